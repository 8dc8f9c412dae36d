#include "mbs/elastic/expand.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/elastic/beam.h"

double lw_section_stress(const lw_section *s, double normal, double moment)
{
    double bending = fabs(moment)*s->y/s->iz, tension = normal/s->area;
    return tension < 0 ? tension - bending : tension + bending;
}

/* ---- axis ------------------------------------------------------------------------------------------- */

static const double on_line = 1e-9;              /* distance from the axis, over its length, that counts as 0 */
static const double same_place = 1e-6;           /* nodes nearer than this, over the length, are one */

/* Places of the link at which something acts: joints, tracers, ends of springs, forces. */
typedef struct places { int n, n_joint; lw_vec2 *at; } places;

static void take(places *p, lw_vec2 at) { p->at[p->n++] = at; }

static lw_status find_places(const lw_model *m, int link, places *p, lw_error *e)
{
    const lw_assembly *k = &m->linkage;
    *p = (places){ .at = calloc(2*(size_t)(k->n_joint + k->n_tracer + 2*m->n_spring + m->n_force) + 2, sizeof *p->at) };
    if (!p->at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].link[0] == link || k->joint[j].link[1] == link)
            take(p, k->joint[j].at);
    p->n_joint = p->n;
    for (int i = 0; i < k->n_tracer; i++)
        if (k->tracer[i].link == link)
            take(p, k->tracer[i].at);
    for (int i = 0; i < m->n_force; i++)
        if (m->force[i].link == link && (m->force[i].fx || m->force[i].fy))
            take(p, m->force[i].at);
    for (int i = 0; i < m->n_spring; i++)
        for (int end = 0; end < 2; end++)
            if (m->spring[i].link[end] == link)
                take(p, m->spring[i].at[end]);
    return LW_OK;
}

/* The two of n places that are farthest apart. */
static double farthest(const lw_vec2 *at, int n, lw_vec2 end[2])
{
    double most = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            double d = lw_v2_norm(lw_v2_sub(at[i], at[j]));
            if (d > most) {
                most = d;
                end[0] = at[j];
                end[1] = at[i];
            }
        }
    return most;
}

/* Without an axis in the file: the line through the joints, or from the only joint to the farthest place, as far as places
 * lie on it. */
static lw_status default_axis(const lw_model *m, int link, const places *p, lw_vec2 end[2], lw_error *e)
{
    const char *name = m->linkage.link_name[link];
    lw_vec2 line[2];
    double size = farthest(p->at, p->n_joint, line);
    if (!(size > 0))
        size = farthest(p->at, p->n, line);
    if (!(size > 0))
        return lw_error_set(e, LW_E_ARG, "the elastic link \"%s\" has no length: all its joints and tracers are at one place; put "
                            "a tracer at its other end, or give its \"axis\" as a list of points", name);
    lw_vec2 u = lw_v2_scale(lw_v2_sub(line[1], line[0]), 1/size);
    double least = 0, most = size;
    for (int i = 0; i < p->n; i++) {
        lw_vec2 d = lw_v2_sub(p->at[i], line[0]);
        bool off = fabs(lw_v2_cross(u, d)) > on_line*size;
        if (off && i < p->n_joint)
            return lw_error_set(e, LW_E_ARG, "the joints of the elastic link \"%s\" do not lie on one line; give its \"axis\" as a "
                                "list of points: bars between them carry joints beside them on rigid arms", name);
        least = off ? least : fmin(least, lw_v2_dot(u, d));
        most = off ? most : fmax(most, lw_v2_dot(u, d));
    }
    end[0] = lw_v2_add(line[0], lw_v2_scale(u, least));
    end[1] = least == 0 && most == size ? line[1] : lw_v2_add(line[0], lw_v2_scale(u, most));
    return LW_OK;
}

