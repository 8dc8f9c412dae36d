/* tests/test_cognate.c - Roberts cognates trace one curve; checked by a four-bar written here, and
 * point by point by distances alone. */
#include "mbs/kinematics/fourbar.h"
#include "base/vec2.h"
#include "tests/check.h"

/* Coupler point by intersecting two circles (not by angles, as the library does); false: open. */
static bool coupler_point(const double k[9], double mode, double angle, lw_vec2 *p)
{
    lw_vec2 a = lw_v2(k[1]*cos(angle), k[1]*sin(angle)), b0 = lw_v2(k[0], 0.0);
    lw_vec2 line = lw_v2_sub(b0, a);
    double d2 = lw_v2_dot(line, line), along = 0.5*(1.0 + (k[2]*k[2] - k[3]*k[3])/d2);
    double h2 = k[2]*k[2]/d2 - along*along;
    if (h2 < 0.0)
        return false;
    lw_vec2 ab = lw_v2_add(lw_v2_scale(line, along), lw_v2_scale(lw_v2_perp(line), mode*sqrt(h2)));
    lw_vec2 q = lw_v2_add(a, lw_v2_turn(ab, lw_v2(k[4]/k[2], k[5]/k[2])));
    *p = lw_v2_add(lw_v2(k[6], k[7]), lw_v2_turn(q, lw_v2(cos(k[8]), sin(k[8]))));
    return true;
}

/* How far the four-bar is from closing with its coupler point at p: over both places of A on the
 * circles about A0 (radius r2) and p (radius |AP|), the least ||B - B0| - r4|. */
static double off_curve(const double k[9], lw_vec2 p)
{
    lw_vec2 c = lw_v2(k[4]/k[2], k[5]/k[2]), a0 = lw_v2(k[6], k[7]);
    lw_vec2 b0 = lw_v2_add(a0, lw_v2_polar(k[0], k[8])), line = lw_v2_sub(p, a0);
    double ap = lw_v2_norm(c)*k[2], d2 = lw_v2_dot(line, line), best = HUGE_VAL;
    double along = 0.5*(1.0 + (k[1]*k[1] - ap*ap)/d2), h2 = fmax(0.0, k[1]*k[1]/d2 - along*along);
    for (int side = -1; side <= 1; side += 2) {
        lw_vec2 foot = lw_v2_add(lw_v2_scale(line, along), lw_v2_scale(lw_v2_perp(line), side*sqrt(h2)));
        lw_vec2 a = lw_v2_add(a0, foot), to_p = lw_v2_sub(p, a);
        lw_vec2 ab = lw_v2_scale(lw_v2_unturn(to_p, c), 1.0/lw_v2_dot(c, c));
        best = fmin(best, fabs(lw_v2_norm(lw_v2_sub(lw_v2_add(a, ab), b0)) - k[3]));
    }
    return best;
}

static void draw_fourbar(lw_rng *rng, double k[9])
{
    lw_fourbar_class c;
    do {
        for (int i = 0; i < 4; i++)
            k[i] = lw_rng_range(rng, 0.2, 1.0);
    } while (lw_fourbar_classify(k, 1e-3, &c, NULL) != LW_OK || c.margin < 1e-3);
    double x, y;
    do {
        x = lw_rng_range(rng, -1.5, 2.5), y = lw_rng_range(rng, -1.5, 1.5);
    } while (hypot(x, y) < 0.1 || hypot(x - 1.0, y) < 0.1);
    k[4] = x*k[2], k[5] = y*k[2];
    k[6] = lw_rng_range(rng, -2.0, 2.0), k[7] = lw_rng_range(rng, -2.0, 2.0);
    k[8] = lw_rng_range(rng, -LW_PI, LW_PI);
}

/* Posture by posture, in both modes. */
TEST(cognates_meet_in_every_posture)
{
    lw_rng rng = check_rng(1);
    int n_posture = 0, n_changed = 0;
    for (int trial = 0; trial < 400; trial++) {
        double k[9], out[2][9], m[2];
        draw_fourbar(&rng, k);
        for (double mode = -1.0; mode <= 1.0; mode += 2.0) {
            CHECK_INT(lw_fourbar_cognates(k, mode, out, m), LW_OK);
            CHECK_NEAR(m[0], -mode, 0, 0);
            for (int i = 0; i < 40; i++) {
                double t = lw_rng_range(&rng, -LW_PI, LW_PI), angle[2], now[2];
                lw_vec2 want, got;
                bool closes = coupler_point(k, mode, t, &want);
                CHECK_INT(lw_fourbar_cognate_posture(k, mode, t, angle, now), closes ? LW_OK : LW_OPEN);
                if (!closes)
                    continue;
                n_posture++;
                n_changed += now[1] != m[1];
                for (int j = 0; j < 2; j++) {
                    double size = out[j][0] + out[j][1] + out[j][2] + out[j][3];
                    lw_fourbar_class c;
                    CHECK(coupler_point(out[j], now[j], angle[j], &got));
                    CHECK_INT(lw_fourbar_classify(out[j], 1e-9, &c, NULL), LW_OK);
                    /* near a dead point of the cognate the angle carries half the digits */
                    double d = hypot(out[j][0] - out[j][1]*cos(angle[j]), out[j][1]*sin(angle[j]));
                    double dead = fmin(out[j][2] + out[j][3] - d, d - fabs(out[j][2] - out[j][3]))/size;
                    CHECK_NEAR(hypot(got.x - want.x, got.y - want.y), 0.0, fmax(size, 1.0)*2e-14/sqrt(fmax(dead, 1e-16)), 0);
                }
            }
        }
    }
    CHECK(n_posture > 10000);
    CHECK(n_changed > 1000);               /* that is why there is lw_fourbar_cognate_posture */
}

