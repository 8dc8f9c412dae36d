/* base/error.h - an error message: what is wrong, where, why, and what to do.  The caller owns the record.
 *
 * Every function that reads something a person wrote takes an lw_error * as its last argument.  It may be NULL; then only
 * the text is lost.  The library fills it, cli/ prints it. */
#ifndef LW_BASE_ERROR_H
#define LW_BASE_ERROR_H

#include "base/status.h"     /* lw_error: linkwright.h */

/* Fill e and return s: a caller can write  return lw_error_set(e, LW_E_ARG, "..."). */
lw_status lw_error_set(lw_error *e, lw_status s, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same with a position in a file. */
lw_status lw_error_at(lw_error *e, lw_status s, const char *file, long line, long column,
                      const char *format, ...) __attribute__((format(printf, 6, 7)));

/* "file:line:column: text" into buf, always terminated; unknown parts are left out. */
void lw_error_print(const lw_error *e, char *buf, int size);

#endif
