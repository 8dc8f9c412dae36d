/* catalogues/draw/diagram_linkage.c - the links, joints, contours, springs and ropes of a diagram. */
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
#include "mbs/elastic/superelement.h"

bool lw_sketch_clip(const lw_box *box, lw_vec2 *a, lw_vec2 *b)
{
    if (!isfinite(a->x + a->y + b->x + b->y))
        return false;
    double lo[2] = { box->x0, box->y0 }, hi[2] = { box->x1, box->y1 };
    double from[2] = { a->x, a->y }, way[2] = { b->x - a->x, b->y - a->y }, t0 = 0, t1 = 1;
    for (int i = 0; i < 2; i++) {
        if (way[i] == 0 && (from[i] < lo[i] || from[i] > hi[i]))
            return false;
        double in = ((way[i] > 0 ? lo[i] : hi[i]) - from[i])/way[i];
        double out = ((way[i] > 0 ? hi[i] : lo[i]) - from[i])/way[i];
        if (way[i] != 0) {
            t0 = fmax(t0, in);
            t1 = fmin(t1, out);
        }
    }
    if (!(t0 <= t1))
        return false;
    if (t1 < 1)
        *b = lw_v2(from[0] + t1*way[0], from[1] + t1*way[1]);
    if (t0 > 0)
        *a = lw_v2(from[0] + t0*way[0], from[1] + t0*way[1]);
    return true;
}

/* The link that the input moves, relative to the other link of the joint. */
static int driven_link(const lw_assembly *linkage, const lw_joint *j)
{
    return j->link[1] == linkage->ground ? j->link[0] : j->link[1];
}

static lw_ink link_ink(const lw_assembly *linkage, int link)
{
    for (int i = 0; i < linkage->n_input; i++)
        if (driven_link(linkage, &linkage->joint[linkage->input[i].joint]) == link)
            return LW_INK_PURPLE;
    for (int i = 0; i < linkage->n_tracer; i++)
        if (linkage->tracer[i].link == link)
            return LW_INK_GREEN;
    return LW_INK_LINK;
}

static lw_bearer bearer(const lw_assembly *linkage, int item, int link)
{
    return (lw_bearer){ item, link == linkage->ground ? -1 : link, 0 };
}

/* Draw the guide of a slider below everything else: a hatched line on the ground, a bar on a moving link. */
static void draw_cylinder(lw_sketch *k, const lw_cylinder *c, int joint);

static void draw_guide(lw_sketch *k, int joint)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
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
    if (lw_joint_has_slot(l->joint[joint].kind))
        lw_symbol_slot(k->d, carrier, a, b, link_ink(l, w.guide), u);
    else if (w.guide == l->ground) {
        if (b.x < a.x || (b.x == a.x && b.y < a.y)) {      /* hatching below or left of the line */
            lw_vec2 t = a;
            a = b;
            b = t;
        }
        lw_vec2 down = lw_v2_sub(b, a);
        double length = fmax(lw_v2_norm(down), 1e-9);
        down = lw_v2_scale(lw_v2_perp(down), 10*u/length);             /* under the block's edge */
        lw_symbol_hatched_line(k->d, carrier, lw_v2_add(a, down), lw_v2_add(b, down), u);
        for (double depth = 1; depth < 1.8; depth += 0.35)                          /* hatching */
            lw_label_map_line(&k->map, lw_v2_add(a, lw_v2_scale(down, depth)), lw_v2_add(b, lw_v2_scale(down, depth)), 1);
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
    lw_symbol_block(k->d, bearer(lw_sketch_linkage_of(k), joint, w.block), at, lw_v2(w.along.x, -w.along.y), link_ink(lw_sketch_linkage_of(k), w.block), k->u);
    lw_label_map_disc(&k->map, at, 15*k->u, 2);
}

/* Draw tube and piston of a hydraulic cylinder, below everything else. */
static void draw_cylinder(lw_sketch *k, const lw_cylinder *c, int joint)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    double scale = k->d->view[0].scale;
    lw_vec2 pin[2] = { lw_sketch_pixel(k, 0, c->pin[0]), lw_sketch_pixel(k, 0, c->pin[1]) };
    lw_vec2 along = lw_v2(c->along.x, -c->along.y);
    lw_symbol_tube(k->d, bearer(l, joint, c->tube), pin[0], along, scale*c->tube_length, link_ink(l, c->tube), k->u);
    lw_symbol_rod(k->d, bearer(l, c->rod, c->rod), pin[1], along, scale*c->rod_length, link_ink(l, c->rod), k->u);
    lw_label_map_line(&k->map, pin[0], pin[1], 2);
}

