#include "catalogues/curves/descriptor.h"

#include <string.h>
#include "base/real.h"

#define STARTS  LW_MATCHER_STARTS
#define PAIRS   (LW_TERMS/2)

/* ---- coefficients ----------------------------------------------------------------------------------
 *
 * A polygon traversed at even speed has a velocity that is constant on each side.  Integrating by parts twice leaves a
 * sum over its corners: with dv_j the change of velocity at corner j, which is passed at time t_j in [0, 1),
 *     closed    c_k = - sum_j dv_j e^{-2 pi i k t_j} / (2 pi k)^2,
 *     open      c_k = - sqrt 2 sum_j dv_j cos(pi k t_j) / (pi k)^2, where the velocity is 0 before and after the path. */

#define LANES 8

/* Corners whose sums are not added yet, and the sums over k of dv cos and dv sin. */
typedef struct corners {
    int    n;                                                  /* corners in the lanes */
    double angle[LANES], dx[LANES], dy[LANES];
    double xc[LW_TERMS][LANES], xs[LW_TERMS][LANES], yc[LW_TERMS][LANES], ys[LW_TERMS][LANES];
} corners;

static void add_lanes(corners *a, int n_term)
{
    double c[LANES], s[LANES], ck[LANES], sk[LANES];
    for (int i = 0; i < LANES; i++) {
        ck[i] = c[i] = cos(a->angle[i]);
        sk[i] = s[i] = sin(a->angle[i]);
    }
    for (int k = 0; k < n_term; k++)
        for (int i = 0; i < LANES; i++) {
            double next = ck[i]*c[i] - sk[i]*s[i];
            a->xc[k][i] += a->dx[i]*ck[i];
            a->xs[k][i] += a->dx[i]*sk[i];
            a->yc[k][i] += a->dy[i]*ck[i];
            a->ys[k][i] += a->dy[i]*sk[i];
            sk[i] = sk[i]*c[i] + ck[i]*s[i];
            ck[i] = next;
        }
    a->n = 0;
    memset(a->dx, 0, sizeof a->dx);
    memset(a->dy, 0, sizeof a->dy);
}

static void add_corner(corners *a, int n_term, double angle, lw_vec2 dv)
{
    a->angle[a->n] = angle;
    a->dx[a->n] = dv.x;
    a->dy[a->n] = dv.y;
    if (++a->n == LANES)
        add_lanes(a, n_term);
}

static double sum_of(const double *lane)
{
    return ((lane[0] + lane[1]) + (lane[2] + lane[3])) + ((lane[4] + lane[5]) + (lane[6] + lane[7]));
}

static void set_terms(const corners *a, bool closed, double scale, lw_vec2 *term)
{
    for (int k = 0; k < (closed ? PAIRS : LW_TERMS); k++) {
        double xc = sum_of(a->xc[k]), xs = sum_of(a->xs[k]), yc = sum_of(a->yc[k]), ys = sum_of(a->ys[k]);
        double by = -scale/((k + 1)*(k + 1)*LW_PI*LW_PI);
        if (closed) {
            term[2*k] = lw_v2_scale(lw_v2(xc + ys, yc - xs), by/4);
            term[2*k + 1] = lw_v2_scale(lw_v2(xc - ys, yc + xs), by/4);
        } else {
            term[k] = lw_v2_scale(lw_v2(xc, yc), by*sqrt(2.0));
        }
    }
}

static lw_vec2 side(const lw_vec2 *p, size_t n, size_t i) { return lw_v2_sub(p[i + 1 < n ? i + 1 : 0], p[i]); }

