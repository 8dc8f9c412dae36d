/* A link adjacency matrix that can be read is printed and read back the same. */
#include "grammar/topology/lam.h"
#include "tests/fuzz/fuzz.h"

FUZZ_READS_BACK(lw_lam, lw_lam_read, lw_lam_print, LW_LAM_SIZE, memcmp(&a, &b, sizeof a) == 0)
