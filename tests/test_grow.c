/* Grown linkages trace the parent's curve, closing all the way. */
#include "optimise/topology/grow.h"
#include "tests/six_bar.h"

/* Does it close at n inputs of a turn? */
static bool closes(const lw_linkage *k, int n)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    CHECK_INT(lw_plan_make(k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, k, dim, mode, &input, NULL), LW_OK);
    for (int i = 0; i < n; i++) {
        lw_posture posture;
        if (lw_posture_solve(&plan, dim, mode, input + 2*LW_PI*i/n, 0, &posture) != LW_OK)
            return false;
    }
    return true;
}

TEST(children_trace_the_parents_curve)
{
    enum { N = 90 };
    lw_linkage k = six_bar();
    double x[N], y[N], angle[N];
    lw_rng rng = check_rng(1);
    six_bar_curve(&k, N, x, y, angle);
    for (int trial = 0; trial < 60; trial++) {
        lw_linkage child, grandchild;
        double cx[N], cy[N];
        CHECK_INT(lw_linkage_grow(&k, true, 0, 0, 0, &rng, &child), LW_OK);
        CHECK_INT(child.n_link, k.n_link + 2);
        CHECK_INT(lw_linkage_mobility(&child), 1);
        CHECK_INT(lw_linkage_check(&child, NULL), LW_OK);
        CHECK(closes(&child, 5000));                        /* between the places that are looked at too */
        six_bar_curve(&child, N, cx, cy, angle);
        for (int i = 0; i < N; i++) {
            CHECK_NEAR(cx[i], x[i], 1e-12, 0);
            CHECK_NEAR(cy[i], y[i], 1e-12, 0);
        }
        CHECK_INT(lw_linkage_grow(&child, true, 0, 0, 0, &rng, &grandchild), LW_OK);
        CHECK_INT(lw_linkage_mobility(&grandchild), 1);
    }
}

/* Of two points one goes on to the new link, each of them sometimes; both run as before. */
TEST(every_point_runs_as_before)
{
    enum { N = 40 };
    lw_linkage k = six_bar();
    int moved[2] = { 0, 0 };
    lw_rng rng = check_rng(3);
    k.n_tracer = 2;
    k.tracer[1] = (lw_tracer){ .name = "Q", .link = 2, .at = { 1.5, 2.6 } };
    for (int trial = 0; trial < 40; trial++) {
        lw_linkage child;
        if (lw_linkage_grow(&k, true, 0, 0, 0, &rng, &child) != LW_OK)
            continue;
        CHECK_INT(child.n_tracer, 2);
        CHECK(closes(&child, 5000));
        for (int i = 0; i < 2; i++) {
            lw_linkage of[2] = { k, child };
            double x[2][N], y[2][N], angle[N];
            moved[i] += child.tracer[i].link != k.tracer[i].link;
            for (int c = 0; c < 2; c++) {
                of[c].tracer[0] = of[c].tracer[i];
                of[c].n_tracer = 1;
                six_bar_curve(&of[c], N, x[c], y[c], angle);
            }
            for (int n = 0; n < N; n++) {
                CHECK_NEAR(x[1][n], x[0][n], 1e-12, 0);
                CHECK_NEAR(y[1][n], y[0][n], 1e-12, 0);
            }
        }
    }
    CHECK(moved[0] > 5 && moved[1] > 5 && moved[0] + moved[1] <= 40);
}

TEST(what_does_not_fit_is_refused)
{
    lw_linkage k = six_bar(), child;
    lw_rng rng = check_rng(2);
    CHECK_INT(lw_linkage_grow(&k, false, 0, 40, 0, &rng, &child), LW_OK);      /* the crank turns: any range */
    k.n_link = LW_LINK_MAX - 1;
    CHECK_INT(lw_linkage_grow(&k, true, 0, 0, 0, &rng, &child), LW_E_ARG);
}
