/* tests/test_motion_curve.c - curves of postures against closed forms, against the second opinion, and closing. */
#include <float.h>
#include "tests/kept_system.h"
#include "tests/large_models.h"
#include "mbs/kinematics/fourbar.h"
#include "mbs/constraints/newton.h"
#include "tests/mbs_linkage.h"
#include "tests/motion_curve.h"

static lw_fourbar_class draw_fourbar(lw_rng *r, double k[9])
{
    lw_fourbar_class c;
    do {
        for (int i = 0; i < 4; i++)
            k[i] = lw_rng_range(r, 0.2, 1.0);
    } while (lw_fourbar_classify(k, LW_FOURBAR_TOLERANCE, &c, NULL) != LW_OK);
    for (int i = 4; i < 8; i++)
        k[i] = lw_rng_range(r, -1.0, 1.0);
    k[8] = 0;
    return c;
}

/* Every four-bar's curve closes.  With a crank: one turn in one mode.  Without: over both modes between its limits,
 * which are those of the class to 1e-10. */
TEST(four_bars_of_all_classes)
{
    lw_rng r = check_rng(1);
    for (int trial = 0; trial < 400; trial++) {
        double k[9], q[9], mode = trial%2 ? 1 : -1;
        lw_fourbar_class c = draw_fourbar(&r, k);
        int range = trial/2%c.n_range;
        double first = c.range[range][0], last = c.range[range][1];
        double start = first + (last - first)*lw_rng_range(&r, 0.01, 0.99);
        lw_linkage l;
        fourbar_linkage(&l, k, mode, start);
        OWNED(curve) *v = follow(&l, 0);
        int n;
        const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
        CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
        CHECK_INT(abs(lw_motion_curve_turns(v->b, -1)), c.crank);
        CHECK_INT(count(v, LW_EVENT_CROSSING), 0);
        CHECK_INT(count(v, LW_EVENT_LIMIT), c.crank ? 0 : 2);
        for (int i = 0; i < n; i++)
            if (e[i].kind == LW_EVENT_LIMIT) {
                double off = fmin(fabs(remainder(e[i].input - first, 2*LW_PI)), fabs(remainder(e[i].input - last, 2*LW_PI)));
                CHECK_NEAR(off, 0, 1e-10, 0);
            } else if (c.n_dead) {                          /* the output turns back: crank and coupler in line */
                double off = 9;
                for (int d = 0; d < c.n_dead; d++)
                    off = fmin(off, fabs(remainder(e[i].input - c.dead[d], 2*LW_PI)));
                CHECK_NEAR(off, 0, 1e-10, 0);
            }
        for (int i = 0; i < 50; i++) {
            double station = lw_rng_range(&r, 0, lw_motion_curve_segments(v->b));
            lw_motion_curve_posture(v->b, station, q, NULL);
            CHECK(residual(v, q) <= 3e-15);
            double angle = lw_motion_curve_input(v->b, q);
            fourbar_joints p = fourbar_at(k, 1, angle), m = fourbar_at(k, -1, angle);
            double off = fmin(distance(tracer(v, 0, q), p.p), distance(tracer(v, 0, q), m.p));
            CHECK(off <= 1e-12 || off <= 1e-7*sqrt(fmin(fabs(angle - first), fabs(angle - last))) || off < 2e-8);
        }
    }
}

/* Arc to station and back; even arcs; the same posture at both ends. */
TEST(arcs_and_stations_agree)
{
    double k[9] = { 4, 3, 2, 2.5, 1, 2, 0, 0, 0 }, q[9], p[9];
    lw_linkage l;
    fourbar_linkage(&l, k, 1, 0.5);
    OWNED(curve) *v = follow(&l, 0);
    double length = lw_motion_curve_length(v->b), sum = 0;
    lw_motion_curve_posture(v->b, 0, p, NULL);
    for (int i = 0; i <= 400; i++) {
        double s = lw_motion_curve_station(v->b, length*i/400);
        CHECK_NEAR(lw_motion_curve_arc(v->b, s), length*i/400, 1e-13, 0);
        lw_motion_curve_posture(v->b, s, q, NULL);
        double step = 0;
        for (int j = 0; j < 9; j++) {
            step += (q[j] - p[j])*(q[j] - p[j]);
            p[j] = q[j];
        }
        sum += sqrt(step);
        if (i > 0)
            CHECK_NEAR(sqrt(step), length/400, 0, 2e-3);
    }
    CHECK_NEAR(sum, length, 0, 2e-4);
    lw_motion_curve_posture(v->b, 0, q, NULL);
    lw_motion_curve_posture(v->b, lw_motion_curve_segments(v->b), p, NULL);
    for (int j = 0; j < 9; j++)
        CHECK_NEAR(remainder(q[j] - p[j], j%3 == 2 ? 2*LW_PI : 100), 0, 1e-14, 0);
}

