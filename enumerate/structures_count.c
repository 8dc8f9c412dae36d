/* enumerate/structures_count.c - structures counted without storing them, see structures.h. */
#include <stdlib.h>
#include <string.h>
#include "base/parallel.h"
#include "enumerate/canon.h"
#include "enumerate/grow.h"
#include "enumerate/structures.h"

#define BLOCK 8           /* parents in one job              */
#define WAVE  64          /* jobs before their sums are added */

typedef struct block {
    const lw_structures *set;
    size_t               first, step, n;         /* parents first, first + step, ... below n */
    lw_status            status;
    lw_structures_tally  by_circles[LW_CIRCLE_MAX + 1];
} block;

/* |automorphisms of circles and lines|: parallel lines may be exchanged too. */
static lw_status count_automorphisms(const lw_structure *s, long double *order)
{
    lw_graph g;
    uint64_t n = 1;
    lw_graph_of_structure(s, &g);
    lw_status status = lw_graph_symmetry(&g, NULL, &n);
    *order = (long double)n;
    for (int e = 1, alike = 1; e < s->n_line; e++) {
        alike = memcmp(s->end[e - 1], s->end[e], 2) == 0 ? alike + 1 : 1;
        *order *= alike;
    }
    return status;
}

static lw_status count_child(void *context, lw_ear ear, const lw_structure *child)
{
    lw_structures_tally *t = &((block *)context)->by_circles[child->n_circle];
    long double order;
    (void)ear;
    lw_status status = count_automorphisms(child, &order);
    t->n++;
    t->weight += 1/order;
    return status;
}

static void count_block(void *context, size_t job, int thread)
{
    block *b = (block *)context + job;
    size_t p = b->first;
    (void)thread;
    for (int i = 0; i < BLOCK && p < b->n && b->status == LW_OK; i++, p += b->step) {
        lw_structure parent;
        lw_structures_get(b->set, lw_structures_loops(b->set), p, &parent);
        b->status = lw_grow_once(&parent, count_child, b);
    }
}

lw_status lw_structures_count_next(const lw_structures *set, int part, int n_part, int n_thread, lw_structures_tick *tick,
                                   void *context, lw_structures_tally *by_circles)
{
    int loops = lw_structures_loops(set);
    size_t n = lw_structures_count(set, loops), found = 0;
    memset(by_circles, 0, (LW_CIRCLE_MAX + 1)*sizeof *by_circles);
    if (loops >= LW_LOOP_MAX || part < 0 || part >= n_part)
        return LW_E_ARG;
    block *wave = malloc(WAVE*sizeof *wave);
    lw_status status = wave ? LW_OK : LW_E_MEMORY;
    for (size_t next = (size_t)part; next < n && status == LW_OK; ) {
        size_t n_block = 0;
        for (; n_block < WAVE && next < n; n_block++, next += BLOCK*(size_t)n_part)
            wave[n_block] = (block){ .set = set, .first = next, .step = (size_t)n_part, .n = n };
        status = lw_parallel(n_thread, n_block, count_block, wave);
        for (size_t k = 0; k < n_block && status == LW_OK; k++) {
            status = wave[k].status;
            for (int v = 0; v <= LW_CIRCLE_MAX; v++) {
                found += wave[k].by_circles[v].n;
                by_circles[v].n += wave[k].by_circles[v].n;
                by_circles[v].weight += wave[k].by_circles[v].weight;
            }
        }
        if (status == LW_OK && tick && !tick(context, loops + 1, found))
            status = LW_STOPPED;
    }
    free(wave);
    return status;
}
