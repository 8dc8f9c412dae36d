/* Shifted Sobol points: in the cube, even in every direction, each seed its own. */
#include "optimise/solvers/lowdiscrepancy.h"
#include "tests/check.h"

TEST(fill_every_direction_evenly)
{
    enum { N = 512, D = 8 };
    static double u[N*D];
    lw_rng rng;
    for (uint64_t stream = 0; stream < 10; stream++) {
        lw_rng_seed(&rng, check_seed(), stream);
        CHECK(lw_low_discrepancy(&rng, N, D, u));
        for (int d = 0; d < D; d++) {
            int count[16] = { 0 };
            for (int i = 0; i < N; i++) {
                CHECK(u[i*D + d] >= 0 && u[i*D + d] < 1);
                count[(int)(16*u[i*D + d])]++;
            }
            for (int k = 0; k < 16; k++)                 /* 32 but for the ends of the shift; random: 32 +- 6 */
                CHECK(abs(count[k] - N/16) <= 2);
        }
    }
}

TEST(repeat_by_seed_only)
{
    double a[30], b[30], c[30];
    lw_rng one, same, other;
    lw_rng_seed(&one, 5, 1);
    lw_rng_seed(&same, 5, 1);
    lw_rng_seed(&other, 5, 2);
    CHECK(lw_low_discrepancy(&one, 10, 3, a) && lw_low_discrepancy(&same, 10, 3, b) && lw_low_discrepancy(&other, 10, 3, c));
    CHECK(memcmp(a, b, sizeof a) == 0);
    CHECK(memcmp(a, c, sizeof a) != 0);
}

TEST(refuse_dimensions_without_points)
{
    double u[41];
    lw_rng rng;
    lw_rng_seed(&rng, 1, 1);
    CHECK(lw_low_discrepancy(&rng, 1, 40, u));
    CHECK(!lw_low_discrepancy(&rng, 1, 41, u));
    CHECK(!lw_low_discrepancy(&rng, 1, 0, u));
}
