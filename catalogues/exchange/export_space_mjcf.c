/* catalogues/exchange/export_space_mjcf.c - write a spatial model as a model of MuJoCo 2.2 (its XML reference). */
#include <stdlib.h>

#include "base/owners.h"
#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"
#include "catalogues/exchange/mjcf.h"
#include "catalogues/exchange/start.h"

#define STEP   2e-4                            /* of time, unless springs need a smaller one [s]          */
#define LITTLE 1e-5                            /* mass of a body without mass, over that of all bodies    */
#define SLIM   1e-4                            /* least principal moment of a body over its greatest one  */
#define HINGE  0.3                             /* half the distance of the points that close a hinge, over the size */

typedef struct writer {
    const lw_spatial *m;
    lw_bytes         *out;
    lw_mjcf_key       key;
    double            size, mass, step;        /* mass: of all bodies                                     */
    bool              weighed;                 /* the model has masses                                    */
    lw_export_twist  *twist;                   /* (n_link) velocities at the start; NULL: all are 0       */
    lw_export_tree    tree;
    lw_owners         joints, tracers, springs, forces;          /* by links                              */
    lw_owners         inputs, joint_springs;                     /* by the joints, or tracers, of their measures */
} writer;

/* ---- text ---------------------------------------------------------------------------------------- */

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }
static void put_tag(writer *w, int depth, const char *text) { lw_mjcf_tag(w->out, depth, text); }
static void put_numbers(writer *w, const char *attribute, const double *v, int n) { lw_mjcf_numbers(w->out, attribute, v, n); }
static void put_attribute(writer *w, const char *attribute, double v) { lw_mjcf_number(w->out, attribute, v); }
static void put_vec(writer *w, const char *attribute, lw_vec3 v) { lw_mjcf_vec(w->out, attribute, v); }

static void put_name(writer *w, const char *attribute, const char *name, const char *more) { lw_mjcf_name(w->out, attribute, name, more); }
static void put_link(writer *w, const char *attribute, int link) { lw_mjcf_link(w->out, attribute, w->m->body[link].name); }

static lw_vec3 from_origin(const writer *w, int link, lw_vec3 at) { return lw_v3_sub(at, w->tree.origin[link]); }

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

/* Value of a coordinate in the posture. */
static double reference_of(const writer *w, lw_spatial_measure of)
{
    for (int at = w->inputs.start[of.index]; at < w->inputs.start[of.index + 1]; at++)
        if (same(w->m->input[w->inputs.entry[at]].measure, of))
            return w->m->input[w->inputs.entry[at]].value;
    return 0;
}

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

/* What acts on a coordinate. A driven one also has an inertia of its drive: that of all bodies at the distance of the model's
 * size, so that the frequency of the drive changes little over the motion, which does not depend on it. */
static void put_reference(writer *w, lw_spatial_measure of)
{
    const lw_spatial *m = w->m;
    const lw_spatial_joint *p = &m->joint[of.index];
    lw_mjcf_coordinate c = { .at = reference_of(w, of) };
    c.has_at = c.at != 0;
    for (int i = w->joint_springs.start[of.index]; i < w->joint_springs.start[of.index + 1]; i++) {
        const lw_spatial_joint_spring *spring = &m->joint_spring[w->joint_springs.entry[i]];
        if (same(spring->measure, of))
            lw_mjcf_coordinate_add(&c, spring->stiffness, spring->damping, spring->free);
    }
    if (of.of == (lw_spatial_kind_of(p->kind)->turns ? LW_OF_TURN : LW_OF_SLIDE))
        c.stop = &p->stop;
    for (int i = 0; i < n_actuator(w); i++)
        if (is_actuated(w, i) && same(actuated(w, i), of))
            c.armature = drive_inertia(w, of);
    lw_mjcf_coordinate_put(w->out, &c);
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
    lw_mjcf_speeds(&w->key, &speed, 1);
}

