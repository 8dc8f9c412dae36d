/* grammar/functions/expression_series.c - Taylor coefficients of every operation from those of its operands, by the
 * recurrences of Griewank & Walther 2008, tables 13.1 and 13.2, which follow from  c' = f'(a) a'.
 *
 * A series here has LW_SERIES_ORDER_MAX + 1 numbers, of which order + 1 are used. */
#include <stdbool.h>
#include <string.h>
#include "base/real.h"
#include "base/vec2.h"
#include "grammar/functions/expression_internal.h"

#define TERMS (LW_SERIES_ORDER_MAX + 1)
typedef double series[TERMS];

static void copy(const series a, series c) { memcpy(c, a, sizeof(series)); }

static void constant(double value, series c)
{
    memset(c, 0, sizeof(series));
    c[0] = value;
}

/* Coefficient k of a b, with the coefficients of a below index `from` taken as 0. */
static double product_term(const series a, const series b, int from, int k)
{
    double sum = 0;
    for (int j = from; j <= k; j++)
        sum += a[j]*b[k - j];
    return sum;
}

/* c must be neither a nor b. */
static void multiply(int order, const series a, const series b, series c)
{
    for (int k = 0; k <= order; k++)
        c[k] = product_term(a, b, 0, k);
}

static void divide(int order, const series a, const series b, series c)
{
    for (int k = 0; k <= order; k++)
        c[k] = (a[k] - product_term(b, c, 1, k))/b[0];
}

/* Coefficient k of c where  c' = g a'. */
static double integral_term(const series a, const series g, int k)
{
    double sum = 0;
    for (int j = 1; j <= k; j++)
        sum += j*a[j]*g[k - j];
    return sum/k;
}

/* The sign of the first nonzero coefficient of a - at: the side of `at` on which the curve continues. */
static int side(int order, const series a, double at)
{
    for (int k = 0; k <= order; k++) {
        double d = k ? a[k] : a[0] - at;
        if (d != 0)
            return d > 0 ? 1 : -1;
    }
    return 0;
}

/* ---- powers and roots --------------------------------------------------------------------------- */

static void whole_power(int order, const series a, int n, series c)
{
    series square, next;
    copy(a, square);
    constant(1, c);
    for (; n; n /= 2) {
        if (n % 2) {
            multiply(order, c, square, next);
            copy(next, c);
        }
        multiply(order, square, square, next);
        copy(next, square);
    }
}

static int leading(int order, const series a)
{
    int m = 0;
    while (m <= order && a[m] == 0)
        m++;
    return m;
}

/* a^b, where b is no small whole number.  If a begins at 0, a = d^m (...): terms below d^(m b) vanish.  The
 * next term is infinite or, if b m is whole, needs terms of a beyond the given order. */
static void real_power(int order, const series a, double b, series c)
{
    c[0] = pow(a[0], b);
    int m = leading(order, a);
    for (int k = 1; k <= order; k++) {
        double sum = 0;
        for (int j = 1; j <= k; j++)
            sum += (b*j - (k - j))*a[j]*c[k - j];
        c[k] = m == 0 ? sum/(k*a[0]) : m > order || k < m*b ? 0 : NAN;
    }
}

/* a c' = a' */
static void logarithm(int order, const series a, series c)
{
    c[0] = log(a[0]);
    for (int k = 1; k <= order; k++) {
        c[k] = 0;                                          /* leave out the term to be computed */
        c[k] = (a[k] - integral_term(c, a, k))/a[0];
    }
}

static void power(int order, const series a, const lw_operand *exponent, const series b, series c)
{
    series one, up;
    if (exponent->node >= 0) {                             /* c = exp(b log a),  c' = c (b log a)' */
        logarithm(order, a, one);
        multiply(order, b, one, up);
        c[0] = pow(a[0], b[0]);
        for (int k = 1; k <= order; k++)
            c[k] = integral_term(up, c, k);
    } else if (b[0] == rint(b[0]) && fabs(b[0]) <= 64) {
        whole_power(order, a, (int)fabs(b[0]), up);
        constant(1, one);
        if (b[0] < 0)
            divide(order, one, up, c);
        else
            copy(up, c);
    } else {
        real_power(order, a, b[0], c);
    }
}

static void root(int order, const series a, series c)
{
    c[0] = sqrt(a[0]);
    bool still = leading(order, a) > order;                /* sqrt(0) with a constant 0 */
    for (int k = 1; k <= order; k++) {
        double sum = a[k];
        for (int j = 1; j < k; j++)
            sum -= c[j]*c[k - j];
        c[k] = still ? 0 : sum/(2*c[0]);
    }
}

