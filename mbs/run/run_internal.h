/* mbs/run/run_internal.h - the state of a run, and what every run does; internal to mbs/. */
#ifndef LW_MBS_RUN_RUN_INTERNAL_H
#define LW_MBS_RUN_RUN_INTERNAL_H

#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/equations/kinks.h"
#include "mbs/equations/timed.h"
#include "mbs/ode/integrate.h"

#define LW_RUN_JUMPS 64

/* The state y of a run: q (n_q), v (n_v), the work of the forces without potential if there are any (has_work), and
 * the first-order states z (n_z). */
typedef struct lw_run {
    lw_dynamics    *d;
    lw_moment_sink *sink;
    void           *context;
    lw_dynamics_report *r;
    lw_error       *e;
    /* Goes on from (r->t, y), where the equations became stiff, by an implicit method, and reports it; length: mean of the latest explicit steps. */
    lw_status     (*leave_stiff)(struct lw_run *run, double *y, double length);
    bool    returns;                 /* after that the run may go back to the explicit method, */
    int     n_back;                  /* and did so many times */
    int     n;                       /* numbers in y */
    bool    has_work;
    long    n_busy;                  /* evaluations */
    int     next;                    /* the next sample */
    long    shown;                   /* number of samples that an earlier formulation has passed on; they are not repeated; */
    double *last_shown;              /* posture (n_q) of the last of them; NULL: no other formulation will follow */
    bool    refused;                 /* the sink ended the run, or no other formulation could go on */
    lw_timed timed;                  /* times at which steps must end because of functions of time */
    double  flight;                  /* duration of a bounce that has just begun [s]; 0: none */
    double  energy0, potential0, momentum0;
    double  work_done, work_last;    /* sum of |changes of the work| over steps, and the work after the last one [J] */
    bool    pushed;                  /* the speed of a drive has jumped: the next comparison of energies gives the work of its impulse */
    double  impulse_work;            /* of such impulses so far, which is not in y [J] */
    long    n_noted;                 /* number of comparisons of the energy; 0: it is not compared */
    bool    keeps_momenta;               /* steps keep the momenta of bodies in free flight (lw_run_hold) */
    double  pivot, pivot_t;          /* root of the least pivot after the last step, and its time */
    double  pivot_tried;             /* root of the least pivot where a crossing was tried last; 1: none was tried */
    double  ahead;                   /* predicted time until the next singular posture [s]; 0: none */
    double  clear;                   /* least pivot at which lw_run_go_on ends; 0: it goes on to the end of the run */
    double  apart;                   /* residual of the rows on a curve tried there; 0: none tried */
    double  jam;                     /* time of the singular posture before which friction jams; 0: none */
    double *behind, fell;            /* with friction: states (2 x n) after the last two steps with their times; last decrease of the pivot */
    double  chosen;                  /* greatest value of the least pivot since the basis of the rows was chosen */
    double *sides;                   /* memory of lw_run_jumps; NULL: nothing jumps */
    struct lw_pulses *pulses;        /* of lw_run_pulses; NULL: no function of a joint or another measure can have a pulse */
    lw_kinks *kinks;                 /* NULL: forces have no kinks or jumps that depend on the motion */
    double  pulse_t[2];              /* when the next step must end because of them; _near */
    double  most_force, jumps_t, jumped[LW_RUN_JUMPS];       /* greatest force so far; time of the last check; times of the last jumps */
    long    n_jumped;
    int     n_near, n_steady;        /* successive short steps beside a jump; how many series of such steps stayed as near; */
    double  near[2];                 /* greatest distances from the jump in these series */
    /* Accelerations d->a and multipliers d->l of a sample at (t, q, v), whose rows are formed.  LW_OPEN: they are found from all rows, as
     * they are where this is NULL. */
    lw_status (*solve_sample)(void *solver, double t, const double *q, const double *v);
    /* The sample at t, t_end is the end of the step.  LW_OPEN: it is found from its state. */
    lw_status (*whole_sample)(void *solver, double t, double t_end, lw_moment *m);
    void   *solver;
    double *y, *state;               /* (n) scratch; state: ggl only */
} lw_run;

