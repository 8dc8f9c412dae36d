/* optimise/problem/constraint_internal.h - the parts of the conditions of a fitting problem: the motion that is checked, and
 * the conditions on it.
 *
 * Conditions on the motion are checked in LW_CURVE_SAMPLES postures: over the turn if the input turns fully, else from the first
 * station to the last.  Extremes between the samples are searched for.  g: the conditions; j: their rows of derivatives by the
 * variables, NULL: not wanted; enough: as lw_problem_conditions has it. */
#ifndef LW_OPTIMISE_PROBLEM_CONSTRAINT_INTERNAL_H
#define LW_OPTIMISE_PROBLEM_CONSTRAINT_INTERNAL_H

#include "optimise/problem/circuit.h"
#include "optimise/problem/constraint.h"

/* ---- constraint_motion.c ------------------------------------------------------------------------------------- */

/* Postures from `from` on over `length`: phases of the circuit if the stations have modes of their own, else inputs.
 * moves: these depend on the variables, with the derivatives by[0] of `from` and by[1] of from + length. */
typedef struct lw_checked_motion {
    double from, length;
    size_t end[2];                    /* stations at the two ends                                           */
    bool   moves;
    double by[2][LW_VAR_MAX];
} lw_checked_motion;

/* Is the motion the whole circuit or turn, wherever the stations are? */
bool lw_checked_is_whole(const lw_problem *p);

/* The motion between the stations, whose phases and inputs are in w; then the derivatives of its ends. */
lw_checked_motion lw_checked_motion_of(const lw_problem *p, const lw_work *w);
void lw_checked_end_slopes(const lw_problem *p, const double *x, lw_work *w, lw_checked_motion *m);

/* The points at n <= LW_CURVE_SAMPLES parts of the motion. */
void lw_checked_points(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, size_t n, const double *part, lw_cycle_point *at);

/* Set w->check_at, check_c and check_s to n postures of the motion; to the same, or n postures of the turn. */
void lw_checked_sample_motion(const lw_problem *p, lw_work *w, const lw_checked_motion *m, size_t n);
void lw_checked_sample(const lw_problem *p, lw_work *w, const lw_checked_motion *m, size_t n);

/* Do the inputs of the postures depend on the variables?  Derivative of the input of the posture `at`, which is at `part` of the
 * motion, by variable d. */
bool   lw_checked_inputs_move(const lw_problem *p, const lw_work *w, const lw_checked_motion *m);
double lw_checked_input_slope(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, const lw_cycle_point *at, double part, int d);

/* Does the motion pass a limit on the way to the next sample? */
bool lw_checked_changes(const lw_problem *p, const lw_work *w, size_t k);

/* lw_batch_jacobian of n postures of check_at at the inputs c, s, one run on the same stroke after the other. */
void lw_checked_jacobians(const lw_problem *p, const double *x, lw_work *w, int n_which, const int *which, const double *c,
                          const double *s, size_t n, const lw_jacobian *out);
void lw_checked_jacobian(const lw_problem *p, const double *x, lw_work *w, int which, const double *c, const double *s,
                         size_t n, const lw_jacobian *out);

/* Set `row` to the numbers of the rows that are needed of n conditions along the motion, and the other conditions to INFINITY.
 * Returns how many are needed. */
size_t lw_rows_choose(double *g, size_t n, double enough, size_t *row);

/* Move the postures of the needed rows to the front.  from[k]: the posture of condition k, or LW_CURVE_SAMPLES if it is constant,
 * and its row 0.  Returns the number of postures; row[i] belongs to the i-th, which is at place[i]. */
size_t lw_rows_keep(const lw_problem *p, lw_work *w, double *g, size_t n, double enough, const size_t *from, double *place,
                    size_t *row, double *j);

/* One row of derivatives: those by the dimensions and by the input are column k of `slope`. */
void lw_row_put(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, double part, const lw_cycle_point *at,
                const double *slope, size_t k, double *row);

/* ---- constraint_margins.c: needs the inputs of the sampled postures ---------------------------------------------- */

void lw_check_transmissions(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, double enough, double *g, double *j);
void lw_check_accelerations(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, double enough, double *g, double *j);

/* The linkage closes at every station. */
void lw_check_closure(const lw_problem *p, const double *x, lw_work *w, double *g, double *j);

/* ---- constraint_zones.c: where fixed pivots must be, and where no pin and no tracer may be -------------------------- */

void lw_check_zones(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, double enough, double *g, double *j);

#endif
