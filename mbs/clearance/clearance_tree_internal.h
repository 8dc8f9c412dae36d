/* mbs/clearance/clearance_tree_internal.h - coordinates of a linkage with some joints opened; internal to mbs/.
 *
 * A tree of pins, sliders and welds from the ground spans the joints that stay.  The coordinate of a pin is the turn of
 * its outer link since the posture, that of a slider its displacement; a link without such a joint has its place and
 * turn:
 *     q = q(u),   dq/dt = B du/dt,   d2q/dt2 = B d2u/dt2 + bias.
 * The other joints, which close loops, and driven inputs are rows of mbs/constraints/system.h times B, with
 * multipliers. */
#ifndef LW_MBS_CLEARANCE_CLEARANCE_TREE_INTERNAL_H
#define LW_MBS_CLEARANCE_CLEARANCE_TREE_INTERNAL_H

#include "mbs/constraints/system.h"

/* Connection of a body to the tree. */
typedef struct lw_tree_joint {
    int     parent;                      /* body; -1: ground */
    enum { LW_TREE_PIN, LW_TREE_SLIDE, LW_TREE_WELD, LW_TREE_FREE } kind;
    int     joint;
    lw_vec2 arm[2];                      /* of the joint on the parent and on the body */
    double  sign;                        /* slide: +1 where the body is link[1], else -1 */
    int     coordinate;                  /* its own; -1: weld.  Free: the first of three */
    int     turn;                        /* the coordinate that is its turn; -1: it does not turn */
    int     n_path, path[LW_SYSTEM_Q_MAX];   /* coordinates that move it */
} lw_tree_joint;

typedef struct lw_tree {
    const lw_system *s;
    int n_u;
    int n_body, order[LW_LINK_MAX];      /* bodies, parents first */
    lw_tree_joint hang[LW_LINK_MAX];     /* of body b */
    int n_close, close[LW_JOINT_MAX];    /* joints neither in the tree nor opened */
    int n_row;                           /* number of their rows */
} lw_tree;

/* State of the tree at one moment; b[body*n_u + k] is the derivative of the place of the body by coordinate k. */
typedef struct lw_tree_state {
    lw_vec2  at[LW_LINK_MAX], dir[LW_LINK_MAX];      /* of body b at b + 1; ground at 0 */
    double   turn[LW_LINK_MAX], spin[LW_LINK_MAX];
    lw_vec2  bias[LW_LINK_MAX];
    lw_vec2 *b;
} lw_tree_state;

/* (n_joint) opened: joints to leave out; apart: joints to keep as rows with multipliers, outside the tree. */
void lw_tree_make(const lw_system *s, const bool *opened, const bool *apart, lw_tree *t);

/* Place everything at (u, du); du NULL: places and derivatives only. */
void lw_tree_place(const lw_tree *t, const double *u, const double *du, lw_tree_state *s);

/* u (n_u) from body coordinates q, and du from v unless du is NULL. */
void lw_tree_read(const lw_tree *t, const double *q, const double *v, double *u, double *du);

/* Body coordinates q (n_q) of a state, and velocities v unless v is NULL (du is needed then). */
void lw_tree_write(const lw_tree *t, const lw_tree_state *s, const double *du, double *q, double *v);

/* Accelerations a (n_q) of the bodies for ddu, at a placed state. */
void lw_tree_accelerations(const lw_tree *t, const lw_tree_state *s, const double *ddu, double *a);

/* A point fixed to a body (-1: ground), r its turned arm: its velocity; adds the generalised force (n_u) of a force
 * f on it. */
lw_vec2 lw_tree_velocity(const lw_tree *t, const lw_tree_state *s, int body, lw_vec2 r, const double *du);
void    lw_tree_push(const lw_tree *t, const lw_tree_state *s, int body, lw_vec2 r, lw_vec2 f, double torque, double *force);

#endif
