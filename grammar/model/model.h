/* grammar/model/model.h - a linkage with its drives and loads: motions of its inputs as functions of time, masses,
 * springs, dampers, forces, friction, stops, clearances, motors.
 *
 * A model is read from the same JSON file as the linkage (docs/notation.md, "Model"); a file with a linkage alone
 * is a model too.  All values are in SI units, positions are those in the drawn posture.  A model owns memory:
 * lw_model_free. */
#ifndef LW_GRAMMAR_MODEL_MODEL_H
#define LW_GRAMMAR_MODEL_MODEL_H

#include "base/key_table.h"
#include "grammar/functions/expression.h"
#include "grammar/functions/moves.h"
#include "grammar/linkage/assembly.h"
#include "grammar/model/section.h"

typedef struct lw_body {
    bool    given;                   /* the file gives a mass; otherwise all is 0                  */
    double  mass;                    /* >= 0 [kg]                                                   */
    lw_vec2 centre;                  /* of mass [m]                                                 */
    double  inertia;                 /* about the centre of mass, >= 0 [kg m^2]                     */
    bool    has_velocity;            /* at the start, of the centre of mass and of the rotation     */
    lw_vec2 velocity;                /* [m/s]                                                       */
    double  omega;                   /* [rad/s]                                                     */
} lw_body;

/* Between a point of one link and a point of another; in a planar model, z is 0.  The force f along the line of the points is positive when
 * it pulls them together:  f = stiffness (l - free) + damping dl/dt,  or `law`, a function of the variables
 * length and rate (and t). */
typedef struct lw_spring {
    char    name[LW_NAME_SIZE];
    int     link[2];
    lw_vec3 at[2];
    double  stiffness, damping, free;    /* [N/m] [N s/m] [m]                                      */
    double  extent[2];                   /* of a hydraulic cylinder: its length when it is pushed in and out [m]; else 0 */
    lw_expression *law;                  /* NULL: linear                                           */
} lw_spring;

/* At a joint, against the displacement q [rad] or [m] of link[1] relative to link[0] from the posture:
 * torque or force -(stiffness (q - free) + damping v), or `law` of displacement, rate, t. */
typedef struct lw_joint_spring {
    char   name[LW_NAME_SIZE];
    int    joint;
    double stiffness, damping, free;     /* [N m/rad] or [N/m], ...                                */
    lw_expression *law;
} lw_joint_spring;

/* A line load is stored as two forces, one after the other, at the ends of its line.  Together they act on a rigid body as the load does;
 * on elastic links they are spread over the line again (mbs/elastic/expand.h).  EVEN, VARYING: the first of them; SECOND: the other. */
typedef enum lw_line_load { LW_LINE_NONE, LW_LINE_EVEN, LW_LINE_VARYING, LW_LINE_SECOND } lw_line_load;

typedef struct lw_force {                /* on one link; the reaction goes to ground               */
    char    name[LW_NAME_SIZE];
    int     link;
    lw_vec3 at;                          /* z is 0 in a planar model                               */
    bool    follows;                     /* directions turn with the link                          */
    lw_expression *force[3], *torque[3]; /* [N] [N m], each may be NULL; a planar model has force[0], force[1], torque[2] */
    lw_line_load line;
    int     part;                        /* of an expanded model: 1 + the element whose load this is; 0: none */
} lw_force;

/* Where ideal friction is asked for and a formulation cannot do it, it is regularised by this speed [m/s]. */
#define LW_FRICTION_SPEED 0.001

typedef struct lw_friction {             /* Coulomb; of a joint                                    */
    double coefficient;                  /* 0: none                                                */
    double radius;                       /* of a pin [m]; torque mu radius |reaction|              */
    double speed;                        /* > 0: regularised, mu tanh(v/speed) [m/s]; 0: set-valued */
} lw_friction;

typedef struct lw_joint_stop {           /* of a joint's displacement from the posture             */
    bool   has_least, has_greatest;
    double least, greatest;              /* [rad] or [m]                                           */
    double restitution;                  /* 0 .. 1, used when stiffness is 0                        */
    double stiffness, damping;           /* > 0: a compliant stop                                  */
} lw_joint_stop;

typedef enum lw_clearance_model {
    LW_CLEARANCE_NONE,                   /* a plain joint                                          */
    LW_CLEARANCE_ZERO,                   /* no gap; Earles-Wu criterion of contact loss            */
    LW_CLEARANCE_LINK,                   /* a massless link as long as the gap                     */
    LW_CLEARANCE_MLSD,                   /* massless link with spring and damper                   */
    LW_CLEARANCE_IMPACT,                 /* two modes, cubic damping step (Makkonen, paper C)      */
    LW_CLEARANCE_HUNT_CROSSLEY, LW_CLEARANCE_LANKARANI
} lw_clearance_model;

