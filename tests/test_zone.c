/* Conditions on places: a fit under them gives linkages that meet them, looked at in the linkages' own postures. */
#include "mbs/newton.h"
#include "optimise/report.h"
#include "tests/check.h"

static const double px[] = { 0, 1, 2, 3, 3.2, 2.6, 1.5, 0.4 }, py[] = { 0, 0.1, 0, 0.3, 1.2, 1.8, 1.7, 1.1 };

/* The best four-bar under the conditions of s. */
static bool best(const lw_fit_spec *s, lw_report *r)
{
    lw_fit_options o = lw_fit_options_default();
    lw_target t;
    lw_fit f;
    lw_error e = { .text = "" };
    o.spec = *s;
    o.max_rounds = 2;
    o.starts = 400;
    CHECK_INT(lw_target_make(8, px, py, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    CHECK_INT(lw_fit_run(&t, &o, &f, &e), LW_OK);
    bool found = false;
    for (int i = 0; i < f.n && !found; i++)
        found = lw_report_make(&t, s, &f.candidate[i], r, NULL) == LW_OK && r->verified;
    lw_fit_free(&f);
    lw_target_free(&t);
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

static void pivots_in_a_box_and_on_a_line(void)
{
    lw_report *r = malloc(sizeof *r);
    lw_fit_spec s = cranks();
    s.n_zone = 1;
    s.zone[0] = (lw_zone){ LW_ZONE_PIVOTS_BOX, { -2, -4 }, { 5, -1 }, 0 };
    if (best(&s, r))
        for (int j = 0; j < r->linkage.n_joint; j++)
            if (is_fixed(&r->linkage, j)) {
                lw_vec2 p = r->linkage.joint[j].at;
                CHECK(p.x >= -2 - 1e-6 && p.x <= 5 + 1e-6 && p.y >= -4 - 1e-6 && p.y <= -1 + 1e-6);
            }
    s.zone[0] = (lw_zone){ LW_ZONE_PIVOTS_LINE, { 0, -1.5 }, { 1, 0 }, 0.01 };
    if (best(&s, r))
        for (int j = 0; j < r->linkage.n_joint; j++)
            if (is_fixed(&r->linkage, j))
                CHECK_NEAR(r->linkage.joint[j].at.y, -1.5, 0.0101, 0);
    free(r);
}

static void nothing_enters_a_circle(void)
{
    lw_report *r = malloc(sizeof *r);
    lw_fit_spec s = cranks();
    lw_newton *n;
    s.n_zone = 1;
    s.zone[0] = (lw_zone){ LW_ZONE_NO_CIRCLE, { 1.6, 0.9 }, { 0, 0 }, 0.5 };
    if (best(&s, r) && lw_newton_create(&r->linkage, &n, NULL) == LW_OK) {
        double start = lw_newton_input(n), least = INFINITY;
        for (int k = 0; k <= 360; k++) {
            CHECK_INT(lw_newton_move(n, start + 2*LW_PI*k/360, NULL), LW_OK);
            for (int j = 0; j < r->linkage.n_joint; j++)
                least = fmin(least, lw_v2_norm(lw_v2_sub(lw_newton_joint(n, j), s.zone[0].at)));
        }
        CHECK(least > 0.5 - 0.02);                       /* looked at in 24 poses                   */
        lw_newton_free(n);
    }
    free(r);
}

static void lengths_of_one_order(void)
{
    lw_report *r = malloc(sizeof *r);
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
    free(r);
}

int main(void)
{
    RUN(pivots_in_a_box_and_on_a_line);
    RUN(nothing_enters_a_circle);
    RUN(lengths_of_one_order);
    return check_end();
}
