/* mbs/plan_internal.h - what the files of the plan share.  Not for users of the library. */
#ifndef LW_MBS_PLAN_INTERNAL_H
#define LW_MBS_PLAN_INTERNAL_H

#include "mbs/plan.h"

#define LW_ORIGIN_REG 0          /* origin of the ground frame */
#define LW_AXIS_REG   1          /* its x axis                 */

/* A dyad as found in the topology. base[]: the known links its outer joints hang on. */
typedef struct lw_group {
    lw_step_kind kind;
    int  link[2], joint[3], base[2];
    bool need[2];                /* is the frame of this link wanted */
} lw_group;

/* What was found out about a linkage before anything is numbered.  Pins are multiple joints: `pin` is the
 * first joint of the same pin, `on_pin` the links that carry it. */
typedef struct lw_topology {
    const lw_linkage *k;
    int      pin[LW_JOINT_MAX];
    uint32_t on_pin[LW_JOINT_MAX];
    int      driven, input_joint;
    int      rank[LW_LINK_MAX];           /* order in which links become known, -1: not yet */
    int      n_group;
    lw_group group[LW_DYAD_MAX];
} lw_topology;

/* Frames, dimensions, registers and steps of what is needed (mbs/plan_steps.c). */
lw_status lw_plan_emit(const lw_topology *t, lw_want want, lw_plan *plan, lw_error *e);

/* Is output o of the plan one of the commonest kind (mbs/plan_short.c)? */
lw_short lw_plan_shorten(const lw_plan *plan, int o);

/* Does link i carry a joint of this kind in the topology's linkage? */
static inline bool lw_joint_has(const lw_joint *j, int link)
{
    return j->link[0] == link || j->link[1] == link;
}
static inline int lw_joint_other(const lw_joint *j, int link)
{
    return j->link[0] == link ? j->link[1] : j->link[0];
}

/* The frames of the plan's links in the posture of k, in the plane (mbs/plan_read.c). */
typedef struct lw_frames { lw_vec2 o[LW_LINK_MAX], d[LW_LINK_MAX]; } lw_frames;
lw_status lw_plan_frames(const lw_plan *plan, const lw_linkage *k, lw_frames *f, lw_error *e);

/* Every register of the plan at one input, in the ground frame; returns the margin (mbs/pose.c). */
double lw_pose_registers(const lw_plan *plan, const double *dim, const double *mode, double input,
                         lw_vec2 reg[LW_REG_MAX]);

#endif
