/* Shortest cycle bases: as many circuits as loops, each a circuit, lengths of known graphs, and no
 * shorter basis by brute force over all circuits. */
#include "check.h"
#include "grammar/topology/circuit.h"
#include "topology.h"

static void rows_of(const lw_mechanism *m, uint32_t *row)
{
    lw_chain c;
    lw_mechanism_chain(m, &c);
    for (int i = 0; i < m->n_link; i++)
        row[i] = lw_chain_neighbours(&c, i);
}

typedef struct search {
    const lw_mechanism *m;
    uint32_t row[LW_LINK_MAX];
    uint64_t edges[4096];
    int      length[4096], n;
} search;

/* All circuits through `start` over higher links, each found in both senses. */
static void extend(search *s, int start, int at, uint32_t seen, uint64_t edges, int length)
{
    for (uint32_t m = s->row[at]; m; m &= m - 1) {
        int next = __builtin_ctz(m);
        uint64_t with = edges | (uint64_t)1 << lw_mechanism_joint(s->m, at, next);
        if (next == start && length >= 3 && s->n < 4096) {
            s->edges[s->n] = with;
            s->length[s->n++] = length;
        }
        if (next > start && !(seen >> next & 1))
            extend(s, start, next, seen | 1u << next, with, length + 1);
    }
}

/* Greedy over all circuits by length: the matroid's least basis. */
static int least_total(search *s)
{
    uint64_t rows[64];
    int n_row = 0, total = 0;
    s->n = 0;
    for (int i = 0; i < s->m->n_link; i++)
        extend(s, i, i, 1u << i, 0, 1);
    for (int length = 3; length <= s->m->n_link; length++)
        for (int k = 0; k < s->n; k++)
            if (s->length[k] == length && lw_gf2_add(rows, &n_row, s->edges[k]))
                total += length;
    return total;
}

TEST(no_shorter_basis)
{
    static search s;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 400; trial++) {
        lw_mechanism m = random_topology(&rng, 3 + trial % 7, trial % 8, "r");
        lw_chain_circuits c;
        s.m = &m;
        rows_of(&m, s.row);
        CHECK_INT(lw_circuit_basis(m.n_link, s.row, &c), LW_OK);
        CHECK_INT(c.n_circuit, m.n_joint - m.n_link + 1);
        for (int k = 0; k < c.n_circuit; k++)
            for (int i = c.first[k]; i < c.first[k + 1]; i++) {
                int next = i + 1 < c.first[k + 1] ? i + 1 : c.first[k];
                CHECK(s.row[c.vertex[i]] >> c.vertex[next] & 1);
            }
        CHECK_INT(c.first[c.n_circuit], least_total(&s));
    }
}

TEST(known_lengths)
{
    lw_chain watt = watt_chain(), stephenson = stephenson_chain();
    lw_chain_circuits c;
    uint32_t row[LW_LINK_MAX];
    for (int i = 0; i < 6; i++)
        row[i] = lw_chain_neighbours(&watt, i);
    lw_circuit_basis(6, row, &c);
    CHECK_INT(c.n_circuit, 2);
    CHECK_INT(c.first[2], 8);                                /* two four-bars */
    for (int i = 0; i < 6; i++)
        row[i] = lw_chain_neighbours(&stephenson, i);
    lw_circuit_basis(6, row, &c);
    CHECK_INT(c.first[2], 9);                                /* a four-bar and a five-bar */
}
