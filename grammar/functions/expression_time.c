/* grammar/functions/expression_time.c - where functions of the time alone have kinks, poles and jumps, and how fast they change.
 *
 * Interval arithmetic (Moore 1966) bounds each operation and its derivative over an interval of time, so that a kink or a pulse
 * cannot lie between two samples.  Bounds are not rounded outwards: errors of rounding move a kink by as much as they move the value. */
#include <float.h>
#include "base/real.h"
#include "base/vec2.h"
#include "grammar/functions/expression_internal.h"
#include "grammar/functions/moves.h"

typedef struct range { double lo, hi; } range;

/* A node over an interval of time: value, derivative, value in the middle. */
typedef struct bound { bool is; range f, d; double mid; } bound;      /* is: of the time alone */

/* ---- ranges ------------------------------------------------------------------------------------ */

static const range whole = { -INFINITY, INFINITY };

static range point(double a) { return (range){ a, a }; }
static range hull(range a, range b) { return (range){ fmin(a.lo, b.lo), fmax(a.hi, b.hi) }; }
static range between(double a, double b) { return isnan(a) || isnan(b) ? whole : (range){ fmin(a, b), fmax(a, b) }; }
static range plus(range a, range b) { return (range){ a.lo + b.lo, a.hi + b.hi }; }
static range minus(range a, range b) { return (range){ a.lo - b.hi, a.hi - b.lo }; }
static double most(range a) { return fmax(fabs(a.lo), fabs(a.hi)); }
static bool   within(range a, range b) { return a.lo >= b.lo && a.hi <= b.hi; }
static bool   passes(range a, double u) { return a.lo < u && a.hi > u; }
static double product(double a, double b) { return a == 0 || b == 0 ? 0 : a*b; }

static range times(range a, range b)
{
    return hull(between(product(a.lo, b.lo), product(a.hi, b.hi)), between(product(a.lo, b.hi), product(a.hi, b.lo)));
}

static range over(range a, range b)
{
    return b.lo > 0 || b.hi < 0 ? times(a, between(1/b.lo, 1/b.hi)) : a.lo == 0 && a.hi == 0 ? a : whole;
}

static range square(range a)
{
    range r = between(a.lo*a.lo, a.hi*a.hi);
    return passes(a, 0) ? (range){ 0, r.hi } : r;
}

static range sine(range a)
{
    if (!(a.hi - a.lo < 2*LW_PI))
        return (range){ -1, 1 };
    range r = between(sin(a.lo), sin(a.hi));
    for (int side = -1; side <= 1; side += 2)                /* crests and troughs */
        if (side*LW_PI/2 + 2*LW_PI*ceil((a.lo - side*LW_PI/2)/(2*LW_PI)) <= a.hi)
            *(side > 0 ? &r.hi : &r.lo) = side;
    return r;
}

static range cosine(range a) { return sine(plus(a, point(LW_PI/2))); }

static range rising(double (*f)(double), range a) { return between(f(a.lo), f(a.hi)); }

static range absolute(range a)
{
    return (range){ a.lo > 0 ? a.lo : a.hi < 0 ? -a.hi : 0, most(a) };
}

/* a to the power c. */
static range power(range a, double c)
{
    bool even = fmod(c, 2) == 0, entire = c == floor(c);
    if ((a.lo < 0 && !entire) || (c < 0 && a.lo <= 0 && a.hi >= 0))
        return whole;
    range r = between(pow(a.lo, c), pow(a.hi, c));
    return even && passes(a, 0) ? (range){ 0, r.hi } : r;
}

/* ---- pieces -------------------------------------------------------------------------------------- */

/* The first place beyond u where an operation of one operand changes its piece; infinite: none. */
static double next_knot(const lw_expression *x, const lw_expression_node *n, double u)
{
    const lw_spline *s = n->op == LW_OP_SPLINE ? &x->spline[n->index] : NULL;
    switch (n->op) {
    case LW_OP_ABS: case LW_OP_SIGN: case LW_OP_MIN: case LW_OP_MAX:
        return u < 0 ? 0 : INFINITY;
    case LW_OP_CUBIC: case LW_OP_HALF_SINE:
        return u < 0 ? 0 : u < 1 ? 1 : INFINITY;
    case LW_OP_SPLINE:
        for (int i = 0; i < s->n; i++)
            if (s->x[i] > u)
                return s->x[i];
        return INFINITY;
    case LW_OP_MOVES:
        return lw_moves_next_kink(x->moves[n->index], u);
    default:
        return INFINITY;
    }
}