/* 1e-3 .. 1e-10 from the parallelogram's change points, where branches pass 1e-5 apart: never the wrong one. */
TEST(near_change_points)
{
    for (double eps = 1e-3; eps > 5e-11; eps *= 0.1) {
        double k[9] = { 4, 1, 4*(1 + eps), 1, 1, 2, 0, 0, 0 };
        lw_fourbar_class c;
        lw_linkage l;
        lw_fourbar_classify(k, 0, &c, NULL);
        fourbar_linkage(&l, k, 1, 0.5);
        OWNED(curve) *v = follow(&l, 0);
        int n;
        const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
        CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
        CHECK_INT(count(v, LW_EVENT_CROSSING), 0);
        CHECK_INT(count(v, LW_EVENT_LIMIT), 2);
        for (int i = 0; i < n; i++)
            if (e[i].kind == LW_EVENT_LIMIT) {
                double off = 9;
                for (int d = 0; d < c.n_limit; d++)
                    off = fmin(off, fabs(remainder(e[i].input - c.limit[d], 2*LW_PI)));
                CHECK_NEAR(off, 0, 1e-10, 0);
            }
    }
}

/* The parallelogram goes straight on through both change points: its coupler never turns. */
TEST(straight_on_through_change_points)
{
    double k[9] = { 4, 1, 4, 1, 1, 2, 0, 0, 0 }, q[9];
    lw_linkage l;
    fourbar_linkage(&l, k, 1, 0.5);
    OWNED(curve) *v = follow(&l, 0);
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
    CHECK_INT(lw_motion_curve_turns(v->b, -1), 1);
    CHECK_INT(count(v, LW_EVENT_CROSSING), 2);
    CHECK_INT(count(v, LW_EVENT_LIMIT), 0);
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
    for (int i = 0; i < n; i++)
        CHECK_NEAR(sin(e[i].input), 0, 1e-10, 0);
    for (int i = 0; i <= 3000; i++) {
        double station = lw_motion_curve_segments(v->b)*i/3000.0;
        if (i%10 == 0)                                      /* close to the change point too */
            station = e[0].station + 1e-3*pow(0.5, i/60.0)*(i%20 ? 1 : -1);
        lw_motion_curve_posture(v->b, station, q, NULL);
        CHECK_NEAR(q[5], 0, 1e-12, 0);
        CHECK(residual(v, q) <= 1e-12);
        fourbar_joints p = fourbar_at(k, 1, 0.5);
        lw_vec2 at = lw_v2_add(lw_v2_sub(p.p, p.a), lw_v2_polar(1, lw_motion_curve_input(v->b, q)));
        CHECK_NEAR(distance(tracer(v, 0, q), at), 0, 4e-12, 0);
    }
}

/* Derivatives do not mind the change point: the parallelogram's rocker turns as its crank. */
TEST(rates_through_change_points)
{
    double k[9] = { 4, 1, 4, 1, 1, 2, 0, 0, 0 }, q[4*9];
    const double motion[4] = { 0, 1, 0, 0 };
    static const double most[4] = { 0, 1e-11, 1e-9, 1e-6 };
    lw_linkage l;
    fourbar_linkage(&l, k, 1, 0.5);
    OWNED(curve) *v = follow(&l, 0);
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
    CHECK_INT(n, 2);
    for (int i = 0; i < 60; i++) {
        double off = i < 2 ? 0 : 0.1*pow(0.6, i)*(i%4 < 2 ? 1 : -1);
        CHECK(lw_motion_curve_motion(v->b, e[i%2].station + off, 3, motion, q));
        for (int order = 1; order <= 3; order++) {
            double *c = q + 9*order;
            CHECK_NEAR(c[2], order == 1, most[order], 0);  /* turns of crank, coupler, rocker */
            CHECK_NEAR(c[5], 0, most[order], 0);
            CHECK_NEAR(c[8], order == 1, most[order], 0);
        }
    }
}

