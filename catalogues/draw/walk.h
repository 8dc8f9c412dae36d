/* catalogues/draw/walk.h - the motion of a linkage through its circuit, in order: along an arc to the limit of its
 * input, through the limit into the other assembly mode of the dyad that is stretched there, and on, until it is back
 * where it began. */
#ifndef LW_CATALOGUES_DRAW_WALK_H
#define LW_CATALOGUES_DRAW_WALK_H

#include "mbs/kinematics/motion.h"
#include "mbs/plan/plan.h"
#include "mbs/batch/posture.h"

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
    bool     loops;                     /* the last stage ends where the first begins              */
    bool     turns;                     /* one stage, a full turn                                   */
} lw_walk;

/* Make the walk through the circuit of arc `arc` of m, which lw_motion_find gave for this plan and these dimensions.
 * An arc of a full turn begins at `input`; other arcs begin at an end that is not a limit, if there is one. plan and
 * dim must outlive the walk. */
void lw_walk_make(const lw_plan *plan, const double *dim, const lw_motion *m, int arc, double input, lw_walk *w);

/* Keep only first <= input <= last of the first stage, from first to last: there and back. */
void lw_walk_restrict(lw_walk *w, double first, double last);

/* Greatest distance of a joint or tracer between two postures [m]. */
double lw_plan_posture_distance(const lw_plan *plan, const lw_posture *a, const lw_posture *b);

/* The t, 0 to n_stage, of an input of the first stage.  Within a stage the input follows a cosine: slow near the ends,
 * where the linkage moves fast.  In a full turn it is even. */
double lw_walk_time(const lw_walk *w, double input);

/* The posture at t.  At a limit, where rounding decides whether the linkage closes, the nearest posture. */
void   lw_walk_posture(const lw_walk *w, double t, lw_posture *posture);

#endif
