/* cli/program/mpi_jobs.h - tasks spread over the processes that mpirun started (bridge to MPI; `make MPI=1`).
 *
 * Process 0 hands tasks out one by one, to whoever is free, and takes the answers in the order of the tasks;
 * the others work.  A lone process works itself.  Answers that come early are kept, at most 64 for each
 * process, so that memory stays bounded. */
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
} cli_mpi_work;

/* Was the program built with MPI? */
bool cli_mpi_available(void);

/* Begin, once; returns the number of this process. */
int  cli_mpi_begin(void);
void cli_mpi_end(void);

/* Run all tasks.  Every process calls this exactly once; process 0 decides how many tasks there are (0 when it
 * cannot go on), the others need not know.  The first status of work or take that is not LW_OK ends the handing out; process 0 returns it. */
lw_status cli_mpi_run(const cli_mpi_work *w);

#endif
