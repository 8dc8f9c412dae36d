/* optimise/search/successive_halving.c - which arm gets how much of the next round.
 *
 * Four-link types have fixed shares.  Families of any linkage are searched in sweeps by successive halving (Karnin,
 * Koren & Somekh 2013; Jamieson & Talwalkar 2016): a look at all of a sweep, then the better ones, of these the
 * better half with twice as much for each, until a few are left; then the next sweep, over those that had no turn, and
 * in the end over all again with other starts, since luck decides too.  How large a sweep is depends on what it may
 * cost, not on the budget: with more budget a search begins as with less, and each sweep may cost twice as much as
 * the one before (as the brackets of Li, Jamieson, DeSalvo, Rostamizadeh & Talwalkar 2018), so that wide and deep
 * ones share it.  What an arm has found is its best f, at whatever price. */
#include <stdlib.h>

#include "base/rng.h"
#include "optimise/search/fit_internal.h"
#include "optimise/problem/problem.h"

enum {
    LEAST_JOBS = 32,        /* of a round                                                         */
    LAST_ARMS = 3,          /* of a sweep                                                         */
    DYAD_JOB = 550,         /* what a job is likely to cost, in evaluations                       */
    GROUP_JOB = 4400,
    SWEEP_COST = 500000
};

static void share_types(lw_search *s)
{
    s->n_job = 0;
    for (int i = 0; i < s->n_arm; i++) {
        long blocks = s->o->starts > 0 ? (s->o->starts + LW_SEARCH_BLOCK - 1)/LW_SEARCH_BLOCK : s->arm[i].row->blocks;
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
    standing *list = malloc(sizeof *list*((size_t)s->n_arm + 1));
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

static bool has_groups(const lw_search *s, int arm)
{
    const lw_families *f = s->o->families;
    return f->turn(f->of, arm) == LW_TURN_GROUPS;
}

/* Those with groups are swept by themselves, unless they are so few that together they cost less than the others: what
 * one job of either kind costs then. */
static void weigh_groups(lw_search *s)
{
    long groups = 0;
    for (int i = 0; i < s->n_arm; i++)
        groups += has_groups(s, i);
    long dyads = s->n_arm - groups;
    s->sweep.apart = groups*GROUP_JOB > dyads*DYAD_JOB;
    s->sweep.mean_job = s->n_arm > 0 ? (groups*GROUP_JOB + dyads*DYAD_JOB)/s->n_arm : DYAD_JOB;
}

lw_status lw_search_halving_begin(lw_search *s)
{
    lw_sweep *w = &s->sweep;
    if (!s->o->families)
        return LW_OK;
    w->order = malloc(sizeof *w->order*((size_t)s->n_arm + 1));
    w->arm = malloc(sizeof *w->arm*((size_t)s->n_arm + 1));
    if (!w->order || !w->arm)
        return LW_E_MEMORY;
    weigh_groups(s);
    return draw_order(s, w->order);
}

static int rungs_of(int n)
{
    int rungs = 0;
    for (; n > LAST_ARMS; n = (n + 1)/2)
        rungs++;
    return rungs;
}

static long job_cost(const lw_search *s, int arm)
{
    return !s->sweep.apart ? s->sweep.mean_job : has_groups(s, arm) ? GROUP_JOB : DYAD_JOB;
}

/* The arms of the next sweep: those whose turn it is, by dyads or by groups alone, as many as may be looked at; after the
 * last the first again.  Of these so many go on as the halvings may cost. */
static void begin_sweep(lw_search *s)
{
    lw_sweep *w = &s->sweep;
    long most = (s->o->sweep > 0 ? s->o->sweep : SWEEP_COST) << (w->n_sweep < 20 ? w->n_sweep : 20), job = 1;
    w->n_sweep++;
    w->rung = w->n = w->go_on = 0;
    for (int i = 0; i < s->n_arm && w->n < LW_JOB_MAX; i++, w->next = (w->next + 1) % s->n_arm) {
        int arm = w->order[w->next];
        if (s->arm[arm].state == LW_FIT_UNABLE)
            continue;
        job = w->n == 0 ? job_cost(s, arm) : job;
        if (job_cost(s, arm) != job || (w->n >= LEAST_JOBS && job*w->n >= most))
            break;
        w->arm[w->n++] = arm;
    }
    while (w->go_on < w->n && (w->go_on < LEAST_JOBS || job*w->go_on*rungs_of(w->go_on) < most))
        w->go_on++;
}

/* Those that go on stand first; those that cannot do the task are out. */
static bool sort_sweep(const lw_search *s, lw_sweep *w)
{
    standing *list = malloc(sizeof *list*((size_t)w->n + 1));
    int n = 0;
    for (int i = 0; list && i < w->n; i++) {
        const lw_search_candidate *a = &s->arm[w->arm[i]];
        if (a->state != LW_FIT_UNABLE)
            list[n++] = (standing){ a->best ? lw_best_starts_f(a->best, 0) : INFINITY, 0, w->arm[i] };
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
    int n = w->rung == 0 ? w->n : w->go_on < w->n ? w->go_on : w->n;
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
    int n = left_of(w), jobs = w->rung == 0 ? w->n : w->go_on;
    jobs = jobs > LEAST_JOBS ? jobs : LEAST_JOBS;
    for (int at = 0; at < jobs && n > 0; at++) {
        int arm = w->arm[at%n], turn = at/n;
        bool around = s->arm[arm].best && w->rung > 0 && (turn & 1) == (w->rung & 1);
        s->job[s->n_job++] = (lw_search_job){ .arm = arm, .around = around };
    }
}

void lw_search_halving(lw_search *s)
{
    if (s->o->families)
        share_families(s);
    else
        share_types(s);
}
