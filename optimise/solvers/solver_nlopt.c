/* optimise/solvers/solver_nlopt.c - the methods of NLopt (Johnson, The NLopt nonlinear-optimization package). No other
 * file uses NLopt.
 *
 * In version 2.7.1 COBYLA and SLSQP may return a point that is not the best they saw, so the stage keeps its own best
 * point. The random state belongs to the thread and is seeded from the clock unless nlopt_srand was called in that
 * thread. Stops are requested by nlopt_force_stop. After a stop the objective returns at once, so methods that check
 * for it late cost little. */
#include <limits.h>
#include <nlopt.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/real.h"
#include "optimise/solvers/feasible.h"
#include "optimise/solvers/method_internal.h"

/* NLopt minimises F divided by the best f so far, because Luksan's methods stop at an absolute gradient of 1e-8, long
 * before an exact fit is exact. Their shortest step is 1e-10 times the gradient, so the curvature must stay well below
 * 1e10. */
#define SCALE_MAX 1e8

typedef struct call { lw_barrier_stage *stage; nlopt_opt opt; double scale; } call;

static double objective(unsigned n, const double *x, double *grad, void *data)
{
    call *c = data;
    double f = lw_barrier_stage_value(c->stage, x, grad);
    if (lw_barrier_stage_over(c->stage))
        nlopt_force_stop(c->opt);
    for (unsigned i = 0; grad && i < n; i++)
        grad[i] *= c->scale;
    return c->scale*f;
}

/* NLopt wants c(x) <= 0. */
static void conditions(unsigned m, double *c, unsigned n, const double *x, double *grad, void *data)
{
    lw_record *r = ((call *)data)->stage->record;
    const double *g = lw_record_conditions(r, x, grad != NULL);
    for (size_t j = 0; j < m; j++)
        c[j] = isfinite(g[j]) ? -g[j] : 1.0;
    for (size_t i = 0; grad && i < (size_t)m*n; i++)
        grad[i] = isfinite(r->j[i]) ? -r->j[i] : 0.0;
}

static lw_stop reason(nlopt_result result, const lw_record *r)
{
    switch (result) {
    case NLOPT_STOPVAL_REACHED: return LW_STOP_F_TARGET;
    case NLOPT_SUCCESS:
    case NLOPT_FAILURE:                                 /* Luksan's line search found no lower point */
    case NLOPT_ROUNDOFF_LIMITED:
    case NLOPT_FTOL_REACHED:    return LW_STOP_F_TOL;
    case NLOPT_XTOL_REACHED:    return LW_STOP_X_TOL;
    case NLOPT_MAXTIME_REACHED: return LW_STOP_TIME;
    case NLOPT_MAXEVAL_REACHED: return LW_STOP_EVALS;
    case NLOPT_FORCED_STOP:     return r->stopped ? r->why : LW_STOP_EVALS;
    default:                    return LW_STOP_FAILED;
    }
}

/* Set the first steps of the methods without gradient: at most a quarter of a narrow range, which BOBYQA demands. NLopt
 * itself removes variables whose range is a point. */
static nlopt_result set_steps(nlopt_opt opt, const lw_barrier_stage *s)
{
    const lw_function *fn = s->record->fn;
    double dx[LW_VAR_MAX];
    for (size_t i = 0; i < fn->n; i++) {
        double range = fn->hi[i] - fn->lo[i];
        dx[i] = range > 0.0 ? fmin(s->step, 0.25*range) : 1.0;
    }
    return nlopt_set_initial_step(opt, dx);
}

/* Set the local method that MLSL starts from promising points. */
static nlopt_result set_local(nlopt_opt opt, unsigned n)
{
    nlopt_opt local = nlopt_create(NLOPT_LD_SLSQP, n);
    if (!local)
        return NLOPT_OUT_OF_MEMORY;
    nlopt_set_ftol_rel(local, 1e-9);
    nlopt_set_xtol_rel(local, 1e-9);
    nlopt_result result = nlopt_set_local_optimizer(opt, local);     /* copies */
    nlopt_destroy(local);
    return result;
}

static int remaining_evals(const lw_barrier_stage *s)
{
    long left = s->last_eval - s->record->evals;
    return left < 1 ? 1 : left > INT_MAX ? INT_MAX : (int)left;
}

typedef enum steps { DESCENT, SIMPLE, BOX } steps;  /* with gradient, without, the whole box (by both) */

