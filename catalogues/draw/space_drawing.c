/* catalogues/draw/space_drawing.c - a frame of a spatial scene in parallel projection, drawn from the farthest piece to the
 * nearest.  Long lines are cut into pieces, so that two bars that pass each other are drawn in the right order. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/vec3.h"
#include "catalogues/draw/labels.h"
#include "catalogues/draw/space_scene.h"
#include "catalogues/draw/symbols.h"

#define PIECES 12                /* of a line across the whole picture                                 */
#define FRONT 0.02               /* of the radius: balls and tracers are so far in front of the ends of bars */
#define BEHIND (1.0/PIECES)      /* the same: paths and guides behind bars on the same line, which is half of the longest piece */
#define MARGIN 36                /* [px]                                                               */

/* A piece of a shape (or of a path, shape NULL) on the page. */
typedef struct piece { const lw_space_shape *shape; double depth; bool tube; int n; lw_vec2 p[LW_SPACE_POINTS]; } piece;

typedef struct page {
    const lw_space_scene *s;
    size_t   frame;
    lw_vec3  axis[3];
    lw_vec2  middle;                                    /* of all postures along the first two axes, from that of the scene */
    double   scale, width, height;
    piece   *piece;
    size_t   n, room;
} page;

lw_space_view lw_space_view_default(void) { return (lw_space_view){ .azimuth = 35*LW_PI/180, .elevation = 25*LW_PI/180 }; }

void lw_space_view_axes(const lw_space_scene *s, lw_space_view view, lw_vec3 axis[3])
{
    lw_vec3 u = s->up, a = fabs(u.z) > 0.9 ? lw_v3(1, 0, 0) : fabs(u.y) > 0.9 ? lw_v3(0, 0, 1) : lw_v3(0, 1, 0);
    a = lw_v3_sub(a, lw_v3_scale(u, lw_v3_dot(a, u)));
    a = lw_v3_scale(a, 1/lw_v3_norm(a));
    lw_vec3 b = lw_v3_cross(u, a);
    double c = cos(view.elevation), across = cos(view.azimuth), along = sin(view.azimuth);
    axis[2] = lw_v3_add(lw_v3_scale(lw_v3_add(lw_v3_scale(a, across), lw_v3_scale(b, along)), c),
                        lw_v3_scale(u, sin(view.elevation)));
    axis[0] = lw_v3_sub(lw_v3_scale(b, across), lw_v3_scale(a, along));
    axis[1] = lw_v3_cross(axis[2], axis[0]);
}

static lw_vec2 on_page(const page *g, lw_vec3 p, double *depth)
{
    lw_vec3 d = lw_v3_sub(p, g->s->middle);
    *depth = lw_v3_dot(d, g->axis[2]);
    lw_vec2 at = lw_v2_sub(lw_v2(lw_v3_dot(d, g->axis[0]), lw_v3_dot(d, g->axis[1])), g->middle);
    return lw_v2(0.5*g->width + g->scale*at.x, 0.5*g->height + 12 - g->scale*at.y);
}

static piece *new_piece(page *g, const lw_space_shape *shape, int n)
{
    if (g->n == g->room)
        return NULL;                                    /* count_pieces made room for all of them */
    g->piece[g->n] = (piece){ .shape = shape, .n = n };
    return &g->piece[g->n++];
}

static int pieces_of(const page *g, lw_vec3 a, lw_vec3 b)
{
    int n = (int)ceil(PIECES*lw_v3_norm(lw_v3_sub(a, b))/(2*g->s->radius));
    return n < 1 ? 1 : n > PIECES ? PIECES : n;
}

/* The way between the ends of a shape, turned with the link at one of them; of an elastic element the slope there. */
static lw_vec3 slope(const page *g, const lw_space_shape *shape, int link)
{
    lw_mat3 turn = lw_quaternion_matrix(g->s->pose[g->frame*(size_t)g->s->n_link + (size_t)link].turn);
    return lw_m3_apply(&turn, lw_v3_sub(shape->p[1], shape->p[0]));
}

