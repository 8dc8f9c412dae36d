/* Read the comments and the header line of a target: columns, units, closed or not. */
#include "optimise/task/target_internal.h"

#include <stdio.h>
#include <string.h>

#include "base/number.h"
#include "base/suggest.h"

#define COUNT(a) ((int)(sizeof (a)/sizeof *(a)))

static const char *const unit_names[] = { "m", "mm", "cm", "km", "um", "in", "ft", "rad", "deg", "turn" };

/* Names of columns.  A length takes a length as unit suffix, an angle an angle. */
enum { COL_X, COL_Y, COL_THETA, COL_ANGLE, COL_THETA_IN, COL_T, COL_WEIGHT };
static const struct { const char *name; char kind; } columns[] = {
    [COL_X] = { "x", 'l' }, [COL_Y] = { "y", 'l' }, [COL_THETA] = { "theta", 'a' },
    [COL_ANGLE] = { "angle", 'a' }, [COL_THETA_IN] = { "theta_in", 'a' }, [COL_T] = { "t", '1' },
    [COL_WEIGHT] = { "weight", '1' },
};
#define COLUMN_COUNT COUNT(columns)
#define NUMBERED_COUNT (COLUMN_COUNT*(1 + LW_ALSO_MAX))      /* further points: x2 is COLUMN_COUNT + COL_X */

static const char *quote(lw_text_span s, char buf[48])
{
    snprintf(buf, 48, "\"%.*s%s\"", s.n > 40 ? 40 : (int)s.n, s.s, s.n > 40 ? "..." : "");
    return buf;
}

/* ---- units ------------------------------------------------------------------------------------- */

/* Take a unit for lengths or angles. who: where the unit is given, for the message when another place gives a different
 * unit. */
static lw_status take_unit(lw_header *h, const char *unit, const char *who, long line, long column, lw_error *e)
{
    lw_units u = h->units;
    bool length = lw_units_set_length(&u, unit);
    if (!length)
        lw_units_set_angle(&u, unit);
    char *by = length ? h->length_by : h->angle_by;
    const char *before = length ? h->units.length : h->units.angle;
    if (*by && strcmp(before, unit) != 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, column, "units are mixed: %s says %s, but %s said %s; "
                           "convert the numbers so that one unit serves the whole file", who, unit, by, before);
    h->units = u;
    if (!*by)
        snprintf(by, sizeof h->length_by, "%s", who);
    return LW_OK;
}

static bool next_word(lw_text_span *rest, lw_text_span *word)
{
    size_t i = 0, n = 0;
    while (i < rest->n && strchr(" \t,;", rest->s[i]) && rest->s[i])
        i++;
    while (i + n < rest->n && !(strchr(" \t,;", rest->s[i+n]) && rest->s[i+n]))
        n++;
    *word = (lw_text_span){ rest->s + i, n };
    *rest = (lw_text_span){ rest->s + i + n, rest->n - i - n };
    return n > 0;
}

static const char *find_unit(lw_text_span word)
{
    static const struct { const char *word, *unit; } other[] = {
        { "degree", "deg" }, { "degrees", "deg" }, { "\xc2\xb0", "deg" }, { "\xb0", "deg" },
        { "inch", "in" }, { "inches", "in" }, { "\xc2\xb5m", "um" }, { "\xce\xbcm", "um" }, { "\xb5m", "um" }, { "metre", "m" },
        { "meter", "m" }, { "millimetre", "mm" }, { "millimeter", "mm" }, { "radian", "rad" }, { "radians", "rad" },
        { "turns", "turn" }
    };
    for (int i = 0; i < COUNT(other); i++)
        if (lw_span_is(word, other[i].word))
            return other[i].unit;
    for (int i = 0; i < COUNT(unit_names); i++)
        if (lw_span_is(word, unit_names[i]))
            return unit_names[i];
    return NULL;
}

