/* mbs/kinematics/closed_motion.h - the closed curve of postures through one posture of a linkage made of dyads, over
 * the limits of its input, as legs.
 *
 * At a limit of the input the margin of one dyad is 0: the dyad passes into its other mode and the input turns
 * back.  From limit to limit is a leg, all of it in one assembly; legs go up and down in turn until place and
 * assembly are those of the start.  A four-bar whose input swings has two legs, its two modes; linkages of
 * several dyads may have more.  mbs/kinematics/motion.h lists every arc of every assembly and is the slower;
 * mbs/constraints/motion_curve.h follows any linkage. */
#ifndef LW_MBS_KINEMATICS_CLOSED_MOTION_H
#define LW_MBS_KINEMATICS_CLOSED_MOTION_H

#include "mbs/plan/plan.h"

#define LW_LEG_MAX     16
#define LW_CLOSED_MOTION_TOUCH 1e-5         /* margin: next to a change point nobody can say which way a linkage goes */

typedef struct lw_leg {
    double last;                    /* input at its end [rad] or [m]                              */
    int    dyad;                    /* whose limit that is                                        */
    double mode[LW_DYAD_MAX];
} lw_leg;

/* Leg 0 holds the posture and goes up; legs of odd number go down.  Each begins where the one before ends; leg 0
 * where the last one does, less `gain`: whole turns of a pin that the input has made over the cycle [rad]. */
typedef struct lw_closed_motion {
    int    n;                       /* legs; 0: the input turns without limit                     */
    double gain;
    lw_leg leg[LW_LEG_MAX];
} lw_closed_motion;

static inline double lw_closed_motion_first(const lw_closed_motion *c, int leg)
{
    return leg > 0 ? c->leg[leg - 1].last : c->leg[c->n - 1].last - c->gain;
}

/* The cycle through this input in the assembly mode[n_dyad], or in the arc of it that is nearest, seen in 64
 * samples of a turn, or of the lengths' sum to either side of a slider's input.  Only dyads that outputs depend on
 * count.  Limits are bracketed by as many samples a leg, dense towards its beginning where postures go as the
 * square root, and are right to rounding; a gap narrower than a sample, with nothing that hints at it, is
 * missed (10 of 7500 random linkages of four to eight links).
 * batch: scratch of mbs/batch/batch.h.
 *
 * LW_OPEN: it closes nowhere in this assembly.  LW_STOPPED: its legs end where slides become parallel, do not end,
 * come nearer to a change point than LW_CLOSED_MOTION_TOUCH, or are too many or too short.  LW_E_KIND: there are higher
 * groups, or no outputs. */
lw_status lw_closed_motion_find(const lw_plan *plan, const double *dim, const double *mode, double input, void *batch,
                        lw_closed_motion *c);

/* Derivatives of the legs' ends by the dimensions, by[leg*LW_DIM_MAX + d]: the limiting dyad's margin stays 0.  Its
 * derivatives are central differences (1e-9 of the largest; next to a limit of another dyad 1e-4). */
void lw_closed_motion_slopes(const lw_plan *plan, const double *dim, const lw_closed_motion *c, void *batch,
                             double *by);

#endif
