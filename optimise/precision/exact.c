/* optimise/precision/exact.c - which method suits a target, and the search over the dimensions that its stations
 * leave free. */
#include "optimise/precision/exact_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "base/parallel.h"
#include "optimise/solvers/lowdiscrepancy.h"

enum { JOBS = 16, LINES = 24, ANGLES = 32, GUIDES = 8, GUIDE_MAX = 256 };
#define REACH 2.0              /* free pins are drawn within this many sizes of the target                */
#define SAME  1e-12            /* stations nearer than this are the same                                  */
#define TURN  1.5              /* free tool angles: the greatest step from point to point [rad]           */

typedef struct exact_run {
    const lw_target      *t;
    const lw_fit_options *o;
    lw_vec2      p[9];
    bool         slides;
    double       started;
    size_t       first_job;
    lw_ranking **of;                             /* of each job of this round                      */
    long        *drawn;
} exact_run;

/* Exact synthesis for one objective. */
typedef struct method {
    size_t      least, most;                 /* numbers of stations that four links can pass through        */
    size_t      finite;                      /* fewer stations: infinitely many linkages, some are drawn    */
    const char *stations;                    /* what they are called                                        */
    const char *types;                       /* types tried by default where the linkages are finitely many */
    lw_status (*run)(exact_run *x, lw_ranking *r, lw_exact *out, lw_error *e);
} method;

/* ---- checks of the target --------------------------------------------------------------------------------- */

static lw_status check_task(const lw_target *t, const lw_fit_spec *spec, const method *m, lw_error *e)
{
    const lw_task_row *task = &lw_task_table[spec->task];
    if (!m->run)
        return lw_error_set(e, LW_E_ARG, "no exact method is known for the %s task; fit without --exact", task->name);
    if (t->n_also > 0)
        return lw_error_set(e, LW_E_ARG, "linkages through precision points have one point; the target has %d: leave "
                            "its columns x2, ... out, or fit without --exact", 1 + t->n_also);
    if (t->n < m->least || t->n > m->most)
        return lw_error_set(e, LW_E_ARG, "a linkage of four links goes through %zu to %zu %s exactly, and the target "
                            "has %zu; without --exact it is fitted as well as can be", m->least, m->most, m->stations,
                            t->n);
    if ((task->prescribed && !t->angle) || (task->place && !t->x) || (task->angle && !t->theta))
        return lw_error_set(e, LW_E_ARG, "a %s needs columns %s%s%s%s", task->name, task->prescribed ? "angle," : "",
                            task->place ? "x,y" : "", task->place && task->angle ? "," : "",
                            task->angle ? "theta" : "");
    if (!task->place && spec->n_zone > 0)
        return lw_error_set(e, LW_E_ARG, "a function has no place in the plane: places of pivots and forbidden zones "
                            "mean nothing to it; leave them out");
    return LW_OK;
}

static lw_status check_distinct(const lw_target *t, lw_task task, lw_error *e)
{
    for (size_t i = 0; i < t->n && lw_task_has_place(task); i++)
        for (size_t k = 0; k < i; k++) {
            double d = hypot(t->x[i] - t->x[k], t->y[i] - t->y[k]);
            double turn = lw_task_has_angle(task) ? fabs(remainder(t->theta[i] - t->theta[k], 2*LW_PI)) : 0;
            if (d <= SAME*t->size && turn < SAME)
                return lw_error_set(e, LW_E_ARG, "stations %zu and %zu are the same; leave one of them out", k + 1, i + 1);
        }
    return LW_OK;
}

/* ---- draws ------------------------------------------------------------------------------------------------ */

static void offer_pairs(lw_ranking *r, const lw_guide *g, int n, const double *angle)
{
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            lw_ranking_offer(r, &g[i], &g[k], angle);
}

/* Two to four poses: draw free pins or lines of guides, and offer all pairs of the guides of a job. */
static void draw_poses(exact_run *x, lw_rng *rng, lw_ranking *r, long *drawn)
{
    double u[LINES*LW_GUIDE_DRAW];
    lw_guide g[GUIDE_MAX];
    lw_guide_rows rows;
    int n = 0;
    lw_guide_rows_make(&(lw_poses){ x->t->n, x->p, x->t->theta }, x->t->size, &rows);
    if (!lw_low_discrepancy(rng, LINES, LW_GUIDE_DRAW, u)) {
        lw_ranking_lose(r);
        return;
    }
    for (int i = 0; i < LINES && n + 4 <= GUIDE_MAX; i++)
        n += lw_guide_rows_draw(&rows, &u[i*LW_GUIDE_DRAW], REACH, x->slides, &g[n]);
    *drawn += LINES;
    offer_pairs(r, g, n, x->t->theta);
}

