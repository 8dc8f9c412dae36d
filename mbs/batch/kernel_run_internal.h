/* mbs/batch/kernel_run_internal.h - the registers of a block of lanes, the loops over it, and the functions that the
 * kernel files share.
 *
 * Every mbs/batch/kernel*.c is compiled once per instruction set (LW_ISA, see the Makefile).  Functions with external
 * linkage have the instruction set in their names.  All others are static, so that no code of one set runs in
 * another. */
#ifndef LW_MBS_BATCH_KERNEL_RUN_INTERNAL_H
#define LW_MBS_BATCH_KERNEL_RUN_INTERNAL_H

#include <string.h>
#include "mbs/batch/kernels_internal.h"
#include "mbs/plan/sincos_internal.h"

#define LW_PASTE(name, isa)  name##_##isa
#define LW_OF_ISA(name, isa) LW_PASTE(name, isa)
#define lw_kernels_here      LW_OF_ISA(lw_kernels, LW_ISA)
#define lw_forward           LW_OF_ISA(lw_forward, LW_ISA)
#define lw_forward_step      LW_OF_ISA(lw_forward_step, LW_ISA)
#define lw_backward          LW_OF_ISA(lw_backward, LW_ISA)
#define lw_seed_margin       LW_OF_ISA(lw_seed_margin, LW_ISA)
#define lw_higher_forward    LW_OF_ISA(lw_higher_forward, LW_ISA)
#define lw_higher_backward   LW_OF_ISA(lw_higher_backward, LW_ISA)
#define lw_in_chunks         LW_OF_ISA(lw_in_chunks, LW_ISA)
#define lw_follow_size       LW_OF_ISA(lw_follow_size, LW_ISA)
#define lw_higher_size       LW_OF_ISA(lw_higher_size, LW_ISA)
#define lw_kernel_group_posture       LW_OF_ISA(lw_kernel_group_posture, LW_ISA)
#define lw_kernel_normal     LW_OF_ISA(lw_kernel_normal, LW_ISA)
#define lw_kernel_nearest    LW_OF_ISA(lw_kernel_nearest, LW_ISA)
#define lw_kernel_costs      LW_OF_ISA(lw_kernel_costs, LW_ISA)
#define lw_kernel_in_order   LW_OF_ISA(lw_kernel_in_order, LW_ISA)
#define lw_fast_points       LW_OF_ISA(lw_fast_points, LW_ISA)
#define lw_fast_jacobian     LW_OF_ISA(lw_fast_jacobian, LW_ISA)
#define lw_fast_sum          LW_OF_ISA(lw_fast_sum, LW_ISA)

/* A loop over whole groups of lanes, so that the compiler needs no code for a remainder.  Lanes are independent: no
 * lane reads a number that another one writes. */
#if defined(__clang__)
#define LW_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define LW_INDEPENDENT _Pragma("GCC ivdep")
#endif
#define LW_LANES(n) LW_INDEPENDENT for (size_t i = 0, end = (n)/LW_GROUP*LW_GROUP; i < end; i++)

/* A block of lanes.  Rows have nb doubles.  Dimension d of lane i is dim[d*dim_row + i], or dim[d] when the lanes share
 * one set (then dim_row is 1). */
typedef struct run {
    const lw_plan *plan;
    size_t nb;
    const double *c, *s;
    const double *dim, *mode;
    size_t dim_row, mode_row;
    double *reg, *margin, *spare;            /* registers: a row of x, a row of y          */
    double *aux;                             /* for each dyad: reciprocals of its root     */
    double *turn;                            /* cosines and sines of the angles            */
    size_t turn_row;
    double *bar;                             /* adjoints of the registers                  */
    double *row;                             /* derivatives by the dimensions              */
    size_t row_row;
    double *spread_dim, *spread_mode;        /* one set copied to every lane               */
    double *tail;                            /* the padded last group                      */
    double *inverse;                         /* inverse Jacobians of the higher groups             */
    void *group;                             /* scratch of one higher group, lw_kernels.group_size */
    const double *group_postures;            /* postures of the higher groups in the lanes of a chunk */
    const double *group_posture;             /* the same from this block on: n_row rows, then a row of the  */
    size_t group_posture_row;                /* distance by which the input is out of reach, else 0; row length */
} run;

