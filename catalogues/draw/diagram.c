/* catalogues/draw/diagram.c - draw a scene: links and joints with their labels, then the margins (title, scale bar,
 * legend), then views, curves and target. */
#include "catalogues/draw/diagram.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "base/number.h"
#include "base/real.h"
#include "catalogues/draw/body_shapes.h"
#include "catalogues/draw/labels.h"
#include "catalogues/draw/symbols.h"
#include "catalogues/draw/views.h"
#include "grammar/model/model.h"
#include "mbs/elastic/superelement.h"

typedef struct sketch {
    const lw_scene *s;
    const lw_diagram_options *o;
    lw_drawing *d;
    lw_label_map map;
    double u;                  /* size of signs and letters: 1 for a page of 1000 by 750           */
    double signs;              /* factor on those of links and joints                              */
    int    room;               /* for the points of a link, in metres and on the page              */
    lw_vec2 *node;
    lw_vec2 *corner;
} sketch;

static lw_vec2 pixel_of(const sketch *k, int panel, lw_vec2 p);

/* Clip the line a b to a box (Liang and Barsky 1984). False: the line misses the box or is not finite. */
static bool clip_line(const lw_box *box, lw_vec2 *a, lw_vec2 *b);

static lw_box view_box(const lw_view *v);              /* where labels may stand                  */

/* ==== links and joints ======================================================================================== */

#define LABEL_SIZE 14.5
#define LENGTH_SIZE 12.5

