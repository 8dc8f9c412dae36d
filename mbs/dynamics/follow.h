/* mbs/dynamics/follow.h - postures of a planar model of any size whose inputs leave no freedom, along given motions of its
 * inputs; with sparse rows, so that a step costs as much as the model has joints.
 *
 * A step leads from knot to knot by the Taylor series of order 8 of all coordinates; its length follows from the last
 * coefficients.  It is taken if the joints close there within `agrees` of the series and the velocities agree too: another
 * branch of postures would have to lie that near.  Between knots a posture is closed from the series of the nearer knot; in a
 * singular posture it is interpolated from both knots (Hermite).  Nothing proves that no step jumps, unlike
 * mbs/constraints/prescribed_motion.h, which follows linkages of up to 32 links. */
#ifndef LW_MBS_DYNAMICS_FOLLOW_H
#define LW_MBS_DYNAMICS_FOLLOW_H

#include "mbs/constraints/prescribed_motion.h"
#include "mbs/dynamics/dynamics.h"

#define LW_FOLLOW_ORDER 3                /* of the series given out */

typedef struct lw_follow lw_follow;

/* mbs/formulations/follow_model.h makes it. */
void lw_follow_free(lw_follow *f);

/* Go to t, later or earlier.  LW_OPEN: the model cannot go beyond a limit of its inputs, found to about 1e-7, at
 * lw_follow_time; LW_E_NUMERIC: the motion is not a number or jumps; LW_STOPPED.  After a failure the posture is the last
 * good one. */
lw_status lw_follow_to(lw_follow *f, double t, lw_error *e);

/* Did the motion cross a singular posture, where links can move while the inputs stand still?  between: both the first time. */
bool          lw_follow_lost(const lw_follow *f, double between[2]);

double        lw_follow_time(const lw_follow *f);
/* Coefficients q[k*n_q + i] of the coordinates by t, k = 0 .. LW_FOLLOW_ORDER, where f is. */
const double *lw_follow_series(const lw_follow *f);
const lw_system *lw_follow_system(const lw_follow *f);

#endif
