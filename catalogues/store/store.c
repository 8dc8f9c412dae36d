/* catalogues/store/store.c - opening, locking, transactions (bridge to SQLite, with the other store*.c). */
#include "catalogues/store/store.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include "base/clock.h"
#include "base/file.h"
#include "base/real.h"
#include "catalogues/store/store_internal.h"

#define BUSY_MILLISECONDS 10000       /* how long a reader waits for a commit, and a commit for readers */

int lw_store_found_version(const lw_store *s) { return s->found_version; }

/* ---- failures ------------------------------------------------------------------------------------ */

lw_status lw_store_fail(lw_store *s, int code, const char *doing, lw_error *e)
{
    switch (code & 0xff) {
    case SQLITE_NOMEM:
        return lw_error_at(e, LW_E_MEMORY, s->path, 0, 0, "out of memory");
    case SQLITE_FULL:
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "the disk is full; what was committed before is kept: make room "
                           "and give the same command again");
    case SQLITE_INTERRUPT:
        return lw_error_at(e, LW_STOPPED, s->path, 0, 0, "stopped");
    case SQLITE_NOTADB:
        return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "this is no SQLite file");
    case SQLITE_CORRUPT:
        return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "the file is damaged (%s); take a copy of before, or build "
                           "it again", sqlite3_errmsg(s->db));
    case SQLITE_READONLY:
    case SQLITE_PERM:
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "the file or its folder is read-only");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "another program keeps the file locked");
    case SQLITE_IOERR:
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "%s: %s%s%s; what was committed before is kept", doing, sqlite3_errmsg(s->db),
                           sqlite3_system_errno(s->db) ? ": " : "",
                           sqlite3_system_errno(s->db) ? strerror(sqlite3_system_errno(s->db)) : "");
    default:
        return lw_error_at(e, code == SQLITE_CANTOPEN ? LW_E_IO : LW_E_NOTATION, s->path, 0, 0, "%s: %s", doing, sqlite3_errmsg(s->db));
    }
}

/* ---- statements ---------------------------------------------------------------------------------- */

lw_status lw_store_prepare(lw_store *s, const char *sql, sqlite3_stmt **statement, lw_error *e)
{
    for (int i = 0; i < s->n_statement; i++)
        if (s->statement[i].sql == sql) {
            *statement = s->statement[i].statement;
            sqlite3_reset(*statement);
            sqlite3_clear_bindings(*statement);
            return LW_OK;
        }
    if (s->n_statement == LW_STORE_STATEMENT_MAX)
        return lw_error_set(e, LW_E_ARG, "more different statements than the store has room for");
    int code = sqlite3_prepare_v3(s->db, sql, -1, SQLITE_PREPARE_PERSISTENT, statement, NULL);
    if (code != SQLITE_OK)
        return lw_store_fail(s, code, "the tables are not those of a catalogue", e);
    s->statement[s->n_statement].sql = sql;
    s->statement[s->n_statement++].statement = *statement;
    return LW_OK;
}

static int bind_all(sqlite3_stmt *t, const char *format, va_list arg)
{
    int code = SQLITE_OK;
    for (int i = 1; *format && code == SQLITE_OK; format++, i++)
        switch (*format) {
        case 'i':
            code = sqlite3_bind_int64(t, i, va_arg(arg, long long));
            break;
        case 'd': {
            double v = va_arg(arg, double);
            code = isfinite(v) ? sqlite3_bind_double(t, i, v) : sqlite3_bind_null(t, i);
            break;
        }
        case 't':
            code = sqlite3_bind_text(t, i, va_arg(arg, const char *), -1, SQLITE_STATIC);
            break;
        case 'b': {
            const void *data = va_arg(arg, const void *);
            size_t size = va_arg(arg, size_t);
            code = sqlite3_bind_blob64(t, i, data, size, SQLITE_STATIC);
            break;
        }
        default:
            code = SQLITE_MISUSE;
        }
    return code;
}

