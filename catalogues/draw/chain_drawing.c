/* catalogues/draw/chain_drawing.c - see chain_drawing.h */
#include "catalogues/draw/chain_drawing.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

#include "base/real.h"
#include "catalogues/draw/symbols.h"

#define SIGN      (1/72.0)   /* size of signs (u of symbols.h) per length of a bar */
#define SIGN_MOST 1.3        /* upper limit of that size [px]                      */
#define SIGN_LEAST 0.42      /* lower limit: pins of 2.3 px                        */
#define MULTIPLE  1.6        /* size of the outer circle of a multiple joint [pins] */
#define CAPTION   12.0       /* size of the caption [px]                           */
#define LETTER    13.0       /* size of the number of a link [u]                   */

typedef struct sketch {
    const lw_mechanism    *m;
    const lw_chain_layout *l;
    lw_drawing *d;
    double      scale, u;                       /* [px] per bar; size of signs [px] */
    lw_vec2     middle, centre;                 /* centre of the layout; its place [px] */
} sketch;

static lw_vec2 pixel(const sketch *k, lw_vec2 p)
{
    return lw_v2(k->centre.x + k->scale*(p.x - k->middle.x), k->centre.y - k->scale*(p.y - k->middle.y));
}

static int outline(const sketch *k, int link, lw_vec2 *p)
{
    const lw_chain_layout *l = k->l;
    int n = 0;
    for (int i = l->first[link]; i < l->first[link + 1]; i++)
        p[n++] = pixel(k, l->at[l->ring[i]]);
    if (n == 1 && link != k->m->ground)
        p[n++] = pixel(k, l->end[link]);
    return n;
}

static bool on_ground(const lw_mechanism *m, int joint)
{
    return m->ground != LW_NONE && (m->link[joint][0] == m->ground || m->link[joint][1] == m->ground);
}

static bool is_driven(const lw_mechanism *m, int joint)
{
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i] == joint)
            return true;
    return false;
}

/* The link that a driven joint moves, relative to its other link. */
static int driven_link(const lw_mechanism *m, int joint)
{
    return m->link[joint][m->link[joint][0] == m->ground || m->ground == LW_NONE ? 1 : 0];
}

static lw_ink ink_of(const lw_mechanism *m, int link)
{
    for (int i = 0; i < m->n_input; i++)
        if (driven_link(m, m->input[i]) == link)
            return LW_INK_PURPLE;
    return link == m->output ? LW_INK_GREEN : LW_INK_LINK;
}

/* ---- fitting into a box ------------------------------------------------------------------------- */

/* Space that signs need around a joint, in u: left and right, up, down. */
static void room_of(const lw_mechanism *m, int joint, double *side, double *up, double *down)
{
    bool ground = on_ground(m, joint);
    *side = *up = *down = is_driven(m, joint) ? 34 : lw_joint_turns(m->kind[joint]) ? 8 : 42;
    if (ground) {
        *side = fmax(*side, 26);
        *down = fmax(*down, 30);
    }
}

typedef struct extent { double left, right, low, top; } extent;

static void include(extent *x, lw_vec2 p, double side, double up, double down)
{
    x->left = fmin(x->left, p.x - side);
    x->right = fmax(x->right, p.x + side);
    x->low = fmin(x->low, p.y - down);
    x->top = fmax(x->top, p.y + up);
}

/* Extent of the picture when signs have the size `sign` per length of a bar. */
static extent cover(const sketch *k, double sign)
{
    extent x = { 1e9, -1e9, 1e9, -1e9 };
    double side, up, down;
    for (int j = 0; j < k->l->n_joint; j++) {
        room_of(k->m, j, &side, &up, &down);
        include(&x, k->l->at[j], sign*side, sign*up, sign*down);
    }
    for (int i = 0; i < k->m->n_link; i++)
        include(&x, k->l->end[i], 8*sign, 8*sign, 8*sign);
    return x;
}

