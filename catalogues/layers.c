/* catalogues/layers.c - which link lies in which layer. */
#include "catalogues/layers.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "catalogues/anatomy.h"

#define STEPS_MAX 1000000

typedef struct work {
    const lw_scene *s;
    lw_layers      *l;
    bool            meet[LW_LINK_MAX][LW_LINK_MAX];      /* cannot be in one layer                   */
    uint32_t        hits[LW_PIN_MAX];                    /* links that come too near to the pin      */
    lw_vec2        *moved;                               /* [frame][link][corner]: corners            */
    lw_vec2        *moved_pin;                           /* [frame][pin]                              */
    int             n_layer;
    long            steps;
} work;

/* ---- plates ------------------------------------------------------------------------------------------- */

static int by_place(const void *a, const void *b)
{
    const lw_vec2 *p = a, *q = b;
    return p->x < q->x ? -1 : p->x > q->x ? 1 : p->y < q->y ? -1 : p->y > q->y;
}

/* Convex hull, counter-clockwise (Andrew's chains); corners on a line are left out.  out has room for n + 1. */
static int hull(lw_vec2 *p, int n, double size, lw_vec2 *out)
{
    int m = 0;
    qsort(p, (size_t)n, sizeof *p, by_place);
    for (int pass = 0, base = 0; pass < 2; pass++, base = m - 1)
        for (int i = 0; i < n; i++) {
            lw_vec2 q = p[pass ? n - 1 - i : i];
            if (pass && i == 0)
                continue;
            while (m - base >= 2 && lw_v2_cross(lw_v2_sub(out[m - 1], out[m - 2]), lw_v2_sub(q, out[m - 2]))
                                    <= 1e-12*size*size)
                m--;
            if (m > 0 && lw_v2_norm(lw_v2_sub(q, out[m - 1])) < 1e-9*size)
                continue;
            out[m++] = q;
        }
    return m > 1 && lw_v2_norm(lw_v2_sub(out[m - 1], out[0])) < 1e-9*size ? m - 1 : m;
}

static bool on_pin(const lw_pin *p, lw_vec2 at, int a, int b)
{
    return p->at.x == at.x && p->at.y == at.y && ((p->links >> a & 1) || (p->links >> b & 1));
}

static void add_hole(lw_layers *l, int link, lw_vec2 a, lw_vec2 b)
{
    lw_plate *p = &l->plate[link];
    for (int i = 0; i < p->n_hole; i++)
        if (p->hole[i].a.x == a.x && p->hole[i].a.y == a.y && p->hole[i].b.x == b.x && p->hole[i].b.y == b.y)
            return;
    if (p->n_hole < LW_HOLE_MAX)
        p->hole[p->n_hole++] = (lw_hole){ a, b };
}

static void add_pin(lw_layers *l, lw_vec2 at, int a, int b, int owner)
{
    for (int i = 0; i < l->n_pin; i++)
        if (on_pin(&l->pin[i], at, a, b)) {
            l->pin[i].links |= 1u << a | 1u << b;
            return;
        }
    if (l->n_pin < LW_PIN_MAX)
        l->pin[l->n_pin++] = (lw_pin){ .at = at, .links = 1u << a | 1u << b, .owner = owner };
}

/* Which links a joint makes guide and block, and where the block is on the line. */
static lw_slide slide_of(const lw_scene *s, int j)
{
    const lw_joint *p = &s->linkage.joint[j];
    if (p->kind == LW_JOINT_SLOT)
        return (lw_slide){ .guide = p->link[0], .block = p->link[1], .at = p->at, .along = p->along };
    return lw_anatomy_slide(s, j);
}

/* How far a point of the block runs along the guide's line, seen from the guide. */
static void travel(const lw_scene *s, const lw_slide *q, double *lo, double *hi)
{
    *lo = *hi = 0;
    for (size_t f = 0; f < s->n_frame; f++) {
        lw_vec2 p = lw_scene_at(s, f, q->block, q->at), o = lw_scene_at(s, f, q->guide, q->at);
        lw_vec2 d = lw_v2_sub(lw_scene_at(s, f, q->guide, lw_v2_add(q->at, q->along)), o);
        double t = lw_v2_dot(lw_v2_sub(p, o), d);
        *lo = fmin(*lo, t);
        *hi = fmax(*hi, t);
    }
}

