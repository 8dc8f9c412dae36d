/* cli/fit/fit.h - the parts of the fit command: what was found for one target, printed and drawn. */
#ifndef CLI_FIT_FIT_H
#define CLI_FIT_FIT_H

#include "cli/program/json.h"
#include "cli/program/output.h"
#include "optimise/task/task_file.h"
#include "optimise/precision/exact.h"
#include "optimise/topology/topology_search.h"

/* Linkages to start from. */
typedef struct cli_fit_start {
    int         n;
    lw_linkage *linkage;           /* (n) owned */
} cli_fit_start;

/* One target with its ranked, verified results. */
typedef struct cli_fit_set {
    const char *path;             /* of the target's file                                          */
    char        name[64];         /* its last part without ".csv"                                  */
    lw_target   target;
    lw_fit_spec spec;
    bool        has_task_file;        /* the target is a task file                                     */
    lw_task_file    task_file;
    cli_fit_start start;
    lw_topology_search search;    /* with --exact only its candidates and results, which are those of ... */
    bool        is_exact;
    lw_exact    exact;            /* ... these precision points                                    */
    uint64_t    seed;
} cli_fit_set;

/* Ranked table, lengths in the unit of the target. */
void cli_fit_table(const cli_fit_set *s, FILE *f);

/* Is the four-bar so near a change point that small errors of its lengths change its class?  false without a class. */
bool cli_fit_near_change_point(const lw_fit_report *r);

/* The JSON object of docs/notation.md, "Results of a fit". */
void cli_fit_json(const cli_fit_set *s, const cli_call *call, FILE *f, int indent);

/* The name of a target's results in --save: its file name without folder and ending, "target" for standard input. */
void cli_fit_name(const char *path, char *name, size_t size);

/* Before the search: make the folder, and ask for each file that may go into it whether it may be written there.
 * `results` at most for each target.  The exit code, CLI_DONE when all is well. */
int cli_fit_check_folder(const cli_call *call, const char *folder, int results);

/* Pictures of the best result and linkages of all into a folder; and one page for all targets. */
lw_status cli_fit_save(const cli_fit_set *s, const char *folder, lw_error *e);
lw_status cli_fit_page(const cli_fit_set *s, int n_set, const char *folder, lw_error *e);

/* --exact (fit_exact.c): linkages through all stations instead of the best ones; then as a fit, with what is said
 * of their defects. */
lw_status cli_fit_exact(const cli_call *call, cli_fit_set *s, const lw_fit_options *o, lw_error *e);
lw_status cli_fit_exact_verify(const cli_call *call, cli_fit_set *s, lw_error *e);
void      cli_fit_exact_row(const cli_fit_set *s, int i, FILE *f);
void      cli_fit_exact_summary(const cli_fit_set *s, FILE *f);
void      cli_fit_exact_json_row(const cli_fit_set *s, int i, cli_json *j);
void      cli_fit_exact_json(const cli_fit_set *s, cli_json *j);

/* Further points of the target (fit_print.c): "coupler,any" to the links that they lie on; lines below a row of the
 * table; a member of its JSON object. */
lw_status cli_fit_carriers(const char *text, const lw_target *t, lw_carrier carrier[LW_ALSO_MAX], lw_error *e);
void cli_fit_points_summary(const cli_fit_set *s, FILE *f);
void cli_fit_points_row(const cli_fit_set *s, int i, FILE *f);
void cli_fit_points_json(const cli_fit_set *s, int i, cli_json *j);

/* Add the linkages of a file as cli_read_linkage takes it, all results of it (fit_start.c). */
lw_status cli_fit_start_read(const char *path, cli_fit_start *s, lw_error *e);

/* Add the linkages of a catalogue, with so many links at most, whose curves are nearest to a target with points. */
lw_status cli_fit_start_nearest(const char *path, const lw_target *t, int links, cli_fit_start *s, lw_error *e);

/* Candidate of result i. */
const lw_candidate *cli_fit_candidate(const cli_fit_set *s, int i);

/* Value of a dimension in the user's unit: angles in radians. */
double cli_fit_value(const cli_fit_set *s, const lw_fit_report *r, int dim, double si);

#endif
