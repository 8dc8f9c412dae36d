/* base/sparse: random systems against their own products, the order of elimination against known fill. */
#include "base/rng.h"
#include "base/sparse.h"
#include "tests/check.h"

#define MOST 60

static double a[MOST*MOST], doubles[MOST*MOST + MOST];
static int ints[MOST*MOST + 4*MOST + 1];

/* `filled` of n*n entries, one in every row and column; zeros on the diagonal are frequent. */
static void random_matrix(lw_rng *rng, int n, int filled)
{
    int to[MOST];
    memset(a, 0, sizeof a);
    for (int i = 0; i < n; i++)
        to[i] = i;
    for (int i = n - 1; i > 0; i--) {
        int k = (int)(lw_rng_uniform(rng)*(i + 1)), x = to[i];
        to[i] = to[k];
        to[k] = x;
    }
    for (int i = 0; i < n; i++)
        a[i + n*to[i]] = 1 + lw_rng_uniform(rng);
    for (int k = n; k < filled; k++)
        a[(int)(lw_rng_uniform(rng)*n*n)] = lw_rng_uniform(rng) - 0.5;
}

TEST(products)
{
    lw_rng rng;
    lw_sparse f;
    lw_rng_seed(&rng, 11, 0);
    for (int n = 1; n <= MOST; n += n < 8 ? 1 : 13)
        for (int trial = 0; trial < 20; trial++) {
            double x[MOST], b[MOST] = { 0 }, found[MOST];
            random_matrix(&rng, n, trial % 2 ? 3*n : n*n/2);
            for (int j = 0; j < n; j++) {
                x[j] = lw_rng_uniform(&rng) - 0.5;
                for (int i = 0; i < n; i++)
                    b[i] += a[i + n*j]*x[j];
            }
            lw_sparse_place(&f, n, doubles, ints);
            CHECK(lw_sparse_doubles(n) <= sizeof doubles/sizeof *doubles && lw_sparse_ints(n) <= sizeof ints/sizeof *ints);
            if (trial % 3)                              /* the order of one matrix serves another */
                lw_sparse_prepare(&f, a);
            else
                for (int k = 0; k < n; k++)
                    f.order[k] = n - 1 - k;
            CHECK_INT(lw_sparse_factor(&f, a), 0);
            lw_sparse_solve(&f, b, found);
            for (int i = 0; i < n; i++)                 /* by residual: random matrices may be ill-conditioned */
                for (int j = 0; j < n; j++)
                    b[i] -= a[i + n*j]*found[j];
            for (int i = 0; i < n; i++)
                CHECK_NEAR(b[i], 0, 1e-10, 0);
        }
}

TEST(singular)
{
    lw_sparse f;
    static const double twice[] = { 1, 2, 2, 4 };
    lw_sparse_place(&f, 2, doubles, ints);
    lw_sparse_prepare(&f, twice);
    CHECK(lw_sparse_factor(&f, twice) > 0);
}

/* A star with its middle first would fill whole; a path and a tree need not fill at all. */
TEST(no_fill)
{
    unsigned char near[MOST*MOST];
    int order[MOST];
    for (int kind = 0; kind < 2; kind++) {
        int n = 20, entries = 0;
        memset(near, 0, sizeof near);
        for (int i = 1; i < n; i++) {
            int to = kind ? (i - 1)/2 : 0;
            near[i*n + to] = near[to*n + i] = 1;
        }
        lw_sparse_order(n, near, order);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                entries += i != j && near[i*n + j];
        CHECK_INT(entries, 2*(n - 1));
        int sum = 0;
        for (int i = 0; i < n; i++)
            sum += order[i];
        CHECK_INT(sum, n*(n - 1)/2);
    }
}
