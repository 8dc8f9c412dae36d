/* test_instant.c - instant centres by Kennedy's theorem and by the lines of links; points of the inflection circle pass an
 * inflection of their path. */
#include <string.h>

#include "base/vec2.h"
#include "linkwright.h"
#include "tests/check.h"

static double draw(lw_rng *rng, double from, double to) { return lw_rng_range(rng, from, to); }

/* A four-bar A0 A B B0 with a tracer P on the coupler, or a slider-crank where `slides`. */
static lw_kinematics *make(lw_rng *rng, bool slides, lw_vec2 tracer, lw_vec2 place[4])
{
    lw_vec2 a0 = { 0, 0 }, a = { draw(rng, 0.2, 0.6), draw(rng, 0.3, 0.7) }, b = { draw(rng, 2, 3), draw(rng, 1.5, 2.5) },
            b0 = { draw(rng, 2, 3), draw(rng, -0.3, 0.3) };
    lw_joint_info joint[4] = {
        { NULL, 'r', { 0, 1 }, a0, { 0, 0 }, 0 }, { NULL, 'r', { 1, 2 }, a, { 0, 0 }, 0 },
        { NULL, 'r', { 2, 3 }, b, { 0, 0 }, 0 },
        { NULL, slides ? 't' : 'r', { 0, 3 }, slides ? b : b0, slides ? lw_v2(1, 0) : lw_v2(0, 0), 0 } };
    lw_input_info input = { 0, NAN, 0, 0, 0 };
    lw_tracer_info p = { NULL, 2, tracer, 0 };
    lw_linkage *k;
    lw_kinematics *m = NULL;
    memcpy(place, (lw_vec2[]){ a0, a, b, b0 }, 4*sizeof *place);
    CHECK(lw_linkage_create(4, 0, 4, joint, 1, &input, 1, &p, &k, &check_error) == LW_OK);
    CHECK(lw_kinematics_create(k, &m, &check_error) == LW_OK);
    lw_linkage_destroy(k);
    return m;
}

static lw_vec2 crossing(lw_vec2 p, lw_vec2 u, lw_vec2 q, lw_vec2 v)
{
    return lw_v2_add(p, lw_v2_scale(u, lw_v2_cross(lw_v2_sub(q, p), v)/lw_v2_cross(u, v)));
}

static void near(lw_vec2 got, lw_vec2 want)
{
    double far = 1 + lw_v2_norm(want);
    CHECK_POINT(got, want.x, want.y, 1e-9*far*far, 0);
}

TEST(centres_of_fourbars)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 200; trial++) {
        lw_vec2 p[4];
        lw_kinematics *m = make(&rng, false, lw_v2(1, 1), p);
        double input = lw_kinematics_input(m);
        lw_instant_motion at;
        CHECK(lw_kinematics_instant(m, input, 2, 0, &at) == LW_OK);      /* coupler: cranks' lines meet */
        near(at.centre, crossing(p[0], lw_v2_sub(p[1], p[0]), p[3], lw_v2_sub(p[2], p[3])));
        CHECK(lw_kinematics_instant(m, input, 3, 1, &at) == LW_OK);      /* cranks: coupler and frame meet */
        near(at.centre, crossing(p[0], lw_v2_sub(p[3], p[0]), p[1], lw_v2_sub(p[2], p[1])));
        CHECK(lw_kinematics_instant(m, input, 1, 2, &at) == LW_OK);      /* neighbours: their pin */
        near(at.centre, p[1]);
        CHECK(lw_kinematics_instant(m, input, 2, 2, &at) == LW_E_ARG);
        lw_kinematics_destroy(m);
    }
}

TEST(centres_of_slider_cranks)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 100; trial++) {
        lw_vec2 p[4];
        lw_kinematics *m = make(&rng, true, lw_v2(1, 1), p);
        lw_instant_motion at;
        CHECK(lw_kinematics_instant(m, lw_kinematics_input(m), 2, 0, &at) == LW_OK);
        near(at.centre, crossing(p[0], lw_v2_sub(p[1], p[0]), p[2], lw_v2(0, 1)));
        CHECK(lw_kinematics_instant(m, lw_kinematics_input(m), 3, 0, &at) == LW_OK);     /* it only shifts */
        CHECK(isnan(at.centre.x) && at.turn == 0);
        lw_kinematics_destroy(m);
    }
}

