/* base/real.c - elementary functions from Taylor series, with sums of two doubles where one has too few digits
 * (Dekker 1971). Reduction of large angles: Payne & Hanek 1983. */
#include "base/real.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* ---- sums of two doubles ------------------------------------------------------------------------- */

typedef struct pair { double hi, lo; } pair;

/* a + b exactly; |a| >= |b| or a == 0. */
static inline pair sum_sorted(double a, double b)
{
    double s = a + b;
    return (pair){ s, b - (s - a) };
}

static inline pair sum(double a, double b)
{
    double s = a + b, t = s - a;
    return (pair){ s, (a - (s - t)) + (b - t) };
}

/* a b exactly, for |a|, |b| < 2^996 and a result above 2^-960. */
static inline pair product(double a, double b)
{
    double p = a*b, ca = 134217729*a, cb = 134217729*b;
    double ah = ca - (ca - a), bh = cb - (cb - b), al = a - ah, bl = b - bh;
    return (pair){ p, ((ah*bh - p) + ah*bl + al*bh) + al*bl };
}

static inline pair add(pair a, pair b)
{
    pair s = sum(a.hi, b.hi);
    return sum_sorted(s.hi, s.lo + (a.lo + b.lo));
}

static inline pair multiply(pair a, pair b)
{
    pair p = product(a.hi, b.hi);
    return sum_sorted(p.hi, p.lo + (a.hi*b.lo + a.lo*b.hi));
}

static inline pair divide(pair a, pair b)
{
    double q = a.hi/b.hi;
    pair p = product(q, b.hi);
    return sum_sorted(q, (((a.hi - p.hi) - p.lo) + a.lo - q*b.lo)/b.hi);
}

/* x 2^n, rounded once. */
static double scale(double x, int n) { return ldexp(x, n); }

static const pair pi_2 = { 0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54 };

/* ---- sine and cosine ----------------------------------------------------------------------------- */

/* 2/pi in digits of 32 bits after the point. */
static const uint32_t two_over_pi[] = {
    0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561, 0xb7246e3a,
    0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41,
    0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf,
    0x27cb09b7, 0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08,
    0x56033046, 0xfc7b6bab,
};

/* |x| >= 2^20, x > 0: multiply by those digits of 2/pi that matter modulo 4. The digits left out change the quarter turn
 * by less than 2^-138; no double is nearer to a multiple of pi/2 than 2^-62. */
static int reduce_large(double x, pair *r)
{
    enum { N = 7 };
    int e;
    uint64_t m = (uint64_t)ldexp(frexp(x, &e), 53), part[2] = { m & 0xffffffff, m >> 32 };
    e -= 53;                                             /* x = m 2^e */
    int first = e > 2 ? (e - 2)/32 : 0, point = 32*(first + N) - e;      /* bits after the point */
    uint32_t digit[N + 2] = { 0 };                       /* of the product, the least first */
    for (int i = 0; i < N; i++) {
        uint64_t w = two_over_pi[first + N - 1 - i], low = w*part[0] + digit[i], high = w*part[1] + digit[i + 1];
        digit[i] = (uint32_t)low;
        high += low >> 32;
        digit[i + 1] = (uint32_t)high;
        digit[i + 2] = (uint32_t)(high >> 32);
    }
    int at = point/32, bit = point%32;
    uint64_t top = digit[at] | (at + 1 < N + 2 ? (uint64_t)digit[at + 1] << 32 : 0);
    int quarter = (int)(top >> bit & 3);
    bool above = bit > 0 ? digit[at] >> (bit - 1) & 1 : digit[at - 1] >> 31;         /* one half or more */
    pair f = { above ? -1 : 0, 0 };
    f = add(f, (pair){ ldexp((double)(digit[at] & (((uint32_t)1 << bit) - 1)), -bit), 0 });
    for (int i = at - 1; i >= 0; i--)
        f = add(f, (pair){ ldexp((double)digit[i], 32*i - point), 0 });
    *r = multiply(f, pi_2);
    return quarter + above;
}

/* x = k pi/2 + r with |r| <= pi/4; returns k modulo 4. */
static int reduce(double x, pair *r)
{
    const double part1 = 0x1.921fb544p+0, part2 = 0x1.0b4611a6p-34, part3 = 0x1.3198a2e037073p-69;
    double a = fabs(x);
    int k;
    if (a < 0x1.921fb54442d18p-1) {
        *r = (pair){ x, 0 };
        return 0;
    }
    if (a < 0x1p20) {
        double n = (a*0x1.45f306dc9c883p-1 + 0x1.8p52) - 0x1.8p52;
        pair t = sum(a - n*part1, -n*part2);             /* products of n with 33 bits are exact */
        *r = sum_sorted(t.hi, t.lo - n*part3);
        k = (int)n;
    } else {
        k = reduce_large(a, r);
    }
    if (x < 0)
        *r = (pair){ -r->hi, -r->lo }, k = -k;
    return k & 3;
}

