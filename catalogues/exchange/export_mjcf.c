/* catalogues/exchange/export_mjcf.c - write a spatial model, or a planar one in the plane z = 0, for MuJoCo 2.2 (its XML reference). */
#include <stdlib.h>
#include <string.h>

#include "base/owners.h"
#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"
#include "catalogues/exchange/plane.h"
#include "catalogues/exchange/start.h"

#define DIGITS     15
#define DEEPEST    40                          /* greatest indentation: bodies of a chain stand inside each other */
#define STEEL      7850.0                      /* density of the rods [kg/m^3]                            */
#define STEP       2e-4                        /* of time, unless loads need a smaller one [s]            */
#define PLANE_STEP 5e-4                        /* the same of a planar model                              */
#define STOP_STEP  1e-4                        /* of a planar one with stops, which give way for some steps */
#define ROPE_STEP  5e-5                        /* and with ropes                                          */
#define LITTLE     1e-5                        /* mass of a body without mass, over that of all bodies    */
#define FLAT       1e-6                        /* planar: least inertia of a body, over its mass times the square of the size */
#define SLIM       1e-4                        /* least principal moment of a body over its greatest one  */
#define HINGE      0.3                         /* half the distance of the points that close a hinge, over the size */
#define DAMPING    10                          /* of stops over the critical one: nothing rebounds        */
#define DRIVE      0.3                         /* angular frequency of a drive, times the step            */
#define RATIO      0.3                         /* of its damping to the critical one                      */

typedef struct writer {
    const lw_spatial *m;
    const lw_export_plane *plane;              /* NULL: a model in space                                  */
    lw_bytes         *out;
    lw_bytes          controls, speeds;        /* in the posture: of the drives; of all coordinates in the order of the file */
    double            size, mass, step;        /* mass: of all bodies                                     */
    bool              weighed;                 /* the model has masses                                    */
    lw_export_twist  *twist;                   /* (n_link) velocities at the start; NULL: all are 0       */
    lw_export_tree    tree;
    lw_owners         joints, tracers, springs, ropes, forces;   /* by links                              */
    lw_owners         inputs, joint_springs;                     /* by the joints, or tracers, of their measures */
} writer;

/* ---- text ---------------------------------------------------------------------------------------- */

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }

/* Begin a tag on a new line. */
static void put_tag(writer *w, int depth, const char *text)
{
    put(w, "\n");
    for (int i = 0; i < depth && i < DEEPEST; i++)
        put(w, "  ");
    put(w, text);
}

static void add_numbers(lw_bytes *out, const double *v, int n)
{
    for (int i = 0; i < n; i++) {
        lw_bytes_text(out, i ? " " : "");
        lw_bytes_number(out, v[i], DIGITS);
    }
}

static void begin_attribute(writer *w, const char *attribute)
{
    put(w, " ");
    put(w, attribute);
    put(w, "=\"");
}

static void put_numbers(writer *w, const char *attribute, const double *v, int n)
{
    begin_attribute(w, attribute);
    add_numbers(w->out, v, n);
    put(w, "\"");
}

static void put_attribute(writer *w, const char *attribute, double v) { put_numbers(w, attribute, &v, 1); }
static void put_vec(writer *w, const char *attribute, lw_vec3 v) { put_numbers(w, attribute, (double[]){ v.x, v.y, v.z }, 3); }

/* A name, followed by `more`. */
static void put_name(writer *w, const char *attribute, const char *name, const char *more)
{
    begin_attribute(w, attribute);
    lw_bytes_xml(w->out, name);
    put(w, more);
    put(w, "\"");
}

/* The name of a link, which is not "world". */
static void put_link(writer *w, const char *attribute, int link)
{
    const char *name = w->m->body[link].name;
    put_name(w, attribute, name, strcmp(name, "world") == 0 ? " link" : "");
}

static lw_vec3 from_origin(const writer *w, int link, lw_vec3 at) { return lw_v3_sub(at, w->tree.origin[link]); }

/* Add to the numbers of the keyframe. */
static void add_key(lw_bytes *key, const double *v, int n)
{
    lw_bytes_text(key, key->size > 0 && n > 0 ? " " : "");
    add_numbers(key, v, n);
}

/* ---- coordinates --------------------------------------------------------------------------------- */

static bool same(lw_spatial_measure a, lw_spatial_measure b) { return a.of == b.of && a.index == b.index; }

/* In a model with masses, an input without a motion runs freely. */
static bool is_driven(const writer *w, const lw_spatial_input *in) { return !w->weighed || in->motion; }

/* What the actuators move: the drives, or the inputs. Returns how many there are. */
static int n_actuator(const writer *w) { return w->m->n_drive ? w->m->n_drive : w->m->n_input; }

static bool is_actuated(const writer *w, int i)
{
    return w->m->n_drive ? w->m->n_input > 0 && is_driven(w, &w->m->input[0]) : is_driven(w, &w->m->input[i]);
}

static lw_spatial_measure actuated(const writer *w, int i)
{
    return w->m->n_drive ? w->m->drive[i] : w->m->input[i].measure;
}

/* The input of a measure; NULL: it is none. */
static const lw_spatial_input *input_of(const writer *w, lw_spatial_measure of)
{
    for (int at = w->inputs.start[of.index]; at < w->inputs.start[of.index + 1]; at++)
        if (same(w->m->input[w->inputs.entry[at]].measure, of))
            return &w->m->input[w->inputs.entry[at]];
    return NULL;
}

/* Value of a coordinate in the posture. */
static double reference_of(const writer *w, lw_spatial_measure of)
{
    const lw_spatial_input *in = input_of(w, of);
    return in ? in->value : 0;
}

