/* grammar/functions/formula.c - text -> operations on a stack (grammar/functions/arithmetic_internal.h); operations -> value with units. */
#include "grammar/functions/formula.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/growable_array.h"
#include "base/real.h"
#include "base/suggest.h"
#include "base/vec2.h"
#include "grammar/functions/arithmetic_internal.h"
#include "grammar/text/text_internal.h"

#define DEPTH_MAX 64               /* nested brackets; also the room of the stack over its arguments */
#define STACK_MAX 256

enum {
    OP_NUMBER = LW_OP_COUNT, OP_WORD, OP_NOT, OP_AND, OP_OR, OP_EQUAL, OP_DIFFERENT, OP_LESS, OP_AT_MOST, OP_GREATER,
    OP_AT_LEAST, OP_FLOOR, OP_CEIL, OP_ROUND, OP_IF, OP_STANDARD
};

static const lw_math_function functions[] = {
    { "floor", OP_FLOOR, 1, 1, "floor(x)" },   { "ceil",  OP_CEIL,  1, 1, "ceil(x)" },
    { "round", OP_ROUND, 1, 1, "round(x)" },   { "if",    OP_IF,    3, 3, "if(condition, a, b)" },
    { "standard", OP_STANDARD, 2, 0, "standard(x, size, size, ...)" },   /* the least size that is at least x */
};

typedef struct operation { int op, n; int word; size_t at; lw_amount value; } operation;    /* n: arguments */

struct lw_formula {
    bool       has_unit;
    lw_amount  unit;
    int        n, room, n_word, depth, deepest;
    operation *operation;
    int       *word;
    char      *texts;              /* literals, each terminated; room for all that the formula can hold */
    size_t     texts_used;
};

typedef struct vocabulary { lw_formula_lookup *lookup; void *context; } vocabulary;

typedef lw_arithmetic parser;

/* ---- amounts and units --------------------------------------------------------------------------- */

typedef struct unit { const char *name; double over, under; lw_dimension dimension; } unit;

#define D(...) { { __VA_ARGS__ } }
static const unit units[] = {                         /*    m  kg   s   A  K rad */
    { "m", 1, 1, D(1) }, { "mm", 1, 1e3, D(1) }, { "cm", 1, 1e2, D(1) }, { "km", 1e3, 1, D(1) }, { "um", 1, 1e6, D(1) },
    { "in", 254, 1e4, D(1) }, { "ft", 3048, 1e4, D(1) },
    { "kg", 1, 1, D(0, 1) }, { "g", 1, 1e3, D(0, 1) }, { "t", 1e3, 1, D(0, 1) }, { "lb", 45359237, 1e8, D(0, 1) },
    { "s", 1, 1, D(0, 0, 1) }, { "ms", 1, 1e3, D(0, 0, 1) }, { "min", 60, 1, D(0, 0, 1) }, { "h", 3600, 1, D(0, 0, 1) },
    { "rad", 1, 1, D(0, 0, 0, 0, 0, 1) }, { "deg", LW_PI, 180, D(0, 0, 0, 0, 0, 1) },
    { "turn", 2*LW_PI, 1, D(0, 0, 0, 0, 0, 1) }, { "rpm", LW_PI, 30, D(0, 0, -1, 0, 0, 1) },
    { "Hz", 1, 1, D(0, 0, -1) },
    { "N", 1, 1, D(1, 1, -2) }, { "kN", 1e3, 1, D(1, 1, -2) }, { "MN", 1e6, 1, D(1, 1, -2) },
    { "Pa", 1, 1, D(-1, 1, -2) }, { "kPa", 1e3, 1, D(-1, 1, -2) }, { "MPa", 1e6, 1, D(-1, 1, -2) },
    { "GPa", 1e9, 1, D(-1, 1, -2) }, { "bar", 1e5, 1, D(-1, 1, -2) },
    { "J", 1, 1, D(2, 1, -2) }, { "kJ", 1e3, 1, D(2, 1, -2) }, { "W", 1, 1, D(2, 1, -3) }, { "kW", 1e3, 1, D(2, 1,
        -3) },
    { "A", 1, 1, D(0, 0, 0, 1) }, { "V", 1, 1, D(2, 1, -3, -1) }, { "ohm", 1, 1, D(2, 1, -3, -2) },
    { "H", 1, 1, D(2, 1, -2, -2) }, { "mH", 1, 1e3, D(2, 1, -2, -2) }, { "K", 1, 1, D(0, 0, 0, 0, 1) },
    { "l", 1, 1e3, D(3) }, { "%", 1, 100, D(0) }, { "1", 1, 1, D(0) },
};
#undef D
enum { N_UNIT = sizeof units/sizeof *units };

