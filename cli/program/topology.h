/* cli/program/topology.h - read chains and mechanisms in any notation from a file or standard input, and write them in
 * the notation of --format. */
#ifndef CLI_PROGRAM_TOPOLOGY_H
#define CLI_PROGRAM_TOPOLOGY_H

#include <stdio.h>
#include "cli/program/output.h"
#include "cli/program/progress.h"
#include "grammar/topology/notation.h"

/* A row of an option table for a CLI_CHOICE member that chooses the notation; the choices are the rows of lw_notations,
 * in their order. */
#define CLI_FORMAT_ROW(settings, member, fallback, actions) \
    { "format", 'f', CLI_CHOICE, offsetof(settings, member), \
      "graph6|lam|sentence|franke|edges|json|dot|graphml", fallback, actions "notation of the topologies that are printed", \
      0, 0, NULL, NULL }

/* Ctrl-C, --time and the progress line of a listing. */
typedef struct cli_watch {
    const cli_call *call;
    cli_progress    progress;
    double          start;            /* clock [s]                          */
    bool            over;             /* --time has passed                  */
} cli_watch;

cli_watch cli_watch_begin(const cli_call *call, const char *what, const char *unit);
/* Show `done` items. False: the listing must stop. */
bool cli_watch_goes_on(cli_watch *w, double done);
/* The exit code: CLI_LIMIT instead of CLI_DONE and CLI_NOTHING if --time ended the listing. */
int cli_watch_end(cli_watch *w, int code);

/* Called for each topology; LW_STOPPED ends the reading without an error. */
typedef lw_status cli_topology_visit(void *context, const lw_mechanism *m, lw_error *e);

/* Read all topologies in `file`; "-" or NULL is standard input. The first error of the input, or of visit, is printed
 * with its place and ends the reading, unless keep_going. Returns the exit code. */
int cli_topologies_each(const cli_call *call, const char *file, bool keep_going, cli_topology_visit *visit, void *context);

/* Write m and a line end; after a notation of several lines also an empty line. The first time that the notation leaves
 * out something of m, a note says what. */
lw_status cli_topology_write(const cli_call *call, FILE *f, const lw_notation *n, const lw_mechanism *m, lw_error *e);

#endif
