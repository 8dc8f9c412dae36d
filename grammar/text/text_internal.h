/* grammar/text/text_internal.h - shared by all notations of this folder: a reader that knows line and column, and a
 * writer into the caller's memory. */
#ifndef LW_GRAMMAR_TEXT_TEXT_INTERNAL_H
#define LW_GRAMMAR_TEXT_TEXT_INTERNAL_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"

/* A place in a text: the next byte to read, and where a person finds it. */
typedef struct lw_cursor {
    const char *text;
    size_t      size, at;
    long        line, column;      /* of the next byte, from 1 */
    const char *file;              /* for messages; NULL: no file */
    lw_error   *e;
} lw_cursor;

lw_cursor lw_cursor_start(const char *text, size_t size, const char *file, lw_error *e);

/* The next byte, or -1 at the end; _next also steps over it. */
int lw_cursor_peek(const lw_cursor *c);
int lw_cursor_next(lw_cursor *c);

/* True if the rest of the text begins with `word`. */
bool lw_cursor_begins(const lw_cursor *c, const char *word);
void lw_cursor_step(lw_cursor *c, size_t n);            /* n times _next */

/* Skip blanks and tabs; with `lines` also line ends and, if `comment` is not 0, everything from that byte to the
 * end of its line. */
void lw_cursor_skip(lw_cursor *c, bool lines, char comment);

/* Read an unsigned number of at most nine digits.  False, nothing read, when the next byte is no digit or there are
 * more digits. */
bool lw_cursor_number(lw_cursor *c, int *value);

/* LW_E_NOTATION with the place of `at`. */
lw_status lw_cursor_fail(const lw_cursor *at, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* LW_E_NOTATION with the place of the first byte 0: it ends no text, and a reader that passes it would read a part. */
lw_status lw_text_check(const char *text, size_t size, const char *file, lw_error *e);

/* The byte as text for a message: 'x', "the end of the line", "byte 0x80".  buf (24). */
const char *lw_byte_name(int byte, char *buf);

/* Text in a buffer of fixed size; when it is full, the length still counts, as with snprintf. */
typedef struct lw_text { char *buf; size_t size, length; } lw_text;

lw_text lw_text_start(char *buf, size_t size);
void    lw_text_add(lw_text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
void    lw_text_byte(lw_text *t, char byte);

#endif
