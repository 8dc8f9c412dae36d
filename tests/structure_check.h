/* tests/structure_check.h - is this a structure: circles joined by lines in rising order, three lines at each circle,
 * connected without any one circle? */
#ifndef TESTS_STRUCTURE_CHECK_H
#define TESTS_STRUCTURE_CHECK_H

#include <string.h>
#include "grammar/topology/structure.h"

/* True if the other circles hang together without circle `lost`. */
static bool whole_without(const lw_structure *s, int lost)
{
    bool seen[LW_CIRCLE_MAX] = { false };
    int n = 0, first = lost == 0;
    seen[first] = true;
    for (int pass = 0; pass < s->n_circle; pass++)
        for (int k = 0; k < s->n_line; k++) {
            int a = s->end[k][0], b = s->end[k][1];
            if (a != lost && b != lost)
                seen[a] = seen[b] = seen[a] || seen[b];
        }
    for (int i = 0; i < s->n_circle; i++)
        n += seen[i];
    return n == s->n_circle - 1;
}

static bool is_structure(const lw_structure *s)
{
    int degree[LW_CIRCLE_MAX] = { 0 };
    if (s->n_circle < 2 || s->n_circle > LW_CIRCLE_MAX || s->n_line > LW_LINE_MAX)
        return false;
    for (int k = 0; k < s->n_line; k++) {
        if (s->end[k][0] >= s->end[k][1] || s->end[k][1] >= s->n_circle || (k > 0 && memcmp(s->end[k - 1], s->end[k], 2) > 0))
            return false;
        degree[s->end[k][0]]++;
        degree[s->end[k][1]]++;
    }
    for (int i = 0; i < s->n_circle; i++)
        if (degree[i] < 3 || !whole_without(s, i))
            return false;
    return true;
}

#endif
