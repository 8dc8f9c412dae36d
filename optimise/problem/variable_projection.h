/* optimise/problem/variable_projection.h - derivatives of f with the inputs of free stations eliminated.
 *
 * Of the rows is kept what no change of the stations' own inputs can make up for (variable projection, Kaufman 1975).
 * Stations that the order holds at one input have one input to give, and are taken together. */
#ifndef LW_OPTIMISE_PROBLEM_VARIABLE_PROJECTION_H
#define LW_OPTIMISE_PROBLEM_VARIABLE_PROJECTION_H

#include "optimise/problem/work.h"

/* Project the rows of derivatives in w; fills w->tie, slip and slide. */
void lw_variable_projection(const lw_problem *p, const double *x, lw_work *w);

/* Derivatives t of the weighted residuals of station k by its phase.  Returns the sum of their squares. */
double lw_problem_tangent(const lw_problem *p, const lw_work *w, size_t k, double t[LW_PROBLEM_ROW_MAX]);

/* Does the order hold station k and the next one (after the last: the first, a turn on) at one input? */
bool lw_timing_joined(const lw_problem *p, const lw_work *w, size_t k);

#endif
