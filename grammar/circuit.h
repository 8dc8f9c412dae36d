/* grammar/circuit.h - a shortest cycle basis of a graph: the circuits of a chain that has no drawing
 * in the plane, and the loops by which an Assur group is classed.
 *
 * Horton 1987: among the circuits "shortest path v-x, edge xy, shortest path y-v", taken by rising
 * length, the independent ones are a basis of least total length.  The lengths of such a basis do
 * not depend on the choice made among equals. */
#ifndef LW_GRAMMAR_CIRCUIT_H
#define LW_GRAMMAR_CIRCUIT_H

#include <stdbool.h>
#include <stdint.h>
#include "base/status.h"
#include "grammar/linkage.h"

#define LW_CHAIN_CIRCUIT_MAX (LW_JOINT_MAX)

/* Circuit k visits vertex[first[k]] .. vertex[first[k+1]-1] in turn, no vertex twice. */
typedef struct lw_chain_circuits {
    int     n_circuit;
    int     first[LW_CHAIN_CIRCUIT_MAX + 1];
    uint8_t vertex[LW_CHAIN_CIRCUIT_MAX*LW_LINK_MAX];
} lw_chain_circuits;

/* Circuits by rising length, L = e - v + (pieces) of them.  adjacent: a bit mask per vertex, as in
 * grammar/planar.h.  The same masks give the same basis.  LW_E_ARG for more than LW_JOINT_MAX edges. */
lw_status lw_circuit_basis(int n, const uint32_t *adjacent, lw_chain_circuits *c);

/* Sets of edges as bits: add `row` to an echelon basis of *n_row rows (64 at most); false when it
 * depends on them. */
bool lw_gf2_add(uint64_t *row_of, int *n_row, uint64_t row);

#endif