/* Was this wheel already drawn for an earlier gear joint? */
static bool is_drawn(const lw_sketch *k, int joint, const lw_wheel *w)
{
    for (int i = 0; i < joint; i++) {
        lw_wheel other[2];
        if (!lw_joint_has_ratio(lw_sketch_linkage_of(k)->joint[i].kind) || !lw_body_shapes_gear(k->s, i, other))
            continue;
        for (int side = 0; side < 2; side++)
            if (other[side].link == w->link && other[side].rack == w->rack
                && lw_v2_norm(lw_v2_sub(other[side].centre, w->centre)) < 1e-6*w->pitch
                && fabs(other[side].radius - w->radius) < 1e-6*w->pitch)
                return true;
    }
    return false;
}

/* away: direction of a rack's teeth, towards its pinion. */
static void draw_wheel(lw_sketch *k, int joint, const lw_wheel *w, lw_vec2 away)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    double scale = k->d->view[0].scale, u = k->u;
    lw_vec2 at = lw_sketch_pixel(k, 0, w->centre), along = lw_v2(w->along.x, -w->along.y);
    lw_bearer carrier = bearer(l, joint, w->link);
    lw_ink ink = link_ink(l, w->link);
    if (w->rack) {
        double body = 14*u, end = 1.5*w->pitch;
        if (lw_v2_dot(lw_v2_perp(along), lw_v2(away.x, -away.y)) > 0)
            body = -body;
        lw_symbol_rack(k->d, carrier, at, along, scale*(w->lo - end), scale*(w->hi + end), scale*w->pitch, w->gap, body, ink, u);
        return;
    }
    double size = 4*hypot(k->d->width, k->d->height);
    if (scale*w->radius < size)                             /* a wheel much larger than the picture looks like a line */
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

/* Direction on the page from a point of a link to the centre of its other nodes; (0, 0) if there are no others. */
static lw_vec2 inwards(const lw_sketch *k, int link, lw_vec2 from)
{
    const lw_vec2 *node = k->node;
    lw_vec2 sum = { 0, 0 };
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++)
        sum = lw_v2_add(sum, lw_v2_sub(node[i], from));
    double length = lw_v2_norm(sum);
    return length > 0 ? lw_v2(sum.x/length, -sum.y/length) : lw_v2(0, 0);
}

static const lw_elastic *elastic_of(const lw_sketch *k, int link)
{
    const lw_elastic *e = k->s->model && k->s->model->elastic ? &k->s->model->elastic[link] : NULL;
    return e && e->given && e->n_axis > 1 ? e : NULL;
}

static const lw_elastic *mesh_of(const lw_sketch *k, int link)
{
    const lw_elastic *e = k->s->model && k->s->model->elastic ? &k->s->model->elastic[link] : NULL;
    return e && e->n_node > 0 ? e : NULL;
}

static double distance(const lw_elastic *e, int node, lw_vec2 from) { return hypot(e->node[node].x - from.x, e->node[node].y - from.y); }

/* The mean direction of the edges at the node nearest to a point; as of the whole link if they cancel. */
static lw_vec2 leaves_mesh(const lw_sketch *k, int link, const lw_elastic *e, lw_vec2 from)
{
    int best = 0, (*edge)[2], n = lw_super_edges(e->n_node, e->n_node, e->node, e->stiffness, &edge);
    lw_vec2 sum = { 0, 0 };
    for (int i = 1; i < e->n_node; i++)
        best = distance(e, i, from) < distance(e, best, from) ? i : best;
    for (int i = 0; i < n; i++) {
        const lw_vec3 *a = &e->node[best], *b = &e->node[edge[i][edge[i][0] == best]];
        if (edge[i][0] == best || edge[i][1] == best)
            sum = lw_v2_add(sum, lw_v2_scale(lw_v2(b->x - a->x, a->y - b->y), 1/hypot(b->x - a->x, b->y - a->y)));
    }
    free(edge);
    return lw_v2_norm(sum) > 1e-6 ? lw_v2_scale(sum, 1/lw_v2_norm(sum)) : inwards(k, link, from);
}

