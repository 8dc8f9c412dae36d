/* Local fits of a four-bar to eighteen timed points (Kunjur & Krishnamurty 1997) a second and core: the
 * least-squares core against GSL's Levenberg-Marquardt and NLopt's SLSQP, from the same starts in one run.
 *
 * The starts are those of the search: of 400 structured ones each in both assembly modes the 24 best.
 * A fit has converged when three steps in a row lessened f by less than 1e-10 of it, or the method found
 * no better point; `near` is the part of the fits that ended within 1e-6 of where the core gets from there
 * with 2000 steps more.
 *
 * CSV: solver, fits, fits a second, microseconds a fit, evaluations a fit, converged, near, the best
 * objective, and how many times longer than the core it took. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/file.h"
#include "optimise/problem/family.h"
#include "optimise/solvers/lm.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "optimise/search/start.h"

enum { DRAWS = 400, KEEP = 24, BLOCKS = 8, ARMS = 2, FITS = ARMS*BLOCKS*KEEP, STEPS = 300, RUNS = 5 };
#define TARGET "catalogues/data/paths/closed18.csv"

typedef struct start { double f, x[LW_VAR_MAX]; } start;

typedef struct bench {
    lw_problem problem[ARMS];
    void      *work;
    start      from[FITS];
} bench;

typedef struct score { double seconds, best; long evals, converged, near; } score;

static void leave(const char *why)
{
    fprintf(stderr, "bench_fit: %s\n", why);
    exit(1);
}

static void make_problems(bench *b)
{
    lw_fit_spec spec = lw_fit_spec_default();
    lw_target t;
    lw_error e;
    char *text;
    size_t size;
    spec.timing = LW_TIMING_PRESCRIBED;
    spec.crank_only = spec.exclude_drag_link = true;
    spec.length_hi = spec.position_hi = 50;
    spec.position_lo = -50;
    if (lw_file_read(TARGET, &text, &size, &e) != LW_OK || lw_target_read(text, size, TARGET, NULL, &t, &e) != LW_OK)
        leave(e.text);
    for (int i = 0; i < ARMS; i++)                          /* the first family is the crank-rocker */
        if (lw_problem_make(&t, &spec, lw_family_table, i ? -1 : 1, 1, &b->problem[i], &e) != LW_OK)
            leave(e.text);
    b->work = aligned_alloc(64, (lw_problem_work_size(&b->problem[0]) + 127) & ~(size_t)63);
    if (!b->work)
        leave("out of memory");
    lw_target_free(&t);
    free(text);
}

static int by_error(const void *a, const void *b)
{
    const start *p = a, *q = b;
    return (p->f > q->f) - (p->f < q->f);
}

static void draw_starts(bench *b)
{
    static double u[DRAWS*LW_START_DRAWS];
    static start s[DRAWS];
    for (int block = 0; block < ARMS*BLOCKS; block++) {
        lw_problem *p = &b->problem[block % ARMS];
        int d = lw_start_draws(p);
        lw_rng rng;
        lw_rng_seed(&rng, 1, (uint64_t)block);
        if (!lw_low_discrepancy(&rng, DRAWS, d, u))
            leave("out of memory");
        lw_problem_work_init(p, b->work);
        for (int i = 0; i < DRAWS; i++)
            s[i].f = lw_start(p, u + i*d, s[i].x, b->work);
        qsort(s, DRAWS, sizeof *s, by_error);
        memcpy(b->from + block*KEEP, s, sizeof *s*KEEP);
    }
}

static const lw_problem *problem_of(const bench *b, int fit) { return &b->problem[fit/KEEP % ARMS]; }

/* One fit; returns f. */
static double fit(const bench *b, const lw_solver *solver, int k, double *x, long *evals, lw_stop *stop)
{
    const lw_problem *p = problem_of(b, k);
    memcpy(x, b->from[k].x, sizeof b->from[k].x);
    if (!solver) {
        lw_lm_options o = lw_lm_options_default();
        o.max_steps = STEPS;
        return lw_lm_improve(p, &o, x, false, b->work, evals, stop);
    }
    lw_solver_options o = lw_solver_options_default();
    lw_solver_result r;
    o.max_evals = 10*STEPS;
    o.f_tol = o.x_tol = 1e-10;
    solver->run(solver, p, &o, x, &r);
    *evals += r.evals;
    *stop = r.stop;
    return r.f;
}

static bool is_near(const bench *b, int k, double *x, double f)
{
    lw_lm_options o = lw_lm_options_default();
    lw_stop stop;
    long evals = 0;
    o.max_steps = 2000;
    o.f_tol = 1e-13;
    return f - lw_lm_improve(problem_of(b, k), &o, x, false, b->work, &evals, &stop) <= 1e-6*f;
}

static score run(const bench *b, const lw_solver *solver, int fits)
{
    static double x[FITS][LW_VAR_MAX];
    static double f[FITS];
    score s = { .best = INFINITY };
    double began = lw_clock_cpu();
    for (int k = 0; k < fits; k++) {
        lw_stop stop;
        f[k] = fit(b, solver, k*(FITS/fits), x[k], &s.evals, &stop);
        s.converged += stop != LW_STOP_EVALS && stop != LW_STOP_FAILED;
    }
    s.seconds = lw_clock_cpu() - began;
    for (int k = 0; k < fits; k++) {
        s.best = fmin(s.best, f[k]*b->problem[0].scale);
        s.near += is_near(b, k*(FITS/fits), x[k], f[k]);
    }
    return s;
}

/* The fastest of some runs: the machine is shared. */
static score best_run(const bench *b, const lw_solver *solver, int fits)
{
    score best = run(b, solver, fits);
    for (int i = 1; i < RUNS; i++) {
        score s = run(b, solver, fits);
        best = s.seconds < best.seconds ? s : best;
    }
    return best;
}

static double report(const bench *b, const char *name, const lw_solver *solver, int fits, double ours)
{
    score s = best_run(b, solver, fits);
    double each = s.seconds/fits;
    printf("%s,%d,%.0f,%.2f,%.1f,%.3f,%.3f,%.6g,%.1f\n", name, fits, 1/each, 1e6*each,
           (double)s.evals/fits, (double)s.converged/fits, (double)s.near/fits, s.best,
           ours > 0 ? each/ours : 1);
    fflush(stdout);
    return each;
}

int main(void)
{
    static bench b;
    make_problems(&b);
    draw_starts(&b);
    printf("solver,fits,fits_a_second,us,evals,converged,near,best,times_core\n");
    double ours = report(&b, "core", NULL, FITS, 0);
    report(&b, "lm-gsl", lw_solver_find("lm-gsl"), FITS/8, ours);
    report(&b, "slsqp", lw_solver_find("slsqp"), FITS/8, ours);
    for (int i = 0; i < ARMS; i++)
        lw_problem_free(&b.problem[i]);
    free(b.work);
    return 0;
}
