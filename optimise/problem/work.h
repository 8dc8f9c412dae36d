/* optimise/problem/work.h - the scratch of one thread for one problem; the caller provides the memory. */
#ifndef LW_OPTIMISE_PROBLEM_WORK_H
#define LW_OPTIMISE_PROBLEM_WORK_H

#include "mbs/batch/batch.h"
#include "mbs/kinematics/closed_motion.h"
#include "optimise/problem/problem.h"

/* For a further point: its lanes, and its curve at the samples. */
typedef struct lw_also_work { lw_jacobian jac; double *curve_x, *curve_y, *curve_u, *curve_v; } lw_also_work;

/* The circuit of a linkage whose input does not turn fully, stroke by stroke. On odd strokes the input decreases. On
 * stroke j, from phase `from` on: input = mid - half cos(psi), psi = rate phase + shift in [j pi, (j + 1) pi]. */
typedef struct lw_stroke { double from, mid, half, rate, shift, mode[LW_DYAD_MAX]; } lw_stroke;
typedef struct lw_swing {
    bool      known, closes, has_slopes;   /* for the dimensions `of`: computed; closes somewhere; slopes computed */
    double    of[LW_DIM_MAX];
    bool      turning;                     /* the phase is the input, in the mode of stroke 0          */
    int       n;
    double    gain;                        /* change of the input over all strokes: whole turns of a pin */
    lw_stroke stroke[LW_LEG_MAX];
    double    mid_by[LW_LEG_MAX][LW_DIM_MAX], half_by[LW_LEG_MAX][LW_DIM_MAX];   /* derivatives by the dimensions */
    double    rate_by[LW_LEG_MAX][LW_DIM_MAX], shift_by[LW_LEG_MAX][LW_DIM_MAX];
} lw_swing;

/* A point of the circuit: cos, sin (or displacement) of the input, the input [rad] or [m] and its derivative by the
 * phase, the stroke, the phase within its first turn, cos and sin of psi. */
typedef struct lw_cycle_point { double c, s, input, rate, around, psi_c, psi_s; int leg; } lw_cycle_point;

/* Pins and tracers whose places are checked. */
#define LW_PLACE_MAX (LW_JOINT_MAX + 1 + LW_ALSO_MAX)

#define LW_COST_ROW (LW_CURVE_SAMPLES + 8)

/* Consecutive stations; the first follows the last. */
typedef struct lw_block { size_t first, count; } lw_block;

typedef struct lw_work {
    size_t  n_lane, ld;          /* lanes (with curve samples for timing none)           */
    double *phase;               /* phase of each lane on its circuit [rad]; if the input turns fully, the input */
    double *input, *rate;        /* its input [rad] or [m], and the input's derivative by the phase */
    double *mode;                /* modes of each lane, if lanes have their own: mode[dyad*ld + lane] */
    short  *leg;                 /* its stroke                                                     */
    double *around, *psi_c, *psi_s;      /* as in lw_cycle_point                                          */
    double *c, *s;               /* cosine and sine of the input                                   */
    lw_jacobian jac;             /* of every lane                                                  */
    lw_also_work also[LW_ALSO_MAX];
    double *row;                 /* derivatives of residuals, row[(k*n_var + d)*ld + lane]         */
    double *res;                 /* residuals, res[k*ld + lane]                                    */
    int     n_row;               /* residuals per lane                                             */
    double *base_res;            /* residuals at the point that a bent step begins from            */
    /* written by lw_variable_projection */
    double *tangent;             /* derivatives of residuals by the phase, 0 where stations are not eliminated; as res */
    double *tangent2;            /* sum of their squares, of the stations of a block; 1 where they are 0 */
    lw_block *block;             /* blocks of two or more stations that have one input and move together (n_block) */
    size_t  n_block;
    bool   *tie;                 /* stations whose input moves nothing: not eliminated             */
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
    /* postures in which conditions on the motion are checked: of the turn, or of the motion between the stations */
    double *check_c, *check_s;
    lw_cycle_point *check_at;
    double *place_x, *place_y;             /* of pins and tracers, place*LW_CURVE_SAMPLES + posture              */
    double *slope[4];                      /* derivatives in these postures: (n_dim + 1) rows, the last by the input */
    double *posture_c, *posture_s, *posture_x, *posture_y, *posture_u, *posture_v, *posture_m;
    lw_jacobian posture;
    double *g_now, *g_row;         /* conditions; their derivatives, g_row[i*n_var + d]               */
    double *g_try, *g_try_row;     /* those of a trial step                                           */
    double *step_h;                /* its quadratic model: four matrices of (n_var)^2                  */
    double *step_a, *step_b;       /* conditions on a step of a solver: rows a (n_var), a . step >= b  */
    short  *step_first, *step_column;      /* their nonzero coefficients, as lw_qp_rows has them         */
    double *cost, *least;        /* dynamic programme: station by sample (LW_COST_ROW); as lw_batch_in_order */
    short  *order;
    void   *batch, *registers;   /* of lw_random_linkage_draw: n_reg rows of LW_CURVE_SAMPLES complex numbers */
} lw_work;

static inline const lw_jacobian *lw_work_jac(const lw_work *w, int k) { return k > 0 ? &w->also[k - 1].jac : &w->jac; }

/* Recompute what depends on p->intended, after that has changed. */
void lw_problem_work_intended(const lw_problem *p, lw_work *w);

#endif
