/* grammar/read_internal.h - pieces of what people write about a linkage, shared by the readers of
 * linkages and of models.  All return LW_E_NOTATION with a place when the text is not as said. */
#ifndef LW_GRAMMAR_READ_INTERNAL_H
#define LW_GRAMMAR_READ_INTERNAL_H

#include "grammar/json_internal.h"
#include "grammar/linkage.h"

#define COUNT(a) ((int)(sizeof (a)/sizeof *(a)))

/* A member that must be there. */
lw_status lw_read_need(const lw_json_node *object, const char *key, lw_json_node *out, lw_error *e);

/* A list of `least` to `most` elements. */
lw_status lw_read_list(const lw_json_node *n, size_t least, size_t most, lw_error *e);

/* [x, y] times unit, within what can be reckoned with. */
lw_status lw_read_pair(const lw_json_node *n, double unit, lw_vec2 *out, lw_error *e);

/* A number that may be left out, times unit. */
lw_status lw_read_optional(const lw_json_node *object, const char *key, double unit, double *out, bool *given,
                           lw_error *e);

/* Index of the thing that a node names; a fault with a suggestion when there is none. */
lw_status lw_read_look_up(const lw_json_node *n, const char *what, const char *const *names, int n_name,
                          int *out, lw_error *e);
lw_status lw_read_link(const lw_json_node *n, const lw_linkage *k, int *out, lw_error *e);
lw_status lw_read_joint(const lw_json_node *n, const lw_linkage *k, int *out, lw_error *e);

/* "units" of a root; u stays as it is where nothing is said. */
lw_status lw_read_units(const lw_json_node *root, lw_units *u, lw_error *e);

/* A linkage from the root of a JSON text; what a model adds is passed over. */
lw_status lw_linkage_read_root(const lw_json_node *root, lw_linkage *k, lw_error *e);

#endif
