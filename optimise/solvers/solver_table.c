/* optimise/solvers/solver_table.c - the table of solvers, built on the methods of method.c. */
#include "optimise/solvers/solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/vec2.h"
#include "optimise/solvers/lm.h"
#include "optimise/solvers/method_internal.h"

/* f and g of a problem; work as for lw_problem_value, of this thread, initialised. */
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

/* Finite bounds for a search of the whole box: those of fn where finite, else lengths in [lo, 10],
 * coordinates in [-10, 10], angles in [-pi, pi] (scaled units, the target has size one); x is inside. */
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

#define X(id, name, box, takes_g, takes_gradient, method, source)                                \
    static lw_status run_##id(const lw_problem *p, const lw_solver_options *o, double *x,        \
                              lw_solver_result *r)                                               \
    { return run(lw_method_find(name), p, o, x, r); }
LW_METHOD_LIST(X)
#undef X

const lw_solver lw_solver_table[] = {
    { "lm", "Levenberg 1944, Marquardt 1963; steps by Goldfarb & Idnani 1983", false, false, true,
      lw_lm_run },
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
