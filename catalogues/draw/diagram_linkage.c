/* catalogues/draw/diagram_linkage.c - the links and joints of a diagram, and their labels */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "catalogues/draw/body_shapes.h"
#include "base/bytes.h"
#include "catalogues/draw/diagram_internal.h"
#include "catalogues/draw/symbols.h"

#define LABEL_SIZE 14.5
#define LENGTH_SIZE 12.5

static const lw_linkage *linkage(const lw_sketch *k)
{
    return &k->s->linkage;
}

/* The link an input drives, seen from the other one. */
static int driven_link(const lw_linkage *k, const lw_joint *j)
{
    return j->link[1] == k->ground ? j->link[0] : j->link[1];
}

static lw_ink link_ink(const lw_linkage *k, int link)
{
    for (int i = 0; i < k->n_input; i++)
        if (driven_link(k, &k->joint[k->input[i].joint]) == link)
            return LW_INK_PURPLE;
    for (int i = 0; i < k->n_tracer; i++)
        if (k->tracer[i].link == link)
            return LW_INK_GREEN;
    return LW_INK_LINK;
}

static lw_bearer bearer(const lw_linkage *k, int item, int link)
{
    return (lw_bearer){ item, link == k->ground ? -1 : link, 0 };
}

/* A guide, drawn below everything else: hatched on the ground, a bar on a moving link. */
static void draw_cylinder(lw_sketch *k, const lw_cylinder *c, int joint);

static void draw_guide(lw_sketch *k, int joint)
{
    const lw_linkage *l = linkage(k);
    lw_cylinder c;
    if (lw_body_shapes_cylinder(k->s, joint, &c)) {
        draw_cylinder(k, &c, joint);
        return;
    }
    lw_slide w = lw_body_shapes_slide(k->s, joint);
    double end = 30*k->u/k->d->view[0].scale, u = k->u;
    lw_vec2 a = lw_sketch_pixel(k, 0, lw_v2_add(w.at, lw_v2_scale(w.along, w.lo - end)));
    lw_vec2 b = lw_sketch_pixel(k, 0, lw_v2_add(w.at, lw_v2_scale(w.along, w.hi + end)));
    lw_bearer carrier = bearer(l, joint, w.guide);
    const lw_box page = { -2*k->d->width, -2*k->d->height, 3*k->d->width, 3*k->d->height };
    if (!lw_sketch_clip(&page, &a, &b))
        return;
    if (l->joint[joint].kind == LW_JOINT_SLOT)
        lw_symbol_slot(k->d, carrier, a, b, link_ink(l, w.guide), u);
    else if (w.guide == l->ground) {
        if (b.x < a.x || (b.x == a.x && b.y < a.y)) {      /* hatching below, or left of, the line */
            lw_vec2 t = a;
            a = b;
            b = t;
        }
        lw_vec2 down = lw_v2_sub(b, a);
        double length = fmax(lw_v2_norm(down), 1e-9);
        down = lw_v2_scale(lw_v2_perp(down), 10*u/length);             /* under the block's edge */
        lw_symbol_hatched_line(k->d, carrier, lw_v2_add(a, down), lw_v2_add(b, down), u);
        for (double depth = 1; depth < 1.8; depth += 0.35)                          /* hatching */
            lw_label_map_line(&k->map, lw_v2_add(a, lw_v2_scale(down, depth)),
                              lw_v2_add(b, lw_v2_scale(down, depth)), 1);
    } else {
        lw_shape *s = lw_drawing_line(k->d, LW_ROLE_GUIDE, a, b);
        s->item = joint;
        s->link = w.guide;
        s->panel = 0;
        s->stroke = link_ink(l, w.guide);
        s->width = 5*u;
    }
    lw_label_map_line(&k->map, a, b, 1);
}