/* The piece about u, which the operand enters with this slope. */
static range piece_about(const lw_expression *x, const lw_expression_node *n, double u, double slope, double modulus)
{
    if (n->op == LW_OP_MOD) {
        double k = floor(u/modulus), low = modulus*(k - (u == modulus*k && slope < 0));
        return between(low, low + modulus);
    }
    range r = whole;
    while ((r.hi = next_knot(x, n, r.lo)) < u || (r.hi == u && slope > 0))
        r.lo = r.hi;
    return r.hi == u && slope == 0 ? whole : r;              /* on a knot all the time: the operand has no kink there */
}

/* Bernstein's bounds of a cubic or spline ramp over u, and of its slope. */
static void ramp(const lw_expression *x, const lw_expression_node *n, range u, range *f, range *slope)
{
    *f = *slope = whole;
    if (!(u.hi - u.lo < INFINITY))
        return;
    for (double p = u.lo, q = p; ; p = q) {
        double c[LW_SERIES_ORDER_MAX + 1], w;
        q = fmin(u.hi, next_knot(x, n, p));
        w = q - p;
        lw_op_piece(x, n, p, 1, 3, c);
        range value = hull(between(c[0], c[0] + c[1]*w/3), between(c[0] + w*(2*c[1] + c[2]*w)/3, c[0] + w*(c[1] + w*(c[2] + w*c[3]))));
        range rate = hull(between(c[1], c[1] + c[2]*w), point(c[1] + w*(2*c[2] + 3*c[3]*w)));
        *f = p == u.lo ? value : hull(*f, value);
        *slope = p == u.lo ? rate : hull(*slope, rate);
        if (!(q < u.hi))
            return;
    }
}

/* ---- bounds -------------------------------------------------------------------------------------- */

static bound operand(const lw_operand *o, const bound *of)
{
    return o->node >= 0 ? of[o->node] : (bound){ true, point(o->value), { 0, 0 }, o->value };
}

static bool two_operands(lw_op op)
{
    return op == LW_OP_ADD || op == LW_OP_SUBTRACT || op == LW_OP_MULTIPLY || op == LW_OP_DIVIDE || op == LW_OP_POWER || op == LW_OP_ATAN2
        || op == LW_OP_MIN || op == LW_OP_MAX || op == LW_OP_MOD || op == LW_OP_HYPOT;
}

