/* mbs/space/recursive.h - a spatial model in the coordinates of its joints.
 *
 * The joints that reach every body from the ground are a tree; the others, and rows of inputs and of spins that are held, close
 * loops.  Joints are cut where they have the fewest rows.  Coordinates x of the tree: turns [rad], slides over `unit`, a
 * quaternion for a ball joint, place and quaternion for a body that no joint reaches; rates u: the same, angular velocity in
 * the axes of link 0 for a quaternion.  A posture and its rates take one pass from the ground outwards, the inertias of the
 * articulated bodies one pass inwards, accelerations one pass more: work in proportion to the number of bodies
 * (Featherstone 1983; Rodriguez, Jain & Kreutz-Delgado 1991 for the factors of the mass matrix).  Loops:
 *
 *     M u' + J^T l = Q,   J u' = c,     M = L D^-1 L^T,   J M^-1 J^T = Y D Y^T,   Y = J L^-T   one pass inwards for each row of J
 *
 * over a basis of the rows of J, chosen by pivots in every posture. */
#ifndef LW_MBS_SPACE_RECURSIVE_H
#define LW_MBS_SPACE_RECURSIVE_H

#include "mbs/space/space.h"

/* Force and moment, or velocity and turn, about the centre of a body in ground axes. */
typedef struct lw_screw { lw_vec3 turn, move; } lw_screw;

/* Inertia of an articulated body: moment = J alpha + B a, force = B^T alpha + M a; J and M by xx yy zz xy xz yz. */
typedef struct lw_articulated { double j[6], m[6]; lw_vec3 b[3]; } lw_articulated;

typedef struct lw_recursive_body {           /* in the order of the tree, parents first */
    int           body, parent;              /* number in lw_space; place in this order, -1: ground */
    int           joint;                     /* -1: none reaches it */
    bool          back;                      /* the body is link 0 of the joint */
    lw_spatial_kind kind;
    int           x, u, n_u;                 /* its coordinates begin at x, its rates at u */
    lw_quaternion fixed;                     /* turn of body 1 against body 0 in the posture of the file */
    lw_vec3       arm[2];                    /* of the joint's point, over unit */
    /* at the posture and the rates placed last */
    lw_quaternion turn;
    lw_vec3       at, from_parent;           /* centre over unit; from the parent's centre */
    lw_mat3       axes;
    lw_screw      velocity, bias;            /* bias: acceleration when the parent and the rates do not accelerate */
    lw_articulated inertia;
    lw_screw      load, a;
} lw_recursive_body;

typedef struct lw_recursive_row {
    int     *body;                           /* (s->n_side) -1: ground, or none */
    double  *jac, phi, bias;                 /* (6*s->n_side) */
    lw_screw *pull;                          /* (s->n_side) */
} lw_recursive_row;

typedef struct lw_recursive {
    const lw_space *s;
    const double *mass;                      /* (n_v) diagonal of the mass matrix of the bodies */
    int       n_x, n_u, n_row, rank;         /* rank: independent rows of loops */
    int       n_cut, *cut;                   /* joints that close loops */
    int       n_extra;
    const lw_space_extra *extra;
    int      *place;                         /* (n_body) of a body in the order of the tree */
    lw_recursive_body *body;                 /* (n_body); body[-1]: the ground */
    lw_screw *axis, *push;                   /* (n_u) motion by each rate; inertia times it */
    double   *by_inertia, *free_rate;        /* (n_u) 1/(axis push); acceleration before what the parent adds */
    lw_recursive_row *row;                   /* (n_row) */
    double   *half, *schur, *l, *along;      /* Y (n_u x n_row, rows of J beside each other); U (n_row x n_row); (n_row); (n_u) */
    double   *sorted;                        /* (n_row) scratch */
    int      *order;                         /* (n_row) of elimination: the first `rank` are kept */
    lw_screw *pull;                          /* (n_body) scratch */
    int      *side;                          /* (s->n_side) scratch */
    lw_space_frame *frame;                   /* (n_body + 1) at the posture of the rows */
    double    weak;                          /* least pivot of loops over the greatest; 1: none */
    void     *memory;
} lw_recursive;

/* mass and extra (rows besides those of the joints) must outlive r.  LW_E_MEMORY. */
lw_status lw_recursive_make(const lw_space *s, const double *mass, const lw_space_extra *extra, int n_extra, lw_recursive *r, lw_error *e);
void      lw_recursive_free(lw_recursive *r);

/* Coordinates and rates of a posture q (n_q) and velocities v (n_v) of the bodies; and back, which also places. */
void lw_recursive_of_bodies(lw_recursive *r, const double *q, const double *v, double *x, double *u);
void lw_recursive_place(lw_recursive *r, const double *x, double *q);
void lw_recursive_velocities(lw_recursive *r, const double *u, double *v);

/* x' for rates u, and a posture moved by a small displacement. */
void lw_recursive_rates(const lw_recursive *r, const double *x, const double *u, double *dx);
void lw_recursive_move(const lw_recursive *r, double *x, const double *by);

/* The same posture with quaternions of length 1; with whole turns taken off angles beyond one turn (true: there were some). */
void lw_recursive_normalise(const lw_recursive *r, double *x);
bool lw_recursive_wrap(const lw_recursive *r, double *x);

/* turn (n_joint) of the joints of the tree: those nearest to the last ones at coordinates x. */
void lw_recursive_count_turns(const lw_recursive *r, const double *x, double *turn);

/* Rows at the posture and velocities placed last, with the angle near which extra i counts and its wanted value (over its unit)
 * and second rate, and turns (n_joint) near which couplings count: phi, jac, bias.  Rows of joints that are cut, couplings, extras. */
void lw_recursive_rows(lw_recursive *r, const double *near, const double (*wanted)[3], const double *turn, const double *v);

/* Factor the masses and the rows at the posture placed last.  LW_OPEN: a singular posture; LW_E_ARG: a motion without mass. */
lw_status lw_recursive_factor(lw_recursive *r);

/* l (n_row) of the i-th row left out by lw_recursive_factor: multipliers of the rows that do nothing to the rates of the tree. */
void lw_recursive_dependence(lw_recursive *r, int i);

/* Accelerations du (n_u) under forces of the bodies (n_v, NULL: none, and no bias), with J du as the rows say: -phi, the second
 * rate, or what is in r->l (n_row). */
typedef enum lw_recursive_want { LW_WANT_CLOSED, LW_WANT_MOTION, LW_WANT_GIVEN } lw_recursive_want;
void lw_recursive_solve(lw_recursive *r, const double *force, lw_recursive_want want, double *du);

/* Accelerations a (n_v) of the bodies for those of the rates at the posture and velocities placed last. */
void lw_recursive_accelerations(lw_recursive *r, const double *du, double *a);

#endif
