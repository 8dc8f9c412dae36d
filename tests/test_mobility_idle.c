/* tests/test_mobility_idle.c - what nobody looks at is held, and the rest moves as before. */
#include "mbs/constraints/mobility.h"
#include "mbs/constraints/motion_curve.h"
#include "tests/check.h"
#include "tests/kept_system.h"
#include "tests/mbs_linkage.h"

static lw_mobility find(const lw_linkage *k)
{
    const lw_mobility_options o = lw_mobility_options_default();
    lw_mobility m;
    CHECK_INT(lw_mobility_find(k, &o, &m, NULL), LW_OK);
    return m;
}

/* A Scotch yoke whose pin is a roller: x of the yoke is that of the pin. */
TEST(a_roller_is_held)
{
    lw_linkage k;
    uint64_t held;
    KEPT_SYSTEM s = { 0 };
    lw_motion_curve *b;
    double q[9];
    blank_linkage(&k, 4);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 0.6, 0.8), SLIDE(3, 2, 0.6, 0.8, 0.5*LW_PI)));
    k.joint[2].kind = LW_JOINT_SLOT;
    add_slide(&k, 0, 3, lw_v2(2, 0), 0);
    add_input(&k, 0, atan2(0.8, 0.6));
    add_tracer(&k, 3, lw_v2(3, 0));
    CHECK_INT(find(&k).freedom, 2);
    CHECK_INT(lw_mobility_hold_idle(&k, &held, NULL), LW_OK);
    CHECK_INT(held, 1 << 1);
    CHECK_INT(find(&k).freedom, 1);
    CHECK_INT(lw_system_make(&k, NULL, 0, &s, NULL), LW_OK);
    CHECK_INT(lw_motion_curve_create(&s, NULL, &(lw_motion_curve_options){ .input = 0 }, &b, NULL), LW_OK);
    for (int i = 0; i <= 50; i++) {
        lw_motion_curve_posture(b, lw_motion_curve_segments(b)*i/50.0, q, NULL);
        CHECK_NEAR(lw_system_point(&s, s.tracer_body[0], s.tracer_arm[0], q).x, 2.4 + cos(lw_motion_curve_input(b, q)), 1e-13, 0);
    }
    lw_motion_curve_free(b);
}

/* Two bars hang on a crank-rocker, a block slides on its coupler: three joints, not the four-bar's. */
TEST(all_that_hangs_on_it)
{
    lw_linkage k;
    uint64_t held;
    blank_linkage(&k, 7);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 0.5, 1), PIN(2, 3, 3, 1.5), PIN(3, 0, 2.5, 0), PIN(3, 4, 3, 2), PIN(4, 5, 4, 2),
                          SLIDE(2, 6, 1, 2, 0.3)));
    add_input(&k, 0, 0);
    add_tracer(&k, 2, lw_v2(1, 1));
    CHECK_INT(find(&k).idle, 3);
    CHECK_INT(lw_mobility_hold_idle(&k, &held, NULL), LW_OK);
    CHECK_INT(held, 1 << 4 | 1 << 5 | 1 << 6);
    CHECK_INT(find(&k).freedom, 1);
}

/* A freedom that a tracer notices is not idle, and with a tracer on the last bar nothing is. */
TEST(what_is_noticed_is_left)
{
    lw_linkage k;
    uint64_t held;
    blank_linkage(&k, 5);
    for (int i = 0; i < 5; i++)
        add_pin(&k, i, (i + 1)%5, lw_v2_polar(1, 1.2*i));
    add_input(&k, 0, 0);
    add_tracer(&k, 2, lw_v2(1, 1));
    CHECK_INT(lw_mobility_hold_idle(&k, &held, NULL), LW_OK);
    CHECK_INT(held, 0);
    CHECK_INT(find(&k).freedom, 2);
    k.joint[1].link[0] = 9;
    CHECK_INT(lw_mobility_hold_idle(&k, &held, NULL), LW_E_ARG);
}
