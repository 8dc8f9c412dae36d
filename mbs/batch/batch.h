/* mbs/batch/batch.h - many postures at once, laid out so that one instruction computes eight of them.
 *
 * A lane is one posture.  Arrays over lanes are contiguous.  Dimensions are either one set for all lanes (a linkage
 * over many inputs; dim_stride is 0) or one set a lane (many candidates): dimension d of lane k is dim[d*dim_stride +
 * k]. Modes have mode_stride in the same way.
 *
 * Outputs must not overlap inputs, because some lanes may be computed twice, with the same bits.
 *
 * For a lane that cannot close, the result is the nearest posture that almost closes (the square root of a negative
 * number is replaced by 0), and `margin` is negative.  No result is NaN while lengths and coordinates are below 1e70,
 * so that their fourth power is finite.  Lengths below 1e-70 count as 0.
 *     margin = least over the dyads of  the squared sine of the angle between the two circles or lines at the point
 *              where they meet; negative when they do not meet [1]
 * so sqrt(margin) is the sine of the transmission angle of an RRR dyad; it is 0 at a dead point.
 *
 * Higher groups (mbs/plan/plan.h).  Their margin is n over the squared Frobenius norm of the inverse Jacobian with
 * unit columns, for n unknowns; for a dyad this is the same number.  With mode_stride 0 the lanes are followed from the
 * seed: in their own order when their inputs only rise or only fall (then also over more than a turn), else in the
 * order of the input.  The steps are so short that the Jacobian stays regular over each.  With dim_stride or
 * mode_stride each lane is followed from its own seed.  The continuation ends at limits and at branch points of a
 * group.  A lane beyond gets the last posture before that point, and as margin minus the distance of its input from
 * there [rad, or over lw_plan_size]; the margin is -1 when there is no posture near the seed. */
#ifndef LW_MBS_BATCH_BATCH_H
#define LW_MBS_BATCH_BATCH_H

#include "mbs/plan/plan.h"

typedef struct lw_lanes {
    size_t        n;            /* lanes                                                          */
    const double *c, *s;        /* input: cos, sin in the ground frame; or displacement [m], unused */
    const double *dim;          /* (n_dim) or (n_dim * dim_stride)                                */
    size_t        dim_stride;
    const double *mode;         /* (n_mode), or (n_mode * mode_stride), see mbs/plan/plan.h       */
    size_t        mode_stride;
} lw_lanes;

/* Bytes of scratch for the calls below; they do not depend on n.  Scratch aligned to 64 bytes is fastest. */
size_t lw_batch_work_size(const lw_plan *plan);

/* Compute for every lane the position (x, y) of output `which` [m] and the direction (u, v) of its link as a unit
 * vector, in the plane (moved by x0, y0, theta0).  u and v may both be NULL; margin may be NULL. */
void lw_batch_point(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    double *x, double *y, double *u, double *v, double *margin);

/* The same for the link's ORIGIN and direction in the ground frame of the linkage, not moved by x0, y0, theta0.  A
 * linear fit of place, size and tracer uses them:
 *     P = z0 + a (o + c d),   z0, a, c complex. */
void lw_batch_frame(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    double *ox, double *oy, double *dx, double *dy, double *margin);

/* Compute positions and their exact derivatives, for dim_stride = mode_stride = 0 only.  jx[d*ld + k] is the
 * derivative of x by dim[d] in lane k; jy of y; jt of the angle of the output's link [rad], jm of the margin.  tx, ty,
 * tt, tm: derivatives of x, y, the angle and the margin by the input.  jt, jm, u, v and all t. may be NULL; so may jx,
 * and jy, jt and tt are then not written either; tx and ty alone cost less, with the same bits.  jm is NaN in lanes where a
 * higher group has the least margin.
 *     `which` is an output, or LW_BATCH_JOINT(j): the pin of joint j, which the plan must work out
 * (lw_plan.joint_point).  A pin has no angle: u, v and jt are NULL; its margin is the least of the whole plan. */
