/* Run the kernels of the chosen instruction set. */
#include "mbs/batch/kernels_internal.h"

size_t lw_group_posture_size(const lw_plan *p)
{
    return *lw_kernels_of(p)->follow_size + sizeof(double)*lw_continuation_size(p) + LW_SCRATCH_ALIGNMENT;
}

/* Higher groups add their inverses, their postures in a chunk of lanes, and the scratch to follow and to solve them. */
size_t lw_batch_work_size(const lw_plan *p)
{
    size_t size = sizeof(double)*(lw_lane_rows(p)*LW_BLOCK_LANES + lw_group_rows(p)*LW_GROUP);
    if (!p->n_higher)
        return size;
    size += sizeof(double)*(lw_inverse_rows(p)*LW_BLOCK_LANES + ((size_t)p->n_row + 1)*(LW_CHUNK + LW_GROUP));
    return size + lw_group_posture_size(p) + *lw_kernels_of(p)->group_size + LW_SCRATCH_ALIGNMENT;
}

const lw_kernels *lw_kernels_of(const lw_plan *plan) { return plan->kernels ? plan->kernels : lw_kernels_supported(0); }

void lw_batch_point(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    double *x, double *y, double *u, double *v, double *margin)
{
    lw_kernels_of(plan)->point(plan, in, which, work, x, y, u, v, margin);
}

void lw_batch_frame(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    double *ox, double *oy, double *dx, double *dy, double *margin)
{
    lw_kernels_of(plan)->frame(plan, in, which, work, ox, oy, dx, dy, margin);
}

void lw_batch_jacobian(const lw_plan *plan, const lw_lanes *in, int which, void *work, const lw_jacobian *out)
{
    lw_kernels_of(plan)->jacobians(plan, in, 1, &which, work, out);
}

void lw_batch_jacobians(const lw_plan *plan, const lw_lanes *in, int n, const int *which, void *work, const lw_jacobian *out)
{
    lw_kernels_of(plan)->jacobians(plan, in, n, which, work, out);
}

double lw_batch_sum(const lw_plan *plan, const lw_lanes *in, int which, void *work,
                    const double *tx, const double *ty, const double *w, double *grad, double *margin)
{
    return lw_kernels_of(plan)->sum(plan, in, which, work, tx, ty, w, grad, margin);
}

void lw_batch_normal(const lw_plan *plan, const lw_normal *in, double *h, double *g)
{
    lw_kernels_of(plan)->normal(in, h, g);
}

void lw_batch_nearest(const lw_plan *plan, const lw_polyline *line, size_t n, const double *x, const double *y, double *near_x,
                      double *near_y)
{
    lw_kernels_of(plan)->nearest(line, n, x, y, near_x, near_y);
}

void lw_batch_costs(const lw_plan *plan, const lw_samples *of, size_t n, const double *x, const double *y, const double *weight,
                    double factor, double *cost)
{
    lw_kernels_of(plan)->costs(of, n, x, y, weight, factor, cost);
}

double lw_batch_in_order(const lw_plan *plan, size_t n, size_t m, const double *cost, size_t first, int sense, double enough, double *least)
{
    return lw_kernels_of(plan)->in_order(n, m, cost, first, sense, enough, least);
}

void lw_batch_turns(const lw_plan *plan, size_t n, const double *angle, double *c, double *s)
{
    lw_kernels_of(plan)->turns(n, angle, c, s);
}
