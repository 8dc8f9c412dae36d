/* optimise/solvers/method_internal.h - the methods behind the rows of the solver table, for any lw_function.
 *
 * A row is one line of the list: a method that lowers F of a stage, whether it searches the whole box, and whether it
 * takes conditions itself. Methods that do not take conditions run inside the barrier. */
#ifndef LW_OPTIMISE_SOLVERS_METHOD_INTERNAL_H
#define LW_OPTIMISE_SOLVERS_METHOD_INTERNAL_H

#include "optimise/solvers/barrier.h"

/* id, name, searches the box, takes conditions, takes gradients, method, source; in the order of the table of solvers.
 */
#define LW_METHOD_LIST(X)                                                                          \
    X(lm_gsl, "lm-gsl", false, true, true, lw_gsl_lm,                                            \
      "Levenberg 1944, Marquardt 1963, GSL; conditions by augmented Lagrangian")                 \
    X(gradient, "gradient", false, false, true, lw_gradient,                                     \
      "Makkonen 1999, eq. 20, with the step of Birgin, Martinez & Raydan 2000")                  \
    X(gradient_fixed, "gradient-fixed", false, false, true, lw_gradient_fixed,                   \
      "Makkonen 1999, eq. 20, with a fixed step")                                                \
    X(slsqp, "slsqp", false, true, true, lw_nlopt_slsqp, "Kraft 1994, NLopt")                    \
    X(mma, "mma", false, true, true, lw_nlopt_mma, "Svanberg 2002, NLopt")                       \
    X(ccsaq, "ccsaq", false, true, true, lw_nlopt_ccsaq, "Svanberg 2002, NLopt")                 \
    X(lbfgs, "lbfgs", false, false, true, lw_nlopt_lbfgs, "Nocedal 1980, Luksan, NLopt")         \
    X(tnewton, "tnewton", false, false, true, lw_nlopt_tnewton,                                  \
      "Dembo & Steihaug 1983, Luksan, NLopt")                                                    \
    X(cobyla, "cobyla", false, true, false, lw_nlopt_cobyla, "Powell 1994, NLopt")               \
    X(bobyqa, "bobyqa", false, false, false, lw_nlopt_bobyqa, "Powell 2009, NLopt")              \
    X(neldermead, "neldermead", false, false, false, lw_nlopt_neldermead,                        \
      "Nelder & Mead 1965, Box 1965, NLopt")                                                     \
    X(sbplx, "sbplx", false, false, false, lw_nlopt_sbplx, "Rowan 1990, NLopt")                  \
    X(crs, "crs", true, false, false, lw_nlopt_crs, "Kaelo & Ali 2006, NLopt")                   \
    X(isres, "isres", true, true, false, lw_nlopt_isres, "Runarsson & Yao 2005, NLopt")          \
    X(esch, "esch", true, false, false, lw_nlopt_esch, "da Silva Santos et al. 2010, NLopt")     \
    X(direct, "direct", true, false, false, lw_nlopt_direct, "Gablonsky & Kelley 2001, NLopt")   \
    X(mlsl, "mlsl", true, false, true, lw_nlopt_mlsl, "Kucherenko & Sytsko 2005, NLopt")

typedef struct lw_method {
    const char  *name;
    bool         global, takes_constraints;
    lw_minimise *minimise;
} lw_method;

/* The whole run: start, stages, final repair, result. Returns as lw_solver.run does. */
lw_status lw_method_run(const lw_method *m, const lw_function *fn, const lw_solver_options *o,
                        double *x, lw_solver_result *result);

/* Improve x of a fitting problem by a method; allocates the scratch. Returns as lw_solver.run does. */
lw_status lw_method_solve(const lw_method *m, const lw_problem *p, const lw_solver_options *o, double *x,
                          lw_solver_result *result);

/* The method of the row of the table with this name; NULL: the row has none, or there is no such row. */
const lw_method *lw_method_find(const char *name);

lw_minimise lw_gsl_lm, lw_gradient, lw_gradient_fixed;
lw_minimise lw_nlopt_slsqp, lw_nlopt_mma, lw_nlopt_ccsaq, lw_nlopt_lbfgs, lw_nlopt_tnewton,
            lw_nlopt_cobyla, lw_nlopt_bobyqa, lw_nlopt_neldermead, lw_nlopt_sbplx, lw_nlopt_crs,
            lw_nlopt_isres, lw_nlopt_esch, lw_nlopt_direct, lw_nlopt_mlsl;

#endif
