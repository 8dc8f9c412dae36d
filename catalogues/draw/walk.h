/* catalogues/draw/walk.h - the motion of a linkage through its circuit, in order: along an arc to the limit
 * of its input, through the limit into the other assembly of the dyad that is stretched there, and
 * on, until it is back where it began. */
#ifndef LW_CATALOGUES_DRAW_WALK_H
#define LW_CATALOGUES_DRAW_WALK_H

#include "mbs/kinematics/motion.h"
#include "mbs/plan/plan.h"
#include "mbs/batch/pose.h"

/* One arc, walked from `from` to `to` (either may be the greater). */
typedef struct lw_walk_stage {
    int    arc;                         /* in lw_motion                                             */
    double from, to;                    /* input [rad] or [m]                                       */
    double mode[LW_MODE_MAX];
} lw_walk_stage;

typedef struct lw_walk {
    const lw_plan *plan;
    const double  *dim;
    int      n_stage;
    lw_walk_stage stage[LW_ARC_MAX];         /* the first is the arc it was made from                    */
    bool     loops;                     /* the end of the last stage is the beginning of the first  */
    bool     turns;                     /* one stage, a full turn                                   */
} lw_walk;

/* The walk through the circuit of arc `arc` of m, which lw_motion_find found for this plan and these
 * dimensions.  When the arc is a full turn it begins at `input`, else at an end that is no limit if
 * there is one.  plan and dim must outlive the walk. */
void lw_walk_make(const lw_plan *plan, const double *dim, const lw_motion *m, int arc, double input,
                  lw_walk *w);

/* Keep only first <= input <= last of the first stage, from first to last: there and back. */
void lw_walk_restrict(lw_walk *w, double first, double last);

/* Where on the walk: t from 0 to n_stage.  Within a stage the input runs as a cosine, slow near the
 * ends, where the linkage runs fast (evenly for a full turn). */
double lw_walk_input(const lw_walk *w, double t);
double lw_walk_time(const lw_walk *w, double input);    /* the t of an input of the first stage   */

/* The pose there; at a limit, where rounding decides whether it closes, the nearest one. */
void   lw_walk_pose(const lw_walk *w, double t, lw_pose *pose);

#endif
