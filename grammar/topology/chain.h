/* grammar/topology/chain.h - a kinematic chain: links are vertices, joints are edges, nothing is fixed yet.
 *
 * Two links share at most one joint, so one bit for each pair and kind of joint is enough.  Links are
 * numbered from 0 here, and from 1 in texts for people.  Plain data of 260 bytes, copied
 * with '='; nothing here allocates or needs freeing. */
#ifndef LW_GRAMMAR_TOPOLOGY_CHAIN_H
#define LW_GRAMMAR_TOPOLOGY_CHAIN_H

#include <stdbool.h>
#include <stdint.h>
#include "base/error.h"

#define LW_LINK_MAX        32
#define LW_JOINT_MAX       64                 /* of a mechanism or linkage */
#define LW_INPUT_MAX        8

typedef struct lw_chain {
    int      n_link;             /* P, 1 .. LW_LINK_MAX                                           */
    uint32_t one[LW_LINK_MAX];   /* bit k of one[i]: i and k share a joint of one freedom (r, t)  */
    uint32_t two[LW_LINK_MAX];   /* the same for two freedoms (p, g); rows n_link.. are 0         */
} lw_chain;

/* n_link links and no joint.  LW_E_ARG, c untouched, when n_link is not 1 .. LW_LINK_MAX. */
lw_status lw_chain_clear(lw_chain *c, int n_link);

/* Join links i and k by a joint of 1 or 2 freedoms.  LW_E_ARG, chain untouched, when i == k, one is
 * no link, or they share a joint of the other kind.  Joining twice is harmless. */
lw_status lw_chain_join(lw_chain *c, int i, int k, int freedom);

/* Remove the joint between i and k, whatever its kind; harmless when there is none. */
void lw_chain_unjoin(lw_chain *c, int i, int k);

/* Freedoms of the joint between i and k: 1 or 2; 0 when they share none. */
static inline int lw_chain_freedom(const lw_chain *c, int i, int k)
{
    return (int)(c->one[i] >> k & 1) + 2*(int)(c->two[i] >> k & 1);
}

/* Links that share a joint with link i, as bits; and how many. */
static inline uint32_t lw_chain_neighbours(const lw_chain *c, int i) { return c->one[i] | c->two[i]; }
static inline int lw_chain_degree(const lw_chain *c, int i)
{
    return __builtin_popcount(lw_chain_neighbours(c, i));
}

/* All links as bits. */
static inline uint32_t lw_chain_links(const lw_chain *c)
{
    return (uint32_t)(((uint64_t)1 << c->n_link) - 1);
}

/* Number of joints of 1 or of 2 freedoms (n1, n2). */
int lw_chain_count(const lw_chain *c, int freedom);

/* F = 3 (P - 1) - 2 n1 - n2  (Makkonen 1999, eq. 2).  A count, not a proof: the sum does not show a
 * rigid subchain, see lw_chain_rigid. */
int lw_chain_mobility(const lw_chain *c);

/* The same count for the subchain of the given links and all joints between them. */
int lw_chain_mobility_of(const lw_chain *c, uint32_t links);

/* L = n1 + n2 - P + 1  (Makkonen 1999, eq. 10), for a connected chain. */
int lw_chain_loops(const lw_chain *c);

/* n_with[d] = number of links with d joints, d = 0 .. LW_LINK_MAX - 1.  n_with (LW_LINK_MAX). */
void lw_chain_assortment(const lw_chain *c, int *n_with);

bool lw_chain_is_connected(const lw_chain *c);

/* Links whose removal leaves the others in several pieces, as bits.  A connected chain is
 * fractionated when it has one: the two sides of a bridge joint are cut links too. */
uint32_t lw_chain_cut_links(const lw_chain *c);

/* True if there is a subchain of two or more links with F <= 0; *links (may be NULL) then gets one.  With
 * `proper` only subchains smaller than the whole count (Baranov trusses have F = 0 as a whole).
 * Pebble game of Lee & Streinu 2008 for (3,4)-sparsity, a joint of one freedom counted twice. */
bool lw_chain_rigid(const lw_chain *c, bool proper, uint32_t *links);

/* A closed chain that can move: connected, no link with fewer than two joints, no rigid subchain (for
 * F = 0: no proper one).  LW_E_ARG with a text that names the links (numbered from 1) otherwise. */
lw_status lw_chain_check(const lw_chain *c, lw_error *e);

/* Rename links: link i of c becomes link to[i] of out.  to is a permutation of 0 .. n_link-1. */
void lw_chain_relabel(const lw_chain *c, const uint8_t *to, lw_chain *out);

/* Same links, same joints, same numbers (not: isomorphic, see enumerate/canon.h). */
bool lw_chain_same(const lw_chain *a, const lw_chain *b);

#endif
