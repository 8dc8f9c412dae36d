/* enumerate/invert.h - ground links of a chain up to symmetry (its kinematic inversions).
 *
 * For any chain.  For chains from a listing, whose symmetry is known, lw_chain_item_orbits (chains.h) gives the same
 * classes faster. */
#ifndef LW_ENUMERATE_INVERT_H
#define LW_ENUMERATE_INVERT_H

#include <stdint.h>
#include "base/status.h"
#include "grammar/topology/chain.h"

/* lowest[i] = the lowest link equivalent to link i; lowest (P).  *n_class (may be NULL) gets the number of
 * classes, which is the number of different mechanisms by choice of the ground link.  LW_E_MEMORY. */
lw_status lw_chain_orbits(const lw_chain *c, uint8_t *lowest, int *n_class);

/* The ground links to choose from, one of each class, rising.  From lowest (n_link) as above to ground
 * (n_link); returns how many. */
int lw_ground_choices(const uint8_t *lowest, int n_link, uint8_t *ground);

#endif
