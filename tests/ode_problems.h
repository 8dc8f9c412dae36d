/* tests/ode_problems.h - small equations for the tests of integrators. */
#ifndef LW_TESTS_ODE_PROBLEMS_H
#define LW_TESTS_ODE_PROBLEMS_H

#include <math.h>
#include "mbs/ode/sundials.h"

static inline lw_status sundials_to(lw_sundials *w, double t, lw_error *e)
{
    lw_ode_stop stop = LW_ODE_STEP;
    lw_status s = LW_OK;
    while (s == LW_OK && stop != LW_ODE_END)
        s = lw_sundials_step(w, t, &stop, e);
    return s;
}

static inline lw_status oscillator(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[1], dy[1] = -y[0];
    return LW_OK;
}

static inline lw_status two_levels(void *context, double t, const double *y, double *g)
{
    (void)context, (void)t;
    g[0] = y[0], g[1] = y[0] - 0.5;
    return LW_OK;
}

static inline lw_status pendulum(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;                                  /* x, y, vx, vy on the unit circle */
    double pull = y[2]*y[2] + y[3]*y[3] - 9.81*y[1];
    dy[0] = y[2], dy[1] = y[3], dy[2] = -pull*y[0], dy[3] = -9.81 - pull*y[1];
    return LW_OK;
}

static inline lw_status onto_circle(void *context, double t, double *y)
{
    (void)context, (void)t;
    double r = hypot(y[0], y[1]), v = (y[0]*y[2] + y[1]*y[3])/(r*r);
    y[2] -= v*y[0], y[3] -= v*y[1], y[0] /= r, y[1] /= r;
    return LW_OK;
}

static inline lw_status explodes(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)t;
    dy[0] = y[0]*y[0];                                       /* 1/(1 - t) */
    return LW_OK;
}

static inline lw_status breaks(void *context, double t, const double *y, double *dy)
{
    (void)context, (void)y;
    dy[0] = 1.0;
    return t > 0.5 ? LW_E_KIND : LW_OK;
}

#endif
