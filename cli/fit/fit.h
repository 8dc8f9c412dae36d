/* cli/fit/fit.h - the parts of the fit command: the results for one target, printed and drawn. */
#ifndef CLI_FIT_FIT_H
#define CLI_FIT_FIT_H

#include "catalogues/pages/fit_page.h"
#include "cli/program/json.h"
#include "cli/program/output.h"
#include "optimise/task/task_file.h"
#include "optimise/precision/exact.h"
#include "optimise/report/robustness.h"
#include "optimise/topology/topology_search.h"

/* Linkages from which a search starts. */
typedef struct cli_fit_start {
    int         n;
    lw_linkage *linkage;           /* (n) owned */
} cli_fit_start;

#define CLI_FIT_NAME_SIZE 256     /* of the last part of a path: NAME_MAX + 1                       */

/* One target with its ranked, verified results. */
typedef struct cli_fit_set {
    const char *path;             /* of the target's file                                          */
    char        name[CLI_FIT_NAME_SIZE];   /* its last part without ".csv"                         */
    lw_target   target;
    lw_fit_spec spec;
    bool        has_task_file;        /* the target is a task file                                     */
    lw_task_file    task_file;
    cli_fit_start start;
    lw_topology_search search;    /* with --exact only candidates and results, which come from ... */
    bool        is_exact;
    lw_exact    exact;            /* ... these precision points                                    */
    double      seconds;          /* its part of --time; 0: no limit                               */
    uint64_t    seed;
    bool        has_tolerances;   /* --tolerances                                                  */
} cli_fit_set;

/* Ranked table, lengths in the unit of the target. */
void cli_fit_table(const cli_fit_set *s, FILE *f);

/* The JSON object of docs/notation.md, "Results of a fit". */
void cli_fit_json(const cli_fit_set *s, const cli_call *call, FILE *f, int indent);

/* The name of a target's results in --save: its file name without folder and ending, "target" for standard input. */
void cli_fit_name(const char *path, char *name, size_t size);

/* Before the search: make the folder, and check for each file that may go into it (at most `results` for each target)
 * that it may be written. Returns the exit code, CLI_DONE if all is well. */
int cli_fit_check_folder(const cli_call *call, const char *folder, int results);

/* Write the linkages of all results and a drawing of the best one into a folder (quick), then its PNG and animation, which
 * take longer; and one page for all targets. */
lw_status cli_fit_save(const cli_fit_set *s, const char *folder, bool quick, lw_error *e);
lw_status cli_fit_page(const cli_fit_set *s, int n_set, const char *folder, lw_error *e);

/* --exact (fit_exact.c): find linkages through all stations instead of the best ones; then print as for a fit, with
 * their defects. */
lw_status cli_fit_exact(const cli_call *call, cli_fit_set *s, const lw_fit_options *o, lw_error *e);
lw_status cli_fit_exact_verify(const cli_call *call, cli_fit_set *s, lw_error *e);
void      cli_fit_exact_row(const cli_fit_set *s, int i, FILE *f);
void      cli_fit_exact_summary(const cli_fit_set *s, FILE *f);
void      cli_fit_exact_json_row(const cli_fit_set *s, int i, cli_json *j);
void      cli_fit_exact_json(const cli_fit_set *s, cli_json *j);
/* Has the task finitely many solutions, and may some be missing? */
bool      cli_fit_may_miss(const cli_fit_set *s);

/* Further points of the target (fit_print.c): read "coupler,any" as the links on which they lie; print lines below a
 * row of the table; print a member of its JSON object. */
lw_status cli_fit_carriers(const char *text, const lw_target *t, lw_carrier carrier[LW_ALSO_MAX], lw_error *e);
void cli_fit_points_summary(const cli_fit_set *s, FILE *f);
void cli_fit_points_row(const cli_fit_set *s, int i, FILE *f);
void cli_fit_points_json(const cli_fit_set *s, int i, cli_json *j);

/* Add the linkages of a file that cli_read_model accepts, all results in it (fit_start.c). */
lw_status cli_fit_start_read(const char *path, cli_fit_start *s, lw_error *e);


/* For the plot and the page. */
lw_fitted cli_fitted(const cli_fit_set *s);

#endif
