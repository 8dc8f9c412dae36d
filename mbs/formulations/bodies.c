/* mbs/formulations/bodies.c - forward dynamics in the coordinates of all bodies: index1 by an explicit method,
 * cvode by an implicit one.  Rigid stops are events; singular postures are passed
 * (mbs/run/singular.c). */
#include "base/real.h"
#include "base/vector.h"
#include "mbs/formulations/formulations_internal.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/ode/cvode.h"
#include "mbs/ode/integrate.h"

static const double rounding = 1e-12;        /* error of a projected velocity at the distance 1 from a singular posture, scaled */
static const double hold_most = 30;          /* greatest correction of velocities, over the error allowed in a step */

double lw_run_held(lw_run *run, const double *q, const double *v, const double *rigid)
{
    lw_dynamics *d = run->d;
    double fastest = 0;
    if (run->has_work)
        return 0;
    double potential = d->eq.potential(d->eq.context, q), all = d->eq.kinetic(d->eq.context, v), off = all + potential - run->energy0;
    double kinetic = rigid ? all - d->eq.kinetic(d->eq.context, rigid) : all;
    for (int i = 0; i < d->n_v; i++)         /* a call of fmax takes longer than the rest */
        fastest = fabs(v[i]) > fastest ? fabs(v[i]) : fastest;
    if (!(kinetic > 0) || !(fabs(off)*fastest <= hold_most*(d->o.absolute + d->o.relative*fastest)*2*kinetic))
        return 0;
    run->r->energy_held += fabs(off);
    return off/(2*kinetic);
}

void lw_run_hold(lw_run *run, double t, double *q, double *v)
{
    lw_dynamics *d = run->d;
    double *rigid = d->eq.keep_momenta ? d->hold : NULL;
    run->keeps_momenta = rigid != NULL;
    if (rigid)
        d->eq.keep_momenta(d->eq.context, t, q, v, rigid);
    double part = lw_run_held(run, q, v, rigid);
    for (int i = 0; i < d->n_v; i++)
        v[i] -= (v[i] - (rigid ? rigid[i] : 0))*part;
}

/* Project y after an explicit step, and hold its momenta and energy.  At the distance theta from a singular posture, rounding errors of a
 * projection grow by 1/theta^3.  Where they reach the tolerance, how far y moves does not tell the error of the step. */
static lw_status project_and_hold_energy(void *context, double t, double *y)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    lw_status s = lw_run_project(run, t, y);
    if (s == LW_OK)
        lw_run_hold(run, t, y, y + d->n_q);
    double theta = pow(rounding/(d->o.relative + d->o.absolute), 1.0/3);
    return s == LW_OK && d->weak < theta*theta ? LW_NOTHING : s;
}

/* ---- one solver or the other ---------------------------------------------------------------------- */

typedef struct stepper {
    lw_run       *run;
    bool          implicit, sticks;          /* sticks: friction of joints is set-valued */
    lw_ode        ode;
    lw_integrator explicit_one;
    lw_sundials   implicit_one;
    double       *work;
    double       *each;                      /* absolute tolerances, NULL: all the same */
    bool          open;                      /* a planar model without loops, which has no singular postures */
    int           n_aimed;                   /* steps that ended at samples, or could have */
    double       *before;                    /* state (n) before the last step of the implicit method */
    int           n_cut;                     /* times in a row that this method began a step again */
    bool          may_leave, returns, leaves;        /* for the implicit method; from there it returns where steps may be longer; it leaves now */
    long          look, looked;              /* steps after which to see whether equations became stiff, and at the last time */
    double        looked_t, mean;            /* mean: of the lengths of the latest steps */
    double        first;                     /* length of the first step; 0: the solver chooses it */
} stepper;

/* Event functions of stops, contacts or friction; that of kinks comes after them. */
static int n_event(const stepper *w)
{
    const lw_dynamics *d = w->run->d;
    return d->touch ? LW_TOUCH_EVENTS : w->sticks ? d->n_friction : d->n_stop + (d->eq.piece_left != NULL);
}

/* Errors of velocities that are greater than the speeds at which regularised friction changes its sign would let a joint at rest rattle: the least
 * of these speeds is so many times as great. */
static const double within_speed = 10;

static double slowest_friction(const lw_dynamics *d)
{
    double least = INFINITY;
    for (int j = 0; j < d->n_friction; j++) {
        const lw_friction_joint *f = &d->friction[j];
        bool slides = !d->space && !lw_joint_turns(d->s.joint[f->joint].kind);
        least = fmin(least, f->speed/(slides ? d->eq.unit : f->lever_arm));
    }
    return least;
}

