/* test_chains.c - all chains: known counts (the published table: test_published.c), all graphs on few links with a
 * test of all 2^n subchains, generating functions, nauty's geng where installed; parts, threads, order, filters, stopping. */
#include <stdlib.h>
#include <string.h>
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/fractionated.h"
#include "enumerate/labelled.h"
#include "grammar/topology/graph6.h"
#include "tests/check.h"

OWNS(lw_chains)

static lw_chains *chains_of(int n_link, int dof)
{
    lw_chains *chains = NULL;
    CHECK_OK(lw_chains_create(n_link, dof, 1, &chains, &check_error));
    return chains;
}

static lw_chain_walk one_thread(void)
{
    lw_chain_walk how = lw_chain_walk_default();
    how.n_thread = 1;
    return how;
}

/* ---- counts beyond the table of test_published.c ------------------------------------------------------- */

static lw_status count_fractionated(void *context, const lw_chain *c, int n_bridge)
{
    (void)n_bridge;
    CHECK_INT(lw_chain_check(c, NULL), LW_OK);
    CHECK(lw_chain_cut_links(c) != 0);
    ++*(uint64_t *)context;
    return LW_OK;
}

/* docs/theory.md, "Numbers"; 14 links: OEIS A233288; the others recounted with geng and subset tests. */
TEST(larger_counts)
{
    static const struct { int n_link, dof; uint64_t n_chain, n_fractionated; } known[] = {
        { 11, 2, 753, 86 }, { 13, 2, 27496, 2189 }, { 12, 3, 1962, 460 }, { 14, 1, 318162, 0 } };
    for (size_t k = 0; k < sizeof known/sizeof *known; k++) {
        lw_chains *chains = chains_of(known[k].n_link, known[k].dof);
        lw_chain_walk how = one_thread();
        OWN(lw_chain_table) table = { 0 };
        uint64_t n = 0;
        CHECK_INT(lw_chains_count(chains, &how, &table), LW_OK);
        CHECK_INT(table.total.n_chain, known[k].n_chain);
        CHECK_INT(lw_fractionated_each(known[k].n_link, known[k].dof, count_fractionated, &n, NULL), LW_OK);
        CHECK_INT(n, known[k].n_fractionated);
        lw_chains_free(chains);
    }
}

/* ---- all graphs on few links ------------------------------------------------------------------------ */

typedef struct pool { lw_chain *form; size_t n, room, labelled; } pool;

static bool pool_has(const pool *p, const lw_chain *form)
{
    for (size_t k = 0; k < p->n; k++)
        if (lw_chain_same(&p->form[k], form))
            return true;
    return false;
}

static void pool_add(pool *p, const lw_chain *c)
{
    lw_chain form;
    CHECK_INT(lw_chain_canonical(c, &form), LW_OK);
    if (pool_has(p, &form))
        return;
    if (p->n == p->room)
        p->form = realloc(p->form, (p->room = p->room ? 2*p->room : 64)*sizeof *p->form);
    p->form[p->n++] = form;
}

/* Closed, connected, every (proper, for F = 0) subchain of two or more links has F >= 1: asked of all 2^n. */
static bool moves(const lw_chain *c, int dof)
{
    for (int i = 0; i < c->n_link; i++)
        if (lw_chain_degree(c, i) < 2)
            return false;
    uint32_t all = lw_chain_links(c);
    for (uint32_t s = 3; s <= all; s++)
        if ((s & (s - 1)) && !(dof == 0 && s == all) && lw_chain_mobility_of(c, s) <= 0)
            return false;
    return lw_chain_is_connected(c);
}

/* Choose joints in rising order; leave a link behind only when it has its two joints. */
static void all_graphs(pool *p, lw_chain *c, int i, int k, int left, int dof)
{
    if (left == 0) {
        if (moves(c, dof)) {
            pool_add(p, c);
            p->labelled += lw_chain_cut_links(c) == 0;
        }
        return;
    }
    for (; i < c->n_link - 1; i++, k = i + 1) {
        for (; k < c->n_link; k++) {
            if (c->n_link > 3 && c->one[i] & c->one[k])
                continue;                                        /* a triangle is rigid */
            (void)lw_chain_join(c, i, k, 1);
            all_graphs(p, c, i, k + 1, left - 1, dof);
            lw_chain_unjoin(c, i, k);
        }
        if (lw_chain_degree(c, i) < 2)
            return;
    }
}

static lw_status pool_item(void *context, const lw_chain_item *item)
{
    pool *p = context;
    size_t n = p->n;
    pool_add(p, item->chain);
    CHECK_INT(p->n, n + 1);                                  /* each chain once */
    CHECK(moves(item->chain, lw_chain_mobility(item->chain)));
    return LW_OK;
}

