/* catalogues/chain_layout_relax.c - from a first drawing without crossings to an even one
 *
 * Energy, with a bar 1 long, r = distance / wanted distance and h = distance of a joint from a link:
 *     springs   w (r - 1/r)^2 / 4      inside a link: its regular shape; between others: their way apart
 *     barrier   b (room/h - 1)^2       for h < room; joints against links they are not of
 *     corner    o (cos a - cos a0)^2   for angles a < a0 between sides that meet
 * Descent by L-BFGS (Nocedal 1980).  No joint moves half as far as the nearest link is in one step, so that
 * nothing passes through anything. */
#include <stdlib.h>
#include <string.h>

#include "catalogues/chain_layout_internal.h"

#define ROOM      0.9      /* distance from which links push joints away                          */
#define PUSH      0.7      /* weight of that                                                      */
#define SHARP     0.72     /* cosine of the angle from which a corner is opened: 44 degrees       */
#define OPEN      30.0     /* weight of that                                                      */
#define FAR       0.06     /* weight of springs between joints that share no link                 */
#define SPAN      0.95     /* their wanted distance against the shortest way along links          */
#define ABOVE     0.55     /* distance wanted above the line of the ground                        */
#define MEMORY    6        /* steps that L-BFGS looks back                                        */

/* Side against bar and circumference: chord of m sides of a regular polygon of k corners with side 1. */
static double chord(int k, int m)
{
    double side = k > 4 ? 0.85 : 1;
    return side*sin(LW_PI*m/k)/sin(LW_PI/k);
}

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
                far[a*n + b] = fmin(far[a*n + b], far[a*n + via] + far[via*n + b]);
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
                r->spring[r->n_spring++] = (lw_spring){ v[a], v[b], chord(k, a - b), step == 1 ? 1 : 0.6 };
            }
    }
    bool ground[LW_WEB_VERTEX] = { false };
    for (int i = 0; i < w->n_ground; i++)
        ground[w->ground[i]] = true;
    for (int a = 0; a < n; a++)
        for (int b = 0; b < a; b++)
            if (!inside[a][b] && far[a*n + b] < 1e8) {
                double length = SPAN*far[a*n + b];
                double weight = ground[a] && ground[b] ? 0.5*FAR : FAR;
                r->spring[r->n_spring++] = (lw_spring){ (uint8_t)a, (uint8_t)b, length, weight };
            }
}

