/* Rows and numbers of scratch that the kernels need. */
#include "mbs/batch/kernels_internal.h"

/* Rows of a block: registers and their adjoints (two numbers each); margin and three spare rows; the reciprocal of a
 * root for each dyad; cosine and sine of each angle; dimensions and modes copied to every lane; derivatives by the
 * dimensions. */
size_t lw_lane_rows(const lw_plan *p)
{
    return 4*(size_t)p->n_reg + 4 + (size_t)p->n_dyad + (size_t)p->n_mode + 2*(size_t)p->n_angle + 2*(size_t)p->n_dim;
}

size_t lw_group_rows(const lw_plan *p) { return 17 + 5*(size_t)p->n_dim + (size_t)p->n_mode; }

size_t lw_inverse_rows(const lw_plan *p)
{
    size_t rows = 0;
    for (int i = 0; i < p->n_higher; i++)
        rows += (size_t)(p->higher[i].n_unknown*p->higher[i].n_unknown);
    return rows;
}

size_t lw_continuation_size(const lw_plan *p)
{
    return (lw_lane_rows(p) + lw_group_rows(p))*LW_GROUP;
}
