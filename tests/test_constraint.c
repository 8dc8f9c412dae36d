/* Subsidiary conditions against plain geometry and exact derivatives of single postures. */
#include "optimise/search/random_linkage.h"
#include "tests/fit_problem.h"
#include "tests/six_bar.h"

static const char *const families[] = { "crank-rocker", "any four-bar", "slider-crank", "any slider-crank",
                                        "oscillating", "slotted crank", "trammel" };
enum { N_FAMILY = sizeof families/sizeof *families };

/* A problem of the member's own stations, a little off, with conditions that are met here and there. */
static bool make_case(const char *family, lw_timing timing, double transmission, double acceleration,
                      lw_rng *rng, member *m, lw_problem *p, double *x)
{
    stations st;
    OWN(lw_target) t = { 0 };
    lw_fit_spec spec = lw_fit_spec_default();
    spec.timing = timing;
    spec.min_transmission = transmission;
    draw_member(family, 1, false, rng, m);
    if (m->plan.input_is_slider && timing == LW_TIMING_PRESCRIBED)
        return false;
    trace_member(m, 9, &st);
    spec.max_acceleration = spec.max_slide_acceleration = acceleration;
    target_of(&st, &spec, &t);
    CHECK_OK(lw_problem_make(&t, &spec, m->family, 1, 1, p, &check_error));
    variables_of(p, m, x);
    return true;
}

static double *conditions(const lw_problem *p, const double *x, double *j)
{
    FREED void *work = new_work(p);
    double *g = calloc(lw_problem_constraint_count(p) + 1, sizeof *g);
    lw_problem_constraints(p, x, g, j, work);
    return g;
}

/* In the order of the header: linear, closure, transmission, acceleration. */
TEST(counts_are_those_asked_for)
{
    lw_rng rng = check_rng(1);
    member m;
    OWN(lw_problem) p = { 0 };
    double x[LW_VAR_MAX];
    CHECK(make_case("crank-rocker", LW_TIMING_FREE, 0, 0, &rng, &m, &p, x));
    CHECK_INT(lw_problem_constraint_count(&p), 3);
    CHECK(!lw_problem_is_nonlinear(&p));
    lw_problem_free(&p);
    CHECK(make_case("crank-rocker", LW_TIMING_PRESCRIBED, 0.5, 3, &rng, &m, &p, x));
    CHECK_INT(lw_problem_constraint_count(&p), 3 + 4 + LW_CURVE_SAMPLES);
    lw_problem_free(&p);
    CHECK(make_case("any four-bar", LW_TIMING_PRESCRIBED, 0.5, 3, &rng, &m, &p, x));
    CHECK_INT(lw_problem_constraint_count(&p), 9 + 2*LW_CURVE_SAMPLES);
    CHECK(lw_problem_is_nonlinear(&p));
}

/* Linear conditions of a crank-rocker by their meaning. */
TEST(linear_ones_are_grashofs)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 50; trial++) {
        member m;
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX];
        make_case("crank-rocker", LW_TIMING_FREE, 0, 0, &rng, &m, &p, x);
        double *g = conditions(&p, x, NULL), r1 = x[0], r2 = x[1], r3 = x[2], r4 = x[3], least = INFINITY;
        double want = fmin(fmin(r3 + r4 - r1 - r2, r1 + r4 - r2 - r3), r1 + r3 - r2 - r4) - LW_LINEAR_LEAST;
        for (int j = 0; j < 3; j++)
            least = fmin(least, g[j]);
        CHECK_NEAR(least, want, 1e-14, 1e-13);
        free(g);
    }
}

/* Angle between coupler and rocker by the law of cosines, in every posture that is checked; the postures hold its extremes,
 * which are where crank and frame are in line. */