lw_status lw_store_do(lw_store *s, const char *sql, lw_error *e, const char *format, ...)
{
    sqlite3_stmt *t;
    lw_status status = lw_store_prepare(s, sql, &t, e);
    if (status != LW_OK)
        return status;
    va_list arg;
    va_start(arg, format);
    int code = bind_all(t, format, arg);
    va_end(arg);
    while (code == SQLITE_OK || code == SQLITE_ROW)
        code = sqlite3_step(t);
    if (code != SQLITE_DONE)
        status = lw_store_fail(s, code, "cannot be written", e);
    sqlite3_reset(t);
    return status;
}

lw_status lw_store_find(lw_store *s, const char *sql, sqlite3_int64 *found, bool *any, lw_error *e, const char *format, ...)
{
    sqlite3_stmt *t;
    lw_status status = lw_store_prepare(s, sql, &t, e);
    if (status != LW_OK)
        return status;
    va_list arg;
    va_start(arg, format);
    int code = bind_all(t, format, arg);
    va_end(arg);
    code = code == SQLITE_OK ? sqlite3_step(t) : code;
    *any = code == SQLITE_ROW && sqlite3_column_type(t, 0) != SQLITE_NULL;
    if (*any)
        *found = sqlite3_column_int64(t, 0);
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        status = lw_store_fail(s, code, "cannot be read", e);
    sqlite3_reset(t);
    return status;
}

/* ---- the lock of whoever writes ------------------------------------------------------------------ */

/* Name the process that holds the lock, from what it wrote into the lock file. */
static lw_status say_who(const lw_store *s, lw_error *e)
{
    char who[400];
    ssize_t n = pread(s->lock, who, sizeof who - 1, 0);
    who[n > 0 ? n : 0] = 0;
    who[strcspn(who, "\n")] = 0;
    return lw_error_at(e, LW_E_IO, s->path, 0, 0, "%s writes to it; wait until it is through, or give it longer with "
                                                  "--wait", *who ? who : "another program");
}

/* Is the open file still the one under its name? The last holder may have removed it. */
static bool same_file(const lw_store *s)
{
    struct stat open_one, named;
    return fstat(s->lock, &open_one) == 0 && stat(s->lock_path, &named) == 0 && open_one.st_ino == named.st_ino
        && open_one.st_dev == named.st_dev;
}

static lw_status take_lock(lw_store *s, const lw_store_options *o, lw_error *e)
{
    double until = lw_clock_wall() + o->wait;
    for (;;) {
        s->lock = open(s->lock_path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (s->lock < 0)
            return lw_file_failed(e, "written", s->path, errno);
        if (flock(s->lock, LOCK_EX | LOCK_NB) == 0 && same_file(s))
            break;
        if (lw_clock_wall() >= until)
            say_who(s, e);
        close(s->lock);
        s->lock = -1;
        if (lw_clock_wall() >= until)
            return LW_E_IO;
        nanosleep(&(struct timespec){ .tv_nsec = 20000000 }, NULL);
    }
    char who[400];
    int n = snprintf(who, sizeof who, "process %ld (%.300s)\n", (long)getpid(), o->command ? o->command : "?");
    if (ftruncate(s->lock, 0) != 0 || pwrite(s->lock, who, (size_t)n, 0) != n)
        return LW_OK;                         /* a waiting process then learns less; the lock is held all the same */
    return LW_OK;
}

static void drop_lock(lw_store *s)
{
    if (s->lock < 0)
        return;
    unlink(s->lock_path);
    close(s->lock);
    s->lock = -1;
}

/* ---- opening ------------------------------------------------------------------------------------- */

/* SQLite gives ":memory:", "" and "file:..." a special meaning. */
static lw_status set_paths(lw_store *s, const char *path, lw_error *e)
{
    if (!*path)
        return lw_error_set(e, LW_E_ARG, "the name of the catalogue is empty");
    bool special = *path == ':' || strncmp(path, "file:", 5) == 0;
    int n = snprintf(s->path, sizeof s->path, "%s%s", special ? "./" : "", path);
    if (n < 0 || (size_t)n >= sizeof s->path)
        return lw_error_set(e, LW_E_ARG, "the name of the catalogue is longer than %zu bytes", sizeof s->path - 1);
    snprintf(s->lock_path, sizeof s->lock_path, "%s-lock", s->path);
    return LW_OK;
}

#define SQLITE_HEAD 100        /* bytes */

/* Check what the file system knows of the file before SQLite opens it. */
static lw_status look_at(const lw_store *s, const lw_store_options *o, lw_error *e)
{
    struct stat st;
    bool there = stat(s->path, &st) == 0;
    if (!there && errno != ENOENT)
        return lw_file_failed(e, "read", s->path, errno);
    if (there && S_ISDIR(st.st_mode))
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "this is a folder");
    if (there && !S_ISREG(st.st_mode))
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "this is no plain file");
    if ((!there || st.st_size == 0) && !o->create)
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, there ? "the file is empty; 'linkwright catalogue build' fills "
                           "one" : "there is no such file; 'linkwright catalogue build' makes one");
    if (there && st.st_size > 0 && st.st_size < SQLITE_HEAD)       /* SQLite takes a file of one byte for an empty one */
        return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "this is no SQLite file: it has %lld bytes", (long long)st.st_size);
    if (there && o->write && ((st.st_mode & 0222) == 0 || access(s->path, W_OK) != 0))
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "the file is read-only");
    return LW_OK;
}

