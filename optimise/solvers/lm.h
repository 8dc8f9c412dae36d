/* optimise/solvers/lm.h - Levenberg-Marquardt for linkages, the default local solver.
 *
 * Derivatives of the residuals are exact. The inputs of free stations are eliminated from each step and moved with it.
 * Bounds and linear conditions, and conditions on the motion to first order, are kept by solving the step as a
 * quadratic program (Goldfarb & Idnani 1983), so that optima on a bound or on the Grashof limit are reached to
 * rounding. Damping after Nielsen 1999; bent steps by the geodesic acceleration of Transtrum & Sethna 2012. No allocation. */
#ifndef LW_OPTIMISE_SOLVERS_LM_H
#define LW_OPTIMISE_SOLVERS_LM_H

#include "optimise/solvers/solver.h"

typedef struct lw_lm_options {
    int    max_steps;      /* trial steps                                                          */
    double f_tol;          /* stop when three steps lower f by less than this part of it */
    double f_stop;         /* stop when f is at most this                                          */
    double f_hopeless;     /* give up when f is above this after `patience` steps; 0: never        */
    int    patience;
    bool   bend;           /* with free timing and no conditions on the motion: steps follow the bend of narrow valleys */
    bool   reassign;       /* at the end, assign the free stations again; go on if f is lower      */
    double until;          /* wall clock (base/clock.h) at which to stop; 0: never                 */
    const volatile int *interrupt;               /* not NULL and *interrupt != 0: stop             */
    void (*improved)(void *context, long evals, double f);     /* after each step; may be NULL     */
    void  *context;
} lw_lm_options;
lw_lm_options lw_lm_options_default(void);

/* Improve x (n_var) in place; x must meet bounds and linear conditions (see lw_lm_feasible). keep_inputs: the inputs of
 * free stations in work are a good start for x; otherwise they are assigned anew. Returns f; INFINITY, x unchanged, if
 * the linkage cannot close at x. */
double lw_lm_improve(const lw_problem *p, const lw_lm_options *o, double *x, bool keep_inputs, void *work, long *evals, lw_stop *stop);

/* The same with conditions on the motion (transmission angle, acceleration, closure, zones, sides of links). From a
 * point that violates them lw_lm_improve comes first; if its result violates them too, or the first point does not,
 * steps keep them to first order, and a step counts by f plus weight times the greatest violation (sequential
 * quadratic programming with the Gauss-Newton matrix; Han 1977). INFINITY: the last point violates them. */
double lw_lm_conditioned(const lw_problem *p, const lw_lm_options *o, double *x, void *work, long *evals, lw_stop *stop);

/* Move x to the nearest point that meets bounds and linear conditions; distances are relative to the size of each
 * variable. work: as for lw_lm_improve, of which the state of the stations stays. False: the conditions contradict each
 * other. */
bool lw_lm_feasible(const lw_problem *p, double *x, void *work);

/* Move x at random, farthest in directions in which f hardly changes: normally distributed with the covariance
 * reach^2 rise (J'J + rise D)^-1, D diagonal with 1 over the square of each variable, so that f rises by about reach^2 rise for each
 * variable, and no variable moves by much more than `reach` of its size. normal: (n_var) standard normal numbers. x then meets bounds and
 * linear conditions. False: the linkage does not close at x, or the conditions contradict each other. */
bool lw_lm_scatter(const lw_problem *p, double rise, double reach, const double *normal, double *x, void *work);

/* Run the row `lm` of the solver table. */
lw_status lw_lm_run(const lw_solver *self, const lw_problem *p, const lw_solver_options *o, double *x, lw_solver_result *r);

#endif