/* Series to x^17; the rest is below 1e-19. */
static double sine(pair r)
{
    double z = r.hi*r.hi, s = 1.0/355687428096000;
    s = s*z - 1.0/1307674368000;
    s = s*z + 1.0/6227020800;
    s = s*z - 1.0/39916800;
    s = s*z + 1.0/362880;
    s = s*z - 1.0/5040;
    s = s*z + 1.0/120;
    s = s*z - 1.0/6;
    return r.hi + (r.hi*z*s + r.lo*(1 - 0.5*z));
}

static double cosine(pair r)
{
    double z = r.hi*r.hi, c = -1.0/6402373705728000;
    c = c*z + 1.0/20922789888000;
    c = c*z - 1.0/87178291200;
    c = c*z + 1.0/479001600;
    c = c*z - 1.0/3628800;
    c = c*z + 1.0/40320;
    c = c*z - 1.0/720;
    c = c*z + 1.0/24;
    pair square = product(r.hi, r.hi), one = sum_sorted(1, -0.5*square.hi);
    return one.hi + (one.lo + (z*z*c - 0.5*square.lo - r.hi*r.lo));
}

double lw_real_sin(double x)
{
    pair r;
    if (!(fabs(x) > 0x1p-27))
        return x;                                        /* -0 and NaN too */
    if (isinf(x))
        return NAN;
    int k = reduce(x, &r);
    double s = k & 1 ? cosine(r) : sine(r);
    return k & 2 ? -s : s;
}

double lw_real_cos(double x)
{
    pair r;
    if (isnan(x) || isinf(x))
        return isnan(x) ? x : NAN;
    if (fabs(x) < 0x1p-27)
        return 1;
    int k = reduce(x, &r);
    double c = k & 1 ? -sine(r) : cosine(r);
    return k & 2 ? -c : c;
}

void lw_real_sincos(double x, double *s, double *c)
{
    pair r;
    if (!(fabs(x) > 0x1p-27) || isinf(x)) {
        *s = lw_real_sin(x);
        *c = lw_real_cos(x);
        return;
    }
    int k = reduce(x, &r);
    double a = sine(r), b = cosine(r);
    *s = k == 0 ? a : k == 1 ? b : k == 2 ? -a : -b;
    *c = k == 0 ? b : k == 1 ? -a : k == 2 ? -b : a;
}

double lw_real_tan(double x)
{
    pair r;
    if (!(fabs(x) > 0x1p-27))
        return x;
    if (isinf(x))
        return NAN;
    return reduce(x, &r) & 1 ? -cosine(r)/sine(r) : sine(r)/cosine(r);
}

/* ---- arcs ---------------------------------------------------------------------------------------- */

static const pair atan_eighths[9] = {
    { 0, 0 },
    { 0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59 },
    { 0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57 },
    { 0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56 },
    { 0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56 },
    { 0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58 },
    { 0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56 },
    { 0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56 },
    { 0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55 },
};

/* The arc tangent of q = low/high in 0 .. 1: that of the nearest eighth c, and of z = (q - c)/(1 + c q), |z| < 1/15, from its series
 * to z^15. */
static pair arc(double low, double high)
{
    int k = (int)(8*(low/high) + 0.5);
    pair top = { low, 0 }, bottom = { high, 0 };
    if (k > 0) {
        pair from = product(0.125*k, high), more = product(0.125*k, low);
        top = (pair){ low - from.hi, -from.lo };         /* exact: at most a factor of 2 apart */
        bottom = sum_sorted(high, more.hi);
        bottom.lo += more.lo;
    }
    pair z = divide(top, bottom);
    double t = z.hi*z.hi, tt = t*t;
    double s = ((-1.0/3 + t*(1.0/5)) + tt*(-1.0/7 + t*(1.0/9))) + tt*tt*((-1.0/11 + t*(1.0/13)) - tt*(1.0/15));
    z.lo += z.hi*t*s;
    pair total = sum_sorted(atan_eighths[k].hi, z.hi);
    if (k == 0)
        total = (pair){ z.hi, 0 };
    return sum_sorted(total.hi, total.lo + (z.lo + atan_eighths[k].lo));
}

