/* grammar/functions/expression_value.c - value and gradient.  The value is one pass over the operations; the gradient
 * adds a pass backwards (Griewank & Walther 2008, chapter 3). */
#include <stdbool.h>
#include "base/real.h"
#include "base/vec2.h"
#include "grammar/functions/expression_internal.h"
#include "grammar/functions/moves.h"

/* ---- pieces ------------------------------------------------------------------------------------ */

/* The slope at the end of piece i at point k, which is i or i + 1. */
static double spline_slope(const lw_spline *s, int i, int k)
{
    double h = s->x[i+1] - s->x[i];
    double chord = (s->y[i+1] - s->y[i])/h;
    return k == i ? chord - h*(2*s->bend[i] + s->bend[i+1])/6
                  : chord + h*(s->bend[i] + 2*s->bend[i+1])/6;
}

static void spline_piece(const lw_spline *s, double u, int direction, double p[4])
{
    int n = s->n, low = 0, high = n - 1;
    if (u < s->x[0] || (u == s->x[0] && direction < 0) || u > s->x[n-1]
        || (u == s->x[n-1] && direction > 0)) {
        int end = u <= s->x[0] ? 0 : n - 1;
        p[1] = spline_slope(s, end ? n - 2 : 0, end);
        p[0] = s->y[end] + p[1]*(u - s->x[end]);
        p[2] = p[3] = 0;
        return;
    }
    while (high - low > 1) {
        int mid = (low + high)/2;
        if (s->x[mid] < u || (s->x[mid] == u && direction > 0))
            low = mid;
        else
            high = mid;
    }
    double h = s->x[low+1] - s->x[low], d = u - s->x[low];
    double jump = (s->bend[low+1] - s->bend[low])/h, slope = spline_slope(s, low, low);
    p[3] = jump/6;
    p[2] = (s->bend[low] + jump*d)/2;
    p[1] = slope + d*(s->bend[low] + jump*d/2);
    p[0] = d == h ? s->y[low+1] : s->y[low] + d*(slope + d*(s->bend[low]/2 + d*jump/6));
}

int lw_op_piece(const lw_expression *x, const lw_expression_node *n, double u, int direction, int order, double p[LW_SERIES_ORDER_MAX + 1])
{
    if (n->op == LW_OP_MOVES) {
        lw_moves_series(x->moves[n->index], u, direction, order, p);
        return order;
    }
    p[1] = p[2] = p[3] = 0;
    if (n->op == LW_OP_SPLINE) {
        spline_piece(&x->spline[n->index], u, direction, p);
    } else if (u < 0 || (u == 0 && direction < 0)) {
        p[0] = 0;
    } else if (u > 1 || (u == 1 && direction > 0)) {
        p[0] = 1;
    } else {
        p[0] = u*u*(3 - 2*u);
        p[1] = 6*u*(1 - u);
        p[2] = 3 - 6*u;
        p[3] = -2;
    }
    return 3;
}

/* ---- value ------------------------------------------------------------------------------------- */

static double half_sine(double u)
{
    if (u <= 0 || u >= 1)
        return u >= 1;
    double s = sin(LW_PI/2*u);
    return s*s;
}

double lw_op_value(const lw_expression *x, const lw_expression_node *n, double a, double b)
{
    double p[LW_SERIES_ORDER_MAX + 1];
    if (isnan(a))
        return a;
    switch (n->op) {
    case LW_OP_NEGATE:    return -a;
    case LW_OP_ADD:       return a + b;
    case LW_OP_SUBTRACT:  return a - b;
    case LW_OP_MULTIPLY:  return a*b;
    case LW_OP_DIVIDE:    return a/b;
    case LW_OP_POWER:     return pow(a, b);
    case LW_OP_SIN:       return sin(a);
    case LW_OP_COS:       return cos(a);
    case LW_OP_TAN:       return tan(a);
    case LW_OP_ASIN:      return asin(a);
    case LW_OP_ACOS:      return acos(a);
    case LW_OP_ATAN:      return atan(a);
    case LW_OP_ATAN2:     return atan2(a, b);
    case LW_OP_SINH:      return sinh(a);
    case LW_OP_COSH:      return cosh(a);
    case LW_OP_TANH:      return tanh(a);
    case LW_OP_EXP:       return exp(a);
    case LW_OP_LOG:       return log(a);
    case LW_OP_SQRT:      return sqrt(a);
    case LW_OP_ABS:       return fabs(a);
    case LW_OP_SIGN:      return (a > 0) - (a < 0);
    case LW_OP_MIN:       return isnan(b) || b < a ? b : a;
    case LW_OP_MAX:       return isnan(b) || b > a ? b : a;
    case LW_OP_MOD:       return lw_modulo(a, b);
    case LW_OP_HYPOT:     return hypot(a, b);
    case LW_OP_HALF_SINE: return half_sine(a);
    case LW_OP_CUBIC:
    case LW_OP_SPLINE:
    case LW_OP_MOVES:     lw_op_piece(x, n, a, 1, 0, p); return p[0];
    default:              return NAN;
    }
}