/* Distance along the axis of its point nearest to `at`. */
static double along(const lw_vec2 *axis, int n, lw_vec2 at)
{
    double best = INFINITY, found = 0, before = 0;
    for (int i = 0; i + 1 < n; i++) {
        lw_vec2 d = lw_v2_sub(axis[i + 1], axis[i]);
        double length = lw_v2_norm(d), s = fmin(fmax(lw_v2_dot(lw_v2_sub(at, axis[i]), d)/length, 0), length);
        double off = lw_v2_segment_distance(at, axis[i], axis[i + 1]);
        if (off < best) {
            best = off;
            found = before + s;
        }
        before += length;
    }
    return found;
}

static lw_vec2 point_at(const lw_vec2 *axis, int n, double s)
{
    for (int i = 0; i + 1 < n; i++) {
        lw_vec2 d = lw_v2_sub(axis[i + 1], axis[i]);
        double length = lw_v2_norm(d);
        if (s <= length || i + 2 == n)
            return s >= length ? axis[i + 1] : lw_v2_add(axis[i], lw_v2_scale(d, s/length));
        s -= length;
    }
    return axis[0];
}

/* ---- number of elements -------------------------------------------------------------------------------- */

/* Longest element times wave number for errors below 1 %: of a lumped chain in bending (a cantilever's first mode, whose
 * error 0.129 (wave number h)^2 is the greatest), of a consistent one, and of a lumped chain in tension. */
static const double lumped_bend = 0.277, consistent_bend = 1.2, lumped_stretch = 0.48;

/* Wave numbers [1/m] of bending (Timoshenko) and of stretch at the angular frequency w. */
static double wave_number(const lw_elastic *p, double w, bool bend)
{
    double a = p->material.density/p->material.e, b = p->material.density*p->section.zeta_y/p->material.g;
    if (!bend)
        return w*sqrt(a);
    double c = 4*p->material.density*p->section.area/(p->material.e*p->section.iz*w*w);
    return w*sqrt(0.5*(a + b + sqrt((a - b)*(a - b) + c)));
}

static int elements_for(const lw_elastic *p, double length, double frequency)
{
    double w = 2*LW_PI*frequency, bend = wave_number(p, w, true)*length, stretch = wave_number(p, w, false)*length;
    double n = p->consistent ? fmax(bend/consistent_bend, stretch/lumped_stretch)
                             : fmax(bend/lumped_bend, stretch/lumped_stretch);
    return (int)fmin(fmax(ceil(n), 2), 10000);
}

/* ---- nodes ---------------------------------------------------------------------------------------------- */

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

typedef struct cut { double *s; int n; } cut;     /* nodes by their distance along the axis */

/* Nodes at the corners of the axis and at the places of joints and loads; between them elements of about equal length, n in
 * all unless places do not fit that. */
