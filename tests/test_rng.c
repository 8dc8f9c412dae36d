/* The generator against its published outputs, and its distributions against their moments. */
#include "base/rng.h"
#include "tests/check.h"

/* splitmix64 seeded with 1234567: the widely used check values of Vigna's splitmix64.c. */
TEST(seeding_is_splitmix64)
{
    static const uint64_t want[4] = { 6457827717110365317u, 3203168211198807973u,
                                      9817491932198370423u, 4593380528125082431u };
    lw_rng r;
    lw_rng_seed(&r, 1234567, 0);
    for (int i = 0; i < 4; i++)
        CHECK(r.s[i] == want[i]);
}

/* xoshiro256** from the state 1, 2, 3, 4: the check values used with Blackman & Vigna's
 * xoshiro256starstar.c. */
TEST(bits_are_xoshiro256ss)
{
    static const uint64_t want[] = {
        11520u, 0u, 1509978240u, 1215971899390074240u, 1216172134540287360u, 607988272756665600u,
        16172922978634559625u, 8476171486693032832u, 10595114339597558777u, 2904607092377533576u };
    lw_rng r = { { 1, 2, 3, 4 } };
    for (size_t i = 0; i < sizeof want/sizeof *want; i++)
        CHECK(lw_rng_bits(&r) == want[i]);
}

TEST(same_seed_same_numbers_other_stream_others)
{
    lw_rng a, b, c, d;
    lw_rng_seed(&a, 7, 3);
    lw_rng_seed(&b, 7, 3);
    lw_rng_seed(&c, 7, 4);
    lw_rng_seed(&d, 8, 3);
    for (int i = 0; i < 1000; i++) {
        uint64_t x = lw_rng_bits(&a);
        CHECK(x == lw_rng_bits(&b));
        CHECK(x != lw_rng_bits(&c));
        CHECK(x != lw_rng_bits(&d));
    }
}

/* n numbers: a mean of k-th powers is off by more than 5 deviations once in a million. */
TEST(moments_of_uniform_and_normal)
{
    enum { n = 200000 };
    double u1 = 0, u2 = 0, n1 = 0, n2 = 0, n4 = 0, uu = 0, last = 0.5;
    lw_rng r = check_rng(0);
    for (int i = 0; i < n; i++) {
        double u = lw_rng_uniform(&r), z = lw_rng_normal(&r);
        CHECK(u >= 0 && u < 1);
        u1 += u/n;
        u2 += u*u/n;
        uu += (u - 0.5)*(last - 0.5)/n;
        last = u;
        n1 += z/n;
        n2 += z*z/n;
        n4 += z*z*z*z/n;
    }
    CHECK_NEAR(u1, 0.5, 5*sqrt(1./12/n), 0);
    CHECK_NEAR(u2, 1./3, 5*sqrt(4./45/n), 0);
    CHECK_NEAR(uu, 0, 5*sqrt(1./144/n), 0);
    CHECK_NEAR(n1, 0, 5*sqrt(1./n), 0);
    CHECK_NEAR(n2, 1, 5*sqrt(2./n), 0);
    CHECK_NEAR(n4, 3, 5*sqrt(96./n), 0);
}

TEST(range_stays_inside)
{
    static const double ends[][2] = { { 0, 1 }, { -3, 5 }, { 1, 1 + 0x1p-52 }, { -1e308, 1e308 },
                                      { 1e9, 1e9 + 1 }, { -2, -1 }, { 5e-324, 1e-323 }, { 4, 4 } };
    lw_rng r = check_rng(1);
    for (size_t k = 0; k < sizeof ends/sizeof *ends; k++)
        for (int i = 0; i < 2000; i++) {
            double lo = ends[k][0], hi = ends[k][1], v = lw_rng_range(&r, lo, hi);
            CHECK(v >= lo && (v < hi || lo == hi));
        }
}
