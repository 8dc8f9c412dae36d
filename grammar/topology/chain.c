/* grammar/topology/chain.c - see chain.h. */
#include <stdio.h>
#include <string.h>
#include "base/number.h"
#include "grammar/topology/chain.h"

#define PEBBLES 3    /* freedoms of a planar link */

lw_status lw_chain_clear(lw_chain *c, int n_link)
{
    if (n_link < 1 || n_link > LW_LINK_MAX)
        return LW_E_ARG;
    *c = (lw_chain){ .n_link = n_link };
    return LW_OK;
}

lw_status lw_chain_join(lw_chain *c, int i, int k, int freedom)
{
    if (i == k || i < 0 || k < 0 || i >= c->n_link || k >= c->n_link || (freedom != 1 && freedom != 2))
        return LW_E_ARG;
    uint32_t *same = freedom == 1 ? c->one : c->two, *other = freedom == 1 ? c->two : c->one;
    if (other[i] >> k & 1)
        return LW_E_ARG;
    same[i] |= (uint32_t)1 << k;
    same[k] |= (uint32_t)1 << i;
    return LW_OK;
}

void lw_chain_unjoin(lw_chain *c, int i, int k)
{
    uint32_t bit_i = (uint32_t)1 << i, bit_k = (uint32_t)1 << k;
    c->one[i] &= ~bit_k;
    c->two[i] &= ~bit_k;
    c->one[k] &= ~bit_i;
    c->two[k] &= ~bit_i;
}

int lw_chain_count(const lw_chain *c, int freedom)
{
    const uint32_t *row = freedom == 1 ? c->one : c->two;
    int n = 0;
    for (int i = 0; i < c->n_link; i++)
        n += __builtin_popcount(row[i]);
    return n/2;
}

int lw_chain_mobility_of(const lw_chain *c, uint32_t links)
{
    int twice = 0;      /* 2 (2 n1 + n2): every joint is seen from both sides */
    for (uint32_t rest = links; rest; rest &= rest - 1) {
        int i = __builtin_ctz(rest);
        twice += 2*__builtin_popcount(c->one[i] & links) + __builtin_popcount(c->two[i] & links);
    }
    return 3*(__builtin_popcount(links) - 1) - twice/2;
}

int lw_chain_mobility(const lw_chain *c) { return lw_chain_mobility_of(c, lw_chain_links(c)); }

int lw_chain_loops(const lw_chain *c)
{
    return lw_chain_count(c, 1) + lw_chain_count(c, 2) - c->n_link + 1;
}

void lw_chain_assortment(const lw_chain *c, int *n_with)
{
    memset(n_with, 0, LW_LINK_MAX*sizeof *n_with);
    for (int i = 0; i < c->n_link; i++)
        n_with[lw_chain_degree(c, i)]++;
}

/* All links that can be reached from the lowest of `links` without leaving `links`. */
static uint32_t reached(const lw_chain *c, uint32_t links)
{
    uint32_t seen = links & -links, fresh = seen;
    while (fresh) {
        int i = __builtin_ctz(fresh);
        fresh &= fresh - 1;
        uint32_t more = lw_chain_neighbours(c, i) & links & ~seen;
        seen |= more;
        fresh |= more;
    }
    return seen;
}

bool lw_chain_is_connected(const lw_chain *c)
{
    return reached(c, lw_chain_links(c)) == lw_chain_links(c);
}

uint32_t lw_chain_cut_links(const lw_chain *c)
{
    uint32_t cut = 0;
    for (int i = 0; i < c->n_link; i++) {
        uint32_t others = lw_chain_links(c) & ~((uint32_t)1 << i);
        if (reached(c, others) != others)
            cut |= (uint32_t)1 << i;
    }
    return cut;
}

/* ---- rigid subchains ---------------------------------------------------------------------------
 * Every link starts with three pebbles; an arc u -> v holds one pebble of u.  A pebble on a link that can
 * be reached from u moves to u when the arcs of the path from u to it are reversed. */
typedef struct game {
    uint8_t  free[LW_LINK_MAX];                 /* pebbles that lie on the link          */
    uint8_t  arc[LW_LINK_MAX][LW_LINK_MAX];     /* number of arcs u -> v                 */
    uint32_t out[LW_LINK_MAX];                  /* links v with arc[u][v] > 0            */
} game;

static void turn_arc(game *g, int u, int v)
{
    if (--g->arc[u][v] == 0)
        g->out[u] &= ~((uint32_t)1 << v);
    if (g->arc[v][u]++ == 0)
        g->out[v] |= (uint32_t)1 << u;
}

