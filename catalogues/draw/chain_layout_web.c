/* catalogues/draw/chain_layout_web.c - the map of joints of an embedding, and its first places */
#include <stdlib.h>
#include <string.h>

#include "base/linalg.h"
#include "catalogues/draw/chain_layout_internal.h"

static int degree_of(const lw_rings *r, int dart)
{
    int n = 0, d = dart;
    do
        n++;
    while ((d = r->after[d]) != dart);
    return n;
}

/* ---- vertices ----------------------------------------------------------------------------------- */

static bool share_joint(const lw_mechanism *m, int i, int k)
{
    return lw_mechanism_joint(m, i, k) != LW_NONE;
}

/* Binary links of a pin and a slider that become one point: their joints in pairs.  Not two around a loop of
 * four, where a bar and another would cover each other. */
static void merge_blocks(const lw_mechanism *m, uint8_t *same_as)
{
    int n_joint[LW_LINK_MAX] = { 0 }, joint[LW_LINK_MAX][2], beside[LW_LINK_MAX][2], n_done = 0;
    for (int j = 0; j < m->n_joint; j++) {
        same_as[j] = (uint8_t)j;
        for (int side = 0; side < 2; side++) {
            int i = m->link[j][side];
            if (n_joint[i]++ < 2)
                joint[i][n_joint[i] - 1] = j;
        }
    }
    for (int i = 0; i < m->n_link; i++) {
        if (n_joint[i] != 2 || i == m->ground)
            continue;
        int a = joint[i][0], b = joint[i][1];
        int p = m->link[a][0] + m->link[a][1] - i, q = m->link[b][0] + m->link[b][1] - i;
        bool block = (m->kind[a] == 't' && m->kind[b] == 'r') || (m->kind[a] == 'r' && m->kind[b] == 't');
        bool free = same_as[a] == a && same_as[b] == b && !share_joint(m, p, q);
        for (int k = 0; k < m->n_joint; k++)
            free = free && (same_as[k] == k || (same_as[k] != a && same_as[k] != b));
        for (int k = 0; k < n_done; k++)
            free = free && !((beside[k][0] == p && beside[k][1] == q) || (beside[k][0] == q && beside[k][1] == p));
        if (!block || !free)
            continue;
        same_as[b] = (uint8_t)a;
        beside[n_done][0] = p;
        beside[n_done++][1] = q;
    }
}

static void add_edge(lw_web *w, int a, int b, int link)
{
    if (a == b)
        return;
    w->edge[w->n_edge][0] = (uint8_t)a;
    w->edge[w->n_edge][1] = (uint8_t)b;
    w->edge_link[w->n_edge++] = (uint8_t)link;
}

/* The vertices of a link in the order of its outline, from dart `first`; a free end when it has one joint. */
static int outline(const lw_rings *r, const lw_web *w, int first, uint8_t *v)
{
    int n = 0, d = first;
    do
        v[n++] = w->vertex_of[d >> 1];
    while ((d = r->after[d]) != first);
    if (n == 1)
        v[n++] = w->end_of[r->link[first]];
    return n;
}

static void close_face(lw_web *w, int n)
{
    w->face_first[w->n_face + 1] = w->face_first[w->n_face] + n;
    w->n_face++;
}

/* Edges, links and polygons as faces; the ground is no face: it lies outside. */
static void add_links(const lw_mechanism *m, const lw_rings *r, lw_web *w)
{
    int first[LW_LINK_MAX];
    for (int d = r->n_dart - 1; d >= 0; d--)
        first[r->link[d]] = d;
    for (int i = 0; i < m->n_link; i++) {
        uint8_t v[LW_LINK_MAX];
        int n = outline(r, w, first[i], v);
        if (i == m->ground)
            continue;
        for (int k = 0; k < (n == 2 ? 1 : n); k++)
            add_edge(w, v[k], v[(k + 1) % n], i);
        memcpy(w->link + w->link_first[w->n_link], v, (size_t)n);
        w->link_first[w->n_link + 1] = w->link_first[w->n_link] + n;
        w->n_link++;
        if (n > 2) {
            memcpy(w->face + w->face_first[w->n_face], v, (size_t)n);
            close_face(w, n);
        }
    }
}

