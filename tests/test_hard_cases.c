/* tests/test_hard_cases.c - linkages that break programs: change points and what is near them, extreme
 * ratios and places, straight lines.  Each goes through classification, motion, the plan and the
 * verifier, which share no code. */
#include "mbs/kinematics/fourbar.h"
#include "mbs/kinematics/motion.h"
#include "mbs/constraints/newton.h"
#include "mbs/batch/posture.h"
#include "mbs/plan/types.h"
#include "tests/check.h"
#include "tests/straight_lines.h"

OWNS(lw_newton)

static double distance(lw_vec2 a, lw_vec2 b) { return lw_v2_norm(lw_v2_sub(a, b)); }

static lw_plan plan_of_type(const char *name, lw_linkage *k)
{
    lw_plan plan;
    lw_type_linkage(lw_type_find(name), k);
    CHECK_INT(lw_plan_make(k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    return plan;
}

static lw_newton *newton_of(const lw_linkage *k)
{
    lw_newton *s = NULL;
    CHECK_OK(lw_newton_create(k, &s, &check_error));
    return s;
}

static bool finite_posture(const lw_posture *p)
{
    for (int i = 0; i <= LW_ORDER_MAX; i++)
        if (!isfinite(p->tracer[0][i].x) || !isfinite(p->tracer[0][i].y) || !isfinite(p->angle[2][i]))
            return false;
    return isfinite(p->margin);
}

/* --- change points --- */

/* Which way the smooth motion goes on at a change point: the mode as a function of the input. */
typedef double mode_of(double input);
static double parallel_mode(double t) { return sin(t) >= 0.0 ? 1.0 : -1.0; }
static double crossed_mode(double t) { return -parallel_mode(t); }
static double kite_mode(double t) { return sin(0.5*t) >= 0.0 ? 1.0 : -1.0; }

static const struct {
    const char *name;
    double      r[4];
    mode_of    *mode;
    int         crossings;              /* in two turns */
} change_point[] = {
    { "parallelogram",     { 5, 2, 5, 2 }, parallel_mode, 4 },
    { "short frame",       { 2, 5, 2, 5 }, parallel_mode, 4 },
    { "antiparallelogram", { 5, 2, 5, 2 }, crossed_mode,  4 },
    { "contraparallelogram, short frame", { 2, 5, 2, 5 }, crossed_mode, 4 },
    { "kite",              { 2, 2, 5, 5 }, kite_mode,     2 },
    { "deltoid",           { 3, 1, 1, 3 }, parallel_mode, 4 },
    { "deltoid, rocker at rest on the frame", { 3, 1, 1, 3 }, crossed_mode, 4 },
    { "rhombus",           { 3, 3, 3, 3 }, parallel_mode, 4 },
};

/* Straight on through every change point: two turns against the closed form with the mode changed by
 * hand, the stations being off the change points themselves. */
TEST(change_points_are_passed_straight)
{
    for (size_t c = 0; c < sizeof change_point/sizeof *change_point; c++) {
        double k[9] = { 0, 0, 0, 0, 1.5, 2.5, 0.3, -0.4, 0.2 }, start = 0.6;
        memcpy(k, change_point[c].r, sizeof change_point[c].r);
        lw_linkage l;
        fourbar_linkage(&l, k, change_point[c].mode(start), start);
        OWNED(lw_newton) *s = newton_of(&l);
        if (!s)
            continue;
        for (int i = 1; i <= 31; i++) {
            double t = start + 4.0*LW_PI*i/31.0;
            CHECK_INT(lw_newton_move(s, t + k[8], NULL), LW_OK);
            lw_vec2 want = fourbar_at(k, change_point[c].mode(t), t).p;
            CHECK_NEAR(distance(lw_newton_tracer(s, 0), want), 0.0, 1e-12, 0);
        }
        CHECK_INT(lw_newton_crossings(s), change_point[c].crossings);
    }
}

/* Inputs at a change point and next to it, reached from both sides: the motion goes on from there as if it had not stopped. */
TEST(change_points_are_reached)
{
    static const double off[] = { 0, 1e-12, 1e-9, 1e-7, 5e-7, 1e-6, 3e-6, 8.3e-6, 2e-5, 1e-4 };
    int n = (int)(sizeof off/sizeof *off);
    double k[9] = { 0.54362106323242188, 0.67822742462158203, 0.98526191711425781, 1.119868278503418, 0.3, 0.2, 0.3, -0.4, 0.2 };
    for (int way = -1; way <= 1; way += 2)
        for (int i = 0; i < 2*n; i++) {
            double stop = i < n ? off[i] : -off[i - n], start = -0.7*way;
            lw_linkage l;
            fourbar_linkage(&l, k, 1.0, start);
            OWNED(lw_newton) *s = newton_of(&l);
            for (int step = 0; s && step < 4; step++) {             /* to the stop, over it, back to it, on */
                double t = step % 2 == 0 ? stop : step == 1 ? 0.5*way : start, mode = t*way > 0.0 ? -1.0 : 1.0;
                CHECK_INT(lw_newton_move(s, t + k[8], NULL), LW_OK);
                CHECK_NEAR(lw_newton_input(s), t + k[8], 1e-15, 0);
                double most = fabs(t) > 0.1 ? 1e-11 : fmin(1e-7, 1e-11 + 1e-15/fabs(t));
                CHECK_NEAR(distance(lw_newton_tracer(s, 0), fourbar_at(k, mode, t).p), 0.0, most, 0);
                CHECK(lw_newton_residual(s) < 4e-15);
            }
            CHECK_INT(lw_newton_crossings(s), 2);
        }
}

/* The same for lengths drawn at random, multiples of 2^-20 so that the sums are exact: frame and crank
 * in line with the others drawn out (g + a = b + h) or folded (g - a = b - h). */
TEST(random_change_points_are_passed_straight)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 300; trial++) {
        double k[9], grain = 0x1p-20;
        bool drawn = trial % 2;
        do {
            for (int i = 0; i < 3; i++)
                k[i] = grain*floor(lw_rng_range(&rng, 0.2, 1.0)/grain);
            k[3] = drawn ? k[0] + k[1] - k[2] : k[2] - k[0] + k[1];
        } while (k[3] < 0.1 || fabs(k[3] - k[0]) < 0.05 || fabs(k[3] - k[1]) < 0.05 || fabs(k[1] - k[0]) < 0.05);
        for (int i = 4; i < 9; i++)
            k[i] = lw_rng_range(&rng, -1.0, 1.0);
        lw_fourbar_class c;
        CHECK_INT(lw_fourbar_classify(k, 0.0, &c, NULL), LW_OK);
        CHECK(c.margin == 0.0);
        if (!c.crank)
            continue;
        double start = lw_rng_range(&rng, 0.1, 3.0), at = drawn ? LW_PI : 0.0;
        lw_linkage l;
        fourbar_linkage(&l, k, 1.0, start);
        OWNED(lw_newton) *s = newton_of(&l);
        for (int i = 1; s && i <= 19; i++) {
            double t = start + 4.0*LW_PI*i/19.0, mode = floor((t - at)/(2.0*LW_PI)) - floor((start - at)/(2.0*LW_PI));
            CHECK_INT(lw_newton_move(s, t + k[8], NULL), LW_OK);
            lw_vec2 want = fourbar_at(k, fmod(mode, 2.0) == 0.0 ? 1.0 : -1.0, t).p;
            double near = fabs(remainder(t - at, 2*LW_PI));       /* a rounded length moves the point by eps over this */
            CHECK_NEAR(distance(lw_newton_tracer(s, 0), want), 0.0, 1e-11 + 1e-15/near, 0);
        }
        CHECK_INT(lw_newton_crossings(s), 2);
    }
}

