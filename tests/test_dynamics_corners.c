/* Contact at corners: of bodies that spin, slide over edges and tips, fall into valleys, or are wedged. */
#include "tests/touch_run.h"

/* A thin rod slides without friction over the edge of a table at 0.3 m/s: 0.15 s after its centre of mass has passed the edge it has turned by
 * 0.053114 rad, as the equations of a rod on a point say.  The same with segments without thickness, drawn above each other; one
 * drawn on the other is refused, since it may be on either side. */
TEST(thin_rods_slide_off)
{
    static const char thin[] = FREE("%s", "'mass': 1, 'centre': [0, %%1$g], 'inertia': 0.03, 'velocity': [0.3, 0]",
                                   "{'segment': [[-0.3, %%1$g], [0.3, %%1$g]]}", "'restitution': 0");
    static const char *const table[] = { "{'polygon': [[-1, -0.3], [1, -0.3], [1, 0], [-1, 0]]}", "{'segment': [[1, 0], [-1, 0]]}" };
    for (int k = 0; k < 6; k++) {
        char text[1000];
        double high = k < 4 ? 0 : 1e-3;
        snprintf(text, sizeof text, thin, table[k >= 2]);
        drun_read_format(&d, text, high, 0);
        CHECK_INT(drun_to(&d, k%2 ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, k%2 ? 1e-12 : 1e-6, 1/0.3 + 0.15, 2),
                  k/2 == 1 ? LW_E_ARG : LW_OK);
        if (k/2 != 1)
            CHECK_NEAR(d.q[2], -0.053114, k%2 ? 2e-3 : 1e-5, 0);
    }
}

/* A corner passes the end of a thin segment from one side to the other within a step: nothing touches.  Captured, too, where a step is longer
 * than its distance from the end; and one that meets the segment strikes. */
TEST(corner_comes_round_an_end)
{
    static const double beside[] = { 3e-7, 3e-6, 3e-3, -1e-3 };
    for (int k = 0; k < 8; k++) {
        char text[1000];
        double x = 1.3 + beside[k%4];
        bool captured = k/4, hits = k%4 == 3;
        snprintf(text, sizeof text, FREE("{'segment': [[0, 0], [1, 0]]}", "'mass': 1, 'centre': [%.17g, -0.9], 'inertia': 0.03, 'velocity': [-0.3, 0.9]",
                                         "{'polygon': [[%.17g, -0.9], [%.17g, -1.1], [%.17g, -0.9], [%.17g, -0.7]]}", "'restitution': 0"),
                 x + 0.2, x, x + 0.2, x + 0.4, x + 0.2);
        drun_read_format(&d, text, 0, 0);
        d.model.gravity = lw_v2(0, 0);
        CHECK_INT(drun_to(&d, captured ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, 1e-8, 1.5, 1), LW_OK);
        CHECK_NEAR(d.v[0]*d.system.unit, hits ? 0.06 : -0.3, hits ? 0.1 : 1e-12, 0);
        CHECK_NEAR(d.v[1]*d.system.unit, hits ? 0.52 : 0.9, hits ? 0.02 : 1e-12, 0);
    }
}

/* A floor and a ramp drawn as one polygon, or in pieces that meet or lie in each other, are the same ground: a box slides over the joints, up and on. */
TEST(ground_in_pieces)
{
    static const char *const ground[] = { "{'polygon': [[-2, 0], [0.5, 0], [1.5, 0.364], [3, 0.364], [3, -1], [-2, -1]]}",
        "{'line': [[0, 0], [1, 0]]}, {'polygon': [[0.5, 0], [3, 0], [3, 0.364], [1.5, 0.364]]}",
        "{'line': [[0, 0], [1, 0]]}, {'polygon': [[0.5, 0], [0.5, -0.3], [3, -0.3], [3, 0.364], [1.5, 0.364]]}",
        "{'segment': [[-2, 0], [0.2, 0]]}, {'segment': [[0.2, 0], [0.5, 0]]}, {'segment': [[0.5, 0], [1.5, 0.364]]}, {'segment': [[1.5, 0.364], [3, 0.364]]}",
        ("{'polygon': [[-2, 0], [0.2, 0], [0.2, -1], [-2, -1]]}, {'polygon': [[0.2, 0], [0.5, 0], [0.5, -1], [0.2, -1]]}, {'polygon': [[0.5, 0], [1.5, 0.364],"
        "[1.5, -1], [0.5, -1]]}, {'polygon': [[1.5, 0.364], [3, 0.364], [3, -1], [1.5, -1]]}") };
    double want[2][3] = { { 0 } };
    for (int k = 0; k < 20; k++) {
        char text[1500];
        bool captured = k >= 10, smooth = k/5%2;
        snprintf(text, sizeof text, FREE("%s", "'mass': 1, 'centre': [0, 0.15], 'inertia': 0.02, 'velocity': [5, 0]",
                 "{'polygon': [[-0.2, 0], [0.2, 0], [0.2, 0.3], [-0.2, 0.3]]}", "'friction': %g"), ground[k%5], smooth ? 0 : 0.2);
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, captured ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, 1e-9, 0.8, 4), LW_OK);
        for (int i = 0; i < 3; i++) {
            want[smooth][i] = k%5 || captured ? want[smooth][i] : state(d.q, i);
            CHECK_NEAR(state(d.q, i), want[smooth][i], captured ? 1e-2 : 1e-9, 0);
        }
        CHECK(want[smooth][0] > 2.2);
    }
}

