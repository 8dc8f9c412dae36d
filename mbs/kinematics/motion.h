/* mbs/kinematics/motion.h - where a linkage can go: the ranges of its input, joined into circuits.
 *
 * An arc is a range of the input in one assembly mode.  At the ends of an arc that are limits of
 * motion the linkage passes into the other mode of one dyad; arcs joined so form one circuit, a closed
 * curve of postures.  Two arcs that only touch (a change point) count as one circuit too. */
#ifndef LW_MBS_KINEMATICS_MOTION_H
#define LW_MBS_KINEMATICS_MOTION_H

#include "mbs/plan/plan.h"

#define LW_ARC_MAX 64

typedef struct lw_arc {
    double first, last;             /* input [rad] or [m]; last - first = 2 pi: a full turn       */
    bool   turns;                   /* the input turns fully in this arc                          */
    double mode[LW_MODE_MAX];
    int    circuit;                 /* arcs with the same number can be reached from each other   */
    double transmission_min;        /* least and greatest transmission angle over the arc [rad],  */
    double transmission_max;        /* in [0, pi]: the angle whose squared sine is the margin of  */
                                    /* mbs/batch/batch.h, at the last dyad: between its links (RRR),    */
                                    /* of link and slide's normal (RRP), of slide's normal and    */
                                    /* line of the pins (RPR), of the slides (PRP, PPR)           */
    bool   limit[2];                /* first, last: a limit of motion, where the mode of a dyad   */
                                    /* flips; false: a turn closes there, slides become parallel, */
                                    /* or the range goes on and is cut where the plan says        */
    int    flips[2];                /* that dyad, else -1.  Its mode 0 is the posture of the limit to */
                                    /* rounding, which +1 and -1 meet to the root of it only      */
} lw_arc;

typedef struct lw_motion {
    int    n_arc, n_circuit;
    bool   change_point;            /* arcs touch: the linkage can leave its circuit there        */
    lw_arc arc[LW_ARC_MAX];
} lw_motion;

/* All arcs of all mode combinations; dyads without modes (PRP, PPR) have mode +1.
 *
 * A dyad whose outer joints are moved by the input link alone has its limits in closed form, to
 * rounding also near change points; nearer than 1e-14 of the size counts as a change point.  So for
 * every linkage with one dyad.  Limits of further dyads are roots of their margin along the arc,
 * bracketed by 256 samples (dense towards limits of earlier dyads) and by the minima and maxima that
 * the samples show, polished to rounding: right to 1e-10 rad or of the size, but gaps or islands
 * narrower than a sample, with nothing in the samples that hints at them, are missed (none in 1200
 * random six-bars that 20000 samples a mode could see).
 *
 * Sliders whose way has no end are cut at 10 times the sum of all lengths to either side.
 * LW_OPEN: no arc, it never closes.  LW_STOPPED: more than LW_ARC_MAX arcs, the first are given. */
lw_status lw_motion_find(const lw_plan *plan, const double *dim, lw_motion *m);

/* The range of the input of a plan with one dyad. */
typedef struct lw_range {
    double first, last;
    bool   turns;                   /* a full turn                                                */
    bool   limits;                  /* the ends are limits of motion, where the mode flips; else  */
                                    /* slides become parallel there, or the range is cut as above */
} lw_range;

/* Work it out in closed form: cheaper than lw_motion_find by far, for inner loops.  Where there are two
 * ranges, side +1 or -1 chooses.  LW_OPEN: it closes nowhere; LW_E_KIND: not one dyad. */
lw_status lw_motion_range(const lw_plan *plan, const double *dim, double side, lw_range *r);

/* The arc in this mode (of plan->n_dyad dyads) that holds the input (whole turns do not count), else
 * the one whose end is nearest to it; -1 when no arc has the mode. */
int lw_motion_arc(const lw_plan *plan, const lw_motion *m, const double *mode, double input);

#endif
