/* tests/catalogue_file.h - for tests of catalogues: the whole content of a file as text, checked for damage, and
 * programs that are killed while they write one. */
#ifndef LW_TESTS_CATALOGUE_FILE_H
#define LW_TESTS_CATALOGUE_FILE_H

#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>
#include "tests/cli_run.h"

/* Rows of a table as text, without the times of day. */
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

/* Run `arguments` (split at blanks) of the test build of the program in `folder`, silent, with its clock 1 ms later at
 * each reading.  It is killed right before it changes a file for the n-th time; 0: it may end.  Returns the exit code,
 * -1 when it was killed.  *n_write, unless NULL, is the number of changes of a run that ended. */
static inline int run_and_kill(const char *folder, const char *arguments, long n, long *n_write)
{
    char line[512], *word[32], number[32];
    const char *program = getenv("C");
    int n_word = 0, status;
    char *whole = realpath(program, NULL);
    snprintf(line, sizeof line, "%s", arguments);
    snprintf(number, sizeof number, "%ld", n);
    word[n_word++] = whole;
    for (char *w = strtok(line, " "); w && n_word < 31; w = strtok(NULL, " "))
        word[n_word++] = w;
    word[n_word] = NULL;
    pid_t pid = fork();
    if (pid == 0) {
        setenv("LW_CLOCK_STEP", "0.001", 1);
        setenv("LW_KILL_AT_WRITE", number, 1);
        setenv("LW_WRITES_FILE", "writes", 1);
        if (chdir(folder) != 0 || !freopen("/dev/null", "w", stderr) || !freopen("/dev/null", "w", stdout))
            _exit(99);
        execv(whole, word);
        _exit(99);
    }
    free(whole);
    waitpid(pid, &status, 0);
    if (n_write) {
        char path[300];
        snprintf(path, sizeof path, "%s/writes", folder);
        FILE *f = fopen(path, "r");
        CHECK(f && fscanf(f, "%ld", n_write) == 1);
        if (f)
            fclose(f);
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static inline void remove_catalogue(const char *path)
{
    char journal[320];
    snprintf(journal, sizeof journal, "%s-journal", path);
    remove(path);
    remove(journal);
}

/* Run `arguments`, which fill the catalogue `file` in the folder $D/killed, once to the end.  Then kill further runs
 * n_kill times, each at a random change of a file.  After each kill the catalogue must be whole.  A run that ends must
 * leave the same content as the first run, of which `has` is a part; the next run then begins without a file. */
static inline void kill_at_random(const char *file, const char *arguments, int n_kill, const char *has)
{
    char folder[280], path[300];
    long n_write = 0;
    int n_killed = 0;
    lw_rng rng = check_rng(77);
    snprintf(folder, sizeof folder, "%s/killed", temporary_folder());
    snprintf(path, sizeof path, "%s/%s", folder, file);
    CHECK_INT(run_and_kill(folder, arguments, 0, &n_write), 0);
    CHECK(n_write > n_kill);
    char *complete = dump_catalogue(path);
    CHECK(strlen(complete) > 1000 && strncmp(complete, "damaged", 7) != 0);
    CHECK_HAS(complete, has);
    remove_catalogue(path);
    for (int tries = 0; n_killed < n_kill && tries < 20*n_kill; tries++) {
        int code = run_and_kill(folder, arguments, 1 + (long)(lw_rng_uniform(&rng)*(double)n_write), NULL);
        n_killed += code == -1;
        CHECK(code == -1 || code == 0);
        char *now = access(path, F_OK) == 0 ? dump_catalogue(path) : NULL;
        CHECK(!now || strncmp(now, "damaged", 7) != 0);
        if (code == 0) {
            CHECK(now && strcmp(now, complete) == 0);
            remove_catalogue(path);
        }
        free(now);
    }
    CHECK_INT(n_killed, n_kill);
    CHECK_INT(run_and_kill(folder, arguments, 0, NULL), 0);
    char *now = dump_catalogue(path);
    CHECK(strcmp(now, complete) == 0);
    free(now);
    free(complete);
}

#endif
