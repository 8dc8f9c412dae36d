/* tests/test_prescribed_motion.c - inputs as functions of time against closed forms. */
#include "mbs/constraints/prescribed_motion.h"
#include "grammar/functions/expression.h"
#include "mbs/kinematics/fourbar.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

typedef struct ride { lw_system s; lw_prescribed_motion *d; lw_error e; lw_status status; } ride;

static ride *start(const lw_linkage *k, lw_input_function *motion, void *context, double t)
{
    ride *r = calloc(1, sizeof *r);
    CHECK_INT(lw_system_make(k, NULL, 0, &r->s, &r->e), LW_OK);
    r->status = lw_prescribed_motion_create(&r->s, NULL, motion, context, t, &r->d, &r->e);
    return r;
}

static void stop(ride *r)
{
    lw_prescribed_motion_free(r->d);
    lw_system_free(&r->s);
    free(r);
}

static double distance(lw_vec2 a, lw_vec2 b) { return lw_v2_norm(lw_v2_sub(a, b)); }

static lw_vec2 tracer(const ride *r, int i)
{
    return lw_system_point(&r->s, r->s.tracer_body[i], r->s.tracer_arm[i], lw_prescribed_motion_posture(r->d));
}

static double residual(const ride *r)
{
    double phi[LW_SYSTEM_ROW_MAX], most = 0;
    lw_system_rows(&r->s, lw_prescribed_motion_posture(r->d), phi, NULL);
    for (int i = 0; i < r->s.n_row; i++)
        most = fmax(most, fabs(phi[i]));
    return most;
}

/* Coefficients of a + b sin(w t + c) */
static void sine(double a, double b, double w, double c, double t, int order, double *u)
{
    double factor = b;
    for (int k = 0; k <= order; k++) {
        u[k] = factor*sin(w*t + c + 0.5*LW_PI*k);
        factor *= w/(k + 1);
    }
    u[0] += a;
}

/* A five-bar: pins 0 and (3, 0), arms 1, rods 2.5; its arms swing and turn. */
static void five_bar_motion(void *context, double t, int order, double *u)
{
    (void)context;
    sine(1.2, 0.5, 3, 0.2, t, order, u);
    sine(1.5, 0.9, 2, 1.0, t, order, u + order + 1);
}

static lw_vec2 five_bar_tip(double t)
{
    double u[2];
    five_bar_motion(NULL, t, 0, u);
    lw_vec2 b = lw_v2_add(lw_v2(3, 0), lw_v2_polar(1, u[1]));
    return meet(lw_v2_polar(1, u[0]), 2.5, b, 2.5, 1);
}

TEST(two_inputs_of_a_five_bar)
{
    lw_linkage l;
    blank_linkage(&l, 5);
    double at0 = 0.4, at1 = 2.0;                           /* drawn elsewhere than the motion begins */
    lw_vec2 a = lw_v2_polar(1, at0), b = lw_v2_add(lw_v2(3, 0), lw_v2_polar(1, at1)), c = meet(a, 2.5, b, 2.5, 1);
    add_pin(&l, 0, 1, lw_v2(0, 0));
    add_pin(&l, 0, 2, lw_v2(3, 0));
    add_pin(&l, 1, 3, a);
    add_pin(&l, 3, 4, c);
    add_pin(&l, 4, 2, b);
    add_input(&l, 0, at0);
    add_input(&l, 1, at1);
    add_tracer(&l, 3, c);
    ride *r = start(&l, five_bar_motion, NULL, -1);
    CHECK_INT(r->status, LW_OK);
    for (int i = 0; i <= 100; i++) {
        double t = i <= 50 ? 0.13*i - 1 : 0.21*(100 - i) - 1, q[4*12], h = 1e-3;   /* and back */
        lw_vec2 p[4];
        CHECK_INT(lw_prescribed_motion_to(r->d, t), LW_OK);
        CHECK_NEAR(distance(tracer(r, 0), five_bar_tip(t)), 0, 1e-13, 0);
        CHECK(residual(r) <= 2e-15);
        CHECK(lw_prescribed_motion_rates(r->d, 3, q));
        lw_system_point_series(&r->s, r->s.tracer_body[0], r->s.tracer_arm[0], 3, q, p);
        lw_vec2 f[5];
        for (int k = 0; k < 5; k++)
            f[k] = five_bar_tip(t + (k - 2)*h);
        CHECK_NEAR(p[1].x, (8*(f[3].x - f[1].x) - (f[4].x - f[0].x))/(12*h), 1e-8, 0);
        CHECK_NEAR(2*p[2].y, (16*(f[3].y + f[1].y) - (f[4].y + f[0].y) - 30*f[2].y)/(12*h*h), 1e-6, 0);
        CHECK_NEAR(6*p[3].x, (f[4].x - f[0].x - 2*(f[3].x - f[1].x))/(2*h*h*h), 1e-2, 0);
    }
    CHECK_INT(lw_prescribed_motion_crossings(r->d, NULL), 0);
    stop(r);
}

