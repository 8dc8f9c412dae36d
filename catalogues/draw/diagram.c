/* catalogues/draw/diagram.c - a scene as a diagram: views, curves and target, with the linkage and its margins. */
#include "catalogues/draw/diagram_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/number.h"
#include "base/real.h"
#include "catalogues/draw/body_shapes.h"
#include "catalogues/draw/symbols.h"
#include "catalogues/draw/views.h"

lw_diagram_options lw_diagram_options_default(void)
{
    return (lw_diagram_options){ .width = 1000, .height = 750, .zoom = 1, .title = true,
                                 .labels = true, .length_labels = true, .length_values = true,
                                 .dimensions = true };
}

lw_page_motion lw_diagram_motion(const lw_scene *s, const lw_view *v, size_t frame, int link)
{
    const lw_place *p = &s->place[frame*(size_t)s->linkage.n_link + (size_t)link];
    return (lw_page_motion){
        .from = lw_view_pixel(v, s->origin[link]), .to = lw_view_pixel(v, p->at),
        .turn = lw_v2(p->turn.x, -p->turn.y),
    };
}

static void curve_ink(lw_sketch *k, int panel, lw_shape *s, const lw_curve *c)
{
    s->item = c->tracer;
    s->panel = panel;
    s->stroke = c->outline ? LW_INK_FAINT : c->compared ? LW_INK_RED : LW_INK_BLUE;
    s->width = (c->shown_branch && !c->compared ? 2.6 : 1.6)*k->u;
    s->dashed = !c->shown_branch;
}

/* Draw a curve. Parts far outside the page are cut off, and what would run through the legend and the scale bar. */
static void draw_curve(lw_sketch *k, int panel, const lw_curve *c)
{
    enum { PIECE = 2048 };
    /* A few pages around the picture, so that no number is too large for an output format. */
    const lw_view *v = &k->d->view[panel];
    const lw_box near = { -2*k->d->width, -2*k->d->height, 3*k->d->width, v->y + v->h - lw_sketch_foot_height(k, v->w) };
    lw_vec2 piece[PIECE];
    size_t n = 0, n_side = c->n < 2 ? 0 : c->n - (c->closed ? 0 : 1);
    lw_role role = c->shown_branch && !c->compared ? LW_ROLE_CURVE : LW_ROLE_OTHER_CURVE;
    for (size_t i = 0; i < n_side; i++) {
        lw_vec2 a = lw_sketch_pixel(k, panel, c->p[i]), a0 = a;
        lw_vec2 b = lw_sketch_pixel(k, panel, c->p[(i + 1) % c->n]);
        bool seen = lw_sketch_clip(&near, &a, &b);
        if (n && (!seen || a.x != a0.x || a.y != a0.y || n == PIECE)) {
            curve_ink(k, panel, lw_drawing_path(k->d, role, piece, n, false), c);
            n = 0;
        }
        if (!seen)
            continue;
        if (n == 0)
            piece[n++] = a;
        piece[n++ % PIECE] = b;
        lw_label_map_line(&k->map, a, b, 0.7);
    }
    if (n)
        curve_ink(k, panel, lw_drawing_path(k->d, role, piece, n, false), c);
}

static void draw_curves(lw_sketch *k, int panel)
{
    for (int layer = 0; layer < 3; layer++)              /* of another linkage, of other branches, of this motion */
        for (int i = 0; i < k->s->n_curve; i++)
            if (layer == (k->s->curve[i].compared ? 0 : 1 + k->s->curve[i].shown_branch))
                draw_curve(k, panel, &k->s->curve[i]);
}

static bool is_near_page(const lw_drawing *d, lw_vec2 p)
{
    return fabs(p.x) < 4*d->width && fabs(p.y) < 4*d->height;
}

/* Number of target points of one tracer. */
static size_t stations_each(const lw_scene *s)
{
    return s->n_each > 0 ? s->n_each : s->n_station;
}

/* Draw a marker for each target point, smaller when there are many, or a polygon when there are too many to tell apart.
 */
static void draw_stations(lw_sketch *k, int panel)
{
    const lw_scene *s = k->s;
    if (s->n_station > 1500) {
        size_t first = k->d->n_shape;
        for (size_t i = 0; i < s->n_station; i += stations_each(s)) {
            lw_curve c = { .tracer = -1, .closed = s->station_closed, .n = stations_each(s), .p = s->station + i };
            draw_curve(k, panel, &c);
        }
        for (size_t i = first; i < k->d->n_shape; i++) {
            k->d->shape[i].role = LW_ROLE_TARGET;
            k->d->shape[i].stroke = LW_INK_RED;
        }
        return;
    }
    double u = k->u*(s->n_station > 400 ? 0.45 : s->n_station > 80 ? 0.7 : 1);
    for (size_t i = 0; i < s->n_station; i++) {
        lw_vec2 at = lw_sketch_pixel(k, panel, s->station[i]);
        if (!is_near_page(k->d, at))
            continue;
        lw_symbol_station(k->d, LW_ROLE_STATION, (lw_bearer){ (int)i, -1, panel }, at, u);
        lw_label_map_disc(&k->map, at, 5*u, 1.5);
    }
}

