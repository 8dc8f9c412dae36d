/* A query that can be read becomes SQL that SQLite accepts. */
#include <sqlite3.h>
#include "catalogues/store/query.h"
#include "catalogues/store/store_internal.h"
#include "tests/fuzz/fuzz.h"

/* A catalogue in memory, made once. */
static sqlite3 *tables(void)
{
    static sqlite3 *db;
    if (db)
        return db;
    if (sqlite3_open(":memory:", &db) != SQLITE_OK)
        abort();
    for (int i = 0; i < lw_store_step_count; i++)
        if (sqlite3_exec(db, lw_store_steps[i], NULL, NULL, NULL) != SQLITE_OK)
            abort();
    return db;
}

static int one_input(const uint8_t *data, size_t size)
{
    lw_query q;
    lw_error e;
    lw_query_options o = { .list = size > 0 && data[0] < LW_LIST_ANY ? (lw_query_list)data[0] : LW_LIST_ANY };
    char *text = malloc(size + 1);
    if (!text)
        return 0;
    memcpy(text, data, size);
    text[size] = 0;
    if (lw_query_compile(text, &o, &q, &e) == LW_OK) {
        sqlite3_stmt *t = NULL;
        if (sqlite3_prepare_v2(tables(), q.sql.data, -1, &t, NULL) != SQLITE_OK || !sqlite3_stmt_readonly(t)
            || sqlite3_bind_parameter_count(t) != q.n_value)
            abort();
        sqlite3_finalize(t);
    }
    lw_query_free(&q);
    free(text);
    return 0;
}
