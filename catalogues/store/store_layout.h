/* catalogues/store/store_layout.h - places of the joints of a chain as bytes of a catalogue (chain.layout).
 *
 * Little-endian bytes: 1 (version), n_link, n_joint, bit 0 planar, n_cross, symmetry; least angle and gap as float; the
 * numbers of joints of link 1, 2, ... ; the joints of each in the order of its outline; x, y of each joint
 * as float; x, y of the free end of each link that has a single joint.  Some 190 bytes for twelve links. */
#ifndef LW_CATALOGUES_STORE_STORE_LAYOUT_H
#define LW_CATALOGUES_STORE_STORE_LAYOUT_H

#include "base/bytes.h"
#include "catalogues/draw/chain_layout.h"

void lw_layout_pack(const lw_chain_layout *l, int n_link, lw_bytes *out);

#endif
