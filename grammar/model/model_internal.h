/* grammar/model/model_internal.h - for the readers of models; internal to grammar/. */
#ifndef LW_GRAMMAR_MODEL_MODEL_INTERNAL_H
#define LW_GRAMMAR_MODEL_MODEL_INTERNAL_H

#include <stddef.h>
#include "grammar/linkage/read_internal.h"
#include "grammar/model/model.h"
#include "grammar/model/spatial.h"

/* Zeroed arrays for the links, joints and inputs of m->linkage.  After LW_E_MEMORY too, m needs lw_model_free. */
lw_status lw_model_reserve(lw_model *m);

/* ---- shared by the readers of planar and of spatial models ------------------------------------------------ */

/* The variables that an expression may use: t; those of the whole model; of a spring's or a joint's law. */
typedef enum { LW_OF_TIME, LW_OF_STATE, LW_OF_LENGTH, LW_OF_DISPLACEMENT } lw_expression_scope;

/* The joint of a motor, and what its push needs to know of it; law: of a spring there. */
typedef struct lw_motor_joint {
    int joint, link[2], ground, rate;    /* rate: the variable of its speed */
    bool turns;
    const char *name;
    lw_expression **law;
} lw_motor_joint;

/* A model that is being read, as far as expressions and states ask. */
typedef struct lw_reading {
    void      *model;
    lw_states *states;
    const lw_units *units;
    const int *n_profile;
    lw_moves *const *profile;
    /* Lists with room for all that the file has, and how many have been read. */
    lw_spring *const *spring;
    lw_force  *const *force;
    lw_motor  *const *motor;
    int       *n_spring, *n_force, *n_motor;
    /* The variable word(name) of a joint, tracer or link.  -1: there is none, with why. */
    int       (*variable)(const void *model, lw_json *json, const char *word, const char *name, char *why);
    /* The link that a node names; the joint of a motor, and the spring there for its push. */
    lw_status (*link)(const lw_json_node *n, const void *model, int *out, lw_error *e);
    lw_status (*motor_place)(const lw_json_node *object, const void *model, int *joint, lw_error *e);
    void      (*motor_spring)(int joint, const char *name, void *model, lw_motor_joint *out);
    /* A spring or damper at a joint, whose keys are checked. */
    lw_status (*joint_spring)(const lw_json_node *object, const char *what, size_t index, const struct lw_reading *r, lw_error *e);
    bool       spatial;                  /* places have three numbers; a joint may have several coordinates */
} lw_reading;

/* Reads one element of a list of loads. */
typedef lw_status lw_read_one(const lw_json_node *object, size_t index, const lw_reading *r, lw_error *e);

/* A list of the root, which may be left out: the number of its elements; read each. */
size_t lw_read_count(const lw_json_node *root, const char *key);
lw_status lw_read_each(const lw_json_node *root, const char *key, lw_read_one *read, const lw_reading *r, lw_error *e);

/* An optional expression or number; *out keeps NULL if it is left out. */
lw_status lw_read_expression(const lw_json_node *object, const char *key, const lw_reading *r, lw_expression_scope scope,
                             lw_expression **out, lw_error *e);

/* An optional density of a line load, in the direction `key`: one expression, or [at its start, at its end], linear in between (*varies
 * becomes true).  first, second: the forces at its ends that push a rigid body alike. */
lw_status lw_read_line_load(const lw_json_node *object, const char *key, const lw_reading *r, double length, lw_expression **first,
                            lw_expression **second, bool *varies, lw_error *e);

/* Put the expression in the text, of t and of profiles, in the place of an input's motion. */
lw_status lw_motion_replace(const char *text, const int *n_profile, lw_moves *const *profile, lw_expression **motion, bool *has_speed,
                            lw_error *e);

/* ---- model_ends.c ------------------------------------------------------------------------------------------ */

/* A place: three numbers, in the plane two, in units of `metre`. */
lw_status lw_read_place(const lw_json_node *n, double metre, bool spatial, lw_vec3 *out, lw_error *e);

/* "links" and "at" of the next spring, whose free length becomes the distance of its ends. */
lw_status lw_read_ends(const lw_json_node *object, const lw_reading *r, lw_error *e);

/* Distance of the ends of a spring in the posture [m]. */
double lw_read_drawn_length(const lw_reading *r, const lw_spring *p);

/* The spring or cylinder of a name, or -1 and why. */
int lw_read_find_spring(const lw_reading *r, lw_json *json, const char *name, char *why);

/* ---- model_loads.c ----------------------------------------------------------------------------------------- */

