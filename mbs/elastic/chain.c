/* mbs/elastic/chain.c - chains of nodes in the plane and in space. */
#include "mbs/elastic/chain.h"

#include <stdlib.h>
#include "base/real.h"
#include "grammar/model/model.h"

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

/* Make *x the mix of two expressions; the list owns it. */
static lw_status mix(lw_expression_list *list, const double weight[2], lw_expression *const of[2], lw_expression **x, lw_error *e)
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

int lw_elastic_modal_nodes(const lw_elastic *p) { return p->modes/(p->plane ? 3 : 6); }

/* Which of these n chains is that of the link; n: it is not elastic. */
static int chain_of(const lw_elastic_chain *chain, int n, int link)
{
    int k = 0;
    while (k < n && chain[k].link != link)
        k++;
    return k;
}

int lw_elastic_chain_node(const lw_elastic_chain *chain, int n, int link, lw_vec3 at)
{
    int k = chain_of(chain, n, link), best = 0;
    if (k == n)
        return link;
    const lw_elastic_chain *c = &chain[k];
    const lw_vec3 *node = c->elastic->node;
    if (c->elastic->n_node == 0)
        return c->node[lw_elastic_axis_node(&c->axis, at)];
    for (int i = 1; i < c->n_bound; i++)
        if (lw_v3_norm(lw_v3_sub(node[c->keep[i]], at)) < lw_v3_norm(lw_v3_sub(node[c->keep[best]], at)))
            best = i;
    return c->node[best];
}

void lw_elastic_take_loads(int link, int n_force, const lw_force *force, int n_spring, const lw_spring *spring, lw_elastic_places *p)
{
    for (int i = 0; i < n_force; i++)
        if (force[i].link == link && (force[i].force[0] || force[i].force[1] || force[i].force[2]))
            p->at[p->n++] = force[i].at;
    for (int i = 0; i < n_spring; i++)
        for (int end = 0; end < 2; end++)
            if (spring[i].link[end] == link)
                p->at[p->n++] = spring[i].at[end];
}

int lw_elastic_spread_room(int n_force, const lw_force *force, int n_beam)
{
    int room = n_force;
    for (int i = 0; i < n_force; i++)
        room += force[i].line == LW_LINE_EVEN || force[i].line == LW_LINE_VARYING ? 4*n_beam : 0;
    return room;
}

/* Put the line load that begins with p on the nodes of its link. */
static lw_status spread_line(const lw_elastic_chain *c, const lw_force *p, lw_expression_list *own, lw_force *to, int *n_to, lw_error *e)
{
    lw_elastic_push push[4];
    lw_status s = LW_OK;
    if (c->elastic->n_node > 0)
        return lw_error_set(e, LW_E_ARG, "the force \"%s\" along a line acts on the elastic link \"%s\", of which only nodes are known; give "
                            "forces at its nodes", p->name, c->name);
    for (int k = 0; s == LW_OK && k + 1 < c->n_bound; k++) {
        int n = lw_elastic_line_pushes(&c->axis, k, p->at, p[1].at, p->line == LW_LINE_VARYING, push);
        if (n < 0)
            return lw_error_set(e, LW_E_ARG, "the line of the force \"%s\" is not on one straight part of the axis of the elastic link \"%s\"; "
                                "give one force for each part", p->name, c->name);
        for (int j = 0; s == LW_OK && j < n; j++) {
            lw_force *f = &to[(*n_to)++];
            *f = *p;
            f->link = c->node[k + 2*j/n], f->at = push[j].place, f->part = 1 + c->first_beam + k;
            for (int x = 0; x < 3; x++)
                f->force[x] = NULL;
            for (int x = 0; s == LW_OK && x < 3; x++)
                s = mix(own, push[j].weight, (lw_expression *[]){ p->force[x], p[1].force[x] }, &f->force[x], e);
        }
    }
    return s;
}

lw_status lw_elastic_spread(const lw_elastic_chain *chain, int n, int n_force, const lw_force *force, lw_expression_list *own, lw_force *to,
                            int *n_to, lw_error *e)
{
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < n_force; i++) {
        int k = chain_of(chain, n, force[i].link);
        if (force[i].line == LW_LINE_NONE || k == n)
            to[(*n_to)++] = force[i];
        else
            s = spread_line(&chain[k], &force[i++], own, to, n_to, e);
    }
    return s;
}

void lw_elastic_attach(const lw_elastic_chain *chain, int n, int n_force, lw_force *force, int n_spring, lw_spring *spring)
{
    for (int i = 0; i < n_force; i++)
        if (!force[i].part)
            force[i].link = lw_elastic_chain_node(chain, n, force[i].link, force[i].at);
    for (int i = 0; i < n_spring; i++)
        for (int end = 0; end < 2; end++)
            spring[i].link[end] = lw_elastic_chain_node(chain, n, spring[i].link[end], spring[i].at[end]);
}

lw_status lw_elastic_chain_take(lw_elastic_chain *c, lw_error *e)
{
    const lw_elastic_axis *a = &c->axis;
    c->length = a->length;
    c->mass = c->elastic->material.density*c->elastic->section.area*a->length;
    c->first = a->first;
    c->frequency = a->frequency;
    c->n_node = c->n_bound = a->n_node;
    c->node = calloc((size_t)a->n_node, sizeof *c->node);
    return c->node ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

void lw_elastic_chains_free(lw_elastic_chain *chain, int n)
{
    for (int k = 0; chain && k < n; k++)
        free(chain[k].node), free(chain[k].axis.node), free(chain[k].keep);
    free(chain);
}
