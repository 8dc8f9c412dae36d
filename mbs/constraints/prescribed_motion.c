/* mbs/constraints/prescribed_motion.c - follow inputs that are functions of time.
 *
 * With one input the posture is a function of its value, whatever the input does in time: only the value is followed, in certified
 * steps (`place`).  The motion in time leads from value to value.  Several inputs are followed along time itself. */
#include "mbs/constraints/prescribed_motion.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/number.h"
#include "base/rng.h"
#include "base/vector.h"
#include "mbs/constraints/continuation_internal.h"

#define TRACK 64                            /* stored postures, from which branch points are crossed   */
#define ORDER LW_SYSTEM_ORDER_MAX
#define SHORT 4                             /* order of the series that predicts a step                 */
#define N_CURVE 9                           /* postures from which rates near a singular one follow      */
#define PARTS 12                            /* moments of a step at which the inputs are looked at      */

static const double longest_change = 0.1;   /* of the value of one input in a step in time, scaled      */
static const double singular = 0.02;        /* radius of the certified ball, 1/kappa, below which a posture counts as near a singular one */
static const double singular_step = 0.02;     /* change of the values of several inputs in a step near one, scaled */
static const double negligible = 1e-11;     /* last term of a series that has converged, scaled         */
static const double smooth = 1e-13;         /* the same for rates, which divide by small changes            */
static const double ample = 1e-14;          /* the same if it converges in half as much again, too       */
static const double contradiction = 1e-7;   /* more than this is left in the equations where they contradict each other, scaled */
static const double other_rate = 0.37;      /* change of an input's rate that shows whether it takes part, over the fastest rate */
static const double too_rough = 1e5;        /* kappa, above which rounding may leave as much */
static const double same_value = 1e-10;     /* values of one input that are no more apart, scaled, are the same */

typedef struct line { double at[LW_INPUT_MAX], direction[LW_INPUT_MAX]; } line;

struct lw_prescribed_motion {
    const lw_system *s;
    lw_continuation        f;
    lw_input_function *motion;
    void            *context;
    int              n;
    double           t, step;
    double          *q, *next, *series, *track;      /* track: TRACK x (1 + n), time and posture       */
    int              n_track;
    double           share;                 /* fraction of the path to the start of the motion          */
    double           first[LW_INPUT_MAX], target[LW_INPUT_MAX];
    line             line;                  /* motion of the inputs along one, by its parameter         */
    bool             straight;              /* the inputs move straight                                */
    bool             stuck;                 /* near a limit: no step is short enough                   */
    double           limit;                 /* time of that limit                                      */
    double           weight[2][2];          /* last two steps: time, 1/kappa^2                         */
    double           det[2];                /* several inputs: time and determinant of all rows at the last step; 0: not known */
    bool             lost;                  /* it has changed its sign, first between these times      */
    double           between[2];
    double          *loose;                 /* (n) the posture there; before: that of the last step    */
    unsigned         at_odds;               /* inputs whose motions contradict each other here: bit i for input i */
    int              crossings;
    double           crossing;
    bool             crossed;               /* the last singular step: its series about `from` holds up to `to` */
    double           from, to;
    double          *over;                  /* (ORDER + 1) x n                                         */
    double           asked;                 /* reported time and posture; inside a singular step they  */
    double          *posture;               /* differ from those where the next step starts            */
    lw_prescribed_motion *place;            /* one input in time: the linkage along its value          */
    double           away_t, away;          /* last moment that was not in a branch point, and its value */
    bool             has_regular;            /* several inputs: a regular posture near the singular one is known */
    double          *regular, at_regular[LW_INPUT_MAX];   /* that posture and its inputs               */
    bool             creeping;              /* the motion stays near singular postures                 */
    double          *curve;                 /* N_CURVE x n: postures for places of a curve of the inputs */
};

/* Series of the inputs at t, relative to the posture; false if a motion is not a number. */
static bool counts(const lw_prescribed_motion *d, double t, int order, double *u)
{
    d->motion(d->context, t, order, u);
    bool good = true;
    for (int i = 0; i < d->s->n_input; i++) {
        u[i*(order + 1)] -= d->s->input_value[i];
        for (int k = 0; k <= order; k++) {
            u[i*(order + 1) + k] /= lw_system_joint_unit(d->s, d->s->input_joint[i]);
            good = good && isfinite(u[i*(order + 1) + k]);
        }
    }
    return good;
}

static bool hold(lw_prescribed_motion *d, double t)
{
    return counts(d, t, 0, d->f.value);
}

/* Change of the inputs from now to t, measured by the first corrector step. */
static double change(lw_prescribed_motion *d, double t)
{
    double u[LW_INPUT_MAX];
    if (!counts(d, t, 0, u))
        return HUGE_VAL;
    memset(d->f.work, 0, (size_t)d->f.m*sizeof *d->f.work);
    for (int i = 0; i < d->s->n_input; i++)
        d->f.work[d->s->n_row + i] = u[i] - d->f.value[i];
    lw_continuation_solve(&d->f, d->f.work);
    double sum = 0.0;
    for (int i = 0; i < d->n; i++)
        sum += d->f.curved[i] ? d->f.work[i]*d->f.work[i] : 0.0;
    return sqrt(sum);
}

/* With the factors of the present posture: may the inputs move to t in one step? */
static bool within_reach(lw_prescribed_motion *d, double t)
{
    static const double part[PARTS] = { 1.0, 0.618, 0.382, 0.236, 0.854, 0.09, 0.472, 0.708, 0.944, 0.146, 0.764, 0.326 };
    double most = 0.5*LW_CONTINUATION_SHARE/d->f.kappa;
    for (int i = 0; i < (d->straight ? 1 : PARTS); i++)
        if (!(change(d, d->t + part[i]*(t - d->t)) <= most))
            return false;
    return true;
}

