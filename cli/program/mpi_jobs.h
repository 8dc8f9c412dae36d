/* cli/program/mpi_jobs.h - tasks shared among the processes that mpirun started (bridge to MPI; `make MPI=1`).
 *
 * Process 0 gives each free process one task at a time and takes the answers in the order of the tasks.  A single
 * process does the tasks itself.  Answers that arrive early are stored, at most `ahead` for each process, which bounds
 * the memory. */
#ifndef CLI_PROGRAM_MPI_JOBS_H
#define CLI_PROGRAM_MPI_JOBS_H

#include <stdbool.h>
#include "base/status.h"
#include "base/bytes.h"
#include "cli/program/command.h"

typedef struct cli_mpi_work {
    size_t      n_task;
    lw_status (*work)(void *context, size_t task, lw_bytes *answer);                     /* any process       */
    lw_status (*take)(void *context, size_t task, const char *answer, size_t size);      /* process 0, in order */
    void       *context;
    bool      (*skip)(void *context, size_t task);    /* process 0: leave this task out; NULL: none */
    size_t      ahead;                                /* answers that each process may be ahead; 0: 64 */
} cli_mpi_work;

/* Read a part such as "2/5", which becomes 1 and 5. CLI_DONE, or the exit code after a message. */
int  cli_read_part(const cli_call *call, const char *text, int *part, int *n_part);

/* CLI_DONE if the program was built with MPI, or the exit code after a message. */
int  cli_mpi_check(const cli_call *call);

/* Begin, once; returns the number of this process. End; `ran`: this process has called cli_mpi_run. If it could not, the
 * others learn that here and end. */
int  cli_mpi_begin(void);
void cli_mpi_end(bool ran);

/* Run all tasks. Every process calls this exactly once. n_task is read in process 0 only; 0 if it cannot continue. The
 * first status of work or take that is not LW_OK ends the run; process 0 returns it. */
lw_status cli_mpi_run(const cli_mpi_work *w);

#endif
