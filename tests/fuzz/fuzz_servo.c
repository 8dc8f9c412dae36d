/* Any bytes are a servo axis with sane numbers, or have an error with a place. */
#include <math.h>

#include "grammar/model/servo.h"
#include "tests/fuzz/fuzz.h"

static int one_input(const uint8_t *data, size_t size)
{
    static lw_servo s;
    lw_error e = { .text = "" };
    lw_status status = lw_servo_read((const char *)data, size, "f", &s, &e);
    if (refused(status, &e))
        return 0;
    demand(s.constant > 0 && s.inertia > 0 && s.factor > 0 && s.load >= 0 && (s.moves.n > 0 || s.reference));
    for (double t = 0; s.moves.n && t < 1e9; t = lw_servo_next_kink(&s, t))
        demand(isfinite(lw_servo_wanted(&s, t).x));
    lw_servo_free(&s);
    return 0;
}
