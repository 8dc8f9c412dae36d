/* optimise/topology/grow.h - a linkage with a dyad added that moves its point as before.
 *
 * The point is taken over by a new link, pinned to the old one at the point; a second new link joins this one to the
 * ground or to another link.  As a start of a fit the child is no worse than its parent, and it has five dimensions
 * more. */
#ifndef LW_OPTIMISE_TOPOLOGY_GROW_H
#define LW_OPTIMISE_TOPOLOGY_GROW_H

#include "base/rng.h"
#include "grammar/linkage/linkage.h"

/* Draw the lengths of the new dyad so that it closes over the parent's motion: a turn of the input (`turns`), or
 * inputs from `first` to `last` (as lw_plan_read counts them).  The least and the greatest distance that the dyad
 * spans are found as zeros of their rate between 48 postures, to rounding; only two zeros between two postures can be
 * missed, and the lengths keep some percent of margin for that.  Of several tracers one is drawn; it stays where it
 * was, on the new link.  The angle between the new links stays between `transmission` [rad] and its supplement if some
 * tries find such links, and else closes only. LW_E_ARG: too many links or joints; LW_OPEN: some tries gave no child; LW_E_MEMORY. */
lw_status lw_linkage_grow(const lw_linkage *parent, bool turns, double first, double last, double transmission,
                          lw_rng *rng, lw_linkage *child);

#endif
