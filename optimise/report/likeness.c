#include "optimise/report/likeness.h"

#include <stdlib.h>
#include "base/real.h"

enum { N = LW_LIKENESS_POINTS, PIECES = 8 };
#define CORNER 0.7              /* a target that turns more than this at a station has a corner there [rad] */

/* ---- the curve of a target ---------------------------------------------------------------------------- */

static lw_vec2 station(const lw_target *t, size_t i)
{
    i %= t->n;
    return lw_v2(t->x[i], t->y[i]);
}

static lw_vec2 unit(lw_vec2 a)
{
    double l = lw_v2_norm(a);
    return l > 0 ? lw_v2_scale(a, 1/l) : a;
}

/* Direction of the curve at a station: that of the circle through it and its neighbours, along a/a^2 + b/b^2; (0, 0)
 * at corners, ends, and where two stations are one. */
static lw_vec2 tangent(const lw_target *t, size_t i)
{
    static const lw_vec2 none = { 0, 0 };
    if (!t->closed && (i == 0 || i + 1 == t->n))
        return none;
    lw_vec2 a = lw_v2_sub(station(t, i), station(t, i + t->n - 1)), b = lw_v2_sub(station(t, i + 1), station(t, i));
    double a2 = lw_v2_dot(a, a), b2 = lw_v2_dot(b, b);
    if (!(a2 > 0 && b2 > 0) || lw_v2_dot(a, b) < cos(CORNER)*sqrt(a2*b2))
        return none;
    return unit(lw_v2_add(lw_v2_scale(a, 1/a2), lw_v2_scale(b, 1/b2)));
}

static bool is_none(lw_vec2 a) { return a.x == 0 && a.y == 0; }

/* Direction of an arc with chord d at its other end. */
static lw_vec2 mirrored(lw_vec2 tangent, lw_vec2 d)
{
    lw_vec2 along = unit(d);
    return lw_v2_sub(lw_v2_scale(along, 2*lw_v2_dot(along, tangent)), tangent);
}

/* PIECES points from station i up to the next, without that: on a cubic with the directions at both (Hermite); on an
 * arc at a corner or an end; on a line between two of these. */
static void span(const lw_target *t, size_t i, lw_vec2 out[PIECES])
{
    lw_vec2 p = station(t, i), d = lw_v2_sub(station(t, i + 1), p), u = tangent(t, i), v = tangent(t, (i + 1) % t->n);
    if (is_none(u) && is_none(v))
        u = v = unit(d);
    else if (is_none(u))
        u = mirrored(v, d);
    else if (is_none(v))
        v = mirrored(u, d);
    double l = lw_v2_norm(d);
    for (int k = 0; k < PIECES; k++) {
        double s = (double)k/PIECES, r = 1 - s;
        lw_vec2 bend = lw_v2_add(lw_v2_scale(u, l*s*r*r), lw_v2_scale(v, -l*s*s*r));
        out[k] = lw_v2_add(lw_v2_add(p, lw_v2_scale(d, s*s*(3 - 2*s))), bend);
    }
}

/* The curve drawn through the stations; *n points.  NULL: no memory.  Free with free(). */
static lw_vec2 *curve_of(const lw_target *t, size_t *n)
{
    size_t spans = t->closed ? t->n : t->n - 1;
    lw_vec2 *p = malloc(sizeof *p*(spans*PIECES + 1));
    *n = spans*PIECES + !t->closed;
    for (size_t i = 0; p && i < spans; i++)
        span(t, i, p + i*PIECES);
    if (p && !t->closed)
        p[spans*PIECES] = station(t, t->n - 1);
    return p;
}

/* ---- distances ------------------------------------------------------------------------------------------ */

