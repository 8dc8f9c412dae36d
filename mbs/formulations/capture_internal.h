/* mbs/formulations/capture_internal.h - a step of captured contacts (capture.c tells the method); internal to mbs/. */
#ifndef LW_MBS_FORMULATIONS_CAPTURE_INTERNAL_H
#define LW_MBS_FORMULATIONS_CAPTURE_INTERNAL_H

#include "base/sparse_lu.h"
#include "mbs/dynamics/touch_internal.h"
#include "mbs/run/run_internal.h"

/* A gap below this fraction of the distance moved in a step is closed. */
static const double lw_capture_closed = 1e-2;
/* An overlap below this fraction of it is captured at any time of the step; so is an impact slower than this fraction of what forces change in a step. */
static const double lw_capture_shallow = 0.1;
/* Rates below this times the speed count as 0. */
static const double lw_capture_exact = 1e-8;

/* A place in the pattern: its index, the first of its rows (gap, then slip if it has friction), its state. */
typedef struct lw_capture_place {
    int    touch, row;
    bool   rubs, shut, presses, pressed;     /* shut: closed in the middle of the step; pressed: before the step */
    int    slips;                            /* 0: sticks */
    double mu, normal, across;               /* impulses */
    double target, glide;                    /* least rate of the gap; rate of the slip while it sticks */
    double closes;                           /* rate in the middle with which a place that did not press closes at the end of the step */
    double pull;                             /* change of the rate of the gap that the forces on its two bodies cause in the step, at most */
} lw_capture_place;

typedef struct lw_capture {
    lw_run *run;
    lw_dynamics *d;
    int     n, n_kept, *kept;                /* places in the pattern; independent rows of the joints */
    lw_capture_place *at, *before;                     /* before: as they were before the step, */
    double work_before;                      /* and `work`, for repeats */
    double  part;                            /* way of a body in a step over `size`; change of a state in it */
    double  size, *arm;                      /* extents of the smallest body that touches, and of each body (n_q/3), scaled */
    double *q, *v, *after, *next_q, *next_v, *still, *momentum, *wanted, *force, *full, *push, *stiffest;
    lw_columns pattern;                      /* of the system, */
    lw_sparse_lu *lu;                        /* its factors, */
    double *value;                           /* its entries: where pairs of rows and their own products go */
    int    *to, *diagonal;
    bool    hits;                            /* a step ended at an impact, which is still to be applied */
    int     soon;                            /* impacts so far that followed the one before them within a small part of a step */
    int     strikes;                         /* the place that strikes at the end of the step and is open until then (index in the list), else -1 */
    double  rest;                            /* speed of the fastest bounce so far that counts as rest, scaled */
    double  late;                            /* the step captures an impact: its length, else 0 */
    double  t, work, power;                  /* power of forces without potential after the impacts of the step [W] */
    double *z, *next_z, *mean_z, *try_z, *rate, *other;      /* first-order states, their mean over a step, their rates (n_z) */
} lw_capture;

/* Move the states z (n_z) over `whole` from t on, at (q, v); mean (n_z, unless NULL): their mean. */
lw_status lw_capture_move_states(lw_capture *g, double t, double whole, const double *q, const double *v, double *z, double *mean);

/* The acceleration of a gap that the forces on its two bodies cause, at most. */
double    lw_capture_pull_on(const lw_capture *g, const lw_touch *p, const lw_touch_motion *m);

/* Does a corner pass the end of a face, instead of striking it after the time `in`? */
bool      lw_capture_slides_off(const lw_capture *g, const lw_touch *p, const lw_touch_motion *m, double in);

/* One step of length h from (t, q, v, z): next_q, next_v, next_z; d->a and d->l are means over it.  *overlap: the greatest one so far, scaled.
 * LW_OPEN: no forces were found; a shorter step may have some. */
lw_status lw_capture_step(lw_capture *g, double h, double *overlap);

/* Of that step: does a place press that did not before?  Has it ended with too great an overlap at a place that does not press?  Has it missed the impact of
 * place g->strikes, so that it is to be repeated with the corrected length *h? */
bool      lw_capture_closes_one(const lw_capture *g);
bool      lw_capture_overlaps_unseen(const lw_capture *g);
bool      lw_capture_miss(lw_capture *g, double *h);

/* Apply the impact at which a step of length h has ended. */
lw_status lw_capture_hit(lw_capture *g, double h, double *overlap);

void      lw_capture_clear_row(lw_dynamics *d, int row);

#endif
