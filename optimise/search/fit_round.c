/* optimise/search/fit_round.c - one round of the search: draw low-discrepancy starts, improve the better ones, polish
 * the best. */
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "mbs/batch/posture.h"
#include "optimise/search/fit_internal.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "optimise/search/random_linkage.h"
#include "optimise/problem/constraint.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/timing.h"
#include "optimise/search/start.h"

enum {
    IMPROVE = 12,           /* most starts of a job that are improved                                */
    FIRST_STEPS = 40,       /* of the improvement of each                                            */
    FULL_STEPS = 120,       /* of the LW_KEEP best                                                   */
    POLISH_STEPS = 1500,    /* of a polish ...                                                       */
    POLISH_GROUPS = 300,    /* ... and of one of higher groups at least                              */
    COSTLY = 2,             /* how many are improved further where conditions on the motion cost most */
    SHORT_ROUND = 64,       /* jobs                                                                  */
    POLISH = 8,             /* finds of a round that are polished                                    */
    POLISH_PART = 16        /* one of higher groups may cost one of so many parts of the budget      */
};
#define LACKING 1e4         /* f counts so many times where a soft condition is not met              */
#define MET   1e-6          /* conditions on results are met to this                                 */
#define HOPELESS 1e4        /* no start whose f exceeds the best by this factor is improved further  */
#define ALMOST 1e-6         /* from so small an f to an exact find it is a way along a narrow valley  */
#define RISE_MOST 1e6       /* a start along such a valley may have so many times the f of the find   */
#define NEARLY_ROUNDING 1e-14   /* ... or of this                                                    */
#define HIT   1e-3          /* relative difference of f of two finds of the same linkage             */

typedef struct estimate { double residual; int which; } estimate;

static int by_residual(const void *a, const void *b)
{
    const estimate *p = a, *q = b;
    return p->residual < q->residual ? -1 : p->residual > q->residual ? 1 : p->which - q->which;
}

/* Choose the draws of a block to settle: all with prescribed timing, which is cheap, else the best by a first estimate.
 * Returns how many; g says which. */
static int choose_draws(const lw_effort *a, lw_problem *p, const double *u, int d, void *work, estimate *g)
{
    for (int i = 0; i < a->block; i++) {
        g[i].which = i;
        g[i].residual = p->timing == LW_TIMING_PRESCRIBED ? 0 : lw_start_estimate(p, u + i*d, work);
    }
    if (p->timing == LW_TIMING_PRESCRIBED)
        return a->block;
    qsort(g, (size_t)a->block, sizeof *g, by_residual);
    return a->settle;
}

/* Put c among the n best, of which there are `most` at most.  Returns their new number. */
static int put_in_order(lw_found *best, int n, int most, const lw_found *c)
{
    if (!isfinite(c->f) || (n == most && c->f >= best[n - 1].f))
        return n;
    int at = n < most ? n++ : n - 1;
    for (; at > 0 && best[at - 1].f > c->f; at--)
        best[at] = best[at - 1];
    best[at] = *c;
    return n;
}

/* Draw a block of starts; best: the best of them in order of f.  Returns how many. */
static int draw_starts(lw_search *s, const lw_effort *a, lw_problem *p, lw_rng *rng, lw_workbench *bench,
                       lw_found *best)
{
    double *u = bench->draws;
    void *work = bench->work;
    estimate g[LW_SEARCH_BLOCK];
    int n = 0, d = lw_start_draws(p);
    if (!lw_low_discrepancy(rng, (size_t)a->block, d, u)) {
        s->no_memory = true;
        return 0;
    }
    int chosen = choose_draws(a, p, u, d, work, g);
    for (int i = 0; i < chosen && isfinite(g[i].residual); i++) {
        lw_found c = { .hits = 1 };
        c.f = lw_start(p, u + g[i].which*d, c.x, work);
        c.intended = p->intended;
        n = put_in_order(best, n, a->improve, &c);
    }
    return n;
}

/* Find out what finds for few stations count as: their `cost`. */
static void weigh_all(lw_search *s, int thread, int n, lw_found *found)
{
    for (int i = 0; i < n; i++) {
        lw_found now = found[i];
        lw_search_weigh(s, thread, &now);
        found[i].cost = now.cost;
    }
}

/* The one of some starts with pins on circles, of the same draws, that counts as least.  Least squares would leave a gentle linkage for a little
 * less error, so it is not improved, but moved to where it counts as least (lw_search_climb). */
static void draw_guided(lw_search *s, const lw_effort *a, lw_problem *p, int candidate, int thread, lw_found *c)
{
    enum { SETTLED = 8 };
    lw_workbench *bench = &s->bench[thread];
    lw_found now[SETTLED];
    int n = 0;
    int d = lw_start_draws(p);
    estimate g[LW_SEARCH_BLOCK];
    for (int i = 0; i < a->block; i++)
        g[i] = (estimate){ lw_start_guided_estimate(p, bench->draws + i*d), i };
    qsort(g, (size_t)a->block, sizeof *g, by_residual);
    for (; n < a->block && n < SETTLED && isfinite(g[n].residual); n++) {
        now[n] = (lw_found){ .candidate = candidate, .hits = 1, .guided = true, .intended = p->intended };
        now[n].f = lw_start_guided(p, bench->draws + g[n].which*d, now[n].x, bench->work);
    }
    weigh_all(s, thread, n, now);
    for (int i = 0; i < n; i++)
        if (isfinite(now[i].cost) && !(c->guided && c->cost <= now[i].cost))
            *c = now[i];
}

/* Draw starts along the valley of a find that is nearly exact: linkages that draw nearly the same curve lie close together in a few
 * directions and far apart in others.  All are kept: those that move least have the least f, and lead back. */
