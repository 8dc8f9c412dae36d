/* A motion as conditions see it, against brute force on random four-bars. */
#include "optimise/task/motion_limits.h"
#include "tests/fit_problem.h"

static lw_rng rng;

static double pin_depth(const lw_zone *z, const lw_posture *posture, const lw_plan *plan)
{
    double most = 0;
    for (int j = 0; j < LW_JOINT_MAX; j++)
        if (plan->joint_point[j] >= 0)
            most = fmax(most, z->reach - lw_v2_norm(lw_v2_sub(posture->joint[j][0], z->at)));
    return fmax(most, z->reach - lw_v2_norm(lw_v2_sub(posture->tracer[0][0], z->at)));
}

TEST(a_turn_is_that_of_its_postures)
{
    for (int trial = 0; trial < 30; trial++) {
        enum { LOOKS = 360 };
        member m;
        lw_posture posture;
        lw_fit_spec s = lw_fit_spec_default();
        double least = INFINITY, most = 0, fast = 0, deep = 0;
        draw_member("crank-rocker", 1, false, &rng, &m);
        CHECK_INT(lw_posture_solve(&m.plan, m.dim, &m.mode, 1, 0, &posture), LW_OK);
        s.n_zone = 1;
        s.zone[0] = (lw_zone){ .kind = LW_ZONE_NO_CIRCLE, .at = lw_v2_add(posture.tracer[0][0], lw_v2(0.2, 0)), .to = { 0, 0 }, .reach = 0.3 };
        for (int k = 0; k <= LOOKS; k++) {
            lw_posture a, b;
            const double h = 1e-4;
            double at = 2*LW_PI*k/LOOKS;
            lw_posture_solve(&m.plan, m.dim, &m.mode, at, 0, &posture);
            lw_posture_solve(&m.plan, m.dim, &m.mode, at - h, 0, &a);
            lw_posture_solve(&m.plan, m.dim, &m.mode, at + h, 0, &b);
            lw_vec2 second = lw_v2_sub(lw_v2_add(a.tracer[0][0], b.tracer[0][0]), lw_v2_scale(posture.tracer[0][0], 2));
            least = fmin(least, posture.margin);
            most = fmax(most, posture.margin);
            fast = fmax(fast, lw_v2_norm(second)/h/h);
            deep = fmax(deep, pin_depth(&s.zone[0], &posture, &m.plan));
        }
        lw_motion_limits w = lw_motion_limits_begin();
        lw_motion_limits_run(&m.plan, &s, m.dim, &m.mode, 0, 2*LW_PI, LOOKS, &w);
        CHECK_NEAR(w.margin_least, least, 1e-14, 0);
        CHECK_NEAR(w.margin_most, most, 1e-14, 0);
        CHECK_NEAR(w.acceleration, fast, 1e-5, 1e-5);
        CHECK_NEAR(w.intrusion, deep, 1e-12, 0);
        CHECK(w.intrusion > 0.05);
    }
}

/* The second derivative of the output angle by the input, without its sign. */
static double output_acceleration(const member *m, double at)
{
    const double h = 1e-4;
    lw_posture a, b, c;
    lw_posture_solve(&m->plan, m->dim, &m->mode, at - h, 0, &a);
    lw_posture_solve(&m->plan, m->dim, &m->mode, at, 0, &b);
    lw_posture_solve(&m->plan, m->dim, &m->mode, at + h, 0, &c);
    double up = remainder(c.angle[3][0] - b.angle[3][0], 2*LW_PI), down = remainder(b.angle[3][0] - a.angle[3][0], 2*LW_PI);
    return fabs(up - down)/h/h;
}

