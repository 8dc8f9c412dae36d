/* optimise/problem/timing.c - find the input of each station when the timing is free: a monotone assignment to samples
 * of the curve by dynamic programming, then Newton steps along the curve. */
#include "optimise/problem/timing.h"

#include <assert.h>
#include <string.h>

#include "base/vector.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/variable_projection.h"

enum { M = LW_CURVE_SAMPLES };
static_assert((M & (M - 1)) == 0, "sample numbers wrap by a mask");

#define SMALL_MOVE 1e-13   /* a shorter move of an input [rad] is rounding: no secant is taken over it */

void lw_timing_sample(const lw_problem *p, const double *x, lw_work *w)
{
    lw_lanes in = { .n = M, .c = w->turn_c, .s = w->turn_s, .dim = x, .mode = p->intended.mode };
    bool modes = lw_problem_has_modes(p);
    lw_cycle_point at[M];
    if (!p->intended.turns)
        lw_circuit_points(p, w, M, w->turn, at);
    for (int j = 0; j < M && !p->intended.turns; j++) {
        w->turn_c[j] = at[j].c;
        w->turn_s[j] = at[j].s;
        if (modes)
            lw_circuit_put_mode(p, w, at[j].leg, w->turn_mode + j, M);
    }
    if (modes) {
        in.mode = w->turn_mode;
        in.mode_stride = M;
    }
    lw_batch_point(&p->plan, &in, 0, w->batch, w->curve_x, w->curve_y, w->curve_u, w->curve_v, w->curve_m);
    for (int i = 0; i < p->n_also; i++) {
        const lw_also_work *a = &w->also[i];
        lw_batch_point(&p->plan, &in, i + 1, w->batch, a->curve_x, a->curve_y, a->curve_u, a->curve_v, w->posture_m);
        for (int j = 0; j < M; j++)
            w->curve_m[j] = fmin(w->curve_m[j], w->posture_m[j]);
    }
}

/* The angle of the body at each sample. */
static void sample_angles(const double *u, const double *v, double tool, double *angle)
{
    for (int j = 0; j < M; j++)
        angle[j] = atan2(v[j], u[j]) + tool;
}

/* Add the cost of the angle at one station for each sample. */
static void add_angle_costs(const double *angle, double theta, double weight, double *c)
{
    for (int j = 0; j < M; j++) {
        double turn = angle[j] - theta;
        turn = fabs(turn) < LW_PI ? turn : remainder(turn, 2*LW_PI);
        c[j] += weight*turn*turn;
    }
}

/* Add the costs of a further point for each station and sample. */
static void add_costs(const lw_problem *p, const double *x, const lw_also_work *a, const lw_aim *aim, double *cost)
{
    double angle[M];
    if (aim->theta)
        sample_angles(a->curve_u, a->curve_v, x[aim->i_tool], angle);
    for (size_t i = 0; i < p->n; i++) {
        double wa = aim->wa[i]*aim->wa[i], wb = aim->wb[i]*aim->wb[i], *c = cost + i*LW_COST_ROW;
        for (int j = 0; aim->x && j < M; j++) {
            double dx = a->curve_x[j] - aim->x[i], dy = a->curve_y[j] - aim->y[i];
            c[j] += wa*(dx*dx + dy*dy);
        }
        if (aim->theta)
            add_angle_costs(angle, aim->theta[i], wb, c);
    }
}

/* The tangent of the curve at each sample, for a step to the next one, and 1 over its square; 0 where a neighbour does not close. */
static void tangents(const lw_work *w, double *tx, double *ty, double *per)
{
    for (int j = 0; j < M; j++) {
        int a = (j + M - 1) & (M - 1), b = (j + 1) & (M - 1);
        bool closes = w->curve_m[a] >= 0 && w->curve_m[b] >= 0;
        tx[j] = closes ? 0.5*(w->curve_x[b] - w->curve_x[a]) : 0;
        ty[j] = closes ? 0.5*(w->curve_y[b] - w->curve_y[a]) : 0;
        double t2 = tx[j]*tx[j] + ty[j]*ty[j];
        per[j] = t2 > 0 ? 1/t2 : 0;
    }
}

/* Cost of assigning station i to sample j.  On a path alone the piece of the curve half way to both neighbours stands for the sample:
 * beside a cusp, samples of one branch may be nearer to a station of the other one than those of its own. */
