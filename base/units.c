#include "base/units.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/vec2.h"

typedef struct unit { const char *name; double factor; } unit;

static const unit lengths[] = {
    { "m", 1 }, { "mm", 1e-3 }, { "cm", 1e-2 }, { "km", 1e3 }, { "um", 1e-6 },
    { "in", 0.0254 }, { "ft", 0.3048 },                    /* international yard, 1959: exact */
};
static const char *const rates[][2] = {                    /* of lengths, in their order */
    { "m/s", "m/s^2" }, { "mm/s", "mm/s^2" }, { "cm/s", "cm/s^2" }, { "km/s", "km/s^2" }, { "um/s", "um/s^2" },
    { "in/s", "in/s^2" }, { "ft/s", "ft/s^2" },
};
static const unit angles[] = {
    { "rad", 1 }, { "deg", LW_PI/180 }, { "turn", 2*LW_PI },
};

static bool set(const unit *table, size_t n, const char *name, char text[8], double *factor)
{
    for (size_t i = 0; name && i < n; i++)
        if (strcmp(table[i].name, name) == 0) {
            snprintf(text, 8, "%s", name);
            *factor = table[i].factor;
            return true;
        }
    return false;
}

lw_units lw_units_si(void)
{
    return (lw_units){ .length = "", .angle = "rad", .metre = 1, .radian = 1 };
}

bool lw_units_set_length(lw_units *u, const char *name)
{
    return set(lengths, sizeof lengths/sizeof *lengths, name, u->length, &u->metre);
}

bool lw_units_set_angle(lw_units *u, const char *name)
{
    return set(angles, sizeof angles/sizeof *angles, name, u->angle, &u->radian);
}

const char *lw_units_rate(const lw_units *u, int order)
{
    size_t i = 0;
    for (size_t k = 0; k < sizeof lengths/sizeof *lengths; k++)
        i = strcmp(u->length, lengths[k].name) == 0 ? k : i;
    return rates[i][order - 1];
}
