/* Gear pairs in plans: postures over whole periods against the loop equations of mbs/constraints/newton.h, wheels
 * against their law, derivatives against differences. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mbs/batch/batch.h"
#include "mbs/constraints/newton.h"
#include "mbs/batch/posture.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

static const lw_plan_options all = { .tracers = 1, .all_joints = true, .kind = LW_PLAN_GEARED };

static void drive(lw_linkage *k, int joint)
{
    add_input(k, joint, 0);
    k->input[0].value = lw_linkage_posture_input(k, joint);
}

/* Wheels on the ground, joined by two bars. */
static void five_bar(lw_linkage *k, double ratio)
{
    blank_linkage(k, 5);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), GEAR(1, 2, 20, 0, ratio), PIN(0, 2, 60, 0), PIN(1, 3, 10, 10), PIN(3, 4, 30, 70),
                         PIN(4, 2, 70, 16)));
    drive(k, 0);
    add_tracer(k, 3, lw_v2(35, 85));
}

/* A sun fixed to the ground, its planet on the crank as the first of two bars, the second on the ground. */
static void planetary(lw_linkage *k, double ratio)
{
    blank_linkage(k, 5);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 20, 10), PIN(2, 3, 28, 12), PIN(3, 4, 50, 60), PIN(4, 0, 80, 5),
                         GEAR(0, 2, 10, 5, ratio)));
    drive(k, 0);
    add_tracer(k, 3, lw_v2(40, 20));
}

/* A point of the planet alone: a trochoid. */
static void trochoid(lw_linkage *k, double ratio)
{
    blank_linkage(k, 3);
    add_joints(k, JOINTS(PIN(0, 1, 2, 1), PIN(1, 2, 4, 2), GEAR(2, 0, 3, 1.5, ratio)));
    drive(k, 0);
    add_tracer(k, 2, lw_v2(4.5, 1));
}

/* A wheel on the coupler of a four-bar, turned by the crank: neither turns evenly. */
static void on_coupler(lw_linkage *k, double ratio)
{
    blank_linkage(k, 5);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 0, 20), PIN(2, 3, 40, 50), PIN(3, 0, 40, 0), PIN(2, 4, 30, 70),
                         GEAR(1, 4, 10, 30, ratio)));
    drive(k, 0);
    add_tracer(k, 4, lw_v2(36, 75));
}

/* Five bars whose crank is geared to the last bar, on the bar that carries both. */
static void floating(lw_linkage *k, double ratio)
{
    five_bar(k, ratio);
    k->joint[1].link[0] = 1;
    k->joint[1].link[1] = 4;
    k->joint[1].at = lw_v2(20, 30);
}

/* The geared five-bar, driven between crank and coupler. */
static void driven_inside(lw_linkage *k, double ratio)
{
    five_bar(k, ratio);
    k->n_input = 0;
    drive(k, 3);
}

/* Three wheels in a row on the ground, the outer ones joined by two bars. */
static void train(lw_linkage *k, double ratio)
{
    blank_linkage(k, 6);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(0, 5, 30, -10), PIN(0, 2, 60, 0), GEAR(1, 5, 10, -5, ratio), GEAR(5, 2, 40, -5, -1),
                         PIN(1, 3, 10, 10), PIN(3, 4, 30, 70), PIN(4, 2, 70, 16)));
    drive(k, 0);
    add_tracer(k, 3, lw_v2(35, 85));
}

/* Two wheels on the bars of a five-bar, one after the other: the input's crank turns the one on the first bar, which
 * turns the second bar. */
static void two_floating(lw_linkage *k, double ratio)
{
    blank_linkage(k, 6);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 3, 12, 8), PIN(3, 5, 22, 35), PIN(3, 4, 30, 70), PIN(4, 2, 70, 30), PIN(2, 0, 60, 0),
                         GEAR(1, 5, 17, 20, ratio), GEAR(5, 4, 26, 50, -1)));
    drive(k, 0);
    add_tracer(k, 4, lw_v2(45, 60));
}

/* A wheel on a carriage rolls on the ground: cycloids. */
static void rolling(lw_linkage *k, double ratio)
{
    blank_linkage(k, 3);
    add_joints(k, JOINTS(SLIDE(0, 1, 3, 2, 0.4), PIN(1, 2, 5, 4), GEAR(0, 2, 5, 3, 1/ratio)));
    add_input(k, 0, 0);
    add_tracer(k, 2, lw_v2(6, 7));
}

