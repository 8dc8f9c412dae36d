/* optimise/problem/problem.h - one fitting problem, as every solver sees it.
 *
 *     f(x) = sum over stations of  w { a |P - T|^2 + b (alpha - theta)^2 }   (Makkonen 1999, eq. 17)
 *
 * x holds the dimensions of the plan, and after them, if the task has them, the input angle of station 0 (`input0`)
 * and the mounting angle of the tool (`tool0`). Internally the target is moved to the origin and scaled to size one,
 * so that coordinates of any size are equally accurate.
 *
 * Further points of the target add their own terms; all points share the input of the station. Each further point lies
 * on its link (optimise/problem/tracers.h) and has its own mounting angle (`tool2`, ...) if it has a theta.
 *
 * Timing. prescribed: the input angle of station i is input0 + angle[i], of a function also input0 - angle[i]; with
 * gears that repeat only after several turns, the inputs are divided by lw_plan.input_turns_per_period. free: each
 * station takes its best input, in the order of the stations (a monotone assignment, one turn at most). none: the
 * nearest points in both directions: from station to curve and from curve to target polygon. f includes this
 * assignment and is differentiable through it (envelope theorem).
 *
 * Conditions are g(x) >= 0: first the linear ones (rows of `linear`), then the others. */
#ifndef LW_OPTIMISE_PROBLEM_PROBLEM_H
#define LW_OPTIMISE_PROBLEM_PROBLEM_H

#include <stdint.h>
#include "optimise/problem/family.h"

#define LW_VAR_MAX    (LW_DIM_MAX + 2 + LW_ALSO_MAX)
#define LW_LINEAR_MAX 128
#define LW_FEW_STATIONS  15           /* so few leave dimensions free, of which more links have more                   */
#define LW_CURVE_SAMPLES 64           /* postures of one turn or circuit: samples of the curve, checks of the motion  */
#define LW_ZONE_SAMPLES  24           /* steps of the motion at which forbidden zones are checked                  */
#define LW_PROBLEM_TRACER_MAX (1 + LW_ALSO_MAX)
/* greatest number of residuals of a station: x, y, angle of each point */
#define LW_PROBLEM_ROW_MAX   (3*LW_PROBLEM_TRACER_MAX)
/* Linear conditions keep this distance (scaled) from their limit: at the change point itself two motion curves cross,
 * and the linkage may follow either. */
#define LW_LINEAR_LEAST 1e-6

/* The motion that a linkage is intended to make. */
typedef struct lw_intended_motion {
    double mode[LW_MODE_MAX];            /* assembly modes, see mbs/plan/plan.h                         */
    /* +1: stations follow a rising input, -1: a falling one.  Of a function -1 means inputs input0 - angle */
    int    sense;
    bool   turns;                        /* the input must turn fully                              */
    /* of any linkage whose input does not turn fully: the range mid +- half in which it must close, [rad] or scaled */
    double mid, half;
    bool   through;                    /* instead of that range, the circuit through `mid` in `mode`, past its limits */
} lw_intended_motion;

/* Targets of one point at the stations, scaled. */
typedef struct lw_aim {
    double *x, *y;                       /* NULL: not part of the task (n)                         */
    double *theta;                       /* tool angle [rad]; NULL: not part of the task (n)       */
    double *wa, *wb;                     /* sqrt(a w), sqrt(b w)                             (n)   */
    int     i_tool;                      /* variable: the tool's mounting angle; -1                */
} lw_aim;

/* A length between two points of one link that is no variable: at most, or at least, a limit; or at least the longest length over
 * `ratio`, if that is not 0.  from, to: variables that are the coordinates of the points; -1: the coordinate is 0. */
#define LW_SIDE_MAX 96
typedef struct lw_side { int from[2], to[2]; bool most; double limit, ratio; } lw_side;

typedef struct lw_problem {
    const lw_family *family;
    lw_plan      plan;
    lw_intended_motion intended;          /* of this run                                            */
    bool         must_turn;              /* the input must turn fully, whatever is drawn           */
    bool         within_limits;          /* the input passes no limit: one assembly mode all along */
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
    double      *along;                  /* length of the polygon up to each station, and of all of it; 0 without places (n + 1) */
    int          n_also;                 /* further points; outputs 1, 2, ... of the plan          */
    lw_aim       also[LW_ALSO_MAX];
    double      *c, *s;                  /* cos, sin of the prescribed input angles, or NULL       */
    double      *angle;                  /* those angles [rad], or NULL                            */
    bool         closed;
    void        *store;
    /* variables */
    int          n_dim, n_var, i_input0, i_tool0;          /* -1: missing                          */
    double       lo[LW_VAR_MAX], hi[LW_VAR_MAX];           /* bounds, scaled; may be infinite      */
    int          n_linear;                                  /* linear[j] . x >= LW_LINEAR_LEAST     */
    double       linear[LW_LINEAR_MAX][LW_VAR_MAX];
    int          ratio_row, n_ratio_row;                    /* those that bound the ratio of two lengths  */
    int          n_side, n_side_known;                      /* conditions; and with those that may be added (n_side = n_side_known) */
    lw_side      side[LW_SIDE_MAX];
    bool         transmission_is_soft;                     /* linkages with less are better than none */
    double       min_transmission, max_acceleration;       /* scaled; 0: no such condition         */
    size_t       n_zone_condition;                       /* conditions of the zones                */
    int          n_zone;
    lw_zone      zone[LW_ZONE_MAX];                         /* scaled                               */
} lw_problem;