static lw_status begin_steps(stepper *w, lw_run *run, double t, const double *y)
{
    const lw_dynamics_options *o = &run->d->o;
    lw_ode_options each = lw_ode_options_default();
    each.relative = w->implicit ? lw_run_bdf_tolerance(o->relative) : o->relative;
    each.absolute = w->implicit ? lw_run_bdf_tolerance(o->absolute) : o->absolute;
    if (w->implicit || w->may_leave)
        each.absolute = fmin(each.absolute, slowest_friction(run->d)/within_speed);
    each.max_step = lw_run_steps_left(run);
    each.smooth = run->d->eq.smooth;
    lw_status s = LW_OK;
    w->each = w->each ? w->each : lw_run_tolerances(run, each.absolute, &s);
    each.absolute_each = w->each;
    if (s != LW_OK)
        return s;
    w->ode = (lw_ode){ .n = run->n, .context = run, .rate = lw_run_rate,
                       .project = w->implicit ? lw_run_project : project_and_hold_energy,
                       .n_event = n_event(w) + (run->kinks != NULL), .breaks = run->kinks ? 1ull << n_event(w) : 0,
                       .event = run->d->touch ? lw_run_touch_events : w->sticks ? lw_run_stick_events : lw_run_stop_events };
    memset(w->ode.direction, -1, sizeof w->ode.direction);
    if (w->implicit)
        return lw_cvode_make(&w->implicit_one, &w->ode, &each, LW_CVODE_BDF, t, y, run->e);
    w->work = calloc(lw_integrate_work(run->n, w->ode.n_event), sizeof *w->work);
    if (!w->work)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    s = lw_integrate_start(&w->explicit_one, &w->ode, &each, w->work, t, y, run->e);
    w->explicit_one.h = w->first;
    w->first = 0;
    return s;
}

static void end_steps(stepper *w, lw_dynamics_report *r)
{
    r->steps += w->implicit ? w->implicit_one.n_step : w->explicit_one.n_step;
    r->refused += w->implicit ? w->implicit_one.n_refused : w->explicit_one.n_refused;
    r->rates += w->implicit ? w->implicit_one.n_rate : w->explicit_one.n_rate;
    if (w->implicit)
        lw_sundials_free(&w->implicit_one);
    free(w->work);
    w->work = NULL;
    w->explicit_one.n_step = w->explicit_one.n_refused = w->explicit_one.n_rate = 0;
}

static const double *state(const stepper *w) { return w->implicit ? w->implicit_one.y : w->explicit_one.y; }
static double time_of(const stepper *w) { return w->implicit ? w->implicit_one.t : w->explicit_one.t; }

static lw_status step(stepper *w, double end, lw_ode_stop *stop, lw_error *e)
{
    return w->implicit ? lw_sundials_step(&w->implicit_one, end, stop, e)
                       : lw_integrate_step(&w->explicit_one, end, stop, e);
}

/* Where the continuous solution of a step is not accurate, each sample in it costs a step of its own.  Few samples (apart by a step over `few`,
 * or more) are the ends of the next steps instead; after AIMED of these it is tried again. */
enum { AIMED = 16 };
static const double few = 3;

static double step_end(lw_run *run, stepper *w)
{
    const lw_dynamics_options *o = &run->d->o;
    double t = time_of(w), end = w->implicit ? lw_run_near(run, t) : lw_run_end(run, t);
    bool aims = w->open && w->explicit_one.rough > 0 && run->next <= o->intervals
             && few*(o->to - o->from) > w->explicit_one.h*o->intervals && ++w->n_aimed % AIMED;
    double next = aims ? lw_run_time(run->d, run->next) : end;
    return next > t ? fmin(end, next) : end;
}

/* The first step ends within the flight, so that the end of a short one is found. */
static lw_status restart(stepper *w, const double *y, double flight, lw_error *e)
{
    if (flight > 0)
        w->explicit_one.h = fmin(w->explicit_one.h, 0.5*flight);
    return w->implicit ? lw_cvode_restart(&w->implicit_one, y, 0.5*flight, e)
                       : lw_integrate_restart(&w->explicit_one, y, e);
}

/* Regularised friction changes while the slip of its joint is less than about its speed, so for a short time where the slip falls to 0 and rises
 * again, or changes its sign.  If only the last stages of a step are within that time, its error is a thousand times the estimate.  So a step ends
 * where the slip, at its present rate of change, falls to `zone` times the speed, and one that begins near there ends no later than at the same slip
 * to the other side, unless the joint rests already, up to an error allowed.  0: no limit. */
