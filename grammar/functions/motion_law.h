/* grammar/functions/motion_law.h - laws of motion from rest to rest over a unit of way in a unit of time, as cam and drive
 * engineers choose them (VDI 2143; Makkonen 1999, L899-933). */
#ifndef LW_GRAMMAR_FUNCTIONS_MOTION_LAW_H
#define LW_GRAMMAR_FUNCTIONS_MOTION_LAW_H

#include "base/error.h"        /* type and functions: linkwright.h */

/* Taylor coefficients 0 .. order of the way at u; at a step those behind it, with direction < 0 those before it. */
void lw_motion_law_series(int law, double u, int direction, int order, double *out);

/* The i-th place inside at which the law changes its formula; 1: there is none. */
double lw_motion_law_border(int law, int i);

#endif
