/* optimise/solvers/feasible.c - see feasible.h.
 *
 * min h(x) = sum of max(0, margin - g_j(x))^2 within the bounds, by Gauss-Newton steps with Levenberg's damping. With
 * little damping this is the shortest step that satisfies the violated conditions to first order, so the repaired point
 * stays near the given one. */
#include "optimise/solvers/feasible.h"

#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/real.h"
#include "base/rng.h"

#define N_STEP     60          /* a step costs two evaluations of g, also if it is rejected       */
#define N_RANDOM   24
#define INSIDE   1e-9          /* closer to a condition, ln g of the barrier would be too steep   */

typedef struct scratch {
    double a[LW_VAR_MAX*LW_VAR_MAX], diag[LW_VAR_MAX], b[LW_VAR_MAX], trial[LW_VAR_MAX];
} scratch;

/* Value of h; *least: the least g. */
static double excess(lw_record *r, const double *x, double margin, double *least)
{
    const double *g = lw_record_conditions(r, x, false);
    double h = 0.0, low = INFINITY;
    for (size_t j = 0; j < r->fn->m; j++) {
        double v = margin - g[j];
        if (isnan(v))
            v = INFINITY;
        if (v > 0.0)
            h += v*v;
        low = fmin(low, margin - v);
    }
    *least = low;
    return h;
}

/* Normal equations of the violated conditions at x. A variable at a bound that the step would cross stays fixed.
 * Returns the largest diagonal element. */
static double normal_equations(lw_record *r, const double *x, double margin, scratch *s)
{
    size_t n = r->fn->n;
    const double *g = lw_record_conditions(r, x, true);
    memset(s->a, 0, n*n*sizeof *s->a);
    memset(s->b, 0, n*sizeof *s->b);
    for (size_t j = 0; j < r->fn->m; j++) {
        if (g[j] >= margin)
            continue;
        const double *row = r->j + j*n;
        for (size_t i = 0; i < n; i++) {
            s->b[i] += (margin - g[j])*row[i];
            for (size_t k = 0; k < n; k++)
                s->a[i*n + k] += row[i]*row[k];
        }
    }
    double largest = 0.0;
    for (size_t i = 0; i < n; i++) {
        if ((x[i] <= r->fn->lo[i] && s->b[i] < 0.0) || (x[i] >= r->fn->hi[i] && s->b[i] > 0.0)) {
            for (size_t k = 0; k < n; k++)
                s->a[i*n + k] = s->a[k*n + i] = 0.0;
            s->b[i] = 0.0;
        }
        largest = fmax(largest, s->a[i*n + i]);
    }
    return largest;
}

/* One damped step from x to s->trial. False: the equations could not be solved. */
static bool step(lw_record *r, const double *x, double margin, double damping, scratch *s)
{
    size_t n = r->fn->n;
    double largest = normal_equations(r, x, margin, s);
    if (!(largest > 0.0) || !isfinite(largest))
        return false;
    for (size_t i = 0; i < n; i++)
        s->a[i*n + i] += damping*largest;
    if (!(lw_qr_factor((int)n, (int)n, s->a, s->diag) > 0.0))
        return false;
    lw_qr_solve((int)n, (int)n, s->a, s->diag, s->b);
    for (size_t i = 0; i < n; i++)
        s->trial[i] = x[i] + s->b[i];
    lw_clip(r->fn, s->trial);
    return true;
}

/* Lower h until every g >= enough. False: no further progress before that. */
static bool move_inside(lw_record *r, double *x, double margin, double enough, scratch *s)
{
    double least, damping = 1e-10;
    lw_clip(r->fn, x);
    double h = excess(r, x, margin, &least);
    for (int k = 0; k < N_STEP && !(least >= enough); k++) {
        double l, t = INFINITY;
        if (step(r, x, margin, damping, s))
            t = excess(r, s->trial, margin, &l);
        else if (damping > 1e-4)
            return false;
        if (t < h) {
            memcpy(x, s->trial, r->fn->n*sizeof *x);
            h = t;
            least = l;
            damping = fmax(0.1*damping, 1e-13);
        } else if (damping > 1e6)
            return false;
        else
            damping = fmax(10.0*damping, 1e-6);
    }
    return least >= enough;
}

/* Find the largest margin that can be reached from x. */
static bool search_from(lw_record *r, double *x, scratch *s)
{
    for (double margin = 1e-2; margin > 1e-12 && !lw_record_must_stop(r); margin *= 1e-2)
        if (move_inside(r, x, margin, 0.5*margin, s))
            return true;
    double least;
    excess(r, x, 0.0, &least);
    return least > 0.0;
}

bool lw_feasible_start(lw_record *r, double *x)
{
    size_t n = r->fn->n;
    double start[LW_VAR_MAX], least;
    lw_clip(r->fn, x);
    excess(r, x, 0.0, &least);
    if (least > INSIDE)
        return true;
    scratch *s = malloc(sizeof *s);
    if (!s) {
        r->no_memory = true;
        return false;
    }
    memcpy(start, x, n*sizeof *x);
    lw_rng rng;
    lw_rng_seed(&rng, r->o->seed, 0);
    bool found = search_from(r, x, s);
    for (int k = 0; !found && k < N_RANDOM && !lw_record_must_stop(r); k++) {
        double spread = ldexp(1.0, k/4 - 4);          /* 1/16 to 2: variables are of order one */
        for (size_t i = 0; i < n; i++)
            x[i] = start[i] + spread*lw_rng_normal(&rng);
        found = search_from(r, x, s);
    }
    free(s);
    return found;
}

bool lw_feasible_repair(lw_record *r, double *x)
{
    lw_clip(r->fn, x);
    if (lw_record_violation(r, x) <= LW_FEASIBLE)
        return true;
    scratch *s = malloc(sizeof *s);
    if (!s) {
        r->no_memory = true;
        return false;
    }
    bool done = move_inside(r, x, LW_FEASIBLE, -LW_FEASIBLE, s);
    free(s);
    return done;
}
