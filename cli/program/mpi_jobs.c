#include "cli/program/mpi_jobs.h"

#include <errno.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

typedef lw_status cli_do_task(void *context, size_t task, lw_bytes *answer);

static lw_status run_tasks(const cli_mpi_work *w, cli_do_task *work, void *context)
{
    lw_status status = LW_OK;
    for (size_t k = 0; k < w->n_task && status == LW_OK; k++) {
        lw_bytes answer = { 0 };
        if (w->skip && w->skip(w->context, k))
            continue;
        status = work(context, k, &answer);
        if (status == LW_OK)
            status = answer.failed ? LW_E_MEMORY : w->take(w->context, k, answer.data ? answer.data : "", answer.size);
        lw_bytes_free(&answer);
    }
    return status;
}

lw_status cli_tasks_run(const cli_mpi_work *w) { return run_tasks(w, w->work, w->context); }

/* ---- what a loop leaves, as bytes: words of zeros are counted, since most finds of a round are empty --------- */

static void pack_words(lw_bytes *to, const char *at, size_t size)
{
    uint64_t word;
    uint32_t count[2];
    for (size_t i = 0; i < size; ) {
        size_t zeros = 0, others = 0;
        for (; i + 8*zeros + 8 <= size; zeros++) {
            memcpy(&word, at + i + 8*zeros, 8);
            if (word)
                break;
        }
        i += 8*zeros;
        for (; i + 8*others + 8 <= size; others++) {
            memcpy(&word, at + i + 8*others, 8);
            if (!word)
                break;
        }
        size_t bytes = i + 8*others + 8 > size ? size - i : 8*others;
        count[0] = (uint32_t)zeros;
        count[1] = (uint32_t)bytes;
        lw_bytes_add(to, count, sizeof count);
        lw_bytes_add(to, at + i, bytes);
        i += bytes;
    }
}

/* False: the bytes are not those of an item of this size. */
static bool unpack_words(const char **from, const char *end, char *at, size_t size)
{
    uint32_t count[2];
    for (size_t i = 0; i < size; ) {
        if ((size_t)(end - *from) < sizeof count)
            return false;
        memcpy(count, *from, sizeof count);
        *from += sizeof count;
        size_t zeros = 8*(size_t)count[0];
        if (zeros > size - i || count[1] > size - i - zeros || count[1] > (size_t)(end - *from) || zeros + count[1] == 0)
            return false;
        memset(at + i, 0, zeros);
        memcpy(at + i + zeros, *from, count[1]);
        *from += count[1];
        i += zeros + count[1];
    }
    return true;
}

/* Every step-th job from `first` on. */
static void pack(const lw_loop *l, size_t first, size_t step, lw_bytes *to)
{
    for (size_t k = first; k < l->n_job; k += step)
        for (int i = 0; i < 2 && l->out[i].at; i++)
            pack_words(to, (const char *)l->out[i].at + k*l->out[i].size, l->out[i].size);
}

static bool unpack(const lw_loop *l, size_t first, size_t step, const char *from, size_t size)
{
    const char *end = from + size;
    for (size_t k = first; k < l->n_job; k += step)
        for (int i = 0; i < 2 && l->out[i].at; i++)
            if (!unpack_words(&from, end, (char *)l->out[i].at + k*l->out[i].size, l->out[i].size))
                return false;
    return from == end;
}

static lw_status keep_loop(cli_side_by_side *s, size_t number, const lw_loop *l)
{
    lw_bytes all = { 0 };
    pack(l, 0, 1, &all);
    lw_status status = lw_bytes_end(&all, &s->e);
    if (status == LW_OK)
        status = cli_kept_add(s->kept, number, all.data ? all.data : "", all.size, &s->e);
    lw_bytes_free(&all);
    return status;
}

static lw_status loop_alone(cli_side_by_side *s, const lw_loop *l)
{
    size_t number = s->n_loop++, size;
    const char *known = cli_kept_get(s->kept, number, &size);
    if (known)
        return unpack(l, 0, 1, known, size) ? LW_OK
             : lw_error_set(&s->e, LW_E_NOTATION, "the kept answers belong to another search");
    lw_status status = lw_parallel(l->n_thread, l->n_job, l->run, l->context);
    if (cli_interrupted())
        s->stop = 1;                             /* and what the loop left is not complete */
    return status == LW_OK && !s->stop ? keep_loop(s, number, l) : status;
}

#ifdef LW_MPI
#include <fcntl.h>
#include <mpi.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

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

/* ---- a task in a child ------------------------------------------------------------------------------- */

#define TRIES 3

