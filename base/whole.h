/* base/whole.h - whole numbers up to 2^128 - 1, about 3.4e38, for counts beyond 64 bits. */
#ifndef LW_BASE_WHOLE_H
#define LW_BASE_WHOLE_H

#include <stdbool.h>

__extension__ typedef unsigned __int128 lw_whole;

#define LW_WHOLE_SIZE 40          /* 39 digits and the end */

/* Write n in decimal to text (LW_WHOLE_SIZE); returns text. */
static inline const char *lw_whole_print(lw_whole n, char *text)
{
    char digit[LW_WHOLE_SIZE];
    int k = 0, i = 0;
    do
        digit[k++] = (char)('0' + (int)(n % 10));
    while ((n /= 10) > 0);
    while (k > 0)
        text[i++] = digit[--k];
    text[i] = '\0';
    return text;
}

/* Read decimal digits; *end becomes the first other character.  False if there is no digit or the number is too large. */
static inline bool lw_whole_read(const char *text, const char **end, lw_whole *n)
{
    const char *at = text;
    bool fits = true;
    for (*n = 0; *at >= '0' && *at <= '9'; at++)
        fits = fits && !__builtin_mul_overflow(*n, 10, n) && !__builtin_add_overflow(*n, (unsigned)(*at - '0'), n);
    *end = at;
    return fits && at > text;
}

#endif
