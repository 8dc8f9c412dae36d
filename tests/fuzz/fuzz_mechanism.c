/* What is read prints and reads back the same. */
#include <stdint.h>
#include <stdlib.h>
#include "grammar/mechanism_json.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_mechanism m, back;
    lw_error e;
    char text[LW_MECHANISM_JSON_SIZE];
    if (lw_mechanism_read((const char *)data, size, "fuzz", &m, &e) != LW_OK)
        return 0;
    size_t n = lw_mechanism_write(&m, text, sizeof text);
    if (n >= sizeof text || lw_mechanism_read(text, n, "fuzz", &back, &e) != LW_OK
        || !lw_mechanism_same(&m, &back))
        abort();
    return 0;
}