/* In each mode of its own the plan goes round a change point without a jump or a NaN; the margin is
 * 0 there and positive elsewhere. */
TEST(change_points_through_the_plan)
{
    lw_linkage l;
    lw_plan plan = plan_of_type("fourbar", &l);
    for (size_t c = 0; c < sizeof change_point/sizeof *change_point; c++)
        for (double mode = -1.0; mode <= 1.0; mode += 2.0) {
            double k[9] = { 0, 0, 0, 0, 1.5, 2.5, 0.3, -0.4, 0.2 };
            memcpy(k, change_point[c].r, sizeof change_point[c].r);
            static lw_posture p;
            for (int i = 0; i < 360; i++) {
                double t = i*LW_PI/180.0;
                lw_status status = lw_posture_solve(&plan, k, &mode, t, LW_ORDER_MAX, &p);
                CHECK(finite_posture(&p));
                if (i % 180 == 0) {
                    CHECK(fabs(p.margin) < 1e-12 || c >= 4);
                    continue;
                }
                CHECK_INT(status, LW_OK);
                CHECK(p.margin > 0.0);
                CHECK_NEAR(distance(p.tracer[0][0], fourbar_at(k, mode, t).p), 0.0, 1e-12, 0);
            }
        }
}

TEST(change_points_are_told)
{
    lw_linkage l;
    lw_plan plan = plan_of_type("fourbar", &l);
    for (size_t c = 0; c < sizeof change_point/sizeof *change_point; c++) {
        double k[9] = { 0 };
        lw_fourbar_class b;
        lw_motion m;
        memcpy(k, change_point[c].r, sizeof change_point[c].r);
        CHECK_INT(lw_fourbar_classify(k, LW_FOURBAR_TOLERANCE, &b, NULL), LW_OK);
        CHECK(b.number >= 13 && b.margin == 0.0);
        CHECK_INT(lw_motion_find(&plan, k, &m), LW_OK);
        CHECK(m.change_point && m.n_circuit == 1 && m.n_arc == 2 && m.arc[0].turns && m.arc[1].turns);
    }
}

