/* mbs/dynamics/dynamics_run.c - forward dynamics in the bodies' coordinates, sampled, watched, stopped. */
#include "mbs/dynamics/dynamics_run_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"

/* ---- what is kept of a run ---------------------------------------------------------------------- */

double lw_run_time(const lw_dynamics *d, int k)
{
    int n = d->o.intervals;
    return k == n ? d->o.to : d->o.from + (d->o.to - d->o.from)*k/(n > 0 ? n : 1);
}

/* Angular momentum about the only pin to ground, or linear momentum along the only slider there [SI]. */
static double momentum(const lw_dynamics *d, const double *y)
{
    const double *q = y, *v = y + d->n_q;
    for (int j = 0; j < d->s.n_joint; j++) {
        const lw_system_joint *p = &d->s.joint[j];
        int ground = p->body[0] < 0 ? 0 : 1;
        if (p->body[ground] >= 0)
            continue;
        double sum = 0;
        for (int b = 0; b < d->s.n_body; b++) {
            lw_vec2 at = lw_v2_sub(lw_v2(q[3*b], q[3*b + 1]), p->arm[ground]), rate = lw_v2(v[3*b], v[3*b + 1]);
            sum += p->kind == LW_JOINT_REVOLUTE
                 ? d->f.mass[3*b]*lw_v2_cross(at, rate) + d->f.mass[3*b + 2]*v[3*b + 2]
                 : d->f.mass[3*b]*lw_v2_dot(p->along, rate)/d->s.unit;
        }
        return sum;
    }
    return 0;
}

static double momentum_scale(const lw_dynamics *d, const double *y)
{
    const double *v = y + d->n_q;
    double sum = 0;
    for (int i = 0; i < d->n_q; i++)
        sum += d->f.mass[i]*fabs(v[i]);
    return sum;
}

/* Nothing but one free joint ties the linkage to the ground. */
static bool keeps_momentum(const lw_dynamics *d)
{
    const lw_model *m = d->model;
    int tied = -1;
    for (int j = 0; j < d->s.n_joint; j++)
        if (d->s.joint[j].body[0] < 0 || d->s.joint[j].body[1] < 0) {
            if (tied >= 0)
                return false;
            tied = j;
        }
    if (tied < 0 || (d->s.joint[tied].kind != LW_JOINT_REVOLUTE && d->s.joint[tied].kind != LW_JOINT_SLIDER))
        return false;
    const lw_joint_stop *p = &m->stop[tied];
    bool loaded = m->gravity.x != 0 || m->gravity.y != 0 || m->n_force || d->f.caller.apply ||
                  m->friction[tied].coefficient > 0 || p->has_least || p->has_greatest;
    for (int i = 0; i < m->n_spring; i++)
        loaded = loaded || m->spring[i].link[0] == m->linkage.ground || m->spring[i].link[1] == m->linkage.ground;
    for (int i = 0; i < m->n_joint_spring; i++)
        loaded = loaded || m->joint_spring[i].joint == tied;
    for (int i = 0; i < m->n_motor; i++)
        loaded = loaded || m->motor[i].joint == tied;
    for (int i = 0; i < d->n_driven; i++)
        loaded = loaded || d->s.input_joint[d->driven[i]] == tied;
    return !loaded;
}

void lw_run_watch(lw_run *run, const double *y)
{
    const lw_dynamics *d = run->d;
    lw_dynamics_report *r = run->r;
    double kinetic = lw_forces_kinetic(&d->f, y + d->n_q), potential = lw_forces_potential(&d->f, y);
    double work = run->has_work ? y[2*d->n_q] : 0;
    r->energy_error = fmax(r->energy_error, fabs(kinetic + potential - run->energy0 - work));
    r->energy_scale = fmax(r->energy_scale, fmax(kinetic, fabs(potential - run->potential0)));
    if (r->momentum_scale > 0) {
        r->momentum_error = fmax(r->momentum_error, fabs(momentum(d, y) - run->momentum0));
        r->momentum_scale = fmax(r->momentum_scale, momentum_scale(d, y));
    }
}

