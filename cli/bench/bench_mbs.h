/* cli/bench/bench_mbs.h - the parts of `linkwright bench mbs`: reference problems of multibody dynamics, one row for
 * each solver and tolerance, other programs' solvers in the same run, tables and plots. */
#ifndef CLI_BENCH_BENCH_MBS_H
#define CLI_BENCH_BENCH_MBS_H

#include "cli/program/output.h"

struct lw_model;
struct lw_spatial;
struct lw_dynamics_report;
struct lw_dynamics_options;

/* Result of one solver at one tolerance (other programs: accuracy, or step size in s). */
typedef struct cli_mbs_row {
    const char *problem;
    char        solver[40];
    double      tolerance;
    double      make, seconds;         /* processor time of set-up and of the run, best of several; NAN: not measured */
    double      error;                   /* greatest error against the reference; NAN: none            */
    double      off;                     /* distance from the right assembly mode [m]; NAN: none       */
    double      energy;                  /* greatest error of the energy over its scale; NAN: unknown   */
    double      known;                   /* of a hard case: what its two references differ by, 0: one; NAN: no hard case */
    long        steps, rates;
    char        note[160];               /* why it failed; "": it did not                              */
} cli_mbs_row;

/* Positions of the bodies at each moment: x, y of the centre of mass [m], angle [rad]; place[3*(k*n_body + b)]. */
typedef struct cli_mbs_motion { int n_moment, n_body; double *place; } cli_mbs_motion;

/* A file of numbers: value[k*n_column + c]. */
typedef struct cli_mbs_reference { int n_row, n_column; double *value; } cli_mbs_reference;

typedef struct cli_mbs_problem {
    const char *name, *title, *error;    /* error: what is measured, with its unit                     */
    const char *file;                    /* model and reference of catalogues/data/mbs; NULL: not of this kind */
    double      to;                      /* [s]                                                        */
    int         implicit;                /* tightest tolerance of implicit methods, 1e-implicit        */
    double    (*measure)(const cli_mbs_motion *m, const cli_mbs_reference *r, double *off);
    int         n_loop;                  /* > 0: a row of so many four-bars instead of the model of the file;
                                            -1: the torques of three drives along a cycle instead of a run */
} cli_mbs_problem;

#define CLI_MBS_TOO_SLOW  1.0             /* [s] for a run: the solver gets no tighter tolerances        */
#define CLI_MBS_PEER_TIME 300.0           /* [s] for all rows of another program on one problem         */
#define CLI_MBS_PEER_MAX  8

extern const cli_mbs_problem cli_mbs_problems[];       /* name NULL ends                                */

typedef struct cli_mbs {
    const cli_call *call;
    double          time;                /* for repeating one row [s]                                   */
    int             loosest, tightest;   /* tolerances 1e-loosest to 1e-tightest                       */
    uint64_t        wanted;              /* bit i: problem i                                            */
    int             n, capacity;
    cli_mbs_row    *row;                 /* owned                                                      */
    char            machine[256];        /* compiler | processor | version                             */
    int             n_peer;
    char            peer[CLI_MBS_PEER_MAX][640];   /* paths of other programs                          */
} cli_mbs;

/* Add a row without results. NULL: out of memory. */
cli_mbs_row *cli_mbs_add(cli_mbs *b, const char *problem, const char *solver, double tolerance);

/* LW_STOPPED: the formulation that was asked for gave up, and another one went on. */
lw_status cli_mbs_own(const struct lw_dynamics_report *r, const struct lw_dynamics_options *o, lw_error *e);

/* The text of NAME.ENDING in catalogues/data/mbs, to be freed, and its path (CLI_PATH_SIZE). */
lw_status cli_mbs_read(const char *name, const char *ending, char *path, char **text, size_t *size, lw_error *e);

/* Find the other programs in a folder. folder "none": no programs; NULL: the folder "peers" beside linkwright, if it
 * exists. */
lw_status cli_mbs_find_peers(cli_mbs *b, const char *folder, lw_error *e);

/* Add the rows of the other programs for one problem. A program that fails or prints nothing valid gets a row that says
 * so. LW_E_KIND: the model has elements that cannot be passed to other programs. */
lw_status cli_mbs_peers(cli_mbs *b, const cli_mbs_problem *p, const struct lw_model *m, const cli_mbs_reference *r, lw_error *e);

/* A cycle of a model whose inputs leave no freedom: turns, rates and accelerations of three drives at each moment. */
enum { CLI_MBS_POSTURES = 101 };
typedef struct cli_mbs_cycle { double at[CLI_MBS_POSTURES][3][3]; } cli_mbs_cycle;

/* The same for a problem in space; answers are places of its first tracer, with a cycle the torques of its drives. */
lw_status cli_mbs_peers_space(cli_mbs *b, const cli_mbs_problem *p, const struct lw_spatial *m, const cli_mbs_cycle *cycle,
                              const cli_mbs_reference *r, lw_error *e);

/* Add the rows of a problem in space; n_loop > 0: a chain of so many bars instead of a model of the data. */
lw_status cli_mbs_space(cli_mbs *b, const cli_mbs_problem *p, lw_error *e);

/* Add rows of models of every kind by every formulation, print how much slower than the fastest `auto` is, and save the plot of the
 * hard cases.  `choice:TEXT` in cases takes the models with TEXT in their name, `choice:hard` the hard cases too, `choice`
 * all.  LW_E_ARG: no model has the text. */
lw_status cli_mbs_choice(cli_mbs *b, const char *cases, const char *folder, lw_error *e);

/* Run the whole benchmark. folder NULL: write no files. cases NULL: all problems. LW_E_ARG: unknown problem in
 * `cases`. */
lw_status cli_mbs_run(cli_mbs *b, const char *cases, const char *folder, lw_error *e);
void      cli_mbs_free(cli_mbs *b);

void      cli_mbs_tables(const cli_mbs *b, FILE *f);                       /* Markdown                  */
lw_status cli_mbs_save(const cli_mbs *b, const char *folder, lw_error *e);   /* mbs.csv, mbs-<problem>.svg */

#endif
