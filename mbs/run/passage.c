/* mbs/run/passage.c - see passage_internal.h; and the forces in singular postures, which follow from it. */
#include "mbs/run/passage_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/vector.h"
#include "mbs/ode/integrate.h"

static const double settled = 1e-14;         /* change of the states in a pass, scaled, that ends the iteration */
static const double unsettled = 1e-9;        /* the same where rounding lets it fall no further */
static const long   most_steps = 2000;       /* of an explicit method to or in a passage; stiff loads would take more */
static const double shortest = 1e-8;         /* length of such a step over the way: towards a limit of inputs they shorten without end */
static const int    lingers = 20;            /* passes in which the change does not halve: rounding, or no convergence */

lw_status lw_passage_integrate(lw_run *run, double t, double end, double *y, bool fixed)
{
    const lw_dynamics_options *o = &run->d->o;
    lw_ode ode = { .n = run->n, .context = run, .rate = lw_run_rate, .project = lw_run_project };
    lw_ode_options each = lw_ode_options_default();
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    double *work = calloc(lw_integrate_work(run->n, 0), sizeof *work);
    if (!work)
        return LW_E_MEMORY;
    each.relative = o->relative;
    each.absolute = o->absolute;
    each.max_step = most_steps;
    each.fixed = fixed ? end - t : 0;
    lw_status s = lw_integrate_start(&w, &ode, &each, work, t, y, run->e);
    while (s == LW_OK && stop != LW_ODE_END) {
        s = lw_integrate_step(&w, end, &stop, run->e);
        if (s == LW_OK && stop != LW_ODE_END && w.h < shortest*(end - t))
            s = LW_OPEN;
    }
    if (s == LW_STOPPED && w.n_step + w.n_refused >= most_steps)
        s = LW_OPEN;
    if (s == LW_OK)
        memcpy(y, w.y, (size_t)run->n*sizeof *y);
    run->r->rates += w.n_rate;
    run->r->steps += w.n_step;
    free(work);
    return s;
}

lw_status lw_passage_begin(lw_passage *z)
{
    lw_dynamics *d = z->run->d;
    for (int i = 0; i < LW_PASSAGE_NODES; i++)
        z->at[i] = 0.5 + 0.5*(i < LW_PASSAGE_SIDE ? -lw_passage_node[LW_PASSAGE_SIDE - 1 - i] : lw_passage_node[i - LW_PASSAGE_SIDE]);
    lw_status s = d->rule ? LW_OK : (d->rule = malloc(sizeof *d->rule)) ? lw_panel_rule_make(d->rule) : LW_E_MEMORY;
    z->rule = d->rule;
    return s;
}

/* Weights of the integral from the anchor to x of the polynomial through values at nodes `first` to `last`; 0 for the
 * others.  The panel's points integrate it exactly. */
static void weights(const lw_passage *z, int first, int last, double x, double weight[LW_PASSAGE_NODES])
{
    double all[LW_PASSAGE_NODES], after[LW_PASSAGE_NODES + 1];
    memset(weight, 0, LW_PASSAGE_NODES*sizeof *weight);
    for (int k = first; k <= last; k++) {
        double apart = 1;
        for (int j = first; j <= last; j++)
            apart *= j == k ? 1 : z->at[k] - z->at[j];
        all[k] = (x - z->anchor)/apart;
    }
    for (int p = 0; p < LW_PANEL_NODES; p++) {
        double before = z->rule->gauss[p], at = z->anchor + (x - z->anchor)*z->rule->gauss_at[p];
        after[last + 1] = 1;
        for (int k = last; k > first; k--)
            after[k] = after[k + 1]*(at - z->at[k]);
        for (int k = first; k <= last; before *= at - z->at[k++])
            weight[k] += all[k]*before*after[k + 1];
    }
}

/* State at x in 0 .. 1 by the rates of the first `known` nodes: those of later nodes may not be written yet. */
static void state_in_gap(const lw_passage *z, const double weight[LW_PASSAGE_NODES], int known, double *restrict y)
{
    const double *restrict rate = z->rate;
    size_t n = (size_t)z->run->n;
    memset(y, 0, n*sizeof *y);
    for (int k = 0; k < known; k++, rate += n)
        for (size_t i = 0; i < n; i++)
            y[i] += weight[k]*rate[i];
    for (size_t i = 0; i < n; i++)
        y[i] = z->begun[i] + z->length*y[i];
}