/* --- margins of 1e-3 ... 1e-15 --- */

/* g + a - b - h = q, either sign, with the limit angle known without cancellation (see
 * test_fourbar.c); q a power of two, so that the lengths are exact. */
static double near_change_point(int digits, double sign, double k[9], double *limit)
{
    double q = sign*exp2(round(log2(pow(10.0, -digits)*12.0)));
    double dim[9] = { 4, 2, 3, 3.0 - q, 1, 2, 0, 0, 0 };
    memcpy(k, dim, sizeof dim);
    *limit = q > 0.0 ? LW_PI - 2.0*asin(sqrt(q*(12.0 - q)/32.0)) : LW_PI;
    return fabs(q)/(12.0 - q);
}

TEST(near_the_change_point_by_class_and_motion)
{
    lw_linkage l;
    lw_plan plan = plan_of_type("fourbar", &l);
    for (int digits = 3; digits <= 15; digits++)
        for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
            double k[9], limit, margin = near_change_point(digits, sign, k, &limit);
            lw_fourbar_class c;
            lw_motion m;
            CHECK_INT(lw_fourbar_classify(k, 0.0, &c, NULL), LW_OK);
            CHECK_TEXT(c.symbol, sign > 0.0 ? "RRR1" : "GCRR");
            CHECK_NEAR(c.margin, margin, 0, 1e-15);
            CHECK_NEAR(c.change, sign*margin, 0, 1e-15);
            CHECK_INT(lw_motion_find(&plan, k, &m), LW_OK);
            CHECK_INT(m.n_arc, 2);
            if (digits >= 14)                  /* counts as a change point there */
                continue;
            CHECK_INT(m.n_circuit, sign > 0.0 ? 1 : 2);
            CHECK(!m.change_point);
            CHECK_INT(m.arc[0].turns, sign < 0.0);
            if (sign > 0.0) {
                CHECK_NEAR(c.limit[1], limit, 1e-15, 0);
                CHECK_NEAR(m.arc[0].last, limit, 1e-15, 0);
                CHECK_NEAR(m.arc[0].first, -limit, 1e-15, 0);
            }
        }
}

