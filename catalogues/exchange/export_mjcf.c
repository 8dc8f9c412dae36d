/* catalogues/exchange/export_mjcf.c - write a linkage as a model of MuJoCo (XML reference of MuJoCo 2.2). */
#include "base/owners.h"
#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"
#include "catalogues/exchange/tree.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DIGITS 15

#define STEEL  7850.0                         /* [kg/m^3]                                                 */
#define STEP   5e-4                           /* of time, unless springs need a smaller one [s]           */
#define DRIVE  0.3                            /* angular frequency of a drive, times the step             */
#define RATIO  0.3                            /* of its damping to the critical one                       */

typedef struct writer {
    const lw_assembly *k;
    const lw_model   *m;                      /* NULL: no masses, no loads                                */
    lw_bytes         *out;
    double            size;
    bool              weighed;                /* the model has masses                                     */
    double            mass, rods, step;       /* of all bodies, of the rods drawn so far [kg]; of time [s] */
    lw_export_tree    tree;
    lw_owners         joints, tracers, springs, forces;          /* by links                              */
    lw_owners         inputs, joint_springs;                     /* by joints                             */
    lw_owners         children;                                  /* links by their parents                */
    int              *next;                   /* (n_link) scratch                                         */
} writer;

/* ---- text --------------------------------------------------------------------------------------- */

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }

static void put_number(writer *w, double v) { lw_bytes_number(w->out, v, DIGITS); }

static void put_vec(writer *w, lw_vec2 v)
{
    put_number(w, v.x);
    put(w, " ");
    put_number(w, v.y);
    put(w, " 0");
}

static void put_indent(writer *w, int depth)
{
    put(w, "\n");
    for (int i = 0; i < depth && i < LW_MJCF_DEEPEST; i++)
        put(w, "  ");
}

/* Write an attribute that holds a name followed by `more`. */
static void put_name(writer *w, const char *attribute, const char *name, const char *more)
{
    put(w, " ");
    put(w, attribute);
    put(w, "=\"");
    lw_bytes_xml(w->out, name);
    put(w, more);
    put(w, "\"");
}

/* As put_name for a link; the name "world" is reserved in MuJoCo. */
static void put_link(writer *w, const char *attribute, int link, const char *more)
{
    const char *name = w->k->link_name[link];
    put_name(w, attribute, name, strcmp(name, "world") == 0 && !*more ? " link" : more);
}

/* ---- the tree ----------------------------------------------------------------------------------- */

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

static void put_attribute(writer *w, const char *attribute, double v)
{
    put(w, " ");
    put(w, attribute);
    put(w, "=\"");
    put_number(w, v);
    put(w, "\"");
}

/* Write what belongs to a joint's coordinate: its value in the posture, springs and dampers, stops, and for a
 * driven joint the inertia of its drive. A drive's inertia is that of all bodies at the distance of the
 * linkage's size, so that its frequency changes by a factor of sqrt(2) at most over the motion; the motion
 * itself does not depend on it. */
static void put_reference(writer *w, int joint)
{
    const lw_assembly *k = w->k;
    const int *input = w->inputs.entry + w->inputs.start[joint], *no_input = w->inputs.entry + w->inputs.start[joint + 1];
    double at = input < no_input ? k->input[*input].value : 0, stiffness = 0, damping = 0, pull = 0;
    if (input < no_input)
        put_attribute(w, "ref", at);
    for (int i = w->joint_springs.start[joint]; i < w->joint_springs.start[joint + 1]; i++) {
        const lw_joint_spring *p = &w->m->joint_spring[w->joint_springs.entry[i]];
        stiffness += p->stiffness;
        damping += p->damping;
        pull += p->stiffness*p->free;
    }
    if (stiffness > 0) {
        put_attribute(w, "stiffness", stiffness);
        put_attribute(w, "springref", at + pull/stiffness);
    }
    if (damping > 0)
        put_attribute(w, "damping", damping);
    const lw_joint_stop *stop = w->m ? &w->m->stop[joint] : NULL;
    if (stop && (stop->has_least || stop->has_greatest)) {
        double a = stop->has_least ? stop->least : -1e6, b = stop->has_greatest ? stop->greatest : 1e6;
        put(w, " limited=\"true\" range=\"");
        put_number(w, at + a);
        put(w, " ");
        put_number(w, at + b);
        put(w, "\"");
    }
    for (; input < no_input; input++)
        if (k->input[*input].ratio == 0 && is_driven(w, *input))
            put_attribute(w, "armature", drive_inertia(w, joint));
}

