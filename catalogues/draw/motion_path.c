/* catalogues/draw/motion_path.c - see motion_path.h */
#include "catalogues/draw/motion_path.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"

#define REACH 8.0                     /* a curve that does not close is followed this far, sizes of the linkage */
#define PATIENCE 60                   /* random postures without a new curve after which the search ends */

static double input_at(lw_motion_curve *motion, double station)
{
    double q[LW_SYSTEM_Q_MAX];
    lw_motion_curve_posture(motion, station, q, NULL);
    return lw_motion_curve_input(motion, q);
}

/* Stations of the nearest limits of the input before and after station `at`; the ends of the curve where there is none.
 * Returns the number of limits of the curve. */
static int limits_around(const lw_motion_curve *motion, double at, double around[2])
{
    int n, found = 0;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    around[0] = 0;
    around[1] = lw_motion_curve_segments(motion);
    for (int i = 0; i < n; i++) {
        if (e[i].kind != LW_EVENT_LIMIT)
            continue;
        found++;
        if (e[i].station <= at)
            around[0] = fmax(around[0], e[i].station);
        else
            around[1] = fmin(around[1], e[i].station);
    }
    return found;
}

void lw_motion_path_choose(lw_motion_path *c, int curve)
{
    lw_motion_curve *motion = c->curves.curve[curve];
    double around[2], start = lw_motion_curve_start(motion), length = lw_motion_curve_length(motion);
    c->shown = curve;
    c->loops = lw_motion_curve_ended(motion) == LW_MOTION_CURVE_CLOSED;
    c->turns = c->loops ? abs(lw_motion_curve_turns(motion, -1)) : 0;
    bool even = limits_around(motion, 0, around) == 0 && c->turns > 0;
    c->pace = even ? LW_PACE_INPUT : LW_PACE_ARC;
    c->from = input_at(motion, 0);
    c->to = input_at(motion, lw_motion_curve_segments(motion));
    c->start = c->loops ? 0 : acos(1 - 2*fmin(fmax(lw_motion_curve_arc(motion, start)/length, 0), 1))/LW_PI;
}

lw_status lw_motion_path_along(const lw_linkage *linkage, bool all, lw_motion_path *c, lw_error *e)
{
    const lw_motion_curve_options o = { .input = 0, .reach = REACH };
    *c = (lw_motion_path){ .turns = 0 };
    lw_status st = lw_system_make(linkage, NULL, 0, &c->s, e);
    if (st == LW_OK)
        st = lw_circuits_find(&c->s, NULL, &o, all ? PATIENCE : 0, 1, &c->curves, e);
    if (st == LW_OK)
        lw_motion_path_choose(c, 0);
    return st;
}

lw_status lw_motion_path_in_time(const lw_linkage *linkage, lw_input_function *motion, void *context, double from,
                                 double to, lw_motion_path *c, lw_error *e)
{
    double q[LW_SYSTEM_Q_MAX], apart = 0;
    *c = (lw_motion_path){ .pace = LW_PACE_TIME, .from = from, .to = to };
    lw_status st = lw_system_make(linkage, NULL, 0, &c->s, e);
    if (st == LW_OK)
        st = lw_prescribed_motion_create(&c->s, NULL, motion, context, from, &c->drive, e);
    if (st != LW_OK)
        return st;
    memcpy(q, lw_prescribed_motion_posture(c->drive), (size_t)c->s.n_q*sizeof *q);
    st = lw_prescribed_motion_to(c->drive, to);
    if (st != LW_OK) {
        double last = lw_prescribed_motion_time(c->drive);
        c->to = from + (last - from)*(1 - 1e-9);
        lw_prescribed_motion_ended(c->drive, st, LW_VIEW(linkage), e);
        return LW_OPEN;
    }
    for (int i = 0; i < c->s.n_q; i++) {
        double d = lw_prescribed_motion_posture(c->drive)[i] - q[i];
        apart = fmax(apart, fabs(i % 3 == 2 ? remainder(d, 2*LW_PI) : d));
    }
    c->loops = apart < 1e-6;
    return LW_OK;
}

void lw_motion_path_free(lw_motion_path *c)
{
    lw_circuits_free(&c->curves);
    lw_prescribed_motion_free(c->drive);
    c->drive = NULL;
    lw_system_free(&c->s);
}

/* Station of curve 0 where the input is u. u lies between the limits next to the posture. On a closed curve the posture
 * is at station 0, so that its neighbourhood is at both ends of the stations. */
