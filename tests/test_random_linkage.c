/* Members of a family of any linkage: they close where they say, by a simulation that shares nothing with the
 * drawing; f of such a family has the derivatives it claims. */
#include "mbs/batch/posture.h"
#include "mbs/constraints/newton.h"
#include "optimise/problem/family.h"
#include "optimise/search/random_linkage.h"
#include "tests/six_bar.h"

static void *make_problem(const lw_family *f, const lw_linkage *k, lw_timing timing, bool turn, lw_problem *p)
{
    OWN(lw_target) t = { 0 };
    lw_error e = { .text = "" };
    lw_fit_spec spec = lw_fit_spec_default();
    spec.timing = timing;
    spec.crank_only = turn;
    six_bar_target(k, 14, timing == LW_TIMING_PRESCRIBED, &t);
    CHECK_INT(lw_problem_make(&t, &spec, f, 1, 1, p, &e), LW_OK);
    void *work = aligned_alloc(64, (lw_problem_work_size(p) + 127) & ~(size_t)63);
    lw_problem_work_init(p, work);
    return work;
}

/* Move the posture by Newton's method through its range; returns whether it got there. */
static bool newton_goes(const lw_problem *p, const lw_linkage *topology, const double *shape, double from, double to)
{
    lw_linkage k = *topology;
    lw_plan plan;
    lw_newton *n;
    lw_error e = { .text = "" };
    CHECK_INT(lw_plan_make(topology, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
    if (lw_plan_write(&plan, shape, p->intended.mode, from, &k) != LW_OK || lw_newton_create(&k, &n, &e) != LW_OK)
        return false;
    bool ok = lw_newton_move(n, lw_newton_input(n) + to - from, NULL) == LW_OK;
    lw_newton_free(n);
    return ok;
}

TEST(members_close_where_they_say)
{
    lw_linkage k = six_bar();
    lw_family f = { .name = "six-bar", .linkage = &k, .links = 6 };
    OWN(lw_problem) p = { 0 };
    FREED void *work = make_problem(&f, &k, LW_TIMING_FREE, false, &p);
    int turns = 0, rocks = 0, arrived = 0, drawn = 0;
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 300; trial++) {
        double u[LW_RANDOM_LINKAGE_DRAW_MAX], shape[LW_VAR_MAX];
        for (int i = 0; i < LW_RANDOM_LINKAGE_DRAW_MAX; i++)
            u[i] = lw_rng_uniform(&rng);
        if (!lw_random_linkage_draw(&p, u, false, shape, work))
            continue;
        drawn++;
        turns += p.intended.turns;
        rocks += !p.intended.turns;
        double from = p.intended.turns ? 0 : p.intended.mid - p.intended.half;
        arrived += newton_goes(&p, &k, shape, from, p.intended.turns ? 2*LW_PI : p.intended.mid + p.intended.half);
    }
    CHECK(drawn > 240 && turns > 90 && rocks > 60);
    CHECK(arrived >= drawn - drawn/50);      /* what opens between two of the 64 inputs looked at      */
}

TEST(the_crank_turns_when_it_must)
{
    lw_linkage k = six_bar();
    lw_family f = { .name = "six-bar", .linkage = &k, .links = 6 };
    OWN(lw_problem) p = { 0 };
    FREED void *work = make_problem(&f, &k, LW_TIMING_FREE, true, &p);
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 100; trial++) {
        double u[LW_RANDOM_LINKAGE_DRAW_MAX], shape[LW_VAR_MAX];
        for (int i = 0; i < LW_RANDOM_LINKAGE_DRAW_MAX; i++)
            u[i] = lw_rng_uniform(&rng);
        CHECK(lw_random_linkage_draw(&p, u, true, shape, work) && p.intended.turns);
    }
}

TEST(the_posture_is_a_start)
{
    lw_linkage k = six_bar();
    lw_family f = { .name = "six-bar", .linkage = &k, .posture = true, .links = 6 };
    for (int timing = LW_TIMING_PRESCRIBED; timing <= LW_TIMING_NONE; timing++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        FREED void *work = make_problem(&f, &k, (lw_timing)timing, false, &p);
        CHECK(lw_random_linkage_posture(&p, x, work) && p.intended.turns);
        double f0 = lw_problem_value(&p, x, NULL, work);
        CHECK_NEAR(f0, 0, timing == LW_TIMING_NONE ? 0.2 : 1e-20, 0);    /* a polygon is no curve         */
    }
}

TEST(derivatives_are_those_of_f)
{
    lw_linkage k = six_bar();
    lw_family f = { .name = "six-bar", .linkage = &k, .posture = true, .links = 6 };
    lw_rng rng = check_rng(3);
    for (int timing = LW_TIMING_PRESCRIBED; timing <= LW_TIMING_FREE; timing++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX], grad[LW_VAR_MAX];
        FREED void *work = make_problem(&f, &k, (lw_timing)timing, false, &p);
        CHECK(lw_random_linkage_posture(&p, x, work));
        for (int v = 0; v < p.n_var; v++)
            x[v] += 0.01*lw_rng_normal(&rng);
        CHECK(isfinite(lw_problem_value(&p, x, grad, work)));
        for (int v = 0; v < p.n_var; v++) {
            double at = x[v], h = 1e-6, up, down;
            x[v] = at + h;
            up = lw_problem_value(&p, x, NULL, work);
            x[v] = at - h;
            down = lw_problem_value(&p, x, NULL, work);
            x[v] = at;
            CHECK_NEAR(grad[v], (up - down)/(2*h), 1e-6, 1e-5);
        }
    }
}
