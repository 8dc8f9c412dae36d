/* The log barrier: its gradient, its path, its stages, and what stands outside it. */
#include "tests/check.h"
#include "tests/functions.h"
#include "optimise/solvers/method_internal.h"

static const double low[3] = { -4.5, -4.5, -5 }, high[3] = { 4.5, 4.5, 5 };

TEST(gradient_is_the_slope)
{
    lw_function fn = hs65();
    lw_solver_options o = lw_solver_options_default();
    o.max_evals = 1000000;
    lw_record r;
    lw_rng rng = check_rng(1);
    CHECK_INT(lw_record_open(&r, &fn, &o), LW_OK);
    for (int trial = 0; trial < 300; trial++) {
        double k = trial%3 ? pow(10, lw_rng_range(&rng, -4, 1)) : 0, x[3], g[3], h = 1e-5;
        for (int i = 0; i < 3; i++)
            x[i] = lw_rng_range(&rng, 0.9*low[i], 0.9*high[i]);
        lw_barrier_stage s = { .record = &r, .k = k, .wall = 1000, .last_eval = 1000000, .best = INFINITY, .lowest = INFINITY };
        double room = lw_record_conditions(&r, x, false)[0];
        if (fabs(room) < 0.1 || (room < 0 && k == 0))           /* the kink, and where f counts */
            continue;
        double f = lw_barrier_stage_value(&s, x, g);
        CHECK((f >= 1000) == (room < 0));
        CHECK(isinf(lw_barrier_value(&r, k, x, NULL)) == (room < 0));
        for (int i = 0; i < 3; i++) {
            double y[3] = { x[0], x[1], x[2] };
            y[i] = x[i] + h;
            double up = lw_barrier_stage_value(&s, y, NULL);
            y[i] = x[i] - h;
            double down = lw_barrier_stage_value(&s, y, NULL);
            /* h^2 F'''/6 with F''' up to 2 k (0.2*5/0.1)^3; rounding eps F/h */
            CHECK_NEAR((up - down)/(2*h), g[i], 1e-10*(1 + k)*1e3 + 1e-10*fabs(f), 1e-8);
        }
    }
    lw_record_close(&r);
}

/* min (x - 2)^2, 1 - x >= 0.  The optimum of F is at 1 - x = (sqrt(1 + 2k) - 1)/2, and f there is above
 * f* = 1 by k to first order. */
static double hill(void *context, const double *x, double *grad)
{
    (void)context;
    if (grad)
        grad[0] = 2*(x[0] - 2);
    return (x[0] - 2)*(x[0] - 2);
}

static void one_minus_x(void *context, const double *x, double *g, double *j)
{
    (void)context;
    g[0] = 1 - x[0];
    if (j)
        j[0] = -1;
}

static const double far_lo = -10, far_hi = 10;

static lw_function hill_function(void)
{
    return (lw_function){ .n = 1, .m = 1, .lo = &far_lo, .hi = &far_hi, .value = hill,
                          .conditions = one_minus_x };
}

TEST(path_ends_at_the_constrained_optimum)
{
    lw_function fn = hill_function();
    lw_solver_options o = lw_solver_options_default();
    for (double k = 1; k > 1e-7; k *= 0.1) {
        lw_record r;
        CHECK_INT(lw_record_open(&r, &fn, &o), LW_OK);
        double x = 0.3, u = k/(sqrt(1 + 2*k) + 1);              /* stable form */
        lw_single_run(&r, lw_gradient, k, true, &x);
        /* F is flat: eps F = F'' dx^2/2, F'' = 2 + k/u^2 */
        double blur = 4*sqrt(2e-16/(2 + k/(u*u)));
        CHECK_NEAR(1 - x, u, blur, 1e-9);
        CHECK_NEAR(hill(NULL, &x, NULL) - 1, k, 2*blur, 0.5*k + 1e-9);
        lw_record_close(&r);
    }
    static const double last[] = { 1e-4, 1e-7, 1e-10 };
    for (int i = 0; i < 3; i++) {
        double x = -3;
        lw_solver_result r;
        o.barrier_last = last[i];
        CHECK_INT(lw_method_run(lw_solver_find("gradient"), &fn, &o, &x, &r), LW_OK);
        CHECK(x <= 1 + LW_FEASIBLE);
        CHECK(r.f >= 1 - 2*LW_FEASIBLE && r.f - 1 < 1.1*last[i]);
    }
}

TEST(starts_from_outside)
{
    lw_function fn = hs65();
    lw_solver_options o = lw_solver_options_default();
    double x[3] = { 4.5, -4.5, 5 }, best = hs65_optimum();
    lw_solver_result r;
    CHECK_INT(lw_method_run(lw_solver_find("lbfgs"), &fn, &o, x, &r), LW_OK);
    CHECK_NEAR(r.f, best, 1e-9, 0);
    CHECK(r.f >= best - 10*LW_FEASIBLE);     /* the multiplier is about 1.4 */
}

/* 1 - x >= 0 and x - 1 - 1e-6 >= 0 */
static void contradiction(void *context, const double *x, double *g, double *j)
{
    (void)context;
    g[0] = 1 - x[0];
    g[1] = x[0] - 1 - 1e-6;
    if (j)
        j[0] = -1, j[1] = 1;
}

TEST(says_that_nothing_is_feasible)
{
    lw_function fn = hill_function();
    lw_solver_options o = lw_solver_options_default();
    fn.conditions = contradiction;
    fn.m = 2;
    double x = 0.25;
    lw_solver_result r;
    CHECK_INT(lw_method_run(lw_solver_find("lbfgs"), &fn, &o, &x, &r), LW_NOTHING);
    CHECK_INT(r.stop, LW_STOP_FAILED);
    CHECK(isinf(r.f) && x == 0.25);
}
