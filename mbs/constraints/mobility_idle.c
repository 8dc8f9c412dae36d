/* mbs/constraints/mobility_idle.c - weld joints that affect neither inputs nor tracers. */
#include "mbs/constraints/mobility.h"

static bool may_be_held(const lw_linkage *linkage, int joint, uint32_t idle)
{
    const lw_joint *j = &linkage->joint[joint];
    for (int i = 0; i < linkage->n_input; i++)
        if (linkage->input[i].joint == joint)
            return false;
    return lw_joint_can_drive(j->kind)
        && ((idle >> j->link[0] & 1) || (idle >> j->link[1] & 1));
}

/* Weld a joint that removes one idle freedom and nothing else; returns its number, -1: there is none. */
static int hold_one(lw_linkage *linkage, lw_mobility *m)
{
    const lw_mobility_options o = lw_mobility_options_default();
    for (int j = 0; j < linkage->n_joint; j++) {
        lw_joint as_it_was = linkage->joint[j];
        lw_mobility held;
        if (!may_be_held(linkage, j, m->idle_links))
            continue;
        linkage->joint[j].kind = LW_JOINT_FIXED;
        linkage->joint[j].along = lw_v2(0.0, 0.0);
        if (lw_mobility_find(linkage, &o, &held, NULL) == LW_OK && held.kind == LW_MOBILITY_MOVES
            && held.freedom == m->freedom - 1 && held.idle == m->idle - 1 && held.driven == m->driven) {
            *m = held;
            return j;
        }
        linkage->joint[j] = as_it_was;
    }
    return -1;
}

lw_status lw_mobility_hold_idle(lw_linkage *linkage, uint64_t *joints, lw_error *e)
{
    const lw_mobility_options o = lw_mobility_options_default();
    lw_mobility m;
    *joints = 0;
    lw_status s = lw_mobility_find(linkage, &o, &m, e);
    while (s == LW_OK && m.idle > 0) {
        int joint = hold_one(linkage, &m);
        if (joint < 0)
            return LW_OK;
        *joints |= (uint64_t)1 << joint;
    }
    return s;
}
