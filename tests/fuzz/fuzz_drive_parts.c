/* Any bytes are a table of parts with sane numbers, or have an error with a place, and nothing is kept of them. */
#include <math.h>
#include "grammar/drive_parts.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lw_drive_parts p = { 0 };
    lw_error e = { .text = "" };
    lw_status s = lw_drive_parts_read((const char *)data, size, "f", &p, &e);
    if (s != LW_OK && (e.status != s || !e.text[0] || (s == LW_E_NOTATION && (e.line < 1 || e.column < 1))
                       || p.n_motor + p.n_gear + p.n_amplifier > 0))
        abort();
    for (int kind = 0; kind < 3; kind++)
        for (int i = 0; i < lw_part_count(&p, kind); i++) {
            if (!lw_part_name(&p, kind, i)[0])
                abort();
            for (const lw_part_column *c = lw_part_columns(kind); c->name; c++)
                if (!isfinite(*lw_part_value(&p, kind, i, c)) || *lw_part_value(&p, kind, i, c) < 0)
                    abort();
        }
    lw_drive_parts_is((const char *)data, size);
    lw_drive_parts_free(&p);
    return 0;
}
