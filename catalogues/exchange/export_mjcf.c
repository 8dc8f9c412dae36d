/* catalogues/exchange/export_mjcf.c - write a linkage as a model of MuJoCo (XML reference of MuJoCo 2.2). */
#include <stdlib.h>

#include "base/owners.h"
#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/mjcf.h"
#include "catalogues/exchange/start.h"

#define STEEL  7850.0                         /* [kg/m^3]                                                 */
#define STEP   5e-4                           /* of time, unless springs need a smaller one [s]           */

typedef struct writer {
    const lw_assembly *k;
    const lw_model   *m;                      /* NULL: no masses, no loads                                */
    lw_bytes         *out;
    double            size;
    bool              weighed;                /* the model has masses                                     */
    double            mass, rods, step;       /* of all bodies, of the rods drawn so far [kg]; of time [s] */
    lw_export_twist  *twist;                  /* (n_link) velocities at the start; NULL: all are 0       */
    lw_export_tree    tree;
    lw_mjcf_key       key;
    lw_owners         joints, tracers, springs, ropes, forces;   /* by links                              */
    lw_owners         inputs, joint_springs;                     /* by joints                             */
} writer;

/* ---- text --------------------------------------------------------------------------------------- */

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }

static void put_tag(writer *w, int depth, const char *text) { lw_mjcf_tag(w->out, depth, text); }
static void put_attribute(writer *w, const char *attribute, double v) { lw_mjcf_number(w->out, attribute, v); }

static void put_vec(writer *w, const char *attribute, lw_vec2 v) { lw_mjcf_vec(w->out, attribute, lw_v3(v.x, v.y, 0)); }

static void put_name(writer *w, const char *attribute, const char *name, const char *more) { lw_mjcf_name(w->out, attribute, name, more); }
static void put_link(writer *w, const char *attribute, int link) { lw_mjcf_link(w->out, attribute, w->k->link_name[link]); }

static lw_vec2 from_origin(const writer *w, int link, lw_vec2 at) { return lw_v2_sub(at, lw_export_origin(&w->tree, link)); }

/* Does a motion drive the input? In a model with masses, an input without a motion runs freely. */
static bool is_driven(const writer *w, int input)
{
    return !w->weighed || w->m->motion[input] != NULL;
}

/* ---- bodies -------------------------------------------------------------------------------------- */

static double drive_inertia(const writer *w, int joint)
{
    return w->mass*(lw_joint_turns(w->k->joint[joint].kind) ? w->size*w->size : 1);
}

/* Write what acts on a joint's coordinate. A drive's inertia is that of all bodies at the distance of the
 * linkage's size, so that its frequency changes by a factor of sqrt(2) at most over the motion; the motion
 * itself does not depend on it. */
static void put_reference(writer *w, int joint)
{
    const lw_input *input = w->k->input;
    int first = w->inputs.start[joint], end = w->inputs.start[joint + 1];
    lw_mjcf_coordinate c = { .has_at = first < end, .stop = w->m ? &w->m->stop[joint] : NULL };
    if (c.has_at)
        c.at = input[w->inputs.entry[first]].value;
    for (int i = w->joint_springs.start[joint]; i < w->joint_springs.start[joint + 1]; i++) {
        const lw_joint_spring *p = &w->m->joint_spring[w->joint_springs.entry[i]];
        lw_mjcf_coordinate_add(&c, p->stiffness, p->damping, p->free);
    }
    for (int i = first; i < end; i++)
        if (input[w->inputs.entry[i]].ratio == 0 && is_driven(w, w->inputs.entry[i]))
            c.armature = drive_inertia(w, joint);
    lw_mjcf_coordinate_put(w->out, &c);
}