/* The plan closes where the closed form says, and never gives a NaN. */
TEST(near_the_change_point_by_posture)
{
    lw_linkage l;
    lw_plan plan = plan_of_type("fourbar", &l);
    for (int digits = 3; digits <= 15; digits++)
        for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
            double k[9], limit, mode = 1.0;
            near_change_point(digits, sign, k, &limit);
            static lw_posture p;
            double width = fmax(LW_PI - limit, 1e-9);
            for (int i = -40; i <= 40; i++) {
                double t = limit + 0.05*i*width;
                lw_status status = lw_posture_solve(&plan, k, &mode, t, LW_ORDER_MAX, &p);
                CHECK(finite_posture(&p));
                /* the square of the distance is known to 4e-15 of its size: 2 sin is its derivative */
                bool known = fabs(t - limit)*fmax(LW_PI - limit, 1e-8) > 4e-15;
                if (known && t <= LW_PI)
                    CHECK_INT(status, sign < 0.0 || t < limit ? LW_OK : LW_OPEN);
            }
        }
}

/* The verifier finds the limits, or follows the sharp bend past the neighbouring branch; nearer than
 * 1e-12 it may take it for a crossing, and says so. */
TEST(near_the_change_point_by_newton)
{
    for (int digits = 3; digits <= 15; digits++)
        for (double sign = -1.0; sign <= 1.0; sign += 2.0) {
            double k[9], limit, reached;
            near_change_point(digits, sign, k, &limit);
            lw_linkage l;
            fourbar_linkage(&l, k, 1.0, 1.0);
            lw_newton *s = newton_of(&l);
            lw_status status = lw_newton_move(s, sign > 0.0 ? 4.0 : 1.0 + 2.0*LW_PI, &reached);
            double end = sign > 0.0 ? limit : 1.0 + 2.0*LW_PI;
            CHECK(lw_newton_residual(s) <= 2e-14);
            if (digits >= 12 && lw_newton_crossings(s) > 0) {
                CHECK_INT(status, LW_OK);
                lw_newton_free(s);
                continue;
            }
            CHECK_INT(status, sign > 0.0 ? LW_OPEN : LW_OK);
            CHECK_NEAR(reached, end, 1e-10, 0);
            CHECK_INT(lw_newton_crossings(s), 0);
            double noise = sign > 0.0 ? 1e-7 : 1e-13;   /* at a limit places have half the digits */
            CHECK_NEAR(distance(lw_newton_tracer(s, 0), fourbar_at(k, 1.0, end).p), 0.0, noise, 0);
            lw_newton_free(s);
        }
}

/* --- ratios, places, units --- */

/* Plan and verifier from the same drawn posture, over a full turn. */
static void compare_over_a_turn(const double k[9], double mode, double start, double tolerance)
{
    lw_linkage l;
    lw_plan plan;
    double dim[LW_DIM_MAX], modes[LW_MODE_MAX], input;
    fourbar_linkage(&l, k, mode, start);
    CHECK_INT(lw_plan_make(&l, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &l, dim, modes, &input, NULL), LW_OK);
    OWNED(lw_newton) *s = newton_of(&l);
    for (int i = 1; s && i <= 24; i++) {
        static lw_posture p;
        double turn = 2.0*LW_PI*i/24.0;
        CHECK_INT(lw_newton_move(s, l.input[0].value + turn, NULL), LW_OK);
        CHECK_INT(lw_posture_solve(&plan, dim, modes, input + turn, 0, &p), LW_OK);
        CHECK_NEAR(distance(lw_newton_tracer(s, 0), p.tracer[0][0]), 0.0, tolerance, 0);
    }
}

TEST(length_ratio_of_a_million)
{
    double tiny_crank[9] = { 1, 1e-6, 1, 1, 0.4, 0.7, 0, 0, 0 };
    double tiny_frame[9] = { 1e-6, 1, 1, 1, 0.4, 0.7, 0, 0, 0 };
    compare_over_a_turn(tiny_crank, 1.0, 0.4, 1e-14);
    compare_over_a_turn(tiny_crank, -1.0, 2.4, 1e-14);
    compare_over_a_turn(tiny_frame, 1.0, 0.4, 1e-13);
    /* the frame a millionth of the rest: coupler point on a circle of its own about the pivot */
    lw_fourbar_class c;
    CHECK_INT(lw_fourbar_classify(tiny_frame, LW_FOURBAR_TOLERANCE, &c, NULL), LW_OK);
    CHECK_TEXT(c.symbol, "GCCC");
}

