#include "enumerate/multiple.h"
#include "enumerate/fractionated.h"

#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"

static int on_pin(const lw_multiple *m, int k) { return __builtin_popcount(m->pin[k]); }

/* ---- does it move ------------------------------------------------------------------------------ */

/* True if the chain is connected without the links in `gone` and without pin `lost` (or LW_NONE). */
static bool holds_together(const lw_multiple *m, uint32_t gone, int lost)
{
    uint32_t all = (uint32_t)(((uint64_t)1 << m->n_link) - 1) & ~gone, seen = all & -all;
    for (bool grown = true; grown;) {
        uint32_t before = seen;
        for (int k = 0; k < m->n_pin; k++)
            if (k != lost && m->pin[k] & seen)
                seen |= m->pin[k] & all;
        grown = seen != before;
    }
    return seen == all;
}

static bool is_whole(const lw_multiple *m)
{
    bool whole = holds_together(m, 0, LW_NONE);
    for (int i = 0; i < m->n_link && whole; i++)
        whole = holds_together(m, 1u << i, LW_NONE);
    for (int k = 0; k < m->n_pin && whole; k++)
        whole = holds_together(m, 0, k);
    return whole;
}

/* True if two links share two pins or a link has only one pin. */
static bool is_simple(const lw_multiple *m)
{
    int n_pin[LW_LINK_MAX] = { 0 };
    for (int k = 0; k < m->n_pin; k++) {
        for (int l = 0; l < k; l++)
            if (__builtin_popcount(m->pin[k] & m->pin[l]) > 1)
                return false;
        for (uint32_t s = m->pin[k]; s; s &= s - 1)
            n_pin[__builtin_ctz(s)]++;
    }
    for (int i = 0; i < m->n_link; i++)
        if (n_pin[i] < 2)
            return false;
    return true;
}

/* True if no choice of star centres for pins k, k + 1, ... gives a rigid chain; c has the stars of earlier pins. */
static bool is_free(const lw_multiple *m, int k, lw_chain *c)
{
    if (k == m->n_pin)
        return !lw_chain_rigid(c, false, NULL);
    for (uint32_t s = m->pin[k]; s; s &= s - 1) {
        int middle = __builtin_ctz(s);
        uint32_t others = m->pin[k] & ~(1u << middle);
        for (uint32_t o = others; o; o &= o - 1)
            lw_chain_join(c, middle, __builtin_ctz(o), 1);
        bool free_here = is_free(m, k + 1, c);
        for (uint32_t o = others; o; o &= o - 1)
            lw_chain_unjoin(c, middle, __builtin_ctz(o));
        if (!free_here || on_pin(m, k) == 2)             /* two links: both centres give the same star */
            return free_here;
    }
    return true;
}

static bool nothing_rigid(const lw_multiple *m)
{
    lw_chain c;
    return lw_chain_clear(&c, m->n_link) == LW_OK && is_simple(m) && is_free(m, 0, &c);
}

bool lw_multiple_moves(const lw_multiple *m) { return nothing_rigid(m) && is_whole(m); }

/* ---- canonical form ---------------------------------------------------------------------------- */

/* Links are vertices, and so are pins with more than two links, of another colour. */
static lw_status graph_of(const lw_multiple *m, lw_graph *g)
{
    memset(g, 0, sizeof *g);
    g->n = m->n_link;
    for (int k = 0; k < m->n_pin; k++) {
        int a = __builtin_ctz(m->pin[k]), b = 31 - __builtin_clz(m->pin[k]);
        if (on_pin(m, k) == 2) {
            g->tie[a][b] = g->tie[b][a] = 1;
            continue;
        }
        if (g->n == LW_GRAPH_MAX)
            return LW_E_ARG;
        g->colour[g->n] = 1;
        for (uint32_t s = m->pin[k]; s; s &= s - 1)
            g->tie[g->n][__builtin_ctz(s)] = g->tie[__builtin_ctz(s)][g->n] = 2;
        g->n++;
    }
    return LW_OK;
}

lw_status lw_multiple_canonical(const lw_multiple *m, lw_multiple *form)
{
    lw_graph g;
    uint8_t to[LW_GRAPH_MAX];
    lw_multiple out = { .n_link = m->n_link, .n_pin = m->n_pin };
    lw_status s = graph_of(m, &g);
    if (s == LW_OK)
        s = lw_graph_label(&g, to);
    if (s != LW_OK)
        return s;
    uint32_t above[LW_GRAPH_MAX] = { 0 };                  /* links that stand before a vertex */
    for (int i = 0; i < m->n_link; i++)
        for (int k = 0; k < m->n_link; k++)
            above[i] += to[k] < to[i];
    for (int k = 0; k < m->n_pin; k++)
        for (uint32_t left = m->pin[k]; left; left &= left - 1)
            out.pin[k] |= 1u << above[__builtin_ctz(left)];
    lw_multiple_sort(&out);
    *form = out;
    return LW_OK;
}

lw_status lw_multiple_symmetry(const lw_multiple *m, uint8_t *lowest, uint64_t *order)
{
    lw_graph g;
    uint8_t all[LW_GRAPH_MAX];               /* links, then pins */
    lw_status s = graph_of(m, &g);
    if (s == LW_OK)
        s = lw_graph_symmetry(&g, all, order);
    if (s == LW_OK)
        memcpy(lowest, all, (size_t)m->n_link);
    return s;
}

/* ---- all of them ------------------------------------------------------------------------------- */

/* Forms seen, in a table with open addresses, at most half full. */
typedef struct seen { size_t n, room; lw_multiple *form; } seen;