/* A box slides 0.25 m over thin bars, and a wheel rolls over them, with as many steps as over one bar: their ends have no thickness, and a bar far away does not
 * move though the wheel turns. */
TEST(ground_of_many_bars)
{
    long steps[2] = { 0 };
    for (int k = 0; k < 4; k++) {
        char text[2500], bars[1500];
        bool wheel = k%2;
        size_t n = 0;
        for (int i = 0; i < (k/2 ? 20 : 1); i++)
            n += (size_t)snprintf(bars + n, sizeof bars - n, "%s{'segment': [[%.9g, 0], [%.9g, 0]]}", i ? ", " : "", 0.1*i - 0.3, k/2 ? 0.1*(i + 1) - 0.3 : 1.7);
        snprintf(text, sizeof text, FREE("%s", "'mass': 1, 'centre': [0.03, %g], 'inertia': 0.005, 'velocity': [1, 0], 'omega': %g", "%s",
                 "'friction': 0.2"), bars, wheel ? 0.1 : 0.05, wheel ? -10.0 : 0, wheel ? "{'circle': [0.03, 0.1], 'radius': 0.1}"
                 : "{'polygon': [[-0.095, 0], [0.155, 0], [0.155, 0.1], [-0.095, 0.1]]}");
        json_quotes(text);
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, wheel ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, 1e-8, 1, 4), LW_OK);
        CHECK_NEAR(state(d.q, 0), wheel ? 1.03 : 0.03 + 0.5/(0.2*g), 1e-8, 0);
        CHECK_NEAR(state(d.q, 1), wheel ? 0.1 : 0.05, 1e-8, 0);
        steps[wheel] = k < 2 ? d.report.steps : steps[wheel];
        CHECK(d.report.steps < 3*steps[wheel] + 300);
    }
}

/* A growing force pushes a box that stands on two or three points: it sticks until all of them are at the limit of their friction, and slides on
 * then.  On a second box of which it slides, too. */
TEST(pushed_boxes_let_go)
{
    static const lw_formulation each[] = { LW_FORMULATION_INDEX1, LW_FORMULATION_INDEX1, LW_FORMULATION_CAPTURE };
    for (int k = 0; k < 9; k++) {
        bool two = k%3 == 2;
        double limit = two ? 0.5*g : 0.4*2*g, after = 0.3, to = limit/8 + after, end = 8*after*after*after/6/(two ? 1 : 2);
        drun_read_format(&d, two ? "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [" FLOOR "]}, {'name': 'a', 'mass': 3, 'centre': [0, 0.05],"
            "'inertia': 0.1, 'shapes': [{'polygon': [[-0.5, 0], [0.5, 0], [0.5, 0.1], [-0.5, 0.1]]}]}, {'name': 'b', 'mass': 1, 'centre': [0, 0.15],"
            "'inertia': 0.02, 'shapes': [{'polygon': [[-0.2, 0.1], [0.2, 0.1], [0.2, 0.2], [-0.2, 0.2]]}]}], 'joints': [{'name': 'A', 'kind': 'n',"
            "'links': ['ground', 'a']}, {'name': 'B', 'kind': 'n', 'links': ['ground', 'b']}], 'contacts': [{'links': ['ground', 'a'], 'friction': 0.3},"
            "{'links': ['a', 'b'], 'friction': 0.5}], 'gravity': [0, -9.81], 'forces': [{'link': 'b', 'at': [0, 0.1], 'fx': '8*t'}], 'tracers': ["
            "{'name': 'P', 'link': 'b', 'at': [0, 0]}]}"
            : k%3 ? FREE(FLOOR, "'mass': 2, 'centre': [0, 0.05], 'inertia': 0.05", "{'polygon': [[-0.2, 0], [0.1, 0], [0.2, 0], [0.2, 0.1], [-0.2, 0.1]]}",
                         "'friction': 0.4}], 'forces': [{'link': 'b', 'at': [0, 0], 'fx': '8*t'")
            : FREE(FLOOR, "'mass': 2, 'centre': [0, 0.05], 'inertia': 0.05", "{'polygon': [[-0.2, 0], [0.2, 0], [0.2, 0.1], [-0.2, 0.1]]}",
                   "'friction': 0.4}], 'forces': [{'link': 'b', 'at': [0, 0], 'fx': '8*t'"), 0, 0);
        CHECK_INT(drun_to(&d, each[k/3], k < 3 ? 1e-9 : k < 6 ? 1e-5 : 1e-10, to, 4), LW_OK);
        CHECK_NEAR(d.tracer[4].x, end, k < 6 ? 1e-6 : 2e-3, 0);
    }
}