static lw_status cut_axis(const lw_vec2 *axis, int n_axis, const places *p, double length, int n, cut *c, lw_error *e)
{
    size_t most = (size_t)(n_axis + p->n), all = 2*most + (size_t)n + 2;
    double *hard = calloc(most + 1, sizeof *hard);
    c->s = calloc(all, sizeof *c->s);
    if (!hard || !c->s) {
        free(hard);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    int n_hard = 0;
    double sum = 0;
    for (int i = 0; i < n_axis; i++) {
        sum += i ? lw_v2_norm(lw_v2_sub(axis[i], axis[i - 1])) : 0;
        hard[n_hard++] = i + 1 == n_axis ? length : sum;
    }
    for (int i = 0; i < p->n; i++)
        hard[n_hard++] = along(axis, n_axis, p->at[i]);
    qsort(hard, (size_t)n_hard, sizeof *hard, by_value);
    c->s[c->n++] = 0;
    for (int i = 1; i < n_hard; i++) {
        double from = c->s[c->n - 1], gap = hard[i] - from;
        if (gap <= same_place*length)
            continue;
        int parts = (int)fmax(ceil(n*gap/length - 1e-6), 1);
        for (int k = 1; k <= parts; k++)
            c->s[c->n++] = k == parts ? hard[i] : from + gap*k/parts;
    }
    free(hard);
    return LW_OK;
}

/* ---- model ---------------------------------------------------------------------------------------------- */

typedef struct work {
    const lw_model *m;
    lw_elastic_expansion   *x;
    cut            *cut;             /* per chain */
    lw_vec2       (*axis)[2];        /* axes that the file does not give */
} work;

static const lw_vec2 *axis_of(const work *w, int chain, int *n)
{
    const lw_elastic *p = &w->m->elastic[w->x->chain[chain].link];
    *n = p->n_axis ? p->n_axis : 2;
    return p->n_axis ? p->axis : w->axis[chain];
}

static lw_status plan_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    const lw_elastic *p = &w->m->elastic[c->link];
    places at;
    int n_axis;
    lw_status s = find_places(w->m, c->link, &at, e);
    if (s == LW_OK && !p->n_axis)
        s = default_axis(w->m, c->link, &at, w->axis[chain], e);
    const lw_vec2 *axis = axis_of(w, chain, &n_axis);
    for (int i = 0; i + 1 < n_axis; i++)
        c->length += lw_v2_norm(lw_v2_sub(axis[i + 1], axis[i]));
    c->mass = p->material.density*p->section.area*c->length;
    c->first = LW_PI/(2*c->length*c->length)*sqrt(p->material.e*p->section.iz/(p->material.density*p->section.area));
    c->frequency = p->segments ? 0 : p->frequency > 0 ? p->frequency : c->first;
    int n = p->segments ? p->segments : s == LW_OK ? elements_for(p, c->length, c->frequency) : 1;
    if (s == LW_OK)
        s = cut_axis(axis, n_axis, &at, c->length, n, &w->cut[chain], e);
    free(at.at);
    c->n_node = w->cut[chain].n;
    if (s == LW_OK && !(c->node = calloc((size_t)c->n_node, sizeof *c->node)))
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    return s;
}

