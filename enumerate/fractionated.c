/* enumerate/fractionated.c - see fractionated.h. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/fractionated.h"

/* Rooted chains: link 0 is the root.  A branch has its root in one block only; a branch set is one branch or
 * more on one root.  Sorted by p links besides the root and f freedoms. */
typedef struct rooted { lw_chain chain; int n_bridge; } rooted;
typedef struct rooted_list { size_t n, room; rooted *at; } rooted_list;

#define BRANCH_LINK_MAX (LW_LINK_MAX/2)

typedef struct branch_table {
    rooted_list branch[BRANCH_LINK_MAX + 1][LW_DOF_MAX + 1], branch_set[BRANCH_LINK_MAX + 1][LW_DOF_MAX + 1];
    int   most;                          /* links besides the root, at most                        */
} branch_table;

static lw_status put(rooted_list *s, const rooted *r)
{
    if (s->n == s->room) {
        size_t room = s->room ? 2*s->room : 4;
        rooted *at = realloc(s->at, room*sizeof *at);
        if (!at)
            return LW_E_MEMORY;
        s->at = at;
        s->room = room;
    }
    s->at[s->n++] = *r;
    return LW_OK;
}

static void free_branch_table(branch_table *y)
{
    for (int p = 0; p <= BRANCH_LINK_MAX; p++)
        for (int f = 0; f <= LW_DOF_MAX; f++) {
            free(y->branch[p][f].at);
            free(y->branch_set[p][f].at);
        }
    free(y);
}

/* Glue a rooted chain to link `at`: its root becomes that link, its other links get new numbers. */
static void glue(rooted *r, int at, const rooted *part)
{
    lw_chain *c = &r->chain;
    int base = c->n_link - 1;                                    /* link i > 0 of part becomes base + i */
    for (int i = 0; i < part->chain.n_link; i++) {
        int to = i ? base + i : at;
        for (uint32_t rest = part->chain.one[i]; rest; rest &= rest - 1) {
            int k = __builtin_ctz(rest);
            c->one[to] |= (uint32_t)1 << (k ? base + k : at);
        }
    }
    c->n_link += part->chain.n_link - 1;
    r->n_bridge += part->n_bridge;
}

/* ---- branch sets on the links of one block ------------------------------------------------------------ */

/* A branch set on a link; p = 0: none. */
typedef struct set_on_link { uint8_t p, f; uint32_t index; } set_on_link;

typedef lw_status take_rooted(void *context, const rooted *r);

/* Distribution of branch sets with p links and f freedoms in total over the links of a block, up to the automorphisms
 * that keep `root` (-1: all automorphisms). */
typedef struct attaching {
    const branch_table *y;
    const lw_chain *block;
    int             n_bridge;            /* 1 when the block is a bridge joint                     */
    int             root;                /* gets nothing; -1: no root                              */
    int             limit;               /* links in one branch set, at most                          */
    bool            every;               /* every link but the root must get something             */
    const uint8_t (*element)[LW_GRAPH_MAX];
    size_t          n_element;
    set_on_link         on[LW_LINK_MAX];
    take_rooted    *take;
    void           *context;
} attaching;

static int compare(const set_on_link *a, const set_on_link *b)
{
    if (a->p != b->p)
        return a->p < b->p ? -1 : 1;
    if (a->f != b->f)
        return a->f < b->f ? -1 : 1;
    return (a->index > b->index) - (a->index < b->index);
}

/* True if no image of the distribution is larger. */
static bool largest(const attaching *d)
{
    for (size_t g = 1; g < d->n_element; g++) {
        const uint8_t *to = d->element[g];
        int order = 0;
        if (d->root >= 0 && to[d->root] != d->root)
            continue;
        for (int i = 0; i < d->block->n_link && order == 0; i++)
            order = compare(&d->on[to[i]], &d->on[i]);
        if (order > 0)
            return false;
    }
    return true;
}

static lw_status finish_attaching(const attaching *d)
{
    if (!largest(d))
        return LW_OK;
    rooted r = { *d->block, d->n_bridge };
    for (int i = 0; i < d->block->n_link; i++)
        if (d->on[i].p)
            glue(&r, i, &d->y->branch_set[d->on[i].p][d->on[i].f].at[d->on[i].index]);
    return d->take(d->context, &r);
}

