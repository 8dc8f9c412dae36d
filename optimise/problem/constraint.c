/* optimise/problem/constraint.c - the conditions g(x) >= 0 of a fitting problem. */
#include "optimise/problem/constraint.h"

#include <string.h>

#include "mbs/batch/pose.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"

/* Conditions on the motion are checked in LW_CURVE_SAMPLES poses: over the turn if the input turns fully, else from the
 * first station to the last. The samples of a turn include every multiple of 90 degrees in the ground frame, where
 * transmission angles of four-link chains have their extremes. Other extremes are found between the samples by a
 * parabola. */
enum {
    POSES = LW_CURVE_SAMPLES,
    HALVINGS = 24                     /* of the straight line between two poses near a box                  */
};

static void linear(const lw_problem *p, const double *x, double *g)
{
    for (int j = 0; j < p->n_linear; j++) {
        g[j] = -LW_LINEAR_LEAST;
        for (int v = 0; v < p->n_var; v++)
            g[j] += p->linear[j][v]*x[v];
    }
}

double lw_problem_input_at(const lw_problem *p, const lw_work *w, double part, double *mode, int *leg)
{
    double lo = w->input[0], hi = lo;
    *leg = 0;
    if (lw_problem_has_modes(p)) {
        double length = p->closed || p->timing == LW_TIMING_NONE ? 2*LW_PI : w->phase[p->n - 1] - w->phase[0];
        lw_cycle_point at = lw_circuit_point(p, w, w->phase[0] + length*part);
        lw_circuit_put_mode(p, w, at.leg, mode, 1);
        *leg = at.leg;
        return at.input;
    }
    memcpy(mode, p->intended.mode, sizeof p->intended.mode);
    for (size_t k = 1; k < p->n; k++) {
        lo = fmin(lo, w->input[k]);
        hi = fmax(hi, w->input[k]);
    }
    return lo + (p->intended.turns && (p->closed || p->must_turn) ? 2*LW_PI : hi - lo)*part;
}

static void sample_motion(const lw_problem *p, lw_work *w)
{
    for (size_t i = 0; i < POSES; i++) {
        double mode[LW_MODE_MAX];
        int leg;
        double at = lw_problem_input_at(p, w, (double)i/(POSES - 1), mode, &leg);
        w->check_c[i] = p->plan.input_is_slider ? at : cos(at);
        w->check_s[i] = p->plan.input_is_slider ? 0 : sin(at);
        w->check_leg[i] = (short)leg;
        if (lw_problem_has_modes(p))
            lw_circuit_put_mode(p, w, leg, w->check_mode + i, POSES);
    }
}

/* Compute the poses at x. False: the linkage cannot close. */
static bool find_poses(const lw_problem *p, const double *x, lw_work *w)
{
    if (p->intended.turns) {
        memcpy(w->check_c, w->turn_c, sizeof *w->check_c*POSES);
        memcpy(w->check_s, w->turn_s, sizeof *w->check_s*POSES);
        return true;
    }
    if (p->timing == LW_TIMING_PRESCRIBED)
        lw_problem_prescribe(p, x, w);
    else if (!lw_problem_settle(p, x, w))
        return false;
    sample_motion(p, w);
    return true;
}

/* Does the motion pass a limit on the way to the next sample? */
static bool changes(const lw_problem *p, const lw_work *w, size_t k)
{
    return lw_problem_has_modes(p) && k + 1 < POSES && w->check_leg[k] != w->check_leg[k + 1];
}

static void margins(const lw_problem *p, const double *x, lw_work *w, double *margin)
{
    bool modes = lw_problem_has_modes(p);
    lw_lanes in = { .n = POSES, .c = w->check_c, .s = w->check_s, .dim = x,
                    .mode = modes ? w->check_mode : p->intended.mode,
                    .mode_stride = modes ? POSES : 0 };
    lw_problem_margin(p, &in, w, margin);
    for (size_t k = 0; k < POSES; k++)
        if (changes(p, w, k))
            margin[k] = margin[k + 1] = fmin(0, fmin(margin[k], margin[k + 1]));
}

static void closure(const lw_problem *p, const double *x, lw_work *w, double *margin)
{
    lw_lanes in = { .n = p->n, .c = w->c, .s = w->s, .dim = x, .mode = p->intended.mode };
    lw_problem_margin(p, &in, w, margin);
}

