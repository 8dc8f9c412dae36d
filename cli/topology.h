/* cli/topology.h - reading chains and mechanisms from a file or standard input in any notation, and
 * writing them in the notation that --format names. */
#ifndef LW_CLI_TOPOLOGY_H
#define LW_CLI_TOPOLOGY_H

#include <stdio.h>
#include "cli/output.h"
#include "grammar/notation.h"

/* A row of an option table for a CLI_CHOICE member that says the notation; the choices are the rows of
 * lw_notations, in their order. */
#define CLI_FORMAT_ROW(settings, member, fallback) \
    { "format", 'f', CLI_CHOICE, offsetof(settings, member), \
      "graph6|lam|sentence|franke|edges|json|dot|graphml", fallback, "notation of what is printed", \
      0, 0, NULL, NULL }

/* Called for each topology; text is the piece of input it came from. */
typedef lw_status cli_topology_visit(void *context, const lw_mechanism *m, lw_error *e);

/* Read what `file` holds, "-" or NULL is standard input.  The first fault of input, or fault that visit
 * reports, is printed with its place and ends the reading, unless keep_going.  Returns the exit code. */
int cli_topologies_each(const cli_call *call, const char *file, bool keep_going, cli_topology_visit *visit,
                        void *context);

/* Write m and the end of its line; an empty line after notations of several lines. */
lw_status cli_topology_write(FILE *f, const lw_notation *n, const lw_mechanism *m, lw_error *e);

#endif
