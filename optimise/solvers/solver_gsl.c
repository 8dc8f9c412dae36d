/* optimise/solvers/solver_gsl.c - Levenberg-Marquardt of GSL's multifit_nlinear (row `lm-gsl`), the only file
 * of this folder that knows GSL.
 *
 * GSL minimises a sum of squares without conditions. Bounds and conditions are brought in as further
 * residuals, by the augmented Lagrangian for inequalities (Rockafellar 1973; Nocedal & Wright 2006,
 * ch. 17.4), which for c(x) >= 0 is a square already:
 *
 *     sum r^2 + sum over c of  (rho/2) max(0, lambda/rho - c)^2,     lambda <- max(0, lambda - rho c)
 *
 * Points in between may lie outside; the record keeps what is feasible, and the end of every round is
 * moved inside and offered.
 *
 * Sizes fit and everything handed to GSL is finite; errors of GSL, such as memory running out, are returned
 * (base/gsl_errors.h). */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <stdlib.h>
#include <string.h>
#include "base/gsl_errors.h"
#include "base/real.h"
#include "optimise/solvers/feasible.h"
#include "optimise/solvers/method_internal.h"

#define N_ROUND     40
#define N_STEP      200
#define WELL_INSIDE 1e-11        /* violation of the conditions up to which the final repair does the rest */

typedef struct lagrangian {
    lw_barrier_stage *stage;
    size_t    n, n_residual, n_condition;            /* n_condition: g, lower, upper bounds       */
    double    rho, *lambda;                          /* (n_condition)                             */
    double   *res, *jac;                             /* of f (n_residual), (n_residual*n)         */
} lagrangian;

/* c_j(x): conditions first, then x - lo, hi - x; INFINITY if there is no bound. */
static double condition(const lagrangian *a, const double *x, const double *g, size_t j)
{
    const lw_function *fn = a->stage->record->fn;
    if (j < fn->m)
        return g[j];
    j -= fn->m;
    return j < a->n ? x[j] - fn->lo[j] : fn->hi[j - a->n] - x[j - a->n];
}

static const double *values(const gsl_vector *v, double *x)
{
    for (size_t i = 0; i < v->size; i++)
        x[i] = gsl_vector_get(v, i);
    return x;
}

/* Residuals; where f is not defined, numbers so large that the step is rejected. */
static int residuals(const gsl_vector *at, void *data, gsl_vector *out)
{
    lagrangian *a = data;
    double buf[LW_VAR_MAX];
    const double *x = values(at, buf);
    if (lw_barrier_stage_over(a->stage))
        return GSL_EBADFUNC;
    bool defined = lw_finite(x, a->n) && lw_record_residuals(a->stage->record, x, a->res, NULL);
    const double *g = lw_record_conditions(a->stage->record, x, false);
    for (size_t i = 0; i < a->n_residual; i++)
        gsl_vector_set(out, i, defined ? a->res[i] : a->stage->wall);
    for (size_t j = 0; j < a->n_condition; j++) {
        double c = condition(a, x, g, j);
        double v = fmax(0.0, a->lambda[j]/a->rho - c);
        gsl_vector_set(out, a->n_residual + j, isfinite(v) ? sqrt(0.5*a->rho)*v : 0.0);
    }
    return GSL_SUCCESS;
}

static int derivatives(const gsl_vector *at, void *data, gsl_matrix *out)
{
    lagrangian *a = data;
    size_t m = a->stage->record->fn->m;
    double buf[LW_VAR_MAX], weight = sqrt(0.5*a->rho);
    const double *x = values(at, buf);
    if (lw_barrier_stage_over(a->stage) || !lw_record_residuals(a->stage->record, x, a->res, a->jac))
        return GSL_EBADFUNC;
    for (size_t i = 0; i < a->n_residual; i++)
        for (size_t k = 0; k < a->n; k++)
            gsl_matrix_set(out, i, k, a->jac[i*a->n + k]);
    const double *g = lw_record_conditions(a->stage->record, x, true);
    for (size_t j = 0; j < a->n_condition; j++) {
        bool active = a->lambda[j]/a->rho - condition(a, x, g, j) > 0.0;
        for (size_t k = 0; k < a->n; k++) {
            double dc = j < m ? a->stage->record->j[j*a->n + k]
                      : j - m == k ? 1.0 : j - m == k + a->n ? -1.0 : 0.0;
            gsl_matrix_set(out, a->n_residual + j, k, active ? -weight*dc : 0.0);
        }
    }
    return GSL_SUCCESS;
}

