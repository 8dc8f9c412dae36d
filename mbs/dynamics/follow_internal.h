/* mbs/dynamics/follow_internal.h - the same for a model made ready; internal to mbs/. */
#ifndef LW_MBS_DYNAMICS_FOLLOW_INTERNAL_H
#define LW_MBS_DYNAMICS_FOLLOW_INTERNAL_H

#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/dynamics/follow.h"

/* Follow d, all of whose freedoms are driven, from its drawing; motion gives the inputs d->driven.  d must outlive f, which
 * uses its rows and factors. */
lw_status lw_follow_ready(lw_dynamics *d, lw_input_function *motion, void *context, double t, lw_follow **f, lw_error *e);

/* f frees its model with this function from now on. */
void lw_follow_own(lw_follow *f, void (*free_dynamics)(lw_dynamics *));

#endif
