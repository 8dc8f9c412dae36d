/* base/sparse: random systems against their own products, the order of elimination against known fill, factors of rows against
 * solutions that are known. */
#include "base/sparse.h"
#include "base/sparse_lu.h"
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

/* ---- symmetric systems -------------------------------------------------------------------------------- */

enum { ROWS = 90, COLUMNS = 40, ENTRIES = 3 };

/* The system A^T A of rows with ENTRIES columns each: its pattern, and both ways to factor it. */
typedef struct square {
    int    n_row, at[ROWS + 1], column[ROWS*ENTRIES];
    double entry[ROWS*ENTRIES];
    lw_cholesky c;
    lw_row_fronts f;
} square;

static void make_square(square *s)
{
    static bool meet[COLUMNS][COLUMNS];
    static int near_at[COLUMNS + 1], near[COLUMNS*COLUMNS], place[COLUMNS], column[ROWS*ENTRIES];
    memset(meet, 0, sizeof meet);
    for (int r = 0; r < s->n_row; r++)
        for (int p = s->at[r]; p < s->at[r + 1]; p++)
            for (int q = s->at[r]; q < s->at[r + 1]; q++)
                meet[s->column[p]][s->column[q]] = true;
    for (int i = 0; i < COLUMNS; i++) {
        near_at[i + 1] = near_at[i];
        for (int j = 0; j < COLUMNS; j++)
            if (i != j && meet[i][j])
                near[near_at[i + 1]++] = j;
    }
    CHECK(lw_cholesky_make(&s->c, COLUMNS, near_at, near));
    for (int k = 0; k < COLUMNS; k++)
        place[s->c.order[k]] = k;
    for (int p = 0; p < s->at[s->n_row]; p++)
        column[p] = place[s->column[p]];
    CHECK(lw_row_fronts_make(&s->f, &s->c, s->n_row, s->at, column));
}

static void free_square(square *s)
{
    lw_row_fronts_free(&s->f);
    lw_cholesky_free(&s->c);
}

static void random_square(square *s, lw_rng *rng)
{
    *s = (square){ .n_row = ROWS };
    for (int r = 0; r < ROWS; r++) {
        s->at[r + 1] = s->at[r] + ENTRIES;
        for (int k = 0; k < ENTRIES; k++) {              /* different columns; every column is in some row */
            s->column[s->at[r] + k] = k == 0 ? r % COLUMNS : (r + 1 + k*7 + 13*(int)(lw_rng_uniform(rng)*3)) % COLUMNS;
            s->entry[s->at[r] + k] = lw_rng_uniform(rng) - 0.5;
        }
    }
}

/* Both factors solve the same systems, with as near a pivot. */
TEST(factors_of_rows_and_of_their_square_agree)
{
    lw_rng rng;
    lw_rng_seed(&rng, 5, 0);
    for (int trial = 0; trial < 20; trial++) {
        square s;
        double b[3][COLUMNS], four[COLUMNS][4], least[2];
        random_square(&s, &rng);
        make_square(&s);
        memset(s.c.value, 0, (size_t)(s.c.n_entry + COLUMNS)*sizeof *s.c.value);
        for (int r = 0; r < ROWS; r++)
            for (int p = s.at[r]; p < s.at[r + 1]; p++)
                for (int q = s.at[r]; q < s.at[r + 1]; q++) {
                    int i = s.f.column[p], j = s.f.column[q];
                    if (i <= j)
                        s.c.value[lw_cholesky_entry(&s.c, i, j)] += s.entry[p]*s.entry[q];
                }
        for (int k = 0; k < COLUMNS; k++) {
            b[0][k] = b[1][k] = b[2][k] = lw_rng_uniform(&rng);
            for (int i = 0; i < 4; i++)
                four[k][i] = (i - 2)*b[0][k];
        }
        least[0] = lw_cholesky_factor(&s.c, 0, NULL);
        lw_cholesky_solve(&s.c, b[0]);
        lw_cholesky_solve_overlapped(&s.c, b[2]);
        lw_cholesky_solve_four(&s.c, four);
        least[1] = lw_row_fronts_factor(&s.f, &s.c, s.entry, 0, NULL);
        lw_cholesky_solve(&s.c, b[1]);
        CHECK(least[0] > 0);
        CHECK_NEAR(least[1], least[0], 1e-12, 1e-9);
        for (int k = 0; k < COLUMNS; k++) {
            CHECK_NEAR(b[1][k], b[0][k], 1e-9, 1e-9);
            CHECK_NEAR(b[2][k], b[0][k], 1e-9, 1e-9);
            for (int i = 0; i < 4; i++)
                CHECK_NEAR(four[k][i], (i - 2)*b[0][k], 1e-9, 1e-9);
        }
        free_square(&s);
    }
}

/* The second difference with a condition of 1e9: its square is singular to all digits.  x of least norm with A^T x = A^T 1 is 1,
 * since A is square. */
