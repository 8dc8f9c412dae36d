/* The rows of the table on real linkages: a four-bar from near its dimensions, one held at a bound, one
 * held at a transmission angle, one that need not turn. */
#include "base/parallel.h"
#include "optimise/problem/family.h"
#include "optimise/solvers/record.h"
#include "tests/check.h"

#define N_STATION 12

/* r1 r2 r3 r4 cx cy x0 y0 theta0 */
static const double dims[9] = { 1.0, 0.35, 0.9, 0.75, 0.5, 0.3, 2, -1, 0.4 };

/* Coupler point by hand: two circles, the upper assembly. */
static lw_vec2 coupler_point(const double d[9], double input)
{
    lw_vec2 a = lw_v2_polar(d[1], input), ab = lw_v2_sub(lw_v2(d[0], 0), a);
    double l = lw_v2_norm(ab), cosine = (d[2]*d[2] + l*l - d[3]*d[3])/(2*d[2]*l);
    lw_vec2 along = lw_v2_turn(lw_v2_scale(ab, 1/l), lw_v2(cosine, sqrt(1 - cosine*cosine)));
    lw_vec2 p = lw_v2_add(a, lw_v2_turn(lw_v2(d[4], d[5]), along));
    return lw_v2_add(lw_v2(d[6], d[7]), lw_v2_turn(p, lw_v2_polar(1, d[8])));
}

typedef enum held { FREE, BOUND, TRANSMISSION, NO_TURN } held;

/* The problem of tracing what `dims` traces, and its variables there. */
static void make_problem(held how, lw_problem *p, double *x)
{
    double px[N_STATION], py[N_STATION], angle[N_STATION];
    lw_fit_spec spec = lw_fit_spec_default();
    OWN(lw_target) t = { 0 };
    spec.timing = LW_TIMING_PRESCRIBED;
    if (how == BOUND) {
        spec.n_bound = 1;
        spec.bound[0] = (lw_bound){ "r2", 0.1, 0.33 };
    }
    if (how == TRANSMISSION)                          /* dims itself comes to 50 degrees */
        spec.min_transmission = 62*LW_PI/180;
    for (int i = 0; i < N_STATION; i++) {
        lw_vec2 q = coupler_point(dims, angle[i] = 2*LW_PI*i/N_STATION);
        px[i] = q.x;
        py[i] = q.y;
    }
    const lw_family *f = lw_family_table;
    while (strcmp(f->name, how == NO_TURN ? "any four-bar" : "crank-rocker") != 0)
        f++;
    CHECK_OK(lw_target_make(N_STATION, px, py, NULL, angle, NULL, 1, &t, &check_error));
    CHECK_OK(lw_problem_make(&t, &spec, f, 1, 1, p, &check_error));
    lw_problem_from_dims(p, dims, x);
    x[p->i_input0] = 0;
}

static void perturb(const lw_problem *p, double by, uint64_t stream, double *x)
{
    lw_rng rng = check_rng(stream);
    for (int i = 0; i < p->n_var; i++)
        x[i] += by*lw_rng_normal(&rng);
}

static void *new_work(const lw_problem *p)
{
    void *work = aligned_alloc(64, (lw_problem_work_size(p) + 127)/64*64);
    lw_problem_work_init(p, work);
    return work;
}

/* The result is what it says, and feasible. */
static void check_result(const lw_problem *p, const lw_solver *s, const double *x, const lw_solver_result *r, long max_evals)
{
    FREED void *work = new_work(p);
    size_t m = lw_problem_constraint_count(p);
    FREED double *g = calloc(m + 1, sizeof *g);
    CHECK_NEAR(lw_problem_value(p, x, NULL, work), r->f, 1e-29, 1e-12);    /* (1e-15)^2 a station */
    lw_problem_constraints(p, x, g, NULL, work);
    for (size_t j = 0; j < m; j++)
        CHECK(g[j] >= -LW_FEASIBLE);
    for (int i = 0; i < p->n_var; i++)
        CHECK(s->global || (x[i] >= p->lo[i] && x[i] <= p->hi[i]));
    CHECK(r->evals <= max_evals);
}

