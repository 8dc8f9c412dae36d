/* The pool of finds: in order, each linkage once, never more than it holds. */
#include "optimise/search/pool.h"
#include "tests/fit_problem.h"

static void make_problem(lw_problem *p)
{
    static const double x[] = { 0, 1, 1, 0 }, y[] = { 0, 0, 1, 1 };
    lw_fit_spec s = lw_fit_spec_default();
    OWN(lw_target) t = { 0 };
    CHECK_INT(lw_target_make(4, x, y, NULL, NULL, NULL, 1, &t, NULL), LW_OK);
    CHECK_INT(lw_problem_make(&t, &s, family_named("crank-rocker"), 1, 1, p, NULL), LW_OK);
}

static lw_found find(double f, double first)
{
    lw_found c = { .f = f, .hits = 1 };
    for (int i = 0; i < 9; i++)
        c.x[i] = first + 0.1*i;
    return c;
}

static void check_order(const lw_pool *pool)
{
    CHECK(pool->n >= 0 && pool->n <= LW_POOL_MAX);
    for (int i = 0; i + 1 < pool->n; i++)
        CHECK(pool->item[i].f <= pool->item[i + 1].f);
}

TEST(keeps_the_best_in_order)
{
    static lw_pool pool;
    OWN(lw_problem) p = { 0 };
    double all[300];
    lw_rng rng = check_rng(1);
    make_problem(&p);
    lw_variables v = lw_pool_variables(&p);
    for (int i = 0; i < 300; i++) {
        lw_found c = find(all[i] = lw_rng_uniform(&rng), i);
        lw_pool_put(&pool, &c, &v);
        check_order(&pool);
        CHECK_INT(pool.n, i + 1 < LW_POOL_MAX ? i + 1 : LW_POOL_MAX);
    }
    for (int k = 0; k < pool.n; k++) {                   /* its k-th has k better ones               */
        int better = 0;
        for (int i = 0; i < 300; i++)
            better += all[i] < pool.item[k].f;
        CHECK_INT(better, k);
    }
}

/* Of many finds none is lost that is smaller, or was fitted with a greater transmission angle, than all with less error. */
TEST(keeps_those_that_no_better_one_is_as_small_and_gentle_as)
{
    static lw_pool pool;
    OWN(lw_problem) p = { 0 };
    lw_found all[300];
    int front = 0;
    lw_rng rng = check_rng(2);
    make_problem(&p);
    lw_variables v = lw_pool_variables(&p);
    for (int i = 0; i < 300; i++) {
        all[i] = find(lw_rng_uniform(&rng), i);
        all[i].size = exp(3*lw_rng_uniform(&rng));
        all[i].gentle = 10*(int)(3*lw_rng_uniform(&rng));
        lw_pool_put(&pool, &all[i], &v);
    }
    check_order(&pool);
    CHECK_INT(pool.n, LW_POOL_MAX);
    for (int i = 0; i < 300; i++) {
        bool wanted = true, held = false;
        for (int k = 0; k < 300; k++)
            wanted &= all[k].f >= all[i].f || all[k].size > 1.02*all[i].size || all[k].gentle < all[i].gentle;
        for (int k = 0; k < pool.n; k++)
            held |= pool.item[k].f == all[i].f;
        CHECK(held || !wanted);
        front += wanted;
    }
    CHECK(front > 8);
    double least = pool.item[0].f;
    lw_pool_shorten(&pool, 1);
    CHECK(pool.n == 1 && pool.item[0].f == least);
}

TEST(counts_what_comes_again)
{
    static lw_pool pool;
    OWN(lw_problem) p = { 0 };
    make_problem(&p);
    lw_variables v = lw_pool_variables(&p);
    lw_found a = find(1, 3), again = a, turned = a, other = a, candidate = a, none = a;
    again.f *= 1 - 1e-6;
    again.x[2] *= 1 + 1e-6;
    turned.x[p.plan.i_theta0] += 2*LW_PI;
    other.x[1] += 0.01;
    candidate.candidate = 1;
    none.f = INFINITY;
    lw_pool_put(&pool, &a, &v);
    lw_pool_put(&pool, &again, &v);
    CHECK_INT(pool.n, 1);
    CHECK(pool.item[0].f == again.f && pool.item[0].hits == 2);
    lw_pool_put(&pool, &turned, &v);                     /* worse: the better one stays              */
    CHECK_INT(pool.n, 1);
    CHECK(pool.item[0].f == again.f && pool.item[0].hits == 3);
    lw_pool_put(&pool, &other, &v);
    lw_pool_put(&pool, &candidate, &v);
    lw_pool_put(&pool, &none, &v);
    CHECK_INT(pool.n, 3);
    check_order(&pool);
}
