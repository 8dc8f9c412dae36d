/* mbs/run/run.c - what every run does: samples, energy and momentum, limits, kinks of the loads. */
#include "base/real.h"
#include "base/vector.h"
#include "mbs/run/run_internal.h"
#include "mbs/dynamics/touch_internal.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/equations/limits_internal.h"

/* ---- what is kept of a run ---------------------------------------------------------------------- */

double lw_run_time(const lw_dynamics *d, int k)
{
    int n = d->o.intervals;
    return k == n ? d->o.to : d->o.from + (d->o.to - d->o.from)*k/(n > 0 ? n : 1);
}

void lw_run_note_energy(lw_run *run, double kinetic, double change, double work, double kinetic0)
{
    lw_dynamics_report *r = run->r;
    r->energy_error = fmax(r->energy_error, fabs(kinetic - kinetic0 + change - work));
    r->energy_scale = fmax(r->energy_scale, fmax(kinetic, fabs(change)));
    run->work_done += fabs(work - run->work_last);
    run->work_last = work;
    run->n_noted++;
}

void lw_run_watch(lw_run *run, const double *y)
{
    const lw_dynamics *d = run->d;
    lw_dynamics_report *r = run->r;
    double potential = d->eq.potential(d->eq.context, y), kinetic = d->eq.kinetic(d->eq.context, y + d->n_q);
    double work = (run->has_work ? y[d->n_q + d->n_v] : 0) + run->impulse_work, off = kinetic + potential - work - run->energy0;
    if (run->pushed)
        run->impulse_work += off, work += off;
    run->pushed = false;
    lw_run_note_energy(run, kinetic, potential - run->potential0, work, run->energy0 - run->potential0);
    if (d->eq.watch)
        d->eq.watch(d->eq.context, r->t, y, y + d->n_q, run->next == 0);
    if (r->momentum_scale > 0) {
        double size, now = d->eq.momentum(d->eq.context, y, y + d->n_q, &size);
        r->momentum_error = fmax(r->momentum_error, fabs(now - run->momentum0));
        r->momentum_scale = fmax(r->momentum_scale, size);
    }
}

int lw_run_looks(const lw_dynamics *d)
{
    enum { LOOKS = 2000 };                               /* over a run */
    return d->n_stop > 0 && d->o.intervals < LOOKS ? LOOKS/(d->o.intervals > 1 ? d->o.intervals : 1) : 1;
}

lw_status lw_run_look_at_stops(lw_run *run, double t, const double *q)
{
    static const double rounding = 1e-9;
    lw_dynamics *d = run->d;
    if (d->n_stop > 0)
        d->eq.place(d->eq.context, q);
    for (int i = 0; i < d->n_stop; i++) {
        const lw_rigid_stop *p = &d->stop[i];
        double row[LW_ROW_SIZE] = { 0 };
        int block[LW_ROW_BLOCKS];
        d->eq.measure_blocks(d->eq.context, p->measure, block);
        if (p->sign*(d->eq.measure(d->eq.context, p->measure, row, block) - p->limit) < -rounding)
            return lw_error_set(run->e, LW_E_KIND, "the prescribed motion brings \"%s\" beyond its rigid stop, at t = %.9g s or a little before: "
                                "inputs that move every freedom do not give way, so how much a rigid stop carries is not determined; give it a "
                                "\"stiffness\", or leave the motion of an input out", d->eq.name(d->eq.context, LW_NAMED_MEASURE, p->measure), t);
    }
    return LW_OK;
}

/* A motion that slides along a jump of the forces shows it in one of two ways.  Forces or rates of states jump LW_RUN_JUMPS times in so short a time that a
 * run would have most_jumps.  Or most_near steps in a row are shorter than a run over most_jumps, all with a jump near them that neither
 * comes nearer nor goes away, since stages within the steps jump; most_steady times as many where no end of a step of late was behind the
 * jump.  A jump is near if its side, at the greatest rate of late (which is forgotten slowly), changes within `reach` steps. */
