/* mbs/ode/integrate.c - steps of DOP853 with error control; events within them. */
#include "base/real.h"
#include "mbs/ode/integrate.h"

#include <float.h>
#include <string.h>
#include "mbs/ode/integrate_table_internal.h"

lw_ode_options lw_ode_options_default(void)
{
    return (lw_ode_options){ .relative = 1e-9, .absolute = 1e-9, .max_step = 10000000 };
}

size_t lw_integrate_work(int n, int n_event)
{
    return LW_INTEGRATE_WORK(n, n_event);
}

static void divide_workspace(lw_integrator *w, double *work)
{
    int n = w->ode->n;
    double **part[] = { &w->y, &w->y_old, &w->dy, &w->stage, &w->low, &w->y_step };
    for (size_t i = 0; i < sizeof part/sizeof *part; i++, work += n)
        *part[i] = work;
    for (int i = 0; i < 16; i++, work += n)
        w->k[i] = work;
    for (int i = 0; i < 8; i++, work += n)
        w->c[i] = work;
    w->g_try = work;
    w->g_old = work + w->ode->n_event;
    w->inner = w->g_old + w->ode->n_event;
    w->halves = w->inner + (16 + 6)*n;
}

static lw_status rate_at(lw_integrator *w, double t, const double *y, double *dy)
{
    w->n_rate++;
    return w->ode->rate(w->ode->context, t, y, dy);
}

static double allowed(const lw_integrator *w, int i, double size)
{
    return (w->o.absolute_each ? w->o.absolute_each[i] : w->o.absolute) + w->o.relative*size;
}

/* ---- one step ------------------------------------------------------------------------------------ */

/* stage = y_old + h sum of rk_matrix[s][j] k[j]; s is a literal, so that the loop unrolls and 0 drops out */
static inline __attribute__((always_inline)) void combine(lw_integrator *w, int s, double h)
{
    const double *k = w->k[0], *y = w->y_old;
    double *out = w->stage;
    size_t n = (size_t)w->ode->n;
    for (size_t i = 0; i < n; i++) {
        double sum = 0.0;
#pragma GCC unroll 16
        for (int j = 0; j < s; j++)
            if (rk_matrix[s][j] != 0.0)
                sum += rk_matrix[s][j]*k[(size_t)j*n + i];
        out[i] = y[i] + h*sum;
    }
}

#define STAGE(s)                                                                           \
    do {                                                                                   \
        combine(w, s, h);                                                                  \
        lw_status st_ = rate_at(w, w->t_old + rk_node[s]*h, w->stage, w->k[s]);            \
        if (st_ != LW_OK)                                                                  \
            return st_;                                                                    \
    } while (0)

/* y_old + low + h sum of weights in twice the precision (Kahan; low holds the lost digits) */
static void add_weighted(lw_integrator *w, double h)
{
    const double *k = w->k[0];
    size_t n = (size_t)w->ode->n;
    for (size_t i = 0; i < n; i++) {
        double sum = 0.0;
#pragma GCC unroll 12
        for (int j = 0; j < 12; j++)
            if (rk_matrix[12][j] != 0.0)
                sum += rk_matrix[12][j]*k[(size_t)j*n + i];
        double add = h*sum + w->y_step[i], y = w->y_old[i] + add;
        w->low[i] = add - (y - w->y_old[i]);
        w->y[i] = y;
    }
}

/* One step of length h from (t_old, y_old) with k[0] given: its end in w->y, the lost digits in w->low, the stages in
 * k[0 .. 11]. */
static lw_status advance(lw_integrator *w, double h)
{
    STAGE(1); STAGE(2); STAGE(3); STAGE(4); STAGE(5); STAGE(6);
    STAGE(7); STAGE(8); STAGE(9); STAGE(10); STAGE(11);
    add_weighted(w, h);
    w->h_done = h;
    return LW_OK;
}

/* Error estimate of order 5, stabilised by that of order 3 (Hairer, Norsett & Wanner 1993, eq. II.10.17); 1 is the
 * allowed error. */
static double step_error(const lw_integrator *w, double h)
{
    const double *k = w->k[0];
    size_t n = (size_t)w->ode->n;
    double e5 = 0.0, e3 = 0.0;
    for (size_t i = 0; i < n; i++) {
        double a = 0.0, b = 0.0;
#pragma GCC unroll 12
        for (int j = 0; j < 12; j++) {
            if (rk_error5[j] != 0.0)
                a += rk_error5[j]*k[(size_t)j*n + i];
            if (rk_matrix[12][j] - rk_error3[j] != 0.0)
                b += (rk_matrix[12][j] - rk_error3[j])*k[(size_t)j*n + i];
        }
        double s = allowed(w, (int)i, fmax(fabs(w->y_old[i]), fabs(w->y[i])));
        e5 += a*a/(s*s);
        e3 += b*b/(s*s);
    }
    double bottom = e5 + 0.01*e3;
    return bottom > 0.0 ? fabs(h)*e5/sqrt((double)n*bottom) : e5 == 0.0 && e3 == 0.0 ? 0.0 : NAN;
}

/* Project w->y at t; w->moved: how far, over the error allowed.  That is an error of the step, which the embedded methods
 * may have missed, unless the callback says otherwise. */
static lw_status project(lw_integrator *w)
{
    size_t n = (size_t)w->ode->n;
    double *before = w->stage, sum = 0.0;
    memcpy(before, w->y, n*sizeof *before);
    lw_status s = w->ode->project(w->ode->context, w->t, w->y);
    if (s != LW_OK && s != LW_NOTHING)
        return s;
    memset(w->low, 0, n*sizeof *w->low);                 /* the lost digits belong to the old y */
    for (size_t i = 0; s == LW_OK && i < n; i++) {
        double moved = (w->y[i] - before[i])/allowed(w, (int)i, fabs(before[i]));
        sum += moved*moved;
    }
    w->moved = sqrt(sum/(double)n);
    return LW_OK;
}

/* Sum of (a_i - b_i)^2. */
static double apart_squared(size_t n, const double *a, const double *b)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++)
        sum += (a[i] - b[i])*(a[i] - b[i]);
    return sum;
}

/* The last stage and the end of a step tell the fastest rate of f by what they are apart, if that is more than this part of the error allowed. */
static const double telling = 1e-4;

