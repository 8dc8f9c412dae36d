/* Searches of mechanisms with gears: the curve of each is found again from its topology alone, to rounding, and the
 * report, which simulates it from its file, agrees. */
#include "grammar/linkage/linkage.h"
#include "mbs/batch/posture.h"
#include "mbs/constraints/newton.h"
#include "optimise/search/random_linkage.h"
#include "optimise/topology/staged_search.h"
#include "tests/check.h"
#include "tests/mbs_linkage.h"

enum { STATIONS = 36 };

static void drive(lw_linkage *k, int joint)
{
    add_input(k, joint, 0);
    k->input[0].value = lw_linkage_posture_input(k, joint);
}

/* Wheels on the ground in the ratio -1/2, two bars: comes back after two turns. */
static lw_linkage geared_five_bar(void)
{
    lw_linkage k;
    blank_linkage(&k, 5);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), GEAR(1, 2, 2, 0, -0.5), PIN(0, 2, 3, 0), PIN(1, 3, 0.6, 0.8), PIN(3, 4, 1.4, 3.5),
                          PIN(4, 2, 3.5, 0.8)));
    drive(&k, 0);
    add_tracer(&k, 3, lw_v2(1.8, 2.9));
    return k;
}

/* A slider-crank pushes a carriage whose wheel rolls on the ground. */
static lw_linkage rolling_carriage(void)
{
    lw_linkage k;
    blank_linkage(&k, 5);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 0.8, 0.6), PIN(2, 3, 3.2, 0.4), SLIDE(0, 3, 3.2, 0.4, 0.1), PIN(3, 4, 3.4, 1),
                          GEAR(0, 4, 3.4, 0.4, 1/0.65)));
    drive(&k, 0);
    add_tracer(&k, 4, lw_v2(3.8, 1.5));
    return k;
}

/* Two gear pairs, one behind the other, and two bars. */
static lw_linkage wheel_train(void)
{
    lw_linkage k;
    blank_linkage(&k, 6);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(0, 5, 1.5, -0.5), PIN(0, 2, 3, 0), GEAR(1, 5, 0.5, -0.2, 2), GEAR(5, 2, 2, -0.2, -1),
                          PIN(1, 3, 0.6, 0.8), PIN(3, 4, 1.4, 3.5), PIN(4, 2, 3.4, 0.5)));
    drive(&k, 0);
    add_tracer(&k, 3, lw_v2(1.8, 2.9));
    return k;
}

/* A wheel on the coupler of a four-bar, turned by the crank at half its turns against the coupler: neither turns evenly,
 * so that the wheel is a group of its own, followed over two turns. */
static lw_linkage half_on_coupler(void)
{
    lw_linkage k;
    blank_linkage(&k, 5);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 0.6, 0.8), PIN(2, 3, 2.6, 2.1), PIN(3, 0, 3, 0), PIN(2, 4, 1.5, 2.4),
                          GEAR(1, 4, 1, 1.4, 0.5)));
    drive(&k, 0);
    add_tracer(&k, 4, lw_v2(2, 2.8));
    return k;
}

/* The rocker of a four-bar is a pinion; its rack slides on the ground and carries, by a pin, the wheel of a second rack,
 * which is cut into the ground: the rack's way turns it. */
static lw_linkage rocker_moves_rack(void)
{
    lw_linkage k;
    blank_linkage(&k, 6);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), PIN(1, 2, 0.6, 0.8), PIN(2, 3, 2.6, 2.1), PIN(3, 0, 3, 0), SLIDE(0, 4, 4, -1, 0.2),
                          GEAR(3, 4, 3, -0.9, 0.9), PIN(4, 5, 4.5, -0.5), GEAR(0, 5, 4.5, -1, 1/0.7)));
    drive(&k, 0);
    add_tracer(&k, 5, lw_v2(5, 0.2));
    return k;
}