/* Tool angles at the points of a path: steps of either sign. */
static void draw_angles(const double *u, size_t n, double *angle)
{
    angle[0] = 0;
    for (size_t j = 1; j < n; j++)
        angle[j] = angle[j - 1] + TURN*(2*u[j - 1] - 1);
}

/* Two to five points: draw tool angles and solve the motion. */
static void draw_path(exact_run *x, lw_rng *rng, lw_ranking *r, long *drawn)
{
    enum { D = 8 };
    double u[ANGLES*D], v[ANGLES*GUIDES*LW_GUIDE_DRAW], angle[9];
    lw_guide g[GUIDES + 4];
    if (!lw_low_discrepancy(rng, ANGLES, D, u) || !lw_low_discrepancy(rng, ANGLES*GUIDES, LW_GUIDE_DRAW, v)) {
        lw_ranking_lose(r);
        return;
    }
    for (int i = 0; i < ANGLES; i++) {
        lw_guide_rows rows;
        draw_angles(&u[i*D], x->t->n, angle);
        lw_guide_rows_make(&(lw_poses){ x->t->n, x->p, angle }, x->t->size, &rows);
        int n = rows.n == 4 ? lw_guide_rows_solve(&rows, g) : 0;
        for (int k = 0; k < GUIDES && rows.n < 4 && n <= GUIDES; k++)
            n += lw_guide_rows_draw(&rows, &v[(i*GUIDES + k)*LW_GUIDE_DRAW], REACH, x->slides, &g[n]);
        offer_pairs(r, g, n, angle);
    }
    *drawn += ANGLES;
}

/* Six to eight points: draw angles at five of them, which gives linkages; then move these linkages through the
 * others. */
typedef struct five { size_t at[5]; double angle[5], all[9]; lw_vec2 p[5], step[8]; } five;

static void settle_pair(exact_run *x, const five *v, const lw_guide *g, const lw_guide *h, lw_ranking *r)
{
    size_t n = x->t->n;
    double unit = x->t->size, angle[9];
    lw_vec2 pin[4] = { g->point, lw_v2_sub(g->centre, x->p[0]), h->point, lw_v2_sub(h->centre, x->p[0]) };
    if (g->kind != LW_GUIDE_RR || h->kind != LW_GUIDE_RR)
        return;
    for (int i = 0; i < 4; i++)
        pin[i] = lw_v2_scale(pin[i], 1/unit);
    memcpy(angle, v->all, sizeof angle);
    if (!lw_path_settle(n, v->step, pin, angle))
        return;
    lw_guide a = { .kind = LW_GUIDE_RR, .point = lw_v2_scale(pin[0], unit),
                   .centre = lw_v2_add(x->p[0], lw_v2_scale(pin[1], unit)) };
    lw_guide b = { .kind = LW_GUIDE_RR, .point = lw_v2_scale(pin[2], unit),
                   .centre = lw_v2_add(x->p[0], lw_v2_scale(pin[3], unit)) };
    lw_ranking_offer(r, &a, &b, angle);
}

static void draw_many(exact_run *x, lw_rng *rng, lw_ranking *r, long *drawn)
{
    double u[ANGLES*4];
    lw_guide g[4];
    five v;
    size_t n = x->t->n;
    if (!lw_low_discrepancy(rng, ANGLES, 4, u)) {
        lw_ranking_lose(r);
        return;
    }
    for (size_t j = 1; j < n; j++)
        v.step[j - 1] = lw_v2_scale(lw_v2_sub(x->p[j], x->p[0]), 1/x->t->size);
    for (size_t k = 0; k < 5; k++) {
        v.at[k] = k*(n - 1)/4;
        v.p[k] = x->p[v.at[k]];
    }
    for (int i = 0; i < ANGLES; i++) {
        lw_guide_rows rows;
        draw_angles(&u[i*4], 5, v.angle);
        for (size_t k = 0, j = 0; j < n; j++) {                /* between these five angles are interpolated */
            k += k < 3 && j > v.at[k + 1];
            double part = (double)(j - v.at[k])/(double)(v.at[k + 1] - v.at[k]);
            v.all[j] = v.angle[k] + part*(v.angle[k + 1] - v.angle[k]);
        }
        lw_guide_rows_make(&(lw_poses){ 5, v.p, v.angle }, x->t->size, &rows);
        int found = rows.n == 4 ? lw_guide_rows_solve(&rows, g) : 0;
        for (int k = 0; k < found; k++)
            for (int l = 0; l < k; l++)
                settle_pair(x, &v, &g[k], &g[l], r);
    }
    *drawn += ANGLES;
}