TEST(transmission_is_that_of_the_triangle)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 50; trial++) {
        member m;
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX], limit = lw_rng_range(&rng, 0.2, 1.4), least = INFINITY, want = INFINITY;
        make_case("crank-rocker", trial % 2 ? LW_TIMING_FREE : LW_TIMING_NONE, limit, 0, &rng, &m, &p, x);
        FREED double *g = conditions(&p, x, NULL);
        const double *r = m.dim;
        for (int k = 0; k < 4; k++) {
            double d2 = r[0]*r[0] + r[1]*r[1] - 2*r[0]*r[1]*cos(0.5*LW_PI*k);
            double angle = acos((r[2]*r[2] + r[3]*r[3] - d2)/(2*r[2]*r[3]));
            CHECK_NEAR(g[3 + k], pow(sin(angle), 2) - pow(sin(limit), 2), 1e-12, 0);
            least = fmin(least, g[3 + k]);
        }
        for (int k = 0; k <= 5000; k++) {
            double d2 = r[0]*r[0] + r[1]*r[1] - 2*r[0]*r[1]*cos(2*LW_PI*k/5000);
            want = fmin(want, pow(sin(acos((r[2]*r[2] + r[3]*r[3] - d2)/(2*r[2]*r[3]))), 2) - pow(sin(limit), 2));
        }
        CHECK_NEAR(least, want, 1e-12, 0);
    }
}

/* Are the stations assigned to where they came from?  A linkage may have two circuits, of which a problem
 * sees one. */
static bool at_home(const lw_problem *p, const double *x)
{
    FREED void *work = new_work(p);
    double f = lw_problem_value(p, x, NULL, work);
    return f < 1e-20;
}

/* A sample's condition, or the least near it, `fine`, where it is less than its neighbours, or less than one of them and hardly more than the other: a
 * second extreme may lie beyond them. */
static void check_sample(const double *g, const double *want, size_t k, bool round, double fine, double off)
{
    enum { N = LW_CURVE_SAMPLES };
    bool end = !round && (k == 0 || k == N - 1);
    double rise = fmax(want[(k + 1) % N], want[(k + N - 1) % N]) - want[k], fall = want[k] - fmin(want[(k + 1) % N], want[(k + N - 1) % N]);
    bool least = fall <= rise/3 + off;
    if (end || !least)
        CHECK_NEAR(g[k], want[k], off, off);
    else
        CHECK(g[k] <= want[k] + off*(1 + fabs(want[k])) && g[k] >= fine - fmax(off, 1e-3)*(1 + fabs(fine)));
}

/* Conditions on transmission angle and acceleration in one posture. */
static void conditions_at(const lw_problem *p, const member *m, double input, const double *mode, double limit, double most,
                          double *sine, double *acceleration)
{
    lw_posture posture;
    lw_posture_solve(&m->plan, m->dim, mode, p->plan.input_is_slider ? input*p->unit : input, 2, &posture);
    CHECK(posture.margin > -1e-9);
    *sine = posture.margin - pow(sin(limit), 2);
    *acceleration = 1 - pow(lw_v2_norm(posture.tracer[0][2])/most, 2);
}

static double apart(const lw_problem *p, double a, double b)
{
    return fabs(p->plan.input_is_slider ? a - b : remainder(a - b, 2*LW_PI));
}

/* Postures in which conditions are looked at, from scratch: of the turn, or of the way between the stations, which
 * here are the member's own. */