/* Read "mm deg" after "# units:". */
static lw_status read_units(lw_header *h, const lw_lines *l, lw_text_span value, lw_error *e)
{
    const char *start = l->line.s;
    lw_text_span word;
    lw_status s = LW_OK;
    while (s == LW_OK && next_word(&value, &word)) {
        char text[48];
        const char *unit = find_unit(word);
        long column = (long)(word.s - start) + 1;
        if (!unit)
            return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "unknown unit %s; known are m, mm, "
                               "cm, km, um, in, ft for lengths and rad, deg, turn for angles", quote(word, text));
        s = take_unit(h, unit, "a comment", l->number, column, e);
    }
    return s;
}

/* ---- comments ---------------------------------------------------------------------------------- */

/* Value of a comment "key: value". */
static bool has_key(lw_text_span comment, const char *key, lw_text_span *value)
{
    const char *colon = comment.s ? memchr(comment.s, ':', comment.n) : NULL;
    if (!colon || !lw_span_is(lw_span_trim((lw_text_span){ comment.s, (size_t)(colon - comment.s) }), key))
        return false;
    *value = lw_span_trim((lw_text_span){ colon + 1, comment.n - (size_t)(colon + 1 - comment.s) });
    return true;
}

static lw_status read_closed(lw_header *h, const lw_lines *l, lw_text_span value, lw_error *e)
{
    lw_text_span word;
    char text[48];
    int closed = -1;
    long column = (long)(value.s - l->line.s) + 1;
    next_word(&value, &word);
    if (lw_span_is(word, "yes") || lw_span_is(word, "true") || lw_span_is(word, "1"))
        closed = 1;
    else if (lw_span_is(word, "no") || lw_span_is(word, "false") || lw_span_is(word, "0"))
        closed = 0;
    else
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "\"closed\" is yes or no, not %s", quote(word, text));
    if (h->closed >= 0 && h->closed != closed)
        return lw_error_at(e, LW_E_NOTATION, h->file, l->number, column, "the file says both \"closed: yes\" and \"closed: no\"; keep one");
    h->closed = closed;
    return LW_OK;
}

/* Apply the options of the command line: they override comments, but not the names of columns. */
static lw_status take_options(lw_header *h, const lw_target_options *o, lw_error *e)
{
    if (o->closed >= 0)
        h->closed = o->closed;
    if (o->length_unit) {
        if (!lw_units_set_length(&h->units, o->length_unit))
            return lw_error_set(e, LW_E_ARG, "unknown length unit \"%.20s\"; known are m, mm, cm, km, um, in, ft", o->length_unit);
        strcpy(h->length_by, "the command line");
    }
    if (o->angle_unit) {
        if (!lw_units_set_angle(&h->units, o->angle_unit))
            return lw_error_set(e, LW_E_ARG, "unknown angle unit \"%.20s\"; known are rad, deg, turn", o->angle_unit);
        strcpy(h->angle_by, "the command line");
    }
    return LW_OK;
}

lw_status lw_header_comments(lw_header *h, const lw_target_options *o, lw_lines l, lw_error *e)
{
    lw_status s = LW_OK;
    lw_text_span value;
    while (s == LW_OK && lw_lines_next(&l))
        if (has_key(l.comment, "closed", &value))
            s = read_closed(h, &l, value, e);
        else if (has_key(l.comment, "units", &value) || has_key(l.comment, "unit", &value))
            s = read_units(h, &l, value, e);
    return s == LW_OK && o ? take_options(h, o, e) : s;
}

/* ---- columns ----------------------------------------------------------------------------------- */

typedef struct seen {
    int     at[NUMBERED_COUNT];          /* column of the file, -1: missing */
    long    place[NUMBERED_COUNT];       /* its byte in the header line, from 1 */
    lw_text_span name[NUMBERED_COUNT];
    const char *below[NUMBERED_COUNT];   /* unit in a line of units below the header, by column of the file; NULL: none */
} seen;

