/* The spread of a path under tolerances: the linear figure against differences of a plain formula, random linkages
 * against the linear figure where tolerances are small, and against a Monte Carlo of the test's own where they are
 * not. */
#include "optimise/report/robustness.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

enum { POSTURES = 24 };
static const double bar[9] = { 3.1, 1.0, 2.7, 2.2, 1.3, 0.9, 0.4, -0.3, 0.25 };

static void make_bar(lw_linkage *k, double *input)
{
    fourbar_linkage(k, bar, 1, 0.4);
    k->n_tracer = 1;
    k->tracer[0].link = 2;
    k->tracer[0].at = fourbar_at(bar, 1, 0.4).p;
    for (int i = 0; i < POSTURES; i++)
        input[i] = 2*LW_PI*i/POSTURES;
}

/* theta0 varies by the tolerance over the mean length, all others by a third of the tolerance. */
TEST(linear_figure_is_that_of_differences)
{
    lw_linkage k;
    lw_robustness r;
    lw_tolerances of = { .length = 1e-4, .trials = 4000, .seed = 1 };
    double input[POSTURES], size = 0, all = 0, part[9] = { 0 };
    make_bar(&k, input);
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &r, NULL), LW_OK);
    for (int d = 0; d < 6; d++)                            /* r1 r2 r3 r4 cx cy                          */
        size += fabs(bar[d])/6;
    for (int d = 0; d < 9; d++)
        for (int i = 0; i < POSTURES; i++) {
            double up[9], down[9], h = 1e-6, sigma = of.length/3/(d == 8 ? size : 1);
            memcpy(up, bar, sizeof up);
            memcpy(down, bar, sizeof down);
            up[d] += h;
            down[d] -= h;
            lw_vec2 by = lw_v2_sub(fourbar_at(up, 1, 0.4 + input[i]).p, fourbar_at(down, 1, 0.4 + input[i]).p);
            part[d] += pow(sigma*lw_v2_norm(by)/(2*h), 2)/POSTURES;
        }
    for (int d = 0; d < 9; d++)
        all += part[d];
    CHECK_NEAR(r.rms, sqrt(all), 0, 1e-6);
    CHECK_INT(r.n_dim, 9);
    int first = 0;
    for (int d = 0; d < 9; d++) {
        CHECK_NEAR(r.part[d], part[d]/all, 1e-6, 1e-6);
        first = part[d] > part[first] ? d : first;
    }
    CHECK_NEAR(r.part[r.first], r.part[first], 1e-12, 0);        /* cx, cy, x0, y0 matter equally     */
    CHECK(r.worst >= r.rms);
    CHECK_INT(r.open, 0);
    CHECK_NEAR(r.trial_rms, r.rms, 0, 0.05);               /* 4000 trials: 1 to 2 %                       */
    CHECK(r.within > r.worst && r.within < 5*r.worst);
}

/* A clearance of radius c adds c^2/4 to the variance of r1 .. r4 and nothing to that of the tracer. */
TEST(clearance_moves_pins_only)
{
    lw_linkage k;
    lw_robustness both, length;
    double input[POSTURES], share = 0;
    make_bar(&k, input);
    lw_tolerances of = { .length = 3e-4, .trials = 10, .seed = 1 };
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &length, NULL), LW_OK);
    of.clearance = 2e-4;
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &both, NULL), LW_OK);
    for (int d = 0; d < 4; d++)
        share += length.part[d];
    CHECK_NEAR(both.rms*both.rms, length.rms*length.rms*(1 + share), 0, 1e-9);       /* sigma^2 doubles */
}

/* A linkage near a change point opens now and then; one that does not close is refused. */
TEST(open_linkages_are_counted)
{
    static const double tight[9] = { 3, 1, 2.5, 1.52, 0.5, 0.5, 0, 0, 0 };
    lw_linkage k;
    lw_robustness r;
    double input[POSTURES];
    make_bar(&k, input);
    fourbar_linkage(&k, tight, 1, 1);
    k.n_tracer = 1;
    k.tracer[0].link = 2;
    k.tracer[0].at = fourbar_at(tight, 1, 1).p;
    for (int i = 0; i < POSTURES; i++)
        input[i] = 2*LW_PI*i/POSTURES - 1;
    lw_tolerances of = { .length = 0.1, .trials = 500, .seed = 1 };
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &r, NULL), LW_OK);
    CHECK(r.open > 0 && r.open < 500);
    of.length = -1;
    CHECK_INT(lw_robustness_make(&k, input, POSTURES, &of, &r, NULL), LW_E_ARG);
}