TEST(conditions_are_those_of_single_postures)
{
    lw_rng rng = check_rng(4);
    int seen = 0;
    for (int trial = 0; trial < 20*N_FAMILY; trial++) {
        member m;
        lw_problem p;
        lw_posture posture;
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
        enum { N = LW_CURVE_SAMPLES };
        bool round = p.intended.turns;
        size_t closure = !round && timing == LW_TIMING_PRESCRIBED ? st.n : 0;
        double *g = conditions(&p, x, NULL), *at = g + p.n_linear, sine[N], acceleration[N], fine[2][N];
        void *work = new_work(&p);
        if (timing == LW_TIMING_PRESCRIBED)
            lw_problem_prescribe(&p, x, work);
        else
            CHECK(lw_problem_settle(&p, x, work));
        for (size_t k = 0; k < closure; k++) {
            CHECK_INT(lw_posture_solve(&m.plan, m.dim, &m.mode, st.input[k], 2, &posture), LW_OK);
            CHECK_NEAR(at[k], posture.margin, 1e-12, 1e-10);
        }
        for (size_t k = 0; k < N; k++) {
            double mode[LW_MODE_MAX];
            int leg;
            double input = round ? 2*LW_PI*(double)k/N : lw_problem_input_at(&p, work, (double)k/(N - 1), mode, &leg);
            double at_end = p.plan.input_is_slider ? input*p.unit : input;
            if (!round && (k == 0 || k == N - 1))
                CHECK(fmin(apart(&p, at_end, st.input[0]), apart(&p, at_end, st.input[8])) < 1e-6);
            conditions_at(&p, &m, input, round ? &m.mode : mode, limit, most, &sine[k], &acceleration[k]);
            fine[0][k] = fine[1][k] = INFINITY;
            for (int i = -40; i <= 40; i++) {
                double place = (double)k + i/24.0, s, a;
                place = round ? place : fmin(fmax(place, 0), N - 1);
                input = round ? 2*LW_PI*place/N : lw_problem_input_at(&p, work, place/(N - 1), mode, &leg);
                conditions_at(&p, &m, input, round ? &m.mode : mode, limit, most, &s, &a);
                fine[0][k] = fmin(fine[0][k], s);
                fine[1][k] = fmin(fine[1][k], a);
            }
        }
        size_t postures = lw_problem_transmission_postures(&p);
        double least = INFINITY, of_all = INFINITY;
        CHECK_INT(postures, round ? 4 : N);
        for (size_t k = 0; k < N; k++) {
            of_all = fmin(of_all, sine[k]);
            if (k < postures)
                least = fmin(least, at[closure + k]);
            if (!round)
                check_sample(at + closure, sine, k, round, fine[0][k], 1e-7);
            check_sample(at + closure + postures, acceleration, k, round, fine[1][k], 1e-5);      /* differenced twice */
        }
        if (round)                                         /* the four postures are those of the extremes */
            CHECK_NEAR(least, of_all, 1e-12, 1e-10);
        free(work);
        free(g);
        lw_problem_free(&p);
    }
    CHECK(seen > 10*N_FAMILY);
}

/* The least over the whole turn of a linkage whose extremes are at no sample, by 5000 postures. */
TEST(extremes_between_samples_are_found)
{
    int n_off = 0, n_far = 0;
    lw_rng rng = check_rng(7);
    for (int trial = 0; trial < 40; trial++) {
        enum { FINE = 5000 };
        member m;
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX] = { 0 }, most = 2, want = INFINITY, least = INFINITY;
        make_case(trial % 2 ? "crank-rocker" : "slider-crank", LW_TIMING_FREE, 0, most, &rng, &m, &p, x);
        double *g = conditions(&p, x, NULL);
        for (int k = 0; k < FINE; k++) {
            lw_posture posture;
            CHECK_INT(lw_posture_solve(&m.plan, m.dim, &m.mode, 2*LW_PI*k/FINE, 2, &posture), LW_OK);
            want = fmin(want, 1 - pow(lw_v2_norm(posture.tracer[0][2])/most, 2));
        }
        for (size_t k = 0; k < LW_CURVE_SAMPLES; k++)
            least = fmin(least, g[(size_t)p.n_linear + k]);
        free(g);
        if (want > 0.5) {                                        /* far from the limit: samples are enough      */
            n_far++;
            CHECK_NEAR(least, want, 0.1, 0);
            continue;
        }
        n_off += !(fabs(least - want) <= 2e-4*(1 + fabs(want)));         /* as near as 5000 postures come */
        CHECK_NEAR(least, want, 0.05, 0.05);                     /* of two peaks between samples it may be the lower */
    }
    CHECK(n_off <= 2 && n_far < 30);
}