/* The coordinates that joint j leaves `child` against its parent; the body's frame begins at the joint. */
static void put_joint(writer *w, int depth, int j, int child)
{
    const lw_spatial_joint *p = &w->m->joint[j];
    int first = p->link[0] == child ? 1 : 0;              /* the side of the parent */
    lw_vec3 axis = lw_v3_scale(p->axis, first ? -1 : 1), x = lw_v3_across(p->axis), y = lw_v3_cross(p->axis, x);
    lw_vec3 one = first ? p->second : p->axis, two = first ? p->axis : p->second;
    lw_export_twist speed = lw_export_relative(w->twist, child, p->link[first], p->at);
    double slides = lw_v3_dot(speed.velocity, axis), turns = lw_v3_dot(speed.omega, axis);
    const double all[] = { speed.velocity.x, speed.velocity.y, speed.velocity.z, speed.omega.x, speed.omega.y, speed.omega.z };
    switch (p->kind) {
    case LW_SPATIAL_CYLINDRICAL:
    case LW_SPATIAL_SCREW:
        put_axis(w, depth, j, LW_OF_SLIDE, axis, NULL, slides);
        put_axis(w, depth, j, LW_OF_TURN, axis, NULL, turns);
        break;
    case LW_SPATIAL_PRISMATIC:
        put_axis(w, depth, j, LW_OF_SLIDE, axis, NULL, slides);
        break;
    case LW_SPATIAL_REVOLUTE:
        put_axis(w, depth, j, LW_OF_TURN, axis, NULL, turns);
        break;
    case LW_SPATIAL_UNIVERSAL:
        put_axis(w, depth, j, LW_OF_TURN, one, " first", share(speed.omega, one, two));
        put_axis(w, depth, j, LW_OF_TURN, two, " second", share(speed.omega, two, one));
        break;
    case LW_SPATIAL_PLANAR:
        put_axis(w, depth, j, LW_OF_SLIDE, x, " first", lw_v3_dot(speed.velocity, x));
        put_axis(w, depth, j, LW_OF_SLIDE, y, " second", lw_v3_dot(speed.velocity, y));
        put_axis(w, depth, j, LW_OF_TURN, axis, NULL, turns);
        break;
    case LW_SPATIAL_SPHERICAL:
    case LW_SPATIAL_FREE:
        put_tag(w, depth, p->kind == LW_SPATIAL_SPHERICAL ? "<joint type=\"ball\"" : "<joint type=\"free\"");
        put_name(w, "name", p->name, "");
        put(w, "/>");
        lw_mjcf_speeds(&w->key, p->kind == LW_SPATIAL_FREE ? all : all + 3, p->kind == LW_SPATIAL_FREE ? 6 : 3);
        break;
    case LW_SPATIAL_FIXED:
        break;
    }
}

/* ---- bodies --------------------------------------------------------------------------------------- */

/* MuJoCo needs some mass and inertia of every body that moves. A bar between ball joints spins about itself without
 * moving anything else; it needs some inertia about its axis too. */
