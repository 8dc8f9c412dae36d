/* mbs/dynamics/dynamics_reduced_internal.h - a run in one coordinate: what its two ways share; internal to mbs/. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_REDUCED_INTERNAL_H
#define LW_MBS_DYNAMICS_DYNAMICS_REDUCED_INTERNAL_H

#include "mbs/dynamics/dynamics_run_internal.h"
#include "mbs/dynamics/reduced_internal.h"

/* The coordinate at the start and p = sqrt(M) s' there, by the velocities y of the bodies. */
lw_status lw_reduced_start(lw_reduced *r, const lw_dynamics *d, const double *y, double *s, double *p);

/* A mass M so many times the least one: a dead point is near.  Beside it the links move as the square root of what is
 * left of the coordinate's way: rounding and the error allowed there, both of the coordinate, are then too great. */
static const double lw_reduced_turning_back = 100;

#endif
