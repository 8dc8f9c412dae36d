/* test_store_layout.c - layouts of chains as bytes and back; bytes that are none are refused. */
#include "catalogues/store/store_layout.h"

#include "base/rng.h"
#include "grammar/graph6.h"
#include "tests/check.h"

/* Four-bar, Watt, Stephenson, two eight-link chains, and one of ten links that is not planar. */
static const char *const chains[] = { "Cl", "ERr?", "Er`G", "Gr`KAC", "GR`ME?", "IAo{@EOW\?" };

static void there_and_back(void)
{
    for (size_t i = 0; i < sizeof chains/sizeof *chains; i++) {
        lw_chain c;
        lw_mechanism m;
        lw_chain_layout a, b;
        lw_bytes bytes = { 0 };
        lw_error e;
        CHECK_INT(lw_graph6_read(chains[i], strlen(chains[i]), NULL, &c, &e), LW_OK);
        CHECK_INT(lw_mechanism_from_chain(&c, &m), LW_OK);
        CHECK_INT(lw_chain_layout_make(&m, &a, &e), LW_OK);
        lw_layout_pack(&a, m.n_link, &bytes);
        CHECK_INT(lw_layout_unpack(bytes.data, bytes.size, m.n_link, &b), LW_OK);
        CHECK_INT(b.n_joint, a.n_joint);
        CHECK_INT(b.planar, a.planar);
        CHECK_INT(b.n_cross, a.n_cross);
        for (int j = 0; j < a.n_joint; j++)
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(a.at[j], b.at[j])), 0, 1e-6, 1e-6);
        CHECK(memcmp(a.first, b.first, sizeof a.first[0]*(size_t)(m.n_link + 1)) == 0);
        CHECK(memcmp(a.ring, b.ring, (size_t)a.first[m.n_link]) == 0);
        /* cut anywhere, of another chain, or too long: no layout */
        for (size_t n = 0; n < bytes.size; n++)
            CHECK_INT(lw_layout_unpack(bytes.data, n, m.n_link, &b), LW_E_NOTATION);
        CHECK_INT(lw_layout_unpack(bytes.data, bytes.size, m.n_link + 1, &b), LW_E_NOTATION);
        lw_bytes_add(&bytes, "x", 1);
        CHECK_INT(lw_layout_unpack(bytes.data, bytes.size, m.n_link, &b), LW_E_NOTATION);
        lw_bytes_free(&bytes);
    }
}

/* Wild bytes never lead outside. */
static void wild_bytes(void)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 9);
    for (int trial = 0; trial < 20000; trial++) {
        unsigned char bytes[200];
        size_t n = (size_t)lw_rng_range(&rng, 0, sizeof bytes);
        lw_chain_layout l;
        for (size_t i = 0; i < n; i++)
            bytes[i] = (unsigned char)(lw_rng_bits(&rng)%(trial%2 ? 256 : 8));
        if (n > 1) {
            bytes[0] = 1;
            bytes[1] = 6;
        }
        if (lw_layout_unpack(bytes, n, 6, &l) == LW_OK)
            CHECK(l.n_joint <= LW_JOINT_MAX && l.first[6] <= 2*LW_JOINT_MAX);
    }
}

int main(void)
{
    RUN(there_and_back);
    RUN(wild_bytes);
    return check_end();
}
