/* Reports: what they say against sums by hand, and that the check of a result can fail. */
#include "mbs/kinematics/motion.h"
#include "optimise/report/report_internal.h"
#include "optimise/report/results.h"
#include "tests/fit_problem.h"
#include "tests/mbs_linkage.h"

/* A candidate made from a member whose stations are `st`, claimed to miss a shaken target. */
typedef struct made {
    member       m;
    stations     st;
    lw_target    t;
    lw_fit_spec  spec;
    lw_candidate c;
    double       input[STATION_MAX], mode[STATION_MAX];
} made;

static void made_free(made *k) { lw_target_free(&k->t); }

static double eq17(const made *k)
{
    double f = 0;
    for (size_t i = 0; i < k->t.n; i++) {
        lw_posture posture;
        double mode = k->c.mode_of ? k->c.mode_of[i] : k->c.intended.mode[0];
        lw_posture_solve(&k->m.plan, k->c.dim, &mode, k->c.input[i], 0, &posture);
        if (k->spec.task != LW_TASK_FUNCTION)
            f += k->spec.a*k->t.weight[i]*(pow(posture.tracer[0][0].x - k->t.x[i], 2) + pow(posture.tracer[0][0].y - k->t.y[i], 2));
        double turn = k->t.theta ? posture.angle[k->m.plan.output_link[0]][0] + k->c.tool0 - k->t.theta[i] : 0;
        f += k->spec.b*k->t.weight[i]*pow(remainder(turn, 2*LW_PI), 2);
    }
    return f;
}

static void claim(made *k)
{
    k->c = (lw_candidate){ .family = k->m.family, .intended = { .sense = 1 }, .n_dim = k->m.plan.n_dim,
                           .input = k->input, .tool0 = k->t.theta ? 0.125 : 0 };
    for (int d = 0; d < LW_MODE_MAX; d++)
        k->c.intended.mode[d] = k->m.mode;
    memcpy(k->c.dim, k->m.dim, sizeof k->c.dim);
    memcpy(k->input, k->st.input, sizeof k->input);
    k->c.objective = eq17(k);
}

static void make(const char *family, double mode, lw_task task, double shake, lw_rng *rng, made *k)
{
    memset(k, 0, sizeof *k);
    k->spec = lw_fit_spec_default();
    k->spec.task = task;
    k->spec.a = 2;
    k->spec.b = 0.5;
    draw_member(family, mode, task == LW_TASK_FUNCTION, rng, &k->m);
    trace_member(&k->m, 9, &k->st);
    shake_stations(&k->st, shake, rng);
    target_of(&k->st, &k->spec, &k->t);
    claim(k);
}

static lw_fit_report report_of(const made *k)
{
    lw_fit_report r;
    lw_error e = { .text = "" };
    CHECK_INT(lw_fit_report_make(&k->t, &k->spec, &k->c, &r, &e), LW_OK);
    return r;
}

/* ---- honest candidates -------------------------------------------------------------------------- */

static bool can_do(const char *family, lw_task task)
{
    const char *type = family_named(family)->type;
    return task != LW_TASK_FUNCTION || (type[3] != 'P' && type[0] != 'P');
}

TEST(every_honest_candidate_is_verified)
{
    lw_rng rng = check_rng(1);
    for (const lw_family *f = lw_family_table; f->name; f++)
        for (int trial = 0; trial < 12; trial++) {
            lw_task task = (lw_task)(trial % 3);
            OWN(made) k = { 0 };
            if (!can_do(f->name, task))
                continue;
            make(f->name, trial % 2 ? 1 : -1, task, 0.05, &rng, &k);
            lw_fit_report r = report_of(&k);
            if (!r.verified)
                fprintf(stderr, "%s: %s\n", f->name, r.fault);
            CHECK(r.verified && r.fault[0] == 0);
            CHECK_NEAR(r.objective, k.c.objective, 0, 1e-12);
            CHECK_NEAR(r.verified_objective, k.c.objective, 1e-18, 1e-8);
            CHECK(r.difference <= 1e-9*(k.t.length + 1));
        }
}

/* The dimensions of a candidate are those of its report, by name. */
TEST(dimensions_of_fit_and_report_agree)
{
    lw_rng rng = check_rng(13);
    for (const lw_family *f = lw_family_table; f->name; f++)
        for (int task = 0; task < 3; task++) {
            OWN(made) k = { 0 };
            OWN(lw_problem) p = { 0 };
            if (!can_do(f->name, (lw_task)task))
                continue;
            make(f->name, 1, (lw_task)task, 0.05, &rng, &k);
            lw_fit_report r = report_of(&k);
            CHECK_INT(lw_problem_make(&k.t, &k.spec, f, 1, 1, &p, NULL), LW_OK);
            for (int i = 0; i < p.n_dim; i++) {
                CHECK_TEXT(r.dim_name[i], lw_problem_variable(&p, i));
                CHECK_INT(r.dim_kind[i], p.plan.dim[i].kind);
            }
            CHECK(r.dim_name[p.n_dim][0] == 0);
        }
}

TEST(errors_are_those_by_hand)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 40; trial++) {
        OWN(made) k = { 0 };
        double sum = 0, square = 0, most = 0, length = 0;
        size_t worst = 0;
        make(trial % 2 ? "crank-rocker" : "drag-link", 1, LW_TASK_PATH, 0.2, &rng, &k);
        lw_fit_report r = report_of(&k);
        for (size_t i = 0; i < 9; i++) {
            lw_vec2 p = fourbar_at(k.c.dim, 1, k.input[i]).p;
            double d = hypot(p.x - k.st.x[i], p.y - k.st.y[i]);
            sum += d;
            square += d*d;
            worst = d > most ? i : worst;
            most = fmax(most, d);
            length += hypot(k.st.x[(i + 1) % 9] - k.st.x[i], k.st.y[(i + 1) % 9] - k.st.y[i]);
        }
        CHECK_NEAR(r.objective, 2*square, 0, 1e-11);
        CHECK_NEAR(r.error_mean, sum/9, 0, 1e-11);
        CHECK_NEAR(r.error_rms, sqrt(square/9), 0, 1e-11);
        CHECK_NEAR(r.error_max, most, 0, 1e-11);
        CHECK_INT(r.worst, worst);
        CHECK_NEAR(r.error_percent, 100*sum/9/length, 0, 1e-11);
        CHECK(isnan(r.angle_mean) && isnan(r.angle_max));
    }
}

/* What the linkage does to rounding has no error; an error of a billionth of its size has one.  The ratio of lengths takes the arm of the
 * point to the nearer pin. */
