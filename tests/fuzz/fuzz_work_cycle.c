/* Any bytes are a work cycle with finite states at any time, or have an error with a place. */
#include <math.h>
#include "grammar/model/work_cycle.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    lw_work_cycle c;
    lw_error e = { .text = "" };
    lw_status s = lw_work_cycle_read((const char *)data, size, "f", &c, &e);
    if (s != LW_OK && (e.status != s || !e.text[0] || (s == LW_E_NOTATION && (e.line < 1 || e.column < 1))))
        abort();
    for (int k = 0; s == LW_OK && k < c.n_axis; k++)
        for (int i = 0; i <= 8; i++) {
            double j;
            lw_axis_state at = lw_work_cycle_at(&c, k, c.end*i/8, &j);
            if (isnan(at.x) || isnan(at.v) || isnan(at.a) || isnan(j))
                abort();
        }
    lw_work_cycle_free(&c);
    return 0;
}