/* ---- rate.c: the right-hand side --------------------------------------------------------- */

/* y' for explicit and implicit methods; projection of y onto the constraints.  _correct: projection of a state within a step.  Beside a
 * singular posture a projection magnifies its error without limit: the state stays as it is where that would move it by more than it can be off. */
lw_status lw_run_rate(void *context, double t, const double *y, double *dy);
lw_status lw_run_project(void *context, double t, double *y);
lw_status lw_run_correct(lw_run *run, double t, double *y);

/* LW_STOPPED if a limit or the caller ends the run.  _limits: after a step; `steps` are those not yet in the report.
 * _busy: in every evaluation of the right-hand side, because one step can take many of them. */
lw_status lw_run_limits(lw_run *run, double t, long steps);
lw_status lw_run_busy(lw_run *run, double t);

/* The status for the integrator of rates at t that failed with s: LW_OPEN, which asks for a shorter step, where that step may end before the
 * failure; else s.  With LW_OPEN the reason stays in run->e, whose status is LW_OPEN, too. */
lw_status lw_run_failed_rates(lw_run *run, double t, lw_status s);

/* Index in y of the first-order states; tolerances of y (n) for the absolute one of lengths and angles, to be freed.  NULL: they are all equal, or *s
 * is LW_E_MEMORY. */
static inline int lw_run_states(const lw_run *run) { return run->d->n_q + run->d->n_v + run->has_work; }
double *lw_run_tolerances(const lw_run *run, double absolute, lw_status *s);

/* The tolerance of a step of BDF methods for the one asked for.  The errors of their many steps of low order add up: the number of steps doubles
 * with two digits, and so does the sum over the tolerance.  A part that falls with its 1/4 power keeps it level from 1e-6 to 1e-10 (random linkages
 * of one and two freedoms).  Then it stays at 5e-13, where rounding of forces with great rates begins to count in the squeezer of Andrews and with
 * pressures, until it is a twentieth of the tolerance again; below 2e-14 Newton's method does not converge. */
static inline double lw_run_bdf_tolerance(double tolerance)
{
    double part = 0.05*tolerance, step = fmax(part*pow(fmin(1, tolerance/1e-6), 0.25), fmin(part, 5e-13));
    return fmin(tolerance, fmax(step, 2e-14));
}

/* Steps left of those allowed; 0: no limit. */
long lw_run_steps_left(const lw_run *run);

/* ---- run.c: what every run does ----------------------------------------------------------- */

/* Time of sample k. */
double lw_run_time(const lw_dynamics *d, int k);

/* Store the energies of the start and pass on the first sample; _solved: with the accelerations d->a and multipliers
 * d->l of the caller. */
lw_status lw_run_begin(lw_run *run, const double *y);
lw_status lw_run_begin_solved(lw_run *run, const double *y);

/* Pass the sample at (t, y) to the sink and store the greatest residuals.  In a singular posture accelerations and
 * multipliers are NaN. */
lw_status lw_run_show(lw_run *run, double t, const double *y);

/* The same with the accelerations d->a and multipliers d->l of the caller, NaN where they do not exist. */
lw_status lw_run_show_solved(lw_run *run, double t, const double *y);

/* Pass on the samples that are due up to time t; state_at fills y (n) at the time of each. */
typedef lw_status lw_run_state_at(void *context, double t, double *y);
lw_status lw_run_samples(lw_run *run, double t, lw_run_state_at *state_at, void *context);

/* Time at which the next step from t must end; _near: for methods that evaluate loads only at the ends of steps.  A solver
 * returns LW_ODE_END at each of these times; lw_run_stop changes that into LW_ODE_STEP before the end of the run. */
