/* Places along a curve: stations by length and curvature; smoothing of noisy points. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "base/vector.h"
#include "optimise/task/target_internal.h"
#include "optimise/task/target_outline_internal.h"
#include "optimise/task/target_tour.h"

#define CORNER (30*LW_PI/180)         /* least turn of a corner; drawn arcs turn by less at each of their points */

/* ---- stations ------------------------------------------------------------------------------------------------ */

/* The segments of a polygon, and its corners. */
typedef struct polyline {
    const lw_vec2 *p;
    size_t         n, n_segment;
    double        *measure;           /* of each segment, in stations: length and turn               (n_segment)  */
    size_t        *corner;            /* stations are spread between these points; ends of an open curve (n_corner) */
    size_t         n_corner;
    bool           closed;
} polyline;

static lw_vec2 segment(const polyline *c, size_t i) { return lw_v2_sub(c->p[(i + 1) % c->n], c->p[i % c->n]); }

/* Turn of the direction at a point; 0 at the ends of an open curve [rad, > 0]. */
static double turn_at(const polyline *c, size_t i)
{
    if (!c->closed && (i == 0 || i + 1 == c->n))
        return 0;
    lw_vec2 a = segment(c, i + c->n - 1), b = segment(c, i);
    return fabs(atan2(lw_v2_cross(a, b), lw_v2_dot(a, b)));
}

static void find_corners(polyline *c, size_t most)
{
    size_t n = 0;
    for (size_t i = 0; i < c->n; i++)
        if ((!c->closed && (i == 0 || i + 1 == c->n)) || turn_at(c, i) >= CORNER)
            n++;
    bool all = n <= most;                           /* more of them are noise, or a shape of a few long sides */
    c->n_corner = 0;
    for (size_t i = 0; i < c->n; i++)
        if ((!c->closed && (i == 0 || i + 1 == c->n)) || (all && turn_at(c, i) >= CORNER))
            c->corner[c->n_corner++] = i;
    if (c->n_corner == 0)
        c->corner[c->n_corner++] = 0;
}

/* Measure the segments. Turns at corners do not count, since corners are stations anyway. */
static void measure(polyline *c, bool by_curvature)
{
    double length = 0, turn = 0;
    for (size_t i = 0, k = 0; i < c->n; i++) {
        bool corner = k < c->n_corner && c->corner[k] == i;
        double t = !by_curvature || (corner && turn_at(c, i) >= CORNER) ? 0 : turn_at(c, i);
        k += corner;
        turn += t;
        double before = lw_v2_norm(segment(c, i + c->n - 1)), after = lw_v2_norm(segment(c, i));
        if (t > 0) {
            c->measure[i] += t*after/(before + after);
            c->measure[(i + c->n - 1) % c->n] += t*before/(before + after);
        }
        length += i < c->n_segment ? after : 0;
    }
    turn = fmax(turn, LW_PI);                       /* a nearly straight curve is spread by its length */
    for (size_t i = 0; i < c->n_segment; i++)
        c->measure[i] = c->measure[i]/turn + 2*lw_v2_norm(segment(c, i))/length;
}

static double span_measure(const polyline *c, size_t first, size_t last)
{
    double sum = 0;
    for (size_t i = first; i < last; i++)
        sum += c->measure[i % c->n];
    return sum;
}

/* Put `parts` stations at equal steps of the measure from point `first` on; the point `last` is not one of them. */
static void put_span(const polyline *c, size_t first, size_t last, size_t parts, lw_vec2 *out, size_t *from)
{
    double all = span_measure(c, first, last), before = 0;
    size_t at = first;
    for (size_t i = 0; i < parts; i++) {
        double goal = all*(double)i/(double)parts;
        while (at + 1 < last && before + c->measure[at % c->n] < goal)
            before += c->measure[at++ % c->n];
        double step = c->measure[at % c->n], u = step > 0 ? fmax(0, fmin(1, (goal - before)/step)) : 0;
        out[i] = lw_v2_add(c->p[at % c->n], lw_v2_scale(segment(c, at), u));
        from[i] = at % c->n;
    }
}

