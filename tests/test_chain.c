/* test_chain.c - chains: joining, counting, renaming, and the pebble game against all 2^n subchains. */
#include "grammar/topology/chain.h"
#include "tests/check.h"

static lw_chain chain_of(int n_link, const int (*joint)[2], int n_joint)
{
    lw_chain c;
    CHECK_INT(lw_chain_clear(&c, n_link), LW_OK);
    for (int j = 0; j < n_joint; j++)
        CHECK_INT(lw_chain_join(&c, joint[j][0], joint[j][1], 1), LW_OK);
    return c;
}

static lw_chain watt(void)
{
    static const int joint[][2] = { {0,1}, {1,2}, {2,3}, {3,4}, {4,5}, {5,0}, {0,3} };
    return chain_of(6, joint, 7);
}

/* two four-bars that share link 0 (joined = 0) or are joined by one more joint (joined = 1) */
static lw_chain two_four_bars(int joined)
{
    static const int shared[][2] = { {0,1}, {1,2}, {2,3}, {3,0}, {0,4}, {4,5}, {5,6}, {6,0} };
    static const int bridge[][2] = { {0,1}, {1,2}, {2,3}, {3,0}, {4,5}, {5,6}, {6,7}, {7,4}, {0,4} };
    return joined ? chain_of(8, bridge, 9) : chain_of(7, shared, 8);
}

TEST(joins_and_parts)
{
    lw_chain c;
    CHECK_INT(lw_chain_clear(&c, 0), LW_E_ARG);
    CHECK_INT(lw_chain_clear(&c, LW_LINK_MAX + 1), LW_E_ARG);
    CHECK_INT(lw_chain_clear(&c, 4), LW_OK);
    CHECK_INT(lw_chain_join(&c, 0, 1, 1), LW_OK);
    CHECK_INT(lw_chain_join(&c, 1, 0, 1), LW_OK);
    CHECK_INT(lw_chain_count(&c, 1), 1);
    CHECK_INT(lw_chain_join(&c, 1, 0, 2), LW_E_ARG);
    CHECK_INT(lw_chain_join(&c, 2, 2, 1), LW_E_ARG);
    CHECK_INT(lw_chain_join(&c, 2, 4, 1), LW_E_ARG);
    CHECK_INT(lw_chain_join(&c, -1, 2, 1), LW_E_ARG);
    CHECK_INT(lw_chain_join(&c, 2, 3, 3), LW_E_ARG);
    CHECK_INT(lw_chain_join(&c, 2, 3, 2), LW_OK);
    CHECK_INT(lw_chain_freedom(&c, 3, 2), 2);
    CHECK_INT(lw_chain_freedom(&c, 0, 1), 1);
    CHECK_INT(lw_chain_freedom(&c, 0, 2), 0);
    lw_chain_unjoin(&c, 3, 2);
    lw_chain_unjoin(&c, 3, 2);
    CHECK_INT(lw_chain_count(&c, 2), 0);
    CHECK_INT(lw_chain_degree(&c, 3), 0);
}

TEST(counts_watt)
{
    lw_chain c = watt();
    int n_with[LW_LINK_MAX];
    lw_chain_assortment(&c, n_with);
    CHECK_INT(n_with[2], 4);
    CHECK_INT(n_with[3], 2);
    CHECK_INT(lw_chain_mobility(&c), 1);
    CHECK_INT(lw_chain_loops(&c), 2);
    CHECK_INT(lw_chain_mobility_of(&c, 0xf), 1);       /* the four-bar 0 1 2 3 */
    CHECK_INT(lw_chain_cut_links(&c), 0);
    CHECK(!lw_chain_rigid(&c, false, NULL));
    CHECK_INT(lw_chain_check(&c, NULL), LW_OK);
    CHECK_INT(lw_chain_count(&c, 1), 7);
    CHECK(lw_chain_freedom(&c, 0, 3) == 1 && lw_chain_freedom(&c, 4, 5) == 1);
    static const int slot[][2] = { {0,1}, {1,2} };                  /* crank with pin in slot: two pins, one slot */
    lw_chain crank = chain_of(3, slot, 2);
    CHECK_INT(lw_chain_join(&crank, 0, 2, 2), LW_OK);
    CHECK_INT(lw_chain_mobility(&crank), 1);
    CHECK_INT(lw_chain_check(&crank, NULL), LW_OK);
}

