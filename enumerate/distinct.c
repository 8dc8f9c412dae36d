/* enumerate/distinct.c - see distinct.h. */
#include "enumerate/distinct.h"

#include <stdlib.h>
#include <string.h>

#include "enumerate/canon.h"

#define ROUNDS 4           /* of colour refinement; more rounds only separate more chains */

typedef struct weighting_set {
    const lw_weighting *w;
    const lw_structure *s;
    size_t    n, capacity;           /* chains; capacity of the arrays                         */
    uint8_t  *weight;                /* (n, n_line)                                            */
    uint64_t *number;                /* (n)                                                    */
    uint32_t *slot;                  /* (2 capacity) hash table: index of a chain + 1; 0: free */
    uint32_t *same;                  /* (n_same) chains whose number came before, or comes again */
    size_t    n_same, same_capacity;
    lw_tally *tally;
} weighting_set;

static uint64_t scatter(uint64_t x)
{
    x = (x ^ x >> 32)*0xd6e8feb86659fd93u;
    return x ^ x >> 29;
}

/* A number of the chain that its numbering does not change. */
static uint64_t number_of(const lw_chain *c)
{
    uint64_t colour[LW_LINK_MAX], spread[LW_LINK_MAX], number = 0;
    uint8_t to[LW_LINK_MAX][LW_LINK_MAX], degree[LW_LINK_MAX];
    for (int i = 0; i < c->n_link; i++) {
        degree[i] = 0;
        for (uint32_t rest = c->one[i]; rest; rest &= rest - 1)
            to[i][degree[i]++] = (uint8_t)__builtin_ctz(rest);
        colour[i] = degree[i];
    }
    for (int round = 0; round < ROUNDS; round++) {
        for (int i = 0; i < c->n_link; i++)
            spread[i] = scatter(colour[i] + 0x9e3779b97f4a7c15u);
        for (int i = 0; i < c->n_link; i++) {
            uint64_t sum = 3*spread[i];
            for (int k = 0; k < degree[i]; k++)
                sum += spread[to[i][k]];
            colour[i] = sum;
        }
    }
    for (int i = 0; i < c->n_link; i++)
        number += scatter(colour[i]);
    return number;
}

static bool make_room(weighting_set *c)
{
    size_t capacity = c->capacity ? 2*c->capacity : 1024, n_line = (size_t)c->s->n_line;
    uint8_t *weight = realloc(c->weight, capacity*n_line);
    if (weight)
        c->weight = weight;
    uint64_t *number = realloc(c->number, capacity*sizeof *number);
    if (number)
        c->number = number;
    uint32_t *slot = calloc(2*capacity, sizeof *slot);
    if (!weight || !number || !slot) {
        free(slot);
        return false;
    }
    for (size_t i = 0; i < c->n; i++) {
        size_t at = number[i] & (2*capacity - 1);
        while (slot[at])
            at = (at + 1) & (2*capacity - 1);
        slot[at] = (uint32_t)i + 1;
    }
    free(c->slot);
    c->slot = slot;
    c->capacity = capacity;
    return true;
}

static bool note_same(weighting_set *c, size_t chain)
{
    if (c->n_same == c->same_capacity) {
        size_t capacity = c->same_capacity ? 2*c->same_capacity : 64;
        uint32_t *more = realloc(c->same, capacity*sizeof *more);
        if (!more)
            return false;
        c->same = more;
        c->same_capacity = capacity;
    }
    c->same[c->n_same++] = (uint32_t)chain;
    return true;
}

static lw_status add(void *context, const uint8_t *weight)
{
    weighting_set *c = context;
    lw_chain chain;
    uint8_t lowest[LW_LINK_MAX];
    uint32_t rigid;
    lw_status status = lw_structure_chain(c->s, weight, &chain);
    if (status != LW_OK)
        return status;
    if ((c->n == c->capacity && !make_room(c)) || c->n >= UINT32_MAX - 1)
        return LW_E_MEMORY;
    uint64_t number = number_of(&chain);
    if ((number & 63) == 0 && lw_chain_rigid(&chain, lw_chain_mobility(&chain) < 1, &rigid))
        return LW_OK;
    bool first = true, ok = true;
    size_t mask = 2*c->capacity - 1, at = number & mask;
    for (; c->slot[at]; at = (at + 1) & mask)
        if (c->number[c->slot[at] - 1] == number) {
            ok = ok && note_same(c, c->slot[at] - 1);
            first = false;
        }
    c->slot[at] = (uint32_t)c->n + 1;
    c->number[c->n] = number;
    memcpy(c->weight + c->n*(size_t)c->s->n_line, weight, (size_t)c->s->n_line);
    ok = ok && (first || note_same(c, c->n));
    c->n++;
    c->tally->n_ground += (uint64_t)lw_weighting_orbits(c->w, weight, lowest);
    return ok ? LW_OK : LW_E_MEMORY;
}

static int by_index(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static int by_form(const void *a, const void *b) { return memcmp(a, b, sizeof(lw_chain)); }

/* The number of different canonical forms among chains that share their number with another one. */
static lw_status count_same(weighting_set *c, size_t *n_chain, size_t *n_form)
{
    lw_status status = LW_OK;
    size_t n = 0;
    if (c->n_same > 0)
        qsort(c->same, c->n_same, sizeof *c->same, by_index);
    for (size_t i = 0; i < c->n_same; i++)
        if (i == 0 || c->same[i] != c->same[i - 1])
            c->same[n++] = c->same[i];
    lw_chain *form = calloc(n + 1, sizeof *form);
    if (!form)
        return LW_E_MEMORY;
    for (size_t i = 0; status == LW_OK && i < n; i++) {
        lw_chain chain;
        status = lw_structure_chain(c->s, c->weight + (size_t)c->same[i]*(size_t)c->s->n_line, &chain);
        if (status == LW_OK)
            status = lw_chain_canonical(&chain, &form[i]);
    }
    qsort(form, n, sizeof *form, by_form);
    *n_chain = n;
    *n_form = 0;
    for (size_t i = 0; i < n; i++)
        *n_form += i == 0 || memcmp(&form[i], &form[i - 1], sizeof *form) != 0;
    free(form);
    return status;
}

lw_status lw_distinct_count(const lw_weighting *w, lw_tally *tally)
{
    weighting_set c = { .w = w, .s = lw_weighting_structure(w), .tally = tally };
    size_t n_chain = 0, n_form = 0;
    *tally = (lw_tally){ 0, 0, 0 };
    lw_status status = lw_weighting_each(w, add, &c);
    if (status == LW_OK)
        status = count_same(&c, &n_chain, &n_form);
    tally->n_chain = c.n - n_chain + n_form;
    free(c.weight);
    free(c.number);
    free(c.slot);
    free(c.same);
    return status;
}