lw_status lw_resample(const lw_vec2 *p, size_t n, bool closed, bool by_curvature, size_t m, lw_vec2 *out, size_t *from, lw_error *e)
{
    polyline c = { .p = p, .n = n, .n_segment = closed ? n : n - 1, .closed = closed };
    size_t at = 0, parts = closed ? m : m - 1;
    c.measure = calloc(n, sizeof *c.measure);
    c.corner = malloc((n + 1)*sizeof *c.corner);
    if (!c.measure || !c.corner) {
        free(c.measure);
        free(c.corner);
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a curve");
    }
    find_corners(&c, m/3 + 1);
    measure(&c, by_curvature);
    size_t spans = closed ? c.n_corner : c.n_corner - 1, first = c.corner[0];
    c.corner[c.n_corner] = first + n;
    double done = 0, all = span_measure(&c, first, closed ? first + n : n - 1);
    for (size_t i = 0, shared = 0; i < spans; i++) {      /* each span gets one station, and its share of the others */
        done += span_measure(&c, c.corner[i], c.corner[i+1]);
        size_t upto = i + 1 == spans ? parts - spans : (size_t)lround((double)(parts - spans)*done/all);
        put_span(&c, c.corner[i], c.corner[i+1], 1 + upto - shared, out + at, from + at);
        at += 1 + upto - shared;
        shared = upto;
    }
    if (!closed) {
        out[at] = p[n - 1];
        from[at] = n - 1;
    }
    free(c.measure);
    free(c.corner);
    return LW_OK;
}

/* ---- smoothing ----------------------------------------------------------------------------------------------- */

/* Second derivatives g of a smoothing spline at its n knots: (R + lambda Q^T Q) g = Q^T y, and the points move by
 * -lambda Q g (Reinsch 1967, eq. 11 to 14). The matrix has five diagonals; those of a closed curve go round, so its
 * last two unknowns are eliminated at the end. An open curve has no unknowns at its ends. */
typedef struct spline {
    size_t  n, m, k;                  /* knots; unknowns; those with a banded matrix                              */
    bool    closed;
    double *x, *y, *h;                /* knots, chords to the next one                                     (n)    */
    double *d0, *d1, *d2, *D, *l1, *l2, *g[2], *border[2], *move[2];          /*                          (n) each */
    double  memory[];
} spline;

static spline *make_spline(size_t n, bool closed)
{
    spline *s = calloc(1, sizeof *s + 15*n*sizeof(double));
    if (!s)
        return NULL;
    double **array[] = { &s->x, &s->y, &s->h, &s->d0, &s->d1, &s->d2, &s->D, &s->l1, &s->l2, &s->g[0], &s->g[1],
                         &s->border[0], &s->border[1], &s->move[0], &s->move[1] };
    for (size_t i = 0; i < 15; i++)
        *array[i] = s->memory + i*n;
    s->n = n;
    s->m = closed ? n : n - 2;
    s->k = n - 2;
    s->closed = closed;
    return s;
}

/* Row i of Q^T: its coefficients at the knots i - 1, i, i + 1, where i is the knot of an unknown. */
static void row(const spline *s, size_t unknown, double c[3], size_t at[3])
{
    size_t i = unknown + !s->closed;
    for (size_t k = 0; k < 3; k++)
        at[k] = (i + s->n + k - 1) % s->n;
    c[0] = 1/s->h[at[0]];
    c[2] = 1/s->h[at[1]];
    c[1] = -c[0] - c[2];
}

static void assemble(spline *s, double lambda)
{
    double a[3], b[3], c[3];
    size_t at[3], next[3];
    for (size_t i = 0; i < s->m; i++) {
        row(s, i, a, at);
        row(s, (i + 1) % s->m, b, next);
        double h0 = s->h[at[0]], h1 = s->h[at[1]];
        s->d0[i] = (h0 + h1)/3 + lambda*(a[0]*a[0] + a[1]*a[1] + a[2]*a[2]);
        s->d1[i] = h1/6 + lambda*(a[1]*b[0] + a[2]*b[1]);
        row(s, (i + 2) % s->m, c, next);
        s->d2[i] = lambda*a[2]*c[0];
        s->g[0][i] = a[0]*s->x[at[0]] + a[1]*s->x[at[1]] + a[2]*s->x[at[2]];
        s->g[1][i] = a[0]*s->y[at[0]] + a[1]*s->y[at[1]] + a[2]*s->y[at[2]];
    }
}

