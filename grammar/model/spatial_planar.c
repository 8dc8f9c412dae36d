/* grammar/model/spatial_planar.c - a spatial model whose motion is planar, as the planar model that moves alike: its JSON text is written,
 * then read. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "grammar/model/spatial.h"
#include "grammar/text/json_internal.h"

typedef struct plane { FILE *f; const lw_spatial *m; lw_vec3 x, y, normal; } plane;

static void put_string(const plane *w, const char *s)
{
    char code[8];
    fputc('"', w->f);
    for (; *s; s++)
        fwrite(code, 1, (size_t)lw_json_character(*s, code), w->f);
    fputc('"', w->f);
}

static void put_text(const plane *w, const char *key, const char *s)
{
    fprintf(w->f, ", \"%s\": ", key);
    put_string(w, s);
}

static void put_vec(const plane *w, const char *key, lw_vec3 a)
{
    fprintf(w->f, ", \"%s\": [%.17g, %.17g]", key, lw_v3_dot(w->x, a), lw_v3_dot(w->y, a));
}

static void put_number(const plane *w, const char *key, double v) { fprintf(w->f, ", \"%s\": %.17g", key, v); }

static void put_links(const plane *w, int a, int b)
{
    fputs(", \"links\": [", w->f);
    put_string(w, w->m->body[a].name);
    fputs(", ", w->f);
    put_string(w, w->m->body[b].name);
    fputs("]", w->f);
}

/* A pin about the opposite of the normal turns as one about the normal with its links exchanged. */
static bool is_turned(const plane *w, int j) { return lw_v3_dot(w->m->joint[j].axis, w->normal) < -0.5; }

/* Planar models count a pin on the ground by the turn of the other link, whichever is named first. */
static bool counts_backwards(const plane *w, int j)
{
    const lw_spatial_joint *p = &w->m->joint[j];
    return p->kind == LW_SPATIAL_REVOLUTE && p->link[is_turned(w, j) ? 0 : 1] == w->m->ground;
}

/* "": all is known in the plane. */
static const char *beyond(const plane *w, double flat)
{
    const lw_spatial *m = w->m;
    if (m->n_force || m->n_motor || m->states.n_state || m->states.n_signal || m->n_profile || m->n_drive || m->n_coupling)
        return "forces, motors, states, profiles, drives or couplings";
    for (int j = 0; j < m->n_joint; j++) {
        if (m->joint[j].kind != LW_SPATIAL_REVOLUTE && m->joint[j].kind != LW_SPATIAL_PRISMATIC && m->joint[j].kind != LW_SPATIAL_FIXED)
            return "joints other than hinges, slides and welds";
        if (m->joint[j].friction.coefficient > 0 || m->joint[j].clearance.model != LW_CLEARANCE_NONE)
            return "friction or clearance";
    }
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i].measure.of > LW_OF_SLIDE || counts_backwards(w, m->input[i].measure.index))
            return "inputs at tracers, or at a hinge on the ground with a turn against the normal of the plane (turn its axis round, or exchange its links)";
    for (int i = 0; i < m->n_joint_spring; i++)
        if (m->joint_spring[i].law)
            return "springs with a law";
    for (int i = 0; i < m->n_spring; i++)
        if (m->spring[i].law || fabs(lw_v3_dot(w->normal, lw_v3_sub(m->spring[i].at[1], m->spring[i].at[0]))) > flat)
            return "springs with a law, or across the plane";
    for (int i = 0; i < m->n_link; i++)
        if (m->body[i].has_velocity || m->body[i].has_omega)
            return "links with velocities of their own";
    return "";
}

static void put_bodies(const plane *w)
{
    const lw_spatial *m = w->m;
    for (int i = 0; i < m->n_link; i++) {
        const lw_spatial_body *b = &m->body[i];
        const double *t = b->inertia;
        lw_vec3 n = w->normal, tn = { t[0]*n.x + t[3]*n.y + t[4]*n.z, t[3]*n.x + t[1]*n.y + t[5]*n.z, t[4]*n.x + t[5]*n.y + t[2]*n.z };
        fputs(i ? ", {\"name\": " : "{\"name\": ", w->f);
        put_string(w, b->name);
        if (b->given && i != m->ground) {
            put_number(w, "mass", b->mass);
            put_vec(w, "centre", b->centre);
            put_number(w, "inertia", lw_v3_dot(n, tn));
        }
        fputs("}", w->f);
    }
}

static void put_joints(const plane *w)
{
    const lw_spatial *m = w->m;
    for (int j = 0; j < m->n_joint; j++) {
        const lw_spatial_joint *p = &m->joint[j];
        bool turned = p->kind == LW_SPATIAL_REVOLUTE && is_turned(w, j);
        fputs(j ? ", {\"name\": " : "{\"name\": ", w->f);
        put_string(w, p->name);
        put_text(w, "kind", p->kind == LW_SPATIAL_REVOLUTE ? "r" : p->kind == LW_SPATIAL_PRISMATIC ? "t" : "f");
        put_links(w, p->link[turned], p->link[!turned]);
        put_vec(w, "at", p->at);
        if (p->kind == LW_SPATIAL_PRISMATIC)
            put_vec(w, "along", p->axis);
        if (p->stop.has_least || p->stop.has_greatest) {
            bool back = counts_backwards(w, j);
            fprintf(w->f, ", \"stop\": {\"restitution\": %.17g", p->stop.restitution);
            if (p->stop.has_least)
                put_number(w, back ? "greatest" : "least", back ? -p->stop.least : p->stop.least);
            if (p->stop.has_greatest)
                put_number(w, back ? "least" : "greatest", back ? -p->stop.greatest : p->stop.greatest);
            if (p->stop.stiffness > 0) {
                put_number(w, "stiffness", p->stop.stiffness);
                put_number(w, "damping", p->stop.damping);
            }
            fputs("}", w->f);
        }
        fputs("}", w->f);
    }
}

