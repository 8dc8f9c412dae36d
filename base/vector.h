/* base/vector.h - sums over arrays of n numbers, from the first to the last. */
#ifndef LW_BASE_VECTOR_H
#define LW_BASE_VECTOR_H

#include "base/real.h"

static inline double lw_dot(int n, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i]*b[i];
    return sum;
}

/* The greatest magnitude; 0 for n = 0.  A NaN counts as 0. */
static inline double lw_greatest(int n, const double *x)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

#endif
