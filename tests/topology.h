/* tests/topology.h - topologies for tests: named ones and random ones. */
#ifndef LW_TESTS_TOPOLOGY_H
#define LW_TESTS_TOPOLOGY_H

#include "base/rng.h"
#include "grammar/topology/mechanism.h"

static inline lw_chain ring_of(int n)
{
    lw_chain c;
    lw_chain_clear(&c, n);
    for (int i = 0; i < n; i++)
        lw_chain_join(&c, i, (i + 1) % n, 1);
    return c;
}

/* Makkonen 1999, paper F, eq. 18: circuits 1 2 3 4 and 1 4 5 6. */
static inline lw_chain watt_chain(void)
{
    lw_chain c = ring_of(6);
    lw_chain_join(&c, 0, 3, 1);
    return c;
}

/* Two ternary links that no joint connects: lines with 1, 1 and 2 binary links. */
static inline lw_chain stephenson_chain(void)
{
    lw_chain c;
    static const uint8_t pair[7][2] = { {0,2}, {2,1}, {0,3}, {3,1}, {0,4}, {4,5}, {5,1} };
    lw_chain_clear(&c, 6);
    for (int j = 0; j < 7; j++)
        lw_chain_join(&c, pair[j][0], pair[j][1], 1);
    return c;
}

/* K3,3 with two binary links on each of two lines that do not meet: F = 1, ten links, not planar.
 * Without these lines it is Watt's chain. */
static inline lw_chain nonplanar_chain(void)
{
    lw_chain c;
    int next = 6;
    lw_chain_clear(&c, 10);
    for (int a = 0; a < 3; a++)
        for (int b = 3; b < 6; b++)
            if (b == a + 3 && a < 2) {
                lw_chain_join(&c, a, next, 1);
                lw_chain_join(&c, next, next + 1, 1);
                lw_chain_join(&c, next + 1, b, 1);
                next += 2;
            } else {
                lw_chain_join(&c, a, b, 1);
            }
    return c;
}

/* Any connected graph of n links with about `extra` joints more than a tree; every kind of joint. */
static inline lw_mechanism random_topology(lw_rng *rng, int n, int extra, const char *kinds)
{
    lw_mechanism m;
    int n_kind = 0;
    while (kinds[n_kind])
        n_kind++;
    lw_mechanism_clear(&m, n);
    for (int i = 1; i < n; i++)
        lw_mechanism_join(&m, i, (int)lw_rng_range(rng, 0, i), kinds[(int)lw_rng_range(rng, 0, n_kind)]);
    for (; extra > 0 && n > 1; extra--)
        lw_mechanism_join(&m, (int)lw_rng_range(rng, 0, n), (int)lw_rng_range(rng, 0, n), kinds[(int)lw_rng_range(rng, 0, n_kind)]);
    return m;
}

static inline void random_permutation(lw_rng *rng, int n, uint8_t *to)
{
    for (int i = 0; i < n; i++) {
        int k = (int)lw_rng_range(rng, 0, i + 1);
        to[i] = to[k];
        to[k] = (uint8_t)i;
    }
}

#endif