TEST(far_from_the_origin_and_small)
{
    double k[9] = { 4, 1, 3.5, 2.5, 1, 2, 0, 0, 0.3 };
    for (int i = 0; i < 6; i++) {
        double far[9], large[9], tiny[9], place = pow(10.0, 4 + i);
        memcpy(far, k, sizeof k);
        far[6] = place, far[7] = -0.7*place;
        /* the posture's coordinates are rounded to one part in 2^53; both read the same ones */
        compare_over_a_turn(far, 1.0, 0.5, 4e-15 + 4.0*place*0x1p-52);
        for (int d = 0; d < 9; d++) {
            double unit = d == 8 ? 1.0 : place;
            large[d] = k[d]*unit;
            tiny[d] = k[d]/unit;
        }
        compare_over_a_turn(large, 1.0, 0.5, 4e-14*place);
        compare_over_a_turn(tiny, 1.0, 0.5, 4e-14/place);
    }
}

TEST(coupler_point_on_a_pivot)
{
    for (int at_b = 0; at_b < 2; at_b++) {
        double k[9] = { 4, 1, 3.5, 2.5, at_b ? 3.5 : 0.0, 0, 0.2, 0.1, 0.3 };
        compare_over_a_turn(k, 1.0, 0.5, 1e-13);
        lw_linkage l;
        fourbar_linkage(&l, k, 1.0, 0.5);
        OWNED(lw_newton) *s = newton_of(&l);
        lw_vec2 pivot = at_b ? l.joint[3].at : l.joint[0].at;
        for (int i = 0; s && i < 12; i++) {
            CHECK_INT(lw_newton_move(s, l.input[0].value + i, NULL), LW_OK);
            CHECK_NEAR(distance(lw_newton_tracer(s, 0), pivot), at_b ? 2.5 : 1.0, 1e-14, 0);
        }
    }
}

/* --- straight lines --- */

/* Approximate straight lines: extremes of the deviation, computed with 30 digits (mpmath) from the
 * intersection of two circles.  The line is  p . n = offset, n the direction of `normal` [rad].
 * Chebyshev's and Hoeken's linkages are cognates, hence the same deviation. */
static const struct {
    const char *name;
    double      k[9], mode, first, last, normal, offset;
    struct { double input, deviation; } extreme[4];
    double      least, most;                       /* over first .. last                            */
} line[] = {
    { "Chebyshev", { 4, 5, 2, 5, 1, 0, 0, 0, 0 }, -1, 0.7, LW_PI/2, LW_PI/2, 4,
      { { 0.70210440414802051354, 0.0097537330863600057645 }, { 0.92729521800161223243, 0.0 },
        { 1.2802087687143641251, 0.0097537330863600057645 }, { LW_PI/2, 0.0 } },
      0.0, 0.0097537330863600057645 },
    { "Hoeken", { 2, 1, 2.5, 2.5, 5, 0, 0, 0, 0 }, 1, LW_PI/2, 3*LW_PI/2, LW_PI/2, 4,
      { { 2.2459278597319282664, 0.0097537330863600057645 }, { LW_PI, 0.0 },
        { 4.0372574474476582105, 0.0097537330863600057645 }, { LW_PI/2, 0.0 } },
      0.0, 0.0097537330863600057645 },
    { "Roberts", { 2, 1.2, 1, 1.2, 0.5, -1.0908712114635714412, 0, 0, 0 }, 1, 0.9, 1.4, LW_PI/2, 0,
      { { 1.1410208954903689334, 0.0 }, { 0.9, -0.0090141052159713988565 },
        { 1.4, -0.013534825661028071092 }, { 1.1410208954903689334, 0.0 } },
      -0.013534825661028071092, 0.0 },
    { "Watt", { 10.19803902718556966, 5, 2, 5, 1, 0, 0, 0, -0.19739555984988075837 }, -1,
      -0.10260444015011924163, 0.49739555984988075837, 0.0, 5,
      { { -0.10260444015011924163, -0.0071837836193288170196 }, { 0.49739555984988075837, 0.00860545720801762735 },
        { 0.19739555984988075837, 0.0 }, { 0.19739555984988075837, 0.0 } },
      -0.0071837836193288170196, 0.00860545720801762735 },
    { "Evans", { 5.3141321022345690273, 1, 1, 5, -1, 0, 0, 0, 1.2252407462131844824 }, -1,
      -1.9252407462131844824, -0.5252407462131844824, 0.0, 0,
      { { -1.4267678900717226984, 0.00052005037322750597615 }, { -1.0211318147476685764, -0.00052005037322750597615 },
        { -1.9252407462131844824, 0.0065267004045008909646 }, { -0.5252407462131844824, -0.0058413178650255097854 } },
      -0.0058413178650255097854, 0.0065267004045008909646 },
};

