/* mbs/elastic/beam.h - one Timoshenko beam element between two nodes, in the frame half-way between their rotations
 * (corotational; Crisfield 1990).
 *
 * The strains are the stretch x - h + y^2/2h of the vector (x, y) between the nodes in this frame, the shear y, and the turn from
 * node to node.  The stretch is that of the distance between the nodes, to second order: with x - h alone the element would turn
 * out of its direction under a tension above 12 EI/h^2, and a taut string would not resist across.  In these strains the stiffness
 * of the beam is diagonal: stretch EA/h, shear 12 EI/(h^3 (1 + k)), bending EI/h, torsion GJ/h, with k = 12 zeta EI/(G A h^2); about
 * an undeformed element it is the matrix of Makkonen (1999, appendix A).  The strain energy is U = 1/2 sum of k_i e_i^2, with e
 * functions of the nodes that rigid motions leave unchanged, and forces are its gradient: so forces and moments of an element
 * balance exactly, and exchanging its ends changes nothing.  Makkonen's frame is fixed to one end and takes moments about the
 * undeformed arm (eq. 37, 38), which loses both.
 *
 * Damping is proportional to stiffness: force k_i d e_i' with the time d [s]. */
#ifndef LW_MBS_ELASTIC_BEAM_H
#define LW_MBS_ELASTIC_BEAM_H

#include "grammar/model/model.h"

/* Element of length h: {stretch [N/m], shear [N/m], bending [N m/rad]} in the plane. */
void lw_beam_stiffness(const lw_section *s, const lw_material *m, double h, double out[3]);

/* An element at one moment.  Coordinates: x, y [m] and turn [rad] of the first node, then of the second. */
typedef struct lw_beam_state {
    double e[3], rate[3];            /* stretch [m], shear [m], bending [rad], and their rates */
    double force[6];                 /* on the nodes */
    double by_x[6][6], by_v[6][6];   /* derivatives of force; filled if asked for */
} lw_beam_state;

/* pull: tension at which derivatives are taken [N]; NULL: that of the stretch and its rate. */
void lw_beam_at(const lw_beam *b, const double x[6], const double v[6], bool derivatives, const double *pull, lw_beam_state *out);

/* Strain energy [J]. */
double lw_beam_energy(const lw_beam *b, const double x[6]);

/* Consistent mass of an element of mass m and length h with Timoshenko's shape functions (Friedman & Kosmatka 1993), in the
 * coordinates above for the direction of the element; k as above, r2 = I/A [m^2]. */
void lw_beam_mass(double m, double h, double k, double r2, double direction, double out[6][6]);

#endif
