/* cli/bench/bench_run.c - runs that record a curve: the default strategy, solvers from its starts, searches of the
 * whole box. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/real.h"
#include "cli/bench/bench.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "optimise/search/start.h"

enum {
    CANDIDATE_MAX = 4,             /* assembly modes times directions                                    */
    DRAWS = 400,             /* draws per candidate and round                                      */
    GLANCE = 100,            /* draws evaluated in full where the timing is free                   */
    TRIES = 12,              /* draws that are then improved                                       */
    EVALS = 1200             /* evaluations of one improvement                                     */
};
#define EXACT 1e-27          /* f of one station, for a path of size one, at rounding error        */

double cli_bench_error(const cli_bench_curve *c)
{
    return c->n ? c->point[c->n - 1].error : INFINITY;
}

double cli_bench_when(const cli_bench_curve *c, double error)
{
    for (size_t i = 0; i < c->n; i++)
        if (c->point[i].error <= error)
            return c->point[i].seconds;
    return NAN;
}

/* The record of a run's improvements: evaluations and seconds of a call are added to those before it. */
typedef struct recorder {
    cli_bench_curve *curve;
    double           started, scale, enough;
    long             before;
    int              stop;
} recorder;

static void record(void *context, long evals, double seconds, double f)
{
    recorder *r = context;
    cli_bench_curve *c = r->curve;
    double error = f*r->scale;
    (void)seconds;
    if (cli_interrupted())
        r->stop = 1;
    if (!(error < cli_bench_error(c)))
        return;
    if (c->n == c->size) {
        size_t size = 2*c->size + 64;
        cli_bench_point *more = realloc(c->point, size*sizeof *more);
        c->incomplete |= !more;
        if (!more)
            return;
        c->point = more;
        c->size = size;
    }
    c->point[c->n++] = (cli_bench_point){ r->before + evals, lw_clock_wall() - r->started, error };
    if (error <= r->enough)
        r->stop = 1;
}

static double spent(const recorder *r) { return lw_clock_wall() - r->started; }

/* ---- the default strategy ---------------------------------------------------------------------- */

static void look_for_interrupt(void *context, double done, double seconds, double best)
{
    recorder *r = context;
    (void)done; (void)seconds; (void)best;
    r->stop |= cli_interrupted();
}

/* The least error of the linkages found, each simulated again from its file. */
static double verified_error(const cli_bench_problem *p, const lw_fit *fit)
{
    double least = INFINITY;
    lw_fit_report *report = malloc(sizeof *report);
    for (int i = 0; i < fit->n && report; i++)
        if (lw_fit_report_make(&p->target, &p->spec, &fit->candidate[i], report, NULL) == LW_OK && report->verified)
            least = fmin(least, report->verified_objective);
    free(report);
    return least;
}

static lw_status run_default(double seconds, int jobs, recorder *r, lw_error *e)
{
    const cli_bench_problem *p = r->curve->problem;
    lw_fit_options o = lw_fit_options_default();
    lw_fit fit;
    o.spec = p->spec;
    o.seed = r->curve->seed;
    o.jobs = jobs;
    o.max_seconds = seconds;
    o.n_result = 3;
    o.interrupt = &r->stop;
    o.progress = look_for_interrupt;
    o.improved = record;
    o.context = r;
    r->scale = 1;                                    /* the strategy reports in the user's units already */
    lw_status st = lw_fit_run(&p->target, &o, &fit, e);
    r->curve->verified = verified_error(p, &fit);
    lw_fit_free(&fit);
    return st < 0 ? st : LW_OK;
}

/* ---- one solver ---------------------------------------------------------------------------------- */

/* One problem for each assembly mode and, if the order of the points may be reversed, each direction. */
typedef struct candidates { int n; lw_problem problem[CANDIDATE_MAX]; void *work; } candidates;

static void free_candidates(candidates *a)
{
    for (int i = 0; i < a->n; i++)
        lw_problem_free(&a->problem[i]);
    free(a->work);
}

