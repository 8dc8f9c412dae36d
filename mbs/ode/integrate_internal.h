/* mbs/ode/integrate_internal.h - what integrate.c and integrate_event.c share. */
#ifndef LW_MBS_ODE_INTEGRATE_INTERNAL_H
#define LW_MBS_ODE_INTEGRATE_INTERNAL_H

#include "mbs/ode/integrate.h"

/* A step of length h from (t_old, y_old), k[0] known: its end in w->y and the lost bits in w->low, stages
 * in k[0 .. 11]. */
lw_status lw_rk_advance(lw_integrator *w, double h);

/* y_old + h*.. is done; project w->y at t_old + h_done and take f there into dy and k[12]. */
lw_status lw_rk_arrive(lw_integrator *w);

/* Events between t_old and t: passing ones are told to `seen`; at the first that is not, the step is
 * made to end (then *found, w->events). */
lw_status lw_rk_events(lw_integrator *w, bool *found);

#endif
