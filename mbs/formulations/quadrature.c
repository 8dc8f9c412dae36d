/* mbs/formulations/quadrature.c - one freedom and forces that depend on the posture alone: time is an integral.
 *
 *     K(s) = K0 + int Q ds,      t(s) = t0 + int sqrt(M/(2 K)) ds
 *
 * with K the kinetic energy, M(s) the mass and Q(s) the force of the coordinate.  Both integrals are taken panel by
 * panel (mbs/ode/panel_internal.h); a panel is as long as sixteen values resolve.  Where K falls to 0, at s*, the
 * linkage stands and turns back: with s = s* - a u^2 the second integral is smooth in u, and one panel holds the
 * motion to s* and back. */
#include "base/real.h"
#include "mbs/formulations/formulations_internal.h"
#include "mbs/formulations/input_panel_internal.h"

#include <stdlib.h>

enum { N = LW_PANEL_NODES };

static const double finest = 2e-14;          /* unresolved part that rounding leaves */
static const double shortest = 1e-7;         /* panel, in units of the coordinate */
static const double near_end = 0.02;         /* of its range: nearer to it, other coordinates go on */
static const double end_error = 2;           /* allowed error of K between the outermost node and the end of a panel, over the tolerance */
static const double rest_error = 1e3;        /* allowed relative error of the force at s*, over the tolerance */

typedef struct quadrature {
    lw_run        *run;
    lw_reduced    *r;
    const lw_panel_rule *rule;
    double s, sense, t, kinetic, work, length; /* where the next panel begins; its proposed length */
    double force;                            /* at s */
    double least_mass, most, kinetic0, potential0, tolerance;     /* most: greatest K so far */
    double *turns;                           /* of the bodies there (n_body) */
    int    n_rest;                           /* number of rests on the upper side of the coordinate */
    double first_rest;
    lw_turn_count count;                     /* at s */
    double top[2];                           /* where it turned last, falling and rising; NaN: not yet */
    lw_input_panel p;
} quadrature;

/* ---- one panel ------------------------------------------------------------------------------------ */

static lw_status evaluate(quadrature *z, double s, int i)
{
    lw_input_panel *p = &z->p;
    double ds, dp, power;
    lw_status st = lw_run_busy(z->run, z->t);
    if (st == LW_OK)
        st = lw_reduced_rate(z->r, 0, s, 1, &ds, &dp, &power);
    if (st != LW_OK)
        return st;
    z->run->r->rates++;
    lw_reduced_count_turns(z->r);
    p->mass[i] = 1/(ds*ds);
    p->force[i] = dp/ds;
    p->other[i] = power/ds;
    lw_input_panel_note_rates(p, z->r, i);
    return p->mass[i] > LW_REDUCED_TURNING_BACK*z->least_mass ? LW_OPEN : LW_OK;
}

/* Values of a panel of length `step` from `from`. */
static lw_status fill(quadrature *z, double from, double step)
{
    lw_status st = LW_OK;
    if (z->r->counts_turns)
        z->r->count = z->count;
    for (int i = 0; i < N && st == LW_OK; i++)
        st = evaluate(z, from + step*z->rule->at[i], i);
    z->p.ready = false;
    return st;
}

static lw_status force_at(quadrature *z, double s, double *force)
{
    double ds, dp, power;
    lw_status st = lw_reduced_rate(z->r, 0, s, 1, &ds, &dp, &power);
    z->run->r->rates++;
    *force = dp/ds;
    return st;
}

/* Does the polynomial through the forces at the nodes have the force at an end of the panel (weight: rule->begin or ->end), where K is
 * `kinetic`?  No node shows a jump of the force between that end and the outermost node. */
static bool matches_force(const quadrature *z, const double *weight, double force, double kinetic)
{
    return fabs(lw_panel_sum(weight, z->p.force) - force)*z->rule->at[0]*z->p.length <= end_error*z->tolerance*kinetic;
}

