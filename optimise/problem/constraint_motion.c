/* optimise/problem/constraint_motion.c - the postures in which conditions on the motion are checked, and how their inputs move with the
 * variables. */
#include "optimise/problem/constraint_internal.h"

#include <string.h>
#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/variable_projection.h"

bool lw_checked_is_whole(const lw_problem *p)
{
    return lw_problem_has_modes(p) ? p->closed || p->timing == LW_TIMING_NONE
                                   : p->intended.turns && (p->closed || p->must_turn);
}

/* Phase of the first posture of a whole circuit: with strokes of equal length no posture is at a limit, where it has no
 * derivative by the input. */
#define WHOLE_FROM 0.02

lw_checked_motion lw_checked_motion_of(const lw_problem *p, const lw_work *w)
{
    lw_checked_motion m = { .from = lw_problem_has_modes(p) ? WHOLE_FROM : 0, .length = 2*LW_PI, .moves = !lw_checked_is_whole(p) };
    if (!m.moves)
        return m;
    if (lw_problem_has_modes(p)) {
        m.end[1] = p->n - 1;
        m.from = w->phase[0];
        m.length = w->phase[p->n - 1] - m.from;
        return m;
    }
    for (size_t k = 1; k < p->n; k++) {
        if (w->input[k] < w->input[m.end[0]])
            m.end[0] = k;
        if (w->input[k] > w->input[m.end[1]])
            m.end[1] = k;
    }
    m.from = w->input[m.end[0]];
    m.length = w->input[m.end[1]] - m.from;
    return m;
}

void lw_checked_points(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, size_t n, const double *part, lw_cycle_point *at)
{
    double place[LW_CURVE_SAMPLES] = { 0 }, c[LW_CURVE_SAMPLES], s[LW_CURVE_SAMPLES] = { 0 };
    for (size_t i = 0; i < n; i++)
        c[i] = place[i] = m->from + m->length*part[i];
    if (lw_problem_has_modes(p)) {
        lw_circuit_points(p, w, n, place, at);
        return;
    }
    if (!p->plan.input_is_slider)
        lw_batch_turns(&p->plan, n, place, c, s);
    for (size_t i = 0; i < n; i++)
        at[i] = (lw_cycle_point){ .input = place[i], .rate = 1, .c = c[i], .s = s[i] };
}

double lw_problem_input_at(const lw_problem *p, const lw_work *w, double part, double *mode, int *leg)
{
    lw_checked_motion m = lw_checked_motion_of(p, w);
    lw_cycle_point at;
    lw_checked_points(p, w, &m, 1, &part, &at);
    memcpy(mode, p->intended.mode, sizeof p->intended.mode);
    if (lw_problem_has_modes(p))
        lw_circuit_put_mode(p, w, at.leg, mode, 1);
    *leg = at.leg;
    return at.input;
}

/* Add the gradient of half the squared residuals of station k at constant phase to g; return the derivative by the
 * phase. */
static double station_slopes(const lw_problem *p, const double *x, const lw_work *w, size_t k, double *g)
{
    bool limits_move = !w->swing.turning && w->rate[k] != 0;
    double by_phase = 0, drift[LW_DIM_MAX] = { 0 };
    for (int d = 0; limits_move && d < p->n_dim; d++)
        drift[d] = lw_circuit_drift(w, k, (size_t)d)/w->rate[k];
    for (int i = 0; i <= p->n_also; i++) {
        const lw_jacobian *j = lw_work_jac(w, i);
        lw_aim aim = lw_problem_aim(p, i);
        double wa = aim.x ? aim.wa[k]*aim.wa[k] : 0, wb = aim.theta ? aim.wb[k]*aim.wb[k] : 0;
        double rx = aim.x ? wa*(j->x[k] - aim.x[k]) : 0, ry = aim.x ? wa*(j->y[k] - aim.y[k]) : 0, rt = 0;
        if (aim.theta)
            rt = wb*remainder(atan2(j->v[k], j->u[k]) + x[aim.i_tool] - aim.theta[k], 2*LW_PI);
        double t = rx*j->tx[k] + ry*j->ty[k] + (aim.theta ? rt*j->tt[k] : 0);
        by_phase += t;
        for (int d = 0; d < p->n_dim; d++) {
            size_t at = (size_t)d*j->ld + k;
            g[d] += rx*j->jx[at] + ry*j->jy[at] + (aim.theta ? rt*j->jt[at] : 0) + t*drift[d];
        }
        if (aim.theta)
            g[aim.i_tool] += rt;
    }
    return by_phase;
}

