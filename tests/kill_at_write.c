/* tests/kill_at_write.c - ends the test build of the program by SIGKILL right before SQLite changes a file for the n-th
 * time.  Only system calls change a file: a program killed at any moment leaves the files as one of these kills does.
 *
 *     LW_KILL_AT_WRITE=n       1: before the first change
 *     LW_WRITES_FILE=path      a program that ends writes the number of changes to this file */
#include <signal.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/types.h>
#include <unistd.h>

static long n_write, kill_at;

static void count(void)
{
    if (++n_write == kill_at)
        raise(SIGKILL);
}

static ssize_t counted_write(int fd, const void *data, size_t n)
{
    count();
    return write(fd, data, n);
}

static ssize_t counted_pwrite(int fd, const void *data, size_t n, off_t at)
{
    count();
    return pwrite(fd, data, n, at);
}

static int counted_ftruncate(int fd, off_t size)
{
    count();
    return ftruncate(fd, size);
}

static int counted_unlink(const char *path)
{
    count();
    return unlink(path);
}

static void tell(void)
{
    FILE *f = fopen(getenv("LW_WRITES_FILE"), "w");
    if (f)
        fprintf(f, "%ld\n", n_write), fclose(f);
}

/* off_t has 64 bits here: pwrite and pwrite64 are the same */
__attribute__((constructor)) static void read_environment(void)
{
    const char *at = getenv("LW_KILL_AT_WRITE");
    static const struct { const char *name; sqlite3_syscall_ptr call; } own[] = {
        { "write", (sqlite3_syscall_ptr)counted_write },         { "pwrite", (sqlite3_syscall_ptr)counted_pwrite },
        { "pwrite64", (sqlite3_syscall_ptr)counted_pwrite },     { "unlink", (sqlite3_syscall_ptr)counted_unlink },
        { "ftruncate", (sqlite3_syscall_ptr)counted_ftruncate },
    };
    if (!at && !getenv("LW_WRITES_FILE"))
        return;
    kill_at = at ? atol(at) : 0;
    sqlite3_vfs *files = sqlite3_vfs_find(NULL);
    for (size_t i = 0; i < sizeof own/sizeof *own; i++)
        files->xSetSystemCall(files, own[i].name, own[i].call);
    if (getenv("LW_WRITES_FILE"))
        atexit(tell);
}
