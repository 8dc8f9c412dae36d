/* mbs/ode/cvode.h - stiff ordinary differential equations y' = f(t, y) by CVODE's BDF methods (Hindmarsh et al.
 * 2005); used like mbs/ode/integrate.h.
 *
 * One solver belongs to one thread.  Events are located to rounding on the solver's continuous solution, whose own
 * error is the tolerance. */
#ifndef LW_MBS_ODE_CVODE_H
#define LW_MBS_ODE_CVODE_H

#include "mbs/ode/integrate.h"

typedef struct lw_cvode {
    double  t, t_old;                /* end and beginning of the last step                          */
    const double *y;                 /* (n) at t                                                    */
    unsigned long long events;       /* bit i: event i happened at t                                */
    long    n_step, n_refused, n_rate, n_jacobian;
    struct lw_cvode_own *own;
} lw_cvode;

typedef enum lw_cvode_method { LW_CVODE_BDF, LW_CVODE_ADAMS } lw_cvode_method;

/* Begin at (t, y); ode must outlive w.  ode->project is used by BDF only.  o->fixed is not supported: LW_E_ARG.
 * After a failure w needs no _free. */
lw_status lw_cvode_make(lw_cvode *w, const lw_ode *ode, const lw_ode_options *o, lw_cvode_method method,
                        double t, const double *y, lw_error *e);
void      lw_cvode_free(lw_cvode *w);

/* As lw_integrate_restart, _step, _dense.  `first` is the length of the first step; 0: chosen as at the start.  t_end
 * must not lie before t. */
lw_status lw_cvode_restart(lw_cvode *w, const double *y, double first, lw_error *e);
lw_status lw_cvode_step(lw_cvode *w, double t_end, lw_ode_stop *stop, lw_error *e);
lw_status lw_cvode_dense(lw_cvode *w, double t, double *y);

#endif
