/* catalogues/exchange/export_stl.c - plates and pins as closed meshes of triangles (STL, text).
 *
 * A face with holes is made one polygon by bridges from each hole to the outline, which is cut into triangles by
 * clipping ears (Eberly, Triangulation by ear clipping, 2002). */
#include <stdio.h>
#include <stdlib.h>

#include "base/real.h"
#include "catalogues/exchange/plates.h"

#define MM     1000.0
#define DIGITS 9
#define STEPS  48                          /* sides of a circle                                        */

typedef struct mesh {
    lw_bytes *out;
    lw_vec2  *p;                           /* corners of all loops                                 (n) */
    int       n;
    int      *ring;                        /* the polygon with bridges, as indices of p       (n_ring) */
    int       n_ring;
} mesh;

/* ---- corners --------------------------------------------------------------------------------------------------- */

/* Append the corners of a loop, counter-clockwise; returns how many. p NULL: only count. */
static int add_corners(const lw_plate_loop *l, lw_vec2 *p)
{
    int n = 0;
    for (int i = 0; i < l->n; i++) {
        const lw_plate_side *a = &l->side[i], *b = &l->side[(i + 1) % l->n];
        lw_vec2 r = lw_v2_sub(a->from, a->centre), q = lw_v2_sub(b->from, a->centre);
        double sweep = l->n == 1 ? 2*LW_PI : atan2(lw_v2_cross(r, q), lw_v2_dot(r, q));
        sweep = sweep < 0 ? sweep + 2*LW_PI : sweep;
        int steps = a->arc ? (int)ceil(STEPS*sweep/(2*LW_PI) - 1e-9) : 1;
        for (int k = 0; k < steps; k++, n++)
            if (p)
                p[n] = k == 0 ? a->from : lw_v2_add(a->centre, lw_v2_turn(r, lw_v2_polar(1, sweep*k/steps)));
    }
    return n;
}

/* ---- triangles ------------------------------------------------------------------------------------------------- */

static void put_corner(mesh *m, lw_vec2 p, double z)
{
    double v[3] = { MM*p.x, MM*p.y, MM*z };
    lw_bytes_text(m->out, "  vertex");
    for (int i = 0; i < 3; i++) {
        lw_bytes_text(m->out, " ");
        lw_bytes_number(m->out, fabs(v[i]) < 1e-9 ? 0 : v[i], DIGITS);
    }
    lw_bytes_text(m->out, "\n");
}

/* A triangle of three corners, each at its height. */
static void put_triangle(mesh *m, const lw_vec2 p[3], const double z[3], double nx, double ny, double nz)
{
    char line[96];
    snprintf(line, sizeof line, " facet normal %.6f %.6f %.6f\n outer loop\n", nx, ny, nz);
    lw_bytes_text(m->out, line);
    for (int i = 0; i < 3; i++)
        put_corner(m, p[i], z[i]);
    lw_bytes_text(m->out, " endloop\n endfacet\n");
}

static double area(lw_vec2 a, lw_vec2 b, lw_vec2 c) { return lw_v2_cross(lw_v2_sub(b, a), lw_v2_sub(c, a)); }

static bool same(lw_vec2 a, lw_vec2 b) { return a.x == b.x && a.y == b.y; }

/* Do the segments cross, other than at a common end? */
static bool cross(lw_vec2 a, lw_vec2 b, lw_vec2 c, lw_vec2 d)
{
    if (same(a, c) || same(a, d) || same(b, c) || same(b, d))
        return false;
    return (area(a, b, c) > 0) != (area(a, b, d) > 0) && (area(c, d, a) > 0) != (area(c, d, b) > 0);
}

/* May corner `from` of the hole first .. first + n - 1 be bridged to place `at` of the ring? The way must cross no
 * loop. */
static bool sees(const mesh *m, int from, int at, const int *start, int n_loop)
{
    lw_vec2 a = m->p[from], b = m->p[m->ring[at]];
    for (int k = 0; k < n_loop; k++)
        for (int i = start[k]; i < start[k+1]; i++)
            if (cross(a, b, m->p[i], m->p[i + 1 < start[k+1] ? i + 1 : start[k]]))
                return false;
    lw_vec2 before = m->p[m->ring[(at + m->n_ring - 1) % m->n_ring]], after = m->p[m->ring[(at + 1) % m->n_ring]];
    bool convex = area(before, b, after) > 0, in = area(before, b, a) > 0, out = area(b, after, a) > 0;
    return convex ? in && out : in || out;
}

/* Join a hole to the ring at the shortest way. Its corners are passed clockwise. */
static bool bridge(mesh *m, const int *start, int n_loop, int hole)
{
    int best = -1, from = -1, n = start[hole+1] - start[hole];
    double least = INFINITY;
    for (int i = start[hole]; i < start[hole+1]; i++)
        for (int at = 0; at < m->n_ring; at++) {
            double d = lw_v2_norm(lw_v2_sub(m->p[i], m->p[m->ring[at]]));
            if (d < least && sees(m, i, at, start, n_loop)) {
                least = d;
                best = at;
                from = i;
            }
        }
    if (best < 0)
        return false;
    for (int i = m->n_ring - 1; i > best; i--)
        m->ring[i + n + 2] = m->ring[i];
    for (int i = 0; i <= n; i++)
        m->ring[best + 1 + i] = start[hole] + (from - start[hole] + n - i) % n;
    m->ring[best + n + 2] = m->ring[best];
    m->n_ring += n + 2;
    return true;
}

