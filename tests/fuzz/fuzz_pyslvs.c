#include "grammar/linkage/pyslvs.h"
#include "tests/fuzz/points_fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    return points_fuzz(data, size, lw_pyslvs_read, lw_pyslvs_write);
}
