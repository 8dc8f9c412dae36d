/* grammar/functions/arithmetic.c - see arithmetic_internal.h. */
#include "grammar/functions/arithmetic_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/growable_array.h"
#include "base/number.h"
#include "base/suggest.h"
#include "grammar/text/text_internal.h"

static const lw_math_function common[] = {
    { "sin",   LW_OP_SIN,   1, 1, "sin(x)" },     { "cos",   LW_OP_COS,   1, 1, "cos(x)" },
    { "tan",   LW_OP_TAN,   1, 1, "tan(x)" },     { "asin",  LW_OP_ASIN,  1, 1, "asin(x)" },
    { "acos",  LW_OP_ACOS,  1, 1, "acos(x)" },    { "atan",  LW_OP_ATAN,  1, 1, "atan(x)" },
    { "atan2", LW_OP_ATAN2, 2, 2, "atan2(y, x)" }, { "sinh", LW_OP_SINH,  1, 1, "sinh(x)" },
    { "cosh",  LW_OP_COSH,  1, 1, "cosh(x)" },    { "tanh",  LW_OP_TANH,  1, 1, "tanh(x)" },
    { "exp",   LW_OP_EXP,   1, 1, "exp(x)" },     { "log",   LW_OP_LOG,   1, 1, "log(x)" },
    { "sqrt",  LW_OP_SQRT,  1, 1, "sqrt(x)" },    { "abs",   LW_OP_ABS,   1, 1, "abs(x)" },
    { "sign",  LW_OP_SIGN,  1, 1, "sign(x)" },    { "min",   LW_OP_MIN,   2, 0, "min(a, b, ...)" },
    { "max",   LW_OP_MAX,   2, 0, "max(a, b, ...)" }, { "mod", LW_OP_MOD, 2, 2, "mod(x, y)" },
    { "hypot", LW_OP_HYPOT, 2, 2, "hypot(x, y)" },
};
enum { N_COMMON = sizeof common/sizeof *common, N_NAME = 64 };

/* ---- text -------------------------------------------------------------------------------------- */

lw_status lw_arithmetic_fault(const lw_arithmetic *p, size_t at, const char *format, ...)
{
    char text[sizeof p->e->text];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return lw_error_at(p->e, LW_E_NOTATION, "", 1, (long)at + 1, "%s", text);
}

int lw_arithmetic_peek(lw_arithmetic *p)
{
    while (p->at < p->size && strchr(" \t\r\n", p->text[p->at]) && p->text[p->at])
        p->at++;
    return lw_arithmetic_byte(p, p->at);
}

bool lw_arithmetic_take(lw_arithmetic *p, int byte)
{
    if (lw_arithmetic_peek(p) != byte)
        return false;
    p->at++;
    return true;
}

int lw_arithmetic_byte(const lw_arithmetic *p, size_t at)
{
    return at < p->size ? (unsigned char)p->text[at] : -1;
}

static size_t digits(const lw_arithmetic *p, size_t at)
{
    while (lw_is_digit(lw_arithmetic_byte(p, at)))
        at++;
    return at;
}

size_t lw_word_length(const char *text, size_t size, size_t at)
{
    size_t end = at;
    while (end < size && (lw_is_letter(text[end]) || lw_is_digit(text[end])))
        end++;
    return end - at;
}

lw_status lw_arithmetic_word(lw_arithmetic *p, char word[LW_WORD_SIZE])
{
    size_t n = lw_word_length(p->text, p->size, p->at);
    if (n >= LW_WORD_SIZE)
        return lw_arithmetic_fault(p, p->at, "this word is too long");
    memcpy(word, p->text + p->at, n);
    word[n] = '\0';
    p->at += n;
    return LW_OK;
}

/* ---- functions --------------------------------------------------------------------------------- */

const lw_math_function *lw_arithmetic_function(const lw_arithmetic *p, const char *word)
{
    for (int i = 0; i < N_COMMON + p->language->n_function; i++) {
        const lw_math_function *f = i < N_COMMON ? &common[i] : &p->language->function[i - N_COMMON];
        if (strcmp(word, f->name) == 0)
            return f;
    }
    return NULL;
}

const char *lw_arithmetic_near(const lw_arithmetic *p, const char *word)
{
    const char *names[N_NAME] = { "pi" };
    int n = 1;
    for (int i = 0; i < p->language->n_function; i++)
        names[n++] = p->language->function[i].name;
    for (int i = 0; i < N_COMMON; i++)
        names[n++] = common[i].name;
    return lw_suggest(word, names, n);
}

lw_status lw_arithmetic_unknown(const lw_arithmetic *p, const char *word, size_t at)
{
    const char *near = lw_arithmetic_near(p, word);
    return lw_arithmetic_fault(p, at, "there is no %s %s here%s%s%s", p->language->words, word, near ? "; did you mean " : "",
                               near ? near : "", near ? "?" : "");
}

