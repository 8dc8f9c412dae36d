/* base/sparse_lu.c - bridge to KLU of SuiteSparse. */
#include "base/sparse_lu.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/klu.h>

static const double least_pivot = 0.1;       /* of the diagonal, over the greatest of its column */
static const double weak_pivots = 1e-6;      /* least reciprocal pivot growth with which old pivots are kept */

/* ---- pattern ------------------------------------------------------------------------------------ */

static int compare(const void *a, const void *b) { return *(const int *)a - *(const int *)b; }

bool lw_columns_make(lw_columns *c, int n, const int *pair, long n_pair)
{
    *c = (lw_columns){ .n = n, .at = calloc((size_t)n + 2, sizeof *c->at), .row = malloc(((size_t)n_pair + 1)*sizeof *c->row) };
    if (!c->at || !c->row) {
        lw_columns_free(c);
        return false;
    }
    for (long i = 0; i < n_pair; i++)
        c->at[pair[2*i + 1] + 2]++;
    for (int j = 0; j < n; j++)
        c->at[j + 2] += c->at[j + 1];
    for (long i = 0; i < n_pair; i++)
        c->row[c->at[pair[2*i + 1] + 1]++] = pair[2*i];
    int used = 0;
    for (int j = 0, first = 0; j < n; j++) {                     /* sort each column and drop repeated entries */
        int end = c->at[j + 1], start = used;
        qsort(c->row + first, (size_t)(end - first), sizeof *c->row, compare);
        for (int i = first; i < end; i++)
            if (used == start || c->row[used - 1] != c->row[i])
                c->row[used++] = c->row[i];
        first = end;
        c->at[j] = start;
    }
    c->at[n] = used;
    return true;
}

void lw_columns_free(lw_columns *c)
{
    free(c->at);
    free(c->row);
    memset(c, 0, sizeof *c);
}

/* ---- factors ------------------------------------------------------------------------------------ */

struct lw_sparse_lu {
    const lw_columns *pattern;
    bool         is_complex;
    klu_common   common;
    klu_symbolic *symbolic;
    klu_numeric  *numeric;
};

lw_sparse_lu *lw_sparse_lu_create(const lw_columns *pattern, bool saddle, bool is_complex)
{
    lw_sparse_lu *f = calloc(1, sizeof *f);
    if (!f)
        return NULL;
    f->pattern = pattern;
    f->is_complex = is_complex;
    klu_defaults(&f->common);
    f->common.ordering = saddle;             /* 0: AMD, 1: COLAMD */
    f->common.btf = 0;                       /* finding blocks takes the square of n where many diagonals are 0 */
    f->common.tol = least_pivot;
    f->symbolic = pattern->n ? klu_analyze(pattern->n, pattern->at, pattern->row, &f->common) : NULL;
    if (f->symbolic || pattern->n == 0)          /* KLU refuses systems without unknowns */
        return f;
    free(f);
    return NULL;
}

static void free_numeric(lw_sparse_lu *f)
{
    (f->is_complex ? klu_z_free_numeric : klu_free_numeric)(&f->numeric, &f->common);
}

void lw_sparse_lu_free(lw_sparse_lu *f)
{
    if (!f)
        return;
    free_numeric(f);
    klu_free_symbolic(&f->symbolic, &f->common);
    free(f);
}

lw_status lw_sparse_lu_factor(lw_sparse_lu *f, const double *value)
{
    int *at = f->pattern->at, *row = f->pattern->row;
    double *a = (double *)(uintptr_t)value;
    if (f->pattern->n == 0)
        return LW_OK;
    if (f->numeric && (f->is_complex ? klu_z_refactor : klu_refactor)(at, row, a, f->symbolic, f->numeric, &f->common)
        && (f->is_complex ? klu_z_rgrowth : klu_rgrowth)(at, row, a, f->symbolic, f->numeric, &f->common)
        && f->common.rgrowth > weak_pivots)
        return LW_OK;
    free_numeric(f);
    f->numeric = (f->is_complex ? klu_z_factor : klu_factor)(at, row, a, f->symbolic, &f->common);
    return f->numeric ? LW_OK : f->common.status == KLU_OUT_OF_MEMORY ? LW_E_MEMORY : LW_OPEN;
}

void lw_sparse_lu_solve(lw_sparse_lu *f, double *b)
{
    if (f->pattern->n)
        (f->is_complex ? klu_z_solve : klu_solve)(f->symbolic, f->numeric, f->pattern->n, 1, b, &f->common);
}