static bool stopped(const exact_run *x)
{
    return (x->o->interrupt && *x->o->interrupt)
        || (x->o->max_seconds > 0 && lw_clock_wall() - x->started >= x->o->max_seconds);
}

static void run_job(void *context, size_t job, int thread)
{
    exact_run *x = context;
    lw_rng rng;
    (void)thread;
    if (!x->of[job] || stopped(x))
        return;
    lw_rng_seed(&rng, x->o->seed, x->first_job + job);
    if (lw_task_has_angle(x->o->spec.task))
        draw_poses(x, &rng, x->of[job], &x->drawn[job]);
    else if (x->t->n > 5)
        draw_many(x, &rng, x->of[job], &x->drawn[job]);
    else
        draw_path(x, &rng, x->of[job], &x->drawn[job]);
}

/* Run rounds of jobs, each with a list of its own; the lists are joined in the order of the jobs. */
static lw_status draw_rounds(exact_run *x, lw_ranking *r, long *drawn, lw_error *e)
{
    lw_ranking *of[JOBS];
    long count[JOBS];
    int rounds = x->o->max_rounds > 0 ? x->o->max_rounds : 4;
    lw_status st = LW_OK;
    x->of = of;
    x->drawn = count;
    for (int k = 0; k < rounds && st == LW_OK && !stopped(x); k++) {
        memset(of, 0, sizeof of);
        memset(count, 0, sizeof count);
        for (int j = 0; j < JOBS && st == LW_OK; j++)
            st = lw_ranking_open(x->t, x->o, true, &of[j], e);
        x->first_job = (size_t)k*JOBS;
        if (st == LW_OK)
            st = lw_parallel(x->o->jobs, JOBS, run_job, x);
        for (int j = 0; j < JOBS; j++) {
            lw_ranking_merge(r, of[j]);
            lw_ranking_close(of[j]);
            *drawn += count[j];
        }
        if (x->o->progress)
            x->o->progress(x->o->context, (k + 1.0)/rounds, lw_clock_wall() - x->started, 0);
    }
    return st;
}

/* ---- the tasks ------------------------------------------------------------------------------------------- */

static lw_status run_function(exact_run *x, lw_ranking *r, lw_exact *out, lw_error *e)
{
    lw_function_bar bar[LW_FREUDENSTEIN_MAX];
    int n;
    lw_status st = lw_freudenstein(x->t->n, x->t->angle, x->t->theta, bar, &n, e);
    for (int i = 0; i < n && st == LW_OK; i++)
        lw_ranking_offer_function(r, &bar[i]);
    out->complete = true;
    if (x->t->n == 3)
        snprintf(out->choice, sizeof out->choice, "angles count from the line of the fixed pins");
    if (x->t->n == 4)
        snprintf(out->choice, sizeof out->choice, "the zero of the input is free and the output's is the line of the "
                 "fixed pins, or the other way round");
    return st;
}

static lw_status run_motion(exact_run *x, lw_ranking *r, lw_exact *out, lw_error *e)
{
    static const char *const free_of[] = {
        "", "", "the fixed pin of each guide and a number for its moving pin", "the fixed pin of each guide",
        "one number for each guide: a line on which its fixed or moving pin lies", ""
    };
    lw_guide_rows rows;
    long drawn = 0;
    lw_guide_rows_make(&(lw_poses){ x->t->n, x->p, x->t->theta }, 0, &rows);
    if (rows.n == 4) {
        out->n_guide = lw_guide_rows_solve(&rows, out->guide);
        out->complete = out->n_guide >= 0;
        if (out->n_guide < 0)
            out->n_guide = 0;
        offer_pairs(r, out->guide, out->n_guide, x->t->theta);
        return LW_OK;
    }
    if (rows.n == 0)
        return lw_error_set(e, LW_E_NUMERIC, "the poses say nothing: all are the same");
    lw_status st = draw_rounds(x, r, &drawn, e);
    snprintf(out->choice, sizeof out->choice, "free: %s; %ld draws within %g sizes of the target", free_of[rows.n + 1], drawn, REACH);
    out->fit.starts = drawn;
    return st;
}