/* Inertia of a drive: that of all bodies at the distance of the model's size, so that the frequency of the drive changes little over the
 * motion, which does not depend on it. */
static double drive_inertia(const writer *w, lw_spatial_measure of)
{
    return w->mass*(of.of == LW_OF_TURN ? w->size*w->size : 1);
}

/* Name of the coordinate of a joint in the file: its own, with " turn" or " slide" where the joint has both. */
static void put_coordinate(writer *w, const char *attribute, lw_spatial_measure of)
{
    const lw_spatial_joint *p = &w->m->joint[of.index];
    const lw_spatial_kind_row *kind = lw_spatial_kind_of(p->kind);
    put_name(w, attribute, p->name, !(kind->turns && kind->slides) ? "" : of.of == LW_OF_TURN ? " turn" : " slide");
}

/* What acts on a coordinate. */
static void put_reference(writer *w, lw_spatial_measure of)
{
    const lw_spatial *m = w->m;
    const lw_spatial_joint *p = &m->joint[of.index];
    const lw_joint_stop *stop = &p->stop;
    double at = reference_of(w, of), stiffness = 0, damping = 0, pull = 0;
    for (int i = w->joint_springs.start[of.index]; i < w->joint_springs.start[of.index + 1]; i++) {
        const lw_spatial_joint_spring *spring = &m->joint_spring[w->joint_springs.entry[i]];
        if (!same(spring->measure, of))
            continue;
        stiffness += spring->stiffness;
        damping += spring->damping;
        pull += spring->stiffness*spring->free;
    }
    if (at != 0)
        put_attribute(w, "ref", at);
    if (stiffness > 0) {
        put_attribute(w, "stiffness", stiffness);
        put_attribute(w, "springref", at + pull/stiffness);
    }
    if (damping > 0)
        put_attribute(w, "damping", damping);
    if ((stop->has_least || stop->has_greatest) && of.of == (lw_spatial_kind_of(p->kind)->turns ? LW_OF_TURN : LW_OF_SLIDE)) {
        put(w, " limited=\"true\"");
        put_numbers(w, "range", (double[]){ at + (stop->has_least ? stop->least : -1e6), at + (stop->has_greatest ? stop->greatest : 1e6) }, 2);
    }
    for (int i = 0; i < n_actuator(w); i++)
        if (is_actuated(w, i) && same(actuated(w, i), of)) {
            put_attribute(w, "armature", drive_inertia(w, of));
            break;
        }
}

/* The part of omega about the unit vector a, the rest being about b. */
static double share(lw_vec3 omega, lw_vec3 a, lw_vec3 b)
{
    double c = lw_v3_dot(a, b);
    return (lw_v3_dot(omega, a) - c*lw_v3_dot(omega, b))/(1 - c*c);
}

/* A hinge or a slide, and its speed; `more` ends its name when it is not the coordinate that the joint counts. */
static void put_axis(writer *w, int depth, int joint, lw_spatial_of of, lw_vec3 axis, const char *more, double speed)
{
    lw_spatial_measure measure = { of, joint };
    put_tag(w, depth, of == LW_OF_TURN ? "<joint type=\"hinge\"" : "<joint type=\"slide\"");
    if (more)
        put_name(w, "name", w->m->joint[joint].name, more);
    else
        put_coordinate(w, "name", measure);
    put_vec(w, "axis", axis);
    if (!more)
        put_reference(w, measure);
    put(w, "/>");
    add_key(&w->speeds, &speed, 1);
}

static void put_slide(writer *w, int depth, int j, lw_vec3 axis, const char *more, lw_export_twist speed)
{
    put_axis(w, depth, j, LW_OF_SLIDE, axis, more, lw_v3_dot(speed.velocity, axis));
}

static void put_turn(writer *w, int depth, int j, lw_vec3 axis, const char *more, lw_export_twist speed)
{
    put_axis(w, depth, j, LW_OF_TURN, axis, more, lw_v3_dot(speed.omega, axis));
}

/* A pin in a slot: seen from the link of the pin, it turns first. */
static void put_slot(writer *w, int depth, int j, bool turned, lw_export_twist speed)
{
    lw_vec3 axis = lw_v3_scale(w->m->joint[j].axis, turned ? -1 : 1), along = lw_v3_scale(w->m->joint[j].second, turned ? -1 : 1);
    if (!turned)
        put_slide(w, depth, j, along, " slide", speed);
    put_turn(w, depth, j, axis, " turn", speed);
    if (turned)
        put_slide(w, depth, j, along, " slide", speed);
}

static void put_free(writer *w, int depth, int j, lw_export_twist speed)
{
    const double all[] = { speed.velocity.x, speed.velocity.y, speed.velocity.z, speed.omega.x, speed.omega.y, speed.omega.z };
    if (w->plane) {
        put_slide(w, depth, j, lw_v3(1, 0, 0), " x", speed);
        put_slide(w, depth, j, lw_v3(0, 1, 0), " y", speed);
        put_turn(w, depth, j, lw_v3(0, 0, 1), " turn", speed);
        return;
    }
    put_tag(w, depth, "<joint type=\"free\"");
    put_name(w, "name", w->m->joint[j].name, "");
    put(w, "/>");
    add_key(&w->speeds, all, 6);
}

