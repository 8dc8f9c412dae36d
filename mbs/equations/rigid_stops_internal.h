/* mbs/equations/rigid_stops_internal.h - rigid stops of joints: impact, rest, departure; internal to mbs/.
 *
 * An impact changes the velocities by an impulse along the gap's gradient g that satisfies all constraints:
 *     v+ = v - (1 + e) (g.v / g.W g) W g,     W: inverse mass on the constraints   (Newton's restitution).
 * Bounces get shorter by the factor e.  One too low to be told from rounding counts as rest: the stop becomes a row of
 * the constraints until it would have to pull.
 *
 * The logic is the same for every set of coordinates; lw_stops says how to do each part in those of the caller. */
#ifndef LW_MBS_EQUATIONS_RIGID_STOPS_INTERNAL_H
#define LW_MBS_EQUATIONS_RIGID_STOPS_INTERNAL_H

#include "grammar/model/model.h"
#include "mbs/constraints/system.h"

#define LW_STOP_CLOSED 1e-9              /* a gap below this is closed, scaled */
#define LW_STOP_LEAST_BOUNCE 1e-13       /* a bounce below this height counts as rest, scaled */

/* gap = sign (measure - limit), scaled; sign is -1 for a greatest value.  resting: a row of the constraints.  measure: as
 * the equations number it, of the joint. */
typedef struct lw_rigid_stop {
    int    joint, measure;
    double sign, limit, restitution;
    bool   resting;
    bool   beyond;                       /* is the start of the run beyond it? */
    bool   touching;                     /* it began to rest without a force: it takes part in impacts as if it were free */
} lw_rigid_stop;

/* rounding: of the acceleration. */
typedef struct lw_gap { double value, rate, acceleration, rounding; } lw_gap;

/* The rigid stops of a model into stop (2*LW_JOINT_MAX), by joint; returns how many. */
int lw_rigid_stops_find(const lw_model *m, const lw_system *s, lw_rigid_stop *stop);

/* Gap at q; its gradient in row (n_q) unless NULL. */
double lw_rigid_stop_gap(const lw_system *s, const lw_rigid_stop *stop, const double *q, double *row);

/* Gap, rate and acceleration at coordinates q, velocities v, accelerations a of the bodies; gradient in row (n_q). */
lw_gap lw_rigid_stop_motion(const lw_system *s, const lw_rigid_stop *stop, const double *q, const double *v, const double *a, double *row);

/* The equations that stops act in.  State y: coordinates, then n velocities. */
typedef struct lw_stops {
    void   *context;
    int     n_stop, n, v;                /* stops; velocities, and where they begin in y */
    double *change, *gradient;           /* (n) scratch */
    lw_rigid_stop  *stop;
    const char *(*name)(void *context, int i);       /* of the joint of stop i */
    double  least_bounce;                /* a bounce below this height counts as rest, scaled */
    bool    passed_is_error;             /* a stop that is passed already: an error, else it is ignored */
    unsigned long long due;              /* bit i: event i has just happened; where stop i rests its force passed 0, and it leaves, whatever rounding says */
    double    (*gap)(void *context, int i, const double *y);
    /* Gap i with its rate and acceleration; its gradient by the velocities in g (n). */
    lw_status (*motion)(void *context, int i, double t, const double *y, double *g, lw_gap *gap);
    /* Change (n) of the velocities by the impulse g; *mobility = g.change.  LW_NOTHING: nothing gives way. */
    lw_status (*impulse)(void *context, double t, const double *y, const double *g, double *change, double *mobility);
    /* Force of resting stop i, >= 0 presses. */
    lw_status (*pressure)(void *context, int i, double t, const double *y, double *press);
    /* stop[i].resting has changed: arrange the constraints, put y on them. */
    lw_status (*arrange)(void *context, int i, double t, double *y);
    /* Stop i is struck at the rate of its gap, or left (impact false).  May be NULL. */
    void      (*note)(void *context, int i, double t, bool impact, double rate);
} lw_stops;

/* Impacts, rests and departures at (t, y), until there are none.  *changed: there were some.  *flight: duration of the
 * shortest bounce that begins [s], 0: none.  LW_E_NUMERIC: a stop is hit by what cannot give way, or impacts do not
 * end; LW_E_ARG: a stop is passed. */
lw_status lw_stops_strike(const lw_stops *stops, double t, double *y, bool *changed, double *flight, lw_error *e);

#endif