typedef struct lw_clearance {            /* of a revolute joint                                    */
    lw_clearance_model model;
    double gap;                          /* radial clearance R [m]                                 */
    double stiffness, exponent;          /* K, e: F = K (r - R)^e                                  */
    double damping, depth;               /* c, d of the damping step [N s/m] [m]                   */
    double restitution;                  /* Hunt-Crossley, Lankarani-Nikravesh                     */
    double friction, friction_speed;     /* coefficient at the contact, regularisation [m/s]       */
} lw_clearance;

/* A variable of first order, dz/dt = rate: of the file's "states", of integral() and lag() in an expression, of a
 * controller, a motor's current, the pressures of a cylinder. */
typedef struct lw_state {
    char    name[2*LW_NAME_SIZE];        /* "M.current", "integral 1"                              */
    const char *unit;                    /* "A", "Pa", "J"; "1": the file does not say             */
    double  scale;                       /* absolute errors count relative to this                  */
    double  start;                       /* value at the start                                      */
    lw_expression *start_at;             /* NULL, or the value at the start as an expression        */
    lw_expression *rate;
} lw_state;

/* An expression that others name: output(NAME) of a controller, voltage of a motor, opening of a valve. */
typedef struct lw_signal {
    char    name[2*LW_NAME_SIZE];
    const char *unit;
    lw_expression *value;
} lw_signal;

typedef struct lw_rotor {                /* of a motor: inertia that moves with a link             */
    int    joint, link;                  /* the link has no other place to go than the joint's      */
    double inertia;                      /* seen at the joint [kg m^2], at a slider [kg]           */
    double ratio;                        /* while a file is read, of one that is a link of its own: its turns over the joint's, */
    char   name[LW_NAME_SIZE];           /* and its name; link is -1, inertia its own.  Otherwise 0 */
} lw_rotor;

/* The parts with first-order states, of planar and of spatial models. */
typedef struct lw_states {
    int        n_state, n_signal, n_rotor;
    lw_state  *state;
    lw_signal *signal;
    lw_rotor  *rotor;
    lw_key_table named[2];               /* while a file is read: states and signals by their names */
    int        n_made[2];                /* integrals and lags in expressions */
} lw_states;

/* The outline of a link, for contact.  Points are in the posture [m].
 *
 *     circle    at[0] its centre, radius
 *     segment   a bar from at[0] to at[1] with round ends, as thick as 2 radius; both sides can be touched
 *     polygon   n corners in counter-clockwise order, solid inside; it may have notches
 *     line      an infinite line through at[0] and at[1], solid on the right of that direction */
typedef enum lw_contour_kind { LW_CONTOUR_CIRCLE, LW_CONTOUR_SEGMENT, LW_CONTOUR_POLYGON, LW_CONTOUR_LINE } lw_contour_kind;

typedef struct lw_contour {
    lw_contour_kind kind;
    int      link, n;
    lw_vec2 *at;                         /* (n)                                                    */
    double   radius;                     /* of a circle; half the thickness of a segment [m]       */
} lw_contour;

/* How two things behave that touch: rigid with Poisson's restitution or, with a stiffness,
 * compliant: F = stiffness depth^exponent (1 + damping d(depth)/dt), never less than 0 (Hunt & Crossley 1975). */
typedef struct lw_surface {
    double friction;                     /* Coulomb's coefficient, 0: none                         */
    double friction_speed;               /* > 0: regularised, mu tanh(v/speed) [m/s]; 0: set-valued */
    double restitution;                  /* 0 .. 1                                                 */
    double stiffness, exponent, damping; /* > 0: compliant [N/m^exponent]; [1]; [s/m]              */
} lw_surface;

/* All shapes of one link touch all shapes of the other. */
typedef struct lw_contact {
    char       name[LW_NAME_SIZE];
    int        link[2];
    lw_surface surface;
} lw_contact;

/* Keeps a point of one link within `length` of a point of another. */
typedef struct lw_rope {
    char       name[LW_NAME_SIZE];
    int        link[2];
    lw_vec2    at[2];
    double     length;                   /* [m]                                                    */
    lw_surface surface;                  /* without friction                                       */
} lw_rope;

typedef struct lw_motor {                /* torque-speed line at a joint                           */
    char   name[LW_NAME_SIZE];
    int    joint;
    double stall, free_speed;            /* torque at rest [N m] or force [N], speed without load [rad/s] or [m/s] */
} lw_motor;

/* An element between two nodes, which are links; elastic links become these (mbs/elastic/expand.h). */
typedef struct lw_beam {
    int    link[2];
    double length, direction;            /* in the posture, from the first node to the second [m] [rad] */
    double stiffness[3];                 /* stretch [N/m], shear [N/m], bending [N m/rad]           */
    double damping;                      /* [s]                                                    */
    double mass, gyration;               /* [kg]; squared radius of gyration of the mass [m^2] */
    bool   consistent;                   /* modes use the mass of the shape functions                */
} lw_beam;

