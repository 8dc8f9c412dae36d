#include "catalogues/curves/descriptor.h"

#include <string.h>
#include "base/real.h"

#define SAMPLES LW_DESCRIBER_SAMPLES
#define STARTS  LW_MATCHER_STARTS
#define PAIRS   (LW_TERMS/2)

/* ---- points at even distances ---------------------------------------------------------------------- */

static double length_of(const lw_vec2 *p, size_t n, bool closed)
{
    double length = 0;
    for (size_t i = 0; i + 1 < n + closed; i++) {
        lw_vec2 d = lw_v2_sub(p[i + 1 < n ? i + 1 : 0], p[i]);
        length += sqrt(d.x*d.x + d.y*d.y);
    }
    return length;
}

/* Resample at equal arc lengths. Closed: sample k is at k/SAMPLES of the length; open: in the middle of the k-th of
 * SAMPLES pieces. */
static void resample(const lw_vec2 *p, size_t n, bool closed, double length, double *x, double *y)
{
    double step = length/SAMPLES, next = closed ? 0 : 0.5*step, before = 0;
    size_t k = 0;
    for (size_t i = 0; i + 1 < n + closed && k < SAMPLES; i++) {
        lw_vec2 a = p[i], d = lw_v2_sub(p[i + 1 < n ? i + 1 : 0], a);
        double piece = sqrt(d.x*d.x + d.y*d.y), per = piece > 0 ? 1/piece : 0;
        while (k < SAMPLES && next <= before + piece) {
            double t = (next - before)*per;
            x[k] = a.x + t*d.x;
            y[k] = a.y + t*d.y;
            k++;
            next = (closed ? (double)k : (double)k + 0.5)*step;
        }
        before += piece;
    }
    for (; k < SAMPLES; k++) {                       /* samples that rounding left out at the end */
        x[k] = p[closed ? 0 : n - 1].x;
        y[k] = p[closed ? 0 : n - 1].y;
    }
}

/* ---- coefficients ---------------------------------------------------------------------------------- */

void lw_describer_make(lw_describer *t)
{
    for (int k = 0; k < LW_TERMS; k++)
        for (int i = 0; i < SAMPLES; i++) {
            t->c[k][i] = cos(2*LW_PI*(k + 1)*i/SAMPLES);
            t->half[k][i] = sqrt(2.0)*cos(LW_PI*(k + 1)*(i + 0.5)/SAMPLES);
            if (k < PAIRS)
                t->s[k][i] = sin(2*LW_PI*(k + 1)*i/SAMPLES);
        }
}

/* (1/SAMPLES) sum of v[i] w[i], in four partial sums. */
static double mean_of(const double *v, const double *w)
{
    double s[4] = { 0, 0, 0, 0 };
    for (int i = 0; i < SAMPLES; i += 4)
        for (int k = 0; k < 4; k++)
            s[k] += v[i + k]*w[i + k];
    return ((s[0] + s[1]) + (s[2] + s[3]))/SAMPLES;
}

static void closed_terms(const lw_describer *t, const double *x, const double *y, lw_vec2 *term)
{
    for (int k = 0; k < PAIRS; k++) {
        double xc = mean_of(x, t->c[k]), xs = mean_of(x, t->s[k]), yc = mean_of(y, t->c[k]), ys = mean_of(y, t->s[k]);
        term[2*k] = lw_v2(xc + ys, yc - xs);
        term[2*k + 1] = lw_v2(xc - ys, yc + xs);
    }
}

static void open_terms(const lw_describer *t, const double *x, const double *y, lw_vec2 *term)
{
    for (int k = 0; k < LW_TERMS; k++)
        term[k] = lw_v2(mean_of(x, t->half[k]), mean_of(y, t->half[k]));
}

