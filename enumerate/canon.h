/* enumerate/canon.h - canonical form and symmetry of small coloured graphs.
 *
 * Chains and structures have one common form: vertices with a colour, and a tie (0 none, 1 .. 255) between any
 * two.  A tie of a chain is the number of freedoms of the joint; a tie of a structure is the number of parallel
 * lines.  Two graphs are isomorphic exactly when their canonical forms are equal.
 *
 * Method: colour refinement with 64-bit colours, first from the neighbourhood of each vertex, then with one vertex
 * after the other singled out.  If all vertices get different colours, as in nearly every graph without symmetry,
 * sorting the colours gives the canonical labelling, and the group is trivial.  Otherwise BLISS (Junttila & Kaski
 * 2007) is called through igraph; a collision of colours has no other effect than this call.  igraph is not
 * thread-safe, so a lock admits one call at a time.  Under the same lock its error handler is replaced by one that
 * returns, and restored afterwards. */
#ifndef LW_ENUMERATE_CANON_H
#define LW_ENUMERATE_CANON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "base/error.h"
#include "grammar/topology/chain.h"
#include "grammar/topology/structure.h"

#define LW_GRAPH_MAX LW_LINK_MAX

typedef struct lw_graph {
    int     n;                                 /* vertices, 1 .. LW_GRAPH_MAX     */
    uint8_t colour[LW_GRAPH_MAX];
    uint8_t tie[LW_GRAPH_MAX][LW_GRAPH_MAX];   /* symmetric, diagonal 0           */
} lw_graph;

/* Links with colour 0, ties = freedoms of the joint; circles, ties = number of parallel lines. */
void lw_graph_of_chain(const lw_chain *c, lw_graph *g);
void lw_graph_of_structure(const lw_structure *s, lw_graph *g);

/* Colours that do not depend on the numbering.  Vertices of one orbit have equal colours; the converse need not hold.
 * colour (g->n). */
void lw_graph_refine(const lw_graph *g, uint64_t *colour);

/* Canonical labelling: vertex i has place to[i] in the canonical form.  to (g->n).
 * LW_E_MEMORY; LW_E_IO: igraph, which is loaded when it is first needed, is not installed. */
lw_status lw_graph_label(const lw_graph *g, uint8_t *to);

/* Unless e holds a message, tell in it what a status of these functions, or of what is built on them, means; returns s.
 * LW_E_IO is igraph that is not installed: which package to install. */
lw_status lw_graph_error(lw_error *e, lw_status s);

/* The canonical form itself, for chains and for structures. */
lw_status lw_chain_canonical(const lw_chain *c, lw_chain *form);
lw_status lw_structure_canonical(const lw_structure *s, lw_structure *form);

/* The automorphism group.  p is a permutation: vertex i goes to p[i]. */
typedef struct lw_symmetry_group {
    int     n;                                    /* vertices                                       */
    int     n_generator;                          /* 0 for the trivial group                        */
    uint8_t (*generator)[LW_GRAPH_MAX];           /* (n_generator) owned, see lw_symmetry_group_free         */
    uint8_t orbit[LW_GRAPH_MAX];                  /* lowest vertex of the orbit of each vertex      */
} lw_symmetry_group;

lw_status lw_graph_group(const lw_graph *g, lw_symmetry_group *group);
void      lw_symmetry_group_free(lw_symmetry_group *group);

/* All elements, the identity first.  *element is allocated, free with free(); *n at least 1.
 * LW_E_MEMORY also when there are more than 2^24. */
lw_status lw_symmetry_group_elements(const lw_symmetry_group *group, uint8_t (**element)[LW_GRAPH_MAX], size_t *n);

/* Of the group of a graph: the lowest vertex of the orbit of each vertex (n; NULL: not wanted), and its order (NULL: not wanted).
 * LW_E_MEMORY also for an order above 2^24, if it is wanted. */
lw_status lw_graph_symmetry(const lw_graph *g, uint8_t *lowest, uint64_t *order);

/* All elements of the group of a graph, as lw_symmetry_group_elements. */
lw_status lw_graph_elements(const lw_graph *g, uint8_t (**element)[LW_GRAPH_MAX], size_t *n);

#endif
