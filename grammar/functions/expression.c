/* grammar/functions/expression.c - text -> operations (grammar/functions/arithmetic_internal.h); besides what formulas have, too:
 *
 *     primary = "pi" | word ("(" name ")")? | "profile" "(" name ("," sum)? ")"
 *             | "integral" "(" sum ("," number)? ")" | "lag" "(" sum "," number ("," number)? ")" */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/spline.h"
#include "base/vec2.h"
#include "grammar/functions/expression_internal.h"
#include "grammar/text/text_internal.h"

typedef lw_arithmetic parser;

static const lw_math_function functions[] = {
    { "integral", LW_OP_INTEGRAL, 1, 2, "integral(x) or integral(x, start)" },
    { "lag",      LW_OP_LAG,      2, 3, "lag(x, time) or lag(x, time, start)" },
    { "profile",  LW_OP_MOVES,    1, 2, "profile(name) or profile(name, x)" },
    { "step",     LW_OP_STEP,     5, 5, "step(x, x0, h0, x1, h1)" },
    { "havsin",   LW_OP_HAVSIN,   5, 5, "havsin(x, x0, h0, x1, h1)" },
    { "poly",     LW_OP_POLY,     3, 0, "poly(x, x0, a0, a1, ...)" },
    { "table",    LW_OP_TABLE,    5, 0, "table(x, x1, y1, x2, y2, ...)" },
};

/* ---- operations -------------------------------------------------------------------------------- */

static lw_operand number(double v) { return (lw_operand){ -1, v }; }

/* Append an operation, or compute its value if all operands are constants.  `at`: its place in the text. */
static lw_status emit(parser *p, size_t at, lw_expression_node n, lw_operand *out)
{
    lw_expression *x = p->made;
    if (n.op != LW_OP_VARIABLE && n.a.node < 0 && n.b.node < 0) {
        *out = number(lw_op_value(x, &n, n.a.value, n.b.value));
        return isfinite(out->value) ? LW_OK
             : lw_arithmetic_fault(p, at, "this is no finite number whatever the variables are");
    }
    if (x->n_node == LW_EXPRESSION_NODE_MAX)
        return lw_arithmetic_fault(p, at, "the expression is too long: at most %d operations", LW_EXPRESSION_NODE_MAX);
    x->node[x->n_node] = n;
    *out = (lw_operand){ x->n_node++, 0 };
    return LW_OK;
}

/* b is a constant where op has one operand. */
static lw_status apply(parser *p, size_t at, lw_op op, lw_operand a, lw_operand b, lw_operand *out)
{
    return emit(p, at, (lw_expression_node){ .op = op, .a = a, .b = b }, out);
}

/* ---- functions expanded into operations --------------------------------------------------------------- */

/* h0 (1 - r) + h1 r,  r the ramp of u = (x - x0)/(x1 - x0).  This form gives h0 and h1 exactly at the ends. */
static lw_status spell_ramp(parser *p, size_t at, lw_op ramp, const lw_argument *a, lw_operand *out)
{
    lw_operand x0 = a[1].o, x1 = a[3].o, top = x0, below = x1, r, rest;
    lw_status s;
    if (x0.node < 0 && x1.node < 0 && !(x0.value < x1.value))
        return lw_arithmetic_fault(p, a[3].at, "x1 must be greater than x0");
    if ((s = apply(p, at, LW_OP_SUBTRACT, a[0].o, x0, &top)) != LW_OK
        || (s = apply(p, at, LW_OP_SUBTRACT, x1, x0, &below)) != LW_OK
        || (s = apply(p, at, LW_OP_DIVIDE, top, below, &r)) != LW_OK
        || (s = apply(p, at, ramp, r, number(0), &r)) != LW_OK
        || (s = apply(p, at, LW_OP_SUBTRACT, number(1), r, &rest)) != LW_OK
        || (s = apply(p, at, LW_OP_MULTIPLY, a[2].o, rest, &rest)) != LW_OK
        || (s = apply(p, at, LW_OP_MULTIPLY, a[4].o, r, &r)) != LW_OK)
        return s;
    return apply(p, at, LW_OP_ADD, rest, r, out);
}

