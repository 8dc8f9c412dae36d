#include "enumerate/derive.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "enumerate/symmetry.h"
#include "grammar/topology/growth.h"
#include "grammar/topology/planar.h"

lw_derive lw_derive_default(int n_link)
{
    return (lw_derive){ .n_link = n_link, .rule = { false, true, true, true, true }, .kinds = "r",
                        .regions = true };
}

/* ---- forwards ---------------------------------------------------------------------------------- */

/* The forms found with one number of links. */
typedef struct level { size_t n, room; lw_mechanism *form; } level;

typedef struct growth { const lw_derive *how; level at[LW_LINK_MAX + 1]; } growth;

static int by_bytes(const void *a, const void *b) { return memcmp(a, b, sizeof(lw_mechanism)); }

static lw_status test_planar(const lw_mechanism *m, bool *planar)
{
    lw_chain c;
    lw_mechanism_chain(m, &c);
    return lw_planar_chain(&c, planar);
}

/* Sort and keep each form once. */
static void prune(level *l)
{
    size_t n = 0;
    if (l->n == 0)
        return;
    qsort(l->form, l->n, sizeof *l->form, by_bytes);
    for (size_t i = 0; i < l->n; i++)
        if (n == 0 || by_bytes(&l->form[n - 1], &l->form[i]) != 0)
            l->form[n++] = l->form[i];
    l->n = n;
}

static lw_status keep(growth *g, const lw_mechanism *m)
{
    level *l = &g->at[m->n_link];
    bool planar = true;
    lw_status s = g->how->regions ? test_planar(m, &planar) : LW_OK;
    if (s != LW_OK || !planar)
        return s;
    if (l->n == l->room)
        prune(l);
    if (2*l->n >= l->room) {
        size_t room = 2*l->room + 64;
        if (g->how->max_bytes > 0 && (double)(room*sizeof *l->form) > g->how->max_bytes)
            return LW_E_MEMORY;
        lw_mechanism *form = realloc(l->form, room*sizeof *form);
        if (!form)
            return LW_E_MEMORY;
        l->form = form;
        l->room = room;
    }
    memset(&l->form[l->n], 0, sizeof *l->form);
    return lw_mechanism_canonical(m, &l->form[l->n++]);
}

/* The production with every choice of its k's. */
static lw_status with_kinds(growth *g, const lw_mechanism *from, lw_production p)
{
    int n_kind = (int)strlen(g->how->kinds), n = lw_rule_kinds(p.rule), n_way = 1;
    lw_status s = LW_OK;
    for (int i = 0; i < n; i++)
        n_way *= n_kind;
    for (int way = 0; way < n_way && s == LW_OK; way++) {
        lw_mechanism grown = *from;
        if (g->how->stop && *g->how->stop)
            return LW_STOPPED;
        for (int i = 0, left = way; i < n && i < 4; i++, left /= n_kind)
            p.kind[i] = g->how->kinds[left % n_kind];
        if ((s = lw_mechanism_grow(&grown, &p)) == LW_OK)
            s = keep(g, &grown);
    }
    return s;
}

/* Apply a rule at all pairs X, Y.  Rule 4 read from Y to X is rule 4 with its k's reversed, so X < Y suffices for
 * it. */
static lw_status everywhere(growth *g, const lw_mechanism *from, int rule)
{
    lw_production p = lw_production_of(rule);
    lw_status s = LW_OK;
    for (int x = 1; x <= from->n_link; x++)
        for (int y = 1; y <= from->n_link && s == LW_OK; y++) {
            p.x = (uint8_t)x;
            p.y = (uint8_t)y;
            if (x < y || (x > y && rule == 3))
                s = with_kinds(g, from, p);
        }
    return s;
}

/* All forms with n links, from those with fewer. */
static lw_status fill(growth *g, int n)
{
    const lw_mechanism none = { 0 };
    lw_status s = LW_OK;
    for (int rule = 1; rule <= 4 && s == LW_OK; rule++) {
        int before = n - lw_rule_links(rule);
        if (!g->how->rule[rule] || before < 0)
            continue;
        if (rule <= 2 && before == 0)
            s = with_kinds(g, &none, lw_production_of(rule));
        for (size_t i = 0; rule > 2 && i < g->at[before].n && s == LW_OK; i++) {
            lw_mechanism from = g->at[before].form[i];
            s = everywhere(g, &from, rule);
        }
    }
    prune(&g->at[n]);
    return s;
}

/* Do the forms with all links fit into the memory, as far as the levels up to n show? The factor from level to level
 * grows with the number of links, so that the last one gives a lower bound. Levels may be empty: rule 4 adds two links.
 */
static bool fits(const growth *g, int n)
{
    enum { SURE = 1000 };
    for (int step = 1; step <= 2 && g->how->max_bytes > 0; step++) {
        double now = (double)g->at[n].n, before = n > step ? (double)g->at[n - step].n : 0;
        if (before < SURE || now < before)
            continue;
        double last = now*pow(now/before, (g->how->n_link - n)/step);
        return 2*last*sizeof(lw_mechanism) <= g->how->max_bytes;
    }
    return true;
}

lw_status lw_derive_each(const lw_derive *how, lw_mechanism_visit *visit, void *context)
{
    growth g = { .how = how };
    lw_status s = LW_OK;
    size_t n_kind = strlen(how->kinds);
    if (how->n_link < 1 || how->n_link > LW_LINK_MAX || n_kind < 1 || n_kind > 2
        || strspn(how->kinds, "rt") != n_kind || how->kinds[0] == how->kinds[1])
        return LW_E_ARG;
    for (int n = 3; n <= how->n_link && s == LW_OK; n++)
        if ((s = fill(&g, n)) == LW_OK && !fits(&g, n))
            s = LW_E_MEMORY;
    for (size_t i = 0; i < g.at[how->n_link].n && s == LW_OK; i++)
        s = visit(context, &g.at[how->n_link].form[i]);
    for (int n = 0; n <= LW_LINK_MAX; n++)
        free(g.at[n].form);
    return s;
}

/* ---- backwards --------------------------------------------------------------------------------- */

static lw_status cover(void *context, const lw_chain_item *item)
{
    lw_coverage *c = context;
    lw_mechanism m;
    lw_growth g;
    lw_reach reach;
    lw_status s = lw_mechanism_from_chain(item->chain, &m);
    if (s == LW_OK)
        s = lw_growth_find(&m, &g, &reach, NULL, NULL);
    if (s != LW_OK)
        return s;
    c->n_chain++;
    c->n_reached += reach == LW_REACHED || reach == LW_REACHED_NO_REGIONS;
    c->n_reached_by_regions += reach == LW_REACHED;
    bool planar = reach == LW_REACHED;
    if (reach == LW_NOT_CORE)
        s = test_planar(&m, &planar);
    c->n_planar += planar;
    return s;
}

static bool goes_on(void *stop, double done)
{
    (void)done;
    return !*(const volatile int *)stop;
}

lw_status lw_coverage_count(int n_link, int n_thread, const volatile int *stop, lw_coverage *coverage, lw_error *e)
{
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    *coverage = (lw_coverage){ 0 };
    lw_status s = lw_chains_create(n_link, 1, n_thread, &chains, e);
    if (s != LW_OK)
        return s;
    how.n_thread = n_thread;
    how.tick = stop ? goes_on : NULL;
    how.tick_context = (void *)(uintptr_t)stop;
    s = lw_chains_each(chains, &how, cover, coverage);
    lw_chains_free(chains);
    return s;
}
