/* A chain in graph6 that can be read is printed and read back the same. */
#include "grammar/topology/graph6.h"
#include "tests/fuzz/fuzz.h"

FUZZ_READS_BACK(lw_chain, lw_graph6_read, lw_graph6_print, LW_GRAPH6_SIZE, lw_chain_same(&a, &b))
