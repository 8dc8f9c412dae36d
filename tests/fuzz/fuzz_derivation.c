/* A derivation that can be read is printed and read back the same, and replays to a structure. */
#include "grammar/derivation.h"
#include "tests/fuzz/fuzz.h"

static bool replays(const lw_derivation *d)
{
    lw_structure s;
    lw_error e;
    return lw_derivation_replay(d, &s) == LW_OK && lw_structure_check(&s, &e) == LW_OK;
}

FUZZ_READS_BACK(lw_derivation, lw_derivation_read, lw_derivation_print, LW_DERIVATION_SIZE,
                memcmp(&a, &b, sizeof a) == 0 && replays(&a))
