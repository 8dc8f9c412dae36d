#include "tests/fuzz/outline_fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    return fuzz_outline(lw_target_read_dxf, data, size);
}