lw_amount lw_amount_plain(double number)
{
    return (lw_amount){ .kind = LW_AMOUNT_NUMBER, .number = number, .over = 1, .under = 1 };
}

lw_amount lw_amount_of_text(const char *text)
{
    return (lw_amount){ .kind = LW_AMOUNT_TEXT, .over = 1, .under = 1, .text = text };
}

double lw_amount_si(const lw_amount *a)
{
    return a->over == a->under ? a->number : a->over == 1 ? a->number/a->under : a->number*a->over/a->under;
}

static bool is_plain(lw_dimension d)
{
    static const lw_dimension none;
    return memcmp(&d, &none, sizeof d) == 0;
}

bool lw_dimension_fits(lw_dimension a, lw_dimension b)
{
    bool only_angle = true;
    for (int i = 0; i < LW_DIMENSION_COUNT; i++) {
        if (i != LW_DIMENSION_RADIAN && a.of[i] != b.of[i])
            return false;
        only_angle = only_angle && (i == LW_DIMENSION_RADIAN || a.of[i] == 0);
    }
    return !only_angle || a.of[LW_DIMENSION_RADIAN] == b.of[LW_DIMENSION_RADIAN];
}

void lw_dimension_print(lw_dimension d, char *text, size_t size)
{
    static const char *const names[] = { "m", "kg", "s", "A", "K", "rad" };
    static const struct { const char *name; lw_dimension d; } known[] = {
        { "N", { { 1, 1, -2 } } }, { "N/m", { { 0, 1, -2 } } }, { "N m", { { 2, 1, -2 } } }, { "W", { { 2, 1, -3 } } },
        { "Pa", { { -1, 1, -2 } } }, { "V", { { 2, 1, -3, -1 } } } };
    size_t used = 0;
    *text = '\0';
    for (size_t i = 0; i < sizeof known/sizeof *known; i++)
        if (memcmp(&known[i].d, &d, sizeof d) == 0) {
            snprintf(text, size, "%s", known[i].name);
            return;
        }
    for (int sign = 1; sign >= -1; sign -= 2)
        for (int i = 0; i < LW_DIMENSION_COUNT && used < size; i++) {
            int n = sign*d.of[i];
            if (n <= 0)
                continue;
            used += (size_t)snprintf(text + used, size - used, "%s%s", sign < 0 ? used ? "/" : "1/" : used ? " " : "", names[i]);
            if (n > 1 && used < size)
                used += (size_t)snprintf(text + used, size - used, "^%d", n);
        }
    if (!used)
        snprintf(text, size, "plain number");
}

bool lw_amount_in(const lw_amount *a, const lw_amount *u, double *out)
{
    if (a->kind != LW_AMOUNT_NUMBER || !lw_dimension_fits(a->dimension, u->dimension))
        return false;
    if (a->over == u->over && a->under == u->under) {
        *out = a->number;
        return true;
    }
    double over = a->over*u->under, under = a->under*u->over;
    double ratio = fmod(over, under) == 0 ? over/under : 0, inverse = fmod(under, over) == 0 ? under/over : 0;
    *out = ratio != 0 ? a->number*ratio : inverse != 0 ? a->number/inverse : a->number*over/under;
    return true;
}

static const unit *find_unit(const char *name, size_t n)
{
    for (int i = 0; i < N_UNIT; i++)
        if (strlen(units[i].name) == n && memcmp(units[i].name, name, n) == 0)
            return &units[i];
    return NULL;
}

static void times_unit(lw_amount *a, const unit *u, int power)
{
    for (int k = 0; k < abs(power); k++) {
        a->over *= power > 0 ? u->over : u->under;
        a->under *= power > 0 ? u->under : u->over;
    }
    for (int i = 0; i < LW_DIMENSION_COUNT; i++)
        a->dimension.of[i] = (int8_t)(a->dimension.of[i] + power*u->dimension.of[i]);
}

