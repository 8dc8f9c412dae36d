/* optimise/problem/residuals.h - postures at the inputs of the stations, and the residuals whose squares add up to f.
 *
 * Inputs come first (from x where the timing is prescribed, else from the phases in the scratch), then the postures of
 * all lanes, then the residuals. */
#ifndef LW_OPTIMISE_PROBLEM_RESIDUALS_H
#define LW_OPTIMISE_PROBLEM_RESIDUALS_H

#include "optimise/problem/work.h"

/* Compute the inputs of the lanes from their phases. False: the linkage x closes nowhere. */
bool lw_problem_turn_stations(const lw_problem *p, const double *x, lw_work *w);

/* Inputs of the stations from x, for a prescribed timing. */
void lw_problem_prescribe(const lw_problem *p, const double *x, lw_work *w);

/* Compute the postures of all lanes at their inputs, with derivatives. False: a lane cannot close. */
bool lw_problem_lanes(const lw_problem *p, const double *x, lw_work *w);

/* Residuals of the lanes and, if requested, their derivatives. Where the input of a station is free, the part of the
 * derivatives that a change of this input can compensate is removed (variable_projection.h). Returns f. */
double lw_problem_rows(const lw_problem *p, const double *x, lw_work *w, bool derivatives);

/* Set posture_c and posture_s to the n inputs in posture_x. */
void lw_problem_inputs(const lw_problem *p, lw_work *w, size_t n);

/* Margin of each lane of `in` (mbs/batch/batch.h), the least over all points; as many lanes as w->posture_m has.
 * Overwrites w->posture_x .. posture_v. */
void lw_problem_margin(const lw_problem *p, const lw_lanes *in, lw_work *w, double *margin);

/* Does the linkage stay clear of dead points between the stations, at twelve times as many samples as usual?  Always
 * true for the four-link types, whose limits are known in closed form. */
bool lw_problem_stays(const lw_problem *p, const double *x, lw_work *w);

#endif