/* `most` points at equal steps along a polyline, with both ends of an open one; of a closed one no point twice. */
static bool resample(const lw_vec2 *p, size_t n, bool closed, int most, lw_vec2 *out)
{
    double total = 0, done = 0;
    size_t last = closed ? n : n - 1, k = 0;
    for (size_t i = 0; i < last; i++)
        total += lw_v2_norm(lw_v2_sub(p[(i + 1) % n], p[i]));
    if (!(total > 0))
        return false;
    for (int j = 0; j < most; j++) {
        double along = total*j/(closed ? most : most - 1), step;
        lw_vec2 d;
        for (;; k++) {
            d = lw_v2_sub(p[(k + 1) % n], p[k % n]);
            step = lw_v2_norm(d);
            if (done + step >= along || k + 1 >= last)
                break;
            done += step;
        }
        double part = step > 0 ? fmin(1, (along - done)/step) : 0;
        out[j] = lw_v2_add(p[k % n], lw_v2_scale(d, part));
    }
    return true;
}

static double rms_radius(const lw_vec2 p[N])
{
    lw_vec2 mean = { 0, 0 };
    double sum = 0;
    for (int i = 0; i < N; i++)
        mean = lw_v2_add(mean, lw_v2_scale(p[i], 1.0/N));
    for (int i = 0; i < N; i++)
        sum += pow(lw_v2_norm(lw_v2_sub(p[i], mean)), 2);
    return sqrt(sum/N);
}

/* Mean distance from the points of a to the polyline through those of b. */
static double nearest(const lw_vec2 a[N], const lw_vec2 b[N], bool closed)
{
    double sum = 0;
    for (int i = 0; i < N; i++) {
        double least = INFINITY;
        for (int j = 0; j < (closed ? N : N - 1); j++)
            least = fmin(least, lw_v2_segment_distance(a[i], b[j], b[(j + 1) % N]));
        sum += least;
    }
    return sum/N;
}

/* Mean distance of points of equal rank: rank i of a and rank `first` + sense*i of b. */
static double in_order(const lw_vec2 a[N], const lw_vec2 b[N], int first, int sense)
{
    double sum = 0;
    for (int i = 0; i < N; i++)
        sum += lw_v2_norm(lw_v2_sub(a[i], b[((first + sense*i) % N + N) % N]));
    return sum/N;
}

lw_status lw_likeness_measure(const lw_target *t, const lw_vec2 *curve, size_t n, lw_likeness *out)
{
    lw_vec2 target[N], found[N];
    size_t n_drawn;
    lw_vec2 *drawn = curve_of(t, &n_drawn);
    *out = (lw_likeness){ NAN, NAN, NAN, NAN };
    bool there = drawn && resample(drawn, n_drawn, t->closed, N, target) && resample(curve, n, t->closed, N, found);
    free(drawn);
    if (!there)
        return drawn ? LW_OK : LW_E_MEMORY;
    double radius = rms_radius(target), best = INFINITY;
    out->to_curve = nearest(target, found, t->closed)/radius;
    out->to_target = nearest(found, target, t->closed)/radius;
    out->chamfer = 0.5*(out->to_curve + out->to_target);
    for (int first = 0; first < (t->closed ? N : 1); first++) {
        best = fmin(best, in_order(target, found, first, 1));
        best = fmin(best, in_order(target, found, t->closed ? first : N - 1, -1));
    }
    out->ordered = best/radius;
    return LW_OK;
}

static double distance_to(const lw_vec2 *line, size_t n, bool closed, lw_vec2 p)
{
    double least = INFINITY;
    for (size_t j = 0; j + !closed < n; j++)
        least = fmin(least, lw_v2_segment_distance(p, line[j], line[(j + 1) % n]));
    return least;
}

lw_stray lw_likeness_stray(const lw_target *t, const lw_vec2 *curve, size_t n)
{
    lw_stray stray = { 0, 0 };
    size_t n_drawn;
    lw_vec2 *drawn = curve_of(t, &n_drawn);
    if (!drawn)
        return (lw_stray){ NAN, NAN };
    for (size_t i = 0; i < t->n; i++)
        stray.to_curve = fmax(stray.to_curve, distance_to(curve, n, t->closed, station(t, i)));
    for (size_t i = 0; i < n; i++)
        stray.to_target = fmax(stray.to_target, distance_to(drawn, n_drawn, t->closed, curve[i]));
    free(drawn);
    return stray;
}