lw_status lw_arithmetic_arguments(lw_arithmetic *p, const lw_math_function *f, lw_argument **list, int *n)
{
    char buf[24];
    *list = NULL;
    *n = 0;
    if (!lw_arithmetic_take(p, '('))
        return lw_arithmetic_fault(p, p->at, "'(' is expected: %s", f->form);
    for (int room = 0;;) {
        lw_argument *more = lw_array_grow(*list, *n, &room, sizeof *more);
        if (!more)
            return lw_error_set(p->e, LW_E_MEMORY, "out of memory for the arguments of a function");
        *list = more;
        lw_arithmetic_peek(p);
        lw_argument *a = &(*list)[*n];
        a->at = p->at;
        if (f->most && *n == f->most)
            return lw_arithmetic_fault(p, p->at, "this is one too many: %s", f->form);
        lw_status s = p->language->whole(p, &a->o);
        if (s != LW_OK)
            return s;
        ++*n;
        if (lw_arithmetic_take(p, ','))
            continue;
        if (lw_arithmetic_peek(p) != ')')
            return lw_arithmetic_fault(p, p->at, "',' or ')' is expected in %s, not %s", f->form, lw_byte_name(lw_arithmetic_peek(p), buf));
        if (*n < f->least)
            return lw_arithmetic_fault(p, p->at, "something is missing: %s", f->form);
        p->at++;
        return LW_OK;
    }
}

/* ---- grammar ------------------------------------------------------------------------------------ */

static lw_status number(lw_arithmetic *p, lw_operand *out)
{
    size_t at = p->at, end = digits(p, at);
    if (lw_arithmetic_byte(p, end) == '.')
        end = digits(p, end + 1);
    int sign = lw_arithmetic_byte(p, end + 1);
    if ((lw_arithmetic_byte(p, end) == 'e' || lw_arithmetic_byte(p, end) == 'E')
        && (lw_is_digit(sign) || sign == '+' || sign == '-')) {
        end += lw_is_digit(sign) ? 1 : 2;
        if (digits(p, end) == end)
            return lw_arithmetic_fault(p, end, "the digits of an exponent are missing");
        end = digits(p, end);
    }
    double v = 0;
    lw_status s = lw_number_parse(p->text + at, end - at, &v);
    if (s != LW_OK)
        return lw_arithmetic_fault(p, at, s == LW_E_NUMERIC ? "this number is too large" : "this is no number");
    p->at = end;
    return p->language->number(p, at, v, out);
}

static lw_status primary(lw_arithmetic *p, lw_operand *out)
{
    int byte = lw_arithmetic_peek(p);
    size_t at = p->at;
    char buf[24];
    if (lw_is_digit(byte) || (byte == '.' && lw_is_digit(lw_arithmetic_byte(p, at + 1))))
        return number(p, out);
    if (byte != '(')
        return p->language->other(p, byte, out);
    p->at++;
    lw_status s = p->language->whole(p, out);
    if (s == LW_OK && !lw_arithmetic_take(p, ')'))
        s = lw_arithmetic_fault(p, p->at, "')' is expected, not %s: the bracket of column %zu is open",
                                lw_byte_name(lw_arithmetic_peek(p), buf), at + 1);
    return s;
}

static lw_status unary(lw_arithmetic *p, lw_operand *out)
{
    const lw_operand none = { -1, 0 };
    int byte = lw_arithmetic_peek(p);
    size_t at = p->at;
    if (p->depth == p->language->depth)
        return lw_arithmetic_fault(p, at, "too many brackets, signs or powers in each other: at most %d", p->language->depth);
    p->depth++;
    lw_status s;
    if (byte == '+' || byte == '-') {
        p->at++;
        s = unary(p, out);
        if (s == LW_OK && byte == '-')
            s = p->language->apply(p, at, LW_OP_NEGATE, *out, none, out);
    } else {
        s = primary(p, out);
        if (s == LW_OK && lw_arithmetic_peek(p) == '^') {
            lw_operand exponent = none;
            at = p->at++;
            s = unary(p, &exponent);
            if (s == LW_OK)
                s = p->language->apply(p, at, LW_OP_POWER, *out, exponent, out);
        }
    }
    p->depth--;
    return s;
}

static lw_status product(lw_arithmetic *p, lw_operand *out)
{
    lw_status s = unary(p, out);
    for (int byte; s == LW_OK && ((byte = lw_arithmetic_peek(p)) == '*' || byte == '/');) {
        size_t at = p->at++;
        lw_operand b = { -1, 0 };
        s = unary(p, &b);
        if (s == LW_OK)
            s = p->language->apply(p, at, byte == '*' ? LW_OP_MULTIPLY : LW_OP_DIVIDE, *out, b, out);
    }
    return s;
}

lw_status lw_arithmetic_sum(lw_arithmetic *p, lw_operand *out)
{
    lw_status s = product(p, out);
    for (int byte; s == LW_OK && ((byte = lw_arithmetic_peek(p)) == '+' || byte == '-');) {
        size_t at = p->at++;
        lw_operand b = { -1, 0 };
        s = product(p, &b);
        if (s == LW_OK)
            s = p->language->apply(p, at, byte == '+' ? LW_OP_ADD : LW_OP_SUBTRACT, *out, b, out);
    }
    return s;
}

lw_status lw_arithmetic_end(lw_arithmetic *p)
{
    char buf[24];
    int byte = lw_arithmetic_peek(p);
    if (byte < 0)
        return LW_OK;
    if (byte == ',')
        return lw_arithmetic_fault(p, p->at, "',' stands between arguments of a function only; numbers have a decimal point");
    if (byte == ')')
        return lw_arithmetic_fault(p, p->at, "this ')' closes nothing");
    if (lw_is_digit(byte) || lw_is_letter(byte) || byte == '(' || byte == '.')
        return lw_arithmetic_fault(p, p->at, "an operator is missing before %s", lw_byte_name(byte, buf));
    return lw_arithmetic_fault(p, p->at, "an operator or the end is expected, not %s", lw_byte_name(byte, buf));
}