static const double zone = 1.5, near_zone = 1.8;

static double step_to_rest(const lw_dynamics *d, const lw_integrator *w)
{
    const double *q = w->y, *v = w->y + d->n_q, *a = w->dy + d->n_q;
    double most = INFINITY;
    for (int j = 0; j < d->n_friction; j++) {
        lw_friction_joint whole = d->friction[j];
        whole.held = true, whole.part = -1;
        double push = whole.coefficient*whole.lever_arm, slip = lw_mbs_rub_one(d, &whole, q, v, 1, d->hold)/push;
        double rate = lw_mbs_rub_one(d, &whole, q, a, 1, d->hold)/push, speed = whole.speed/whole.lever_arm;
        if (slip*rate < 0 && fabs(slip) > w->o.absolute)
            most = fmin(most, (fabs(slip) + (fabs(slip) > near_zone*speed ? -zone : zone)*speed)/fabs(rate));
    }
    return most < INFINITY ? most : 0;
}

/* Places that touch after a step: their event functions are positive, and the next step misses none. */
static lw_status watch_touch(stepper *w, double *y)
{
    lw_integrator *e = &w->explicit_one;
    memcpy(y, e->y, (size_t)w->run->n*sizeof *y);
    lw_status s = lw_run_touch_accept(w->run, e->t, y);
    memset(e->side, 1, (size_t)e->ode->n_event);
    e->o.greatest = lw_run_touch_step(w->run, y);
    e->o.greatest = e->o.greatest < INFINITY ? e->o.greatest : 0;
    return s;
}

/* The state at t within the last step. */
static lw_status state_at(void *context, double t, double *y)
{
    stepper *w = context;
    if (t == time_of(w)) {
        memcpy(y, state(w), (size_t)w->run->n*sizeof *y);
        return LW_OK;
    }
    lw_status s = w->implicit ? lw_sundials_dense(&w->implicit_one, t, y) : lw_integrate_dense(&w->explicit_one, t, y);
    return s == LW_OK && lw_run_correct(w->run, t, y) < 0 ? LW_E_NUMERIC : s;
}

/* Forces of contacts have peaks within steps: look at places of the last step, which began at t; y is overwritten. */
static void watch_within(lw_run *run, stepper *w, double t, double *y)
{
    enum { LOOKS = 8 };
    const lw_equations *eq = &run->d->eq;
    double step = time_of(w) - t;
    for (int k = 1; eq->watch && k < LOOKS; k++)
        if (state_at(w, t + step*k/LOOKS, y) == LW_OK)
            eq->watch(eq->context, t + step*k/LOOKS, y, y + run->d->n_q, false);
}

/* The last state at some distance from singular postures. */
typedef struct good_state { double t, h, weak, *y; } good_state;

static const double beside = 1e-4;           /* least pivot near a singular posture: an angle of 0.01 */

/* Does the solver take ever shorter steps towards a singular posture? */
static bool is_stuck(const stepper *w, const lw_dynamics *d, const good_state *f, lw_status s)
{
    if (s == LW_STOPPED || w->implicit || d->n_resting || d->touch || w->sticks || d->eq.next_piece || !(f->h > 0) || d->weak > beside)
        return false;
    return s == LW_E_NUMERIC || s == LW_OPEN || w->explicit_one.h < 0.02*f->h;
}

/* Keep the state where it is good.  Where the solver is stuck before a singular posture, step over it and begin
 * again behind it. */
static lw_status step_over_singular(lw_run *run, stepper *w, good_state *f, lw_status s, lw_ode_stop *stop)
{
    lw_dynamics *d = run->d;
    double t;
    if (s == LW_OK && d->weak > beside)
        *f = (good_state){ time_of(w), fmax(time_of(w) - w->explicit_one.t_old, 0.5*f->h), d->weak,
                     memcpy(f->y, state(w), (size_t)run->n*sizeof *f->y) };
    if (!is_stuck(w, d, f, s))
        return s;
    s = lw_run_singular_step(run, f->t, f->weak, time_of(w), &t, f->y);
    if (s != LW_OK)
        return s;
    double h = f->h;
    f->h = 0;
    *stop = LW_ODE_STEP;                     /* that of a step that failed says nothing */
    end_steps(w, run->r);
    s = begin_steps(w, run, t, f->y);
    w->explicit_one.h = h;
    return s;
}