/* Horner: a0 + d (a1 + d (a2 + ...)) */
static lw_status spell_poly(parser *p, size_t at, const lw_argument *a, int n, lw_operand *out)
{
    lw_operand d, sum_of = a[n-1].o;
    lw_status s = apply(p, at, LW_OP_SUBTRACT, a[0].o, a[1].o, &d);
    for (int i = n - 2; s == LW_OK && i >= 2; i--)
        if ((s = apply(p, at, LW_OP_MULTIPLY, sum_of, d, &sum_of)) == LW_OK)
            s = apply(p, at, LW_OP_ADD, sum_of, a[i].o, &sum_of);
    *out = sum_of;
    return s;
}

static lw_status check_table(const parser *p, const lw_argument *a, int n)
{
    if (n % 2 == 0)
        return lw_arithmetic_fault(p, a[n-1].at, "this x has no y: table(x, x1, y1, x2, y2, ...)");
    for (int i = 1; i < n; i++) {
        if (a[i].o.node >= 0)
            return lw_arithmetic_fault(p, a[i].at, "the points of a table are numbers, nothing that changes");
        if (i > 2 && i % 2 && !(a[i].o.value > a[i-2].o.value))
            return lw_arithmetic_fault(p, a[i].at, "the x of a table must rise, but %g follows %g", a[i].o.value, a[i-2].o.value);
    }
    return LW_OK;
}

static lw_status spell_table(parser *p, size_t at, const lw_argument *a, int n, lw_operand *out)
{
    lw_expression *x = p->made;
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
    lw_spline_bend((int)m, spline->x, spline->y, (const double[]){ NAN, NAN }, block + 3*m, spline->bend);
    for (size_t i = 0; i < m; i++)
        if (!isfinite(spline->bend[i])) {
            free(block);
            return lw_arithmetic_fault(p, at, "the points of this table are too far apart, or too close, to compute with");
        }
    x->n_spline++;
    return emit(p, at, (lw_expression_node){ .op = LW_OP_SPLINE, .index = x->n_spline - 1, .a = a[0].o,
                                  .b = number(0) }, out);
}

static lw_status function_call(parser *p, size_t at, const lw_math_function *f, lw_operand *out)
{
    lw_argument *a;
    int n;
    lw_status s = lw_arithmetic_arguments(p, f, &a, &n);
    if (s == LW_OK)
        *out = a[0].o;
    if (s == LW_OK && (f->op == LW_OP_STEP || f->op == LW_OP_HAVSIN))
        s = spell_ramp(p, at, f->op == LW_OP_STEP ? LW_OP_CUBIC : LW_OP_HALF_SINE, a, out);
    else if (s == LW_OK && f->op == LW_OP_POLY)
        s = spell_poly(p, at, a, n, out);
    else if (s == LW_OK && f->op == LW_OP_TABLE)
        s = spell_table(p, at, a, n, out);
    else if (s == LW_OK && n == 1)
        s = apply(p, at, (lw_op)f->op, *out, number(0), out);
    else
        for (int i = 1; s == LW_OK && i < n; i++)
            s = apply(p, at, (lw_op)f->op, *out, a[i].o, out);
    free(a);
    return s;
}

/* ---- words -------------------------------------------------------------------------------------- */

/* Read the name of a variable after its opening bracket: up to ')', without surrounding blanks, or in '...'. */
static lw_status name_of(parser *p, char name[LW_WORD_SIZE], size_t *name_at)
{
    lw_arithmetic_peek(p);
    char stop = ')';
    if (lw_arithmetic_byte(p, p->at) == '\'') {
        stop = '\'';
        p->at++;
    }
    size_t end = *name_at = p->at;
    while (lw_arithmetic_byte(p, end) >= ' ' && lw_arithmetic_byte(p, end) != stop)
        end++;
    if (lw_arithmetic_byte(p, end) != stop)
        return lw_arithmetic_fault(p, end, "%c is missing behind a name", stop);
    p->at = end + 1;
    while (stop == ')' && end > *name_at && p->text[end-1] == ' ')
        end--;
    if (end == *name_at || end - *name_at >= LW_WORD_SIZE)
        return lw_arithmetic_fault(p, *name_at, "a name of 1 to %d bytes is expected", LW_WORD_SIZE - 1);
    memcpy(name, p->text + *name_at, end - *name_at);
    name[end - *name_at] = '\0';
    return stop == '\'' && !lw_arithmetic_take(p, ')') ? lw_arithmetic_fault(p, p->at, "')' is missing behind a name") : LW_OK;
}