/* The same at s*, where K is 0. */
static bool matches_at_rest(quadrature *z)
{
    double force;
    return force_at(z, z->p.from, &force) == LW_OK
        && fabs(lw_panel_sum(z->rule->begin, z->p.force) - force) <= rest_error*z->tolerance*fabs(force);
}

/* Factor of the length that would make the unresolved part of f as large as allowed. */
static double length_factor(const quadrature *z, double tail)
{
    double by = 0.95*pow(z->tolerance/fmax(tail, 1e-3*finest), 1.0/N);
    return by < 0.25 ? 0.25 : by > 2 ? 2 : by;
}

/* ---- to where it turns back, and from there ------------------------------------------------------------ */

/* Pace of a turning panel whose values are known; false: K does not rise from s*, or the pace is not resolved. */
static bool pace_turning(quadrature *z, double *tail)
{
    lw_input_panel *p = &z->p;
    double h[N], k[N];
    for (int i = 0; i < N; i++)
        h[i] = -p->sense*p->force[i];
    lw_panel_apply(&z->rule->mean, h, k);
    for (int i = 0; i < N; i++) {
        if (!(k[i] > 0))
            return false;
        p->pace[i] = sqrt(2*p->length*p->mass[i]/k[i]);
    }
    *tail = lw_panel_tail(z->rule, p->pace);
    return *tail <= z->tolerance;
}

static double half_time(const quadrature *z)
{
    double root[N], c[N];
    lw_panel_apply(&z->rule->root, z->p.pace, root);
    lw_panel_apply(&z->rule->coef, root, c);
    return lw_panel_value(c, 1);
}

/* Values of the panel between s* = top and `length` from it, reached or left in the direction sense. */
static lw_status fill_turning(quadrature *z, double top, double sense, double length)
{
    lw_input_panel *p = &z->p;
    p->turning = true;
    p->from = top;
    p->sense = sense;
    p->length = length;
    return fill(z, top, -sense*length);
}

/* A panel from the present place to s*, which is near `guess`, and back.  LW_NOTHING: one panel does not hold it. */
static lw_status turning_panel(quadrature *z, double guess)
{
    lw_input_panel *p = &z->p;
    double top = guess, tail, before = z->kinetic, *last = &z->top[z->sense > 0];
    if (fabs(*last - guess) < 0.5*z->length)
        top = *last;                             /* the same place again, but for rounding */
    for (int k = 0;; k++) {
        double length = z->sense*(top - z->s);
        if (!(length > 0) || length > 4*z->length || k == 12)
            return LW_NOTHING;
        lw_status st = fill_turning(z, top, z->sense, length);
        double slope = -z->sense*p->force[0], off = z->kinetic + z->sense*length*lw_panel_sum(z->rule->whole, p->force);
        if (st != LW_OK || !(slope > 0))
            return st == LW_OK || st == LW_OPEN ? LW_NOTHING : st;
        if (fabs(off) <= 4e-16*z->kinetic || fabs(off/slope) <= 2e-16*fabs(top))
            break;
        if (fabs(off) > 0.5*before && fabs(off) > 1e-13*z->kinetic)
            return LW_NOTHING;               /* it does not turn back here */
        before = fabs(off);
        top += z->sense*off/slope;
    }
    if (!pace_turning(z, &tail) || !matches_force(z, z->rule->end, z->force, z->kinetic) || !matches_at_rest(z))
        return LW_NOTHING;
    *last = top;
    p->begin = -1;
    p->t_end = z->t + 2*half_time(z);
    z->length = p->length*length_factor(z, tail);
    z->sense = -z->sense;
    return LW_OK;
}

/* K at x of a turning panel */
static double kinetic_at(const quadrature *z, double x)
{
    double q[N], c[N];
    lw_panel_apply(&z->rule->mean, z->p.force, q);
    lw_panel_apply(&z->rule->coef, q, c);
    return -z->p.sense*z->p.length*x*lw_panel_value(c, x);
}

