/* Conditions on places: a fit under them gives linkages that meet them, looked at in the linkages' own postures. */
#include "mbs/constraints/newton.h"
#include "optimise/report/report.h"
#include "tests/check.h"
#include "tests/fit_problem.h"

static const double px[] = { 0, 1, 2, 3, 3.2, 2.6, 1.5, 0.4 }, py[] = { 0, 0.1, 0, 0.3, 1.2, 1.8, 1.7, 1.1 };

/* The best four-bar under the conditions of s. */
static bool best(const lw_fit_spec *s, lw_fit_report *r)
{
    lw_fit_options o = lw_fit_options_default();
    OWN(lw_target) t = { 0 };
    OWN(lw_fit) f = { 0 };
    lw_error e = { .text = "" };
    o.spec = *s;
    o.max_rounds = 2;
    o.starts = 400;
    CHECK_INT(lw_target_make(8, px, py, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    CHECK_INT(lw_fit_run(&t, &o, &f, &e), LW_OK);
    bool found = false;
    for (int i = 0; i < f.n && !found; i++)
        found = lw_fit_report_make(&t, s, &f.candidate[i], r, NULL) == LW_OK && r->verified;
    CHECK(found);
    return found;
}

static lw_fit_spec cranks(void)
{
    lw_fit_spec s = lw_fit_spec_default();
    s.timing = LW_TIMING_FREE;
    s.crank_only = true;
    return s;
}

static bool is_fixed(const lw_linkage *k, int j)
{
    return k->joint[j].link[0] == k->ground || k->joint[j].link[1] == k->ground;
}

/* Does the report say that the linkage is at this limit, if its distance from it is less than a thousandth of the target's size? */
static void check_active(const lw_fit_report *r, const char *limit, double distance)
{
    const double thousandth = 1e-3*hypot(3.2, 1.8);
    bool said = false;
    for (int i = 0; i < r->n_active; i++)
        said |= strcmp(r->active[i], limit) == 0;
    CHECK(said ? distance < 1.1*thousandth : distance > 0.9*thousandth);
}

TEST(pivots_in_a_box_and_on_a_line)
{
    double inside = INFINITY;
    FREED lw_fit_report *r = malloc(sizeof *r);
    lw_fit_spec s = cranks();
    s.n_zone = 1;
    s.zone[0] = (lw_zone){ .kind = LW_ZONE_PIVOTS_BOX, .at = { -2, -4 }, .to = { 5, -1 }, .reach = 0 };
    if (best(&s, r))
        for (int j = 0; j < r->linkage.n_joint; j++)
            if (is_fixed(&r->linkage, j)) {
                lw_vec2 p = r->linkage.joint[j].at;
                CHECK(p.x >= -2 - 1e-6 && p.x <= 5 + 1e-6 && p.y >= -4 - 1e-6 && p.y <= -1 + 1e-6);
                inside = fmin(inside, fmin(fmin(p.x + 2, 5 - p.x), fmin(p.y + 4, -1 - p.y)));
            }
    check_active(r, "pivots", inside);
    s.zone[0] = (lw_zone){ .kind = LW_ZONE_PIVOTS_LINE, .at = { 0, -1.5 }, .to = { 1, 0 }, .reach = 0.01 };
    if (best(&s, r))
        for (int j = 0; j < r->linkage.n_joint; j++)
            if (is_fixed(&r->linkage, j))
                CHECK_NEAR(r->linkage.joint[j].at.y, -1.5, 0.0101, 0);
}

TEST(nothing_enters_a_circle)
{
    FREED lw_fit_report *r = malloc(sizeof *r);
    lw_fit_spec s = cranks();
    lw_newton *n;
    s.n_zone = 1;
    s.zone[0] = (lw_zone){ .kind = LW_ZONE_NO_CIRCLE, .at = { 1.6, 0.9 }, .to = { 0, 0 }, .reach = 0.5 };
    if (best(&s, r) && lw_newton_create(&r->linkage, &n, NULL) == LW_OK) {
        double start = lw_newton_input(n), least = INFINITY, point = INFINITY;
        for (int k = 0; k <= 360; k++) {
            CHECK_INT(lw_newton_move(n, start + 2*LW_PI*k/360, NULL), LW_OK);
            for (int j = 0; j < r->linkage.n_joint; j++)
                least = fmin(least, lw_v2_norm(lw_v2_sub(lw_newton_joint(n, j), s.zone[0].at)));
            point = fmin(point, lw_v2_norm(lw_v2_sub(lw_newton_tracer(n, 0), s.zone[0].at)));
        }
        check_active(r, "forbidden", fmin(least, point) - 0.5);
        CHECK(least > 0.5 - 0.02);                       /* looked at in 24 postures                   */
        lw_newton_free(n);
    }
}

/* A zone much smaller than the way between two postures, in the middle of it: the conditions see it, and only then. */
TEST(a_small_zone_is_not_stepped_over)
{
    member m;
    lw_problem p;
    lw_target t;
    stations st;
    double x[LW_VAR_MAX], g[4*LW_CURVE_SAMPLES + LW_LINEAR_MAX];
    lw_rng rng = check_rng(4);
    draw_member("crank-rocker", 1, false, &rng, &m);
    trace_member(&m, 12, &st);
    for (int k = 0; k < 60; k++) {
        lw_fit_spec s = lw_fit_spec_default();
        lw_posture posture;
        CHECK_INT(lw_posture_solve(&m.plan, m.dim, &m.mode, m.first + 2*LW_PI*(k + 0.3)/60, 0, &posture), LW_OK);
        lw_vec2 at = posture.tracer[0][0];
        bool box = k & 1, polygon = k % 4 > 1;              /* the box as a polygon; a thin triangle round the point */
        s.n_zone = 1;
        s.zone[0] = box ? (lw_zone){ .kind = LW_ZONE_NO_BOX, .at = { at.x - 0.02, at.y - 0.02 }, .to = { at.x + 0.02, at.y + 0.02 }, .reach = 0 }
                        : (lw_zone){ .kind = LW_ZONE_NO_CIRCLE, .at = at, .to = { 0, 0 }, .reach = 0.02 };
        if (polygon)
            s.zone[0] = box ? (lw_zone){ .kind = LW_ZONE_NO_POLYGON, .n_corner = 4, .corner = { { at.x - 0.02, at.y - 0.02 },
                                         { at.x - 0.02, at.y + 0.02 }, { at.x + 0.02, at.y + 0.02 }, { at.x + 0.02, at.y - 0.02 } } }
                            : (lw_zone){ .kind = LW_ZONE_NO_POLYGON, .n_corner = 3, .corner = { { at.x - 0.02, at.y - 0.01 },
                                         { at.x + 0.02, at.y - 0.01 }, { at.x, at.y + 0.02 } } };
        CHECK_INT(lw_zone_settle(&s.zone[0], NULL), LW_OK);
        for (int far = 0; far < 2; far++) {
            double least = INFINITY;
            target_of(&st, &s, &t);
            CHECK_INT(lw_problem_make(&t, &s, m.family, m.mode, 1, &p, NULL), LW_OK);
            variables_of(&p, &m, x);
            void *work = new_work(&p);
            CHECK(isfinite(lw_problem_value(&p, x, NULL, work)));
            size_t n = lw_problem_constraint_count(&p);
            lw_problem_constraints(&p, x, g, NULL, work);
            for (size_t i = (size_t)p.n_linear; i < n; i++)
                least = fmin(least, g[i]);
            CHECK(far ? least > 0 : least < 0);
            s.zone[0].at = lw_v2_add(s.zone[0].at, lw_v2(100, 0));           /* and the same, far away      */
            s.zone[0].to = lw_v2_add(s.zone[0].to, lw_v2(100, 0));
            for (int c = 0; c < s.zone[0].n_corner; c++)
                s.zone[0].corner[c] = lw_v2_add(s.zone[0].corner[c], lw_v2(100, 0));
            free(work);
            lw_problem_free(&p);
            lw_target_free(&t);
        }
    }
}

/* Conditions that contradict each other have no linkage, and none that breaks one of them is handed out. */
TEST(nothing_meets_a_contradiction)
{
    lw_fit_options o = lw_fit_options_default();
    OWN(lw_target) t = { 0 };
    OWN(lw_fit) f = { 0 };
    o.spec = cranks();
    o.spec.position_lo = 0;
    o.spec.position_hi = 1;
    o.spec.n_zone = 1;
    o.spec.zone[0] = (lw_zone){ .kind = LW_ZONE_PIVOTS_BOX, .at = { 5, 5 }, .to = { 6, 6 }, .reach = 0 };
    o.max_rounds = 1;
    o.starts = 8;
    CHECK_INT(lw_target_make(8, px, py, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    lw_status st = lw_fit_run(&t, &o, &f, NULL);
    CHECK(st == LW_NOTHING || st == LW_STOPPED);
    CHECK_INT(f.n, 0);
}

TEST(lengths_of_one_order)
{
    FREED lw_fit_report *r = malloc(sizeof *r);
    lw_fit_spec s = cranks();
    s.length_ratio = 2.5;
    if (best(&s, r)) {
        double least = INFINITY, most = 0;
        static const int pair[4][2] = { { 0, 1 }, { 1, 2 }, { 2, 3 }, { 3, 0 } };
        for (int i = 0; i < 4; i++) {
            double l = lw_v2_norm(lw_v2_sub(r->linkage.joint[pair[i][0]].at, r->linkage.joint[pair[i][1]].at));
            least = fmin(least, l);
            most = fmax(most, l);
        }
        CHECK(most <= 2.5*least*(1 + 1e-5));
    }
}
