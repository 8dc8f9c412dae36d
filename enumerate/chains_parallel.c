/* enumerate/chains_parallel.c - see chains.h: printing and counting with threads.  A job is one structure or a block
 * of structures. */
#include <stdlib.h>
#include <string.h>
#include "base/parallel.h"
#include "enumerate/chains_internal.h"
#include "enumerate/labelled.h"

/* Data shared by the threads. */
typedef struct crew {
    const lw_chains     *chains;
    const lw_chain_walk *how;
    int                  n_thread;
    lw_weighting       **weighting;       /* (n_thread) scratch                        */
    size_t               size;            /* structures of the part                    */
    size_t               done;            /* structures finished; counts under `lock`  */
    pthread_mutex_t      lock;
    lw_status            status;          /* first that is not LW_OK; under `lock`     */
} crew;

static lw_status crew_open(crew *c, const lw_chains *chains, const lw_chain_walk *how)
{
    lw_status status = lw_walk_check(how);
    *c = (crew){ .chains = chains, .how = how };
    pthread_mutex_init(&c->lock, NULL);
    if (status != LW_OK)
        return status;
    c->size = lw_walk_size(chains, how);
    c->n_thread = how->n_thread < 1 ? lw_core_count() : how->n_thread;
    c->weighting = calloc((size_t)c->n_thread, sizeof(lw_weighting *));
    for (int k = 0; c->weighting && k < c->n_thread && status == LW_OK; k++)
        if (!(c->weighting[k] = lw_weighting_create()))
            status = LW_E_MEMORY;
    return c->weighting ? status : LW_E_MEMORY;
}

static void crew_close(crew *c)
{
    for (int k = 0; c->weighting && k < c->n_thread; k++)
        lw_weighting_free(c->weighting[k]);
    free(c->weighting);
    pthread_mutex_destroy(&c->lock);
}

/* Record that a job of n structures is finished; returns the status of all jobs. */
static lw_status crew_report(crew *c, size_t n, lw_status status)
{
    pthread_mutex_lock(&c->lock);
    c->done += n;
    if (c->status == LW_OK && status == LW_OK && c->how->tick && !c->how->tick(c->how->tick_context, (double)c->done/(double)c->size))
        status = LW_STOPPED;
    if (c->status == LW_OK)
        c->status = status;
    status = c->status;
    pthread_mutex_unlock(&c->lock);
    return status;
}

static bool crew_stopped(crew *c)
{
    pthread_mutex_lock(&c->lock);
    bool stopped = c->status != LW_OK;
    pthread_mutex_unlock(&c->lock);
    return stopped;
}

/* ---- printing ------------------------------------------------------------------------------------ */

typedef struct printing {
    crew            crew;
    lw_walk_start   start;
    size_t          most;
    lw_chain_print *print;
    void           *context;
    lw_ordered      out;
} printing;

typedef struct page { const printing *all; lw_ordered_part piece; uint64_t skip; } page;

static lw_status print_item(void *context, const lw_chain_item *item)
{
    page *p = context;
    if (p->skip > 0) {
        p->skip--;
        return LW_OK;
    }
    char *text = lw_piece_space(&p->piece, p->all->most);
    if (!text)
        return LW_STOPPED;                       /* the ordered output holds the reason */
    size_t length = 0;
    lw_status status = p->all->print(p->all->context, item, text, p->all->most, &length);
    lw_piece_add(&p->piece, length);
    return status;
}

static void print_job(void *context, size_t job, int thread)
{
    printing *all = context;
    crew *c = &all->crew;
    page p = { .all = all, .skip = job == 0 ? all->start.skip : 0 };
    lw_status status = LW_OK;
    lw_piece_begin(&p.piece, &all->out, job);
    if (!crew_stopped(c))
        status = lw_walk_structure(c->chains, c->how, all->start.structure + job, c->weighting[thread], print_item, &p);
    lw_piece_end(&p.piece);
    status = crew_report(c, 1, status);
    if (status != LW_OK)
        lw_ordered_stop(&all->out, status);
}

