/* catalogues/draw/symbols.c - see symbols.h */
#include "catalogues/draw/symbols.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/bytes.h"
#include "catalogues/draw/body_shapes.h"

static lw_shape *bear(lw_shape *s, lw_bearer b)
{
    s->item = b.item;
    s->link = b.link;
    s->panel = b.panel;
    return s;
}

static lw_shape *stroke(lw_shape *s, lw_bearer b, lw_ink ink, double width)
{
    bear(s, b);
    s->stroke = ink;
    s->width = width;
    return s;
}

void lw_symbol_pin(lw_drawing *d, lw_bearer b, lw_vec2 at, double u)
{
    stroke(lw_drawing_circle(d, LW_ROLE_JOINT, at, 5.5*u), b, LW_INK_GROUND, 2*u)->fill = LW_INK_PAPER;
}

/* Draw short strokes on the right side of the line a p, the solid side. */
static void hatch(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, double u)
{
    lw_vec2 line = lw_v2_sub(p, a);
    double length = lw_v2_norm(line), step = 7*u;
    int n = (int)fmin(length/step, 4000);
    if (n < 1)
        return;
    lw_vec2 along = lw_v2_scale(line, 1/length), right = lw_v2_perp(along);  /* y points down: this is the right side */
    lw_vec2 down = lw_v2_add(lw_v2_scale(right, 7*u), lw_v2_scale(along, -6*u));
    for (int i = 0; i < n; i++) {
        lw_vec2 from = lw_v2_add(a, lw_v2_scale(line, (i + 0.75)/n));
        stroke(lw_drawing_line(d, LW_ROLE_HATCH, from, lw_v2_add(from, down)), b, LW_INK_GROUND, 1.2*u);
    }
}

void lw_symbol_hatched_line(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, double u)
{
    stroke(lw_drawing_line(d, LW_ROLE_GUIDE, a, p), b, LW_INK_GROUND, 2*u);
    b.item = -1;
    hatch(d, b, a, p, u);
}

void lw_symbol_pivot(lw_drawing *d, lw_bearer b, lw_vec2 at, double u)
{
    double w = 11*u, h = 19*u, base = 17*u;
    lw_vec2 corner[3] = { at, lw_v2(at.x - w, at.y + h), lw_v2(at.x + w, at.y + h) };
    stroke(lw_drawing_path(d, LW_ROLE_GROUND, corner, 3, true), b, LW_INK_GROUND, 1.8*u)->fill
        = LW_INK_PAPER;
    lw_vec2 left = lw_v2(at.x - base, at.y + h), right = lw_v2(at.x + base, at.y + h);
    b.item = -1;
    stroke(lw_drawing_line(d, LW_ROLE_HATCH, left, right), b, LW_INK_GROUND, 2*u);
    hatch(d, b, left, right, u);
}

void lw_symbol_block(lw_drawing *d, lw_bearer b, lw_vec2 at, lw_vec2 along, lw_ink ink, double u)
{
    lw_vec2 x = lw_v2_scale(along, 17*u), y = lw_v2_scale(lw_v2_perp(along), 10*u);
    lw_vec2 corner[4] = {
        lw_v2_add(at, lw_v2_add(x, y)), lw_v2_add(at, lw_v2_sub(y, x)),
        lw_v2_sub(at, lw_v2_add(x, y)), lw_v2_add(at, lw_v2_sub(x, y)),
    };
    stroke(lw_drawing_path(d, LW_ROLE_SLIDER, corner, 4, true), b, ink, 2.2*u)->fill = LW_INK_PAPER;
}

void lw_symbol_slot(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, lw_ink ink, double u)
{
    enum { HALF = 9 };
    lw_vec2 outline[2*HALF], line = lw_v2_sub(p, a);
    double direction = atan2(line.y, line.x);
    for (int i = 0; i < 2*HALF; i++) {
        double turn = direction + LW_PI/2 + LW_PI*(i % HALF)/(HALF - 1) + (i < HALF ? 0 : LW_PI);
        outline[i] = lw_v2_add(i < HALF ? a : p, lw_v2_polar(8*u, turn));
    }
    stroke(lw_drawing_path(d, LW_ROLE_GUIDE, outline, 2*HALF, true), b, ink, 2*u)->fill = LW_INK_PAPER;
}

