/* optimise/problem/timing.h - which input belongs to which station when the timing is not prescribed.
 *
 * First an assignment of the stations to curve samples (monotone by dynamic programming where the stations have an
 * order, else the nearest), then Newton steps along the curve. */
#ifndef LW_OPTIMISE_PROBLEM_TIMING_H
#define LW_OPTIMISE_PROBLEM_TIMING_H

#include "optimise/problem/work.h"

/* Find the curves of all points at LW_CURVE_SAMPLES inputs. */
void lw_timing_sample(const lw_problem *p, const double *x, lw_work *w);

/* Inputs of the stations from scratch: the best assignment to curve samples.  false: the linkage closes nowhere. */
bool lw_timing_assign(const lw_problem *p, const double *x, lw_work *w);

/* Improve the inputs by Newton steps that keep the order, until the inputs rest or `steps` are used up.  The best
 * inputs are kept, and the lanes (work.h) are at these inputs afterwards.  false: the linkage cannot close there. */
bool lw_timing_refine(const lw_problem *p, const double *x, lw_work *w, int steps);

/* Move the phases theta (n) to the nearest ones in order, one turn at most from first to last: least weighted squares
 * by pooling adjacent violators, also round the turn.  scratch: 3 n numbers. */
void lw_timing_order(const lw_problem *p, double *theta, const double *weight, double *scratch);

/* Without timing: nearest points of the target polygon to the curve samples x, y (LW_CURVE_SAMPLES each). */
void lw_timing_samples(const lw_problem *p, lw_work *w, const double *x, const double *y);

#endif
