/* grammar/functions/profile.h - point-to-point motion of one axis in least time, or in a given time, under limits of speed,
 * acceleration and jerk that may differ by direction; from any state to any state.
 *
 * Method.  At a given duration T, the way covered between the two states lies between two extremes.  The greatest
 * is covered when the jerk is first greatest, then least, then greatest again, with pauses where acceleration or
 * speed stands at its limit; for every T these phases follow in closed form.  The least is the mirror image.  The
 * least time is the first T at which the wanted way lies between the extremes; there it equals one of them.  At any
 * other T where it lies between, the mixture of both extremes that covers it is a motion within all limits, since
 * the equations of motion are linear and the limits convex.  A T may be impossible between possible ones: an axis that
 * already moves fast can need either a short time or a long one.
 *
 * The seven phases are those of Makkonen 1999, eq. 2.13-2.29, for motions from rest to rest. */
#ifndef LW_GRAMMAR_FUNCTIONS_PROFILE_H
#define LW_GRAMMAR_FUNCTIONS_PROFILE_H

#include "base/error.h"        /* types and functions: linkwright.h */

/* The same limits in both directions. */
static inline lw_axis_limits lw_axis_limits_even(double v, double a, double j)
{
    return (lw_axis_limits){ { -v, v }, { -a, a }, { -j, j } };
}

#endif
