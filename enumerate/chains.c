/* enumerate/chains.c - see chains.h: the set of structures, the walk over it, visiting, tables of counts. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"
#include "enumerate/chains_internal.h"
#include "enumerate/distinct.h"

lw_status lw_chains_create(int n_link, int dof, int n_thread, lw_chains **chains, lw_error *e)
{
    return lw_chains_create_while(n_link, dof, n_thread, NULL, NULL, NULL, chains, e);
}

/* A set without structures, and its numbers. */
static lw_status begin_chains(int n_link, int dof, lw_chains **made, lw_error *e)
{
    lw_numbers numbers;
    lw_status status = lw_numbers_for_links(n_link, dof, 0, &numbers, e);
    if (status != LW_OK)
        return status;
    *made = calloc(1, sizeof **made);
    if (!*made)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    (*made)->numbers = numbers;
    return LW_OK;
}

lw_status lw_chains_create_while(int n_link, int dof, int n_thread, const char *stored, lw_structures_tick *tick,
                                 void *context, lw_chains **chains, lw_error *e)
{
    lw_chains *made;
    lw_status status = begin_chains(n_link, dof, &made, e);
    if (status != LW_OK)
        return status;
    if (made->numbers.n_loop > 1)
        status = lw_structures_stored(stored, made->numbers.n_loop, n_thread, tick, context, &made->structures, e);
    if (status == LW_OK)
        *chains = made;
    else
        free(made);
    return status;
}

lw_status lw_chains_create_within(int n_link, int dof, int most_circles, int n_thread, lw_structures_tick *tick,
                                  void *context, lw_chains **chains, lw_error *e)
{
    lw_chains *made;
    lw_status status = begin_chains(n_link, dof, &made, e);
    if (status != LW_OK)
        return status;
    if (made->numbers.n_loop > 1)
        status = lw_structures_create_within(made->numbers.n_loop, most_circles, n_thread, tick, context, &made->structures);
    if (status == LW_OK) {
        *chains = made;
        return LW_OK;
    }
    free(made);
    return status == LW_STOPPED ? lw_error_set(e, status, "stopped while the structures were grown") : lw_graph_error(e, status);
}

void lw_chains_free(lw_chains *chains)
{
    if (chains)
        lw_structures_free(chains->structures);
    free(chains);
}

const lw_numbers *lw_chains_numbers(const lw_chains *chains) { return &chains->numbers; }
const lw_structures *lw_chains_structures(const lw_chains *chains) { return chains->structures; }

lw_chain_walk lw_chain_walk_default(void) { return (lw_chain_walk){ .n_part = 1 }; }

int lw_chain_item_orbits(const lw_chain_item *item, uint8_t *lowest)
{
    if (item->structure)
        return lw_weighting_orbits(item->weighting, item->weight, lowest);
    memset(lowest, 0, (size_t)item->chain->n_link);      /* all links of a ring are equivalent */
    return 1;
}

lw_status lw_walk_check(const lw_chain_walk *how)
{
    return how->n_part >= 1 && how->part >= 0 && how->part < how->n_part ? LW_OK : LW_E_ARG;
}

size_t lw_walk_size(const lw_chains *chains, const lw_chain_walk *how)
{
    size_t n = chains->structures ? lw_structures_count(chains->structures, chains->numbers.n_loop) : 1;
    size_t part = (size_t)how->part, n_part = (size_t)how->n_part;
    return n > part ? (n - part + n_part - 1)/n_part : 0;
}

/* The ring of a set with L = 1. */
static lw_chain the_ring(const lw_chains *chains)
{
    lw_chain ring;
    int n = chains->numbers.n_link;
    (void)lw_chain_clear(&ring, n);
    for (int i = 0; i < n; i++)
        (void)lw_chain_join(&ring, i, (i + 1) % n, 1);
    return ring;
}

/* Turns weightings into items and applies the filter. */
typedef struct relay {
    lw_chain_item   item;
    lw_chain        chain;
    lw_filter_chain *wanted;
    lw_chain_visit *visit;
    void           *context;
} relay;

static lw_status relay_weighting(void *context, const uint8_t *weight)
{
    relay *r = context;
    lw_status status = lw_structure_chain(r->item.structure, weight, &r->chain);
    bool keep = true;
    if (status == LW_OK && r->wanted)
        status = r->wanted(&r->chain, &keep);
    if (status != LW_OK || !keep)
        return status;
    r->item.weight = weight;
    return r->visit(r->context, &r->item);
}

lw_status lw_walk_structure(const lw_chains *chains, const lw_chain_walk *how, size_t k, lw_weighting *w,
                            lw_chain_visit *visit, void *context)
{
    const lw_filter *f = how->filter;
    bool keep = true;
    relay r = { .wanted = f && !f->structure ? f->chain : NULL, .visit = visit, .context = context };
    r.item = (lw_chain_item){ .chain = &r.chain, .index = lw_walk_index(how, k), .weighting = w };
    if (!chains->structures) {
        r.chain = the_ring(chains);
        lw_status asked = f ? f->chain(&r.chain, &keep) : LW_OK;
        return asked == LW_OK && keep ? visit(context, &r.item) : asked;
    }
    lw_structure s;
    lw_structures_get(chains->structures, chains->numbers.n_loop, r.item.index, &s);
    lw_status status = f && f->structure ? f->structure(&s, &keep) : LW_OK;
    if (status != LW_OK || !keep)
        return status;
    status = lw_weighting_prepare(w, &s, chains->numbers.dof);
    r.item.structure = lw_weighting_structure(w);
    return status == LW_OK ? lw_weighting_each(w, relay_weighting, &r) : status;
}

