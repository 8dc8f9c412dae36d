/* mbs/dynamics/follow.c - see follow.h */
#include "base/real.h"
#include "mbs/dynamics/follow_internal.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"
#include "mbs/equations/limits_internal.h"
#include "mbs/equations/timed.h"

enum { ORDER = LW_SERIES_ORDER_MAX, NODES = 2*(ORDER + 1) };

static const double wanted = 1e-10;          /* size of the last terms of a step */
static const double agrees = 1e-8;           /* greatest distance of a closed posture from the series of a step */
static const double rates_agree = 1e-3;      /* greatest difference of velocities, relative */
static const double longest = 0.5;           /* greatest change of a coordinate in a step */
static const double weakens = 0.15;          /* least pivot of a knot over that of the one before, */
static const double across = 1e-3;           /* or where the step crosses a singular posture */
static const double farther = 1.3;           /* a step may be so much longer if that crosses one */
static const double singular = 0.02;         /* pivots below this share of those of the knots: a posture is interpolated */
static const double grows = 1e3;             /* how much `gives` grows towards a singular posture, at least */
static const double beyond = 16;             /* a step may lead so many times as far as the posture asked for */

/* A posture with its series in time.  `push` is the unit vector of rows whose solution `gives` is about the greatest: next to a singular posture the motion
 * that the inputs leave free, which changes its sign across it. */
typedef struct knot { double t, weak, *c, *push, *gives; } knot;

struct lw_follow {
    lw_dynamics       *d;
    lw_input_function *motion;
    void              *context;
    double            *target;               /* of the straight way */
    double            *shown;                /* (LW_FOLLOW_ORDER + 1) x n: where f is */
    double             t, smallest;          /* shortest step */
    knot               near, far;            /* the step: from near to far */
    bool               has_far;
    bool               lost;                 /* a singular posture was crossed, first at lost_t */
    double             begun, lost_t;
    double            *q, *dq, *u, *phi, *sum;
    double            *memory;
    const volatile sig_atomic_t *stop;
    void             (*free_dynamics)(lw_dynamics *);     /* NULL: d is the caller's */
};

void lw_follow_own(lw_follow *f, void (*free_dynamics)(lw_dynamics *)) { f->free_dynamics = free_dynamics; }

double lw_follow_time(const lw_follow *f) { return f->t; }
const double *lw_follow_series(const lw_follow *f) { return f->shown; }
const lw_system *lw_follow_system(const lw_follow *f) { return &f->d->s; }

/* ---- one posture ------------------------------------------------------------------------------------------- */

/* Coefficients of the driven inputs at t into f->u, over their units and from the drawing. */
static bool inputs_at(lw_follow *f, double t, int order)
{
    const lw_dynamics *d = f->d;
    bool good = true;
    f->motion(f->context, t, order, f->u);
    for (int i = 0; i < d->n_driven; i++) {
        double *u = f->u + i*(order + 1), unit = lw_system_joint_unit(&d->s, d->driven_measure[i]);
        u[0] -= d->s.input_value[d->driven[i]];
        for (int k = 0; k <= order; k++) {
            good = good && isfinite(u[k]);
            u[k] /= unit;
        }
    }
    return good;
}

/* Rows at q for the inputs in f->u (order 0) into d->phi and d->jac, factored.  Returns how singular they are, 0: entirely. */
static double factor_at(lw_follow *f, const double *q, int order)
{
    lw_dynamics *d = f->d;
    double motion[3];
    if (lw_mbs_rows(d, d->o.from, q) != LW_OK)
        return 0;
    for (int i = 0; i < d->n_driven; i++) {
        lw_mbs_motion(d, i, d->o.from, motion);
        d->phi[d->n_row + i] += motion[0] - f->u[i*(order + 1)];
    }
    return lw_mbs_factor(d, false) == LW_OK ? d->weak : 0;
}

