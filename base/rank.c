#include "base/rank.h"

#include <string.h>
#include "base/real.h"
#include "base/vector.h"

size_t lw_rank_doubles(int m, int n) { return (size_t)m*(size_t)n + 3*(size_t)(m + n); }
size_t lw_rank_ints(int m, int n) { return (size_t)n + 0*(size_t)m; }

void lw_rank_place(lw_rank *r, int m, int n, double *doubles, int *ints)
{
    int least = m < n ? m : n;
    *r = (lw_rank){ .m = m, .n = n, .a = doubles, .column = ints };
    r->left = doubles + (size_t)m*(size_t)n;
    r->right = r->left + least;
    r->work = r->right + least;
}

static double *column(const lw_rank *r, int k) { return r->a + (size_t)k*(size_t)r->m; }

/* I - factor v v^T with v[0] = 1 takes x to (-sign |x|, 0 ..); v over x, its first number the new one. */
static double reflector(double *x, int n, double rest)
{
    double size = hypot(x[0], rest), head = x[0];
    if (!(size > 0) || rest == 0)
        return 0;
    double top = head > 0 ? -size : size;
    for (int i = 1; i < n; i++)
        x[i] /= head - top;
    x[0] = top;
    return (top - head)/top;
}

/* Reflect c, of which v[0] = 1 stands for c[0]. */
static void reflect(const double *v, double factor, double *c, int n)
{
    double sum = c[0];
    for (int i = 1; i < n; i++)
        sum += v[i]*c[i];
    sum *= factor;
    c[0] -= sum;
    for (int i = 1; i < n; i++)
        c[i] -= sum*v[i];
}

enum { TOGETHER = 4 };                       /* columns, whose sums do not wait for each other */

/* Reflect the rests of all columns behind k by column k. */
static void reflect_columns(lw_rank *r, int k)
{
    const double *v = column(r, k) + k;
    int n = r->m - k, j = k + 1;
    for (; j + TOGETHER <= r->n; j += TOGETHER) {
        double *c[TOGETHER], sum[TOGETHER];
        for (int q = 0; q < TOGETHER; q++) {
            c[q] = column(r, j + q) + k;
            sum[q] = c[q][0];
        }
        for (int i = 1; i < n; i++)
            for (int q = 0; q < TOGETHER; q++)
                sum[q] += v[i]*c[q][i];
        for (int q = 0; q < TOGETHER; q++) {
            sum[q] *= r->left[k];
            c[q][0] -= sum[q];
            for (int i = 1; i < n; i++)
                c[q][i] -= sum[q]*v[i];
        }
    }
    for (; j < r->n; j++)
        reflect(v, r->left[k], column(r, j) + k, n);
}

/* Lengths of the rests of columns j, j + 1, ... */
static void lengths_of(const lw_rank *r, int k, int j, double length[TOGETHER])
{
    const double *c[TOGETHER];
    double sum[TOGETHER] = { 0 };
    for (int q = 0; q < TOGETHER; q++)
        c[q] = column(r, j + q < r->n ? j + q : j);
    for (int i = k; i < r->m; i++)
        for (int q = 0; q < TOGETHER; q++)
            sum[q] += c[q][i]*c[q][i];
    for (int q = 0; q < TOGETHER; q++)
        length[q] = sqrt(sum[q]);
}

/* The column with the longest rest goes to place k; returns that length. */
static double pivot_longest_column(lw_rank *r, int k)
{
    int best = k;
    double longest = -1, length[TOGETHER];
    for (int j = k; j < r->n; j++) {
        int q = (j - k)%TOGETHER;
        if (q == 0)
            lengths_of(r, k, j, length);
        if (length[q] > longest || isnan(length[q])) {
            longest = length[q];
            best = j;
        }
    }
    if (best == k)
        return longest;
    double *a = column(r, k), *b = column(r, best);
    for (int i = 0; i < r->m; i++) {
        double t = a[i];
        a[i] = b[i];
        b[i] = t;
    }
    int t = r->column[k];
    r->column[k] = r->column[best];
    r->column[best] = t;
    return longest;
}