/* The least margin of two dyads that take turns: samples fall on from the extreme of one to that of the other.  By 1280 postures. */
TEST(extremes_hidden_by_another_group_are_found)
{
    enum { TRIALS = 300, FINE = 20*LW_CURVE_SAMPLES };
    static const lw_vec2 at[] = { { 111.338056, -60 }, { 87.475747, -77.472207 }, { 93.606359, -87.005988 }, { 102.948391, -60 },
                                  { 20.989957, -90.229818 }, { 21.401058, -83.965477 }, { 110.820833, -60 } };
    lw_rng rng = check_rng(9);
    int seen = 0, missed = 0;
    for (int trial = 0; trial < TRIALS; trial++) {
        lw_linkage k = six_bar();
        stations st = { .n = 12, .closed = true };
        OWN(lw_problem) p = { 0 };
        OWN(lw_target) t = { 0 };
        double x[LW_VAR_MAX], dim[LW_DIM_MAX], mode[LW_MODE_MAX], input, least = INFINITY, want = INFINITY;
        lw_plan plan;
        for (int j = 0; j < k.n_joint; j++)
            k.joint[j].at = lw_v2(0.02*at[j].x + 0.0005*lw_rng_normal(&rng), 0.02*at[j].y + 0.0005*lw_rng_normal(&rng));
        k.tracer[0].at = lw_v2(0.01, 0);
        CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, NULL), LW_OK);
        CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
        for (int i = 0; i < FINE; i++) {
            lw_posture posture;
            lw_status now = lw_posture_solve(&plan, dim, mode, 2*LW_PI*i/FINE, 0, &posture);
            want = fmin(want, now == LW_OK ? posture.margin : -INFINITY);
        }
        if (!(want > 0.01))                                      /* it does not turn fully                      */
            continue;
        lw_family f = { .name = "six-bar", .linkage = &k, .posture = true, .links = 6 };
        lw_fit_spec spec = lw_fit_spec_default();
        spec.min_transmission = 0.1;
        six_bar_curve(&k, st.n, st.x, st.y, st.input);
        target_of(&st, &spec, &t);
        CHECK_INT(lw_problem_make(&t, &spec, &f, 1, 1, &p, NULL), LW_OK);
        FREED void *work = new_work(&p);
        CHECK(lw_random_linkage_posture(&p, x, work));
        FREED double *g = conditions(&p, x, NULL);
        CHECK_INT(lw_problem_transmission_postures(&p), LW_CURVE_SAMPLES);
        for (size_t i = 0; i < LW_CURVE_SAMPLES; i++)
            least = fmin(least, g[(size_t)p.n_linear + i] + pow(sin(spec.min_transmission), 2));
        seen++;
        missed += !(fabs(least - want) <= 1e-4);
    }
    CHECK(seen > TRIALS/2 && missed == 0);
}

/* Every kind of condition: transmission, acceleration, pivots in a box and on a line, zones on the path, lengths. */
static void ask_for_everything(const stations *st, lw_fit_spec *s)
{
    double x = st->x[2], y = st->y[2];
    s->min_transmission = 0.3;
    s->max_acceleration = s->max_slide_acceleration = 2;
    s->length_lo = 0.5;
    s->length_hi = 2;
    s->n_zone = 6;
    s->zone[0] = (lw_zone){ .kind = LW_ZONE_PIVOTS_BOX, .at = { -1, -1 }, .to = { 1, 2 }, .reach = 0 };
    s->zone[1] = (lw_zone){ .kind = LW_ZONE_PIVOTS_LINE, .at = { 0, 1 }, .to = { 0.8, 0.6 }, .reach = 0.5 };
    s->zone[2] = (lw_zone){ .kind = LW_ZONE_NO_CIRCLE, .at = { x + 0.3, y + 0.1 }, .to = { 0, 0 }, .reach = 0.2 };
    s->zone[3] = (lw_zone){ .kind = LW_ZONE_NO_BOX, .at = { x - 1.3, y - 0.7 }, .to = { x - 0.8, y - 0.1 }, .reach = 0 };
    s->zone[4] = (lw_zone){ .kind = LW_ZONE_PIVOTS_POLYGON, .n_corner = 3, .corner = { { -2, -1 }, { 2.5, -1.5 }, { 0, 3 } } };
    s->zone[5] = (lw_zone){ .kind = LW_ZONE_NO_POLYGON, .n_corner = 5, .corner = { { x - 0.9, y + 0.6 }, { x - 0.2, y + 0.2 },
                            { x + 0.3, y + 0.5 }, { x + 0.1, y + 1 }, { x - 0.5, y + 1.1 } } };
    for (int i = 4; i < 6; i++)
        CHECK_INT(lw_zone_settle(&s->zone[i], NULL), LW_OK);
}

