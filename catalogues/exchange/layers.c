/* catalogues/exchange/layers.c - choose the layer of each link; how near two bodies come to each other in a motion.
 *
 * Between two frames a corner moves at least by the chord c and, on a curved path, a little more. With d2, the second
 * difference of its places at either end, its path length is estimated as L = c + d2/2: an arc of a circle is longer
 * than its chord by about d2/12, a cusp halfway by d2/2. No point of a convex body moves further than one of its
 * corners. Two bodies move by La and Lb between the distances d0 and d1. Up to any moment they have covered at most
 * half of La + Lb, or from then on they will; so at all times
 *     distance >= (d0 + d1 - La - Lb)/2. */
#include "catalogues/exchange/layers.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/draw/body_shapes.h"

/* A plate or a pin in every frame of a scene. */
typedef struct plate_body {
    int      n;
    lw_vec2 *at;               /* corners, frame after frame (n_frame*n) owned                         */
    double  *path;              /* L from the frame before f to f, the longest of all corners (n_frame) */
    lw_vec2  lo, hi;            /* of the box that it never leaves                                      */
} plate_body;

/* seen: the least distance in the frames; sure: a lower bound of the distance between frames too. */
typedef struct approach { double seen, sure; } approach;

/* ==== distances =============================================================================================== */

/* ---- one frame --------------------------------------------------------------------------------------------- */

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

static void free_body(plate_body *b)
{
    free(b->at);
    free(b->path);
    *b = (plate_body){ 0 };
}

static double norm2(lw_vec2 v) { return lw_v2_dot(v, v); }

/* The largest second difference of a corner around frame f. At the ends of a motion back and forth, that of the next
 * inner frame. */
static double bend_at(const lw_scene *s, const plate_body *b, size_t f)
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

/* The frame before f; 0 for frame 0 of a motion back and forth. */
static size_t before(const lw_scene *s, size_t f) { return f > 0 ? f - 1 : s->loops ? s->n_frame - 1 : 0; }

static lw_status move_body(const lw_scene *s, int link, const lw_vec2 *corner, int n, plate_body *b)
{
    size_t m = (size_t)n;
    b->n = n;
    b->at = malloc((s->n_frame*m + 1)*sizeof *b->at);
    b->path = malloc(s->n_frame*sizeof *b->path);
    if (!b->at || !b->path) {
        free_body(b);
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
        b->path[f] = f == g ? 0 : sqrt(chord) + 0.5*fmax(bend_at(s, b, f), bend_at(s, b, g));
    }
    double most = 0;                                       /* within half a path of one of the two frames */
    b->lo = b->hi = b->at[0];
    for (size_t f = 0; f < s->n_frame; f++)
        most = fmax(most, b->path[f]);
    for (size_t i = 0; i < s->n_frame*m; i++) {
        b->lo = lw_v2(fmin(b->lo.x, b->at[i].x), fmin(b->lo.y, b->at[i].y));
        b->hi = lw_v2(fmax(b->hi.x, b->at[i].x), fmax(b->hi.y, b->at[i].y));
    }
    b->lo = lw_v2_sub(b->lo, lw_v2(most/2, most/2));
    b->hi = lw_v2_add(b->hi, lw_v2(most/2, most/2));
    return LW_OK;
}

/* A lower bound of the distance at all times. */
static double box_gap(const plate_body *a, const plate_body *b)
{
    return fmax(fmax(a->lo.x - b->hi.x, b->lo.x - a->hi.x), fmax(a->lo.y - b->hi.y, b->lo.y - a->hi.y));
}

static approach approach_of(const lw_scene *s, const plate_body *a, const plate_body *b)
{
    approach least = { INFINITY, INFINITY };
    size_t last = s->n_frame - 1;
    double d0 = lw_hull_distance(a->at + last*(size_t)a->n, a->n, b->at + last*(size_t)b->n, b->n);
    for (size_t f = 0; f < s->n_frame; f++) {
        double d1 = lw_hull_distance(a->at + f*(size_t)a->n, a->n, b->at + f*(size_t)b->n, b->n);
        if (f == 0 && !s->loops)
            d0 = d1;
        least.seen = fmin(least.seen, d1);
        least.sure = fmin(least.sure, 0.5*(d0 + d1 - a->path[f] - b->path[f]));
        d0 = d1;
    }
    return least;
}

/* ==== layers ================================================================================================== */

#define STEPS_MAX 100000000L          /* looks at a link or pin, in each of the two searches; about half a second each */
#define LAYERS_MAX 64                 /* in the search for fewer layers, a bit for each                                */
#define LEVELS    3                   /* of frames: the given number, 4 and 16 times that */

/* Numbers for each row: item[start[row] .. start[row + 1] - 1]. */
typedef struct table { int *start, *item; } table;

