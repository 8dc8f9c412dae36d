/* base/spline.h - cubic splines: two continuous derivatives through given points. */
#ifndef LW_BASE_SPLINE_H
#define LW_BASE_SPLINE_H

/* Second derivatives of the cubic spline through the n >= 2 points, x rising.  slope: first derivatives at both ends, NaN where
 * the second derivative is 0 instead (a natural spline).  work (n), bend (n). */
void   lw_spline_bend(int n, const double *x, const double *y, const double slope[2], double *work, double *bend);

/* Its value at u between points i and i + 1. */
double lw_spline_value(const double *x, const double *y, const double *bend, int i, double u);

#endif