static bool is_telling(const lw_integrator *w)
{
    for (int i = 0; i < w->ode->n; i++)
        if (fabs(w->y[i] - w->stage[i]) > telling*allowed(w, i, fabs(w->y[i])))
            return true;
    return false;
}

/* After the step: project w->y at t_old + h_done and evaluate f there into dy and k[12]. */
static lw_status arrive(lw_integrator *w)
{
    double moved = is_telling(w) ? apart_squared((size_t)w->ode->n, w->y, w->stage) : 0.0;
    double add = w->h_done + w->t_step;                  /* time is summed with compensation too */
    w->t = w->t_old + add;
    w->t_low = add - (w->t - w->t_old);
    lw_status s = w->ode->project ? project(w) : LW_OK;
    if (s != LW_OK)
        return s;
    s = rate_at(w, w->t, w->y, w->k[12]);
    memcpy(w->dy, w->k[12], sizeof(double)*(size_t)w->ode->n);
    w->dense = false;
    w->in_halves = 0;
    w->reach = s == LW_OK && moved > 0.0 ? fabs(w->h_done)*sqrt(apart_squared((size_t)w->ode->n, w->k[12], w->k[11])/moved) : 0.0;
    return s;
}

/* Stage 11 and the end of the step are nearly one place, but the error estimate does not know f at the end.  It is small, too, if all of
 * its stages lie where a force is 0 that is great at the end, as that of a stiff contact.  Returns how far f at both is apart, times the
 * step, over 20 times the most that smooth motions have shown at tolerances down to 1e-10. */
static double end_apart(const lw_integrator *w, double h)
{
    double most = 0.0;
    for (int i = 0; i < w->ode->n; i++)
        most = fmax(most, fabs(w->k[12][i] - w->k[11][i])/allowed(w, i, fabs(w->y[i])));
    return fabs(h)*most/1e5;
}

/* ---- continuous solution, order 7 ---------------------------------------------------------------- */

static double polynomial(double *const *c, int i, double x)
{
    double z = 1.0 - x;
    return c[0][i] + x*(c[1][i] + z*(c[2][i] + x*(c[3][i] + z*(c[4][i] + x*(c[5][i] + z*(c[6][i] + x*c[7][i]))))));
}

static double dense_value(const lw_integrator *w, int i, double x) { return polynomial(w->c, i, x); }

static double dense_slope(const lw_integrator *w, int i, double x)
{
    double value = w->c[7][i], slope = 0.0;
    for (int r = 6; r >= 0; r--) {
        slope = slope*(r%2 ? 1.0 - x : x) + (r%2 ? -value : value);
        value = value*(r%2 ? 1.0 - x : x) + w->c[r][i];
    }
    return slope;
}

static const double over_allowed = 5;        /* error of the continuous solution, over that allowed in a step */

/* The error of the step does not tell that of the continuous solution.  Compare its slope with f at a place that is far from those
 * that it is made of: on smooth motions its greatest error is less than an eighth of their difference times the length of the step. */
static lw_status check_dense(lw_integrator *w)
{
    const double x = 0.65, over_error = 8*over_allowed;
    double *y = w->stage, *f = w->k[1], most = 0.0;
    for (int i = 0; i < w->ode->n; i++)
        y[i] = dense_value(w, i, x);
    lw_status s = rate_at(w, w->t_old + x*w->h_done, y, f);
    for (int i = 0; i < w->ode->n; i++)
        most = fmax(most, fabs(dense_slope(w, i, x) - w->h_done*f[i])/allowed(w, i, fabs(w->y[i])));
    w->rough = s != LW_OK ? INFINITY : most < over_error ? 0 : most/8;
    return s == LW_STOPPED ? s : LW_OK;
}

static lw_status dense_stages(lw_integrator *w)
{
    double h = w->h_done;
    STAGE(13); STAGE(14); STAGE(15);
    return LW_OK;
}

/* Without its stages, since f is not known at one of them, the continuous solution is a cubic that only tells where states are. */
static lw_status prepare_dense(lw_integrator *w)
{
    double h = w->h_done;
    size_t n = (size_t)w->ode->n;
    lw_status s = dense_stages(w);
    if (s == LW_STOPPED)
        return s;
    for (size_t i = 0; i < n; i++) {
        double rise = w->y[i] - w->y_old[i], bend = h*w->k[0][i] - rise;
        w->c[0][i] = w->y_old[i];
        w->c[1][i] = rise;
        w->c[2][i] = bend;
        w->c[3][i] = rise - h*w->k[12][i] - bend;
        for (int r = 0; r < 4; r++) {
            double sum = 0.0;
            for (int j = 0; s == LW_OK && j < 16; j++)
                sum += rk_dense[r][j]*w->k[j][i];
            w->c[4 + r][i] = h*sum;
        }
    }
    w->dense = true;
    w->rough = s == LW_OK ? 0 : INFINITY;
    return s != LW_OK || w->o.fixed > 0.0 ? LW_OK : check_dense(w);
}

/* An integrator for states within the last step, from one of its ends. */
static lw_status begin_within(const lw_integrator *w, lw_ode *ode, long most_steps, bool from_end, lw_integrator *inner)
{
    lw_ode_options o = w->o;
    *ode = *w->ode;
    ode->n_event = 0;
    ode->project = NULL;
    o.max_step = most_steps;
    return lw_integrate_start(inner, ode, &o, w->inner, from_end ? w->t : w->t_old, from_end ? w->y : w->y_old, NULL);
}

/* Did the caller stop it, and not the limit of steps? */
static bool is_stopped(const lw_integrator *inner, lw_status s)
{
    return s == LW_STOPPED && inner->n_step + inner->n_refused < inner->o.max_step;
}

/* Distance of a state at x of the step from the continuous solution, over the error allowed. */
static double apart_from_dense(const lw_integrator *w, double x, const double *y)
{
    double apart = 0.0;
    for (int i = 0; i < w->ode->n; i++)
        apart = fmax(apart, fabs(y[i] - dense_value(w, i, x))/allowed(w, i, fabs(w->y[i])));
    return apart;
}

static const double most_apart = 1000;       /* of a state within a step from the continuous solution */
static const double explained = 10;          /* the same, over the error that the continuous solution shows */

