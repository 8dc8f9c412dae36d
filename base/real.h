/* base/real.h - <math.h> with elementary functions that give the same bits on every processor.
 *
 * The C library chooses variants of its functions by the processor (with or without fused multiply-add), whose last bits
 * differ. Those here use additions, multiplications, divisions and square roots only, which IEEE 754 rounds correctly.
 * The macros replace calls of the standard names, so include this header instead of <math.h>. Arguments and results at
 * zeros, infinities and NaN are as in Annex F of the C standard; errno and flags are not set. Functions of <math.h>
 * without a macro here (sqrt, fabs, floor, fmod, remainder, frexp, ldexp ...) are exact or correctly rounded.
 *
 * Errors in units of the last place: below 0.55 of log, log2, log10, atan, atan2, hypot and of pow with a whole exponent up to
 * 1024 (0.8 if the result is subnormal); below 1 of sin, cos, exp, other pow; below 3 of the other functions (tests/test_real.c). */
#ifndef LW_BASE_REAL_H
#define LW_BASE_REAL_H

#include <math.h>

double lw_real_sin(double x);
double lw_real_cos(double x);
void   lw_real_sincos(double x, double *sine, double *cosine);
double lw_real_tan(double x);
double lw_real_asin(double x);
double lw_real_acos(double x);
double lw_real_atan(double x);
double lw_real_atan2(double y, double x);
double lw_real_exp(double x);
double lw_real_log(double x);
double lw_real_log2(double x);
double lw_real_log10(double x);
double lw_real_pow(double x, double y);
double lw_real_sinh(double x);
double lw_real_cosh(double x);
double lw_real_tanh(double x);
double lw_real_hypot(double x, double y);

#define sin(x)      lw_real_sin(x)
#define cos(x)      lw_real_cos(x)
#define sincos(x, s, c) lw_real_sincos(x, s, c)
#define tan(x)      lw_real_tan(x)
#define asin(x)     lw_real_asin(x)
#define acos(x)     lw_real_acos(x)
#define atan(x)     lw_real_atan(x)
#define atan2(y, x) lw_real_atan2(y, x)
#define exp(x)      lw_real_exp(x)
#define log(x)      lw_real_log(x)
#define log2(x)     lw_real_log2(x)
#define log10(x)    lw_real_log10(x)
#define pow(x, y)   lw_real_pow(x, y)
#define sinh(x)     lw_real_sinh(x)
#define cosh(x)     lw_real_cosh(x)
#define tanh(x)     lw_real_tanh(x)
#define hypot(x, y) lw_real_hypot(x, y)

#endif