static void solve_band(const spline *s, double *b)
{
    size_t k = s->k;
    for (size_t i = 0; i < k; i++)
        b[i] -= (i > 0 ? s->l1[i-1]*b[i-1] : 0) + (i > 1 ? s->l2[i-2]*b[i-2] : 0);
    for (size_t i = 0; i < k; i++)
        b[i] /= s->D[i];
    for (size_t i = k; i-- > 0;)
        b[i] -= (i + 1 < k ? s->l1[i]*b[i+1] : 0) + (i + 2 < k ? s->l2[i]*b[i+2] : 0);
}

static void solve(spline *s)
{
    size_t k = s->k, m = s->m;
    for (size_t i = 0; i < k; i++) {
        s->D[i] = s->d0[i] - (i > 0 ? s->l1[i-1]*s->l1[i-1]*s->D[i-1] : 0)
                - (i > 1 ? s->l2[i-2]*s->l2[i-2]*s->D[i-2] : 0);
        s->l1[i] = (s->d1[i] - (i > 0 ? s->l2[i-1]*s->D[i-1]*s->l1[i-1] : 0))/s->D[i];
        s->l2[i] = s->d2[i]/s->D[i];
    }
    solve_band(s, s->g[0]);
    solve_band(s, s->g[1]);
    if (!s->closed)
        return;
    /* columns of the unknowns m - 2 and m - 1 in the rows of the others */
    double *u = s->border[0], *v = s->border[1], cu[4] = { s->d2[m-2], 0, s->d2[m-4], s->d1[m-3] },
           cv[4] = { s->d1[m-1], s->d2[m-1], 0, s->d2[m-3] };
    size_t at[4] = { 0, 1, k - 2, k - 1 };
    memset(u, 0, m*sizeof *u);
    memset(v, 0, m*sizeof *v);
    for (int i = 0; i < 4; i++) {
        u[at[i]] += cu[i];
        v[at[i]] += cv[i];
    }
    solve_band(s, u);
    solve_band(s, v);
    double a = s->d0[m-2], b = s->d1[m-2], d = s->d0[m-1];
    for (int i = 0; i < 4; i++) {
        a -= cu[i]*u[at[i]];
        b -= cu[i]*v[at[i]];
        d -= cv[i]*v[at[i]];
    }
    for (int side = 0; side < 2; side++) {
        double *g = s->g[side], p = g[m-2], q = g[m-1];
        for (int i = 0; i < 4; i++) {
            p -= cu[i]*g[at[i]];
            q -= cv[i]*g[at[i]];
        }
        g[m-2] = (d*p - b*q)/(a*d - b*b);
        g[m-1] = (a*q - b*p)/(a*d - b*b);
        for (size_t i = 0; i < k; i++)
            g[i] -= u[i]*g[m-2] + v[i]*g[m-1];
    }
}

/* Greatest distance that a knot moves; infinite if the equations cannot be solved. */
static double smooth_by(spline *s, double lambda)
{
    double c[3], most = 0;
    size_t at[3];
    assemble(s, lambda);
    solve(s);
    memset(s->move[0], 0, s->n*sizeof(double));
    memset(s->move[1], 0, s->n*sizeof(double));
    for (size_t i = 0; i < s->m; i++) {
        row(s, i, c, at);
        for (int k = 0; k < 3; k++) {
            s->move[0][at[k]] -= lambda*c[k]*s->g[0][i];
            s->move[1][at[k]] -= lambda*c[k]*s->g[1][i];
        }
    }
    for (size_t i = 0; i < s->n; i++) {
        double d = hypot(s->move[0][i], s->move[1][i]);
        most = isfinite(d) ? fmax(most, d) : INFINITY;
    }
    return most;
}

/* The greatest smoothing that keeps the distance. */
static void find_smoothing(spline *s, double distance)
{
    double h = 0, low = 0, high;
    for (size_t i = 0; i < s->n; i++)
        h += s->h[i]/(double)s->n;
    for (high = 1e-6*h*h*h; high < 1e15*h*h*h && smooth_by(s, high) <= distance; high *= 10)
        low = high;
    for (int i = 0; i < 40 && low < high*(1 - 1e-9); i++) {
        double middle = low > 0 ? sqrt(low*high) : high/2;
        if (smooth_by(s, middle) <= distance)
            low = middle;
        else
            high = middle;
    }
    smooth_by(s, low);
}

