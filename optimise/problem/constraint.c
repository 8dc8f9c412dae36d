/* optimise/problem/constraint.c - the conditions g(x) >= 0 of a fitting problem, with their derivatives.
 *
 * A condition on the motion is checked in sampled postures.  Its derivative has two parts: by the dimensions at
 * constant input, from the plan's adjoints, and by the input of the posture, which moves with the variables where the
 * ends of the motion do. */
#include "optimise/problem/constraint.h"

#include <string.h>

#include "base/vector.h"
#include "mbs/batch/posture.h"
#include "optimise/problem/circuit.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/timing.h"
#include "optimise/problem/variable_projection.h"

/* Conditions on the motion are checked in LW_CURVE_SAMPLES postures: over the turn if the input turns fully, else from the
 * first station to the last. Extremes between the samples are searched for. */
enum {
    POSTURES = LW_CURVE_SAMPLES,
    ZONE_POSTURES = LW_ZONE_SAMPLES + 1
};

static void linear(const lw_problem *p, const double *x, double *g)
{
    for (int j = 0; j < p->n_linear; j++) {
        g[j] = -LW_LINEAR_LEAST;
        for (int v = 0; v < p->n_var; v++)
            g[j] += p->linear[j][v]*x[v];
    }
}

/* ---- the motion that is checked ------------------------------------------------------------------------------ */

/* Postures from `from` on over `length`: phases of the circuit if the stations have modes of their own, else inputs.
 * moves: these depend on the variables, with the derivatives by[0] of `from` and by[1] of from + length. */
typedef struct motion {
    double from, length;
    size_t end[2];                    /* stations at the two ends                                           */
    bool   moves;
    double by[2][LW_VAR_MAX];
} motion;

/* Is the motion the whole circuit or turn, wherever the stations are? */
static bool is_whole(const lw_problem *p)
{
    return lw_problem_has_modes(p) ? p->closed || p->timing == LW_TIMING_NONE
                                   : p->intended.turns && (p->closed || p->must_turn);
}

/* Phase of the first posture of a whole circuit: with strokes of equal length no posture is at a limit, where it has no
 * derivative by the input. */
#define WHOLE_FROM 0.02