typedef struct work {
    const lw_scene *s;
    lw_layers      *l;
    /* (links + pins) x links, the pins after the links; of two links only where the first is the greater */
    uint8_t        *pair;              /* verdict                                                      */
    double         *clearance;         /* guaranteed between them [m]                                  */
    table           beside;            /* link: links that meet it; pin after the links: links that it hits */
    table           pins;              /* link: pins that go through it or that it hits                    */
    int             n_layer;
    long            steps, most_steps, left;
    int            *chosen;            /* (links) of each place: the link, the layers not tried yet (bits)    */
    uint64_t       *choice, *open;     /* (links) open: the layers in which a link can be placed now     */
    bool           *stale;             /* (links) open has to be found again                             */
    int             none;              /* so many layers, and fewer, do not do                         */
    plate_body     *body;              /* links, then pins, in the frames of s                         */
} work;

static bool is_stopped(const work *w) { return w->s->stop && *w->s->stop; }

static size_t at(const work *w, int a, int b) { return (size_t)a*(size_t)w->s->linkage.n_link + (size_t)b; }

/* ---- plates ------------------------------------------------------------------------------------------- */

static int by_place(const void *a, const void *b)
{
    const lw_vec2 *p = a, *q = b;
    return p->x < q->x ? -1 : p->x > q->x ? 1 : p->y < q->y ? -1 : p->y > q->y;
}

/* Convex hull, counter-clockwise (Andrew's chains), without corners that lie on a line; out: n + 1 elements. */
static int hull(lw_vec2 *p, int n, double size, lw_vec2 *out)
{
    int m = 0;
    qsort(p, (size_t)n, sizeof *p, by_place);
    for (int pass = 0, base = 0; pass < 2; pass++, base = m - 1)
        for (int i = 0; i < n; i++) {
            lw_vec2 q = p[pass ? n - 1 - i : i];
            if (pass && i == 0)
                continue;
            while (m - base >= 2 && lw_v2_cross(lw_v2_sub(out[m - 1], out[m - 2]), lw_v2_sub(q, out[m - 2])) <= 1e-12*size*size)
                m--;
            if (m > 0 && lw_v2_norm(lw_v2_sub(q, out[m - 1])) < 1e-9*size)
                continue;
            out[m++] = q;
        }
    return m > 1 && lw_v2_norm(lw_v2_sub(out[m - 1], out[0])) < 1e-9*size ? m - 1 : m;
}

bool lw_pin_joins(const lw_pin *p, int link)
{
    for (int i = 0; i < p->n_link; i++)
        if (p->link[i] == link)
            return true;
    return false;
}

static bool on_pin(const lw_pin *p, lw_vec2 at, int a, int b)
{
    return p->at.x == at.x && p->at.y == at.y && (lw_pin_joins(p, a) || lw_pin_joins(p, b));
}

/* Room for what make_plates adds at most: two holes and two pins for each end of a joint, a hole for each tracer. */
static lw_status allocate(const lw_assembly *k, lw_layers *l)
{
    size_t links = (size_t)k->n_link, joints = (size_t)k->n_joint, most = 0, holes = 4*joints + (size_t)k->n_tracer + 1;
    l->layer = calloc(links + 1, sizeof *l->layer);
    l->plate = calloc(links + 1, sizeof *l->plate);
    l->pin = calloc(2*joints + 1, sizeof *l->pin);
    int *room = calloc(links + 1, sizeof *room);
    l->memory[0] = calloc(holes, sizeof(lw_hole));
    l->memory[1] = calloc(2*holes, sizeof(lw_vec2));
    l->memory[2] = calloc(4*holes + 2, sizeof(lw_vec2));
    for (size_t j = 0; room && j < joints; j++)
        for (int end = 0; end < 2; end++)
            room[k->joint[j].link[end]] += 2;
    for (int t = 0; room && t < k->n_tracer; t++)
        room[k->tracer[t].link]++;
    for (size_t i = 0; room && l->plate && l->memory[0] && l->memory[1] && i < links; i++) {
        l->plate[i].hole = (lw_hole *)l->memory[0] + most;
        l->plate[i].corner = (lw_vec2 *)l->memory[1] + 2*most;
        most += (size_t)room[i];
    }
    free(room);
    return l->layer && l->plate && l->pin && l->memory[0] && l->memory[1] && l->memory[2] && most > 0 ? LW_OK : LW_E_MEMORY;
}

void lw_layers_free(lw_layers *l)
{
    for (int i = 0; l->pin && i < l->n_pin; i++)
        free(l->pin[i].link);
    void *const array[] = { l->layer, l->plate, l->pin, l->memory[0], l->memory[1], l->memory[2] };
    for (size_t i = 0; i < sizeof array/sizeof *array; i++)
        free(array[i]);
    *l = (lw_layers){ 0 };
}

static void add_hole(lw_layers *l, int link, lw_vec2 a, lw_vec2 b)
{
    lw_plate *p = &l->plate[link];
    for (int i = 0; i < p->n_hole; i++)
        if (p->hole[i].a.x == a.x && p->hole[i].a.y == a.y && p->hole[i].b.x == b.x && p->hole[i].b.y == b.y)
            return;
    p->hole[p->n_hole++] = (lw_hole){ a, b };
}