/* Drawn at a change point, one branch is followed, and through the point again. */
TEST(drawn_at_change_points)
{
    for (int i = 0; i < 4; i++) {
        double k[9] = { 4, 1, 4, 1, 1, 2, 0, 0, 0 }, q[9], turn = i/2*LW_PI;
        lw_linkage l;
        fourbar_linkage(&l, k, 1, turn);
        if (i%2) {                                          /* or of equal crank and rod */
            blank_linkage(&l, 4);
            add_joints(&l, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 0, cos(turn)), PIN(2, 3, 0, 0), SLIDE(0, 3, 0, 0, 0)));
            add_input(&l, 0, 0.5*LW_PI + turn);
        }
        OWNED(curve) *v = follow(&l, 0);
        CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
        CHECK_INT(abs(lw_motion_curve_turns(v->b, -1)), 1);
        CHECK_INT(count(v, LW_EVENT_CROSSING), 2);
        CHECK(!lw_motion_curve_rests(v->b));
        for (int j = 0; j <= 100; j++) {
            lw_motion_curve_posture(v->b, lw_motion_curve_segments(v->b)*j/100.0, q, NULL);
            CHECK(residual(v, q) <= 1e-12);
        }
        lw_system_posture(&v->s, q);
        CHECK(lw_motion_curve_holds(v->b, q));
    }
}

/* A bar of no length spins, and the crank it hangs on stands still. */
TEST(the_input_stands_still)
{
    lw_linkage l;
    double q[2*9];
    blank_linkage(&l, 4);
    add_joints(&l, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 0), PIN(2, 3, 1, 0), PIN(3, 0, 2, 1)));
    add_input(&l, 0, 0);
    OWNED(curve) *v = follow(&l, 0);
    CHECK(lw_motion_curve_rests(v->b));
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
    CHECK_INT(abs(lw_motion_curve_turns(v->b, 2)), 1);
    CHECK(!lw_motion_curve_motion(v->b, 0.5, 1, (double[]){ 0, 1 }, q));
}

/* Drawn next to a change point, before or behind it: the last leap ends where the curve began. */
TEST(starts_next_to_change_points)
{
    for (int i = 0; i < 40; i++) {
        double k[9] = { 4, 1, 4, 1, 1, 2, 0, 0, 0 }, q[9];
        double angle = (i%2 ? -1 : 1)*pow(10, -1 - 0.1*i) + (i%4 < 2 ? 0 : LW_PI);
        lw_linkage l;
        fourbar_linkage(&l, k, sin(angle) > 0 ? 1 : -1, angle);
        OWNED(curve) *v = follow(&l, 0);
        CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
        CHECK_INT(lw_motion_curve_turns(v->b, -1), 1);
        CHECK_INT(count(v, LW_EVENT_CROSSING), 2);
        for (int n = 0; n <= 40; n++) {
            lw_motion_curve_posture(v->b, lw_motion_curve_segments(v->b)*n/40.0, q, NULL);
            CHECK_NEAR(q[5], 0, 1e-9, 0);                  /* the posture itself holds the angle to 1e-16/angle */
        }
    }
}

