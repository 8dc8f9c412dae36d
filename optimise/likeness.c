#include "optimise/likeness.h"

#include <math.h>

enum { N = LW_LIKENESS_POINTS };

/* A polyline: points, or the stations of a target. */
typedef struct polyline { const lw_vec2 *p; const lw_target *t; size_t n; } polyline;

static lw_vec2 corner(const polyline *l, size_t i)
{
    i %= l->n;
    return l->p ? l->p[i] : lw_v2(l->t->x[i], l->t->y[i]);
}

/* N points at equal steps along it; of an open one both ends, of a closed one no end twice. */
static bool resample(const polyline *l, bool closed, lw_vec2 out[N])
{
    double total = 0, along = 0;
    size_t last = closed ? l->n : l->n - 1, k = 0;
    for (size_t i = 0; i < last; i++)
        total += lw_v2_norm(lw_v2_sub(corner(l, i + 1), corner(l, i)));
    if (!(total > 0))
        return false;
    for (int j = 0; j < N; j++) {
        double want = total*j/(closed ? N : N - 1), step;
        lw_vec2 d;
        for (;; k++) {
            d = lw_v2_sub(corner(l, k + 1), corner(l, k));
            step = lw_v2_norm(d);
            if (along + step >= want || k + 1 >= last)
                break;
            along += step;
        }
        double share = step > 0 ? fmin(1, (want - along)/step) : 0;
        out[j] = lw_v2_add(corner(l, k), lw_v2_scale(d, share));
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

/* Mean distance of equal ranks, a's rank i beside b's `first` + sense*i. */
static double in_order(const lw_vec2 a[N], const lw_vec2 b[N], int first, int sense)
{
    double sum = 0;
    for (int i = 0; i < N; i++)
        sum += lw_v2_norm(lw_v2_sub(a[i], b[((first + sense*i) % N + N) % N]));
    return sum/N;
}

void lw_likeness_measure(const lw_target *t, const lw_vec2 *curve, size_t n, lw_likeness *out)
{
    lw_vec2 want[N], have[N];
    *out = (lw_likeness){ NAN, NAN, NAN, NAN };
    if (!resample(&(polyline){ NULL, t, t->n }, t->closed, want)
        || !resample(&(polyline){ curve, NULL, n }, t->closed, have))
        return;
    double radius = rms_radius(want), best = INFINITY;
    out->to_curve = nearest(want, have, t->closed)/radius;
    out->to_target = nearest(have, want, t->closed)/radius;
    out->chamfer = 0.5*(out->to_curve + out->to_target);
    for (int first = 0; first < (t->closed ? N : 1); first++) {
        best = fmin(best, in_order(want, have, first, 1));
        best = fmin(best, in_order(want, have, t->closed ? first : N - 1, -1));
    }
    out->ordered = best/radius;
}
