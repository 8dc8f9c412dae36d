/* optimise/solvers/solver.h - a solver is a row of a table: one call improves one starting point.
 *
 * Every solver gets the same lw_problem. A record keeps the best feasible point seen, whatever the method returns. */
#ifndef LW_OPTIMISE_SOLVERS_SOLVER_H
#define LW_OPTIMISE_SOLVERS_SOLVER_H

#include "optimise/problem/problem.h"

struct lw_barrier_stage;

typedef enum lw_stop {
    LW_STOP_F_TOL,       /* the objective no longer falls                  */
    LW_STOP_X_TOL,       /* the variables no longer move                   */
    LW_STOP_GRADIENT,    /* the (projected) gradient is zero to rounding   */
    LW_STOP_F_TARGET,    /* f <= f_target                                  */
    LW_STOP_EVALS,       /* limit of evaluations                           */
    LW_STOP_TIME,        /* limit of seconds                               */
    LW_STOP_USER,        /* the caller requested a stop                    */
    LW_STOP_FAILED       /* the method failed; the best point is kept      */
} lw_stop;
const char *lw_stop_text(lw_stop s);

typedef struct lw_solver_options {
    uint64_t seed;
    long     max_evals;          /* of f, each with or without gradient                 (10000)  */
    double   max_seconds;        /* 0: no limit                                         (0)      */
    double   f_target;           /* stop when reached                                   (0)      */
    double   f_tol, x_tol;       /* relative                                            (1e-14)  */
    double   step;               /* gradient-fixed: k of eq. 20                         (1e-3)   */
    double   barrier_first;      /* k of eq. 18 over f at the start                     (1e-2)   */
    double   barrier_last;       /*      and at the end                                 (1e-10)  */
    double   barrier_ratio;      /* k falls by this factor between stages               (0.1)    */
    const volatile int *interrupt;   /* not NULL and *interrupt != 0: stop                       */
    /* called after each improvement, for work-precision curves; may be NULL */
    void   (*improved)(void *context, long evals, double seconds, double f);
    void    *context;
} lw_solver_options;
lw_solver_options lw_solver_options_default(void);

typedef struct lw_solver_result {
    double  f;                   /* at x, the best feasible point seen; INFINITY if none          */
    long    evals;
    lw_stop stop;
} lw_solver_result;

/* A method lowers F of a stage (barrier.h) from x, which it may change. The stage keeps the best point. */
typedef lw_stop lw_minimise(struct lw_barrier_stage *stage, const double *x);

typedef struct lw_solver {
    const char *name;            /* "slsqp": what --solver takes                                  */
    const char *source;          /* "Kraft 1994, NLopt"                                           */
    bool        global;          /* searches the whole box, needs finite bounds                   */
    bool        takes_constraints;   /* takes g(x) >= 0 itself; the others run inside the barrier */
    bool        takes_gradient;
    /* Improve x (n_var) in place. LW_OK; LW_STOPPED: by evaluations, time or user; LW_NOTHING: no feasible point was
     * seen. LW_NOTHING and errors (< 0) leave x unchanged. Thread-safe. */
    lw_status (*run)(const struct lw_solver *self, const lw_problem *p, const lw_solver_options *o, double *x, lw_solver_result *r);
    lw_minimise *minimise;       /* the method, if run is lw_method_solve; else NULL              */
} lw_solver;

extern const lw_solver lw_solver_table[];          /* ends with name == NULL; [0] is the default   */
const lw_solver *lw_solver_find(const char *name);

#endif
