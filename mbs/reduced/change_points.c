/* mbs/reduced/change_points.c - change points: inputs at which the two assembly modes of a dyad meet and part again.
 *
 * The margin of a dyad, sin^2 of its angle, has a double root there, so y = +-sqrt(margin) has a simple one, and a
 * linkage that keeps its velocities changes to the other sign.  The input is scanned from the start to both sides,
 * with modes that change at every such point; where a margin falls below 0 the motion ends. */
#include "base/real.h"
#include "mbs/reduced/reduced_internal.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"

static const int    per_turn = 360;          /* inputs looked at in a turn */
static const double is_zero = 1e-13;         /* a margin below this is 0: rounding of lengths */
static const double near_zero = 0.05;         /* only margins below this are looked at */
static const double vague = 1e-7;            /* a margin below this is neither 0 nor clearly a gap */
static const double on_lengths = 1e-11;      /* residual allowed on a bridge, over the links' lengths */
static const double reach_most = 0.05;       /* greatest half width of a bridge [rad], or over the size */

typedef struct scan {
    lw_reduced *r;
    double mode[LW_DYAD_MAX], width;         /* width: of one step */
    double margin[3][LW_DYAD_MAX];           /* at the last three inputs */
    double limit;                            /* input at which the motion ends */
    int    side;                             /* direction of the scan */
    bool   vague;                            /* assembly modes came near each other but did not meet */
    const lw_change_point *met;                     /* point behind which the modes of its dyads have changed */
} scan;

/* Margin of one dyad. */
static double margin_at(const scan *c, int dyad, double input)
{
    double of[LW_DYAD_MAX], mode[LW_DYAD_MAX], least;
    memcpy(mode, c->mode, sizeof mode);
    for (int b = 0; c->met && c->side*(input - c->met->at) > 0 && b < c->met->n_bridge; b++)
        mode[c->met->bridge[b].dyad] *= -1;
    lw_reduced_plain(c->r, mode, NULL, input, of, &least);
    return of[dyad];
}

/* Least margin of a dyad between inputs a and b, by golden section. */
static double least_margin(const scan *c, int dyad, double a, double b, double *where)
{
    const double g = 0.6180339887498949;
    double x1 = b - g*(b - a), x2 = a + g*(b - a), f1 = margin_at(c, dyad, x1), f2 = margin_at(c, dyad, x2);
    for (int k = 0; k < 60 && fabs(b - a) > 1e-9*c->width; k++) {
        if (f1 < f2) {
            b = x2, x2 = x1, f2 = f1;
            x1 = b - g*(b - a), f1 = margin_at(c, dyad, x1);
        } else {
            a = x1, x1 = x2, f1 = f2;
            x2 = a + g*(b - a), f2 = margin_at(c, dyad, x2);
        }
    }
    *where = f1 < f2 ? x1 : x2;
    return fmin(f1, f2);
}

/* The simple root of +-sqrt(margin), by inverse interpolation from inputs on both sides. */
static double sharpen(const scan *c, int dyad, double at)
{
    for (int pass = 0; pass < 3; pass++) {
        double h = c->width*(pass ? 0.05 : 0.3), left = sqrt(fmax(0, margin_at(c, dyad, at - h)));
        double right = sqrt(fmax(0, margin_at(c, dyad, at + h)));
        if (!(left + right > 0))
            break;
        at += h*(left - right)/(left + right);
    }
    return at;
}

/* ---- bridges ------------------------------------------------------------------------------------------ */

static int angles_of(const lw_plan *p, int dyad, int out[2])
{
    for (int i = 0; i < p->n_step; i++)
        if (p->step[i].kind >= LW_STEP_RRR && p->step[i].dyad == dyad) {
            out[0] = p->step[i].out[0];
            out[1] = p->step[i].kind == LW_STEP_RRR ? p->step[i].out[1] : -1;
            return p->step[i].kind;
        }
    return -1;
}

