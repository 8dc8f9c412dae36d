/* A GraphML graph that can be read is printed and read back the same. */
#include "grammar/topology/edges.h"
#include "tests/fuzz/fuzz.h"

static size_t print(const lw_mechanism *m, char *buf, size_t size) { return lw_graphml_print(m, buf, size); }

FUZZ_READS_BACK(lw_mechanism, lw_graphml_read, print, LW_GRAPHML_SIZE, lw_mechanism_same(&a, &b))