static void put_slide(writer *w, int depth, int joint, double sign, const char *more)
{
    put_indent(w, depth);
    put(w, "<joint type=\"slide\"");
    put_name(w, "name", w->k->joint[joint].name, more);
    put(w, " axis=\"");
    put_vec(w, lw_v2_scale(w->k->joint[joint].along, sign));
    put(w, "\"");
    put_reference(w, joint);
    put(w, "/>");
}

/* Write the tree joint of a body; the body's frame begins at the joint's point. A slot slides on link[0] and turns at
 * the pin: seen from the pin's link, it turns first. */
static void put_joint(writer *w, int depth, int child)
{
    const lw_assembly *k = w->k;
    int j = w->tree.joint[child];
    const lw_joint *p = &k->joint[j];
    double sign = lw_export_count_sign(k, j, child);
    bool slot = lw_joint_has_slot(p->kind), carries = slot && p->link[0] == child;
    if (lw_joint_translates(p->kind) || (slot && !carries))
        put_slide(w, depth, j, sign, slot ? " slide" : "");
    if (lw_joint_turns(p->kind) || slot) {
        put_indent(w, depth);
        put(w, "<joint type=\"hinge\"");
        put_name(w, "name", p->name, slot ? " turn" : "");
        put(w, sign < 0 ? " axis=\"0 0 -1\"" : " axis=\"0 0 1\"");
        put_reference(w, j);
        put(w, "/>");
    }
    if (carries)
        put_slide(w, depth, j, -1, " slide");
}

static void put_rod(writer *w, int depth, lw_vec2 a, lw_vec2 b)
{
    bool ball = lw_v2_norm(lw_v2_sub(b, a)) < 1e-9*w->size;
    put_indent(w, depth);
    put(w, ball ? "<geom type=\"sphere\" pos=\"" : "<geom type=\"capsule\" fromto=\"");
    put_vec(w, a);
    if (!ball) {
        put(w, " ");
        put_vec(w, b);
    }
    put(w, "\" size=\"");
    double r = (ball ? 0.02 : 0.01)*w->size;
    put_number(w, r);
    put(w, w->weighed ? "\" density=\"0\"/>" : "\"/>");
    w->rods += STEEL*(4*LW_PI/3*r*r*r + (ball ? 0 : LW_PI*r*r*lw_v2_norm(lw_v2_sub(b, a))));
}

/* MuJoCo needs some mass and inertia, so bodies without them get a millionth of what all bodies have. */
static double body_mass(const writer *w, double mass) { return fmax(mass, 1e-6*w->mass); }

static double body_inertia(const writer *w, double mass, double inertia) { return fmax(inertia, 1e-6*mass*w->size*w->size); }