/* Direction on the page in which a link leaves a point where it is held: along its axis or mesh if it is elastic. */
static lw_vec2 leaves(const lw_sketch *k, int link, lw_vec2 from)
{
    const lw_elastic *e = elastic_of(k, link), *mesh = mesh_of(k, link);
    int best = 0;
    if (!e)
        return mesh ? leaves_mesh(k, link, mesh, from) : inwards(k, link, from);
    for (int i = 1; i < e->n_axis; i++)
        if (hypot(e->axis[i].x - from.x, e->axis[i].y - from.y) < hypot(e->axis[best].x - from.x, e->axis[best].y - from.y))
            best = i;
    int next = best + 1 < e->n_axis ? best + 1 : best - 1;
    lw_vec2 way = lw_v2(e->axis[next].x - e->axis[best].x, e->axis[best].y - e->axis[next].y);
    return lw_v2_scale(way, 1/fmax(lw_v2_norm(way), 1e-300));
}

static void draw_weld(lw_sketch *k, int joint)
{
    const lw_joint *j = &lw_sketch_linkage_of(k)->joint[joint];
    lw_vec2 at = lw_sketch_pixel(k, 0, j->at);
    if (lw_sketch_on_ground(lw_sketch_linkage_of(k), j)) {
        int held = j->link[j->link[0] == lw_sketch_linkage_of(k)->ground];
        lw_symbol_clamp(k->d, bearer(lw_sketch_linkage_of(k), joint, lw_sketch_linkage_of(k)->ground), at, leaves(k, held, j->at), k->u);
        lw_label_map_disc(&k->map, at, 16*k->u, 3);
        return;
    }
    lw_symbol_weld(k->d, bearer(lw_sketch_linkage_of(k), joint, j->link[1]), at, inwards(k, j->link[0], j->at),
                   inwards(k, j->link[1], j->at), link_ink(lw_sketch_linkage_of(k), j->link[1]), k->u);
    lw_label_map_disc(&k->map, at, 8*k->u, 3);
}

enum { MANY_CORNERS = 64 };                              /* the lines between all of them would fill the plate again and again */

/* The bars of an elastic link along its axis, and arms from it to the points beside it. */
static void draw_elastic(lw_sketch *k, int link, const lw_elastic *e)
{
    lw_bearer b = bearer(lw_sketch_linkage_of(k), link, link);
    lw_vec2 *p = k->corner;
    for (int i = 0; i < e->n_axis; i++) {
        p[i] = lw_sketch_pixel(k, 0, lw_v2(e->axis[i].x, e->axis[i].y));
        if (i > 0)
            lw_label_map_line(&k->map, p[i - 1], p[i], 1);
    }
    lw_symbol_frame(k->d, b, p, e->n_axis, link_ink(lw_sketch_linkage_of(k), link), k->u);
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++) {
        lw_vec2 at = lw_sketch_pixel(k, 0, k->node[i]), best = p[0];
        for (int j = 0; j + 1 < e->n_axis; j++) {
            lw_vec2 along = lw_v2_sub(p[j + 1], p[j]);
            double part = lw_v2_dot(lw_v2_sub(at, p[j]), along)/lw_v2_dot(along, along);
            lw_vec2 foot = lw_v2_add(p[j], lw_v2_scale(along, fmin(fmax(part, 0), 1)));
            best = lw_v2_norm(lw_v2_sub(at, foot)) < lw_v2_norm(lw_v2_sub(at, best)) ? foot : best;
        }
        if (lw_v2_norm(lw_v2_sub(at, best)) > k->u)
            lw_symbol_frame(k->d, b, (lw_vec2[]){ best, at }, 2, link_ink(lw_sketch_linkage_of(k), link), 0.6*k->u);
    }
}