/* Continuous solutions of both halves of the last step.  LW_NOTHING: they are not accurate either, or do not lead to its end. */
static lw_status prepare_halves(lw_integrator *w)
{
    lw_ode ode;
    lw_integrator inner;
    lw_status s = begin_within(w, &ode, 2, false, &inner);
    w->in_halves = -1;
    for (int k = 0; k < 2 && s == LW_OK; k++) {
        lw_ode_stop stop = LW_ODE_STEP;
        inner.h = 0.5*fabs(w->h_done);
        for (int r = 0; r < 8; r++)
            inner.c[r] = w->halves + (8*k + r)*w->ode->n;
        s = lw_integrate_step(&inner, k ? w->t : w->t_old + 0.5*w->h_done, &stop, NULL);
        if (s == LW_OK)
            s = stop == LW_ODE_END ? prepare_dense(&inner) : LW_NOTHING;
        if (s == LW_OK && inner.rough)
            s = LW_NOTHING;
    }
    w->n_rate += inner.n_rate;
    double apart = 0.0;
    for (int i = 0; i < w->ode->n && s == LW_OK; i++)
        apart = fmax(apart, fabs(inner.y[i] - w->y[i])/allowed(w, i, fabs(w->y[i])));
    if (s != LW_OK || !(apart <= over_allowed))
        return is_stopped(&inner, s) ? s : LW_NOTHING;
    w->in_halves = 1;
    return LW_OK;
}

/* State at t within the last step from its halves.  LW_NOTHING: they do not tell. */
static lw_status within_halves(lw_integrator *w, double t, double *y)
{
    lw_status s = w->in_halves ? LW_OK : prepare_halves(w);
    if (s != LW_OK || w->in_halves < 0)
        return s == LW_OK ? LW_NOTHING : s;
    double x = (t - w->t_old)/w->h_done, *c[8];
    int k = x > 0.5;
    for (int r = 0; r < 8; r++)
        c[r] = w->halves + (8*k + r)*w->ode->n;
    for (int i = 0; i < w->ode->n; i++)
        y[i] = polynomial(c, i, 2.0*x - k);
    return apart_from_dense(w, x, y) <= most_apart ? LW_OK : LW_NOTHING;
}

/* State at t within the last step by steps from its nearer end.  That way may lead over a place where f is not known well, and
 * off the solution: where the continuous solution is not as near as its error tells, or not near at all, both ends are tried, and the
 * state that is nearer to it is taken.  LW_NOTHING: neither is as near as the error of the continuous solution, if it is known, explains. */
static lw_status integrate_within(lw_integrator *w, double t, double *y)
{
    lw_ode ode;
    lw_integrator inner;
    double x = (t - w->t_old)/w->h_done, least = INFINITY;
    for (int k = 0; k < 2 && !(least <= fmin(w->rough, most_apart)); k++) {
        lw_ode_stop stop = LW_ODE_STEP;
        lw_status s = begin_within(w, &ode, 200, (x > 0.5) == (k == 0), &inner);
        inner.h = fabs(t - inner.t);
        while (s == LW_OK && stop != LW_ODE_END)
            s = lw_integrate_step(&inner, t, &stop, NULL);
        w->n_rate += inner.n_rate;
        if (is_stopped(&inner, s))
            return s;
        double apart = apart_from_dense(w, x, inner.y);
        if (s != LW_OK || !(apart < least))
            continue;
        least = apart;
        memcpy(w->k[2], inner.y, sizeof(double)*(size_t)ode.n);
    }
    if (!(least <= fmax(most_apart, explained*w->rough)))
        return LW_NOTHING;
    memcpy(y, w->k[2], sizeof(double)*(size_t)ode.n);
    return LW_OK;
}

/* From so many states asked for in a rough step on, its halves cost less than a step to each of them. */
static const double many = 3;

lw_status lw_integrate_dense(lw_integrator *w, double t, double *y)
{
    if (w->h_done == 0.0) {
        memcpy(y, w->y, sizeof(double)*(size_t)w->ode->n);
        return LW_OK;
    }
    if (!w->dense) {
        lw_status s = prepare_dense(w);
        if (s != LW_OK)
            return s;
    }
    bool dense = many*fabs(t - w->asked) < fabs(w->h_done);
    w->asked = t;
    lw_status s = w->rough && dense ? within_halves(w, t, y) : LW_NOTHING;
    if (w->rough && s == LW_NOTHING)
        s = integrate_within(w, t, y);
    if (s == LW_OK || s == LW_STOPPED)
        return s;
    for (int i = 0; i < w->ode->n; i++)
        y[i] = dense_value(w, i, (t - w->t_old)/w->h_done);
    return w->rough < INFINITY ? LW_OK : LW_E_NUMERIC;
}

/* ---- begin --------------------------------------------------------------------------------------- */

/* Length of the first step from the sizes of y, f and a difference of f (Hairer, Norsett & Wanner 1993,
 * section II.4); its sign is that of the direction. */
static lw_status first_step(lw_integrator *w, double sign)
{
    int n = w->ode->n;
    double y2 = 0.0, f2 = 0.0, d2 = 0.0;
    for (int i = 0; i < n; i++) {
        double s = allowed(w, i, fabs(w->y[i]));
        y2 += pow(w->y[i]/s, 2);
        f2 += pow(w->dy[i]/s, 2);
    }
    bool guess = f2 <= 1e-10 || y2 <= 1e-10;             /* at rest at 0: nothing tells the scale of time yet */
    double h = guess ? 1e-6 : 0.01*sqrt(y2/f2), h1;
    if (w->o.greatest > 0.0)
        h = fmin(h, w->o.greatest);
    for (;; guess = false) {
        lw_status status;
        for (int tries = 0; ; tries++, h *= 0.1) {
            for (int i = 0; i < n; i++)
                w->stage[i] = w->y[i] + sign*h*w->dy[i];
            status = rate_at(w, w->t + sign*h, w->stage, w->k[1]);
            if (status != LW_OPEN || tries == 8)
                break;
        }
        if (status != LW_OK)
            return status;
        d2 = 0.0;
        for (int i = 0; i < n; i++)
            d2 += pow((w->k[1][i] - w->dy[i])/allowed(w, i, fabs(w->y[i])), 2);
        double most = fmax(sqrt(f2), sqrt(d2)/h);
        h1 = most <= 1e-15 ? fmax(1e-6, 1e-3*h) : pow(0.01/most, 1.0/8.0);
        if (!guess || h1 <= 100.0*h || w->o.greatest > 0.0)
            break;
        h = 0.01*h1;
    }
    w->h = fmin(100.0*h, h1);
    return LW_OK;
}

