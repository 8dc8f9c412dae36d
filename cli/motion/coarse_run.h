/* cli/motion/coarse_run.h - how far a run with contacts moves away from the same run with less accuracy.
 *
 * Each impact amplifies errors, and captured contacts leave an error that the energy does not show.  The difference of two runs shows both.
 * A captured run is repeated in steps of twice the length, one that locates its impacts with 100 times the tolerance. */
#ifndef CLI_MOTION_COARSE_RUN_H
#define CLI_MOTION_COARSE_RUN_H

#include "cli/motion/simulate.h"

/* Can contacts act in a run of this model, so that its postures should be kept for the comparison?  No with so many rows that they would need 160 MB. */
bool cli_coarse_run_suits(const cli_simulate *s);

/* Repeat the run that s has made, and compare it with the postures kept in s: s->coarse.  LW_E_MEMORY; a run that ends early is not compared. */
lw_status cli_coarse_run_compare(cli_simulate *s, lw_error *e);

#endif
