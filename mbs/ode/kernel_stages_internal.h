/* mbs/ode/kernel_stages_internal.h - the table of loops of mbs/ode/collocation.c, which each instruction set has with the same bits;
 * internal to mbs/ode. */
#ifndef LW_MBS_ODE_KERNEL_STAGES_INTERNAL_H
#define LW_MBS_ODE_KERNEL_STAGES_INTERNAL_H

#include "mbs/ode/collocation.h"

/* Arrays of rows have a number of the state in each row, at the eight points or by eight polynomials. */
typedef struct lw_stage_loops {
    const char *isa;
    /* out: sum of in[row][j] column[j], in each of n rows; out may be in */
    void (*sums)(int n, const double (*column)[LW_STAGES], const double *in, double *out);
    /* stage = y + h times these sums of f; off (8): sums of squares over rows of how far each stage moved, times scale */
    void (*improve)(int n, const double (*column)[LW_STAGES], double h, const double *y, const double *scale, const double *f,
                    double *stage, double *off);
    /* size (8): sums of squares of in over its rows, times scale */
    void (*squares)(int n, const double *scale, const double *in, double *size);
    /* off[m] (8): sum over rows and points of squares of f minus c[0] column[0] .. c[m] column[m], times scale, by weight (8) of the points */
    void (*misses)(int n, const double (*column)[LW_STAGES], const double *c, const double *f, const double *scale, const double *weight,
                   double *off);
} lw_stage_loops;

extern const lw_stage_loops lw_stage_loops_x86_64, lw_stage_loops_x86_64_v3, lw_stage_loops_x86_64_v4, lw_stage_loops_native;

#endif
