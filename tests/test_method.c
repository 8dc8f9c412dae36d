/* Every method: how near it comes, what it keeps to, and that it repeats. */
#include <pthread.h>
#include "optimise/solvers/method_internal.h"
#include "tests/check.h"
#include "tests/functions.h"

/* f - f* that 10000 evaluations must reach on HS65 (one active condition) and in Rosenbrock's valley
 * (none).  1e-9: to rounding of the conditions and the last k of the barrier.  The barrier is what
 * methods without gradient find hard; those that search the box stay coarse. */
static const struct { const char *name; double hs65, valley; } level[] = {
    { "lm-gsl",     1e-9, 1e-25 }, { "gradient",   1e-9, 1e-20 }, { "gradient-fixed", 0.2, 1e-3 },
    { "slsqp",      1e-9, 1e-20 }, { "mma",        1e-9, 1e-12 }, { "ccsaq",      1e-9, 1e-12 },
    { "lbfgs",      1e-9, 1e-20 }, { "tnewton",    1e-9, 1e-18 }, { "cobyla",     1e-9, 1e-5  },
    { "bobyqa",     1e-4, 1e-20 }, { "neldermead", 1e-7, 1e-20 }, { "sbplx",      1e-3, 1e-20 },
    { "crs",        1e-7, 1e-12 }, { "isres",      1e-2, 1e-3  }, { "esch",       0.5,  1e-2  },
    { "direct",     0.1,  1e-10 }, { "mlsl",       1e-7, 1e-20 },
};
#define N_LEVEL (sizeof level/sizeof *level)

TEST(table_is_whole)
{
    size_t n = 0;
    for (size_t i = 0; i < N_LEVEL; i++) {
        const lw_solver *m = lw_solver_find(level[i].name);
        CHECK(m != NULL);
        n += m != NULL;
    }
    CHECK_INT(n, N_LEVEL);
    CHECK(lw_solver_find("simplex") == NULL);
    for (int s = LW_STOP_F_TOL; s <= LW_STOP_FAILED; s++)
        for (int t = s + 1; t <= LW_STOP_FAILED + 1; t++)
            CHECK(strcmp(lw_stop_text((lw_stop)s), lw_stop_text((lw_stop)t)) != 0);
}

TEST(reaches_its_level_under_a_condition)
{
    static const double start[3][3] = { { -4.5, 4.5, 0 }, { 4.5, 4.5, -5 }, { 2, 3, 1 } };
    lw_function fn = hs65();
    lw_solver_options o = lw_solver_options_default();
    double best = hs65_optimum();
    CHECK_NEAR(best, 0.9535288567, 1.5e-10, 0);       /* Hock & Schittkowski 1981, ten digits */
    for (size_t i = 0; i < N_LEVEL; i++)
        for (int k = 0; k < 3; k++) {
            double x[3] = { start[k][0], start[k][1], start[k][2] }, g;
            lw_solver_result r;
            lw_status s = lw_method_run(lw_solver_find(level[i].name), &fn, &o, x, &r);
            CHECK(s == LW_OK || s == LW_STOPPED);
            CHECK_NEAR(r.f, hs65_value(NULL, x, NULL), 0, 0);
            hs65_conditions(NULL, x, &g, NULL);
            CHECK(g >= -LW_FEASIBLE && r.f > best - 1e-10);
            for (int d = 0; d < 3; d++)
                CHECK(x[d] >= fn.lo[d] && x[d] <= fn.hi[d]);
            if (!(r.f - best < level[i].hs65))
                fprintf(stderr, "%s from start %d: f - f* = %g\n", level[i].name, k, r.f - best);
            CHECK(r.f - best < level[i].hs65);
            CHECK(r.evals <= o.max_evals);
        }
}

TEST(reaches_its_level_without)
{
    const double lo[2] = { -2, -2 }, hi[2] = { 2, 2 };
    lw_function fn = valley(lo, hi);
    lw_solver_options o = lw_solver_options_default();
    for (size_t i = 0; i < N_LEVEL; i++) {
        double x[2] = { -1.2, 1 };
        lw_solver_result r;
        CHECK(lw_method_run(lw_solver_find(level[i].name), &fn, &o, x, &r) >= 0);
        if (!(r.f < level[i].valley))
            fprintf(stderr, "%s: f = %g\n", level[i].name, r.f);
        CHECK(r.f < level[i].valley);
        CHECK(r.evals <= o.max_evals);
    }
}