/* Find scale and size of signs. Signs have a least size and so take more of a small box: iterate. */
static void fit(sketch *k, lw_box box)
{
    double w = box.x1 - box.x0, h = box.y1 - box.y0, sign = SIGN;
    extent x = { 0, 0, 0, 0 };
    for (int round = 0; round < 6; round++) {
        x = cover(k, sign);
        k->scale = fmin(fmin(w/(x.right - x.left), h/(x.top - x.low)), fmin(w, h)/3);
        sign = fmax(sign, fmin(SIGN_LEAST/k->scale, 3*SIGN));
    }
    k->u = fmin(k->scale*sign, SIGN_MOST);
    k->middle = lw_v2((x.left + x.right)/2, (x.low + x.top)/2);
    k->centre = lw_v2((box.x0 + box.x1)/2, (box.y0 + box.y1)/2);
}

/* ---- links -------------------------------------------------------------------------------------- */

static void draw_link(sketch *k, int link)
{
    lw_vec2 p[LW_LINK_MAX + 1];
    int n = outline(k, link, p);
    if (link == k->m->ground || n < 2 || k->l->axes >> link & 1)
        return;
    lw_ink ink = ink_of(k->m, link);
    lw_shape *s = lw_drawing_path(k->d, LW_ROLE_LINK, p, (size_t)n, n > 2);
    s->item = link;
    s->stroke = ink;
    s->width = (n > 2 ? 3.2 : 4.4)*k->u;
    if (n > 2) {
        s->fill = ink;
        s->alpha = 0.16;
    }
}

/* Where links cross, the one drawn later passes above: a gap in the paper's colour interrupts the other one. */
static void draw_bridges(sketch *k, int above, int below)
{
    lw_vec2 p[LW_LINK_MAX + 1], q[LW_LINK_MAX + 1];
    int n = outline(k, above, p), m = outline(k, below, q);
    for (int i = 0; i < (n > 2 ? n : n - 1); i++)
        for (int j = 0; j < (m > 2 ? m : m - 1); j++) {
            lw_vec2 a = p[i], u = lw_v2_sub(p[(i + 1) % n], a), b = q[j], v = lw_v2_sub(q[(j + 1) % m], b);
            lw_vec2 d = lw_v2_sub(b, a);
            double turn = lw_v2_cross(u, v), s = lw_v2_cross(d, v)/turn, t = lw_v2_cross(d, u)/turn;
            if (!(s > 1e-6 && s < 1 - 1e-6 && t > 1e-6 && t < 1 - 1e-6))
                continue;
            lw_vec2 at = lw_v2_add(a, lw_v2_scale(u, s)), reach = lw_v2_scale(u, 7*k->u/lw_v2_norm(u));
            lw_shape *gap = lw_drawing_line(k->d, LW_ROLE_GUIDE, lw_v2_sub(at, reach), lw_v2_add(at, reach));
            gap->stroke = LW_INK_PAPER;
            gap->width = 12*k->u;
        }
}

/* Draw polygons first and bars above them. */
static void draw_links(sketch *k)
{
    int order[LW_LINK_MAX], n = 0;
    for (int bars = 0; bars < 2; bars++)
        for (int i = 0; i < k->m->n_link; i++)
            if ((k->l->first[i + 1] - k->l->first[i] < 3) == bars && i != k->m->ground && !(k->l->axes >> i & 1))
                order[n++] = i;
    for (int i = 0; i < n; i++) {
        for (int below = 0; k->l->n_cross > 0 && below < i; below++)
            draw_bridges(k, order[i], order[below]);
        draw_link(k, order[i]);
    }
}

/* Direction in which a link leaves a joint: along a bar, else along the outline. */
static lw_vec2 direction_of(const sketch *k, int link, int joint)
{
    lw_vec2 p[LW_LINK_MAX + 1], at = pixel(k, k->l->at[joint]), best = { 1, 0 };
    int n = outline(k, link, p);
    double most = 1e-6;
    if (link == k->m->ground)
        return best;
    for (int i = 0; i < n; i++) {
        lw_vec2 d = lw_v2_sub(p[i], at);
        if (lw_v2_norm(d) > most) {
            most = lw_v2_norm(d);
            best = lw_v2_scale(d, 1/most);
        }
    }
    return best;
}