/* Equal crank and rod: the slider goes straight on through the bifurcation, x = 2 cos. */
TEST(equal_slider_crank)
{
    lw_linkage l;
    double q[9];
    blank_linkage(&l, 4);
    add_pin(&l, 0, 1, lw_v2(0, 0));
    add_pin(&l, 1, 2, lw_v2_polar(1, 0.6));
    add_pin(&l, 2, 3, lw_v2(2*cos(0.6), 0));
    add_slide(&l, 0, 3, lw_v2(2*cos(0.6), 0), 0);
    add_input(&l, 0, 0.6);
    add_tracer(&l, 3, lw_v2(2*cos(0.6), 0));
    OWNED(curve) *v = follow(&l, 0);
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
    CHECK_INT(count(v, LW_EVENT_CROSSING), 2);
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
    for (int i = 0; i < n; i++)
        CHECK_NEAR(e[i].kind == LW_EVENT_CROSSING ? cos(e[i].input) : sin(e[i].input), 0, 1e-10, 0);
    for (int i = 0; i <= 1000; i++) {
        lw_motion_curve_posture(v->b, lw_motion_curve_segments(v->b)*i/1000.0, q, NULL);
        CHECK_NEAR(tracer(v, 0, q).x, 2*cos(lw_motion_curve_input(v->b, q)), 1e-12, 0);
    }
}

/* Geared five-bars close when both cranks have turned whole turns: -p/q after q turns of the input. */
TEST(gears_close_after_several_turns)
{
    static const int ratio[][2] = { { 1, 2 }, { 2, 3 }, { 1, 1 }, { 3, 1 }, { 5, 4 } };
    for (int i = 0; i < 5; i++) {
        lw_linkage l;
        double q[12];
        blank_linkage(&l, 5);
        add_joints(&l, JOINTS(PIN(0, 1, 0, 0), PIN(0, 2, 3, 0), PIN(1, 3, 0.5, 0.5), PIN(3, 4, 1.5, 3), PIN(4, 2, 3.5, 0.8),
                              GEAR(1, 2, 2, 0, -1.0*ratio[i][0]/ratio[i][1])));
        add_input(&l, 0, 0);
        OWNED(curve) *v = follow(&l, 0);
        CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
        CHECK_INT(lw_motion_curve_turns(v->b, -1), ratio[i][1]);
        CHECK_INT(lw_motion_curve_turns(v->b, 2), -ratio[i][0]);
        for (int n = 0; n < 50; n++) {
            lw_motion_curve_posture(v->b, lw_motion_curve_segments(v->b)*n/50.0, q, NULL);
            CHECK_NEAR(q[5], -q[2]*ratio[i][0]/ratio[i][1], 1e-14, 0);
            CHECK(residual(v, q) <= 1e-14);
        }
    }
}

/* Random six-bars, one of which has no dyads: where the second opinion can go the curve goes, at the same input
 * in the same posture; it ends its pieces at the same limits. */
TEST(six_bars_agree_with_newton)
{
    static const int pair[4][7][2] = {
        { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,3} }, { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,0} },
        { {0,1},{1,2},{2,3},{3,4},{4,1},{4,5},{5,0} }, { {0,1},{1,2},{1,3},{2,4},{3,5},{4,5},{5,0} },
    };
    lw_rng r = check_rng(2);
    for (int trial = 0; trial < 120; trial++) {
        lw_linkage l;
        double q[15], reached;
        int n;
        blank_linkage(&l, 6);
        for (int j = 0; j < 7; j++)
            add_pin(&l, pair[trial%4][j][0], pair[trial%4][j][1], lw_v2(lw_rng_range(&r, -1, 1), lw_rng_range(&r, -1, 1)));
        add_input(&l, 0, 0);
        add_tracer(&l, 4, lw_v2(lw_rng_range(&r, -1, 1), lw_rng_range(&r, -1, 1)));
        OWNED(curve) *v = follow(&l, 0);
        const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
        CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
        double first = 0, last = lw_motion_curve_segments(v->b);
        for (int i = n - 1; i >= 0; i--)                   /* up to the first limit */
            if (e[i].kind == LW_EVENT_LIMIT)
                last = e[i].station;
        lw_newton *s;
        CHECK_INT(lw_newton_create(&l, &s, NULL), LW_OK);
        lw_motion_curve_posture(v->b, last, q, NULL);
        double end = lw_motion_curve_input(v->b, q);
        bool limit = last < lw_motion_curve_segments(v->b);
        for (int i = 1; i <= 10; i++) {
            double input = end*i/10, at = i < 10 ? lw_motion_curve_find(v->b, first, last, input) : last;
            lw_motion_curve_posture(v->b, at, q, NULL);
            double found = lw_motion_curve_input(v->b, q), rounded = 4*DBL_EPSILON*at, scatter = 0;
            for (int side = -1; side <= 1; side += 2) {                /* a station has so many digits, and a posture its own rounding */
                lw_motion_curve_posture(v->b, fmin(at + side*rounded, lw_motion_curve_segments(v->b)), q, NULL);
                scatter = fmax(scatter, fabs(lw_motion_curve_input(v->b, q) - found));
            }
            lw_motion_curve_posture(v->b, at, q, NULL);
            CHECK_NEAR(found, input, 1e-14 + scatter, 0);
            lw_status status = lw_newton_move(s, i == 10 && limit ? end + 1e-3 : input, &reached);
            CHECK_INT(status, i == 10 && limit ? LW_OPEN : LW_OK);
            CHECK_NEAR(reached, input, 1e-10, 0);
            CHECK_NEAR(distance(tracer(v, 0, q), lw_newton_tracer(s, 0)), 0, i == 10 ? 2e-5 : 1e-10, 0);
            CHECK(residual(v, q) <= 1e-14);
        }
        lw_newton_free(s);
        CHECK(lw_motion_curve_worst(v->b) <= 1e-14);
    }
}