/* Close q at t.  Returns the pivot there, 0: not closed; *by: the greatest change of a coordinate. */
static double close_at(lw_follow *f, double t, double *q, double *by)
{
    lw_dynamics *d = f->d;
    double before = INFINITY, far = 1;
    *by = 0;
    if (!inputs_at(f, t, 0))
        return 0;
    memcpy(f->sum, q, (size_t)d->n_q*sizeof *q);
    for (int i = 0; i < d->n_q; i++)
        far = fmax(far, fabs(q[i]));
    for (int pass = 0; pass < 10; pass++) {
        double weak = factor_at(f, q, 0), off = lw_greatest(d->n_c, d->phi), moved = 0;
        if (!(weak > 0) || !(off < 1))
            return 0;
        if (off <= 4*DBL_EPSILON*far || (off < 1e-12*far && off >= 0.5*before)) {
            for (int i = 0; i < d->n_q; i++)
                *by = fmax(*by, fabs(q[i] - f->sum[i]));
            return weak;
        }
        before = off;
        for (int r = 0; r < d->n_c; r++)
            d->rhs[r] = -d->phi[r];
        lw_mbs_linear(d, NULL, d->rhs, f->dq, d->l_each);
        for (int i = 0; i < d->n_q; i++) {
            q[i] += f->dq[i];
            moved = fmax(moved, fabs(f->dq[i]));
        }
        if (!(moved < longest))
            return 0;
    }
    return 0;
}

/* Series in time of the motion through c[0 ..], with the factors there. */
static bool series_at(lw_follow *f, double t, int order, double *c)
{
    lw_dynamics *d = f->d;
    size_t n = (size_t)d->n_q;
    double input[LW_SERIES_ORDER_MAX + 1];
    if (!inputs_at(f, t, order))
        return false;
    memset(c + n, 0, (size_t)order*n*sizeof *c);
    for (int k = 1; k <= order; k++) {
        lw_system_series(&d->s, k, c, f->phi);
        for (int r = 0; r < d->n_row; r++)
            d->rhs[r] = -f->phi[(size_t)k*(size_t)d->n_row + (size_t)r];
        for (int i = 0; i < d->n_driven; i++) {
            lw_system_measure_series(&d->s, d->driven_measure[i], k, c, input);
            d->rhs[d->n_row + i] = f->u[i*(order + 1) + k] - input[k];
        }
        for (int twice = 0; twice < 2; twice++) {            /* refined, since the factors are those of a squared matrix */
            lw_mbs_linear(d, NULL, d->rhs, f->dq, d->l_each);
            for (size_t i = 0; i < n; i++)
                c[(size_t)k*n + i] += f->dq[i];
            lw_mbs_times(d, f->dq, d->l_each);
            for (int r = 0; r < d->n_c; r++)
                d->rhs[r] -= d->l_each[r];
        }
    }
    for (size_t i = 0; i < (size_t)(order + 1)*n; i++)
        if (!isfinite(c[i]))
            return false;
    return true;
}

/* Sum of the series of a knot at t, or of its derivative. */
static void sum_at(const lw_follow *f, const knot *k, double t, bool rate, double *out)
{
    size_t n = (size_t)f->d->n_q;
    double h = t - k->t;
    memset(out, 0, n*sizeof *out);
    for (int m = ORDER; m >= rate; m--)
        for (size_t i = 0; i < n; i++)
            out[i] = out[i]*h + (rate ? m : 1)*k->c[(size_t)m*n + i];
}

/* ---- steps -------------------------------------------------------------------------------------------------- */

/* How far the series of k serves. */
static double reach(const lw_follow *f, const knot *k)
{
    int n = f->d->n_q;
    double h = longest/fmax(lw_greatest(n, k->c + n), 1e-300);
    for (int m = ORDER - 1; m <= ORDER; m++)
        h = fmin(h, pow(wanted/fmax(lw_greatest(n, k->c + m*n), 1e-300), 1.0/m));
    return h;
}

