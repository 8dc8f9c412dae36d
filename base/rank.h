/* base/rank.h - linear systems whose matrix may be rank deficient: complete orthogonal decomposition.
 *
 *     A P = Q [T 0; 0 0] Z      Q, Z orthogonal, P a permutation, T upper triangular, rank x rank
 *
 * Householder QR with column pivoting, the columns beyond the rank are folded into T from the right (Golub & Van
 * Loan 2013, sections 5.4.2, 5.4.7).  One factorisation solves A x = b and A^T x = b, each in the least
 * squares sense; of all such x it gives the one of least norm.  The caller provides the memory. */
#ifndef LW_BASE_RANK_H
#define LW_BASE_RANK_H

#include <signal.h>
#include <stddef.h>

typedef struct lw_rank {
    int     m, n, rank;
    const volatile sig_atomic_t *stop;   /* the factorisation ends when it is not 0, and is of no use then; may be NULL */
    int     most;                /* known upper bound of the rank; 0: none                              */
    double  weakest;             /* |last kept diagonal| / |first|: distance from lower rank; 0: rank 0  */
    double *a;                   /* (m*n) reflectors and triangle, by columns                           */
    double *left, *right;        /* (min(m, n)) factors of the reflectors                               */
    int    *column;              /* (n) column[k] of A is in position k; the first `rank` are a basis    */
    double *work;                /* (m + n)                                                             */
} lw_rank;

/* Number of doubles and ints needed; lw_rank_place divides them among the fields of r. */
size_t lw_rank_doubles(int m, int n);
size_t lw_rank_ints(int m, int n);
void   lw_rank_place(lw_rank *r, int m, int n, double *doubles, int *ints);

/* Factor the matrix in r->a (by columns, a[i + m*j]).  Diagonals below `least` times the largest count as 0.
 * A matrix with NaN has rank 0. */
void lw_rank_factor(lw_rank *r, double least);

/* x (n) of A x = b (m);  b is overwritten by Q^T b. */
void lw_rank_solve(const lw_rank *r, double *b, double *x);

/* x (m) of A^T x = b (n). */
void lw_rank_solve_transposed(const lw_rank *r, const double *b, double *x);

/* x (m): vector k, from 0, of an orthonormal basis of the null space of A^T; k < m - rank. */
void lw_rank_left_null(const lw_rank *r, int k, double *x);

/* Project x (n) onto the null space of A. */
void lw_rank_null_part(const lw_rank *r, double *x);

#endif
