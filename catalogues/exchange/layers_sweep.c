/* catalogues/exchange/layers_sweep.c - distances of convex bodies, and the least of a motion. */
#include <math.h>
#include <stdlib.h>

#include "catalogues/exchange/layers_internal.h"

/* ---- one posture ------------------------------------------------------------------------------------------- */

static double point_distance(lw_vec2 p, const lw_vec2 *a, int n)
{
    double d = INFINITY;
    bool inside = n > 2;
    for (int i = 0; i < n; i++) {
        lw_vec2 u = a[i], v = a[(i + 1) % n];
        d = fmin(d, lw_v2_segment_distance(p, u, v));
        inside = inside && lw_v2_cross(lw_v2_sub(v, u), lw_v2_sub(p, u)) >= 0;
    }
    return inside ? 0 : d;
}

static bool edges_cross(lw_vec2 a, lw_vec2 b, lw_vec2 c, lw_vec2 d)
{
    lw_vec2 u = lw_v2_sub(b, a), v = lw_v2_sub(d, c);
    return lw_v2_cross(u, lw_v2_sub(c, a))*lw_v2_cross(u, lw_v2_sub(d, a)) < 0
        && lw_v2_cross(v, lw_v2_sub(a, c))*lw_v2_cross(v, lw_v2_sub(b, c)) < 0;
}

double lw_hull_distance(const lw_vec2 *a, int n_a, const lw_vec2 *b, int n_b)
{
    double d = INFINITY;
    for (int i = 0; i < n_a; i++)
        d = fmin(d, point_distance(a[i], b, n_b));
    for (int i = 0; i < n_b && d > 0; i++)
        d = fmin(d, point_distance(b[i], a, n_a));
    for (int i = 0; i < n_a && d > 0; i++)
        for (int j = 0; j < n_b; j++)
            if (edges_cross(a[i], a[(i + 1) % n_a], b[j], b[(j + 1) % n_b]))
                return 0;
    return d;
}

/* ---- a motion ---------------------------------------------------------------------------------------------- */

void lw_body_free(lw_plate_body *b)
{
    free(b->at);
    free(b->way);
    *b = (lw_plate_body){ 0 };
}

static double norm2(lw_vec2 v) { return lw_v2_dot(v, v); }

/* The largest second difference of a corner around posture f, which in a motion back and forth is an inner one. */
static double bend_at(const lw_scene *s, const lw_plate_body *b, size_t f)
{
    size_t last = s->n_frame - 1, mid = s->loops ? f : f == 0 ? 1 : f == last ? last - 1 : f;
    size_t from = s->loops ? (mid + last) % s->n_frame : mid - 1, to = (mid + 1) % s->n_frame;
    double most = 0;
    for (int c = 0; s->n_frame > 2 && c < b->n; c++) {
        lw_vec2 p = b->at[from*(size_t)b->n + (size_t)c], q = b->at[mid*(size_t)b->n + (size_t)c];
        lw_vec2 r = b->at[to*(size_t)b->n + (size_t)c];
        most = fmax(most, norm2(lw_v2_sub(lw_v2_add(p, r), lw_v2_scale(q, 2))));
    }
    return sqrt(most);
}

/* The posture before f; the first itself when the motion goes back and forth. */
static size_t before(const lw_scene *s, size_t f) { return f > 0 ? f - 1 : s->loops ? s->n_frame - 1 : 0; }

lw_status lw_body_move(const lw_scene *s, int link, const lw_vec2 *corner, int n, lw_plate_body *b)
{
    size_t m = (size_t)n;
    b->n = n;
    b->at = malloc((s->n_frame*m + 1)*sizeof *b->at);
    b->way = malloc(s->n_frame*sizeof *b->way);
    if (!b->at || !b->way) {
        lw_body_free(b);
        return LW_E_MEMORY;
    }
    for (size_t f = 0; f < s->n_frame; f++)
        for (size_t c = 0; c < m; c++)
            b->at[f*m + c] = lw_scene_at(s, f, link, corner[c]);
    for (size_t f = 0; f < s->n_frame; f++) {
        size_t g = before(s, f);
        double chord = 0;
        for (size_t c = 0; c < m; c++)
            chord = fmax(chord, norm2(lw_v2_sub(b->at[f*m + c], b->at[g*m + c])));
        b->way[f] = f == g ? 0 : sqrt(chord) + 0.5*fmax(bend_at(s, b, f), bend_at(s, b, g));
    }
    return LW_OK;
}

lw_approach lw_body_approach(const lw_scene *s, const lw_plate_body *a, const lw_plate_body *b)
{
    lw_approach least = { INFINITY, INFINITY };
    size_t last = s->n_frame - 1;
    double d0 = lw_hull_distance(a->at + last*(size_t)a->n, a->n, b->at + last*(size_t)b->n, b->n);
    for (size_t f = 0; f < s->n_frame; f++) {
        double d1 = lw_hull_distance(a->at + f*(size_t)a->n, a->n, b->at + f*(size_t)b->n, b->n);
        if (f == 0 && !s->loops)
            d0 = d1;
        least.seen = fmin(least.seen, d1);
        least.sure = fmin(least.sure, 0.5*(d0 + d1 - a->way[f] - b->way[f]));
        d0 = d1;
    }
    return least;
}
