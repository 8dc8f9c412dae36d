/* cli/motion/drive.h - the actions of `linkwright drive`. */
#ifndef CLI_MOTION_DRIVE_H
#define CLI_MOTION_DRIVE_H

#include "cli/program/command.h"
#include "mbs/drives/motor.h"

typedef struct cli_drive_settings {
    const char *speed, *plot, *matrices, *folder, *bode, *motors, *gears, *amplifiers, *drive;
    double      from, to, band, inertia_ratio, mass, way, acceleration;
    int         steps, results;
} cli_drive_settings;

int cli_drive_load(const cli_call *call);
int cli_drive_simulate(const cli_call *call);
int cli_drive_select(const cli_call *call);
int cli_drive_radius(const cli_call *call);

/* Move the model of the command as its inputs prescribe.  l needs lw_loads_free also after a failure. */
lw_status cli_drive_run(const cli_call *call, lw_loads *l, lw_error *e);

#endif