/* u = t^2 from the drawn angle */
static void square(void *context, double t, int order, double *u)
{
    const double c[3] = { *(double *)context + t*t, 2*t, 1 };
    for (int k = 0; k <= order; k++)
        u[k] = k < 3 ? c[k] : 0;
}

/* A rocker is driven to its limit: the time is told to 1e-10. */
TEST(the_time_of_a_limit)
{
    lw_rng g = check_rng(1);
    for (int trial = 0; trial < 200; trial++) {
        double k[9] = { 0 };
        lw_fourbar_class c;
        do {
            for (int i = 0; i < 4; i++)
                k[i] = lw_rng_range(&g, 0.2, 1.0);
        } while (lw_fourbar_classify(k, LW_FOURBAR_TOLERANCE, &c, NULL) != LW_OK || c.crank || c.margin < 1e-3);
        double first = c.range[0][0], last = c.range[0][1], angle = first + (last - first)*lw_rng_range(&g, 0.1, 0.9);
        lw_linkage l;
        fourbar_linkage(&l, k, trial%2 ? 1 : -1, angle);
        ride *r = start(&l, square, &angle, 0);
        CHECK_INT(r->status, LW_OK);
        CHECK_INT(lw_prescribed_motion_to(r->d, 0.5*sqrt(last - angle)), LW_OK);
        CHECK_NEAR(distance(tracer(r, 0), fourbar_at(k, trial%2 ? 1 : -1, angle + 0.25*(last - angle)).p), 0, 1e-13, 0);
        CHECK_INT(lw_prescribed_motion_to(r->d, 5), LW_OPEN);
        CHECK_NEAR(lw_prescribed_motion_time(r->d), sqrt(last - angle), 1e-11, 0);
        CHECK(residual(r) <= 1e-14);
        CHECK_INT(lw_prescribed_motion_to(r->d, 0), LW_OK);            /* and back the way it came */
        CHECK_NEAR(distance(tracer(r, 0), fourbar_at(k, trial%2 ? 1 : -1, angle).p), 0, 1e-12, 0);
        stop(r);
    }
}

static void steady(void *context, double t, int order, double *u)
{
    (void)context;
    for (int k = 0; k <= order; k++)
        u[k] = k == 0 ? 0.5 + 3*t : k == 1 ? 3 : 0;
}

