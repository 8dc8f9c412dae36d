/* base/sparse.c - elimination that skips zeros. */
#include "base/sparse.h"

#include <math.h>
#include <string.h>

void lw_sparse_order(int n, unsigned char *near, int *order)
{
    for (int k = 0; k < n; k++)
        order[k] = k;
    for (int k = 0; k < n; k++) {
        int best = k, least = n + 1;
        for (int i = k; i < n; i++) {
            int met = 0;
            for (int j = k; j < n; j++)
                met += order[j] != order[i] && near[order[i]*n + order[j]];
            if (met < least)
                best = i, least = met;
        }
        int next = order[best];
        memmove(order + k + 1, order + k, (size_t)(best - k)*sizeof *order);
        order[k] = next;
        for (int i = k + 1; i < n; i++)              /* those it met now meet each other */
            for (int j = k + 1; near[next*n + order[i]] && j < n; j++)
                near[order[i]*n + order[j]] |= near[next*n + order[j]];
    }
}

size_t lw_sparse_doubles(int n) { return (size_t)n*(size_t)n + (size_t)n; }
size_t lw_sparse_ints(int n)    { return (size_t)n*(size_t)n + 4*(size_t)n + 1; }

void lw_sparse_place(lw_sparse *f, int n, double *doubles, int *ints)
{
    *f = (lw_sparse){ .n = n, .a = doubles, .work = doubles + (size_t)n*(size_t)n, .order = ints, .row = ints + n,
                      .at = ints + 2*n, .list = ints + 4*n + 1 };
}

void lw_sparse_prepare(lw_sparse *f, const double *a)
{
    int n = f->n;
    unsigned char *near = (unsigned char *)f->list;
    memset(near, 0, (size_t)n*(size_t)n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; a[i + n*j] != 0 && k < n; k++)
                near[j*n + k] |= a[i + n*k] != 0;
    lw_sparse_order(n, near, f->order);
}

static void swap_rows(lw_sparse *f, int i, int j)
{
    int row = f->row[i];
    f->row[i] = f->row[j];
    f->row[j] = row;
    for (int c = 0; c < f->n; c++) {
        double x = f->a[i + f->n*c];
        f->a[i + f->n*c] = f->a[j + f->n*c];
        f->a[j + f->n*c] = x;
    }
}

/* Where the factors are not 0. */
static void list_entries(lw_sparse *f)
{
    int n = f->n, used = 0;
    for (int k = 0; k < n; k++) {
        const double *column = f->a + k*n;
        f->at[2*k] = used;
        for (int i = k + 1; i < n; i++)
            if (column[i] != 0)
                f->list[used++] = i;
        f->at[2*k + 1] = used;
        for (int i = 0; i < k; i++)
            if (column[i] != 0)
                f->list[used++] = i;
    }
    f->at[2*n] = used;
}

int lw_sparse_factor(lw_sparse *f, const double *a)
{
    int n = f->n, *below = f->list;
    for (int k = 0; k < n; k++) {
        memcpy(f->a + k*n, a + f->order[k]*n, (size_t)n*sizeof *a);
        f->row[k] = k;
    }
    for (int k = 0; k < n; k++) {
        double *pivot = f->a + k*n;
        int best = k, m = 0;
        for (int i = k + 1; i < n; i++)
            best = fabs(pivot[i]) > fabs(pivot[best]) ? i : best;
        if (!(fabs(pivot[best]) > 0))
            return 1 + f->order[k];
        if (best != k)
            swap_rows(f, k, best);
        for (int i = k + 1; i < n; i++)
            if (pivot[i] != 0) {
                pivot[i] /= pivot[k];
                below[m++] = i;
            }
        for (int j = k + 1; j < n; j++) {
            double *column = f->a + j*n, x = column[k];
            for (int i = 0; x != 0 && i < m; i++)
                column[below[i]] -= pivot[below[i]]*x;
        }
    }
    list_entries(f);
    return 0;
}

void lw_sparse_solve(const lw_sparse *f, const double *b, double *x)
{
    int n = f->n;
    double *y = f->work;
    for (int k = 0; k < n; k++)
        y[k] = b[f->row[k]];
    for (int k = 0; k < n; k++)
        for (int i = f->at[2*k]; y[k] != 0 && i < f->at[2*k + 1]; i++)
            y[f->list[i]] -= f->a[f->list[i] + n*k]*y[k];
    for (int k = n - 1; k >= 0; k--) {
        double each = y[k] /= f->a[k + n*k];
        for (int i = f->at[2*k + 1]; i < f->at[2*k + 2]; i++)
            y[f->list[i]] -= f->a[f->list[i] + n*k]*each;
    }
    for (int k = 0; k < n; k++)
        x[f->order[k]] = y[k];
}
