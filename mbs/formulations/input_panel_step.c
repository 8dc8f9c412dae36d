/* mbs/formulations/input_panel_step.c - panels where the forces depend on the speed, too: dampers, motors, friction.
 *
 * K at the nodes meets dK/ds = Q(s, K) at all of them (collocation at Chebyshev points).  The nodes are evaluated one after the other, at values of K
 * predicted from the nodes before (methods of Adams), and K follows from linear equations with the derivative of Q by K, at first that where
 * the panel begins.  Where its error may count, all nodes are evaluated again, which gives the derivative of each. */
#include "base/real_complex.h"
#include "mbs/formulations/input_panel_internal.h"

#include <string.h>

enum { N = LW_PANEL_NODES, SWEEPS = 4, PASSES = 60, TRIES = 20 };

static const double nudge = 1e-5;            /* of K, for the derivative by it */
static const double most_change = 4;         /* factor by which K may change in a panel */
static const double worth_while = 0.02;      /* panel, in units of the coordinate: where K changes so fast that it is shorter, steps in time do better */
static const double least_decay = 0.2;       /* length in which a difference of K decays, in the same units: where it is shorter, as with strong dampers,
                                              * panels would be shorter than steps in time */
static const double shortest = 1e-6;         /* panel, in units of the coordinate */
static const double wary = 30;               /* errors by kinks count so many times: panels that end at one need fewer evaluations in all */
static const double over_tolerance = 10;     /* error of a panel that its last coefficients show, over the tolerance */

/* Values at one place: Q, the part of it without potential, and M. */
typedef struct values { double force, other, mass; } values;

static lw_status forces_at(const lw_input_panel *p, lw_run *run, lw_reduced *r, double s, double kinetic, values *v)
{
    double ds, dp, power, root = p->sense*sqrt(2*kinetic);
    lw_status st = lw_run_busy(run, p->t);
    if (st != LW_OK)
        return st;
    st = lw_reduced_rate(r, s, s, root, &ds, &dp, &power);           /* no load depends on the time */
    run->r->rates++;
    if (st != LW_OK)
        return st == LW_E_NUMERIC ? LW_OPEN : st;
    *v = (values){ root*dp/ds, power/ds, 2*kinetic/(ds*ds) };
    return LW_OK;
}

/* Evaluate node i.  again: from the reactions of the last evaluation on. */
static lw_status evaluate(lw_input_panel *p, lw_run *run, lw_reduced *r, int i, double kinetic, bool again)
{
    lw_reduced_friction *f = r->friction;
    double s = p->from + p->sense*p->length*p->rule->at[i];
    values v;
    if (f && again)
        lw_reduced_friction_expect(f, s, p->reaction[i]);
    lw_status st = forces_at(p, run, r, s, kinetic, &v);
    if (st != LW_OK)
        return st;
    p->force[i] = v.force, p->other[i] = v.other, p->mass[i] = v.mass;
    if (r->counts_turns)
        lw_reduced_count_turns(r);
    lw_input_panel_note_rates(p, r, i);
    for (int k = 0; f && k < f->n; k++)
        p->reaction[i][k] = lw_v2(f->x[k], f->y[k]);
    return v.mass > LW_REDUCED_TURNING_BACK*p->least_mass ? LW_OPEN : LW_OK;
}

/* ---- kinks -------------------------------------------------------------------------------------------- */

/* Where the reaction of a pin falls to nearly 0, at x, its size nearly has a kink: a pair of singularities at x +- off i.  With rho the sum of
 * the half axes of the ellipse through them whose foci are the ends of the panel, the coefficients of degree n of the square root, or of
 * the kink where off is 0, fall as rho^-n; a kink beside an end adds the square of its distance from there.  Returns the error for a size that
 * changes by 1 in the panel, if it has the part `length` of its length. */
static double kink_error(double x, double off, double length)
{
    x /= length, off /= length;
    double from = hypot(x, off), to = hypot(1 - x, off), sum = from + to, near = sqrt(4*from*to), end = fmin(fabs(x), fabs(1 - x));
    double rho = sum + sqrt(fmax(sum*sum - 1, 0)), coefficient = 0.5*pow(rho, 1 - N)*fmin(1.3*near/N, sqrt(1.2*fabs(off)*near/N))/N;
    return length*length*fmin(coefficient, end*end + off*off);
}

/* The x at which the reaction of joint k is 0, near `guess`, by Newton's method on the polynomial through its values at nodes up to i, at most
 * four. */
static double complex zero_reaction(const lw_input_panel *p, int i, int k, double complex guess)
{
    int n = i < 3 ? i + 1 : 4;
    for (int pass = 0; pass < 6; pass++) {
        double complex value = 0, slope = 0;
        for (int a = i - n + 1; a <= i; a++) {
            double complex term = p->reaction[a][k].x + I*p->reaction[a][k].y, sum = 0;
            for (int b = i - n + 1; b <= i; b++)
                if (b != a) {
                    term *= (guess - p->rule->at[b])/(p->rule->at[a] - p->rule->at[b]);
                    sum += 1/(guess - p->rule->at[b]);
                }
            value += term;
            slope += term*sum;
        }
        guess -= value/slope;
    }
    return guess;
}

