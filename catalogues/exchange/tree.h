/* catalogues/exchange/tree.h - a linkage as a tree of bodies that hang on each other, for formats that know such trees
 * only; the joints outside of the tree close the loops. */
#ifndef LW_CATALOGUES_EXCHANGE_TREE_H
#define LW_CATALOGUES_EXCHANGE_TREE_H

#include "base/vec3.h"
#include "grammar/model/model.h"

typedef struct lw_export_tree {
    bool    *in_tree;                  /* (n_joint)                                                          */
    int     *parent, *joint;           /* (n_link) the parent and the joint to it; -1: none (ground)         */
    int     *child, *next;             /* (n_link) the first child, the next child of the parent; -1: none   */
    lw_vec3 *origin;                   /* (n_link) of a body's frame: the joint to its parent; ground: 0 [m] */
} lw_export_tree;

/* A spanning tree of n_link links from the ground: joints of lowest rank first, those of a rank below 0 never. Joints are `stride`
 * bytes apart; the pair of links of each is `offset` bytes inside. Does not fill origin. LW_E_KIND: a link is not reached;
 * LW_E_MEMORY. Free it after a failure too. */
lw_status lw_span(const void *joints, size_t stride, size_t offset, const int *rank, int n_joint, int ground, int n_link, lw_export_tree *t);
void      lw_export_tree_free(lw_export_tree *t);

/* Choose a spanning tree: driven and loaded joints first (m may be NULL), then those of gear wheels, welds, sliders and
 * slots, pins last. LW_E_KIND: a link hangs on a gear alone; failures of lw_export_gear. Free it after a failure too. */
lw_status lw_export_span(const lw_assembly *linkage, const lw_model *m, lw_export_tree *t, lw_error *e);

/* Origin of the frame of a link's body in the plane [m]. */
static inline lw_vec2 lw_export_origin(const lw_export_tree *t, int link) { return lw_v2(t->origin[link].x, t->origin[link].y); }

/* +1 if the turn or shift of `child` has the joint's sign, else -1. */
double lw_export_count_sign(const lw_assembly *linkage, int joint, int child);

/* Has a link of the model a mass? m may be NULL. */
bool lw_export_weighed(const lw_assembly *linkage, const lw_model *m);

#endif
