/* enumerate/filter.c - see filter.h. */
#include <string.h>
#include "enumerate/canon.h"
#include "enumerate/filter.h"
#include "grammar/topology/planar.h"

/* Binary links and parallel lines do not affect planarity. */
static lw_status structure_planar(const lw_structure *s, bool *keep)
{
    uint32_t row[LW_CIRCLE_MAX];
    lw_structure_rows(s, row);
    return lw_planar_test(s->n_circle, row, keep);
}

static lw_status chain_not_planar(const lw_chain *c, bool *keep)
{
    bool planar = false;
    lw_status status = lw_planar_chain(c, &planar);
    *keep = !planar;
    return status;
}

static lw_status structure_not_planar(const lw_structure *s, bool *keep)
{
    bool planar = false;
    lw_status status = structure_planar(s, &planar);
    *keep = !planar;
    return status;
}

static lw_status chain_asymmetric(const lw_chain *c, bool *keep)
{
    lw_graph g;
    lw_symmetry_group group;
    lw_graph_of_chain(c, &g);
    lw_status status = lw_graph_group(&g, &group);
    *keep = group.n_generator == 0;
    lw_symmetry_group_free(&group);
    return status;
}

static lw_status chain_no_dyad(const lw_chain *c, bool *keep)
{
    *keep = true;
    for (int i = 0; i < c->n_link; i++)
        for (uint32_t rest = lw_chain_neighbours(c, i); rest && lw_chain_degree(c, i) == 2; rest &= rest - 1)
            if (lw_chain_degree(c, __builtin_ctz(rest)) == 2)
                *keep = false;
    return LW_OK;
}

static lw_status chain_every(const lw_chain *c, bool *keep)
{
    (void)c;
    *keep = true;
    return LW_OK;
}

static lw_status structure_every(const lw_structure *s, bool *keep)
{
    (void)s;
    *keep = true;
    return LW_OK;
}

const lw_filter lw_filters[] = {
    { "planar",     lw_planar_chain,  structure_planar     },    /* the graph can be drawn without crossings */
    { "non-planar", chain_not_planar, structure_not_planar },
    { "asymmetric", chain_asymmetric, NULL                 },    /* no two links are alike */
    { "no-dyad",    chain_no_dyad,    NULL                 },    /* no two binary links in a row: rules 1 to 4 of paper F cannot make it last */
    { "every",      chain_every,      NULL                 },    /* counted one by one, without Burnside's lemma */
    { "distinct",   chain_every,      NULL                 },    /* counted one by one, each compared with all others of its structure */
    { "generating", chain_every,      structure_every      },    /* only chains with symmetries are counted, generating functions give the others */
    { NULL, NULL, NULL }
};

const lw_filter *lw_filter_find(const char *name)
{
    for (const lw_filter *f = lw_filters; f->name; f++)
        if (strcmp(f->name, name) == 0)
            return f;
    return NULL;
}
