/* tests/all_chains.h - all chains on few links the slow obvious way: every distribution of binary links on
 * every structure, tested by the pebble game, kept once by canonical form. */
#ifndef LW_TESTS_ALL_CHAINS_H
#define LW_TESTS_ALL_CHAINS_H

#include <stdlib.h>
#include "enumerate/canon.h"
#include "enumerate/structures.h"
#include <string.h>
#include "topology.h"

typedef struct chain_list { int n, room; lw_chain *chain; } chain_list;

static inline int by_chain(const void *a, const void *b) { return memcmp(a, b, sizeof(lw_chain)); }

static inline void add_form(chain_list *list, const lw_chain *c)
{
    if (list->n == list->room) {
        list->room = 2*list->room + 64;
        list->chain = realloc(list->chain, sizeof *list->chain*(size_t)list->room);
        if (!list->chain)
            abort();
    }
    memset(&list->chain[list->n], 0, sizeof *c);
    lw_chain_canonical(c, &list->chain[list->n++]);
}

/* Sort the forms and keep each once. */
static inline void prune_forms(chain_list *list)
{
    int n = 0;
    if (list->n == 0)
        return;
    qsort(list->chain, (size_t)list->n, sizeof *list->chain, by_chain);
    for (int i = 0; i < list->n; i++)
        if (i == 0 || by_chain(&list->chain[n - 1], &list->chain[i]) != 0)
            list->chain[n++] = list->chain[i];
    list->n = n;
}

static inline void distribute(chain_list *list, const lw_structure *s, bool baranov, uint8_t *weight, int line, int left)
{
    lw_chain c;
    if (line + 1 < s->n_line) {
        for (int w = 0; w <= left; w++) {
            weight[line] = (uint8_t)w;
            distribute(list, s, baranov, weight, line + 1, left - w);
        }
        return;
    }
    weight[line] = (uint8_t)left;
    if (lw_structure_chain(s, weight, &c) == LW_OK && !lw_chain_rigid(&c, baranov, NULL))
        add_form(list, &c);
}

/* Chains with P links and F freedoms, not fractionated; free list.chain. */
static inline chain_list all_chains(int n_link, int dof)
{
    chain_list list = { 0 };
    int loops = (n_link - dof - 1)/2;
    lw_structures *set;
    if (loops == 1) {
        lw_chain c = ring_of(n_link);
        add_form(&list, &c);
        return list;
    }
    if (lw_structures_create(loops, 1, &set) != LW_OK)
        abort();
    for (size_t i = 0; i < lw_structures_count(set, loops); i++) {
        lw_structure s;
        uint8_t weight[LW_LINE_MAX];
        lw_structures_get(set, loops, i, &s);
        if (n_link >= s.n_circle)
            distribute(&list, &s, dof == 0, weight, 0, n_link - s.n_circle);
    }
    lw_structures_free(set);
    prune_forms(&list);
    return list;
}

#endif