/* A coordinate in which `child` moves against the other link of a joint: along a direction of the plane, or about the normal of the plane. */
static void put_axis(writer *w, int depth, int joint, int child, lw_vec3 axis, const char *more)
{
    const lw_joint *p = &w->k->joint[joint];
    bool turns = axis.z != 0;
    lw_export_twist v = lw_export_relative(w->twist, child, p->link[p->link[0] == child], lw_v3(p->at.x, p->at.y, 0));
    double speed = lw_v3_dot(turns ? v.omega : v.velocity, axis);
    put_tag(w, depth, turns ? "<joint type=\"hinge\"" : "<joint type=\"slide\"");
    put_name(w, "name", p->name, more);
    lw_mjcf_vec(w->out, "axis", axis);
    put_reference(w, joint);
    put(w, "/>");
    lw_mjcf_speeds(&w->key, &speed, 1);
}

static lw_vec3 slide_axis(const lw_joint *p, double sign) { return lw_v3(sign*p->along.x, sign*p->along.y, 0); }

/* Write the tree joint of a body; the body's frame begins at the joint's point. A slot slides on link[0] and turns at
 * the pin: seen from the pin's link, it turns first. */
static void put_joint(writer *w, int depth, int child)
{
    int j = w->tree.joint[child];
    const lw_joint *p = &w->k->joint[j];
    double sign = lw_export_count_sign(w->k, j, child);
    bool slot = lw_joint_has_slot(p->kind), carries = slot && p->link[0] == child, free = lw_joint_freedoms(p->kind) == 3;
    if (free) {
        put_axis(w, depth, j, child, lw_v3(1, 0, 0), " x");
        put_axis(w, depth, j, child, lw_v3(0, 1, 0), " y");
    }
    if (lw_joint_translates(p->kind) || (slot && !carries))
        put_axis(w, depth, j, child, slide_axis(p, sign), slot ? " slide" : "");
    if (lw_joint_turns(p->kind) || slot || free)
        put_axis(w, depth, j, child, lw_v3(0, 0, free ? 1 : sign), slot || free ? " turn" : "");
    if (carries)
        put_axis(w, depth, j, child, slide_axis(p, -1), " slide");
}

/* A rod from the frame's origin, or a ball there. */
static void put_rod(writer *w, int depth, lw_vec2 to)
{
    bool ball = lw_v2_norm(to) < 1e-9*w->size;
    double r = (ball ? 0.02 : 0.01)*w->size;
    put_tag(w, depth, ball ? "<geom type=\"sphere\" pos=\"0 0 0\"" : "<geom type=\"capsule\"");
    if (!ball)
        lw_mjcf_numbers(w->out, "fromto", (double[]){ 0, 0, 0, to.x, to.y, 0 }, 6);
    put_attribute(w, "size", r);
    put(w, w->weighed ? " density=\"0\"/>" : "/>");
    w->rods += STEEL*(4*LW_PI/3*r*r*r + (ball ? 0 : LW_PI*r*r*lw_v2_norm(to)));
}

/* MuJoCo needs some mass and inertia, so bodies without them get a millionth of what all bodies have. */
static double body_mass(const writer *w, double mass) { return fmax(mass, 1e-6*w->mass); }

static double body_inertia(const writer *w, double mass, double inertia) { return fmax(inertia, 1e-6*mass*w->size*w->size); }

/* Write mass and inertia of a body, by whose frame the centre is given. */
static void put_inertia(writer *w, int depth, double mass, lw_vec2 centre, double inertia)
{
    mass = body_mass(w, mass);
    inertia = body_inertia(w, mass, inertia);
    put_tag(w, depth, "<inertial");
    put_vec(w, "pos", centre);
    put_attribute(w, "mass", mass);
    lw_mjcf_numbers(w->out, "diaginertia", (double[]){ inertia, inertia, inertia }, 3);
    put(w, "/>");
}

/* Write rods from the frame's origin to the other points of the link, or a ball if there are none. */
static void put_shape(writer *w, int depth, int link)
{
    const lw_assembly *k = w->k;
    bool any = false;
    for (int at = w->joints.start[link]; at < w->joints.start[link + 1]; at++) {
        int j = w->joints.entry[at]/2;
        const lw_joint *p = &k->joint[j];
        if (j == w->tree.joint[link] || lw_joint_has_ratio(p->kind))
            continue;
        lw_vec2 to = from_origin(w, link, p->at);
        if (lw_v2_norm(to) < 1e-9*w->size)
            continue;
        put_rod(w, depth, to);
        any = true;
    }
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
        lw_vec2 to = from_origin(w, link, k->tracer[w->tracers.entry[at]].at);
        if (lw_v2_norm(to) < 1e-9*w->size)
            continue;
        put_rod(w, depth, to);
        any = true;
    }
    if (!any)
        put_rod(w, depth, lw_v2(0, 0));
}

