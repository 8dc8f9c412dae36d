/* cli/bench/bench.h - the parts of `linkwright bench fit`: problems with known figures, runs that leave a
 * curve of error against work, and what is printed and drawn of them. */
#ifndef CLI_BENCH_BENCH_H
#define CLI_BENCH_BENCH_H

#include "cli/program/output.h"
#include "optimise/search/fit.h"
#include "optimise/report/report.h"

#define CLI_PUBLISHED_MAX 6
#define CLI_WITHIN 1.01                  /* reached: within 1 % of the figure                       */

/* What papers and earlier searches say about a problem; errors in squared units of its file. */
typedef struct cli_bench_figures {
    const char *name, *file;             /* the file without folder and ".csv"                     */
    double      length[2], position[2];  /* bounds; both 0: none                                    */
    lw_datum    datum;
    bool        at_origin;               /* x0 = y0 = theta0 = 0                                    */
    struct { const char *who; double error; } published[CLI_PUBLISHED_MAX];
    double      reachable;               /* 0: unknown                                              */
    const char *note;                    /* NULL, or what to know about it                          */
} cli_bench_figures;

typedef struct cli_bench_problem {
    const cli_bench_figures *known;
    cli_bench_figures own;               /* for a file that is not in the table                    */
    char        name[64];
    lw_target   target;
    lw_fit_spec spec;
} cli_bench_problem;

/* Problems of a folder: those of the table first, in its order, then other CSV files by name, fitted
 * without bounds.  *p (*n) is freed with _free.  folder NULL: catalogues/data/paths, here or beside the
 * program, else where `make install` puts it. */
lw_status cli_bench_load(const char *folder, cli_bench_problem **p, int *n, lw_error *e);
void      cli_bench_free(cli_bench_problem *p, int n);

/* One improvement: the best error so far after so much work. */
typedef struct cli_bench_point { long evals; double seconds, error; } cli_bench_point;

typedef struct cli_bench_curve {
    const cli_bench_problem *problem;
    const char      *solver;             /* "default": the whole strategy; else a row of the table */
    uint64_t         seed;
    size_t           n, size;
    cli_bench_point *point;              /* (n), owned; error falls                                 */
    bool             incomplete;         /* memory ran out                                          */
    double           verified;           /* default strategy: the least error of its linkages as simulated
                                          * again by independent code; INFINITY: none               */
} cli_bench_curve;

double cli_bench_error(const cli_bench_curve *c);              /* the last one; INFINITY if none    */
/* When the curve came to this error; NAN if never. */
double cli_bench_when(const cli_bench_curve *c, double error);

/* Add to a curve for so many seconds.  `solver` NULL is the default strategy, which uses `jobs` threads
 * and ends early once it is at `enough` (0: goes on); a local row runs from the structured starts of
 * that strategy, best first; a global row searches the box of each assembly mode in turn. */
lw_status cli_bench_run(const lw_solver *solver, double seconds, int jobs, double enough,
                        cli_bench_curve *c, lw_error *e);

/* One run of the default strategy towards the reachable figure. */
typedef struct cli_bench_reach {
    uint64_t seed;
    bool     reached;
    double   seconds, error;             /* until it was reached, else until nothing got better; at
                                          * its end, INFINITY when it could not be verified         */
    long     evals;
} cli_bench_reach;

typedef struct cli_bench {
    int                n_problem, n_curve, n_seed;
    cli_bench_problem *problem;
    int               *reach_done;       /* runs of each problem                      (n_problem)  */
    cli_bench_reach   *reach;            /* (n_problem*n_seed)                                      */
    cli_bench_curve   *curve;            /* (n_curve), problem after problem                        */
    double             seconds, limit;   /* of a curve, of a run to the figure                     */
    int                jobs;
    char               machine[256];     /* compiler | processor | version                          */
} cli_bench;

/* The figure a problem is held against: the reachable one, else the least error of this bench. */
double cli_bench_figure(const cli_bench *b, const cli_bench_problem *p);

void      cli_bench_machine(char *text, size_t size);
void      cli_bench_tables(const cli_bench *b, FILE *f);                       /* Markdown          */
/* curves.csv, reach.csv and a plot for each problem. */
lw_status cli_bench_save(const cli_bench *b, const char *line, const char *folder, lw_error *e);

/* Searches with up to so many links; the table goes to standard output, links.csv and plots into the folder. */
typedef struct cli_bench_links {
    int         links, jobs;
    long        budget;                  /* evaluations a number of links                           */
    uint64_t    seed;
    const char *folder;                  /* NULL: none                                              */
    bool        both_ways;               /* untimed paths: target to curve and curve to target      */
} cli_bench_links;
lw_status cli_bench_links_run(const cli_call *call, const cli_bench *b, const cli_bench_links *o, lw_error *e);

#endif
