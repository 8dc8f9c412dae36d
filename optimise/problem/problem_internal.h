/* optimise/problem/problem_internal.h - what problem.c, the assignment and the least-squares core share:
 * the scratch of one thread, and residual rows with the inputs of free stations eliminated. */
#ifndef LW_OPTIMISE_PROBLEM_PROBLEM_INTERNAL_H
#define LW_OPTIMISE_PROBLEM_PROBLEM_INTERNAL_H

#include "mbs/batch/batch.h"
#include "mbs/kinematics/closed_motion.h"
#include "optimise/problem/problem.h"

#define LW_CURVE_SAMPLES 64      /* poses over one turn from which an assignment starts            */
#define LW_PROBLEM_TRACER_MAX (1 + LW_ALSO_MAX)
#define LW_PROBLEM_ROW_MAX   (3*LW_PROBLEM_TRACER_MAX)   /* residuals a station has at most: x, y, angle of each point */

/* Of a further point: its lanes, and its curve at the samples. */
typedef struct lw_also_work { lw_jacobian jac; double *curve_x, *curve_y, *curve_u, *curve_v; } lw_also_work;

/* The circuit of a linkage whose input does not turn fully, stroke by stroke.  Over stroke j, of odd number on the way
 * down, from phase `from` on:  input = mid - half cos(psi),  psi = rate phase + shift  in [j pi, (j + 1) pi]. */
typedef struct lw_stroke { double from, mid, half, rate, shift, mode[LW_DYAD_MAX]; } lw_stroke;
typedef struct lw_swing {
    bool      known, closes, has_slopes;   /* of the dimensions `of`: worked out; closes somewhere; by the dimensions */
    double    of[LW_DIM_MAX];
    bool      turning;                     /* the phase is the input, in the mode of stroke 0          */
    int       n;
    double    gain;                        /* of the input over all strokes: whole turns, of a pin       */
    lw_stroke stroke[LW_LEG_MAX];
    double    mid_by[LW_LEG_MAX][LW_DIM_MAX], half_by[LW_LEG_MAX][LW_DIM_MAX];   /* by the dimensions     */
    double    rate_by[LW_LEG_MAX][LW_DIM_MAX], shift_by[LW_LEG_MAX][LW_DIM_MAX];
} lw_swing;

/* A place on it: cos, sin (or displacement) of the input, the input [rad] or [m] and its derivative by the phase,
 * the stroke, the phase within the first turn of it, cos and sin of psi. */
typedef struct lw_cycle_point { double c, s, input, rate, around, psi_c, psi_s; int leg; } lw_cycle_point;

typedef struct lw_work {
    size_t  n, n_lane, ld;       /* stations; lanes (and curve samples when both ways count)       */
    double *phase;               /* where each lane is on its circuit [rad]; the input if that turns */
    double *input, *rate;        /* its input [rad] or [m], and the input's derivative by the phase */
    double *mode;                /* assembly of each lane, where they have their own: mode[dyad*ld + lane] */
    short  *leg;                 /* its stroke                                                     */
    double *around, *psi_c, *psi_s;      /* as of lw_cycle_point                                          */
    double *c, *s;               /* cosine and sine of the input                                   */
    lw_jacobian jac;             /* of every lane                                                  */
    lw_also_work also[LW_ALSO_MAX];
    double *row;                 /* derivatives of residuals, row[(k*n_var + d)*ld + lane]         */
    double *res;                 /* residuals, res[k*ld + lane]                                    */
    int     n_row;               /* residuals a lane                                               */
    bool   *tie;                 /* station whose input moves nothing: not eliminated              */
    double *slide, *slip;        /* eliminated: change of phase = -(slip[k] + sum slide[d*ld+k] dx[d]) */
    double *keep_theta, *best_theta;   /* inputs before a trial step, before an assignment         */
    double *try_theta, *pool;    /* three arrays of ld each for the refinement of inputs           */
    lw_swing swing;
    lw_closed_motion cycle;
    double   least_margin;
    /* the curve, sampled (LW_CURVE_SAMPLES); turn: phases */
    double *turn, *turn_c, *turn_s, *turn_mode, *curve_x, *curve_y, *curve_u, *curve_v, *curve_m;
    double *foot_x, *foot_y;     /* nearest points of the target polygon                           */
    double *normal_x, *normal_y, *by_input;      /* of the samples' distances from them (lanes)     */
    double  sample_weight;
    /* poses in which conditions on the motion are looked at: samples of the turn, or of the way between the stations */
    double *way_c, *way_s, *way_mode;        /* way_mode[dyad*LW_CURVE_SAMPLES + pose]               */
    short  *way_leg;             /* their strokes                                                  */
    double *pose_c, *pose_s, *pose_x, *pose_y, *pose_u, *pose_v, *pose_m;
    lw_jacobian pose;
    double *g_now, *g_up, *g_down;
    double *cost, *best;         /* dynamic programme: station by sample                           */
    short  *from, *order;
    void   *batch;
} lw_work;

/* Point k: what it has to do, and its lanes. */
static inline lw_aim lw_problem_aim(const lw_problem *p, int k)
{
    bool path = p->task != LW_TASK_FUNCTION;
    return k > 0 ? p->also[k - 1]
                 : (lw_aim){ path ? p->x : NULL, path ? p->y : NULL, p->theta, p->wa, p->wb, p->i_tool0 };
}

static inline const lw_jacobian *lw_work_jac(const lw_work *w, int k) { return k > 0 ? &w->also[k - 1].jac : &w->jac; }