static lw_status make_candidates(const cli_bench_problem *p, candidates *a, lw_error *e)
{
    const lw_family *f = lw_family_table;
    int n = p->spec.timing == LW_TIMING_FREE ? 4 : 2;
    while (!f->turns || f->drag_link)                /* only crank-rockers: the crank is the shortest link */
        f++;
    memset(a, 0, sizeof *a);
    for (; a->n < n; a->n++) {
        lw_status st = lw_problem_make(&p->target, &p->spec, f, a->n & 1 ? -1 : 1, a->n & 2 ? -1 : 1, &a->problem[a->n], e);
        if (st != LW_OK)
            return st;
    }
    a->work = aligned_alloc(64, (lw_problem_work_size(&a->problem[0]) + 127) & ~(size_t)63);
    return a->work ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

typedef struct start { double f, x[LW_VAR_MAX]; int candidate, draw; } start;

static int by_f(const void *a, const void *b)
{
    const start *p = a, *q = b;
    return p->f < q->f ? -1 : p->f > q->f ? 1
         : p->candidate != q->candidate ? p->candidate - q->candidate : p->draw - q->draw;
}

/* Draw the best TRIES starts of one candidate, as the default strategy does. */
static bool draw_candidate(candidates *a, int candidate, lw_rng *rng, start *s)
{
    double *u = malloc(sizeof *u*DRAWS*LW_START_DRAWS);
    lw_problem *p = &a->problem[candidate];
    bool look = p->timing != LW_TIMING_PRESCRIBED;
    int d = lw_start_draws(p), n = look ? GLANCE : DRAWS;
    if (!u || !lw_low_discrepancy(rng, DRAWS, d, u)) {
        free(u);
        return false;
    }
    lw_problem_work_init(p, a->work);
    for (int i = 0; i < DRAWS; i++) {
        s[i] = (start){ .candidate = candidate, .draw = i };
        if (look)
            s[i].f = lw_start_estimate(p, u + i*d, a->work);
    }
    if (look)
        qsort(s, DRAWS, sizeof *s, by_f);
    for (int i = 0; i < n; i++)
        s[i].f = lw_start(p, u + s[i].draw*d, s[i].x, a->work);
    qsort(s, (size_t)n, sizeof *s, by_f);
    free(u);
    return true;
}

/* Draw the starts of a round, best first. Returns their number, or -1 when out of memory. */
static int draw_round(candidates *a, uint64_t seed, int round, start *s)
{
    int n = 0;
    for (int candidate = 0; candidate < a->n; candidate++) {
        lw_rng rng;
        lw_rng_seed(&rng, seed, (uint64_t)(round*CANDIDATE_MAX + candidate));
        if (!draw_candidate(a, candidate, &rng, s + n))    /* space for all draws follows the starts that are kept */
            return -1;
        for (int i = 0; i < TRIES && isfinite(s[n].f); i++)
            n++;
    }
    qsort(s, (size_t)n, sizeof *s, by_f);
    return n;
}

static lw_solver_options solver_options(const recorder *r, double seconds, long evals)
{
    lw_solver_options o = lw_solver_options_default();
    o.seed = r->curve->seed;
    o.max_evals = evals;
    o.max_seconds = fmax(seconds, 1e-4);
    o.f_tol = o.x_tol = 1e-10;
    o.interrupt = cli_stop_flag();
    o.improved = record;
    o.context = (void *)r;
    return o;
}

static void call_solver(const lw_solver *solver, const lw_problem *p, double seconds, long evals, double *x, recorder *r)
{
    lw_solver_result result;
    lw_solver_options o = solver_options(r, seconds, evals);
    r->scale = p->scale;
    solver->run(solver, p, &o, x, &result);
    r->before += result.evals;
}

static lw_status run_starts(const lw_solver *solver, double seconds, candidates *a, recorder *r)
{
    start *s = malloc(sizeof *s*(DRAWS + CANDIDATE_MAX*TRIES));
    const lw_problem *p = &a->problem[0];
    double exact = EXACT*(double)p->n*p->scale;
    int n = s ? 0 : -1;
    for (int round = 0; n >= 0 && !r->stop; round++) {
        n = draw_round(a, r->curve->seed, round, s);
        r->before += (long)a->n*DRAWS;
        for (int i = 0; i < n && !r->stop; i++) {
            call_solver(solver, &a->problem[s[i].candidate], seconds - spent(r), EVALS, s[i].x, r);
            r->stop |= cli_interrupted() || spent(r) >= seconds || cli_bench_error(r->curve) <= exact;
        }
        r->stop |= spent(r) >= seconds;
    }
    free(s);
    return n < 0 ? LW_E_MEMORY : LW_OK;
}

/* The middle of the box, where a search begins; angles and unbounded variables start at 0 or 1. */
static void middle(const lw_problem *p, double *x)
{
    for (int i = 0; i < p->n_var; i++) {
        bool length = i < p->n_dim && p->plan.dim[i].kind == LW_DIM_LENGTH;
        x[i] = isfinite(p->lo[i]) && isfinite(p->hi[i]) ? (p->lo[i] + p->hi[i])/2 : length ? 1 : 0;
    }
}

static void run_box(const lw_solver *solver, double seconds, candidates *a, recorder *r)
{
    for (int i = 0; i < a->n && !cli_interrupted(); i++) {
        double x[LW_VAR_MAX];
        middle(&a->problem[i], x);
        call_solver(solver, &a->problem[i], seconds*(i + 1)/a->n - spent(r), 1000000000, x, r);
    }
}

lw_status cli_bench_run(const lw_solver *solver, double seconds, int jobs, double enough, cli_bench_curve *c, lw_error *e)
{
    recorder r = { .curve = c, .started = lw_clock_wall(), .enough = enough };
    candidates *a = calloc(1, sizeof *a);
    lw_status st = !a ? LW_E_MEMORY : solver ? make_candidates(c->problem, a, e) : run_default(seconds, jobs, &r, e);
    if (solver && st == LW_OK && solver->global)
        run_box(solver, seconds, a, &r);
    else if (solver && st == LW_OK)
        st = run_starts(solver, seconds, a, &r);
    if (a)
        free_candidates(a);
    free(a);
    if (c->incomplete || st == LW_E_MEMORY)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    return st;
}