static lw_status tally_item(void *context, const lw_chain_item *item)
{
    lw_tally *tally = context;
    uint8_t lowest[LW_LINK_MAX];
    tally->n_chain++;
    tally->n_ground += (uint64_t)lw_chain_item_orbits(item, lowest);
    return LW_OK;
}

lw_status lw_walk_count(const lw_chains *chains, const lw_chain_walk *how, size_t k, lw_weighting *w, lw_tally *tally)
{
    const lw_filter *f = how->filter;
    *tally = (lw_tally){ 0, 0, 0 };
    bool distinct = f && strcmp(f->name, "distinct") == 0, generating = f && strcmp(f->name, "generating") == 0;
    uint64_t ring = 2*(uint64_t)chains->numbers.n_link;      /* symmetries of a polygon */
    if (!chains->structures && generating)
        return lw_labelled_forms(chains->numbers.n_link, ring, ring - 1, &tally->n_labelled);
    if (!chains->structures || (f && !f->structure && !distinct))
        return lw_walk_structure(chains, how, k, w, tally_item, tally);
    lw_structure s;
    lw_structures_get(chains->structures, chains->numbers.n_loop, lw_walk_index(how, k), &s);
    bool keep = true;
    lw_status status = f && !distinct ? f->structure(&s, &keep) : LW_OK;
    if (status != LW_OK || !keep)
        return status;
    status = lw_weighting_prepare(w, &s, chains->numbers.dof);
    return status != LW_OK ? status : distinct ? lw_distinct_count(w, tally)
         : generating ? lw_weighting_excess(w, tally) : lw_weighting_count(w, tally);
}

lw_status lw_walk_find_start(const lw_chains *chains, const lw_chain_walk *how, lw_walk_start *start)
{
    *start = (lw_walk_start){ 0, how->skip };
    if (how->skip == 0)
        return LW_OK;
    lw_weighting *w = lw_weighting_create();
    if (!w)
        return LW_E_MEMORY;
    lw_status status = LW_OK;
    for (size_t n = lw_walk_size(chains, how); start->structure < n && status == LW_OK; start->structure++) {
        lw_tally tally;
        status = lw_walk_count(chains, how, start->structure, w, &tally);
        if (start->skip < tally.n_chain)
            break;
        start->skip -= tally.n_chain;
    }
    lw_weighting_free(w);
    return status;
}

/* ---- visiting in the calling thread -------------------------------------------------------------- */

typedef struct skipping { uint64_t skip; lw_chain_visit *visit; void *context; } skipping;

static lw_status skip_front(void *context, const lw_chain_item *item)
{
    skipping *s = context;
    if (s->skip == 0)
        return s->visit(s->context, item);
    s->skip--;
    return LW_OK;
}

lw_status lw_chains_each(const lw_chains *chains, const lw_chain_walk *how, lw_chain_visit *visit, void *context)
{
    lw_walk_start start;
    lw_status status = lw_walk_check(how);
    if (status == LW_OK)
        status = lw_walk_find_start(chains, how, &start);
    lw_weighting *w = status == LW_OK ? lw_weighting_create() : NULL;
    if (!w)
        return status == LW_OK ? LW_E_MEMORY : status;
    skipping s = { start.skip, visit, context };
    size_t n = lw_walk_size(chains, how);
    for (size_t k = start.structure; k < n && status == LW_OK; k++) {
        status = lw_walk_structure(chains, how, k, w, skip_front, &s);
        if (status == LW_OK && how->tick && !how->tick(how->tick_context, (double)(k + 1)/(double)n))
            status = LW_STOPPED;
    }
    lw_weighting_free(w);
    return status;
}

/* ---- tables of counts ----------------------------------------------------------------------------- */

lw_status lw_chain_table_make(const lw_numbers *numbers, lw_chain_table *table)
{
    lw_assortment a;
    *table = (lw_chain_table){ .n_row = 0 };
    for (bool more = lw_assortment_first(numbers, &a); more; more = lw_assortment_next(numbers, &a))
        table->n_row++;
    table->row = calloc(table->n_row, sizeof *table->row);
    if (!table->row) {
        table->n_row = 0;
        return LW_E_MEMORY;
    }
    size_t k = 0;
    for (bool more = lw_assortment_first(numbers, &a); more; more = lw_assortment_next(numbers, &a))
        table->row[k++].links = a;
    return LW_OK;
}

void lw_chain_table_free(lw_chain_table *table)
{
    free(table->row);
    *table = (lw_chain_table){ .n_row = 0 };
}
