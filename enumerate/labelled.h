/* enumerate/labelled.h - numbers of labelled chains from generating functions, without making any chain: a second
 * opinion on every enumeration.
 *
 * A labelled chain has links named 1 .. P, so a chain counts P!/|automorphisms| times.
 *
 * Identity.  Let f(S) = 3(|S| - 1) - 2 e(S) for a set S of vertices of a simple graph.  S is rigid if each edge taken
 * twice, S contains three disjoint spanning trees (|S| = 1 is rigid); by Tutte and Nash-Williams: if for every partition
 * of S into k sets 2(edges between sets) >= 3(k - 1).  Rigid sets that share a vertex or are joined by two edges have a
 * rigid union, so the maximal ones partition the vertices, with at most one edge between any two.  Contracting each of
 * them gives a simple graph H without rigid set of two or more vertices.  Conversely, replace each vertex of such an H by
 * any rigid graph and join each edge of H to any vertex of it: the maximal rigid sets are the graphs put in, because a
 * rigid set stays rigid when parts of it are contracted.  So each graph comes from one H in one way.  And H has no rigid
 * set exactly if f(S) >= 1 for every |S| >= 2: a smallest S with f(S) <= 0 satisfies the condition for each partition,
 * as every part T of it with |T| >= 2 has f(T) >= 1.  These H are the connected chains; their blocks (maximal 2-connected
 * parts, or a single edge) are chains too, and f is the sum of that of the blocks.
 *
 * Generating functions.  z_d marks a vertex of degree d, D is the derivation z_d -> z_{d+1} (one more edge at some vertex),
 * R(z) the rigid graphs with two or more vertices, B(z) the 2-connected chains, all exponential in the number of
 * vertices.  A vertex of degree d of H stands for w_d = z_d + D^d R, and the connected graphs G with degrees >= 2 (z_0 =
 * z_1 = 0) satisfy, with T = sum of n d/dn (number of vertices),
 *
 *     T G = sum over d of (T w_d) e_d,          sum e_d u^d = exp(sum b_j u^j),
 *     b_1 = y_1,  b_j = dB/dz_j (y_2, y_3, ...),     y_j = sum over d of w_{j+d} e_d
 *
 * where e_d are the ways to put blocks with d edges at a vertex of H and y_j is a vertex with j edges in one block, with
 * all that hangs from it.  With L loops the unknown parts of B and R enter as B_L and R_L only, and 2-connected chains
 * with L loops have 2L + 2 or more vertices, rigid graphs 2L + 1 or fewer.  So G determines both, level by level.  G
 * follows from the numbers of simple graphs with given degrees.
 *
 * Everything is computed modulo three primes; two give the number, the third confirms it. */
#ifndef LW_ENUMERATE_LABELLED_H
#define LW_ENUMERATE_LABELLED_H

#include "enumerate/chains.h"

/* The labelled chains of each assortment, not fractionated: n_labelled of the rows and of the total; the other numbers
 * are 0.  numbers->n2 = 0.  20 links of F = 1: some seconds.  LW_E_ARG: dof < 1, n2 > 0, or more than 5e36; LW_E_MEMORY. */
lw_status lw_labelled_chains(const lw_numbers *numbers, lw_chain_table *table, lw_error *e);

/* The chains of each assortment from the sum of the tables that lw_chains_count made of parts with the filter "generating":
 * (labelled chains + n_labelled)/P!.  Fills n_chain.  LW_E_KIND if the division leaves a rest; else as above. */
lw_status lw_labelled_complete(const lw_numbers *numbers, lw_chain_table *table, lw_error *e);

#endif