/* Write numbers beside the target points: beside each when there are few, else beside some, evenly chosen. */
static void label_stations(lw_sketch *k, int panel)
{
    const lw_scene *s = k->s;
    size_t step = 1 + s->n_station/37;
    const lw_view *v = &k->d->view[panel];
    for (size_t i = 0; i < s->n_station; i += step) {
        char text[24];
        snprintf(text, sizeof text, "%zu", i % stations_each(s) + 1);
        lw_vec2 p = lw_sketch_pixel(k, panel, s->station[i]), at;
        if (!lw_label_map_place(&k->map, text, 11.5*k->u, p, p, 6*k->u, lw_sketch_view_box(v), &at))
            continue;
        lw_shape *t = lw_drawing_text(k->d, LW_ROLE_STATION_LABEL, text, at, 11.5*k->u, 0);
        t->item = (int)i;
        t->panel = panel;
        t->fill = LW_INK_RED;
    }
}

/* Draw the second panel, which shows the path alone, enlarged, with the tracers. Mark its box in the first panel. */
static void draw_path_panel(lw_sketch *k, lw_box path)
{
    lw_drawing *d = k->d;
    const lw_view *v = &d->view[1];
    lw_vec2 frame[4] = { { v->x, v->y }, { v->x + v->w, v->y }, { v->x + v->w, v->y + v->h },
                         { v->x, v->y + v->h } };
    lw_shape *s = lw_drawing_path(d, LW_ROLE_INSET, frame, 4, true);
    s->stroke = LW_INK_FAINT;
    s->fill = LW_INK_PAPER;
    draw_curves(k, 1);
    for (int i = 0; i < k->s->linkage.n_tracer; i++) {
        const lw_tracer *t = &k->s->linkage.tracer[i];
        lw_vec2 at = lw_sketch_pixel(k, 1, t->at);
        lw_symbol_tracer(d, (lw_bearer){ i, t->link, 1 }, at, k->u);
    }
    draw_stations(k, 1);
    lw_vec2 a = lw_sketch_pixel(k, 0, lw_v2(path.x0, path.y1));
    lw_vec2 b = lw_sketch_pixel(k, 0, lw_v2(path.x1, path.y0));
    double m = 5*k->u;
    lw_vec2 mark[4] = { { a.x - m, a.y - m }, { b.x + m, a.y - m }, { b.x + m, b.y + m },
                        { a.x - m, b.y + m } };
    s = lw_drawing_path(d, LW_ROLE_INSET, mark, 4, true);
    s->stroke = LW_INK_FAINT;
    s->panel = 0;
    for (int i = 0; i < 4; i++)
        lw_label_map_line(&k->map, mark[i], mark[(i + 1) % 4], 1);
    char text[32], factor[32];
    lw_number_text(factor, v->scale/d->view[0].scale, 2);
    snprintf(text, sizeof text, "path, %.12s times larger", factor);
    lw_drawing_text(d, LW_ROLE_INSET, text, lw_v2(v->x + 8*k->u, v->y + 16*k->u), 11.5*k->u, 0)->fill
        = LW_INK_FAINT;
    lw_label_map_take(&k->map, (lw_box){ v->x, v->y, v->x + v->w, v->y + 22*k->u });
}

/* Divide the page below `top`: one panel, or two side by side (one above the other on a tall page). */
static lw_status make_views(lw_sketch *k, double top, lw_box *path, lw_error *e)
{
    lw_drawing *d = k->d;
    lw_box all = lw_scene_box(k->s, k->o->whole_motion);
    *path = lw_scene_path_box(k->s);
    if (lw_box_is_empty(&all))
        return lw_error_set(e, LW_E_NUMERIC, "nothing to draw: no coordinate is a finite number");
    double w = d->width, h = d->height - top, margin = 44*k->u;
    double size = lw_box_size(path);
    bool two = size > 0 && lw_box_size(&all) > LW_SPECK*size, tall = h > w;
    double w0 = two && !tall ? 0.56*w : w, h0 = two && tall ? 0.56*h : h;
    d->n_view = two ? 2 : 1;
    d->view[0] = lw_view_fit(all, 0, top, w0, h0 - lw_sketch_foot_height(k, w0), margin);
    d->view[0].h = h0;                                    /* the lower panel holds scale bar and legend */
    if (two) {
        double x = tall ? 8*k->u : w0, y = tall ? top + h0 : top;
        double w1 = w - x - 8*k->u, h1 = d->height - y - 8*k->u;
        d->view[1] = lw_view_fit(*path, x, y + 18*k->u, w1, h1 - lw_sketch_foot_height(k, w1) - 18*k->u, margin*0.8);
        d->view[1].y = y;
        d->view[1].h = h1;
    }
    return LW_OK;
}

