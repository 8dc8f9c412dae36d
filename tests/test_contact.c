/* tests/test_contact.c - laws of contact: values by hand, pieces that meet, energy, friction, names. */
#include "mbs/elastic/contact.h"
#include "tests/check.h"

static lw_clearance law(lw_clearance_model m)
{
    return (lw_clearance){ .model = m, .gap = 1e-4, .stiffness = 1e8, .exponent = 1.5, .damping = 3000, .depth = 1.2e-6,
                           .restitution = 0.8, .friction = 0.2, .friction_speed = 1e-3 };
}

/* Makkonen 1999, paper C, eqs. 2-3 at depth d/2 and beyond d, and the laws of restitution, by hand */
TEST(values)
{
    lw_clearance c = law(LW_CLEARANCE_IMPACT);
    c.exponent = 1.0;
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_RISING, 0.6e-6, 0.01, 0), 60.0 + 0.125*30.0, 1e-10, 0);
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_FULL, 2e-6, 0.01, 0), 230.0, 1e-10, 0);
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_FULL, 2e-6, -0.1, 0), -100.0, 1e-10, 0);
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_APART, 2e-6, 0.01, 0), 0.0, 0, 0);
    c = law(LW_CLEARANCE_MLSD);
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_FULL, -1e-6, 0.01, 0), -70.0, 1e-10, 0);
    double k = 1e8*pow(4e-6, 1.5);
    c = law(LW_CLEARANCE_HUNT_CROSSLEY);
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_FULL, 4e-6, 0.05, 0.1), k*1.15, 0, 1e-13);
    c = law(LW_CLEARANCE_LANKARANI);
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_FULL, 4e-6, 0.05, 0.1), k*1.135, 0, 1e-13);
    CHECK_NEAR(lw_contact_force(&c, LW_CONTACT_FULL, 4e-6, 0.05, 0.0), k*(1.0 + 0.75*0.36*0.05/LW_CONTACT_SLOWEST), 0, 1e-13);
    CHECK_NEAR(lw_contact_friction(&c, -50.0, 1.0), 10.0, 1e-12, 0);
    CHECK_NEAR(lw_contact_friction(&c, 50.0, -0.5e-3), -10.0*tanh(0.5), 1e-12, 0);
}

/* The phases meet: force at their borders, and the phase that holds on each side */
TEST(pieces_meet)
{
    for (lw_clearance_model m = LW_CLEARANCE_MLSD; m <= LW_CLEARANCE_LANKARANI; m++) {
        lw_clearance c = law(m);
        bool rises = lw_contact_rises(&c);
        CHECK_INT(rises, m == LW_CLEARANCE_IMPACT);
        lw_contact_phase first = rises ? LW_CONTACT_RISING : LW_CONTACT_FULL;
        if (m != LW_CLEARANCE_MLSD) {
            CHECK_INT(lw_contact_phase_at(&c, -1e-9), LW_CONTACT_APART);
            CHECK_NEAR(lw_contact_force(&c, first, 0.0, 0.3, 0.3), 0.0, 0, 0);
        }
        CHECK_INT(lw_contact_phase_at(&c, 1e-9), first);
        CHECK_INT(lw_contact_phase_at(&c, 2e-6), LW_CONTACT_FULL);
        CHECK_NEAR(lw_contact_force(&c, first, c.depth, 0.1, 0.3), lw_contact_force(&c, LW_CONTACT_FULL, c.depth, 0.1, 0.3), 0, 1e-14);
        CHECK(isfinite(lw_contact_force(&c, LW_CONTACT_FULL, -1e-7, 0.1, 0.3)));
    }
    lw_clearance c = law(LW_CLEARANCE_IMPACT);
    c.damping = 0.0;
    CHECK(!lw_contact_rises(&c));
}

/* dE/ddepth is the force without damping; the depth of a force gives it back */
TEST(energy_and_depth)
{
    for (lw_clearance_model m = LW_CLEARANCE_MLSD; m <= LW_CLEARANCE_LANKARANI; m++)
        for (double depth = 1e-7; depth < 1e-4; depth *= 3.0) {
            lw_clearance c = law(m);
            lw_contact_phase p = lw_contact_phase_at(&c, depth);
            double h = 1e-4*depth, f = lw_contact_force(&c, p, depth, 0.0, 1.0);
            double slope = (lw_contact_energy(&c, p, depth + h) - lw_contact_energy(&c, p, depth - h))/(2.0*h);
            CHECK_NEAR(slope, f, 0, 1e-7);
            CHECK_NEAR(lw_contact_depth(&c, f), depth, 0, 1e-13);
        }
    lw_clearance c = law(LW_CLEARANCE_IMPACT);
    CHECK_NEAR(lw_contact_energy(&c, LW_CONTACT_APART, -1e-5), 0.0, 0, 0);
    CHECK_NEAR(lw_contact_depth(&c, 0.0), 0.0, 0, 0);
}

TEST(names)
{
    for (lw_clearance_model m = LW_CLEARANCE_ZERO; m <= LW_CLEARANCE_LANKARANI; m++)
        CHECK_INT(lw_clearance_named(lw_clearance_name(m)), m);
    CHECK_INT(lw_clearance_named("bounce"), LW_CLEARANCE_NONE);
    CHECK_INT(lw_clearance_named(""), LW_CLEARANCE_NONE);
    CHECK_TEXT(lw_clearance_name(LW_CLEARANCE_NONE), "");
    CHECK_TEXT(lw_clearance_name((lw_clearance_model)99), "");
}