/* Lower each sample that is less than both neighbours to the vertex of the parabola through the three. */
static void look_between(bool round, double *g)
{
    double before = round ? g[POSES - 1] : INFINITY, first = g[0];
    for (size_t k = 0; k < POSES; k++) {
        double now = g[k], after = k + 1 < POSES ? g[k + 1] : round ? first : INFINITY;
        double bend = before + after - 2*now, slope = after - before;
        if (now <= before && now <= after && bend > 0 && isfinite(bend))
            g[k] -= slope*slope/(8*bend);
        before = now;
    }
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

/* Tangents dP/d(input), with every input shifted by `by`. */
static void tangents(const lw_problem *p, const double *x, lw_work *w, double by, double *tx,
                     double *ty)
{
    double cb = cos(by), sb = sin(by);
    for (size_t k = 0; k < POSES; k++) {
        double c = w->check_c[k], s = w->check_s[k];
        w->pose_c[k] = p->plan.input_is_slider ? c + by : cb*c - sb*s;
        w->pose_s[k] = p->plan.input_is_slider ? 0 : sb*c + cb*s;
    }
    if (!lw_problem_has_modes(p)) {
        tangents_of_mode(p, x, w, 0, POSES, p->intended.mode, tx, ty);
        return;
    }
    for (size_t first = 0, k = 1; k <= POSES; k++)
        if (k == POSES || w->check_leg[k] != w->check_leg[first]) {
            tangents_of_mode(p, x, w, first, k, w->swing.stroke[w->check_leg[first]].mode, tx, ty);
            first = k;
        }
}

/* 1 - |P''|^2 / limit^2. P'' is the difference of exact tangents 1e-4 rad apart (error 1e-8). For a function it is that
 * of the output angle psi: the tracer has distance one from the output's pin, so |P''|^2 = psi''^2 + |P'|^4. */
static void accelerations(const lw_problem *p, const double *x, lw_work *w, double *g)
{
    const double h = 1e-4, limit2 = p->max_acceleration*p->max_acceleration;
    tangents(p, x, w, +h, w->pose_x, w->pose_y);
    tangents(p, x, w, -h, w->pose_u, w->pose_v);
    for (size_t k = 0; k < POSES; k++) {
        double ax = (w->pose_x[k] - w->pose_u[k])/(2*h), ay = (w->pose_y[k] - w->pose_v[k])/(2*h);
        double vx = 0.5*(w->pose_x[k] + w->pose_u[k]), vy = 0.5*(w->pose_y[k] + w->pose_v[k]);
        double turn2 = !lw_task_has_place(p->task) ? pow(vx*vx + vy*vy, 2) : 0;
        g[k] = 1 - (ax*ax + ay*ay - turn2)/limit2;
    }
    for (size_t k = 0; k < POSES; k++)                        /* at a dead point it is unbounded */
        if (changes(p, w, k))
            g[k] = g[k + 1] = fmin(-1, fmin(g[k], g[k + 1]));
}

/* ---- zones: where fixed pivots must be, and where no pin and no tracer may be -------------------------------- */

static double *pivot_conditions(const lw_zone *z, const lw_vec2 *at, int n, double *g)
{
    for (int k = 0; k < n; k++) {
        if (z->kind == LW_ZONE_PIVOTS_BOX) {
            *g++ = at[k].x - z->at.x;
            *g++ = z->to.x - at[k].x;
            *g++ = at[k].y - z->at.y;
            *g++ = z->to.y - at[k].y;
            continue;
        }
        double off = lw_v2_cross(z->to, lw_v2_sub(at[k], z->at));
        *g++ = z->reach - off;
        *g++ = z->reach + off;
    }
    return g;
}

/* Lengths are scaled, so hypot, which avoids overflow, is not needed: it costs a fifth of the time here. */
static double length_of(lw_vec2 a) { return sqrt(lw_v2_dot(a, a)); }

/* The least distance to a zone along the straight line from a to b. The distance is convex along a line and changes by
 * at most the length of the line. */
static double outside_between(const lw_zone *z, lw_vec2 a, lw_vec2 b, double enough)
{
    lw_vec2 line = lw_v2_sub(b, a);
    double from = lw_zone_outside(z, a), to = lw_zone_outside(z, b), lo = 0, hi = 1, least = fmin(from, to);
    double length = length_of(line);
    if (length == 0 || !(0.5*(from + to - length) < enough))
        return least;
    if (z->kind == LW_ZONE_NO_CIRCLE)
        return lw_v2_segment_distance(z->at, a, b) - z->reach;
    for (int i = 0; i < HALVINGS; i++) {
        double third = (hi - lo)/3, p = lw_zone_outside(z, lw_v2_add(a, lw_v2_scale(line, lo + third)));
        double q = lw_zone_outside(z, lw_v2_add(a, lw_v2_scale(line, hi - third)));
        least = fmin(least, fmin(p, q));
        if (p < q)
            hi -= third;
        else
            lo += third;
    }
    return least;
}

typedef struct places { int n; lw_vec2 at[LW_JOINT_MAX + 1 + LW_ALSO_MAX]; } places;

/* Find all pins that turn, and the tracers; none if the linkage does not close. */
static void find_places(const lw_problem *p, const double *x, const double *mode, double input, places *out)
{
    lw_pose pose;
    out->n = 0;
    if (lw_pose_solve(&p->plan, x, mode, input, 0, &pose) != LW_OK)
        return;
    for (int j = 0; j < LW_JOINT_MAX; j++)
        if (p->plan.joint_point[j] >= 0)
            out->at[out->n++] = pose.joint[j][0];
    for (int i = 0; i <= p->n_also; i++)
        out->at[out->n++] = pose.tracer[i][0];
}

/* How far a path may leave the chord between its poses b and c, from its curvature at b. */
static double bulge(lw_vec2 a, lw_vec2 b, lw_vec2 c)
{
    return 0.125*length_of(lw_v2_sub(lw_v2_add(a, c), lw_v2_scale(b, 2)));
}

/* Least distance between poses b and c, where a is the pose before b. 0 if one of them does not close; another
 * condition covers that. */
static double least_between(const lw_zone *z, const places *a, const places *b, const places *c)
{
    double least = INFINITY;
    for (int i = 0; i < b->n && c->n == b->n; i++) {
        double out = a->n == b->n ? bulge(a->at[i], b->at[i], c->at[i]) : 0;
        least = fmin(least, outside_between(z, b->at[i], c->at[i], least + out) - out);
    }
    return isfinite(least) ? least : 0;
}

/* The least distances of all pins and points from the forbidden zones, between each pose and the next. */
static void forbidden(const lw_problem *p, const double *x, const lw_work *w, double *const *g)
{
    places earlier = { .n = 0 }, before = { .n = 0 }, now;
    double mode[LW_MODE_MAX];
    int leg;
    for (int k = 0; k <= LW_ZONE_SAMPLES; k++) {
        double input = lw_problem_input_at(p, w, (double)k/LW_ZONE_SAMPLES, mode, &leg);
        find_places(p, x, mode, input, &now);
        for (int i = 0; i < p->n_zone && k > 0; i++)
            if (lw_zone_forbids(&p->zone[i]))
                g[i][k - 1] = least_between(&p->zone[i], &earlier, &before, &now);
        earlier = before;
        before = now;
    }
}

static void zones(const lw_problem *p, const double *x, lw_work *w, double *g)
{
    lw_vec2 at[LW_DIM_MAX + 1], turn = lw_v2_polar(1, x[p->plan.i_theta0]);
    double *of[LW_ZONE_MAX];
    int n = p->n_zone > 0 ? lw_problem_fixed_pivots(p, x, at) : 0;
    bool any = false;
    for (int k = 0; k < n; k++)
        at[k] = lw_v2_add(lw_v2(x[p->plan.i_x0], x[p->plan.i_y0]), lw_v2_turn(at[k], turn));
    for (int i = 0; i < p->n_zone; i++) {
        const lw_zone *z = &p->zone[i];
        of[i] = g;
        any |= lw_zone_forbids(z);
        g = lw_zone_forbids(z) ? g + LW_ZONE_SAMPLES : pivot_conditions(z, at, n, g);
    }
    if (any)
        forbidden(p, x, w, of);
}

/* ---- all of them ------------------------------------------------------------------------------------------- */

static void values(const lw_problem *p, const double *x, double *g, lw_work *w)
{
    double sine = sin(p->min_transmission);
    size_t m = lw_problem_constraint_count(p) - (size_t)p->n_linear;
    linear(p, x, g);
    g += p->n_linear;
    if (m > 0 && !find_poses(p, x, w)) {
        for (size_t k = 0; k < m; k++)
            g[k] = -1;                                   /* without poses the condition counts as fully violated */
        return;
    }
    if (lw_problem_must_close(p)) {
        closure(p, x, w, g);
        g += p->n;
    }
    if (p->min_transmission > 0) {
        margins(p, x, w, g);
        for (size_t k = 0; k < POSES; k++)
            g[k] -= sine*sine;
        look_between(p->intended.turns, g);
        g += POSES;
    }
    if (p->max_acceleration > 0) {
        accelerations(p, x, w, g);
        look_between(p->intended.turns, g);
        g += POSES;
    }
    zones(p, x, w, g);
}

/* Central differences for the conditions on the motion, exact rows for the linear conditions. */
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