/* Margin of lanes, the least over what any point depends on (lanes of the poses at most; pose_x .. pose_v are lost). */
void lw_problem_margin(const lw_problem *p, const lw_lanes *in, lw_work *w, double *margin);

/* Are there conditions besides bounds and linear ones? */
bool lw_problem_is_nonlinear(const lw_problem *p);

/* Are all of them met at x, to `off`? */
bool lw_problem_admissible(const lw_problem *p, const double *x, double off, lw_work *w);

/* Do stations have assembly modes of their own: a circuit through limits? */
bool lw_problem_has_modes(const lw_problem *p);

/* The first length of the plan, what a size is told by; -1: there is none. */
int lw_problem_first_length(const lw_problem *p);

/* After p->branch was changed: what work keeps of it. */
void lw_problem_work_branch(const lw_problem *p, lw_work *w);

/* Constraints at most, whichever branch is chosen. */
size_t lw_problem_constraint_most(const lw_problem *p);

int lw_problem_component_count(const lw_problem *p);

/* Lanes: stations, and curve samples where both ways count. */
size_t lw_problem_lane_count(const lw_problem *p);

/* Fill jac for x at the inputs in w->c, w->s; false when a lane cannot close. */
bool lw_problem_lanes(const lw_problem *p, const double *x, lw_work *w);

/* Of any linkage: does it stay clear of dead points between the stations of w->input, looked at closely? */
bool lw_problem_stays(const lw_problem *p, const double *x, lw_work *w);

/* The input at 0 .. 1 of the way from the first station to the last, or all round; its assembly and stroke. */
double lw_problem_way(const lw_problem *p, const lw_work *w, double share, double *mode, int *leg);

/* Conditions of zones (zone.c): how many, and their values g >= 0 at the inputs that x's stations have. */
size_t lw_zone_count(const lw_problem *p);
void   lw_zone_conditions(const lw_problem *p, const double *x, lw_work *w, double *g);

/* w->swing: the circuit of the linkage x.  Its input turns, or goes from limit to limit, the assembly changing at
 * each.  false when it closes nowhere, or its strokes lead nowhere. */
bool lw_circuit_find(const lw_problem *p, const double *x, lw_work *w);

/* How strokes move with the dimensions at x: what stays at its phase goes with them. */
void lw_circuit_slopes(const lw_problem *p, const double *x, lw_work *w);

/* Derivative of the input of lane k by dimension d at its phase; needs the slopes. */
double lw_circuit_drift(const lw_work *w, size_t k, size_t d);

/* Where a phase lies; the assembly of a stroke into mode[dyad*stride]. */
lw_cycle_point lw_circuit_point(const lw_problem *p, const lw_work *w, double phase);
void    lw_circuit_put_mode(const lw_problem *p, const lw_work *w, int leg, double *mode, size_t stride);

/* Lanes 0 .. n - 1 at their phases. */
void lw_circuit_lanes(const lw_problem *p, lw_work *w, size_t n);

/* One past the last of the lanes from `first` on, of n, that are on its stroke. */
size_t lw_circuit_run(const lw_work *w, size_t first, size_t n);

/* Give lanes of stations their own modes where the circuit has both. */
void lw_circuit_modes(const lw_problem *p, const lw_work *w, lw_lanes *in);

/* Everything of the lanes that follows from their phases; false as lw_circuit_find.  And from x
 * where the timing is prescribed. */
bool lw_problem_turn_stations(const lw_problem *p, const double *x, lw_work *w);
void lw_problem_prescribe(const lw_problem *p, const double *x, lw_work *w);

/* Inputs and jac of every station at x, from scratch; false when it cannot close. */
bool lw_problem_settle(const lw_problem *p, const double *x, lw_work *w);

/* Residuals, and rows of derivatives, from jac.  Where the input of a station is free, the part of
 * its derivatives that a change of the input makes up for is taken out (variable projection,
 * Kaufman 1975).  Returns f, the sum of squares. */
double lw_problem_rows(const lw_problem *p, const double *x, lw_work *w, bool derivatives);

/* How the weighted residuals of station k change with its input; returns the square of that. */
double lw_problem_tangent(const lw_problem *p, const lw_work *w, size_t k, double t[LW_PROBLEM_ROW_MAX]);

/* The curve at LW_CURVE_SAMPLES inputs. */
void lw_timing_sample(const lw_problem *p, const double *x, lw_work *w);

/* The inputs of free stations from scratch: the best monotone assignment to curve samples. */
bool lw_timing_assign(const lw_problem *p, const double *x, lw_work *w);

/* Improve them by Newton steps that keep the order, until they rest or `steps` are used up; the best are kept.
 * jac is that of the inputs left behind. false when the linkage cannot close there. */
bool lw_timing_refine(const lw_problem *p, const double *x, lw_work *w, int steps);

/* Move inputs to the nearest ones in order, one turn at most from first to last (least weighted squares;
 * pool adjacent violators, round the turn). */
void lw_timing_order(const lw_problem *p, double *theta, const double *weight, double *scratch);

/* Timing none: nearest points of the target polygon to the curve samples x, y. */
void lw_timing_samples(const lw_problem *p, lw_work *w, const double *x, const double *y);

/* Does the order hold station k and the next one (after the last, the first a turn on) at one input? */
bool lw_timing_joined(const lw_problem *p, const lw_work *w, size_t k);

/* Rows of derivatives with the inputs of stations eliminated; tie, slip and slide. */
void lw_variable_projection(const lw_problem *p, const double *x, lw_work *w);

#endif
