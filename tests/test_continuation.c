/* tests/test_continuation.c - the bound that keeps steps on their branch, pair by pair; series; freedoms by rank. */
#include "mbs/constraints/continuation_internal.h"
#include "tests/check.h"
#include "tests/kept_system.h"
#include "tests/mbs_random.h"

/* A crank and dyads of every kind, a slot, a rack and its pinion, a wheel on another wheel. */
static void draw_linkage(lw_rng *r, lw_linkage *k)
{
    random_grown(r, 1 + (int)(lw_rng_bits(r)%3), k);
    int n = k->n_link;
    for (int i = 0; i < 4; i++)
        snprintf(k->link_name[n + i], LW_NAME_SIZE, "L%d", n + i + 1);
    k->n_link = n + 4;
    add_pin(k, 0, n, random_place(r));                       /* pinion, and a rack on the ground */
    add_slide(k, n + 1, 0, random_place(r), lw_rng_range(r, -3, 3));
    add_gear(k, lw_rng_bits(r)%2 ? n : n + 1, 0, random_place(r), 1);
    lw_joint *g = &k->joint[k->n_joint - 1];
    g->link[1] = g->link[0] == n ? n + 1 : n;
    g->ratio = lw_rng_range(r, 0.3, 3);
    add_joint(k, LW_JOINT_SLOT, n, 1, random_place(r), lw_rng_range(r, -3, 3));
    add_pin(k, 1, n + 2, random_place(r));                   /* a wheel on the crank, and one on that */
    add_pin(k, n + 2, n + 3, random_place(r));
    add_gear(k, 1, n + 3, random_place(r), lw_rng_range(r, -3, -0.3));
    add_joint(k, LW_JOINT_SLOT, n + 3, 0, random_place(r), lw_rng_range(r, -3, 3));
}

/* |A^+ (G'(a) - G'(b)) v| in the norm of the bound, over kappa |a - b| |v|: never above 1 within the reach. */
static double worst_ratio(lw_rng *r, lw_continuation *f, const double *q, double kappa)
{
    double worst = 0;
    static double jac[2][LW_SYSTEM_Q_MAX*LW_SYSTEM_ROW_MAX];
    double at[2][LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX], out[LW_SYSTEM_ROW_MAX], zero[LW_SYSTEM_Q_MAX] = { 0 };
    for (int pair = 0; pair < 20; pair++) {
        for (int side = 0; side < 2; side++) {
            double size, share = pow(lw_rng_uniform(r), 0.3)/kappa;
            for (int i = 0; i < f->n; i++)
                v[i] = f->curved[i] ? lw_rng_normal(r) : 0;
            size = lw_continuation_distance(f, v, zero);
            for (int i = 0; i < f->n; i++)
                at[side][i] = q[i] + share*v[i]/size;
            lw_continuation_assemble(f, at[side]);
            memcpy(jac[side], f->matrix, (size_t)f->m*(size_t)f->n*sizeof(double));
        }
        for (int i = 0; i < f->n; i++)
            v[i] = lw_rng_bits(r)%3 ? 0 : lw_rng_normal(r);
        memset(out, 0, sizeof out);
        for (int i = 0; i < f->n; i++)
            for (int m = 0; m < f->m; m++)
                out[m] += (jac[0][m + f->m*i] - jac[1][m + f->m*i])*v[i];
        lw_continuation_factor(f, q);
        if (f->plane)
            lw_continuation_tangent(f);
        lw_continuation_solve(f, out);
        double by = kappa*lw_continuation_distance(f, at[0], at[1])*lw_continuation_distance(f, v, zero);
        if (by > 0)
            worst = fmax(worst, lw_continuation_distance(f, out, zero)/by);
    }
    return worst;
}