/* A box that is pressed against a wall is lifted at that side by a growing force.  It begins to turn about its other corner on the floor when friction is at its
 * limit at both corners: N = (W/4 - 30*0.05)/0.5 there, 30 + 0.7 N at the lower corner of the wall, so that the force is W + 21 - 0.51 N; at every
 * tolerance alike. */
TEST(box_lifted_along_a_wall)
{
    double want = 0, weight = 2*g, limit = (weight + 21 - 0.51*(weight/4 - 1.5)/0.5)/20;
    for (int k = 0; k < 2; k++) {
        free_model(FREE("{'polygon': [[-2, -2], [2, -2], [2, 0], [0, 0], [0, 2], [-2, 2]]}", "'mass': 2, 'centre': [0.25, 0.05], 'inertia': 0.05",
                        "{'polygon': [[0, 0], [0.5, 0], [0.5, 0.1], [0, 0.1]]}", "'friction': 0.7}], 'forces': [{'link': 'b', 'at': [0.25, 0.05], 'fx':"
                        "'-30'}, {'link': 'b', 'at': [0, 0.05], 'fy': '20*t'"), 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, k ? 1e-5 : 1e-10, limit - 1e-6, 2), LW_OK);
        CHECK_NEAR(d.q[2], 0, 1e-9, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, k ? 1e-5 : 1e-10, limit + 0.08, 2), LW_OK);
        CHECK(d.q[2] < -0.03);
        CHECK_NEAR(d.q[2], k ? want : d.q[2], 1e-4, 0);
        want = d.q[2];
    }
}

/* A triangle spins above the floor without gravity.  Only the longest of its corners strikes, for which it would be out again a moment later. */
TEST(spinning_triangle_strikes)
{
    double w = 40, high = 0.4995, part = LW_PI/1.5;
    for (int k = 0; k < 12; k++) {
        double early = 0.5*k + 0.2, angle = early - acos(high/0.5) - 0.5*LW_PI;      /* of the longest corner, which turns clockwise */
        char text[1000];
        snprintf(text, sizeof text, FREE(FLOOR, "'mass': 1, 'centre': [0, %.17g], 'inertia': 0.03, 'omega': %.17g", "{'polygon': [[%.17g, %.17g], [%.17g, %.17g], [%.17g, %.17g]]}",
                 "'friction': 0"), high, -w, 0.5*cos(angle), high + 0.5*sin(angle), 0.499*cos(angle + part), high + 0.499*sin(angle + part),
                 0.499*cos(angle - part), high + 0.499*sin(angle - part));
        drun_read_format(&d, text, 0, 0);
        d.model.gravity = lw_v2(0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-8, 0.3, 1), LW_OK);
        CHECK(d.report.n_event > 0);
        CHECK_NEAR(d.report.event[0].t, (early - 2*acos(high/0.5))/w, 1e-9, 0);
    }
}

/* A corner flies at the tip of a wedge, 20 degrees sharp, so near its end that it would be out again within 10 us to 1 ms. */
TEST(corner_meets_a_sharp_tip)
{
    for (int k = 0; k < 5; k++) {
        char text[1000];
        double x = 0.5 - 0.03*pow(0.3, k);
        snprintf(text, sizeof text, FREE("{'polygon': [[-0.5, 0], [0.5, 0], [-0.5, -0.36397]]}", "'mass': 1, 'centre': [%.17g, 1.2], 'inertia': 0.03, 'velocity': [0, -8]",
                 "{'polygon': [[%.17g, 1], [%.17g, 1.2], [%.17g, 1.4], [%.17g, 1.2]]}", "'restitution': 0.5"), x, x, x + 0.2, x, x - 0.2);
        drun_read_format(&d, text, 0, 0);
        d.model.gravity = lw_v2(0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-8, 0.2, 1), LW_OK);
        CHECK_NEAR(d.v[1]*d.system.unit, 4, 1e-9, 0);
    }
}

/* A corner of a lever slides on a side of a pawl to its end, where the pawl's corner comes to that of the lever at 6.7 rad/s: it passes, and nothing strikes.
 * Captured, the pawl stopped there.  By index1, which locates the events. */
TEST(corner_slides_off_a_corner)
{
    double turn[2];
    drun_read_format(&d, "{'linkwright': 1, 'units': {'length': 'mm'}, 'gravity': [0, -9.81], 'links': ['ground', {'name': 'lever', 'mass': 0.4, "
        "'centre': [60, 0], 'inertia': 0.0006, 'shapes': [{'polygon': [[0, -5], [120, -5], [120, 5], [0, 5]]}]}, {'name': 'pawl', 'mass': 0.15, "
        "'centre': [125, -40], 'inertia': 0.0002, 'shapes': [{'polygon': [[116, -6], [116, -14], [130, -14], [130, -6]]}]}], 'joints': [{'name': 'O', "
        "'links': ['ground', 'lever'], 'at': [0, 0]}, {'name': 'Q', 'links': ['ground', 'pawl'], 'at': [128, -70]}], 'contacts': [{'name': 'hook', "
        "'links': ['lever', 'pawl'], 'friction': 0.15}], 'springs': [{'joint': 'Q', 'stiffness': 0.3, 'free': 0.3, 'damping': 0.002}]}", 0, 0);
    for (int k = 4; k <= 12; k++) {
        CHECK_INT(drun_to(&d, k > 4 ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, k > 4 ? pow(10, -k) : 1e-10, 0.2, 40), LW_OK);
        for (int b = 0; b < 2; b++) {
            CHECK_NEAR(d.q[3*b + 2], k > 4 ? turn[b] : d.q[3*b + 2], k < 10 ? 5e-3 : 5e-4, 0);
            turn[b] = k > 4 ? turn[b] : d.q[3*b + 2];
        }
    }
}

