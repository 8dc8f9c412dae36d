/* catalogues/store/store_ask.c - queries of the store: our own, and SQL written by the user. */
#include <stdio.h>
#include <string.h>
#include "catalogues/store/store_internal.h"

/* What the user's SQL may do: read tables and call functions. ATTACH, writing, and PRAGMAs that change anything are
 * refused; the connection is read-only besides. */
static int allow(void *context, int action, const char *first, const char *second, const char *base, const char *trigger)
{
    (void)context, (void)base, (void)trigger;
    switch (action) {
    case SQLITE_SELECT:
    case SQLITE_READ:
    case SQLITE_RECURSIVE:
        return SQLITE_OK;
    case SQLITE_FUNCTION:
        return second && strcmp(second, "load_extension") == 0 ? SQLITE_DENY : SQLITE_OK;
    case SQLITE_PRAGMA:
        return first && (!strcmp(first, "table_info") || !strcmp(first, "table_list")) ? SQLITE_OK : SQLITE_DENY;
    default:
        return SQLITE_DENY;
    }
}

static int keep_going(void *query)
{
    const lw_store_query *q = query;
    return !q->goes_on(q->context);
}

static int bind(sqlite3_stmt *t, const lw_value *v, int i)
{
    switch (v->kind) {
    case LW_VALUE_INTEGER: return sqlite3_bind_int64(t, i, v->integer);
    case LW_VALUE_REAL:    return sqlite3_bind_double(t, i, v->real);
    case LW_VALUE_TEXT:    return sqlite3_bind_text64(t, i, v->text, v->size, SQLITE_STATIC, SQLITE_UTF8);
    case LW_VALUE_BLOB:    return sqlite3_bind_blob64(t, i, v->text, v->size, SQLITE_STATIC);
    case LW_VALUE_NULL:    break;
    }
    return sqlite3_bind_null(t, i);
}

static lw_value column(sqlite3_stmt *t, int i)
{
    lw_value v = { .kind = LW_VALUE_NULL };
    switch (sqlite3_column_type(t, i)) {
    case SQLITE_INTEGER:
        v.kind = LW_VALUE_INTEGER;
        v.integer = sqlite3_column_int64(t, i);
        v.real = (double)v.integer;
        break;
    case SQLITE_FLOAT:
        v.kind = LW_VALUE_REAL;
        v.real = sqlite3_column_double(t, i);
        break;
    case SQLITE_TEXT:
        v.kind = LW_VALUE_TEXT;
        v.text = (const char *)sqlite3_column_text(t, i);
        v.size = (size_t)sqlite3_column_bytes(t, i);
        break;
    case SQLITE_BLOB:
        v.kind = LW_VALUE_BLOB;
        v.text = sqlite3_column_blob(t, i);
        v.size = (size_t)sqlite3_column_bytes(t, i);
        break;
    default:
        break;
    }
    return v;
}

#define COLUMN_MAX 100

static lw_status read_rows(lw_store *s, sqlite3_stmt *t, const lw_store_query *q, lw_error *e)
{
    const char *name[COLUMN_MAX];
    lw_value value[COLUMN_MAX];
    int n = sqlite3_column_count(t), code;
    lw_status status = LW_OK;
    if (n > COLUMN_MAX)
        return lw_error_set(e, LW_E_ARG, "%d columns are more than %d", n, COLUMN_MAX);
    /* the first step may compile the statement again for the values bound (GLOB), so earlier names are no longer valid
     */
    code = sqlite3_step(t);
    for (int i = 0; i < n; i++)
        name[i] = sqlite3_column_name(t, i);
    if (q->head)
        status = q->head(q->context, n, name);
    for (; status == LW_OK && code != SQLITE_DONE; code = sqlite3_step(t)) {
        if (code == SQLITE_INTERRUPT)
            return lw_error_set(e, LW_STOPPED, "stopped");
        if (code != SQLITE_ROW)
            return lw_store_fail(s, code, "cannot be read", e);
        for (int i = 0; i < n; i++) {
            value[i] = column(t, i);
            if (value[i].kind == LW_VALUE_TEXT && !value[i].text)
                return lw_error_set(e, LW_E_MEMORY, "out of memory");
        }
        status = q->row(q->context, n, name, value);
    }
    return status;
}

