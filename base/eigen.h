/* base/eigen.h - eigenvalues, by GSL; those of tridiagonal matrices, for which GSL has no function of its own, by our QL method. */
#ifndef LW_BASE_EIGEN_H
#define LW_BASE_EIGEN_H

#include "base/status.h"

/* K x = w M x for symmetric K (n*n) and symmetric positive definite M (NULL: 1), by rows.  w (n) rising; x[k*n + i] is
 * component i of vector k.  K, M are overwritten.  LW_E_NUMERIC: M is not positive definite; LW_E_ARG:
 * a coefficient is not finite, here and below. */
lw_status lw_eigen_symmetric(int n, double *k, double *m, double *w, double *x);

/* Eigenvalues of a symmetric tridiagonal matrix into diagonal (n), in no order, by the QL method (Wilkinson & Reinsch 1971, II/3).  beside
 * (n): the n - 1 numbers next to the diagonal; overwritten.  x[k*rows + i] (n*rows) becomes component i of vector k for rows of the unit
 * matrix on entry; all rows or some. */
lw_status lw_eigen_tridiagonal(int n, double *diagonal, double *beside, int rows, double *x);

/* A x = s x for any A (n*n), overwritten.  re, im (n); x_re, x_im[k*n + i] are component i of vector k. */
lw_status lw_eigen_general(int n, double *a, double *re, double *im, double *x_re, double *x_im);

#endif
