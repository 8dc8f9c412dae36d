/* mbs/ode/cvode.h - stiff ordinary differential equations y' = f(t, y) by CVODE's BDF methods (Hindmarsh et al.
 * 2005). */
#ifndef LW_MBS_ODE_CVODE_H
#define LW_MBS_ODE_CVODE_H

#include "mbs/ode/sundials.h"

typedef enum lw_cvode_method { LW_CVODE_BDF, LW_CVODE_ADAMS } lw_cvode_method;

/* Begin at (t, y); ode must outlive w.  ode->project is used by BDF only.  o->fixed is not supported: LW_E_ARG.
 * After a failure w needs no _free. */
lw_status lw_cvode_make(lw_sundials *w, const lw_ode *ode, const lw_ode_options *o, lw_cvode_method method,
                        double t, const double *y, lw_error *e);

/* As lw_integrate_restart.  `first` is the length of the first step; 0: chosen as at the start. */
lw_status lw_cvode_restart(lw_sundials *w, const double *y, double first, lw_error *e);

#endif
