/* mbs/plan/plan_internal.h - types and functions shared by the files of the plan.  Not for users of the library. */
#ifndef LW_MBS_PLAN_PLAN_INTERNAL_H
#define LW_MBS_PLAN_PLAN_INTERNAL_H

#include "mbs/plan/plan.h"

#define LW_ORIGIN_REG 0          /* origin of the ground frame */
#define LW_AXIS_REG   1          /* its x axis                 */

/* A group found in the topology.
 *     dyad           base[]: the known links at its outer joints
 *     higher group   (LW_STEP_HIGHER) cluster: its number; the rest is unused
 *     gear           (lw_plan_group_is_gear) link[0]: wheel, pinion or rack; joint[0]: its pin or slide on the carrier
 *                    base[0]; joint[1]: the gear; base[1]: the known partner; ratio: of two wheels' speeds */
typedef struct lw_plan_group {
    lw_step_kind kind;
    int  link[2], joint[3], base[2];
    bool need[2];                /* is the frame of this link needed? */
    int  cluster;
    double ratio;
} lw_plan_group;

/* A joint between link a (of the group or known) and link b of the group. */
typedef struct lw_tie { int a, b, joint; } lw_tie;

/* A higher group: its links in the order in which they are reached, each with its tie to an earlier or known link; the
 * pins that close loops; its gears; its links and the known links they are joined to, as sets. */
typedef struct lw_cluster {
    int      n_link, n_loop, n_gear;
    lw_tie   reach[LW_LINK_MAX];           /* b is the link that is reached                       */
    lw_tie   loop[LW_JOINT_MAX];
    int      gear[LW_JOINT_MAX];           /* the gears between its links                          */
    uint32_t links, bases;
    bool     need;
} lw_cluster;

/* The topology of a linkage.  Several joints may be one pin: `pin` is the first joint of the same pin, `on_pin` the
 * set of links that carry it. */
typedef struct lw_topology {
    const lw_linkage *k;
    int      pin[LW_JOINT_MAX];
    uint32_t on_pin[LW_JOINT_MAX];
    int      driven, input_joint;
    int      rank[LW_LINK_MAX];           /* order in which links become known, -1: not yet */
    int      slot[LW_JOINT_MAX];          /* the slider added for a pin in a slot, else -1 */
    int      n_group, n_cluster, n_gear;
    lw_plan_group group[LW_DYAD_MAX + LW_HIGHER_MAX + LW_LINK_MAX];
    lw_gear  gear[LW_JOINT_MAX];          /* carrier and slides of each gear                */
    bool     geared[LW_JOINT_MAX];        /* has the gear been used, for a link or a group? */
    double   rate[LW_LINK_MAX];           /* turns per turn of the input; NaN: not constant */
    int      input_turns_per_period;      /* turns of the input until all gears are back    */
    lw_cluster cluster[LW_HIGHER_MAX];
} lw_topology;

/* Copy the linkage with a die between pin and slot of every joint of kind p: the joint becomes the pin of link[1] in
 * the die, and a further joint is the slide of the die on link[0].  slot[j] is that further joint; slot may be NULL. */
lw_status lw_plan_expand(const lw_linkage *linkage, lw_linkage *wide, int *slot, lw_error *e);

/* Find the smallest group that known links determine (mbs/plan/plan_assur.c). */
lw_status lw_plan_find_cluster(const lw_topology *t, lw_cluster *c, lw_error *e);

/* Gears (mbs/plan/plan_gear.c).  known: number of links known so far.
 *     start_gears   find the carrier and slides of every gear
 *     tie_inputs    make the links of tied inputs known
 *     find_gear     make one wheel or rack known that a gear determines; *found: is there one
 *     gear_turns    multiply input_turns_per_period by the turns that the gears of a higher group need
 *     check_gears   LW_E_KIND when a gear joins links that are known without it */
lw_status lw_plan_start_gears(lw_topology *t, lw_error *e);
lw_status lw_plan_tie_inputs(lw_topology *t, int *known, lw_error *e);
lw_status lw_plan_find_gear(lw_topology *t, int *known, bool *found, lw_error *e);
lw_status lw_plan_gear_turns(lw_topology *t, const lw_cluster *c, lw_error *e);
lw_status lw_plan_check_gears(const lw_topology *t, lw_error *e);

static inline bool lw_plan_group_is_gear(const lw_plan_group *g)
{
    return g->kind == LW_STEP_GEAR || g->kind == LW_STEP_ROLL || g->kind == LW_STEP_RACK;
}

/* List the names of the unknown links as text: "A", "B". */
void lw_plan_list_unknown(const lw_topology *t, char *list, size_t size);

/* The link of this joint that became known first; -1 when none is known. */
int lw_known_link(const lw_topology *t, int joint);

/* Add the frames, dimensions, registers and steps that the outputs need (mbs/plan/plan_steps.c). */
lw_status lw_plan_emit(const lw_topology *t, lw_plan_options options, lw_plan *plan, lw_error *e);

/* Check whether output o is of the form of lw_fast_dyad; `applies` says so (mbs/plan/fast_dyad.c). */
lw_fast_dyad lw_plan_find_fast_dyad(const lw_plan *plan, int o);

static inline bool lw_same_place(lw_vec2 a, lw_vec2 b) { return a.x == b.x && a.y == b.y; }
static inline bool lw_plan_is_pin(const lw_topology *t, int joint)
{
    return lw_joint_turns(t->k->joint[joint].kind);
}

static inline bool lw_joint_has(const lw_joint *j, int link)
{
    return j->link[0] == link || j->link[1] == link;
}
static inline int lw_joint_other(const lw_joint *j, int link)
{
    return j->link[0] == link ? j->link[1] : j->link[0];
}

/* The frames of the plan's links in the plane, in the posture of a linkage; the direction of a slide line; the plan's
 * input [rad] or [m] (mbs/plan/plan_read.c).  The linkage has dies in its slots (lw_plan_expand).  LW_E_ARG: of another
 * topology. */
typedef struct lw_frames { lw_vec2 o[LW_LINK_MAX], d[LW_LINK_MAX]; } lw_frames;
lw_status lw_plan_frames(const lw_plan *p, const lw_linkage *linkage, lw_frames *f, lw_error *e);
lw_vec2 lw_plan_slide_direction(const lw_plan *p, const lw_linkage *linkage, int j);
double lw_plan_read_input(const lw_plan *p, const lw_linkage *linkage, const lw_frames *f);

#endif