/* The pin goes through the link, too.  false: out of memory. */
static bool pass_through(lw_pin *p, int link)
{
    int *more = lw_pin_joins(p, link) ? p->link : realloc(p->link, ((size_t)p->n_link + 1)*sizeof *more);
    if (!more)
        return false;
    p->link = more;
    if (!lw_pin_joins(p, link))
        p->link[p->n_link++] = link;
    return true;
}

static bool add_pin(lw_layers *l, lw_vec2 at, int a, int b, int owner)
{
    int i = 0;
    while (i < l->n_pin && !on_pin(&l->pin[i], at, a, b))
        i++;
    if (i == l->n_pin)
        l->pin[l->n_pin++] = (lw_pin){ .at = at, .owner = owner };
    return pass_through(&l->pin[i], a) && pass_through(&l->pin[i], b);
}

/* Which link of a slider or slot is the guide and which the block, and where the block sits on the line. */
static lw_slide slide_of(const lw_scene *s, int j)
{
    const lw_joint *p = &s->linkage.joint[j];
    if (lw_joint_has_slot(p->kind))
        return (lw_slide){ .guide = p->link[0], .block = p->link[1], .at = p->at, .along = p->along };
    return lw_body_shapes_slide(s, j);
}

/* Extend lo .. hi by the travel of a point of the block along the guide's line, relative to the guide. Between two
 * frames the block may turn back: add an eighth of the second difference. */
static void travel(const lw_scene *s, const lw_slide *q, double *lo, double *hi)
{
    double then = 0, now = 0;
    *lo = *hi = 0;
    for (size_t f = 0; f < s->n_frame + 2*(size_t)s->loops; f++) {
        size_t at = f % s->n_frame;
        lw_vec2 p = lw_scene_at(s, at, q->block, q->at), o = lw_scene_at(s, at, q->guide, q->at);
        lw_vec2 d = lw_v2_sub(lw_scene_at(s, at, q->guide, lw_v2_add(q->at, q->along)), o);
        double t = lw_v2_dot(lw_v2_sub(p, o), d), beyond = f > 1 ? fabs(t - 2*now + then)/8 : 0;
        *lo = fmin(*lo, fmin(t, now - beyond));
        *hi = fmax(*hi, fmax(t, now + beyond));
        then = now;
        now = t;
    }
}

static bool add_slide(const lw_scene *s, int j, lw_layers *l)
{
    lw_slide q = slide_of(s, j);
    bool good = true;
    double lo, hi, apart = lw_joint_has_slot(s->linkage.joint[j].kind) ? 0 : l->radius;
    travel(s, &q, &lo, &hi);
    for (int side = apart > 0 ? -1 : 1; side <= 1; side += 2) {
        lw_vec2 at = lw_v2_add(q.at, lw_v2_scale(q.along, side*apart));
        good = add_pin(l, at, q.guide, q.block, q.block) && good;
        add_hole(l, q.block, at, at);
    }
    add_hole(l, q.guide, lw_v2_add(q.at, lw_v2_scale(q.along, lo - apart)), lw_v2_add(q.at, lw_v2_scale(q.along, hi + apart)));
    return good;
}

/* Would a hole at a point meet one that the plate has? */
static bool in_hole(const lw_layers *l, int link, lw_vec2 at)
{
    const lw_plate *p = &l->plate[link];
    for (int i = 0; i < p->n_hole; i++)
        if (lw_v2_segment_distance(at, p->hole[i].a, p->hole[i].b) <= 2*l->bore)
            return true;
    return false;
}

static bool make_plates(const lw_scene *s, lw_layers *l)
{
    bool good = true;
    const lw_assembly *k = &s->linkage;
    for (int j = 0; j < k->n_joint; j++) {
        const lw_joint *p = &k->joint[j];
        if (!lw_joint_turns(p->kind)) {
            good = add_slide(s, j, l) && good;
            continue;
        }
        good = add_pin(l, p->at, p->link[0], p->link[1], p->link[0] == k->ground ? p->link[0] : p->link[1]) && good;
        add_hole(l, p->link[0], p->at, p->at);
        add_hole(l, p->link[1], p->at, p->at);
    }
    for (int t = 0; t < k->n_tracer; t++)
        if (!in_hole(l, k->tracer[t].link, k->tracer[t].at))
            add_hole(l, k->tracer[t].link, k->tracer[t].at, k->tracer[t].at);
    for (int link = 0; link < k->n_link; link++) {
        lw_plate *q = &l->plate[link];
        lw_vec2 *p = l->memory[2], *out = p + 2*q->n_hole;
        int n = 0;
        for (int i = 0; i < q->n_hole; i++) {
            p[n++] = q->hole[i].a;
            p[n++] = q->hole[i].b;
        }
        n = hull(p, n, lw_v2_norm(lw_v2_sub(p[0], p[n - 1])) + l->radius, out);
        q->n_corner = n;
        memcpy(q->corner, out, (size_t)n*sizeof *out);
    }
    return good;
}