/* Draw a filled arrow head with its tip at p, pointing along the unit vector. */
static void head(lw_drawing *d, lw_bearer b, lw_vec2 p, lw_vec2 along, double u)
{
    lw_vec2 back = lw_v2_sub(p, lw_v2_scale(along, 11*u)), side = lw_v2_scale(lw_v2_perp(along), 4.5*u);
    lw_vec2 corner[3] = { p, lw_v2_add(back, side), lw_v2_sub(back, side) };
    bear(lw_drawing_path(d, LW_ROLE_INPUT, corner, 3, true), b)->fill = LW_INK_PURPLE;
}

void lw_symbol_turning(lw_drawing *d, lw_bearer b, lw_vec2 at, double from, bool back, double u)
{
    enum { N = 24 };
    lw_vec2 arc[N];
    const double radius = 27*u, sweep = 1.9;                            /* [rad], with the head */
    double begin = back ? from + sweep : from, sense = back ? -1 : 1;
    for (int i = 0; i < N; i++)
        arc[i] = lw_v2_add(at, lw_v2_polar(radius, -(begin + sense*(sweep - 0.35)*i/(N - 1))));
    stroke(lw_drawing_path(d, LW_ROLE_INPUT, arc, N, false), b, LW_INK_PURPLE, 2.2*u);
    b.item = -1;
    lw_vec2 tip = lw_v2_add(at, lw_v2_polar(radius, -(begin + sense*sweep)));
    lw_vec2 along = lw_v2_sub(tip, arc[N - 1]);
    head(d, b, tip, lw_v2_scale(along, 1/lw_v2_norm(along)), u);
}

void lw_symbol_arrow(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, double u)
{
    lw_vec2 along = lw_v2_sub(p, a);
    along = lw_v2_scale(along, 1/fmax(lw_v2_norm(along), 1e-9));
    stroke(lw_drawing_line(d, LW_ROLE_INPUT, a, lw_v2_sub(p, lw_v2_scale(along, 8*u))), b, LW_INK_PURPLE, 2.2*u);
    b.item = -1;
    head(d, b, p, along, u);
}

void lw_symbol_tracer(lw_drawing *d, lw_bearer b, lw_vec2 at, double u)
{
    stroke(lw_drawing_circle(d, LW_ROLE_TRACER, at, 7*u), b, LW_INK_BLUE, 2.2*u)->fill = LW_INK_PAPER;
    b.item = -1;
    bear(lw_drawing_circle(d, LW_ROLE_TRACER, at, 3*u), b)->fill = LW_INK_BLUE;
}

void lw_symbol_station(lw_drawing *d, lw_role role, lw_bearer b, lw_vec2 at, double u)
{
    double r = 5.2*u;
    lw_vec2 corner[4] = { lw_v2(at.x, at.y - r), lw_v2(at.x + r, at.y), lw_v2(at.x, at.y + r),
                          lw_v2(at.x - r, at.y) };
    lw_shape *s = stroke(lw_drawing_path(d, role, corner, 4, true), b, LW_INK_PAPER, 0.9*u);
    s->fill = LW_INK_RED;
}

void lw_symbol_tube(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 along, double length, lw_ink ink, double u)
{
    lw_vec2 side = lw_v2_scale(lw_v2_perp(along), 8*u), z = lw_v2_add(a, lw_v2_scale(along, length));
    lw_vec2 corner[4] = { lw_v2_add(a, side), lw_v2_add(z, side), lw_v2_sub(z, side), lw_v2_sub(a, side) };
    stroke(lw_drawing_path(d, LW_ROLE_SLIDER, corner, 4, true), b, ink, 2.2*u)->fill = LW_INK_PAPER;
}

