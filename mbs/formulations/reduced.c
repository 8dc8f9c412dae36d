/* mbs/formulations/reduced.c - a run in one coordinate.  Where the coordinate turns back (a dead point of the
 * input) the run goes on in the coordinates of all bodies.
 *
 * Where there are losses, loads do not depend on the time, and the kinetic energy does not change fast, the input is the independent variable:
 * panels of sixteen values (input_panel_internal.h) need about half of the evaluations of steps in time.
 *
 * With friction the linkage slides one way, slides the other way or sticks.  It slides until p = 0; the side on which
 * a joint's friction acts changes where the joint turns back.  Both are events; a panel ends where a joint turns back.  It sticks as long as
 * it would accelerate neither way, against its friction in that way. */
#include "base/real.h"
#include "mbs/formulations/formulations_internal.h"
#include "mbs/formulations/input_panel_internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/ode/integrate.h"

static const int turns_every = 4;
static const double hold_most = 10;          /* greatest correction of p over the error allowed in a step */
static const double most_change = 1e-4;     /* greatest correction of s and p */

typedef struct motion {
    lw_run        *run;
    lw_reduced    *r;
    lw_integrator *w;
    double kinetic, potential, least_mass;   /* kinetic, potential: at the start */
    double unit;                             /* p at a rate of 1/s of the coordinate, or of all bodies where that is less */
    double *memory;                            /* of the integrator */
    double t, s[3], t_old;                   /* at the end of the last step: time and (s over scale, p, work); time where it began */
    double slip;                             /* least speed of smooth friction [1/s], of a slip of the unit of length; infinite: none */
    bool   panels, in_panel;                 /* panels suit the loads; the last step was one */
    double allowed[3];                       /* absolute errors of steps; between panels the whole error: that of a pin does not grow with its turns */
    long   wait;                             /* number of steps of the integrator before which no panel is tried */
    lw_input_panel panel;
    double next_reversal;                    /* of a joint with friction, in multiples of scale; infinite: there is none */
    bool   slides;                           /* a slide has friction */
    bool   may_leave;                        /* for an implicit method, where regularised friction limits the steps */
    int    turning;                          /* the friction whose slide has the least reaction */
    double x[LW_JOINT_MAX], y[LW_JOINT_MAX]; /* reactions of joints with friction, where the step begins */
    bool   in_step;
    const double *from;                      /* (n) bodies' coordinates before the last step */
} motion;

static lw_status rate(void *context, double t, const double *y, double *dy)
{
    const motion *m = context;
    double power, scale = m->r->scale;
    lw_status s = lw_run_busy(m->run, t);
    if (s == LW_OK)
        s = lw_reduced_rate(m->r, t, y[0]*scale, y[1], &dy[0], &dy[1], &power);
    dy[0] /= scale;
    if (m->run->has_work)
        dy[2] = power;
    return s;
}

/* Absolute error allowed in s over scale, p and work, whatever the units of length, mass and energy are.  That of p is this
 * part of the speed of smooth friction: at rest, steps with a greater one would go to and fro between the friction of either direction. */
static const double slip_part = 0.1;

static double allowed_absolute(const motion *m, int i)
{
    const double absolute = m->run->d->o.absolute;
    return i == 0 ? absolute : i == 1 ? fmin(absolute, slip_part*m->slip)*m->unit : absolute*m->unit*m->unit;
}

/* Choose the unit of p at the start.  Beside a dead point of the input M is far too great to measure errors by: no more counts than all masses
 * and inertias, each at a rate of 1/s. */
static lw_status choose_unit(motion *m, double s)
{
    const lw_dynamics *d = m->run->d;
    double mass, all = 0;
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_body *body = &d->model->body[d->s.link[b]];
        all += body->mass*d->s.unit*d->s.unit + body->inertia;
    }
    lw_status st = lw_reduced_mass(m->r, s, &mass);
    m->unit = sqrt(fmin(mass*m->r->scale*m->r->scale, all));
    return st;
}

/* Note the end of the last step of the integrator, or its start. */
static void note_state(motion *m)
{
    const lw_dynamics_options *o = &m->run->d->o;
    m->t = m->w->t;
    memcpy(m->s, m->w->y, (size_t)m->w->ode->n*sizeof *m->s);
    for (int i = 0; i < 3; i++)
        m->allowed[i] = allowed_absolute(m, i) + (m->panels ? o->relative*(i > 0 ? fabs(m->s[i]) : 1) : 0);
}

/* Start the integrator anew at the state noted, with steps of length h (0: not known). */
static lw_status start_anew(motion *m, double h)
{
    lw_run *run = m->run;
    lw_ode_options o = m->w->o;
    run->r->steps += m->w->n_step, run->r->refused += m->w->n_refused, run->r->rates += m->w->n_rate;
    o.max_step = lw_run_steps_left(run);
    lw_status s = lw_integrate_start(m->w, m->w->ode, &o, m->memory, m->t, m->s, run->e);
    m->w->h = h;
    return s;
}