static const double most_jumps = 2e5, reach = 4, forget = 0.99;
static const int most_near = 80, most_steady = 10;
static const double least_jump = 1e-3;                   /* part of the greatest force, or rate of a state, so far: less is no jump */
static const double lately = 1e-3;                       /* part of the run: the last jump is not longer ago */

lw_status lw_run_slides(lw_run *run, double t)
{
    run->refused = true;                                 /* no formulation can follow it */
    return lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s a force, or the rate of a state, with sign() or mod() jumps to and fro: the motion slides "
                        "along the jump, where it is not defined. Give the joint \"friction\", or take a smooth function, as tanh(x/0.001)", t);
}

/* ---- pulses ------------------------------------------------------------------------------------------- */

/* A variable of an expression: its last value, its mean rate over the last step, how far it may move without a pulse (forwards, back). */
typedef struct pulse { double value, rate, reach[2]; } pulse;

struct lw_pulses {
    int     n, next, looks;                  /* looks: number of moments looked at */
    double  t, t_old, h;                     /* of the last moment, of the one before; greatest length of the next step */
    double *force, *q;                       /* (n_v), (n_q) scratch */
    pulse   of[];
};

/* Values farther away do not tell what is small; shorter pulses are not looked for [rad], [m]. */
static const double pulse_range = 1e3, pulse_least = 1e-7;

static bool is_motion(int variable)
{
    lw_quantity what = lw_variable_quantity(variable);
    return what != LW_QUANTITY_T && what != LW_QUANTITY_STATE;
}

static void count_pulses(void *context, const lw_expression *x)
{
    const int *which;
    for (int i = 0, n = x ? lw_expression_variables(x, &which) : 0; i < n; i++)
        *(int *)context += is_motion(which[i]) && lw_expression_may_pulse(x, which[i]);
}

/* How far the variable may move from u in the direction `way`: from the reach before, which it doubles or halves. */
static double reach_of(const lw_expression *x, int variable, double u, double way, double before)
{
    double most = before > 0 ? fmin(4*before, pulse_range) : pulse_range;
    return fabs(lw_expression_calm(x, variable, true, u - way*pulse_range, u, u + way*most, pulse_least) - u);
}

/* Time in which a variable with this rate and acceleration moves by `way`. */
static double time_for(double way, double rate, double acceleration)
{
    return 2*way/(fabs(rate) + sqrt(rate*rate + 2*fabs(acceleration)*way) + 1e-300);
}

static void look_at_pulses(void *context, const lw_expression *x, const double *v)
{
    struct lw_pulses *p = context;
    const int *which;
    for (int i = 0, n = lw_expression_variables(x, &which); i < n; i++) {
        if (!is_motion(which[i]) || !lw_expression_may_pulse(x, which[i]) || p->next == p->n)
            continue;
        pulse *z = &p->of[p->next++];
        double h = p->t - p->t_old, mean = h > 0 ? (v[i] - z->value)/h : 0, bend = h > 0 && p->looks > 1 ? (mean - z->rate)/h : 0;
        double now = mean + 0.5*h*bend;
        z->value = v[i];
        z->rate = mean;
        for (int back = 0; back < 2; back++) {
            bool goes = (back ? -now : now) + fabs(bend)*h > 0;      /* in this direction, if not at once */
            if (!goes)
                continue;
            z->reach[back] = reach_of(x, which[i], v[i], back ? -1 : 1, z->reach[back]);
            if (z->reach[back] < pulse_range)
                p->h = fmin(p->h, time_for(z->reach[back], now, bend));
        }
    }
}

lw_status lw_run_make_pulses(lw_run *run)
{
    const lw_equations *eq = &run->d->eq;
    int n = 0;
    if (eq->expressions)
        eq->expressions(eq->context, count_pulses, &n);
    if (n == 0)
        return LW_OK;
    run->pulses = calloc(1, sizeof *run->pulses + (size_t)n*sizeof *run->pulses->of + (size_t)(eq->n_v + eq->n_q)*sizeof(double));
    if (!run->pulses)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    run->pulses->n = n;
    run->pulses->force = (double *)(run->pulses->of + n);
    run->pulses->q = run->pulses->force + eq->n_v;
    return LW_OK;
}

