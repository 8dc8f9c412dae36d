#include "optimise/fit.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "optimise/lm.h"
#include "optimise/lowdiscrepancy.h"
#include "optimise/pool.h"
#include "optimise/problem_internal.h"
#include "optimise/start.h"

enum {
    BLOCK = 400,            /* draws of one job                                                   */
    GLANCE = 100,           /* of these, settled, where the timing is free                        */
    IMPROVE = 12,           /* of these, improved                                                 */
    KEEP = 8,               /* of these, handed to the pool                                       */
    FIRST_STEPS = 40,       /* of each of these                                                   */
    FULL_STEPS = 120,       /* of those handed on                                                 */
    POLISH = 8,             /* of the pool, polished after each round                             */
    ARM_MAX = 80,
    HITS = 100              /* found this often by different starts: nothing better is likely     */
};
#define EXACT 1e-27         /* f of one station, of size one, that is rounding                    */

lw_fit_options lw_fit_options_default(void)
{
    return (lw_fit_options){ .spec = lw_fit_spec_default(), .types = "fourbar", .seed = 1,
                             .n_result = 10 };
}

/* A family in one assembly mode and sense: one problem, and a coarser one for the search when the
 * target has many stations. */
typedef struct arm {
    lw_problem fine, coarse;
    bool       has_coarse;
    int        blocks;                       /* jobs a round                                     */
} arm;

typedef struct search {
    const lw_target      *t;
    const lw_fit_options *o;
    lw_target  thin;                         /* fewer stations                                   */
    int        n_arm, n_thread, n_job, round;
    arm        arm[ARM_MAX];
    int        job_arm[ARM_MAX*8];
    void     **work;                         /* of each thread                                   */
    lw_pool    pool, raw;                    /* polished; of this round's search                 */
    lw_found  *found;                        /* KEEP of each job                                 */
    double     started, best_raw;            /* the latter in the search's own scale             */
    long       hits;                         /* how often the best of the search was found       */
    long      *evals, *improved;             /* of each job                                      */
} search;

/* ---- arms --------------------------------------------------------------------------------- */

/* Is this type asked for?  `types` is "all", or names and letters separated by commas. */
static bool wanted(const char *types, const lw_type *type)
{
    const char *names[] = { type->letters, type->name };
    if (strcmp(types, "all") == 0)
        return true;
    for (int i = 0; i < 2; i++)
        for (const char *at = types; (at = strstr(at, names[i])); at++) {
            size_t n = strlen(names[i]);
            if ((at == types || at[-1] == ',') && (at[n] == 0 || at[n] == ','))
                return true;
        }
    return false;
}

static bool family_wanted(const lw_fit_options *o, const lw_family *f)
{
    if (!wanted(o->types, lw_type_find(f->type)))
        return false;
    if (o->spec.crank_only && !f->turns)
        return false;
    return !(o->spec.exclude_drag_link && f->drag_link);
}

static void note_skipped(lw_fit *out, const lw_family *f, const lw_error *e)
{
    const char *title = lw_type_find(f->type)->title;
    size_t n = strlen(out->skipped);
    if (!strstr(out->skipped, title))                       /* a type once, not each of its families */
        snprintf(out->skipped + n, sizeof out->skipped - n, "%s%s (%.60s)", n ? ", " : "", title,
                 e->text);
}

static lw_status make_arm(search *s, const lw_family *f, double mode, int sense, lw_error *e)
{
    arm *a = &s->arm[s->n_arm];
    memset(a, 0, sizeof *a);
    lw_status st = lw_problem_make(s->t, &s->o->spec, f, mode, sense, &a->fine, e);
    if (st != LW_OK)
        return st;
    a->has_coarse = s->thin.n > 0;
    if (a->has_coarse && (st = lw_problem_make(&s->thin, &s->o->spec, f, mode, sense, &a->coarse, e))
            != LW_OK) {
        lw_problem_free(&a->fine);
        return st;
    }
    s->n_arm++;
    return LW_OK;
}