static int is_stopped(void *store)
{
    return *((lw_store *)store)->stop != 0;
}

void lw_store_watch(lw_store *s)
{
    sqlite3_progress_handler(s->db, s->stop ? 10000 : 0, is_stopped, s);
}

static lw_status set_up(lw_store *s, lw_error *e)
{
    static const char *const pragmas[] = {
        "PRAGMA trusted_schema=OFF", "PRAGMA cell_size_check=ON", "PRAGMA foreign_keys=ON", "PRAGMA temp_store=MEMORY",
        "PRAGMA mmap_size=0",         /* a file that another program cuts short is an error then, not SIGBUS */
    };
    sqlite3_busy_timeout(s->db, BUSY_MILLISECONDS);
    lw_store_watch(s);
    sqlite3_extended_result_codes(s->db, 1);
    sqlite3_db_config(s->db, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    for (size_t i = 0; i < sizeof pragmas/sizeof *pragmas; i++) {
        int code = sqlite3_exec(s->db, pragmas[i], NULL, NULL, NULL);
        if (code != SQLITE_OK)
            return lw_store_fail(s, code, "cannot be opened", e);
    }
    return LW_OK;
}

static lw_status read_pragma(lw_store *s, const char *sql, int *value, lw_error *e)
{
    sqlite3_stmt *t;
    int code = sqlite3_prepare_v2(s->db, sql, -1, &t, NULL);
    if (code == SQLITE_OK)
        code = sqlite3_step(t);
    *value = code == SQLITE_ROW ? sqlite3_column_int(t, 0) : 0;
    lw_status status = code == SQLITE_ROW || code == SQLITE_DONE ? LW_OK : lw_store_fail(s, code, "cannot be read", e);
    sqlite3_finalize(t);
    return status;
}

/* Check that the file is a catalogue, and its version. Version 0 without any table is a new file. */
static lw_status identify(lw_store *s, lw_error *e)
{
    int application = 0, n_table = 0;
    lw_status status = read_pragma(s, "PRAGMA application_id", &application, e);
    if (status == LW_OK)
        status = read_pragma(s, "PRAGMA user_version", &s->found_version, e);
    if (status == LW_OK)
        status = read_pragma(s, "SELECT count(*) FROM sqlite_schema", &n_table, e);
    if (status != LW_OK)
        return status;
    if (application == 0 && s->found_version == 0 && n_table == 0)
        return LW_OK;
    if (application != LW_STORE_APPLICATION)
        return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "this is a database of another program (application_id "
                           "0x%08X, not 0x%08X); it stays as it is", (unsigned)application,
                           (unsigned)LW_STORE_APPLICATION);
    if (s->found_version > lw_store_step_count)
        return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "the file has schema version %d and comes from a newer "
                           "program; this one, " LW_VERSION ", knows versions 1 to %d", s->found_version,
                           lw_store_step_count);
    if (s->found_version < 1)
        return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "the file has no schema version");
    return LW_OK;
}

