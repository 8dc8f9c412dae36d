#include "optimise/report/likeness.h"

#include <stdlib.h>
#include "base/real.h"

enum { N = LW_LIKENESS_POINTS, PIECES = 8 };
#define CORNER 0.7              /* a target that turns more than this at a station has a corner there [rad] */
#define LONGER 4                /* a chord so many times longer than its neighbour is a straight line that an arc touches */

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

/* Direction of the curve at a station: that of the circle through it and its neighbours, along a/a^2 + b/b^2, or of a chord
 * much longer than the other; (0, 0) at corners, ends, and where two stations are one. */
static lw_vec2 tangent(const lw_target *t, size_t i)
{
    static const lw_vec2 none = { 0, 0 };
    if (!t->closed && (i == 0 || i + 1 == t->n))
        return none;
    lw_vec2 a = lw_v2_sub(station(t, i), station(t, i + t->n - 1)), b = lw_v2_sub(station(t, i + 1), station(t, i));
    double a2 = lw_v2_dot(a, a), b2 = lw_v2_dot(b, b);
    if (!(a2 > 0 && b2 > 0) || lw_v2_dot(a, b) < cos(CORNER)*sqrt(a2*b2))
        return none;
    if (fmax(a2, b2) > LONGER*LONGER*fmin(a2, b2))
        return unit(a2 > b2 ? a : b);
    return unit(lw_v2_add(lw_v2_scale(a, 1/a2), lw_v2_scale(b, 1/b2)));
}

/* Height over its chord of an arc that turns as the target does at a station; its chord is the longer of the two there.  0 at ends. */
static double arc_height(const lw_target *t, size_t i)
{
    if (!t->closed && (i == 0 || i + 1 == t->n))
        return 0;
    lw_vec2 a = lw_v2_sub(station(t, i), station(t, i + t->n - 1)), b = lw_v2_sub(station(t, i + 1), station(t, i));
    double turn = atan2(fabs(lw_v2_cross(a, b)), lw_v2_dot(a, b));
    return 0.5*fmax(lw_v2_norm(a), lw_v2_norm(b))*tan(0.25*turn);
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
            least = lw_v2_nearer(a[i], b[j], b[(j + 1) % N], least);
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

/* Runs of segments of a polyline, with a box around each: of most runs it says enough. */
typedef struct runs {
    const lw_vec2 *line;
    size_t n, n_segment, size, n_run;
    size_t near;                   /* the segment that was nearest to the last point                    */
    struct { lw_vec2 low, high; } *box;
} runs;

static bool make_runs(const lw_vec2 *line, size_t n, bool closed, runs *r)
{
    *r = (runs){ .line = line, .n = n, .n_segment = n - !closed, .size = 1 + (size_t)sqrt((double)n) };
    r->n_run = (r->n_segment + r->size - 1)/r->size;
    r->box = malloc(sizeof *r->box*(r->n_run + 1));
    for (size_t j = 0; r->box && j <= r->n_segment; j++) {       /* the end of a run is the start of the next */
        lw_vec2 p = line[j % n];
        size_t k = j/r->size, first = j % r->size == 0;
        for (size_t b = k - (first && k > 0); b <= k && b < r->n_run; b++) {
            bool fresh = j == b*r->size;
            r->box[b].low = fresh ? p : lw_v2(fmin(r->box[b].low.x, p.x), fmin(r->box[b].low.y, p.y));
            r->box[b].high = fresh ? p : lw_v2(fmax(r->box[b].high.x, p.x), fmax(r->box[b].high.y, p.y));
        }
    }
    return r->box;
}

/* The greatest distance from n points to the polyline, or `most` if that is greater. */
static double farthest(runs *r, const lw_vec2 *p, size_t n, double most)
{
    for (size_t i = 0; i < n; i++) {
        size_t first = r->near/r->size;
        double least = lw_v2_nearer(p[i], r->line[r->near], r->line[(r->near + 1) % r->n], INFINITY);
        for (size_t k = 0; k < r->n_run && least > most; k++) {
            size_t b = (first + k) % r->n_run;
            double dx = fmax(fmax(r->box[b].low.x - p[i].x, p[i].x - r->box[b].high.x), 0);
            double dy = fmax(fmax(r->box[b].low.y - p[i].y, p[i].y - r->box[b].high.y), 0);
            size_t end = (b + 1)*r->size;
            if ((1 - 1e-12)*(dx*dx + dy*dy) >= least*least)
                continue;
            for (size_t j = b*r->size; j < end && j < r->n_segment; j++) {
                double before = least;
                least = lw_v2_nearer(p[i], r->line[j], r->line[(j + 1) % r->n], least);
                r->near = least < before ? j : r->near;
            }
        }
        most = fmax(most, least);
    }
    return most;
}

lw_stray lw_likeness_stray(const lw_target *t, const lw_vec2 *curve, size_t n)
{
    lw_stray stray = { NAN, NAN, NAN };
    size_t n_drawn;
    lw_vec2 *drawn = curve_of(t, &n_drawn);
    runs found = { 0 }, wanted = { 0 };
    if (drawn && make_runs(curve, n, t->closed, &found) && make_runs(drawn, n_drawn, t->closed, &wanted)) {
        stray = (lw_stray){ 0, farthest(&wanted, curve, n, 0), lw_target_arc(t) };
        for (size_t i = 0; i < t->n; i++) {
            lw_vec2 p = station(t, i);
            stray.to_curve = farthest(&found, &p, 1, stray.to_curve);
            stray.unsure = fmax(stray.unsure, 2*arc_height(t, i));
        }
    }
    free(found.box);
    free(wanted.box);
    free(drawn);
    return stray;
}
