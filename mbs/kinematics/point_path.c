/* mbs/kinematics/point_path.c - see point_path.h */
#include "mbs/kinematics/point_path.h"

#include <stdlib.h>
#include "base/real.h"
#include "base/vec2.h"

typedef struct path { size_t n; const double *x, *y; double size; } path;
typedef struct chord { double least, most; size_t i; } chord;              /* its range of x */

/* Point and derivative at parameter t of the cubic through four points around segment i. */
static void cubic(const path *p, size_t i, double t, lw_vec2 *at, lw_vec2 *rate)
{
    size_t first = i == 0 ? 0 : i - 1, k = p->n < 4 ? p->n : 4;
    first = first + k > p->n ? p->n - k : first;
    *at = *rate = lw_v2(0, 0);
    for (size_t a = 0; a < k; a++) {
        double value = 1, slope = 0;
        for (size_t b = 0; b < k; b++) {
            if (b == a)
                continue;
            double scale = 1/((double)a - (double)b), u = t - (double)(first + b);
            slope = (slope*u + value)*scale;
            value *= u*scale;
        }
        lw_vec2 q = lw_v2(p->x[first + a], p->y[first + a]);
        *at = lw_v2_add(*at, lw_v2_scale(q, value));
        *rate = lw_v2_add(*rate, lw_v2_scale(q, slope));
    }
}

static bool refine(const path *p, size_t i, size_t j, double *s, double *t, lw_vec2 *at)
{
    lw_vec2 a, da, b, db;
    for (int round = 0; round < 12; round++) {
        cubic(p, i, *s, &a, &da);
        cubic(p, j, *t, &b, &db);
        lw_vec2 off = lw_v2_sub(b, a);
        double det = lw_v2_cross(da, db);
        *at = a;
        if (lw_v2_norm(off) <= 1e-13*p->size)
            return fabs(*s - (double)i - 0.5) < 1 && fabs(*t - (double)j - 0.5) < 1;
        if (!(fabs(det) > 1e-12*lw_v2_norm(da)*lw_v2_norm(db)))
            return false;
        *s += lw_v2_cross(off, db)/det;
        *t += lw_v2_cross(off, da)/det;
        if (!(fabs(*s - (double)i - 0.5) < 2) || !(fabs(*t - (double)j - 0.5) < 2))
            return false;
    }
    return lw_v2_norm(lw_v2_sub(b, a)) <= 1e-10*p->size;
}

/* Do the chords of segments i < j cross?  Neighbours share a point; so do the last and the first of a closed path. */
static bool chords_cross(const path *p, size_t i, size_t j, double *s, double *t)
{
    lw_vec2 a = lw_v2(p->x[i], p->y[i]), u = lw_v2_sub(lw_v2(p->x[i + 1], p->y[i + 1]), a);
    lw_vec2 b = lw_v2(p->x[j], p->y[j]), v = lw_v2_sub(lw_v2(p->x[j + 1], p->y[j + 1]), b), d = lw_v2_sub(b, a);
    double det = lw_v2_cross(u, v);
    bool ends_meet = i == 0 && j == p->n - 2 && lw_v2_norm(lw_v2_sub(lw_v2_add(b, v), a)) <= 1e-9*p->size;
    if (j == i + 1 || ends_meet || det == 0)
        return false;
    *s = lw_v2_cross(d, v)/det;
    *t = lw_v2_cross(d, u)/det;
    return *s >= 0 && *s < 1 && *t >= 0 && *t < 1;
}

static int by_least(const void *a, const void *b)
{
    const chord *p = a, *q = b;
    return (p->least > q->least) - (p->least < q->least);
}

static int keep(const path *p, size_t i, size_t j, lw_double_point *out, int n, int most)
{
    double s, t;
    lw_vec2 at;
    if (!chords_cross(p, i, j, &s, &t))
        return n;
    s += (double)i;
    t += (double)j;
    if (n == most || !refine(p, i, j, &s, &t, &at))
        return n;
    int k = n;
    for (int q = 0; q < n; q++)                                 /* found from the next chord already? */
        if (fabs(out[q].first - s) < 1e-6 && fabs(out[q].second - t) < 1e-6)
            return n;
    for (; k > 0 && out[k - 1].first > s; k--)
        out[k] = out[k - 1];
    out[k] = (lw_double_point){ at, s, t };
    return n + 1;
}

int lw_point_path_doubles(size_t n, const double *x, const double *y, lw_double_point *out, int most)
{
    path p = { n, x, y, 0 };
    size_t m = 0;
    int found = 0;
    chord *c = malloc((n + 1)*sizeof *c);
    if (!c)
        return -1;
    for (size_t i = 0; i + 1 < n; i++)
        if (isfinite(x[i] + x[i + 1] + y[i] + y[i + 1])) {
            c[m++] = (chord){ fmin(x[i], x[i + 1]), fmax(x[i], x[i + 1]), i };
            p.size = fmax(p.size, fmax(fabs(x[i + 1] - x[0]), fabs(y[i + 1] - y[0])));
        }
    qsort(c, m, sizeof *c, by_least);
    for (size_t a = 0; a < m; a++)
        for (size_t b = a + 1; b < m && c[b].least <= c[a].most; b++)
            found = keep(&p, c[a].i < c[b].i ? c[a].i : c[b].i, c[a].i < c[b].i ? c[b].i : c[a].i, out, found, most);
    free(c);
    return found;
}
