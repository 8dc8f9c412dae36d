/* enumerate/critical.h - the circle sets that can hold a rigid subchain.
 *
 * Put max(0, 2 - w_e) copies of each line e between its circles.  A chain has no rigid subchain exactly
 * when every set S of two or more circles holds at most 3|S| - 4 copies ((3,4)-sparsity; Lee & Streinu
 * 2008).  With no binary links at all S would hold 2 E(S) copies, so only sets with 2 E(S) > 3|S| - 4
 * can be overfull.  A set is left out if a smaller set inside it needs at least as many binary links.
 * Usually only a few sets remain. */
#ifndef LW_ENUMERATE_CRITICAL_H
#define LW_ENUMERATE_CRITICAL_H

#include "grammar/topology/structure.h"

typedef struct lw_critical {
    uint32_t circles;       /* S                                                              */
    uint64_t lines;         /* lines with both ends in S                                      */
    int      room;          /* 3|S| - 4: copies S may hold                                    */
    int      need;          /* 2 E(S) - room: least number of binary links on its lines,
                               where a line counts for at most two                            */
} lw_critical;

/* A growing list.  Set it to zero before first use and free(list.set) at the end. */
typedef struct lw_critical_list { int n, room; lw_critical *set; } lw_critical_list;

/* The critical sets of a structure, smaller ones first.  The set of all circles is included if `whole` is true; it
 * is false for F = 0.  LW_E_MEMORY. */
lw_status lw_critical_sets(const lw_structure *s, bool whole, lw_critical_list *list);

#endif
