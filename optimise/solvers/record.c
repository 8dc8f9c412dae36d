/* optimise/solvers/record.c - see record.h. */
#include "optimise/solvers/record.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/real.h"

static bool options_are_sound(const lw_solver_options *o)
{
    return o->max_evals >= 1 && o->max_seconds >= 0.0 && !isnan(o->f_target)
        && o->f_tol >= 0.0 && o->x_tol >= 0.0 && o->step > 0.0 && isfinite(o->step)
        && o->barrier_last > 0.0 && o->barrier_first >= o->barrier_last
        && isfinite(o->barrier_first) && o->barrier_ratio > 0.0 && o->barrier_ratio < 1.0;
}

lw_status lw_record_open(lw_record *r, const lw_function *fn, const lw_solver_options *o)
{
    memset(r, 0, sizeof *r);
    if (!options_are_sound(o) || fn->n < 1 || fn->n > LW_VAR_MAX)
        return LW_E_ARG;
    r->fn = fn;
    r->o = o;
    r->limit = o->max_evals - (o->max_evals > 1);
    r->f = r->f_near = INFINITY;
    r->started = lw_clock_wall();
    if (fn->m == 0)
        return LW_OK;
    r->g = malloc(fn->m*(fn->n + 1)*sizeof *r->g);
    if (!r->g)
        return LW_E_MEMORY;
    r->j = r->g + fn->m;
    return LW_OK;
}

void lw_record_close(lw_record *r)
{
    free(r->g);
    r->g = r->j = NULL;
}

/* Stop; the first reason counts. */
static void stop_because(lw_record *r, lw_stop why)
{
    if (!r->stopped) {
        r->stopped = true;
        r->why = why;
    }
}

bool lw_record_must_stop(lw_record *r)
{
    if (r->stopped)
        return true;
    if (r->o->interrupt && *r->o->interrupt)
        stop_because(r, LW_STOP_USER);
    else if (r->o->max_seconds > 0.0 && lw_clock_wall() - r->started >= r->o->max_seconds)
        stop_because(r, LW_STOP_TIME);
    else if (r->evals >= r->limit)
        stop_because(r, LW_STOP_EVALS);
    return r->stopped;
}

void lw_clip(const lw_function *fn, double *x)
{
    for (size_t i = 0; i < fn->n; i++)
        x[i] = fmin(fmax(x[i], fn->lo[i]), fn->hi[i]);
}

bool lw_finite(const double *x, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(x[i]))
            return false;
    return true;
}

const double *lw_record_conditions(lw_record *r, const double *x, bool want_j)
{
    size_t bytes = r->fn->n*sizeof *x;
    if (r->fn->m == 0)
        return NULL;
    if (!r->known || (want_j && !r->known_j) || memcmp(x, r->gx, bytes) != 0) {
        r->fn->conditions(r->fn->context, x, r->g, want_j ? r->j : NULL);
        memmove(r->gx, x, bytes);
        r->known = true;
        r->known_j = want_j;
    }
    return r->g;
}

static double outside_bounds(const lw_function *fn, const double *x)
{
    double worst = 0.0;
    for (size_t i = 0; i < fn->n; i++)
        worst = fmax(worst, fmax(fn->lo[i] - x[i], x[i] - fn->hi[i]));
    return worst;
}

static double outside_conditions(lw_record *r, const double *x)
{
    const double *g = lw_record_conditions(r, x, false);
    double worst = 0.0;
    for (size_t i = 0; i < r->fn->m; i++)
        worst = g[i] >= -worst ? worst : isnan(g[i]) ? INFINITY : -g[i];
    return worst;
}

double lw_record_violation(lw_record *r, const double *x)
{
    return fmax(outside_bounds(r->fn, x), outside_conditions(r, x));
}

/* Keep a better point and report it to the caller. */
static void improve(lw_record *r, const double *x, double f)
{
    r->f = f;
    memcpy(r->x, x, r->fn->n*sizeof *x);
    if (r->o->improved)
        r->o->improved(r->o->context, r->evals, lw_clock_wall() - r->started, f);
    if (f <= r->o->f_target)
        stop_because(r, LW_STOP_F_TARGET);
}

static void offer(lw_record *r, const double *x, double f)
{
    if (!(f < r->f))                                  /* the conditions are evaluated only when they matter */
        return;
    double box = outside_bounds(r->fn, x), v = outside_conditions(r, x);
    if (box == 0.0 && v <= LW_FEASIBLE)
        improve(r, x, f);
    else if (box <= LW_NEARLY && v <= LW_NEARLY && f < r->f_near) {
        r->f_near = f;
        memcpy(r->x_near, x, r->fn->n*sizeof *x);
    }
}

static double evaluate(lw_record *r, const double *x, double *grad)
{
    r->evals++;
    double f = r->fn->value(r->fn->context, x, grad);
    if (!isfinite(f))
        return INFINITY;
    offer(r, x, f);
    return f;
}

double lw_record_value(lw_record *r, const double *x, double *grad)
{
    return lw_record_must_stop(r) ? INFINITY : evaluate(r, x, grad);
}

void lw_record_count(lw_record *r)
{
    if (!lw_record_must_stop(r))
        r->evals++;
}

void lw_record_last(lw_record *r, const double *x)
{
    if (r->evals < r->o->max_evals)
        evaluate(r, x, NULL);
}

bool lw_record_residuals(lw_record *r, const double *x, double *res, double *j)
{
    if (lw_record_must_stop(r))
        return false;
    r->evals++;
    if (!r->fn->residuals(r->fn->context, x, res, j))
        return false;
    double f = 0.0;
    for (size_t i = 0; i < r->fn->n_residual; i++)
        f += res[i]*res[i];
    if (!isfinite(f))
        return false;
    offer(r, x, f);
    return true;
}
