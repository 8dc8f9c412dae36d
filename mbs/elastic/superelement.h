/* mbs/elastic/superelement.h - a body between n nodes in its own moving frame: strains e, the displacements and rotation vectors of
 * its nodes relative to the frame half-way between two of them, have the energy 1/2 e^T K e.  Rotations of the nodes against the
 * frame may have any angle below 180 degrees; K is that of small strains.  Its weight acts at the centre of mass, which follows from the
 * places of the nodes and the mass matrix, so that condensed bodies sag as the whole ones do.  In time the whole mass matrix moves with
 * the frame. */
#ifndef LW_MBS_ELASTIC_SUPERELEMENT_H
#define LW_MBS_ELASTIC_SUPERELEMENT_H

#include "mbs/elastic/beam_space.h"

#define LW_SUPER_NODES 100              /* at most */

typedef struct lw_super {
    const lw_superelement *p;
    int      a, b;                   /* nodes that carry the frame: the first, and the farthest from it */
    double   size;                   /* distance between them [m] */
    lw_vec3  gravity;                /* [m/s^2] */
    lw_mat3 *axes;                   /* (n) the frame's axes in those of each node */
    double  *work;                   /* e, stress, B (6n x 6n), K B, two gradients */
    lw_beam_node *still;             /* (n), */
    lw_vec3 *rate;                   /* (2n) scratch */
} lw_super;

/* turn: of each node's axes in the posture.  s needs lw_super_free, after LW_E_MEMORY too. */
lw_status lw_super_make(const lw_superelement *p, const lw_mat3 *turn, lw_vec3 gravity, lw_super *s);
void      lw_super_free(lw_super *s);

/* force (6n): force and moment on each node, ground axes; by_x, by_v (6n x 6n) its derivatives as in lw_beam_space_state; NULL: not
 * wanted.  node is as it was afterwards.  Returns the energy with that of the weight [J]; *power of the damping [W]. */
double lw_super_at(const lw_super *s, lw_beam_node *node, double *force, double *by_x, double *by_v, double *power);

/* Inertia with which the superelement moves: force (6n): force and moment on each node that its motion takes, ground axes, for the
 * accelerations and angular accelerations rate (2n), ground axes; momentum (6n): derivatives of the kinetic energy by velocities and
 * angular velocities of the nodes.  Either may be NULL, and rate without force.  Returns the kinetic energy [J]. */
double lw_super_inertia(const lw_super *s, const lw_beam_node *node, const lw_vec3 *rate, double *force, double *momentum);

/* The mass matrix (6n x 6n) by velocities and angular velocities of the nodes, ground axes. */
void lw_super_mass(const lw_super *s, const lw_beam_node *node, double *out);

/* First moment of the mass against node a, in ground axes [kg m]. */
lw_vec3 lw_super_moment(const lw_super *s, const lw_beam_node *node);

/* Condensation of the matrices of a mesh (n x n, n/6 nodes) to the nodes `keep`, ascending, by Guyan (1965), and to the lowest modes of
 * the others with those at rest (Craig & Bampton 1968).  Six modes are the strains e of each of `more` nodes, which lie at the first and
 * move with the frame as long as they are 0.  k and mass become 6 (nodes + more) square.  plane: motions in the plane and across it are
 * taken apart, and the strains along x and y and about z are the lowest modes in the plane.  at: places of the nodes kept.  rate,
 * turn: lw_superelement's; the caller frees them, after a failure too.  LW_E_NUMERIC: the other coordinates are not held by the stiffness,
 * or their mass is not positive definite. */
lw_status lw_super_reduce(int n, double *k, double *mass, int nodes, const int *keep, const lw_vec3 *at, int more, bool plane,
                          double **rate, double **turn);

/* The edges of a mesh for pictures: pairs of its first n nodes, displacements of which cause forces at each other by the stiffness
 * (6 n_matrix square).  Where it is condensed, so that all are such pairs: the shortest tree between the nodes (Prim 1957).  Returns how many;
 * free *edge.  -1: no memory. */
int lw_super_edges(int n, int n_matrix, const lw_vec3 *at, const double *stiffness, int (**edge)[2]);

/* Mass, centre [m] and inertia about it (as in lw_spatial_body) of a mass matrix when the body moves as a rigid one. */
void lw_super_rigid_mass(int n, const lw_vec3 *at, const double *mass, double *total, lw_vec3 *centre, double inertia[6]);

/* Share the mass among the nodes in proportion to the diagonal, their inertias too: lump (n), inertia (6n).  What the nodes then lack of the
 * inertia of the rigid body (total, centre, rigid) they get in equal parts, so that a shaft turns as it should; a bar in few pieces has too
 * much of it across its axis. */
void lw_super_lump(int n, const lw_vec3 *at, const double *mass, double total, lw_vec3 centre, const double rigid[6], double *lump,
                   double *inertia);

#endif
