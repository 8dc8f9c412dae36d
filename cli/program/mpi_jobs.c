#include "cli/program/mpi_jobs.h"

#include <stdlib.h>
#include "cli/program/output.h"

int cli_read_part(const cli_call *call, const char *text, int *part, int *n_part)
{
    char *end;
    long r = strtol(text, &end, 10), m = *end == '/' ? strtol(end + 1, &end, 10) : 0;
    if (*end || r < 1 || r > m || m > 1000000)
        return cli_usage(call, "--part is R/M with 1 <= R <= M, for example 2/5, not '%s'", text);
    *part = (int)r - 1;
    *n_part = (int)m;
    return CLI_DONE;
}

#ifdef LW_MPI
#include <mpi.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { TAG_TASK = 1, TAG_ANSWER };
#define NO_TASK      UINT64_MAX
#define KEPT_BY_RANK 64

/* Precedes every answer. */
typedef struct heading { uint64_t task; int64_t status; } heading;

int cli_mpi_check(const cli_call *call)
{
    (void)call;
    return CLI_DONE;
}

int cli_mpi_begin(void)
{
    int rank;
    MPI_Init(NULL, NULL);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    return rank;
}

/* Used by a process that cannot go on: its answers report the failure; process 0 ends the others. */
static lw_status work_not(void *context, size_t k, lw_bytes *answer)
{
    (void)context, (void)k, (void)answer;
    return LW_E_MEMORY;
}

void cli_mpi_end(bool ran)
{
    cli_mpi_work nothing = { .work = work_not };
    if (!ran)
        (void)cli_mpi_run(&nothing);
    MPI_Finalize();
}

static void send_task(int rank, uint64_t task) { MPI_Send(&task, 1, MPI_UINT64_T, rank, TAG_TASK, MPI_COMM_WORLD); }


static void begin_answer(lw_bytes *answer, uint64_t task)
{
    heading h = { task, LW_OK };
    lw_bytes_free(answer);
    lw_bytes_add(answer, &h, sizeof h);
    if (answer->failed)
        MPI_Abort(MPI_COMM_WORLD, 4);            /* no memory even for a message */
}