/* The coordinates that joint j leaves `child` against its parent; the body's frame begins at the joint. */
static void put_joint(writer *w, int depth, int j, int child)
{
    const lw_spatial_joint *p = &w->m->joint[j];
    int first = p->link[0] == child ? 1 : 0;              /* the side of the parent */
    lw_vec3 axis = lw_v3_scale(p->axis, first ? -1 : 1);
    lw_vec3 one = first ? p->second : p->axis, two = first ? p->axis : p->second;
    lw_export_twist speed = lw_export_relative(w->twist, child, p->link[first], p->at);
    switch (p->kind) {
    case LW_SPATIAL_CYLINDRICAL:
    case LW_SPATIAL_SCREW:
        put_slide(w, depth, j, axis, NULL, speed);
        put_turn(w, depth, j, axis, NULL, speed);
        break;
    case LW_SPATIAL_PRISMATIC:
        put_slide(w, depth, j, axis, NULL, speed);
        break;
    case LW_SPATIAL_REVOLUTE:
        put_turn(w, depth, j, axis, NULL, speed);
        break;
    case LW_SPATIAL_UNIVERSAL:
        put_axis(w, depth, j, LW_OF_TURN, one, " first", share(speed.omega, one, two));
        put_axis(w, depth, j, LW_OF_TURN, two, " second", share(speed.omega, two, one));
        break;
    case LW_SPATIAL_PLANAR:
        if (lw_export_is_slot(p)) {
            put_slot(w, depth, j, first == 1, speed);
            break;
        }
        put_slide(w, depth, j, lw_v3_across(p->axis), " first", speed);
        put_slide(w, depth, j, lw_v3_cross(p->axis, lw_v3_across(p->axis)), " second", speed);
        put_turn(w, depth, j, axis, NULL, speed);
        break;
    case LW_SPATIAL_SPHERICAL:
        put_tag(w, depth, "<joint type=\"ball\"");
        put_name(w, "name", p->name, "");
        put(w, "/>");
        add_key(&w->speeds, (double[]){ speed.omega.x, speed.omega.y, speed.omega.z }, 3);
        break;
    case LW_SPATIAL_FREE:
        put_free(w, depth, j, speed);
        break;
    case LW_SPATIAL_FIXED:
        break;
    }
}

/* ---- bodies --------------------------------------------------------------------------------------- */

static double body_mass(const writer *w, const lw_spatial_body *b) { return fmax(b ? b->mass : 0, LITTLE*w->mass); }

/* Least principal moment of a body. */
static double least_moment(const writer *w, const lw_spatial_body *b)
{
    return (b && b->mass > 0 ? (w->plane ? FLAT : LITTLE)*body_mass(w, b) : LITTLE*w->mass)*w->size*w->size;
}

/* MuJoCo needs some mass and inertia of every body that moves. A bar between ball joints spins about itself without
 * moving anything else; it needs some inertia about its axis too. */
static void put_inertia(writer *w, int depth, const lw_spatial_body *b, lw_vec3 centre)
{
    double value[3] = { 0 };
    lw_mat3 axes = { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
    if (b)
        lw_m3_principal(b->inertia, value, &axes);
    double least = fmax(least_moment(w, b), SLIM*fmax(value[0], fmax(value[1], value[2])));
    for (int i = 0; i < 3; i++)
        value[i] = fmax(value[i], least);
    lw_quaternion turn = lw_quaternion_of_matrix(&axes);
    put_tag(w, depth, "<inertial");
    put_vec(w, "pos", centre);
    put_attribute(w, "mass", body_mass(w, b));
    put_numbers(w, "quat", (double[]){ turn.w, turn.x, turn.y, turn.z }, 4);
    put_numbers(w, "diaginertia", value, 3);
    put(w, "/>");
}

/* A rod from the frame's origin, or a ball there. */
static void put_rod(writer *w, int depth, lw_vec3 to)
{
    bool ball = lw_v3_norm(to) < 1e-9*w->size;
    put_tag(w, depth, ball ? "<geom type=\"sphere\"" : "<geom type=\"capsule\"");
    if (!ball)
        put_numbers(w, "fromto", (double[]){ 0, 0, 0, to.x, to.y, to.z }, 6);
    put_attribute(w, "size", (ball ? 0.02 : 0.01)*w->size);
    put(w, w->weighed ? " density=\"0\"/>" : "/>");
}

static double rod_mass(const writer *w, lw_vec3 to)
{
    bool ball = lw_v3_norm(to) < 1e-9*w->size;
    double r = (ball ? 0.02 : 0.01)*w->size;
    return STEEL*(4*LW_PI/3*r*r*r + (ball ? 0 : LW_PI*r*r*lw_v3_norm(to)));
}

/* Rods from the origin of the frame of a link to its joints and tracers, or a ball there: they are written or, with depth 0, only weighed.
 * Returns their mass in steel. */
static double put_shape(writer *w, int depth, int link)
{
    const lw_spatial *m = w->m;
    int first = w->joints.start[link], joints = w->joints.start[link + 1] - first, tracers = w->tracers.start[link];
    int rods = 0, n = joints + w->tracers.start[link + 1] - tracers;
    double mass = 0;
    for (int i = 0; i <= n; i++) {
        lw_vec3 to = lw_v3(0, 0, 0);
        if (i < n)
            to = from_origin(w, link, i < joints ? m->joint[w->joints.entry[first + i]/2].at : m->tracer[w->tracers.entry[tracers + i - joints]].at);
        if (i < n ? lw_v3_norm(to) < 1e-9*w->size : rods > 0)
            continue;
        rods++;
        mass += rod_mass(w, to);
        if (depth > 0)
            put_rod(w, depth, to);
    }
    return mass;
}

/* A point of a link, with the turn of a tracer or without. */
static void put_site(writer *w, int depth, const char *name, const char *more, int link, lw_vec3 at, const lw_quaternion *turn)
{
    put_tag(w, depth, "<site");
    put_name(w, "name", name, more);
    put_vec(w, "pos", from_origin(w, link, at));
    if (turn)
        put_numbers(w, "quat", (double[]){ turn->w, turn->x, turn->y, turn->z }, 4);
    put_attribute(w, "size", (turn ? 0.02 : 0.01)*w->size);
    put(w, "/>");
}

/* Tracers, and the points of springs, ropes and forces. */
static void put_sites(writer *w, int depth, int link)
{
    const lw_spatial *m = w->m;
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
        const lw_spatial_tracer *p = &m->tracer[w->tracers.entry[at]];
        put_site(w, depth, p->name, "", link, p->at, &p->frame);
    }
    for (int at = w->springs.start[link]; at < w->springs.start[link + 1]; at++) {
        const lw_spring *p = &m->spring[w->springs.entry[at]/2];
        int end = w->springs.entry[at]%2;
        put_site(w, depth, p->name, end ? " end" : " start", link, p->at[end], NULL);
    }
    for (int at = w->plane ? w->ropes.start[link] : 0; w->plane && at < w->ropes.start[link + 1]; at++) {
        const lw_rope *p = &w->plane->model.rope[w->ropes.entry[at]/2];
        int end = w->ropes.entry[at]%2;
        put_site(w, depth, p->name, end ? " rope end" : " rope start", link, lw_v3(p->at[end].x, p->at[end].y, 0), NULL);
    }
    for (int at = w->forces.start[link]; at < w->forces.start[link + 1]; at++) {
        const lw_force *p = &m->force[w->forces.entry[at]];
        put_site(w, depth, p->name, " force", link, p->at, NULL);
    }
}