/* The slider of a slider-crank is a rack and turns a pinion on the ground. */
static void rack_turns(lw_linkage *k, double ratio)
{
    blank_linkage(k, 5);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 20, 15), PIN(2, 3, 80, 10), SLIDE(3, 0, 90, 10, 0.1), PIN(4, 0, 100, 30),
                         GEAR(4, 3, 100, 12, ratio)));
    drive(k, 0);
    add_tracer(k, 4, lw_v2(120, 45));
}

/* The rocker of a four-bar is the pinion of a rack, which carries the pin of two more bars. */
static void rack_moves(lw_linkage *k, double ratio)
{
    blank_linkage(k, 7);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 15, 12), PIN(2, 3, 60, 50), PIN(3, 0, 70, 0), SLIDE(0, 4, 80, -20, -0.2),
                         GEAR(3, 4, 72, -12, ratio), PIN(4, 5, 110, -26), PIN(5, 6, 130, 40), PIN(6, 3, 75, 45)));
    drive(k, 0);
    add_tracer(k, 5, lw_v2(140, 20));
}

/* A rack rolls on the ground's pinion, its guide about it, and a bar from the crank holds it. */
static void rack_floats(lw_linkage *k, double ratio)
{
    blank_linkage(k, 5);
    add_joints(k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 4, 16, 5), PIN(4, 2, 50, 60), PIN(0, 3, 80, 10), SLIDE(2, 3, 70, 40, 1.2),
                         GEAR(0, 2, 75, 30, ratio)));
    drive(k, 0);
    add_tracer(k, 4, lw_v2(35, 85));
}

/* The same driven by a cylinder between rack and guide. */
static void cylinder(lw_linkage *k, double ratio)
{
    rack_floats(k, ratio);
    k->n_input = 0;
    add_input(k, 4, 0);
}

typedef void maker(lw_linkage *k, double ratio);
static const struct { maker *make; double ratio; int input_turns_per_period, n_higher, n_rack; } cases[] = {
    { five_bar, -1, 1, 0, 0 },        { five_bar, 2, 1, 0, 0 },         { five_bar, -0.5, 2, 0, 0 },
    { five_bar, 1.0/3, 3, 0, 0 },     { five_bar, -2.0/3, 3, 0, 0 },    { planetary, -1, 1, 0, 0 },
    { planetary, 2, 1, 0, 0 },        { planetary, -0.5, 2, 0, 0 },     { planetary, 3, 1, 0, 0 },
    { trochoid, -1, 1, 0, 0 },        { trochoid, 0.5, 1, 0, 0 },       { trochoid, 3, 3, 0, 0 },
    { trochoid, -2, 2, 0, 0 },        { on_coupler, 1, 1, 0, 0 },       { on_coupler, -2, 1, 0, 0 },
    { on_coupler, 3, 1, 0, 0 },       { on_coupler, 0.5, 2, 1, 0 },     { on_coupler, -2.0/3, 3, 1, 0 },
    { floating, -1, 1, 1, 0 },        { floating, 2, 1, 1, 0 },         { floating, -0.5, 2, 1, 0 },
    { driven_inside, -1, 1, 1, 0 },   { driven_inside, 1.5, 6, 1, 0 },  { train, -1, 1, 0, 0 },
    { train, -0.5, 2, 0, 0 },         { two_floating, -1, 1, 1, 0 },    { two_floating, 2, 1, 1, 0 },
    { two_floating, 0.5, 2, 1, 0 },   { rolling, 2, 1, 0, 1 },          { rack_turns, 18, 1, 0, 1 },
    { rack_turns, -25, 1, 0, 1 },     { rack_moves, 12, 1, 0, 1 },      { rack_moves, -9, 1, 0, 1 },
    { rack_floats, 14, 1, 1, 1 },     { rack_floats, -21, 1, 1, 1 },    { cylinder, 17, 1, 1, 1 },
};
enum { CASES = sizeof cases/sizeof *cases };

typedef struct planned { lw_linkage k; lw_plan plan; double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input; } planned;

static bool plan_case(int i, planned *p)
{
    lw_error e = { .text = "" };
    cases[i].make(&p->k, cases[i].ratio);
    bool good = lw_plan_make(&p->k, all, &p->plan, &e) == LW_OK
             && lw_plan_read(&p->plan, &p->k, p->dim, p->mode, &p->input, &e) == LW_OK;
    if (!good)
        printf("case %d: %s\n", i, e.text);
    CHECK(good);
    return good;
}