/* Correct the energy H after a step: by p alone where the correction is as small as the error allowed in the step,
 * which costs nothing; near turning points by the least change, along the gradient (-Q, p).  LW_OPEN: the energy has
 * changed by more than the errors allowed. */
static lw_status hold_energy(void *context, double t, double *y)
{
    motion *m = context;
    const lw_dynamics_options *o = &m->run->d->o;
    double scale = m->r->scale, ds, dp, mass, power;
    lw_status s = lw_reduced_registers(m->r, y[0]*scale);
    if (s != LW_OK)
        return s;
    double off = 0.5*y[1]*y[1] - m->kinetic + lw_reduced_potential(m->r, y[0]*scale) - m->potential;
    double explained = hold_most*(allowed_absolute(m, 1) + o->relative*fabs(y[1]))*fabs(y[1]);
    if (fabs(off) <= explained) {
        y[1] -= off/y[1];
    } else if (lw_reduced_rate(m->r, t, y[0]*scale, y[1], &ds, &dp, &power) == LW_OK
               && lw_reduced_mass(m->r, y[0]*scale, &mass) == LW_OK) {
        double push = dp*sqrt(mass)*scale, steep = push*push + y[1]*y[1];
        if (!(fabs(off) < most_change*steep))    /* at rest in equilibrium, or the step is wrong, as one over a singular posture may be */
            return fabs(off) <= explained + hold_most*(allowed_absolute(m, 0)*fabs(push) + allowed_absolute(m, 2)) ? LW_OK : LW_OPEN;
        y[0] += push*off/steep;
        y[1] -= y[1]*off/steep;
    }
    m->run->r->energy_held += fabs(off);
    return LW_OK;
}

/* The coordinates of all bodies for s = (s, p, work); turns are taken near those in y. */
static lw_status bodies_state(const motion *m, const double *s, double *y)
{
    const lw_dynamics *d = m->run->d;
    double mass;
    lw_status st = lw_reduced_mass(m->r, s[0]*m->r->scale, &mass);
    if (st == LW_OK)
        lw_reduced_state(m->r, d, s[1]/sqrt(mass), y, y + d->n_q);
    if (m->run->has_work)
        y[2*d->n_q] = s[2];
    return st;
}

/* Predict the turns of the links after h from the rates before and those in the registers. */
static void predict_turns(const motion *m, const double *from, double h, double ds, double *to)
{
    const lw_dynamics *d = m->run->d;
    for (int b = 0; b < d->s.n_body; b++) {
        double before = from[d->n_q + 3*b + 2], after = ds*m->r->reg[m->r->centre[b].dir].d.x;
        to[3*b + 2] = from[3*b + 2] + 0.5*h*(before + after);
        to[d->n_q + 3*b + 2] = after;
    }
}

/* The state at t, within the last step. */
static lw_status state_at(void *context, double t, double *y)
{
    motion *m = context;
    double s3[3], mass;
    memcpy(s3, m->s, sizeof s3);
    if (t != m->t && m->in_panel)
        return lw_input_panel_state(&m->panel, m->run, m->r, t, m->from + 2, 3, y);
    lw_status s = t == m->t ? LW_OK : lw_integrate_dense(m->w, t, s3);
    if (s != LW_OK)
        return s;
    lw_reduced_mass(m->r, s3[0]*m->r->scale, &mass);
    predict_turns(m, m->from, t - m->t_old, s3[1]/sqrt(mass), y);
    return bodies_state(m, s3, y);
}

/* Energies come from the registers, so that a step costs little more than its evaluations.  The turns of the links
 * are found every few steps only, which is often enough to count revolutions, unless lw_run_jumps looks at them. */
static lw_status watch(motion *m, double *y)
{
    lw_run *run = m->run;
    double input = m->s[0]*m->r->scale, mass;
    lw_status s = lw_reduced_registers(m->r, input);
    double change = lw_reduced_potential(m->r, input) - m->potential, kinetic = 0.5*m->s[1]*m->s[1];
    lw_run_note_energy(run, kinetic, change, run->has_work ? m->s[2] : 0, m->kinetic);
    if (s != LW_OK)
        return s;
    lw_reduced_mass(m->r, input, &mass);
    lw_reduced_count_turns(m->r);
    predict_turns(m, y, m->t - m->t_old, m->s[1]/sqrt(mass), y);
    for (int b = 0; m->in_panel && b < run->d->s.n_body; b++)
        y[3*b + 2] = m->from[3*b + 2] + lw_input_panel_turned(&m->panel, b, 1);
    bool unseen = !m->in_panel && m->w->n_step % turns_every && !run->sides && !run->pulses && !run->kinks;
    return unseen ? LW_OK : bodies_state(m, m->s, y);
}