/* A panel out of rest, or nearly so: from s*, a little behind the present place, by the force there. */
static lw_status panel_from_rest(quadrature *z)
{
    lw_input_panel *p = &z->p;
    double force = z->force, sense = force > 0 ? 1 : -1, back = z->kinetic/fabs(force), tail = 1, end, root[N], c[N];
    for (int k = 0; k < 60; k++) {
        lw_status st = fill_turning(z, z->s - sense*back, -sense, z->length);
        if (st == LW_OK && pace_turning(z, &tail)) {
            double off = back > 0 ? z->kinetic - kinetic_at(z, back/z->length) : 0;
            if (fabs(off) > 1e-15*z->kinetic && k <= 50)
                back += off/fabs(lw_panel_sum(z->rule->begin, p->force));        /* the force at s* */
            else if (fabs(off) <= 1e-13*z->kinetic && force_at(z, p->from + sense*p->length, &end) == LW_OK
                     && matches_force(z, z->rule->end, end, kinetic_at(z, 1)) && matches_at_rest(z))
                break;
            else
                z->length *= 0.5;
        } else if (st != LW_OK && st != LW_OPEN) {
            return st;
        } else {
            z->length *= st == LW_OK ? length_factor(z, fmax(tail, z->tolerance)) : 0.5;
        }
        if (z->length < shortest*z->r->scale || k == 59)
            return LW_OPEN;
    }
    p->begin = sqrt(back/p->length);
    lw_panel_apply(&z->rule->root, p->pace, root);
    lw_panel_apply(&z->rule->coef, root, c);
    p->t_end = z->t + lw_panel_value(c, 1) - p->begin*lw_panel_value(c, back/p->length);
    z->s = p->from + sense*p->length;
    z->sense = sense;
    z->kinetic = kinetic_at(z, 1);
    z->length = p->length*length_factor(z, tail);
    return LW_OK;
}

/* ---- straight on -------------------------------------------------------------------------------------- */

/* Where K comes to 0: between two of its values, or by its slope and curvature behind the end, within one length of
 * the panel.  false: not there. */
static bool guess_turn(const quadrature *z, const double *kinetic, double end, double *guess)
{
    const lw_input_panel *p = &z->p;
    const double *x = z->rule->at;
    double before = z->kinetic, from = 0;
    for (int i = 0; i < N; i++) {
        if (kinetic[i] <= 0) {               /* on the polynomial through the forces, whose panel need not resolve the pace */
            double c[N], q[N], force[N], at = from + (x[i] - from)*before/(before - kinetic[i]), off = 1;
            lw_panel_apply(&z->rule->mean, p->force, q);
            lw_panel_apply(&z->rule->coef, q, c);
            lw_panel_apply(&z->rule->coef, p->force, force);
            for (int k = 0; k < 6 && fabs(off) > 1e-16; k++) {
                off = z->kinetic/(z->sense*z->length) + at*lw_panel_value(c, at);
                off /= lw_panel_value(force, at);
                at = fmin(fmax(at - off, from), x[i]);
            }
            *guess = z->s + z->sense*z->length*at;
            return true;
        }
        before = kinetic[i];
        from = x[i];
    }
    double fall = -z->sense*p->force[N - 1]*z->length;
    double bend = z->sense*(p->force[N - 1] - p->force[N - 2])/(x[N - 1] - x[N - 2])*z->length;
    double under = fall*fall - 2*bend*end, on = under > 0 ? 2*end/(fall + sqrt(under)) : -1;
    *guess = z->s + z->sense*z->length*(1 + on);
    return end <= 0 || (fall > 0 && on >= 0 && on < 1);
}

