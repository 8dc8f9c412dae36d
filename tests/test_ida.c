/* tests/test_ida.c - the bridge to IDA: Robertson's reactions, a pendulum as index-2 equations (GGL), events,
 * consistent starts, how failures are told. */
#include "mbs/ode/ida.h"
#include "tests/check.h"
#include "tests/ode_problems.h"

/* Robertson's reactions with the sum as third equation, index 1.  End values: Mazzia & Magherini, Test set for IVP
 * solvers 2.4, problem ROBER, t = 1e11. */
static lw_status robertson(void *context, double t, const double *y, const double *dy, double *r)
{
    (void)context, (void)t;
    double a = 0.04*y[0], b = 1e4*y[1]*y[2], c = 3e7*y[1]*y[1];
    r[0] = dy[0] + a - b;
    r[1] = dy[1] - a + b + c;
    r[2] = y[0] + y[1] + y[2] - 1.0;
    return LW_OK;
}

static lw_status robertson_slope(void *context, double t, double c, const double *y, const double *dy, double *jac)
{
    (void)context, (void)t, (void)dy;
    double row[3][3] = { { c + 0.04, -1e4*y[2], -1e4*y[1] },
                         { -0.04, c + 1e4*y[2] + 6e7*y[1], 1e4*y[1] }, { 1.0, 1.0, 1.0 } };
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            jac[i + 3*j] = row[i][j];
    return LW_OK;
}

TEST(robertson_published)
{
    for (int with = 0; with < 2; with++) {
        const unsigned char algebraic[3] = { 0, 0, 1 };
        const double each[3] = { 1e-14, 1e-18, 1e-14 };
        lw_dae dae = { .n = 3, .residual = robertson, .jacobian = with ? robertson_slope : NULL,
                       .algebraic = algebraic };
        lw_ode_options o = lw_ode_options_default();
        o.relative = 1e-9, o.absolute_each = each;
        OWN(lw_sundials) w = { 0 };
        double y[3] = { 1.0, 0.0, 0.0 }, dy[3] = { -0.04, 0.04, 0.0 };
        CHECK_INT(lw_ida_make(&w, &dae, &o, 0.0, y, dy, NULL), LW_OK);
        CHECK_INT(sundials_to(&w, 1e11, NULL), LW_OK);
        CHECK_NEAR(w.y[0], 0.2083340149701255e-7, 0, 1e-5);
        CHECK_NEAR(w.y[1], 0.8333360770334713e-13, 0, 1e-5);
        CHECK_NEAR(w.y[2], 0.9999999791665050, 1e-12, 0);
        CHECK(w.n_step < 5000);
    }
}

/* Pendulum of length 1 m in Cartesian coordinates, stabilised index 2 (Gear, Gupta & Leimkuhler 1985):
 * x' = v - J^T mu, v' = g - J^T lambda, phi(x) = 0, J v = 0.   y = x, y, vx, vy, lambda, mu. */
static const double gravity = 9.81;

static lw_status ggl(void *context, double t, const double *y, const double *dy, double *r)
{
    (void)context, (void)t;
    r[0] = dy[0] - y[2] + y[0]*y[5];
    r[1] = dy[1] - y[3] + y[1]*y[5];
    r[2] = dy[2] + y[0]*y[4];
    r[3] = dy[3] + gravity + y[1]*y[4];
    r[4] = y[0]*y[2] + y[1]*y[3];
    r[5] = 0.5*(y[0]*y[0] + y[1]*y[1] - 1.0);
    return LW_OK;
}

static lw_status ggl_slope(void *context, double t, double c, const double *y, const double *dy, double *jac)
{
    (void)context, (void)t, (void)dy;
    double row[6][6] = {
        { c + y[5], 0, -1, 0, 0, y[0] }, { 0, c + y[5], 0, -1, 0, y[1] }, { y[4], 0, c, 0, y[0], 0 },
        { 0, y[4], 0, c, y[1], 0 }, { y[2], y[3], y[0], y[1], 0, 0 }, { y[0], y[1], 0, 0, 0, 0 } };
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            jac[i + 6*j] = row[i][j];
    return LW_OK;
}

static lw_status by_angle(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[1], dy[1] = -gravity*sin(y[0]);
    return LW_OK;
}

static void exact_pendulum(double t, double *place, double *speed)
{
    lw_ode ode = { .n = 2, .rate = by_angle };
    lw_ode_options o = lw_ode_options_default();
    o.relative = o.absolute = 1e-14;
    lw_integrator w;
    double work[LW_INTEGRATE_WORK(2, 0)], y[2] = { 1.0, 0.0 };
    lw_integrate_start(&w, &ode, &o, work, 0.0, y, NULL);
    lw_ode_stop stop = LW_ODE_STEP;
    while (stop != LW_ODE_END && lw_integrate_step(&w, t, &stop, NULL) == LW_OK)
        continue;
    *place = w.y[0], *speed = w.y[1];
}

static const unsigned char multipliers[6] = { 0, 0, 0, 0, 1, 1 };
static void ggl_start(double *y, double *dy)
{
    double s = sin(1.0), c = cos(1.0), pull = gravity*c;
    double y0[6] = { s, -c, 0, 0, pull, 0 }, dy0[6] = { 0, 0, -s*pull, -gravity + c*pull, 0, 0 };
    memcpy(y, y0, sizeof y0);
    memcpy(dy, dy0, sizeof dy0);
}

