/* mbs/dynamics/statics_internal.h - equilibrium of the equations of small vibrations; internal to mbs/. */
#ifndef LW_MBS_DYNAMICS_STATICS_INTERNAL_H
#define LW_MBS_DYNAMICS_STATICS_INTERNAL_H

#include "mbs/dynamics/dynamics_run_internal.h"
#include "mbs/dynamics/statics.h"
#include "mbs/dynamics/vibration_internal.h"

/* Move q downhill to equilibrium, a stable one where there is one near.  LW_NOTHING: the forces drive it away. */
lw_status lw_vibration_rest(lw_vibration *v, double t, double *q, lw_rest *r, lw_error *e);

/* The same from the start of d, for models of any size (mbs/dynamics/statics_large.c): as lw_statics_rest. */
lw_status lw_statics_rest_large(lw_dynamics *d, double t, double *q, lw_rest *r, lw_error *e);

/* A quasi-static run: equilibrium at the time of every sample, each sought from the one before.  Velocities are those that the
 * motions of inputs cause while loads stay as they are. */
lw_status lw_statics_run_large(lw_run *run);

#endif