/* Write mass and inertia of a body, by whose frame the centre is given. */
static void put_inertia(writer *w, int depth, double mass, lw_vec2 centre, double inertia)
{
    put_indent(w, depth);
    put(w, "<inertial pos=\"");
    put_vec(w, centre);
    put(w, "\"");
    mass = body_mass(w, mass);
    put_attribute(w, "mass", mass);
    inertia = body_inertia(w, mass, inertia);
    put(w, " diaginertia=\"");
    for (int i = 0; i < 3; i++) {
        put(w, i ? " " : "");
        put_number(w, inertia);
    }
    put(w, "\"/>");
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
        lw_vec2 to = lw_v2_sub(p->at, w->tree.origin[link]);
        if (lw_v2_norm(to) < 1e-9*w->size)
            continue;
        put_rod(w, depth, lw_v2(0, 0), to);
        any = true;
    }
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
        lw_vec2 to = lw_v2_sub(k->tracer[w->tracers.entry[at]].at, w->tree.origin[link]);
        if (lw_v2_norm(to) < 1e-9*w->size)
            continue;
        put_rod(w, depth, lw_v2(0, 0), to);
        any = true;
    }
    if (!any)
        put_rod(w, depth, lw_v2(0, 0), lw_v2(0, 0));
}

static void put_sites(writer *w, int depth, int link)
{
    const lw_assembly *k = w->k;
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
        const lw_tracer *tracer = &k->tracer[w->tracers.entry[at]];
        put_indent(w, depth);
        put(w, "<site");
        put_name(w, "name", tracer->name, "");
        put(w, " pos=\"");
        put_vec(w, lw_v2_sub(tracer->at, w->tree.origin[link]));
        put(w, "\" euler=\"0 0 ");
        put_number(w, tracer->angle);
        put(w, "\" size=\"");
        put_number(w, 0.02*w->size);
        put(w, "\"/>");
    }
}

static void put_load_site(writer *w, int depth, const char *name, const char *more, int link, lw_vec2 at)
{
    put_indent(w, depth);
    put(w, "<site");
    put_name(w, "name", name, more);
    put(w, " pos=\"");
    put_vec(w, lw_v2_sub(at, w->tree.origin[link]));
    put(w, "\"");
    put_attribute(w, "size", 0.01*w->size);
    put(w, "/>");
}

/* Write the points of springs and forces on a link. */
static void put_load_sites(writer *w, int depth, int link)
{
    for (int at = w->springs.start[link]; at < w->springs.start[link + 1]; at++) {
        const lw_spring *p = &w->m->spring[w->springs.entry[at]/2];
        int end = w->springs.entry[at]%2;
        put_load_site(w, depth, p->name, end ? " end" : " start", link, p->at[end]);
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
        put_indent(w, depth);
        put(w, "<body");
        put_name(w, "name", p->name, " runner");
        put(w, " pos=\"");
        put_vec(w, lw_v2_sub(p->at, w->tree.origin[link]));
        put(w, "\">");
        put_slide(w, depth + 1, j, 1, "");
        if (w->weighed)
            put_inertia(w, depth + 1, 0, lw_v2(0, 0), 0);
        put_rod(w, depth + 1, lw_v2(0, 0), lw_v2(0, 0));
        put_indent(w, depth);
        put(w, "</body>");
    }
}

/* Begin the body of a link: everything but the bodies inside it. */
static void put_body(writer *w, int depth, int link)
{
    const lw_assembly *k = w->k;
    bool ground = link == k->ground;
    if (!ground) {
        put_indent(w, depth);
        put(w, "<body");
        put_link(w, "name", link, "");
        put(w, " pos=\"");
        put_vec(w, lw_v2_sub(w->tree.origin[link], w->tree.origin[w->tree.parent[link]]));
        put(w, "\">");
        put_joint(w, depth + 1, link);
        if (w->weighed) {
            const lw_body *b = &w->m->body[link];
            put_inertia(w, depth + 1, b->mass, b->given ? lw_v2_sub(b->centre, w->tree.origin[link]) : lw_v2(0, 0),
                        b->inertia);
        }
        put_shape(w, depth + 1, link);
    }
    put_sites(w, depth + 1, link);
    put_load_sites(w, depth + 1, link);
    put_runners(w, depth + 1, link);
}

