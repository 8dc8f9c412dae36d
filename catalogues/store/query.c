#include "catalogues/store/query.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/suggest.h"
#include "base/units.h"

#define DEPTH_MAX 50
#define FIELD_MAX 100

/* ---- words ------------------------------------------------------------------------------------------- */

typedef enum token_kind { END, WORD, NUMBER, TEXT, SIGN } token_kind;

typedef struct token {
    token_kind  kind;
    const char *at;
    size_t      n;
    char        sign;             /* SIGN: one of ( ) , = ! < > ~ [ (<=) ] (>=) : (..) */
} token;

typedef struct reader {
    const char             *text, *at;
    token                   next;
    const lw_query_options *o;
    lw_query               *q;
    const lw_query_field         *used[FIELD_MAX];
    int                     n_used, depth;
    size_t                  n_text;
    lw_error               *e;
} reader;

static lw_status fault(reader *r, const char *at, const char *format, const char *word, size_t n)
{
    return lw_error_at(r->e, LW_E_NOTATION, "query", 1, at - r->text + 1, format, (int)(n > 60 ? 60 : n), word);
}

static bool in_word(char c)
{
    return isalnum((unsigned char)c) || c == '_' || c == '-' || c == '.' || c == '/' || c == '*' || c == '?';
}

static lw_status read_quoted(reader *r, token *t)
{
    const char *end = strchr(r->at + 1, *r->at);
    if (!end)
        return fault(r, r->at, "the text %.*s has no quote at its end", r->at, strlen(r->at));
    *t = (token){ TEXT, r->at + 1, (size_t)(end - r->at - 1), 0 };
    r->at = end + 1;
    return LW_OK;
}

static bool read_sign(reader *r, token *t)
{
    static const char *const two[] = { "<=", ">=", "!=", "<>", "==", ".." };
    static const char code[] = "[]!!=:";
    for (int i = 0; i < 6; i++)
        if (strncmp(r->at, two[i], 2) == 0) {
            *t = (token){ SIGN, r->at, 2, code[i] };
            r->at += 2;
            return true;
        }
    if (!strchr("(),=<>~", *r->at))
        return false;
    *t = (token){ SIGN, r->at, 1, *r->at };
    r->at++;
    return true;
}

/* A number ends before "..", so that 4..8 is two numbers. */
static size_t word_length(const char *at)
{
    size_t n = 0;
    while (in_word(at[n]) && !(at[n] == '.' && at[n + 1] == '.'))
        n++;
    bool exponent = n > 0 && tolower((unsigned char)at[n - 1]) == 'e' && isdigit((unsigned char)*at);
    if (exponent && (at[n] == '+' || at[n] == '-'))
        n += 1 + word_length(at + n + 1);
    return n;
}

static lw_status advance(reader *r)
{
    token *t = &r->next;
    while (isspace((unsigned char)*r->at))
        r->at++;
    if (!*r->at) {
        *t = (token){ END, r->at, 0, 0 };
        return LW_OK;
    }
    if (*r->at == '"' || *r->at == '\'')
        return read_quoted(r, t);
    if (read_sign(r, t))
        return LW_OK;
    size_t n = word_length(r->at + (*r->at == '+')) + (*r->at == '+');
    if (n == 0)
        return fault(r, r->at, "'%.*s' means nothing here; texts with signs stand in quotes", r->at, 1);
    const char *digit = r->at + (*r->at == '-' || *r->at == '+');
    bool number = isdigit((unsigned char)*digit) || (*digit == '.' && isdigit((unsigned char)digit[1]));
    *t = (token){ number ? NUMBER : WORD, r->at, n, 0 };
    r->at += n;
    return LW_OK;
}

static bool is_word(const token *t, const char *word)
{
    if (t->kind != WORD || t->n != strlen(word))
        return false;
    for (size_t i = 0; i < t->n; i++)
        if (tolower((unsigned char)t->at[i]) != word[i])
            return false;
    return true;
}

/* ---- fields ------------------------------------------------------------------------------------------ */

static const lw_query_field *find_field(const char *at, size_t n)
{
    for (const lw_query_field *f = lw_fields; f->name; f++)
        if (strlen(f->name) == n && strncmp(f->name, at, n) == 0)
            return f;
    return NULL;
}

