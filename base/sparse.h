/* base/sparse.h - square systems with few entries in a row, of a size (tens to hundreds) where they may be stored with
 * all their zeros but not multiplied by them.
 *
 * P A Q = L U with partial pivoting; the columns are eliminated in an order that fills little, found once from the
 * pattern of A^T A (Gilbert & Ng 1993: it bounds the fill whatever rows are chosen).  Memory is the caller's. */
#ifndef LW_BASE_SPARSE_H
#define LW_BASE_SPARSE_H

#include <stddef.h>

/* Order of elimination of a symmetric pattern near[i*n + j] != 0 (its diagonal does not count): always one that meets
 * fewest of those left (Tinney & Walker 1967, scheme 2).  order[k]: eliminated k-th.  near is filled in: afterwards those
 * later in the order that i meets are row i of U. */
void lw_sparse_order(int n, unsigned char *near, int *order);

typedef struct lw_sparse {
    int     n;
    double *a, *work;            /* (n*n) factors by columns; (n)                                        */
    int    *order, *row;         /* (n) columns as eliminated; row of A at each place                     */
    int    *at, *list;           /* (2 n + 1), (n*n) below, then above the diagonal of each column        */
} lw_sparse;

size_t lw_sparse_doubles(int n);
size_t lw_sparse_ints(int n);
void   lw_sparse_place(lw_sparse *f, int n, double *doubles, int *ints);

/* The order for matrices like a (n*n, a[i + n*j]); f->list serves as memory. */
void lw_sparse_prepare(lw_sparse *f, const double *a);

/* 0, or 1 + the column in which no pivot was left. */
int lw_sparse_factor(lw_sparse *f, const double *a);

/* x of A x = b; may be the same. */
void lw_sparse_solve(const lw_sparse *f, const double *b, double *x);

#endif
