/* tests/fail_at_call.c - the test build of the program, in which the n-th call of the system fails.
 *
 *     LW_FAIL=malloc:3        the third call that takes memory fails
 *     LW_CALLS_FILE=path      a program that ends writes how often each kind was called to this file: "malloc 12", and the first call of
 *                             each place, with a number of the place: "place malloc:3 1c2f"
 *     LW_FAIL_SHOW=1          shows where the call came from
 *     LW_HIDE=igraph          libraries with this in their name, of those loaded late, are not there
 *
 * Kinds: malloc (malloc, calloc, realloc, aligned_alloc, strdup, strndup, open_memstream, and gp_New of libplanarity),
 * fsync, rename, pthread_create, write (write, fflush, fclose, and writes of SQLite), jansson and sqlite (what these take).
 * The linker sends the calls of linkwright's own files and of the archives among the libraries here (--wrap in the
 * Makefile).  Calls inside shared libraries stay out of reach: igraph, cairo, and the C library itself. */
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <jansson.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "tests/fresh_memory.h"

enum kind { MEMORY, SYNC, RENAME, THREAD, WRITE, JANSSON, SQLITE, N_KIND };
static const char *const names[N_KIND] = { "malloc", "fsync", "rename", "pthread_create", "write", "jansson",
                                          "sqlite" };
static atomic_long calls[N_KIND];
static long fail_at[N_KIND];
static sqlite3_mem_methods sqlite_memory;

/* Within a call whose memory was made sure of before (mbs/ode/sundials.c), no allocation fails. */
static _Thread_local bool never_fails;

/* The places that calls come from, with the first call of each.  A place is the address that the call returns to; of jansson and SQLite,
 * which call from few places of their own, those of the calls that led to it, too. */
enum { N_PLACE = 1 << 14, N_TRIED = 64, N_FRAME = 5 };
static struct { atomic_size_t key; long n; enum kind kind; } places[N_PLACE];
static bool counting;

static void remember(enum kind kind, long n, const void *from)
{
    void *frame[N_FRAME] = { 0 };
    size_t key = (size_t)from*N_KIND + kind;
    for (int k = kind == JANSSON || kind == SQLITE ? backtrace(frame, N_FRAME) - 1 : 0; k > 2; k--)
        key = key*1099511628211u ^ (size_t)frame[k];
    for (size_t k = 0; k < N_TRIED; k++) {
        size_t at = (key*11400714819323198485u >> 32)%N_PLACE + k, none = 0;
        if (at >= N_PLACE || places[at].key == key)
            return;
        if (atomic_compare_exchange_strong(&places[at].key, &none, key)) {
            places[at].kind = kind;
            places[at].n = n;
            return;
        }
    }
}

static bool fails(enum kind kind, int error, const void *from)
{
    if (never_fails)
        return false;
    long n = ++calls[kind];
    if (counting)
        remember(kind, n, from);
    if (n != fail_at[kind])
        return false;
    if (getenv("LW_FAIL_SHOW")) {
        void *at[24];
        backtrace_symbols_fd(at, backtrace(at, 24), 2);
    }
    errno = error;
    return true;
}

#define FROM __builtin_return_address(0)
#define WRAP(type, name, parameters, arguments, kind, failed, error) \
    type __real_##name parameters; \
    type __wrap_##name parameters; \
    type __wrap_##name parameters { return fails(kind, error, FROM) ? failed : __real_##name arguments; }

WRAP(void *, calloc, (size_t n, size_t size), (n, size), MEMORY, NULL, ENOMEM)
WRAP(void *, realloc, (void *old, size_t n), (old, n), MEMORY, NULL, ENOMEM)
WRAP(void *, aligned_alloc, (size_t by, size_t n), (by, n), MEMORY, NULL, ENOMEM)
WRAP(char *, strdup, (const char *text), (text), MEMORY, NULL, ENOMEM)
WRAP(char *, strndup, (const char *text, size_t n), (text, n), MEMORY, NULL, ENOMEM)
WRAP(FILE *, open_memstream, (char **text, size_t *n), (text, n), MEMORY, NULL, ENOMEM)
WRAP(void *, gp_New, (void), (), MEMORY, NULL, ENOMEM)
WRAP(int, fsync, (int fd), (fd), SYNC, -1, EIO)
WRAP(int, rename, (const char *from, const char *to), (from, to), RENAME, -1, EIO)
WRAP(int, pthread_create, (pthread_t *t, const pthread_attr_t *a, void *(*run)(void *), void *data), (t, a, run, data),
     THREAD, EAGAIN, EAGAIN)
