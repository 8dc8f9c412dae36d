/* Read a target from CSV text (docs/notation.md, "Target"). */
#include "base/real.h"
#include "optimise/task/target_internal.h"
#include "optimise/task/target_outline_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/bytes.h"
#include "base/number.h"
#include "grammar/text/text_internal.h"

/* ---- numbers ----------------------------------------------------------------------------------- */

/* Report an error in the field of `role`. */
static lw_status bad_number(const lw_header *h, lw_target_field role, const lw_lines *l, lw_text_span field, lw_error *e)
{
    long column = (long)(field.s - l->line.s) + 1;
    int n = field.n > 40 ? 40 : (int)field.n;
    const char *name = h->name[role];
    double v;
    if (field.n == 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "the field of %s is empty; every station needs all columns", name);
    if (lw_number_is_word(field.s, field.n))
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "%s is \"%.*s\", which is no finite number; "
                           "leave the line out if nothing is wanted there", name, n, field.s);
    if (lw_number_parse(field.s, field.n, &v) == LW_E_NUMERIC)
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "%s is too large: \"%.*s\"", name, n, field.s);
    return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "%s is \"%.*s\", which is no number; units belong "
                       "into the header, as x [mm]", name, n, field.s);
}

static lw_status bad_decimal(const lw_header *h, const lw_lines *l, lw_text_span field, const char *why, lw_error *e)
{
    return lw_error_at(e, LW_E_NOTATION, h->file, l->number, (long)(field.s - l->line.s) + 1, "\"%.*s\": %s",
                       field.n > 40 ? 40 : (int)field.n, field.s, why);
}

static bool is_digit(lw_text_span s, size_t i)
{
    return i < s.n && s.s[i] >= '0' && s.s[i] <= '9';
}

/* Bytes of a separator of thousands at i: a space or an apostrophe, plain or as Unicode has them, with a digit before and three
 * after it; 0: there is none. A point or a comma is none, since it may be that of the decimals. */
static size_t thousands_mark(lw_text_span s, size_t i)
{
    static const char *const marks[] = { " ", "'", "\xc2\xa0", "\xe2\x80\xaf", "\xe2\x80\x89", "\xe2\x80\x99" };
    for (size_t k = 0; k < sizeof marks/sizeof *marks; k++) {
        size_t n = strlen(marks[k]), j = i + n;
        if (j < s.n && memcmp(s.s + i, marks[k], n) == 0)
            return i > 0 && is_digit(s, i - 1) && is_digit(s, j) && is_digit(s, j + 1) && is_digit(s, j + 2) && !is_digit(s, j + 3) ? n : 0;
    }
    return 0;
}

/* Write a number as spreadsheets do in the way that lw_number_parse reads: without a plus, with a plain minus and with
 * a decimal point, without separators of thousands. A comma is a decimal comma; commas and points do not mix. */
static lw_status plain_number(lw_header *h, const lw_lines *l, lw_text_span field, lw_text_span *plain, char *buf, size_t size, lw_error *e)
{
    static const char minus[] = "\xe2\x88\x92";                        /* U+2212 */
    const char *comma = memchr(field.s, ',', field.n), *point = memchr(field.s, '.', field.n);
    char mark = comma ? ',' : point ? '.' : 0;
    bool quoted = field.s > l->line.s && field.s[-1] == '"';
    size_t n = 0;
    *plain = field;
    if (field.n >= size)
        return LW_OK;
    if (comma && (point || memchr(comma + 1, ',', field.n - (size_t)(comma + 1 - field.s))))
        return bad_decimal(h, l, field, "leave separators of thousands out", e);
    if (comma && quoted && h->separator != ',' && field.s + field.n - comma == 4 && h->decimal != ',')
        return bad_decimal(h, l, field, "this may be a separator of thousands or a decimal comma; write the number without quotes", e);
    if (mark && h->decimal && h->decimal != mark) {
        char why[96];
        snprintf(why, sizeof why, "the file mixes decimal commas and decimal points (line %ld has a %s)",
                 h->decimal_line, mark == ',' ? "point" : "comma");
        return bad_decimal(h, l, field, why, e);
    }
    if (mark && !h->decimal) {
        h->decimal = mark;
        h->decimal_line = l->number;
    }
    bool whole = true;
    for (size_t i = 0; i < field.n; i++) {
        size_t skip = whole ? thousands_mark(field, i) : 0;
        whole = whole && field.s[i] != mark;
        if (skip > 0) {
            i += skip - 1;
        } else if (field.n - i >= 3 && memcmp(field.s + i, minus, 3) == 0) {
            buf[n++] = '-';
            i += 2;
        } else if (i > 0 || field.s[i] != '+') {
            buf[n++] = field.s[i] == ',' ? '.' : field.s[i];
        }
    }
    *plain = (lw_text_span){ buf, n };
    return LW_OK;
}