/* A crank that turns one way has one side; a rocker changes sides at each limit. */
TEST(sides_change_at_limits)
{
    double k[9] = { 4, 3, 2, 2.5, 1, 2, 0, 0, 0 };
    lw_linkage l;
    int n, side[2] = { 0, 0 };
    fourbar_linkage(&l, k, 1, 0.5);
    OWNED(curve) *v = follow(&l, 0);
    const lw_motion_curve_event *e = lw_motion_curve_events(v->b, &n);
    for (int i = 0; i < n; i++)
        if (e[i].kind == LW_EVENT_LIMIT) {
            side[0] = lw_motion_curve_side(v->b, e[i].station - 1e-3);
            side[1] = lw_motion_curve_side(v->b, e[i].station + 1e-3);
            CHECK(side[0]*side[1] == -1);
        }
}

/* Offset slider-crank in closed form, by the crank; and in time. */
TEST(rates_by_the_input)
{
    const double rr = 30, ll = 80, ee = 10;
    lw_linkage l;
    double q[4*9];
    lw_vec2 p[4], a = lw_v2_polar(rr, 0.7), pin = { a.x + sqrt(ll*ll - (a.y - ee)*(a.y - ee)), ee };
    blank_linkage(&l, 4);
    add_pin(&l, 0, 1, lw_v2(0, 0));
    add_pin(&l, 1, 2, a);
    add_pin(&l, 2, 3, pin);
    add_slide(&l, 0, 3, pin, 0);
    add_input(&l, 0, 0.7);
    add_tracer(&l, 3, pin);
    OWNED(curve) *v = follow(&l, 0);
    for (int i = 0; i < 40; i++) {
        double at = i/40.0*lw_motion_curve_segments(v->b), speed = i%2 ? -3 : 1, motion[4] = { 0, speed, 0, 0 };
        lw_motion_curve_posture(v->b, at, q, NULL);
        double x = lw_motion_curve_input(v->b, q);
        CHECK(lw_motion_curve_rates(v->b, 3, motion, q));
        lw_system_point_series(&v->s, v->s.tracer_body[0], v->s.tracer_arm[0], 3, q, p);
        double u = rr*sin(x) - ee, u1 = rr*cos(x), u2 = -rr*sin(x), u3 = -rr*cos(x);
        double w = sqrt(ll*ll - u*u), w1 = -u*u1/w, w2 = -(u1*u1 + u*u2 + w1*w1)/w, w3 = -(3*u1*u2 + u*u3 + 3*w1*w2)/w;
        CHECK_NEAR(p[0].x, rr*cos(x) + w, 2e-13, 0);
        CHECK_NEAR(p[1].x, speed*(-rr*sin(x) + w1), 1e-12, 0);
        CHECK_NEAR(2*p[2].x, speed*speed*(-rr*cos(x) + w2), 1e-11, 0);
        CHECK_NEAR(6*p[3].x, speed*speed*speed*(rr*sin(x) + w3), 1e-10, 0);
        CHECK_NEAR(p[0].y, ee, 1e-13, 0);
    }
}

