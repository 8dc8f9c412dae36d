/* test_invert.c - ground links up to symmetry: named chains, all renamings on few links, published counts. */
#include <string.h>
#include "enumerate/chains.h"
#include "enumerate/invert.h"
#include "tests/check.h"
#include "tests/topology.h"

static int classes(const lw_chain *c, uint8_t *lowest)
{
    int n = 0;
    CHECK_INT(lw_chain_orbits(c, lowest, &n), LW_OK);
    return n;
}

/* Watt: two inversions, Stephenson: three (Tsai 2001, chapter 5). */
TEST(six_links)
{
    uint8_t lowest[LW_LINK_MAX], ground[LW_LINK_MAX];
    lw_chain watt = ring_of(6), five = ring_of(5), stephenson = { .n_link = 6 }, slot = ring_of(4);
    lw_chain_join(&watt, 0, 3, 1);
    CHECK_INT(classes(&watt, lowest), 2);
    CHECK_INT(lw_ground_choices(lowest, 6, ground), 2);
    CHECK(ground[0] == 0 && ground[1] == 1);
    memcpy(stephenson.one, five.one, sizeof five.one);
    lw_chain_join(&stephenson, 0, 5, 1);            /* links 1 and 5 each alone between 0 and 2 */
    lw_chain_join(&stephenson, 5, 2, 1);
    CHECK_INT(classes(&stephenson, lowest), 3);
    CHECK(lowest[5] == 1 && lowest[2] == 0 && lowest[4] == 3);
    lw_chain_unjoin(&slot, 0, 1);                   /* a joint of two freedoms breaks the symmetry of the ring */
    lw_chain_join(&slot, 0, 1, 2);
    CHECK_INT(classes(&slot, lowest), 2);
    lw_chain four = ring_of(4);
    CHECK_INT(classes(&four, lowest), 1);
    CHECK_INT(lw_ground_choices(lowest, 4, ground), 1);
}

/* Two links are alike when some renaming that keeps the chain carries one into the other: all 8! tried. */
static void try_renamings(const lw_chain *c, uint8_t *to, int k, uint32_t used, bool (*alike)[8])
{
    for (int v = 0; v < c->n_link; v++) {
        if (used >> v & 1)
            continue;
        to[k] = (uint8_t)v;
        bool fits = true;
        for (int i = 0; i < k && fits; i++)
            fits = lw_chain_freedom(c, i, k) == lw_chain_freedom(c, to[i], v);
        if (!fits)
            continue;
        if (k + 1 < c->n_link)
            try_renamings(c, to, k + 1, used | (uint32_t)1 << v, alike);
        else
            for (int i = 0; i < c->n_link; i++)
                alike[i][to[i]] = true;
    }
}

static lw_status check_item(void *context, const lw_chain_item *item)
{
    uint8_t lowest[LW_LINK_MAX], quick[LW_LINK_MAX], to[LW_LINK_MAX];
    bool alike[8][8] = { { false } };
    *(int *)context += classes(item->chain, lowest);
    CHECK_INT(lw_chain_item_orbits(item, quick), classes(item->chain, lowest));
    CHECK(memcmp(quick, lowest, (size_t)item->chain->n_link) == 0);
    try_renamings(item->chain, to, 0, 0, alike);
    for (int i = 0; i < item->chain->n_link; i++)
        for (int k = 0; k < item->chain->n_link; k++)
            CHECK_INT(alike[i][k], lowest[i] == lowest[k]);
    return LW_OK;
}

TEST(agrees_with_all_renamings)
{
    static const int known[][3] = { {4,1,1}, {6,1,5}, {8,1,71}, {5,2,1}, {7,2,11}, {6,3,1}, {8,3,18}, {5,0,2}, {7,0,10} };
    for (size_t k = 0; k < sizeof known/sizeof *known; k++) {
        lw_chains *chains;
        lw_chain_walk how = lw_chain_walk_default();
        int n = 0;
        CHECK_INT(lw_chains_create(known[k][0], known[k][1], 1, &chains, NULL), LW_OK);
        CHECK_INT(lw_chains_each(chains, &how, check_item, &n), LW_OK);
        CHECK_INT(n, known[k][2]);
        lw_chains_free(chains);
    }
}
