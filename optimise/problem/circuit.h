/* optimise/problem/circuit.h - the motion of the input: in full turns, or stroke by stroke between its limits.
 *
 * One phase describes a position on the circuit. The motion is smooth in the phase also at the limits, where the
 * assembly mode changes. If the ends of the range are no limits (slides become parallel, or limits were not searched
 * for), the input moves back and forth in one assembly mode. */
#ifndef LW_OPTIMISE_PROBLEM_CIRCUIT_H
#define LW_OPTIMISE_PROBLEM_CIRCUIT_H

#include "optimise/problem/work.h"

/* Fill w->swing, the circuit of the linkage x. False: the linkage closes nowhere, or a stroke has no length. */
bool lw_circuit_find(const lw_problem *p, const double *x, lw_work *w);

/* Derivatives of the strokes by the dimensions at x. */
void lw_circuit_slopes(const lw_problem *p, const double *x, lw_work *w);

/* Derivative of the input of lane k, or of a point, by dimension d at constant phase; needs the slopes. */
double lw_circuit_drift(const lw_work *w, size_t k, size_t d);
double lw_circuit_drift_at(const lw_work *w, const lw_cycle_point *at, size_t d);

/* The points of the circuit at n phases; write the assembly mode of a stroke into mode[dyad*stride]. */
void lw_circuit_points(const lw_problem *p, const lw_work *w, size_t n, const double *phase, lw_cycle_point *at);
void lw_circuit_put_mode(const lw_problem *p, const lw_work *w, int leg, double *mode, size_t stride);

/* Set lanes 0 .. n - 1 to their phases. */
void lw_circuit_lanes(const lw_problem *p, lw_work *w, size_t n);

/* End index of the run of lanes, of n, on the same stroke as lane `first`. */
size_t lw_circuit_run(const lw_work *w, size_t first, size_t n);

/* Give the lanes of `in` the assembly modes of their strokes, where the stations have modes of their own. */
void lw_circuit_modes(const lw_problem *p, const lw_work *w, lw_lanes *in);

#endif
