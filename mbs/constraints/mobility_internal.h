/* mbs/constraints/mobility_internal.h - moving a linkage blindly: steps off a posture and back to closure. */
#ifndef LW_MBS_CONSTRAINTS_MOBILITY_INTERNAL_H
#define LW_MBS_CONSTRAINTS_MOBILITY_INTERNAL_H

#include "base/rank.h"
#include "base/rng.h"
#include "mbs/constraints/mobility.h"

#define LW_RANK_ZERO 1e-6      /* below: rounding, or what a shaky part keeps of it */

typedef struct lw_drift {
    const lw_system *s;
    lw_rank  rank;             /* of what was factored last */
    double   tolerance;
    int     *columns;          /* for rank */
    double  *block;            /* of the arrays below */
    double  *factors, *phi, *jac, *step, *goal, *null, *start;
} lw_drift;

/* A posture and the motions from there: columns motion[i*n_q ..], i = 0 .. freedom - 1, square to each
 * other, of length 1. */
typedef struct lw_mobility_pose {
    int     rank, first_order, freedom;
    double *q, *motion;
} lw_mobility_pose;

lw_status lw_drift_create(const lw_system *s, double tolerance, lw_drift *d);
void      lw_drift_free(lw_drift *d);

/* Factor a (m x n, by rows; n <= n_q, m <= n_row + n_q + LW_DRIFT_EXTRA) into d->rank; returns the rank. */
#define LW_DRIFT_EXTRA (LW_INPUT_MAX + 2*LW_TRACER_MAX + 1)
int  lw_drift_factor(lw_drift *d, int m, int n, const double *a, double zero);

/* An orthonormal basis of the null space of what was factored last: null[i*n ..]. */
void lw_drift_null(const lw_drift *d, double *null);

/* Pivoted Gram-Schmidt: of k vectors v[i*n ..] those longer than `zero` beside the others come first, square
 * to each other and of length 1.  Returns how many. */
int  lw_drift_independent(int n, int k, double *v, double zero);

/* Rank and null space (d->null) of the rows at q; pivots below `zero` count as none. */
int lw_drift_rank(lw_drift *d, const double *q, double zero);

/* Bring q back to closure by the least way; with along (n_q) not NULL its share along that direction from
 * `from` is kept at `length`.  Returns the largest row left over, or infinity when it runs away. */
double lw_drift_settle(lw_drift *d, const double *from, const double *along, double length, double *q);

/* Walk from q in random directions that close; q is where it ends.  Returns the way, 0 when the first
 * step falls back; *residual: the largest row met. */
double lw_drift_walk(lw_drift *d, lw_rng *r, double *q, double *residual);

/* What moves at t->q, of first order and truly.  t->motion has room for n_q columns. */
void lw_drift_stand(lw_drift *d, bool moves, lw_mobility_pose *t);

#endif
