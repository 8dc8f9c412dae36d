/* tests/fuzz/outline_fuzz.h - any bytes are a drawing with a target in it, or are refused. */
#ifndef LW_TESTS_FUZZ_OUTLINE_FUZZ_H
#define LW_TESTS_FUZZ_OUTLINE_FUZZ_H

#include <math.h>
#include "optimise/task/target_outline.h"
#include "tests/fuzz/fuzz.h"

typedef lw_status read_outline(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e);

static inline int fuzz_outline(read_outline *read, const uint8_t *data, size_t size)
{
    static const lw_target_options option[] = { { .closed = -1 },
        { .closed = 1, .length_unit = "in", .curve = "all" },
        { .length_unit = "km", .angle_unit = "deg", .curve = "1", .stations = -1, .smooth = 0.1 } };
    for (int i = 0; i < 3; i++) {
        lw_target t;
        lw_error e = { .text = "" };
        if (read((const char *)data, size, "f", &option[i], &t, &e) != LW_OK) {
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

#endif
