/* mbs/equations/forces.h - masses and loads of a model in the coordinates of its system (mbs/constraints/system.h).
 *
 * Coordinates are scaled: places in multiples of system->unit, turns in rad.  So every generalised force is an energy
 * [J] and every entry of the mass matrix is in [kg m^2].  The reference point of a link is its centre of mass, hence
 * the mass matrix is diagonal and constant.
 *
 * Every load acts along a measure l(q): a length between two points, the turn or displacement of a joint, a coordinate
 * of a tracer, the turn of a link.  It has a gradient g and second derivatives H by the at most six coordinates of its
 * two links, which give forces and their derivatives for every kind of load:
 *     force f along l:   Q = f g,   dQ/dq = g (df/dq)^T + f H,   d(dl/dt)/dq = H v,   d(dl/dt)/dv = g. */
#ifndef LW_MBS_EQUATIONS_FORCES_H
#define LW_MBS_EQUATIONS_FORCES_H

#include "grammar/model/model.h"
#include "mbs/constraints/system.h"
#include "mbs/elastic/beam.h"
#include "mbs/equations/superelements.h"
#include "mbs/equations/equations.h"

typedef struct lw_forces {
    const lw_model  *model;                 /* the caller's; must outlive this */
    const lw_system *system;
    double  *mass;                          /* (n_q) diagonal [kg m^2] */
    double  *weight;                        /* (n_q) generalised force of gravity [J] */
    lw_vec2 (*spring_arm)[2];               /* ends of springs, points of forces, in the frames of their links */
    lw_vec2 *force_arm;
    int      n_stop, *stop_joint;           /* compliant stops */
    bool    conservative;                   /* gravity, springs without damping, compliant stops */
    bool    any_state;                      /* loads other than gravity */
    bool    coupled;                        /* first-order states, or laws of other quantities than their own measure */
    double *pull;                           /* (n_beam) tension at which derivatives of elements are taken [N]; NAN: that of the stretch */
    double *z;                              /* (model->n_state) the states at which forces are wanted */
    lw_expression_sink_at *see;             /* is shown the expressions with their values as they are evaluated; NULL: not */
    void    *see_of;
    lw_superelements superelements;              /* of elastic links */
    lw_caller_force caller;                 /* apply NULL: none */
    lw_link_motion *caller_link;            /* (n_link) scratch for the caller's forces, */
    lw_link_load   *caller_load;
    double         *caller_x;               /* (3 n_q) and for their derivatives: two threads need two lw_forces */
    double  *memory;                        /* of the arrays of numbers */
} lw_forces;

/* The system of a model with reference points in the centres of mass, as lw_forces needs it.  any_size false: LW_E_KIND
 * when the model has more parts than a linkage holds (grammar/linkage/linkage.h), or elastic links.  s needs lw_system_free. */
lw_status lw_forces_system(const lw_model *m, bool any_size, lw_system *s, lw_error *e);

/* caller: forces of the caller's own; NULL or apply NULL: none.  f needs lw_forces_free. */
lw_status lw_forces_make(const lw_model *m, const lw_system *s, const lw_caller_force *caller, lw_forces *f, lw_error *e);
void      lw_forces_free(lw_forces *f);

/* Generalised forces (n_q) of all loads but friction [J].  dq, dv (n_q x n_q, entry [i*n_q + j] is dforce_i/dq_j)
 * may be NULL.  *power: power of the forces without potential (dampers, motors, applied forces, laws, the caller's)
 * [W]; may be NULL. */
void lw_forces_apply(const lw_forces *f, double t, const double *q, const double *v, double *force, double *dq, double *dv, double *power);

/* The same for large models. */
void lw_forces_derivatives(const lw_forces *f, double t, const double *q, const double *v, double *force, const lw_force_sink *sink);

/* Are the derivatives of the caller's forces complete?  In large models only those of the force on a link by its own motion are known. */
bool lw_forces_caller_exact(const lw_forces *f);

/* Show the expressions of forces, laws and rates, one after the other, with the values of their variables; force (n_q) gets the forces
 * without the caller's. */
void lw_forces_values(const lw_forces *f, double t, const double *q, const double *v, double *force, lw_expression_sink_at *see, void *of);

/* The same calls for every entry that can differ from 0, with any values, to learn the pattern. */
void lw_forces_pattern(const lw_forces *f, const lw_force_sink *sink);

/* Rates of the states f->z; values of all states at the start and of signal i at (t, q, v, f->z). */
void   lw_forces_state_rates(const lw_forces *f, double t, const double *q, const double *v, double *rate);
void   lw_forces_state_start(const lw_forces *f, double t, const double *q, const double *v, double *z);
double lw_forces_signal(const lw_forces *f, int i, double t, const double *q, const double *v);

/* Motion prescribed for input i at t: what its joint measures from the posture, its rate and second rate, in rad or
 * scaled.  The model gives the input a motion.  LW_E_NUMERIC: a number that is not finite. */
lw_status lw_input_motion(const lw_model *m, const lw_system *s, int i, double t, double out[3]);

/* side (2 n_stop): > 0 where a compliant stop is touched, and where it pushes. */
void lw_forces_stop_sides(const lw_forces *f, const double *q, const double *v, double *side);

/* Derivatives are taken with the tensions that a small displacement `by` (n_q) from q changes linearly, until the next call; NULL: with
 * those at hand. */
void lw_forces_foresee(const lw_forces *f, const double *q, const double *by);

/* An element of the model at a moment (mbs/elastic/beam.h). */
void lw_forces_beam(const lw_forces *f, int beam, const double *q, const double *v, bool derivatives, lw_beam_state *out);

/* Force i of the model: force and moment about its body's centre [N] [N m]. */
lw_vec2 lw_forces_applied(const lw_forces *f, int i, double t, const double *q, const double *v, double *moment);

/* Strain energy of all elements [J]. */
double lw_forces_strain(const lw_forces *f, const double *q);

/* Potential of gravity (0 in the posture), linear springs, compliant stops and elements; kinetic energy [J]. */
double lw_forces_potential(const lw_forces *f, const double *q);
double lw_forces_kinetic(const lw_forces *f, const double *v);

/* A measure at one moment. */
typedef struct lw_measure {
    int    body[2];                         /* bodies of its links; -1: ground or none */
    double value, rate;                     /* [m] or [rad]; per second */
    double g[6], h[6][6];                   /* by coordinate i%3 of body[i/3] */
    bool   second;                          /* h is filled */
} lw_measure;

void lw_measure_joint(const lw_system *s, int joint, const double *q, const double *v, bool second, lw_measure *m);
void lw_measure_length(const lw_system *s, const int body[2], const lw_vec2 arm[2], const double *q,
                       const double *v, bool second, lw_measure *m);
/* axis 0: x, 1: y of a point; 2: the turn of its body. */
void lw_measure_point(const lw_system *s, int body, lw_vec2 arm, int axis, const double *q, const double *v, bool second, lw_measure *m);

#endif