/* N parallelograms in a row, through every change point straight on for two turns: the couplers never turn. */
TEST(parallelograms_go_straight_on)
{
    for (int n = 1; n <= 5; n += 2) {
        lw_linkage l;
        blank_linkage(&l, 1 + 2*n + 1);                    /* ground, cranks 1 .. n+1, couplers */
        for (int i = 0; i <= n; i++)
            add_pin(&l, 0, 1 + i, lw_v2(i, 0));
        for (int i = 0; i < n; i++) {
            lw_vec2 tip = lw_v2_polar(1, 0.5);
            add_pin(&l, 1 + i, n + 2 + i, lw_v2(tip.x + i, tip.y));
            add_pin(&l, n + 2 + i, 2 + i, lw_v2(tip.x + i + 1, tip.y));
        }
        add_input(&l, 0, 0.5);
        add_tracer(&l, n + 1, lw_v2(n + cos(0.5), sin(0.5)));
        ride *r = start(&l, steady, NULL, 0);
        CHECK_INT(r->status, LW_OK);
        double at;
        for (int i = 1; i <= 42; i++) {
            double t = 0.1*i;
            CHECK_INT(lw_prescribed_motion_to(r->d, t), LW_OK);
            CHECK_NEAR(lw_prescribed_motion_time(r->d), t, 0, 0);
            CHECK_NEAR(distance(tracer(r, 0), lw_v2_add(lw_v2(n, 0), lw_v2_polar(1, 0.5 + 3*t))), 0, 1e-11, 0);
            if (lw_prescribed_motion_crossings(r->d, &at) == 1)
                CHECK_NEAR(at, (LW_PI - 0.5)/3, 1e-10, 0);
        }
        CHECK_INT(lw_prescribed_motion_crossings(r->d, &at), 4);
        CHECK_NEAR(at, (4*LW_PI - 0.5)/3, 1e-10, 0);
        stop(r);
    }
}

static void arm_alone(void *context, double t, int order, double *u)
{
    (void)context;
    for (int k = 0; k <= order; k++)
        u[k] = k == 0 ? -t : k == 1 ? -1 : 0, u[order + 1 + k] = k == 0 ? LW_PI/2 : 0;
}

/* The lower arm and the crank of a palletiser turn about one pin, and a parallelogram carries the crank's direction to the upper arm: its arms are lost
 * where the parallelogram is flat, at pi/2, also when that lies in the last step. */
TEST(inputs_lose_a_flat_parallelogram)
{
    for (int k = 0; k < 3; k++) {
        lw_linkage l;
        double between[2], to = k == 2 ? 2.5 : k ? 1.6 : 1.5;
        blank_linkage(&l, 5);
        add_pin(&l, 0, 1, lw_v2(0, 0));
        add_pin(&l, 0, 2, lw_v2(0, 0));
        add_pin(&l, 2, 3, lw_v2(0, 0.3));
        add_pin(&l, 3, 4, lw_v2(1, 0.3));
        add_pin(&l, 1, 4, lw_v2(1, 0));
        add_input(&l, 0, 0);
        add_input(&l, 1, LW_PI/2);
        add_tracer(&l, 4, lw_v2(1, -0.5));
        ride *r = start(&l, arm_alone, NULL, 0);
        CHECK_INT(lw_prescribed_motion_to(r->d, to), LW_OK);
        char how[LW_PRESCRIBED_MOTION_TEXT];
        CHECK_INT(lw_prescribed_motion_lost(r->d, LW_VIEW(&l), between, how), k > 0);
        CHECK_TEXT(how, k ? "link \"L5\" turns about (0, -1) m" : "");       /* its pin at the end of the lower arm */
        CHECK(k == 0 || (between[0] < LW_PI/2 && between[1] > LW_PI/2));
        CHECK_NEAR(distance(tracer(r, 0), lw_v2(cos(to), -sin(to) - 0.5)), 0, 1e-11, 0);
        stop(r);
    }
}