/* Is the corner an ear: convex, with no other corner of the ring in its triangle? */
static bool is_ear(const mesh *m, int at)
{
    lw_vec2 a = m->p[m->ring[(at + m->n_ring - 1) % m->n_ring]], b = m->p[m->ring[at]], c = m->p[m->ring[(at + 1) % m->n_ring]];
    if (area(a, b, c) <= 0)
        return false;
    for (int i = 0; i < m->n_ring; i++) {
        lw_vec2 q = m->p[m->ring[i]];
        if (!same(q, a) && !same(q, b) && !same(q, c) && area(a, b, q) >= 0 && area(b, c, q) >= 0 && area(c, a, q) >= 0)
            return false;
    }
    return true;
}

/* Cut the ring into triangles, below and above. False: it cannot be cut. */
static bool put_flat_faces(mesh *m, double low, double high)
{
    while (m->n_ring >= 3) {
        int ear = 0;
        while (ear < m->n_ring && !is_ear(m, ear))
            ear++;
        if (ear == m->n_ring)
            return false;
        int before = m->ring[(ear + m->n_ring - 1) % m->n_ring], after = m->ring[(ear + 1) % m->n_ring];
        lw_vec2 up[3] = { m->p[before], m->p[m->ring[ear]], m->p[after] }, down[3] = { up[2], up[1], up[0] };
        put_triangle(m, up, (double[]){ high, high, high }, 0, 0, 1);
        put_triangle(m, down, (double[]){ low, low, low }, 0, 0, -1);
        for (int i = ear; i + 1 < m->n_ring; i++)
            m->ring[i] = m->ring[i+1];
        m->n_ring--;
    }
    return true;
}

static void put_sides(mesh *m, int first, int last, double low, double high, bool hole)
{
    for (int i = first; i < last; i++) {
        lw_vec2 a = m->p[i], b = m->p[i + 1 < last ? i + 1 : first], d = lw_v2_sub(b, a);
        lw_vec2 out = lw_v2_scale(lw_v2_perp(d), (hole ? 1 : -1)/lw_v2_norm(d));
        lw_vec2 p = hole ? b : a, q = hole ? a : b;
        put_triangle(m, (lw_vec2[]){ p, q, q }, (double[]){ low, low, high }, out.x, out.y, 0);
        put_triangle(m, (lw_vec2[]){ p, q, p }, (double[]){ low, high, high }, out.x, out.y, 0);
    }
}

static void put_name(lw_bytes *out, const char *before, const char *name)
{
    lw_bytes_text(out, before);
    for (; *name; name++) {
        char c[2] = { *name > ' ' && *name < 127 ? *name : '_', 0 };
        lw_bytes_text(out, c);
    }
    lw_bytes_text(out, "\n");
}

static lw_status put_slab(const lw_slab *s, lw_bytes *out, lw_error *e)
{
    mesh m = { .out = out };
    int n_loop = s->n_hole + 1, *start = calloc((size_t)n_loop + 1, sizeof *start);
    if (!start)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a mesh");
    for (int k = 0; k < n_loop; k++)
        start[k+1] = start[k] + add_corners(k ? &s->hole[k-1] : &s->outline, NULL);
    m.n = start[n_loop];
    m.p = malloc((size_t)m.n*sizeof *m.p);
    m.ring = malloc((size_t)(m.n + 2*n_loop)*sizeof *m.ring);
    bool ok = m.p && m.ring;
    lw_status st = ok ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory for a mesh");
    for (int k = 0; ok && k < n_loop; k++)
        add_corners(k ? &s->hole[k-1] : &s->outline, m.p + start[k]);
    for (m.n_ring = 0; ok && m.n_ring < start[1]; m.n_ring++)
        m.ring[m.n_ring] = m.n_ring;
    put_name(out, "solid ", s->name);
    for (int k = 0; ok && k < n_loop; k++)
        put_sides(&m, start[k], start[k+1], s->low, s->high, k > 0);
    for (int k = 1; ok && k < n_loop; k++)
        ok = bridge(&m, start, n_loop, k);
    if (ok)
        ok = put_flat_faces(&m, s->low, s->high);
    put_name(out, "endsolid ", s->name);
    if (!ok && st == LW_OK)
        st = lw_error_set(e, LW_E_KIND, "plate '%s' could not be cut into triangles; export step", s->name);
    free(m.p);
    free(m.ring);
    free(start);
    return st;
}

lw_status lw_export_stl(const lw_assembly *linkage, const lw_export_options *o, lw_bytes *out, lw_error *e)
{
    lw_plates *plates;
    lw_status s = lw_plates_make(linkage, o, &plates, e);
    if (s != LW_OK)
        return s;
    lw_slab slab;
    s = lw_plates_check_holes(plates, e);
    for (int i = 0; s == LW_OK && i < lw_plates_count(plates); i++) {
        lw_plates_slab(plates, i, &slab);
        s = put_slab(&slab, out, e);
    }
    lw_plates_free(plates);
    if (s != LW_OK) {
        lw_bytes_free(out);
        return s;
    }
    return lw_bytes_end(out, e);
}
