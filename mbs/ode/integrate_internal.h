/* mbs/ode/integrate_internal.h - shared by integrate.c and integrate_event.c. */
#ifndef LW_MBS_ODE_INTEGRATE_INTERNAL_H
#define LW_MBS_ODE_INTEGRATE_INTERNAL_H

#include "mbs/ode/integrate.h"

/* One step of length h from (t_old, y_old) with k[0] given: its end in w->y, the lost digits in w->low, the stages in
 * k[0 .. 11]. */
lw_status lw_rk_advance(lw_integrator *w, double h);

/* After the step: project w->y at t_old + h_done and evaluate f there into dy and k[12]. */
lw_status lw_rk_arrive(lw_integrator *w);

/* Find events between t_old and t.  Passing ones are reported to `seen`; the step ends at the first other one (*found,
 * w->events). */
lw_status lw_rk_events(lw_integrator *w, bool *found);

#endif