/* A third of the shortest distance between two pins of one link, at most 1/25 of the size. */
static double usual_radius(const lw_assembly *linkage)
{
    double least = INFINITY, size = 0;
    for (int i = 0; i < linkage->n_joint; i++)
        for (int j = 0; j < i; j++) {
            const lw_joint *p = &linkage->joint[i], *q = &linkage->joint[j];
            double d = lw_v2_norm(lw_v2_sub(p->at, q->at));
            bool shared = p->link[0] == q->link[0] || p->link[0] == q->link[1] || p->link[1] == q->link[0]
                       || p->link[1] == q->link[1];
            size = fmax(size, d);
            if (shared && d > 0 && lw_joint_turns(p->kind) && lw_joint_turns(q->kind))
                least = fmin(least, d);
        }
    for (int i = 0; i < linkage->n_tracer; i++)
        size = fmax(size, lw_v2_norm(lw_v2_sub(linkage->tracer[i].at, linkage->joint[0].at)));
    return fmin(least/3, size/25);
}

/* ---- what is in the way ---------------------------------------------------------------------------------- */

/* OPEN: not known yet; ROUGH: they do not meet, but less than half of the clearance in the frames is guaranteed. FAR: the places
 * that they pass are apart; only this is guaranteed. */
typedef enum verdict { OPEN, ROUGH, CLEAR, MEET, FAR } verdict;

static verdict judge(const approach *d, double limit)
{
    double seen = d->seen - limit, sure = d->sure - limit;
    return seen <= 0 ? MEET : sure <= 0 ? OPEN : 2*sure < seen ? ROUGH : CLEAR;
}

/* The links of one scene, then its pins, as bodies. */
static lw_status move_all(const work *w, const lw_scene *s, plate_body *body)
{
    lw_status st = LW_OK;
    int n = s->linkage.n_link;
    for (int i = 0; i < n && st == LW_OK; i++)
        st = move_body(s, i, w->l->plate[i].corner, w->l->plate[i].n_corner, &body[i]);
    for (int p = 0; p < w->l->n_pin && st == LW_OK; p++)
        st = move_body(s, w->l->pin[p].owner, &w->l->pin[p].at, 1, &body[n + p]);
    return st;
}

/* Test all pairs without a final verdict in the frames of s. Returns how many are still without one. */
static int look_at_pairs(work *w, const lw_scene *s, const plate_body *body)
{
    int n = s->linkage.n_link, n_open = 0;
    for (int a = 0; a < n + w->l->n_pin; a++)
        for (int b = 0; b < n && b < a; b++) {
            double limit = w->l->radius + (a < n ? w->l->radius : w->l->bore);
            size_t i = at(w, a, b);
            if (w->pair[i] > ROUGH || is_stopped(w))
                continue;
            double gap = box_gap(&body[a], &body[b]) - limit;
            if (gap > 0) {
                w->pair[i] = FAR;
                w->clearance[i] = gap;
                continue;
            }
            approach d = approach_of(s, &body[a], &body[b]);
            w->pair[i] = (uint8_t)judge(&d, limit);
            w->clearance[i] = d.sure - limit;
            n_open += w->pair[i] <= ROUGH;
        }
    return n_open;
}

/* Decide pairs that need no test: links on one pin meet, a pin never meets its own links, the ground is alone in its
 * layer. */
static void settle_joints(work *w)
{
    const lw_assembly *k = &w->s->linkage;
    int n = k->n_link;
    for (int p = 0; p < w->l->n_pin; p++)
        for (int i = 0; i < w->l->pin[p].n_link; i++) {
            int a = w->l->pin[p].link[i];
            w->pair[at(w, n + p, a)] = CLEAR;
            w->clearance[at(w, n + p, a)] = INFINITY;
            for (int j = 0; j < w->l->pin[p].n_link; j++)
                if (w->l->pin[p].link[j] < a)
                    w->pair[at(w, a, w->l->pin[p].link[j])] = MEET;
        }
    for (int a = 0; a < n + w->l->n_pin; a++) {
        w->pair[at(w, a, k->ground)] = CLEAR;
        w->clearance[at(w, a, k->ground)] = INFINITY;
    }
    for (int b = 0; b < k->ground; b++) {
        w->pair[at(w, k->ground, b)] = CLEAR;
        w->clearance[at(w, k->ground, b)] = INFINITY;
    }
    for (int j = 0; j < k->n_joint; j++) {
        int a = k->joint[j].link[0], b = k->joint[j].link[1];
        w->pair[at(w, a > b ? a : b, a > b ? b : a)] = MEET;
    }
}

/* Test all pairs in the frames of the scene, then in four times as many, and so on while pairs are undecided. Pairs
 * that stay OPEN count as meeting. */