lw_status lw_run_show(lw_run *run, double t, const double *y)
{
    lw_dynamics *d = run->d;
    lw_moment m;
    lw_status s = lw_mbs_moment(d, t, y, y + d->n_q, run->has_work ? y[2*d->n_q] : 0, &m);
    if (s != LW_OK)
        return s;
    run->r->worst_off = fmax(run->r->worst_off, m.off);
    run->r->worst_off_rate = fmax(run->r->worst_off_rate, m.off_rate);
    return run->sink ? run->sink(run->context, &m) : LW_OK;
}

/* J^T l = Q(t, q, 0) */
lw_status lw_run_show_slow(lw_run *run, double t, const double *y)
{
    static const double still[LW_SYSTEM_Q_MAX];
    lw_dynamics *d = run->d;
    lw_moment m;
    lw_status s = lw_mbs_moment(d, t, y, y + d->n_q, 0, &m);
    if (s == LW_OK)
        s = lw_mbs_factor(d, true);
    if (s != LW_OK)
        return s;
    lw_forces_apply(&d->f, t, y, still, d->force, NULL, NULL, NULL);
    lw_rank_solve(&d->rank_of, d->force, d->l);
    run->r->worst_off = fmax(run->r->worst_off, m.off);
    run->r->worst_off_rate = fmax(run->r->worst_off_rate, m.off_rate);
    return run->sink ? run->sink(run->context, &m) : LW_OK;
}

lw_status lw_run_begin(lw_run *run, const double *y)
{
    lw_dynamics *d = run->d;
    run->potential0 = lw_forces_potential(&d->f, y);
    run->energy0 = run->potential0 + lw_forces_kinetic(&d->f, y + d->n_q);
    run->momentum0 = momentum(d, y);
    run->r->momentum_scale = keeps_momentum(d) ? fmax(momentum_scale(d, y), 1e-300) : 0;
    lw_run_watch(run, y);
    run->next = 1;
    return lw_run_show(run, d->o.from, y);
}

lw_status lw_run_limits(lw_run *run, double t, long steps)
{
    const lw_dynamics_options *o = &run->d->o;
    run->r->t = t;
    if (o->stop && *o->stop)
        return lw_error_set(run->e, LW_STOPPED, "stopped at t = %.9g s", t);
    if (o->max_step > 0 && run->r->steps + run->r->refused + steps >= o->max_step && t < o->to)
        return lw_error_set(run->e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", t, o->max_step);
    if (o->until > 0 && (steps & 15) == 0 && lw_clock_wall() > o->until)
        return lw_error_set(run->e, LW_STOPPED, "the time allowed was used up at t = %.9g s", t);
    return LW_OK;
}

lw_status lw_run_busy(lw_run *run, double t)
{
    const lw_dynamics_options *o = &run->d->o;
    if (o->stop && *o->stop)
        return lw_error_set(run->e, LW_STOPPED, "stopped at t = %.9g s", t);
    if (o->until > 0 && (++run->n_busy & 255) == 0 && lw_clock_wall() > o->until)
        return lw_error_set(run->e, LW_STOPPED, "the time allowed was used up at t = %.9g s", t);
    return LW_OK;
}

long lw_run_steps_left(const lw_run *run)
{
    long all = run->d->o.max_step, done = run->r->steps + run->r->refused;
    return all <= 0 ? 0 : done < all ? all - done : 1;
}

/* ---- right-hand side ------------------------------------------------------------------------------ */

lw_status lw_run_rate(void *context, double t, const double *y, double *dy)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    int n = d->n_q;
    double power = 0;
    lw_status s = lw_run_busy(run, t);
    if (s == LW_OK)
        s = lw_mbs_accelerate(d, t, y, y + n, dy + n, d->l, run->has_work ? &power : NULL);
    if (s != LW_OK)
        return s;
    memcpy(dy, y + n, (size_t)n*sizeof *dy);
    for (int i = 0; run->has_work && i < d->n_driven; i++) {
        double motion[3];
        lw_mbs_motion(d, i, t, motion);
        power -= d->l[d->n_row + i]*motion[1];
    }
    if (run->has_work)
        dy[2*n] = power;
    return LW_OK;
}

