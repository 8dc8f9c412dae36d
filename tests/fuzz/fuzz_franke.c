/* Franke's notation that can be read is printed and read back the same, and is a chain. */
#include "grammar/topology/franke.h"
#include "tests/fuzz/fuzz.h"

static bool is_chain(const lw_franke *f)
{
    lw_chain c;
    return lw_franke_chain(f, &c) == LW_OK;
}

FUZZ_READS_BACK(lw_franke, lw_franke_read, lw_franke_print, LW_FRANKE_SIZE, memcmp(&a, &b, sizeof a) == 0 && is_chain(&a))