static double of(const lw_operand *o, const double *value)
{
    return o->node < 0 ? o->value : value[o->node];
}

static void run(const lw_expression *x, const double *v, double *value)
{
    for (int i = 0; i < x->n_node; i++) {
        const lw_expression_node *n = &x->node[i];
        value[i] = n->op == LW_OP_VARIABLE
                 ? v[n->index] : lw_op_value(x, n, of(&n->a, value), of(&n->b, value));
    }
}

double lw_expression_value(const lw_expression *x, const double *v)
{
    double value[LW_EXPRESSION_NODE_MAX];
    run(x, v, value);
    return of(&x->result, value);
}

/* ---- gradient ---------------------------------------------------------------------------------- */

static void power_partials(double a, double b, bool fixed, double f, double *da, double *db)
{
    *da = b == 0 ? 0 : b*pow(a, b - 1);
    *db = fixed || (a == 0 && b > 0) ? 0 : f*log(a);
}

/* hypot has no derivative at the origin; 0 is one of its subgradients. */
static void hypot_partials(double a, double b, double f, double *da, double *db)
{
    *da = f > 0 ? a/f : 0;
    *db = f > 0 ? b/f : 0;
}

static void atan2_partials(double a, double b, double *da, double *db)
{
    double r = hypot(a, b);
    *da = b/r/r;
    *db = -a/r/r;
}

static double piece_slope(const lw_expression *x, const lw_expression_node *n, double u)
{
    double p[LW_SERIES_ORDER_MAX + 1];
    lw_op_piece(x, n, u, 1, 1, p);
    return p[1];
}

/* Derivatives of operation n with value f by its operands; at a kink the right-hand one. */
static void partials(const lw_expression *x, const lw_expression_node *n, double a, double b, double f, double *da, double *db)
{
    *da = *db = 0;
    switch (n->op) {
    case LW_OP_NEGATE:    *da = -1; break;
    case LW_OP_ADD:       *da = *db = 1; break;
    case LW_OP_SUBTRACT:  *da = 1; *db = -1; break;
    case LW_OP_MULTIPLY:  *da = b; *db = a; break;
    case LW_OP_DIVIDE:    *da = 1/b; *db = -f/b; break;
    case LW_OP_POWER:     power_partials(a, b, n->b.node < 0, f, da, db); break;
    case LW_OP_SIN:       *da = cos(a); break;
    case LW_OP_COS:       *da = -sin(a); break;
    case LW_OP_TAN:       *da = 1 + f*f; break;
    case LW_OP_ASIN:      *da = 1/sqrt((1 - a)*(1 + a)); break;
    case LW_OP_ACOS:      *da = -1/sqrt((1 - a)*(1 + a)); break;
    case LW_OP_ATAN:      *da = 1/(1 + a*a); break;
    case LW_OP_ATAN2:     atan2_partials(a, b, da, db); break;
    case LW_OP_SINH:      *da = cosh(a); break;
    case LW_OP_COSH:      *da = sinh(a); break;
    case LW_OP_TANH:      *da = 1/(cosh(a)*cosh(a)); break;
    case LW_OP_EXP:       *da = f; break;
    case LW_OP_LOG:       *da = 1/a; break;
    case LW_OP_SQRT:      *da = 0.5/f; break;
    case LW_OP_ABS:       *da = a < 0 ? -1 : 1; break;
    case LW_OP_MIN:       *(b < a ? db : da) = 1; break;
    case LW_OP_MAX:       *(b > a ? db : da) = 1; break;
    case LW_OP_MOD:       *da = 1; *db = -round((a - f)/b); break;
    case LW_OP_HYPOT:     hypot_partials(a, b, f, da, db); break;
    case LW_OP_HALF_SINE: *da = a <= 0 || a >= 1 ? 0 : LW_PI/2*sin(LW_PI*a); break;
    case LW_OP_CUBIC:
    case LW_OP_SPLINE:
    case LW_OP_MOVES:     *da = piece_slope(x, n, a); break;
    default:              break;
    }
}

double lw_expression_gradient(const lw_expression *x, const double *v, double *dv)
{
    double value[LW_EXPRESSION_NODE_MAX], share[LW_EXPRESSION_NODE_MAX];
    for (int i = 0; i < x->n_variable; i++)
        dv[i] = 0;
    run(x, v, value);
    for (int i = 0; i < x->n_node; i++)
        share[i] = 0;
    if (x->result.node >= 0)
        share[x->result.node] = 1;
    for (int i = x->n_node - 1; i >= 0; i--) {
        const lw_expression_node *n = &x->node[i];
        double da, db;
        if (share[i] == 0)                                 /* not chosen by max: avoids 0 times infinity */
            continue;
        if (n->op == LW_OP_VARIABLE) {
            dv[n->index] += share[i];
            continue;
        }
        partials(x, n, of(&n->a, value), of(&n->b, value), value[i], &da, &db);
        if (n->a.node >= 0 && da != 0)
            share[n->a.node] += share[i]*da;
        if (n->b.node >= 0 && db != 0)
            share[n->b.node] += share[i]*db;
    }
    return of(&x->result, value);
}