/* If both operands begin with d^m, so does the distance: d^m hypot(a/d^m, b/d^m), to the right of 0. */
static void distance(int order, const series a, const series b, series c)
{
    int m = leading(order, a), other = leading(order, b);
    m = m < other ? m : other;
    memset(c, 0, sizeof(series));
    if (m > order)
        return;
    double *d = c + m;
    d[0] = hypot(a[m], b[m]);
    for (int k = 1; k <= order - m; k++) {
        double sum = 0;
        for (int j = 0; j <= k; j++)
            sum += a[m + j]/d[0]*a[m + k - j] + b[m + j]/d[0]*b[m + k - j];
        for (int j = 1; j < k; j++)
            sum -= d[j]/d[0]*d[k - j];
        d[k] = sum/2;
    }
}

/* ---- functions of one operand ------------------------------------------------------------------- */

/* s' = c a',  c' = sign s a':  sign -1: sine and cosine, +1: sinh and cosh; s[0], c[0] are given. */
static void sine_pair(int order, int sign, const series a, series s, series c)
{
    for (int k = 1; k <= order; k++) {
        s[k] = integral_term(a, c, k);
        c[k] = sign*integral_term(a, s, k);
    }
}

/* c' = (1 + sign c^2) a':  tan and tanh. */
static void tangent(int order, int sign, const series a, series c)
{
    series slope;
    slope[0] = sign > 0 ? 1 + c[0]*c[0] : 1/(cosh(a[0])*cosh(a[0]));
    for (int k = 1; k <= order; k++) {
        c[k] = integral_term(a, slope, k);
        slope[k] = sign*product_term(c, c, 0, k);
    }
}

/* c' = +-a'/sqrt(1 - a^2) */
static void arc_sine(int order, int sign, const series a, series c)
{
    series inner, slope_inverse, slope, one;
    multiply(order, a, a, inner);
    for (int k = 1; k <= order; k++)
        inner[k] = -inner[k];
    inner[0] = (1 - a[0])*(1 + a[0]);
    root(order, inner, slope_inverse);
    constant(sign, one);
    divide(order, one, slope_inverse, slope);
    for (int k = 1; k <= order; k++)
        c[k] = integral_term(a, slope, k);
}

/* The direction of (b, a):  c' = (b a' - a b')/(a^2 + b^2). */
static void arc_tangent(int order, const series a, const series b, series c)
{
    series square, across, slope, other;
    double r = hypot(a[0], b[0]);
    for (int k = 0; k <= order; k++) {
        other[k] = b[k]/r;
        across[k] = a[k]/r;
    }
    for (int k = 0; k <= order; k++)
        square[k] = product_term(across, across, 0, k) + product_term(other, other, 0, k);
    series turn = { 0 };
    for (int k = 0; k < order; k++)
        for (int j = 0; j <= k; j++)
            turn[k] += (j + 1)*(across[j + 1]*other[k - j] - other[j + 1]*across[k - j]);
    divide(order, turn, square, slope);
    for (int k = 1; k <= order; k++)
        c[k] = slope[k - 1]/k;
}

static void exponential(int order, const series a, series c)
{
    for (int k = 1; k <= order; k++)
        c[k] = integral_term(a, c, k);
}

static void half_sine(int order, const series a, series c)
{
    if (a[0] < 0 || a[0] > 1 || (a[0] == 0 && side(order, a, 0) < 0) || (a[0] == 1 && side(order, a, 1) > 0))
        return;
    series angle = { 0 }, s, k;
    for (int i = 0; i <= order; i++)
        angle[i] = LW_PI*a[i];
    s[0] = sin(angle[0]);
    k[0] = cos(angle[0]);
    sine_pair(order, -1, angle, s, k);
    for (int i = 1; i <= order; i++)
        c[i] = -k[i]/2;
}

static void piecewise(const lw_expression *x, const lw_expression_node *n, int order, const series a, series c)
{
    double p[LW_SERIES_ORDER_MAX + 1];
    series d, next;
    /* the side matters only at the ends of pieces; there the first nonzero difference decides */
    copy(a, d);
    d[0] = 0;
    int direction = side(order, d, 0);
    int degree = lw_op_piece(x, n, a[0], direction ? direction : 1, order, p);
    constant(p[degree], c);
    for (int i = degree - 1; i >= 0; i--) {
        multiply(order, c, d, next);
        copy(next, c);
        c[0] += p[i];
    }
}