/* Fit polynomials through angle and rate at six inputs near the change point; false: they do not fit. */
static bool fit_bridge(lw_reduced *r, const double *before, const double *after, const lw_change_point *t, lw_bridge *b)
{
    static const double place[6] = { -2, -1.5, -1, 1, 1.5, 2 };
    double a[LW_BRIDGE_SIZE*LW_BRIDGE_SIZE], diag[LW_BRIDGE_SIZE], rhs[2][LW_BRIDGE_SIZE], first[2] = { 0, 0 };
    int out[2] = { -1, -1 };
    angles_of(&r->plan, b->dyad, out);
    for (int i = 0; i < 6; i++) {
        double x = place[i], margin;
        lw_reduced_plain(r, x < 0 ? before : after, NULL, t->at + x*t->reach, NULL, &margin);
        for (int k = 0; k < LW_BRIDGE_SIZE; k++) {
            a[2*i + LW_BRIDGE_SIZE*k] = pow(x, k);
            a[2*i + 1 + LW_BRIDGE_SIZE*k] = k < 1 ? 0 : k*pow(x, k - 1);
        }
        for (int j = 0; j < 2; j++) {
            if (out[j] < 0)
                continue;
            const lw_reg1 *u = &r->reg[out[j]];
            double angle = atan2(u->p.y, u->p.x);
            /* the branch of the angle that the last value predicts */
            double expected = i ? first[j] + (place[i] - place[i - 1])*t->reach*u->d.x : angle;
            first[j] = expected + remainder(angle - expected, 2*LW_PI);
            rhs[j][2*i] = first[j];
            rhs[j][2*i + 1] = u->d.x*t->reach;
        }
    }
    lw_qr_factor(LW_BRIDGE_SIZE, LW_BRIDGE_SIZE, a, diag);
    for (int j = 0; j < 2; j++)
        if (out[j] >= 0) {
            lw_qr_solve(LW_BRIDGE_SIZE, LW_BRIDGE_SIZE, a, diag, rhs[j]);
            memcpy(b->c[j], rhs[j], sizeof rhs[j]);
            for (int k = 0; k < LW_BRIDGE_SIZE; k++)
                if (!isfinite(b->c[j][k]))
                    return false;
        }
    return true;
}

/* ---- going through ------------------------------------------------------------------------------------ */

/* Is the margin least at the middle of the last three inputs, and 0 near there? */
static bool is_change_point(const scan *c, int d, double middle)
{
    double where;
    return c->margin[1][d] <= c->margin[0][d] && c->margin[1][d] <= c->margin[2][d] && c->margin[1][d] <= near_zero
           && fabs(least_margin(c, d, middle - c->width, middle + c->width, &where)) <= is_zero;
}

/* Find the dyads whose margin is least at the middle of the last three inputs, and those that share the change point
 * of one of them: where it lies on one of the inputs, rounding decides which margin is least there. */
static bool meet(scan *c, double middle, lw_change_point *t)
{
    lw_reduced *r = c->r;
    bool any = false;
    t->n_bridge = 0;
    c->met = NULL;
    for (int d = 0; d < r->plan.n_dyad; d++)
        any = any || is_change_point(c, d, middle);
    for (int d = 0; d < r->plan.n_dyad; d++) {
        double where;
        const double *m[3] = { c->margin[0], c->margin[1], c->margin[2] };
        /* if one dyad changes, look at all; else only at margins that are vague */
        if (!any && (!(m[1][d] <= m[0][d] && m[1][d] <= m[2][d]) || m[1][d] > near_zero))
            continue;
        double least = least_margin(c, d, middle - c->width, middle + c->width, &where);
        c->vague = c->vague || (fabs(least) > is_zero && fabs(least) < vague);
        if (!(fabs(least) <= is_zero))
            continue;                              /* passed by, or a gap, where the motion ends */
        where = sharpen(c, d, where);
        if (t->n_bridge == 0)
            t->at = where;
        if (fabs(where - t->at) < 1e-7*c->width)
            t->bridge[t->n_bridge++].dyad = d;
        c->met = t;
    }
    c->met = NULL;
    return t->n_bridge > 0;
}