/* Store this posture if it is far enough from the last stored one (steps become short near a branch point). */
static void remember(lw_prescribed_motion *d)
{
    const double *last = d->track + (long)((d->n_track + TRACK - 1) % TRACK)*(1 + d->n);
    if (d->n_track > 0 && lw_continuation_distance(&d->f, last + 1, d->q) < 0.05*LW_CONTINUATION_BACK)
        return;
    double *at = d->track + (long)(d->n_track++ % TRACK)*(1 + d->n);
    at[0] = d->t;
    memcpy(at + 1, d->q, (size_t)d->n*sizeof *at);
}

/* Is a step h towards `last` too short to go on? */
static bool too_short(const lw_prescribed_motion *d, double h, double last)
{
    return !(fabs(h) > 1e-15*fmax(fabs(d->t), fabs(last)));
}

static void arrive(lw_prescribed_motion *d, double t, const double *q)
{
    remember(d);
    memcpy(d->q, q, (size_t)d->n*sizeof *q);
    d->t = t;
    d->has_regular = d->creeping = false;
}

/* ---- branch points ----------------------------------------------------------------------------- */

typedef struct from_here { lw_prescribed_motion *d; double t; } from_here;

static void hold_at(void *context, double x)
{
    from_here *p = context;
    hold(p->d, p->t + x);
}

/* Series in time at q, t, with the factors at q. */
static bool make_series(lw_prescribed_motion *d, double t, const double *q, int order)
{
    double u[LW_INPUT_MAX*(ORDER + 1)];
    if (!hold(d, t) || !counts(d, t, order, u) || !(lw_continuation_factor(&d->f, q) > 1e-14))
        return false;
    memcpy(d->series, q, (size_t)d->n*sizeof *q);
    lw_continuation_series(&d->f, order, u, d->series);
    return true;
}

/* With more equations than coordinates: the inputs whose motions the equations cannot follow together from the present posture, none if they
 * can.  An input takes part if what is left in the equations changes when its rate does.  d->f.kappa is that of this posture.  Makes d->series. */
static void find_contradiction(lw_prescribed_motion *d)
{
    double u[LW_INPUT_MAX*(SHORT + 1)], rate = 0;
    d->at_odds = 0;
    if (!make_series(d, d->t, d->q, SHORT) || d->f.m <= d->n || !(d->f.kappa < too_rough))
        return;
    counts(d, d->t, SHORT, u);
    double left = lw_continuation_misfit(&d->f, SHORT, u, d->series, &rate);
    if (!(left > contradiction))
        return;
    for (int i = 0; i < d->s->n_input; i++) {
        double *first = &u[i*(SHORT + 1) + 1], drawn = *first;
        *first += other_rate*rate;
        lw_continuation_series(&d->f, SHORT, u, d->series);
        double other = lw_continuation_misfit(&d->f, SHORT, u, d->series, &rate);
        *first = drawn;
        if (fabs(other - left) > contradiction*left)
            d->at_odds |= 1u << i;
    }
}

/* The last stored posture that is farther from here than `away`, otherwise the first one. */
static const double *look_back(const lw_prescribed_motion *d, double away)
{
    const double *at = NULL;
    for (int i = d->n_track - 1; i >= 0 && i > d->n_track - TRACK; i--) {
        at = d->track + (long)(i % TRACK)*(1 + d->n);
        if (lw_continuation_distance(&d->f, at + 1, d->q) >= away)
            break;
    }
    return at;
}

/* Does the series about `from` in d->series lead to the posture at time t, after the branch point?  If so, it is
 * d->next. */
static bool leads_to(lw_prescribed_motion *d, double from, double t)
{
    double *q = d->next, *kept = d->series + (ORDER + 1)*d->n;
    lw_continuation_sum(&d->f, ORDER, d->series, t - from, q);
    memcpy(kept, q, (size_t)d->n*sizeof *q);
    return hold(d, t) && lw_continuation_correct(&d->f, q) && lw_continuation_factor(&d->f, q) > 1e-12
           && lw_continuation_distance(&d->f, kept, q)*lw_continuation_bound(&d->f, q) < 0.01;
}

/* The equations lose rank at about time `ahead`.  At a crossing of branches the motion is smooth, and its series from
 * an earlier posture agrees with a posture beyond the crossing.  At a limit of the inputs there is no posture beyond.
 * */
static bool cross_singular(lw_prescribed_motion *d, double ahead, double last)
{
    const double *from = look_back(d, LW_CONTINUATION_BACK);
    if (!from || !make_series(d, from[0], from + 1, ORDER))
        return false;
    double distance = ahead - from[0], t = from[0];
    bool found = false;
    for (double share = 2.0; share <= 4.0 && !found; share += 0.5) {
        t = from[0] + share*distance;
        found = leads_to(d, from[0], t);
    }
    if (!found && (last - ahead)*distance > 0.0 && fabs(last - from[0]) < 4.0*fabs(distance)) {
        t = last;                                         /* after it the motion may be a different function */
        found = leads_to(d, from[0], t);
    }
    if (!found)
        return false;
    from_here place = { d, from[0] };
    d->from = from[0];
    d->to = t;
    d->crossed = true;
    memcpy(d->over, d->series, (size_t)((ORDER + 1)*d->n)*sizeof *d->over);
    d->crossing = d->from + lw_continuation_locate(&d->f, ORDER, d->over, distance, hold_at, &place);
    d->crossings++;
    memcpy(d->q, d->next, (size_t)d->n*sizeof *d->q);
    d->t = t;
    d->n_track = 0;
    d->step = 0.1*distance;
    return true;
}

/* ---- reported postures ------------------------------------------------------------------------- */

static bool in_singular_step(const lw_prescribed_motion *d, double t)
{
    return d->crossed && (t - d->from)*(d->to - t) >= 0.0;
}

/* Distance from the crossing as a fraction of the singular step. */
static double from_crossing(const lw_prescribed_motion *d, double t)
{
    return fabs((t - d->crossing)/(d->crossing - d->from));
}

