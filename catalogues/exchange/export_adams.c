/* catalogues/exchange/export_adams.c - write a linkage as a dataset of ADAMS/Solver, and the commands that run it.
 *
 * Markers are numbered as in PLASMA, 100 part + count; the part of link i is i + 1. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/owners.h"
#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"
#include "catalogues/exchange/start.h"
#include "catalogues/exchange/tree.h"
#include "catalogues/draw/scene.h"

#define DIGITS 15

typedef struct writer {
    const lw_assembly *k;
    const lw_model   *m;                       /* NULL: no masses, no loads                              */
    bool              weighed;                 /* the model has masses                                   */
    lw_bytes         *out;
    lw_export_twist  *twist;                   /* (n_link) velocities at the start; NULL: all are 0      */
    int              *n_marker;                /* (n_link)                                               */
    int             (*at)[2];                  /* (n_joint) markers of a joint on its two links          */
    int              *tracer;                  /* (n_tracer)                                             */
    lw_owners         joints, tracers;         /* of each link                                           */
    int               stride;                  /* between the first markers of two links; 0: numbers without gaps */
    int               last;                    /* marker number                                          */
    int               origin;                  /* marker of the ground's origin                          */
} writer;

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }

static void put_number(writer *w, double v) { lw_bytes_number(w->out, v, DIGITS); }

/* "NAME/07" */
static void put_id(writer *w, const char *what, int id, int digits)
{
    char text[48];
    snprintf(text, sizeof text, "%s%0*d", what, digits, id);
    put(w, text);
}

/* Write printable ASCII characters except the quote. */
static void put_plain(writer *w, const char *text)
{
    for (; *text; text++) {
        char c[2] = { *text > 31 && *text < 127 && *text != '\'' ? *text : '_', 0 };
        put(w, c);
    }
}

static void put_name(writer *w, const char *name, const char *more)
{
    put(w, "!                            adams_view_name='");
    put_plain(w, name);
    put(w, more);
    put(w, "'\n");
}

/* Is it a JOINT or JPRIM?  A gear is a COUPLER; a part without a joint is free. */
static bool has_statement(lw_joint_kind kind) { return !lw_joint_has_ratio(kind) && lw_joint_freedoms(kind) < 3; }

/* ---- parts and markers ---------------------------------------------------------------------------- */

/* Number of the marker that is written next on a link. */
static int next_marker(const writer *w, int link) { return w->stride ? w->stride*(link + 1) + w->n_marker[link] + 1 : w->last + 1; }

/* Write a marker with its z axis along a direction of the plane: turn by the direction's angle + 90 degrees about z,
 * then by 90 about x. */
static int put_marker(writer *w, int link, lw_vec2 at, const lw_vec2 *z, double turn, const char *name)
{
    int id = next_marker(w, link);
    w->n_marker[link]++;
    w->last = id;
    put_name(w, name, "");
    put_id(w, "MARKER/", id, 4);
    put_id(w, ", PART = ", link + 1, 2);
    put(w, ", QP = ");
    put_number(w, at.x);
    put(w, ", ");
    put_number(w, at.y);
    put(w, ", 0");
    if (z || turn != 0) {
        put(w, ", REULER = ");
        put_number(w, z ? atan2(z->y, z->x) + LW_PI/2 : turn);
        put(w, z ? ", 90D, 0" : ", 0, 0");
    }
    put(w, "\n");
    return id;
}

/* Write the marker of joint j on a link: z perpendicular to the plane, along the slide, or perpendicular to the slot.
 */
static void put_joint_marker(writer *w, int j, int side)
{
    const lw_joint *p = &w->k->joint[j];
    char name[LW_NAME_SIZE + 8];
    lw_vec2 across = lw_v2_perp(p->along);
    const lw_vec2 *z = lw_joint_translates(p->kind) ? &p->along : lw_joint_has_slot(p->kind) ? &across : NULL;
    snprintf(name, sizeof name, "%s %c", p->name, side ? 'j' : 'i');
    w->at[j][side] = put_marker(w, p->link[side], p->at, z, 0, name);
}

