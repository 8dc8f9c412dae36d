/* grammar/model/mesh.c - integrals over the tetrahedra between a point and the triangles of a surface. */
#include "grammar/model/mesh.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"

/* Directed edges of the triangles; `turn` is 1 if from < to, else -1 and they are exchanged. */
typedef struct edge { lw_vec3 from, to; int turn; } edge;

static int order(const lw_vec3 *a, const lw_vec3 *b)
{
    return a->x != b->x ? (a->x < b->x ? -1 : 1) : a->y != b->y ? (a->y < b->y ? -1 : 1) : a->z != b->z ? (a->z < b->z ? -1 : 1) : 0;
}

static int order_edges(const void *a, const void *b)
{
    const edge *p = a, *q = b;
    int from = order(&p->from, &q->from);
    return from ? from : order(&p->to, &q->to);
}

/* Every edge runs as often one way as the other. */
static lw_status check_closed(const lw_vec3 *corner, size_t n, const char *file, lw_error *e)
{
    edge *side = malloc(n*sizeof *side);
    size_t count = 0;
    lw_status s = LW_OK;
    if (!side)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (size_t i = 0; i < n; i++) {
        const lw_vec3 *a = &corner[i], *b = &corner[i%3 == 2 ? i - 2 : i + 1];
        int way = order(a, b);
        if (way)
            side[count++] = way < 0 ? (edge){ *a, *b, 1 } : (edge){ *b, *a, -1 };
    }
    qsort(side, count, sizeof *side, order_edges);
    for (size_t i = 0, end; s == LW_OK && i < count; i = end) {
        int sum = 0;
        for (end = i; end < count && order_edges(&side[i], &side[end]) == 0; end++)
            sum += side[end].turn;
        if (sum)
            s = lw_error_at(e, LW_E_NOTATION, file, 0, 0, "the mesh is not closed, or its faces do not all look outwards: at the edge from "
                            "(%.6g, %.6g, %.6g) to (%.6g, %.6g, %.6g)", side[i].from.x, side[i].from.y, side[i].from.z, side[i].to.x,
                            side[i].to.y, side[i].to.z);
    }
    free(side);
    return s;
}

/* The tetrahedron from 0 to a, b, c has the volume v = a (b x c)/6; the integral of x over it is v/4 (a + b + c), that of x y
 * v/20 (ax ay + bx by + cx cy + sx sy) with s = a + b + c. */
static void integrate(const lw_vec3 *corner, size_t n, lw_mesh_integrals *out)
{
    lw_vec3 middle = { 0 }, first = { 0 };
    double volume = 0, second[6] = { 0 };            /* xx, yy, zz, xy, xz, yz */
    for (size_t i = 0; i < n; i++)
        middle = lw_v3_add(middle, lw_v3_scale(corner[i], 1/(double)n));
    for (size_t i = 0; i < n; i += 3) {
        lw_vec3 p[4];
        for (int k = 0; k < 3; k++)
            p[k] = lw_v3_sub(corner[i + (size_t)k], middle);
        p[3] = lw_v3_add(p[0], lw_v3_add(p[1], p[2]));
        double v = lw_v3_dot(p[0], lw_v3_cross(p[1], p[2]))/6;
        volume += v;
        first = lw_v3_add(first, lw_v3_scale(p[3], v/4));
        for (int k = 0; k < 4; k++) {
            second[0] += v/20*p[k].x*p[k].x, second[1] += v/20*p[k].y*p[k].y, second[2] += v/20*p[k].z*p[k].z;
            second[3] += v/20*p[k].x*p[k].y, second[4] += v/20*p[k].x*p[k].z, second[5] += v/20*p[k].y*p[k].z;
        }
    }
    lw_vec3 c = lw_v3_scale(first, 1/volume);
    const double about[6] = { c.x*c.x, c.y*c.y, c.z*c.z, c.x*c.y, c.x*c.z, c.y*c.z };
    for (int k = 0; k < 6; k++)
        second[k] -= volume*about[k];
    out->volume = volume;
    out->centre = lw_v3_add(middle, c);
    for (int k = 0; k < 3; k++)
        out->inertia[k] = second[0] + second[1] + second[2] - second[k], out->inertia[3 + k] = -second[3 + k];
}