static int search_along(const lw_best_starts *finds, const lw_effort *a, lw_problem *p, lw_rng *rng, void *work,
                        lw_found *best)
{
    double normal[LW_VAR_MAX];
    int n = 0;
    for (int i = 0; i < a->improve; i++) {
        lw_found c;
        lw_best_starts_get(finds, (int)(lw_rng_uniform(rng)*finds->n), &c);
        double rise = fmax(c.f, NEARLY_ROUNDING)*pow(RISE_MOST, lw_rng_uniform(rng)), reach = exp(0.5 - 3*lw_rng_uniform(rng));
        p->intended = c.intended;
        lw_problem_work_intended(p, work);
        for (int v = 0; v < p->n_var; v++)
            normal[v] = lw_rng_normal(rng);
        if (lw_lm_scatter(p, rise, reach, normal, c.x, work))
            c.f = lw_problem_value(p, c.x, NULL, work);
        else
            c.f = INFINITY;
        n = put_in_order(best, n, a->improve, &c);
    }
    return n;
}

/* Draw starts around the best finds of a candidate: move all variables a little, or some of them farther. */
static int search_around(const lw_best_starts *finds, const lw_effort *a, lw_problem *p, lw_rng *rng, void *work,
                         lw_found *best)
{
    int n = 0;
    for (int i = 0; finds && i < a->settle; i++) {
        lw_found c;
        lw_best_starts_get(finds, (int)(lw_rng_uniform(rng)*finds->n), &c);
        double far = exp(-1 - 4*lw_rng_uniform(rng)), part = lw_rng_uniform(rng) < 0.5 ? 1 : 0.3;
        p->intended = c.intended;
        lw_problem_work_intended(p, work);
        for (int v = 0; v < p->n_var; v++)
            if (lw_rng_uniform(rng) < part)
                c.x[v] += far*fmax(0.1, fabs(c.x[v]))*lw_rng_normal(rng);
        c.f = lw_lm_feasible(p, c.x, work) ? lw_problem_value(p, c.x, NULL, work) : INFINITY;
        n = put_in_order(best, n, a->improve, &c);
    }
    return n;
}

/* Improve c by the solver of the user's choice. */
static void run_solver(lw_search *s, const lw_solver *solver, const lw_problem *p, const lw_lm_options *lm, lw_found *c)
{
    lw_solver_options o = lw_solver_options_default();
    lw_solver_result r;
    o.seed = s->o->seed;
    o.max_evals = 10L*lm->max_steps;
    o.interrupt = lm->interrupt;
    o.max_seconds = lm->until > 0 ? fmax(1e-3, lm->until - lw_clock_wall()) : 0;
    lw_status st = solver->run(solver, p, &o, c->x, &r);
    if (st == LW_E_MEMORY)
        s->no_memory = true;
    c->f = st >= 0 && st != LW_NOTHING ? r.f : INFINITY;
    c->evals += r.evals;
    c->stop = r.stop;
}

void lw_search_improve(lw_search *s, const lw_problem *p, const lw_lm_options *o, bool conditions, void *work, lw_found *c)
{
    const lw_solver *mine = s->o->solver;
    if (mine && mine->run != lw_lm_run) {
        run_solver(s, mine, p, o, c);
        return;
    }
    c->f = conditions ? lw_lm_conditioned(p, o, c->x, work, &c->evals, &c->stop)
                      : lw_lm_improve(p, o, c->x, false, work, &c->evals, &c->stop);
    if (conditions && !isfinite(c->f) && p->transmission_is_soft)      /* worse than any that keeps the conditions */
        c->f = LACKING*(1 + lw_problem_lacks(p, c->x, work))*lw_problem_value(p, c->x, NULL, work);
}

/* Does a start keep the conditions on the motion, as linkages do that were found before? */
static bool keeps_conditions(const lw_problem *p, const double *x, lw_work *work)
{
    return lw_problem_is_nonlinear(p) && lw_problem_admissible(p, x, MET, work);
}

/* Improve each of n starts by `steps` steps at most; then sort them by f. */
static void improve_all(lw_search *s, lw_problem *p, int steps, int n, void *work, lw_found *best)
{
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = steps;
    o.f_hopeless = HOPELESS*fmax(s->best_raw, LW_SEARCH_NEAR_MISS);
    o.patience = FIRST_STEPS;
    o.bend = s->o->families && steps > FIRST_STEPS && !lw_problem_is_nonlinear(p);       /* else most runs end on a condition */
    o.interrupt = s->o->interrupt;
    o.until = lw_search_end(s);
    for (int i = 0; i < n && !lw_search_stopped(s); i++) {
        p->intended = best[i].intended;
        lw_problem_work_intended(p, work);
        bool conditions = !p->family->linkage || steps > FIRST_STEPS || keeps_conditions(p, best[i].x, work);
        lw_search_improve(s, p, &o, conditions, work, &best[i]);
        if (p->plan.n_higher > 0 && isfinite(best[i].f))             /* the seeds move with the linkage */
            if (lw_plan_seed(&p->plan, best[i].x, p->intended.mode[p->plan.n_mode - 1], best[i].intended.mode)
                == LW_E_MEMORY)
                s->no_memory = true;
    }
    for (int i = 1; i < n; i++) {
        lw_found c = best[i];
        int at = i;
        for (; at > 0 && best[at - 1].f > c.f; at--)
            best[at] = best[at - 1];
        best[at] = c;
    }
}

/* The starts of one job in order of f, of families one more than effort->improve at most.  Returns how many. */
static int starts_of(lw_search *s, size_t job, const lw_effort *effort, lw_problem *p, lw_workbench *bench,
                     lw_found *best)
{
    void *work = bench->work;
    const lw_search_candidate *a = &s->candidate[s->job[job].candidate];
    lw_rng rng;
    uint64_t round = (uint64_t)s->round*(s->o->families ? LW_JOB_MAX : LW_SEARCH_CANDIDATE_MAX*LW_SEARCH_BLOCK_MAX);
    lw_rng_seed(&rng, s->o->seed, round + job + ((uint64_t)s->o->part_number << 40));
    if (s->job[job].around && lw_best_starts_f(a->best, 0) < ALMOST)
        return search_along(a->best, effort, p, &rng, work, best);
    if (s->job[job].around)
        return search_around(a->best, effort, p, &rng, work, best);
    int n = draw_starts(s, effort, p, &rng, bench, best);
    int senses = p->timing == LW_TIMING_FREE || lw_problem_turns_either_way(p) ? 2 : 1;
    lw_found given = { .f = INFINITY };
    for (int k = 0; k < senses && p->family->posture && a->starts == 0; k++) {
        lw_found c = { .hits = 1 };
        p->intended.sense = senses == 2 ? 2*k - 1 : p->intended.sense;
        c.f = lw_random_linkage_posture(p, c.x, work) ? lw_problem_value(p, c.x, NULL, work) : INFINITY;
        c.intended = p->intended;
        given = c.f < given.f ? c : given;
        n = put_in_order(best, n, effort->improve, &c);
    }
    if (isfinite(given.f) && given.f > best[n - 1].f)    /* it is improved beside the drawn ones, even if all of these have less f */
        best[n++] = given;
    return n;
}

