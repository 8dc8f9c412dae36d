#include "catalogues/exchange/tree.h"

#include <stdlib.h>
#include "base/owners.h"
#include "base/union_find.h"
#include "catalogues/exchange/export.h"

/* Mark the joints with an input, a spring, a motor or a stop. Formats know these for joints of the tree only. */
static void mark_loaded(const lw_assembly *linkage, const lw_model *m, bool *loaded)
{
    for (int i = 0; i < linkage->n_input; i++)
        loaded[linkage->input[i].joint] = true;
    for (int j = 0; m && j < linkage->n_joint; j++)
        loaded[j] = loaded[j] || m->stop[j].has_least || m->stop[j].has_greatest;
    for (int i = 0; m && i < m->n_joint_spring; i++)
        loaded[m->joint_spring[i].joint] = true;
    for (int i = 0; m && i < m->n_motor; i++)
        loaded[m->motor[i].joint] = true;
}

/* Order in which the tree takes the joints: driven and loaded joints, joints of gear wheels, welds, sliders and slots, then
 * pins, because a loop is closed most simply at a pin; free joints, which close nothing, last. -1: never. */
static int rank_of(lw_joint_kind kind, bool loaded, bool at_gear)
{
    return lw_joint_has_ratio(kind) ? -1 : loaded ? 0 : at_gear ? 1
         : lw_joint_freedoms(kind) == 0 ? 2 : lw_joint_freedoms(kind) == 3 ? 5 : lw_joint_turns(kind) ? 4 : 3;
}

static lw_status mark_gears(const lw_assembly *linkage, bool *at_gear, lw_error *e)
{
    for (int j = 0; j < linkage->n_joint; j++) {
        int joint[2];
        double sign[2];
        lw_status s = lw_joint_has_ratio(linkage->joint[j].kind) ? lw_export_gear(linkage, j, joint, sign, e) : LW_OK;
        if (s != LW_OK)
            return s;
        if (lw_joint_has_ratio(linkage->joint[j].kind))
            at_gear[joint[0]] = at_gear[joint[1]] = true;
    }
    return LW_OK;
}

static const int *links_of(const void *joints, size_t stride, size_t offset, int j)
{
    return (const int *)(const void *)((const char *)joints + (size_t)j*stride + offset);
}

lw_status lw_span(const void *joints, size_t stride, size_t offset, const int *rank, int n_joint, int ground, int n_link, lw_export_tree *t)
{
    size_t n = (size_t)n_link + 1;
    lw_owners of = { 0 };                                  /* joints of each link */
    int most = 0, reached = 1, *group = calloc(n, sizeof *group), *queue = group;
    *t = (lw_export_tree){ .in_tree = calloc((size_t)n_joint + 1, sizeof *t->in_tree), .parent = calloc(4*n, sizeof *t->parent),
                           .origin = calloc(n, sizeof *t->origin) };
    if (!group || !t->in_tree || !t->parent || !t->origin || !lw_owners_make(&of, n_link, joints, stride, offset, n_joint, 2)) {
        free(group);
        return LW_E_MEMORY;
    }
    t->joint = t->parent + n, t->child = t->joint + n, t->next = t->child + n;
    for (int i = 0; i < n_link; i++) {
        group[i] = i;
        t->parent[i] = t->joint[i] = t->child[i] = t->next[i] = -1;
    }
    for (int j = 0; j < n_joint; j++)
        most = rank[j] > most ? rank[j] : most;
    for (int r = 0; r <= most; r++)                        /* Kruskal's method */
        for (int j = 0; j < n_joint; j++) {
            if (rank[j] != r)
                continue;
            const int *link = links_of(joints, stride, offset, j);
            int a = lw_root_of(group, link[0]), b = lw_root_of(group, link[1]);
            t->in_tree[j] = a != b;
            group[b] = a;
        }
    queue[0] = ground;
    for (int head = 0; head < reached; head++)
        for (int at = of.start[queue[head]]; at < of.start[queue[head] + 1]; at++) {
            int j = of.entry[at]/2, to = links_of(joints, stride, offset, j)[1 - of.entry[at]%2];
            if (!t->in_tree[j] || to == ground || t->parent[to] >= 0)
                continue;
            t->parent[to] = queue[head];
            t->joint[to] = j;
            queue[reached++] = to;
        }
    for (int i = n_link - 1; i >= 0; i--)
        if (t->parent[i] >= 0) {
            t->next[i] = t->child[t->parent[i]];
            t->child[t->parent[i]] = i;
        }
    lw_owners_free(&of);
    free(group);
    return reached == n_link ? LW_OK : LW_E_KIND;
}

lw_status lw_export_span(const lw_assembly *linkage, const lw_model *m, lw_export_tree *t, lw_error *e)
{
    size_t joints = (size_t)linkage->n_joint + 1;
    bool *at_gear = calloc(2*joints, sizeof *at_gear), *loaded = at_gear + joints;
    int *rank = calloc(joints, sizeof *rank);
    *t = (lw_export_tree){ 0 };
    lw_status s = at_gear && rank ? mark_gears(linkage, at_gear, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        mark_loaded(linkage, m, loaded);
    for (int j = 0; s == LW_OK && j < linkage->n_joint; j++)
        rank[j] = rank_of(linkage->joint[j].kind, loaded[j], at_gear[j]);
    if (s == LW_OK && (s = lw_span(linkage->joint, sizeof *linkage->joint, offsetof(lw_joint, link), rank, linkage->n_joint,
                                   linkage->ground, linkage->n_link, t)) != LW_OK)
        lw_error_set(e, s, s == LW_E_MEMORY ? "out of memory" : "a link hangs on a gear alone, which has no form in a tree of bodies");
    for (int i = 0; s == LW_OK && i < linkage->n_link; i++)
        if (t->joint[i] >= 0)
            t->origin[i] = lw_v3(linkage->joint[t->joint[i]].at.x, linkage->joint[t->joint[i]].at.y, 0);
    free(at_gear), free(rank);
    return s;
}

void lw_export_tree_free(lw_export_tree *t)
{
    free(t->in_tree), free(t->parent), free(t->origin);
    *t = (lw_export_tree){ 0 };
}

double lw_export_count_sign(const lw_assembly *linkage, int joint, int child)
{
    const lw_joint *p = &linkage->joint[joint];
    bool turned = lw_joint_turns(p->kind) && p->link[1] == linkage->ground;
    return (p->link[turned ? 0 : 1] == child) ? 1 : -1;
}

bool lw_export_weighed(const lw_assembly *linkage, const lw_model *m)
{
    for (int i = 0; m && i < linkage->n_link; i++)
        if (i != linkage->ground && m->body[i].mass > 0)
            return true;
    return false;
}