/* An implicit method near a singular posture that it cannot pass takes ever shorter steps without end.  It counts as
 * stuck after so many steps in a row, each no longer than this part of the run. */
static const long   stuck_most = 5000;
static const double stuck_step = 1e-9;

static lw_status check_progress(const lw_run *run, const stepper *w, long *n)
{
    const lw_dynamics *d = run->d;
    bool still = time_of(w) - run->r->t < stuck_step*(d->o.to - d->o.from) && d->weak < beside;
    *n = still ? *n + 1 : 0;
    return *n < stuck_most ? LW_OK
         : lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the linkage comes to a singular posture with speed, and "
                        "no motion was found behind it: a dead point or the end of its way", time_of(w));
}

/* Steps left at which a run counts as endless; rounding of places over the length of a step, over the error allowed of velocities. */
static const double endless = 1e7, hidden = 1e4;

lw_status lw_run_check_rounding(const lw_run *run, double h, const double *y, long *n)
{
    const lw_dynamics_options *o = &run->d->o;
    const double *v = y + run->d->n_q;
    if (!(h*endless < o->to - run->r->t)) {
        *n = 0;
        return LW_OK;
    }
    double place = lw_greatest(run->d->n_q, y), allowed = lw_run_bdf_tolerance(o->absolute) + lw_run_bdf_tolerance(o->relative)*lw_greatest(run->d->n_v, v);
    *n = DBL_EPSILON*place > hidden*allowed*h ? *n + 1 : 0;
    return *n < stuck_most ? LW_OK
         : lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the tolerance is below rounding: coordinates of up to %.2g, scaled, are held to %.1g, which "
                        "does not give velocities to %.1g; ask for a greater tolerance, or take index1", run->r->t, place, DBL_EPSILON*place, allowed);
}

/* Pass through the singular posture ahead, if there is one, and begin again behind it. */
static lw_status pass_singular(lw_run *run, stepper *w, double weak, double *y)
{
    double t = time_of(w);
    if (run->d->large || run->d->touch || w->sticks)     /* step_over_singular and take_back see to its singular postures */
        return LW_OK;
    memcpy(y, state(w), (size_t)run->n*sizeof *y);
    lw_status s = lw_run_rechoose(run, t, y, &weak);
    s = s < 0 ? s : lw_run_singular_crossing(run, weak, w->implicit ? NULL : w->explicit_one.y_old, &t, y);
    if (s == LW_NOTHING && !w->implicit && run->ahead > 0 && run->d->n_resting == 0)    /* a longer step would miss it */
        w->explicit_one.h = fmin(w->explicit_one.h, 0.7*run->ahead);
    if (s != LW_OK)
        return s == LW_NOTHING ? LW_OK : s;
    if (lw_run_project(run, t, y) < 0)
        return LW_E_NUMERIC;
    if (w->implicit)
        w->implicit_one.t = t;
    else
        w->explicit_one.t = t, w->explicit_one.t_low = 0;
    return t < run->d->o.to ? restart(w, y, 0, run->e) : LW_OK;
}

/* A step over a singular posture can end on the other motion curve that meets there.  Then the energy has changed by
 * more than the error of a step.  Take such a step back and begin again with a shorter one; *taken: how often so far. */
static const double most_energy = 100;       /* such a change over that of a step at its tolerance */
static const int    most_taken = 6;

static lw_status take_back(lw_run *run, stepper *w, double *y, int *taken)
{
    const lw_dynamics *d = run->d;
    lw_integrator *e = &w->explicit_one;
    double near = 2*LW_SINGULAR_STEP_HALF, length = e->t - e->t_old;
    if (d->weak > near*near || *taken == most_taken
        || fabs(lw_run_energy(run, e->y) - lw_run_energy(run, e->y_old)) <= lw_run_energy_error(run, most_energy, e->y, y)) {
        *taken = 0;
        return LW_NOTHING;
    }
    ++*taken;
    memcpy(y, e->y_old, (size_t)run->n*sizeof *y);
    e->t = e->t_old;
    e->t_low = 0;
    e->events = 0;
    lw_status s = lw_integrate_restart(e, y, run->e);
    e->h = 0.3*length;
    return s;
}

/* Newton's method of cvode takes a jump for a steep slope, and then a step in which nothing moves, or in which friction pushes on, for a solution.  Do the
 * equations hold behind the step?  If not, the jump is in an expression, or the step begins again, shorter, from the state y before it: LW_NOTHING. */
