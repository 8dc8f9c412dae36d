/* mbs/formulations/formulations.h - a model is made ready, its formulation chosen, and its analysis carried out. */
#ifndef LW_MBS_FORMULATIONS_FORMULATIONS_H
#define LW_MBS_FORMULATIONS_FORMULATIONS_H

#include "mbs/dynamics/dynamics.h"
#include "mbs/equilibrium/statics.h"

/* d needs lw_dynamics_free; the model must outlive d.  Projects the start onto the constraints, moves driven inputs to the start of their motions,
 * finds redundant rows, chooses the formulation.  LW_E_ARG: a mass is missing (the link is named), or the motions drive
 * more than the degrees of freedom; LW_E_KIND: the formulation cannot do this model; LW_OPEN, LW_E_NUMERIC: no posture or
 * velocity satisfies the constraints. */
lw_status lw_dynamics_make(const lw_model *m, const lw_dynamics_options *o, lw_dynamics **d, lw_error *e);
lw_status lw_dynamics_make_spatial(const lw_spatial *m, const lw_dynamics_options *o, lw_dynamics **d, lw_error *e);

/* Set another start for the next run: from, to, q, v (n_q) and z, which satisfy the constraints.  The formulation is chosen again. */
lw_status lw_dynamics_restart(lw_dynamics *d, double from, double to, const double *q, const double *v, const double *z,
                              lw_error *e);

/* Run.  Samples taken before a failure stay valid, and r->t is the time reached.  LW_E_NUMERIC: the motion cannot be continued, or
 * the error of its energy is far greater than the tolerance explains. */
lw_status lw_dynamics_run(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_error *e);

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
 * planar model with contacts is repeated with less accuracy, and r->coarse tells how far they differ, if the postures of its samples fit in
 * 160 MB; options.until ends both. */
lw_status lw_dynamics_analyse(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_rest *rest,
                              lw_error *e);

/* The parts of such a comparison.  Is a run of d to be compared?  The coarser options of the other run, with a comparison that begins; captured: its
 * contacts are.  Keep how far a posture is from that of the coarse run at t. */
bool          lw_coarse_suits(const lw_dynamics *d);
lw_coarse_run lw_coarse_begin(bool captured, lw_dynamics_options *o);
void          lw_coarse_compare(const lw_dynamics *d, double t, const double *q, const double *coarse, lw_coarse_run *r);

#endif