static uint64_t hash_of(const lw_multiple *m)
{
    uint64_t h = 14695981039346656037u;
    for (int k = 0; k < m->n_pin; k++)
        h = (h ^ m->pin[k])*1099511628211u;
    return h ^ h >> 29;
}

static lw_multiple *place_of(const seen *s, const lw_multiple *form)
{
    size_t at = hash_of(form) & (s->room - 1);
    while (s->form[at].n_link && memcmp(&s->form[at], form, sizeof *form) != 0)
        at = (at + 1) & (s->room - 1);
    return &s->form[at];
}

static lw_status make_room(seen *s)
{
    seen larger = { .n = s->n, .room = s->room ? 2*s->room : 1024 };
    if (2*s->n < s->room)
        return LW_OK;
    larger.form = calloc(larger.room, sizeof *larger.form);
    if (!larger.form)
        return LW_E_MEMORY;
    for (size_t i = 0; i < s->room; i++)
        if (s->form[i].n_link)
            *place_of(&larger, &s->form[i]) = s->form[i];
    free(s->form);
    *s = larger;
    return LW_OK;
}

typedef struct laying {
    seen               seen;
    bool               fractionated;                   /* wanted: those that separate, else the others */
    lw_multiple_visit *visit;
    void              *context;
} laying;

static lw_status offer(laying *l, const lw_multiple *m)
{
    lw_multiple form;
    if (on_pin(m, 0) == 2 || !is_simple(m) || is_whole(m) == l->fractionated)   /* not rigid: checked while merging */
        return LW_OK;
    lw_status s = make_room(&l->seen);
    if (s == LW_OK)
        s = lw_multiple_canonical(m, &form);
    if (s != LW_OK)
        return s;
    lw_multiple *place = place_of(&l->seen, &form);
    if (place->n_link)
        return LW_OK;
    *place = form;
    l->seen.n++;
    return l->visit(l->context, m);
}

/* The state of merging: pins made around links 0 .. at-1, and the joints that are still simple. */
typedef struct stage { lw_multiple pins; uint32_t left[LW_LINK_MAX]; } stage;

/* The pins, together with the joints that stayed simple. */
static lw_multiple whole_of(const stage *s)
{
    lw_multiple m = s->pins;
    for (int i = 0; i < m.n_link; i++)
        for (uint32_t rest = s->left[i] & ~((2u << i) - 1); rest; rest &= rest - 1)
            m.pin[m.n_pin++] = 1u << i | (rest & -rest);
    lw_multiple_sort(&m);
    return m;
}

/* Merge joints of link `at`: the lowest of `todo` with any set of the others, or alone.  A rigid chain stays rigid
 * when more joints are merged, so it is left at once. */
static lw_status lay(laying *l, const stage *s, int at, uint32_t todo)
{
    lw_status status = LW_OK;
    if (at == s->pins.n_link) {
        lw_multiple m = whole_of(s);
        return offer(l, &m);
    }
    if (!todo)
        return lay(l, s, at + 1, at + 1 < s->pins.n_link ? s->left[at + 1] : 0);
    uint32_t first = todo & -todo, others = todo & ~first, with = 0;
    do {                                                   /* every subset of the others, the empty one first */
        stage next = *s;
        if (with) {
            next.pins.pin[next.pins.n_pin++] = 1u << at | first | with;
            next.left[at] &= ~(first | with);
            for (uint32_t o = first | with; o; o &= o - 1)
                next.left[__builtin_ctz(o)] &= ~(1u << at);
            lw_multiple m = whole_of(&next);
            if (nothing_rigid(&m))
                status = lay(l, &next, at, others & ~with);
        } else {
            status = lay(l, &next, at, others);
        }
        with = (with - others) & others;
    } while (with && status == LW_OK);
    return status;
}

static lw_status lay_chain(laying *l, const lw_chain *chain)
{
    stage s = { .pins = { .n_link = chain->n_link } };
    if (lw_chain_count(chain, 1) > LW_JOINT_MAX)
        return LW_E_ARG;
    for (int i = 0; i < chain->n_link; i++)
        s.left[i] = lw_chain_neighbours(chain, i);
    return lay(l, &s, 0, s.left[0]);
}

static lw_status lay_item(void *context, const lw_chain_item *item) { return lay_chain(context, item->chain); }

static lw_status lay_fractionated(void *context, const lw_chain *chain, int n_bridge)
{
    (void)n_bridge;
    return lay_chain(context, chain);
}

static lw_status each(int n_link, int dof, int n_thread, laying l, lw_error *e)
{
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    lw_status s = lw_chains_create(n_link, dof, n_thread, &chains, e);
    if (s != LW_OK)
        return s;
    how.n_thread = n_thread;
    s = lw_chains_each(chains, &how, lay_item, &l);
    lw_chains_free(chains);
    if (s == LW_OK && l.fractionated)
        s = lw_fractionated_each(n_link, dof, lay_fractionated, &l, e);
    free(l.seen.form);
    return s;
}

lw_status lw_multiple_each(int n_link, int dof, int n_thread, lw_multiple_visit *visit, void *context, lw_error *e)
{
    return each(n_link, dof, n_thread, (laying){ .visit = visit, .context = context }, e);
}

lw_status lw_multiple_fractionated_each(int n_link, int dof, int n_thread, lw_multiple_visit *visit, void *context, lw_error *e)
{
    return each(n_link, dof, n_thread, (laying){ .fractionated = true, .visit = visit, .context = context }, e);
}
