/* catalogues/bytes.h - a growing block of bytes: what every writer of this folder returns, so that one
 * function (base/file.h, lw_file_write) puts them all on disk.
 *
 * A failed allocation is remembered and makes every later call do nothing; ask once, at the end.
 * Numbers are written without the C library's formats, so the program's locale does not matter. */
#ifndef LW_CATALOGUES_BYTES_H
#define LW_CATALOGUES_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"

typedef struct lw_bytes {
    char  *data;          /* terminated by a 0 that `size` does not count; NULL while empty */
    size_t size, room;
    bool   failed;
} lw_bytes;               /* { 0 } is an empty block */

void lw_bytes_free(lw_bytes *b);

void lw_bytes_add(lw_bytes *b, const void *data, size_t size);
void lw_bytes_text(lw_bytes *b, const char *text);                  /* as it is                     */
void lw_bytes_xml(lw_bytes *b, const char *text);                   /* & < > " ' as entities; bytes
                                                                     * that are no UTF-8 or no XML
                                                                     * character become U+FFFD      */
void lw_bytes_fixed(lw_bytes *b, double v, int decimals);           /* "1.5", trailing zeros cut; |v| < 1e12, else "0" */
void lw_bytes_number(lw_bytes *b, double v, int digits);            /* shortest of %g with `digits` */

/* LW_E_MEMORY with a text, b freed, when a call above failed; else LW_OK. */
lw_status lw_bytes_end(lw_bytes *b, lw_error *e);

#endif