/* Distribute branch sets with p links and f freedoms in total over the links from `link` on of the block. */
static lw_status attach(attaching *d, int link, int p, int f)
{
    if (link == d->block->n_link)
        return p == 0 && f == 0 ? finish_attaching(d) : LW_OK;
    lw_status status = LW_OK;
    d->on[link] = (set_on_link){ 0, 0, 0 };
    if (link == d->root || !d->every)
        status = attach(d, link + 1, p, f);
    if (link == d->root)
        return status;
    for (int bp = 1; bp <= p && bp <= d->limit; bp++)
        for (int bf = 1; bf <= f; bf++)
            for (size_t k = 0; k < d->y->branch_set[bp][bf].n && status == LW_OK; k++) {
                d->on[link] = (set_on_link){ (uint8_t)bp, (uint8_t)bf, (uint32_t)k };
                status = attach(d, link + 1, p - bp, f - bf);
            }
    d->on[link] = (set_on_link){ 0, 0, 0 };
    return status;
}

/* The same after computing the block's symmetry; with `rooted_too` for all roots up to symmetry. */
static lw_status attach_to_block(attaching *d, bool rooted_too, int p, int f)
{
    lw_graph g;
    lw_symmetry_group group;
    uint8_t (*element)[LW_GRAPH_MAX] = NULL;
    lw_graph_of_chain(d->block, &g);
    lw_status status = lw_graph_group(&g, &group);
    if (status == LW_OK)
        status = lw_symmetry_group_elements(&group, &element, &d->n_element);
    d->element = (const uint8_t (*)[LW_GRAPH_MAX])element;
    d->root = -1;
    if (status == LW_OK && !rooted_too)
        status = attach(d, 0, p, f);
    for (int i = 0; i < d->block->n_link && status == LW_OK && rooted_too; i++) {
        d->root = i;
        if (group.orbit[i] == i)
            status = attach(d, 0, p, f);
    }
    free(element);
    lw_symmetry_group_free(&group);
    return status;
}

/* A bridge joint as block; each of its links must have another joint. */
static lw_status attach_to_bridge(attaching *d, bool rooted_too, int p, int f)
{
    static const lw_chain bridge = { .n_link = 2, .one = { 2, 1 } };
    d->block = &bridge;
    d->n_bridge = 1;
    d->every = true;
    lw_status status = attach_to_block(d, rooted_too, p, f);
    d->n_bridge = 0;
    d->every = false;
    return status;
}

/* ---- all blocks of a size ------------------------------------------------------------------------- */

typedef struct block_walk { attaching *d; bool rooted_too; int p, f; } block_walk;

static lw_status visit_block(void *context, const lw_chain_item *item)
{
    block_walk *w = context;
    w->d->block = item->chain;
    return attach_to_block(w->d, w->rooted_too, w->p, w->f);
}

static lw_status each_block(int n_link, int dof, block_walk *w)
{
    bool bare = w->p == 0 && w->f == 0, filled = w->p >= 3 && w->f > 0;     /* a four-bar adds three links */
    if (n_link < dof + 3 || (n_link - dof - 1) % 2 != 0 || !(bare || filled))
        return LW_OK;
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    lw_status status = lw_chains_create(n_link, dof, 1, &chains, NULL);
    if (status != LW_OK)
        return status;
    status = lw_chains_each(chains, &how, visit_block, w);
    lw_chains_free(chains);
    return status;
}

/* ---- branches and branch sets ---------------------------------------------------------------------- */

/* Append a branch to its list, with its root as link 0. */
typedef struct list_target { rooted_list *s; attaching *d; } list_target;

static lw_status put_branch(void *context, const rooted *r)
{
    list_target *to = context;
    uint8_t place[LW_LINK_MAX];
    rooted branch = { .n_bridge = r->n_bridge };
    for (int i = 0; i < r->chain.n_link; i++)
        place[i] = (uint8_t)i;
    place[to->d->root] = 0;
    place[0] = (uint8_t)to->d->root;
    lw_chain_relabel(&r->chain, place, &branch.chain);
    return put(to->s, &branch);
}