/* Near a dead point the links move like the square root of the distance to it, which magnifies rounding and the
 * allowed error of the coordinate.  Take back a step that came near one: y becomes the state `before` it.  LW_OPEN:
 * taken back. */
static lw_status stay_off(motion *m, const double *before, double *y)
{
    double mass;
    lw_status s = lw_reduced_mass(m->r, m->s[0]*m->r->scale, &mass);
    m->least_mass = fmin(m->least_mass, mass);
    if (s == LW_OK && mass <= LW_REDUCED_TURNING_BACK*m->least_mass)
        return LW_OK;
    s = bodies_state(m, before, y);
    m->run->r->t = m->t_old;
    return s == LW_OK ? LW_OPEN : s;
}

/* ---- friction ------------------------------------------------------------------------------------ */

/* Does the size of a pin's reaction fall to nearly 0 and rise again within the step, so that the equation nearly has a kink?
 * The stages of a step may lie so that its error is not seen.  A step of length h in which a reaction changes p' by s has an error of
 * about s h/144 there, of s h x^2 if the kink is at a part x of the step from its nearer end.  A reaction that does not fall to 0 has a
 * singularity at a complex time; rho is the sum of the half axes of the ellipse through it with foci at the ends of the step, over half the
 * step.  Beyond `sharp`, errors of polynomials fall by a power of rho (Bernstein's ellipse); with the sixth they were at most 8 tolerances
 * in 124 linkages.  The error grows at least as h^2: then w->retry is the length that is allowed. */
static const double sharp = 1.6;             /* a quarter of a step beside its middle */

static bool steps_over_dip(const motion *m)
{
    const lw_reduced_friction *f = m->r->friction;
    lw_integrator *w = m->w;
    const lw_dynamics_options *o = &m->run->d->o;
    double allowed = allowed_absolute(m, 1) + o->relative*fabs(w->y[1]), h = fabs(w->h_done), most = 1;
    for (int i = 0; i < f->n && m->in_step; i++) {
        lw_vec2 before = { m->x[i], m->y[i] }, change = { f->x[i] - m->x[i], f->y[i] - m->y[i] };
        double square = lw_v2_dot(change, change), x = -lw_v2_dot(before, change)/square, side = fmin(x, 1 - x);
        if (f->press[i] != 0 || !(side > 0))
            continue;
        double off = lw_v2_cross(before, change)/square, axis = hypot(x, off) + hypot(1 - x, off);
        double rho = fmax(1, (axis + sqrt(fmax(axis*axis - 1, 0)))/sharp), cube = rho*rho*rho;
        most = fmax(most, f->feel[i]*sqrt(square)*h*fmin(side*side + off*off, 1/144.)/(cube*cube*allowed));
    }
    if (most > 1)
        w->retry = h*fmin(fmax(0.9/sqrt(most), 0.1), 0.5);
    return most > 1;
}

/* Rest, the next reversal of a joint, and where the reaction of a slide changes its sign (m->slides). */
static lw_status friction_events(motion *m, double t, const double *y, double *g)
{
    lw_reduced_friction *f = m->r->friction;
    double ds, dp, power, greatest = 0;
    g[0] = f->set_valued ? f->sense*y[1] : 1;
    g[1] = f->set_valued ? f->sense*(m->next_reversal - y[0]) : 1;
    if (t == m->w->t && steps_over_dip(m))
        return LW_OPEN;                      /* a shorter step */
    if (!m->slides)
        return LW_OK;
    lw_status s = lw_reduced_rate(m->r, t, y[0]*m->r->scale, y[1], &ds, &dp, &power);
    g[2] = 1;
    for (int i = 0; i < f->n && s == LW_OK; i++)
        greatest = fmax(greatest, fabs(f->size[i]));
    for (int i = 0; i < f->n && s == LW_OK; i++)
        if (f->press[i] != 0 && f->press[i]*f->x[i] < g[2]*greatest) {
            g[2] = f->press[i]*f->x[i]/greatest;
            m->turning = i;
        }
    return s;
}

/* After the events of friction, the next kink. */
static lw_status events(void *context, double t, const double *y, double *g)
{
    motion *m = context;
    lw_status s = LW_OK;
    int n = m->r->friction ? 2 + m->slides : 0;
    if (m->run->kinks) {
        memcpy(m->run->y, m->r->q, (size_t)m->run->d->n_q*sizeof *y);       /* turns of the last evaluation */
        s = bodies_state(m, y, m->run->y);
        g[n] = s == LW_OK ? lw_run_kink_ahead(m->run, t, m->run->y) : 0;
    }
    return s == LW_OK && n > 0 ? friction_events(m, t, y, g) : s;
}