/* Value and derivative of an operation on operands a and b. */
static void bound_operation(const lw_expression *x, const lw_expression_node *n, const bound *p, const bound *q, bound *out)
{
    range a = p->f, b = q->f, f = whole, slope = whole, one = point(1);      /* slope: by a */
    range d = whole;
    bool has_d = true;                                       /* d is set here; else the derivative is slope times that of a */
    switch (n->op) {
    case LW_OP_NEGATE:   f = minus(point(0), a), d = minus(point(0), p->d); break;
    case LW_OP_ADD:      f = plus(a, b), d = plus(p->d, q->d); break;
    case LW_OP_SUBTRACT: f = minus(a, b), d = minus(p->d, q->d); break;
    case LW_OP_MULTIPLY: f = times(a, b), d = plus(times(a, q->d), times(p->d, b)); break;
    case LW_OP_DIVIDE:   f = over(a, b), d = over(minus(p->d, times(f, q->d)), b); break;
    case LW_OP_POWER:
        if (b.lo == b.hi && most(q->d) == 0)
            f = power(a, b.lo), d = times(times(b, power(a, b.lo - 1)), p->d);
        else if (a.lo > 0) {
            range log_a = rising(lw_real_log, a);
            f = rising(lw_real_exp, times(b, log_a));
            d = times(f, plus(times(q->d, log_a), over(times(b, p->d), a)));
        }
        break;
    case LW_OP_ATAN2:
        if (b.lo > 0)
            f = rising(lw_real_atan, over(a, b));
        d = over(minus(times(p->d, b), times(a, q->d)), plus(square(a), square(b)));
        break;
    case LW_OP_HYPOT: {
        range u = absolute(a), v = absolute(b);
        f = between(hypot(u.lo, v.lo), hypot(u.hi, v.hi));
        d = f.lo > 0 ? over(plus(times(a, p->d), times(b, q->d)), f) : times((range){ -1, 1 }, plus(absolute(p->d), absolute(q->d)));
        break;
    }
    case LW_OP_MIN:
        f = (range){ fmin(a.lo, b.lo), fmin(a.hi, b.hi) }, d = a.hi <= b.lo ? p->d : b.hi <= a.lo ? q->d : hull(p->d, q->d);
        break;
    case LW_OP_MAX:
        f = (range){ fmax(a.lo, b.lo), fmax(a.hi, b.hi) }, d = a.lo >= b.hi ? p->d : b.lo >= a.hi ? q->d : hull(p->d, q->d);
        break;
    case LW_OP_MOD:
        if (b.lo == b.hi && most(q->d) == 0 && floor(a.lo/b.lo) == floor(a.hi/b.lo))
            f = minus(a, point(b.lo*floor(a.lo/b.lo))), d = p->d;
        else
            f = hull(point(0), b);
        break;
    default: has_d = false;
    }
    switch (n->op) {
    case LW_OP_SIN:   f = sine(a), slope = cosine(a); break;
    case LW_OP_COS:   f = cosine(a), slope = minus(point(0), sine(a)); break;
    case LW_OP_TAN:
        if (floor(a.lo/LW_PI + 0.5) == floor(a.hi/LW_PI + 0.5))
            f = rising(lw_real_tan, a), slope = plus(one, square(f));
        break;
    case LW_OP_ASIN:  f = rising(lw_real_asin, a), slope = over(one, power(minus(one, square(a)), 0.5)); break;
    case LW_OP_ACOS:  f = rising(lw_real_acos, a), slope = over(point(-1), power(minus(one, square(a)), 0.5)); break;
    case LW_OP_ATAN:  f = rising(lw_real_atan, a), slope = over(one, plus(one, square(a))); break;
    case LW_OP_SINH:  f = rising(lw_real_sinh, a), slope = rising(lw_real_cosh, absolute(a)); break;
    case LW_OP_COSH:  f = rising(lw_real_cosh, absolute(a)), slope = rising(lw_real_sinh, a); break;
    case LW_OP_TANH:  f = rising(lw_real_tanh, a), slope = over(one, square(rising(lw_real_cosh, absolute(a)))); break;
    case LW_OP_EXP:   f = slope = rising(lw_real_exp, a); break;
    case LW_OP_LOG:   f = rising(lw_real_log, a), slope = over(one, a); break;
    case LW_OP_SQRT:  f = rising(sqrt, a), slope = over(point(0.5), f); break;
    case LW_OP_ABS:   f = absolute(a), slope = a.lo >= 0 ? one : a.hi <= 0 ? point(-1) : (range){ -1, 1 }; break;
    case LW_OP_SIGN:  f = between((a.lo > 0) - (a.lo < 0), (a.hi > 0) - (a.hi < 0)), slope = f.lo == f.hi ? point(0) : whole; break;
    case LW_OP_HALF_SINE: {
        range u = { fmin(fmax(a.lo, 0), 1), fmin(fmax(a.hi, 0), 1) };
        f = between(lw_op_value(x, n, a.lo, 0), lw_op_value(x, n, a.hi, 0));
        slope = times(point(LW_PI/2), sine(times(point(LW_PI), u)));
        break;
    }
    case LW_OP_CUBIC: case LW_OP_SPLINE: ramp(x, n, a, &f, &slope); break;
    default: break;
    }
    out->f = f;
    out->d = has_d ? d : times(slope, p->d);
}