/* f after at most 10000 evaluations from 2 % beside the dimensions that give 0.  The first group gets
 * there to rounding, the second comes near, the last, which search the box, only improve or do not
 * even that. */
static const struct { const char *name; double turn, no_turn; } level[] = {
    { "lm",         1e-26, 1e-26 }, { "lm-gsl",  1e-26, 1e-26 }, { "slsqp",      1e-26, 1e-26 },
    { "lbfgs",      1e-20, 1e-20 }, { "tnewton", 1e-20, 1e-20 }, { "bobyqa",     1e-12, 1e-12 },
    { "gradient",   1e-5,  1e-5  }, { "mma",     1e-3,  1e-3  }, { "ccsaq",      1e-3,  1e-3  },
    { "neldermead", 1e-6,  1e-6  }, { "cobyla",  1e-3,  1e-3  }, { "sbplx",      1e-3,  1e-3  },
    { "gradient-fixed", 1e-3, 1e-3 }, { "crs",   1e-2,  1e-2  }, { "mlsl",       1e-12, 1e-12 },
    { "esch",       0.5,   0.5   }, { "isres",   0.5,   0.5   }, { "direct",     0.5,   0.5   },
};
#define N_LEVEL (sizeof level/sizeof *level)

TEST(every_row_is_in_the_table)
{
    size_t n = 0;
    for (const lw_solver *s = lw_solver_table; s->name; s++, n++)
        CHECK(s->source && s->run && lw_solver_find(s->name) == s);
    CHECK_INT(n, N_LEVEL);
    CHECK_TEXT(lw_solver_table[0].name, "lm");
    CHECK(lw_solver_find("simplex") == NULL);
}

TEST(traces_what_a_four_bar_traced)
{
    for (int how = 0; how < 2; how++)
        for (size_t i = 0; i < N_LEVEL; i++) {
            const lw_solver *s = lw_solver_find(level[i].name);
            OWN(lw_problem) p = { 0 };
            double x[LW_VAR_MAX], want = how ? level[i].no_turn : level[i].turn;
            make_problem(how ? NO_TURN : FREE, &p, x);
            perturb(&p, 0.02, i, x);
            lw_solver_options o = lw_solver_options_default();
            lw_solver_result r;
            FREED void *work = new_work(&p);
            double before = lw_problem_value(&p, x, NULL, work);
            lw_status status = s->run(s, &p, &o, x, &r);
            CHECK(status == LW_OK || status == LW_STOPPED);
            if (!(r.f < want))
                fprintf(stderr, "%s: f = %g\n", s->name, r.f);
            CHECK(r.f < want && r.f <= before);
            check_result(&p, s, x, &r, o.max_evals);
        }
}

/* First-order conditions at an optimum on the upper bound of r2.  A method may end beside a bound, by what f, equal to 1e-9, allows. */
static void check_optimum_on_bound(const lw_problem *p, const double *x)
{
    FREED void *work = new_work(p);
    double g[LW_VAR_MAX], f = lw_problem_value(p, x, g, work), least = 1e-4*sqrt(f);     /* half of the digits of f */
    for (int i = 0; i < p->n_var; i++) {
        double room = g[i] < 0 ? p->hi[i] - x[i] : x[i] - p->lo[i];
        CHECK(fabs(g[i]) <= least || fabs(g[i])*room <= 1e-9*f);
    }
    CHECK(g[lw_problem_index(p, "r2")] < -least);
}

static const char *const exact[] = { "lm", "lm-gsl", "slsqp", "lbfgs", "tnewton" };
#define N_EXACT (sizeof exact/sizeof *exact)

/* Run exact[i] from beside x0; x gets the end. */
static double run_exact(size_t i, const lw_problem *p, double by, const double *x0, double *x)
{
    const lw_solver *s = lw_solver_find(exact[i]);
    lw_solver_options o = lw_solver_options_default();
    lw_solver_result r;
    memcpy(x, x0, LW_VAR_MAX*sizeof *x);
    perturb(p, by, i, x);
    lw_status status = s->run(s, p, &o, x, &r);
    CHECK(status == LW_OK || status == LW_STOPPED);
    check_result(p, s, x, &r, o.max_evals);
    return r.f;
}