/* One loop as a walk over vertices; place[d]: where dart d stands in it. */
static void add_loop(const lw_rings *r, lw_web *w, int first, int *place)
{
    uint8_t *v = w->face + w->face_first[w->n_face];
    int n = 0, d = first;
    do {
        int at = w->vertex_of[d >> 1], other = r->link[d ^ 1];
        if (n == 0 || v[n - 1] != at)
            v[n++] = (uint8_t)at;
        place[d] = n - 1;
        if (r->after[d ^ 1] == (d ^ 1) && w->end_of[other] != 255)
            v[n++] = w->end_of[other];
        d = r->after[d ^ 1];
    } while (d != first);
    if (n > 1 && v[n - 1] == v[0] && w->n_ground == 0) {
        n--;
        for (int k = 0; k < r->n_dart; k++)
            if (place[k] == n)
                place[k] = 0;
    }
    close_face(w, n);
}

static void add_loops(const lw_mechanism *m, const lw_embedding *way, lw_web *w, int *place)
{
    uint8_t loop_of[LW_DART_MAX];
    int n = lw_rings_loops(&way->rings, loop_of), other[LW_DART_MAX];
    int outer = loop_of[way->outer];
    int first = m->ground == LW_NONE ? way->outer : way->rings.after[way->outer ^ 1];
    for (int d = 0; d < way->rings.n_dart; d++)
        place[d] = -1;
    add_loop(&way->rings, w, first, place);
    for (int i = 0; i < n; i++)
        for (int d = 0; i != outer && d < way->rings.n_dart; d++)
            if (loop_of[d] == i) {
                add_loop(&way->rings, w, d, other);
                break;
            }
}

/* Symmetries of the map as turns of the page; none but the identity when blocks are not alike under them. */
static void add_group(const lw_mechanism *m, const lw_embedding *way, const int *place, lw_web *w)
{
    lw_layout_symmetry g;
    int size = w->face_first[1];
    lw_embedding_symmetry(m, way, &g);
    for (int k = 0; k < g.n; k++) {
        int image = g.to[k][way->outer];
        memset(w->to[k], 255, sizeof w->to[k]);
        bool fits = true;
        for (int d = 0; d < way->rings.n_dart; d++) {
            uint8_t *to = &w->to[k][w->vertex_of[d >> 1]], want = w->vertex_of[g.to[k][d] >> 1];
            fits = fits && (*to == 255 || *to == want);
            *to = want;
            if (w->end_of[way->rings.link[d]] != 255)
                w->to[k][w->end_of[way->rings.link[d]]] = w->end_of[way->rings.link[g.to[k][d]]];
        }
        if (!fits && k > 0) {
            w->n_group = 1;
            return;
        }
        int shift = place[g.mirror[k] ? image ^ 1 : image] - (g.mirror[k] ? 0 : place[way->outer]);
        shift += g.mirror[k] ? place[way->outer] : 0;
        w->mirror[k] = g.mirror[k];
        w->turn[k] = lw_v2_polar(1, 2*LW_PI*shift/size);
        if (m->ground != LW_NONE)
            w->turn[k] = lw_v2(g.mirror[k] ? -1 : 1, 0);          /* over the upright through the middle */
        w->n_group = k + 1;
    }
}

void lw_web_make(const lw_mechanism *m, const lw_embedding *way, lw_web *w)
{
    uint8_t same_as[LW_JOINT_MAX];
    int place[LW_DART_MAX];
    memset(w, 0, sizeof *w);
    merge_blocks(m, same_as);
    for (int j = 0; j < m->n_joint; j++)
        if (same_as[j] == j)
            w->vertex_of[j] = (uint8_t)w->n_vertex++;
    for (int j = 0; j < m->n_joint; j++)
        w->vertex_of[j] = w->vertex_of[same_as[j]];
    memset(w->end_of, 255, sizeof w->end_of);
    for (int d = 0; d < way->rings.n_dart; d++)
        if (degree_of(&way->rings, d) == 1 && way->rings.link[d] != m->ground)
            w->end_of[way->rings.link[d]] = (uint8_t)w->n_vertex++;
    if (m->ground != LW_NONE)
        w->n_ground = outline(&way->rings, w, way->rings.after[way->outer ^ 1], w->ground);
    if (w->n_ground == 2 && w->ground[1] == 255)
        w->n_ground = 1;                                           /* a ground of one joint has no end */
    add_loops(m, way, w, place);
    add_links(m, &way->rings, w);
    add_group(m, way, place, w);
}

/* ---- first places ------------------------------------------------------------------------------- */

typedef struct system {
    int      n, n_node, room;      /* unknown nodes are 0 .. n-1 after `number`, fixed ones have a place */
    int     *number;               /* (n_node) -1: fixed                                                 */
    lw_vec2 *place;                /* (n_node)                                                           */
    int    (*rod)[2], n_rod;
} barycentres;