/* Read a line of units below the names, such as mm;mm;[deg], where - or nothing is no unit.  False: it is no such line. */
static bool read_units_below(const lw_header *h, lw_text_span line, const char *unit[NUMBERED_COUNT])
{
    size_t at = 0;
    lw_text_span field;
    bool any = false;
    for (int i = 0; i < NUMBERED_COUNT && lw_field_next(line, h->separator, &at, &field); i++) {
        bool bracket = field.n > 2 && (field.s[0] == '[' || field.s[0] == '(');
        unit[i] = find_unit(bracket ? lw_span_trim((lw_text_span){ field.s + 1, field.n - 2 }) : field);
        if (!unit[i] && field.n > 0 && !lw_span_is(field, "-"))
            return false;
        any = any || unit[i];
    }
    return any;
}

static bool of_a_point(int column)
{
    return column == COL_X || column == COL_Y || column == COL_THETA || column == COL_WEIGHT;
}

/* Find a column such as "theta", or "theta2" for the second point. */
static int find_column(lw_text_span name)
{
    int number = name.n > 1 && name.s[name.n - 1] > '0' && name.s[name.n - 1] <= '1' + LW_ALSO_MAX
               ? name.s[name.n - 1] - '0' : 0;
    lw_text_span bare = { name.s, name.n - (number > 0) };
    for (int i = 0; i < COLUMN_COUNT; i++)
        if (number > 0 ? of_a_point(i) && lw_span_is(bare, columns[i].name) : lw_span_is(name, columns[i].name))
            return number > 0 ? i + (number - 1)*COLUMN_COUNT : i;
    return -1;
}

/* Split a unit off a name: "x_mm", "x [mm]", "x (mm)", "x/mm" and "x mm" are x in mm; "theta_in" is a name by itself, not an
 * angle in inches. *fault: the text in brackets, if it is no unit. */
static int split_name(lw_text_span name, const char **unit, lw_text_span *fault)
{
    int found = find_column(name);
    *unit = NULL;
    *fault = (lw_text_span){ NULL, 0 };
    for (size_t i = name.n; found < 0 && i-- > 1; ) {
        char c = name.s[i], last = name.s[name.n - 1];
        if (c != '_' && c != '/' && !(c == ' ' && last != ']' && last != ')') && !(c == '[' && last == ']') && !(c == '(' && last == ')'))
            continue;
        bool bracket = c == '[' || c == '(';
        lw_text_span word = lw_span_trim((lw_text_span){ name.s + i + 1, name.n - i - 1 - bracket });
        int column = find_column(lw_span_trim((lw_text_span){ name.s, i }));
        *unit = find_unit(word);
        if (column >= 0 && !*unit && bracket)
            *fault = word;
        found = *unit || word.n == 0 ? column : -1;
        break;
    }
    return found;
}

static lw_status unknown_column(const lw_header *h, lw_text_span name, long line, long place, lw_error *e)
{
    char text[48], word[32];
    double number;
    if (name.n == 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, place, "this column has no name");
    if (lw_number_parse(name.s, name.n, &number) == LW_OK)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, place, "the first line holds numbers; only two columns "
                           "need no names (x and y), put a line such as x,y,angle before more");
    snprintf(word, sizeof word, "%.*s", name.n < 31 ? (int)name.n : 31, name.s);
    const char *near = LW_SUGGEST(word, columns, COLUMN_COUNT, name);
    return lw_error_at(e, LW_E_NOTATION, h->file, line, place, "unknown column %s%s%s%s; columns are x, y, theta, "
                       "angle or t, weight, lengths and angles also with their unit (x_mm, angle_deg); those of "
                       "further points have their number, x2 .. x%d, theta2, weight2", quote(name, text),
                       near ? ", did you mean \"" : "", near ? near : "", near ? "\"?" : "", 1 + LW_ALSO_MAX);
}