/* "^2" or "^-2" at *at, or 1.  0: no exponent between 1 and 9. */
static int unit_power(const char *text, size_t size, size_t *at)
{
    if (*at >= size || text[*at] != '^')
        return 1;
    bool minus = *at + 1 < size && text[*at + 1] == '-';
    size_t digit = *at + 1 + minus;
    if (digit >= size || text[digit] < '1' || text[digit] > '9' || (digit + 1 < size && lw_is_digit(text[digit + 1])))
        return 0;
    *at = digit + 1;
    return minus ? -(text[digit] - '0') : text[digit] - '0';
}

static lw_status unknown_unit(const char *name, size_t n, size_t at, lw_error *e)
{
    char word[LW_WORD_SIZE];
    snprintf(word, sizeof word, "%.*s", (int)(n < sizeof word ? n : sizeof word - 1), name);
    const char *near = LW_SUGGEST(word, units, N_UNIT, name);
    return lw_error_at(e, LW_E_NOTATION, "", 1, (long)at + 1, "there is no unit \"%s\"%s%s%s", word,
                       near ? "; did you mean " : "", near ? near : "", near ? "?" : "");
}

lw_status lw_unit_parse(const char *text, size_t size, lw_amount *out, lw_error *e)
{
    bool under = false, any = false;
    *out = lw_amount_plain(1);
    for (size_t at = 0; at < size;) {
        if (text[at] == ' ' || text[at] == '*') {
            at++;
            continue;
        }
        if (text[at] == '/' && any && !under) {
            under = true;
            at++;
            continue;
        }
        size_t n = text[at] == '%' || text[at] == '1' ? 1 : lw_word_length(text, size, at), start = at;
        const unit *u = n ? find_unit(text + at, n) : NULL;
        if (!u)
            return unknown_unit(text + at, n ? n : 1, at, e);
        at += n;
        int power = unit_power(text, size, &at);
        if (power == 0)
            return lw_error_at(e, LW_E_NOTATION, "", 1, (long)at + 1, "an exponent of 1 to 9 is expected after ^");
        times_unit(out, u, under ? -power : power);
        for (int i = 0; i < LW_DIMENSION_COUNT; i++)
            if (abs(out->dimension.of[i]) > 20)
                return lw_error_at(e, LW_E_NOTATION, "", 1, (long)start + 1, "this unit has too great exponents");
        if (!(out->over < 1e60 && out->under < 1e60))
            return lw_error_at(e, LW_E_NOTATION, "", 1, (long)start + 1, "this unit is too large or too small");
        under = false;
        any = true;
    }
    return any ? LW_OK : lw_error_at(e, LW_E_NOTATION, "", 1, 1, "a unit is expected, such as mm or kg m^2");
}

/* ---- text ---------------------------------------------------------------------------------------- */

static bool take_word(parser *p, const char *word)
{
    size_t n = strlen(word);
    lw_arithmetic_peek(p);
    if (lw_word_length(p->text, p->size, p->at) != n || memcmp(p->text + p->at, word, n) != 0)
        return false;
    p->at += n;
    return true;
}

static lw_status emit(parser *p, operation o)
{
    lw_formula *f = p->made;
    operation *more = lw_array_grow(f->operation, f->n, &f->room, sizeof *more);
    if (!more)
        return lw_error_set(p->e, LW_E_MEMORY, "out of memory for a formula");
    f->operation = more;
    f->depth += 1 - o.n;
    f->deepest = f->depth > f->deepest ? f->depth : f->deepest;
    if (f->deepest > STACK_MAX)
        return lw_arithmetic_fault(p, o.at, "the formula is too long: at most %d arguments of functions", STACK_MAX);
    f->operation[f->n++] = o;
    return LW_OK;
}

static lw_status literal(parser *p)
{
    size_t at = p->at, start = at + 1, end = start;
    while (lw_arithmetic_byte(p, end) >= 0 && lw_arithmetic_byte(p, end) != '\'')
        end++;
    if (lw_arithmetic_byte(p, end) < 0)
        return lw_arithmetic_fault(p, at, "this text has no closing '");
    lw_formula *f = p->made;
    char *text = f->texts + f->texts_used;
    memcpy(text, p->text + start, end - start);
    text[end - start] = '\0';
    f->texts_used += end - start + 1;
    p->at = end + 1;
    return emit(p, (operation){ .op = OP_NUMBER, .at = at, .value = lw_amount_of_text(text) });
}