/* Write a point of a link where a load acts. */
static void put_load_site(writer *w, int depth, const char *name, const char *more, int link, lw_vec2 at)
{
    lw_vec2 p = from_origin(w, link, at);
    lw_mjcf_site(w->out, depth, name, more, lw_v3(p.x, p.y, 0), NULL, NULL, 0, 0.01*w->size);
}

/* Write the tracers of a link, and the points of springs and forces. */
static void put_sites(writer *w, int depth, int link)
{
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
        const lw_tracer *tracer = &w->k->tracer[w->tracers.entry[at]];
        lw_vec2 p = from_origin(w, link, tracer->at);
        lw_mjcf_site(w->out, depth, tracer->name, "", lw_v3(p.x, p.y, 0), "euler", (double[]){ 0, 0, tracer->angle }, 3, 0.02*w->size);
    }
    for (int at = w->springs.start[link]; at < w->springs.start[link + 1]; at++) {
        const lw_spring *p = &w->m->spring[w->springs.entry[at]/2];
        int end = w->springs.entry[at]%2;
        put_load_site(w, depth, p->name, end ? " end" : " start", link, p->at[end]);
    }
    for (int at = w->ropes.start[link]; at < w->ropes.start[link + 1]; at++) {
        const lw_rope *p = &w->m->rope[w->ropes.entry[at]/2];
        int end = w->ropes.entry[at]%2;
        put_load_site(w, depth, p->name, end ? " rope end" : " rope start", link, p->at[end]);
    }
    for (int at = w->forces.start[link]; at < w->forces.start[link + 1]; at++) {
        const lw_force *f = &w->m->force[w->forces.entry[at]];
        put_load_site(w, depth, f->name, " force", link, f->at);
    }
}

/* Write a body that slides on a line of link[0], for each loop that is closed by a slider or a slot. */
static void put_runners(writer *w, int depth, int link)
{
    const lw_assembly *k = w->k;
    for (int at = w->joints.start[link]; at < w->joints.start[link + 1]; at++) {
        int j = w->joints.entry[at]/2;
        const lw_joint *p = &k->joint[j];
        if (w->tree.in_tree[j] || w->joints.entry[at]%2 == 1 || !lw_joint_slides(p->kind))
            continue;
        put_tag(w, depth, "<body");
        put_name(w, "name", p->name, " runner");
        put_vec(w, "pos", from_origin(w, link, p->at));
        put(w, ">");
        put_axis(w, depth + 1, j, p->link[1], slide_axis(p, 1), "");
        if (w->weighed)
            put_inertia(w, depth + 1, 0, lw_v2(0, 0), 0);
        put_rod(w, depth + 1, lw_v2(0, 0));
        put_tag(w, depth, "</body>");
    }
}

/* Begin the body of a link: everything but the bodies inside it. */
static void put_body(void *context, int depth, int link)
{
    writer *w = context;
    if (link != w->k->ground) {
        put_tag(w, depth, "<body");
        put_link(w, "name", link);
        put_vec(w, "pos", from_origin(w, w->tree.parent[link], lw_export_origin(&w->tree, link)));
        put(w, ">");
        put_joint(w, depth + 1, link);
        if (w->weighed) {
            const lw_body *b = &w->m->body[link];
            put_inertia(w, depth + 1, b->mass, b->given ? from_origin(w, link, b->centre) : lw_v2(0, 0), b->inertia);
        }
        put_shape(w, depth + 1, link);
    }
    put_sites(w, depth + 1, link);
    put_runners(w, depth + 1, link);
}

static void put_bodies(writer *w) { lw_mjcf_bodies(w->out, &w->tree, w->k->ground, 2, put_body, w); }

/* ---- what closes the loops ----------------------------------------------------------------------- */