/* Look for kinks between nodes i - 1 and i, and beyond them at the ends of the panel, that its values need not show.  false: one adds more than
 * `allowed`; p->cut is the part of the length that suits it, which may end at the kink. */
static bool has_no_kink(lw_input_panel *p, const lw_reduced *r, int i, double allowed)
{
    const lw_reduced_friction *f = r->friction;
    const double *at = p->rule->at, gap = at[i] - at[i - 1], root = wary*sqrt(p->mass[i]), finer = 0.93;
    p->cut = 1;
    for (int k = 0; k < f->n; k++) {
        lw_vec2 a = p->reaction[i - 1][k], change = lw_v2_sub(p->reaction[i][k], a);
        double square = lw_v2_dot(change, change), side = -lw_v2_dot(a, change)/square;
        if (!(side > -0.5 && side < 1.5))
            continue;
        double size = f->feel[k]*root*sqrt(square)/gap/allowed, x = at[i - 1] + gap*side, off = gap*lw_v2_cross(a, change)/square, part = 1;
        if (size*kink_error(x, off, 1) <= 1)
            continue;
        double complex zero = zero_reaction(p, i, k, x + I*off);
        if (fabs(creal(zero) - x) < gap)
            x = creal(zero), off = cimag(zero);
        bool ends = size*kink_error(x, off, x) <= 0.5;
        while (part > 0.01 && size*kink_error(x, off, part) > 0.5 && !(ends && part <= x))
            part = ends && part > x && part*finer < x ? x : part*finer;
        p->cut = fmin(p->cut, part);
    }
    return p->cut == 1;
}

/* ---- a panel ------------------------------------------------------------------------------------------ */

static double weighted(const double *weight, const double *f, int last, double first)
{
    double sum = 0;
    for (int k = 0; k < LW_PANEL_PAST && k <= last + 1; k++)
        sum += weight[k]*(k <= last ? f[last - k] : first);
    return sum;
}

/* Evaluate all nodes at K = used[], which is predicted in the first sweep.  LW_OPEN: the panel must be shorter. */
static lw_status sweep_nodes(lw_input_panel *p, lw_run *run, lw_reduced *r, int sweep, double allowed, double *used)
{
    double now = p->kinetic, along = p->sense*p->length;
    if (r->counts_turns)
        r->count = p->count;
    for (int i = 0; i < N; i++) {
        if (sweep == 0)
            used[i] = now + along*weighted(p->rule->ahead[i], p->force, i - 1, p->force_begin);
        if (!(used[i]*most_change > p->kinetic && used[i] < most_change*p->kinetic))
            return LW_OPEN;
        lw_status st = evaluate(p, run, r, i, used[i], sweep > 0);
        if (st != LW_OK)
            return st;
        now += along*weighted(p->rule->with[i], p->force, i, p->force_begin);
        if (sweep == 0 && r->friction && i > 0 && !has_no_kink(p, r, i, allowed))
            return LW_OPEN;
    }
    return LW_OK;
}

/* Solve K - K0 = along x mean(Q + by (K - used)) at the nodes; slope: Q + by (K - used).  false: the passes do not converge. */
static bool solve_linear(const lw_input_panel *p, const double *used, const double *by, double tolerance, double *kinetic, double *slope)
{
    double mean[N], change = INFINITY;
    memcpy(slope, p->force, sizeof mean);
    memcpy(kinetic, used, sizeof mean);
    for (int pass = 0; pass < PASSES && change > 1e-3*tolerance*p->kinetic; pass++) {
        change = 0;
        lw_panel_apply(&p->rule->mean, slope, mean);
        for (int i = 0; i < N; i++) {
            double next = p->kinetic + p->sense*p->length*p->rule->at[i]*mean[i];
            change = fmax(change, fabs(next - kinetic[i]));
            kinetic[i] = next;
            slope[i] = p->force[i] + by[i]*(next - used[i]);
        }
    }
    return change <= 1e-3*tolerance*p->kinetic;
}

/* Unresolved part of Q and of the pace, over that allowed. */
static double unresolved(const lw_input_panel *p, double tolerance, double allowed)
{
    double most = 0;
    for (int i = 0; i < N; i++)
        most = fmax(most, fabs(p->force[i]));
    return fmax(lw_panel_tail(p->rule, p->pace)/tolerance, lw_panel_tail(p->rule, p->force)*most/allowed);
}

