/* Starts: with the right shape and inputs the linear fit finds place, size and tracer; what comes out is
 * a start in the sense of the header. */
#include "base/real_complex.h"
#include "optimise/solvers/lowdiscrepancy.h"
#include "optimise/search/start.h"
#include "tests/fit_problem.h"

static const char *const families[] = { "crank-rocker", "drag-link", "slider-crank", "oscillating", "turning",
                                        "slotted crank" };
enum { N_FAMILY = sizeof families/sizeof *families };

/* A member whose shape is what `u` draws, and the problem of its own stations from input 2 pi u - pi on. */
static void make_case(const char *family, lw_timing timing, lw_task task, lw_rng *rng, double *u, lw_problem *p)
{
    member m;
    stations st;
    OWN(lw_target) t = { 0 };
    double shape[LW_SHAPE_MAX];
    lw_fit_spec spec = lw_fit_spec_default();
    spec.task = task;
    spec.timing = timing;
    draw_member(family, 1, false, rng, &m);
    for (int i = 0; i < LW_START_DRAWS; i++)
        u[i] = lw_rng_range(rng, 0.35, 0.75);
    m.family->draw(u, shape);
    double size = lw_rng_range(rng, 0.2, 5);
    for (int i = 0; m.family->shape[i]; i++)
        *dim_named(&m, m.family->shape[i]) = size*shape[i];
    m.first = 2*LW_PI*u[m.family->n_draw] - LW_PI;
    m.last = m.first + 2*LW_PI;
    trace_member(&m, 12, &st);
    if (task == LW_TASK_MOTION)                          /* a tool that is not along its link        */
        for (size_t k = 0; k < st.n; k++)
            st.theta[k] += 0.7;
    target_of(&st, &spec, &t);
    for (size_t k = 0; t.angle && k < t.n; k++)          /* only differences matter                  */
        t.angle[k] -= m.first;
    CHECK_INT(lw_problem_make(&t, &spec, m.family, 1, 1, p, NULL), LW_OK);
    for (int i = 0; i < p->n_dim; i++) {
        p->lo[i] = fmin(p->lo[i], p->plan.dim[i].kind == LW_DIM_LENGTH ? p->lo[i] : -1e3);
        p->hi[i] = fmax(p->hi[i], 1e3);
    }
}

TEST(the_right_shape_gives_the_right_linkage)
{
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 20*N_FAMILY; trial++) {
        OWN(lw_problem) p = { 0 };
        double u[LW_START_DRAWS], x[LW_VAR_MAX];
        lw_task task = trial % 2 ? LW_TASK_MOTION : LW_TASK_PATH;
        make_case(families[trial % N_FAMILY], LW_TIMING_PRESCRIBED, task, &rng, u, &p);
        CHECK_INT(lw_start_draws(&p), p.family->n_draw + 1);
        FREED void *work = new_work(&p);
        double f = lw_start(&p, u, x, work);
        CHECK(f < 1e-18);                                /* the diagonal has 1e-12 added            */
        CHECK_NEAR(lw_problem_value(&p, x, NULL, work), f, 1e-28, 1e-6);
    }
}

/* What the linear fit leaves is the least over place, size and tracer: no near linkage of the same shape
 * and inputs does better. */
TEST(no_other_place_size_or_tracer_is_better)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 60; trial++) {
        OWN(lw_problem) p = { 0 };
        double u[LW_START_DRAWS], x[LW_VAR_MAX], grad[LW_VAR_MAX], by_size = 0;
        make_case(families[trial % N_FAMILY], LW_TIMING_PRESCRIBED, LW_TASK_PATH, &rng, u, &p);
        for (int i = 0; i < p.family->n_draw; i++)
            u[i] = lw_rng_uniform(&rng);
        FREED void *work = new_work(&p);
        double f = lw_start(&p, u, x, work);
        CHECK_NEAR(lw_problem_value(&p, x, grad, work), f, 0, 1e-9);
        for (int i = 0; i < p.n_dim; i++) {
            bool of_shape = false;
            for (int k = 0; p.family->shape[k]; k++)
                of_shape |= strcmp(p.family->shape[k], p.plan.dim[i].name) == 0;
            if (!of_shape)                               /* place, turn, tracer                      */
                CHECK_NEAR(grad[i], 0, 1e-5*(1 + fabs(x[i])), 0);
            if (p.plan.dim[i].kind != LW_DIM_ANGLE && strncmp(p.plan.dim[i].name, "x0", 2) && strncmp(p.plan.dim[i].name, "y0", 2))
                by_size += grad[i]*x[i];
        }
        CHECK_NEAR(by_size, 0, 1e-4, 0);
    }
}