static const lw_assembly *linkage(const sketch *k)
{
    return &k->s->linkage;
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
static void draw_cylinder(sketch *k, const lw_cylinder *c, int joint);

static void draw_guide(sketch *k, int joint)
{
    const lw_assembly *l = linkage(k);
    lw_cylinder c;
    if (lw_body_shapes_cylinder(k->s, joint, &c)) {
        draw_cylinder(k, &c, joint);
        return;
    }
    lw_slide w = lw_body_shapes_slide(k->s, joint);
    double end = 30*k->u/k->d->view[0].scale, u = k->u;
    lw_vec2 a = pixel_of(k, 0, lw_v2_add(w.at, lw_v2_scale(w.along, w.lo - end)));
    lw_vec2 b = pixel_of(k, 0, lw_v2_add(w.at, lw_v2_scale(w.along, w.hi + end)));
    lw_bearer carrier = bearer(l, joint, w.guide);
    const lw_box page = { -2*k->d->width, -2*k->d->height, 3*k->d->width, 3*k->d->height };
    if (!clip_line(&page, &a, &b))
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

static void draw_block(sketch *k, int joint)
{
    lw_cylinder c;
    if (lw_body_shapes_cylinder(k->s, joint, &c))
        return;
    lw_slide w = lw_body_shapes_slide(k->s, joint);
    lw_vec2 at = pixel_of(k, 0, w.at);
    lw_symbol_block(k->d, bearer(linkage(k), joint, w.block), at, lw_v2(w.along.x, -w.along.y), link_ink(linkage(k), w.block), k->u);
    lw_label_map_disc(&k->map, at, 15*k->u, 2);
}

/* Draw tube and piston of a hydraulic cylinder, below everything else. */
static void draw_cylinder(sketch *k, const lw_cylinder *c, int joint)
{
    const lw_assembly *l = linkage(k);
    double scale = k->d->view[0].scale;
    lw_vec2 pin[2] = { pixel_of(k, 0, c->pin[0]), pixel_of(k, 0, c->pin[1]) };
    lw_vec2 along = lw_v2(c->along.x, -c->along.y);
    lw_symbol_tube(k->d, bearer(l, joint, c->tube), pin[0], along, scale*c->tube_length, link_ink(l, c->tube), k->u);
    lw_symbol_rod(k->d, bearer(l, c->rod, c->rod), pin[1], along, scale*c->rod_length, link_ink(l, c->rod), k->u);
    lw_label_map_line(&k->map, pin[0], pin[1], 2);
}

/* Was this wheel already drawn for an earlier gear joint? */
static bool is_drawn(const sketch *k, int joint, const lw_wheel *w)
{
    for (int i = 0; i < joint; i++) {
        lw_wheel other[2];
        if (!lw_joint_has_ratio(linkage(k)->joint[i].kind) || !lw_body_shapes_gear(k->s, i, other))
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
static void draw_wheel(sketch *k, int joint, const lw_wheel *w, lw_vec2 away)
{
    const lw_assembly *l = linkage(k);
    double scale = k->d->view[0].scale, u = k->u;
    lw_vec2 at = pixel_of(k, 0, w->centre), along = lw_v2(w->along.x, -w->along.y);
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

static void draw_gear(sketch *k, int joint)
{
    lw_wheel w[2];
    if (!lw_body_shapes_gear(k->s, joint, w))
        return;
    for (int side = 0; side < 2; side++)
        if (!is_drawn(k, joint, &w[side]))
            draw_wheel(k, joint, &w[side], lw_v2_sub(w[1 - side].centre, w[side].centre));
}

/* Direction on the page from a point of a link to the centre of its other nodes; (0, 0) if there are no others. */
static lw_vec2 inwards(const sketch *k, int link, lw_vec2 from)
{
    const lw_vec2 *node = k->node;
    lw_vec2 sum = { 0, 0 };
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++)
        sum = lw_v2_add(sum, lw_v2_sub(node[i], from));
    double length = lw_v2_norm(sum);
    return length > 0 ? lw_v2(sum.x/length, -sum.y/length) : lw_v2(0, 0);
}

static bool on_ground(const lw_assembly *linkage, const lw_joint *j)
{
    return j->link[0] == linkage->ground || j->link[1] == linkage->ground;
}

static const lw_elastic *elastic_of(const sketch *k, int link)
{
    const lw_elastic *e = k->s->model && k->s->model->elastic ? &k->s->model->elastic[link] : NULL;
    return e && e->given && e->n_axis > 1 ? e : NULL;
}

static const lw_elastic *mesh_of(const sketch *k, int link)
{
    const lw_elastic *e = k->s->model && k->s->model->elastic ? &k->s->model->elastic[link] : NULL;
    return e && e->n_node > 0 ? e : NULL;
}

/* The edges of the mesh of a superelement, *n; free it.  NULL: no memory. */
static int (*edges_of(const lw_elastic *e, int *n))[2]
{
    int (*edge)[2] = malloc((size_t)e->n_node*(size_t)e->n_node/2*sizeof *edge + 1);
    *n = edge ? lw_super_edges(e->n_node, e->n_node, e->node, e->stiffness, edge) : 0;
    return edge;
}

static double distance(const lw_elastic *e, int node, lw_vec2 from) { return hypot(e->node[node].x - from.x, e->node[node].y - from.y); }

/* The mean direction of the edges at the node nearest to a point; as of the whole link if they cancel. */
static lw_vec2 leaves_mesh(const sketch *k, int link, const lw_elastic *e, lw_vec2 from)
{
    int n, best = 0, (*edge)[2] = edges_of(e, &n);
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
static lw_vec2 leaves(const sketch *k, int link, lw_vec2 from)
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

static void draw_weld(sketch *k, int joint)
{
    const lw_joint *j = &linkage(k)->joint[joint];
    lw_vec2 at = pixel_of(k, 0, j->at);
    if (on_ground(linkage(k), j)) {
        int held = j->link[j->link[0] == linkage(k)->ground];
        lw_symbol_clamp(k->d, bearer(linkage(k), joint, linkage(k)->ground), at, leaves(k, held, j->at), k->u);
        lw_label_map_disc(&k->map, at, 16*k->u, 3);
        return;
    }
    lw_symbol_weld(k->d, bearer(linkage(k), joint, j->link[1]), at, inwards(k, j->link[0], j->at),
                   inwards(k, j->link[1], j->at), link_ink(linkage(k), j->link[1]), k->u);
    lw_label_map_disc(&k->map, at, 8*k->u, 3);
}

enum { MANY_CORNERS = 64 };                              /* the lines between all of them would fill the plate again and again */

/* The bars of an elastic link along its axis, and arms from it to the points beside it. */
static void draw_elastic(sketch *k, int link, const lw_elastic *e)
{
    lw_bearer b = bearer(linkage(k), link, link);
    lw_vec2 *p = k->corner;
    for (int i = 0; i < e->n_axis; i++) {
        p[i] = pixel_of(k, 0, lw_v2(e->axis[i].x, e->axis[i].y));
        if (i > 0)
            lw_label_map_line(&k->map, p[i - 1], p[i], 1);
    }
    lw_symbol_frame(k->d, b, p, e->n_axis, link_ink(linkage(k), link), k->u);
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++) {
        lw_vec2 at = pixel_of(k, 0, k->node[i]), best = p[0];
        for (int j = 0; j + 1 < e->n_axis; j++) {
            lw_vec2 along = lw_v2_sub(p[j + 1], p[j]);
            double part = lw_v2_dot(lw_v2_sub(at, p[j]), along)/lw_v2_dot(along, along);
            lw_vec2 foot = lw_v2_add(p[j], lw_v2_scale(along, fmin(fmax(part, 0), 1)));
            best = lw_v2_norm(lw_v2_sub(at, foot)) < lw_v2_norm(lw_v2_sub(at, best)) ? foot : best;
        }
        if (lw_v2_norm(lw_v2_sub(at, best)) > k->u)
            lw_symbol_frame(k->d, b, (lw_vec2[]){ best, at }, 2, link_ink(linkage(k), link), 0.6*k->u);
    }
}

/* The edges of the mesh of a superelement, and arms from its nearest nodes to the points beside them.  false: no memory. */
static bool draw_mesh(sketch *k, int link, const lw_elastic *e)
{
    int n_edge, (*edge)[2] = edges_of(e, &n_edge);
    if (!edge)
        return false;
    lw_bearer b = bearer(linkage(k), link, link);
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n_edge; i++) {
        const lw_vec3 *p = &e->node[edge[i][0]], *q = &e->node[edge[i][1]];
        lw_vec2 end[] = { pixel_of(k, 0, lw_v2(p->x, p->y)), pixel_of(k, 0, lw_v2(q->x, q->y)) };
        lw_label_map_line(&k->map, end[0], end[1], 1);
        lw_symbol_frame(k->d, b, end, 2, link_ink(linkage(k), link), k->u);
    }
    free(edge);
    for (int i = 0; i < n; i++) {
        lw_vec2 at = pixel_of(k, 0, k->node[i]), best = { INFINITY, INFINITY };
        for (int j = 0; j < e->n_node; j++) {
            lw_vec2 p = pixel_of(k, 0, lw_v2(e->node[j].x, e->node[j].y));
            best = lw_v2_norm(lw_v2_sub(at, p)) < lw_v2_norm(lw_v2_sub(at, best)) ? p : best;
        }
        if (lw_v2_norm(lw_v2_sub(at, best)) > k->u)
            lw_symbol_frame(k->d, b, (lw_vec2[]){ best, at }, 2, link_ink(linkage(k), link), 0.6*k->u);
    }
    return true;
}

static void draw_link(sketch *k, int link)
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
        p[i] = pixel_of(k, 0, node[i]);
        for (int j = n > MANY_CORNERS && i > 0 ? i - 1 : 0; j < i; j++)
            lw_label_map_line(&k->map, p[j], p[i], 1);
    }
    lw_symbol_link(k->d, bearer(linkage(k), link, link), p, n, link_ink(linkage(k), link), k->u);
}

/* Draw the line between the ground pins; the label of the frame's length stands beside it. */
static void draw_frame_line(sketch *k)
{
    const lw_assembly *l = linkage(k);
    int last = -1;
    for (int i = 0; i < l->n_joint; i++) {
        if (!lw_joint_turns(l->joint[i].kind) || !on_ground(l, &l->joint[i]))
            continue;
        if (last >= 0) {
            lw_vec2 a = pixel_of(k, 0, l->joint[last].at);
            lw_vec2 b = pixel_of(k, 0, l->joint[i].at);
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

static void draw_pivots(sketch *k)
{
    const lw_assembly *l = linkage(k);
    for (int i = 0; i < l->n_joint; i++) {
        if (!lw_joint_turns(l->joint[i].kind) || !on_ground(l, &l->joint[i]))
            continue;
        lw_vec2 at = pixel_of(k, 0, l->joint[i].at);
        lw_symbol_pivot(k->d, (lw_bearer){ i, -1, 0 }, at, k->u);
        lw_label_map_disc(&k->map, lw_v2(at.x, at.y + 14*k->u), 16*k->u, 2);
    }
}

static void draw_pins(sketch *k)
{
    const lw_assembly *l = linkage(k);
    for (int i = 0; i < l->n_joint; i++) {
        const lw_joint *j = &l->joint[i];
        if (!lw_joint_turns(j->kind) && !lw_joint_has_slot(j->kind))
            continue;
        lw_vec2 at = pixel_of(k, 0, j->at);
        lw_symbol_pin(k->d, bearer(l, i, on_ground(l, j) ? l->ground : j->link[1]), at, k->u);
        lw_label_map_disc(&k->map, at, 6*k->u, 3);
    }
    for (int i = 0; i < l->n_tracer; i++) {
        lw_vec2 at = pixel_of(k, 0, l->tracer[i].at);
        lw_symbol_tracer(k->d, bearer(l, i, l->tracer[i].link), at, k->u);
        lw_label_map_disc(&k->map, at, 6*k->u, 3);
    }
}

/* Direction from the input pin to the centre of the driven link's other nodes [rad, page with y up]. */
static double driven_direction(const sketch *k, int link, lw_vec2 pin)
{
    const lw_vec2 *node = k->node;
    lw_vec2 sum = { 0, 0 };
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++)
        sum = lw_v2_add(sum, lw_v2_sub(node[i], pin));
    return atan2(sum.y, sum.x);
}

static void draw_input(sketch *k, int input)
{
    const lw_assembly *l = linkage(k);
    int joint = l->input[input].joint;
    bool back = l->input[input].ratio < 0;               /* coupled to the first input, in the opposite sense */
    const lw_joint *j = &l->joint[joint];
    int driven = driven_link(l, j), base = j->link[0] == driven ? j->link[1] : j->link[0];
    lw_bearer carrier = bearer(l, input, base);
    if (lw_joint_turns(j->kind)) {
        lw_vec2 at = pixel_of(k, 0, j->at);
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
    lw_vec2 at = lw_v2_add(pixel_of(k, 0, w.at), lw_v2_scale(lw_v2_perp(along), -21*k->u));
    lw_vec2 a = lw_v2_sub(at, lw_v2_scale(along, 20*k->u)), b = lw_v2_add(at, lw_v2_scale(along, 24*k->u));
    lw_symbol_arrow(k->d, carrier, a, b, k->u);
    lw_label_map_line(&k->map, a, b, 2);
}

/* The outline of a link that can touch others: shaded; a line of the ground is hatched. */
static void draw_contour(sketch *k, const lw_contour *c)
{
    const lw_assembly *l = linkage(k);
    double scale = k->d->view[0].scale, u = k->u;
    lw_vec2 a = pixel_of(k, 0, c->at[0]), b = pixel_of(k, 0, c->at[c->n > 1]), *p;
    lw_bearer carrier = bearer(l, c->link, c->link);
    const lw_box page = { -2*k->d->width, -2*k->d->height, 3*k->d->width, 3*k->d->height };
    lw_shape *s;
    switch (c->kind) {
    case LW_CONTOUR_LINE: {
        lw_vec2 along = lw_v2_sub(b, a);
        along = lw_v2_scale(along, 4*(k->d->width + k->d->height)/fmax(lw_v2_norm(along), 1e-9));
        lw_vec2 from = lw_v2_sub(a, along), to = lw_v2_add(a, along);
        if (clip_line(&page, &from, &to))
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
            p[i] = pixel_of(k, 0, c->at[i]);
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
static void tie(sketch *k, size_t first, const int link[2], lw_vec2 a, lw_vec2 b, bool rigid)
{
    for (lw_shape *s = k->d->shape + first; s < k->d->shape + k->d->n_shape; s++) {
        s->link = link[0] == linkage(k)->ground ? -1 : link[0];
        s->tie = link[1];
        s->panel = 0;
        s->at = a;
        s->hold = b;
        s->rigid = rigid;
    }
}

/* A rope, a straight line; or a spring, a zigzag.  Its ends move with two links. */
static void draw_tie(sketch *k, const int link[2], const lw_vec2 end[2], bool spring)
{
    enum { TEETH = 9 };
    lw_vec2 a = pixel_of(k, 0, end[0]), b = pixel_of(k, 0, end[1]), p[TEETH + 4] = { a };
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
static void draw_jack(sketch *k, const lw_spring *c)
{
    const lw_assembly *l = linkage(k);
    double scale = k->d->view[0].scale, tube = 0.95*scale*c->extent[0];
    lw_vec2 end[2] = { pixel_of(k, 0, c->at[0]), pixel_of(k, 0, c->at[1]) }, line = lw_v2_sub(end[1], end[0]);
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

static void sketch_linkage(sketch *k)
{
    const lw_assembly *l = linkage(k);
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
            draw_tie(k, m->spring[i].link, m->spring[i].at, true);
    draw_pins(k);
}

/* Add a label that moves with a link: beside the line a b, or beside the point a if a = b. */
static void label(sketch *k, lw_role role, int item, int link, const char *text, double size, lw_vec2 a, lw_vec2 b, double gap, lw_ink ink)
{
    lw_vec2 at;
    if (!lw_label_map_place(&k->map, text, size, a, b, gap, view_box(&k->d->view[0]), &at))
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

static void label_points(sketch *k)
{
    const lw_assembly *l = linkage(k);
    double u = k->u;
    for (int i = 0; i < l->n_tracer; i++) {
        lw_vec2 at = pixel_of(k, 0, l->tracer[i].at);
        label(k, LW_ROLE_JOINT_LABEL, l->n_joint + i, l->tracer[i].link, l->tracer[i].name, LABEL_SIZE*u, at, at, 9*u, LW_INK_BLUE);
    }
    for (int i = 0; i < l->n_joint; i++) {
        const lw_joint *j = &l->joint[i];
        if (j->kind == LW_JOINT_FREE)
            continue;
        bool slides = lw_joint_translates(j->kind);
        lw_slide w = slides ? lw_body_shapes_slide(k->s, i) : (lw_slide){ .at = j->at };
        lw_cylinder c;
        if (slides && lw_body_shapes_cylinder(k->s, i, &c)) {
            w.at = lw_v2_add(c.pin[0], lw_v2_scale(c.along, 0.5*c.tube_length));
            w.block = c.tube;
        }
        lw_vec2 at = pixel_of(k, 0, w.at);
        int link = slides ? w.block : on_ground(l, j) ? l->ground : j->link[1];
        label(k, LW_ROLE_JOINT_LABEL, i, link, j->name, LABEL_SIZE*u, at, at, (slides ? 17 : 10)*u, LW_INK_TEXT);
    }
}

/* Find the two nodes of a link whose distance is `length`: the label of dimension "r<k>" stands between them. */
static bool find_length(const sketch *k, int link, double length, lw_vec2 *a, lw_vec2 *b)
{
    const lw_vec2 *node = k->node;
    int n = lw_body_shapes_nodes(k->s, link, k->node, k->room);
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++)
            if (fabs(lw_v2_norm(lw_v2_sub(node[i], node[j])) - length) <= 1e-6*length) {
                *a = node[i];
                *b = node[j];
                return true;
            }
    return false;
}

static void label_length(sketch *k, int link, const char *name, double length, lw_vec2 a, lw_vec2 b)
{
    char number[32], text[64];
    lw_number_text(number, length/linkage(k)->units.metre, 4);
    bool both = name[0] && k->o->length_values;
    snprintf(text, sizeof text, "%s%s%s", name, both ? " = " : "", both || !name[0] ? number : "");
    lw_vec2 p = pixel_of(k, 0, a), q = pixel_of(k, 0, b);
    label(k, LW_ROLE_LENGTH_LABEL, link, link, text, LENGTH_SIZE*k->u, p, q, 6*k->u, LW_INK_FAINT);
}

static void label_lengths(sketch *k)
{
    const lw_scene *s = k->s;
    lw_vec2 a, b;
    for (int i = 0; i < s->n_dim; i++)
        if (s->dim_kind[i] == LW_DIM_LENGTH && find_length(k, s->dim_link[i], s->dim[i], &a, &b))
            label_length(k, s->dim_link[i], s->dim_name[i], s->dim[i], a, b);
    for (int link = 0; s->n_dim == 0 && link < s->linkage.n_link; link++) {
        const lw_vec2 *node = k->node;
        if (link != s->linkage.ground && lw_body_shapes_nodes(s, link, k->node, k->room) == 2)
            label_length(k, link, "", lw_v2_norm(lw_v2_sub(node[0], node[1])), node[0], node[1]);
    }
}

static void label_linkage(sketch *k)
{
    label_points(k);
    if (k->o->length_labels)
        label_lengths(k);
}

/* ==== margins ================================================================================================= */

static void faint_line(sketch *k, const char *text, double y)
{
    lw_drawing_text(k->d, LW_ROLE_NOTE, text, lw_v2(16*k->u, y), 12.5*k->u, 0)->fill = LW_INK_FAINT;
}

/* Text of dimension i, such as "r2 = 1.25", in the units of the file. */
static void dimension_text(const lw_scene *s, int i, char *text, size_t size)
{
    char number[32];
    lw_number_text(number, lw_scene_dimension(s, i), 5);
    snprintf(text, size, "%s = %s", s->dim_name[i], number);
}

/* Write the dimensions in at most four lines of the page's width. Returns the base line below them. */
static double list_dimensions(sketch *k, double y)
{
    const lw_scene *s = k->s;
    char line[512] = "", item[64];
    double width = k->d->width - 32*k->u;
    int n_line = 0;
    for (int i = 0; i <= s->n_dim; i++) {
        if (i < s->n_dim)
            dimension_text(s, i, item, sizeof item);
        else
            snprintf(item, sizeof item, "[%s, %s]",
                     s->linkage.units.length[0] ? s->linkage.units.length : "length units",
                     s->linkage.units.angle[0] ? s->linkage.units.angle : "rad");
        size_t used = strlen(line);
        char longer[sizeof line + sizeof item + 4];
        snprintf(longer, sizeof longer, "%s%s%s", line, used ? "  " : "", item);
        if (used && (lw_text_width(longer, 12.5*k->u) > width || strlen(longer) >= sizeof line)) {
            faint_line(k, line, y);
            y += 17*k->u;
            snprintf(longer, sizeof longer, "%s", ++n_line == 4 ? "" : item);
        }
        memcpy(line, longer, strlen(longer) + 1);
        if (n_line == 4)
            return y;
    }
    faint_line(k, line, y);
    return y + 17*k->u;
}

/* Cut text to a width [px] and end it with three dots. */
static void shorten(char *text, double size, double width)
{
    size_t n = strlen(text);
    if (lw_text_width(text, size) <= width)
        return;
    while (n > 0 && lw_text_width(text, size) + 1.2*size > width) {
        do
            n--;
        while (n > 0 && ((unsigned char)text[n] & 0xc0) == 0x80);
        text[n] = 0;
    }
    memcpy(text + n, "...", 4);
}

static double sketch_header(sketch *k)
{
    lw_drawing *d = k->d;
    double u = k->u, y = 14*u;
    lw_vec2 page[4] = { { 0, 0 }, { d->width, 0 }, { d->width, d->height }, { 0, d->height } };
    lw_drawing_path(d, LW_ROLE_PAPER, page, 4, true)->fill = LW_INK_PAPER;
    char title[sizeof k->s->title + 4];
    lw_text_clean(title, sizeof title - 4, k->s->title);
    if (title[0] && k->o->title) {
        shorten(title, 19*u, d->width - 32*u);
        y += 16*u;
        lw_drawing_text(d, LW_ROLE_TITLE, title, lw_v2(16*u, y), 19*u, 0)->bold = true;
        y += 21*u;
    } else if (k->o->dimensions)
        y += 8*u;
    if (k->o->dimensions && k->s->n_dim > 0)
        y = list_dimensions(k, y);
    return y - 8*u;
}

static void scale_bar(sketch *k, int panel)
{
    const lw_view *v = &k->d->view[panel];
    const lw_units *units = &k->s->linkage.units;
    double u = k->u, px = v->scale*units->metre;                     /* [px] per unit of the file */
    lw_vec2 at = lw_v2(v->x + 16*u, v->y + v->h - 12*u);
    double w = lw_symbol_scale_bar(k->d, (lw_bearer){ panel, -1, -1 }, at, px, 0.24*v->w, units->length, "", u);
    if (w > 0)
        lw_label_map_take(&k->map, (lw_box){ at.x - 4, at.y - 16*u, at.x + w + 5*u, v->y + v->h });
}

/* The entries of the legend, from right to left: what each one shows, its text, width of its sample [px]. */
typedef enum lw_sample { TARGET, OTHER, COMPARED, TRACED, N_SAMPLE } lw_sample;
static const struct { const char *text; double room; } samples[N_SAMPLE] = {
    [TARGET] = { "target", 36 }, [OTHER] = { "also possible", 52 }, [COMPARED] = { "second linkage", 52 },
    [TRACED] = { "traced curve", 52 },
};

static bool is_shown(const lw_scene *s, lw_sample sample)
{
    if (sample == TARGET)
        return s->n_station > 0;
    for (int i = 0; i < s->n_curve; i++)
        if (s->curve[i].compared ? sample == COMPARED : sample != COMPARED && s->curve[i].shown_branch == (sample == TRACED))
            return true;
    return false;
}

static double legend_width(const sketch *k)
{
    double w = 0;
    for (int i = 0; i < N_SAMPLE; i++)
        if (is_shown(k->s, (lw_sample)i))
            w += lw_text_width(samples[i].text, 12*k->u) + samples[i].room*k->u;
    return w;
}

static double foot_height(const sketch *k, double width)
{
    bool beside = legend_width(k) + 0.24*width + 130*k->u < width;
    return (beside ? 30 : 48)*k->u;
}

/* Draw one entry that ends at x. Returns where the entry left of it ends. */
static double entry(sketch *k, double x, double y, lw_sample sample)
{
    double u = k->u, left = x - lw_text_width(samples[sample].text, 12*u);
    lw_drawing_text(k->d, LW_ROLE_LEGEND, samples[sample].text, lw_v2(left, y), 12*u, 0);
    if (sample == TARGET)
        lw_symbol_station(k->d, LW_ROLE_LEGEND, (lw_bearer){ -1, -1, -1 },
                          lw_v2(left - 14*u, y - 4*u), u);
    else {
        lw_shape *s = lw_drawing_line(k->d, LW_ROLE_LEGEND, lw_v2(left - 34*u, y - 4*u), lw_v2(left - 8*u, y - 4*u));
        s->stroke = sample == COMPARED ? LW_INK_RED : LW_INK_BLUE;
        s->width = (sample == TRACED ? 2.6 : 1.6)*u;
        s->dashed = sample == OTHER;
    }
    return left - samples[sample].room*u;
}

/* Draw the legend in the last panel: beside the scale bar, or above it where the panel is narrow. */
static void legend(sketch *k)
{
    const lw_view *v = &k->d->view[k->d->n_view - 1];
    double u = k->u, end = v->x + v->w - 14*u, x = end;
    double y = v->y + v->h - foot_height(k, v->w) + 18*u;
    for (int i = 0; i < N_SAMPLE; i++)
        if (is_shown(k->s, (lw_sample)i))
            x = entry(k, x, y, (lw_sample)i);
    if (x < end)
        lw_label_map_take(&k->map, (lw_box){ x, y - 16*u, end, v->y + v->h });
}

static void sketch_feet(sketch *k)
{
    for (int i = 0; i < k->d->n_view; i++)
        scale_bar(k, i);
    legend(k);
    const lw_view *v = &k->d->view[0];
    if (k->s->note[0] == 0)
        return;
    char note[sizeof k->s->note + 4];
    double u = k->u, y = v->y + v->h - 6*u - foot_height(k, v->w);
    lw_text_clean(note, sizeof note - 4, k->s->note);
    shorten(note, 12*u, v->w - 32*u);
    lw_drawing_text(k->d, LW_ROLE_NOTE, note, lw_v2(16*u, y), 12*u, 0)->fill = LW_INK_FAINT;
    lw_label_map_take(&k->map, (lw_box){ 12*u, y - 14*u, 20*u + lw_text_width(note, 12*u), y + 5*u });
}

/* ==== the whole =============================================================================================== */

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

static lw_vec2 pixel_of(const sketch *k, int panel, lw_vec2 p)
{
    return lw_view_pixel(&k->d->view[panel], p);
}

static bool clip_line(const lw_box *box, lw_vec2 *a, lw_vec2 *b)
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

static void curve_ink(sketch *k, int panel, lw_shape *s, const lw_curve *c)
{
    s->item = c->tracer;
    s->panel = panel;
    s->stroke = c->outline ? LW_INK_FAINT : c->compared ? LW_INK_RED : LW_INK_BLUE;
    s->width = (c->shown_branch && !c->compared ? 2.6 : 1.6)*k->u;
    s->dashed = !c->shown_branch;
}

/* Draw a curve. Parts far outside the page are cut off, and what would run through the legend and the scale bar. */
static void draw_curve(sketch *k, int panel, const lw_curve *c)
{
    enum { PIECE = 2048 };
    /* A few pages around the picture, so that no number is too large for an output format. */
    const lw_view *v = &k->d->view[panel];
    const lw_box near = { -2*k->d->width, -2*k->d->height, 3*k->d->width, v->y + v->h - foot_height(k, v->w) };
    lw_vec2 piece[PIECE];
    size_t n = 0, n_side = c->n < 2 ? 0 : c->n - (c->closed ? 0 : 1);
    lw_role role = c->shown_branch && !c->compared ? LW_ROLE_CURVE : LW_ROLE_OTHER_CURVE;
    for (size_t i = 0; i < n_side; i++) {
        lw_vec2 a = pixel_of(k, panel, c->p[i]), a0 = a;
        lw_vec2 b = pixel_of(k, panel, c->p[(i + 1) % c->n]);
        bool seen = clip_line(&near, &a, &b);
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

static void draw_curves(sketch *k, int panel)
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
static void draw_stations(sketch *k, int panel)
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
        lw_vec2 at = pixel_of(k, panel, s->station[i]);
        if (!is_near_page(k->d, at))
            continue;
        lw_symbol_station(k->d, LW_ROLE_STATION, (lw_bearer){ (int)i, -1, panel }, at, u);
        lw_label_map_disc(&k->map, at, 5*u, 1.5);
    }
}

/* Write numbers beside the target points: beside each when there are few, else beside some, evenly chosen. */
static void label_stations(sketch *k, int panel)
{
    const lw_scene *s = k->s;
    size_t step = 1 + s->n_station/37;
    const lw_view *v = &k->d->view[panel];
    for (size_t i = 0; i < s->n_station; i += step) {
        char text[24];
        snprintf(text, sizeof text, "%zu", i % stations_each(s) + 1);
        lw_vec2 p = pixel_of(k, panel, s->station[i]), at;
        if (!lw_label_map_place(&k->map, text, 11.5*k->u, p, p, 6*k->u, view_box(v), &at))
            continue;
        lw_shape *t = lw_drawing_text(k->d, LW_ROLE_STATION_LABEL, text, at, 11.5*k->u, 0);
        t->item = (int)i;
        t->panel = panel;
        t->fill = LW_INK_RED;
    }
}

static lw_box view_box(const lw_view *v)
{
    return (lw_box){ v->x + 2, v->y + 2, v->x + v->w - 2, v->y + v->h - 2 };
}

/* Draw the second panel, which shows the path alone, enlarged, with the tracers. Mark its box in the first panel. */
static void draw_path_panel(sketch *k, lw_box path)
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
        lw_vec2 at = pixel_of(k, 1, t->at);
        lw_symbol_tracer(d, (lw_bearer){ i, t->link, 1 }, at, k->u);
    }
    draw_stations(k, 1);
    lw_vec2 a = pixel_of(k, 0, lw_v2(path.x0, path.y1));
    lw_vec2 b = pixel_of(k, 0, lw_v2(path.x1, path.y0));
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
static lw_status make_views(sketch *k, double top, lw_box *path, lw_error *e)
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
    d->view[0] = lw_view_fit(all, 0, top, w0, h0 - foot_height(k, w0), margin);
    d->view[0].h = h0;                                    /* the lower panel holds scale bar and legend */
    if (two) {
        double x = tall ? 8*k->u : w0, y = tall ? top + h0 : top;
        double w1 = w - x - 8*k->u, h1 = d->height - y - 8*k->u;
        d->view[1] = lw_view_fit(*path, x, y + 18*k->u, w1, h1 - foot_height(k, w1) - 18*k->u, margin*0.8);
        d->view[1].y = y;
        d->view[1].h = h1;
    }
    return LW_OK;
}

static void describe(sketch *k)
{
    const lw_scene *s = k->s;
    lw_text_clean(k->d->title, sizeof k->d->title, s->title);
    snprintf(k->d->about, sizeof k->d->about,
             "Planar linkage of %d links and %d joints, %d curve%s, %zu target point%s",
             s->linkage.n_link, s->linkage.n_joint, s->n_curve, lw_plural(s->n_curve),
             s->n_station, lw_plural(s->n_station));
}

static void draw_all(sketch *k, lw_box path)
{
    double u = k->u;
    draw_curves(k, 0);
    k->u *= k->signs;
    sketch_linkage(k);
    k->u = u;
    if (k->d->n_view == 1)
        draw_stations(k, 0);
    else
        draw_path_panel(k, path);
    sketch_feet(k);
    if (k->o->labels) {
        label_linkage(k);
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
    sketch k = { .s = s, .o = o, .d = d };
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
        double top = sketch_header(&k);
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
