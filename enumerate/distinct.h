/* enumerate/distinct.h - the chains of one structure, listed and compared with each other.
 *
 * This is a second opinion on weighting.h, which keeps one weighting of each orbit and never compares chains.  Here each
 * chain gets a number that does not depend on the numbering of its links (colour refinement of the whole graph).
 * Chains with different numbers are not isomorphic.  Chains with equal numbers are compared by their canonical forms.
 * One chain in 64, chosen by its number, is tested for rigid subchains by the pebble game. */
#ifndef LW_ENUMERATE_DISTINCT_H
#define LW_ENUMERATE_DISTINCT_H

#include "enumerate/weighting.h"

/* n_chain: classes of isomorphic chains without rigid subchain; n_ground: ground links as by lw_weighting_orbits.
 * Fewer chains than lw_weighting_each visits mean that some were isomorphic or rigid.  LW_E_MEMORY; LW_E_IO as for
 * lw_chain_canonical.  16 + n_line bytes of memory a chain. */
lw_status lw_distinct_count(const lw_weighting *w, lw_tally *tally);

#endif