static void put_inertia(writer *w, int depth, const lw_spatial_body *b, lw_vec3 centre)
{
    double mass = fmax(b ? b->mass : 0, LITTLE*w->mass), value[3] = { 0 };
    lw_mat3 axes = { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
    if (b)
        lw_m3_principal(b->inertia, value, &axes);
    double least = fmax(LITTLE*(b && b->mass > 0 ? mass : w->mass)*w->size*w->size, SLIM*fmax(value[0], fmax(value[1], value[2])));
    for (int i = 0; i < 3; i++)
        value[i] = fmax(value[i], least);
    lw_quaternion turn = lw_quaternion_of_matrix(&axes);
    put_tag(w, depth, "<inertial");
    put_vec(w, "pos", centre);
    put_attribute(w, "mass", mass);
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

static void put_shape(writer *w, int depth, int link)
{
    const lw_spatial *m = w->m;
    int rods = 0, joints = w->joints.start[link + 1] - w->joints.start[link];
    for (int i = 0; i < joints + w->tracers.start[link + 1] - w->tracers.start[link]; i++) {
        lw_vec3 to = from_origin(w, link, i < joints ? m->joint[w->joints.entry[w->joints.start[link] + i]/2].at
                                 : m->tracer[w->tracers.entry[w->tracers.start[link] + i - joints]].at);
        if (lw_v3_norm(to) < 1e-9*w->size)
            continue;
        put_rod(w, depth, to);
        rods++;
    }
    if (rods == 0)
        put_rod(w, depth, lw_v3(0, 0, 0));
}

/* Tracers, and the points of springs and forces. */
static void put_sites(writer *w, int depth, int link)
{
    const lw_spatial *m = w->m;
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
        const lw_spatial_tracer *p = &m->tracer[w->tracers.entry[at]];
        const double turn[] = { p->frame.w, p->frame.x, p->frame.y, p->frame.z };
        lw_mjcf_site(w->out, depth, p->name, "", from_origin(w, link, p->at), "quat", turn, 4, 0.02*w->size);
    }
    for (int at = w->springs.start[link]; at < w->springs.start[link + 1]; at++) {
        const lw_spatial_spring *p = &m->spring[w->springs.entry[at]/2];
        int end = w->springs.entry[at]%2;
        lw_mjcf_site(w->out, depth, p->name, end ? " end" : " start", from_origin(w, link, p->at[end]), NULL, NULL, 0, 0.01*w->size);
    }
    for (int at = w->forces.start[link]; at < w->forces.start[link + 1]; at++) {
        const lw_spatial_force *p = &m->force[w->forces.entry[at]];
        lw_mjcf_site(w->out, depth, p->name, " force", from_origin(w, link, p->at), NULL, NULL, 0, 0.01*w->size);
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
        lw_vec3 x = lw_v3_across(p->axis);
        if (w->tree.in_tree[j] || w->joints.entry[at]%2 == 1 || !has_runner(p->kind))
            continue;
        lw_vec3 along = p->kind == LW_SPATIAL_PLANAR ? x : p->axis, across = lw_v3_cross(p->axis, x);
        put_tag(w, depth, "<body");
        put_name(w, "name", p->name, " runner");
        put_vec(w, "pos", from_origin(w, link, p->at));
        put(w, ">");
        lw_export_twist speed = lw_export_relative(w->twist, p->link[1], p->link[0], p->at);
        double turns = lw_v3_dot(speed.omega, p->axis);
        if (p->kind == LW_SPATIAL_UNIVERSAL)
            put_axis(w, depth + 1, j, LW_OF_TURN, p->axis, " first", share(speed.omega, p->axis, p->second));
        else
            put_axis(w, depth + 1, j, LW_OF_SLIDE, along, " first", lw_v3_dot(speed.velocity, along));
        if (p->kind == LW_SPATIAL_SCREW)
            put_axis(w, depth + 1, j, LW_OF_TURN, p->axis, " second", turns);
        if (p->kind == LW_SPATIAL_PLANAR)
            put_axis(w, depth + 1, j, LW_OF_SLIDE, across, " second", lw_v3_dot(speed.velocity, across));
        put_inertia(w, depth + 1, NULL, lw_v3(0, 0, 0));
        put_rod(w, depth + 1, lw_v3(0, 0, 0));
        put_tag(w, depth, "</body>");
    }
}

static void put_body(void *context, int depth, int link)
{
    writer *w = context;
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

/* Two points of an axis, which leave the turn about it. */
static void put_hinge(writer *w, int j, bool runner, lw_vec3 axis)
{
    for (int end = -1; end <= 1; end += 2) {
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
    for (int i = 0; i < w->m->n_coupling; i++) {
        put_tag(w, 2, "<tendon");
        put_name(w, "tendon1", w->m->coupling[i].name, " coupling");
        put(w, "/>");
    }
    put(w, "\n  </equality>");
}

/* ---- loads ---------------------------------------------------------------------------------------- */

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
        if (!w->tree.in_tree[m->joint_spring[i].measure.index])
            return lw_error_set(e, LW_E_KIND, "joint spring '%s' acts at a joint by which a loop is closed, which has no form in MJCF",
                                m->joint_spring[i].name);
    for (int i = 0; i < m->n_motor; i++)
        if (!w->tree.in_tree[m->motor[i].joint])
            return lw_error_set(e, LW_E_KIND, "motor '%s' acts at a joint by which a loop is closed, which has no form in MJCF",
                                m->motor[i].name);
    for (int i = 0; i < m->n_coupling; i++)
        for (int k = 0; k < m->coupling[i].n; k++)
            if (!w->tree.in_tree[m->coupling[i].of[k].index])
                return lw_error_set(e, LW_E_KIND, "coupling '%s' acts at joint '%s', by which a loop is closed, which has no form in MJCF",
                                    m->coupling[i].name, m->joint[m->coupling[i].of[k].index].name);
    for (int j = 0; j < m->n_joint; j++) {
        const lw_joint_stop *stop = &m->joint[j].stop;
        bool stops = stop->has_least || stop->has_greatest;
        if (stops && (stop->restitution > 0 || stop->stiffness > 0 || !w->tree.in_tree[j]))
            return lw_error_set(e, LW_E_KIND, "joint '%s' has a stop that %s, which has no form in MJCF",
                                m->joint[j].name,
                                w->tree.in_tree[j] ? "rebounds or gives way" : "acts where a loop is closed");
    }
    return LW_OK;
}

/* Springs between points; the sum of a coupling is the length of a tendon, which an equality keeps. */
static void put_tendons(writer *w)
{
    bool any = w->m->n_spring + w->m->n_coupling > 0;
    put(w, any ? "\n  <tendon>" : "");
    for (int i = 0; i < w->m->n_coupling; i++) {
        const lw_spatial_coupling *c = &w->m->coupling[i];
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
    for (int i = 0; i < w->m->n_spring; i++) {
        const lw_spatial_spring *p = &w->m->spring[i];
        lw_mjcf_spring(w->out, p->name, p->free, p->stiffness, p->damping, 0.005*w->size);
    }
    put(w, any ? "\n  </tendon>" : "");
}

/* The step of time: a fifth of the shortest time 1/omega of a spring on the lightest body, at most STEP. */
static double choose_step(const writer *w)
{
    double least = INFINITY, stiffest = 0;
    for (int i = 0; i < w->m->n_link; i++)
        if (i != w->m->ground && w->m->body[i].mass > 0)
            least = fmin(least, w->m->body[i].mass);
    for (int i = 0; i < w->m->n_spring; i++)
        stiffest = fmax(stiffest, w->m->spring[i].stiffness);
    for (int i = 0; i < w->m->n_joint_spring; i++)
        stiffest = fmax(stiffest, w->m->joint_spring[i].stiffness/(w->m->joint_spring[i].measure.of == LW_OF_TURN ? w->size*w->size : 1));
    return fmax(1e-6, fmin(STEP, stiffest > 0 && isfinite(least) ? 0.2*sqrt(least/stiffest) : STEP));
}

static void put_actuators(writer *w)
{
    const lw_spatial *m = w->m;
    put(w, "\n  <actuator>");
    for (int i = 0; i < n_actuator(w); i++) {
        if (!is_actuated(w, i))
            continue;
        lw_spatial_measure of = actuated(w, i);
        put(w, "\n    <general biastype=\"affine\"");
        put_name(w, "name", m->joint[of.index].name, " drive");
        put_coordinate(w, "joint", of);
        lw_mjcf_drive(w->out, &w->key, reference_of(w, of), drive_inertia(w, of), w->step);
        put(w, "/>");
    }
    for (int i = 0; i < m->n_motor; i++)
        lw_mjcf_motor(w->out, m->motor[i].name, m->joint[m->motor[i].joint].name, m->motor[i].stall, m->motor[i].free_speed);
    for (int i = 0; i < m->n_force; i++) {
        const lw_spatial_force *p = &m->force[i];
        double value[6];
        for (int c = 0; c < 6; c++)
            value[c] = lw_export_constant(c < 3 ? p->force[c] : p->torque[c - 3]);
        lw_mjcf_force(w->out, p->name, p->follows, value);
    }
    put(w, "\n  </actuator>\n  <sensor>");
    for (int t = 0; t < m->n_tracer; t++)
        lw_mjcf_sensor(w->out, m->tracer[t].name);
    put(w, "\n  </sensor>");
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
        && LW_OWNERS(&w->joint_springs, n, m->joint_spring, m->n_joint_spring, measure.index, 1);
}

lw_status lw_export_space_mjcf(const lw_spatial *m, lw_bytes *out, lw_error *e)
{
    writer w = { .m = m, .out = out, .size = lw_spatial_size(m), .weighed = lw_space_weighed(m), .mass = 1 };
    lw_status s = lw_space_tree_make(m, &w.tree, e);
    for (int i = 0; w.weighed && i < m->n_link; i++)
        w.mass = (i ? w.mass : 0) + (i == m->ground ? 0 : m->body[i].mass);
    if (s == LW_OK)
        s = lw_export_space_loads(m, "MJCF", false, e);
    if (s == LW_OK)
        s = check(&w, e);
    if (s == LW_OK)
        s = lw_export_space_start(m, m, &w.twist, e);
    if (s == LW_OK && !list_owners(&w))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        w.step = choose_step(&w);
        lw_mjcf_head(out, m->name[0] ? m->name : "model", w.weighed ? m->gravity : lw_v3(0, 0, 0), w.step, w.size,
                     6*(m->n_joint - m->n_link + 1) + 2*m->n_joint, m->n_force > 0);
        lw_mjcf_bodies(out, &w.tree, m->ground, 1, put_body, &w);
        put(&w, "\n  </worldbody>");
        put_closures(&w);
        put_tendons(&w);
        put_actuators(&w);
        lw_mjcf_keyframe(out, &w.key, m->n_motor + m->n_force, w.twist != NULL);
        put(&w, "\n</mujoco>\n");
        s = lw_bytes_end(out, e);
    }
    if (s != LW_OK)
        lw_bytes_free(out);
    lw_mjcf_key_free(&w.key);
    free(w.twist);
    lw_export_tree_free(&w.tree);
    lw_owners *const lists[] = { &w.joints, &w.tracers, &w.springs, &w.forces, &w.inputs, &w.joint_springs };
    for (size_t i = 0; i < sizeof lists/sizeof *lists; i++)
        lw_owners_free(lists[i]);
    return s;
}