/* Stations at equal steps of as many turns of the input as bring all back, with their input angles. */
static int make_target(const lw_linkage *k, lw_target *t)
{
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input, x[STATIONS], y[STATIONS], angle[STATIONS];
    lw_error e = { .text = "" };
    CHECK_INT(lw_plan_make(k, (lw_plan_options){ .tracers = 1, .all_joints = true, .kind = LW_PLAN_GEARED }, &plan, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    CHECK_INT(lw_plan_read(&plan, k, dim, mode, &input, NULL), LW_OK);
    for (int i = 0; i < STATIONS; i++) {
        lw_posture posture;
        double turn = 2*LW_PI*i/STATIONS;
        CHECK_INT(lw_posture_solve(&plan, dim, mode, input + turn, 0, &posture), LW_OK);
        angle[i] = turn*plan.input_turns_per_period;
        x[i] = posture.tracer[0][0].x;
        y[i] = posture.tracer[0][0].y;
    }
    CHECK_INT(lw_target_make(STATIONS, x, y, NULL, angle, NULL, 1, t, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    return plan.input_turns_per_period;
}

static void found_again(lw_linkage k, int input_turns_per_period, long budget)
{
    lw_family f = { .name = "geared", .linkage = &k, .links = k.n_link };
    lw_search_stage stage[] = { { .links = k.n_link, .families = lw_families_of(&f, 1) } };
    lw_fit_options o = lw_fit_options_default();
    OWN(lw_target) t = { 0 };
    OWN(lw_staged_search) s = { 0 };
    lw_error e = { .text = "" };
    CHECK_INT(make_target(&k, &t), input_turns_per_period);
    o.spec.timing = LW_TIMING_PRESCRIBED;
    o.max_rounds = 40;
    o.budget = budget;
    o.n_result = 3;
    CHECK_INT(lw_staged_search_run(&t, &o, stage, 1, &s, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    CHECK(s.fit.n > 0 && s.fit.candidate[0].objective < 1e-18);
    printf("# %s %g, %ld evaluations\n", k.name, s.fit.n ? s.fit.candidate[0].objective : NAN, s.fit.evals);
    FREED lw_fit_report *r = malloc(sizeof *r);
    if (s.fit.n > 0) {
        CHECK_INT(lw_fit_report_make(&t, &o.spec, &s.fit.candidate[0], r, &e), LW_OK);
        CHECK(r->verified && r->error_max < 1e-8);
        CHECK_TEXT(r->fault, "");
        CHECK_INT(r->input_turns_per_period, input_turns_per_period);
    }
}

TEST(over_two_turns) { found_again(geared_five_bar(), 2, 1000000); }
TEST(a_rack_turns_its_pinion) { found_again(rolling_carriage(), 1, 1000000); }
TEST(a_pinion_moves_its_rack) { found_again(rocker_moves_rack(), 1, 1000000); }
TEST(two_gear_pairs) { found_again(wheel_train(), 1, 1000000); }
TEST(a_gear_in_a_group) { found_again(half_on_coupler(), 2, 1000000); }

/* Five bars whose crank is geared to the last bar, on the bar that carries both. */
static lw_linkage floating(void)
{
    lw_linkage k;
    blank_linkage(&k, 5);
    add_joints(&k, JOINTS(PIN(0, 1, 0, 0), GEAR(1, 4, 1, 1.5, 2), PIN(0, 2, 3, 0), PIN(1, 3, 0.6, 0.8), PIN(3, 4, 1.4, 3.5),
                          PIN(4, 2, 3.5, 0.8)));
    drive(&k, 0);
    add_tracer(&k, 3, lw_v2(1.8, 2.9));
    return k;
}

/* Does the linkage of these dimensions come back after a turn of the plan's input, by its loop equations? */
static bool comes_back(const lw_problem *p, const lw_linkage *topology, const double *shape)
{
    lw_linkage k = *topology;
    lw_plan plan;
    lw_newton *n;
    CHECK_INT(lw_plan_make(topology, (lw_plan_options){ .tracers = 1, .all_joints = true, .kind = LW_PLAN_GEARED }, &plan, NULL), LW_OK);
    double seed = p->intended.mode[plan.n_mode - 1];
    if (lw_plan_write(&plan, shape, p->intended.mode, seed, &k) != LW_OK || lw_newton_create(&k, &n, NULL) != LW_OK)
        return false;
    lw_vec2 from = lw_newton_tracer(n, 0);
    bool ok = lw_newton_move(n, lw_newton_input(n) + 2*LW_PI*plan.input_turns_per_period, NULL) == LW_OK
           && lw_v2_norm(lw_v2_sub(lw_newton_tracer(n, 0), from)) < 1e-6*lw_plan_size(&plan, shape);
    lw_newton_free(n);
    return ok;
}

/* Members that are drawn to turn fully are at the same place afterwards. */
TEST(members_come_back)
{
    const lw_linkage of[2] = { half_on_coupler(), floating() };
    for (int i = 0; i < 2; i++) {
        lw_family f = { .name = "geared", .linkage = &of[i], .links = 5 };
        lw_fit_spec spec = lw_fit_spec_default();
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        int drawn = 0, back = 0;
        make_target(&of[0], &t);
        spec.timing = LW_TIMING_PRESCRIBED;
        CHECK_INT(lw_problem_make(&t, &spec, &f, 1, 1, &p, NULL), LW_OK);
        FREED void *work = aligned_alloc(64, (lw_problem_work_size(&p) + 127) & ~(size_t)63);
        lw_problem_work_init(&p, work);
        lw_rng rng = check_rng((uint64_t)i);
        for (int trial = 0; trial < 150; trial++) {
            double u[LW_RANDOM_LINKAGE_DRAW_MAX], shape[LW_VAR_MAX];
            for (int d = 0; d < LW_RANDOM_LINKAGE_DRAW_MAX; d++)
                u[d] = lw_rng_uniform(&rng);
            if (!lw_random_linkage_draw(&p, u, true, shape, work))
                continue;
            drawn++;
            back += comes_back(&p, &of[i], shape);
        }
        printf("# %d members, %d come back\n", drawn, back);
        CHECK(drawn > 20);
        CHECK(back >= drawn - drawn/50);             /* what opens between two of the 64 inputs looked at */
    }
}