/* The motion between the stations, whose phases and inputs are in w. */
static motion motion_of(const lw_problem *p, const lw_work *w)
{
    motion m = { .from = lw_problem_has_modes(p) ? WHOLE_FROM : 0, .length = 2*LW_PI, .moves = !is_whole(p) };
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

/* The points at n <= POSTURES parts of the motion. */
static void points_at(const lw_problem *p, const lw_work *w, const motion *m, size_t n, const double *part, lw_cycle_point *at)
{
    double place[POSTURES] = { 0 }, c[POSTURES], s[POSTURES] = { 0 };
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
    motion m = motion_of(p, w);
    lw_cycle_point at;
    points_at(p, w, &m, 1, &part, &at);
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

/* Set the derivatives of the ends of the motion. */
static void end_slopes(const lw_problem *p, const double *x, lw_work *w, motion *m)
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

/* Derivative of the input of the posture `at`, which is at `part` of the motion, by variable d. */
static double input_slope(const lw_problem *p, const lw_work *w, const motion *m, const lw_cycle_point *at, double part, int d)
{
    double by = m->by[0][d] + part*(m->by[1][d] - m->by[0][d]);
    if (!lw_problem_has_modes(p) || w->swing.turning)
        return by;
    return at->rate*by + (d < p->n_dim ? lw_circuit_drift_at(w, at, (size_t)d) : 0);
}

/* Do the inputs of the postures depend on the variables? */
static bool inputs_move(const lw_problem *p, const lw_work *w, const motion *m)
{
    return m->moves || (lw_problem_has_modes(p) && !w->swing.turning);
}

/* Set w->check_at, check_c and check_s to n postures of the motion. */
static void sample_motion(const lw_problem *p, lw_work *w, const motion *m, size_t n)
{
    double part[POSTURES] = { 0 };
    for (size_t i = 0; i < n; i++)
        part[i] = (double)i/(double)(n - 1);
    points_at(p, w, m, n, part, w->check_at);
    for (size_t i = 0; i < n; i++) {
        w->check_c[i] = w->check_at[i].c;
        w->check_s[i] = w->check_at[i].s;
    }
}

/* The same, or n postures of the turn, of which there are POSTURES. */
static void sample(const lw_problem *p, lw_work *w, const motion *m, size_t n)
{
    if (!p->intended.turns) {
        sample_motion(p, w, m, n);
        return;
    }
    for (size_t i = 0; i < n; i++) {
        size_t k = i*(POSTURES/n);
        w->check_at[i] = (lw_cycle_point){ .c = w->turn_c[k], .s = w->turn_s[k], .input = w->turn[k], .rate = 1 };
        w->check_c[i] = w->turn_c[k];
        w->check_s[i] = w->turn_s[k];
    }
}

/* lw_batch_jacobian of n postures of check_at at the inputs c, s, one run on the same stroke after the other. */
static void jacobians(const lw_problem *p, const double *x, lw_work *w, int n_which, const int *which, const double *c,
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

static void jacobian(const lw_problem *p, const double *x, lw_work *w, int which, const double *c, const double *s,
                     size_t n, const lw_jacobian *out)
{
    jacobians(p, x, w, 1, &which, c, s, n, out);
}

/* Does the motion pass a limit on the way to the next sample? */
static bool changes(const lw_problem *p, const lw_work *w, size_t k)
{
    return lw_problem_has_modes(p) && k + 1 < POSTURES && w->check_at[k].leg != w->check_at[k + 1].leg;
}

/* ---- which rows of derivatives are needed ---------------------------------------------------------------------- */

#define ALL_ROWS INFINITY            /* as `enough`: every row is needed */

/* Is condition k of n along the motion the least around or beside it?  The others follow it. */
static bool is_near_least(const double *g, size_t k, size_t n)
{
    for (size_t i = k > 0 ? k - 1 : 0; i <= k + 1 && i < n; i++)
        if ((i == 0 || g[i - 1] >= g[i]) && (i + 1 == n || g[i + 1] >= g[i]))
            return true;
    return false;
}

/* Set `row` to the numbers of the rows that are needed of n conditions along the motion, and the other conditions to
 * INFINITY.  Returns how many are needed. */
static size_t choose_rows(double *g, size_t n, double enough, size_t *row)
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

/* Move the postures of the needed rows to the front.  from[k]: the posture of condition k, or POSTURES if it is constant, and
 * its row 0.  Returns the number of postures; row[i] belongs to the i-th, which is at place[i]. */
static size_t keep_needed(const lw_problem *p, lw_work *w, double *g, size_t n, double enough, const size_t *from,
                          double *place, size_t *row, double *j)
{
    size_t kept = 0, needed = choose_rows(g, n, enough, row);
    for (size_t i = 0; i < needed; i++) {
        size_t k = row[i], at = from[k];
        if (at == POSTURES) {
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

/* One row of derivatives: those by the dimensions and by the input are column k of `slope`. */
static void put_row(const lw_problem *p, const lw_work *w, const motion *m, double part, const lw_cycle_point *at,
                    const double *slope, size_t k, double *row)
{
    double by_input = slope[(size_t)p->n_dim*w->posture.ld + k];
    for (int d = 0; d < p->n_var; d++)
        row[d] = d < p->n_dim ? slope[(size_t)d*w->posture.ld + k] : 0;
    for (int d = 0; d < p->n_var && inputs_move(p, w, m); d++)
        row[d] += by_input*input_slope(p, w, m, at, part, d);
}

/* ---- margins and accelerations -------------------------------------------------------------------------------- */

static void margins_at(const lw_problem *p, const double *x, lw_work *w, const double *c, const double *s, size_t n,
                       double *margin, double *slope);

#define DIFFERENCE 2e-7             /* step of differences, of sizes and angles */

/* Set the slopes of margins that belong to a higher group, which are not known, by central differences; `slope` is as margins_at has
 * it. */
static void higher_slopes(const lw_problem *p, const double *x, lw_work *w, const double *c, const double *s, size_t n, double *slope)
{
    size_t ld = w->posture.ld, rows = (size_t)p->n_dim;
    double at[LW_VAR_MAX], value[2][POSTURES], by_c[POSTURES], by_s[POSTURES];
    memcpy(at, x, sizeof *at*(size_t)p->n_var);
    for (size_t first = 0, m; first < n; first += m) {
        m = n - first < POSTURES ? n - first : POSTURES;
        for (size_t d = 0; d <= rows; d++) {
            double *of = slope + d*ld + first, h = d < rows ? DIFFERENCE*fmax(1, fabs(x[d])) : DIFFERENCE;
            bool any = false;
            for (size_t k = 0; k < m; k++)
                any |= isnan(of[k]);
            for (int side = 0; side < 2 && any; side++) {
                double by = side ? h : -h, turn_c = cos(by), turn_s = sin(by);
                memcpy(by_c, c + first, sizeof *c*m);
                memcpy(by_s, s + first, sizeof *s*m);
                for (size_t k = 0; k < m && d == rows; k++) {
                    bool slides = p->plan.input_is_slider;
                    by_c[k] = slides ? c[first + k] + by : c[first + k]*turn_c - s[first + k]*turn_s;
                    by_s[k] = slides ? s[first + k] : s[first + k]*turn_c + c[first + k]*turn_s;
                }
                if (d < rows)
                    at[d] = x[d] + by;
                margins_at(p, at, w, by_c, by_s, m, value[side], NULL);
                if (d < rows)
                    at[d] = x[d];
            }
            for (size_t k = 0; k < m && any; k++)
                of[k] = isnan(of[k]) ? (value[1][k] - value[0][k])/(2*h) : of[k];
        }
    }
}

/* Least margin over all outputs of n postures at c, s; with `slope` its derivatives. */
static void margins_at(const lw_problem *p, const double *x, lw_work *w, const double *c, const double *s, size_t n,
                       double *margin, double *slope)
{
    size_t ld = w->posture.ld, rows = (size_t)p->n_dim;
    for (int i = 0; i <= p->n_also; i++) {
        double *to = i == 0 ? slope : slope ? w->slope[1] : NULL;
        lw_jacobian j = { .x = w->posture_x, .y = w->posture_y, .margin = i == 0 ? margin : w->posture_m, .ld = ld,
                          .jm = to, .tm = to ? to + rows*ld : NULL };
        jacobian(p, x, w, i, c, s, n, &j);
        for (size_t k = 0; i > 0 && k < n; k++) {
            if (!(w->posture_m[k] < margin[k]))
                continue;
            margin[k] = w->posture_m[k];
            for (size_t d = 0; slope && d <= rows; d++)
                slope[d*ld + k] = to[d*ld + k];
        }
    }
    if (slope && p->plan.n_higher > 0)
        higher_slopes(p, x, w, c, s, n, slope);
}

/* 1 - |P''|^2 / limit^2. P'' is the difference of exact tangents 1e-4 rad apart (error 1e-8). For a function it is that
 * of the output angle psi: the tracer has distance one from the output's pin, so |P''|^2 = psi''^2 + |P'|^4. */
typedef struct acceleration { double x, y, vx, vy; } acceleration;

/* Set the inputs of the scratch's postures from number `first` on to those of n samples, shifted by `by`. */
static void shift_inputs(const lw_problem *p, lw_work *w, size_t n, double by, size_t first)
{
    double cb, sb, *to_c = w->posture_c + first, *to_s = w->posture_s + first;
    sincos(by, &sb, &cb);
    for (size_t k = 0; k < n; k++) {
        double c = w->check_c[k], s = w->check_s[k];
        to_c[k] = p->plan.input_is_slider ? c + by : cb*c - sb*s;
        to_s[k] = p->plan.input_is_slider ? 0 : sb*c + cb*s;
    }
}

/* Tangents of n of the scratch's postures, and on request their Jacobian. */
static void tangents(const lw_problem *p, const double *x, lw_work *w, size_t n, bool with_jacobian, double *tx, double *ty)
{
    lw_jacobian j = w->posture;
    j.tx = tx;
    j.ty = ty;
    if (!with_jacobian)
        j.jx = j.jy = NULL;
    jacobian(p, x, w, 0, w->posture_c, w->posture_s, n, &j);
}

/* n, or the next multiple of eight where all postures have one assembly mode: whole groups are computed faster. */
static size_t whole_groups(const lw_problem *p, size_t n) { return lw_problem_has_modes(p) ? n : (n + 7) & ~(size_t)7; }

static double acceleration_condition(const lw_problem *p, const acceleration *a)
{
    double turn2 = !lw_task_has_place(p->task) ? pow(a->vx*a->vx + a->vy*a->vy, 2) : 0;
    return 1 - (a->x*a->x + a->y*a->y - turn2)/(p->max_acceleration*p->max_acceleration);
}

/* Derivatives of P' and P'' by dimensions and input: central differences by the input of the exact Jacobian.
 * w->slope[0 .. 3] become those of P'' (x, y) and of P' (x, y). */
static void acceleration_slopes(const lw_problem *p, const double *x, lw_work *w, size_t n)
{
    const double h = 2e-4;
    size_t ld = w->posture.ld, rows = (size_t)p->n_dim + 1;
    int parts = lw_task_has_place(p->task) ? 2 : 4;          /* a path needs P'' alone                 */
    for (int i = 0; i < parts; i++)
        memset(w->slope[i], 0, sizeof(double)*rows*ld);
    for (int i = -1; i <= 1; i++) {
        double a = (i == 0 ? -2 : 1)/(h*h), v = i/(2*h);
        shift_inputs(p, w, whole_groups(p, n), i*h, 0);
        tangents(p, x, w, whole_groups(p, n), true, w->posture_u, w->posture_v);
        for (size_t d = 0; d < rows; d++)
            for (int part = 0; part < parts; part++) {
                const double *restrict from = part % 2 == 0 ? (d + 1 < rows ? w->posture.jx + d*ld : w->posture_u)
                                                            : (d + 1 < rows ? w->posture.jy + d*ld : w->posture_v);
                double *restrict to = w->slope[part] + d*ld, by = part < 2 ? a : v;
                for (size_t k = 0; k < n; k++)
                    to[k] += by*from[k];
            }
    }
}

/* P' and P'' of n postures, and their conditions. */
static void find_accelerations(const lw_problem *p, const double *x, lw_work *w, size_t n, acceleration *of, double *g)
{
    const double h = 1e-4;
    size_t lanes = whole_groups(p, n);
    bool at_once = !lw_problem_has_modes(p) && 2*lanes <= POSTURES;
    const double *ux = w->posture_u, *uy = w->posture_v;
    shift_inputs(p, w, lanes, +h, 0);
    if (at_once) {
        shift_inputs(p, w, lanes, -h, lanes);
        ux = w->posture_x + lanes;
        uy = w->posture_y + lanes;
    }
    tangents(p, x, w, at_once ? 2*lanes : lanes, false, w->posture_x, w->posture_y);
    if (!at_once) {
        shift_inputs(p, w, lanes, -h, 0);
        tangents(p, x, w, lanes, false, w->posture_u, w->posture_v);
    }
    for (size_t k = 0; k < n; k++) {
        double vx = w->posture_x[k], vy = w->posture_y[k];
        of[k] = (acceleration){ (vx - ux[k])/(2*h), (vy - uy[k])/(2*h), 0.5*(vx + ux[k]), 0.5*(vy + uy[k]) };
        g[k] = acceleration_condition(p, &of[k]);
    }
}

static void acceleration_conditions(const lw_problem *p, const double *x, lw_work *w, size_t n, double *g)
{
    acceleration of[POSTURES];
    find_accelerations(p, x, w, n, of, g);
}

/* A condition in n postures of check_c, check_s. */
typedef void condition(const lw_problem *p, const double *x, lw_work *w, size_t n, double *g);

/* Move the postures from number `first` on to n places, counted in samples of the motion. */
static void move_postures(const lw_problem *p, lw_work *w, const motion *m, size_t first, size_t n, const double *place)
{
    static const motion turn = { .length = 2*LW_PI };
    double part[POSTURES] = { 0 };
    lw_cycle_point at[POSTURES];
    for (size_t i = 0; i < n; i++)
        part[i] = p->intended.turns ? place[i]/POSTURES : fmin(fmax(place[i]/(POSTURES - 1), 0), 1);
    points_at(p, w, p->intended.turns ? &turn : m, n, part, at);
    for (size_t i = 0; i < n; i++) {
        w->check_at[first + i] = at[i];
        w->check_c[first + i] = at[i].c;
        w->check_s[first + i] = at[i].s;
    }
}

/* Move posture q*i + k to best[i] + h*net[k], for each of n places. */
static void spread_net(const lw_problem *p, lw_work *w, const motion *m, size_t n, const double *best, double h,
                       size_t q, const double *net)
{
    double place[POSTURES] = { 0 };
    for (size_t i = 0; i < n*q; i++)
        place[i] = best[i/q] + h*net[i % q];
    move_postures(p, w, m, 0, n*q, place);
}

/* Vertex of the parabola through the values before, now, after at -1, 0, 1; *least: its value. */
static double vertex(double before, double now, double after, double *least)
{
    double bend = before + after - 2*now, at = bend > 0 ? fmin(fmax(0.5*(before - after)/bend, -2), 2) : 0;
    *least = now + at*(0.5*(after - before) + 0.5*bend*at);
    return at;
}

/* How far from sample k, which is less than both neighbours, its extreme may lie on one side, 1 or -1, in samples: as far as the
 * neighbour, or half a sample farther, where samples that rise may hide another extreme before the next limit. */
static double reach(const lw_problem *p, const lw_work *w, const double *g, size_t k, int side)
{
    size_t next = (k + (size_t)(POSTURES + side)) % POSTURES, beyond = (next + (size_t)(POSTURES + side)) % POSTURES;
    bool ends = !p->intended.turns && (next == 0 || next == POSTURES - 1);
    return ends || changes(p, w, side > 0 ? next : beyond) || !(g[beyond] > g[next]) ? 1 : 1.5;
}

/* Is sample k less than both neighbours? */
static bool is_low(const double *g, size_t k, bool round)
{
    bool inside = round || (k > 0 && k < POSTURES - 1);
    return inside && g[k] < g[(k + POSTURES - 1) % POSTURES] && g[k] <= g[(k + 1) % POSTURES];
}

/* May an extreme be hidden beside sample k: do the samples fall on from it by less than a third of what they fell by before?  The margin is the
 * least of several groups: beyond the extreme of one, another one goes on to fall. */
static bool falls_on(const double *g, size_t k, bool round)
{
    size_t before = (k + POSTURES - 1) % POSTURES, after = (k + 1) % POSTURES;
    double left = g[before] - g[k], right = g[after] - g[k];
    return (right < 0 && left > -3*right && !is_low(g, after, round)) || (left <= 0 && right > -3*left && !is_low(g, before, round));
}

/* Move each sample beside which an extreme may lie to the least extreme within 1.5 samples, whose value g becomes: two nets,
 * each of a quarter of the spacing before, then parabolas.  The posture of sample k is then at place[k].  Only the
 * least of many; not those that would stay above `enough` if the bend of the three samples went on. */
static void seek_extremes(const lw_problem *p, const double *x, lw_work *w, const motion *m, condition *of,
                          double enough, double *g, double *place)
{
    enum { NET = 10, MOST = POSTURES/NET };
    size_t at[MOST], n = 0;
    double best[MOST], lo[MOST], hi[MOST], value[POSTURES];
    bool round = p->intended.turns;
    for (size_t k = 0; k < POSTURES; k++)
        place[k] = (double)k;
    for (size_t hidden = 0, first = 0; hidden < 2; hidden++, first = n)       /* hidden ones only where there is room for them */
        for (size_t k = round ? 0 : 1; k < (round ? POSTURES : POSTURES - 1); k++) {
            double before = g[(k + POSTURES - 1) % POSTURES], after = g[(k + 1) % POSTURES];
            if (!(hidden ? falls_on(g, k, round) : is_low(g, k, round)) || g[k] - (before + after - 2*g[k]) > enough
                || (k > 0 && changes(p, w, k - 1)) || changes(p, w, k))
                continue;
            size_t i = n < MOST ? n++ : n;
            for (; i > first && g[at[i - 1]] > g[k]; i--)
                if (i < MOST)
                    at[i] = at[i - 1];
            if (i < MOST)
                at[i] = k;
        }
    if (n == 0)
        return;
    lw_cycle_point sample[NET*MOST];
    memcpy(sample, w->check_at, sizeof *sample*NET*n);
    for (size_t i = 0; i < n; i++) {
        best[i] = (double)at[i];
        lo[i] = best[i] - reach(p, w, g, at[i], -1);
        hi[i] = best[i] + reach(p, w, g, at[i], 1);
    }
    for (double h = 0.25; h > 0.01; h *= 0.25) {
        static const double net[NET] = { -6, -5, -3, -2, -1, 1, 2, 3, 5, 6 };
        spread_net(p, w, m, n, best, h, NET, net);
        of(p, x, w, NET*n, value);
        for (size_t i = 0; i < n; i++) {
            double from = best[i];
            for (size_t q = NET*i; q < NET*(i + 1); q++) {
                double now = from + h*net[q % NET];
                if (value[q] < g[at[i]] && now >= lo[i] && now <= hi[i]) {
                    g[at[i]] = value[q];
                    best[i] = now;
                }
            }
        }
    }
    for (double h = 1.0/16; h > 5e-4; h *= 0.2) {
        spread_net(p, w, m, n, best, h, 3, (const double[]){ -1, 0, 1 });
        of(p, x, w, 3*n, value);
        for (size_t i = 0; i < n; i++)
            best[i] += h*vertex(value[3*i], value[3*i + 1], value[3*i + 2], &g[at[i]]);
    }
    memcpy(w->check_at, sample, sizeof *sample*NET*n);
    for (size_t k = 0; k < NET*n; k++) {
        w->check_c[k] = sample[k].c;
        w->check_s[k] = sample[k].s;
    }
    for (size_t i = 0; i < n; i++) {
        place[at[i]] = best[i];
        move_postures(p, w, m, at[i], 1, &best[i]);
    }
}

/* Where the motion passes a limit, both conditions beside it are the lesser one, and at most `most`.  from: as
 * keep_needed has it; a condition held at `most` has no posture. */
static void lower_changes(const lw_problem *p, const lw_work *w, double most, double *g, size_t *from)
{
    for (size_t k = 0; k < POSTURES; k++)
        from[k] = k;
    for (size_t k = 0; k < POSTURES; k++) {
        if (!changes(p, w, k))
            continue;
        size_t least = g[k] < g[k + 1] ? k : k + 1;
        from[k] = from[k + 1] = g[least] < most ? from[least] : POSTURES;
        g[k] = g[k + 1] = fmin(most, g[least]);
    }
}

/* The rows of the postures that were kept of n, from the derivatives in `slope`. */
static void put_rows(const lw_problem *p, const lw_work *w, const motion *m, size_t n, size_t kept, const size_t *row,
                     const double *place, const double *slope, double *j)
{
    for (size_t k = 0; k < kept; k++)
        put_row(p, w, m, place[k]/(double)(n - 1), &w->check_at[k], slope, k, j + row[k]*(size_t)p->n_var);
}

static void margins(const lw_problem *p, const double *x, lw_work *w, size_t n, double *g)
{
    margins_at(p, x, w, w->check_c, w->check_s, n, g, NULL);
}

/* Needs the inputs of the sampled postures. */
static void transmissions(const lw_problem *p, const double *x, lw_work *w, const motion *m, double enough, double *g, double *j)
{
    double sine = sin(p->min_transmission), place[POSTURES], unused[POSTURES];
    size_t n = lw_problem_transmission_postures(p), from[POSTURES], row[POSTURES];
    margins(p, x, w, n, g);
    if (n == POSTURES) {                                      /* else the postures are those of the extremes */
        seek_extremes(p, x, w, m, margins, enough + sine*sine, g, place);
        lower_changes(p, w, 0, g, from);
    }
    for (size_t k = 0; k < n && n < POSTURES; k++)
        place[from[k] = k] = (double)k;
    for (size_t k = 0; k < n; k++)
        g[k] -= sine*sine;
    if (!j)
        return;
    size_t kept = keep_needed(p, w, g, n, enough, from, place, row, j);
    margins_at(p, x, w, w->check_c, w->check_s, kept, unused, w->slope[0]);
    put_rows(p, w, m, n, kept, row, place, w->slope[0], j);
}

#define FAR_FROM_LIMIT 0.5          /* |P''| below 0.7 of its limit: peaks between samples do not matter  */

/* The same for accelerations. */
static void accelerations(const lw_problem *p, const double *x, lw_work *w, const motion *m, double enough, double *g, double *j)
{
    const double scale = 2/(p->max_acceleration*p->max_acceleration);
    acceleration a[POSTURES];
    double place[POSTURES], unused[POSTURES];
    size_t from[POSTURES], row[POSTURES];
    acceleration_conditions(p, x, w, POSTURES, g);
    seek_extremes(p, x, w, m, acceleration_conditions, FAR_FROM_LIMIT, g, place);
    lower_changes(p, w, -1, g, from);                       /* at a dead point it is unbounded */
    if (!j)
        return;
    size_t kept = keep_needed(p, w, g, POSTURES, enough, from, place, row, j);
    find_accelerations(p, x, w, kept, a, unused);
    acceleration_slopes(p, x, w, kept);
    for (size_t d = 0; d <= (size_t)p->n_dim; d++)
        for (size_t k = 0; k < kept; k++) {
            size_t at = d*w->posture.ld + k;
            double v2 = !lw_task_has_place(p->task) ? 2*(a[k].vx*a[k].vx + a[k].vy*a[k].vy) : 0;
            w->slope[0][at] = -scale*(a[k].x*w->slope[0][at] + a[k].y*w->slope[1][at]
                                      - v2*(a[k].vx*w->slope[2][at] + a[k].vy*w->slope[3][at]));
        }
    put_rows(p, w, m, POSTURES, kept, row, place, w->slope[0], j);
}

static void closure(const lw_problem *p, const double *x, lw_work *w, double *g, double *j)
{
    double *slope = j ? w->slope[0] : NULL;
    size_t ld = w->posture.ld, nv = (size_t)p->n_var;
    margins_at(p, x, w, w->c, w->s, p->n, g, slope);
    for (size_t k = 0; j && k < p->n; k++)
        for (size_t d = 0; d < nv; d++) {
            double *to = &j[k*nv + d], by_input = slope[(size_t)p->n_dim*ld + k];
            *to = d < (size_t)p->n_dim ? slope[d*ld + k] : (int)d == p->i_input0 ? by_input : 0;
            if ((int)d == p->plan.i_theta0 && p->datum == LW_DATUM_PLANE)
                *to -= by_input/p->plan.input_turns_per_period;
        }
}

/* ---- lengths between points of one link ------------------------------------------------------------------------ */

/* 1 - d/most, or d/least - 1. */
static void sides(const lw_problem *p, const double *x, double *g, double *j)
{
    for (int i = 0; i < p->n_side; i++, g++) {
        const lw_side *s = &p->side[i];
        lw_vec2 span = lw_v2_sub(lw_point_on_link(x, s->to), lw_point_on_link(x, s->from));
        double d = lw_v2_norm(span), by = (s->most ? -1 : 1)/s->limit;
        *g = (s->most ? 1 : -1) + by*d;
        if (!j)
            continue;
        memset(j, 0, sizeof *j*(size_t)p->n_var);
        const int *end[2] = { s->from, s->to };
        for (int e = 0; e < 2 && d > 0; e++)
            for (int c = 0; c < 2; c++)
                if (end[e][c] >= 0)
                    j[end[e][c]] += (e ? by : -by)*(c ? span.y : span.x)/d;
        j += p->n_var;
    }
}

/* ---- zones: where fixed pivots must be, and where no pin and no tracer may be -------------------------------- */

/* Derivatives of fixed pivots in the plane: of the place of number `of` by variable d. */
static lw_vec2 pivot_slope(const lw_problem *p, const lw_pivots *v, lw_vec2 turn, int of, int d)
{
    lw_vec2 by = lw_v2((d == p->plan.i_x0) + (d == v->of[of][0] ? turn.x : 0) - (d == v->of[of][1] ? turn.y : 0),
                       (d == p->plan.i_y0) + (d == v->of[of][0] ? turn.y : 0) + (d == v->of[of][1] ? turn.x : 0));
    return d == p->plan.i_theta0 ? lw_v2_add(by, lw_v2_perp(lw_v2_turn(v->at[of], turn))) : by;
}

static void pivot_conditions(const lw_problem *p, const lw_zone *z, const lw_pivots *v, const double *x, double *g, double *j)
{
    static const lw_vec2 box[4] = { { 1, 0 }, { -1, 0 }, { 0, 1 }, { 0, -1 } };
    lw_vec2 turn = lw_v2_polar(1, x[p->plan.i_theta0]), base = lw_v2(x[p->plan.i_x0], x[p->plan.i_y0]);
    for (int k = 0; k < v->n; k++) {
        lw_vec2 at = lw_v2_add(base, lw_v2_turn(v->at[k], turn)), across = lw_v2(-z->to.y, z->to.x);
        bool in_box = z->kind == LW_ZONE_PIVOTS_BOX, in_polygon = lw_zone_is_polygon(z);
        for (int i = 0; i < lw_zone_sides(z); i++, g++) {
            lw_vec2 n = in_polygon ? lw_v2_scale(lw_zone_normal(z, i), -1) : in_box ? box[i] : lw_v2_scale(across, i ? 1 : -1);
            lw_vec2 from = in_polygon ? z->corner[i] : in_box && i % 2 ? z->to : z->at;
            *g = lw_v2_dot(n, lw_v2_sub(at, from)) + (z->kind == LW_ZONE_PIVOTS_LINE ? z->reach : 0);
            for (int d = 0; j && d < p->n_var; d++)
                *j++ = lw_v2_dot(n, pivot_slope(p, v, turn, k, d));
        }
    }
}

/* Lengths are scaled, so hypot, which avoids overflow, is not needed: it costs a fifth of the time here. */
static double length_of(lw_vec2 a) { return sqrt(lw_v2_dot(a, a)); }

/* outside_between of a polygon; least: at the ends.  Inside, the distance is the greatest of those from the sides, which are
 * linear along the line: its least is where two of them cross.  Outside, it is least beside a corner. */
static double outside_of_polygon(const lw_zone *z, lw_vec2 a, lw_vec2 line, double least, double *where)
{
    double base[LW_ZONE_CORNERS], slope[LW_ZONE_CORNERS], lo[2] = { -INFINITY, 0 }, hi[2] = { -INFINITY, 0 };
    int n = z->n_corner;
    for (int i = 0; i < n; i++) {
        lw_vec2 normal = lw_zone_normal(z, i);
        base[i] = lw_v2_dot(normal, lw_v2_sub(a, z->corner[i]));
        slope[i] = lw_v2_dot(normal, line);
        if (base[i] > lo[0])
            lo[0] = base[i], lo[1] = slope[i];
        if (base[i] + slope[i] > hi[0])
            hi[0] = base[i] + slope[i], hi[1] = slope[i];
    }
    double deepest = fmin(lo[0], hi[0]), at = lo[0] <= hi[0] ? 0 : 1;
    for (int step = 0; step <= n && lo[1] < 0 && hi[1] > 0; step++) {
        double t = (hi[0] - hi[1] - lo[0])/(lo[1] - hi[1]), top = -INFINITY, steep = 0;
        double crossing = lo[0] + lo[1]*t;
        for (int i = 0; i < n; i++)
            if (base[i] + slope[i]*t > top)
                top = base[i] + slope[i]*t, steep = slope[i];
        deepest = top;
        at = t;
        if (top <= crossing + 1e-14*(1 + fabs(crossing)))
            break;
        if (steep < 0)
            lo[0] = top - steep*t, lo[1] = steep;
        else
            hi[0] = top + steep*(1 - t), hi[1] = steep;
    }
    if (deepest <= 0) {
        *where = deepest < least ? at : *where;
        return fmin(deepest, least);
    }
    for (int i = 0; i < n; i++) {
        double t = lw_v2_dot(lw_v2_sub(z->corner[i], a), line)/lw_v2_dot(line, line);
        double d = t > 0 && t < 1 ? length_of(lw_v2_sub(lw_v2_add(a, lw_v2_scale(line, t)), z->corner[i])) : INFINITY;
        if (d < least)
            least = d, *where = t;
    }
    return least;
}

/* The least distance to a zone along the straight line from a to b, which has this length and is `from` and `to` off at
 * its ends, and where on it, 0 .. 1.  To a box it is least at an end, beside a corner, or where the nearest side
 * changes: on an axis of the box, or where two sides are equally far. */
static double outside_between(const lw_zone *z, lw_vec2 a, lw_vec2 b, double from, double to, double length, double *where)
{
    lw_vec2 line = lw_v2_sub(b, a);
    double least = fmin(from, to);
    *where = from <= to ? 0 : 1;
    if (length == 0)
        return least;
    if (z->kind == LW_ZONE_NO_CIRCLE) {
        *where = fmax(0, fmin(1, lw_v2_dot(lw_v2_sub(z->at, a), line)/(length*length)));
        return length_of(lw_v2_off_segment(z->at, a, b)) - z->reach;
    }
    if (lw_zone_is_polygon(z))
        return outside_of_polygon(z, a, line, least, where);
    lw_vec2 off = lw_v2_sub(a, lw_v2_scale(lw_v2_add(z->at, z->to), 0.5));
    lw_vec2 half = lw_v2_scale(lw_v2_sub(z->to, z->at), 0.5);
    double at[10] = { -off.x/line.x, -off.y/line.y };      /* divisions by 0 give no number in (0, 1) */
    for (int i = 0; i < 4; i++) {
        double sx = i & 1 ? 1 : -1, sy = i & 2 ? 1 : -1;
        at[2 + i] = (half.x - half.y - sx*off.x + sy*off.y)/(sx*line.x - sy*line.y);
        at[6 + i] = lw_v2_dot(lw_v2_sub(lw_v2(sx*half.x, sy*half.y), off), line)/(length*length);
    }
    for (int i = 0; i < 10; i++) {
        if (!(at[i] > 0 && at[i] < 1))
            continue;
        double d = lw_zone_outside(z, lw_v2_add(a, lw_v2_scale(line, at[i])));
        if (d < least) {
            least = d;
            *where = at[i];
        }
    }
    return least;
}

/* How far a path may leave a chord between two of its postures a, b, c, from its curvature at b. */
static double bulge(lw_vec2 a, lw_vec2 b, lw_vec2 c)
{
    return 0.125*length_of(lw_v2_sub(lw_v2_add(a, c), lw_v2_scale(b, 2)));
}

/* A box that holds points: its corners with the least and the greatest coordinates. */
typedef struct box { lw_vec2 least, most; } box;

static void extend(box *b, lw_vec2 at)
{
    *b = (box){ lw_v2(lw_lesser(b->least.x, at.x), lw_lesser(b->least.y, at.y)),
                lw_v2(-lw_lesser(-b->most.x, -at.x), -lw_lesser(-b->most.y, -at.y)) };
}

static box box_of_zone(const lw_zone *z)
{
    lw_vec2 reach = lw_v2(z->reach, z->reach);
    if (z->kind == LW_ZONE_NO_CIRCLE)
        return (box){ lw_v2_sub(z->at, reach), lw_v2_add(z->at, reach) };
    box b = { z->at, z->to };
    if (lw_zone_is_polygon(z))
        b = (box){ z->corner[0], z->corner[0] };
    for (int i = 0; lw_zone_is_polygon(z) && i < z->n_corner; i++)
        extend(&b, z->corner[i]);
    return b;
}

/* Square of the distance between two boxes. */
static double apart(box a, box b)
{
    double x = fmax(0, fmax(a.least.x - b.most.x, b.least.x - a.most.x));
    double y = fmax(0, fmax(a.least.y - b.most.y, b.least.y - a.most.y));
    return x*x + y*y;
}

/* The pins and tracers whose places are checked, each place once; which: as lw_batch_jacobian has it.  Their paths are in boxes,
 * from which they may stick out by `out`.  From posture k - 1 to k: the length of the chord, and how far the path may leave it. */
typedef struct places {
    int n, which[LW_PLACE_MAX];
    bool closes[ZONE_POSTURES], measured[LW_PLACE_MAX];
    box within[LW_PLACE_MAX];
    double out[LW_PLACE_MAX];
    double length[LW_PLACE_MAX][ZONE_POSTURES], bulge[LW_PLACE_MAX][ZONE_POSTURES];
} places;

static lw_vec2 place(const lw_work *w, int i, size_t k)
{
    return lw_v2(w->place_x[(size_t)i*POSTURES + k], w->place_y[(size_t)i*POSTURES + k]);
}

/* The first of the three postures that give the bulge between k - 1 and k. */
static size_t bulge_from(size_t k) { return k > 1 ? k - 2 : 0; }

static void find_box(const lw_work *w, places *all, int i)
{
    box b = { place(w, i, 0), place(w, i, 0) };
    double bend2 = 0;
    for (size_t k = 1; k < ZONE_POSTURES; k++)
        extend(&b, place(w, i, k));
    for (size_t k = 2; k < ZONE_POSTURES; k++) {
        lw_vec2 bend = lw_v2_sub(lw_v2_add(place(w, i, k - 2), place(w, i, k)), lw_v2_scale(place(w, i, k - 1), 2));
        bend2 = -lw_lesser(-bend2, -lw_v2_dot(bend, bend));
    }
    all->within[i] = b;
    all->out[i] = 0.125*sqrt(bend2);
    all->measured[i] = false;
}

static void find_places(const lw_problem *p, const double *x, lw_work *w, places *out)
{
    out->n = 0;
    for (int j = 0; j < LW_JOINT_MAX; j++) {
        bool seen = p->plan.joint_point[j] < 0;
        for (int i = 0; i < j && !seen; i++)
            seen = p->plan.joint_point[i] == p->plan.joint_point[j];
        if (!seen)
            out->which[out->n++] = LW_BATCH_JOINT(j);
    }
    for (int i = 0; i <= p->n_also; i++)
        out->which[out->n++] = i;
    lw_jacobian all[LW_PLACE_MAX];
    double margin[ZONE_POSTURES];
    for (int i = 0; i < out->n; i++)
        all[i] = (lw_jacobian){ .x = w->place_x + i*POSTURES, .y = w->place_y + i*POSTURES,
                                .margin = i == 0 ? margin : NULL, .ld = w->posture.ld };   /* that of a pin: of the plan */
    jacobians(p, x, w, out->n, out->which, w->check_c, w->check_s, ZONE_POSTURES, all);
    for (size_t k = 0; k < ZONE_POSTURES; k++)
        out->closes[k] = margin[k] >= 0;
    for (int i = 0; i < out->n; i++)
        find_box(w, out, i);
}

/* Lengths and bulges of the chords of place i. */
static void measure_chords(const lw_work *w, places *all, int i)
{
    for (size_t k = 1; k < ZONE_POSTURES && !all->measured[i]; k++) {
        size_t from = bulge_from(k);
        all->length[i][k] = length_of(lw_v2_sub(place(w, i, k), place(w, i, k - 1)));
        all->bulge[i][k] = bulge(place(w, i, from), place(w, i, from + 1), place(w, i, from + 2));
    }
    all->measured[i] = true;
}

/* Where a condition is least: of which place, how far from posture k - 1 to posture k, with the bulge or not. */
typedef struct nearest { int place; double where; bool bulges; } nearest;

/* The least distances between each posture and the one before, of places no farther than `enough` from the zone. 0 if one of them
 * does not close; another condition covers that. */
static void least_distances(const lw_work *w, places *all, const lw_zone *z, double enough, double *g, nearest *at)
{
    const box zone = box_of_zone(z);
    double least[ZONE_POSTURES], outside[ZONE_POSTURES], where;
    for (size_t k = 1; k < ZONE_POSTURES; k++) {
        least[k] = INFINITY;
        at[k] = (nearest){ .place = -1 };
    }
    for (int i = 0; i < all->n; i++) {
        double far = enough + all->out[i];
        if (apart(zone, all->within[i]) > far*far)
            continue;
        measure_chords(w, all, i);
        for (size_t k = 0; k < ZONE_POSTURES; k++)
            outside[k] = lw_zone_outside(z, place(w, i, k));
        for (size_t k = 1; k < ZONE_POSTURES; k++) {
            bool bulges = all->closes[bulge_from(k)] && all->closes[bulge_from(k) + 2];
            double out = bulges ? all->bulge[i][k] : 0;
            if (!(0.5*(outside[k - 1] + outside[k] - all->length[i][k]) - out < least[k]))
                continue;                                   /* no place of the chord is nearer than one found before */
            double d = outside_between(z, place(w, i, k - 1), place(w, i, k), outside[k - 1], outside[k], all->length[i][k], &where) - out;
            if (d < least[k]) {
                least[k] = d;
                at[k] = (nearest){ i, where, bulges };
            }
        }
    }
    for (size_t k = 1; k < ZONE_POSTURES; k++) {
        bool closes = all->closes[k] && all->closes[k - 1];
        g[k - 1] = closes ? least[k] : 0;
        at[k].place = closes ? at[k].place : -1;
    }
}

#define KINK 1e-10      /* sides of a box this close together are equally far */

/* The same as outwards: beyond a corner away from it, else across the farthest side, or the mean of the two farthest. */
static lw_vec2 outwards_of_polygon(const lw_zone *z, lw_vec2 at, lw_vec2 line)
{
    double far[2] = { -INFINITY, -INFINITY }, least = INFINITY;
    lw_vec2 normal[2] = { { 0, 0 }, { 0, 0 } }, edge = at;
    for (int i = 0; i < z->n_corner; i++) {
        lw_vec2 a = z->corner[i], side = lw_v2_sub(z->corner[(i + 1) % z->n_corner], a), n = lw_zone_normal(z, i);
        lw_vec2 foot = lw_v2_add(a, lw_v2_scale(side, fmin(fmax(lw_v2_dot(lw_v2_sub(at, a), side)/lw_v2_dot(side, side), 0), 1)));
        double d = lw_v2_dot(n, lw_v2_sub(at, a)), away = length_of(lw_v2_sub(at, foot));
        if (away < least)
            least = away, edge = foot;
        int k = d > far[0] ? 0 : 1;
        if (k == 0)
            far[1] = far[0], normal[1] = normal[0];
        if (d > far[k])
            far[k] = d, normal[k] = n;
    }
    if (far[0] > 1e-9)
        return lw_v2_scale(lw_v2_sub(at, edge), 1/fmax(least, 1e-300));
    double s = lw_v2_dot(normal[0], line), t = lw_v2_dot(normal[1], line);
    if (far[0] - far[1] < 1e3*KINK && s*t < 0)
        return lw_v2_add(lw_v2_scale(normal[0], t/(t - s)), lw_v2_scale(normal[1], -s/(t - s)));
    return normal[0];
}

/* Gradient of lw_zone_outside at a point where it is least along `line`, which may be 0.  Where the nearest side
 * changes there, it is the mean of the gradients to both sides that is normal to the line. */
static lw_vec2 outwards(const lw_zone *z, lw_vec2 at, lw_vec2 line)
{
    lw_vec2 off = lw_v2_sub(at, z->at);
    if (z->kind == LW_ZONE_NO_CIRCLE)
        return lw_v2_scale(off, 1/fmax(length_of(off), 1e-300));
    if (lw_zone_is_polygon(z))
        return outwards_of_polygon(z, at, line);
    bool left = z->at.x - at.x > at.x - z->to.x, below = z->at.y - at.y > at.y - z->to.y;
    lw_vec2 beyond = lw_v2(left ? z->at.x - at.x : at.x - z->to.x, below ? z->at.y - at.y : at.y - z->to.y);
    lw_vec2 sign = lw_v2(left ? -1 : 1, below ? -1 : 1);
    if (beyond.x > 0 && beyond.y > 0)
        return lw_v2_scale(lw_v2(sign.x*beyond.x, sign.y*beyond.y), 1/length_of(beyond));
    double x = sign.x*line.x, y = sign.y*line.y;
    if (fabs(beyond.x - beyond.y) < KINK && x*y < 0)
        return lw_v2(sign.x*y/(y - x), -sign.y*x/(y - x));
    if (lw_v2_dot(line, line) > 0 && fabs(beyond.x > beyond.y ? 2*at.x - z->at.x - z->to.x : 2*at.y - z->at.y - z->to.y) < KINK)
        return lw_v2(0, 0);
    return beyond.x > beyond.y ? lw_v2(sign.x, 0) : lw_v2(0, sign.y);
}

/* Add pull . dP/dx of the place in the scratch's Jacobian at posture k to a row. */
static void add_place(const lw_problem *p, const lw_work *w, const motion *m, size_t k, lw_vec2 pull, double *row)
{
    size_t ld = w->posture.ld;
    const double *jx = w->posture.jx + k, *jy = w->posture.jy + k;
    double by_input = pull.x*w->posture_u[k] + pull.y*w->posture_v[k];
    for (int d = 0; d < p->n_var; d++) {
        if (d < p->n_dim)
            row[d] += pull.x*jx[(size_t)d*ld] + pull.y*jy[(size_t)d*ld];
        if (inputs_move(p, w, m))
            row[d] += by_input*input_slope(p, w, m, &w->check_at[k], (double)k/LW_ZONE_SAMPLES, d);
    }
}

static void nearest_row(const lw_problem *p, const lw_work *w, const motion *m, const lw_zone *z, size_t k, const nearest *at, double *row)
{
    lw_vec2 b = place(w, at->place, k - 1), c = place(w, at->place, k), pull[3] = { { 0, 0 } };
    size_t from = bulge_from(k);
    bool end = at->where == 0 || at->where == 1;
    lw_vec2 out = outwards(z, lw_v2_add(lw_v2_scale(b, 1 - at->where), lw_v2_scale(c, at->where)), end ? lw_v2(0, 0) : lw_v2_sub(c, b));
    pull[k - 1 - from] = lw_v2_scale(out, 1 - at->where);
    pull[k - from] = lw_v2_scale(out, at->where);
    if (at->bulges) {
        lw_vec2 middle = place(w, at->place, from + 1);
        lw_vec2 bend = lw_v2_sub(lw_v2_add(place(w, at->place, from), place(w, at->place, from + 2)), lw_v2_scale(middle, 2));
        double size = length_of(bend);
        bend = lw_v2_scale(bend, size > 0 ? -0.125/size : 0);
        pull[0] = lw_v2_add(pull[0], bend);
        pull[1] = lw_v2_sub(pull[1], lw_v2_scale(bend, 2));
        pull[2] = lw_v2_add(pull[2], bend);
    }
    for (size_t i = 0; i < 3; i++)
        add_place(p, w, m, from + i, pull[i], row);
}

/* The least distances of all pins and points from the forbidden zones, between each posture and the next. */
static void forbidden(const lw_problem *p, const double *x, lw_work *w, const motion *m, double enough, double *const *g, double *const *j)
{
    places all;
    nearest at[LW_ZONE_MAX][ZONE_POSTURES];
    size_t chosen[LW_ZONE_MAX][LW_ZONE_SAMPLES], needed[LW_ZONE_MAX];
    sample_motion(p, w, m, ZONE_POSTURES);
    find_places(p, x, w, &all);
    for (int i = 0; i < p->n_zone; i++)
        if (g[i])
            least_distances(w, &all, &p->zone[i], enough, g[i], at[i]);
    for (int i = 0; i < p->n_zone; i++)
        needed[i] = j && g[i] ? choose_rows(g[i], LW_ZONE_SAMPLES, enough, chosen[i]) : 0;
    for (int q = 0; j && q < all.n; q++) {
        bool any = false;
        for (int i = 0; i < p->n_zone; i++)
            for (size_t c = 0; c < needed[i]; c++) {
                size_t k = chosen[i][c] + 1;
                if (at[i][k].place != q)
                    continue;
                if (!any) {
                    lw_jacobian jac = w->posture;
                    jac.tx = w->posture_u;
                    jac.ty = w->posture_v;
                    jacobian(p, x, w, all.which[q], w->check_c, w->check_s, ZONE_POSTURES, &jac);
                    any = true;
                }
                nearest_row(p, w, m, &p->zone[i], k, &at[i][k], j[i] + (k - 1)*(size_t)p->n_var);
            }
    }
}

static void zones(const lw_problem *p, const double *x, lw_work *w, const motion *m, double enough, double *g, double *j)
{
    double *of[LW_ZONE_MAX] = { NULL }, *row[LW_ZONE_MAX];
    lw_pivots v;
    bool any = false;
    lw_problem_fixed_pivots(p, x, &v);
    for (int i = 0; i < p->n_zone; i++) {
        const lw_zone *z = &p->zone[i];
        size_t n = lw_zone_forbids(z) ? LW_ZONE_SAMPLES : (size_t)(v.n*lw_zone_sides(z));
        if (lw_zone_forbids(z)) {
            of[i] = g;
            row[i] = j;
            any = true;
            if (j)
                memset(j, 0, sizeof *j*n*(size_t)p->n_var);
        } else
            pivot_conditions(p, z, &v, x, g, j);
        g += n;
        j += j ? n*(size_t)p->n_var : 0;
    }
    if (any)
        forbidden(p, x, w, m, enough, of, j ? row : NULL);
}

/* ---- all of them ------------------------------------------------------------------------------------------- */

/* Do conditions need the stations' inputs? */
static bool needs_stations(const lw_problem *p)
{
    bool postures = p->min_transmission > 0 || p->max_acceleration > 0, forbids = false;
    for (int i = 0; i < p->n_zone; i++)
        forbids |= lw_zone_forbids(&p->zone[i]);
    return lw_problem_must_close(p) || (postures && !p->intended.turns) || (forbids && !is_whole(p))
        || (lw_problem_has_modes(p) && (postures || forbids));
}

/* Set the inputs of the stations. False: the linkage cannot close. */
static bool find_stations(const lw_problem *p, const double *x, bool settled, lw_work *w)
{
    if (settled || !needs_stations(p))
        return true;
    if (p->timing == LW_TIMING_PRESCRIBED)
        lw_problem_prescribe(p, x, w);
    else if (is_whole(p))
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
    motion between = motion_of(p, w);
    if (j && needs_stations(p) && between.moves)
        end_slopes(p, x, w, &between);
    if (j && lw_problem_has_modes(p))
        lw_circuit_slopes(p, x, w);
    if (lw_problem_must_close(p)) {
        closure(p, x, w, g, j);
        g += p->n;
        j += j ? p->n*nv : 0;
    }
    motion turn = { .moves = false }, *checked = p->intended.turns ? &turn : &between;
    if (p->min_transmission > 0) {
        size_t n = lw_problem_transmission_postures(p);
        sample(p, w, checked, n);
        transmissions(p, x, w, checked, enough, g, j);
        g += n;
        j += j ? n*nv : 0;
    }
    if (p->max_acceleration > 0) {
        sample(p, w, checked, POSTURES);
        accelerations(p, x, w, checked, enough, g, j);
        g += POSTURES;
        j += j ? POSTURES*nv : 0;
    }
    if (p->n_zone > 0)
        zones(p, x, w, &between, enough, g, j);
}

void lw_problem_constraints(const lw_problem *p, const double *x, double *g, double *j, void *work)
{
    lw_problem_conditions(p, x, false, ALL_ROWS, g, j, work);
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
