/* optimise/problem/zone.c - conditions on places: where the fixed pivots have to be, and where no pin and no tracer may
 * come. */
#include <string.h>

#include "mbs/plan/pose.h"
#include "optimise/problem/family.h"
#include "optimise/problem/problem_internal.h"

enum {
    POSES = 24,                       /* steps of the motion in which forbidden zones are looked at      */
    HALVINGS = 24                     /* of the way between two poses beside a box                      */
};

/* Fixed pivots: their places in the ground frame; the first is its origin.  Returns how many. */
static int fixed_pivots(const lw_problem *p, const double *x, lw_vec2 *at)
{
    int n = 0, ground = p->plan.link[0];
    at[n++] = lw_v2(0, 0);
    for (int d = 0; d < p->n_dim; d++) {
        const lw_dim_info *i = &p->plan.dim[d];
        if (i->link != ground)
            continue;
        if (i->role == LW_ROLE_R)
            at[n++] = lw_v2(x[d], 0);
        if (i->role == LW_ROLE_X)
            at[n++] = lw_v2(x[d], 0);
        if (i->role == LW_ROLE_Y)
            at[n - 1].y = x[d];
    }
    return n;
}

size_t lw_zone_count(const lw_problem *p)
{
    double x[LW_VAR_MAX] = { 0 };
    lw_vec2 at[LW_DIM_MAX + 1];
    size_t n = 0, pivots = p->n_zone > 0 ? (size_t)fixed_pivots(p, x, at) : 0;
    for (int i = 0; i < p->n_zone; i++)
        n += lw_zone_forbids(&p->zone[i]) ? POSES : p->zone[i].kind == LW_ZONE_PIVOTS_BOX ? 4*pivots : 2*pivots;
    return n;
}

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

/* Scaled lengths have no need of hypot's care, which is a fifth of the time here. */
static double length_of(lw_vec2 a) { return sqrt(lw_v2_dot(a, a)); }

/* The least distance from it on the way from a to b, taken as straight: it is convex along a line, and falls no faster
 * than the way is long. */
static double outside_between(const lw_zone *z, lw_vec2 a, lw_vec2 b, double enough)
{
    lw_vec2 way = lw_v2_sub(b, a);
    double from = lw_zone_outside(z, a), to = lw_zone_outside(z, b), lo = 0, hi = 1, least = fmin(from, to);
    double length = length_of(way);
    if (length == 0 || !(0.5*(from + to - length) < enough))
        return least;
    if (z->kind == LW_ZONE_NO_CIRCLE)
        return lw_v2_segment_distance(z->at, a, b) - z->reach;
    for (int i = 0; i < HALVINGS; i++) {
        double third = (hi - lo)/3, p = lw_zone_outside(z, lw_v2_add(a, lw_v2_scale(way, lo + third)));
        double q = lw_zone_outside(z, lw_v2_add(a, lw_v2_scale(way, hi - third)));
        least = fmin(least, fmin(p, q));
        if (p < q)
            hi -= third;
        else
            lo += third;
    }
    return least;
}

typedef struct places { int n; lw_vec2 at[LW_JOINT_MAX + 1 + LW_ALSO_MAX]; } places;

/* All pins that turn, and the tracers; none where it does not close. */
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

/* How far a way may bulge out from between its poses b and c, by how it bends at b. */
static double bulge(lw_vec2 a, lw_vec2 b, lw_vec2 c)
{
    return 0.125*length_of(lw_v2_sub(lw_v2_add(a, c), lw_v2_scale(b, 2)));
}

/* Between poses b and c, a the one before; 0 where one does not close, which is another condition. */
static double least_between(const lw_zone *z, const places *a, const places *b, const places *c)
{
    double least = INFINITY;
    for (int i = 0; i < b->n && c->n == b->n; i++) {
        double out = a->n == b->n ? bulge(a->at[i], b->at[i], c->at[i]) : 0;
        least = fmin(least, outside_between(z, b->at[i], c->at[i], least + out) - out);
    }
    return isfinite(least) ? least : 0;
}

/* The least distances of all pins and points from the forbidden zones, from pose to pose. */
static void forbidden(const lw_problem *p, const double *x, const lw_work *w, double *const *g)
{
    places earlier = { .n = 0 }, before = { .n = 0 }, now;
    double mode[LW_MODE_MAX];
    int leg;
    for (int k = 0; k <= POSES; k++) {
        double input = lw_problem_way(p, w, (double)k/POSES, mode, &leg);
        find_places(p, x, mode, input, &now);
        for (int i = 0; i < p->n_zone && k > 0; i++)
            if (lw_zone_forbids(&p->zone[i]))
                g[i][k - 1] = least_between(&p->zone[i], &earlier, &before, &now);
        earlier = before;
        before = now;
    }
}

void lw_zone_conditions(const lw_problem *p, const double *x, lw_work *w, double *g)
{
    lw_vec2 at[LW_DIM_MAX + 1], turn = lw_v2_polar(1, x[p->plan.i_theta0]);
    double *of[LW_ZONE_MAX];
    int n = p->n_zone > 0 ? fixed_pivots(p, x, at) : 0;
    bool any = false;
    for (int k = 0; k < n; k++)
        at[k] = lw_v2_add(lw_v2(x[p->plan.i_x0], x[p->plan.i_y0]), lw_v2_turn(at[k], turn));
    for (int i = 0; i < p->n_zone; i++) {
        const lw_zone *z = &p->zone[i];
        of[i] = g;
        any |= lw_zone_forbids(z);
        g = lw_zone_forbids(z) ? g + POSES : pivot_conditions(z, at, n, g);
    }
    if (any)
        forbidden(p, x, w, of);
}
