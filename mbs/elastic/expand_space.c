/* mbs/elastic/expand_space.c - elastic links of a spatial model as chains of nodes. */
#include "mbs/elastic/expand_space.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/elastic/beam_space.h"

typedef struct work {
    const lw_spatial     *m;
    lw_spatial_expansion *x;
    lw_elastic_axis      *axis;      /* per chain */
} work;

/* Places of the link at which something acts: joints, tracers, ends of springs, forces. */
static lw_status find_places(const lw_spatial *m, int link, lw_elastic_places *p, lw_error *e)
{
    *p = (lw_elastic_places){ .at = calloc((size_t)(m->n_joint + m->n_tracer + 2*m->n_spring + m->n_force) + 1, sizeof *p->at) };
    if (!p->at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int j = 0; j < m->n_joint; j++)
        if (m->joint[j].link[0] == link || m->joint[j].link[1] == link)
            p->at[p->n++] = m->joint[j].at;
    p->n_joint = p->n;
    for (int i = 0; i < m->n_tracer; i++)
        if (m->tracer[i].link == link)
            p->at[p->n++] = m->tracer[i].at;
    for (int i = 0; i < m->n_force; i++)
        if (m->force[i].link == link && (m->force[i].force[0] || m->force[i].force[1] || m->force[i].force[2]))
            p->at[p->n++] = m->force[i].at;
    for (int i = 0; i < m->n_spring; i++)
        for (int end = 0; end < 2; end++)
            if (m->spring[i].link[end] == link)
                p->at[p->n++] = m->spring[i].at[end];
    return LW_OK;
}

static lw_status plan_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    lw_elastic_axis *a = &w->axis[chain];
    lw_elastic_places at;
    lw_status s = find_places(w->m, c->link, &at, e);
    if (s == LW_OK)
        s = lw_elastic_axis_make(c->elastic, w->m->body[c->link].name, &at, a, e);
    free(at.at);
    return s == LW_OK ? lw_elastic_chain_take(c, a, e) : s;
}

/* A copy of n entries, with room for `more`; never NULL but without memory. */
static void *copy(const void *from, int n, int more, size_t size)
{
    void *to = calloc((size_t)(n + more) + 1, size);
    if (to && n > 0)
        memcpy(to, from, (size_t)n*size);
    return to;
}

/* The expanded model: links grow, what refers to them is copied, the rest is shared. */
static lw_status reserve(work *w, int nodes, int beams, lw_error *e)
{
    const lw_spatial *m = w->m;
    lw_spatial *to = &w->x->model;
    *to = *m;
    to->n_elastic = 0, to->elastic = NULL;
    to->body = copy(m->body, m->n_link, nodes, sizeof *m->body);
    to->joint = copy(m->joint, m->n_joint, 0, sizeof *m->joint);
    to->tracer = copy(m->tracer, m->n_tracer, 0, sizeof *m->tracer);
    to->spring = copy(m->spring, m->n_spring, 0, sizeof *m->spring);
    to->force = copy(m->force, m->n_force, 0, sizeof *m->force);
    to->beam = copy(NULL, 0, beams, sizeof *to->beam);
    to->states.rotor = copy(m->states.rotor, m->states.n_rotor, 0, sizeof *m->states.rotor);
    return to->body && to->joint && to->tracer && to->spring && to->force && to->beam && to->states.rotor
         ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* Axes of an element from `a` to `b`: x along it, y in the plane of the height. */
static lw_status element_axes(const work *w, const lw_elastic_chain *c, lw_vec3 along, lw_mat3 *out, lw_error *e)
{
    static const double least = 1e-6;            /* sine of the angle between height and axis */
    lw_vec3 height = c->elastic->height;
    if (!(lw_v3_norm(height) > 0))
        height = lw_v3_across(along);            /* all directions are alike */
    lw_vec3 z = lw_v3_cross(along, height);
    if (!(lw_v3_norm(z) > least))
        return lw_error_set(e, LW_E_ARG, "the \"height\" of the elastic link \"%s\" lies along its axis; give a direction across it",
                            w->m->body[c->link].name);
    z = lw_v3_scale(z, 1/lw_v3_norm(z));
    *out = lw_m3_columns(along, lw_v3_cross(z, along), z);
    return LW_OK;
}

/* Add a diagonal tensor in the given axes. */
static void add_inertia(lw_spatial_body *b, const lw_mat3 *axes, const double value[3])
{
    static const int at[6][2] = { { 0, 0 }, { 1, 1 }, { 2, 2 }, { 0, 1 }, { 0, 2 }, { 1, 2 } };
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 3; k++) {
            lw_vec3 c = lw_m3_column(axes, k);
            const double x[3] = { c.x, c.y, c.z };
            b->inertia[i] += value[k]*x[at[i][0]]*x[at[i][1]];
        }
}

