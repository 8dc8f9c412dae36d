/* optimise/solvers/qp.h - small dense quadratic programs, for the step of a bounded least-squares fit.
 * Dual active set method of Goldfarb & Idnani 1983. */
#ifndef LW_OPTIMISE_SOLVERS_QP_H
#define LW_OPTIMISE_SOLVERS_QP_H

#include <stdbool.h>

#define LW_QP_MAX 48      /* unknowns */

/* Lower triangle of h (n x n, row by row, only its lower triangle is read) becomes its Cholesky
 * factor; false, h spoilt, when h is not positive definite to rounding. */
bool lw_qp_cholesky(int n, double *h);

/* p minimises  1/2 p'Hp + g'p  subject to  a[j*n ..] . p >= b[j],  j < m;  l is the factor of H.
 * false when the conditions contradict each other (p is then unspecified). */
bool lw_qp_solve(int n, const double *l, const double *g, int m, const double *a, const double *b,
                 double *p);

#endif
