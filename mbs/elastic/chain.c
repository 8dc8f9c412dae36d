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

int lw_elastic_modal_nodes(const lw_elastic *p) { return p->modes/(p->plane ? 3 : 6); }

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

lw_status lw_elastic_line_on_nodes(const char *force, const char *link, lw_error *e)
{
    return lw_error_set(e, LW_E_ARG, "the force \"%s\" along a line acts on the elastic link \"%s\", of which only nodes are known; give forces at its "
                        "nodes", force, link);
}

lw_status lw_elastic_chain_take(lw_elastic_chain *c, const lw_elastic_axis *a, lw_error *e)
{
    c->length = a->length;
    c->mass = c->elastic->material.density*c->elastic->section.area*a->length;
    c->first = a->first;
    c->frequency = a->frequency;
    c->n_node = c->n_bound = a->n_node;
    c->node = calloc((size_t)a->n_node, sizeof *c->node);
    return c->node ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}
