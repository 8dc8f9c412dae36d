/* Phase one and repair on polytopes and balls with a known inside. */
#include "tests/check.h"
#include "tests/functions.h"
#include "optimise/solvers/feasible.h"

#define N 8
#define M 20

/* g_j = a_j . (x - inside) + room_j: satisfied with room at `inside`; the last one is a ball. */
typedef struct body { double a[M][N], room[M], inside[N], radius; int asked; } body;

static void body_conditions(void *context, const double *x, double *g, double *j)
{
    body *b = context;
    b->asked++;
    for (int i = 0; i < M; i++) {
        g[i] = b->room[i];
        for (int k = 0; k < N; k++) {
            g[i] += b->a[i][k]*(x[k] - b->inside[k]);
            if (j)
                j[i*N + k] = b->a[i][k];
        }
    }
    g[M] = b->radius*b->radius;
    for (int k = 0; k < N; k++) {
        double d = x[k] - b->inside[k];
        g[M] -= d*d;
        if (j)
            j[M*N + k] = -2*d;
    }
}

static void draw_body(lw_rng *rng, body *b)
{
    b->radius = lw_rng_range(rng, 0.3, 2);
    for (int k = 0; k < N; k++)
        b->inside[k] = lw_rng_range(rng, -1, 1);
    for (int i = 0; i < M; i++) {
        b->room[i] = lw_rng_range(rng, 0.001, 0.3);
        for (int k = 0; k < N; k++)
            b->a[i][k] = 0.3*lw_rng_normal(rng);
    }
}

static const double lo[N] = { -1, -1, -1, -1, -1, -1, -INFINITY, -INFINITY };
static const double hi[N] = { 1, 1, 1, 1, INFINITY, INFINITY, 1, INFINITY };

static lw_function body_function(body *b)
{
    return (lw_function){ .n = N, .m = M + 1, .lo = lo, .hi = hi, .context = b,
                          .conditions = body_conditions };
}

TEST(finds_the_inside)
{
    lw_solver_options o = lw_solver_options_default();
    lw_rng rng = check_rng(1);
    for (int trial = 0; trial < 300; trial++) {
        body b;
        draw_body(&rng, &b);
        lw_function fn = body_function(&b);
        lw_record r;
        CHECK_INT(lw_record_open(&r, &fn, &o), LW_OK);
        double x[N], again[N];
        for (int k = 0; k < N; k++)
            x[k] = 5*lw_rng_normal(&rng);
        CHECK(lw_feasible_start(&r, x));
        CHECK_NEAR(lw_record_violation(&r, x), 0, 0, 0);
        const double *g = lw_record_conditions(&r, x, false);
        for (int i = 0; i <= M; i++)
            CHECK(g[i] > 0);
        memcpy(again, x, sizeof x);
        CHECK(lw_feasible_start(&r, again));          /* what is inside stays */
        CHECK(memcmp(again, x, sizeof x) == 0);
        lw_record_close(&r);
    }
}

TEST(says_when_there_is_none)
{
    lw_solver_options o = lw_solver_options_default();
    lw_rng rng = check_rng(2);
    for (int trial = 0; trial < 20; trial++) {
        body b;
        draw_body(&rng, &b);
        for (int k = 0; k < N; k++)                   /* 0 > 1 contradicts 1: no x meets both */
            b.a[1][k] = -b.a[0][k];
        b.room[1] = -b.room[0] - 0.01;
        lw_function fn = body_function(&b);
        lw_record r;
        CHECK_INT(lw_record_open(&r, &fn, &o), LW_OK);
        double x[N] = { 0 };
        CHECK(!lw_feasible_start(&r, x));
        lw_record_close(&r);
    }
}

/* A user who asks to stop does not wait for all the random points. */
TEST(stops_when_asked)
{
    static const volatile int stop = 1;
    lw_solver_options o = lw_solver_options_default();
    body b;
    o.interrupt = &stop;
    lw_rng rng = check_rng(2);
    draw_body(&rng, &b);
    for (int k = 0; k < N; k++)
        b.a[1][k] = -b.a[0][k];
    b.room[1] = -b.room[0] - 0.01;
    b.asked = 0;
    lw_function fn = body_function(&b);
    lw_record r;
    CHECK_INT(lw_record_open(&r, &fn, &o), LW_OK);
    double x[N] = { 0 };
    CHECK(!lw_feasible_start(&r, x));
    CHECK(b.asked <= 3);
    lw_record_close(&r);
}

/* From d outside the ball of HS65 the way back is d, to first order. */
TEST(repairs_by_the_shortest_way)
{
    lw_function fn = hs65();
    lw_solver_options o = lw_solver_options_default();
    lw_record r;
    CHECK_INT(lw_record_open(&r, &fn, &o), LW_OK);
    for (double d = 1e-2; d > 1e-11; d *= 0.1) {
        double s = (sqrt(48) + d)/sqrt(48), y[3] = { 4*s, 4*s, 4*s }, x[3], way = 0;
        memcpy(x, y, sizeof x);
        CHECK(lw_feasible_repair(&r, x));
        CHECK(lw_record_violation(&r, x) <= LW_FEASIBLE);
        for (int k = 0; k < 3; k++)
            way += (x[k] - y[k])*(x[k] - y[k]);
        CHECK_NEAR(sqrt(way), d, 2e-12, d);           /* curvature: relative error d / radius, below d */
    }
    lw_record_close(&r);
}
