/* tests/test_newton.c - the verifier against closed forms written here and against what rigid links
 * must keep. */
#include "mbs/constraints/newton.h"
#include "mbs/kinematics/fourbar.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

OWNS(lw_newton)

static double distance(lw_vec2 a, lw_vec2 b) { return lw_v2_norm(lw_v2_sub(a, b)); }

/* A four-bar of a class with a crank, or without, not nearer to a change point than margin. */
static lw_fourbar_class draw_fourbar(lw_rng *rng, bool crank, double margin, double k[9])
{
    lw_fourbar_class c;
    do {
        for (int i = 0; i < 4; i++)
            k[i] = lw_rng_range(rng, 0.2, 1.0);
    } while (lw_fourbar_classify(k, LW_FOURBAR_TOLERANCE, &c, NULL) != LW_OK || c.crank != crank || c.margin < margin);
    for (int i = 4; i < 8; i++)
        k[i] = lw_rng_range(rng, -1.0, 1.0);
    k[8] = lw_rng_range(rng, -LW_PI, LW_PI);
    return c;
}

static lw_newton *make(const lw_linkage *k)
{
    lw_newton *s;
    CHECK_OK(lw_newton_create(k, &s, &check_error));
    return s;
}

TEST(crank_turns_in_both_modes)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 200; trial++) {
        double k[9];
        draw_fourbar(&rng, true, 1e-3, k);
        double mode = trial % 2 ? 1.0 : -1.0, start = lw_rng_range(&rng, -3.0, 3.0);
        double way = trial % 4 < 2 ? 1.0 : -1.0;
        lw_linkage l;
        fourbar_linkage(&l, k, mode, start);
        OWNED(lw_newton) *s = make(&l);
        for (int i = 1; i <= 24; i++) {
            double angle = start + way*0.31*i, reached;         /* a turn and a bit */
            CHECK_INT(lw_newton_move(s, angle + k[8], &reached), LW_OK);
            CHECK_NEAR(reached, angle + k[8], 0, 0);
            fourbar_joints q = fourbar_at(k, mode, angle);
            CHECK_NEAR(distance(lw_newton_tracer(s, 0), q.p), 0.0, 2e-13, 0);
            CHECK_NEAR(distance(lw_newton_joint(s, 2), q.b), 0.0, 2e-13, 0);
            CHECK_NEAR(lw_newton_angle(s, 1), way*0.31*i, 1e-14, 1e-15);
            CHECK(lw_newton_residual(s) <= 4e-15);
        }
        CHECK_INT(lw_newton_crossings(s), 0);
    }
}

/* Limits of the input as lw_fourbar_classify has them in closed form; and back again, over the dead
 * point's own branch. */
TEST(rocker_stops_at_its_limits)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 200; trial++) {
        double k[9], reached;
        lw_fourbar_class c = draw_fourbar(&rng, false, 1e-3, k);
        int r = c.n_range == 2 ? trial % 2 : 0;
        double mode = trial % 4 < 2 ? 1.0 : -1.0, first = c.range[r][0], last = c.range[r][1];
        double start = first + (last - first)*lw_rng_range(&rng, 0.05, 0.95);
        lw_linkage l;
        fourbar_linkage(&l, k, mode, start);
        OWNED(lw_newton) *s = make(&l);
        CHECK_INT(lw_newton_move(s, last + k[8] + 0.3, &reached), LW_OPEN);
        CHECK_NEAR(reached, last + k[8], 1e-12, 0);
        CHECK_NEAR(distance(lw_newton_joint(s, 1), fourbar_at(k, mode, last).a), 0.0, 1e-12, 0);
        CHECK(lw_newton_residual(s) <= 4e-15);
        CHECK_INT(lw_newton_move(s, last + k[8] + 0.2, &reached), LW_OPEN);
        CHECK_INT(lw_newton_move(s, first + k[8] - 0.3, &reached), LW_OPEN);
        CHECK_NEAR(reached, first + k[8], 1e-12, 0);
        CHECK_INT(lw_newton_move(s, start + k[8], &reached), LW_OK);
        CHECK_NEAR(distance(lw_newton_tracer(s, 0), fourbar_at(k, mode, start).p), 0.0, 1e-12, 0);
        lw_newton_reset(s);
        CHECK_NEAR(lw_newton_angle(s, 1), 0.0, 0, 0);
        CHECK_INT(lw_newton_move(s, last + k[8] - 1e-9, &reached), LW_OK);   /* just short of it */
        CHECK_INT(lw_newton_move(s, last + k[8] + 1e-9, &reached), LW_OPEN);
        CHECK_NEAR(reached, last + k[8], 1e-12, 0);
    }
}

