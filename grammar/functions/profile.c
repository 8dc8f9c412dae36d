/* grammar/functions/profile.c - see profile.h for the method.
 *
 * Notation of this file, for the motion of greatest way: the acceleration rises from a0 to a peak, stays there,
 * falls to a valley, stays there, rises to a1.  up, down: 1/jerk of rising and falling; both: their sum. */
#include "grammar/functions/profile.h"

#include <string.h>
#include "base/real.h"

#define ROUNDING   1e-12       /* of a time or acceleration, relative: what counts as nought */
#define TIMES_MAX  24          /* ends of intervals and borders of formulas                  */

/* A motion between two states, seen so that the way is to be greatest: mirrored for the least. */
typedef struct transfer {
    double v0, a0, v1, a1;
    double v_most, a_least, a_most;
    double up, down, both;
} transfer;

typedef struct phases { int n; double t[7], jerk[7], a[7]; } phases;

/* The greatest way at one duration. */
typedef struct extreme {
    double way, slope;         /* slope: its derivative by the duration */
    double peak, hold_peak, cruise, valley, hold_valley;
    bool   cruises;
} extreme;

static double square(double x) { return x*x; }

static double inverse(double jerk) { return isinf(jerk) ? 0 : 1/jerk; }

static transfer transfer_of(lw_axis_state from, lw_axis_state to, const lw_axis_limits *l, bool mirrored)
{
    transfer m = { from.v, from.a, to.v, to.a, l->v[1], l->a[0], l->a[1], inverse(l->j[1]), inverse(-l->j[0]), 0 };
    if (mirrored)
        m = (transfer){ -from.v, -from.a, -to.v, -to.a, -l->v[0], -l->a[1], -l->a[0], m.down, m.up, 0 };
    m.both = m.up + m.down;
    m.a0 = m.both == 0 ? 0 : fmin(fmax(m.a0, m.a_least), m.a_most);       /* a state may pass its limit by rounding */
    m.a1 = m.both == 0 ? 0 : fmin(fmax(m.a1, m.a_least), m.a_most);
    return m;
}

/* Way of a phase and the state after it. */
static double advance(double t, double jerk, double *v, double *a)
{
    double way = t*(*v + t*(*a/2 + t*jerk/6));
    *v += t*(*a + t*jerk/2);
    *a += t*jerk;
    return way;
}

/* Peak and hold of the quickest change of speed by `gain` from acceleration a, through the peak, to acceleration 0.
 * false: the gain is too small for that. */
static bool rise_to_rest(const transfer *m, double gain, double a, double *peak, double *hold)
{
    double whole = gain + a*a/2*m->up;                     /* as if it began at acceleration 0 */
    if (m->both == 0 || whole >= m->both/2*square(m->a_most)) {
        *peak = m->a_most;
        *hold = whole/m->a_most - m->both/2*m->a_most;
        return *hold >= -ROUNDING;
    }
    *peak = sqrt(fmax(2*whole/m->both, 0));
    *hold = 0;
    return whole >= -ROUNDING*(fabs(gain) + a*a*m->up) && *peak >= a - ROUNDING*fabs(a);
}