static void put_rest(const plane *w)
{
    const lw_spatial *m = w->m;
    fputs("]", w->f);
    for (int i = 0; i < m->n_input; i++) {
        const lw_spatial_input *in = &m->input[i];
        fputs(i ? ", {\"joint\": " : ", \"inputs\": [{\"joint\": ", w->f);
        put_string(w, m->joint[in->measure.index].name);
        put_number(w, "value", in->value);
        if (in->motion)
            put_text(w, "motion", lw_expression_text(in->motion));
        if (in->has_speed)
            put_number(w, "speed", in->speed);
        fputs("}", w->f);
    }
    fputs(m->n_input ? "], \"springs\": [" : ", \"springs\": [", w->f);
    for (int i = 0; i < m->n_spring; i++) {
        const lw_spring *c = &m->spring[i];
        fprintf(w->f, "%s{\"stiffness\": %.17g, \"damping\": %.17g, \"free\": %.17g", i ? ", " : "", c->stiffness, c->damping, c->free);
        put_links(w, c->link[0], c->link[1]);
        fprintf(w->f, ", \"at\": [[%.17g, %.17g], [%.17g, %.17g]]", lw_v3_dot(w->x, c->at[0]), lw_v3_dot(w->y, c->at[0]),
                lw_v3_dot(w->x, c->at[1]), lw_v3_dot(w->y, c->at[1]));
        if (c->name[0])
            put_text(w, "name", c->name);
        fputs("}", w->f);
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_spatial_joint_spring *c = &m->joint_spring[i];
        fprintf(w->f, "%s{\"stiffness\": %.17g, \"damping\": %.17g, \"free\": %.17g", i + m->n_spring ? ", " : "", c->stiffness,
                c->damping, counts_backwards(w, c->measure.index) ? -c->free : c->free);
        put_text(w, "joint", m->joint[c->measure.index].name);
        if (c->name[0])
            put_text(w, "name", c->name);
        fputs("}", w->f);
    }
    fputs("], \"tracers\": [", w->f);
    for (int i = 0; i < m->n_tracer; i++) {
        fputs(i ? ", {\"name\": " : "{\"name\": ", w->f);
        put_string(w, m->tracer[i].name);
        put_text(w, "link", m->body[m->tracer[i].link].name);
        put_vec(w, "at", m->tracer[i].at);
        fputs("}", w->f);
    }
    fputs("]", w->f);
    if (lw_v3_norm(m->gravity) > 0)
        put_vec(w, "gravity", m->gravity);
}

lw_status lw_spatial_in_plane(const lw_spatial *m, lw_model *p, lw_error *e)
{
    plane w = { .m = m };
    char *text = NULL;
    size_t size = 0;
    if (!lw_spatial_is_planar(m, &w.normal))
        return lw_error_set(e, LW_E_KIND, "%s", m->n_elastic > 0 ? "elastic links bend out of their plane, too: write them in a planar model"
                            : "the model does not move in a plane: it has no hinge, hinges that are not parallel, a slide along them, or other joints");
    lw_vec3 n = w.normal;                    /* along z, x or y rather than against them */
    double most = fabs(n.z) >= fabs(n.x) && fabs(n.z) >= fabs(n.y) ? n.z : fabs(n.x) >= fabs(n.y) ? n.x : n.y;
    w.normal = n = most < 0 ? lw_v3_scale(n, -1) : n;
    w.x = most == n.z || most == -n.z ? lw_v3(1, 0, 0) : fabs(n.x) >= fabs(n.y) ? lw_v3(0, 1, 0) : lw_v3(0, 0, 1);
    w.x = lw_v3_sub(w.x, lw_v3_scale(n, lw_v3_dot(n, w.x)));
    w.x = lw_v3_scale(w.x, 1/lw_v3_norm(w.x));
    w.y = lw_v3_cross(n, w.x);
    const char *more = beyond(&w, 1e-9*lw_spatial_size(m));
    if (more[0])
        return lw_error_set(e, LW_E_KIND, "the model has %s, which are not taken into the plane", more);
    w.f = open_memstream(&text, &size);
    if (!w.f)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    fputs("{\"linkwright\": 1", w.f);
    if (m->name[0])
        put_text(&w, "name", m->name);
    put_text(&w, "ground", m->body[m->ground].name);
    fputs(", \"links\": [", w.f);
    put_bodies(&w);
    fputs("], \"joints\": [", w.f);
    put_joints(&w);
    put_rest(&w);
    fputs("}\n", w.f);
    bool bad = ferror(w.f) != 0;
    bad = fclose(w.f) != 0 || bad;
    lw_status s = bad ? lw_error_set(e, LW_E_MEMORY, "out of memory") : lw_model_read(text, size, "the model in its plane", p, e);
    free(text);
    return s;
}
