/* mbs/equations/flying.h - groups of bodies of a spatial scene that nothing joins to the ground: whatever acts inside a group, it keeps
 * its angular momentum about its centre of mass, and its linear momentum but for gravity.  Integrators keep them to their tolerance
 * only; here the velocities are put back on them by the smallest change, a motion of the group as one rigid body.  A body by itself
 * keeps the energy of its rotation, too: it is turned by the smallest angle that gives it this energy at its angular momentum. */
#ifndef LW_MBS_EQUATIONS_FLYING_H
#define LW_MBS_EQUATIONS_FLYING_H

#include "mbs/space/space_forces.h"

/* Momenta of a group; angular: about its centre of mass, ground axes.  body: its last one. */
typedef struct lw_flying_group { double mass, inertia[6], spin; lw_vec3 centre, linear, angular; int bodies, body; } lw_flying_group;

typedef struct lw_flying {
    int     n;                           /* groups */
    int    *group;                       /* (n_body) of a body; -1: joined to the ground */
    lw_flying_group *kept, *now;         /* (n) at the start; scratch */
    double  since;                       /* the time of `kept` [s] */
} lw_flying;

/* Joints but free ones, springs, elements and contacts join bodies; forces of the file, inputs and rotors hold their links to the
 * ground.  n = 0 where no group flies.  LW_E_MEMORY.  It needs lw_flying_free, after a failure too. */
lw_status lw_flying_make(const lw_space *s, lw_flying *f, lw_error *e);
void      lw_flying_free(lw_flying *f);

/* Note the momenta at time t. */
void lw_flying_note(const lw_space_forces *forces, const lw_space_frame *frame, const double *v, double t, lw_flying *f);

/* Put v (n_v) on them, and turn bodies that fly alone (q, frame); rigid (n_v): the part of v by which groups move as rigid bodies, 0
 * for other bodies. */
void lw_flying_hold(const lw_space_forces *forces, double t, double *q, lw_space_frame *frame, double *v, double *rigid, lw_flying *f);

#endif
