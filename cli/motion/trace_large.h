/* cli/motion/trace_large.h - trace of planar models with more parts than a linkage holds (mbs/dynamics/follow.h). */
#ifndef CLI_MOTION_TRACE_LARGE_H
#define CLI_MOTION_TRACE_LARGE_H

#include "cli/motion/trace_rows.h"
#include "cli/program/command.h"
#include "grammar/model/model.h"

typedef struct cli_trace_large {
    const lw_model *model;
    cli_rows        rows;
    int             steps;
    const double   *input_range;     /* [rad] or [m]; NULL: a whole turn, or as far as the input goes       */
    const double   *time_range;      /* from, to, step [s]; NULL: along the first input                     */
    bool            timed;           /* derivatives by time                                                 */
    double          speed;           /* of the input [rad/s] or [m/s]                                       */
} cli_trace_large;

/* Print the trace; returns an exit code. */
int cli_trace_large_run(const cli_call *call, cli_trace_large *t);

#endif