/* Does a joint that closes a loop need a body of its own, which moves on link[0] as the joint allows but for a turn? */
static bool has_runner(lw_spatial_kind kind)
{
    return kind == LW_SPATIAL_PRISMATIC || kind == LW_SPATIAL_CYLINDRICAL || kind == LW_SPATIAL_SCREW
        || kind == LW_SPATIAL_PLANAR || kind == LW_SPATIAL_UNIVERSAL;
}

static void put_runners(writer *w, int depth, int link)
{
    for (int at = w->joints.start[link]; at < w->joints.start[link + 1]; at++) {
        int j = w->joints.entry[at]/2;
        const lw_spatial_joint *p = &w->m->joint[j];
        if (w->tree.in_tree[j] || w->joints.entry[at]%2 == 1 || !has_runner(p->kind))
            continue;
        bool plane = p->kind == LW_SPATIAL_PLANAR && !lw_export_is_slot(p);
        lw_vec3 x = lw_v3_across(p->axis), along = plane ? x : lw_export_is_slot(p) ? p->second : p->axis;
        lw_export_twist speed = lw_export_relative(w->twist, p->link[1], p->link[0], p->at);
        put_tag(w, depth, "<body");
        put_name(w, "name", p->name, " runner");
        put_vec(w, "pos", from_origin(w, link, p->at));
        put(w, ">");
        if (p->kind == LW_SPATIAL_UNIVERSAL)
            put_axis(w, depth + 1, j, LW_OF_TURN, p->axis, " first", share(speed.omega, p->axis, p->second));
        else
            put_slide(w, depth + 1, j, along, " first", speed);
        if (p->kind == LW_SPATIAL_SCREW)
            put_turn(w, depth + 1, j, p->axis, " second", speed);
        if (plane)
            put_slide(w, depth + 1, j, lw_v3_cross(p->axis, x), " second", speed);
        put_inertia(w, depth + 1, NULL, lw_v3(0, 0, 0));
        put_rod(w, depth + 1, lw_v3(0, 0, 0));
        put_tag(w, depth, "</body>");
    }
}

/* Begin the body of a link: all of it but the bodies inside it. */
static void put_body(writer *w, int depth, int link)
{
    const lw_spatial *m = w->m;
    const lw_spatial_body *b = &m->body[link];
    if (link != m->ground) {
        put_tag(w, depth, "<body");
        put_link(w, "name", link);
        put_vec(w, "pos", from_origin(w, w->tree.parent[link], w->tree.origin[link]));
        put(w, ">");
        put_joint(w, depth + 1, w->tree.joint[link], link);
        if (w->weighed)
            put_inertia(w, depth + 1, b, b->given ? from_origin(w, link, b->centre) : lw_v3(0, 0, 0));
        put_shape(w, depth + 1, link);
    }
    put_sites(w, depth + 1, link);
    put_runners(w, depth + 1, link);
}

/* The bodies of all links, each inside its parent; without recursion, since a chain may be as long as memory holds. */
static void put_bodies(writer *w)
{
    const lw_export_tree *t = &w->tree;
    int depth = 1, link = w->m->ground;
    put_body(w, depth, link);
    for (;;) {
        if (t->child[link] >= 0) {
            put_body(w, ++depth, link = t->child[link]);
            continue;
        }
        for (; link != w->m->ground && t->next[link] < 0; link = t->parent[link])
            put_tag(w, depth--, "</body>");
        if (link == w->m->ground)
            return;
        put_tag(w, depth, "</body>");
        put_body(w, depth, link = t->next[link]);
    }
}

/* ---- what closes the loops ------------------------------------------------------------------------ */

/* Join link[1] of a joint to its runner, or to link[0], at a point. The world cannot be the first of the two. */
static void put_equality(writer *w, const char *kind, int j, bool runner, const lw_vec3 *at)
{
    const lw_spatial_joint *p = &w->m->joint[j];
    int side = !runner && p->link[0] == w->m->ground ? 1 : 0, other = p->link[1 - side];
    put_tag(w, 2, kind);
    if (runner)
        put_name(w, "body1", p->name, " runner");
    else
        put_link(w, "body1", p->link[side]);
    if (other != w->m->ground)
        put_link(w, "body2", other);
    if (at)
        put_vec(w, "anchor", lw_v3_sub(*at, runner ? p->at : w->tree.origin[p->link[side]]));
    put(w, "/>");
}