/* Two wedges slide towards each other on one floor, sharp corner against sharp corner: their corners are on the plane of the other's lower face
 * when they meet.  Without friction the one pushes the other, and momentum stays. */
TEST(wedges_meet_on_a_floor)
{
    for (int k = 0; k < 4; k++) {                        /* a block upright, leaning back, leaning over; and a wedge that turns up about its tip */
        double slope = k == 1 ? 2 : 0.5, back = k == 1 ? 0.1 : k >= 2 ? -0.1 : 0, turn = k == 3 ? 6 : 0;
        char text[2000];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [" FLOOR "]}, {'name': 'a', 'mass': 1, 'centre': [-0.5, 0.1], 'inertia': 0.02,"
            "'velocity': [2, 0], 'shapes': [{'polygon': [[-0.7, 0], [-0.3, 0], [%.17g, 0.3], [-0.7, 0.3]]}]}, {'name': 'b', 'mass': 3, 'centre': [0.3, 0.1], 'inertia': 0.1, "
            "'velocity': [%.17g, %.17g], 'omega': %.17g, 'shapes': [{'polygon': [[0, 0], [0.8, 0], [0.8, %.17g]]}]}], 'joints': [{'name': 'A', 'kind': 'n', 'links': ['ground', 'a']}, {'name': 'B', 'kind': 'n',"
            "'links': ['ground', 'b']}], 'contacts': [{'links': ['ground', 'a']}, {'links': ['ground', 'b']}, {'links': ['a', 'b']}], 'gravity': [0, -9.81]}",
            -0.3 - back, -0.1*turn, 0.3*turn, turn, 0.8*slope);
        drun_read_format(&d, text, 0, 0);
        for (int f = 0; f < 3; f++) {                    /* captured, corners on the floor are on its plane to a part of a step only */
            CHECK_INT(drun_to(&d, f ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, f == 1 ? 1e-6 : 1e-10, 0.2, 1), LW_OK);
            CHECK_NEAR((d.v[0] + 3*d.v[3])*d.system.unit, 2 - 0.3*turn, 1e-9, 0);
            CHECK(d.v[3]*d.system.unit > -0.1*turn + 0.1);
        }
    }
}

/* A pinned bar strikes the floor at (x, -h) from its pin.  Its tip slips forward until the bar stands, then back, with friction against the slip:
 * the bar comes back with  e (x - mu h)/(x + mu h)  of its speed. */
TEST(pinned_bar_strikes)
{
    lw_rng rng = check_rng(31);
    for (int k = 0; k < 40; k++) {
        double x = lw_rng_range(&rng, 0.3, 1), h = lw_rng_range(&rng, 0.1, 1), mu = lw_rng_range(&rng, 0, 0.9*x/h), e = lw_rng_range(&rng, 0.2, 1);
        double a = -atan2(h, x) + 0.05, l = hypot(x, h), w = -lw_rng_range(&rng, 0.5, 5);
        char text[1500];
        snprintf(text, sizeof text, "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [{'line': [[0, %.17g], [1, %.17g]]}]}, {'name': 'bar', 'mass': 1, 'centre':"
                 "[0.1, 0], 'inertia': 0.1, 'shapes': [{'segment': [[0, 0], [%.17g, %.17g]]}]}], 'joints': [{'name': 'A', 'links': ['ground', 'bar'], 'at': [0, 0]}],"
                 "'contacts': [{'links': ['ground', 'bar'], 'friction': %.17g, 'restitution': %.17g}], 'input': {'joint': 'A', 'speed': %.17g}}", -h, -h, l*cos(a),
                 l*sin(a), mu, e, w);
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, k%2 ? 1e-10 : 1e-8, 0.06/-w, 1), LW_OK);
        CHECK_NEAR(d.v[2], -w*e*(x - mu*h)/(x + mu*h), 0, 1e-7);
    }
}

/* Two triangles and a box come to rest together in a bin.  A corner strikes the floor just after another event whose function is only rounding:
 * the step once ended behind the impact. */
