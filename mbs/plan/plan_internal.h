/* mbs/plan/plan_internal.h - what the files of the plan share.  Not for users of the library. */
#ifndef LW_MBS_PLAN_PLAN_INTERNAL_H
#define LW_MBS_PLAN_PLAN_INTERNAL_H

#include "mbs/plan/plan.h"

#define LW_ORIGIN_REG 0          /* origin of the ground frame */
#define LW_AXIS_REG   1          /* its x axis                 */

/* A group as found in the topology.  Of a dyad: base[]: the known links its outer joints hang on.  Of a
 * higher group (LW_STEP_HIGHER) only `cluster` counts, its number.  Of a gear (see lw_plan_group_is_gear): link[0] the
 * wheel, pinion or rack, joint[0] its pin or slide on base[0], the carrier, joint[1] the gear, base[1] the known
 * partner; of two wheels the ratio of their speeds on the carrier. */
typedef struct lw_plan_group {
    lw_step_kind kind;
    int  link[2], joint[3], base[2];
    bool need[2];                /* is the frame of this link wanted */
    int  cluster;
    double ratio;
} lw_plan_group;

/* The joint `joint` between link a (of the group, or known) and link b of the group. */
typedef struct lw_tie { int a, b, joint; } lw_tie;

/* A higher group: its links in the order in which they are reached, each by its tie from an earlier one or a
 * known one; the pins that close loops; the links solved before that it hangs on. */
typedef struct lw_cluster {
    int      n_link, n_loop, n_gear;
    lw_tie   reach[LW_LINK_MAX];           /* b: the link                                           */
    lw_tie   loop[LW_JOINT_MAX];
    int      gear[LW_JOINT_MAX];           /* the gears that hold its links                         */
    uint32_t links, bases;
    bool     need;
} lw_cluster;

/* What was found out about a linkage before anything is numbered.  Pins are multiple joints: `pin` is the
 * first joint of the same pin, `on_pin` the links that carry it. */
typedef struct lw_topology {
    const lw_linkage *k;
    int      pin[LW_JOINT_MAX];
    uint32_t on_pin[LW_JOINT_MAX];
    int      driven, input_joint;
    int      rank[LW_LINK_MAX];           /* order in which links become known, -1: not yet */
    int      slot[LW_JOINT_MAX];          /* of a pin in a slot: the slider put behind it, else -1 */
    int      n_group, n_cluster, n_gear;
    lw_plan_group group[LW_DYAD_MAX + LW_HIGHER_MAX + LW_LINK_MAX];
    lw_gear  gear[LW_JOINT_MAX];          /* of gears: what they run on                    */
    bool     geared[LW_JOINT_MAX];        /* of gears: a link was found by it              */
    double   rate[LW_LINK_MAX];           /* turns a turn of the input, NaN: not even      */
    int      input_turns_per_period;      /* turns of the input until all gears are back   */
    lw_cluster cluster[LW_HIGHER_MAX];
} lw_topology;

/* A copy of the linkage with a die between pin and slot of every joint of kind p: the joint is the pin of
 * link[1] in the die, and the slide of the die on link[0] a further joint.  slot (n_joint of the copy) may be NULL. */
lw_status lw_plan_expand(const lw_linkage *k, lw_linkage *wide, int *slot, lw_error *e);

/* Find the smallest group that known links determine (mbs/plan/plan_assur.c). */
lw_status lw_plan_find_cluster(const lw_topology *t, lw_cluster *c, lw_error *e);

/* What every gear runs on; links that tied inputs turn; a wheel or rack that its gear makes known; the gears of a group
 * that was found, as turns of the input until it is back; is there a gear that holds nothing (mbs/plan/plan_gear.c)? */
lw_status lw_plan_start_gears(lw_topology *t, lw_error *e);
lw_status lw_plan_tie_inputs(lw_topology *t, int *known, lw_error *e);
lw_status lw_plan_find_gear(lw_topology *t, int *known, bool *found, lw_error *e);
lw_status lw_plan_gear_turns(lw_topology *t, const lw_cluster *c, lw_error *e);
lw_status lw_plan_check_gears(const lw_topology *t, lw_error *e);

/* The least q for which q times a ratio is a whole number p that a plan can take; false: there is none. */
bool lw_plan_fraction(double ratio, int *p, int *q);

static inline bool lw_plan_group_is_gear(const lw_plan_group *g)
{
    return g->kind == LW_STEP_GEAR || g->kind == LW_STEP_ROLL || g->kind == LW_STEP_RACK;
}

/* The names of the links not known, "A", "B". */
void lw_plan_list_unknown(const lw_topology *t, char *list, size_t size);

/* The link that has been known longest of those that carry this joint, -1 when none is. */
int lw_known_link(const lw_topology *t, int joint);

/* Frames, dimensions, registers and steps of what is needed (mbs/plan/plan_steps.c). */
lw_status lw_plan_emit(const lw_topology *t, lw_plan_options options, lw_plan *plan, lw_error *e);

/* Is output o of the plan one of the commonest kind (mbs/plan/fast_dyad.c)? */
lw_fast_dyad lw_plan_find_fast_dyad(const lw_plan *plan, int o);

static inline bool lw_same_place(lw_vec2 a, lw_vec2 b) { return a.x == b.x && a.y == b.y; }
static inline bool lw_plan_is_pin(const lw_topology *t, int joint)
{
    return t->k->joint[joint].kind == LW_JOINT_REVOLUTE;
}

static inline bool lw_joint_has(const lw_joint *j, int link)
{
    return j->link[0] == link || j->link[1] == link;
}
static inline int lw_joint_other(const lw_joint *j, int link)
{
    return j->link[0] == link ? j->link[1] : j->link[0];
}

/* The frames of the plan's links in the posture of a linkage, in the plane; the direction of a slide line there; the
 * plan's input [rad] or [m] (mbs/plan/plan_read.c).  LW_E_ARG when the linkage has another topology. */
typedef struct lw_frames { lw_vec2 o[LW_LINK_MAX], d[LW_LINK_MAX]; } lw_frames;
lw_status lw_plan_frames(const lw_plan *p, const lw_linkage *k, lw_frames *f, lw_error *e);
lw_vec2 lw_plan_slide_direction(const lw_plan *p, const lw_linkage *k, int j);
double lw_plan_read_input(const lw_plan *p, const lw_linkage *k, const lw_frames *f);

#endif