typedef struct lw_model {
    lw_assembly     linkage;
    lw_linkage     *small;               /* the same as read, for plans, drawings and exports; NULL: too large for one */
    lw_expression **motion;              /* value of input i [rad] or [m] as a function of t; NULL: none */
    bool           *has_speed;
    double         *speed;               /* at t = 0 [rad/s] or [m/s]; the input then runs freely  */
    lw_body        *body;                /* (n_link)                                               */
    lw_vec2         gravity;             /* [m/s^2]                                                */
    lw_elastic      *elastic;            /* (n_link)                                               */
    int              n_elastic;          /* links that are elastic                                 */
    int              n_beam;             /* a file has none                                        */
    lw_beam         *beam;
    int              n_super;            /* a file has none; as in space, with places and turns in the plane alone */
    lw_superelement *super;
    int              n_spring, n_joint_spring, n_force, n_motor, n_shape, n_contact, n_rope;
    lw_spring       *spring;
    lw_joint_spring *joint_spring;
    lw_force        *force;
    lw_motor        *motor;
    int              n_profile;
    lw_moves        *profile;            /* of profile(name) in expressions                        */
    lw_states        states;
    lw_contour        *shape;
    lw_contact      *contact;
    lw_rope         *rope;
    lw_friction     *friction;           /* (n_joint) of each joint                                */
    lw_joint_stop   *stop;
    lw_clearance    *clearance;
} lw_model;

/* The quantity of a variable in an expression: t; q, v: turn or displacement of a joint, and its rate; s, vs: slide of a
 * spatial joint; x, y, z, vx, vy, vz: place and velocity of a tracer; angle, omega: rotation of a link of a planar model since
 * the posture, and its rate; length, rate: of the spring whose law it is, or its joint's displacement; state: its value; spring
 * length, rate: of a spring or cylinder. */
typedef enum lw_quantity {
    LW_QUANTITY_T, LW_QUANTITY_Q, LW_QUANTITY_V, LW_QUANTITY_S, LW_QUANTITY_VS, LW_QUANTITY_X, LW_QUANTITY_Y, LW_QUANTITY_Z,
    LW_QUANTITY_VX, LW_QUANTITY_VY, LW_QUANTITY_VZ, LW_QUANTITY_ANGLE, LW_QUANTITY_OMEGA, LW_QUANTITY_LENGTH, LW_QUANTITY_RATE,
    LW_QUANTITY_STATE, LW_QUANTITY_SPRING_LENGTH, LW_QUANTITY_SPRING_RATE
} lw_quantity;

/* A variable's number: quantity and the index of the joint, tracer or link it belongs to. */
static inline int lw_variable(lw_quantity q, int index) { return 32*index + (int)q; }
static inline lw_quantity lw_variable_quantity(int variable) { return (lw_quantity)(variable%32); }
static inline int lw_variable_index(int variable) { return variable/32; }

/* weight[0] of[0] + weight[1] of[1], of which either may be NULL; both: *out is unchanged.  LW_E_NOTATION: too long together. */
lw_status lw_expression_mix(const double weight[2], lw_expression *const of[2], lw_expression **out, lw_error *e);

/* Read a model.  LW_E_NOTATION with line and column, for expressions too; m needs no _free after a failure. */
lw_status lw_model_read(const char *text, size_t size, const char *file, lw_model *m, lw_error *e);

/* The same for result number `which` of a text with results, as lw_linkage_read_result. */
lw_status lw_model_read_result(const char *text, size_t size, const char *file, int which, lw_model *m, lw_error *e);
void      lw_model_free(lw_model *m);
void      lw_states_free(lw_states *s);
void      lw_springs_and_forces_free(int n_spring, lw_spring *spring, int n_force, lw_force *force);

/* m->small.  LW_E_KIND when it is NULL; the text says how large the model is. */
lw_status lw_model_small(const lw_model *m, const lw_linkage **linkage, lw_error *e);

/* Give an input a motion, replacing the one it has.  LW_E_NOTATION with the column in e. */
lw_status lw_model_drive(lw_model *m, int input, const char *motion, lw_error *e);

/* Can the motion of an input be followed from `from` to `to` (NULL: there is none)?  LW_E_ARG: it has a pole or jumps there; the text names
 * the input and the time. */
lw_status lw_motion_check(const lw_expression *motion, const char *input, double from, double to, lw_error *e);

/* The angular frequency with which an input excites vibrations between these times [rad/s]: its greatest speed, if it turns, or the ratio of its
 * greatest acceleration to its greatest speed where it moves to and fro, whichever is greater.  speed: of an input without a motion (NULL). */
double lw_motion_frequency(const lw_expression *motion, bool turns, double speed, double from, double to);

/* Show the rates of states; motions, forces, laws and rates: NULL where one is missing. */
void lw_states_expressions(const lw_states *s, lw_expression_sink *see, void *context);
void lw_model_expressions(const lw_model *m, lw_expression_sink *see, void *context);

/* A model of a linkage alone: no masses, no loads.  LW_E_MEMORY: m is empty. */
lw_status lw_model_from_assembly(const lw_assembly *linkage, lw_model *m);
lw_status lw_model_from_linkage(const lw_linkage *linkage, lw_model *m);

#endif
