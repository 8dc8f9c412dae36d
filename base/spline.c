#include "base/spline.h"

#include "base/real.h"

void lw_spline_bend(int n, const double *x, const double *y, const double slope[2], double *work, double *bend)
{
    double first = x[1] - x[0], last = x[n-1] - x[n-2];
    bend[0] = work[0] = 0;
    if (!isnan(slope[0])) {
        bend[0] = 3*((y[1] - y[0])/first - slope[0])/first;
        work[0] = 0.5;
    }
    for (int i = 1; i < n - 1; i++) {                      /* Thomas' elimination of the three rows */
        double h0 = x[i] - x[i-1], h1 = x[i+1] - x[i];
        double pivot = 2*(h0 + h1) - h0*work[i-1];
        work[i] = h1/pivot;
        bend[i] = (6*((y[i+1] - y[i])/h1 - (y[i] - y[i-1])/h0) - h0*bend[i-1])/pivot;
    }
    bend[n-1] = 0;
    if (!isnan(slope[1]))
        bend[n-1] = (6*(slope[1] - (y[n-1] - y[n-2])/last)/last - bend[n-2])/(2 - work[n-2]);
    for (int i = n - 2; i >= 0; i--)
        bend[i] -= work[i]*bend[i+1];
}

double lw_spline_value(const double *x, const double *y, const double *bend, int i, double u)
{
    double h = x[i+1] - x[i], a = (x[i+1] - u)/h, b = (u - x[i])/h;
    return a*y[i] + b*y[i+1] + ((a*a*a - a)*bend[i] + (b*b*b - b)*bend[i+1])*h*h/6;
}
