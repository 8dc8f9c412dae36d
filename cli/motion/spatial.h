/* cli/motion/spatial.h - commands for spatial models: the same files, places with three numbers. */
#ifndef CLI_MOTION_SPATIAL_H
#define CLI_MOTION_SPATIAL_H

#include "cli/program/command.h"
#include "mbs/dynamics/dynamics_space.h"

/* Options of trace that spatial models know. */
typedef struct cli_spatial_trace {
    int         steps;
    const char *tracer;                  /* NULL: all                                      */
    const char *speed;                   /* NULL: rates by the input                       */
    const double *input_range, *time_range;      /* (2) unit of the file, (3) s; NULL: none */
    const char *plot;                    /* a picture; NULL: none                          */
    bool        geometry;                /* curvature and screw axis too                   */
} cli_spatial_trace;

/* Refuse the options that are given among `names` (NULL ends them): CLI_USAGE after a message; else CLI_DONE. */
int cli_spatial_refuse(const cli_call *call, const char *const *names);

int cli_spatial_trace_run(const cli_call *call, const lw_spatial *m, const cli_spatial_trace *o);
int cli_spatial_mobility(const cli_call *call, const lw_spatial *m, double tolerance, bool as_drawn);

/* Pictures of a run; NULL: none. */
typedef struct cli_spatial_pictures { const char *plot, *columns, *gif; } cli_spatial_pictures;

/* speed: of the inputs without a motion; NULL: they run freely. */
int cli_spatial_simulate(const cli_call *call, lw_spatial *m, const lw_dynamics_options *o, const char *speed,
                         bool explain, const cli_spatial_pictures *p);

/* Inputs without a motion move at constant speed from their values in the file; speed NULL: they do not. */
lw_status cli_spatial_speed(lw_spatial *m, const char *speed, lw_error *e);

/* As cli_explain_elastic (cli/motion/simulate.h). */
void cli_explain_elastic_spatial(const cli_call *call, const lw_spatial *m, const lw_dynamics *solved, double from, double to);

/* Keep the rows of a run (cli/motion/table.h). */
struct cli_table;
lw_status cli_spatial_table(lw_spatial *m, const lw_dynamics_options *o, const char *speed, struct cli_table *t, lw_error *e);

#endif