/* body1 must be a body: the ground is the world, so it is second and is left out. */
static void put_pair(writer *w, const char *kind, int joint, bool runner, bool anchor)
{
    const lw_assembly *k = w->k;
    const lw_joint *p = &k->joint[joint];
    int first = p->link[0] == k->ground || runner ? 1 : 0, a = p->link[first], b = p->link[1 - first];
    put_tag(w, 2, kind);
    if (a == k->ground) {              /* the runner on a line of a moving link, connected to the ground */
        put_name(w, "body1", p->name, " runner");
    } else {
        put_link(w, "body1", a);
        if (runner)
            put_name(w, "body2", p->name, " runner");
        else if (b != k->ground)
            put_link(w, "body2", b);
    }
    if (anchor)
        put_vec(w, "anchor", a == k->ground ? lw_v2(0, 0) : from_origin(w, a, p->at));
    put(w, "/>");
}

/* Joint b moves `ratio` times as far as joint a. */
static void put_ratio(writer *w, int a, int b, double ratio)
{
    put_tag(w, 2, "<joint");
    put_name(w, "joint1", w->k->joint[b].name, "");
    put_name(w, "joint2", w->k->joint[a].name, "");
    lw_mjcf_numbers(w->out, "polycoef", (double[]){ 0, ratio, 0, 0, 0 }, 5);
    put(w, "/>");
}

static lw_status put_gear(writer *w, int gear, lw_error *e)
{
    const lw_assembly *k = w->k;
    int joint[2];
    double sign[2];
    lw_status s = lw_export_gear(k, gear, joint, sign, e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < 2; i++)
        if (!w->tree.in_tree[joint[i]])
            return lw_error_set(e, LW_E_KIND, "gear '%s' runs on joint '%s', by which a loop is closed; MuJoCo couples "
                                "joints of its tree only", k->joint[gear].name, k->joint[joint[i]].name);
    put_ratio(w, joint[0], joint[1], k->joint[gear].ratio*sign[0]*sign[1]);
    return LW_OK;
}

static lw_status put_closures(writer *w, lw_error *e)
{
    lw_status s = LW_OK;
    put(w, "\n  <equality>");
    for (int j = 0; s == LW_OK && j < w->k->n_joint; j++) {
        if (w->tree.in_tree[j])
            continue;
        switch (w->k->joint[j].kind) {
        case LW_JOINT_REVOLUTE: put_pair(w, "<connect", j, false, true);  break;
        case LW_JOINT_SLOT:     put_pair(w, "<connect", j, true, true);   break;
        case LW_JOINT_SLIDER:   put_pair(w, "<weld", j, true, false);     break;
        case LW_JOINT_FIXED:    put_pair(w, "<weld", j, false, false);    break;
        case LW_JOINT_GEAR:     s = put_gear(w, j, e);                    break;
        case LW_JOINT_FREE:     break;
        }
    }
    for (int i = lw_assembly_free_inputs(w->k); s == LW_OK && i < w->k->n_input; i++)
        put_ratio(w, w->k->input[0].joint, w->k->input[i].joint, w->k->input[i].ratio);
    put(w, "\n  </equality>");
    return s;
}

/* ---- loads ---------------------------------------------------------------------------------------- */

