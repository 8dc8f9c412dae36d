/* mbs/dynamics/dynamics_run_internal.h - one run under way, and the formulations it can take; internal to mbs/. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_RUN_INTERNAL_H
#define LW_MBS_DYNAMICS_DYNAMICS_RUN_INTERNAL_H

#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/equations/timed.h"
#include "mbs/ode/integrate.h"

#define LW_RUN_JUMPS 64

/* The state y of a run: q (n_q), v (n_v), where some is done the work of what the potential does not hold, and the
 * first-order states z (n_z). */
typedef struct lw_run {
    lw_dynamics    *d;
    lw_moment_sink *sink;
    void           *context;
    lw_dynamics_report *r;
    lw_error       *e;
    int     n;                       /* numbers in y */
    bool    has_work;
    long    n_busy;                  /* evaluations */
    int     next;                    /* the next sample */
    long    shown;                   /* samples that an earlier formulation handed out, which are left out, */
    double *last_shown;              /* and the posture (n_q) of the last of them; NULL: none will follow */
    bool    refused;                 /* the sink ended the run, or no other formulation could go on */
    lw_timed timed;                  /* where steps must end because of functions of time */
    double  flight;                  /* duration of a bounce that has just begun [s]; 0: none */
    double  energy0, potential0, momentum0;
    double  work_done, work_last;    /* sum of |changes of the work| over steps, and the work after the last one [J] */
    bool    pushed;                  /* a drive has changed its speed at once: the next comparison begins anew */
    long    n_noted;                 /* how often the energy was compared; 0: it is not */
    bool    keeps_momenta;               /* steps keep those of parts that fly (lw_run_hold) */
    double  pivot, pivot_t;          /* root of the least pivot after the last step, and its time */
    double  pivot_tried;             /* root of the least pivot where a crossing was tried last; 1: nowhere */
    double  ahead;                   /* time to the singular posture foretold [s]; 0: none */
    double  apart;                   /* residual of the rows on a curve tried there; 0: none tried */
    double  jam;                     /* time of the singular posture before which friction jams; 0: none */
    double *behind, fell;            /* with friction: (2 x n) states after the last two steps, and their times; last fall of the pivot */
    double  chosen;                  /* greatest of the least pivots since the kept rows were chosen */
    double *sides;                   /* memory of lw_run_jumps; NULL: nothing jumps */
    double  most_force, jumps_t, jumped[LW_RUN_JUMPS];       /* greatest force so far; time looked at last; times of the last jumps */
    long    n_jumped;
    int     n_near, n_steady;        /* short steps in a row beside a jump, and how often before as many stayed so near; */
    double  near[2];                 /* and the greatest distances from it */
    double *y, *state;               /* (n) scratch; state: ggl only */
} lw_run;

/* ---- dynamics_rate.c: the right-hand side --------------------------------------------------------- */

/* y' for explicit and implicit methods; y put back on the constraints. */
lw_status lw_run_rate(void *context, double t, const double *y, double *dy);
lw_status lw_run_project(void *context, double t, double *y);

/* LW_STOPPED when a limit or the caller ends the run: after a step, with `steps` more than the report has; and in
 * every right-hand side, because one step may be tried for long. */
lw_status lw_run_limits(lw_run *run, double t, long steps);
lw_status lw_run_busy(lw_run *run, double t);

/* First-order states in y; absolute tolerances of y (n), NULL where all are one (or out of memory, *s), to be freed. */
static inline int lw_run_states(const lw_run *run) { return run->d->n_q + run->d->n_v + run->has_work; }
double *lw_run_tolerances(const lw_run *run, lw_status *s);

/* Steps left of those allowed; 0: no limit. */
long lw_run_steps_left(const lw_run *run);

/* ---- dynamics_run.c: what every run does ----------------------------------------------------------- */

/* Time of sample k. */
double lw_run_time(const lw_dynamics *d, int k);

/* Numbers of the start, and the first sample; with the accelerations and multipliers of the caller. */
lw_status lw_run_begin(lw_run *run, const double *y);
lw_status lw_run_begin_solved(lw_run *run, const double *y);

/* Hand the moment at (t, y) to the sink and keep the greatest residuals.  In a singular posture accelerations and
 * multipliers are NaN. */
lw_status lw_run_show(lw_run *run, double t, const double *y);

/* The same with the accelerations d->a and multipliers d->l of the caller, NaN where they do not exist. */
lw_status lw_run_show_solved(lw_run *run, double t, const double *y);

