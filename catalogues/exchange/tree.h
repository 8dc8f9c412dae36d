/* catalogues/exchange/tree.h - a linkage as a tree of bodies that hang on each other, for formats that know such trees
 * only; the joints outside of the tree close the loops. */
#ifndef LW_CATALOGUES_EXCHANGE_TREE_H
#define LW_CATALOGUES_EXCHANGE_TREE_H

#include "grammar/model/model.h"

typedef struct lw_export_tree {
    bool    *in_tree;                  /* (n_joint)                                                      */
    int     *parent;                   /* (n_link) parent link, and the joint to it; -1: none (ground)   */
    int     *joint;                    /* (n_link)                                                       */
    lw_vec2 *origin;                   /* (n_link) of the body's frame: the joint to its parent [m]      */
} lw_export_tree;

/* A spanning tree of n_link links from the ground: joints of lowest rank first, those of a rank below 0 never. link:
 * (n_joint) pairs; group: (n_link) scratch; in_tree (n_joint): false before. LW_E_KIND: a link is not reached;
 * LW_E_MEMORY. */
lw_status lw_span(int (*link)[2], const int *rank, int n_joint, int ground, int n_link, int *group, bool *in_tree,
                  int *parent, int *joint);

/* Choose a spanning tree: driven and loaded joints first (m may be NULL), then those of gear wheels, welds, sliders and
 * slots, pins last. LW_E_KIND: a link hangs on a gear alone; failures of lw_export_gear. */
lw_status lw_export_span(const lw_assembly *linkage, const lw_model *m, lw_export_tree *t, lw_error *e);
void      lw_export_tree_free(lw_export_tree *t);       /* after a failure too */

/* +1 if the turn or shift of `child` has the joint's sign, else -1. */
double lw_export_count_sign(const lw_assembly *linkage, int joint, int child);

/* Has a link of the model a mass? m may be NULL. */
bool lw_export_weighed(const lw_assembly *linkage, const lw_model *m);

#endif
