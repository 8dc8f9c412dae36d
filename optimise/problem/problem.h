/* optimise/problem/problem.h - one fitting problem, as every solver sees it.
 *
 *     f(x) = sum over stations of  w { a |P - T|^2 + b (alpha - theta)^2 }   (Makkonen 1999, eq. 17)
 *
 * x holds the dimensions of the plan, and behind them, where the task has them, the input angle of
 * station 0 (`input0`) and the mounting angle of the tool (`tool0`).  Inside, the target is moved to
 * the origin and scaled to size one, so that coordinates around 1e9 or 1e-9 are as good as any.
 *
 * Further points of the target add their own terms, with the input of the station in common; each lies on its link
 * (optimise/problem/tracers.h) and has a mounting angle of its own (`tool2`, ...) where it has a theta.
 *
 * Timing.  prescribed: the input angle of station i is input0 + angle[i]; with gears that come back after several
 * turns the three are divided by lw_plan.input_turns_per_period.  free: each station takes the input that suits it
 * best, in the order of the stations (a monotone assignment, one turn at most).  none: the nearest points, both
 * ways: station to curve and curve to target polygon.
 * The assignment is part of f, worked out inside; f is differentiable through it (envelope theorem).
 *
 * Subsidiary conditions are g(x) >= 0: first the linear ones (rows of `linear`), then the others. */
#ifndef LW_OPTIMISE_PROBLEM_PROBLEM_H
#define LW_OPTIMISE_PROBLEM_PROBLEM_H

#include <stdint.h>
#include "optimise/problem/family.h"

#define LW_VAR_MAX    (LW_DIM_MAX + 2 + LW_ALSO_MAX)
#define LW_LINEAR_MAX 128
#define LW_CURVE_SAMPLES 64           /* poses of one turn or circuit: samples of the curve, checks of the motion  */
#define LW_ZONE_SAMPLES  24           /* steps of the motion at which forbidden zones are checked                  */
#define LW_PROBLEM_TRACER_MAX (1 + LW_ALSO_MAX)
#define LW_PROBLEM_ROW_MAX   (3*LW_PROBLEM_TRACER_MAX)   /* residuals of a station at most: x, y, angle of each point */
/* Linear conditions keep this distance (scaled) from their limit: at the change point itself two
 * branches cross and nobody can say which one a linkage follows. */
#define LW_LINEAR_LEAST 1e-6

/* Which of its motions a linkage is meant to make. */
typedef struct lw_intended_motion {
    double mode[LW_MODE_MAX];            /* assembly, see mbs/plan/plan.h                               */
    int    sense;                        /* +1: stations follow a rising input, -1: a falling one  */
    bool   turns;                        /* the input must turn fully                              */
    double mid, half;                    /* of any linkage whose input does not: its way, mid +- half, in
                                          * which it must close, [rad] or scaled                   */
    bool   through;                      /* over its limits instead, the circuit through `mid` in `mode` */
} lw_intended_motion;

/* What one point has to do at the stations, scaled. */
typedef struct lw_aim {
    double *x, *y;                       /* NULL: not asked for                              (n)   */
    double *theta;                       /* tool angle [rad]; NULL: not asked for            (n)   */
    double *wa, *wb;                     /* sqrt(a w), sqrt(b w)                             (n)   */
    int     i_tool;                      /* variable: the tool's mounting angle; -1                */
} lw_aim;

typedef struct lw_problem {
    const lw_family *family;
    lw_plan      plan;
    lw_intended_motion intended;          /* of this run                                            */
    bool         must_turn;              /* the input has to turn fully, whatever is drawn         */
    lw_task      task;
    lw_timing    timing;
    lw_datum     datum;
    double       a, b;                   /* for the scaled target                                  */
    double       scale;                  /* objective in the user's units = scale * f              */
    lw_vec2      origin;                 /* user's point = origin + unit * scaled point            */
    double       unit;
    /* stations, scaled; owned by the problem's creator (n) */
    size_t       n;
    double      *x, *y, *theta, *w;      /* theta NULL: no tool angle                              */
    double      *wa, *wb;                /* sqrt(a w), sqrt(b w)                                   */
    int          n_also;                 /* further points; outputs 1, 2, ... of the plan          */
    lw_aim       also[LW_ALSO_MAX];
    double      *c, *s;                  /* cos, sin of the prescribed input angles, or NULL       */
    double      *angle;                  /* those angles [rad], or NULL                            */
    bool         closed;
    void        *store;
    /* variables */
    int          n_dim, n_var, i_input0, i_tool0;          /* -1: not there                        */
    double       lo[LW_VAR_MAX], hi[LW_VAR_MAX];           /* bounds, scaled; may be infinite      */
    int          n_linear;                                  /* linear[j] . x >= LW_LINEAR_LEAST     */
    double       linear[LW_LINEAR_MAX][LW_VAR_MAX];
    double       min_transmission, max_acceleration;       /* scaled; 0: not asked                 */
    int          n_zone;
    lw_zone      zone[LW_ZONE_MAX];                         /* scaled                               */
} lw_problem;