static lw_status fill_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    const lw_elastic *p = c->elastic;
    const lw_section *q = &p->section;
    lw_spatial *to = &w->x->model;
    c->first_beam = to->n_beam;
    for (int i = 0; i < c->n_node; i++) {
        int link = i ? to->n_link++ : c->link;
        c->node[i] = link;
        to->body[link] = (lw_spatial_body){ .given = true,
                                            .centre = lw_elastic_axis_point(&w->axis[chain], w->axis[chain].node[i]) };
        if (snprintf(to->body[link].name, LW_NAME_SIZE, "%s.%d", w->m->body[c->link].name, i) >= LW_NAME_SIZE)
            return lw_error_set(e, LW_E_ARG, "the name of the elastic link \"%s\" is too long: its nodes are called \"NAME.0\", "
                                "\"NAME.1\", ...; at most %d bytes", w->m->body[c->link].name, LW_NAME_SIZE - 7);
    }
    for (int i = 0; i + 1 < c->n_node; i++) {
        lw_spatial_beam *b = &to->beam[to->n_beam++];
        lw_vec3 d = lw_v3_sub(to->body[c->node[i + 1]].centre, to->body[c->node[i]].centre);
        double h = lw_v3_norm(d), line = p->material.density*h;
        *b = (lw_spatial_beam){ .link = { c->node[i], c->node[i + 1] }, .length = h, .damping = p->damping, .mass = line*q->area,
                                .gyration = { q->iy/q->area, q->iz/q->area }, .consistent = p->consistent };
        lw_status s = element_axes(w, c, lw_v3_scale(d, 1/h), &b->axes, e);
        if (s != LW_OK)
            return s;
        lw_beam_space_stiffness(q, &p->material, h, b->stiffness);
        const double inertia[3] = { 0.5*line*(q->iy + q->iz), 0.5*line*q->iy, 0.5*line*q->iz };
        for (int end = 0; end < 2; end++) {
            to->body[b->link[end]].mass += 0.5*b->mass;
            add_inertia(&to->body[b->link[end]], &b->axes, inertia);
        }
    }
    return LW_OK;
}

/* The node of an elastic link nearest along the axis to `at`; other links stay. */
static int node_for(const work *w, int link, lw_vec3 at)
{
    for (int k = 0; k < w->x->n_chain; k++)
        if (w->x->chain[k].link == link)
            return w->x->chain[k].node[lw_elastic_axis_node(&w->axis[k], at)];
    return link;
}

static void attach(work *w)
{
    lw_spatial *to = &w->x->model;
    for (int i = 0; i < to->states.n_rotor; i++)
        to->states.rotor[i].link = node_for(w, to->states.rotor[i].link, to->joint[to->states.rotor[i].joint].at);
    for (int j = 0; j < to->n_joint; j++)
        for (int end = 0; end < 2; end++)
            to->joint[j].link[end] = node_for(w, to->joint[j].link[end], to->joint[j].at);
    for (int i = 0; i < to->n_tracer; i++)
        to->tracer[i].link = node_for(w, to->tracer[i].link, to->tracer[i].at);
    for (int i = 0; i < to->n_force; i++)
        to->force[i].link = node_for(w, to->force[i].link, to->force[i].at);
    for (int i = 0; i < to->n_spring; i++)
        for (int end = 0; end < 2; end++)
            to->spring[i].link[end] = node_for(w, to->spring[i].link[end], to->spring[i].at[end]);
}