/* Scan from `from` to one side, at most `turns` turns: change points in the order met, and the modes behind each. */
static int scan_side(scan *c, double from, int side, int turns, lw_change_point *found, double mode[][LW_DYAD_MAX])
{
    lw_reduced *r = c->r;
    double least;
    int n = 0, seen = 0, open = 0;
    c->side = side;
    c->limit = side*INFINITY;
    for (int k = 0; k <= turns*per_turn + 1; k++) {
        double at = from + side*k*c->width;
        memmove(c->margin[0], c->margin[1], 2*sizeof c->margin[0]);
        lw_reduced_plain(r, c->mode, NULL, at, c->margin[2], &least);
        if (++seen >= 3 && n < LW_CHANGE_POINT_MAX && meet(c, at - side*c->width, &found[n])) {
            for (int b = 0; b < found[n].n_bridge; b++)
                c->mode[found[n].bridge[b].dyad] *= -1;
            memcpy(mode[n++], c->mode, sizeof c->mode);
            seen = 0;                              /* the last margins belong to other modes */
            open = 0;
            k--;
            continue;
        }
        open = least < -1e-12 ? open + 1 : 0;      /* just behind a change point the modes may not fit yet */
        if (open == 2) {
            c->limit = at;
            break;
        }
    }
    return n;
}

static bool same_modes(const lw_plan *p, const double *a, const double *b)
{
    for (int d = 0; d < p->n_dyad; d++)
        if (a[d] != b[d] && p->dyad[d].link[0] >= 0)
            return false;
    return true;
}

/* Do the dyads close all along the bridge?  They do not where their assembly modes come near each other without
 * meeting (a parallelogram with one length slightly off). */
static bool bridge_closes(lw_reduced *r, const double *before, const double *after, const lw_change_point *t)
{
    for (int k = -4; k <= 4; k++) {
        double margin;
        lw_reduced_plain(r, k < 0 ? before : after, t, t->at + 0.2*k*t->reach, NULL, &margin);
        for (int i = 0; i < r->n_step; i++) {
            const lw_dyad_step *st = &r->step[i];
            bool bridged = false;
            for (int b = 0; b < t->n_bridge && st->kind >= LW_STEP_RRR; b++)
                bridged = bridged || t->bridge[b].dyad == st->dyad;
            if (!bridged || (st->kind != LW_STEP_RRR && st->kind != LW_STEP_RRP && st->kind != LW_STEP_RPR))
                continue;
            const lw_reg1 *a = &r->reg[st->in[0]], *b = &r->reg[st->in[1]];
            lw_vec2 u = r->reg[st->out[0]].p, c = lw_v2_add(a->p, lw_v2_scale(u, st->r1));
            double off = st->kind == LW_STEP_RRR ? lw_v2_norm(lw_v2_sub(c, b->p)) - fabs(st->r2)
                       : st->kind == LW_STEP_RPR ? lw_v2_cross(u, lw_v2_sub(b->p, a->p)) - st->r1
                       : lw_v2_cross(r->reg[st->in[2]].p, lw_v2_sub(c, b->p));
            double length = st->kind == LW_STEP_RPR ? r->dynamics->s.unit : fabs(st->r1) + (st->kind == LW_STEP_RRR ? fabs(st->r2) : 0);
            if (!(fabs(off) <= on_lengths*length))
                return false;
        }
    }
    return true;
}

/* Make each bridge as wide as its neighbours allow; LW_E_KIND: one does not close. */
static lw_status make_bridges(lw_reduced *r)
{
    for (int i = 0; i < r->n_change; i++) {
        lw_change_point *t = &r->change[i];
        t->reach = reach_most*r->scale;
        if (i > 0)
            t->reach = fmin(t->reach, 0.25*(t->at - r->change[i - 1].at));
        if (i + 1 < r->n_change)
            t->reach = fmin(t->reach, 0.25*(r->change[i + 1].at - t->at));
        for (int b = 0; b < t->n_bridge;) {
            if (fit_bridge(r, r->piece_mode[i], r->piece_mode[i + 1], t, &t->bridge[b])) {
                b++;
                continue;
            }
            t->bridge[b] = t->bridge[--t->n_bridge];
        }
        if (!bridge_closes(r, r->piece_mode[i], r->piece_mode[i + 1], t))
            return LW_E_KIND;
    }
    return LW_OK;
}