lw_status lw_descriptor_make(const lw_vec2 *p, size_t n, bool closed, lw_descriptor *d)
{
    size_t n_side = n < 2 ? 0 : n - 1 + closed;
    int n_term = closed ? PAIRS : LW_TERMS;
    double length = 0, square = 0, before = 0;
    lw_vec2 first = lw_v2(0, 0), last = lw_v2(0, 0);           /* directions of the sides with a length */
    corners a = { 0 };
    *d = (lw_descriptor){ .closed = closed };
    for (size_t i = 0; i < n_side; i++) {
        lw_vec2 v = side(p, n, i);
        double piece = sqrt(lw_v2_dot(v, v));
        length += piece;
        d->centre = lw_v2_add(d->centre, lw_v2_scale(lw_v2_add(lw_v2_sub(p[i], p[0]), lw_v2_scale(v, 0.5)), piece));
        if (piece > 0)
            last = lw_v2_scale(v, 1/piece);
    }
    if (!isfinite(length) || !(length > 0))
        return LW_E_ARG;
    d->centre = lw_v2_add(p[0], lw_v2_scale(d->centre, 1/length));
    last = closed ? last : first;
    for (size_t i = 0; i < n_side; i++) {
        lw_vec2 v = side(p, n, i), from = lw_v2_sub(p[i], d->centre), to = lw_v2_add(from, v);
        double piece = sqrt(lw_v2_dot(v, v));
        if (!(piece > 0))
            continue;
        v = lw_v2_scale(v, 1/piece);
        square += piece*(lw_v2_dot(from, from) + lw_v2_dot(from, to) + lw_v2_dot(to, to))/(3*length);
        add_corner(&a, n_term, (closed ? 2 : 1)*LW_PI*before/length, lw_v2_sub(v, last));
        last = v;
        before += piece;
    }
    if (!closed)
        add_corner(&a, n_term, LW_PI, lw_v2_scale(last, -1));
    add_lanes(&a, n_term);
    d->size = sqrt(square);
    if (!(d->size > 1e-9*length))
        return LW_E_ARG;
    set_terms(&a, closed, length/d->size, d->term);
    return LW_OK;
}

/* ---- packed ---------------------------------------------------------------------------------------- */

void lw_descriptor_pack(const lw_descriptor *d, lw_packed *packed)
{
    for (int k = 0; k < LW_TERMS; k++) {
        packed->re[k] = (int16_t)lrint(LW_TERM_ONE*fmin(fmax(d->term[k].x, -1), 1));
        packed->im[k] = (int16_t)lrint(LW_TERM_ONE*fmin(fmax(d->term[k].y, -1), 1));
    }
}

void lw_descriptor_unpack(const lw_packed *packed, bool closed, lw_descriptor *d)
{
    *d = (lw_descriptor){ .closed = closed, .size = 1 };
    for (int k = 0; k < LW_TERMS; k++)
        d->term[k] = lw_v2(packed->re[k]/LW_TERM_ONE, packed->im[k]/LW_TERM_ONE);
}

void lw_packed_size(const lw_packed *p, float size[LW_TERMS])
{
    for (int k = 0; k < LW_TERMS; k++) {
        float re = p->re[k], im = p->im[k];
        size[k] = sqrtf(re*re + im*im)*(float)(1/LW_TERM_ONE);
    }
}

void lw_descriptor_sizes(const lw_descriptor *d, float forth[LW_TERMS], float back[LW_TERMS])
{
    for (int k = 0; k < LW_TERMS; k++)
        forth[k] = (float)sqrt(lw_v2_dot(d->term[k], d->term[k]));
    for (int k = 0; k < LW_TERMS; k++)
        back[k] = forth[d->closed ? k ^ 1 : k];
}

/* ---- distance -------------------------------------------------------------------------------------- */

/* The terms of the curve as it is, mirrored, traversed in reverse, or both. */
static void variant(const lw_descriptor *d, bool mirrored, bool reversed, lw_vec2 *term)
{
    for (int k = 0; k < LW_TERMS; k++) {
        lw_vec2 c = d->closed && mirrored != reversed ? d->term[k ^ 1] : d->term[k];
        if (mirrored)
            c.y = -c.y;
        if (!d->closed && reversed && k%2 == 0)                /* term k is c_(k + 1) */
            c = lw_v2_scale(c, -1);
        term[k] = c;
    }
}

/* F(tau) = sum of w_k e^{i k tau}; w in the order of the terms. */
static lw_vec2 sum_at(const lw_vec2 *w, double tau)
{
    lw_vec2 one = lw_v2_polar(1, tau), turn = one, f = lw_v2(0, 0);
    for (int k = 0; k < LW_TERMS; k += 2, turn = lw_v2_turn(turn, one))
        f = lw_v2_add(f, lw_v2_add(lw_v2_turn(w[k], turn), lw_v2_unturn(w[k + 1], turn)));
    return f;
}

/* g(tau) = |F(tau)|^2 = g_0 + sum over m > 0 of 2 Re(g_m e^{i m tau}), and a bound of its third derivative. */
typedef struct square_series { double constant, third; lw_vec2 g[LW_TERMS + 1]; } square_series;

