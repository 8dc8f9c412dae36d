/* mbs/constraints/mobility_internal.h - random walks on the set of postures: steps away from a posture and back to
 * closure. */
#ifndef LW_MBS_CONSTRAINTS_MOBILITY_INTERNAL_H
#define LW_MBS_CONSTRAINTS_MOBILITY_INTERNAL_H

#include "base/rank.h"
#include "base/rng.h"
#include "mbs/constraints/mobility.h"

#define LW_RANK_ZERO 1e-6      /* smaller pivots are rounding errors, or remains of a shaky part */

typedef struct lw_drift {
    const lw_system *s;
    lw_rank  rank;             /* of the last factorisation */
    double   tolerance;
    int     *columns;          /* for rank */
    double  *block;            /* of the arrays below */
    double  *factors, *phi, *jac, *step, *goal, *null, *start;
} lw_drift;

/* A posture and its motions: orthonormal columns motion[i*n_q ..], i = 0 .. freedom - 1. */
typedef struct lw_mobility_posture {
    int     rank, first_order, freedom;
    double *q, *motion;
} lw_mobility_posture;

lw_status lw_drift_create(const lw_system *s, double tolerance, lw_drift *d);
void      lw_drift_free(lw_drift *d);

/* Factor a (m x n, by rows; n <= n_q, m <= n_row + n_q + LW_DRIFT_EXTRA) into d->rank; returns the rank. */
#define LW_DRIFT_EXTRA (LW_INPUT_MAX + 2*LW_TRACER_MAX + 1)
int  lw_drift_factor(lw_drift *d, int m, int n, const double *a, double zero);

/* An orthonormal basis of the null space of the matrix factored last: null[i*n ..]. */
void lw_drift_null(const lw_drift *d, double *null);

/* Rank and null space (d->null) of the rows at q; pivots below `zero` count as 0. */
int lw_drift_rank(lw_drift *d, const double *q, double zero);

/* Bring q back to closure by least-norm steps.  If along (n_q) is not NULL, the component of q - from in that
 * direction is kept at `length`.  Returns the largest residual, or infinity if the iteration diverges. */
double lw_drift_settle(lw_drift *d, const double *from, const double *along, double length, double *q);

/* Walk from q in random directions that close; q receives the end.  Returns the distance, 0 if the first step falls
 * back. *residual: largest residual on the way. */
double lw_drift_walk(lw_drift *d, lw_rng *r, double *q, double *residual);

/* Find the motions at t->q, those of first order and the true ones.  t->motion has room for n_q columns. */
void lw_drift_stand(lw_drift *d, bool moves, lw_mobility_posture *t);

#endif