TEST(impact_after_an_event_of_rounding)
{
    drun_read_text(&d,
        "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'polygon': [[-2, -1], [2, -1], [2, 3], [1.2, 3], [1.2, 0], "
        "[-1.2, 0], [-1.2, 3], [-2, 3]]}]}, {'name': 'b0', 'mass': 1, 'centre': [-0.88273, 0.5], 'inertia': 0.01, 'shapes': [{'polygon': [[-0.94566, "
        "0.39911], [-0.76386, 0.49661], [-0.91795, 0.61358]]}], 'velocity': [-0.55181, -0.03376], 'omega': -0.7185}, {'name': 'b1', 'mass': 1, "
        "'centre': [-0.6628, 0.95], 'inertia': 0.01, 'shapes': [{'polygon': [[-0.56651, 1.0321], [-0.78228, 0.99167], [-0.6636, 0.82346]]}], "
        "'velocity': [-0.17794, 0.44868], 'omega': 0.37191}, {'name': 'b2', 'mass': 1, 'centre': [-0.14981, 1.4], 'inertia': 0.01, 'shapes': "
        "[{'polygon': [[-0.07778, 1.32255], [-0.0608, 1.45713], [-0.22184, 1.47745], [-0.23882, 1.34287]]}], 'velocity': [0.81412, -0.84536], "
        "'omega': -1.21533}], 'joints': [{'name': 'Fb0', 'kind': 'n', 'links': ['ground', 'b0']}, {'name': 'Fb1', 'kind': 'n', 'links': ['ground', "
        "'b1']}, {'name': 'Fb2', 'kind': 'n', 'links': ['ground', 'b2']}], 'contacts': [{'links': ['ground', 'b0'], 'friction': 0.31243}, {'links': "
        "['ground', 'b1'], 'friction': 0.31243}, {'links': ['b0', 'b1'], 'friction': 0.31243}, {'links': ['ground', 'b2'], 'friction': 0.31243}, "
        "{'links': ['b0', 'b2'], 'friction': 0.31243}, {'links': ['b1', 'b2'], 'friction': 0.31243}]}");
    CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-6, 0.7, 1), LW_OK);
    CHECK_NEAR(d.report.t, 0.7, 0, 0);
}

/* Two triangles slide down both sides of a valley and meet tip to tip.  They stay on their sides, or the run ends with the reason. */
TEST(tips_meet_in_a_valley)
{
    static const double slope[3][2] = { { 0.3, 0.1 }, { 0.3, 0.2 }, { 0.5, 0.2 } };
    for (int k = 0; k < 6; k++) {
        double c = cos(slope[k/2][0]), s = sin(slope[k/2][0]), corner[3][2] = { { 0.1, 0 }, { 0.3, 0 }, { 0.1 + slope[k/2][1], 0.15 } };
        char text[2500];
        int n = snprintf(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'polygon': [[%.17g, %.17g], [0, 0], [%.17g, %.17g],"
                         "[%.17g, -1], [%.17g, -1]]}]}", -3*c, 3*s, 3*c, 3*s, 3*c, -3*c);
        for (int side = -1; side <= 1; side += 2) {
            double x[3], y[3], far = side < 0 ? 1e-4 : 0;
            for (int i = 0; i < 3; i++) {
                x[i] = side*((corner[i][0] + far)*c - corner[i][1]*s);
                y[i] = (corner[i][0] + far)*s + corner[i][1]*c + 2e-6;
            }
            n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': '%c', 'mass': 1, 'centre': [%.17g, %.17g], 'inertia': 0.004, 'shapes': [{'polygon': [[%.6f, %.6f],"
                          "[%.6f, %.6f], [%.6f, %.6f]]}]}", side < 0 ? 'a' : 'b', (x[0] + x[1] + x[2])/3, (y[0] + y[1] + y[2])/3, x[0], y[0], x[1], y[1], x[2], y[2]);
        }
        snprintf(text + n, sizeof text - (size_t)n, "], 'joints': [{'name': 'F0', 'kind': 'n', 'links': ['ground', 'a']}, {'name': 'F1', 'kind': 'n', 'links': ['ground', 'b']}],"
                 "'contacts': [{'links': ['ground', 'a']}, {'links': ['ground', 'b']}, {'links': ['a', 'b']}]}");
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, k%2 ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, 1e-8, 0.6, 6), LW_OK);
        CHECK(state(d.q, 3) - state(d.q, 0) > 0.15);
    }
}

/* How deep the corners of a polygon are below two slopes that rise from the origin to `left` and `right`. */
static double below_valley(const lw_vec2 *drawn, int n, lw_vec2 centre, int body, lw_vec2 left, lw_vec2 right)
{
    double deepest = 0, turn = d.q[3*body + 2];
    lw_vec2 dir = lw_v2(cos(turn), sin(turn)), at = lw_v2(state(d.q, 3*body), state(d.q, 3*body + 1));
    for (int i = 0; i < n; i++) {
        lw_vec2 corner = lw_v2_add(at, lw_v2_turn(lw_v2_sub(drawn[i], centre), dir));
        deepest = fmax(deepest, lw_v2_cross(left, corner)/lw_v2_norm(left));
        deepest = fmax(deepest, lw_v2_cross(corner, right)/lw_v2_norm(right));
    }
    return deepest;
}