/* The edges of the mesh of a superelement, and arms from its nearest nodes to the points beside them.  false: no memory. */
static bool draw_mesh(lw_sketch *k, int link, const lw_elastic *e)
{
    int (*edge)[2], n_edge = lw_super_edges(e->n_node, e->n_node, e->node, e->stiffness, &edge);
    if (!edge)
        return false;
    lw_bearer b = bearer(lw_sketch_linkage_of(k), link, link);
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n_edge; i++) {
        const lw_vec3 *p = &e->node[edge[i][0]], *q = &e->node[edge[i][1]];
        lw_vec2 end[] = { lw_sketch_pixel(k, 0, lw_v2(p->x, p->y)), lw_sketch_pixel(k, 0, lw_v2(q->x, q->y)) };
        lw_label_map_line(&k->map, end[0], end[1], 1);
        lw_symbol_frame(k->d, b, end, 2, link_ink(lw_sketch_linkage_of(k), link), k->u);
    }
    free(edge);
    for (int i = 0; i < n; i++) {
        lw_vec2 at = lw_sketch_pixel(k, 0, k->node[i]), best = { INFINITY, INFINITY };
        for (int j = 0; j < e->n_node; j++) {
            lw_vec2 p = lw_sketch_pixel(k, 0, lw_v2(e->node[j].x, e->node[j].y));
            best = lw_v2_norm(lw_v2_sub(at, p)) < lw_v2_norm(lw_v2_sub(at, best)) ? p : best;
        }
        if (lw_v2_norm(lw_v2_sub(at, best)) > k->u)
            lw_symbol_frame(k->d, b, (lw_vec2[]){ best, at }, 2, link_ink(lw_sketch_linkage_of(k), link), 0.6*k->u);
    }
    return true;
}

static void draw_link(lw_sketch *k, int link)
{
    const lw_elastic *e = elastic_of(k, link), *mesh = mesh_of(k, link);
    if (mesh && draw_mesh(k, link, mesh))
        return;
    if (e) {
        draw_elastic(k, link, e);
        return;
    }
    const lw_vec2 *node = k->node;
    lw_vec2 *p = k->corner;
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++) {
        p[i] = lw_sketch_pixel(k, 0, node[i]);
        for (int j = n > MANY_CORNERS && i > 0 ? i - 1 : 0; j < i; j++)
            lw_label_map_line(&k->map, p[j], p[i], 1);
    }
    lw_symbol_link(k->d, bearer(lw_sketch_linkage_of(k), link, link), p, n, link_ink(lw_sketch_linkage_of(k), link), k->u);
}

/* Draw the line between the ground pins; the label of the frame's length stands beside it. */
static void draw_frame_line(lw_sketch *k)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    int last = -1;
    for (int i = 0; i < l->n_joint; i++) {
        if (!lw_joint_turns(l->joint[i].kind) || !lw_sketch_on_ground(l, &l->joint[i]))
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
    const lw_assembly *l = lw_sketch_linkage_of(k);
    for (int i = 0; i < l->n_joint; i++) {
        if (!lw_joint_turns(l->joint[i].kind) || !lw_sketch_on_ground(l, &l->joint[i]))
            continue;
        lw_vec2 at = lw_sketch_pixel(k, 0, l->joint[i].at);
        lw_symbol_pivot(k->d, (lw_bearer){ i, -1, 0 }, at, k->u);
        lw_label_map_disc(&k->map, lw_v2(at.x, at.y + 14*k->u), 16*k->u, 2);
    }
}

static void draw_pins(lw_sketch *k)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    for (int i = 0; i < l->n_joint; i++) {
        const lw_joint *j = &l->joint[i];
        if (!lw_joint_turns(j->kind) && !lw_joint_has_slot(j->kind))
            continue;
        lw_vec2 at = lw_sketch_pixel(k, 0, j->at);
        lw_symbol_pin(k->d, bearer(l, i, lw_sketch_on_ground(l, j) ? l->ground : j->link[1]), at, k->u);
        lw_label_map_disc(&k->map, at, 6*k->u, 3);
    }
    for (int i = 0; i < l->n_tracer; i++) {
        lw_vec2 at = lw_sketch_pixel(k, 0, l->tracer[i].at);
        lw_symbol_tracer(k->d, bearer(l, i, l->tracer[i].link), at, k->u);
        lw_label_map_disc(&k->map, at, 6*k->u, 3);
    }
}