static lw_status pool_fractionated(void *context, const lw_chain *c, int n_bridge)
{
    pool *p = context;
    size_t n = p->n;
    (void)n_bridge;
    pool_add(p, c);
    CHECK_INT(p->n, n + 1);
    return LW_OK;
}

static pool listed_pool(int n_link, int dof)
{
    pool p = { 0 };
    OWNED(lw_chains) *chains = chains_of(n_link, dof);
    lw_chain_walk how = one_thread();
    CHECK_INT(lw_chains_each(chains, &how, pool_item, &p), LW_OK);
    CHECK_INT(lw_fractionated_each(n_link, dof, pool_fractionated, &p, NULL), LW_OK);
    return p;
}

static void same_pools(const pool *a, const pool *b)
{
    CHECK_INT(a->n, b->n);
    for (size_t k = 0; k < a->n; k++)
        CHECK(pool_has(b, &a->form[k]));
}

static lw_whole generating_sum(int n_link, int dof)
{
    lw_numbers numbers;
    OWN(lw_chain_table) table = { 0 };
    CHECK_INT(lw_numbers_for_links(n_link, dof, 0, &numbers, NULL), LW_OK);
    CHECK_INT(lw_labelled_chains(&numbers, &table, NULL), LW_OK);
    lw_whole n = table.total.n_labelled;
    return n;
}

TEST(agrees_with_all_graphs)
{
    static const int small[][2] = { {3,0}, {4,1}, {5,2}, {6,3}, {7,4}, {5,0}, {6,1}, {7,2}, {8,3}, {7,0}, {8,1} };
    for (size_t k = 0; k < sizeof small/sizeof *small; k++) {
        int n_link = small[k][0], dof = small[k][1];
        pool brute = { 0 }, listed = listed_pool(n_link, dof);
        lw_chain c;
        (void)lw_chain_clear(&c, n_link);
        all_graphs(&brute, &c, 0, 1, (3*(n_link - 1) - dof)/2, dof);
        same_pools(&brute, &listed);
        if (dof > 0)
            CHECK(generating_sum(n_link, dof) == brute.labelled);
        free(brute.form);
        free(listed.form);
    }
}

/* ---- labelled chains ---------------------------------------------------------------------------------- */

/* Labelled chains from generating functions, and the excess of those with symmetries, give the chains of each assortment as
 * Burnside's lemma does. */
TEST(generating_functions_agree)
{
    static const int size[][2] = { {4,1}, {6,1}, {8,1}, {10,1}, {12,1}, {14,1}, {5,2}, {9,2}, {13,2}, {12,3}, {14,5}, {19,10} };
    for (size_t k = 0; k < sizeof size/sizeof *size; k++) {
        lw_chains *chains = chains_of(size[k][0], size[k][1]);
        lw_chain_walk how = one_thread();
        OWN(lw_chain_table) all = { 0 }, table = { 0 };
        CHECK_INT(lw_chains_count(chains, &how, &all), LW_OK);
        how.filter = lw_filter_find("generating");
        CHECK_INT(lw_chains_count(chains, &how, &table), LW_OK);
        CHECK(all.total.n_chain > 0 && all.total.n_chain == table.total.n_chain);
        for (size_t i = 0; i < all.n_row; i++)
            CHECK_INT(table.row[i].n.n_chain, all.row[i].n.n_chain);
        lw_chains_free(chains);
    }
}

TEST(refuses_labelled_numbers_beyond_its_range)
{
    lw_numbers numbers;
    lw_chain_table table;
    CHECK_INT(lw_numbers_for_links(9, 0, 0, &numbers, NULL), LW_OK);
    CHECK_INT(lw_labelled_chains(&numbers, &table, &check_error), LW_E_ARG);
    CHECK_INT(lw_numbers_for_links(32, 1, 0, &numbers, NULL), LW_OK);
    CHECK_FAILS(lw_labelled_chains(&numbers, &table, &check_error), LW_E_ARG, "5e36");
}

/* nauty's geng makes every connected graph once; what moves of them must be what is listed. */
TEST(agrees_with_geng)
{
    static const int sizes[][2] = { {9,0}, {9,2}, {10,1}, {10,3}, {10,5} };
    const char *geng = system("command -v nauty-geng >/dev/null 2>&1") == 0 ? "nauty-geng"
                     : system("command -v geng >/dev/null 2>&1") == 0 ? "geng" : NULL;
    if (!geng) {
        printf("test_chains: geng is not installed, comparison skipped\n");
        return;
    }
    for (size_t k = 0; k < sizeof sizes/sizeof *sizes; k++) {
        int n_link = sizes[k][0], dof = sizes[k][1], n_joint = (3*(n_link - 1) - dof)/2;
        char command[64], line[LW_GRAPH6_SIZE];
        pool made = { 0 }, listed = listed_pool(n_link, dof);
        snprintf(command, sizeof command, "%s -q -c -t -d2 %d %d:%d", geng, n_link, n_joint, n_joint);
        FILE *f = popen(command, "r");
        while (f && fgets(line, sizeof line, f)) {
            lw_chain c;
            CHECK_INT(lw_graph6_read(line, strlen(line), "geng", &c, NULL), LW_OK);
            if (moves(&c, dof))
                pool_add(&made, &c);
        }
        CHECK(f && pclose(f) == 0);
        same_pools(&made, &listed);
        free(made.form);
        free(listed.form);
    }
}

