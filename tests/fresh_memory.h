/* tests/fresh_memory.h - fresh memory is filled with NaN, so that a result that depends on memory that was never written fails in every run. */
#ifndef LW_TESTS_FRESH_MEMORY_H
#define LW_TESTS_FRESH_MEMORY_H

#include <string.h>

/* Fill the first MB of p (n bytes; NULL: nothing happens).  Returns p. */
static inline void *fill_with_nan(void *p, size_t n)
{
    enum { MOST = 1 << 20 };
    return p ? memset(p, 0xff, n < MOST ? n : MOST) : NULL;
}

#endif