/* Is the link drawn as a block only, with its two joints at one place? */
static bool is_block(const sketch *k, int link)
{
    const lw_chain_layout *l = k->l;
    if (l->first[link + 1] - l->first[link] != 2)
        return false;
    lw_vec2 a = l->at[l->ring[l->first[link]]], b = l->at[l->ring[l->first[link] + 1]];
    return a.x == b.x && a.y == b.y;
}

/* The link that carries the rail of a slider: the frame, else the link that is not the block, else the first one. */
static int rail_side(const sketch *k, int joint)
{
    const uint8_t *link = k->m->link[joint];
    if (link[0] == k->m->ground || link[1] == k->m->ground)
        return link[1] == k->m->ground;
    return is_block(k, link[0]) ? 1 : 0;
}

/* ---- joints ------------------------------------------------------------------------------------- */

static void draw_slider(sketch *k, int joint)
{
    int side = rail_side(k, joint), rail = k->m->link[joint][side], block = k->m->link[joint][1 - side];
    lw_vec2 at = pixel(k, k->l->at[joint]), along = direction_of(k, rail, joint);
    lw_vec2 reach = lw_v2_scale(along, 36*k->u), down = lw_v2(0, 10*k->u);
    lw_bearer b = { joint, -1, -1 };
    if (rail == k->m->ground) {
        lw_symbol_hatched_line(k->d, b, lw_v2_add(lw_v2_sub(at, reach), down), lw_v2_add(lw_v2_add(at, reach), down), k->u);
    } else {
        lw_shape *s = lw_drawing_line(k->d, LW_ROLE_GUIDE, lw_v2_sub(at, reach), lw_v2_add(at, reach));
        s->item = joint;
        s->stroke = ink_of(k->m, rail);
        s->width = 4.4*k->u;
    }
    lw_symbol_block(k->d, b, at, along, ink_of(k->m, block), k->u);
}

static void draw_slot(sketch *k, int joint)
{
    lw_vec2 at = pixel(k, k->l->at[joint]);
    int side = k->m->link[joint][1] == k->m->ground;
    int link = k->m->link[joint][side];
    lw_vec2 reach = lw_v2_scale(direction_of(k, link, joint), 15*k->u);
    lw_bearer b = { joint, -1, -1 };
    if (link == k->m->ground)
        lw_symbol_hatched_line(k->d, b, lw_v2(at.x - 25*k->u, at.y + 8*k->u), lw_v2(at.x + 25*k->u, at.y + 8*k->u), k->u);
    lw_symbol_slot(k->d, b, lw_v2_sub(at, reach), lw_v2_add(at, reach), ink_of(k->m, link), k->u);
    lw_symbol_pin(k->d, b, at, k->u);
}

/* Draw two pitch circles that touch at the joint, one on the side of each link. */
static void draw_contact(sketch *k, int joint)
{
    lw_vec2 at = pixel(k, k->l->at[joint]);
    const uint8_t *link = k->m->link[joint];
    lw_vec2 a = direction_of(k, link[0], joint), b = direction_of(k, link[1], joint);
    bool ground = on_ground(k->m, joint);
    lw_vec2 apart = ground ? lw_v2(0, link[0] == k->m->ground ? -1 : 1) : lw_v2_sub(b, a);
    double norm = lw_v2_norm(apart), radius = 8*k->u;
    apart = norm > 1e-6 ? lw_v2_scale(apart, radius/norm) : lw_v2(0, radius);
    for (int side = 0; side < 2; side++) {
        lw_vec2 c = side ? lw_v2_add(at, apart) : lw_v2_sub(at, apart);
        if (link[side] == k->m->ground) {
            lw_symbol_hatched_line(k->d, (lw_bearer){ joint, -1, -1 }, lw_v2(at.x - 20*k->u, at.y),
                                   lw_v2(at.x + 20*k->u, at.y), k->u);
            continue;
        }
        lw_shape *s = lw_drawing_circle(k->d, LW_ROLE_JOINT, c, radius);
        s->item = joint;
        s->stroke = ink_of(k->m, link[side]);
        s->width = 2*k->u;
        s->fill = LW_INK_PAPER;
    }
}