lw_status lw_run_project(void *context, double t, double *y)
{
    lw_run *run = context;
    return lw_mbs_settle(run->d, t, y, y + run->d->n_q);
}

static const double hold_most = 30;          /* change of velocities over the error that a step may have    */

/* The same after an explicit step, and the energy of a conservative model put back by a change of all velocities in
 * proportion, which constraints at rest allow, where that is as little as the step's error may be. */
static lw_status arrive(void *context, double t, double *y)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    double *v = y + d->n_q, fastest = 0;
    lw_status s = lw_run_project(run, t, y);
    if (s != LW_OK || run->has_work)
        return s;
    double kinetic = lw_forces_kinetic(&d->f, v), off = kinetic + lw_forces_potential(&d->f, y) - run->energy0;
    for (int i = 0; i < d->n_q; i++)
        fastest = fmax(fastest, fabs(v[i]));
    if (!(fabs(off)*fastest <= hold_most*(d->o.absolute + d->o.relative*fastest)*2*kinetic))
        return LW_OK;
    for (int i = 0; kinetic > 0 && i < d->n_q; i++)
        v[i] -= v[i]*(off/(2*kinetic));
    run->r->energy_held += fabs(off);
    return LW_OK;
}

/* ---- one solver or the other ---------------------------------------------------------------------- */

typedef struct stepper {
    bool          implicit;
    lw_ode        ode;
    lw_integrator explicit_one;
    lw_cvode      implicit_one;
    double       *work;
} stepper;

static lw_status begin_steps(stepper *w, lw_run *run, double t, const double *y)
{
    const lw_dynamics_options *o = &run->d->o;
    lw_ode_options each = lw_ode_options_default();
    each.relative = o->relative;
    each.absolute = o->absolute;
    each.max_step = lw_run_steps_left(run);
    w->ode = (lw_ode){ .n = run->n, .context = run, .rate = lw_run_rate, .project = w->implicit ? lw_run_project : arrive,
                       .n_event = run->d->n_contact, .event = lw_run_gaps };
    memset(w->ode.direction, -1, sizeof w->ode.direction);
    if (w->implicit)
        return lw_cvode_make(&w->implicit_one, &w->ode, &each, LW_CVODE_BDF, t, y, run->e);
    w->work = calloc(lw_integrate_work(run->n, w->ode.n_event), sizeof *w->work);
    if (!w->work)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    return lw_integrate_start(&w->explicit_one, &w->ode, &each, w->work, t, y, run->e);
}

static void end_steps(stepper *w, lw_dynamics_report *r)
{
    r->steps += w->implicit ? w->implicit_one.n_step : w->explicit_one.n_step;
    r->refused += w->implicit ? w->implicit_one.n_refused : w->explicit_one.n_refused;
    r->rates += w->implicit ? w->implicit_one.n_rate : w->explicit_one.n_rate;
    if (w->implicit)
        lw_cvode_free(&w->implicit_one);
    free(w->work);
}

static const double *state(const stepper *w) { return w->implicit ? w->implicit_one.y : w->explicit_one.y; }
static double time_of(const stepper *w) { return w->implicit ? w->implicit_one.t : w->explicit_one.t; }

static lw_status step(stepper *w, double end, lw_ode_stop *stop, lw_error *e)
{
    return w->implicit ? lw_cvode_step(&w->implicit_one, end, stop, e)
                       : lw_integrate_step(&w->explicit_one, end, stop, e);
}

/* The first step ends within the flight, so that a short one is seen. */
static lw_status restart(stepper *w, const double *y, double flight, lw_error *e)
{
    if (flight > 0)
        w->explicit_one.h = fmin(w->explicit_one.h, 0.5*flight);
    return w->implicit ? lw_cvode_restart_with(&w->implicit_one, y, 0.5*flight, e)
                       : lw_integrate_restart(&w->explicit_one, y, e);
}

