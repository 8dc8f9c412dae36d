/* optimise/search/start.h - structured starting points: draw the shape of the linkage and compute the rest.
 *
 * For given link ratios and input angles the tracer is linear in three complex numbers,
 *     P = z0 + a (o + c d)      z0 place, a size and turn, c tracer on its link,
 * where o and d are origin and direction of the tracer's link in a linkage of size one.  So place, size and tracer
 * (and one tracer for each further point) follow from linear least squares (variable projection).  What remains to be
 * drawn is the shape, the first input angle, and with free timing how the stations are spread along the curve. */
#ifndef LW_OPTIMISE_SEARCH_START_H
#define LW_OPTIMISE_SEARCH_START_H

#include "optimise/search/random_linkage.h"

#define LW_START_DRAWS (LW_RANDOM_LINKAGE_DRAW_MAX + 4)     /* most numbers in [0, 1) that a start takes    */

/* How many numbers a start of this problem takes. */
int lw_start_draws(const lw_problem *p);

/* A first estimate of the start that u stands for, at a tenth of its cost: the residual of the linear fit with the
 * inputs as guessed.  INFINITY: u stands for no start.  For a family of any linkage, here and in lw_start, p->intended
 * becomes the start's. */
double lw_start_estimate(lw_problem *p, const double *u, void *work);

/* Compute the start x (n_var) that u stands for.  It meets the bounds and linear conditions; the inputs of free
 * stations are left in work.  Returns f there; INFINITY when u stands for no start. */
double lw_start(lw_problem *p, const double *u, double *x, void *work);

/* Poses tell more: of three or more, the pins of a four-bar can be points of the body whose paths are nearly circles (Burmester's
 * circle points), and the middles of these.  A parallelogram for a body that keeps its angle, for example, is hardly ever drawn
 * otherwise.  lw_start_has_guides: is this a problem for such starts?  The others are as above, of four numbers u; the estimate is what
 * the two circles are missed by. */
bool   lw_start_has_guides(const lw_problem *p);
double lw_start_guided_estimate(const lw_problem *p, const double *u);
double lw_start_guided(lw_problem *p, const double *u, double *x, void *work);

#endif
