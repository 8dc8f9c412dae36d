/* base/sparse.h - sparse square systems with tens to hundreds of unknowns.  Matrices are stored with their zeros, but the
 * computation skips them.
 *
 * P A Q = L U with partial pivoting.  The elimination order of the columns is chosen once for low fill, from the pattern of
 * A^T A, which bounds the fill for any choice of pivot rows (Gilbert & Ng 1993).  The caller provides the memory. */
#ifndef LW_BASE_SPARSE_H
#define LW_BASE_SPARSE_H

#include <stddef.h>

/* Elimination order for a symmetric pattern near[i*n + j] != 0 (the diagonal does not count): always eliminate the unknown
 * with the fewest remaining neighbours (Tinney & Walker 1967, scheme 2).  order[k] is eliminated k-th.  near receives the
 * fill: afterwards its entries that come later in the order than i are row i of U. */
void lw_sparse_order(int n, unsigned char *near, int *order);

typedef struct lw_sparse {
    int     n;
    double *a, *work;            /* (n*n) factors by columns; (n)                                        */
    int    *order, *row;         /* (n) columns in elimination order; row of A in each position           */
    int    *at, *list;           /* (2 n + 1), (n*n) entries below, then above the diagonal per column    */
} lw_sparse;

size_t lw_sparse_doubles(int n);
size_t lw_sparse_ints(int n);
void   lw_sparse_place(lw_sparse *f, int n, double *doubles, int *ints);

/* Choose the order for matrices with the pattern of a (n*n, a[i + n*j]).  Uses f->list as scratch memory. */
void lw_sparse_prepare(lw_sparse *f, const double *a);

/* Returns 0, or 1 + the column in which no pivot was left. */
int lw_sparse_factor(lw_sparse *f, const double *a);

/* Solve A x = b.  x and b may be the same array. */
void lw_sparse_solve(const lw_sparse *f, const double *b, double *x);

#endif
