/* tests/test_cvode.c - the bridge to CVODE: a stiff problem with a published solution, events, projection, how
 * failures are told. */
#include "mbs/ode/cvode.h"
#include "tests/check.h"
#include "tests/ode_problems.h"

/* Van der Pol, mu = 1e3 in scaled time (1e-6 in front): Mazzia & Magherini, Test set for IVP solvers 2.4, problem
 * VDPOL: y(2) = 1.706167732170483, -0.8928097010247975. */
static lw_status van_der_pol(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[1];
    dy[1] = ((1.0 - y[0]*y[0])*y[1] - y[0])/1e-6;
    return LW_OK;
}

static lw_status van_der_pol_slope(void *context, double t, const double *y, const double *dy, double *jac)
{
    (void)context, (void)t, (void)dy;
    jac[0] = 0.0, jac[2] = 1.0;
    jac[1] = (-2.0*y[0]*y[1] - 1.0)/1e-6, jac[3] = (1.0 - y[0]*y[0])/1e-6;
    return LW_OK;
}

TEST(stiff_published)
{
    for (int with = 0; with < 2; with++)
        for (double tolerance = 1e-6; tolerance > 1e-11; tolerance *= 0.01) {
            lw_ode ode = { .n = 2, .rate = van_der_pol, .jacobian = with ? van_der_pol_slope : NULL };
            lw_ode_options o = lw_ode_options_default();
            o.relative = o.absolute = tolerance;
            OWN(lw_sundials) w = { 0 };
            double y[2] = { 2.0, 0.0 };
            CHECK_INT(lw_cvode_make(&w, &ode, &o, LW_CVODE_BDF, 0.0, y, NULL), LW_OK);
            CHECK_INT(sundials_to(&w, 2.0, NULL), LW_OK);
            CHECK_NEAR(w.y[0], 1.706167732170483, 2000.0*tolerance, 0);
            CHECK_NEAR(w.y[1], -0.8928097010247975, 2000.0*tolerance, 0);
            CHECK(w.t == 2.0 && w.n_step > 50 && w.n_step < 20000 && w.n_jacobian > 0);
        }
}

typedef struct seen_list { int n; double t[16]; } seen_list;
static void note(void *context, int event, double t, const double *y)
{
    (void)y, (void)event;
    seen_list *l = context;
    if (l->n < 16)
        l->t[l->n++] = t;
}

TEST(events_in_order)
{
    const double pi = 3.14159265358979323846;
    seen_list l = { 0 };
    lw_ode ode = { .n = 2, .context = &l, .rate = oscillator, .n_event = 2, .event = two_levels, .direction = { 0, -1 },
                   .passing = { false, true }, .seen = note };
    lw_ode_options o = lw_ode_options_default();
    o.relative = o.absolute = 1e-11;
    OWN(lw_sundials) w = { 0 };
    double y[2] = { 1.0, 0.0 };
    CHECK_INT(lw_cvode_make(&w, &ode, &o, LW_CVODE_ADAMS, 0.0, y, NULL), LW_OK);
    lw_ode_stop stop;
    int k = 0;
    while (lw_sundials_step(&w, 10.0, &stop, NULL) == LW_OK && stop != LW_ODE_END)
        if (stop == LW_ODE_EVENT) {
            CHECK_NEAR(w.t, (k++ + 0.5)*pi, 1e-8, 0);
            CHECK_INT((int)w.events & 1, 1);
            CHECK_NEAR(w.y[0], 0.0, 1e-13, 0);
            double early[2];                                 /* inside the step that the event ended */
            CHECK_INT(lw_sundials_dense(&w, w.t - 1e-3, early), LW_OK);
            CHECK_NEAR(early[0], cos(w.t - 1e-3), 1e-8, 0);
        }
    CHECK_INT(k, 3);
    CHECK_INT(l.n, 2);
    CHECK_NEAR(l.t[0], pi/3, 1e-8, 0);
    CHECK_NEAR(l.t[1], 7*pi/3, 1e-8, 0);
    CHECK(w.t == 10.0);
    /* an end shortly after an event, which CVODE has passed already, and a state put in by hand */
    CHECK_INT(lw_cvode_restart(&w, y, 0, NULL), LW_OK);
    stop = LW_ODE_STEP;
    while (stop == LW_ODE_STEP)
        CHECK_INT(lw_sundials_step(&w, 20.0, &stop, NULL), LW_OK);
    CHECK_NEAR(w.t, 10.0 + pi/2, 1e-8, 0);
    CHECK_INT(sundials_to(&w, w.t + 1e-6, NULL), LW_OK);
    CHECK_NEAR(w.y[0], -1e-6, 1e-8, 0);
}

TEST(projection)
{
    double drift[2];
    for (int with = 0; with < 2; with++) {
        lw_ode ode = { .n = 4, .rate = pendulum, .project = with ? onto_circle : NULL };
        lw_ode_options o = lw_ode_options_default();
        o.relative = o.absolute = 1e-7;
        OWN(lw_sundials) w = { 0 };
        double y[4] = { 1.0, 0.0, 0.0, 0.0 };
        CHECK_INT(lw_cvode_make(&w, &ode, &o, LW_CVODE_BDF, 0.0, y, NULL), LW_OK);
        CHECK_INT(sundials_to(&w, 10.0, NULL), LW_OK);
        drift[with] = fabs(hypot(w.y[0], w.y[1]) - 1.0);
    }
    CHECK(drift[0] > 1e-8);
    CHECK(drift[1] < 1e-9);
}

TEST(failures_are_told)
{
    lw_ode_options o = lw_ode_options_default();
    lw_sundials w;
    double y[2] = { 1.0, 0.0 };
    lw_ode bad = { .n = 1, .rate = explodes };
    CHECK_OK(lw_cvode_make(&w, &bad, &o, LW_CVODE_BDF, 0.0, y, &check_error));
    CHECK_FAILS(sundials_to(&w, 2.0, &check_error), LW_E_NUMERIC, "CVODE gave up at t = ");
    CHECK(w.t < 1.0 + 1e-6 && w.t > 0.9);
    lw_sundials_free(&w);
    bad.rate = breaks;
    CHECK_OK(lw_cvode_make(&w, &bad, &o, LW_CVODE_BDF, 0.0, y, &check_error));
    CHECK_INT(sundials_to(&w, 2.0, &check_error), LW_E_KIND);
    lw_sundials_free(&w);
    lw_ode ode = { .n = 2, .rate = oscillator };
    o.max_step = 20;
    CHECK_OK(lw_cvode_make(&w, &ode, &o, LW_CVODE_BDF, 0.0, y, &check_error));
    CHECK_INT(sundials_to(&w, 1e3, &check_error), LW_STOPPED);
    lw_ode_stop stop;
    CHECK_INT(lw_sundials_step(&w, -1.0, &stop, &check_error), LW_E_ARG);
    lw_sundials_free(&w);
    lw_sundials_free(&w);                                       /* twice is harmless */
    o = (lw_ode_options){ .relative = -1.0 };
    CHECK_INT(lw_cvode_make(&w, &ode, &o, LW_CVODE_BDF, 0.0, y, &check_error), LW_E_ARG);
    o = (lw_ode_options){ .relative = 1e-6, .absolute = 1e-6, .fixed = 0.1 };
    CHECK_INT(lw_cvode_make(&w, &ode, &o, LW_CVODE_BDF, 0.0, y, &check_error), LW_E_ARG);
}
