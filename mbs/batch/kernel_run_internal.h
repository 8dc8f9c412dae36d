/* mbs/batch/kernel_run_internal.h - the registers of a block of lanes and the loops over it.  Included by mbs/batch/kernel.c
 * alone, once per instruction set. */
#ifndef LW_MBS_BATCH_KERNEL_RUN_INTERNAL_H
#define LW_MBS_BATCH_KERNEL_RUN_INTERNAL_H

#include <string.h>
#include "mbs/batch/kernels_internal.h"
#include "mbs/plan/sincos_internal.h"

/* Whole groups of lanes, which spares the compiler the loop's rest.  Lanes do not depend on each other:
 * nothing a lane writes is read by another. */
#if defined(__clang__)
#define LW_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define LW_INDEPENDENT _Pragma("GCC ivdep")
#endif
#define LW_LANES(n) LW_INDEPENDENT for (size_t i = 0, end = (n)/LW_GROUP*LW_GROUP; i < end; i++)

/* A block of lanes.  Rows are nb doubles long; dimension d of lane i is dim[d*dim_row + i], or dim[d] when
 * the lanes share one set (then dim_row is 1). */
typedef struct run {
    const lw_plan *plan;
    size_t nb;
    const double *c, *s;
    const double *dim, *mode;
    size_t dim_row, mode_row;
    double *reg, *margin, *spare;            /* registers: x row, y row                     */
    double *aux;                             /* a row a dyad: reciprocal of its root        */
    double *turn;                            /* cosines, sines of the angles                */
    size_t turn_row;
    double *bar;                             /* adjoints of the registers                   */
    double *row;                             /* derivatives by the dimensions               */
    size_t row_row;
    double *spread_dim, *spread_mode;        /* one set copied to every lane                */
    double *tail;                            /* the padded last group                       */
    double *inverse;                         /* of the higher groups' Jacobians             */
    const double *seats;                     /* the same of the chunk's first lane          */
    const double *seat;                      /* where the higher groups are in these lanes: n_row rows, then by */
    size_t seat_row;                         /* how much the input is out of reach, 0: not at all */
} run;

LW_INLINE double *reg_x(const run *k, int r) { return k->reg + 2*(size_t)r*k->nb; }
LW_INLINE double *reg_y(const run *k, int r) { return reg_x(k, r) + k->nb; }
LW_INLINE double *bar_x(const run *k, int r) { return k->bar + 2*(size_t)r*k->nb; }
LW_INLINE double *bar_y(const run *k, int r) { return bar_x(k, r) + k->nb; }
LW_INLINE double *aux_row(const run *k, int dyad) { return k->aux + (size_t)dyad*k->nb; }
LW_INLINE double *dim_bar(const run *k, int d) { return d < 0 ? k->spare : k->row + (size_t)d*k->row_row; }
LW_INLINE const double *dim_of(const run *k, int d) { return d < 0 ? reg_x(k, 0) : k->dim + (size_t)d*k->dim_row; }
LW_INLINE const double *mode_of(const run *k, int dyad) { return k->mode + (size_t)dyad*k->mode_row; }
LW_INLINE const double *cos_of(const run *k, int angle) { return k->turn + 2*(size_t)angle*k->turn_row; }
LW_INLINE const double *sin_of(const run *k, int angle) { return cos_of(k, angle) + k->turn_row; }

/* Points or directions over the lanes. */
typedef struct in_rows { const double *x, *y; } in_rows;
typedef struct out_rows { double *x, *y; } out_rows;

LW_INLINE in_rows in_reg(const run *k, int r) { return (in_rows){ reg_x(k, r), reg_y(k, r) }; }
LW_INLINE out_rows out_reg(const run *k, int r) { return (out_rows){ reg_x(k, r), reg_y(k, r) }; }
LW_INLINE in_rows in_bar(const run *k, int r) { return (in_rows){ bar_x(k, r), bar_y(k, r) }; }
LW_INLINE out_rows out_bar(const run *k, int r) { return (out_rows){ bar_x(k, r), bar_y(k, r) }; }
LW_INLINE lw_vec2 get(in_rows r, size_t i) { return lw_v2(r.x[i], r.y[i]); }
LW_INLINE void put(out_rows r, size_t i, lw_vec2 v)
{
    r.x[i] = v.x;
    r.y[i] = v.y;
}
LW_INLINE void add_to(out_rows r, size_t i, lw_vec2 v)
{
    r.x[i] += v.x;
    r.y[i] += v.y;
}

/* Where places go, and where they are wanted (w NULL: weight 1). */
typedef struct rows { double *x, *y, *u, *v, *margin; } rows;
typedef struct target { const double *x, *y, *w; } target;

static void fill(double *row, double v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        row[i] = v;
}

/* What a forward sweep leaves beside the registers. */
enum { POSE_ONLY, WITH_MARGIN, WITH_ROOTS };

#endif