LW_INLINE double *reg_x(const run *k, int r) { return k->reg + 2*(size_t)r*k->nb; }
LW_INLINE double *reg_y(const run *k, int r) { return reg_x(k, r) + k->nb; }
LW_INLINE double *bar_x(const run *k, int r) { return k->bar + 2*(size_t)r*k->nb; }
LW_INLINE double *bar_y(const run *k, int r) { return bar_x(k, r) + k->nb; }
LW_INLINE double *aux_row(const run *k, int dyad) { return k->aux + (size_t)dyad*k->nb; }
LW_INLINE double *dim_bar(const run *k, int d) { return d < 0 ? k->spare : k->row + (size_t)d*k->row_row; }
LW_INLINE const double *dim_of(const run *k, int d) { return d < 0 ? reg_x(k, 0) : k->dim + (size_t)d*k->dim_row; }
LW_INLINE const double *mode_of(const run *k, int dyad) { return k->mode + (size_t)dyad*k->mode_row; }
LW_INLINE const double *cos_of(const run *k, int angle) { return k->turn + 2*(size_t)angle*k->turn_row; }
LW_INLINE const double *sin_of(const run *k, int angle) { return cos_of(k, angle) + k->turn_row; }

/* Two rows that hold a point or a direction. */
typedef struct in_rows { const double *x, *y; } in_rows;
typedef struct out_rows { double *x, *y; } out_rows;

LW_INLINE in_rows in_reg(const run *k, int r) { return (in_rows){ reg_x(k, r), reg_y(k, r) }; }
LW_INLINE out_rows out_reg(const run *k, int r) { return (out_rows){ reg_x(k, r), reg_y(k, r) }; }
LW_INLINE in_rows in_bar(const run *k, int r) { return (in_rows){ bar_x(k, r), bar_y(k, r) }; }
LW_INLINE out_rows out_bar(const run *k, int r) { return (out_rows){ bar_x(k, r), bar_y(k, r) }; }
LW_INLINE lw_vec2 get(in_rows r, size_t i) { return lw_v2(r.x[i], r.y[i]); }
LW_INLINE void put(out_rows r, size_t i, lw_vec2 v)
{
    r.x[i] = v.x;
    r.y[i] = v.y;
}
LW_INLINE void add_to(out_rows r, size_t i, lw_vec2 v)
{
    r.x[i] += v.x;
    r.y[i] += v.y;
}

/* Rows of results; rows of target points and weights (w NULL: weight 1). */
typedef struct rows { double *x, *y, *u, *v, *margin; } rows;
typedef struct target { const double *x, *y, *w; } target;

static inline void fill(double *row, double v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        row[i] = v;
}

/* A forward pass stores besides the registers: nothing; margins; margins and the reciprocals for derivatives. */
enum { POSTURE_ONLY, WITH_MARGIN, WITH_ROOTS };

/* ---- a block of lanes ---------------------------------------------------------------------------------- */

static inline size_t round_up(size_t n) { return (n + LW_GROUP - 1)/LW_GROUP*LW_GROUP; }

/* Divide the work memory into rows.  They are as short as n allows, to stay in cache. */
static inline run start(const lw_plan *plan, size_t n, void *work)
{
    run k = { .plan = plan, .nb = n >= LW_BLOCK_LANES ? LW_BLOCK_LANES : round_up(n) };
    double *w = work;
    size_t nb = k.nb;
    k.reg = w;         w += 2*(size_t)plan->n_reg*nb;
    k.bar = w;         w += 2*(size_t)plan->n_reg*nb;
    k.margin = w;      w += nb;
    k.spare = w;       w += 3*nb;
    k.aux = w;         w += (size_t)plan->n_dyad*nb;
    k.spread_mode = w; w += (size_t)plan->n_mode*nb;
    k.turn = w;        w += 2*(size_t)plan->n_angle*nb;
    k.spread_dim = w;  w += (size_t)plan->n_dim*nb;
    k.row = w;         w += (size_t)plan->n_dim*nb;
    k.row_row = nb;
    k.tail = w;        w += (17 + 5*(size_t)plan->n_dim + (size_t)plan->n_mode)*LW_GROUP;
    k.inverse = w;
    if (plan->n_higher)
        k.group = lw_scratch_align(w + lw_inverse_rows(plan)*nb);
    return k;
}

/* Set the registers of the ground frame (origin and x axis); clear the spare rows. */
static inline void ground_rows(const run *k, size_t n)
{
    double *ox = reg_x(k, 0), *oy = reg_y(k, 0), *ux = reg_x(k, 1), *uy = reg_y(k, 1);
    for (size_t i = 0; i < n; i++) {
        ox[i] = oy[i] = uy[i] = 0;
        ux[i] = 1;
    }
    memset(k->spare, 0, 3*n*sizeof(double));
}

/* Cosines and sines of n angles.  Angles outside the range of lw_sincos are left to the C library. */
static inline void turns(const double *angle, size_t n, double *restrict c, double *restrict s)
{
    int far = 0;
    LW_LANES(n) {
        lw_vec2 u = lw_sincos(angle[i]);
        far |= !(fabs(angle[i]) < LW_SINCOS_MAX);
        c[i] = u.x;
        s[i] = u.y;
    }
    for (size_t i = 0; far && i < n; i++)
        if (!(fabs(angle[i]) < LW_SINCOS_MAX)) {
            c[i] = cos(angle[i]);
            s[i] = sin(angle[i]);
        }
}