/* The motion of greatest way that takes T.  false: no motion between these states takes T. */
static bool greatest_way(const transfer *m, double T, extreme *x)
{
    /* T - (rising from a0 to a1), and the gain of speed as if a0 and a1 were 0 */
    double K = T - m->up*(m->a1 - m->a0), C = m->v1 - m->v0 + m->up/2*(square(m->a0) - square(m->a1));
    double both = m->both, low = m->a_least, high = m->a_most;
    double small = ROUNDING*((high < INFINITY ? high : 0) - (low > -INFINITY ? low : 0) + fabs(m->a0) + fabs(m->a1));

    memset(x, 0, sizeof *x);
    if (K < 0)
        return false;
    bool known = false;
    if (both > 0) {
        if (K > 0) {
            x->peak = K/(2*both) + C/K;
            x->valley = C/K - K/(2*both);
        } else if (C != 0)
            return false;
        known = x->peak <= high && x->valley >= low;
        double q = 2*(high*K - C)/both;
        if (!known && high < INFINITY && q >= 0) {         /* the peak at its limit */
            double valley = high - sqrt(q), hold = K - both*(high - valley);
            if ((known = valley >= low && hold >= -ROUNDING*T))
                x->peak = high, x->valley = valley, x->hold_peak = fmax(hold, 0);
        }
        q = 2*(C - low*K)/both;
        if (!known && low > -INFINITY && q >= 0) {         /* the valley at its limit */
            double peak = low + sqrt(q), hold = K - both*(peak - low);
            if ((known = peak <= high && hold >= -ROUNDING*T))
                x->peak = peak, x->valley = low, x->hold_valley = fmax(hold, 0);
        }
    }
    if (!known) {                                          /* both */
        double H = K - both*(high - low), R = C - both/2*(square(high) - square(low));
        x->peak = high, x->valley = low;
        x->hold_peak = (R - low*H)/(high - low);
        x->hold_valley = H - x->hold_peak;
        if (x->hold_peak < -ROUNDING*T || x->hold_valley < -ROUNDING*T)
            return false;
        x->hold_peak = fmax(x->hold_peak, 0), x->hold_valley = fmax(x->hold_valley, 0);
    }
    if (x->peak < m->a0 - small || x->valley > m->a1 + small || x->peak < x->valley - small)
        return false;

    if (x->peak > 0 && x->valley < 0) {
        double top = m->v0 + (square(x->peak) - square(m->a0))/2*m->up + x->peak*x->hold_peak
                     + square(x->peak)/2*m->down;
        if (top > m->v_most) {                             /* the speed at its limit, between two quickest changes */
            double valley;
            transfer back = *m;                            /* seen from the end, time runs backwards */
            back.a_most = -low;
            if (!rise_to_rest(m, m->v_most - m->v0, m->a0, &x->peak, &x->hold_peak)
                || !rise_to_rest(&back, m->v_most - m->v1, -m->a1, &valley, &x->hold_valley))
                return false;
            x->valley = -valley;
            x->cruise = T - (x->peak - m->a0)*m->up - x->hold_peak - (x->peak - x->valley)*m->down
                        - x->hold_valley - (m->a1 - x->valley)*m->up;
            x->cruises = true;
            if (x->cruise < -ROUNDING*T)
                return false;
            x->cruise = fmax(x->cruise, 0);
        }
    }
    return true;
}

static phases phases_of(const transfer *m, const extreme *x)
{
    double rise = inverse(m->up), fall = -inverse(m->down);
    phases p = { 0 };
    double t[7] = { fmax(x->peak - m->a0, 0)*m->up, x->hold_peak,
                    (x->cruises ? x->peak : fmax(x->peak - x->valley, 0))*m->down, x->cruise,
                    x->cruises ? -x->valley*m->down : 0, x->hold_valley, fmax(m->a1 - x->valley, 0)*m->up };
    double jerk[7] = { rise, 0, fall, 0, fall, 0, rise };
    double middle = x->cruises ? 0 : x->valley;
    double a[7] = { m->a0, x->peak, x->peak, middle, middle, x->valley, x->valley };
    for (int i = 0; i < 7; i++)
        if (t[i] > 0) {
            p.t[p.n] = t[i], p.jerk[p.n] = jerk[i], p.a[p.n] = a[i];
            p.n++;
        }
    return p;
}

/* Way of a ramp of the acceleration from a to b that takes t; a pause has a = b. */
static double ramp(double t, double a, double b, double *v)
{
    double way = t*(*v + t*(2*a + b)/6);
    *v += t*(a + b)/2;
    return way;
}

/* Way and slope of phases that are known.  The slope is the Hamiltonian v + p a of the problem, taken where the fall
 * from peak to valley begins; the costate p of the speed is nought in the middle of that fall and has slope -1. */
