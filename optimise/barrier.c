/* optimise/barrier.c - see barrier.h. */
#include "optimise/barrier.h"

#include <math.h>
#include <string.h>
#include "optimise/feasible.h"

#define N_AGAIN     20           /* runs of a method in a stage                                   */
#define PAYS        0.01         /* a further run follows one that lowered F by this part of k,   */
                                 /* or of F where there is no k                                   */
#define FIRST_STEP  0.1          /* variables are of order one                                    */
#define MIN_STEP    1e-7
#define WALL        1e3          /* above anything a sensible linkage scores, times 1 + f(start)  */

double lw_barrier_value(lw_record *r, double k, const double *x, double *grad)
{
    size_t n = r->fn->n, m = r->fn->m;
    if (k > 0.0) {
        const double *g = lw_record_conditions(r, x, grad != NULL);
        for (size_t j = 0; j < m; j++)
            if (!(g[j] > 0.0)) {
                lw_record_count(r);
                return INFINITY;
            }
    }
    double f = lw_record_value(r, x, grad);
    if (!(k > 0.0) || !isfinite(f))
        return f;
    const double *g = lw_record_conditions(r, x, grad != NULL);
    for (size_t j = 0; j < m; j++) {
        f -= k*log(g[j]);
        for (size_t i = 0; grad && i < n; i++)
            grad[i] -= k/g[j]*r->j[j*n + i];
    }
    return f;
}

/* What stands for F outside.  grad comes in as the direction that lessens the opening, which is used
 * when no condition tells more. */
static double wall_value(lw_stage *s, const double *x, double *grad)
{
    size_t n = s->record->fn->n, m = s->record->fn->m;
    const double *g = lw_record_conditions(s->record, x, grad != NULL);
    double v = 0.0;
    for (size_t j = 0; j < m; j++)
        if (g[j] < 0.0)
            v += g[j]*g[j];
    if (grad && v > 0.0)
        memset(grad, 0, n*sizeof *grad);
    for (size_t i = 0; grad && i < n; i++) {
        for (size_t j = 0; j < m; j++)
            if (g[j] < 0.0)
                grad[i] += 2.0*g[j]*s->record->j[j*n + i];
        grad[i] = isfinite(grad[i]) ? s->wall*grad[i] : 0.0;
    }
    return s->wall*(1.0 + fmin(v, 1e6));
}

double lw_stage_value(lw_stage *s, const double *x, double *grad)
{
    size_t n = s->record->fn->n;
    if (grad)
        memset(grad, 0, n*sizeof *grad);
    if (!lw_finite(x, n)) {
        lw_record_count(s->record);
        return 1e6*s->wall;
    }
    if (lw_record_must_stop(s->record))
        return s->wall;
    double f = lw_barrier_value(s->record, s->k, x, grad);
    if (!isfinite(f))
        return wall_value(s, x, grad);
    if (f < s->best && (s->record->fn->m == 0 || s->k > 0.0 || f == s->record->f)) {
        s->best = f;
        memcpy(s->x, x, n*sizeof *x);
    }
    return f;
}

bool lw_stage_over(const lw_stage *s)
{
    return s->record->stopped || s->record->evals >= s->last_eval;
}

static lw_stage new_stage(lw_record *r, double k)
{
    return (lw_stage){
        .record = r, .k = k, .wall = WALL*(1.0 + (isfinite(r->f) ? fabs(r->f) : 0.0)),
        .f_tol = r->o->f_tol, .step = FIRST_STEP, .last_eval = r->limit, .best = INFINITY
    };
}

/* Run the method in the stage; leave the stage's best point in x. */
static lw_stop run_stage(lw_stage *s, lw_minimise *method, bool again, double *x)
{
    lw_stop why = LW_STOP_FAILED;
    for (int k = 0; k < N_AGAIN && !lw_stage_over(s); k++) {
        double before = s->best;
        why = method(s, x);
        if (isfinite(s->best))
            memcpy(x, s->x, s->record->fn->n*sizeof *x);
        if (!again || !(before - s->best > PAYS*(s->k > 0.0 ? s->k : fabs(s->best))))
            break;
    }
    return why;
}

lw_stop lw_single_run(lw_record *r, lw_minimise *method, double k, bool again, double *x)
{
    lw_stage s = new_stage(r, k);
    return run_stage(&s, method, again, x);
}

/* The path of optima x(k) is nearly straight in k at its end (Fiacco & McCormick 1968): from the last
 * two of them guess the next, and keep the guess when F is lower there.  Returns the way left to go. */
static double extrapolate(lw_stage *s, const double *older, double k_older, double k, double *x)
{
    size_t n = s->record->fn->n;
    double guess[LW_VAR_MAX], way = 0.0, t = (k - s->k)/(k_older - k);
    for (size_t i = 0; i < n; i++) {
        guess[i] = x[i] + t*(older[i] - x[i]);
        way = fmax(way, fabs(guess[i] - x[i]));
    }
    lw_clip(s->record->fn, guess);
    double here = lw_barrier_value(s->record, s->k, x, NULL);
    if (lw_barrier_value(s->record, s->k, guess, NULL) < here)
        memcpy(x, guess, n*sizeof *x);
    return way;
}

/* Evaluations for a stage that is not the last: an equal share of what is left. */
static long share(const lw_record *r, double level)
{
    const lw_solver_options *o = r->o;
    double left = ceil(log(o->barrier_last/level)/log(o->barrier_ratio) - 1e-9);
    return (long)((double)(r->limit - r->evals)/(left + 1.0)) + 1;
}

lw_stop lw_barrier_run(lw_record *r, lw_minimise *method, double *x)
{
    const lw_solver_options *o = r->o;
    lw_stop why = LW_STOP_FAILED;
    double older[LW_VAR_MAX], end[LW_VAR_MAX], k_older = 0.0, k_end = 0.0, step = FIRST_STEP;
    if (!lw_feasible_start(r, x) || !isfinite(lw_record_value(r, x, NULL)))
        return why;
    for (double level = o->barrier_first; !r->stopped; level *= o->barrier_ratio) {
        bool last = level <= o->barrier_last*(1.0 + 1e-9);
        level = fmax(level, o->barrier_last);
        lw_stage s = new_stage(r, level*r->f);
        if (!last) {
            s.f_tol = fmax(o->f_tol, 0.01*level);
            s.last_eval = r->evals + share(r, level);
        }
        memcpy(end, x, r->fn->n*sizeof *x);
        if (k_older > k_end)
            step = fmin(FIRST_STEP, fmax(extrapolate(&s, older, k_older, k_end, x), MIN_STEP));
        s.step = step;
        memcpy(older, end, r->fn->n*sizeof *x);
        k_older = k_end;
        k_end = s.k;
        why = run_stage(&s, method, true, x);
        if (last)
            break;
    }
    return why;
}
