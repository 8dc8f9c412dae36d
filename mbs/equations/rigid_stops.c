#include "base/real.h"
#include "mbs/equations/rigid_stops_internal.h"

#include <string.h>

static const double passed = 1e-6;           /* a gap below minus this: the stop is passed, scaled */
static const double still = 1e-13;           /* a rate below this over the greatest velocity is rounding */

int lw_rigid_stops_find(const lw_model *m, const lw_system *s, lw_rigid_stop *stop)
{
    int n = 0;
    for (int j = 0; j < s->n_joint; j++) {
        const lw_joint_stop *p = &m->stop[j];
        double scale = 1/lw_system_joint_unit(s, j);
        if (p->stiffness > 0)
            continue;
        if (p->has_least)
            stop[n++] = (lw_rigid_stop){ j, j, 1, p->least*scale, p->restitution, false, false, false };
        if (p->has_greatest)
            stop[n++] = (lw_rigid_stop){ j, j, -1, p->greatest*scale, p->restitution, false, false, false };
    }
    return n;
}

double lw_rigid_stop_gap(const lw_system *s, const lw_rigid_stop *stop, const double *q, double *row)
{
    double value = lw_system_measure(s, stop->joint, q, row);
    for (int i = 0; row && i < s->n_q; i++)
        row[i] *= stop->sign;
    return stop->sign*(value - stop->limit);
}

lw_gap lw_rigid_stop_motion(const lw_system *s, const lw_rigid_stop *stop, const double *q, const double *v, const double *a, double *row)
{
    double series[3*LW_SYSTEM_Q_MAX], out[3];
    int n = s->n_q;
    lw_gap gap = { .value = lw_rigid_stop_gap(s, stop, q, row) };
    for (int i = 0; i < n; i++) {
        gap.rate += row[i]*v[i];
        series[i] = q[i];
        series[n + i] = v[i];
        series[2*n + i] = 0.5*a[i];
    }
    lw_system_measure_series(s, stop->joint, 2, series, out);
    gap.acceleration = 2*stop->sign*out[2];
    return gap;
}

/* Bodies that only touch are struck one after the other, not as one. */
static lw_status part_touching(const lw_stops *s, double t, double *y)
{
    lw_status st = LW_OK;
    for (int i = 0; st == LW_OK && i < s->n_stop; i++)
        if (s->stop[i].resting && s->stop[i].touching) {
            s->stop[i].resting = false;
            st = s->arrange(s->context, i, t, y);
        }
    return st;
}

/* Stop i is hit. */
static lw_status strike(const lw_stops *s, int i, double t, double *y, double *g, double rate, lw_error *e)
{
    double *change = s->change, mobility, *v = y + s->v, restitution = s->stop[i].restitution;
    lw_gap gap;
    lw_status st = s->impulse(s->context, t, y, g, change, &mobility);
    if (st == LW_NOTHING)
        return lw_error_set(e, LW_E_NUMERIC, "the stop of joint \"%s\" is hit at t = %.9g s, but motions and joints "
                            "leave it no way to give", s->name(s->context, i), t);
    if (st != LW_OK)
        return st;
    for (int k = 0; k < s->n; k++)
        v[k] -= (1 + restitution)*rate/mobility*change[k];
    st = s->motion(s->context, i, t, y, g, &gap);
    if (st != LW_OK)
        return st;
    bool low = gap.rate*gap.rate <= -2*gap.acceleration*s->least_bounce;
    if (gap.acceleration <= 0 && (gap.rate <= 0 || low)) {
        s->stop[i].resting = true;
        s->stop[i].touching = false;
        return s->arrange(s->context, i, t, y);
    }
    for (int k = 0; restitution == 0 && k < s->n; k++)
        v[k] -= gap.rate/mobility*change[k];
    return LW_OK;
}

/* Its force has just passed 0: it is left, for its acceleration there is rounding. */
static bool is_due(const lw_stops *s, int i) { return i < 64 && s->due >> i & 1; }

static double rounding_of_rate(const lw_stops *s, const double *y)
{
    double fastest = 0;
    for (int k = 0; k < s->n; k++)
        fastest = fmax(fastest, fabs(y[s->v + k]));
    return still*fastest;
}