static lw_status unknown_field(reader *r, const char *at, size_t n)
{
    char word[40];
    int count = 0;
    while (lw_fields[count].name)
        count++;
    snprintf(word, sizeof word, "%.*s", (int)(n < 39 ? n : 39), at);
    const char *near = LW_SUGGEST(word, lw_fields, count, name);
    return lw_error_at(r->e, LW_E_NOTATION, "query", 1, at - r->text + 1, "there is no field '%s'%s%s%s", word,
                       near ? "; did you mean '" : "; --fields lists them", near ? near : "", near ? "'?" : "");
}

static void use(reader *r, const lw_query_field *f)
{
    for (int i = 0; i < r->n_used; i++)
        if (r->used[i] == f)
            return;
    r->used[r->n_used++] = f;
}

/* Find the list that has all fields used, unless the caller chose a list. */
static lw_status choose_list(reader *r)
{
    bool free = r->o->list == LW_LIST_ANY;
    int first = free ? 0 : (int)r->o->list, last = free ? LW_LIST_ANY - 1 : first;
    const lw_query_field *missing = NULL;
    for (int l = first; l <= last; l++) {
        missing = NULL;
        for (int i = 0; i < r->n_used && !missing; i++)
            missing = r->used[i]->sql[l] ? NULL : r->used[i];
        r->q->list = (lw_query_list)l;
        if (!missing)
            return LW_OK;
    }
    if (first == last)
        return lw_error_set(r->e, LW_E_ARG, "%s have no field '%s'; --fields lists what they have", lw_list_names[first], missing->name);
    return lw_error_set(r->e, LW_E_ARG, "no list has all these fields, '%s' and others; --fields lists which has what", missing->name);
}

/* ---- values ------------------------------------------------------------------------------------------ */

static lw_status add_value(reader *r, lw_value v)
{
    char number[16];
    if (r->q->n_value == LW_QUERY_VALUE_MAX)
        return fault(r, r->next.at, "more than 64 values%.*s", "", 0);
    r->q->value[r->q->n_value++] = v;
    snprintf(number, sizeof number, "?%d", r->q->n_value);
    lw_bytes_text(&r->q->sql, number);
    return LW_OK;
}

static lw_status add_text(reader *r, const char *at, size_t n, bool part)
{
    char *to = r->q->text + r->n_text;
    if (r->n_text + n + 2 > sizeof r->q->text)
        return fault(r, at, "the query is too long at '%.*s'", at, n);
    if (part)
        *to++ = '*';
    memcpy(to, at, n);
    if (part)
        to[n] = '*';
    r->n_text += n + 2*part;
    return add_value(r, (lw_value){ .kind = LW_VALUE_TEXT, .text = part ? to - 1 : to, .size = n + 2*part });
}

/* "2", "1e-3", "2mm", "30deg" */
static lw_status read_number(reader *r, const lw_query_field *f, double *v)
{
    const token *t = &r->next;
    size_t digits = t->n;
    double unit = 1;
    char name[8];
    while (digits > 0 && lw_number_parse(t->at, digits, v) != LW_OK)
        digits--;
    if (t->kind != NUMBER || digits == 0)
        return fault(r, t->at, "a number is wanted, not '%.*s'", t->at, t->n);
    if (digits < t->n && isdigit((unsigned char)t->at[digits]))
        return fault(r, t->at, "'%.*s' is too large a number", t->at, t->n);
    if (digits < t->n) {
        lw_units u = lw_units_si();
        snprintf(name, sizeof name, "%.*s", (int)(t->n - digits < 7 ? t->n - digits : 7), t->at + digits);
        if (f->kind == LW_FIELD_LENGTH && lw_units_set_length(&u, name))
            unit = u.metre;
        else if (f->kind == LW_FIELD_ANGLE && lw_units_set_angle(&u, name))
            unit = u.radian;
        else
            return fault(r, t->at + digits, "'%.*s' is no unit of this field", t->at + digits, t->n - digits);
    }
    *v *= unit;
    return LW_OK;
}

