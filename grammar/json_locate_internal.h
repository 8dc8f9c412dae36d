/* grammar/json_locate_internal.h - where a value stands in a JSON text that is known to be well-formed. */
#ifndef LW_GRAMMAR_JSON_LOCATE_INTERNAL_H
#define LW_GRAMMAR_JSON_LOCATE_INTERNAL_H

#include <stdbool.h>
#include <stddef.h>

/* The way from the root: at each level the number of the element in its array or object, from 0. */
typedef struct lw_json_way { int n; size_t index[16]; } lw_json_way;

/* Offset of the value, or of its key when key is set and it stands in an object.  The end of the text
 * when the way leads nowhere. */
size_t lw_json_locate(const char *text, size_t size, const lw_json_way *way, bool key);

/* Line and column (bytes, both from 1) of an offset. */
void lw_text_place(const char *text, size_t size, size_t offset, long *line, long *column);

#endif