/* Two bodies slide down the slopes of a valley and push each other at its bottom: one under the other, tip against tip, tip into the notch. */
TEST(bodies_push_each_other_in_a_valley)
{
    static const struct { lw_vec2 left, right; double mass[2], inertia[2]; lw_vec2 centre[2], corner[2][4]; int n[2]; } pair[3] = {
        { { -2.673, 1.362 }, { 2.579, 1.532 }, { 0.803, 1.523 }, { 0.01, 0.015 }, { { -0.269, 0.172 }, { 0.121, 0.162 } },
          { { { -0.145, 0.076 }, { -0.387, 0.199 }, { -0.276, 0.241 } }, { { 0.073, 0.046 }, { 0.252, 0.152 }, { 0.038, 0.29 } } }, { 3, 3 } },
        { { -2.185, 2.056 }, { 2.155, 2.087 }, { 0.338, 1.464 }, { 0.013, 0.016 }, { { -0.051, 0.108 }, { 0.157, 0.326 } },
          { { { -0.04, 0.039 }, { -0.157, 0.15 }, { 0.042, 0.135 } }, { { 0.198, 0.194 }, { 0.285, 0.278 }, { 0.114, 0.455 }, { 0.033, 0.377 } } }, { 3, 4 } },
        { { -2.736, 1.23 }, { 2.153, 2.089 }, { 1.204, 1.338 }, { 0.007, 0.006 }, { { -0.176, 0.12 }, { 0.139, 0.161 } },
          { { { -0.058, 0.028 }, { -0.302, 0.138 }, { -0.168, 0.194 } }, { { 0.096, 0.095 }, { 0.244, 0.239 }, { 0.077, 0.149 } } }, { 3, 3 } } };
    for (int k = 0; k < 6; k++) {
        lw_vec2 left = pair[k/2].left, right = pair[k/2].right;
        char text[2500];
        int n = snprintf(text, sizeof text, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'polygon': [[%.9g, %.9g], [0, 0], [%.9g, %.9g],"
                         "[%.9g, -1], [%.9g, -1]]}]}", left.x, left.y, right.x, right.y, right.x, left.x);
        for (int i = 0; i < 2; i++) {
            n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': '%c', 'mass': %.9g, 'centre': [%.9g, %.9g], 'inertia': %.9g, 'shapes': [{'polygon': [", 'a' + i,
                          pair[k/2].mass[i], pair[k/2].centre[i].x, pair[k/2].centre[i].y, pair[k/2].inertia[i]);
            for (int j = 0; j < pair[k/2].n[i]; j++)
                n += snprintf(text + n, sizeof text - (size_t)n, "%s[%.9g, %.9g]", j ? ", " : "", pair[k/2].corner[i][j].x, pair[k/2].corner[i][j].y);
            n += snprintf(text + n, sizeof text - (size_t)n, "]}]}");
        }
        snprintf(text + n, sizeof text - (size_t)n, "], 'joints': [{'name': 'F0', 'kind': 'n', 'links': ['ground', 'a']}, {'name': 'F1', 'kind': 'n', 'links': ['ground', 'b']}],"
                 "'contacts': [{'links': ['ground', 'a']}, {'links': ['ground', 'b']}, {'links': ['a', 'b']}]}");
        drun_read_text(&d, text);
        CHECK_INT(drun_to(&d, k%2 ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, 1e-8, 0.6, 6), LW_OK);
        for (int i = 0; i < 2; i++)
            CHECK_NEAR(below_valley(pair[k/2].corner[i], pair[k/2].n[i], pair[k/2].centre[i], i, left, right), 0, 1e-6, 0);
    }
}

/* A heavy disc slides over a round hill and leaves it where nothing presses it on, also while a box stands beside it, whose two corners
 * share the friction in many ways. */
TEST(leaves_a_hill)
{
    static const char format[] = "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'circle': [0, 0], 'radius': 1},"
        "{'polygon': [[3, -1], [4, -1], [4, 0], [3, 0]]}]}, {'name': 'disc', 'mass': 1, 'centre': [0, 1.1], 'inertia': 5, 'velocity': [%.17g, 0], 'shapes':"
        "[{'circle': [0, 1.1], 'radius': 0.1}]}, {'name': 'box', 'mass': 1, 'centre': [3.5, 0.1], 'inertia': 0.01, 'shapes': [{'polygon': [[3.35, 0], [3.65, 0],"
        "[3.65, 0.2], [3.35, 0.2]]}]}], 'joints': [{'name': 'F0', 'kind': 'n', 'links': ['ground', 'disc']}, {'name': 'F1', 'kind': 'n', 'links': ['ground',"
        "'box']}], 'contacts': [{'links': ['ground', 'disc'], 'friction': 0.3}, {'name': 'floor', 'links': ['ground', 'box'], 'friction': %.17g}]}";
    for (int k = 0; k < 3; k++) {
        double left[2] = { 0, 1 };
        for (int sticks = 0; sticks < 2; sticks++) {
            drun_read_format(&d, format, 1.7 + 0.3*k, 0.5*sticks);
            CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-6, 1, 20), LW_OK);
            for (int i = d.report.n_event - 1; i >= 0; i--)
                left[sticks] = d.report.event[i].impact ? left[sticks] : d.report.event[i].t;
        }
        CHECK_NEAR(left[1], left[0], 1e-6, 0);
    }
}