static lw_status find_conflicts(work *w)
{
    const lw_assembly *k = &w->s->linkage;
    lw_scene fine = { 0 };
    lw_status st = LW_OK;
    int bodies = k->n_link + w->l->n_pin, n_open = 1;
    plate_body *body = calloc(2*(size_t)bodies, sizeof *body);
    if (!body)
        return LW_E_MEMORY;
    w->body = body;
    settle_joints(w);
    for (int level = 0; level < LEVELS && n_open > 0 && st == LW_OK && !is_stopped(w); level++) {
        const lw_scene *s = level ? &fine : w->s;
        size_t wanted = w->s->n_frame << 2*level;
        if (level)
            st = lw_scene_make_any(k, w->s->model, NULL, &(lw_scene_options){ .n_frame = wanted, .stop = w->s->stop },
                                   &fine, NULL);
        if (st == LW_OK && s->n_frame >= wanted)
            st = move_all(w, s, body);
        if (st == LW_OK && s->n_frame >= wanted)
            n_open = look_at_pairs(w, s, body);
        for (int i = 0; level && i < bodies; i++)
            free_body(&body[i]);
        if (level)
            lw_scene_free(&fine);
        body = w->body + bodies;
    }
    return st;
}

/* Must a and b, two links or a pin and a link, be kept apart by layers? */
static bool meets(const work *w, int a, int b)
{
    uint8_t v = a == b ? CLEAR : w->pair[a > b ? at(w, a, b) : at(w, b, a)];
    return v == OPEN || v == MEET;
}

static bool touches_pin(const work *w, int link, int pin)
{
    return lw_pin_joins(&w->l->pin[pin], link) || meets(w, w->s->linkage.n_link + pin, link);
}

static bool fill(const work *w, int rows, int columns, bool (*has)(const work *w, int row, int column), table *t)
{
    size_t n = 0, room = 0;
    t->start = malloc(((size_t)rows + 1)*sizeof *t->start);
    for (int r = 0; t->start && r <= rows; r++) {
        t->start[r] = (int)n;
        for (int c = 0; r < rows && c < columns; c++) {
            if (!has(w, r, c))
                continue;
            if (n == room) {
                int *more = realloc(t->item, (room = 2*room + 64)*sizeof *more);
                if (!more)
                    return false;
                t->item = more;
            }
            t->item[n++] = c;
        }
    }
    return t->start != NULL;
}

/* The least clearance between plates in one layer, and between pins and the plates that they pass. The distances of pairs
 * that are FAR are computed only where they may be the least. */
static double least_clearance(const work *w)
{
    const lw_layers *l = w->l;
    int n = w->s->linkage.n_link;
    double least = INFINITY;
    for (int far = 0; far < 2; far++)
        for (int a = 0; a < n + l->n_pin; a++)
            for (int b = 0; b < n && b < a && !is_stopped(w); b++) {
                bool pass = a < n ? l->layer[a] == l->layer[b]
                                  : l->layer[b] > l->pin[a - n].low && l->layer[b] < l->pin[a - n].high;
                size_t i = at(w, a, b);
                if (!pass || (w->pair[i] == FAR) != far || w->clearance[i] >= least)
                    continue;
                double known = w->clearance[i], limit = l->radius + (a < n ? l->radius : l->bore);
                least = fmin(least, far ? fmax(known, approach_of(w->s, &w->body[a], &w->body[b]).sure - limit) : known);
            }
    return least;
}

/* ---- layers ------------------------------------------------------------------------------------------------- */

/* Does every pin that goes through the link, or that the link would hit, clear the links placed so far between its lowest
 * and highest link?  link -1: every pin. */
static bool pins_pass(work *w, int link)
{
    lw_layers *l = w->l;
    const int *hits = w->beside.start + w->s->linkage.n_link;
    int first = link < 0 ? 0 : w->pins.start[link], last = link < 0 ? l->n_pin : w->pins.start[link + 1];
    for (int at = first; at < last; at++) {
        int p = link < 0 ? at : w->pins.item[at], low = INT_MAX, high = -1;
        w->steps += l->pin[p].n_link + hits[p + 1] - hits[p];
        for (int i = 0; i < l->pin[p].n_link; i++) {
            int layer = l->layer[l->pin[p].link[i]];
            low = layer >= 0 && layer < low ? layer : low;
            high = layer > high ? layer : high;
        }
        l->pin[p].low = low;
        l->pin[p].high = high;
        for (int k = hits[p]; k < hits[p + 1]; k++)
            if (l->layer[w->beside.item[k]] > low && l->layer[w->beside.item[k]] < high)
                return false;
    }
    return true;
}

/* ---- an order ------------------------------------------------------------------------------------------------ */

/* Layers exist only if the links have an order, from the ground up, in which no link that a pin hits lies between two links of the
 * pin: it lies above all of them or below all of them. Links are placed from the ground up; each decision is followed to
 * its end, so that most contradictions show at once. */
typedef struct ordering {
    work   *w;
    int8_t *side;              /* (n*n) of a, b: 1: a lies below b, -1: above, 0: not known              */
    int    *pair, n_pair;      /* (n*n/2) a*n + b with a below b, in the order found; the end is a queue */
    int    *link, *before;     /* (n) of each place: the link; pairs known before it was chosen          */
} ordering;

static bool learn(ordering *o, int low, int high)
{
    int n = o->w->s->linkage.n_link;
    if (low == high || o->side[low*n + high] < 0)
        return false;
    if (o->side[low*n + high] == 0) {
        o->side[low*n + high] = 1;
        o->side[high*n + low] = -1;
        o->pair[o->n_pair++] = low*n + high;
    }
    return true;
}

