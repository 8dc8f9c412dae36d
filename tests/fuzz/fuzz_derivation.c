/* What is read prints and reads back the same, and replays. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "grammar/derivation.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_derivation d, back;
    lw_structure s;
    lw_error e;
    char text[LW_DERIVATION_SIZE];
    if (lw_derivation_read((const char *)data, size, "fuzz", &d, &e) != LW_OK)
        return 0;
    size_t n = lw_derivation_print(&d, text, sizeof text);
    if (n >= sizeof text || lw_derivation_read(text, n, "fuzz", &back, &e) != LW_OK
        || memcmp(&d, &back, sizeof d) != 0 || lw_derivation_replay(&d, &s) != LW_OK
        || lw_structure_check(&s, &e) != LW_OK)
        abort();
    return 0;
}