/* Hand out the samples that are due up to time t; state_at fills y (n) at the time of each. */
typedef lw_status lw_run_state_at(void *context, double t, double *y);
lw_status lw_run_samples(lw_run *run, double t, lw_run_state_at *state_at, void *context);

/* Where the next step from t must end; near: if the method evaluates the loads at the ends of steps only.  A solver stops with LW_ODE_END
 * at each of these; lw_run_stop keeps that for the end of the run. */
static inline double lw_run_end(lw_run *run, double t) { return lw_timed_end(&run->timed, t); }
static inline double lw_run_near(lw_run *run, double t) { return lw_timed_near(&run->timed, t); }
static inline lw_ode_stop lw_run_stop(const lw_run *run, double t, lw_ode_stop stop)
{
    return t >= run->d->o.to ? LW_ODE_END : stop == LW_ODE_END ? LW_ODE_STEP : stop;
}

/* Just before a kink, where the solver must begin anew: hand out the samples up to it (state_at NULL: none) and set *t to just
 * behind it. */
static inline bool lw_run_at_kink(const lw_run *run, double t) { return lw_timed_at_kink(&run->timed, t); }
lw_status lw_run_pass_kink(lw_run *run, double *t, lw_run_state_at *state_at, void *context);

/* Compare energy and momentum at y with those of the start. */
void lw_run_watch(lw_run *run, const double *y);

/* The energy alone, by the change of the potential since the start, and the kinetic energy of the start [J]. */
void lw_run_note_energy(lw_run *run, double kinetic, double change, double work, double kinetic0);

/* After a step to (t, y).  LW_E_NUMERIC: forces with sign() or mod() jump to and fro all the time, as where the motion would have to
 * slide along the jump. */
lw_status lw_run_jumps(lw_run *run, double t, const double *y);
lw_status lw_run_slides(lw_run *run, double t);          /* that error */

/* Kinetic and potential energy at y less the work done since the start [J], which is constant. */
double lw_run_energy(const lw_run *run, const double *y);

/* The greatest change of it in a step to y that counts as an error of the step, so many times what the tolerance allows [J].  The
 * posture of y is placed, d->force are the forces there.  scratch (n_v). */
double lw_run_energy_error(const lw_run *run, double times, const double *y, double *scratch);

/* The part of v less rigid to take away after an explicit step to (q, v) for a conservative model to keep its energy, which
 * constraints at rest allow; 0 where the correction is greater than the error allowed in a step.  rigid (n_v): a part of v that
 * stays, orthogonal to the rest in the metric of the masses; NULL: none. */
double lw_run_held(lw_run *run, const double *q, const double *v, const double *rigid);

/* Take it away, and put q and v on the momenta of parts that fly first. */
void lw_run_hold(lw_run *run, double t, double *q, double *v);

/* Fills r->unknowns and r->why; returns the status. */
lw_status lw_formulation_say(lw_dynamics_report *r, lw_status status, int unknowns, const char *why);

/* ---- dynamics_stops.c: rigid stops ------------------------------------------------------------------ */

/* Event functions (n_stop): the gap of each stop, the pressure of one that is rested on; behind them the distance to the end of
 * the forces' smooth piece, where they have pieces. */
lw_status lw_run_stop_events(void *context, double t, const double *y, double *g);

/* Is y beyond a rigid stop, but for those that the start of the run is beyond?  begin: y is that start. */
bool lw_run_stop_passed(const lw_run *run, const double *y, bool begin);

/* Apply the impacts, rests and departures at t, where events happened; *changed is set if y or the rows changed. */
lw_status lw_run_strike(lw_run *run, double t, double *y, unsigned long long events, bool *changed);

/* ---- dynamics_stick.c: friction of joints in space that stick ----------------------------------------- */

/* Can all friction of d be set-valued: of revolute and prismatic joints in space, without rigid stops? */
bool lw_stick_suits(const lw_dynamics *d);

/* At the start of a run; then, and at each event, at (t, y): which joints stick, and where to the others slip.  events: bits of
 * the event functions (n_friction) that crossed 0. */
void      lw_run_stick_begin(lw_run *run);
lw_status lw_run_stick(lw_run *run, double t, double *y, unsigned long long events);
lw_status lw_run_stick_events(void *context, double t, const double *y, double *g);

/* ---- dynamics_touch.c: contact, ropes, and the rigid stops of models that have them ------------------- */