static void report(lw_prescribed_motion *d, double t, const double *q)
{
    memcpy(d->posture, q, (size_t)d->n*sizeof *q);
    d->asked = t;
}

/* The posture at time t inside the singular step: by Newton's method, and near the branch point by the series alone. */
static void report_inside(lw_prescribed_motion *d, double t)
{
    lw_continuation_sum(&d->f, ORDER, d->over, t - d->from, d->next);
    report(d, t, d->next);
    if (from_crossing(d, t) > 0.1 && hold(d, t) && lw_continuation_correct(&d->f, d->next)
        && lw_continuation_distance(&d->f, d->next, d->posture) < 1e-6)
        report(d, t, d->next);
}

/* ---- one input, by its value --------------------------------------------------------------------- */

static double value_at(const lw_prescribed_motion *d, double t)
{
    double u[LW_INPUT_MAX];                               /* a model writes its tied inputs too */
    d->motion(d->context, t, 0, u);
    return u[0];
}

/* The moment between `before` and `after`, to rounding, at which the input comes to x. */
static double moment_of(const lw_prescribed_motion *d, double before, double after, double x)
{
    double side = value_at(d, after) - x;
    for (double middle; middle = 0.5*(before + after), middle != before && middle != after;)
        *((value_at(d, middle) - x)*side > 0 ? &after : &before) = middle;
    return after;
}

/* Go to the value of the input at t. */
static lw_status go_to_value(lw_prescribed_motion *d, double t)
{
    lw_prescribed_motion *p = d->place;
    double u = value_at(d, t), near = same_value*lw_system_joint_unit(d->s, d->s->input_joint[0]);
    int before = p->crossings;
    lw_status s = lw_prescribed_motion_to(p, u);
    if (s != LW_OK) {
        d->stuck = s == LW_OPEN;
        d->limit = d->stuck ? moment_of(d, d->t, t, p->limit) : d->t;
        return s;
    }
    if (p->crossings == 0 || fabs(u - p->crossing) > near) {
        if (p->crossings > 0 && (d->away - p->crossing)*(u - p->crossing) < 0) {
            d->crossings += p->crossings > before ? p->crossings - before : 1;
            d->crossing = moment_of(d, d->away_t, t, p->crossing);
            if (!d->lost)
                d->between[0] = d->between[1] = d->crossing;
            d->lost = true;
        }
        d->away_t = t;
        d->away = u;
    }
    return LW_OK;
}

/* The moment between `before` and `after` of the greatest value of the input times `sign`, by the golden section. */
static double moment_of_extreme(const lw_prescribed_motion *d, double before, double after, double sign)
{
    static const double share = 0.381966011250105;
    double a = before + share*(after - before), b = after - share*(after - before);
    double at_a = sign*value_at(d, a), at_b = sign*value_at(d, b);
    for (int i = 0; i < 60; i++)
        if (at_a > at_b) {
            after = b, b = a, at_b = at_a;
            a = before + share*(after - before), at_a = sign*value_at(d, a);
        } else {
            before = a, a = b, at_a = at_b;
            b = after - share*(after - before), at_b = sign*value_at(d, b);
        }
    return at_a > at_b ? a : b;
}

/* One step towards `last`: to the values at which the input turns back within it, and to that at its end. */
static lw_status advance_by_value(lw_prescribed_motion *d, double last)
{
    double u[PARTS + 1], rest = last - d->t, most = longest_change*lw_system_joint_unit(d->s, d->s->input_joint[0]);
    double h = d->step*rest > 0 && fabs(d->step) < fabs(rest) ? d->step : rest, end;
    bool near = false;
    u[0] = value_at(d, d->t);
    for (int halved = 0; !near; halved++) {
        h *= halved > 0 ? 0.5 : 1;
        if (halved > 0 && too_short(d, h, last))
            return LW_E_NUMERIC;                          /* the input jumps here, or is not a number */
        near = true;
        end = h == rest ? last : d->t + h;
        for (int i = PARTS; i > 0 && near; i--)
            near = fabs((u[i] = value_at(d, i == PARTS ? end : d->t + h*i/PARTS)) - u[0]) <= most;
    }
    for (int side = -1; side <= 1; side += 2) {
        int extreme = 0;
        for (int i = 1; i <= PARTS; i++)
            extreme = side*u[i] > side*u[extreme] ? i : extreme;
        double turn = d->t + h*extreme/PARTS;
        lw_status s = extreme == 0 || extreme == PARTS ? LW_OK
                    : go_to_value(d, moment_of_extreme(d, turn - h/PARTS, turn + h/PARTS, side));
        if (s != LW_OK)
            return s;
    }
    lw_status s = go_to_value(d, end);
    if (s == LW_OK) {
        d->t = end;
        d->step = 2*h;
    }
    return s;
}

/* ---- several inputs, by straight lines ------------------------------------------------------------ */

static lw_input_function straight;

static void on_line(void *context, double x, int order, double *u)
{
    const lw_prescribed_motion *d = context;
    for (int i = 0; i < d->s->n_input; i++)
        for (int k = 0; k <= order; k++)
            u[i*(order + 1) + k] = k == 0 ? d->line.at[i] + x*d->line.direction[i] : k == 1 ? d->line.direction[i] : 0;
}

static lw_status make(const lw_system *s, const double *q, lw_input_function *motion, void *context, double t, double start,
                      const line *l, lw_prescribed_motion **out, lw_error *e);

/* Values of the inputs in posture q. */
static void values_of(const lw_prescribed_motion *d, const double *q, double *u)
{
    for (int i = 0; i < d->s->n_input; i++) {
        int joint = d->s->input_joint[i];
        u[i] = d->s->input_value[i] + lw_system_joint_unit(d->s, joint)*lw_system_measure(d->s, joint, q, NULL);
    }
}

/* Is q near a singular posture?  Overwrites the factors. */
static bool is_singular(lw_prescribed_motion *d, const double *q)
{
    return !(hold(d, d->t) && lw_continuation_factor(&d->f, q) > 1e-12) || !(lw_continuation_bound(&d->f, q)*singular < 1);
}