/* Both ends of a bar are short pieces, behind the balls there from whichever side they are seen.  Elastic elements are cubics between their nodes. */
static void put_line(page *g, const lw_space_shape *shape, lw_vec3 a, lw_vec3 b)
{
    lw_vec3 way = lw_v3_sub(b, a), from = { 0, 0, 0 }, to = { 0, 0, 0 };         /* slopes less the chord */
    if (shape->kind == LW_SPACE_BAR && shape->to >= 0) {
        from = lw_v3_sub(slope(g, shape, shape->link), way);
        to = lw_v3_sub(slope(g, shape, shape->to), way);
    }
    bool bar = shape->kind == LW_SPACE_BAR;
    double length = lw_v3_norm(lw_v3_sub(b, a)), end = bar ? fmin(2*FRONT*g->s->radius/length, 1.0/3) : 0;
    int n = pieces_of(g, a, b), first = bar ? -1 : 0;
    for (int i = first; i < n - first; i++) {
        piece *q = new_piece(g, shape, 2);
        double depth[2];
        if (!q)
            return;
        for (int k = 0; k < 2; k++) {
            double u = i + k < 0 ? 0 : i + k > n ? 1 : end + (1 - 2*end)*(i + k)/n;
            lw_vec3 p = lw_v3_add(a, lw_v3_scale(way, u)), bent = lw_v3_sub(lw_v3_scale(from, u*(1 - u)*(1 - u)), lw_v3_scale(to, u*u*(1 - u)));
            q->p[k] = on_page(g, lw_v3_add(p, bent), &depth[k]);
        }
        q->depth = 0.5*(depth[0] + depth[1]) - (shape->kind == LW_SPACE_GUIDE ? BEHIND*g->s->radius : 0);
    }
}

/* A line from u to v of the way from a to b, its ends so far across it on the page [px]. */
static piece *put_part(page *g, const lw_space_shape *shape, lw_vec3 a, lw_vec3 b, const double u[2], const double across[2])
{
    lw_vec3 way = lw_v3_sub(b, a);
    double depth[2];
    lw_vec2 along = lw_v2_sub(on_page(g, b, &depth[1]), on_page(g, a, &depth[0]));
    lw_vec2 side = lw_v2_scale(lw_v2_perp(along), 1/fmax(lw_v2_norm(along), 1e-9));
    piece *q = new_piece(g, shape, 2);
    if (!q)
        return NULL;
    for (int k = 0; k < 2; k++)
        q->p[k] = lw_v2_add(on_page(g, lw_v3_add(a, lw_v3_scale(way, u[k])), &depth[k]), lw_v2_scale(side, across[k]));
    q->depth = 0.5*(depth[0] + depth[1]);
    return q;
}

/* A zigzag as catalogues/draw/diagram.c draws it; of a cylinder the rod and, over it, the tube. */
static void put_tie(page *g, const lw_space_shape *shape, lw_vec3 a, lw_vec3 b)
{
    enum { TEETH = 9 };
    static const double straight[2] = { 0, 0 };
    if (shape->tube > 0) {
        double tube = fmin(shape->tube/fmax(lw_v3_norm(lw_v3_sub(b, a)), 1e-300), 1);
        put_part(g, shape, a, b, (double[]){ tube, 1 }, straight);
        piece *q = put_part(g, shape, a, b, (double[]){ 0, tube }, straight);
        if (q)
            q->tube = true;
        return;
    }
    for (int i = -1; i <= TEETH; i++) {
        double u[2], across[2];
        for (int k = 0; k < 2; k++) {
            int at = i + k;
            u[k] = at < 0 ? 0 : at > TEETH ? 1 : 0.2 + 0.6*at/TEETH;
            across[k] = at <= 0 || at >= TEETH ? 0 : at % 2 ? 7 : -7;
        }
        put_part(g, shape, a, b, u, across);
    }
}

static void put_shape(page *g, const lw_space_shape *shape)
{
    lw_vec3 p[LW_SPACE_POINTS];
    for (int i = 0; i < shape->n; i++)
        p[i] = lw_space_scene_point(g->s, g->frame, shape, i);
    if (shape->n == 2) {
        (shape->kind == LW_SPACE_TIE ? put_tie : put_line)(g, shape, p[0], p[1]);
        return;
    }
    piece *q = new_piece(g, shape, shape->n);
    for (int i = 0; q && i < shape->n; i++) {
        double depth;
        q->p[i] = on_page(g, p[i], &depth);
        q->depth += depth/shape->n;
    }
    if (q && shape->kind != LW_SPACE_PLATE)
        q->depth += FRONT*g->s->radius;                 /* in front of the bars that end there */
}

