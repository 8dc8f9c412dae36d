/* optimise/tracers.h - several points of one mechanism: on which links they lie.
 *
 * The first tracer of a family is the point that is fitted.  Further points of a target lie on further tracers: those
 * that the family's linkage brings, else new ones.  Of the four-link types a point lies on the coupler and an angle
 * alone is that of the output (of the coupler, when the output is the first), unless the task names another link. */
#ifndef LW_OPTIMISE_TRACERS_H
#define LW_OPTIMISE_TRACERS_H

#include "optimise/family.h"

/* The linkage of a family with a tracer for every point of the target.  LW_E_KIND: it has no such link, or its
 * output only slides and has no angle. */
lw_status lw_tracers_linkage(const lw_family *f, const lw_target *t, const lw_fit_spec *s, lw_linkage *k, lw_error *e);

/* Those of a plan for this target: bits of lw_want.tracers. */
unsigned lw_tracers_mask(const lw_target *t);

#endif
