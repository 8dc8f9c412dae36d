#include "grammar/topology/circuit.h"

#include <string.h>

typedef struct graph {
    int             n;
    const uint32_t *adjacent;
    uint8_t         edge[LW_LINK_MAX][LW_LINK_MAX];     /* number of the edge              */
    uint8_t         far[LW_LINK_MAX][LW_LINK_MAX];      /* distance, 255 when not reached  */
    uint8_t         toward[LW_LINK_MAX][LW_LINK_MAX];   /* [v][x]: the step from x to v    */
} graph;

bool lw_gf2_add(uint64_t *row_of, int *n_row, uint64_t row)
{
    for (int i = 0; i < *n_row; i++)
        if (row & (row_of[i] & -row_of[i]))
            row ^= row_of[i];
    if (!row)
        return false;
    row_of[(*n_row)++] = row;
    return true;
}

/* Breadth-first search from v; among paths of equal length the one through the lower vertex. */
static void paths_from(graph *g, int v)
{
    uint8_t queue[LW_LINK_MAX];
    int head = 0, tail = 0;
    memset(g->far[v], 255, sizeof g->far[v]);
    g->far[v][v] = 0;
    queue[tail++] = (uint8_t)v;
    while (head < tail) {
        int x = queue[head++];
        for (uint32_t m = g->adjacent[x]; m; m &= m - 1) {
            int y = __builtin_ctz(m);
            if (g->far[v][y] == 255) {
                g->far[v][y] = (uint8_t)(g->far[v][x] + 1);
                g->toward[v][y] = (uint8_t)x;
                queue[tail++] = (uint8_t)y;
            }
        }
    }
}

/* The circuit through v and edge xy: its vertices into walk, its edges as bits; 0 when the two paths
 * share more than v. */
static uint64_t circuit_of(const graph *g, int v, int x, int y, uint8_t *walk)
{
    uint32_t seen = 1u << v;
    uint64_t edges = (uint64_t)1 << g->edge[x][y];
    int n = 0, n_x = g->far[v][x];
    for (int at = x; at != v; at = g->toward[v][at]) {
        walk[n_x - 1 - n++] = (uint8_t)at;
        seen |= 1u << at;
        edges |= (uint64_t)1 << g->edge[at][g->toward[v][at]];
    }
    for (int at = y; at != v; at = g->toward[v][at]) {
        if (seen >> at & 1)
            return 0;
        walk[n++] = (uint8_t)at;
        edges |= (uint64_t)1 << g->edge[at][g->toward[v][at]];
    }
    walk[n] = (uint8_t)v;
    return edges;
}

static void add_of_length(const graph *g, int length, uint64_t *rows, int *n_row, lw_chain_circuits *c)
{
    for (int v = 0; v < g->n; v++)
        for (int x = 0; x < g->n; x++)
            for (uint32_t m = g->adjacent[x] & ~((2u << x) - 1); m; m &= m - 1) {
                int y = __builtin_ctz(m);
                if (g->far[v][x] == 255 || g->far[v][x] + g->far[v][y] + 1 != length)
                    continue;
                uint8_t *walk = c->vertex + c->first[c->n_circuit], scratch[2*LW_LINK_MAX];
                uint64_t edges = circuit_of(g, v, x, y, scratch);
                if (edges && lw_gf2_add(rows, n_row, edges)) {
                    memcpy(walk, scratch, (size_t)length);
                    c->first[++c->n_circuit] = (int)(walk - c->vertex) + length;
                }
            }
}

lw_status lw_circuit_basis(int n, const uint32_t *adjacent, lw_chain_circuits *c)
{
    graph g = { .n = n, .adjacent = adjacent };
    uint64_t rows[LW_JOINT_MAX];
    int n_edge = 0, n_row = 0;
    for (int x = 0; x < n; x++)
        for (uint32_t m = adjacent[x] & ~((2u << x) - 1); m; m &= m - 1) {
            if (n_edge == LW_JOINT_MAX)
                return LW_E_ARG;
            g.edge[x][__builtin_ctz(m)] = g.edge[__builtin_ctz(m)][x] = (uint8_t)n_edge++;
        }
    for (int v = 0; v < n; v++)
        paths_from(&g, v);
    c->n_circuit = 0;
    c->first[0] = 0;
    for (int length = 3; length <= n; length++)
        add_of_length(&g, length, rows, &n_row, c);
    return LW_OK;
}