static void fill_costs(const lw_problem *p, const double *x, lw_work *w)
{
    double tx[M], ty[M], per[M], angle[M];
    const lw_samples of = { M, w->curve_x, w->curve_y, tx, ty, per, p->theta || p->n_also > 0 ? 0 : 0.5 };
    tangents(w, tx, ty, per);
    lw_batch_costs(&p->plan, &of, p->n, p->x, p->y, p->w, p->a, w->cost);
    if (p->theta)
        sample_angles(w->curve_u, w->curve_v, x[p->i_tool0], angle);
    for (size_t i = 0; p->theta && i < p->n; i++)
        add_angle_costs(angle, p->theta[i], p->w[i]*p->b, w->cost + i*LW_COST_ROW);
    for (int k = 0; k < p->n_also; k++)
        add_costs(p, x, &w->also[k], &p->also[k], w->cost);
    for (size_t i = 0; i < p->n; i++) {
        double *c = w->cost + i*LW_COST_ROW;
        for (int j = 0; j < M; j++)
            c[j] = w->curve_m[j] >= 0 ? c[j] : 1e30;
        memcpy(c + M, c, sizeof *c*(LW_COST_ROW - M));
    }
}

/* Cheapest increasing assignment with station 0 at sample `first`; order[] gets the number of steps after `first`.  INFINITY: it costs
 * `enough` or more. */
static double rising(const lw_problem *p, lw_work *w, int first, double enough, short *order)
{
    double f = lw_batch_in_order(&p->plan, p->n, M, w->cost, (size_t)first, p->intended.sense, enough, w->least);
    if (!(f < enough))
        return INFINITY;
    int at = M;
    for (size_t i = p->n; i-- > 0; order[i] = (short)at)
        for (const double *least = w->least + i*LW_COST_ROW; at > 0 && least[at - 1] == least[at]; )
            at--;
    return f;
}

/* Assign each station to its nearest sample, in any order. */
static void nearest(const lw_problem *p, lw_work *w)
{
    for (size_t i = 0; i < p->n; i++) {
        const double *c = w->cost + i*LW_COST_ROW;
        int best = 0;
        for (int j = 1; j < M; j++)
            if (c[j] < c[best])
                best = j;
        w->phase[i] = w->turn[best];
    }
}

/* Cheapest assignment in the direction of the input. Station 0 may start at the samples where its distance has a local
 * minimum; each start needs one dynamic programme. */
static bool monotone(const lw_problem *p, lw_work *w)
{
    int kept = -1;
    double least = 1e29;
    short *now = w->order, *keep = w->order + p->n;
    for (int j = 0; j < M; j++) {
        const double *c = w->cost;
        if (c[j] > c[(j + 1) & (M - 1)] || c[j] >= c[(j + M - 1) & (M - 1)])
            continue;
        double f = rising(p, w, j, least, now);
        if (f < least) {
            least = f;
            kept = j;
            memcpy(keep, now, p->n*sizeof *now);
        }
    }
    for (size_t i = 0; kept >= 0 && i < p->n; i++)
        w->phase[i] = w->turn[kept] + p->intended.sense*keep[i]*(2*LW_PI/M);
    return kept >= 0;
}

/* Move the inputs between samples: one Gauss-Newton step with the tangent from the differences to the neighbours. The
 * step ends before the middle of two samples, where a limit of the motion may be: there the tangent is 0/0. */
static void between_samples(const lw_problem *p, lw_work *w)
{
    const double width = 2*LW_PI/M;
    for (size_t i = 0; i < p->n; i++) {
        int j = (int)lrint((w->phase[i] - w->turn[0])/width) & (M - 1);
        int a = (j + M - 1) & (M - 1), b = (j + 1) & (M - 1);
        double tx = 0.5*(w->curve_x[b] - w->curve_x[a]), ty = 0.5*(w->curve_y[b] - w->curve_y[a]);
        double t2 = tx*tx + ty*ty;
        double s = tx*(p->x[i] - w->curve_x[j]) + ty*(p->y[i] - w->curve_y[j]);
        for (int k = 0; k < p->n_also; k++) {
            const lw_also_work *z = &w->also[k];
            const lw_aim *aim = &p->also[k];
            if (!aim->x)
                continue;
            tx = 0.5*(z->curve_x[b] - z->curve_x[a]);
            ty = 0.5*(z->curve_y[b] - z->curve_y[a]);
            t2 += tx*tx + ty*ty;
            s += tx*(aim->x[i] - z->curve_x[j]) + ty*(aim->y[i] - z->curve_y[j]);
        }
        w->try_theta[i] = 1;
        if (t2 > 0)
            w->phase[i] += width*lw_greater(-0.49, lw_lesser(0.49, s/t2));
    }
    if (p->timing == LW_TIMING_FREE)
        lw_timing_order(p, w->phase, w->try_theta, w->pool);
}