static void scale_into(int order, double factor, const series a, series c)
{
    for (int k = 1; k <= order; k++)
        c[k] = factor*a[k];
}

/* c[0] is already set. */
static void function(const lw_expression *x, const lw_expression_node *n, int order, const series a, series c)
{
    series other;
    switch (n->op) {
    case LW_OP_NEGATE: scale_into(order, -1, a, c); break;
    case LW_OP_SIN:    other[0] = cos(a[0]); sine_pair(order, -1, a, c, other); break;
    case LW_OP_COS:    other[0] = -sin(a[0]); sine_pair(order, -1, a, c, other); break;
    case LW_OP_SINH:   other[0] = cosh(a[0]); sine_pair(order, 1, a, c, other); break;
    case LW_OP_COSH:   other[0] = sinh(a[0]); sine_pair(order, 1, a, c, other); break;
    case LW_OP_TAN:    tangent(order, 1, a, c); break;
    case LW_OP_TANH:   tangent(order, -1, a, c); break;
    case LW_OP_ASIN:   arc_sine(order, 1, a, c); break;
    case LW_OP_ACOS:   arc_sine(order, -1, a, c); break;
    case LW_OP_ATAN:   constant(1, other); arc_tangent(order, a, other, c); break;
    case LW_OP_EXP:    exponential(order, a, c); break;
    case LW_OP_LOG:    logarithm(order, a, c); break;
    case LW_OP_SQRT:   root(order, a, c); break;
    case LW_OP_ABS:    scale_into(order, side(order, a, 0) < 0 ? -1 : 1, a, c); break;
    case LW_OP_HALF_SINE: half_sine(order, a, c); break;
    case LW_OP_CUBIC:
    case LW_OP_SPLINE:
    case LW_OP_MOVES:  piecewise(x, n, order, a, c); break;
    default: break;                                        /* sign: constant on either side */
    }
}

/* ---- all operations ----------------------------------------------------------------------------- */

static void choose(int order, bool least, const series a, const series b, series c)
{
    series d;
    for (int k = 0; k <= order; k++)
        d[k] = b[k] - a[k];
    int s = side(order, d, 0);
    copy((least ? s < 0 : s > 0) ? b : a, c);
}

static void operation(const lw_expression *x, const lw_expression_node *n, int order, const series a, const series b, series c)
{
    double value = lw_op_value(x, n, a[0], b[0]);
    constant(value, c);
    if (order == 0 || isnan(value))
        return;
    switch (n->op) {
    case LW_OP_ADD:
    case LW_OP_SUBTRACT:
        for (int k = 1; k <= order; k++)
            c[k] = n->op == LW_OP_ADD ? a[k] + b[k] : a[k] - b[k];
        break;
    case LW_OP_MOD:                                        /* a - whole b */
        for (int k = 1; k <= order; k++)
            c[k] = a[k] - round((a[0] - c[0])/b[0])*b[k];
        break;
    case LW_OP_MULTIPLY: multiply(order, a, b, c); break;
    case LW_OP_DIVIDE:   divide(order, a, b, c); break;
    case LW_OP_POWER:    power(order, a, &n->b, b, c); break;
    case LW_OP_ATAN2:    arc_tangent(order, a, b, c); break;
    case LW_OP_MIN:      choose(order, true, a, b, c); break;
    case LW_OP_MAX:      choose(order, false, a, b, c); break;
    case LW_OP_HYPOT:    distance(order, a, b, c); break;
    default:             function(x, n, order, a, c); break;
    }
    c[0] = value;                                          /* the same bits as lw_expression_value */
}

static void fetch(const lw_operand *o, double (*done)[TERMS], series a)
{
    if (o->node < 0)
        constant(o->value, a);
    else
        copy(done[o->node], a);
}

void lw_expression_series(const lw_expression *x, int order, const double *v, double *out)
{
    double done[LW_EXPRESSION_NODE_MAX][TERMS];
    series a, b;
    for (int i = 0; i < x->n_node; i++) {
        const lw_expression_node *n = &x->node[i];
        if (n->op == LW_OP_VARIABLE) {
            memset(done[i], 0, sizeof done[i]);
            memcpy(done[i], v + (size_t)n->index*(size_t)(order + 1), (size_t)(order + 1)*sizeof *v);
            continue;
        }
        fetch(&n->a, done, a);
        fetch(&n->b, done, b);
        operation(x, n, order, a, b, done[i]);
    }
    fetch(&x->result, done, a);
    memcpy(out, a, (size_t)(order + 1)*sizeof *out);
}
