/* Small quadratic programs against the enumeration of all active sets: the minimum is the solution of
 * the equality problem of some independent set of rows, so the best feasible one of all sets is it. */
#include "optimise/solvers/qp.h"
#include "tests/check.h"

enum { N = 8, M = 10 };

typedef struct program {
    int    n, m;
    double h[N*N], g[N], a[M*N], b[M];
} program;

/* Gauss with row exchange, k equations; false when singular. */
static bool gauss(int k, double *a, double *b)
{
    for (int c = 0; c < k; c++) {
        int top = c;
        for (int r = c + 1; r < k; r++)
            top = fabs(a[r*k + c]) > fabs(a[top*k + c]) ? r : top;
        if (fabs(a[top*k + c]) < 1e-9)
            return false;
        for (int i = 0; i < k; i++) {
            double t = a[c*k + i];
            a[c*k + i] = a[top*k + i];
            a[top*k + i] = t;
        }
        double t = b[c];
        b[c] = b[top];
        b[top] = t;
        for (int r = c + 1; r < k; r++) {
            double q = a[r*k + c]/a[c*k + c];
            for (int i = c; i < k; i++)
                a[r*k + i] -= q*a[c*k + i];
            b[r] -= q*b[c];
        }
    }
    for (int c = k - 1; c >= 0; c--) {
        for (int i = c + 1; i < k; i++)
            b[c] -= a[c*k + i]*b[i];
        b[c] /= a[c*k + c];
    }
    return true;
}

/* Minimum with the rows of `set` as equations. */
static bool solve_set(const program *q, unsigned set, double *p)
{
    int row[M], n_row = 0, n = q->n;
    for (int j = 0; j < q->m; j++)
        if (set >> j & 1)
            row[n_row++] = j;
    int k = n + n_row;
    double a[(N + M)*(N + M)] = { 0 }, b[N + M];
    if (n_row > n)
        return false;
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < n; c++)
            a[i*k + c] = q->h[i*n + c];
        for (int c = 0; c < n_row; c++)
            a[i*k + n + c] = a[(n + c)*k + i] = q->a[row[c]*n + i];
        b[i] = -q->g[i];
    }
    for (int c = 0; c < n_row; c++)
        b[n + c] = q->b[row[c]];
    if (!gauss(k, a, b))
        return false;
    memcpy(p, b, sizeof *p*(size_t)n);
    return true;
}

static double value(const program *q, const double *p)
{
    double f = 0;
    for (int i = 0; i < q->n; i++) {
        f += q->g[i]*p[i];
        for (int k = 0; k < q->n; k++)
            f += 0.5*p[i]*q->h[i*q->n + k]*p[k];
    }
    return f;
}

/* How far p is outside: 0 inside. */
static double violation(const program *q, const double *p)
{
    double worst = 0;
    for (int j = 0; j < q->m; j++) {
        double s = -q->b[j];
        for (int i = 0; i < q->n; i++)
            s += q->a[j*q->n + i]*p[i];
        worst = fmax(worst, -s);
    }
    return worst;
}

static bool enumerate(const program *q, double *best)
{
    double least = INFINITY, p[N];
    for (unsigned set = 0; set < 1u << q->m; set++) {
        if (!solve_set(q, set, p) || violation(q, p) > 1e-8)
            continue;
        double f = value(q, p);
        if (f < least) {
            least = f;
            memcpy(best, p, sizeof *p*(size_t)q->n);
        }
    }
    return isfinite(least);
}

static bool solve(const program *q, double *p)
{
    double l[N*N], work[2*N*N];
    memcpy(l, q->h, sizeof *l*(size_t)(q->n*q->n));
    CHECK(lw_qp_cholesky(q->n, l));
    short first[M + 1], column[M*N];
    lw_qp_rows dense = { .m = q->m, .a = q->a, .b = q->b }, listed = { q->m, q->a, q->b, q->m/2, first, column };
    lw_qp_list(q->n, listed.n_listed, q->a, first, column);
    double same[N] = { 0 };
    bool found = lw_qp_solve(q->n, l, q->g, &listed, work, same);
    CHECK(lw_qp_solve(q->n, l, q->g, &dense, work, p) == found);
    for (int i = 0; i < q->n && found; i++)
        CHECK_NEAR(same[i], p[i], 0, 0);
    return found;
}

static void check_against_all_sets(const program *q)
{
    double p[N], want[N];
    bool solvable = enumerate(q, want);
    CHECK_INT(solve(q, p), solvable);
    for (int i = 0; solvable && i < q->n; i++)
        CHECK_NEAR(p[i], want[i], 1e-8, 1e-8);          /* h has a condition below 1e4 */
    if (solvable)
        CHECK(violation(q, p) <= 1e-10);
}

static void draw_hessian(lw_rng *rng, program *q)
{
    double r[N*N];
    for (int i = 0; i < q->n*q->n; i++)
        r[i] = lw_rng_normal(rng);
    for (int i = 0; i < q->n; i++)
        for (int k = 0; k < q->n; k++) {
            q->h[i*q->n + k] = i == k ? 0.1 : 0;
            for (int c = 0; c < q->n; c++)
                q->h[i*q->n + k] += r[i*q->n + c]*r[k*q->n + c];
        }
}

static int whole(lw_rng *rng, int most) { return (int)lw_rng_range(rng, -most, most + 1); }