/* Has a callback said more about its failure than its status does? */
static bool told(const lw_error *e, lw_status s) { return s == LW_STOPPED || (e && e->status == s && e->text[0]); }

static lw_status bad_start(const lw_ode *ode, const lw_ode_options *o, lw_error *e)
{
    bool each = o->absolute_each != NULL;
    for (int i = 0; each && i < ode->n; i++)
        each = o->absolute_each[i] > 0.0 || o->relative > 0.0;
    if (!(o->fixed > 0.0 || o->absolute > 0.0 || o->relative > 0.0 || each) || o->absolute < 0.0 || o->relative < 0.0)
        return lw_error_set(e, LW_E_ARG, "integration needs a tolerance above 0");
    if (ode->n < 1 || ode->n_event < 0 || ode->n_event > LW_EVENT_MAX)
        return lw_error_set(e, LW_E_ARG, "integration of %d numbers with %d events: 1 or more numbers, "
                            "0 to %d events", ode->n, ode->n_event, LW_EVENT_MAX);
    return LW_OK;
}

static lw_status look_at_events(lw_integrator *w, lw_error *e)
{
    if (w->ode->n_event == 0)
        return LW_OK;
    lw_status s = w->ode->event(w->ode->context, w->t, w->y, w->g_try);
    if (s != LW_OK)
        return lw_error_set(e, s, "the events cannot be judged at t = %.9g s: %s", w->t, lw_status_text(s));
    for (int i = 0; i < w->ode->n_event; i++)
        w->side[i] = w->g_try[i] < 0.0 ? -1 : 1;
    memcpy(w->g_old, w->g_try, sizeof(double)*(size_t)w->ode->n_event);
    return LW_OK;
}

/* For an event that has just happened, g is only the error of its location and the sign of g is rounding.  The side
 * of such an event is the one shortly afterwards: past 0, or back again after an impact.  Look further ahead until g
 * exceeds that error. */
static lw_status look_ahead(lw_integrator *w, double sign)
{
    double left[LW_EVENT_MAX];
    bool sure = false;
    lw_status s = LW_OK;
    memcpy(left, w->g_try, sizeof(double)*(size_t)w->ode->n_event);
    for (double x = 1e-7; s == LW_OK && !sure && x < 2e-3; x *= 10.0) {
        for (int i = 0; i < w->ode->n; i++)
            w->stage[i] = w->y[i] + sign*x*w->h*w->dy[i];
        s = w->ode->event(w->ode->context, w->t, w->stage, w->g_try);
        sure = true;
        for (int i = 0; s == LW_OK && i < w->ode->n_event; i++)
            if (w->events >> i & 1) {
                w->side[i] = w->g_try[i] < 0.0 ? -1 : 1;
                sure = sure && fabs(w->g_try[i]) > 2.0*fabs(left[i]);
            }
    }
    return s;
}

lw_status lw_integrate_start(lw_integrator *w, const lw_ode *ode, const lw_ode_options *o, double *work,
                             double t, const double *y, lw_error *e)
{
    lw_status s = bad_start(ode, o, e);
    if (s != LW_OK)
        return s;
    memset(w, 0, sizeof *w);
    w->ode = ode;
    w->o = *o;
    divide_workspace(w, work);
    w->t = w->t_old = t;
    w->err_old = 1e-4;
    size_t bytes = sizeof(double)*(size_t)ode->n;
    memcpy(w->y, y, bytes);
    memcpy(w->y_old, y, bytes);
    memset(w->low, 0, bytes);
    if (e)
        e->status = LW_OK;
    if ((s = rate_at(w, t, w->y, w->dy)) != LW_OK)
        return told(e, s) ? s : lw_error_set(e, s, "the equations of motion have no meaning at the start: %s", lw_status_text(s));
    return look_at_events(w, e);
}

lw_status lw_integrate_restart(lw_integrator *w, const double *y, lw_error *e)
{
    size_t bytes = sizeof(double)*(size_t)w->ode->n;
    if (y)
        memcpy(w->y, y, bytes);
    memset(w->low, 0, bytes);
    lw_status s = rate_at(w, w->t, w->y, w->dy);
    if (s != LW_OK)
        return told(e, s) ? s : lw_error_set(e, s, "the equations of motion have no meaning at t = %.9g s: %s", w->t, lw_status_text(s));
    s = look_at_events(w, e);
    if (s == LW_OK && w->events)
        s = look_ahead(w, w->h_done < 0.0 ? -1.0 : 1.0);
    w->events = 0;
    return s;
}

/* ---- events within a step ------------------------------------------------------------------------ */

#define SAMPLES 4                    /* points checked in a step: three inside, and its end               */

typedef struct crossing {
    int    event;
    double t, slope;                 /* of g there                                                 */
} crossing;

/* y at fraction x of the step by the cubic through both ends: accurate enough for signs, and cheap */
static void cubic(const lw_integrator *w, double x, double *y)
{
    double h = w->h_done, z = 1.0 - x;
    for (int i = 0; i < w->ode->n; i++)
        y[i] = w->y_old[i]*z*z*(1.0 + 2.0*x) + w->y[i]*x*x*(3.0 - 2.0*x)
             + h*x*z*(z*w->k[0][i] - x*w->k[12][i]);
}

static int side_of(double g)
{
    return g < 0.0 ? -1 : 1;
}

/* g of one event on the continuous solution */
static lw_status g_at(lw_integrator *w, int event, double t, double *g, double *y)
{
    lw_status s = lw_integrate_dense(w, t, y);
    if (s == LW_OK)
        s = w->ode->event(w->ode->context, t, y, w->g_try);
    *g = w->g_try[event];
    return s == LW_OK && isnan(*g) ? LW_E_NUMERIC : s;
}