static void put_paths(page *g)
{
    const lw_space_scene *s = g->s;
    for (int t = 0; t < s->n_tracer; t++)
        for (size_t i = 0; i + 1 < s->n_path + s->loops; i++) {
            lw_vec3 a = s->path[i*(size_t)s->n_tracer + (size_t)t];
            lw_vec3 b = s->path[(i + 1) % s->n_path*(size_t)s->n_tracer + (size_t)t];
            piece *q = new_piece(g, NULL, 2);
            double depth[2];
            if (!q)
                return;
            q->p[0] = on_page(g, a, &depth[0]);
            q->p[1] = on_page(g, b, &depth[1]);
            q->depth = 0.5*(depth[0] + depth[1]) - BEHIND*g->s->radius;
        }
}

static int compare(const void *a, const void *b)
{
    const piece *p = a, *q = b;
    if (p->depth != q->depth)
        return p->depth < q->depth ? -1 : 1;
    return (p->shape > q->shape) - (p->shape < q->shape);
}

/* ---- ink ------------------------------------------------------------------------------------------------- */

/* A light seam beside a bar, so that it is seen to pass over what is behind it.  Its round ends stay within the piece. */
static void seam(lw_drawing *d, const piece *q, double width)
{
    lw_vec2 way = lw_v2_sub(q->p[1], q->p[0]);
    double length = hypot(way.x, way.y), cut = length > width ? 0.5*width/length : 0.5;
    piece inner = *q;
    inner.p[0] = lw_v2_add(q->p[0], lw_v2_scale(way, cut));
    inner.p[1] = lw_v2_sub(q->p[1], lw_v2_scale(way, cut));
    if (cut < 0.5) {
        lw_shape *s = lw_drawing_line(d, LW_ROLE_LINK, inner.p[0], inner.p[1]);
        s->stroke = LW_INK_PAPER;
        s->width = width;
    }
}

static void line(lw_drawing *d, lw_role role, const piece *q, lw_ink ink, double width)
{
    lw_shape *s = lw_drawing_line(d, role, q->p[0], q->p[1]);
    s->stroke = ink;
    s->width = width;
}

static void ink(lw_drawing *d, const piece *q)
{
    lw_shape *s;
    if (!q->shape) {
        line(d, LW_ROLE_CURVE, q, LW_INK_BLUE, 2.2);
        return;
    }
    lw_ink dark = q->shape->grounded ? LW_INK_GROUND : LW_INK_LINK;
    switch (q->shape->kind) {
    case LW_SPACE_BAR:
        seam(d, q, 8);
        line(d, LW_ROLE_LINK, q, LW_INK_LINK, 5);
        break;
    case LW_SPACE_GUIDE: line(d, LW_ROLE_GUIDE, q, LW_INK_FAINT, 1.6); break;
    case LW_SPACE_PIN:
        line(d, LW_ROLE_JOINT, q, dark, 12);
        line(d, LW_ROLE_JOINT, q, q->shape->grounded ? LW_INK_FAINT : LW_INK_PAPER, 8);
        break;
    case LW_SPACE_TIE:
        if (q->tube) {
            line(d, LW_ROLE_LINK, q, LW_INK_LINK, 11);
            line(d, LW_ROLE_LINK, q, LW_INK_PAPER, 7);
        } else
            line(d, LW_ROLE_LINK, q, q->shape->tube > 0 ? LW_INK_LINK : LW_INK_ORANGE, q->shape->tube > 0 ? 3 : 1.6);
        break;
    case LW_SPACE_PLATE:
        s = lw_drawing_path(d, LW_ROLE_LINK, q->p, (size_t)q->n, true);
        s->stroke = s->fill = dark;
        s->width = 3;
        s->alpha = 0.25;
        break;
    case LW_SPACE_BALL:
    case LW_SPACE_TRACER:
        s = lw_drawing_circle(d, q->shape->kind == LW_SPACE_BALL ? LW_ROLE_JOINT : LW_ROLE_TRACER, q->p[0],
                              q->shape->kind == LW_SPACE_BALL ? 6 : 4.5);
        s->stroke = q->shape->kind == LW_SPACE_BALL ? dark : LW_INK_BLUE;
        s->fill = q->shape->grounded ? LW_INK_FAINT : LW_INK_PAPER;
        s->width = 2.4;
        break;
    }
    if (d->n_shape)
        d->shape[d->n_shape - 1].item = q->shape->item;
}