/* A pin with more than two links is two circles, one in the other. */
static void draw_pin(sketch *k, int joint)
{
    const uint8_t *link = k->m->link[joint], *ring = k->l->ring;
    lw_bearer b = { joint, -1, -1 };
    lw_vec2 at = pixel(k, k->l->at[joint]);
    int axis = k->l->axes >> link[0] & 1 ? link[0] : k->l->axes >> link[1] & 1 ? link[1] : -1;
    if (axis < 0 || ring[k->l->first[axis]] == joint)
        lw_symbol_pin(k->d, b, at, axis < 0 ? k->u : MULTIPLE*k->u);
    if (axis >= 0 && ring[k->l->first[axis]] == joint)
        lw_symbol_pin(k->d, b, at, 0.8*k->u);
}

static void draw_joint(sketch *k, int joint)
{
    switch ((lw_joint_kind)k->m->kind[joint]) {
    case LW_JOINT_SLIDER:   draw_slider(k, joint); break;
    case LW_JOINT_SLOT:     draw_slot(k, joint); break;
    case LW_JOINT_GEAR:     draw_contact(k, joint); break;
    case LW_JOINT_REVOLUTE: draw_pin(k, joint); break;
    case LW_JOINT_FIXED: case LW_JOINT_FREE: assert(!"no chain has welds or free links");
    }
}

static void draw_input(sketch *k, int input)
{
    int joint = k->m->input[input], link = driven_link(k->m, joint);
    lw_vec2 at = pixel(k, k->l->at[joint]), along = direction_of(k, link, joint);
    lw_bearer b = { joint, -1, -1 };
    if (lw_joint_turns(k->m->kind[joint])) {
        /* start the arrow at the link, or end it there if that side is further above the frame */
        double link_at = atan2(-along.y, along.x);
        bool below = on_ground(k->m, joint) && fmin(sin(link_at + 0.4), sin(link_at + 2.3))
                                               < fmin(sin(link_at - 2.3), sin(link_at - 0.4));
        lw_symbol_turning(k->d, b, at, link_at + (below ? -2.3 : 0.4), false, k->u);
        return;
    }
    along = direction_of(k, k->m->link[joint][rail_side(k, joint)], joint);
    lw_vec2 from = lw_v2_add(at, lw_v2_scale(lw_v2_perp(along), (along.x < 0 ? 1 : -1)*20*k->u));
    lw_symbol_arrow(k->d, b, lw_v2_sub(from, lw_v2_scale(along, 20*k->u)), lw_v2_add(from, lw_v2_scale(along, 24*k->u)), k->u);
}

/* ---- numbers ------------------------------------------------------------------------------------ */

/* Free distance around a place, from the sides of all links and from joints. */
static double clearance(const sketch *k, lw_vec2 at)
{
    double least = 1e9;
    for (int i = 0; i < k->m->n_link; i++) {
        lw_vec2 p[LW_LINK_MAX + 1];
        int n = outline(k, i, p);
        for (int s = 0; i != k->m->ground && !(k->l->axes >> i & 1) && s < (n > 2 ? n : n - 1); s++)
            least = fmin(least, lw_v2_segment_distance(at, p[s], p[(s + 1) % n]));
    }
    return least;
}

/* Place for a number: beside the middle of a bar or a little off it, on either side, where most space is free. */
static lw_vec2 beside_bar(const sketch *k, lw_vec2 a, lw_vec2 b)
{
    lw_vec2 d = lw_v2_sub(b, a), best = a;
    double length = lw_v2_norm(d), most = -1;
    int ground = k->m->ground;
    bool on_line = ground != LW_NONE && a.y >= pixel(k, k->l->at[k->l->ring[k->l->first[ground]]]).y - 1e-6;
    for (int i = 0; length <= 1e-6 && i < 8; i++) {                                       /* a block */
        lw_vec2 at = lw_v2_add(a, lw_v2_polar(25*k->u, (2*i + 3)*LW_PI/8));
        if (clearance(k, at) > most + 0.1*k->u && !(on_line && at.y > a.y - 5*k->u)) {
            most = clearance(k, at);
            best = at;
        }
    }
    for (int i = 0; length > 1e-6 && i < 6; i++) {
        static const double part[] = { 0.5, 0.36, 0.64 };
        lw_vec2 off = lw_v2_scale(lw_v2_perp(d), (i % 2 ? 11 : -11)*k->u/length);
        lw_vec2 at = lw_v2_add(lw_v2_add(a, lw_v2_scale(d, part[i/2])), off);
        double free = fmin(clearance(k, at), 10.5*k->u) + 0.02*clearance(k, lw_v2_add(at, off));
        if (free > most + 0.1*k->u) {
            most = free;
            best = at;
        }
    }
    return best;
}