static void put_parts(writer *w)
{
    const lw_assembly *k = w->k;
    for (int link = 0; link < k->n_link; link++) {
        put(w, "!\n");
        put_name(w, k->link_name[link], "");
        put_id(w, "PART/", link + 1, 2);
        put(w, link == k->ground ? ", GROUND" : "");
        const lw_body *body = w->weighed && link != k->ground ? &w->m->body[link] : NULL;
        if (body && body->mass > 0) {                  /* its marker is the first one of the part */
            put(w, ", MASS = ");
            put_number(w, body->mass);
            put_id(w, ", CM = ", next_marker(w, link), 4);
            for (int i = 0; i < 3; i++) {
                put(w, i ? ", " : ", IP = ");
                put_number(w, body->inertia);
            }
            if (w->twist) {                            /* of the centre, along the axes of the ground */
                lw_export_twist v = lw_export_relative(w->twist, link, k->ground, lw_v3(body->centre.x, body->centre.y, 0));
                put(w, "\n, VX = ");
                put_number(w, v.velocity.x);
                put(w, ", VY = ");
                put_number(w, v.velocity.y);
                put(w, ", WZ = ");
                put_number(w, v.omega.z);
            }
        }
        put(w, "\n");
        if (body && body->mass > 0)
            put_marker(w, link, body->centre, NULL, 0, "centre of mass");
        for (int at = w->joints.start[link]; at < w->joints.start[link + 1]; at++)
            if (has_statement(k->joint[w->joints.entry[at]/2].kind))
                put_joint_marker(w, w->joints.entry[at]/2, w->joints.entry[at]%2);
        for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
            const lw_tracer *t = &k->tracer[w->tracers.entry[at]];
            w->tracer[w->tracers.entry[at]] = put_marker(w, link, t->at, NULL, t->angle, t->name);
        }
        if (link == k->ground)
            w->origin = put_marker(w, link, lw_v2(0, 0), NULL, 0, "origin");
    }
}

/* ---- joints ---------------------------------------------------------------------------------------- */

static const char *joint_statement(lw_joint_kind kind)
{
    switch (kind) {
    case LW_JOINT_REVOLUTE: return ", REVOLUTE";
    case LW_JOINT_SLIDER:   return ", TRANSLATIONAL";
    case LW_JOINT_SLOT:     return ", INPLANE";
    case LW_JOINT_FIXED:    return ", FIXED";
    case LW_JOINT_GEAR:
    case LW_JOINT_FREE:     break;
    }
    return "";
}

/* The movement of marker I relative to J is the movement of the joint (lw_input). */
static void put_joint(writer *w, int j)
{
    const lw_joint *p = &w->k->joint[j];
    bool turned = lw_joint_turns(p->kind) && p->link[1] == w->k->ground;
    put_name(w, p->name, "");
    put_id(w, lw_joint_has_slot(p->kind) ? "JPRIM/" : "JOINT/", j + 1, 2);
    put(w, joint_statement(p->kind));
    put_id(w, ", I = ", w->at[j][turned ? 0 : 1], 4);
    put_id(w, ", J = ", w->at[j][turned ? 1 : 0], 4);
    put(w, "\n");
}

static lw_status put_coupler(writer *w, int gear, lw_error *e)
{
    int joint[2];
    double sign[2];
    lw_status s = lw_export_gear(w->k, gear, joint, sign, e);
    if (s != LW_OK)
        return s;
    put_name(w, w->k->joint[gear].name, "");
    put_id(w, "COUPLER/", gear + 1, 2);
    put_id(w, ", JOINTS = ", joint[0] + 1, 2);
    put_id(w, ", ", joint[1] + 1, 2);
    put(w, ", SCALES = ");
    put_number(w, w->k->joint[gear].ratio*sign[0]);
    put(w, ", ");
    put_number(w, -sign[1]);
    put(w, "\n");
    return LW_OK;
}

static lw_status put_joints(writer *w, lw_error *e)
{
    lw_status s = LW_OK;
    put(w, "!\n");
    for (int j = 0; s == LW_OK && j < w->k->n_joint; j++)
        if (lw_joint_has_ratio(w->k->joint[j].kind))
            s = put_coupler(w, j, e);
        else if (has_statement(w->k->joint[j].kind))
            put_joint(w, j);
    return s;
}

/* ---- loads ----------------------------------------------------------------------------------------- */

