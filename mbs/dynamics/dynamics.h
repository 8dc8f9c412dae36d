/* mbs/dynamics/dynamics.h - how a model moves and what its joints carry: kinetostatics and forward dynamics.
 *
 * An lw_dynamics holds one run: model, equations and memory.  The formulation follows from the analysis and the model,
 * or the caller chooses it (docs/theory.md, "Dynamics").
 *
 * Coordinates q (n_q) and velocities v are those of mbs/constraints/system.h, scaled by system->unit; forces are those
 * of mbs/equations/forces.h.  Multipliers l (n_c) belong to the rows of the system, then of the driven inputs, then of
 * the closed stops; the generalised forces of the constraints are -J^T l. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_H
#define LW_MBS_DYNAMICS_DYNAMICS_H

#include <signal.h>
#include "mbs/elastic/expand.h"
#include "mbs/equations/forces.h"

typedef enum lw_analysis {
    LW_ANALYSIS_TRANSIENT,       /* kinematic when every freedom is driven, else dynamic */
    LW_ANALYSIS_STATIC,          /* equilibrium */
    LW_ANALYSIS_QUASISTATIC,     /* motions prescribed, forces without inertia */
    LW_ANALYSIS_KINEMATIC,       /* motions prescribed, forces with inertia */
    LW_ANALYSIS_DYNAMIC
} lw_analysis;

/* The formulations, in the order in which they are considered: X(constant, name, text for users).
 *
 *     driven      positions by Newton's method; velocities, accelerations and reactions by one factorisation a moment
 *     quadrature  K(s) = K0 + int Q ds, t = int sqrt(M/2K) ds, by Chebyshev points panel by panel
 *     reduced     M(s) s'' + M'(s)/2 s'^2 = Q in the input s of the plan, explicit method of order 8; friction is
 *                 set-valued
 *     alpha       M v' + J^T l = Q with Phi = 0 by the generalised-alpha method of second order with sparse derivatives
 *     radau       the same by Radau IIA of order 5 or 9
 *     capture     impacts and contact forces together in steps of time (Moreau, Jean)
 *     recursive   M(x) u' + J^T l = Q in the coordinates of the joints of a spatial model: accelerations in one pass in and
 *                 one out, J of the loops alone; eight stages at once, or explicit method of order 8
 *     index1      M a + J^T l = Q with J a = c solved in every evaluation, explicit method of order 8, the state put
 *                 back on the constraints after every step
 *     cvode       the same equations by an implicit method
 *     ggl         differential-algebraic, stabilised index 2 (Gear, Gupta & Leimkuhler 1985), by IDA */
#define LW_FORMULATION_LIST(X) \
    X(DRIVEN, driven, "every freedom is driven: kinematics, then forces") \
    X(QUADRATURE, quadrature, "one freedom, forces by the posture alone: time is an integral") \
    X(REDUCED, reduced, "one freedom: one equation in the input; friction sticks") \
    X(ALPHA, alpha, "generalised-alpha method of second order, for lightly damped elastic links at loose tolerances") \
    X(RADAU, radau, "implicit Runge-Kutta method of order 5 or 9, for elastic links and stiff dampers") \
    X(CAPTURE, capture, "many rigid contacts: captured in steps, second order; many impacts at once: first order") \
    X(RECURSIVE, recursive, "models in space: coordinates of the joints, loops cut; explicit method") \
    X(INDEX1, index1, "any model: coordinates of all bodies, explicit method") \
    X(CVODE, cvode, "the same by an implicit method, for smooth friction") \
    X(GGL, ggl, "differential-algebraic equations of index 2, for stiff dampers; no rigid stops")

typedef enum lw_formulation {
    LW_FORMULATION_AUTO,
#define X(id, name, text) LW_FORMULATION_##id,
    LW_FORMULATION_LIST(X)
#undef X
} lw_formulation;

const char *lw_formulation_name(lw_formulation f);     /* "reduced"; "auto" */

