/* optimise/solver_table.c - the table of solvers, built on the methods of method.c. */
#include "optimise/solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/vec2.h"
#include "optimise/method.h"

static double call_value(void *context, const double *x, double *grad)
{
    struct lw_problem_call *c = context;
    return lw_problem_value(c->p, x, grad, c->work);
}

static bool call_residuals(void *context, const double *x, double *r, double *j)
{
    struct lw_problem_call *c = context;
    return lw_problem_residuals(c->p, x, r, j, c->work);
}

static void call_conditions(void *context, const double *x, double *g, double *j)
{
    struct lw_problem_call *c = context;
    lw_problem_constraints(c->p, x, g, j, c->work);
}

lw_function lw_function_of(struct lw_problem_call *call)
{
    const lw_problem *p = call->p;
    return (lw_function){
        .n = (size_t)p->n_var, .m = lw_problem_constraint_count(p),
        .n_residual = lw_problem_residual_count(p), .lo = p->lo, .hi = p->hi, .context = call,
        .value = call_value, .residuals = call_residuals, .conditions = call_conditions
    };
}

void lw_problem_box(const lw_problem *p, const double *x, double *lo, double *hi)
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

static lw_status run(const lw_method *m, const lw_problem *p, const lw_solver_options *o, double *x,
                     lw_solver_result *result)
{
    double lo[LW_VAR_MAX], hi[LW_VAR_MAX];
    size_t size = (lw_problem_work_size(p) + 63)/64*64;
    void *work = aligned_alloc(64, size ? size : 64);
    *result = (lw_solver_result){ .f = INFINITY, .stop = LW_STOP_FAILED };
    if (!work)
        return LW_E_MEMORY;
    lw_problem_work_init(p, work);
    struct lw_problem_call call = { p, work };
    lw_function fn = lw_function_of(&call);
    if (m->global) {
        lw_problem_box(p, x, lo, hi);
        fn.lo = lo;
        fn.hi = hi;
    }
    lw_status s = lw_method_run(m, &fn, o, x, result);
    free(work);
    return s;
}

#define X(id, name, box, takes_g, takes_gradient, method, source)                                \
    static lw_status run_##id(const lw_problem *p, const lw_solver_options *o, double *x,        \
                              lw_solver_result *r)                                               \
    { return run(lw_method_find(name), p, o, x, r); }
LW_METHOD_LIST(X)
#undef X

const lw_solver lw_solver_table[] = {
#define X(id, name, box, takes_g, takes_gradient, method, source)                                \
    { name, source, box, takes_g, takes_gradient, run_##id },
    LW_METHOD_LIST(X)
#undef X
    { NULL, NULL, false, false, false, NULL }
};

const lw_solver *lw_solver_find(const char *name)
{
    for (const lw_solver *s = lw_solver_table; s->name; s++)
        if (strcmp(s->name, name) == 0)
            return s;
    return NULL;
}

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
