/* mbs/kinematics/closed_motion.h - the closed motion through one posture of a linkage made of dyads, over the limits of
 * its input.
 *
 * At a limit of the input the margin of one dyad is 0.  The dyad passes into its other assembly mode and the input
 * turns back.  A leg goes from one limit to the next in one assembly mode.  Legs of rising and falling input alternate
 * until posture and assembly mode are those of the start.  A four-bar with a swinging input has two legs, one a mode;
 * linkages of several dyads may have more.  mbs/kinematics/motion.h lists every arc of every mode and is slower;
 * mbs/constraints/motion_curve.h follows any linkage. */
#ifndef LW_MBS_KINEMATICS_CLOSED_MOTION_H
#define LW_MBS_KINEMATICS_CLOSED_MOTION_H

#include "mbs/plan/plan.h"

#define LW_LEG_MAX             16
#define LW_CLOSED_MOTION_TOUCH 1e-5  /* at a smaller margin, near a change point, the next posture is not determined */

typedef struct lw_leg {
    double last;                    /* input at its end [rad] or [m]                              */
    int    dyad;                    /* the dyad whose limit that is                               */
    double mode[LW_DYAD_MAX];
} lw_leg;

/* The input rises in leg 0, which contains the given posture, and falls in legs of odd number.  Each leg begins where
 * the one before ends.  Leg 0 begins where the last leg ends, minus `gain`: the whole turns of the input over the
 * closed motion [rad]. */
typedef struct lw_closed_motion {
    int    n;                       /* legs; 0: the input turns without limit                     */
    double gain;
    lw_leg leg[LW_LEG_MAX];
} lw_closed_motion;

/* The input at the beginning of a leg. */
static inline double lw_closed_motion_first(const lw_closed_motion *c, int leg)
{
    return leg > 0 ? c->leg[leg - 1].last : c->leg[c->n - 1].last - c->gain;
}

/* Find the closed motion through this input in the assembly mode[n_dyad].  If the linkage does not close there, take
 * the nearest of 64 samples of a turn (of a slider: of the sum of the lengths to either side) where it does.  Only
 * dyads that outputs depend on count.  Each leg is sampled as often, with samples dense near its beginning, where
 * postures vary like the square root of the input; limits are exact to rounding.  A gap narrower than a sample, not beside the
 * leg, is missed when the margins of the samples show no sign of it (5 of 7500 random linkages of four to eight links).
 * batch: scratch of mbs/batch/batch.h.
 *
 * LW_OPEN: the linkage closes nowhere in this mode.  LW_STOPPED: the legs end where slides become parallel, do not end,
 * have a margin below LW_CLOSED_MOTION_TOUCH without a limit, or are too many or too short.  LW_E_KIND: there are
 * higher groups, or no outputs. */
lw_status lw_closed_motion_find(const lw_plan *plan, const double *dim, const double *mode, double input, void *batch,
                                lw_closed_motion *motion);

/* Derivatives of the legs' ends by the dimensions, by[leg*LW_DIM_MAX + d], from the condition that the margin of the
 * limiting dyad stays 0, and the exact derivatives of that margin. */
void lw_closed_motion_slopes(const lw_plan *plan, const double *dim, const lw_closed_motion *motion, void *batch, double *by);

#endif
