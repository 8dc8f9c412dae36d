/* What is read prints and reads back the same. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "grammar/lam.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_lam a, back;
    lw_error e;
    char text[LW_LAM_SIZE];
    if (lw_lam_read((const char *)data, size, "fuzz", &a, &e) != LW_OK)
        return 0;
    size_t n = lw_lam_print(&a, text, sizeof text);
    if (n >= sizeof text || lw_lam_read(text, n, "fuzz", &back, &e) != LW_OK
        || memcmp(&a, &back, sizeof a) != 0)
        abort();
    return 0;
}