/* Is row i an acceleration beside a posture near a dead point, where it grows beyond all bounds? */
static bool beside_dead_point(const lw_problem *p, const double *g, size_t i)
{
    size_t first = lw_problem_constraint_count(p) - p->n_zone_condition - LW_CURVE_SAMPLES;
    if (lw_problem_transmission_postures(p) < LW_CURVE_SAMPLES)           /* a crank has no dead points */
        return false;
    if (i < first || i >= first + LW_CURVE_SAMPLES)
        return false;
    for (int by = -2; by <= 2; by++)
        if (g[first - LW_CURVE_SAMPLES + (i - first + LW_CURVE_SAMPLES + (size_t)by)%LW_CURVE_SAMPLES] < 0)
            return true;
    return false;
}

/* Where differences with two steps, or to the two sides, disagree a condition has a kink (the least of several distances, say) and is not
 * compared; *smooth counts the others. */
static void compare_derivatives(const lw_problem *p, const double *x, long *smooth, long *all)
{
    size_t n = lw_problem_constraint_count(p), nv = (size_t)p->n_var;
    double *j = calloc(n*nv, sizeof *j), *g = conditions(p, x, j), at[LW_VAR_MAX];
    for (size_t v = 0; v < nv; v++) {
        double *to[2][4];
        memcpy(at, x, sizeof at);
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 4; i++) {                    /* five points: error h^4 */
                at[v] = x[v] + (i < 2 ? i - 2 : i - 1)*(k ? 5e-6 : 2e-5);
                to[k][i] = conditions(p, at, NULL);
            }
        for (size_t i = 0; i < n; i++) {
            double slope[2];
            for (int k = 0; k < 2; k++)
                slope[k] = (to[k][0][i] - 8*to[k][1][i] + 8*to[k][2][i] - to[k][3][i])/(12*(k ? 5e-6 : 2e-5));
            double off = 2e-5*(1 + fabs(g[i]) + fabs(slope[0]));
            ++*all;
            double turn = (to[1][2][i] - 2*g[i] + to[1][1][i])/5e-6;      /* of the slope at x itself: a kink there is seen by no central difference */
            if (!(fabs(slope[0] - slope[1]) < off) || !(fabs(turn) < off) || beside_dead_point(p, g, i))
                continue;
            ++*smooth;
            if (!(fabs(j[i*nv + v] - slope[0]) <= 2*off))
                fprintf(stderr, "%s, condition %zu of %zu (%zu, %zu linear, sides) %g by %s:\n", p->family->name, i, n,
                        (size_t)p->n_linear, (size_t)p->n_side, g[i], lw_problem_variable(p, (int)v));
            CHECK_NEAR(j[i*nv + v], slope[0], 2*off, 0);
        }
        for (int i = 0; i < 8; i++)
            free(to[i/4][i%4]);
    }
    free(g);
    free(j);
}

