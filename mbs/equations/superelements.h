/* mbs/equations/superelements.h - superelements of a planar model: those of space (mbs/elastic/superelement.h), whose nodes move in the plane z = 0. */
#ifndef LW_MBS_EQUATIONS_SUPERELEMENTS_H
#define LW_MBS_EQUATIONS_SUPERELEMENTS_H

#include "grammar/model/model.h"
#include "mbs/constraints/system.h"
#include "mbs/elastic/superelement.h"
#include "mbs/equations/equations.h"

typedef struct lw_superelements {
    const lw_system       *system;
    const lw_superelement *given;        /* (n) the model's */
    int       n;
    lw_super *super;                     /* (n) */
    double    start;                     /* energy in the posture of the file [J] */
    double   *work;                      /* of the largest: force, derivatives, nodes, rates */
    double   *placed, *out;              /* (n_q) the posture placed last; scratch */
} lw_superelements;

/* LW_E_MEMORY.  x needs lw_superelements_free, after a failure too. */
lw_status lw_superelements_make(const lw_model *m, const lw_system *s, lw_superelements *x);
void      lw_superelements_free(lw_superelements *x);

/* Add the generalised forces (n_q) with the weight, and the power of damping; their derivatives to a sink, unless NULL. */
void lw_superelements_forces(const lw_superelements *x, const double *q, const double *v, double *force, double *power, const lw_force_sink *sink);
void lw_superelements_pattern(const lw_superelements *x, const lw_force_sink *sink);

/* The mass matrix, and the inertia for accelerations a, beyond the masses of the nodes: more_mass and more_inertia of lw_equations. */
void lw_superelements_mass(const lw_superelements *x, const double *q, const lw_force_sink *sink);
void lw_superelements_inertia(const lw_superelements *x, const double *q, const double *v, const double *a, double *out);

/* Kinetic energy beyond that of the nodes, at x->placed; potential with the weight (0 in the posture of the file); that of strains alone [J]. */
double lw_superelements_kinetic(const lw_superelements *x, const double *v);
double lw_superelements_potential(const lw_superelements *x, const double *q);
double lw_superelements_strain(const lw_superelements *x, const double *q);

/* What superelement i, a piece of a bar, does to its node at one end, less what it takes for its motion: force x, y and moment [N] [N m]. */
void lw_superelements_end(const lw_superelements *x, const double *q, const double *v, const double *a, int i, int end, double out[3]);

#endif