/* Where rows depend on others, those kept may become dependent while others are not: choose again at q. */
static void choose_rows(lw_follow *f, const double *q)
{
    lw_dynamics *d = f->d;
    int rank = d->n_kept;
    if (d->n_kept == d->n_c || lw_mbs_arrange(d, d->o.from, q) != LW_OK || d->n_kept == rank)
        return;
    lw_mbs_arrange(d, d->o.from, f->near.c);             /* a singular posture has fewer: keep those of the knot before */
}

/* Push the rows so, with the factors at hand: coordinates into f->dq. */
static void push_rows(lw_follow *f, const double *push)
{
    memcpy(f->d->rhs, push, (size_t)f->d->n_c*sizeof *push);
    lw_mbs_linear(f->d, NULL, f->d->rhs, f->dq, f->d->l_each);
}

/* push and gives of a knot, with the factors there: multipliers of least-norm solutions are inverse iteration. */
static void find_weakest(lw_follow *f, knot *k)
{
    lw_dynamics *d = f->d;
    for (int r = 0; r < d->n_c; r++)
        k->push[r] = cos(r);
    for (int round = 0; round < 4; round++) {
        push_rows(f, k->push);
        double size = lw_norm(d->n_c, d->l_each);
        for (int r = 0; round < 3 && r < d->n_c; r++)
            k->push[r] = d->l_each[r]/size;
    }
    memcpy(k->gives, f->dq, (size_t)d->n_q*sizeof *f->dq);
}

/* The knot at t, if it is on the motion of the near one. */
static bool knot_at(lw_follow *f, double t, knot *k)
{
    lw_dynamics *d = f->d;
    double by, off = 0, fast = 0;
    sum_at(f, &f->near, t, false, k->c);
    k->t = t;
    k->weak = close_at(f, t, k->c, &by);
    if (!(k->weak > 0) || by > agrees || !series_at(f, t, ORDER, k->c))
        return false;
    sum_at(f, &f->near, t, true, f->q);
    for (int i = 0; i < d->n_q; i++) {
        double rate = k->c[d->n_q + i];
        off = fmax(off, fabs(rate - f->q[i]));
        fast = fmax(fast, fmax(fabs(rate), fabs(f->q[i])));
    }
    if (off <= rates_agree*fast)
        find_weakest(f, k);
    return off <= rates_agree*fast;
}

/* A step of h to the far knot.  Returns its pivot over that of the near one; 0: it is too long. */
static double try_step(lw_follow *f, double h)
{
    return knot_at(f, f->near.t + h, &f->far) ? f->far.weak/f->near.weak : 0;
}

/* A step from the near knot towards `last` or beyond.  Knots keep away from singular postures, where the series lose their
 * digits: a step that would end near one crosses it or stops before it. */
static lw_status advance(lw_follow *f, double last, lw_error *e)
{
    lw_dynamics *d = f->d;
    double sign = last >= f->near.t ? 1 : -1;
    double far = reach(f, &f->near), h = fmin(far, fmax(beyond*fabs(last - f->near.t), 1e-3*fmin(far, 1))), kink = INFINITY;
    if (sign > 0 && f->motion == lw_mbs_driven_inputs) {
        lw_timed timed = { .expressions = d->eq.expressions, .context = d->eq.context, .from = d->o.from };
        kink = lw_timed_next_kink(&timed, f->near.t + 1e-12*fmax(fabs(f->near.t), 1e-3), f->near.t + farther*h) - f->near.t;
    }
    double top = kink > 0 ? fmin(kink, f->smallest + farther*h) : farther*h, before = 0;
    bool chosen = false;
    for (h = fmin(h, top); h > f->smallest; h *= 0.7) {
        lw_status s = lw_limits_check(f->stop, d->o.until, true, f->near.t, e);
        if (s != LW_OK)
            return s;
        double share = try_step(f, sign*h);
        if (share >= weakens)
            return LW_OK;
        if (share > 0 && !chosen) {                          /* perhaps other rows are not as weak */
            choose_rows(f, f->far.c);
            chosen = true;
            share = try_step(f, sign*h);
        }
        if (share > 0 && share < before && before > across)  /* in between is a singular posture, which the longer step crosses */
            return try_step(f, sign*h/0.7) > 0 ? LW_OK : LW_E_NUMERIC;
        if (share > 0 && before == 0 && farther*h <= top && try_step(f, sign*farther*h) > fmax(across, 2*share))
            return LW_OK;
        before = share;
    }
    return inputs_at(f, f->near.t + sign*f->smallest, 0) ? LW_OPEN
         : lw_error_set(e, LW_E_NUMERIC, "the motion of an input is not a number at t = %.9g s", f->near.t);
}

