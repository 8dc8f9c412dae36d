/* tests/json_text.h - JSON texts in C strings, with ' in the place of ". */
#ifndef LW_TESTS_JSON_TEXT_H
#define LW_TESTS_JSON_TEXT_H

#include <stdarg.h>
#include "tests/check.h"

/* Change each ' into ", in place. */
static inline char *json_quotes(char *text)
{
    for (char *c = text; *c; c++)
        *c = *c == '\'' ? '"' : *c;
    return text;
}

/* snprintf, and json_quotes.  Returns the size of the text. */
static inline size_t json_format(char *text, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));
static inline size_t json_format(char *text, size_t size, const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    int n = vsnprintf(text, size, format, arg);
    va_end(arg);
    CHECK(n >= 0 && (size_t)n < size);
    return strlen(json_quotes(text));
}

#endif
