#include "mbs/elastic/expand.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/elastic/beam.h"
#include "mbs/elastic/expand_space.h"
#include "mbs/elastic/superelement.h"

/* ---- model ---------------------------------------------------------------------------------------------- */

typedef struct work {
    const lw_model *m;
    lw_elastic_expansion *x;
    lw_spatial_expansion *condensed; /* per chain: the link alone, as a model in space */
    bool in_time;
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
    lw_elastic_take_loads(link, m->n_force, m->force, m->n_spring, m->spring, p);
    return LW_OK;
}

/* A condensed link alone, as a model in space that is fixed where something acts on it.  Its section is as stiff in both directions; what the link
 * does across the plane is not used. */
static lw_status condense(work *w, int chain, const lw_elastic_places *at, lw_error *e)
{
    const lw_model *m = w->m;
    const lw_elastic_chain *c = &w->x->chain[chain];
    lw_elastic elastic[2] = { { .given = false }, *c->elastic };
    lw_section *q = &elastic[1].section;
    q->iy = q->iz, q->zeta_z = q->zeta_y, q->it = 2*q->iz, q->gyration_y = q->gyration_z;               /* y across the plane */
    elastic[1].height = lw_v3(0, 0, 1);
    lw_spatial_body body[2] = { { .given = false } };
    lw_spatial_joint *joint = calloc((size_t)at->n + 1, sizeof *joint);
    lw_spatial_tracer *tracer = calloc((size_t)at->n + 1, sizeof *tracer);
    lw_force *force = calloc((size_t)m->n_force + 1, sizeof *force);
    lw_spatial alone = { .n_link = 2, .body = body, .elastic = elastic, .n_elastic = 2, .n_joint = at->n_joint, .joint = joint, .n_tracer = at->n - at->n_joint,
                         .tracer = tracer, .n_force = m->n_force, .force = force };
    memcpy(body[1].name, c->name, sizeof body[1].name);
    for (int i = 0; joint && i < at->n_joint; i++)
        joint[i] = (lw_spatial_joint){ .kind = LW_SPATIAL_FIXED, .link = { 0, 1 }, .at = at->at[i] };
    for (int i = at->n_joint; tracer && i < at->n; i++)
        tracer[i - at->n_joint] = (lw_spatial_tracer){ .link = 1, .at = at->at[i] };
    for (int i = 0; force && i < m->n_force; i++)                            /* nodes under line loads stay */
        force[i] = (lw_force){ .link = m->force[i].link == c->link, .at = m->force[i].at, .line = m->force[i].line };
    lw_status s = joint && tracer && force ? lw_spatial_expand(&alone, w->in_time, &w->condensed[chain], e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    free(joint), free(tracer), free(force);
    return s;
}

/* The nodes of a condensed link are those of the model in space; its axis keeps the nodes that are among them. */
static lw_status take_nodes(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    lw_elastic_chain *from = w->condensed[chain].chain;
    lw_elastic_axis *a = &c->axis;
    int n = 0;
    c->condensed = true;
    c->length = from->length, c->mass = from->mass, c->first = from->first, c->frequency = from->frequency;
    c->n_node = from->n_node, c->n_bound = from->n_bound;
    c->keep = from->keep, from->keep = NULL;
    c->node = calloc((size_t)c->n_node, sizeof *c->node);
    for (int i = 0; i < a->n_node; i++)
        for (int k = 0; k < from->n_node; k++)
            if (lw_v3_norm(lw_v3_sub(lw_elastic_axis_point(a, a->node[i]), w->condensed[chain].model.body[from->node[k]].centre)) < 1e-9*a->length) {
                a->node[n++] = a->node[i];
                break;
            }
    a->n_node = n;
    return c->node ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

static lw_status plan_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    lw_elastic_axis *a = &c->axis;
    lw_elastic_places at;
    bool condensed = c->elastic->pieces > 0 || c->elastic->n_node > 0 || (w->in_time && c->elastic->consistent);
    lw_status s = find_places(w->m, c->link, &at, e);
    if (s == LW_OK && c->elastic->n_node == 0)
        s = lw_elastic_axis_make(c->elastic, c->name, &at, a, e);
    if (s == LW_OK && condensed)
        s = condense(w, chain, &at, e);
    free(at.at);
    return s != LW_OK ? s : condensed ? take_nodes(w, chain, e) : lw_elastic_chain_take(c, e);
}

/* Arrays of the expanded model: links grow, joints, tracers and loads are copied. */
static lw_status reserve(work *w, int links, int beams, int supers, lw_error *e)
{
    const lw_model *m = w->m;
    lw_model *to = &w->x->model;
    lw_status s = lw_assembly_copy(&m->linkage, &to->linkage);
    size_t n = (size_t)links + 1, springs = (size_t)m->n_spring + 1, forces = (size_t)lw_elastic_spread_room(m->n_force, m->force, beams) + 1;
    char (*names)[LW_NAME_SIZE] = s == LW_OK ? calloc(n, sizeof *names) : NULL;
    to->body = calloc(n, sizeof *to->body);
    to->elastic = calloc(n, sizeof *to->elastic);
    to->beam = calloc((size_t)beams + 1, sizeof *to->beam);
    to->super = calloc((size_t)supers + 1, sizeof *to->super);
    to->spring = calloc(springs, sizeof *to->spring);
    to->force = calloc(forces, sizeof *to->force);
    to->states.rotor = calloc((size_t)m->states.n_rotor + 1, sizeof *to->states.rotor);
    if (!names || !to->body || !to->elastic || !to->beam || !to->super || !to->spring || !to->force || !to->states.rotor) {
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
    to->n_shape = m->n_shape, to->shape = m->shape;
    to->n_contact = m->n_contact, to->contact = m->contact;
    to->n_rope = m->n_rope, to->rope = m->rope;
}

static void add_mass(lw_body *b, double mass, double inertia)
{
    b->given = true;
    b->mass += mass;
    b->inertia += inertia;
}

/* Take the masses of the nodes of a condensed link, and its superelements. */
static void fill_condensed(work *w, int chain)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    lw_spatial *from = &w->condensed[chain].model;
    const int *node = w->condensed[chain].chain->node;
    lw_model *to = &w->x->model;
    c->first_beam = to->n_super;
    for (int i = 0; i < c->n_node; i++)
        add_mass(&to->body[c->node[i]], from->body[node[i]].mass, from->body[node[i]].inertia[2]);
    for (int k = 0; k < from->n_super; k++) {
        lw_superelement *p = &to->super[to->n_super++];
        *p = from->super[k];
        for (int i = 0; i < p->n; i++) {
            int at = 0;
            while (node[at] != p->link[i])
                at++;
            p->link[i] = c->node[at];
        }
    }
    from->n_super = 0;
}

static lw_status fill_chain(work *w, int chain, lw_error *e)
{
    lw_elastic_chain *c = &w->x->chain[chain];
    const lw_elastic *p = &w->m->elastic[c->link];
    lw_model *to = &w->x->model;
    const lw_spatial_expansion *alone = &w->condensed[chain];
    c->first_beam = to->n_beam;
    for (int i = 0; i < c->n_node; i++) {
        int link = i ? to->linkage.n_link++ : c->link;
        c->node[i] = link;
        lw_vec3 at = c->condensed ? alone->model.body[alone->chain->node[i]].centre : lw_elastic_axis_point(&c->axis, c->axis.node[i]);
        to->body[link] = (lw_body){ .given = true, .centre = { at.x, at.y } };
        if (snprintf(to->linkage.link_name[link], LW_NAME_SIZE, "%s.%d", c->name, i) >= LW_NAME_SIZE)
            return lw_error_set(e, LW_E_ARG, "the name of the elastic link \"%s\" is too long: its nodes are called \"NAME.0\", "
                                "\"NAME.1\", ...; at most %d bytes", c->name, LW_NAME_SIZE - 7);
    }
    if (c->condensed)
        return fill_condensed(w, chain), LW_OK;
    for (int i = 0; i + 1 < c->n_node; i++) {
        lw_beam *b = &to->beam[to->n_beam++];
        lw_vec2 d = lw_v2_sub(to->body[c->node[i + 1]].centre, to->body[c->node[i]].centre);
        double h = lw_v2_norm(d), mass = p->material.density*p->section.area*h, gyration = lw_section_mass_z(&p->section);
        *b = (lw_beam){ .link = { c->node[i], c->node[i + 1] }, .length = h, .direction = atan2(d.y, d.x),
                        .damping = p->damping, .mass = mass, .consistent = p->consistent, .gyration = gyration };
        lw_beam_stiffness(&p->section, &p->material, h, b->stiffness);
        for (int end = 0; end < 2; end++)
            add_mass(&to->body[b->link[end]], 0.5*mass, 0.5*mass*gyration);
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

static int node_for(const lw_elastic_expansion *x, int link, lw_vec2 at)
{
    return lw_elastic_chain_node(x->chain, x->n_chain, link, lw_v3(at.x, at.y, 0));
}

static void attach(lw_elastic_expansion *x)
{
    lw_model *to = &x->model;
    lw_assembly *k = &to->linkage;
    for (int j = 0; j < k->n_joint; j++)
        for (int end = 0; end < 2; end++)
            k->joint[j].link[end] = node_for(x, k->joint[j].link[end], k->joint[j].at);
    for (int i = 0; i < k->n_tracer; i++)
        k->tracer[i].link = node_for(x, k->tracer[i].link, k->tracer[i].at);
    for (int i = 0; i < to->states.n_rotor; i++)
        to->states.rotor[i].link = node_for(x, to->states.rotor[i].link, k->joint[to->states.rotor[i].joint].at);
    lw_elastic_attach(x->chain, x->n_chain, to->n_force, to->force, to->n_spring, to->spring);
}

lw_status lw_elastic_expand(const lw_model *m, bool in_time, lw_elastic_expansion *x, lw_error *e)
{
    size_t n = (size_t)m->n_elastic + 1;
    *x = (lw_elastic_expansion){ .chain = calloc(n, sizeof *x->chain) };
    work w = { m, x, calloc(n, sizeof *w.condensed), in_time };
    int links = m->linkage.n_link, beams = 0, supers = 0;
    lw_status s = x->chain && w.condensed ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int l = 0; s == LW_OK && l < m->linkage.n_link; l++) {
        if (!m->elastic[l].given)
            continue;
        x->chain[x->n_chain] = (lw_elastic_chain){ .link = l, .name = m->linkage.link_name[l], .elastic = &m->elastic[l] };
        s = plan_chain(&w, x->n_chain++, e);
        links += x->chain[x->n_chain - 1].n_node - 1;
        beams += x->chain[x->n_chain - 1].n_node - 1;
        supers += w.condensed[x->n_chain - 1].model.n_super;
    }
    if (s == LW_OK)
        s = reserve(&w, links, beams, supers, e);
    if (s == LW_OK)
        share(m, &x->model);
    for (int k = 0; s == LW_OK && k < x->n_chain; k++)
        s = fill_chain(&w, k, e);
    if (s == LW_OK)
        s = lw_elastic_spread(x->chain, x->n_chain, m->n_force, m->force, &x->own, x->model.force, &x->model.n_force, e);
    if (s == LW_OK)
        attach(x);
    for (int k = 0; w.condensed && k < m->n_elastic; k++)
        lw_spatial_expansion_free(&w.condensed[k]);
    free(w.condensed);
    return s;
}

void lw_elastic_expansion_free(lw_elastic_expansion *x)
{
    lw_elastic_chains_free(x->chain, x->n_chain);
    for (int k = 0; k < x->model.n_super; k++)
        lw_superelement_free(&x->model.super[k]);
    void *const own[] = { x->model.body, x->model.elastic, x->model.beam, x->model.super, x->model.spring, x->model.force,
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
    lw_model bars = *m;                      /* condensed bars count as what they are condensed from */
    bars.elastic = calloc((size_t)m->linkage.n_link + 1, sizeof *bars.elastic);
    if (!bars.elastic)
        return lw_elastic_rigid_free(rigid), lw_error_set(e, LW_E_MEMORY, "out of memory");
    memcpy(bars.elastic, m->elastic, (size_t)m->linkage.n_link*sizeof *bars.elastic);
    for (int i = 0; i < m->linkage.n_link; i++)
        bars.elastic[i].pieces = bars.elastic[i].modes = 0;
    lw_status s = lw_elastic_expand(&bars, false, &x, e);
    for (int k = 0; s == LW_OK && k < x.n_chain; k++) {
        lw_body *b = &rigid->body[x.chain[k].link];
        const lw_elastic *p = x.chain[k].elastic;
        *b = (lw_body){ .given = true };
        if (p->n_node > 0) {
            lw_vec3 centre;
            double inertia[6];
            lw_super_rigid_mass(p->n_node, p->node, p->mass, &b->mass, &centre, inertia);
            b->centre = lw_v2(centre.x, centre.y), b->inertia = inertia[2];
            continue;
        }
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
    free(bars.elastic);
    if (s != LW_OK)
        lw_elastic_rigid_free(rigid);
    return s;
}

void lw_elastic_rigid_free(lw_model *rigid)
{
    free(rigid->body);
    memset(rigid, 0, sizeof *rigid);
}
