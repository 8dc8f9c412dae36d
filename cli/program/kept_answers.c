#include "cli/program/kept_answers.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "base/file.h"

typedef struct answer { char *data; size_t size; } answer;

struct cli_kept {
    char    *path;
    int      fd;
    uint64_t run;
    size_t   n;                          /* room in `of` */
    answer  *of;                         /* (n) data NULL: not there */
};

#define FNV_START 14695981039346656037u

static uint64_t hash(uint64_t h, const char *text, size_t size)
{
    for (size_t i = 0; i < size; i++)
        h = (h ^ (uint8_t)text[i])*1099511628211u;
    return h;
}

/* The linker writes a number of the build (--build-id) into a note of the program, which is the first object of the list. */
static int hash_notes(struct dl_phdr_info *program, size_t size, void *h)
{
    (void)size;
    for (const ElfW(Phdr) *p = program->dlpi_phdr; p < program->dlpi_phdr + program->dlpi_phnum; p++)
        if (p->p_type == PT_NOTE)
            *(uint64_t *)h = hash(*(uint64_t *)h, (const char *)(program->dlpi_addr + p->p_vaddr), p->p_memsz);
    return 1;
}

lw_status cli_kept_run(const char *line, int n_file, const char *const *file, uint64_t *run, lw_error *e)
{
    /* the number says how many words an option takes */
    static const struct { const char *name; int words; } left_out[] = {
        { "--keep", 2 }, { "--part", 2 }, { "--mpi", 1 }, { "--jobs", 2 }, { "-j", 2 }, { "--quiet", 1 }, { "-q", 1 }, { "-o", 2 },
        { "--output", 2 }, { "--save", 2 }, { "--force", 1 }, { "--json", 1 }, { "--time", 2 }, { "--memory", 2 }
    };
    uint64_t h = hash(FNV_START, LW_VERSION, strlen(LW_VERSION));
    int skip = 1;                                     /* the name of the program */
    dl_iterate_phdr(hash_notes, &h);                  /* answers may be memory as this build lays it out */
    for (const char *at = line + strspn(line, " "); *at; at += strspn(at, " ")) {
        size_t n = strcspn(at, " ");
        for (size_t i = 0; skip == 0 && i < sizeof left_out/sizeof *left_out; i++) {
            size_t length = strlen(left_out[i].name);
            if (n >= length && strncmp(at, left_out[i].name, length) == 0 && (n == length || at[length] == '='))
                skip = n == length ? left_out[i].words : 1;
        }
        if (skip > 0)
            skip--;
        else
            h = hash(h, at, n + 1);
        at += n;
    }
    for (int i = 0; i < n_file; i++) {
        char *text = NULL;
        size_t size = 0;
        lw_status s = lw_file_read_bytes(file[i], &text, &size, NULL);
        if (s == LW_E_MEMORY)                         /* without the text it would be the number of another run */
            return lw_error_set(e, s, "out of memory");
        if (s == LW_OK)
            h = hash(h, text, size);
        free(text);
    }
    *run = h;
    return LW_OK;
}

uint64_t cli_kept_check(size_t task, const char *data, size_t size)
{
    char number[24];
    return hash(hash(FNV_START, number, (size_t)snprintf(number, sizeof number, "%zu", task)), data, size);
}

static lw_status put(cli_kept *k, size_t task, const char *data, size_t size)
{
    if (task >= k->n) {
        size_t n = 2*k->n > task + 1 ? 2*k->n : task + 1;
        answer *of = realloc(k->of, n*sizeof *of);
        if (!of)
            return LW_E_MEMORY;
        memset(of + k->n, 0, (n - k->n)*sizeof *of);
        k->of = of;
        k->n = n;
    }
    char *copy = malloc(size + 1);
    if (!copy)
        return LW_E_MEMORY;
    memcpy(copy, data, size);
    free(k->of[task].data);
    k->of[task] = (answer){ copy, size };
    return LW_OK;
}