static void measure(const transfer *m, extreme *x)
{
    double v = m->v0, peak = x->peak, valley = x->valley, middle = x->cruises ? 0 : valley;
    double way = ramp(fmax(peak - m->a0, 0)*m->up, m->a0, peak, &v);
    way += ramp(x->hold_peak, peak, peak, &v);
    double at_fall = v;
    way += ramp(fmax(peak - middle, 0)*m->down, peak, middle, &v);
    if (x->cruises) {
        way += x->cruise*v;
        way += ramp(-valley*m->down, 0, valley, &v);
    }
    way += ramp(x->hold_valley, valley, valley, &v);
    x->way = way + ramp(fmax(m->a1 - valley, 0)*m->up, valley, m->a1, &v);
    x->slope = x->cruises ? m->v_most : at_fall + (peak - valley)*m->down/2*peak;
}

static bool evaluate(const transfer *m, double T, extreme *x)
{
    if (!greatest_way(m, T, x))
        return false;
    measure(m, x);
    return true;
}

static void insert(double t, int *n, double list[TIMES_MAX])
{
    if (!(t >= 0) || isinf(t) || *n == TIMES_MAX)
        return;
    int i = (*n)++;
    for (; i > 0 && list[i - 1] > t; i--)
        list[i] = list[i - 1];
    list[i] = t;
}

/* A duration at which greatest and least way are one: the acceleration only rises and falls, or falls and rises. */
typedef struct two_phases {
    double  T, loose;              /* [s] how exactly T is known */
    extreme most, least;           /* the same phases seen as greatest and, mirrored, as least way */
} two_phases;

static void add_two_phases(const transfer *m, bool mirrored, double T, double peak, double hold, double loose, int *n, two_phases list[4])
{
    extreme same = { .peak = peak, .hold_peak = hold, .valley = m->a1 };
    extreme other = { .peak = -m->a0, .valley = -peak, .hold_valley = hold };       /* falls and rises */
    int i = (*n)++;
    for (; i > 0 && list[i - 1].T > T; i--)
        list[i] = list[i - 1];
    list[i] = (two_phases){ T, loose, mirrored ? other : same, mirrored ? same : other };
}

/* Rising and falling between the states of m, which is mirrored if so. */
static void find_two_phases(const transfer *m, bool mirrored, int *n, two_phases list[4])
{
    double gain = m->v1 - m->v0, high = m->a_most, ends = fmax(m->a0, m->a1);
    if (m->both == 0) {
        if (gain >= 0 && !(mirrored && gain == 0))
            add_two_phases(m, mirrored, gain/high, high, gain/high, 0, n, list);
        return;
    }
    double whole = gain + square(m->a0)/2*m->up + square(m->a1)/2*m->down, q = sqrt(fmax(2*whole/m->both, 0));
    /* rounding of speeds, and what it makes of the peak */
    double loose = 1e-15*(fabs(m->v0) + fabs(m->v1)) + ROUNDING*m->both*square(ends);
    double small = fmin(loose/(m->both*fabs(ends)), sqrt(loose/m->both));
    if (whole < -loose || (whole <= loose && ends < -q - small))       /* no such duration; or a gap of no width */
        return;
    for (int sign = 1; sign >= -1; sign -= 2) {
        double peak = sign*q, hold = 0;
        if (peak < ends - small || (sign < 0 && q <= small))
            continue;
        peak = fmax(peak, ends);
        if (peak > high)
            hold = (whole - m->both/2*square(high))/high, peak = high;
        add_two_phases(m, mirrored, (peak - m->a0)*m->up + hold + (peak - m->a1)*m->down, peak, fmax(hold, 0),
                       fmin(loose/fmax(q, 1e-300), sqrt(loose*m->both)), n, list);
    }
}

/* Durations where the formulas of the greatest way change, and where its slope is least in each: between two of them
 * the slope only rises or only falls. */
