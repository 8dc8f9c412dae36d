/* enumerate/chains_internal.h - the walk over structures, shared by visiting, printing and counting. */
#ifndef LW_ENUMERATE_CHAINS_INTERNAL_H
#define LW_ENUMERATE_CHAINS_INTERNAL_H

#include "enumerate/chains.h"

struct lw_chains {
    lw_numbers     numbers;
    lw_structures *structures;            /* NULL for L = 1 */
};

lw_status lw_walk_check(const lw_chain_walk *how);

/* Number of structures of the part (a ring counts as one), and the index of the k-th of them. */
size_t lw_walk_size(const lw_chains *chains, const lw_chain_walk *how);
static inline size_t lw_walk_index(const lw_chain_walk *how, size_t k)
{
    return (size_t)how->part + k*(size_t)how->n_part;
}

/* Visit the chains of the k-th structure of the part that pass the filter.  w is scratch. */
lw_status lw_walk_structure(const lw_chains *chains, const lw_chain_walk *how, size_t k, lw_weighting *w,
                            lw_chain_visit *visit, void *context);

/* Count them. */
lw_status lw_walk_count(const lw_chains *chains, const lw_chain_walk *how, size_t k, lw_weighting *w, lw_tally *tally);

/* Where how->skip ends: the structure, and the number of chains to leave out there. */
typedef struct lw_walk_start { size_t structure; uint64_t skip; } lw_walk_start;
lw_status lw_walk_find_start(const lw_chains *chains, const lw_chain_walk *how, lw_walk_start *start);

#endif
