/* base/bytes.h - a growing block of bytes: what every writer of this folder returns, so that one
 * function (base/file.h, lw_file_write) puts them all on disk.
 *
 * A failed allocation is remembered and makes every later call do nothing; ask once, at the end.
 * Numbers are written without the C library's formats, so the program's locale does not matter. */
#ifndef LW_BASE_BYTES_H
#define LW_BASE_BYTES_H

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
void lw_bytes_fixed(lw_bytes *b, double v, int decimals);           /* "-1.5": at most so many decimals
                                                                     * (0 .. 6), trailing zeros cut;
                                                                     * "0" unless |v| < 1e12        */
void lw_bytes_integer(lw_bytes *b, long v);
void lw_bytes_number(lw_bytes *b, double v, int digits);            /* as lw_number_text            */

/* v with so many significant digits (1 .. 17), trailing zeros cut: "0.0125", "1.25e-9", "nan". */
void lw_number_text(char text[32], double v, int digits);

/* Number of bytes of the UTF-8 that begins text, and its character; 0 if it is no UTF-8.  Reads no byte past the first that does not belong
 * to it. */
int lw_utf8_read(const char *text, unsigned *code);
/* Write a character, 0 to 0x10ffff, as UTF-8, without a 0 at the end; returns the number of bytes. */
int lw_utf8_write(unsigned code, char out[4]);

/* Number of bytes of the character that begins text; 0 if it is no UTF-8 or no character that a document may hold. */
int lw_text_character(const char *text);

/* Is a control character in the text?  Names have none: they are printed on terminals and in lines of tables. */
bool lw_text_has_control(const char *text);

/* Copy text into out[size] in whole characters, as far as they fit; what is no UTF-8 or no character
 * a document may hold becomes U+FFFD. */
void lw_text_clean(char *out, size_t size, const char *text);

/* Does the text begin with the byte order mark of UTF-16?  And the same text in UTF-8, terminated, of *n bytes: free it with free(), NULL:
 * out of memory.  Half a pair of surrogates becomes U+FFFD. */
bool  lw_text_is_utf16(const char *text, size_t size);
char *lw_text_from_utf16(const char *text, size_t size, size_t *n);

/* LW_E_MEMORY with a text, b freed, when a call above failed; else LW_OK. */
lw_status lw_bytes_end(lw_bytes *b, lw_error *e);

#endif
