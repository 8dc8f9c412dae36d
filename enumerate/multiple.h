/* enumerate/multiple.h - chains with multiple joints: two or more pins on one axis.
 *
 * Such a chain is a bipartite graph of links and pins; a pin that holds d links counts as d - 1 joints of one
 * freedom, so F = 3 (P - 1) - 2 sum of (d - 1).  Replacing the pin by a star of simple joints around
 * one of the d links makes a simple chain.  For every set of links the star around one of its own links gives the
 * right count.  So nothing is rigid exactly when no choice of star centres gives a rigid chain; and some choice gives
 * a chain that is not fractionated.  So all chains with multiple joints arise from the simple chains of the same P
 * and F by merging joints of one link; canonical forms identify duplicates. */
#ifndef LW_ENUMERATE_MULTIPLE_H
#define LW_ENUMERATE_MULTIPLE_H

#include "enumerate/chains.h"
#include "grammar/topology/multiple.h"

/* True for a closed chain that can move and is not fractionated: no two links share two pins, every link has at least
 * two pins, no set of links has F <= 0, and the chain stays connected without any one link or pin. */
bool lw_multiple_moves(const lw_multiple *m);

/* Canonical form: the same for isomorphic chains and for no others.  LW_E_ARG when links and multiple
 * pins together are more than LW_LINK_MAX; LW_E_MEMORY. */
lw_status lw_multiple_canonical(const lw_multiple *m, lw_multiple *form);

/* lowest (n_link): of each link the lowest one that a symmetry maps it to; *order: the number of symmetries.
 * LW_E_ARG as above, LW_E_MEMORY. */
lw_status lw_multiple_symmetry(const lw_multiple *m, uint8_t *lowest, uint64_t *order);

typedef lw_status lw_multiple_visit(void *context, const lw_multiple *m);

/* Visit once every chain with n_link links, F = dof and at least one multiple joint, not fractionated, in the order of
 * the simple chains (chains.h).  Keeps all forms in memory, 264 bytes each.  LW_E_ARG with the
 * equation, LW_E_MEMORY. */
lw_status lw_multiple_each(int n_link, int dof, int n_thread, lw_multiple_visit *visit, void *context, lw_error *e);

/* The same for chains that separate at a link or a pin.  They arise from simple chains of both sorts. */
lw_status lw_multiple_fractionated_each(int n_link, int dof, int n_thread, lw_multiple_visit *visit, void *context, lw_error *e);

#endif