void lw_run_free_pulses(lw_run *run) { free(run->pulses); }

static void look_at_moment(lw_run *run, double t, const double *q, const double *v)
{
    const lw_equations *eq = &run->d->eq;
    struct lw_pulses *p = run->pulses;
    p->next = 0;
    p->t_old = p->looks > 0 ? p->t : t;
    p->t = t;
    p->h = INFINITY;
    eq->values(eq->context, t, q, v, p->force, look_at_pulses, p);
    p->looks++;
}

/* At the start of a run, the moment before is that from which the velocities lead here. */
static void limit_by_pulses(lw_run *run, double t, const double *y)
{
    const lw_equations *eq = &run->d->eq;
    struct lw_pulses *p = run->pulses;
    const double *v = y + eq->n_q, before = 1e-7*(run->d->o.to - run->d->o.from);
    eq->place_states(eq->context, y + lw_run_states(run));
    if (t <= run->d->o.from) {
        p->looks = 0;
        memcpy(p->q, y, (size_t)eq->n_q*sizeof *p->q);
        for (int i = 0; i < eq->n_v; i++)
            p->force[i] = -before*v[i];
        eq->move(eq->context, p->q, p->force);
        look_at_moment(run, t - before, p->q, v);
    }
    look_at_moment(run, t, y, v);
    run->pulse_t[0] = t + p->h;
    run->pulse_t[1] = t + p->h/LW_CALM_SAMPLES;
}

/* ---- jumps -------------------------------------------------------------------------------------------- */

lw_status lw_run_jumps(lw_run *run, double t, const double *y)
{
    const lw_equations *eq = &run->d->eq;
    if (run->pulses)
        limit_by_pulses(run, t, y);
    if (!run->sides)
        return LW_OK;
    int n = eq->n_v + eq->n_z;                           /* forces, and rates of states */
    double *side = run->sides, *now = side + eq->n_switch, *force = now + eq->n_switch, *before = force + n, *most = before + n;
    bool jumped = false, large = false;
    memcpy(before, force, (size_t)n*sizeof *before);
    eq->place_states(eq->context, y + lw_run_states(run));
    eq->switches(eq->context, t, y, y + eq->n_q, force, now);
    if (eq->n_z)
        eq->state_rates(eq->context, t, y, y + eq->n_q, force + eq->n_v);
    for (int i = 0; i < eq->n_v; i++)
        run->most_force = fmax(run->most_force, fabs(force[i]));
    for (int i = 0; i < n; i++) {
        double *of = i < eq->n_v ? &run->most_force : &most[i - eq->n_v];
        *of = fmax(*of, fabs(force[i]));
        large = large || fabs(force[i] - before[i]) > least_jump**of;
    }
    double all = run->d->o.to - run->d->o.from, h = t - run->jumps_t, *rate = most + eq->n_z;      /* rate (n_jump): of the sides */
    double near = -1;                                    /* distance of a jump that the step could reach; < 0: there is none */
    bool first_look = run->jumps_t == -INFINITY;
    for (int k = 0, i = eq->n_switch - eq->n_jump; k < eq->n_jump; k++, i++) {
        rate[k] = fmax(h > 0 ? fabs(now[i] - side[i])/h : 0, forget*rate[k]);
        jumped = jumped || (!first_look && (now[i] > 0) != (side[i] > 0));
        near = fabs(now[i]) <= reach*h*rate[k] ? fmax(near, fabs(now[i])) : near;
    }
    memcpy(side, now, (size_t)eq->n_switch*sizeof *side);
    run->jumps_t = t;
    bool beside = near >= 0 && !first_look && h*most_jumps < all;
    run->n_near = beside ? run->n_near + 1 : 0;
    run->n_steady = beside ? run->n_steady : 0;
    double *part = &run->near[run->n_near > most_near/2];        /* greatest distance in the first half of such steps, in the second */
    *part = run->n_near % (most_near/2) == 1 ? near : fmax(*part, near);
    double *last = &run->jumped[run->n_jumped % LW_RUN_JUMPS], first = *last;
    if (jumped && large) {
        *last = t;
        if (++run->n_jumped > LW_RUN_JUMPS && (t - first)*most_jumps < LW_RUN_JUMPS*all)
            return lw_run_slides(run, t);
    }
    double since = run->n_jumped > 0 ? t - run->jumped[(run->n_jumped - 1) % LW_RUN_JUMPS] : INFINITY;
    if (run->n_near < most_near)
        return LW_OK;
    run->n_near = 0;
    bool steady = run->near[1] <= 2*run->near[0] && run->near[0] <= 2*run->near[1];       /* else the motion comes to the jump, or leaves it */
    run->n_steady = steady ? run->n_steady + 1 : 0;
    return steady && (since < lately*all || run->n_steady >= most_steady) ? lw_run_slides(run, t) : LW_OK;
}

