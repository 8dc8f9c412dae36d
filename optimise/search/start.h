/* optimise/search/start.h - structured starting points: the shape of the linkage is drawn, the rest is worked out.
 *
 * For given link ratios and input angles the tracer is linear in three complex numbers,
 *     P = z0 + a (o + c d)      z0 place, a size and turn, c tracer on its link,
 * o and d being origin and direction of the tracer's link in a linkage of size one, so place, size
 * and tracer - with further points a tracer for each - follow from linear least squares (variable projection).  What is left to draw is the
 * shape, the first input angle, and for free timing how the stations run along the curve. */
#ifndef LW_OPTIMISE_SEARCH_START_H
#define LW_OPTIMISE_SEARCH_START_H

#include "optimise/search/random_linkage.h"

#define LW_START_DRAWS (LW_RANDOM_LINKAGE_DRAW_MAX + 4)     /* numbers in [0, 1) a start takes at most     */

/* How many numbers a start of this problem takes. */
int lw_start_draws(const lw_problem *p);

/* A first look at the start that belongs to u, for a tenth of the price: what the linear fit leaves
 * with the inputs as guessed.  INFINITY when it is no start.  Of a family of any linkage, p->branch becomes
 * that of the start, here and below. */
double lw_start_glance(lw_problem *p, const double *u, void *work);

/* x (n_var) of the start that belongs to u; meets bounds and linear conditions; inputs of free
 * stations are left in work.  Returns f there; INFINITY when it is no start. */
double lw_start(lw_problem *p, const double *u, double *x, void *work);

#endif
