#include "grammar/linkage/pmks.h"
#include "tests/fuzz/points_fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    return points_fuzz(data, size, lw_pmks_read, lw_pmks_write);
}
