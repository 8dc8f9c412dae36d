/* base/linalg.h - Householder QR of small dense systems, for solves inside a loop.
 *
 * Own code, not a bridge to GSL: a 10 x 10 solve is most of an iteration of mbs/constraints/newton.c and takes
 * half of GSL's time (0.53 against 0.98 us).  It also gives the determinant, and a singular matrix is a normal answer
 * here, where GSL would call its global error handler, which aborts.  Use GSL for large systems.  Golub & Van Loan 2013, section 5.2. */
#ifndef LW_BASE_LINALG_H
#define LW_BASE_LINALG_H

/* Factor a = Q R in place.  a is m x n, m >= n >= 1, by columns without gaps: a[i + m*j].  After
 * the call the columns hold the reflectors on and below the diagonal and R above it; diag[n] holds
 * R's diagonal.  Returns min |R_jj| / max |R_jj|, a cheap estimate of the condition: 0 for a matrix
 * without full rank, NaN if a contains NaN. */
double lw_qr_factor(int m, int n, double *a, double *diag);

/* Least-squares solution x of A x = b from the factors (rank n).  b[m] is overwritten: its first n numbers are x, and the
 * norm of the others is the norm of the residual. */
void lw_qr_solve(int m, int n, const double *a, const double *diag, double *b);

/* The determinant of a square A from its factors. */
double lw_qr_determinant(int n, const double *diag);

#endif