static lw_status connect_to(lw_store *s, int flags, lw_error *e)
{
    int code = sqlite3_open_v2(s->path, &s->db, flags | SQLITE_OPEN_NOMUTEX, NULL);
    if (!s->db)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (code != SQLITE_OK)
        return lw_store_fail(s, code, "cannot be opened", e);
    lw_status status = set_up(s, e);
    return status == LW_OK ? identify(s, e) : status;
}

static void disconnect(lw_store *s)
{
    for (int i = 0; i < s->n_statement; i++)
        sqlite3_finalize(s->statement[i].statement);
    s->n_statement = 0;
    sqlite3_close(s->db);
    s->db = NULL;
}

/* Open for reading. If a program was killed in a transaction it left a journal beside the file, and an older file needs
 * migration: in both cases a connection that may write is opened first, then the one that may not. */
static lw_status open_to_read(lw_store *s, const lw_store_options *o, lw_error *e)
{
    char journal[sizeof s->path + 16];
    snprintf(journal, sizeof journal, "%s-journal", s->path);
    bool left_over = access(journal, F_OK) == 0 && access(s->path, W_OK) == 0;
    lw_status status = connect_to(s, left_over ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY, e);
    if (status != LW_OK)
        return status;
    if (s->found_version == 0)
        return lw_error_at(e, LW_E_IO, s->path, 0, 0, "the database is empty; 'linkwright catalogue build' fills one");
    if (s->found_version < lw_store_step_count) {
        int found = s->found_version;
        lw_store *again;
        lw_store_options write = { .write = true, .wait = o->wait, .command = o->command,
                                   .stop = o->stop };
        disconnect(s);
        status = lw_store_open(s->path, &write, &again, e);
        lw_store_close(again);
        if (status == LW_OK)
            status = connect_to(s, SQLITE_OPEN_READONLY, e);
        s->found_version = found;
    } else if (left_over) {
        disconnect(s);
        status = connect_to(s, SQLITE_OPEN_READONLY, e);
    }
    return status;
}

static int run_steps(lw_store *s, int from)
{
    char sql[80];
    int code = SQLITE_OK;
    for (int i = from; i < lw_store_step_count && code == SQLITE_OK; i++)
        code = sqlite3_exec(s->db, lw_store_steps[i], NULL, NULL, NULL);
    if (code != SQLITE_OK)
        return code;
    snprintf(sql, sizeof sql, "PRAGMA application_id=%d; PRAGMA user_version=%d", LW_STORE_APPLICATION, lw_store_step_count);
    return sqlite3_exec(s->db, sql, NULL, NULL, NULL);
}

/* Bring the file from version `from` to the newest, in one transaction. */
static lw_status migrate(lw_store *s, int from, lw_error *e)
{
    lw_status status = lw_store_begin(s, e);
    if (status != LW_OK)
        return status;
    int code = run_steps(s, from);
    if (code != SQLITE_OK) {
        status = lw_store_fail(s, code, from ? "an older file cannot be brought up to date" : "cannot be made", e);
        lw_store_rollback(s);
        return status;
    }
    return lw_store_commit(s, e);
}

static lw_status open_to_write(lw_store *s, const lw_store_options *o, lw_error *e)
{
    lw_status status = take_lock(s, o, e);
    s->made = access(s->path, F_OK) != 0;
    if (status == LW_OK)
        status = connect_to(s, SQLITE_OPEN_READWRITE | (o->create ? SQLITE_OPEN_CREATE : 0), e);
    if (status == LW_OK && s->found_version < lw_store_step_count)
        status = migrate(s, s->found_version, e);
    return status;
}

