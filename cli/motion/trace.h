/* cli/motion/trace.h - the rows of `linkwright trace`: ranges of the input, printed as CSV or JSON. */
#ifndef CLI_MOTION_TRACE_H
#define CLI_MOTION_TRACE_H

#include "cli/motion/trace_rows.h"
#include "mbs/kinematics/motion.h"
#include "mbs/batch/posture.h"

#define CLI_PIECE_MAX 1024

/* Part of an arc within the chosen range of the input.  limit[i]: this end is a limit of the motion. */
typedef struct cli_piece {
    int    arc;                         /* index in motion.arc                                     */
    double first, last;                 /* [rad] or [m], as in the plan                            */
    bool   limit[2];
} cli_piece;

typedef struct cli_trace {
    lw_linkage k;
    lw_plan    plan;
    lw_motion  motion;
    double     dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;     /* of the posture in the file        */
    double     tool[LW_TRACER_MAX];     /* tool direction minus direction of its link [rad]        */
    bool       whole;                   /* whole input range, else from .. to                      */
    double     from, to;                /* in the angle convention of the file [rad] or [m]        */
    bool       timed;                   /* derivatives by time, at the given input speed           */
    double     speed;                   /* [rad/s] or [m/s]                                        */
    int        steps;
    bool       more_arcs;               /* arcs that are wanted are not in `motion`                */
    bool       dropped;                 /* more pieces than CLI_PIECE_MAX                          */
    int        n_piece;
    cli_piece  piece[CLI_PIECE_MAX];
    cli_rows   rows;
    const char *line;                   /* the command                                             */
} cli_trace;

/* Cut the arcs into pieces; only_file: only the arc that contains the posture of the file. */
void cli_trace_pieces(cli_trace *t, bool only_file);

/* Print every piece; stops after a row when t->rows says so. */
void cli_trace_csv(cli_trace *t);
void cli_trace_json(cli_trace *t);

/* Say so where the circuit of the posture passes close to a change point of exact dimensions. */
void cli_note_nearly_flat(const cli_call *call, const lw_linkage *linkage);

#endif