double lw_run_kink_ahead(lw_run *run, double t, const double *y)
{
    const lw_equations *eq = &run->d->eq;
    eq->place_states(eq->context, y + lw_run_states(run));
    return lw_kinks_ahead(run->kinks, t, y, y + eq->n_q);
}

bool lw_run_pass_kinks(lw_run *run, double t, const double *y, bool event)
{
    const lw_equations *eq = &run->d->eq;
    if (!run->kinks)
        return false;
    eq->place_states(eq->context, y + lw_run_states(run));
    return lw_kinks_pass(run->kinks, t, y, y + eq->n_q, event);
}

double lw_run_energy(const lw_run *run, const double *y)
{
    const lw_dynamics *d = run->d;
    double potential = d->eq.potential(d->eq.context, y);
    return d->eq.kinetic(d->eq.context, y + d->n_q) + potential - (run->has_work ? y[d->n_q + d->n_v] : 0);
}

/* A linkage at rest moves by the errors allowed alone: its energy changes by theirs, and by the rounding of its coordinates. */
static const double rounded = 1e-13;         /* of coordinates after a step, over the greatest one */

/* farthest: the least distance that counts as the greatest coordinate. */
static double rounded_energy(const lw_dynamics *d, const double *q, const double *forces, double farthest)
{
    double force = 0;
    for (int i = 0; i < d->n_q; i++)
        farthest = fmax(farthest, fabs(q[i]));
    for (int i = 0; i < d->n_v; i++)
        force += fabs(forces[i]);
    return rounded*farthest*force;
}

/* The kinetic energy of the velocities allowed as errors; v: scratch (n_v). */
static double least_kinetic(const lw_dynamics *d, double *v)
{
    for (int i = 0; i < d->n_v; i++)
        v[i] = d->o.absolute;
    return d->eq.kinetic(d->eq.context, v);
}

double lw_run_energy_error(const lw_run *run, double times, const double *y, double *scratch)
{
    const lw_dynamics *d = run->d;
    double scale = fmax(run->r->energy_scale, d->eq.kinetic(d->eq.context, y + d->n_q));
    double least = least_kinetic(d, scratch) + rounded_energy(d, y, d->force, 0);
    return times*(d->o.relative + d->o.absolute)*scale + 2*sqrt(scale*least) + least;
}

/* A period that is measured and repeated is off by this part, plus this share of the tolerance. */
static const double period_rounded = 1e-13, period_share = 0.01;
static const double least_known = 0.1;       /* phase or turn [rad] to which a sample must be known: one digit */