static double deviation(size_t i, lw_vec2 p)
{
    return p.x*cos(line[i].normal) + p.y*sin(line[i].normal) - line[i].offset;
}

TEST(straight_lines_by_plan_and_newton)
{
    lw_linkage type, l;
    lw_plan plan = plan_of_type("fourbar", &type);
    for (size_t i = 0; i < sizeof line/sizeof *line; i++) {
        const double *k = line[i].k;
        double middle = 0.5*(line[i].first + line[i].last) + 0.1*(line[i].last - line[i].first);
        fourbar_linkage(&l, k, line[i].mode, middle);
        OWNED(lw_newton) *s = newton_of(&l);
        static lw_posture p;
        for (int j = 0; s && j < 4; j++) {
            double t = line[i].extreme[j].input, want = line[i].extreme[j].deviation;
            CHECK_INT(lw_posture_solve(&plan, k, &line[i].mode, t, 0, &p), LW_OK);
            CHECK_NEAR(deviation(i, p.tracer[0][0]), want, 5e-14, 0);
            CHECK_INT(lw_newton_move(s, t + k[8], NULL), LW_OK);
            CHECK_NEAR(deviation(i, lw_newton_tracer(s, 0)), want, 5e-14, 0);
        }
        for (int j = 0; j <= 1000; j++) {
            double t = line[i].first + (line[i].last - line[i].first)*j/1000.0;
            CHECK_INT(lw_posture_solve(&plan, k, &line[i].mode, t, 0, &p), LW_OK);
            double d = deviation(i, p.tracer[0][0]);
            CHECK(d >= line[i].least - 5e-14 && d <= line[i].most + 5e-14);
        }
    }
}

/* --- slider-crank with equal crank and rod: Scott Russell --- */

/* The slider passes the crank's pivot, where the other branch (slider at rest on the pivot, rod
 * turning with the crank) crosses; the tracer stays on the y axis exactly. */
TEST(equal_crank_and_rod)
{
    lw_linkage l;
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    scott_russell(&l, 0.7);
    lw_newton *s = newton_of(&l);
    for (int i = 1; s && i <= 25; i++) {
        double t = 0.7 + 0.31*i;
        CHECK_INT(lw_newton_move(s, t, NULL), LW_OK);
        CHECK_POINT(lw_newton_tracer(s, 0), 0.0, 2.0*sin(t), 1e-13, 0);
    }
    CHECK_INT(lw_newton_crossings(s), 3);                  /* pi/2, 3 pi/2, 5 pi/2 before 8.45 */
    lw_newton_free(s);

    lw_motion m;
    static lw_posture p;
    CHECK_INT(lw_plan_make(&l, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &l, dim, mode, &input, NULL), LW_OK);
    CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
    CHECK(m.change_point && m.n_arc == 2 && m.n_circuit == 1);
    CHECK(m.arc[0].turns && m.arc[1].turns);
    for (int i = -89; i <= 89; i++) {                      /* while cos t > 0 in the drawn mode */
        double t = i*LW_PI/180.0;
        CHECK_INT(lw_posture_solve(&plan, dim, mode, t, 0, &p), LW_OK);
        CHECK_POINT(p.tracer[0][0], 0.0, 2.0*sin(t), 2e-14, 0);
    }
}