/* Bring one more pebble to u without taking those of v; *seen gets the links searched. */
static bool fetch_pebble(game *g, int u, int v, uint32_t *seen)
{
    int from[LW_LINK_MAX], queue[LW_LINK_MAX], head = 0, tail = 0;
    *seen = (uint32_t)1 << u | (uint32_t)1 << v;
    queue[tail++] = u;
    while (head < tail) {
        int i = queue[head++];
        for (uint32_t rest = g->out[i] & ~*seen; rest; rest &= rest - 1) {
            int k = __builtin_ctz(rest);
            from[k] = i;
            if (g->free[k] == 0) {
                queue[tail++] = k;
                *seen |= (uint32_t)1 << k;
                continue;
            }
            g->free[k]--;
            g->free[u]++;
            for (; k != u; k = from[k])
                turn_arc(g, from[k], k);
            return true;
        }
    }
    return false;
}

/* Place one edge u - v.  It needs five of the six pebbles of its ends.  If they cannot be gathered, the
 * links searched have as many edges as they can bear without becoming rigid: *links gets them. */
static bool place_edge(game *g, int u, int v, uint32_t *links)
{
    while (g->free[u] + g->free[v] < 5) {
        uint32_t seen_u = 0, seen_v = 0;
        bool more = (g->free[u] < PEBBLES && fetch_pebble(g, u, v, &seen_u))
                 || (g->free[v] < PEBBLES && fetch_pebble(g, v, u, &seen_v));
        if (!more) {
            *links = seen_u | seen_v | (uint32_t)1 << u | (uint32_t)1 << v;
            return false;
        }
    }
    int tail = g->free[u] ? u : v, head = tail == u ? v : u;
    g->free[tail]--;
    if (g->arc[tail][head]++ == 0)
        g->out[tail] |= (uint32_t)1 << head;
    return true;
}

static bool rigid_among(const lw_chain *c, uint32_t links, uint32_t *rigid)
{
    game g;
    memset(&g, 0, sizeof g);
    memset(g.free, PEBBLES, sizeof g.free);
    for (int u = 0; u < c->n_link; u++) {
        if (!(links >> u & 1))
            continue;
        uint32_t later = links & ~(((uint32_t)2 << u) - 1);
        for (uint32_t rest = lw_chain_neighbours(c, u) & later; rest; rest &= rest - 1) {
            int v = __builtin_ctz(rest);
            for (int copies = 3 - lw_chain_freedom(c, u, v); copies > 0; copies--)
                if (!place_edge(&g, u, v, rigid))
                    return true;
        }
    }
    return false;
}

bool lw_chain_rigid(const lw_chain *c, bool proper, uint32_t *links)
{
    uint32_t found, all = lw_chain_links(c);
    if (!links)
        links = &found;
    if (!proper)
        return rigid_among(c, all, links);
    for (int i = 0; i < c->n_link; i++)         /* a proper subchain lacks some link */
        if (rigid_among(c, all & ~((uint32_t)1 << i), links))
            return true;
    return false;
}

/* "1, 2, 5": links as people number them. */
static void name_links(uint32_t links, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (; links && used < size; links &= links - 1)
        used += (size_t)snprintf(text + used, size - used, "%s%d", used ? ", " : "", __builtin_ctz(links) + 1);
}

lw_status lw_chain_check(const lw_chain *c, lw_error *e)
{
    uint32_t links;
    char text[160];
    if (!lw_chain_is_connected(c)) {
        name_links(reached(c, lw_chain_links(c)), text, sizeof text);
        return lw_error_set(e, LW_E_ARG, "the chain is in pieces: links %s share no joint with the rest", text);
    }
    for (int i = 0; i < c->n_link; i++)
        if (lw_chain_degree(c, i) < 2)
            return lw_error_set(e, LW_E_ARG, "link %d has %d joint%s; every link of a closed chain has two or more",
                                i + 1, lw_chain_degree(c, i), lw_plural(lw_chain_degree(c, i)));
    bool truss = lw_chain_mobility(c) == 0;
    if (lw_chain_rigid(c, truss, &links)) {
        name_links(links, text, sizeof text);
        return lw_error_set(e, LW_E_ARG, "links %s form a rigid subchain (F = %d); treat them as one link",
                            text, lw_chain_mobility_of(c, links));
    }
    return LW_OK;
}

void lw_chain_relabel(const lw_chain *c, const uint8_t *to, lw_chain *out)
{
    lw_chain renamed = { .n_link = c->n_link };
    for (int i = 0; i < c->n_link; i++) {
        for (uint32_t rest = c->one[i]; rest; rest &= rest - 1)
            renamed.one[to[i]] |= (uint32_t)1 << to[__builtin_ctz(rest)];
        for (uint32_t rest = c->two[i]; rest; rest &= rest - 1)
            renamed.two[to[i]] |= (uint32_t)1 << to[__builtin_ctz(rest)];
    }
    *out = renamed;
}

bool lw_chain_same(const lw_chain *a, const lw_chain *b)
{
    size_t size = (size_t)a->n_link*sizeof a->one[0];
    return a->n_link == b->n_link && memcmp(a->one, b->one, size) == 0 && memcmp(a->two, b->two, size) == 0;
}