/* Two points of an axis, which leave the turn about it; one is enough in the plane. */
static void put_hinge(writer *w, int j, bool runner, lw_vec3 axis)
{
    for (int end = w->plane ? 0 : -1; end <= 1; end += 2) {
        lw_vec3 at = lw_v3_add(w->m->joint[j].at, lw_v3_scale(axis, end*HINGE*w->size));
        put_equality(w, "<connect", j, runner, &at);
    }
}

/* slide = pitch times turn of a screw */
static void put_screw(writer *w, int j)
{
    const lw_spatial_joint *p = &w->m->joint[j];
    bool in_tree = w->tree.in_tree[j];
    put_tag(w, 2, "<joint");
    put_name(w, "joint1", p->name, in_tree ? " slide" : " first");
    put_name(w, "joint2", p->name, in_tree ? " turn" : " second");
    put_numbers(w, "polycoef", (double[]){ 0, p->lead/(2*LW_PI), 0, 0, 0 }, 5);
    put(w, "/>");
}

/* The second coordinate of two follows the first one; a sum of more is the length of a tendon. */
static void put_coupling(writer *w, const lw_spatial_coupling *c)
{
    put_tag(w, 2, c->n == 2 ? "<joint" : "<tendon");
    if (c->n == 2) {
        put_coordinate(w, "joint1", c->of[1]);
        put_coordinate(w, "joint2", c->of[0]);
        put_numbers(w, "polycoef", (double[]){ 0, -c->factor[0]/c->factor[1], 0, 0, 0 }, 5);
    } else
        put_name(w, "tendon1", c->name, " coupling");
    put(w, "/>");
}

static void put_closures(writer *w)
{
    put(w, "\n  <equality>");
    for (int j = 0; j < w->m->n_joint; j++) {
        const lw_spatial_joint *p = &w->m->joint[j];
        if (p->kind == LW_SPATIAL_SCREW)
            put_screw(w, j);
        if (w->tree.in_tree[j])
            continue;
        switch (p->kind) {
        case LW_SPATIAL_REVOLUTE:    put_hinge(w, j, false, p->axis);                   break;
        case LW_SPATIAL_CYLINDRICAL: put_hinge(w, j, true, p->axis);                    break;
        case LW_SPATIAL_PLANAR:      put_hinge(w, j, true, p->axis);                    break;
        case LW_SPATIAL_UNIVERSAL:   put_hinge(w, j, true, p->second);                  break;
        case LW_SPATIAL_SPHERICAL:   put_equality(w, "<connect", j, false, &p->at);     break;
        case LW_SPATIAL_PRISMATIC:
        case LW_SPATIAL_SCREW:       put_equality(w, "<weld", j, true, NULL);           break;
        case LW_SPATIAL_FIXED:       put_equality(w, "<weld", j, false, NULL);          break;
        case LW_SPATIAL_FREE:        break;
        }
    }
    for (int i = 0; i < w->m->n_coupling; i++)
        put_coupling(w, &w->m->coupling[i]);
    put(w, "\n  </equality>");
}

/* ---- loads ---------------------------------------------------------------------------------------- */

/* Can loads act on the coordinate of a joint?  It stands in the tree, and a slot has two. */
static bool takes_loads(const writer *w, int j) { return w->tree.in_tree[j] && !lw_export_is_slot(&w->m->joint[j]); }

/* Refuse what has no form in MJCF, by name. */
static lw_status check(const writer *w, lw_error *e)
{
    const lw_spatial *m = w->m;
    for (int i = 0; i < n_actuator(w); i++) {
        lw_spatial_measure of = actuated(w, i);
        if (is_actuated(w, i) && of.of >= LW_OF_X)
            return lw_error_set(e, LW_E_KIND, "an input prescribes tracer '%s', which has no form in MJCF; name the "
                                "joints that move it as \"drives\"", m->tracer[of.index].name);
        if (is_actuated(w, i) && !w->tree.in_tree[of.index])
            return lw_error_set(e, LW_E_KIND, "'%s' closes a loop of driven joints, which has no form in MJCF", m->joint[of.index].name);
    }
    for (int i = 0; i < m->n_joint_spring; i++)
        if (!takes_loads(w, m->joint_spring[i].measure.index))
            return lw_error_set(e, LW_E_KIND, "joint spring '%s' acts at a joint by which a loop is closed, or in a slot, which has no form in "
                                "MJCF", m->joint_spring[i].name);
    for (int i = 0; i < m->n_motor; i++)
        if (!takes_loads(w, m->motor[i].joint))
            return lw_error_set(e, LW_E_KIND, "motor '%s' acts at a joint by which a loop is closed, which has no form in MJCF",
                                m->motor[i].name);
    for (int i = 0; i < m->n_coupling; i++)
        for (int k = 0; k < m->coupling[i].n; k++)
            if (!takes_loads(w, m->coupling[i].of[k].index))
                return lw_error_set(e, LW_E_KIND, "coupling '%s' acts at joint '%s', by which a loop is closed, which has no form in MJCF",
                                    m->coupling[i].name, m->joint[m->coupling[i].of[k].index].name);
    for (int j = 0; j < m->n_joint; j++) {
        const lw_joint_stop *stop = &m->joint[j].stop;
        bool stops = stop->has_least || stop->has_greatest;
        if (stops && (stop->restitution > 0 || stop->stiffness > 0 || !takes_loads(w, j)))
            return lw_error_set(e, LW_E_KIND, "joint '%s' has a stop that %s, which has no form in MJCF",
                                m->joint[j].name,
                                takes_loads(w, j) ? "rebounds or gives way" : "acts where a loop is closed, or in a slot");
    }
    for (int i = 0; w->plane && i < w->plane->model.n_rope; i++) {
        const lw_rope *p = &w->plane->model.rope[i];
        if (p->surface.stiffness > 0 || p->surface.restitution > 0)
            return lw_error_set(e, LW_E_KIND, "rope '%s' rebounds or gives way, which has no form in MJCF", p->name);
    }
    return LW_OK;
}