/* The child: it dies with its parent, and where memory ends the system ends it first. */
static _Noreturn void do_in_child(const cli_mpi_work *w, size_t task, int out)
{
    lw_bytes answer = { 0 };
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    int score = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
    if (score >= 0 && write(score, "500", 3) != 3)
        (void)score;                             /* not a failure: only the choice of the system */
    lw_status status = w->work(w->context, task, &answer);
    heading h = { task, answer.failed || answer.size > INT32_MAX - sizeof h ? LW_E_MEMORY : status };
    if (h.status != LW_OK)
        answer.size = 0;
    if (write(out, &h, sizeof h) != sizeof h)
        _exit(1);
    for (size_t done = 0; done < answer.size; ) {
        ssize_t n = write(out, answer.data + done, answer.size - done);
        if (n < 0 && errno != EINTR)
            _exit(1);
        done += n > 0 ? (size_t)n : 0;
    }
    _exit(0);
}

/* Collect what the child writes until it ends. False: it was killed. */
static bool hear_child(pid_t child, int in, lw_bytes *answer, int *killed_by)
{
    char part[1 << 15];
    int state = 0;
    for (ssize_t n; (n = read(in, part, sizeof part)) != 0; ) {
        if (n < 0 && errno != EINTR)
            break;
        if (n > 0)
            lw_bytes_add(answer, part, (size_t)n);
    }
    close(in);
    while (waitpid(child, &state, 0) < 0 && errno == EINTR)
        ;
    *killed_by = WIFSIGNALED(state) ? WTERMSIG(state) : 0;
    return WIFEXITED(state) && WEXITSTATUS(state) == 0 && answer->size >= sizeof(heading);
}

/* The answer with its heading before it. */
static void do_apart(const cli_mpi_work *w, size_t task, lw_bytes *answer)
{
    for (int n_try = 0; n_try < TRIES; n_try++) {
        int ends[2], killed_by;
        lw_bytes_free(answer);
        if (pipe2(ends, O_CLOEXEC) != 0)
            break;
        pid_t child = fork();
        if (child == 0)
            do_in_child(w, task, ends[1]);
        close(ends[1]);
        if (child < 0)
            close(ends[0]);
        else if (hear_child(child, ends[0], answer, &killed_by) && !answer->failed)
            return;
        else
            fprintf(stderr, "linkwright: the process that did task %zu was killed (signal %d); %s\n", task + 1, killed_by,
                    n_try + 1 < TRIES ? "only this task is done again" : "given up");
    }
    heading h = { task, LW_E_MEMORY };
    lw_bytes_free(answer);
    lw_bytes_add(answer, &h, sizeof h);
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

bool cli_mpi_agree(bool ready)
{
    int mine = ready, all = 0;
    MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    return all;
}

static void send_task(int rank, uint64_t task) { MPI_Send(&task, 1, MPI_UINT64_T, rank, TAG_TASK, MPI_COMM_WORLD); }


/* Ask for a task by sending the last answer (at first an empty one), until no task is left. */
static lw_status work_for_others(const cli_mpi_work *w)
{
    lw_bytes answer = { 0 };
    heading first = { NO_TASK, LW_OK };
    uint64_t task;
    lw_bytes_add(&answer, &first, sizeof first);
    for (;;) {
        if (answer.failed)
            MPI_Abort(MPI_COMM_WORLD, 4);            /* no memory even for a message */
        MPI_Send(answer.data, (int)answer.size, MPI_BYTE, 0, TAG_ANSWER, MPI_COMM_WORLD);
        MPI_Recv(&task, 1, MPI_UINT64_T, 0, TAG_TASK, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        if (task == NO_TASK)
            break;
        do_apart(w, task, &answer);
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
    if (d->next == d->w->n_task || d->next >= d->turn + d->n_kept || !d->w->skip || !d->w->skip(d->w->context, d->next))
        return false;
    d->early[d->next++ % d->n_kept].here = true;
    take_early(d);
    return true;
}

/* Give tasks to idle processes; end them when no task is left. Returns how many were ended. */
static int send_tasks(desk *d)
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
        working -= send_tasks(&d);
    }
    for (size_t k = 0; k < d.n_kept; k++)
        free(d.early[k].data);
    free(d.early);
    free(d.idle);
    return d.status;
}

static lw_status work_apart(void *context, size_t task, lw_bytes *answer)
{
    heading h;
    do_apart(context, task, answer);
    if (answer->failed)
        return LW_E_MEMORY;
    memcpy(&h, answer->data, sizeof h);
    memmove(answer->data, answer->data + sizeof h, answer->size -= sizeof h);
    return (lw_status)h.status;
}

lw_status cli_mpi_run(const cli_mpi_work *w)
{
    int rank, n_rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_rank);
    return rank > 0 ? work_for_others(w) : n_rank > 1 ? serve(w, n_rank) : run_tasks(w, work_apart, (void *)w);
}

/* ---- loops side by side ----------------------------------------------------------------------------- */

typedef struct my_jobs { const lw_loop *loop; size_t rank, n_rank; } my_jobs;

static void run_my_job(void *context, size_t job, int thread)
{
    const my_jobs *m = context;
    m->loop->run(m->loop->context, m->rank + job*m->n_rank, thread);
}