/* Run one job: improve all of its best starts a little and the best of these further; LW_KEEP go to the pool. */
static void search_in(lw_search *s, size_t at, lw_problem *p, int thread)
{
    lw_workbench *bench = &s->bench[thread];
    void *work = bench->work;
    lw_search_job *job = &s->job[at];
    lw_found best[IMPROVE], *keep = s->found + at*LW_KEEP;
    lw_effort effort = lw_search_effort(s, p);
    int n = starts_of(s, at, &effort, p, bench, best);
    job->block = effort.block;
    job->of = lw_pool_variables(p);
    job->n_mode = p->plan.n_mode;
    job->evals += (long)effort.cost*effort.block;
    job->improved += n;
    for (int i = 0; i < n; i++)
        best[i].candidate = job->candidate;
    improve_all(s, p, FIRST_STEPS, n, work, best);
    if (p->family->linkage && lw_problem_is_nonlinear(p) && n > COSTLY) {
        int kept = COSTLY;
        while (kept < n && !keeps_conditions(p, best[kept].x, work))
            kept++;
        if (kept < n)                                      /* the best that keeps the conditions goes on too  */
            best[COSTLY] = best[kept];
        n = COSTLY + (kept < n);
    }
    improve_all(s, p, FULL_STEPS, n < LW_KEEP ? n : LW_KEEP, work, best);
    for (int i = 0; i < n; i++) {
        best[i].seconds = lw_clock_wall() - s->started;
        job->evals += effort.cost*best[i].evals;
        if (i < LW_KEEP)
            keep[i] = best[i];
    }
    if (!lw_search_climbs(s))
        return;
    if (lw_start_has_guides(p))
        draw_guided(s, &effort, p, job->candidate, thread, &keep[LW_KEEP - 1]);
    if (!s->o->families)
        weigh_all(s, thread, LW_KEEP, keep);
}

static void search_job(void *context, size_t at, int thread)
{
    lw_search *s = context;
    lw_search_job *job = &s->job[at];
    memset(s->found + at*LW_KEEP, 0, LW_KEEP*sizeof *s->found);
    for (int i = 0; i < LW_KEEP; i++)
        s->found[at*LW_KEEP + (size_t)i].f = INFINITY;
    if (lw_search_stopped(s))
        return;
    lw_problem *p = lw_search_problem(s, thread, job->candidate, true, &job->status);
    if (p)
        search_in(s, at, p, thread);
    if (s->no_memory)
        job->status = LW_E_MEMORY;
}

/* A find to polish on the full target, and the outcome. */
typedef struct polish {
    lw_found     find;
    long         spent;                      /* evaluations of the polish alone                  */
    lw_variables of;
    lw_status    status;
} polish;

typedef struct polish_list {
    lw_search *s;
    int n;
    double until;                            /* wall clock; 0: no limit                           */
    const volatile int *interrupt;           /* NULL if the search was asked to stop before: until says when   */
    atomic_bool any;                         /* there is a result: none is begun any more after `until`        */
    polish item[LW_POOL_MAX];
} polish_list;

/* An empty list; NULL: no memory. */
static polish_list *new_list(lw_search *s)
{
    polish_list *list = calloc(1, sizeof *list);
    if (list) {
        list->s = s;
        list->interrupt = s->o->interrupt && *s->o->interrupt ? NULL : s->o->interrupt;
    }
    return list;
}

/* A search that was stopped wants one result soon: of a target of MANY stations only one find is begun at a time. */
#define MANY 1000

static lw_status run_list(lw_search *s, polish_list *list, lw_job *run)
{
    int n_thread = s->t->n >= MANY && lw_search_stopped(s) ? 1 : s->n_thread;
    const lw_loop loop = { n_thread, (size_t)list->n, run, list, { { list->item, sizeof *list->item }, { NULL, 0 } } };
    return lw_loop_run(&loop, s->o->sharing);
}

/* The coarse and the fine problem have scales of their own: convert by the user's frame. */
static void refine_variables(const lw_problem *coarse, const lw_problem *fine, double *x)
{
    double dim[LW_DIM_MAX], to[LW_VAR_MAX];
    lw_problem_to_dims(coarse, x, dim);
    lw_problem_from_dims(fine, dim, to);
    memcpy(x, to, sizeof *x*(size_t)fine->n_dim);
}

/* Steps of a fit that may cost so many evaluations, each of which counts as `cost`. */
static int steps_of(long allowance, int cost, int most)
{
    long steps = allowance/cost;
    return steps < 1 ? 1 : steps < most ? (int)steps : most;
}

/* Steps of the polish of a find.  A step of higher groups costs most, and along a narrow valley one thread takes longer than all others
 * for the rest of the round: beside finds of earlier rounds that is limited. */
static int polish_steps(const lw_search *s, const lw_problem *p, int cost)
{
    int steps = steps_of(lw_search_budget(s)/POLISH_PART, cost, POLISH_STEPS);
    bool limited = p->plan.n_higher > 0 && s->pool.n > 0;
    return !limited ? POLISH_STEPS : steps > POLISH_GROUPS ? steps : POLISH_GROUPS;
}

