/* mbs/space/recursive_stages.h - the equations of an open tree (mbs/space/recursive.h) in eight states at once.
 *
 * For integrators whose stages do not depend on each other (mbs/ode/collocation.h).  All joints have coordinates whose rates are
 * their derivatives (no balls, no free bodies); the loads are gravity and linear springs and dampers between points.  Number i of
 * a state in lane k is y[8*i + k]; a state is x, u and, if wanted, the work that dampers have done [J]. */
#ifndef LW_MBS_SPACE_RECURSIVE_STAGES_H
#define LW_MBS_SPACE_RECURSIVE_STAGES_H

#include "mbs/space/recursive.h"
#include "mbs/space/space_forces.h"

typedef struct lw_stage_body {
    int  parent;                             /* place in the order of the tree, -1: ground */
    lw_spatial_kind kind;
    bool back;                               /* the body is link 0 of the joint */
    bool leaf, last_child;                   /* it has no children; it is the last one of its parent's */
    int  x, u, n_u, angle;                   /* its first coordinate, rate, half angle */
    lw_vec3 arm[2], z, along[2];             /* joint's point over unit; axis, and directions of slides in body 0; */
    lw_vec3 second;                          /* universal: the axis of body 1 */
    double  pitch;                           /* slide over unit for each radian */
    lw_quaternion part[2];                   /* body 1 against body 0: cosine and sine of the half angle times these */
    double  mass[4];                         /* of the centre; about the principal axes */
    lw_vec3 weight;                          /* generalised force of gravity */
} lw_stage_body;

typedef struct lw_stage_spring { int body[2]; lw_vec3 arm[2]; double stiffness, damping, free; } lw_stage_spring;  /* over unit */

typedef struct lw_tree_stages {
    int     n_body, n_x, n_u, n_angle, n_spring;
    bool    has_work;
    double  unit;
    lw_stage_body   *body;                   /* (n_body) */
    lw_stage_spring *spring;
    int    *turn;                            /* (n_angle) coordinates of the angles */
    double *angle, *cosine, *sine;           /* (8 n_angle) halves */
    void   *state;                           /* scratch of the kernels, */
    const struct lw_tree_kernel *kernel;     /* which are those of the processor */
    const char *isa;
    void  (*turns)(size_t n, const double *angle, double *cosine, double *sine);
    void   *memory;
} lw_tree_stages;

/* r is a tree without rows, f its loads; both must outlive s.  LW_E_KIND: it has rows, balls or other loads; LW_E_MEMORY. */
lw_status lw_tree_stages_make(const lw_recursive *r, const lw_space_forces *f, bool has_work, lw_tree_stages *s);
void      lw_tree_stages_free(lw_tree_stages *s);

/* dy of eight states y, but x'.  LW_E_ARG: a motion without mass. */
lw_status lw_tree_stages_rates(lw_tree_stages *s, const double *y, double *dy);

#endif