/* The unit after a number: a single one, or any in brackets. */
static lw_status unit_after(parser *p, lw_amount *v)
{
    lw_error inner = { 0 };
    lw_amount u;
    int byte = lw_arithmetic_peek(p);
    size_t start = p->at, end;
    if (byte == '[') {
        for (end = ++start; lw_arithmetic_byte(p, end) >= 0 && lw_arithmetic_byte(p, end) != ']'; end++)
            continue;
        if (lw_arithmetic_byte(p, end) < 0)
            return lw_arithmetic_fault(p, start - 1, "this bracket of a unit has no ]");
        p->at = end + 1;
    } else {
        size_t n = byte == '%' ? 1 : lw_word_length(p->text, p->size, start);
        static const char *const words[] = { "as", "and", "or" };
        for (int i = 0; i < 3; i++)
            if (strlen(words[i]) == n && memcmp(words[i], p->text + start, n) == 0)
                return LW_OK;
        if (n == 0)
            return LW_OK;
        end = start + n;
        unit_power(p->text, p->size, &end);
        p->at = end;
    }
    lw_status s = lw_unit_parse(p->text + start, end - start, &u, &inner);
    if (s != LW_OK)
        return lw_arithmetic_fault(p, start + (inner.column > 0 ? (size_t)inner.column - 1 : 0), "%s", inner.text);
    u.number = v->number;
    *v = u;
    return LW_OK;
}

/* The operands of a language are not used: values are on the stack. */
static lw_status number(parser *p, size_t at, double value, lw_operand *out)
{
    lw_amount v = lw_amount_plain(value);
    lw_status s = unit_after(p, &v);
    (void)out;
    return s == LW_OK ? emit(p, (operation){ .op = OP_NUMBER, .at = at, .value = v }) : s;
}

static lw_status operate(parser *p, size_t at, lw_op op, lw_operand a, lw_operand b, lw_operand *out)
{
    (void)a, (void)b, (void)out;
    return emit(p, (operation){ .op = (int)op, .n = op == LW_OP_NEGATE ? 1 : 2, .at = at });
}

static lw_status word(parser *p, int byte, lw_operand *out)
{
    char name[LW_WORD_SIZE], why[256] = "", buf[24];
    size_t at = p->at;
    (void)out;
    if (byte == '\'')
        return literal(p);
    if (!lw_is_letter(byte))
        return lw_arithmetic_fault(p, at, "a number, a word, a 'text' or '(' is expected, not %s", lw_byte_name(byte, buf));
    lw_status s = lw_arithmetic_word(p, name);
    if (s != LW_OK)
        return s;
    lw_amount v = lw_amount_plain(LW_PI);
    if (strcmp(name, "true") == 0 || strcmp(name, "false") == 0)
        v = (lw_amount){ .kind = LW_AMOUNT_TRUTH, .number = name[0] == 't', .over = 1, .under = 1 };
    if (strcmp(name, "pi") == 0 || v.kind == LW_AMOUNT_TRUTH)
        return emit(p, (operation){ .op = OP_NUMBER, .at = at, .value = v });
    const lw_math_function *g = lw_arithmetic_function(p, name);
    if (g) {
        lw_argument *list;
        int n;
        s = lw_arithmetic_arguments(p, g, &list, &n);
        free(list);
        return s == LW_OK ? emit(p, (operation){ .op = g->op, .n = n, .at = at }) : s;
    }
    const vocabulary *w = p->words;
    lw_formula *f = p->made;
    int id = w->lookup ? w->lookup(w->context, name, why) : -1;
    if (id < 0)
        return why[0] ? lw_arithmetic_fault(p, at, "%s", why) : lw_arithmetic_unknown(p, name, at);
    f->word[f->n_word++] = id;
    return emit(p, (operation){ .op = OP_WORD, .at = at, .word = id });
}

static lw_status comparison(parser *p)
{
    lw_operand none;
    static const struct { const char *sign; int op; } signs[] = {      /* longer ones first */
        { "==", OP_EQUAL }, { "!=", OP_DIFFERENT }, { "<=", OP_AT_MOST }, { ">=", OP_AT_LEAST }, { "<", OP_LESS },
        { ">", OP_GREATER }, { "=", OP_EQUAL } };
    lw_status s = lw_arithmetic_sum(p, &none);
    lw_arithmetic_peek(p);
    for (size_t i = 0; s == LW_OK && i < sizeof signs/sizeof *signs; i++) {
        size_t n = strlen(signs[i].sign), at = p->at;
        if (p->size - at < n || memcmp(p->text + at, signs[i].sign, n) != 0)
            continue;
        p->at += n;
        s = lw_arithmetic_sum(p, &none);
        return s == LW_OK ? emit(p, (operation){ .op = signs[i].op, .n = 2, .at = at }) : s;
    }
    return s;
}