double lw_real_atan2(double y, double x)
{
    double a = fabs(y), b = fabs(x);
    pair t;
    if (isnan(x) || isnan(y))
        return x + y;
    bool steep = a > b;
    if (isinf(a) && isinf(b)) {
        t = atan_eighths[8];
        steep = false;
    } else {
        double low = steep ? b : a, high = steep ? a : b;
        if (low == 0 || isinf(high)) {
            t = (pair){ 0, 0 };
        } else {
            if (!(high < 0x1p500 && high > 0x1p-400)) {
                int e;
                (void)frexp(high, &e);
                low = scale(low, -e), high = scale(high, -e);
            }
            if (low < 0x1p-900*high) {                   /* the quotient may be subnormal */
                if (!steep && !(signbit(x)))
                    return copysign(a/b, y);
                t = (pair){ 0, 0 };
            } else {
                t = arc(low, high);
            }
        }
    }
    if (steep)
        t = add(pi_2, (pair){ -t.hi, -t.lo });
    if (signbit(x))
        t = add((pair){ 2*pi_2.hi, 2*pi_2.lo }, (pair){ -t.hi, -t.lo });
    return copysign(t.hi + t.lo, y);
}

double lw_real_atan(double x) { return fabs(x) < 0x1p-27 ? x : lw_real_atan2(x, 1); }

double lw_real_asin(double x)
{
    return fabs(x) < 0x1p-27 ? x : lw_real_atan2(x, sqrt((1 - x)*(1 + x)));
}

double lw_real_acos(double x)
{
    return lw_real_atan2(sqrt((1 - x)*(1 + x)), x);
}

/* ---- exponential and logarithm ------------------------------------------------------------------- */

/* e^(x.hi + x.lo): x = n ln 2 + r, series to r^14, whose rest is below 1e-19. */
static double exponential(pair x)
{
    if (isnan(x.hi))
        return x.hi;
    if (x.hi > 710)
        return INFINITY;
    if (x.hi < -746)
        return 0;
    double n = (x.hi*0x1.71547652b82fep+0 + 0x1.8p52) - 0x1.8p52;
    pair r = sum(x.hi - n*0x1.62e42fefp-1, -n*0x1.473de6af278edp-34);
    double z = r.hi, p = 1.0/87178291200;
    for (int i = 13; i >= 2; i--) {
        static const double inverse[] = { 0, 0, 1.0/2, 1.0/6, 1.0/24, 1.0/120, 1.0/720, 1.0/5040, 1.0/40320, 1.0/362880,
                                          1.0/3628800, 1.0/39916800, 1.0/479001600, 1.0/6227020800 };
        p = p*z + inverse[i];
    }
    pair s = sum_sorted(1, z);
    double low = z*z*p + s.lo;
    low += (r.lo + x.lo)*(s.hi + low);
    return scale(s.hi + low, (int)n);
}

/* ln x = n ln 2 + ln m, m in [sqrt(1/2), sqrt(2)); ln m = 2 (s + s^3/3 + s^5/5 ...), s = (m - 1)/(m + 1). For 0 < x. */
static pair logarithm(double x)
{
    static const pair third = { 0x1.5555555555555p-2, 0x1.5555555555555p-56 };
    int n;
    double m = frexp(x, &n);
    if (m < 0.70710678118654752)
        m *= 2, n--;
    pair s = divide((pair){ m - 1, 0 }, sum(m, 1)), t = multiply(s, s);
    double z = t.hi, p = 1.0/25;
    for (int i = 9; i >= 0; i--) {
        static const double odd[] = { 1.0/5, 1.0/7, 1.0/9, 1.0/11, 1.0/13, 1.0/15, 1.0/17, 1.0/19, 1.0/21, 1.0/23 };
        p = p*z + odd[i];
    }
    pair cube = multiply(multiply(s, t), add(third, (pair){ z*p, 0 }));
    pair log_m = add(s, cube);
    log_m = (pair){ 2*log_m.hi, 2*log_m.lo };
    /* n times the first part, of 33 bits, is exact */
    pair whole = sum_sorted(n*0x1.62e42fefp-1, n*0x1.473de6af278edp-34);
    whole.lo -= n*0x1.9ff0342542fc3p-90;
    return add(whole, log_m);
}

/* Is the logarithm one of the special cases? */
static bool log_special(double x, double *value)
{
    *value = isnan(x) ? x : x == 0 ? -INFINITY : x < 0 ? NAN : x;
    return !(x > 0) || isinf(x);
}

double lw_real_exp(double x) { return exponential((pair){ x, 0 }); }

