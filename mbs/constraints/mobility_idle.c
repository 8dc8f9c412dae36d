/* mbs/constraints/mobility_idle.c - weld joints that affect neither inputs nor tracers. */
#include "mbs/constraints/mobility.h"

static bool may_be_held(const lw_linkage *k, int joint, uint32_t idle)
{
    const lw_joint *j = &k->joint[joint];
    for (int i = 0; i < k->n_input; i++)
        if (k->input[i].joint == joint)
            return false;
    return lw_joint_can_drive(j->kind)
        && ((idle >> j->link[0] & 1) || (idle >> j->link[1] & 1));
}

/* Weld a joint that removes one idle freedom and nothing else; returns its number, -1: there is none. */
static int hold_one(lw_linkage *k, lw_mobility *m)
{
    const lw_mobility_options o = lw_mobility_options_default();
    for (int j = 0; j < k->n_joint; j++) {
        lw_joint as_it_was = k->joint[j];
        lw_mobility held;
        if (!may_be_held(k, j, m->idle_links))
            continue;
        k->joint[j].kind = LW_JOINT_FIXED;
        k->joint[j].along = lw_v2(0.0, 0.0);
        if (lw_mobility_find(k, &o, &held, NULL) == LW_OK && held.kind == LW_MOBILITY_MOVES
            && held.freedom == m->freedom - 1 && held.idle == m->idle - 1 && held.driven == m->driven) {
            *m = held;
            return j;
        }
        k->joint[j] = as_it_was;
    }
    return -1;
}

lw_status lw_mobility_hold_idle(lw_linkage *k, uint64_t *joints, lw_error *e)
{
    const lw_mobility_options o = lw_mobility_options_default();
    lw_mobility m;
    *joints = 0;
    lw_status s = lw_mobility_find(k, &o, &m, e);
    while (s == LW_OK && m.idle > 0) {
        int joint = hold_one(k, &m);
        if (joint < 0)
            return LW_OK;
        *joints |= (uint64_t)1 << joint;
    }
    return s;
}