/* Write all links, each inside its parent.  next: (n_link) scratch, the place of the next child. */
static void put_bodies(writer *w, int *next)
{
    const lw_assembly *k = w->k;
    int depth = 1, link = k->ground;
    memcpy(next, w->children.start, (size_t)k->n_link*sizeof *next);
    put_body(w, depth, link);
    for (;;) {
        if (next[link] < w->children.start[link + 1]) {
            link = w->children.entry[next[link]++];
            put_body(w, ++depth, link);
        } else if (link == k->ground)
            return;
        else {
            put_indent(w, depth--);
            put(w, "</body>");
            link = w->tree.parent[link];
        }
    }
}

/* ---- what closes the loops ----------------------------------------------------------------------- */

/* body1 must be a body: the ground is the world, so it is second and is left out. */
static void put_pair(writer *w, const char *kind, int joint, bool runner, bool anchor)
{
    const lw_assembly *k = w->k;
    const lw_joint *p = &k->joint[joint];
    int first = p->link[0] == k->ground || runner ? 1 : 0, a = p->link[first], b = p->link[1 - first];
    if (a == k->ground) {              /* the runner on a line of a moving link, connected to the ground */
        put_indent(w, 2);
        put(w, kind);
        put_name(w, "body1", p->name, " runner");
    } else {
        put_indent(w, 2);
        put(w, kind);
        put_link(w, "body1", a, "");
        if (runner)
            put_name(w, "body2", p->name, " runner");
        else if (b != k->ground)
            put_link(w, "body2", b, "");
    }
    if (anchor) {
        put(w, " anchor=\"");
        put_vec(w, a == k->ground ? lw_v2(0, 0) : lw_v2_sub(p->at, w->tree.origin[a]));
        put(w, "\"");
    }
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
    put_indent(w, 2);
    put(w, "<joint");
    put_name(w, "joint1", k->joint[joint[1]].name, "");
    put_name(w, "joint2", k->joint[joint[0]].name, "");
    put(w, " polycoef=\"0 ");
    put_number(w, k->joint[gear].ratio*sign[0]*sign[1]);
    put(w, " 0 0 0\"/>");
    return LW_OK;
}

static void put_tie(writer *w, int input)
{
    put_indent(w, 2);
    put(w, "<joint");
    put_name(w, "joint1", w->k->joint[w->k->input[input].joint].name, "");
    put_name(w, "joint2", w->k->joint[w->k->input[0].joint].name, "");
    put(w, " polycoef=\"0 ");
    put_number(w, w->k->input[input].ratio);
    put(w, " 0 0 0\"/>");
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
        put_tie(w, i);
    put(w, "\n  </equality>");
    return s;
}

/* ---- loads ---------------------------------------------------------------------------------------- */

static double constant(const lw_expression *x) { return x ? lw_expression_value(x, NULL) : 0; }

static bool varies(const lw_expression *x)
{
    const int *which;
    return x && lw_expression_variables(x, &which) > 0;
}

