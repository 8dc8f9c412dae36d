/* mbs/space/space_trace.h - paths of the tracers of a spatial model over its input, or in time. */
#ifndef LW_MBS_SPACE_SPACE_TRACE_H
#define LW_MBS_SPACE_SPACE_TRACE_H

#include <signal.h>
#include "mbs/space/space_follow.h"

typedef lw_frame_motion lw_space_tracer;         /* rates are by the input, or by time; NAN at a limit of the input */

/* One row; the arrays hold until the next one.  u: the input [rad] or [m], or the time [s]. */
typedef lw_status lw_space_row_sink(void *context, double u, const double *input, const lw_space_tracer *tracer);

typedef struct lw_space_trace {
    bool   in_time;                              /* u is the time; else the first input, all others stand still */
    double from, to;
    bool   whole;                                /* without from and to: the range of the input, or what is possible */
    int    intervals;
    const volatile sig_atomic_t *stop;           /* may be NULL                                        */
    bool   limit[2];                             /* out: an end is a limit of the motion               */
    int    away[2];                              /* out: there this link slides away without bound; -1: none */
    double distance[2];                          /* out: where rows end it is so many times the size of the model from its place in the file */
    double moved, turned;                        /* out: joints were adjusted by so much (mbs/space/space_adjust.h) */
    bool   lost;                                 /* out: between these values of u, the first time, the drives lose the model: it can move there while */
    double lost_at[2];                           /* they stand still (mbs/space/space_hold.h) */
    char   lost_how[240];                        /* in this way, if it is not empty */
    double open;                                 /* out: greatest residual of a joint, lengths over the size of the model, radians */
} lw_space_trace;

/* LW_OPEN: a limit or a singular posture lies before the end, as the text says; rows before it have been handed out.
 * LW_E_ARG: the inputs do not fit the freedoms; LW_STOPPED. */
lw_status lw_space_trace_run(const lw_spatial *m, lw_space_trace *o, lw_space_row_sink *sink, void *context, lw_error *e);

/* Motion of all tracers at a posture (n_q) with rates v, a (n_v). */
void lw_space_tracers(const lw_space *s, const lw_space_frame *frame, const double *q, const double *v, const double *a,
                      lw_space_tracer *out);

#endif
