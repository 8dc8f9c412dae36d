/* Derivations: what rules 1 to 4 made is found again and replays to the same mechanism; what they
 * cannot make is refused for the right reason. */
#include "check.h"
#include "grammar/topology/growth.h"
#include "topology.h"

/* Replayed as links and joints, and as sentences, the derivation is m in other numbers. */
static void check_replay(const lw_mechanism *m, const lw_growth *g, lw_reach reach)
{
    lw_mechanism built, renamed;
    lw_sentence s;
    for (int n = 0; n < g->n_step; n++)
        CHECK_INT(lw_mechanism_grow(&built, &g->step[n]), LW_OK);
    lw_mechanism_relabel(&built, g->link_of, &renamed);
    CHECK(lw_mechanism_same(m, &renamed));
    if (reach != LW_REACHED)
        return;
    for (int n = 1; n <= g->n_step; n++) {
        CHECK_SILENT(lw_growth_sentence(g, n, &s, &check_error));
        CHECK(n == 1 || g->step[n - 1].word != LW_NONE);
    }
    CHECK_INT(lw_sentence_mechanism(&s, &built, NULL), LW_OK);
    lw_mechanism_relabel(&built, g->link_of, &renamed);
    CHECK(lw_mechanism_same(m, &renamed));
}

TEST(found_again)
{
    int n_planar = 0, n_other = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 1000; trial++) {
        lw_production p = lw_production_of(1 + trial % 2);
        lw_mechanism m, shuffled;
        lw_growth g;
        lw_reach reach;
        uint8_t to[LW_LINK_MAX];
        CHECK_INT(lw_mechanism_grow(&m, &p), LW_OK);
        for (int step = trial % 7; step >= 0; step--) {
            p = lw_production_of(3 + (int)lw_rng_range(&rng, 0, 2));
            p.x = (uint8_t)(1 + lw_rng_range(&rng, 0, m.n_link));
            p.y = (uint8_t)(1 + lw_rng_range(&rng, 0, m.n_link));
            for (int k = 0; k < 3; k++)
                p.kind[k] = lw_rng_bits(&rng) & 1 ? 'r' : 't';
            lw_mechanism_grow(&m, &p);                       /* X = Y is refused, which is fine */
        }
        random_permutation(&rng, m.n_link, to);
        lw_mechanism_relabel(&m, to, &shuffled);
        CHECK_INT(lw_growth_find(&shuffled, &g, &reach, NULL, NULL), LW_OK);
        CHECK(reach == LW_REACHED || reach == LW_REACHED_NO_REGIONS);
        n_planar += reach == LW_REACHED;
        n_other += reach == LW_REACHED_NO_REGIONS;
        check_replay(&shuffled, &g, reach);
    }
    CHECK(n_planar > 300 && n_other > 30);
}

static lw_reach reach_of(const lw_chain *c, uint32_t *core)
{
    lw_mechanism m;
    lw_growth g;
    lw_reach reach = LW_REACHED;
    lw_mechanism_from_chain(c, &m);
    CHECK_INT(lw_growth_find(&m, &g, &reach, core, NULL), LW_OK);
    if (reach <= LW_REACHED_NO_REGIONS)
        check_replay(&m, &g, reach);
    return reach;
}

/* K4 with a binary link on four of its six lines, on none of a matching: eight links, no two binary
 * ones in a row. */
static lw_chain k4_chain(void)
{
    lw_chain c;
    int next = 4;
    lw_chain_clear(&c, 8);
    for (int a = 0; a < 4; a++)
        for (int b = a + 1; b < 4; b++)
            if (a + b == 3) {
                lw_chain_join(&c, a, b, 1);
            } else {
                lw_chain_join(&c, a, next, 1);
                lw_chain_join(&c, next++, b, 1);
            }
    return c;
}

TEST(reasons)
{
    lw_chain four = ring_of(4), five = ring_of(5), watt = watt_chain(), other = stephenson_chain();
    lw_chain cube = k4_chain(), twisted = nonplanar_chain();
    uint32_t core = 0;
    char text[400];
    lw_mechanism m;
    CHECK_INT(reach_of(&four, NULL), LW_REACHED);
    CHECK_INT(reach_of(&watt, NULL), LW_REACHED);
    CHECK_INT(reach_of(&other, NULL), LW_REACHED);
    CHECK_INT(reach_of(&five, NULL), LW_NOT_MOBILITY);
    CHECK_INT(reach_of(&twisted, NULL), LW_REACHED_NO_REGIONS);
    CHECK_INT(lw_chain_check(&cube, NULL), LW_OK);
    CHECK_INT(reach_of(&cube, &core), LW_NOT_CORE);
    CHECK_INT(core, 255);
    lw_mechanism_from_chain(&cube, &m);
    lw_reach_print(&m, LW_NOT_CORE, core, text, sizeof text);
    CHECK_HAS(text, "ends at links 1 2 3 4 5 6 7 8, which");
    lw_mechanism twisted_m;
    lw_mechanism_from_chain(&twisted, &twisted_m);
    lw_reach_print(&twisted_m, LW_REACHED_NO_REGIONS, 0, text, sizeof text);
    CHECK_HAS(text, "(links 1 2 3 4 5 6 are tied together as in K3,3)");
    lw_reach_print(&m, LW_NOT_GEAR, 0, text, sizeof text);
    CHECK_HAS(text, "no rule makes a joint g");
    lw_mechanism_from_chain(&five, &m);
    lw_reach_print(&m, LW_NOT_MOBILITY, 0, text, sizeof text);
    CHECK_HAS(text, "F = 2");
}

/* Rules 1 and 3 with their pin in slot; a slider beside the p is no rule 3. */
TEST(kinds_matter)
{
    lw_mechanism m;
    lw_growth g;
    lw_reach reach;
    lw_mechanism_clear(&m, 3);
    lw_mechanism_join(&m, 0, 1, 't');
    lw_mechanism_join(&m, 1, 2, 'p');
    lw_mechanism_join(&m, 0, 2, 'r');
    CHECK_INT(lw_growth_find(&m, &g, &reach, NULL, NULL), LW_OK);
    CHECK_INT(reach, LW_REACHED);
    CHECK_INT(g.step[0].rule, 1);
    check_replay(&m, &g, reach);
    m.kind[0] = 'g';
    CHECK_OK(lw_growth_find(&m, &g, &reach, NULL, &check_error));
    CHECK_INT(reach, LW_NOT_MOBILITY);
    m.kind[2] = 'r';
    CHECK_OK(lw_growth_find(&m, &g, &reach, NULL, &check_error));
    CHECK_INT(reach, LW_NOT_GEAR);
    lw_mechanism_clear(&m, 3);
    lw_mechanism_join(&m, 0, 1, 'r');
    lw_mechanism_join(&m, 1, 2, 'r');
    CHECK_INT(lw_growth_find(&m, &g, &reach, NULL, &check_error), LW_E_ARG);   /* open ends */
}