/* All arms: families in both modes, and for ordered free timing in both senses. */
static lw_status make_arms(search *s, lw_fit *out, lw_error *e)
{
    for (const lw_family *f = lw_family_table; f->name; f++) {
        if (!family_wanted(s->o, f))
            continue;
        int senses = s->o->spec.timing == LW_TIMING_FREE ? 2 : 1;
        for (int k = 0; k < 2*senses; k++) {
            lw_error why = { .text = "" };
            lw_status st = make_arm(s, f, k & 1 ? -1 : 1, k & 2 ? -1 : 1, &why);
            if (st == LW_E_KIND && k == 0)
                note_skipped(out, f, &why);
            if (st == LW_E_KIND)
                break;
            if (st != LW_OK) {
                if (e)
                    *e = why;
                return st;
            }
        }
    }
    if (s->n_arm == 0)
        return lw_error_set(e, LW_E_ARG, "no linkage of the types asked for can do this%s%s%s",
                            s->o->spec.crank_only ? ", since its input must turn fully" : "",
                            out->skipped[0] ? ": " : "", out->skipped);
    return LW_OK;
}

/* Every so-manieth station, for the search on long targets. */
static lw_status thin_out(search *s, lw_error *e)
{
    enum { MANY = 48, FEW = 28 };
    const lw_target *t = s->t;
    if (t->n <= MANY || s->o->spec.task == LW_TASK_FUNCTION)
        return LW_OK;
    double v[5][FEW];
    const double *from[5] = { t->x, t->y, t->theta, t->angle, t->weight };
    for (size_t i = 0; i < FEW; i++) {
        size_t k = t->closed ? i*t->n/FEW : i*(t->n - 1)/(FEW - 1);
        for (int c = 0; c < 5; c++)
            v[c][i] = from[c] ? from[c][k] : 0;
    }
    double weight = 0;
    for (size_t i = 0; i < FEW; i++)
        weight += v[4][i];
    for (size_t i = 0; i < FEW && !(weight > 0); i++)
        v[4][i] = 1;
    return lw_target_make(FEW, v[0], v[1], t->theta ? v[2] : NULL, t->angle ? v[3] : NULL, v[4],
                          t->closed, &s->thin, e);
}

/* Coarse and fine targets are scaled by themselves: go through the user's frame. */
static void refine_variables(const arm *a, const double *coarse, double *x)
{
    double dim[LW_DIM_MAX];
    lw_problem_to_dims(&a->coarse, coarse, dim);
    lw_problem_from_dims(&a->fine, dim, x);
    for (int i = a->fine.n_dim; i < a->fine.n_var; i++)
        x[i] = coarse[i];
}

/* ---- one round ---------------------------------------------------------------------------- */

static bool stopped(const search *s)
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

/* Which draws of a block are worth settling: all where that is cheap, else the GLANCE best by a
 * first look. */
static int choose_draws(const lw_problem *p, const double *u, int d, void *work, glance *g)
{
    for (int i = 0; i < BLOCK; i++) {
        g[i].which = i;
        g[i].rest = p->timing == LW_TIMING_PRESCRIBED ? 0 : lw_start_glance(p, u + i*d, work);
    }
    if (p->timing == LW_TIMING_PRESCRIBED)
        return BLOCK;
    qsort(g, BLOCK, sizeof *g, by_rest);
    return GLANCE;
}

/* The IMPROVE best starts of a block, in order. */
static int screen(const lw_problem *p, lw_rng *rng, void *work, lw_found *best)
{
    double u[BLOCK*LW_START_DRAWS];
    glance g[BLOCK];
    int n = 0, d = lw_start_draws(p);
    if (!lw_low_discrepancy(rng, BLOCK, d, u))
        return 0;
    int chosen = choose_draws(p, u, d, work, g);
    for (int i = 0; i < chosen && isfinite(g[i].rest); i++) {
        lw_found c;
        c.f = lw_start(p, u + g[i].which*d, c.x, work);
        if (!isfinite(c.f) || (n == IMPROVE && c.f >= best[n - 1].f))
            continue;
        int at = n < IMPROVE ? n++ : n - 1;
        for (; at > 0 && best[at - 1].f > c.f; at--)
            best[at] = best[at - 1];
        best[at] = c;
    }
    return n;
}

