/* Any bytes are a table of published counts or have an error with a line. */
#include "enumerate/published.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    lw_published_table t;
    lw_error e = { 0 };
    size_t sum = 0;
    if (lw_published_read((const char *)data, size, "fuzz", &t, &e) != LW_OK) {
        if (e.line < 1)
            abort();
        return 0;
    }
    for (size_t i = 0; i < t.n; i++)
        sum += strlen(t.row[i].family) + strlen(t.row[i].what) + strlen(t.row[i].source);
    if (sum > 3*size)
        abort();
    lw_published_free(&t);
    return 0;
}