void lw_symbol_rod(lw_drawing *d, lw_bearer b, lw_vec2 p, lw_vec2 along, double length, lw_ink ink, double u)
{
    lw_vec2 piston = lw_v2_sub(p, lw_v2_scale(along, length)), side = lw_v2_scale(lw_v2_perp(along), 7*u);
    stroke(lw_drawing_line(d, LW_ROLE_LINK, p, piston), b, ink, 5*u);
    b.item = -1;
    stroke(lw_drawing_line(d, LW_ROLE_SLIDER, lw_v2_add(piston, side), lw_v2_sub(piston, side)), b, ink, 5*u);
}

/* Height of a tooth's flank at its 4 corners, given in pitches from the tooth's middle; half of it outwards, half
 * inwards. */
static const double corner_at[4] = { -0.36, -0.14, 0.14, 0.36 }, corner_out[4] = { -1, 1, 1, -1 };

void lw_symbol_wheel(lw_drawing *d, lw_bearer b, lw_vec2 centre, double radius, int teeth, double at, bool gap,
                     bool ring, lw_ink ink, double u)
{
    enum { MOST = 400 };
    lw_vec2 outline[4*MOST];
    double pitch = 2*LW_PI*radius/fmax(teeth, 1), height = 0.27*pitch;
    if (teeth < 3 || teeth > MOST || pitch < 2.5*u) {
        stroke(lw_drawing_circle(d, LW_ROLE_GUIDE, centre, radius), b, ink, 1.5*u)->dashed = true;
        return;
    }
    for (int i = 0; i < 4*teeth; i++) {
        double turn = at + 2*LW_PI*(i/4 + (gap ? 0.5 : 0) + corner_at[i % 4])/teeth;
        outline[i] = lw_v2_add(centre, lw_v2_polar(radius + height*corner_out[i % 4], turn));
    }
    lw_shape *s = stroke(lw_drawing_path(d, LW_ROLE_GUIDE, outline, (size_t)(4*teeth), true), b, ink, 1.6*u);
    if (!ring) {
        s->fill = ink;
        s->alpha = 0.07;
    }
}

void lw_symbol_rack(lw_drawing *d, lw_bearer b, lw_vec2 p, lw_vec2 along, double lo, double hi, double pitch,
                    bool gap, double body, lw_ink ink, double u)
{
    enum { MOST = 400 };
    lw_vec2 outline[4*MOST + 2], left = lw_v2_perp(along);
    double shift = gap ? 0.5 : 0;
    int first = (int)fmax(floor(lo/pitch - shift), -MOST/2), n = 0;
    int last = (int)fmin(ceil(hi/pitch - shift), MOST/2 - 1);
    for (int i = first; i <= last; i++)
        for (int c = 0; c < 4; c++) {
            lw_vec2 foot = lw_v2_add(p, lw_v2_scale(along, (i + shift + corner_at[c])*pitch));
            outline[n++] = lw_v2_sub(foot, lw_v2_scale(left, 0.27*pitch*corner_out[c]*(body < 0 ? -1 : 1)));
        }
    outline[n] = lw_v2_add(outline[n - 1], lw_v2_scale(left, body));
    n++;
    outline[n] = lw_v2_add(outline[0], lw_v2_scale(left, body));
    n++;
    lw_shape *s = stroke(lw_drawing_path(d, LW_ROLE_GUIDE, outline, (size_t)n, true), b, ink, 1.6*u);
    s->fill = ink;
    s->alpha = 0.07;
}

void lw_symbol_weld(lw_drawing *d, lw_bearer b, lw_vec2 at, lw_vec2 one, lw_vec2 other, lw_ink ink, double u)
{
    if (fabs(lw_v2_cross(one, other)) < 0.2) {
        bear(lw_drawing_circle(d, LW_ROLE_JOINT, at, 5.5*u), b)->fill = ink;
        return;
    }
    lw_vec2 corner[3] = { at, lw_v2_add(at, lw_v2_scale(one, 18*u)), lw_v2_add(at, lw_v2_scale(other, 18*u)) };
    stroke(lw_drawing_path(d, LW_ROLE_JOINT, corner, 3, true), b, ink, 2*u)->fill = ink;
}