TEST(rounding_is_no_error)
{
    lw_rng rng = check_rng(17);
    for (int trial = 0; trial < 40; trial++) {
        OWN(made) k = { 0 };
        double off = trial % 2 ? 1e-9 : 0, far = trial % 4 < 2 ? 1e4 : 0;
        make("crank-rocker", 1, LW_TASK_PATH, 0, &rng, &k);
        *dim_named(&k.m, "x0") += far;
        for (size_t i = 0; i < 9; i++) {
            k.st.x[i] = fourbar_at(k.m.dim, 1, k.st.input[i]).p.x + (i == 4 ? off*far : 0) + (i == 4 ? off : 0);
            k.st.y[i] = fourbar_at(k.m.dim, 1, k.st.input[i]).p.y;
        }
        made_free(&k);
        target_of(&k.st, &k.spec, &k.t);
        claim(&k);
        lw_fit_report r = report_of(&k);
        if (off > 0) {
            CHECK(r.error_max > 0 && r.error_mean > 0);
            CHECK_NEAR(r.error_max, off*(1 + far), 1e-11*(1 + far), 0);
        } else {
            CHECK(r.error_max == 0 && r.error_mean == 0 && r.error_rms == 0 && r.error_percent == 0);
        }
        double cx = *dim_named(&k.m, "cx"), cy = *dim_named(&k.m, "cy"), least = INFINITY, most = fmin(hypot(cx, cy), hypot(cx - *dim_named(&k.m, "r3"), cy));
        static const char *const side[] = { "r1", "r2", "r3", "r4" };
        for (int i = 0; i < 4; i++) {
            least = fmin(least, *dim_named(&k.m, side[i]));
            most = fmax(most, *dim_named(&k.m, side[i]));
        }
        CHECK_NEAR(lw_fit_report_ratio(&k.t, &r), most/least, 0, 1e-9);
    }
}

TEST(angles_are_those_by_hand)
{
    lw_rng rng = check_rng(3);
    for (int trial = 0; trial < 20; trial++) {
        OWN(made) k = { 0 };
        double sum = 0, most = 0;
        make("crank-rocker", 1, LW_TASK_MOTION, 0.2, &rng, &k);
        lw_fit_report r = report_of(&k);
        for (size_t i = 0; i < 9; i++) {
            fourbar_joints q = fourbar_at(k.c.dim, 1, k.input[i]);
            double tool = atan2(q.b.y - q.a.y, q.b.x - q.a.x) + 0.125;
            double d = fabs(remainder(tool - k.st.theta[i], 2*LW_PI));
            sum += d;
            most = fmax(most, d);
        }
        CHECK_NEAR(r.angle_mean, sum/9, 0, 1e-10);
        CHECK_NEAR(r.angle_max, most, 0, 1e-10);
        made_free(&k);
        make("oscillating", 1, LW_TASK_FUNCTION, 0.2, &rng, &k);
        r = report_of(&k);
        CHECK(isnan(r.error_mean) && isnan(r.curve_max) && r.n_cognate == 0);
        CHECK(r.angle_max >= r.angle_mean && r.angle_mean > 0);
    }
}

TEST(motion_is_that_of_brute_force)
{
    enum { LOOKS = 3600 };
    lw_rng rng = check_rng(4);
    for (int trial = 0; trial < 20; trial++) {
        OWN(made) k = { 0 };
        double least = 9, most = 0, farthest = 0, stride = 0;
        make("crank-rocker", trial % 2 ? 1 : -1, LW_TASK_PATH, 0.2, &rng, &k);
        lw_fit_report r = report_of(&k);
        for (int q = 0; q < LOOKS; q++) {
            fourbar_joints j = fourbar_at(k.c.dim, k.m.mode, 2*LW_PI*q/LOOKS);
            lw_vec2 u = lw_v2_sub(j.a, j.b), v = lw_v2_sub(j.b0, j.b);
            lw_vec2 next = fourbar_at(k.c.dim, k.m.mode, 2*LW_PI*(q + LOOKS/720)/LOOKS).p;
            stride = fmax(stride, lw_v2_norm(lw_v2_sub(next, j.p)));
            double angle = acos(lw_v2_dot(u, v)/(lw_v2_norm(u)*lw_v2_norm(v))), near = INFINITY;
            least = fmin(least, angle);
            most = fmax(most, angle);
            for (size_t i = 0; i < 9; i++) {
                lw_vec2 a = lw_v2(k.st.x[i], k.st.y[i]);
                lw_vec2 d = lw_v2_sub(lw_v2(k.st.x[(i + 1) % 9], k.st.y[(i + 1) % 9]), a);
                double along = fmax(0, fmin(1, lw_v2_dot(lw_v2_sub(j.p, a), d)/lw_v2_dot(d, d)));
                near = fmin(near, lw_v2_norm(lw_v2_sub(j.p, lw_v2_add(a, lw_v2_scale(d, along)))));
            }
            farthest = fmax(farthest, near);
        }
        CHECK(r.turns && r.has_class && r.barker.crank);
        double ends[2] = { fmin(least, LW_PI - least), fmin(most, LW_PI - most) };      /* folded to [0, pi/2] */
        CHECK_NEAR(r.transmission_min, fmin(ends[0], ends[1]), 1e-5, 0);
        CHECK_NEAR(r.transmission_max, least < LW_PI/2 && most > LW_PI/2 ? LW_PI/2 : fmax(ends[0], ends[1]), 1e-5, 0);
        CHECK_NEAR(r.curve_max, farthest, 0.5*stride, 0);           /* 720 looks against 3600      */
    }
}

/* The curve of an open target of few stations, looked at as often as one likes, leaves the target no farther than the report says. */
TEST(stray_is_that_of_a_dense_curve)
{
    enum { LOOKS = 8000 };
    FREED lw_vec2 *curve = malloc(sizeof *curve*(LOOKS + 1));
    lw_rng rng = check_rng(14);
    for (int trial = 0; trial < 20; trial++) {
        OWN(made) k = { 0 };
        make("crank-rocker", trial % 2 ? 1 : -1, LW_TASK_PATH, 0, &rng, &k);
        made_free(&k);
        k.st.closed = false;
        k.st.n = 5;
        target_of(&k.st, &k.spec, &k.t);
        claim(&k);
        lw_fit_report r = report_of(&k);
        for (int q = 0; q <= LOOKS; q++)
            curve[q] = fourbar_at(k.c.dim, k.m.mode, k.st.input[0] + (k.st.input[4] - k.st.input[0])*q/LOOKS).p;
        lw_stray dense = lw_likeness_stray(&k.t, curve, LOOKS + 1);
        /* 1600 looks miss a crest of the distance by up to 6e-3 of it, where the curve has a corner; 48 looks, by up to 0.05 */
        CHECK_NEAR(r.stray.to_target, dense.to_target, 1e-9, 7e-3);
    }
}

