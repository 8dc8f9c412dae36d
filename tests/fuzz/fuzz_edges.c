/* A list of edges that can be read is printed and read back the same. */
#include "grammar/topology/edges.h"
#include "tests/fuzz/fuzz.h"

FUZZ_READS_BACK(lw_mechanism, lw_edges_read, lw_edges_print, LW_EDGES_SIZE, lw_mechanism_same(&a, &b))