/* Move posture q straight until its inputs are `to` (n_input), into `out`. */
static bool go_straight(const lw_prescribed_motion *d, const double *q, const double *to, double *out)
{
    line l;
    lw_prescribed_motion *p;
    values_of(d, q, l.at);
    for (int i = 0; i < d->s->n_input; i++)
        l.direction[i] = to[i] - l.at[i];
    bool good = make(d->s, q, on_line, NULL, 0, 0, &l, &p, NULL) == LW_OK && lw_prescribed_motion_to(p, 1) == LW_OK;
    if (good)
        memcpy(out, p->posture, (size_t)d->n*sizeof *out);
    lw_prescribed_motion_free(p);
    return good;
}

/* The posture for the values u of the inputs, into `out`, from the series along a straight line of values that begins at the regular
 * posture, whose factors are known.  Returns the last term. */
static double from_regular(lw_prescribed_motion *d, const double *u, double *out)
{
    double straight_there[LW_INPUT_MAX*(ORDER + 1)] = { 0 }, last = 0;
    for (int i = 0; i < d->s->n_input; i++)
        straight_there[i*(ORDER + 1) + 1] = (u[i] - d->at_regular[i])/lw_system_joint_unit(d->s, d->s->input_joint[i]);
    memcpy(d->series, d->regular, (size_t)d->n*sizeof *d->series);
    lw_continuation_series(&d->f, ORDER, straight_there, d->series);
    for (int i = 0; i < 2*d->n; i++)
        last = fmax(last, fabs(d->series[(ORDER - 1)*d->n + i])*(i < d->n ? 0.1 : 1));
    lw_continuation_sum(&d->f, ORDER, d->series, 1, out);
    return last;
}

static bool factor_regular(lw_prescribed_motion *d)
{
    hold(d, d->t);
    return lw_continuation_factor(&d->f, d->regular) > 1e-12;
}

/* Find a regular posture near the values u, starting from posture q: of some directions, the one whose series to u converges best. */
static bool find_regular(lw_prescribed_motion *d, const double *q, const double *u, double *out)
{
    enum { N_DIRECTION = 6, N = 3*N_DIRECTION };
    static const double size[] = { 0.04, 0.02, 0.01 };
    double last = INFINITY, least = negligible, best[LW_INPUT_MAX];
    lw_rng rng;
    lw_rng_seed(&rng, 5, 0);
    for (int k = 0; k <= N && last > ample; k++) {        /* at last the best of them again */
        if (k == N && !(least < negligible))
            break;
        for (int i = 0; i < d->s->n_input; i++) {
            double by = lw_rng_range(&rng, -0.2, 0.2), unit = lw_system_joint_unit(d->s, d->s->input_joint[i]);
            d->at_regular[i] = k == N ? best[i] : u[i] + size[k/N_DIRECTION % 3]*unit*(by + copysign(0.8, by));
        }
        last = go_straight(d, q, d->at_regular, d->regular) && factor_regular(d) ? from_regular(d, u, out) : INFINITY;
        if (last < least) {
            least = last;
            memcpy(best, d->at_regular, sizeof best);
        }
    }
    return d->has_regular = last <= negligible;
}

/* The posture for the values u, from the regular posture if the last term of its series is at most `most`, else from a new one. */
static bool reach_from_regular(lw_prescribed_motion *d, const double *u, double most, double *out)
{
    if (d->has_regular && factor_regular(d) && from_regular(d, u, out) <= most)
        return true;
    const double *from = d->has_regular ? d->regular : d->q;
    if (!d->has_regular && !(hold(d, d->t) && lw_continuation_factor(&d->f, d->q) > 1e-9))
        from = d->n_track > 0 ? look_back(d, LW_CONTINUATION_BACK) + 1 : NULL;
    double *start = d->series + (ORDER + 1)*d->n;         /* `regular` is overwritten */
    if (from)
        memcpy(start, from, (size_t)d->n*sizeof *start);
    return from && find_regular(d, start, u, out);
}

/* Where an input rests, turns back or creeps in a singular posture, no series in time continues the motion.  But the posture is a smooth function
 * of the values of the inputs: it follows from a regular posture nearby.  Makes one step towards `last`; false: none is possible. */
static bool go_from_regular(lw_prescribed_motion *d, double last)
{
    double now[LW_INPUT_MAX], to[LW_INPUT_MAX], h = last - d->t, t = last;
    d->motion(d->context, d->t, 0, now);
    for (bool near = false; !near; h *= near ? 1 : 0.5) {
        near = true;
        t = h == last - d->t ? last : d->t + h;
        for (int k = 1; k <= PARTS; k++) {
            d->motion(d->context, k == PARTS ? t : d->t + h*k/PARTS, 0, to);
            for (int i = 0; i < d->s->n_input; i++)
                near = near && fabs(to[i] - now[i]) <= singular_step*lw_system_joint_unit(d->s, d->s->input_joint[i]);
        }
        if (!near && too_short(d, h, last))
            return false;
    }
    if (!reach_from_regular(d, to, negligible, d->next) || !hold(d, t) || !(lw_continuation_residual(&d->f, d->next) < 100*negligible))
        return false;
    memcpy(d->q, d->next, (size_t)d->n*sizeof *d->q);
    d->t = t;
    d->crossed = false;
    d->step = d->weight[1][1] = 0;
    d->creeping = is_singular(d, d->q);
    return true;
}

const double *lw_prescribed_motion_regular(const lw_prescribed_motion *d) { return d->has_regular ? d->at_regular : NULL; }

bool lw_prescribed_motion_near(lw_prescribed_motion *d, const double *u, double *q)
{
    static const double predicted = 1e-7;
    if (!d->has_regular || !factor_regular(d) || !(from_regular(d, u, q) <= predicted))
        return false;
    memcpy(d->next, q, (size_t)d->n*sizeof *q);
    for (int i = 0; i < d->s->n_input; i++)
        d->f.value[i] = (u[i] - d->s->input_value[i])/lw_system_joint_unit(d->s, d->s->input_joint[i]);
    return lw_continuation_correct(&d->f, q) && lw_continuation_distance(&d->f, q, d->next) < 10*predicted;
}

