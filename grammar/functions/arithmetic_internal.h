/* grammar/functions/arithmetic_internal.h - what expressions (expression.h) and formulas (formula.h) have in common, by recursive descent:
 *
 *     sum     = product (("+" | "-") product)*
 *     product = unary (("*" | "/") unary)*
 *     unary   = ("+" | "-") unary | primary ("^" unary)?                  -2^2 is -4, 2^-1 is 0.5, 2^3^2 is 2^9
 *     primary = number | "(" whole ")" | what the language adds
 *     call    = function "(" whole ("," whole)* ")" */
#ifndef LW_GRAMMAR_FUNCTIONS_ARITHMETIC_INTERNAL_H
#define LW_GRAMMAR_FUNCTIONS_ARITHMETIC_INTERNAL_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"
#include "base/real.h"

typedef enum lw_op {
    LW_OP_VARIABLE, LW_OP_NEGATE, LW_OP_ADD, LW_OP_SUBTRACT, LW_OP_MULTIPLY, LW_OP_DIVIDE,
    LW_OP_POWER,
    LW_OP_SIN, LW_OP_COS, LW_OP_TAN, LW_OP_ASIN, LW_OP_ACOS, LW_OP_ATAN, LW_OP_ATAN2, LW_OP_SINH,
    LW_OP_COSH, LW_OP_TANH, LW_OP_EXP, LW_OP_LOG, LW_OP_SQRT, LW_OP_ABS, LW_OP_SIGN, LW_OP_MIN,
    LW_OP_MAX, LW_OP_MOD, LW_OP_HYPOT,
    /* of expressions only */
    LW_OP_CUBIC,        /* 0 before 0, 3 u^2 - 2 u^3, 1 behind 1    */
    LW_OP_HALF_SINE,    /* 0 before 0, sin^2(pi u/2), 1 behind 1    */
    LW_OP_SPLINE,       /* the table of the node                   */
    LW_OP_MOVES,        /* the motion of the node                  */
    LW_OP_STEP, LW_OP_HAVSIN, LW_OP_POLY, LW_OP_TABLE, LW_OP_INTEGRAL, LW_OP_LAG,    /* names only: expanded while reading */
    LW_OP_COUNT         /* languages count their own operations from here */
} lw_op;

/* The value of a part of the text: a node, or (-1) a constant.  Formulas keep values on a stack and do not use it. */
typedef struct lw_operand { int node; double value; } lw_operand;

typedef struct lw_argument { lw_operand o; size_t at; } lw_argument;     /* at: where its text begins */

/* A function of `least` to `most` arguments; most 0: `least` or more. */
typedef struct lw_math_function { const char *name; int op, least, most; const char *form; } lw_math_function;

typedef struct lw_arithmetic lw_arithmetic;

/* The value of mod(a, b): the remainder with the sign of b. */
static inline double lw_modulo(double a, double b)
{
    double r = fmod(a, b);
    return r != 0 && (r < 0) != (b < 0) ? r + b : r;
}

typedef struct lw_language {
    const char *words;               /* "function or variable", for messages */
    int         depth;               /* brackets, signs and powers in each other */
    int         n_function;
    const lw_math_function *function;     /* besides those that all have */
    lw_status (*whole)(lw_arithmetic *p, lw_operand *out);
    lw_status (*number)(lw_arithmetic *p, size_t at, double value, lw_operand *out);
    lw_status (*other)(lw_arithmetic *p, int byte, lw_operand *out);     /* byte: a letter, or none that begins a primary */
    lw_status (*apply)(lw_arithmetic *p, size_t at, lw_op op, lw_operand a, lw_operand b, lw_operand *out);
} lw_language;

struct lw_arithmetic {
    const char *text;
    size_t      size, at;
    int         depth;
    const lw_language *language;
    void       *made;                /* the expression or formula */
    const void *words;               /* the words that the caller knows */
    lw_error   *e;
};

#define LW_WORD_SIZE 64

/* Fill the error with the line and column of byte `at`; returns LW_E_NOTATION. */
lw_status lw_arithmetic_fault(const lw_arithmetic *p, size_t at, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* _peek: the next byte that is not blank, -1 at the end.  _take: step over this byte if it equals `byte`; returns whether it did.
 * _byte: the byte at `at`, -1 behind the end. */
int  lw_arithmetic_peek(lw_arithmetic *p);
bool lw_arithmetic_take(lw_arithmetic *p, int byte);
int  lw_arithmetic_byte(const lw_arithmetic *p, size_t at);

static inline bool lw_is_digit(int c) { return c >= '0' && c <= '9'; }
static inline bool lw_is_letter(int c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/* Length of the word of letters and digits that begins at a place. */
size_t lw_word_length(const char *text, size_t size, size_t at);

/* Read the word that begins at p->at. */
lw_status lw_arithmetic_word(lw_arithmetic *p, char word[LW_WORD_SIZE]);

/* The function of this name; NULL: none.  The known word nearest to it; NULL: none is near.  The error for it. */
const lw_math_function *lw_arithmetic_function(const lw_arithmetic *p, const char *word);
const char        *lw_arithmetic_near(const lw_arithmetic *p, const char *word);
lw_status          lw_arithmetic_unknown(const lw_arithmetic *p, const char *word, size_t at);

/* Read the arguments of f with their brackets.  *list (*n) is the caller's to free, after a failure too. */
lw_status lw_arithmetic_arguments(lw_arithmetic *p, const lw_math_function *f, lw_argument **list, int *n);

lw_status lw_arithmetic_sum(lw_arithmetic *p, lw_operand *out);

/* The error for text after the end. */
lw_status lw_arithmetic_end(lw_arithmetic *p);

#endif