/* Refuse what is not written, by name. */
static lw_status check_loads(const writer *w, lw_error *e)
{
    const lw_model *m = w->m;
    for (int i = 0; m && i < m->n_spring; i++)
        if (m->spring[i].law)
            return lw_error_set(e, LW_E_KIND, "spring '%s' has a law of its own, which is not written to ADAMS", m->spring[i].name);
    for (int i = 0; m && i < m->n_joint_spring; i++)
        if (m->joint_spring[i].law || !lw_joint_turns(w->k->joint[m->joint_spring[i].joint].kind))
            return lw_error_set(e, LW_E_KIND, "joint spring '%s' %s, which is not written to ADAMS",
                                m->joint_spring[i].name,
                                m->joint_spring[i].law ? "has a law of its own" : "acts along a slider");
    for (int i = 0; m && i < m->n_motor; i++)
        if (!lw_joint_turns(w->k->joint[m->motor[i].joint].kind))
            return lw_error_set(e, LW_E_KIND, "motor '%s' moves a slider, which is not written to ADAMS", m->motor[i].name);
    for (int i = 0; m && i < m->n_force; i++)
        if (lw_export_varies(m->force[i].fx) || lw_export_varies(m->force[i].fy) || lw_export_varies(m->force[i].torque))
            return lw_error_set(e, LW_E_KIND, "force '%s' is not constant, which is not written to ADAMS", m->force[i].name);
    for (int j = 0; m && j < w->k->n_joint; j++) {
        const char *what = m->friction[j].coefficient > 0 ? "friction" : m->clearance[j].model != LW_CLEARANCE_NONE
            ? "clearance"
                         : m->stop[j].has_least || m->stop[j].has_greatest ? "a stop" : NULL;
        if (what)
            return lw_error_set(e, LW_E_KIND, "joint '%s' has %s, which is not written to ADAMS", w->k->joint[j].name, what);
    }
    return LW_OK;
}

/* "KEY = number" */
static void put_key(writer *w, const char *key, double v)
{
    put(w, key);
    put_number(w, v);
}

/* The markers of a joint whose relative turn counts as the joint does. */
static void put_turn_markers(writer *w, int j)
{
    bool turned = w->k->joint[j].link[1] == w->k->ground;
    put_id(w, ", I = ", w->at[j][turned ? 0 : 1], 4);
    put_id(w, ", J = ", w->at[j][turned ? 1 : 0], 4);
}

/* A force or torque on a marker, along z of another one, without a reaction. */
static void put_action(writer *w, int *id, int at, int axis, const char *kind, double v)
{
    put_id(w, "SFORCE/", ++*id, 2);
    put_id(w, ", I = ", at, 4);
    put_id(w, ", J = ", axis, 4);
    put(w, kind);
    put_key(w, ", ACTIONONLY\n, FUNCTION = ", v);
    put(w, "\n");
}

static void put_loads(writer *w)
{
    const lw_model *m = w->m;
    int spring = 0, force = 0;
    if (!m || !(w->weighed || m->n_spring + m->n_joint_spring + m->n_motor + m->n_force > 0))
        return;
    put(w, "!\n");
    if (w->weighed) {
        put_key(w, "ACCGRAV/IGRAV = ", m->gravity.x);
        put_key(w, ", JGRAV = ", m->gravity.y);
        put(w, ", KGRAV = 0\n");
    }
    for (int i = 0; i < m->n_spring; i++) {
        const lw_spring *p = &m->spring[i];
        int at[2];
        for (int end = 0; end < 2; end++)
            at[end] = put_marker(w, p->link[end], p->at[end], NULL, 0, p->name);
        put_name(w, p->name, "");
        put_id(w, "SPRINGDAMPER/", ++spring, 2);
        put_id(w, ", I = ", at[0], 4);
        put_id(w, ", J = ", at[1], 4);
        put_key(w, ", TRANSLATION, K = ", p->stiffness);
        put_key(w, ", C = ", p->damping);
        put_key(w, ", LENGTH = ", p->free);
        put(w, "\n");
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_joint_spring *p = &m->joint_spring[i];
        put_name(w, p->name, "");
        put_id(w, "SPRINGDAMPER/", ++spring, 2);
        put_turn_markers(w, p->joint);
        put_key(w, ", ROTATION, KT = ", p->stiffness);
        put_key(w, ", CT = ", p->damping);
        put_key(w, ", ANGLE = ", p->free);
        put(w, "\n");
    }
    for (int i = 0; i < m->n_motor; i++) {
        const lw_motor *p = &m->motor[i];
        char speed[48];
        bool turned = w->k->joint[p->joint].link[1] == w->k->ground;
        const int *at = w->at[p->joint];
        put_name(w, p->name, " motor");
        put_id(w, "SFORCE/", ++force, 2);
        put_turn_markers(w, p->joint);
        put_key(w, ", ROTATION\n, FUNCTION = ", p->stall);
        put_key(w, "*(1 - ", 1/p->free_speed);
        snprintf(speed, sizeof speed, "*WZ(%04d, %04d))\n", at[turned ? 0 : 1], at[turned ? 1 : 0]);
        put(w, speed);
    }
    for (int i = 0; i < m->n_force; i++) {
        const lw_force *p = &m->force[i];
        double fx = lw_export_constant(p->fx), fy = lw_export_constant(p->fy);
        double torque = lw_export_constant(p->torque), size = hypot(fx, fy);
        int at = put_marker(w, p->link, p->at, NULL, 0, p->name);
        lw_vec2 z = size > 0 ? lw_v2(fx/size, fy/size) : lw_v2(1, 0);
        put_name(w, p->name, " force");
        if (size > 0)
            put_action(w, &force, at, put_marker(w, p->follows ? p->link : w->k->ground, p->at, &z, 0, p->name), ", TRANSLATION", size);
        if (torque != 0)
            put_action(w, &force, at, w->origin, ", ROTATION", torque);
    }
}