/* Arrays of the expanded model: links grow, joints, tracers and loads are copied. */
static lw_status reserve(work *w, int links, int beams, lw_error *e)
{
    const lw_model *m = w->m;
    lw_model *to = &w->x->model;
    lw_status s = lw_assembly_copy(&m->linkage, &to->linkage);
    size_t n = (size_t)links + 1, springs = (size_t)m->n_spring + 1, forces = (size_t)m->n_force + 1;
    char (*names)[LW_NAME_SIZE] = s == LW_OK ? calloc(n, sizeof *names) : NULL;
    to->body = calloc(n, sizeof *to->body);
    to->elastic = calloc(n, sizeof *to->elastic);
    to->beam = calloc((size_t)beams + 1, sizeof *to->beam);
    to->spring = calloc(springs, sizeof *to->spring);
    to->force = calloc(forces, sizeof *to->force);
    to->rotor = calloc((size_t)m->n_rotor + 1, sizeof *to->rotor);
    if (!names || !to->body || !to->elastic || !to->beam || !to->spring || !to->force || !to->rotor) {
        free(names);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    memcpy(names, m->linkage.link_name, (size_t)m->linkage.n_link*sizeof *names);
    memcpy(to->body, m->body, (size_t)m->linkage.n_link*sizeof *to->body);
    if (m->n_spring)
        memcpy(to->spring, m->spring, (size_t)m->n_spring*sizeof *to->spring);
    if (m->n_force)
        memcpy(to->force, m->force, (size_t)m->n_force*sizeof *to->force);
    if (m->n_rotor)
        memcpy(to->rotor, m->rotor, (size_t)m->n_rotor*sizeof *to->rotor);
    free(to->linkage.link_name);
    to->linkage.has_nodes = true;
    to->linkage.link_name = names;
    return LW_OK;
}

/* What the expanded model shares with the other. */
static void share(const lw_model *m, lw_model *to)
{
    to->motion = m->motion, to->has_speed = m->has_speed, to->speed = m->speed;
    to->gravity = m->gravity;
    to->n_spring = m->n_spring, to->n_joint_spring = m->n_joint_spring, to->n_force = m->n_force, to->n_motor = m->n_motor;
    to->joint_spring = m->joint_spring, to->motor = m->motor;
    to->n_state = m->n_state, to->n_signal = m->n_signal, to->n_rotor = m->n_rotor;
    to->state = m->state, to->signal = m->signal;
    to->friction = m->friction, to->stop = m->stop, to->clearance = m->clearance;
}

static void add_mass(lw_body *b, double mass, double inertia)
{
    b->given = true;
    b->mass += mass;
    b->inertia += inertia;
}

static lw_status fill_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    const lw_elastic *p = &w->m->elastic[c->link];
    lw_model *to = &w->x->model;
    const char *name = w->m->linkage.link_name[c->link];
    int n_axis;
    const lw_vec2 *axis = axis_of(w, chain, &n_axis);
    c->first_beam = to->n_beam;
    for (int i = 0; i < c->n_node; i++) {
        int link = i ? to->linkage.n_link++ : c->link;
        c->node[i] = link;
        to->body[link] = (lw_body){ .given = true, .centre = point_at(axis, n_axis, w->cut[chain].s[i]) };
        if (snprintf(to->linkage.link_name[link], LW_NAME_SIZE, "%s.%d", name, i) >= LW_NAME_SIZE)
            return lw_error_set(e, LW_E_ARG, "the name of the elastic link \"%s\" is too long: its nodes are called \"NAME.0\", "
                                "\"NAME.1\", ...; at most %d bytes", name, LW_NAME_SIZE - 7);
    }
    for (int i = 0; i + 1 < c->n_node; i++) {
        lw_beam *b = &to->beam[to->n_beam++];
        lw_vec2 d = lw_v2_sub(to->body[c->node[i + 1]].centre, to->body[c->node[i]].centre);
        double h = lw_v2_norm(d), mass = p->material.density*p->section.area*h, i_over_a = p->section.iz/p->section.area;
        *b = (lw_beam){ .link = { c->node[i], c->node[i + 1] }, .length = h, .direction = atan2(d.y, d.x),
                        .damping = p->damping, .mass = mass, .consistent = p->consistent, .gyration = i_over_a };
        lw_beam_stiffness(&p->section, &p->material, h, b->stiffness);
        for (int end = 0; end < 2; end++)
            add_mass(&to->body[b->link[end]], 0.5*mass, 0.5*mass*i_over_a);
    }
    return LW_OK;
}

/* The node of an elastic link nearest along the axis to `at`; other links stay. */
static int node_for(const work *w, int link, lw_vec2 at)
{
    for (int k = 0; k < w->x->n_chain; k++) {
        int n_axis, best = 0;
        const lw_elastic_chain *c = &w->x->chain[k];
        if (c->link != link)
            continue;
        const lw_vec2 *axis = axis_of(w, k, &n_axis);
        double s = along(axis, n_axis, at);
        for (int i = 1; i < c->n_node; i++)
            best = fabs(w->cut[k].s[i] - s) < fabs(w->cut[k].s[best] - s) ? i : best;
        return c->node[best];
    }
    return link;
}

static void attach(work *w)
{
    lw_model *to = &w->x->model;
    lw_assembly *k = &to->linkage;
    for (int j = 0; j < k->n_joint; j++)
        for (int end = 0; end < 2; end++)
            k->joint[j].link[end] = node_for(w, k->joint[j].link[end], k->joint[j].at);
    for (int i = 0; i < k->n_tracer; i++)
        k->tracer[i].link = node_for(w, k->tracer[i].link, k->tracer[i].at);
    for (int i = 0; i < to->n_rotor; i++)
        to->rotor[i].link = node_for(w, to->rotor[i].link, k->joint[to->rotor[i].joint].at);
    for (int i = 0; i < to->n_force; i++)
        to->force[i].link = node_for(w, to->force[i].link, to->force[i].at);
    for (int i = 0; i < to->n_spring; i++)
        for (int end = 0; end < 2; end++)
            to->spring[i].link[end] = node_for(w, to->spring[i].link[end], to->spring[i].at[end]);
}