static bool closes(const lw_stops *s, int i, const double *y, const lw_gap *gap)
{
    return gap->rate <= 0 && !(gap->rate >= -rounding_of_rate(s, y) && (is_due(s, i) || gap->acceleration >= 0));
}

/* At a closed stop nothing moves and nothing pushes, so later pushes decide: it is rested on, and left by the first that pulls. */
static bool touches(const lw_stops *s, int i, const double *y, const lw_gap *gap)
{
    return !is_due(s, i) && fabs(gap->rate) <= rounding_of_rate(s, y) && fabs(gap->acceleration) <= gap->rounding;
}

static lw_status strike_all(const lw_stops *s, double t, double *y, bool *any, lw_error *e)
{
    double *g = s->gradient;
    for (int i = 0; i < s->n_stop; i++) {
        lw_gap gap;
        if (s->stop[i].resting || s->gap(s->context, i, y) > LW_STOP_CLOSED)
            continue;
        lw_status st = s->motion(s->context, i, t, y, g, &gap);
        if (st == LW_OK && fabs(gap.value) > passed) {
            if (s->passed_is_error)
                return lw_error_set(e, LW_E_ARG, "the stop of joint \"%s\" is passed at t = %.9g s", s->name(s->context, i), t);
            continue;
        }
        if (st == LW_OK && touches(s, i, y, &gap)) {
            s->stop[i].resting = s->stop[i].touching = true;
            st = s->arrange(s->context, i, t, y);
            *any |= s->stop[i].resting;
            if (st == LW_OK)
                continue;
        }
        if (st == LW_OK && !closes(s, i, y, &gap))
            continue;
        if (st == LW_OK && s->note)
            s->note(s->context, i, t, true, gap.rate);
        if (st == LW_OK)
            st = part_touching(s, t, y);
        if (st == LW_OK)
            st = s->motion(s->context, i, t, y, g, &gap);
        if (st == LW_OK)
            st = strike(s, i, t, y, g, gap.rate, e);
        if (st != LW_OK)
            return st;
        *any = true;
    }
    return LW_OK;
}

/* Leaves the first stop that would have to pull; `due` counts in the first pass. */
static lw_status leave_one(const lw_stops *s, double t, double *y, bool first, bool *any)
{
    for (int i = 0; i < s->n_stop; i++) {
        double press;
        if (!s->stop[i].resting)
            continue;
        lw_status st = s->pressure(s->context, i, t, y, &press);
        if (st != LW_OK)
            return st;
        if (press >= 0 && !(first && is_due(s, i)))
            continue;
        if (s->note)
            s->note(s->context, i, t, false, 0);
        s->stop[i].resting = false;
        *any = true;
        return s->arrange(s->context, i, t, y);
    }
    return LW_OK;
}

static lw_status find_flight(const lw_stops *s, double t, const double *y, double *flight)
{
    double *g = s->gradient;
    *flight = 0;
    for (int i = 0; i < s->n_stop; i++) {
        lw_gap gap;
        if (s->stop[i].resting || fabs(s->gap(s->context, i, y)) > LW_STOP_CLOSED)
            continue;
        lw_status st = s->motion(s->context, i, t, y, g, &gap);
        if (st != LW_OK)
            return st;
        double f = gap.rate > 0 && gap.acceleration < -gap.rounding ? -2*gap.rate/gap.acceleration : 0;
        if (f > 0 && (*flight == 0 || f < *flight))
            *flight = f;
    }
    return LW_OK;
}

lw_status lw_stops_strike(const lw_stops *stops, double t, double *y, bool *changed, double *flight, lw_error *e)
{
    lw_stops own = *stops, *s = &own;
    *changed = false;
    for (int i = 0; i < s->n_stop && i < 64; i++)        /* events of the others are impacts */
        s->due &= ~((unsigned long long)!s->stop[i].resting << i);
    for (int pass = 0; pass < 100; pass++) {
        bool any = false;
        lw_status st = strike_all(s, t, y, &any, e);
        if (st == LW_OK)
            st = leave_one(s, t, y, pass == 0, &any);
        if (st != LW_OK)
            return st;
        if (!any)
            return find_flight(s, t, y, flight);
        *changed = true;
    }
    return lw_error_set(e, LW_E_NUMERIC, "stops strike each other without end at t = %.9g s", t);
}
