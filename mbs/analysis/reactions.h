/* mbs/analysis/reactions.h - reactions of joints, driving torques and shaking forces, from the multipliers of a
 * moment (mbs/dynamics/dynamics.h). */
#ifndef LW_MBS_ANALYSIS_REACTIONS_H
#define LW_MBS_ANALYSIS_REACTIONS_H

#include "mbs/dynamics/dynamics.h"

/* out (n_joint). */
void lw_reactions_joints(const lw_dynamics *d, const lw_moment *m, lw_reaction *out);

/* Torque [N m] or force [N] on the inputs, in the order of the linkage's inputs, positive where it drives the input
 * up: that of the motion, 0 without one; of tied inputs, as if each had a motor of its own. */
void lw_reactions_driving(const lw_dynamics *d, const lw_moment *m, double *out);

/* Force of the moving masses on the frame, and its moment about the origin of the plane: -d/dt of momentum and
 * angular momentum, without weight. */
lw_reaction lw_reactions_shaking(const lw_dynamics *d, const lw_moment *m);

/* Inside an elastic link at a node, in the axes of the section there: tension and shear force [N], bending moment [N m], of the
 * elements on both sides the mean; and the stress of greatest absolute value, N/A + M/W on the side of the sign of N [N/m^2]. */
typedef struct lw_inner_force { double normal, shear, moment, stress; } lw_inner_force;

/* out (n_node of the chain, see lw_dynamics_elastic); NAN where a link with its own matrices, or a node that carries modes, has none. */
void lw_reactions_inner(const lw_dynamics *d, const lw_moment *m, int chain, lw_inner_force *out);

/* Forces of the contacts of the model on their second links, contact (n_contact), and tensions of its ropes, rope
 * (n_rope) [N].  Where places share a load in several ways (a block on three feet) the
 * forces keep to all limits of friction, with the least sum of squares. */
void lw_reactions_contacts(const lw_dynamics *d, const lw_moment *m, lw_vec2 *contact, double *rope);

#endif
