/* grammar/mechanism_json.h - chains and mechanisms as JSON, one object per line in streams.
 *
 *     {"linkwright": 1, "links": 4, "joints": [[1, 2, "r"], [1, 4, "r"], [2, 3, "r"], [3, 4, "t"]],
 *      "ground": 1, "inputs": [[1, 2]], "output": 3}
 *
 * Links count from 1.  A joint may leave its kind out, which means r; ground, inputs and output are
 * left out where nobody chose them.  Linkages, which have places and names, are another object: there
 * "links" is a list (grammar/linkage.h). */
#ifndef LW_GRAMMAR_MECHANISM_JSON_H
#define LW_GRAMMAR_MECHANISM_JSON_H

#include <stddef.h>
#include "grammar/mechanism.h"

#define LW_MECHANISM_JSON_SIZE (LW_JOINT_MAX*16 + LW_INPUT_MAX*10 + 128)

/* One line without line end; returns the length as snprintf does. */
size_t lw_mechanism_write(const lw_mechanism *m, char *buf, size_t size);

/* LW_E_NOTATION with line and column: unknown keys, a link that does not exist, is joined to itself or
 * twice to another, no joint kind, an input that is no joint of one freedom. */
lw_status lw_mechanism_read(const char *text, size_t size, const char *file, lw_mechanism *m,
                            lw_error *e);

#endif
