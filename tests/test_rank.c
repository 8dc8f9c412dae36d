/* Rank, least squares and least norm against their definitions, on random matrices of known rank. */
#include "base/rank.h"
#include "tests/check.h"

#define MOST 12

static double doubles[MOST*MOST + 6*MOST];
static int ints[MOST];

/* A = B C with B m x rank, C rank x n. */
static void draw(lw_rng *rng, int m, int n, int rank, double *a)
{
    double b[MOST*MOST], c[MOST*MOST];
    for (int i = 0; i < MOST*MOST; i++) {
        b[i] = lw_rng_uniform(rng) - 0.5;
        c[i] = lw_rng_uniform(rng) - 0.5;
    }
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) {
            a[i + m*j] = 0;
            for (int k = 0; k < rank; k++)
                a[i + m*j] += b[i*MOST + k]*c[k*MOST + j];
        }
}

/* y = A x, or A^T x */
static void apply(int m, int n, const double *a, int transposed, const double *x, double *y)
{
    for (int i = 0; i < (transposed ? n : m); i++) {
        y[i] = 0;
        for (int j = 0; j < (transposed ? m : n); j++)
            y[i] += (transposed ? a[j + m*i] : a[i + m*j])*x[j];
    }
}

/* x is the least-squares solution of least norm: the residual is normal to the columns, and x has no part
 * that A does not see, that is, x = A^T w for some w (the null part of x is 0). */
static void check_solution(int m, int n, const double *a, int transposed, const double *x, const double *b, const lw_rank *r)
{
    double y[MOST], back[MOST], null[MOST];
    int rows = transposed ? n : m, columns = transposed ? m : n;
    apply(m, n, a, transposed, x, y);
    for (int i = 0; i < rows; i++)
        y[i] -= b[i];
    apply(m, n, a, !transposed, y, back);
    for (int i = 0; i < columns; i++)
        CHECK_NEAR(back[i], 0, 1e-11, 0);
    if (transposed)
        return;
    memcpy(null, x, (size_t)n*sizeof *x);
    lw_rank_null_part(r, null);
    for (int i = 0; i < n; i++)
        CHECK_NEAR(null[i], 0, 1e-10, 1e-10);
}

TEST(random_matrices)
{
    lw_rng rng = check_rng(0);
    for (int trial = 0; trial < 500; trial++) {
        int m = 1 + (int)(lw_rng_uniform(&rng)*MOST), n = 1 + (int)(lw_rng_uniform(&rng)*MOST);
        int most = m < n ? m : n, rank = (int)(lw_rng_uniform(&rng)*(most + 1));
        double a[MOST*MOST], b[MOST], x[MOST], keep[MOST], ax[MOST];
        lw_rank r;
        draw(&rng, m, n, rank, a);
        lw_rank_place(&r, m, n, doubles, ints);
        memcpy(r.a, a, (size_t)(m*n)*sizeof *a);
        lw_rank_factor(&r, 1e-12);
        CHECK_INT(r.rank, rank);
        if (r.rank && r.weakest < 1e-4)
            continue;                       /* near to less rank: the tolerances below are for the others */
        for (int i = 0; i < MOST; i++)
            b[i] = lw_rng_uniform(&rng) - 0.5;
        memcpy(keep, b, sizeof b);
        lw_rank_solve(&r, b, x);
        check_solution(m, n, a, 0, x, keep, &r);
        lw_rank_solve_transposed(&r, keep, x);
        check_solution(m, n, a, 1, x, keep, &r);
        for (int k = 0; k < m - r.rank; k++) {
            double length = 0;
            lw_rank_left_null(&r, k, x);
            apply(m, n, a, 1, x, ax);
            for (int i = 0; i < n; i++)
                CHECK_NEAR(ax[i], 0, 1e-11, 0);
            for (int i = 0; i < m; i++)
                length += x[i]*x[i];
            CHECK_NEAR(length, 1, 1e-13, 0);
        }
        memcpy(x, keep, sizeof x);
        lw_rank_null_part(&r, x);
        apply(m, n, a, 0, x, ax);
        for (int i = 0; i < m; i++)
            CHECK_NEAR(ax[i], 0, 1e-11, 0);
    }
}

/* A^T x = b has its least norm in the range of A: compare with A y for the y of A^T A y = b. */
TEST(transposed_is_of_least_norm)
{
    double a[6] = { 1, 2, 3, 2, 4, 6 }, b[2] = { 14, 28 }, x[3];    /* two columns, (1 2 3) and twice it */
    lw_rank r;
    lw_rank_place(&r, 3, 2, doubles, ints);
    memcpy(r.a, a, sizeof a);
    lw_rank_factor(&r, 1e-12);
    CHECK_INT(r.rank, 1);
    lw_rank_solve_transposed(&r, b, x);
    for (int i = 0; i < 3; i++)
        CHECK_NEAR(x[i], i + 1, 1e-14, 0);
}

TEST(zero_and_nan)
{
    double x[2], b[2] = { 1, 2 };
    lw_rank r;
    lw_rank_place(&r, 2, 2, doubles, ints);
    memset(r.a, 0, 4*sizeof *r.a);
    lw_rank_factor(&r, 1e-12);
    CHECK_INT(r.rank, 0);
    lw_rank_solve(&r, b, x);
    CHECK(x[0] == 0 && x[1] == 0);
    r.a[2] = NAN;
    lw_rank_factor(&r, 1e-12);
    CHECK_INT(r.rank, 0);
}
