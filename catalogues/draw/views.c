/* catalogues/draw/views.c - see views.h */
#include "catalogues/draw/views.h"

#include "base/real.h"
#include "catalogues/draw/body_shapes.h"
#include "grammar/model/model.h"

#define ENDLESS 8.0            /* a motion this many times larger than the posture shown is cut off */

static void box_empty(lw_box *b)
{
    *b = (lw_box){ INFINITY, INFINITY, -INFINITY, -INFINITY };
}

bool lw_box_is_empty(const lw_box *b)
{
    return !(b->x0 <= b->x1);
}

/* Points that are not finite are ignored. */
static void box_add(lw_box *b, lw_vec2 p)
{
    if (!isfinite(p.x) || !isfinite(p.y))
        return;
    b->x0 = fmin(b->x0, p.x);
    b->y0 = fmin(b->y0, p.y);
    b->x1 = fmax(b->x1, p.x);
    b->y1 = fmax(b->y1, p.y);
}

static void box_join(lw_box *b, const lw_box *other)
{
    if (lw_box_is_empty(other))
        return;
    box_add(b, lw_v2(other->x0, other->y0));
    box_add(b, lw_v2(other->x1, other->y1));
}

double lw_box_size(const lw_box *b)
{
    return lw_box_is_empty(b) ? 0 : hypot(b->x1 - b->x0, b->y1 - b->y0);
}

static void add_points(lw_box *b, const lw_vec2 *p, size_t n)
{
    for (size_t i = 0; i < n; i++)
        box_add(b, p[i]);
}

static lw_box curve_box(const lw_scene *s, bool shown_branch)
{
    lw_box b;
    box_empty(&b);
    for (int i = 0; i < s->n_curve; i++)
        if (s->curve[i].shown_branch == shown_branch)
            add_points(&b, s->curve[i].p, s->curve[i].n);
    return b;
}

lw_box lw_scene_path_box(const lw_scene *s)
{
    lw_box b, curve = curve_box(s, true);
    box_empty(&b);
    add_points(&b, s->station, s->n_station);
    if (lw_box_size(&b) == 0 || lw_box_size(&curve) < LW_SPECK*lw_box_size(&b))
        box_join(&b, &curve);
    return b;
}

/* Add both wheels of a gear pair. */
static void add_gear(lw_box *b, const lw_scene *s, size_t frame, int joint)
{
    lw_wheel w[2];
    if (!lw_body_shapes_gear(s, joint, w))
        return;
    for (int side = 0; side < 2; side++) {
        double r = w[side].radius + 0.3*w[side].pitch;
        lw_vec2 c = lw_scene_at(s, frame, w[side].link, w[side].centre);
        box_add(b, lw_v2_sub(c, lw_v2(r, r)));
        box_add(b, lw_v2_add(c, lw_v2(r, r)));
        for (int end = 0; end < 2 && w[side].rack; end++) {
            double t = end ? w[side].hi + 1.5*w[side].pitch : w[side].lo - 1.5*w[side].pitch;
            box_add(b, lw_scene_at(s, frame, w[side].link, lw_v2_add(w[side].centre, lw_v2_scale(w[side].along, t))));
        }
    }
}

/* Outlines, but not infinite lines, the ends of ropes and springs, axes and nodes of elastic links. */
static void add_parts(lw_box *b, const lw_scene *s, size_t frame)
{
    for (int i = 0; s->model && s->model->elastic && i < s->linkage.n_link; i++)
        for (int k = 0; k < s->model->elastic[i].n_axis; k++)
            box_add(b, lw_scene_at(s, frame, i, lw_v2(s->model->elastic[i].axis[k].x, s->model->elastic[i].axis[k].y)));
    for (int i = 0; s->model && s->model->elastic && i < s->linkage.n_link; i++)
        for (int k = 0; k < s->model->elastic[i].n_node; k++)
            box_add(b, lw_scene_at(s, frame, i, lw_v2(s->model->elastic[i].node[k].x, s->model->elastic[i].node[k].y)));
    for (int i = 0; s->model && i < s->model->n_shape; i++) {
        const lw_contour *c = &s->model->shape[i];
        lw_vec2 reach = lw_v2(c->radius, c->radius);
        for (int k = 0; k < c->n && c->kind != LW_CONTOUR_LINE; k++) {
            lw_vec2 at = lw_scene_at(s, frame, c->link, c->at[k]);
            box_add(b, lw_v2_sub(at, reach));
            box_add(b, lw_v2_add(at, reach));
        }
    }
    for (int end = 0; end < 2 && s->model; end++) {
        for (int i = 0; i < s->model->n_rope; i++)
            box_add(b, lw_scene_at(s, frame, s->model->rope[i].link[end], s->model->rope[i].at[end]));
        for (int i = 0; i < s->model->n_spring; i++)
            box_add(b, lw_scene_at(s, frame, s->model->spring[i].link[end], lw_v3_xy(s->model->spring[i].at[end])));
    }
}