static lw_status take_column(lw_header *h, seen *f, lw_text_span name, long line, long place, lw_error *e)
{
    const char *unit;
    char text[48];
    lw_text_span fault;
    int c = split_name(name, &unit, &fault);
    if (c < 0 && fault.s)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, place + (long)(fault.s - name.s),
                           "unknown unit %s; known are "
                           "m, mm, cm, km, um, in, ft for lengths and rad, deg, turn for angles; t counts turns of the "
                           "input, 0 to 1 is one turn", quote(fault, text));
    if (c < 0)
        return unknown_column(h, name, line, place, e);
    if (f->at[c] >= 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, place, "column %s is there twice, here and as column "
                           "%d; drop one", quote(name, text), f->at[c] + 1);
    f->at[c] = h->n_column;
    f->place[c] = place;
    f->name[c] = name;
    const char *given[] = { unit, f->below[h->n_column] };
    for (int i = 0; i < COUNT(given); i++) {
        if (!given[i])
            continue;
        lw_units scratch = lw_units_si();
        bool length = lw_units_set_length(&scratch, given[i]);
        if (columns[c % COLUMN_COUNT].kind != (length ? 'l' : 'a'))
            return lw_error_at(e, LW_E_NOTATION, h->file, line, place, "column %s is no %s, so %s cannot be its unit",
                               quote(name, text), length ? "length" : "angle", given[i]);
        lw_status s = take_unit(h, given[i], quote(name, text), line, place, e);
        if (s != LW_OK)
            return s;
    }
    return LW_OK;
}

/* ---- what the columns mean --------------------------------------------------------------------- */

static lw_status clash(const lw_header *h, const seen *f, int a, int b, long line, lw_error *e)
{
    int later = f->place[a] > f->place[b] ? a : b;
    return lw_error_at(e, LW_E_NOTATION, h->file, line, f->place[later], "columns %s and %s both give the %s angle; "
                       "drop one, or call the tool angle theta and the input angle", columns[a].name,
                       columns[b].name, a == COL_THETA ? "tool" : "input");
}

static void assign(lw_header *h, const seen *f, lw_target_field role, int c)
{
    h->column[role] = f->at[c];
    h->role[f->at[c]] = role;
    snprintf(h->name[role], sizeof h->name[role], "%.*s", (int)f->name[c].n, f->name[c].s);
    char kind = columns[c % COLUMN_COUNT].kind;
    h->factor[role] = kind == 'l' ? h->units.metre : kind == 'a' ? h->units.radian : 1;
}

/* Decide which of angle, theta, theta_in, t is the input and which the tool: `angle` is the input unless theta_in is
 * there. */
static lw_status assign_angles(lw_header *h, const seen *f, long line, lw_error *e)
{
    const int *at = f->at;
    bool published = at[COL_THETA_IN] >= 0;
    int tool = published && at[COL_ANGLE] >= 0 ? COL_ANGLE : COL_THETA;
    int input = published ? COL_THETA_IN : at[COL_ANGLE] >= 0 ? COL_ANGLE : COL_T;
    if (published && at[COL_THETA] >= 0 && at[COL_ANGLE] >= 0)
        return clash(h, f, COL_THETA, COL_ANGLE, line, e);
    if (input != COL_T && at[COL_T] >= 0)
        return clash(h, f, input, COL_T, line, e);
    if (at[tool] >= 0)
        assign(h, f, LW_TARGET_FIELD_THETA, tool);
    if (at[input] >= 0)
        assign(h, f, LW_TARGET_FIELD_ANGLE, input);
    if (input == COL_T)
        h->factor[LW_TARGET_FIELD_ANGLE] = 2*LW_PI;
    return LW_OK;
}