/* Find the signs of the reactions of slides for the sense of the motion. */
static lw_status find_press(motion *m, double t, const double *y)
{
    lw_reduced_friction *f = m->r->friction;
    double ds, dp, power;
    memset(f->press, 0, sizeof f->press);
    if (!m->slides)
        return LW_OK;
    lw_status s = lw_reduced_rate(m->r, t, y[0]*m->r->scale, y[1], &ds, &dp, &power);
    for (int i = 0; i < f->n && s == LW_OK; i++)
        f->press[i] = !m->r->joint[f->joint[i]].slides ? 0 : f->x[i] < 0 ? -1 : 1;
    return s;
}

/* Tell the equations of the bodies which friction acts. */
static void show_friction(const motion *m, bool held)
{
    const lw_reduced_friction *f = m->r->friction;
    for (int i = 0; i < f->n; i++) {
        m->run->d->friction[i].held = held && m->run->d->friction[i].ideal;
        m->run->d->friction[i].part = f->sense*f->side[i];
    }
}

/* p' at rest for a sense of the friction. */
static lw_status push_at_rest(motion *m, double t, double s, double sense, double *push)
{
    double ds, power;
    m->r->friction->sense = sense;
    return lw_reduced_rate(m->r, t, s*m->r->scale, 0, &ds, push, &power);
}

/* The sense in which a linkage at rest starts to move; 0: it sticks, with the part of the friction that acts in
 * f->sense.  LW_OPEN: it could start either way. */
static lw_status leave_rest(motion *m, double t, double s, double *sense)
{
    lw_reduced_friction *f = m->r->friction;
    double x[2] = { -1, 1 }, push[2], now = 0;
    int side = 0;
    memset(f->press, 0, sizeof f->press);
    lw_status st = push_at_rest(m, t, s, 0, &now);
    if (st == LW_OK)
        st = lw_reduced_friction_sides(m->r, s*m->r->scale, now);
    for (int k = 0; k < 2 && st == LW_OK; k++)
        st = push_at_rest(m, t, s, x[k], &push[k]);
    if (st == LW_OK && push[1] > 0 && push[0] < 0)
        return LW_OPEN;
    if (st != LW_OK)
        return st;
    *sense = f->sense = push[1] > 0 ? 1 : push[0] < 0 ? -1 : 0;
    /* zero of the push in between, by the Illinois method */
    for (int k = 0; *sense == 0 && st == LW_OK && k < 60 && push[0] > push[1]; k++) {
        double at = x[0] + (x[1] - x[0])*push[0]/(push[0] - push[1]);
        st = push_at_rest(m, t, s, at, &now);
        if (now == 0 || at == x[0] || at == x[1])
            break;
        int to = now < 0;
        x[to] = at, push[to] = now;
        push[1 - to] *= k && side == to ? 0.5 : 1;
        side = to;
    }
    return st;
}

/* The state at rest at t. */
static lw_status state_at_rest(void *context, double t, double *y)
{
    motion *m = context;
    double sense;
    lw_status s = leave_rest(m, t, m->s[0], &sense);
    show_friction(m, true);
    return s == LW_OK ? bodies_state(m, m->s, y) : s;
}

/* Rates for the steps that look for the end of rest: their error control finds how fast the loads change. */
static lw_status rest_rate(void *context, double t, const double *y, double *dy)
{
    motion *m = context;
    (void)y;
    lw_status s = lw_run_busy(m->run, t);
    for (int k = 0; k < 2 && s == LW_OK; k++)
        s = push_at_rest(m, t, m->s[0], k ? 1 : -1, &dy[k]);
    return s;
}

static lw_status rest_events(void *context, double t, const double *y, double *g)
{
    lw_status s = rest_rate(context, t, y, g);
    g[1] = -g[1];
    return s;
}

/* Rest from m->t until the linkage starts to move in some sense, or to the end of the run; *end: when. */
static lw_status rest_until(motion *m, double *end, double *sense)
{
    const lw_dynamics_options *o = &m->run->d->o;
    lw_ode ode = { .n = 2, .context = m, .rate = rest_rate, .n_event = 2, .event = rest_events,
                   .direction = { -1, -1 } };
    lw_ode_options each = lw_ode_options_default();
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    double memory[LW_INTEGRATE_WORK(2, 2)], start[2] = { 0, 0 }, push[2];
    *end = o->to;
    if (m->r->constant_loads)
        return LW_OK;
    lw_status s = rest_rate(m, m->t, NULL, push);
    each.relative = 0;
    each.absolute = fmax(o->relative, 1e-9)*fmax(fmax(fabs(push[0]), fabs(push[1])), 1e-300)*(o->to - o->from);
    each.greatest = 0.01*(o->to - o->from);
    if (s == LW_OK)
        s = lw_integrate_start(&w, &ode, &each, memory, m->t, start, m->run->e);
    lw_timed timed = m->run->timed;
    while (s == LW_OK && w.t < o->to && stop != LW_ODE_EVENT) {
        s = lw_integrate_step(&w, lw_timed_end(&timed, w.t), &stop, m->run->e);
        if (s == LW_OK && stop != LW_ODE_EVENT && lw_timed_at_kink(&timed, w.t)) {
            w.t = lw_timed_behind(&timed);
            w.t_low = 0;
            s = lw_integrate_restart(&w, NULL, m->run->e);
            if (s == LW_OK && (w.side[0] < 0 || w.side[1] < 0)) {        /* the loads jump */
                stop = LW_ODE_EVENT;
                w.events = w.side[0] < 0 ? 1 : 2;
            }
        }
    }
    if (s == LW_OK && stop == LW_ODE_EVENT) {
        *end = w.t;
        *sense = w.events & 1 ? -1 : 1;
    }
    return s;
}

