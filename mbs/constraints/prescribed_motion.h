/* mbs/constraints/prescribed_motion.h - a linkage whose inputs, one or several, are given as functions of time.
 *
 * Every step is so short that the posture provably stays on its branch, for any path of the inputs within their change
 * over the step (mbs/constraints/continuation_internal.h).  Whether several inputs stay within that change is checked at a
 * dozen times inside the step.  The posture of a linkage with one input follows the value of the input, which may rest or turn back
 * anywhere, in a branch point too; where it turns back is looked for at a dozen times in each tenth of a radian.  Near a branch point
 * that several inputs do not simply cross, the posture is still a smooth function of their values.  There postures and rates follow from the
 * Taylor series about a regular posture nearby, if its last terms are negligible. */
#ifndef LW_MBS_CONSTRAINTS_PRESCRIBED_MOTION_H
#define LW_MBS_CONSTRAINTS_PRESCRIBED_MOTION_H

#include "mbs/constraints/system.h"

/* Inputs at time t [s]: u[i*(order + 1) + k], coefficient k (derivative divided by k!) of input i, [rad] or [m] as in
 * lw_input.  order <= LW_SERIES_ORDER_MAX. */
typedef void lw_input_function(void *context, double t, int order, double *u);

/* The motions of a model (grammar/model/model.h), which is the context.  Inputs without a motion rest. */
lw_input_function lw_prescribed_motion_of_model;

/* The first input of a model, which is the context, is t itself; the others rest. */
lw_input_function lw_prescribed_motion_first_alone;

typedef struct lw_prescribed_motion lw_prescribed_motion;

/* Move the inputs straight from posture q (NULL: the drawn one), which is at or near the drawn values of the inputs, to their
 * values at time t.  s must outlive the object.  LW_E_ARG:
 * fewer or more inputs than degrees of freedom; LW_E_NUMERIC: the posture is a dead point of the inputs, or a motion
 * is not a number; LW_OPEN: the linkage cannot reach the start of the motion. */
lw_status lw_prescribed_motion_create(const lw_system *s, const double *q, lw_input_function *motion, void *context,
                                      double t, lw_prescribed_motion **out, lw_error *e);
void      lw_prescribed_motion_free(lw_prescribed_motion *d);

/* Move to time t, later or earlier.  LW_OPEN: the inputs lead beyond a limit (a dead point of the inputs); then
 * lw_prescribed_motion_time is the time of the limit, to 1e-10 of the duration of the motion.  LW_E_NUMERIC: the
 * branch was lost, or a motion jumps or is not a number, or the linkage has more equations than coordinates and cannot follow its inputs
 * together; where this holds from the start, the start fails, too.  After a failure the posture is the last good one. */
lw_status lw_prescribed_motion_to(lw_prescribed_motion *d, double t);

/* Write to e where and why the motion ended, with s, the result of lw_prescribed_motion_to, and return s.  names: the linkage, for the
 * names of its joints. */
lw_status lw_prescribed_motion_ended(const lw_prescribed_motion *d, lw_status s, const lw_assembly *names, lw_error *e);

/* One input: its postures along its value, from which those in time follow; they may be asked for any value, and d keeps its own
 * posture and time.  d owns them.  NULL unless there is one input. */
lw_prescribed_motion *lw_prescribed_motion_by_value(lw_prescribed_motion *d);

double        lw_prescribed_motion_time(const lw_prescribed_motion *d);
const double *lw_prescribed_motion_posture(const lw_prescribed_motion *d);   /* coordinates (n_q) */

/* Coefficients q[k*n_q + i], k = 0 .. order, of the motion with respect to time; false at a dead point.  At a branch
 * point they are those of the motion straight on, the third accurate to 1e-6.  Just before a branch point digits are
 * lost until the step across it is known. */
bool          lw_prescribed_motion_rates(lw_prescribed_motion *d, int order, double *q);

/* The same while the inputs move by other series u, as lw_input_function gives them, from their present values. */
bool          lw_prescribed_motion_along(lw_prescribed_motion *d, int order, const double *u, double *q);

/* Several inputs, near a singular posture, after rates or `along`: the values of the inputs (n_input) in the regular posture used; NULL: none. */
const double *lw_prescribed_motion_regular(const lw_prescribed_motion *d);

/* The posture q for values u of the inputs around these.  false: it is not found, or it is singular. */
bool          lw_prescribed_motion_near(lw_prescribed_motion *d, const double *u, double *q);

/* At most LW_LINK_MAX links: does the motion pass a parallel singularity, where links can move while the inputs stand still?
 * between: the times before and after the first one; with one input its time is known, and both are that.  how (empty with one input): what moves
 * there, the link of the first tracer unless another one moves ten times as much,
 * `link "b" turns about (0.3, -0.1) m`, rounded to hundredths of the size of the linkage; names: the linkage.  false: it does not, or it is not known. */
#define LW_PRESCRIBED_MOTION_TEXT 240
bool          lw_prescribed_motion_lost(lw_prescribed_motion *d, const lw_assembly *names, double between[2], char how[LW_PRESCRIBED_MOTION_TEXT]);

/* Number of branch points passed, and the time of the last one (to 1e-10). */
int           lw_prescribed_motion_crossings(const lw_prescribed_motion *d, double *last);

#endif
