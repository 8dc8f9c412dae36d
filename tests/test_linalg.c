/* tests/test_linalg.c - the small QR against known systems and against the definition. */
#include "base/linalg.h"
#include "tests/check.h"

static double uniform(uint64_t *s)          /* own generator: splitmix64, not the library's */
{
    uint64_t z = *s += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30)*0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27)*0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11)*0x1p-53*2.0 - 1.0;
}

/* determinant by expansion along the first row, columns `used` taken out */
static double determinant(int n, const double *a, int row, unsigned used)
{
    if (row == n)
        return 1.0;
    double sum = 0.0, sign = 1.0;
    for (int j = 0; j < n; j++)
        if (!(used >> j & 1)) {
            sum += sign*a[row + n*j]*determinant(n, a, row + 1, used | 1u << j);
            sign = -sign;
        }
    return sum;
}

TEST(solves_square_systems)
{
    uint64_t seed = check_seed();
    for (int trial = 0; trial < 2000; trial++) {
        int n = 1 + trial % 10;
        double a[100], f[100], d[10], x[10], b[10] = { 0 };
        for (int i = 0; i < n*n; i++)
            f[i] = a[i] = uniform(&seed);
        for (int j = 0; j < n; j++) {
            x[j] = uniform(&seed);
            for (int i = 0; i < n; i++)
                b[i] += a[i + n*j]*x[j];
        }
        double condition = lw_qr_factor(n, n, f, d);
        CHECK(condition > 0.0 && condition <= 1.0);
        lw_qr_solve(n, n, f, d, b);
        for (int j = 0; j < n; j++)
            CHECK_NEAR(b[j], x[j], 1e-13/condition, 0);
    }
}

TEST(determinant_by_expansion)
{
    uint64_t seed = check_seed() + 1;
    for (int trial = 0; trial < 600; trial++) {
        int n = 1 + trial % 6;
        double a[36], d[6];
        for (int i = 0; i < n*n; i++)
            a[i] = uniform(&seed);
        double det = determinant(n, a, 0, 0);
        lw_qr_factor(n, n, a, d);
        CHECK_NEAR(lw_qr_determinant(n, d), det, 1e-13, 1e-12);
    }
}

/* least squares: the residual is perpendicular to every column */
TEST(fits_more_equations_than_unknowns)
{
    uint64_t seed = check_seed() + 2;
    for (int trial = 0; trial < 300; trial++) {
        enum { M = 12, N = 5 };
        double a[M*N], f[M*N], d[N], b[M], x[M];
        for (int i = 0; i < M*N; i++)
            f[i] = a[i] = uniform(&seed);
        for (int i = 0; i < M; i++)
            x[i] = b[i] = uniform(&seed);
        lw_qr_factor(M, N, f, d);
        lw_qr_solve(M, N, f, d, x);
        double left = 0.0, rest[M];
        for (int i = 0; i < M; i++) {
            rest[i] = b[i];
            for (int j = 0; j < N; j++)
                rest[i] -= a[i + M*j]*x[j];
            left += rest[i]*rest[i];
        }
        double tail = 0.0;
        for (int i = N; i < M; i++)
            tail += x[i]*x[i];
        CHECK_NEAR(tail, left, 1e-13, 0);
        for (int j = 0; j < N; j++) {
            double dot = 0.0;
            for (int i = 0; i < M; i++)
                dot += rest[i]*a[i + M*j];
            CHECK_NEAR(dot, 0.0, 1e-13, 0);
        }
    }
}

TEST(tells_a_singular_matrix)
{
    double zero[4] = { 0, 0, 0, 0 }, column[4] = { 0, 0, 1, 2 }, nan[4] = { 1, NAN, 0, 1 }, d[2];
    CHECK_NEAR(lw_qr_factor(2, 2, zero, d), 0.0, 0, 0);
    CHECK_NEAR(lw_qr_determinant(2, d), 0.0, 0, 0);
    CHECK_NEAR(lw_qr_factor(2, 2, column, d), 0.0, 0, 0);
    CHECK(isnan(lw_qr_factor(2, 2, nan, d)));
}
