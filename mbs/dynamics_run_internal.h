/* mbs/dynamics_run_internal.h - one run under way; internal to mbs/. */
#ifndef LW_MBS_DYNAMICS_RUN_INTERNAL_H
#define LW_MBS_DYNAMICS_RUN_INTERNAL_H

#include "mbs/cvode.h"
#include "mbs/dynamics_internal.h"
#include "mbs/ida.h"
#include "mbs/integrate.h"

typedef struct lw_run {
    lw_dynamics    *d;
    lw_moment_sink *sink;
    void           *context;
    lw_report      *r;
    lw_error       *e;
    int     n;                       /* q, v, and the work where some is done                          */
    bool    has_work;
    int     next;                    /* the sample to come                                             */
    double  flight;                  /* of a bounce that just began [s]; 0: none                        */
    double  energy0, potential0, momentum0;
    double *y;                       /* (n) scratch                                                    */
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

/* LW_STOPPED when a limit or the caller ends the run. */
lw_status lw_run_limits(lw_run *run, double t, long steps);

/* y' for explicit and implicit methods, and putting y back on the constraints. */
lw_status lw_run_rate(void *context, double t, const double *y, double *dy);
lw_status lw_run_project(void *context, double t, double *y);

/* Rigid stops: functions of their gaps and pressures; what happens at t.  *changed: y or rows are others now. */
lw_status lw_run_gaps(void *context, double t, const double *y, double *g);
lw_status lw_run_contacts(lw_run *run, double t, double *y, bool *changed);

/* Fill what the report says about the formulation; LW_E_KIND when the one asked for cannot do the model. */
lw_status lw_dynamics_choose(lw_dynamics *d, lw_report *r, lw_error *e);

/* Go on from (run->r->t, y) in the bodies' coordinates. */
lw_status lw_run_go_on(lw_run *run, const double *y);

/* From the good state y at time `good`, whose least pivot is `weak`, over the singular posture that is met at about
 * `place`; y and *t: behind it.  LW_OPEN: what comes out has another energy. */
lw_status lw_run_leap(lw_run *run, double good, double weak, double place, double *t, double *y);

lw_status lw_run_driven(lw_run *run);
lw_status lw_run_ggl(lw_run *run);
lw_status lw_run_reduced(lw_run *run);

#endif
