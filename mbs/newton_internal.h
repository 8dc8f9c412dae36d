/* mbs/newton_internal.h - the loop equations of a planar linkage and their Jacobian; internal to
 * mbs/newton*.c.
 *
 * Unknowns z: place x, y of each moving link's middle and its turn since the posture, then the change
 * of the first input.  Lengths are divided by the size of the posture. */
#ifndef LW_MBS_NEWTON_INTERNAL_H
#define LW_MBS_NEWTON_INTERNAL_H

#include "grammar/linkage.h"

typedef struct lw_loop_joint {
    lw_joint_kind kind;
    int           link[2];
    lw_vec2       arm[2];           /* the joint's point from the middle of each link, in the posture */
    lw_vec2       along;            /* of the slide, on link[0]                                       */
} lw_loop_joint;

typedef struct lw_loop {
    int           n;                /* coordinates, 3 a moving link                                   */
    int           m;                /* equations, those of the inputs last                            */
    int           n_link, n_joint, n_input;
    int           column[LW_LINK_MAX];     /* where a link's coordinates begin; -1 for the ground     */
    lw_vec2       middle[LW_LINK_MAX];     /* in the posture, from `centre`, over `size`              */
    lw_loop_joint joint[LW_JOINT_MAX];
    int           input[LW_INPUT_MAX];     /* its joint                                               */
    lw_vec2       centre;
    double        size;
} lw_loop;

/* LW_E_ARG, LW_E_KIND as lw_newton_create. */
lw_status lw_loop_make(const lw_linkage *k, lw_loop *p, lw_error *e);

/* Coordinates of the posture: z[n + 1]. */
void lw_loop_posture(const lw_loop *p, double *z);

/* What is left over in the m equations at z: f[m], and the greatest in size as value.  j, unless
 * NULL: the Jacobian m x (n + 1), by columns ld apart. */
double lw_loop_equations(const lw_loop *p, const double *z, double *f, double *j, int ld);

/* Where a point of a link is at z, in the plane [m]; `arm` from the link's middle in the posture. */
lw_vec2 lw_loop_point(const lw_loop *p, const double *z, int link, lw_vec2 arm);

/* The arm of a point given in the posture in the plane [m]. */
lw_vec2 lw_loop_arm(const lw_loop *p, int link, lw_vec2 at);

#endif