bool lw_timing_assign(const lw_problem *p, const double *x, lw_work *w)
{
    if (!lw_circuit_find(p, x, w))
        return false;
    lw_timing_sample(p, x, w);
    fill_costs(p, x, w);
    bool found = true;
    if (p->timing == LW_TIMING_NONE)
        nearest(p, w);
    else
        found = monotone(p, w);
    if (found)
        between_samples(p, w);
    if (p->timing == LW_TIMING_NONE)
        lw_timing_samples(p, w, w->curve_x, w->curve_y);
    return found;
}

/* Blocks of stations with the same input, in order: mean input, weight and number of stations. */
typedef struct blocks { double *mean, *mass, *size; size_t n; } blocks;

static void pool_blocks(const lw_problem *p, const double *theta, const double *weight, blocks *b)
{
    b->n = 0;
    for (size_t i = 0; i < p->n; i++) {
        size_t top = b->n++;
        b->mean[top] = p->intended.sense*theta[i];
        b->mass[top] = weight[i];
        b->size[top] = 1;
        for (; top > 0 && b->mean[top - 1] > b->mean[top]; top--, b->n--) {
            double m = b->mass[top - 1] + b->mass[top];
            b->mean[top - 1] = (b->mean[top - 1]*b->mass[top - 1] + b->mean[top]*b->mass[top])/m;
            b->mass[top - 1] = m;
            b->size[top - 1] += b->size[top];
        }
    }
}

/* If the blocks span more than a turn, merge the last with the first of the next turn, and with the blocks that the
 * merged one overlaps. */
static void pool_round_the_turn(blocks *b)
{
    size_t lo = 0, hi = b->n - 1;
    if (hi == 0 || b->mean[hi] - b->mean[lo] <= 2*LW_PI)
        return;
    double mass = b->mass[lo] + b->mass[hi];
    double mean = (b->mean[lo]*b->mass[lo] + (b->mean[hi] - 2*LW_PI)*b->mass[hi])/mass;
    while (lo + 1 < hi) {
        bool up = b->mean[lo + 1] < mean;
        if (!up && b->mean[hi - 1] <= mean + 2*LW_PI)
            break;
        size_t take = up ? ++lo : --hi;
        double at = b->mean[take] - (up ? 0 : 2*LW_PI);
        mean = (mean*mass + at*b->mass[take])/(mass + b->mass[take]);
        mass += b->mass[take];
    }
    for (size_t k = 0; k <= lo; k++)
        b->mean[k] = mean;
    for (size_t k = hi; k < b->n; k++)
        b->mean[k] = mean + 2*LW_PI;
}

void lw_timing_order(const lw_problem *p, double *theta, const double *weight, double *scratch)
{
    blocks b = { .mean = scratch, .mass = scratch + p->n, .size = scratch + 2*p->n };
    pool_blocks(p, theta, weight, &b);
    pool_round_the_turn(&b);
    for (size_t k = 0, i = 0; k < b.n; k++)
        for (double q = 0; q < b.size[k]; q++)
            theta[i++] = p->intended.sense*b.mean[k];
}

/* Take a Newton step of each station along the curve. The second derivative is a secant if there are two evaluations
 * and it is positive enough. */
static void propose(const lw_problem *p, lw_work *w, bool have_old)
{
    double *old = w->try_theta, *slope_old = old + w->ld, *curvature = old + 2*w->ld;
    double t[LW_PROBLEM_ROW_MAX];
    for (size_t k = 0; k < p->n; k++) {
        double t2 = lw_problem_tangent(p, w, k, t), slope = 0;
        for (int i = 0; i < w->n_row; i++)
            slope += t[i]*w->res[(size_t)i*w->ld + k];
        double bend = t2 + 1e-30;
        double moved = w->phase[k] - old[k];
        if (have_old && fabs(moved) > SMALL_MOVE) {
            double secant = (slope - slope_old[k])/moved;
            if (secant > 0.02*t2)
                bend = secant;
        }
        old[k] = w->phase[k];
        slope_old[k] = slope;
        curvature[k] = bend;
        w->phase[k] -= slope/bend;
    }
}

