/* tests/model_text.h - the text of a model, piece by piece, with random numbers. */
#ifndef LW_TESTS_MODEL_TEXT_H
#define LW_TESTS_MODEL_TEXT_H

#include "base/rng.h"
#include "tests/json_text.h"

static lw_rng rng;
static char text[8000];
static int  used;                    /* of text */

static inline double between(double a, double b) { return lw_rng_range(&rng, a, b); }

/* Append to the text; ' is written for ". */
static inline void put(const char *format, ...) __attribute__((format(printf, 1, 2)));
static inline void put(const char *format, ...)
{
    va_list arg;
    va_start(arg, format);
    used += vsnprintf(text + used, sizeof text - (size_t)used, format, arg);
    va_end(arg);
    json_quotes(text);
}

/* A link with a random mass about (x, y). */
static inline void put_link(const char *name, double x, double y)
{
    put(", {'name': '%s', 'mass': %.17g, 'centre': [%.17g, %.17g], 'inertia': %.17g}", name, between(0.5, 2),
        x + between(-0.2, 0.2), y + between(-0.2, 0.2), between(0.05, 0.5));
}

#endif
