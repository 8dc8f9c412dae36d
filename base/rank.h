/* base/rank.h - systems whose matrix may lack rank: complete orthogonal decomposition.
 *
 *     A P = Q [T 0; 0 0] Z      Q, Z orthogonal, P a permutation, T upper triangular, rank x rank
 *
 * Householder QR with column pivoting, columns beyond the rank folded into T from the right (Golub & Van
 * Loan 2013, sections 5.4.2, 5.4.7).  One factorisation solves A x = b and A^T x = b, each in the least
 * squares sense and, of all such x, by the one of least norm.  Memory is the caller's. */
#ifndef LW_BASE_RANK_H
#define LW_BASE_RANK_H

#include <stddef.h>

typedef struct lw_rank {
    int     m, n, rank;
    int     most;                /* rank that is known not to be exceeded; 0: none is                   */
    double  weakest;             /* |last kept diagonal| / |first|: how near to less rank; 0: no rank    */
    double *a;                   /* (m*n) reflectors and triangle, by columns                           */
    double *left, *right;        /* (min(m, n)) factors of the reflectors                               */
    int    *column;              /* (n) column[k] of A stands at place k: the first `rank` are a basis   */
    double *work;                /* (m + n)                                                             */
} lw_rank;

/* Doubles and ints of memory; lw_rank_place lays r out in them. */
size_t lw_rank_doubles(int m, int n);
size_t lw_rank_ints(int m, int n);
void   lw_rank_place(lw_rank *r, int m, int n, double *doubles, int *ints);

/* Factor what r->a holds (A by columns, a[i + m*j]).  Diagonals below `least` times the greatest count as 0.
 * A matrix with NaN has rank 0. */
void lw_rank_factor(lw_rank *r, double least);

/* x (n) of A x = b (m);  b is overwritten by Q^T b. */
void lw_rank_solve(const lw_rank *r, double *b, double *x);

/* x (m) of A^T x = b (n). */
void lw_rank_solve_transposed(const lw_rank *r, const double *b, double *x);

/* x (m): vector k, from 0, of an orthonormal basis of the null space of A^T; k < m - rank. */
void lw_rank_left_null(const lw_rank *r, int k, double *x);

/* x (n) less its part in the row space of A: what is left is in the null space. */
void lw_rank_null_part(const lw_rank *r, double *x);

#endif
