/* test_fractionated.c - fractionated chains: the sum over pairs of inversions for F = 2, bridges counted again
 * joint by joint, each chain once.  Against all graphs and geng: test_chains.c. */
#include <stdlib.h>
#include "enumerate/canon.h"
#include "enumerate/chains.h"
#include "enumerate/fractionated.h"
#include "tests/check.h"

typedef struct seen { lw_chain *form; size_t n, room, n_bridged; } seen;

static int bridges_by_trial(const lw_chain *c)
{
    int n_bridge = 0;
    for (int i = 0; i < c->n_link; i++)
        for (int k = i + 1; k < c->n_link; k++) {
            lw_chain without = *c;
            lw_chain_unjoin(&without, i, k);
            n_bridge += lw_chain_freedom(c, i, k) != 0 && !lw_chain_is_connected(&without);
        }
    return n_bridge;
}

static lw_status check_chain(void *context, const lw_chain *c, int n_bridge)
{
    seen *s = context;
    if (s->n == s->room)
        s->form = realloc(s->form, (s->room = s->room ? 2*s->room : 64)*sizeof *s->form);
    CHECK_INT(lw_chain_canonical(c, &s->form[s->n]), LW_OK);
    for (size_t k = 0; k < s->n; k++)
        CHECK(!lw_chain_same(&s->form[k], &s->form[s->n]));
    s->n++;
    s->n_bridged += n_bridge > 0;
    CHECK_INT(n_bridge, bridges_by_trial(c));
    CHECK_INT(lw_chain_check(c, NULL), LW_OK);
    CHECK(lw_chain_cut_links(c) != 0);
    return LW_OK;
}

TEST(each_once_and_sound)
{
    /* (9, 4) and beyond: recounted here with geng and shortg */
    static const struct { int n_link, dof; size_t n, n_bridged; } known[] = {
        { 4, 1, 0, 0 }, { 5, 0, 0, 0 }, { 5, 2, 0, 0 }, { 7, 2, 1, 0 }, { 9, 2, 5, 0 }, { 11, 2, 86, 0 },
        { 8, 3, 2, 1 }, { 10, 3, 24, 5 }, { 12, 3, 460, 86 }, { 9, 4, 4, 2 }, { 11, 4, 63, 24 }, { 11, 6, 9, 6 } };
    for (size_t k = 0; k < sizeof known/sizeof *known; k++) {
        seen s = { 0 };
        CHECK_INT(lw_fractionated_each(known[k].n_link, known[k].dof, check_chain, &s, NULL), LW_OK);
        CHECK_INT(s.n, known[k].n);
        CHECK_INT(s.n_bridged, known[k].n_bridged);
        free(s.form);
    }
}

static uint64_t inversions(int n_link)
{
    lw_chains *chains;
    lw_chain_walk how = lw_chain_walk_default();
    OWN(lw_chain_table) table = { 0 };
    CHECK_INT(lw_chains_create(n_link, 1, 1, &chains, NULL), LW_OK);
    CHECK_INT(lw_chains_count(chains, &how, &table), LW_OK);
    uint64_t n = table.total.n_ground;
    lw_chains_free(chains);
    return n;
}

static lw_status count(void *context, const lw_chain *c, int n_bridge)
{
    (void)c;
    CHECK_INT(n_bridge, 0);
    ++*(uint64_t *)context;
    return LW_OK;
}

/* F = 2: two chains with F = 1 share a link, so P = P' + P'' - 1 and one counts unordered pairs of inversions. */
TEST(two_freedoms_are_pairs_of_inversions)
{
    for (int n_link = 7; n_link <= 15; n_link += 2) {
        uint64_t want = 0, got = 0;
        for (int a = 4; a <= (n_link + 1)/2; a += 2) {
            uint64_t n = inversions(a);
            want += 2*a == n_link + 1 ? n*(n + 1)/2 : n*inversions(n_link + 1 - a);
        }
        CHECK_INT(lw_fractionated_each(n_link, 2, count, &got, NULL), LW_OK);
        CHECK_INT(got, want);
    }
}

static lw_status stop(void *context, const lw_chain *c, int n_bridge)
{
    (void)c;
    (void)n_bridge;
    return ++*(int *)context == 3 ? LW_STOPPED : LW_OK;
}

TEST(stops_and_refuses)
{
    int n = 0;
    CHECK_INT(lw_fractionated_each(11, 2, stop, &n, NULL), LW_STOPPED);
    CHECK_INT(n, 3);
    CHECK_FAILS(lw_fractionated_each(8, 2, stop, &n, &check_error), LW_E_ARG, "P = 8");
}