/* Direction from the input pin to the centre of the driven link's other nodes [rad, page with y up]. */
static double driven_direction(const lw_sketch *k, int link, lw_vec2 pin)
{
    lw_vec2 on_page = inwards(k, link, pin);
    return atan2(-on_page.y, on_page.x);
}

static void draw_input(lw_sketch *k, int input)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    int joint = l->input[input].joint;
    bool back = l->input[input].ratio < 0;               /* coupled to the first input, in the opposite sense */
    const lw_joint *j = &l->joint[joint];
    int driven = driven_link(l, j), base = j->link[0] == driven ? j->link[1] : j->link[0];
    lw_bearer carrier = bearer(l, input, base);
    if (lw_joint_turns(j->kind)) {
        lw_vec2 at = lw_sketch_pixel(k, 0, j->at);
        double from = driven_direction(k, driven, j->at) + 0.4;
        lw_symbol_turning(k->d, carrier, at, from, back, k->u);
        for (int i = 0; i < 12; i++)
            lw_label_map_disc(&k->map, lw_v2_add(at, lw_v2_polar(27*k->u, -(from + 0.16*i))), 4*k->u, 2);
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

/* The outline of a link that can touch others: shaded; a line of the ground is hatched. */
static void draw_contour(lw_sketch *k, const lw_contour *c)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    double scale = k->d->view[0].scale, u = k->u;
    lw_vec2 a = lw_sketch_pixel(k, 0, c->at[0]), b = lw_sketch_pixel(k, 0, c->at[c->n > 1]), *p;
    lw_bearer carrier = bearer(l, c->link, c->link);
    const lw_box page = { -2*k->d->width, -2*k->d->height, 3*k->d->width, 3*k->d->height };
    lw_shape *s;
    switch (c->kind) {
    case LW_CONTOUR_LINE: {
        lw_vec2 along = lw_v2_sub(b, a);
        along = lw_v2_scale(along, 4*(k->d->width + k->d->height)/fmax(lw_v2_norm(along), 1e-9));
        lw_vec2 from = lw_v2_sub(a, along), to = lw_v2_add(a, along);
        if (lw_sketch_clip(&page, &from, &to))
            lw_symbol_hatched_line(k->d, carrier, from, to, u);
        return;
    }
    case LW_CONTOUR_CIRCLE:
        s = lw_drawing_circle(k->d, LW_ROLE_LINK, a, scale*c->radius);
        break;
    case LW_CONTOUR_SEGMENT:
        s = lw_drawing_line(k->d, LW_ROLE_LINK, a, b);
        break;
    default:
        p = malloc((size_t)c->n*sizeof *p);
        for (int i = 0; p && i < c->n; i++)
            p[i] = lw_sketch_pixel(k, 0, c->at[i]);
        s = lw_drawing_path(k->d, LW_ROLE_LINK, p, p ? (size_t)c->n : 0, true);
        free(p);
    }
    bool bar = c->kind == LW_CONTOUR_SEGMENT;
    s->item = carrier.item;
    s->link = carrier.link;
    s->panel = 0;
    s->stroke = c->link == l->ground ? LW_INK_GROUND : link_ink(l, c->link);
    s->width = bar ? fmax(2*c->radius*scale, 2*u) : 1.5*u;
    if (!bar)
        s->fill = s->stroke;
    s->alpha = 0.15;
}

/* Shapes from `first` on reach from the point a of link[0] to b of link[1] [px] and move with both; rigid: they do not stretch. */
static void tie(lw_sketch *k, size_t first, const int link[2], lw_vec2 a, lw_vec2 b, bool rigid)
{
    for (lw_shape *s = k->d->shape + first; s < k->d->shape + k->d->n_shape; s++) {
        s->link = link[0] == lw_sketch_linkage_of(k)->ground ? -1 : link[0];
        s->tie = link[1];
        s->panel = 0;
        s->at = a;
        s->hold = b;
        s->rigid = rigid;
    }
}

