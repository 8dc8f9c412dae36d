/* tests/temporary.h - a folder for the files of one test program, below TMPDIR, removed when the program ends. */
#ifndef LW_TESTS_TEMPORARY_H
#define LW_TESTS_TEMPORARY_H

#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static char temporary_path[200];
static pid_t temporary_owner;

static inline int temporary_remove_one(const char *path, const struct stat *about, int type, struct FTW *at)
{
    (void)about, (void)type, (void)at;
    return remove(path);
}

static inline void temporary_remove(void)
{
    if (getpid() == temporary_owner && nftw(temporary_path, temporary_remove_one, 16, FTW_DEPTH | FTW_PHYS) != 0)
        perror(temporary_path);
}

/* Its path.  Made at the first call, the same at each further one. */
static inline const char *temporary_folder(void)
{
    const char *parent = getenv("TMPDIR");
    if (temporary_owner)
        return temporary_path;
    snprintf(temporary_path, sizeof temporary_path, "%s/linkwright-XXXXXX", parent ? parent : "/tmp");
    if (!mkdtemp(temporary_path)) {
        perror(temporary_path);
        exit(1);
    }
    temporary_owner = getpid();
    atexit(temporary_remove);
    return temporary_path;
}

/* The path of a file in it; the text is overwritten at the fourth call after. */
static inline const char *temporary_file(const char *name)
{
    static char path[4][1500];
    static int k;
    k = (k + 1)%4;
    snprintf(path[k], sizeof path[k], "%s/%s", temporary_folder(), name);
    return path[k];
}

#endif
