/* mbs/plan/dyad_internal.h - the closed forms of the dyads and their derivatives, one posture at a time.
 *
 * The arithmetic has no branches.  It is inlined into the steps of all plans (mbs/plan/steps_internal.h) and into the
 * loops of the most frequent ones (mbs/batch/kernel_fast_dyad.c).  Internal to mbs.
 *
 * Where circles or lines do not meet, the square root of a negative number is replaced by 0 and the direction stays a
 * unit vector: the link points as near to the other as it can.  Where the centres coincide the direction is set along
 * x and the margin is at most 0.
 *
 * Derivatives run backwards.  The adjoint (`bar`) of a number is the derivative of some scalar by it.  A function
 * *_back takes the adjoints of a dyad's outputs and adds to the adjoints of its inputs.  The adjoint of a direction is
 * the one by its angle.  `inv` is the only division that the derivative of a dyad needs; it is 0 where the derivative
 * does not exist. */
#ifndef LW_MBS_PLAN_DYAD_INTERNAL_H
#define LW_MBS_PLAN_DYAD_INTERNAL_H

#include "base/vec2.h"

#define LW_INLINE static inline __attribute__((always_inline))

/* Lengths below this count as 0.  It is small enough for coordinates around 1e-9, and its fourth power does not
 * underflow. */
#define LW_TINY  1e-70
#define LW_TINY2 1e-140
#define LW_MARGIN_LEAST (-1e30)          /* keeps quotients by LW_TINY finite */
/* Below this margin a dyad has no derivatives. */
#define LW_MARGIN_FLAT 1e-30

LW_INLINE double lw_away_from_zero(double a) { return fabs(a) > LW_TINY ? a : LW_TINY; }
LW_INLINE double lw_at_least(double a, double least) { return a > least ? a : least; }
LW_INLINE double lw_at_most(double a, double most) { return a < most ? a : most; }

/* ---- points and lines --------------------------------------------------------------------------- */

/* o + (x + iy) d */
LW_INLINE lw_vec2 lw_frame_point(lw_vec2 o, lw_vec2 d, double x, double y)
{
    return lw_v2_add(o, lw_v2_turn(lw_v2(x, y), d));
}

/* ---- RRR: c = a + r1 u1 = b + r2 u2 ------------------------------------------------------------------
 * With d = |b - a|, the triangle r1, r2, d has (4 area)^2 = h = ((r1 + r2)^2 - d^2)(d^2 - (r1 - r2)^2)
 * (Heron).  Each factor is a difference of given numbers, so that near dead points h is as accurate as d^2.  Then
 *     2 d^2 (c - a) = (b - a) (d^2 + r1^2 - r2^2 + i mode sqrt(h)). */
typedef struct lw_rrr { lw_vec2 span; double d2, p1, p2, y, h, r1, r2; } lw_rrr;

/* The vector from a to b.  Where they coincide it is LW_TINY along x, whose square does not underflow.  The addition
 * changes no other vector with coordinates above 1e-54. */
LW_INLINE lw_vec2 lw_joint_span(lw_vec2 a, lw_vec2 b) { return lw_v2((b.x - a.x) + LW_TINY, b.y - a.y); }

/* met: are the circles known to meet?  It is a constant wherever this function is inlined. */
LW_INLINE lw_rrr lw_rrr_solve_met(lw_vec2 a, lw_vec2 b, double r1, double r2, double mode, const int met)
{
    lw_rrr z;
    z.span = lw_joint_span(a, b);
    z.d2 = lw_v2_dot(z.span, z.span);
    z.r1 = lw_away_from_zero(r1);
    z.r2 = lw_away_from_zero(r2);
    double sum = z.r1 + z.r2, dif = z.r1 - z.r2;
    z.h = (sum*sum - z.d2)*(z.d2 - dif*dif);
    int meet = met || z.h >= 0;
    double q = sqrt(meet ? z.h : 4*z.d2);
    z.y = meet ? mode*q : 0;
    z.p1 = z.d2 + sum*dif;
    z.p2 = z.d2 - sum*dif;
    z.p1 = meet ? z.p1 : copysign(z.r1*q, z.p1);
    z.p2 = meet ? z.p2 : copysign(z.r2*q, z.p2);
    return z;
}