/* A rope, a straight line; or a spring, a zigzag.  Its ends move with two links. */
static void draw_tie(lw_sketch *k, const int link[2], const lw_vec2 end[2], bool spring)
{
    enum { TEETH = 9 };
    lw_vec2 a = lw_sketch_pixel(k, 0, end[0]), b = lw_sketch_pixel(k, 0, end[1]), p[TEETH + 4] = { a };
    lw_vec2 across = lw_v2_scale(lw_v2_perp(lw_v2_sub(b, a)), 1/fmax(lw_v2_norm(lw_v2_sub(b, a)), 1e-9));
    int n = 1;
    for (int i = 0; i <= TEETH && spring; i++)             /* the middle of its length */
        p[n++] = lw_v2_add(lw_v2_add(a, lw_v2_scale(lw_v2_sub(b, a), 0.2 + 0.6*i/TEETH)),
                           lw_v2_scale(across, (i == 0 || i == TEETH ? 0 : i % 2 ? 7 : -7)*k->u));
    p[n++] = b;
    lw_shape *s = lw_drawing_path(k->d, LW_ROLE_LINK, p, (size_t)n, false);
    tie(k, k->d->n_shape - 1, link, a, b, false);
    s->stroke = LW_INK_ORANGE;
    s->width = (spring ? 1.6 : 2.2)*k->u;
    lw_label_map_line(&k->map, a, b, 3);
}

/* A hydraulic cylinder between points of two links: tube and rod turn with the line between its pins and do not stretch. */
static void draw_jack(lw_sketch *k, const lw_spring *c)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    double scale = k->d->view[0].scale, tube = 0.95*scale*c->extent[0];
    lw_vec2 end[2] = { lw_sketch_pixel(k, 0, lw_v3_xy(c->at[0])), lw_sketch_pixel(k, 0, lw_v3_xy(c->at[1])) }, line = lw_v2_sub(end[1], end[0]);
    lw_vec2 along = lw_v2_scale(line, 1/fmax(lw_v2_norm(line), 1e-9));
    const int back[2] = { c->link[1], c->link[0] };
    size_t first = k->d->n_shape;
    lw_symbol_tube(k->d, (lw_bearer){ -1, -1, 0 }, end[0], along, tube, LW_INK_ORANGE, k->u);
    tie(k, first, c->link, end[0], end[1], true);
    first = k->d->n_shape;
    lw_symbol_rod(k->d, (lw_bearer){ -1, -1, 0 }, end[1], along, tube, LW_INK_ORANGE, k->u);
    tie(k, first, back, end[1], end[0], true);
    for (int i = 0; i < 2; i++) {
        if (c->link[i] == l->ground)
            lw_symbol_pivot(k->d, bearer(l, -1, l->ground), end[i], k->u);
        lw_symbol_pin(k->d, bearer(l, -1, c->link[i]), end[i], k->u);
    }
    lw_label_map_line(&k->map, end[0], end[1], 3);
}

void lw_sketch_linkage(lw_sketch *k)
{
    const lw_assembly *l = lw_sketch_linkage_of(k);
    const lw_model *m = k->s->model;
    for (int i = 0; m && i < m->n_shape; i++)
        draw_contour(k, &m->shape[i]);
    draw_frame_line(k);
    for (int i = 0; i < l->n_joint; i++)
        if (lw_joint_slides(l->joint[i].kind))
            draw_guide(k, i);
        else if (lw_joint_has_ratio(l->joint[i].kind))
            draw_gear(k, i);
    draw_pivots(k);
    for (int i = 0; i < l->n_link; i++)
        if (i != l->ground)
            draw_link(k, i);
    for (int i = 0; i < l->n_joint; i++)
        switch (l->joint[i].kind) {
        case LW_JOINT_SLIDER: draw_block(k, i); break;
        case LW_JOINT_FIXED:  draw_weld(k, i);  break;
        case LW_JOINT_REVOLUTE: case LW_JOINT_SLOT: case LW_JOINT_GEAR: case LW_JOINT_FREE: break;
        }
    for (int i = 0; i < l->n_input; i++)
        draw_input(k, i);
    for (int i = 0; m && i < m->n_rope; i++)
        draw_tie(k, m->rope[i].link, m->rope[i].at, false);
    for (int i = 0; m && i < m->n_spring; i++)
        if (m->spring[i].extent[1] > 0)
            draw_jack(k, &m->spring[i]);
        else
            draw_tie(k, m->spring[i].link, (lw_vec2[]){ lw_v3_xy(m->spring[i].at[0]), lw_v3_xy(m->spring[i].at[1]) }, true);
    draw_pins(k);
}
