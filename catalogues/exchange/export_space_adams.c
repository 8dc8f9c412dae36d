/* catalogues/exchange/export_space_adams.c - write a spatial model as a dataset of ADAMS/Solver. */
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/exchange/export.h"
#include "catalogues/exchange/export_space.h"
#include "catalogues/exchange/start.h"
#include "mbs/elastic/expand_space.h"

#define DIGITS 15

typedef struct writer {
    const lw_spatial *m;                       /* elastic links expanded                                  */
    const lw_spatial_expansion *expansion;
    lw_bytes         *out;
    bool              weighed;                 /* the model has masses                                    */
    int               part;                    /* a marker is part times the part's number, plus a count  */
    int              *count;                   /* (n_link) markers of a part so far                       */
    int             (*at)[2], *tracer;         /* markers of a joint on its links, of a tracer            */
    int               origin, spring, force;
    lw_export_twist   *twist;                   /* (n_link) velocities at the start; NULL: all are 0       */
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

static void put_id(writer *w, const char *what, int id)
{
    char text[64];
    snprintf(text, sizeof text, "%s%02d", what, id);
    put(w, text);
}

/* A name as a comment, of printable ASCII characters but the quote. */
static void put_name(writer *w, const char *name, const char *more)
{
    char text[2*LW_NAME_SIZE];
    snprintf(text, sizeof text, "%s%s", name, more);
    for (char *c = text; *c; c++)
        *c = *c > 31 && *c < 127 && *c != '\'' ? *c : '_';
    put(w, "!                            adams_view_name='");
    put(w, text);
    put(w, "'\n");
}

/* A marker; its axes are those of `turn`: by angle a about z, then b about the new x, then c about the new z. */
static int put_marker(writer *w, int link, lw_vec3 at, const lw_mat3 *turn, const char *name)
{
    int id = w->part*(link + 1) + ++w->count[link];
    put_name(w, name, "");
    put_id(w, "MARKER/", id);
    put_id(w, ", PART = ", link + 1);
    put_vec(w, ", QP = ", at);
    if (turn) {
        lw_vec3 x = lw_m3_column(turn, 0), y = lw_m3_column(turn, 1), z = lw_m3_column(turn, 2);
        double across = hypot(z.x, z.y), a = across > 1e-12 ? atan2(z.x, -z.y) : atan2(x.y, x.x);
        put_vec(w, "\n, REULER = ", lw_v3(a, atan2(across, z.z), across > 1e-12 ? atan2(x.z, y.z) : 0));
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

static void put_part(writer *w, int link)
{
    const lw_spatial *m = w->m;
    const lw_spatial_body *b = &m->body[link];
    bool weighed = w->weighed && link != m->ground && b->mass > 0;
    double moment[3];
    lw_mat3 axes;
    put(w, "!\n");
    put_name(w, b->name, "");
    put_id(w, "PART/", link + 1);
    put(w, link == m->ground ? ", GROUND" : "");
    if (weighed) {                             /* its marker is the first one of the part */
        lw_m3_principal(b->inertia, moment, &axes);
        put_key(w, ", MASS = ", b->mass);
        put_id(w, ", CM = ", w->part*(link + 1) + 1);
        put_vec(w, "\n, IP = ", lw_v3(moment[0], moment[1], moment[2]));
        if (w->twist) {
            lw_export_twist v = w->twist[link];
            v.velocity = lw_v3_add(v.velocity, lw_v3_cross(v.omega, b->centre));
            put_id(w, "\n, VM = ", w->origin);
            put_id(w, ", WM = ", w->origin);
            put_key(w, ", VX = ", v.velocity.x);
            put_key(w, ", VY = ", v.velocity.y);
            put_key(w, ", VZ = ", v.velocity.z);
            put_key(w, "\n, WX = ", v.omega.x);
            put_key(w, ", WY = ", v.omega.y);
            put_key(w, ", WZ = ", v.omega.z);
        }
    }
    put(w, "\n");
    if (weighed)
        put_marker(w, link, b->centre, &axes, "centre of mass");
    if (link == m->ground)
        w->origin = put_marker(w, link, lw_v3(0, 0, 0), NULL, "origin");
    for (int j = 0; j < m->n_joint; j++)
        for (int side = 0; side < 2; side++) {
            const lw_spatial_joint *p = &m->joint[j];
            if (p->link[side] != link)
                continue;
            lw_vec3 z = lw_v3_norm(p->axis) > 0 ? p->axis : lw_v3(0, 0, 1), x = lw_v3_across(z);
            if (p->kind == LW_SPATIAL_UNIVERSAL) {
                z = side ? p->second : p->axis;
                x = side ? p->axis : p->second;
            }
            w->at[j][side] = put_axis_marker(w, link, p->at, z, x, p->name);
        }
    for (int t = 0; t < m->n_tracer; t++)
        if (m->tracer[t].link == link) {
            lw_mat3 frame = lw_quaternion_matrix(m->tracer[t].frame);
            w->tracer[t] = put_marker(w, link, m->tracer[t].at, &frame, m->tracer[t].name);
        }
}

/* Markers whose movement, I relative to J, counts as the joint does. */
static void put_markers(writer *w, int j)
{
    put_id(w, ", I = ", w->at[j][1]);
    put_id(w, ", J = ", w->at[j][0]);
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
    if (p->kind == LW_SPATIAL_FREE)
        return LW_OK;
    if (p->kind == LW_SPATIAL_UNIVERSAL && fabs(lw_v3_dot(p->axis, p->second)) > 1e-9)
        return lw_error_set(e, LW_E_KIND, "the axes of universal joint '%s' are not at right angles, which ADAMS does not know", p->name);
    put_name(w, p->name, "");
    put_id(w, "JOINT/", j + 1);
    put(w, ", ");
    put(w, word[p->kind]);
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
    put_id(w, ", I = ", at);
    put_id(w, ", J = ", axis);
    put(w, kind);
    put_key(w, ", ACTIONONLY\n, FUNCTION = ", size);
    put(w, "\n");
}

static void put_spring(writer *w, const lw_spatial_spring *p)
{
    int at[2];
    for (int end = 0; end < 2; end++)
        at[end] = put_marker(w, p->link[end], p->at[end], NULL, p->name);
    put_name(w, p->name, "");
    put_id(w, "SPRINGDAMPER/", ++w->spring);
    put_id(w, ", I = ", at[0]);
    put_id(w, ", J = ", at[1]);
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
        put_id(w, "*WZ(", w->at[p->joint][1]);
        put_id(w, ", ", w->at[p->joint][0]);
        put(w, "))\n");
    }
    for (int i = 0; i < m->n_force; i++) {
        const lw_spatial_force *p = &m->force[i];
        double v[6];
        for (int c = 0; c < 6; c++)
            v[c] = lw_export_constant(c < 3 ? p->force[c] : p->torque[c - 3]);
        put_name(w, p->name, " force");
        put_action(w, p->link, p->at, lw_v3(v[0], v[1], v[2]), p->follows ? p->link : m->ground, p->name, ", TRANSLATION");
        put_action(w, p->link, p->at, lw_v3(v[3], v[4], v[5]), p->follows ? p->link : m->ground, p->name, ", ROTATION");
    }
}

/* Couplings: scales times displacements, I relative to J, are 0. */
static void put_couplers(writer *w)
{
    for (int i = 0; i < w->m->n_coupling; i++) {
        const lw_spatial_coupling *c = &w->m->coupling[i];
        put_name(w, c->name, "");
        put_id(w, "COUPLER/", i + 1);
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
            put_id(w, ", I = ", at[1]);
            put_id(w, ", J = ", at[0]);
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

/* The motion of an input; without one, of a model without masses: to and fro, over its range or a tenth of a radian or
 * of the size. */
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
        put_id(w, ", I = ", w->tracer[in->measure.index]);
        put_id(w, ", J = ", w->origin);
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
    } else {
        double reach = of == LW_OF_TURN ? 0.1 : 0.1*lw_spatial_size(w->m);
        double down = in->has_range ? in->value - in->first : reach, up = in->has_range ? in->last - in->value : reach;
        double half = (up + down)/2, middle = (up - down)/2, phase = half > 0 ? asin(fmax(-1, fmin(1, -middle/half)))
            : 0;
        put_key(w, "", middle + (of >= LW_OF_X ? in->value : 0));
        put_key(w, " + ", half);
        put_key(w, "*SIN(2*PI*TIME + ", phase);
        put(w, ")");
    }
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
            put_id(w, ", I = ", w->tracer[t]);
            put_id(w, ", J = ", w->origin);
            put(w, "\n");
        }
}

/* ---- the whole -------------------------------------------------------------------------------------- */

/* Room for markers; their greatest number in a part decides how they are counted. */
static lw_status reserve(writer *w, lw_error *e)
{
    const lw_spatial *m = w->m;
    int most = 2 + 2*m->n_joint + m->n_tracer + 2*m->n_spring + 4*m->n_force + 2*(m->n_beam > 0);
    for (w->part = 100; w->part <= most; w->part *= 10)
        continue;
    w->count = calloc((size_t)m->n_link, sizeof *w->count);
    w->at = calloc((size_t)m->n_joint + 1, sizeof *w->at);
    w->tracer = calloc((size_t)m->n_tracer + 1, sizeof *w->tracer);
    if (!w->count || !w->at || !w->tracer)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a dataset");
    if ((double)(m->n_link + 1)*w->part > 1e9)
        return lw_error_set(e, LW_E_KIND, "the model is too large: ADAMS numbers markers below 1e9");
    return LW_OK;
}

static lw_status write_dataset(writer *w, const lw_spatial *given, lw_error *e)
{
    const lw_spatial *m = w->m;
    lw_status s = reserve(w, e);
    if (s == LW_OK)
        s = check(m, e);
    if (s == LW_OK)
        s = lw_export_space_start(given, m, &w->twist, e);
    if (s == LW_OK) {
        put(w, "ADAMS/View model name: ");
        put(w, m->name[0] ? m->name : "model");
        put(w, "\n!\nUNITS/FORCE = NEWTON, MASS = KILOGRAM, LENGTH = METER, TIME = SECOND\n");
        w->origin = w->part*(m->ground + 1) + 1;
        for (int i = 0; i < m->n_link; i++)
            put_part(w, i);
        put(w, "!\n");
    }
    for (int j = 0; s == LW_OK && j < m->n_joint; j++)
        s = put_joint(w, j, e);
    if (s == LW_OK) {
        put_couplers(w);
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
    return s;
}

lw_status lw_export_space_adams(const lw_spatial *m, lw_bytes *out, lw_error *e)
{
    lw_spatial_expansion x = { 0 };
    writer w = { .m = m->n_elastic ? &x.model : m, .expansion = &x, .out = out, .weighed = lw_space_weighed(m) };
    lw_status s = lw_export_space_loads(m, "ADAMS", true, e);
    if (s == LW_OK && m->n_elastic)
        s = lw_spatial_expand(m, false, &x, e);
    if (s == LW_OK)
        s = write_dataset(&w, m, e);
    if (s != LW_OK)
        lw_bytes_free(out);
    lw_spatial_expansion_free(&x);
    free(w.count);
    free(w.at);
    free(w.tracer);
    free(w.twist);
    return s;
}
