/* optimise/precision/exact_track_internal.h - the equations of points of a path and the tracker, for exact_nine.c and
 * tests. */
#ifndef LW_OPTIMISE_PRECISION_EXACT_TRACK_INTERNAL_H
#define LW_OPTIMISE_PRECISION_EXACT_TRACK_INTERNAL_H

#include <stdbool.h>
#include "base/real.h"

/* Complex numbers whose product is four multiplications; C's own product also handles infinities. */
typedef struct lw_cx { double re, im; } lw_cx;

static inline lw_cx cx_add(lw_cx a, lw_cx b)      { return (lw_cx){ a.re + b.re, a.im + b.im }; }
static inline lw_cx cx_sub(lw_cx a, lw_cx b)      { return (lw_cx){ a.re - b.re, a.im - b.im }; }
static inline lw_cx cx_neg(lw_cx a)               { return (lw_cx){ -a.re, -a.im }; }
static inline lw_cx cx_conj(lw_cx a)              { return (lw_cx){ a.re, -a.im }; }
static inline lw_cx cx_scale(lw_cx a, double s)   { return (lw_cx){ a.re*s, a.im*s }; }
static inline double cx_norm1(lw_cx a)            { return fabs(a.re) + fabs(a.im); }
static inline lw_cx cx_mul(lw_cx a, lw_cx b)
{
    return (lw_cx){ a.re*b.re - a.im*b.im, a.re*b.im + a.im*b.re };
}
static inline lw_cx cx_inverse(lw_cx a)
{
    double d = 1/(a.re*a.re + a.im*a.im);
    return (lw_cx){ a.re*d, -a.im*d };
}

/* Eight displacements from the first of nine points, and their conjugates, which are independent variables here. With
 * given pivots only four displacements count, and a a^ b b^ are these. */
typedef struct lw_nine { lw_cx d[8], dh[8]; bool pivots; lw_cx pivot[4]; } lw_nine;

/* The equation of one point at v = (x x^ a a^ y y^ b b^), its derivatives by v, d and d^. */
void lw_nine_equation(const lw_cx *v, lw_cx d, lw_cx dh, lw_cx *f, lw_cx by[8], lw_cx *by_d, lw_cx *by_dh);

/* How a path ends. */
typedef enum lw_track {
    LW_TRACK_ARRIVED,            /* at a regular solution, exact to rounding                        */
    LW_TRACK_SINGULAR,           /* at infinity, or just before the end: at a singular solution there */
    LW_TRACK_LOST                /* on the way                                                      */
} lw_track;

/* Follow the solution v while the points move on straight lines from `from` to `to`.  care: 1, or less for smaller
 * steps and equations in twice the precision.  The steps are added to *steps. */
lw_track lw_nine_track(const lw_nine *from, const lw_nine *to, double care, lw_cx v[8], long *steps);

#endif
