/* A mechanism in JSON that can be read is written and read back the same. */
#include "grammar/topology/mechanism_json.h"
#include "tests/fuzz/fuzz.h"

FUZZ_READS_BACK(lw_mechanism, lw_mechanism_read, lw_mechanism_write, LW_MECHANISM_JSON_SIZE, lw_mechanism_same(&a, &b))