typedef struct lw_dynamics_options {
    lw_analysis    analysis;
    lw_formulation formulation;
    double from, to;             /* time [s] */
    int    intervals;            /* number of samples less one; they are evenly spaced */
    double relative, absolute;   /* error of a step, in scaled coordinates */
    long   max_step;             /* 0: no limit */
    double rho;                  /* of alpha: the part of infinitely fast vibrations that a step leaves, 0 to 1; default 0.8 */
    double until;                /* time of lw_clock_wall at which to stop; 0: no limit */
    const volatile sig_atomic_t *stop;     /* the run ends when it is not 0; may be NULL */
    lw_caller_force force;       /* forces of the caller's own; apply NULL: none */
    bool pieces;                 /* the run is continued in pieces: use no formulation that needs the motion after the end, or the posture of the file */
    bool           hold_inputs;  /* keep inputs without a motion where they are */
    bool           rigid;        /* treat elastic links as rigid bars of the same mass */
    bool           compare;      /* lw_dynamics_analyse repeats a run of a planar model with contacts with less accuracy (lw_coarse_run) */
    double         coarse;       /* such a run of captured contacts: its steps are so many times as long; 0: any other run */
    bool           closed;       /* spatial: treat joints with clearance as ideal joints; analyses other than dynamic do so anyway */
} lw_dynamics_options;

/* transient, auto, 0 to 1 s, 100 intervals, 1e-10 */
lw_dynamics_options lw_dynamics_options_default(void);

/* One moment.  The solver owns the arrays; they are valid until the next moment. */
typedef struct lw_moment {
    double t;
    const double *q, *v, *a;     /* (n_q) */
    const double *z;             /* (n_state of the model) first-order states */
    const double *l;             /* (n_c) multipliers; in a singular posture NaN where they have no limit */
    double kinetic, potential;   /* [J] */
    double work;                 /* done since the start by forces without potential [J] */
    double off, off_rate;        /* greatest residual of the constraints, scaled, and of their rates */
    bool   unique;               /* the multipliers are unique; otherwise they are those of least norm */
} lw_moment;

/* Receives a moment.  LW_OK: continue; any other status ends the run. */
typedef lw_status lw_moment_sink(void *context, const lw_moment *m);

#define LW_REPORT_EVENT_MAX 64

/* How far a run with contacts is from the same run with less accuracy.  Each impact amplifies errors, and captured contacts leave an error that
 * the energy does not show; the difference of two runs shows both. */
typedef struct lw_coarse_run {
    double tolerance;            /* of the coarse run; 0: there was none */
    bool   ended;                /* it ended early, at ended_t [s]: the differences are those until then */
    double ended_t;
    double apart;                /* greatest difference of a centre of mass or of a point that can touch, over the size of the linkage */
    double place, place_t;       /* greatest difference of a centre of mass [m], and when [s] */
    double turn, turn_t;         /* of the angle of a link [rad], and when [s] */
    int    placed, turned;       /* these links */
    bool   large;                /* contacts were captured, or it is more than 100 times what its tolerance allows in a step */
} lw_coarse_run;

/* A rigid stop struck (impact) or left: joint, which end, rate of the gap [rad/s] or [m/s].  name: of the joint, or
 * where touch is set of a contact or rope; the model owns it. */
typedef struct lw_run_event { double t; int joint; bool greatest, impact; double speed; const char *name; bool touch; } lw_run_event;