/* At a moment at rest: go on in some way, if need be after resting for a while.  Where the push just exceeds the
 * friction, rounding decides the sign of their difference, so that the event itself tells the sense. */
static lw_status from_rest(motion *m)
{
    double sense, end;
    m->s[1] = 0;
    lw_status s = leave_rest(m, m->t, m->s[0], &sense);
    if (s == LW_OK && sense == 0) {
        s = rest_until(m, &end, &sense);
        if (s == LW_OK)
            s = lw_run_samples(m->run, end, state_at_rest, m);
        m->r->friction->sense = sense;
        m->t = end;
    }
    m->run->r->t = m->t;
    show_friction(m, true);
    return s;
}

/* Begin to slide from y in the sense of the friction: sides of the joints, reactions of slides, next event. */
static lw_status slide(motion *m, double t, const double *y)
{
    lw_reduced *r = m->r;
    double next = INFINITY, s = y[0]*r->scale;
    lw_status st = lw_reduced_friction_sides(r, s, r->friction->sense);
    if (st == LW_OK)
        st = lw_reduced_next_reversal(r, s, r->friction->sense, &next);
    m->next_reversal = next/r->scale;
    show_friction(m, true);
    return st == LW_OK ? find_press(m, t, y) : st;
}

/* After a step that ended at an event, or at a start at rest. */
static lw_status change_friction(motion *m, bool rests)
{
    lw_integrator *w = m->w;
    double to = m->run->d->o.to;
    if (w->events == 4) {
        m->r->friction->press[m->turning] *= -1;
        return lw_integrate_restart(w, w->y, m->run->e);
    }
    lw_status s = rests ? from_rest(m) : LW_OK;
    if (s == LW_OK && m->t < to)
        s = slide(m, m->t, m->s);
    w->events = 0;                           /* the functions are others now, and not near 0 */
    if (s != LW_OK || m->t >= to || m->in_panel)
        return s;
    if (w->t != m->t)
        w->t = m->t, w->t_low = 0;
    return lw_integrate_restart(w, m->s, m->run->e);
}

static lw_status friction_at_start(motion *m, double t, const double *s)
{
    lw_reduced_friction *f = m->r->friction;
    f->sense = s[1] < 0 ? -1 : 1;
    if (s[1] != 0 || !f->set_valued)
        return slide(m, t, s);
    double sense;
    m->next_reversal = 0;
    lw_status st = leave_rest(m, t, s[0], &sense);
    show_friction(m, true);
    return st;
}

/* ---- what repeats itself ------------------------------------------------------------------------- */

/* Without losses and loads that depend on time, a motion that comes to rest goes back the same way and repeats
 * itself for ever.  The period is measured over so many periods, between rests on one side.  Each later sample is
 * reached from the last rest measured, within one period, so rounding and the errors of steps do not add up. */
enum { MEASURED = 10 };
static const double much_longer = 10;        /* periods left from which on this is worth while */

typedef struct rests { int n; double t[2*MEASURED + 1], y[3]; lw_turn_count count; } rests;

/* Find where the last step came to rest, p = 0, by bisection in the dense output. */
static lw_status note_rest(rests *r, lw_integrator *w)
{
    double low = w->t_old, high = w->t;
    if (!(w->y_old[1]*w->y[1] < 0) || r->n == 2*MEASURED + 1)
        return LW_OK;
    for (int i = 0; i < 60 && low < high; i++) {
        double at = 0.5*(low + high);
        if (at == low || at == high)
            break;
        lw_status s = lw_integrate_dense(w, at, r->y);
        if (s != LW_OK)
            return s;
        *((r->y[1] < 0) == (w->y_old[1] < 0) ? &low : &high) = at;
    }
    r->y[1] = 0;
    r->t[r->n++] = high;
    return LW_OK;
}

