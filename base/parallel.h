/* base/parallel.h - a loop over independent jobs on several threads.
 *
 * If each result depends only on the job number (write to elements indexed by it, seed by it), the answer is the same
 * for any number of threads. */
#ifndef LW_BASE_PARALLEL_H
#define LW_BASE_PARALLEL_H

#include <stddef.h>
#include "base/status.h"

/* One job.  thread is 0 .. n_thread-1 and selects the caller's scratch memory. */
typedef void lw_job(void *context, size_t job, int thread);

/* Run jobs 0 .. n_job-1, each once, started in rising order.  n_thread < 1 means one thread per core.
 * If the system refuses a thread, the others do the work; this is not a failure. */
lw_status lw_parallel(int n_thread, size_t n_job, lw_job *run, void *context);

/* A loop whose jobs may run in another process.  All that job k leaves for the code after the loop is size bytes, without
 * pointers, at `at` + k*size of each array of `out`. */
typedef struct lw_loop {
    int     n_thread;
    size_t  n_job;
    lw_job *run;
    void   *context;
    struct { void *at; size_t size; } out[2];          /* at NULL: no such array */
} lw_loop;

/* A loop can be run by other means than the threads of this process: by other processes that came to the same loop, or
 * from a file with the results of an earlier run.  loop returns LW_OK when all arrays are filled. */
typedef struct lw_sharing {
    lw_status (*loop)(void *context, const lw_loop *loop);
    void       *context;
} lw_sharing;

/* sharing NULL: lw_parallel. */
lw_status lw_loop_run(const lw_loop *loop, const lw_sharing *sharing);

/* Number of cores this process may use (affinity respected), at least 1. */
int lw_core_count(void);

#endif