/* ---- the two forms of the file -------------------------------------------------------------------------------- */

static uint32_t word_at(const char *p)
{
    const unsigned char *b = (const unsigned char *)p;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* 80 bytes, the number of triangles, and for each a normal, three corners (floats) and 2 bytes. */
static bool binary(const char *text, size_t size)
{
    return size >= 84 && size == 84 + 50*(size_t)word_at(text + 80);
}

static lw_status read_binary(const char *text, size_t n, const char *file, lw_vec3 *corner, lw_error *e)
{
    for (size_t i = 0; i < n; i++) {
        float x[3];
        for (size_t k = 0; k < 3; k++) {
            uint32_t bits = word_at(text + 84 + i/3*50 + 12 + i%3*12 + 4*k);
            memcpy(&x[k], &bits, sizeof bits);
        }
        corner[i] = lw_v3((double)x[0], (double)x[1], (double)x[2]);
        if (!isfinite(x[0] + x[1] + x[2]))
            return lw_error_at(e, LW_E_NOTATION, file, 0, 0, "triangle %zu has a corner that is no place", i/3 + 1);
    }
    return LW_OK;
}

/* The next word from *at on; its length, 0 at the end.  *line counts. */
static size_t next_word(const char **at, const char *end, long *line)
{
    while (*at < end && memchr(" \t\r\n", **at, 4))
        *line += *(*at)++ == '\n';
    const char *stop = *at;
    while (stop < end && !memchr(" \t\r\n", *stop, 4))
        stop++;
    return (size_t)(stop - *at);
}

/* The corners of a text, into corner unless it is NULL. */
static lw_status read_text(const char *text, size_t size, const char *file, lw_vec3 *corner, size_t *n, lw_error *e)
{
    const char *at = text, *end = text + size;
    long line = 1;
    *n = 0;
    for (size_t length; (length = next_word(&at, end, &line)) > 0; at += length) {
        if (length != 6 || memcmp(at, "vertex", 6) != 0)
            continue;
        double x[3];
        for (int k = 0; k < 3; k++) {
            at += length;
            length = next_word(&at, end, &line);
            if (lw_number_parse(at, length, &x[k]) != LW_OK)
                return lw_error_at(e, LW_E_NOTATION, file, line, 0, "a vertex has three numbers");
        }
        if (corner)
            corner[*n] = lw_v3(x[0], x[1], x[2]);
        ++*n;
    }
    return LW_OK;
}

lw_status lw_mesh_read(const char *text, size_t size, const char *file, lw_mesh_integrals *out, lw_error *e)
{
    bool bytes = binary(text, size);
    size_t n = bytes ? 3*(size_t)word_at(text + 80) : 0;
    if (!bytes && (size < 5 || memcmp(text, "solid", 5) != 0))
        return lw_error_at(e, LW_E_NOTATION, file, 1, 1, "this is no STL file: it neither begins with \"solid\" nor has the size of its triangles");
    lw_status s = bytes ? LW_OK : read_text(text, size, file, NULL, &n, e);
    if (s == LW_OK && (n == 0 || n%3))
        s = lw_error_at(e, LW_E_NOTATION, file, 0, 0, n ? "the last triangle is not complete" : "there are no triangles");
    if (s != LW_OK)
        return s;
    lw_vec3 *corner = malloc(n*sizeof *corner);
    if (!corner)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    s = bytes ? read_binary(text, n, file, corner, e) : read_text(text, size, file, corner, &n, e);
    if (s == LW_OK)
        s = check_closed(corner, n, file, e);
    if (s == LW_OK) {
        integrate(corner, n, out);
        if (!(out->volume > 0) || !isfinite(out->volume))
            s = lw_error_at(e, LW_E_NOTATION, file, 0, 0, "the mesh encloses no volume, or its faces look inwards");
    }
    free(corner);
    return s;
}