static lw_status read_flag(reader *r)
{
    static const char *const word[] = { "no", "yes", "false", "true" };
    const token *t = &r->next;
    for (int i = 0; i < 4; i++)
        if (is_word(t, word[i]))
            return add_value(r, (lw_value){ .kind = LW_VALUE_INTEGER, .integer = i%2 });
    if (t->kind == NUMBER && t->n == 1 && (*t->at == '0' || *t->at == '1'))
        return add_value(r, (lw_value){ .kind = LW_VALUE_INTEGER, .integer = *t->at - '0' });
    return fault(r, t->at, "yes or no is wanted, not '%.*s'", t->at, t->n);
}

static lw_status read_value(reader *r, const lw_query_field *f, bool pattern)
{
    const token t = r->next;
    lw_status s;
    if (t.kind == END || t.kind == SIGN)
        return fault(r, t.at, t.kind == END ? "a value is wanted here%.*s" : "a value is wanted, not '%.*s'", t.at, t.n);
    if (f->kind == LW_FIELD_TEXT) {
        bool part = pattern && !memchr(t.at, '*', t.n) && !memchr(t.at, '?', t.n);
        s = add_text(r, t.at, t.n, part);
    } else if (f->kind == LW_FIELD_FLAG) {
        s = read_flag(r);
    } else {
        double v = 0;
        s = read_number(r, f, &v);
        if (s == LW_OK)
            s = add_value(r, (lw_value){ .kind = LW_VALUE_REAL, .real = v });
    }
    return s == LW_OK ? advance(r) : s;
}

/* ---- tests ------------------------------------------------------------------------------------------- */

/* Until the list is chosen, a field is written in the SQL as a byte 1 and its number. */
static void put_field(reader *r, const lw_query_field *f)
{
    char mark[3] = { 1, (char)(f - lw_fields + 1), 0 };
    use(r, f);
    lw_bytes_text(&r->q->sql, mark);
}

static lw_status read_set(reader *r, const lw_query_field *f)
{
    lw_status s = advance(r);
    if (s == LW_OK && r->next.sign != '(')
        return fault(r, r->next.at, "after 'in' comes '(', not '%.*s'", r->next.at, r->next.n);
    lw_bytes_text(&r->q->sql, " IN (");
    do {
        if (s == LW_OK && r->next.sign == ',')
            lw_bytes_text(&r->q->sql, ", ");
        if (s == LW_OK)
            s = advance(r);
        if (s == LW_OK)
            s = read_value(r, f, false);
    } while (s == LW_OK && r->next.sign == ',');
    if (s == LW_OK && r->next.sign != ')')
        return fault(r, r->next.at, "',' or ')' is wanted%.*s", "", 0);
    lw_bytes_text(&r->q->sql, ")");
    return s == LW_OK ? advance(r) : s;
}

/* field = least..greatest: the first value is already written. */
static lw_status read_range(reader *r, const lw_query_field *f, char sign)
{
    if (sign != '=' || f->kind == LW_FIELD_TEXT || f->kind == LW_FIELD_FLAG)
        return fault(r, r->next.at, "a range 4..8 comes after '=' and between numbers%.*s", "", 0);
    lw_bytes_text(&r->q->sql, " AND ");
    lw_status s = advance(r);
    const char *last = r->next.at;
    if (s == LW_OK)
        s = read_value(r, f, false);
    const lw_value *v = r->q->value + r->q->n_value;
    if (s == LW_OK && v[-2].real > v[-1].real)
        return fault(r, last, "nothing lies in a range that ends below its beginning%.*s", "", 0);
    return s;
}

static const char *operator_text(char sign)
{
    switch (sign) {
    case '=': return " = ";
    case '!': return " != ";
    case '<': return " < ";
    case '>': return " > ";
    case '[': return " <= ";
    case ']': return " >= ";
    case '~': return " GLOB ";
    default:  return NULL;
    }
}

