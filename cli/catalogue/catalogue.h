/* cli/catalogue/catalogue.h - the actions of the catalogue command, one file each, and what they share. */
#ifndef CLI_CATALOGUE_CATALOGUE_H
#define CLI_CATALOGUE_CATALOGUE_H

#include "catalogues/store/query.h"
#include "catalogues/store/store.h"
#include "cli/program/output.h"
#include "cli/program/progress.h"

typedef struct cli_catalogue_settings {
    double      time, wait, commit, min_transmission, length_range[2];
    bool        mpi, multiple, full_turn, disagreeing, no_pictures, sql, fields;
    int         links, dof, input, samples, curves, results, shape, list, format;
    const char *joints, *types, *columns, *sort, *part;
} cli_catalogue_settings;

/* Actions. Each gets the whole call, whose word[0] is its own name, and returns the exit code. */
int cli_catalogue_build(const cli_call *call);
int cli_catalogue_add(const cli_call *call);
int cli_catalogue_curves(const cli_call *call);
int cli_catalogue_nearest(const cli_call *call);
int cli_catalogue_query(const cli_call *call);
int cli_catalogue_export(const cli_call *call);
int cli_catalogue_check(const cli_call *call);
int cli_catalogue_html(const cli_call *call);
int cli_catalogue_release(const cli_call *call);

/* Make the folder `folder` (with `/under`, unless NULL), and check that it has no files with this ending that the command
 * may not write.  CLI_DONE, or the exit code after a message. */
int cli_catalogue_folder(const cli_call *call, const char *folder, const char *under, const char *ending);

/* Begin --time, if it is given.  Actions that read another file before the catalogue begin with it; `check` of a table does not:
 * there --time is how long the counts may take by their estimates. */
void cli_catalogue_limit(const cli_call *call);

/* Open the catalogue of word[1]; if `write`, create it if it does not exist. */
lw_status cli_catalogue_open(const cli_call *call, bool write, lw_store **store, lw_error *e);

/* Set o->list, unless it was chosen by --list, to the first list of at most `last` that has all fields of the question and
 * is not empty in this catalogue.  Without such a list it stays LW_LIST_ANY. */
lw_status cli_catalogue_list(const cli_call *call, const char *text, lw_query_list last, lw_query_options *o, lw_error *e);

/* Ctrl-C, --time (if given) and the progress line of an action that writes. */
typedef struct cli_catalogue_watch {
    cli_progress progress;
    double       start, limit, total;      /* wall time; limit [s], 0: none; number of items, 0: unknown */
    bool         over;                        /* --time has passed                                    */
} cli_catalogue_watch;

cli_catalogue_watch cli_catalogue_watch_begin(const cli_call *call, const char *what, const char *unit);
bool cli_catalogue_goes_on(cli_catalogue_watch *w, double done);
/* The exit code: CLI_LIMIT instead of CLI_DONE if --time ended the action. */
int  cli_catalogue_watch_end(cli_catalogue_watch *w, int code);

#endif
