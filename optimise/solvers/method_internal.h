/* optimise/solvers/method_internal.h - solvers whose row of the table has a method, which lowers F of a stage.
 * They work for any lw_function.  Methods that do not take conditions run inside the barrier. */
#ifndef LW_OPTIMISE_SOLVERS_METHOD_INTERNAL_H
#define LW_OPTIMISE_SOLVERS_METHOD_INTERNAL_H

#include "optimise/solvers/barrier.h"

/* The whole run: start, stages, final repair, result. Returns as lw_solver.run does. */
lw_status lw_method_run(const lw_solver *m, const lw_function *fn, const lw_solver_options *o, double *x, lw_solver_result *result);

/* lw_solver.run of a row with a method; allocates the scratch. */
lw_status lw_method_solve(const lw_solver *m, const lw_problem *p, const lw_solver_options *o, double *x, lw_solver_result *result);

lw_minimise lw_gsl_lm, lw_gradient, lw_gradient_fixed;
lw_minimise lw_nlopt_slsqp, lw_nlopt_mma, lw_nlopt_ccsaq, lw_nlopt_lbfgs, lw_nlopt_tnewton,
            lw_nlopt_cobyla, lw_nlopt_bobyqa, lw_nlopt_neldermead, lw_nlopt_sbplx, lw_nlopt_crs,
            lw_nlopt_isres, lw_nlopt_esch, lw_nlopt_direct, lw_nlopt_mlsl;

#endif