/* Of a function the acceleration is the output angle's, and its condition in a fit is of the same. */
TEST(a_function_is_judged_by_its_output)
{
    for (int trial = 0; trial < 30; trial++) {
        enum { LOOKS = 64, BETWEEN = 64 };
        member m;
        stations st;
        OWN(lw_target) t = { 0 };
        OWN(lw_problem) p = { 0 };
        lw_fit_spec s = lw_fit_spec_default();
        double x[LW_VAR_MAX] = { 0 }, g[4*LW_CURVE_SAMPLES + LW_LINEAR_MAX], look[LOOKS], fast = 0, peak = 0, least = INFINITY;
        s.task = LW_TASK_FUNCTION;
        s.timing = LW_TIMING_PRESCRIBED;
        draw_member("crank-rocker", 1, true, &rng, &m);
        trace_member(&m, 12, &st);
        for (int k = 0; k < LOOKS; k++) {
            look[k] = output_acceleration(&m, 2*LW_PI*k/LOOKS);
            fast = fmax(fast, look[k]);
        }
        for (int k = 0; k < LOOKS; k++)                          /* the condition looks for peaks between its samples  */
            for (int i = -BETWEEN; i <= BETWEEN && look[k] >= fmax(look[(k + 1) % LOOKS], look[(k + LOOKS - 1) % LOOKS]); i++)
                peak = fmax(peak, output_acceleration(&m, 2*LW_PI*(k + (double)i/BETWEEN)/LOOKS));
        lw_motion_limits w = lw_motion_limits_begin();
        lw_motion_limits_run(&m.plan, &s, m.dim, &m.mode, 0, 2*LW_PI, LOOKS, &w);
        CHECK_NEAR(w.acceleration, fast, 1e-5, 1e-5);
        s.max_acceleration = 0.9*fast;
        target_of(&st, &s, &t);
        CHECK_INT(lw_problem_make(&t, &s, m.family, m.mode, 1, &p, NULL), LW_OK);
        variables_of(&p, &m, x);
        x[0] = m.dim[0];
        FREED void *work = new_work(&p);
        lw_problem_constraints(&p, x, g, NULL, work);
        for (size_t i = (size_t)p.n_linear; i < lw_problem_constraint_count(&p); i++)
            least = fmin(least, g[i]);
        CHECK_NEAR(least, 1 - pow(peak/s.max_acceleration, 2), 1e-3, 0);
    }
}

TEST(every_condition_is_asked)
{
    static const lw_motion_limits good = { .margin_least = 0.5, .margin_most = 0.9, .acceleration = 2 };
    char why[160] = "";
    lw_linkage k;
    lw_fit_spec s = lw_fit_spec_default();
    lw_type_linkage(lw_type_find("RRRR"), &k);
    k.joint[0].at = lw_v2(1, 1);
    k.joint[3].at = lw_v2(3, 1.5);
    CHECK(lw_motion_limits_meets(&good, &s, &k, 1, why, sizeof why) && !why[0]);
    s.min_transmission = asin(sqrt(0.5)) - 1e-6;
    s.max_acceleration = 2;
    s.n_zone = 1;
    s.zone[0] = (lw_zone){ .kind = LW_ZONE_PIVOTS_BOX, .at = { 0, 0 }, .to = { 3, 2 }, .reach = 0 };
    CHECK(lw_motion_limits_meets(&good, &s, &k, 1, why, sizeof why) && !why[0]);
    lw_motion_limits bad[3] = { good, good, good };
    bad[0].margin_least = 0.4;
    bad[1].acceleration = 2.1;
    bad[2].intrusion = 0.1;
    static const char *const words[] = { "transmission", "acceleration", "forbidden" };
    for (int i = 0; i < 3; i++) {
        CHECK(!lw_motion_limits_meets(&bad[i], &s, &k, 1, why, sizeof why));
        CHECK_HAS(why, words[i]);
    }
    s.zone[0].to.x = 2.9;
    CHECK(!lw_motion_limits_meets(&good, &s, &k, 1, why, sizeof why) && strstr(why, "pivot"));
    s.zone[0] = (lw_zone){ .kind = LW_ZONE_PIVOTS_LINE, .at = { 0, 1 }, .to = { 1, 0 }, .reach = 0.5 };
    CHECK(lw_motion_limits_meets(&good, &s, &k, 1, NULL, 0));
    s.zone[0].reach = 0.4;
    CHECK(!lw_motion_limits_meets(&good, &s, &k, 1, NULL, 0));
    lw_motion_limits none = lw_motion_limits_begin();
    CHECK(!lw_motion_limits_meets(&none, &s, &k, 1, NULL, 0));
}

CHECK_MAIN
{
    lw_rng_seed(&rng, check_seed(), 1);
    check_run();
    return check_end();
}