/* Refuse what has no form in MJCF, by name. */
static lw_status check_loads(const writer *w, lw_error *e)
{
    const lw_model *m = w->m;
    const lw_assembly *k = w->k;
    for (int i = 0; m && i < m->n_spring; i++)
        if (m->spring[i].law)
            return lw_error_set(e, LW_E_KIND, "spring '%s' has a law of its own, which has no form in MJCF", m->spring[i].name);
    for (int i = 0; m && i < m->n_rope; i++)
        if (m->rope[i].surface.stiffness > 0 || m->rope[i].surface.restitution > 0)
            return lw_error_set(e, LW_E_KIND, "rope '%s' rebounds or gives way, which has no form in MJCF", m->rope[i].name);
    for (int i = 0; m && i < m->n_joint_spring; i++) {
        const lw_joint_spring *p = &m->joint_spring[i];
        if (p->law || lw_joint_has_slot(k->joint[p->joint].kind) || !w->tree.in_tree[p->joint])
            return lw_error_set(e, LW_E_KIND, "joint spring '%s' %s, which has no form in MJCF", p->name,
                                p->law ? "has a law of its own" : "acts at a joint by which a loop is closed");
    }
    for (int i = 0; m && i < m->n_motor; i++)
        if (!w->tree.in_tree[m->motor[i].joint])
            return lw_error_set(e, LW_E_KIND, "motor '%s' acts at a joint by which a loop is closed, which has no form "
                                "in MJCF", m->motor[i].name);
    for (int i = 0; m && i < m->n_force; i++)
        if (lw_export_varies(m->force[i].fx) || lw_export_varies(m->force[i].fy) || lw_export_varies(m->force[i].torque))
            return lw_error_set(e, LW_E_KIND, "force '%s' is not constant, which has no form in MJCF", m->force[i].name);
    for (int j = 0; m && j < k->n_joint; j++) {
        const lw_joint_stop *stop = &m->stop[j];
        bool stops = stop->has_least || stop->has_greatest;
        const char *what = m->friction[j].coefficient > 0 ? "friction" : m->clearance[j].model != LW_CLEARANCE_NONE
            ? "clearance"
                         : stops && (stop->restitution > 0 || stop->stiffness > 0) ? "a stop that rebounds or gives way"
                         : stops && (!w->tree.in_tree[j] || lw_joint_has_slot(k->joint[j].kind))
                             ? "a stop where a loop is closed"
                         : NULL;
        if (what)
            return lw_error_set(e, LW_E_KIND, "joint '%s' has %s, which has no form in MJCF", k->joint[j].name, what);
    }
    return LW_OK;
}

static void put_tendons(writer *w)
{
    if (!w->m || w->m->n_spring + w->m->n_rope == 0)
        return;
    put(w, "\n  <tendon>");
    for (int i = 0; i < w->m->n_spring; i++) {
        const lw_spring *p = &w->m->spring[i];
        lw_mjcf_spring(w->out, p->name, p->free, p->stiffness, p->damping, 0.005*w->size);
    }
    for (int i = 0; i < w->m->n_rope; i++)
        lw_mjcf_rope(w->out, w->m->rope[i].name, w->m->rope[i].length, w->step, 0.005*w->size);
    put(w, "\n  </tendon>");
}

static void put_forces(writer *w)
{
    const lw_model *m = w->m;
    for (int i = 0; m && i < m->n_motor; i++)
        lw_mjcf_motor(w->out, m->motor[i].name, w->k->joint[m->motor[i].joint].name, m->motor[i].stall, m->motor[i].free_speed);
    for (int i = 0; m && i < m->n_force; i++) {
        const lw_force *p = &m->force[i];
        lw_mjcf_force(w->out, p->name, p->follows, (double[]){ lw_export_constant(p->fx), lw_export_constant(p->fy), 0, 0, 0,
                                                               lw_export_constant(p->torque) });
    }
}

/* Mass or inertia that moves along or about a joint when one link is held: the lesser of its two links. */
static double least_inertia(const writer *w, int joint)
{
    const lw_joint *p = &w->k->joint[joint];
    double least = INFINITY;
    for (int side = 0; side < 2; side++) {
        const lw_body *b = &w->m->body[p->link[side]];
        double mass = body_mass(w, b->mass), r = b->given ? lw_v2_norm(lw_v2_sub(b->centre, p->at)) : 0;
        if (p->link[side] != w->k->ground)
            least = fmin(least, lw_joint_turns(p->kind) ? body_inertia(w, mass, b->inertia) + mass*r*r : mass);
    }
    return least;
}

/* The longest step for a spring and a damper on an inertia: a fifth of 1/omega, half of the damper's time constant. */
static double step_for(double inertia, double stiffness, double damping)
{
    return fmin(stiffness > 0 ? 0.2*sqrt(inertia/stiffness) : INFINITY, damping > 0 ? 0.5*inertia/damping : INFINITY);
}