lw_status lw_elastic_expand(const lw_model *m, lw_elastic_expansion *x, lw_error *e)
{
    size_t n = (size_t)m->n_elastic + 1;
    *x = (lw_elastic_expansion){ .chain = calloc(n, sizeof *x->chain) };
    work w = { m, x, calloc(n, sizeof *w.cut), calloc(n, sizeof *w.axis) };
    int links = m->linkage.n_link, beams = 0;
    lw_status s = x->chain && w.cut && w.axis ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int l = 0; s == LW_OK && l < m->linkage.n_link; l++) {
        if (!m->elastic[l].given)
            continue;
        x->chain[x->n_chain].link = l;
        x->chain[x->n_chain].elastic = &m->elastic[l];
        s = plan_chain(&w, x->n_chain++, e);
        links += x->chain[x->n_chain - 1].n_node - 1;
        beams += x->chain[x->n_chain - 1].n_node - 1;
    }
    if (s == LW_OK)
        s = reserve(&w, links, beams, e);
    if (s == LW_OK)
        share(m, &x->model);
    for (int k = 0; s == LW_OK && k < x->n_chain; k++)
        s = fill_chain(&w, k, e);
    if (s == LW_OK)
        attach(&w);
    for (int k = 0; w.cut && k < m->n_elastic; k++)
        free(w.cut[k].s);
    free(w.cut);
    free(w.axis);
    return s;
}

void lw_elastic_expansion_free(lw_elastic_expansion *x)
{
    for (int k = 0; x->chain && k < x->n_chain; k++)
        free(x->chain[k].node);
    void *const own[] = { x->chain, x->model.body, x->model.elastic, x->model.beam, x->model.spring, x->model.force,
                          x->model.rotor };
    for (size_t i = 0; i < sizeof own/sizeof *own; i++)
        free(own[i]);
    lw_assembly_free(&x->model.linkage);
    memset(x, 0, sizeof *x);
}

/* ---- rigid ----------------------------------------------------------------------------------------------- */

lw_status lw_elastic_rigid(const lw_model *m, lw_model *rigid, lw_error *e)
{
    lw_elastic_expansion x;
    *rigid = *m;
    rigid->n_elastic = 0;
    rigid->body = calloc((size_t)m->linkage.n_link + 1, sizeof *rigid->body);
    if (!rigid->body)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    memcpy(rigid->body, m->body, (size_t)m->linkage.n_link*sizeof *rigid->body);
    lw_status s = lw_elastic_expand(m, &x, e);
    for (int k = 0; s == LW_OK && k < x.n_chain; k++) {
        lw_body *b = &rigid->body[x.chain[k].link];
        *b = (lw_body){ .given = true };
        for (int i = 0; i + 1 < x.chain[k].n_node; i++) {          /* each element is a uniform bar */
            const lw_beam *beam = &x.model.beam[x.chain[k].first_beam + i];
            lw_vec2 a = x.model.body[beam->link[0]].centre, c = x.model.body[beam->link[1]].centre;
            lw_vec2 middle = lw_v2_scale(lw_v2_add(a, c), 0.5);
            b->mass += beam->mass;
            b->centre = lw_v2_add(b->centre, lw_v2_scale(middle, beam->mass));
            b->inertia += beam->mass*(beam->length*beam->length/12 + beam->gyration + lw_v2_dot(middle, middle));
        }
        b->centre = lw_v2_scale(b->centre, 1/b->mass);
        b->inertia -= b->mass*lw_v2_dot(b->centre, b->centre);
    }
    lw_elastic_expansion_free(&x);
    if (s != LW_OK)
        lw_elastic_rigid_free(rigid);
    return s;
}

void lw_elastic_rigid_free(lw_model *rigid)
{
    free(rigid->body);
    memset(rigid, 0, sizeof *rigid);
}
