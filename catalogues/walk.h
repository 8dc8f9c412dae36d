/* catalogues/walk.h - the motion of a linkage through its circuit, in order: along an arc to the limit
 * of its input, through the limit into the other assembly of the dyad that is stretched there, and
 * on, until it is back where it began.  For showing; mbs/motion.h has the limits to full precision. */
#ifndef LW_CATALOGUES_WALK_H
#define LW_CATALOGUES_WALK_H

#include "mbs/plan.h"
#include "mbs/pose.h"

#define LW_STAGE_MAX 32

/* One arc, walked from `from` to `to` (either may be the greater). */
typedef struct lw_stage {
    double from, to;                    /* input [rad] or [m]                                       */
    double mode[LW_DYAD_MAX];
} lw_stage;

typedef struct lw_walk {
    const lw_plan *plan;
    const double  *dim;
    int      n_stage;
    lw_stage stage[LW_STAGE_MAX];       /* the first holds the posture it was made from             */
    bool     loops;                     /* the end of the last stage is the beginning of the first  */
    bool     turns;                     /* one stage, a full turn from the posture                  */
} lw_walk;

/* The circuit through the posture at `input` with `mode`.  size: of the linkage [m], for the steps of
 * a slider input.  LW_OPEN when the posture does not close.  dim must outlive the walk. */
lw_status lw_walk_make(const lw_plan *plan, const double *dim, const double *mode, double input,
                       double size, lw_walk *w);

/* A circuit that is none of found[0 .. n-1] (of the same plan and dimensions): other assembly modes, and
 * ranges of the input that cannot be reached from those.  False when there is none; up to 6 dyads with
 * two assemblies each are tried.  input: of the posture, about which a slider's range is searched. */
bool lw_walk_next(const lw_walk *found, int n, double input, double size, lw_walk *next);

/* Keep only first <= input <= last of the stage with the posture: there and back. */
void lw_walk_restrict(lw_walk *w, double first, double last);

/* Where on the walk: t from 0 to n_stage.  Within a stage the input runs as a cosine, slow near the
 * ends, where the linkage runs fast (evenly for a full turn). */
double    lw_walk_input(const lw_walk *w, double t);
lw_status lw_walk_pose(const lw_walk *w, double t, lw_pose *pose);
double    lw_walk_time(const lw_walk *w, double input);    /* the t of an input of the first stage */

#endif