TEST(agree_on_an_optimum_on_a_bound)
{
    OWN(lw_problem) p = { 0 };
    double x0[LW_VAR_MAX] = { 0 }, x[LW_VAR_MAX], first = 0;
    make_problem(BOUND, &p, x0);
    for (size_t i = 0; i < N_EXACT; i++) {
        double f = run_exact(i, &p, 0.02, x0, x);
        first = i == 0 ? f : first;
        CHECK_NEAR(f, first, 0, 1e-9);
        check_optimum_on_bound(&p, x);
    }
    CHECK(first > 1e-4);                              /* the bound really holds it */
}

/* Those that take conditions get there to their digits, L-BFGS in the barrier to three or more.  The truncated
 * Newton method stops early in the bent valley between the conditions in one run of five. */
TEST(agree_on_an_optimum_on_a_condition)
{
    static const double within[N_EXACT] = { 0, 1e-8, 1e-8, 1e-3, 5 };
    OWN(lw_problem) p = { 0 };
    double x0[LW_VAR_MAX] = { 0 }, x[LW_VAR_MAX], first = 0;
    make_problem(TRANSMISSION, &p, x0);
    for (size_t i = 1; i < N_EXACT; i++) {            /* lm leaves such conditions to the others */
        double f = run_exact(i, &p, 0.01, x0, x);
        first = i == 1 ? f : first;
        CHECK(f > first*(1 - 1e-8));
        CHECK_NEAR(f, first, 0, within[i]);
    }
    CHECK(first > 1e-3);
}

typedef struct batch { const lw_problem *p; const double *x; double (*out)[LW_VAR_MAX]; double *f; } batch;

static void run_job(void *context, size_t job, int thread)
{
    batch *b = context;
    (void)thread;
    lw_solver_options o = lw_solver_options_default();
    lw_solver_result r;
    o.seed = 3;
    o.max_evals = 1500;
    memcpy(b->out[job], b->x, sizeof b->out[job]);
    perturb(b->p, 0.02, 77, b->out[job]);
    lw_solver_table[job%N_LEVEL].run(&lw_solver_table[job%N_LEVEL], b->p, &o, b->out[job], &r);
    b->f[job] = r.f;
}

TEST(repeat_on_any_number_of_threads)
{
    enum { N_JOB = 2*N_LEVEL };
    static double one[N_JOB][LW_VAR_MAX], three[N_JOB][LW_VAR_MAX];
    double f1[N_JOB], f3[N_JOB], x[LW_VAR_MAX] = { 0 };
    OWN(lw_problem) p = { 0 };
    make_problem(FREE, &p, x);
    CHECK_INT(lw_parallel(1, N_JOB, run_job, &(batch){ &p, x, one, f1 }), LW_OK);
    CHECK_INT(lw_parallel(3, N_JOB, run_job, &(batch){ &p, x, three, f3 }), LW_OK);
    for (size_t j = 0; j < N_JOB; j++) {
        CHECK(memcmp(one[j], three[j], sizeof one[j]) == 0 && f1[j] == f3[j]);
        CHECK(memcmp(one[j], one[j%N_LEVEL], sizeof one[j]) == 0);
    }
}

TEST(obey_their_limits)
{
    static const long limit[] = { 1, 2, 3, 17, 200 };
    OWN(lw_problem) p = { 0 };
    double x0[LW_VAR_MAX];
    make_problem(FREE, &p, x0);
    perturb(&p, 0.02, 5, x0);
    for (const lw_solver *s = lw_solver_table + 1; s->name; s++)
        for (int k = 0; k < 6; k++) {
            double x[LW_VAR_MAX];
            memcpy(x, x0, sizeof x);
            int interrupt = k == 5;
            lw_solver_options o = lw_solver_options_default();
            lw_solver_result r;
            o.interrupt = &interrupt;
            o.max_evals = limit[k < 5 ? k : 4];
            lw_status status = s->run(s, &p, &o, x, &r);
            CHECK(r.evals <= o.max_evals);
            if (k == 5) {
                CHECK(status == LW_NOTHING && r.stop == LW_STOP_USER && r.evals == 0);
                CHECK(memcmp(x, x0, sizeof x) == 0);
            } else
                check_result(&p, s, x, &r, o.max_evals);
        }
}
