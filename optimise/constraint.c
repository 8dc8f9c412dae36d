/* optimise/constraint.c - the subsidiary conditions g(x) >= 0 of a fitting problem. */
#include <string.h>

#include "optimise/problem_internal.h"

/* Conditions on the motion are looked at in these poses: over the turn when the input turns, else at
 * the stations.  The samples of a turn hold every multiple of 90 degrees of the ground frame, where
 * transmission angles of four-link chains have their extremes. */
static size_t pose_count(const lw_problem *p)
{
    return p->branch.turns ? LW_CURVE_SAMPLES : p->n;
}

static bool must_stay_closed(const lw_problem *p)
{
    return !p->branch.turns && p->timing == LW_TIMING_PRESCRIBED;
}

bool lw_problem_is_nonlinear(const lw_problem *p)
{
    return must_stay_closed(p) || p->min_transmission > 0 || p->max_acceleration > 0 || p->n_zone > 0;
}

size_t lw_problem_constraint_count(const lw_problem *p)
{
    return (size_t)p->n_linear + (must_stay_closed(p) ? p->n : 0)
         + (p->min_transmission > 0 ? pose_count(p) : 0)
         + (p->max_acceleration > 0 ? pose_count(p) : 0) + lw_zone_count(p);
}

size_t lw_problem_constraint_most(const lw_problem *p)
{
    size_t poses = p->n > LW_CURVE_SAMPLES ? p->n : LW_CURVE_SAMPLES;
    return (size_t)p->n_linear + 3*poses + lw_zone_count(p);
}

static void linear(const lw_problem *p, const double *x, double *g)
{
    for (int j = 0; j < p->n_linear; j++) {
        g[j] = -LW_LINEAR_LEAST;
        for (int v = 0; v < p->n_var; v++)
            g[j] += p->linear[j][v]*x[v];
    }
}

/* The inputs (and modes) of the poses at x; false when it cannot close. */
static bool find_poses(const lw_problem *p, const double *x, lw_work *w)
{
    if (p->branch.turns)
        return true;
    if (p->timing != LW_TIMING_PRESCRIBED)
        return lw_problem_settle(p, x, w);
    lw_problem_prescribe(p, x, w);
    return true;
}

static void margins(const lw_problem *p, const double *x, lw_work *w, double *margin)
{
    lw_lanes in = { .n = pose_count(p), .c = p->branch.turns ? w->turn_c : w->c,
                    .s = p->branch.turns ? w->turn_s : w->s, .dim = x, .mode = p->branch.mode };
    lw_circuit_modes(p, w, &in);
    lw_problem_margin(p, &in, w, margin);
}

static void tangents_of_mode(const lw_problem *p, const double *x, lw_work *w, size_t first, size_t last,
                             const double *mode, double *tx, double *ty)
{
    lw_lanes in = { .n = last - first, .c = w->pose_c + first, .s = w->pose_s + first, .dim = x,
                    .mode = mode };
    lw_jacobian j = w->pose;
    j.tx = tx + first;
    j.ty = ty + first;
    lw_batch_jacobian(&p->plan, &in, 0, w->batch, &j);
}

/* Tangents dP/d(input) with every input turned by `by`. */
static void tangents(const lw_problem *p, const double *x, lw_work *w, double by, double *tx,
                     double *ty)
{
    size_t n = pose_count(p);
    const double *c = p->branch.turns ? w->turn_c : w->c, *s = p->branch.turns ? w->turn_s : w->s;
    double cb = cos(by), sb = sin(by);
    for (size_t k = 0; k < n; k++) {
        w->pose_c[k] = p->plan.input_is_slider ? c[k] + by : cb*c[k] - sb*s[k];
        w->pose_s[k] = p->plan.input_is_slider ? 0 : sb*c[k] + cb*s[k];
    }
    if (!lw_problem_has_modes(p)) {
        tangents_of_mode(p, x, w, 0, n, p->branch.mode, tx, ty);
        return;
    }
    for (size_t first = 0, next; first < n; first = next) {
        next = lw_circuit_run(w, first, n);
        tangents_of_mode(p, x, w, first, next, w->swing.stroke[w->leg[first]].mode, tx, ty);
    }
}

/* 1 - |P''|^2 / limit^2; P'' is differenced from exact tangents 1e-4 rad apart (error 1e-8). */
static void accelerations(const lw_problem *p, const double *x, lw_work *w, double *g)
{
    const double h = 1e-4;
    tangents(p, x, w, +h, w->pose_x, w->pose_y);
    tangents(p, x, w, -h, w->pose_u, w->pose_v);
    for (size_t k = 0; k < pose_count(p); k++) {
        double ax = (w->pose_x[k] - w->pose_u[k])/(2*h), ay = (w->pose_y[k] - w->pose_v[k])/(2*h);
        g[k] = 1 - (ax*ax + ay*ay)/(p->max_acceleration*p->max_acceleration);
    }
}

static void values(const lw_problem *p, const double *x, double *g, lw_work *w)
{
    double sine = sin(p->min_transmission);
    size_t m = lw_problem_constraint_count(p) - (size_t)p->n_linear;
    linear(p, x, g);
    g += p->n_linear;
    if (m > 0 && !find_poses(p, x, w)) {
        for (size_t k = 0; k < m; k++)
            g[k] = -1;                                   /* it has no poses: as violated as can be */
        return;
    }
    if (must_stay_closed(p)) {
        margins(p, x, w, g);
        g += p->n;
    }
    if (p->min_transmission > 0) {
        margins(p, x, w, g);
        for (size_t k = 0; k < pose_count(p); k++)
            g[k] -= sine*sine;
        g += pose_count(p);
    }
    if (p->max_acceleration > 0) {
        accelerations(p, x, w, g);
        g += pose_count(p);
    }
    lw_zone_conditions(p, x, w, g);
}

/* Central differences for the conditions on the motion, exact rows for the linear ones. */
static void derivatives(const lw_problem *p, const double *x, double *j, lw_work *w)
{
    size_t m = lw_problem_constraint_count(p), nv = (size_t)p->n_var;
    double at[LW_VAR_MAX];
    memcpy(at, x, sizeof at[0]*nv);
    for (size_t v = 0; v < nv && m > (size_t)p->n_linear; v++) {
        double h = 2e-7*fmax(1, fabs(x[v]));
        at[v] = x[v] + h;
        values(p, at, w->g_up, w);
        at[v] = x[v] - h;
        values(p, at, w->g_down, w);
        at[v] = x[v];
        for (size_t i = (size_t)p->n_linear; i < m; i++)
            j[i*nv + v] = (w->g_up[i] - w->g_down[i])/(2*h);
    }
    for (int i = 0; i < p->n_linear; i++)
        memcpy(j + (size_t)i*nv, p->linear[i], sizeof *j*nv);
}

void lw_problem_constraints(const lw_problem *p, const double *x, double *g, double *j, void *work)
{
    values(p, x, g, work);
    if (j)
        derivatives(p, x, j, work);
}

bool lw_problem_admissible(const lw_problem *p, const double *x, double off, lw_work *w)
{
    lw_problem_constraints(p, x, w->g_now, NULL, w);
    for (size_t i = 0; i < lw_problem_constraint_count(p); i++)
        if (!(w->g_now[i] >= -off))
            return false;
    return true;
}