lw_status lw_spatial_expand(const lw_spatial *m, lw_spatial_expansion *x, lw_error *e)
{
    size_t n = (size_t)m->n_elastic + 1;
    *x = (lw_spatial_expansion){ .chain = calloc(n, sizeof *x->chain) };
    work w = { m, x, calloc(n, sizeof *w.axis) };
    int more = 0;
    lw_status s = x->chain && w.axis ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int l = 0; s == LW_OK && l < m->n_link; l++) {
        if (!m->elastic[l].given)
            continue;
        x->chain[x->n_chain].link = l;
        x->chain[x->n_chain].elastic = &m->elastic[l];
        s = plan_chain(&w, x->n_chain++, e);
        more += x->chain[x->n_chain - 1].n_node - 1;
    }
    if (s == LW_OK)
        s = reserve(&w, more, more, e);
    for (int k = 0; s == LW_OK && k < x->n_chain; k++)
        s = fill_chain(&w, k, e);
    if (s == LW_OK)
        attach(&w);
    for (int k = 0; w.axis && k < m->n_elastic; k++)
        free(w.axis[k].node);
    free(w.axis);
    return s;
}

void lw_spatial_expansion_free(lw_spatial_expansion *x)
{
    for (int k = 0; x->chain && k < x->n_chain; k++)
        free(x->chain[k].node);
    void *const own[] = { x->chain, x->model.body, x->model.joint, x->model.tracer, x->model.spring, x->model.force,
                          x->model.beam, x->model.states.rotor };
    for (size_t i = 0; i < sizeof own/sizeof *own; i++)
        free(own[i]);
    memset(x, 0, sizeof *x);
}

/* ---- rigid ----------------------------------------------------------------------------------------------- */

/* Each element is a uniform bar. */
static void join(const lw_spatial_expansion *x, const lw_elastic_chain *c, lw_spatial_body *b)
{
    const lw_spatial *m = &x->model;
    char name[LW_NAME_SIZE];
    memcpy(name, b->name, sizeof name);
    *b = (lw_spatial_body){ .given = true };
    memcpy(b->name, name, sizeof name);
    for (int i = 0; i + 1 < c->n_node; i++) {
        const lw_spatial_beam *beam = &m->beam[c->first_beam + i];
        lw_vec3 middle = lw_v3_scale(lw_v3_add(m->body[beam->link[0]].centre, m->body[beam->link[1]].centre), 0.5);
        b->mass += beam->mass;
        b->centre = lw_v3_add(b->centre, lw_v3_scale(middle, beam->mass));
    }
    b->centre = lw_v3_scale(b->centre, 1/b->mass);
    for (int i = 0; i + 1 < c->n_node; i++) {
        const lw_spatial_beam *beam = &m->beam[c->first_beam + i];
        lw_vec3 middle = lw_v3_scale(lw_v3_add(m->body[beam->link[0]].centre, m->body[beam->link[1]].centre), 0.5);
        lw_vec3 d = lw_v3_sub(middle, b->centre);
        double length = beam->length*beam->length/12, iy = beam->gyration[0], iz = beam->gyration[1];
        const double own[3] = { beam->mass*(iy + iz), beam->mass*(length + iy), beam->mass*(length + iz) };
        add_inertia(b, &beam->axes, own);
        const double far[6] = { d.y*d.y + d.z*d.z, d.x*d.x + d.z*d.z, d.x*d.x + d.y*d.y, -d.x*d.y, -d.x*d.z, -d.y*d.z };
        for (int k = 0; k < 6; k++)
            b->inertia[k] += beam->mass*far[k];
    }
}

lw_status lw_spatial_rigid(const lw_spatial *m, lw_spatial *rigid, lw_error *e)
{
    lw_spatial_expansion x;
    *rigid = *m;
    rigid->n_elastic = 0, rigid->elastic = NULL;
    rigid->body = copy(m->body, m->n_link, 0, sizeof *m->body);
    if (!rigid->body)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = lw_spatial_expand(m, &x, e);
    for (int k = 0; s == LW_OK && k < x.n_chain; k++)
        join(&x, &x.chain[k], &rigid->body[x.chain[k].link]);
    lw_spatial_expansion_free(&x);
    if (s != LW_OK)
        lw_spatial_rigid_free(rigid);
    return s;
}

void lw_spatial_rigid_free(lw_spatial *rigid)
{
    free(rigid->body);
    memset(rigid, 0, sizeof *rigid);
}
