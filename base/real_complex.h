/* base/real_complex.h - <complex.h> with functions that give the same bits on every processor; see base/real.h. */
#ifndef LW_BASE_REAL_COMPLEX_H
#define LW_BASE_REAL_COMPLEX_H

#include <complex.h>
#include "base/real.h"

static inline double complex lw_real_cexp(double complex z)
{
    double size = exp(creal(z));
    return __builtin_complex(size*cos(cimag(z)), size*sin(cimag(z)));      /* clang lacks CMPLX of glibc */
}

#define cexp(z) lw_real_cexp(z)

static inline double lw_real_cabs(double complex z) { return hypot(creal(z), cimag(z)); }
static inline double lw_real_carg(double complex z) { return atan2(cimag(z), creal(z)); }

#define cabs(z) lw_real_cabs(z)
#define carg(z) lw_real_carg(z)

#endif