/* Pairs of sides that meet: the joint between them, then the two others. */
static void add_corners(const lw_web *w, lw_relax *r)
{
    for (int i = 0; i < w->n_edge; i++)
        for (int k = 0; k < i; k++)
            for (int way = 0; way < 4; way++) {
                const uint8_t *a = w->edge[i], *b = w->edge[k];
                if (a[way & 1] != b[way >> 1])
                    continue;
                uint8_t *c = r->corner[r->n_corner++];
                c[0] = a[way & 1];
                c[1] = a[!(way & 1)];
                c[2] = b[!(way >> 1)];
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
    r->pair = malloc((n*e + 1)*sizeof *r->pair);
    r->corner = malloc((e*e/2 + 1)*sizeof *r->corner);
    r->number = malloc((2*n*(2*MEMORY + 5) + n)*sizeof *r->number);
    if (!far || !r->spring || !r->pair || !r->corner || !r->number) {
        free(far);
        lw_relax_free(r);
        return LW_E_MEMORY;
    }
    fill_distances(w, far);
    add_springs(w, far, r);
    free(far);
    add_corners(w, r);
    for (int k = 0; k < w->n_edge; k++)
        for (int v = 0; v < w->n_vertex; v++)
            if (w->edge[k][0] != v && w->edge[k][1] != v) {
                r->pair[r->n_pair][0] = (uint8_t)v;
                r->pair[r->n_pair++][1] = (uint8_t)k;
            }
    return LW_OK;
}

void lw_relax_free(lw_relax *r)
{
    free(r->spring);
    free(r->pair);
    free(r->corner);
    free(r->number);
    *r = (lw_relax){ 0 };
}

/* ---- energy ------------------------------------------------------------------------------------- */

static double springs(const lw_relax *r, const lw_vec2 *p, lw_vec2 *g)
{
    double f = 0;
    for (int i = 0; i < r->n_spring; i++) {
        const lw_spring *s = &r->spring[i];
        double x = p[s->a].x - p[s->b].x, y = p[s->a].y - p[s->b].y;
        double d2 = fmax(x*x + y*y, 1e-12)/(s->length*s->length), back = 1/d2;
        f += 0.25*s->weight*(d2 + back - 2);
        double slope = 0.5*s->weight*(1 - back*back)/(s->length*s->length);
        g[s->a].x += slope*x;
        g[s->a].y += slope*y;
        g[s->b].x -= slope*x;
        g[s->b].y -= slope*y;
    }
    return f;
}

/* Also the distance of every joint from the nearest link, and of every link from the nearest joint, at the joints: how
 * far each may go. */
static double barrier(const lw_web *w, const lw_relax *r, const lw_vec2 *p, lw_vec2 *g, double *clear2)
{
    double f = 0;
    for (int i = 0; i < r->n_pair; i++) {
        int v = r->pair[i][0];
        const uint8_t *end = w->edge[r->pair[i][1]];
        lw_vec2 a = p[end[0]], line = lw_v2_sub(p[end[1]], a), q = lw_v2_sub(p[v], a);
        double l2 = line.x*line.x + line.y*line.y, t = (q.x*line.x + q.y*line.y)/fmax(l2, 1e-18);
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        double x = q.x - t*line.x, y = q.y - t*line.y, h2 = fmax(x*x + y*y, 1e-18);
        clear2[v] = h2 < clear2[v] ? h2 : clear2[v];
        clear2[end[0]] = h2 < clear2[end[0]] ? h2 : clear2[end[0]];
        clear2[end[1]] = h2 < clear2[end[1]] ? h2 : clear2[end[1]];
        if (h2 >= ROOM*ROOM)
            continue;
        double h = sqrt(h2), over = ROOM/h - 1, slope = -2*PUSH*over*ROOM/(h2*h);
        f += PUSH*over*over;
        g[v].x += slope*x;
        g[v].y += slope*y;
        g[end[0]].x -= (1 - t)*slope*x;
        g[end[0]].y -= (1 - t)*slope*y;
        g[end[1]].x -= t*slope*x;
        g[end[1]].y -= t*slope*y;
    }
    return f;
}

/* Sides that meet: the sharper the angle, the more is to be gained by opening it. */
static double corners(const lw_relax *r, const lw_vec2 *p, lw_vec2 *g)
{
    double f = 0;
    for (int i = 0; i < r->n_corner; i++) {
        const uint8_t *v = r->corner[i];
        lw_vec2 a = lw_v2_sub(p[v[1]], p[v[0]]), b = lw_v2_sub(p[v[2]], p[v[0]]);
        double a2 = fmax(lw_v2_dot(a, a), 1e-18), b2 = fmax(lw_v2_dot(b, b), 1e-18), ab = sqrt(a2*b2);
        double cosine = lw_v2_dot(a, b)/ab, over = cosine - SHARP;
        if (over <= 0)
            continue;
        double slope = 2*OPEN*over;
        lw_vec2 ga = lw_v2_scale(lw_v2_sub(lw_v2_scale(b, 1/ab), lw_v2_scale(a, cosine/a2)), slope);
        lw_vec2 gb = lw_v2_scale(lw_v2_sub(lw_v2_scale(a, 1/ab), lw_v2_scale(b, cosine/b2)), slope);
        f += OPEN*over*over;
        g[v[1]] = lw_v2_add(g[v[1]], ga);
        g[v[2]] = lw_v2_add(g[v[2]], gb);
        g[v[0]] = lw_v2_sub(g[v[0]], lw_v2_add(ga, gb));
    }
    return f;
}

/* Everything that is not on the line of the ground stays above it. */
static double above(const lw_web *w, const lw_vec2 *p, lw_vec2 *g, double *clear2)
{
    double f = 0;
    bool ground[LW_WEB_VERTEX] = { false };
    for (int i = 0; i < w->n_ground; i++)
        ground[w->ground[i]] = true;
    for (int v = 0; v < w->n_vertex; v++) {
        double y = fmax(p[v].y, 1e-9);
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

static double dot(int n, const double *a, const double *b)
{
    double s = 0;
    for (int i = 0; i < n; i++)
        s += a[i]*b[i];
    return s;
}

/* Rounding would break the symmetry in the end: put it right by the mean over all images. */
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
    int     n, used, next;          /* numbers, steps kept, where the next one goes */
    double *s, *y, rho[MEMORY];
} memory;

/* dir = -H g by the two loops. */
static void direction(const memory *m, const double *g, double *dir)
{
    double alpha[MEMORY];
    for (int i = 0; i < m->n; i++)
        dir[i] = -g[i];
    for (int k = 1; k <= m->used; k++) {
        int at = (m->next - k + 2*MEMORY) % MEMORY;
        alpha[at] = m->rho[at]*dot(m->n, m->s + at*m->n, dir);
        for (int i = 0; i < m->n; i++)
            dir[i] -= alpha[at]*m->y[at*m->n + i];
    }
    if (m->used > 0) {
        int at = (m->next - 1 + MEMORY) % MEMORY;
        double scale = 1/(m->rho[at]*dot(m->n, m->y + at*m->n, m->y + at*m->n));
        for (int i = 0; i < m->n; i++)
            dir[i] *= scale;
    }
    for (int k = m->used; k >= 1; k--) {
        int at = (m->next - k + 2*MEMORY) % MEMORY;
        double beta = m->rho[at]*dot(m->n, m->y + at*m->n, dir);
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
    double sy = dot(m->n, s, y);
    if (sy <= 1e-10*dot(m->n, y, y))
        return;
    m->rho[m->next] = 1/sy;
    m->next = (m->next + 1) % MEMORY;
    m->used += m->used < MEMORY;
}

/* The longest part of a step that is safe: no joint goes further than 0.45 of what is free around it. */
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
        double slope = dot(n, g, dir), f1 = f, part;
        if (!(slope < 0)) {
            m.used = 0;
            direction(&m, g, dir);
            slope = dot(n, g, dir);
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
