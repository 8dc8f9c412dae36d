/* mbs/batch/posture.h - one full posture of a linkage: joints, links and tracers with their derivatives by the input
 * up to the third order.  The derivatives are exact (truncated Taylor arithmetic), not difference quotients. */
#ifndef LW_MBS_BATCH_POSTURE_H
#define LW_MBS_BATCH_POSTURE_H

#include "mbs/plan/plan.h"

typedef struct lw_posture {
    double  input;                                       /* [rad] or [m], ground frame            */
    double  margin;                                      /* as in mbs/batch/batch.h               */
    lw_vec2 joint [LW_JOINT_MAX ][LW_ORDER_MAX + 1];     /* in the plane [m], [m/rad], ...        */
    double  angle [LW_LINK_MAX  ][LW_ORDER_MAX + 1];     /* direction of each link's x axis [rad] */
    lw_vec2 tracer[LW_TRACER_MAX][LW_ORDER_MAX + 1];
} lw_posture;

/* Solve for the posture and its derivatives up to `order`.  LW_OPEN when the linkage cannot close at this input; the
 * positions are then those of the nearest posture and the derivatives are 0.  At a dead point (margin 0) derivatives do
 * not exist and are set to 0.  LW_E_MEMORY: only for plans with higher groups, which take 1 MB for the time of the
 * call. */
lw_status lw_posture_solve(const lw_plan *plan, const double *dim, const double *mode, double input, int order, lw_posture *posture);

/* Compute every register of the plan at this input, in the ground frame.  reg: (plan->n_reg).  LW_OPEN, LW_E_MEMORY:
 * as lw_posture_solve. */
lw_status lw_posture_registers(const lw_plan *plan, const double *dim, const double *mode, double input, lw_vec2 reg[LW_REG_MAX]);

/* The inverse of lw_plan_read: move `linkage`, of the topology of the plan, into the posture at `input` with these
 * dimensions.  The plan must have all_joints.  LW_OPEN when the linkage cannot close there; it is then unchanged.
 * Tracers without an output, tool angles and the points of slide lines move with their links.  The input's value
 * changes as much as the input. */
lw_status lw_plan_write(const lw_plan *plan, const double *dim, const double *mode, double input, lw_linkage *linkage);

/* Replace the seed in mode by the posture at this input, reached from the old seed.  LW_OPEN when it cannot be reached;
 * mode is then unchanged.  Plans without higher groups have no seed. */
lw_status lw_plan_seed(const lw_plan *plan, const double *dim, double input, double *mode);

#endif
