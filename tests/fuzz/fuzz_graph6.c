/* What is read prints and reads back the same. */
#include <stdint.h>
#include <stdlib.h>
#include "grammar/graph6.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_chain c, back;
    lw_error e;
    char text[LW_GRAPH6_SIZE];
    if (lw_graph6_read((const char *)data, size, "fuzz", &c, &e) != LW_OK)
        return 0;
    size_t n = lw_graph6_print(&c, text, sizeof text);
    if (n >= sizeof text || lw_graph6_read(text, n, "fuzz", &back, &e) != LW_OK
        || !lw_chain_same(&c, &back))
        abort();
    return 0;
}
