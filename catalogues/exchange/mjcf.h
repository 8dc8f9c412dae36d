/* catalogues/exchange/mjcf.h - elements of MJCF, the XML of MuJoCo 2.2, for the writers of planar and of spatial models.
 *
 * Lengths [m], angles [rad], all other values in SI units. */
#ifndef LW_CATALOGUES_EXCHANGE_MJCF_H
#define LW_CATALOGUES_EXCHANGE_MJCF_H

#include "base/bytes.h"
#include "catalogues/exchange/tree.h"

#define LW_MJCF_DIGITS 15

/* Begin a tag on a new line. */
void lw_mjcf_tag(lw_bytes *out, int depth, const char *text);

/* Attributes: numbers; a vector; a name, followed by `more`; the name of a link, which is not "world". */
void lw_mjcf_numbers(lw_bytes *out, const char *attribute, const double *v, int n);
void lw_mjcf_number(lw_bytes *out, const char *attribute, double v);
void lw_mjcf_vec(lw_bytes *out, const char *attribute, lw_vec3 v);
void lw_mjcf_name(lw_bytes *out, const char *attribute, const char *name, const char *more);
void lw_mjcf_link(lw_bytes *out, const char *attribute, const char *name);

/* What acts on the coordinate of a joint: its value in the posture; sums over its springs and dampers, pull: of stiffness times
 * free turn or length.  stop: NULL: none.  armature: inertia of its drive, 0: none. */
typedef struct lw_mjcf_coordinate {
    double at, stiffness, damping, pull, armature;
    bool   has_at;
    const lw_joint_stop *stop;
} lw_mjcf_coordinate;
void lw_mjcf_coordinate_add(lw_mjcf_coordinate *c, double stiffness, double damping, double free);
void lw_mjcf_coordinate_put(lw_bytes *out, const lw_mjcf_coordinate *c);

/* A site of this size; its turn: an attribute of n numbers, NULL: none. */
void lw_mjcf_site(lw_bytes *out, int depth, const char *name, const char *more, lw_vec3 at, const char *attribute, const double *turn,
                  int n, double size);

/* The bodies of all links, each inside its parent; those on the ground are indented by `first`.  begin writes all of a body but
 * those inside it. */
typedef void lw_mjcf_begin(void *context, int depth, int link);
void lw_mjcf_bodies(lw_bytes *out, const lw_export_tree *t, int ground, int first, lw_mjcf_begin *begin, void *context);

/* A spring between the sites "NAME start" and "NAME end": a tendon. */
void lw_mjcf_spring(lw_bytes *out, const char *name, double free, double stiffness, double damping, double width);

/* A rope between the sites "NAME rope start" and "NAME rope end": a tendon with a greatest length, where nothing rebounds. */
void lw_mjcf_rope(lw_bytes *out, const char *name, double length, double step, double width);

/* The keyframe "posture": controls of the drives, velocities of all coordinates in the order of the file.  { 0 } is empty. */
typedef struct lw_mjcf_key { lw_bytes controls, speeds; } lw_mjcf_key;
void lw_mjcf_speeds(lw_mjcf_key *key, const double *v, int n);
void lw_mjcf_key_free(lw_mjcf_key *key);

/* Write it where it says something.  loads: actuators after the drives, which need no control; moves: not all velocities are 0. */
void lw_mjcf_keyframe(lw_bytes *out, const lw_mjcf_key *key, int loads, bool moves);

/* Actuators.  A drive of a joint's coordinate is a spring of a frequency that suits the step of time, on the inertia of the drive,
 * with damping; its control is the coordinate.  Motors and constant forces need no control.  A force at the site "NAME force"
 * has three components and three moments, along axes of the site if it follows it, else of the world. */
void lw_mjcf_drive(lw_bytes *out, lw_mjcf_key *key, double control, double inertia, double step);     /* attributes gainprm and biasprm */
void lw_mjcf_motor(lw_bytes *out, const char *name, const char *joint, double stall, double free_speed);
void lw_mjcf_force(lw_bytes *out, const char *name, bool follows, const double value[6]);

/* A sensor of the place of a tracer. */
void lw_mjcf_sensor(lw_bytes *out, const char *tracer);

/* From the start of the file to that of the world's body.  rows: not fewer than equalities and limits have, for
 * which MuJoCo 2 asks for room where they are more than 500. */
void lw_mjcf_head(lw_bytes *out, const char *name, lw_vec3 gravity, double step, double size, int rows, bool has_forces);

#endif
