/* optimise/problem/constraint.h - the conditions g(x) >= 0 and their derivatives, in the scratch of a thread. */
#ifndef LW_OPTIMISE_PROBLEM_CONSTRAINT_H
#define LW_OPTIMISE_PROBLEM_CONSTRAINT_H

#include "optimise/problem/work.h"

/* As lw_problem_constraints.  settled: the inputs of the stations in w are those of x already.  Conditions on the motion that
 * have more room than `enough` may become INFINITY; with rows j, also those with more room than the ones beside them, whose rows
 * are not set; enough = INFINITY: all are needed. */
void lw_problem_conditions(const lw_problem *p, const double *x, bool settled, double enough, double *g, double *j, lw_work *w);

/* By how much the worst condition is missed at x; 0: all are met. */
double lw_problem_lacks(const lw_problem *p, const double *x, lw_work *w);

/* Are all conditions met at x, g >= -tolerance? */
bool lw_problem_admissible(const lw_problem *p, const double *x, double tolerance, lw_work *w);

/* The input at `part` (0 .. 1) of the motion from the first station to the last, or of the whole turn. Also its
 * assembly modes (mode[dyad]) and its stroke. */
double lw_problem_input_at(const lw_problem *p, const lw_work *w, double part, double *mode, int *leg);

#endif