/* A point of the coupler on the circle is traced: velocity and acceleration are parallel there, and nowhere else. */
TEST(points_of_the_inflection_circle)
{
    for (int trial = 0; trial < 200; trial++) {
        lw_rng rng = check_rng((uint64_t)(100 + trial));
        lw_rng again = rng;
        lw_vec2 p[4], tracer[3];
        bool slides = trial % 2;
        lw_kinematics *m = make(&rng, slides, lw_v2(1, 1), p);
        lw_instant_motion at;
        CHECK(lw_kinematics_instant(m, lw_kinematics_input(m), 2, 0, &at) == LW_OK);
        lw_kinematics_destroy(m);
        if (lw_v2_norm(lw_v2_sub(at.centre, at.inflection)) > 1e6)      /* almost a line: nothing is well off it */
            continue;
        lw_vec2 middle = lw_v2_scale(lw_v2_add(at.centre, at.inflection), 0.5);
        lw_vec2 on = lw_v2_add(middle, lw_v2_turn(lw_v2_sub(at.centre, middle), lw_v2_polar(1, draw(&rng, 0.5, 5.5))));
        for (int off = 0; off < 2; off++) {
            lw_rng same = again;
            m = make(&same, slides, off ? lw_v2_add(on, lw_v2_scale(lw_v2_sub(on, middle), 0.3)) : on, p);
            CHECK(lw_kinematics_posture(m, lw_kinematics_input(m), 2, NULL, NULL, tracer, NULL) == LW_OK);
            double bend = lw_v2_cross(tracer[1], tracer[2])/(lw_v2_norm(tracer[1])*lw_v2_norm(tracer[2]));
            CHECK(off ? fabs(bend) > 1e-6 : fabs(bend) < 1e-6);
            lw_kinematics_destroy(m);
        }
    }
}

/* The limacon r = 1 + 2 cos t passes the origin at t = 120 and 240 degrees; a figure of eight its middle; a circle nothing. */
TEST(double_points_of_known_curves)
{
    enum { N = 361 };
    static const double pi = 3.14159265358979323846;
    double x[N], y[N];
    lw_double_point d[8];
    for (int i = 0; i < N; i++) {
        double t = (i + 17)*2*pi/360, r = 1 + 2*cos(t);
        x[i] = r*cos(t) + 5;
        y[i] = r*sin(t) - 3;
    }
    CHECK_INT(lw_path_double_points(N, x, y, d, 8), 1);
    CHECK_POINT(d[0].at, 5, -3, 1e-7, 0);
    CHECK_NEAR(d[0].first, 103, 1e-5, 0);
    CHECK_NEAR(d[0].second, 223, 1e-5, 0);
    for (int i = 0; i < N; i++) {
        x[i] = sin((i + 0.3)*2*pi/360);
        y[i] = sin((i + 0.3)*4*pi/360);
    }
    CHECK_INT(lw_path_double_points(N, x, y, d, 8), 1);
    CHECK_NEAR(hypot(d[0].at.x, d[0].at.y), 0, 1e-7, 0);
    CHECK_NEAR(d[0].second - d[0].first, 180, 1e-5, 0);
    x[90] = NAN;                                                /* a gap elsewhere changes nothing */
    CHECK_INT(lw_path_double_points(N, x, y, d, 8), 1);
    for (int i = 0; i < N; i++) {
        x[i] = cos(i*2*pi/360);
        y[i] = sin(i*2*pi/360);
    }
    CHECK_INT(lw_path_double_points(N, x, y, d, 8), 0);
    for (int i = 0; i < N; i++) {                               /* a flower with three petals through one place */
        double t = (i + 0.4)*2*pi/360, r = 1 + 3*cos(3*t);
        x[i] = r*cos(t);
        y[i] = r*sin(t);
    }
    CHECK(lw_path_double_points(N, x, y, d, 8) >= 3);
    CHECK_INT(lw_path_double_points(N, x, y, d, 1), 1);
    CHECK_INT(lw_path_double_points(1, x, y, d, 8), 0);
    CHECK_INT(lw_path_double_points(0, x, y, d, 8), 0);
}