/* ---- motion ---------------------------------------------------------------------------------------- */

lw_status lw_export_way(const lw_assembly *linkage, const lw_model *m, int input, double *down, double *up, bool *turns, bool *ends)
{
    const lw_input *in = &linkage->input[input];
    bool slider = lw_joint_slides(linkage->joint[in->joint].kind);
    lw_scene scene;
    *turns = *ends = false;
    if (in->first < in->last) {
        *down = in->value - in->first;
        *up = in->last - in->value;
        return LW_OK;
    }
    *down = *up = slider ? 0.1*lw_export_size(linkage) : 0.1;
    const lw_scene_options o = { .n_frame = 181, .n_curve_point = 8 };
    if (linkage->n_input > 1 && linkage->input[1].ratio == 0)          /* several move by themselves */
        return LW_OK;
    lw_status s = lw_scene_make_any(linkage, m, NULL, &o, &scene, NULL);
    if (s != LW_OK)
        return s == LW_E_MEMORY ? s : LW_OK;
    double here = scene.input[scene.first_frame], least = here, most = here;
    for (size_t f = 0; f < scene.n_frame; f++) {
        least = fmin(least, scene.input[f]);
        most = fmax(most, scene.input[f]);
    }
    *turns = !slider && scene.loops && most - least > 1.95*LW_PI;
    if (scene.n_frame > 1) {
        *down = here - least;
        *up = most - here;
        *ends = !*turns && (scene.loops || (!slider && most - least < 2*LW_PI));
    }
    lw_scene_free(&scene);
    return LW_OK;
}

lw_status lw_export_law_of(const lw_assembly *linkage, const lw_model *m, int input, lw_export_law *law)
{
    double down, up;
    bool ends;
    *law = (lw_export_law){ .turns = false };
    lw_status s = lw_export_way(linkage, m, input, &down, &up, &law->turns, &ends);
    if (s != LW_OK || law->turns)
        return s;
    double middle = 0.5*(up - down), half = 0.99*0.5*(up + down);
    law->half = half;
    law->phase = half > 0 ? asin(fmax(-1, fmin(1, -middle/half))) : 0;
    return LW_OK;
}

static void put_motion(writer *w, int input)
{
    const lw_input *in = &w->k->input[input];
    bool slider = lw_joint_slides(w->k->joint[in->joint].kind);
    lw_export_law law;
    w->out->failed |= lw_export_law_of(w->k, w->m, input, &law) != LW_OK;
    put_name(w, w->k->joint[in->joint].name, " motion");
    put_id(w, "MOTION/", input + 1, 2);
    put_id(w, ", JOINT = ", in->joint + 1, 2);
    put(w, slider ? ", TRANSLATION\n, FUNCTION = " : ", ROTATION\n, FUNCTION = ");
    if (law.turns) {
        put(w, "2*PI*TIME\n");
        return;
    }
    put_number(w, -law.half*sin(law.phase));
    put(w, " + ");
    put_number(w, law.half);
    put(w, "*SIN(2*PI*TIME + ");
    put_number(w, law.phase);
    put(w, ")\n");
}

/* A coupled input follows the first one: ratio q_0 - q_i = 0. */
static void put_tie(writer *w, int input)
{
    const lw_input *in = &w->k->input[input];
    put_name(w, w->k->joint[in->joint].name, " tie");
    put_id(w, "COUPLER/", w->k->n_joint + input, 2);
    put_id(w, ", JOINTS = ", w->k->input[0].joint + 1, 2);
    put_id(w, ", ", in->joint + 1, 2);
    put(w, ", SCALES = ");
    put_number(w, in->ratio);
    put(w, ", -1\n");
}