/* Row k of [T R12] from the right: only place k and those from rank on change. */
static void fold_row(lw_rank *r, int k)
{
    double sum = 0;
    for (int j = r->rank; j < r->n; j++)
        sum += column(r, j)[k]*column(r, j)[k];
    double head = column(r, k)[k], size = sqrt(head*head + sum);
    r->right[k] = 0;
    if (sum == 0 || !(size > 0))
        return;
    double top = head > 0 ? -size : size;
    for (int j = r->rank; j < r->n; j++)
        column(r, j)[k] /= head - top;
    column(r, k)[k] = top;
    r->right[k] = (top - head)/top;
    for (int i = 0; i < k; i++) {
        double dot = column(r, k)[i];
        for (int j = r->rank; j < r->n; j++)
            dot += column(r, j)[i]*column(r, j)[k];
        dot *= r->right[k];
        column(r, k)[i] -= dot;
        for (int j = r->rank; j < r->n; j++)
            column(r, j)[i] -= dot*column(r, j)[k];
    }
}

void lw_rank_factor(lw_rank *r, double least)
{
    int most = r->m < r->n ? r->m : r->n;
    most = r->most > 0 && r->most < most ? r->most : most;
    double first = 0;
    r->rank = 0;
    r->weakest = 0;
    for (int j = 0; j < r->n; j++)
        r->column[j] = j;
    for (int k = 0; k < most; k++) {
        double longest = pivot_longest_column(r, k);
        first = k == 0 ? longest : first;
        if (!(longest > least*first) || !(longest > 0) || isinf(longest) || (r->stop && *r->stop))
            break;
        double *c = column(r, k) + k;
        r->left[k] = reflector(c, r->m - k, lw_norm(r->m - k - 1, c + 1));
        reflect_columns(r, k);
        r->weakest = longest/first;
        r->rank++;
    }
    for (int k = r->rank - 1; k >= 0 && !(r->stop && *r->stop); k--)
        fold_row(r, k);
}

/* Reflector k of Z on z (n). */
static void fold(const lw_rank *r, int k, double *z)
{
    double sum = z[k];
    for (int j = r->rank; j < r->n; j++)
        sum += column(r, j)[k]*z[j];
    sum *= r->right[k];
    z[k] -= sum;
    for (int j = r->rank; j < r->n; j++)
        z[j] -= sum*column(r, j)[k];
}

/* x = P Z^T z */
static void from_rows(const lw_rank *r, double *z, double *x)
{
    for (int k = 0; k < r->rank; k++)
        fold(r, k, z);
    for (int j = 0; j < r->n; j++)
        x[r->column[j]] = z[j];
}

void lw_rank_solve(const lw_rank *r, double *b, double *x)
{
    double *z = r->work;
    for (int k = 0; k < r->rank; k++)
        reflect(column(r, k) + k, r->left[k], b + k, r->m - k);
    memset(z, 0, (size_t)r->n*sizeof *z);
    for (int k = r->rank - 1; k >= 0; k--) {
        double sum = b[k];
        for (int j = k + 1; j < r->rank; j++)
            sum -= column(r, j)[k]*z[j];
        z[k] = sum/column(r, k)[k];
    }
    from_rows(r, z, x);
}

/* z = Z P^T x: its first `rank` numbers are the part in the row space. */
static void to_rows(const lw_rank *r, const double *x, double *z)
{
    for (int j = 0; j < r->n; j++)
        z[j] = x[r->column[j]];
    for (int k = r->rank - 1; k >= 0; k--)
        fold(r, k, z);
}

void lw_rank_solve_transposed(const lw_rank *r, const double *b, double *x)
{
    double *z = r->work;
    to_rows(r, b, z);
    memset(x, 0, (size_t)r->m*sizeof *x);
    for (int k = 0; k < r->rank; k++) {
        double sum = z[k];
        for (int j = 0; j < k; j++)
            sum -= column(r, k)[j]*x[j];
        x[k] = sum/column(r, k)[k];
    }
    for (int k = r->rank - 1; k >= 0; k--)
        reflect(column(r, k) + k, r->left[k], x + k, r->m - k);
}

void lw_rank_left_null(const lw_rank *r, int k, double *x)
{
    memset(x, 0, (size_t)r->m*sizeof *x);
    x[r->rank + k] = 1;
    for (int i = r->rank - 1; i >= 0; i--)
        reflect(column(r, i) + i, r->left[i], x + i, r->m - i);
}

void lw_rank_null_part(const lw_rank *r, double *x)
{
    double *z = r->work;
    to_rows(r, x, z);
    memset(z, 0, (size_t)r->rank*sizeof *z);
    from_rows(r, z, x);
}
