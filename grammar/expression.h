/* grammar/expression.h - a number as a function of time and of the state of a linkage, as text:
 *
 *     "2*pi*t + step(t, 0, 0, 0.5, 0.1)"        "-k*x(P)"  is not known: constants are numbers
 *
 * Operators + - * / ^ and brackets; numbers; pi; t [s]; functions of docs/notation.md, "Expressions":
 * sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt abs sign min max mod hypot, and the motion
 * generators of Makkonen 1999, paper A:
 *     step(x, x0, h0, x1, h1)     cubic from h0 to h1, constant outside
 *     havsin(x, x0, h0, x1, h1)   half a sine wave from h0 to h1
 *     poly(x, x0, a0, a1, ...)    sum of a_k (x - x0)^k
 *     table(x, x1, y1, x2, y2, ...)  natural cubic spline through the points, rising x; straight outside
 * Everything else of the form  word  or  word(name)  is a variable that the caller knows or refuses.
 *
 * An expression is immutable once parsed: threads may share it.  Angles in radians, all else in SI. */
#ifndef LW_GRAMMAR_EXPRESSION_H
#define LW_GRAMMAR_EXPRESSION_H

#include <stddef.h>
#include "base/error.h"

#define LW_EXPRESSION_VARIABLE_MAX 16     /* different ones in one expression                      */
#define LW_SERIES_ORDER_MAX         8

typedef struct lw_expression lw_expression;

/* The caller's number (>= 0) of the variable `word` or `word(name)`, name NULL in the first case; -1
 * when there is none, with a text why in `why` (128 bytes) or "" for a plain "unknown".  `t` is asked
 * for too. */
typedef int lw_expression_lookup(void *context, const char *word, const char *name, char *why);

/* LW_E_NOTATION with the column (from 1, in bytes) of the fault; LW_E_MEMORY. */
lw_status lw_expression_parse(const char *text, size_t size, lw_expression_lookup *lookup,
                              void *context, lw_expression **out, lw_error *e);
void      lw_expression_free(lw_expression *x);

/* The variables it depends on: their number, and the caller's numbers of them in the order of
 * first appearance.  A constant has none. */
int lw_expression_variables(const lw_expression *x, const int **which);

/* Value at v[i], the value of the i-th variable of lw_expression_variables.  Outside the domain (sqrt
 * of a negative number) it is NaN, which the caller reports. */
double lw_expression_value(const lw_expression *x, const double *v);

/* Value, and dv[i] its derivative by the i-th variable. */
double lw_expression_gradient(const lw_expression *x, const double *v, double *dv);

/* Taylor coefficients: v[i*(order+1) + k] is coefficient k (k-th derivative over k!) of variable i along
 * some curve, out (order + 1) those of the expression.  order <= LW_SERIES_ORDER_MAX.  At a kink (abs,
 * min, ends of step) the right-hand branch is taken. */
void lw_expression_series(const lw_expression *x, int order, const double *v, double *out);

/* The text as it was given. */
const char *lw_expression_text(const lw_expression *x);

#endif