static const double most_unsolved = 10;          /* change of a velocity in the step, over its tolerance */
static const double cut = 0.1;
enum { CUTS = 12 };                              /* times in a row */

static lw_status check_solved(lw_run *run, stepper *w, const double *y, double *slope)
{
    const lw_dynamics *d = run->d;
    lw_sundials *c = &w->implicit_one;
    double length = c->t - c->t_old;
    bool solved = true;
    lw_status s = lw_sundials_slope(c, slope);
    if (s == LW_OK)
        s = lw_run_rate(run, c->t, c->y, run->y);
    for (int i = d->n_q; s == LW_OK && i < d->n_q + d->n_v; i++)
        solved = solved && fabs(slope[i] - run->y[i])*length <= most_unsolved*(d->o.absolute + d->o.relative*fabs(c->y[i]));
    w->n_cut = solved ? 0 : w->n_cut + 1;
    if (s != LW_OK || solved)
        return s;
    if (run->sides)
        return lw_run_slides(run, c->t);
    if (w->n_cut > CUTS)
        return lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s no step is short enough for the friction, whose \"speed\" is far below the tolerance of the "
                            "velocities; ask for a smaller tolerance or give a greater speed", c->t_old);
    c->t = c->t_old;
    s = lw_cvode_restart(c, y, cut*length, run->e);
    return s == LW_OK ? LW_NOTHING : s;
}

/* A kink that is passed in the last step: begin again.  *stop: LW_ODE_STEP if it was the only event. */
static lw_status pass_kinks(stepper *w, double *y, lw_ode_stop *stop)
{
    unsigned long long *events = w->implicit ? &w->implicit_one.events : &w->explicit_one.events, kink = 1ull << n_event(w);
    bool event = *stop == LW_ODE_EVENT && *events & kink, passed = lw_run_pass_kinks(w->run, time_of(w), state(w), event);
    *events &= ~kink;
    *stop = event && !*events ? LW_ODE_STEP : *stop;
    if (!passed || *stop != LW_ODE_STEP)
        return LW_OK;
    memcpy(y, state(w), (size_t)w->run->n*sizeof *y);
    return restart(w, y, 0, w->run->e);
}

/* Impacts at the state y, and what rests, touches or sticks from here on; begin again. */
static lw_status decide(stepper *w, double *y, unsigned long long events)
{
    lw_run *run = w->run;
    double t = time_of(w);
    bool changed;
    lw_status s = run->d->touch ? lw_run_touch(run, t, y, events) : w->sticks ? lw_run_stick(run, t, y, events)
                : lw_run_strike(run, t, y, events, &changed);
    if (s == LW_OK)
        s = restart(w, y, run->flight, run->e);
    if (w->sticks)
        memset(w->explicit_one.side, 1, (size_t)run->d->n_friction);
    return s;
}

/* The step ends at events.  What is good then is the state behind the impact. */
static lw_status act_on_events(stepper *w, good_state *f, double *y)
{
    const lw_dynamics *d = w->run->d;
    memcpy(y, state(w), (size_t)w->run->n*sizeof *y);
    if (d->eq.next_piece) {
        d->eq.next_piece(d->eq.context, y, y + d->n_q, false);
        d->eq.watch(d->eq.context, time_of(w), y, y + d->n_q, false);
    }
    lw_status s = decide(w, y, w->implicit ? w->implicit_one.events : w->explicit_one.events);
    if (f->t == time_of(w))
        memcpy(f->y, y, (size_t)w->run->n*sizeof *f->y);
    return s;
}

/* Equations can become stiff on the way, as where a valve opens, and then steps are short for stability alone.  Seen after each LOOK steps, which
 * double whenever the run comes back from an implicit method. */
enum { LOOK = 64 };

/* Joints that rest by regularised friction make them stiff, too: after so many steps as long as stability allows, where more than `worth` of them are left. */
enum { LIMITED = 15 };
static const double worth = 200;

bool lw_run_friction_limits(const lw_run *run, const lw_integrator *w)
{
    return w->n_limited >= LIMITED && run->d->o.to - w->t > worth*(w->t - w->t_old);
}

