/* cli/motion/trace_curve.h - `linkwright trace` for any linkage: along its curves of postures, or in time. */
#ifndef CLI_MOTION_TRACE_CURVE_H
#define CLI_MOTION_TRACE_CURVE_H

#include "cli/motion/trace_rows.h"
#include "grammar/model.h"
#include "mbs/constraints/system.h"
#include "mbs/batch/pose.h"
#include "mbs/constraints/circuits.h"
#include "mbs/constraints/prescribed_motion.h"

/* Rows of a trace between two postures of its curve, from the plan of its groups (mbs/plan/plan.h).  The plan starts from
 * a posture on the curve, and gives the next rows in a fraction of the time, to the same rounding. */
#define CLI_GROUP_ROWS 16              /* rows from seed to seed                                     */

typedef struct cli_groups {
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    bool       seeded;
    double     more;                   /* what the plan's input counts more than the linkage's       */
    double     tool[LW_TRACER_MAX];    /* angles told less the plan's [rad]                          */
    double     angle[LW_TRACER_MAX];   /* of the row before [rad]                                    */
    lw_linkage k;
    lw_pose    pose;
} cli_groups;

/* NULL when the linkage has no plan, or memory ran out: then there is the curve alone.  Free with free(). */
cli_groups *cli_groups_make(const lw_linkage *k, unsigned tracers);

/* Posture q of s, where the input is u and which has been told as `row`, is the seed of the next rows. */
void cli_groups_seed(cli_groups *g, const lw_system *s, const double *q, double u, const cli_rows *rows,
                     const cli_row *row);

/* Values of the row at input u, derivatives by `by` times the input.  False, when the plan does not vouch for it. */
bool cli_groups_row(cli_groups *g, double u, double by, const cli_rows *rows, cli_row *row);

#define CLI_STRETCH_MAX 1024

/* A stretch of a curve on which the free input goes one way: from limit to limit, or all of it.  On a closed curve
 * it may go over the end of the stations: then in two parts.  Where the input turns on and on the stretch goes round
 * the curve as often as it likes. */
typedef struct cli_stretch {
    int    curve;
    double first, last;               /* input [rad] or [m]                                        */
    bool   limit[2], turns;
    double zero, lap;                 /* turns: input at station 0, and what it gains in a lap; else 0 */
    int    n_part;
    struct { double from, to, more; } part[2];    /* stations; what the input counts more than there  */
} cli_stretch;

typedef struct cli_curve_trace {
    const lw_model *model;
    const lw_linkage *k;
    lw_system   s;
    lw_circuits   curves;
    cli_rows    rows;
    cli_groups *groups;               /* of linkages that have a plan, else NULL                   */
    const char *line;
    bool        whole;                /* all of the input, else from .. to [rad] or [m]            */
    double      from, to;
    bool        timed;                /* derivatives by time                                       */
    double      speed;                /* of the input [rad/s] or [m/s]                             */
    int         steps;
    bool        dropped;              /* there are more stretches than CLI_STRETCH_MAX               */
    int         n_stretch;
    cli_stretch stretch[CLI_STRETCH_MAX];
    double      shift[LW_TRACER_MAX]; /* whole turns that angles are told less                     */
} cli_curve_trace;

/* Cut the curves into stretches, these to the wanted range of the input. */
void cli_curve_stretches(cli_curve_trace *t);

/* All stretches; or with `cycle` every curve as a whole, evenly by its arc. */
void cli_curve_print(cli_curve_trace *t, bool cycle);

/* Inputs as functions of time from range[0] in steps of range[2] to range[1].  LW_OPEN, LW_E_NUMERIC: the rows end
 * before, e says why. */
lw_status cli_time_print(cli_curve_trace *t, const double range[3], lw_error *e);

/* Shared: values of all tracers from a series of postures (4 x n_q), into row. */
void cli_curve_values(cli_curve_trace *t, const double *series, bool first, cli_row *row);
double cli_curve_unit(const cli_curve_trace *t, int input);       /* metre or radian of the file       */
const char *cli_curve_unit_name(const cli_curve_trace *t, int input);

#endif
