/* Any bytes as a drawing: what is read is a target. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "optimise/target_outline.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const lw_target_options option[] = { { -1, NULL, NULL }, { 1, "in", NULL }, { 0, "km", "deg" } };
    for (int i = 0; i < 3; i++) {
        lw_target t;
        lw_error e = { .text = "" };
        if (lw_target_read_svg((const char *)data, size, "f", &option[i], &t, &e) != LW_OK) {
            if (!e.text[0] || (e.status == LW_E_NOTATION && e.line < 1) || t.store)
                abort();
            continue;
        }
        if (t.n < 1 || t.n > LW_STATION_MAX)
            abort();
        for (size_t k = 0; k < t.n; k++)
            if (!isfinite(t.x[k]) || !isfinite(t.y[k]) || t.line[k] < 1)
                abort();
        lw_target_free(&t);
    }
    return 0;
}