static lw_status read_number(lw_header *h, lw_target_field role, const lw_lines *l, lw_text_span field, double *out, lw_error *e)
{
    double v, most = lw_field_most(role);
    char buf[64];
    lw_text_span plain;
    lw_status s = plain_number(h, l, field, &plain, buf, sizeof buf, e);
    if (s != LW_OK)
        return s;
    if (lw_number_parse(plain.s, plain.n, &v) != LW_OK)
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
                       h->separator == ',' ? "; decimal commas need semicolons or tabs between the columns" : "");
}

static lw_status read_row(lw_header *h, const lw_lines *l, lw_target *t, size_t i, lw_error *e)
{
    size_t at = 0, start = 0;
    lw_text_span field;
    lw_status s = LW_OK;
    int n = 0;
    t->line[i] = l->number;
    for (; s == LW_OK && lw_field_next(l->line, h->separator, &at, &field); n++, start = at) {
        if (n >= h->n_column && field.n == 0)              /* spreadsheets fill rows up */
            continue;
        if (n >= h->n_column)
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

static lw_status count_rows(const lw_header *h, lw_lines l, size_t *n, lw_error *e)
{
    for (*n = 0; next_row(&l); ++*n)
        if (*n == LW_STATION_MAX)
            return lw_error_at(e, LW_E_NOTATION, h->file, l.number, 1, "this is station %d; %d are allowed, take "
                               "every tenth or so", LW_STATION_MAX + 1, LW_STATION_MAX);
    if (*n == 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, l.number, 1, "no stations follow the header; a target has one line a station");
    return LW_OK;
}

/* Refuse angles without a unit that cannot be meant in radians: beyond a whole turn, where no angle is an arc tangent that jumps, they
 * would go on by more than half a turn from one station to the next. */
static lw_status check_angles(const lw_header *h, lw_lines l, const lw_target *t, lw_error *e)
{
    for (int role = 0; role < LW_TARGET_FIELD_COUNT && !*h->angle_by; role++) {
        const double *a = lw_target_array(t, (lw_target_field)role);
        lw_target_field first = lw_field_first((lw_target_field)role);
        if (!a || (first != LW_TARGET_FIELD_THETA && first != LW_TARGET_FIELD_ANGLE) || strcmp(h->name[role], "t") == 0)
            continue;
        for (size_t i = 1; i < t->n; i++)
            if (fabs(a[i] - a[i-1]) > LW_PI*(1 + 1e-9) && fmax(fabs(a[i]), fabs(a[i-1])) > 2*LW_PI*(1 + 1e-9))
                return lw_error_at(e, LW_E_NOTATION, h->file, t->line[i], find_place(h, l, t->line[i], (lw_target_field)role),
                                   "angles have no unit, and in radians %s would go on by more than half a turn here, from %g to %g; if they are "
                                   "degrees, call the column %s_deg or add \"# units: deg\"", h->name[role], a[i-1], a[i], h->name[role]);
    }
    return LW_OK;
}

static lw_status read_rows(lw_header *h, lw_lines l, lw_target *t, lw_error *e)
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
    if ((s = check_angles(h, all, t, e)) != LW_OK)
        return s;
    s = lw_target_finish(t, h->closed, &place, &fault);
    if (s == LW_OK || s == LW_E_MEMORY)
        return s == LW_OK ? s : lw_error_set(e, s, "%s", fault.text);
    long line = t->line[place.station];
    return lw_error_at(e, LW_E_NOTATION, h->file, line, find_place(h, all, line, place.role), "%s", fault.text);
}

/* Read the line that names the columns, and one of units below it; without names, two columns are x and y. l: then before the first row. */
static lw_status read_columns(lw_header *h, lw_lines *l, lw_error *e)
{
    lw_lines before = *l;
    if (!next_row(l))
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number > 0 ? l->number : 1, 1, "nothing is in this file but "
                           "blank lines and comments; a target begins with a header such as x,y");
    if (l->line.n >= 5 && strncasecmp(l->line.s, "sep=", 4) == 0) {      /* a line for Excel */
        h->separator = l->line.s[4];
        before = *l;
        if (!next_row(l))
            return lw_error_at(e, LW_E_NOTATION, h->file, l->number, 1, "no header and no stations follow this line");
    }
    lw_lines below = *l;
    lw_text_span none = { l->line.s, 0 };
    lw_status s = lw_header_columns(h, l->line, next_row(&below) ? below.line : none, l->number, e);
    if (s == LW_OK && (!h->named || h->units_below))
        *l = h->named ? below : before;
    return s;
}

