/* tests/catalogue_file.h - what tests of catalogues share: the whole content of a file as text, its examination,
 * and programs that are killed. */
#ifndef LW_TESTS_CATALOGUE_FILE_H
#define LW_TESTS_CATALOGUE_FILE_H

#include <signal.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include "base/rng.h"
#include "tests/check.h"

/* Rows of a table as text, moments left out. */
static inline void dump_table(sqlite3 *db, const char *table, FILE *f)
{
    char sql[200];
    sqlite3_stmt *t;
    snprintf(sql, sizeof sql, "SELECT * FROM \"%s\"", table);
    if (sqlite3_prepare_v2(db, sql, -1, &t, NULL) != SQLITE_OK) {
        fprintf(f, "%s: %s\n", table, sqlite3_errmsg(db));
        return;
    }
    while (sqlite3_step(t) == SQLITE_ROW) {
        fprintf(f, "%s", table);
        for (int i = 0; i < sqlite3_column_count(t); i++) {
            const char *name = sqlite3_column_name(t, i);
            if (strcmp(name, "begun") == 0 || strcmp(name, "ended") == 0)
                continue;
            if (sqlite3_column_type(t, i) == SQLITE_BLOB) {
                const unsigned char *b = sqlite3_column_blob(t, i);
                uint64_t hash = 14695981039346656037u;
                for (int k = 0; k < sqlite3_column_bytes(t, i); k++)
                    hash = (hash ^ b[k])*1099511628211u;
                fprintf(f, "|%llx", (unsigned long long)hash);
            } else {
                const unsigned char *text = sqlite3_column_text(t, i);
                fprintf(f, "|%s", text ? (const char *)text : "(null)");
            }
        }
        fputc('\n', f);
    }
    sqlite3_finalize(t);
}

/* All tables; "damaged: ..." when SQLite finds a fault.  Free with free(). */
static inline char *dump_catalogue(const char *path)
{
    char *text = NULL;
    size_t size;
    FILE *f = open_memstream(&text, &size);
    sqlite3 *db;
    sqlite3_stmt *t = NULL;
    sqlite3_open_v2(path, &db, SQLITE_OPEN_READWRITE, NULL);
    if (sqlite3_prepare_v2(db, "PRAGMA integrity_check", -1, &t, NULL) != SQLITE_OK || sqlite3_step(t) != SQLITE_ROW
        || strcmp((const char *)sqlite3_column_text(t, 0), "ok") != 0)
        fprintf(f, "damaged: %s\n", sqlite3_errmsg(db));
    sqlite3_finalize(t);
    t = NULL;
    sqlite3_prepare_v2(db, "SELECT name FROM sqlite_schema WHERE type = 'table' ORDER BY name", -1, &t, NULL);
    while (t && sqlite3_step(t) == SQLITE_ROW)
        dump_table(db, (const char *)sqlite3_column_text(t, 0), f);
    sqlite3_finalize(t);
    sqlite3_close(db);
    fclose(f);
    return text;
}

static inline double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9*(double)t.tv_nsec;
}

/* Start `arguments` (split at blanks) of the program in `folder`, silent; kill it after so many seconds, < 0: let it
 * end.  Returns the exit code, -1 when it was killed. */
static inline int start_and_kill(const char *folder, const char *arguments, double seconds)
{
    char line[512], *word[32];
    int n = 0, status;
    const char *program = getenv("LW_PROGRAM");
    char *whole = realpath(program ? program : "build/linkwright", NULL);
    snprintf(line, sizeof line, "%s", arguments);
    word[n++] = whole;
    for (char *w = strtok(line, " "); w && n < 31; w = strtok(NULL, " "))
        word[n++] = w;
    word[n] = NULL;
    pid_t pid = fork();
    if (pid == 0) {
        if (chdir(folder) != 0 || !freopen("/dev/null", "w", stderr) || !freopen("/dev/null", "w", stdout))
            _exit(99);
        execv(whole, word);
        _exit(99);
    }
    free(whole);
    if (seconds >= 0) {
        nanosleep(&(struct timespec){ (time_t)seconds, (long)(1e9*(seconds - (double)(time_t)seconds)) }, NULL);
        kill(pid, SIGKILL);
    }
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* Kill `arguments`, which work on `file` in `folder`, at `n` random moments of a run that takes `seconds`; after
 * each kill the file must be whole, and in the end hold what `want` says.  Whenever a run came through, `reset`
 * prepares the file for the next one. */
static inline void kill_at_random(const char *folder, const char *file, const char *arguments, double seconds, int n,
                                  const char *want, void (*reset)(const char *path))
{
    lw_rng rng;
    char path[300];
    int n_killed = 0;
    lw_rng_seed(&rng, check_seed(), 77);
    snprintf(path, sizeof path, "%s/%s", folder, file);
    reset(path);
    for (int tries = 0; n_killed < n && tries < 20*n; tries++) {
        int code = start_and_kill(folder, arguments, lw_rng_range(&rng, 0, 1.1*seconds));
        n_killed += code == -1;
        CHECK(code == -1 || code == 0);
        char *now = access(path, F_OK) == 0 ? dump_catalogue(path) : NULL;
        CHECK(!now || strncmp(now, "damaged", 7) != 0);
        if (code == 0) {
            CHECK(now && strcmp(now, want) == 0);
            reset(path);
        }
        free(now);
    }
    CHECK_INT(n_killed, n);
    CHECK_INT(start_and_kill(folder, arguments, -1), 0);
    char *now = dump_catalogue(path);
    CHECK(strcmp(now, want) == 0);
    free(now);
}

#endif