/* Many turns do not wear digits off. */
TEST(a_hundred_turns)
{
    double k[9] = { 4, 1, 3.5, 2.5, 1, 2, 0, 0, 0 };
    lw_linkage l;
    fourbar_linkage(&l, k, 1.0, 0.5);
    OWNED(lw_newton) *s = make(&l);
    double reached;
    CHECK_INT(lw_newton_move(s, 0.5 + 200.0*LW_PI, &reached), LW_OK);
    CHECK_NEAR(lw_newton_angle(s, 1), 200.0*LW_PI, 0, 4e-16);
    CHECK_NEAR(distance(lw_newton_tracer(s, 0), fourbar_at(k, 1.0, 0.5).p), 0.0, 1e-12, 0);
    CHECK(lw_newton_residual(s) <= 5e-15);
}

/* Slider-crank by its crank, and by its slider, whose way ends where crank and rod are in line. */
TEST(slider_crank)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 100; trial++) {
        double r = lw_rng_range(&rng, 0.3, 1.0), e = lw_rng_range(&rng, -0.3, 0.3);
        double rod = r + fabs(e) + lw_rng_range(&rng, 0.05, 1.0), tilt = lw_rng_range(&rng, -3.0, 3.0);
        double t0 = 0.7, way = trial % 2 ? LW_PI : 0.0;        /* the slide drawn either way */
        lw_vec2 u = lw_v2_polar(1.0, tilt), base = lw_v2(0.3, -0.2);
        lw_linkage l;
        for (int driven = 0; driven < 2; driven++) {
            double x = r*cos(t0) + sqrt(rod*rod - pow(r*sin(t0) - e, 2.0));
            lw_vec2 a = lw_v2_add(base, lw_v2_turn(lw_v2_polar(r, t0), u));
            lw_vec2 b = lw_v2_add(base, lw_v2_turn(lw_v2(x, e), u));
            blank_linkage(&l, 4);
            add_pin(&l, 0, 1, base);
            add_pin(&l, 1, 2, a);
            add_pin(&l, 2, 3, b);
            add_slide(&l, 0, 3, b, tilt + way);
            add_input(&l, driven ? 3 : 0, driven ? 0.0 : t0 + tilt);
            add_tracer(&l, 3, b);
            OWNED(lw_newton) *s = make(&l);
            double reached;
            if (!driven)
                for (double t = 0.0; t < 7.0; t += 0.5) {
                    CHECK_INT(lw_newton_move(s, t + tilt, &reached), LW_OK);
                    double want = r*cos(t) + sqrt(rod*rod - pow(r*sin(t) - e, 2.0));
                    lw_vec2 at = lw_v2_unturn(lw_v2_sub(lw_newton_tracer(s, 0), base), u);
                    CHECK_NEAR(at.x, want, 1e-13, 0);
                    CHECK_NEAR(at.y, e, 1e-14, 0);
                }
            else {
                double out = sqrt(pow(rod + r, 2.0) - e*e) - x, in = sqrt(pow(rod - r, 2.0) - e*e) - x;
                double sign = way > 0.0 ? -1.0 : 1.0;
                CHECK_INT(lw_newton_move(s, sign*10.0, &reached), LW_OPEN);
                CHECK_NEAR(reached, sign*out, 1e-12, 0);
                CHECK_INT(lw_newton_move(s, -sign*10.0, &reached), LW_OPEN);
                CHECK_NEAR(reached, sign*in, 1e-12, 0);
            }
        }
    }
}

/* Random postures of six-bars, also with inputs that no dyad follows from: links stay rigid, pins
 * stay together, the input is met, and the way back ends where it began. */