/* The posture at t between the knots, interpolated: divided differences of both series. */
static void interpolate(lw_follow *f, double t, double *out)
{
    size_t n = (size_t)f->d->n_q;
    double h = f->far.t - f->near.t, x = (t - f->near.t)/h;
    for (size_t i = 0; i < n; i++) {
        double table[NODES], power[2][ORDER + 1], p[LW_FOLLOW_ORDER + 1] = { 0 }, scale = 1;
        for (int k = 0; k <= ORDER; k++, scale *= h)
            for (int end = 0; end < 2; end++)
                power[end][k] = scale*(end ? f->far : f->near).c[(size_t)k*n + i];
        for (int j = 0; j < NODES; j++)
            table[j] = power[j > ORDER][0];
        double newton[NODES];
        newton[0] = table[0];
        for (int k = 1; k < NODES; k++) {
            for (int j = 0; j < NODES - k; j++) {
                bool same = (j > ORDER) == (j + k > ORDER);
                table[j] = same ? power[j > ORDER][k <= ORDER ? k : ORDER] : table[j + 1] - table[j];
            }
            newton[k] = table[0];
        }
        for (int j = NODES - 1; j >= 0; j--) {                 /* p = p (x + s - node) + newton[j], in powers of s */
            double at = x - (j > ORDER);
            for (int k = LW_FOLLOW_ORDER; k > 0; k--)
                p[k] = p[k]*at + p[k - 1];
            p[0] = p[0]*at + newton[j];
        }
        for (int k = 0; k <= LW_FOLLOW_ORDER; k++)
            out[(size_t)k*n + i] = p[k]/pow(h, k);
    }
}

/* Does the step cross a singular posture?  The weakest motion of the near knot then grows beyond bounds in between and comes back with the other sign: 0 of
 * the inverse of its part along itself, by the Illinois method.  Overwrites the factors and f->shown. */
static void look_across(lw_follow *f)
{
    int n = f->d->n_q;
    push_rows(f, f->near.push);
    double ends = fmax(lw_norm(n, f->near.gives), lw_norm(n, f->dq)), size = 0, at = f->near.t;
    double side[2] = { f->near.t, f->far.t }, small[2] = { 1/lw_dot(n, f->near.gives, f->near.gives), 1/lw_dot(n, f->near.gives, f->dq) };
    if (f->lost || !(small[1] < 0))
        return;
    for (int round = 0, last = -1; round < 50; round++) {
        double before = at;
        at = side[0] + (side[1] - side[0])*small[0]/(small[0] - small[1]);
        interpolate(f, at, f->shown);
        if (fabs(at - before) <= 1e-13*fabs(f->far.t - f->near.t))
            break;
        if (!(factor_at(f, f->shown, 0) > 0)) {
            size = INFINITY;
            break;
        }
        push_rows(f, f->near.push);
        double now = 1/lw_dot(n, f->near.gives, f->dq);
        int to = now < 0;
        size = fmax(size, lw_norm(n, f->dq));
        side[to] = at, small[to] = now;
        if (to == last)
            small[!to] *= 0.5;
        last = to;
    }
    f->lost = size > grows*ends;
    f->lost_t = at;
}

