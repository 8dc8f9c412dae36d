/* optimise/problem/tracers.h - several points of one mechanism: on which links they lie.
 *
 * The first tracer of a family is the point that is fitted.  Further points of a target lie on further tracers: those
 * that the family's linkage brings, else new ones.  In the four-link types a point lies on the coupler, and an angle
 * alone is that of the output (of the coupler when the output is the first), unless the task names another link. */
#ifndef LW_OPTIMISE_PROBLEM_TRACERS_H
#define LW_OPTIMISE_PROBLEM_TRACERS_H

#include "optimise/problem/family.h"

/* The linkage of a family with a tracer for every point of the target.  LW_E_KIND: the family has no such link, or the
 * link only slides and has no angle. */
lw_status lw_tracers_linkage(const lw_family *family, const lw_target *target, const lw_fit_spec *spec, lw_linkage *linkage, lw_error *e);

/* The tracers that a plan needs for this target: bits of lw_plan_options.tracers. */
unsigned lw_tracers_mask(const lw_target *target);

/* The role of a link that carries a tracer: input, coupler or output. */
lw_carrier lw_tracers_carrier(const lw_linkage *linkage, int link);

/* Does a link keep its direction because a slide joins it to the ground? */
bool lw_tracers_only_slides(const lw_linkage *linkage, int link);

/* Tracer number i, from 0, becomes a new one on this link; the tracers behind it go.  Its place is the mean of the
 * link's joints, which nobody reads. */
void lw_tracers_put(lw_linkage *linkage, int i, int link);

#endif
