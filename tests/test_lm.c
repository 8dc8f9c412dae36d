/* Bounded least squares: finds its way back to known linkages, keeps bounds and conditions, and where it
 * rests on them no direction leads down (Karush, Kuhn and Tucker). */
#include "optimise/solvers/lm.h"
#include "tests/fit_problem.h"

static const char *const families[] = { "crank-rocker", "drag-link", "any four-bar", "slider-crank",
                                        "any slider-crank", "oscillating", "turning", "any inverted",
                                        "slotted crank", "trammel" };
enum { N_FAMILY = sizeof families/sizeof *families };

static bool make_case(const char *family, lw_task task, lw_timing timing, lw_fit_spec spec, double shake,
                      lw_rng *rng, lw_problem *p, double *x)
{
    member m;
    stations st;
    OWN(lw_target) t = { 0 };
    spec.task = task;
    spec.timing = timing;
    draw_member(family, 1, task == LW_TASK_FUNCTION, rng, &m);
    trace_member(&m, 14, &st);
    shake_stations(&st, shake, rng);
    target_of(&st, &spec, &t);
    lw_status status = lw_problem_make(&t, &spec, m.family, 1, 1, p, NULL);
    if (status != LW_OK)
        return false;
    variables_of(p, &m, x);
    double size = task == LW_TASK_FUNCTION ? x[lw_problem_index(p, m.family->shape[0])] : 1;
    for (int i = 0; i < p->n_dim; i++)                   /* in units of the length that is held     */
        x[i] /= p->plan.dim[i].kind == LW_DIM_ANGLE ? 1 : size;
    return true;
}

static void perturb(const lw_problem *p, double by, lw_rng *rng, double *x)
{
    for (int i = 0; i < p->n_var; i++)
        if (p->lo[i] < p->hi[i])
            x[i] += by*lw_rng_normal(rng);
}

static double improve_by(const lw_problem *p, bool bend, double *x, lw_stop *stop, long *evals)
{
    FREED void *work = new_work(p);
    lw_lm_options o = lw_lm_options_default();
    o.max_steps = 2000;
    o.f_tol = 1e-14;
    o.bend = bend;
    *evals = 0;
    double f = lw_lm_improve(p, &o, x, false, work, evals, stop);
    CHECK(*evals > 0 && *evals < 9000);
    return f;
}

static double improve(const lw_problem *p, double *x, lw_stop *stop)
{
    long evals;
    return improve_by(p, false, x, stop, &evals);
}

static bool feasible(const lw_problem *p, double *x)
{
    FREED void *work = new_work(p);
    bool found = lw_lm_feasible(p, x, work);
    return found;
}

static double value(const lw_problem *p, const double *x, double *grad)
{
    FREED void *work = new_work(p);
    double f = lw_problem_value(p, x, grad, work);
    return f;
}

static void check_inside(const lw_problem *p, const double *x)
{
    double size = 1;
    for (int i = 0; i < p->n_var; i++) {
        CHECK(x[i] >= p->lo[i] && x[i] <= p->hi[i]);
        size = fmax(size, i < p->n_dim && p->plan.dim[i].kind == LW_DIM_LENGTH ? x[i] : 0);
    }
    CHECK(linear_least(p, x) >= -1e-13*size);            /* a sum of four, rounded                */
}