static inline lw_vec2 turn(double angle)
{
    return fabs(angle) < LW_SINCOS_MAX ? lw_sincos(angle) : lw_v2(cos(angle), sin(angle));
}

/* Cosines and sines of the first n_angle angles among the dimensions; theta0 is the last. */
static inline void set_turns(run *k, int n_angle, int per_lane, size_t n)
{
    k->turn_row = per_lane ? k->nb : 1;
    for (int a = 0; a < n_angle; a++) {
        const double *angle = dim_of(k, k->plan->angle[a]);
        double *c = k->turn + 2*(size_t)a*k->turn_row;
        if (per_lane) {
            turns(angle, n, c, c + k->turn_row);
            continue;
        }
        lw_vec2 u = turn(*angle);
        c[0] = u.x;
        c[1] = u.y;
    }
}

/* ---- functions that the kernel files share ----------------------------------------------------------------- */

/* The steps that output `which` depends on, in order; of a pin (LW_BATCH_JOINT) all steps of the plan.  Bit h of keep:
 * out[h] of the step is needed. */
LW_INLINE int n_step_of(const lw_plan *p, int which) { return which < 0 ? p->n_step : p->n_output_step[which]; }
LW_INLINE const lw_step *step_of(const lw_plan *p, int which, int i)
{
    return &p->step[which < 0 ? i : p->output_step[which][i]];
}
LW_INLINE int keep_of(const lw_plan *p, int which, int i) { return which < 0 ? ~0 : p->output_keep[which][i]; }

/* Evaluate the steps of `which` over n lanes; outputs: POSTURE_ONLY, ...  lw_forward_step evaluates
 * one step with margins, for lanes that share their dimensions; not for higher groups.  kernel_steps.c */
void lw_forward(const run *k, int which, size_t n, int per_lane, int outputs);
void lw_forward_step(const run *k, const lw_step *s, size_t n);

/* Derivatives of `which`, backwards: from the adjoints in k->bar to k->row and to the row of the input.
 * kernel_steps.c */
void lw_backward(const run *k, int which, size_t n, double *input_bar);

/* Add the adjoints of the least margin of each lane to k->bar and k->row.  known[i] (n) becomes false, and nothing is
 * added, where a higher group has the least margin.  kernel_steps.c */
void lw_seed_margin(const run *k, int which, size_t n, bool *known);

/* The step of a higher group, and the scratch it takes [byte].  kernel_higher.c */
extern const size_t lw_higher_size;
void lw_higher_forward(const run *k, const lw_step *s, size_t n, int per_lane, int outputs);
void lw_higher_backward(const run *k, const lw_step *s, size_t n);

/* For plans with higher groups: follow the groups over the lanes of `in`, chunk by chunk, and call `work_on` for each
 * chunk with its lanes, the number of its first lane, scratch, and its groups' postures.  kernel_continuation.c */
typedef void lw_chunk_work(void *caller, const lw_lanes *part, size_t first, void *work, const double *group_postures);
extern const size_t lw_follow_size;
void lw_in_chunks(const lw_plan *plan, const lw_lanes *in, void *work, lw_chunk_work *work_on, void *caller);
void lw_kernel_group_posture(const lw_plan *plan, const double *dim, const double *mode, double input, void *work,
                             lw_group_posture *group_posture);

/* The normal equations J'J and J'r.  kernel_normal.c */
void lw_kernel_normal(const lw_normal *in, double *h, double *g);

/* Nearest points of a polyline.  kernel_nearest.c */
void lw_kernel_nearest(const lw_polyline *line, size_t n, const double *x, const double *y, double *near_x, double *near_y);

/* Assignment of points to samples of a curve.  kernel_assign.c */
void lw_kernel_costs(const lw_samples *of, size_t n, const double *x, const double *y, const double *weight, double factor, double *cost);
double lw_kernel_in_order(size_t n, size_t m, const double *cost, size_t first, int sense, double enough, double *least);

/* Plans of the form lw_fast_dyad, all steps in one loop.  kernel_fast_dyad.c */
void lw_fast_points(const run *k, int which, size_t n, const rows *out, int per_lane, int frame);
void lw_fast_jacobian(const run *k, int which, size_t n, const lw_jacobian *out);

/* Sums over lanes, eight accumulators each. */
typedef struct sums {
    double r2[LW_GROUP], e_in[LW_GROUP], b[LW_GROUP], e[LW_GROUP], beta[LW_GROUP], d1[LW_GROUP], d2[LW_GROUP],
           cx[LW_GROUP], cy[LW_GROUP], x0[LW_GROUP], y0[LW_GROUP], turn[LW_GROUP], f[LW_GROUP], margin[LW_GROUP];
} sums;
void lw_fast_sum(const run *k, int which, size_t n, const target *t, sums *a);
#define LW_ZEROS 1024                    /* lanes that an absent dimension has zeros for                  */

#endif
