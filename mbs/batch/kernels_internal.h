/* mbs/batch/kernels_internal.h - the table of loops of mbs/batch/batch.h, which each instruction set has.
 *
 * Every instruction set gives the same bits: sums are neither contracted nor reordered, and have eight accumulators
 * (lane number modulo eight).  Internal to mbs. */
#ifndef LW_MBS_BATCH_KERNELS_INTERNAL_H
#define LW_MBS_BATCH_KERNELS_INTERNAL_H

#include <stdint.h>
#include "base/vector.h"
#include "mbs/batch/batch.h"

#define LW_BLOCK_LANES 128    /* lanes per pass: the registers of a small plan stay in the first-level cache  */
#define LW_GROUP 8            /* lanes come in multiples of this; the last group is padded                    */

#define LW_CHUNK 1024         /* lanes per pass of the continuation; the last pass has up to LW_GROUP - 1 more */

/* The posture of the higher groups of a plan at one input: in row[] x, y for the direction of each turn and d for each
 * displacement; the inverse Jacobians of the groups one after the other; the least margin. */
#define LW_GROUP_ROW_MAX (2*LW_MODE_MAX)
#define LW_INVERSE_MAX   (LW_HIGHER_MAX*LW_UNKNOWN_MAX*LW_UNKNOWN_MAX)
typedef struct lw_group_posture {
    double row[LW_GROUP_ROW_MAX], inverse[LW_INVERSE_MAX], margin;
} lw_group_posture;

typedef struct lw_kernels {
    const char *isa;
    void (*point)(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                  double *x, double *y, double *u, double *v, double *margin);
    void (*frame)(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                  double *ox, double *oy, double *dx, double *dy, double *margin);
    void (*jacobians)(const lw_plan *plan, const lw_lanes *in, int n, const int *which, void *work, const lw_jacobian *out);
    double (*sum)(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                  const double *tx, const double *ty, const double *w, double *grad, double *margin);
    void (*normal)(const lw_normal *in, double *h, double *g);
    void (*nearest)(const lw_polyline *line, size_t n, const double *x, const double *y, double *near_x, double *near_y);
    void (*costs)(const lw_samples *of, size_t n, const double *x, const double *y, const double *weight, double factor, double *cost);
    double (*in_order)(size_t n, size_t m, const double *cost, size_t first, int sense, double enough, double *least);
    void (*turns)(size_t n, const double *angle, double *c, double *s);
    /* Follow the higher groups from the seed to one input.  work: lw_group_posture_size bytes. */
    void (*group_posture)(const lw_plan *plan, const double *dim, const double *mode, double input, void *work,
                          lw_group_posture *group_posture);
    const size_t *group_size, *follow_size;      /* bytes of scratch for a higher group, to follow all of them: the */
                                                 /* same in each table                                      */
} lw_kernels;

/* Doubles of scratch: rows of the block for each lane; inverse Jacobians for each lane; rows to follow the higher
 * groups. */
size_t lw_lane_rows(const lw_plan *plan);
/* Rows of the padded last group: its inputs and outputs. */
size_t lw_group_rows(const lw_plan *plan);
size_t lw_inverse_rows(const lw_plan *plan);
size_t lw_continuation_size(const lw_plan *plan);

/* The scratch of lw_kernels.group_posture [byte]: 0.3 to 1 MB, too much for the stack. */
size_t lw_group_posture_size(const lw_plan *plan);

/* Find the posture of the higher groups at one input.  LW_E_MEMORY: there is no scratch.  posture.c */
lw_status lw_group_posture_find(const lw_plan *plan, const double *dim, const double *mode, double input, lw_group_posture *group_posture);

/* The tables this processor can run, best first; NULL past the last. */
const lw_kernels *lw_kernels_supported(int rank);

/* The table that plan->kernels chooses, the best one when it is NULL. */
const lw_kernels *lw_kernels_of(const lw_plan *plan);

#endif
