/* Any bytes are a table of parts with sane numbers, or have an error with a place, and nothing is kept of them. */
#include <math.h>
#include "grammar/model/drive_parts.h"
#include "linkwright.h"
#include "tests/fuzz/fuzz.h"

/* Every choice has limits that are numbers or unknown, and those of the front can do the work. */
static void choose(const lw_drive_parts *p)
{
    static const double speed[] = { 0, 1, 0, -1, 0 }, torque[] = { 2, 2, 0, -1, 1 }, acceleration[] = { 5, 0, -5, 0, 5 };
    lw_load load = { .name = "drive", .n = 5, .step = 0.1, .speed = speed, .torque = torque, .acceleration = acceleration,
                     .inertia = { 0.1, 0.2 } };
    lw_error e;
    if (p->n_motor == 0 || p->n_gear == 0 || (double)p->n_motor*p->n_gear*(p->n_amplifier + 1) > 1e4)
        return;
    for (int slides = 0; slides < 2; slides++) {
        lw_drive_choice *c = NULL;
        bool *front = NULL;
        size_t n = 0;
        load.slides = slides;
        lw_status s = lw_drive_choose(&load, p, 10, NULL, &n, &c, &front, &e);
        for (size_t i = 0; s == LW_OK && i < n; i++)
            if (isnan(c[i].torque_rms) || isnan(c[i].worst) || (front[i] && c[i].fails) || c[i].ratio < 0)
                abort();
        free(c);
        free(front);
    }
}

static int one_input(const uint8_t *data, size_t size)
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
    choose(&p);
    lw_drive_parts_free(&p);
    return 0;
}