/* Limit the move of each station to `most`; returns the longest move. This comes after the ordering, because the mean of
 * shortened steps is no step of a block. */
static double shorten(const lw_problem *p, lw_work *w, double most)
{
    const double *old = w->try_theta;
    double longest = 0;
    for (size_t k = 0; k < p->n; k++) {
        double move = w->phase[k] - old[k];
        if (!(fabs(move) <= most))
            w->phase[k] = old[k] + copysign(most, move);
        longest = lw_greater(longest, lw_lesser(most, fabs(move)));
    }
    return longest;
}

bool lw_timing_refine(const lw_problem *p, const double *x, lw_work *w, int steps)
{
    /* An f this little above the least counts as equal: f is flat there, and a return to the inputs of the least would
     * keep only half of their digits. */
    const double rounding = 1e-9;
    double least = INFINITY, *kept = w->keep_theta, most = LW_TIMING_MOVE_MAX;
    int last = steps;
    bool careful = false, back = false;
    for (int i = 0;; i++) {
        if (!lw_problem_turn_stations(p, x, w) || !lw_problem_lanes(p, x, w))
            return false;
        double f = lw_problem_rows(p, x, w, false);
        bool worse = f > least*(1 + rounding);
        if (f <= least) {
            least = f;
            memcpy(kept, w->phase, p->n*sizeof *kept);
        }
        if (i >= last && (!worse || back))
            return true;
        if (worse && (careful || i >= last)) {
            /* Newton's method led to a worse extreme: try again from the best inputs, with shorter steps.  If that ends worse, too, take the
             * best inputs themselves; this happens once, because f of groups solved by continuation is not exactly reproducible. */
            memcpy(w->phase, kept, p->n*sizeof *kept);
            back = i >= last && careful;
            last = careful ? last : i + 1 + steps;
            careful = true;
            most *= 0.3;
            continue;
        }
        propose(p, w, i > 0);
        if (p->timing == LW_TIMING_FREE)
            lw_timing_order(p, w->phase, w->try_theta + 2*w->ld, w->pool);
        if (shorten(p, w, most) < 1e-12)
            last = i + 1;
    }
}

/* ---- both directions: curve to target ------------------------------------------------------- */

/* An open target corresponds to a part of the curve, from the first station's input to the last's on the side with more
 * stations. Samples outside this part do not count. */
static bool outside_piece(const lw_problem *p, const lw_work *w, int sample, double from, double span)
{
    if (p->closed || p->n < 2)
        return false;
    double at = remainder(w->turn[sample] - from, 2*LW_PI);
    if (span > 0)
        return !((at < 0 ? at + 2*LW_PI : at) <= span);
    return !((at > 0 ? at - 2*LW_PI : at) >= span);
}

static double covered_span(const lw_problem *p, const lw_work *w)
{
    double from = w->phase[0], rise = remainder(w->phase[p->n - 1] - from, 2*LW_PI);
    if (rise < 0)
        rise += 2*LW_PI;
    size_t inside = 0;
    for (size_t i = 1; i + 1 < p->n; i++) {
        double at = remainder(w->phase[i] - from, 2*LW_PI);
        inside += (at < 0 ? at + 2*LW_PI : at) <= rise;
    }
    return 2*inside + 2 >= p->n ? rise : rise - 2*LW_PI;
}

void lw_timing_samples(const lw_problem *p, lw_work *w, const double *x, const double *y)
{
    double total = 0, span = covered_span(p, w);
    for (size_t i = 0; i < p->n; i++)
        total += p->w[i];
    w->sample_weight = total/M;
    const lw_polyline polygon = { p->n, p->x, p->y, p->closed };
    lw_batch_nearest(&p->plan, &polygon, M, x, y, w->foot_x, w->foot_y);
    for (int j = 0; j < M; j++) {
        w->phase[p->n + (size_t)j] = w->turn[j];
        if (outside_piece(p, w, j, w->phase[0], span)) {
            w->foot_x[j] = x[j];
            w->foot_y[j] = y[j];
        }
    }
}
