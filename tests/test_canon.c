/* test_canon.c - canonical form and symmetry: renaming changes nothing, different graphs stay different
 * (counts of all graphs on few vertices), groups of graphs whose groups are known. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"
#include "tests/check.h"

static void tie(lw_graph *g, int i, int k, int value)
{
    g->tie[i][k] = g->tie[k][i] = (uint8_t)value;
}

static lw_graph renamed(const lw_graph *g, const uint8_t *to)
{
    lw_graph h = { .n = g->n };
    for (int i = 0; i < g->n; i++) {
        h.colour[to[i]] = g->colour[i];
        for (int k = 0; k < g->n; k++)
            h.tie[to[i]][to[k]] = g->tie[i][k];
    }
    return h;
}

static lw_graph form_of(const lw_graph *g)
{
    uint8_t to[LW_GRAPH_MAX], seen[LW_GRAPH_MAX] = { 0 };
    CHECK_INT(lw_graph_label(g, to), LW_OK);
    for (int i = 0; i < g->n; i++)
        CHECK(to[i] < g->n && !seen[to[i]]++);
    return renamed(g, to);
}

/* to (LW_GRAPH_MAX): a random permutation of the first n, the others stay */
static void shuffle(lw_rng *r, int n, uint8_t *to)
{
    for (int i = 0; i < LW_GRAPH_MAX; i++)
        to[i] = (uint8_t)i;
    for (int i = n - 1; i > 0; i--) {
        int k = (int)(lw_rng_bits(r) % (uint64_t)(i + 1));
        uint8_t swap = to[i];
        to[i] = to[k];
        to[k] = swap;
    }
}

/* ---- graphs with names -------------------------------------------------------------------------- */

/* Vertex i is joined to i + jump[k] (mod n). */
static lw_graph circulant(int n, const int *jump, int n_jump)
{
    lw_graph g = { .n = n };
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n_jump; k++)
            tie(&g, i, (i + jump[k]) % n, 1);
    return g;
}

static lw_graph cycle(int n) { return circulant(n, (int[]){ 1 }, 1); }

static lw_graph complete(int n)
{
    lw_graph g = { .n = n };
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++)
            tie(&g, i, k, 1);
    return g;
}

static lw_graph complete_bipartite(int a, int b)
{
    lw_graph g = { .n = a + b };
    for (int i = 0; i < a; i++)
        for (int k = 0; k < b; k++)
            tie(&g, i, a + k, 1);
    return g;
}

static lw_graph cube(int dimension)
{
    lw_graph g = { .n = 1 << dimension };
    for (int i = 0; i < g.n; i++)
        for (int d = 0; d < dimension; d++)
            tie(&g, i, i ^ 1 << d, 1);
    return g;
}

/* generalised Petersen graph: outer cycle, spokes, inner star polygon */
static lw_graph petersen(int n, int step)
{
    lw_graph g = { .n = 2*n };
    for (int i = 0; i < n; i++) {
        tie(&g, i, (i + 1) % n, 1);
        tie(&g, i, n + i, 1);
        tie(&g, n + i, n + (i + step) % n, 1);
    }
    return g;
}

static lw_graph heawood(void)
{
    lw_graph g = cycle(14);
    for (int i = 0; i < 14; i += 2)
        tie(&g, i, (i + 5) % 14, 1);
    return g;
}

static size_t order_of(const lw_graph *g)
{
    OWN(lw_symmetry_group) group = { 0 };
    uint8_t (*element)[LW_GRAPH_MAX];
    size_t n;
    CHECK_INT(lw_graph_group(g, &group), LW_OK);
    CHECK_INT(lw_symmetry_group_elements(&group, &element, &n), LW_OK);
    for (size_t k = 0; k < n; k++) {
        lw_graph same = renamed(g, element[k]);
        CHECK(memcmp(&same, g, sizeof same) == 0);
        for (int i = 0; i < g->n; i++) {
            CHECK_INT(group.orbit[element[k][i]], group.orbit[i]);
            CHECK(group.orbit[i] <= i && (k > 0 || element[k][i] == i));
        }
    }
    free(element);
    return n;
}

TEST(known_groups)
{
    lw_graph g = { .n = 1 };
    CHECK_INT(order_of(&g), 1);
    g = cycle(9);                 CHECK_INT(order_of(&g), 18);
    g = cycle(32);                CHECK_INT(order_of(&g), 64);
    g = complete(6);              CHECK_INT(order_of(&g), 720);
    g = complete_bipartite(3, 3); CHECK_INT(order_of(&g), 72);
    g = complete_bipartite(3, 5); CHECK_INT(order_of(&g), 720);
    g = cube(3);                  CHECK_INT(order_of(&g), 48);
    g = cube(5);                  CHECK_INT(order_of(&g), 3840);
    g = petersen(5, 2);           CHECK_INT(order_of(&g), 120);
    g = petersen(8, 3);           CHECK_INT(order_of(&g), 96);      /* Moebius-Kantor */
    g = heawood();                CHECK_INT(order_of(&g), 336);
    g = cycle(6);
    tie(&g, 0, 1, 2);                                               /* one edge doubled: a reflection stays */
    CHECK_INT(order_of(&g), 2);
    g = cycle(6);
    g.colour[2] = 1;
    CHECK_INT(order_of(&g), 2);
    g.colour[3] = 2;
    CHECK_INT(order_of(&g), 1);
}