static int new_node(barycentres *b)
{
    b->number[b->n_node] = b->n++;
    return b->n_node++;
}

static void join(barycentres *b, int a, int c)
{
    b->rod[b->n_rod][0] = a;
    b->rod[b->n_rod++][1] = c;
}

/* Posts around the outer loop: on a circle, or with a ground on a half circle above its line. */
static void fence(const lw_web *w, barycentres *b)
{
    const uint8_t *v = w->face;
    int n = w->face_first[1], k = w->n_ground;
    for (int i = 0; i < k; i++) {
        b->number[w->ground[i]] = -1;
        b->place[w->ground[i]] = lw_v2(i - (k - 1)/2.0, 0);
    }
    for (int i = 0; i < (k ? n - 1 : n); i++) {
        double turn = k ? LW_PI - LW_PI*(i + 0.5)/(n - 1) : 2*LW_PI*(i + 0.5)/n;
        int post = b->n_node++;
        b->number[post] = -1;
        b->place[post] = lw_v2_polar((k ? (k + 1)/2.0 : 1), turn);
        join(b, post, v[i]);
        join(b, post, v[(i + 1) % n]);
    }
}

/* A point inside a face that holds it open; a face that touches itself gets a ring of points inside first. */
static void hold_open(const lw_web *w, int face, barycentres *b)
{
    const uint8_t *v = w->face + w->face_first[face];
    int n = w->face_first[face + 1] - w->face_first[face];
    uint8_t count[LW_WEB_VERTEX] = { 0 };
    bool simple = true;
    for (int i = 0; i < n; i++)
        simple = simple && count[v[i]]++ == 0;
    if (n < 4)
        return;
    int middle = new_node(b);
    for (int i = 0; i < n; i++) {
        if (simple) {
            join(b, middle, v[i]);
            continue;
        }
        int post = new_node(b);
        join(b, post, v[i]);
        join(b, post, v[(i + 1) % n]);
        join(b, post, middle);
        join(b, post, i + 1 < n ? post + 1 : post + 1 - n);
    }
}

static lw_status solve(barycentres *b)
{
    size_t n = (size_t)b->n;
    double *a = calloc(n*n + 3*n + 1, sizeof *a), *diag = a + n*n, *x = diag + n, *y = x + n;
    if (!a)
        return LW_E_MEMORY;
    for (int k = 0; k < b->n_rod; k++)
        for (int side = 0; side < 2; side++) {
            int at = b->rod[k][side], to = b->rod[k][1 - side], row = b->number[at];
            if (row < 0)
                continue;
            a[(size_t)row*(n + 1)] += 1;
            if (b->number[to] >= 0) {
                a[(size_t)row + n*(size_t)b->number[to]] -= 1;
            } else {
                x[row] += b->place[to].x;
                y[row] += b->place[to].y;
            }
        }
    if (b->n > 0) {
        lw_qr_factor(b->n, b->n, a, diag);
        lw_qr_solve(b->n, b->n, a, diag, x);
        lw_qr_solve(b->n, b->n, a, diag, y);
    }
    for (int i = 0; i < b->n_node; i++)
        if (b->number[i] >= 0)
            b->place[i] = lw_v2(x[b->number[i]], y[b->number[i]]);
    free(a);
    return LW_OK;
}

lw_status lw_web_start(const lw_web *w, lw_vec2 *p)
{
    enum { NODES = LW_WEB_VERTEX + 8*LW_DART_MAX, RODS = 24*LW_DART_MAX };
    struct room { int number[NODES]; lw_vec2 place[NODES]; int rod[RODS][2]; } *room = calloc(1, sizeof *room);
    if (!room)
        return LW_E_MEMORY;
    barycentres b = { .number = room->number, .place = room->place, .rod = room->rod };
    bool fixed[LW_WEB_VERTEX] = { false };
    for (int i = 0; i < w->n_ground; i++)
        fixed[w->ground[i]] = true;
    for (b.n_node = 0; b.n_node < w->n_vertex; b.n_node++)
        b.number[b.n_node] = fixed[b.n_node] ? -1 : b.n++;
    fence(w, &b);
    for (int i = 0; i < w->n_edge; i++)
        join(&b, w->edge[i][0], w->edge[i][1]);
    for (int i = 1; i < w->n_face; i++)
        hold_open(w, i, &b);
    lw_status s = solve(&b);
    memcpy(p, b.place, (size_t)w->n_vertex*sizeof *p);
    free(room);
    return s;
}
