/* base/number.h - decimal text to double and back, the same under every locale; plurals of nouns behind numbers.
 *
 * Accepted: an optional sign, digits with an optional point, an optional exponent ("-1", ".5", "3.", "1e-3").
 * Nothing else: no blanks, no "0x", no "inf", no "nan", no decimal comma. */
#ifndef LW_BASE_NUMBER_H
#define LW_BASE_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include "base/status.h"

#define LW_NUMBER_SIZE 32       /* room for any double as text, with its terminator */

/* Read all n bytes at s as a number, correctly rounded.  LW_E_NOTATION: not a number, or
 * longer than 1000 bytes; LW_E_NUMERIC: too large for a double (a too small number becomes 0 or subnormal).
 * *out is untouched on failure. */
lw_status lw_number_parse(const char *s, size_t n, double *out);

/* Do the n bytes spell a value that is not a finite number ("nan", "inf", "-Infinity", ...)?  Used only for a
 * better error message. */
bool lw_number_is_word(const char *s, size_t n);

/* The shortest of 15, 16 or 17 significant digits that reads back as the same bits.  "nan", "inf",
 * "-inf" for values that are not finite. */
void lw_number_print(double v, char text[LW_NUMBER_SIZE]);

/* The shortest decimal w for which w*unit == v when read back, otherwise the 17 digits of v/unit: 0.03 m in mm is
 * "30". */
void lw_number_print_in(double v, double unit, char text[LW_NUMBER_SIZE]);

/* "s" behind a noun after the number n, as in "2 links"; "" if n is 1. */
const char *lw_plural(long long n);

#endif