static void put_requests(writer *w)
{
    static const char *const kind[] = { "DISPLACEMENT", "VELOCITY", "ACCELERATION" };
    int id = 0;
    for (int t = 0; t < w->k->n_tracer; t++)
        for (int i = 0; i < 3; i++) {
            put_name(w, w->k->tracer[t].name, "");
            put_id(w, "REQUEST/", ++id, 2);
            put(w, ", ");
            put(w, kind[i]);
            put_id(w, ", I = ", w->tracer[t], 4);
            put_id(w, ", J = ", w->origin, 4);
            put(w, "\n");
        }
}

/* ---- the whole -------------------------------------------------------------------------------------- */

lw_status lw_export_adams(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    writer *w = calloc(1, sizeof *w);
    if (!w)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a dataset");
    w->k = linkage;
    w->m = o ? o->model : NULL;
    w->n_marker = calloc((size_t)linkage->n_link + (size_t)linkage->n_tracer + 1, sizeof *w->n_marker);
    w->at = calloc((size_t)linkage->n_joint + 1, sizeof *w->at);
    lw_status s = lw_assembly_check(linkage, e);
    if (s == LW_OK && !(w->n_marker && w->at && LW_OWNERS(&w->joints, linkage->n_link, linkage->joint, linkage->n_joint, link, 2)
                        && LW_OWNERS(&w->tracers, linkage->n_link, linkage->tracer, linkage->n_tracer, link, 1)))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory for a dataset");
    w->tracer = w->n_marker ? w->n_marker + linkage->n_link : NULL;
    w->stride = 100;
    if (linkage->n_joint > LW_JOINT_MAX)                       /* a link may have more than a hundred: one after the other */
        w->stride = 0;
    w->weighed = lw_export_weighed(linkage, w->m);
    w->out = out;
    if (s == LW_OK)
        s = check_loads(w, e);
    if (s == LW_OK)
        s = lw_export_start(w->m, &w->twist, e);
    if (s == LW_OK) {
        put(w, "ADAMS/View model name: ");
        put_plain(w, linkage->name[0] ? linkage->name : "linkage");
        put(w, "\n!\nUNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = METER, TIME = SECOND\n");
        put_parts(w);
        s = put_joints(w, e);
    }
    if (s == LW_OK) {
        put_loads(w);
        put(w, "!\n");
        for (int i = 0; i < linkage->n_input; i++)
            if (linkage->input[i].ratio != 0)
                put_tie(w, i);
            else if (!w->weighed || w->m->motion[i])
                put_motion(w, i);
        put_requests(w);
        put(w, "!\nRESULTS/\n!\nEND\n");
        s = lw_bytes_end(out, e);
    } else {
        lw_bytes_free(out);
    }
    lw_owners_free(&w->joints), lw_owners_free(&w->tracers);
    free(w->n_marker), free(w->at), free(w->twist), free(w);
    return s;
}

/* A file name, without ending, from a name: letters, digits, underscores; "linkage" if nothing is left. */
static void file_name(const char *from, char *name, size_t size)
{
    size_t n = 0;
    for (const char *c = from; *c && n + 1 < size; c++)
        if ((*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || (*c >= '0' && *c <= '9'))
            name[n++] = *c;
        else if (n > 0 && name[n - 1] != '_')
            name[n++] = '_';
    while (n > 0 && name[n - 1] == '_')
        n--;
    name[n] = 0;
    if (n == 0)
        snprintf(name, size, "linkage");
}

static lw_status put_commands(const char *title, bool weighed, lw_bytes *out, lw_error *e)
{
    char name[64];
    file_name(title, name, sizeof name);
    lw_bytes_text(out, name);
    lw_bytes_text(out, ".adm\n");
    lw_bytes_text(out, name);
    lw_bytes_text(out, "\nOUTPUT/NOSEPARATOR\nSIMULATE/");
    lw_bytes_text(out, weighed ? "DYNAMICS" : "KINEMATICS");
    lw_bytes_text(out, ", END = 1.0, STEPS = 100\nSTOP\n");
    return lw_bytes_end(out, e);
}

lw_status lw_export_adams_commands(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    return put_commands(linkage->name, lw_export_weighed(linkage, o ? o->model : NULL), out, e);
}

lw_status lw_export_space_adams_commands(const lw_spatial *m, lw_bytes *out, lw_error *e)
{
    lw_status s = lw_export_space_loads(m, "ADAMS", true, e);      /* the dataset that the commands run has to exist */
    return s == LW_OK ? put_commands(m->name, lw_space_weighed(m), out, e) : s;
}
