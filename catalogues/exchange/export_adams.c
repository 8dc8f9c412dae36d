/* catalogues/exchange/export_adams.c - write a spatial model, or a planar one in the plane z = 0, as a dataset of ADAMS/Solver, and the
 * commands that run it.
 *
 * Markers are numbered as in PLASMA, 100 part + count, or one after the other where a part has more than 99; the part of link i is i + 1. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/owners.h"
#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"
#include "catalogues/exchange/plane.h"
#include "catalogues/exchange/start.h"
#include "mbs/elastic/expand_space.h"

#define DIGITS 15

typedef struct writer {
    const lw_spatial *m;                       /* elastic links expanded                                  */
    const lw_spatial_expansion *expansion;
    const lw_export_plane *plane;              /* NULL: a model in space                                  */
    lw_bytes         *out;
    bool              weighed;                 /* the model has masses                                    */
    lw_owners         joints, tracers;         /* of each link                                            */
    bool              by_part;                 /* markers count from 100 times the number of their part   */
    int              *count, last;             /* (n_link) markers of a part so far; the last marker      */
    int             (*at)[2], *tracer;         /* markers of a joint on its links, of a tracer            */
    int               origin, spring, force, coupler;
    lw_export_twist  *twist;                    /* (n_link) velocities at the start; NULL: all are 0       */
} writer;

static void put(writer *w, const char *text) { lw_bytes_text(w->out, text); }

static void put_key(writer *w, const char *key, double v)
{
    put(w, key);
    lw_bytes_number(w->out, v, DIGITS);
}

static void put_vec(writer *w, const char *key, lw_vec3 v)
{
    put_key(w, key, v.x);
    put_key(w, ", ", v.y);
    put_key(w, ", ", v.z);
}

static void put_digits(writer *w, const char *what, int id, int digits)
{
    char text[64];
    snprintf(text, sizeof text, "%s%0*d", what, digits, id);
    put(w, text);
}

static void put_id(writer *w, const char *what, int id) { put_digits(w, what, id, 2); }
static void put_marker_id(writer *w, const char *what, int id) { put_digits(w, what, id, 4); }

/* Write printable ASCII characters except the quote. */
static void put_plain(writer *w, const char *text)
{
    for (; *text; text++)
        lw_bytes_add(w->out, *text > 31 && *text < 127 && *text != '\'' ? text : "_", 1);
}

/* A name as a comment. */
static void put_name(writer *w, const char *name, const char *more)
{
    put(w, "!                            adams_view_name='");
    put_plain(w, name);
    put_plain(w, more);
    put(w, "'\n");
}

/* Number of the marker that is written next on a link. */
static int next_marker(const writer *w, int link) { return w->by_part ? 100*(link + 1) + w->count[link] + 1 : w->last + 1; }

/* A marker; its axes are those of `turn`: by angle a about z, then b about the new x, then c about the new z. */
static int put_marker(writer *w, int link, lw_vec3 at, const lw_mat3 *turn, const char *name)
{
    int id = w->last = next_marker(w, link);
    w->count[link]++;
    put_name(w, name, "");
    put_marker_id(w, "MARKER/", id);
    put_id(w, ", PART = ", link + 1);
    put_vec(w, ", QP = ", at);
    if (turn) {
        lw_vec3 x = lw_m3_column(turn, 0), y = lw_m3_column(turn, 1), z = lw_m3_column(turn, 2);
        double across = hypot(z.x, z.y), a = across > 1e-12 ? atan2(z.x, -z.y) : atan2(x.y, x.x);
        lw_vec3 euler = lw_v3(a, atan2(across, z.z), across > 1e-12 ? atan2(x.z, y.z) : 0);
        if (lw_v3_norm(euler) > 0)
            put_vec(w, "\n, REULER = ", euler);
    }
    put(w, "\n");
    return id;
}

/* A marker with z along a direction and x along another one across it. */
static int put_axis_marker(writer *w, int link, lw_vec3 at, lw_vec3 z, lw_vec3 x, const char *name)
{
    lw_mat3 turn = lw_m3_columns(x, lw_v3_cross(z, x), z);
    return put_marker(w, link, at, &turn, name);
}

/* ---- parts and joints ------------------------------------------------------------------------------- */