/* ---- order, parts, threads, filters, stopping --------------------------------------------------------- */

typedef struct text { char *at; size_t n, room; } text;

static lw_status append(void *context, const char *piece, size_t size)
{
    text *t = context;
    while (t->n + size > t->room)
        t->at = realloc(t->at, t->room = t->room ? 2*t->room : 4096);
    memcpy(t->at + t->n, piece, size);
    t->n += size;
    return LW_OK;
}

static lw_status print_graph6(void *context, const lw_chain_item *item, char *line, size_t most, size_t *length)
{
    (void)context;
    *length = lw_graph6_print(item->chain, line, most);
    line[(*length)++] = '\n';
    return LW_OK;
}

static lw_status append_item(void *context, const lw_chain_item *item)
{
    char line[LW_GRAPH6_SIZE + 1];
    size_t length;
    print_graph6(NULL, item, line, sizeof line, &length);
    return append(context, line, length);
}

static text printed(const lw_chains *chains, lw_chain_walk how)
{
    text t = { 0 };
    CHECK_INT(lw_chains_print(chains, &how, LW_GRAPH6_SIZE + 1, print_graph6, append, &t), LW_OK);
    return t;
}

TEST(threads_and_visits_give_the_same_text)
{
    lw_chains *chains = chains_of(12, 1);
    text by_visit = { 0 };
    lw_chain_walk how = one_thread();
    CHECK_INT(lw_chains_each(chains, &how, append_item, &by_visit), LW_OK);
    for (int n_thread = 1; n_thread <= 4; n_thread++) {
        how.n_thread = n_thread;
        text t = printed(chains, how);
        CHECK(t.n == by_visit.n && memcmp(t.at, by_visit.at, t.n) == 0);
        free(t.at);
    }
    CHECK_INT(by_visit.n, 6856*13);
    free(by_visit.at);
    lw_chains_free(chains);
}

/* A chain that may take nearly a megabyte: every job waits for its turn and passes its text on at once. */
TEST(large_texts_keep_their_order)
{
    lw_chains *chains = chains_of(12, 1);
    lw_chain_walk how = one_thread();
    text one = printed(chains, how), four = { 0 };
    how.n_thread = 4;
    CHECK_INT(lw_chains_print(chains, &how, ((size_t)1 << 20) - 20, print_graph6, append, &four), LW_OK);
    CHECK(one.n == four.n && memcmp(one.at, four.at, one.n) == 0);
    free(one.at);
    free(four.at);
    lw_chains_free(chains);
}

/* Merge parts structure by structure: the whole again. */
TEST(parts_make_the_whole)
{
    lw_chains *chains = chains_of(10, 1);
    text whole = printed(chains, one_thread());
    for (int n_part = 1; n_part <= 20; n_part += 3) {
        uint64_t n = 0;
        pool p = { 0 };
        for (int part = 0; part < n_part; part++) {
            lw_chain_walk how = one_thread();
            OWN(lw_chain_table) table = { 0 };
            how.part = part;
            how.n_part = n_part;
            CHECK_INT(lw_chains_each(chains, &how, pool_item, &p), LW_OK);       /* disjoint */
            CHECK_INT(lw_chains_count(chains, &how, &table), LW_OK);
            n += table.total.n_chain;
        }
        CHECK_INT(p.n, 230);
        CHECK_INT(n, 230);
        free(p.form);
    }
    lw_chain_walk how = one_thread();
    how.part = 3;
    how.n_part = 3;
    OWN(lw_chain_table) table = { 0 };
    CHECK_INT(lw_chains_count(chains, &how, &table), LW_E_ARG);
    CHECK_INT(lw_chains_print(chains, &how, LW_GRAPH6_SIZE + 1, print_graph6, append, &whole), LW_E_ARG);
    CHECK_INT(lw_chains_each(chains, &how, append_item, &whole), LW_E_ARG);
    free(whole.at);
    lw_chains_free(chains);
}