lw_status lw_store_open(const char *path, const lw_store_options *o, lw_store **store, lw_error *e)
{
    lw_store *s = calloc(1, sizeof *s);
    *store = NULL;
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    s->lock = -1;
    s->writes = o->write;
    s->stop = o->write ? NULL : o->stop;      /* what a writer has begun it commits */
    lw_status status = set_paths(s, path, e);
    if (status == LW_OK)
        status = look_at(s, o, e);
    if (status == LW_OK)
        status = (o->write ? open_to_write : open_to_read)(s, o, e);
    if (status != LW_OK) {
        lw_store_close(s);
        return status;
    }
    *store = s;
    return LW_OK;
}

/* After a failure (a full disk) SQLite leaves its journal for the next program that opens the file. Open the file here,
 * which removes the journal and frees its space. Remove a new file that never held anything. */
static void tidy_up(lw_store *s)
{
    struct stat st;
    char journal[sizeof s->path + 16];
    lw_error ignored;
    snprintf(journal, sizeof journal, "%s-journal", s->path);
    if (access(journal, F_OK) == 0) {
        (void)connect_to(s, SQLITE_OPEN_READWRITE, &ignored);
        disconnect(s);
    }
    if (s->made && stat(s->path, &st) == 0 && st.st_size == 0)
        unlink(s->path);
}

void lw_store_close(lw_store *s)
{
    if (!s)
        return;
    disconnect(s);
    if (s->lock >= 0)
        tidy_up(s);
    drop_lock(s);
    free(s);
}

const char *lw_store_path(const lw_store *s) { return s->path; }

/* ---- transactions and runs ----------------------------------------------------------------------- */

lw_status lw_store_begin(lw_store *s, lw_error *e)
{
    if (!s->writes)
        return lw_error_at(e, LW_E_ARG, s->path, 0, 0, "the catalogue was opened for reading");
    return lw_store_do(s, "BEGIN IMMEDIATE", e, "");
}

lw_status lw_store_commit(lw_store *s, lw_error *e)
{
    return lw_store_do(s, "COMMIT", e, "");
}

void lw_store_rollback(lw_store *s)
{
    if (s->db && !sqlite3_get_autocommit(s->db))
        sqlite3_exec(s->db, "ROLLBACK", NULL, NULL, NULL);
}

/* 2026-01-31T12:00:00Z */
static void time_now(char text[32])
{
    time_t now = time(NULL);
    struct tm utc;
    strftime(text, 32, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
}

lw_status lw_store_run_begin(lw_store *s, const lw_store_run *r, lw_error *e)
{
    char now[32], seed[24];
    bool any;
    snprintf(seed, sizeof seed, "%llu", (unsigned long long)r->seed);
    lw_status status = lw_store_find(s, "SELECT id FROM run WHERE action = ?1 AND what = ?2 AND command = ?3 AND seed "
                                        "= ?4 AND program = ?5 AND ended IS NULL", &s->run, &any, e, "ttttt", r->action,
                                     r->what, r->command, seed, LW_VERSION);
    if (status != LW_OK || any)
        return status;
    time_now(now);
    status = lw_store_do(s, "INSERT INTO run(action, what, program, seed, command, units, begun) "
                         "VALUES(?1, ?2, ?3, ?4, ?5, 'm rad s', ?6)", e, "tttttt", r->action, r->what, LW_VERSION, seed,
                         r->command, now);
    s->run = sqlite3_last_insert_rowid(s->db);
    return status;
}

lw_status lw_store_run_end(lw_store *s, lw_error *e)
{
    char now[32];
    time_now(now);
    return lw_store_do(s, "UPDATE run SET ended = ?1 WHERE id = ?2", e, "ti", now, (long long)s->run);
}

lw_status lw_store_copy_undated(lw_store *s, const char *path, lw_error *e)
{
    lw_output copy;
    lw_status status = lw_store_do(s, "UPDATE run SET begun = '', ended = ''", e, "");
    if (status == LW_OK)
        status = lw_output_open(&copy, path, e);
    if (status != LW_OK)
        return status;
    status = lw_store_do(s, "VACUUM INTO ?1", e, "t", copy.temp);
    if (status == LW_OK)
        return lw_output_commit(&copy, e);
    lw_output_abandon(&copy);
    return status;
}
