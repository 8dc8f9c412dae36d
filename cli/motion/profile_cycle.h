/* cli/motion/profile_cycle.h - `linkwright profile CYCLE.json`. */
#ifndef CLI_MOTION_PROFILE_CYCLE_H
#define CLI_MOTION_PROFILE_CYCLE_H

#include "cli/program/command.h"

/* The cycle of the text `given`, or if NULL of the file of the command.  rows: intervals of the table; 0: the summary.
 * plot: NULL or a picture to draw. */
int cli_profile_cycle(const cli_call *call, const char *given, size_t given_size, int rows, const char *plot);

#endif
