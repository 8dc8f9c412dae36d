/* optimise/search/random_linkage.h - random linkages of a given topology that close.
 *
 * The dimensions are chosen step by step along the plan, in a linkage whose crank has length one.  When a dyad is
 * added to two points, the distance of these points is known for every input of the motion; the dyad's lengths are
 * drawn from those that reach the greatest distance and fold to the least.  A linkage with higher groups is drawn as
 * a posture with joints anywhere; its cranks are made shorter until the linkage turns.  So no draw is wasted because
 * it does not close. */
#ifndef LW_OPTIMISE_SEARCH_RANDOM_LINKAGE_H
#define LW_OPTIMISE_SEARCH_RANDOM_LINKAGE_H

#include "optimise/problem/problem.h"

#define LW_RANDOM_LINKAGE_DRAW_MAX 36

/* How many numbers in [0, 1) a draw takes. */
int lw_random_linkage_draws(const lw_problem *p);

/* Compute the linkage that u stands for: its dimensions, shape (n_dim), and in p->intended its assembly mode and its
 * motion: the input turns fully or, unless `turns` asks for that, moves in a range in which the linkage closes.
 * false: the linkage is degenerate (parallel slides), or does not move. */
bool lw_random_linkage_draw(lw_problem *p, const double *u, bool turns, double *shape, void *work);

/* Variables x (n_var, scaled) and p->intended of the family's own linkage in its posture, moved into the problem's
 * bounds; the inputs of a prescribed timing begin at the posture's.  false: it does not close there. */
bool lw_random_linkage_posture(lw_problem *p, double *x, void *work);

#endif
