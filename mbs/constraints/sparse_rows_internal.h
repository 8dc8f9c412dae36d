/* mbs/constraints/sparse_rows_internal.h - least squares with the rows of a system of any size, without their zeros.
 *
 *     [ A ]       [ b ]       A: rows and driven inputs (m x n);  W: diagonal, (n) weights, 0 where a coordinate has none
 *     [ W ] x  =  [ 0 ]
 *
 * R of the QR factorisation comes from reflections of the rows (base/sparse.h); solutions follow from R^T R x = A^T b, corrected once
 * by their residual (Bjorck 1996, section 6.6.5).  A factorisation and a solution cost as much as the linkage has joints. */
#ifndef LW_MBS_CONSTRAINTS_SPARSE_ROWS_INTERNAL_H
#define LW_MBS_CONSTRAINTS_SPARSE_ROWS_INTERNAL_H

#include "base/sparse.h"
#include "mbs/constraints/system_internal.h"

typedef struct lw_sparse_rows {
    const lw_system *s;
    int     m, n, n_held;
    const int *held;                       /* (n_held) driven inputs                                   */
    int    *at, *column;                   /* entries of the rows of A, then one for each weight        */
    double *entry;                         /* of A; the last n are the weights, which the caller sets   */
    double *block;                         /* (n_row * LW_SYSTEM_ROW_SIZE) scratch                     */
    lw_row_bodies *body;
    double *x, *rest, *right;              /* scratch: (n), (m), (n)                                   */
    bool   *dependent;                     /* (n) coordinates that the last factorisation left out       */
    lw_cholesky   factor;
    lw_row_fronts fronts;
    int    *place;                         /* of a coordinate in the order of elimination               */
} lw_sparse_rows;

/* held must outlive r.  False: out of memory; then *r is empty. */
bool   lw_sparse_rows_create(const lw_system *s, const int *held, int n_held, lw_sparse_rows *r);
void   lw_sparse_rows_free(lw_sparse_rows *r);

static inline double *lw_sparse_rows_weights(lw_sparse_rows *r) { return r->entry + r->at[r->m]; }

/* A at the given frames of the bodies. */
void   lw_sparse_rows_fill(lw_sparse_rows *r, const lw_body_frame *f);

/* Factor A and W.  Columns whose pivot is below `least` times their norm are left out, and *left is their number; with left NULL the
 * result is 0 where a pivot is 0.  Returns min |R_jj| / max |R_jj| of the others, NaN if an entry is no number. */
double lw_sparse_rows_factor(lw_sparse_rows *r, double least, int *left);

/* The solution x (n) for b (m), with 0 for coordinates left out.  rough: without the correction, with half the digits at worst. */
void   lw_sparse_rows_solve(const lw_sparse_rows *r, const double *b, bool rough, double *x);

/* out (m) = A x */
void   lw_sparse_rows_times(const lw_sparse_rows *r, const double *x, double *out);

/* x (n): the vector with A x = 0 that is 1 in coordinate k, which has a weight or was left out, and 0 in others left out. */
void   lw_sparse_rows_null(const lw_sparse_rows *r, int k, double *x);

#endif