static bool became_stiff(lw_run *run, stepper *w, const double *y)
{
    long n = w->explicit_one.n_step + w->explicit_one.n_refused;
    double t = time_of(w);
    bool limits = w->may_leave && run->d->n_friction && lw_run_friction_limits(run, &w->explicit_one);
    w->mean = limits ? t - w->explicit_one.t_old : (t - w->looked_t)/(double)(n - w->looked);
    if (limits || !w->may_leave || n < w->look)
        return limits;
    w->look = n + (LOOK << run->n_back), w->looked = n, w->looked_t = t;
    run->d->eq.place_states(run->d->eq.context, y + lw_run_states(run));
    return lw_mbs_became_stiff(run->d, t, y, y + run->d->n_q, w->mean, w->returns);
}

/* A step from `t` on with contacts fails: rows of places have become dependent.  Choose others, and begin with a short step. */
static lw_status choose_other_places(stepper *w, double t, double *y)
{
    lw_run *run = w->run;
    memcpy(y, state(w), (size_t)run->n*sizeof *y);
    lw_status s = lw_run_touch(run, t, y, 0);
    if (s == LW_OK)
        s = restart(w, y, run->flight, run->e);
    w->explicit_one.h *= 0.01;
    return s != LW_OPEN ? s : lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the forces of contact are undetermined; give the contacts a "
                                           "\"stiffness\"", t);
}

/* Where the step ends at a kink of loads or drives: its samples, and what rests, touches or sticks behind it. */
static lw_status pass_kink_of_loads(stepper *w, double *y, lw_ode_stop *stop)
{
    lw_run *run = w->run;
    if (!lw_run_at_kink(run, time_of(w)))
        return LW_OK;
    memcpy(y, state(w), (size_t)run->n*sizeof *y);
    lw_status s = lw_run_pass_kink(run, w->implicit ? &w->implicit_one.t : &w->explicit_one.t, state_at, w);
    *stop = lw_run_stop(run, time_of(w), LW_ODE_STEP);
    if (s == LW_OK && run->pushed && *stop != LW_ODE_END)        /* by drives, whose impulse changes all velocities */
        s = lw_run_project(run, time_of(w), y) < 0 ? LW_E_NUMERIC : LW_OK;
    if (s == LW_OK && *stop != LW_ODE_END)               /* loads that jump lift what rests, and move what sticks */
        s = decide(w, y, 0);
    return s;
}

/* To the end of the run.  LW_NOTHING: the run can go on otherwise from the state reached. */
static lw_status run_steps(lw_run *run, stepper *w, double t, double *y)
{
    lw_dynamics *d = run->d;
    lw_ode_stop stop = LW_ODE_STEP;
    long n_stuck = 0, n_hidden = 0;
    int taken = 0;
    double redecided = -INFINITY;
    bool has_stops = !d->touch && !w->sticks;
    if (has_stops)
        lw_run_stop_passed(run, y, true);
    good_state f = { t, 0, 1, calloc(2*(size_t)run->n, sizeof *y) };
    w->before = f.y ? f.y + run->n : NULL;
    lw_status s = f.y ? begin_steps(w, run, t, y) : LW_E_MEMORY;
    if (s == LW_OK && d->touch)
        s = watch_touch(w, y);
    if (s == LW_OK && w->sticks)
        memset(w->explicit_one.side, 1, (size_t)d->n_friction);
    for (long n = 1; s == LW_OK && stop != LW_ODE_END; n++) {
        double from = time_of(w);
        if (d->n_friction && has_stops && !w->implicit)
            w->explicit_one.o.greatest = step_to_rest(d, &w->explicit_one);
        if (w->implicit)
            memcpy(w->before, state(w), (size_t)run->n*sizeof *y);
        s = step(w, step_end(run, w), &stop, run->e);
        s = w->implicit ? s : step_over_singular(run, w, &f, s, &stop);
        if (d->touch && s != LW_OK && s != LW_STOPPED && time_of(w) > redecided) {
            redecided = time_of(w);
            s = choose_other_places(w, redecided, y);
            stop = LW_ODE_STEP;
        } else if (d->touch && s == LW_E_NUMERIC)
            lw_run_touch_jams(run, time_of(w));
        if (s == LW_OK && w->implicit)
            s = check_progress(run, w, &n_stuck);
        run->r->t = time_of(w);
        if (s == LW_OK && w->implicit)
            s = lw_run_check_rounding(run, time_of(w) - from, state(w), &n_hidden);
        if (s != LW_OK)
            break;
        if (w->implicit && (run->sides || d->n_friction) && (s = check_solved(run, w, w->before, y)) != LW_OK) {
            stop = LW_ODE_STEP;
            s = s == LW_NOTHING ? LW_OK : s;
            continue;
        }
        double weak = d->weak;
        if (!w->implicit && !d->touch && (s = take_back(run, w, y, &taken)) != LW_NOTHING) {
            stop = LW_ODE_STEP;
            continue;
        }
        s = LW_OK;
        stop = lw_run_stop(run, time_of(w), stop);
        watch_within(run, w, from, y);
        lw_run_watch(run, state(w));
        s = lw_run_jumps(run, time_of(w), state(w));
        if (s == LW_OK && has_stops && lw_run_stop_passed(run, state(w), false))
            s = lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s a joint has passed its rigid stop unseen, which it was pushed against from rest: "
                             "let it begin a little away from the stop, or press on it from the start", time_of(w));
        if (s == LW_OK)
            s = lw_run_samples(run, time_of(w), state_at, w);
        if (s == LW_OK)
            s = pass_kinks(w, y, &stop);
        if (s == LW_OK && stop == LW_ODE_EVENT)
            s = act_on_events(w, &f, y);
        if (s == LW_OK)
            s = pass_kink_of_loads(w, y, &stop);
        if (s == LW_OK && d->touch)
            s = watch_touch(w, y);
        if (s == LW_OK)
            s = lw_run_limits(run, time_of(w), n);
        if (s == LW_OK && stop != LW_ODE_END) {
            s = pass_singular(run, w, weak, y);
            stop = lw_run_stop(run, time_of(w), stop);
        }
        if (s == LW_OK && stop != LW_ODE_END && run->clear > 0 && !w->implicit && d->weak > run->clear)
            s = LW_NOTHING;
        if (s == LW_OK && stop != LW_ODE_END && (w->leaves = became_stiff(run, w, state(w))))
            s = LW_NOTHING;
    }
    free(f.y);
    return s;
}