/* A time after a at which the event function is on its last known side: right after an impact g is 0 up to rounding. */
static lw_status step_off(lw_integrator *w, int event, double b, double *a, double *ga)
{
    double start = *a;
    lw_status s = LW_OK;
    for (int k = 1; s == LW_OK && k <= 30 && (side_of(*ga) != w->side[event] || *ga == 0.0); k++) {
        *a = start + ldexp(b - start, -k);
        s = g_at(w, event, *a, ga, w->stage);
    }
    return s;
}

/* The root between a and b by the Illinois method, with bisection if it is slow.  LW_NOTHING: the
 * continuous solution does not change sign. */
static lw_status locate(lw_integrator *w, double a, double b, crossing *c)
{
    double *y = w->stage, from = a, ga, gb, tight = 2.0*DBL_EPSILON*fmax(fabs(a), fabs(b));
    lw_status s = g_at(w, c->event, a, &ga, y);
    if (s == LW_OK)
        s = g_at(w, c->event, b, &gb, y);
    if (s == LW_OK && side_of(gb) != w->side[c->event])
        s = step_off(w, c->event, b, &a, &ga);
    if (s != LW_OK)
        return s;
    if (side_of(ga) == side_of(gb)) {
        if (side_of(gb) == w->side[c->event])
            return LW_NOTHING;                           /* the cubic was wrong */
        /* the crossing was invisible to the cubic, or the side was determined too near 0 */
        if (from != w->t_old)
            return locate(w, w->t_old, b, c);
        c->t = b, c->slope = 0.0;
        return LW_OK;
    }
    double slope = (gb - ga)/(b - a), fa = ga, fb = gb, wide = 1e-3*fabs(b - a);
    for (int i = 0; i < 200 && fabs(b - a) > tight; i++) {      /* where g has kinks, by bisection at last */
        double t = i % 4 == 3 || i > 100 ? 0.5*(a + b) : a + (b - a)*fa/(fa - fb), g;
        if (!(fabs(t - a) > 0.0))
            t = 0.5*(a + b);                             /* g is 0 at a too, up to rounding */
        if (!(fabs(t - a) > 0.0 && fabs(t - b) > 0.0))
            break;
        if ((s = g_at(w, c->event, t, &g, y)) != LW_OK)
            return s;
        bool near_b = side_of(g) == side_of(gb);
        double other = near_b ? b : a;
        if (fabs(t - other) > wide)                      /* a smaller difference gives only rounding errors */
            slope = (g - (near_b ? gb : ga))/(t - other);
        if (near_b) {
            b = t, gb = fb = g;
            fa *= 0.5;
        } else {
            a = t, ga = fa = g;
            fb *= 0.5;
        }
    }
    c->t = b;                        /* on the far side */
    c->slope = slope;
    return LW_OK;
}

/* Collect the crossings between fractions xa and xb of the step in order of time.  Crossings in a direction that does
 * not count only update the side. */
static lw_status collect(lw_integrator *w, const double *g, double ta, double tb, crossing *found, int *n_found)
{
    int n = 0;
    signed char now[LW_EVENT_MAX];
    for (int i = 0; i < w->ode->n_event; i++)
        now[i] = (signed char)side_of(g[i]);
    for (int i = 0; i < w->ode->n_event; i++) {
        if (now[i] == w->side[i])
            continue;
        if (w->ode->direction[i] && now[i] != w->ode->direction[i]) {
            w->side[i] = now[i];
            continue;
        }
        crossing c = { .event = i };
        lw_status s = locate(w, ta, tb, &c);
        if (s < 0 || s == LW_OPEN)
            return s;
        if (s == LW_NOTHING)
            continue;
        int k = n++;
        for (; k > 0 && (found[k - 1].t - c.t)*w->h_done > 0.0; k--)
            found[k] = found[k - 1];
        found[k] = c;
    }
    *n_found = n;
    return LW_OK;
}

/* End the step at c by steps of the method itself from t_old, so that the state is as accurate as at the end of any
 * step. The secant rule finds t, at first with the known slope, and never beyond the accepted step. */
static lw_status land(lw_integrator *w, const crossing *c)
{
    double t = c->t, slope = c->slope, t_before = 0.0, g_before = 0.0, whole = w->h_done;
    for (int i = 0; i < 5; i++) {
        lw_status s = advance(w, t - w->t_old);
        if (s == LW_OK)
            s = arrive(w);
        if (s == LW_OK)
            s = w->ode->event(w->ode->context, w->t, w->y, w->g_try);
        if (s != LW_OK)
            return s;
        double g = w->g_try[c->event];
        if (i > 0 && fabs(g) > 2*fabs(g_before) && fabs(t - t_before) > 1e-12*fabs(whole)) {
            s = advance(w, t_before - w->t_old);   /* g has a kink or grazes 0: the slope led away */
            return s == LW_OK ? arrive(w) : s;
        }
        if (i > 0 && fabs(g) >= fabs(g_before))
            break;                                       /* rounding */
        if (i > 0 && fabs(t - t_before) > 1e-9*fabs(w->h_done))
            slope = (g - g_before)/(t - t_before);
        double d = slope != 0.0 ? -g/slope : 0.0;
        double x = (t + d - w->t_old)/whole;
        if (fabs(d) <= 2.0*DBL_EPSILON*fabs(t) || !(x > 0.0 && x <= 1.0))
            break;
        t_before = t, g_before = g;
        t += d;
    }
    return LW_OK;
}

static lw_status act(lw_integrator *w, double ta, const crossing *found, int n, bool *ended);

/* End the step at found[k].  What is on another side there, but was not found, crossed 0 twice between ta and the next
 * sample: the step ends at its first crossing instead. */