TEST(factors_of_rows_keep_their_digits)
{
    square s = { .n_row = COLUMNS };
    for (int r = 0; r < COLUMNS; r++) {
        s.at[r + 1] = s.at[r];
        for (int k = 0; k < 3 && r + k < COLUMNS; k++) {
            s.column[s.at[r + 1]] = r + k;
            s.entry[s.at[r + 1]++] = k == 0 ? 1 : k == 1 ? -3 : 2;     /* (1 - x) (1 - 2 x): the inverse grows as 2^n */
        }
    }
    make_square(&s);
    double b[COLUMNS] = { 0 }, off = 0;
    for (int r = 0; r < COLUMNS; r++)
        for (int p = s.at[r]; p < s.at[r + 1]; p++)
            b[s.f.column[p]] += s.entry[p];
    CHECK(lw_row_fronts_factor(&s.f, &s.c, s.entry, 0, NULL) > 0);
    lw_cholesky_solve(&s.c, b);
    for (int r = 0; r < COLUMNS; r++) {
        double x = 0;
        for (int p = s.at[r]; p < s.at[r + 1]; p++)
            x += s.entry[p]*b[s.f.column[p]];
        off = fmax(off, fabs(x - 1));
    }
    CHECK(off < 1e-4);                           /* 2^40 times the rounding */
    free_square(&s);
}

/* A column that depends on another is left out; the others still solve. */
TEST(dependent_columns_of_rows)
{
    lw_rng rng;
    lw_rng_seed(&rng, 6, 0);
    for (int trial = 0; trial < 20; trial++) {
        square s;
        bool dependent[COLUMNS];
        double x[COLUMNS], b[COLUMNS] = { 0 }, left[ROWS] = { 0 };
        int n = 0;
        random_square(&s, &rng);
        for (int r = 0; r < ROWS; r++) {         /* column 2 is twice column 0 */
            int zero = -1, two = -1;
            for (int p = s.at[r]; p < s.at[r + 1]; p++) {
                zero = s.column[p] == 0 ? p : zero;
                two = s.column[p] == 2 ? p : two;
            }
            if (zero >= 0 && two < 0) {
                two = zero == s.at[r] ? zero + 1 : s.at[r];
                s.column[two] = 2;
            }
            if (two >= 0)
                s.entry[two] = zero >= 0 ? 2*s.entry[zero] : 0;
        }
        make_square(&s);
        CHECK(lw_row_fronts_factor(&s.f, &s.c, s.entry, 1e-20, dependent) > 0);
        for (int k = 0; k < COLUMNS; k++)
            n += dependent[k];
        CHECK_INT(n, 1);
        for (int k = 0; k < COLUMNS; k++)
            x[k] = lw_rng_uniform(&rng);
        for (int pass = 0; pass < 2; pass++) {   /* b = A^T A x, then the residual of the solution */
            double y[ROWS] = { 0 };
            for (int r = 0; r < ROWS; r++)
                for (int p = s.at[r]; p < s.at[r + 1]; p++)
                    y[r] += s.entry[p]*x[s.f.column[p]];
            if (pass == 0) {
                memcpy(left, y, sizeof left);
                for (int r = 0; r < ROWS; r++)
                    for (int p = s.at[r]; p < s.at[r + 1]; p++)
                        b[s.f.column[p]] += s.entry[p]*y[r];
                lw_cholesky_solve(&s.c, b);
                for (int k = 0; k < COLUMNS; k++)
                    x[k] = dependent[k] ? 0 : b[k];
            } else
                for (int r = 0; r < ROWS; r++)
                    CHECK_NEAR(y[r], left[r], 1e-8, 0);
        }
        free_square(&s);
    }
}

/* Factors by KLU, with many zeros on the diagonal, in both orders of elimination; a pattern that no values make regular is singular. */
TEST(unsymmetric_systems)
{
    lw_rng rng;
    lw_rng_seed(&rng, 7, 0);
    for (int trial = 0; trial < 40; trial++) {
        const int n = 2 + trial;
        int pair[2*MOST*MOST];
        long n_pair = 0;
        double value[MOST*MOST], x[MOST], b[MOST] = { 0 };
        lw_columns c;
        random_matrix(&rng, n, 3*n);
        for (int k = 0; trial%4 == 3 && k < n; k++)          /* rows 0 and 1 meet the same single column */
            a[n*k] = a[1 + n*k] = k == 0;
        for (int k = 0; k < n*n; k++)
            if (a[k] != 0)
                pair[2*n_pair] = k%n, pair[2*n_pair++ + 1] = k/n;
        CHECK(lw_columns_make(&c, n, pair, n_pair));
        for (int j = 0; j < n; j++)
            x[j] = lw_rng_uniform(&rng);
        for (int j = 0; j < n; j++)
            for (int k = c.at[j]; k < c.at[j + 1]; k++)
                b[c.row[k]] += (value[k] = a[c.row[k] + n*j])*x[j];
        lw_sparse_lu *f = lw_sparse_lu_create(&c, trial%2, false);
        CHECK(f != NULL);
        lw_status s = lw_sparse_lu_factor(f, value);
        CHECK_INT(s, trial%4 == 3 ? LW_OPEN : LW_OK);
        if (s == LW_OK)
            lw_sparse_lu_solve(f, b);
        for (int j = 0; s == LW_OK && j < n; j++)
            CHECK_NEAR(b[j], x[j], 1e-8, 0);
        lw_sparse_lu_free(f);
        lw_columns_free(&c);
    }
}