/* Captured, a place that could slip from t on does so in the first step with its middle behind t. */
static void check_lets_go(double t)
{
    double late = d.report.jammed_t + 0.5*d.report.captured_step - t;
    CHECK(late >= 0 && late <= d.report.captured_step);
}

/* A box is pushed into the corner of a floor and a wall, and lifted beside the wall by 20 t.  It stays while friction can hold it in some way,
 * until the floor carries 6.81 N and pushes by 0.7 of that towards the wall; but it can slip up the wall from 1.524 s on, when the floor pushes the other way.
 * That is said; a box that is pulled away from the wall slips at one time.  Captured, it slips as soon as it can. */
TEST(wedged_box_could_slip_earlier)
{
    static const char format[] = "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'polygon': [[-2, -2], [2, -2], [2, 0], [0, 0], [0, 2],"
        "[-2, 2]]}]}, {'name': 'box', 'mass': 2, 'centre': [0.25, 0.05], 'inertia': 0.05, 'shapes': [{'polygon': [[0, 0], [0.5, 0], [0.5, 0.1], [0, 0.1]]}]}], 'joints':"
        "[{'name': 'F', 'kind': 'n', 'links': ['ground', 'box']}], 'contacts': [{'name': 'c', 'links': ['ground', 'box'], 'friction': 0.7}], 'forces': [{'link': 'box',"
        "'at': [0.25, 0.05], 'fx': '%g'}, {'link': 'box', 'at': [0, 0.05], 'fy': '%g*t'}]}";
    const double floor = 19.62 - 2*(4.905 + 1.5), wall = 0.7*(30 + 0.7*floor);
    for (int pulled = 0; pulled < 2; pulled++) {
        drun_read_format(&d, format, pulled ? 10 : -30, 20);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-8, pulled ? 0.4 : 1.9, 2), LW_OK);
        CHECK_INT(d.report.jammed != NULL, !pulled);
        if (!pulled)
            CHECK_NEAR(d.report.jammed_t, (19.62 - floor + wall)/20, 1e-8, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_CAPTURE, 1e-8, pulled ? 0.4 : 1.7, 2), LW_OK);
        CHECK_INT(d.report.jammed != NULL, !pulled);
        if (!pulled)
            check_lets_go((19.62 - floor + 0.7*(30 - 0.7*floor))/20);
    }
}

/* A box between two walls without clearance is pushed against one of them by 40 - 20 t.  From 1.019 s on that does not hold it, but a squeeze of any size
 * could: index1 goes on holding it, capture lets it go, and both say so. */
TEST(squeezed_box_could_slip)
{
    static const double slips = (40 - 2*9.81)/20, to[] = { 0.9*slips, 1.9 };
    drun_read_format(&d, "{'linkwright': 1, 'gravity': [0, -9.81], 'links': [{'name': 'ground', 'shapes': [{'polygon': [[-1, -1], [0, -1], [0, 1],"
        "[-1, 1]]}, {'polygon': [[0.3, -1], [1, -1], [1, 1], [0.3, 1]]}]}, {'name': 'box', 'mass': 1, 'centre': [0.15, 0.1], 'inertia': 0.01, 'shapes':"
        "[{'polygon': [[0, 0], [0.3, 0], [0.3, 0.2], [0, 0.2]]}]}], 'joints': [{'name': 'F', 'kind': 'n', 'links': ['ground', 'box']}], 'contacts':"
        "[{'name': 'c', 'links': ['ground', 'box'], 'friction': 0.5}], 'forces': [{'link': 'box', 'at': [0.15, 0.1], 'fx': '%g - %g*t'}],"
        "'tracers': [{'name': 'P', 'link': 'box', 'at': [0.15, 0.1]}]}", 40, 20);
    for (int k = 0; k < 2; k++) {
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, 1e-8, to[k], 2), LW_OK);
        CHECK_NEAR(d.tracer[d.n_moment - 1].y, 0.1, 1e-9, 0);
        CHECK_INT(d.report.jammed != NULL, k);
        CHECK(!k || d.report.jammed_t == to[k]);
        CHECK_INT(drun_to(&d, LW_FORMULATION_CAPTURE, 1e-8, to[k], 2), LW_OK);
        CHECK_INT(d.report.jammed != NULL, k);
    }
    CHECK(d.tracer[d.n_moment - 1].y < -0.9);
    check_lets_go(slips);
}

