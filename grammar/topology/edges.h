/* grammar/topology/edges.h - a topology as a list of joints on one line, and for other programs.
 *
 *     1-2 1-4 2-3 3-4:p            a joint r needs no letter; t, p and g follow a colon
 *     1-2! 1-4 2-3 3-4 @1 >3       '!' a driven joint, '@' the ground link, '>' the output link
 *
 * Links count from 1.  The number of links is the highest that is named. */
#ifndef LW_GRAMMAR_TOPOLOGY_EDGES_H
#define LW_GRAMMAR_TOPOLOGY_EDGES_H

#include <stddef.h>
#include "grammar/topology/mechanism.h"

#define LW_EDGES_SIZE   (LW_JOINT_MAX*10 + 16)
#define LW_DOT_SIZE     8192
#define LW_GRAPHML_SIZE 16384

/* One line without line end; returns the length as snprintf does. */
size_t lw_edges_print(const lw_mechanism *m, char *buf, size_t size);

/* Read one line.  LW_E_NOTATION with the column: a link joined to itself, two links joined twice, an
 * unknown joint kind, a link number without joints, more than LW_JOINT_MAX joints. */
lw_status lw_edges_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e);

/* The graph for Graphviz (`dot`, `neato`); the ground link is a double circle, the output bold.  name
 * follows the word "graph"; it must be an identifier. */
size_t lw_dot_print(const lw_mechanism *m, const char *name, char *buf, size_t size);

/* A whole GraphML document with data keys kind, driven, ground and output. */
size_t lw_graphml_print(const lw_mechanism *m, char *buf, size_t size);

/* Read them: what lw_dot_print and lw_graphml_print write, and undirected graphs of other programs, whose labels and
 * keys are left out.  If the nodes are named 1 .. n or 0 .. n - 1, their names are the links, else links are numbered in
 * the order in which nodes appear.  DOT: no subgraphs.  LW_E_NOTATION with line and column. */
lw_status lw_dot_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e);
lw_status lw_graphml_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e);

#endif
