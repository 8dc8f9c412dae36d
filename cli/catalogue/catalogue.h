/* cli/catalogue/catalogue.h - the actions of the catalogue command, one file each, and what they share. */
#ifndef CLI_CATALOGUE_CATALOGUE_H
#define CLI_CATALOGUE_CATALOGUE_H

#include "catalogues/store/store.h"
#include "cli/program/output.h"
#include "cli/program/progress.h"

typedef struct cli_catalogue_settings {
    double      time, wait, commit;
    bool        disagreeing, no_pictures, sql, fields;
    int         links, dof, input, samples, curves, results, shape, list, format;
    const char *joints, *types, *columns, *sort;
} cli_catalogue_settings;

/* Each gets the whole call; word[0] is its own name.  They return the exit code. */
int cli_catalogue_build(const cli_call *call);
int cli_catalogue_add(const cli_call *call);
int cli_catalogue_curves(const cli_call *call);
int cli_catalogue_nearest(const cli_call *call);
int cli_catalogue_query(const cli_call *call);
int cli_catalogue_export(const cli_call *call);
int cli_catalogue_check(const cli_call *call);
int cli_catalogue_html(const cli_call *call);

/* word[1] of the call, opened; `write` also makes it when there is none. */
lw_status cli_catalogue_open(const cli_call *call, bool write, lw_store **store, lw_error *e);

/* Ctrl-C, --time (when it was given) and the progress line of an action that writes. */
typedef struct cli_catalogue_watch {
    const cli_call *call;
    cli_progress    progress;
    double          start, limit, total;      /* clock; [s], 0: none; of what is counted, 0: unknown  */
    bool            over;                     /* --time has passed                                    */
} cli_catalogue_watch;

cli_catalogue_watch cli_catalogue_watch_begin(const cli_call *call, const char *what, const char *unit);
bool cli_catalogue_goes_on(cli_catalogue_watch *w, double done);
/* The exit code: CLI_LIMIT in place of CLI_DONE when --time ended it. */
int  cli_catalogue_watch_end(cli_catalogue_watch *w, int code);

#endif