static void draw_block(lw_sketch *k, int joint)
{
    lw_cylinder c;
    if (lw_body_shapes_cylinder(k->s, joint, &c))
        return;
    lw_slide w = lw_body_shapes_slide(k->s, joint);
    lw_vec2 at = lw_sketch_pixel(k, 0, w.at);
    lw_symbol_block(k->d, bearer(linkage(k), joint, w.block), at, lw_v2(w.along.x, -w.along.y),
                    link_ink(linkage(k), w.block), k->u);
    lw_label_map_disc(&k->map, at, 15*k->u, 2);
}

/* Rectangle and piston, below everything else. */
static void draw_cylinder(lw_sketch *k, const lw_cylinder *c, int joint)
{
    const lw_linkage *l = linkage(k);
    double scale = k->d->view[0].scale;
    lw_vec2 pin[2] = { lw_sketch_pixel(k, 0, c->pin[0]), lw_sketch_pixel(k, 0, c->pin[1]) };
    lw_vec2 along = lw_v2(c->along.x, -c->along.y);
    lw_symbol_tube(k->d, bearer(l, joint, c->tube), pin[0], along, scale*c->tube_length, link_ink(l, c->tube), k->u);
    lw_symbol_rod(k->d, bearer(l, c->rod, c->rod), pin[1], along, scale*c->rod_length, link_ink(l, c->rod), k->u);
    lw_label_map_line(&k->map, pin[0], pin[1], 2);
}

/* Does an earlier gear joint show this wheel already? */
static bool is_drawn(const lw_sketch *k, int joint, const lw_wheel *w)
{
    for (int i = 0; i < joint; i++) {
        lw_wheel other[2];
        if (linkage(k)->joint[i].kind != LW_JOINT_GEAR || !lw_body_shapes_gear(k->s, i, other))
            continue;
        for (int side = 0; side < 2; side++)
            if (other[side].link == w->link && other[side].rack == w->rack
                && lw_v2_norm(lw_v2_sub(other[side].centre, w->centre)) < 1e-6*w->pitch
                && fabs(other[side].radius - w->radius) < 1e-6*w->pitch)
                return true;
    }
    return false;
}

/* `away`: where a rack's teeth point, towards its pinion. */
static void draw_wheel(lw_sketch *k, int joint, const lw_wheel *w, lw_vec2 away)
{
    const lw_linkage *l = linkage(k);
    double scale = k->d->view[0].scale, u = k->u;
    lw_vec2 at = lw_sketch_pixel(k, 0, w->centre), along = lw_v2(w->along.x, -w->along.y);
    lw_bearer carrier = bearer(l, joint, w->link);
    lw_ink ink = link_ink(l, w->link);
    if (w->rack) {
        double body = 14*u, end = 1.5*w->pitch;
        if (lw_v2_dot(lw_v2_perp(along), lw_v2(away.x, -away.y)) > 0)
            body = -body;
        lw_symbol_rack(k->d, carrier, at, along, scale*(w->lo - end), scale*(w->hi + end), scale*w->pitch, w->gap,
                       body, ink, u);
        return;
    }
    double size = 4*hypot(k->d->width, k->d->height);
    if (scale*w->radius < size)                             /* else it is as good as a line far off */
        lw_symbol_wheel(k->d, carrier, at, scale*w->radius, w->teeth, atan2(along.y, along.x), w->gap, w->ring, ink, u);
}

static void draw_gear(lw_sketch *k, int joint)
{
    lw_wheel w[2];
    if (!lw_body_shapes_gear(k->s, joint, w))
        return;
    for (int side = 0; side < 2; side++)
        if (!is_drawn(k, joint, &w[side]))
            draw_wheel(k, joint, &w[side], lw_v2_sub(w[1 - side].centre, w[side].centre));
}