/* Change points to one side, and the modes behind each. */
typedef struct points {
    lw_change_point found[LW_CHANGE_POINT_MAX];
    double mode[LW_CHANGE_POINT_MAX][LW_DYAD_MAX];
} points;

static lw_status find_points(lw_reduced *r, double from, points *ahead, points *behind)
{
    static const int most_turns = 4;
    double turn = r->plan.input_is_slider ? 20*r->scale : 2*LW_PI;
    lw_change_point *found = ahead->found, *back = behind->found;
    double (*mode)[LW_DYAD_MAX] = ahead->mode, (*back_mode)[LW_DYAD_MAX] = behind->mode;
    scan c = { .r = r, .width = turn/per_turn };
    memcpy(c.mode, r->mode, sizeof c.mode);
    int n = scan_side(&c, from, 1, most_turns, found, mode);
    if (c.vague)
        return LW_E_KIND;
    if (n == 0 && !r->plan.input_is_slider && isinf(c.limit))
        return LW_OK;                             /* whole turns without one */
    memcpy(r->piece_mode[0], r->mode, sizeof r->mode);
    for (int k = 1; n > 0 && !r->plan.input_is_slider && isinf(c.limit) && k <= most_turns; k++) {
        int m = 0;
        while (m < n && found[m].at < from + k*turn)
            m++;
        if (!same_modes(&r->plan, m ? mode[m - 1] : r->mode, r->mode) || m > LW_CHANGE_POINT_MAX/2)
            continue;
        r->period = k*turn;
        r->low = from;
        r->n_change = m;
        memcpy(r->change, found, (size_t)m*sizeof *found);
        memcpy(r->piece_mode[1], mode, (size_t)m*sizeof *mode);
        return make_bridges(r);
    }
    /* not periodic within these turns: scan both sides */
    memcpy(c.mode, r->mode, sizeof c.mode);
    int m = scan_side(&c, from, -1, most_turns, back, back_mode);
    if (c.vague)
        return LW_E_KIND;
    if (n + m == 0)
        return LW_OK;                             /* no mode changes: the plan itself tells where it ends */
    r->high = from + most_turns*turn;
    m = m < LW_CHANGE_POINT_MAX/2 ? m : LW_CHANGE_POINT_MAX/2;
    n = n < LW_CHANGE_POINT_MAX/2 ? n : LW_CHANGE_POINT_MAX/2;
    r->low = m == LW_CHANGE_POINT_MAX/2 ? back[m - 1].at + 1e-3*c.width : from - most_turns*turn;
    if (n == LW_CHANGE_POINT_MAX/2)
        r->high = found[n - 1].at - 1e-3*c.width;
    r->n_change = m + n;
    assert(r->n_change <= LW_CHANGE_POINT_MAX);
    for (int i = 0; i < m; i++) {
        r->change[i] = back[m - 1 - i];
        memcpy(r->piece_mode[i], back_mode[m - 1 - i], sizeof *back_mode);
    }
    memcpy(r->piece_mode[m], r->mode, sizeof r->mode);
    for (int i = 0; i < n; i++) {
        r->change[m + i] = found[i];
        memcpy(r->piece_mode[m + i + 1], mode[i], sizeof *mode);
    }
    return make_bridges(r);
}

lw_status lw_reduced_change_points(lw_reduced *r, double from)
{
    points *sides = malloc(2*sizeof *sides);
    lw_status s = sides ? find_points(r, from, &sides[0], &sides[1]) : LW_E_MEMORY;
    free(sides);
    return s;
}