WRAP(ssize_t, write, (int fd, const void *data, size_t n), (fd, data, n), WRITE, -1, ENOSPC)
WRAP(int, fflush, (FILE *f), (f), WRITE, EOF, ENOSPC)

void *__real_malloc(size_t n);
void *__wrap_malloc(size_t n);
void *__wrap_malloc(size_t n)
{
    return fails(MEMORY, ENOMEM, FROM) ? NULL : fill_with_nan(__real_malloc(n), n);
}

int __real_SUNContext_Create(void *comm, void *context);
int __wrap_SUNContext_Create(void *comm, void *context);
int __wrap_SUNContext_Create(void *comm, void *context)
{
    if (fails(MEMORY, ENOMEM, FROM))
        return -1;
    never_fails = true;
    int code = __real_SUNContext_Create(comm, context);
    never_fails = false;
    return code;
}

int __real_fclose(FILE *f);
int __wrap_fclose(FILE *f);
int __wrap_fclose(FILE *f)
{
    bool lost = fails(WRITE, ENOSPC, FROM);
    int code = __real_fclose(f);
    if (lost)
        errno = ENOSPC;
    return lost ? EOF : code;
}

void *__real_dlopen(const char *file, int mode);
void *__wrap_dlopen(const char *file, int mode);
void *__wrap_dlopen(const char *file, int mode)
{
    const char *hidden = getenv("LW_HIDE");
    return __real_dlopen(hidden && strstr(file, hidden) ? "hidden.so.0" : file, mode);
}

static void *jansson_malloc(size_t n) { return fails(JANSSON, ENOMEM, FROM) ? NULL : __real_malloc(n); }

static void *sqlite_malloc(int n)             { return fails(SQLITE, ENOMEM, FROM) ? NULL : sqlite_memory.xMalloc(n); }
static void *sqlite_realloc(void *old, int n) { return fails(SQLITE, ENOMEM, FROM) ? NULL : sqlite_memory.xRealloc(old, n); }

static ssize_t sqlite_pwrite(int fd, const void *data, size_t n, off_t at)
{
    return fails(WRITE, ENOSPC, FROM) ? -1 : pwrite(fd, data, n, at);
}

static void tell(void)
{
    FILE *f = fopen(getenv("LW_CALLS_FILE"), "w");
    for (int k = 0; f && k < N_KIND; k++)
        fprintf(f, "%s %ld\n", names[k], (long)calls[k]);
    for (int k = 0; f && k < N_PLACE; k++)
        if (places[k].key)
            fprintf(f, "place %s:%ld %zx\n", names[places[k].kind], places[k].n, (size_t)places[k].key);
    if (f)
        __real_fclose(f);
}

__attribute__((constructor)) static void read_environment(void)
{
    const char *fault = getenv("LW_FAIL");
    if (!fault && !getenv("LW_CALLS_FILE"))
        return;
    json_set_alloc_funcs(jansson_malloc, free);
    sqlite3_mem_methods own;
    sqlite3_config(SQLITE_CONFIG_GETMALLOC, &sqlite_memory);
    own = sqlite_memory;
    own.xMalloc = sqlite_malloc;
    own.xRealloc = sqlite_realloc;
    sqlite3_config(SQLITE_CONFIG_MALLOC, &own);
    sqlite3_vfs *files = sqlite3_vfs_find(NULL);
    files->xSetSystemCall(files, "pwrite", (sqlite3_syscall_ptr)sqlite_pwrite);
    files->xSetSystemCall(files, "pwrite64", (sqlite3_syscall_ptr)sqlite_pwrite);
    for (int k = 0; k < N_KIND; k++) {
        size_t n = strlen(names[k]);
        calls[k] = 0;                                /* SQLite has started above */
        if (fault && strncmp(fault, names[k], n) == 0 && fault[n] == ':')
            fail_at[k] = atol(fault + n + 1);
    }
    counting = getenv("LW_CALLS_FILE") != NULL;
    if (counting)
        atexit(tell);
}