static void add_slide(const lw_scene *s, int j, lw_layers *l)
{
    lw_slide q = slide_of(s, j);
    double lo, hi, apart = s->linkage.joint[j].kind == LW_JOINT_SLOT ? 0 : l->radius;
    travel(s, &q, &lo, &hi);
    for (int side = apart > 0 ? -1 : 1; side <= 1; side += 2) {
        lw_vec2 at = lw_v2_add(q.at, lw_v2_scale(q.along, side*apart));
        add_pin(l, at, q.guide, q.block, q.block);
        add_hole(l, q.block, at, at);
    }
    add_hole(l, q.guide, lw_v2_add(q.at, lw_v2_scale(q.along, lo - apart)),
             lw_v2_add(q.at, lw_v2_scale(q.along, hi + apart)));
}

static void make_plates(const lw_scene *s, lw_layers *l)
{
    const lw_linkage *k = &s->linkage;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *p = &k->joint[j];
        if (p->kind != LW_JOINT_REVOLUTE) {
            add_slide(s, j, l);
            continue;
        }
        add_pin(l, p->at, p->link[0], p->link[1], p->link[0] == k->ground ? p->link[0] : p->link[1]);
        add_hole(l, p->link[0], p->at, p->at);
        add_hole(l, p->link[1], p->at, p->at);
    }
    for (int t = 0; t < k->n_tracer; t++)
        add_hole(l, k->tracer[t].link, k->tracer[t].at, k->tracer[t].at);
    for (int link = 0; link < k->n_link; link++) {
        lw_plate *q = &l->plate[link];
        lw_vec2 p[2*LW_HOLE_MAX], out[2*LW_HOLE_MAX + 2];
        int n = 0;
        for (int i = 0; i < q->n_hole; i++) {
            p[n++] = q->hole[i].a;
            p[n++] = q->hole[i].b;
        }
        n = hull(p, n, lw_v2_norm(lw_v2_sub(p[0], p[n - 1])) + l->radius, out);
        q->n_corner = n < LW_CORNER_MAX ? n : LW_CORNER_MAX;
        memcpy(q->corner, out, (size_t)q->n_corner*sizeof *out);
    }
}

/* A third of the shortest distance of two pins of one link. */
static double usual_radius(const lw_linkage *k)
{
    double least = INFINITY, size = 0;
    for (int i = 0; i < k->n_joint; i++)
        for (int j = 0; j < i; j++) {
            const lw_joint *p = &k->joint[i], *q = &k->joint[j];
            double d = lw_v2_norm(lw_v2_sub(p->at, q->at));
            bool shared = p->link[0] == q->link[0] || p->link[0] == q->link[1] || p->link[1] == q->link[0]
                       || p->link[1] == q->link[1];
            size = fmax(size, d);
            if (shared && d > 0 && p->kind == LW_JOINT_REVOLUTE && q->kind == LW_JOINT_REVOLUTE)
                least = fmin(least, d);
        }
    return fmin(least/3, size/25);
}

/* ---- what is in the way ---------------------------------------------------------------------------------- */

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

static lw_vec2 *corners(const work *w, size_t frame, int link)
{
    return w->moved + (frame*LW_LINK_MAX + (size_t)link)*LW_CORNER_MAX;
}

static bool move_all(work *w)
{
    const lw_layers *l = w->l;
    const lw_scene *s = w->s;
    w->moved = malloc(s->n_frame*LW_LINK_MAX*LW_CORNER_MAX*sizeof *w->moved);
    w->moved_pin = malloc(s->n_frame*LW_PIN_MAX*sizeof *w->moved_pin);
    if (!w->moved || !w->moved_pin)
        return false;
    for (size_t f = 0; f < s->n_frame; f++) {
        for (int link = 0; link < s->linkage.n_link; link++)
            for (int c = 0; c < l->plate[link].n_corner; c++)
                corners(w, f, link)[c] = lw_scene_at(s, f, link, l->plate[link].corner[c]);
        for (int p = 0; p < l->n_pin; p++)
            w->moved_pin[f*LW_PIN_MAX + (size_t)p] = lw_scene_at(s, f, l->pin[p].owner, l->pin[p].at);
    }
    return true;
}

