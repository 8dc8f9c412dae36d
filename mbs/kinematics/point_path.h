/* mbs/kinematics/point_path.h - the path of a point: where it crosses itself. */
#ifndef LW_MBS_KINEMATICS_POINT_PATH_H
#define LW_MBS_KINEMATICS_POINT_PATH_H

#include <stddef.h>
#include "linkwright.h"       /* lw_double_point */

/* Double points of the path through n points at even steps of a parameter, x and y (n): places it passes twice, in the order
 * of the first passage; at most `most` of them.  Returns their number, or -1: out of memory.  Between the points the path
 * is taken for a cubic through four of them, so that the error falls with the fourth power of the steps.  A path that
 * returns to its first point does not count that as a double point; points that are not finite interrupt it. */
int lw_point_path_doubles(size_t n, const double *x, const double *y, lw_double_point *out, int most);

#endif
