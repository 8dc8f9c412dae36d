/* mbs/dynamics/dynamics_space.h - runs of spatial models (mbs/dynamics/dynamics.h), and what their moments mean: places of
 * bodies, reactions, drives. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_SPACE_H
#define LW_MBS_DYNAMICS_DYNAMICS_SPACE_H

#include "mbs/dynamics/dynamics.h"
#include "mbs/elastic/expand_space.h"
#include "mbs/space/space_forces.h"
#include "mbs/space/space_trace.h"

const lw_space *lw_dynamics_space(const lw_dynamics *d);

/* A moment; arrays are the solver's and hold until the next one. */
typedef struct lw_space_moment {
    double t;
    const double *q, *v, *a;             /* scaled (mbs/space/space.h) */
    const lw_space_frame *frame;
    const double *input, *input_rate;    /* (n_input) as people count them */
    const double *drive;                 /* force [N] or torque [N m] of each drive (or input, if the model has no drives);
                                            0 for inputs that run freely */
    const lw_spatial_reaction *joint;    /* on link[1], about the joint's point there, ground axes */
    const double *coupling;              /* times a factor: force [N] or torque [N m] on the second link of the joint */
    double kinetic, potential, work;     /* [J] */
    double off, off_rate;                /* greatest residual of the rows, and of their rates */
} lw_space_moment;

/* LW_OPEN: the posture is singular for the drives; LW_E_ARG: the drives cannot carry the forces. */
lw_status lw_dynamics_space_moment(lw_dynamics *d, const lw_moment *m, lw_space_moment *out, lw_error *e);

/* The elastic links; NULL: there are none, or they are taken as rigid. */
const lw_spatial_expansion *lw_dynamics_spatial_elastic(const lw_dynamics *d);

/* The posture q (n_q of d) in which the links are as in a posture of the same model with rigid links, elastic ones undeformed;
 * inputs are held there, whatever their motion.  For modes. */
lw_status lw_dynamics_place_on_rigid(lw_dynamics *d, const lw_space *rigid, const double *rigid_q, double *q, lw_error *e);

/* Inside an elastic link at a node, in the axes of the section there, of the elements on both sides the mean: tension and shear forces
 * along y and z [N], torque and bending moments about y and z [N m]; the greatest stress, N/A + M/W [N/m^2]. */
typedef struct lw_space_inner { double normal, shear[2], torque, bending[2], stress; } lw_space_inner;

/* Linear momentum, and angular momentum about the origin (ground axes). */
void lw_dynamics_space_momentum(const lw_dynamics *d, const lw_space_moment *m, lw_vec3 *linear, lw_vec3 *angular);

/* out (n_node of the chain).  Of a condensed bar at its interface nodes: with what its weight adds up to there, exact at rest.  Of
 * a superelement with its own matrices: 0, it has no section. */
void lw_dynamics_space_inner(const lw_dynamics *d, const lw_space_moment *m, int chain, lw_space_inner *out);

/* Contact i of the model solved (n_contact): at a moment, and over the run so far. */
lw_space_touch          lw_dynamics_space_touch(const lw_dynamics *d, int i, const lw_space_moment *m);
const lw_space_contact *lw_dynamics_space_contact(const lw_dynamics *d, int i);

/* Signal i of the model: the output of a controller, the voltage of a motor, the opening of a valve. */
double lw_dynamics_space_signal(const lw_dynamics *d, int i, const lw_space_moment *m);
double lw_dynamics_space_strain(const lw_dynamics *d, const lw_space_moment *m);       /* of elastic links [J] */

/* Motion of all links (n_link) at a moment. */
void lw_space_links(const lw_space *s, const lw_space_moment *m, lw_frame_motion *out);

#endif
