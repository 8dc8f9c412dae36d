/* A derivation that can be read is printed and read back the same, and replays to a structure. */
#include "grammar/topology/derivation.h"
#include "tests/fuzz/fuzz.h"
#include "tests/structure_check.h"

static bool replays(const lw_derivation *d)
{
    lw_structure s;
    return lw_derivation_replay(d, &s) == LW_OK && is_structure(&s);
}

FUZZ_READS_BACK(lw_derivation, lw_derivation_read, lw_derivation_print, LW_DERIVATION_SIZE, memcmp(&a, &b, sizeof a) == 0 && replays(&a))
