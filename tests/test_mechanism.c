#include "check.h"
#include "topology.h"

TEST(joints_stay_in_the_order_of_the_matrix)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 300; trial++) {
        lw_mechanism m = random_topology(&rng, 2 + trial % 12, trial % 9, "rtpg"), back;
        lw_chain c;
        lw_mechanism_chain(&m, &c);
        CHECK_INT(lw_chain_count(&c, 1) + lw_chain_count(&c, 2), m.n_joint);
        for (int j = 0; j < m.n_joint; j++) {
            CHECK_INT(lw_chain_freedom(&c, m.link[j][0], m.link[j][1]), lw_joint_freedoms(m.kind[j]));
            CHECK_INT(lw_mechanism_joint(&m, m.link[j][1], m.link[j][0]), j);
        }
        CHECK_INT(lw_mechanism_from_chain(&c, &back), LW_OK);
        CHECK_INT(back.n_joint, m.n_joint);
        CHECK(!memcmp(back.link, m.link, sizeof *m.link*(size_t)m.n_joint));
    }
}

TEST(renaming_twice_goes_back)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 300; trial++) {
        lw_mechanism m = random_topology(&rng, 3 + trial % 12, trial % 9, "rt"), there, back;
        uint8_t to[LW_LINK_MAX], from[LW_LINK_MAX];
        m.ground = trial % m.n_link;
        m.output = (trial + 1) % m.n_link;
        m.input[0] = 0;
        m.input[1] = (uint8_t)(m.n_joint - 1);
        m.n_input = m.n_joint > 1 ? 2 : 1;
        random_permutation(&rng, m.n_link, to);
        for (int i = 0; i < m.n_link; i++)
            from[to[i]] = (uint8_t)i;
        lw_mechanism_relabel(&m, to, &there);
        CHECK_INT(there.ground, to[m.ground]);
        lw_mechanism_relabel(&there, from, &back);
        CHECK(lw_mechanism_same(&m, &back));
    }
}

TEST(refusals)
{
    lw_mechanism m, before;
    CHECK_INT(lw_mechanism_clear(&m, 0), LW_E_ARG);
    CHECK_INT(lw_mechanism_clear(&m, LW_LINK_MAX + 1), LW_E_ARG);
    CHECK_INT(lw_mechanism_clear(&m, 12), LW_OK);
    CHECK_INT(lw_mechanism_join(&m, 1, 0, 'r'), LW_OK);
    before = m;
    CHECK_INT(lw_mechanism_join(&m, 0, 0, 'r'), LW_E_ARG);
    CHECK_INT(lw_mechanism_join(&m, 0, 1, 't'), LW_E_ARG);
    CHECK_INT(lw_mechanism_join(&m, 0, 12, 'r'), LW_E_ARG);
    CHECK_INT(lw_mechanism_join(&m, -1, 2, 'r'), LW_E_ARG);
    CHECK_INT(lw_mechanism_join(&m, 1, 2, 'k'), LW_E_ARG);
    CHECK(lw_mechanism_same(&m, &before));
    for (int i = 0; i < 12; i++)
        for (int k = 0; k < i; k++)
            lw_mechanism_join(&m, i, k, 'r');
    CHECK_INT(m.n_joint, LW_JOINT_MAX);                       /* 66 pairs, 64 fit */
    lw_chain dense;
    lw_chain_clear(&dense, 12);
    for (int i = 0; i < 12; i++)
        for (int k = 0; k < i; k++)
            lw_chain_join(&dense, i, k, 1);
    CHECK_INT(lw_mechanism_from_chain(&dense, &m), LW_E_ARG);
}