/* Say which names and units were assumed. */
static void note_assumptions(const lw_header *h, lw_target *t)
{
    bool turned = h->column[LW_TARGET_FIELD_THETA] >= 0;
    bool driven = h->column[LW_TARGET_FIELD_ANGLE] >= 0 && strcmp(h->name[LW_TARGET_FIELD_ANGLE], "t") != 0;
    if (!h->named)
        lw_target_add_note(t, "the columns have no names; they count as x, y");
    if (t->x && !*h->length_by)
        lw_target_add_note(t, "lengths have no unit: results are in that of the file, exports take metres; add \"# units: mm\"");
    if ((turned || driven) && !*h->angle_by)
        lw_target_add_note(t, "angles have no unit and count as rad; add \"# units: deg\" if they are degrees");
    if (t->x && !turned && strncasecmp(h->name[LW_TARGET_FIELD_ANGLE], "angle", 5) == 0)
        lw_target_add_note(t, "the column angle is that of the input at each point; the direction of the body is called theta");
}

lw_status lw_target_read(const char *text, size_t size, const char *file, const lw_target_options *o, lw_target *t, lw_error *e)
{
    lw_error why = { .text = "" };
    *t = (lw_target){ .n = 0 };
    if (lw_text_is_utf16(text, size)) {
        size_t n;
        char *plain = lw_text_from_utf16(text, size, &n);
        lw_status s = plain ? lw_target_read(plain, n, file, o, t, e)
                    : lw_error_set(e, LW_E_MEMORY, "out of memory for a target");
        free(plain);
        return s;
    }
    lw_lines l = lw_lines_start(text, size);
    lw_header h = { .file = file, .closed = -1, .units = lw_units_si() };
    for (int role = 0; role < LW_TARGET_FIELD_COUNT; role++)
        h.column[role] = -1;
    lw_status s = lw_text_check(text, size, file, e);
    if (s == LW_OK) {
        lw_status comments = lw_header_comments(&h, o, l, e);
        s = read_columns(&h, &l, e);               /* its fault says more: in a file that is no table '#' is no comment */
        s = s == LW_OK ? comments : s;
    }
    if (s == LW_OK)
        s = read_rows(&h, l, t, e);
    if (s == LW_OK)
        note_assumptions(&h, t);
    if (s == LW_OK && (s = lw_target_treat(t, h.closed, o, &why)) != LW_OK)
        lw_error_at(e, s, file, 0, 0, "%s", why.text);
    if (s != LW_OK)
        lw_target_free(t);
    return s;
}