/* Improve a find until it converges; f becomes INFINITY if it does not meet the conditions. */
static void polish_one(void *context, size_t job, int thread)
{
    polish_list *list = context;
    lw_search *s = list->s;
    polish *l = &list->item[job];
    lw_found *c = &l->find;
    lw_problem *p = lw_search_problem(s, thread, c->candidate, false, &l->status);
    const lw_problem *searched = p ? lw_search_made(s, thread, c->candidate, true, &l->status) : NULL;
    void *work = s->bench[thread].work;
    lw_lm_options o = lw_lm_options_default();
    if (list->any && ((list->interrupt && *list->interrupt) || (list->until > 0 && lw_clock_wall() > list->until)))
        c->f = INFINITY;
    if (!searched || !isfinite(c->f))
        return;
    const int cost = lw_search_effort(s, p).cost;
    o.max_steps = polish_steps(s, p, cost);
    o.f_tol = 1e-12;
    o.bend = s->o->families && (c->f < ALMOST || !lw_problem_is_nonlinear(p));
    o.until = list->until;
    o.interrupt = list->interrupt;
    l->of = lw_pool_variables(p);
    if (s->thin.n > 0 && !c->polished)
        refine_variables(searched, p, c->x);
    lw_lm_feasible(p, c->x, work);
    p->intended = c->intended;
    lw_problem_work_intended(p, work);
    l->spent = -c->evals;
    lw_search_improve(s, p, &o, true, work, c);
    l->spent += c->evals;
    l->spent *= cost;
    lw_search_judge(s, p, work, c);
    if (isfinite(c->f))
        list->any = true;
}

/* Count how often the search found its best, which decides when it ends. */
static void count_hits(lw_search *s, double f)
{
    if (f < s->best_raw*(1 - HIT)) {
        s->best_raw = f;
        s->hits = 1;
    } else if (f <= s->best_raw*(1 + HIT))
        s->hits++;
}

static void take(const lw_found *c, polish_list *list)
{
    list->item[list->n++].find = *c;
}

static bool is_taken(const lw_found *c, const polish_list *list)
{
    bool taken = false;
    for (int i = 0; i < list->n && !taken; i++)
        taken = list->item[i].find.candidate == c->candidate && list->item[i].find.f == c->f;
    return taken;
}

static const char *type_of(const lw_search *s, const lw_found *c)
{
    return lw_family_type(s->candidate[c->candidate].row);
}

/* best: the best find of each type in this round.  Returns the number of types. */
static int best_of_types(const lw_search *s, const lw_found **best)
{
    int n_type = 0;
    for (int i = 0; i < s->n_job*LW_KEEP; i++) {
        const lw_found *c = &s->found[i];
        int k = 0;
        if (!isfinite(c->f))
            continue;
        while (k < n_type && type_of(s, best[k]) != type_of(s, c))
            k++;
        if (k == n_type)
            best[n_type++] = c;
        else if (c->f < best[k]->f)
            best[k] = c;
    }
    return n_type;
}

/* The best finds of the round, or of its jobs that drew new starts, each linkage once. */
static const lw_pool *best_of_round(lw_search *s, bool of_new)
{
    s->raw.n = 0;
    for (int i = 0; i < s->n_job*LW_KEEP; i++)
        if (!of_new || !s->job[i/LW_KEEP].around)
            lw_pool_put(&s->raw, &s->found[i], &s->job[i/LW_KEEP].of);
    return &s->raw;
}

/* List the round's best finds, each linkage once, and the best of every type, because a user who allows several types
 * compares them. */
static void pick(lw_search *s, polish_list *list)
{
    const lw_found *best[LW_SEARCH_CANDIDATE_MAX];
    list->n = 0;
    for (int i = 0; i < s->n_job*LW_KEEP; i++)
        if (isfinite(s->found[i].f))
            count_hits(s, s->found[i].f);
    bool near_miss = s->best_raw < LW_SEARCH_NEAR_MISS;
    for (int of_new = 0; of_new <= near_miss; of_new++) {
        const lw_pool *raw = best_of_round(s, of_new);
        for (int i = 0; i < raw->n && list->n < (near_miss && !of_new ? POLISH/2 : POLISH); i++)
            if (!of_new || !is_taken(&raw->item[i], list))
                take(&raw->item[i], list);
    }
    int n_type = s->o->families ? 0 : best_of_types(s, best), n_raw = list->n;
    for (int k = 0; k < n_type; k++) {
        bool taken = false;
        for (int i = 0; i < n_raw; i++)
            taken |= type_of(s, &list->item[i].find) == type_of(s, best[k]);
        if (!taken)
            take(best[k], list);
    }
}

/* Add the finds of a job to the best finds of its candidate. */
static void remember(lw_search *s, const lw_search_job *job, const lw_found *found, lw_search_candidate *a)
{
    lw_pool *best = &s->raw;
    best->n = 0;
    for (int i = 0; a->best && i < a->best->n; i++)
        lw_best_starts_get(a->best, i, &best->item[best->n++]);
    for (int i = 0; i < LW_KEEP; i++)
        lw_pool_put(best, &found[i], &job->of);
    lw_best_starts *more = lw_best_starts_of(best, LW_SEARCH_CANDIDATE_BEST, &job->of, job->n_mode);
    if (more) {
        free(a->best);
        a->best = more;
    } else if (best->n > 0)
        s->no_memory = true;
}

/* Update the candidates and the totals by the jobs of a round. */
static lw_status update_candidates(lw_search *s, lw_error *e)
{
    for (int j = 0; j < s->n_job; j++) {
        const lw_search_job *job = &s->job[j];
        lw_search_candidate *a = &s->candidate[job->candidate];
        s->evals += job->evals;
        s->improved += job->improved;
        a->starts += job->block;
        if (job->status == LW_E_KIND && s->o->families)
            a->state = LW_FIT_UNABLE;
        else if (job->status != LW_OK)
            return lw_search_fault(s, job->candidate, e);
        if (job->block == 0)
            continue;
        for (int i = 0; i < LW_KEEP && lw_search_climbs(s) && !s->o->families; i++) {
            lw_found *c = &s->found[j*LW_KEEP + i];
            if (isfinite(c->f) && isfinite(c->cost))
                lw_pool_put(&s->light, c, &job->of);
            c->f = c->guided ? INFINITY : c->f;
        }
        if (s->o->families)
            remember(s, job, s->found + j*LW_KEEP, a);
        a->state = a->best ? LW_FIT_CLOSED : LW_FIT_LOOKED;
    }
    return LW_OK;
}