static lw_status end_at(lw_integrator *w, double ta, const crossing *found, int n, int k)
{
    double together = 1e-12*fabs(w->h_done) + 4.0*DBL_EPSILON*fabs(found[k].t), g[LW_EVENT_MAX];
    crossing missed[LW_EVENT_MAX];
    int n_missed = 0;
    bool ended = false;
    unsigned long long known = 0;
    lw_status s = land(w, &found[k]);
    if (s != LW_OK)
        return s;
    if (k + 1 < n && (w->t - found[k + 1].t)*w->h_done > together*fabs(w->h_done))       /* its root is not where it was found */
        return end_at(w, ta, found, n, k + 1);
    for (int i = k; i < n; i++)
        known |= 1ull << found[i].event;
    memcpy(g, w->g_try, sizeof(double)*(size_t)w->ode->n_event);
    for (int i = 0; i < w->ode->n_event; i++) {
        int turned = side_of(g[i]) != w->side[i] && (!w->ode->direction[i] || side_of(g[i]) == w->ode->direction[i]);
        g[i] = turned && !(known >> i & 1) ? g[i] : w->side[i];
    }
    s = collect(w, g, ta, w->t, missed, &n_missed);
    if (s == LW_OK && n_missed > 0 && (w->t - missed[0].t)*w->h_done > together*fabs(w->h_done))
        s = act(w, ta, missed, n_missed, &ended);
    if (s != LW_OK || ended)
        return s;
    for (int i = k; i < n && fabs(found[i].t - found[k].t) <= together; i++)
        if (!w->ode->passing[found[i].event]) {
            w->events |= 1ull << found[i].event;
            w->side[found[i].event] = (signed char)-w->side[found[i].event];
        }
    return LW_OK;
}

/* Report the events found in one interval from ta on, or end the step at one. */
static lw_status act(lw_integrator *w, double ta, const crossing *found, int n, bool *ended)
{
    for (int k = 0; k < n; k++) {
        int i = found[k].event;
        if (!w->ode->passing[i]) {
            *ended = true;
            return end_at(w, ta, found, n, k);
        }
        w->side[i] = (signed char)-w->side[i];
        w->events |= 1ull << i;
        if (w->ode->seen) {
            lw_status s = lw_integrate_dense(w, found[k].t, w->stage);
            if (s != LW_OK)
                return s;
            w->ode->seen(w->ode->context, i, found[k].t, w->stage);
        }
    }
    return LW_OK;
}

/* Event functions at a time inside the step, or at its end. */
typedef struct event_sample { double t, g[LW_EVENT_MAX]; } event_sample;

static bool is_least(int side, double a, double b, double c)
{
    a *= side, b *= side, c *= side;
    return b > 0.0 && b <= a && b <= c && (b < a || b < c);
}

/* May an event function that is a, b, c at three times in order cross 0 about the second and come back?  A smooth one
 * goes no farther below b than it rises beside it. */
static bool may_dip(int side, double a, double b, double c)
{
    return is_least(side, a, b, c) && side*b < side*(side*a > side*c ? a : c) - side*b;
}

static bool counts(const lw_integrator *w, int event)
{
    return !w->ode->direction[event] || w->ode->direction[event] != w->side[event];
}

/* Seek the extreme of one event function by golden sections, until a value past 0 is found (its time *t, all functions in g_try),
 * or none can be.  LW_NOTHING: there is none. */
static lw_status seek_dip(lw_integrator *w, int event, const event_sample *a, const event_sample *b, const event_sample *c,
                          double *t)
{
    const double golden = 0.381966011250105, shortest = 1e-5*fabs(w->h_done);
    double ta = a->t, tb = b->t, tc = c->t, ga = a->g[event], gb = b->g[event], gc = c->g[event];
    int side = w->side[event];
    bool skewed;
    do {
        bool after = fabs(tc - tb) > fabs(tb - ta);
        double g;
        *t = tb + golden*((after ? tc : ta) - tb);
        lw_status s = g_at(w, event, *t, &g, w->stage);
        if (s != LW_OK || side_of(g) != side)
            return s;
        bool nearer = side*g < side*gb;
        if (nearer == after)
            ta = nearer ? tb : *t, ga = nearer ? gb : g;
        else
            tc = nearer ? tb : *t, gc = nearer ? gb : g;
        if (nearer)
            tb = *t, gb = g;
        skewed = fmin(fabs(tb - ta), fabs(tc - tb)) < 0.2*fabs(tc - ta);     /* then the three values do not show how deep the extreme is */
    } while (fabs(tc - ta) > shortest && (skewed || may_dip(side, ga, gb, gc)));
    return LW_NOTHING;
}

/* Find events that cross 0 near b and come back, all between a and c.  near: b is so close to a or c that the three values do not
 * show how deep the extreme is. */
static lw_status find_dips(lw_integrator *w, const event_sample *a, const event_sample *b, const event_sample *c, bool near,
                           bool *ended)
{
    const lw_ode *ode = w->ode;
    for (int i = 0; i < ode->n_event && !*ended; i++) {
        crossing found[LW_EVENT_MAX];
        event_sample dip = *b;
        lw_status s = LW_OK;
        int n = 0;
        if (!counts(w, i))
            continue;
        if (!near || !(w->side[i]*b->g[i] < 0.0 && w->side[i]*a->g[i] > 0.0)) {
            if (!(near ? is_least : may_dip)(w->side[i], a->g[i], b->g[i], c->g[i]))
                continue;
            s = seek_dip(w, i, a, b, c, &dip.t);
            memcpy(dip.g, w->g_try, sizeof(double)*(size_t)ode->n_event);
        }
        if (s == LW_NOTHING)
            continue;
        if (s == LW_OK)
            s = collect(w, dip.g, a->t, dip.t, found, &n);
        if (s == LW_OK)
            s = act(w, a->t, found, n, ended);
        if (s == LW_OK && !*ended)                       /* it is passing, and comes back */
            s = collect(w, c->g, dip.t, c->t, found, &n);
        if (s == LW_OK && !*ended)
            s = act(w, dip.t, found, n, ended);
        if (s != LW_OK)
            return s;
    }
    return LW_OK;
}

/* May an event function cross 0 near the sample b and come back? */
static bool suspects(const lw_integrator *w, const event_sample *a, const event_sample *b, const event_sample *c)
{
    for (int i = 0; i < w->ode->n_event; i++)
        if (counts(w, i) && may_dip(w->side[i], a->g[i], b->g[i], c->g[i]))
            return true;
    return false;
}

/* May one cross 0 and come back between an end of the step and the sample inside next to it?  far: the sample after that. */
static bool suspects_end(const lw_integrator *w, const event_sample *end, const event_sample *inside, const event_sample *far)
{
    for (int i = 0; i < w->ode->n_event; i++)
        if (counts(w, i) && w->side[i]*end->g[i] < w->side[i]*inside->g[i] && may_dip(w->side[i], far->g[i], end->g[i], far->g[i]))
            return true;
    return false;
}