/* Bound all nodes between the times a and b. */
static void enclose(const lw_expression *x, int t_variable, double a, double b, bound *of)
{
    double half = 0.5*(b - a), middle = a + half;
    for (int i = 0; i < x->n_node; i++) {
        const lw_expression_node *n = &x->node[i];
        bound *o = &of[i], p, q;
        if (n->op == LW_OP_VARIABLE) {
            *o = (bound){ x->variable[n->index] == t_variable, { a, b }, { 1, 1 }, middle };
            continue;
        }
        p = operand(&n->a, of);
        q = two_operands(n->op) ? operand(&n->b, of) : p;
        o->is = p.is && q.is && n->op != LW_OP_MOVES;
        if (!o->is)
            continue;
        bound_operation(x, n, &p, &q, o);
        o->mid = lw_op_value(x, n, p.mid, q.mid);
        double reach = product(most(o->d), half);            /* mean value theorem */
        if (reach < INFINITY && isfinite(o->mid))
            o->f = (range){ fmax(o->f.lo, o->mid - reach), fmin(o->f.hi, o->mid + reach) };
    }
}

/* Values of the nodes of the time alone, which `is` says, at t. */
static void values_at(const lw_expression *x, const bound *of, double t, double *value)
{
    for (int i = 0; i < x->n_node; i++) {
        const lw_expression_node *n = &x->node[i];
        if (of[i].is)
            value[i] = n->op == LW_OP_VARIABLE ? t : lw_op_value(x, n, n->a.node < 0 ? n->a.value : value[n->a.node],
                                                                 n->b.node < 0 ? n->b.value : value[n->b.node]);
    }
}

/* ---- kinks --------------------------------------------------------------------------------------- */

/* An operation with kinks, of the time alone: it stays smooth while the quantity, its operand or the difference of both, stays in
 * the piece. */
typedef struct kinked { int node; range piece; } kinked;

static bool has_kinks(lw_op op)
{
    return op == LW_OP_ABS || op == LW_OP_SIGN || op == LW_OP_MIN || op == LW_OP_MAX || op == LW_OP_MOD || op == LW_OP_CUBIC
        || op == LW_OP_HALF_SINE || op == LW_OP_SPLINE || op == LW_OP_MOVES;
}

static bool is_jump(lw_op op) { return op == LW_OP_SIGN || op == LW_OP_MOD; }

static bound quantity(const lw_expression_node *n, const bound *of)
{
    bound p = operand(&n->a, of), q;
    if (n->op != LW_OP_MIN && n->op != LW_OP_MAX)
        return p;
    q = operand(&n->b, of);
    return (bound){ p.is && q.is, minus(p.f, q.f), minus(p.d, q.d), p.mid - q.mid };
}

static double quantity_at(const lw_expression *x, const lw_expression_node *n, const bound *of, double t)
{
    double value[LW_EXPRESSION_NODE_MAX];
    values_at(x, of, t, value);
    double a = n->a.node < 0 ? n->a.value : value[n->a.node];
    return n->op == LW_OP_MIN || n->op == LW_OP_MAX ? a - (n->b.node < 0 ? n->b.value : value[n->b.node]) : a;
}

/* The time between a and b at which the quantity, which rises or falls all the time, leaves its piece; infinite: it does not. */
static double leaves(const lw_expression *x, const bound *of, const kinked *k, double a, double b)
{
    const lw_expression_node *n = &x->node[k->node];
    double end = quantity_at(x, n, of, b), border = end > k->piece.hi ? k->piece.hi : k->piece.lo;
    if (end >= k->piece.lo && end <= k->piece.hi)
        return INFINITY;
    double fa = quantity_at(x, n, of, a) - border, fb = end - border;
    for (int i = 0; i < 200; i++) {                          /* the Illinois method, with bisections */
        double t = i % 4 == 3 ? 0.5*(a + b) : a + (b - a)*fa/(fa - fb);
        t = t > a && t < b ? t : i % 2 ? nextafter(a, b) : nextafter(b, a);      /* within rounding of an end */
        if (!(t > a && t < b))
            break;
        double f = quantity_at(x, n, of, t) - border;
        if ((f > 0) == (end > border) && f != 0)
            b = t, fb = f, fa *= 0.5;
        else
            a = t, fa = f, fb *= 0.5;
        if (f == 0)
            b = t;
    }
    return b;
}