/* Draw the conclusions from all pairs after `first`. False: a contradiction. */
static bool conclude(ordering *o, int first)
{
    const work *w = o->w;
    int n = w->s->linkage.n_link;
    bool fits = true;
    for (; first < o->n_pair && fits; first++) {
        int end[2] = { o->pair[first]/n, o->pair[first] % n };             /* below, above */
        for (int e = 0; e < 2 && fits; e++)                                /* a pin through one that hits the other */
            for (int k = w->pins.start[end[e]]; k < w->pins.start[end[e] + 1] && fits; k++) {
                const lw_pin *p = &w->l->pin[w->pins.item[k]];
                bool hits = lw_pin_joins(p, end[e]) && !lw_pin_joins(p, end[1 - e]) && meets(w, n + w->pins.item[k], end[1 - e]);
                for (int i = 0; hits && i < p->n_link && fits; i++)
                    fits = e == 0 ? learn(o, p->link[i], end[1]) : learn(o, end[0], p->link[i]);
            }
        const int8_t *low = o->side + end[0]*n, *high = o->side + end[1]*n;
        for (int i = 0; i < n && fits; i++)
            fits = (low[i] >= 0 || learn(o, i, end[1])) && (high[i] <= 0 || learn(o, end[0], i));
        o->w->steps += n;
    }
    return fits;
}

static void forget(ordering *o, int n_pair)
{
    int n = o->w->s->linkage.n_link;
    while (o->n_pair > n_pair) {
        int pair = o->pair[--o->n_pair];
        o->side[pair] = o->side[pair % n*n + pair/n] = 0;
    }
}

static bool can_be_next(const ordering *o, const bool *placed, int link)
{
    int n = o->w->s->linkage.n_link;
    for (int i = 0; i < n; i++)
        if (!placed[i] && o->side[i*n + link] > 0)
            return false;
    return !placed[link];
}

/* Place all links. LW_NOTHING: there is no order; LW_STOPPED: the steps are used up, or the user's stop. */
static lw_status place_all(ordering *o, bool *placed, long most)
{
    int n = o->w->s->linkage.n_link, place = 0, ground = o->w->s->linkage.ground, link = ground;
    while (place < n) {
        while (link < n && !can_be_next(o, placed, link))
            link++;
        if (link == n) {                                                   /* none fits: back to the place before */
            if (place <= 1)
                return LW_NOTHING;
            link = o->link[--place];
            placed[link] = false;
            forget(o, o->before[place]);
            link++;
            continue;
        }
        if (o->w->steps > most || is_stopped(o->w))
            return LW_STOPPED;
        bool fits = true;
        o->before[place] = o->n_pair;
        for (int i = 0; i < n && fits; i++)
            fits = placed[i] || i == link || learn(o, link, i);
        if (fits && conclude(o, o->before[place])) {
            o->link[place++] = link;
            placed[link] = true;
            link = 0;
        } else if (place == 0) {
            return LW_NOTHING;
        } else {
            forget(o, o->before[place]);
            link++;
        }
    }
    return LW_OK;
}

/* Layers by an order: each link in the lowest one above all below it that it meets. */
static lw_status layers_by_order(work *w, long most)
{
    size_t n = (size_t)w->s->linkage.n_link;
    ordering o = { .w = w, .side = calloc(n*n, 1), .pair = malloc(n*n*sizeof *o.pair), .link = malloc(2*n*sizeof *o.link) };
    bool *placed = calloc(n, sizeof *placed);
    lw_status st = o.side && o.pair && o.link && placed ? LW_OK : LW_E_MEMORY;
    o.before = o.link + n;
    w->steps = 0;
    if (st == LW_OK)
        st = place_all(&o, placed, most);
    for (size_t i = 0; st == LW_OK && i < n; i++)
        w->l->layer[i] = i == (size_t)w->s->linkage.ground ? 0 : -1;
    w->n_layer = 1;
    for (size_t i = 1; st == LW_OK && i < n; i++) {
        int link = o.link[i], layer = 1;
        for (int k = w->beside.start[link]; k < w->beside.start[link + 1]; k++)
            layer = w->l->layer[w->beside.item[k]] >= layer ? w->l->layer[w->beside.item[k]] + 1 : layer;
        w->l->layer[link] = layer;
        w->n_layer = layer >= w->n_layer ? layer + 1 : w->n_layer;
    }
    free(o.side), free(o.pair), free(o.link), free(placed);
    return st == LW_OK && !pins_pass(w, -1) ? LW_STOPPED : st;
}

/* ---- the fewest layers ----------------------------------------------------------------------------------------- */

/* Layers (bits) in which a link can be placed. */
static uint64_t open_layers(work *w, int link)
{
    uint64_t open = 0;
    for (int k = w->beside.start[link]; k < w->beside.start[link + 1]; k++)
        if (w->l->layer[w->beside.item[k]] > 0)
            open |= (uint64_t)1 << w->l->layer[w->beside.item[k]];
    open = ~open;
    for (int at = 1; at < w->n_layer; at++) {
        w->l->layer[link] = at;
        if ((open >> at & 1) && !pins_pass(w, link))
            open &= ~((uint64_t)1 << at);
    }
    open &= w->n_layer < 64 ? ((uint64_t)1 << w->n_layer) - 2 : ~(uint64_t)1;
    w->l->layer[link] = -1;
    return open;
}

