/* Links on pins that can be read are printed and read back the same, and have simple joints or are too many. */
#include "grammar/topology/multiple.h"
#include "tests/fuzz/fuzz.h"

static bool has_axes(const lw_multiple *m)
{
    lw_mechanism all;
    uint32_t axes;
    return lw_multiple_mechanism(m, &all, &axes) != LW_OK || all.n_link == m->n_link + __builtin_popcount(axes);
}

FUZZ_READS_BACK(lw_multiple, lw_multiple_read, lw_multiple_print, LW_MULTIPLE_SIZE, memcmp(&a, &b, sizeof a) == 0 && has_axes(&a))