static lw_status negation(parser *p)
{
    size_t at = (lw_arithmetic_peek(p), p->at);
    if (!take_word(p, "not"))
        return comparison(p);
    if (p->depth == DEPTH_MAX)
        return lw_arithmetic_fault(p, at, "too many \"not\" in each other: at most %d", DEPTH_MAX);
    p->depth++;
    lw_status s = negation(p);
    p->depth--;
    return s == LW_OK ? emit(p, (operation){ .op = OP_NOT, .n = 1, .at = at }) : s;
}

static lw_status conjunction(parser *p)
{
    lw_status s = negation(p);
    for (size_t at = (lw_arithmetic_peek(p), p->at); s == LW_OK && take_word(p, "and"); at = (lw_arithmetic_peek(p), p->at))
        if ((s = negation(p)) == LW_OK)
            s = emit(p, (operation){ .op = OP_AND, .n = 2, .at = at });
    return s;
}

static lw_status disjunction(parser *p, lw_operand *out)
{
    (void)out;
    if (p->depth == DEPTH_MAX)
        return lw_arithmetic_fault(p, p->at, "too many brackets in each other: at most %d", DEPTH_MAX);
    p->depth++;
    lw_status s = conjunction(p);
    for (size_t at = (lw_arithmetic_peek(p), p->at); s == LW_OK && take_word(p, "or"); at = (lw_arithmetic_peek(p), p->at))
        if ((s = conjunction(p)) == LW_OK)
            s = emit(p, (operation){ .op = OP_OR, .n = 2, .at = at });
    p->depth--;
    return s;
}

/* "as UNIT" or the end. */
static lw_status end_of(parser *p)
{
    if (take_word(p, "as")) {
        lw_error inner = { 0 };
        lw_formula *f = p->made;
        lw_arithmetic_peek(p);
        lw_status s = lw_unit_parse(p->text + p->at, p->size - p->at, &f->unit, &inner);
        f->has_unit = true;
        return s == LW_OK ? s : lw_arithmetic_fault(p, p->at + (inner.column > 0 ? (size_t)inner.column - 1 : 0), "%s", inner.text);
    }
    return lw_arithmetic_end(p);
}

static const lw_language language = { .words = "parameter or function", .depth = DEPTH_MAX, .function = functions,
    .n_function = sizeof functions/sizeof *functions, .whole = disjunction, .number = number, .other = word, .apply = operate };

lw_status lw_formula_parse(const char *text, size_t size, lw_formula_lookup *lookup, void *context, lw_formula **out, lw_error *e)
{
    *out = NULL;
    lw_formula *f = calloc(1, sizeof *f);
    if (f) {
        f->texts = malloc(size + 1);
        f->word = malloc((size + 1)*sizeof *f->word);
    }
    if (!f || !f->texts || !f->word) {
        lw_formula_free(f);
        return lw_error_set(e, LW_E_MEMORY, "out of memory for a formula");
    }
    lw_error own = { 0 };
    vocabulary w = { lookup, context };
    lw_operand none;
    parser p = { .text = text, .size = size, .language = &language, .made = f, .words = &w, .e = e ? e : &own };
    lw_status s = disjunction(&p, &none);
    if (s == LW_OK)
        s = end_of(&p);
    if (s != LW_OK)
        lw_formula_free(f);
    else
        *out = f;
    return s;
}

void lw_formula_free(lw_formula *f)
{
    if (!f)
        return;
    free(f->operation);
    free(f->texts);
    free(f->word);
    free(f);
}

const lw_amount *lw_formula_unit(const lw_formula *f) { return f->has_unit ? &f->unit : NULL; }

int lw_formula_words(const lw_formula *f, const int **which)
{
    *which = f->word;
    return f->n_word;
}

/* ---- value --------------------------------------------------------------------------------------- */

static lw_status mistake(const operation *o, lw_error *e, const char *format, ...) __attribute__((format(printf, 3, 4)));
static lw_status mistake(const operation *o, lw_error *e, const char *format, ...)
{
    char text[400];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return lw_error_at(e, LW_E_NOTATION, "", 1, (long)o->at + 1, "%s", text);
}

