/* base/key_table.h - finds the index of a key, such as a name, among many.
 *
 * The caller keeps the keys in an array of items; a table holds only indices.  A key is its first `size` bytes at the start of
 * an item: strlen + 1 for a name, sizeof for a number.  A zeroed table is empty. */
#ifndef LW_BASE_KEY_TABLE_H
#define LW_BASE_KEY_TABLE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct lw_key_slot { uint32_t hash; int item; } lw_key_slot;      /* item 0: empty, else index + 1 */
typedef struct lw_key_table { size_t capacity, n; lw_key_slot *slot; } lw_key_table;

static inline uint32_t lw_key_table_hash(const void *key, size_t size)         /* FNV-1a */
{
    uint32_t h = 2166136261u;
    for (size_t i = 0; i < size; i++)
        h = (h ^ ((const unsigned char *)key)[i])*16777619u;
    return h;
}

/* The index that was added with this key; -1: none. */
static inline int lw_key_table_find(const lw_key_table *t, const void *items, size_t stride, const void *key, size_t size)
{
    uint32_t h = lw_key_table_hash(key, size);
    for (size_t i = h; t->capacity > 0 && t->slot[i &= t->capacity - 1].item > 0; i++)
        if (t->slot[i].hash == h && memcmp((const char *)items + (size_t)(t->slot[i].item - 1)*stride, key, size) == 0)
            return t->slot[i].item - 1;
    return -1;
}

/* Add a key that is not in the table.  false: out of memory. */
static inline bool lw_key_table_add(lw_key_table *t, const void *key, size_t size, int index)
{
    if (2*(t->n + 1) > t->capacity) {
        lw_key_table more = { .capacity = t->capacity ? 2*t->capacity : 64, .n = t->n };
        more.slot = calloc(more.capacity, sizeof *more.slot);
        if (!more.slot)
            return false;
        for (size_t i = 0; i < t->capacity; i++) {
            size_t to = t->slot[i].hash & (more.capacity - 1);
            while (t->slot[i].item > 0 && more.slot[to].item > 0)
                to = (to + 1) & (more.capacity - 1);
            if (t->slot[i].item > 0)
                more.slot[to] = t->slot[i];
        }
        free(t->slot);
        *t = more;
    }
    uint32_t h = lw_key_table_hash(key, size);
    size_t to = h & (t->capacity - 1);
    while (t->slot[to].item > 0)
        to = (to + 1) & (t->capacity - 1);
    t->slot[to] = (lw_key_slot){ h, index + 1 };
    t->n++;
    return true;
}

static inline void lw_key_table_free(lw_key_table *t)
{
    free(t->slot);
    *t = (lw_key_table){ 0 };
}

#endif