bool lw_run_may_leave(lw_dynamics *d)
{
    return d->o.formulation == LW_FORMULATION_AUTO && !(d->n_friction && lw_stick_suits(d)) && !d->touch && !d->eq.next_piece
        && !d->large && !d->has_zero_mass && !d->eq.more_inertia && !d->elastic
        && !lw_mbs_is_stiff(d);
}

static lw_status run_bodies(lw_run *run, bool implicit)
{
    lw_dynamics *d = run->d;
    stepper w = { .run = run, .implicit = implicit, .look = LOOK, .looked_t = d->o.from };
    bool changed = false;
    w.may_leave = !implicit && lw_run_may_leave(d);
    w.returns = w.may_leave && run->returns;
    w.open = !implicit && !d->space && !d->touch && d->s.n_joint <= d->s.n_body && d->n_driven == 0;
    double *y = calloc(2*(size_t)run->n, sizeof *y);
    if (!y)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    run->y = y + run->n;
    lw_dynamics_start(d, y, y + d->n_q);
    memcpy(y + lw_run_states(run), d->start_z, (size_t)d->eq.n_z*sizeof *y);
    d->eq.place_states(d->eq.context, d->start_z);
    if ((w.sticks = !implicit && lw_stick_suits(d)))
        lw_run_stick_begin(run);
    lw_status s = d->touch ? lw_run_touch(run, d->o.from, y, 0) : w.sticks ? lw_run_stick(run, d->o.from, y, 0)
                : lw_run_strike(run, d->o.from, y, 0, &changed);
    if (s == LW_OK)
        s = lw_run_begin(run, y);
    if (s == LW_OK)
        s = run_steps(run, &w, d->o.from, y);
    if (w.leaves) {
        memcpy(y, state(&w), (size_t)run->n*sizeof *y);
        end_steps(&w, run->r);
        s = run->leave_stiff(run, y, w.mean);
    } else if (s == LW_OK && d->touch) {
        memcpy(y, state(&w), (size_t)run->n*sizeof *y);
        s = lw_run_touch_end(run, time_of(&w), y);
    }
    if (s == LW_E_NUMERIC && implicit && d->o.formulation == LW_FORMULATION_CVODE && run->r->t > d->o.from) {
        memcpy(y, state(&w), (size_t)run->n*sizeof *y);
        s = lw_run_hand_over(run, y);
    }
    end_steps(&w, run->r);
    free(w.each);
    free(y);
    return s;
}

