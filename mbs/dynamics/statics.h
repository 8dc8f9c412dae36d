/* mbs/dynamics/statics.h - where a model rests: forces balanced on the constraints. */
#ifndef LW_MBS_DYNAMICS_STATICS_H
#define LW_MBS_DYNAMICS_STATICS_H

#include "mbs/dynamics/dynamics.h"

typedef struct lw_rest {
    int    iterations;
    double residual;            /* greatest force left along the constraints [J]                          */
    bool   stable;              /* the stiffness is positive there; else it rests on a saddle, or anywhere along a
                                   motion that no force minds                                         */
} lw_rest;

/* Equilibrium nearest downhill from the start of d, inputs with a motion held at t: q (n_q).  Newton's method on
 * the reduced forces; where their matrix is not positive it is shifted until it is.  LW_NOTHING: no rest was found,
 * or it lies beyond a rigid stop (which is named); LW_OPEN: the linkage does not close. */
lw_status lw_statics_rest(lw_dynamics *d, double t, double *q, lw_rest *r, lw_error *e);

/* Hand the moment of rest at (t, q) to a sink: no velocities, reactions to weight and loads. */
lw_status lw_statics_moment(lw_dynamics *d, double t, const double *q, lw_moment_sink *sink, void *context,
                            lw_error *e);

#endif