/* Conditions of zones with no more room than `enough`, and their rows, are the same as without that limit; the others have more. */
static void compare_near(const lw_problem *p, const double *x, double enough, long *near)
{
    size_t n = lw_problem_constraint_count(p), nv = (size_t)p->n_var, first = n - p->n_zone_condition;
    double *j = calloc(n*nv, sizeof *j), *row = calloc(n*nv, sizeof *row), *g = conditions(p, x, j);
    double *some = calloc(n, sizeof *some), *least = calloc(n, sizeof *least);
    void *work = new_work(p);
    lw_problem_conditions(p, x, false, enough, some, NULL, work);
    lw_problem_conditions(p, x, false, enough, least, row, work);
    for (size_t i = first; i < n; i++) {
        CHECK(g[i] > enough ? some[i] > enough : some[i] == g[i]);
        CHECK(isinf(least[i]) || (least[i] == g[i] && memcmp(row + i*nv, j + i*nv, nv*sizeof *j) == 0));
        *near += g[i] <= enough;
    }
    free(g);
    free(j);
    free(row);
    free(some);
    free(least);
    free(work);
}

/* Stations are off the linkage's curve, so that the best inputs of free stations move with the variables. */
TEST(derivatives_are_those_of_differences)
{
    long smooth = 0, all = 0, near = 0;
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 6*N_FAMILY; trial++) {
        member m;
        OWN(lw_problem) p = { 0 };
        stations st;
        OWN(lw_target) t = { 0 };
        double x[LW_VAR_MAX] = { 0 };
        lw_fit_spec spec = lw_fit_spec_default();
        spec.timing = trial % 3 == 0 ? LW_TIMING_PRESCRIBED : trial % 3 == 1 ? LW_TIMING_FREE : LW_TIMING_NONE;
        spec.task = trial % 2 && spec.timing == LW_TIMING_FREE ? LW_TASK_MOTION : LW_TASK_PATH;
        spec.datum = trial % 2 ? LW_DATUM_PLANE : LW_DATUM_FREE;
        draw_member(families[trial % N_FAMILY], 1, false, &rng, &m);
        if (m.plan.input_is_slider && spec.timing == LW_TIMING_PRESCRIBED)
            continue;
        trace_member(&m, 9, &st);
        shake_stations(&st, 0.03, &rng);
        st.closed &= trial % 4 < 2;
        ask_for_everything(&st, &spec);
        target_of(&st, &spec, &t);
        CHECK_INT(lw_problem_make(&t, &spec, m.family, 1, 1, &p, NULL), LW_OK);
        variables_of(&p, &m, x);
        compare_derivatives(&p, x, &smooth, &all);
        compare_near(&p, x, 0.1*(trial % 5), &near);
    }
    CHECK(smooth > 0.6*(double)all && near > 500);
}

TEST(derivatives_of_a_six_bar)
{
    long smooth = 0, all = 0;
    lw_linkage k = six_bar();
    lw_family f = { .name = "six-bar", .linkage = &k, .posture = true, .links = 6 };
    lw_rng rng = check_rng(8);
    for (int trial = 0; trial < 9; trial++) {
        stations st = { .n = 12, .closed = true };
        OWN(lw_problem) p = { 0 };
        OWN(lw_target) t = { 0 };
        double x[LW_VAR_MAX];
        lw_fit_spec spec = lw_fit_spec_default();
        spec.timing = (lw_timing)(trial % LW_TIMINGS);
        six_bar_curve(&k, st.n, st.x, st.y, st.input);
        ask_for_everything(&st, &spec);
        target_of(&st, &spec, &t);
        CHECK_INT(lw_problem_make(&t, &spec, &f, 1, 1, &p, NULL), LW_OK);
        CHECK(p.n_side > 5);
        FREED void *work = new_work(&p);
        CHECK(lw_random_linkage_posture(&p, x, work));
        for (int v = 0; v < p.n_var; v++)
            x[v] += 0.003*lw_rng_normal(&rng);
        if (isfinite(lw_problem_value(&p, x, NULL, work)))                 /* it closes                        */
            compare_derivatives(&p, x, &smooth, &all);
    }
    CHECK(all > 10000 && smooth > 0.6*(double)all);
}

/* What was asked before leaves no trace. */
TEST(answers_do_not_depend_on_the_past)
{
    lw_rng rng = check_rng(6);
    for (int trial = 0; trial < N_FAMILY; trial++) {
        member m;
        OWN(lw_problem) p = { 0 };
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
    }
}
