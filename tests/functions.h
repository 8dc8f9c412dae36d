/* tests/functions.h - small problems with known optima for the tests of solvers.
 *
 * HS65: Hock & Schittkowski 1981, no. 65, a sum of three squares over a ball and a box,
 *     f* = 0.9535288567,  x* = (3.650461821, 3.650461821, 4.620417050).
 * The optimum is symmetric, x1 = x2 = t, and one condition is active: a minimum over one angle, which
 * hs65_optimum() works out to rounding. The condition is divided by 10: conditions are of order one. */
#ifndef LW_TESTS_FUNCTIONS_H
#define LW_TESTS_FUNCTIONS_H

#include <math.h>
#include <string.h>
#include "optimise/solvers/record.h"

static inline bool hs65_residuals(void *context, const double *x, double *r, double *j)
{
    static const double jac[9] = { 1, -1, 0, 1/3.0, 1/3.0, 0, 0, 0, 1 };
    (void)context;
    r[0] = x[0] - x[1];
    r[1] = (x[0] + x[1] - 10)/3;
    r[2] = x[2] - 5;
    if (j)
        memcpy(j, jac, sizeof jac);
    return true;
}

static inline double hs65_value(void *context, const double *x, double *grad)
{
    double r[3], j[9];
    hs65_residuals(context, x, r, j);
    for (int k = 0; grad && k < 3; k++)
        grad[k] = 2*(r[0]*j[k] + r[1]*j[3 + k] + r[2]*j[6 + k]);
    return r[0]*r[0] + r[1]*r[1] + r[2]*r[2];
}

static inline void hs65_conditions(void *context, const double *x, double *g, double *j)
{
    (void)context;
    g[0] = (48 - x[0]*x[0] - x[1]*x[1] - x[2]*x[2])/10;
    for (int k = 0; j && k < 3; k++)
        j[k] = -0.2*x[k];
}

static inline lw_function hs65(void)
{
    static const double lo[3] = { -4.5, -4.5, -5 }, hi[3] = { 4.5, 4.5, 5 };
    return (lw_function){ .n = 3, .m = 1, .n_residual = 3, .lo = lo, .hi = hi, .value = hs65_value,
                          .residuals = hs65_residuals, .conditions = hs65_conditions };
}

/* On the ball x1 = x2 = sqrt(24) sin u, x3 = sqrt(48) cos u; Newton's method on df/du = 0. */
static inline double hs65_optimum(void)
{
    double u = 0.84, a = sqrt(24), b = sqrt(48), r, s;
    for (int k = 0; k < 20; k++) {
        r = (2*a*sin(u) - 10)/3, s = b*cos(u) - 5;
        double dr = 2*a*cos(u)/3, ds = -b*sin(u);
        u -= (r*dr + s*ds)/(dr*dr + ds*ds - r*2*a*sin(u)/3 - s*b*cos(u));
    }
    r = (2*a*sin(u) - 10)/3, s = b*cos(u) - 5;
    return r*r + s*s;
}

/* Rosenbrock's valley, inside a box: f* = 0 at (1, 1). */
static inline bool valley_residuals(void *context, const double *x, double *r, double *j)
{
    (void)context;
    r[0] = 10*(x[1] - x[0]*x[0]);
    r[1] = 1 - x[0];
    if (j) {
        j[0] = -20*x[0], j[1] = 10;
        j[2] = -1, j[3] = 0;
    }
    return true;
}

static inline double valley_value(void *context, const double *x, double *grad)
{
    double r[2], j[4];
    valley_residuals(context, x, r, j);
    for (int k = 0; grad && k < 2; k++)
        grad[k] = 2*(r[0]*j[k] + r[1]*j[2 + k]);
    return r[0]*r[0] + r[1]*r[1];
}

static inline lw_function valley(const double *lo, const double *hi)
{
    return (lw_function){ .n = 2, .n_residual = 2, .lo = lo, .hi = hi, .value = valley_value,
                          .residuals = valley_residuals };
}

#endif