/* End a tendon between two sites. */
static void end_tendon(writer *w, const char *name, const char *const more[2])
{
    put_attribute(w, "width", 0.005*w->size);
    put(w, ">");
    for (int end = 0; end < 2; end++) {
        put_tag(w, 3, "<site");
        put_name(w, "site", name, more[end]);
        put(w, "/>");
    }
    put_tag(w, 2, "</spatial>");
}

static void put_spring(writer *w, const lw_spring *p)
{
    put_tag(w, 2, "<spatial");
    put_name(w, "name", p->name, "");
    put_attribute(w, "springlength", p->free);
    put_attribute(w, "stiffness", p->stiffness);
    put_attribute(w, "damping", p->damping);
    end_tendon(w, p->name, (const char *[]){ " start", " end" });
}

/* A tendon with a greatest length, where nothing rebounds. */
static void put_rope(writer *w, const lw_rope *p)
{
    put_tag(w, 2, "<spatial limited=\"true\" solimplimit=\"0.9999 0.9999 0.001\"");
    put_name(w, "name", p->name, " rope");
    put_numbers(w, "range", (double[]){ 0, p->length }, 2);
    put_numbers(w, "solreflimit", (double[]){ 2*w->step, DAMPING }, 2);
    end_tendon(w, p->name, (const char *[]){ " rope start", " rope end" });
}

static int n_rope(const writer *w) { return w->plane ? w->plane->model.n_rope : 0; }

/* Springs and ropes between points; the sum of a coupling is the length of a tendon, which an equality keeps. */
static void put_tendons(writer *w)
{
    bool any = w->m->n_spring + w->m->n_coupling + n_rope(w) > 0;
    put(w, any ? "\n  <tendon>" : "");
    for (int i = 0; i < w->m->n_coupling; i++) {
        const lw_spatial_coupling *c = &w->m->coupling[i];
        if (c->n == 2)
            continue;
        put(w, "\n    <fixed");
        put_name(w, "name", c->name, " coupling");
        put(w, ">");
        for (int k = 0; k < c->n; k++) {
            put(w, "\n      <joint");
            put_coordinate(w, "joint", c->of[k]);
            put_attribute(w, "coef", c->factor[k]);
            put(w, "/>");
        }
        put(w, "\n    </fixed>");
    }
    for (int i = 0; i < w->m->n_spring; i++)
        put_spring(w, &w->m->spring[i]);
    for (int i = 0; i < n_rope(w); i++)
        put_rope(w, &w->plane->model.rope[i]);
    put(w, any ? "\n  </tendon>" : "");
}

/* Mass or inertia that moves along or about the axis of a joint when one link is held: the lesser of its two links. */
static double least_inertia(const writer *w, lw_spatial_measure of)
{
    const lw_spatial_joint *p = &w->m->joint[of.index];
    double least = INFINITY;
    for (int side = 0; side < 2; side++) {
        const lw_spatial_body *b = &w->m->body[p->link[side]];
        const double *t = b->inertia;
        lw_vec3 a = p->axis, arm = b->given ? lw_v3_cross(a, lw_v3_sub(b->centre, p->at)) : lw_v3(0, 0, 0);
        double own = t[0]*a.x*a.x + t[1]*a.y*a.y + t[2]*a.z*a.z + 2*(t[3]*a.x*a.y + t[4]*a.x*a.z + t[5]*a.y*a.z), mass = body_mass(w, b);
        if (p->link[side] != w->m->ground)
            least = fmin(least, of.of == LW_OF_TURN ? fmax(own, least_moment(w, b)) + mass*lw_v3_dot(arm, arm) : mass);
    }
    return least;
}

/* The longest step for a spring and a damper on an inertia: a fifth of 1/omega, half of the damper's time constant. */
static double step_for(double inertia, double stiffness, double damping)
{
    return fmin(stiffness > 0 ? 0.2*sqrt(inertia/stiffness) : INFINITY, damping > 0 ? 0.5*inertia/damping : INFINITY);
}

/* The lesser mass at the ends of a spring; an end without mass moves with other links, the lightest of all at the least. */
static double lighter_end(const writer *w, const lw_spring *p, double lightest)
{
    double least = INFINITY;
    for (int end = 0; end < 2; end++)
        if (p->link[end] != w->m->ground)
            least = fmin(least, w->m->body[p->link[end]].mass > 0 ? w->m->body[p->link[end]].mass : lightest);
    return least;
}