/* h: NULL, or as for lw_run_explicit_from. */
static lw_status go_on(lw_run *run, double *out, bool implicit, double *h)
{
    stepper w = { .run = run, .implicit = implicit, .may_leave = h, .returns = h, .first = h ? *h : 0, .look = LOOK << run->n_back, .looked_t = run->r->t };
    size_t n = (size_t)run->n;
    double *y = calloc(2*n, sizeof *y), *old = run->y;
    if (!y)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    memcpy(y, out, n*sizeof *y);
    run->y = y + n;
    run->e->text[0] = '\0';
    run->pivot = run->ahead = 0, run->pivot_tried = 1;
    run->r->smooth_friction = run->d->ideal_friction;
    lw_status s = lw_run_project(run, run->r->t, y);
    if (s == LW_OK)
        s = run_steps(run, &w, run->r->t, y);
    if (s == LW_NOTHING) {
        run->r->t = time_of(&w);
        memcpy(out, state(&w), n*sizeof *y);
        if (h)
            *h = w.leaves ? w.mean : 0;
    }
    end_steps(&w, run->r);
    free(w.each);
    run->y = old;
    free(y);
    return s;
}

lw_status lw_run_go_on_implicit(lw_run *run, double *out) { return go_on(run, out, true, NULL); }

lw_status lw_run_go_on(lw_run *run, double *out) { return go_on(run, out, run->d->n_friction > 0 || lw_mbs_is_stiff(run->d), NULL); }

lw_status lw_run_explicit_from(lw_run *run, double *out, double *h) { return go_on(run, out, false, h); }

lw_status lw_run_hand_over(lw_run *run, double *y)
{
    lw_dynamics *d = run->d;
    lw_dynamics_report *r = run->r;
    bool implicit = lw_mbs_is_stiff(d) || (d->n_friction && lw_mbs_friction_is_stiff(d));
    if (run->refused || d->touch || d->elastic || d->eq.next_piece || d->eq.more_inertia || (implicit && (d->large || r->formulation == LW_FORMULATION_CVODE)))
        return LW_E_NUMERIC;
    const lw_formulation to = implicit ? LW_FORMULATION_CVODE : LW_FORMULATION_INDEX1;
    snprintf(r->why, sizeof r->why, "%s gave up: %.230s", lw_formulation_name(r->formulation),
             run->e->text[0] ? run->e->text : "its equations have no solution there");
    r->gave_up = r->formulation;
    r->gave_up_t = r->t;
    r->formulation = to;
    return go_on(run, y, implicit, NULL);
}

/* ---- index1 and cvode -------------------------------------------------------------------------------- */

static lw_status run_index1(lw_run *run) { return run_bodies(run, false); }
static lw_status run_cvode(lw_run *run) { return run_bodies(run, true); }

static lw_status index1_able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    char why[200];
    if (d->touch)
        return lw_formulation_say(r, LW_OK, d->n_q + d->n_v, "bodies' coordinates; contacts and ropes by complementarity");
    if (asked)
        return lw_formulation_say(r, LW_OK, d->n_q + d->n_v, "asked for");
    if (lw_mbs_is_stiff(d) || (d->n_friction && !lw_stick_suits(d) && !lw_run_may_leave(d) && lw_mbs_friction_is_stiff(d)))
        return lw_formulation_say(r, LW_E_KIND, 0, "the equations are stiff");
    if (lw_mbs_states_decay(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "first-order states decay fast");
    if (d->space)
        snprintf(why, sizeof why, "places and quaternions of all bodies, explicit method of order 8%s%s%s",
                 d->has_zero_mass ? "; massless parts are solved by rank" : "",
                 !d->n_friction ? "" : lw_stick_suits(d) ? "; friction sticks" : "; friction is regularised, but not stiff", lw_mbs_is_planar(d));
    else
        snprintf(why, sizeof why, "bodies' coordinates: %s", d->not_reduced);
    return lw_formulation_say(r, LW_OK, d->n_q + d->n_v, why);
}

static lw_status cvode_able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    if (d->touch || d->eq.next_piece)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no contacts");
    if (!asked && lw_mbs_suits_ggl(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "ggl solves stiff dampers in fewer steps");
    if (d->large)
        return lw_formulation_say(r, LW_E_KIND, 0, "more links than a dense matrix is made for");
    return lw_formulation_say(r, LW_OK, d->n_q + d->n_v, asked ? "asked for" : d->n_friction
                              ? "friction makes the equations stiff: an implicit method"
                              : lw_mbs_states_decay(d) ? "first-order states decay fast: an implicit method"
                              : "dampers make the equations stiff: an implicit method");
}

const lw_formulation_row lw_formulation_index1 = { index1_able, run_index1 };
const lw_formulation_row lw_formulation_cvode = { cvode_able, run_cvode };