TEST(six_bars_keep_their_links)
{
    static const int pair[4][7][2] = {       /* input at the first joint */
        { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,3} },          /* Watt 2-like: ternaries 2, 3       */
        { {0,1},{1,2},{2,3},{3,0},{2,4},{4,5},{5,0} },          /* Stephenson 3                      */
        { {0,1},{1,2},{2,3},{3,4},{4,1},{4,5},{5,0} },          /* the crank ternary                 */
        { {0,1},{1,2},{1,3},{2,4},{3,5},{4,5},{5,0} },          /* one group of four links           */
    };
    lw_rng rng = check_rng(4);
    int n_moved = 0, n_ended = 0;
    for (int trial = 0; trial < 120; trial++) {
        const int (*p)[2] = pair[trial % 4];
        lw_linkage l;
        OWNED(lw_newton) *s = NULL;
        blank_linkage(&l, 6);
        for (int j = 0; j < 7; j++)
            add_pin(&l, p[j][0], p[j][1], lw_v2(lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1)));
        add_input(&l, 0, 0.0);
        for (int i = 0; i < 6; i++)
            add_tracer(&l, i, lw_v2(lw_rng_range(&rng, -1, 1), lw_rng_range(&rng, -1, 1)));
        s = make(&l);
        lw_vec2 before = lw_newton_tracer(s, 4);
        double reached;
        lw_status status = lw_newton_move(s, 1.0, &reached);
        CHECK(status == LW_OK || status == LW_OPEN);
        n_moved += status == LW_OK;
        n_ended += status == LW_OPEN;
        CHECK_NEAR(lw_newton_angle(s, 1), reached, 5e-15, 0);
        CHECK(lw_newton_residual(s) <= 8e-15);
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 7; j++) {
                if (p[j][0] != i)
                    continue;
                double want = distance(l.tracer[i].at, l.joint[j].at);
                CHECK_NEAR(distance(lw_newton_tracer(s, i), lw_newton_joint(s, j)), want, 5e-15, 0);
            }
        CHECK_INT(lw_newton_move(s, 0.0, &reached), LW_OK);
        CHECK_NEAR(distance(lw_newton_tracer(s, 4), before), 0.0, 1e-7, 0);   /* dead points may be near */
    }
    CHECK(n_moved > 20 && n_ended > 20);
}

/* A beam engine's parallelogram with a third, equal crank: one constraint too many, yet it turns;
 * and the third crank keeps it from folding at the change points. */
TEST(overconstrained_parallelogram)
{
    lw_linkage l;
    blank_linkage(&l, 5);
    double t = 0.4;
    lw_vec2 up = lw_v2_polar(1.0, t);
    for (int i = 0; i < 3; i++) {
        add_pin(&l, 0, 1 + i, lw_v2(1.5*i, 0.0));
        add_pin(&l, 1 + i, 4, lw_v2_add(lw_v2(1.5*i, 0.0), up));
    }
    add_input(&l, 0, t);
    add_tracer(&l, 4, lw_v2(2.0, 1.0));
    lw_newton *s = make(&l);
    for (int i = 1; i <= 20; i++) {
        CHECK_INT(lw_newton_move(s, t + 0.5*i, NULL), LW_OK);
        lw_vec2 want = lw_v2_add(lw_v2(2.0, 1.0), lw_v2_sub(lw_v2_polar(1.0, t + 0.5*i), up));
        CHECK_NEAR(distance(lw_newton_tracer(s, 0), want), 0.0, 1e-14, 0);
        CHECK_NEAR(lw_newton_angle(s, 4), 0.0, 1e-14, 0);
    }
    lw_newton_free(s);
    l.joint[5].at.x += 0.01;                                   /* now it is a truss */
    CHECK_FAILS(lw_newton_create(&l, &s, &check_error), LW_E_NUMERIC, "rigid");
    CHECK(s == NULL);
}

/* Crank between two moving links: the input is their relative turn. */
TEST(input_between_moving_links)
{
    double k[9] = { 4, 2, 3, 3.5, 1, 1, 0, 0, 0 };
    lw_linkage l;
    fourbar_linkage(&l, k, 1.0, 1.0);
    l.n_input = 0;
    add_input(&l, 1, 0.0);
    OWNED(lw_newton) *s = make(&l);
    CHECK_INT(lw_newton_move(s, -0.2, NULL), LW_OK);
    CHECK_NEAR(lw_newton_angle(s, 2) - lw_newton_angle(s, 1), -0.2, 1e-15, 0);
}

/* A pin in a slot: Geneva-like crank, tan of the slot's turn = r sin t/(d + r cos t). */
TEST(pin_in_slot)
{
    lw_linkage l;
    blank_linkage(&l, 3);
    double r = 1.0, d = 2.0, t = 0.3;
    lw_vec2 pin = lw_v2_polar(r, t), pivot = lw_v2(-d, 0.0);
    double turn = atan2(pin.y, pin.x + d);
    int crank = add_pin(&l, 0, 1, lw_v2(0.0, 0.0));
    add_pin(&l, 0, 2, pivot);
    add_joint(&l, LW_JOINT_SLOT, 2, 1, pin, turn);
    add_input(&l, crank, t);
    OWNED(lw_newton) *s = make(&l);
    for (int i = 1; i <= 20; i++) {
        double now = t + 0.4*i;
        CHECK_INT(lw_newton_move(s, now, NULL), LW_OK);
        CHECK_NEAR(lw_newton_angle(s, 2), atan2(r*sin(now), d + r*cos(now)) - turn, 1e-14, 0);
    }
}

