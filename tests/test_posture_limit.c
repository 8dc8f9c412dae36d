/* Postures within rounding of a limit of motion: finite, whatever the order asked for. */
#include "mbs/batch/posture.h"
#include "tests/planar_models.h"

static void check_finite(const lw_posture *p, const lw_plan *plan)
{
    for (int i = 0; i <= LW_ORDER_MAX; i++) {
        CHECK(isfinite(p->tracer[0][i].x) && isfinite(p->tracer[0][i].y));
        CHECK(isfinite(p->angle[plan->output_link[0]][i]));
    }
}

/* Jansen's leg in the mode +++, which closes on part of the turn only: walk onto each limit by
 * halving, then through the numbers next to it. */
TEST(finite_around_every_limit)
{
    static lw_linkage k;
    static lw_plan plan;
    static lw_posture posture;
    double dim[LW_DIM_MAX], file_mode[LW_MODE_MAX], file_input;
    load_linkage("examples/jansen.json", &k);
    CHECK_OK(lw_plan_make(&k, (lw_plan_options){ .tracers = 1, .all_joints = true }, &plan, &check_error));
    CHECK_OK(lw_plan_read(&plan, &k, dim, file_mode, &file_input, &check_error));
    int n_limit = 0;
    for (int set = 0; set < 1 << plan.n_dyad; set++) {
        double mode[LW_MODE_MAX];
        for (int d = 0; d < plan.n_dyad; d++)
            mode[d] = set >> d & 1 ? -1 : 1;
        for (int i = 0; i < 720; i++) {
            double in = i*LW_PI/360, out = (i + 1)*LW_PI/360;
            bool left = lw_posture_solve(&plan, dim, mode, in, 0, &posture) == LW_OK;
            if (left == (lw_posture_solve(&plan, dim, mode, out, 0, &posture) == LW_OK))
                continue;
            n_limit++;
            for (int step = 0; step < 60; step++) {
                double middle = 0.5*(in + out);
                bool closes = lw_posture_solve(&plan, dim, mode, middle, LW_ORDER_MAX, &posture) == LW_OK;
                check_finite(&posture, &plan);
                if (closes == left)
                    in = middle;
                else
                    out = middle;
            }
            for (double q = in - 1e-14; q < in + 1e-14; q = nextafter(q, 10)) {
                lw_posture_solve(&plan, dim, mode, q, LW_ORDER_MAX, &posture);
                check_finite(&posture, &plan);
            }
        }
    }
    CHECK(n_limit >= 4);
}