/* Refuse what has no form in MJCF, by name. */
static lw_status check_loads(const writer *w, lw_error *e)
{
    const lw_model *m = w->m;
    const lw_assembly *k = w->k;
    for (int i = 0; m && i < m->n_spring; i++)
        if (m->spring[i].law)
            return lw_error_set(e, LW_E_KIND, "spring '%s' has a law of its own, which has no form in MJCF",
                                m->spring[i].name);
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
        if (varies(m->force[i].fx) || varies(m->force[i].fy) || varies(m->force[i].torque))
            return lw_error_set(e, LW_E_KIND, "force '%s' is not constant, which has no form in MJCF",
                                m->force[i].name);
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

void lw_mjcf_spring(lw_bytes *out, const char *name, double free, double stiffness, double damping, double width)
{
    writer w = { .out = out };
    put(&w, "\n    <spatial");
    put_name(&w, "name", name, "");
    put_attribute(&w, "springlength", free);
    put_attribute(&w, "stiffness", stiffness);
    put_attribute(&w, "damping", damping);
    put_attribute(&w, "width", width);
    put(&w, ">");
    for (int end = 0; end < 2; end++) {
        put_indent(&w, 3);
        put(&w, "<site");
        put_name(&w, "site", name, end ? " end" : " start");
        put(&w, "/>");
    }
    put(&w, "\n    </spatial>");
}

static void put_springs(writer *w)
{
    if (!w->m || w->m->n_spring == 0)
        return;
    put(w, "\n  <tendon>");
    for (int i = 0; i < w->m->n_spring; i++) {
        const lw_spring *p = &w->m->spring[i];
        lw_mjcf_spring(w->out, p->name, p->free, p->stiffness, p->damping, 0.005*w->size);
    }
    put(w, "\n  </tendon>");
}

/* Forces and motors need no control: they are the bias of an actuator. A force that keeps its direction acts along the
 * axes of a site of the world. */
static void put_forces(writer *w)
{
    const lw_model *m = w->m;
    for (int i = 0; m && i < m->n_motor; i++) {
        const lw_motor *p = &m->motor[i];
        put(w, "\n    <general gainprm=\"0\" biastype=\"affine\"");
        put_name(w, "name", p->name, " motor");
        put_name(w, "joint", w->k->joint[p->joint].name, "");
        put(w, " biasprm=\"");
        put_number(w, p->stall);
        put(w, " 0 ");
        put_number(w, -p->stall/p->free_speed);
        put(w, "\"/>");
    }
    for (int i = 0; m && i < m->n_force; i++) {
        const lw_force *p = &m->force[i];
        put(w, "\n    <general gainprm=\"0\" biastype=\"affine\" biasprm=\"1 0 0\"");
        put_name(w, "name", p->name, " force");
        put_name(w, "site", p->name, " force");
        if (!p->follows)
            put(w, " refsite=\"axes of the world\"");
        put(w, " gear=\"");
        put_number(w, constant(p->fx));
        put(w, " ");
        put_number(w, constant(p->fy));
        put(w, " 0 0 0 ");
        put_number(w, constant(p->torque));
        put(w, "\"/>");
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

/* The step of time: what all springs, dampers and motors allow, a whole part of STEP.  A stop gives way for some steps. */
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
    return STEP/ceil(STEP/fmax(1e-6, step));
}

/* ---- the whole ------------------------------------------------------------------------------------ */

/* A drive is a spring of its own inertia's frequency DRIVE/step, with damping; its control is the joint's coordinate.
 * */
static void put_drives(writer *w)
{
    const lw_assembly *k = w->k;
    put(w, "\n  <actuator>");
    for (int i = 0; i < lw_assembly_free_inputs(k); i++) {
        const lw_input *in = &k->input[i];
        double omega = DRIVE/w->step, kp = drive_inertia(w, in->joint)*omega*omega, kv = 2*RATIO*kp/omega;
        if (!is_driven(w, i))
            continue;
        put(w, "\n    <general biastype=\"affine\"");
        put_name(w, "name", k->joint[in->joint].name, " drive");
        put_name(w, "joint", k->joint[in->joint].name, "");
        put_attribute(w, "gainprm", kp);
        put(w, " biasprm=\"0 ");
        put_number(w, -kp);
        put(w, " ");
        put_number(w, -kv);
        put(w, "\"");
        if (in->first < in->last) {
            put(w, " ctrllimited=\"true\" ctrlrange=\"");
            put_number(w, in->first);
            put(w, " ");
            put_number(w, in->last);
            put(w, "\"");
        }
        put(w, "/>");
    }
    put_forces(w);
    put(w, "\n  </actuator>\n  <sensor>");
    for (int t = 0; t < k->n_tracer; t++) {
        put(w, "\n    <framepos objtype=\"site\"");
        put_name(w, "objname", k->tracer[t].name, "");
        put(w, "/>");
    }
    put(w, "\n  </sensor>");
    int n = 0;
    for (int i = 0; i < lw_assembly_free_inputs(k); i++) {
        if (!is_driven(w, i))
            continue;
        put(w, n++ > 0 ? " " : "\n  <keyframe>\n    <key name=\"posture\" ctrl=\"");
        put_number(w, k->input[i].value);
    }
    for (int i = 0; n > 0 && w->m && i < w->m->n_motor + w->m->n_force; i++)
        put(w, " 0");
    put(w, n > 0 ? "\"/>\n  </keyframe>" : "");
}

static void put_head(writer *w)
{
    lw_vec2 g = w->weighed ? w->m->gravity : lw_v2(0, 0);
    put(w, "<mujoco");
    put_name(w, "model", w->k->name[0] ? w->k->name : "linkage", "");
    put(w, ">\n  <!-- The controls of the drives are coordinates of their joints; those of the drawn posture are in "
        "the "
           "keyframe. -->"
           "\n  <compiler angle=\"radian\" boundmass=\"1e-12\" boundinertia=\"1e-18\"/>"
           "\n  <option integrator=\"RK4\" gravity=\"");
    put_vec(w, g);
    put(w, "\"");
    put_attribute(w, "timestep", w->step);
    put(w, "/>\n  <statistic");
    put_attribute(w, "extent", w->size);
    put(w, "/>\n  <default>\n    <joint limited=\"false\" solreflimit=\"");
    put_number(w, 2*w->step);
    put(w, " ");
    put_number(w, LW_MJCF_STOP);
    put(w, "\" solimplimit=\"0.9999 0.9999 0.001\"/>"
           "\n    <geom contype=\"0\" conaffinity=\"0\" density=\"7850\" rgba=\"0.35 0.55 0.75 1\"/>"
           "\n    <site rgba=\"0.85 0.35 0 1\"/>"
           "\n    <equality solref=\"");
    put_number(w, 2*w->step);
    put(w, " 1\" solimp=\"0.9999 0.9999 0.001\"/>"
           "\n  </default>\n  <worldbody>");
    if (w->m && w->m->n_force > 0)
        put(w, "\n    <site name=\"axes of the world\" pos=\"0 0 0\" rgba=\"0 0 0 0\"/>");
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
        put_bodies(w, w->next);
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
    w->next = calloc((size_t)k->n_link + 1, sizeof *w->next);
    return w->next && LW_OWNERS(&w->joints, k->n_link, k->joint, k->n_joint, link, 2)
        && LW_OWNERS(&w->tracers, k->n_link, k->tracer, k->n_tracer, link, 1)
        && LW_OWNERS(&w->inputs, k->n_joint, k->input, k->n_input, joint, 1)
        && LW_OWNERS(&w->springs, k->n_link, m->spring, m->n_spring, link, 2)
        && LW_OWNERS(&w->forces, k->n_link, m->force, m->n_force, link, 1)
        && LW_OWNERS(&w->joint_springs, k->n_joint, m->joint_spring, m->n_joint_spring, joint, 1)
        && lw_owners_make(&w->children, k->n_link, w->tree.parent, sizeof *w->tree.parent, 0, k->n_link, 1);
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
    if (s == LW_OK && !list_owners(&w))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        w.mass = mass_of(&w);
        w.step = choose_step(&w);
        put_head(&w);
        put_bodies(&w, w.next);
        put(&w, "\n  </worldbody>");
        s = put_closures(&w, e);
    }
    if (s == LW_OK) {
        put_springs(&w);
        put_drives(&w);
        put(&w, "\n</mujoco>\n");
    }
    lw_export_tree_free(&w.tree);
    lw_owners *const lists[] = { &w.joints, &w.tracers, &w.springs, &w.forces, &w.inputs, &w.joint_springs, &w.children };
    for (size_t i = 0; i < sizeof lists/sizeof *lists; i++)
        lw_owners_free(lists[i]);
    free(w.next);
    if (s != LW_OK) {
        lw_bytes_free(out);
        return s;
    }
    return lw_bytes_end(out, e);
}