/* Direction on the page from a point of a link to the middle of its other nodes; (0, 0) when there are none. */
static lw_vec2 inwards(const lw_sketch *k, int link, lw_vec2 from)
{
    lw_shape_node node[LW_NODE_MAX];
    lw_vec2 sum = { 0, 0 };
    int n = lw_body_shapes_nodes(k->s, link, node);
    for (int i = 0; i < n; i++)
        sum = lw_v2_add(sum, lw_v2_sub(node[i].at, from));
    double length = lw_v2_norm(sum);
    return length > 0 ? lw_v2(sum.x/length, -sum.y/length) : lw_v2(0, 0);
}

static void draw_weld(lw_sketch *k, int joint)
{
    const lw_joint *j = &linkage(k)->joint[joint];
    lw_vec2 at = lw_sketch_pixel(k, 0, j->at);
    lw_symbol_weld(k->d, bearer(linkage(k), joint, j->link[1]), at, inwards(k, j->link[0], j->at),
                   inwards(k, j->link[1], j->at), link_ink(linkage(k), j->link[1]), k->u);
    lw_label_map_disc(&k->map, at, 8*k->u, 3);
}

static void draw_link(lw_sketch *k, int link)
{
    lw_shape_node node[LW_NODE_MAX];
    lw_vec2 p[LW_NODE_MAX];
    int n = lw_body_shapes_nodes(k->s, link, node);
    for (int i = 0; i < n; i++) {
        p[i] = lw_sketch_pixel(k, 0, node[i].at);
        for (int j = 0; j < i; j++)
            lw_label_map_line(&k->map, p[j], p[i], 1);
    }
    lw_symbol_link(k->d, bearer(linkage(k), link, link), p, n, link_ink(linkage(k), link), k->u);
}

static bool on_ground(const lw_linkage *k, const lw_joint *j)
{
    return j->link[0] == k->ground || j->link[1] == k->ground;
}

/* The line between the ground pins, to which the frame's length belongs. */
static void draw_frame_line(lw_sketch *k)
{
    const lw_linkage *l = linkage(k);
    int last = -1;
    for (int i = 0; i < l->n_joint; i++) {
        if (l->joint[i].kind != LW_JOINT_REVOLUTE || !on_ground(l, &l->joint[i]))
            continue;
        if (last >= 0) {
            lw_vec2 a = lw_sketch_pixel(k, 0, l->joint[last].at);
            lw_vec2 b = lw_sketch_pixel(k, 0, l->joint[i].at);
            lw_shape *s = lw_drawing_line(k->d, LW_ROLE_FRAME, a, b);
            s->stroke = LW_INK_FAINT;
            s->dashed = true;
            s->panel = 0;
            s->width = k->u;
            lw_label_map_line(&k->map, a, b, 0.5);
        }
        last = i;
    }
}

static void draw_pivots(lw_sketch *k)
{
    const lw_linkage *l = linkage(k);
    for (int i = 0; i < l->n_joint; i++) {
        if (l->joint[i].kind != LW_JOINT_REVOLUTE || !on_ground(l, &l->joint[i]))
            continue;
        lw_vec2 at = lw_sketch_pixel(k, 0, l->joint[i].at);
        lw_symbol_pivot(k->d, (lw_bearer){ i, -1, 0 }, at, k->u);
        lw_label_map_disc(&k->map, lw_v2(at.x, at.y + 14*k->u), 16*k->u, 2);
    }
}

static void draw_pins(lw_sketch *k)
{
    const lw_linkage *l = linkage(k);
    for (int i = 0; i < l->n_joint; i++) {
        const lw_joint *j = &l->joint[i];
        if (j->kind != LW_JOINT_REVOLUTE && j->kind != LW_JOINT_SLOT)
            continue;
        lw_vec2 at = lw_sketch_pixel(k, 0, j->at);
        lw_symbol_pin(k->d, bearer(l, i, on_ground(l, j) ? l->ground : j->link[1]), at, k->u);
        lw_label_map_disc(&k->map, at, 6*k->u, 3);
    }
    for (int i = 0; i < l->n_tracer; i++) {
        lw_vec2 at = lw_sketch_pixel(k, 0, l->tracer[i].at);
        lw_symbol_tracer(k->d, bearer(l, i, l->tracer[i].link), at, k->u);
        lw_label_map_disc(&k->map, at, 6*k->u, 3);
    }
}