/* The step of time: what all springs, dampers and motors allow, a whole part of STEP.  A stop or a rope gives way for some steps. */
static double choose_step(const writer *w)
{
    double least = INFINITY, step = STEP;
    for (int i = 0; i < w->k->n_link; i++)
        if (w->weighed && i != w->k->ground && w->m->body[i].mass > 0)
            least = fmin(least, w->m->body[i].mass);
    if (!w->weighed)
        return step;
    for (int i = 0; i < w->m->n_spring; i++)
        step = fmin(step, step_for(least, w->m->spring[i].stiffness, w->m->spring[i].damping));
    for (int i = 0; i < w->m->n_joint_spring; i++) {
        const lw_joint_spring *p = &w->m->joint_spring[i];
        step = fmin(step, step_for(least_inertia(w, p->joint), p->stiffness, p->damping));
    }
    for (int i = 0; i < w->m->n_motor; i++) {
        const lw_motor *p = &w->m->motor[i];
        step = fmin(step, step_for(least_inertia(w, p->joint), 0, p->stall/p->free_speed));
    }
    for (int j = 0; j < w->k->n_joint; j++)
        if (w->m->stop[j].has_least || w->m->stop[j].has_greatest)
            step = fmin(step, STEP/5);
    if (w->m->n_rope > 0)
        step = fmin(step, STEP/10);
    return STEP/ceil(STEP/fmax(1e-6, step));
}

/* ---- the whole ------------------------------------------------------------------------------------ */

/* The limits of the linkage for an input without a range, where there are any; its drive stays within `part` of them: in a limit, a singular posture,
 * the motion could go on in several ways. */
static bool find_limits(writer *w, const lw_input *in, double part, double limit[2])
{
    double down, up;
    bool turns, ends = false;
    w->out->failed |= lw_export_way(w->k, w->m, (int)(in - w->k->input), &down, &up, &turns, &ends) != LW_OK;
    limit[0] = in->value - part*down, limit[1] = in->value + part*up;
    return ends;
}

/* Without the names of joints: two hyphens would end the comment. */
static void put_limits(writer *w)
{
    double limit[2];
    for (int i = 0; i < lw_assembly_free_inputs(w->k); i++) {
        if (is_driven(w, i) || !find_limits(w, &w->k->input[i], 1, limit))
            continue;
        put(w, "\n  <!-- The input runs freely and comes to limits of the linkage at ");
        lw_bytes_number(w->out, limit[0], 6);
        put(w, " and ");
        lw_bytes_number(w->out, limit[1], 6);
        put(w, ": singular postures, which MuJoCo may leave in another way than a rigid linkage. -->");
    }
}

static void put_drives(writer *w)
{
    const lw_assembly *k = w->k;
    double limit[2];
    put_limits(w);
    put(w, "\n  <actuator>");
    for (int i = 0; i < lw_assembly_free_inputs(k); i++) {
        const lw_input *in = &k->input[i];
        if (!is_driven(w, i))
            continue;
        put(w, "\n    <general biastype=\"affine\"");
        put_name(w, "name", k->joint[in->joint].name, " drive");
        put_name(w, "joint", k->joint[in->joint].name, "");
        lw_mjcf_drive(w->out, &w->key, in->value, drive_inertia(w, in->joint), w->step);
        bool range = in->first < in->last;
        if (range)
            limit[0] = in->first, limit[1] = in->last;
        if (range || find_limits(w, in, 0.99, limit)) {
            put(w, " ctrllimited=\"true\"");
            lw_mjcf_numbers(w->out, "ctrlrange", limit, 2);
        }
        put(w, "/>");
    }
    put_forces(w);
    put(w, "\n  </actuator>\n  <sensor>");
    for (int t = 0; t < k->n_tracer; t++)
        lw_mjcf_sensor(w->out, k->tracer[t].name);
    put(w, "\n  </sensor>");
    lw_mjcf_keyframe(w->out, &w->key, w->m ? w->m->n_motor + w->m->n_force : 0, w->twist != NULL);
}