/* Asked for at the very times of its change points, and next to them, a parallelogram is there, as fast as ever. */
TEST(stops_at_branch_points)
{
    double k[9] = { 4, 1, 4, 1, 1, 2, 0, 0, 0 }, q[4*9];
    static const double off[] = { -1e-3, -1e-8, 0, 1e-12, 1e-7, 1e-3, 0.01 };
    lw_linkage l;
    fourbar_linkage(&l, k, 1, 0.5);
    ride *r = start(&l, steady, NULL, 0);
    CHECK_INT(r->status, LW_OK);
    for (int turn = 1; turn <= 4; turn++)
        for (size_t i = 0; i < sizeof off/sizeof *off; i++) {
            double t = (turn*LW_PI - 0.5)/3 + off[i], u = 0.5 + 3*t;
            CHECK_INT(lw_prescribed_motion_to(r->d, t), LW_OK);
            CHECK_NEAR(lw_prescribed_motion_time(r->d), t, 0, 0);
            CHECK(residual(r) <= 1e-12);
            CHECK_NEAR(remainder(lw_prescribed_motion_posture(r->d)[5], 2*LW_PI), 0, 1e-11, 0);
            lw_vec2 at = lw_v2_add(fourbar_at(k, 1, 0.5).p, lw_v2_sub(lw_v2_polar(1, u), lw_v2_polar(1, 0.5)));
            CHECK_NEAR(distance(tracer(r, 0), at), 0, 1e-11, 0);
            if (i < 2)
                continue;
            CHECK(lw_prescribed_motion_rates(r->d, 3, q));              /* turns of crank and rocker */
            for (int order = 1; order <= 3; order++) {
                CHECK_NEAR(q[9*order + 2], order == 1 ? 3 : 0, 1e-4, 0);
                CHECK_NEAR(q[9*order + 8], order == 1 ? 3 : 0, 1e-4, 0);
            }
        }
    CHECK_INT(lw_prescribed_motion_crossings(r->d, NULL), 4);
    CHECK_INT(lw_prescribed_motion_to(r->d, 0), LW_OK);                 /* and back */
    CHECK_NEAR(lw_prescribed_motion_posture(r->d)[2], 0, 1e-11, 0);
    stop(r);
}

/* A boom raised by a cylinder whose ends both move: cylinder between arm and a crank that stands. */
static void stroke(void *context, double t, int order, double *u)
{
    (void)context;
    sine(0.5, 0.4, 1, 0, t, order, u);
    for (int k = 0; k <= order; k++)
        u[order + 1 + k] = k == 0 ? 0.3 + 0.2*t : k == 1 ? 0.2 : 0;
}

TEST(a_cylinder_between_moving_links)
{
    lw_linkage l;
    enum { GROUND, CRANK, BOOM, TUBE, ROD };
    lw_vec2 foot = lw_v2_polar(1, 0.3), head = { 2, 2 }, along = lw_v2_sub(head, foot);
    double length = lw_v2_norm(along);
    blank_linkage(&l, 5);
    add_pin(&l, GROUND, CRANK, lw_v2(0, 0));
    add_pin(&l, GROUND, BOOM, lw_v2(3, 0));
    add_pin(&l, CRANK, TUBE, foot);
    add_slide(&l, TUBE, ROD, foot, atan2(along.y, along.x));
    add_pin(&l, ROD, BOOM, head);
    add_input(&l, 3, 0.5);
    add_input(&l, 0, 0.3);
    add_tracer(&l, BOOM, head);
    ride *r = start(&l, stroke, NULL, 0);
    CHECK_INT(r->status, LW_OK);
    for (int i = 0; i <= 60; i++) {
        double t = 0.1*i, u[2];
        CHECK_INT(lw_prescribed_motion_to(r->d, t), LW_OK);
        stroke(NULL, t, 0, u);
        lw_vec2 pin = lw_v2_polar(1, u[1]), want = meet(pin, length + u[0] - 0.5, lw_v2(3, 0), sqrt(5), 1);
        CHECK_NEAR(distance(tracer(r, 0), want), 0, 1e-13, 0);
    }
    stop(r);
}

static int time_alone(void *context, const char *word, const char *name, char *why)
{
    (void)context;
    why[0] = 0;
    return name || strcmp(word, "t") != 0 ? -1 : 0;
}

/* The first input moves by t, the second by an expression, the third by 3 t. */
static void by_expression(void *context, double t, int order, double *u)
{
    double at[LW_SERIES_ORDER_MAX + 1] = { t, 1 };
    memset(u, 0, 3*(size_t)(order + 1)*sizeof *u);
    lw_expression_series(context, order, at, u + order + 1);
    for (int k = 0; k <= order && k < 2; k++) {
        u[k] = at[k];
        u[2*(order + 1) + k] = 3*at[k];
    }
}

