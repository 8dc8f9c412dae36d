/* Subsidiary conditions against plain geometry and exact derivatives of single poses. */
#include "tests/fit_problem.h"

static const char *const families[] = { "crank-rocker", "any four-bar", "slider-crank", "any slider-crank",
                                        "oscillating", "slotted crank", "trammel" };
enum { N_FAMILY = sizeof families/sizeof *families };

/* A problem of the member's own stations, a little off, with conditions that are met here and there. */
static bool make_case(const char *family, lw_timing timing, double transmission, double acceleration,
                      lw_rng *rng, member *m, lw_problem *p, double *x)
{
    stations st;
    lw_target t;
    lw_error e;
    lw_fit_spec spec = lw_fit_spec_default();
    spec.timing = timing;
    spec.min_transmission = transmission;
    draw_member(family, 1, false, rng, m);
    if (m->plan.input_is_slider && timing == LW_TIMING_PRESCRIBED)
        return false;
    trace_member(m, 9, &st);
    spec.max_acceleration = acceleration;
    target_of(&st, &spec, &t);
    CHECK_INT(lw_problem_make(&t, &spec, m->family, 1, 1, p, &e), LW_OK);
    variables_of(p, m, x);
    lw_target_free(&t);
    return true;
}

static double *conditions(const lw_problem *p, const double *x, double *j)
{
    void *work = new_work(p);
    double *g = calloc(lw_problem_constraint_count(p) + 1, sizeof *g);
    lw_problem_constraints(p, x, g, j, work);
    free(work);
    return g;
}

/* In the order of the header: linear, closure, transmission, acceleration. */
static void counts_are_those_asked_for(void)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 1);
    member m;
    lw_problem p;
    double x[LW_VAR_MAX];
    CHECK(make_case("crank-rocker", LW_TIMING_FREE, 0, 0, &rng, &m, &p, x));
    CHECK_INT(lw_problem_constraint_count(&p), 3);
    CHECK(!lw_problem_is_nonlinear(&p));
    lw_problem_free(&p);
    CHECK(make_case("crank-rocker", LW_TIMING_PRESCRIBED, 0.5, 3, &rng, &m, &p, x));
    CHECK_INT(lw_problem_constraint_count(&p), 3 + 2*LW_CURVE_SAMPLES);
    lw_problem_free(&p);
    CHECK(make_case("any four-bar", LW_TIMING_PRESCRIBED, 0.5, 3, &rng, &m, &p, x));
    CHECK_INT(lw_problem_constraint_count(&p), 9 + 9 + 9);
    CHECK(lw_problem_is_nonlinear(&p));
    lw_problem_free(&p);
}

/* Linear conditions of a crank-rocker by their meaning. */
static void linear_ones_are_grashofs(void)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 2);
    for (int trial = 0; trial < 50; trial++) {
        member m;
        lw_problem p;
        double x[LW_VAR_MAX];
        make_case("crank-rocker", LW_TIMING_FREE, 0, 0, &rng, &m, &p, x);
        double *g = conditions(&p, x, NULL), r1 = x[0], r2 = x[1], r3 = x[2], r4 = x[3], least = INFINITY;
        double want = fmin(fmin(r3 + r4 - r1 - r2, r1 + r4 - r2 - r3), r1 + r3 - r2 - r4) - LW_LINEAR_LEAST;
        for (int j = 0; j < 3; j++)
            least = fmin(least, g[j]);
        CHECK_NEAR(least, want, 1e-14, 1e-13);
        free(g);
        lw_problem_free(&p);
    }
}

/* Angle between coupler and rocker by the law of cosines, in every pose of the turn; the poses hold its
 * extremes, which are where crank and frame are in line. */
static void transmission_is_that_of_the_triangle(void)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 3);
    for (int trial = 0; trial < 50; trial++) {
        member m;
        lw_problem p;
        double x[LW_VAR_MAX], limit = lw_rng_range(&rng, 0.2, 1.4), least = INFINITY, want = INFINITY;
        make_case("crank-rocker", trial % 2 ? LW_TIMING_FREE : LW_TIMING_NONE, limit, 0, &rng, &m, &p, x);
        double *g = conditions(&p, x, NULL);
        const double *r = m.dim;
        for (int k = 0; k < LW_CURVE_SAMPLES; k++) {
            double d2 = r[0]*r[0] + r[1]*r[1] - 2*r[0]*r[1]*cos(2*LW_PI*k/LW_CURVE_SAMPLES);
            double angle = acos((r[2]*r[2] + r[3]*r[3] - d2)/(2*r[2]*r[3]));
            CHECK_NEAR(g[3 + k], pow(sin(angle), 2) - pow(sin(limit), 2), 1e-12, 0);
            least = fmin(least, g[3 + k]);
        }
        for (int k = 0; k <= 5000; k++) {
            double d2 = r[0]*r[0] + r[1]*r[1] - 2*r[0]*r[1]*cos(2*LW_PI*k/5000);
            want = fmin(want, pow(sin(acos((r[2]*r[2] + r[3]*r[3] - d2)/(2*r[2]*r[3]))), 2) - pow(sin(limit), 2));
        }
        CHECK_NEAR(least, want, 1e-12, 0);
        free(g);
        lw_problem_free(&p);
    }
}