/* Mass, its marker, and the velocity at the start, along the axes of the ground. */
static void put_mass(writer *w, int link, const double moment[3])
{
    const lw_spatial_body *b = &w->m->body[link];
    put_key(w, ", MASS = ", b->mass);
    put_marker_id(w, ", CM = ", next_marker(w, link));
    put_vec(w, ", IP = ", lw_v3(moment[0], moment[1], moment[2]));
    if (!w->twist)
        return;
    lw_vec3 omega = w->twist[link].omega, v = lw_v3_add(w->twist[link].velocity, lw_v3_cross(omega, b->centre));
    put_key(w, "\n, VX = ", v.x);
    put_key(w, ", VY = ", v.y);
    put_key(w, ", VZ = ", v.z);
    put_key(w, "\n, WX = ", omega.x);
    put_key(w, ", WY = ", omega.y);
    put_key(w, ", WZ = ", omega.z);
}

/* The marker of joint j on a link: z along the axis, or across a slot in its plane. */
static void put_joint_marker(writer *w, int j, int side)
{
    static const lw_vec3 up = { 0, 0, 1 };
    const lw_spatial_joint *p = &w->m->joint[j];
    lw_vec3 z = lw_export_is_slot(p) ? lw_v3_cross(p->axis, p->second) : lw_v3_norm(p->axis) > 0 ? p->axis : up;
    lw_vec3 x = z.x == 0 && z.y == 0 && z.z > 0 ? lw_v3(1, 0, 0) : z.z == 0 ? lw_v3_cross(up, z) : lw_v3_across(z);
    if (p->kind == LW_SPATIAL_UNIVERSAL) {
        z = side ? p->second : p->axis;
        x = side ? p->axis : p->second;
    }
    w->at[j][side] = put_axis_marker(w, p->link[side], p->at, z, x, p->name);
}

static void put_part(writer *w, int link)
{
    const lw_spatial *m = w->m;
    bool weighed = w->weighed && link != m->ground && m->body[link].mass > 0;
    double moment[3];
    lw_mat3 axes;
    put(w, "!\n");
    put_name(w, m->body[link].name, "");
    put_id(w, "PART/", link + 1);
    put(w, link == m->ground ? ", GROUND" : "");
    if (weighed) {
        lw_m3_principal(m->body[link].inertia, moment, &axes);
        put_mass(w, link, moment);
    }
    put(w, "\n");
    if (weighed)
        put_marker(w, link, m->body[link].centre, &axes, "centre of mass");
    for (int at = w->joints.start[link]; at < w->joints.start[link + 1]; at++)
        if (m->joint[w->joints.entry[at]/2].kind != LW_SPATIAL_FREE)
            put_joint_marker(w, w->joints.entry[at]/2, w->joints.entry[at]%2);
    for (int at = w->tracers.start[link]; at < w->tracers.start[link + 1]; at++) {
        const lw_spatial_tracer *t = &m->tracer[w->tracers.entry[at]];
        lw_mat3 frame = lw_quaternion_matrix(t->frame);
        w->tracer[w->tracers.entry[at]] = put_marker(w, link, t->at, &frame, t->name);
    }
    if (link == m->ground)
        w->origin = put_marker(w, link, lw_v3(0, 0, 0), NULL, "origin");
}

/* Markers whose movement, I relative to J, counts as the joint does. */
static void put_markers(writer *w, int j)
{
    put_marker_id(w, ", I = ", w->at[j][1]);
    put_marker_id(w, ", J = ", w->at[j][0]);
}

/* Couplers: scales times displacements, I relative to J, are 0. */
static void put_coupler(writer *w)
{
    const lw_spatial_coupling *c = &w->m->coupling[w->coupler++];
    put_name(w, c->name, "");
    put_id(w, "COUPLER/", w->coupler);
    for (int k = 0; k < c->n; k++)
        put_id(w, k ? ", " : ", JOINTS = ", c->of[k].index + 1);
    for (int k = 0; k < c->n; k++) {
        put(w, k ? ":" : "\n, TYPE = ");
        put(w, c->of[k].of == LW_OF_TURN ? "R" : "T");
    }
    for (int k = 0; k < c->n; k++)
        put_key(w, k ? ", " : "\n, SCALES = ", c->factor[k]);
    put(w, "\n");
}