/* Postures of the same curve are on it, those of the other circuit are not. */
TEST(knows_its_postures)
{
    double k[9] = { 4, 1, 3.5, 2.5, 1, 2, 0, 0, 0 }, q[9];
    lw_linkage l, other;
    fourbar_linkage(&l, k, 1, 0.5);
    fourbar_linkage(&other, k, -1, 0.5);
    curve *v = follow(&l, 0), *w = follow(&other, 0);
    for (int i = 0; i < 20; i++) {
        lw_motion_curve_posture(v->b, lw_motion_curve_segments(v->b)*i/20.0, q, NULL);
        q[2] += 2*LW_PI;
        CHECK(lw_motion_curve_holds(v->b, q));
        q[5] += 1e-3;
        CHECK(!lw_motion_curve_holds(v->b, q));
    }
    curve_free(v);
    curve_free(w);
}

/* A rod in two guides: the curve leaves both ways and is kept as an open one. */
TEST(curves_without_end)
{
    lw_linkage l;
    double q[3];
    blank_linkage(&l, 2);
    add_slide(&l, 0, 1, lw_v2(1, 0), 0.3);
    add_input(&l, 0, 5);
    add_tracer(&l, 1, lw_v2(0, 0));
    l.joint[0].at = lw_v2(0, 0);
    add_pin(&l, 0, 1, lw_v2(2, 0));
    l.joint[1].kind = LW_JOINT_SLOT;
    l.joint[1].along = lw_v2_polar(1, 0.3);
    OWNED(curve) *v = follow(&l, 0);
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_FAR);
    double start = lw_motion_curve_start(v->b);
    CHECK(start > 1 && start < lw_motion_curve_segments(v->b) - 1);
    lw_motion_curve_posture(v->b, start, q, NULL);
    CHECK_NEAR(lw_motion_curve_input(v->b, q), 5, 1e-15, 0);
    lw_motion_curve_posture(v->b, 0, q, NULL);
    CHECK(lw_motion_curve_input(v->b, q) < 5 - 20);
    lw_motion_curve_posture(v->b, lw_motion_curve_find(v->b, 0, lw_motion_curve_segments(v->b), -7.25), q, NULL);
    CHECK_NEAR(lw_motion_curve_input(v->b, q), -7.25, 1e-14, 0);
}

/* An elliptic trammel whose point is a hundred times as far from its pins as these from each other: its sliders go as far, and its curve is closed. */
TEST(small_links_with_a_long_arm_are_followed_all_round)
{
    lw_linkage l;
    lw_vec2 b = lw_v2(0.02, 0), c = lw_v2_polar(0.03, 0.05);
    blank_linkage(&l, 4);
    add_slide(&l, 0, 1, b, 0);
    add_pin(&l, 1, 2, b);
    add_pin(&l, 2, 3, c);
    add_slide(&l, 0, 3, c, 0.05);
    add_input(&l, 0, 0);
    add_tracer(&l, 2, lw_v2(1, 0));
    OWNED(curve) *v = follow(&l, 0);
    CHECK_INT(lw_motion_curve_ended(v->b), LW_MOTION_CURVE_CLOSED);
}