/* From two percent beside; a few starts lie in another valley. */
TEST(finds_the_way_back)
{
    /* Percent of the fits of all families that find the way back.  At 150 seeds 99.8, 99.7, 99.5, 98.5 and 99.3 did: fewer than these come by
     * chance once in 1e5 runs.  Of one family (94.9 for the worst, free points of any four-bar) half do. */
    static const struct { lw_task task; lw_timing timing; int least; } kind[] = {
        { LW_TASK_PATH, LW_TIMING_PRESCRIBED, 95 }, { LW_TASK_MOTION, LW_TIMING_PRESCRIBED, 95 },
        { LW_TASK_FUNCTION, LW_TIMING_PRESCRIBED, 92 }, { LW_TASK_PATH, LW_TIMING_FREE, 90 },
        { LW_TASK_MOTION, LW_TIMING_FREE, 93 },
    };
    lw_rng rng = check_rng(1);
    for (size_t q = 0; q < sizeof kind/sizeof *kind; q++) {
        int all_back = 0, all_tried = 0;
        for (int k = 0; k < N_FAMILY; k++) {
            int back = 0, tried = 0;
            for (int trial = 0; trial < 10; trial++) {
                lw_problem p;
                lw_stop stop;
                double x[LW_VAR_MAX] = { 0 };
                if (!make_case(families[k], kind[q].task, kind[q].timing, lw_fit_spec_default(), 0, &rng, &p, x))
                    break;
                if (!(value(&p, x, NULL) < 1e-20)) {     /* the stations are on the other circuit  */
                    lw_problem_free(&p);
                    continue;
                }
                perturb(&p, 0.02, &rng, x);
                feasible(&p, x);
                double before = value(&p, x, NULL), f = improve(&p, x, &stop);
                tried++;
                back += f < 1e-15;                       /* short arcs lie in flat valleys         */
                CHECK(!(f > before));
                lw_problem_free(&p);
            }
            if (2*back < tried)
                fprintf(stderr, "%s, kind %zu: %d of %d\n", families[k], q, back, tried);
            CHECK(2*back >= tried);
            all_back += back, all_tried += tried;
        }
        if (100*all_back < kind[q].least*all_tried)
            fprintf(stderr, "kind %zu: %d of %d\n", q, all_back, all_tried);
        CHECK(100*all_back >= kind[q].least*all_tried);
    }
}

/* Steps that follow the bend of a valley end as exactly as straight ones, and where these take long, in two thirds of the
 * evaluations at most. */
TEST(bent_steps_are_shorter_ways)
{
    lw_rng rng = check_rng(9);
    long evals[2] = { 0, 0 };
    int exact[2] = { 0, 0 }, slow = 0;
    for (int trial = 0; trial < 300; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[2][LW_VAR_MAX] = { { 0 } }, f[2];
        long used[2];
        lw_stop stop;
        if (!make_case(families[trial % N_FAMILY], LW_TASK_PATH, LW_TIMING_FREE, lw_fit_spec_default(), 0, &rng, &p, x[0]))
            continue;
        perturb(&p, 0.02, &rng, x[0]);
        feasible(&p, x[0]);
        memcpy(x[1], x[0], sizeof x[0]);
        for (int bend = 0; bend < 2; bend++) {
            f[bend] = improve_by(&p, bend, x[bend], &stop, &used[bend]);
            exact[bend] += f[bend] < 1e-22;
        }
        bool counts = f[0] < 1e-22 && f[1] < 1e-22 && used[0] > 100;
        for (int bend = 0; bend < 2 && counts; bend++)
            evals[bend] += used[bend];
        slow += counts;
        check_inside(&p, x[1]);
    }
    CHECK(exact[1] >= exact[0] - 2);
    CHECK(slow >= 8 && 3*evals[1] < 2*evals[0]);
}

TEST(never_ends_above_its_start)
{
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 60; trial++) {
        static const lw_timing timing[] = { LW_TIMING_PRESCRIBED, LW_TIMING_FREE, LW_TIMING_NONE };
        OWN(lw_problem) p = { 0 };
        lw_stop stop;
        double x[LW_VAR_MAX] = { 0 }, start[LW_VAR_MAX];
        if (!make_case(families[trial/3 % N_FAMILY], LW_TASK_PATH, timing[trial % 3], lw_fit_spec_default(), 0.3, &rng, &p, x))
            continue;
        perturb(&p, 0.1, &rng, x);
        feasible(&p, x);
        memcpy(start, x, sizeof x);
        double before = value(&p, x, NULL), f = improve(&p, x, &stop);
        CHECK(isfinite(before) ? f <= before : memcmp(start, x, sizeof x) == 0);
        if (isfinite(f)) {
            check_inside(&p, x);
            if (timing[trial % 3] != LW_TIMING_NONE && p.intended.turns && linear_least(&p, x) > 0.05)
                CHECK(value(&p, x, NULL) <= 1.2*f);      /* a fresh assignment is as good, or nearly */
        }
    }
}

/* ---- optimum on bounds and conditions ----------------------------------------------------------------- */

/* Largest first-order fall of f over directions that keep all active conditions to first order, by
 * projecting the gradient onto their cone: non-negative least squares, one row after the other. */