void lw_passage_state(const lw_passage *z, double x, double *y)
{
    double weight[LW_PASSAGE_NODES];
    weights(z, 0, LW_PASSAGE_NODES - 1, x, weight);
    state_in_gap(z, weight, LW_PASSAGE_NODES, y);
}

lw_status lw_passage_guess(lw_passage *z)
{
    double weight[LW_PASSAGE_NODES], t = z->start;
    const double *from = z->begun;
    size_t n = (size_t)z->run->n;
    lw_status s = LW_OK;
    for (int k = 0; k < LW_PASSAGE_NODES && s == LW_OK; k++) {
        double *to = z->state + (size_t)k*n, at = z->start + z->length*z->at[k];
        if (k < LW_PASSAGE_SIDE) {
            memcpy(to, from, n*sizeof *to);
            s = lw_passage_integrate(z->run, t, at, to, false);
        } else {
            weights(z, 0, k - 1, z->at[k], weight);
            state_in_gap(z, weight, k, to);
            s = lw_run_project(z->run, at, to);
        }
        if (s == LW_OK)
            s = lw_run_rate(z->run, at, to, z->rate + (size_t)k*n);
        from = to;
        t = at;
    }
    return s;
}

/* Roots of the least pivot at the nodes.  false: there is none. */
static bool pivots(const lw_passage *z, double pivot[LW_PASSAGE_NODES])
{
    lw_dynamics *d = z->run->d;
    for (int k = 0; k < LW_PASSAGE_NODES; k++) {
        d->by_rank = false;                  /* else the pivot is not found */
        if (lw_mbs_rows(d, z->start + z->length*z->at[k], z->state + k*z->run->n) != LW_OK)
            return false;
        lw_mbs_factor(d, false);
        pivot[k] = sqrt(fmax(d->weak, 0));
    }
    return true;
}

bool lw_passage_is_clear(const lw_passage *z, double least)
{
    double pivot[LW_PASSAGE_NODES];
    bool clear = pivots(z, pivot);
    for (int k = 0; k < LW_PASSAGE_NODES; k++)
        clear = clear && pivot[k] > least;
    return clear;
}

/* The zero is that of the cubic t(pivot) through two nodes on either side of the least one. */
bool lw_passage_centre(lw_passage *z)
{
    double pivot[LW_PASSAGE_NODES], at = 0;
    int least = 0, use[4];
    if (!pivots(z, pivot))
        return false;
    for (int k = 0; k < LW_PASSAGE_NODES; k++)
        least = pivot[k] < pivot[least] ? k : least;
    if (least < 2 || least > LW_PASSAGE_NODES - 3)
        return false;
    for (int i = 0; i < 4; i++)
        use[i] = least + (i < 2 ? i - 2 : i - 1);
    for (int i = 0; i < 4; i++) {
        double product = 1, own = i < 2 ? pivot[use[i]] : -pivot[use[i]];
        for (int j = 0; j < 4; j++) {
            double other = j < 2 ? pivot[use[j]] : -pivot[use[j]];
            product *= i == j ? 1 : other/(other - own);
        }
        at += product*z->at[use[i]];
    }
    if (!(at > 0.2 && at < 0.8))
        return false;
    z->length *= 2*at;
    return true;
}

/* Near its turn the pivot's root is a parabola, with a part of third order: through two nodes on either side, inside the others but
 * well apart from the singular posture. */
bool lw_passage_centre_turn(lw_passage *z, double *t, double *beyond, double *bend)
{
    enum { OUTER = 5, INNER = 8, LAST = LW_PASSAGE_NODES - 1 };
    double pivot[LW_PASSAGE_NODES], x = z->at[LAST - OUTER] - 0.5, u = z->at[LAST - INNER] - 0.5;
    if (!pivots(z, pivot))
        return false;
    double odd = pivot[LAST - OUTER] - pivot[OUTER], odd_in = pivot[LAST - INNER] - pivot[INNER];
    double even = pivot[LAST - OUTER] + pivot[OUTER], even_in = pivot[LAST - INNER] + pivot[INNER];
    double slope = 0.5*(odd_in*x*x*x - odd*u*u*u)/(u*x*(x*x - u*u)), curve = 0.5*(even - even_in)/(x*x - u*u);
    double off = -0.5*slope/curve;
    if (!(curve > 0 && fabs(off) < 0.2))
        return false;
    *bend = 2*curve/(z->length*z->length);
    *beyond = curve*(x*x + off*off) - 0.5*even;
    z->length *= 1 + 2*off;
    *t = z->start + 0.5*z->length;
    return true;
}

