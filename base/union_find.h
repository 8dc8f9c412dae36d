/* base/union_find.h - disjoint sets of numbers, as a forest: parent[i] == i is the root of a set. */
#ifndef LW_BASE_UNION_FIND_H
#define LW_BASE_UNION_FIND_H

/* The root of the set of i; halves the path to it. */
static inline int lw_root_of(int *parent, int i)
{
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

#endif
