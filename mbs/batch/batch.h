/* mbs/batch/batch.h - many poses at once, laid out so that one instruction serves eight of them.
 *
 * A lane is one pose.  Arrays over lanes are contiguous.  Dimensions are either one set for all
 * lanes (a linkage over many inputs) or one set a lane (many candidates): `dim_stride` is 0 or the
 * distance between dim[d] of lane k and dim[d+1] of lane k, dim[d*dim_stride + k].  Modes likewise.
 *
 * Outputs must not overlap inputs: some lanes may be worked out twice, with the same bits.
 *
 * Lanes that cannot close are answered by the nearest pose that nearly closes (square root of a
 * negative number taken as 0) and tell so in `margin`; no NaN as long as lengths and coordinates lie
 * below 1e70 (their fourth power must be a number); below 1e-70 they count as 0.
 *     margin = least over the dyads of  the squared sine of the angle at which its two circles or
 *              lines meet at the solution, negative when they do not meet [1]
 * so sqrt(margin) is the sine of the transmission angle of an RRR dyad, 0 at a dead point.
 *
 * Higher groups (mbs/plan/plan.h).  Their margin is n over the squared Frobenius norm of the inverse Jacobian with
 * unit columns, n unknowns: of a dyad it is the same number.  With mode_stride 0 the lanes are followed from
 * the seed, in their order when their inputs rise or fall (then also over more than a turn), else in the order
 * of the input; steps in between are as short as it takes for the Jacobian to stay regular over each.  With
 * dim_stride or mode_stride each lane is followed from its own seed.  A lane that is not reached has the last
 * posture on the way and the margin minus how far its input lies beyond [rad, or over lw_plan_size]; -1 when
 * there is no posture near the seed.  The way ends at limits and at branch points of a group. */
#ifndef LW_MBS_BATCH_BATCH_H
#define LW_MBS_BATCH_BATCH_H

#include "mbs/plan/plan.h"

typedef struct lw_lanes {
    size_t        n;            /* lanes                                                          */
    const double *c, *s;        /* input: cos, sin in the ground frame; or displacement [m], unused */
    const double *dim;          /* (n_dim) or (n_dim * dim_stride)                                */
    size_t        dim_stride;
    const double *mode;         /* (n_mode), or (n_mode * mode_stride), see mbs/plan/plan.h            */
    size_t        mode_stride;
} lw_lanes;

/* Bytes of scratch for the calls below, whatever n; 64-byte aligned scratch is fastest. */
size_t lw_batch_work_size(const lw_plan *plan);

/* Positions of output `which` [m] (and direction of its link as unit vector, when u, v are given) of
 * every lane, in the plane (x0, y0, theta0 applied).  u and v may be NULL, both; margin may be NULL. */
void lw_batch_point(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    double *x, double *y, double *u, double *v, double *margin);

/* The same in the ground frame of the linkage, not moved by x0, y0, theta0, for the link's ORIGIN
 * and direction: what a linear fit of place, size and tracer needs,
 *     P = z0 + a (o + c d),   z0, a, c complex. */
void lw_batch_frame(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    double *ox, double *oy, double *dx, double *dy, double *margin);

/* Positions and their exact derivatives, dim_stride = mode_stride = 0 only.  jx[d*ld + k] is d x / d dim[d] of lane
 * k; jt: of the angle of the output's link [rad], may be NULL.  tx, ty, tt: derivative of x, y, angle by the input. */
typedef struct lw_jacobian { double *x, *y, *u, *v, *margin, *jx, *jy, *jt, *tx, *ty, *tt; size_t ld; } lw_jacobian;
void lw_batch_jacobian(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                       const lw_jacobian *out);

/* f = sum over lanes of w |P - T|^2 (w NULL: 1) and its gradient by every dimension in one pass; one set
 * of dimensions.  Returns f; *margin the least margin, may be NULL.  The fits use the Jacobian instead; this function
 * carries the figure "3 ns a point with sum of squares and gradient by nine dimensions"
 * (tests/bench/bench_kernel.c). */
double lw_batch_sum(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    const double *tx, const double *ty, const double *w, double *grad, double *margin);

/* The normal equations of a least-squares step: from rows over lanes, column v of component r at
 * row[(r*row_step + v)*ld], component r of the residual at res[r*ld], to the lower triangle of J'J,
 *     h[i*n + j] = sum over components and lanes of column[i] times column[j],  j <= i,
 * and g[i], the same with the residual.  ld: a multiple of 8, rows 0 beyond the last lane. */
typedef struct lw_normal {
    int           n, n_row;     /* columns taken, components                                      */
    const int    *column;       /* (n)                                                            */
    const double *row, *res;
    size_t        row_step, ld;
} lw_normal;
void lw_batch_normal(const lw_plan *plan, const lw_normal *in, double *h, double *g);

/* Name of the instruction set the plan's kernels were compiled for: "x86-64-v4", "generic", ... */
const char *lw_batch_isa(const lw_plan *plan);

#endif
