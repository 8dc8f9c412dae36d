/* mbs/ode/collocation.h - ordinary differential equations y' = f(t, y) whose f is worked out at eight states at once.
 *
 * A step of length h is the polynomial of degree 8 that meets the equations at the eight points of Radau IIA (order 15 at the end
 * of the step, 9 within): Y = y + h A f(Y).  Y is improved by f of all points together (van der Houwen & Sommeijer 1990), from the
 * continued polynomial of the step before.  So a step makes few calls one after the other, and the eight states of a call go
 * through vector instructions.  The improvements converge while h is below about 5 over the fastest rate; for stiff equations of
 * motion (`implicit`) they are steps of Newton's method with derivatives by differences, and h has no such limit.
 *
 * The state is x, u with x' = u, or with x' = a function of x and u (quaternions), and integrals of functions of these.  The caller
 * provides all memory; nothing is allocated.
 */
#ifndef LW_MBS_ODE_COLLOCATION_H
#define LW_MBS_ODE_COLLOCATION_H

#include "mbs/ode/integrate.h"

enum { LW_STAGES = 8, LW_IMPLICIT_MAX = 16 };

/* Number i of the state at point k is y[LW_STAGES*i + k].  Statuses as in lw_ode. */
typedef struct lw_stages_ode {
    int   n, n_x, n_u;                       /* numbers in y; in x and in u.  f does not depend on the others */
    bool  implicit;                          /* n_u is at most LW_IMPLICIT_MAX, and x' = u */
    void *context;
    /* dy but x' (n x LW_STAGES).  again: dy holds what the last call gave for states nearby, and may be improved only so far that repeated
     * calls tend to f */
    lw_status (*rates)(void *context, const double t[LW_STAGES], bool again, const double *y, double *dy);
    void (*motion)(void *context, const double *y, double *dx);      /* x' (n_x x LW_STAGES); NULL: u */
    lw_status (*project)(void *context, double t, double *y);        /* y (n), after every step.  One that this moves by
                                              * more than its allowed error is repeated shorter */
    const char *isa;                         /* instruction set of the processor, as lw_kernels names it; NULL: what all have */
} lw_stages_ode;

typedef struct lw_collocation {
    const lw_stages_ode *ode;
    const struct lw_stage_loops *loops;
    lw_ode_options o;                        /* relative, absolute, greatest, max_step */
    double  t, t_old, h;                     /* end and beginning of the last step; length proposed for the next */
    double *y, *y_old;                       /* (n) there */
    long    n_step, n_refused, n_rate;       /* n_rate: states at which f was worked out */
    /* private to the integrator */
    double *f, *stage, *low, *scale, *lost;
    double *c;                               /* Legendre coefficients of the rates in the last step; */
    double *d, *d_refused;                   /* their divided differences from its end, and those of the last step refused, */
    double  h_refused, passed;               /* whose length this is; how far the motion has come since it began */
    double *by, *lu;                         /* derivatives of u' by x and u; factors for each complex eigenvalue of A */
    double  h_done, t_low, fastest, most;    /* fastest: factor of an improvement over h; limit of h */
    double  error;                           /* of the last step, over the error allowed */
    double  moved, noise;                    /* how far projections moved the last trial, move by rounding, over the error allowed */
    int     degree;                          /* of the polynomial that predicts f, through the last points of a step */
    bool    stale;                           /* the derivatives are to be found afresh */
} lw_collocation;

/* Doubles of workspace. */
size_t lw_collocation_work(int n, bool implicit);

/* Begin at (t, y).  ode and work belong to the caller and must outlive w. */
void lw_collocation_start(lw_collocation *w, const lw_stages_ode *ode, const lw_ode_options *o, double *work, double t, const double *y);

/* Go on from y at w->t, where the caller has changed the state without changing its rates. */
void lw_collocation_restart(lw_collocation *w, const double *y);

/* One step towards t_end > t.  Statuses as of lw_integrate_step. */
lw_status lw_collocation_step(lw_collocation *w, double t_end, lw_ode_stop *stop, lw_error *e);

/* y (n) at t between t_old and t of the last step. */
void lw_collocation_dense(const lw_collocation *w, double t, double *y);

/* y (n x LW_STAGES) at eight times after t_old. */
void lw_collocation_dense_eight(const lw_collocation *w, const double t[LW_STAGES], double *y);

#endif
