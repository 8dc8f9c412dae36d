/* grammar/topology/planar.c - the only file that includes libplanarity.  Its vertices count from 1. */
#include "grammar/topology/planar.h"

#include <planarity/graph.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static lw_status check_masks(int n, const uint32_t *adjacent)
{
    if (n < 1 || n > LW_LINK_MAX)
        return LW_E_ARG;
    uint32_t all = n == 32 ? ~0u : (1u << n) - 1;
    for (int i = 0; i < n; i++) {
        if (adjacent[i] & ~all || adjacent[i] >> i & 1)
            return LW_E_ARG;
        for (uint32_t m = adjacent[i]; m; m &= m - 1)
            if (!(adjacent[__builtin_ctz(m)] >> i & 1))
                return LW_E_ARG;
    }
    return LW_OK;
}

static int edge_count(int n, const uint32_t *adjacent)
{
    int twice = 0;
    for (int i = 0; i < n; i++)
        twice += __builtin_popcount(adjacent[i]);
    return twice/2;
}

/* Embed into *g, which the caller frees also after a failure.  A graph with more than 3n - 6 edges is passed to
 * libplanarity too, because the caller may need the witness. */
static lw_status embed(int n, const uint32_t *adjacent, graphP *g, bool *planar)
{
    lw_status s = check_masks(n, adjacent);
    *g = NULL;
    if (s != LW_OK)
        return s;
    int n_edge = edge_count(n, adjacent);
    *g = gp_New();
    if (!*g || gp_EnsureArcCapacity(*g, 2*(n_edge + 3*n)) != OK)
        return LW_E_MEMORY;
    if (gp_InitGraph(*g, n) != OK) {
        free(*g);                /* it has freed what is in the graph; gp_Free() would free it again and abort */
        *g = NULL;
        return LW_E_MEMORY;
    }
    for (int i = 0; i < n; i++)
        for (uint32_t m = adjacent[i] >> i; m; m &= m - 1)
            if (gp_AddEdge(*g, i + 1, 0, i + 1 + __builtin_ctz(m), 0) != OK)
                return LW_E_MEMORY;
    int r = gp_Embed(*g, EMBEDFLAGS_PLANAR);
    if (r != OK && r != NONEMBEDDABLE)
        return LW_E_MEMORY;
    *planar = r == OK;
    return gp_SortVertices(*g) == OK ? LW_OK : LW_E_MEMORY;   /* back to our numbering */
}

lw_status lw_planar_test(int n, const uint32_t *adjacent, bool *planar)
{
    graphP g;
    lw_status s = embed(n, adjacent, &g, planar);
    gp_Free(&g);
    return s;
}

lw_status lw_planar_chain(const lw_chain *c, bool *planar)
{
    uint32_t row[LW_LINK_MAX];
    for (int i = 0; i < c->n_link; i++)
        row[i] = lw_chain_neighbours(c, i);
    return lw_planar_test(c->n_link, row, planar);
}

static bool connected(int n, const uint32_t *adjacent)
{
    uint32_t seen = 1, front = 1;
    while (front) {
        uint32_t next = 0;
        for (; front; front &= front - 1)
            next |= adjacent[__builtin_ctz(front)];
        front = next & ~seen;
        seen |= next;
    }
    return __builtin_popcount(seen) == n;
}

/* after[v][w]: the vertex that follows w in the ring of neighbours around v. */
static void read_rings(graphP g, int n, uint8_t after[LW_LINK_MAX][LW_LINK_MAX])
{
    for (int v = 0; v < n; v++) {
        int first = gp_GetFirstArc(g, v + 1);
        for (int e = first; gp_IsArc(e); e = gp_GetNextArc(g, e)) {
            int next = gp_IsArc(gp_GetNextArc(g, e)) ? gp_GetNextArc(g, e) : first;
            after[v][gp_GetNeighbor(g, e) - 1] = (uint8_t)(gp_GetNeighbor(g, next) - 1);
        }
    }
}

/* Walk along every side once: from v to w, then to the neighbour of w that follows v. */
static void trace_regions(int n, const uint32_t *adjacent, uint8_t after[LW_LINK_MAX][LW_LINK_MAX], lw_regions *r)
{
    uint32_t walked[LW_LINK_MAX] = { 0 };
    int n_side = 0;
    r->n_region = 0;
    for (int i = 0; i < n; i++)
        for (uint32_t m; (m = adjacent[i] & ~walked[i]);) {
            int v = i, w = __builtin_ctz(m);
            r->first[r->n_region++] = n_side;
            while (!(walked[v] >> w & 1)) {
                walked[v] |= 1u << w;
                r->vertex[n_side++] = (uint8_t)v;
                int next = after[w][v];
                v = w;
                w = next;
            }
        }
    r->first[r->n_region] = n_side;
}

lw_status lw_planar_regions(int n, const uint32_t *adjacent, lw_regions *r)
{
    graphP g;
    bool planar = false;
    uint8_t after[LW_LINK_MAX][LW_LINK_MAX];
    lw_status s = embed(n, adjacent, &g, &planar);
    if (s == LW_OK && (n < 2 || !connected(n, adjacent)))
        s = LW_E_ARG;
    if (s == LW_OK && !planar)
        s = LW_NOTHING;
    if (s == LW_OK) {
        read_rings(g, n, after);
        trace_regions(n, adjacent, after, r);
    }
    gp_Free(&g);
    return s;
}

lw_status lw_planar_witness(int n, const uint32_t *adjacent, uint32_t *witness)
{
    graphP g;
    bool planar = false;
    lw_status s = embed(n, adjacent, &g, &planar);
    if (s == LW_OK && planar)
        s = LW_NOTHING;
    if (s == LW_OK) {                        /* libplanarity leaves only the witness in the graph */
        memset(witness, 0, (size_t)n*sizeof *witness);
        for (int v = 0; v < n; v++)
            for (int e = gp_GetFirstArc(g, v + 1); gp_IsArc(e); e = gp_GetNextArc(g, e))
                witness[v] |= 1u << (gp_GetNeighbor(g, e) - 1);
    }
    gp_Free(&g);
    return s;
}
