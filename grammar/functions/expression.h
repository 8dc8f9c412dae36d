/* grammar/functions/expression.h - a number as a function of time and of the state of a linkage, as text:
 *
 *     "2*pi*t + step(t, 0, 0, 0.5, 0.1)"        "-k*x(P)"  is refused: constants must be numbers
 *
 * Operators + - * / ^ and brackets; numbers; pi; t [s]; functions of docs/notation.md, "Expressions":
 * sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt abs sign min max mod hypot, and the motion
 * generators of Makkonen 1999, paper A:
 *     step(x, x0, h0, x1, h1)     cubic from h0 to h1, constant outside
 *     havsin(x, x0, h0, x1, h1)   half a sine wave from h0 to h1
 *     poly(x, x0, a0, a1, ...)    sum of a_k (x - x0)^k
 *     profile(name), profile(name, x)   a motion with limits, at t or at x
 *     table(x, x1, y1, x2, y2, ...)  natural cubic spline through the points, rising x; straight outside
 * Any other text of the form  word  or  word(name)  is a variable, which the caller accepts or refuses.
 *
 * An expression is immutable once parsed: threads may share it.  Angles are in radians, other values in SI units. */
#ifndef LW_GRAMMAR_FUNCTIONS_EXPRESSION_H
#define LW_GRAMMAR_FUNCTIONS_EXPRESSION_H

#include <stdbool.h>
#include <stddef.h>
#include "base/error.h"

#define LW_EXPRESSION_VARIABLE_MAX 16     /* different ones in one expression                      */
#define LW_SERIES_ORDER_MAX         8

typedef struct lw_expression lw_expression;

/* Returns the caller's number (>= 0) of the variable `word` (name is NULL) or `word(name)`.  Returns -1 for an
 * unknown variable; `why` (128 bytes) then gets the reason, or "" for a plain "unknown".  The variable `t` is
 * looked up in the same way. */
typedef int lw_expression_lookup(void *context, const char *word, const char *name, char *why);

/* LW_E_NOTATION with the column (from 1, in bytes) of the error; LW_E_MEMORY. */
lw_status lw_expression_parse(const char *text, size_t size, lw_expression_lookup *lookup, void *context, lw_expression **out, lw_error *e);

/* Words that stand for more than a variable.  Each may be NULL: there are none.
 *
 * insert: the expression that word(name), or word with name NULL, stands for; it is copied.  NULL: none.
 * integrate: the number of a new variable z for  integral(x, start)  with lag 0, z' = x, or for  lag(x, time, start),
 * z' = (x - z)/time.  It takes x over, also when it fails (-1: out of memory).  start is NAN when it is left out. */
typedef struct lw_expression_words {
    void *context;
    lw_expression_lookup *variable;
    const lw_expression *(*insert)(void *context, const char *word, const char *name);
    int (*integrate)(void *context, lw_expression *x, double lag, double start);
    /* The motion of profile(name) and profile(name, x), which must outlive the expression; NULL: none of that name. */
    const struct lw_moves *(*moves)(void *context, const char *name);
} lw_expression_words;

lw_status lw_expression_parse_words(const char *text, size_t size, const lw_expression_words *words, lw_expression **out, lw_error *e);
void      lw_expression_free(lw_expression *x);

/* The variables of the expression: returns how many there are; *which gets the caller's numbers of them in the
 * order of first appearance.  A constant has none. */
int lw_expression_variables(const lw_expression *x, const int **which);

/* Value at v[i], the value of the i-th variable of lw_expression_variables.  Outside the domain (sqrt
 * of a negative number) it is NaN, which the caller reports. */
double lw_expression_value(const lw_expression *x, const double *v);

/* Returns the value; dv[i] gets its derivative by the i-th variable. */
double lw_expression_gradient(const lw_expression *x, const double *v, double *dv);

/* Taylor coefficients: v[i*(order+1) + k] is coefficient k (k-th derivative over k!) of variable i along
 * a curve; out (order + 1) gets the coefficients of the expression.  order <= LW_SERIES_ORDER_MAX.  At a kink
 * (abs, min, ends of step) the derivatives are those from the right. */
void lw_expression_series(const lw_expression *x, int order, const double *v, double *out);

/* The first time between t and end at which the expression has a kink whose place depends on t alone: where a profile changes its
 * phase, at the ends of step and havsin, the points of tables, zeros of abs and sign, steps of mod, where min and
 * max change over; t_variable: the caller's number of t.  Infinite: none. */
double lw_expression_next_kink(const lw_expression *x, int t_variable, double t, double end);

/* The end of an interval from t towards `end` (later or earlier) in which functions of a variable alone have no pulse between LW_CALM_SAMPLES evenly
 * spaced samples, or t +- least.  with_kinks: functions with kinks, too; else there are none of these between t and end.  from: values between it
 * and `end` tell what is small. */
#define LW_CALM_SAMPLES 8
double lw_expression_calm(const lw_expression *x, int variable, bool with_kinks, double from, double t, double end, double least);

/* Can functions of this variable alone have a pulse, with kinks or without? */
bool lw_expression_may_pulse(const lw_expression *x, int variable);

/* The first time between t and end near which an expression of t alone, without profiles, changes by more than most_change within rounding of the
 * time: it jumps there by *by, or is so fast, as near a pole (*by infinite).  Infinite: there is none, or it is no number there. */
double lw_expression_next_break(const lw_expression *x, int t_variable, double t, double end, double most_change, double *by);

/* Operations that jump (sign, mod), or that have kinks (abs, min, max, step, havsin, table, profile), where something else than t changes.  Returns
 * how many; side (unless v is NULL) gets for each a number that is > 0 on one side of the jump or kink, at the values v of
 * lw_expression_value. */
int lw_expression_breaks(const lw_expression *x, int t_variable, bool jumps, const double *v, double *side);

/* Takes an expression of a model, or NULL; _at: with the values of its variables. */
typedef void lw_expression_sink(void *context, const lw_expression *x);
typedef void lw_expression_sink_at(void *context, const lw_expression *x, const double *v);

/* The text as it was given. */
const char *lw_expression_text(const lw_expression *x);

#endif
