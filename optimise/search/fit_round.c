/* optimise/search/fit_round.c - one round of the search: low-discrepancy starts, the better ones improved, the
 * best polished. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "optimise/search/fit_internal.h"
#include "optimise/solvers/lm.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "optimise/search/random_linkage.h"
#include "optimise/problem/constraint.h"
#include "optimise/problem/residuals.h"
#include "optimise/search/start.h"

enum {
    IMPROVE = 12,           /* starts of a job that are improved, at most                          */
    FIRST_STEPS = 40,       /* of each of these                                                   */
    FULL_STEPS = 120,       /* of the LW_KEEP that are handed on                                  */
    DEAR = 2,               /* that go on where conditions on the motion cost most                */
    POLISH = 8              /* of a round's finds, polished                                       */
};
#define GRACE 0.5           /* for the polish of what was found when time is over [s]                */
#define MET   1e-6          /* conditions of what is handed on are met to this                       */

bool lw_search_stopped(const lw_search *s)
{
    return (s->o->interrupt && *s->o->interrupt)
        || (s->o->max_seconds > 0 && lw_clock_wall() - s->started > s->o->max_seconds);
}

typedef struct glance { double rest; int which; } glance;

static int by_rest(const void *a, const void *b)
{
    const glance *p = a, *q = b;
    return p->rest < q->rest ? -1 : p->rest > q->rest ? 1 : p->which - q->which;
}

/* Which draws of a block are worth settling: all where that is cheap, else the best by a first look. */
static int choose_draws(const lw_effort *a, lw_problem *p, const double *u, int d, void *work, glance *g)
{
    for (int i = 0; i < a->block; i++) {
        g[i].which = i;
        g[i].rest = p->timing == LW_TIMING_PRESCRIBED ? 0 : lw_start_glance(p, u + i*d, work);
    }
    if (p->timing == LW_TIMING_PRESCRIBED)
        return a->block;
    qsort(g, (size_t)a->block, sizeof *g, by_rest);
    return a->settle;
}

/* Put c among the n best; returns how many there are now. */
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

/* The best starts of a block, in order. */
static int screen(const lw_effort *a, lw_problem *p, lw_rng *rng, void *work, lw_found *best)
{
    double u[LW_SEARCH_BLOCK*LW_START_DRAWS];
    glance g[LW_SEARCH_BLOCK];
    int n = 0, d = lw_start_draws(p);
    if (!lw_low_discrepancy(rng, (size_t)a->block, d, u))
        return 0;
    int chosen = choose_draws(a, p, u, d, work, g);
    for (int i = 0; i < chosen && isfinite(g[i].rest); i++) {
        lw_found c;
        c.f = lw_start(p, u + g[i].which*d, c.x, work);
        c.branch = p->branch;
        n = put_in_order(best, n, a->improve, &c);
    }
    return n;
}

/* Starts around what the arm found: all variables moved a little, or some of them farther. */
static int look_around(const lw_best_starts *few, const lw_effort *a, lw_problem *p, lw_rng *rng, void *work, lw_found *best)
{
    int n = 0;
    for (int i = 0; few && i < a->settle; i++) {
        lw_found c;
        lw_best_starts_get(few, (int)(lw_rng_uniform(rng)*few->n), &c);
        double far = exp(-1 - 4*lw_rng_uniform(rng)), part = lw_rng_uniform(rng) < 0.5 ? 1 : 0.3;
        p->branch = c.branch;
        lw_problem_work_branch(p, work);
        for (int v = 0; v < p->n_var; v++)
            if (lw_rng_uniform(rng) < part)
                c.x[v] += far*fmax(0.1, fabs(c.x[v]))*lw_rng_normal(rng);
        c.f = lw_lm_feasible(p, c.x) ? lw_problem_value(p, c.x, NULL, work) : INFINITY;
        n = put_in_order(best, n, a->improve, &c);
    }
    return n;
}

