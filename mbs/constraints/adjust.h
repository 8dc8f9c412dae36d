/* mbs/constraints/adjust.h - overconstrained linkages that move, drawn with rounded numbers.
 *
 * Three parallel bars, Burmester's focal linkage: such linkages move for special dimensions only.  Written with a few
 * digits they are rigid, by a hair.  The least change of the dimensions, in the sense of least squares, makes them move:
 * places of joints on their links and directions of slides, so that all rows can be satisfied in several postures along
 * the motion at once. */
#ifndef LW_MBS_CONSTRAINTS_ADJUST_H
#define LW_MBS_CONSTRAINTS_ADJUST_H

#include "mbs/constraints/system.h"

#define LW_ADJUST_MOST 2e-3              /* greatest change, scaled: more is another linkage */

/* A linkage whose dimensions can change. */
typedef struct lw_adjustable {
    void *context;
    int   n_place, n_q;          /* numbers of a posture; of a displacement of it                              */
    int   n_row, n_dim;
    int   postures;              /* in which the rows are satisfied at once, of each motion; even. Fewer where there are many motions */
    bool  doubles;               /* can the dimensions wanted be a double root, as of three parallel bars?     */
    void (*change)(void *context, const double *by);                             /* take the dimensions drawn, changed by these (n_dim) */
    void (*rows)(void *context, const double *place, double *phi, double *jac);  /* (n_row), (n_row x n_q), which may be NULL           */
    void (*move)(void *context, double *place, const double *by);                /* by a displacement (n_q)                             */
} lw_adjustable;

/* Adjust the dimensions at the posture place (n_place), which is put on the rows.  by: their changes (n_dim), scaled or [rad].
 * LW_NOTHING: there is nothing to adjust, dimensions and place are unchanged: no row nearly depends on others, or no motion is as near
 * as LW_ADJUST_MOST. */
lw_status lw_adjust(const lw_adjustable *a, double *place, double *by, lw_error *e);

/* Adjust the dimensions of s, a system of a linkage, at the posture q (n_q), which is put on the rows.  *by: greatest
 * change of a dimension, scaled or [rad].  LW_NOTHING as above. */
lw_status lw_system_adjust(lw_system *s, double *q, double *by, lw_error *e);

#endif
