/* test_store_layout.c - layouts of chains as bytes, read back as catalogues/store/store_layout.h says. */
#include "catalogues/store/store_layout.h"

#include "grammar/topology/graph6.h"
#include "tests/check.h"

/* Four-bar, Watt, Stephenson, two eight-link chains, and one of ten links that is not planar. */
static const char *const chains[] = { "Cl", "ERr?", "Er`G", "Gr`KAC", "GR`ME?", "IAo{@EOW\?" };

static lw_vec2 place(const char *at)
{
    float f[2];
    memcpy(f, at, sizeof f);                                /* little-endian, as this test's machine */
    return lw_v2(f[0], f[1]);
}

TEST(there_and_back)
{
    for (size_t i = 0; i < sizeof chains/sizeof *chains; i++) {
        lw_chain c;
        lw_mechanism m;
        lw_chain_layout l;
        OWN(lw_bytes) bytes = { 0 };
        CHECK_OK(lw_graph6_read(chains[i], strlen(chains[i]), NULL, &c, &check_error));
        CHECK_INT(lw_mechanism_from_chain(&c, &m), LW_OK);
        CHECK_OK(lw_chain_layout_make(&m, &l, &check_error));
        lw_layout_pack(&l, m.n_link, &bytes);
        const char *b = bytes.data, *ring = b + 14 + m.n_link, *at = ring + l.first[m.n_link];
        CHECK(b[0] == 1 && b[1] == m.n_link && b[2] == l.n_joint && b[3] == l.planar && b[4] == l.n_cross);
        CHECK_NEAR(place(b + 6).x, l.least_angle, 0, 1e-6);
        for (int k = 0; k < m.n_link; k++)
            CHECK_INT(b[14 + k], l.first[k + 1] - l.first[k]);
        CHECK(memcmp(ring, l.ring, (size_t)l.first[m.n_link]) == 0);
        for (int j = 0; j < l.n_joint; j++)
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(place(at + 8*j), l.at[j])), 0, 1e-6, 1e-6);
        CHECK_INT(bytes.size, at + 8*l.n_joint - b);         /* no link of a closed chain has a free end */
    }
}
