/* optimise/topology/grow.h - a linkage with two links more that does what the smaller one does: the point is taken by a
 * new link that is pinned there, and held by a second one that is pinned to the ground or to
 * another link.  As a start for a fit it cannot be worse than what it came from, and it has five
 * dimensions more. */
#ifndef LW_OPTIMISE_TOPOLOGY_GROW_H
#define LW_OPTIMISE_TOPOLOGY_GROW_H

#include "base/rng.h"
#include "grammar/linkage.h"

/* The new dyad's lengths are drawn so that it closes wherever the parent's input goes: `turns`, or from `first` to
 * `last` (as lw_plan_read counts it).  For that the least and the greatest distance it has to span are found as zeros
 * of their rate between 48 places, to rounding; only two of them between two places could be missed, and some percent
 * are left for that.  A tracer of the child - the only one, or one drawn of several - is that of the parent, on the
 * new link; the others stay.  LW_E_ARG: too many links or joints; LW_OPEN: nothing was found in some tries. */
lw_status lw_linkage_grow(const lw_linkage *parent, bool turns, double first, double last, lw_rng *rng,
                          lw_linkage *child);

#endif
