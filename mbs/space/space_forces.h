/* mbs/space/space_forces.h - masses and loads of a spatial model as generalised forces, with derivatives.
 *
 * Springs, dampers, motors and stops act along a measure l(q), a length between two points or the turn or slide of a joint,
 * as in the plane (mbs/equations/forces.h).  It has a gradient g and second derivatives H by the at most twelve velocity
 * coordinates of its two bodies, derivatives along motions of the bodies (lw_space_move), so H is not symmetric:
 *     force f along l:   Q = f g,   dQ_a/dq_b = g_a df/dq_b + f H_ab,   d(dl/dt)/dq_b = sum of v_a H_ab,   d(dl/dt)/dv = g. */
#ifndef LW_MBS_SPACE_SPACE_FORCES_H
#define LW_MBS_SPACE_SPACE_FORCES_H

#include "mbs/elastic/contact.h"
#include "mbs/elastic/superelement.h"
#include "mbs/space/space.h"

/* Pin and bush, or ball and socket, of an opened clearance. */
typedef struct lw_space_contact {
    int     joint;
    const lw_clearance *law;
    lw_friction friction;                /* where the surfaces touch; its speed is set                            */
    lw_space_point end[2];               /* centres of the bush and of the pin                                    */
    lw_contact_phase phase;
    double  struck;                      /* rate at which contact began [m/s]                                     */
    /* of a run, after each step (lw_space_watch_contacts) */
    bool    open;                        /* apart after the last step                                             */
    double  last, apart;                 /* time of the last step; apart for so long [s]                          */
    double  force_most, distance_most;   /* [N] [m]                                                               */
    long    losses;                      /* times at which contact was lost                                       */
} lw_space_contact;

/* At one moment: the distance of the centres and its rate, the force that presses pin and bush together [N]; friction on the pin
 * [N] and where it acts, from the pin's centre [m]. */
typedef struct lw_space_touch { double distance, rate, force; lw_vec3 drag, arm; } lw_space_touch;

typedef struct lw_space_forces {
    const lw_space *s;
    lw_space_point (*spring_end)[2];     /* (n_spring) */
    lw_space_point  *force_at;           /* (n_force) */
    lw_beam_space   *beam;               /* (n_beam) */
    double          *pull;               /* (n_beam) tension at which derivatives are taken [N]; NAN: that of the stretch */
    lw_space_contact *contact;           /* (n_contact) */
    int              n_super;
    lw_super        *super;              /* (n_super) */
    double          *super_work;         /* scratch of the largest: force, by_x, by_v, nodes */
    double          *turn;               /* (n_joint) turns accepted last, from which angles are counted */
    double          *weight;             /* (n_v) generalised force of gravity [J] */
    double          *z;                  /* (n_state) the states at which forces are wanted */
    const double    *held;               /* (6 n_link) the caller's loads: force at the centre of a link [N] and torque [N m], ground
                                            axes; NULL: none.  The caller's, who makes conservative false */
    lw_expression_sink_at *see;          /* is shown the expressions with their values as they are evaluated; NULL: not */
    void            *see_of;
    bool conservative;                   /* no dampers, motors, laws, forces */
    bool weights_alone;                  /* nothing else has a potential */
    void *memory;
} lw_space_forces;

/* Takes derivatives of force `row` by coordinate `column` of a displacement and of the velocities; they are sums.
 * add_state: those of the rates of states, rows from n_v on, and by states, columns from n_v on (by_q); NULL: not wanted. */
typedef struct lw_space_sink {
    void *context;
    void (*add)(void *context, int row, int column, double by_q, double by_v);
    void (*add_state)(void *context, int row, int column, double by_q, double by_v);
} lw_space_sink;

lw_status lw_space_forces_make(const lw_space *s, lw_space_forces *f, lw_error *e);
void      lw_space_forces_free(lw_space_forces *f);

/* Take the turns at a posture that is accepted. */
void lw_space_forces_accept(lw_space_forces *f, const lw_space_frame *frame);

/* Forces (n_v) [J] with gravity and what spinning bodies add; power of those without potential, unless NULL.  Derivatives go
 * to the sink, unless NULL. */
void lw_space_forces_apply(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v,
                           double *force, double *power, const lw_space_sink *sink);

/* Contact i of pin and bush; v NULL: at rest. */
lw_space_touch lw_space_touch_of(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i);

/* side (two for each compliant stop, in the order of the joints): > 0 where it is touched, and where it pushes. */
void lw_space_stop_sides(const lw_space_forces *f, const lw_space_frame *frame, const double *v, double *side);

/* Laws of contact have smooth pieces.  How far the posture is from the end of one, over its clearance, the least of all
 * contacts; < 0 beyond it, 1 without contacts.  Take the pieces that begin at this posture and these velocities; start: from
 * the posture alone. */
double lw_space_piece_left(const lw_space_forces *f, const lw_space_frame *frame);
void   lw_space_next_piece(lw_space_forces *f, const lw_space_frame *frame, const double *v, bool start);

