/* optimise/search/successive_halving.c - which candidate gets how many jobs of the next round.
 *
 * Four-link types have fixed numbers of jobs.  Families of any linkage are searched in sweeps by successive halving
 * (Karnin, Koren & Somekh 2013; Jamieson & Talwalkar 2016).  A sweep looks at all of its candidates, goes on with the
 * better ones, then with the better half of these and twice the work for each, until a few are left.  Work is counted in
 * evaluations: where candidates with groups beyond dyads are among the others, they have a job when the others have had as
 * many evaluations.  The next sweep
 * takes the candidates that had no turn yet; after the last candidate the sweeps begin again at the first, with other
 * starts.  A candidate stands by its best f, whatever that cost.
 *
 * The size of a sweep depends on what the sweep may cost and not on the budget, so a search with more budget begins
 * like one with less.  Each sweep may cost twice as much as the one before, so wide and deep sweeps share the budget
 * (as the brackets of Li, Jamieson, DeSalvo, Rostamizadeh & Talwalkar 2018). */
#include <assert.h>
#include <limits.h>
#include <stdlib.h>

#include "base/rng.h"
#include "optimise/search/fit_internal.h"

enum {
    LEAST_JOBS = 32,        /* of a round                                                            */
    LEAST_GROUP_JOBS = 8,   /* of a round of candidates with groups beyond dyads                     */
    LAST_CANDIDATES = 3,    /* a sweep ends when no more are left                                    */
    DYAD_JOB = 550,         /* evaluations that a job is likely to cost, of dyads ...                */
    GROUP_STARTS = 220,     /* ... and of groups beyond dyads, each of which costs lw_search_group_cost */
    SWEEP_COST = 500000,
    DOUBLINGS_MAX = 20      /* of the cost of a sweep                                                */
};

static void jobs_of_types(lw_search *s)
{
    s->n_job = 0;
    for (int i = 0; i < s->n_candidate; i++) {
        long blocks = s->o->starts > 0 ? (s->o->starts + LW_SEARCH_BLOCK - 1)/LW_SEARCH_BLOCK
                                       : s->candidate[i].row->blocks;
        for (int k = 0; k < blocks && k < LW_SEARCH_BLOCK_MAX; k++)
            s->job[s->n_job++] = (lw_search_job){ .candidate = i };
    }
}

/* ---- families ------------------------------------------------------------------------------------------- */

typedef struct standing { double f; uint64_t lot; int candidate; } standing;

static int by_f(const void *a, const void *b)
{
    const standing *p = a, *q = b;
    if (p->f != q->f)
        return p->f < q->f ? -1 : 1;
    return p->lot != q->lot ? (p->lot < q->lot ? -1 : 1) : p->candidate - q->candidate;
}

/* The order of the candidates' turns: by lw_turn, equal ones by lot. */
static lw_status draw_order(lw_search *s, int *order)
{
    const lw_families *f = s->o->families;
    standing *list = malloc(sizeof *list*((size_t)s->n_candidate + 1));
    if (!list)
        return LW_E_MEMORY;
    for (int i = 0; i < s->n_candidate; i++) {
        lw_rng rng;
        lw_rng_seed(&rng, s->o->seed ^ 0x6c6f7473u, (uint64_t)i + ((uint64_t)s->o->part_number << 40));
        list[i] = (standing){ f->turn(f->of, i), lw_rng_bits(&rng), i };
    }
    qsort(list, (size_t)s->n_candidate, sizeof *list, by_f);
    for (int i = 0; i < s->n_candidate; i++)
        order[i] = list[i].candidate;
    free(list);
    return LW_OK;
}

static bool has_groups(const lw_search *s, int candidate)
{
    const lw_families *f = s->o->families;
    return f->turn(f->of, candidate) == LW_TURN_GROUPS;
}

static long group_job(const lw_search *s) { return GROUP_STARTS*lw_search_group_cost(s); }

/* Candidates with groups beyond dyads are swept by themselves, unless they are so few that together they cost less
 * than the others.  Then every job counts with the mean cost. */
static void weigh_groups(lw_search *s)
{
    long groups = 0;
    for (int i = 0; i < s->n_candidate; i++)
        groups += has_groups(s, i);
    long dyads = s->n_candidate - groups;
    s->sweep.apart = groups*group_job(s) > dyads*DYAD_JOB;
    s->sweep.mean_job = s->n_candidate > 0 ? (groups*group_job(s) + dyads*DYAD_JOB)/s->n_candidate : DYAD_JOB;
}

lw_status lw_search_halving_begin(lw_search *s)
{
    lw_family_sweep *w = &s->sweep;
    if (!s->o->families)
        return LW_OK;
    w->order = malloc(sizeof *w->order*((size_t)s->n_candidate + 1));
    w->candidate = malloc(sizeof *w->candidate*((size_t)s->n_candidate + 1));
    if (!w->order || !w->candidate)
        return LW_E_MEMORY;
    weigh_groups(s);
    return draw_order(s, w->order);
}

