/* mbs/elastic/expand.h - elastic links of a model as chains of nodes and beam elements.
 *
 * An elastic link becomes n elements between n + 1 nodes, which are links with lumped masses: half the mass of each element
 * and half of its rotary inertia rho I h at either end.  Joints, tracers, springs and forces of the link act on the node at
 * their place; beside the axis, through a rigid arm from the nearest point of it; a load along a line on the nodes that it
 * covers.  All other links, joints, tracers and inputs keep their indices, so expressions stay valid; node 0 of a link has the index of the link.
 * Shapes, contacts and ropes are those of rigid links. */
#ifndef LW_MBS_ELASTIC_EXPAND_H
#define LW_MBS_ELASTIC_EXPAND_H

#include "grammar/model/model.h"
#include "mbs/elastic/chain.h"

typedef struct lw_elastic_expansion {
    lw_model model;                  /* shares expressions and names with the model it comes from, which must outlive it */
    int      n_chain;
    lw_elastic_chain *chain;
    lw_expression_list own;          /* of loads that are spread over elements */
} lw_elastic_expansion;

/* in_time: a bar of consistent mass becomes a superelement for each of its elements, as in space.  LW_E_ARG: an axis that does not follow
 * from the joints, or has no length (the link is named).  x needs lw_elastic_expansion_free, after a failure too. */
lw_status lw_elastic_expand(const lw_model *m, bool in_time, lw_elastic_expansion *x, lw_error *e);
void      lw_elastic_expansion_free(lw_elastic_expansion *x);

/* The same model with its elastic links as rigid bars of the same mass; *rigid needs lw_elastic_rigid_free. */
lw_status lw_elastic_rigid(const lw_model *m, lw_model *rigid, lw_error *e);
void      lw_elastic_rigid_free(lw_model *rigid);

#endif