/* The user's solver from where the start stands. */
static void run_solver(const search *s, const lw_solver *solver, const lw_problem *p, long evals,
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

/* Improve c: least squares by default, a solver with conditions where these are violated. */
static void improve(const search *s, const lw_problem *p, const lw_lm_options *o, void *work,
                    lw_found *c)
{
    const lw_solver *mine = s->o->solver;
    if (mine && mine->run != lw_lm_run) {
        run_solver(s, mine, p, 10L*o->max_steps, c);
        return;
    }
    c->f = lw_lm_conditioned(p, o, c->x, work, &c->evals, &c->stop);
}

/* Least squares from each of n starts, at most so many steps; then in order of f. */
static void improve_all(const search *s, const lw_problem *p, int steps, int n, void *work,
                        lw_found *best)
{
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = steps;
    o.f_hopeless = 1e4*s->best_raw;
    o.patience = FIRST_STEPS;
    o.interrupt = s->o->interrupt;
    o.until = s->o->max_seconds > 0 ? s->started + s->o->max_seconds : 0;
    for (int i = 0; i < n && !stopped(s); i++)
        improve(s, p, &o, work, &best[i]);
    for (int i = 1; i < n; i++) {
        lw_found c = best[i];
        int at = i;
        for (; at > 0 && best[at - 1].f > c.f; at--)
            best[at] = best[at - 1];
        best[at] = c;
    }
}

/* Local fits of the best starts of one block: all of them a little, the best of these further; KEEP
 * go to the pool. */
static void search_block(void *context, size_t job, int thread)
{
    search *s = context;
    int ia = s->job_arm[job];
    const arm *a = &s->arm[ia];
    const lw_problem *p = a->has_coarse ? &a->coarse : &a->fine;
    void *work = s->work[thread];
    lw_found best[IMPROVE], *keep = s->found + job*KEEP;
    lw_rng rng;
    for (int i = 0; i < KEEP; i++)
        keep[i].f = INFINITY;
    if (stopped(s))
        return;
    lw_problem_work_init(p, work);
    lw_rng_seed(&rng, s->o->seed, (uint64_t)s->round*ARM_MAX*8 + job);
    int n = screen(p, &rng, work, best);
    s->evals[job] += BLOCK;
    s->improved[job] += n;
    for (int i = 0; i < n; i++) {
        best[i].arm = ia;
        best[i].evals = 0;
        best[i].polished = false;
        best[i].hits = 1;
    }
    improve_all(s, p, FIRST_STEPS, n, work, best);
    improve_all(s, p, FULL_STEPS, n < KEEP ? n : KEEP, work, best);
    for (int i = 0; i < n; i++) {
        best[i].seconds = lw_clock_wall() - s->started;
        s->evals[job] += best[i].evals;
        if (i < KEEP)
            keep[i] = best[i];
    }
}

typedef struct polish_list {
    search *s;
    int n;
    lw_found item[LW_POOL_MAX];
    long spent[LW_POOL_MAX];                 /* evaluations of the polish alone                  */
} polish_list;

/* To the end, on the full target. */
static void polish_one(void *context, size_t job, int thread)
{
    polish_list *list = context;
    search *s = list->s;
    lw_found *c = &list->item[job];
    const arm *a = &s->arm[c->arm];
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = 1500;
    o.f_tol = 1e-12;
    lw_problem_work_init(&a->fine, s->work[thread]);
    list->spent[job] = -c->evals;
    improve(s, &a->fine, &o, s->work[thread], c);
    list->spent[job] += c->evals;
    if (a->fine.timing != LW_TIMING_PRESCRIBED)          /* what x is worth with no more known     */
        c->f = lw_problem_value(&a->fine, c->x, NULL, s->work[thread]);
    c->polished = true;
}

/* Count how often the best of the search was met, to know when to end. */
static void count_hits(search *s, double f)
{
    if (f < s->best_raw*(1 - 1e-3)) {
        s->best_raw = f;
        s->hits = 1;
    } else if (f <= s->best_raw*(1 + 1e-3))
        s->hits++;
}

static void take(search *s, const lw_found *c, polish_list *list)
{
    lw_found *to = &list->item[list->n++];
    const arm *a = &s->arm[c->arm];
    *to = *c;
    if (a->has_coarse)
        refine_variables(a, c->x, to->x);
    lw_lm_feasible(&a->fine, to->x);
}

/* The best of the round's finds go on, each linkage once; and of every type the best, since a list
 * of one type is not what somebody asks for who allows several. */
static void pick(search *s, polish_list *list)
{
    lw_pool *raw = &s->raw;
    const char *seen[ARM_MAX];
    int n_seen = 0;
    raw->n = list->n = 0;
    for (int i = 0; i < s->n_job*KEEP; i++) {
        const lw_found *c = &s->found[i];
        if (!isfinite(c->f))
            continue;
        count_hits(s, c->f);
        lw_pool_put(raw, c, &s->arm[c->arm].fine);
    }
    for (int i = 0; i < raw->n && list->n < LW_POOL_MAX; i++) {
        const char *type = s->arm[raw->item[i].arm].fine.family->type;
        bool first = true;
        for (int k = 0; k < n_seen; k++)
            first &= seen[k] != type;
        if (first)
            seen[n_seen++] = type;
        if (first || i < POLISH)
            take(s, &raw->item[i], list);
    }
}

static void one_round(search *s)
{
    polish_list list = { .s = s };
    lw_parallel(s->n_thread, (size_t)s->n_job, search_block, s);
    pick(s, &list);
    lw_parallel(s->n_thread, (size_t)list.n, polish_one, &list);
    for (int i = 0; i < list.n; i++) {
        lw_pool_put(&s->pool, &list.item[i], &s->arm[list.item[i].arm].fine);
        s->evals[0] += list.spent[i];
    }
}

/* ---- the whole ---------------------------------------------------------------------------- */

static int rounds_of(const search *s)
{
    /* Jobs of about five milliseconds each at eighteen stations: 500 of them for one family of cranks
     * are enough for every published path problem with margin (docs/benchmarks.md); further families
     * take their share of more. */
    const lw_target *t = s->thin.n ? &s->thin : s->t;
    double share = s->n_job > 16 ? 700.0 : 500.0;
    double jobs = share*45/((double)t->n + 27);
    int rounds = (int)(jobs/s->n_job + 0.5);
    return s->o->max_rounds > 0 ? s->o->max_rounds : rounds < 5 ? 5 : rounds;
}

static lw_status share_out(search *s)
{
    size_t bytes = 0;
    for (int i = 0; i < s->n_arm; i++) {
        arm *a = &s->arm[i];
        long blocks = s->o->starts > 0 ? (s->o->starts + BLOCK - 1)/BLOCK : a->fine.family->blocks;
        size_t need = lw_problem_work_size(&a->fine);
        a->blocks = (int)(blocks > 8 ? 8 : blocks);
        bytes = need > bytes ? need : bytes;
        for (int k = 0; k < a->blocks; k++)
            s->job_arm[s->n_job++] = i;
    }
    s->n_thread = s->o->jobs > 0 ? s->o->jobs : lw_core_count();
    s->found = malloc(sizeof *s->found*(size_t)(s->n_job*KEEP));
    s->evals = calloc((size_t)s->n_job, sizeof *s->evals);
    s->improved = calloc((size_t)s->n_job, sizeof *s->improved);
    s->work = calloc((size_t)s->n_thread, sizeof *s->work);
    if (!s->found || !s->evals || !s->improved || !s->work)
        return LW_E_MEMORY;
    for (int i = 0; i < s->n_thread; i++)
        if (!(s->work[i] = aligned_alloc(64, (bytes + 127) & ~(size_t)63)))
            return LW_E_MEMORY;
    return LW_OK;
}

static void search_free(search *s)
{
    for (int i = 0; i < s->n_arm; i++) {
        lw_problem_free(&s->arm[i].fine);
        if (s->arm[i].has_coarse)
            lw_problem_free(&s->arm[i].coarse);
    }
    for (int i = 0; s->work && i < s->n_thread; i++)
        free(s->work[i]);
    lw_target_free(&s->thin);
    free(s->work);
    free(s->found);
    free(s->evals);
    free(s->improved);
    free(s);
}

static long evals_of(const search *s)
{
    long sum = 0;
    for (int i = 0; i < s->n_job; i++)
        sum += s->evals[i];
    return sum;
}

static lw_stop search_rounds(search *s)
{
    double least = INFINITY;
    int rounds = rounds_of(s);
    for (s->round = 0; s->round < rounds; s->round++) {
        one_round(s);
        double best = s->pool.n ? s->pool.item[0].f : INFINITY, now = lw_clock_wall() - s->started;
        if (s->o->progress)
            s->o->progress(s->o->context, (s->round + 1.0)/rounds, now, best*s->arm[0].fine.scale);
        if (s->o->improved && best < least)
            s->o->improved(s->o->context, evals_of(s), now, best*s->arm[0].fine.scale);
        least = fmin(least, best);
        if (s->o->interrupt && *s->o->interrupt)
            return LW_STOP_USER;
        if (stopped(s))
            return LW_STOP_TIME;
        if (best <= EXACT*(double)s->t->n)
            return LW_STOP_F_TARGET;
        if (s->hits >= HITS && s->round >= 2)
            return LW_STOP_F_TOL;
    }
    return LW_STOP_EVALS;
}

/* The curve of one find: where its stations and its samples are. */
typedef struct trail {
    const lw_found *of;
    double *px, *py, cx[LW_CURVE_SAMPLES], cy[LW_CURVE_SAMPLES];
} trail;

static double nearest_of(const trail *t, double x, double y)
{
    double least = INFINITY;
    for (int j = 0; j < LW_CURVE_SAMPLES; j++) {
        int k = (j + 1) % LW_CURVE_SAMPLES;
        double dx = t->cx[k] - t->cx[j], dy = t->cy[k] - t->cy[j], d2 = dx*dx + dy*dy;
        double u = d2 > 0 ? ((x - t->cx[j])*dx + (y - t->cy[j])*dy)/d2 : 0;
        u = fmax(0, fmin(1, u));
        least = fmin(least, hypot(x - t->cx[j] - u*dx, y - t->cy[j] - u*dy));
    }
    return least;
}

/* One curve (cognates, or a linkage met twice): the stations' points agree, and the rest to what
 * polygons of samples can tell. */
static bool same_curve(const trail *a, const trail *b, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (hypot(a->px[k] - b->px[k], a->py[k] - b->py[k]) > 1e-4)
            return false;
    for (int j = 0; j < LW_CURVE_SAMPLES; j += 4)
        if (nearest_of(b, a->cx[j], a->cy[j]) > 0.03)
            return false;
    return true;
}

/* One generator of a function: links of the same proportions.  An offset to the other side with the slide
 * turned round is the same. */
static bool same_links(const search *s, const lw_found *a, const lw_found *b)
{
    const lw_problem *p = &s->arm[a->arm].fine, *q = &s->arm[b->arm].fine;
    if (strcmp(p->family->type, q->family->type) != 0)
        return false;
    int first = lw_problem_index(p, p->family->shape[0]);
    for (int i = 0; i < p->n_dim; i++) {
        double u = fabs(a->x[i]/a->x[first]), v = fabs(b->x[i]/b->x[first]);
        if (p->plan.dim[i].kind != LW_DIM_ANGLE && fabs(u - v) > 1e-4*fmax(1, u))
            return false;
    }
    return true;
}

static bool follow(const search *s, const lw_found *c, trail *t)
{
    t->of = c;
    const lw_problem *p = &s->arm[c->arm].fine;
    lw_work *w = s->work[0];
    lw_problem_work_init(p, w);
    if (!lw_problem_settle(p, c->x, w))
        return false;
    memcpy(t->px, w->jac.x, sizeof *t->px*p->n);
    memcpy(t->py, w->jac.y, sizeof *t->py*p->n);
    lw_assign_sample(p, c->x, w);
    memcpy(t->cx, w->curve_x, sizeof t->cx);
    memcpy(t->cy, w->curve_y, sizeof t->cy);
    return true;
}

/* What the caller gets of one find. */
static bool hand_out(const search *s, const lw_found *c, lw_candidate *out)
{
    const lw_problem *p = &s->arm[c->arm].fine;
    lw_work *w = s->work[0];
    lw_problem_work_init(p, w);
    if (!lw_problem_settle(p, c->x, w))
        return false;
    *out = (lw_candidate){ .family = p->family, .mode = p->mode[0], .sense = p->sense,
                           .n_dim = p->n_dim, .objective = c->f*p->scale, .evals = c->evals,
                           .seconds = c->seconds, .stop = c->stop };
    lw_problem_to_dims(p, c->x, out->dim);
    out->input0 = p->i_input0 >= 0 ? c->x[p->i_input0] : 0;
    out->tool0 = p->i_tool0 >= 0 ? c->x[p->i_tool0] : 0;
    out->input = malloc(sizeof *out->input*p->n);
    if (out->input)
        for (size_t k = 0; k < p->n; k++)
            out->input[k] = w->input[k]*(p->plan.input_is_slider ? p->unit : 1);
    if (p->turns || p->timing == LW_TIMING_PRESCRIBED)
        return out->input != NULL;
    out->mode_of = malloc(sizeof *out->mode_of*p->n);
    if (out->mode_of)
        memcpy(out->mode_of, w->mode, sizeof *out->mode_of*p->n);
    return out->input && out->mode_of;
}

/* Ranked candidates, each curve once. */
static lw_status rank(search *s, lw_fit *out)
{
    int most = s->o->n_result > 0 ? s->o->n_result : 1;
    size_t n = s->t->n;
    trail *seen = calloc((size_t)most + 1, sizeof *seen);
    double *points = malloc(sizeof *points*2*n*((size_t)most + 1));
    out->candidate = calloc((size_t)most, sizeof *out->candidate);
    if (!seen || !points || !out->candidate) {
        free(seen);
        free(points);
        return LW_E_MEMORY;
    }
    for (int i = 0; i < s->pool.n && out->n < most; i++) {
        const lw_found *c = &s->pool.item[i];
        trail *t = &seen[out->n];
        t->px = points + 2*n*(size_t)out->n;
        t->py = t->px + n;
        bool fresh = follow(s, c, t);
        for (int k = 0; fresh && k < out->n; k++)
            fresh = s->o->spec.task == LW_TASK_FUNCTION ? !same_links(s, t->of, seen[k].of)
                                                        : !same_curve(t, &seen[k], n);
        if (fresh && hand_out(s, c, &out->candidate[out->n]))
            out->n++;
    }
    free(seen);
    free(points);
    return LW_OK;
}

lw_status lw_fit_run(const lw_target *t, const lw_fit_options *o, lw_fit *out, lw_error *e)
{
    memset(out, 0, sizeof *out);
    search *s = calloc(1, sizeof *s);
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "no memory for the search");
    s->t = t;
    s->o = o;
    s->started = lw_clock_wall();
    s->best_raw = INFINITY;
    lw_status st = thin_out(s, e);
    if (st == LW_OK)
        st = make_arms(s, out, e);
    if (st == LW_OK && (st = share_out(s)) == LW_OK) {
        out->stop = search_rounds(s);
        st = rank(s, out);
    }
    for (int i = 0; st == LW_OK && i < s->n_job; i++)
        out->improved += s->improved[i];
    out->evals = st == LW_OK ? evals_of(s) : 0;
    out->rounds = s->round + (out->stop != LW_STOP_EVALS);       /* it ended in a round, or after all */
    out->starts = (long)s->n_job*BLOCK*out->rounds;
    out->seconds = lw_clock_wall() - s->started;
    search_free(s);
    if (st == LW_E_MEMORY)
        return lw_error_set(e, st, "no memory for the search");
    if (st == LW_OK && (out->stop == LW_STOP_TIME || out->stop == LW_STOP_USER))
        return LW_STOPPED;
    return st == LW_OK && out->n == 0 ? LW_NOTHING : st;
}

void lw_fit_free(lw_fit *f)
{
    for (int i = 0; i < f->n; i++) {
        free(f->candidate[i].input);
        free(f->candidate[i].mode_of);
    }
    free(f->candidate);
    memset(f, 0, sizeof *f);
}