/* Report the error of the user's SQL, with its column if SQLite knows it. */
static lw_status sql_fault(lw_store *s, const lw_store_query *q, int code, lw_error *e)
{
    int at = sqlite3_error_offset(s->db);
    if (!q->foreign)
        return lw_store_fail(s, code, "cannot be read", e);
    if ((code & 0xff) == SQLITE_AUTH)
        return lw_error_set(e, LW_E_ARG, "the SQL may read the tables of the catalogue and nothing else (%s)", sqlite3_errmsg(s->db));
    if ((code & 0xff) != SQLITE_ERROR)
        return lw_store_fail(s, code, "cannot be read", e);
    return lw_error_at(e, LW_E_NOTATION, "SQL", at < 0 ? 0 : 1, at + 1, "%s", sqlite3_errmsg(s->db));
}

static lw_status ask(lw_store *s, const lw_store_query *q, lw_error *e)
{
    sqlite3_stmt *t = NULL;
    const char *rest = NULL;
    lw_status status = LW_OK;
    int code = sqlite3_prepare_v2(s->db, q->sql, -1, &t, &rest);
    if (code != SQLITE_OK)
        return sql_fault(s, q, code, e);
    if (!t)
        status = lw_error_set(e, LW_E_ARG, "the SQL says nothing");
    else if (rest[strspn(rest, " \t\r\n;")])
        status = lw_error_set(e, LW_E_ARG, "one SELECT at a time: '%.40s' comes after it", rest);
    else if (!sqlite3_stmt_readonly(t) || sqlite3_column_count(t) == 0)
        status = lw_error_set(e, LW_E_ARG, "only a SELECT can be asked here");
    for (int i = 0; i < q->n_value && status == LW_OK; i++)
        if ((code = bind(t, &q->value[i], i + 1)) != SQLITE_OK)
            status = lw_store_fail(s, code, "a value cannot be bound", e);
    if (status == LW_OK)
        status = read_rows(s, t, q, e);
    sqlite3_finalize(t);
    return status;
}

lw_status lw_store_ask(lw_store *s, const lw_store_query *q, lw_error *e)
{
    if (q->foreign) {
        sqlite3_set_authorizer(s->db, allow, NULL);
        sqlite3_limit(s->db, SQLITE_LIMIT_SQL_LENGTH, 100000);
        sqlite3_limit(s->db, SQLITE_LIMIT_EXPR_DEPTH, 100);
        sqlite3_limit(s->db, SQLITE_LIMIT_LENGTH, 100000000);
    }
    if (q->goes_on)
        sqlite3_progress_handler(s->db, 10000, keep_going, (void *)(uintptr_t)q);
    lw_status status = ask(s, q, e);
    lw_store_watch(s);
    sqlite3_set_authorizer(s->db, NULL, NULL);
    return status;
}

/* ---- one number ---------------------------------------------------------------------------------- */

static lw_status take_number(void *context, int n_column, const char *const *name, const lw_value *value)
{
    (void)name;
    if (n_column > 0)
        *(long long *)context = value[0].integer;
    return LW_OK;
}

lw_status lw_store_number(lw_store *s, const char *sql, const lw_value *value, int n_value, long long *number, lw_error *e)
{
    lw_store_query q = { .sql = sql, .value = value, .n_value = n_value, .row = take_number, .context = number };
    *number = 0;
    return lw_store_ask(s, &q, e);
}

/* ---- examination --------------------------------------------------------------------------------- */

typedef struct complaint { char text[256]; } complaint;

static lw_status take_complaint(void *context, int n_column, const char *const *name, const lw_value *value)
{
    (void)n_column, (void)name;
    complaint *c = context;
    if (!c->text[0] && value[0].text && strcmp(value[0].text, "ok") != 0)
        snprintf(c->text, sizeof c->text, "%.200s", value[0].text);
    return LW_OK;
}

lw_status lw_store_verify(lw_store *s, lw_error *e)
{
    static const char *const pragmas[] = { "PRAGMA integrity_check(1)", "PRAGMA foreign_key_check" };
    for (size_t i = 0; i < sizeof pragmas/sizeof *pragmas; i++) {
        complaint c = { "" };
        lw_store_query q = { .sql = pragmas[i], .row = take_complaint, .context = &c };
        lw_status status = lw_store_ask(s, &q, e);
        if (status != LW_OK)
            return status;
        if (c.text[0])
            return lw_error_at(e, LW_E_NOTATION, s->path, 0, 0, "the file is damaged: %s%s", c.text,
                               i ? " points to a row that is not there" : "");
    }
    return LW_OK;
}

lw_status lw_store_has_table(lw_store *s, const char *table, bool *has, lw_error *e)
{
    long long n = 0;
    lw_value v = { .kind = LW_VALUE_TEXT, .text = table, .size = strlen(table) };
    lw_status status = lw_store_number(s, "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = ?1", &v, 1, &n, e);
    *has = n > 0;
    return status;
}
