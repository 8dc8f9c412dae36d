/* optimise/solvers/record.h - what all solvers share: the function that is minimised, and the record of its values.
 *
 * A method asks the record for values. The record counts them, keeps the best feasible point, reports improvements to
 * the caller, and says when to stop. The point that a method returns is not used: COBYLA and SLSQP of NLopt 2.7 may
 * return a point worse than one they saw. */
#ifndef LW_OPTIMISE_SOLVERS_RECORD_H
#define LW_OPTIMISE_SOLVERS_RECORD_H

#include "optimise/solvers/solver.h"

/* Feasible: lo <= x <= hi exactly, and g >= -LW_FEASIBLE.  g is of order one, so this is rounding. */
#define LW_FEASIBLE  1e-12
/* A point this close is kept too and moved inside at the end, because methods that take constraints approach an active
 * one from outside. */
#define LW_NEARLY    1e-9

/* min f(x) = sum r_i(x)^2  subject to  lo <= x <= hi,  g(x) >= 0. */
typedef struct lw_function {
    size_t        n, m, n_residual;      /* variables <= LW_VAR_MAX, conditions, residuals        */
    const double *lo, *hi;               /* (n), may be infinite                                  */
    void         *context;
    /* as lw_problem_value, lw_problem_residuals, lw_problem_constraints; residuals may be NULL   */
    double (*value)(void *context, const double *x, double *grad);
    bool   (*residuals)(void *context, const double *x, double *r, double *j);
    void   (*conditions)(void *context, const double *x, double *g, double *j);
} lw_function;

typedef struct lw_record {
    const lw_function       *fn;
    const lw_solver_options *o;
    long    evals, limit;                /* limit: max_evals, less one that is reserved for the last point */
    double  started;                     /* [s]                                                   */
    bool    stopped;                     /* no further value is computed ...                      */
    lw_stop why;                         /* ... for this reason                                   */
    double  f, f_near;                   /* best feasible; best nearly feasible; INFINITY: none   */
    double  x[LW_VAR_MAX], x_near[LW_VAR_MAX];
    bool    known, known_j;              /* g, j below belong to gx                               */
    double  gx[LW_VAR_MAX];
    double *g, *j;                       /* (m), (m*n); owned                                     */
    bool    no_memory;                   /* a part of the method found none                       */
} lw_record;

/* Open a record: allocate g and j, evaluate nothing. LW_E_ARG: options outside their range. */
lw_status lw_record_open(lw_record *r, const lw_function *fn, const lw_solver_options *o);
void      lw_record_close(lw_record *r);

/* f(x), and its gradient unless grad is NULL; INFINITY where f is not defined, and after a stop. */
double lw_record_value(lw_record *r, const double *x, double *grad);

/* Residuals and derivatives, as lw_problem_residuals. False also after a stop. */
bool lw_record_residuals(lw_record *r, const double *x, double *res, double *j);

/* Count one evaluation without f, for a point outside the conditions. */
void lw_record_count(lw_record *r);

/* Use the reserved evaluation: offer x even after a stop. */
void lw_record_last(lw_record *r, const double *x);

/* g(x), (m), valid until the next call; if want_j, derivatives in r->j. Not counted as an evaluation. */
const double *lw_record_conditions(lw_record *r, const double *x, bool want_j);

/* Largest violation of bounds and conditions at x; 0: x is inside. */
double lw_record_violation(lw_record *r, const double *x);

/* Check time and interrupt. Every evaluation calls this, and so do methods in loops without an evaluation. */
bool lw_record_must_stop(lw_record *r);

/* Move x to the nearest point inside the bounds. */
void lw_clip(const lw_function *fn, double *x);

bool lw_finite(const double *x, size_t n);

#endif