/* The period [s]; 0: not known yet, or the rests are not evenly spaced. */
static double period_of(const rests *r, double tolerance)
{
    double length = (r->t[2*MEASURED] - r->t[0])/MEASURED;
    if (r->n < 2*MEASURED + 1)
        return 0;
    for (int i = 0; i + 2 < r->n; i++)
        if (!(fabs(r->t[i + 2] - r->t[i] - length) <= (1000*tolerance + 1e-13)*length))
            return 0;
    return length;
}

/* Advance to the time phase_time after the last rest, with y near it; begin anew at that rest when it lies behind. */
static lw_status reach(motion *m, lw_integrator *w, const rests *r, double phase_time, const double *base, double *y)
{
    lw_run *run = m->run;
    lw_ode_stop stop = LW_ODE_STEP;
    lw_status s = LW_OK;
    if (phase_time < w->t) {
        memcpy(y, base, (size_t)run->n*sizeof *y);
        m->r->count = r->count;
        m->t = 0;
        memcpy(m->s, r->y, sizeof m->s);
        s = start_anew(m, 0);
    }
    while (s == LW_OK && stop != LW_ODE_END && phase_time > w->t) {
        m->t_old = w->t;
        s = lw_integrate_step(w, phase_time, &stop, run->e);
        note_state(m);
        if (s == LW_OK)
            s = watch(m, y);
    }
    return s;
}

/* Take the samples that are left.  y: coordinates of the bodies near the last rest; base: scratch for those there. */
static lw_status repeat(motion *m, lw_integrator *w, const rests *r, double length, double *y, double *base)
{
    lw_run *run = m->run;
    double start = r->t[2*MEASURED];
    memcpy(base, y, (size_t)run->n*sizeof *y);
    lw_status s = bodies_state(m, r->y, base);
    run->r->period = length;
    w->t = INFINITY;                         /* begin at the rest */
    for (long k = 1; s == LW_OK && run->next <= run->d->o.intervals; run->next++, k++) {
        double t = lw_run_time(run->d, run->next), phase = (t - start)/length;
        s = reach(m, w, r, (phase - floor(phase))*length, base, y);
        memcpy(run->y, y, (size_t)run->n*sizeof *y);
        if (s == LW_OK)
            s = bodies_state(m, w->y, run->y);
        if (s == LW_OK)
            s = lw_run_show(run, t, run->y);
        if (s == LW_OK)
            s = lw_run_limits(run, t, w->n_step);
    }
    return s;
}

/* A panel from the state noted on.  LW_OPEN: the motion suits none. */
static lw_status take_panel(motion *m)
{
    lw_input_panel *p = &m->panel;
    lw_reduced *r = m->r;
    p->from = m->s[0]*r->scale;
    p->sense = m->s[1] < 0 ? -1 : 1;
    p->t = m->t;
    p->kinetic = 0.5*m->s[1]*m->s[1];
    p->work = m->s[2];
    p->count = r->count;
    p->least_mass = m->least_mass;
    p->absolute = allowed_absolute(m, 1);
    if (r->friction && !m->in_panel)
        r->friction->n_past = 0;             /* panels predict reactions by the input */
    double end = m->next_reversal*r->scale;
    lw_status s = lw_input_panel_step(p, m->run, r, end);
    if (s != LW_OK) {
        r->count = p->count;
        return s;
    }
    m->in_panel = true;
    m->run->r->steps++;
    m->t = p->t_end;
    m->s[0] = p->length == fabs(end - p->from) ? m->next_reversal : (p->from + p->sense*p->length)/r->scale;
    m->s[1] = p->sense*sqrt(2*p->kinetic_end);
    m->s[2] = p->work_end;
    return LW_OK;
}

/* Is a panel to be tried next?  After steps in time their last rates tell how fast K changes. */
static bool may_take_panel(const motion *m)
{
    const lw_integrator *w = m->w;
    double p = m->s[1], pace = fabs(w->dy[0])*m->r->scale;
    if (!m->panels || p == 0)
        return false;
    return m->in_panel || (w->n_step >= m->wait && lw_input_panel_suits(m->r, 0.5*p*p, p*w->dy[1]/pace));
}

/* A panel or a step. */
static lw_status go_on(motion *m, lw_ode_stop *stop)
{
    lw_integrator *w = m->w;
    lw_status s;
    const double last = m->in_panel ? m->t - m->panel.t : 0;
    if (may_take_panel(m)) {
        s = take_panel(m);
        w->events = s == LW_OK && m->s[0] == m->next_reversal ? 2 : 0;
        *stop = w->events ? LW_ODE_EVENT : LW_ODE_STEP;
        if (s != LW_OPEN)
            return s;
        if (m->r->friction)
            m->r->friction->n_past = 0;
        s = m->in_panel ? start_anew(m, 0.1*last) : LW_OK;
        m->in_panel = false;
        m->wait = w->n_step + 10;
        if (s != LW_OK)
            return s;
    }
    m->in_step = true;
    s = lw_integrate_step(w, lw_run_end(m->run, w->t), stop, m->run->e);
    m->in_step = false;
    if (s == LW_OK)
        note_state(m);
    return s;
}

