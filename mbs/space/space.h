/* mbs/space/space.h - the constraint rows of a spatial model, their derivatives, and what velocities add.
 *
 * Lengths are in multiples of `unit`, the size of the model, as in the plane (mbs/constraints/system.h).  A body has 7
 * coordinates, its centre of mass in ground axes and a quaternion w, x, y, z of any length that turns its principal axes
 * to ground axes; and 6 velocities, that of the centre in ground axes and omega [rad/s] in principal axes.  So the mass
 * matrix is diagonal and constant, m m m I1 I2 I3 [kg m^2], and forces are energies [J].  A row of a joint touches two bodies at
 * most; its derivatives by their velocities are 12 numbers.  That of a coupling touches the bodies of all its joints, in 6 numbers for
 * each.  Frames, points and values of measures are in SI units. */
#ifndef LW_MBS_SPACE_SPACE_H
#define LW_MBS_SPACE_SPACE_H

#include "grammar/model/spatial.h"

#define LW_SPACE_ROW 12          /* derivatives of the row of a joint or measure: by 6 velocities of each of two bodies */

/* A body's place; [0] of an array of frames is the ground, [b + 1] body b. */
typedef struct lw_space_frame { lw_vec3 at; lw_mat3 turn; } lw_space_frame;

typedef struct lw_space_joint {
    lw_spatial_kind kind;
    int     body[2];             /* -1: ground                                                        */
    int     row;                 /* its first row                                                     */
    lw_vec3 arm[2];              /* its point on each body, in the body's axes                        */
    lw_vec3 x[2], y[2], z[2];    /* a frame on each body, equal in the posture; z is the axis.  Universal: x[0] is the
                                  * axis of link 0, x[1] that of link 1                               */
    double  fixed;               /* universal: cosine between the axes                                */
    double  pitch;               /* screw: slide per radian [m]                                       */
} lw_space_joint;

/* The sum of factor times measure less its value in the posture of the file, over the greatest factor.  A slide is measured at
 * the centre of its second body, which keeps the turn of this body out of the row. */
typedef struct lw_space_term {
    lw_space_joint joint;
    bool    turn;
    double  factor, start;       /* of a slide over `unit`                                            */
    int     index, side[2];      /* its joint; places of the two bodies in the row, -1: ground         */
} lw_space_term;

typedef struct lw_space_coupling {
    int  n, n_side, *body;       /* terms; bodies, at least two, -1 where there are fewer              */
    int  n_part, *part;          /* groups of three of the 6*n_side derivatives that are not 0         */
    lw_space_term *term;         /* (n)                                                                */
    double most;                             /* greatest factor, of a slide times `unit`               */
} lw_space_coupling;

/* A point of a body, in its axes; of the ground for body -1. */
typedef struct lw_space_point { int body; lw_vec3 arm; } lw_space_point;

/* Rows besides those of the joints: a measure, or the spin of a body about an axis (in its own axes), which is held. */
typedef struct lw_space_extra { bool spin; lw_spatial_measure measure; int body; lw_vec3 axis; } lw_space_extra;

typedef struct lw_space {
    const lw_spatial *model;
    int     n_body, n_q, n_v, n_joint, n_coupling;
    int     n_joint_row, n_row;  /* rows of joints; and couplings, one each                           */
    int     n_side, n_term;      /* most bodies of a row; most terms of a coupling, at least two      */
    double  unit;
    int    *body_of, *link_of;   /* (n_link) body of a link, -1: ground; (n_body)                     */
    lw_space_joint *joint;       /* (n_joint)                                                         */
    lw_space_coupling *coupling; /* (n_coupling)                                                      */
    lw_space_point *tracer;      /* (n_tracer)                                                        */
    lw_mat3 *from;               /* (n_tracer) turn of its body since which LW_OF_TURN_X .. of it count: that of the file, unless a user sets it */
    lw_quaternion *axes;         /* (n_body) principal axes in the posture of the file                */
    double  *mass;               /* (n_v) diagonal of the mass matrix [kg m^2]                        */
    double  *rotor;              /* (n_body) part of it without weight: of rotors at sliders, of superelements */
    double  *start;              /* (n_q) posture of the file                                         */
    void    *memory;
} lw_space;

/* The model must outlive s.  Elastic links are rigid bars of the same mass (mbs/elastic/expand_space.h).  LW_E_MEMORY;
 * LW_E_ARG: an elastic link without an axis. */
lw_status lw_space_make(const lw_spatial *m, lw_space *s, lw_error *e);
void      lw_space_free(lw_space *s);

