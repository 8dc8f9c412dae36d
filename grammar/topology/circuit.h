/* grammar/topology/circuit.h - a shortest cycle basis of a graph.  It gives the circuits of a chain whose graph is not
 * planar, and the loops that determine the class of an Assur group.
 *
 * Horton 1987: take the circuits "shortest path v-x, edge xy, shortest path y-v" in the order of their
 * lengths and keep each that is independent of those kept before.  The result is a basis of least total
 * length.  Its lengths do not depend on the order of circuits of equal length. */
#ifndef LW_GRAMMAR_TOPOLOGY_CIRCUIT_H
#define LW_GRAMMAR_TOPOLOGY_CIRCUIT_H

#include <stdbool.h>
#include <stdint.h>
#include "base/status.h"
#include "grammar/topology/chain.h"

#define LW_CHAIN_CIRCUIT_MAX (LW_JOINT_MAX)

/* Circuit k visits vertex[first[k]] .. vertex[first[k+1]-1] in turn, no vertex twice. */
typedef struct lw_chain_circuits {
    int     n_circuit;
    int     first[LW_CHAIN_CIRCUIT_MAX + 1];
    uint8_t vertex[LW_CHAIN_CIRCUIT_MAX*LW_LINK_MAX];
} lw_chain_circuits;

/* The circuits, shortest first; their number is L = e - v + (connected pieces).  adjacent: a bit mask for each
 * vertex, as in grammar/topology/planar.h.  The same masks give the same basis.  LW_E_ARG for more than LW_JOINT_MAX edges. */
lw_status lw_circuit_basis(int n, const uint32_t *adjacent, lw_chain_circuits *c);

/* Sets of edges as bits: add `row` to an echelon basis of *n_row rows (64 at most).  False when the row
 * depends on the basis. */
bool lw_gf2_add(uint64_t *row_of, int *n_row, uint64_t row);

#endif
