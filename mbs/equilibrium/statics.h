/* mbs/equilibrium/statics.h - equilibrium: forces balanced on the constraints. */
#ifndef LW_MBS_EQUILIBRIUM_STATICS_H
#define LW_MBS_EQUILIBRIUM_STATICS_H

#include "mbs/dynamics/dynamics.h"

typedef struct lw_rest {
    int    iterations;
    double residual;            /* greatest force left along the constraints [J] */
    bool   stable;              /* the stiffness is positive definite; else a saddle or a neutral equilibrium */
    bool   neutral;             /* nothing resists one motion (a buckled round column turns about its axis); stable is false */
    bool   unknown;             /* stability is not known: large models and elastic links under forces without a potential; stable is false */
} lw_rest;

/* "stable", "neutral", "not stable", or that and why it is not known. */
const char *lw_rest_text(const lw_rest *r);

/* Equilibrium nearest downhill from the start of d, inputs with a motion held at their values at t: q (n_q).
 * Newton's method on the reduced forces, with a shifted matrix where it is not positive definite.  LW_NOTHING: no
 * equilibrium was found, or it lies beyond a rigid stop (which is named); LW_OPEN: the linkage does not close.
 *
 * With contacts and ropes: where the model comes to rest from the posture of the file, damped in all motion. */
lw_status lw_statics_rest(lw_dynamics *d, double t, double *q, lw_rest *r, lw_error *e);

/* Hand the moment of rest at (t, q) to a sink: no velocities, reactions to weight and loads.  LW_OPEN: the posture is singular, and the
 * reactions handed on are NaN. */
lw_status lw_statics_moment(lw_dynamics *d, double t, const double *q, lw_moment_sink *sink, void *context,
                            lw_error *e);

/* The analysis of d, whichever it is: a run, or for a static one the moment of rest at its beginning, with *rest.  With options.compare a run of a
 * planar model with contacts is repeated with less accuracy, and r->coarse tells how far they differ, if there is no limit of time and the
 * postures of its samples fit in 160 MB. */
lw_status lw_dynamics_analyse(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_rest *rest,
                              lw_error *e);

#endif