/* How accurate is the phase of a sample at m->t?  LW_E_ARG: it has no digit left. */
static lw_status check_phase(lw_run *run, const lw_moment *m)
{
    const lw_dynamics *d = run->d;
    lw_dynamics_report *r = run->r;
    double fastest = lw_greatest(d->n_v, m->v), periods = r->period > 0 ? (m->t - d->o.from)/r->period : 0;
    double off = DBL_EPSILON*fabs(m->t)*fastest;
    run->refused = true;                                 /* no formulation knows more */
    if (!(off < least_known))
        return lw_error_set(run->e, LW_E_ARG, "t = %.9g s has too few digits: the linkage moves by %.3g, in radians "
                            "or multiples of its size, while t grows by its last digit", m->t, off);
    off = periods*(period_rounded + period_share*d->o.relative);
    r->period_off = fmax(r->period_off, off);
    if (!(off < least_known))
        return lw_error_set(run->e, LW_E_ARG, "at t = %.9g s, after %.3g periods, the phase is known to %.2g periods "
                            "only, less than one digit: give an earlier end or a smaller tolerance", m->t, periods, off);
    run->refused = false;
    return LW_OK;
}

/* Samples of two formulations that differ by more are of different motions: chaos, or a branch. */
static const double same = 1e-7, far_apart = 1e4;

/* A posture whose constraints are off by more is none. */
static const double most_off = 1e-6, far_off = 1e3;

/* Work is integrated with the motion, and impacts count as work.  So kinetic and potential energy less the work are constant up to
 * the errors of the steps.  A far greater error shows a wrong motion, for instance on another assembly mode.  Not checked: alpha,
 * which sums the work by trapeziums; capture, which may take impacts late; elastic links and clearance joints, whose fast
 * vibrations implicit methods damp; prescribed motion, which integrates nothing; statics of contacts,
 * which damps the motion. */
static const double least_energy_off = 0.01; /* part of the energy exchanged below which there is no error yet */
static const double most_energy_off = 100;   /* greatest error, over that of all steps at the tolerance; examples reach 4 */
#define ENERGY_STEPS 1000.0           /* error over that of one step from which the report says so */

static bool knows_energy(const lw_run *run)
{
    lw_formulation f = run->r->formulation;
    return run->n_noted > 0 && run->d->o.analysis != LW_ANALYSIS_STATIC && f != LW_FORMULATION_ALPHA && f != LW_FORMULATION_CAPTURE
        && !run->d->elastic && !run->d->eq.next_piece;
}

static lw_status check_energy(lw_run *run, const lw_moment *m)
{
    lw_dynamics *d = run->d;
    lw_dynamics_report *r = run->r;
    double scale = fmax(r->energy_scale, fmax(m->kinetic, run->work_done)), step = (d->o.relative + d->o.absolute)*scale;
    double off = fmax(r->energy_error, fabs(m->kinetic + m->potential - m->work - run->energy0));
    if (!knows_energy(run) || off <= ENERGY_STEPS*step)
        return LW_OK;
    d->eq.forces(d->eq.context, m->t, m->q, m->v, d->hold, NULL);
    double noise = rounded_energy(d, m->q, d->hold, 1), least = least_kinetic(d, d->hold);
    step += 2*sqrt(scale*least) + least + noise;
    r->energy_steps = fmax(r->energy_steps, off > ENERGY_STEPS*step ? off/step : 0);
    return off <= fmax(least_energy_off*scale, most_energy_off*(double)run->n_noted*step) ? LW_OK
         : lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the energy is off by %.3g J of %.3g J, far more than steps at this tolerance explain: "
                        "the motion is not that of the model; another tolerance or formulation may find it", m->t, off, scale);
}

/* Every sample of a run is handed out here.  LW_E_NUMERIC: its posture is none, its energy is wrong, or it does not go on from those
 * of an earlier formulation. */
