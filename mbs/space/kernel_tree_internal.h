/* mbs/space/kernel_tree_internal.h - the table of loops of mbs/space/recursive_stages.h, which each instruction set has; internal to
 * mbs/space. */
#ifndef LW_MBS_SPACE_KERNEL_TREE_INTERNAL_H
#define LW_MBS_SPACE_KERNEL_TREE_INTERNAL_H

#include "mbs/batch/kernels_internal.h"
#include "mbs/space/recursive_stages.h"

typedef struct lw_tree_kernel {
    const char *isa;
    int width;                               /* lanes at a time */
    /* the halves of the angles; if again, how far the coordinates of a body and of all bodies inwards are from those of the factors, summed, at most */
    double (*prepare)(const lw_tree_stages *s, bool again, const double *y);
    /* least pivot of the loops over the first, 1 without loops or `again`; 0: a motion without mass, or a singular posture; -1: a leg that is nearly
     * stretched is to be solved with all loops */
    double (*rates)(const lw_tree_stages *s, bool again, const double *y, double *dy);
    /* Add to du (8 n_u) the least change, in the metric of the masses, that closes the loops; `speeds`: that their rates lack.  again: with the
     * factors of the call before.  Returns the greatest misfit before that; infinite where `rates` returns 0 or less. */
    double (*close)(const lw_tree_stages *s, bool again, bool speeds, const double *y, double *du);
    /* lw_tree_stages_moments of the states for which `rates` was called without `again` just before */
    void (*moments)(const lw_tree_stages *s, int n, double *out);
} lw_tree_kernel;

extern const lw_tree_kernel lw_tree_kernel_x86_64, lw_tree_kernel_x86_64_v3, lw_tree_kernel_x86_64_v4, lw_tree_kernel_native;

/* The table of an instruction set; of one that has none, the last. */
const lw_tree_kernel *lw_tree_kernel_of(const char *isa);

/* Bytes of lw_tree_stages.state for the lanes of one register: states of bodies and rates; rows, those of legs carried over, Y, Y D Y^T,
 * multipliers and their changes. */
enum { LW_TREE_BODY_PACKS = 58, LW_TREE_RATE_PACKS = 14, LW_TREE_PULL_PACKS = 13 };
static inline size_t lw_tree_state_size(int width, int n_body, int n_u, int n_row)
{
    size_t bodies = (size_t)n_body + 1, u = (size_t)n_u, row = (size_t)n_row;
    return (size_t)width*sizeof(double)*(bodies*LW_TREE_BODY_PACKS + u*LW_TREE_RATE_PACKS + row*(LW_TREE_PULL_PACKS + 6 + u + row + 2));
}

#endif
