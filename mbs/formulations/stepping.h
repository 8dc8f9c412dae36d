/* mbs/formulations/stepping.h - a run in pieces: go on to a time, look, change loads and states, go on.
 *
 * Every piece is a run of its own from the posture, velocities and states at its start, so what follows depends on
 * these and on the loads alone: a run that is saved and restored has the same bits as one that was not. */
#ifndef LW_MBS_FORMULATIONS_STEPPING_H
#define LW_MBS_FORMULATIONS_STEPPING_H

#include "mbs/dynamics/dynamics.h"

typedef struct lw_stepping lw_stepping;

/* The model must outlive s.  It starts at o->from; o->to and o->intervals are not used.  Errors: lw_dynamics_make;
 * LW_E_KIND also for an analysis that is no run in time. */
lw_status lw_stepping_make(const lw_model *m, const lw_dynamics_options *o, lw_stepping **s, lw_error *e);
lw_status lw_stepping_make_spatial(const lw_spatial *m, const lw_dynamics_options *o, lw_stepping **s, lw_error *e);
void      lw_stepping_free(lw_stepping *s);

/* Go on to t, and hand the moment there to sink (NULL: nobody).  A t that is not later than the present: the present
 * moment again.  After a failure s stands where it was before.  r gets the report of this piece, unless NULL; its `coarse` is that of all pieces
 * so far: with options.compare a planar model with contacts is run a second time beside s with less accuracy (lw_coarse_begin), to the end of each
 * piece, or of some where captured steps are as long as pieces. */
lw_status lw_stepping_advance(lw_stepping *s, double t, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_error *e);

double lw_stepping_time(const lw_stepping *s);
const lw_dynamics *lw_stepping_dynamics(const lw_stepping *s);

/* From now on a load acts on a link, besides all others; a load of 0 ends it.  Of a planar model: force, torque (3); of a
 * spatial one: force at the centre of mass (of an elastic link: at its first node), torque (6), in ground axes.  LW_E_ARG: no
 * such link, not finite. */
lw_status lw_stepping_set_load(lw_stepping *s, int link, const double *load);

/* Set a first-order state now.  LW_E_ARG: no such state, not finite. */
lw_status lw_stepping_set_state(lw_stepping *s, int state, double value);

/* The present as bytes, to be freed.  restore: LW_E_NOTATION when they are none, damaged, or those of another model, *s is
 * then unchanged. */
lw_status lw_stepping_save(const lw_stepping *s, void **bytes, size_t *size);
lw_status lw_stepping_restore(lw_stepping *s, const void *bytes, size_t size, lw_error *e);

#endif