static lw_status hand_out(lw_run *run, const lw_moment *m)
{
    lw_status s = check_phase(run, m);
    if (s != LW_OK)
        return s;
    lw_dynamics_report *r = run->r;
    bool known = true;
    for (int i = 0; i < run->d->n_c; i++)
        known &= isfinite(m->l[i]) != 0;
    if (!known && r->without_forces++ == 0)
        r->without_forces_t = m->t;
    r->jams = r->jams || (!known && run->d->jams);
    if (!(m->off <= most_off + far_off*run->d->o.relative))
        return lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the constraints are off by %.3g of the size of the linkage", m->t, m->off);
    if ((s = check_energy(run, m)) != LW_OK)
        return s;
    r->samples++;
    r->worst_off = fmax(r->worst_off, m->off);
    r->worst_off_rate = fmax(r->worst_off_rate, m->off_rate);
    if (r->samples <= run->shown) {
        double off = 0;
        for (int i = 0; i < run->d->n_q && r->samples == run->shown; i++)
            off = fmax(off, fabs(m->q[i] - run->last_shown[i]));
        return off <= same + far_apart*run->d->o.relative ? LW_OK
             : lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the motion is another one than by the formulation before", m->t);
    }
    if (run->last_shown)
        memcpy(run->last_shown, m->q, (size_t)run->d->n_q*sizeof *m->q);
    s = run->sink ? run->sink(run->context, m) : LW_OK;
    run->refused = s != LW_OK;
    return s;
}

/* A sample without forces; its work contains that of impulses of drives. */
static lw_status measure(lw_run *run, double t, const double *y, lw_moment *m)
{
    const lw_dynamics *d = run->d;
    lw_status s = lw_mbs_measure(run->d, t, y, y + d->n_q, (run->has_work ? y[d->n_q + d->n_v] : 0) + run->impulse_work, m);
    if (s == LW_OK && run->pushed)
        m->work = m->kinetic + m->potential - run->energy0;
    return s;
}

lw_status lw_run_show(lw_run *run, double t, const double *y)
{
    lw_dynamics *d = run->d;
    lw_moment m;
    lw_error was = *run->e;
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    lw_status s = measure(run, t, y, &m);
    if (s == LW_OK && run->solve_sample && run->solve_sample(run->solver, t, m.q, m.v) == LW_OK)
        return hand_out(run, &m);
    if (s == LW_OK)
        s = lw_mbs_moment_forces(d, &m);
    if (s == LW_OK && d->touch)
        lw_mbs_touch_spread(d, m.v, d->l);
    bool touches = d->touch || d->n_resting;             /* what holds now may not hold around it */
    double apart = s == LW_OPEN ? 0 : d->by_rank ? d->rank_of.weakest : sqrt(d->weak);
    bool jams = s == LW_E_NUMERIC && d->n_friction && !d->touch && apart < LW_SINGULAR_NEAR;
    if (jams)                                            /* the motion goes on, and only this sample has no forces */
        *run->e = was, s = LW_OPEN;
    if ((s == LW_OK || (s == LW_OPEN && !jams)) && apart < LW_SINGULAR_NEAR && !touches && !d->large)
        s = lw_run_singular_forces(run, t, y);
    else if (s == LW_OPEN) {
        for (int i = 0; i < d->n_v; i++)
            d->a[i] = NAN;
        for (int i = 0; i < d->n_c; i++)
            d->l[i] = NAN;
    }
    return s == LW_OK || s == LW_OPEN ? hand_out(run, &m) : s;
}

lw_status lw_run_show_solved(lw_run *run, double t, const double *y)
{
    lw_dynamics *d = run->d;
    lw_moment m;
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    lw_status s = measure(run, t, y, &m);
    bool still = d->o.analysis == LW_ANALYSIS_QUASISTATIC;
    if (still || run->r->formulation == LW_FORMULATION_DRIVEN) {      /* nothing is integrated: the work is the change of the energies */
        double energy = m.potential + (still ? 0 : m.kinetic);
        run->energy0 = run->r->samples == 0 ? energy : run->energy0;
        m.work = energy - run->energy0;
    }
    if (s == LW_OK)
        lw_mbs_least_norm(d, d->l);
    return s == LW_OK ? hand_out(run, &m) : s;
}

