#include "mbs/elastic/expand.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/elastic/beam.h"

static double add_bending(double tension, double bending) { return tension < 0 ? tension - bending : tension + bending; }

double lw_section_stress(const lw_section *s, double normal, double moment)
{
    if (!(s->y > 0))
        return NAN;
    return add_bending(normal/s->area, fabs(moment)*s->y/s->iz);
}

double lw_section_stress_space(const lw_section *s, double normal, double about_y, double about_z)
{
    if (!(s->y > 0 && s->z > 0))
        return NAN;
    double y = fabs(about_y)*s->z/s->iy, z = fabs(about_z)*s->y/s->iz;
    return add_bending(normal/s->area, s->round ? hypot(y, z) : y + z);
}

/* ---- model ---------------------------------------------------------------------------------------------- */

typedef struct work {
    const lw_model *m;
    lw_elastic_expansion *x;
    lw_elastic_axis *axis;           /* per chain */
} work;

static void take(lw_elastic_places *p, lw_vec2 at) { p->at[p->n++] = lw_v3(at.x, at.y, 0); }

static lw_status find_places(const lw_model *m, int link, lw_elastic_places *p, lw_error *e)
{
    const lw_assembly *k = &m->linkage;
    *p = (lw_elastic_places){ .at = calloc(2*(size_t)(k->n_joint + k->n_tracer + 2*m->n_spring + m->n_force) + 2, sizeof *p->at) };
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

lw_status lw_expression_list_mix(lw_expression_list *list, const double weight[2], lw_expression *const of[2], lw_expression **x, lw_error *e)
{
    lw_expression **more = realloc(list->x, (size_t)(list->n + 1)*sizeof *more);
    if (!more)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    list->x = more;
    *x = NULL;
    lw_status s = lw_expression_mix(weight, of, x, e);
    list->x[list->n] = *x;
    list->n += s == LW_OK && *x;
    return s;
}

void lw_expression_list_free(lw_expression_list *list)
{
    for (int i = 0; i < list->n; i++)
        lw_expression_free(list->x[i]);
    free(list->x);
}

int lw_elastic_chain_of(const lw_elastic_chain *chain, int n, int link)
{
    int k = 0;
    while (k < n && chain[k].link != link)
        k++;
    return k;
}

lw_status lw_elastic_line_off_axis(const char *force, const char *link, lw_error *e)
{
    return lw_error_set(e, LW_E_ARG, "the line of the force \"%s\" is not on one straight part of the axis of the elastic link \"%s\"; give one "
                        "force for each part", force, link);
}

lw_status lw_elastic_chain_take(lw_elastic_chain *c, const lw_elastic_axis *a, lw_error *e)
{
    c->length = a->length;
    c->mass = c->elastic->material.density*c->elastic->section.area*a->length;
    c->first = a->first;
    c->frequency = a->frequency;
    c->n_node = a->n_node;
    c->node = calloc((size_t)a->n_node, sizeof *c->node);
    return c->node ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

static lw_status plan_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    lw_elastic_axis *a = &w->axis[chain];
    lw_elastic_places at;
    lw_status s = find_places(w->m, c->link, &at, e);
    if (s == LW_OK)
        s = lw_elastic_axis_make(c->elastic, w->m->linkage.link_name[c->link], &at, a, e);
    free(at.at);
    return s == LW_OK ? lw_elastic_chain_take(c, a, e) : s;
}

/* Arrays of the expanded model: links grow, joints, tracers and loads are copied. */
static lw_status reserve(work *w, int links, int beams, lw_error *e)
{
    const lw_model *m = w->m;
    lw_model *to = &w->x->model;
    lw_status s = lw_assembly_copy(&m->linkage, &to->linkage);
    size_t n = (size_t)links + 1, springs = (size_t)m->n_spring + 1, forces = (size_t)m->n_force + 1;
    for (int i = 0; i < m->n_force; i++)
        forces += m->force[i].line == LW_LINE_EVEN || m->force[i].line == LW_LINE_VARYING ? 4*(size_t)beams : 0;
    char (*names)[LW_NAME_SIZE] = s == LW_OK ? calloc(n, sizeof *names) : NULL;
    to->body = calloc(n, sizeof *to->body);
    to->elastic = calloc(n, sizeof *to->elastic);
    to->beam = calloc((size_t)beams + 1, sizeof *to->beam);
    to->spring = calloc(springs, sizeof *to->spring);
    to->force = calloc(forces, sizeof *to->force);
    to->states.rotor = calloc((size_t)m->states.n_rotor + 1, sizeof *to->states.rotor);
    if (!names || !to->body || !to->elastic || !to->beam || !to->spring || !to->force || !to->states.rotor) {
        free(names);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    memcpy(names, m->linkage.link_name, (size_t)m->linkage.n_link*sizeof *names);
    memcpy(to->body, m->body, (size_t)m->linkage.n_link*sizeof *to->body);
    if (m->n_spring)
        memcpy(to->spring, m->spring, (size_t)m->n_spring*sizeof *to->spring);
    if (m->states.n_rotor)
        memcpy(to->states.rotor, m->states.rotor, (size_t)m->states.n_rotor*sizeof *to->states.rotor);
    free(to->linkage.link_name);
    to->linkage.has_nodes = true;
    to->linkage.link_name = names;
    return LW_OK;
}

/* The parts that the expanded model shares with the other. */
static void share(const lw_model *m, lw_model *to)
{
    to->motion = m->motion, to->has_speed = m->has_speed, to->speed = m->speed;
    to->gravity = m->gravity;
    to->n_spring = m->n_spring, to->n_joint_spring = m->n_joint_spring, to->n_motor = m->n_motor;
    to->joint_spring = m->joint_spring, to->motor = m->motor;
    to->states.n_state = m->states.n_state, to->states.n_signal = m->states.n_signal, to->states.n_rotor = m->states.n_rotor;
    to->states.state = m->states.state, to->states.signal = m->states.signal;
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
    c->first_beam = to->n_beam;
    for (int i = 0; i < c->n_node; i++) {
        int link = i ? to->linkage.n_link++ : c->link;
        c->node[i] = link;
        lw_vec3 at = lw_elastic_axis_point(&w->axis[chain], w->axis[chain].node[i]);
        to->body[link] = (lw_body){ .given = true, .centre = { at.x, at.y } };
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
    /* 2/n^2 for n elements in line: lumps at the ends of each instead of a uniform bar */
    double sum = 0, first[2] = { 0 }, second = 0;
    for (int i = 0; i + 1 < c->n_node; i++) {
        const lw_beam *b = &to->beam[c->first_beam + i];
        lw_vec2 at = lw_v2_sub(lw_v2_scale(lw_v2_add(to->body[b->link[0]].centre, to->body[b->link[1]].centre), 0.5), to->body[c->node[0]].centre);
        sum += b->mass, first[0] += b->mass*at.x, first[1] += b->mass*at.y;
        second += b->mass*(lw_v2_dot(at, at) + b->length*b->length/12 + b->gyration);
        c->too_much += b->mass*b->length*b->length/6;
    }
    c->too_much /= second - (first[0]*first[0] + first[1]*first[1])/sum;
    return LW_OK;
}

/* The node of an elastic link nearest along the axis to `at`; other links stay. */
static int node_for(const work *w, int link, lw_vec2 at)
{
    int k = lw_elastic_chain_of(w->x->chain, w->x->n_chain, link);
    return k < w->x->n_chain ? w->x->chain[k].node[lw_elastic_axis_node(&w->axis[k], lw_v3(at.x, at.y, 0))] : link;
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
    for (int i = 0; i < to->states.n_rotor; i++)
        to->states.rotor[i].link = node_for(w, to->states.rotor[i].link, k->joint[to->states.rotor[i].joint].at);
    for (int i = 0; i < to->n_force; i++)
        if (!to->force[i].part)
            to->force[i].link = node_for(w, to->force[i].link, to->force[i].at);
    for (int i = 0; i < to->n_spring; i++)
        for (int end = 0; end < 2; end++)
            to->spring[i].link[end] = node_for(w, to->spring[i].link[end], to->spring[i].at[end]);
}

/* Forces of a line load on the nodes of its link; other forces are copied. */
static lw_status spread_force(work *w, int *i, lw_error *e)
{
    const lw_force *p = &w->m->force[*i];
    lw_model *to = &w->x->model;
    int chain = lw_elastic_chain_of(w->x->chain, w->x->n_chain, p->link);
    if (p->line == LW_LINE_NONE || chain == w->x->n_chain) {
        to->force[to->n_force++] = *p;
        return LW_OK;
    }
    const lw_elastic_chain *c = &w->x->chain[chain];
    lw_vec3 end[2] = { lw_v3(p->at.x, p->at.y, 0), lw_v3(p[1].at.x, p[1].at.y, 0) };
    lw_elastic_push push[4];
    lw_status s = LW_OK;
    for (int k = 0; s == LW_OK && k + 1 < c->n_node; k++) {
        int n = lw_elastic_line_pushes(&w->axis[chain], k, end[0], end[1], p->line == LW_LINE_VARYING, push);
        if (n < 0)
            return lw_elastic_line_off_axis(p->name, w->m->linkage.link_name[c->link], e);
        for (int j = 0; s == LW_OK && j < n; j++) {
            lw_force *f = &to->force[to->n_force++];
            *f = *p;
            f->link = c->node[k + 2*j/n], f->at = lw_v2(push[j].place.x, push[j].place.y), f->part = 1 + c->first_beam + k;
            f->fx = f->fy = NULL;
            if ((s = lw_expression_list_mix(&w->x->own, push[j].weight, (lw_expression *[]){ p->fx, p[1].fx }, &f->fx, e)) == LW_OK)
                s = lw_expression_list_mix(&w->x->own, push[j].weight, (lw_expression *[]){ p->fy, p[1].fy }, &f->fy, e);
        }
    }
    ++*i;
    return s;
}

lw_status lw_elastic_expand(const lw_model *m, lw_elastic_expansion *x, lw_error *e)
{
    size_t n = (size_t)m->n_elastic + 1;
    *x = (lw_elastic_expansion){ .chain = calloc(n, sizeof *x->chain) };
    work w = { m, x, calloc(n, sizeof *w.axis) };
    int links = m->linkage.n_link, beams = 0;
    lw_status s = x->chain && w.axis ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
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
    for (int i = 0; s == LW_OK && i < m->n_force; i++)
        s = spread_force(&w, &i, e);
    if (s == LW_OK)
        attach(&w);
    for (int k = 0; w.axis && k < m->n_elastic; k++)
        free(w.axis[k].node);
    free(w.axis);
    return s;
}

void lw_elastic_expansion_free(lw_elastic_expansion *x)
{
    for (int k = 0; x->chain && k < x->n_chain; k++)
        free(x->chain[k].node);
    void *const own[] = { x->chain, x->model.body, x->model.elastic, x->model.beam, x->model.spring, x->model.force,
                          x->model.states.rotor };
    for (size_t i = 0; i < sizeof own/sizeof *own; i++)
        free(own[i]);
    lw_assembly_free(&x->model.linkage);
    lw_expression_list_free(&x->own);
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
