#include "base/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <unistd.h>

#define THREAD_MAX 256         /* more than this is never useful here, and needs no allocation */

int lw_core_count(void)
{
    cpu_set_t set;
    long n = 0;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        n = CPU_COUNT(&set);
    if (n < 1)                                 /* more cores than cpu_set_t can tell */
        n = sysconf(_SC_NPROCESSORS_ONLN);
    return n < 1 ? 1 : n > THREAD_MAX ? THREAD_MAX : (int)n;
}

typedef struct queue {
    atomic_size_t next;
    size_t        n_job;
    lw_job       *run;
    void         *context;
} queue;

typedef struct worker { queue *q; int thread; pthread_t id; } worker;

static void *work(void *arg)
{
    const worker *w = arg;
    queue *q = w->q;
    for (size_t job; (job = atomic_fetch_add(&q->next, 1)) < q->n_job; )
        q->run(q->context, job, w->thread);
    return NULL;
}

lw_status lw_parallel(int n_thread, size_t n_job, lw_job *run, void *context)
{
    if (!run)
        return LW_E_ARG;
    if (n_thread < 1)
        n_thread = lw_core_count();
    if (n_thread > THREAD_MAX)
        n_thread = THREAD_MAX;
    if ((size_t)n_thread > n_job)
        n_thread = n_job > 0 ? (int)n_job : 1;

    queue q = { .n_job = n_job, .run = run, .context = context };
    worker w[THREAD_MAX];
    int n_started = 1;                         /* this thread is number 0 */
    w[0] = (worker){ .q = &q };
    while (n_started < n_thread) {
        w[n_started] = (worker){ .q = &q, .thread = n_started };
        if (pthread_create(&w[n_started].id, NULL, work, &w[n_started]) != 0)
            break;
        n_started++;
    }
    work(&w[0]);
    for (int i = 1; i < n_started; i++)
        pthread_join(w[i].id, NULL);
    return LW_OK;
}

lw_status lw_loop_run(const lw_loop *loop, const lw_sharing *sharing)
{
    return sharing ? sharing->loop(sharing->context, loop)
                   : lw_parallel(loop->n_thread, loop->n_job, loop->run, loop->context);
}
