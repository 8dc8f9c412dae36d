/* tests/fit_problem.h - linkages of every family and targets they trace, for the tests of optimise/. */
#ifndef LW_TESTS_FIT_PROBLEM_H
#define LW_TESTS_FIT_PROBLEM_H

#include <stdlib.h>
#include <string.h>
#include "mbs/batch/posture.h"
#include "optimise/problem/family.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/constraint.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/timing.h"
#include "optimise/problem/variable_projection.h"
#include "tests/check.h"

#define STATION_MAX 64

static inline const lw_family *family_named(const char *name)
{
    const lw_family *f = lw_family_table;
    while (strcmp(f->name, name) != 0)
        f++;
    return f;
}

/* One linkage of a family, in SI. */
typedef struct member {
    const lw_family *family;
    lw_plan plan;
    double  mode, dim[LW_DIM_MAX], first, last;     /* its input runs from first to last            */
} member;

static inline double *dim_named(member *m, const char *name)
{
    int i = lw_plan_dim(&m->plan, name);
    CHECK(i >= 0);
    return &m->dim[i < 0 ? 0 : i];
}

static inline void make_plan_of(const lw_family *f, bool function, lw_plan *plan)
{
    lw_linkage k;
    lw_type_linkage(lw_type_find(f->type), &k);
    if (function)
        k.tracer[0].link = 3;
    CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, plan, NULL), LW_OK);
}

/* Inputs over which a member moves without a limit: the turn, or the middle of the longest stretch
 * that sampling finds. */
static inline void find_way(member *m)
{
    enum { STEPS = 400 };
    double from = m->plan.input_is_slider ? -4 : -LW_PI, to = -from;
    m->first = 0;
    m->last = 2*LW_PI;
    if (m->family->turns)
        return;
    int best = 0, best_at = 0, run = 0;
    for (int i = 0; i <= STEPS; i++) {
        lw_posture posture;
        double at = from + (to - from)*i/STEPS;
        bool open = lw_posture_solve(&m->plan, m->dim, &m->mode, at, 0, &posture) != LW_OK || posture.margin < 0.02;
        run = open ? 0 : run + 1;
        if (run > best) {
            best = run;
            best_at = i;
        }
    }
    m->first = from + (to - from)*(best_at - 0.9*best)/STEPS;
    m->last = from + (to - from)*(best_at - 0.1*best)/STEPS;
}

/* A member of moderate shape: lengths and tracer within some ten of each other. */
static inline void draw_member(const char *family, double mode, bool function, lw_rng *rng, member *m)
{
    double u[LW_DRAW_MAX], shape[LW_SHAPE_MAX];
    memset(m, 0, sizeof *m);
    m->family = family_named(family);
    m->mode = mode;
    make_plan_of(m->family, function, &m->plan);
    do {
        for (int i = 0; i < LW_DRAW_MAX; i++)
            u[i] = lw_rng_range(rng, 0.35, 0.75);
        m->family->draw(u, shape);
        for (int i = 0; m->family->shape[i]; i++)
            *dim_named(m, m->family->shape[i]) = shape[i];
        find_way(m);
    } while (!(m->last - m->first > 0.3));
    *dim_named(m, "cx") = function ? 1 : lw_rng_range(rng, -1, 2);
    *dim_named(m, "cy") = function ? 0 : lw_rng_range(rng, 0.5, 1.5);
    *dim_named(m, "x0") = function ? 0 : lw_rng_range(rng, -2, 2);
    *dim_named(m, "y0") = function ? 0 : lw_rng_range(rng, -2, 2);
    *dim_named(m, "theta0") = function ? 0 : lw_rng_range(rng, -3, 3);
}

/* Stations a member passes: k-th of n from first on, a turn short of its end when it turns. */
typedef struct stations {
    size_t n;
    double x[STATION_MAX], y[STATION_MAX], theta[STATION_MAX], input[STATION_MAX];
    bool   closed;
} stations;

static inline void trace_member(const member *m, size_t n, stations *s)
{
    int link = m->plan.output_link[0];
    s->n = n;
    s->closed = m->family->turns;
    for (size_t k = 0; k < n; k++) {
        lw_posture posture;
        double part = s->closed ? (double)k/(double)n : n > 1 ? (double)k/(double)(n - 1) : 0.5;
        s->input[k] = m->first + part*(m->last - m->first);
        CHECK_INT(lw_posture_solve(&m->plan, m->dim, &m->mode, s->input[k], 0, &posture), LW_OK);
        s->x[k] = posture.tracer[0][0].x;
        s->y[k] = posture.tracer[0][0].y;
        s->theta[k] = posture.angle[link][0];
    }
}

static inline void shake_stations(stations *s, double by, lw_rng *rng)
{
    for (size_t k = 0; k < s->n; k++) {
        s->x[k] += by*lw_rng_normal(rng);
        s->y[k] += by*lw_rng_normal(rng);
        s->theta[k] += by*lw_rng_normal(rng);
    }
}

/* The target of these stations, with the columns the task needs. */
static inline void target_of(const stations *s, const lw_fit_spec *spec, lw_target *t)
{
    bool function = spec->task == LW_TASK_FUNCTION;
    bool timed = function || spec->timing == LW_TIMING_PRESCRIBED;
    lw_error e = { .text = "" };
    CHECK_INT(lw_target_make(s->n, function ? NULL : s->x, function ? NULL : s->y,
                             spec->task == LW_TASK_PATH ? NULL : s->theta, timed ? s->input : NULL, NULL,
                             s->closed, t, &e), LW_OK);
}

static inline void *new_work(const lw_problem *p)
{
    void *work = aligned_alloc(64, (lw_problem_work_size(p) + 127)/64*64);
    lw_problem_work_init(p, work);
    return work;
}

static inline double central_difference(const lw_problem *p, const double *x, int i, double h, void *work)
{
    double at[LW_VAR_MAX];
    memcpy(at, x, sizeof at);
    at[i] = x[i] + h;
    double up = lw_problem_value(p, at, NULL, work);
    at[i] = x[i] - h;
    return (up - lw_problem_value(p, at, NULL, work))/(2*h);
}

/* Variables of a member; input0 and tool0 as its stations have them. */
static inline void variables_of(const lw_problem *p, const member *m, double *x)
{
    lw_problem_from_dims(p, m->dim, x);
    if (p->i_input0 >= 0)
        x[p->i_input0] = 0;
    if (p->i_tool0 >= 0)
        x[p->i_tool0] = 0;
}

/* The least of the linear conditions at x. */
static inline double linear_least(const lw_problem *p, const double *x)
{
    double least = INFINITY;
    for (int j = 0; j < p->n_linear; j++) {
        double g = -LW_LINEAR_LEAST;
        for (int v = 0; v < p->n_var; v++)
            g += p->linear[j][v]*x[v];
        least = fmin(least, g);
    }
    return least;
}

#endif
