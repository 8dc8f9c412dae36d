/* tests/test_linalg.c - the small QR, and eigenvalues of tridiagonal matrices, against known systems and against the definition. */
#include "base/eigen.h"
#include "base/linalg.h"
#include "base/vector.h"
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

/* The second difference has the eigenvalues 2 cos(k pi/(n + 1)) and vectors sin(i k pi/(n + 1)) sqrt(2/(n + 1)), at any scale; random matrices, some of
 * which come apart, satisfy the definition; single rows of the vectors are those of whole ones. */
TEST(tridiagonal_matrices)
{
    enum { N = 30 };
    uint64_t seed = check_seed();
    for (int trial = 0; trial < 300; trial++) {
        double a[N], b[N] = { 0 }, w[N], left[N], x[N*N] = { 0 }, last[N] = { 0 };
        double scale = trial%3 == 0 ? 1e-200 : trial%3 == 1 ? 1 : 1e150;
        bool closed = trial < 3;
        int n = closed ? N : 1 + trial%N;
        for (int i = 0; i < n; i++) {
            a[i] = closed ? 0 : scale*uniform(&seed);
            b[i] = i == n - 1 ? 0 : closed ? scale : trial%5 && i%4 == 3 ? 0 : scale*uniform(&seed);
            x[i*n + i] = 1;
        }
        last[n - 1] = 1;
        memcpy(w, a, sizeof w), memcpy(left, b, sizeof left);
        CHECK_INT(lw_eigen_tridiagonal(n, w, left, n, x), LW_OK);
        double same[N], other[N];
        memcpy(same, a, sizeof same), memcpy(other, b, sizeof other);
        CHECK_INT(lw_eigen_tridiagonal(n, same, other, 1, last), LW_OK);
        for (int k = 0; k < n; k++) {
            double length = 0;
            for (int i = 0; i < n; i++) {
                double product = a[i]*x[k*n + i] + (i ? b[i - 1]*x[k*n + i - 1] : 0) + (i < n - 1 ? b[i]*x[k*n + i + 1] : 0);
                CHECK_NEAR(product/scale, w[k]/scale*x[k*n + i], 1e-13, 0);
                length += x[k*n + i]*x[k*n + i];
            }
            CHECK_NEAR(length, 1, 1e-13, 0);
            CHECK(same[k] == w[k] && last[k] == x[k*n + n - 1]);
            int order = 1;                               /* from the greatest on */
            for (int i = 0; i < n; i++)
                order += w[i] > w[k];
            if (closed)
                CHECK_NEAR(w[k]/scale, 2*cos(order*acos(-1)/(n + 1)), 1e-14, 0);
        }
    }
    double nan[2] = { NAN, 1 }, one[2] = { 1, 0 }, unit[2] = { 1, 0 };
    CHECK_INT(lw_eigen_tridiagonal(2, nan, one, 1, unit), LW_E_ARG);
}

/* Wherever a value that is not finite stands, it is not lost beside greater ones. */
TEST(greatest_magnitudes)
{
    const double bad[] = { NAN, INFINITY, -INFINITY };
    for (int k = 0; k < 3; k++)
        for (int at = 0; at < 3; at++) {
            double x[] = { 1, -3, 2 };
            CHECK(lw_greatest(3, x) == 3 && lw_greatest_or_infinite(3, x) == 3);
            x[at] = bad[k];
            CHECK(lw_greatest_or_infinite(3, x) == INFINITY);
        }
}