/* The same at an end of the step: a sample close to it shows whether the extreme is in this step. */
static lw_status find_dips_at_end(lw_integrator *w, const event_sample *end, const event_sample *inside,
                                  const event_sample *far, bool *ended)
{
    const double share = 1e-4;
    if (!suspects_end(w, end, inside, far))
        return LW_OK;
    event_sample beside = { .t = end->t + share*(inside->t - end->t) };
    lw_status s = g_at(w, 0, beside.t, beside.g, w->stage);
    memcpy(beside.g, w->g_try, sizeof(double)*(size_t)w->ode->n_event);
    bool first = end->t == w->t_old;
    return s == LW_OK ? find_dips(w, first ? end : inside, &beside, first ? inside : end, true, ended) : s;
}

/* Find events between t_old and t.  Passing ones are reported to `seen`; the step ends at the first other one (*ended,
 * w->events).  Where there may be one, the samples are taken again, of the continuous solution. */
static lw_status find_events(lw_integrator *w, bool *ended)
{
    const lw_ode *ode = w->ode;
    size_t bytes = sizeof(double)*(size_t)ode->n_event;
    crossing found[LW_EVENT_MAX];
    event_sample at[SAMPLES + 1];
    bool exact = false;
    signed char first[LW_EVENT_MAX];
    memcpy(first, w->side, sizeof first);
    at[0].t = w->t_old;
    memcpy(at[0].g, w->g_old, bytes);
    for (int k = 1; k <= SAMPLES; k++) {
        double x = (double)k/SAMPLES, *y = k < SAMPLES ? w->stage : w->y;
        bool change = false;
        lw_status s = LW_OK;
        at[k].t = k < SAMPLES ? w->t_old + x*w->h_done : w->t;
        if (k < SAMPLES && !exact)
            cubic(w, x, y);
        else if (k < SAMPLES)
            s = lw_integrate_dense(w, at[k].t, y);
        if (s == LW_OK)
            s = ode->event(ode->context, at[k].t, y, w->g_try);
        if (s != LW_OK)
            return s;
        memcpy(at[k].g, w->g_try, bytes);
        for (int i = 0; i < ode->n_event; i++) {
            if (isnan(w->g_try[i]))
                return LW_E_NUMERIC;
            change = change || side_of(w->g_try[i]) != w->side[i];
        }
        if (!exact && (change || (k > 1 && suspects(w, &at[k - 2], &at[k - 1], &at[k]))
                       || (k == 2 && suspects_end(w, &at[0], &at[1], &at[2]))
                       || (k == SAMPLES && suspects_end(w, &at[k], &at[k - 1], &at[k - 2])))) {
            exact = true;
            k = 0;
            continue;
        }
        if (k == 2 || (k == 1 && change))
            s = find_dips_at_end(w, &at[0], &at[1], &at[k], ended);
        if (s == LW_OK && !*ended && k > 1)
            s = find_dips(w, &at[k - 2], &at[k - 1], &at[k], false, ended);
        if (s == LW_OK && !*ended && change) {
            int n = 0;
            s = collect(w, at[k].g, at[k - 1].t, at[k].t, found, &n);
            if (s == LW_OK)
                s = act(w, at[k - 1].t, found, n, ended);
        }
        for (int i = 0; i < ode->n_event; i++)
            if (w->side[i] != first[i])
                at[0].g[i] = NAN;                        /* it began on the other side */
        if (s == LW_OK && !*ended && k == SAMPLES)
            s = find_dips_at_end(w, &at[k], &at[k - 1], &at[k - 2], ended);
        if (s != LW_OK || *ended)
            return s;
    }
    memcpy(w->g_try, at[SAMPLES].g, bytes);
    memcpy(w->g_old, at[SAMPLES].g, bytes);
    return LW_OK;
}

/* ---- the public step ----------------------------------------------------------------------------- */

static lw_status too_short(const lw_integrator *w, double h, lw_error *e)
{
    if (fabs(h) > 4.0*DBL_EPSILON*fabs(w->t_old) && fabs(h) > DBL_MIN)
        return LW_OK;
    lw_error why = { .text = "the motion is singular there, a load is not a number behind it, or the tolerance is below rounding" };
    if (told(e, LW_OPEN))
        why = *e;
    return lw_error_set(e, LW_E_NUMERIC, "at t = %.12g s the steps became too short (%.3g s): %s", w->t_old, fabs(h), why.text);
}

/* Growth of the step after one of error err; before: the length of the step before it, 0 if that or this one was cut short. Where
 * rounding of f dominates the error estimate, which then falls only in proportion to the step, proportional-integral control does not
 * make steps much shorter than needed. Where f is accurate to rounding (smooth), the predictive control of Gustafsson (1994) continues
 * the change of the error's coefficient, err/h^8, from step to step: for the same error it takes four fifths of the evaluations of
 * one-coordinate models with losses, in which that changes fast. */
static double growth(const lw_integrator *w, double err, double before)
{
    if (!w->o.smooth)
        return 0.9*pow(err, -0.117)*pow(w->err_old, 0.04);
    return before > 0.0 ? 0.85*fabs(w->h_done)/before*pow(err, -1.2/8)*pow(w->err_old, 0.7/8) : 0.9*pow(err, -1.0/8);
}

/* Is the step as long as stability allows?  Between the last stage and the end of a step, f changes by the fastest rate times what the state
 * changes by (Hairer & Wanner 1996, section IV.2). */
static const double at_limit = 6.1;
enum { FORGETS = 6 };                        /* other steps in a row, after which the count begins anew */

/* Steps do not grow beyond that length by more than `beyond`.  The error of a state that has died away is small there and much too great just
 * behind, so that steps which grow by their errors alone are refused again and again. */
static const double beyond = 1.03;

static double stable_growth(const lw_integrator *w)
{
    return w->reach > 0.0 ? fmax(1.0, beyond*at_limit/w->reach) : INFINITY;
}

static void note_limit(lw_integrator *w)
{
    bool at = w->reach > at_limit;
    w->n_free = at ? 0 : w->n_free + 1;
    w->n_limited = at ? w->n_limited + 1 : w->n_free < FORGETS ? w->n_limited : 0;
}