/* The terms of a closed curve in the order c_-8 .. c_-1, (c_0 = 0), c_1 .. c_8. */
static void square_series_make(const lw_vec2 *w, square_series *q)
{
    lw_vec2 v[2*PAIRS + 1];
    *q = (square_series){ 0 };
    v[PAIRS] = lw_v2(0, 0);
    for (int k = 1; k <= PAIRS; k++) {
        v[PAIRS + k] = w[2*k - 2];
        v[PAIRS - k] = w[2*k - 1];
    }
    for (int i = 0; i <= 2*PAIRS; i++) {
        q->constant += lw_v2_dot(v[i], v[i]);
        for (int k = 0; k < i; k++)
            q->g[i - k] = lw_v2_add(q->g[i - k], lw_v2_unturn(v[i], v[k]));
    }
    for (int m = 1; m <= LW_TERMS; m++)
        q->third += 2.0*m*m*m*sqrt(lw_v2_dot(q->g[m], q->g[m]));
}

/* g and its first two derivatives. */
static void square_at(const square_series *q, double tau, double d[3])
{
    lw_vec2 one = lw_v2_polar(1, tau), turn = one;
    d[0] = q->constant;
    d[1] = d[2] = 0;
    for (int m = 1; m <= LW_TERMS; m++, turn = lw_v2_turn(turn, one)) {
        lw_vec2 t = lw_v2_turn(q->g[m], turn);
        d[0] += 2*t.x;
        d[1] -= 2*m*t.y;
        d[2] -= 2.0*m*m*t.x;
    }
}

/* All tau within `half` of `at`, where g <= `most`. */
typedef struct arc { double at, half, most, d[3]; } arc;

/* Bound g on the arc by its Taylor series with the third derivative in the remainder. */
static arc arc_of(const square_series *q, double at, double half)
{
    arc a = { .at = at, .half = half };
    square_at(q, at, a.d);
    double slope = fabs(a.d[1]), bend = a.d[2], to = half;
    if (bend < 0 && slope < -bend*half)
        to = -slope/bend;
    a.most = a.d[0] + slope*to + 0.5*bend*to*to + q->third*half*half*half/6;
    return a;
}

/* The largest g on an arc where it is concave, by Newton steps that stay on the arc. */
static double climb(const square_series *q, const arc *a, double *tau)
{
    double d[3] = { a->d[0], a->d[1], a->d[2] }, t = a->at, best = d[0];
    *tau = t;
    for (int n = 0; n < 20; n++) {
        double to = fmin(fmax(t - d[1]/d[2], a->at - a->half), a->at + a->half);
        if (fabs(to - t) < 1e-12)
            break;
        t = to;
        square_at(q, t, d);
        if (d[0] > best) {
            best = d[0];
            *tau = t;
        }
    }
    return best;
}

#define ARCS     16       /* the circle starts as so many arcs                                            */
#define ARC_MAX  192
#define LEFT_OUT 1e-13    /* g counts as its largest value when no arc can be this much above it          */

/* F(tau) with the largest |F| if its square exceeds `least`, else (0, 0).  Branch and bound: the arc with the highest
 * bound is halved, or climbed where g is concave on it, until no bound exceeds the best value. */
static lw_vec2 largest(const lw_vec2 *w, double least)
{
    square_series q;
    arc todo[ARC_MAX];
    double best = least, at = NAN, tau;
    int n = ARCS;
    square_series_make(w, &q);
    for (int i = 0; i < ARCS; i++)
        todo[i] = arc_of(&q, (2*i + 1)*LW_PI/ARCS, LW_PI/ARCS);
    while (n > 0) {
        int top = 0;
        for (int i = 1; i < n; i++)
            top = todo[i].most > todo[top].most ? i : top;
        arc a = todo[top];
        if (a.most <= best + LEFT_OUT)
            break;
        todo[top] = todo[--n];
        bool concave = a.d[2] + q.third*a.half < 0;
        double value = a.d[0];
        tau = a.at;
        if (concave)
            value = climb(&q, &a, &tau);
        if (value > best) {
            best = value;
            at = tau;
        }
        for (int i = -1; i <= 1 && !concave; i += 2) {
            arc half = arc_of(&q, a.at + i*0.5*a.half, 0.5*a.half);
            if (half.most > best + LEFT_OUT && n < ARC_MAX)      /* halving ends long before the list is full */
                todo[n++] = half;
        }
    }
    return isnan(at) ? lw_v2(0, 0) : sum_at(w, at);
}

