/* base/vec2.h - points and vectors of the plane.  Multiplication by a unit vector rotates, as with complex
 * numbers; most of planar kinematics consists of it. */
#ifndef LW_BASE_VEC2_H
#define LW_BASE_VEC2_H

#include "base/real.h"
#include "linkwright.h"     /* lw_vec2 */

#define LW_PI 3.14159265358979323846

static inline lw_vec2 lw_v2(double x, double y) { return (lw_vec2){ x, y }; }
static inline lw_vec2 lw_v2_add(lw_vec2 a, lw_vec2 b) { return lw_v2(a.x + b.x, a.y + b.y); }
static inline lw_vec2 lw_v2_sub(lw_vec2 a, lw_vec2 b) { return lw_v2(a.x - b.x, a.y - b.y); }
static inline lw_vec2 lw_v2_scale(lw_vec2 a, double s) { return lw_v2(s*a.x, s*a.y); }
static inline double  lw_v2_dot(lw_vec2 a, lw_vec2 b) { return a.x*b.x + a.y*b.y; }
static inline double  lw_v2_cross(lw_vec2 a, lw_vec2 b) { return a.x*b.y - a.y*b.x; }
static inline double  lw_v2_norm(lw_vec2 a) { return hypot(a.x, a.y); }
static inline lw_vec2 lw_v2_perp(lw_vec2 a) { return lw_v2(-a.y, a.x); }            /* i a      */
static inline lw_vec2 lw_v2_polar(double r, double t) { return lw_v2(r*cos(t), r*sin(t)); }
/* complex product: rotate a by the angle of the unit vector u (and scale by |u|) */
static inline lw_vec2 lw_v2_turn(lw_vec2 a, lw_vec2 u)
{
    return lw_v2(a.x*u.x - a.y*u.y, a.x*u.y + a.y*u.x);
}
/* a times the conjugate of u: the coordinates of a in the frame whose x axis is u */
static inline lw_vec2 lw_v2_unturn(lw_vec2 a, lw_vec2 u)
{
    return lw_v2(a.x*u.x + a.y*u.y, a.y*u.x - a.x*u.y);
}

/* Vector from the nearest point of the segment a b (which may be a single point) to p; and its length. */
static inline lw_vec2 lw_v2_off_segment(lw_vec2 p, lw_vec2 a, lw_vec2 b)
{
    lw_vec2 d = lw_v2_sub(b, a), q = lw_v2_sub(p, a);
    double d2 = lw_v2_dot(d, d), t = d2 > 0 ? lw_v2_dot(q, d)/d2 : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return lw_v2_sub(q, lw_v2_scale(d, t));
}

static inline double lw_v2_segment_distance(lw_vec2 p, lw_vec2 a, lw_vec2 b)
{
    return lw_v2_norm(lw_v2_off_segment(p, a, b));
}

/* The distance from p to the segment a b, or `least` if that is smaller: most segments of a long line are told by squares,
 * without a root. */
static inline double lw_v2_nearer(lw_vec2 p, lw_vec2 a, lw_vec2 b, double least)
{
    lw_vec2 off = lw_v2_off_segment(p, a, b);
    return lw_v2_dot(off, off) > (1 + 1e-12)*least*least ? least : fmin(least, lw_v2_norm(off));
}

#endif
