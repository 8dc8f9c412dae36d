/* catalogues/curves/descriptor.h - the shape of a curve as a few numbers, and the distance of two shapes.
 *
 * A curve is traversed at even speed.  A closed curve has Fourier coefficients (Zahn & Roskies 1972; for coupler curves
 * McGarva & Mullineux 1993),
 *     z(s) = c_0 + sum over k of c_k e^{i k s},            terms in the order c_1, c_-1, c_2, c_-2, ...
 * An open curve is traversed there and back, which gives a series of cosines,
 *     z(s) = c_0 + sum over k > 0 of c_k sqrt 2 cos(k s / 2),            terms c_1, c_2, ...
 * Without c_0 the place does not matter.  By Parseval's theorem the mean square of |z - c_0| is the sum of |c_k|^2;
 * dividing it to 1 removes the size.  Four more operations must not matter:
 *     turn by phi             c_k -> e^{i phi} c_k
 *     start later by tau      c_k -> e^{i k tau} c_k               (closed curves only)
 *     other direction         c_k -> c_-k;  open: (-1)^k c_k
 *     mirror in x             c_k -> conj c_-k;  open: conj c_k
 * The distance of two curves is the least root mean square distance of their points over all these operations, in units
 * of the size, computed from the terms kept.  The first two operations do not change |c_k|, hence
 *     sum (|a_k| - |b_k|)^2  <=  distance^2
 * (triangle inequality).  An index of the curves uses this bound. */
#ifndef LW_CATALOGUES_CURVES_DESCRIPTOR_H
#define LW_CATALOGUES_CURVES_DESCRIPTOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "base/status.h"
#include "base/vec2.h"

#define LW_TERMS 16                   /* complex numbers kept                                         */
#define LW_TERM_ONE 32767.0           /* 1 in the packed form                                         */

typedef struct lw_descriptor {
    bool    closed;
    lw_vec2 term[LW_TERMS];           /* [1]                                                          */
    lw_vec2 centre;                   /* c_0, the mean of the points by length                     [m] */
    double  size;                     /* root mean square distance from there                      [m] */
} lw_descriptor;

/* Real and imaginary parts with two bytes for each number. */
typedef struct lw_packed { int16_t re[LW_TERMS], im[LW_TERMS]; } lw_packed;

/* Descriptor of the polygon p (n), which returns to its first point when closed; exact, so that it does not depend on
 * the point where a closed polygon starts.  LW_E_ARG: fewer than two points, a point that is not finite, or all points
 * equal. */
lw_status lw_descriptor_make(const lw_vec2 *p, size_t n, bool closed, lw_descriptor *d);

void lw_descriptor_pack(const lw_descriptor *d, lw_packed *packed);
void lw_descriptor_unpack(const lw_packed *packed, bool closed, lw_descriptor *d);   /* centre 0, size 1 */

/* |c_k| (LW_TERMS), and |c_k| of the curve traversed in the other direction (equal for open curves). */
void lw_packed_size(const lw_packed *p, float size[LW_TERMS]);
void lw_descriptor_sizes(const lw_descriptor *d, float forth[LW_TERMS], float back[LW_TERMS]);

/* How to lay `curve` on `target`, both closed or both open:
 *     target's point ~ centre_t + size_t e^{i turn} (point - centre_c)/size_c,
 * where the point is mirrored in the x axis first if `mirrored`. */
typedef struct lw_match { double distance, turn; bool mirrored; } lw_match;
void lw_descriptor_match(const lw_descriptor *target, const lw_descriptor *curve, lw_match *m);

/* The same for many curves: made once for a target. */
#define LW_MATCHER_STARTS 64
typedef struct lw_matcher {
    lw_descriptor target;
    double square;                               /* sum |a_k|^2                                        */
    float re[LW_TERMS], im[LW_TERMS];
    float c[LW_TERMS/2][LW_MATCHER_STARTS], s[LW_TERMS/2][LW_MATCHER_STARTS];
} lw_matcher;
void  lw_matcher_make(const lw_descriptor *target, lw_matcher *m);
/* Square of the distance [1] where it is at most `limit`; a larger number or INFINITY where it is more. */
double lw_matcher_square(const lw_matcher *m, const lw_packed *curve, double limit);

/* m points on a smooth curve through p (n): centripetal Catmull-Rom splines, which make no loops between unevenly
 * spaced points (Yuksel, Schaefer & Keyser 2011). Repeated points are skipped. */
void lw_curve_smooth(const lw_vec2 *p, size_t n, bool closed, lw_vec2 *out, size_t m);

#endif