TEST(pendulum_of_index_two)
{
    double angle, speed;
    exact_pendulum(5.0, &angle, &speed);
    for (double tolerance = 1e-5; tolerance > 1e-12; tolerance *= 0.1) {
        lw_dae dae = { .n = 6, .residual = ggl, .jacobian = ggl_slope, .algebraic = multipliers };
        lw_ode_options o = lw_ode_options_default();
        o.relative = o.absolute = tolerance;
        OWN(lw_sundials) w = { 0 };
        double y[6], dy[6];
        ggl_start(y, dy);
        CHECK_INT(lw_ida_make(&w, &dae, &o, 0.0, y, dy, NULL), LW_OK);
        CHECK_INT(sundials_to(&w, 5.0, NULL), LW_OK);
        CHECK_NEAR(w.y[0], sin(angle), 3000.0*tolerance, 0);
        CHECK_NEAR(w.y[1], -cos(angle), 3000.0*tolerance, 0);
        CHECK_NEAR(w.y[2], cos(angle)*speed, 10000.0*tolerance, 0);
        CHECK_NEAR(hypot(w.y[0], w.y[1]), 1.0, 10.0*tolerance, 0);
    }
}

static lw_status lowest(void *context, double t, const double *y, double *g)
{
    (void)context, (void)t;
    g[0] = y[0];
    return LW_OK;
}

/* passing the lowest point; the period of a pendulum let go at 1 rad is 4 K(sin 1/2)/sqrt g */
TEST(events_of_the_pendulum)
{
    double a = 1.0, b = cos(0.5);
    for (int i = 0; i < 8; i++) {
        double m = 0.5*(a + b);
        b = sqrt(a*b), a = m;
    }
    double agm = 0.5*3.14159265358979323846/a/sqrt(gravity);
    lw_dae dae = { .n = 6, .residual = ggl, .jacobian = ggl_slope, .algebraic = multipliers, .n_event = 1,
                   .event = lowest };
    lw_ode_options o = lw_ode_options_default();
    o.relative = o.absolute = 1e-10;
    OWN(lw_sundials) w = { 0 };
    double y[6], dy[6];
    ggl_start(y, dy);
    CHECK_INT(lw_ida_make(&w, &dae, &o, 0.0, y, dy, NULL), LW_OK);
    lw_ode_stop stop;
    int k = 0;
    while (lw_sundials_step(&w, 3.0, &stop, NULL) == LW_OK && stop != LW_ODE_END)
        if (stop == LW_ODE_EVENT)
            CHECK_NEAR(w.t, (2*k++ + 1)*agm, 1e-7, 0);
    CHECK_INT(k, 3);
    double in[6];
    CHECK_INT(lw_sundials_dense(&w, w.t, in), LW_OK);
    CHECK(in[0] == w.y[0]);
    ggl_start(y, dy);
    CHECK_INT(lw_ida_restart(&w, y, dy, NULL), LW_OK);
    stop = LW_ODE_STEP;
    while (stop == LW_ODE_STEP)
        CHECK_INT(lw_sundials_step(&w, 6.0, &stop, NULL), LW_OK);
    CHECK_NEAR(w.t, 3.0 + agm, 1e-7, 0);
    CHECK_INT(lw_sundials_dense(&w, w.t - 1e-4, in), LW_OK);
    CHECK(in[0] > 0.0);
}

static lw_status breaks_residual(void *context, double t, const double *y, const double *dy, double *r)
{
    (void)context;
    r[0] = dy[0] - y[0];
    return t > 0.5 ? LW_E_KIND : LW_OK;
}

TEST(failures_are_told)
{
    lw_ode_options o = lw_ode_options_default();
    lw_sundials w;
    double y[6] = { 1.0 }, dy[6] = { 1.0 };
    lw_dae dae = { .n = 1, .residual = breaks_residual };
    CHECK_OK(lw_ida_make(&w, &dae, &o, 0.0, y, dy, &check_error));
    CHECK_FAILS(sundials_to(&w, 2.0, &check_error), LW_E_KIND, "IDA gave up at t = ");
    lw_sundials_free(&w);
    ggl_start(y, dy);
    y[0] = 2.0;                                              /* off the circle by far */
    lw_dae pendulum = { .n = 6, .residual = ggl, .algebraic = multipliers };
    CHECK_OK(lw_ida_make(&w, &pendulum, &o, 0.0, y, dy, &check_error));
    CHECK(sundials_to(&w, 1.0, &check_error) != LW_OK || fabs(hypot(w.y[0], w.y[1]) - 1.0) < 1e-6);
    lw_sundials_free(&w);
    o.max_step = 20;
    ggl_start(y, dy);
    CHECK_OK(lw_ida_make(&w, &pendulum, &o, 0.0, y, dy, &check_error));
    CHECK_INT(sundials_to(&w, 100.0, &check_error), LW_STOPPED);
    lw_sundials_free(&w);
    lw_sundials_free(&w);
    o.fixed = 0.1;
    CHECK_INT(lw_ida_make(&w, &pendulum, &o, 0.0, y, dy, &check_error), LW_E_ARG);
}
