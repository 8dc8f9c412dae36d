/* optimise/problem/timing.h - find the input of each station when the timing is not prescribed.
 *
 * First the stations are assigned to curve samples (monotone by dynamic programming if the stations have an order, else
 * the nearest), then the inputs are improved by Newton steps along the curve. */
#ifndef LW_OPTIMISE_PROBLEM_TIMING_H
#define LW_OPTIMISE_PROBLEM_TIMING_H

#include "optimise/problem/work.h"

#define LW_TIMING_MOVE_MAX 0.3      /* longest move of the input of a free station in one step [rad] */

/* Compute the curves of all points at LW_CURVE_SAMPLES inputs. */
void lw_timing_sample(const lw_problem *p, const double *x, lw_work *w);

/* Find the inputs of the stations anew: the best assignment to curve samples. False: the linkage closes nowhere. */
bool lw_timing_assign(const lw_problem *p, const double *x, lw_work *w);

/* Improve the inputs by Newton steps that keep the order, until the inputs do not change or `steps` are used up. The
 * best inputs are kept, and the lanes (work.h) are at these inputs afterwards. False: the linkage cannot close there.
 */
bool lw_timing_refine(const lw_problem *p, const double *x, lw_work *w, int steps);

/* Move the phases theta (n) to the nearest ones in order, with at most one turn from first to last: least weighted
 * squares by pooling adjacent violators, also across the end of the turn. scratch: 3 n numbers. */
void lw_timing_order(const lw_problem *p, double *theta, const double *weight, double *scratch);

/* Without timing: nearest points of the target polygon to the curve samples x, y (LW_CURVE_SAMPLES each). */
void lw_timing_samples(const lw_problem *p, lw_work *w, const double *x, const double *y);

#endif