/* The link was placed or taken back: what is open to others on or beside its pins, and to those that it meets? */
static void renew_around(work *w, int link)
{
    const int *hits = w->beside.start + w->s->linkage.n_link;
    for (int k = w->beside.start[link]; k < w->beside.start[link + 1]; k++)
        w->stale[w->beside.item[k]] = true;
    for (int at = w->pins.start[link]; at < w->pins.start[link + 1]; at++) {
        const lw_pin *p = &w->l->pin[w->pins.item[at]];
        for (int i = 0; i < p->n_link; i++)
            w->stale[p->link[i]] = true;
        for (int k = hits[w->pins.item[at]]; k < hits[w->pins.item[at] + 1]; k++)
            w->stale[w->beside.item[k]] = true;
    }
}

/* Choose the link with the fewest possible layers (Brelaz 1979). False: the steps are used up. */
static bool choose(work *w, int place)
{
    int fewest = LAYERS_MAX + 1, n_link = w->s->linkage.n_link;
    for (int i = 0; i < n_link && w->steps <= w->most_steps && !is_stopped(w); i++) {
        if (w->l->layer[i] >= 0)
            continue;
        if (w->stale[i])
            w->open[i] = open_layers(w, i);
        w->stale[i] = false;
        int n = __builtin_popcountll(w->open[i]);
        if (n < fewest) {
            fewest = n;
            w->chosen[place] = i;
            w->choice[place] = w->open[i];
        }
    }
    return w->steps <= w->most_steps && !is_stopped(w);
}

/* Place all links in n_layer layers: try the possible layers of each in turn. False, too: the steps are used up. */
static bool place_in_layers(work *w)
{
    int place = 0, n = w->s->linkage.n_link - 1;
    memset(w->stale, true, (size_t)n + 1);
    for (;;) {
        if (place < n && !choose(w, place))
            return false;
        if (place == n && pins_pass(w, -1))
            return true;
        while (place == n || w->choice[place] == 0) {                      /* back to one that has layers left */
            if (place < n) {
                w->l->layer[w->chosen[place]] = -1;
                w->stale[w->chosen[place]] = true;
                renew_around(w, w->chosen[place]);
            }
            if (place-- == 0)
                return false;
        }
        w->l->layer[w->chosen[place]] = __builtin_ctzll(w->choice[place]);
        w->choice[place] &= w->choice[place] - 1;
        renew_around(w, w->chosen[place]);
        place++;
    }
}

/* So many layers are needed at least: one for the ground, and one for each of some links that all meet each other. */
static int least_layers(const work *w)
{
    int n = w->s->linkage.n_link, most = 0, *clique = malloc((size_t)n*sizeof *clique);
    for (int first = 0; clique && first < n; first++) {
        int k = 0;
        if (first != w->s->linkage.ground)
            clique[k++] = first;
        for (int at = w->beside.start[first]; k > 0 && at < w->beside.start[first + 1]; at++) {
            int i = 0, link = w->beside.item[at];
            while (i < k && link != w->s->linkage.ground && meets(w, clique[i], link))
                i++;
            if (i == k)
                clique[k++] = link;
        }
        most = k > most ? k : most;
    }
    free(clique);
    return most + 1;
}

/* Search for from .. to - 1 layers, each number in so many steps and at most a share of those left. Returns the first number that does,
 * else `to`. */
static int search(work *w, int from, int to, long steps, int share)
{
    const lw_assembly *k = &w->s->linkage;
    to = to <= k->n_link + 1 ? to : k->n_link + 1;
    for (w->n_layer = from; w->n_layer < to && w->n_layer <= LAYERS_MAX && !is_stopped(w); w->n_layer++) {
        for (int i = 0; i < k->n_link; i++)
            w->l->layer[i] = i == k->ground ? 0 : -1;
        w->steps = 0;
        w->most_steps = w->left/(share > 0 ? share : to - w->n_layer);
        w->most_steps = w->most_steps < steps ? w->most_steps : steps;
        bool done = place_in_layers(w);
        w->left -= w->steps;
        if (done)
            return w->n_layer;
        if (w->steps <= w->most_steps && !is_stopped(w))
            w->none = w->n_layer;
    }
    return to;
}

/* A few layers in the first attempt; else an order, which decides whether there are layers at all and gives some; then
 * fewer ones in the steps that are left. */
