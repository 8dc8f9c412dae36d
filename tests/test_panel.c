/* Integrals by sixteen values against closed forms. */
#include "mbs/ode/panel_internal.h"

#include <math.h>
#include "tests/check.h"

static lw_panel_rule r;

static void values(double rate, double *f)
{
    for (int i = 0; i < LW_PANEL_NODES; i++)
        f[i] = exp(rate*r.at[i]);
}

TEST(means_of_an_exponential)
{
    double f[LW_PANEL_NODES], m[LW_PANEL_NODES], c[LW_PANEL_NODES];
    for (double rate = -3; rate <= 3; rate += 1.5) {
        values(rate, f);
        lw_panel_apply(&r.mean, f, m);
        for (int i = 0; i < LW_PANEL_NODES; i++)
            CHECK_NEAR(m[i], rate == 0 ? 1 : expm1(rate*r.at[i])/(rate*r.at[i]), 1e-14, 1e-14);
        CHECK_NEAR(lw_panel_sum(r.whole, f), rate == 0 ? 1 : expm1(rate)/rate, 1e-14, 1e-14);
        lw_panel_apply(&r.coef, f, c);
        for (double x = 0; x <= 1; x += 0.1)
            CHECK_NEAR(lw_panel_value(c, x), exp(rate*x), 1e-13, 1e-13);
        CHECK(lw_panel_tail(&r, f) < 1e-13);
    }
}

/* int_0^u exp(a u'^2) du' for a = -1: the error function. */
TEST(roots_of_an_exponential)
{
    double f[LW_PANEL_NODES], h[LW_PANEL_NODES], c[LW_PANEL_NODES];
    values(-1, f);
    lw_panel_apply(&r.root, f, h);
    lw_panel_apply(&r.coef, h, c);
    for (double u = -1; u <= 1; u += 0.125)
        CHECK_NEAR(u*lw_panel_value(c, u*u), 0.5*sqrt(acos(-1.0))*erf(u), 1e-14, 0);
}

TEST(what_is_not_resolved_is_seen)
{
    double f[LW_PANEL_NODES];
    for (int i = 0; i < LW_PANEL_NODES; i++)
        f[i] = 1/(r.at[i] + 0.01);
    CHECK(lw_panel_tail(&r, f) > 1e-4);
    for (int i = 0; i < LW_PANEL_NODES; i++)
        f[i] = 0;
    CHECK(lw_panel_tail(&r, f) == 0);
}

CHECK_MAIN
{
    CHECK_INT(lw_panel_rule_make(&r), LW_OK);
    check_run();
    return check_end();
}