/* The user's solver from where the start stands. */
static void run_solver(const lw_search *s, const lw_solver *solver, const lw_problem *p, long evals, double until,
                       lw_found *c)
{
    lw_solver_options o = lw_solver_options_default();
    lw_solver_result r;
    o.seed = s->o->seed;
    o.max_evals = evals;
    o.interrupt = s->o->interrupt;
    o.max_seconds = until > 0 ? fmax(1e-3, until - lw_clock_wall()) : 0;
    lw_status st = solver->run(p, &o, c->x, &r);
    c->f = st >= 0 && st != LW_NOTHING ? r.f : INFINITY;
    c->evals += r.evals;
    c->stop = r.stop;
}

/* Improve c: least squares by default, a solver with conditions where these are violated (if they are looked
 * at already). */
static void improve(const lw_search *s, const lw_problem *p, const lw_lm_options *o, bool conditions, void *work,
                    lw_found *c)
{
    const lw_solver *mine = s->o->solver;
    if (mine && mine->run != lw_lm_run) {
        run_solver(s, mine, p, 10L*o->max_steps, o->until, c);
        return;
    }
    c->f = conditions ? lw_lm_conditioned(p, o, c->x, work, &c->evals, &c->stop)
                      : lw_lm_improve(p, o, c->x, false, work, &c->evals, &c->stop);
}

/* Least squares from each of n starts, at most so many steps; then in order of f. */
static void improve_all(const lw_search *s, lw_problem *p, int steps, int n, void *work,
                        lw_found *best)
{
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = steps;
    o.f_hopeless = 1e4*s->best_raw;
    o.patience = FIRST_STEPS;
    o.interrupt = s->o->interrupt;
    o.until = s->o->max_seconds > 0 ? s->started + s->o->max_seconds : 0;
    for (int i = 0; i < n && !lw_search_stopped(s); i++) {
        p->branch = best[i].branch;
        lw_problem_work_branch(p, work);
        improve(s, p, &o, !p->family->linkage || steps > FIRST_STEPS, work, &best[i]);
        if (p->plan.n_higher > 0 && isfinite(best[i].f))             /* the seeds move with the linkage */
            lw_plan_seed(&p->plan, best[i].x, p->branch.mode[p->plan.n_mode - 1], best[i].branch.mode);
    }
    for (int i = 1; i < n; i++) {
        lw_found c = best[i];
        int at = i;
        for (; at > 0 && best[at - 1].f > c.f; at--)
            best[at] = best[at - 1];
        best[at] = c;
    }
}

/* The starts of one job, in order of f. */
static int starts_of(lw_search *s, size_t job, const lw_effort *effort, lw_problem *p, void *work, lw_found *best)
{
    const lw_search_candidate *a = &s->arm[s->job[job].arm];
    lw_rng rng;
    uint64_t round = (uint64_t)s->round*(s->o->families ? LW_JOB_MAX : LW_SEARCH_CANDIDATE_MAX*8);
    lw_rng_seed(&rng, s->o->seed, round + job);
    if (s->job[job].around)
        return look_around(a->best, effort, p, &rng, work, best);
    int n = screen(effort, p, &rng, work, best);
    if (p->family->posture && a->starts == 0) {
        lw_found c;
        c.f = lw_random_linkage_posture(p, c.x, work) ? lw_problem_value(p, c.x, NULL, work) : INFINITY;
        c.branch = p->branch;
        n = put_in_order(best, n, effort->improve, &c);
    }
    return n;
}

/* Local fits of the best starts of one job: all of them a little, the best of these further; LW_KEEP
 * go to the pool. */