/* Minimise the sum for the current multipliers, from x; x becomes the end point. */
static lw_stop inner(lagrangian *a, gsl_multifit_nlinear_workspace *w, double *x)
{
    const lw_solver_options *o = a->stage->record->o;
    gsl_multifit_nlinear_fdf fdf = {
        .f = residuals, .df = derivatives, .n = a->n_residual + a->n_condition, .p = a->n, .params = a
    };
    gsl_vector_view start = gsl_vector_view_array(x, a->n);
    if (gsl_multifit_nlinear_init(&start.vector, &fdf, w) != GSL_SUCCESS)
        return LW_STOP_FAILED;
    lw_stop why = LW_STOP_EVALS;
    double before = gsl_blas_dnrm2(gsl_multifit_nlinear_residual(w));
    for (int k = 0; k < N_STEP; k++) {
        int status = gsl_multifit_nlinear_iterate(w), info;
        double f = gsl_blas_dnrm2(gsl_multifit_nlinear_residual(w));
        if (status == GSL_ENOPROG || (before - f <= 0.5*o->f_tol*f && f <= before))
            why = LW_STOP_F_TOL;
        else if (status != GSL_SUCCESS)
            why = LW_STOP_FAILED;
        else if (gsl_multifit_nlinear_test(o->x_tol, 0.0, 0.0, &info, w) == GSL_SUCCESS)
            why = LW_STOP_X_TOL;
        before = f;
        if (why != LW_STOP_EVALS || lw_barrier_stage_over(a->stage))
            break;
    }
    values(gsl_multifit_nlinear_position(w), x);
    return why;
}

/* Update the multipliers. Returns the largest violation or change of a multiplier. */
static double update(lagrangian *a, const double *x)
{
    const double *g = lw_record_conditions(a->stage->record, x, false);
    double worst = 0.0;
    for (size_t j = 0; j < a->n_condition; j++) {
        double c = condition(a, x, g, j);
        if (!isfinite(c))
            continue;
        worst = fmax(worst, fabs(fmin(c, a->lambda[j]/a->rho)));
        a->lambda[j] = fmax(0.0, a->lambda[j] - a->rho*c);
    }
    return worst;
}

static lw_stop rounds(lagrangian *a, gsl_multifit_nlinear_workspace *w, double *x)
{
    double worst = INFINITY, inside[LW_VAR_MAX];
    lw_stop why = LW_STOP_FAILED;
    for (int k = 0; k < N_ROUND && !lw_barrier_stage_over(a->stage); k++) {
        why = inner(a, w, x);
        memcpy(inside, x, a->n*sizeof *x);
        if (lw_finite(x, a->n) && lw_feasible_repair(a->stage->record, inside))
            lw_barrier_stage_value(a->stage, inside, NULL);
        double now = update(a, x);
        if (!(now > WELL_INSIDE))
            break;
        if (now > 0.25*worst)
            a->rho *= 10.0;
        worst = now;
    }
    return why;
}

lw_stop lw_gsl_lm(lw_barrier_stage *stage, const double *start)
{
    const lw_function *fn = stage->record->fn;
    lagrangian a = {
        .stage = stage, .n = fn->n, .n_residual = fn->n_residual, .n_condition = fn->m + 2*fn->n,
        .rho = 10.0*fmin(fmax(stage->record->f, 1e-8), 1e8)
    };
    double x[LW_VAR_MAX];
    memcpy(x, start, fn->n*sizeof *x);
    lw_clip(fn, x);
    if (!isfinite(lw_barrier_stage_value(stage, x, NULL)))
        return LW_STOP_FAILED;
    a.lambda = calloc(a.n_condition + fn->n_residual*(fn->n + 1), sizeof *a.lambda);
    lw_gsl_begin();
    gsl_multifit_nlinear_parameters how = gsl_multifit_nlinear_default_parameters();
    gsl_multifit_nlinear_workspace *w = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &how, a.n_residual + a.n_condition, a.n);
    lw_stop why = LW_STOP_FAILED;
    if (a.lambda && w) {
        a.res = a.lambda + a.n_condition;
        a.jac = a.res + fn->n_residual;
        why = rounds(&a, w, x);
    } else
        stage->record->no_memory = true;
    if (w)
        gsl_multifit_nlinear_free(w);
    lw_gsl_end();
    free(a.lambda);
    return why;
}
