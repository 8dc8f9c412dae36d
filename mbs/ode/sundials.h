/* mbs/ode/sundials.h - a solver of SUNDIALS while it runs: CVODE (mbs/ode/cvode.h) or IDA (mbs/ode/ida.h); used like
 * mbs/ode/integrate.h.
 *
 * One solver belongs to one thread.  Events are located to rounding on the solver's continuous solution, whose own
 * error is the tolerance. */
#ifndef LW_MBS_ODE_SUNDIALS_H
#define LW_MBS_ODE_SUNDIALS_H

#include "mbs/ode/integrate.h"

typedef struct lw_sundials {
    double  t, t_old;                /* end and beginning of the last step                          */
    const double *y;                 /* (n) at t                                                    */
    unsigned long long events;       /* bit i: event i happened at t                                */
    long    n_step, n_refused, n_rate, n_jacobian;       /* n_rate: evaluations of f or F           */
    struct lw_sun *own;
} lw_sundials;

/* As lw_integrate_step, _dense.  t_end must not lie before t. */
lw_status lw_sundials_step(lw_sundials *w, double t_end, lw_ode_stop *stop, lw_error *e);
lw_status lw_sundials_dense(lw_sundials *w, double t, double *y);
lw_status lw_sundials_slope(lw_sundials *w, double *dy);        /* of the continuous solution at the end of the last step */
void      lw_sundials_free(lw_sundials *w);

#endif
