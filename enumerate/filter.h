/* enumerate/filter.h - filters that select chains.  A filter is a row of a table: to add one, write its predicate
 * and its row in filter.c; the command line and the tests find it there. */
#ifndef LW_ENUMERATE_FILTER_H
#define LW_ENUMERATE_FILTER_H

#include <stdbool.h>
#include "base/status.h"
#include "grammar/topology/structure.h"

/* *keep becomes true: keep this one.  LW_E_MEMORY; LW_E_IO: igraph is not installed. */
typedef lw_status lw_filter_chain(const lw_chain *c, bool *keep);
typedef lw_status lw_filter_structure(const lw_structure *s, bool *keep);

typedef struct lw_filter {
    const char *name;
    lw_filter_chain     *chain;
    lw_filter_structure *structure;                 /* NULL, or the answer if it is the same for all chains of a
                                                       structure; then counting needs no listing            */
} lw_filter;

/* The rows; the last has name NULL. */
extern const lw_filter lw_filters[];

/* The row of that name; NULL when there is none. */
const lw_filter *lw_filter_find(const char *name);

#endif