TEST(finds_cut_links)
{
    lw_chain c = two_four_bars(0), d = two_four_bars(1);
    CHECK_INT(lw_chain_cut_links(&c), 1);
    CHECK_INT(lw_chain_mobility(&c), 2);
    CHECK_INT(lw_chain_cut_links(&d), 1 | 1 << 4);
    CHECK_INT(lw_chain_mobility(&d), 3);
    CHECK(lw_chain_is_connected(&d));
    lw_chain_unjoin(&d, 0, 4);
    CHECK(!lw_chain_is_connected(&d));
}

TEST(names_what_is_wrong)
{
    lw_chain c = watt();
    lw_chain_unjoin(&c, 2, 3);
    CHECK_FAILS(lw_chain_check(&c, &check_error), LW_E_ARG, "link 3 has 1 joint;");
    c = two_four_bars(1);
    lw_chain_unjoin(&c, 0, 4);
    CHECK_FAILS(lw_chain_check(&c, &check_error), LW_E_ARG, "links 1, 2, 3, 4 share no joint");
    c = watt();
    lw_chain_join(&c, 0, 2, 1);                        /* now 0 1 2 and 0 2 3 are triangles */
    CHECK_FAILS(lw_chain_check(&c, &check_error), LW_E_ARG, "rigid subchain (F = 0)");
}

static lw_chain random_chain(lw_rng *r, int n_link, int n_joint)
{
    lw_chain c;
    lw_chain_clear(&c, n_link);
    for (int k = 0; k < n_joint; k++) {
        int a = (int)(lw_rng_bits(r) % (uint64_t)n_link), b = (int)(lw_rng_bits(r) % (uint64_t)n_link);
        (void)lw_chain_join(&c, a, b, lw_rng_bits(r) % 4 ? 1 : 2);
    }
    return c;
}

/* the slow way: every subchain of two or more links */
static bool rigid_by_subchains(const lw_chain *c, bool proper)
{
    uint32_t all = lw_chain_links(c);
    for (uint32_t s = 1; s <= all; s++)
        if ((s & (s - 1)) && !(proper && s == all) && lw_chain_mobility_of(c, s) <= 0)
            return true;
    return false;
}

TEST(pebbles_agree_with_all_subchains)
{
    lw_rng r = check_rng(1);
    int n_rigid = 0, n_trial = 3000;
    for (int trial = 0; trial < n_trial; trial++) {
        int n = 3 + (int)(lw_rng_bits(&r) % 7);
        lw_chain c = random_chain(&r, n, 3*n/2);
        bool proper = trial & 1, rigid = rigid_by_subchains(&c, proper);
        uint32_t links = 0;
        CHECK_INT(lw_chain_rigid(&c, proper, &links), rigid);
        if (rigid) {
            n_rigid++;
            CHECK(__builtin_popcount(links) >= 2 && lw_chain_mobility_of(&c, links) <= 0);
            CHECK(!proper || links != lw_chain_links(&c));
        }
    }
    CHECK(n_rigid > n_trial/10 && n_rigid < n_trial*9/10);
}

TEST(renaming_keeps_what_counts)
{
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 300; trial++) {
        int n = 2 + (int)(lw_rng_bits(&r) % (LW_LINK_MAX - 1));
        lw_chain c = random_chain(&r, n, 3*n/2), d, back;
        uint8_t to[LW_LINK_MAX], inverse[LW_LINK_MAX];
        for (int i = 0; i < n; i++)
            to[i] = (uint8_t)i;
        for (int i = n - 1; i > 0; i--) {
            int k = (int)(lw_rng_bits(&r) % (uint64_t)(i + 1));
            uint8_t swap = to[i];
            to[i] = to[k];
            to[k] = swap;
        }
        for (int i = 0; i < n; i++)
            inverse[to[i]] = (uint8_t)i;
        lw_chain_relabel(&c, to, &d);
        CHECK_INT(lw_chain_mobility(&d), lw_chain_mobility(&c));
        CHECK_INT(lw_chain_is_connected(&d), lw_chain_is_connected(&c));
        CHECK_INT(lw_chain_rigid(&d, false, NULL), lw_chain_rigid(&c, false, NULL));
        for (int i = 0; i < n; i++)
            CHECK_INT(lw_chain_degree(&d, to[i]), lw_chain_degree(&c, i));
        lw_chain_relabel(&d, inverse, &back);
        CHECK(lw_chain_same(&back, &c));
    }
}
