/* cli/motion/trace_groups.h - rows of a trace between two postures of its curve, by the plan of its groups (mbs/plan/plan.h):
 * seeded with a posture on the curve, a few rows on are got in a fraction of the time, to the same rounding. */
#ifndef CLI_MOTION_TRACE_GROUPS_H
#define CLI_MOTION_TRACE_GROUPS_H

#include "cli/motion/trace_rows.h"
#include "mbs/batch/pose.h"
#include "mbs/constraints/system.h"

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

#endif