typedef struct lw_dynamics_report {
    lw_formulation formulation;
    char   why[256];             /* reason for this formulation */
    lw_formulation gave_up;      /* the formulation asked for, or chosen, which gave up at gave_up_t [s]; `why` gives the reason, and
                                  * `formulation` went on; AUTO: none */
    double gave_up_t;
    int    unknowns;             /* of the differential or algebraic system solved */
    int    freedom;              /* degree of freedom, driven inputs included */
    int    redundant;            /* rows that depend on others */
    double moved;                /* change of the start by its projection onto the constraints, scaled */
    double adjusted;             /* greatest change of a dimension that makes an overconstrained linkage move [m], 0: none */
    double adjusted_turn;        /* in space: of the direction of an axis [rad] */
    long   steps, refused, rates;          /* rates: evaluations of the equations */
    double worst_off, worst_off_rate;      /* greatest residuals over all samples */
    double energy_error;         /* greatest |E - E(start) - work| [J] */
    double energy_steps;         /* that error over the error allowed a step, where it is more than 1000 times as great; 0: less, or not known */
    double added;                /* sum of the errors of the steps of alpha, scaled, where it is more than 100 times that allowed in one; else 0 */
    double energy_held;          /* sum of the corrections of the energy after steps, where it is kept [J] */
    double period;               /* of a motion that repeats itself: measured, used for the rest of the run [s]; 0 */
    double period_off;           /* uncertainty of the phase at the last sample, in periods; 0 without a period */
    double energy_scale;         /* greatest kinetic energy or change of potential [J] */
    double momentum_error, momentum_scale;   /* about the only joint to ground; scale 0: not conserved */
    int    n_event, n_event_seen;            /* events kept, and all */
    lw_run_event event[LW_REPORT_EVENT_MAX];
    const char *undetermined;    /* a contact that shares a load with one that slips in several ways, each with another motion; NULL: none */
    double undetermined_t;       /* the first time [s] */
    const char *jammed;          /* a contact whose friction holds in some of the ways to share a load only, as where a body is wedged: */
    double jammed_t;             /* it slips at this time, or sticks to this end of the run, but rigid bodies do not determine when [s]; NULL: none */
    double captured_step, captured_late, overlap;        /* of the capture formulation: longest step, longest one with an impact that was not located, or time
                                              * between strikes that were taken as one [s]; greatest overlap [m] */
    double captured_rest;                    /* speed of the fastest bounce that counts as rest [m/s] */
    lw_coarse_run coarse;
    bool   smooth_friction;      /* friction without a "speed" was regularised, and creeps instead of sticking */
    bool   no_friction;          /* friction of joints was left out, as in every equilibrium */
    double t;                    /* time reached */
    long   samples;              /* passed to the sink; intervals + 1 if the run succeeds */
    long   without_forces;       /* samples in singular postures in which some force has no limit, */
    double without_forces_t;     /* and the time of the first */
    bool   jams;                 /* in some of them because friction of rigid links leaves no forces, or several, though all motion is prescribed */
    bool   lost;                 /* the inputs move every freedom: between these times, the first time, the drives lose control of the links */
    double lost_t[2];            /* (mbs/space/space_hold.h, mbs/constraints/prescribed_motion.h) */
    char   lost_how[240];        /* "link ... turns about ...": what moves there while they stand still; empty: not known */
} lw_dynamics_report;

typedef struct lw_dynamics lw_dynamics;

/* mbs/formulations/formulations.h makes it. */
void lw_dynamics_free(lw_dynamics *d);

/* The formulation chosen: formulation, why, unknowns; the rest of the report is empty. */
const lw_dynamics_report *lw_dynamics_choice(const lw_dynamics *d);

/* The model that is solved: that of _make, or the one with its elastic links as chains of elements, whose links are the
 * nodes.  The chains; NULL: no link is elastic. */
const lw_model     *lw_dynamics_model(const lw_dynamics *d);
const lw_elastic_expansion *lw_dynamics_elastic(const lw_dynamics *d);

const lw_system *lw_dynamics_system(const lw_dynamics *d);
const lw_forces *lw_dynamics_forces(const lw_dynamics *d);

/* Posture and velocities of the start (n_q), on the constraints. */
void lw_dynamics_start(const lw_dynamics *d, double *q, double *v);

/* Values of the first-order states at the start (n_state of the model). */
const double *lw_dynamics_start_states(const lw_dynamics *d);

/* Inputs of the model, and their names. */
int         lw_dynamics_inputs(const lw_dynamics *d);
const char *lw_dynamics_input_name(const lw_dynamics *d, int i);

/* Number of idle spins of links between ball joints, which are held; are there more drives than freedoms, so that their forces
 * are those of least norm? */
int  lw_dynamics_idle(const lw_dynamics *d);
bool lw_dynamics_many_drives(const lw_dynamics *d);

/* Does the run include inertia (not static, not quasi-static)? */
bool lw_dynamics_in_time(const lw_dynamics *d);

/* A link that can move without moving any mass, for which a static analysis assumed values; NULL: there is none. */
const char *lw_dynamics_massless(const lw_dynamics *d);

/* Does input i start at rest because neither its speed nor its motion is given? */
bool lw_dynamics_starts_at_rest(const lw_dynamics *d, int i);

/* Names of joints whose reactions are not unique, " A B"; "" when all are.  Returns whether friction acts in one of them, which depends on its reaction. */
bool lw_dynamics_redundant(const lw_dynamics *d, char *text, size_t size);

#endif