lw_status lw_descriptor_make(const lw_describer *t, const lw_vec2 *p, size_t n, bool closed, lw_descriptor *d)
{
    double x[SAMPLES], y[SAMPLES], length, square = 0;
    if (n < 2 || !isfinite(length = length_of(p, n, closed)) || !(length > 0))
        return LW_E_ARG;
    resample(p, n, closed, length, x, y);
    *d = (lw_descriptor){ .closed = closed };
    for (int i = 0; i < SAMPLES; i++) {
        d->centre.x += x[i]/SAMPLES;
        d->centre.y += y[i]/SAMPLES;
    }
    for (int i = 0; i < SAMPLES; i++) {
        x[i] -= d->centre.x;
        y[i] -= d->centre.y;
        square += (x[i]*x[i] + y[i]*y[i])/SAMPLES;
    }
    d->size = sqrt(square);
    if (!(d->size > 1e-9*length))
        return LW_E_ARG;
    (closed ? closed_terms : open_terms)(t, x, y, d->term);
    for (int k = 0; k < LW_TERMS; k++)
        d->term[k] = lw_v2_scale(d->term[k], 1/d->size);
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

/* F(tau) = sum of w_k e^{i k tau} and its first two derivatives; w in the order of the terms. */
static void series(const lw_vec2 *w, double tau, lw_vec2 f[3])
{
    lw_vec2 one = lw_v2_polar(1, tau), turn = one;              /* e^{i k tau} */
    f[0] = f[1] = f[2] = lw_v2(0, 0);
    for (int k = 1; k <= PAIRS; k++, turn = lw_v2_turn(turn, one)) {
        lw_vec2 a = lw_v2_turn(w[2*k - 2], turn), b = lw_v2_unturn(w[2*k - 1], turn);
        lw_vec2 sum = lw_v2_add(a, b), difference = lw_v2_sub(a, b);
        f[0] = lw_v2_add(f[0], sum);
        f[1] = lw_v2_add(f[1], lw_v2_scale(lw_v2_perp(difference), k));
        f[2] = lw_v2_sub(f[2], lw_v2_scale(sum, (double)k*k));
    }
}

/* |F(tau)|^2 for the unit vector e^{i tau}. */
static double square_at(const lw_vec2 *w, lw_vec2 one)
{
    lw_vec2 turn = one, f = lw_v2(0, 0);
    for (int k = 0; k < LW_TERMS; k += 2, turn = lw_v2_turn(turn, one))
        f = lw_v2_add(f, lw_v2_add(lw_v2_turn(w[k], turn), lw_v2_unturn(w[k + 1], turn)));
    return lw_v2_dot(f, f);
}

/* F(tau) with the largest |F|: Newton steps from the starts that are higher than both neighbours. */
static lw_vec2 largest(const lw_vec2 *w)
{
    double at[2*STARTS], limit = LW_PI/STARTS, highest = 0;
    lw_vec2 f[3], best = lw_v2(0, 0), step = lw_v2_polar(1, limit), one = lw_v2(1, 0);
    for (int i = 0; i < 2*STARTS; i++, one = lw_v2_turn(one, step)) {
        at[i] = square_at(w, one);
        highest = fmax(highest, at[i]);
    }
    for (int i = 0; i < 2*STARTS; i++) {
        double before = at[(i + 2*STARTS - 1)%(2*STARTS)], after = at[(i + 1)%(2*STARTS)], tau = i*limit;
        /* |F| grows by less than this factor between two starts */
        if (at[i] < before || at[i] < after || at[i] < 0.8*highest)
            continue;
        series(w, tau, f);
        for (int n = 0; n < 8; n++) {
            double slope = lw_v2_dot(f[0], f[1]), bend = lw_v2_dot(f[1], f[1]) + lw_v2_dot(f[0], f[2]);
            double move = bend < 0 ? -slope/bend : copysign(limit, slope);
            tau += fmin(fmax(move, -limit), limit);
            series(w, tau, f);
        }
        if (lw_v2_dot(f[0], f[0]) > lw_v2_dot(best, best))
            best = f[0];
    }
    return best;
}

void lw_descriptor_match(const lw_descriptor *target, const lw_descriptor *curve, lw_match *m)
{
    double squares = 0, best = -1;
    for (int k = 0; k < LW_TERMS; k++)
        squares += lw_v2_dot(target->term[k], target->term[k]) + lw_v2_dot(curve->term[k], curve->term[k]);
    *m = (lw_match){ .distance = sqrt(squares) };
    for (int v = 0; v < 4; v++) {
        lw_vec2 c[LW_TERMS], w[LW_TERMS], f = lw_v2(0, 0);
        bool mirrored = v & 1;
        variant(curve, mirrored, v & 2, c);
        for (int k = 0; k < LW_TERMS; k++) {
            w[k] = lw_v2_unturn(target->term[k], c[k]);        /* a conj b */
            f = lw_v2_add(f, w[k]);
        }
        if (target->closed)
            f = largest(w);
        if (lw_v2_norm(f) > best) {
            best = lw_v2_norm(f);
            *m = (lw_match){ sqrt(fmax(squares - 2*best, 0)), atan2(f.y, f.x), mirrored };
        }
    }
}

void lw_matcher_make(const lw_descriptor *target, lw_matcher *m)
{
    m->closed = target->closed;
    m->square = 0;
    for (int k = 0; k < LW_TERMS; k++) {
        m->re[k] = (float)target->term[k].x;
        m->im[k] = (float)target->term[k].y;
        m->square += m->re[k]*m->re[k] + m->im[k]*m->im[k];
    }
    for (int k = 0; k < PAIRS; k++)
        for (int i = 0; i < STARTS; i++) {
            m->c[k][i] = (float)cos(2*LW_PI*(k + 1)*i/STARTS);
            m->s[k][i] = (float)sin(2*LW_PI*(k + 1)*i/STARTS);
        }
}

/* The largest |F|^2 over the starts, from w_k and w_-k. */
static float largest_start(const lw_matcher *m, const float *wr, const float *wi)
{
    float fr[STARTS] = { 0 }, fi[STARTS] = { 0 }, best = 0;
    for (int k = 0; k < PAIRS; k++) {
        float sr = wr[2*k] + wr[2*k + 1], dr = wr[2*k] - wr[2*k + 1];
        float si = wi[2*k] + wi[2*k + 1], di = wi[2*k] - wi[2*k + 1];
        const float *c = m->c[k], *s = m->s[k];
        for (int i = 0; i < STARTS; i++) {
            fr[i] += sr*c[i] - di*s[i];
            fi[i] += si*c[i] + dr*s[i];
        }
    }
    for (int i = 0; i < STARTS; i++) {
        float v = fr[i]*fr[i] + fi[i]*fi[i];
        best = v > best ? v : best;
    }
    return best;
}

float lw_matcher_square(const lw_matcher *m, const lw_packed *curve)
{
    float square = m->square, best = 0;
    float br[LW_TERMS], bi[LW_TERMS], wr[LW_TERMS], wi[LW_TERMS];
    for (int k = 0; k < LW_TERMS; k++) {
        br[k] = curve->re[k]*(float)(1/LW_TERM_ONE);
        bi[k] = curve->im[k]*(float)(1/LW_TERM_ONE);
        square += br[k]*br[k] + bi[k]*bi[k];
    }
    for (int v = 0; v < 4; v++) {
        int swap = m->closed && (v & 2) ? 1 : 0;               /* closed: take c_-k; open: change every other sign */
        float conj = v & 1 ? -1.0f : 1.0f, value = 0, sr = 0, si = 0;
        for (int k = 0; k < LW_TERMS; k++) {
            float sign = !m->closed && (v & 2) && k%2 == 0 ? -1.0f : 1.0f;
            float r = br[k ^ swap]*sign, i = bi[k ^ swap]*conj*sign;
            wr[k] = m->re[k]*r + m->im[k]*i;
            wi[k] = m->im[k]*r - m->re[k]*i;
            sr += wr[k];
            si += wi[k];
        }
        value = m->closed ? largest_start(m, wr, wi) : sr*sr + si*si;
        best = value > best ? value : best;
    }
    float d = square - 2*sqrtf(best);
    return d > 0 ? d : 0;
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
        out[j] = spline(beside(p, n, closed, i, -1, p[k]), p[i], p[k], beside(p, n, closed, k, 1, p[i]),
                        at - (double)i);
    }
}