static double station_of(const lw_motion_path *c, double u)
{
    lw_motion_curve *motion = c->curves.curve[0];
    double around[2], at = lw_motion_curve_start(motion), end = lw_motion_curve_segments(motion);
    double total = c->turns ? input_at(motion, end) - input_at(motion, 0) : 0;
    int limits = limits_around(motion, at, around);
    if (lw_motion_curve_ended(motion) != LW_MOTION_CURVE_CLOSED)
        return lw_motion_curve_find(motion, around[0], around[1], u);
    double first = input_at(motion, 0);
    if (limits == 0)
        return lw_motion_curve_find(motion, 0, end, total != 0 ? u - total*floor((u - first)/total) : u);
    if (u >= first)
        return lw_motion_curve_find(motion, 0, around[1], u);
    limits_around(motion, end, around);
    return lw_motion_curve_find(motion, around[0], end, u + input_at(motion, end) - first);
}

/* The inputs at the limits next to the posture of curve 0, the smaller first. */
static void input_limits(const lw_motion_path *c, double limit[2])
{
    lw_motion_curve *motion = c->curves.curve[0];
    double around[2], at = lw_motion_curve_start(motion), end = lw_motion_curve_segments(motion);
    bool closed = lw_motion_curve_ended(motion) == LW_MOTION_CURVE_CLOSED;
    int n = limits_around(motion, at, around);
    if (closed && n == 0) {
        limit[0] = -INFINITY;
        limit[1] = INFINITY;
        return;
    }
    double a = input_at(motion, around[0]), z = input_at(motion, around[1]);
    if (closed) {
        limits_around(motion, end, around);
        a = input_at(motion, around[0]) - (input_at(motion, end) - input_at(motion, 0));
    }
    limit[0] = fmin(a, z);
    limit[1] = fmax(a, z);
}

void lw_motion_path_restrict(lw_motion_path *c, double first, double last)
{
    double limit[2];
    lw_motion_path_choose(c, 0);
    double now = input_at(c->curves.curve[0], lw_motion_curve_start(c->curves.curve[0]));
    input_limits(c, limit);
    c->from = fmax(first, limit[0]);
    c->to = fmin(last, limit[1]);
    c->pace = LW_PACE_RANGE;
    c->loops = false;
    c->start = acos(1 - 2*fmin(fmax((now - c->from)/(c->to - c->from), 0), 1))/LW_PI;
}

static double first_input(const lw_system *s, const double *q)
{
    if (s->n_input == 0)
        return 0;
    int joint = s->input_joint[0];
    double unit = lw_system_joint_unit(s, joint);
    return s->input_value[0] + unit*lw_system_measure(s, joint, q, NULL);
}

/* Station on the shown curve at t.  *input is set only where the pace prescribes it. */
static double station_at(const lw_motion_path *c, double t, double *input)
{
    lw_motion_curve *motion = c->curves.curve[c->shown];
    double end = lw_motion_curve_segments(motion), eased = 0.5 - 0.5*cos(LW_PI*t);
    if (c->pace == LW_PACE_RANGE) {
        *input = c->from + eased*(c->to - c->from);
        return station_of(c, *input);
    }
    if (t == 0 || t == 1)
        return t*end;
    if (c->pace == LW_PACE_INPUT)
        return lw_motion_curve_find(motion, 0, end, c->from + t*(c->to - c->from));
    return lw_motion_curve_station(motion, lw_motion_curve_length(motion)*(c->loops ? t : eased));
}

double lw_motion_path_at(lw_motion_path *c, double t, double *q)
{
    double input = NAN;
    t = fmin(fmax(t, 0), 1);
    if (c->pace == LW_PACE_TIME) {
        lw_prescribed_motion_to(c->drive, c->from + t*(c->to - c->from));
        memcpy(q, lw_prescribed_motion_posture(c->drive), (size_t)c->s.n_q*sizeof *q);
    } else
        lw_motion_curve_posture(c->curves.curve[c->shown], station_at(c, t, &input), q, NULL);
    return isnan(input) ? first_input(&c->s, q) : input;
}

double lw_motion_path_duration(bool (*alike)(void *context, double a, double b), void *context)
{
    static const double span[] = { 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100 };
    for (size_t i = 0; i < sizeof span/sizeof *span; i++) {
        double t = span[i];
        bool again = alike(context, 0, t) && alike(context, 0.3*t, 1.3*t) && alike(context, 0.6*t, 1.6*t);
        bool rest = alike(context, t, 1.3*t) && alike(context, t, 2*t);
        if ((again || rest) && !alike(context, 0, 0.37*t))
            return t;
    }
    return 1;
}