static lw_status work_my_jobs(void *context, size_t task, lw_bytes *answer)
{
    my_jobs *m = context;
    size_t n = (m->loop->n_job + m->n_rank - 1 - m->rank)/m->n_rank;
    (void)task;
    lw_status status = lw_parallel(m->loop->n_thread, n, run_my_job, m);
    pack(m->loop, m->rank, m->n_rank, answer);
    return status;
}

/* Everybody gets what everybody has: a number and bytes each. LW_E_MEMORY in all processes if it is in one. */
static lw_status exchange(const cli_side_by_side *s, const lw_loop *l, const lw_bytes *mine, int n_rank, bool *stop)
{
    int *about = malloc(3*(size_t)n_rank*sizeof *about), *from = about + 2*n_rank;
    heading h;
    lw_status status = LW_OK;
    if (!about)
        MPI_Abort(MPI_COMM_WORLD, 4);
    memcpy(&h, mine->data, sizeof h);
    int own[2] = { (int)mine->size, (h.status != LW_OK) + 2*cli_interrupted() }, all = 0;
    (void)s;
    MPI_Allgather(own, 2, MPI_INT, about, 2, MPI_INT, MPI_COMM_WORLD);
    int *size = malloc((size_t)n_rank*sizeof *size);
    for (int i = 0; i < n_rank && size; i++) {
        size[i] = about[2*i];
        from[i] = all;
        *stop |= about[2*i + 1] >= 2;
        status = about[2*i + 1] & 1 || size[i] > INT32_MAX - all ? LW_E_MEMORY : status;
        all += status == LW_OK ? size[i] : 0;
    }
    char *bytes = malloc((size_t)all + 1);
    if (!bytes || !size)
        MPI_Abort(MPI_COMM_WORLD, 4);
    if (status == LW_OK) {
        MPI_Allgatherv(mine->data, own[0], MPI_BYTE, bytes, size, from, MPI_BYTE, MPI_COMM_WORLD);
        for (int i = 0; i < n_rank && status == LW_OK; i++)
            if (!unpack(l, (size_t)i, (size_t)n_rank, bytes + from[i] + sizeof h, (size_t)size[i] - sizeof h))
                status = LW_E_MEMORY;
    }
    free(bytes);
    free(size);
    free(about);
    return status;
}

/* Send what process 0 has kept of this loop to all. *there: it was there. */
static lw_status spread_known(cli_side_by_side *s, size_t number, const lw_loop *l, bool *there)
{
    size_t n = 0;
    const char *known = cli_kept_get(s->kept, number, &n);
    uint64_t size = known ? n : UINT64_MAX;
    MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    *there = size != UINT64_MAX;
    if (!*there)
        return LW_OK;
    char *copy = known ? NULL : malloc((size_t)size + 1);
    if (!known && !copy)
        MPI_Abort(MPI_COMM_WORLD, 4);
    MPI_Bcast(known ? (char *)known : copy, (int)size, MPI_BYTE, 0, MPI_COMM_WORLD);
    bool good = unpack(l, 0, 1, known ? known : copy, (size_t)size);
    free(copy);
    return good ? LW_OK : lw_error_set(&s->e, LW_E_NOTATION, "the kept answers belong to another search");
}

static lw_status loop_together(cli_side_by_side *s, const lw_loop *l)
{
    int rank, n_rank;
    bool there, stop = false;
    size_t number = s->n_loop++;
    lw_bytes mine = { 0 };
    lw_status status = spread_known(s, number, l, &there);
    if (there)
        return status;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_rank);
    my_jobs m = { l, (size_t)rank, (size_t)n_rank };
    cli_mpi_work w = { .work = work_my_jobs, .context = &m };
    do_apart(&w, number, &mine);
    if (mine.failed)
        MPI_Abort(MPI_COMM_WORLD, 4);
    status = exchange(s, l, &mine, n_rank, &stop);
    lw_bytes_free(&mine);
    if (stop)
        s->stop = 1;
    int saved = status == LW_OK && s->kept ? (int)keep_loop(s, number, l) : LW_OK;
    MPI_Bcast(&saved, 1, MPI_INT, 0, MPI_COMM_WORLD);
    return status == LW_OK ? (lw_status)saved : status;
}

lw_status cli_share_loop(void *side_by_side, const lw_loop *l)
{
    cli_side_by_side *s = side_by_side;
    return s->mpi ? loop_together(s, l) : loop_alone(s, l);
}

#else

int cli_mpi_check(const cli_call *call)
{
    return cli_usage(call, "this program was built without MPI; 'make MPI=1' builds build/mpi/linkwright with it");
}

int  cli_mpi_begin(void) { return 0; }
void cli_mpi_end(bool ran) { (void)ran; }
bool cli_mpi_agree(bool ready) { return ready; }
lw_status cli_mpi_run(const cli_mpi_work *w)
{
    (void)w;
    return LW_E_KIND;
}

lw_status cli_share_loop(void *side_by_side, const lw_loop *l) { return loop_alone(side_by_side, l); }

#endif