/* The operation that fetches the variable with the caller's number `id`; each variable has one. */
static lw_status variable(parser *p, size_t at, int id, lw_operand *out)
{
    lw_expression *x = p->made;
    for (int i = 0; i < x->n_variable; i++)
        if (x->variable[i] == id) {
            for (int k = 0; k < x->n_node; k++)
                if (x->node[k].op == LW_OP_VARIABLE && x->node[k].index == i)
                    *out = (lw_operand){ k, 0 };
            return LW_OK;
        }
    if (x->n_variable == LW_EXPRESSION_VARIABLE_MAX)
        return lw_arithmetic_fault(p, at, "the expression depends on too many quantities: at most %d", LW_EXPRESSION_VARIABLE_MAX);
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
    char name[LW_WORD_SIZE], why[128] = "";
    const lw_expression_words *w = p->words;
    if (!w->moves)
        return lw_arithmetic_fault(p, at, "profile is possible in model files only");
    if (!lw_arithmetic_take(p, '('))
        return lw_arithmetic_fault(p, p->at, "'(' is expected: profile(name) or profile(name, x)");
    lw_arithmetic_peek(p);
    size_t begin = p->at, end = begin;
    while (lw_arithmetic_byte(p, end) >= ' ' && lw_arithmetic_byte(p, end) != ')' && lw_arithmetic_byte(p, end) != ',')
        end++;
    p->at = end;
    while (end > begin && p->text[end - 1] == ' ')
        end--;
    if (end == begin || end - begin >= LW_WORD_SIZE)
        return lw_arithmetic_fault(p, begin, "the name of a profile is expected");
    memcpy(name, p->text + begin, end - begin);
    name[end - begin] = '\0';
    const struct lw_moves *moves = w->moves(w->context, name);
    if (!moves)
        return lw_arithmetic_fault(p, begin, "there is no profile \"%s\"", name);
    lw_operand u;
    lw_status s;
    if (lw_arithmetic_take(p, ','))
        s = lw_arithmetic_sum(p, &u);
    else {
        int id = w->variable ? w->variable(w->context, "t", NULL, why) : -1;
        s = id >= 0 ? variable(p, at, id, &u) : lw_arithmetic_fault(p, at, "there is no t here: profile(name, x)");
    }
    if (s != LW_OK)
        return s;
    if (!lw_arithmetic_take(p, ')'))
        return lw_arithmetic_fault(p, p->at, "')' is expected: profile(name) or profile(name, x)");
    if (add_moves(p->made, moves) != LW_OK)
        return lw_error_set(p->e, LW_E_MEMORY, "out of memory for an expression");
    return emit(p, at, (lw_expression_node){ .op = LW_OP_MOVES, .index = ((lw_expression *)p->made)->n_moves - 1, .a = u, .b = number(0) }, out);
}

/* Append the operations of y, whose variables are looked up in both by the caller's numbers. */
static lw_status insert(parser *p, size_t at, const lw_expression *y, lw_operand *out)
{
    lw_expression *x = p->made;
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
    lw_arithmetic_peek(p);
    size_t at = p->at;
    lw_status s = lw_arithmetic_sum(p, &o);
    if (s == LW_OK && o.node >= 0)
        return lw_arithmetic_fault(p, at, "a number is expected here, nothing that changes");
    *out = s == LW_OK ? o.value : 0;
    return s;
}

static lw_expression *new_expression(const char *text, size_t size);

