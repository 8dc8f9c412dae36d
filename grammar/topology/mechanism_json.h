/* grammar/topology/mechanism_json.h - chains and mechanisms as JSON, one object per line in streams.
 *
 *     {"linkwright": 1, "links": 4, "joints": [[1, 2, "r"], [1, 4, "r"], [2, 3, "r"], [3, 4, "t"]],
 *      "ground": 1, "inputs": [[1, 2]], "output": 3}
 *
 * Links count from 1.  A joint without a kind is a pin (r).  Ground, inputs and output are left out if they are
 * not chosen.  Linkages, which have positions and names, are another kind of object, in which "links" is a list
 * (grammar/linkage/linkage.h). */
#ifndef LW_GRAMMAR_TOPOLOGY_MECHANISM_JSON_H
#define LW_GRAMMAR_TOPOLOGY_MECHANISM_JSON_H

#include <stddef.h>
#include "grammar/topology/mechanism.h"

#define LW_MECHANISM_JSON_SIZE (LW_JOINT_MAX*16 + LW_INPUT_MAX*10 + 128)

/* One line without line end; returns the length as snprintf does. */
size_t lw_mechanism_write(const lw_mechanism *m, char *buf, size_t size);

/* LW_E_NOTATION with line and column: an unknown key or joint kind; a link that does not exist, is joined to
 * itself or twice to another link; an input that is no joint of one freedom. */
lw_status lw_mechanism_read(const char *text, size_t size, const char *file, lw_mechanism *m, lw_error *e);

#endif