static inline double lw_run_before(double end, double t, double pulse) { return pulse > t && pulse < end ? pulse : end; }
static inline double lw_run_end(lw_run *run, double t) { return lw_run_before(lw_timed_end(&run->timed, t), t, run->pulse_t[0]); }
static inline double lw_run_near(lw_run *run, double t) { return lw_run_before(lw_timed_near(&run->timed, t), t, run->pulse_t[1]); }
static inline lw_ode_stop lw_run_stop(const lw_run *run, double t, lw_ode_stop stop)
{
    return t >= run->d->o.to ? LW_ODE_END : stop == LW_ODE_END ? LW_ODE_STEP : stop;
}

/* Just before a kink, at which the solver must be restarted: pass on the samples up to it (state_at NULL: none) and set *t
 * to just after it. */
static inline bool lw_run_at_kink(const lw_run *run, double t) { return lw_timed_at_kink(&run->timed, t); }
lw_status lw_run_pass_kink(lw_run *run, double *t, lw_run_state_at *state_at, void *context);

/* Compare energy and momentum at y with those of the start. */
void lw_run_watch(lw_run *run, const double *y);

/* The same for the energy alone, from the change of the potential since the start and the kinetic energy at the start [J]. */
void lw_run_note_energy(lw_run *run, double kinetic, double change, double work, double kinetic0);

/* Call after a step to (t, y).  LW_E_NUMERIC: a force with sign() or mod() changes its sign at every step, because the motion
 * would have to slide along the jump. */
lw_status lw_run_jumps(lw_run *run, double t, const double *y);
lw_status lw_run_slides(lw_run *run, double t);          /* sets this error */

/* Expressions of joints, points, springs and their rates can change within a short way, as a detent does.  lw_run_jumps limits the next
 * step to where such a change is seen: from the values after the last three steps, and the bounds of lw_expression_calm.  LW_E_MEMORY. */
lw_status lw_run_make_pulses(lw_run *run);
void      lw_run_free_pulses(lw_run *run);

/* lw_kinks_ahead and lw_kinks_pass at the state y.  Solvers add the event to theirs, as the last one, if run->kinks is not NULL. */
double lw_run_kink_ahead(lw_run *run, double t, const double *y);
bool   lw_run_pass_kinks(lw_run *run, double t, const double *y, bool event);

/* Kinetic and potential energy at y less the work done since the start [J], which is constant. */
double lw_run_energy(const lw_run *run, const double *y);

/* The greatest change of this energy in a step to y that is accepted: `times` the change that the tolerance allows [J].  The
 * bodies are placed in the posture of y, d->force are the forces there.  scratch (n_v). */
double lw_run_energy_error(const lw_run *run, double times, const double *y, double *scratch);

/* Fills r->unknowns and r->why; returns the status. */
lw_status lw_formulation_say(lw_dynamics_report *r, lw_status status, int unknowns, const char *why);

/* ---- stops.c: rigid stops ------------------------------------------------------------------ */

/* Event functions (n_stop): the gap of each open stop, the force of each closed one; then, if the forces are piecewise
 * smooth, the distance to the end of the piece. */
lw_status lw_run_stop_events(void *context, double t, const double *y, double *g);

/* Is y beyond a rigid stop that was not passed at the start of the run?  begin: y is the start. */
bool lw_run_stop_passed(const lw_run *run, const double *y, bool begin);

/* Apply the events at t: impacts, closing and opening of stops; *changed is set if y or the rows changed. */
lw_status lw_run_strike(lw_run *run, double t, double *y, unsigned long long events, bool *changed);

/* Number of checks of the rigid stops between two samples of a driven run, since a motion can pass a stop and return between them. */
int       lw_run_looks(const lw_dynamics *d);
/* LW_E_KIND: the posture q (n_q) at t is beyond a rigid stop. */
lw_status lw_run_look_at_stops(lw_run *run, double t, const double *q);

/* ---- stick.c: set-valued friction of joints in space ----------------------------------------- */

/* Can all friction of d be set-valued?  Only in revolute and prismatic joints in space, without rigid stops. */
bool lw_stick_suits(const lw_dynamics *d);

/* _begin: call at the start of a run.  lw_run_stick: call at the start and at each event; finds which joints stick and in which
 * direction the others slip.  events: bits of the event functions (n_friction) that crossed 0. */
