/* optimise/search/random_linkage.h - a member of a family of any linkage, drawn so that it closes.
 *
 * The dimensions are chosen step by step along the plan, in a linkage whose crank has length one: where a
 * dyad is to hang on two points, their distance is known by then for every input of the motion, and
 * its lengths are drawn from those that reach the farthest and fold to the nearest.  A linkage with higher
 * groups is drawn as a posture, joints anywhere, and its crank made shorter until it turns.  Nothing is
 * drawn and thrown away because it does not close. */
#ifndef LW_OPTIMISE_SEARCH_RANDOM_LINKAGE_H
#define LW_OPTIMISE_SEARCH_RANDOM_LINKAGE_H

#include "optimise/problem/problem.h"

#define LW_RANDOM_LINKAGE_DRAW_MAX 36

/* How many numbers in [0, 1) a draw takes. */
int lw_random_linkage_draws(const lw_problem *p);

/* shape (n_dim) and p->branch of the member that belongs to u: its assembly, and either an input that turns
 * fully or, unless `turns` is asked for, a range of the input in which it closes.  false: a
 * degenerate one (parallel slides). */
bool lw_random_linkage_draw(lw_problem *p, const double *u, bool turns, double *shape, void *work);

/* x (n_var, scaled) and p->branch of the posture of the family's own linkage, as far as the problem's bounds let
 * it; inputs of a prescribed timing begin at the posture's.  false when it does not close there. */
bool lw_random_linkage_posture(lw_problem *p, double *x, void *work);

#endif
