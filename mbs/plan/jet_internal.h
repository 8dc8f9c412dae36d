/* mbs/plan/jet_internal.h - truncated Taylor arithmetic: a number is its Taylor coefficients in the input, and every
 * operation is that on the coefficients (Griewank & Walther 2008, ch. 13).  Derivatives are exact to rounding.
 * Internal to mbs. */
#ifndef LW_MBS_PLAN_JET_INTERNAL_H
#define LW_MBS_PLAN_JET_INTERNAL_H

#include "base/vec2.h"
#include "mbs/plan/plan.h"

#define LW_JET (LW_ORDER_MAX + 1)
typedef struct lw_jet { double c[LW_JET]; } lw_jet;
typedef struct lw_jet2 { lw_jet x, y; } lw_jet2;

static inline lw_jet lw_jet_constant(double a) { return (lw_jet){ { a } }; }

static inline lw_jet lw_jet_add(lw_jet a, lw_jet b)
{
    for (int i = 0; i < LW_JET; i++)
        a.c[i] += b.c[i];
    return a;
}

static inline lw_jet lw_jet_scale(lw_jet a, double s)
{
    for (int i = 0; i < LW_JET; i++)
        a.c[i] *= s;
    return a;
}

static inline lw_jet lw_jet_sub(lw_jet a, lw_jet b) { return lw_jet_add(a, lw_jet_scale(b, -1)); }

static inline lw_jet lw_jet_mul(lw_jet a, lw_jet b)
{
    lw_jet p = { { 0 } };
    for (int i = 0; i < LW_JET; i++)
        for (int j = 0; j <= i; j++)
            p.c[i] += a.c[j]*b.c[i - j];
    return p;
}

static inline lw_jet lw_jet_divide(lw_jet a, lw_jet b)
{
    for (int i = 0; i < LW_JET; i++) {
        for (int j = 0; j < i; j++)
            a.c[i] -= a.c[j]*b.c[i - j];
        a.c[i] /= b.c[0];
    }
    return a;
}

static inline lw_jet lw_jet_root(lw_jet a)
{
    lw_jet r = { { sqrt(a.c[0]) } };
    for (int i = 1; i < LW_JET; i++) {
        double rest = a.c[i];
        for (int j = 1; j < i; j++)
            rest -= r.c[j]*r.c[i - j];
        r.c[i] = rest/(2*r.c[0]);
    }
    return r;
}

static inline lw_jet2 lw_jet2_of(lw_jet x, lw_jet y) { return (lw_jet2){ x, y }; }
static inline lw_jet2 lw_jet2_constant(double x, double y)
{
    return lw_jet2_of(lw_jet_constant(x), lw_jet_constant(y));
}
static inline lw_jet2 lw_jet2_add(lw_jet2 a, lw_jet2 b)
{
    return lw_jet2_of(lw_jet_add(a.x, b.x), lw_jet_add(a.y, b.y));
}
static inline lw_jet2 lw_jet2_sub(lw_jet2 a, lw_jet2 b)
{
    return lw_jet2_of(lw_jet_sub(a.x, b.x), lw_jet_sub(a.y, b.y));
}
static inline lw_jet2 lw_jet2_scale(lw_jet2 a, lw_jet s) { return lw_jet2_of(lw_jet_mul(a.x, s), lw_jet_mul(a.y, s)); }
static inline lw_jet2 lw_jet2_conjugate(lw_jet2 a) { return lw_jet2_of(a.x, lw_jet_scale(a.y, -1)); }
static inline lw_jet lw_jet2_cross(lw_jet2 a, lw_jet2 b)
{
    return lw_jet_sub(lw_jet_mul(a.x, b.y), lw_jet_mul(a.y, b.x));
}
static inline lw_jet lw_jet2_dot(lw_jet2 a, lw_jet2 b)
{
    return lw_jet_add(lw_jet_mul(a.x, b.x), lw_jet_mul(a.y, b.y));
}
static inline lw_jet2 lw_jet2_turn(lw_jet2 a, lw_jet2 u)
{
    return lw_jet2_of(lw_jet_sub(lw_jet_mul(a.x, u.x), lw_jet_mul(a.y, u.y)), lw_jet_add(lw_jet_mul(a.x, u.y), lw_jet_mul(a.y, u.x)));
}
static inline lw_jet2 lw_jet2_point(lw_jet2 o, lw_jet2 d, double x, double y)
{
    return lw_jet2_add(o, lw_jet2_turn(lw_jet2_constant(x, y), d));
}

/* The angle of a direction u, given its value: u' = i angle' u for a unit vector u. */
static inline lw_jet lw_jet_angle(const lw_jet2 *u, double first)
{
    lw_jet a = lw_jet_constant(first);
    for (int m = 1; m < LW_JET; m++)
        for (int l = 1; l <= m; l++)
            a.c[m] += l*(u->x.c[m - l]*u->y.c[l] - u->y.c[m - l]*u->x.c[l])/m;
    return a;
}

/* The direction of an angle. */
static inline lw_jet2 lw_jet_polar(lw_jet a)
{
    lw_jet2 u = lw_jet2_constant(cos(a.c[0]), sin(a.c[0]));
    for (int m = 1; m < LW_JET; m++)
        for (int l = 1; l <= m; l++) {
            u.x.c[m] -= l*a.c[l]*u.y.c[m - l]/m;
            u.y.c[m] += l*a.c[l]*u.x.c[m - l]/m;
        }
    return u;
}

#endif
