/* grammar/topology/planar.h - whether a graph is planar; its regions if it is, a witness if it is not.
 *
 * A bridge to libplanarity (Boyer & Myrvold 2004, edge addition).  A graph is given as a bit mask per
 * vertex: bit k of adjacent[i] and bit i of adjacent[k] are set when i and k are joined.  Parallel
 * lines and strings of binary links do not affect planarity, so a chain can be tested by its structure.
 * A planar *mechanism* moves in a plane; its graph need not be planar.
 *
 * Reentrant; every call allocates and frees inside libplanarity. */
#ifndef LW_GRAMMAR_TOPOLOGY_PLANAR_H
#define LW_GRAMMAR_TOPOLOGY_PLANAR_H

#include <stdbool.h>
#include <stdint.h>
#include "base/status.h"
#include "grammar/topology/chain.h"

#define LW_REGION_MAX       (2*LW_LINK_MAX)   /* Euler: at most 2n - 4 regions, n > 2      */
#define LW_REGION_SIDE_MAX  (6*LW_LINK_MAX)   /* two sides of at most 3n - 6 edges         */

/* The regions of one drawing in the plane.  Region r is bounded by the closed walk
 * vertex[first[r]], ..., vertex[first[r+1]-1]; neighbours in the walk, and its last and first, are
 * joined.  The walks contain every edge twice, once in each direction; a bridge is twice in the same
 * walk.  All walks go round their regions in the same sense, seen from inside each region. */
typedef struct lw_regions {
    int     n_region;
    int     first[LW_REGION_MAX + 1];
    uint8_t vertex[LW_REGION_SIDE_MAX];
} lw_regions;

/* *planar is set if the graph of n vertices (1 .. LW_LINK_MAX) is planar; the graph need not be connected.
 * LW_E_ARG when a mask holds its own vertex or a vertex >= n, or is not symmetric. */
lw_status lw_planar_test(int n, const uint32_t *adjacent, bool *planar);

/* The same of the graph of a chain. */
lw_status lw_planar_chain(const lw_chain *c, bool *planar);

/* The regions of a connected planar graph with two vertices or more; v - e + a = 2 (Makkonen 1999,
 * eq. 6).  The same masks give the same drawing.  LW_NOTHING when the graph is not planar; LW_E_ARG
 * as above and when it is not connected. */
lw_status lw_planar_regions(int n, const uint32_t *adjacent, lw_regions *r);

/* For a graph that is not planar: a subdivision of K5 or K3,3 inside it (Kuratowski 1930), as the
 * masks of its edges in witness (n).  LW_NOTHING when the graph is planar. */
lw_status lw_planar_witness(int n, const uint32_t *adjacent, uint32_t *witness);

#endif