/* The best of all operations if its |F| exceeds `best`; else the distance is infinite. */
static void match_above(const lw_descriptor *target, const lw_descriptor *curve, double best, lw_match *m)
{
    double squares = 0;
    for (int k = 0; k < LW_TERMS; k++)
        squares += lw_v2_dot(target->term[k], target->term[k]) + lw_v2_dot(curve->term[k], curve->term[k]);
    *m = (lw_match){ .distance = INFINITY };
    for (int v = 0; v < 4; v++) {
        lw_vec2 c[LW_TERMS], w[LW_TERMS], f = lw_v2(0, 0);
        bool mirrored = v & 1;
        variant(curve, mirrored, v & 2, c);
        for (int k = 0; k < LW_TERMS; k++) {
            w[k] = lw_v2_unturn(target->term[k], c[k]);        /* a conj b */
            f = lw_v2_add(f, w[k]);
        }
        if (target->closed)
            f = largest(w, best < 0 ? -1 : best*best);
        if (lw_v2_norm(f) > best) {
            best = lw_v2_norm(f);
            *m = (lw_match){ sqrt(fmax(squares - 2*best, 0)), atan2(f.y, f.x), mirrored };
        }
    }
}

void lw_descriptor_match(const lw_descriptor *target, const lw_descriptor *curve, lw_match *m)
{
    match_above(target, curve, -1, m);
}

void lw_matcher_make(const lw_descriptor *target, lw_matcher *m)
{
    m->target = *target;
    m->square = 0;
    for (int k = 0; k < LW_TERMS; k++) {
        m->re[k] = (float)target->term[k].x;
        m->im[k] = (float)target->term[k].y;
        m->square += lw_v2_dot(target->term[k], target->term[k]);
    }
    for (int k = 0; k < PAIRS; k++)
        for (int i = 0; i < STARTS; i++) {
            m->c[k][i] = (float)cos(2*LW_PI*(k + 1)*i/STARTS);
            m->s[k][i] = (float)sin(2*LW_PI*(k + 1)*i/STARTS);
        }
}

/* An upper bound of |F| over all tau, from STARTS values.  Where |F| is largest its derivative is 0, so that the value
 * at the start nearest to that place is less by at most  sum k^2 |w_k| (half the step)^2 / 2. */
static float most_of(const lw_matcher *m, const float *wr, const float *wi)
{
    float fr[STARTS] = { 0 }, fi[STARTS] = { 0 }, best = 0, bend = 0, half = (float)LW_PI/STARTS;
    for (int k = 0; k < PAIRS; k++) {
        float sr = wr[2*k] + wr[2*k + 1], dr = wr[2*k] - wr[2*k + 1];
        float si = wi[2*k] + wi[2*k + 1], di = wi[2*k] - wi[2*k + 1];
        const float *c = m->c[k], *s = m->s[k];
        for (int i = 0; i < STARTS; i++) {
            fr[i] += sr*c[i] - di*s[i];
            fi[i] += si*c[i] + dr*s[i];
        }
        bend += (float)((k + 1)*(k + 1))*(sqrtf(wr[2*k]*wr[2*k] + wi[2*k]*wi[2*k])
                                          + sqrtf(wr[2*k + 1]*wr[2*k + 1] + wi[2*k + 1]*wi[2*k + 1]));
    }
    for (int i = 0; i < STARTS; i++) {
        float v = fr[i]*fr[i] + fi[i]*fi[i];
        best = v > best ? v : best;
    }
    return sqrtf(best) + 0.5f*bend*half*half + 1e-5f;          /* allows for single precision */
}