TEST(cognates_trace_the_curve)
{
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 20; trial++) {
        OWN(made) k = { 0 };
        make("crank-rocker", trial % 2 ? 1 : -1, LW_TASK_PATH, 0, &rng, &k);
        lw_fit_report r = report_of(&k);
        CHECK_INT(r.n_cognate, 2);
        for (size_t i = 0; i < 9; i++) {
            lw_vec2 p = lw_v2(k.st.x[i], k.st.y[i]);
            double turn[2], mode[2];
            CHECK_INT(lw_fourbar_cognate_posture(k.c.dim, k.m.mode, k.input[i], turn, mode), LW_OK);
            CHECK_NEAR(remainder(turn[0] - k.input[i], 2*LW_PI), 0, 1e-12, 0);
            CHECK(mode[0] == r.cognate_mode[0]);
            for (int which = 0; which < 2; which++) {
                lw_vec2 on = fourbar_at(r.cognate[which], mode[which], turn[which]).p;
                CHECK(lw_v2_norm(lw_v2_sub(on, p)) < 1e-7*k.t.size);       /* near limits half the digits */
            }
        }
    }
}

/* ---- the check can fail ----------------------------------------------------------------------------- */

static int by_objective(const void *a, const void *b)
{
    double u = ((const lw_candidate *)a)->objective, v = ((const lw_candidate *)b)->objective;
    return (u > v) - (u < v);
}

/* Claim N copies of k whose dimensions differ by less than 2 %, but for the last one, `scale` times as large; best first. */
enum { COPIES = 8 };
static void claim_copies(const made *k, double scale, lw_rng *rng, made copy[COPIES], lw_candidate c[COPIES])
{
    for (int i = 0; i < COPIES; i++) {
        copy[i] = *k;
        for (int d = 0; d < k->m.plan.n_dim; d++)
            if (k->m.plan.dim[d].kind != LW_DIM_ANGLE)
                copy[i].m.dim[d] *= (i == COPIES - 1 ? scale : 1) + 0.008*(2*lw_rng_uniform(rng) - 1);
        claim(&copy[i]);
        c[i] = copy[i].c;
        c[i].input = copy[i].input;
    }
    qsort(c, COPIES, sizeof *c, by_objective);
}

/* They are one row, though one has less error and another less stray; one a tenth smaller is another row, or the only one if it is
 * better in all. */