static lw_status check_complete(const lw_header *h, long line, lw_error *e)
{
    const int *c = h->column;
    const char *missing = NULL;
    if (c[LW_TARGET_FIELD_X] >= 0 || c[LW_TARGET_FIELD_Y] >= 0)
        missing = c[LW_TARGET_FIELD_X] < 0 ? "x" : c[LW_TARGET_FIELD_Y] < 0 ? "y" : NULL;
    else if (c[LW_TARGET_FIELD_THETA] < 0 && c[LW_TARGET_FIELD_ANGLE] < 0)
        missing = "x";
    else
        missing = c[LW_TARGET_FIELD_THETA] < 0 ? "theta" : c[LW_TARGET_FIELD_ANGLE] < 0 ? "angle" : NULL;
    if (!missing)
        return LW_OK;
    return lw_error_at(e, LW_E_NOTATION, h->file, line, 1, "column \"%s\" is missing; a path has x and y, a function "
                       "angle (input) and theta (output)", missing);
}

/* Assign the columns of a further point (counted from 0): x and y, or theta, or all three; they follow those of the
 * points before it. */
static lw_status assign_also(lw_header *h, const seen *f, int point, long line, lw_error *e)
{
    static const struct { int column; lw_target_field role; } own[] = {
        { COL_X, LW_TARGET_FIELD_X }, { COL_Y, LW_TARGET_FIELD_Y },
        { COL_THETA, LW_TARGET_FIELD_THETA }, { COL_WEIGHT, LW_TARGET_FIELD_WEIGHT }
    };
    int base = (point + 1)*COLUMN_COUNT, number = point + 2, any = -1;
    for (int i = 0; i < COUNT(own); i++)
        if (f->at[base + own[i].column] >= 0) {
            assign(h, f, lw_field_also(own[i].role, point), base + own[i].column);
            any = base + own[i].column;
        }
    const int *c = h->column + lw_field_also(LW_TARGET_FIELD_X, point);
    if (any < 0)
        return LW_OK;
    if ((c[0] < 0) != (c[1] < 0))
        return lw_error_at(e, LW_E_NOTATION, h->file, line, f->place[any], "column \"%c%d\" is missing; the place of a "
                           "point needs x and y", c[0] < 0 ? 'x' : 'y', number);
    if (c[0] < 0 && c[2] < 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, f->place[any], "there is a weight%d but no x%d and y%d or "
                           "theta%d to weigh", number, number, number, number);
    const int *before = c - 4;
    if (point > 0 && before[0] < 0 && before[2] < 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, f->place[any], "there are columns of point %d but none of "
                           "point %d; points are numbered without gaps", number, number - 1);
    if (c[0] >= 0 && h->column[LW_TARGET_FIELD_X] < 0)
        return lw_error_at(e, LW_E_NOTATION, h->file, line, f->place[base + COL_X], "there are x%d and y%d but no x "
                           "and y; let the point with a path be the first, and its output angle theta2", number,
                           number);
    return LW_OK;
}

/* Is a line two numbers? They may have decimal commas, unless commas separate them. *number: it begins with one. */
static bool is_pair(lw_text_span line, char separator, bool *number)
{
    size_t at = 0;
    int n = 0;
    lw_text_span f;
    bool all = true;
    *number = false;
    for (; lw_field_next(line, separator, &at, &f); n += f.n > 0) {
        char text[64];
        double v;
        size_t skip = f.n > 0 && f.s[0] == '+';
        if (f.n == 0)
            continue;
        snprintf(text, sizeof text, "%.*s", f.n > 63 ? 63 : (int)f.n, f.s);
        char *comma = strchr(text, ',');
        if (comma)
            *comma = '.';
        bool is_number = lw_number_parse(text + skip, strlen(text + skip), &v) == LW_OK;
        all = all && is_number;
        *number = *number || (n == 0 && is_number);
    }
    return all && n == 2;
}

/* Find the separator of columns. In a line of names a comma is one; in numbers, it may be a decimal comma. */
static lw_status find_separator(lw_header *h, lw_text_span line, long number, lw_error *e)
{
    line = lw_span_trim(line);
    bool comma = memchr(line.s, ',', line.n), semicolon = memchr(line.s, ';', line.n), numbers;
    char other = semicolon ? ';' : memchr(line.s, '\t', line.n) ? '\t' : ' ';
    h->named = true;
    if (!h->separator)
        h->separator = comma ? ',' : other;
    if (is_pair(line, h->separator, &numbers)) {
        h->named = false;
        return LW_OK;
    }
    if (comma && is_pair(line, other, &numbers)) {
        h->separator = other;
        h->named = false;
    } else if (comma && semicolon && h->separator == ',') {
        return lw_error_at(e, LW_E_NOTATION, h->file, number, 1, "the header has commas and semicolons; separate columns by one of them");
    }
    return LW_OK;
}

