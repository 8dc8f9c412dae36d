/* mbs/constraints/prescribed_motion.h - a linkage whose inputs, one or several, are given as functions of time.
 *
 * Every step is so short that the posture provably stays on its branch whatever way the inputs take within their
 * change (mbs/constraints/continuation_internal.h); that the inputs do not leave this change between two ends of a step is looked at
 * a dozen places in between. */
#ifndef LW_MBS_CONSTRAINTS_PRESCRIBED_MOTION_H
#define LW_MBS_CONSTRAINTS_PRESCRIBED_MOTION_H

#include "mbs/constraints/system.h"

/* Inputs at time t [s]: u[i*(order + 1) + k], coefficient k (derivative over k!) of input i, [rad] or [m] as lw_input
 * counts.  order <= LW_SERIES_ORDER_MAX. */
typedef void lw_input_function(void *context, double t, int order, double *u);

/* That of a model (grammar/model.h), the context: inputs without a motion rest where they are drawn. */
lw_input_function lw_prescribed_motion_of_model;

typedef struct lw_prescribed_motion lw_prescribed_motion;

/* From the drawn posture the inputs are first taken straight to where they are at time t; s must outlive it.
 * LW_E_ARG: fewer or more inputs than freedoms; LW_E_NUMERIC: a posture that is a dead point of the inputs, or
 * motions that are no number; LW_OPEN: the linkage cannot get to where the motion begins. */
lw_status lw_prescribed_motion_create(const lw_system *s, lw_input_function *motion, void *context, double t, lw_prescribed_motion **out,
                          lw_error *e);
void      lw_prescribed_motion_free(lw_prescribed_motion *d);

/* On to time t, later or earlier.  LW_OPEN: the inputs lead beyond a limit (a dead point of theirs), whose time is
 * lw_prescribed_motion_time then, to 1e-10 of the time the motion takes; LW_E_NUMERIC: the branch was lost, or a motion jumps
 * or is no number.  The posture is the last good one. */
lw_status lw_prescribed_motion_to(lw_prescribed_motion *d, double t);

double        lw_prescribed_motion_time(const lw_prescribed_motion *d);
const double *lw_prescribed_motion_pose(const lw_prescribed_motion *d);           /* coordinates (n_q)                        */

/* Coefficients q[k*n_q + i], k = 0 .. order, of the motion by time; false at a dead point.  At branch points those of
 * the motion straight on, the third to 1e-6; just before them digits are lost as long as the way over is not known. */
bool          lw_prescribed_motion_rates(lw_prescribed_motion *d, int order, double *q);

/* Branch points passed straight on: their number and the time of the last one (to 1e-10). */
int           lw_prescribed_motion_crossings(const lw_prescribed_motion *d, double *last);

#endif