static nlopt_result set_up(nlopt_opt opt, steps kind, bool takes_constraints, call *c)
{
    const lw_barrier_stage *s = c->stage;
    const lw_record *r = s->record;
    const lw_function *fn = r->fn;
    const lw_solver_options *o = r->o;
    nlopt_result ok = nlopt_set_lower_bounds(opt, fn->lo);
    if (ok > 0)
        ok = nlopt_set_upper_bounds(opt, fn->hi);
    if (ok > 0)
        ok = nlopt_set_min_objective(opt, objective, c);
    if (ok > 0)                                    /* a search of the box uses its whole budget */
        ok = nlopt_set_ftol_rel(opt, kind == BOX ? 0.0 : s->f_tol);
    if (ok > 0)
        ok = nlopt_set_xtol_rel(opt, kind == BOX ? 0.0 : o->x_tol);
    if (ok > 0)
        ok = nlopt_set_maxeval(opt, remaining_evals(s));
    if (ok > 0 && o->max_seconds > 0.0)            /* 0 would mean no limit */
        ok = nlopt_set_maxtime(opt, fmax(o->max_seconds - (lw_clock_wall() - r->started), 1e-6));
    if (ok > 0 && kind == DESCENT)
        ok = nlopt_set_vector_storage(opt, 20);
    if (ok > 0 && kind == SIMPLE)
        ok = set_steps(opt, s);
    if (ok > 0 && takes_constraints && fn->m > 0)  /* no tolerances: the record applies ours */
        ok = nlopt_add_inequality_mconstraint(opt, (unsigned)fn->m, conditions, c, NULL);
    return ok;
}

/* Is there as much memory as a method takes for so many variables and conditions?  Some methods go on in another way when they get less,
 * and nlopt_copy does not look whether it got any. */
static bool memory_is_there(const lw_function *fn)
{
    size_t rows = 4*fn->n + fn->m + 64;
    void *volatile all = malloc(rows*rows*sizeof(double));         /* volatile: the call is not optimised away */
    bool there = all != NULL;
    free(all);
    return there;
}

static lw_stop minimise(nlopt_algorithm algorithm, steps kind, bool takes_constraints, lw_barrier_stage *stage, const double *start)
{
    lw_record *r = stage->record;
    unsigned n = (unsigned)r->fn->n;
    double x[LW_VAR_MAX], f;
    call c = { stage, memory_is_there(r->fn) ? nlopt_create(algorithm, n) : NULL, 1.0 };
    if (!c.opt) {
        r->no_memory = true;
        return LW_STOP_FAILED;
    }
    lw_stop why = LW_STOP_FAILED;
    memcpy(x, start, n*sizeof *x);
    lw_clip(r->fn, x);
    nlopt_srand((unsigned long)r->o->seed);
    if (isfinite(r->f))
        c.scale = fmin(1.0/r->f, SCALE_MAX);
    nlopt_result result = set_up(c.opt, kind, takes_constraints, &c);
    if (result > 0 && algorithm == NLOPT_GD_MLSL_LDS)
        result = set_local(c.opt, n);
    if (result > 0) {
        result = nlopt_optimize(c.opt, x, &f);
        why = reason(result, r);
    }
    r->no_memory |= result == NLOPT_OUT_OF_MEMORY;
    nlopt_destroy(c.opt);
    if (takes_constraints && r->fn->m > 0 && lw_finite(x, n) && lw_feasible_repair(r, x))
        lw_barrier_stage_value(stage, x, NULL);
    return why;
}

#define METHOD(row, algorithm, kind, takes_constraints)                                  \
    lw_stop lw_nlopt_##row(lw_barrier_stage *s, const double *x)                                 \
    { return minimise(algorithm, kind, takes_constraints, s, x); }

METHOD(slsqp,      NLOPT_LD_SLSQP,      DESCENT, true)
METHOD(mma,        NLOPT_LD_MMA,        DESCENT, true)
METHOD(ccsaq,      NLOPT_LD_CCSAQ,      DESCENT, true)
METHOD(lbfgs,      NLOPT_LD_LBFGS,      DESCENT, false)
METHOD(tnewton,    NLOPT_LD_TNEWTON_PRECOND_RESTART, DESCENT, false)
METHOD(cobyla,     NLOPT_LN_COBYLA,     SIMPLE,  true)
METHOD(bobyqa,     NLOPT_LN_BOBYQA,     SIMPLE,  false)
METHOD(neldermead, NLOPT_LN_NELDERMEAD, SIMPLE,  false)
METHOD(sbplx,      NLOPT_LN_SBPLX,      SIMPLE,  false)
METHOD(crs,        NLOPT_GN_CRS2_LM,    BOX,     false)
METHOD(isres,      NLOPT_GN_ISRES,      BOX,     true)
METHOD(esch,       NLOPT_GN_ESCH,       BOX,     false)
METHOD(direct,     NLOPT_GN_DIRECT_L,   BOX,     false)
METHOD(mlsl,       NLOPT_GD_MLSL_LDS,   BOX,     false)
