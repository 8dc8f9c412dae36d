/* cli/motion/clearance.h - sweeps of a model with clearance over speeds and laws of contact. */
#ifndef CLI_MOTION_CLEARANCE_H
#define CLI_MOTION_CLEARANCE_H

#include "cli/program/output.h"
#include "cli/program/progress.h"
#include "mbs/dynamics/clearance_sweep.h"

#define CLI_CLEARANCE_LIST_MAX 10000

/* "80:400:2" from, to, step; "1e6,1e7"; both mixed.  Free with free().  LW_E_ARG with a text. */
lw_status cli_clearance_list(const char *name, const char *text, double **list, int *n, lw_error *e);

typedef struct cli_clearance {
    const cli_call *call;
    const char *unit;                     /* of the speeds: "rpm", "rad/s", "m/s"                       */
    lw_model   *model;
    lw_clearance_model models[8];         /* the lists of the options                                  */
    double     *stiffness, *damping, *speed;
    lw_sweep_options o;
    lw_sweep    sweep;
} cli_clearance;

/* Fill the lists and make the sweep; run it with progress; free both. */
lw_status cli_clearance_make(cli_clearance *c, const char *models, const char *stiffness, const char *damping,
                             const char *speeds, lw_error *e);
lw_status cli_clearance_run(cli_clearance *c, lw_error *e);
void      cli_clearance_free(cli_clearance *c);

void cli_clearance_csv(const cli_clearance *c, FILE *f);
void cli_clearance_limits(const cli_clearance *c, FILE *f);
void cli_clearance_json(const cli_clearance *c, FILE *f);

/* Speed against stiffness, contact kept or lost (Makkonen 1999, paper C, figures 16-17). */
lw_status cli_clearance_plot(const cli_clearance *c, const char *path, lw_error *e);

/* Direction of the pin in its bush at every passing, over speed: few points where motion is regular, many where it is
 * not. */
lw_status cli_clearance_passes(const cli_clearance *c, const char *path, lw_error *e);

/* The one run of a call of one law and one speed, in full: what of `history` (CSV), `path` (of the pin in its bush) and
 * `force` (over time) is not NULL. */
lw_status cli_clearance_detail(cli_clearance *c, const char *history, const char *path, const char *force, lw_error *e);

#endif