static lw_status read_comparison(reader *r, const lw_query_field *f)
{
    const token op = r->next;
    const char *text = operator_text(op.sign);
    lw_status s = LW_OK;
    if (!text)
        return fault(r, op.at, "after a field comes one of = != < <= > >= ~ in, not '%.*s'", op.at, op.n);
    if (op.sign == '~' && f->kind != LW_FIELD_TEXT)
        return fault(r, op.at, "'%.*s' is for texts", op.at, op.n);
    s = advance(r);
    if (s == LW_OK && is_word(&r->next, "none")) {
        if (op.sign != '=' && op.sign != '!')
            return fault(r, r->next.at, "'%.*s' goes with = and != only", r->next.at, r->next.n);
        lw_bytes_text(&r->q->sql, op.sign == '=' ? " IS NULL" : " IS NOT NULL");
        return advance(r);
    }
    size_t before = r->q->sql.size;
    lw_bytes_text(&r->q->sql, text);
    size_t after = r->q->sql.size;
    if (s == LW_OK)
        s = read_value(r, f, op.sign == '~');
    if (s != LW_OK || r->next.sign != ':')
        return s;
    /* replace the operator by BETWEEN */
    char number[16];
    snprintf(number, sizeof number, "%.15s", r->q->sql.failed ? "" : r->q->sql.data + after);
    r->q->sql.size = r->q->sql.failed ? 0 : before;
    lw_bytes_text(&r->q->sql, " BETWEEN ");
    lw_bytes_text(&r->q->sql, number);
    return read_range(r, f, op.sign);
}

static lw_status read_test(reader *r)
{
    const token t = r->next;
    if (t.kind == END)
        return fault(r, t.at, "the query ends where a field should follow%.*s", "", 0);
    const lw_query_field *f = t.kind == WORD ? find_field(t.at, t.n) : NULL;
    if (t.kind != WORD)
        return fault(r, t.at, "a field is wanted, not '%.*s'", t.at, t.n);
    if (!f)
        return unknown_field(r, t.at, t.n);
    put_field(r, f);
    lw_status s = advance(r);
    if (s != LW_OK)
        return s;
    if (is_word(&r->next, "in"))
        return read_set(r, f);
    bool alone = r->next.kind == END || r->next.sign == ')' || is_word(&r->next, "and") || is_word(&r->next, "or");
    if (alone && f->kind != LW_FIELD_FLAG)
        return fault(r, r->next.at, "'%.*s' wants a value: field=value", f->name, strlen(f->name));
    return alone ? LW_OK : read_comparison(r, f);
}

static lw_status read_or(reader *r);

static lw_status read_not(reader *r)
{
    lw_status s;
    if (++r->depth > DEPTH_MAX)
        return fault(r, r->next.at, "more than 50 parentheses in each other%.*s", "", 0);
    if (is_word(&r->next, "not")) {
        lw_bytes_text(&r->q->sql, "NOT ");
        s = advance(r);
        s = s == LW_OK ? read_not(r) : s;
    } else if (r->next.sign == '(') {
        const char *open = r->next.at;
        lw_bytes_text(&r->q->sql, "(");
        s = advance(r);
        if (s == LW_OK)
            s = read_or(r);
        if (s == LW_OK && r->next.sign != ')')
            return fault(r, open, "'%.*s' has no ')'", open, 1);
        lw_bytes_text(&r->q->sql, ")");
        s = s == LW_OK ? advance(r) : s;
    } else {
        s = read_test(r);
    }
    r->depth--;
    return s;
}

static lw_status read_and(reader *r)
{
    lw_status s = read_not(r);
    while (s == LW_OK && is_word(&r->next, "and")) {
        lw_bytes_text(&r->q->sql, " AND ");
        s = advance(r);
        s = s == LW_OK ? read_not(r) : s;
    }
    return s;
}

static lw_status read_or(reader *r)
{
    lw_status s = read_and(r);
    while (s == LW_OK && is_word(&r->next, "or")) {
        lw_bytes_text(&r->q->sql, " OR ");
        s = advance(r);
        s = s == LW_OK ? read_and(r) : s;
    }
    return s;
}

/* ---- columns, order ---------------------------------------------------------------------------------- */

static const char *const columns_of[LW_LIST_ANY] = {
    "graph6,links,dof,assortment,symmetry,grounds,planar,franke",
    "graph6,ground,kinds,inputs,highest,modes,assur",
    "id,name,type,class,target,error,error_max,transmission_min,crank",
    "loops,circles,lines,planar,structure,derivation",
};