static lw_status put_joint(writer *w, int j, lw_error *e)
{
    static const char *const word[] = {
        [LW_SPATIAL_REVOLUTE] = "REVOLUTE",       [LW_SPATIAL_PRISMATIC] = "TRANSLATIONAL",
        [LW_SPATIAL_CYLINDRICAL] = "CYLINDRICAL", [LW_SPATIAL_SPHERICAL] = "SPHERICAL",
        [LW_SPATIAL_UNIVERSAL] = "UNIVERSAL",     [LW_SPATIAL_SCREW] = "SCREW",
        [LW_SPATIAL_PLANAR] = "PLANAR",           [LW_SPATIAL_FIXED] = "FIXED",
        [LW_SPATIAL_FREE] = NULL
    };
    const lw_spatial_joint *p = &w->m->joint[j];
    if (p->link[0] < 0)                        /* a gear: the couplings begin with those of gears */
        put_coupler(w);
    if (p->kind == LW_SPATIAL_FREE)
        return LW_OK;
    if (p->kind == LW_SPATIAL_UNIVERSAL && fabs(lw_v3_dot(p->axis, p->second)) > 1e-9)
        return lw_error_set(e, LW_E_KIND, "the axes of universal joint '%s' are not at right angles, which ADAMS does not know", p->name);
    put_name(w, p->name, "");
    put_id(w, lw_export_is_slot(p) ? "JPRIM/" : "JOINT/", j + 1);
    put(w, ", ");
    put(w, lw_export_is_slot(p) ? "INPLANE" : word[p->kind]);
    put_markers(w, j);
    if (p->kind == LW_SPATIAL_SCREW)
        put_key(w, ", PITCH = ", p->lead);
    put(w, "\n");
    return LW_OK;
}

/* ---- loads ------------------------------------------------------------------------------------------ */

static lw_status check(const lw_spatial *m, lw_error *e)
{
    for (int j = 0; j < m->n_joint; j++)
        if (m->joint[j].stop.has_least || m->joint[j].stop.has_greatest)
            return lw_error_set(e, LW_E_KIND, "joint '%s' has a stop, which is not written to ADAMS", m->joint[j].name);
    for (int i = 0; i < m->n_joint_spring; i++)
        if (m->joint_spring[i].measure.of != LW_OF_TURN)
            return lw_error_set(e, LW_E_KIND, "joint spring '%s' acts along a slide, which is not written to ADAMS",
                                m->joint_spring[i].name);
    for (int i = 0; i < m->n_motor; i++)
        if (!lw_spatial_kind_of(m->joint[m->motor[i].joint].kind)->turns)
            return lw_error_set(e, LW_E_KIND, "motor '%s' moves a slide, which is not written to ADAMS", m->motor[i].name);
    for (int i = 0; i < m->n_coupling; i++)
        for (int k = 0; k < m->coupling[i].n; k++) {
            lw_spatial_kind kind = m->joint[m->coupling[i].of[k].index].kind;
            if (k >= 3 || (kind != LW_SPATIAL_REVOLUTE && kind != LW_SPATIAL_PRISMATIC && kind != LW_SPATIAL_CYLINDRICAL))
                return lw_error_set(e, LW_E_KIND, "coupling '%s' has no form in ADAMS, which knows two or three revolute, prismatic or "
                                    "cylindrical joints", m->coupling[i].name);
        }
    return LW_OK;
}

/* A force or torque on marker `at` along z of another one, without a reaction. */
static void put_action(writer *w, int link, lw_vec3 point, lw_vec3 v, int on, const char *name, const char *kind)
{
    double size = lw_v3_norm(v);
    if (size == 0)
        return;
    lw_vec3 z = lw_v3_scale(v, 1/size);
    int at = put_marker(w, link, point, NULL, name), axis = put_axis_marker(w, on, point, z, lw_v3_across(z), name);
    put_id(w, "SFORCE/", ++w->force);
    put_marker_id(w, ", I = ", at);
    put_marker_id(w, ", J = ", axis);
    put(w, kind);
    put_key(w, ", ACTIONONLY\n, FUNCTION = ", size);
    put(w, "\n");
}

static void put_spring(writer *w, const lw_spring *p)
{
    int at[2];
    for (int end = 0; end < 2; end++)
        at[end] = put_marker(w, p->link[end], p->at[end], NULL, p->name);
    put_name(w, p->name, "");
    put_id(w, "SPRINGDAMPER/", ++w->spring);
    put_marker_id(w, ", I = ", at[0]);
    put_marker_id(w, ", J = ", at[1]);
    put_key(w, ", TRANSLATION, K = ", p->stiffness);
    put_key(w, ", C = ", p->damping);
    put_key(w, ", LENGTH = ", p->free);
    put(w, "\n");
}