lw_status lw_passage_solve(lw_passage *z, double *y, double *tail)
{
    lw_run *run = z->run;
    int n = run->n, both = run->d->n_q + run->d->n_v;
    double before = INFINITY, change = INFINITY, least = INFINITY, weight[LW_PASSAGE_NODES][LW_PASSAGE_NODES], whole[LW_PASSAGE_NODES];
    for (int k = 0; k < LW_PASSAGE_NODES; k++)
        weights(z, 0, LW_PASSAGE_NODES - 1, z->at[k], weight[k]);
    bool ended = false;
    for (int pass = 0, since = 0; !ended && pass - since < lingers; pass++) {
        for (int k = 0; k < LW_PASSAGE_NODES; k++) {
            lw_status s = lw_run_rate(run, z->start + z->length*z->at[k], z->state + k*n, z->rate + k*n);
            if (s != LW_OK)
                return s;
        }
        before = change;
        change = 0;
        for (int k = 0; k < LW_PASSAGE_NODES; k++) {
            state_in_gap(z, weight[k], LW_PASSAGE_NODES, y);
            lw_status s = lw_run_project(run, z->start + z->length*z->at[k], y);
            if (s != LW_OK)
                return s;
            for (int i = 0; i < both; i++)
                change = fmax(change, fabs(y[i] - z->state[k*n + i])/(1 + fabs(y[i])));
            memcpy(z->state + k*n, y, (size_t)n*sizeof *y);
        }
        if (!(change < 0.1))
            return LW_OPEN;
        if (change < 0.5*least)
            least = change, since = pass;
        ended = change <= settled || (change < unsettled && (change > 0.5*before || change*change <= z->enough*before));
    }
    *tail = 0;
    weights(z, 1, LW_PASSAGE_NODES - 2, 1, whole);
    state_in_gap(z, whole, LW_PASSAGE_NODES, run->state);
    lw_passage_state(z, 1, y);
    lw_status s = lw_run_project(run, z->start + z->length, y);    /* away with rounding across the motion curve */
    if (s == LW_OK)
        s = lw_run_project(run, z->start + z->length, run->state);
    for (int i = 0; i < both; i++)
        *tail = fmax(*tail, fabs(y[i] - run->state[i])/(1 + fabs(y[i])));
    z->rounding = change;
    return s != LW_OK ? s : change < unsettled ? LW_OK : LW_OPEN;
}

bool lw_passage_meets(const lw_passage *z, double tolerance)
{
    lw_dynamics *d = z->run->d;
    double off = 0;
    for (int k = -2; k <= 2; k++) {
        double x = 0.5 + 0.05*k;
        lw_passage_state(z, x, z->run->state);
        if (lw_mbs_rows(d, z->start + z->length*x, z->run->state) != LW_OK)
            return false;
        for (int i = 0; i < d->n_c; i++)
            off = fmax(off, fabs(d->phi[i]));
    }
    return lw_passage_fits(off, tolerance);
}

/* ---- forces in it ------------------------------------------------------------------------------------------- */

/* Accelerations and multipliers lose all digits in a singular posture.  The motion through it is found as over the gap,
 * from the state there; the accelerations are the rates of that polynomial.  Multipliers have at most a simple pole, so
 * the product of multiplier and time from the pole is a polynomial too (mbs/formulations/driven.c). */
static const double longest_window = 0.3, shortest_window = 0.03;    /* half of it, scaled: about radians */
static const double agreed = 1e-9, disagreed = 1e-5;     /* orders 20 and 18: good, and too far apart, relative */
static const double improved = 0.1;          /* two orders more, or half a window, leave less than this part of the error; more: it is rounding */
static const double enough_for_forces = 1e-13;           /* error of the states at the nodes that `agreed` does not notice */
static const double no_pole = 1e-8;          /* strength of a pole that counts as 0, relative */
static const double at_pole = 1e-7;          /* distance from a pole, over half the window, without a value */
static const double least_apart = 1e-3;      /* nearer to a singular posture multipliers are rounding */