/* Take over what the file holds. *end: where its last whole answer ends. */
static lw_status read_all(cli_kept *k, const char *text, size_t size, size_t *end, lw_error *e)
{
    long record = 0;
    for (*end = 0; *end < size; record++) {
        const char *at = text + *end, *line = memchr(at, '\n', size - *end);
        uint64_t run, check;
        size_t task, n;
        int head = 0;
        if (!line)
            return LW_OK;                             /* cut short: the rest is removed */
        size_t first = (size_t)(line + 1 - text);
        char word[128];
        snprintf(word, sizeof word, "%.*s", (int)(line - at < 120 ? line - at : 120), at);
        if (sscanf(word, "linkwright answers of %" SCNx64 "%n", &run, &head) == 1 && !word[head]) {
            if (run != k->run)
                return lw_error_set(e, LW_E_NOTATION, "%s holds answers of another command, target or build of linkwright; name "
                                    "another file", k->path);
            *end = first;
            continue;
        }
        if (record == 0 || sscanf(word, "task %zu bytes %zu check %" SCNx64 "%n", &task, &n, &check, &head) != 3 || word[head])
            return lw_error_set(e, LW_E_NOTATION, "record %ld of %s is damaged, or this is no file of kept answers", record + 1, k->path);
        if (n >= size - first)
            return LW_OK;
        if (cli_kept_check(task, text + first, n) != check || text[first + n] != '\n' || task > 100000000)
            return lw_error_set(e, LW_E_NOTATION, "%s: the answer of task %zu is damaged", k->path, task);
        lw_status status = put(k, task, text + first, n);
        if (status != LW_OK)
            return lw_error_set(e, status, "out of memory");
        *end = first + n + 1;
    }
    return LW_OK;
}

static lw_status io(const cli_kept *k, lw_error *e)
{
    return lw_file_failed(e, "written", k->path, errno);
}

static lw_status open_file(cli_kept *k, lw_error *e)
{
    char head[64], *text = NULL;
    size_t size = 0, end = 0;
    k->fd = open(k->path, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (k->fd < 0)
        return io(k, e);
    if (flock(k->fd, LOCK_EX | LOCK_NB) != 0)
        return lw_error_at(e, LW_E_IO, k->path, 0, 0, "another program has it open");
    lw_status status = lw_file_read_bytes(k->path, &text, &size, e);
    if (status == LW_OK)
        status = read_all(k, text, size, &end, e);
    free(text);
    if (status != LW_OK)
        return status;
    if (end < size && ftruncate(k->fd, (off_t)end) != 0)
        return io(k, e);
    if (end > 0)
        return LW_OK;
    int n = snprintf(head, sizeof head, "linkwright answers of %016" PRIx64 "\n", k->run);
    return write(k->fd, head, (size_t)n) == n ? LW_OK : io(k, e);
}

lw_status cli_kept_open(const char *path, uint64_t run, cli_kept **out, lw_error *e)
{
    cli_kept *k = calloc(1, sizeof *k);
    if (!k || !(k->path = strdup(path))) {
        free(k);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    k->run = run;
    lw_status status = open_file(k, e);
    if (status == LW_OK)
        *out = k;
    else
        cli_kept_close(k);
    return status;
}

void cli_kept_close(cli_kept *k)
{
    if (!k)
        return;
    for (size_t i = 0; i < k->n; i++)
        free(k->of[i].data);
    free(k->of);
    if (k->fd >= 0)
        close(k->fd);
    free(k->path);
    free(k);
}

const char *cli_kept_get(const cli_kept *k, size_t task, size_t *size)
{
    if (!k || task >= k->n || !k->of[task].data)
        return NULL;
    *size = k->of[task].size;
    return k->of[task].data;
}

lw_status cli_kept_add(cli_kept *k, size_t task, const char *data, size_t size, lw_error *e)
{
    char head[96];
    int n = snprintf(head, sizeof head, "task %zu bytes %zu check %016" PRIx64 "\n", task, size, cli_kept_check(task, data, size));
    char *all = malloc((size_t)n + size + 1);
    if (!all)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    memcpy(all, head, (size_t)n);
    memcpy(all + n, data, size);
    all[(size_t)n + size] = '\n';
    size_t length = (size_t)n + size + 1, done = 0;
    for (ssize_t more; done < length; done += (size_t)more)
        if ((more = write(k->fd, all + done, length - done)) < 0) {
            if (errno != EINTR)
                break;
            more = 0;
        }
    free(all);
    if (done < length || fdatasync(k->fd) != 0)
        return io(k, e);
    lw_status status = put(k, task, data, size);
    return status == LW_OK ? LW_OK : lw_error_set(e, status, "out of memory");
}
