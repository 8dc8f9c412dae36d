/* base/vector.h - arrays of n numbers: sums from the first to the last, the greatest, sorting; registers of vector instructions. */
#ifndef LW_BASE_VECTOR_H
#define LW_BASE_VECTOR_H

#include <stdint.h>
#include <stdlib.h>
#include "base/real.h"

static inline double lw_dot(int n, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i]*b[i];
    return sum;
}

static inline double lw_norm(int n, const double *a) { return sqrt(lw_dot(n, a, a)); }

/* The lesser and the greater of two numbers; a if b is NaN.  Unlike fmin and fmax they are no calls. */
static inline double lw_lesser(double a, double b) { return b < a ? b : a; }
static inline double lw_greater(double a, double b) { return b > a ? b : a; }

/* The greatest magnitude; 0 for n = 0.  A NaN counts as 0. */
static inline double lw_greatest(int n, const double *x)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = lw_greater(most, fabs(x[i]));
    return most;
}

/* The greatest magnitude; INFINITY if one of them is not finite. */
static inline double lw_greatest_or_infinite(int n, const double *x)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = lw_greater(most, isfinite(x[i]) ? fabs(x[i]) : INFINITY);
    return most;
}

static inline int lw_compare_numbers(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sort in ascending order; no NaN. */
static inline void lw_sort(size_t n, double *x) { qsort(x, n, sizeof *x, lw_compare_numbers); }

/* The place of the first of n ascending numbers that is not below k; n if all are. */
static inline int lw_place_in(int n, const int *ascending, int k)
{
    int low = 0, high = n;
    while (low < high) {
        int middle = (low + high)/2;
        if (ascending[middle] < k)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Two neighbouring numbers of an array in a register. */
typedef double lw_pair __attribute__((vector_size(16), aligned(8), may_alias));

/* The first address from p on at which a register of eight numbers begins in memory; [bytes]. */
#define LW_SCRATCH_ALIGNMENT 64
static inline void *lw_scratch_align(void *p)
{
    return (char *)p + (LW_SCRATCH_ALIGNMENT - (uintptr_t)p%LW_SCRATCH_ALIGNMENT)%LW_SCRATCH_ALIGNMENT;
}

#endif
