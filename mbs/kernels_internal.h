/* mbs/kernels_internal.h - the loops of mbs/batch.h, compiled once per instruction set from mbs/kernel.c.
 *
 * Every instruction set gives the same bits: no contraction, no reassociation, sums in eight accumulators
 * (lane number modulo eight).  Internal to mbs. */
#ifndef LW_MBS_KERNELS_INTERNAL_H
#define LW_MBS_KERNELS_INTERNAL_H

#include "mbs/batch.h"

#define LW_BLOCK 128          /* lanes worked on at a time: registers of a small plan stay in the first cache */
#define LW_GROUP 8            /* lanes are worked on in multiples of this; the rest is padded                 */

typedef struct lw_kernels {
    const char *isa;
    void (*point)(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                  double *x, double *y, double *u, double *v, double *margin);
    void (*frame)(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                  double *ox, double *oy, double *dx, double *dy, double *margin);
    void (*jacobian)(const lw_plan *plan, const lw_lanes *in, int which, void *work, const lw_jacobian *out);
    double (*sum)(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                  const double *tx, const double *ty, const double *w, double *grad, double *margin);
} lw_kernels;

/* The tables this processor can run, best first; NULL past the last. */
const lw_kernels *lw_kernels_supported(int rank);

#endif