/* The posture before f; the first when the motion goes back and forth. */
static size_t before(const lw_scene *s, size_t f) { return f > 0 ? f - 1 : s->loops ? s->n_frame - 1 : 0; }

/* Half the way that a plate makes from the posture before f. */
static double half_step(const work *w, size_t f, int link)
{
    size_t g = before(w->s, f);
    double d = 0;
    for (int c = 0; c < w->l->plate[link].n_corner; c++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(corners(w, f, link)[c], corners(w, g, link)[c])));
    return 0.5*d;
}

static double half_pin_step(const work *w, size_t f, int pin)
{
    const lw_vec2 *now = w->moved_pin + f*LW_PIN_MAX, *then = w->moved_pin + before(w->s, f)*LW_PIN_MAX;
    return 0.5*lw_v2_norm(lw_v2_sub(now[pin], then[pin]));
}

static bool plates_meet(const work *w, int a, int b)
{
    const lw_plate *p = &w->l->plate[a], *q = &w->l->plate[b];
    for (size_t f = 0; f < w->s->n_frame; f++) {
        double step = half_step(w, f, a) + half_step(w, f, b);
        size_t g = before(w->s, f);
        double d = fmin(lw_hull_distance(corners(w, f, a), p->n_corner, corners(w, f, b), q->n_corner),
                        lw_hull_distance(corners(w, g, a), p->n_corner, corners(w, g, b), q->n_corner));
        if (d <= 2*w->l->radius + step)
            return true;
    }
    return false;
}

static bool pin_hits(const work *w, int pin, int link)
{
    const lw_plate *p = &w->l->plate[link];
    for (size_t f = 0; f < w->s->n_frame; f++) {
        double step = half_step(w, f, link) + half_pin_step(w, f, pin);
        if (point_distance(w->moved_pin[f*LW_PIN_MAX + (size_t)pin], corners(w, f, link), p->n_corner)
            <= w->l->radius + w->l->bore + step)
            return true;
    }
    return false;
}

static void find_conflicts(work *w)
{
    const lw_linkage *k = &w->s->linkage;
    for (int j = 0; j < k->n_joint; j++)
        w->meet[k->joint[j].link[0]][k->joint[j].link[1]] = w->meet[k->joint[j].link[1]][k->joint[j].link[0]] = true;
    for (int p = 0; p < w->l->n_pin; p++)
        for (int a = 0; a < k->n_link; a++)
            for (int b = 0; b < k->n_link; b++)
                if (a != b && (w->l->pin[p].links >> a & 1) && (w->l->pin[p].links >> b & 1))
                    w->meet[a][b] = true;
    for (int a = 0; a < k->n_link; a++)
        for (int b = 0; b < a; b++)
            if (a != k->ground && b != k->ground && !w->meet[a][b])
                w->meet[a][b] = w->meet[b][a] = plates_meet(w, a, b);
    for (int p = 0; p < w->l->n_pin; p++)
        for (int a = 0; a < k->n_link; a++)
            if (!(w->l->pin[p].links >> a & 1) && a != k->ground && pin_hits(w, p, a))
                w->hits[p] |= 1u << a;
}

/* ---- layers ------------------------------------------------------------------------------------------------- */