static void search_in(lw_search *s, size_t at, lw_problem *p, void *work)
{
    lw_search_job *job = &s->job[at];
    lw_found best[IMPROVE], *keep = s->found + at*LW_KEEP;
    lw_effort effort = lw_search_effort(s, p);
    int n = starts_of(s, at, &effort, p, work, best);
    job->block = effort.block;
    job->of = lw_pool_variables(p);
    job->n_mode = p->plan.n_mode;
    job->evals += (long)effort.cost*effort.block;
    job->improved += n;
    for (int i = 0; i < n; i++) {
        best[i].arm = job->arm;
        best[i].evals = 0;
        best[i].polished = false;
        best[i].hits = 1;
    }
    improve_all(s, p, FIRST_STEPS, n, work, best);
    bool dear = p->family->linkage && lw_problem_is_nonlinear(p);
    if (dear && n > DEAR)
        n = DEAR;
    improve_all(s, p, FULL_STEPS, n < LW_KEEP ? n : LW_KEEP, work, best);
    for (int i = 0; i < n; i++) {
        best[i].seconds = lw_clock_wall() - s->started;
        job->evals += effort.cost*best[i].evals;
        if (i < LW_KEEP)
            keep[i] = best[i];
    }
}

static void search_job(void *context, size_t at, int thread)
{
    lw_search *s = context;
    lw_search_job *job = &s->job[at];
    for (int i = 0; i < LW_KEEP; i++)
        s->found[at*LW_KEEP + (size_t)i].f = INFINITY;
    if (lw_search_stopped(s))
        return;
    lw_problem *p = lw_search_problem(s, thread, job->arm, true, &job->status);
    if (p)
        search_in(s, at, p, s->bench[thread].work);
}

/* A find on the full target: what is polished, and what came of it. */
typedef struct polish {
    lw_found     find;
    long         spent;                      /* evaluations of the polish alone                  */
    lw_variables of;
    lw_status    status;
} polish;

typedef struct polish_list {
    lw_search *s;
    int n;
    double until;                            /* wall clock; 0: no end                            */
    polish item[LW_POOL_MAX];
} polish_list;

/* Coarse and fine targets are scaled by themselves: go through the user's frame. */
static void refine_variables(const lw_problem *coarse, const lw_problem *fine, double *x)
{
    double dim[LW_DIM_MAX], to[LW_VAR_MAX];
    lw_problem_to_dims(coarse, x, dim);
    lw_problem_from_dims(fine, dim, to);
    memcpy(x, to, sizeof *x*(size_t)fine->n_dim);
}

/* To the end. */
static void polish_one(void *context, size_t job, int thread)
{
    polish_list *list = context;
    lw_search *s = list->s;
    polish *l = &list->item[job];
    lw_found *c = &l->find;
    lw_problem *p = lw_search_problem(s, thread, c->arm, false, &l->status);
    const lw_problem *searched = p ? lw_search_made(s, thread, c->arm, true, &l->status) : NULL;
    void *work = s->bench[thread].work;
    lw_lm_options o = lw_lm_options_default();
    if (!searched)
        return;
    o.max_steps = 1500;
    o.f_tol = 1e-12;
    o.until = list->until;
    l->of = lw_pool_variables(p);
    if (s->thin.n > 0)
        refine_variables(searched, p, c->x);
    lw_lm_feasible(p, c->x);
    p->branch = c->branch;
    lw_problem_work_branch(p, work);
    l->spent = -c->evals;
    improve(s, p, &o, true, work, c);
    l->spent += c->evals;
    l->spent *= lw_search_effort(s, p).cost;
    if (isfinite(c->f) && p->timing != LW_TIMING_PRESCRIBED)       /* what x is worth with no more known */
        c->f = lw_problem_value(p, c->x, NULL, work);
    if (isfinite(c->f) && !(lw_problem_stays(p, c->x, work) && lw_problem_admissible(p, c->x, MET, work)))
        c->f = INFINITY;
    c->polished = true;
}

/* Count how often the best of the search was met, to know when to end. */
static void count_hits(lw_search *s, double f)
{
    if (f < s->best_raw*(1 - 1e-3)) {
        s->best_raw = f;
        s->hits = 1;
    } else if (f <= s->best_raw*(1 + 1e-3))
        s->hits++;
}

static void take(const lw_found *c, polish_list *list)
{
    list->item[list->n++].find = *c;
}

static const char *type_of(const lw_search *s, const lw_found *c)
{
    return lw_family_type(s->arm[c->arm].row);
}