static void put_loads(writer *w)
{
    const lw_spatial *m = w->m;
    put(w, "!\n");
    if (w->weighed) {
        put_key(w, "ACCGRAV/IGRAV = ", m->gravity.x);
        put_key(w, ", JGRAV = ", m->gravity.y);
        put_key(w, ", KGRAV = ", m->gravity.z);
        put(w, "\n");
    }
    for (int i = 0; i < m->n_spring; i++)
        put_spring(w, &m->spring[i]);
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_spatial_joint_spring *p = &m->joint_spring[i];
        put_name(w, p->name, "");
        put_id(w, "SPRINGDAMPER/", ++w->spring);
        put_markers(w, p->measure.index);
        put_key(w, ", ROTATION, KT = ", p->stiffness);
        put_key(w, ", CT = ", p->damping);
        put_key(w, ", ANGLE = ", p->free);
        put(w, "\n");
    }
    for (int i = 0; i < m->n_motor; i++) {
        const lw_motor *p = &m->motor[i];
        put_name(w, p->name, " motor");
        put_id(w, "SFORCE/", ++w->force);
        put_markers(w, p->joint);
        put_key(w, ", ROTATION\n, FUNCTION = ", p->stall);
        put_key(w, "*(1 - ", 1/p->free_speed);
        put_marker_id(w, "*WZ(", w->at[p->joint][1]);
        put_marker_id(w, ", ", w->at[p->joint][0]);
        put(w, "))\n");
    }
    for (int i = 0; i < m->n_force; i++) {
        const lw_force *p = &m->force[i];
        double v[6];
        for (int c = 0; c < 6; c++)
            v[c] = lw_export_constant(c < 3 ? p->force[c] : p->torque[c - 3]);
        put_name(w, p->name, " force");
        put_action(w, p->link, p->at, lw_v3(v[0], v[1], v[2]), p->follows ? p->link : m->ground, p->name, ", TRANSLATION");
        put_action(w, p->link, p->at, lw_v3(v[3], v[4], v[5]), p->follows ? p->link : m->ground, p->name, ", ROTATION");
    }
}

/* The elements of elastic links: I lies where x of J, along the beam, ends.  ADAMS measures the strains in J, not half-way. */
static void put_beams(writer *w)
{
    const lw_spatial *m = w->m;
    int id = 0;
    for (int k = 0; k < w->expansion->n_chain; k++) {
        const lw_elastic_chain *c = &w->expansion->chain[k];
        const lw_section *q = &c->elastic->section;
        const lw_material *p = &c->elastic->material;
        for (int i = 0; i + 1 < c->n_node; i++) {
            const lw_spatial_beam *b = &m->beam[c->first_beam + i];
            const char *name = m->body[b->link[0]].name;
            int at[2];
            for (int end = 0; end < 2; end++)
                at[end] = put_marker(w, b->link[end], m->body[b->link[end]].centre, &b->axes, name);
            put_name(w, name, " beam");
            put_id(w, "BEAM/", ++id);
            put_marker_id(w, ", I = ", at[1]);
            put_marker_id(w, ", J = ", at[0]);
            put_key(w, ", LENGTH = ", b->length);
            put_key(w, "\n, AREA = ", q->area);
            put_key(w, ", IXX = ", q->it);
            put_key(w, ", IYY = ", q->iy);
            put_key(w, ", IZZ = ", q->iz);
            put_key(w, "\n, ASY = ", q->zeta_y);
            put_key(w, ", ASZ = ", q->zeta_z);
            put_key(w, ", EMODULUS = ", p->e);
            put_key(w, ", GMODULUS = ", p->g);
            put_key(w, ", CRATIO = ", b->damping);
            put(w, "\n");
        }
    }
}

/* ---- motion ----------------------------------------------------------------------------------------- */