#define LW_BATCH_JOINT(j) (-1 - (j))
typedef struct lw_jacobian {
    double *x, *y, *u, *v, *margin, *jx, *jy, *jt, *tx, *ty, *tt;
    size_t  ld;
    double *jm, *tm;
} lw_jacobian;
void lw_batch_jacobian(const lw_plan *plan, const lw_lanes *in, int which, void *work, const lw_jacobian *out);

/* The same for n outputs at once: which[i] goes to out[i].  Higher groups are followed once for all of them. */
void lw_batch_jacobians(const lw_plan *plan, const lw_lanes *in, int n, const int *which, void *work, const lw_jacobian *out);

/* Return f = sum over lanes of w |P - T|^2 (w NULL: 1) and its gradient by every dimension, in one pass, for one set of
 * dimensions.  *margin is the least margin; it may be NULL.  The fits use the Jacobian instead.  The benchmark
 * "3 ns a point with sum of squares and gradient by nine dimensions" measures this function
 * (tests/bench/bench_kernel.c). */
double lw_batch_sum(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    const double *tx, const double *ty, const double *w, double *grad, double *margin);

/* Compute the normal equations of a least-squares step.  Column v of component r is the row over lanes at
 * row[(r*row_step + v)*ld], component r of the residual that at res[r*ld].  The lower triangle of J'J is
 *     h[i*n + j] = sum over components and lanes of column[i] times column[j],  j <= i,
 * and g[i] = J'r is the same sum with the residual.  ld is a multiple of 8; rows are 0 beyond the last lane. */
typedef struct lw_normal {
    int           n, n_row;     /* number of columns, of components                               */
    const int    *column;       /* (n)                                                            */
    const double *row, *res;
    size_t        row_step, ld;
} lw_normal;
void lw_batch_normal(const lw_plan *plan, const lw_normal *in, double *h, double *g);

/* Find the points of a polyline that are nearest to n points x, y; of equally near ones those of the first side.  n is a multiple of 8. */
typedef struct lw_polyline {
    size_t        n;            /* corners, at least 1                                            */
    const double *x, *y;        /* (n)                                                            */
    bool          closed;       /* a side leads from the last corner to the first                 */
} lw_polyline;
void lw_batch_nearest(const lw_plan *plan, const lw_polyline *line, size_t n, const double *x, const double *y, double *near_x,
                      double *near_y);

/* Costs of assigning n points to m samples of a curve, m a power of two and at least 8:
 *     cost[i*(m + 8) + j] = weight[i] factor d^2,
 * d the distance from point i to the piece of a line from sample j - reach tangent to sample j + reach tangent.  `per` is 1 over the square of the
 * tangent, 0 where that is 0.  Columns m to m + 7 are left out. */
typedef struct lw_samples {
    size_t        m;
    const double *x, *y, *tangent_x, *tangent_y, *per;      /* (m)                                */
    double        reach;
} lw_samples;
void lw_batch_costs(const lw_plan *plan, const lw_samples *of, size_t n, const double *x, const double *y, const double *weight,
                    double factor, double *cost);

/* Assign n points to the m samples of a closed curve in their order (sense < 0: in the reverse order), the first point to sample `first`: points
 * may share a sample, and the last is at most m samples after the first.  Costs are those above; columns m to m + 7 repeat the first eight.
 * least[i*(m + 8) + k], k = 0 .. m, becomes the least cost of points 0 to i if none is more than k samples after the first.  Returns the least cost of
 * all; INFINITY as soon as that is at least `enough`. */
double lw_batch_in_order(const lw_plan *plan, size_t n, size_t m, const double *cost, size_t first, int sense, double enough, double *least);

/* Cosines and sines of n angles.  The arrays hold n rounded up to a multiple of 8, do not overlap, and all of their
 * elements may be read or written.  The errors are at most 2 units in the last place of 1. */
void lw_batch_turns(const lw_plan *plan, size_t n, const double *angle, double *c, double *s);

#endif