/* After a step to y: kinks of forces that it passed, events of friction, and a kink of the loads at its end.  *again: the steps begin anew there. */
static lw_status pass_events(motion *m, double *y, lw_ode_stop *stop, bool *again)
{
    lw_run *run = m->run;
    lw_integrator *w = m->w;
    lw_status s = LW_OK;
    unsigned long long kink = run->kinks ? 1ull << (w->ode->n_event - 1) : 0;
    bool passed = lw_run_pass_kinks(run, m->t, y, w->events & kink);
    w->events &= ~kink;
    if (*stop == LW_ODE_EVENT && w->events) {
        s = change_friction(m, w->events & 1);
        *stop = lw_run_stop(run, m->t, LW_ODE_STEP);
        *again = true;
    } else if (passed && *stop != LW_ODE_END) {
        s = lw_integrate_restart(w, NULL, run->e);
        *again = true;
    }
    if (s == LW_OK && !m->in_panel && lw_run_at_kink(run, m->t)) {
        s = lw_run_pass_kink(run, &w->t, state_at, m);
        m->t = w->t;
        *stop = lw_run_stop(run, m->t, LW_ODE_STEP);
        if (s == LW_OK && m->r->friction)
            s = find_press(m, m->t, m->s);
        if (s == LW_OK && *stop != LW_ODE_END)
            s = lw_integrate_restart(w, NULL, run->e);
        *again = true;
    }
    return s;
}

static lw_status run_steps(motion *m, double *y, double *before)
{
    lw_run *run = m->run;
    lw_dynamics *d = run->d;
    lw_integrator *w = m->w;
    lw_ode_stop stop = LW_ODE_STEP;
    lw_status s = LW_OK;
    bool taken_back = false;
    double stiff = 0;                        /* the last step, where the equations became stiff */
    rests rest = { .n = 0 };
    double old[3], good[3], t_good = m->t, longest = 0;      /* good: the last state before steps became short */
    memcpy(good, m->s, sizeof good);
    lw_reduced_mass(m->r, m->s[0]*m->r->scale, &m->least_mass);
    m->kinetic = 0.5*m->s[1]*m->s[1];
    lw_reduced_registers(m->r, m->s[0]*m->r->scale);
    m->potential = lw_reduced_potential(m->r, m->s[0]*m->r->scale);
    while (s == LW_OK && stop != LW_ODE_END) {
        if (m->r->friction) {
            memcpy(m->x, m->r->friction->x, sizeof m->x);
            memcpy(m->y, m->r->friction->y, sizeof m->y);
        }
        memcpy(old, m->s, sizeof old);
        m->t_old = m->t;
        memcpy(before, y, (size_t)run->n*sizeof *y);
        s = go_on(m, &stop);
        if (s != LW_OK)
            break;
        run->r->t = m->t;
        stop = lw_run_stop(run, m->t, stop);
        s = stay_off(m, old, y);
        if (s == LW_OPEN) {
            taken_back = true;
            break;
        }
        longest = fmax(longest, m->t - m->t_old);
        if (m->t - m->t_old > 0.1*longest) {
            memcpy(good, m->s, sizeof good);
            t_good = m->t;
        }
        if (s == LW_OK)
            s = watch(m, y);
        if (s == LW_OK)
            s = lw_run_jumps(run, m->t, y);
        if (s == LW_OK)
            s = lw_run_samples(run, m->t, state_at, m);
        if (s == LW_OK)
            s = lw_run_limits(run, m->t, w->n_step);
        bool again = false;
        if (s == LW_OK)
            s = pass_events(m, y, &stop, &again);
        longest = again ? 0 : longest;
        if (s == LW_OK && !run->has_work)
            s = note_rest(&rest, w);
        if (s == LW_OK && stop != LW_ODE_END && m->may_leave && !m->in_panel && lw_run_friction_limits(run, w)) {
            stiff = w->t - w->t_old;
            break;
        }
        double length = s == LW_OK ? period_of(&rest, d->o.relative) : 0;
        if (length > 0 && d->o.to - m->t > much_longer*length) {
            rest.count = m->r->count;
            s = repeat(m, w, &rest, length, y, before);
            break;
        }
    }
    if ((s == LW_E_NUMERIC || s == LW_OPEN) && !taken_back) {    /* the run goes on from there */
        bodies_state(m, good, y);
        run->r->t = t_good;
    }
    run->r->t = fmin(run->r->t, d->o.to);
    run->r->steps += w->n_step;
    run->r->refused += w->n_refused;
    run->r->rates += w->n_rate;
    if (stiff > 0 && (s = bodies_state(m, m->s, y)) == LW_OK)
        s = run->leave_stiff(run, y, stiff);
    return s;
}