bool lw_follow_lost(const lw_follow *f, double between[2])
{
    between[0] = between[1] = f->lost_t;
    return f->lost && (f->lost_t - f->begun)*(f->t - f->lost_t) >= 0;        /* steps may lead beyond f->t */
}

/* The posture at t within the step into f->shown.  false: it is not near the series, which has to be shorter. */
static bool show(lw_follow *f, double t)
{
    lw_dynamics *d = f->d;
    bool ahead = f->has_far && fabs(t - f->far.t) < fabs(t - f->near.t);
    const knot *from = ahead ? &f->far : &f->near;
    double by, least = singular*fmax(f->near.weak, f->has_far ? f->far.weak : 0);
    sum_at(f, from, t, false, f->shown);
    double weak = close_at(f, t, f->shown, &by);
    if (weak > least || !f->has_far)
        if (!(by <= agrees) || !(weak > 0) || !series_at(f, t, LW_FOLLOW_ORDER, f->shown))
            return false;
    if (!(weak > least) && f->has_far) {
        interpolate(f, t, f->shown);
        if (!inputs_at(f, t, 0))
            return false;
        factor_at(f, f->shown, 0);
        if (!(lw_greatest(d->n_c, d->phi) < agrees))
            return false;
    }
    f->t = t;
    return true;
}

static bool within(const lw_follow *f, double t)
{
    return f->has_far && (t - f->near.t)*(f->far.t - t) >= 0;
}

lw_status lw_follow_to(lw_follow *f, double t, lw_error *e)
{
    f->smallest = 1e-9*fmax(fabs(t - f->near.t), 1e-9*fabs(t));
    for (int refined = 0; refined < 60;) {
        if (f->has_far && !within(f, t) && (t - f->far.t)*(f->far.t - f->near.t) > 0) {
            knot was = f->near;
            f->near = f->far;
            f->far = was;
            f->has_far = false;
        } else if (f->has_far && !within(f, t))
            f->has_far = false;                          /* back */
        if (!f->has_far && fabs(t - f->near.t) <= 4*DBL_EPSILON*fabs(t))
            return show(f, t) ? LW_OK : lw_error_set(e, LW_E_NUMERIC, "at t = %.9g s the posture is singular", t);
        if (!f->has_far) {
            lw_status s = advance(f, t, e);
            if (s != LW_OK) {
                f->t = f->near.t;
                memcpy(f->shown, f->near.c, (LW_FOLLOW_ORDER + 1)*(size_t)f->d->n_q*sizeof *f->shown);
                return s;
            }
            f->has_far = true;
            look_across(f);
        }
        if (!within(f, t))
            continue;
        if (show(f, t))
            return LW_OK;
        f->has_far = false;                              /* the motion is not smooth in between: a step to t itself */
        refined++;
        if (knot_at(f, t, &f->far)) {
            f->has_far = true;
            look_across(f);
            continue;
        }
        double half = f->near.t + 0.5*(t - f->near.t);
        if (knot_at(f, half, &f->far)) {
            f->has_far = true;
            look_across(f);
        }
    }
    return lw_error_set(e, LW_E_NUMERIC, "the motion is lost at t = %.9g s: an input jumps there", f->near.t);
}

/* ---- making ------------------------------------------------------------------------------------------------- */

/* The inputs straight from those drawn to f->target, for t from 0 to 1. */
static void straight(void *context, double t, int order, double *u)
{
    const lw_follow *f = context;
    for (int i = 0; i < f->d->n_driven; i++) {
        double first = f->d->s.input_value[f->d->driven[i]], way = f->target[i] - first;
        for (int k = 0; k <= order; k++)
            u[i*(order + 1) + k] = k == 0 ? first + t*way : k == 1 ? way : 0;
    }
}

