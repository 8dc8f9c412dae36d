/* grammar/model/spatial.h - a spatial model: bodies, joints, drives and loads in space, as many as memory holds.
 *
 * It is read from the same JSON vocabulary as a planar model (docs/notation.md, "Spatial model"); places have three
 * numbers.  All values are in SI units and in ground axes of the posture of the file.  A model owns memory:
 * lw_spatial_free. */
#ifndef LW_GRAMMAR_MODEL_SPATIAL_H
#define LW_GRAMMAR_MODEL_SPATIAL_H

#include "base/vec3.h"
#include "grammar/functions/expression.h"
#include "grammar/model/model.h"          /* lw_joint_stop, LW_NAME_SIZE */

/* Kinds of joints: X(constant, letter, word, constraint rows, turns about its axis, slides along its axis). */
#define LW_SPATIAL_KIND_LIST(X) \
    X(REVOLUTE,    'r', "revolute",    5, true,  false) \
    X(PRISMATIC,   't', "prismatic",   5, false, true)  \
    X(CYLINDRICAL, 'c', "cylindrical", 4, true,  true)  \
    X(SPHERICAL,   'b', "spherical",   3, false, false) \
    X(UNIVERSAL,   'u', "universal",   4, false, false) \
    X(SCREW,       'h', "screw",       5, true,  true)  \
    X(PLANAR,      'e', "planar",      3, true,  false) \
    X(FIXED,       'f', "fixed",       6, false, false) \
    X(FREE,        'o', "free",        0, false, false)

typedef enum lw_spatial_kind {
#define X(id, letter, word, rows, turns, slides) LW_SPATIAL_##id,
    LW_SPATIAL_KIND_LIST(X)
#undef X
} lw_spatial_kind;

/* word, letter, number of rows; does a turn about the axis, a slide along it count? */
typedef struct lw_spatial_kind_row { char letter; const char *word; int rows; bool turns, slides; } lw_spatial_kind_row;
const lw_spatial_kind_row *lw_spatial_kind_of(lw_spatial_kind kind);

typedef struct lw_spatial_body {
    char    name[LW_NAME_SIZE];
    bool    given;               /* the file gives a mass; otherwise mass and inertia are 0            */
    double  mass;                /* [kg]                                                               */
    lw_vec3 centre;              /* of mass [m]                                                        */
    double  inertia[6];          /* about the centre, ground axes: xx yy zz xy xz yz of the matrix [kg m^2] */
    bool    has_velocity, has_omega;
    lw_vec3 velocity, omega;     /* at t = 0: of the centre [m/s], of the body [rad/s]                 */
} lw_spatial_body;

typedef struct lw_spatial_joint {
    char    name[LW_NAME_SIZE];
    lw_spatial_kind kind;
    int     link[2];
    lw_vec3 at;                  /* a point of the axis, the centre, a point of the plane [m]          */
    lw_vec3 axis;                /* unit; universal: of link[0]; planar: the normal; 0 where there is none */
    lw_vec3 second;              /* universal: unit axis of link[1]; planar: only direction of the slide, in files for other programs, else 0 */
    double  lead;                /* screw: slide of link[1] per turn [m]                               */
    bool    has_cone;
    double  cone;                /* spherical, universal: greatest angle of tilt from the posture [rad]; not enforced */
    lw_vec3 cone_axis;           /* unit, the axis of link[1] whose tilt counts                        */
    lw_joint_stop stop;          /* of the turn, or the slide of a prismatic joint, from the posture   */
    lw_friction friction;        /* coefficient 0: none                                                */
    lw_clearance clearance;      /* spherical, revolute: between the centres; link[1] has the pin or the ball */
    bool    opened;              /* its kind is what the clearance leaves of it (lw_spatial_open)       */
} lw_spatial_joint;

typedef struct lw_spatial_tracer {
    char    name[LW_NAME_SIZE];
    int     link;
    lw_vec3 at;                  /* [m]                                                                */
    lw_quaternion frame;         /* orientation of its axes (a tool)                                   */
} lw_spatial_tracer;

