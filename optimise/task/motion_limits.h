/* optimise/task/motion_limits.h - a motion as the conditions of a task see it, whoever found the linkage. */
#ifndef LW_OPTIMISE_TASK_MOTION_LIMITS_H
#define LW_OPTIMISE_TASK_MOTION_LIMITS_H

#include "mbs/batch/pose.h"
#include "optimise/task/specification.h"

typedef struct lw_motion_limits {
    double margin_least, margin_most;   /* mbs/batch/batch.h [1]; NaN: no pose yet                        */
    double acceleration;                /* greatest, by the input: of the point [m/rad^2], of a function of the
                                         * output angle [rad/rad^2]                                 */
    double intrusion;                   /* the deepest that a pin or a point was in a forbidden zone [m]  */
} lw_motion_limits;

lw_motion_limits lw_motion_limits_begin(void);

/* One pose more, solved to order 2. */
void lw_motion_limits_pose(const lw_plan *plan, const lw_fit_spec *s, const lw_pose *pose, lw_motion_limits *w);

/* `looks` steps more from one input to another in one assembly; poses that do not close are passed over. */
void lw_motion_limits_run(const lw_plan *plan, const lw_fit_spec *s, const double *dim, const double *modes, double from,
                double to, int looks, lw_motion_limits *w);

/* Does it meet the conditions on the motion, and do the fixed pivots of k lie where they have to?  To a thousandth: of
 * the target's size, of the acceleration, of the sine of the transmission angle.  why: what is not met, may be NULL. */
bool lw_motion_limits_meets(const lw_motion_limits *w, const lw_fit_spec *s, const lw_linkage *k, double size, char *why, size_t room);

#endif
