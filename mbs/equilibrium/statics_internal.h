/* mbs/equilibrium/statics_internal.h - equilibrium of models of any size (mbs/equilibrium/statics_large.c); internal to mbs/. */
#ifndef LW_MBS_EQUILIBRIUM_STATICS_INTERNAL_H
#define LW_MBS_EQUILIBRIUM_STATICS_INTERNAL_H

#include "mbs/run/run_internal.h"
#include "mbs/equilibrium/statics.h"

/* As lw_statics_rest. */
lw_status lw_statics_rest_large(lw_dynamics *d, double t, double *q, lw_rest *r, lw_error *e);

/* A quasi-static run: equilibrium at the time of every sample, each sought from the one before.  Velocities are those that the
 * motions of inputs cause while loads stay as they are. */
lw_status lw_statics_run_large(lw_run *run);

#endif