static lw_status make_memory(lw_search *s, lw_error *e)
{
    if (s->n_job <= s->n_found)
        return LW_OK;
    free(s->found);
    s->n_found = s->n_job;
    s->found = malloc(sizeof *s->found*LW_KEEP*(size_t)s->n_job);
    return s->found ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for the finds of a round");
}

static lw_status polish_round(lw_search *s, polish_list *list, lw_error *e)
{
    pick(s, list);
    if (s->pool.n > 0 && s->pool.item[0].f < LW_SEARCH_NEAR_MISS && s->pool.item[0].stop == LW_STOP_EVALS)
        take(&s->pool.item[0], list);                    /* its polish goes on: a narrow valley takes thousands of steps */
    if (s->o->max_seconds > 0 || lw_search_stopped(s))
        list->until = (lw_search_stopped(s) ? lw_clock_wall() : lw_search_end(s)) + lw_search_grace(s);
    list->any = s->pool.n > 0;
    lw_status st = run_list(s, list, polish_one);
    if (st != LW_OK)
        return lw_error_set(e, st, "%s", lw_status_text(st));
    for (int i = 0; i < list->n; i++) {
        const polish *l = &list->item[i];
        if (l->status != LW_OK)
            return lw_search_fault(s, l->find.candidate, e);
        lw_pool_put(&s->pool, &l->find, &l->of);
        s->evals += l->spent;
    }
    return LW_OK;
}

lw_status lw_search_round(lw_search *s, lw_error *e)
{
    lw_status st = make_memory(s, e);
    if (st != LW_OK)
        return st;
    const lw_loop loop = { s->n_thread, (size_t)s->n_job, search_job, s,
                           { { s->found, LW_KEEP*sizeof *s->found }, { s->job, sizeof *s->job } } };
    if ((st = lw_loop_run(&loop, s->o->sharing)) != LW_OK)
        return lw_error_set(e, st, "%s", lw_status_text(st));
    if ((st = update_candidates(s, e)) != LW_OK)
        return st;
    if (s->o->whole_rounds && s->n_job <= SHORT_ROUND && lw_search_stopped(s))
        return LW_OK;
    polish_list *list = new_list(s);
    st = list ? polish_round(s, list, e) : lw_error_set(e, LW_E_MEMORY, "no memory for the finds of a round");
    free(list);
    return st;
}

/* ---- stations in order ------------------------------------------------------------------------------------- */

/* The find of a search without timing as one of candidate k with ordered stations. */
static lw_status order_one(lw_search *s, int k, int sense, lw_found *c, lw_variables *of)
{
    lw_status st;
    lw_problem *p = lw_search_problem(s, 0, k, false, &st);
    void *work = s->bench[0].work;
    if (!p)
        return st == LW_E_KIND ? LW_OK : st;
    c->candidate = k;
    c->intended.sense = sense;
    p->intended = c->intended;
    *of = lw_pool_variables(p);
    lw_problem_work_intended(p, work);
    lw_search_judge(s, p, work, c);
    return LW_OK;
}

lw_status lw_search_order_stations(lw_search *s, lw_fit *out, lw_error *e)
{
    int n = s->n_candidate;
    lw_status st = LW_OK;
    lw_search_candidate *before = s->candidate;
    lw_pool *found = malloc(sizeof *found);
    if (!found)
        return LW_E_MEMORY;
    *found = s->pool;
    s->pool.n = 0;
    s->own.spec.timing = LW_TIMING_FREE;
    for (int i = 0; i < s->n_thread; i++)
        lw_search_empty_slots(&s->bench[i]);
    if (!s->o->families) {
        for (int i = 0; i < n; i++)
            s->starts += before[i].starts;
        s->candidate = NULL;
        s->n_candidate = 0;
        st = lw_search_make_candidates(s, out, e);
    }
    for (int i = 0; i < found->n && st == LW_OK; i++) {
        const lw_search_candidate *b = &before[found->item[i].candidate];
        lw_found best = { .f = INFINITY };
        lw_variables of;
        for (int k = 0; k < s->n_candidate && st == LW_OK; k++) {
            const lw_search_candidate *a = &s->candidate[k];
            bool mine = s->o->families ? k == found->item[i].candidate : a->row == b->row && a->mode == b->mode;
            for (int sense = -1; mine && sense <= 1 && st == LW_OK; sense += 2) {
                lw_found now = found->item[i];
                if (!s->o->families && sense != a->sense)
                    continue;
                st = order_one(s, k, sense, &now, &of);
                best = now.f < best.f ? now : best;
            }
        }
        if (isfinite(best.f))
            lw_pool_put(&s->pool, &best, &of);
    }
    if (!s->o->families) {
        for (int i = 0; i < n; i++)
            free(before[i].best);
        free(before);
    }
    free(found);
    return st;
}

/* ---- the front ------------------------------------------------------------------------------------------- */

/* A find is fitted again in chains, one for each of these least transmission angles [deg]: every fit begins with the linkage of
 * the one before, whose size is the most times SHRINK.  If the smallest linkage within a tolerance is asked for, chains in finer
 * steps follow, the last from the smallest linkages within it; what they find is kept apart, so that the search is the same without it. */
static const double chain_angle[] = { 0, 30, 40 };
enum { CHAINS = sizeof chain_angle/sizeof *chain_angle, WIDENED = 4, CHAIN = 9, LONG_CHAIN = 16, FAILURES = 2, FRONT = 24 };
/* A chain follows one kind of linkage and may get stuck.  So the best finds of all chains are then fitted again at common sizes, the
 * rungs, for each angle: the best of this size, a larger one made smaller, and one whose angle is made greater. */
