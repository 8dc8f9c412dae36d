/* cli/motion/clearance.h - sweeps of a model with clearance over speeds and contact laws. */
#ifndef CLI_MOTION_CLEARANCE_H
#define CLI_MOTION_CLEARANCE_H

#include "cli/program/output.h"
#include "cli/program/progress.h"
#include "mbs/clearance/clearance_sweep.h"

#define CLI_CLEARANCE_LIST_MAX 10000

typedef struct cli_clearance {
    const cli_call *call;
    const char *unit;                     /* of the speeds: "rpm", "rad/s", "m/s"                       */
    lw_model   *model;
    lw_clearance_model models[8];         /* the lists of the options                                  */
    double     *stiffness, *damping, *speed;
    lw_sweep_options o;
    lw_sweep    sweep;
} cli_clearance;

/* Fill the lists and make the sweep; run it and show the progress; free both. */
lw_status cli_clearance_make(cli_clearance *c, const char *models, const char *stiffness, const char *damping,
                             const char *speeds, lw_error *e);
lw_status cli_clearance_run(cli_clearance *c, lw_error *e);
void      cli_clearance_free(cli_clearance *c);

void cli_clearance_csv(const cli_clearance *c, FILE *f);
void cli_clearance_limits(const cli_clearance *c, FILE *f);
void cli_clearance_json(const cli_clearance *c, FILE *f);

/* Plot speed over stiffness, contact kept or lost (Makkonen 1999, paper C, figures 16-17). */
lw_status cli_clearance_plot(const cli_clearance *c, const char *path, lw_error *e);

/* Plot the direction of the pin in its bush each time the input passes its start, over speed. A regular motion gives
 * few points, an irregular one many. */
lw_status cli_clearance_passes(const cli_clearance *c, const char *path, lw_error *e);

/* Run one law at one speed in full. Write `history` (CSV), `path` (of the pin in its bush) and `force` (over time),
 * unless NULL. */
lw_status cli_clearance_detail(cli_clearance *c, const char *history, const char *path, const char *force, lw_error *e);

#endif