LW_INLINE lw_rrr lw_rrr_solve(lw_vec2 a, lw_vec2 b, double r1, double r2, double mode)
{
    return lw_rrr_solve_met(a, b, r1, r2, mode, 0);
}

/* c - a.  c - b: the caller gives its value where the circles meet.  Each is as long as its link. */
LW_INLINE lw_vec2 lw_rrr_arm(const lw_rrr *z)
{
    return lw_v2_scale(lw_v2_turn(z->span, lw_v2(z->p1, z->y)), 0.5/z->d2);
}

LW_INLINE lw_vec2 lw_rrr_other(const lw_rrr *z, lw_vec2 where_met, const int met)
{
    lw_vec2 apart = lw_v2_scale(lw_v2_turn(z->span, lw_v2(-z->p2, z->y)), 0.5/z->d2);
    int meet = met || z->h >= 0;
    return lw_v2(meet ? where_met.x : apart.x, meet ? where_met.y : apart.y);
}

LW_INLINE lw_vec2 lw_rrr_first(const lw_rrr *z)
{
    return lw_v2_scale(lw_v2_turn(z->span, lw_v2(z->p1, z->y)), 0.5/(z->d2*z->r1));
}

/* sin^2 of the angle between the two links; `flat` is 1/(2 r1 r2)^2. */
LW_INLINE double lw_rrr_flat(double r1, double r2)
{
    double p = lw_away_from_zero(r1)*lw_away_from_zero(r2);
    return 0.25/(p*p);
}

LW_INLINE double lw_rrr_margin(const lw_rrr *z, double flat)
{
    double m = lw_at_least(z->h*flat, LW_MARGIN_LEAST);
    return z->d2 > 2*LW_TINY2 ? m : lw_at_most(m, 0);
}

/* 2 r1 r2 sin(angle) = y, hence with k1 = bar1 2 r2 / y, k2 = bar2 2 r1 / y
 *     d angle1 = (dr2 - dr1 cos - (da - db).u2) 2 r2 / y,
 *     d angle2 = (dr2 cos - dr1 - (da - db).u1) 2 r1 / y.   Returns the adjoint of b; that of a is its negative. */
LW_INLINE lw_vec2 lw_rrr_back(lw_vec2 u1, lw_vec2 u2, double r1, double r2, double inv, double bar1, double bar2,
                              double *r1_bar, double *r2_bar)
{
    double k1 = bar1*(2*r2)*inv, k2 = bar2*(2*r1)*inv, cosine = lw_v2_dot(u1, u2);
    *r1_bar -= k1*cosine + k2;
    *r2_bar += k1 + k2*cosine;
    return lw_v2_add(lw_v2_scale(u2, k1), lw_v2_scale(u1, k2));
}

/* ---- RRP: c = a + r u = q + t w --------------------------------------------------------------------- */
typedef struct lw_rrp { lw_vec2 arm; double y, h, r; } lw_rrp;      /* arm: c - a */

/* In the frame of the line.  `away` is the distance of the line from a, positive if it passes to the left. */
LW_INLINE lw_rrp lw_rrp_solve(double away, double r, double mode)
{
    lw_rrp z;
    z.r = lw_away_from_zero(r);
    z.h = (z.r - away)*(z.r + away);
    int meet = z.h >= 0;
    z.y = mode*sqrt(meet ? z.h : 0);
    z.arm = lw_v2(z.y, meet ? away : copysign(z.r, away));
    return z;
}

LW_INLINE lw_rrp lw_rrp_solve_along(lw_vec2 a, lw_vec2 q, lw_vec2 w, double r, double mode)
{
    lw_rrp z = lw_rrp_solve(lw_v2_cross(w, lw_v2_sub(q, a)), r, mode);
    z.arm = lw_v2_turn(z.arm, w);
    return z;
}