/* Value at x of the polynomial through rows (LW_PASSAGE_NODES x width) at nodes `skip` .. LW_PASSAGE_NODES - 1 - skip, each multiplied by its
 * distance from `pole` unless that is 0. */
static void between_nodes(const lw_passage *z, const double *row, int width, int skip, double pole, double x, double *out)
{
    memset(out, 0, (size_t)width*sizeof *out);
    for (int k = skip; k < LW_PASSAGE_NODES - skip; k++) {
        double product = pole != 0 ? z->at[k] - pole : 1;
        for (int j = skip; j < LW_PASSAGE_NODES - skip; j++)
            product *= j == k ? 1 : (x - z->at[j])/(z->at[k] - z->at[j]);
        for (int c = 0; c < width; c++)
            out[c] += product*row[k*width + c];
    }
}

/* Where the pole of the multipliers l (LW_PASSAGE_NODES x n) is, as a fraction of the length: there the product with the distance has
 * no highest power.  The middle, if they have none. */
static double find_pole(const lw_passage *z, const double *l, int n)
{
    double over = 0, under = 0, unit = 0, most = lw_greatest(LW_PASSAGE_NODES*n, l);
    for (int c = -1; c < n; c++) {
        double a = 0, b = 0;
        for (int k = 0; k < LW_PASSAGE_NODES; k++) {
            double by = 1;
            for (int j = 0; j < LW_PASSAGE_NODES; j++)
                by /= j == k ? 1 : z->at[k] - z->at[j];
            a += by*(c < 0 ? 1/(z->at[k] - 0.5) : l[k*n + c]);
            b += c < 0 ? 0 : by*(z->at[k] - 0.5)*l[k*n + c];
        }
        unit = c < 0 ? a : unit;
        over += c < 0 ? 0 : a*b;
        under += c < 0 ? 0 : a*a;
    }
    return sqrt(under) > 1e-6*most*fabs(unit) ? 0.5 + over/under : 0.5;
}

/* d->a and d->l at the anchor from the states at the nodes.  l (LW_PASSAGE_NODES + 4 rows of n_c) is scratch.  Returns how far orders 20
 * and 18 are apart, relative; *before: orders 18 and 16.  Infinite where they cannot be found. */
static double forces_at_anchor(const lw_passage *z, double *l, double *before)
{
    lw_run *run = z->run;
    lw_dynamics *d = run->d;
    int n = d->n_c, n_v = d->n_v;
    double off = INFINITY;
    for (int k = 0; k < LW_PASSAGE_NODES; k++) {
        const double *y = z->state + k*run->n;
        lw_moment m;
        if (lw_mbs_moment(d, z->start + z->length*z->at[k], y, y + d->n_q, 0, &m) != LW_OK)
            return INFINITY;
        memcpy(l + k*n, d->l, (size_t)n*sizeof *l);
        memcpy(z->rate + k*run->n, d->a, (size_t)n_v*sizeof *d->a);
    }
    double pole = find_pole(z, l, n), x = z->anchor - pole, most = lw_greatest(LW_PASSAGE_NODES*n, l);
    double *strength = l + LW_PASSAGE_NODES*n, *plain = strength + n, *product = plain + n, *had = product + n;
    for (int skip = 2; skip >= 0; skip--) {
        memcpy(had, d->l, (size_t)n*sizeof *had);
        memcpy(z->begun, d->a, (size_t)n_v*sizeof *d->a);
        between_nodes(z, l, n, skip, 0, z->anchor, plain);
        between_nodes(z, l, n, skip, pole, pole, strength);
        between_nodes(z, l, n, skip, pole, z->anchor, product);
        for (int c = 0; c < n; c++)
            d->l[c] = fabs(strength[c]) < no_pole*most ? plain[c] : fabs(x) < at_pole ? NAN : product[c]/x;
        between_nodes(z, z->rate, run->n, skip, 0, z->anchor, run->state);
        memcpy(d->a, run->state, (size_t)n_v*sizeof *d->a);
        *before = off;
        off = 0;
        for (int c = 0; c < n; c++)
            off = isnan(d->l[c]) ? off : fmax(off, fabs(d->l[c] - had[c])/fmax(most, fabs(d->l[c])));
        for (int i = 0; i < n_v; i++)
            off = fmax(off, fabs(d->a[i] - z->begun[i])/fmax(lw_greatest(n_v, d->a), 1e-300));
    }
    return off;
}