enum { RUNGS = 16, RUNG_STEPS = 300 };
#define LARGEST_RUNG 3.2         /* diagonals of the target; each rung is STEP times the one before.  Of a function ... */
#define LARGEST_RATIO 8          /* ... the ratio of lengths                                           */
#define SHRINK       0.8
static const double shrink_within[] = { 0.88, 0.96, 0.985 };
#define ROUGH        0.05        /* sizes of the target: a chain ends where the error is more, and ... */
#define MUCH_WORSE   100         /* ... the objective so many times that of the find                 */
#define STEP         0.9         /* size of a rung over that of the rung before                       */
#define KEPT_STEP    0.95        /* a find is kept beside better ones if its size over theirs is less */
#define TWIN         0.01        /* relative difference of f of linkages that differ little           */

/* Is the smallest linkage within a tolerance asked for? */
static bool is_smallest_wanted(const lw_search *s)
{
    return s->o->spec.tolerance > 0 && lw_task_has_place(s->o->spec.task);
}

typedef struct chain {
    lw_found     find[LONG_CHAIN];           /* the first is given; f INFINITY: none                 */
    double       size[LONG_CHAIN];           /* of each; 0: none.  Within the tolerance uneven ones count as larger */
    long         spent;
    lw_variables of;
    lw_status    status;
} chain;

typedef struct chain_list {
    lw_search *s;
    int        n;
    double     until;                        /* wall clock; 0: no limit                              */
    double     shrink;                       /* factor of the size from step to step                 */
    bool       within;                       /* finds shall stay within the tolerance                */
    int        n_rung;                       /* items after the chains                               */
    long       allowance;                    /* evaluations of an item, counted by their cost        */
    double     largest;                      /* size of the first rung, scaled                       */
    chain      item[(WIDENED + RUNGS)*CHAINS];      /* chains, then rungs, each a chain of one find; item i has angle i % CHAINS */
} chain_list;

/* Make the whole linkage smaller; one whose longest dimensions alone are cut may not close. */
static void scale_linkage(const lw_problem *p, double factor, double *x)
{
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind != LW_DIM_ANGLE)
            x[i] *= factor;
}

/* Fit *c again with a size of `most` at most.  false, *c untouched but for its evaluations: no linkage was found, or its error is
 * so great that nobody wants it. */
static bool fit_smaller(lw_search *s, lw_problem *p, double most, double f_rough, const lw_lm_options *o, void *work, lw_found *c)
{
    lw_problem_limit_size(p, most);
    for (int scaled = 0; scaled < (lw_task_has_place(p->task) ? 2 : 1); scaled++) {
        lw_found now = *c;
        if (scaled)
            scale_linkage(p, most/fmax(most, lw_problem_size(p, now.x)), now.x);
        if (lw_lm_feasible(p, now.x, work))
            lw_search_improve(s, p, o, true, work, &now);
        else
            now.f = INFINITY;
        c->evals = now.evals;
        if (now.f <= f_rough) {
            *c = now;
            return true;
        }
    }
    return false;
}

/* Does the find keep all conditions and, at the inputs that were found last, stay within the tolerance at every station? */
static bool is_within(const lw_search *s, const lw_problem *p, const lw_work *w, const lw_found *c)
{
    double most = 0;
    for (size_t k = 0; k < p->n; k++)
        most = fmax(most, hypot(w->jac.x[k] - p->x[k], w->jac.y[k] - p->y[k]));
    return isfinite(c->f) && c->beyond == 0 && most*p->unit <= s->o->spec.tolerance;
}

static lw_lm_options chain_options(const chain_list *list, int steps, int cost)
{
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = steps_of(list->allowance, cost, steps);
    o.f_tol = 1e-9;
    o.until = list->until;
    o.interrupt = list->s->o->interrupt;
    return o;
}

static bool chains_end(const lw_lm_options *o)
{
    return (o->until > 0 && lw_clock_wall() > o->until) || (o->interrupt && *o->interrupt);
}

static void run_chain(void *context, size_t job, int thread)
{
    chain_list *list = context;
    lw_search *s = list->s;
    chain *l = &list->item[job];
    const bool fine = list->within;
    int length = fine ? LONG_CHAIN : CHAIN, angle = (int)job % CHAINS, failed = 0;
    lw_found now = l->find[0];
    lw_problem *p = lw_search_problem_again(s, thread, chain_angle[angle], &now, &l->status);
    void *work = s->bench[thread].work;
    l->find[0].f = INFINITY;
    if (!p)
        return;
    const int cost = lw_search_effort(s, p).cost;
    const lw_lm_options o = chain_options(list, POLISH_STEPS, cost);
    l->of = lw_pool_variables(p);
    l->spent = -now.evals;
    double most = lw_problem_size(p, now.x), f_rough = fmax(MUCH_WORSE*now.f, ROUGH*ROUGH*(double)p->n);
    const double tolerance = s->o->spec.tolerance/p->unit;
    if (fine)                                            /* beyond the tolerance in the mean                        */
        f_rough = (double)p->n*tolerance*tolerance;
    for (int k = angle == 0; k < length && failed < FAILURES; k++) {
        if (chains_end(&o) || (l->spent + now.evals)*cost > list->allowance)
            break;
        if (!fit_smaller(s, p, most*pow(list->shrink, k), f_rough, &o, work, &now)) {
            failed++;
            continue;
        }
        l->find[k] = now;
        lw_search_judge(s, p, work, &l->find[k]);
        if (fine && !is_within(s, p, work, &l->find[k])) {
            l->find[k].f = INFINITY;
            failed++;
            continue;
        }
        failed = 0;
        l->size[k] = lw_problem_size(p, now.x)*(fine ? lw_problem_uneven(p, now.x) : 1);
    }
    l->spent = (l->spent + now.evals)*cost;
}

/* One find of the chains that is not taken yet. */
typedef struct place { int chain, at; } place;

static const lw_found *found_at(const chain_list *list, place of) { return &list->item[of.chain].find[of.at]; }
static double size_at(const chain_list *list, place of) { return list->item[of.chain].size[of.at]; }

