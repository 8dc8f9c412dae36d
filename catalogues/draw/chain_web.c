/* catalogues/draw/chain_web.c - the map of joints of an embedding, its first places, and its relaxation. */
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"

#include "base/linalg.h"
#include "catalogues/draw/chain_layout_internal.h"

/* ==== the map ================================================================================================= */

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

/* Find the joints that are one point: those of an axis, and in pairs those of a binary link with a pin and a slider.  At
 * most one such link in a loop of four, where otherwise two bars would cover each other. */
static void merge_joints(const lw_mechanism *m, uint32_t axes, uint8_t *same_as)
{
    int n_joint[LW_LINK_MAX] = { 0 }, joint[LW_LINK_MAX][2], beside[LW_LINK_MAX][2], n_done = 0;
    for (int j = 0; j < m->n_joint; j++) {
        same_as[j] = (uint8_t)j;
        for (int side = 0; side < 2; side++) {
            int i = m->link[j][side];
            if (n_joint[i]++ < 2)
                joint[i][n_joint[i] - 1] = j;
            if (axes >> i & 1)
                same_as[j] = (uint8_t)joint[i][0];
        }
    }
    for (int i = 0; i < m->n_link; i++) {
        if (n_joint[i] != 2 || i == m->ground)
            continue;
        int a = joint[i][0], b = joint[i][1];
        int p = m->link[a][0] + m->link[a][1] - i, q = m->link[b][0] + m->link[b][1] - i;
        bool block = lw_joint_can_drive(m->kind[a]) && lw_joint_can_drive(m->kind[b]) && m->kind[a] != m->kind[b];
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

/* List the vertices of a link in the order of its outline, from dart `first`. A link with one joint gets a free end. */
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

/* Add edges, links, and polygons as faces. The ground is no face: it lies outside. */
static void add_links(const lw_mechanism *m, const lw_rings *r, lw_web *w)
{
    int first[LW_LINK_MAX];
    for (int d = r->n_dart - 1; d >= 0; d--)
        first[r->link[d]] = d;
    for (int i = 0; i < m->n_link; i++) {
        uint8_t v[LW_LINK_MAX];
        int n = outline(r, w, first[i], v);
        if (i == m->ground || r->axes >> i & 1)
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

/* Add one loop as a closed path over vertices. place[d]: index of dart d in it. */
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

static void add_loops(const lw_mechanism *m, const lw_embedding *embedding, lw_web *w, int *place)
{
    uint8_t loop_of[LW_DART_MAX];
    int n = lw_rings_loops(&embedding->rings, loop_of), other[LW_DART_MAX];
    int outer = loop_of[embedding->outer];
    int first = m->ground == LW_NONE ? embedding->outer : embedding->rings.after[embedding->outer ^ 1];
    for (int d = 0; d < embedding->rings.n_dart; d++)
        place[d] = -1;
    add_loop(&embedding->rings, w, first, place);
    for (int i = 0; i < n; i++)
        for (int d = 0; i != outer && d < embedding->rings.n_dart; d++)
            if (loop_of[d] == i) {
                add_loop(&embedding->rings, w, d, other);
                break;
            }
}

/* Turn the symmetries of the map into rotations and reflections of the page. Only the identity is kept if merged blocks
 * do not map to merged blocks. */
static void add_group(const lw_mechanism *m, const lw_embedding *embedding, const int *place, lw_web *w)
{
    lw_layout_symmetry g;
    int size = w->face_first[1];
    lw_embedding_symmetry(m, embedding, &g);
    for (int k = 0; k < g.n; k++) {
        int image = g.to[k][embedding->outer];
        memset(w->to[k], 255, sizeof w->to[k]);
        bool fits = true;
        for (int d = 0; d < embedding->rings.n_dart; d++) {
            uint8_t *to = &w->to[k][w->vertex_of[d >> 1]], wanted = w->vertex_of[g.to[k][d] >> 1];
            fits = fits && (*to == 255 || *to == wanted);
            *to = wanted;
            if (w->end_of[embedding->rings.link[d]] != 255)
                w->to[k][w->end_of[embedding->rings.link[d]]] = w->end_of[embedding->rings.link[g.to[k][d]]];
        }
        if (!fits && k > 0) {
            w->n_group = 1;
            return;
        }
        int shift = place[g.mirror[k] ? image ^ 1 : image] - (g.mirror[k] ? 0 : place[embedding->outer]);
        shift += g.mirror[k] ? place[embedding->outer] : 0;
        w->mirror[k] = g.mirror[k];
        w->turn[k] = lw_v2_polar(1, 2*LW_PI*shift/size);
        if (m->ground != LW_NONE)
            w->turn[k] = lw_v2(g.mirror[k] ? -1 : 1, 0);          /* reflection in the vertical axis */
        w->n_group = k + 1;
    }
}

void lw_web_make(const lw_mechanism *m, const lw_embedding *embedding, lw_web *w)
{
    uint8_t same_as[LW_JOINT_MAX];
    int place[LW_DART_MAX];
    memset(w, 0, sizeof *w);
    merge_joints(m, embedding->rings.axes, same_as);
    for (int j = 0; j < m->n_joint; j++)
        if (same_as[j] == j)
            w->vertex_of[j] = (uint8_t)w->n_vertex++;
    for (int j = 0; j < m->n_joint; j++)
        w->vertex_of[j] = w->vertex_of[same_as[j]];
    memset(w->end_of, 255, sizeof w->end_of);
    for (int d = 0; d < embedding->rings.n_dart; d++)
        if (degree_of(&embedding->rings, d) == 1 && embedding->rings.link[d] != m->ground)
            w->end_of[embedding->rings.link[d]] = (uint8_t)w->n_vertex++;
    if (m->ground != LW_NONE)
        w->n_ground = outline(&embedding->rings, w, embedding->rings.after[embedding->outer ^ 1], w->ground);
    if (w->n_ground == 2 && w->ground[1] == 255)
        w->n_ground = 1;                                           /* a ground with one joint has no free end */
    add_loops(m, embedding, w, place);
    add_links(m, &embedding->rings, w);
    add_group(m, embedding, place, w);
}

/* ---- first places ------------------------------------------------------------------------------- */

typedef struct system {
    int      n, n_node;            /* unknown nodes are numbered 0 .. n-1; fixed nodes have a given place */
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

/* Fix a ring of posts around the outer loop: on a circle, or with a ground on a half circle above its line. */
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

/* Add a point inside a face so that the face does not collapse. A face that touches itself first gets a ring of points
 * inside. */
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
    struct arrays { int number[NODES]; lw_vec2 place[NODES]; int rod[RODS][2]; } *arrays = calloc(1, sizeof *arrays);
    if (!arrays)
        return LW_E_MEMORY;
    barycentres b = { .number = arrays->number, .place = arrays->place, .rod = arrays->rod };
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
    free(arrays);
    return s;
}

/* ==== relaxing ================================================================================================ */

#define ROOM      0.9      /* below this distance, links push joints away                         */
#define PUSH      0.7      /* weight of that repulsion                                            */
#define SHARP     0.72     /* cosine of the angle (44 degrees) below which a corner is opened     */
#define OPEN      30.0     /* weight of that                                                      */
#define STRAIGHT  0.96     /* cosine of the angle (16 degrees) from straight below which two sides at a joint are */
#define BEND      600.0    /* bent: links in a row would look like one bar; weight of that           */
#define FAR       0.06     /* weight of springs between joints that share no link                 */
#define SPAN      0.95     /* length of those springs / shortest path along links                */
#define ABOVE     0.55     /* distance wanted above the line of the ground                        */
#define MEMORY    6        /* steps that L-BFGS remembers                                         */

/* Distance of two corners, m sides apart, of a regular polygon with k sides of length 1. */
static double chord(int k, int m)
{
    double side = k > 4 ? 0.85 : 1;
    return side*sin(LW_PI*m/k)/sin(LW_PI/k);
}

static double lesser(double a, double b) { return a < b ? a : b; }

static void fill_distances(const lw_web *w, double *far)
{
    int n = w->n_vertex;
    for (int i = 0; i < n*n; i++)
        far[i] = i % (n + 1) ? 1e9 : 0;
    for (int l = 0; l < w->n_link; l++) {
        const uint8_t *v = w->link + w->link_first[l];
        int k = w->link_first[l + 1] - w->link_first[l];
        for (int a = 0; a < k; a++)
            for (int b = 0; b < k; b++)
                if (a != b && v[a] != v[b])
                    far[v[a]*n + v[b]] = chord(k, abs(a - b));
    }
    for (int via = 0; via < n; via++)                                       /* Floyd 1962 */
        for (int a = 0; a < n; a++)
            for (int b = 0; b < n; b++)
                far[a*n + b] = lesser(far[a*n + b], far[a*n + via] + far[via*n + b]);
}

static void add_spring(lw_relax *r, int a, int b, double length, double weight)
{
    r->spring[r->n_spring++] = (lw_layout_spring){ (uint8_t)a, (uint8_t)b, length, 1/(length*length), weight };
}

static void add_springs(const lw_web *w, const double *far, lw_relax *r)
{
    int n = w->n_vertex;
    uint8_t inside[LW_WEB_VERTEX][LW_WEB_VERTEX];
    memset(inside, 0, sizeof inside);
    for (int l = 0; l < w->n_link; l++) {
        const uint8_t *v = w->link + w->link_first[l];
        int k = w->link_first[l + 1] - w->link_first[l];
        for (int a = 0; a < k; a++)
            for (int b = 0; b < a; b++) {
                int step = a - b < k - a + b ? a - b : k - a + b;
                if (v[a] == v[b])
                    continue;
                inside[v[a]][v[b]] = inside[v[b]][v[a]] = 1;
                add_spring(r, v[a], v[b], chord(k, a - b), step == 1 ? 1 : 0.6);
            }
    }
    bool ground[LW_WEB_VERTEX] = { false };
    for (int i = 0; i < w->n_ground; i++)
        ground[w->ground[i]] = true;
    for (int a = 0; a < n; a++)
        for (int b = 0; b < a; b++)
            if (!inside[a][b] && far[a*n + b] < 1e8)
                add_spring(r, a, b, SPAN*far[a*n + b], ground[a] && ground[b] ? 0.5*FAR : FAR);
}

/* List the corners: pairs of sides with a common joint, as that joint and the two other ends. */
static void add_corners(const lw_web *w, lw_relax *r)
{
    for (int i = 0; i < w->n_edge; i++)
        for (int k = 0; k < i; k++)
            for (int embedding = 0; embedding < 4; embedding++) {
                const uint8_t *a = w->edge[i], *b = w->edge[k];
                if (a[embedding & 1] != b[embedding >> 1])
                    continue;
                uint8_t *c = r->corner[r->n_corner++];
                c[0] = a[embedding & 1];
                c[1] = a[!(embedding & 1)];
                c[2] = b[!(embedding >> 1)];
            }
}

lw_status lw_relax_make(const lw_web *w, lw_relax *r)
{
    size_t n = (size_t)w->n_vertex, e = (size_t)w->n_edge;
    size_t inside = 0;
    for (int l = 0; l < w->n_link; l++)
        inside += (size_t)LW_LINK_MAX*(size_t)(w->link_first[l + 1] - w->link_first[l]);
    *r = (lw_relax){ 0 };
    double *far = malloc(n*n*sizeof *far);
    r->spring = malloc((n*n/2 + inside)*sizeof *r->spring);
    r->corner = malloc((e*e/2 + 1)*sizeof *r->corner);
    r->number = malloc((2*n*(2*MEMORY + 5) + n)*sizeof *r->number);
    if (!far || !r->spring || !r->corner || !r->number) {
        free(far);
        lw_relax_free(r);
        return LW_E_MEMORY;
    }
    fill_distances(w, far);
    add_springs(w, far, r);
    free(far);
    add_corners(w, r);
    return LW_OK;
}

void lw_relax_free(lw_relax *r)
{
    free(r->spring);
    free(r->corner);
    free(r->number);
    *r = (lw_relax){ 0 };
}

/* ---- energy ------------------------------------------------------------------------------------- */

static double springs(const lw_relax *r, const lw_vec2 *p, lw_vec2 *g)
{
    double f = 0;
    for (int i = 0; i < r->n_spring; i++) {
        const lw_layout_spring *s = &r->spring[i];
        double x = p[s->a].x - p[s->b].x, y = p[s->a].y - p[s->b].y, r2 = x*x + y*y;
        double d2 = (r2 > 1e-12 ? r2 : 1e-12)*s->scale, back = 1/d2;
        f += 0.25*s->weight*(d2 + back - 2);
        double slope = 0.5*s->weight*(1 - back*back)*s->scale;
        g[s->a].x += slope*x;
        g[s->a].y += slope*y;
        g[s->b].x -= slope*x;
        g[s->b].y -= slope*y;
    }
    return f;
}

/* Squared distance h2 of every vertex from a side, and parameter t (0 .. 1) of the nearest point on the side. */
static void distances(const lw_vec2 *p, int n, lw_vec2 a, lw_vec2 line, double *t, double *h2)
{
    double l2 = line.x*line.x + line.y*line.y, part = 1/(l2 > 1e-18 ? l2 : 1e-18);
    for (int v = 0; v < n; v++) {
        double qx = p[v].x - a.x, qy = p[v].y - a.y, at = (qx*line.x + qy*line.y)*part;
        at = at < 0 ? 0 : at > 1 ? 1 : at;
        double x = qx - at*line.x, y = qy - at*line.y, d2 = x*x + y*y;
        t[v] = at;
        h2[v] = d2 > 1e-18 ? d2 : 1e-18;
    }
}

/* Energy and gradient of the repulsion between a side and all joints that are not its ends. Also update clear2, the
 * squared distance up to which each joint is free: to the nearest link, and for the ends of a side to the nearest
 * joint. */
static double push(const lw_web *w, const uint8_t *end, const lw_vec2 *p, lw_vec2 *g, double *clear2)
{
    double t[LW_WEB_VERTEX], h2[LW_WEB_VERTEX], f = 0, least = 1e18;
    lw_vec2 a = p[end[0]], line = lw_v2_sub(p[end[1]], a), sum[2] = { { 0, 0 }, { 0, 0 } };
    distances(p, w->n_vertex, a, line, t, h2);
    h2[end[0]] = h2[end[1]] = 1e18;
    for (int v = 0; v < w->n_vertex; v++) {
        clear2[v] = h2[v] < clear2[v] ? h2[v] : clear2[v];
        least = h2[v] < least ? h2[v] : least;
    }
    for (int k = 0; k < 2; k++)
        clear2[end[k]] = least < clear2[end[k]] ? least : clear2[end[k]];
    for (int v = 0; v < w->n_vertex && least < ROOM*ROOM; v++) {
        if (h2[v] >= ROOM*ROOM)
            continue;
        double h = sqrt(h2[v]), over = ROOM/h - 1, slope = -2*PUSH*over*ROOM/(h2[v]*h);
        double x = slope*(p[v].x - a.x - t[v]*line.x), y = slope*(p[v].y - a.y - t[v]*line.y);
        f += PUSH*over*over;
        g[v] = lw_v2_add(g[v], lw_v2(x, y));
        sum[0] = lw_v2_add(sum[0], lw_v2((1 - t[v])*x, (1 - t[v])*y));
        sum[1] = lw_v2_add(sum[1], lw_v2(t[v]*x, t[v]*y));
    }
    for (int k = 0; k < 2; k++)
        g[end[k]] = lw_v2_sub(g[end[k]], sum[k]);
    return f;
}

static double barrier(const lw_web *w, const lw_relax *r, const lw_vec2 *p, lw_vec2 *g, double *clear2)
{
    double f = 0;
    for (int i = 0; i < w->n_edge; i++)
        if (!(r->ghost >> w->edge_link[i] & 1))
            f += push(w, w->edge[i], p, g, clear2);
    return f;
}

/* Energy and gradient of corners: greater for sharper angles. */
static double corners(const lw_relax *r, const lw_vec2 *p, lw_vec2 *g)
{
    double f = 0;
    for (int i = 0; i < r->n_corner; i++) {
        const uint8_t *v = r->corner[i];
        lw_vec2 a = lw_v2_sub(p[v[1]], p[v[0]]), b = lw_v2_sub(p[v[2]], p[v[0]]);
        double ab = lw_v2_dot(a, b), a2 = lw_v2_dot(a, a) + 1e-18, b2 = lw_v2_dot(b, b) + 1e-18;
        double limit = ab > 0 ? SHARP : STRAIGHT, weight = ab > 0 ? OPEN : BEND;
        if (ab*ab <= limit*limit*a2*b2)
            continue;
        double length = 1/sqrt(a2*b2), cosine = ab*length, over = cosine - (ab > 0 ? limit : -limit);
        double slope = 2*weight*over;
        lw_vec2 ga = lw_v2_scale(lw_v2_sub(lw_v2_scale(b, length), lw_v2_scale(a, cosine/a2)), slope);
        lw_vec2 gb = lw_v2_scale(lw_v2_sub(lw_v2_scale(a, length), lw_v2_scale(b, cosine/b2)), slope);
        f += weight*over*over;
        g[v[1]] = lw_v2_add(g[v[1]], ga);
        g[v[2]] = lw_v2_add(g[v[2]], gb);
        g[v[0]] = lw_v2_sub(g[v[0]], lw_v2_add(ga, gb));
    }
    return f;
}

/* Energy and gradient that keep all joints not on the ground's line above it. */
static double above(const lw_web *w, const lw_vec2 *p, lw_vec2 *g, double *clear2)
{
    double f = 0;
    bool ground[LW_WEB_VERTEX] = { false };
    for (int i = 0; i < w->n_ground; i++)
        ground[w->ground[i]] = true;
    for (int v = 0; v < w->n_vertex; v++) {
        double y = p[v].y > 1e-9 ? p[v].y : 1e-9;
        if (ground[v]) {
            g[v].y = 0;
            continue;
        }
        clear2[v] = y*y < clear2[v] ? y*y : clear2[v];
        if (y < ABOVE) {
            f += PUSH*(ABOVE/y - 1)*(ABOVE/y - 1);
            g[v].y -= 2*PUSH*(ABOVE/y - 1)*ABOVE/(y*y);
        }
    }
    return f;
}

static double energy(const lw_web *w, const lw_relax *r, const lw_vec2 *p, lw_vec2 *g, double *clear2)
{
    memset(g, 0, (size_t)w->n_vertex*sizeof *g);
    for (int i = 0; i < w->n_vertex; i++)
        clear2[i] = 1e18;
    double f = springs(r, p, g) + barrier(w, r, p, g, clear2) + corners(r, p, g);
    if (w->n_ground > 0)
        f += above(w, p, g, clear2);
    return f;
}

/* ---- descent ------------------------------------------------------------------------------------ */

/* Rounding would slowly break the symmetry: replace each place by the mean over all its images. */
static void keep_symmetry(const lw_web *w, lw_vec2 *p)
{
    lw_vec2 mean[LW_WEB_VERTEX], middle = { 0, 0 };
    if (w->n_group < 2)
        return;
    for (int v = 0; v < w->n_vertex; v++)
        middle = lw_v2_add(middle, lw_v2_scale(p[v], 1.0/w->n_vertex));
    if (w->n_ground)
        middle.y = 0;
    for (int v = 0; v < w->n_vertex; v++)
        mean[v] = lw_v2(0, 0);
    for (int k = 0; k < w->n_group; k++)
        for (int v = 0; v < w->n_vertex; v++) {
            lw_vec2 q = lw_v2_sub(p[v], middle);
            q = w->n_ground ? lw_v2(w->mirror[k] ? -q.x : q.x, q.y)
                            : lw_v2_turn(w->mirror[k] ? lw_v2(q.x, -q.y) : q, w->turn[k]);
            mean[w->to[k][v]] = lw_v2_add(mean[w->to[k][v]], lw_v2_scale(q, 1.0/w->n_group));
        }
    for (int v = 0; v < w->n_vertex; v++)
        p[v] = w->n_ground ? mean[v] : lw_v2_add(mean[v], middle);
}

typedef struct memory {
    int     n, used, next;          /* unknowns, steps kept, index of the next one */
    double *s, *y, rho[MEMORY];
} memory;

/* dir = -H g by the two-loop recursion of L-BFGS. */
static void direction(const memory *m, const double *g, double *dir)
{
    double alpha[MEMORY];
    for (int i = 0; i < m->n; i++)
        dir[i] = -g[i];
    for (int k = 1; k <= m->used; k++) {
        int at = (m->next - k + 2*MEMORY) % MEMORY;
        alpha[at] = m->rho[at]*lw_dot(m->n, m->s + at*m->n, dir);
        for (int i = 0; i < m->n; i++)
            dir[i] -= alpha[at]*m->y[at*m->n + i];
    }
    if (m->used > 0) {
        int at = (m->next - 1 + MEMORY) % MEMORY;
        double scale = 1/(m->rho[at]*lw_dot(m->n, m->y + at*m->n, m->y + at*m->n));
        for (int i = 0; i < m->n; i++)
            dir[i] *= scale;
    }
    for (int k = m->used; k >= 1; k--) {
        int at = (m->next - k + 2*MEMORY) % MEMORY;
        double beta = m->rho[at]*lw_dot(m->n, m->y + at*m->n, dir);
        for (int i = 0; i < m->n; i++)
            dir[i] += (alpha[at] - beta)*m->s[at*m->n + i];
    }
}

static void remember(memory *m, const double *x0, const double *x1, const double *g0, const double *g1)
{
    double *s = m->s + m->next*m->n, *y = m->y + m->next*m->n;
    for (int i = 0; i < m->n; i++) {
        s[i] = x1[i] - x0[i];
        y[i] = g1[i] - g0[i];
    }
    double sy = lw_dot(m->n, s, y);
    if (sy <= 1e-10*lw_dot(m->n, y, y))
        return;
    m->rho[m->next] = 1/sy;
    m->next = (m->next + 1) % MEMORY;
    m->used += m->used < MEMORY;
}

/* The largest safe fraction of a step: no joint moves further than 0.45 of the free distance around it. */
static double safe_part(const lw_web *w, const lw_vec2 *dir, const double *clear2)
{
    double part = 1;
    for (int v = 0; v < w->n_vertex; v++) {
        double d2 = dir[v].x*dir[v].x + dir[v].y*dir[v].y;
        if (part*part*d2 > 0.2*clear2[v])
            part = sqrt(0.2*clear2[v]/d2);
    }
    return part;
}

double lw_relax_run(const lw_web *w, const lw_relax *r, int steps, lw_vec2 *p)
{
    int n = 2*w->n_vertex;
    double *x = (double *)p, *g = r->number, *dir = g + n, *x1 = dir + n, *g1 = x1 + n, *clear2 = g1 + n;
    memory m = { .n = n, .s = clear2 + n, .y = clear2 + n + MEMORY*n };
    keep_symmetry(w, p);
    double f = energy(w, r, p, (lw_vec2 *)g, clear2);
    for (int step = 0; step < steps; step++) {
        direction(&m, g, dir);
        double slope = lw_dot(n, g, dir), f1 = f, part;
        if (!(slope < 0)) {
            m.used = 0;
            direction(&m, g, dir);
            slope = lw_dot(n, g, dir);
        }
        part = safe_part(w, (lw_vec2 *)dir, clear2);
        int tries = 0;
        for (; tries < 12; tries++, part *= 0.4) {
            for (int i = 0; i < n; i++)
                x1[i] = x[i] + part*dir[i];
            keep_symmetry(w, (lw_vec2 *)x1);
            f1 = energy(w, r, (lw_vec2 *)x1, (lw_vec2 *)g1, clear2);
            if (f1 <= f + 1e-4*part*slope)
                break;
        }
        if (tries == 12 || !(f1 <= f))
            break;
        remember(&m, x, x1, g, g1);
        memcpy(x, x1, (size_t)n*sizeof *x);
        memcpy(g, g1, (size_t)n*sizeof *g);
        bool done = f - f1 < 1e-5*f1;
        f = f1;
        if (done)
            break;
    }
    return f;
}
