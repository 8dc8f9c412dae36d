/* tests/test_sum.c - sums that nearly vanish, against integers. */
#include "base/sum.h"
#include "tests/check.h"

/* Multiples of 2^-60 below 2^62 units: their sum is exact in 64-bit integers, rounded once at the end. */
TEST(one_rounding_only)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 100000; trial++) {
        int64_t k[4], sum = 0;
        double x[4];
        for (int i = 0; i < 4; i++) {
            int64_t nearly = i == 3 ? -sum : 0;                 /* the last one cancels most */
            x[i] = ldexp((double)(nearly + (int64_t)(lw_rng_bits(&rng) >> (i == 3 ? 40 : 5))), -60);
            k[i] = (int64_t)ldexp(x[i], 60);
            sum += k[i];
        }
        double want = ldexp((double)sum, -60), got = lw_sum4(x[0], x[1], x[2], x[3]);
        CHECK_NEAR(got, want, 0, 0x1p-52);
    }
}

TEST(where_plain_addition_fails)
{
    CHECK_NEAR(lw_sum4(1.0, 1e-20, -1.0, 0.0), 1e-20, 0, 0);
    CHECK_NEAR(lw_sum4(1e16, 1.0, 1.0, -1e16), 2.0, 0, 0);
    CHECK_NEAR(lw_sum4(0.1, 0.2, -0.3, 0.0), 0x1.999999999999ap-4 + (0x1.999999999999ap-3 - 0x1.3333333333333p-2), 0, 0);
    CHECK(isnan(lw_sum4(NAN, 0.0, 0.0, 0.0)));
}