/* Are the stations assigned to where they came from?  A linkage may have two circuits, of which a problem
 * sees one. */
static bool at_home(const lw_problem *p, const double *x)
{
    void *work = new_work(p);
    double f = lw_problem_value(p, x, NULL, work);
    free(work);
    return f < 1e-20;
}

/* Poses in which conditions are looked at, from scratch: of the turn, or those of the stations, which
 * here are the member's own. */
static void conditions_are_those_of_single_poses(void)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 4);
    int seen = 0;
    for (int trial = 0; trial < 20*N_FAMILY; trial++) {
        member m;
        lw_problem p;
        lw_pose pose;
        stations st;
        double x[LW_VAR_MAX] = { 0 }, limit = lw_rng_range(&rng, 0.05, 0.3), most = lw_rng_range(&rng, 2, 5);
        lw_timing timing = trial % 2 ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
        if (!make_case(families[trial % N_FAMILY], timing, limit, most, &rng, &m, &p, x))
            continue;
        trace_member(&m, 9, &st);
        if (!at_home(&p, x)) {
            lw_problem_free(&p);
            continue;
        }
        seen++;
        size_t n = p.branch.turns ? LW_CURVE_SAMPLES : st.n, closure = !p.branch.turns && timing == LW_TIMING_PRESCRIBED ? st.n : 0;
        double *g = conditions(&p, x, NULL), *at = g + p.n_linear;
        for (size_t k = 0; k < n; k++) {
            double input = p.branch.turns ? 2*LW_PI*(double)k/LW_CURVE_SAMPLES : st.input[k];
            CHECK_INT(lw_pose_solve(&m.plan, m.dim, &m.mode, input, 2, &pose), LW_OK);
            if (closure)
                CHECK_NEAR(at[k], pose.margin, 1e-12, 1e-10);
            CHECK_NEAR(at[closure + k], pose.margin - pow(sin(limit), 2), 1e-7, 0);
            double a = lw_v2_norm(pose.tracer[0][2])/most;
            CHECK_NEAR(at[closure + n + k], 1 - a*a, 1e-5, 1e-5);      /* differenced twice */
        }
        free(g);
        lw_problem_free(&p);
    }
    CHECK(seen > 10*N_FAMILY);
}

static void derivatives_are_those_of_differences(void)
{
    const double h = 1e-6;
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 5);
    for (int trial = 0; trial < 4*N_FAMILY; trial++) {
        member m;
        lw_problem p;
        double x[LW_VAR_MAX] = { 0 }, at[LW_VAR_MAX];
        lw_timing timing = trial % 2 ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
        if (!make_case(families[trial % N_FAMILY], timing, 0.3, 2, &rng, &m, &p, x))
            continue;
        size_t n = lw_problem_constraint_count(&p), nv = (size_t)p.n_var;
        double *j = calloc(n*nv, sizeof *j), *g = conditions(&p, x, j);
        for (size_t v = 0; v < nv; v++) {
            double *to[4];
            memcpy(at, x, sizeof at);
            for (int i = 0; i < 4; i++) {                /* five points: error h^4 */
                at[v] = x[v] + (i < 2 ? i - 2 : i - 1)*h;
                to[i] = conditions(&p, at, NULL);
            }
            for (size_t i = 0; i < n; i++) {
                double slope = (to[0][i] - 8*to[1][i] + 8*to[2][i] - to[3][i])/(12*h);
                if (fabs(g[i]) < 100)                    /* at a limit accelerations have no bound  */
                    CHECK_NEAR(j[i*nv + v], slope, 1e-4*(1 + fabs(g[i])), 1e-4);
            }
            for (int i = 0; i < 4; i++)
                free(to[i]);
        }
        free(g);
        free(j);
        lw_problem_free(&p);
    }
}

/* What was asked before leaves no trace. */
static void answers_do_not_depend_on_the_past(void)
{
    lw_rng rng;
    lw_rng_seed(&rng, check_seed(), 6);
    for (int trial = 0; trial < N_FAMILY; trial++) {
        member m;
        lw_problem p;
        double x[LW_VAR_MAX] = { 0 }, other[LW_VAR_MAX];
        make_case(families[trial], LW_TIMING_FREE, 0.3, 2, &rng, &m, &p, x);
        size_t n = lw_problem_constraint_count(&p);
        void *work = new_work(&p);
        double *g = conditions(&p, x, NULL), *again = calloc(n, sizeof *again);
        memcpy(other, x, sizeof other);
        other[0] *= 1.1;
        lw_problem_value(&p, other, NULL, work);
        lw_problem_constraints(&p, x, again, NULL, work);
        CHECK(memcmp(g, again, n*sizeof *g) == 0);
        free(g);
        free(again);
        free(work);
        lw_problem_free(&p);
    }
}

int main(void)
{
    RUN(counts_are_those_asked_for);
    RUN(linear_ones_are_grashofs);
    RUN(transmission_is_that_of_the_triangle);
    RUN(conditions_are_those_of_single_poses);
    RUN(derivatives_are_those_of_differences);
    RUN(answers_do_not_depend_on_the_past);
    return check_end();
}