/* The best of each type that the search found, best[0 ..]; returns how many types. */
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

/* The best of the round's finds go on, each linkage once; and of every type the best, since a list
 * of one type is not what somebody asks for who allows several. */
static void pick(lw_search *s, polish_list *list)
{
    lw_pool *raw = &s->raw;
    const lw_found *best[LW_SEARCH_CANDIDATE_MAX];
    raw->n = list->n = 0;
    for (int i = 0; i < s->n_job*LW_KEEP; i++) {
        const lw_found *c = &s->found[i];
        if (!isfinite(c->f))
            continue;
        count_hits(s, c->f);
        lw_pool_put(raw, c, &s->job[i/LW_KEEP].of);
    }
    for (int i = 0; i < raw->n && i < POLISH; i++)
        take(&raw->item[i], list);
    int n_type = s->o->families ? 0 : best_of_types(s, best), n_raw = list->n;
    for (int k = 0; k < n_type; k++) {
        bool taken = false;
        for (int i = 0; i < n_raw; i++)
            taken |= type_of(s, &raw->item[i]) == type_of(s, best[k]);
        if (!taken)
            take(best[k], list);
    }
}

/* What the finds of a job add to what its arm remembers. */
static void remember(lw_search *s, const lw_search_job *job, const lw_found *found, lw_search_candidate *a)
{
    lw_pool *few = &s->raw;
    few->n = 0;
    for (int i = 0; a->best && i < a->best->n; i++)
        lw_best_starts_get(a->best, i, &few->item[few->n++]);
    for (int i = 0; i < LW_KEEP; i++)
        lw_pool_put(few, &found[i], &job->of);
    lw_best_starts *more = lw_best_starts_of(few, LW_SEARCH_CANDIDATE_BEST, &job->of, job->n_mode);
    if (more) {
        free(a->best);
        a->best = more;
    }
}

/* What the arms learnt in a round, and what it took. */
static lw_status keep_of_arms(lw_search *s, lw_error *e)
{
    for (int j = 0; j < s->n_job; j++) {
        const lw_search_job *job = &s->job[j];
        lw_search_candidate *a = &s->arm[job->arm];
        s->evals += job->evals;
        s->improved += job->improved;
        a->starts += job->block;
        if (job->status == LW_E_KIND && s->o->families)
            a->state = LW_FIT_UNABLE;
        else if (job->status != LW_OK)
            return lw_search_fault(s, job->arm, e);
        if (job->block == 0)
            continue;
        if (s->o->families)
            remember(s, job, s->found + j*LW_KEEP, a);
        a->state = a->best ? LW_FIT_CLOSED : LW_FIT_LOOKED;
    }
    return LW_OK;
}

static lw_status make_room(lw_search *s, lw_error *e)
{
    if (s->n_job <= s->n_found)
        return LW_OK;
    free(s->found);
    s->n_found = s->n_job;
    s->found = malloc(sizeof *s->found*LW_KEEP*(size_t)s->n_job);
    return s->found ? LW_OK : lw_error_set(e, LW_E_MEMORY, "no memory for the finds of a round");
}

lw_status lw_search_round(lw_search *s, lw_error *e)
{
    polish_list list = { .s = s };
    lw_status st = make_room(s, e);
    if (st != LW_OK)
        return st;
    lw_parallel(s->n_thread, (size_t)s->n_job, search_job, s);
    if ((st = keep_of_arms(s, e)) != LW_OK)
        return st;
    pick(s, &list);
    if (s->o->max_seconds > 0 || lw_search_stopped(s))
        list.until = fmax(lw_clock_wall(), s->started + s->o->max_seconds) + GRACE;
    lw_parallel(s->n_thread, (size_t)list.n, polish_one, &list);
    for (int i = 0; i < list.n; i++) {
        const polish *l = &list.item[i];
        if (l->status != LW_OK)
            return lw_search_fault(s, l->find.arm, e);
        lw_pool_put(&s->pool, &l->find, &l->of);
        s->evals += l->spent;
    }
    return LW_OK;
}
