/* catalogues/exchange/export_space.h - a spatial model as a file that another program runs.
 *
 * As catalogues/exchange/export.h: text in SI units, out is freed after a failure, LW_E_KIND names what the format
 * cannot express: laws and forces that are not constant, elastic links in MJCF, superelements, stops that rebound. */
#ifndef LW_CATALOGUES_EXCHANGE_EXPORT_SPACE_H
#define LW_CATALOGUES_EXCHANGE_EXPORT_SPACE_H

#include "base/bytes.h"
#include "grammar/model/spatial.h"

/* MuJoCo's MJCF. Bodies are the links, nested along a spanning tree of the joints, parallel to the world in the posture
 * of the file; equality constraints close the other joints. Drives (or the driven inputs) have actuators, whose
 * controls are the coordinates of their joints. Velocities at the start are in the keyframe. */
lw_status lw_export_space_mjcf(const lw_spatial *m, lw_bytes *out, lw_error *e);

/* A dataset of ADAMS/Solver, and the commands that run it. An elastic link is a part for each node (link i of the expanded model,
 * mbs/elastic/expand_space.h, is part i + 1) and a BEAM for each element. Motions of inputs are written in the words of ADAMS;
 * LW_E_KIND also: a motion has others (profile, table), a joint has a stop. */
lw_status lw_export_space_adams(const lw_spatial *m, lw_bytes *out, lw_error *e);
lw_status lw_export_space_adams_commands(const lw_spatial *m, lw_bytes *out, lw_error *e);

/* ---- for the writers ------------------------------------------------------------------------------- */

/* A spanning tree of the links from the ground. */
typedef struct lw_space_tree {
    bool    *in_tree;                  /* (n_joint)                                                          */
    int     *parent, *joint;           /* (n_link) the parent and the joint to it; -1: none (ground)         */
    int     *child, *next;             /* (n_link) the first child, the next child of the parent; -1: none   */
    lw_vec3 *origin;                   /* (n_link) of a body's frame: the joint to its parent; ground: 0 [m]  */
} lw_space_tree;

/* Joints that are no revolute or spherical ones first, then driven and loaded ones, spherical ones last. LW_E_KIND: a
 * free joint between two links that move; LW_E_MEMORY. Free it after a failure too. */
lw_status lw_space_tree_make(const lw_spatial *m, lw_space_tree *t, lw_error *e);
void      lw_space_tree_free(lw_space_tree *t);

/* Velocities at the start, of each link (n_link) of m with its elastic links expanded (m itself without those): of its point at
 * the origin [m/s] and of its turn [rad/s]. *out: to be
 * freed; NULL: all links start at rest. LW_E_KIND: some input has a motion and another a speed; failures of
 * lw_dynamics_make_spatial. */
typedef struct lw_space_twist { lw_vec3 velocity, omega; } lw_space_twist;
lw_status lw_export_space_start(const lw_spatial *m, const lw_spatial *expanded, lw_space_twist **out, lw_error *e);

/* LW_E_KIND, naming it: a law, a force that varies, an elastic link (beams: a superelement). */
lw_status lw_export_space_loads(const lw_spatial *m, const char *format, bool beams, lw_error *e);

bool lw_space_weighed(const lw_spatial *m);      /* Has a link a mass? */

/* A spring of MJCF between the sites "NAME start" and "NAME end": a tendon, drawn with this width [m]. */
void lw_mjcf_spring(lw_bytes *out, const char *name, double free, double stiffness, double damping, double width);

#define LW_MJCF_DEEPEST 40         /* greatest indentation: bodies of a chain stand inside each other */
#define LW_MJCF_STOP    10         /* damping of stops over the critical one: nothing rebounds */

/* Value of an expression without variables; 0 of NULL. */
double lw_export_constant(const lw_expression *x);

#endif
