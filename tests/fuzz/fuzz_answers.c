/* Any bytes are a file of kept answers or have an error; what is added is there when the file is read again, and a loop takes
 * its results from an answer of the right size or refuses it.  Mutations get the check sums of their answers, so that they
 * reach the code behind these. */
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>
#include "cli/program/mpi_jobs.h"
#include "cli/program/output.h"
#include "tests/fuzz/fuzz.h"

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most) __attribute__((weak));
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
    size = LLVMFuzzerMutate(data, size, most);
    for (size_t i = 0; i < size && seed%8 != 0; i++) {
        size_t task, n;
        int head = 0;
        char line[96], check[20];
        snprintf(line, sizeof line, "%.*s", (int)(size - i < 90 ? size - i : 90), (const char *)data + i);
        if (sscanf(line, "task %zu bytes %zu check %*16[0-9a-f]%n", &task, &n, &head) != 2 || head < 16 || n >= size - i - (size_t)head)
            continue;
        snprintf(check, sizeof check, "%016llx", (unsigned long long)cli_kept_check(task, (const char *)data + i + head + 1, n));
        memcpy(data + i + head - 16, check, 16);
        i += (size_t)head;
    }
    return size;
}

/* what mpi_jobs.o needs of the program */
int cli_usage(const cli_call *call, const char *format, ...) { (void)call, (void)format; return 2; }
const volatile sig_atomic_t *cli_stop_flag(void) { static volatile sig_atomic_t stop; return &stop; }

typedef struct results { uint64_t word[6]; char text[2][11]; } results;

static void fill(void *context, size_t job, int thread)
{
    results *r = context;
    (void)thread;
    for (int i = 0; i < 3; i++)
        r->word[3*job + (size_t)i] = 5*job*(unsigned)i;
    memset(r->text[job], 'a' + (int)job, sizeof r->text[job]);
}

static lw_status run_loops(cli_kept *k, results r[2], lw_error *e)
{
    cli_side_by_side s = { .kept = k };
    lw_status status = LW_OK;
    for (int i = 0; i < 2 && status == LW_OK; i++)
        status = cli_share_loop(&s, &(lw_loop){ 1, 2, fill, &r[i], { { r[i].word, 24 }, { r[i].text, 11 } } });
    *e = s.e;
    return status;
}

static int one_input(const uint8_t *data, size_t size)
{
    cli_kept *k;
    lw_error e = { 0 };
    results first[2] = { 0 }, second[2] = { 0 };
    char path[64];
    size_t n;
    int fd = memfd_create("fuzz", 0);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size)
        abort();
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    lw_status status = cli_kept_open(path, 7, &k, &e);
    demand(status == LW_OK || e.text[0]);
    if (status == LW_OK) {
        lw_status loops = run_loops(k, first, &e);
        demand(loops == LW_OK || (loops == LW_E_NOTATION && e.text[0]));
        demand(cli_kept_add(k, 3, "an answer", 9, &e) == LW_OK);
        cli_kept_close(k);
        demand(cli_kept_open(path, 7, &k, &e) == LW_OK);
        const char *answer = cli_kept_get(k, 3, &n);
        demand(answer && n == 9 && memcmp(answer, "an answer", 9) == 0);
        demand(run_loops(k, second, &e) == loops);
        demand(loops != LW_OK || memcmp(first, second, sizeof first) == 0);
        cli_kept_close(k);
    }
    close(fd);
    return 0;
}