/* Try steps from t_old until one is accepted; *last is set if it reached t_end. */
static lw_status accept_step(lw_integrator *w, double t_end, bool *last, lw_error *e)
{
    double sign = t_end < w->t_old ? -1.0 : 1.0, factor_max = 6.0, moved = INFINITY;
    if (e)
        e->status = LW_OK;
    for (;;) {
        if (w->o.max_step > 0 && w->n_step + w->n_refused >= w->o.max_step)
            return lw_error_set(e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", w->t_old, w->o.max_step);
        double left = fabs(t_end - w->t_old - w->t_step), h = w->o.fixed > 0.0 ? w->o.fixed : w->h;
        if (w->o.greatest > 0.0)
            h = fmin(h, w->o.greatest);
        const double proposed = h;
        *last = h*(1.0 + 1e-10) >= left;                 /* avoid a tiny last step */
        h = sign*(*last ? left : !w->o.fixed && 2.0*h > left ? 0.5*left : h);
        lw_status s = too_short(w, h, e);
        if (s != LW_OK)
            return s;
        s = advance(w, h);
        double err = s == LW_OK ? w->o.fixed > 0.0 ? 0.0 : step_error(w, h) : NAN;
        if (s == LW_OK && err <= 1.0)
            s = arrive(w);
        if (s == LW_OK && err <= 1.0 && w->moved > 1.0 && w->o.fixed <= 0.0) {
            if (w->moved > 0.5*moved)                    /* a shorter step did not help: rounding */
                w->rounding = fmax(w->rounding, w->moved);
            moved = w->moved;
            err = moved > 4.0*w->rounding ? moved : err;
        }
        if (s == LW_OK && err <= 1.0 && w->o.fixed <= 0.0) {
            double apart = end_apart(w, h);
            err = apart <= 1.0 ? err : apart;
        }
        if (s == LW_OK && err <= 1.0) {
            bool full = fabs(h) == proposed;             /* the error of a step cut short says nothing about the trend */
            double f = err > 0.0 ? growth(w, err, full ? w->h_old : 0.0) : factor_max;
            double next = fabs(h)*fmin(fmin(factor_max, fmax(1.0/3.0, f)), stable_growth(w));
            w->h = *last && next < w->h && f >= 1.0 ? w->h : next;
            w->err_old = fmax(err, 1e-4);
            w->h_old = full ? proposed : 0.0;
            w->n_step++;
            note_limit(w);
            return LW_OK;
        }
        if (s != LW_OK && s != LW_OPEN)
            return told(e, s) ? s : lw_error_set(e, s, "the equations of motion fail near t = %.9g s: %s", w->t_old, lw_status_text(s));
        if (w->o.fixed > 0.0)
            return lw_error_set(e, LW_E_NUMERIC, "a step of fixed length fails at t = %.9g s", w->t_old);
        w->n_refused++;
        factor_max = 1.0;
        w->h = fabs(h)*(err > 1.0 && err < 1e300 ? fmax(1.0/3.0, 0.9*pow(err, -0.125)) : 0.1);
    }
}

/* Most of the error of a step over a break of f is made at the break: its share of the error allowed. */
static const double over_break = 0.03;
static const double shortest = 1e-11;        /* step over the time, below which it does not become shorter for that */

lw_status lw_integrate_step(lw_integrator *w, double t_end, lw_ode_stop *stop, lw_error *e)
{
    size_t bytes = sizeof(double)*(size_t)w->ode->n;
    *stop = LW_ODE_END;
    w->events = 0;
    if (lw_ode_at_end(w->t, t_end)) {
        w->t = t_end, w->t_low = 0.0;
        return LW_OK;
    }
    if (w->h == 0.0 && w->o.fixed <= 0.0) {
        w->h = w->o.first;
        lw_status s = w->h > 0.0 ? LW_OK : first_step(w, t_end < w->t ? -1.0 : 1.0);
        if (s != LW_OK)
            return lw_error_set(e, s, "no first step is possible at t = %.9g s: %s", w->t, lw_status_text(s));
    }
    w->t_old = w->t;
    memcpy(w->y_old, w->y, bytes);
    memcpy(w->k[0], w->dy, bytes);
    memcpy(w->y_step, w->low, bytes);
    w->t_step = w->t_low;
    bool last = false, found = false;
    signed char side[LW_EVENT_MAX];
    memcpy(side, w->side, sizeof side);
    lw_status s = accept_step(w, t_end, &last, e);
    for (; s == LW_OK; s = accept_step(w, t_end, &last, e)) {
        if (last)
            w->t = t_end, w->t_low = 0.0;                /* exactly t_end; t_old + h may differ by rounding */
        lw_status look = w->ode->n_event > 0 ? find_events(w, &found) : LW_OK;
        bool coarse = look == LW_OK && found && (w->events & w->ode->breaks) && w->err_old > over_break && !(w->o.fixed > 0.0)
                   && fabs(w->h_done) > shortest*fabs(w->t_old);
        if (look == LW_OK && !coarse)
            break;
        if (coarse) {
            memcpy(w->side, side, sizeof side);
            w->events = 0;
            found = false;
            w->h = fabs(w->h_done)*fmax(0.1, 0.5*over_break/w->err_old);
            w->n_refused++;
            continue;
        }
        if (look != LW_OPEN || w->o.fixed > 0.0) {
            s = told(e, look) ? look : lw_error_set(e, look, "an event near t = %.9g s cannot be located: %s", w->t, lw_status_text(look));
            break;
        }
        /* f is undefined inside the step although its end is valid: try a shorter step */
        memcpy(w->side, side, sizeof side);
        w->h = w->retry > 0.0 ? w->retry : 0.25*fabs(w->h_done);
        w->retry = 0.0;
        w->n_refused++;
    }
    if (s != LW_OK) {
        w->t = w->t_old, w->t_low = w->t_step;
        memcpy(w->y, w->y_old, bytes);
        memcpy(w->dy, w->k[0], bytes);
        memcpy(w->low, w->y_step, bytes);
        return s;
    }
    for (int i = 0; found && i < w->ode->n_event; i++)
        w->g_old[i] = NAN;                               /* unknown until the restart */
    *stop = found ? LW_ODE_EVENT : last ? LW_ODE_END : LW_ODE_STEP;
    return LW_OK;
}
