/* optimise/solvers/method.c - what all methods share: options, start, the last repair, the result. */
#include "optimise/solvers/method_internal.h"

#include <math.h>
#include <string.h>
#include "base/clock.h"
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
    case LW_STOP_USER:     return "stopped by the user";
    case LW_STOP_FAILED:   return "the method gave up";
    }
    return "unknown reason";
}

static const lw_method methods[] = {
#define X(id, name, box, takes_g, takes_gradient, method, source) { name, box, takes_g, method },
    LW_METHOD_LIST(X)
#undef X
};

const lw_method *lw_method_find(const char *name)
{
    for (size_t i = 0; i < sizeof methods/sizeof *methods; i++)
        if (strcmp(methods[i].name, name) == 0)
            return &methods[i];
    return NULL;
}

static bool nothing_to_vary(const lw_function *fn)
{
    for (size_t i = 0; i < fn->n; i++)
        if (fn->lo[i] < fn->hi[i])
            return false;
    return true;
}

static lw_stop run_method(const lw_method *m, lw_record *r, double *x)
{
    bool own_way = m->takes_constraints || r->fn->m == 0;
    lw_record_value(r, x, NULL);
    if (r->stopped || nothing_to_vary(r->fn))
        return LW_STOP_X_TOL;
    if (!own_way && !m->global)
        return lw_barrier_run(r, m->minimise, x);
    if (!isfinite(r->f) && r->fn->m > 0 && lw_feasible_start(r, x))     /* better than nothing */
        lw_record_value(r, x, NULL);
    double k = own_way ? 0.0 : r->o->barrier_last*(isfinite(r->f) ? r->f : 1.0);
    return lw_single_run(r, m->minimise, k, !m->global, x);
}

static lw_status outcome(lw_stop why)
{
    return why == LW_STOP_EVALS || why == LW_STOP_TIME || why == LW_STOP_USER ? LW_STOPPED : LW_OK;
}

lw_status lw_method_run(const lw_method *m, const lw_function *fn, const lw_solver_options *o,
                        double *x, lw_solver_result *result)
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
    result->seconds = lw_clock_wall() - r.started;
    if (isfinite(r.f))
        memcpy(x, r.x, fn->n*sizeof *x);
    lw_record_close(&r);
    return isfinite(result->f) ? outcome(result->stop) : LW_NOTHING;
}