/* The directions of the axes in the lower left corner. */
static void triad(const page *g, lw_drawing *d)
{
    static const char *const name[] = { "x", "y", "z" };
    static const lw_ink colour[] = { LW_INK_RED, LW_INK_GREEN, LW_INK_BLUE };
    lw_vec2 foot = lw_v2(44, g->height - 44);
    for (int i = 0; i < 3; i++) {
        lw_vec3 unit = lw_v3(i == 0, i == 1, i == 2);
        lw_vec2 way = lw_v2(lw_v3_dot(unit, g->axis[0]), -lw_v3_dot(unit, g->axis[1]));
        lw_shape *s = lw_drawing_line(d, LW_ROLE_AXIS, foot, lw_v2_add(foot, lw_v2_scale(way, 24)));
        s->stroke = colour[i];
        s->width = 2;
        s = lw_drawing_text(d, LW_ROLE_AXIS, name[i], lw_v2_add(lw_v2_add(foot, lw_v2_scale(way, 33)), lw_v2(0, 4)), 12, 0.5);
        s->fill = colour[i];
    }
}

/* A parallel projection keeps lengths that are parallel to the picture. */
static void scale_bar(const page *g, lw_drawing *d)
{
    const lw_units *units = &g->s->model->units;
    const char *remark = g->width < 600 ? "" : " parallel to the picture";
    if (g->width >= 300)
        lw_symbol_scale_bar(d, (lw_bearer){ -1, -1, -1 }, lw_v2(94, g->height - 14), g->scale*units->metre, 0.2*g->width,
                            units->length[0] ? units->length : "m",
                            remark, 1);
}

/* ---- names ----------------------------------------------------------------------------------------------- */

/* The longest line on the page between two points of a link, beside which its name stands; else the place of the link. */
static void place_of_name(const page *g, int link, lw_vec2 *a, lw_vec2 *b)
{
    double depth, longest = -1;
    *a = *b = on_page(g, lw_space_scene_at(g->s, g->frame, link, g->s->origin[link]), &depth);
    for (int i = 0; i < g->s->n_shape; i++) {
        const lw_space_shape *shape = &g->s->shape[i];
        bool body = shape->link == link && (shape->kind == LW_SPACE_BAR || (shape->kind == LW_SPACE_PLATE && shape->n > 2));
        for (int k = 0; body && k < shape->n - (shape->n == 2); k++) {
            lw_vec2 p = on_page(g, lw_space_scene_point(g->s, g->frame, shape, k), &depth);
            lw_vec2 q = on_page(g, lw_space_scene_point(g->s, g->frame, shape, (k + 1) % shape->n), &depth);
            double length = lw_v2_norm(lw_v2_sub(q, p));
            if (length > longest)
                *a = p, *b = q, longest = length;
        }
    }
}

static void put_name(lw_drawing *d, lw_label_map *map, lw_role role, const char *text, lw_vec2 a, lw_vec2 b, double gap)
{
    lw_vec2 at;
    char clean[LW_NAME_SIZE + 4];
    lw_text_clean(clean, sizeof clean, text);
    if (!clean[0] || !lw_label_map_place(map, clean, 13, a, b, gap, (lw_box){ 8, 44, d->width - 8, d->height - 8 }, &at))
        return;
    lw_shape *s = lw_drawing_text(d, role, clean, at, 13, 0);
    s->fill = role == LW_ROLE_TRACER ? LW_INK_BLUE : LW_INK_LINK;
    s->italic = role == LW_ROLE_TRACER;
}

