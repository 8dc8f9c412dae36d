/* mbs/dynamics/reactions.h - what joints carry and what a machine shakes its frame with, from the multipliers of a moment
 * (mbs/dynamics/dynamics.h). */
#ifndef LW_MBS_DYNAMICS_REACTIONS_H
#define LW_MBS_DYNAMICS_REACTIONS_H

#include "mbs/dynamics/dynamics.h"

/* out (n_joint). */
void lw_reactions_joints(const lw_dynamics *d, const lw_moment *m, lw_reaction *out);

/* Torque [N m] or force [N] on the driven joints, in the order of the linkage's inputs, positive where it drives the input
 * up: what the motion takes, 0 without one, and what the ties take, as if each input had a motor of its own. */
void lw_reactions_drives(const lw_dynamics *d, const lw_moment *m, double *out);

/* Force on the frame and moment about the origin of the plane that masses in motion cause: -d/dt of momentum and
 * angular momentum, weight left out. */
lw_reaction lw_reactions_shaking(const lw_dynamics *d, const lw_moment *m);

#endif
