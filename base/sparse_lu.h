/* base/sparse_lu.h - large sparse linear systems by KLU of SuiteSparse (Davis & Palamadai Natarajan 2010).
 *
 * A x = b with A stored by columns without its zeros.  The pattern is analysed once; matrices of the same pattern are factored
 * again with the pivots of the first, unless those have become too small. */
#ifndef LW_BASE_SPARSE_LU_H
#define LW_BASE_SPARSE_LU_H

#include <stdbool.h>
#include "base/status.h"
#include "base/vector.h"

/* Entries of column j: rows row[at[j]] .. row[at[j + 1] - 1], ascending. */
typedef struct lw_columns { int n, *at, *row; } lw_columns;

/* The pattern of entries (pair[2*i], pair[2*i + 1]) = (row, column), which may repeat.  false: out of memory. */
bool lw_columns_make(lw_columns *c, int n, const int *pair, long n_pair);
void lw_columns_free(lw_columns *c);

/* Index of an entry that the pattern has. */
static inline int lw_columns_find(const lw_columns *c, int row, int column)
{
    return c->at[column] + lw_place_in(c->at[column + 1] - c->at[column], c->row + c->at[column], row);
}

typedef struct lw_sparse_lu lw_sparse_lu;

/* The pattern must outlive it.  saddle: many diagonals are 0, so pivots are taken beside the diagonal, and columns are ordered for
 * any pivots; else for those of the diagonal, with less fill.  is_complex: entries and right-hand sides are pairs (real, imaginary).
 * NULL: out of memory. */
lw_sparse_lu *lw_sparse_lu_create(const lw_columns *pattern, bool saddle, bool is_complex);
void lw_sparse_lu_free(lw_sparse_lu *f);

/* value: of the entries.  LW_OPEN: singular; LW_E_MEMORY. */
lw_status lw_sparse_lu_factor(lw_sparse_lu *f, const double *value);

/* Solve A x = b in place, after a successful _factor. */
void lw_sparse_lu_solve(lw_sparse_lu *f, double *b);

#endif