/* Numbers of a spring or damper, or the "law" that stands in their place, of a length or of a joint's displacement in this unit.  *free: that of the
 * posture on entry. */
lw_status lw_read_spring_numbers(const lw_json_node *object, const lw_reading *r, lw_expression_scope scope, double unit, double *stiffness,
                                 double *damping, double *free, lw_expression **law, lw_error *e);

/* One of "springs", of "dampers", of "forces", of "motors". */
lw_read_one lw_read_spring, lw_read_damper, lw_read_force, lw_read_motor;

/* ---- model_joint.c: what a joint has besides its freedoms ------------------------------------------------ */

/* Numbers of a stop, about the posture of the file at displacement 0: least, greatest [unit], restitution, stiffness,
 * damping. */
lw_status lw_read_stop(const lw_json_node *stop, double unit, lw_joint_stop *p, lw_error *e);

/* Friction of a joint; radius: does it turn, so that a "radius" is needed?  Its lengths are in units of `metre`. */
lw_status lw_read_friction(const lw_json_node *n, double metre, bool radius, lw_friction *f, lw_error *e);

/* The clearance of a joint; its lengths are in units of `metre`. */
lw_status lw_read_clearance(const lw_json_node *n, double metre, lw_clearance *c, lw_error *e);

/* Refuse a centre of mass that lies `away` from a joint of its link, where all joints and tracers are within `extent` of the first joint: the
 * equations keep the digits of the greatest distance. */
lw_status lw_read_check_centre(const lw_json_node *root, int link, const char *name, double away, double extent, lw_error *e);

/* ---- model_states.c: what has first-order states --------------------------------------------------------- */

/* Names of the states of the lists "states", "motors", "cylinders", which expressions may use.  Names of all loads differ in their
 * lists. */
lw_status lw_states_name(const lw_json_node *root, lw_states *z, lw_error *e);

/* One of "controllers", and the ends of one of "cylinders", which other expressions name; later, the equations of states. */
lw_read_one lw_states_read_controller, lw_states_read_cylinder_ends;
lw_status lw_states_read(const lw_json_node *root, const lw_reading *r, lw_error *e);

/* One of "motors" with a "resistance", or with a "torque"; or false: it has neither. */
bool lw_is_driven_motor(const lw_json_node *object);
lw_read_one lw_states_read_motor;

/* ---- spatial_loads.c: loads of models in space, and what they name ------------------------------------------------- */

/* Arguments of lw_read_name_of and lw_read_find for a list of n parts with names. */
#define LW_NAMES(list, n, type) (const char *)(list) + offsetof(type, name), sizeof(type), n

/* The link of a spatial model that a node names. */
lw_status lw_spatial_read_link(const lw_json_node *n, const void *model, int *out, lw_error *e);

/* The measure that an object names: "joint", "coordinate" turn or slide; or "tracer", "coordinate" x, y, z. */
lw_status lw_spatial_read_measure(const lw_json_node *object, const lw_spatial *m, bool tracers, const char *what,
                                  lw_spatial_measure *out, lw_error *e);

/* The unit of a measure in the file. */
double lw_spatial_measure_unit(const lw_spatial *m, lw_spatial_measure of);

/* What expressions and states ask of the model. */
lw_reading lw_spatial_reading(lw_spatial *m);

/* ---- model_rotor.c: rotors that turn between moving links ------------------------------------------------------ */

/* Names of the link and its joint on the carrier, of its gear or coupling: that of the motor with these behind it. */
#define LW_ROTOR_LINK ".rotor"
#define LW_ROTOR_GEAR ".gear"

/* At the end of reading: add the links of these rotors, and take them from the list of states.  LW_E_NOTATION: a name is taken; the link that is
 * driven is elastic. */
lw_status lw_model_add_rotors(const lw_json_node *root, lw_model *m, lw_error *e);
lw_status lw_spatial_add_rotors(const lw_json_node *root, lw_spatial *m, lw_error *e);

/* ---- model_elastic.c ------------------------------------------------------------------------------------- */

/* Joints need a place on an elastic link; guides and gears need a rigid one. */
lw_status lw_model_check_elastic(const lw_json_node *root, const lw_model *m, lw_error *e);

/* ---- model_contact.c: what can touch ---------------------------------------------------------------------- */

/* The "shapes" of all links; then one of "contacts", which needs them, and one of "ropes". */
lw_status lw_model_read_shapes(const lw_json_node *root, lw_model *m, lw_error *e);
lw_read_one lw_model_read_contact, lw_model_read_rope;

#endif
