/* cli/motion/drive.h - the actions of `linkwright drive`. */
#ifndef CLI_MOTION_DRIVE_H
#define CLI_MOTION_DRIVE_H

#include "cli/motion/table.h"
#include "mbs/drives/motor.h"

typedef struct cli_drive_settings {
    const char *speed, *plot, *matrices, *motors, *gears, *amplifiers, *drive;
    double      from, to, band, inertia_ratio, mass, way, acceleration;
    int         steps, results;
} cli_drive_settings;

int cli_drive_load(const cli_call *call);
int cli_drive_simulate(const cli_call *call);
int cli_drive_select(const cli_call *call);
int cli_drive_radius(const cli_call *call);

/* Move the model of the command as its inputs prescribe.  t needs cli_table_free also after a failure. */
lw_status cli_drive_run(const cli_call *call, cli_table *t, lw_error *e);

/* The loads of all drives; *value holds their samples.  Both need free(). */
lw_status cli_drive_loads(const cli_table *t, double step, double **value, lw_load **load, lw_error *e);

#endif