static void borders(const transfer *m, int *n, double list[TIMES_MAX])
{
    double C = m->v1 - m->v0 + m->up/2*(square(m->a0) - square(m->a1)), both = m->both;
    double start = m->up*(m->a1 - m->a0), low = m->a_least, high = m->a_most, range = both/2*square(high - low);
    if (both > 0) {
        insert(start + sqrt(2*both*fabs(C)*sqrt(m->up/(m->up + 2*m->down))), n, list);
        if (high < INFINITY) {                             /* peak = high, without and with the valley at its limit */
            double r = high*(both - m->down/2)/both;
            insert(start + (both*r*r/2 + C)/high, n, list);
            double root = sqrt(square(high) - 2*C/both);
            insert(start + both*(high - root), n, list);
            insert(start + both*(high + root), n, list);
            insert(start + (C - range)/low, n, list);
        }
        if (low > -INFINITY) {
            double r = -low*(m->up + m->down/2)/both;
            insert(start + (C - both*r*r/2)/low, n, list);
            double root = sqrt(square(low) + 2*C/both);
            insert(start + both*(-low - root), n, list);
            insert(start + both*(-low + root), n, list);
            insert(start + (C + range)/high, n, list);
        }
    }
    double peak, hold, valley, hold_valley;
    transfer back = *m;
    back.a_most = -low;
    if (m->v_most < INFINITY && rise_to_rest(m, m->v_most - m->v0, m->a0, &peak, &hold)
        && rise_to_rest(&back, m->v_most - m->v1, -m->a1, &valley, &hold_valley))
        insert((peak - m->a0)*m->up + hold + (peak + valley)*m->down + hold_valley + (m->a1 + valley)*m->up, n, list);
}

/* First duration in (lo, hi] at which the greatest way reaches `way`; at lo it is at_lo, which is below.  NaN: none. */
static double first_reach(const transfer *m, double way, double lo, extreme at_lo, double hi)
{
    double border[TIMES_MAX];
    int n = 0;
    extreme at_end, x;
    borders(m, &n, border);
    for (int i = 0; i <= n && lo < hi; i++) {
        double end = i < n ? fmin(border[i], hi) : hi;
        if (end <= lo*(1 + ROUNDING) && i < n)
            continue;
        if (end == INFINITY) {                             /* the last formula */
            if (m->v_most < INFINITY && m->v_most <= 0 && at_lo.slope <= 0)
                return NAN;
            end = lo + fmax(lo, (way - at_lo.way)/fmin(fmax(m->v_most, 1e-300), 1e300)) + 1e-300;
            while (!(evaluate(m, end, &x) && x.way >= way) && end < 1e200)
                end *= 2;
        }
        double inside = end;
        for (int k = 0; k < 4 && !evaluate(m, inside, &at_end); k++)       /* an end of durations, to rounding */
            inside = end - (end - lo)*(k ? pow(10, -14 + 3*k) : 1e-15);
        if (!evaluate(m, inside, &at_end))
            return NAN;
        double a = lo, b = at_end.way >= way ? inside : lo;
        if (b == lo && at_lo.slope > 0 && at_end.slope < 0) {              /* a hump between */
            double rising = lo, falling = inside;
            for (int k = 0; k < 60 && falling - rising > 1e-15*falling; k++) {
                double middle = rising + (falling - rising)/2;
                *(evaluate(m, middle, &x) && x.slope > 0 ? &rising : &falling) = middle;
            }
            if (evaluate(m, rising, &x) && x.way >= way)
                b = rising;
        }
        if (b > a) {                                       /* Newton's method, kept between a and b */
            double t = b;
            for (int k = 0; k < 200; k++) {
                bool known = evaluate(m, t, &x);
                *(known && x.way >= way ? &b : &a) = t;
                double next = known ? t - (x.way - way)/x.slope : NAN;
                if (fabs(next - t) <= 2e-16*t)
                    return t;
                if (b - a <= 2e-16*b)
                    break;
                t = next > a && next < b ? next : a + (b - a)/2;
            }
            return b;
        }
        lo = end;
        at_lo = at_end;
    }
    return NAN;
}

typedef struct solution { double T; bool known; extreme x; } solution;       /* known: x has the phases */