/* The pin of a driver turns a Geneva wheel of four slots by a right angle: halfway it has turned by half of that, but for the clearance of 0.4 mm. */
TEST(geneva_wheel)
{
    double c = 0.1, r = c*sqrt(0.5), pin = 0.006, half = 0.0064, deep = c - r - 1.5*pin, a = 130*LW_PI/180;
    char text[3000];
    int n = snprintf(text, sizeof text, "{'linkwright': 1, 'links': ['ground', {'name': 'driver', 'mass': 1, 'centre': [0.1, 0], 'inertia': 0.01, 'shapes':"
                     "[{'circle': [%.9g, %.9g], 'radius': 0.006}]}, {'name': 'wheel', 'mass': 1, 'centre': [0, 0], 'inertia': 0.002, 'shapes': [{'polygon': [",
                     c + r*cos(a), r*sin(a));
    for (int k = 0; k < 16; k++) {
        double x = k%4 == 0 || k%4 == 3 ? r : deep, y = k%4 < 2 ? -half : half, turn = LW_PI*(k/4 + 0.5)/2;
        n += snprintf(text + n, sizeof text - (size_t)n, "%s[%.9g, %.9g]", k ? ", " : "", x*cos(turn) - y*sin(turn), x*sin(turn) + y*cos(turn));
    }
    snprintf(text + n, sizeof text - (size_t)n, "]}]}], 'joints': [{'name': 'D', 'links': ['ground', 'driver'], 'at': [0.1, 0]}, {'name': 'W', 'links':"
             "['ground', 'wheel'], 'at': [0, 0]}], 'contacts': [{'links': ['driver', 'wheel'], 'friction': 0.05}], 'dampers': [{'joint': 'W', 'damping':"
             "0.02}], 'input': {'joint': 'D', 'motion': 't'}}");
    drun_read_text(&d, text);
    for (int f = 0; f < 2; f++) {
        CHECK_INT(drun_to(&d, f ? LW_FORMULATION_CAPTURE : LW_FORMULATION_INDEX1, 1e-8, LW_PI - a, 5), LW_OK);
        CHECK_NEAR(d.q[5], asin(0.0004/(c - r)) - LW_PI/4, f ? 1e-4 : 1e-6, 0);
        CHECK_INT(drun_to(&d, d.o.formulation, 1e-8, 2, 5), LW_OK);
        CHECK_NEAR(d.q[5], -LW_PI/2, 0.1, 0);
    }
}

/* Boxes of one width that stand exactly on each other stay so: a corner that meets a corner is held by the face below, not by the sides. */
TEST(boxes_of_one_width_stand)
{
    /* of these the top box tipped over by itself: mass, centre, inertia, top */
    static const double drawn[3][4] = { { 1.0180520610967643, 0.08673771437725905, 0.01612710899235095, 0.1734754287545181 },
        { 0.19495502937940853, 0.2932870122166345, 0.003532248219631615, 0.4130985956787509 },
        { 0.6466060771591745, 0.5306359191802095, 0.011599040178856481, 0.6481732426816682 } };
    lw_rng rng = check_rng(7);
    for (int k = 0; k < 12; k++) {
        char text[3000];
        double y = 0, friction = k ? lw_rng_range(&rng, 0.1, 1) : 0.3;
        int n = snprintf(text, sizeof text, "{'linkwright': 1, 'links': [{'name': 'ground', 'shapes': [{'line': [[0, 0], [1, 0]]}]}");
        for (int b = 0; b < 3; b++) {
            double top = k ? y + lw_rng_range(&rng, 0.1, 0.3) : drawn[b][3], mass = k ? lw_rng_range(&rng, 0.1, 2) : drawn[b][0];
            double centre = k ? (y + top)/2 : drawn[b][1], inertia = k ? mass*(0.16 + (top - y)*(top - y))/12 : drawn[b][2];
            n += snprintf(text + n, sizeof text - (size_t)n, ", {'name': 'b%d', 'mass': %.17g, 'centre': [0, %.17g], 'inertia': %.17g, 'shapes': ["
                "{'polygon': [[-0.2, %.17g], [0.2, %.17g], [0.2, %.17g], [-0.2, %.17g]]}]}", b, mass, centre, inertia, y, y, top, top);
            y = top;
        }
        snprintf(text + n, sizeof text - (size_t)n, "], 'joints': [{'name': 'F0', 'kind': 'n', 'links': ['ground', 'b0']}, {'name': 'F1', 'kind': 'n',"
            "'links': ['ground', 'b1']}, {'name': 'F2', 'kind': 'n', 'links': ['ground', 'b2']}], 'contacts': [{'links': ['ground', 'b0'], 'friction':"
            "%.17g}, {'links': ['b0', 'b1'], 'friction': %.17g}, {'links': ['b1', 'b2'], 'friction': %.17g}], 'gravity': [0, -9.81]}", friction,
            friction, friction);
        drun_read_format(&d, text, 0, 0);
        CHECK_INT(drun_to(&d, LW_FORMULATION_INDEX1, k%2 ? 1e-9 : 1e-6, 1, 4), LW_OK);
        for (int i = 0; i < 9; i++)
            CHECK_NEAR(d.v[i], 0, 1e-9, 0);
        CHECK_INT(d.n_moment, 5);
    }
}