double lw_noise(const double *x, const double *y, size_t n, bool closed, double *work)
{
    static const double by[4][9] = { { 0, 0, 0, 1, -2, 1 }, { 0, 0, 1, -4, 6, -4, 1 }, { 0, 1, -6, 15, -20, 15, -6, 1 },
                                     { 1, -8, 28, -56, 70, -56, 28, -8, 1 } };
    double least = INFINITY;
    for (int order = 0; order < 4; order++) {
        double square = 0;
        size_t count = 0;
        for (int j = 0; j < 9; j++)
            square += by[order][j]*by[order][j];
        for (size_t i = closed ? 0 : 4; i + (closed ? 0 : 4) < n; i++) {
            lw_vec2 d = { 0, 0 };
            for (size_t j = 0; j < 9; j++)
                d = lw_v2_add(d, lw_v2_scale(lw_v2(x[(i + n + j - 4) % n], y[(i + n + j - 4) % n]), by[order][j]));
            size_t a = (i + n - 4) % n, b = (i + 4) % n;
            lw_vec2 chord = lw_v2(x[b] - x[a], y[b] - y[a]);
            double length = lw_v2_norm(chord);
            work[count++] = length > 0 ? fabs(lw_v2_cross(chord, d))/length : lw_v2_norm(d);
        }
        lw_sort(count, work);
        least = fmin(least, work[count/2]/(0.6745*sqrt(square)));
    }
    return least;
}

lw_status lw_smooth(double *x, double *y, size_t n, bool closed, double distance, double *rms, double *most, lw_error *e)
{
    size_t *knot = malloc(n*sizeof *knot), m = 0;
    *rms = *most = 0;
    for (size_t i = 0; knot && i < n; i++) {
        bool again = i > 0 && x[i] == x[i-1] && y[i] == y[i-1];
        m += !again;
        knot[i] = m - 1;
    }
    bool meets = closed && n > 0 && x[n-1] == x[0] && y[n-1] == y[0] && m > 1;
    m -= meets;
    spline *s = knot && m >= 5 ? make_spline(m, closed) : NULL;
    if (!knot || (m >= 5 && !s)) {
        free(knot);
        return lw_error_set(e, LW_E_MEMORY, "out of memory for smoothing %zu points", n);
    }
    for (size_t i = 0; s && i < n; i++) {
        s->x[knot[i] % m] = x[i];
        s->y[knot[i] % m] = y[i];
    }
    for (size_t i = 0; s && i < m; i++)
        s->h[i] = hypot(s->x[(i + 1) % m] - s->x[i], s->y[(i + 1) % m] - s->y[i]);
    if (s && !closed)
        s->h[m-1] = s->h[m-2];                      /* of no segment, used by none */
    if (s)
        find_smoothing(s, distance);
    for (size_t i = 0; s && i < n; i++) {
        double dx = s->move[0][knot[i] % m], dy = s->move[1][knot[i] % m];
        x[i] += dx;
        y[i] += dy;
        *rms += (dx*dx + dy*dy)/(double)n;
        *most = fmax(*most, hypot(dx, dy));
    }
    *rms = sqrt(*rms);
    free(knot);
    free(s);
    return LW_OK;
}

/* ---- targets ------------------------------------------------------------------------------------------------- */