/* First possible duration that is `from` or more; NaN: none.  slack: of the way, by rounding. */
static solution first_time(const transfer *most, const transfer *least, double way, double slack, double from)
{
    two_phases end[4];
    solution near = { .T = NAN };                          /* missed by rounding alone */
    int n = 0;
    find_two_phases(most, false, &n, end);
    find_two_phases(least, true, &n, end);
    for (int i = 0; i < n; i++) {
        double hi = i + 1 < n ? end[i + 1].T : INFINITY, lo = end[i].T;
        if (lo >= from*(1 - ROUNDING)) {
            measure(most, &end[i].most);
            double v = fabs(most->v0) + fabs(most->v1), a = fmin(most->a_most, -most->a_least);
            if (fabs(way - end[i].most.way) <= slack + v*(1e-14*lo + 1e-15*v/a))
                return (solution){ fmax(lo, from), true, end[i].most };
            if (near.T != near.T && fabs(way - end[i].most.way) <= 4*(slack + v*end[i].loose)) {
                /* the peak is known as loosely as this: moved so that the way is met, it changes the speed by less than
                 * its rounding */
                near = (solution){ lo, true, end[i].most };
                double late = near.x.slope != 0 ? (way - near.x.way)/near.x.slope : 0;
                double *extremum = near.x.valley == most->a1 ? &near.x.peak : &near.x.valley;
                if (fabs(late) <= 4*end[i].loose) {
                    *extremum += (extremum == &near.x.peak ? late : -late)/most->both;
                    near.T += late;
                }
            }
        }
        extreme x, y;
        double inside = isinf(hi) ? 2*fmax(lo, from) + 1e-9 : fmax(lo, from) + (hi - fmax(lo, from))/2;
        if (hi <= fmax(lo, from) || !evaluate(most, inside, &x) || !evaluate(least, inside, &y))
            continue;
        if (from > lo) {
            lo = from;
            if (!evaluate(most, lo, &x) || !evaluate(least, lo, &y))
                continue;
            if (way <= x.way + slack && way >= -y.way - slack)
                return (solution){ lo, false, x };
        } else {
            x = end[i].most, y = end[i].least;
            measure(most, &x);
            measure(least, &y);
        }
        double T = way > x.way ? first_reach(most, way, lo, x, hi) : first_reach(least, -way, lo, y, hi);
        if (T == T && !(near.T < T))
            return (solution){ T, false, x };
    }
    return near;
}

/* The phases of the mixture of both extremes that covers the way. */
static void build(const transfer *most, const transfer *least, lw_axis_state from, double way, const solution *found, lw_profile *out)
{
    extreme x = found->x, y = { 0 };
    double T = found->T, share = 1;
    memset(out, 0, sizeof *out);
    if (!found->known) {
        bool greatest = evaluate(most, T, &x), smallest = evaluate(least, T, &y);
        double width = x.way + y.way;
        share = !smallest ? 1 : !greatest ? 0 : width > 0 ? fmin(fmax((way + y.way)/width, 0), 1) : 0;
    }
    if (share < 1e-14 || share > 1 - 1e-14)
        share = round(share);
    phases p = phases_of(most, &x), q = phases_of(least, &y);
    if (share == 0)
        p.n = 0;
    if (share == 1)
        q.n = 0;
    /* Durations are taken from what is left of each phase, so that short phases stay exact after long ones. */
    double t = 0, v = from.v, position = from.x, left_p = 0, left_q = 0, a = 0;
    int i = -1, k = -1;
    for (;;) {
        while (left_p <= 0 && ++i < p.n)
            left_p = p.t[i];
        while (left_q <= 0 && ++k < q.n)
            left_q = q.t[k];
        bool has_p = i < p.n, has_q = k < q.n;
        if ((!has_p && p.n) || (!has_q && q.n) || !(p.n + q.n) || out->n == LW_PROFILE_PHASES_MAX)
            break;                                         /* both end together, to rounding */
        double step = !has_q ? left_p : !has_p ? left_q : fmin(left_p, left_q), jerk = 0;
        a = 0;
        if (has_p)
            a += share*(p.a[i] + (p.t[i] - left_p)*p.jerk[i]), jerk += share*p.jerk[i];
        if (has_q)
            a -= (1 - share)*(q.a[k] + (q.t[k] - left_q)*q.jerk[k]), jerk -= (1 - share)*q.jerk[k];
        if (step > 1e-16*T) {                              /* the sums of both differ by rounding */
            out->t[out->n] = t;
            out->at[out->n] = (lw_axis_state){ position, v, a };
            out->jerk[out->n++] = jerk;
            position += advance(step, jerk, &v, &a);
            t += step;
        }
        left_p = has_p ? left_p - step : 0;
        left_q = has_q ? left_q - step : 0;
    }
    out->t[out->n] = out->duration = out->n ? fmax(out->t[out->n - 1], T) : 0;
    out->at[out->n] = (lw_axis_state){ position, v, a };
}