TEST(turns_as_the_loop_equations)
{
    for (int i = 0; i < CASES; i++) {
        planned p;
        lw_newton *n;
        lw_posture posture;
        if (!plan_case(i, &p))
            continue;
        CHECK_INT(p.plan.input_turns_per_period, cases[i].input_turns_per_period);
        CHECK_INT(p.plan.n_higher, cases[i].n_higher);
        CHECK_INT(p.plan.n_rack, cases[i].n_rack);
        lw_error why = { .text = "" };
        if (lw_newton_create(&p.k, &n, &why) != LW_OK) {
            CHECK_TEXT(why.text, "");
            printf("case %d\n", i);
            continue;
        }
        double before = p.k.input[0].value, reached, way = p.plan.input_is_slider ? 20 : 2*LW_PI;
        int far = 0;
        for (int s = 0; s <= 48; s++) {
            double turn = way*s/48;
            if (lw_posture_solve(&p.plan, p.dim, p.mode, p.input + turn, 0, &posture) != LW_OK)
                break;                                           /* some rock: up to their limit    */
            far = s;
            CHECK(lw_newton_move(n, before + p.plan.input_turns_per_period*turn, &reached) == LW_OK);
            lw_vec2 at = lw_newton_tracer(n, 0);
            CHECK_POINT(posture.tracer[0][0], at.x, at.y, 1e-9, 1e-9);
        }
        if (far < 48) {                                          /* so does the second opinion      */
            lw_status end = lw_newton_move(n, before + p.plan.input_turns_per_period*way*(far + 1)/48, &reached);
            CHECK_INT(end, LW_OPEN);
        }
        if (far == 48 && !p.plan.input_is_slider)
            CHECK_NEAR(posture.tracer[0][0].x, p.k.tracer[0].at.x, 1e-9, 1e-9); /* it comes back    */
        lw_newton_free(n);
    }
}

/* The same mechanisms with their joints elsewhere, at random: a way of 1 rad in small steps, until a limit or where the
 * posture is near one. */
TEST(random_ones_too)
{
    int compared = 0;
    lw_rng r = check_rng(3);
    for (int trial = 0; trial < 8*CASES; trial++) {
        planned p;
        lw_posture posture;
        lw_newton *n;
        int i = trial % CASES;
        cases[i].make(&p.k, cases[i].ratio);
        for (int j = 0; j < p.k.n_joint; j++)
            p.k.joint[j].at = lw_v2_add(p.k.joint[j].at, lw_v2(lw_rng_range(&r, -12, 12), lw_rng_range(&r, -12, 12)));
        p.k.input[0].value = lw_linkage_posture_input(&p.k, p.k.input[0].joint);
        bool good = lw_plan_make(&p.k, all, &p.plan, NULL) == LW_OK
                 && lw_plan_read(&p.plan, &p.k, p.dim, p.mode, &p.input, NULL) == LW_OK;
        CHECK(good);
        if (!good || lw_newton_create(&p.k, &n, NULL) != LW_OK)
            continue;
        for (int s = -10; s <= 10; s++) {
            double turn = (p.plan.input_is_slider ? 1 : 0.1/p.plan.input_turns_per_period)*s;
            lw_newton_reset(n);
            double reached, from = p.k.input[0].value, ratio = p.plan.input_turns_per_period;
            bool there = lw_newton_move(n, from + ratio*turn, &reached) == LW_OK;
            if (lw_posture_solve(&p.plan, p.dim, p.mode, p.input + turn, 0, &posture) != LW_OK || posture.margin < 1e-4)
                continue;
            if (!there) {                                    /* beyond a gap, narrower than the step */
                lw_posture_solve(&p.plan, p.dim, p.mode, p.input + (reached - from)/ratio, 0, &posture);
                CHECK_NEAR(posture.margin, 0, 1e-9, 0);
                continue;
            }
            CHECK_NEAR(lw_v2_norm(lw_v2_sub(posture.tracer[0][0], lw_newton_tracer(n, 0))), 0, 1e-9/posture.margin, 0);
            compared++;
        }
        lw_newton_free(n);
    }
    printf("# %d postures of %d\n", compared, 21*8*CASES);
    CHECK(compared > 21*8*CASES/2);
}

/* Written at another input, the linkage is the same one: read back it has the same dimensions, and its wheels touch at
 * the pitch point. */
