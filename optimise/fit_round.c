/* optimise/fit_round.c - one round of the search: low-discrepancy starts, the better ones improved, the
 * best polished. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "optimise/fit_internal.h"
#include "optimise/lm.h"
#include "optimise/lowdiscrepancy.h"
#include "optimise/member.h"
#include "optimise/problem_internal.h"
#include "optimise/start.h"

enum {
    IMPROVE = 12,           /* starts of a job that are improved, at most                          */
    FIRST_STEPS = 40,       /* of each of these                                                   */
    FULL_STEPS = 120,       /* of the LW_KEEP that are handed on                                  */
    DEAR = 2,               /* that go on where conditions on the motion cost most                */
    POLISH = 8              /* of a round's finds, polished                                       */
};

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
static int choose_draws(const lw_arm *a, lw_problem *p, const double *u, int d, void *work, glance *g)
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
static int screen(const lw_arm *a, lw_problem *p, lw_rng *rng, void *work, lw_found *best)
{
    double u[LW_BLOCK*LW_START_DRAWS];
    glance g[LW_BLOCK];
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
static int look_around(const lw_arm *a, lw_problem *p, lw_rng *rng, void *work, lw_found *best)
{
    int n = 0, known = a->best->n < LW_ARM_BEST ? a->best->n : LW_ARM_BEST;
    for (int i = 0; known > 0 && i < a->settle; i++) {
        lw_found c = a->best->item[(int)(lw_rng_uniform(rng)*known)];
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
static void run_solver(const lw_search *s, const lw_solver *solver, const lw_problem *p, long evals,
                       lw_found *c)
{
    lw_solver_options o = lw_solver_options_default();
    lw_solver_result r;
    o.seed = s->o->seed;
    o.max_evals = evals;
    o.interrupt = s->o->interrupt;
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
        run_solver(s, mine, p, 10L*o->max_steps, c);
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

lw_problem *lw_search_problem(lw_search *s, int thread, const lw_found *c, bool coarse)
{
    const lw_arm *a = &s->arm[c->arm];
    lw_problem *p = &s->local[thread];
    *p = coarse && a->has_coarse ? a->coarse : a->fine;
    p->branch = c->branch;
    return p;
}

/* The starts of one job, in order of f. */
static int starts_of(lw_search *s, size_t job, lw_problem *p, void *work, lw_found *best)
{
    const lw_arm *a = &s->arm[s->job[job].arm];
    lw_rng rng;
    uint64_t round = (uint64_t)s->round*(s->o->family ? LW_JOB_MAX : LW_ARM_MAX*8);
    lw_rng_seed(&rng, s->o->seed, round + job);
    if (s->job[job].around)
        return look_around(a, p, &rng, work, best);
    int n = screen(a, p, &rng, work, best);
    if (p->family->posture && s->round == 0) {
        lw_found c;
        c.f = lw_member_posture(p, c.x, work) ? lw_problem_value(p, c.x, NULL, work) : INFINITY;
        c.branch = p->branch;
        n = put_in_order(best, n, a->improve, &c);
    }
    return n;
}

/* Local fits of the best starts of one job: all of them a little, the best of these further; LW_KEEP
 * go to the pool. */
static void search_job(void *context, size_t job, int thread)
{
    lw_search *s = context;
    lw_found best[IMPROVE], *keep = s->found + job*LW_KEEP;
    void *work = s->work[thread];
    for (int i = 0; i < LW_KEEP; i++)
        keep[i].f = INFINITY;
    if (lw_search_stopped(s))
        return;
    lw_problem *p = &s->local[thread];
    const lw_arm *a = &s->arm[s->job[job].arm];
    *p = a->has_coarse ? a->coarse : a->fine;
    lw_problem_work_init(p, work);
    int n = starts_of(s, job, p, work, best);
    s->evals[job] += a->cost*a->block;
    s->improved[job] += n;
    for (int i = 0; i < n; i++) {
        best[i].arm = s->job[job].arm;
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
        s->evals[job] += a->cost*best[i].evals;
        if (i < LW_KEEP)
            keep[i] = best[i];
    }
}

typedef struct polish_list {
    lw_search *s;
    int n;
    lw_found item[LW_POOL_MAX];
    long spent[LW_POOL_MAX];                 /* evaluations of the polish alone                  */
} polish_list;

/* To the end, on the full target. */
static void polish_one(void *context, size_t job, int thread)
{
    polish_list *list = context;
    lw_search *s = list->s;
    lw_found *c = &list->item[job];
    lw_problem *p = lw_search_problem(s, thread, c, false);
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = 1500;
    o.f_tol = 1e-12;
    lw_problem_work_init(p, s->work[thread]);
    list->spent[job] = -c->evals;
    improve(s, p, &o, true, s->work[thread], c);
    list->spent[job] += c->evals;
    if (p->timing != LW_TIMING_PRESCRIBED)               /* what x is worth with no more known     */
        c->f = lw_problem_value(p, c->x, NULL, s->work[thread]);
    if (isfinite(c->f) && !lw_problem_stays(p, c->x, s->work[thread]))
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

/* Coarse and fine targets are scaled by themselves: go through the user's frame. */
static void refine_variables(const lw_arm *a, const double *coarse, double *x)
{
    double dim[LW_DIM_MAX];
    lw_problem_to_dims(&a->coarse, coarse, dim);
    lw_problem_from_dims(&a->fine, dim, x);
    for (int i = a->fine.n_dim; i < a->fine.n_var; i++)
        x[i] = coarse[i];
}

static void take(lw_search *s, const lw_found *c, polish_list *list)
{
    lw_found *to = &list->item[list->n++];
    const lw_arm *a = &s->arm[c->arm];
    *to = *c;
    if (a->has_coarse)
        refine_variables(a, c->x, to->x);
    lw_lm_feasible(&a->fine, to->x);
}

static const char *type_of(const lw_search *s, const lw_found *c)
{
    return lw_family_type(s->arm[c->arm].fine.family);
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
    const lw_found *best[LW_ARM_MAX];
    raw->n = list->n = 0;
    for (int i = 0; i < s->n_job*LW_KEEP; i++) {
        const lw_found *c = &s->found[i];
        if (!isfinite(c->f))
            continue;
        count_hits(s, c->f);
        lw_pool_put(raw, c, &s->arm[c->arm].fine);
    }
    for (int i = 0; i < raw->n && i < POLISH; i++)
        take(s, &raw->item[i], list);
    int n_type = s->o->family ? 0 : best_of_types(s, best), n_raw = list->n;
    for (int k = 0; k < n_type; k++) {
        bool taken = false;
        for (int i = 0; i < n_raw; i++)
            taken |= type_of(s, &raw->item[i]) == type_of(s, best[k]);
        if (!taken)
            take(s, best[k], list);
    }
}

/* What the arms remember of a round. */
static void keep_of_arms(lw_search *s)
{
    for (int j = 0; j < s->n_job; j++) {
        lw_arm *a = &s->arm[s->job[j].arm];
        a->starts += a->block;
        for (int i = 0; i < LW_KEEP && a->best; i++)
            lw_pool_put(a->best, &s->found[j*LW_KEEP + i], a->has_coarse ? &a->coarse : &a->fine);
    }
}

void lw_search_round(lw_search *s)
{
    polish_list list = { .s = s };
    lw_parallel(s->n_thread, (size_t)s->n_job, search_job, s);
    keep_of_arms(s);
    pick(s, &list);
    lw_parallel(s->n_thread, (size_t)list.n, polish_one, &list);
    for (int i = 0; i < list.n; i++) {
        lw_pool_put(&s->pool, &list.item[i], &s->arm[list.item[i].arm].fine);
        s->evals[0] += s->arm[list.item[i].arm].cost*list.spent[i];
    }
}
