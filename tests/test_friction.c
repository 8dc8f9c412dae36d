/* tests/test_friction.c - reactions that depend on the friction they cause. */
#include "mbs/equations/friction.h"

#include "base/rng.h"
#include "tests/check.h"

/* Random weak couplings: the result satisfies |R_j| = N_j */
TEST(fixed_points)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 5);
    for (int trial = 0; trial < 500; trial++) {
        enum { MOST = 6 };
        int n = 1 + trial%MOST;
        lw_vec2 rest[MOST], response[MOST*MOST];
        double press[MOST];
        for (int j = 0; j < n; j++)
            rest[j] = lw_v2(lw_rng_range(&rng, -100, 100), trial%3 ? lw_rng_range(&rng, -100, 100) : 0);
        for (int j = 0; j < n*n; j++)
            response[j] = lw_v2(lw_rng_range(&rng, -0.5, 0.5)/n, trial%3 ? lw_rng_range(&rng, -0.5, 0.5)/n : 0);
        CHECK_INT(lw_friction_sizes(n, 0, 2, &rest[0].x, &response[0].x, press, NULL), LW_OK);
        for (int j = 0; j < n; j++) {
            lw_vec2 r = rest[j];
            for (int k = 0; k < n; k++)
                r = lw_v2_add(r, lw_v2_scale(response[j + n*k], press[k]));
            CHECK_NEAR(lw_v2_norm(r), press[j], 1e-10, 1e-12);
        }
    }
}

/* N = |1 + 2 N| has no solution; N = |1 + N/2| has 2 */
TEST(painleve)
{
    lw_vec2 rest = { 1, 0 }, response = { 2, 0 };
    double press;
    CHECK_INT(lw_friction_sizes(1, 0, 2, &rest.x, &response.x, &press, NULL), LW_E_NUMERIC);
    response.x = 0.5;
    CHECK_INT(lw_friction_sizes(1, 0, 2, &rest.x, &response.x, &press, NULL), LW_OK);
    CHECK_NEAR(press, 2, 1e-13, 0);
    CHECK_NEAR(lw_friction_push(&(lw_friction_joint){ .coefficient = 0.3, .speed = 1e-3, .lever_arm = 0.02 }, 5), -0.006, 1e-15, 0);
}