static lw_status check_limits(const lw_axis_limits *l, lw_error *error)
{
    if (!(l->v[0] < l->v[1] && l->a[0] < 0 && l->a[1] > 0 && l->j[0] < 0 && l->j[1] > 0))
        return lw_error_set(error, LW_E_ARG, "limits of speed must be rising, those of acceleration and jerk below and above 0");
    for (int side = 0; side < 2; side++)
        if (isinf(l->a[side]) && isinf(l->j[side]))
            return lw_error_set(error, LW_E_ARG, "neither acceleration nor jerk is limited: the least time would be 0; "
                                "give one of the two");
    if (isfinite(l->j[0]) != isfinite(l->j[1]))
        return lw_error_set(error, LW_E_ARG, "the jerk must be limited in both directions or in neither");
    return LW_OK;
}

static bool outside(double x, const double limit[2])
{
    return x < limit[0] - ROUNDING*fabs(limit[0]) || x > limit[1] + ROUNDING*fabs(limit[1]);
}

/* A state at the start (sign +1) or the end (-1), where time runs backwards and falls become rises. */
static lw_status check_state(lw_axis_state s, const lw_axis_limits *l, int sign, lw_error *error)
{
    const char *which = sign > 0 ? "first" : "last";
    if (!isfinite(s.x) || !isfinite(s.v) || !isfinite(s.a))
        return lw_error_set(error, LW_E_ARG, "the %s state has a number that is not finite", which);
    if (outside(s.v, l->v))
        return lw_error_set(error, LW_E_ARG,
                            "the %s speed %g is outside its limits %g to %g; widen the limits or change "
                            "the speed", which, s.v, l->v[0], l->v[1]);
    if (isinf(l->j[1]))
        return LW_OK;
    if (outside(s.a, l->a))
        return lw_error_set(error, LW_E_ARG, "the %s acceleration %g is outside its limits %g to %g", which, s.a, l->a[0], l->a[1]);
    double rate = (s.a > 0) == (sign > 0) ? -l->j[0] : l->j[1];      /* jerk that brings it to 0, or from 0 */
    double v = s.v + sign*s.a*fabs(s.a)/2/rate;
    if (outside(v, l->v))
        return lw_error_set(error, LW_E_ARG, "the %s acceleration %g and the limit of jerk %g make the speed %g %s, "
                            "outside its limits %g to %g", which, s.a, rate, v, sign > 0 ? "afterwards" : "before",
                            l->v[0], l->v[1]);
    return LW_OK;
}

static lw_status check_all(lw_axis_state from, lw_axis_state to, const lw_axis_limits *l, lw_error *error)
{
    lw_status s = check_limits(l, error);
    if (s == LW_OK)
        s = check_state(from, l, 1, error);
    return s == LW_OK ? check_state(to, l, -1, error) : s;
}

static lw_status make(lw_axis_state from, lw_axis_state to, const lw_axis_limits *limits, double least, lw_profile *out, lw_error *error)
{
    transfer greatest = transfer_of(from, to, limits, false), smallest = transfer_of(from, to, limits, true);
    double way = to.x - from.x, slack = 1e-15*(fabs(from.x) + fabs(to.x));
    solution found = first_time(&greatest, &smallest, way, slack, fmax(least, 0));
    if (found.T != found.T)
        return lw_error_set(error, LW_E_ARG, "the limits of speed %g to %g do not allow a way of %g", limits->v[0], limits->v[1], way);
    build(&greatest, &smallest, from, way, &found, out);
    lw_axis_limits e = lw_profile_extremes(out);
    if (fmax(-e.v[0], e.v[1])*out->duration < fabs(way)*(1 - 1e-9))
        return lw_error_set(error, LW_E_ARG, "the way %g, the limits and the time differ by too many orders of magnitude: the motion "
                            "cannot be computed with 16 digits; choose other units, or limits nearer to what the motion needs", way);
    return LW_OK;
}

