/* optimise/report/report_circuit.c - closed motions across limits, leg by leg over the whole circuit. */
#include <stdlib.h>

#include "base/real.h"
#include "mbs/batch/batch.h"
#include "optimise/report/report_internal.h"

bool lw_fit_report_cycle(const lw_plan *plan, const lw_candidate *c, const double *modes, lw_closed_motion *cycle)
{
    cycle->n = 0;
    void *batch = c->mode_of ? aligned_alloc(64, (lw_batch_work_size(plan) + 127) & ~(size_t)63) : NULL;
    if (!batch)
        return !c->mode_of;
    bool found = lw_closed_motion_find(plan, c->dim, modes, c->input[0], batch, cycle) == LW_OK;
    free(batch);
    if (!found)
        cycle->n = 0;
    return true;
}

size_t lw_fit_report_cycle_points(const lw_plan *plan, const lw_candidate *c, const lw_closed_motion *cycle, size_t most, lw_vec2 *curve)
{
    size_t each = most/(size_t)cycle->n, n = 0;
    for (int j = 0; j < cycle->n; j++) {
        const lw_leg *leg = &cycle->leg[j];
        double first = lw_closed_motion_first(cycle, j), mid = 0.5*(first + leg->last), half = 0.5*(leg->last - first);
        for (size_t k = 0; k < each; k++) {              /* not at the limits: rounding may open it there */
            lw_posture posture;
            double input = mid - half*cos(LW_PI*((double)k + 0.5)/(double)each);
            if (lw_posture_solve(plan, c->dim, leg->mode, input, 0, &posture) == LW_OK)
                curve[n++] = posture.tracer[0][0];
        }
    }
    return n;
}