/* Any draw of any family: inside bounds and conditions, f as said, closing everywhere. */
TEST(starts_are_what_they_say)
{
    static const lw_timing timing[] = { LW_TIMING_FREE, LW_TIMING_PRESCRIBED, LW_TIMING_NONE };
    lw_rng rng = check_rng(3);
    for (const lw_family *f = lw_family_table; f->name; f++)
        for (int k = 0; k < 3; k++) {
            enum { DRAWS = 100 };
            member m;
            stations st;
            OWN(lw_target) t = { 0 };
            OWN(lw_problem) p = { 0 };
            lw_fit_spec spec = lw_fit_spec_default();
            double u[DRAWS*LW_START_DRAWS], x[LW_VAR_MAX];
            int good = 0;
            spec.timing = timing[k];
            draw_member("crank-rocker", 1, false, &rng, &m);
            trace_member(&m, 10, &st);
            target_of(&st, &spec, &t);
            lw_status status = lw_problem_make(&t, &spec, f, 1, 1, &p, NULL);
            if (status != LW_OK)
                continue;
            int d = lw_start_draws(&p);
            CHECK(d <= LW_START_DRAWS && lw_low_discrepancy(&rng, DRAWS, d, u));
            FREED void *work = new_work(&p);
            for (int i = 0; i < DRAWS; i++) {
                double rest = timing[k] == LW_TIMING_PRESCRIBED ? 0 : lw_start_estimate(&p, u + i*d, work);
                double start = lw_start(&p, u + i*d, x, work);
                CHECK(rest >= -1e-9 && !isnan(start));
                CHECK(isfinite(rest) || !isfinite(start));
                if (!isfinite(start))
                    continue;
                good++;
                for (int v = 0; v < p.n_var; v++)
                    CHECK(x[v] >= p.lo[v] && x[v] <= p.hi[v]);
                CHECK(linear_least(&p, x) >= -1e-12);
                if (timing[k] == LW_TIMING_PRESCRIBED)
                    CHECK_NEAR(lw_problem_value(&p, x, NULL, work), start, 0, 1e-12);
            }
            if (good < 1)
                fprintf(stderr, "%s: %d starts of %d\n", f->name, good, DRAWS);
            CHECK(good >= 1);
        }
}

/* With the bounds wide open a start with free timing is at most what a glance at it left: it goes on from
 * there. (Not always: an assignment in order may cost more than the guess.) */
TEST(full_starts_mostly_improve_on_the_glance)
{
    lw_rng rng = check_rng(4);
    int better = 0, all = 0;
    for (int trial = 0; trial < 300; trial++) {
        OWN(lw_problem) p = { 0 };
        double u[LW_START_DRAWS], x[LW_VAR_MAX];
        make_case(families[trial % N_FAMILY], LW_TIMING_FREE, LW_TASK_PATH, &rng, u, &p);
        for (int i = 0; i < lw_start_draws(&p); i++)
            u[i] = lw_rng_uniform(&rng);
        FREED void *work = new_work(&p);
        double rest = lw_start_estimate(&p, u, work), f = lw_start(&p, u, x, work);
        all += isfinite(rest) && isfinite(f);
        better += isfinite(f) && f <= rest;
    }
    CHECK(all > 200 && better > 0.8*all);
}