/* An expression of t in the words of ADAMS: false if it has others. */
static bool put_function(writer *w, const char *text)
{
    static const char *const known[] = { "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh",
                                         "exp", "log", "sqrt", "abs", "mod", "min", "max", "step", "havsin", "poly",
                                         "pi" };
    while (*text) {
        size_t n = 0;
        char word[16] = "";
        while (isalpha((unsigned char)text[n]) || (n > 0 && (isdigit((unsigned char)text[n]) || text[n] == '_')))
            n++;
        if (n == 0) {                          /* a number with its exponent, or a sign */
            n = strspn(text, "0123456789.");
            if (n > 0 && (text[n] == 'e' || text[n] == 'E'))
                n += 1 + strspn(text + n + 1, "+-") + strspn(text + n + 1 + strspn(text + n + 1, "+-"), "0123456789");
            n = n ? n : 1;
            if (*text == '^')
                put(w, "**");
            else
                lw_bytes_add(w->out, text, n);
            text += n;
            continue;
        }
        for (size_t i = 0; i < n && i + 1 < sizeof word; i++)
            word[i] = text[i];
        bool ours = strcmp(word, "t") == 0 && n == 1;
        for (size_t i = 0; !ours && i < sizeof known/sizeof *known; i++)
            ours = strcmp(word, known[i]) == 0 && strlen(word) == n;
        if (!ours)
            return false;
        for (char *c = word; *c; c++)
            *c = (char)toupper((unsigned char)*c);
        put(w, strcmp(word, "T") == 0 ? "TIME" : word);
        text += n;
    }
    return true;
}

/* To and fro once per second: in the plane over the way of the linkage, which may be whole turns, else over the range of
 * the input or a tenth of a radian or of the size. */
static lw_status put_law(writer *w, int i)
{
    const lw_spatial_input *in = &w->m->input[i];
    lw_export_law law = { .turns = false };
    double start = in->measure.of >= LW_OF_X ? in->value : 0;
    if (w->plane) {
        lw_status s = lw_export_law_of(&w->plane->model.linkage, w->plane->given ? &w->plane->model : NULL, i, &law);
        if (s != LW_OK)
            return s;
    } else {
        double reach = in->measure.of == LW_OF_TURN ? 0.1 : 0.1*lw_spatial_size(w->m);
        lw_export_law_within(in->has_range ? in->value - in->first : reach, in->has_range ? in->last - in->value : reach, 1, &law);
    }
    if (law.turns) {
        put(w, "2*PI*TIME");
        return LW_OK;
    }
    put_key(w, "", start - law.half*sin(law.phase));
    put_key(w, " + ", law.half);
    put_key(w, "*SIN(2*PI*TIME + ", law.phase);
    put(w, ")");
    return LW_OK;
}