/* A number that a posture has: turn [rad] or slide [m] of link[1] relative to link[0] along the axis of a joint, 0 in
 * the posture of the file; or a coordinate [m] of a tracer; or 2 sin(a/2) times a coordinate of the axis, where a is the angle by which its
 * link has turned since a posture that the user of the measure gives (mbs/space/space.h: `from`; no file has it). */
typedef enum lw_spatial_of { LW_OF_TURN, LW_OF_SLIDE, LW_OF_X, LW_OF_Y, LW_OF_Z, LW_OF_TURN_X, LW_OF_TURN_Y, LW_OF_TURN_Z } lw_spatial_of;
typedef struct lw_spatial_measure { lw_spatial_of of; int index; } lw_spatial_measure;     /* of a joint or a tracer */

typedef struct lw_spatial_input {
    lw_spatial_measure measure;
    double value;                /* in the posture: that of the file [rad] or [m]                      */
    bool   has_range;
    double first, last;          /* range of motion                                                    */
    lw_expression *motion;       /* value as a function of t; NULL: none                               */
    bool   has_speed;
    double speed;                /* at t = 0; afterwards the input runs freely                         */
} lw_spatial_input;

/* A gear pair, belt or rope: the sum of factor times measure [rad] [m] keeps its value of the posture of the file. */
typedef struct lw_spatial_coupling {
    char   name[LW_NAME_SIZE];
    int    n;                            /* terms, 2 or more                                           */
    lw_spatial_measure *of;              /* (n) of joints, each once                                   */
    double *factor;                      /* (n) not 0; of turns [m/rad] where the sum is a length      */
} lw_spatial_coupling;

/* The value of an input less its measure: joints measure 0 in the posture of the file, whatever value that has. */
static inline double lw_spatial_offset(const lw_spatial_input *in) { return in->measure.of >= LW_OF_X ? 0 : in->value; }

typedef struct lw_spatial_joint_spring { /* against a measure, as lw_joint_spring                      */
    char    name[LW_NAME_SIZE];
    lw_spatial_measure measure;
    double  stiffness, damping, free;
    lw_expression *law;
} lw_spatial_joint_spring;

/* An element between two nodes, which are links; elastic links become these (mbs/elastic/expand_space.h). */
typedef struct lw_spatial_beam {
    int     link[2];
    double  length;                      /* in the posture [m]                                         */
    double  stiffness[6];                /* stretch, shear along y and z [N/m]; torsion, bending about y and z [N m/rad] */
    double  damping;                     /* [s]                                                        */
    lw_mat3 axes;                        /* in the posture: x along the element, y and z of its section */
    double  mass, gyration[2];           /* [kg]; squared radii of gyration of the mass [m^2] */
    bool    consistent;                  /* modes use the mass of the shape functions                  */
} lw_spatial_beam;

typedef struct lw_spatial {
    char    name[64];
    int     n_link, n_joint, n_coupling, n_input, n_drive, n_tracer, n_spring, n_joint_spring, n_force, n_motor;
    int     ground;
    lw_spatial_body         *body;       /* (n_link)                                                   */
    lw_spatial_joint        *joint;
    lw_spatial_coupling     *coupling;
    lw_spatial_input        *input;
    lw_spatial_measure      *drive;      /* what motors move when the inputs are elsewhere (a tool); else none */
    lw_spatial_tracer       *tracer;
    lw_spring               *spring;
    lw_spatial_joint_spring *joint_spring;
    lw_force                *force;
    lw_motor                *motor;
    int                      n_profile;
    lw_moves                *profile;    /* of profile(name) in expressions                            */
    lw_states                states;
    lw_elastic              *elastic;    /* (n_link)                                                   */
    int      n_elastic;                  /* links that are elastic                                     */
    int      n_beam;                     /* a file has none                                            */
    lw_spatial_beam         *beam;
    int      n_super;                    /* a file has none                                            */
    lw_superelement         *super;
    int      n_contact, *contact;        /* joints whose clearance is opened; a file has none          */
    char    *files;                      /* paths of the meshes and matrices it was read from, one after the other, each with its NUL, and an
                                            empty one; NULL: none */
    lw_vec3  gravity;                    /* [m/s^2]                                                    */
    lw_units units;
} lw_spatial;