static lw_status to_by_value(lw_prescribed_motion *d, double t)
{
    lw_status s = LW_OK;
    d->stuck = false;
    while (s == LW_OK && d->t != t)
        s = advance_by_value(d, t);
    report(d, d->t, d->place->posture);
    return s;
}

/* The series of the posture in time, from that along the value of the input and that of the input in time. */
static bool series_by_value(lw_prescribed_motion *d, int order, double *q)
{
    double u[LW_INPUT_MAX*(ORDER + 1)], p[ORDER + 1];
    d->motion(d->context, d->asked, order, u);
    if (lw_prescribed_motion_to(d->place, u[0]) != LW_OK || !lw_prescribed_motion_rates(d->place, order, d->series))
        return false;
    for (int i = 0; i < d->n; i++) {
        memset(p, 0, sizeof p);
        for (int m = order; m >= 0; m--)                  /* Horner's scheme; u[0] is left out */
            for (int k = order; k >= 0; k--) {
                p[k] = k == 0 ? d->series[m*d->n + i] : 0;
                for (int j = 1; j <= k; j++)
                    p[k] += u[j]*p[k - j];
            }
        for (int k = 1; k <= order; k++)
            q[k*d->n + i] = p[k];
    }
    return true;
}

/* ---- steps ------------------------------------------------------------------------------------- */

typedef enum outcome { MOVED, LIMIT, LOST } outcome;

/* The singular posture between d->loose and d->q, where the determinant of the rows has these values of different sign, into d->loose: on the straight
 * line between them, by the Illinois method. */
static void find_loose(lw_prescribed_motion *d, double before, double after)
{
    double part[2] = { 0, 1 }, det[2] = { before, after }, at = 0;
    for (int round = 0, last = -1; round < 30; round++) {
        at = part[0] + (part[1] - part[0])*det[0]/(det[0] - det[1]);
        for (int i = 0; i < d->n; i++)
            d->next[i] = d->loose[i] + at*(d->q[i] - d->loose[i]);
        lw_continuation_factor(&d->f, d->next);
        double now = lw_qr_determinant(d->n, d->f.diag);
        if (now == 0)
            break;
        int side = now*det[0] < 0;
        part[side] = at, det[side] = now;
        if (side == last)
            det[!side] *= 0.5;
        last = side;
    }
    memcpy(d->loose, d->next, (size_t)d->n*sizeof *d->next);
    lw_continuation_factor(&d->f, d->q);
}

/* Note the determinant of the rows, whose factors d->f holds at d->q.  It is 0 where the inputs lose control of the links. */
static void watch(lw_prescribed_motion *d)
{
    if (d->s->n_input < 2 || !d->f.matrix || d->f.m != d->f.n)
        return;
    double det = lw_qr_determinant(d->n, d->f.diag);
    if (!d->lost && det*d->det[1] < 0) {
        d->lost = true;
        d->between[0] = fmin(d->det[0], d->t), d->between[1] = fmax(d->det[0], d->t);
        find_loose(d, d->det[1], det);
    }
    if (!d->lost)
        memcpy(d->loose, d->q, (size_t)d->n*sizeof *d->q);
    d->det[0] = d->t, d->det[1] = det;
}

static double rounded(double x, double step) { return step*round(x/step) + 0.0; }

/* How a body moves that has this rate v of q [1, rad]. */
static void motion_text(const lw_system *s, const lw_assembly *names, int body, const double *q, const double *v, char text[LW_PRESCRIBED_MOTION_TEXT])
{
    static const double none = 1e-3;
    const double *rate = v + 3*body, metre = names->units.metre, step = pow(10, floor(log10(0.02*s->unit/metre)));
    lw_vec2 speed = lw_v2(rate[0], rate[1]), along = lw_v2_scale(speed, (speed.x + speed.y < 0 ? -1 : 1)/lw_v2_norm(speed));
    const char *link = names->link_name[s->link[body]];
    if (fabs(rate[2]) > none*lw_v2_norm(speed)) {
        lw_vec2 at = lw_system_point(s, body, lw_v2(0, 0), q);
        at = lw_v2_add(at, lw_v2_scale(lw_v2_perp(speed), s->unit/rate[2]));
        snprintf(text, LW_PRESCRIBED_MOTION_TEXT, "link \"%.40s\" turns about (%.9g, %.9g) %s", link, rounded(at.x/metre, step), rounded(at.y/metre, step),
                 names->units.length[0] ? names->units.length : "m");
    } else
        snprintf(text, LW_PRESCRIBED_MOTION_TEXT, "link \"%.40s\" slides along (%.2f, %.2f)", link, rounded(along.x, 0.01), rounded(along.y, 0.01));
}

/* At a singular posture q almost any right-hand side has the motion that the inputs leave free as its solution. */
static void tell_free_motion(lw_prescribed_motion *d, const lw_assembly *names, const double *q, char text[LW_PRESCRIBED_MOTION_TEXT])
{
    const lw_system *s = d->s;
    double *v = d->f.work;
    int best = 0, tool = s->n_tracer > 0 ? s->tracer_body[0] : -1;
    lw_continuation_factor(&d->f, q);
    for (int i = 0; i < d->f.m; i++)
        v[i] = 1 + 0.1*i;
    lw_continuation_solve(&d->f, v);
    for (int b = 1; b < s->n_body; b++)
        best = lw_norm(3, v + 3*b) > lw_norm(3, v + 3*best) ? b : best;
    if (tool >= 0 && lw_norm(3, v + 3*tool) > 0.1*lw_norm(3, v + 3*best))
        best = tool;
    if (isfinite(lw_norm(3, v + 3*best)))
        motion_text(s, names, best, q, v, text);
}