/* Direction from the input pin to the middle of the driven link's other nodes [rad, page upright]. */
static double driven_direction(const lw_sketch *k, int link, lw_vec2 pin)
{
    lw_shape_node node[LW_NODE_MAX];
    lw_vec2 sum = { 0, 0 };
    int n = lw_body_shapes_nodes(k->s, link, node);
    for (int i = 0; i < n; i++)
        sum = lw_v2_add(sum, lw_v2_sub(node[i].at, pin));
    return atan2(sum.y, sum.x);
}

static void draw_input(lw_sketch *k, int input)
{
    const lw_linkage *l = linkage(k);
    int joint = l->input[input].joint;
    bool back = l->input[input].ratio < 0;               /* tied, against the first */
    const lw_joint *j = &l->joint[joint];
    int driven = driven_link(l, j), base = j->link[0] == driven ? j->link[1] : j->link[0];
    lw_bearer carrier = bearer(l, input, base);
    if (j->kind == LW_JOINT_REVOLUTE) {
        lw_vec2 at = lw_sketch_pixel(k, 0, j->at);
        double from = driven_direction(k, driven, j->at) + 0.4;
        lw_symbol_turning(k->d, carrier, at, from, back, k->u);
        for (int i = 0; i < 12; i++)
            lw_label_map_disc(&k->map, lw_v2_add(at, lw_v2_polar(27*k->u, -(from + 0.16*i))),
                              4*k->u, 2);
        return;
    }
    lw_slide w = lw_body_shapes_slide(k->s, joint);
    double sign = (w.block == driven) != back ? 1 : -1;
    carrier.link = w.guide == l->ground ? -1 : w.guide;
    lw_vec2 along = lw_v2(sign*w.along.x, -sign*w.along.y);
    lw_vec2 at = lw_v2_add(lw_sketch_pixel(k, 0, w.at), lw_v2_scale(lw_v2_perp(along), -21*k->u));
    lw_vec2 a = lw_v2_sub(at, lw_v2_scale(along, 20*k->u)), b = lw_v2_add(at, lw_v2_scale(along, 24*k->u));
    lw_symbol_arrow(k->d, carrier, a, b, k->u);
    lw_label_map_line(&k->map, a, b, 2);
}

void lw_sketch_linkage(lw_sketch *k)
{
    const lw_linkage *l = linkage(k);
    draw_frame_line(k);
    for (int i = 0; i < l->n_joint; i++)
        if (l->joint[i].kind == LW_JOINT_SLIDER || l->joint[i].kind == LW_JOINT_SLOT)
            draw_guide(k, i);
        else if (l->joint[i].kind == LW_JOINT_GEAR)
            draw_gear(k, i);
    draw_pivots(k);
    for (int i = 0; i < l->n_link; i++)
        if (i != l->ground)
            draw_link(k, i);
    for (int i = 0; i < l->n_joint; i++)
        if (l->joint[i].kind == LW_JOINT_SLIDER)
            draw_block(k, i);
        else if (l->joint[i].kind == LW_JOINT_FIXED)
            draw_weld(k, i);
    for (int i = 0; i < l->n_input; i++)
        draw_input(k, i);
    draw_pins(k);
}

/* A label of the line a b, or of the point a = b, that moves with a link. */
static void label(lw_sketch *k, lw_role role, int item, int link, const char *text, double size,
                  lw_vec2 a, lw_vec2 b, double gap, lw_ink ink)
{
    lw_vec2 at;
    if (!lw_label_map_place(&k->map, text, size, a, b, gap, lw_view_box(&k->d->view[0]), &at))
        return;
    lw_shape *s = lw_drawing_text(k->d, role, text, at, size, 0);
    s->item = item;
    s->link = link == linkage(k)->ground ? -1 : link;
    s->panel = 0;
    s->upright = true;
    s->hold = lw_v2_scale(lw_v2_add(a, b), 0.5);
    s->fill = ink;
    s->italic = role != LW_ROLE_LENGTH_LABEL;
}

