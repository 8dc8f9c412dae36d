/* Read a target from CSV text (docs/notation.md, "Target"). */
#include "optimise/task/target_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/number.h"

/* ---- numbers ----------------------------------------------------------------------------------- */

/* Report an error in the field of `role`. */
static lw_status bad_number(const lw_header *h, lw_target_field role, const lw_lines *l, lw_text_span field,
                            lw_error *e)
{
    long column = (long)(field.s - l->line.s) + 1;
    int n = field.n > 40 ? 40 : (int)field.n;
    const char *name = h->name[role];
    double v;
    if (field.n == 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "the field of %s is empty; every station "
                           "needs all columns", name);
    if (lw_number_is_word(field.s, field.n))
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "%s is \"%.*s\", which is no finite number; "
                           "leave the line out if nothing is wanted there", name, n, field.s);
    if (lw_number_parse(field.s, field.n, &v) == LW_E_NUMERIC)
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "%s is too large: \"%.*s\"", name, n,
                           field.s);
    const char *hint = h->separator != ',' && memchr(field.s, ',', field.n)
                     ? "; write decimals with a point" : "";
    return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "%s is \"%.*s\", which is no number%s", name, n,
                       field.s, hint);
}

static lw_status read_number(const lw_header *h, lw_target_field role, const lw_lines *l, lw_text_span field,
                             double *out, lw_error *e)
{
    double v, most = lw_field_most(role);
    if (lw_number_parse(field.s, field.n, &v) != LW_OK)
        return bad_number(h, role, l, field, e);
    *out = v*h->factor[role];
    if (fabs(*out) <= most)
        return LW_OK;
    return lw_error_at(e, LW_E_NOTATION, h->file, l->number, (long)(field.s - l->line.s) + 1,
                       "%s is too large: its size is %g at most (in SI)", h->name[role], most);
}

/* ---- rows -------------------------------------------------------------------------------------- */

static lw_status wrong_count(const lw_header *h, const lw_lines *l, int n, size_t at, lw_error *e)
{
    if (n < h->n_column)
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, (long)l->line.n + 1, "this line has %d of the %d "
                           "fields that the header names; is one missing, or are they separated otherwise?", n,
                           h->n_column);
    return lw_error_at(e, LW_E_NOTATION, h->file, l->number, (long)at + 1, "this line has more than the %d fields "
                       "that the header names%s", h->n_column,
                       h->separator == ',' ? "; write decimals with a point" : "");
}

static lw_status read_row(const lw_header *h, const lw_lines *l, lw_target *t, size_t i, lw_error *e)
{
    size_t at = 0, start = 0;
    lw_text_span field;
    lw_status s = LW_OK;
    int n = 0;
    t->line[i] = l->number;
    for (; s == LW_OK && lw_field_next(l->line, h->separator, &at, &field); n++, start = at) {
        if (n == h->n_column)
            return wrong_count(h, l, n + 1, start, e);
        lw_target_field role = h->role[n];
        s = read_number(h, role, l, field, &lw_target_array(t, role)[i], e);
    }
    return s == LW_OK && n < h->n_column ? wrong_count(h, l, n, at, e) : s;
}

/* Byte at which the number of a role stands in the line of a station, for errors found later. */
static long find_place(const lw_header *h, lw_lines l, long line, lw_target_field role)
{
    size_t at = 0;
    lw_text_span field;
    while (lw_lines_next(&l) && l.number < line)
        ;
    for (int n = 0; lw_field_next(l.line, h->separator, &at, &field); n++)
        if (n == h->column[role])
            return (long)(field.s - l.line.s) + 1;
    return 1;
}

/* ---- the whole --------------------------------------------------------------------------------- */

static bool next_row(lw_lines *l)
{
    while (lw_lines_next(l))
        if (!lw_span_blank(l->line))
            return true;
    return false;
}

static lw_status refuse_foreign(const char *text, size_t size, const char *file, lw_error *e)
{
    if (size >= 2 && (memcmp(text, "\xff\xfe", 2) == 0 || memcmp(text, "\xfe\xff", 2) == 0))
        return lw_error_at(e, LW_E_NOTATION, file, 1, 1, "this text is in UTF-16; save it as UTF-8 or ASCII");
    return LW_OK;
}

static lw_status count_rows(const lw_header *h, lw_lines l, size_t *n, lw_error *e)
{
    for (*n = 0; next_row(&l); ++*n)
        if (*n == LW_STATION_MAX)
            return lw_error_at(e, LW_E_NOTATION, h->file, l.number, 1, "this is station %d; %d are allowed, take "
                               "every tenth or so", LW_STATION_MAX + 1, LW_STATION_MAX);
    if (*n == 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, l.number, 1, "no stations follow the header; a target has "
                           "one line a station");
    return LW_OK;
}

static lw_status read_rows(const lw_header *h, lw_lines l, lw_target *t, lw_error *e)
{
    bool has[LW_TARGET_FIELD_COUNT];
    size_t n;
    lw_target_place place;
    lw_lines all = lw_lines_start(l.text, l.size);
    lw_error fault;
    lw_status s = count_rows(h, l, &n, e);
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++)
        has[role] = h->column[role] >= 0;
    if (s == LW_OK)
        s = lw_target_allocate(t, n, has, e);
    for (size_t i = 0; s == LW_OK && i < n && next_row(&l); i++)
        s = read_row(h, &l, t, i, e);
    if (s != LW_OK)
        return s;
    t->units = h->units;
    s = lw_target_finish(t, h->closed, &place, &fault);
    if (s == LW_OK || s == LW_E_MEMORY)
        return s == LW_OK ? s : lw_error_set(e, s, "%s", fault.text);
    long line = t->line[place.station];
    return lw_error_at(e, LW_E_NOTATION, h->file, line, find_place(h, all, line, place.role), "%s", fault.text);
}

lw_status lw_target_read(const char *text, size_t size, const char *file, const lw_target_options *o,
                         lw_target *t, lw_error *e)
{
    lw_lines l = lw_lines_start(text, size);
    lw_header h = { .file = file, .closed = -1, .units = lw_units_si() };
    lw_status s = refuse_foreign(text, size, file, e);
    *t = (lw_target){ .n = 0 };
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++)
        h.column[role] = -1;
    if (s == LW_OK)
        s = lw_header_comments(&h, o, l, e);
    if (s == LW_OK && !next_row(&l))
        s = lw_error_at(e, LW_E_NOTATION, file, l.number > 0 ? l.number : 1, 1, "nothing is in this file but "
                        "blank lines and comments; a target begins with a header such as x,y");
    if (s == LW_OK)
        s = lw_header_columns(&h, l.line, l.number, e);
    if (s == LW_OK)
        s = read_rows(&h, l, t, e);
    if (s != LW_OK)
        lw_target_free(t);
    return s;
}