/* Stations that the order keeps at the input of station k: the first of them, and their number. */
static size_t block_of(const lw_problem *p, const lw_work *w, size_t k, size_t *count)
{
    size_t first = k;
    *count = 1;
    while (*count < p->n && lw_timing_joined(p, w, (first + p->n - 1) % p->n)) {
        first = (first + p->n - 1) % p->n;
        ++*count;
    }
    for (size_t last = k; *count < p->n && lw_timing_joined(p, w, last); last = (last + 1) % p->n)
        ++*count;
    return first;
}

/* Derivatives of the phases of two stations by the variables.  In the best phase the derivative S of the station's
 * residuals by the phase is 0, so
 *     d phase/dx = - (dS/dx)/(dS/d phase),     dS/dx = d/d phase of the gradient at constant phase.
 * Derivatives by the phase are differences of fourth order of exact gradients. */
static void phase_slopes(const lw_problem *p, const double *x, lw_work *w, const size_t station[2], double by[2][LW_VAR_MAX])
{
    static const double part[4] = { 1, -8, 8, -1 };
    const double h = 1e-4;
    double *keep = w->best_theta, slope[2] = { 0, 0 };        /* keep_theta holds those before a trial step */
    memcpy(keep, w->phase, p->n*sizeof *keep);
    memset(by, 0, 2*sizeof *by);
    lw_circuit_slopes(p, x, w);
    size_t first[2], count[2];
    for (int e = 0; e < 2; e++)
        first[e] = block_of(p, w, station[e], &count[e]);
    for (int i = 0; i < 4; i++) {
        for (size_t k = 0; k < p->n; k++)
            w->phase[k] = keep[k] + h*(i < 2 ? i - 2 : i - 1);
        lw_circuit_lanes(p, w, p->n);
        lw_problem_lanes(p, x, w);
        for (int e = 0; e < 2; e++)
            for (size_t q = 0; q < count[e]; q++) {
                double g[LW_VAR_MAX] = { 0 };
                slope[e] += part[i]*station_slopes(p, x, w, (first[e] + q) % p->n, g);
                for (int d = 0; d < p->n_var; d++)
                    by[e][d] += part[i]*g[d];
            }
    }
    for (int e = 0; e < 2; e++)
        for (int d = 0; d < p->n_var; d++)
            by[e][d] = slope[e] > 0 ? -by[e][d]/slope[e] : 0;
    memcpy(w->phase, keep, p->n*sizeof *keep);
    lw_circuit_lanes(p, w, p->n);
    lw_problem_lanes(p, x, w);
}

void lw_checked_end_slopes(const lw_problem *p, const double *x, lw_work *w, lw_checked_motion *m)
{
    memset(m->by, 0, sizeof m->by);
    if (!m->moves)
        return;
    if (p->timing == LW_TIMING_PRESCRIBED) {
        for (int e = 0; e < 2; e++) {
            m->by[e][p->i_input0] = 1;
            if (p->datum == LW_DATUM_PLANE)
                m->by[e][p->plan.i_theta0] = -1.0/p->plan.input_turns_per_period;
        }
        return;
    }
    phase_slopes(p, x, w, m->end, m->by);
    for (int e = 0; e < 2 && !lw_problem_has_modes(p); e++)       /* of the inputs instead */
        for (int d = 0; d < p->n_var; d++) {
            m->by[e][d] *= w->rate[m->end[e]];
            if (!w->swing.turning && d < p->n_dim)
                m->by[e][d] += lw_circuit_drift(w, m->end[e], (size_t)d);
        }
}

double lw_checked_input_slope(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, const lw_cycle_point *at, double part, int d)
{
    double by = m->by[0][d] + part*(m->by[1][d] - m->by[0][d]);
    if (!lw_problem_has_modes(p) || w->swing.turning)
        return by;
    return at->rate*by + (d < p->n_dim ? lw_circuit_drift_at(w, at, (size_t)d) : 0);
}

bool lw_checked_inputs_move(const lw_problem *p, const lw_work *w, const lw_checked_motion *m)
{
    return m->moves || (lw_problem_has_modes(p) && !w->swing.turning);
}

void lw_checked_sample_motion(const lw_problem *p, lw_work *w, const lw_checked_motion *m, size_t n)
{
    double part[LW_CURVE_SAMPLES] = { 0 };
    for (size_t i = 0; i < n; i++)
        part[i] = (double)i/(double)(n - 1);
    lw_checked_points(p, w, m, n, part, w->check_at);
    for (size_t i = 0; i < n; i++) {
        w->check_c[i] = w->check_at[i].c;
        w->check_s[i] = w->check_at[i].s;
    }
}