static lw_graph random_graph(lw_rng *r)
{
    lw_graph g = { .n = 1 + (int)(lw_rng_bits(r) % LW_GRAPH_MAX) };
    uint64_t density = lw_rng_bits(r) % 16, colours = 1 + lw_rng_bits(r) % 3, ties = 1 + lw_rng_bits(r) % 3;
    for (int i = 0; i < g.n; i++) {
        g.colour[i] = (uint8_t)(lw_rng_bits(r) % colours);
        for (int k = 0; k < i; k++)
            if (lw_rng_bits(r) % 16 < density)
                tie(&g, i, k, 1 + (int)(lw_rng_bits(r) % ties));
    }
    return g;
}

TEST(renaming_keeps_the_form)
{
    lw_rng r = check_rng(1);
    lw_graph named[] = { cycle(10), complete(8), complete_bipartite(4, 5), cube(4), petersen(5, 2), heawood(),
                         petersen(7, 2), petersen(10, 3), circulant(13, (int[]){ 1, 5 }, 2) };
    int n_named = sizeof named/sizeof *named;
    for (int trial = 0; trial < 1000; trial++) {
        lw_graph g = trial < 20*n_named ? named[trial % n_named] : random_graph(&r);
        uint8_t to[LW_GRAPH_MAX];
        shuffle(&r, g.n, to);
        lw_graph h = renamed(&g, to), form_g = form_of(&g), form_h = form_of(&h);
        CHECK(memcmp(&form_g, &form_h, sizeof form_g) == 0);
    }
}

/* Different canonical forms among all graphs on n vertices with ties 0 .. most. */
static size_t count_classes(int n, int most)
{
    size_t n_class = 0, room = 1024;
    lw_graph *form = malloc(room*sizeof *form), g = { .n = n };
    int pair[16][2], n_pair = 0;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < i; k++, n_pair++) {
            pair[n_pair][0] = i;
            pair[n_pair][1] = k;
        }
    for (bool more = true; more; ) {
        lw_graph f = form_of(&g);
        size_t k = 0;
        while (k < n_class && memcmp(&form[k], &f, sizeof f) != 0)
            k++;
        if (k == n_class && n_class < room)
            form[n_class++] = f;
        more = false;
        for (int p = 0; p < n_pair && !more; p++) {
            int value = g.tie[pair[p][0]][pair[p][1]];
            more = value < most;
            tie(&g, pair[p][0], pair[p][1], more ? value + 1 : 0);
        }
    }
    free(form);
    return n_class;
}

/* Graphs: OEIS A000088.  Graphs with two kinds of edges ("signed graphs"): OEIS A004102. */
TEST(different_graphs_stay_different)
{
    static const size_t graphs[] = { 1, 1, 2, 4, 11, 34, 156 }, signed_graphs[] = { 1, 1, 3, 10, 66 };
    for (int n = 1; n <= 6; n++)
        CHECK_INT(count_classes(n, 1), graphs[n]);
    for (int n = 1; n <= 4; n++)
        CHECK_INT(count_classes(n, 2), signed_graphs[n]);
}

/* The order of the group is the number of renamings that change nothing. */
TEST(groups_agree_with_all_permutations)
{
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 200; trial++) {
        lw_graph g = { .n = 5 };
        for (int i = 0; i < 5; i++)
            for (int k = 0; k < i; k++)
                tie(&g, i, k, (int)(lw_rng_bits(&r) % 3));
        size_t n = 0;
        for (int code = 0; code < 5*5*5*5*5; code++) {
            uint8_t to[5], used = 0;
            for (int i = 0, rest = code; i < 5; i++, rest /= 5)
                used |= (uint8_t)(1 << (to[i] = (uint8_t)(rest % 5)));
            if (used != 31)
                continue;
            lw_graph h = renamed(&g, to);
            n += memcmp(&g, &h, sizeof g) == 0;
        }
        CHECK_INT(order_of(&g), n);
    }
}

TEST(chains_and_structures_have_forms)
{
    lw_rng r = check_rng(3);
    lw_structure s = lw_structure_theta(), t, form_s, form_t;
    CHECK_INT(lw_structure_grow(&s, (lw_ear){ LW_EAR_LINES, 0, 1 }, &s), LW_OK);
    CHECK_INT(lw_structure_grow(&s, (lw_ear){ LW_EAR_CIRCLE_LINE, 0, 2 }, &s), LW_OK);
    CHECK_INT(lw_structure_grow(&s, (lw_ear){ LW_EAR_LINE, 3, 3 }, &s), LW_OK);
    uint8_t weight[LW_LINE_MAX], to[LW_GRAPH_MAX];
    memset(weight, 1, sizeof weight);
    lw_chain c, d, form_c, form_d;
    CHECK_INT(lw_structure_chain(&s, weight, &c), LW_OK);
    for (int trial = 0; trial < 20; trial++) {
        shuffle(&r, s.n_circle, to);
        lw_structure_relabel(&s, to, &t);
        CHECK_INT(lw_structure_canonical(&s, &form_s), LW_OK);
        CHECK_INT(lw_structure_canonical(&t, &form_t), LW_OK);
        CHECK(lw_structure_same(&form_s, &form_t));
        shuffle(&r, c.n_link, to);
        lw_chain_relabel(&c, to, &d);
        CHECK_INT(lw_chain_canonical(&c, &form_c), LW_OK);
        CHECK_INT(lw_chain_canonical(&d, &form_d), LW_OK);
        CHECK(lw_chain_same(&form_c, &form_d));
    }
}