/* Values of a panel of p->length.  LW_OPEN: it must be shorter; *err tells by how much, unless it is 0. */
static lw_status fill(lw_input_panel *p, lw_run *run, lw_reduced *r, double tolerance, double allowed, double *err)
{
    double used[N], kinetic[N], by[N], slope[N], before[N], force[N];
    p->ready = p->turning = false;
    p->begin = 0;
    for (int i = 0; i < N; i++)
        by[i] = p->by_begin;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double off = 0;
        lw_status st = sweep_nodes(p, run, r, sweep, allowed, used);
        if (st != LW_OK)
            return st;
        for (int i = 0; i < N && sweep > 0; i++) {
            double change = used[i] - before[i];
            if (fabs(change) > 1e-9*p->kinetic)
                by[i] = (p->force[i] - force[i])/change;
        }
        if (!solve_linear(p, used, by, tolerance, kinetic, slope))
            return LW_OPEN;
        for (int i = 0; i < N; i++)
            p->pace[i] = sqrt(p->mass[i]/(2*kinetic[i]));
        *err = unresolved(p, tolerance, allowed);
        if (*err > (sweep > 0 ? 2 : 1e4))
            return LW_OPEN;
        /* in the first sweep by[i] may be off by itself, later by its change with K */
        for (int i = 0; i < N; i++) {
            double change = fabs(kinetic[i] - used[i]);
            off = fmax(off, fabs(by[i])*change*(sweep > 0 ? change/p->kinetic : 1));
        }
        if (off*p->length <= 0.03*tolerance*p->kinetic) {
            for (int i = 0; i < N; i++) {
                p->other[i] += slope[i] - p->force[i];       /* the rest of Q depends on the posture alone */
                p->force[i] = slope[i];
            }
            *err = unresolved(p, tolerance, allowed);
            p->kinetic_end = p->kinetic + p->sense*p->length*lw_panel_sum(p->rule->whole, p->force);
            return p->kinetic_end*most_change > p->kinetic && p->kinetic_end < most_change*p->kinetic ? LW_OK : LW_OPEN;
        }
        memcpy(before, used, sizeof before);
        memcpy(force, p->force, sizeof force);
        memcpy(used, kinetic, sizeof used);
    }
    return LW_OPEN;
}

/* Length in which K, which rises by `rise` with the way, falls to a half of itself, or rises to three times itself. */
static double reach_of(double kinetic, double rise) { return kinetic*(rise < 0 ? 0.5 : 2)/fabs(rise); }

bool lw_input_panel_suits(const lw_reduced *r, double kinetic, double rise) { return reach_of(kinetic, rise) > 2*worth_while*r->scale; }

lw_status lw_input_panel_step(lw_input_panel *p, lw_run *run, lw_reduced *r, double end)
{
    const lw_dynamics_options *o = &run->d->o;
    const double left = fabs(end - p->from), tolerance = fmax(over_tolerance*(o->relative + p->absolute/sqrt(2*p->kinetic)), 2e-14);
    values v, more;
    lw_status st = forces_at(p, run, r, p->from, p->kinetic*(1 + nudge), &more);
    if (st == LW_OK)
        st = forces_at(p, run, r, p->from, p->kinetic, &v);
    if (st != LW_OK)
        return st;
    p->force_begin = v.force;
    p->by_begin = (more.force - v.force)/(nudge*p->kinetic);
    double reach = reach_of(p->kinetic, p->sense*v.force);
    if (!(reach > worth_while*r->scale && fabs(p->by_begin)*least_decay*r->scale < 1))
        return LW_OPEN;
    reach = fmin(reach, p->next);
    double length = isinf(left) ? reach : left/ceil(left/reach);
    bool is_cut = length < p->next;          /* by something else than its own resolution */
    for (int k = 0; k < TRIES && length > shortest*r->scale; k++) {
        double err = 0, allowed = tolerance*p->kinetic/length;
        p->length = length;
        p->cut = 1;
        st = fill(p, run, r, tolerance, allowed, &err);
        if (st == LW_OK && err <= 1)
            st = forces_at(p, run, r, p->from + p->sense*length, p->kinetic_end, &v);
        if (st != LW_OK && st != LW_OPEN)
            return st;
        if (st == LW_OK && err <= 1 && fabs(lw_panel_sum(p->rule->end, p->force) - v.force)*p->rule->at[0] <= 2*allowed) {
            p->t_end = p->t + length*lw_panel_sum(p->rule->whole, p->pace);
            p->work_end = p->work + p->sense*length*lw_panel_sum(p->rule->whole, p->other);
            length *= fmin(fmax(0.95*pow(err, -1.0/N), 0.5), 2);
            p->next = is_cut ? fmax(length, p->next) : length;
            return LW_OK;
        }
        run->r->refused++;
        length *= p->cut < 1 ? p->cut : err > 1 ? fmin(fmax(0.9*pow(err, -0.1), 0.2), 0.8) : 0.5;
        is_cut = is_cut || p->cut < 1;
    }
    return LW_OPEN;
}
