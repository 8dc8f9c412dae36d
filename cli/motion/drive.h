/* cli/motion/drive.h - the actions of `linkwright drive`. */
#ifndef CLI_MOTION_DRIVE_H
#define CLI_MOTION_DRIVE_H

#include "cli/program/command.h"

typedef struct cli_drive_settings {
    const char *speed, *plot, *matrices;
    double      from, to, band;
    int         steps;
} cli_drive_settings;

int cli_drive_load(const cli_call *call);
int cli_drive_simulate(const cli_call *call);

#endif