static lw_status check_drives(const writer *w, lw_error *e)
{
    for (int i = 0; i < w->k->n_input; i++)
        if (!w->tree.in_tree[w->k->input[i].joint])
            return lw_error_set(e, LW_E_KIND, "input '%s' closes a loop of inputs, which has no form in MJCF",
                                w->k->joint[w->k->input[i].joint].name);
    return LW_OK;
}

/* Mass of all bodies: of the model, or of the steel rods that are drawn. */
static double mass_of(writer *w)
{
    lw_bytes scratch = { 0 }, *out = w->out;
    double mass = 0;
    for (int i = 0; w->weighed && i < w->k->n_link; i++)
        mass += i == w->k->ground ? 0 : w->m->body[i].mass;
    w->out = &scratch;
    if (!w->weighed)
        put_bodies(w);
    mass = w->weighed ? mass : w->rods;
    lw_bytes_free(&scratch);
    w->out = out;
    return mass;
}

static bool list_owners(writer *w)
{
    static const lw_model none;
    const lw_assembly *k = w->k;
    const lw_model *m = w->m ? w->m : &none;
    return LW_OWNERS(&w->joints, k->n_link, k->joint, k->n_joint, link, 2)
        && LW_OWNERS(&w->tracers, k->n_link, k->tracer, k->n_tracer, link, 1)
        && LW_OWNERS(&w->inputs, k->n_joint, k->input, k->n_input, joint, 1)
        && LW_OWNERS(&w->springs, k->n_link, m->spring, m->n_spring, link, 2)
        && LW_OWNERS(&w->ropes, k->n_link, m->rope, m->n_rope, link, 2)
        && LW_OWNERS(&w->forces, k->n_link, m->force, m->n_force, link, 1)
        && LW_OWNERS(&w->joint_springs, k->n_joint, m->joint_spring, m->n_joint_spring, joint, 1);
}

/* Not fewer than the rows of loops, stops and ropes. */
static int rows_of(const lw_assembly *k, const lw_model *m)
{
    int rows = 3*(k->n_joint - k->n_link + 1) + (m ? m->n_rope : 0);
    for (int j = 0; j < k->n_joint; j++)
        rows += (k->joint[j].kind == LW_JOINT_SLIDER || k->joint[j].kind == LW_JOINT_FIXED ? 3 : 0)
              + (m && (m->stop[j].has_least || m->stop[j].has_greatest));
    return rows;
}

lw_status lw_export_mjcf(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    writer w = { .k = linkage, .m = o ? o->model : NULL, .out = out, .size = lw_export_size(linkage) };
    lw_status s = lw_assembly_check(linkage, e);
    w.weighed = lw_export_weighed(linkage, w.m);
    if (s == LW_OK)
        s = lw_export_span(linkage, w.m, &w.tree, e);
    if (s == LW_OK)
        s = check_drives(&w, e);
    if (s == LW_OK)
        s = check_loads(&w, e);
    if (s == LW_OK)
        s = lw_export_start(w.m, &w.twist, e);
    if (s == LW_OK && !list_owners(&w))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        w.mass = mass_of(&w);
        w.step = choose_step(&w);
        lw_vec2 g = w.weighed ? w.m->gravity : lw_v2(0, 0);
        lw_mjcf_head(out, linkage->name[0] ? linkage->name : "linkage", lw_v3(g.x, g.y, 0), w.step,
                     w.size, rows_of(linkage, w.m), w.m && w.m->n_force > 0);
        put_bodies(&w);
        put(&w, "\n  </worldbody>");
        s = put_closures(&w, e);
    }
    if (s == LW_OK) {
        put_tendons(&w);
        put_drives(&w);
        put(&w, "\n</mujoco>\n");
    }
    lw_export_tree_free(&w.tree);
    lw_mjcf_key_free(&w.key);
    free(w.twist);
    lw_owners *const lists[] = { &w.joints, &w.tracers, &w.springs, &w.ropes, &w.forces, &w.inputs, &w.joint_springs };
    for (size_t i = 0; i < sizeof lists/sizeof *lists; i++)
        lw_owners_free(lists[i]);
    if (s != LW_OK) {
        lw_bytes_free(out);
        return s;
    }
    return lw_bytes_end(out, e);
}
