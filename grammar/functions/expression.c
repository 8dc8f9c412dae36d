/* grammar/functions/expression.c - text -> operations, by recursive descent:
 *
 *     sum     = product (("+" | "-") product)*
 *     product = unary (("*" | "/") unary)*
 *     unary   = ("+" | "-") unary | power
 *     power   = primary ("^" unary)?                        -2^2 is -4, 2^-1 is 0.5, 2^3^2 is 2^9
 *     primary = number | "(" sum ")" | "pi" | function "(" sum ("," sum)* ")" | word ("(" name ")")?
 *             | "profile" "(" name ("," sum)? ")" | "integral" "(" sum ("," number)? ")" | "lag" "(" sum "," number ("," number)? ")" */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/number.h"
#include "base/real.h"
#include "base/suggest.h"
#include "base/vec2.h"
#include "grammar/functions/expression_internal.h"
#include "grammar/text/text_internal.h"

#define DEPTH_MAX 100              /* nested brackets, repeated signs */
#define WORD_SIZE 64

typedef struct parser {
    const char    *text;
    size_t         size, at;
    int            depth;
    lw_expression *x;
    const lw_expression_words *words;
    lw_error      *e;
} parser;

typedef struct argument { lw_operand o; size_t at; } argument;     /* and where its text begins */

static const struct function { const char *name; lw_op op; int least, most; const char *form; } functions[] = {
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
    { "step",   LW_OP_STEP,   5, 5, "step(x, x0, h0, x1, h1)" },
    { "havsin", LW_OP_HAVSIN, 5, 5, "havsin(x, x0, h0, x1, h1)" },
    { "poly",   LW_OP_POLY,   3, 0, "poly(x, x0, a0, a1, ...)" },
    { "table",  LW_OP_TABLE,  5, 0, "table(x, x1, y1, x2, y2, ...)" },
};
enum { N_FUNCTION = sizeof functions/sizeof *functions };

static lw_status sum(parser *p, lw_operand *out);

/* ---- text -------------------------------------------------------------------------------------- */

__attribute__((format(printf, 3, 4)))
static lw_status fault(const parser *p, size_t at, const char *format, ...)
{
    char text[sizeof p->e->text];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    return lw_error_at(p->e, LW_E_NOTATION, "", 1, (long)at + 1, "%s", text);
}

static int peek(parser *p)
{
    while (p->at < p->size && strchr(" \t\r\n", p->text[p->at]) && p->text[p->at])
        p->at++;
    return p->at < p->size ? (unsigned char)p->text[p->at] : -1;
}

static bool take(parser *p, int byte)
{
    if (peek(p) != byte)
        return false;
    p->at++;
    return true;
}