/* Does the solver know all of the sample at t itself, after a step to t_end? */
static bool is_whole(lw_run *run, double t, double t_end, lw_moment *m)
{
    return run->whole_sample && !run->keeps_momenta && run->whole_sample(run->solver, t, t_end, m) == LW_OK;
}

lw_status lw_run_samples(lw_run *run, double t, lw_run_state_at *state_at, void *context)
{
    lw_status s = LW_OK;
    while (s == LW_OK && run->next <= run->d->o.intervals) {
        double at = lw_run_time(run->d, run->next);
        if (at > t)
            break;
        lw_moment m;
        if (is_whole(run, at, t, &m))
            s = hand_out(run, &m);
        else {
            s = state_at(context, at, run->y);
            if (s == LW_OK && run->keeps_momenta)        /* between steps, too */
                run->d->eq.keep_momenta(run->d->eq.context, at, run->y, run->y + run->d->n_q, run->d->hold);
            if (s == LW_OK || s == LW_OPEN)
                s = lw_run_show(run, at, run->y);
        }
        run->next += s == LW_OK;             /* a sample that failed may come from another step */
    }
    return s;
}

/* Does the speed of a drive jump between these times?  Then the work of its impulse is what the energies change by. */
static void find_push(lw_run *run, double before, double after)
{
    static const double least = 1e-9;
    double from[3], to[3];
    for (int i = 0; i < run->d->n_driven; i++)
        if (lw_mbs_motion(run->d, i, before, from) == LW_OK && lw_mbs_motion(run->d, i, after, to) == LW_OK)
            run->pushed = run->pushed || fabs(to[1] - from[1]) > least*fmax(1, fabs(from[1]));
}

lw_status lw_run_pass_kink(lw_run *run, double *t, lw_run_state_at *state_at, void *context)
{
    double after = lw_timed_behind(&run->timed);
    find_push(run, *t, after);
    lw_status s = state_at ? lw_run_samples(run, after, state_at, context) : LW_OK;
    *t = after;
    return s;
}

static void note_start(lw_run *run, const double *y)
{
    lw_dynamics *d = run->d;
    run->potential0 = d->eq.potential(d->eq.context, y);
    run->energy0 = run->potential0 + d->eq.kinetic(d->eq.context, y + d->n_q) - (run->has_work ? y[d->n_q + d->n_v] : 0);
    run->impulse_work = 0;
    double size = 0;
    if (d->eq.note_momenta)
        d->eq.note_momenta(d->eq.context, d->o.from, y, y + d->n_q);
    run->momentum0 = d->eq.momentum ? d->eq.momentum(d->eq.context, y, y + d->n_q, &size) : 0;
    run->r->momentum_scale = d->eq.momentum ? fmax(size, 1e-300) : 0;
    run->next = 0;
    lw_run_watch(run, y);
    run->next = 1;
    run->pulse_t[0] = run->pulse_t[1] = INFINITY;
    if (run->pulses)
        limit_by_pulses(run, d->o.from, y);
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    if (run->kinks)
        lw_kinks_start(run->kinks, fmax(d->o.relative, d->o.absolute), d->o.from, y, y + d->n_q);
    run->timed = (lw_timed){ .expressions = d->eq.expressions, .context = d->eq.context, .from = d->o.from, .to = d->o.to,
                              .kink = d->o.from, .calm = d->o.from };
}

lw_status lw_run_begin(lw_run *run, const double *y)
{
    const double t = run->d->o.from;
    lw_moment m;
    note_start(run, y);
    return is_whole(run, t, t, &m) ? hand_out(run, &m) : lw_run_show(run, t, y);
}

lw_status lw_run_begin_solved(lw_run *run, const double *y)
{
    note_start(run, y);
    return lw_run_show_solved(run, run->d->o.from, y);
}

lw_status lw_formulation_say(lw_dynamics_report *r, lw_status status, int unknowns, const char *why)
{
    r->unknowns = unknowns;
    snprintf(r->why, sizeof r->why, "%s", why);
    return status;
}
