/* optimise/solvers/barrier.h - subsidiary conditions as a logarithmic barrier (Makkonen 1999, eq. 18, 19)
 *
 *     F(x) = f(x) + k sum over j of ln(1 / g_j(x)),      g_j(x) > 0
 *
 * minimised for a falling sequence of k, each stage from the optimum of the one before.  With a fixed k
 * the optimum stays off the true one: f(x_k) - f* is about (number of active conditions) k, so k has to
 * fall (Fiacco & McCormick 1968).  Bounds are not in the barrier; every method keeps them itself. */
#ifndef LW_OPTIMISE_SOLVERS_BARRIER_H
#define LW_OPTIMISE_SOLVERS_BARRIER_H

#include "optimise/solvers/record.h"

/* One stage: F with its k, and the best point of it. */
typedef struct lw_barrier_stage {
    lw_record *record;
    double     k;                        /* 0: F is f itself                                      */
    double     edge;                     /* g below which ln(1/g) goes on as a parabola, 0: never */
    double     wall;                     /* value where F is not defined                          */
    double     f_tol;                    /* relative, no finer than this k deserves               */
    double     step;                     /* first step of methods without gradient                */
    long       last_eval;                /* the record may count up to here in this stage         */
    bool       inside;                   /* was the last point one where F is meant?              */
    double     lowest;                   /* value given out, also below the edge                  */
    double     best, x[LW_VAR_MAX];      /* least F seen and where; INFINITY: none                */
} lw_barrier_stage;

/* A method lowers F of a stage from x (which it may change); the stage keeps the best. */
typedef lw_stop lw_minimise(lw_barrier_stage *stage, const double *x);

/* F(x) and its gradient (may be NULL) for any k >= 0; INFINITY where some g <= 0 (k > 0), where f is
 * not defined, and after a stop. */
double lw_barrier_value(lw_record *r, double k, const double *x, double *grad);

/* The same for methods that want a number everywhere.  Below the edge the logarithm goes on as its
 * Taylor polynomial of second order, so that a line search which steps over finds its way back by
 * interpolation (Ben-Tal & Zibulevsky 1997); such points never become the best.  Where f
 * is not defined, or the edge is 0, it is  wall (1 + sum of squared violations), with the gradient
 * that leads back. */
double lw_barrier_stage_value(lw_barrier_stage *stage, const double *x, double *grad);

/* True when the method has to come back: the record stopped or the share of this stage is used up. */
bool lw_barrier_stage_over(const lw_barrier_stage *stage);

/* All stages of k with a method that takes no conditions; the start is made feasible first.  Stop is
 * LW_STOP_FAILED when no feasible start was found. */
lw_stop lw_barrier_run(lw_record *r, lw_minimise *method, double *x);

/* One stage with this k, for methods that take conditions (k = 0), problems without, and searches of
 * the whole box.  Methods are started again from the best point while that pays. */
lw_stop lw_single_run(lw_record *r, lw_minimise *method, double k, bool again, double *x);

#endif
