/* What is read prints and reads back the same. */
#include <stdint.h>
#include <stdlib.h>
#include "grammar/edges.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_mechanism m, back;
    lw_error e;
    char text[LW_EDGES_SIZE];
    if (lw_edges_read((const char *)data, size, "fuzz", &m, &e) != LW_OK)
        return 0;
    size_t n = lw_edges_print(&m, text, sizeof text);
    if (n >= sizeof text || lw_edges_read(text, n, "fuzz", &back, &e) != LW_OK
        || !lw_mechanism_same(&m, &back))
        abort();
    return 0;
}