static double unresolved(const lw_problem *p, const double *x, const double *grad)
{
    enum { MOST = 2*LW_VAR_MAX + LW_LINEAR_MAX };
    double row[MOST][LW_VAR_MAX] = { { 0 } }, by[MOST] = { 0 }, rest[LW_VAR_MAX], worst = 0;
    int m = 0;
    for (int i = 0; i < p->n_var; i++) {
        rest[i] = p->lo[i] < p->hi[i] ? grad[i] : 0;
        if (p->lo[i] < p->hi[i] && x[i] == p->lo[i])
            row[m++][i] = 1;
        if (p->lo[i] < p->hi[i] && x[i] == p->hi[i])
            row[m++][i] = -1;
    }
    for (int j = 0; j < p->n_linear; j++) {
        double g = -LW_LINEAR_LEAST;
        for (int v = 0; v < p->n_var; v++)
            g += p->linear[j][v]*x[v];
        if (g < 1e-9)
            memcpy(row[m++], p->linear[j], sizeof row[0]);
    }
    for (int sweep = 0; sweep < 20000 && m > 0; sweep++) {
        int j = sweep % m;
        double a2 = 0, ar = 0;
        for (int i = 0; i < p->n_var; i++) {
            double a = p->lo[i] < p->hi[i] ? row[j][i] : 0;
            a2 += a*a;
            ar += a*rest[i];
        }
        double step = a2 > 0 ? fmax(-by[j], ar/a2) : 0;  /* multipliers stay >= 0                  */
        by[j] += step;
        for (int i = 0; i < p->n_var; i++)
            rest[i] -= p->lo[i] < p->hi[i] ? step*row[j][i] : 0;
    }
    for (int i = 0; i < p->n_var; i++)
        worst = fmax(worst, fabs(rest[i]));
    return worst;
}

/* The conditions hold it when the multipliers are there: f could fall without them. */
static int check_optimum(const lw_problem *p, const double *x, double f)
{
    double grad[LW_VAR_MAX], most = 0;
    CHECK_NEAR(value(p, x, grad), f, 1e-18, 1e-9);
    for (int i = 0; i < p->n_var; i++)
        most = fmax(most, p->lo[i] < p->hi[i] ? fabs(grad[i]) : 0);
    CHECK(unresolved(p, x, grad) <= 1e-4*sqrt(f));       /* half of the digits of f               */
    return most > 1e-2*sqrt(f);
}

TEST(rests_on_a_bound_as_it_should)
{
    lw_rng rng = check_rng(3);
    int held = 0;
    for (int trial = 0; trial < 60; trial++) {
        lw_fit_spec spec = lw_fit_spec_default();
        OWN(lw_problem) p = { 0 };
        lw_stop stop;
        double x[LW_VAR_MAX] = { 0 };
        if (!make_case(families[trial % N_FAMILY], LW_TASK_PATH, LW_TIMING_PRESCRIBED, spec, 0.02, &rng, &p, x))
            continue;
        for (int i = 0; i < 4; i++) {                    /* the way home is barred                  */
            p.lo[i] = x[i] - lw_rng_range(&rng, 0.05, 0.3);
            p.hi[i] = x[i] - (i == trial % 4 ? 0.04 : -0.3);
        }
        if (feasible(&p, x) && isfinite(value(&p, x, NULL))) {
            double f = improve(&p, x, &stop);
            check_inside(&p, x);
            if (stop != LW_STOP_EVALS && p.intended.turns)        /* others may end where they open          */
                held += check_optimum(&p, x, f);
        }
    }
    CHECK(held > 12);
}