double lw_expression_next_kink(const lw_expression *x, int t_variable, double t, double end)
{
    enum { TRIES = 10000 };                                  /* the kinks behind are left to the error of steps */
    bound of[LW_EXPRESSION_NODE_MAX];
    kinked k[LW_EXPRESSION_NODE_MAX];
    int n_kinked = 0;
    enclose(x, t_variable, t, t, of);
    for (int i = 0; i < x->n_node; i++) {
        const lw_expression_node *n = &x->node[i];
        bound u = has_kinks(n->op) ? quantity(n, of) : (bound){ .is = false };
        bool fixed = n->op != LW_OP_MOD || n->b.node < 0;
        if (u.is && fixed && isfinite(u.mid))
            k[n_kinked++] = (kinked){ i, piece_about(x, n, u.mid, isfinite(u.d.lo) ? u.d.lo : 0, n->b.value) };
    }
    double a = t, h = end - t;
    for (int tries = 0; n_kinked > 0 && a < end && tries < TRIES; tries++) {
        double b = fmin(a + h, end), first = INFINITY, least = 4*DBL_EPSILON*fmax(fmax(fabs(a), fabs(b)), 1e-3);
        bool short_enough = h <= least, bends = false;
        enclose(x, t_variable, a, b, of);
        for (int i = 0; i < n_kinked; i++) {
            bound u = quantity(&x->node[k[i].node], of);
            if (within(u.f, k[i].piece))
                continue;
            if (u.d.lo >= 0 || u.d.hi <= 0 || short_enough)
                first = fmin(first, leaves(x, of, &k[i], a, b));
            else
                bends = true;
        }
        if (bends) {
            h = 0.5*(b - a);
            continue;
        }
        if (first < INFINITY)
            return first;
        a = b;
        h *= 2;
    }
    return INFINITY;
}

/* ---- fast changes --------------------------------------------------------------------------------- */

/* A function has no pulse that steps could miss in an interval in which it changes by at most this multiple of what samples show; or by
 * so little of its size there, or of its greatest size in the run. */
static const double changes = 4, even = 1e-3, nothing = 1e-8;

/* Kinks at known times are ends of steps; those of other quantities are not. */
static bool may_pulse(lw_op op, bool with_kinks)
{
    return op >= LW_OP_DIVIDE && op <= LW_OP_SPLINE && !is_jump(op) && (with_kinks || !has_kinks(op));
}

bool lw_expression_may_pulse(const lw_expression *x, int variable)
{
    bound of[LW_EXPRESSION_NODE_MAX];
    bool any = false;
    enclose(x, variable, 0, 0, of);
    for (int i = 0; i < x->n_node; i++)
        any = any || (of[i].is && may_pulse(x->node[i].op, true));
    return any;
}

double lw_expression_calm(const lw_expression *x, int variable, bool with_kinks, double from, double t, double end, double least)
{
    bound of[LW_EXPRESSION_NODE_MAX];
    double peak[LW_EXPRESSION_NODE_MAX], low[LW_EXPRESSION_NODE_MAX], high[LW_EXPRESSION_NODE_MAX], value[LW_EXPRESSION_NODE_MAX];
    bool any = false;
    enclose(x, variable, fmin(from, end), fmax(from, end), of);
    for (int i = 0; i < x->n_node; i++) {
        bool looked_at = of[i].is && may_pulse(x->node[i].op, with_kinks);
        any = any || looked_at;
        peak[i] = looked_at ? most(of[i].f) : 0;
    }
    for (double h = end - t; any && fabs(h) > least; h *= 0.5) {
        bool calm = true;
        enclose(x, variable, fmin(t, t + h), fmax(t, t + h), of);
        for (int pass = 0; pass < 2 && calm; pass++) {       /* the first needs no samples */
            for (int k = 0; pass && k <= LW_CALM_SAMPLES; k++) {
                values_at(x, of, t + h*k/LW_CALM_SAMPLES, value);
                for (int i = 0; i < x->n_node; i++)
                    if (of[i].is) {
                        low[i] = k ? fmin(low[i], value[i]) : value[i];
                        high[i] = k ? fmax(high[i], value[i]) : value[i];
                    }
            }
            for (int i = 0; i < x->n_node && calm; i++) {
                /* a part that grows beyond all numbers, as the cosh(x) of 1/cosh(x), shows in the whole */
                if (!of[i].is || !may_pulse(x->node[i].op, with_kinks) || (peak[i] == INFINITY && i < x->n_node - 1))
                    continue;
                double shown = pass ? high[i] - low[i] : of[i].f.hi - of[i].f.lo, change = fabs(h)*most(of[i].d);
                bool small = isfinite(peak[i]) && fmin(change, of[i].f.hi - of[i].f.lo) <= nothing*peak[i];
                calm = small || change <= changes*shown + even*most(of[i].f);
            }
        }
        if (calm)
            return t + h;
    }
    return any ? t + copysign(fmin(least, fabs(end - t)), end - t) : end;
}

