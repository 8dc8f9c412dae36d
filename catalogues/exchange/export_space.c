#include "catalogues/exchange/export_space.h"

#include <stdlib.h>
#include "catalogues/exchange/export.h"

bool lw_space_weighed(const lw_spatial *m)
{
    for (int i = 0; i < m->n_link; i++)
        if (i != m->ground && (m->body[i].mass > 0 || (m->elastic && m->elastic[i].given)))
            return true;
    return false;
}

lw_status lw_export_space_loads(const lw_spatial *m, const char *format, bool beams, lw_error *e)
{
    for (int i = 0; i < m->n_link; i++) {
        const lw_elastic *p = m->elastic ? &m->elastic[i] : NULL;
        if (p && p->given && !(beams && p->n_node == 0 && p->pieces == 0))
            return lw_error_set(e, LW_E_KIND, "link '%s' is %s, which is not written to %s: give it a mass instead in a copy of the "
                                "file to export the rest", m->body[i].name, beams ? "a superelement" : "elastic", format);
    }
    for (int j = 0; j < m->n_joint; j++)
        if (lw_spatial_has_clearance(&m->joint[j]) || m->joint[j].friction.coefficient > 0)
            return lw_error_set(e, LW_E_KIND, "joint '%s' has %s, which is not written to %s: take it out of a copy of the file to "
                                "export the rest", m->joint[j].name, lw_spatial_has_clearance(&m->joint[j]) ? "a clearance" : "friction",
                                format);
    lw_status s = lw_export_states(&m->states, format, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < m->n_spring; i++)
        if (m->spring[i].law)
            return lw_error_set(e, LW_E_KIND, "spring '%s' has a law of its own, which is not written to %s", m->spring[i].name, format);
    for (int i = 0; i < m->n_joint_spring; i++)
        if (m->joint_spring[i].law || m->joint_spring[i].measure.of >= LW_OF_X)
            return lw_error_set(e, LW_E_KIND, "joint spring '%s' has a law of its own, which is not written to %s",
                                m->joint_spring[i].name, format);
    for (int i = 0; i < m->n_force; i++)
        for (int c = 0; c < 3; c++)
            if (lw_export_varies(m->force[i].force[c]) || lw_export_varies(m->force[i].torque[c]))
                return lw_error_set(e, LW_E_KIND, "force '%s' is not constant, which is not written to %s", m->force[i].name, format);
    return LW_OK;
}

/* ---- the tree --------------------------------------------------------------------------------------- */

static void mark_loaded(const lw_spatial *m, bool *loaded)
{
    for (int j = 0; j < m->n_joint; j++)
        loaded[j] = m->joint[j].stop.has_least || m->joint[j].stop.has_greatest;
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i].measure.of < LW_OF_X)
            loaded[m->input[i].measure.index] = true;
    for (int i = 0; i < m->n_drive; i++)           /* always of joints */
        loaded[m->drive[i].index] = true;
    for (int i = 0; i < m->n_joint_spring; i++)
        if (m->joint_spring[i].measure.of < LW_OF_X)
            loaded[m->joint_spring[i].measure.index] = true;
    for (int i = 0; i < m->n_motor; i++)
        loaded[m->motor[i].joint] = true;
    for (int i = 0; i < m->n_coupling; i++)
        for (int k = 0; k < m->coupling[i].n; k++)
            loaded[m->coupling[i].of[k].index] = true;
}

/* Loaded joints first, revolute and spherical joints last: other programs close a loop at these with points alone, at the others with a
 * light body in between, which makes the loop softer. */
static int rank_of(lw_spatial_kind kind, bool loaded)
{
    switch (kind) {
    case LW_SPATIAL_FIXED:     return 0;
    case LW_SPATIAL_PRISMATIC:
    case LW_SPATIAL_CYLINDRICAL:
    case LW_SPATIAL_UNIVERSAL:
    case LW_SPATIAL_SCREW:
    case LW_SPATIAL_PLANAR:
        return loaded ? 0 : 1;
    case LW_SPATIAL_REVOLUTE:  return loaded ? 0 : 2;
    case LW_SPATIAL_SPHERICAL: return 3;
    case LW_SPATIAL_FREE:      return 4;             /* it closes nothing */
    }
    return 0;
}

lw_status lw_space_tree_make(const lw_spatial *m, bool plane, lw_export_tree *t, lw_error *e)
{
    size_t joints = (size_t)m->n_joint + 1;
    int *rank = calloc(joints, sizeof *rank);
    bool *loaded = calloc(joints, sizeof *loaded);
    *t = (lw_export_tree){ 0 };
    lw_status s = rank && loaded ? LW_OK : LW_E_MEMORY;
    if (s == LW_OK)
        mark_loaded(m, loaded);
    for (int j = 0; s == LW_OK && j < m->n_joint; j++)
        rank[j] = m->joint[j].link[0] < 0 ? -1 : rank_of(m->joint[j].kind, loaded[j]);
    if (s == LW_OK)
        s = lw_span(m->joint, sizeof *m->joint, offsetof(lw_spatial_joint, link), rank, m->n_joint, m->ground, m->n_link, t);
    if (s != LW_OK)
        lw_error_set(e, s, s == LW_E_MEMORY ? "out of memory for a tree of bodies"
                     : "a link hangs on no joint, or on a gear alone, which has no form in a tree of bodies");
    for (int i = 0; s == LW_OK && i < m->n_link; i++) {
        const lw_spatial_joint *p = t->joint[i] < 0 ? NULL : &m->joint[t->joint[i]];
        if (p && p->kind == LW_SPATIAL_FREE && t->parent[i] != m->ground && !plane)
            s = lw_error_set(e, LW_E_KIND, "joint '%s' is free between two links that move, which has no form in a "
                             "tree of bodies; name the ground as one of its links", p->name);
        if (p)
            t->origin[i] = p->at;
    }
    free(rank), free(loaded);
    return s;
}