LW_INLINE lw_vec2 lw_rrp_direction(const lw_rrp *z) { return lw_v2_scale(z->arm, 1/z->r); }

LW_INLINE double lw_rrp_margin(const lw_rrp *z) { return lw_at_least(z->h/(z->r*z->r), LW_MARGIN_LEAST); }

/* y d angle = t dw - dr (u.n) - (da - dq).n,  n = i w, t = (c - q).w.
 * Returns the adjoint of q; that of a is its negative. */
LW_INLINE lw_vec2 lw_rrp_back(lw_vec2 u, lw_vec2 w, double t, double inv, double bar, double *r_bar, double *w_bar)
{
    double k = bar*inv;
    lw_vec2 n = lw_v2_perp(w);
    *w_bar += k*t;
    *r_bar -= k*lw_v2_dot(u, n);
    return lw_v2_scale(n, k);
}

/* ---- RPR: b = a + (y + ie) u ------------------------------------------------------------------------ */
typedef struct lw_rpr { lw_vec2 u; double y, h, d2; } lw_rpr;

LW_INLINE lw_rpr lw_rpr_solve(lw_vec2 a, lw_vec2 b, double e, double mode)
{
    lw_rpr z;
    lw_vec2 span = lw_joint_span(a, b);
    z.d2 = lw_v2_dot(span, span);
    z.h = z.d2 - e*e;
    int meet = z.h >= 0;
    double q = sqrt(meet ? z.h : z.d2);
    z.y = meet ? mode*q : 0;
    e = meet ? e : copysign(q, e);
    z.u = lw_v2_scale(lw_v2_unturn(span, lw_v2(z.y, e)), 1/z.d2);
    return z;
}

LW_INLINE double lw_rpr_margin(const lw_rpr *z)
{
    double m = lw_at_least(z->h/z->d2, -1);
    return z->d2 > 2*LW_TINY2 ? m : lw_at_most(m, 0);
}

/* y d angle = (db - da).n - de,  n = i u.  Returns the adjoint of b; that of a is its negative. */
LW_INLINE lw_vec2 lw_rpr_back(lw_vec2 u, double inv, double bar, double *e_bar)
{
    double k = bar*inv;
    *e_bar -= k;
    return lw_v2_scale(lw_v2_perp(u), k);
}

/* ---- PRP, PPR: c = q1 + t1 w1 = q2 + t2 w2 ---------------------------------------------------------- */
typedef struct lw_prp { lw_vec2 c; double t1, sine, inv; } lw_prp;

LW_INLINE lw_prp lw_prp_solve(lw_vec2 q1, lw_vec2 w1, lw_vec2 q2, lw_vec2 w2)
{
    lw_prp z;
    z.sine = lw_v2_cross(w1, w2);
    int cross = fabs(z.sine) > 1e-15;          /* of unit vectors: below, rounding alone decides */
    z.inv = (cross ? 1 : 0)/(cross ? z.sine : 1);
    z.t1 = lw_v2_cross(lw_v2_sub(q2, q1), w2)*z.inv;
    z.c = lw_v2_add(q1, lw_v2_scale(w1, z.t1));
    return z;
}

LW_INLINE double lw_prp_margin(const lw_prp *z) { return z->inv != 0 ? z->sine*z->sine : 0; }

/* sine dt1 = (dq1 - dq2).n2 + t1 cos dw1 - t2 dw2,  n2 = i w2.  Returns the adjoint of q2; that of
 * q1 is the adjoint of c minus it. */
LW_INLINE lw_vec2 lw_prp_back(lw_vec2 w1, lw_vec2 w2, double t1, double t2, double inv, lw_vec2 bar, double *w1_bar, double *w2_bar)
{
    double k = lw_v2_dot(bar, w1)*inv;
    *w1_bar += t1*(lw_v2_dot(bar, lw_v2_perp(w1)) + k*lw_v2_dot(w1, w2));
    *w2_bar -= k*t2;
    return lw_v2_scale(lw_v2_perp(w2), -k);
}

#endif
