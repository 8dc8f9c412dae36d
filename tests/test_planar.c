/* Planarity against Euler and Kuratowski: what is planar shows a + v - e = 2 regions, what is not
 * shows a subdivision of K5 or K3,3. */
#include "check.h"
#include "grammar/topology/planar.h"

typedef struct { int n; uint32_t adj[LW_LINK_MAX]; } graph;

static void join(graph *g, int i, int k)
{
    g->adj[i] |= 1u << k;
    g->adj[k] |= 1u << i;
}

static graph complete(int n)
{
    graph g = { .n = n };
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            join(&g, i, k);
    return g;
}

static graph bipartite(int a, int b)
{
    graph g = { .n = a + b };
    for (int i = 0; i < a; i++)
        for (int k = 0; k < b; k++)
            join(&g, i, a + k);
    return g;
}

static int edges(const graph *g)
{
    int twice = 0;
    for (int i = 0; i < g->n; i++)
        twice += __builtin_popcount(g->adj[i]);
    return twice/2;
}

/* Every edge once in each sense, and the number of regions that Euler wants. */
static void check_regions(const graph *g)
{
    lw_regions r;
    uint32_t seen[LW_LINK_MAX] = { 0 };
    CHECK_INT(lw_planar_regions(g->n, g->adj, &r), LW_OK);
    CHECK_INT(g->n - edges(g) + r.n_region, 2);
    for (int k = 0; k < r.n_region; k++)
        for (int i = r.first[k]; i < r.first[k + 1]; i++) {
            int v = r.vertex[i], w = r.vertex[i + 1 < r.first[k + 1] ? i + 1 : r.first[k]];
            CHECK(g->adj[v] >> w & 1);
            CHECK(!(seen[v] >> w & 1));
            seen[v] |= 1u << w;
        }
    CHECK(!memcmp(seen, g->adj, sizeof(uint32_t)*(size_t)g->n));
}

/* A subgraph whose vertices of degree >= 3 are five of degree 4 or six of degree 3. */
static void check_witness(const graph *g)
{
    uint32_t w[LW_LINK_MAX];
    int with[5] = { 0 };
    CHECK_INT(lw_planar_witness(g->n, g->adj, w), LW_OK);
    for (int i = 0; i < g->n; i++) {
        int d = __builtin_popcount(w[i]);
        CHECK((w[i] & ~g->adj[i]) == 0 && d <= 4 && d != 1);
        with[d < 5 ? d : 0]++;
    }
    CHECK((with[3] == 6 && with[4] == 0) || (with[3] == 0 && with[4] == 5));
}

TEST(known_graphs)
{
    static const struct { int a, b; bool planar; } known[] = {   /* b = 0: complete graph on a */
        { 1, 0, true }, { 2, 0, true }, { 4, 0, true }, { 5, 0, false }, { 6, 0, false },
        { 32, 0, false }, { 2, 30, true }, { 3, 3, false }, { 16, 16, false }, { 1, 31, true },
    };
    for (size_t i = 0; i < sizeof known/sizeof *known; i++) {
        graph g = known[i].b ? bipartite(known[i].a, known[i].b) : complete(known[i].a);
        bool planar;
        CHECK_INT(lw_planar_test(g.n, g.adj, &planar), LW_OK);
        CHECK_INT(planar, known[i].planar);
        if (known[i].planar && g.n > 1)
            check_regions(&g);
        if (!known[i].planar)
            check_witness(&g);
    }
}

/* A wheel-like triangulation of 32 vertices has 3n - 6 edges and 2n - 4 regions; one more edge is
 * too many (Euler). */
TEST(largest_planar_graph)
{
    graph g = bipartite(2, 30);
    for (int i = 0; i < 30; i++)
        join(&g, 2 + i, 2 + (i + 1) % 30);
    CHECK_INT(edges(&g), 3*32 - 6);
    check_regions(&g);
    join(&g, 0, 1);
    check_witness(&g);
}

/* Random connected graphs: a planar one has regions by Euler, another one has a witness. */
TEST(random_graphs)
{
    int n_planar = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 3000; trial++) {
        graph g = { .n = 3 + (int)lw_rng_range(&rng, 0, 14) };
        for (int i = 1; i < g.n; i++)
            join(&g, i, (int)lw_rng_range(&rng, 0, i));
        for (int extra = (int)lw_rng_range(&rng, 0, 1.2*g.n); extra > 0; extra--) {
            int i = (int)lw_rng_range(&rng, 0, g.n), k = (int)lw_rng_range(&rng, 0, g.n);
            if (i != k)
                join(&g, i, k);
        }
        bool planar = false;
        CHECK_INT(lw_planar_test(g.n, g.adj, &planar), LW_OK);
        n_planar += planar;
        if (planar)
            check_regions(&g);
        else
            check_witness(&g);
    }
    CHECK(n_planar > 500 && n_planar < 2900);
}

TEST(refusals)
{
    graph g = complete(4);
    lw_regions r;
    uint32_t w[LW_LINK_MAX];
    bool planar;
    CHECK_INT(lw_planar_witness(g.n, g.adj, w), LW_NOTHING);
    CHECK_INT(lw_planar_test(0, g.adj, &planar), LW_E_ARG);
    CHECK_INT(lw_planar_test(33, g.adj, &planar), LW_E_ARG);
    CHECK_INT(lw_planar_test(3, g.adj, &planar), LW_E_ARG);      /* mask names vertex 3 */
    g.adj[0] |= 1;
    CHECK_INT(lw_planar_test(4, g.adj, &planar), LW_E_ARG);      /* a loop */
    g.adj[0] = 0;
    CHECK_INT(lw_planar_test(4, g.adj, &planar), LW_E_ARG);      /* one-sided */
    graph apart = { .n = 4, .adj = { 2, 1, 8, 4 } };
    CHECK_INT(lw_planar_test(4, apart.adj, &planar), LW_OK);
    CHECK_INT(lw_planar_regions(4, apart.adj, &r), LW_E_ARG);
    g = complete(5);
    CHECK_INT(lw_planar_regions(5, g.adj, &r), LW_NOTHING);
}
