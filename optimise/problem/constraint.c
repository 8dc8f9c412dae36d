/* optimise/problem/constraint.c - the conditions g(x) >= 0 of a fitting problem, with their derivatives.
 *
 * A condition on the motion is checked in sampled postures.  Its derivative has two parts: by the dimensions at
 * constant input, from the plan's adjoints, and by the input of the posture, which moves with the variables where the
 * ends of the motion do. */
#include "optimise/problem/constraint_internal.h"

#include <string.h>

#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/variable_projection.h"

static void linear(const lw_problem *p, const double *x, double *g)
{
    for (int j = 0; j < p->n_linear; j++) {
        g[j] = -LW_LINEAR_LEAST;
        for (int v = 0; v < p->n_var; v++)
            g[j] += p->linear[j][v]*x[v];
    }
}

/* ---- lengths between points of one link ------------------------------------------------------------------------ */

static double side_length(const double *x, const lw_side *s)
{
    return lw_v2_norm(lw_v2_sub(lw_point_on_link(x, s->to), lw_point_on_link(x, s->from)));
}

/* Add `by` times the derivatives of the length d. */
static void add_slopes(const double *x, const lw_side *s, double d, double by, double *j)
{
    const lw_vec2 span = lw_v2_sub(lw_point_on_link(x, s->to), lw_point_on_link(x, s->from));
    const int *end[2] = { s->from, s->to };
    for (int e = 0; e < 2 && d > 0; e++)
        for (int c = 0; c < 2; c++)
            if (end[e][c] >= 0)
                j[end[e][c]] += (e ? by : -by)*(c ? span.y : span.x)/d;
}

/* The longest of the lengths that are variables and of those that are bounded by it; its value. */
static double longest_side(const lw_problem *p, const double *x, lw_side *longest)
{
    double most = 0;
    *longest = (lw_side){ { -1, -1 }, { -1, -1 }, false, 0, 0 };
    for (int i = 0; i < p->n_side; i++)
        if (p->side[i].ratio > 0 && side_length(x, &p->side[i]) > most) {
            *longest = p->side[i];
            most = side_length(x, longest);
        }
    for (int i = 0; i < p->n_dim; i++)
        if (p->plan.dim[i].kind == LW_DIM_LENGTH && x[i] > most) {
            *longest = (lw_side){ { -1, -1 }, { i, -1 }, false, 0, 0 };
            most = x[i];
        }
    return most;
}

/* 1 - d/most, or d/least - 1. */
static void sides(const lw_problem *p, const double *x, double *g, double *j)
{
    lw_side longest;
    const double most = p->n_side > 0 ? longest_side(p, x, &longest) : 0;
    for (int i = 0; i < p->n_side; i++, g++) {
        const lw_side *s = &p->side[i];
        double d = side_length(x, s), by = s->ratio > 0 ? s->ratio/most : (s->most ? -1 : 1)/s->limit;
        *g = (s->most ? 1 : -1) + by*d;
        if (!j)
            continue;
        memset(j, 0, sizeof *j*(size_t)p->n_var);
        add_slopes(x, s, d, by, j);
        if (s->ratio > 0)
            add_slopes(x, &longest, most, -by*d/most, j);
        j += p->n_var;
    }
}

/* ---- all of them ------------------------------------------------------------------------------------------- */

/* Do conditions need the stations' inputs? */
static bool needs_stations(const lw_problem *p)
{
    bool postures = p->min_transmission > 0 || p->max_acceleration > 0, forbids = false;
    for (int i = 0; i < p->n_zone; i++)
        forbids |= lw_zone_forbids(&p->zone[i]);
    return lw_problem_must_close(p) || (postures && !p->intended.turns) || (forbids && !lw_checked_is_whole(p))
        || (lw_problem_has_modes(p) && (postures || forbids));
}

/* Set the inputs of the stations. False: the linkage cannot close. */
static bool find_stations(const lw_problem *p, const double *x, bool settled, lw_work *w)
{
    if (settled || !needs_stations(p))
        return true;
    if (p->timing == LW_TIMING_PRESCRIBED)
        lw_problem_prescribe(p, x, w);
    else if (lw_checked_is_whole(p))
        return lw_circuit_find(p, x, w);
    else
        return lw_problem_settle(p, x, w);
    return true;
}

void lw_problem_conditions(const lw_problem *p, const double *x, bool settled, double enough, double *g, double *j, lw_work *w)
{
    size_t m = lw_problem_constraint_count(p) - (size_t)p->n_linear, nv = (size_t)p->n_var;
    linear(p, x, g);
    for (int i = 0; j && i < p->n_linear; i++)
        memcpy(j + (size_t)i*nv, p->linear[i], sizeof *j*nv);
    g += p->n_linear;
    j += j ? (size_t)p->n_linear*nv : 0;
    sides(p, x, g, j);
    g += p->n_side;
    j += j ? (size_t)p->n_side*nv : 0;
    m -= (size_t)p->n_side;
    if (m == 0)
        return;
    if (!find_stations(p, x, settled, w)) {
        for (size_t k = 0; k < m; k++)
            g[k] = -1;                                   /* without postures the condition counts as fully violated */
        if (j)
            memset(j, 0, sizeof *j*m*nv);
        return;
    }
    lw_checked_motion between = lw_checked_motion_of(p, w);
    if (j && needs_stations(p) && between.moves)
        lw_checked_end_slopes(p, x, w, &between);
    if (j && lw_problem_has_modes(p))
        lw_circuit_slopes(p, x, w);
    if (lw_problem_must_close(p)) {
        lw_check_closure(p, x, w, g, j);
        g += p->n;
        j += j ? p->n*nv : 0;
    }
    lw_checked_motion turn = { .moves = false }, *checked = p->intended.turns ? &turn : &between;
    if (p->min_transmission > 0) {
        size_t n = lw_problem_transmission_postures(p);
        lw_checked_sample(p, w, checked, n);
        lw_check_transmissions(p, x, w, checked, enough, g, j);
        g += n;
        j += j ? n*nv : 0;
    }
    if (p->max_acceleration > 0) {
        lw_checked_sample(p, w, checked, LW_CURVE_SAMPLES);
        lw_check_accelerations(p, x, w, checked, enough, g, j);
        g += LW_CURVE_SAMPLES;
        j += j ? LW_CURVE_SAMPLES*nv : 0;
    }
    if (p->n_zone > 0)
        lw_check_zones(p, x, w, &between, enough, g, j);
}

void lw_problem_constraints(const lw_problem *p, const double *x, double *g, double *j, void *work)
{
    lw_problem_conditions(p, x, false, INFINITY, g, j, work);
}

double lw_problem_lacks(const lw_problem *p, const double *x, lw_work *w)
{
    double most = 0;
    lw_problem_constraints(p, x, w->g_now, NULL, w);
    for (size_t i = 0; i < lw_problem_constraint_count(p); i++)
        most = fmax(most, isnan(w->g_now[i]) ? INFINITY : -w->g_now[i]);
    return most;
}

bool lw_problem_admissible(const lw_problem *p, const double *x, double off, lw_work *w)
{
    return lw_problem_lacks(p, x, w) <= off;
}
