/* enumerate/critical.h - the circle sets that can hold a rigid subchain.
 *
 * Put max(0, 2 - w_e) copies of each line e between its circles.  A chain has no rigid subchain exactly
 * when every set S of two or more circles holds at most 3|S| - 4 copies ((3,4)-sparsity; Lee & Streinu
 * 2008).  With no binary links at all S would hold 2 E(S) copies, so only sets with 2 E(S) > 3|S| - 4
 * can be overfull.  Of these a set is left out when a smaller one inside it needs as many binary links.
 * What remains is usually a handful. */
#ifndef LW_ENUMERATE_CRITICAL_H
#define LW_ENUMERATE_CRITICAL_H

#include "grammar/structure.h"

typedef struct lw_critical {
    uint32_t circles;       /* S                                                              */
    uint64_t lines;         /* lines with both ends in S                                      */
    int      room;          /* 3|S| - 4: copies S may hold                                    */
    int      need;          /* 2 E(S) - room: binary links its lines must hold at least,
                               no line counted for more than two                              */
} lw_critical;

/* A list that grows; zero it before first use, free(list.set) after last. */
typedef struct lw_critical_list { int n, room; lw_critical *set; } lw_critical_list;

/* The critical sets of a structure, smaller ones first; `whole` says whether the set of all circles counts
 * (it does not for F = 0).  LW_E_MEMORY. */
lw_status lw_critical_sets(const lw_structure *s, bool whole, lw_critical_list *list);

#endif