/* The motion of an input; one without it moves once per second, or runs freely where the model has masses. */
static lw_status put_motion(writer *w, int i, lw_error *e)
{
    const lw_spatial_input *in = &w->m->input[i];
    lw_spatial_of of = in->measure.of;
    char name[LW_NAME_SIZE + 16];
    lw_spatial_measure_name(w->m, in->measure, name, sizeof name);
    if (!in->motion && w->weighed)
        return LW_OK;
    put_name(w, name, " motion");
    put_id(w, "MOTION/", i + 1);
    if (of >= LW_OF_X) {
        put_marker_id(w, ", I = ", w->tracer[in->measure.index]);
        put_marker_id(w, ", J = ", w->origin);
        put(w, of == LW_OF_X ? ", X" : of == LW_OF_Y ? ", Y" : ", Z");
    } else {
        put_id(w, ", JOINT = ", in->measure.index + 1);
        put(w, of == LW_OF_TURN ? ", ROTATION" : ", TRANSLATION");
    }
    put(w, "\n, FUNCTION = ");
    if (in->motion) {
        if (!put_function(w, lw_expression_text(in->motion)))
            return lw_error_set(e, LW_E_KIND, "the motion of %s, \"%s\", has no form in ADAMS", name, lw_expression_text(in->motion));
        put_key(w, lw_spatial_offset(in) > 0 ? " - " : " + ", fabs(lw_spatial_offset(in)));
    } else if (put_law(w, i) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for the motion of %s", name);
    put(w, "\n");
    return LW_OK;
}

static void put_requests(writer *w)
{
    static const char *const kind[] = { ", DISPLACEMENT", ", VELOCITY", ", ACCELERATION" };
    for (int t = 0; t < w->m->n_tracer; t++)
        for (int i = 0; i < 3; i++) {
            put_name(w, w->m->tracer[t].name, "");
            put_id(w, "REQUEST/", 3*t + i + 1);
            put(w, kind[i]);
            put_marker_id(w, ", I = ", w->tracer[t]);
            put_marker_id(w, ", J = ", w->origin);
            put(w, "\n");
        }
}

/* ---- the whole -------------------------------------------------------------------------------------- */

/* Room for markers.  Are there fewer than 100 in every part? */
static lw_status reserve(writer *w, lw_error *e)
{
    const lw_spatial *m = w->m;
    w->count = calloc((size_t)m->n_link, sizeof *w->count);
    w->at = calloc((size_t)m->n_joint + 1, sizeof *w->at);
    w->tracer = calloc((size_t)m->n_tracer + 1, sizeof *w->tracer);
    if (!w->count || !w->at || !w->tracer || !LW_OWNERS(&w->joints, m->n_link, m->joint, m->n_joint, link, 2)
        || !LW_OWNERS(&w->tracers, m->n_link, m->tracer, m->n_tracer, link, 1))
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a dataset");
    int most = 0, others = 2 + 2*m->n_spring + 4*m->n_force + 2*(m->n_beam > 0);      /* of all parts */
    for (int i = 0; i < m->n_link; i++)
        most = (int)fmax(most, w->joints.start[i + 1] - w->joints.start[i] + w->tracers.start[i + 1] - w->tracers.start[i]);
    w->by_part = most + others < 100;
    return LW_OK;
}

static lw_status write_dataset(writer *w, const lw_spatial *given, lw_error *e)
{
    const lw_spatial *m = w->m;
    lw_status s = lw_export_space_loads(given, "ADAMS", true, e);
    if (s == LW_OK)
        s = reserve(w, e);
    if (s == LW_OK)
        s = check(m, e);
    if (s == LW_OK)
        s = w->plane ? lw_export_start(&w->plane->model, &w->twist, e) : lw_export_space_start(given, m, &w->twist, e);
    if (s == LW_OK) {
        put(w, "ADAMS/View model name: ");
        put_plain(w, m->name[0] ? m->name : "model");
        put(w, "\n!\nUNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = METER, TIME = SECOND\n");
        for (int i = 0; i < m->n_link; i++)
            put_part(w, i);
        put(w, "!\n");
    }
    for (int j = 0; s == LW_OK && j < m->n_joint; j++)
        s = put_joint(w, j, e);
    if (s == LW_OK) {
        while (w->coupler < m->n_coupling)
            put_coupler(w);
        put_beams(w);
        put_loads(w);
    }
    for (int i = 0; s == LW_OK && i < m->n_input; i++)
        s = put_motion(w, i, e);
    if (s == LW_OK) {
        put_requests(w);
        put(w, "!\nRESULTS/\n!\nEND\n");
        s = lw_bytes_end(w->out, e);
    }
    if (s != LW_OK)
        lw_bytes_free(w->out);
    lw_owners_free(&w->joints), lw_owners_free(&w->tracers);
    free(w->count), free(w->at), free(w->tracer), free(w->twist);
    return s;
}

lw_status lw_export_space_adams(const lw_spatial *m, lw_bytes *out, lw_error *e)
{
    lw_spatial_expansion x = { 0 };
    lw_status s = m->n_elastic ? lw_export_space_loads(m, "ADAMS", true, e) : LW_OK;      /* before they are expanded */
    if (s == LW_OK && m->n_elastic)
        s = lw_spatial_expand(m, false, &x, e);
    writer w = { .m = m->n_elastic ? &x.model : m, .expansion = &x, .out = out, .weighed = lw_space_weighed(m) };
    if (s == LW_OK)
        s = write_dataset(&w, m, e);
    lw_spatial_expansion_free(&x);
    return s;
}

lw_status lw_export_adams(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_export_plane plane;
    lw_spatial_expansion none = { 0 };
    lw_status s = lw_export_plane_make(linkage, o ? o->model : NULL, &plane, e);
    writer w = { .m = &plane.space, .expansion = &none, .plane = &plane, .out = out, .weighed = lw_space_weighed(&plane.space) };
    if (s == LW_OK)
        s = write_dataset(&w, &plane.space, e);
    lw_export_plane_free(&plane);
    return s;
}

/* ---- commands --------------------------------------------------------------------------------------- */

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
