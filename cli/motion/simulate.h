/* cli/motion/simulate.h - print a run as rows of named columns: CSV, JSON, plots, frames of a GIF. */
#ifndef CLI_MOTION_SIMULATE_H
#define CLI_MOTION_SIMULATE_H

#include "cli/motion/dynamics_report.h"
#include "cli/motion/table.h"
#include "cli/program/json.h"
#include "mbs/analysis/reactions.h"

typedef struct cli_simulate {
    const cli_call *call;
    lw_model       *model;
    lw_dynamics_options options;
    lw_dynamics    *d;
    FILE           *f;                   /* where rows are written; NULL: nowhere                      */
    bool            json, keep;          /* keep: rows and postures stay in memory                         */
    cli_json        j;
    int             n_column;
    cli_column     *column;
    double         *scratch;             /* one row, then series of the links and reactions             */
    lw_inner_force *inner;               /* of the nodes of one elastic link                               */
    size_t          n_row, capacity;
    double         *row;                 /* (capacity * n_column)                                          */
    double         *q;                   /* (capacity * n_q)                                               */
    lw_dynamics_report       report;
    cli_suction     suction;
    cli_pull        pull;
} cli_simulate;

/* Drive the inputs without a motion at this constant speed, as --speed gives it; NULL: none. */
lw_status cli_simulate_speed(lw_model *m, const char *speed, const char *file, lw_error *e);

/* Make the equations of s->model and name its columns. */
lw_status cli_simulate_make(cli_simulate *s, const lw_dynamics_options *o, const char *file, lw_error *e);

/* Print the head (units, then names of columns); after all rows, print the end. */
void cli_simulate_head(cli_simulate *s);
void cli_simulate_tail(cli_simulate *s, lw_status status, const lw_error *e);

/* Take one row: the sink of lw_dynamics_run; context: the cli_simulate. */
lw_status cli_simulate_row(void *context, const lw_moment *m);

lw_status cli_simulate_gif(const cli_simulate *s, const char *path, lw_error *e);

/* Say so if the animation of a motion in n_frame rows is slower than the motion of this length [s]. */
void cli_note_slower(const cli_call *call, size_t n_frame, double seconds);

/* Print the lines of --explain about elastic links: number of elements, first frequency, the rules of the source. */
void cli_explain_elastic(const cli_call *call, const lw_model *m, const lw_dynamics *solved, double from, double to);

/* Print counterweights that keep the common centre of mass at rest, computed from the postures kept. */
lw_status cli_simulate_balance(cli_simulate *s, FILE *f, lw_error *e);

void cli_simulate_free(cli_simulate *s);

#endif