/* Samples up to where the solver stands. */
static lw_status show_samples(lw_run *run, stepper *w)
{
    lw_dynamics *d = run->d;
    lw_status s = LW_OK;
    for (; s == LW_OK && run->next <= d->o.intervals; run->next++) {
        double t = lw_run_time(d, run->next);
        if (t > time_of(w))
            break;
        if (t == time_of(w)) {
            memcpy(run->y, state(w), (size_t)run->n*sizeof *run->y);
        } else {
            s = w->implicit ? lw_cvode_dense(&w->implicit_one, t, run->y)
                            : lw_integrate_dense(&w->explicit_one, t, run->y);
            if (s == LW_OK && lw_run_project(run, t, run->y) < 0)
                s = LW_E_NUMERIC;
        }
        if (s == LW_OK)
            s = lw_run_show(run, t, run->y);
        s = s == LW_OPEN ? LW_OK : s;           /* a sample in a singular posture has no accelerations */
    }
    return s;
}

/* The last state at a fair distance from singular postures. */
typedef struct fair { double t, h, weak, *y; } fair;

static const double beside = 1e-4;           /* least pivot beside a singular posture: an angle of 0.01        */

/* Does the solver creep up to a singular posture? */
static bool creeps(const stepper *w, const lw_dynamics *d, const fair *f, lw_status s)
{
    if (s == LW_STOPPED || w->implicit || d->n_contact || !(f->h > 0) || d->weak > beside)
        return false;
    return s == LW_E_NUMERIC || s == LW_OPEN || w->explicit_one.h < 0.02*f->h;
}

/* Note a fair state, or leap over the singular posture that the solver creeps up to and begin again behind it. */
static lw_status keep_off(lw_run *run, stepper *w, fair *f, lw_status s)
{
    lw_dynamics *d = run->d;
    double t;
    if (s == LW_OK && d->weak > beside)
        *f = (fair){ time_of(w), fmax(time_of(w) - w->explicit_one.t_old, 0.5*f->h), d->weak,
                     memcpy(f->y, state(w), (size_t)run->n*sizeof *f->y) };
    if (!creeps(w, d, f, s))
        return s;
    s = lw_run_singular_step(run, LW_SINGULAR_STEP_HALF, f->t, f->weak, time_of(w), &t, f->y);
    if (s != LW_OK)
        return s;
    double h = f->h;
    f->h = 0;
    end_steps(w, run->r);
    w->work = NULL;
    s = begin_steps(w, run, t, f->y);
    w->explicit_one.h = h;
    return s;
}

/* An implicit method beside a singular posture that it cannot pass comes nearer for ever, in ever shorter steps: so many
 * of them in a row, each so small a part of the run. */
static const long   creep_most = 5000;
static const double creep_step = 1e-9;

static lw_status creep(const lw_run *run, const stepper *w, long *n)
{
    const lw_dynamics *d = run->d;
    bool still = time_of(w) - run->r->t < creep_step*(d->o.to - d->o.from) && d->weak < beside;
    *n = still ? *n + 1 : 0;
    return *n < creep_most ? LW_OK
         : lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the linkage comes to a singular posture with speed, and no "
                        "motion was found behind it: a dead point or the end of its way", time_of(w));
}