TEST(a_posture_elsewhere_is_the_same_linkage)
{
    int written = 0;
    for (int i = 0; i < CASES; i++) {
        planned p;
        if (!plan_case(i, &p))
            continue;
        for (double turn = -0.3; turn < 0.35; turn += 0.3) {
            lw_linkage there = p.k;
            double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
            lw_gear g;
            if (lw_plan_write(&p.plan, p.dim, p.mode, p.input + turn, &there) != LW_OK)
                continue;                                        /* beyond a limit                   */
            written++;
            double moved = p.plan.input_turns_per_period*turn;
            CHECK_NEAR(remainder(there.input[0].value - p.k.input[0].value - moved, 2*LW_PI), 0, 1e-12, 0);
            for (int j = 0; j < there.n_joint; j++)
                if (there.joint[j].kind == LW_JOINT_GEAR) {
                    CHECK(lw_linkage_gear(&there, j, &g, NULL) == LW_OK);
                    CHECK_NEAR(lw_v2_norm(lw_v2_sub(lw_gear_contact(there.joint, j, &g), there.joint[j].at)), 0, 1e-9, 0);
                }
            CHECK(lw_plan_read(&p.plan, &there, dim, mode, &input, NULL) == LW_OK);
            for (int s = 0; s < 5; s++) {
                lw_posture a, b;
                double on = 0.01*s;
                lw_posture_solve(&p.plan, p.dim, p.mode, p.input + turn + on, 0, &a);
                lw_posture_solve(&p.plan, dim, mode, input + on, 0, &b);
                if (a.margin < 1e-3)
                    break;                                       /* as above                         */
                CHECK_POINT(a.tracer[0][0], b.tracer[0][0].x, b.tracer[0][0].y, 1e-9, 0);
            }
        }
    }
    CHECK(written > 5*CASES/2);
}

/* Turns of wheels against their carrier are in the ratio of the file. */
TEST(wheels_turn_by_their_ratio)
{
    for (int i = 0; i < CASES; i++) {
        planned p;
        lw_posture a;
        lw_gear g;
        if (!plan_case(i, &p))
            continue;
        lw_posture_solve(&p.plan, p.dim, p.mode, p.input, 1, &a);
        for (int j = 0; j < p.k.n_joint; j++)
            if (p.k.joint[j].kind == LW_JOINT_GEAR) {
                const int *link = p.k.joint[j].link;
                CHECK(lw_linkage_gear(&p.k, j, &g, NULL) == LW_OK);
                if (p.plan.n_rack > 0)
                    continue;
                double ratio = p.k.joint[j].ratio, c = a.angle[g.carrier][1];
                CHECK_NEAR(a.angle[link[1]][1] - c, ratio*(a.angle[link[0]][1] - c), 1e-11, 1e-11);
            }
    }
}

/* Rates by the input, and Jacobians by all dimensions, phases among them, against central differences. */
TEST(derivatives_are_differences)
{
    enum { N = 9 };
    const double h = 1e-5;
    int compared = 0;
    for (int i = 0; i < CASES; i++) {
        planned p;
        double c[N], s[N], row[13][N], jx[LW_DIM_MAX*N], jy[LW_DIM_MAX*N], jt[LW_DIM_MAX*N];
        if (!plan_case(i, &p))
            continue;
        for (int k = 0; k < N; k++) {
            double t = p.input + 0.02*k;
            c[k] = p.plan.input_is_slider ? t : cos(t);
            s[k] = p.plan.input_is_slider ? 0 : sin(t);
        }
        FREED void *work = aligned_alloc(64, (lw_batch_work_size(&p.plan) + 63)/64*64 + 64);
        lw_lanes in = { .n = N, .c = c, .s = s, .dim = p.dim, .mode = p.mode };
        lw_jacobian out = { row[0], row[1], row[2], row[3], row[4], jx, jy, jt, row[5], row[6], row[7], N, NULL, NULL };
        lw_batch_jacobian(&p.plan, &in, 0, work, &out);
        for (int k = 0; k < N; k++) {
            lw_posture posture;
            lw_posture_solve(&p.plan, p.dim, p.mode, p.input + 0.02*k, 3, &posture);
            if (!(row[4][k] > 0.05))
                continue;                                        /* differences are none near limits */
            compared++;
            CHECK_NEAR(row[0][k], posture.tracer[0][0].x, 1e-11, 1e-12);
            CHECK_NEAR(row[1][k], posture.tracer[0][0].y, 1e-11, 1e-12);
            CHECK_NEAR(row[5][k], posture.tracer[0][1].x, 1e-9, 1e-10);
            CHECK_NEAR(row[6][k], posture.tracer[0][1].y, 1e-9, 1e-10);
            lw_posture up, down;
            lw_posture_solve(&p.plan, p.dim, p.mode, p.input + 0.02*k + h, 2, &up);
            lw_posture_solve(&p.plan, p.dim, p.mode, p.input + 0.02*k - h, 2, &down);
            CHECK_NEAR(posture.tracer[0][1].x, (up.tracer[0][0].x - down.tracer[0][0].x)/(2*h), 1e-5, 1e-6);
            CHECK_NEAR(posture.tracer[0][3].y, (up.tracer[0][2].y - down.tracer[0][2].y)/(2*h), 1e-3, 1e-5);
        }
        for (int d = 0; d < p.plan.n_dim; d++) {
            double keep = p.dim[d], x[2][N], y[2][N], u[2][N], v[2][N], step = h*fmax(1, fabs(keep));
            for (int up = 0; up < 2; up++) {
                p.dim[d] = keep + (up ? step : -step);
                lw_batch_point(&p.plan, &in, 0, work, x[up], y[up], u[up], v[up], NULL);
            }
            p.dim[d] = keep;
            for (int k = 0; k < N; k++) {
                if (!(row[4][k] > 0.05))
                    continue;
                CHECK_NEAR(jx[d*N + k], (x[1][k] - x[0][k])/(2*step), 1e-5, 1e-6);
                CHECK_NEAR(jy[d*N + k], (y[1][k] - y[0][k])/(2*step), 1e-5, 1e-6);
                double turn = atan2(u[0][k]*v[1][k] - v[0][k]*u[1][k], u[0][k]*u[1][k] + v[0][k]*v[1][k]);
                CHECK_NEAR(jt[d*N + k], turn/(2*step), 1e-6, 1e-6);
            }
        }
    }
    CHECK(compared > 3*CASES*N/4);
}

