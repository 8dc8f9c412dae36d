/* mbs/elastic/beam_space.h - the beam element of mbs/elastic/beam.h in space: six strains in the frame half-way between the
 * rotations of its nodes, three of the vector between them and the vector g of the rotation from one to the other, whose
 * components are the same in all three frames.
 *
 *     U = 1/2 sum of k_i e_i^2,    k = EA/h, 12 EIz/(h^3 (1 + ky)), 12 EIy/(h^3 (1 + kz)), G It/h, EIy/h, EIz/h
 *
 * Rotations between the nodes may have any angle below 360 degrees. */
#ifndef LW_MBS_ELASTIC_BEAM_SPACE_H
#define LW_MBS_ELASTIC_BEAM_SPACE_H

#include "base/vec3.h"
#include "grammar/model/spatial.h"

typedef struct lw_beam_space {
    double  length;
    double  stiffness[6];        /* stretch, shear along y and z [N/m]; torsion, bending about y and z [N m/rad] */
    double  damping;             /* [s] */
    lw_mat3 axes[2];             /* x along the beam, y, z of the section, in the axes of each node */
} lw_beam_space;

/* A node: place [m], its axes, velocity and angular velocity, all in ground axes. */
typedef struct lw_beam_node { lw_vec3 at; lw_mat3 turn; lw_vec3 v, omega; } lw_beam_node;

typedef struct lw_beam_space_state {
    double  energy;
    double  stretch, stretch_rate;   /* [m] [m/s] */
    double  power;               /* of the dampers [W] */
    lw_mat3 frame;               /* the mid frame; columns are its axes */
    double  force[12];           /* force and moment on each node, in ground axes [N] [N m] */
    double  by_x[12][12];        /* derivatives of force by small displacements and turns of the nodes, in ground axes; without
                                    those of the rates of damping */
    double  by_v[12][12];        /* by velocities and angular velocities */
} lw_beam_space_state;

/* The frame half-way between the rotations of two nodes, axes: those of the frame in the axes of each node.  g: rotation vector from
 * the first to the second; small turns t of the nodes, in the frame's axes, turn it by (t0 + t1)/2 - q g x (t1 - t0), and change g by
 * k (t1 - t0) + n g (g . (t1 - t0)).  dq: derivative of q by |g|^2/4. */
typedef struct lw_mid_frame { lw_mat3 turn; lw_vec3 g; double q, dq, k, n; } lw_mid_frame;
lw_mid_frame lw_mid_frame_of(const lw_mat3 *first, const lw_mat3 *second);

void lw_beam_space_stiffness(const lw_section *s, const lw_material *m, double h, double out[6]);
/* pull: as for lw_beam_at. */
void lw_beam_space_at(const lw_beam_space *b, const lw_beam_node node[2], bool derivatives, const double *pull, lw_beam_space_state *out);

/* Consistent mass of an element less the lumps at its nodes, by displacements and turns of the nodes in its own axes: Timoshenko's
 * shape functions in both planes (mbs/elastic/beam.h), linear ones for stretch and torsion. */
void lw_beam_space_mass(const lw_spatial_beam *p, double out[12][12]);

#endif
