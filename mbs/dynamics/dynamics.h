/* mbs/dynamics/dynamics.h - how a model moves and what it carries: statics, kinetostatics, forward dynamics.
 *
 * One lw_dynamics is one run's model, equations and memory.  What is solved depends on what is asked and on
 * what the scene needs (docs/theory.md, "Dynamics"):
 *
 *     driven    as many motions prescribed as there are freedoms: positions by Newton's method, velocities,
 *               accelerations and all reactions by one factorisation a moment
 *     quadrature  one freedom, rigid, forces that the posture alone decides: K(s) = K0 + int Q ds,
 *               t = int sqrt(M/2K) ds, by Chebyshev points panel by panel
 *     reduced   one freedom, rigid, no friction: M(s) s'' + M'(s)/2 s'^2 = Q in the input of the plan
 *               (mbs/dynamics/reduced.h), explicit order 8
 *     index1    bodies' coordinates; M a + J^T l = Q with J a = c solved for every evaluation, explicit order
 *               8, put back on the constraints after every step
 *     cvode     the same equations by an implicit method, for stiff ones
 *     ggl       differential-algebraic, stabilised index 2 (Gear, Gupta & Leimkuhler 1985), by IDA
 *
 * Coordinates q (n_q), velocities v: those of mbs/constraints/system.h, scaled by system->unit; forces as in
 * mbs/dynamics/forces.h.  Multipliers l (n_c): of the rows of the system, then of the driven inputs, then of stops
 * that are touched; the constraints push with -J^T l. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_H
#define LW_MBS_DYNAMICS_DYNAMICS_H

#include <signal.h>
#include "mbs/dynamics/forces.h"

typedef enum lw_analysis {
    LW_ANALYSIS_TRANSIENT,       /* kinematic when every freedom is driven, else dynamic              */
    LW_ANALYSIS_STATIC,          /* where it rests                                                    */
    LW_ANALYSIS_QUASISTATIC,     /* motions prescribed, forces without inertia                        */
    LW_ANALYSIS_KINEMATIC,       /* motions prescribed, forces with inertia                           */
    LW_ANALYSIS_DYNAMIC
} lw_analysis;

typedef enum lw_formulation {
    LW_FORMULATION_AUTO, LW_FORMULATION_DRIVEN, LW_FORMULATION_QUADRATURE, LW_FORMULATION_REDUCED,
    LW_FORMULATION_INDEX1, LW_FORMULATION_CVODE, LW_FORMULATION_GGL
} lw_formulation;

const char *lw_formulation_name(lw_formulation f);     /* "reduced" */

typedef struct lw_dynamics_options {
    lw_analysis    analysis;
    lw_formulation formulation;
    double from, to;             /* time [s]                                                       */
    int    intervals;            /* samples less one, evenly spaced                                  */
    double relative, absolute;   /* of a step, in scaled coordinates                                  */
    long   max_step;             /* 0: no limit                                                      */
    double until;                /* of lw_clock_wall; 0: no limit                                     */
    const volatile sig_atomic_t *stop;     /* not 0: end here; may be NULL                            */
    lw_caller_force force;       /* forces of the caller's own; apply NULL: none                      */
} lw_dynamics_options;

/* transient, auto, 0 to 1 s, 100 intervals, 1e-10 */
lw_dynamics_options lw_dynamics_options_default(void);

/* One moment.  Arrays are the solver's and hold until the next. */
typedef struct lw_moment {
    double t;
    const double *q, *v, *a;     /* (n_q)                                                           */
    const double *l;             /* (n_c) multipliers                                               */
    double kinetic, potential;   /* [J]                                                             */
    double work;                 /* done since the start by what the potential does not hold [J]     */
    double off, off_rate;        /* greatest residual of the constraints, scaled, and of their rates  */
    bool   unique;               /* the multipliers are the only ones; else those of least norm       */
} lw_moment;

/* LW_OK goes on; else the run ends with that status. */
typedef lw_status lw_moment_sink(void *context, const lw_moment *m);

#define LW_REPORT_EVENT_MAX 64

/* Something that happened, and when. */
typedef struct lw_run_event { double t; int joint; bool greatest, impact; double speed; } lw_run_event;

typedef struct lw_dynamics_report {
    lw_formulation formulation;
    char   why[256];             /* why this one                                                    */
    int    unknowns;             /* of the differential or algebraic system solved                   */
    int    freedom;              /* of motion, driven ones included                                  */
    int    redundant;            /* rows that say nothing new                                       */
    double moved, moved_rate;    /* the start was put on the constraints by so much, scaled           */
    long   steps, refused, rates;
    double worst_off, worst_off_rate;
    double energy_error;         /* greatest |E - E(start) - work| [J]                               */
    double energy_held;          /* sum of what was taken off |E - E(start)| after steps, where it is kept [J] */
    double period;               /* of what repeats itself: measured, and used for the rest of the run [s]; 0 */
    double energy_scale;         /* greatest kinetic energy or change of potential [J]               */
    double momentum_error, momentum_scale;   /* about the only joint to ground; scale 0: not conserved */
    int    n_happening, n_seen;  /* kept, and all                                                   */
    lw_run_event happening[LW_REPORT_EVENT_MAX];
    double t;                    /* how far it came                                                 */
} lw_dynamics_report;

typedef struct lw_dynamics lw_dynamics;

/* The model must outlive d.  Puts the start on the constraints, moves driven inputs to where they start, finds
 * redundant rows.  LW_E_ARG: a mass missing where dynamics needs one (the link is named), motions that ask
 * for more than the freedoms; LW_E_KIND: the formulation cannot do this model; LW_OPEN, LW_E_NUMERIC: no
 * posture or velocity that satisfies the constraints. */
lw_status lw_dynamics_make(const lw_model *m, const lw_dynamics_options *o, lw_dynamics **d, lw_error *e);
void      lw_dynamics_free(lw_dynamics *d);

/* Run; what was sampled before a failure stays valid, and the report says how far it came. */
lw_status lw_dynamics_run(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_error *e);

/* What was chosen: formulation, why, unknowns; the rest of the report is empty. */
const lw_dynamics_report *lw_dynamics_choice(const lw_dynamics *d);

const lw_system *lw_dynamics_system(const lw_dynamics *d);
const lw_forces *lw_dynamics_forces(const lw_dynamics *d);

/* Rows of one joint at q: phi (1 to 3), jac (as many times n_q). */
void lw_dynamics_joint_rows(const lw_dynamics *d, int joint, const double *q, double *phi, double *jac);

/* The posture and velocities of the start (n_q), on the constraints. */
void lw_dynamics_start(const lw_dynamics *d, double *q, double *v);

/* Names of joints whose reactions are not unique, " A B"; "" when all are. */
void lw_dynamics_redundant(const lw_dynamics *d, char *text, size_t size);

#endif