/* Call for each field of a comma-separated list; `falling` allows a - before a field. */
static lw_status each_field(reader *r, const char *list, bool put)
{
    bool first = true;
    for (const char *at = list; *at || first; first = false) {
        size_t n = strcspn(at, ",");
        bool falling = put && *at == '-';
        const lw_query_field *f = find_field(at + falling, n - falling);
        r->text = list;
        if (!f)
            return unknown_field(r, at + falling, n - falling);
        if (!put) {
            use(r, f);
        } else {
            lw_bytes_text(&r->q->sql, first ? " ORDER BY " : ", ");
            put_field(r, f);
            lw_bytes_text(&r->q->sql, falling ? " DESC" : "");
        }
        at += n + (at[n] == ',');
    }
    return LW_OK;
}

static void put_columns(const lw_query *q, const char *list, lw_bytes *sql)
{
    for (const char *at = list; *at;) {
        size_t n = strcspn(at, ",");
        const lw_query_field *f = find_field(at, n);
        lw_bytes_text(sql, at == list ? "SELECT " : ", ");
        lw_bytes_text(sql, f->sql[q->list]);
        lw_bytes_text(sql, " AS \"");
        lw_bytes_text(sql, f->name);
        lw_bytes_text(sql, "\"");
        at += n + (at[n] == ',');
    }
}

/* Build the whole SQL: columns, tables, and the tests with field names in place of their marks. */
static void finish(lw_query *q, const lw_query_options *o)
{
    static const char *const from[LW_LIST_ANY] = {
        " FROM chain c LEFT JOIN structure s ON s.id = c.structure",
        " FROM mechanism m JOIN chain c ON c.id = m.chain LEFT JOIN structure s ON s.id = c.structure",
        " FROM linkage k LEFT JOIN chain c ON c.label = k.label LEFT JOIN structure s ON s.id = c.structure",
        " FROM structure s",
    };
    lw_bytes sql = { 0 };
    put_columns(q, o->columns ? o->columns : columns_of[q->list], &sql);
    lw_bytes_text(&sql, from[q->list]);
    for (size_t i = 0; i < q->sql.size; i++)
        if (q->sql.data[i] == 1)
            lw_bytes_text(&sql, lw_fields[q->sql.data[++i] - 1].sql[q->list]);
        else
            lw_bytes_add(&sql, q->sql.data + i, 1);
    if (!o->sort) {
        static const char *const order[LW_LIST_ANY] = { "c.id", "m.id", "k.id", "s.id" };
        lw_bytes_text(&sql, " ORDER BY ");
        lw_bytes_text(&sql, order[q->list]);
    }
    if (o->limit > 0) {
        lw_bytes_text(&sql, " LIMIT ");
        lw_bytes_integer(&sql, o->limit);
    }
    sql.failed |= q->sql.failed;
    lw_bytes_free(&q->sql);
    q->sql = sql;
}

static lw_status compile(reader *r, const char *text)
{
    lw_status s = advance(r);
    if (s == LW_OK && r->next.kind != END) {
        lw_bytes_text(&r->q->sql, " WHERE ");
        s = read_or(r);
        if (s == LW_OK && r->next.kind != END)
            s = fault(r, r->next.at, r->next.sign == ')' ? "this '%.*s' closes nothing" : "and, or, or the end is "
                      "wanted, not '%.*s'", r->next.at, r->next.n);
    }
    if (s == LW_OK && r->o->columns)
        s = each_field(r, r->o->columns, false);
    if (s == LW_OK && r->o->sort)
        s = each_field(r, r->o->sort, true);
    r->text = text;
    return s == LW_OK ? choose_list(r) : s;
}

lw_status lw_query_compile(const char *text, const lw_query_options *o, lw_query *q, lw_error *e)
{
    lw_error ignored;
    text = text ? text : "";
    reader r = { .text = text, .at = text, .o = o, .q = q, .e = e ? e : &ignored };
    memset(q, 0, sizeof *q);
    if (strlen(text) >= LW_QUERY_TEXT_MAX)
        return lw_error_set(r.e, LW_E_NOTATION, "the query is longer than %d bytes", LW_QUERY_TEXT_MAX - 1);
    lw_status s = compile(&r, text);
    if (s != LW_OK)
        return s;
    finish(q, o);
    return lw_bytes_end(&q->sql, r.e);
}

void lw_query_free(lw_query *q)
{
    lw_bytes_free(&q->sql);
}
