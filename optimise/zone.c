/* optimise/zone.c - conditions on places: where the fixed pivots have to be, and where no pin and no tracer may
 * come. */
#include <string.h>

#include "mbs/pose.h"
#include "optimise/family.h"
#include "optimise/problem_internal.h"

enum { POSES = 24 };                  /* over the motion, in which forbidden zones are looked at      */

static bool forbids(const lw_zone *z) { return z->kind == LW_ZONE_NO_BOX || z->kind == LW_ZONE_NO_CIRCLE; }

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
        n += forbids(&p->zone[i]) ? POSES : p->zone[i].kind == LW_ZONE_PIVOTS_BOX ? 4*pivots : 2*pivots;
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

/* How far outside a zone a point is; negative inside. */
static double outside(const lw_zone *z, lw_vec2 at)
{
    if (z->kind == LW_ZONE_NO_CIRCLE)
        return lw_v2_norm(lw_v2_sub(at, z->at)) - z->reach;
    double dx = fmax(z->at.x - at.x, at.x - z->to.x), dy = fmax(z->at.y - at.y, at.y - z->to.y);
    return dx > 0 && dy > 0 ? hypot(dx, dy) : fmax(dx, dy);
}

/* All round, or from station to station as they were last: where exactly the motion ends does not matter
 * much, and finding out would cost more than all the rest. */
static void input_range(const lw_problem *p, const lw_work *w, double *lo, double *hi)
{
    *lo = *hi = w->input[0];
    for (size_t k = 1; k < p->n; k++) {
        *lo = fmin(*lo, w->input[k]);
        *hi = fmax(*hi, w->input[k]);
    }
    if (p->branch.turns && p->closed)
        *hi = *lo + 2*LW_PI;
}

/* The least distance of all pins that turn and of the tracer, in poses between the stations. */
static double *forbidden(const lw_problem *p, const double *x, const lw_work *w, const lw_zone *z, double *g)
{
    double lo, hi, mode[LW_MODE_MAX];
    input_range(p, w, &lo, &hi);
    memcpy(mode, p->branch.mode, sizeof mode);
    for (int k = 0; k < POSES; k++) {
        lw_pose pose;
        double least = INFINITY;
        if (lw_problem_has_modes(p))
            mode[0] = w->mode[(size_t)k*p->n/POSES];
        bool there = lw_pose_solve(&p->plan, x, mode, lo + (hi - lo)*(k + 0.5)/POSES, 0, &pose) == LW_OK;
        for (int j = 0; there && j < LW_JOINT_MAX; j++)
            if (p->plan.joint_point[j] >= 0)
                least = fmin(least, outside(z, pose.joint[j][0]));
        for (int i = 0; there && i <= p->n_also; i++)
            least = fmin(least, outside(z, pose.tracer[i][0]));
        *g++ = there ? least : 0;                        /* closing is another condition            */
    }
    return g;
}

void lw_zone_conditions(const lw_problem *p, const double *x, lw_work *w, double *g)
{
    lw_vec2 at[LW_DIM_MAX + 1], turn = lw_v2_polar(1, x[p->plan.i_theta0]);
    int n = p->n_zone > 0 ? fixed_pivots(p, x, at) : 0;
    for (int k = 0; k < n; k++)
        at[k] = lw_v2_add(lw_v2(x[p->plan.i_x0], x[p->plan.i_y0]), lw_v2_turn(at[k], turn));
    for (int i = 0; i < p->n_zone; i++) {
        const lw_zone *z = &p->zone[i];
        g = forbids(z) ? forbidden(p, x, w, z, g) : pivot_conditions(z, at, n, g);
    }
}