/* The whole of each cognate's curve, both modes, lies on the curve of the given linkage. */
TEST(curves_are_one)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 200; trial++) {
        double k[9], out[2][9], m[2];
        draw_fourbar(&rng, k);
        CHECK_INT(lw_fourbar_cognates(k, 1.0, out, m), LW_OK);
        for (int j = 0; j < 2; j++)
            for (double mode = -1.0; mode <= 1.0; mode += 2.0)
                for (int i = 0; i < 50; i++) {
                    lw_vec2 p;
                    if (!coupler_point(out[j], mode, lw_rng_range(&rng, -LW_PI, LW_PI), &p))
                        continue;
                    CHECK_NEAR(off_curve(k, p), 0.0, 3e-7, 0);   /* square root at touching circles */
                }
    }
}

/* The cognates of a cognate are the given linkage and the other cognate. */
TEST(cognates_of_cognates)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 200; trial++) {
        double k[9], out[2][9], m[2], back[2][9], n[2];
        draw_fourbar(&rng, k);
        CHECK_INT(lw_fourbar_cognates(k, 1.0, out, m), LW_OK);
        CHECK_INT(lw_fourbar_cognates(out[1], m[1], back, n), LW_OK);
        for (int i = 0; i < 9; i++)          /* out[1] shares A0 with the given one: back[1] is it */
            CHECK_NEAR(i == 8 ? remainder(back[1][i] - k[i], 2.0*LW_PI) : back[1][i], i == 8 ? 0.0 : k[i], 1e-13, 0);
        CHECK_INT(lw_fourbar_cognates(out[0], m[0], back, n), LW_OK);
        for (int i = 0; i < 4; i++)
            CHECK_NEAR(back[0][i], k[i], 1e-13, 0);
        CHECK_NEAR(n[0], 1.0, 0, 0);
    }
}

/* Coupler point in the line of the coupler, half way: the cognates have half the size. */
TEST(half_way_on_the_coupler)
{
    double k[9] = { 4, 2, 3, 3.5, 1.5, 0, 1, 2, 0.3 }, out[2][9], m[2];
    CHECK_INT(lw_fourbar_cognates(k, 1.0, out, m), LW_OK);
    double want0[4] = { 2, 1, 1.75, 1.5 }, want1[4] = { 2, 1.5, 1, 1.75 };
    for (int i = 0; i < 4; i++) {
        CHECK_NEAR(out[0][i], want0[i], 1e-15, 0);
        CHECK_NEAR(out[1][i], want1[i], 1e-15, 0);
    }
    CHECK_NEAR(out[0][6], 1.0 + 2.0*cos(0.3), 1e-15, 0);
    CHECK_NEAR(out[0][7], 2.0 + 2.0*sin(0.3), 1e-15, 0);
}

TEST(coupler_point_on_a_pivot)
{
    double at_a[9] = { 4, 2, 3, 3.5, 0, 0, 0, 0, 0 }, at_b[9] = { 4, 2, 3, 3.5, 3, 0, 0, 0, 0 };
    double out[2][9], m[2];
    CHECK_INT(lw_fourbar_cognates(at_a, 1.0, out, m), LW_E_NUMERIC);
    CHECK_NEAR(out[1][0], 0.0, 0, 0);
    CHECK_NEAR(out[0][0], 4.0, 1e-15, 0);       /* the other: coupler and output exchanged */
    CHECK_NEAR(out[0][2], 3.5, 1e-15, 0);
    CHECK_INT(lw_fourbar_cognates(at_b, 1.0, out, m), LW_E_NUMERIC);
    CHECK_NEAR(out[0][0], 0.0, 0, 0);
    CHECK_NEAR(out[1][1], 3.0, 1e-15, 0);
    double open[9] = { 10, 1, 1, 1, 0.5, 0.5, 0, 0, 0 };
    CHECK_INT(lw_fourbar_cognates(open, 1.0, out, m), LW_E_ARG);
}
