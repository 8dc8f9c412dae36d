/* What is read prints and reads back the same, and is a chain. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "grammar/franke.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_franke f, back;
    lw_chain c;
    lw_error e;
    char text[LW_FRANKE_SIZE];
    if (lw_franke_read((const char *)data, size, "fuzz", &f, &e) != LW_OK)
        return 0;
    size_t n = lw_franke_print(&f, text, sizeof text);
    if (n >= sizeof text || lw_franke_read(text, n, "fuzz", &back, &e) != LW_OK
        || memcmp(&f, &back, sizeof f) != 0 || lw_franke_chain(&f, &c) != LW_OK)
        abort();
    return 0;
}