/* A flat parallelogram can be driven at both pins of the ground: it has two freedoms there to first order, and one afterwards. */
TEST(inputs_of_a_flat_parallelogram_that_contradict_each_other)
{
    static const struct { const char *motion; double ends; } of[] = {
        { "t", 2 }, { "-2*atan(3*tan(t/2))", 2 },          /* parallel and crossed */
        { "2*t", 0 }, { "-t/3", 0 }, { "-3*t", 0 }, { "0*t", 0 },      /* these contradict in the second or third order */
        { "t + max(0, t - 0.53)^3", 0.53 }, { "t + max(0, t - 0.53)", 0.53 },
    };
    lw_linkage l;
    blank_linkage(&l, 5);
    add_joints(&l, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 1, 0), PIN(2, 3, 3, 0), PIN(3, 0, 2, 0), PIN(0, 4, 5, 1)));
    add_input(&l, 0, 0);
    add_input(&l, 3, 0);
    add_input(&l, 4, 0);
    for (size_t i = 0; i < sizeof of/sizeof *of; i++) {
        lw_expression *x;
        double series[4*12];
        CHECK_INT(lw_expression_parse(of[i].motion, strlen(of[i].motion), time_alone, NULL, &x, NULL), LW_OK);
        ride *r = start(&l, by_expression, x, 0);
        CHECK_INT(r->status, LW_OK);
        CHECK_INT(lw_prescribed_motion_to(r->d, 0), of[i].ends > 0 ? LW_OK : LW_E_NUMERIC);
        lw_status s = lw_prescribed_motion_to(r->d, 1.5);
        CHECK_INT(s, of[i].ends > 1.5 ? LW_OK : LW_E_NUMERIC);
        CHECK_NEAR(lw_prescribed_motion_time(r->d), fmin(of[i].ends, 1.5), 1e-4, 0);
        CHECK(residual(r) <= 2e-15);
        if (s != LW_OK) {
            lw_prescribed_motion_ended(r->d, s, LW_VIEW(&l), &r->e);
            CHECK_HAS(r->e.text, "inputs J1 and J4 contradict each other");
            if (of[i].ends > 0) {                          /* up to there it is a motion like others */
                CHECK_INT(lw_prescribed_motion_to(r->d, 0.4), LW_OK);
                CHECK(lw_prescribed_motion_rates(r->d, 3, series));
            }
        }
        stop(r);
        lw_expression_free(x);
    }
}

static void nowhere(void *context, double t, int order, double *u)
{
    (void)context;
    memset(u, 0, (size_t)(order + 1)*sizeof *u);
    u[0] = t < 1 ? 3.0 : t < 2 ? 0.5 : NAN;
}

TEST(says_what_is_wrong)
{
    double k[9] = { 4, 3, 2, 2.5, 1, 2, 0, 0, 0 };
    lw_linkage l;
    fourbar_linkage(&l, k, 1, 0.5);                         /* its limits: -1.37 and 1.37 */
    ride *r = start(&l, nowhere, NULL, 0);
    CHECK_INT(r->status, LW_OPEN);
    CHECK_HAS(r->e.text, "cannot get to where the motions begin at t = 0: it comes 34.8");
    stop(r);
    r = start(&l, nowhere, NULL, 2);
    CHECK_INT(r->status, LW_E_NUMERIC);
    CHECK_HAS(r->e.text, "input 1 is no number at t = 2");
    stop(r);
    r = start(&l, nowhere, NULL, 1.5);
    CHECK_INT(r->status, LW_OK);
    CHECK_INT(lw_prescribed_motion_to(r->d, 3), LW_E_NUMERIC);
    CHECK_INT(lw_prescribed_motion_to(r->d, INFINITY), LW_E_ARG);
    stop(r);
    l.n_input = 0;
    r = start(&l, nowhere, NULL, 0);
    CHECK_INT(r->status, LW_E_ARG);
    CHECK_HAS(r->e.text, "1 freedom but 0 inputs; drive 1 more joint");
    stop(r);
}