/* The find with the least f of the chains with these angles, of at most this size, that keeps the conditions; chain -1: none. */
static place best_find(const chain_list *list, double most, int low, int high)
{
    place best = { -1, 0 };
    for (int i = 0; i < list->n; i++)
        for (int k = 0; k < LONG_CHAIN && i % CHAINS >= low && i % CHAINS <= high; k++) {
            const lw_found *c = &list->item[i].find[k];
            if (list->item[i].size[k] > 0 && list->item[i].size[k] <= most && isfinite(c->f) && c->beyond == 0
                && (best.chain < 0 || c->f < found_at(list, best)->f))
                best = (place){ i, k };
        }
    return best;
}

/* Fit the best finds again with the size and the angle of a rung, and keep the best. */
static void run_rung(void *context, size_t job, int thread)
{
    chain_list *list = context;
    lw_search *s = list->s;
    chain *l = &list->item[(size_t)list->n + job];
    int angle = (int)job % CHAINS;
    double most = list->largest*pow(STEP, (double)(job/CHAINS));
    const place start[] = { best_find(list, most, angle, CHAINS - 1), best_find(list, most/SHRINK, angle, CHAINS - 1),
                            best_find(list, most, 0, angle - 1) };
    for (size_t i = 0; i < sizeof start/sizeof *start && l->spent <= list->allowance; i++) {
        if (start[i].chain < 0 || (i > 0 && start[i].chain == start[0].chain && start[i].at == start[0].at))
            continue;
        lw_found now = *found_at(list, start[i]);
        lw_problem *p = lw_search_problem_again(s, thread, chain_angle[angle], &now, &l->status);
        void *work = s->bench[thread].work;
        long before = now.evals;
        if (!p)
            return;
        const int cost = lw_search_effort(s, p).cost;
        const lw_lm_options o = chain_options(list, RUNG_STEPS, cost);
        if (chains_end(&o))
            return;
        bool found = fit_smaller(s, p, most, ROUGH*ROUGH*(double)p->n, &o, work, &now);
        l->spent += (now.evals - before)*cost;
        if (found)
            lw_search_judge(s, p, work, &now);
        if (!found || !(now.f < l->find[0].f))
            continue;
        l->find[0] = now;
        l->size[0] = lw_problem_size(p, now.x);
        l->of = lw_pool_variables(p);
    }
}

/* The find with the least f of those not taken, and of equal ones the one with the greatest angle; chain -1: none. */
static place next_find(const chain_list *list, bool taken[][LONG_CHAIN])
{
    place best = { -1, 0 };
    for (int i = 0; i < list->n + list->n_rung; i++)
        for (int k = 0; k < LONG_CHAIN; k++) {
            const lw_found *c = &list->item[i].find[k];
            if (taken[i][k] || !(list->item[i].size[k] > 0) || !isfinite(c->f))
                continue;
            double than = best.chain >= 0 ? found_at(list, best)->f : INFINITY;
            bool gentler = best.chain >= 0 && i % CHAINS > best.chain % CHAINS;
            if (gentler ? c->f <= than*(1 + HIT) : c->f < than*(best.chain >= 0 ? 1 - HIT : 1))
                best = (place){ i, k };
        }
    return best;
}

/* Put finds into the pool that are smaller by KEPT_STEP than all those with less f, or have a greater angle: the pool keeps the least f,
 * and would lose the smallest linkages if others filled it. */
static void put_front(const chain_list *list, lw_pool *pool)
{
    bool taken[(WIDENED + RUNGS)*CHAINS][LONG_CHAIN] = { { false } };
    place kept[(WIDENED*LONG_CHAIN + RUNGS)*CHAINS];
    int n = 0;
    for (place now; (now = next_find(list, taken)).chain >= 0; ) {
        const lw_found *c = found_at(list, now);
        bool wanted = true;
        taken[now.chain][now.at] = true;
        for (int i = 0; i < n && wanted; i++)
            wanted = !(found_at(list, kept[i])->beyond <= c->beyond && kept[i].chain % CHAINS >= now.chain % CHAINS
                       && size_at(list, kept[i])*KEPT_STEP <= size_at(list, now));
        if (!wanted)
            continue;
        kept[n++] = now;
        lw_pool_put(pool, c, &list->item[now.chain].of);
    }
}

/* Put the two smallest finds of each chain into the pool: between the stations the smallest may leave the tolerance. */
static void put_smallest(const chain_list *list, lw_pool *pool)
{
    for (int i = 0; i < list->n; i++) {
        const chain *l = &list->item[i];
        for (int k = LONG_CHAIN - 1, kept = 0; k >= 0 && kept < 2; k--)
            if (l->size[k] > 0) {
                lw_pool_put(pool, &l->find[k], &l->of);
                kept++;
            }
    }
}

/* A find to begin chains with.  rank: the same for finds whose f differ by rounding only, which must not decide: the largest
 * comes first, so that others follow that are smaller by SHRINK each. */
typedef struct beginning { const lw_found *find; int rank; double size; } beginning;

static int by_rank_and_size(const void *a, const void *b)
{
    const beginning *p = a, *q = b;
    int order = (p->size < q->size) - (p->size > q->size);
    return p->rank != q->rank ? p->rank - q->rank : order;
}

/* The finds to begin chains with, into first[], among those that keep the conditions as well as the best does: those that are smaller
 * than all better ones, then others of another error.  Returns their number. */