void lw_checked_sample(const lw_problem *p, lw_work *w, const lw_checked_motion *m, size_t n)
{
    if (!p->intended.turns) {
        lw_checked_sample_motion(p, w, m, n);
        return;
    }
    for (size_t i = 0; i < n; i++) {
        size_t k = i*(LW_CURVE_SAMPLES/n);
        w->check_at[i] = (lw_cycle_point){ .c = w->turn_c[k], .s = w->turn_s[k], .input = w->turn[k], .rate = 1 };
        w->check_c[i] = w->turn_c[k];
        w->check_s[i] = w->turn_s[k];
    }
}

void lw_checked_jacobians(const lw_problem *p, const double *x, lw_work *w, int n_which, const int *which, const double *c,
                      const double *s, size_t n, const lw_jacobian *out)
{
    bool modes = lw_problem_has_modes(p);
    for (size_t first = 0, next; first < n; first = next) {
        lw_jacobian part[LW_PLACE_MAX];
        for (next = modes ? first + 1 : n; next < n && w->check_at[next].leg == w->check_at[first].leg; next++)
            ;
        for (int k = 0; k < n_which; k++) {
            lw_jacobian *j = &part[k];
            *j = out[k];
            double **each[] = { &j->x, &j->y, &j->u, &j->v, &j->margin, &j->jx, &j->jy, &j->jt, &j->tx, &j->ty, &j->tt,
                                &j->jm, &j->tm };
            for (size_t i = 0; i < sizeof each/sizeof *each; i++)
                if (*each[i])
                    *each[i] += first;
        }
        lw_lanes in = { .n = next - first, .c = c + first, .s = s + first, .dim = x, .mode = p->intended.mode };
        if (modes)
            in.mode = w->swing.stroke[w->check_at[first].leg].mode;
        lw_batch_jacobians(&p->plan, &in, n_which, which, w->batch, part);
    }
}

void lw_checked_jacobian(const lw_problem *p, const double *x, lw_work *w, int which, const double *c, const double *s,
                     size_t n, const lw_jacobian *out)
{
    lw_checked_jacobians(p, x, w, 1, &which, c, s, n, out);
}

bool lw_checked_changes(const lw_problem *p, const lw_work *w, size_t k)
{
    return lw_problem_has_modes(p) && k + 1 < LW_CURVE_SAMPLES && w->check_at[k].leg != w->check_at[k + 1].leg;
}

/* ---- which rows of derivatives are needed ---------------------------------------------------------------------- */

/* Is condition k of n along the motion the least around or beside it?  The others follow it. */
static bool is_near_least(const double *g, size_t k, size_t n)
{
    for (size_t i = k > 0 ? k - 1 : 0; i <= k + 1 && i < n; i++)
        if ((i == 0 || g[i - 1] >= g[i]) && (i + 1 == n || g[i + 1] >= g[i]))
            return true;
    return false;
}

size_t lw_rows_choose(double *g, size_t n, double enough, size_t *row)
{
    size_t needed = 0;
    for (size_t k = 0; k < n; k++)
        if (!isfinite(enough) || (!(g[k] > enough) && is_near_least(g, k, n)))
            row[needed++] = k;
    for (size_t k = 0, i = 0; k < n; k++)
        if (i < needed && row[i] == k)
            i++;
        else
            g[k] = INFINITY;
    return needed;
}

size_t lw_rows_keep(const lw_problem *p, lw_work *w, double *g, size_t n, double enough, const size_t *from,
                    double *place, size_t *row, double *j)
{
    size_t kept = 0, needed = lw_rows_choose(g, n, enough, row);
    for (size_t i = 0; i < needed; i++) {
        size_t k = row[i], at = from[k];
        if (at == LW_CURVE_SAMPLES) {
            memset(j + k*(size_t)p->n_var, 0, sizeof *j*(size_t)p->n_var);
            continue;
        }
        w->check_at[kept] = w->check_at[at];
        w->check_c[kept] = w->check_c[at];
        w->check_s[kept] = w->check_s[at];
        place[kept] = place[at];
        row[kept++] = k;
    }
    return kept;
}

void lw_row_put(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, double part, const lw_cycle_point *at,
                const double *slope, size_t k, double *row)
{
    double by_input = slope[(size_t)p->n_dim*w->posture.ld + k];
    for (int d = 0; d < p->n_var; d++)
        row[d] = d < p->n_dim ? slope[(size_t)d*w->posture.ld + k] : 0;
    for (int d = 0; d < p->n_var && lw_checked_inputs_move(p, w, m); d++)
        row[d] += by_input*lw_checked_input_slope(p, w, m, at, part, d);
}