static lw_status begin(lw_follow *f, double t, lw_error *e)
{
    lw_dynamics *d = f->d;
    double by, most = 0;
    memcpy(f->near.c, d->drawn_q, (size_t)d->n_q*sizeof *d->drawn_q);
    f->near.t = 0;
    f->near.weak = close_at(f, 0, f->near.c, &by);
    if (!(f->near.weak > 0) || !series_at(f, 0, ORDER, f->near.c))
        return lw_error_set(e, LW_E_NUMERIC, "the posture of the file is singular for its inputs; draw the linkage in another posture");
    find_weakest(f, &f->near);
    for (int i = 0; i < d->n_driven; i++)
        most = fmax(most, fabs(f->target[i] - d->s.input_value[d->driven[i]]));
    memcpy(f->shown, f->near.c, (size_t)d->n_q*sizeof *f->shown);
    lw_status s = most > 0 ? lw_follow_to(f, 1, e) : LW_OK;
    if (s == LW_OPEN)
        return lw_error_set(e, s, "from its posture the linkage cannot get to where the motions begin at t = %g: it comes %.6g %% of "
                            "the way, straight in its inputs", t, 100*f->t);
    return s;
}

lw_status lw_follow_ready(lw_dynamics *d, lw_input_function *motion, void *context, double t, lw_follow **out, lw_error *e)
{
    lw_follow *f = calloc(1, sizeof *f);
    size_t n = (size_t)d->n_q, inputs = (size_t)d->model->linkage.n_input + 1;
    *out = NULL;
    if (f)
        f->memory = calloc((2*(ORDER + 1) + LW_FOLLOW_ORDER + 1 + 5)*n + inputs*(ORDER + 2) + 2*((size_t)d->n_c + 1)
                           + (ORDER + 1)*((size_t)d->n_row + 1), sizeof *f->memory);
    if (!f || !f->memory) {
        free(f);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    f->d = d;
    f->stop = d->o.stop;
    f->near.c = f->memory;
    f->far.c = f->near.c + (ORDER + 1)*n;
    f->shown = f->far.c + (ORDER + 1)*n;
    f->q = f->shown + (LW_FOLLOW_ORDER + 1)*n;
    f->dq = f->q + n;
    f->sum = f->dq + n;
    f->target = f->sum + n;
    f->u = f->target + inputs;
    f->near.gives = f->u + inputs*(ORDER + 1);
    f->far.gives = f->near.gives + n;
    f->near.push = f->far.gives + n;
    f->far.push = f->near.push + d->n_c + 1;
    f->phi = f->far.push + d->n_c + 1;
    motion(context, t, 0, f->target);
    f->motion = straight;
    f->context = f;
    lw_status s = LW_OK;
    for (int i = 0; i < d->n_driven && s == LW_OK; i++)
        if (!isfinite(f->target[i]))
            s = lw_error_set(e, LW_E_NUMERIC, "the motion of input %d is no number at t = %g", i + 1, t);
    if (s == LW_OK)
        s = begin(f, t, e);
    if (s == LW_OK) {
        f->motion = motion;
        f->context = context;
        memcpy(f->near.c, f->shown, n*sizeof *f->shown);
        f->near.t = f->t = f->begun = t;
        f->has_far = f->lost = false;
        double by;
        f->near.weak = close_at(f, t, f->near.c, &by);
        if (!(f->near.weak > 0) || by > agrees || !series_at(f, t, ORDER, f->near.c))
            s = lw_error_set(e, LW_E_NUMERIC, "the motions begin in a singular posture at t = %g; begin a little before", t);
        else {
            memcpy(f->shown, f->near.c, (LW_FOLLOW_ORDER + 1)*n*sizeof *f->shown);
            find_weakest(f, &f->near);
        }
    }
    if (s == LW_OK)
        *out = f;
    else
        lw_follow_free(f);
    return s;
}

void lw_follow_free(lw_follow *f)
{
    if (!f)
        return;
    if (f->free_dynamics)
        f->free_dynamics(f->d);
    free(f->memory);
    free(f);
}
