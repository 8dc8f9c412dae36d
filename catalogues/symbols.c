/* catalogues/symbols.c - see symbols.h */
#include "catalogues/symbols.h"

#include <stdlib.h>
#include <string.h>

#include "catalogues/anatomy.h"

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

/* Short strokes down to the left from the line a p, whose right side is the solid one. */
static void hatch(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, double u)
{
    lw_vec2 line = lw_v2_sub(p, a);
    double length = lw_v2_norm(line), step = 7*u;
    int n = (int)fmin(length/step, 4000);
    if (n < 1)
        return;
    lw_vec2 along = lw_v2_scale(line, 1/length), right = lw_v2_perp(along);   /* y down: right side */
    lw_vec2 down = lw_v2_add(lw_v2_scale(right, 7*u), lw_v2_scale(along, -6*u));
    for (int i = 0; i < n; i++) {
        lw_vec2 from = lw_v2_add(a, lw_v2_scale(line, (i + 0.75)/n));
        stroke(lw_drawing_line(d, LW_ROLE_HATCH, from, lw_v2_add(from, down)), b, LW_INK_GROUND,
               1.2*u);
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

/* Filled head of an arrow whose point is p and which flies along the unit vector. */
static void head(lw_drawing *d, lw_bearer b, lw_vec2 p, lw_vec2 along, double u)
{
    lw_vec2 back = lw_v2_sub(p, lw_v2_scale(along, 11*u)), side = lw_v2_scale(lw_v2_perp(along), 4.5*u);
    lw_vec2 corner[3] = { p, lw_v2_add(back, side), lw_v2_sub(back, side) };
    bear(lw_drawing_path(d, LW_ROLE_INPUT, corner, 3, true), b)->fill = LW_INK_PURPLE;
}

void lw_symbol_turning(lw_drawing *d, lw_bearer b, lw_vec2 at, double from, double u)
{
    enum { N = 24 };
    lw_vec2 arc[N];
    const double radius = 27*u, sweep = 1.9;                            /* [rad], head included */
    for (int i = 0; i < N; i++)
        arc[i] = lw_v2_add(at, lw_v2_polar(radius, -(from + (sweep - 0.35)*i/(N - 1))));
    stroke(lw_drawing_path(d, LW_ROLE_INPUT, arc, N, false), b, LW_INK_PURPLE, 2.2*u);
    b.item = -1;
    lw_vec2 tip = lw_v2_add(at, lw_v2_polar(radius, -(from + sweep)));
    lw_vec2 along = lw_v2_sub(tip, arc[N - 1]);
    head(d, b, tip, lw_v2_scale(along, 1/lw_v2_norm(along)), u);
}

void lw_symbol_arrow(lw_drawing *d, lw_bearer b, lw_vec2 a, lw_vec2 p, double u)
{
    lw_vec2 along = lw_v2_sub(p, a);
    along = lw_v2_scale(along, 1/fmax(lw_v2_norm(along), 1e-9));
    stroke(lw_drawing_line(d, LW_ROLE_INPUT, a, lw_v2_sub(p, lw_v2_scale(along, 8*u))), b,
           LW_INK_PURPLE, 2.2*u);
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

static int left_to_right(const void *a, const void *b)
{
    const lw_vec2 *p = a, *q = b;
    return p->x != q->x ? (p->x > q->x) - (p->x < q->x) : (p->y > q->y) - (p->y < q->y);
}

/* Convex hull, counter-clockwise from the leftmost point (Andrew 1979).  p is put in order. */
static int hull(lw_vec2 *p, int n, lw_vec2 *out)
{
    qsort(p, (size_t)n, sizeof *p, left_to_right);
    int m = 0;
    for (int pass = 0, start = 0; pass < 2; pass++, start = m) {
        for (int i = 0; i < n; i++) {
            lw_vec2 q = p[pass ? n - 1 - i : i];
            while (m >= start + 2
                   && lw_v2_cross(lw_v2_sub(out[m-1], out[m-2]), lw_v2_sub(q, out[m-2])) <= 0)
                m--;
            out[m++] = q;
        }
        m--;                                             /* the last is the first of the other pass */
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

void lw_symbol_link(lw_drawing *d, lw_bearer b, const lw_vec2 *p, int n, lw_ink ink, double u)
{
    lw_vec2 sorted[LW_NODE_MAX], corner[2*LW_NODE_MAX];
    if (n < 2 || n > LW_NODE_MAX)
        return;
    memcpy(sorted, p, (size_t)n*sizeof *p);
    int m = n > 2 ? hull(sorted, n, corner) : 0;
    if (m < 3 || area(corner, m) < 9*u*u) {
        lw_vec2 a = p[0], z = p[1];                      /* all on a line: from end to end */
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