/* x2 <= 0.25 cuts the valley: the optimum is on the bound, where 2 x1 = 1 + O(0.005). */
TEST(reaches_an_optimum_on_a_bound)
{
    const double lo[2] = { -2, -2 }, hi[2] = { 2, 0.25 };
    lw_function fn = valley(lo, hi);
    lw_solver_options o = lw_solver_options_default();
    double t = 0.5;
    for (int k = 0; k < 50; k++)                      /* 200 t (t^2 - 1/4) = 1 - t */
        t -= (200*t*(t*t - 0.25) - 1 + t)/(600*t*t - 49);
    double best = 100*(0.25 - t*t)*(0.25 - t*t) + (1 - t)*(1 - t);
    static const char *local[] = { "lm-gsl", "gradient", "slsqp", "mma", "ccsaq", "lbfgs", "tnewton" };
    for (int i = 0; i < 7; i++) {
        double x[2] = { -1.2, 0.1 };
        lw_solver_result r;
        CHECK(lw_method_run(lw_solver_find(local[i]), &fn, &o, x, &r) >= 0);
        if (!(r.f - best < 1e-9))
            fprintf(stderr, "%s: f - f* = %g\n", local[i], r.f - best);
        CHECK_NEAR(r.f, best, 1e-9, 0);
        CHECK(x[1] <= 0.25);
    }
}

TEST(keeps_what_is_fixed)
{
    const double lo[2] = { -2, 0.25 }, hi[2] = { 2, 0.25 };
    lw_function fn = valley(lo, hi), stuck = valley(lo, lo);
    lw_solver_options o = lw_solver_options_default();
    for (size_t i = 0; i < N_LEVEL; i++) {
        double x[2] = { -1.2, 0.25 };
        lw_solver_result r;
        lw_status s = lw_method_run(lw_solver_find(level[i].name), &fn, &o, x, &r);
        CHECK(s >= 0 && x[1] == 0.25 && r.f <= valley_value(NULL, (double[]){ -1.2, 0.25 }, NULL));
        CHECK(lw_method_run(lw_solver_find(level[i].name), &stuck, &o, x, &r) == LW_OK);
        CHECK(x[0] == -2 && x[1] == 0.25 && r.evals == 1);
    }
}

/* A value that is not defined on half of the box, and not a number in places. */
static double broken_value(void *context, const double *x, double *grad)
{
    double f = valley_value(context, x, grad);
    if (x[0] < -1.5)
        f = NAN;
    else if (x[0] + x[1] < -1)
        f = INFINITY;
    for (int k = 0; grad && !isfinite(f) && k < 2; k++)
        grad[k] = x[0] < -1.5 ? NAN : -1;
    return f;
}

static bool broken_residuals(void *context, const double *x, double *r, double *j)
{
    return isfinite(broken_value(context, x, NULL)) && valley_residuals(context, x, r, j);
}

TEST(survives_undefined_values)
{
    const double lo[2] = { -2, -2 }, hi[2] = { 2, 2 };
    lw_function fn = valley(lo, hi);
    lw_solver_options o = lw_solver_options_default();
    fn.value = broken_value;
    fn.residuals = broken_residuals;
    o.max_evals = 3000;
    for (size_t i = 0; i < N_LEVEL; i++) {
        double x[2] = { -1.2, 1 }, y[2] = { -1.9, 0 };
        lw_solver_result r;
        CHECK(lw_method_run(lw_solver_find(level[i].name), &fn, &o, x, &r) >= 0);
        CHECK(isfinite(r.f) && r.f <= 24.2 && r.evals <= 3000);
        lw_status s = lw_method_run(lw_solver_find(level[i].name), &fn, &o, y, &r);
        CHECK(s >= 0 && (s == LW_NOTHING) == !isfinite(r.f));
    }
}

typedef struct run { const char *name; double x[3]; lw_solver_result r; uint64_t seed; } run;

static void *solve(void *data)
{
    run *a = data;
    lw_function fn = hs65();
    lw_solver_options o = lw_solver_options_default();
    o.seed = a->seed;
    o.max_evals = 2000;
    a->x[0] = -4.5, a->x[1] = 4.5, a->x[2] = 0;
    lw_method_run(lw_solver_find(a->name), &fn, &o, a->x, &a->r);
    return NULL;
}

TEST(repeats_for_a_seed_on_any_thread)
{
    run alone[N_LEVEL], beside[N_LEVEL], other = { .name = "esch", .seed = 8 };
    pthread_t thread[N_LEVEL];
    for (size_t i = 0; i < N_LEVEL; i++) {
        alone[i] = beside[i] = (run){ .name = level[i].name, .seed = 7 };
        solve(&alone[i]);
    }
    for (size_t i = 0; i < N_LEVEL; i++)
        CHECK_INT(pthread_create(&thread[i], NULL, solve, &beside[i]), 0);
    for (size_t i = 0; i < N_LEVEL; i++) {
        pthread_join(thread[i], NULL);
        CHECK(memcmp(alone[i].x, beside[i].x, sizeof alone[i].x) == 0);
        CHECK(alone[i].r.f == beside[i].r.f && alone[i].r.evals == beside[i].r.evals);
        CHECK_INT(alone[i].r.stop, beside[i].r.stop);
    }
    solve(&other);
    CHECK(other.x[0] != alone[14].x[0]);              /* another seed, another way */
}