/* Take joints that changed a little in the model, which has no couplings; the posture stays.  drawn (n_joint): before all changes, so that
 * rows depend on them smoothly. */
void lw_space_joints(lw_space *s, const lw_spatial_joint *drawn);

/* frames (n_body + 1) at q [m]. */
void lw_space_place(const lw_space *s, const double *q, lw_space_frame *frame);

/* The point of a link that is at `at` in the posture of the file. */
lw_space_point lw_space_point_of(const lw_space *s, int link, lw_vec3 at);
lw_vec3 lw_space_point_at(const lw_space_frame *frame, lw_space_point p);
lw_vec3 lw_space_point_velocity(const lw_space *s, const lw_space_frame *frame, lw_space_point p, const double *v);
lw_vec3 lw_space_omega(const lw_space_frame *frame, int body, const double *v);      /* in ground axes */

/* Bodies of an extra: two, -1 where there is none. */
void lw_space_bodies(const lw_space *s, const lw_space_extra *x, int body[2]);

/* Rows phi (n_joint_row) and jac (n_joint_row x 12) of the joints. */
void lw_space_rows(const lw_space *s, const lw_space_frame *frame, double *phi, double *jac);
/* The right-hand side of J a = out for the rows of joints and couplings, which velocities cause (n_row). */
void lw_space_bias(const lw_space *s, const lw_space_frame *frame, const double *v, double *out);
/* The same for one joint. */
void lw_space_joint_rows(const lw_space *s, int joint, const lw_space_frame *frame, double *phi, double *jac);
void lw_space_joint_bias(const lw_space *s, int joint, const lw_space_frame *frame, const double *v, double *out);

/* The row of a coupling and its derivatives (6*n_side), with turns (n_joint) near which angles count, but of its fastest term, which the sum tells. */
void lw_space_coupling_row(const lw_space *s, int coupling, const lw_space_frame *frame, const double *turn, double *phi, double *jac);
double lw_space_coupling_bias(const lw_space *s, int coupling, const lw_space_frame *frame, const double *v);

/* Count turns (n_joint) on to a posture that is less than half a turn of each joint away, but of the fastest one of each coupling. */
void lw_space_count_turns(const lw_space *s, const lw_space_frame *frame, double *turn);

/* A measure over its unit (lw_space_scale), its derivatives (12; may be NULL).  Angles are the ones nearest to
 * `near`. */
double lw_space_measure(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, double near, double *jac);
double lw_space_measure_bias(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, const double *v);
double lw_space_scale(const lw_space *s, lw_spatial_measure of);      /* 1 of turns, unit of lengths */

/* Its second derivatives over the unit, by the 12 coordinates of its bodies along their motions: derivative by b of entry a
 * of the first derivatives.  And those of row k of a joint, of which there are at most LW_SPACE_BENDS, and of a coupling, at most
 * that for each term, by velocity coordinates of the model; returns how many.  Not of LW_OF_TURN_X .., on which nothing acts. */
typedef struct lw_space_bend { int a, b; double h; } lw_space_bend;
#define LW_SPACE_BENDS 72
void lw_space_measure_bends(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, double h[12][12]);
int  lw_space_row_bends(const lw_space *s, const lw_space_frame *frame, int joint, int k, lw_space_bend *out);
int  lw_space_coupling_bends(const lw_space *s, const lw_space_frame *frame, int coupling, lw_space_bend *out);

/* The coordinate that a stop or a motor acts on: the turn of a joint, or its slide if it does not turn. */
lw_spatial_measure lw_space_stop_measure(const lw_space *s, int joint);

/* Its value and rate in SI units. */
void lw_space_measured(const lw_space *s, const lw_space_frame *frame, lw_spatial_measure of, double near,
                       const double *v,
                       double *value, double *rate);

/* Move q by a displacement (n_v), on the manifold; velocities while the displacement changes with these rates, which they
 * replace; q' = G v. */
void lw_space_move(const lw_space *s, double *q, const double *by);
void lw_space_along(const lw_space *s, const double *by, double *rate);
void lw_space_rates(const lw_space *s, const double *q, const double *v, double *dq);
/* Quaternions of length 1. */
void lw_space_normalise(const lw_space *s, double *q);

/* Does row k of a joint depend on the turns of its bodies alone? */
bool lw_space_row_turns(const lw_space *s, int joint, int k);

/* Name of a row: "x" "y" "z" of a point, "turn 1", "across 1", ...; "sum" of coupling *joint - n_joint. */
const char *lw_space_row_name(const lw_space *s, int row, int *joint);

#endif
