/* grammar/functions/expression_internal.h - the compiled form of an expression: operations in the order in which
 * they are computed, each on constants or on results of earlier operations.
 *
 * Constant parts are computed while reading, so a step between fixed ends takes five operations and a
 * number takes none.  step, havsin, poly and table are expanded into operations; only the three ramps
 * LW_OP_CUBIC, LW_OP_HALF_SINE and LW_OP_SPLINE exist for them alone. */
#ifndef LW_GRAMMAR_FUNCTIONS_EXPRESSION_INTERNAL_H
#define LW_GRAMMAR_FUNCTIONS_EXPRESSION_INTERNAL_H

#include "grammar/functions/arithmetic_internal.h"
#include "grammar/functions/expression.h"

#define LW_EXPRESSION_NODE_MAX 512

struct lw_moves;

typedef struct lw_spline {         /* natural cubic spline; straight outside */
    int     n;
    double *x, *y, *bend;          /* (n) in one block at x; bend: second derivative */
} lw_spline;

typedef struct lw_expression_node {
    lw_op      op;
    int        index;              /* of the variable or spline */
    lw_operand a, b;
} lw_expression_node;

struct lw_expression {
    char       *text;
    int         n_node, n_variable, n_spline, n_moves;
    lw_operand  result;
    int         variable[LW_EXPRESSION_VARIABLE_MAX];
    lw_spline  *spline;
    const struct lw_moves **moves;             /* (n_moves) the caller's */
    lw_expression_node     node[];
};

/* The result of one operation; operations with one operand ignore b. */
double lw_op_value(const lw_expression *x, const lw_expression_node *n, double a, double b);

/* The polynomial that LW_OP_CUBIC, LW_OP_SPLINE or LW_OP_MOVES equals at u and beyond u in the direction given by the
 * sign of `direction`:  p[0] + p[1] d + p[2] d^2 + ...,  d = difference to u.  Returns its degree; of a motion, up to
 * the order given. */
int lw_op_piece(const lw_expression *x, const lw_expression_node *n, double u, int direction, int order, double p[LW_SERIES_ORDER_MAX + 1]);

#endif