/* Is this the text of a spatial model: has a place three numbers, or, where none has two, a joint a kind that only space has? */
bool lw_spatial_text(const char *text, size_t size);
/* The same; LW_E_MEMORY, for which lw_spatial_text says no. */
lw_status lw_spatial_recognise(const char *text, size_t size, bool *spatial);

/* Read a model.  LW_E_NOTATION with line and column, also for errors of meaning; m is then empty. */
lw_status lw_spatial_read(const char *text, size_t size, const char *file, lw_spatial *m, lw_error *e);
void      lw_spatial_free(lw_spatial *m);

/* The kind that the file gives a joint, opened or not. */
static inline lw_spatial_kind lw_spatial_kind_given(const lw_spatial_joint *j)
{
    return !j->opened ? j->kind : j->kind == LW_SPATIAL_FREE ? LW_SPATIAL_SPHERICAL : LW_SPATIAL_REVOLUTE;
}

/* Does a joint have a clearance that lw_spatial_open opens? */
bool lw_spatial_has_clearance(const lw_spatial_joint *j);

/* The same model with its clearances opened: a spherical joint becomes a free one, a revolute joint a planar one, which keeps
 * tilt and axial place.  It shares what it does not change with m, which must outlive it.  LW_E_MEMORY.  *open needs
 * lw_spatial_open_free, after a failure too. */
lw_status lw_spatial_open(const lw_spatial *m, lw_spatial *open, lw_error *e);
void      lw_spatial_open_free(lw_spatial *open);

/* Move input i by an expression of t, "0.5 + 10*t" [rad] or [m]. */
lw_status lw_spatial_set_motion(lw_spatial *m, int i, const char *motion, lw_error *e);

/* The greatest distance of a joint, tracer or centre of mass from the middle of them, at least 1e-9 m: the size that
 * tolerances refer to. */
double lw_spatial_size(const lw_spatial *m);

/* Has it a slide, so that its sum is a length? */
bool lw_spatial_coupling_slides(const lw_spatial_coupling *c);

/* A name for messages: "A", or "x of P" of a tracer. */
void lw_spatial_measure_name(const lw_spatial *m, lw_spatial_measure of, char *text, size_t size);

/* Are all axes parallel, and every load across them, so that the motion is planar?  *normal: the axis. */
bool lw_spatial_is_planar(const lw_spatial *m, lw_vec3 *normal);

/* A planar model as one in space, in the plane z = 0, for what knows only space: links, joints, inputs without their motions,
 * tracers, masses, springs and stops; no other loads.  A pin in a slot becomes a slide and a pin.  m needs lw_spatial_free.
 * LW_E_KIND: gears, tied inputs, elastic links, springs with a law; m is then empty. */
lw_status lw_spatial_of_planar(const lw_model *p, lw_spatial *m, lw_error *e);

/* The same with the joints, links and free inputs of p by the same numbers, for writers of files: a pin in a slot is a planar joint that slides
 * along `second` alone, a gear a free joint without links (-1).  Springs are without their laws.  LW_E_MEMORY: m is empty. */
lw_status lw_spatial_joint_by_joint(const lw_model *p, lw_spatial *m, lw_error *e);

/* The planar model that moves as m, whose motion is planar: axes of the plane are x, y across the normal z (y, z across x; z, x
 * across y), in metres and radians.  p needs lw_model_free.  LW_E_KIND: it is not planar, or has loads that are not taken over. */
lw_status lw_spatial_in_plane(const lw_spatial *m, lw_model *p, lw_error *e);

#endif
