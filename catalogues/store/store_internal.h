/* catalogues/store/store_internal.h - what the files of the store share: prepared statements, values bound by a format,
 * texts for failures of SQLite. */
#ifndef LW_CATALOGUES_STORE_STORE_INTERNAL_H
#define LW_CATALOGUES_STORE_STORE_INTERNAL_H

#include <sqlite3.h>
#include "base/file.h"
#include "catalogues/store/store.h"

#define LW_STORE_STATEMENT_MAX 32

struct lw_store {
    sqlite3      *db;
    char          path[LW_PATH_SIZE], lock_path[LW_PATH_SIZE + 16];
    const volatile int *stop;                /* NULL: nothing stops a statement                       */
    int           lock, found_version;       /* lock: a file descriptor, -1 when nothing is written   */
    bool          writes, made;              /* made: there was no file                               */
    sqlite3_int64 run, build, sweep;
    int           n_statement;
    struct { const char *sql; sqlite3_stmt *statement; } statement[LW_STORE_STATEMENT_MAX];
};

/* The schema as steps from one version to the next: step[0] makes version 1 of an empty file. */
extern const char *const lw_store_steps[];
extern const int         lw_store_step_count;

/* Fill e with the reason of SQLite's last failure (or of `code`) and the file's name; `doing` is "cannot be read" or the like. */
lw_status lw_store_fail(lw_store *s, int code, const char *doing, lw_error *e);

/* Let the flag `stop` end statements; again after another progress handler was set. */
void lw_store_watch(lw_store *s);

/* The prepared statement of this text, reset and without values.  The same pointer gives the same statement. */
lw_status lw_store_prepare(lw_store *s, const char *sql, sqlite3_stmt **statement, lw_error *e);

/* Bind ?1, ?2, ... by letters: i long long, d double, t const char * (NULL: null), b const void * and size_t; d
 * that is not finite becomes null.  Run to its end. */
lw_status lw_store_do(lw_store *s, const char *sql, lw_error *e, const char *format, ...);

/* The same for a SELECT of at most one row with one whole number. */
lw_status lw_store_find(lw_store *s, const char *sql, sqlite3_int64 *found, bool *any, lw_error *e, const char *format, ...);

/* The terms, or else the linkages, of one block of curves, which must have this size in bytes. */
lw_status lw_store_block(lw_store *s, long long id, bool linkages, void *to, size_t size, lw_error *e);

#endif
