#include "grammar/model/drive_parts.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/bytes.h"
#include "base/growable_array.h"
#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "grammar/functions/formula.h"
#include "grammar/text/text_internal.h"

#define X_MOTOR(member, unit, needed) { #member, unit, needed, offsetof(lw_motor_part, member) },
#define X_GEAR(member, unit, needed) { #member, unit, needed, offsetof(lw_gear_part, member) },
#define X_AMPLIFIER(member, unit, needed) { #member, unit, needed, offsetof(lw_amplifier_part, member) },
static const lw_part_column motors[] = { LW_MOTOR_COLUMN_LIST(X_MOTOR) { NULL, NULL, 0, 0 } };
static const lw_part_column gears[] = { LW_GEAR_COLUMN_LIST(X_GEAR) { NULL, NULL, 0, 0 } };
static const lw_part_column amplifiers[] = { LW_AMPLIFIER_COLUMN_LIST(X_AMPLIFIER) { NULL, NULL, 0, 0 } };
static const lw_part_column *const columns[] = { motors, gears, amplifiers };
static const char *const kinds[] = { "motor", "gear", "amplifier" };

#define FIELD_MAX 32

const lw_part_column *lw_part_columns(int kind) { return columns[kind]; }

static size_t part_size(int kind)
{
    return kind == 0 ? sizeof(lw_motor_part) : kind == 1 ? sizeof(lw_gear_part) : sizeof(lw_amplifier_part);
}

static char *part_at(const lw_drive_parts *p, int kind, int i)
{
    return kind == 0 ? (char *)&p->motor[i] : kind == 1 ? (char *)&p->gear[i] : (char *)&p->amplifier[i];
}

int lw_part_count(const lw_drive_parts *p, int kind) { return kind == 0 ? p->n_motor : kind == 1 ? p->n_gear
                                                       : p->n_amplifier; }

const char *lw_part_name(const lw_drive_parts *p, int kind, int i) { return part_at(p, kind, i); }

double *lw_part_value(const lw_drive_parts *p, int kind, int i, const lw_part_column *c)
{
    return (double *)(void *)(part_at(p, kind, i) + c->place);
}

char *lw_part_add(lw_drive_parts *p, int kind)
{
    void **list = kind == 0 ? (void **)&p->motor : kind == 1 ? (void **)&p->gear : (void **)&p->amplifier;
    int *n = kind == 0 ? &p->n_motor : kind == 1 ? &p->n_gear : &p->n_amplifier;
    char *more = realloc(*list, (size_t)(*n + 1)*part_size(kind));
    if (!more)
        return NULL;
    *list = more;
    return memset(more + (size_t)(*n)++*part_size(kind), 0, part_size(kind));
}

void lw_drive_parts_free(lw_drive_parts *p)
{
    free(p->motor);
    free(p->gear);
    free(p->amplifier);
    *p = (lw_drive_parts){ 0 };
}

/* ---- reading ------------------------------------------------------------------------------------- */

typedef struct field { const char *text; size_t n; long column; } field;

typedef struct header { int n, kind, name; const lw_part_column *of[FIELD_MAX]; lw_amount unit[FIELD_MAX]; } header;

/* Fields without surrounding blanks and quotes.  -1: too many. */
static int split(const char *line, size_t size, field *f)
{
    int n = 0;
    for (size_t at = 0; at <= size;) {
        size_t end = at;
        while (end < size && line[end] != ',')
            end++;
        if (n == FIELD_MAX)
            return -1;
        size_t a = at, b = end;
        while (a < b && (line[a] == ' ' || line[a] == '\t' || line[a] == '"'))
            a++;
        while (b > a && (line[b - 1] == ' ' || line[b - 1] == '\t' || line[b - 1] == '"' || line[b - 1] == '\r'))
            b--;
        f[n++] = (field){ line + a, b - a, (long)a + 1 };
        at = end + 1;
    }
    return n;
}

static bool is_word(const field *f, size_t n, const char *word) { return strlen(word) == n && memcmp(f->text, word,
    n) == 0; }

/* The kind whose columns the header has. */
static int kind_of(const field *f, int n)
{
    static const char *const signs[] = { "torque_constant", "ratio", "voltage" };
    for (int kind = 0; kind < 3; kind++)
        for (int i = 0; i < n; i++)
            if (f[i].n >= strlen(signs[kind]) && memcmp(f[i].text, signs[kind], strlen(signs[kind])) == 0)
                return kind;
    return -1;
}