lw_status lw_chains_print(const lw_chains *chains, const lw_chain_walk *how, size_t most, lw_chain_print *print,
                          lw_text_sink *sink, void *context)
{
    printing all = { .most = most, .print = print, .context = context };
    lw_status status = crew_open(&all.crew, chains, how);
    if (status == LW_OK)
        status = lw_walk_find_start(chains, how, &all.start);
    if (status == LW_OK) {
        lw_ordered_open(&all.out, sink, context);
        status = lw_parallel(all.crew.n_thread, all.crew.size - all.start.structure, print_job, &all);
        lw_status written = lw_ordered_close(&all.out);
        if (status == LW_OK)
            status = written;
    }
    crew_close(&all.crew);
    return status;
}

/* ---- counting ------------------------------------------------------------------------------------ */

#define COUNT_BLOCK 16        /* structures a job */

typedef struct counting {
    crew            crew;
    lw_chain_table *table;    /* rows under the crew's lock */
} counting;

/* The row for the chains of structure k of the walk. */
static lw_chain_row *row_of(const counting *all, size_t k)
{
    const lw_chains *chains = all->crew.chains;
    lw_assortment a = { { 0 } };
    lw_chain_row *row = all->table->row;
    if (!chains->structures)
        return row;
    lw_structure s;
    uint8_t degree[LW_CIRCLE_MAX];
    lw_structures_get(chains->structures, chains->numbers.n_loop, lw_walk_index(all->crew.how, k), &s);
    lw_structure_degrees(&s, degree);
    for (int c = 0; c < s.n_circle; c++)
        a.n_with[degree[c]]++;
    a.n_with[2] = chains->numbers.n_link - s.n_circle;
    while (memcmp(&row->links, &a, sizeof a) != 0)
        row++;                                   /* every assortment has its row */
    return row;
}

static void count_job(void *context, size_t job, int thread)
{
    counting *all = context;
    crew *c = &all->crew;
    size_t first = job*COUNT_BLOCK, last = first + COUNT_BLOCK < c->size ? first + COUNT_BLOCK : c->size;
    lw_tally tally[COUNT_BLOCK];
    lw_status status = crew_stopped(c) ? LW_STOPPED : LW_OK;
    for (size_t k = first; k < last && status == LW_OK; k++)
        status = lw_walk_count(c->chains, c->how, k, c->weighting[thread], &tally[k - first]);
    if (crew_report(c, last - first, status) != LW_OK)
        return;
    for (size_t k = first; k < last; k++) {
        if (tally[k - first].n_chain == 0 && tally[k - first].n_labelled == 0)
            continue;
        lw_chain_row *row = row_of(all, k);
        pthread_mutex_lock(&c->lock);
        if (lw_tally_add(&row->n, &tally[k - first]) != LW_OK)
            c->status = LW_E_ARG;
        pthread_mutex_unlock(&c->lock);
    }
}

lw_status lw_chains_count(const lw_chains *chains, const lw_chain_walk *how, lw_chain_table *table)
{
    counting all = { .table = table };
    lw_status status = lw_chain_table_make(&chains->numbers, table);
    if (status != LW_OK)
        return status;
    status = crew_open(&all.crew, chains, how);
    if (status == LW_OK)
        status = lw_parallel(all.crew.n_thread, (all.crew.size + COUNT_BLOCK - 1)/COUNT_BLOCK, count_job, &all);
    if (status == LW_OK)
        status = all.crew.status;
    crew_close(&all.crew);
    for (size_t k = 0; k < table->n_row; k++)
        if (lw_tally_add(&table->total, &table->row[k].n) != LW_OK)
            status = LW_E_ARG;
    bool generating = how->filter && strcmp(how->filter->name, "generating") == 0;
    if (status == LW_OK && generating && how->n_part == 1)
        status = lw_labelled_complete(&chains->numbers, table, NULL);
    return status;
}