/* integral(x, start), lag(x, time, start): x becomes an expression of its own. */
static lw_status integral(parser *p, size_t at, const lw_math_function *f, lw_operand *out)
{
    const lw_expression_words *w = p->words;
    bool lags = f->op == LW_OP_LAG;
    double lag = 0, start = NAN;
    if (!w->integrate)
        return lw_arithmetic_fault(p, at, "%s is possible in forces, voltages, valves and controllers only", lags ? "lag" : "integral");
    if (!lw_arithmetic_take(p, '('))
        return lw_arithmetic_fault(p, p->at, "'(' is expected: %s", f->form);
    parser inner = *p;
    lw_arithmetic_peek(&inner);
    size_t begin = inner.at;
    lw_expression *x = inner.made = new_expression(p->text, p->size);
    if (!x)
        return lw_error_set(p->e, LW_E_MEMORY, "out of memory for an expression");
    lw_status s = p->depth < p->language->depth ? LW_OK : lw_arithmetic_fault(p, at, "too many brackets in each other: at most %d", p->language->depth);
    inner.depth++;
    if (s == LW_OK)
        s = lw_arithmetic_sum(&inner, &x->result);
    p->at = inner.at;
    if (s == LW_OK) {                                     /* its text is its own part */
        memmove(x->text, x->text + begin, p->at - begin);
        x->text[p->at - begin] = '\0';
    }
    if (s == LW_OK && lags && !lw_arithmetic_take(p, ','))
        s = lw_arithmetic_fault(p, p->at, "something is missing: %s", f->form);
    size_t time_at = p->at;
    if (s == LW_OK && lags && (s = constant(p, &lag)) == LW_OK && !(lag > 0))
        s = lw_arithmetic_fault(p, time_at, "the time of a lag must be greater than 0 s");
    if (s == LW_OK && lw_arithmetic_take(p, ','))
        s = constant(p, &start);
    if (s == LW_OK && !lw_arithmetic_take(p, ')'))
        s = lw_arithmetic_fault(p, p->at, "')' is expected: %s", f->form);
    if (s != LW_OK) {
        lw_expression_free(x);
        return s;
    }
    int id = w->integrate(w->context, x, lag, start);
    return id < 0 ? lw_error_set(p->e, LW_E_MEMORY, "out of memory for an expression") : variable(p, at, id, out);
}

static lw_status word(parser *p, int byte, lw_operand *out)
{
    char text[LW_WORD_SIZE], name[LW_WORD_SIZE], why[128] = "", buf[24];
    size_t at = p->at, name_at = 0;
    if (byte == '*' && at > 0 && p->text[at - 1] == '*')
        return lw_arithmetic_fault(p, at, "a power is written a^b, not a**b");
    if (!lw_is_letter(byte))
        return lw_arithmetic_fault(p, at, "a number, a word or '(' is expected, not %s", lw_byte_name(byte, buf));
    lw_status s = lw_arithmetic_word(p, text);
    if (s != LW_OK)
        return s;
    if (strcmp(text, "pi") == 0) {
        *out = number(LW_PI);
        return LW_OK;
    }
    const lw_math_function *f = lw_arithmetic_function(p, text);
    if (f)
        return f->op == LW_OP_MOVES ? profile(p, at, out) : f->op == LW_OP_INTEGRAL || f->op == LW_OP_LAG ? integral(p, at, f, out)
             : function_call(p, at, f, out);
    bool named = lw_arithmetic_peek(p) == '(', function = named && lw_arithmetic_near(p, text);
    if (named) {
        p->at++;
        s = name_of(p, name, &name_at);
        if (s != LW_OK)                                   /* a misspelt function: its arguments are no name */
            return function ? lw_arithmetic_unknown(p, text, at) : s;
    }
    const lw_expression_words *w = p->words;
    const lw_expression *known = w->insert ? w->insert(w->context, text, named ? name : NULL) : NULL;
    if (known)
        return insert(p, at, known, out);
    int id = w->variable ? w->variable(w->context, text, named ? name : NULL, why) : -1;
    if (id >= 0)
        return variable(p, at, id, out);
    return why[0] && !function ? lw_arithmetic_fault(p, named ? name_at : at, "%s", why) : lw_arithmetic_unknown(p, text, at);
}

static lw_status number_read(parser *p, size_t at, double value, lw_operand *out)
{
    (void)p, (void)at;
    *out = number(value);
    return LW_OK;
}

static const lw_language language = { .words = "function or variable", .depth = 100, .function = functions,
    .n_function = sizeof functions/sizeof *functions, .whole = lw_arithmetic_sum, .number = number_read, .other = word, .apply = apply };

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

lw_status lw_expression_parse(const char *text, size_t size, lw_expression_lookup *lookup, void *context, lw_expression **out, lw_error *e)
{
    return lw_expression_parse_words(text, size, &(lw_expression_words){ .context = context, .variable = lookup }, out, e);
}

lw_status lw_expression_parse_words(const char *text, size_t size, const lw_expression_words *words, lw_expression **out, lw_error *e)
{
    *out = NULL;
    lw_expression *x = new_expression(text, size);
    if (!x)
        return lw_error_set(e, LW_E_MEMORY, "out of memory for an expression");
    parser p = { .text = x->text, .size = size, .language = &language, .made = x, .words = words, .e = e };
    lw_status s = lw_arithmetic_sum(&p, &x->result);
    if (s == LW_OK)
        s = lw_arithmetic_end(&p);
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
