/* base/sparse.h - sparse square systems with tens to hundreds of unknowns.  Matrices are stored with their zeros, but the
 * computation skips them.
 *
 * P A Q = L U with partial pivoting.  The elimination order of the columns is chosen once for low fill, from the pattern of
 * A^T A, which bounds the fill for any choice of pivot rows (Gilbert & Ng 1993).  The caller provides the memory. */
#ifndef LW_BASE_SPARSE_H
#define LW_BASE_SPARSE_H

#include <stdbool.h>
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

/* ---- symmetric positive definite matrices of any size ----
 *
 * S = U^T U, stored and computed without zeros.  Equations are eliminated in an order of low fill (minimum degree, the first
 * of those with equal degree).  The work of a factorisation is written down as a list of multiplications when the pattern
 * is analysed, so that factoring searches nothing: linear in the number of unknowns for chains and for trees of loops. */
typedef struct lw_cholesky_run { int to, n; } lw_cholesky_run;      /* products that go to n neighbouring entries, the first one `to` */

typedef struct lw_cholesky {
    int     n, n_entry;          /* unknowns; entries right of the diagonal                               */
    int    *order;               /* (n) order[k] is eliminated k-th                                       */
    int    *at, *list;           /* (n + 1), (n_entry) columns right of the diagonal of row k, ascending  */
    lw_cholesky_run *run;        /* where the products go, in the order of elimination                    */
    double *value;               /* (n_entry + n) entries of the rows, then the diagonal                  */
    double *diag;                /* (n) the diagonal, then 1/pivot                                        */
} lw_cholesky;

/* Analyse the pattern: unknown i meets near[near_at[i] .. near_at[i + 1] - 1], and they meet i.  false: out of memory;
 * then *c is empty. */
bool lw_cholesky_make(lw_cholesky *c, int n, const int *near_at, const int *near);
void lw_cholesky_free(lw_cholesky *c);

/* Index in c->value of the entry of row i and column j in the order of elimination, i <= j. */
int lw_cholesky_entry(const lw_cholesky *c, int i, int j);

/* Factor the matrix in c->value.  Returns the least pivot over its diagonal: how near to singular.  dependent (n), or
 * NULL: set for equations whose pivot is below `tolerance` times the diagonal; they are left out, and the least pivot is
 * of the others.  With NULL the computation ends at a pivot that is not positive and returns 0. */
double lw_cholesky_factor(lw_cholesky *c, double tolerance, bool *dependent);

/* Solve S x = b in place, both in the order of elimination. */
void lw_cholesky_solve(const lw_cholesky *c, double *b);

/* The same but for rounding, up to twice as fast: sums begin with the unknowns that are known longest, so the processor works at
 * several rows at once instead of waiting for the last unknown. */
void lw_cholesky_solve_overlapped(const lw_cholesky *c, double *b);

/* The same for four right-hand sides, b[k] those of equation k, in little more time than for one. */
void lw_cholesky_solve_four(const lw_cholesky *c, double (*b)[4]);

/* The same factor of S = A^T A from the rows of A, by Householder's reflections of the rows that meet at each column (George & Liu
 * 1987; Liu 1986): pivots and solutions have the digits of A, where forming S loses twice as many. */
typedef struct lw_row_fronts {
    int     n_row;
    int    *at, *column;         /* (n_row + 1), entries of each row: columns in the order of elimination     */
    int    *first, *row;         /* (n + 1), (n_row) rows by their first column                               */
    int    *child, *sibling;     /* (n) fronts that pass rows on to a front; -1: none                         */
    int    *height, *place;      /* (n) rows passed on; place of a column in a front                          */
    size_t *to;                  /* (n) where in pass                                                         */
    double *pass, *front, *size; /* rows passed on; the front at hand; (n) squares of the columns' norms      */
} lw_row_fronts;

/* Rows of A by their entries: those of row i are at[i] .. at[i + 1] - 1, in columns column[] of c, which are given as places in
 * the order of elimination; each row's columns meet in c.  Takes copies.  false: out of memory; then *f is empty. */
bool lw_row_fronts_make(lw_row_fronts *f, const lw_cholesky *c, int n_row, const int *at, const int *column);
void lw_row_fronts_free(lw_row_fronts *f);

/* As lw_cholesky_factor, of A with these entries. */
double lw_row_fronts_factor(lw_row_fronts *f, lw_cholesky *c, const double *entry, double tolerance, bool *dependent);

#endif