static lw_status grow_branches(branch_table *y, int p, int f)
{
    attaching d = { .y = y, .limit = y->most, .take = put_branch };
    list_target to = { &y->branch[p][f], &d };
    d.context = &to;
    lw_status status = attach_to_bridge(&d, true, p - 1, f - 1);
    for (int n_link = 4; n_link <= p + 1 && status == LW_OK; n_link++)
        for (int dof = 1; dof <= f && status == LW_OK; dof++) {
            block_walk w = { &d, true, p + 1 - n_link, f - dof };
            status = each_block(n_link, dof, &w);
        }
    return status;
}

/* All multisets of at least `least` branches with p links and f freedoms in total, no branch larger than `limit`.
 * Branches are taken in falling order of (p, f, index); `before` is the last one taken. */
typedef struct composing {
    const branch_table *y;
    int            limit, least;
    int            bridge_limit;         /* the same for branches that begin with a bridge joint   */
    take_rooted   *take;
    void          *context;
} composing;

static lw_status compose(const composing *b, const rooted *sofar, set_on_link before, int n, int p, int f)
{
    if (p == 0)
        return f == 0 && n >= b->least ? b->take(b->context, sofar) : LW_OK;
    lw_status status = LW_OK;
    for (int bp = p < b->limit ? p : b->limit; bp > 0; bp--)
        for (int bf = f; bf > 0; bf--)
            for (size_t k = b->y->branch[bp][bf].n; k-- > 0 && status == LW_OK; ) {
                set_on_link next = { (uint8_t)bp, (uint8_t)bf, (uint32_t)k };
                const rooted *branch = &b->y->branch[bp][bf].at[k];
                bool begins_with_bridge = lw_chain_degree(&branch->chain, 0) == 1;
                if (compare(&next, &before) > 0 || (begins_with_bridge && bp > b->bridge_limit))
                    continue;
                rooted more = *sofar;
                glue(&more, 0, branch);
                status = compose(b, &more, next, n + 1, p - bp, f - bf);
            }
    return status;
}

static lw_status compose_all(const composing *b, int p, int f)
{
    rooted root = { { .n_link = 1 }, 0 };
    return compose(b, &root, (set_on_link){ UINT8_MAX, 0, 0 }, 0, p, f);
}

static lw_status put_branch_set(void *context, const rooted *r) { return put(context, r); }

static lw_status fill_branch_table(branch_table *y, int dof)
{
    lw_status status = LW_OK;
    for (int p = 3; p <= y->most && status == LW_OK; p++)
        for (int f = 1; f < dof && status == LW_OK; f++) {
            composing b = { y, y->most, 1, y->most, put_branch_set, &y->branch_set[p][f] };
            status = grow_branches(y, p, f);
            if (status == LW_OK)
                status = compose_all(&b, p, f);
        }
    return status;
}

/* ---- whole chains --------------------------------------------------------------------------------- */

typedef struct visitor { lw_fractionated_visit *visit; void *context; } visitor;

static lw_status pass_on(void *context, const rooted *r)
{
    visitor *g = context;
    return g->visit(g->context, &r->chain, r->n_bridge);
}

static lw_status each_middle(const branch_table *y, int n_link, int dof, visitor *to)
{
    composing link = { y, n_link/2, 2, (n_link - 1)/2, pass_on, to };
    lw_status status = compose_all(&link, n_link - 1, dof);
    attaching bridge = { .y = y, .limit = n_link/2 - 1, .take = pass_on, .context = to };
    if (status == LW_OK && n_link % 2 == 0)
        status = attach_to_bridge(&bridge, false, n_link - 2, dof - 1);
    for (int size = 4; size < n_link && status == LW_OK; size++)
        for (int f = 1; f < dof && status == LW_OK; f++) {
            attaching d = { .y = y, .limit = (n_link - 1)/2 - 1, .take = pass_on, .context = to };
            block_walk w = { &d, false, n_link - size, dof - f };
            status = each_block(size, f, &w);
        }
    return status;
}

lw_status lw_fractionated_each(int n_link, int dof, lw_fractionated_visit *visit, void *context, lw_error *e)
{
    lw_numbers numbers;
    lw_status status = lw_numbers_for_links(n_link, dof, 0, &numbers, e);
    if (status != LW_OK)
        return status;
    branch_table *y = calloc(1, sizeof *y);
    if (!y)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    visitor to = { visit, context };
    y->most = n_link/2;
    status = fill_branch_table(y, dof);
    if (status == LW_OK)
        status = each_middle(y, n_link, dof, &to);
    free_branch_table(y);
    return status;
}