static lw_status read_header(const field *f, int n, const char *file, long line, header *h, lw_error *e)
{
    *h = (header){ .n = n, .kind = kind_of(f, n), .name = -1 };
    if (h->kind < 0)
        return lw_error_at(e, LW_E_NOTATION, file, line, 1, "the columns are those of no table of parts: motors have a "
                           "\"torque_constant\", gears a \"ratio\", amplifiers a \"voltage\"");
    for (int i = 0; i < n; i++) {
        const char *open = memchr(f[i].text, '[', f[i].n);
        size_t word = open ? (size_t)(open - f[i].text) : f[i].n;
        while (word > 0 && f[i].text[word - 1] == ' ')
            word--;
        if (is_word(&f[i], word, "name")) {
            h->name = i;
            continue;
        }
        const char *names[FIELD_MAX];
        int m = 0;
        for (const lw_part_column *c = columns[h->kind]; c->name; c++) {
            names[m++] = c->name;
            if (is_word(&f[i], word, c->name))
                h->of[i] = c;
        }
        char text[64];
        snprintf(text, sizeof text, "%.*s", (int)(word < 63 ? word : 63), f[i].text);
        const char *near = lw_suggest(text, names, m);
        if (!h->of[i] && word > 2 && memcmp(f[i].text, "x-", 2) == 0)
            continue;
        if (!h->of[i])
            return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column,
                               "there is no column \"%s\" of a %s%s%s%s; columns of your "
                               "own begin with x-", text, kinds[h->kind], LW_DID_YOU_MEAN(near));
        lw_amount si;
        lw_error inner = { 0 };
        lw_unit_parse(h->of[i]->unit, strlen(h->of[i]->unit), &si, NULL);
        h->unit[i] = si;
        if (open && f[i].text[f[i].n - 1] == ']'
            && lw_unit_parse(open + 1, f[i].n - (size_t)(open - f[i].text) - 2, &h->unit[i], &inner) != LW_OK)
            return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column + (open - f[i].text) + 1, "%s", inner.text);
        if (open && f[i].text[f[i].n - 1] != ']')
            return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column, "this unit has no ]");
        if (!lw_dimension_fits(h->unit[i].dimension, si.dimension))
            return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column, "%s needs a unit like [%s]", h->of[i]->name, h->of[i]->unit);
        for (int k = 0; k < i; k++)
            if (h->of[k] == h->of[i])
                return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column, "the column %s is given twice", h->of[i]->name);
    }
    if (h->name < 0)
        return lw_error_at(e, LW_E_NOTATION, file, line, 1, "the column \"name\" is missing");
    for (const lw_part_column *c = columns[h->kind]; c->name; c++) {
        bool there = !c->needed;
        for (int i = 0; i < n; i++)
            there = there || h->of[i] == c;
        if (!there)
            return lw_error_at(e, LW_E_NOTATION, file, line, 1, "the column \"%s\" [%s] of a %s is missing", c->name,
                               c->unit,
                               kinds[h->kind]);
    }
    return LW_OK;
}

/* Of a part, in SI: products and quotients of several of them are finite. */
#define LEAST_VALUE    1e-30
#define GREATEST_VALUE 1e30

static lw_status read_part(const header *h, const field *f, int n, const char *file, long line, lw_drive_parts *p, lw_error *e)
{
    char *part = lw_part_add(p, h->kind);
    if (!part)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    int at = lw_part_count(p, h->kind) - 1;
    if (n != h->n)
        return lw_error_at(e, LW_E_NOTATION, file, line, 1, "this line has %d fields, the header has %d", n, h->n);
    if (f[h->name].n == 0 || f[h->name].n >= LW_PART_NAME)
        return lw_error_at(e, LW_E_NOTATION, file, line, f[h->name].column, "a name of 1 to %d bytes is expected", LW_PART_NAME - 1);
    memcpy(part, f[h->name].text, f[h->name].n);
    if (lw_text_has_control(part))
        return lw_error_at(e, LW_E_NOTATION, file, line, f[h->name].column, "this name holds a control character");
    for (int i = 0; i < n; i++) {
        double x = 0, v;
        if (!h->of[i])
            continue;
        if (f[i].n == 0 && !h->of[i]->needed)
            continue;
        if (lw_number_parse(f[i].text, f[i].n, &x) != LW_OK || x < 0 || (x == 0 && h->of[i]->needed))
            return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column, "%s: a number %s 0 is expected",
                               h->of[i]->name,
                               h->of[i]->needed ? "above" : "of at least");
        lw_amount a = h->unit[i];
        a.number = x;
        v = lw_amount_si(&a);
        if (x != 0 && v < LEAST_VALUE)
            return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column, "%s is too small", h->of[i]->name);
        if (!(v <= GREATEST_VALUE) || (h->kind == 1 && strcmp(h->of[i]->name, "efficiency") == 0 && v > 1))
            return lw_error_at(e, LW_E_NOTATION, file, line, f[i].column, "%s is too large", h->of[i]->name);
        *lw_part_value(p, h->kind, at, h->of[i]) = v;
    }
    return LW_OK;
}

