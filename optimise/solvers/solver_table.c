/* optimise/solvers/solver_table.c - the table of solvers, built on the methods of method.c. */
#include "optimise/solvers/solver.h"

#include <string.h>
#include "optimise/solvers/lm.h"
#include "optimise/solvers/method_internal.h"

const lw_solver lw_solver_table[] = {
    { "lm", "Levenberg 1944, Marquardt 1963; steps by Goldfarb & Idnani 1983", false, false, true, lw_lm_run, NULL },
    { "lm-gsl", "Levenberg 1944, Marquardt 1963, GSL; conditions by augmented Lagrangian", false, true, true,
      lw_method_solve, lw_gsl_lm },
    { "gradient", "Makkonen 1999, eq. 20, with the step of Birgin, Martinez & Raydan 2000", false, false, true,
      lw_method_solve, lw_gradient },
    { "gradient-fixed", "Makkonen 1999, eq. 20, with a fixed step", false, false, true,
      lw_method_solve, lw_gradient_fixed },
    { "slsqp", "Kraft 1994, NLopt", false, true, true, lw_method_solve, lw_nlopt_slsqp },
    { "mma", "Svanberg 2002, NLopt", false, true, true, lw_method_solve, lw_nlopt_mma },
    { "ccsaq", "Svanberg 2002, NLopt", false, true, true, lw_method_solve, lw_nlopt_ccsaq },
    { "lbfgs", "Nocedal 1980, Luksan, NLopt", false, false, true, lw_method_solve, lw_nlopt_lbfgs },
    { "tnewton", "Dembo & Steihaug 1983, Luksan, NLopt", false, false, true, lw_method_solve, lw_nlopt_tnewton },
    { "cobyla", "Powell 1994, NLopt", false, true, false, lw_method_solve, lw_nlopt_cobyla },
    { "bobyqa", "Powell 2009, NLopt", false, false, false, lw_method_solve, lw_nlopt_bobyqa },
    { "neldermead", "Nelder & Mead 1965, Box 1965, NLopt", false, false, false,
      lw_method_solve, lw_nlopt_neldermead },
    { "sbplx", "Rowan 1990, NLopt", false, false, false, lw_method_solve, lw_nlopt_sbplx },
    { "crs", "Kaelo & Ali 2006, NLopt", true, false, false, lw_method_solve, lw_nlopt_crs },
    { "isres", "Runarsson & Yao 2005, NLopt", true, true, false, lw_method_solve, lw_nlopt_isres },
    { "esch", "da Silva Santos et al. 2010, NLopt", true, false, false, lw_method_solve, lw_nlopt_esch },
    { "direct", "Gablonsky & Kelley 2001, NLopt", true, false, false, lw_method_solve, lw_nlopt_direct },
    { "mlsl", "Kucherenko & Sytsko 2005, NLopt", true, false, true, lw_method_solve, lw_nlopt_mlsl },
    { NULL, NULL, false, false, false, NULL, NULL }
};

const lw_solver *lw_solver_find(const char *name)
{
    for (const lw_solver *s = lw_solver_table; s->name; s++)
        if (strcmp(s->name, name) == 0)
            return s;
    return NULL;
}