static const char *print_kind(const lw_amount *a, char text[64])
{
    if (a->kind == LW_AMOUNT_NUMBER)
        lw_dimension_print(a->dimension, text, 64);
    return a->kind == LW_AMOUNT_NUMBER ? text : a->kind == LW_AMOUNT_TEXT ? "text" : "condition";
}

static lw_status unfit(const operation *o, const lw_amount *a, const lw_amount *b, const char *what, lw_error *e)
{
    char one[64], two[64];
    return mistake(o, e, "the units do not fit: [%s] and [%s] cannot be %s", print_kind(a, one), print_kind(b, two), what);
}

/* b in the unit of a. */
static bool align(const lw_amount *a, const lw_amount *b, double *out)
{
    return a->kind == LW_AMOUNT_NUMBER && lw_amount_in(b, a, out);
}

static lw_status add(const operation *o, lw_amount *a, const lw_amount *b, lw_error *e)
{
    double other;
    if (!align(a, b, &other))
        return unfit(o, a, b, o->op == LW_OP_ADD ? "added" : "subtracted", e);
    a->number = o->op == LW_OP_ADD ? a->number + other : a->number - other;
    return LW_OK;
}

/* Keep whole factors while they are exact; else take them into the number. */
static void settle(lw_amount *a)
{
    if (a->over == a->under || a->over > 1e15 || a->under > 1e15) {
        a->number = lw_amount_si(a);
        a->over = a->under = 1;
    }
}

static lw_status multiply(const operation *o, lw_amount *a, const lw_amount *b, lw_error *e)
{
    bool divide = o->op == LW_OP_DIVIDE;
    if (a->kind != LW_AMOUNT_NUMBER || b->kind != LW_AMOUNT_NUMBER)
        return unfit(o, a, b, divide ? "divided" : "multiplied", e);
    a->number = divide ? a->number/b->number : a->number*b->number;
    a->over *= divide ? b->under : b->over;
    a->under *= divide ? b->over : b->under;
    for (int i = 0; i < LW_DIMENSION_COUNT; i++) {
        int d = a->dimension.of[i] + (divide ? -b->dimension.of[i] : b->dimension.of[i]);
        if (abs(d) > 100)
            return mistake(o, e, "the exponents of these units are too great");
        a->dimension.of[i] = (int8_t)d;
    }
    settle(a);
    return LW_OK;
}

static lw_status power(const operation *o, lw_amount *a, double exponent, lw_error *e)
{
    double si = lw_amount_si(a);
    for (int i = 0; i < LW_DIMENSION_COUNT; i++) {
        double d = a->dimension.of[i]*exponent, whole = round(d);
        char text[64];
        if (fabs(d - whole) > 1e-9 || fabs(whole) > 100)
            return mistake(o, e, "[%s] has no power %g", print_kind(a, text), exponent);
        a->dimension.of[i] = (int8_t)whole;
    }
    bool whole = exponent == round(exponent) && exponent >= 1 && exponent <= 4;
    double over = 1, under = 1;
    for (int k = 0; whole && k < (int)exponent; k++) {
        over *= a->over;
        under *= a->under;
    }
    a->number = whole ? pow(a->number, exponent) : pow(si, exponent);
    a->over = over;
    a->under = under;
    settle(a);
    return LW_OK;
}

static bool is_number_or_angle(const lw_amount *a)
{
    lw_dimension d = a->dimension;
    d.of[LW_DIMENSION_RADIAN] = 0;
    return a->kind == LW_AMOUNT_NUMBER && is_plain(d);
}

static lw_status elementary(const operation *o, lw_amount *a, lw_error *e)
{
    char text[64];
    double x = lw_amount_si(a);
    if (!is_number_or_angle(a))
        return mistake(o, e, "a plain number%s is expected as argument, this is [%s]",
                       o->op <= LW_OP_TAN ? " or an angle" : "", print_kind(a, text));
    switch (o->op) {
    case LW_OP_SIN:  x = sin(x); break;
    case LW_OP_COS:  x = cos(x); break;
    case LW_OP_TAN:  x = tan(x); break;
    case LW_OP_ASIN: x = asin(x); break;
    case LW_OP_ACOS: x = acos(x); break;
    case LW_OP_ATAN: x = atan(x); break;
    case LW_OP_SINH: x = sinh(x); break;
    case LW_OP_COSH: x = cosh(x); break;
    case LW_OP_TANH: x = tanh(x); break;
    case LW_OP_EXP:  x = exp(x); break;
    default:      x = log(x); break;
    }
    *a = lw_amount_plain(x);
    a->dimension.of[LW_DIMENSION_RADIAN] = o->op == LW_OP_ASIN || o->op == LW_OP_ACOS || o->op == LW_OP_ATAN;
    return LW_OK;
}

