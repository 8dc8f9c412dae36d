/* The record: what it keeps, what it counts, when it stops. */
#include "tests/check.h"
#include "tests/functions.h"
#include "optimise/solvers/method_internal.h"

static lw_solver_options options(void) { return lw_solver_options_default(); }

TEST(keeps_the_best_feasible_point)
{
    lw_function fn = hs65();
    lw_solver_options o = options();
    lw_record r;
    CHECK_INT(lw_record_open(&r, &fn, &o), LW_OK);
    const double good[3] = { 3.6, 3.6, 4.6 }, worse[3] = { 1, 1, 1 }, out[3] = { 4, 4, 5 };
    const double beyond[3] = { 4, 4.6, 1 };
    lw_record_value(&r, worse, NULL);
    double f = lw_record_value(&r, good, NULL);
    CHECK(lw_record_value(&r, out, NULL) < f);                 /* lower, but g < 0            */
    CHECK_NEAR(lw_record_violation(&r, out), 0.9, 1e-14, 0);   /* (48 - 16 - 16 - 25)/10      */
    CHECK_NEAR(lw_record_violation(&r, beyond), 0.1, 1e-14, 0);
    lw_record_value(&r, worse, NULL);
    CHECK_NEAR(r.f, f, 0, 0);
    CHECK(memcmp(r.x, good, sizeof good) == 0);
    CHECK_INT(r.evals, 4);
    lw_record_close(&r);
}

/* A method that sees a good point and ends with worse, infeasible and undefined ones. */
static lw_stop liar(lw_barrier_stage *s, const double *x)
{
    const double good[3] = { 3.6, 3.6, 4.6 }, out[3] = { 4, 4, 5 }, none[3] = { NAN, 0, 0 };
    lw_barrier_stage_value(s, good, NULL);
    lw_barrier_stage_value(s, x, NULL);
    CHECK(isfinite(lw_barrier_stage_value(s, none, NULL)));
    lw_barrier_stage_value(s, out, NULL);
    return LW_STOP_F_TOL;
}

TEST(trusts_no_method)
{
    const lw_solver rows[2] = {
        { .name = "liar", .takes_constraints = true, .minimise = liar },
        { .name = "liar", .global = true, .minimise = liar },
    };
    lw_function fn = hs65();
    lw_solver_options o = options();
    for (int i = 0; i < 2; i++) {
        double x[3] = { 0, 0, 0 };
        lw_solver_result r;
        CHECK_INT(lw_method_run(&rows[i], &fn, &o, x, &r), LW_OK);
        CHECK_NEAR(x[0], 3.6, 0, 0);
        CHECK_NEAR(r.f, hs65_value(NULL, x, NULL), 0, 0);
        CHECK_INT(r.stop, LW_STOP_F_TOL);
    }
}

/* A method that comes to the condition from outside and stays a little outside. */
static lw_stop outsider(lw_barrier_stage *s, const double *x)
{
    double t = sqrt(48/3.0) + 1e-10, y[3] = { t, t, t };
    (void)x;
    lw_barrier_stage_value(s, y, NULL);
    return LW_STOP_X_TOL;
}

TEST(moves_the_nearly_feasible_inside)
{
    const lw_solver row = { .name = "outsider", .takes_constraints = true, .minimise = outsider };
    lw_function fn = hs65();
    lw_solver_options o = options();
    for (long limit = 2; limit < 5; limit++) {
        double x[3] = { 0, 0, 0 }, g;
        lw_solver_result r;
        o.max_evals = limit;
        lw_method_run(&row, &fn, &o, x, &r);
        CHECK(r.evals <= limit);
        if (limit < 3)                                /* start and last leave nothing for the method */
            continue;
        hs65_conditions(NULL, x, &g, NULL);
        CHECK(g >= -LW_FEASIBLE);
        CHECK_NEAR(x[1], 4, 1e-12, 0);
    }
}

typedef struct watch { long n; double last; int *interrupt; } watch;

static void watch_improvement(void *context, long evals, double seconds, double f)
{
    watch *w = context;
    CHECK(f < w->last);
    CHECK(evals > w->n && seconds >= 0);
    w->last = f;
    w->n = evals;
    if (w->interrupt && evals > 5)
        *w->interrupt = 1;
}

TEST(tells_and_stops)
{
    const double lo[2] = { -2, -2 }, hi[2] = { 2, 2 };
    lw_function fn = valley(lo, hi);
    static const struct { lw_stop stop; lw_status status; } row[] = {
        { LW_STOP_EVALS, LW_STOPPED }, { LW_STOP_F_TARGET, LW_OK }, { LW_STOP_USER, LW_STOPPED },
        { LW_STOP_TIME, LW_STOPPED }
    };
    for (int i = 0; i < 4; i++) {
        lw_solver_options o = options();
        int interrupt = 0;
        watch w = { 0, INFINITY, i == 2 ? &interrupt : NULL };
        double x[2] = { -1.2, 1 };
        lw_solver_result r;
        o.improved = watch_improvement;
        o.context = &w;
        o.interrupt = &interrupt;
        o.max_evals = i == 0 ? 17 : 10000;
        o.f_target = i == 1 ? 1e-3 : -1;
        o.max_seconds = i == 3 ? 1e-9 : 0;
        CHECK_INT(lw_method_run(lw_solver_find("lbfgs"), &fn, &o, x, &r),
                  i == 3 ? LW_NOTHING : row[i].status);           /* no time for a single value */
        CHECK_INT(r.stop, row[i].stop);
        CHECK(r.evals <= o.max_evals);
        if (i == 3)
            continue;
        CHECK_NEAR(r.f, w.last, 0, 0);
        CHECK_NEAR(r.f, valley_value(NULL, x, NULL), 0, 0);
    }
}

TEST(refuses_bad_options)
{
    const double lo[2] = { -2, -2 }, hi[2] = { 2, 2 };
    lw_function fn = valley(lo, hi);
    const lw_solver *m = lw_solver_find("slsqp");
    lw_solver_result r;
    double x[2] = { 0, 0 }, nan[2] = { 0, NAN };
    lw_solver_options o;
    CHECK_INT((o = options(), o.max_evals = 0, lw_method_run(m, &fn, &o, x, &r)), LW_E_ARG);
    CHECK_INT((o = options(), o.max_seconds = -1, lw_method_run(m, &fn, &o, x, &r)), LW_E_ARG);
    CHECK_INT((o = options(), o.f_tol = NAN, lw_method_run(m, &fn, &o, x, &r)), LW_E_ARG);
    CHECK_INT((o = options(), o.barrier_ratio = 1, lw_method_run(m, &fn, &o, x, &r)), LW_E_ARG);
    CHECK_INT((o = options(), o.barrier_last = 1, lw_method_run(m, &fn, &o, x, &r)), LW_E_ARG);
    CHECK_INT((o = options(), o.step = 0, lw_method_run(m, &fn, &o, x, &r)), LW_E_ARG);
    CHECK_INT((o = options(), lw_method_run(m, &fn, &o, nan, &r)), LW_E_ARG);
    CHECK(x[0] == 0 && x[1] == 0 && isinf(r.f));
}
