/* optimise/problem/variable_projection.h - derivatives of f with the inputs of free stations eliminated.
 *
 * The part of the rows that a change of the stations' own inputs can compensate is removed (variable projection,
 * Kaufman 1975). Stations that the order keeps at one input have one common input and are treated together. */
#ifndef LW_OPTIMISE_PROBLEM_VARIABLE_PROJECTION_H
#define LW_OPTIMISE_PROBLEM_VARIABLE_PROJECTION_H

#include "optimise/problem/work.h"

/* Project the rows of derivatives in w; fills w->tangent, tie, slip and slide. */
void lw_variable_projection(const lw_problem *p, const double *x, lw_work *w);

/* Derivatives t of the weighted residuals of station k by its phase.  Returns the sum of their squares. */
double lw_problem_tangent(const lw_problem *p, const lw_work *w, size_t k, double t[LW_PROBLEM_ROW_MAX]);

/* Does the order keep station k and the next one (after the last: the first, a turn later) at one input? */
bool lw_timing_joined(const lw_problem *p, const lw_work *w, size_t k);

#endif
