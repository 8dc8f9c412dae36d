/* cli/motion/trace_curve.h - `linkwright trace` for any linkage: along its motion curves, or in time. */
#ifndef CLI_MOTION_TRACE_CURVE_H
#define CLI_MOTION_TRACE_CURVE_H

#include "cli/motion/trace_rows.h"
#include "grammar/model/model.h"
#include "mbs/batch/posture.h"
#include "mbs/constraints/circuits.h"
#include "mbs/constraints/prescribed_motion.h"
#include "mbs/constraints/system.h"

/* The plan of the linkage's groups (mbs/plan/plan.h) computes the rows between two postures of the curve. It starts
 * from a posture on the curve and gives the next rows in a fraction of the time, with the same rounding error. */
#define CLI_GROUP_ROWS 16              /* rows from one seed to the next                             */

typedef struct cli_groups {
    lw_plan    plan;
    double     dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    bool       seeded;
    double     more;                   /* the plan's input minus the linkage's                        */
    double     tool[LW_TRACER_MAX];    /* printed angles minus the plan's [rad]                      */
    double     angle[LW_TRACER_MAX];   /* in the previous row [rad]                                  */
    lw_linkage k;
    lw_posture    posture;
} cli_groups;

/* Returns NULL if the linkage has no plan or memory ran out; then the curve alone gives all rows. Free with free(). */
cli_groups *cli_groups_make(const lw_linkage *linkage, unsigned tracers);

/* Start the next rows from posture q of s, which was printed as `row` at input u. */
void cli_groups_seed(cli_groups *g, const lw_system *s, const double *q, double u, const cli_rows *rows, const cli_row *row);

/* Compute the row at input u; by: input rate that scales the derivatives. False: the plan is too near a dead point. */
bool cli_groups_row(cli_groups *g, double u, double by, const cli_rows *rows, cli_row *row);

#define CLI_STRETCH_MAX 1024          /* within a range of the input                                 */

/* A part of a motion curve on which the free input moves in one direction: from limit to limit, or the whole curve.
 * On a closed curve it may contain the end of the stations; it then has two parts.  If the input can turn without
 * end, the stretch repeats the curve. */
typedef struct cli_stretch {
    int    curve;
    double first, last;               /* input [rad] or [m]                                        */
    bool   limit[2], turns;
    double zero, input_per_round;     /* if turns: input at station 0, and its change once round; else 0 */
    int    n_part;
    struct { double from, to, more; } part[2];    /* stations; offset of the input from the curve's    */
} cli_stretch;

typedef struct cli_curve_trace {
    const lw_model *model;
    lw_assembly k;                    /* a view                                                    */
    lw_system   s;
    double     *drawn;           /* (s.n_q) posture of the file, where an overconstrained linkage was adjusted; or NULL */
    lw_circuits   curves;
    cli_rows    rows;
    cli_groups *groups;               /* NULL: the linkage has no plan                             */
    const char *line;
    bool        whole;                /* whole input range, else from .. to [rad] or [m]           */
    double      from, to;
    bool        timed;                /* derivatives by time                                       */
    double      speed;                /* of the input [rad/s] or [m/s]                             */
    int         steps;
    bool        dropped;              /* more stretches than CLI_STRETCH_MAX                         */
    bool        no_memory;            /* for another stretch                                       */
    int         n_stretch, room;
    cli_stretch *stretch;
    double     *series;               /* (CLI_ROW_ORDER + 1) x n_q: of the row at hand; owns the next three arrays */
    double     *shift, *lead;         /* (n_tracer) whole turns subtracted from printed angles; of the row */
    double    (*value)[CLI_ROW_MOST]; /* of the row                                                */
    double     *q;                    /* (n_q) scratch                                             */
} cli_curve_trace;

/* Make room for a row, with the system made.  LW_E_MEMORY. */
lw_status cli_curve_room(cli_curve_trace *t, lw_error *e);

/* Cut the curves into stretches, within the chosen range of the input.  LW_E_MEMORY. */
lw_status cli_curve_stretches(cli_curve_trace *t, lw_error *e);

/* Print all stretches; with `cycle` each curve as a whole, at equal distances along it. */
void cli_curve_print(cli_curve_trace *t, bool cycle);

/* Print rows in time from range[0] to range[1] in steps of range[2]; the inputs move by their motions. LW_OPEN and
 * LW_E_NUMERIC: the rows end early; e has the reason. */
lw_status cli_time_print(const cli_call *call, cli_curve_trace *t, const double range[3], lw_error *e);

double cli_curve_unit(const cli_curve_trace *t, int input);       /* metre or radian of the file       */

#endif
