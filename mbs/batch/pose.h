/* mbs/batch/pose.h - one pose of one linkage in full: joints, links, and their derivatives by the input up
 * to the third order.  Exact (truncated Taylor arithmetic through the plan), not differenced. */
#ifndef LW_MBS_BATCH_POSE_H
#define LW_MBS_BATCH_POSE_H

#include "mbs/plan/plan.h"

#define LW_ORDER_MAX 3        /* 0 position, 1 velocity, 2 acceleration, 3 jerk, by input         */

typedef struct lw_pose {
    double  input;                                       /* [rad] or [m], ground frame            */
    double  margin;                                      /* as in mbs/batch/batch.h               */
    lw_vec2 joint [LW_JOINT_MAX ][LW_ORDER_MAX + 1];     /* in the plane [m], [m/rad], ...        */
    double  angle [LW_LINK_MAX  ][LW_ORDER_MAX + 1];     /* direction of each link's x axis [rad] */
    lw_vec2 tracer[LW_TRACER_MAX][LW_ORDER_MAX + 1];
} lw_pose;

/* Solve for the pose and its derivatives up to `order`.  LW_OPEN when it cannot close at this input:
 * then positions are those of the nearest pose and derivatives are 0.  At a dead point (margin 0)
 * derivatives do not exist and are set to 0; margin tells. */
lw_status lw_pose_solve(const lw_plan *plan, const double *dim, const double *mode, double input,
                        int order, lw_pose *pose);

/* Every register of the plan at this input, in the ground frame; returns the margin.  reg: plan->n_reg. */
double lw_pose_registers(const lw_plan *plan, const double *dim, const double *mode, double input,
                         lw_vec2 reg[LW_REG_MAX]);

/* The opposite of lw_plan_read: put the posture at `input` with these dimensions into k, which brings the topology
 * and names.  Needs a plan with all_joints.  LW_OPEN when it cannot close there (k untouched).
 * Tracers without an output, tool angles and the places of slide lines go with their links; the
 * input's value moves by as much as the input. */
lw_status lw_plan_write(const lw_plan *plan, const double *dim, const double *mode, double input, lw_linkage *k);

/* Put a new seed into mode: the posture at this input, reached from the old seed.  LW_OPEN, mode untouched,
 * when it cannot be reached.  Nothing to do for plans without higher groups. */
lw_status lw_plan_seed(const lw_plan *plan, const double *dim, double input, double *mode);

#endif
