/* mbs/elastic/expand_space.h - elastic links of a spatial model as chains of nodes and beam elements (mbs/elastic/beam_space.h),
 * as mbs/elastic/expand.h does in the plane.  Rotary inertia at either end of an element: half of rho I h, I the second moments
 * of the section about its three axes. */
#ifndef LW_MBS_ELASTIC_EXPAND_SPACE_H
#define LW_MBS_ELASTIC_EXPAND_SPACE_H

#include "grammar/model/spatial.h"
#include "mbs/elastic/chain.h"

typedef struct lw_spatial_expansion {
    lw_spatial model;                /* shares expressions with the model it comes from, which must outlive it */
    int        n_chain;
    lw_elastic_chain *chain;
    lw_expression_list own;          /* of loads that are spread over elements */
} lw_spatial_expansion;

/* in_time: a bar of consistent mass becomes a superelement for each of its elements, whose mass turns with it.
 * Modes of condensed links are the coordinates of nodes behind the others of their link.  LW_E_ARG: an axis that does not
 * follow from the joints, a direction of the height along it, or more modes than inner coordinates of own matrices (the link is named).  x needs
 * lw_spatial_expansion_free, after a failure too. */
lw_status lw_spatial_expand(const lw_spatial *m, bool in_time, lw_spatial_expansion *x, lw_error *e);
void      lw_spatial_expansion_free(lw_spatial_expansion *x);

/* The same model with its elastic links as rigid bars of the same mass; *rigid needs lw_spatial_rigid_free. */
lw_status lw_spatial_rigid(const lw_spatial *m, lw_spatial *rigid, lw_error *e);
void      lw_spatial_rigid_free(lw_spatial *rigid);

#endif