lw_status lw_profile_make(lw_axis_state from, lw_axis_state to, const lw_axis_limits *limits, double least,
                          lw_profile *out, lw_error *error)
{
    lw_status s = check_all(from, to, limits, error);
    bool rests = from.v == 0 && from.a == 0 && to.v == 0 && to.a == 0;
    if (s != LW_OK || !(least > 0) || !rests || from.x == to.x)
        return s == LW_OK ? make(from, to, limits, least, out, error) : s;
    s = make(from, to, limits, 0, out, error);
    double slower = least/(2*out->duration);
    if (s != LW_OK || slower < 50)
        return s == LW_OK ? make(from, to, limits, least, out, error) : s;
    lw_axis_limits scaled = *limits;         /* a mixture of extreme motions that go much farther would lose digits */
    for (int side = 0; side < 2; side++) {
        scaled.v[side] /= slower;
        scaled.a[side] /= slower*slower;
        scaled.j[side] /= slower*slower*slower;
    }
    return make(from, to, &scaled, least, out, error);
}

lw_status lw_profile_make_timed(lw_axis_state from, lw_axis_state to, const lw_axis_limits *limits, double duration,
                                lw_profile *out, double *next, lw_error *error)
{
    lw_status s = lw_profile_make(from, to, limits, duration, out, error);
    if (s != LW_OK)
        return s;
    if (out->duration <= duration*(1 + ROUNDING))
        return LW_OK;
    if (next)
        *next = out->duration;
    return lw_error_set(error, LW_NOTHING, "no motion within the limits takes %g s; the next duration that is possible "
                        "is %.9g s", duration, out->duration);
}

/* All axes along one line: one motion of the axis that goes farthest, for which the limits of all count. */
static lw_status make_in_phase(int n, const lw_axis_state *from, const lw_axis_state *to, const lw_axis_limits *limits,
                               double least, lw_profile *out, lw_error *error)
{
    int lead = 0;
    for (int i = 1; i < n; i++)
        if (fabs(to[i].x - from[i].x) > fabs(to[lead].x - from[lead].x))
            lead = i;
    double way = to[lead].x - from[lead].x;
    lw_axis_limits common = limits[lead];
    for (int i = 0; i < n; i++) {
        double r = way != 0 ? (to[i].x - from[i].x)/way : i == lead;
        const double own[4] = { from[i].v, from[i].a, to[i].v, to[i].a };
        const double wanted[4] = { r*from[lead].v, r*from[lead].a, r*to[lead].v, r*to[lead].a };
        for (int k = 0; k < 4; k++)
            if (fabs(own[k] - wanted[k]) > 1e-9*(fabs(own[k]) + fabs(wanted[k])))
                return lw_error_set(error, LW_NOTHING, "speeds and accelerations of axis %d are not along the line to "
                                    "the goal: a motion in phase does not exist; ask for one in time", i + 1);
        if (r == 0)
            continue;
        const double *of[3] = { limits[i].v, limits[i].a, limits[i].j };
        double *into[3] = { common.v, common.a, common.j };
        for (int k = 0; k < 3; k++) {
            into[k][0] = fmax(into[k][0], of[k][r > 0 ? 0 : 1]/r);
            into[k][1] = fmin(into[k][1], of[k][r > 0 ? 1 : 0]/r);
        }
    }
    lw_profile one;
    lw_status s = lw_profile_make(from[lead], to[lead], &common, least, &one, error);
    for (int i = 0; i < n && s == LW_OK; i++) {
        double r = way != 0 ? (to[i].x - from[i].x)/way : i == lead;
        out[i] = one;
        for (int k = 0; k <= one.n && i != lead; k++) {
            const lw_axis_state *a = &one.at[k];
            out[i].at[k] = (lw_axis_state){ from[i].x + r*(a->x - from[lead].x), r*a->v, r*a->a };
            if (k < one.n)
                out[i].jerk[k] = r*one.jerk[k];
        }
    }
    return s;
}