static void describe(lw_sketch *k)
{
    const lw_scene *s = k->s;
    lw_text_clean(k->d->title, sizeof k->d->title, s->title);
    snprintf(k->d->about, sizeof k->d->about,
             "Planar linkage of %d links and %d joints, %d curve%s, %zu target point%s",
             s->linkage.n_link, s->linkage.n_joint, s->n_curve, lw_plural(s->n_curve),
             s->n_station, lw_plural(s->n_station));
}

static void draw_all(lw_sketch *k, lw_box path)
{
    double u = k->u;
    draw_curves(k, 0);
    k->u *= k->signs;
    lw_sketch_linkage(k);
    k->u = u;
    if (k->d->n_view == 1)
        draw_stations(k, 0);
    else
        draw_path_panel(k, path);
    lw_sketch_feet(k);
    if (k->o->labels) {
        lw_sketch_labels(k);
        label_stations(k, k->d->n_view - 1);
    }
}

/* Factor on the signs of a model with more parts than a linkage: a link stays several times as long as a pin is wide. */
static double crowded(const lw_scene *s, double width, double u)
{
    const lw_assembly *a = &s->linkage;
    double size = 0, sum = 0;
    int n = 0;
    if (a->n_link <= LW_LINK_MAX && a->n_joint <= LW_JOINT_MAX)
        return 1;
    for (int j = 0; j < a->n_joint; j++)
        for (int end = 0; end < 2; end++) {
            double far = lw_v2_norm(lw_v2_sub(a->joint[j].at, s->origin[a->joint[j].link[end]]));
            size = fmax(size, lw_v2_norm(lw_v2_sub(a->joint[j].at, a->joint[0].at)));
            if (a->joint[j].link[end] == a->ground || !(far > 0))
                continue;
            sum += far;
            n++;
        }
    return n && size > 0 ? fmin(1, fmax(0.15, sum/n/size*0.5*width/(40*u))) : 1;
}

lw_status lw_diagram_draw(const lw_scene *s, const lw_diagram_options *o, lw_drawing *d, lw_error *e)
{
    lw_diagram_options standard = lw_diagram_options_default();
    o = o ? o : &standard;
    *d = (lw_drawing){ .width = o->width, .height = o->height };
    if (!(o->width >= 64 && o->width <= 8192 && o->height >= 64 && o->height <= 8192) || !(o->zoom >= 0.1 && o->zoom <= 10))
        return lw_error_set(e, LW_E_ARG, "a picture of %g by %g px, signs %g times as large: sizes "
                            "are 64 to 8192, zoom 0.1 to 10", o->width, o->height, o->zoom);
    lw_sketch k = { .s = s, .o = o, .d = d };
    double size = fmin(o->width/1000, o->height/750);
    k.u = o->zoom*(size < 1 ? sqrt(size) : size);   /* letters stay legible in small pictures */
    lw_diagram_options plain = *o;
    double fewer = crowded(s, o->width, k.u);
    k.signs = fewer;
    plain.labels = o->labels && fewer > 0.6;
    k.o = &plain;
    lw_box path;
    lw_status status = lw_label_map_make(&k.map, o->width, o->height, e);
    int nodes = 2*(s->linkage.n_joint + s->linkage.n_tracer) + (s->model ? s->model->n_spring + s->model->n_rope : 0);
    for (int i = 0; s->model && s->model->elastic && i < s->linkage.n_link; i++)
        nodes = s->model->elastic[i].n_axis > nodes ? s->model->elastic[i].n_axis : nodes;
    k.room = nodes > LW_NODE_MAX ? nodes : LW_NODE_MAX;
    k.node = malloc((size_t)k.room*sizeof *k.node);
    k.corner = malloc((size_t)k.room*sizeof *k.corner);
    if (status == LW_OK && (!k.node || !k.corner))
        status = lw_error_set(e, LW_E_MEMORY, "not enough memory for the picture");
    if (status == LW_OK) {
        double top = lw_sketch_header(&k);
        status = make_views(&k, top, &path, e);
    }
    if (status == LW_OK) {
        describe(&k);
        draw_all(&k, path);
    }
    lw_label_map_free(&k.map);
    free(k.node), free(k.corner);
    if (status != LW_OK) {
        lw_drawing_free(d);
        return status;
    }
    return lw_drawing_end(d, e);
}