void      lw_run_stick_begin(lw_run *run);
lw_status lw_run_stick(lw_run *run, double t, double *y, unsigned long long events);
lw_status lw_run_stick_events(void *context, double t, const double *y, double *g);

/* ---- touch.c: contact, ropes, and the rigid stops of models that have them ------------------- */

/* Event functions (LW_TOUCH_EVENTS); all are positive between events. */
#define LW_TOUCH_EVENTS 7
lw_status lw_run_touch_events(void *context, double t, const double *y, double *g);

/* Apply the impacts at (t, y), then find the states of all contacts.  events: bits of the event functions that crossed 0. */
lw_status lw_run_touch(lw_run *run, double t, double *y, unsigned long long events);
/* Call if a run has failed at t: sets the error if friction makes the force of a contact grow without limit there. */
void      lw_run_touch_jams(lw_run *run, double t);

/* Call at the end of a run, which leaves (t, y): reports if places stick there that could slip as well. */
lw_status lw_run_touch_end(lw_run *run, double t, double *y);

/* Report that friction at the place gave way at t although it could still have held: the load can be shared in several ways. */
void      lw_run_touch_jammed(lw_run *run, double t, int place);

/* At the start: on which sides bars are touched, in the coordinates placed last.  LW_E_ARG: nothing tells it. */
lw_status lw_run_touch_choose_sides(lw_run *run);

/* LW_E_ARG: shapes overlap at t, in the coordinates placed last. */
lw_status lw_run_touch_check(lw_run *run, double t);

/* LW_E_NUMERIC: corners have passed through each other by more than this, scaled.  The equations are placed. */
lw_status lw_run_touch_crossed(lw_run *run, double t, double by);

/* Change the velocities v (n_v) by an impact at n places that approach, with friction and restitution; the posture is placed and the rows of the
 * joints alone are factored.  LW_NOTHING: no impulses were found, v is untouched. */
lw_status lw_run_touch_impact(lw_run *run, double t, int n, const int *place, double *v);

/* _accept: call after a step to (t, y); LW_E_NUMERIC: the closing of a contact was missed.  _step: the longest step from y that
 * cannot miss one. */
lw_status lw_run_touch_accept(lw_run *run, double t, const double *y);
double    lw_run_touch_step(lw_run *run, const double *y);

/* ---- passage.c: forces in singular postures -------------------------------------------------- */

/* Accelerations d->a and multipliers d->l at (t, y) near a singular posture, where the rows are too inaccurate, from the motion
 * through this posture; rows and factors are those at y.  NaN where they have no limit or cannot be found. */
#define LW_SINGULAR_NEAR 0.02            /* distance from a singular posture below which to call it, about radians */
lw_status lw_run_singular_forces(lw_run *run, double t, const double *y);

/* ---- singular.c: through singular postures -------------------------------------------------- */

/* If rows are redundant, the basis of the rows can become dependent in a posture that is not singular: choose another basis.
 * *weak: the least pivot, before and after.  LW_OK: the basis has changed; LW_NOTHING: it is the same. */
lw_status lw_run_rechoose(lw_run *run, double t, const double *y, double *weak);

/* Call after a step to (*t, y), where the least pivot is `weak`.  If a singular posture is ahead, go through it and pass on the
 * samples on the way; y and *t are then beyond it.  before: the state before the step, NULL: not known.  LW_NOTHING: there is
 * no singular posture, or it cannot be passed in this way. */
lw_status lw_run_singular_crossing(lw_run *run, double weak, const double *before, double *t, double *y);

/* From y at time `good`, with the least pivot `weak`, cross the singular posture at about the time `place` by one step. The step
 * begins LW_SINGULAR_STEP_HALF before it and ends as far behind it, in multiples of the distance at which a pivot is 1 (about
 * radians).  On return y and *t are beyond it; samples on the way are passed on.  LW_OPEN: the energy has changed. */
#define LW_SINGULAR_STEP_HALF 0.1
lw_status lw_run_singular_step(lw_run *run, double good, double weak, double place, double *t, double *y);

#endif
