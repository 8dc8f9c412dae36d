/* mbs/ode/ida.h - differential-algebraic equations F(t, y, y') = 0 of constrained motion by IDA's BDF methods
 * (Hindmarsh et al. 2005).
 *
 * `algebraic` marks multipliers and other variables without derivative.  They are excluded from the error test;
 * otherwise index-2 equations (Gear, Gupta & Leimkuhler 1985) fail at the start for tight tolerances. */
#ifndef LW_MBS_ODE_IDA_H
#define LW_MBS_ODE_IDA_H

#include "mbs/ode/sundials.h"

typedef struct lw_dae {
    int   n;
    void *context;
    lw_status (*residual)(void *context, double t, const double *y, const double *dy, double *r);   /* r (n) */
    /* jac[i + n*j] = dr_i/dy_j + c dr_i/dy'_j, zeroed before; NULL: by differences */
    lw_status (*jacobian)(void *context, double t, double c, const double *y, const double *dy, double *jac);
    /* Not NULL: the Jacobian has these entries only, and jac holds them in this order, zeroed before. */
    const struct lw_columns *pattern;
    const unsigned char *algebraic;  /* (n), 1: its derivative does not occur; NULL: none             */
    int   n_event;                   /* this and the following as in lw_ode                         */
    lw_status (*event)(void *context, double t, const double *y, double *g);
    signed char direction[LW_EVENT_MAX];
    bool  passing[LW_EVENT_MAX];
    void (*seen)(void *context, int event, double t, const double *y);
} lw_dae;

/* Begin at (t, y, y'), which should satisfy F; dae must outlive w.  o->fixed: LW_E_ARG.  After a failure w needs no
 * _free. */
lw_status lw_ida_make(lw_sundials *w, const lw_dae *dae, const lw_ode_options *o, double t, const double *y, const double *dy, lw_error *e);

/* As lw_integrate_restart; the length of the first step is chosen. */
lw_status lw_ida_restart(lw_sundials *w, const double *y, const double *dy, lw_error *e);

#endif