/* Pace of a panel whose values are known; false: not resolved.  *turns: it may turn back, near *guess. */
static bool pace_on(quadrature *z, double *tail, bool *turns, double *guess)
{
    lw_input_panel *p = &z->p;
    double q[N], kinetic[N], low, end = z->kinetic + z->sense*z->length*lw_panel_sum(z->rule->whole, p->force);
    lw_panel_apply(&z->rule->mean, p->force, q);
    low = end;
    for (int i = 0; i < N; i++) {
        kinetic[i] = z->kinetic + z->sense*z->length*z->rule->at[i]*q[i];
        low = fmin(low, kinetic[i]);
        p->pace[i] = sqrt(p->mass[i]/(2*kinetic[i]));
    }
    *tail = low > 0 ? lw_panel_tail(z->rule, p->pace) : 1;
    *turns = (low < 0.6*z->kinetic || *tail > z->tolerance) && guess_turn(z, kinetic, end, guess);
    if (*tail <= z->tolerance)
        p->t_end = z->t + z->length*lw_panel_sum(z->rule->whole, p->pace);
    return *tail <= z->tolerance;
}

/* The same at both ends of a straight panel. */
static bool matches_both_ends(quadrature *z)
{
    const lw_input_panel *p = &z->p;
    double end, kinetic = z->kinetic + p->sense*p->length*lw_panel_sum(z->rule->whole, p->force);
    return matches_force(z, z->rule->begin, z->force, z->kinetic) && force_at(z, p->from + p->sense*p->length, &end) == LW_OK
        && matches_force(z, z->rule->end, end, kinetic);
}

static lw_status straight_panel(quadrature *z)
{
    lw_input_panel *p = &z->p;
    double tail, guess;
    bool turns, tried = false;
    lw_status st = LW_OK;
    for (int k = 0; k < 100 && z->length > (st == LW_OPEN ? near_end : shortest)*z->r->scale; k++) {
        p->turning = false;
        p->from = z->s;
        p->sense = z->sense;
        p->length = z->length;
        st = fill(z, z->s, z->sense*z->length);
        if (st != LW_OK && st != LW_OPEN)
            return st;
        bool resolved = st == LW_OK && pace_on(z, &tail, &turns, &guess);
        if (resolved && !matches_both_ends(z)) {
            resolved = false;
            tail = 1;
        }
        if (st == LW_OK && turns && !tried) {
            st = turning_panel(z, guess);
            if (st != LW_NOTHING)
                return st;
            tried = tail < 1;
            z->length *= resolved ? 1 : tail < 1 ? length_factor(z, tail) : 0.5;
        } else if (resolved) {
            p->begin = 0;
            z->kinetic += z->sense*z->length*lw_panel_sum(z->rule->whole, p->force);
            z->s += z->sense*z->length;
            z->length *= length_factor(z, tail);
            return LW_OK;
        } else {
            z->length *= st == LW_OK && tail < 1 ? fmin(length_factor(z, tail), k ? 0.7 : 1) : 0.5;
        }
    }
    return LW_OPEN;
}

/* ---- the run ------------------------------------------------------------------------------------------ */

/* Check the energy at the end of the panel by the posture there, and note the force there. */
static lw_status watch(quadrature *z)
{
    double ds, dp, power;
    lw_status st = lw_reduced_rate(z->r, 0, z->s, 1, &ds, &dp, &power);
    if (st != LW_OK)
        return st;
    if (z->r->counts_turns) {
        lw_reduced_count_turns(z->r);
        z->count = z->r->count;
    }
    double change = lw_reduced_potential(z->r, z->s) - z->potential0, off = z->kinetic - z->kinetic0 + change - z->work;
    lw_dynamics_report *r = z->run->r;
    lw_run_note_energy(z->run, z->kinetic, change, z->work, z->kinetic0);
    /* rounding would add up over many panels; where K is small, this K is better than the one from the potential */
    bool known = z->kinetic < z->most && z->kinetic > 0.1*z->most;
    z->most = fmax(z->most, z->kinetic);
    if (!z->run->has_work && known) {
        z->kinetic -= off;
        r->energy_held += fabs(off);
    }
    z->least_mass = fmin(z->least_mass, 1/(ds*ds));
    z->force = dp/ds;
    return LW_OK;
}

static lw_status state_at(void *context, double t, double *y)
{
    quadrature *z = context;
    return lw_input_panel_state(&z->p, z->run, z->r, t, z->turns, 1, y);
}