/* A part and the line of the table that it stands in; 0: in an earlier table. */
typedef struct named { const char *name; long line; } named;

static int by_name(const void *a, const void *b)
{
    const named *x = a, *y = b;
    int order = strcmp(x->name, y->name);
    return order ? order : x->line < y->line ? -1 : x->line > y->line;
}

/* No two parts of a kind have one name.  line: of each part after the first `before`. */
static lw_status check_names(const lw_drive_parts *p, const header *h, int before, const long *line, const char *file, lw_error *e)
{
    int n = lw_part_count(p, h->kind);
    const named *first = NULL;
    named *all = malloc((size_t)n*sizeof *all);
    if (!all)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < n; i++)
        all[i] = (named){ lw_part_name(p, h->kind, i), i < before ? 0 : line[i - before] };
    qsort(all, (size_t)n, sizeof *all, by_name);
    for (int i = 1; i < n; i++)
        if (strcmp(all[i - 1].name, all[i].name) == 0 && all[i].line > 0 && (!first || all[i].line < first->line))
            first = &all[i];
    lw_status s = first ? lw_error_at(e, LW_E_NOTATION, file, first->line, 1, "the name \"%s\" is given twice", first->name) : LW_OK;
    free(all);
    return s;
}

lw_status lw_drive_parts_read(const char *text, size_t size, const char *file, lw_drive_parts *p, lw_error *e)
{
    header h = { .n = 0 };
    field f[FIELD_MAX];
    int before[3] = { p->n_motor, p->n_gear, p->n_amplifier };
    int n_part = 0, room = 0;
    long line = 0, *lines = NULL;                       /* of each part */
    lw_status s = lw_text_check(text, size, file, e);
    size_t at = 0;
    while (at < size && s == LW_OK) {
        const char *newline = memchr(text + at, '\n', size - at);
        size_t end = newline ? (size_t)(newline - text) : size, first = at;
        line++;
        while (first < end && (text[first] == ' ' || text[first] == '\t' || text[first] == '\r'))
            first++;
        if (first < end && text[first] != '#') {
            int n = split(text + at, end - at, f);
            if (n < 0)
                s = lw_error_at(e, LW_E_NOTATION, file, line, 1, "more than %d columns", FIELD_MAX);
            else if (h.n == 0)
                s = read_header(f, n, file, line, &h, e);
            else {
                long *more = lw_array_grow(lines, n_part, &room, sizeof *lines);
                if (!more) {
                    s = lw_error_set(e, LW_E_MEMORY, "out of memory");
                    break;
                }
                lines = more;
                lines[n_part++] = line;
                s = read_part(&h, f, n, file, line, p, e);
            }
        }
        at = end + 1;
    }
    if (s == LW_OK && n_part == 0)
        s = lw_error_at(e, LW_E_NOTATION, file, line ? line : 1, 1, "this table has no part");
    else if (s == LW_OK)
        s = check_names(p, &h, before[h.kind], lines, file, e);
    free(lines);
    if (s != LW_OK) {
        p->n_motor = before[0];
        p->n_gear = before[1];
        p->n_amplifier = before[2];
    }
    return s;
}

bool lw_drive_parts_is(const char *text, size_t size)
{
    field f[FIELD_MAX];
    for (size_t at = 0; at < size;) {
        const char *newline = memchr(text + at, '\n', size - at);
        size_t end = newline ? (size_t)(newline - text) : size;
        if (end > at && text[at] != '#' && text[at] != '\r') {
            int n = split(text + at, end - at, f);
            for (int i = 0; i < n; i++)
                if (is_word(&f[i], f[i].n, "name"))
                    return kind_of(f, n) >= 0;
            return false;
        }
        at = end + 1;
    }
    return false;
}
