/* mbs/motion.h - where a linkage can go: the ranges of its input, joined into circuits.
 *
 * An arc is a range of the input in one assembly mode.  At the ends of an arc that are limits of
 * motion the linkage passes into the other mode; arcs joined so form one circuit, a closed curve. */
#ifndef LW_MBS_MOTION_H
#define LW_MBS_MOTION_H

#include "mbs/plan.h"

#define LW_ARC_MAX 64

typedef struct lw_arc {
    double first, last;             /* input [rad] or [m]; last - first = 2 pi: a full turn       */
    bool   turns;                   /* the input turns fully in this arc                          */
    double mode[LW_DYAD_MAX];
    int    circuit;                 /* arcs with the same number can be reached from each other   */
    double transmission_min;        /* least and greatest transmission angle over the arc [rad]:  */
    double transmission_max;        /* the angle at the inner joint of the last dyad              */
} lw_arc;

typedef struct lw_motion { int n_arc, n_circuit; lw_arc arc[LW_ARC_MAX]; } lw_motion;

/* All arcs of all mode combinations, limits to 1e-10 rad (or of the size of the linkage for sliders):
 * in closed form where only the input link moves a dyad's outer joints, else bracketed by bounds and
 * polished.  Slider inputs: range found likewise, never infinite for linkages that close. */
lw_status lw_motion_find(const lw_plan *plan, const double *dim, lw_motion *m);

#endif
