/* cli/program/mpi_jobs.h - tasks shared among the processes that mpirun started (bridge to MPI; `make MPI=1`), and answers
 * kept in a file.
 *
 * Process 0 gives each free process one task at a time and takes the answers in the order of the tasks.  Answers that
 * arrive early are stored, at most `ahead` for each process, which bounds the memory.  Every process does a task in a
 * child that it forks.  If the child is killed, the task is done again, up to twice; nothing else is lost. */
#ifndef CLI_PROGRAM_MPI_JOBS_H
#define CLI_PROGRAM_MPI_JOBS_H

#include <stdbool.h>
#include "base/parallel.h"
#include "base/status.h"
#include "base/bytes.h"
#include "cli/program/command.h"
#include "cli/program/kept_answers.h"

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

/* Are all processes ready? Every process calls this at the same place. */
bool cli_mpi_agree(bool ready);

/* Run the tasks in this process, one after the other. */
lw_status cli_tasks_run(const cli_mpi_work *w);

/* Processes that run the same search side by side and share its loops (base/parallel.h); or one process alone that keeps
 * what each loop leaves.  Process 0 has the file of kept answers: a loop that is there is not run again.  All processes
 * stop together when one of them got a signal. */
typedef struct cli_side_by_side {
    cli_kept    *kept;                   /* of process 0; NULL: nothing is kept                        */
    bool         mpi;
    size_t       n_loop;                 /* loops so far; 0 at first                                   */
    volatile int stop;                   /* for the search                                             */
    lw_error     e;                      /* why a loop failed, with a text                             */
} cli_side_by_side;
lw_status cli_share_loop(void *side_by_side, const lw_loop *loop);

#endif