static lw_status smooth_target(lw_target *t, double distance, lw_error *e)
{
    double all = 0, worst = 0, rms, most, noise = 0, *work = NULL;
    lw_status s = LW_OK;
    if (distance < 0 && t->n < LW_NOISE_POINTS)
        return lw_error_set(e, LW_E_ARG, "the noise of %zu points cannot be estimated, only that of %d or more; say how far "
                            "the smooth path may be from the points", t->n, LW_NOISE_POINTS);
    if (distance < 0 && !(work = malloc(t->n*sizeof *work)))
        return lw_error_set(e, LW_E_MEMORY, "out of memory for the noise of %zu points", t->n);
    for (int i = -1; i < t->n_also && work; i++)
        if (i < 0 || t->also[i].x)
            noise = fmax(noise, lw_noise(i < 0 ? t->x : t->also[i].x, i < 0 ? t->y : t->also[i].y, t->n, t->closed, work));
    if (work) {
        distance = noise*sqrt(2*log((double)t->n));               /* the greatest of n deviations, as expected */
        lw_target_add_note(t, "noise across the path: %.3g %s (standard deviation), smoothed by --smooth %.3g", noise/t->units.metre,
                 t->units.length, distance/t->units.metre);
        free(work);
    }
    for (int i = -1; s == LW_OK && i < t->n_also; i++) {
        double *x = i < 0 ? t->x : t->also[i].x, *y = i < 0 ? t->y : t->also[i].y;
        if (!x)
            continue;
        s = lw_smooth(x, y, t->n, t->closed, distance, &rms, &most, e);
        all = fmax(all, rms);
        worst = fmax(worst, most);
    }
    t->noise = all;
    lw_target_add_note(t, "smoothed: the path lies %.3g %s (RMS) from the points, %.3g at most", all/t->units.metre,
             t->units.length,
             worst/t->units.metre);
    return s;
}

static lw_status spread_target(lw_target *t, size_t m, lw_error *e)
{
    lw_target spread = { .n = 0 };
    lw_vec2 *p = malloc((t->n + m)*sizeof *p), *out = p ? p + t->n : NULL;
    size_t *from = malloc(m*sizeof *from), n = 0;
    double *xy = malloc(2*m*sizeof *xy);
    lw_status s = p && from && xy ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory for %zu stations", m);
    for (size_t i = 0; s == LW_OK && i < t->n; i++)
        if (n == 0 || p[n-1].x != t->x[i] || p[n-1].y != t->y[i])
            p[n++] = lw_v2(t->x[i], t->y[i]);
    if (s == LW_OK && t->closed && n > 1 && p[n-1].x == p[0].x && p[n-1].y == p[0].y)
        n--;
    if (s == LW_OK && n < 2)
        s = lw_error_set(e, LW_E_ARG, "a path of one place cannot be spread to %zu stations", m);
    if (s == LW_OK)
        s = lw_resample(p, n, t->closed && n > 2, true, m, out, from, e);
    for (size_t i = 0; s == LW_OK && i < m; i++) {
        xy[i] = out[i].x;
        xy[m + i] = out[i].y;
    }
    if (s == LW_OK)
        s = lw_target_make(m, xy, xy + m, NULL, NULL, NULL, t->closed, &spread, e);
    if (s == LW_OK) {
        spread.units = t->units;
        spread.noise = t->noise;
        for (size_t i = 0; i < m; i++)
            spread.line[i] = t->line[from[i]];
        memcpy(spread.note, t->note, sizeof spread.note);
        lw_target_add_note(&spread, "%zu stations on the path through the %zu points of the file", m, t->n);
        lw_target_free(t);
        *t = spread;
    }
    free(p);
    free(from);
    free(xy);
    return s;
}

lw_status lw_target_treat(lw_target *t, int closed, const lw_target_options *o, lw_error *e)
{
    lw_target_place place;
    lw_status s = lw_target_look_at_order(t, closed, e);
    if (s != LW_OK || !o || (o->smooth == 0 && o->stations <= 0))
        return s;
    if (!t->x)
        return lw_error_set(e, LW_E_ARG, "a function cannot be smoothed or spread to other stations; only a path can");
    if (o->stations > 0 && (t->theta || t->angle || t->n_also > 0))
        return lw_error_set(e, LW_E_ARG, "stations with angles or further points belong to the rows of the file; only "
                            "a path of x and y can be spread to other stations");
    s = lw_target_put_in_order(t, e);                          /* there is no curve along points that jump to and fro */
    if (s != LW_OK)
        return s;
    if (o->smooth != 0)
        s = smooth_target(t, o->smooth*t->units.metre, e);
    if (s == LW_OK && o->smooth != 0)
        s = lw_target_finish(t, t->closed, &place, e);            /* its length and size */
    if (s == LW_OK && o->stations > 0)
        s = spread_target(t, (size_t)o->stations, e);
    return s;
}
