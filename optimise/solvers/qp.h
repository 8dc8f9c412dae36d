/* optimise/solvers/qp.h - small dense quadratic programs, for the step of a bounded least-squares fit. Dual active set
 * method of Goldfarb & Idnani 1983. */
#ifndef LW_OPTIMISE_SOLVERS_QP_H
#define LW_OPTIMISE_SOLVERS_QP_H

#include <stdbool.h>

#define LW_QP_MAX 72      /* unknowns: all variables of a problem */

/* Replace the lower triangle of h (n x n by rows; the rest is not read) by its Cholesky factor. False, h overwritten: h
 * is not positive definite to rounding. */
bool lw_qp_cholesky(int n, double *h);

/* Find the p that minimises 1/2 p'Hp + g'p subject to a[j*n ..] . p >= b[j], j < m; l is the factor of H. work: 2*n*n
 * doubles. False: the conditions contradict each other (p is then unspecified). */
bool lw_qp_solve(int n, const double *l, const double *g, int m, const double *a, const double *b, double *work,
                 double *p);

#endif