lw_status lw_profile_make_axes(int n, const lw_axis_state *from, const lw_axis_state *to, const lw_axis_limits *limits,
                               double least, bool in_phase, lw_profile *out, lw_error *error)
{
    if (in_phase)
        return make_in_phase(n, from, to, limits, least, out, error);
    double T = fmax(least, 0);
    for (int unchanged = 0, i = 0; unchanged < n; i = (i + 1) % n) {
        lw_status s = lw_profile_make(from[i], to[i], &limits[i], T, &out[i], error);
        if (s != LW_OK)
            return s;
        unchanged = out[i].duration > T*(1 + ROUNDING) ? 1 : unchanged + 1;
        T = fmax(T, out[i].duration);
    }
    return LW_OK;
}

lw_axis_state lw_profile_at(const lw_profile *profile, double t, double *jerk)
{
    int n = profile->n, i = n - 1;
    const lw_axis_state *at = profile->at;
    if (jerk)
        *jerk = 0;
    if (t < 0)
        return (lw_axis_state){ at[0].x + t*at[0].v, at[0].v, 0 };
    if (t > profile->duration || n == 0)
        return (lw_axis_state){ at[n].x + (t - profile->duration)*at[n].v, at[n].v, 0 };
    while (i > 0 && t < profile->t[i])
        i--;
    double v = at[i].v, a = at[i].a;
    double x = at[i].x + advance(t - profile->t[i], profile->jerk[i], &v, &a);
    if (jerk)
        *jerk = profile->jerk[i];
    /* rounding of long times leaves no acceleration beyond the ends of the phase */
    return (lw_axis_state){ x, v, fmin(fmax(a, fmin(at[i].a, at[i + 1].a)), fmax(at[i].a, at[i + 1].a)) };
}

lw_axis_limits lw_profile_extremes(const lw_profile *profile)
{
    const lw_axis_state *at = profile->at;
    lw_axis_limits e = { { at[0].v, at[0].v }, { at[0].a, at[0].a }, { 0, 0 } };
    for (int i = 0; i < profile->n; i++) {
        double jerk = profile->jerk[i], v = at[i].v, a = at[i].a;
        if (jerk != 0 && a*at[i + 1].a < 0)                          /* the speed turns where the acceleration is nought */
            advance(-a/jerk, jerk, &v, &a);
        e.v[0] = fmin(e.v[0], fmin(v, at[i + 1].v)), e.v[1] = fmax(e.v[1], fmax(v, at[i + 1].v));
        /* without a limit of jerk the acceleration steps from phase to phase */
        double end = jerk != 0 ? at[i + 1].a : at[i].a;
        e.a[0] = fmin(e.a[0], fmin(at[i].a, end)), e.a[1] = fmax(e.a[1], fmax(at[i].a, end));
        e.j[0] = i ? fmin(e.j[0], jerk) : jerk, e.j[1] = i ? fmax(e.j[1], jerk) : jerk;
    }
    return e;
}

void lw_profile_limit_power(double way, double power, double mass, lw_axis_limits *limits)
{
    if (way == 0)
        return;
    double a = pow(2*power*power/(mass*mass*fabs(way)), 1/3.0), v = power/(mass*a);
    limits->a[0] = fmax(limits->a[0], -a), limits->a[1] = fmin(limits->a[1], a);
    limits->v[0] = fmax(limits->v[0], -v), limits->v[1] = fmin(limits->v[1], v);
}

/* The ramps have one length only if the acceleration reaches its limit, which the way and the speed may not allow. */
void lw_profile_limit_frequency(double way, double frequency, lw_axis_limits *limits)
{
    if (way == 0)
        return;
    double a = fmin(limits->a[1], -limits->a[0]), j = fmin(limits->j[1], -limits->j[0]);
    double v = fmin(limits->v[1], -limits->v[0]);
    /* reached = min(a, v/ramp, way/(2 ramp^2)), reached/ramp <= j */
    double needed = isinf(j) ? 0 : fmin(fmin(a/j, sqrt(v/j)), pow(fabs(way)/(2*j), 1/3.0));
    double periods = fmax(1, ceil(needed*frequency*(1 - 1e-12)));
    double ramp = periods/frequency, reached = fmin(a, fmin(v/ramp, fabs(way)/(2*ramp*ramp)));
    for (int side = 0; side < 2; side++) {
        limits->a[side] = side ? reached : -reached;
        limits->j[side] = limits->a[side]/ramp;
    }
}
