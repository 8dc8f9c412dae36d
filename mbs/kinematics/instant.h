/* mbs/kinematics/instant.h - how one link moves against another at one moment: instant centre and inflection circle.
 * Derivatives are by the input, so that the results do not depend on its speed. */
#ifndef LW_MBS_KINEMATICS_INSTANT_H
#define LW_MBS_KINEMATICS_INSTANT_H

#include "grammar/linkage/linkage.h"     /* lw_instant_motion: linkwright.h */
#include "mbs/batch/posture.h"

/* The motion of `link` seen from `base`, in a posture with derivatives of order 2.  LW_E_ARG: no such links, or the
 * same one twice; LW_E_KIND: a link has neither a pin nor a tracer, so that the posture has no point of it. */
lw_status lw_instant_motion_of(const lw_linkage *k, const lw_posture *posture, int link, int base, lw_instant_motion *out);

/* The motion against the ground of a link with the point p[0], velocity p[1] and acceleration p[2], turned by angle[0 .. 2]
 * (derivatives by any parameter). */
lw_instant_motion lw_instant_motion_at(const lw_vec2 p[3], const double angle[3]);

#endif