/* ---- poles and jumps --------------------------------------------------------------------------------- */

double lw_expression_next_break(const lw_expression *x, int t_variable, double t, double end, double most_change, double *by)
{
    enum { TRIES = 10000 };                                  /* what is behind is not looked at */
    bound of[LW_EXPRESSION_NODE_MAX];
    double a = t, h = end - t;
    for (int tries = 0; a < end && tries < TRIES; tries++) {
        double b = fmin(a + h, end), least = 4*DBL_EPSILON*fmax(fmax(fabs(a), fabs(b)), 1e-3);
        enclose(x, t_variable, a, b, of);
        bound whole_x = operand(&x->result, of);
        if (!whole_x.is)
            return INFINITY;
        double fastest = most(whole_x.d);
        bool finite = isfinite(most(whole_x.f));
        if (!(finite && fastest*least <= most_change)) {
            if (h > least) {
                h = 0.5*(b - a);
                continue;
            }
            double jump = fabs(lw_expression_value(x, &b) - lw_expression_value(x, &a));
            bool fast = finite && fastest < INFINITY;        /* bounds are infinite where something jumps, the expression need not */
            *by = fast || !finite ? INFINITY : jump;
            if (isnan(jump))
                return INFINITY;
            if (fast || jump > most_change)
                return a;
        }
        a = b;
        h = fmax(2*h, least);
    }
    return INFINITY;
}

/* ---- breaks of other quantities ------------------------------------------------------------------------ */

/* A number > 0 on one side of each place where an operation on a and b jumps or has a kink; with several places it is so in every other piece. */
static double side_of(const lw_expression *x, const lw_expression_node *n, double a, double b)
{
    double side = 1;
    switch (n->op) {
    case LW_OP_ABS: case LW_OP_SIGN:
        return a;
    case LW_OP_MIN: case LW_OP_MAX:
        return a - b;
    case LW_OP_CUBIC: case LW_OP_HALF_SINE:
        return a*(a - 1);
    case LW_OP_MOD:
        return fmod(floor(a/b), 2) != 0 ? -1 : 1;
    default:
        for (double knot = next_knot(x, n, -INFINITY); knot < a; knot = next_knot(x, n, knot))
            side = -side;
        return side;
    }
}

int lw_expression_breaks(const lw_expression *x, int t_variable, bool jumps, const double *v, double *side)
{
    bool timed[LW_EXPRESSION_NODE_MAX];
    double value[LW_EXPRESSION_NODE_MAX];
    int count = 0;
    for (int i = 0; i < x->n_node; i++) {
        const lw_expression_node *n = &x->node[i];
        bool variable = n->op == LW_OP_VARIABLE, second = !variable && two_operands(n->op);
        double a = variable ? 0 : n->a.node < 0 ? n->a.value : value[n->a.node], b = !second ? 0 : n->b.node < 0 ? n->b.value : value[n->b.node];
        timed[i] = variable ? x->variable[n->index] == t_variable
                 : (n->a.node < 0 || timed[n->a.node]) && (!second || n->b.node < 0 || timed[n->b.node]);
        value[i] = !v ? 0 : variable ? v[n->index] : lw_op_value(x, n, a, b);
        if (timed[i] || !has_kinks(n->op) || is_jump(n->op) != jumps)
            continue;
        if (v)
            side[count] = side_of(x, n, a, b);
        count++;
    }
    return count;
}
