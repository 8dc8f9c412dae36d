/* grammar/text/json_locate_internal.h - finds the place of a value in a well-formed JSON text. */
#ifndef LW_GRAMMAR_TEXT_JSON_LOCATE_INTERNAL_H
#define LW_GRAMMAR_TEXT_JSON_LOCATE_INTERNAL_H

#include <stdbool.h>
#include <stddef.h>

/* The path from the root: at each level the number of the element in its array or object, from 0. */
typedef struct lw_json_path { int n; size_t index[16]; } lw_json_path;

/* Offset of the value, or of its key if `key` is set and the value belongs to an object.  The end of the text
 * if there is no such value. */
size_t lw_json_locate(const char *text, size_t size, const lw_json_path *path, bool key);

/* Line and column (bytes, both from 1) of an offset. */
void lw_text_place(const char *text, size_t size, size_t offset, long *line, long *column);

#endif
