/* mbs/kinematics/output_limits.h - inputs where a link at the ground stands still: the ends of its swing or stroke.
 * They are the dead points of the linkage when that link drives it. */
#ifndef LW_MBS_KINEMATICS_OUTPUT_LIMITS_H
#define LW_MBS_KINEMATICS_OUTPUT_LIMITS_H

#include "mbs/plan/plan.h"

typedef struct lw_output_limits {
    int    link, joint;           /* the link and its ground joint                                  */
    double input;                 /* [rad] or [m]                                                  */
} lw_output_limits;

/* Find all limits for inputs strictly between first and last in one assembly mode, link by link, by rising input.  The
 * plan is made from `linkage` with all_joints.  Returns their number, at most `max`.  The speed is sampled at 256
 * inputs and its sign changes are exact to rounding.  Two limits between neighbouring samples are found by the sign of
 * the acceleration; four are not. */
int lw_output_limits_find(const lw_plan *plan, const lw_linkage *linkage, const double *dim, const double *mode,
                          double first, double last, lw_output_limits *out, int max);

#endif