static lw_status run_one(motion *m, double *y)
{
    lw_run *run = m->run;
    lw_dynamics *d = run->d;
    double s[3] = { 0 }, memory[LW_INTEGRATE_WORK(3, 4)], *before = y + run->n;
    lw_ode ode = { .n = 2 + run->has_work, .context = m, .rate = rate,
                   .project = run->has_work ? NULL : hold_energy };
    if (m->r->friction) {
        m->slides = m->r->friction->n_slide > 0;
        m->may_leave = !m->r->friction->set_valued && lw_run_may_leave(d);
        ode.n_event = 2 + m->slides;
    }
    ode.breaks = run->kinks ? 1ull << ode.n_event++ : 0;
    ode.event = events;
    memset(ode.direction, -1, sizeof ode.direction);
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    o.relative = d->o.relative;
    o.absolute = d->o.absolute;
    o.max_step = d->o.max_step;
    o.smooth = true;
    lw_dynamics_start(d, y, y + d->n_q);
    lw_status st = lw_reduced_start(m->r, d, y, &s[0], &s[1]);
    if (st != LW_OK)
        return st;
    m->memory = memory;
    m->w = &w;
    m->from = before;
    m->slip = m->r->friction && !m->r->friction->set_valued ? lw_friction_least_slip(d->n_friction, d->friction, d->s.unit) : INFINITY;
    st = choose_unit(m, s[0]);
    s[0] /= m->r->scale;
    if (st == LW_OK && m->r->friction)
        st = friction_at_start(m, d->o.from, s);
    if (st == LW_OK)
        st = lw_run_begin(run, y);
    m->panels = run->has_work && m->r->constant_loads && !m->slides && !run->kinks && !run->pulses && !run->sides;
    m->panel.rule = d->rule;
    m->panel.next = 0.1*m->r->scale;
    m->next_reversal = m->r->friction ? m->next_reversal : INFINITY;
    for (int i = 0; i < 3; i++)
        m->allowed[i] = allowed_absolute(m, i) + (m->panels ? o.relative : 0);
    o.absolute_each = m->allowed;
    if (m->panels)
        o.relative = 0;
    assert(lw_integrate_work(ode.n, ode.n_event) <= sizeof memory/sizeof *memory);
    if (st == LW_OK)
        st = lw_integrate_start(&w, &ode, &o, memory, d->o.from, s, run->e);
    if (st == LW_OK)
        note_state(m);
    if (st == LW_OK && m->r->friction && m->r->friction->set_valued && s[1] == 0)
        st = change_friction(m, true);
    return st == LW_OK && m->t < d->o.to ? run_steps(m, y, before) : st;
}

static lw_status run_reduced(lw_run *run)
{
    motion *m = calloc(1, sizeof *m);
    double *y = calloc(3*(size_t)run->n, sizeof *y);
    if (!y || !m) {
        free(y), free(m);
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    }
    m->run = run;
    lw_reduced *r = m->r = run->d->reduced;
    run->y = y + 2*run->n;
    lw_status s = run_one(m, y);
    if (r->friction)
        show_friction(m, false);
    if ((s == LW_E_NUMERIC || s == LW_OPEN) && r->friction && r->friction->undetermined)
        s = lw_error_set(run->e, LW_E_NUMERIC, "friction at joint \"%s\" leaves its reaction undetermined for rigid "
                         "links (Painleve's paradox) at t = %.9g s: the linkage jams; lower the coefficient or give "
                         "the joint compliance", run->d->model->linkage.joint[r->friction->joint[0]].name, run->r->t);
    else if (s == LW_E_NUMERIC || s == LW_OPEN)
        s = lw_run_go_on(run, y);
    free(y), free(m);
    return s;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    if (!asked && lw_mbs_is_damped(d, true))
        return lw_formulation_say(r, LW_E_KIND, 0, "dampers make the equations stiff");
    lw_status s = lw_reduced_able(d);
    if (s == LW_OK && !asked && d->n_friction && !d->reduced->friction->set_valued && !lw_run_may_leave(d) && lw_mbs_friction_is_stiff(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "friction makes the equations stiff");
    if (s == LW_OK && lw_input_panel_rule(d) != LW_OK)
        return lw_formulation_say(r, LW_E_MEMORY, 0, "out of memory");
    return s != LW_OK ? lw_formulation_say(r, s, 0, d->not_reduced)
         : lw_formulation_say(r, LW_OK, 2, asked ? "asked for"
                              : "one freedom, rigid, solved in closed form by dyads: one coordinate");
}

const lw_formulation_row lw_formulation_reduced = { able, run_reduced };