TEST(agrees_with_enumeration)
{
    lw_rng rng = check_rng(1);
    int contradictory = 0;
    for (int trial = 0; trial < 600; trial++) {
        program q = { .n = 1 + trial % N, .m = (int)lw_rng_range(&rng, 0, 9) };
        draw_hessian(&rng, &q);
        for (int i = 0; i < q.n; i++)
            q.g[i] = 3*lw_rng_normal(&rng);
        for (int j = 0; j < q.m; j++) {
            for (int i = 0; i < q.n; i++)
                q.a[j*q.n + i] = lw_rng_normal(&rng);
            q.b[j] = lw_rng_normal(&rng) - 0.3;
        }
        check_against_all_sets(&q);
        double p[N];
        contradictory += !solve(&q, p);
    }
    CHECK(contradictory > 20);                           /* both outcomes were met */
}

/* Small whole numbers: rows that repeat, meet in one point, oppose each other exactly, or are zero. */
TEST(agrees_where_rows_depend_on_each_other)
{
    lw_rng rng = check_rng(2);
    int solved = 0;
    for (int trial = 0; trial < 1500; trial++) {
        program q = { .n = 1 + trial % 4, .m = (int)lw_rng_range(&rng, 2, 10) };
        draw_hessian(&rng, &q);
        for (int i = 0; i < q.n; i++)
            q.g[i] = whole(&rng, 4);
        for (int j = 0; j < q.m; j++) {
            int twin = j > 0 && lw_rng_uniform(&rng) < 0.3 ? j - 1 : -1;
            double sign = lw_rng_uniform(&rng) < 0.5 ? -1 : 1;
            for (int i = 0; i < q.n; i++)
                q.a[j*q.n + i] = twin >= 0 ? sign*q.a[twin*q.n + i] : whole(&rng, 1);
            q.b[j] = twin >= 0 ? sign*q.b[twin] : whole(&rng, 2) - 1;
        }
        check_against_all_sets(&q);
        double p[N];
        solved += solve(&q, p);
    }
    CHECK(solved > 200 && solved < 1400);
}

/* Rows a few 1e-6 apart, and a last row that with positive weights adds up with them to 0 = 0 - `gap`: no point meets all of
 * them if the gap is positive, whatever rounding does. */
TEST(knows_contradictions_of_nearly_parallel_rows)
{
    lw_rng rng = check_rng(4);
    for (int trial = 0; trial < 400; trial++) {
        bool contradicts = trial % 2;
        program q = { .n = 2 + trial/2 % (N - 1) };
        double p[N], along[N];
        draw_hessian(&rng, &q);
        for (int i = 0; i < q.n; i++) {
            q.g[i] = lw_rng_normal(&rng);
            along[i] = lw_rng_normal(&rng);
        }
        double *last = q.a + q.n*q.n;
        q.b[q.n] = contradicts ? 0.5 : -0.5;
        for (int j = 0; j < q.n; j++) {
            double weight = lw_rng_range(&rng, 0.5, 2);
            for (int i = 0; i < q.n; i++) {
                q.a[j*q.n + i] = along[i] + 5e-6*lw_rng_normal(&rng);
                last[i] -= weight*q.a[j*q.n + i];
            }
            q.b[j] = lw_rng_normal(&rng);
            q.b[q.n] -= weight*q.b[j];
        }
        q.m = q.n + 1;
        bool solved = solve(&q, p);
        CHECK_INT(solved, !contradicts);
        double far = 0;
        for (int i = 0; i < q.n; i++)
            far = fmax(far, fabs(p[i]));
        if (solved)
            CHECK(violation(&q, p) <= 1e-12*(1 + far));
    }
}

/* Bounds, as the fit uses them: the box clips a diagonal problem; equal bounds hold a variable. */
TEST(clips_to_a_box)
{
    program q = { .n = 3, .m = 6, .h = { 1, 0, 0, 0, 2, 0, 0, 0, 4 }, .g = { -5, 1, 8 },
                  .a = { 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1 },
                  .b = { -1, -1, -1, -1, 0.25, -0.25 } };
    double p[3];
    CHECK(solve(&q, p));
    CHECK_NEAR(p[0], 1, 0, 1e-15);
    CHECK_NEAR(p[1], -0.5, 0, 1e-15);
    CHECK_NEAR(p[2], 0.25, 0, 1e-15);
}

/* Variables measured in other units, by powers of two: the same answer in these units. */
TEST(does_not_mind_units)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 200; trial++) {
        program q = { .n = 6, .m = 8 }, s;
        double p[N], t[N], d[N];
        draw_hessian(&rng, &q);
        for (int i = 0; i < q.n; i++) {
            q.g[i] = lw_rng_normal(&rng);
            d[i] = ldexp(1, whole(&rng, 20));
        }
        for (int j = 0; j < q.m; j++) {
            for (int i = 0; i < q.n; i++)
                q.a[j*q.n + i] = lw_rng_normal(&rng);
            q.b[j] = -0.5*lw_rng_uniform(&rng);
        }
        s = q;
        for (int i = 0; i < q.n; i++) {
            s.g[i] *= d[i];
            for (int k = 0; k < q.n; k++)
                s.h[i*q.n + k] *= d[i]*d[k];
            for (int j = 0; j < q.m; j++)
                s.a[j*q.n + i] *= d[i];
        }
        CHECK(solve(&q, p) && solve(&s, t));
        for (int i = 0; i < q.n; i++)
            CHECK_NEAR(t[i]*d[i], p[i], 0, 0);
    }
}

TEST(refuses_what_is_not_positive_definite)
{
    double flat[4] = { 1, 0, 1, 1 }, saddle[4] = { 1, 0, 2, 1 }, nan[1] = { NAN }, zero[1] = { 0 };
    CHECK(!lw_qp_cholesky(2, flat));
    CHECK(!lw_qp_cholesky(2, saddle));
    CHECK(!lw_qp_cholesky(1, nan));
    CHECK(!lw_qp_cholesky(1, zero));
}
