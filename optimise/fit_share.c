/* optimise/fit_share.c - which arm gets how much of the next round.
 *
 * Four-link types have fixed shares.  Families of any linkage are searched by successive halving (Karnin, Koren
 * & Somekh 2013; Jamieson & Talwalkar 2016): a round for all, the next for the better half, twice as much for
 * each, until a few are left; then all over again with other starts, since luck decides too.  What an arm
 * has found is its best f, at whatever price. */
#include <stdlib.h>

#include "base/rng.h"
#include "optimise/fit_internal.h"
#include "optimise/problem_internal.h"

enum {
    LEAST_JOBS = 32,        /* of a round                                                         */
    LAST_ARMS = 3,          /* of a sweep                                                         */
    SWEEP_ARMS = 1024       /* at its beginning, at most                                          */
};

static void share_types(lw_search *s)
{
    s->n_job = 0;
    for (int i = 0; i < s->n_arm; i++) {
        long blocks = s->o->starts > 0 ? (s->o->starts + LW_BLOCK - 1)/LW_BLOCK : s->arm[i].row->blocks;
        for (int k = 0; k < blocks && k < 8; k++)
            s->job[s->n_job++] = (lw_search_job){ .arm = i };
    }
}

/* ---- families ------------------------------------------------------------------------------------------- */

typedef struct standing { double f; uint64_t lot; int arm; } standing;

static int by_f(const void *a, const void *b)
{
    const standing *p = a, *q = b;
    if (p->f != q->f)
        return p->f < q->f ? -1 : 1;
    return p->lot != q->lot ? (p->lot < q->lot ? -1 : 1) : p->arm - q->arm;
}

/* The order of their turns: as lw_turn says, among equals by lot. */
static lw_status draw_order(lw_search *s, int *order)
{
    const lw_families *f = s->o->families;
    standing *list = malloc(sizeof *list*(size_t)s->n_arm);
    if (!list)
        return LW_E_MEMORY;
    for (int i = 0; i < s->n_arm; i++) {
        lw_rng rng;
        lw_rng_seed(&rng, s->o->seed ^ 0x6c6f7473u, (uint64_t)i);
        list[i] = (standing){ f->turn(f->of, i), lw_rng_bits(&rng), i };
    }
    qsort(list, (size_t)s->n_arm, sizeof *list, by_f);
    for (int i = 0; i < s->n_arm; i++)
        order[i] = list[i].arm;
    free(list);
    return LW_OK;
}

lw_status lw_search_share_begin(lw_search *s)
{
    lw_sweep *w = &s->sweep;
    if (!s->o->families)
        return LW_OK;
    w->order = malloc(sizeof *w->order*((size_t)s->n_arm + 1));
    w->arm = malloc(sizeof *w->arm*((size_t)s->n_arm + 1));
    if (!w->order || !w->arm)
        return LW_E_MEMORY;
    return draw_order(s, w->order);
}

/* The arms of a sweep: all, or the next that have not had their turn; after the last the first again. */
static void begin_sweep(lw_search *s)
{
    lw_sweep *w = &s->sweep;
    w->rung = w->n = 0;
    for (int i = 0; i < s->n_arm && w->n < SWEEP_ARMS; i++) {
        int arm = s->n_arm <= SWEEP_ARMS ? i : w->order[w->next++];
        w->next = w->next == s->n_arm ? 0 : w->next;
        if (s->arm[arm].state != LW_FIT_UNABLE)
            w->arm[w->n++] = arm;
    }
}

/* Those that go on stand first; those that cannot do the task are out. */
static bool sort_sweep(const lw_search *s, lw_sweep *w)
{
    standing *list = malloc(sizeof *list*((size_t)w->n + 1));
    int n = 0;
    for (int i = 0; list && i < w->n; i++) {
        const lw_arm *a = &s->arm[w->arm[i]];
        if (a->state != LW_FIT_UNABLE)
            list[n++] = (standing){ a->best ? lw_few_f(a->best, 0) : INFINITY, 0, w->arm[i] };
    }
    if (!list)
        return false;
    qsort(list, (size_t)n, sizeof *list, by_f);
    for (int i = 0; i < n; i++)
        w->arm[i] = list[i].arm;
    w->n = n;
    free(list);
    return true;
}

/* How many of a sweep are left on its rung. */
static int left_of(const lw_sweep *w)
{
    int n = w->n;
    for (int r = 0; r < w->rung; r++)
        n = (n + 1)/2;
    return n;
}

static void share_families(lw_search *s)
{
    lw_sweep *w = &s->sweep;
    s->n_job = 0;
    if (!sort_sweep(s, w))
        return;                                          /* no jobs: the search ends with what it has */
    if (left_of(w) > LAST_ARMS)
        w->rung++;
    else {
        begin_sweep(s);
        if (!sort_sweep(s, w))
            return;
    }
    int n = left_of(w), jobs = w->n > LEAST_JOBS ? w->n : LEAST_JOBS;
    for (int at = 0; at < jobs && n > 0; at++) {
        int arm = w->arm[at%n], turn = at/n;
        bool around = s->arm[arm].best && w->rung > 0 && (turn & 1) == (w->rung & 1);
        s->job[s->n_job++] = (lw_search_job){ .arm = arm, .around = around };
    }
}

void lw_search_share(lw_search *s)
{
    if (s->o->families)
        share_families(s);
    else
        share_types(s);
}