/* Does every pin pass what lies between the links placed so far? */
static bool pins_pass(work *w)
{
    lw_layers *l = w->l;
    for (int p = 0; p < l->n_pin; p++) {
        int low = LW_LINK_MAX, high = -1;
        for (int i = 0; i < w->s->linkage.n_link; i++)
            if ((l->pin[p].links >> i & 1) && l->layer[i] >= 0) {
                low = l->layer[i] < low ? l->layer[i] : low;
                high = l->layer[i] > high ? l->layer[i] : high;
            }
        l->pin[p].low = low;
        l->pin[p].high = high;
        for (int i = 0; i < w->s->linkage.n_link; i++)
            if ((w->hits[p] >> i & 1) && l->layer[i] > low && l->layer[i] < high)
                return false;
    }
    return true;
}

/* Layers (bits) that are open to a link. */
static uint32_t open_layers(work *w, int link)
{
    uint32_t open = 0;
    for (int at = 1; at < w->n_layer; at++) {
        bool free_here = true;
        for (int i = 0; free_here && i < w->s->linkage.n_link; i++)
            free_here = !(w->l->layer[i] == at && w->meet[link][i]);
        w->l->layer[link] = at;
        if (free_here && pins_pass(w))
            open |= 1u << at;
    }
    w->l->layer[link] = -1;
    return open;
}

/* The link with the fewest layers left next (Brelaz 1979), all of these in turn. */
static bool place(work *w, int left)
{
    int best = -1, fewest = LW_LINK_MAX + 1;
    uint32_t choice = 0;
    if (left == 0)
        return pins_pass(w);
    if (++w->steps > STEPS_MAX)
        return false;
    for (int i = 0; i < w->s->linkage.n_link; i++) {
        if (w->l->layer[i] >= 0)
            continue;
        uint32_t open = open_layers(w, i);
        int n = __builtin_popcount(open);
        if (n < fewest) {
            fewest = n;
            best = i;
            choice = open;
        }
    }
    for (int at = 1; at < w->n_layer; at++)
        if (choice >> at & 1) {
            w->l->layer[best] = at;
            if (place(w, left - 1))
                return true;
        }
    w->l->layer[best] = -1;
    return false;
}

static lw_status find_layers(work *w, lw_error *e)
{
    const lw_linkage *k = &w->s->linkage;
    for (w->n_layer = 2; w->n_layer <= k->n_link; w->n_layer++) {
        for (int i = 0; i < k->n_link; i++)
            w->l->layer[i] = i == k->ground ? 0 : -1;
        w->steps = 0;
        if (place(w, k->n_link - 1)) {
            w->l->n_layer = w->n_layer;
            return LW_OK;
        }
    }
    if (w->steps > STEPS_MAX)
        return lw_error_set(e, LW_STOPPED, "no layers were found in %d steps in which the links pass each other",
                            STEPS_MAX);
    return lw_error_set(e, LW_NOTHING, "there are no layers in which all links pass each other and the pins over the "
                        "whole motion; a smaller range of the input, or pins held from both sides, would help");
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static lw_status check(const lw_scene *s, lw_error *e)
{
    const lw_linkage *k = &s->linkage;
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].kind == LW_JOINT_GEAR || k->joint[j].kind == LW_JOINT_FIXED)
            return lw_error_set(e, LW_E_KIND, "joint '%s': gears and welds are not cut from plates", k->joint[j].name);
    if (s->n_frame < 2)
        return lw_error_set(e, LW_E_KIND, "plates need the motion. %s", s->note);
    return LW_OK;
}

lw_status lw_layers_find(const lw_scene *s, double radius, lw_layers *l, lw_error *e)
{
    work *w = NULL;
    lw_status st = check(s, e);
    if (st != LW_OK)
        return st;
    memset(l, 0, sizeof *l);
    l->radius = radius > 0 ? radius : usual_radius(&s->linkage);
    l->bore = 0.4*l->radius;
    l->thickness = l->radius;
    make_plates(s, l);
    w = calloc(1, sizeof *w);
    if (w) {
        w->s = s;
        w->l = l;
    }
    if (w && move_all(w)) {
        find_conflicts(w);
        st = find_layers(w, e);
    } else {
        st = lw_error_set(e, LW_E_MEMORY, "out of memory for the layers of a linkage");
    }
    if (w) {
        free(w->moved);
        free(w->moved_pin);
    }
    free(w);
    return st;
}
