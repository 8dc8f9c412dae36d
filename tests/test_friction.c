/* tests/test_friction.c - reactions that depend on the friction they cause. */
#include "mbs/equations/friction.h"

#include <stdlib.h>
#include "tests/check.h"

/* Random weak couplings: the result satisfies |R_j| = N_j */
TEST(fixed_points)
{
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 500; trial++) {
        enum { MOST = 6 };
        int n = 1 + trial%MOST;
        lw_vec2 rest[MOST], response[MOST*MOST];
        double press[MOST], work[MOST*(MOST + 4)];
        for (int j = 0; j < n; j++)
            rest[j] = lw_v2(lw_rng_range(&rng, -100, 100), trial%3 ? lw_rng_range(&rng, -100, 100) : 0);
        for (int j = 0; j < n*n; j++)
            response[j] = lw_v2(lw_rng_range(&rng, -0.5, 0.5)/n, trial%3 ? lw_rng_range(&rng, -0.5, 0.5)/n : 0);
        CHECK_INT(lw_friction_sizes(n, 0, 2, &rest[0].x, &response[0].x, press, work, NULL), LW_OK);
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
    double press, work[5];
    CHECK_INT(lw_friction_sizes(1, 0, 2, &rest.x, &response.x, &press, work, NULL), LW_E_NUMERIC);
    response.x = 0.5;
    CHECK_INT(lw_friction_sizes(1, 0, 2, &rest.x, &response.x, &press, work, NULL), LW_OK);
    CHECK_NEAR(press, 2, 1e-13, 0);
    CHECK_NEAR(lw_friction_push(&(lw_friction_joint){ .coefficient = 0.3, .speed = 1e-3, .lever_arm = 0.02 }, 5), -0.006, 1e-15, 0);
}

/* Joints that do not touch are as one alone, however many they are: N = |1 + N/2| is 2, though 0.5^n is next to 0. */
TEST(many_harmless_joints)
{
    static const int number[] = { 1, 2, 33, 100, 1000 };
    for (size_t i = 0; i < sizeof number/sizeof *number; i++) {
        size_t n = (size_t)number[i];
        double *rest = calloc(2*n + 2*n*n + n*(n + 4) + n, sizeof *rest), *response = rest + 2*n, *size = response + 2*n*n, least;
        for (size_t j = 0; j < n; j++)
            rest[2*j] = 1, response[2*(j + n*j)] = 0.5;
        CHECK_INT(lw_friction_sizes((int)n, 0, 2, rest, response, size, size + n, &least), LW_OK);
        CHECK_NEAR(least, 0.5, 1e-13, 0);
        for (size_t j = 0; j < n; j++)
            CHECK_NEAR(size[j], 2, 1e-12, 0);
        free(rest);
    }
}

/* N = |2 N - 1| is 1 where friction lost its way (determinant 1 - 2) or 1/3.  Two such joints have a positive determinant and
 * are as lost as one, also where each feels the other. */
TEST(two_lost_joints)
{
    for (int n = 1; n <= 4; n++)
        for (int coupled = 0; coupled < 2; coupled++) {
            double rest[8] = { 0 }, response[32] = { 0 }, size[4], work[32], least;
            for (int j = 0; j < n; j++) {
                rest[2*j] = -1;
                for (int k = 0; k < n; k++)
                    response[2*(j + n*k)] = j == k ? 2 : 0.01*coupled;
            }
            CHECK_INT(lw_friction_sizes(n, 0, 2, rest, response, size, work, &least), LW_E_NUMERIC);
            CHECK(least < 0);
        }
}

/* Joint a alone is lost (pivot 1 - 1.2), with joint b it is not, in either order.  N = (1, 2). */
TEST(joints_that_help_each_other)
{
    for (int a = 0; a < 2; a++) {
        double rest[4] = { 0 }, response[8] = { 0 }, size[2], work[12], least;
        int b = 1 - a;
        rest[2*a] = 1.8, rest[2*b] = 1;
        response[2*(a + 2*a)] = 1.2, response[2*(a + 2*b)] = -1, response[2*(b + 2*a)] = 1;
        CHECK_INT(lw_friction_sizes(2, 0, 2, rest, response, size, work, &least), LW_OK);
        CHECK_NEAR(size[a], 1, 1e-12, 0);
        CHECK_NEAR(size[b], 2, 1e-12, 0);
        CHECK_NEAR(least, 0.8, 1e-12, 0);
    }
}