static lw_status next_panel(quadrature *z)
{
    lw_input_panel *p = &z->p;
    double force = z->force;
    p->t = z->t;
    p->kinetic = z->kinetic;
    p->work = z->work;
    bool leaves_rest = z->kinetic <= 0.05*fabs(force)*z->length && z->sense*force >= 0;
    if (leaves_rest && force == 0)
        return LW_OPEN;
    lw_status st = leaves_rest ? panel_from_rest(z) : straight_panel(z);
    if (st != LW_OK)
        return st;
    if (!p->turning)
        z->work += p->sense*p->length*lw_panel_sum(z->rule->whole, p->other);
    else if (p->begin >= 0)
        z->work -= p->sense*p->length*(lw_panel_sum(z->rule->whole, p->other) - lw_input_panel_work(p, z->r, p->begin*p->begin));
    z->t = p->t_end;
    return LW_OK;
}

static void advance_turns(quadrature *z)
{
    for (int b = 0; b < z->run->d->s.n_body && !(z->p.turning && z->p.begin < 0); b++)
        z->turns[b] += lw_input_panel_turned(&z->p, b, 1);
}

/* A motion that came to rest goes back the same way and repeats itself.  Leave out whole periods without samples,
 * once enough periods were measured that rounding does not add up. */
static void leave_out_periods(quadrature *z)
{
    enum { MEASURED = 10 };
    const lw_input_panel *p = &z->p;
    const lw_run *run = z->run;
    if (!p->turning || p->begin >= 0 || p->sense < 0)
        return;
    double rest = p->t + 0.5*(p->t_end - p->t), *period = &run->r->period;
    if (z->n_rest++ == 0)
        z->first_rest = rest;
    if (z->n_rest == MEASURED + 1)
        *period = (rest - z->first_rest)/MEASURED;
    double next = run->next <= run->d->o.intervals ? lw_run_time(run->d, run->next) : run->d->o.to;
    if (*period > 0 && next - z->t > *period)
        z->t += *period*floor((next - z->t)/ *period);
}

static lw_status run_panels(quadrature *z)
{
    lw_run *run = z->run;
    double to = run->d->o.to;
    lw_status st = watch(z);
    for (long k = 1; st == LW_OK && z->t < to; k++) {
        st = next_panel(z);
        if (st != LW_OK)
            break;
        run->r->steps++;
        run->r->t = fmin(z->t, to);
        st = lw_run_samples(run, z->p.t_end, state_at, z);
        advance_turns(z);
        leave_out_periods(z);
        if (st == LW_OK)
            st = watch(z);
        if (st == LW_OK)
            st = lw_run_limits(run, run->r->t, 0);
    }
    return st;
}

/* The state of the bodies where the panels end, to go on from there in their coordinates. */
static void leave(quadrature *z, double *y)
{
    const lw_dynamics *d = z->run->d;
    double mass;
    z->run->r->t = z->t;
    if (lw_reduced_mass(z->r, z->s, &mass) != LW_OK)
        return;
    for (int b = 0; b < d->s.n_body; b++)
        y[3*b + 2] = z->turns[b];
    lw_reduced_state(z->r, d, z->sense*sqrt(2*z->kinetic/mass), y, y + d->n_q);
    if (z->run->has_work)
        y[2*d->n_q] = z->work;
}

static lw_status start(quadrature *z, double *y)
{
    const lw_dynamics *d = z->run->d;
    double p;
    lw_dynamics_start(d, y, y + d->n_q);
    lw_status st = lw_reduced_start(z->r, d, y, &z->s, &p);
    if (st == LW_OK)
        st = lw_reduced_mass(z->r, z->s, &z->least_mass);
    if (st != LW_OK)
        return st;
    z->potential0 = lw_reduced_potential(z->r, z->s);
    z->kinetic = z->kinetic0 = 0.5*p*p;
    z->sense = p < 0 ? -1 : p > 0;
    z->t = d->o.from;
    z->length = 0.5*z->r->scale;
    z->top[0] = z->top[1] = NAN;
    z->tolerance = fmax(10*d->o.relative, finest);
    for (int b = 0; b < d->s.n_body; b++)
        z->turns[b] = y[3*b + 2];
    return lw_run_begin(z->run, y);
}

