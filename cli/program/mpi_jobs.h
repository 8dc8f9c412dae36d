/* cli/program/mpi_jobs.h - tasks shared among the processes that mpirun started (bridge to MPI; `make MPI=1`).
 *
 * Process 0 gives each free process one task at a time and takes the answers in the order of the tasks.  A single
 * process does the tasks itself.  Answers that arrive early are stored, at most 64 for each process, which bounds the
 * memory. */
#ifndef CLI_PROGRAM_MPI_JOBS_H
#define CLI_PROGRAM_MPI_JOBS_H

#include <stdbool.h>
#include "base/status.h"
#include "base/bytes.h"

typedef struct cli_mpi_work {
    size_t      n_task;
    lw_status (*work)(void *context, size_t task, lw_bytes *answer);                     /* any process       */
    lw_status (*take)(void *context, size_t task, const char *answer, size_t size);      /* process 0, in order */
    void       *context;
    bool      (*skip)(void *context, size_t task);    /* process 0: leave this task out; NULL: none */
} cli_mpi_work;

/* Was the program built with MPI? */
bool cli_mpi_available(void);

/* Begin, once; returns the number of this process. */
int  cli_mpi_begin(void);
void cli_mpi_end(void);

/* Run all tasks. Every process calls this exactly once. n_task is read in process 0 only; 0 if it cannot continue. The
 * first status of work or take that is not LW_OK ends the run; process 0 returns it. */
lw_status cli_mpi_run(const cli_mpi_work *w);

#endif
