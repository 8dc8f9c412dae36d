/* optimise/solvers/solver_table.c - the table of solvers, built on the methods of method.c. */
#include "optimise/solvers/solver.h"

#include <string.h>
#include "optimise/solvers/lm.h"
#include "optimise/solvers/method_internal.h"

#define X(id, name, box, takes_g, takes_gradient, method, source)                                \
    static lw_status run_##id(const lw_problem *p, const lw_solver_options *o, double *x,        \
                              lw_solver_result *r)                                               \
    { return lw_method_solve(lw_method_find(name), p, o, x, r); }
LW_METHOD_LIST(X)
#undef X

const lw_solver lw_solver_table[] = {
    { "lm", "Levenberg 1944, Marquardt 1963; steps by Goldfarb & Idnani 1983", false, false, true,
      lw_lm_run },
#define X(id, name, box, takes_g, takes_gradient, method, source)                                \
    { name, source, box, takes_g, takes_gradient, run_##id },
    LW_METHOD_LIST(X)
#undef X
    { NULL, NULL, false, false, false, NULL }
};

const lw_solver *lw_solver_find(const char *name)
{
    for (const lw_solver *s = lw_solver_table; s->name; s++)
        if (strcmp(s->name, name) == 0)
            return s;
    return NULL;
}