static int choose_widened(lw_search *s, lw_found *first)
{
    const lw_found *item = s->pool.item;
    beginning of[LW_POOL_MAX];
    int n = 0, chosen = 0;
    double f = -INFINITY, least = INFINITY;
    for (; n < s->pool.n && item[n].beyond == item[0].beyond; n++) {
        lw_status st;
        const lw_problem *p = lw_search_made(s, 0, item[n].candidate, false, &st);
        bool worse = item[n].f > f*(1 + HIT) + NEARLY_ROUNDING;
        of[n] = (beginning){ &item[n], n > 0 ? of[n - 1].rank + worse : 0, p ? lw_problem_size(p, item[n].x) : INFINITY };
        f = worse ? item[n].f : f;
    }
    qsort(of, (size_t)n, sizeof *of, by_rank_and_size);
    for (int smaller = 1; smaller >= 0; smaller--)
        for (int i = 0; i < n && chosen < WIDENED; i++) {
            bool twin = smaller && !(of[i].size < SHRINK*least);
            for (int k = 0; k < chosen && !twin && !smaller; k++)
                twin = fabs(first[k].f - of[i].find->f) <= TWIN*of[i].find->f;
            if (twin)
                continue;
            least = fmin(least, of[i].size);
            first[chosen++] = *of[i].find;
        }
    return chosen;
}

/* The size of a find within the tolerance, an uneven one as a larger one; INFINITY: it is not within. */
static double size_within(lw_search *s, const lw_found *c)
{
    lw_status st;
    lw_problem *p = lw_search_problem(s, 0, c->candidate, false, &st);
    if (!p)
        return INFINITY;
    p->intended = c->intended;
    lw_problem_work_intended(p, s->bench[0].work);
    bool within = lw_problem_settle(p, c->x, s->bench[0].work) && is_within(s, p, s->bench[0].work, c);
    return within ? lw_problem_size(p, c->x)*lw_problem_uneven(p, c->x) : INFINITY;
}

/* The smallest finds that stay within the tolerance, one of each candidate and angle, into first[]; returns their number. */
static int choose_smallest(lw_search *s, lw_found *first)
{
    const lw_found *find[2*LW_POOL_MAX];
    double size[2*LW_POOL_MAX];
    int chosen = 0, n = 0;
    for (int i = 0; i < s->pool.n; i++)
        find[n++] = &s->pool.item[i];
    for (int i = 0; i < s->shrunk.n; i++)
        find[n++] = &s->shrunk.item[i];
    for (int i = 0; i < n; i++)
        size[i] = size_within(s, find[i]);
    for (int least = 0; chosen < WIDENED && least >= 0; ) {
        least = -1;
        for (int i = 0; i < n; i++) {
            bool seen = false;
            for (int k = 0; k < chosen && !seen; k++)
                seen = first[k].candidate == find[i]->candidate && first[k].gentle == find[i]->gentle;
            if (!seen && isfinite(size[i]) && (least < 0 || size[i] < size[least]))
                least = i;
        }
        if (least >= 0)
            first[chosen++] = *find[least];
    }
    return chosen;
}

/* Make the list one of chains that begin with these n finds. */
static void begin_chains(chain_list *list, const lw_found *first, int n)
{
    list->n = n*CHAINS;
    list->n_rung = list->within || n == 0 ? 0 : RUNGS*CHAINS;
    for (int i = 0; i < list->n + list->n_rung; i++) {
        chain *l = &list->item[i];
        memset(l, 0, sizeof *l);
        for (int k = 0; k < LONG_CHAIN; k++)
            l->find[k].f = INFINITY;
        if (i < list->n)
            l->find[0] = first[i/CHAINS];
    }
}

/* Run chains that begin with these n finds, and put what they find into the pool. */
static lw_status run_chains(lw_search *s, chain_list *list, const lw_found *first, int n, lw_pool *pool)
{
    begin_chains(list, first, n);
    list->allowance = s->o->families && list->n > 0 ? lw_search_budget(s)/(list->n + list->n_rung) : LONG_MAX;
    const lw_loop loop = { s->n_thread, (size_t)list->n, run_chain, list, { { list->item, sizeof *list->item }, { NULL, 0 } } };
    lw_status st = lw_loop_run(&loop, s->o->sharing);
    chain *rung = list->item + list->n;
    const lw_loop again = { s->n_thread, (size_t)list->n_rung, run_rung, list, { { rung, sizeof *rung }, { NULL, 0 } } };
    if (st == LW_OK && list->n_rung > 0)
        st = lw_loop_run(&again, s->o->sharing);
    for (int i = 0; i < list->n + list->n_rung && st == LW_OK; i++) {
        chain *l = &list->item[i];
        st = l->status;
        s->evals += l->spent;
    }
    if (st == LW_OK)
        (list->within ? put_smallest : put_front)(list, pool);
    return st;
}

lw_status lw_search_widen(lw_search *s, lw_status (*go_on)(lw_search *s, double until))
{
    lw_pool *pool = &s->pool;
    if (!lw_search_widens(s) || (s->o->interrupt && *s->o->interrupt))
        return LW_OK;
    int left = s->o->both_ways ? LW_POOL_MAX - FRONT : LW_SEARCH_LEFT;      /* ordered stations may hide the nearest curves   */
    chain_list *list = calloc(1, sizeof *list);
    lw_found first[WIDENED];
    int n = choose_widened(s, first);
    if (!list)
        return LW_E_MEMORY;
    list->s = s;
    if (n > 0) {
        lw_status made;
        const lw_problem *p = lw_search_made(s, 0, first[0].candidate, false, &made);
        list->largest = !lw_task_has_place(s->o->spec.task) ? LARGEST_RATIO : p ? LARGEST_RUNG*s->t->extent/p->unit : 0;
    }
    lw_pool_shorten(pool, left);
    list->until = lw_search_end(s) + lw_search_widening(s) + 0.5*lw_search_grace(s);
    if (s->o->max_seconds <= 0)
        list->until = lw_search_stopped(s) ? lw_clock_wall() + lw_search_grace(s) : 0;
    list->shrink = SHRINK;
    lw_status st = run_chains(s, list, first, n, pool);
    if (st == LW_OK)
        st = go_on(s, list->until);
    list->within = true;
    for (size_t i = 0; is_smallest_wanted(s) && i < sizeof shrink_within/sizeof *shrink_within && st == LW_OK; i++) {
        n = i > 0 ? choose_smallest(s, first) : n;
        list->shrink = shrink_within[i];
        st = run_chains(s, list, first, n, &s->shrunk);
    }
    free(list);
    return st == LW_OK && s->no_memory ? LW_E_MEMORY : st;
}