static lw_status of_pair(const operation *o, lw_amount *a, const lw_amount *b, lw_error *e)
{
    double y;
    if (!align(a, b, &y))
        return unfit(o, a, b, "compared", e);
    double x = a->number;
    if (o->op == LW_OP_ATAN2) {
        *a = lw_amount_plain(atan2(x, y));
        a->dimension.of[LW_DIMENSION_RADIAN] = 1;
    } else
        a->number = o->op == LW_OP_MOD ? lw_modulo(x, y) : hypot(x, y);
    return LW_OK;
}

static lw_status compare(const operation *o, lw_amount *a, const lw_amount *b, lw_error *e)
{
    double y = 0;
    bool equal, less = false;
    if (a->kind == LW_AMOUNT_NUMBER) {
        if (!align(a, b, &y))
            return unfit(o, a, b, "compared", e);
        equal = a->number == y;
        less = a->number < y;
    } else {
        if (a->kind != b->kind || (o->op != OP_EQUAL && o->op != OP_DIFFERENT))
            return unfit(o, a, b, "compared", e);
        equal = a->kind == LW_AMOUNT_TEXT ? strcmp(a->text, b->text) == 0 : a->number == b->number;
    }
    bool is = o->op == OP_EQUAL ? equal : o->op == OP_DIFFERENT ? !equal : o->op == OP_LESS ? less
            : o->op == OP_AT_MOST ? less || equal : o->op == OP_GREATER ? !less && !equal : !less;
    *a = (lw_amount){ .kind = LW_AMOUNT_TRUTH, .number = is, .over = 1, .under = 1 };
    return LW_OK;
}

static lw_status logic(const operation *o, lw_amount *a, lw_error *e)
{
    char text[64];
    for (int i = 0; i < o->n; i++)
        if (a[i].kind != LW_AMOUNT_TRUTH)
            return mistake(o, e, "a condition is expected on %s side, this is a [%s]", o->n == 1 ? "the right" : i ?
                           "the right"
                           : "the left", print_kind(&a[i], text));
    a->number = o->op == OP_NOT ? a->number == 0 : o->op == OP_AND ? a[0].number != 0 && a[1].number != 0
              : a[0].number != 0 || a[1].number != 0;
    return LW_OK;
}

static lw_status choose(const operation *o, lw_amount *a, lw_error *e)
{
    char one[64], two[64];
    if (a->kind != LW_AMOUNT_TRUTH)
        return mistake(o, e, "if needs a condition first, this is a [%s]", print_kind(a, one));
    if (a[1].kind != a[2].kind || (a[1].kind == LW_AMOUNT_NUMBER && !lw_dimension_fits(a[1].dimension, a[2].dimension)))
        return mistake(o, e, "both values of if must have one unit, these are [%s] and [%s]", print_kind(&a[1], one),
                       print_kind(&a[2], two));
    *a = a->number != 0 ? a[1] : a[2];
    return LW_OK;
}

/* min, max, standard */
static lw_status of_list(const operation *o, lw_amount *a, lw_error *e)
{
    int best = o->op == OP_STANDARD ? -1 : 0;
    double value = a->number, y;
    for (int i = 1; i < o->n; i++) {
        if (!align(a, &a[i], &y))
            return unfit(o, a, &a[i], "compared", e);
        bool better = o->op == LW_OP_MIN ? y < value : o->op == LW_OP_MAX ? y > value
                    : y >= a->number && (best < 0 || y < value);
        if (better) {
            best = i;
            value = y;
        }
    }
    if (best < 0) {
        double si = lw_amount_si(a);
        return mistake(o, e, "no standard size is as large as %g (in SI units)", si);
    }
    *a = a[best];
    return LW_OK;
}

