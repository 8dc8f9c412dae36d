/* optimise/search/climb.c - finds for few stations moved to where the linkage counts as less.
 *
 * Few stations leave dimensions free: of the linkages that meet them equally well least squares finds any, though some are gentler, smaller
 * or less sensitive than others.  The measure that orders the results has no derivatives here, so the finds that count as least go on
 * from there by an evolution strategy with one parent and one child (Rechenberg 1973). */
#include <limits.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/rng.h"
#include "optimise/search/fit_internal.h"

enum {
    CLIMBS = 6,                  /* finds that go on, ...                                         */
    TRIALS = 60,                 /* ... trials of each, ...                                       */
    LONG_CLIMBS = 2,             /* ... then those that count as least, ...                       */
    LONG_TRIALS = 200,           /* ... with so many more; of families these alone, ...           */
    FAMILY_TRIALS = 80,          /* ... with so many: the search in parts climbs once in each     */
    FIT_STEPS = 20               /* of the fit after a step                                       */
};
#define EXACT      1e-14         /* f of a find that meets every station; those it becomes do so too  */
#define OFF        1e-3          /* a step off the linkages that meet it as well adds so much       */
#define FIRST_STEP 0.2           /* parts of the lengths                                            */
#define LEAST_STEP 1e-3
#define MOST_STEP  0.5
#define LONGER     1.5           /* the step after one that was better, ...                         */
#define SHORTER    0.9           /* ... and after another                                           */
#define GAIN       1e-3          /* less is rounding                                                */
#define WORSE      1             /* finds that count as e times the best do not go on               */

typedef struct climb {
    lw_found     find;
    double       step[2];                    /* without and with a fit: the one trades error for cost, the other does not */
    lw_rng       rng;
    long         spent;
    lw_variables of;
    lw_status    status;
} climb;

typedef struct climb_list {
    lw_search *s;
    long       allowance;                    /* evaluations of a climb, counted by their cost         */
    double     until;
    int        n, trials;
    climb      item[2*LW_POOL_MAX];          /* of both pools */
} climb_list;

static bool is_over(const climb_list *list)
{
    return (list->until > 0 && lw_clock_wall() > list->until) || (list->s->o->interrupt && *list->s->o->interrupt);
}

static void find_cost(void *context, size_t job, int thread)
{
    climb_list *list = context;
    climb *l = &list->item[job];
    const lw_problem *p = lw_search_made(list->s, thread, l->find.candidate, false, &l->status);
    l->find.cost = INFINITY;
    if (!p || is_over(list))
        return;
    l->of = lw_pool_variables(p);
    lw_search_weigh(list->s, thread, &l->find);
}

/* Move a find by one random step of all variables; `fits`: then fit it to the target again.  f INFINITY: it is no result. */
static void move(climb_list *list, climb *l, int thread, double reach, bool fits, lw_found *now)
{
    lw_search *s = list->s;
    double normal[LW_VAR_MAX];
    *now = l->find;
    lw_problem *p = lw_search_problem_again(s, thread, 0, now, &l->status);
    now->f = INFINITY;
    now->evals = 1;
    if (!p)
        return;
    void *work = s->bench[thread].work;
    for (int v = 0; v < p->n_var; v++)
        normal[v] = lw_rng_normal(&l->rng);
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = FIT_STEPS;
    o.f_tol = 1e-9;
    o.until = list->until;
    o.interrupt = s->o->interrupt;
    if (lw_lm_scatter(p, OFF*OFF*(double)p->n, reach, normal, now->x, work)) {
        now->f = lw_problem_value(p, now->x, NULL, work);
        if (fits)
            lw_search_improve(s, p, &o, true, work, now);
        if (isfinite(now->f))
            lw_search_judge(s, p, work, now);
    }
    l->spent += now->evals*lw_search_effort(s, p).cost;
}

static void run_climb(void *context, size_t job, int thread)
{
    climb_list *list = context;
    climb *l = &list->item[job];
    for (int i = 0; i < list->trials && l->status == LW_OK && !is_over(list) && l->spent < list->allowance; i++) {
        const bool exact = l->find.f <= EXACT, fits = exact || i % 2;
        double *reach = &l->step[fits];
        lw_found now;
        if (*reach < LEAST_STEP)
            continue;
        move(list, l, thread, *reach, fits, &now);
        now.cost = exact && !(now.f <= EXACT) ? INFINITY : lw_search_cost(list->s, thread, &now);
        bool better = now.cost < l->find.cost - GAIN;
        *reach = fmin(*reach*(better ? LONGER : SHORTER), MOST_STEP);
        if (!better)
            continue;
        now.evals += l->find.evals;
        now.moved = true;
        l->find = now;
    }
}

static int by_cost(const void *a, const void *b)
{
    const lw_found *p = &((const climb *)a)->find, *q = &((const climb *)b)->find;
    return p->cost != q->cost ? (p->cost > q->cost) - (p->cost < q->cost) : (p->f > q->f) - (p->f < q->f);
}

static lw_status run(climb_list *list, int n, lw_job *job)
{
    const lw_loop loop = { list->s->n_thread, (size_t)n, job, list, { { list->item, sizeof *list->item }, { NULL, 0 } } };
    return lw_loop_run(&loop, list->s->o->sharing);
}

/* Order the finds by what they count as.  Returns how many of them go on. */
static int choose(climb_list *list, int most)
{
    int n = 0;
    qsort(list->item, (size_t)list->n, sizeof *list->item, by_cost);
    while (n < list->n && n < most && list->item[n].find.cost <= list->item[0].find.cost + WORSE && isfinite(list->item[n].find.cost))
        n++;
    return n;
}

lw_status lw_search_climb(lw_search *s, double until)
{
    if (!lw_search_climbs(s))
        return LW_OK;
    climb_list *list = calloc(1, sizeof *list);
    if (!list)
        return LW_E_MEMORY;
    list->s = s;
    list->until = until;
    for (int i = 0; i < s->pool.n + s->light.n; i++) {
        climb *l = &list->item[list->n++];
        l->find = i < s->pool.n ? s->pool.item[i] : s->light.item[i - s->pool.n];
        l->find.moved |= i >= s->pool.n;
    }
    lw_status st = run(list, list->n, find_cost);
    const bool types = !s->o->families;
    const int n = choose(list, types ? CLIMBS : LONG_CLIMBS);
    for (int i = 0; i < n; i++) {
        list->item[i].step[0] = list->item[i].step[1] = FIRST_STEP;
        lw_rng_seed(&list->item[i].rng, s->o->seed, UINT64_MAX - (uint64_t)i);
    }
    list->trials = types ? TRIALS : FAMILY_TRIALS;
    list->allowance = types ? LONG_MAX : lw_search_budget(s)/(8*LONG_CLIMBS);
    st = st == LW_OK ? run(list, n, run_climb) : st;
    list->n = n;
    list->trials = LONG_TRIALS;
    if (st == LW_OK && types)
        st = run(list, choose(list, LONG_CLIMBS), run_climb);
    for (int i = 0; i < n && st == LW_OK; i++) {
        const climb *l = &list->item[i];
        st = l->status;
        s->evals += l->spent;
        if (l->find.moved)
            lw_pool_put(&s->pool, &l->find, &l->of);
    }
    free(list);
    return st;
}
