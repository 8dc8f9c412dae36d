/* mbs/dynamics/reactions.h - reactions of joints, driving torques and shaking forces, from the multipliers of a
 * moment (mbs/dynamics/dynamics.h). */
#ifndef LW_MBS_DYNAMICS_REACTIONS_H
#define LW_MBS_DYNAMICS_REACTIONS_H

#include "mbs/dynamics/dynamics.h"

/* out (n_joint). */
void lw_reactions_joints(const lw_dynamics *d, const lw_moment *m, lw_reaction *out);

/* Torque [N m] or force [N] on the inputs, in the order of the linkage's inputs, positive where it drives the input
 * up: that of the motion, 0 without one; of tied inputs, as if each had a motor of its own. */
void lw_reactions_driving(const lw_dynamics *d, const lw_moment *m, double *out);

/* Force of the moving masses on the frame, and its moment about the origin of the plane: -d/dt of momentum and
 * angular momentum, without weight. */
lw_reaction lw_reactions_shaking(const lw_dynamics *d, const lw_moment *m);

#endif
