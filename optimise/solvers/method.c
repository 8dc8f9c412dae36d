/* optimise/solvers/method.c - what all methods share: options, start, final repair, result. */
#include "base/real.h"
#include "optimise/solvers/method_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/vec2.h"
#include "optimise/solvers/feasible.h"

lw_solver_options lw_solver_options_default(void)
{
    return (lw_solver_options){
        .seed = 1, .max_evals = 10000, .f_tol = 1e-14, .x_tol = 1e-14, .step = 1e-3,
        .barrier_first = 1e-2, .barrier_last = 1e-10, .barrier_ratio = 0.1
    };
}

const char *lw_stop_text(lw_stop s)
{
    switch (s) {
    case LW_STOP_F_TOL:    return "the objective no longer falls";
    case LW_STOP_X_TOL:    return "the variables no longer move";
    case LW_STOP_GRADIENT: return "the gradient is zero to rounding";
    case LW_STOP_F_TARGET: return "good enough";
    case LW_STOP_EVALS:    return "limit of evaluations";
    case LW_STOP_TIME:     return "time limit";
    case LW_STOP_USER:     return "the caller requested a stop";
    case LW_STOP_FAILED:   return "the method gave up";
    }
    return "unknown reason";
}

static bool nothing_to_vary(const lw_function *fn)
{
    for (size_t i = 0; i < fn->n; i++)
        if (fn->lo[i] < fn->hi[i])
            return false;
    return true;
}

static lw_stop run_method(const lw_solver *m, lw_record *r, double *x)
{
    bool own_way = m->takes_constraints || r->fn->m == 0;
    lw_record_value(r, x, NULL);
    if (r->stopped || nothing_to_vary(r->fn))
        return LW_STOP_X_TOL;
    if (!own_way && !m->global)
        return lw_barrier_run(r, m->minimise, x);
    if (!isfinite(r->f) && r->fn->m > 0 && lw_feasible_start(r, x))     /* better than no point */
        lw_record_value(r, x, NULL);
    double k = own_way ? 0.0 : r->o->barrier_last*(isfinite(r->f) ? r->f : 1.0);
    return lw_single_run(r, m->minimise, k, !m->global, x);
}

static lw_status outcome(lw_stop why)
{
    return why == LW_STOP_EVALS || why == LW_STOP_TIME || why == LW_STOP_USER ? LW_STOPPED : LW_OK;
}

lw_status lw_method_run(const lw_solver *m, const lw_function *fn, const lw_solver_options *o, double *x, lw_solver_result *result)
{
    lw_record r;
    double y[LW_VAR_MAX];
    *result = (lw_solver_result){ .f = INFINITY, .stop = LW_STOP_FAILED };
    if (fn->n > LW_VAR_MAX || !lw_finite(x, fn->n))
        return LW_E_ARG;
    lw_status s = lw_record_open(&r, fn, o);
    if (s != LW_OK)
        return s;
    memcpy(y, x, fn->n*sizeof *x);
    lw_clip(fn, y);
    lw_stop why = run_method(m, &r, y);
    if (r.f_near < r.f && lw_feasible_repair(&r, r.x_near))
        lw_record_last(&r, r.x_near);
    result->f = r.f;
    result->evals = r.evals;
    result->stop = r.stopped ? r.why : why;
    if (isfinite(r.f))
        memcpy(x, r.x, fn->n*sizeof *x);
    lw_record_close(&r);
    if (r.no_memory)
        return LW_E_MEMORY;
    return isfinite(result->f) ? outcome(result->stop) : LW_NOTHING;
}

/* ---- a method on a fitting problem ------------------------------------------------------------------------ */

/* f and g of a problem. work is initialised and used by one thread, as for lw_problem_value. */
typedef struct problem_call { const lw_problem *p; void *work; } problem_call;

static double call_value(void *context, const double *x, double *grad)
{
    problem_call *c = context;
    return lw_problem_value(c->p, x, grad, c->work);
}

static bool call_residuals(void *context, const double *x, double *r, double *j)
{
    problem_call *c = context;
    return lw_problem_residuals(c->p, x, r, j, c->work);
}

static void call_conditions(void *context, const double *x, double *g, double *j)
{
    problem_call *c = context;
    lw_problem_constraints(c->p, x, g, j, c->work);
}

static lw_function function_of(problem_call *call)
{
    const lw_problem *p = call->p;
    return (lw_function){
        .n = (size_t)p->n_var, .m = lw_problem_constraint_count(p),
        .n_residual = lw_problem_residual_count(p), .lo = p->lo, .hi = p->hi, .context = call,
        .value = call_value, .residuals = call_residuals, .conditions = call_conditions
    };
}

/* Finite bounds for a search of the whole box: those of fn where finite; else lengths in [lo, 10], coordinates in [-10,
 * 10], angles in [-pi, pi] (scaled units, the target has size one). x lies inside. */
static void search_box(const lw_problem *p, const double *x, double *lo, double *hi)
{
    for (int i = 0; i < p->n_var; i++) {
        lw_dim_kind kind = i < p->n_dim ? p->plan.dim[i].kind : LW_DIM_ANGLE;
        double limit = kind == LW_DIM_ANGLE ? LW_PI : 10.0;
        double low = kind == LW_DIM_LENGTH ? 0.0 : -limit;
        lo[i] = isfinite(p->lo[i]) ? p->lo[i] : fmin(low, x[i]);
        hi[i] = isfinite(p->hi[i]) ? p->hi[i] : fmax(fmax(limit, lo[i]), x[i]);
        lo[i] = fmin(lo[i], hi[i]);
    }
}

lw_status lw_method_solve(const lw_solver *m, const lw_problem *p, const lw_solver_options *o, double *x, lw_solver_result *result)
{
    double lo[LW_VAR_MAX], hi[LW_VAR_MAX];
    size_t size = (lw_problem_work_size(p) + 63)/64*64;
    void *work = aligned_alloc(64, size ? size : 64);
    *result = (lw_solver_result){ .f = INFINITY, .stop = LW_STOP_FAILED };
    if (!work)
        return LW_E_MEMORY;
    lw_problem_work_init(p, work);
    problem_call call = { p, work };
    lw_function fn = function_of(&call);
    if (m->global) {
        search_box(p, x, lo, hi);
        fn.lo = lo;
        fn.hi = hi;
    }
    lw_status s = lw_method_run(m, &fn, o, x, result);
    free(work);
    return s;
}
