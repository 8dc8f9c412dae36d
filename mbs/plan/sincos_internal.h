/* mbs/plan/sincos_internal.h - sine, cosine and arc tangent without branches: they vectorise and give the same bits in
 * every instruction set.  Internal to mbs.
 *
 * Sine and cosine: subtract the nearest multiple of pi/2 in three parts (Cody & Waite 1980), then sum the Taylor series
 * to x^17, whose remainder on |x| <= pi/4 is below 1e-19.  The error is at most 2 units in the last place of 1 for
 * |x| < LW_SINCOS_MAX.  Larger arguments are not allowed. */
#ifndef LW_MBS_PLAN_SINCOS_INTERNAL_H
#define LW_MBS_PLAN_SINCOS_INTERNAL_H

#include "mbs/plan/dyad_internal.h"
#include "mbs/plan/plan.h"

#define LW_SINCOS_MAX 1e6

LW_INLINE double lw_nearest_integer(double x)
{
    const double shift = 0x1.8p52;            /* its last place is worth 1 */
    return (x + shift) - shift;
}

LW_INLINE lw_vec2 lw_sincos(double x)
{
    const double part1 = 0x1.921fb544p+0, part2 = 0x1.0b4611a6p-34, part3 = 0x1.3198a2e037073p-69;
    double k = lw_nearest_integer(x*(2/LW_PI));
    double r = ((x - k*part1) - k*part2) - k*part3, z = r*r;
    double s = 1.0/355687428096000;
    s = s*z - 1.0/1307674368000;
    s = s*z + 1.0/6227020800;
    s = s*z - 1.0/39916800;
    s = s*z + 1.0/362880;
    s = s*z - 1.0/5040;
    s = s*z + 1.0/120;
    s = s*z - 1.0/6;
    s = r + r*z*s;
    double c = 1.0/20922789888000;
    c = c*z - 1.0/87178291200;
    c = c*z + 1.0/479001600;
    c = c*z - 1.0/3628800;
    c = c*z + 1.0/40320;
    c = c*z - 1.0/720;
    c = c*z + 1.0/24;
    c = 1 - (0.5*z - z*z*c);
    double quarter = k - 4*lw_nearest_integer(0.25*k);       /* -2, -1, 0, 1, 2 */
    int odd = fabs(quarter) == 1, half = fabs(quarter) == 2;
    double turned_c = odd ? -quarter*s : c, turned_s = odd ? quarter*c : s;
    return lw_v2(half ? -turned_c : turned_c, half ? -turned_s : turned_s);
}

/* The angle of (c, s), as atan2(s, c), to 1e-14.  An angle above pi/8 is reduced by pi/4, so that |z| <= tan(pi/8);
 * there the remainder of the series after z^33 is below 1e-15. */
LW_INLINE double lw_bearing(double c, double s)
{
    double a = fabs(c), b = fabs(s);
    int steep = b > a, zero;
    double low = steep ? a : b, high = steep ? b : a;
    int beyond = low > 0.41421356237309503*high;
    double top = beyond ? low - high : low, bottom = beyond ? low + high : high;
    zero = bottom == 0;
    double z = top/(zero ? 1 : bottom), z2 = z*z, sum = 1.0/33;
    for (int i = 31; i > 0; i -= 2)
        sum = 1.0/i - z2*sum;
    double turn = z*sum + (beyond ? LW_PI/4 : 0);
    turn = steep ? LW_PI/2 - turn : turn;
    turn = c < 0 ? LW_PI - turn : turn;
    return copysign(turn, s);
}

/* ---- racks -------------------------------------------------------------------------------------- */

/* The turn of the pinion when its rack is at displacement d. */
LW_INLINE double lw_rolled(double d, double rho, double shift) { return (d - shift)/lw_away_from_zero(rho); }

/* The angle from the rack's middle, within half a turn. */
LW_INLINE double lw_off_middle(double angle, double middle)
{
    double a = angle - middle;
    return a - 2*LW_PI*lw_nearest_integer(a*(0.5/LW_PI));
}

/* 1 in the middle, 0 at the ends of the rack. */
LW_INLINE double lw_rack_margin(double off)
{
    double t = off*(1/LW_RACK_REACH);
    return 1 - t*t;
}

#endif
