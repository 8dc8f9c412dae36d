/* cli/bench/bench_run.c - runs that leave a curve: the default strategy, solvers from its starts, searches
 * of the box. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "cli/bench/bench.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "optimise/search/start.h"

enum {
    ARM_MAX = 4,             /* assembly modes by senses                                           */
    DRAWS = 400,             /* of one arm and round                                               */
    GLANCE = 100,            /* of these, settled, where the timing is free                        */
    TRIES = 12,              /* of these, improved                                                 */
    EVALS = 1200             /* of one improvement                                                 */
};
#define EXACT 1e-27          /* f of one station, of size one, that is rounding                    */

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

/* Where a run writes: improvements of one call of a solver, after what went before. */
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

/* The least error of what was found, simulated again from its file. */
static double verified_error(const cli_bench_problem *p, const lw_fit *fit)
{
    double least = INFINITY;
    lw_fit_report *report = malloc(sizeof *report);
    for (int i = 0; i < fit->n && report; i++)
        if (lw_fit_report_make(&p->target, &p->spec, &fit->candidate[i], report, NULL) == LW_OK
            && report->verified)
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
    r->scale = 1;                                    /* it speaks in the user's units already        */
    lw_status st = lw_fit_run(&p->target, &o, &fit, e);
    r->curve->verified = verified_error(p, &fit);
    lw_fit_free(&fit);
    return st < 0 ? st : LW_OK;
}

/* ---- one solver ---------------------------------------------------------------------------------- */

/* The problem once for each assembly mode and, where the order of the points may run either way, sense. */
typedef struct arms { int n; lw_problem problem[ARM_MAX]; void *work; } arms;

static void free_arms(arms *a)
{
    for (int i = 0; i < a->n; i++)
        lw_problem_free(&a->problem[i]);
    free(a->work);
}

static lw_status make_arms(const cli_bench_problem *p, arms *a, lw_error *e)
{
    const lw_family *f = lw_family_table;
    int n = p->spec.timing == LW_TIMING_FREE ? 4 : 2;
    while (!f->turns || f->drag_link)                /* the crank-rocker: crank and shortest link   */
        f++;
    *a = (arms){ 0 };
    for (; a->n < n; a->n++) {
        lw_status st = lw_problem_make(&p->target, &p->spec, f, a->n & 1 ? -1 : 1, a->n & 2 ? -1 : 1,
                                       &a->problem[a->n], e);
        if (st != LW_OK)
            return st;
    }
    a->work = aligned_alloc(64, (lw_problem_work_size(&a->problem[0]) + 127) & ~(size_t)63);
    return a->work ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

typedef struct start { double f, x[LW_VAR_MAX]; int arm, draw; } start;

static int by_f(const void *a, const void *b)
{
    const start *p = a, *q = b;
    return p->f < q->f ? -1 : p->f > q->f ? 1 : p->arm != q->arm ? p->arm - q->arm : p->draw - q->draw;
}

/* The best TRIES starts of one arm, as the default strategy draws them. */
static bool draw_arm(arms *a, int arm, lw_rng *rng, start *s)
{
    double u[DRAWS*LW_START_DRAWS];
    lw_problem *p = &a->problem[arm];
    bool look = p->timing != LW_TIMING_PRESCRIBED;
    int d = lw_start_draws(p), n = look ? GLANCE : DRAWS;
    if (!lw_low_discrepancy(rng, DRAWS, d, u))
        return false;
    lw_problem_work_init(p, a->work);
    for (int i = 0; i < DRAWS; i++) {
        s[i] = (start){ .arm = arm, .draw = i };
        if (look)
            s[i].f = lw_start_estimate(p, u + i*d, a->work);
    }
    if (look)
        qsort(s, DRAWS, sizeof *s, by_f);
    for (int i = 0; i < n; i++)
        s[i].f = lw_start(p, u + s[i].draw*d, s[i].x, a->work);
    qsort(s, (size_t)n, sizeof *s, by_f);
    return true;
}

/* The starts of a round, best first.  Returns how many, or -1 when out of memory. */
static int draw_round(arms *a, uint64_t seed, int round, start *s)
{
    int n = 0;
    for (int arm = 0; arm < a->n; arm++) {
        lw_rng rng;
        lw_rng_seed(&rng, seed, (uint64_t)(round*ARM_MAX + arm));
        if (!draw_arm(a, arm, &rng, s + n))          /* room for all draws behind those that are kept */
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

static void call_solver(const lw_solver *solver, const lw_problem *p, double seconds, long evals,
                        double *x, recorder *r)
{
    lw_solver_result result;
    lw_solver_options o = solver_options(r, seconds, evals);
    r->scale = p->scale;
    solver->run(p, &o, x, &result);
    r->before += result.evals;
}

static lw_status run_starts(const lw_solver *solver, double seconds, arms *a, recorder *r)
{
    start *s = malloc(sizeof *s*(DRAWS + ARM_MAX*TRIES));
    const lw_problem *p = &a->problem[0];
    double exact = EXACT*(double)p->n*p->scale;
    int n = s ? 0 : -1;
    for (int round = 0; n >= 0 && !r->stop; round++) {
        n = draw_round(a, r->curve->seed, round, s);
        r->before += (long)a->n*DRAWS;
        for (int i = 0; i < n && !r->stop; i++) {
            call_solver(solver, &a->problem[s[i].arm], seconds - spent(r), EVALS, s[i].x, r);
            r->stop |= cli_interrupted() || spent(r) >= seconds || cli_bench_error(r->curve) <= exact;
        }
        r->stop |= spent(r) >= seconds;
    }
    free(s);
    return n < 0 ? LW_E_MEMORY : LW_OK;
}

/* The middle of the box, where a search begins; angles and what has no bounds at 0 or 1. */
static void middle(const lw_problem *p, double *x)
{
    for (int i = 0; i < p->n_var; i++) {
        bool length = i < p->n_dim && p->plan.dim[i].kind == LW_DIM_LENGTH;
        x[i] = isfinite(p->lo[i]) && isfinite(p->hi[i]) ? (p->lo[i] + p->hi[i])/2 : length ? 1 : 0;
    }
}

static void run_box(const lw_solver *solver, double seconds, arms *a, recorder *r)
{
    for (int i = 0; i < a->n && !cli_interrupted(); i++) {
        double x[LW_VAR_MAX];
        middle(&a->problem[i], x);
        call_solver(solver, &a->problem[i], seconds*(i + 1)/a->n - spent(r), 1000000000, x, r);
    }
}

lw_status cli_bench_run(const lw_solver *solver, double seconds, int jobs, double enough,
                        cli_bench_curve *c, lw_error *e)
{
    recorder r = { .curve = c, .started = lw_clock_wall(), .enough = enough };
    arms a = { 0 };
    lw_status st = solver ? make_arms(c->problem, &a, e) : run_default(seconds, jobs, &r, e);
    if (solver && st == LW_OK && solver->global)
        run_box(solver, seconds, &a, &r);
    else if (solver && st == LW_OK)
        st = run_starts(solver, seconds, &a, &r);
    free_arms(&a);
    if (c->incomplete || st == LW_E_MEMORY)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    return st;
}