/* What point k has to do; 0: the first. */
static inline lw_aim lw_problem_aim(const lw_problem *p, int k)
{
    bool path = lw_task_has_place(p->task);
    return k > 0 ? p->also[k - 1]
                 : (lw_aim){ path ? p->x : NULL, path ? p->y : NULL, p->theta, p->wa, p->wb, p->i_tool0 };
}

const char *lw_problem_variable(const lw_problem *p, int i);         /* its name                   */
int         lw_problem_index(const lw_problem *p, const char *name); /* -1: no such variable       */

/* Variable of the first length, which stands for the size of the linkage; -1: there is none. */
int lw_problem_first_length(const lw_problem *p);

/* Do the stations have assembly modes of their own, because the input goes over limits? */
bool lw_problem_has_modes(const lw_problem *p);

/* Residuals of one station. */
int lw_problem_component_count(const lw_problem *p);

/* Lanes, the inputs at which poses are found at once: stations, and curve samples where both ways count. */
size_t lw_problem_lane_count(const lw_problem *p);

/* Fixed pivots: their places in the ground frame, whose origin is the first.  Returns their number, at most
 * LW_DIM_MAX + 1. */
int lw_problem_fixed_pivots(const lw_problem *p, const double *x, lw_vec2 *at);

/* Are there constraints besides bounds and linear ones?  Is closing at every station one of them? */
bool lw_problem_is_nonlinear(const lw_problem *p);
bool lw_problem_must_close(const lw_problem *p);

/* Constraints of the zones; constraints at most, whichever motion is intended. */
size_t lw_problem_zone_count(const lw_problem *p);
size_t lw_problem_constraint_most(const lw_problem *p);

/* Make the problem of fitting one family, in one assembly mode and sense, to a target.
 * LW_E_ARG with a text: bounds that exclude everything, a task the target has no columns for, ...
 * LW_E_KIND: this family cannot do this task (a slider input has no crank angle to prescribe). */
lw_status lw_problem_make(const lw_target *t, const lw_fit_spec *s, const lw_family *family,
                          double mode, int sense, lw_problem *p, lw_error *e);
void      lw_problem_free(lw_problem *p);

/* Dimensions in the user's frame and SI from variables, and back. */
void lw_problem_to_dims(const lw_problem *p, const double *x, double *dim);
void lw_problem_from_dims(const lw_problem *p, const double *dim, double *x);

/* Scratch for the calls below.  Opaque memory of this size, one a thread, 64-byte aligned;
 * _init once before the first use. It remembers the last assignment, nothing that changes an answer. */
size_t lw_problem_work_size(const lw_problem *p);
void   lw_problem_work_init(const lw_problem *p, void *work);

/* f(x), and its gradient (n_var) when grad is given.  INFINITY when the linkage cannot close at some
 * station (prescribed timing) or not at all; grad is then the direction that lessens the opening. */
double lw_problem_value(const lw_problem *p, const double *x, double *grad, void *work);

/* Residuals r (n_residual) with f = sum r^2, and their derivatives j[i*n_var + d] (may be NULL).
 * false where f is INFINITY. */
size_t lw_problem_residual_count(const lw_problem *p);
bool   lw_problem_residuals(const lw_problem *p, const double *x, double *r, double *j, void *work);

/* Subsidiary conditions g(x) >= 0 (n_constraint) and their derivatives j[i*n_var + d] (may be NULL):
 * the linear ones, the opening of prescribed stations, transmission, acceleration. All of order one. */
size_t lw_problem_constraint_count(const lw_problem *p);
void   lw_problem_constraints(const lw_problem *p, const double *x, double *g, double *j, void *work);

#endif
