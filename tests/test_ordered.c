/* test_ordered.c - text of parallel jobs comes out in order: jobs of very different length, slow ones first, many
 * threads; a sink that fails stops all. */
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "base/parallel.h"
#include "enumerate/ordered.h"
#include "tests/check.h"

typedef struct run {
    lw_ordered out;
    size_t     n_job, next_job, next_line, bytes;
    size_t   (*lines_of)(size_t job);
    size_t     fail_at;                       /* bytes after which the sink refuses; 0: never */
} run;

/* Lines "job line" must come in order, none missing. */
static lw_status check_sink(void *context, const char *text, size_t size)
{
    run *r = context;
    for (const char *at = text; at < text + size; ) {
        char *end;
        size_t job = strtoull(at, &end, 10), line = strtoull(end, &end, 10);
        while (r->next_line == r->lines_of(r->next_job)) {
            r->next_job++;
            r->next_line = 0;
        }
        CHECK_INT(job, r->next_job);
        CHECK_INT(line, r->next_line++);
        at = end + 1;
    }
    r->bytes += size;
    return r->fail_at && r->bytes > r->fail_at ? LW_E_IO : LW_OK;
}

static void write_lines(void *context, size_t job, int thread)
{
    run *r = context;
    lw_ordered_part p;
    (void)thread;
    lw_piece_begin(&p, &r->out, job);
    if (job % 16 == 0)
        nanosleep(&(struct timespec){ 0, 1000000 }, NULL);
    for (size_t line = 0; line < r->lines_of(job); line++) {
        char *text = lw_piece_space(&p, 48);
        if (!text)
            break;
        lw_piece_add(&p, (size_t)snprintf(text, 48, "%zu %zu\n", job, line));
    }
    lw_piece_end(&p);
}

static lw_status run_jobs(run *r, int n_thread)
{
    r->next_job = r->next_line = r->bytes = 0;
    lw_ordered_open(&r->out, check_sink, r);
    CHECK_INT(lw_parallel(n_thread, r->n_job, write_lines, r), LW_OK);
    return lw_ordered_close(&r->out);
}

static size_t few(size_t job) { return job*7919 % 13; }
static size_t one_in_a_while(size_t job) { return job % 50 == 49 ? 200000 : 1; }

TEST(comes_in_order)
{
    for (int n_thread = 1; n_thread <= 8; n_thread *= 2) {
        run r = { .n_job = 500, .lines_of = few };
        CHECK_INT(run_jobs(&r, n_thread), LW_OK);
        r.n_job = 100;                                    /* two jobs with two megabytes each */
        r.lines_of = one_in_a_while;
        CHECK_INT(run_jobs(&r, n_thread), LW_OK);
        CHECK_INT(r.next_job, 99);
        CHECK_INT(r.next_line, 200000);
    }
}

TEST(a_failing_sink_stops_all)
{
    for (int n_thread = 1; n_thread <= 4; n_thread++) {
        run r = { .n_job = 300, .lines_of = one_in_a_while, .fail_at = 1000000 };
        CHECK_INT(run_jobs(&r, n_thread), LW_E_IO);
        CHECK(r.bytes < 4000000);
    }
}