TEST(skipping_leaves_the_rest)
{
    lw_chains *chains = chains_of(10, 1);
    text whole = printed(chains, one_thread());
    size_t width = whole.n/230;
    for (uint64_t skip = 0; skip <= 231; skip += 11) {
        lw_chain_walk how = one_thread();
        how.skip = skip;
        how.n_thread = 2;
        text rest = printed(chains, how), visited = { 0 };
        size_t want = skip < 230 ? (size_t)(230 - skip)*width : 0;
        CHECK_INT(lw_chains_each(chains, &how, append_item, &visited), LW_OK);
        CHECK_INT(rest.n, want);
        CHECK_INT(visited.n, want);
        CHECK(want == 0 || memcmp(rest.at, whole.at + whole.n - want, want) == 0);
        CHECK(want == 0 || memcmp(visited.at, rest.at, want) == 0);
        free(rest.at);
        free(visited.at);
    }
    free(whole.at);
    lw_chains_free(chains);
}

/* Every filter says of each chain what it says of the chain's structure, and counts what it lists. */
static lw_status ask_both(void *context, const lw_chain_item *item)
{
    const lw_filter *f = context;
    bool whole = true, one = true;
    CHECK_INT(f->chain(item->chain, &one), LW_OK);
    if (f->structure && item->structure) {
        CHECK_INT(f->structure(item->structure, &whole), LW_OK);
        CHECK_INT(whole, one);
    }
    return LW_OK;
}

TEST(filters_agree_with_themselves)
{
    static const int sizes[][2] = { {4,1}, {10,1}, {9,0}, {9,2} };
    CHECK(lw_filter_find("no such filter") == NULL);
    for (size_t k = 0; k < sizeof sizes/sizeof *sizes; k++) {
        OWNED(lw_chains) *chains = chains_of(sizes[k][0], sizes[k][1]);
        for (const lw_filter *f = lw_filters; f->name; f++) {
            lw_chain_walk how = one_thread();
            OWN(lw_chain_table) table = { 0 };
            CHECK(lw_filter_find(f->name) == f);
            CHECK_INT(lw_chains_each(chains, &how, ask_both, (void *)f), LW_OK);
            how.filter = f;
            bool generating = strcmp(f->name, "generating") == 0;
            text t = printed(chains, how);
            CHECK_INT(lw_chains_count(chains, &how, &table), generating && sizes[k][1] == 0 ? LW_E_ARG : LW_OK);
            size_t lines = 0;
            for (size_t i = 0; i < t.n; i++)
                lines += t.at[i] == '\n';
            if (!generating || sizes[k][1] > 0)
                CHECK_INT(table.total.n_chain, lines);
            free(t.at);
        }
    }
}

static lw_status refuse_second(void *context, const char *piece, size_t size)
{
    (void)piece;
    (void)size;
    return ++*(int *)context >= 2 ? LW_E_IO : LW_OK;
}

static bool stop_halfway(void *context, double done)
{
    *(double *)context = done;
    return done < 0.5;
}

static lw_status stop_at_tenth(void *context, const lw_chain_item *item)
{
    (void)item;
    return ++*(int *)context == 10 ? LW_NOTHING : LW_OK;
}

TEST(stops_when_asked)
{
    OWNED(lw_chains) *chains = chains_of(12, 1);
    for (int n_thread = 1; n_thread <= 3; n_thread++) {
        lw_chain_walk how = one_thread();
        OWN(lw_chain_table) table = { 0 };
        int n = 0;
        double done = 0;
        text t = { 0 };
        how.n_thread = n_thread;
        CHECK_INT(lw_chains_print(chains, &how, LW_GRAPH6_SIZE + 1, print_graph6, refuse_second, &n), LW_E_IO);
        n = 0;
        CHECK_INT(lw_chains_each(chains, &how, stop_at_tenth, &n), LW_NOTHING);
        CHECK_INT(n, 10);
        how.tick = stop_halfway;
        how.tick_context = &done;
        CHECK_INT(lw_chains_print(chains, &how, LW_GRAPH6_SIZE + 1, print_graph6, append, &t), LW_STOPPED);
        CHECK(done >= 0.5 && done < 1 && t.n > 0 && t.n % 13 == 0);
        CHECK_INT(lw_chains_each(chains, &how, append_item, &t), LW_STOPPED);
        CHECK_INT(lw_chains_count(chains, &how, &table), LW_STOPPED);
        free(t.at);
    }
}

TEST(explains_impossible_sizes)
{
    lw_chains *chains = NULL;
    CHECK_FAILS(lw_chains_create(7, 1, 1, &chains, &check_error), LW_E_ARG, "P = F + 2 L + 1 - n2");
    CHECK_INT(lw_chains_create(34, 1, 1, &chains, &check_error), LW_E_ARG);
    CHECK_INT(lw_chains_create(22, 11, 1, &chains, &check_error), LW_E_ARG);
    CHECK_INT(lw_fractionated_each(7, 1, pool_fractionated, NULL, &check_error), LW_E_ARG);
    CHECK(chains == NULL);
    lw_chains_free(NULL);
}