/* Cardan's gears: a point of the rim of the planet in a ring twice its size keeps to a line, for fifty turns. */
TEST(cardan_gears_draw_a_line)
{
    lw_linkage l;
    blank_linkage(&l, 3);
    add_joints(&l, JOINTS(PIN(0, 1, 5.0, 3.0), PIN(1, 2, 6.0, 3.0), GEAR(0, 2, 7.0, 3.0, 2.0)));
    add_input(&l, 0, 0.0);
    add_tracer(&l, 2, lw_v2(7.0, 3.0));
    OWNED(lw_newton) *s = make(&l);
    for (int i = 1; i <= 200; i++) {
        double turn = 0.5*LW_PI*i + 0.1, reached;
        CHECK_INT(lw_newton_move(s, turn, &reached), LW_OK);
        CHECK_NEAR(lw_newton_tracer(s, 0).y, 3.0, 2e-14, 0);
        CHECK_NEAR(lw_newton_tracer(s, 0).x, 5.0 + 2.0*cos(turn), 1e-14*i, 0);
        CHECK_NEAR(lw_newton_angle(s, 2), -turn, 1e-15, 1e-15);
        CHECK(lw_newton_residual(s) <= 1e-14);
    }
}

/* Three wheels on the ground and a rack on the last, with ratios that are no round numbers. */
TEST(a_gear_train_turns_by_its_ratios)
{
    const double r[3] = { -3.7, -0.31, 1.9 };
    lw_linkage l;
    blank_linkage(&l, 5);                                  /* ground, three wheels, rack */
    for (int i = 0; i < 3; i++)
        add_pin(&l, 0, i + 1, lw_v2(2.0*i, 0.3*i));
    add_slide(&l, 0, 4, lw_v2(3.0, 3.0), 0.4);
    for (int i = 0; i < 3; i++)
        add_gear(&l, i + 1, i + 2, lw_v2(2.0*i + 1.0, 0.0), r[i]);
    add_input(&l, 0, 0.0);
    add_tracer(&l, 4, lw_v2(3.0, 3.0));
    OWNED(lw_newton) *s = make(&l);
    for (int i = 1; i <= 40; i++) {
        double turn = -0.9*i, reached;
        CHECK_INT(lw_newton_move(s, turn, &reached), LW_OK);
        CHECK_NEAR(lw_newton_angle(s, 2), r[0]*turn, 1e-14, 1e-15);
        CHECK_NEAR(lw_newton_angle(s, 3), r[0]*r[1]*turn, 1e-14, 1e-15);
        lw_vec2 way = lw_v2_sub(lw_newton_tracer(s, 0), lw_v2(3.0, 3.0));
        CHECK_NEAR(distance(way, lw_v2_polar(r[0]*r[1]*r[2]*turn, 0.4)), 0.0, 1e-14*i, 0);
    }
}

TEST(refuses_with_reasons)
{
    double k[9] = { 4, 2, 3, 3.5, 1, 1, 0, 0, 0 }, reached;
    lw_linkage l;
    lw_newton *s;
    fourbar_linkage(&l, k, 1.0, 1.0);
    l.n_input = 0;
    CHECK_FAILS(lw_newton_create(&l, &s, &check_error), LW_E_ARG, "no input");
    fourbar_linkage(&l, k, 1.0, 1.0);
    l.joint[2].kind = LW_JOINT_GEAR;
    l.joint[2].ratio = 2.0;
    CHECK_FAILS(lw_newton_create(&l, &s, &check_error), LW_E_KIND, "no link carries both");
    double dead[9] = { 4, 3, 2, 3, 1, 1, 0, 0, 0 };            /* posture where b and h are in line */
    lw_fourbar_class c;
    lw_fourbar_classify(dead, LW_FOURBAR_TOLERANCE, &c, NULL);
    fourbar_linkage(&l, dead, 1.0, c.limit[c.n_limit - 1]);
    CHECK_FAILS(lw_newton_create(&l, &s, &check_error), LW_E_NUMERIC, "dead point");
    blank_linkage(&l, 5);                                      /* five-bar: two freedoms */
    for (int i = 0; i < 5; i++)
        add_pin(&l, i, (i + 1) % 5, lw_v2_polar(1.0, 1.2*i));
    add_input(&l, 0, 0.0);
    CHECK_FAILS(lw_newton_create(&l, &s, &check_error), LW_E_ARG, "2 freedoms but 1 input; drive 1 more joint");
    add_input(&l, 4, 0.0);
    s = make(&l);                                              /* driven twice it moves */
    CHECK_INT(lw_newton_move(s, 0.1, &reached), LW_OK);
    CHECK_NEAR(lw_newton_angle(s, 4), 0.0, 1e-15, 0);
    CHECK_INT(lw_newton_move(s, NAN, &reached), LW_E_ARG);
    lw_newton_free(s);
    lw_newton_free(NULL);
}
