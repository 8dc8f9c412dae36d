/* optimise/solvers/qp.h - small dense quadratic programs, for the step of a bounded least-squares fit. Dual active set
 * method of Goldfarb & Idnani 1983. */
#ifndef LW_OPTIMISE_SOLVERS_QP_H
#define LW_OPTIMISE_SOLVERS_QP_H

#include <stdbool.h>

#define LW_QP_MAX 72      /* unknowns: all variables of a problem */

/* Replace the lower triangle of h (n x n by rows; the rest is not read) by its Cholesky factor. False, h overwritten: h
 * is not positive definite to rounding. */
bool lw_qp_cholesky(int n, double *h);

/* The conditions a[j*n ..] . p >= b[j], j < m. */
typedef struct lw_qp_rows {
    int           m;
    const double *a, *b;
    int           n_listed;      /* the first so many rows ...                                       */
    const short  *first;         /* ... have the coefficients column[first[j]] .. column[first[j + 1] - 1] (n_listed + 1) */
    const short  *column;        /* and no others: bounds and ratios of two lengths are worked out faster */
} lw_qp_rows;

/* List the nonzero coefficients of m rows in first (m + 1) and column (m*n). */
void lw_qp_list(int n, int m, const double *a, short *first, short *column);

/* Find the p that minimises 1/2 p'Hp + g'p subject to these conditions (NULL: none); l is the factor of H. work: 2*n*n
 * doubles. False: the conditions contradict each other (p is then unspecified). */
bool lw_qp_solve(int n, const double *l, const double *g, const lw_qp_rows *rows, double *work, double *p);

#endif