/* Ask for a task by sending the last answer (at first an empty one), until no task is left. */
static lw_status work_for_others(const cli_mpi_work *w)
{
    lw_bytes answer = { 0 };
    uint64_t task = NO_TASK;
    begin_answer(&answer, task);
    for (;;) {
        MPI_Send(answer.data, (int)answer.size, MPI_BYTE, 0, TAG_ANSWER, MPI_COMM_WORLD);
        MPI_Recv(&task, 1, MPI_UINT64_T, 0, TAG_TASK, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        if (task == NO_TASK)
            break;
        begin_answer(&answer, task);
        int64_t status = w->work(w->context, task, &answer);
        if (answer.failed || answer.size > INT32_MAX) {
            begin_answer(&answer, task);
            status = LW_E_MEMORY;
        }
        memcpy(answer.data + offsetof(heading, status), &status, sizeof status);
    }
    lw_bytes_free(&answer);
    return LW_OK;
}

/* ---- process 0 ------------------------------------------------------------------------------------ */

typedef struct kept { char *data; size_t size; bool here; } kept;      /* data NULL: a task left out */

typedef struct desk {
    const cli_mpi_work *w;
    size_t    next, turn;             /* task to hand out next; task whose answer is taken next     */
    size_t    n_kept;
    kept     *early;                  /* answers that came early, at index task modulo n_kept       */
    int       n_idle, *idle;          /* processes without a task                                   */
    lw_status status;
} desk;

static void note_status(desk *d, lw_status status)
{
    if (d->status == LW_OK)
        d->status = status;
}

/* Take all answers whose turn has come. */
static void take_early(desk *d)
{
    for (kept *a; (a = &d->early[d->turn % d->n_kept])->here; d->turn++) {
        if (d->status == LW_OK && a->data)
            note_status(d, d->w->take(d->w->context, d->turn, a->data + sizeof(heading), a->size - sizeof(heading)));
        free(a->data);
        *a = (kept){ 0 };
    }
}

/* Receive one answer and keep it. */
static void receive(desk *d)
{
    MPI_Status from;
    heading h;
    int size;
    MPI_Probe(MPI_ANY_SOURCE, TAG_ANSWER, MPI_COMM_WORLD, &from);
    MPI_Get_count(&from, MPI_BYTE, &size);
    char *data = malloc((size_t)size);
    if (!data)
        MPI_Abort(MPI_COMM_WORLD, 4);            /* the others can be told in no other way */
    MPI_Recv(data, size, MPI_BYTE, from.MPI_SOURCE, TAG_ANSWER, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    memcpy(&h, data, sizeof h);
    d->idle[d->n_idle++] = from.MPI_SOURCE;
    note_status(d, (lw_status)h.status);
    if (h.task == NO_TASK || h.status != LW_OK) {
        free(data);
        return;
    }
    d->early[h.task % d->n_kept] = (kept){ data, (size_t)size, true };
    take_early(d);
}

/* The next task is left out. */
static bool skip_next(desk *d)
{
    if (d->next == d->w->n_task || d->next >= d->turn + d->n_kept || !d->w->skip
        || !d->w->skip(d->w->context, d->next))
        return false;
    d->early[d->next++ % d->n_kept].here = true;
    take_early(d);
    return true;
}

/* Give tasks to idle processes; end them when no task is left. Returns how many were ended. */
static int hand_out(desk *d)
{
    int n_left = 0;
    while (d->n_idle > 0) {
        while (d->status == LW_OK && skip_next(d))
            ;
        bool over = d->status != LW_OK || d->next == d->w->n_task;
        if (!over && d->next >= d->turn + d->n_kept)
            break;                               /* too far ahead of an answer that is still missing */
        send_task(d->idle[--d->n_idle], over ? NO_TASK : d->next++);
        n_left += over;
    }
    return n_left;
}

static lw_status serve(const cli_mpi_work *w, int n_rank)
{
    desk d = { .w = w, .n_kept = (w->ahead > 0 ? w->ahead : KEPT_BY_RANK)*(size_t)n_rank };
    d.early = calloc(d.n_kept, sizeof *d.early);
    d.idle = calloc((size_t)n_rank, sizeof *d.idle);
    if (!d.early || !d.idle)
        MPI_Abort(MPI_COMM_WORLD, 4);
    for (int working = n_rank - 1; working > 0; ) {
        receive(&d);
        working -= hand_out(&d);
    }
    for (size_t k = 0; k < d.n_kept; k++)
        free(d.early[k].data);
    free(d.early);
    free(d.idle);
    return d.status;
}

static lw_status work_alone(const cli_mpi_work *w)
{
    lw_status status = LW_OK;
    for (size_t k = 0; k < w->n_task && status == LW_OK; k++) {
        lw_bytes answer = { 0 };
        if (w->skip && w->skip(w->context, k))
            continue;
        status = w->work(w->context, k, &answer);
        if (status == LW_OK)
            status = answer.failed ? LW_E_MEMORY : w->take(w->context, k, answer.data ? answer.data : "", answer.size);
        lw_bytes_free(&answer);
    }
    return status;
}

lw_status cli_mpi_run(const cli_mpi_work *w)
{
    int rank, n_rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_rank);
    return rank > 0 ? work_for_others(w) : n_rank > 1 ? serve(w, n_rank) : work_alone(w);
}

#else

int cli_mpi_check(const cli_call *call)
{
    return cli_usage(call, "this program was built without MPI; 'make MPI=1' builds build/mpi/linkwright with it");
}

int  cli_mpi_begin(void) { return 0; }
void cli_mpi_end(bool ran) { (void)ran; }
lw_status cli_mpi_run(const cli_mpi_work *w)
{
    (void)w;
    return LW_E_KIND;
}

#endif
