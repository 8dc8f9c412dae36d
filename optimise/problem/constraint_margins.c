/* optimise/problem/constraint_margins.c - conditions on transmission angles and accelerations: their extremes over the motion, and rows of
 * derivatives there. */
#include "optimise/problem/constraint_internal.h"

#include <string.h>
#include "base/vector.h"

static void margins_at(const lw_problem *p, const double *x, lw_work *w, const double *c, const double *s, size_t n,
                       double *margin, double *slope);

#define DIFFERENCE 2e-7             /* step of differences, of sizes and angles */

/* Set the slopes of margins that belong to a higher group, which are not known, by central differences; `slope` is as margins_at has
 * it. */
static void higher_slopes(const lw_problem *p, const double *x, lw_work *w, const double *c, const double *s, size_t n, double *slope)
{
    size_t ld = w->posture.ld, rows = (size_t)p->n_dim;
    double at[LW_VAR_MAX], value[2][LW_CURVE_SAMPLES], by_c[LW_CURVE_SAMPLES], by_s[LW_CURVE_SAMPLES];
    memcpy(at, x, sizeof *at*(size_t)p->n_var);
    for (size_t first = 0, m; first < n; first += m) {
        m = n - first < LW_CURVE_SAMPLES ? n - first : LW_CURVE_SAMPLES;
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
        lw_checked_jacobian(p, x, w, i, c, s, n, &j);
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
    lw_checked_jacobian(p, x, w, 0, w->posture_c, w->posture_s, n, &j);
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
    bool at_once = !lw_problem_has_modes(p) && 2*lanes <= LW_CURVE_SAMPLES;
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
    acceleration of[LW_CURVE_SAMPLES];
    find_accelerations(p, x, w, n, of, g);
}

/* A condition in n postures of check_c, check_s. */
typedef void condition(const lw_problem *p, const double *x, lw_work *w, size_t n, double *g);

/* Move the postures from number `first` on to n places, counted in samples of the motion. */
static void move_postures(const lw_problem *p, lw_work *w, const lw_checked_motion *m, size_t first, size_t n, const double *place)
{
    static const lw_checked_motion turn = { .length = 2*LW_PI };
    double part[LW_CURVE_SAMPLES] = { 0 };
    lw_cycle_point at[LW_CURVE_SAMPLES];
    for (size_t i = 0; i < n; i++)
        part[i] = p->intended.turns ? place[i]/LW_CURVE_SAMPLES : fmin(fmax(place[i]/(LW_CURVE_SAMPLES - 1), 0), 1);
    lw_checked_points(p, w, p->intended.turns ? &turn : m, n, part, at);
    for (size_t i = 0; i < n; i++) {
        w->check_at[first + i] = at[i];
        w->check_c[first + i] = at[i].c;
        w->check_s[first + i] = at[i].s;
    }
}

/* Move posture q*i + k to best[i] + h*net[k], for each of n places. */
static void spread_net(const lw_problem *p, lw_work *w, const lw_checked_motion *m, size_t n, const double *best, double h,
                       size_t q, const double *net)
{
    double place[LW_CURVE_SAMPLES] = { 0 };
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
    size_t next = (k + (size_t)(LW_CURVE_SAMPLES + side)) % LW_CURVE_SAMPLES, beyond = (next + (size_t)(LW_CURVE_SAMPLES + side)) % LW_CURVE_SAMPLES;
    bool ends = !p->intended.turns && (next == 0 || next == LW_CURVE_SAMPLES - 1);
    return ends || lw_checked_changes(p, w, side > 0 ? next : beyond) || !(g[beyond] > g[next]) ? 1 : 1.5;
}

/* Is sample k less than both neighbours? */
static bool is_low(const double *g, size_t k, bool round)
{
    bool inside = round || (k > 0 && k < LW_CURVE_SAMPLES - 1);
    return inside && g[k] < g[(k + LW_CURVE_SAMPLES - 1) % LW_CURVE_SAMPLES] && g[k] <= g[(k + 1) % LW_CURVE_SAMPLES];
}

/* May an extreme be hidden beside sample k: do the samples fall on from it by less than a third of what they fell by before?  The margin is the
 * least of several groups: beyond the extreme of one, another one goes on to fall. */
static bool falls_on(const double *g, size_t k, bool round)
{
    size_t before = (k + LW_CURVE_SAMPLES - 1) % LW_CURVE_SAMPLES, after = (k + 1) % LW_CURVE_SAMPLES;
    double left = g[before] - g[k], right = g[after] - g[k];
    return (right < 0 && left > -3*right && !is_low(g, after, round)) || (left <= 0 && right > -3*left && !is_low(g, before, round));
}

/* Move each sample beside which an extreme may lie to the least extreme within 1.5 samples, whose value g becomes: two nets,
 * each of a quarter of the spacing before, then parabolas.  The posture of sample k is then at place[k].  Only the
 * least of many; not those that would stay above `enough` if the bend of the three samples went on. */
static void seek_extremes(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, condition *of,
                          double enough, double *g, double *place)
{
    enum { NET = 10, MOST = LW_CURVE_SAMPLES/NET };
    size_t at[MOST], n = 0;
    double best[MOST], lo[MOST], hi[MOST], value[LW_CURVE_SAMPLES];
    bool round = p->intended.turns;
    for (size_t k = 0; k < LW_CURVE_SAMPLES; k++)
        place[k] = (double)k;
    for (size_t hidden = 0, first = 0; hidden < 2; hidden++, first = n)       /* hidden ones only where there is room for them */
        for (size_t k = round ? 0 : 1; k < (round ? LW_CURVE_SAMPLES : LW_CURVE_SAMPLES - 1); k++) {
            double before = g[(k + LW_CURVE_SAMPLES - 1) % LW_CURVE_SAMPLES], after = g[(k + 1) % LW_CURVE_SAMPLES];
            if (!(hidden ? falls_on(g, k, round) : is_low(g, k, round)) || g[k] - (before + after - 2*g[k]) > enough
                || (k > 0 && lw_checked_changes(p, w, k - 1)) || lw_checked_changes(p, w, k))
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
 * lw_rows_keep has it; a condition held at `most` has no posture. */
static void lower_changes(const lw_problem *p, const lw_work *w, double most, double *g, size_t *from)
{
    for (size_t k = 0; k < LW_CURVE_SAMPLES; k++)
        from[k] = k;
    for (size_t k = 0; k < LW_CURVE_SAMPLES; k++) {
        if (!lw_checked_changes(p, w, k))
            continue;
        size_t least = g[k] < g[k + 1] ? k : k + 1;
        from[k] = from[k + 1] = g[least] < most ? from[least] : LW_CURVE_SAMPLES;
        g[k] = g[k + 1] = fmin(most, g[least]);
    }
}

/* The rows of the postures that were kept of n, from the derivatives in `slope`. */
static void put_rows(const lw_problem *p, const lw_work *w, const lw_checked_motion *m, size_t n, size_t kept, const size_t *row,
                     const double *place, const double *slope, double *j)
{
    for (size_t k = 0; k < kept; k++)
        lw_row_put(p, w, m, place[k]/(double)(n - 1), &w->check_at[k], slope, k, j + row[k]*(size_t)p->n_var);
}

static void margins(const lw_problem *p, const double *x, lw_work *w, size_t n, double *g)
{
    margins_at(p, x, w, w->check_c, w->check_s, n, g, NULL);
}

void lw_check_transmissions(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, double enough, double *g, double *j)
{
    double sine = sin(p->min_transmission), place[LW_CURVE_SAMPLES], unused[LW_CURVE_SAMPLES];
    size_t n = lw_problem_transmission_postures(p), from[LW_CURVE_SAMPLES], row[LW_CURVE_SAMPLES];
    margins(p, x, w, n, g);
    if (n == LW_CURVE_SAMPLES) {                                      /* else the postures are those of the extremes */
        seek_extremes(p, x, w, m, margins, enough + sine*sine, g, place);
        lower_changes(p, w, 0, g, from);
    }
    for (size_t k = 0; k < n && n < LW_CURVE_SAMPLES; k++)
        place[from[k] = k] = (double)k;
    for (size_t k = 0; k < n; k++)
        g[k] -= sine*sine;
    if (!j)
        return;
    size_t kept = lw_rows_keep(p, w, g, n, enough, from, place, row, j);
    margins_at(p, x, w, w->check_c, w->check_s, kept, unused, w->slope[0]);
    put_rows(p, w, m, n, kept, row, place, w->slope[0], j);
}

#define FAR_FROM_LIMIT 0.5          /* |P''| below 0.7 of its limit: peaks between samples do not matter  */

void lw_check_accelerations(const lw_problem *p, const double *x, lw_work *w, const lw_checked_motion *m, double enough, double *g, double *j)
{
    const double scale = 2/(p->max_acceleration*p->max_acceleration);
    acceleration a[LW_CURVE_SAMPLES];
    double place[LW_CURVE_SAMPLES], unused[LW_CURVE_SAMPLES];
    size_t from[LW_CURVE_SAMPLES], row[LW_CURVE_SAMPLES];
    acceleration_conditions(p, x, w, LW_CURVE_SAMPLES, g);
    seek_extremes(p, x, w, m, acceleration_conditions, FAR_FROM_LIMIT, g, place);
    lower_changes(p, w, -1, g, from);                       /* at a dead point it is unbounded */
    if (!j)
        return;
    size_t kept = lw_rows_keep(p, w, g, LW_CURVE_SAMPLES, enough, from, place, row, j);
    find_accelerations(p, x, w, kept, a, unused);
    acceleration_slopes(p, x, w, kept);
    for (size_t d = 0; d <= (size_t)p->n_dim; d++)
        for (size_t k = 0; k < kept; k++) {
            size_t at = d*w->posture.ld + k;
            double v2 = !lw_task_has_place(p->task) ? 2*(a[k].vx*a[k].vx + a[k].vy*a[k].vy) : 0;
            w->slope[0][at] = -scale*(a[k].x*w->slope[0][at] + a[k].y*w->slope[1][at]
                                      - v2*(a[k].vx*w->slope[2][at] + a[k].vy*w->slope[3][at]));
        }
    put_rows(p, w, m, LW_CURVE_SAMPLES, kept, row, place, w->slope[0], j);
}

void lw_check_closure(const lw_problem *p, const double *x, lw_work *w, double *g, double *j)
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