/* Crank longer than the rod: it rocks to asin(l/r), 41.81 deg for 1.5 and 1. */
TEST(rocking_slider_crank)
{
    lw_linkage l;
    double t = 0.3, x = 1.5*cos(t) + sqrt(1.0 - pow(1.5*sin(t), 2.0)), reached;
    blank_linkage(&l, 4);
    add_pin(&l, 0, 1, lw_v2(0.0, 0.0));
    add_pin(&l, 1, 2, lw_v2_polar(1.5, t));
    add_pin(&l, 2, 3, lw_v2(x, 0.0));
    add_slide(&l, 0, 3, lw_v2(x, 0.0), 0.0);
    add_input(&l, 0, t);
    add_tracer(&l, 2, lw_v2(1.0, 1.0));
    lw_newton *s = newton_of(&l);
    CHECK_INT(lw_newton_move(s, 1.0, &reached), LW_OPEN);
    CHECK_NEAR(reached, 41.81031489577859806586*LW_PI/180.0, 1e-14, 0);
    lw_newton_free(s);

    lw_plan plan;
    lw_motion m;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    CHECK_INT(lw_plan_make(&l, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &l, dim, mode, &input, NULL), LW_OK);
    CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
    int a = lw_motion_arc(&plan, &m, mode, input);
    CHECK(m.n_arc == 4 && m.n_circuit == 2 && a >= 0);
    if (a >= 0)
        CHECK_NEAR(m.arc[a].last - m.arc[a].first, 2.0*41.81031489577859806586*LW_PI/180.0, 1e-14, 0);
}

/* --- Peaucellier's inversor: exactly straight, and limits where two dyads end at once --- */

TEST(peaucellier_is_straight)
{
    const double limit = 96.37937020844280386828*LW_PI/180.0;       /* cos(t/2) = 2/3 */
    lw_linkage l;
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input, reached;
    peaucellier(&l, 1.5, 0.3);
    lw_newton *s = newton_of(&l);
    CHECK_INT(lw_plan_make(&l, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &l, dim, mode, &input, NULL), LW_OK);
    for (int i = -9; s && i <= 9; i++) {
        static lw_posture p;
        CHECK_INT(lw_newton_move(s, 0.185*i, NULL), LW_OK);
        CHECK_NEAR(lw_newton_tracer(s, 0).x, 16.0/3.0, 2e-13, 0);
        CHECK_INT(lw_posture_solve(&plan, dim, mode, input + 0.185*i - 0.3, 0, &p), LW_OK);
        CHECK_POINT(p.tracer[0][0], 16.0/3.0, lw_newton_tracer(s, 0).y, 2e-13, 0);
    }
    for (int way = -1; s && way <= 1; way += 2) {
        CHECK_INT(lw_newton_move(s, 2.0*way, &reached), LW_OPEN);
        CHECK_NEAR(reached, limit*way, 1e-11, 0);
        CHECK_INT(lw_newton_move(s, 0.5*way, &reached), LW_OK);
        CHECK_NEAR(lw_newton_tracer(s, 0).x, 16.0/3.0, 1e-12, 0);
    }
    lw_newton_free(s);

    static lw_motion m;
    CHECK_INT(lw_motion_find(&plan, dim, &m), LW_OK);
    int a = lw_motion_arc(&plan, &m, mode, input);
    CHECK(a >= 0);
    if (a >= 0) {
        CHECK_NEAR(remainder(m.arc[a].first - (input - 0.3 - limit), 2.0*LW_PI), 0.0, 1e-12, 0);
        CHECK_NEAR(remainder(m.arc[a].last - (input - 0.3 + limit), 2.0*LW_PI), 0.0, 1e-12, 0);
    }
}

/* With c = 2 the points P and Q meet at t = 0, where the rhombus is flat: half the digits there (the
 * root of what rounding leaves of lengths of 5), all of them again beyond. */
TEST(peaucellier_through_its_flat_rhombus)
{
    lw_linkage l;
    peaucellier(&l, 2.0, 0.5);
    OWNED(lw_newton) *s = newton_of(&l);
    for (int i = 4; s && i >= -4; i--) {
        CHECK_INT(lw_newton_move(s, 0.1*i, NULL), LW_OK);
        CHECK_NEAR(lw_newton_tracer(s, 0).x, 4.0, i == 0 ? 1e-7 : 8e-13, 0);
    }
}