static lw_status find_layers(work *w, lw_error *e)
{
    const lw_assembly *k = &w->s->linkage;
    size_t size = (size_t)k->n_link*sizeof *w->l->layer;
    int *found = malloc(size), least = least_layers(w), n = 0;
    long quick = 200L*k->n_link*k->n_link;                             /* a few attempts without many turns back */
    lw_status st = found ? LW_OK : LW_E_MEMORY;
    w->left = STEPS_MAX;
    w->none = least - 1;
    if (st == LW_OK && (n = search(w, least, least + 3, quick, 8)) == least + 3) {
        st = layers_by_order(w, STEPS_MAX);
        n = st == LW_OK ? w->n_layer : k->n_link + 1;
    } else if (n > k->n_link)
        st = LW_STOPPED;
    for (int pass = 0; pass < 2 && (st == LW_OK || st == LW_STOPPED) && n > w->none + 1; pass++) {
        if (st == LW_OK)
            memcpy(found, w->l->layer, size);
        int fewer = search(w, w->none + 1, n, pass ? LONG_MAX : quick, pass ? 0 : 8);
        if (st == LW_OK && fewer == n)
            memcpy(w->l->layer, found, size);
        else if (fewer < n)
            st = LW_OK;
        n = fewer;
    }
    free(found);
    w->l->n_layer = n;
    w->l->fewest = w->none >= n - 1;
    if (is_stopped(w))
        return lw_error_set(e, LW_STOPPED, "stopped before the layers were found");
    if (st == LW_OK)
        pins_pass(w, -1);                                              /* the layers of the pins */
    else if (st == LW_STOPPED && w->none < k->n_link)
        return lw_error_set(e, st, "no layers in which the links pass each other were found in %ld steps", STEPS_MAX);
    else if (st != LW_E_MEMORY)
        return lw_error_set(e, LW_NOTHING, "there are no layers in which all links pass each other and the pins over the "
                            "whole motion; a smaller range of the input, or pins held from both sides, would help");
    return st;
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static lw_status check(const lw_scene *s, lw_error *e)
{
    const lw_assembly *k = &s->linkage;
    for (int j = 0; j < k->n_joint; j++)
        if (!lw_joint_has_position(k->joint[j].kind))
            return lw_error_set(e, LW_E_KIND, "joint '%s': gears and welds are not cut from plates", k->joint[j].name);
    if (s->n_frame < 2)
        return lw_error_set(e, LW_E_KIND, "plates need the motion. %s", s->note);
    return LW_OK;
}

lw_status lw_layers_find(const lw_scene *s, const lw_plate_size *size, lw_layers *l, lw_error *e)
{
    work w = { .s = s, .l = l };
    *l = (lw_layers){ 0 };
    lw_status st = is_stopped(&w) ? lw_error_set(e, LW_STOPPED, "stopped before the layers were found") : check(s, e);
    if (st != LW_OK)
        return st;
    l->radius = size && size->radius > 0 ? size->radius : usual_radius(&s->linkage);
    l->bore = size && size->bore > 0 ? size->bore : 0.4*l->radius;
    l->thickness = size && size->thickness > 0 ? size->thickness : l->radius;
    l->pin_radius = l->bore - (size && size->clearance >= 0 ? size->clearance/2 : 0.05*l->bore);
    if (!(l->bore < l->radius && l->pin_radius > 0))
        return lw_error_set(e, LW_E_ARG, "plates %.4g mm wide, holes of %.4g mm and pins of %.4g mm do not go together",
                            2e3*l->radius, 2e3*l->bore, 2e3*l->pin_radius);
    st = allocate(&s->linkage, l);
    if (st == LW_OK && !make_plates(s, l))
        st = LW_E_MEMORY;
    size_t pairs = (size_t)(s->linkage.n_link + l->n_pin)*(size_t)s->linkage.n_link;
    w.pair = calloc(pairs, sizeof *w.pair);
    w.clearance = calloc(pairs, sizeof *w.clearance);
    w.chosen = calloc((size_t)s->linkage.n_link, sizeof *w.chosen);
    w.choice = calloc(2*(size_t)s->linkage.n_link, sizeof *w.choice);
    w.stale = calloc((size_t)s->linkage.n_link, sizeof *w.stale);
    w.open = w.choice ? w.choice + s->linkage.n_link : NULL;
    if (st == LW_OK)
        st = w.pair && w.clearance && w.chosen && w.choice && w.stale ? find_conflicts(&w) : LW_E_MEMORY;
    int n = s->linkage.n_link;
    if (st == LW_OK && !(fill(&w, n + l->n_pin, n, meets, &w.beside) && fill(&w, n, l->n_pin, touches_pin, &w.pins)))
        st = LW_E_MEMORY;
    if (st == LW_OK)
        st = find_layers(&w, e);
    if (st == LW_OK)
        l->room = least_clearance(&w);
    if (st == LW_OK && is_stopped(&w))
        st = lw_error_set(e, LW_STOPPED, "stopped before the clearance of the layers was known");
    else if (st == LW_E_MEMORY)
        lw_error_set(e, st, "out of memory for the layers of a linkage");
    for (int i = 0; w.body && i < 2*(n + l->n_pin); i++)
        free_body(&w.body[i]);
    free(w.body), free(w.pair), free(w.clearance), free(w.chosen), free(w.choice), free(w.stale);
    free(w.beside.start), free(w.beside.item);
    free(w.pins.start), free(w.pins.item);
    return st;
}
