/* mbs/space/kernel_tree_internal.h - the table of loops of mbs/space/recursive_stages.h, which each instruction set has; internal to
 * mbs/space. */
#ifndef LW_MBS_SPACE_KERNEL_TREE_INTERNAL_H
#define LW_MBS_SPACE_KERNEL_TREE_INTERNAL_H

#include "mbs/batch/kernels_internal.h"
#include "mbs/space/recursive_stages.h"

typedef struct lw_tree_kernel {
    const char *isa;
    int width;                               /* lanes at a time */
    bool (*rates)(const lw_tree_stages *s, const double *y, double *dy);         /* false: a motion without mass */
} lw_tree_kernel;

extern const lw_tree_kernel lw_tree_kernel_x86_64, lw_tree_kernel_x86_64_v3, lw_tree_kernel_x86_64_v4, lw_tree_kernel_native;

/* The table of an instruction set; of one that has none, the last. */
const lw_tree_kernel *lw_tree_kernel_of(const char *isa);

/* Bytes of lw_tree_stages.state. */
enum { LW_TREE_BODY_PACKS = 58, LW_TREE_RATE_PACKS = 14 };
static inline size_t lw_tree_state_size(const lw_tree_kernel *k, int n_body, int n_u)
{
    return (size_t)k->width*sizeof(double)*((size_t)(n_body + 1)*LW_TREE_BODY_PACKS + (size_t)n_u*LW_TREE_RATE_PACKS);
}

#endif
