/* enumerate/fractionated.h - chains that fall apart at a link or at a bridge joint.
 *
 * Such a chain is a tree of blocks: closed chains that are not fractionated (chains.h, rings included) and
 * bridge joints, which count as blocks of two links with F = 1.  Blocks share links; the freedoms of the
 * blocks add up to F, so there are at most six.  Every link has two joints at least, so no bridge hangs
 * loose.
 *
 * Each chain is built once, outward from its middle (the centroid of the tree; Jordan 1869): the link all of
 * whose branches have at most P/2 links; where two links joined by a bridge share that honour, the bridge;
 * or else the block on each of whose links hang fewer than P/2, the link included.  Branches are rooted chains, small ones only, made beforehand; on a middle block they are
 * distributed up to its symmetry. */
#ifndef LW_ENUMERATE_FRACTIONATED_H
#define LW_ENUMERATE_FRACTIONATED_H

#include "base/error.h"
#include "grammar/chain.h"

/* One chain, valid during the call; n_bridge bridge joints.  Anything but LW_OK ends the walk. */
typedef lw_status lw_fractionated_visit(void *context, const lw_chain *chain, int n_bridge);

/* Visit every fractionated chain with P links and F freedoms, joints of one freedom: those with a middle
 * link first, then a middle bridge, then by middle block, small blocks first.  Single-threaded.  LW_E_ARG as lw_chains_create;
 * LW_E_MEMORY; or what visit returned. */
lw_status lw_fractionated_each(int n_link, int dof, lw_fractionated_visit *visit, void *context, lw_error *e);

#endif