bool lw_prescribed_motion_lost(lw_prescribed_motion *d, const lw_assembly *names, double between[2], char how[LW_PRESCRIBED_MOTION_TEXT])
{
    how[0] = 0;
    if (!d->place && hold(d, d->t) && lw_continuation_factor(&d->f, d->q) > 1e-15)
        watch(d);
    if (d->lost && !d->place)
        tell_free_motion(d, names, d->loose, how);
    memcpy(between, d->between, sizeof d->between);
    return d->lost;
}

/* One step towards `last`. */
static outcome advance(lw_prescribed_motion *d, double last)
{
    double rest = last - d->t, h = d->step*rest > 0.0 && fabs(d->step) < fabs(rest) ? d->step : rest;
    if (!hold(d, d->t))
        return LOST;
    if (!(lw_continuation_factor(&d->f, d->q) > 1e-15))
        return cross_singular(d, d->t, last) ? MOVED : LIMIT;
    watch(d);
    lw_continuation_bound(&d->f, d->q);
    d->weight[0][0] = d->weight[1][0];
    d->weight[0][1] = d->weight[1][1];
    d->weight[1][0] = d->t;
    d->weight[1][1] = 1.0/(d->f.kappa*d->f.kappa);
    while (!within_reach(d, d->t + h)) {
        h *= 0.5;
        double speed = change(d, d->t + h);
        if (speed < LW_CONTINUATION_LEAST && 1.0 < d->f.kappa*2.0*LW_CONTINUATION_LEAST)
            return cross_singular(d, d->t + h, last) ? MOVED : LIMIT;
        if (too_short(d, h, last))
            return LOST;                                  /* an input jumps here, or is not a number     */
    }
    double kappa = d->f.kappa;
    find_contradiction(d);
    if (d->at_odds)
        return LOST;
    for (int try = 0; try == 0 || (try < 30 && !too_short(d, h, last)); try++, h *= 0.5) {
        double t = h == rest ? last : d->t + h;
        lw_continuation_sum(&d->f, SHORT, d->series, h, d->next);
        if (!hold(d, t))
            return LOST;
        if (lw_continuation_correct(&d->f, d->next) && lw_continuation_distance(&d->f, d->next, d->q) < 1.0/kappa) {
            arrive(d, t, d->next);
            d->step = 2.0*h;
            return MOVED;
        }
    }
    return LOST;
}

/* Does the motion stay near a singular posture, rather than cross it or leave it? */
static bool creeps(const lw_prescribed_motion *d)
{
    double before = d->weight[0][1], now = d->weight[1][1];
    return d->creeping || (now < singular*singular && now > 0.5*before && now < 2*before);
}

/* Return from a limit to a stored posture before it. */
static void come_free(lw_prescribed_motion *d)
{
    const double *from = look_back(d, 0.05*LW_CONTINUATION_BACK);
    if (!from)
        return;
    d->t = from[0];
    memcpy(d->q, from + 1, (size_t)d->n*sizeof *d->q);
    d->n_track = 0;
    d->step = 0.0;
    d->stuck = false;
}

/* Towards a limit, the distance along the curve and 1/kappa fall to 0 like the square root of the remaining time.  `last` may be the
 * limit itself. */
static double limit_towards(const lw_prescribed_motion *d, double last)
{
    const double *w0 = d->weight[0], *w1 = d->weight[1];
    double ahead = (w1[0] - w0[0])*w1[1]/(w0[1] - w1[1]), most = 1e4*(w1[0] - w0[0]);
    if (w1[0] == d->t && ahead*(last - d->t) > 0.0 && fabs(ahead) < fabs(most))
        return fabs(ahead) < fabs(last - d->t) ? d->t + ahead : last;
    return d->t;
}

lw_status lw_prescribed_motion_to(lw_prescribed_motion *d, double t)
{
    if (!isfinite(t))
        return LW_E_ARG;
    if (d->place)
        return to_by_value(d, t);
    if (d->at_odds && d->t == t)
        return LW_E_NUMERIC;
    d->at_odds = 0;
    if (d->stuck && d->t != t)
        come_free(d);
    bool several = d->s->n_input > 1 && d->motion != straight && d->motion != on_line;
    while (d->t != t && !in_singular_step(d, t)) {
        if (several && creeps(d) && go_from_regular(d, t))
            continue;
        outcome o = advance(d, t);
        if (o != MOVED && (d->at_odds || !several || !go_from_regular(d, t))) {
            hold(d, d->t);
            report(d, d->t, d->q);
            d->limit = o == LIMIT ? limit_towards(d, t) : d->t;
            d->stuck = true;
            return o == LIMIT ? LW_OPEN : LW_E_NUMERIC;
        }
    }
    if (d->t == t)
        report(d, t, d->q);
    else
        report_inside(d, t);
    hold(d, d->t);
    return LW_OK;
}

/* ---- making ------------------------------------------------------------------------------------ */

/* The straight path of the inputs to the start of the motion, in time 0 .. 1. */
static void straight(void *context, double t, int order, double *u)
{
    const lw_prescribed_motion *d = context;
    for (int i = 0; i < d->s->n_input; i++) {
        double first = d->first[i], way = d->target[i] - first;
        for (int k = 0; k <= order; k++)
            u[i*(order + 1) + k] = k == 0 ? first + t*way : k == 1 ? way : 0.0;
    }
}

/* One input as a function of itself: postures along its value, which takes the place of the time. */
static void itself_alone(void *context, double x, int order, double *u)
{
    (void)context;
    for (int k = 0; k <= order; k++)
        u[k] = k == 0 ? x : k == 1;
}

