/* enumerate/fractionated.h - chains that fall apart at a link or at a bridge joint.
 *
 * Such a chain is a tree of blocks: closed chains that are not fractionated (chains.h, rings included) and
 * bridge joints, which count as blocks of two links with F = 1.  Blocks share links.  The freedoms of the
 * blocks add up to F, so there are at most six blocks.  Every link has at least two joints, so no bridge has a
 * free end.
 *
 * Each chain is built once, outward from its middle (the centroid of the tree; Jordan 1869).  The middle is the
 * link all of whose branches have at most P/2 links; if two links joined by a bridge have this property, it is the
 * bridge; otherwise it is the block each of whose links carries fewer than P/2 links, the link included.  Branches
 * are small rooted chains, made beforehand; on a middle block they are distributed up to its symmetry. */
#ifndef LW_ENUMERATE_FRACTIONATED_H
#define LW_ENUMERATE_FRACTIONATED_H

#include "base/error.h"
#include "grammar/topology/chain.h"

/* One chain, valid during the call; n_bridge bridge joints.  A status other than LW_OK ends the walk. */
typedef lw_status lw_fractionated_visit(void *context, const lw_chain *chain, int n_bridge);

/* Visit every fractionated chain with P links and F freedoms, joints of one freedom: first those with a middle link,
 * then with a middle bridge, then with a middle block, small blocks first.  Single-threaded.  LW_E_ARG as
 * lw_chains_create; LW_E_MEMORY; or the status of visit. */
lw_status lw_fractionated_each(int n_link, int dof, lw_fractionated_visit *visit, void *context, lw_error *e);

#endif