void lw_symbol_clamp(lw_drawing *d, lw_bearer b, lw_vec2 at, lw_vec2 leaves, double u)
{
    lw_vec2 half = lw_v2_norm(leaves) > 0 ? lw_v2(-17*u*leaves.y, 17*u*leaves.x) : lw_v2(17*u, 0);
    lw_symbol_hatched_line(d, b, lw_v2_sub(at, half), lw_v2_add(at, half), u);
}

static int left_to_right(const void *a, const void *b)
{
    const lw_vec2 *p = a, *q = b;
    return p->x != q->x ? (p->x > q->x) - (p->x < q->x) : (p->y > q->y) - (p->y < q->y);
}

/* Convex hull, counter-clockwise from the leftmost point (Andrew 1979). Sorts p. */
static int hull(lw_vec2 *p, int n, lw_vec2 *out)
{
    qsort(p, (size_t)n, sizeof *p, left_to_right);
    int m = 0;
    for (int pass = 0, start = 0; pass < 2; pass++, start = m) {
        for (int i = 0; i < n; i++) {
            lw_vec2 q = p[pass ? n - 1 - i : i];
            while (m >= start + 2 && lw_v2_cross(lw_v2_sub(out[m-1], out[m-2]), lw_v2_sub(q, out[m-2])) <= 0)
                m--;
            out[m++] = q;
        }
        m--;                                             /* this point is the first of the other pass */
    }
    return m;
}

static double area(const lw_vec2 *p, int n)
{
    double a = 0;
    for (int i = 0; i < n; i++)
        a += lw_v2_cross(p[i], p[(i + 1) % n])/2;
    return fabs(a);
}

void lw_symbol_frame(lw_drawing *d, lw_bearer b, const lw_vec2 *p, int n, lw_ink ink, double u)
{
    stroke(lw_drawing_path(d, LW_ROLE_LINK, p, (size_t)n, false), b, ink, 5*u);
}

void lw_symbol_link(lw_drawing *d, lw_bearer b, const lw_vec2 *p, int n, lw_ink ink, double u)
{
    lw_vec2 sorted[LW_NODE_MAX], corner[2*LW_NODE_MAX];
    if (n < 2 || n > LW_NODE_MAX)
        return;
    memcpy(sorted, p, (size_t)n*sizeof *p);
    int m = n > 2 ? hull(sorted, n, corner) : 0;
    if (m < 3 || area(corner, m) < 9*u*u) {
        lw_vec2 a = p[0], z = p[1];                      /* all points on one line: from end to end */
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++)
                if (lw_v2_norm(lw_v2_sub(p[i], p[j])) > lw_v2_norm(lw_v2_sub(z, a))) {
                    a = p[j];
                    z = p[i];
                }
        stroke(lw_drawing_line(d, LW_ROLE_LINK, a, z), b, ink, 5*u);
        return;
    }
    lw_shape *s = stroke(lw_drawing_path(d, LW_ROLE_LINK, corner, (size_t)m, true), b, ink, 3.2*u);
    s->fill = ink;
    s->alpha = 0.16;
}

/* The greatest number not above v that is 1, 2 or 5 times a power of ten. */
static double round_down(double v)
{
    double power = pow(10, floor(log10(v))), m = v/power;
    return power*(m >= 5 ? 5 : m >= 2 ? 2 : 1);
}

double lw_symbol_scale_bar(lw_drawing *d, lw_bearer b, lw_vec2 at, double px, double most, const char *unit, const char *remark, double u)
{
    double length = round_down(most/px), w = length*px;
    if (!isfinite(length) || !(length > 0))
        return 0;
    lw_vec2 bar[4] = { { at.x, at.y - 5*u }, at, { at.x + w, at.y }, { at.x + w, at.y - 5*u } };
    stroke(lw_drawing_path(d, LW_ROLE_SCALE, bar, 4, false), b, LW_INK_TEXT, 1.5*u);
    char number[32], text[96];
    lw_number_text(number, length, 3);
    snprintf(text, sizeof text, "%s%s%s%s", number, unit[0] ? " " : "", unit, remark);
    lw_drawing_text(d, LW_ROLE_SCALE, text, lw_v2(at.x + w + 7*u, at.y), 12*u, 0);
    return w + 7*u + lw_text_width(text, 12*u);
}
