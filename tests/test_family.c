/* Families: what their conditions promise, by looking at 720 inputs of a turn. */
#include "mbs/batch/batch.h"
#include "tests/fit_problem.h"

enum { LOOKS = 720 };

/* Least margin of a shape over the turn. */
static double least_margin(const lw_plan *plan, const double *dim, double mode)
{
    double c[LOOKS], s[LOOKS], o[LOOKS], u[LOOKS], d[LOOKS], v[LOOKS], margin[LOOKS], least = INFINITY;
    double modes[LW_MODE_MAX] = { mode };
    FREED void *work = aligned_alloc(64, (lw_batch_work_size(plan) + 63)/64*64 + 64);
    for (int k = 0; k < LOOKS; k++) {
        c[k] = cos(2*LW_PI*k/LOOKS);
        s[k] = sin(2*LW_PI*k/LOOKS);
    }
    lw_lanes in = { .n = LOOKS, .c = c, .s = s, .dim = dim, .mode = modes };
    lw_batch_frame(plan, &in, 0, work, o, u, d, v, margin);
    for (int k = 0; k < LOOKS; k++)
        least = fmin(least, margin[k]);
    return least;
}

/* Value of a condition "+r3+r4-r1-r2" read independently: each name with the sign before it. */
static double condition(const lw_plan *plan, const char *text, const double *dim, double *gradient)
{
    double sum = 0;
    for (const char *at = text; *at; ) {
        char name[8] = "";
        double sign = *at++ == '-' ? -1 : 1;
        size_t n = strcspn(at, "+-");
        memcpy(name, at, n);
        at += n;
        int i = lw_plan_dim(plan, name);
        CHECK(i >= 0);
        sum += sign*dim[i];
        gradient[i] += sign;
    }
    return sum;
}

static void put_shape(const lw_family *f, const lw_plan *plan, lw_rng *rng, double *dim)
{
    double u[LW_DRAW_MAX], shape[LW_SHAPE_MAX] = { 0 };
    for (int i = 0; i < LW_DRAW_MAX; i++)
        u[i] = lw_rng_uniform(rng);
    f->draw(u, shape);
    memset(dim, 0, sizeof *dim*LW_DIM_MAX);
    for (int i = 0; f->shape[i]; i++) {
        int at = lw_plan_dim(plan, f->shape[i]);
        CHECK(at >= 0 && at < plan->n_dim);
        dim[at] = shape[i];
        CHECK(isfinite(shape[i]));
        CHECK(plan->dim[at].kind != LW_DIM_LENGTH || shape[i] > 0);
    }
}

TEST(rows_fit_their_types)
{
    for (const lw_family *f = lw_family_table; f->name; f++) {
        lw_plan plan;
        const lw_type *type = lw_type_find(f->type);
        CHECK(type && type->letters == lw_type_find(type->name)->letters);
        make_plan_of(f, false, &plan);
        CHECK(f->n_draw >= 1 && f->n_draw <= LW_DRAW_MAX);
        CHECK(f->turns || f->linear[0] == NULL);     /* a yoke turns without any condition */
        /* what the shape leaves out is place, tracer and nothing else */
        int n = 0;
        while (f->shape[n])
            n++;
        CHECK_INT(plan.n_dim - n, 5);
    }
}

TEST(draws_meet_their_conditions_and_turn)
{
    lw_rng rng = check_rng(1);
    for (const lw_family *f = lw_family_table; f->name; f++) {
        lw_plan plan;
        double dim[LW_DIM_MAX];
        make_plan_of(f, false, &plan);
        for (int trial = 0; f->turns && trial < 300; trial++) {
            double ignore[LW_DIM_MAX] = { 0 };
            put_shape(f, &plan, &rng, dim);
            for (int j = 0; j < 4 && f->linear[j]; j++)
                CHECK(condition(&plan, f->linear[j], dim, ignore) > 0);
            CHECK(least_margin(&plan, dim, 1) > 0);
            CHECK(least_margin(&plan, dim, -1) > 0);
        }
    }
}

/* A condition may be met by another link being the shortest: then the input still turns in none of the
 * families, except that s + l = p + q has two sides.  So each condition is violated on its own, a
 * little, from a draw that meets the others with ease. */
TEST(a_violated_condition_stops_the_turn)
{
    lw_rng rng = check_rng(2);
    for (const lw_family *f = lw_family_table; f->name; f++) {
        lw_plan plan;
        double dim[LW_DIM_MAX];
        int tried = 0;
        make_plan_of(f, false, &plan);
        for (int trial = 0; f->turns && trial < 300; trial++) {
            put_shape(f, &plan, &rng, dim);
            for (int j = 0; j < 4 && f->linear[j]; j++) {
                double way[LW_DIM_MAX] = { 0 }, moved[LW_DIM_MAX], none[LW_DIM_MAX] = { 0 }, w2 = 0;
                double now = condition(&plan, f->linear[j], dim, way);
                for (int i = 0; i < plan.n_dim; i++)
                    w2 += way[i]*way[i];
                bool others = true;
                for (int i = 0; i < plan.n_dim; i++)
                    moved[i] = dim[i] - way[i]*(now + 1e-3)/w2;
                for (int i = 0; i < 4 && f->linear[i]; i++)
                    others &= i == j || condition(&plan, f->linear[i], moved, none) > 1e-2;
                for (int i = 0; i < plan.n_dim; i++)
                    others &= plan.dim[i].kind != LW_DIM_LENGTH || moved[i] > 1e-2;
                if (!others)
                    continue;
                CHECK(least_margin(&plan, moved, 1) < 0);
                tried++;
            }
        }
        CHECK(!f->linear[0] || tried > 50);
    }
}

/* The families of four-bars cover what they say: every set of lengths whose input turns fully is a
 * crank-rocker (input shortest) or a drag link (frame shortest). */
TEST(four_bars_that_turn_are_in_a_family)
{
    lw_rng rng = check_rng(3);
    lw_plan plan;
    int turning = 0;
    make_plan_of(family_named("crank-rocker"), false, &plan);
    for (int trial = 0; trial < 4000; trial++) {
        double dim[LW_DIM_MAX] = { 0 }, none[LW_DIM_MAX] = { 0 }, least[2] = { 1, 1 };
        for (int i = 0; i < 4; i++)
            dim[i] = lw_rng_range(&rng, 0.3, 3);
        for (int k = 0; k < 2; k++) {
            const lw_family *f = family_named(k ? "drag-link" : "crank-rocker");
            for (int j = 0; j < 4 && f->linear[j]; j++)
                least[k] = fmin(least[k], condition(&plan, f->linear[j], dim, none));
        }
        if (fabs(least[0]) < 1e-3 || fabs(least[1]) < 1e-3)
            continue;                                    /* sampling cannot tell */
        bool turns = least_margin(&plan, dim, 1) > 0;
        turning += turns;
        CHECK_INT(turns, least[0] > 0 || least[1] > 0);
    }
    CHECK(turning > 500);
}