/* The two numbers of a start that stand for this point of the body, from the tracer in the first pose (start.h: 0.03 to 3 sizes). */
static void draw_pin(double complex pin, double *u)
{
    u[0] = log(cabs(pin)/0.03)/log(100);
    u[1] = carg(pin)/(2*LW_PI);
}

/* Poses that a four-bar made: drawn at its pins, the circles are exact, and the start is that four-bar, whichever of both is the crank. */
TEST(pins_on_circles_are_those_of_the_linkage)
{
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 20; trial++) {
        OWN(lw_problem) p = { 0 };
        OWN(lw_target) t = { 0 };
        member m;
        stations st;
        double u[4], x[LW_VAR_MAX];
        lw_fit_spec spec = lw_fit_spec_default();
        spec.task = LW_TASK_MOTION;
        spec.timing = LW_TIMING_FREE;
        draw_member("crank-rocker", 1, false, &rng, &m);
        trace_member(&m, 12, &st);
        target_of(&st, &spec, &t);
        CHECK_INT(lw_problem_make(&t, &spec, m.family, 1, 1, &p, NULL), LW_OK);
        CHECK(lw_start_has_guides(&p));
        double complex along = cexp(I*st.theta[0])/p.unit;
        double complex crank = -(*dim_named(&m, "cx") + I**dim_named(&m, "cy"))*along;
        draw_pin(crank, u + 2*(trial % 2));
        draw_pin(crank + *dim_named(&m, "r3")*along, u + 2 - 2*(trial % 2));
        CHECK_NEAR(lw_start_guided_estimate(&p, u), 0, 1e-20, 0);
        FREED void *work = new_work(&p);
        CHECK(lw_start_guided(&p, u, x, work) < 1e-4);
        for (int i = 0; i < 4; i++)
            CHECK_NEAR(x[lw_plan_dim(&p.plan, m.family->shape[i])]*p.unit, *dim_named(&m, m.family->shape[i]), 0, 1e-8);
    }
}

/* A body that keeps its angle on an arc is carried by parallel cranks, wherever the pins are. */
TEST(pins_of_a_translation_are_a_parallelogram)
{
    enum { N = 6 };
    lw_rng rng = check_rng(6);
    OWN(lw_problem) p = { 0 };
    OWN(lw_target) t = { 0 };
    double px[N], py[N], theta[N] = { 0 }, x[LW_VAR_MAX];
    int found = 0;
    lw_fit_spec spec = lw_fit_spec_default();
    spec.task = LW_TASK_MOTION;
    spec.timing = LW_TIMING_FREE;
    for (int k = 0; k < N; k++) {
        px[k] = 1.4*cos(0.15*k - 0.4);
        py[k] = 1.4*sin(0.15*k - 0.4);
    }
    CHECK_INT(lw_target_make(N, px, py, theta, NULL, NULL, 0, &t, NULL), LW_OK);
    CHECK_INT(lw_problem_make(&t, &spec, family_named("any four-bar"), 1, 1, &p, NULL), LW_OK);
    FREED void *work = new_work(&p);
    for (int trial = 0; trial < 40; trial++) {
        double u[4];
        for (int i = 0; i < 4; i++)
            u[i] = lw_rng_uniform(&rng);
        CHECK_NEAR(lw_start_guided_estimate(&p, u), 0, 1e-18, 0);
        if (!(lw_start_guided(&p, u, x, work) < 1e-6))
            continue;
        found++;
        CHECK_NEAR(x[lw_plan_dim(&p.plan, "r2")]*p.unit, 1.4, 0, 1e-6);
        CHECK_NEAR(x[lw_plan_dim(&p.plan, "r4")]*p.unit, 1.4, 0, 1e-6);
        CHECK_NEAR(x[lw_plan_dim(&p.plan, "r1")], x[lw_plan_dim(&p.plan, "r3")], 0, 1e-6);
    }
    CHECK(found >= 10);
}
