/* Assemblies of higher groups: the six postures of a triad against a scan, counts of the trusses of seven links. */
#include "mbs/assemblies.h"
#include "mbs/pose.h"
#include "tests/check.h"
#include "tests/mbs_random.h"

static lw_assemblies found;

/* A triad with six real postures (data/mbs: ground points, platform points, legs). */
static const lw_vec2 ground_at[3] = { { 0, 0 }, { 11, 0 }, { 19, 7 } }, plate[3] = { { 0, 0 }, { 8, 0 }, { -2, 9 } };
static const double leg[3] = { 13, 9, 17 };

/* With the plate turned by t the first two legs put its origin at one of two places; what the third lacks. */
static double lack(double t, double side, lw_vec2 *at)
{
    lw_vec2 turn = lw_v2_polar(1, t);
    lw_vec2 other = lw_v2_sub(ground_at[1], lw_v2_turn(plate[1], turn));
    double d = lw_v2_norm(lw_v2_sub(other, ground_at[0]));
    if (d > leg[0] + leg[1] || d < fabs(leg[0] - leg[1]))
        return NAN;
    *at = meet(ground_at[0], leg[0], other, leg[1], side);
    return lw_v2_norm(lw_v2_sub(lw_v2_add(*at, lw_v2_turn(plate[2], turn)), ground_at[2])) - leg[2];
}

/* Roots by a scan: angle and place of the plate. */
static int scan(double *angle, lw_vec2 *at)
{
    int n = 0;
    for (int side = -1; side <= 1; side += 2)
        for (int i = 0; i < 20000; i++) {
            lw_vec2 p;
            double a = 2*LW_PI*i/20000, b = 2*LW_PI*(i + 1)/20000, fa = lack(a, side, &p), fb = lack(b, side, &p);
            if (!(fa*fb <= 0))
                continue;
            for (int h = 0; h < 100; h++) {
                double m = 0.5*(a + b), fm = lack(m, side, &p);
                if ((fm > 0) == (fa > 0))
                    a = m;
                else
                    b = m;
            }
            lack(a, side, &at[n]);
            angle[n++] = a;
        }
    return n;
}

static void triad_with_crank(double angle, lw_vec2 at, lw_linkage *k)
{
    blank_linkage(k, 6);
    lw_vec2 p[3];
    for (int i = 0; i < 3; i++)
        p[i] = lw_v2_add(at, lw_v2_turn(plate[i], lw_v2_polar(1, angle)));
    add_pin(k, 0, 1, lw_v2(18, 7));
    add_pin(k, 0, 2, ground_at[0]);
    add_pin(k, 0, 3, ground_at[1]);
    add_pin(k, 1, 4, ground_at[2]);
    for (int i = 0; i < 3; i++)
        add_pin(k, 2 + i, 5, p[i]);
    add_input(k, 0, 0);
    add_tracer(k, 5, p[0]);
}

static void triad_has_six(void)
{
    double angle[16], dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    lw_vec2 at[16];
    lw_linkage k;
    static lw_plan plan;
    int n = scan(angle, at);
    CHECK_INT(n, 6);
    triad_with_crank(angle[0], at[0], &k);
    CHECK_INT(lw_plan_make_any(&k, (lw_want){ 1, true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
    CHECK_INT(lw_assemblies_find(&plan, dim, mode, input, 0, 1, 0, &found, NULL), LW_OK);
    CHECK_INT(found.n_complex, 6);
    CHECK_INT(found.n_real, 6);
    CHECK(found.complete);
    CHECK(found.residual < 1e-12);
    bool met[16] = { false };
    for (int i = 0; i < found.n_real; i++) {                  /* each is one of the scan, none twice */
        lw_pose pose;
        double own[LW_MODE_MAX];
        memcpy(own, mode, sizeof own);
        memcpy(own + plan.higher[0].first_mode, found.mode[i], 4*sizeof(double));
        CHECK_INT(lw_pose_solve(&plan, dim, own, input, 0, &pose), LW_OK);
        int hit = -1;
        for (int s = 0; s < n; s++)
            if (lw_v2_norm(lw_v2_sub(pose.tracer[0][0], at[s])) < 1e-9)
                hit = s;
        CHECK(hit >= 0 && !met[hit < 0 ? 0 : hit]);
        met[hit < 0 ? 0 : hit] = true;
    }
}

/* The Baranov trusses of seven links: link 0 taken for the ground, with a crank that carries nothing it holds. */
static const struct { int joint[9][2], n_mode; } truss[] = {
    { { { 0, 3 }, { 0, 4 }, { 0, 5 }, { 0, 6 }, { 1, 2 }, { 1, 3 }, { 1, 4 }, { 2, 5 }, { 2, 6 } }, 18 },
    { { { 0, 1 }, { 0, 2 }, { 0, 3 }, { 1, 4 }, { 1, 5 }, { 2, 4 }, { 2, 6 }, { 3, 5 }, { 3, 6 } }, 14 },
    { { { 0, 1 }, { 0, 2 }, { 0, 4 }, { 1, 3 }, { 1, 5 }, { 2, 5 }, { 2, 6 }, { 3, 4 }, { 3, 6 } }, 16 }
};

static void trusses_of_seven_links(void)
{
    lw_rng r;
    lw_rng_seed(&r, check_seed(), 9);
    for (int t = 0; t < 3; t++) {
        lw_linkage k;
        static lw_plan plan;
        double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
        blank_linkage(&k, 8);
        add_pin(&k, 0, 7, random_place(&r));                  /* the crank; the truss's first pin hangs on it */
        for (int j = 0; j < 9; j++)
            add_pin(&k, j == 0 ? 7 : truss[t].joint[j][0], truss[t].joint[j][1], random_place(&r));
        add_input(&k, 0, lw_linkage_posture_input(&k, 0));
        add_tracer(&k, 6, random_place(&r));
        CHECK_INT(lw_plan_make_any(&k, (lw_want){ 1, true }, &plan, NULL), LW_OK);
        CHECK_INT(plan.n_higher, 1);
        CHECK_INT(plan.higher[0].n_link, 6);
        CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
        CHECK_INT(lw_assemblies_find(&plan, dim, mode, input, 0, 1, 0, &found, NULL), LW_OK);
        CHECK_INT(found.n_complex, truss[t].n_mode);
        CHECK(found.n_real >= 1 && found.n_real%2 == 0);
        CHECK(found.residual < 1e-12);
        CHECK(!found.complete);
    }
}

static void says_what_is_wrong(void)
{
    static lw_plan plan;
    lw_linkage k;
    lw_error e;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    lw_type_linkage(lw_type_find("fourbar"), &k);
    CHECK_INT(lw_plan_make(&k, (lw_want){ 1, true }, &plan, NULL), LW_OK);
    CHECK_INT(lw_plan_read(&plan, &k, dim, mode, &input, NULL), LW_OK);
    CHECK_INT(lw_assemblies_find(&plan, dim, mode, input, 0, 1, 0, &found, &e), LW_E_ARG);
    CHECK_HAS(e.text, "the plan has 0");
}

int main(void)
{
    RUN(triad_has_six);
    RUN(trusses_of_seven_links);
    RUN(says_what_is_wrong);
    return check_end();
}