/* A target from just behind the limit of turning: two lengths sum up to what the others allow. */
TEST(rests_on_the_limit_of_turning)
{
    lw_rng rng = check_rng(4);
    int held = 0;
    for (int trial = 0; trial < 40; trial++) {
        OWN(lw_problem) p = { 0 };
        lw_stop stop;
        double x[LW_VAR_MAX] = { 0 };
        make_case(trial % 2 ? "crank-rocker" : "slider-crank", LW_TASK_PATH, LW_TIMING_PRESCRIBED,
                  lw_fit_spec_default(), 0.02, &rng, &p, x);
        for (int j = 0; j < p.n_linear; j++) {           /* make the lengths' conditions stricter    */
            double g = 0, add = lw_rng_range(&rng, 0, 0.1);
            int i = lw_problem_index(&p, "r2");
            for (int v = 0; v < p.n_var; v++)
                g += p.linear[j][v]*x[v];
            p.linear[j][i] -= (g + add)/x[i]*(j == trial/2 % p.n_linear);
        }
        if (feasible(&p, x)) {
            double f = improve(&p, x, &stop);
            check_inside(&p, x);
            if (isfinite(f) && stop != LW_STOP_EVALS)
                held += check_optimum(&p, x, f) && linear_least(&p, x) < 1e-9;
        }
    }
    CHECK(held > 10);
}

/* ---- the nearest feasible point ----------------------------------------------------------------------- */

TEST(feasible_points_stay_and_others_move_little)
{
    lw_rng rng = check_rng(5);
    for (int trial = 0; trial < 200; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX] = { 0 }, start[LW_VAR_MAX];
        make_case(families[trial % 4], LW_TASK_PATH, LW_TIMING_FREE, lw_fit_spec_default(), 0.02, &rng, &p, x);
        for (int i = 0; i < p.n_dim; i++)                /* no draw is outside                      */
            if (p.plan.dim[i].kind != LW_DIM_ANGLE) {
                p.lo[i] = fmin(p.lo[i], x[i]);
                p.hi[i] = fmax(p.hi[i], x[i]);
            }
        memcpy(start, x, sizeof x);
        CHECK(feasible(&p, x));
        CHECK(memcmp(start, x, sizeof x) == 0);
        for (int i = 0; i < 4; i++)
            x[i] *= exp(0.5*lw_rng_normal(&rng));
        CHECK(feasible(&p, x));
        check_inside(&p, x);
        CHECK(memcmp(start + 4, x + 4, sizeof *x*5) == 0);       /* place and tracer: no reason   */
    }
}

/* Scattered points lie where f hardly rises: it rises as promised, and far less than over moves of the same length in any direction. */
TEST(scattered_points_keep_the_curve)
{
    const double rise = 1e-6, reach = 0.3;
    lw_rng rng = check_rng(7);
    double along = 0, across = 0, moved = 0;
    int n = 0;
    for (int trial = 0; trial < 20; trial++) {
        OWN(lw_problem) p = { 0 };
        double x[LW_VAR_MAX] = { 0 }, to[LW_VAR_MAX], other[LW_VAR_MAX], normal[LW_VAR_MAX];
        make_case("crank-rocker", LW_TASK_PATH, LW_TIMING_FREE, lw_fit_spec_default(), 0, &rng, &p, x);
        FREED void *work = new_work(&p);
        for (int i = 0; i < p.n_var; i++)
            normal[i] = lw_rng_normal(&rng);
        memcpy(to, x, sizeof x);
        if (!lw_lm_scatter(&p, rise, reach, normal, to, work))
            continue;
        double far = 0;
        for (int i = 0; i < p.n_var; i++)
            far = fmax(far, fabs(to[i] - x[i]));
        memcpy(other, x, sizeof x);
        perturb(&p, far/sqrt(p.n_var), &rng, other);
        double f = value(&p, to, NULL), g = value(&p, other, NULL);
        if (!isfinite(f) || !isfinite(g))
            continue;
        along += log(f);
        across += log(g);
        moved += far;
        n++;
    }
    CHECK(n > 10);
    CHECK(exp(along/n) < 20*reach*reach*rise);
    CHECK(exp(along/n) < 0.1*exp(across/n));
    CHECK(moved/n > 1e-3);
}

TEST(contradictions_are_found_out)
{
    lw_rng rng = check_rng(6);
    OWN(lw_problem) p = { 0 };
    double x[LW_VAR_MAX] = { 0 };
    make_case("crank-rocker", LW_TASK_PATH, LW_TIMING_FREE, lw_fit_spec_default(), 0.02, &rng, &p, x);
    for (int i = 0; i < 4; i++) {
        p.lo[i] = i == 1 ? 3 : 1;
        p.hi[i] = i == 1 ? 4 : 2;
    }
    CHECK(!feasible(&p, x));
}
