#include "tests/fuzz/outline_fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return fuzz_outline(lw_target_read_svg, data, size);
}