static int rungs_of(int n)
{
    int rungs = 0;
    for (; n > LAST_CANDIDATES; n = (n + 1)/2)
        rungs++;
    return rungs;
}

static long job_cost(const lw_search *s, int candidate)
{
    return !s->sweep.apart ? s->sweep.mean_job : has_groups(s, candidate) ? group_job(s) : DYAD_JOB;
}

/* What a round may cost. */
static long most_cost(const lw_search *s) { return s->o->budget > 0 ? s->o->budget : LONG_MAX; }

/* Of a round; fewer if they cost more than the budget. */
static int least_jobs(const lw_search *s)
{
    bool any = s->sweep.n > 0, groups = any && s->sweep.apart && has_groups(s, s->sweep.candidate[0]);
    long least = groups ? LEAST_GROUP_JOBS : LEAST_JOBS, most = most_cost(s)/(any ? job_cost(s, s->sweep.candidate[0]) : 1);
    return most < 1 ? 1 : most < least ? (int)most : (int)least;
}

/* Fill the next sweep with the candidates whose turn it is, as many as a first look may cost; candidates with groups
 * beyond dyads and others are not mixed if they are swept apart.  After the last candidate the first one follows
 * again.  Set how many go on after the first look, by what the halvings may cost. */
static void begin_sweep(lw_search *s)
{
    lw_family_sweep *w = &s->sweep;
    int doublings = w->n_sweep < DOUBLINGS_MAX ? w->n_sweep : DOUBLINGS_MAX;
    long least = s->o->sweep > 0 ? s->o->sweep : SWEEP_COST, most = least << doublings, job = 1;
    w->n_sweep++;
    w->rung = w->n = w->go_on = 0;
    for (int i = 0; i < s->n_candidate && w->n < LW_JOB_MAX; i++, w->next = (w->next + 1) % s->n_candidate) {
        int candidate = w->order[w->next];
        if (s->candidate[candidate].state == LW_FIT_UNABLE)
            continue;
        job = w->n == 0 ? job_cost(s, candidate) : job;
        if (job_cost(s, candidate) != job || (w->n >= least_jobs(s) && job*w->n >= most) || (w->n > 0 && job*(w->n + 1) > most_cost(s)))
            break;
        w->candidate[w->n++] = candidate;
    }
    least = least > job*w->n ? least : job*w->n;                   /* the first look may cost less than it could */
    most = least < most ? least : most;
    while (w->go_on < w->n && (w->go_on < least_jobs(s) || job*w->go_on*rungs_of(w->go_on) < most))
        w->go_on++;
}

/* Sort by best f; take out candidates that cannot do the task.  false: no memory. */
static bool sort_sweep(lw_search *s, lw_family_sweep *w)
{
    standing *list = malloc(sizeof *list*((size_t)w->n + 1));
    int n = 0;
    for (int i = 0; list && i < w->n; i++) {
        const lw_search_candidate *a = &s->candidate[w->candidate[i]];
        if (a->state != LW_FIT_UNABLE)
            list[n++] = (standing){ a->best ? lw_best_starts_f(a->best, 0) : INFINITY, 0, w->candidate[i] };
    }
    if (!list) {
        s->no_memory = true;
        return false;
    }
    qsort(list, (size_t)n, sizeof *list, by_f);
    for (int i = 0; i < n; i++)
        w->candidate[i] = list[i].candidate;
    w->n = n;
    free(list);
    return true;
}

/* How many candidates of a sweep are left after its halvings so far. */
static int left_of(const lw_family_sweep *w)
{
    int n = w->rung == 0 ? w->n : w->go_on < w->n ? w->go_on : w->n;
    for (int r = 0; r < w->rung; r++)
        n = (n + 1)/2;
    return n;
}

static void jobs_of_families(lw_search *s)
{
    lw_family_sweep *w = &s->sweep;
    s->n_job = 0;
    if (!sort_sweep(s, w))
        return;
    if (left_of(w) > LAST_CANDIDATES)
        w->rung++;
    else {
        begin_sweep(s);
        if (!sort_sweep(s, w))
            return;
    }
    int n = left_of(w), jobs = w->rung == 0 ? w->n : w->go_on;
    int least = least_jobs(s), seldom = s->sweep.apart ? 1 : (int)(group_job(s)/DYAD_JOB);
    jobs = jobs > least ? jobs : least;
    for (int at = 0; at < jobs && n > 0; at++) {
        int candidate = w->candidate[at%n], turn = at/n;
        if (turn % seldom != 0 && has_groups(s, candidate))
            continue;
        const lw_best_starts *best = s->candidate[candidate].best;
        bool around = best && w->rung > 0 && (turn & 1) == (w->rung & 1);
        assert(s->n_job < LW_JOB_MAX);
        s->job[s->n_job++] = (lw_search_job){ .candidate = candidate, .around = around };
    }
}

void lw_search_halving(lw_search *s)
{
    if (s->o->families)
        jobs_of_families(s);
    else
        jobs_of_types(s);
}