/* Targets of point k; 0: the first. */
static inline lw_aim lw_problem_aim(const lw_problem *p, int k)
{
    bool path = lw_task_has_place(p->task);
    return k > 0 ? p->also[k - 1]
                 : (lw_aim){ path ? p->x : NULL, path ? p->y : NULL, p->theta, p->wa, p->wb, p->i_tool0 };
}

/* The point of a link with these variables as coordinates in its frame; -1: 0. */
static inline lw_vec2 lw_point_on_link(const double *x, const int of[2])
{
    return lw_v2(of[0] >= 0 ? x[of[0]] : 0, of[1] >= 0 ? x[of[1]] : 0);
}

/* A short link beside a long one multiplies play and tolerances.  Up to a ratio of LW_EVEN this costs nothing; beyond, the linkage
 * counts as larger by this factor. */
#define LW_EVEN 8
static inline double lw_uneven(double longest, double shortest)
{
    return fmax(1, longest/(LW_EVEN*shortest));
}

/* Size of a linkage, scaled: greatest distance between a pin and another pin or tracer of its link, or greatest coordinate on a link.
 * A function has no length to compare with: of its linkage the ratio of the longest to the shortest length. */
double lw_problem_size(const lw_problem *p, const double *x);
/* Lower the upper bounds of what makes the size to `most`. */
void   lw_problem_limit_size(lw_problem *p, double most);

/* The factor lw_uneven of the lengths that are variables. */
double lw_problem_uneven(const lw_problem *p, const double *x);

const char *lw_problem_variable(const lw_problem *p, int i);         /* its name                   */
int         lw_problem_index(const lw_problem *p, const char *name); /* -1: no such variable       */

/* Variable of the first length, which gives the size of the linkage; -1: there is none. */
int lw_problem_first_length(const lw_problem *p);

/* Does each station have its own assembly modes, because the input passes limits? */
bool lw_problem_has_modes(const lw_problem *p);

/* May the input of a function turn either way? Then intended.sense says which. */
static inline bool lw_problem_turns_either_way(const lw_problem *p)
{
    return !lw_task_has_place(p->task) && p->datum == LW_DATUM_FREE;
}

/* Number of residuals of one station. */
int lw_problem_component_count(const lw_problem *p);

/* Number of lanes, the inputs at which postures are computed together: stations; curve samples for timing none. */
size_t lw_problem_lane_count(const lw_problem *p);

/* The fixed pivots in the ground frame, whose origin is the first pivot: their places, and the variables that are their
 * coordinates (-1: the coordinate is 0). */
typedef struct lw_pivots { int n, of[LW_DIM_MAX + 1][2]; lw_vec2 at[LW_DIM_MAX + 1]; } lw_pivots;
void lw_problem_fixed_pivots(const lw_problem *p, const double *x, lw_pivots *v);

/* Are there constraints besides bounds and linear ones?  Is closing at every station one of them? */
bool lw_problem_is_nonlinear(const lw_problem *p);
bool lw_problem_must_close(const lw_problem *p);

/* Greatest number of constraints over all intended motions. */
size_t lw_problem_constraint_most(const lw_problem *p);

/* Make the problem of fitting one family, in one assembly mode and sense, to a target. LW_E_ARG with a text: bounds
 * that exclude everything, a task that needs other columns of the target, ... LW_E_KIND: this family cannot do this
 * task (a slider input has no crank angle to prescribe). */
lw_status lw_problem_make(const lw_target *t, const lw_fit_spec *s, const lw_family *family,
                          double mode, int sense, lw_problem *p, lw_error *e);
void      lw_problem_free(lw_problem *p);

/* Convert variables into dimensions in the user's frame and SI units, and back. */
void lw_problem_to_dims(const lw_problem *p, const double *x, double *dim);
void lw_problem_from_dims(const lw_problem *p, const double *dim, double *x);

/* Scratch for the calls below: opaque memory of this size for each thread, 64-byte aligned; call _init once before the
 * first use. It stores the last assignment but nothing that changes a result. */
size_t lw_problem_work_size(const lw_problem *p);
void   lw_problem_work_init(const lw_problem *p, void *work);

/* f(x), and its gradient (n_var) unless grad is NULL. INFINITY: the linkage cannot close at a station (prescribed
 * timing) or not at all; grad is then the direction in which the closure error decreases. */
double lw_problem_value(const lw_problem *p, const double *x, double *grad, void *work);

/* Residuals r (n_residual) with f = sum r^2, and their derivatives j[i*n_var + d] (may be NULL). False: f is INFINITY.
 */
size_t lw_problem_residual_count(const lw_problem *p);
bool   lw_problem_residuals(const lw_problem *p, const double *x, double *r, double *j, void *work);

/* Conditions g(x) >= 0 (n_constraint) and their derivatives j[i*n_var + d] (may be NULL): linear conditions, lengths
 * between points of a link, closure at prescribed stations, transmission, acceleration, zones. All are of order one.
 * Derivatives are exact but for the input's part of accelerations (differences of fourth order) and for margins of
 * higher groups (central differences). */
size_t lw_problem_constraint_count(const lw_problem *p);

/* Postures whose transmission angles are conditions: of a four-link chain whose input turns the four at multiples of 90 degrees
 * in the ground frame, where they have their extremes; else LW_CURVE_SAMPLES. */
size_t lw_problem_transmission_postures(const lw_problem *p);
void   lw_problem_constraints(const lw_problem *p, const double *x, double *g, double *j, void *work);

#endif
