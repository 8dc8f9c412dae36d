/* Turnings against closed forms: cosine rule for the four-bar, stroke ends of the slider-crank. */
#include "mbs/kinematics/output_limits.h"
#include "mbs/kinematics/fourbar.h"
#include "mbs/batch/posture.h"
#include "mbs/plan/types.h"
#include "tests/check.h"

/* a linkage of a type with these dimensions, and its plan */
static void setup(const char *type, lw_linkage *k, lw_plan *plan, double *dim, double *mode)
{
    double input;
    lw_type_linkage(lw_type_find(type), k);
    CHECK_OK(lw_plan_make(k, (lw_plan_options){ .tracers = 1, .all_joints = true }, plan, &check_error));
    CHECK_OK(lw_plan_read(plan, k, dim, mode, &input, &check_error));
}

static void set(const lw_plan *plan, double *dim, const char *name, double v)
{
    int i = lw_plan_dim(plan, name);
    CHECK(i >= 0);
    if (i >= 0)
        dim[i] = v;
}

/* Crank-rockers: the rocker stands still where crank and coupler are in line. */
TEST(rocker_turns_back_at_dead_points)
{
    lw_linkage k;
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    lw_rng rng = check_rng(1);
    setup("RRRR", &k, &plan, dim, mode);
    for (int trial = 0; trial < 100; trial++) {
        double s = lw_rng_range(&rng, 0.2, 1), p = lw_rng_range(&rng, 2, 3), q = lw_rng_range(&rng, 2, 3);
        double r[4] = { p, s, q, lw_rng_range(&rng, fmax(p, q) - 0.5, p + q - s - 0.3) };
        lw_fourbar_class c;
        lw_error e;
        if (lw_fourbar_classify(r, 1e-12, &c, &e) != LW_OK || c.number != 2)
            continue;
        for (int i = 0; i < 4; i++)
            set(&plan, dim, (const char *[]){ "r1", "r2", "r3", "r4" }[i], r[i]);
        lw_output_limits t[8];
        int n = lw_output_limits_find(&plan, &k, dim, mode, -LW_PI, LW_PI, t, 8);
        CHECK_INT(n, 2);
        for (int i = 0; i < n; i++) {
            double near = 10;
            for (int d = 0; d < c.n_dead; d++)
                near = fmin(near, fabs(remainder(t[i].input - c.dead[d], 2*LW_PI)));
            CHECK_NEAR(near, 0, 1e-9, 0);
        }
    }
}

/* Offset slider-crank: the stroke ends where crank and rod are in line, sin a = e/(l +- r). */
TEST(slider_turns_at_stroke_ends)
{
    lw_linkage k;
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    setup("RRRP", &k, &plan, dim, mode);
    lw_output_limits t[8];
    int n = lw_output_limits_find(&plan, &k, dim, mode, -LW_PI, LW_PI, t, 8);
    CHECK_INT(n, 2);
    for (int i = 0; i < n; i++) {
        lw_posture posture;
        CHECK_INT(lw_posture_solve(&plan, dim, mode, t[i].input, 1, &posture), LW_OK);
        lw_vec2 o = posture.joint[0][0], a = posture.joint[1][0], b = posture.joint[2][0];
        double sine = lw_v2_cross(lw_v2_sub(a, o), lw_v2_sub(b, o))/(lw_v2_norm(lw_v2_sub(a, o))*lw_v2_norm(lw_v2_sub(b, o)));
        CHECK_NEAR(sine, 0, 1e-12, 0);
    }
}

/* A double crank has none, and the list is never overrun. */
TEST(none_and_too_many)
{
    lw_linkage k;
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    lw_output_limits t[2] = { { -7, -7, -7 }, { -7, -7, -7 } };
    setup("RRRR", &k, &plan, dim, mode);
    static const double drag[4] = { 1, 4, 4.5, 4 }, rocker[4] = { 5, 2, 4, 4 };
    for (int i = 0; i < 4; i++)
        set(&plan, dim, (const char *[]){ "r1", "r2", "r3", "r4" }[i], drag[i]);
    CHECK_INT(lw_output_limits_find(&plan, &k, dim, mode, -LW_PI, LW_PI, t, 2), 0);
    for (int i = 0; i < 4; i++)
        set(&plan, dim, (const char *[]){ "r1", "r2", "r3", "r4" }[i], rocker[i]);
    CHECK_INT(lw_output_limits_find(&plan, &k, dim, mode, -LW_PI, LW_PI, t, 1), 1);
    CHECK_INT(t[1].link, -7);
}

/* Scott Russell the other way round: crank and rod equally long, no offset, the slider sits on the pivot
 * of the crank and only rounding moves it. */
TEST(standing_still_is_no_turning)
{
    lw_linkage k;
    lw_plan plan;
    double dim[LW_DIM_MAX], mode[LW_MODE_MAX];
    lw_output_limits t[8];
    setup("RRRP", &k, &plan, dim, mode);
    set(&plan, dim, "r2", 0.05);
    set(&plan, dim, "r3", 0.05);
    set(&plan, dim, "e1", 0);
    int n[2];
    for (int i = 0; i < 2; i++) {
        mode[0] = i ? -1 : 1;
        n[i] = lw_output_limits_find(&plan, &k, dim, mode, -1.4, 1.4, t, 8);
    }
    CHECK_INT(n[0] + n[1], 1);
}
