/* optimise/problem/evaluate.h - everything that f needs at one place x, from scratch. */
#ifndef LW_OPTIMISE_PROBLEM_EVALUATE_H
#define LW_OPTIMISE_PROBLEM_EVALUATE_H

#include "optimise/problem/work.h"

/* Inputs and postures of every station at x.  false when the linkage cannot close. */
bool lw_problem_settle(const lw_problem *p, const double *x, lw_work *w);

#endif