/* There cannot be more inputs than the rows leave degrees of freedom. */
static lw_status check_inputs(lw_prescribed_motion *d, lw_error *e)
{
    lw_continuation rows = d->f;
    rows.n_held = 0;
    int freedoms = lw_continuation_freedoms(&rows, d->q, d->next), inputs = d->s->n_input;
    if (freedoms < 0)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (inputs > freedoms)
        return lw_error_set(e, LW_E_ARG, "the linkage has %d freedom%s but %d input%s; leave out %d", freedoms,
                            lw_plural(freedoms), inputs, lw_plural(inputs), inputs - freedoms);
    return LW_OK;
}

/* Go from the drawn values of the inputs to those at t, where the motion begins at `start`: the same time, but for one input by its
 * value, which is then t. */
static lw_status begin(lw_prescribed_motion *d, double t, double start, lw_error *e)
{
    lw_input_function *motion = d->motion;
    void *context = d->context;
    bool itself = motion == itself_alone;
    motion(context, t, 0, d->target);
    if (motion == on_line || itself)                      /* a posture that was adjusted has other values than drawn */
        values_of(d, d->q, d->first);
    else
        memcpy(d->first, d->s->input_value, (size_t)d->s->n_input*sizeof *d->first);
    double first = itself ? d->first[0] : 0, last = itself ? t : 1;
    for (int i = 0; i < d->s->n_input; i++)
        if (!isfinite(d->target[i]))
            return lw_error_set(e, LW_E_NUMERIC, "the motion of input %d is no number at t = %g", i + 1, start);
    d->motion = itself ? motion : straight;
    d->context = d;
    d->straight = true;
    d->t = d->asked = first;
    hold(d, first);
    if (!(lw_continuation_factor(&d->f, d->q) > 1e-12))
        return lw_error_set(e, LW_E_NUMERIC, "the posture is a dead point of the inputs; draw the linkage in another posture");
    report(d, first, d->q);
    lw_status s = lw_prescribed_motion_to(d, last);
    if (s != LW_OK)
        return lw_error_set(e, s, "from its posture the linkage cannot get to where the motions begin at t = %g: it "
                            "comes %.6g %% of the way, straight in its inputs", start, 100*(d->t - first)/(last - first));
    if (itself)
        return LW_OK;
    if (d->t != 1.0 && from_crossing(d, 1.0) < 0.1)
        return lw_error_set(e, LW_E_NUMERIC, "the motions begin at a branch point at t = %g; begin a little before", t);
    memcpy(d->q, d->posture, (size_t)d->n*sizeof *d->q);
    d->motion = motion;
    d->context = context;
    d->straight = motion == on_line;
    d->t = t;
    d->step = 0.0;
    d->n_track = d->crossings = 0;
    d->crossed = d->has_regular = d->creeping = d->lost = false;
    d->det[1] = 0;
    hold(d, t);
    if (lw_continuation_factor(&d->f, d->q) > 1e-12 && lw_continuation_bound(&d->f, d->q) > 0)
        find_contradiction(d);
    hold(d, t);
    report(d, t, d->q);
    return LW_OK;
}

static lw_status make(const lw_system *s, const double *q, lw_input_function *motion, void *context, double t, double start,
                      const line *l, lw_prescribed_motion **out, lw_error *e)
{
    int all[LW_INPUT_MAX], missing = s->n_q - s->n_row - s->n_input;
    *out = NULL;
    if (missing > 0)
        return lw_error_set(e, LW_E_ARG, "the linkage has %d freedom%s but %d input%s; drive %d more joint%s",
                            s->n_q - s->n_row, lw_plural(s->n_q - s->n_row), s->n_input, lw_plural(s->n_input), missing,
                            lw_plural(missing));
    bool by_value = s->n_input == 1 && motion != itself_alone;
    lw_prescribed_motion *d = calloc(1, sizeof *d);
    for (int i = 0; i < s->n_input; i++)
        all[i] = i;
    if (d) {
        d->s = s;
        d->n = s->n_q;
        d->motion = motion;
        d->context = l ? d : context;
        if (l)
            d->line = *l;
        size_t vectors = 1 + (ORDER + 2) + (by_value ? 0 : 4 + N_CURVE + (ORDER + 1)), stored = by_value ? 0 : TRACK*(size_t)(1 + d->n);
        d->series = calloc(vectors*(size_t)d->n + stored, sizeof *d->series);
    }
    if (!d || !d->series || (!by_value && !lw_continuation_create(s, all, s->n_input, false, &d->f))) {
        lw_prescribed_motion_free(d);
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    }
    lw_status status;
    d->posture = d->series + (ORDER + 2)*d->n;
    if (by_value) {
        d->t = d->away_t = t;
        d->away = value_at(d, t);
        status = make(s, q, itself_alone, NULL, d->away, t, NULL, &d->place, e);
        if (status == LW_OK)
            report(d, t, d->place->posture);
    } else {
        d->q = d->posture + d->n;
        d->next = d->q + d->n;
        d->over = d->next + d->n;
        d->regular = d->over + (ORDER + 1)*d->n;
        d->curve = d->regular + d->n;
        d->loose = d->curve + N_CURVE*d->n;
        d->track = d->loose + d->n;
        if (q)
            memcpy(d->q, q, (size_t)d->n*sizeof *q);
        else
            lw_system_posture(s, d->q);
        status = check_inputs(d, e);
        if (status == LW_OK)
            status = begin(d, t, start, e);
    }
    if (status != LW_OK) {
        lw_prescribed_motion_free(d);
        return status;
    }
    *out = d;
    return LW_OK;
}

lw_status lw_prescribed_motion_create(const lw_system *s, const double *q, lw_input_function *motion, void *context,
                                      double t, lw_prescribed_motion **out, lw_error *e)
{
    return make(s, q, motion, context, t, t, NULL, out, e);
}

lw_prescribed_motion *lw_prescribed_motion_by_value(lw_prescribed_motion *d) { return d->place; }

void lw_prescribed_motion_free(lw_prescribed_motion *d)
{
    if (!d)
        return;
    lw_prescribed_motion_free(d->place);
    free(d->series);
    lw_continuation_free(&d->f);
    free(d);
}

