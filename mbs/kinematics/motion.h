/* mbs/kinematics/motion.h - the ranges of a linkage's input, joined into circuits.
 *
 * An arc is a range of the input in one assembly mode.  At a limit of motion, the end of an arc, one dyad passes into
 * its other mode.  Arcs joined at limits form a circuit, a closed curve of postures.  Two arcs that only touch (at a
 * change point) count as one circuit too. */
#ifndef LW_MBS_KINEMATICS_MOTION_H
#define LW_MBS_KINEMATICS_MOTION_H

#include "mbs/plan/plan.h"

#define LW_ARC_MAX 64

typedef struct lw_arc {
    double first, last;             /* input [rad] or [m]; last - first = 2 pi: a full turn       */
    bool   turns;                   /* the input turns fully in this arc                          */
    double mode[LW_MODE_MAX];
    int    circuit;                 /* arcs with the same number can be reached from each other   */
    double transmission_min;        /* least and greatest transmission angle of any dyad over the */
    double transmission_max;        /* arc [rad], in [0, pi]; the least squared sine of the two   */
                                    /* is the margin (mbs/batch/batch.h).  It is the angle of     */
                                    /* links (RRR), link and slide normal (RRP), slide normal and */
                                    /* line of pins (RPR), or slides (PRP, PPR)                   */
    bool   limit[2];                /* is `first`, `last` a limit of motion, where the mode of a  */
                                    /* dyad changes?  false: a turn closes there, slides become   */
                                    /* parallel, or a range without end is cut                    */
    int    flips[2];                /* that dyad, else -1.  Its mode 0 gives the posture at the   */
                                    /* limit to rounding; +1 and -1 only to the square root of it */
} lw_arc;

typedef struct lw_motion {
    int    n_arc, n_circuit;
    bool   change_point;            /* do arcs touch?  There the linkage can change its circuit    */
    lw_arc arc[LW_ARC_MAX];
} lw_motion;

/* Find all arcs of all combinations of modes; dyads without modes (PRP, PPR) have mode +1.
 *
 * If only the input link moves the outer joints of a dyad, its limits have closed forms, as in every linkage with one
 * dyad.  They are exact to rounding even near change points; what is nearer than 1e-14 of the size counts as a change
 * point.  Limits of other dyads are roots of their margin along the arc.  They are bracketed by 256 samples, dense near
 * limits of earlier dyads, and by the minima and maxima that the samples show.  They are exact to 1e-10 rad, or times
 * the size.  Gaps or islands narrower than a sample are missed when the samples show no sign of them (none in 1200
 * random six-bars, compared with 20000 samples a mode; one in some thousands, compared with circuits found by chance).
 *
 * Ranges of a slider that have no end are cut at 10 times the sum of all lengths to either side.
 * LW_OPEN: the linkage never closes.  LW_STOPPED: there are more than LW_ARC_MAX arcs; the first are returned.
 * LW_E_MEMORY. */
lw_status lw_motion_find(const lw_plan *plan, const double *dim, lw_motion *motion);

/* A range of the input of a plan with one dyad. */
typedef struct lw_range {
    double first, last;
    bool   turns;                   /* a full turn                                                */
    bool   limits;                  /* are the ends limits of motion, where the mode changes?     */
                                    /* else slides become parallel there, or the range is cut     */
} lw_range;

/* Compute the range in closed form; this is much cheaper than lw_motion_find.  side, +1 or -1, selects one of two
 * ranges. LW_OPEN: the linkage closes nowhere.  LW_E_KIND: the plan has not one dyad. */
lw_status lw_motion_range(const lw_plan *plan, const double *dim, double side, lw_range *r);

/* The arc in mode[n_dyad] that contains the input, apart from whole turns, or else the one with the nearest end; -1
 * when no arc has the mode. */
int lw_motion_arc(const lw_plan *plan, const lw_motion *motion, const double *mode, double input);

/* A dyad of an arc of this circuit almost reaches a flat posture inside the arc, or stops a little before one beyond
 * which another circuit begins, as where a linkage with a change point (a parallelogram, a kite) is drawn with rounded
 * numbers: the angle that is left [rad], else 0.  pin: the input is an angle. */
double lw_motion_nearly_flat(const lw_motion *motion, int circuit, bool pin);

#endif