/* Through the singular posture ahead, if there is one, and begin again behind it. */
static lw_status cross(lw_run *run, stepper *w, double weak, double *y)
{
    double t = time_of(w);
    memcpy(y, state(w), (size_t)run->n*sizeof *y);
    lw_status s = lw_run_rechoose(run, t, y, &weak);
    s = s < 0 ? s : lw_run_singular_crossing(run, weak, &t, y);
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

static lw_status run_steps(lw_run *run, stepper *w, double t, double *y)
{
    lw_dynamics *d = run->d;
    lw_ode_stop stop = LW_ODE_STEP;
    bool changed = false;
    long creeping = 0;
    fair f = { t, 0, 1, calloc((size_t)run->n, sizeof *y) };
    lw_status s = f.y ? begin_steps(w, run, t, y) : LW_E_MEMORY;
    for (long n = 1; s == LW_OK && stop != LW_ODE_END; n++) {
        s = step(w, d->o.to, &stop, run->e);
        s = w->implicit ? s : keep_off(run, w, &f, s);
        if (s == LW_OK && w->implicit)
            s = creep(run, w, &creeping);
        run->r->t = time_of(w);
        if (s != LW_OK)
            break;
        double weak = d->weak;
        stop = time_of(w) >= d->o.to ? LW_ODE_END : stop;
        lw_run_watch(run, state(w));
        s = show_samples(run, w);
        if (s == LW_OK && stop == LW_ODE_EVENT) {
            memcpy(y, state(w), (size_t)run->n*sizeof *y);
            s = lw_run_contacts(run, time_of(w), y, &changed);
            if (s == LW_OK)
                s = restart(w, y, run->flight, run->e);
        }
        if (s == LW_OK)
            s = lw_run_limits(run, time_of(w), n);
        if (s == LW_OK && stop != LW_ODE_END) {
            s = cross(run, w, weak, y);
            stop = time_of(w) >= d->o.to ? LW_ODE_END : stop;
        }
    }
    free(f.y);
    return s;
}

static lw_status run_bodies(lw_run *run, bool implicit)
{
    stepper w = { .implicit = implicit };
    lw_dynamics *d = run->d;
    bool changed = false;
    double *y = calloc(2*(size_t)run->n, sizeof *y);
    if (!y)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    run->y = y + run->n;
    lw_dynamics_start(d, y, y + d->n_q);
    lw_status s = lw_run_contacts(run, d->o.from, y, &changed);
    if (s == LW_OK)
        s = lw_run_begin(run, y);
    if (s == LW_OK)
        s = run_steps(run, &w, d->o.from, y);
    end_steps(&w, run->r);
    free(y);
    return s;
}

lw_status lw_run_go_on(lw_run *run, const double *from)
{
    stepper w = { .implicit = false };
    size_t n = (size_t)run->n;
    double *y = calloc(2*n, sizeof *y), *old = run->y;
    if (!y)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    memcpy(y, from, n*sizeof *y);
    run->y = y + n;
    run->e->text[0] = '\0';
    lw_status s = lw_run_project(run, run->r->t, y);
    if (s == LW_OK)
        s = run_steps(run, &w, run->r->t, y);
    end_steps(&w, run->r);
    run->y = old;
    free(y);
    return s;
}

lw_status lw_dynamics_run(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_error *e)
{
    lw_error own = { 0 };
    lw_run run = { .d = d, .sink = sink, .context = context, .r = r, .e = e ? e : &own };
    lw_status s;
    *r = d->choice;
    d->e = run.e;
    run.has_work = !d->f.conservative || d->n_driven || d->n_friction || d->n_contact;
    run.n = 2*d->n_q + run.has_work;
    run.pivot_tried = 1;
    switch (r->formulation) {
    case LW_FORMULATION_DRIVEN: s = lw_run_driven(&run); break;
    case LW_FORMULATION_QUADRATURE: s = lw_run_quadrature(&run); break;
    case LW_FORMULATION_REDUCED: s = lw_run_reduced(&run); break;
    case LW_FORMULATION_GGL: s = lw_run_ggl(&run); break;
    default: s = run_bodies(&run, r->formulation == LW_FORMULATION_CVODE);
    }
    if (s == LW_OPEN && run.apart > 0 && run.apart < 1e-5)
        s = lw_error_set(run.e, LW_E_NUMERIC, "at t = %.9g s two branches of postures come as near each other as %.1e "
                         "of the size and which of them goes on cannot be told%s", r->t, run.apart, run.apart > 1e-8
                         ? "" : ": if they should meet, write the posture with more digits or give a tolerance above "
                         "that");
    if (s == LW_OPEN)
        s = lw_error_set(run.e, LW_E_NUMERIC, "at t = %.9g s the linkage stands in a singular posture, from "
                         "which it can go on in several ways", r->t);
    if (s < 0 && !run.e->text[0])
        lw_error_set(run.e, s, "the run ended at t = %.9g s: %s", r->t, lw_status_text(s));
    return s;
}