/* Count what contacts do, after a step to time t; the first call of a run begins. */
void lw_space_watch_contacts(lw_space_forces *f, const lw_space_frame *frame, const double *v, double t, bool first);

/* Rates of the states f->z; values of all states at the start; signal i. */
void   lw_space_state_rates(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v, double *rate);
void   lw_space_state_start(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v, double *z);
double lw_space_signal(const lw_space_forces *f, int i, double t, const lw_space_frame *frame, const double *v);

/* Show the expressions of forces, laws and rates, one after the other, with the values of their variables; force (n_v) gets the forces. */
void lw_space_values(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v, double *force,
                     lw_expression_sink_at *see, void *of);

/* The same calls for every entry that can differ from 0, with any values, to learn the pattern. */
void lw_space_forces_pattern(const lw_space_forces *f, const lw_space_sink *sink);

/* Damper k of n: coefficient [SI] and the gradient (n_v, zeroed) of its measure. */
int    lw_space_dampers(const lw_space *s);
double lw_space_damper(const lw_space_forces *f, int k, const lw_space_frame *frame, double *g);

/* A load on nodes that are bodies (a beam, a superelement): force and moment about its centre on each of n bodies, in ground
 * axes [N] [N m], into force (n_v); with a sink, its derivatives by small displacements [m] and turns [rad] of the bodies in
 * ground axes, by_x (6n x 6n), and by their velocities, by_v.  The sink's derivatives contain the turns of the axes in which
 * moments are given.  Moving the nodes' velocities with the turns is the caller's part of by_x. */
void lw_space_add_element(const lw_space *s, const lw_space_frame *frame, int n, const int *body, const double *load,
                          const double *by_x, const double *by_v, double *force, const lw_space_sink *sink);

/* Of all beams and superelements (space_elements.c): make them, as a part of lw_space_forces_make; add their forces and their power, as
 * lw_space_forces_apply does; return `energy` and that of their strain. */
lw_status lw_space_elements_make(const lw_space *s, lw_space_forces *f, lw_error *e);
void      lw_space_push_elements(const lw_space_forces *f, const lw_space_frame *frame, const double *v, double *force, double *power,
                                 const lw_space_sink *sink);
double    lw_space_elements_energy(const lw_space_forces *f, const lw_space_frame *frame, double energy);

/* Derivatives are taken with the tensions that a small displacement `by` (n_v) changes linearly, until the next call; NULL: with those at
 * hand. */
void lw_space_foresee(const lw_space_forces *f, const lw_space_frame *frame, const double *by);

/* Beam element i at one moment. */
void lw_space_beam(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i, bool derivatives,
                   lw_beam_space_state *out);

/* Force i of the model: force and moment about the centre of its body, ground axes [N] [N m]. */
lw_vec3 lw_space_applied(const lw_space_forces *f, int i, double t, const lw_space_frame *frame, const double *v, lw_vec3 *moment);

/* Force and moment of superelement i on each of its nodes at one moment, with its weight (6n; scratch of f), ground axes [N] [N m]. */
const double *lw_space_super(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i);

/* Force and moment that each node of superelement i takes for its motion, a (n_v): accelerations (6n; scratch of f), ground axes. */
const double *lw_space_super_inertia(const lw_space_forces *f, const lw_space_frame *frame, const double *v, const double *a, int i);

/* Inertia of all superelements beyond that of the masses at their nodes, added to out (n_v): M a with what velocities alone cause; a
 * NULL: the derivatives of their kinetic energy by v, which is returned (0 with a).  out NULL: not wanted. */
double lw_space_more_inertia(const lw_space_forces *f, const lw_space_frame *frame, const double *v, const double *a, double *out);

/* Entries of the mass matrix besides its diagonal, of beam elements with consistent mass; true: there are any.  sink NULL:
 * only find out. */
bool lw_space_more_mass(const lw_space_forces *f, const lw_space_frame *frame, const lw_space_sink *sink);

/* Potential at the posture q (n_q); frame (n_body + 1): scratch, which is placed there unless weights alone have a potential. */
double lw_space_potential(const lw_space_forces *f, const double *q, lw_space_frame *frame);
double lw_space_strain(const lw_space_forces *f, const lw_space_frame *frame);      /* the part of elastic links, without their weight */
double lw_space_kinetic(const lw_space *s, const double *v);

/* What superelement i has beyond the masses at its nodes: first moment, linear momentum, angular momentum and inertia (as
 * lw_spatial_body's) about a place, ground axes. */
typedef struct lw_super_whole { lw_vec3 first, linear, angular; double inertia[6]; } lw_super_whole;
void lw_space_super_whole(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i, lw_vec3 about, lw_super_whole *out);

/* Linear momentum, and angular momentum about the origin (ground axes). */
void lw_space_momentum(const lw_space_forces *f, const lw_space_frame *frame, const double *v, lw_vec3 *linear, lw_vec3 *angular);

#endif