static void label_points(lw_sketch *k)
{
    const lw_linkage *l = linkage(k);
    double u = k->u;
    for (int i = 0; i < l->n_tracer; i++) {
        lw_vec2 at = lw_sketch_pixel(k, 0, l->tracer[i].at);
        label(k, LW_ROLE_JOINT_LABEL, l->n_joint + i, l->tracer[i].link, l->tracer[i].name,
              LABEL_SIZE*u, at, at, 9*u, LW_INK_BLUE);
    }
    for (int i = 0; i < l->n_joint; i++) {
        const lw_joint *j = &l->joint[i];
        bool slides = j->kind == LW_JOINT_SLIDER;
        lw_slide w = slides ? lw_body_shapes_slide(k->s, i) : (lw_slide){ .at = j->at };
        lw_cylinder c;
        if (slides && lw_body_shapes_cylinder(k->s, i, &c)) {
            w.at = lw_v2_add(c.pin[0], lw_v2_scale(c.along, 0.5*c.tube_length));
            w.block = c.tube;
        }
        lw_vec2 at = lw_sketch_pixel(k, 0, w.at);
        int link = slides ? w.block : on_ground(l, j) ? l->ground : j->link[1];
        label(k, LW_ROLE_JOINT_LABEL, i, link, j->name, LABEL_SIZE*u, at, at, (slides ? 17 : 10)*u,
              LW_INK_TEXT);
    }
}

/* The two nodes of a link whose distance is `length`: where a dimension "r<k>" stands. */
static bool find_length(const lw_scene *s, int link, double length, lw_vec2 *a, lw_vec2 *b)
{
    lw_shape_node node[LW_NODE_MAX];
    int n = lw_body_shapes_nodes(s, link, node);
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++)
            if (fabs(lw_v2_norm(lw_v2_sub(node[i].at, node[j].at)) - length) <= 1e-6*length) {
                *a = node[i].at;
                *b = node[j].at;
                return true;
            }
    return false;
}

static void label_length(lw_sketch *k, int link, const char *name, double length, lw_vec2 a, lw_vec2 b)
{
    char number[32], text[64];
    lw_number_text(number, length/linkage(k)->units.metre, 4);
    bool both = name[0] && k->o->length_values;
    snprintf(text, sizeof text, "%s%s%s", name, both ? " = " : "", both || !name[0] ? number : "");
    lw_vec2 p = lw_sketch_pixel(k, 0, a), q = lw_sketch_pixel(k, 0, b);
    label(k, LW_ROLE_LENGTH_LABEL, link, link, text, LENGTH_SIZE*k->u, p, q, 6*k->u, LW_INK_FAINT);
}

static void label_lengths(lw_sketch *k)
{
    const lw_scene *s = k->s;
    lw_vec2 a, b;
    for (int i = 0; i < s->n_dim; i++)
        if (s->dim_kind[i] == LW_DIM_LENGTH
            && find_length(s, s->dim_link[i], s->dim[i], &a, &b))
            label_length(k, s->dim_link[i], s->dim_name[i], s->dim[i], a, b);
    for (int link = 0; s->n_dim == 0 && link < s->linkage.n_link; link++) {
        lw_shape_node node[LW_NODE_MAX];
        if (link != s->linkage.ground && lw_body_shapes_nodes(s, link, node) == 2)
            label_length(k, link, "", lw_v2_norm(lw_v2_sub(node[0].at, node[1].at)), node[0].at,
                         node[1].at);
    }
}

void lw_sketch_label_linkage(lw_sketch *k)
{
    label_points(k);
    if (k->o->length_labels)
        label_lengths(k);
}
