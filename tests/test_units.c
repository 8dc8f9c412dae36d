/* Unit names and their factors. */
#include "base/units.h"
#include "base/vec2.h"
#include "tests/check.h"

/* Factors by definition: SI brochure; international foot and inch of 1959. */
static const struct { const char *name; double factor; } lengths[] = {
    { "m", 1 }, { "mm", 0.001 }, { "cm", 0.01 }, { "km", 1000 }, { "um", 1e-6 },
    { "in", 0.0254 }, { "ft", 0.3048 },
}, angles[] = { { "rad", 1 }, { "deg", LW_PI/180 }, { "turn", 2*LW_PI } };

TEST(known_names)
{
    lw_units u = lw_units_si();
    for (size_t i = 0; i < sizeof lengths/sizeof *lengths; i++) {
        CHECK(lw_units_set_length(&u, lengths[i].name));
        CHECK_TEXT(u.length, lengths[i].name);
        CHECK_NEAR(u.metre, lengths[i].factor, 0, 0);
    }
    for (size_t i = 0; i < sizeof angles/sizeof *angles; i++) {
        CHECK(lw_units_set_angle(&u, angles[i].name));
        CHECK_TEXT(u.angle, angles[i].name);
        CHECK_NEAR(u.radian, angles[i].factor, 0, 0);
    }
    CHECK_NEAR(12*0.0254, 0.3048, 0, 1e-15);
}

TEST(unknown_names_change_nothing)
{
    static const char *const wrong[] = { "", "M", "mmm", "furlong", "degree", "rad ", " mm", NULL };
    lw_units u = lw_units_si();
    lw_units_set_length(&u, "mm");
    lw_units_set_angle(&u, "deg");
    for (size_t i = 0; i < sizeof wrong/sizeof *wrong; i++) {
        CHECK(!lw_units_set_length(&u, wrong[i]));
        CHECK(!lw_units_set_angle(&u, wrong[i]));
    }
    CHECK(!lw_units_set_length(&u, "deg"));
    CHECK(!lw_units_set_angle(&u, "mm"));
    CHECK_TEXT(u.length, "mm");
    CHECK_TEXT(u.angle, "deg");
}

TEST(si_is_factor_one)
{
    lw_units u = lw_units_si();
    CHECK_TEXT(u.length, "");
    CHECK_TEXT(u.angle, "rad");
    CHECK(u.metre == 1 && u.radian == 1);
}