static void draw_number(sketch *k, int link)
{
    lw_vec2 p[LW_LINK_MAX + 1], at = { 0, 0 };
    int n = outline(k, link, p);
    char text[12];
    for (int i = 0; i < n; i++)
        at = lw_v2_add(at, lw_v2_scale(p[i], 1.0/n));
    if (link == k->m->ground) {
        bool pin = lw_joint_turns(k->m->kind[k->l->ring[k->l->first[link]]]);
        at = lw_v2(p[0].x - (pin ? 25 : 46)*k->u, p[0].y + 12*k->u);
    } else if (n == 2) {
        at = beside_bar(k, p[0], p[1]);
    }
    snprintf(text, sizeof text, "%d", link + 1);
    double size = fmax(LETTER*k->u, 6);
    lw_shape *s = lw_drawing_text(k->d, LW_ROLE_NOTE, text, lw_v2(at.x, at.y + 0.36*size), size, 0.5);
    s->item = link;
    s->fill = LW_INK_BLUE;
}

/* ---- all together ------------------------------------------------------------------------------- */

void lw_chain_draw_into(const lw_mechanism *m, const lw_chain_layout *l, lw_box box, bool numbers, lw_drawing *d)
{
    sketch k = { .m = m, .l = l, .d = d };
    fit(&k, box);
    for (int j = 0; j < m->n_joint; j++)
        if (lw_joint_turns(m->kind[j]) && on_ground(m, j))
            lw_symbol_pivot(d, (lw_bearer){ j, -1, -1 }, pixel(&k, l->at[j]), k.u);
    draw_links(&k);
    for (int pins = 0; pins < 2; pins++)                     /* draw pins above the blocks they stand on */
        for (int j = 0; j < m->n_joint; j++)
            if (lw_joint_turns(m->kind[j]) == pins)
                draw_joint(&k, j);
    for (int i = 0; i < m->n_input; i++)
        draw_input(&k, i);
    for (int i = 0; numbers && i < m->n_link; i++)
        if (!(l->axes >> i & 1))
            draw_number(&k, i);
}

lw_status lw_chain_draw(const lw_mechanism *m, const lw_chain_layout *l, const lw_chain_style *s, lw_drawing *d, lw_error *e)
{
    int n_axis = __builtin_popcount(l->axes);
    *d = (lw_drawing){ .width = s->width, .height = s->height };
    if (!(s->width >= 32 && s->width <= 8192 && s->height >= 32 && s->height <= 8192))
        return lw_error_set(e, LW_E_ARG, "a picture is 32 to 8192 px wide and high");
    double edge = 0.04*fmin(s->width, s->height), below = s->caption ? 1.6*CAPTION : 0;
    lw_box box = { edge, edge, s->width - edge, s->height - edge - below };
    lw_vec2 corner[4] = { { 0, 0 }, { s->width, 0 }, { s->width, s->height }, { 0, s->height } };
    lw_drawing_path(d, LW_ROLE_PAPER, corner, 4, true)->fill = LW_INK_PAPER;
    lw_chain_draw_into(m, l, box, s->numbers, d);
    if (s->caption)
        lw_drawing_text(d, LW_ROLE_TITLE, s->caption, lw_v2(s->width/2, s->height - 0.6*CAPTION), CAPTION, 0.5);
    lw_text_clean(d->title, sizeof d->title, s->caption ? s->caption : "Kinematic chain");
    snprintf(d->about, sizeof d->about, "%s of %d links and %d joints", m->ground == LW_NONE ? "Chain" : "Mechanism",
             m->n_link - n_axis, m->n_joint - n_axis);
    return lw_drawing_end(d, e);
}