/* Add the places of infinite lines, as of a floor, that are beside the middle, unless they are further away than the rest is large. */
static void add_lines(lw_box *b, const lw_scene *s, size_t frame)
{
    double size = lw_box_size(b);
    lw_vec2 middle = { b->x0 + (b->x1 - b->x0)/2, b->y0 + (b->y1 - b->y0)/2 };
    for (int i = 0; s->model && i < s->model->n_shape; i++) {
        const lw_contour *c = &s->model->shape[i];
        if (c->kind != LW_CONTOUR_LINE)
            continue;
        lw_vec2 at = lw_scene_at(s, frame, c->link, c->at[0]), along = lw_v2_sub(lw_scene_at(s, frame, c->link, c->at[1]), at);
        lw_vec2 foot = lw_v2_add(at, lw_v2_scale(along, lw_v2_dot(along, lw_v2_sub(middle, at))/lw_v2_dot(along, along)));
        if (lw_v2_norm(lw_v2_sub(foot, middle)) < size)
            box_add(b, foot);
    }
}

/* Add pins, blocks and tracers; if `guides`, also the travel of guides, and gears. */
static void add_links(lw_box *b, const lw_scene *s, size_t frame, bool guides)
{
    const lw_assembly *k = &s->linkage;
    add_parts(b, s, frame);
    for (int i = 0; i < k->n_joint; i++) {
        const lw_joint *j = &k->joint[i];
        if (lw_joint_freedoms(j->kind) == 3)
            continue;
        if (!lw_joint_slides(j->kind)) {
            box_add(b, lw_scene_at(s, frame, j->link[1], j->at));
            if (guides && lw_joint_has_ratio(j->kind))
                add_gear(b, s, frame, i);
            continue;
        }
        lw_slide w = lw_body_shapes_slide(s, i);
        lw_vec2 lo = lw_v2_add(w.at, lw_v2_scale(w.along, w.lo));
        lw_vec2 hi = lw_v2_add(w.at, lw_v2_scale(w.along, w.hi));
        box_add(b, lw_scene_at(s, frame, w.block, w.at));
        if (guides) {
            box_add(b, lw_scene_at(s, frame, w.guide, lo));
            box_add(b, lw_scene_at(s, frame, w.guide, hi));
        }
    }
    for (int i = 0; i < k->n_tracer; i++)
        box_add(b, lw_scene_at(s, frame, k->tracer[i].link, k->tracer[i].at));
}

/* Cut the box `wide` to a few times the size of `core`, so that a motion that runs to infinity does not shrink
 * everything else to a dot. */
static lw_box keep_core_large(lw_box wide, const lw_box *core)
{
    double size = lw_box_size(core), around = 1.2*size;
    if (size == 0 || lw_box_size(&wide) < ENDLESS*size)
        return wide;
    return (lw_box){ fmax(wide.x0, core->x0 - around), fmax(wide.y0, core->y0 - around),
                     fmin(wide.x1, core->x1 + around), fmin(wide.y1, core->y1 + around) };
}

lw_box lw_scene_box(const lw_scene *s, bool whole_motion)
{
    lw_box core, curve = curve_box(s, true), other = curve_box(s, false);
    box_empty(&core);
    add_points(&core, s->station, s->n_station);
    add_links(&core, s, s->first_frame, false);
    add_lines(&core, s, s->first_frame);
    lw_box all = core;
    add_links(&all, s, s->first_frame, true);
    for (size_t f = 0; whole_motion && f < s->n_frame; f++)
        add_links(&all, s, f, true);
    box_join(&all, &curve);
    all = keep_core_large(all, &core);
    lw_box with = all;                     /* other assembly modes only if the rest does not get small */
    box_join(&with, &other);
    return lw_box_size(&with) < 1.6*lw_box_size(&all) ? with : all;
}

lw_view lw_view_fit(lw_box c, double x, double y, double w, double h, double margin)
{
    double room_x = fmax(w - 2*margin, 0.2*w), room_y = fmax(h - 2*margin, 0.2*h);
    double scale = fmin(room_x/(c.x1 - c.x0), room_y/(c.y1 - c.y0));
    if (!isfinite(scale))                                  /* a single point: any scale shows it */
        scale = 0.25*fmin(room_x, room_y)/fmax(fmax(fabs(c.x0), fabs(c.y0)), 1e-300);
    if (!isfinite(scale))
        scale = 1;
    return (lw_view){
        .middle = lw_v2(c.x0 + (c.x1 - c.x0)/2, c.y0 + (c.y1 - c.y0)/2),
        .scale = scale, .centre = lw_v2(x + w/2, y + h/2), .x = x, .y = y, .w = w, .h = h,
    };
}
