/* grammar/topology/graph6.h - chains as graph6 lines, the format that nauty's tools read and write (McKay,
 * "Description of graph6, sparse6 and digraph6 encodings").
 *
 * A chain of joints of one freedom is one graph6 word.  With joints of two freedoms it is two words
 * separated by a blank: all joints, then the joints of two freedoms. */
#ifndef LW_GRAMMAR_TOPOLOGY_GRAPH6_H
#define LW_GRAMMAR_TOPOLOGY_GRAPH6_H

#include <stddef.h>
#include "grammar/topology/chain.h"

/* Room for the longest chain with its terminator: two words of 1 + 83 bytes. */
#define LW_GRAPH6_SIZE 176

/* Write the chain; returns the length without terminator, as snprintf does.  No line end. */
size_t lw_graph6_print(const lw_chain *c, char *buf, size_t size);

/* Read one line, with or without its line end and an optional ">>graph6<<" in front.  Any graph
 * is accepted; lw_chain_check tests whether it is a chain that moves.  LW_E_NOTATION with the column;
 * lines count from 1 at text.  At most LW_LINK_MAX links. */
lw_status lw_graph6_read(const char *text, size_t size, const char *file, lw_chain *c, lw_error *e);

#endif