lw_status lw_run_singular_forces(lw_run *run, double t, const double *y)
{
    lw_dynamics *d = run->d;
    size_t n = (size_t)run->n, n_c = (size_t)d->n_c, n_q = (size_t)d->n_q, n_v = (size_t)d->n_v;
    double apart = d->by_rank ? d->rank_of.weakest : sqrt(fmax(d->weak, 0)), speed = lw_greatest(d->n_v, y + n_q);
    double tail, best = INFINITY, *old = run->state;
    double *memory = malloc((n*(3 + 2*LW_PASSAGE_NODES) + 2*(n_v + n_c) + (LW_PASSAGE_NODES + 4)*n_c + n_v)*sizeof *memory);
    lw_passage z = { .run = run, .begun = memory, .enough = enough_for_forces };
    lw_status s = memory ? lw_passage_begin(&z) : LW_E_MEMORY;
    lw_error was = *run->e;
    if (s == LW_OK) {
        z.rate = memory + n;
        z.state = z.rate + LW_PASSAGE_NODES*n;
        run->state = z.state + LW_PASSAGE_NODES*n;
        double *end = run->state + n, *kept = end + n, *l = kept + 2*(n_v + n_c), *way = l + (LW_PASSAGE_NODES + 4)*n_c;
        memcpy(kept + n_v + n_c, d->a, n_v*sizeof *kept);
        memcpy(kept + 2*n_v + n_c, d->l, n_c*sizeof *kept);
        bool by_rounding = false;
        for (double half = longest_window; speed > 0 && best > agreed && !by_rounding && half >= shortest_window; half *= 0.5) {
            z.start = t - half/speed;
            z.length = 2*half/speed;
            bool solved = true;
            for (int pass = 0; solved && pass < 2; pass++) {
                z.anchor = (t - z.start)/z.length;
                for (int k = 0; k < LW_PASSAGE_NODES && solved; k++) {
                    double *to = memcpy(z.state + (size_t)k*n, y, n*sizeof *y), by = z.length*(z.at[k] - z.anchor);
                    const double *a = kept + n_v + n_c;      /* some digits of it serve a first guess */
                    for (size_t i = 0; i < n_v; i++) {
                        double gain = apart > least_apart ? by*a[i] : 0;
                        way[i] = by*(y[n_q + i] + 0.5*gain);
                        to[n_q + i] += gain;
                    }
                    d->eq.move(d->eq.context, to, way);
                    solved = lw_run_project(run, z.start + z.length*z.at[k], to) == LW_OK;
                }
                memcpy(z.begun, y, n*sizeof *y);
                solved = solved && (pass == 0 || lw_passage_solve(&z, end, &tail) == LW_OK);
                if (pass == 0)
                    solved = solved && lw_passage_centre(&z);
            }
            double before = INFINITY, off = solved && lw_passage_meets(&z, 10*d->o.absolute) ? forces_at_anchor(&z, l, &before) : INFINITY;
            by_rounding = (best < disagreed && !(off < improved*best)) || (off < disagreed && !(off < improved*before));
            if (!(off < best))
                continue;
            best = off;
            memcpy(kept, d->a, n_v*sizeof *kept);
            memcpy(kept + n_v, d->l, n_c*sizeof *kept);
        }
        bool known = best < disagreed;
        if (!known && apart > least_apart)   /* as they were */
            known = (kept += n_v + n_c, true);
        for (size_t i = 0; i < n_v; i++)
            d->a[i] = known ? kept[i] : NAN;
        for (size_t i = 0; i < n_c; i++)
            d->l[i] = known ? kept[n_v + i] : NAN;
        run->state = old;
        *run->e = was;
        s = lw_mbs_rows(d, t, y);            /* the run goes on from there */
        lw_mbs_factor(d, d->rank < d->n_c);
    }
    free(memory);
    return s;
}
