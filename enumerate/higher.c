#include "enumerate/higher.h"

#include <stdlib.h>
#include "enumerate/canon.h"

typedef struct marking {
    const lw_chain *chain;
    uint32_t        binary;                   /* links that may be marked                            */
    uint8_t       (*symmetry)[LW_GRAPH_MAX];  /* NULL until a set of marks is complete                */
    size_t          n_symmetry;
    int             n_mark;
    lw_higher_visit *visit;
    bool          (*go_on)(void *context);    /* NULL: always */
    void           *context;
} marking;

/* The two links beside a binary link. */
static uint32_t beside(const lw_chain *c, int link) { return lw_chain_neighbours(c, link); }

/* True if link i can be marked too: it touches no marked link and makes no second joint between two links. */
static bool fits(const lw_chain *c, uint32_t marks, int i)
{
    uint32_t pair = beside(c, i);
    int a = __builtin_ctz(pair);
    if (pair & marks || lw_chain_neighbours(c, a) & pair)
        return false;
    for (; marks; marks &= marks - 1)
        if (beside(c, __builtin_ctz(marks)) == pair)
            return false;
    return true;
}

static lw_status find_symmetry(marking *k)
{
    lw_graph g;
    if (k->symmetry)
        return LW_OK;
    lw_graph_of_chain(k->chain, &g);
    return lw_graph_elements(&g, &k->symmetry, &k->n_symmetry);
}

/* True if this set is the first of its equivalent sets: it contains the lowest link in which they differ. */
static bool is_first(const marking *k, uint32_t marks)
{
    for (size_t g = 1; g < k->n_symmetry; g++) {
        uint32_t image = 0;
        for (uint32_t left = marks; left; left &= left - 1)
            image |= 1u << k->symmetry[g][__builtin_ctz(left)];
        uint32_t differ = image ^ marks;
        if (differ && image & (differ & -differ))
            return false;
    }
    return true;
}

/* Shrink the marked links to joints of two freedoms. */
static lw_chain shrink(const lw_chain *c, uint32_t marks)
{
    lw_chain out;
    uint8_t number[LW_LINK_MAX];
    int n = 0;
    for (int i = 0; i < c->n_link; i++)
        if (!(marks >> i & 1))
            number[i] = (uint8_t)n++;
    lw_chain_clear(&out, n);
    for (int i = 0; i < c->n_link; i++) {
        uint32_t next = lw_chain_neighbours(c, i);
        if (marks >> i & 1)
            lw_chain_join(&out, number[__builtin_ctz(next)], number[31 - __builtin_clz(next)], 2);
        else
            for (next &= ~marks; next; next &= next - 1)
                lw_chain_join(&out, number[i], number[__builtin_ctz(next)], 1);
    }
    return out;
}

static lw_status mark(marking *k, int n, int from, uint32_t marks)
{
    lw_status s = LW_OK;
    if (n == 0) {
        s = find_symmetry(k);
        if (s == LW_OK && is_first(k, marks)) {
            lw_chain c = shrink(k->chain, marks);
            s = k->visit(k->context, &c);
        }
        return s;
    }
    for (int i = from; i < k->chain->n_link && s == LW_OK && __builtin_popcount(k->binary >> i) >= n; i++)
        if (k->binary >> i & 1 && fits(k->chain, marks, i))
            s = mark(k, n - 1, i + 1, marks | 1u << i);
    return s;
}

static lw_status mark_chain(void *context, const lw_chain_item *item)
{
    marking k = *(marking *)context;
    k.chain = item->chain;
    for (int i = 0; i < item->chain->n_link; i++)
        k.binary |= (uint32_t)(lw_chain_degree(item->chain, i) == 2) << i;
    lw_status s = __builtin_popcount(k.binary) < k.n_mark ? LW_OK : mark(&k, k.n_mark, 0, 0);
    free(k.symmetry);
    return s;
}

static bool grow_tick(void *context, int loops, size_t found)
{
    const marking *k = context;
    (void)loops;
    (void)found;
    return !k->go_on || k->go_on(k->context);
}

static bool walk_tick(void *context, double done) { return grow_tick(context, 0, (size_t)done); }

lw_status lw_higher_each(int n_link, int dof, int n2, int n_thread, lw_higher_visit *visit, void *context, lw_error *e)
{
    return lw_higher_each_while(n_link, dof, n2, n_thread, NULL, visit, context, e);
}

lw_status lw_higher_each_while(int n_link, int dof, int n2, int n_thread, bool (*go_on)(void *context),
                               lw_higher_visit *visit, void *context, lw_error *e)
{
    marking k = { .n_mark = n2, .visit = visit, .go_on = go_on, .context = context };
    lw_numbers numbers;
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    lw_status s = lw_numbers_for_links(n_link, dof, n2, &numbers, e);
    if (s == LW_OK && n_link + n2 > LW_LINK_MAX)
        s = lw_error_set(e, LW_E_ARG, "links and joints of two freedoms together may be %d at most", LW_LINK_MAX);
    if (s == LW_OK)
        s = lw_chains_create_within(n_link + n2, dof, n_link, n_thread, grow_tick, &k, &chains, e);
    if (s != LW_OK)
        return s;
    how.n_thread = n_thread;
    how.tick = walk_tick;
    how.tick_context = &k;
    s = lw_chains_each(chains, &how, mark_chain, &k);
    lw_chains_free(chains);
    return s;
}