TEST(each_lane_its_own_dimensions)
{
    enum { N = 11 };
    for (int i = 0; i < CASES; i++) {
        planned p;
        double c[N], s[N], x[N], y[N], x0[N], y0[N], margin[N], dim[LW_DIM_MAX*N];
        if (!plan_case(i, &p))
            continue;
        FREED void *work = aligned_alloc(64, (lw_batch_work_size(&p.plan) + 63)/64*64 + 64);
        for (int k = 0; k < N; k++) {
            double t = p.input + 0.01*k;
            c[k] = p.plan.input_is_slider ? t : cos(t);
            s[k] = p.plan.input_is_slider ? 0 : sin(t);
            for (int d = 0; d < p.plan.n_dim; d++)
                dim[d*N + k] = p.dim[d];
        }
        lw_lanes in = { .n = N, .c = c, .s = s, .dim = p.dim, .mode = p.mode }, each = in;
        each.dim = dim;
        each.dim_stride = N;
        lw_batch_point(&p.plan, &in, 0, work, x0, y0, NULL, NULL, margin);
        lw_batch_point(&p.plan, &each, 0, work, x, y, NULL, NULL, NULL);
        for (int k = 0; k < N; k++) {
            if (p.plan.n_higher > 0 && margin[k] < 1e-3)         /* beyond a limit they stand before it       */
                continue;
            CHECK(p.plan.n_higher > 0 || (x[k] == x0[k] && y[k] == y0[k]));
            CHECK_NEAR(x[k], x0[k], 1e-10, 0);
            CHECK_NEAR(y[k], y0[k], 1e-10, 0);
        }
    }
}

TEST(what_cannot_be_planned_says_why)
{
    lw_linkage k;
    lw_plan plan;
    lw_error e;
    five_bar(&k, -0.5);
    CHECK(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true, .kind = LW_PLAN_HIGHER }, &plan,
                       &e) == LW_E_KIND);
    CHECK_HAS(e.text, "of kind 'g'");
    five_bar(&k, -sqrt(2));
    CHECK(lw_plan_make(&k, all, &plan, &e) == LW_E_KIND);
    CHECK_HAS(e.text, "ratios of whole numbers");
    train(&k, 1.0/5);                                          /* a fifth of a fifth                           */
    k.joint[4].ratio = 1.0/5;
    CHECK(lw_plan_make(&k, all, &plan, &e) == LW_E_KIND);
    CHECK_HAS(e.text, "more than 24 turns of the input");
    five_bar(&k, -1);                                          /* wheels without a link in common              */
    k.joint[1].link[1] = 3;
    CHECK(lw_plan_make(&k, all, &plan, &e) == LW_E_KIND);
}

TEST(explained)
{
    planned p;
    char text[2000];
    if (!plan_case(0, &p))
        return;
    lw_plan_explain(&p.plan, &p.k, text, sizeof text);
    CHECK_HAS(text, "turned by gear \"J2\"");
    CHECK_HAS(text, "dyad RRR in closed form");
    CHECK_HAS(text, "nothing is left out");
}
