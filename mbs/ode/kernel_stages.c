/* mbs/ode/kernel_stages.c - sums over the eight points of collocation.  Compiled once per instruction set. */
#include "base/real.h"
#include "mbs/ode/kernel_stages_internal.h"

#include <string.h>

#define PASTE(name, isa)  name##_##isa
#define OF_ISA(name, isa) PASTE(name, isa)

enum { N = LW_STAGES };

static inline void combine(const double (*column)[N], const double *in, double *out)
{
    double sum[N] = { 0 };
#pragma GCC unroll 8
    for (int j = 0; j < N; j++)
        for (int k = 0; k < N; k++)
            sum[k] += in[j]*column[j][k];
    memcpy(out, sum, sizeof sum);
}

static void sums(int n, const double (*column)[N], const double *in, double *out)
{
    for (int i = 0; i < n; i++)
        combine(column, in + N*i, out + N*i);
}

static void improve(int n, const double (*column)[N], double h, const double *y, const double *scale, const double *f, double *stage, double *off)
{
    double sum[N], all[N] = { 0 };
    for (int i = 0; i < n; i++, stage += N) {
        const double from = y[i], by = scale[i];         /* which stage, for all that the compiler knows, may hold */
        combine(column, f + N*i, sum);
        for (int k = 0; k < N; k++) {
            double to = from + h*sum[k], moved = (to - stage[k])*by;
            all[k] += moved*moved;
            stage[k] = to;
        }
    }
    memcpy(off, all, sizeof all);
}

static void squares(int n, const double *scale, const double *in, double *size)
{
    double all[N] = { 0 };
    for (int i = 0; i < n; i++)
        for (int k = 0; k < N; k++) {
            double by = in[N*i + k]*scale[i];
            all[k] += by*by;
        }
    memcpy(size, all, sizeof all);
}

static void misses(int n, const double (*column)[N], const double *c, const double *f, const double *scale, const double *weight, double *off)
{
    double each[N][N] = { { 0 } };
    for (int i = 0; i < n; i++) {
        double left[N];
        for (int k = 0; k < N; k++)
            left[k] = f[N*i + k]*scale[i];
        for (int m = 0; m < N; m++) {
            double by = c[N*i + m]*scale[i];
            for (int k = 0; k < N; k++)
                left[k] -= by*column[m][k], each[m][k] += left[k]*left[k];
        }
    }
    for (int m = 0; m < N; m++) {
        off[m] = 0;
        for (int k = 0; k < N; k++)
            off[m] += weight[k]*each[m][k];
    }
}

const lw_stage_loops OF_ISA(lw_stage_loops, LW_ISA) = { LW_ISA_NAME, sums, improve, squares, misses };