/* The step of time: what all springs, dampers and motors allow, a whole part of the usual one.  A stop or a rope gives way for some steps. */
static double choose_step(const writer *w)
{
    const lw_spatial *m = w->m;
    double lightest = INFINITY, usual = w->plane ? PLANE_STEP : STEP, step = usual;
    if (!w->weighed)
        return step;
    for (int i = 0; i < m->n_link; i++)
        if (i != m->ground && m->body[i].mass > 0)
            lightest = fmin(lightest, m->body[i].mass);
    for (int i = 0; i < m->n_spring; i++)
        step = fmin(step, step_for(lighter_end(w, &m->spring[i], lightest), m->spring[i].stiffness, m->spring[i].damping));
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_spatial_joint_spring *p = &m->joint_spring[i];
        step = fmin(step, step_for(least_inertia(w, p->measure), p->stiffness, p->damping));
    }
    for (int i = 0; i < m->n_motor; i++) {
        const lw_motor *p = &m->motor[i];
        lw_spatial_measure of = { lw_spatial_kind_of(m->joint[p->joint].kind)->turns ? LW_OF_TURN : LW_OF_SLIDE, p->joint };
        step = fmin(step, step_for(least_inertia(w, of), 0, p->stall/p->free_speed));
    }
    for (int j = 0; w->plane && j < m->n_joint; j++)
        if (m->joint[j].stop.has_least || m->joint[j].stop.has_greatest)
            step = fmin(step, STOP_STEP);
    if (n_rope(w) > 0)
        step = fmin(step, ROPE_STEP);
    return usual/ceil(usual/fmax(1e-6, step));
}

/* ---- actuators ------------------------------------------------------------------------------------ */

/* The limits of a planar linkage for input i, where there are any; its drive stays within `part` of them: in a limit, a singular posture, the
 * motion could go on in several ways. */
static bool find_limits(writer *w, int i, double part, double limit[2])
{
    const lw_export_plane *p = w->plane;
    double down, up, value = w->m->input[i].value;
    bool turns, ends = false;
    w->out->failed |= lw_export_way(&p->model.linkage, p->given ? &p->model : NULL, i, &down, &up, &turns, &ends) != LW_OK;
    limit[0] = value - part*down, limit[1] = value + part*up;
    return ends;
}

/* Without the names of joints: two hyphens would end the comment. */
static void put_limits(writer *w)
{
    double limit[2];
    for (int i = 0; w->plane && i < w->m->n_input; i++) {
        if (is_driven(w, &w->m->input[i]) || !find_limits(w, i, 1, limit))
            continue;
        put(w, "\n  <!-- The input runs freely and comes to limits of the linkage at ");
        lw_bytes_number(w->out, limit[0], 6);
        put(w, " and ");
        lw_bytes_number(w->out, limit[1], 6);
        put(w, ": singular postures, which MuJoCo may leave in another way than a rigid linkage. -->");
    }
}

/* A spring of a frequency that suits the step of time, on the inertia of the drive, with damping; its control is the coordinate. */
static void put_drive(writer *w, int i)
{
    const lw_spatial_measure of = actuated(w, i);
    const lw_spatial_input *in = input_of(w, of);
    double omega = DRIVE/w->step, stiffness = drive_inertia(w, of)*omega*omega, at = reference_of(w, of), limit[2];
    bool range = in && in->has_range;
    put(w, "\n    <general biastype=\"affine\"");
    put_name(w, "name", w->m->joint[of.index].name, " drive");
    put_coordinate(w, "joint", of);
    put_attribute(w, "gainprm", stiffness);
    put_numbers(w, "biasprm", (double[]){ 0, -stiffness, -2*RATIO*stiffness/omega }, 3);
    if (range)
        limit[0] = in->first, limit[1] = in->last;
    if (range || (w->plane && find_limits(w, i, 0.99, limit))) {
        put(w, " ctrllimited=\"true\"");
        put_numbers(w, "ctrlrange", limit, 2);
    }
    put(w, "/>");
    add_key(&w->controls, &at, 1);
}

static void put_motor(writer *w, const lw_motor *p)
{
    lw_spatial_measure of = { lw_spatial_kind_of(w->m->joint[p->joint].kind)->turns ? LW_OF_TURN : LW_OF_SLIDE, p->joint };
    put_tag(w, 2, "<general gainprm=\"0\" biastype=\"affine\"");
    put_name(w, "name", p->name, " motor");
    put_coordinate(w, "joint", of);
    put_numbers(w, "biasprm", (double[]){ p->stall, 0, -p->stall/p->free_speed }, 3);
    put(w, "/>");
}

/* Three components and three moments at a site, along its axes if the force follows the link, else along those of the world. */
static void put_force(writer *w, const lw_force *p)
{
    double value[6];
    for (int c = 0; c < 6; c++)
        value[c] = lw_export_constant(c < 3 ? p->force[c] : p->torque[c - 3]);
    put_tag(w, 2, "<general gainprm=\"0\" biastype=\"affine\" biasprm=\"1 0 0\"");
    put_name(w, "name", p->name, " force");
    put_name(w, "site", p->name, " force");
    put(w, p->follows ? "" : " refsite=\"axes of the world\"");
    put_numbers(w, "gear", value, 6);
    put(w, "/>");
}

static void put_actuators(writer *w)
{
    const lw_spatial *m = w->m;
    put_limits(w);
    put(w, "\n  <actuator>");
    for (int i = 0; i < n_actuator(w); i++)
        if (is_actuated(w, i))
            put_drive(w, i);
    for (int i = 0; i < m->n_motor; i++)
        put_motor(w, &m->motor[i]);
    for (int i = 0; i < m->n_force; i++)
        put_force(w, &m->force[i]);
    put(w, "\n  </actuator>\n  <sensor>");
    for (int t = 0; t < m->n_tracer; t++) {
        put_tag(w, 2, "<framepos objtype=\"site\"");
        put_name(w, "objname", m->tracer[t].name, "");
        put(w, "/>");
    }
    put(w, "\n  </sensor>");
}

