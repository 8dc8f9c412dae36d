/* cli/bench/bench.h - the parts of `linkwright bench fit`: problems with published errors, runs that record a curve of
 * error over work, tables and plots. */
#ifndef CLI_BENCH_BENCH_H
#define CLI_BENCH_BENCH_H

#include "base/bytes.h"
#include "cli/program/output.h"
#include "optimise/search/fit.h"
#include "optimise/report/report.h"

#define CLI_PUBLISHED_MAX 6
#define CLI_WITHIN 1.01                  /* reached: within 1 % of the figure                       */

/* Published errors of a problem and those found before; in squared units of its file. */
typedef struct cli_bench_figures {
    const char *name, *file;             /* the file without folder and ".csv"                     */
    double      length[2], position[2];  /* bounds; both 0: none                                    */
    lw_datum    datum;
    bool        at_origin;               /* x0 = y0 = theta0 = 0                                    */
    struct { const char *who; double error; } published[CLI_PUBLISHED_MAX];
    double      reachable;               /* 0: unknown                                              */
} cli_bench_figures;

typedef struct cli_bench_problem {
    const cli_bench_figures *known;
    cli_bench_figures own;               /* for a file that is not in the table                    */
    char        name[64], path[CLI_PATH_SIZE];
    lw_target   target;
    lw_fit_spec spec;
} cli_bench_problem;

/* Load the problems of a folder: those of the table first, in its order, then other CSV files by name, fitted without
 * bounds. Free *p (*n) with _free. folder NULL: catalogues/data/paths, in the current folder or beside the program,
 * else where `make install` puts it. */
lw_status cli_bench_load(const char *folder, cli_bench_problem **p, int *n, lw_error *e);
void      cli_bench_free(cli_bench_problem *p, int n);

/* "error: sum of squared distances [mm^2]". */
void cli_bench_error_label(const cli_bench_problem *p, char *text, size_t size);

/* One improvement: the best error after this much work. */
typedef struct cli_bench_point { long evals; double seconds, error; } cli_bench_point;

typedef struct cli_bench_curve {
    const cli_bench_problem *problem;
    const char      *solver;             /* "default": the whole strategy; else a row of the solver table */
    uint64_t         seed;
    size_t           n, size;
    cli_bench_point *point;              /* (n), owned; the error decreases                         */
    bool             incomplete;         /* memory ran out                                          */
    /* default strategy: the least error of its linkages when independent code simulates them again; INFINITY: none */
    double           verified;
} cli_bench_curve;

double cli_bench_error(const cli_bench_curve *c);              /* the last one; INFINITY if none    */
/* Time at which the curve reached this error; NaN: never. */
double cli_bench_when(const cli_bench_curve *c, double error);

/* Extend a curve for `seconds`. solver NULL: the default strategy, which uses `jobs` threads and ends early once it is
 * at `enough` (0: it goes on). A local solver runs from the structured starts of that strategy, best first. A global
 * solver searches the box of each assembly mode in turn. */
lw_status cli_bench_run(const lw_solver *solver, double seconds, int jobs, double enough, cli_bench_curve *c, lw_error *e);

/* One run of the default strategy until it reaches the reachable error. */
typedef struct cli_bench_reach {
    uint64_t seed;
    bool     reached;
    /* seconds until the error was reached, else until the last improvement; error at the end, INFINITY: not verified */
    double   seconds, error;
    long     evals;
} cli_bench_reach;

typedef struct cli_bench {
    int                n_problem, n_curve, n_seed;
    cli_bench_problem *problem;
    int               *reach_done;       /* runs of each problem                      (n_problem)  */
    cli_bench_reach   *reach;            /* (n_problem*n_seed)                                      */
    cli_bench_curve   *curve;            /* (n_curve), problem after problem                        */
    double             seconds, limit;   /* limits of a curve, and of a run to the reachable error */
    int                jobs;
    char               machine[256];     /* compiler | processor | version                          */
} cli_bench;

void      cli_bench_machine(char *text, size_t size);
void      cli_bench_tables(const cli_bench *b, FILE *f);                       /* Markdown          */
/* Save curves.csv, reach.csv and a plot for each problem. */
lw_status cli_bench_save(const cli_bench *b, const char *line, const char *folder, lw_error *e);

/* Searches with increasing numbers of links. */
typedef struct cli_bench_links {
    int         links, jobs;
    long        budget;                  /* evaluations for each number of links                    */
    uint64_t    seed;
    const char *folder;                  /* NULL: none                                              */
    bool        both_ways;               /* paths without timing: compare target to curve and curve to target */
    struct cli_bench_outcome *outcome;   /* of each problem, made by _begin, owned                  */
} cli_bench_links;
/* Begin; search one problem; take its answer; end: the table goes to standard output, links.csv and plots into the
 * folder. */
lw_status cli_bench_links_begin(const cli_bench *b, cli_bench_links *o, lw_error *e);
lw_status cli_bench_links_one(const cli_bench_problem *p, const cli_bench_links *o, lw_bytes *answer, lw_error *e);
lw_status cli_bench_links_take(cli_bench_links *o, int problem, const char *answer, size_t size, lw_error *e);
lw_status cli_bench_links_end(const cli_bench *b, const cli_bench_links *o, lw_error *e);
void      cli_bench_links_free(cli_bench_links *o);

#endif
