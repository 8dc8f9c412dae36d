/* Grown linkages trace the parent's curve, closing all the way. */
#include "optimise/grow.h"
#include "tests/six_bar.h"

static void children_trace_the_parents_curve(void)
{
    enum { N = 90 };
    lw_linkage k = six_bar();
    double x[N], y[N], angle[N];
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 1);
    six_bar_curve(&k, N, x, y, angle);
    for (int trial = 0; trial < 60; trial++) {
        lw_linkage child, grandchild;
        double cx[N], cy[N];
        CHECK_INT(lw_linkage_grow(&k, true, 0, 0, &rng, &child), LW_OK);
        CHECK_INT(child.n_link, k.n_link + 2);
        CHECK_INT(lw_linkage_mobility(&child), 1);
        CHECK_INT(lw_linkage_check(&child, NULL), LW_OK);
        six_bar_curve(&child, N, cx, cy, angle);
        for (int i = 0; i < N; i++) {
            CHECK_NEAR(cx[i], x[i], 1e-12, 0);
            CHECK_NEAR(cy[i], y[i], 1e-12, 0);
        }
        CHECK_INT(lw_linkage_grow(&child, true, 0, 0, &rng, &grandchild), LW_OK);
        CHECK_INT(lw_linkage_mobility(&grandchild), 1);
    }
}

static void what_does_not_fit_is_refused(void)
{
    lw_linkage k = six_bar(), child;
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 2);
    CHECK_INT(lw_linkage_grow(&k, false, 0, 40, &rng, &child), LW_OK);      /* the crank turns: any range */
    k.n_link = LW_LINK_MAX - 1;
    CHECK_INT(lw_linkage_grow(&k, true, 0, 0, &rng, &child), LW_E_ARG);
}

int main(void)
{
    RUN(children_trace_the_parents_curve);
    RUN(what_does_not_fit_is_refused);
    return check_end();
}