/* Inequality (1) of mbs/constraints/continuation_internal.h for random linkages, postures and pairs, on curves and driven. */
TEST(the_bound_holds)
{
    double worst = 0;
    int looked = 0;
    lw_rng r = check_rng(1);
    for (int trial = 0; trial < 300; trial++) {
        lw_linkage k;
        KEPT_SYSTEM s = { 0 };
        OWN(lw_continuation) f = { 0 };
        double q[LW_SYSTEM_Q_MAX];
        int all[LW_INPUT_MAX] = { 0 };
        bool plane = trial%2;
        draw_linkage(&r, &k);
        CHECK_OK(lw_system_make(&k, NULL, 0, &s, &check_error));
        CHECK_INT(s.n_q - s.n_row, 1);
        CHECK(lw_continuation_create(&s, all, plane ? 0 : 1, plane, &f));
        lw_system_posture(&s, q);
        for (int i = 0; i < s.n_q; i++)                    /* the bound needs no posture that closes */
            q[i] += lw_rng_range(&r, -1, 1);
        if (plane)
            CHECK(lw_continuation_freedoms(&f, q, f.row) == 1);
        if (lw_continuation_factor(&f, q) > 1e-9 && (!plane || lw_continuation_tangent(&f))) {
            double ratio = worst_ratio(&r, &f, q, lw_continuation_bound(&f, q));
            CHECK(ratio <= 1 + 1e-9);
            worst = fmax(worst, ratio);
            looked++;
        }
    }
    CHECK(looked > 250);
    CHECK(worst > 0.05);                                    /* the bound is no giant */
}

/* For two links on pins it is sharp: |A^+ arms| is reached. */
TEST(the_bound_is_sharp_for_pins)
{
    double most = 0;
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 200; trial++) {
        lw_linkage k;
        KEPT_SYSTEM s = { 0 };
        OWN(lw_continuation) f = { 0 };
        double q[9];
        blank_linkage(&k, 4);
        for (int i = 0; i < 4; i++)
            add_pin(&k, i, (i + 1)%4, random_place(&r));
        add_input(&k, 0, 0);
        CHECK_INT(lw_system_make(&k, NULL, 0, &s, NULL), LW_OK);
        CHECK(lw_continuation_create(&s, NULL, 0, true, &f));
        lw_system_posture(&s, q);
        lw_continuation_freedoms(&f, q, f.row);
        if (lw_continuation_factor(&f, q) > 1e-9 && lw_continuation_tangent(&f)) {
            double ratio = worst_ratio(&r, &f, q, lw_continuation_bound(&f, q));
            CHECK(ratio <= 1 + 1e-9);
            most = fmax(most, ratio);
        }
    }
    CHECK(most > 0.6);
}

/* The series of a curve leaves the rows at order 9. */
TEST(series_follow_the_curve)
{
    lw_rng r = check_rng(3);
    for (int trial = 0; trial < 50; trial++) {
        lw_linkage k;
        KEPT_SYSTEM s = { 0 };
        OWN(lw_continuation) f = { 0 };
        double series[9*LW_SYSTEM_Q_MAX], at[LW_SYSTEM_Q_MAX], left[2];
        draw_linkage(&r, &k);
        CHECK_INT(lw_system_make(&k, NULL, 0, &s, NULL), LW_OK);
        CHECK(lw_continuation_create(&s, NULL, 0, true, &f));
        lw_system_posture(&s, series);
        CHECK_INT(lw_continuation_freedoms(&f, series, f.row), 1);
        lw_continuation_factor(&f, series);
        lw_continuation_tangent(&f);
        double h = 0.1/lw_continuation_bound(&f, series);
        lw_continuation_series(&f, 8, NULL, series);
        for (int half = 0; half < 2; half++) {
            lw_continuation_sum(&f, 8, series, half ? 0.5*h : h, at);
            left[half] = lw_continuation_residual(&f, at);
        }
        CHECK(left[0] < 1e-6);
        CHECK(left[1] <= fmax(left[0]/200, 4e-15));          /* 2^9 and a bit of order 10 */
        double along = 0;
        for (int i = 0; i < f.n; i++)
            along += (at[i] - series[i])*series[f.n + i];
        CHECK_NEAR(along, 0.5*h, 1e-14, 0);
    }
}

TEST(freedoms_by_rank)
{
    lw_linkage k;
    KEPT_SYSTEM s = { 0 };
    lw_continuation f;
    double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX];
    for (int flat = 0; flat < 2; flat++) {                   /* a parallelogram, and its change point */
        double d[9] = { 4, 1, 4, 1, 1, 2, 0, 0, 0 };
        int input = 0;
        fourbar_linkage(&k, d, 1, flat ? 0 : 0.5);
        CHECK_INT(lw_system_make(&k, NULL, 0, &s, NULL), LW_OK);
        lw_system_posture(&s, q);
        CHECK(lw_continuation_create(&s, NULL, 0, true, &f));
        CHECK_INT(lw_continuation_freedoms(&f, q, v), 1 + flat);
        lw_continuation_free(&f);
        CHECK(lw_continuation_create(&s, &input, 1, false, &f));
        CHECK_INT(lw_continuation_freedoms(&f, q, v), flat);
        lw_continuation_free(&f);
        lw_system_free(&s);
    }
}
