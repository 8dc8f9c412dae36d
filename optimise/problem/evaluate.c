#include "optimise/problem/evaluate.h"

#include <string.h>

#include "optimise/problem/residuals.h"
#include "optimise/problem/timing.h"

bool lw_problem_settle(const lw_problem *p, const double *x, lw_work *w)
{
    if (p->timing == LW_TIMING_PRESCRIBED) {
        lw_problem_prescribe(p, x, w);
        return lw_problem_lanes(p, x, w);
    }
    if (!lw_timing_assign(p, x, w) || !lw_timing_refine(p, x, w, 60))
        return false;
    if (p->timing == LW_TIMING_NONE)                         /* the stations have moved, and with them the ends of the piece */
        lw_timing_samples(p, w, w->jac.x + p->n, w->jac.y + p->n);
    return true;
}

double lw_problem_value(const lw_problem *p, const double *x, double *grad, void *work)
{
    lw_work *w = work;
    if (grad)
        memset(grad, 0, sizeof *grad*(size_t)p->n_var);
    if (!lw_problem_settle(p, x, w))
        return INFINITY;
    double f = lw_problem_rows(p, x, w, grad != NULL);
    size_t ld = w->ld, nv = (size_t)p->n_var;
    for (size_t d = 0; grad && d < nv; d++)
        for (size_t i = 0; i < (size_t)w->n_row; i++)
            for (size_t k = 0; k < w->n_lane; k++)
                grad[d] += 2*w->row[(i*nv + d)*ld + k]*w->res[i*ld + k];
    return f;
}

size_t lw_problem_residual_count(const lw_problem *p)
{
    return lw_problem_lane_count(p)*(size_t)lw_problem_component_count(p);
}

bool lw_problem_residuals(const lw_problem *p, const double *x, double *r, double *j, void *work)
{
    lw_work *w = work;
    if (!lw_problem_settle(p, x, w))
        return false;
    lw_problem_rows(p, x, w, j != NULL);
    size_t ld = w->ld, nv = (size_t)p->n_var, at = 0;
    for (size_t i = 0; i < (size_t)w->n_row; i++)
        for (size_t k = 0; k < w->n_lane; k++, at++) {
            r[at] = w->res[i*ld + k];
            for (size_t d = 0; j && d < nv; d++)
                j[at*nv + d] = w->row[(i*nv + d)*ld + k];
        }
    return true;
}