/* Read the next name; a unit in brackets behind a blank belongs to it. */
static bool next_name(const lw_header *h, lw_text_span line, size_t *at, lw_text_span *name)
{
    size_t ahead;
    lw_text_span unit;
    if (!lw_field_next(line, h->separator, at, name))
        return false;
    ahead = *at;
    if (h->separator == ' ' && lw_field_next(line, ' ', &ahead, &unit) && (unit.s[0] == '[' || unit.s[0] == '(')) {
        name->n = (size_t)(unit.s + unit.n - name->s);
        *at = ahead;
    }
    return true;
}

/* Is no word of the line the name of a column or near one?  Then the file is no table of stations, but prose or code. */
static bool names_nothing(const lw_header *h, lw_text_span line)
{
    const char *unit;
    size_t at = 0;
    char word[32];
    double number;
    lw_text_span name, fault;
    while (next_name(h, line, &at, &name)) {
        snprintf(word, sizeof word, "%.*s", name.n < 31 ? (int)name.n : 31, name.s);
        if (split_name(name, &unit, &fault) >= 0 || LW_SUGGEST(word, columns, COLUMN_COUNT, name)
            || lw_number_parse(name.s, name.n, &number) == LW_OK)
            return false;
    }
    return true;
}

lw_status lw_header_columns(lw_header *h, lw_text_span line, lw_text_span below, long number, lw_error *e)
{
    seen f = { .below = { NULL } };
    size_t at = 0;
    static const lw_text_span pair[] = { { "x", 1 }, { "y", 1 } };
    lw_text_span name;
    lw_status s = find_separator(h, line, number, e);
    if (s == LW_OK && h->named && names_nothing(h, line))
        return lw_error_at(e, LW_E_NOTATION, h->file, number, 1, "this is no target: its first line names no column; a "
                           "target is a table (CSV) whose first line names its columns, as x,y or angle,theta, or a drawing (SVG, DXF)");
    for (int i = 0; i < NUMBERED_COUNT; i++)
        f.at[i] = -1;
    h->n_column = 0;
    h->units_below = s == LW_OK && h->named && read_units_below(h, below, f.below);
    if (!h->units_below)
        memset(f.below, 0, sizeof f.below);
    if (s == LW_OK && !h->named)
        for (; s == LW_OK && h->n_column < 2; h->n_column++)
            s = take_column(h, &f, pair[h->n_column], number, 1, e);
    else
        for (; s == LW_OK && next_name(h, line, &at, &name); h->n_column++) {
            if (name.n == 0 && lw_span_blank((lw_text_span){ name.s, line.n - (size_t)(name.s - line.s) }))
                break;                             /* spreadsheets fill lines up */
            s = take_column(h, &f, name, number, (long)(name.s - line.s) + 1, e);
        }
    if (s == LW_OK)
        s = assign_angles(h, &f, number, e);
    if (s != LW_OK)
        return s;
    if (f.at[COL_X] >= 0)
        assign(h, &f, LW_TARGET_FIELD_X, COL_X);
    if (f.at[COL_Y] >= 0)
        assign(h, &f, LW_TARGET_FIELD_Y, COL_Y);
    if (f.at[COL_WEIGHT] >= 0)
        assign(h, &f, LW_TARGET_FIELD_WEIGHT, COL_WEIGHT);
    s = check_complete(h, number, e);
    for (int i = 0; i < LW_ALSO_MAX && s == LW_OK; i++)
        s = assign_also(h, &f, i, number, e);
    return s;
}
