#include "catalogues/store/drive_store.h"

#include <string.h>
#include "catalogues/store/store_internal.h"

/* Columns in the order of lw_part_columns. */
static const char *const insert[] = {
    ("INSERT OR REPLACE INTO motor(name, run, torque_constant, resistance, inductance, inertia, torque, torque_peak, "
     "speed, mass, price) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)"),
    ("INSERT OR REPLACE INTO gear(name, run, ratio, radius, efficiency, inertia, torque, torque_peak, speed, mass, "
     "price) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)"),
    ("INSERT OR REPLACE INTO amplifier(name, run, voltage, current, current_peak, peak_time, mass, price) "
     "VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)") };
static const char *const choose[] = {
    ("SELECT name, torque_constant, resistance, inductance, inertia, torque, torque_peak, speed, mass, price FROM motor ORDER BY id"),
    "SELECT name, ratio, radius, efficiency, inertia, torque, torque_peak, speed, mass, price FROM gear ORDER BY id",
    "SELECT name, voltage, current, current_peak, peak_time, mass, price FROM amplifier ORDER BY id" };

static lw_status add_one(lw_store *s, const lw_drive_parts *p, int kind, int i, lw_error *e)
{
    sqlite3_stmt *st;
    lw_status status = lw_store_prepare(s, insert[kind], &st, e);
    if (status != LW_OK)
        return status;
    int n = 3, code = sqlite3_bind_text(st, 1, lw_part_name(p, kind, i), -1, SQLITE_TRANSIENT);
    if (code == SQLITE_OK)
        code = sqlite3_bind_int64(st, 2, s->run);
    for (const lw_part_column *c = lw_part_columns(kind); c->name && code == SQLITE_OK; c++)
        code = sqlite3_bind_double(st, n++, *lw_part_value(p, kind, i, c));
    if (code == SQLITE_OK)
        code = sqlite3_step(st);
    return code == SQLITE_DONE ? LW_OK : lw_store_fail(s, code, "cannot be written", e);
}

lw_status lw_store_add_drive_parts(lw_store *s, const lw_drive_parts *p, const char *file, const char *command, lw_error *e)
{
    const lw_store_run run = { .action = "add", .what = file, .command = command };
    lw_status status = lw_store_begin(s, e);
    if (status != LW_OK)
        return status;
    status = lw_store_run_begin(s, &run, e);
    for (int kind = 0; kind < 3; kind++)
        for (int i = 0; status == LW_OK && i < lw_part_count(p, kind); i++)
            status = add_one(s, p, kind, i, e);
    if (status == LW_OK)
        status = lw_store_run_end(s, e);
    if (status == LW_OK)
        return lw_store_commit(s, e);
    lw_store_rollback(s);
    return status;
}

static lw_status read_kind(lw_store *s, int kind, lw_drive_parts *p, lw_error *e)
{
    sqlite3_stmt *st;
    int code;
    lw_status status = lw_store_prepare(s, choose[kind], &st, e);
    if (status != LW_OK)
        return status;
    while ((code = sqlite3_step(st)) == SQLITE_ROW) {
        const char *name = (const char *)sqlite3_column_text(st, 0);
        char *part = lw_part_add(p, kind);
        if (!part || !name)
            return lw_error_set(e, LW_E_MEMORY, "out of memory");
        int n = 1, at = lw_part_count(p, kind) - 1;
        strncpy(part, name, LW_PART_NAME - 1);
        for (const lw_part_column *c = lw_part_columns(kind); c->name; c++)
            *lw_part_value(p, kind, at, c) = sqlite3_column_double(st, n++);
    }
    return code == SQLITE_DONE ? LW_OK : lw_store_fail(s, code, "cannot be read", e);
}

lw_status lw_store_read_drive_parts(const char *path, lw_drive_parts *p, lw_error *e)
{
    const lw_store_options o = { .wait = 5 };
    lw_store *s = NULL;
    lw_status status = lw_store_open(path, &o, &s, e);
    if (status == LW_OK && lw_store_found_version(s) < 3) {
        lw_store_close(s);
        return lw_error_at(e, LW_E_NOTATION, path, 0, 0, "this catalogue holds no motors; add them by 'linkwright "
                                                         "catalogue add %s motors.csv'", path);
    }
    for (int kind = 0; status == LW_OK && kind < 3; kind++)
        status = read_kind(s, kind, p, e);
    lw_store_close(s);
    return status;
}