double lw_matcher_square(const lw_matcher *m, const lw_packed *curve, double limit)
{
    double square = m->square, least;
    float br[LW_TERMS], bi[LW_TERMS], wr[LW_TERMS], wi[LW_TERMS];
    bool near = false;
    for (int k = 0; k < LW_TERMS; k++) {
        double re = curve->re[k]/LW_TERM_ONE, im = curve->im[k]/LW_TERM_ONE;
        square += re*re + im*im;
        br[k] = (float)re;
        bi[k] = (float)im;
    }
    least = 0.5*(square - limit);                              /* |F| that is needed */
    for (int v = 0; v < 4 && !near; v++) {
        int swap = m->target.closed && (v & 2) ? 1 : 0;        /* closed: take c_-k; open: change every other sign */
        float conj = v & 1 ? -1.0f : 1.0f, sr = 0, si = 0;
        for (int k = 0; k < LW_TERMS; k++) {
            float sign = !m->target.closed && (v & 2) && k%2 == 0 ? -1.0f : 1.0f;
            float r = br[k ^ swap]*sign, i = bi[k ^ swap]*conj*sign;
            wr[k] = m->re[k]*r + m->im[k]*i;
            wi[k] = m->im[k]*r - m->re[k]*i;
            sr += wr[k];
            si += wi[k];
        }
        near = (m->target.closed ? most_of(m, wr, wi) : sqrtf(sr*sr + si*si) + 1e-5f) >= least;
    }
    if (!near)
        return INFINITY;
    lw_descriptor d;
    lw_match match;
    lw_descriptor_unpack(curve, m->target.closed, &d);
    match_above(&m->target, &d, fmax(least - 1e-9, -1), &match);
    return match.distance*match.distance;
}

/* ---- a smooth curve through points ----------------------------------------------------------------- */

/* Point between b (t = 0) and c (t = 1) of a spline whose knots are spaced by the square root of the distance. */
static lw_vec2 spline(lw_vec2 a, lw_vec2 b, lw_vec2 c, lw_vec2 d, double t)
{
    double t1 = sqrt(lw_v2_norm(lw_v2_sub(b, a))), t2 = t1 + sqrt(lw_v2_norm(lw_v2_sub(c, b)));
    double t3 = t2 + sqrt(lw_v2_norm(lw_v2_sub(d, c))), at = t1 + t*(t2 - t1);
    lw_vec2 p = lw_v2_add(lw_v2_scale(a, (t1 - at)/t1), lw_v2_scale(b, at/t1));
    lw_vec2 q = lw_v2_add(lw_v2_scale(b, (t2 - at)/(t2 - t1)), lw_v2_scale(c, (at - t1)/(t2 - t1)));
    lw_vec2 r = lw_v2_add(lw_v2_scale(c, (t3 - at)/(t3 - t2)), lw_v2_scale(d, (at - t2)/(t3 - t2)));
    p = lw_v2_add(lw_v2_scale(p, (t2 - at)/t2), lw_v2_scale(q, at/t2));
    q = lw_v2_add(lw_v2_scale(q, (t3 - at)/(t3 - t1)), lw_v2_scale(r, (at - t1)/(t3 - t1)));
    return lw_v2_add(lw_v2_scale(p, (t2 - at)/(t2 - t1)), lw_v2_scale(q, (at - t1)/(t2 - t1)));
}

/* The next point of the row, in direction `by`, that differs from p[i]. Past an open end, the mirror image of `other`.
 */
static lw_vec2 beside(const lw_vec2 *p, size_t n, bool closed, size_t i, int by, lw_vec2 other)
{
    size_t k = i;
    for (size_t tries = 0; tries < n; tries++) {
        if (!closed && (by > 0 ? k + 1 == n : k == 0))
            break;
        k = by > 0 ? (k + 1)%n : (k + n - 1)%n;
        if (p[k].x != p[i].x || p[k].y != p[i].y)
            return p[k];
    }
    return lw_v2_sub(lw_v2_scale(p[i], 2), other);
}

void lw_curve_smooth(const lw_vec2 *p, size_t n, bool closed, lw_vec2 *out, size_t m)
{
    size_t pieces = closed ? n : n - 1;
    for (size_t j = 0; j < m; j++) {
        double at = (double)j*(double)pieces/(double)(closed ? m : m - 1);
        size_t i = (size_t)at < pieces ? (size_t)at : pieces - 1, k = (i + 1)%n;
        if (p[i].x == p[k].x && p[i].y == p[k].y) {
            out[j] = p[i];
            continue;
        }
        out[j] = spline(beside(p, n, closed, i, -1, p[k]), p[i], p[k], beside(p, n, closed, k, 1, p[i]), at - (double)i);
    }
}
