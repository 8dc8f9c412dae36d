/* optimise/solvers/barrier.h - conditions as a logarithmic barrier (Makkonen 1999, eq. 18, 19)
 *
 *     F(x) = f(x) + k sum over j of ln(1 / g_j(x)),      g_j(x) > 0
 *
 * minimised for a decreasing sequence of k; each stage starts at the optimum of the one before. With a fixed k the
 * optimum differs from the true one, f(x_k) - f* is about (number of active conditions) k, so k must decrease (Fiacco &
 * McCormick 1968). Bounds are not part of the barrier; every method keeps them itself. */
#ifndef LW_OPTIMISE_SOLVERS_BARRIER_H
#define LW_OPTIMISE_SOLVERS_BARRIER_H

#include "optimise/solvers/record.h"

/* One stage: F for one k, and the best point of the stage. */
typedef struct lw_barrier_stage {
    lw_record *record;
    double     k;                        /* 0: F is f itself                                      */
    double     edge;                     /* below this g, ln(1/g) continues as a parabola; 0: never */
    double     wall;                     /* value where F is not defined                          */
    double     f_tol;                    /* relative; no finer than k justifies                   */
    double     step;                     /* first step of methods without gradient                */
    long       last_eval;                /* number of evaluations at which this stage ends        */
    bool       inside;                   /* was the last point inside, where F is not replaced?   */
    double     lowest;                   /* least value returned, also below the edge             */
    double     best, x[LW_VAR_MAX];      /* least F inside, and its point; INFINITY: none         */
} lw_barrier_stage;

/* F(x) and its gradient (may be NULL) for any k >= 0. INFINITY where some g <= 0 (if k > 0), where f is not defined,
 * and after a stop. */
double lw_barrier_value(lw_record *r, double k, const double *x, double *grad);

/* The same for methods that need a finite value everywhere. Below the edge the logarithm continues as its Taylor
 * polynomial of second order, so that a line search that steps too far returns by interpolation (Ben-Tal & Zibulevsky
 * 1997); such points never become the best. Where f is not defined, or if the edge is 0, the value is wall (1 + sum of
 * squared violations), with the gradient that leads back. */
double lw_barrier_stage_value(lw_barrier_stage *stage, const double *x, double *grad);

/* Must the method return? The record has stopped, or the evaluations of this stage are used up. */
bool lw_barrier_stage_over(const lw_barrier_stage *stage);

/* Run all stages of k with a method that takes no conditions. The start is made feasible first; LW_STOP_FAILED: no
 * feasible start was found. */
lw_stop lw_barrier_run(lw_record *r, lw_minimise *method, double *x);

/* Run one stage with this k: for methods that take conditions (k = 0), problems without conditions, and searches of the
 * whole box. again: restart the method from the best point as long as this lowers F. */
lw_stop lw_single_run(lw_record *r, lw_minimise *method, double k, bool again, double *x);

#endif
