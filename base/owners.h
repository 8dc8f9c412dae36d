/* base/owners.h - which items belong to an owner: the joints of a link, the springs of a joint.
 *
 * Each item has one owner or two (`ends`).  Entries of an owner stand together and rise:
 *     for (int at = t.start[owner]; at < t.start[owner + 1]; at++)
 *         item = t.entry[at]/ends, end = t.entry[at]%ends;
 * A zeroed table is empty and needs no lw_owners_free, which takes the tables of failed calls, too. */
#ifndef LW_BASE_OWNERS_H
#define LW_BASE_OWNERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

typedef struct lw_owners { int *start, *entry; } lw_owners;

/* Items are `stride` bytes apart; the owners of each, `ends` numbers below n_owner, are `offset` bytes inside; a negative one is
 * none.  false: out of memory. */
static inline bool lw_owners_make(lw_owners *t, int n_owner, const void *items, size_t stride, size_t offset, int n_item, int ends)
{
    size_t owners = (size_t)n_owner + 2;
    t->start = calloc(owners + (size_t)n_item*(size_t)ends, sizeof *t->start);
    if (!t->start)
        return false;
    t->entry = t->start + owners;
    for (int pass = 0; pass < 2; pass++) {                 /* count, then fill: start[owner + 1] is where it goes on */
        for (int i = 0; i < n_item; i++)
            for (int end = 0; end < ends; end++) {
                int owner = ((const int *)((const char *)items + (size_t)i*stride + offset))[end];
                if (owner < 0)
                    continue;
                if (pass == 0)
                    t->start[owner + 2]++;
                else
                    t->entry[t->start[owner + 1]++] = i*ends + end;
            }
        for (int i = 0; pass == 0 && i < n_owner; i++)
            t->start[i + 2] += t->start[i + 1];
    }
    return true;
}

/* The same for n items of one struct type, by its member. */
#define LW_OWNERS(table, n_owner, items, n, member, ends) \
    lw_owners_make(table, n_owner, items, sizeof *(items), offsetof(__typeof__(*(items)), member), n, ends)

static inline void lw_owners_free(lw_owners *t)
{
    free(t->start);
    *t = (lw_owners){ 0 };
}

#endif