double lw_real_log(double x)
{
    double v;
    if (log_special(x, &v))
        return v;
    pair l = logarithm(x);
    return l.hi + l.lo;
}

double lw_real_log2(double x)
{
    double v;
    int n;
    if (log_special(x, &v))
        return v;
    if (frexp(x, &n) == 0.5)
        return n - 1;
    pair l = multiply(logarithm(x), (pair){ 0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56 });
    return l.hi + l.lo;
}

double lw_real_log10(double x)
{
    double v;
    if (log_special(x, &v))
        return v;
    pair l = multiply(logarithm(x), (pair){ 0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57 });
    return l.hi + l.lo;
}

/* x^n for x > 0 and n = 0 .. 1024, by squaring: m^n stays within 2^-512 .. 2^512. */
static double whole_power(double x, int n, bool inverse)
{
    int e;
    double m = frexp(x, &e);
    if (m < 0.70710678118654752)
        m *= 2, e--;
    pair p = { 1, 0 }, square = { m, 0 };
    for (int left = n; left > 0; left >>= 1) {
        if (left & 1)
            p = multiply(p, square);
        if (left > 1)
            square = multiply(square, square);
    }
    if (inverse)
        p = divide((pair){ 1, 0 }, p);
    return scale(p.hi + p.lo, inverse ? -e*n : e*n);
}

double lw_real_pow(double x, double y)
{
    if (y == 0 || x == 1)
        return 1;
    if (isnan(x) || isnan(y))
        return x + y;
    bool whole = floor(y) == y, odd = whole && fabs(y) < 0x1p53 && fmod(y, 2) != 0;
    double a = fabs(x), sign = signbit(x) && odd ? -1 : 1;
    if (isinf(y))
        return a == 1 ? 1 : (a > 1) == (y > 0) ? INFINITY : 0;
    if (a == 0 || isinf(a))
        return sign*((a == 0) == (y > 0) ? 0 : INFINITY);
    if (x < 0 && !whole)
        return NAN;
    if (a == 1)
        return sign;
    if (whole && fabs(y) <= 1024)
        return sign*whole_power(a, (int)fabs(y), y < 0);
    if (y == 0.5)
        return sqrt(x);
    pair l = logarithm(a);
    if (fabs(y*l.hi) > 1e4 || fabs(y) < 0x1p-900)        /* far beyond the range, or 1 */
        return sign*(fabs(y) < 1 ? 1 : y*l.hi > 0 ? INFINITY : 0);
    return sign*exponential(multiply((pair){ y, 0 }, l));
}

/* ---- hyperbolic functions, hypotenuse ------------------------------------------------------------- */

double lw_real_sinh(double x)
{
    double a = fabs(x), z = x*x, s = 1.0/1307674368000;
    if (a > 0.5) {
        double e = lw_real_exp(a > 700 ? 0.5*a : a);
        return copysign(a > 700 ? 0.5*e*e : 0.5*(e - 1/e), x);
    }
    s = s*z + 1.0/6227020800;
    s = s*z + 1.0/39916800;
    s = s*z + 1.0/362880;
    s = s*z + 1.0/5040;
    s = s*z + 1.0/120;
    s = s*z + 1.0/6;
    return x + x*z*s;
}

double lw_real_cosh(double x)
{
    double a = fabs(x), e = lw_real_exp(a > 700 ? 0.5*a : a);
    return a > 700 ? 0.5*e*e : 0.5*(e + 1/e);
}

double lw_real_tanh(double x)
{
    double a = fabs(x);
    return a > 0.5 ? copysign(a > 22 ? 1 : 1 - 2/(lw_real_exp(2*a) + 1), x) : lw_real_sinh(x)/lw_real_cosh(x);
}

double lw_real_hypot(double x, double y)
{
    double a = fabs(x), b = fabs(y);
    if (isinf(a) || isinf(b))
        return INFINITY;
    if (isnan(a) || isnan(b))
        return x + y;
    if (a < b) {
        double t = a;
        a = b;
        b = t;
    }
    if (b < 0x1p-54*a || b == 0)
        return a + b;
    int e = 0;
    if (a > 0x1p480 || b < 0x1p-400) {
        (void)frexp(a, &e);
        a = scale(a, -e);
        b = scale(b, -e);
    }
    double h = sqrt(a*a + b*b);
    pair d = add(product(a, a), product(b, b)), h2 = product(h, h);
    h += (((d.hi - h2.hi) - h2.lo) + d.lo)/(2*h);
    return e == 0 ? h : scale(h, e);
}
