/* base/growable_array.h - arrays that grow by doubling. */
#ifndef LW_BASE_GROWABLE_ARRAY_H
#define LW_BASE_GROWABLE_ARRAY_H

#include <stdlib.h>

/* Make room for one more than n items of `size` bytes.  Returns the array, which may have moved, or NULL if memory is
 * exhausted; then the old array is still valid.  *capacity must be 0 if the array is NULL. */
static inline void *lw_array_grow(void *array, int n, int *capacity, size_t size)
{
    int most = *capacity > 0 ? *capacity : 64;
    if (n < *capacity)
        return array;
    while (most <= n)
        most *= 2;
    void *more = realloc(array, size*(size_t)most);
    *capacity = more ? most : *capacity;
    return more;
}

#endif