TEST(the_same_mechanism_is_one_row)
{
    lw_rng rng = check_rng(15);
    int differ = 0;
    for (int trial = 0; trial < 12; trial++) {
        const bool smaller = trial % 2;
        made k, copy[COPIES];
        lw_candidate c[COPIES];
        OWN(lw_fit_results) found = { 0 };
        make("crank-rocker", 1, LW_TASK_PATH, smaller ? 0.3 : 0.02, &rng, &k);
        lw_fit_spec_set_limits(&k.spec, &k.t, LW_LIMIT_ALL & ~LW_LIMIT_SIZE);      /* copies on both sides of a limit would be two kinds */
        claim_copies(&k, smaller ? 0.9 : 1, &rng, copy, c);
        lw_fit fit = { .n = COPIES, .candidate = c };
        CHECK_INT(lw_fit_results_make(&k.t, &k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        int first = found.n > 0 ? found.candidate[0] : 0;
        bool alone = smaller && found.n == 1 && c[first].dim[0] < 0.95*c[(first + 1) % COPIES].dim[0];
        CHECK_INT(found.n, smaller && !alone ? 2 : 1);
        if (found.n > 0)
            differ += c[0].objective < 0.95*c[found.candidate[0]].objective;
        made_free(&k);
    }
    CHECK(differ > 0);
}

/* Of two linkages that are alike but for their size, the larger without error comes first; of a target known to its noise only, the smaller. */
TEST(errors_below_the_noise_do_not_count)
{
    lw_rng rng = check_rng(17);
    for (int trial = 0; trial < 12; trial++) {
        made k, smaller;
        OWN(lw_fit_results) found = { 0 };
        make("crank-rocker", 1, LW_TASK_PATH, 0, &rng, &k);
        lw_fit_spec_set_limits(&k.spec, &k.t, 0);
        smaller = k;
        for (int d = 0; d < k.m.plan.n_dim; d++)
            smaller.m.dim[d] *= k.m.plan.dim[d].kind != LW_DIM_ANGLE && d != k.m.plan.i_x0 && d != k.m.plan.i_y0 ? 0.99 : 1;
        claim(&smaller);
        lw_candidate c[] = { k.c, smaller.c };
        c[0].input = k.input;
        c[1].input = smaller.input;
        lw_fit fit = { .n = 2, .candidate = c };
        k.t.noise = trial % 2 ? 1e4*k.t.extent : 0;
        CHECK_INT(lw_fit_results_make(&k.t, &k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        CHECK_INT(found.n, 1);
        CHECK(found.n < 1 || found.candidate[0] == trial % 2);
        made_free(&k);
    }
}

/* Beside errors of manufacture, a thousandth of the target, half of that costs less than two thirds more size, ten times a thousandth costs more.  A
 * linkage of three targets is made less exactly than a small one: that it would meet the target does not pay for its size. */
TEST(errors_below_those_of_manufacture_cost_little)
{
    static const struct { double large, small, error; int first; } row[] = { { 2.1, 1.25, 5e-4, 1 }, { 2.1, 1.25, 1e-2, 0 }, { 3.3, 1.9, 4e-3, 1 } };
    lw_rng rng = check_rng(18);
    for (size_t trial = 0; trial < sizeof row/sizeof *row; trial++) {
        OWN(made) k = { 0 };
        OWN(lw_fit_results) found = { 0 };
        make("crank-rocker", 1, LW_TASK_PATH, 0, &rng, &k);
        lw_fit_spec_set_limits(&k.spec, &k.t, LW_LIMIT_ALL & ~LW_LIMIT_SIZE);
        lw_candidate c[] = { k.c, k.c };
        lw_fit_report r[] = { report_of(&k), report_of(&k) };
        for (int i = 0; i < 2; i++) {
            c[i].input = k.input;
            c[i].report = &r[i];
            r[i].as_made = 1e-3*k.t.extent;
            r[i].size = (i == 0 ? row[trial].large : row[trial].small)*k.t.extent;
        }
        r[1].error_max = r[1].stray.to_curve = r[1].stray.to_target = row[trial].error*k.t.extent;
        c[1].objective = r[1].error_max*r[1].error_max;
        c[1].dim[0] *= 1.1;                                  /* not the same mechanism */
        lw_fit fit = { .n = 2, .candidate = c };
        CHECK_INT(lw_fit_results_make(&k.t, &k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        CHECK(found.n > 0 && found.candidate[0] == row[trial].first);
    }
}

/* A crank-rocker and a linkage of six links that has its report but other errors, over the extent of the target. */
typedef struct four_and_six { made k; lw_family six; lw_candidate c[2]; lw_fit_report r[2]; } four_and_six;

static void make_four_and_six(lw_rng *rng, double off_of_six, double off_of_four, four_and_six *p)
{
    make("crank-rocker", 1, LW_TASK_PATH, 0, rng, &p->k);
    lw_fit_spec_set_limits(&p->k.spec, &p->k.t, LW_LIMIT_ALL & ~LW_LIMIT_SIZE);
    p->six = *p->k.m.family;
    p->six.links = 6;
    for (int i = 0; i < 2; i++) {
        p->c[i] = p->k.c;
        p->r[i] = report_of(&p->k);
        p->c[i].input = p->k.input;
        p->c[i].report = &p->r[i];
        p->r[i].error_max = p->r[i].stray.to_curve = p->r[i].stray.to_target = (i == 0 ? off_of_six : off_of_four)*p->k.t.extent;
        p->c[i].objective = p->r[i].error_max*p->r[i].error_max;
    }
    p->c[0].family = &p->six;
}

/* A four-bar that misses the target by 1/500 comes before six links that meet it, one that misses it by 1/200 after them. */
TEST(two_links_more_cost_as_much_as_a_small_error)
{
    lw_rng rng = check_rng(21);
    for (int trial = 0; trial < 2; trial++) {
        four_and_six p;
        OWN(lw_fit_results) found = { 0 };
        make_four_and_six(&rng, 0, trial == 0 ? 0.002 : 0.005, &p);
        lw_fit fit = { .n = 2, .candidate = p.c };
        CHECK_INT(lw_fit_results_make(&p.k.t, &p.k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        CHECK(found.n > 0 && found.candidate[0] == (trial == 0 ? 1 : 0));
        lw_target_free(&p.k.t);
    }
}

/* Two four-bars of equal transmission angles: 1.5 diagonals with 0.5 % of error come before 2.6 diagonals with 0.2 %, 2.3 diagonals do not
 * come before 2.6. */
TEST(linkages_larger_than_compact_ones_cost_more)
{
    lw_rng rng = check_rng(23);
    for (int trial = 0; trial < 2; trial++) {
        four_and_six p;
        OWN(lw_fit_results) found = { 0 };
        make_four_and_six(&rng, 0.002, 0.005, &p);
        p.c[0].family = p.c[1].family;
        p.r[0].size = 2.6*p.k.t.extent;
        p.r[1].size = (trial == 0 ? 1.5 : 2.3)*p.k.t.extent;
        p.c[1].dim[0] *= 1.1;                                /* not the same mechanism */
        lw_fit fit = { .n = 2, .candidate = p.c };
        CHECK_INT(lw_fit_results_make(&p.k.t, &p.k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        CHECK(found.n > 0 && found.candidate[0] == (trial == 0 ? 1 : 0));
        lw_target_free(&p.k.t);
    }
}

/* A linkage of six diagonals that meets the target counts as many times one of 1.5 diagonals that misses it by 0.5 %: no row, unless it is
 * gentler; having more links does not help.  One of four diagonals is a row.  Where one of 1.5 diagonals misses the target by 3 %, one that
 * misses it by 2 % is a row whatever it counts as, one with 2.7 % is none. */
TEST(the_list_ends_where_quality_ends)
{
    static const struct { double size, gentle; bool more_links; double six, four; int rows; } row[] = {
        { 6, 0.5, false, 0, 0.005, 1 }, { 6, 0.7, false, 0, 0.005, 2 }, { 6, 0.5, true, 0, 0.005, 1 }, { 4, 0.5, false, 0, 0.005, 2 },
        { 6, 0.5, true, 0.02, 0.03, 2 }, { 6, 0.5, true, 0.027, 0.03, 1 }
    };
    lw_rng rng = check_rng(24);
    for (size_t trial = 0; trial < sizeof row/sizeof *row; trial++) {
        four_and_six p;
        OWN(lw_fit_results) found = { 0 };
        make_four_and_six(&rng, row[trial].six, row[trial].four, &p);
        p.c[0].family = row[trial].more_links ? p.c[0].family : p.c[1].family;
        p.r[0].size = row[trial].size*p.k.t.extent;
        p.r[1].size = 1.5*p.k.t.extent;
        p.r[0].transmission_min = row[trial].gentle;
        p.r[1].transmission_min = 0.5;
        p.c[1].dim[0] *= 1.1;                                /* not the same mechanism */
        lw_fit fit = { .n = 2, .candidate = p.c };
        CHECK_INT(lw_fit_results_make(&p.k.t, &p.k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        CHECK_INT(found.n, 2);
        lw_fit_results_end(&p.k.t, &fit, &found);
        CHECK_INT(found.n, row[trial].rows);
        CHECK_INT(found.candidate[0], 1);
        lw_target_free(&p.k.t);
    }
}

/* A kite whose pins A and C coincide turns its coupler about them, and its rocker rests: it is no result.  In its other mode it is a linkage. */
TEST(a_linkage_whose_pin_rests_is_no_result)
{
    lw_rng rng = check_rng(24);
    int rests = 0;
    for (int mode = -1; mode <= 1; mode += 2) {
        OWN(made) k = { 0 };
        make("crank-rocker", mode, LW_TASK_PATH, 0, &rng, &k);
        lw_target_free(&k.t);
        memcpy(k.m.dim, (const double[9]){ 2, 1, 1, 2, 0.5, 0.4, 0, 0, 0 }, 9*sizeof(double));
        k.st.closed = false;
        for (size_t i = 0; i < k.st.n; i++) {
            k.st.input[i] = 1.2 + 0.1*(double)i;
            lw_vec2 p = fourbar_at(k.m.dim, mode, k.st.input[i]).p;
            k.st.x[i] = p.x;
            k.st.y[i] = p.y;
        }
        target_of(&k.st, &k.spec, &k.t);
        claim(&k);
        lw_fit_spec_set_limits(&k.spec, &k.t, 0);
        lw_fit_report r = report_of(&k);
        const fourbar_joints at = fourbar_at(k.m.dim, mode, k.st.input[0]);
        const bool folded = lw_v2_norm(lw_v2_sub(at.b, at.a0)) < 1e-9;
        CHECK(r.rests == folded && (r.broken & LW_LIMIT_MARGIN) == (folded ? LW_LIMIT_MARGIN : 0));
        rests += r.rests;
    }
    CHECK_INT(rests, 1);
}

/* The best four-bar is the second row, not the last one after all linkages of six links. */
TEST(the_best_of_each_number_of_links_comes_first)
{
    lw_rng rng = check_rng(22);
    four_and_six p;
    OWN(lw_fit_results) found = { 0 };
    make_four_and_six(&rng, 0, 0.015, &p);
    lw_fit_report larger = p.r[0];
    lw_candidate c[3] = { p.c[0], p.c[0], p.c[1] };
    larger.size *= 1.5;                                      /* comes first by error */
    larger.stray.to_curve = larger.stray.to_target = 0;
    p.r[0].error_max = p.r[0].stray.to_curve = p.r[0].stray.to_target = 0.001*p.k.t.extent;
    c[0].objective = pow(p.r[0].error_max, 2);
    c[1].report = &larger;
    c[1].dim[0] *= 1.5;                                      /* not the same mechanisms */
    c[2].dim[0] *= 1.1;
    lw_fit fit = { .n = 3, .candidate = c };
    CHECK_INT(lw_fit_results_make(&p.k.t, &p.k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
    CHECK(found.n == 3 && lw_candidate_links(&c[found.candidate[0]]) == 6 && lw_candidate_links(&c[found.candidate[1]]) == 4);
    CHECK(found.n == 3 && found.report[1].counts_as > found.report[2].counts_as);
    lw_target_free(&p.k.t);
}

/* Between few stations a linkage may go on an arc through them, whether it meets them or not: its error there is what it surely misses
 * them by.  For a search that may go on, only a four-bar that meets them is as near. */
TEST(few_stations_are_missed_by_their_errors)
{
    lw_rng rng = check_rng(20);
    OWN(made) k = { 0 };
    make("crank-rocker", 1, LW_TASK_PATH, 0, &rng, &k);
    lw_fit_report r = report_of(&k);
    const double extent = k.t.extent;
    for (int trial = 0; trial < 3; trial++) {
        r.error_max = r.stray.to_curve = (trial == 0 ? 0 : 0.003)*extent;
        r.stray.to_target = 0.03*extent;
        r.stray.unsure = 0.028*extent;
        k.t.n = trial < 2 ? 8 : 30;
        CHECK_NEAR(lw_fit_report_known_miss(&k.t, &r, 0.05), (trial == 0 ? 0.002 : trial == 1 ? 0.003 : 0.03)*extent, 0, 1e-9*extent);
        CHECK_NEAR(lw_fit_report_distance(&k.t, &r), (trial == 0 ? 0.002 : 0.03)*extent, 0, 1e-9*extent);
    }
}

/* A four-bar that leaves the target by 8 % of its diagonal is no row beside six links that follow it, unless it alone turns fully. */
TEST(rows_far_from_the_target_end_where_another_is_near)
{
    lw_rng rng = check_rng(19);
    for (int trial = 0; trial < 3; trial++) {
        four_and_six p;
        OWN(lw_fit_results) found = { 0 };
        make_four_and_six(&rng, trial == 1 ? 0.03 : 0.01, 0.08, &p);
        p.r[0].turns = trial < 2;
        p.r[1].turns = true;
        p.c[1].dim[0] *= 1.1;                                /* not the same mechanism */
        lw_fit fit = { .n = 2, .candidate = p.c };
        CHECK_INT(lw_fit_results_make(&p.k.t, &p.k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        CHECK_INT(found.n, trial == 0 ? 1 : 2);
        lw_target_free(&p.k.t);
    }
}

/* Of a function met to 0.003 degrees the linkage with the smallest error is a row beside, but none between whose lengths differ more, too. */
TEST(rows_of_a_function_end_where_one_is_fine)
{
    OWN(made) k = { 0 };
    OWN(lw_fit_results) found = { 0 };
    lw_rng rng = check_rng(20);
    make("crank-rocker", 1, LW_TASK_FUNCTION, 0, &rng, &k);
    lw_fit_spec_set_limits(&k.spec, &k.t, 0);
    lw_candidate c[3];
    lw_fit_report r[3];
    for (int i = 0; i < 3; i++) {
        c[i] = k.c;
        c[i].input = k.input;
        r[i] = report_of(&k);
        c[i].report = &r[i];
        r[i].broken = 0;
        r[i].angle_max = pow(10, -7 + i);
        c[i].objective = r[i].angle_max*r[i].angle_max;
        r[i].length_least = 0.1*(i + 1);
        r[i].length_most = 1;
        c[i].dim[0] *= 1 + 0.1*i;                            /* not the same mechanism */
    }
    lw_fit fit = { .n = 3, .candidate = c };
    CHECK_INT(lw_fit_results_make(&k.t, &k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
    CHECK(found.n == 2 && found.candidate[0] == 2 && found.candidate[1] == 0);
}

/* The measures of a row: error, stray, Chamfer distance, size, and transmission angle up to 45 degrees.  Less is better. */
enum { ROW_MEASURES = 5 };
static void measures_of(const lw_fit_report *r, double m[ROW_MEASURES])
{
    const double all[ROW_MEASURES] = { r->objective, lw_fit_report_stray(r), r->likeness.chamfer, r->size, -fmin(r->transmission_min, LW_PI/4) };
    memcpy(m, all, sizeof all);
}

/* A row after the first is the best so far in a measure, by more than a thousandth, or, beside each row before it, has 0.7 of its size,
 * stray or error, or 5 degrees more. */
TEST(rows_earn_their_place)
{
    lw_rng rng = check_rng(16);
    int rows = 0;
    for (int trial = 0; trial < 40; trial++) {
        made k, copy[COPIES];
        lw_candidate c[COPIES];
        OWN(lw_fit_results) found = { 0 };
        make("crank-rocker", 1, LW_TASK_PATH, 0.1, &rng, &k);
        lw_fit_spec_set_limits(&k.spec, &k.t, 0);
        for (int i = 0; i < COPIES; i++) {                   /* most have the same size, that of r1; the one with the least error is longer */
            copy[i] = k;
            for (int d = 1; d < k.m.plan.n_dim && i > 0; d++)
                if (k.m.plan.dim[d].kind != LW_DIM_ANGLE)
                    copy[i].m.dim[d] *= 1 + 0.1*(2*lw_rng_uniform(&rng) - 1);
            *dim_named(&copy[i].m, "r1") *= i > 0 ? 1 : 1.01;
            claim(&copy[i]);
            c[i] = copy[i].c;
            c[i].input = copy[i].input;
        }
        qsort(c, COPIES, sizeof *c, by_objective);
        lw_fit fit = { .n = COPIES, .candidate = c };
        CHECK_INT(lw_fit_results_make(&k.t, &k.spec, &fit, 10, NULL, NULL, &found, NULL), LW_OK);
        for (int i = 1; i < found.n; i++) {
            double m[ROW_MEASURES], first[ROW_MEASURES];
            bool best[ROW_MEASURES] = { true, true, true, true, true }, any = false, covered = false;
            measures_of(&found.report[i], m);
            for (int j = 0; j < i; j++) {
                measures_of(&found.report[j], first);
                for (int n = 0; n < ROW_MEASURES; n++)
                    best[n] &= m[n] < first[n] - 0.99e-3*fabs(first[n]);
                covered |= found.report[j].turns >= found.report[i].turns && m[3] >= 0.7*first[3] && m[1] >= 0.7*first[1]
                        && m[0] >= 0.49*first[0] && (first[4] <= -LW_PI/4 || -m[4] <= -first[4] + 5*LW_PI/180);
            }
            for (int n = 0; n < ROW_MEASURES; n++)
                any |= best[n];
            CHECK(any || !covered);
            rows++;
        }
        made_free(&k);
    }
    CHECK(rows > 20);
}

TEST(what_was_tampered_with_is_not_verified)
{
    lw_rng rng = check_rng(6);
    for (int trial = 0; trial < 40; trial++) {
        OWN(made) k = { 0 };
        make(trial % 2 ? "crank-rocker" : "slider-crank", 1, (lw_task)(trial % 4 == 3 ? 2 : 0), 0.1, &rng, &k);
        CHECK(report_of(&k).verified);
        double keep = k.c.objective;
        k.c.objective *= 1 + 1e-6;
        CHECK(!report_of(&k).verified);
        k.c.objective = keep;
        k.c.dim[trial % 6] += 1e-3;
        CHECK(!report_of(&k).verified);
        k.c.dim[trial % 6] -= 1e-3;
        k.input[trial % 9] += 1e-2;
        lw_fit_report r = report_of(&k);
        CHECK(!r.verified);
        CHECK_HAS(r.fault, "objective");
        k.input[trial % 9] = NAN;
        CHECK(!report_of(&k).verified);
    }
}

/* Positions that the independent simulation does not find. */
TEST(positions_that_disagree_are_not_verified)
{
    lw_rng rng = check_rng(7);
    static const double by[] = { 0, 1e-8, 1e-3, NAN };
    for (int trial = 0; trial < 4; trial++) {
        OWN(made) k = { 0 };
        make("crank-rocker", 1, LW_TASK_PATH, 0.1, &rng, &k);
        lw_fit_report r = report_of(&k);
        lw_vec2 at[STATION_MAX];
        for (size_t i = 0; i < 9; i++)
            at[i] = fourbar_at(k.c.dim, 1, k.input[i]).p;
        at[4].x += by[trial]*k.t.length;
        r.verified = false;
        r.difference = r.verified_objective = 0;
        lw_verify(&k.t, &k.spec, &k.c, &k.m.plan, at, &r);
        CHECK_INT(r.verified, trial == 0);
        CHECK(trial == 0 || strstr(r.fault, "independent"));
    }
}

/* Stations along one circuit that swings from limit to limit, by phase as the search has them. */
static bool make_swing(lw_rng *rng, double side, made *k)
{
    static const double angle_of[] = { 0.3, 0.9, 1.5, 2.2, 2.9, 3.6, 4.4, 5.1, 5.9 };
    make("any four-bar", 1, LW_TASK_PATH, 0, rng, k);
    lw_motion m;
    CHECK_INT(lw_motion_find(&k->m.plan, k->m.dim, &m), LW_OK);
    const lw_arc *a = NULL;
    for (int i = 0; i < m.n_arc && !a; i++)
        if (m.arc[i].mode[0] > 0 && !m.arc[i].turns && m.arc[i].limit[0] && m.arc[i].limit[1]
            && (m.n_arc == 2 || side*(m.arc[i].first + m.arc[i].last) > 0))
            a = &m.arc[i];
    if (!a || m.change_point)
        return false;
    for (size_t i = 0; i < 9; i++) {
        lw_posture posture;
        k->mode[i] = sin(angle_of[i]) > 0 ? 1 : -1;
        k->st.input[i] = 0.5*(a->first + a->last) - 0.5*(a->last - a->first)*cos(angle_of[i]);
        CHECK_INT(lw_posture_solve(&k->m.plan, k->m.dim, &k->mode[i], k->st.input[i], 0, &posture), LW_OK);
        k->st.x[i] = posture.tracer[0][0].x;
        k->st.y[i] = posture.tracer[0][0].y;
    }
    shake_stations(&k->st, 0.05, rng);
    lw_target_free(&k->t);
    target_of(&k->st, &k->spec, &k->t);
    claim(k);
    k->c.mode_of = k->mode;
    k->c.objective = eq17(k);
    return true;
}

TEST(a_circuit_through_both_assemblies_is_verified)
{
    lw_rng rng = check_rng(8);
    int seen = 0;
    for (int trial = 0; trial < 40; trial++) {
        OWN(made) k = { 0 };
        if (make_swing(&rng, trial % 2 ? 1 : -1, &k)) {
            lw_fit_report r = report_of(&k);
            if (!r.verified)
                fprintf(stderr, "%s\n", r.fault);
            CHECK(r.verified);
            seen++;
        }
    }
    CHECK(seen >= 10);
}

/* Every station lies on the curve, but two of them are met in the wrong order. */
TEST(stations_out_of_order_are_refused)
{
    lw_rng rng = check_rng(18);
    int seen = 0;
    for (int trial = 0; trial < 20; trial++) {
        made k;
        if (make_swing(&rng, trial % 2 ? 1 : -1, &k)) {
            double *of[] = { k.st.x, k.st.y, k.st.input, k.mode };
            k.spec.timing = LW_TIMING_FREE;
            CHECK(report_of(&k).verified);
            for (int i = 0; i < 4; i++) {
                double now = of[i][2];
                of[i][2] = of[i][6];
                of[i][6] = now;
            }
            made_free(&k);
            target_of(&k.st, &k.spec, &k.t);
            claim(&k);
            k.c.mode_of = k.mode;
            k.c.objective = eq17(&k);
            lw_fit_report r = report_of(&k);
            CHECK(!r.verified);
            CHECK_HAS(r.fault, "out of order");
            seen++;
        }
        made_free(&k);
    }
    CHECK(seen >= 5);
}

/* A crank-rocker has two circuits, one an assembly: nobody gets from one to the other. */
TEST(stations_in_two_circuits_are_refused)
{
    lw_rng rng = check_rng(9);
    for (int trial = 0; trial < 10; trial++) {
        OWN(made) k = { 0 };
        make(trial % 2 ? "crank-rocker" : "slider-crank", 1, LW_TASK_PATH, 0.1, &rng, &k);
        for (size_t i = 0; i < 9; i++)
            k.mode[i] = i < 5 ? 1 : -1;
        k.c.mode_of = k.mode;
        k.c.n_dyad = 1;
        k.c.objective = eq17(&k);
        lw_fit_report r = report_of(&k);
        CHECK(!r.verified);
        CHECK_HAS(r.fault, "station 6 lies on another branch");
    }
}

/* A double rocker of Grashof's kind: in one assembly its input has two ranges with a gap between. */
TEST(stations_beyond_a_gap_are_refused)
{
    lw_rng rng = check_rng(10);
    static const double r[4] = { 3, 2.5, 1, 2.6 };        /* the coupler is the shortest          */
    OWN(made) k = { 0 };
    make("any four-bar", 1, LW_TASK_PATH, 0, &rng, &k);
    memcpy(k.m.dim, r, sizeof r);
    lw_motion m;
    CHECK_INT(lw_motion_find(&k.m.plan, k.m.dim, &m), LW_OK);
    CHECK_INT(m.n_circuit, 2);
    const lw_arc *arc[2];
    int n = 0;
    for (int i = 0; i < m.n_arc && n < 2; i++)
        if (m.arc[i].mode[0] > 0)
            arc[n++] = &m.arc[i];
    CHECK_INT(n, 2);
    for (size_t i = 0; n == 2 && i < 9; i++)
        k.st.input[i] = arc[i < 4 ? 0 : 1]->first + 0.1*(double)(i + 1)*(arc[0]->last - arc[0]->first);
    claim(&k);
    lw_fit_report report = report_of(&k);
    CHECK(!report.verified);
    CHECK_HAS(report.fault, "station 5 cannot be reached");
}

TEST(what_does_not_close_says_so)
{
    lw_rng rng = check_rng(11);
    OWN(made) k = { 0 };
    make("crank-rocker", 1, LW_TASK_PATH, 0, &rng, &k);
    k.c.dim[0] *= 100;
    lw_fit_report r = report_of(&k);
    CHECK(!r.verified);
    CHECK_HAS(r.fault, "close");
}

/* Size and place of the whole do not matter to the check. */
TEST(far_small_and_large_results_are_verified)
{
    static const double size[] = { 1e9, 1e-9, 1, 1e6 }, away[] = { 0, 3, 1e6, -2 };
    lw_rng rng = check_rng(12);
    for (int trial = 0; trial < 48; trial++) {
        static const char *const family[] = { "crank-rocker", "slider-crank", "any four-bar", "trammel" };
        double z = size[trial % 4], far = away[trial/4 % 4]*z;
        OWN(made) k = { 0 };
        make(family[trial/4 % 4], 1, LW_TASK_PATH, 0.05, &rng, &k);
        for (int i = 0; i < k.m.plan.n_dim; i++)
            k.m.dim[i] *= k.m.plan.dim[i].kind == LW_DIM_ANGLE ? 1 : z;
        *dim_named(&k.m, "x0") += far;
        *dim_named(&k.m, "y0") -= far;
        for (size_t i = 0; i < 9; i++) {
            k.st.x[i] = z*k.st.x[i] + far;
            k.st.y[i] = z*k.st.y[i] - far;
            k.st.input[i] *= k.m.plan.input_is_slider ? z : 1;
        }
        made_free(&k);
        target_of(&k.st, &k.spec, &k.t);
        claim(&k);
        lw_fit_report r = report_of(&k);
        if (!r.verified)
            fprintf(stderr, "%s, size %g: %s\n", k.m.family->name, z, r.fault);
        CHECK(r.verified);
    }
}

/* Sliding inputs go to and fro through both assemblies, and their guides have no place of their own: a
 * trammel that draws an ellipse exactly, and a yoke whose way is long beside its links, are simulated
 * again through their limits. */
TEST(sliding_inputs_pass_their_limits)
{
    static const char *const types[] = { "trammel", "wedge", "sliderdriven" };
    double x[20], y[20];
    for (int i = 0; i < 20; i++) {
        lw_vec2 p = lw_v2_turn(lw_v2(0.06*cos(0.1*LW_PI*i), 0.025*sin(0.1*LW_PI*i)), lw_v2(0.8, 0.6));
        x[i] = 0.1 + p.x;
        y[i] = 0.05 + p.y;
    }
    OWN(lw_target) t = { 0 };
    CHECK_INT(lw_target_make(20, x, y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    for (int k = 0; k < 3; k++) {
        lw_fit_options o = lw_fit_options_default();
        OWN(lw_fit) f = { 0 };
        lw_fit_report r;
        o.types = types[k];
        o.max_rounds = 2;
        o.n_result = 1;
        CHECK_INT(lw_fit_run(&t, &o, &f, NULL), LW_OK);
        CHECK_INT(f.n, 1);
        if (f.n == 1) {
            CHECK_INT(lw_fit_report_make(&t, &o.spec, &f.candidate[0], &r, NULL), LW_OK);
            CHECK_TEXT(r.fault, "");
            CHECK(r.verified);
            if (k == 0)
                CHECK_NEAR(r.error_max, 0, 1e-12, 0);
        }
    }
}

/* ---- limits and dead points ---------------------------------------------------------------------- */

/* The rate of a link, NaN where it cannot close. */
static double rate_of(const lw_plan *plan, const double *dim, const double *mode, int link, double input)
{
    lw_posture posture;
    bool there = lw_posture_solve(plan, dim, mode, input, 1, &posture) == LW_OK;
    return there ? posture.angle[link][1] : NAN;
}

/* Turns of links pinned to the ground change their sense as often as is said, and there; the input cannot be moved
 * beyond its limits, and up to them. Reversals counted. */
static int check_reversals(const lw_plan *plan, const lw_candidate *c, const double *mode, const lw_fit_report *r)
{
    enum { STEPS = 3000 };
    const lw_linkage *k = &r->linkage;
    int limits = 0, said = 0, seen = 0;
    double way = r->input_last - r->input_first;
    CHECK(c->input[0] >= r->input_first - 1e-12 && c->input[0] <= r->input_last + 1e-12);
    for (int i = 0; i < r->n_reversal; i++) {
        const lw_reversal *v = &r->reversal[i];
        limits += v->limit;
        said += !v->limit;
        if (v->limit) {
            double out = v->input > c->input[0] ? 1 : -1;
            CHECK(v->input == (out > 0 ? r->input_last : r->input_first));
            CHECK(isnan(rate_of(plan, c->dim, mode, 1, v->input + 1e-6*out)));
            CHECK(!isnan(rate_of(plan, c->dim, mode, 1, v->input - 1e-6*out)));
        } else
            CHECK_NEAR(rate_of(plan, c->dim, mode, v->link, v->input), 0, 1e-7, 0);
    }
    CHECK_INT(limits, r->turns ? 0 : 2);
    for (int j = 0; j < k->n_joint; j++) {
        if (j == plan->input_joint || (k->joint[j].link[0] != k->ground && k->joint[j].link[1] != k->ground))
            continue;
        int link = k->joint[j].link[k->joint[j].link[0] == k->ground];
        double before = NAN;
        for (int i = 0; i <= STEPS; i++) {
            double now = rate_of(plan, c->dim, mode, link, r->input_first + way*(1e-7 + (1 - 2e-7)*i/STEPS));
            seen += now*before < 0;
            before = now;
        }
    }
    CHECK_INT(seen, said);
    return said;
}

TEST(limits_and_dead_points_are_where_samples_change_sign)
{
    static const char *const family[] = { "crank-rocker", "drag-link", "any four-bar" };
    int found = 0;
    lw_rng rng = check_rng(17);
    for (int trial = 0; trial < 45; trial++) {
        OWN(made) k = { 0 };
        make(family[trial % 3], trial % 2 ? 1 : -1, LW_TASK_PATH, 0.05, &rng, &k);
        lw_fit_report r = report_of(&k);
        found += check_reversals(&k.m.plan, &k.c, k.c.intended.mode, &r);
    }
    CHECK(found > 30);
}

/* ---- higher groups ------------------------------------------------------------------------------- */

/* Stephenson III driven where its dyad stands on the ground: a triad.  crank: length of the driven link. */
static lw_linkage triad_linkage(double crank)
{
    static const char form[] =
        "{\"linkwright\":1,\"name\":\"triad\",\"links\":[\"ground\",\"bar\",\"coupler\",\"rocker\",\"arm\",\"crank\"],"
        "\"joints\":[{\"name\":\"A\",\"links\":[\"ground\",\"bar\"],\"at\":[0,0]},"
        "{\"name\":\"B\",\"links\":[\"bar\",\"coupler\"],\"at\":[0.5,0.8]},"
        "{\"name\":\"C\",\"links\":[\"coupler\",\"rocker\"],\"at\":[2.6,2.1]},"
        "{\"name\":\"D\",\"links\":[\"ground\",\"rocker\"],\"at\":[3,0]},{\"name\":\"E\",\"links\":[\"coupler\",\"arm\"],\"at\":[1.1,2.4]},"
        "{\"name\":\"F\",\"links\":[\"arm\",\"crank\"],\"at\":[%.17g,3]},"
        "{\"name\":\"G\",\"links\":[\"ground\",\"crank\"],\"at\":[-1.5,3]}],"
        "\"input\":{\"joint\":\"G\"},\"tracers\":[{\"name\":\"P\",\"link\":\"arm\",\"at\":[0.2,2.9]}]}";
    char text[2048];
    lw_linkage k;
    lw_error e = { .text = "" };
    int n = snprintf(text, sizeof text, form, -1.5 + crank);
    CHECK_INT(lw_linkage_read(text, (size_t)n, "triad", &k, &e), LW_OK);
    return k;
}

/* Turns and swings of triads: against postures followed densely and differences of them. */
TEST(motion_of_higher_groups)
{
    enum { N = 2000, STATIONS = 12 };
    static const struct { double crank, way; bool turns; } known[] = { { 0.2, 2*LW_PI, true }, { 1.2, 0.4, false } };
    for (size_t i = 0; i < 2; i++) {
        lw_linkage k = triad_linkage(known[i].crank);
        const lw_family family = { .name = "triad", .linkage = &k, .links = 6 };
        lw_plan plan;
        double dim[LW_DIM_MAX], mode[LW_MODE_MAX], first, least = 9, most = 0, fastest = 0;
        lw_error e = { .text = "" };
        made m = { .spec = lw_fit_spec_default() };
        CHECK_INT(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true, .kind = LW_PLAN_HIGHER }, &plan, &e), LW_OK);
        CHECK_INT(plan.n_higher, 1);
        CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &first, &e), LW_OK);
        static lw_vec2 around[N + 3], *p = around + 1;
        for (int q = -1; q <= N + 1; q++) {
            lw_posture posture;
            CHECK_INT(lw_posture_solve(&plan, dim, mode, first + known[i].way*q/N, 0, &posture), LW_OK);
            p[q] = posture.tracer[0][0];
            if (q < 0 || q > N)
                continue;
            least = fmin(least, asin(sqrt(posture.margin)));
            most = fmax(most, asin(sqrt(posture.margin)));
        }
        for (int q = 0; q <= N; q++) {
            lw_vec2 bend = lw_v2_sub(lw_v2_add(p[q - 1], p[q + 1]), lw_v2_scale(p[q], 2));
            fastest = fmax(fastest, lw_v2_norm(bend)*N*N/(known[i].way*known[i].way));
        }
        m.c = (lw_candidate){ .family = &family, .intended = { .sense = 1 }, .n_dim = plan.n_dim, .input = m.input };
        memcpy(m.c.dim, dim, sizeof dim);
        memcpy(m.c.intended.mode, mode, sizeof mode);
        m.st.n = STATIONS;
        m.st.closed = known[i].turns;
        for (int q = 0; q < STATIONS; q++) {
            int at = known[i].turns ? q*N/STATIONS : q*N/(STATIONS - 1);
            m.input[q] = first + known[i].way*at/N;
            m.st.x[q] = p[at].x;
            m.st.y[q] = p[at].y;
        }
        target_of(&m.st, &m.spec, &m.t);
        lw_fit_report r = report_of(&m);
        CHECK_INT(r.turns, known[i].turns);
        CHECK_INT(r.circuits, known[i].turns ? 2 : 1);
        CHECK_NEAR(r.input_last - r.input_first, known[i].turns ? 2*LW_PI : 0.5093697156951267 + 1.8154101282362176, 1e-9, 0);
        CHECK(check_reversals(&plan, &m.c, mode, &r) > 1);
        CHECK_NEAR(r.transmission_min, least, 1e-4, 0);
        CHECK_NEAR(r.transmission_max, most, 1e-4, 0);
        CHECK_NEAR(r.acceleration_max, fastest, 0, 2e-3);
        CHECK(most > least + 0.01 && r.error_max < 1e-9);
        CHECK_TEXT(r.fault, "");
        CHECK(r.verified);
        lw_target_free(&m.t);
    }
}
