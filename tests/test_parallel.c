/* Every job once, the same answer for any number of threads; and the clocks go forward. */
#include <sched.h>
#include <stdatomic.h>

#include "base/clock.h"
#include "base/parallel.h"
#include "tests/check.h"

enum { N_JOB = 5000, N_THREAD = 64 };

typedef struct work {
    atomic_int n_run[N_JOB];
    double     answer[N_JOB];
    atomic_int bad_thread;
    int        n_thread;
} work;

static void one(void *context, size_t job, int thread)
{
    work *w = context;
    lw_rng r;
    lw_rng_seed(&r, 5, job);
    atomic_fetch_add(&w->n_run[job], 1);
    w->answer[job] = lw_rng_uniform(&r);
    if (thread < 0 || thread >= w->n_thread)
        atomic_store(&w->bad_thread, 1);
}

TEST(each_job_once_for_any_number_of_threads)
{
    static work w, first;
    static const int threads[] = { 1, 2, 3, 7, N_THREAD };
    for (size_t k = 0; k < sizeof threads/sizeof *threads; k++) {
        memset(&w, 0, sizeof w);
        w.n_thread = threads[k];
        CHECK_INT(lw_parallel(threads[k], N_JOB, one, &w), LW_OK);
        for (int i = 0; i < N_JOB; i++)
            CHECK_INT(w.n_run[i], 1);
        CHECK(!w.bad_thread);
        if (k == 0)
            first = w;
        CHECK(memcmp(first.answer, w.answer, sizeof w.answer) == 0);
    }
}

TEST(fewer_jobs_than_threads_and_none)
{
    static work w;
    for (size_t n = 0; n < 4; n++) {
        memset(&w, 0, sizeof w);
        w.n_thread = N_THREAD;
        CHECK_INT(lw_parallel(N_THREAD, n, one, &w), LW_OK);
        for (size_t i = 0; i < 5; i++)
            CHECK_INT(w.n_run[i], i < n);
    }
    CHECK_INT(lw_parallel(1, 1, NULL, NULL), LW_E_ARG);
    w.n_thread = lw_core_count();
    CHECK_INT(lw_parallel(0, 10, one, &w), LW_OK);
    CHECK(!w.bad_thread);
    w.n_thread = 1 << 20;
    CHECK_INT(lw_parallel(1 << 20, 10, one, &w), LW_OK);
}

TEST(cores_follow_the_affinity)
{
    cpu_set_t old, one_core;
    CHECK(lw_core_count() >= 1);
    if (sched_getaffinity(0, sizeof old, &old) != 0)
        return;
    CPU_ZERO(&one_core);
    for (int i = 0; i < CPU_SETSIZE; i++)
        if (CPU_ISSET(i, &old)) {
            CPU_SET(i, &one_core);
            break;
        }
    CHECK_INT(sched_setaffinity(0, sizeof one_core, &one_core), 0);
    CHECK_INT(lw_core_count(), 1);
    CHECK_INT(sched_setaffinity(0, sizeof old, &old), 0);
}

TEST(clocks_never_go_back)
{
    double wall = lw_clock_wall(), cpu = lw_clock_cpu();
    CHECK(wall > 0 && cpu > 0);
    for (int i = 0; i < 1000; i++) {
        double w = lw_clock_wall(), c = lw_clock_cpu();
        CHECK(w >= wall && c >= cpu);
        wall = w;
        cpu = c;
    }
}