/* Names of tracers, then of links, where they cover little and no other name. */
static lw_status put_names(const page *g, lw_drawing *d, lw_error *e)
{
    const lw_spatial *m = g->s->model;
    lw_label_map map;
    lw_vec2 a, b;
    double depth;
    lw_status st = lw_label_map_make(&map, g->width, g->height, e);
    if (st != LW_OK)
        return st;
    for (size_t i = 0; i < g->n; i++) {
        const piece *q = &g->piece[i];
        for (int k = 0; k < q->n; k++)
            lw_label_map_line(&map, q->p[k], q->p[(k + 1) % q->n], q->shape ? 1 : 0.5);
        if (q->n == 1)
            lw_label_map_disc(&map, q->p[0], 9, 2);
    }
    lw_label_map_take(&map, (lw_box){ 0, g->height - 84, 90, g->height });
    lw_label_map_take(&map, (lw_box){ 90, g->height - 32, 0.6*g->width, g->height });
    for (int i = 0; i < m->n_tracer; i++) {
        a = on_page(g, lw_space_scene_at(g->s, g->frame, m->tracer[i].link, m->tracer[i].at), &depth);
        put_name(d, &map, LW_ROLE_TRACER, m->tracer[i].name, a, a, 9);
    }
    for (int i = 0; i < m->n_link; i++) {
        place_of_name(g, i, &a, &b);
        if (i != m->ground)
            put_name(d, &map, LW_ROLE_LINK, m->body[i].name, a, b, 6);
    }
    lw_label_map_free(&map);
    return LW_OK;
}

static size_t count_pieces(const lw_space_scene *s)
{
    return (size_t)s->n_shape*(PIECES + 2) + (size_t)s->n_tracer*s->n_path + 1;
}

/* The greatest scale at which every posture is on the page, in its middle. */
static void choose_scale(page *g)
{
    lw_vec2 least = { INFINITY, INFINITY }, most = { -INFINITY, -INFINITY };
    for (size_t f = 0; f < g->s->n_frame; f++)
        for (int i = 0; i < g->s->n_shape; i++)
            for (int k = 0; k < g->s->shape[i].n; k++) {
                lw_vec3 p = lw_v3_sub(lw_space_scene_point(g->s, f, &g->s->shape[i], k), g->s->middle);
                lw_vec2 at = lw_v2(lw_v3_dot(p, g->axis[0]), lw_v3_dot(p, g->axis[1]));
                least = lw_v2(fmin(least.x, at.x), fmin(least.y, at.y));
                most = lw_v2(fmax(most.x, at.x), fmax(most.y, at.y));
            }
    g->scale = 1;
    if (g->s->n_shape == 0)
        return;
    g->middle = lw_v2_scale(lw_v2_add(least, most), 0.5);
    g->scale = fmin((g->width - 2*MARGIN)/fmax(most.x - least.x, 2e-12), (g->height - 2*MARGIN - 24)/fmax(most.y - least.y, 2e-12));
}

lw_status lw_space_draw(const lw_space_scene *s, size_t frame, lw_space_view view, int width, int height,
                        lw_drawing *d, lw_error *e)
{
    page g = { .s = s, .frame = frame, .width = width, .height = height, .room = count_pieces(s) };
    memset(d, 0, sizeof *d);
    d->width = width;
    d->height = height;
    g.piece = calloc(g.room, sizeof *g.piece);
    if (!g.piece)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_space_view_axes(s, view, g.axis);
    choose_scale(&g);
    for (int i = 0; i < s->n_shape; i++)
        put_shape(&g, &s->shape[i]);
    put_paths(&g);
    qsort(g.piece, g.n, sizeof *g.piece, compare);
    lw_vec2 corner[] = { { 0, 0 }, { width, 0 }, { width, height }, { 0, height } };
    lw_drawing_path(d, LW_ROLE_PAPER, corner, 4, true)->fill = LW_INK_PAPER;
    for (size_t i = 0; i < g.n; i++)
        ink(d, &g.piece[i]);
    triad(&g, d);
    scale_bar(&g, d);
    lw_status st = view.names ? put_names(&g, d, e) : LW_OK;
    snprintf(d->title, sizeof d->title, "%s", s->title);
    lw_shape *title = lw_drawing_text(d, LW_ROLE_TITLE, s->title, lw_v2(16, 30), 18, 0);
    title->bold = true;
    free(g.piece);
    return st == LW_OK ? lw_drawing_end(d, e) : st;
}
