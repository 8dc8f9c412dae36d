/* mbs/kinematics/output_limits.h - where a link at the ground stands still while the input moves: the ends of its
 * swing or stroke, and the dead points of the linkage when that link is the driver. */
#ifndef LW_MBS_KINEMATICS_OUTPUT_LIMITS_H
#define LW_MBS_KINEMATICS_OUTPUT_LIMITS_H

#include "mbs/plan/plan.h"

typedef struct lw_output_limits {
    int    link, joint;           /* the link, and the ground joint it moves in                    */
    double input;                 /* [rad] or [m]                                                  */
} lw_output_limits;

/* All turnings for inputs strictly inside first .. last in one assembly mode, link by link, rising;
 * plan made with all_joints from k.  Returns their number, at most `max`.  Speeds are sampled at 256
 * places and the sign changes polished to rounding; a pair of turnings between two samples is found
 * by the acceleration's sign, two pairs there are not. */
int lw_output_limits_find(const lw_plan *plan, const lw_linkage *k, const double *dim, const double *mode,
                    double first, double last, lw_output_limits *out, int max);

#endif