/* Do the bounds leave one place for each fixed pin? */
static bool gives_pivots(const lw_fit_spec *s, lw_vec2 pivot[2])
{
    static const char *const name[4] = { "x0", "y0", "r1", "theta0" };
    double v[4] = { NAN, NAN, NAN, NAN };
    for (int b = 0; b < s->n_bound; b++)
        for (int k = 0; k < 4; k++)
            if (strcmp(s->bound[b].name, name[k]) == 0 && s->bound[b].lo == s->bound[b].hi)
                v[k] = s->bound[b].lo;
    pivot[0] = lw_v2(v[0], v[1]);
    pivot[1] = lw_v2_add(pivot[0], lw_v2_polar(v[2], v[3]));
    return isfinite(pivot[1].x) && isfinite(pivot[1].y);
}

static lw_status run_path(exact_run *x, lw_ranking *r, lw_exact *out, lw_error *e)
{
    long drawn = 0;
    lw_vec2 pivot[2];
    if (x->t->n == 9)
        return lw_nine_solve(x->p, NULL, x->o, r, out);
    if (x->t->n == 5 && gives_pivots(&x->o->spec, pivot))
        return lw_nine_solve(x->p, pivot, x->o, r, out);
    lw_status st = draw_rounds(x, r, &drawn, e);
    if (x->t->n > 5)
        snprintf(out->choice, sizeof out->choice, "free: %zu of the coupler's angles at four points, the others "
                 "follow; %ld draws", 9 - x->t->n, drawn);
    else
        snprintf(out->choice, sizeof out->choice, "free: the coupler's angles at the points%s; %ld draws",
                 x->t->n < 5 ? " and the pins of each guide as for a motion" : "", drawn);
    out->fit.starts = drawn;
    return st;
}

static const method methods[LW_TASKS] = {
    [LW_TASK_PATH]     = { 2, 9, 9, "points", "fourbar", run_path },
    [LW_TASK_FUNCTION] = { 3, 5, 3, "pairs of angles", "fourbar", run_function },
    [LW_TASK_MOTION]   = { 2, 5, 5, "poses (points with a tool angle)", "all", run_motion }
};

lw_status lw_exact_run(const lw_target *t, const lw_fit_options *o, lw_exact *out, lw_error *e)
{
    lw_fit_options own = *o;
    exact_run x = { .t = t, .o = &own, .started = lw_clock_wall() };
    const method *m = &methods[o->spec.task];
    lw_ranking *r = NULL;
    memset(out, 0, sizeof *out);
    if (!own.types)
        own.types = t->n < m->finite ? "fourbar" : m->types;
    lw_vec2 pivot[2];
    bool pivots = o->spec.task == LW_TASK_PATH && t->n == 5 && gives_pivots(&o->spec, pivot);
    if (pivots && own.n_result < LW_EXACT_FIVE_MAX)
        own.n_result = LW_EXACT_FIVE_MAX;                  /* list them all */
    lw_status st = check_task(t, &o->spec, m, e);
    if (st == LW_OK)
        st = check_distinct(t, o->spec.task, e);
    if (st == LW_OK)
        st = lw_ranking_open(t, &own, t->n < m->finite && !pivots, &r, e);
    if (st != LW_OK)
        return st;
    for (size_t i = 0; i < t->n && t->x; i++)
        x.p[i] = lw_v2(t->x[i], t->y[i]);
    x.slides = lw_ranking_slides(r);
    st = m->run(&x, r, out, e);
    bool early = stopped(&x);
    if (st == LW_OK)
        st = lw_ranking_finish(r, out);
    lw_ranking_close(r);
    out->fit.seconds = lw_clock_wall() - x.started;
    out->fit.stop = !early ? LW_STOP_F_TARGET : o->interrupt && *o->interrupt ? LW_STOP_USER : LW_STOP_TIME;
    if (st == LW_E_MEMORY)
        lw_error_set(e, st, "no memory for the linkages");
    if (st < 0)
        lw_exact_free(out);
    return (st == LW_OK || st == LW_NOTHING) && early ? LW_STOPPED : st;
}

void lw_exact_free(lw_exact *x)
{
    lw_fit_free(&x->fit);
    free(x->defect);
    free(x->quality);
    memset(x, 0, sizeof *x);
}