/* Event functions (LW_TOUCH_EVENTS); all are positive between events. */
#define LW_TOUCH_EVENTS 7
lw_status lw_run_touch_events(void *context, double t, const double *y, double *g);

/* Impacts at (t, y), then the states of all places.  events: bits of the event functions that crossed 0. */
lw_status lw_run_touch(lw_run *run, double t, double *y, unsigned long long events);
/* A run has ended at t: give the reason if friction makes the force of a contact grow without limit there. */
void      lw_run_touch_jams(lw_run *run, double t);

/* At the start: on which sides bars are touched.  LW_E_ARG: nothing tells it.  The coordinates are those placed last. */
lw_status lw_run_touch_choose_sides(lw_run *run);

/* LW_E_ARG: shapes overlap at t.  The coordinates are those placed last. */
lw_status lw_run_touch_check(lw_run *run, double t);

/* After a step to (t, y); LW_E_NUMERIC: a closure was missed.  And the longest step from there that misses none. */
lw_status lw_run_touch_accept(lw_run *run, double t, const double *y);
double    lw_run_touch_step(lw_run *run, const double *y);

/* ---- dynamics_passage.c: forces in singular postures -------------------------------------------------- */

/* Accelerations d->a and multipliers d->l at (t, y) near a singular posture, where the rows have lost their digits, from
 * the motion through it; rows and factors are those at y.  NaN where they have no limit or cannot be found. */
#define LW_SINGULAR_NEAR 0.02            /* distance from a singular posture below which to ask, about radians */
lw_status lw_run_singular_forces(lw_run *run, double t, const double *y);

/* ---- dynamics_singular.c: through singular postures -------------------------------------------------- */

/* Where rows are redundant, those kept may become dependent in a posture that is not singular: choose others.  *weak:
 * the least pivot, before and after.  LW_OK: other rows are kept now; LW_NOTHING: the same. */
lw_status lw_run_rechoose(lw_run *run, double t, const double *y, double *weak);

/* After a step to (*t, y), where the least pivot is `weak`: go through the singular posture ahead, if there is one, to
 * behind it, and hand out the samples on the way.  before: the state before the step, NULL: not known.  LW_NOTHING:
 * there is none, or none that this can pass. */
lw_status lw_run_singular_crossing(lw_run *run, double weak, const double *before, double *t, double *y);

/* From y at time `good`, with the least pivot `weak`, over the singular posture that is met at about `place`, by one
 * step from LW_SINGULAR_STEP_HALF before it to as far behind (in multiples of the distance at which a pivot is 1, about
 * radians).  y and *t are behind it; samples on the way are handed out.  LW_OPEN: the energy has changed. */
#define LW_SINGULAR_STEP_HALF 0.1
lw_status lw_run_singular_step(lw_run *run, double good, double weak, double place, double *t, double *y);

/* ---- dynamics_bodies.c ------------------------------------------------------------------------------- */

/* Go on from (run->r->t, y) in the bodies' coordinates. */
lw_status lw_run_go_on(lw_run *run, const double *y);

/* ---- dynamics_space.c -------------------------------------------------------------------------------- */

/* A run of a spatial model whose inputs leave no freedom. */
lw_status lw_run_driven_spatial(lw_run *run);
/* Driven runs look at rigid stops so many times from sample to sample: motions can go beyond one and back between two. */
int       lw_run_looks(const lw_dynamics *d);
/* LW_E_KIND: the posture q (n_q) at t is beyond a rigid stop. */
lw_status lw_run_look_at_stops(lw_run *run, double t, const double *q);

/* "", or a note that a spatial model could be written as a planar one. */
const char *lw_mbs_is_planar(const lw_dynamics *d);

/* ---- formulations ------------------------------------------------------------------------------------ */

/* One formulation.  A new one is a file that defines its row, and a line in LW_FORMULATION_LIST
 * (mbs/dynamics/dynamics.h).
 *
 * able: can it do the model of d, and (asked false) is it the one to take by itself, before those after it in the
 * list?  LW_OK: yes, r->why says why, r->unknowns how many unknowns it has; other status: no, r->why says why not. */
typedef struct lw_formulation_row {
    lw_status (*able)(lw_dynamics *d, bool asked, lw_dynamics_report *r);
    lw_status (*run)(lw_run *run);
} lw_formulation_row;

#define X(id, name, text) extern const lw_formulation_row lw_formulation_##name;
LW_FORMULATION_LIST(X)
#undef X

#endif