static lw_status unary_value(const operation *o, lw_amount *a, lw_error *e)
{
    char text[64];
    if (a->kind != LW_AMOUNT_NUMBER)
        return mistake(o, e, "a number is expected here, this is a [%s]", print_kind(a, text));
    switch (o->op) {
    case LW_OP_NEGATE: a->number = -a->number; return LW_OK;
    case LW_OP_ABS:    a->number = fabs(a->number); return LW_OK;
    case LW_OP_SIGN:   *a = lw_amount_plain((a->number > 0) - (a->number < 0)); return LW_OK;
    case LW_OP_SQRT:   return power(o, a, 0.5, e);
    default:        break;
    }
    if (!is_plain(a->dimension))
        return mistake(o, e, "a plain number is expected here, this is [%s]; divide it by a unit", print_kind(a, text));
    double x = lw_amount_si(a);
    *a = lw_amount_plain(o->op == OP_FLOOR ? floor(x) : o->op == OP_CEIL ? ceil(x) : round(x));
    return LW_OK;
}

static lw_status apply(const operation *o, lw_amount *a, lw_error *e)
{
    switch (o->op) {
    case LW_OP_ADD: case LW_OP_SUBTRACT:    return add(o, a, a + 1, e);
    case LW_OP_MULTIPLY: case LW_OP_DIVIDE: return multiply(o, a, a + 1, e);
    case LW_OP_POWER:
        if (a[0].kind != LW_AMOUNT_NUMBER || !is_number_or_angle(&a[1]))
            return mistake(o, e, "an exponent is a plain number");
        return power(o, a, lw_amount_si(&a[1]), e);
    case OP_NOT: case OP_AND: case OP_OR: return logic(o, a, e);
    case OP_EQUAL: case OP_DIFFERENT: case OP_LESS: case OP_AT_MOST: case OP_GREATER: case OP_AT_LEAST:
        return compare(o, a, a + 1, e);
    case LW_OP_ATAN2: case LW_OP_MOD: case LW_OP_HYPOT: return of_pair(o, a, a + 1, e);
    case LW_OP_MIN: case LW_OP_MAX: case OP_STANDARD: return of_list(o, a, e);
    case OP_IF: return choose(o, a, e);
    case LW_OP_NEGATE: case LW_OP_ABS: case LW_OP_SIGN: case LW_OP_SQRT: case OP_FLOOR: case OP_CEIL: case OP_ROUND:
        return unary_value(o, a, e);
    default: return elementary(o, a, e);
    }
}

static lw_status run(const lw_formula *f, const lw_amount *const value[2], lw_amount *out, lw_amount *sides, lw_error *e)
{
    lw_amount stack[STACK_MAX + 1];
    int n = 0;
    for (int i = 0; i < f->n; i++) {
        const operation *o = &f->operation[i];
        n += 1 - o->n;
        if (o->op == OP_NUMBER)
            stack[n - 1] = o->value;
        else if (o->op == OP_WORD)
            stack[n - 1] = value[o->word & 1][o->word >> 1];
        else {
            if (sides && i == f->n - 1 && o->n == 2)
                memcpy(sides, &stack[n - 1], 2*sizeof *sides);
            lw_status s = apply(o, &stack[n - 1], e);
            if (s != LW_OK)
                return s;
        }
    }
    if (stack->kind == LW_AMOUNT_NUMBER && !isfinite(lw_amount_si(stack)))
        return lw_error_at(e, LW_E_NOTATION, "", 1, 1, "this is no finite number");
    if (stack->kind == LW_AMOUNT_NUMBER && f->has_unit && !lw_dimension_fits(stack->dimension, f->unit.dimension)) {
        char one[64], two[64];
        return lw_error_at(e, LW_E_NOTATION, "", 1, 1, "the units do not fit: this is [%s], not [%s]",
                           print_kind(stack, one), print_kind(&f->unit, two));
    }
    *out = *stack;
    return LW_OK;
}

lw_status lw_formula_value(const lw_formula *f, const lw_amount *const value[2], lw_amount *out, lw_error *e)
{
    return run(f, value, out, NULL, e);
}

lw_status lw_formula_compare(const lw_formula *f, const lw_amount *const value[2], lw_amount *out, lw_amount *left,
                             lw_amount *right, lw_error *e)
{
    lw_amount sides[2] = { lw_amount_plain(0), lw_amount_plain(0) };
    lw_status s = run(f, value, out, sides, e);
    *left = sides[0];
    *right = sides[1];
    return s;
}