TEST(refuses_with_reasons)
{
    lw_linkage l;
    KEPT_SYSTEM s = { 0 };
    lw_motion_curve *b;
    const lw_motion_curve_options o = { .input = 0 };
    blank_linkage(&l, 5);
    for (int i = 0; i < 5; i++)
        add_pin(&l, i, (i + 1)%5, lw_v2_polar(1, 1.2*i));
    CHECK_OK(lw_system_make(&l, NULL, 0, &s, &check_error));
    CHECK_FAILS(lw_motion_curve_create(&s, NULL, &o, &b, &check_error), LW_E_ARG, "no input");
    add_input(&l, 0, 0);
    lw_system_free(&s);
    lw_system_make(&l, NULL, 0, &s, &check_error);
    CHECK_FAILS(lw_motion_curve_create(&s, NULL, &o, &b, &check_error), LW_E_ARG, "2 freedoms but 1 input; drive 1 more joint");
    blank_linkage(&l, 3);
    for (int i = 0; i < 3; i++)
        add_pin(&l, i, (i + 1)%3, lw_v2_polar(1, 2.2*i));
    add_input(&l, 0, 0);
    lw_system_free(&s);
    lw_system_make(&l, NULL, 0, &s, &check_error);
    CHECK_FAILS(lw_motion_curve_create(&s, NULL, &o, &b, &check_error), LW_E_NUMERIC, "cannot move");
    blank_linkage(&l, 6);                                   /* two parallelograms drawn flat */
    for (int i = 0; i < 3; i++)
        add_pin(&l, 0, 1 + i, lw_v2(2*i, 0));
    for (int i = 0; i < 2; i++) {
        add_pin(&l, 1 + i, 4 + i, lw_v2(2*i + 1, 0));
        add_pin(&l, 2 + i, 4 + i, lw_v2(2*i + 3, 0));
    }
    add_input(&l, 0, 0);
    lw_system_free(&s);
    CHECK_OK(lw_system_make(&l, NULL, 0, &s, &check_error));
    CHECK_FAILS(lw_motion_curve_create(&s, NULL, &o, &b, &check_error), LW_E_NUMERIC, "it is a branch point");
    lw_motion_curve_free(NULL);
}

/* A row of 20 parallelograms, beyond a linkage: every crank turns as the first, through both flat postures, where 20 ranks are lost at
 * once.  The arc length is that of one turn in the coordinates of all links. */
TEST(a_row_of_parallelograms_turns_as_one)
{
    enum { N = 20, LOOKS = 60 };
    OWN(lw_model) m = { 0 };
    KEPT_SYSTEM s = { 0 };
    lw_motion_curve *b;
    read_row(N, &m);
    CHECK_OK(lw_system_assemble(&m.linkage, NULL, 0, &s, &check_error));
    CHECK(s.n_q > LW_SYSTEM_Q_MAX);
    CHECK_OK(lw_motion_curve_create(&s, NULL, &(lw_motion_curve_options){ .input = 0 }, &b, &check_error));
    CHECK_INT(lw_motion_curve_ended(b), LW_MOTION_CURVE_CLOSED);
    CHECK_INT(lw_motion_curve_turns(b, -1), 1);
    CHECK(lw_motion_curve_worst(b) < 1e-12);
    double arms = 2*0.25 + (N - 1)*4.0/9 + N;                /* squares of the circles of the links' reference points */
    CHECK_NEAR(lw_motion_curve_length(b), 2*LW_PI*sqrt(N + 1 + arms/(s.unit*s.unit)), 0, 1e-4);
    int n;
    const lw_motion_curve_event *event = lw_motion_curve_events(b, &n);
    CHECK_INT(n, 2);
    for (int i = 0; i < n; i++) {
        CHECK_INT(event[i].kind, LW_EVENT_CROSSING);
        CHECK_NEAR(sin(event[i].input), 0, 1e-9, 0);
    }
    double *series = calloc(4*(size_t)s.n_q, sizeof *series), motion[4] = { 0, 1, 0, 0 };
    for (int look = 0; look < LOOKS; look++) {
        double arc = lw_motion_curve_length(b)*(look + 0.5)/LOOKS;
        CHECK(lw_motion_curve_motion(b, lw_motion_curve_station(b, arc), 3, motion, series));
        double turn = lw_motion_curve_input(b, series) - s.input_value[0];
        for (int k = 0; k < s.n_body; k++) {
            bool crank = k <= N;
            CHECK_NEAR(series[3*k + 2], crank ? turn : 0, 1e-9, 0);
            CHECK_NEAR(series[s.n_q + 3*k + 2], crank, 1e-8, 0);
            CHECK_NEAR(series[2*s.n_q + 3*k + 2], 0, 1e-6, 0);
        }
    }
    free(series);
    lw_motion_curve_free(b);
}
