/* mbs/ode/integrate.h - ordinary differential equations y' = f(t, y): problem, options, and an explicit method of
 * order 8.
 *
 * DOP853 (Hairer, Norsett & Wanner 1993, section II.10; Dormand & Prince): twelve evaluations per step, an error
 * estimate from embedded methods of orders 5 and 3, and a continuous solution of order 7 for four more evaluations.  Where that
 * one is less accurate than the step, states within it are integrated anew from the nearer end; where many are asked for, by one step
 * over each half, with a continuous solution of its own.
 * The state is summed with compensation, so that 1e7 steps do not lose digits.  Not for stiff problems: steps are
 * limited to about 6 divided by the fastest rate (mbs/ode/cvode.h has no such limit).
 *
 * One call makes one step, which ends at an event, at t_end, or where the allowed error requires.  The caller
 * provides all memory; nothing is allocated. */
#ifndef LW_MBS_ODE_INTEGRATE_H
#define LW_MBS_ODE_INTEGRATE_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"

#define LW_EVENT_MAX 64

/* Every callback returns LW_OK; LW_OPEN if the state is meaningless (the step is repeated shorter); a failure, which
 * ends the run with that status; or LW_STOPPED, which also ends the run, after setting the error text. */
typedef struct lw_ode {
    int   n;                         /* length of y                                                */
    void *context;                   /* passed to every callback                                   */
    lw_status (*rate)(void *context, double t, const double *y, double *dy);             /* dy (n)    */
    /* jac[i + n*j] = d dy_i / d y_j, zeroed before; for implicit methods only; NULL: by differences  */
    lw_status (*jacobian)(void *context, double t, const double *y, const double *dy, double *jac);
    /* correct y after every accepted step (constraints, energy).  A step that this moves by more than its allowed error is
     * repeated shorter; after LW_NOTHING, which means success too, that is not looked at.  NULL: none  */
    lw_status (*project)(void *context, double t, double *y);
    int   n_event;                   /* event functions, watched for zero crossings                 */
    lw_status (*event)(void *context, double t, const double *y, double *g);             /* g (n_event) */
    signed char direction[LW_EVENT_MAX];   /* +1 rising, -1 falling, 0 both                           */
    bool  passing[LW_EVENT_MAX];     /* true: `seen` is called and the step goes on; false: the step ends there */
    void (*seen)(void *context, int event, double t, const double *y);                    /* may be NULL */
    unsigned long long breaks;       /* bit i: rate jumps or has a kink at event i, so that the error of a step with it is kept smaller */
} lw_ode;

/* |error of a step in y_i| <= absolute_i + relative |y_i|, in the root mean square over i. */
typedef struct lw_ode_options {
    double relative, absolute;       /* > 0 one of them; default 1e-9, 1e-9                         */
    const double *absolute_each;     /* (n), NULL: `absolute` for all                               */
    double first, greatest;          /* first step, longest step; 0: chosen automatically, no limit */
    int    order;                    /* greatest order, of IDA only; 0: that of the method          */
    double fixed;                    /* > 0: all steps have this length, without error control (tests) */
    bool   smooth;                   /* f is accurate to rounding: use a step control that refuses fewer steps */
    long   max_step;                 /* accepted and refused; default 10000000; 0: no limit         */
} lw_ode_options;

lw_ode_options lw_ode_options_default(void);

typedef enum lw_ode_stop {
    LW_ODE_STEP,                     /* an ordinary step                                           */
    LW_ODE_EVENT,                    /* t is where events crossed 0, to 1e-12 of the time scale or rounding */
    LW_ODE_END                       /* t is t_end                                                 */
} lw_ode_stop;

/* Is nothing left of the way from t to t_end but rounding, as where an event happens at t_end itself?  No solver steps over that. */
static inline bool lw_ode_at_end(double t, double t_end)
{
    double size = t_end < 0 ? -t_end : t_end, left = t_end < t ? t - t_end : t_end - t;
    return left <= 1e-14*size;
}

typedef struct lw_integrator {
    const lw_ode  *ode;
    lw_ode_options o;
    double  t, t_old;                /* end and beginning of the last step                          */
    double  h;                       /* proposed length of the next step                            */
    double *y, *y_old;               /* (n) there                                                   */
    double *dy;                      /* (n) f(t, y)                                                 */
    unsigned long long events;       /* bit i: event i happened at t                                */
    double  retry;                   /* an event function that says LW_OPEN: length of a step that suits it; 0: a quarter */
    long    n_step, n_refused, n_rate;
    int     n_limited;               /* recent steps whose length stability limits, and not the error allowed */
    /* private to the integrator */
    double *k[16], *stage, *c[8], *low, *y_step, *g_try, *g_old, *inner, *halves;
    double  t_low, t_step, h_done, h_old, err_old, moved, rounding, asked;
    signed char side[LW_EVENT_MAX];
    double  reach;                   /* length of the last step times the fastest rate of f, as far as the step shows it */
    int     n_free;                  /* steps in a row that stability did not limit */
    bool    dense;                   /* the continuous solution is known */
    double  rough;                   /* its error over that allowed in a step, if it is not accurate enough; else 0 */
    int     in_halves;               /* continuous solutions of its halves: 1 known, -1 not accurate either, 0 not yet tried */
} lw_integrator;

/* Doubles of workspace: 30 n for the step, 22 n for steps within it, 16 n for its halves. */
#define LW_INTEGRATE_WORK(n, n_event) (68*(size_t)(n) + 2*(size_t)(n_event))
size_t lw_integrate_work(int n, int n_event);

/* Begin at (t, y).  ode and work belong to the caller and must outlive w.  LW_E_ARG: no tolerance, or more than
 * LW_EVENT_MAX events; also the failures of f. */
lw_status lw_integrate_start(lw_integrator *w, const lw_ode *ode, const lw_ode_options *o, double *work,
                             double t, const double *y, lw_error *e);

/* After the caller changed the state (an impact) or f itself (contact made or lost) at w->t: take the new y (NULL:
 * unchanged) and determine again on which side of 0 each event function is; for an event that has just happened, on
 * which side it will be shortly afterwards.  The step length is kept; set w->h to change it. */
lw_status lw_integrate_restart(lw_integrator *w, const double *y, lw_error *e);

/* One step towards t_end (which may lie before t).  Events are checked at the end of a step and at three
 * points inside.  Where an event function comes near 0 between these and goes back, its extreme is sought: two crossings of
 * one event are seen unless they are closer together than 1e-5 of the step.
 * LW_STOPPED: max_step used up; LW_E_NUMERIC: steps too short to move t, or numbers not finite. */
lw_status lw_integrate_step(lw_integrator *w, double t_end, lw_ode_stop *stop, lw_error *e);

/* y (n) at t between t_old and t of the last step.  LW_E_NUMERIC: f is not known where the state would follow from it. */
lw_status lw_integrate_dense(lw_integrator *w, double t, double *y);

#endif
