/* mbs/ode/integrate_event.c - location of events within a step. */
#include <float.h>
#include <string.h>
#include "base/real.h"
#include "mbs/ode/integrate_internal.h"

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
        lw_status s = lw_rk_advance(w, t - w->t_old);
        if (s == LW_OK)
            s = lw_rk_arrive(w);
        if (s == LW_OK)
            s = w->ode->event(w->ode->context, w->t, w->y, w->g_try);
        if (s != LW_OK)
            return s;
        double g = w->g_try[c->event];
        if (i > 0 && fabs(g) > 1e3*fabs(g_before) && fabs(t - t_before) > 1e-12*fabs(whole)) {
            s = lw_rk_advance(w, t_before - w->t_old);   /* g has a kink there: the slope led away */
            return s == LW_OK ? lw_rk_arrive(w) : s;
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

static lw_status end_at(lw_integrator *w, const crossing *found, int n, int k)
{
    double together = 1e-12*fabs(w->h_done) + 4.0*DBL_EPSILON*fabs(found[k].t);
    lw_status s = land(w, &found[k]);
    if (s != LW_OK)
        return s;
    for (int i = k; i < n && fabs(found[i].t - found[k].t) <= together; i++)
        if (!w->ode->passing[found[i].event]) {
            w->events |= 1ull << found[i].event;
            w->side[found[i].event] = (signed char)-w->side[found[i].event];
        }
    return LW_OK;
}

/* Report the events found in one interval, or end the step at one. */
static lw_status act(lw_integrator *w, const crossing *found, int n, bool *ended)
{
    for (int k = 0; k < n; k++) {
        int i = found[k].event;
        if (!w->ode->passing[i]) {
            *ended = true;
            return end_at(w, found, n, k);
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

lw_status lw_rk_events(lw_integrator *w, bool *ended)
{
    const lw_ode *ode = w->ode;
    double ta = w->t_old, t_end = w->t, h = w->h_done;
    crossing found[LW_EVENT_MAX];
    for (int k = 1; k <= SAMPLES; k++) {
        double x = (double)k/SAMPLES, tb = k < SAMPLES ? w->t_old + x*h : t_end;
        double *y = w->y;
        if (k < SAMPLES)
            cubic(w, x, y = w->stage);
        lw_status s = ode->event(ode->context, tb, y, w->g_try);
        if (s != LW_OK)
            return s;
        bool change = false;
        for (int i = 0; i < ode->n_event; i++) {
            if (isnan(w->g_try[i]))
                return LW_E_NUMERIC;
            change = change || side_of(w->g_try[i]) != w->side[i];
        }
        if (change) {
            int n = 0;
            double g[LW_EVENT_MAX];
            memcpy(g, w->g_try, sizeof(double)*(size_t)ode->n_event);
            s = collect(w, g, ta, tb, found, &n);
            if (s == LW_OK)
                s = act(w, found, n, ended);
            if (s != LW_OK || *ended)
                return s;
            memcpy(w->g_try, g, sizeof(double)*(size_t)ode->n_event);
        }
        ta = tb;
    }
    return LW_OK;
}
