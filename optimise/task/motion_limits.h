/* optimise/task/motion_limits.h - a motion as the conditions of a task see it, whoever found the linkage. */
#ifndef LW_OPTIMISE_TASK_MOTION_LIMITS_H
#define LW_OPTIMISE_TASK_MOTION_LIMITS_H

#include "mbs/batch/posture.h"
#include "optimise/task/specification.h"

/* The extremes of a motion over the postures looked at so far. */
typedef struct lw_motion_limits {
    double margin_least, margin_most;   /* of mbs/batch/batch.h [1]; NaN: no posture was added yet         */
    double acceleration;                /* greatest, by the input: of the point [m/rad^2]; for a function that
                                         * of the output angle [rad/rad^2]                          */
    double intrusion;                   /* greatest depth of a pin or point in a forbidden zone [m]; < 0: least distance */
    bool   no_memory;                   /* some posture could not be computed for lack of memory           */
} lw_motion_limits;

lw_motion_limits lw_motion_limits_begin(void);

/* Add one posture, solved to order 2. */
void lw_motion_limits_posture(const lw_plan *plan, const lw_fit_spec *s, const lw_posture *posture, lw_motion_limits *w);

/* Add the postures at `steps` + 1 equal steps from one input to another in one assembly mode.  Postures that do not
 * close are skipped. */
void lw_motion_limits_run(const lw_plan *plan, const lw_fit_spec *s, const double *dim, const double *modes,
                          double from, double to, int steps, lw_motion_limits *w);

/* Greatest distance of a fixed pivot from where it has to be [m]; < 0: each is so far inside; -INFINITY: it may be anywhere. */
double lw_pivots_astray(const lw_fit_spec *s, const lw_linkage *linkage);

/* Does the motion meet the conditions, and do the fixed pivots of the linkage lie where they have to?  Tolerances are a
 * thousandth: of the target's size, of the acceleration, of the sine of the transmission angle.  why (may be NULL)
 * tells which condition is not met. */
bool lw_motion_limits_meets(const lw_motion_limits *w, const lw_fit_spec *s, const lw_linkage *linkage,
                            double size, char *why, size_t why_size);

#endif