static bool is_digit(int c) { return c >= '0' && c <= '9'; }
static bool is_letter(int c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

static int byte_at(const parser *p, size_t at)
{
    return at < p->size ? (unsigned char)p->text[at] : -1;
}

static size_t digits(const parser *p, size_t at)
{
    while (is_digit(byte_at(p, at)))
        at++;
    return at;
}

/* ---- operations -------------------------------------------------------------------------------- */

static lw_operand number(double v) { return (lw_operand){ -1, v }; }

/* Append an operation, or compute its value if all operands are constants.  `at`: its place in the text. */
static lw_status emit(parser *p, size_t at, lw_expression_node n, lw_operand *out)
{
    lw_expression *x = p->x;
    if (n.op != LW_OP_VARIABLE && n.a.node < 0 && n.b.node < 0) {
        *out = number(lw_op_value(x, &n, n.a.value, n.b.value));
        return isfinite(out->value) ? LW_OK
             : fault(p, at, "this is no finite number whatever the variables are");
    }
    if (x->n_node == LW_EXPRESSION_NODE_MAX)
        return fault(p, at, "the expression is too long: at most %d operations",
                     LW_EXPRESSION_NODE_MAX);
    x->node[x->n_node] = n;
    *out = (lw_operand){ x->n_node++, 0 };
    return LW_OK;
}

static lw_status binary(parser *p, size_t at, lw_op op, lw_operand a, lw_operand b, lw_operand *out)
{
    return emit(p, at, (lw_expression_node){ .op = op, .a = a, .b = b }, out);
}

static lw_status unary_op(parser *p, size_t at, lw_op op, lw_operand a, lw_operand *out)
{
    return emit(p, at, (lw_expression_node){ .op = op, .a = a, .b = number(0) }, out);
}

/* ---- functions expanded into operations --------------------------------------------------------------- */

/* h0 (1 - r) + h1 r,  r the ramp of u = (x - x0)/(x1 - x0).  This form gives h0 and h1 exactly at the ends. */
static lw_status spell_ramp(parser *p, size_t at, lw_op ramp, const argument *a, lw_operand *out)
{
    lw_operand x0 = a[1].o, x1 = a[3].o, top = x0, below = x1, r, rest;
    lw_status s;
    if (x0.node < 0 && x1.node < 0 && !(x0.value < x1.value))
        return fault(p, a[3].at, "x1 must be greater than x0");
    if ((s = binary(p, at, LW_OP_SUBTRACT, a[0].o, x0, &top)) != LW_OK
        || (s = binary(p, at, LW_OP_SUBTRACT, x1, x0, &below)) != LW_OK
        || (s = binary(p, at, LW_OP_DIVIDE, top, below, &r)) != LW_OK
        || (s = unary_op(p, at, ramp, r, &r)) != LW_OK
        || (s = binary(p, at, LW_OP_SUBTRACT, number(1), r, &rest)) != LW_OK
        || (s = binary(p, at, LW_OP_MULTIPLY, a[2].o, rest, &rest)) != LW_OK
        || (s = binary(p, at, LW_OP_MULTIPLY, a[4].o, r, &r)) != LW_OK)
        return s;
    return binary(p, at, LW_OP_ADD, rest, r, out);
}

/* Horner: a0 + d (a1 + d (a2 + ...)) */
static lw_status spell_poly(parser *p, size_t at, const argument *a, int n, lw_operand *out)
{
    lw_operand d, sum_of = a[n-1].o;
    lw_status s = binary(p, at, LW_OP_SUBTRACT, a[0].o, a[1].o, &d);
    for (int i = n - 2; s == LW_OK && i >= 2; i--)
        if ((s = binary(p, at, LW_OP_MULTIPLY, sum_of, d, &sum_of)) == LW_OK)
            s = binary(p, at, LW_OP_ADD, sum_of, a[i].o, &sum_of);
    *out = sum_of;
    return s;
}

static lw_status check_table(const parser *p, const argument *a, int n)
{
    if (n % 2 == 0)
        return fault(p, a[n-1].at, "this x has no y: table(x, x1, y1, x2, y2, ...)");
    for (int i = 1; i < n; i++) {
        if (a[i].o.node >= 0)
            return fault(p, a[i].at, "the points of a table are numbers, nothing that changes");
        if (i > 2 && i % 2 && !(a[i].o.value > a[i-2].o.value))
            return fault(p, a[i].at, "the x of a table must rise, but %g follows %g", a[i].o.value,
                         a[i-2].o.value);
    }
    return LW_OK;
}

static lw_status spell_table(parser *p, size_t at, const argument *a, int n, lw_operand *out)
{
    lw_expression *x = p->x;
    lw_status s = check_table(p, a, n);
    if (s != LW_OK)
        return s;
    size_t m = (size_t)n/2;
    lw_spline *more = realloc(x->spline, (size_t)(x->n_spline + 1)*sizeof *more);
    double *block = more ? malloc(4*m*sizeof *block) : NULL;
    if (more)
        x->spline = more;
    if (!block)
        return lw_error_set(p->e, LW_E_MEMORY, "out of memory for a table");
    lw_spline *spline = &x->spline[x->n_spline];
    *spline = (lw_spline){ (int)m, block, block + m, block + 2*m };
    for (size_t i = 0; i < m; i++) {
        spline->x[i] = a[1 + 2*i].o.value;
        spline->y[i] = a[2 + 2*i].o.value;
    }
    lw_spline_bend((int)m, spline->x, spline->y, block + 3*m, spline->bend);
    for (size_t i = 0; i < m; i++)
        if (!isfinite(spline->bend[i])) {
            free(block);
            return fault(p, at, "the points of this table are too far apart, or too close, to compute with");
        }
    x->n_spline++;
    return emit(p, at, (lw_expression_node){ .op = LW_OP_SPLINE, .index = x->n_spline - 1, .a = a[0].o,
                                  .b = number(0) }, out);
}

static lw_status call(parser *p, size_t at, const struct function *f, const argument *a, int n,
                      lw_operand *out)
{
    lw_status s = LW_OK;
    switch (f->op) {
    case LW_OP_STEP:   return spell_ramp(p, at, LW_OP_CUBIC, a, out);
    case LW_OP_HAVSIN: return spell_ramp(p, at, LW_OP_HALF_SINE, a, out);
    case LW_OP_POLY:   return spell_poly(p, at, a, n, out);
    case LW_OP_TABLE:  return spell_table(p, at, a, n, out);
    default:
        if (f->most == 1)
            return unary_op(p, at, f->op, a[0].o, out);
        *out = a[0].o;
        for (int i = 1; s == LW_OK && i < n; i++)
            s = binary(p, at, f->op, *out, a[i].o, out);
        return s;
    }
}

/* ---- grammar ------------------------------------------------------------------------------------ */

/* Read the arguments and the closing bracket; the opening one is read.  *list grows; the caller frees it. */
static lw_status arguments(parser *p, const struct function *f, argument **list, int *n)
{
    for (int room = 0;;) {
        if (*n == room) {
            room = room ? 2*room : 8;
            argument *more = realloc(*list, (size_t)room*sizeof *more);
            if (!more)
                return lw_error_set(p->e, LW_E_MEMORY, "out of memory for an expression");
            *list = more;
        }
        peek(p);
        argument *a = &(*list)[*n];
        a->at = p->at;
        if (f->most && *n == f->most)
            return fault(p, p->at, "this is one too many: %s", f->form);
        lw_status s = sum(p, &a->o);
        if (s != LW_OK)
            return s;
        ++*n;
        if (take(p, ','))
            continue;
        char buf[24];
        if (peek(p) != ')')
            return fault(p, p->at, "',' or ')' is expected in %s, not %s", f->form,
                         lw_byte_name(peek(p), buf));
        if (*n < f->least)
            return fault(p, p->at, "something is missing: %s", f->form);
        p->at++;
        return LW_OK;
    }
}

static lw_status function_call(parser *p, size_t at, const struct function *f, lw_operand *out)
{
    argument *list = NULL;
    int n = 0;
    if (!take(p, '('))
        return fault(p, p->at, "'(' is expected: %s", f->form);
    lw_status s = arguments(p, f, &list, &n);
    if (s == LW_OK)
        s = call(p, at, f, list, n, out);
    free(list);
    return s;
}

/* Read the name of a variable after its opening bracket: up to ')', without surrounding blanks, or in '...'. */
static lw_status name_of(parser *p, char name[WORD_SIZE], size_t *name_at)
{
    peek(p);
    char stop = ')';
    if (byte_at(p, p->at) == '\'') {
        stop = '\'';
        p->at++;
    }
    size_t end = *name_at = p->at;
    while (byte_at(p, end) >= ' ' && byte_at(p, end) != stop)
        end++;
    if (byte_at(p, end) != stop)
        return fault(p, end, "%c is missing behind a name", stop);
    p->at = end + 1;
    while (stop == ')' && end > *name_at && p->text[end-1] == ' ')
        end--;
    if (end == *name_at || end - *name_at >= WORD_SIZE)
        return fault(p, *name_at, "a name of 1 to %d bytes is expected", WORD_SIZE - 1);
    memcpy(name, p->text + *name_at, end - *name_at);
    name[end - *name_at] = '\0';
    return stop == '\'' && !take(p, ')') ? fault(p, p->at, "')' is missing behind a name") : LW_OK;
}

static const char *near_function(const char *word)
{
    enum { MORE = 4 };
    const char *words[N_FUNCTION + MORE] = { "pi", "integral", "lag", "profile" };
    for (int i = 0; i < N_FUNCTION; i++)
        words[i + MORE] = functions[i].name;
    return lw_suggest(word, words, N_FUNCTION + MORE);
}

static lw_status unknown(const parser *p, const char *word, size_t at)
{
    const char *near = near_function(word);
    return fault(p, at, "there is no function or variable %s here%s%s%s", word,
                 near ? "; did you mean " : "", near ? near : "", near ? "?" : "");
}

/* The operation that fetches the variable with the caller's number `id`; each variable has one. */
static lw_status variable(parser *p, size_t at, int id, lw_operand *out)
{
    lw_expression *x = p->x;
    for (int i = 0; i < x->n_variable; i++)
        if (x->variable[i] == id) {
            for (int k = 0; k < x->n_node; k++)
                if (x->node[k].op == LW_OP_VARIABLE && x->node[k].index == i)
                    *out = (lw_operand){ k, 0 };
            return LW_OK;
        }
    if (x->n_variable == LW_EXPRESSION_VARIABLE_MAX)
        return fault(p, at, "the expression depends on too many quantities: at most %d",
                     LW_EXPRESSION_VARIABLE_MAX);
    x->variable[x->n_variable] = id;
    return emit(p, at, (lw_expression_node){ .op = LW_OP_VARIABLE, .index = x->n_variable++, .a = number(0),
                                  .b = number(0) }, out);
}

static lw_status add_moves(lw_expression *x, const struct lw_moves *moves)
{
    const struct lw_moves **more = realloc(x->moves, ((size_t)x->n_moves + 1)*sizeof *more);
    if (!more)
        return LW_E_MEMORY;
    x->moves = more;
    more[x->n_moves++] = moves;
    return LW_OK;
}

/* profile(name) or profile(name, x); the opening bracket is next. */
static lw_status profile(parser *p, size_t at, lw_operand *out)
{
    char name[WORD_SIZE], why[128] = "";
    if (!p->words->moves)
        return fault(p, at, "profile is possible in model files only");
    if (!take(p, '('))
        return fault(p, p->at, "'(' is expected: profile(name) or profile(name, x)");
    peek(p);
    size_t begin = p->at, end = begin;
    while (byte_at(p, end) >= ' ' && byte_at(p, end) != ')' && byte_at(p, end) != ',')
        end++;
    p->at = end;
    while (end > begin && p->text[end - 1] == ' ')
        end--;
    if (end == begin || end - begin >= WORD_SIZE)
        return fault(p, begin, "the name of a profile is expected");
    memcpy(name, p->text + begin, end - begin);
    name[end - begin] = '\0';
    const struct lw_moves *moves = p->words->moves(p->words->context, name);
    if (!moves)
        return fault(p, begin, "there is no profile \"%s\"", name);
    lw_operand u;
    lw_status s;
    if (take(p, ','))
        s = sum(p, &u);
    else {
        int id = p->words->variable ? p->words->variable(p->words->context, "t", NULL, why) : -1;
        s = id >= 0 ? variable(p, at, id, &u) : fault(p, at, "there is no t here: profile(name, x)");
    }
    if (s != LW_OK)
        return s;
    if (!take(p, ')'))
        return fault(p, p->at, "')' is expected: profile(name) or profile(name, x)");
    if (add_moves(p->x, moves) != LW_OK)
        return lw_error_set(p->e, LW_E_MEMORY, "out of memory for an expression");
    return emit(p, at, (lw_expression_node){ .op = LW_OP_MOVES, .index = p->x->n_moves - 1, .a = u, .b = number(0) }, out);
}

/* Append the operations of y, whose variables are looked up in both by the caller's numbers. */
static lw_status insert(parser *p, size_t at, const lw_expression *y, lw_operand *out)
{
    lw_expression *x = p->x;
    lw_operand *to = malloc(((size_t)y->n_node + 1)*sizeof *to);
    lw_spline *more = realloc(x->spline, ((size_t)x->n_spline + (size_t)y->n_spline + 1)*sizeof *more);
    int first = x->n_spline;
    x->spline = more ? more : x->spline;
    lw_status s = to && more ? LW_OK : LW_E_MEMORY;
    for (int i = 0; s == LW_OK && i < y->n_spline; i++) {
        size_t n = 4*(size_t)y->spline[i].n;
        double *block = malloc(n*sizeof *block);
        if (!block) {
            s = LW_E_MEMORY;
            break;
        }
        memcpy(block, y->spline[i].x, n*sizeof *block);
        x->spline[x->n_spline++] = (lw_spline){ y->spline[i].n, block, block + n/4, block + n/2 };
    }
    int first_moves = x->n_moves;
    for (int i = 0; s == LW_OK && i < y->n_moves; i++)
        s = add_moves(x, y->moves[i]);
    for (int i = 0; s == LW_OK && i < y->n_node; i++) {
        lw_expression_node n = y->node[i];
        if (n.op == LW_OP_VARIABLE) {
            s = variable(p, at, y->variable[n.index], &to[i]);
            continue;
        }
        n.index += n.op == LW_OP_SPLINE ? first : n.op == LW_OP_MOVES ? first_moves : 0;
        n.a = n.a.node < 0 ? n.a : to[n.a.node];
        n.b = n.b.node < 0 ? n.b : to[n.b.node];
        s = emit(p, at, n, &to[i]);
    }
    if (s == LW_OK)
        *out = y->result.node < 0 ? y->result : to[y->result.node];
    free(to);
    return s == LW_E_MEMORY ? lw_error_set(p->e, s, "out of memory for an expression") : s;
}

/* A constant argument behind a ','. */
static lw_status constant(parser *p, double *out)
{
    lw_operand o;
    peek(p);
    size_t at = p->at;
    lw_status s = sum(p, &o);
    if (s == LW_OK && o.node >= 0)
        return fault(p, at, "a number is expected here, nothing that changes");
    *out = s == LW_OK ? o.value : 0;
    return s;
}

static lw_expression *new_expression(const char *text, size_t size);

/* integral(x, start), lag(x, time, start): x becomes an expression of its own. */
static lw_status integral(parser *p, size_t at, bool lags, lw_operand *out)
{
    const char *form = lags ? "lag(x, time) or lag(x, time, start)" : "integral(x) or integral(x, start)";
    double lag = 0, start = NAN;
    if (!p->words->integrate)
        return fault(p, at, "%s is possible in forces, voltages, valves and controllers only", lags ? "lag" : "integral");
    if (!take(p, '('))
        return fault(p, p->at, "'(' is expected: %s", form);
    parser inner = *p;
    peek(&inner);
    size_t begin = inner.at;
    inner.x = new_expression(p->text, p->size);
    if (!inner.x)
        return lw_error_set(p->e, LW_E_MEMORY, "out of memory for an expression");
    lw_status s = p->depth < DEPTH_MAX ? LW_OK : fault(p, at, "too many brackets in each other: at most %d", DEPTH_MAX);
    inner.depth++;
    if (s == LW_OK)
        s = sum(&inner, &inner.x->result);
    p->at = inner.at;
    if (s == LW_OK) {                                     /* its text is its own part */
        memmove(inner.x->text, inner.x->text + begin, p->at - begin);
        inner.x->text[p->at - begin] = '\0';
    }
    if (s == LW_OK && lags && !take(p, ','))
        s = fault(p, p->at, "something is missing: %s", form);
    size_t time_at = p->at;
    if (s == LW_OK && lags && (s = constant(p, &lag)) == LW_OK && !(lag > 0))
        s = fault(p, time_at, "the time of a lag must be greater than 0 s");
    if (s == LW_OK && take(p, ','))
        s = constant(p, &start);
    if (s == LW_OK && !take(p, ')'))
        s = fault(p, p->at, "')' is expected: %s", form);
    if (s != LW_OK) {
        lw_expression_free(inner.x);
        return s;
    }
    int id = p->words->integrate(p->words->context, inner.x, lag, start);
    return id < 0 ? lw_error_set(p->e, LW_E_MEMORY, "out of memory for an expression") : variable(p, at, id, out);
}

static lw_status word(parser *p, lw_operand *out)
{
    char text[WORD_SIZE], name[WORD_SIZE], why[128] = "";
    size_t at = p->at, end = at, name_at = 0;
    while (is_letter(byte_at(p, end)) || is_digit(byte_at(p, end)))
        end++;
    if (end - at >= WORD_SIZE)
        return fault(p, at, "this word is too long");
    memcpy(text, p->text + at, end - at);
    text[end - at] = '\0';
    p->at = end;
    if (strcmp(text, "pi") == 0) {
        *out = number(LW_PI);
        return LW_OK;
    }
    for (int i = 0; i < N_FUNCTION; i++)
        if (strcmp(text, functions[i].name) == 0)
            return function_call(p, at, &functions[i], out);
    if (strcmp(text, "profile") == 0)
        return profile(p, at, out);
    if (strcmp(text, "integral") == 0 || strcmp(text, "lag") == 0)
        return integral(p, at, text[0] == 'l', out);
    bool named = peek(p) == '(', function = named && near_function(text);
    if (named) {
        p->at++;
        lw_status s = name_of(p, name, &name_at);
        if (s != LW_OK)                                   /* a misspelt function: its arguments are no name */
            return function ? unknown(p, text, at) : s;
    }
    const lw_expression_words *w = p->words;
    const lw_expression *known = w->insert ? w->insert(w->context, text, named ? name : NULL) : NULL;
    if (known)
        return insert(p, at, known, out);
    int id = w->variable ? w->variable(w->context, text, named ? name : NULL, why) : -1;
    if (id >= 0)
        return variable(p, at, id, out);
    return why[0] && !function ? fault(p, named ? name_at : at, "%s", why) : unknown(p, text, at);
}

static lw_status read_number(parser *p, lw_operand *out)
{
    size_t at = p->at, end = digits(p, at);
    if (byte_at(p, end) == '.')
        end = digits(p, end + 1);
    int sign = byte_at(p, end + 1);
    if ((byte_at(p, end) == 'e' || byte_at(p, end) == 'E')
        && (is_digit(sign) || sign == '+' || sign == '-')) {
        end += is_digit(sign) ? 1 : 2;
        if (digits(p, end) == end)
            return fault(p, end, "the digits of an exponent are missing");
        end = digits(p, end);
    }
    double v = 0;
    lw_status s = lw_number_parse(p->text + at, end - at, &v);
    if (s != LW_OK)
        return fault(p, at, s == LW_E_NUMERIC ? "this number is too large" : "this is no number");
    p->at = end;
    *out = number(v);
    return LW_OK;
}

static lw_status primary(parser *p, lw_operand *out)
{
    int byte = peek(p);
    size_t at = p->at;
    char buf[24];
    if (is_digit(byte) || (byte == '.' && is_digit(byte_at(p, at + 1))))
        return read_number(p, out);
    if (is_letter(byte))
        return word(p, out);
    if (byte != '(')
        return fault(p, at, "a number, a word or '(' is expected, not %s", lw_byte_name(byte, buf));
    p->at++;
    lw_status s = sum(p, out);
    if (s == LW_OK && !take(p, ')'))
        s = fault(p, p->at, "')' is expected, not %s: the bracket of column %zu is open",
                  lw_byte_name(peek(p), buf), at + 1);
    return s;
}

static lw_status unary(parser *p, lw_operand *out)
{
    int byte = peek(p);
    size_t at = p->at;
    if (p->depth == DEPTH_MAX)
        return fault(p, at, "too many brackets, signs or powers in each other: at most %d", DEPTH_MAX);
    p->depth++;
    lw_status s;
    if (byte == '+' || byte == '-') {
        p->at++;
        s = unary(p, out);
        if (s == LW_OK && byte == '-')
            s = unary_op(p, at, LW_OP_NEGATE, *out, out);
    } else {
        s = primary(p, out);
        if (s == LW_OK && peek(p) == '^') {
            lw_operand exponent;
            at = p->at++;
            s = unary(p, &exponent);
            if (s == LW_OK)
                s = binary(p, at, LW_OP_POWER, *out, exponent, out);
        }
    }
    p->depth--;
    return s;
}

static lw_status product(parser *p, lw_operand *out)
{
    lw_status s = unary(p, out);
    for (int byte; s == LW_OK && ((byte = peek(p)) == '*' || byte == '/');) {
        size_t at = p->at++;
        lw_operand b;
        s = unary(p, &b);
        if (s == LW_OK)
            s = binary(p, at, byte == '*' ? LW_OP_MULTIPLY : LW_OP_DIVIDE, *out, b, out);
    }
    return s;
}

static lw_status sum(parser *p, lw_operand *out)
{
    lw_status s = product(p, out);
    for (int byte; s == LW_OK && ((byte = peek(p)) == '+' || byte == '-');) {
        size_t at = p->at++;
        lw_operand b;
        s = product(p, &b);
        if (s == LW_OK)
            s = binary(p, at, byte == '+' ? LW_OP_ADD : LW_OP_SUBTRACT, *out, b, out);
    }
    return s;
}

/* The error for text after a complete expression. */
static lw_status left_over(parser *p)
{
    char buf[24];
    int byte = peek(p);
    if (byte < 0)
        return LW_OK;
    if (byte == ',')
        return fault(p, p->at, "',' stands between arguments of a function only; numbers have a decimal point");
    if (byte == ')')
        return fault(p, p->at, "this ')' closes nothing");
    if (is_digit(byte) || is_letter(byte) || byte == '(' || byte == '.')
        return fault(p, p->at, "an operator is missing before %s", lw_byte_name(byte, buf));
    return fault(p, p->at, "an operator or the end is expected, not %s", lw_byte_name(byte, buf));
}

/* Room for the most operations; a copy of the text.  NULL: out of memory. */
static lw_expression *new_expression(const char *text, size_t size)
{
    lw_expression *x = calloc(1, sizeof *x + LW_EXPRESSION_NODE_MAX*sizeof *x->node);
    if (x)
        x->text = malloc(size + 1);
    if (!x || !x->text) {
        free(x);
        return NULL;
    }
    if (size)
        memcpy(x->text, text, size);
    x->text[size] = '\0';
    return x;
}

lw_status lw_expression_parse(const char *text, size_t size, lw_expression_lookup *lookup,
                              void *context, lw_expression **out, lw_error *e)
{
    return lw_expression_parse_words(text, size, &(lw_expression_words){ .context = context, .variable = lookup }, out, e);
}

lw_status lw_expression_parse_words(const char *text, size_t size, const lw_expression_words *words, lw_expression **out,
                                    lw_error *e)
{
    *out = NULL;
    lw_expression *x = new_expression(text, size);
    if (!x)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for an expression");
    parser p = { .text = x->text, .size = size, .x = x, .words = words, .e = e };
    lw_status s = sum(&p, &x->result);
    if (s == LW_OK)
        s = left_over(&p);
    if (s != LW_OK) {
        lw_expression_free(x);
        return s;
    }
    lw_expression *fit = realloc(x, sizeof *x + (size_t)x->n_node*sizeof *x->node);
    *out = fit ? fit : x;
    return LW_OK;
}

void lw_expression_free(lw_expression *x)
{
    if (!x)
        return;
    for (int i = 0; i < x->n_spline; i++)
        free(x->spline[i].x);
    free(x->spline);
    free(x->moves);
    free(x->text);
    free(x);
}

int lw_expression_variables(const lw_expression *x, const int **which)
{
    if (which)
        *which = x->variable;
    return x->n_variable;
}

const char *lw_expression_text(const lw_expression *x) { return x->text; }