static lw_status run_quadrature(lw_run *run)
{
    size_t n = (size_t)run->n, n_body = (size_t)run->d->s.n_body;
    quadrature *z = calloc(1, sizeof *z);
    double *y = calloc(2*n + n_body, sizeof *y);
    if (!z || !y) {
        free(z), free(y);
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    }
    z->rule = z->p.rule = run->d->rule;
    z->run = run;
    z->r = run->d->reduced;
    z->turns = y + 2*n;
    run->y = y + n;
    lw_status st = start(z, y);
    if (st == LW_OK)
        st = run_panels(z);
    if (st == LW_OPEN || st == LW_E_NUMERIC) {
        leave(z, y);
        st = lw_run_go_on(run, y);
    }
    free(z), free(y);
    return st;
}

/* ---- can it do the model? ------------------------------------------------------------------------------- */

static bool of_length_alone(const lw_expression *law)
{
    const int *which;
    int n = law ? lw_expression_variables(law, &which) : 0;
    return n == 0 || (n == 1 && which[0] == lw_variable(LW_QUANTITY_LENGTH, 0));
}

static bool constant(const lw_expression *x)
{
    const int *which;
    return !x || lw_expression_variables(x, &which) == 0;
}

/* Do the forces depend on the posture alone? */
static bool by_posture(const lw_dynamics *d)
{
    const lw_model *m = d->model;
    bool yes = m->n_motor == 0 && !d->f.caller.apply && d->n_driven == 0 && d->n_friction == 0;
    for (int i = 0; i < m->n_spring; i++)
        yes = yes && m->spring[i].damping == 0 && of_length_alone(m->spring[i].law);
    for (int i = 0; i < m->n_joint_spring; i++)
        yes = yes && m->joint_spring[i].damping == 0 && of_length_alone(m->joint_spring[i].law);
    for (int i = 0; i < m->n_force; i++)
        yes = yes && constant(m->force[i].force[0]) && constant(m->force[i].force[1]) && constant(m->force[i].torque[2]);
    return yes;
}

/* Do no laws of springs have a pulse, as a detent has, between lengths or angles of this size?  Panels could pass over one. */
static bool have_no_pulse(const lw_dynamics *d)
{
    const double most = 10*fmax(1, d->s.unit);
    const lw_model *m = d->model;
    bool yes = true;
    for (int i = 0; i < m->n_spring + m->n_joint_spring; i++) {
        bool pin = i >= m->n_spring;
        const lw_expression *law = pin ? m->joint_spring[i - m->n_spring].law : m->spring[i].law;
        double from = pin ? -most : 0;
        yes = yes && (!law || lw_expression_calm(law, lw_variable(LW_QUANTITY_LENGTH, 0), false, from, from, most, 1e-3*most) == most);
    }
    return yes;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    lw_status s = lw_reduced_able(d);
    if (s != LW_OK)
        return lw_formulation_say(r, s, 0, d->not_reduced);
    if (!by_posture(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "forces depend on time or speed");
    if (d->eq.n_kink + d->eq.n_jump > 0)
        return lw_formulation_say(r, LW_E_KIND, 0, "the law of a spring has kinks, at which its panels do not end");
    if (!have_no_pulse(d))
        return lw_formulation_say(r, LW_E_KIND, 0, "the law of a spring changes too fast for its panels");
    if (lw_input_panel_rule(d) != LW_OK)
        return lw_formulation_say(r, LW_E_MEMORY, 0, "out of memory");
    return lw_formulation_say(r, LW_OK, 1, asked ? "asked for"
                              : "one freedom, rigid, forces by the posture alone: time is an integral over one coordinate");
}

const lw_formulation_row lw_formulation_quadrature = { able, run_quadrature };