double        lw_prescribed_motion_time(const lw_prescribed_motion *d) { return d->stuck ? d->limit : d->asked; }
const double *lw_prescribed_motion_posture(const lw_prescribed_motion *d) { return d->posture; }

/* Coefficients of the posture while the inputs move by the series u: near a singular posture from postures at points of that curve,
 * through which a polynomial is laid (Newton's divided differences). */
static bool along_from_regular(lw_prescribed_motion *d, int order, const double *u, double *q)
{
    enum { N = N_CURVE };
    double x[N], at[LW_INPUT_MAX], reach = 1, spread = 0, *c = d->curve;
    int n = d->n;
    for (int i = 0; i < d->s->n_input; i++)
        at[i] = u[i*(order + 1)];
    if (!reach_from_regular(d, at, smooth, d->next))
        return false;
    for (int i = 0; i < d->s->n_input; i++)
        spread = fmax(spread, 0.25*fabs(at[i] - d->at_regular[i])/lw_system_joint_unit(d->s, d->s->input_joint[i]));
    for (int i = 0; i < d->s->n_input; i++)
        for (int k = 1; k <= order; k++)
            reach = fmin(reach, pow(spread*lw_system_joint_unit(d->s, d->s->input_joint[i])/fabs(u[i*(order + 1) + k]), 1.0/k));
    for (int j = 0; j < N; j++) {
        x[j] = reach*cos((2*j + 1)*LW_PI/(2*N));
        for (int i = 0; i < d->s->n_input; i++) {
            at[i] = 0;
            for (int k = order; k >= 0; k--)
                at[i] = at[i]*x[j] + u[i*(order + 1) + k];
        }
        if (!(from_regular(d, at, c + j*n) <= negligible))
            return false;
    }
    for (int k = 1; k < N; k++)
        for (int j = N - 1; j >= k; j--)
            for (int i = 0; i < n; i++)
                c[j*n + i] = (c[j*n + i] - c[(j - 1)*n + i])/(x[j] - x[j - k]);
    for (int k = N - 1; k > 0; k--)                        /* to powers */
        for (int j = k - 1; j < N - 1; j++)
            for (int i = 0; i < n; i++)
                c[j*n + i] -= x[k - 1]*c[(j + 1)*n + i];
    memcpy(q, d->next, (size_t)n*sizeof *q);
    memcpy(q + n, c + n, (size_t)(order*n)*sizeof *q);
    return true;
}

bool lw_prescribed_motion_along(lw_prescribed_motion *d, int order, const double *u, double *q)
{
    double scaled[LW_INPUT_MAX*(ORDER + 1)];
    bool unsure = d->s->n_input > 1 && d->motion != on_line && is_singular(d, d->posture);
    if (unsure && along_from_regular(d, order, u, q))
        return true;
    for (int i = 0; i < d->s->n_input; i++)
        for (int k = 0; k <= order; k++)
            scaled[i*(order + 1) + k] = u[i*(order + 1) + k]/lw_system_joint_unit(d->s, d->s->input_joint[i]);
    if (!(lw_continuation_factor(&d->f, d->posture) > (unsure ? 1e-4 : 1e-14)))
        return false;
    memcpy(q, d->posture, (size_t)d->n*sizeof *q);
    lw_continuation_series(&d->f, order, scaled, q);
    return d->f.m <= d->n || lw_continuation_misfit(&d->f, order, scaled, q, (double[]){ 0 }) <= contradiction;
}

bool lw_prescribed_motion_rates(lw_prescribed_motion *d, int order, double *q)
{
    double u[LW_INPUT_MAX*(ORDER + 1)];
    memcpy(q, d->posture, (size_t)d->n*sizeof *q);
    if (d->place)
        return series_by_value(d, order, q);
    if (in_singular_step(d, d->asked) && from_crossing(d, d->asked) < 0.25) {
        for (int k = 1; k <= order; k++) {                /* the series of the singular step, about this time */
            double choose = 1.0;
            memset(q + k*d->n, 0, (size_t)d->n*sizeof *q);
            for (int m = k; m <= ORDER; choose *= (m + 1.0)/(m + 1.0 - k), m++)
                for (int i = 0; i < d->n; i++)
                    q[k*d->n + i] += choose*pow(d->asked - d->from, m - k)*d->over[m*d->n + i];
        }
        return true;
    }
    d->motion(d->context, d->asked, order, u);
    return hold(d, d->asked) && lw_prescribed_motion_along(d, order, u, q);
}

lw_status lw_prescribed_motion_ended(const lw_prescribed_motion *d, lw_status s, const lw_assembly *names, lw_error *e)
{
    const lw_prescribed_motion *p = d->place ? d->place : d;
    double t = lw_prescribed_motion_time(d);
    char text[LW_INPUT_MAX*(LW_NAME_SIZE + 8)] = "";
    size_t used = 0;
    if (s == LW_OPEN)
        return lw_error_set(e, s, "the motions lead beyond a limit of the linkage (a dead point of its inputs) at t = %.12g s", t);
    if (!p->at_odds)
        return lw_error_set(e, s, "the motion is lost at t = %.12g s: an input jumps or is no number there, or no step is short enough to stay on "
                            "the branch", t);
    for (unsigned left = p->at_odds, i = 0; left; left >>= 1, i++)
        if (left & 1)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", used == 0 ? "" : left == 1 ? " and " : ", ",
                                     names->joint[d->s->input_joint[i]].name);
    if ((p->at_odds & (p->at_odds - 1)) == 0)
        return lw_error_set(e, s, "the linkage cannot follow its input %s from t = %.12g s: its joints would open; it moves there to first order only",
                            text, t);
    return lw_error_set(e, s, "the motions of the inputs %s contradict each other from t = %.12g s: the joints would open; leave a motion out, or give "
                        "motions that the linkage can follow together", text, t);
}

int lw_prescribed_motion_crossings(const lw_prescribed_motion *d, double *last)
{
    if (last)
        *last = d->crossing;
    return d->crossings;
}