/* The posture: controls of the drives, and velocities where not all are 0. */
static void put_keyframe(writer *w)
{
    bool drives = w->controls.size > 0, moves = w->twist && w->speeds.size > 0;
    w->out->failed |= w->controls.failed || w->speeds.failed;
    if (!drives && !moves)
        return;
    put(w, "\n  <keyframe>\n    <key name=\"posture\"");
    if (drives) {
        begin_attribute(w, "ctrl");
        put(w, w->controls.data);
        for (int i = 0; i < w->m->n_motor + w->m->n_force; i++)
            put(w, " 0");
        put(w, "\"");
    }
    if (moves)
        put_name(w, "qvel", w->speeds.data, "");
    put(w, "/>\n  </keyframe>");
}

/* ---- the whole ------------------------------------------------------------------------------------ */

/* From the start of the file to that of the world's body. MuJoCo 2 asks for room where equalities and limits have more than 500 rows. */
static void put_head(writer *w)
{
    const lw_spatial *m = w->m;
    int rows = 6*(m->n_joint - m->n_link + 1) + 2*m->n_joint + n_rope(w);
    put(w, "<mujoco");
    put_name(w, "model", m->name[0] ? m->name : "model", "");
    put(w, ">\n  <!-- The controls of the drives are coordinates of their joints; those of the posture, and its speeds, are "
           "in the keyframe. -->\n  <compiler angle=\"radian\" boundmass=\"1e-12\" boundinertia=\"1e-18\"/>"
           "\n  <option integrator=\"RK4\"");
    put_vec(w, "gravity", w->weighed ? m->gravity : lw_v3(0, 0, 0));
    put_attribute(w, "timestep", w->step);
    if (rows > 500) {
        put(w, "/>\n  <size");
        put_attribute(w, "njmax", rows);
    }
    put(w, "/>\n  <statistic");
    put_attribute(w, "extent", w->size);
    put(w, "/>\n  <default>\n    <joint limited=\"false\"");
    put_numbers(w, "solreflimit", (double[]){ 2*w->step, DAMPING }, 2);
    put(w, " solimplimit=\"0.9999 0.9999 0.001\"/>"
           "\n    <geom contype=\"0\" conaffinity=\"0\" density=\"7850\" rgba=\"0.35 0.55 0.75 1\"/>"
           "\n    <site rgba=\"0.85 0.35 0 1\"/>\n    <equality");
    put_numbers(w, "solref", (double[]){ 2*w->step, 1 }, 2);
    put(w, " solimp=\"0.9999 0.9999 0.001\"/>\n  </default>\n  <worldbody>");
    if (m->n_force > 0)
        put(w, "\n    <site name=\"axes of the world\" pos=\"0 0 0\" rgba=\"0 0 0 0\"/>");
}

static bool list_owners(writer *w)
{
    const lw_spatial *m = w->m;
    int n = m->n_joint > m->n_tracer ? m->n_joint : m->n_tracer;
    return LW_OWNERS(&w->joints, m->n_link, m->joint, m->n_joint, link, 2)
        && LW_OWNERS(&w->tracers, m->n_link, m->tracer, m->n_tracer, link, 1)
        && LW_OWNERS(&w->springs, m->n_link, m->spring, m->n_spring, link, 2)
        && LW_OWNERS(&w->forces, m->n_link, m->force, m->n_force, link, 1)
        && LW_OWNERS(&w->inputs, n, m->input, m->n_input, measure.index, 1)
        && LW_OWNERS(&w->joint_springs, n, m->joint_spring, m->n_joint_spring, measure.index, 1)
        && (!w->plane || LW_OWNERS(&w->ropes, m->n_link, w->plane->model.rope, w->plane->model.n_rope, link, 2));
}

/* plane: the planar model that m stands for; NULL: none. */
static lw_status write_model(const lw_spatial *m, const lw_export_plane *plane, lw_bytes *out, lw_error *e)
{
    double size = plane ? lw_export_size(&plane->model.linkage) : lw_spatial_size(m);
    writer w = { .m = m, .plane = plane, .out = out, .size = size, .weighed = lw_space_weighed(m) };
    lw_status s = lw_space_tree_make(m, plane != NULL, &w.tree, e);
    if (s == LW_OK)
        s = lw_export_space_loads(m, "MJCF", false, e);
    if (s == LW_OK)
        s = check(&w, e);
    if (s == LW_OK)
        s = plane ? lw_export_start(&plane->model, &w.twist, e) : lw_export_space_start(m, m, &w.twist, e);
    if (s == LW_OK && !list_owners(&w))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        for (int i = 0; i < m->n_link; i++)
            w.mass += i == m->ground ? 0 : w.weighed ? m->body[i].mass : put_shape(&w, 0, i);
        w.step = choose_step(&w);
        put_head(&w);
        put_bodies(&w);
        put(&w, "\n  </worldbody>");
        put_closures(&w);
        put_tendons(&w);
        put_actuators(&w);
        put_keyframe(&w);
        put(&w, "\n</mujoco>\n");
        s = lw_bytes_end(out, e);
    }
    if (s != LW_OK)
        lw_bytes_free(out);
    lw_bytes_free(&w.controls);
    lw_bytes_free(&w.speeds);
    free(w.twist);
    lw_export_tree_free(&w.tree);
    lw_owners *const lists[] = { &w.joints, &w.tracers, &w.springs, &w.ropes, &w.forces, &w.inputs, &w.joint_springs };
    for (size_t i = 0; i < sizeof lists/sizeof *lists; i++)
        lw_owners_free(lists[i]);
    return s;
}

lw_status lw_export_space_mjcf(const lw_spatial *m, lw_bytes *out, lw_error *e) { return write_model(m, NULL, out, e); }

lw_status lw_export_mjcf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_export_plane plane;
    lw_status s = lw_export_plane_make(linkage, o ? o->model : NULL, &plane, e);
    if (s == LW_OK)
        s = write_model(&plane.space, &plane, out, e);
    lw_export_plane_free(&plane);
    return s;
}
