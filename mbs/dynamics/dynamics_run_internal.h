/* mbs/dynamics/dynamics_run_internal.h - one run under way; internal to mbs/. */
#ifndef LW_MBS_DYNAMICS_DYNAMICS_RUN_INTERNAL_H
#define LW_MBS_DYNAMICS_DYNAMICS_RUN_INTERNAL_H

#include "mbs/ode/cvode.h"
#include "mbs/dynamics/dynamics_internal.h"
#include "mbs/ode/ida.h"
#include "mbs/ode/integrate.h"

typedef struct lw_run {
    lw_dynamics    *d;
    lw_moment_sink *sink;
    void           *context;
    lw_dynamics_report      *r;
    lw_error       *e;
    int     n;                       /* q, v, and the work where some is done                          */
    bool    has_work;
    long    n_busy;                  /* evaluations                                                    */
    int     next;                    /* the sample to come                                             */
    double  flight;                  /* of a bounce that just began [s]; 0: none                        */
    double  energy0, potential0, momentum0;
    double  pivot, pivot_t, pivot_tried; /* root of the least pivot, when that was, where one was tried to cross */
    double  apart;                   /* what a curve tried there did not satisfy the rows by; 0: none tried */
    double  chosen;                  /* best of the least pivots since rows were chosen                  */
    double *y, *state;               /* (n) scratch; ggl: the state in front of and behind a crossing    */
} lw_run;

/* Time of sample k. */
double lw_run_time(const lw_dynamics *d, int k);

/* Hand the moment at (t, y) to the sink and keep its worst numbers. */
lw_status lw_run_show(lw_run *run, double t, const double *y);

/* The same without inertia: velocities are told, forces are those at rest. */
lw_status lw_run_show_slow(lw_run *run, double t, const double *y);

/* Energy and momentum at (t, y) against those of the start. */
void lw_run_watch(lw_run *run, const double *y);

/* Begin: numbers of the start, the first sample. */
lw_status lw_run_begin(lw_run *run, const double *y);

/* LW_STOPPED when a limit or the caller ends the run, `steps` more than the report has: after a step, and within every
 * right-hand side, because a step may be tried for long. */
lw_status lw_run_limits(lw_run *run, double t, long steps);
lw_status lw_run_busy(lw_run *run, double t);

/* Steps that are left of those allowed; 0: no limit. */
long lw_run_steps_left(const lw_run *run);

/* y' for explicit and implicit methods, and putting y back on the constraints. */
lw_status lw_run_rate(void *context, double t, const double *y, double *dy);
lw_status lw_run_project(void *context, double t, double *y);

/* Rigid stops: functions of their gaps and pressures; what happens at t.  *changed: y or rows are others now. */
lw_status lw_run_gaps(void *context, double t, const double *y, double *g);
lw_status lw_run_contacts(lw_run *run, double t, double *y, bool *changed);

/* Fill what the report says about the formulation; LW_E_KIND when the one asked for cannot do the model. */
lw_status lw_dynamics_choose(lw_dynamics *d, lw_dynamics_report *r, lw_error *e);

/* Go on from (run->r->t, y) in the bodies' coordinates. */
lw_status lw_run_go_on(lw_run *run, const double *y);

/* Where rows are redundant those kept may become dependent in a posture that is not singular: choose others.  *weak:
 * the least pivot, before and after.  LW_OK: rows are others now; LW_NOTHING: they are not. */
lw_status lw_run_rechoose(lw_run *run, double t, const double *y, double *weak);

/* After a step to (*t, y), where the least pivot is `weak`: through the singular posture that lies ahead, if one does,
 * to behind it, samples told.  LW_NOTHING: none there, or not one this can do (mbs/dynamics/dynamics_singular_crossing.c). */
lw_status lw_run_singular_crossing(lw_run *run, double weak, double *t, double *y);

/* From the good state y at time `good`, whose least pivot is `weak`, over the singular posture that is met at about
 * `place`; half the leap is in multiples of what makes a pivot 1: about radians.  y and *t: behind it, samples on the
 * way told.  LW_OPEN: what comes out has another energy. */
#define LW_SINGULAR_STEP_HALF 0.03
lw_status lw_run_singular_step(lw_run *run, double half, double good, double weak, double place, double *t, double *y);

lw_status lw_run_driven(lw_run *run);
lw_status lw_run_ggl(lw_run *run);
lw_status lw_run_reduced(lw_run *run);
lw_status lw_run_quadrature(lw_run *run);

#endif
