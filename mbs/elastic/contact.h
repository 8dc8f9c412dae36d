/* mbs/elastic/contact.h - laws of contact between pin and bush of a revolute joint with clearance.
 *
 * The centre of the pin is at the distance r from that of the bush; depth = r - gap, rate = dr/dt.  The force F(depth,
 * rate) pulls the pin back to the middle:
 *
 *     mlsd                  K depth + c rate, always (Seneviratne, Earles & Fenner 1996; Makkonen 1999, eq. 25)
 *     impact                K depth^e + S c rate while depth > 0, S = min(depth/d, 1)^3.  Makkonen 1999, paper C,
 *                           eqs. 2-3; the source prints the damping without rate, the thesis (eq. 28) with the
 *                           wrong sign
 *     hunt-crossley         K depth^e (1 + 3/2 (1 - s) rate/v)      Hunt & Crossley 1975
 *     lankarani-nikravesh   K depth^e (1 + 3/4 (1 - s^2) rate/v)    Lankarani & Nikravesh 1990
 *                           s restitution, v the rate at which contact began
 *
 * Each law has a few smooth pieces (phases); the change from one to the next is an event, not a kink inside a step.
 * The source does not cut off pulling forces (the damping of a pin that leaves fast), and neither do we for
 * `impact`. */
#ifndef LW_MBS_ELASTIC_CONTACT_H
#define LW_MBS_ELASTIC_CONTACT_H

#include "grammar/model/model.h"

typedef enum lw_contact_phase {
    LW_CONTACT_APART,                    /* no force */
    LW_CONTACT_RISING,                   /* impact: 0 < depth < d, the damping grows */
    LW_CONTACT_FULL                      /* deeper; and every contact of the other laws */
} lw_contact_phase;

/* Least v [m/s] in the laws that have it: they have no limit for v = 0. */
#define LW_CONTACT_SLOWEST 1e-3

/* Does the law have the phase LW_CONTACT_RISING (a damping and a depth)? */
bool lw_contact_rises(const lw_clearance *c);

/* The phase at a depth [m]. */
lw_contact_phase lw_contact_phase_at(const lw_clearance *c, double depth);

/* F [N] in a phase; also beyond its ends, where it continues smoothly.  struck: v above [m/s]. */
double lw_contact_force(const lw_clearance *c, lw_contact_phase phase, double depth, double rate, double struck);

/* The same with its derivatives by depth [N/m] and rate [N s/m]. */
double lw_contact_gradient(const lw_clearance *c, lw_contact_phase phase, double depth, double rate, double struck,
                           double *by_depth, double *by_rate);

/* How far the depth lies within a phase: from the nearer end [m], < 0 beyond it.  The phase beyond that end. */
double           lw_contact_within(const lw_clearance *c, lw_contact_phase phase, double depth);
lw_contact_phase lw_contact_next(const lw_clearance *c, lw_contact_phase phase, double depth);

/* The part of the force that is the spring's, in contact [N], and its energy [J]. */
double lw_contact_spring(const lw_clearance *c, double depth);
double lw_contact_energy(const lw_clearance *c, lw_contact_phase phase, double depth);

/* Depth at which the law without damping gives the force f [N]. */
double lw_contact_depth(const lw_clearance *c, double f);

/* Coulomb friction for a normal force: coefficient tanh(slip/friction_speed) |force| [N], against the slip. */
double lw_contact_friction(const lw_clearance *c, double force, double slip);

/* "impact" ... as in the file; "" for LW_CLEARANCE_NONE.  The reverse: LW_CLEARANCE_NONE for an unknown name. */
const char        *lw_clearance_name(lw_clearance_model m);
lw_clearance_model lw_clearance_named(const char *name);

#endif
