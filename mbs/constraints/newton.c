/* mbs/constraints/newton.c - follow a branch of postures by predictor and corrector.
 *
 * The postures and their inputs form curves in the space of coordinates and input.  A step moves by a length h along
 * the unit tangent t and returns to the curve by Newton's method on the plane t . (z - z0) = h.  So a limit of
 * motion, where the input turns back, is an ordinary point of the curve (Keller 1977, pseudo-arclength; Allgower &
 * Georg 1990, chapters 2, 8).  A step is accepted only if
 *     the first correction is small compared with h and the corrections shrink,
 *     the tangent turns by less than 0.3,
 *     the chord is parallel to the mean of the tangents at its ends, as for an arc,
 *     the input, as the cubic through its values and rates at both ends, does not turn back in between,
 *     the determinant of the equations with the tangent as last row keeps its sign and most of its size.
 * The determinant changes sign only where two branches cross.  So a step that jumped to the other branch near an almost
 * crossing is detected and shortened.  Near a crossing, each step covers only a part of the remaining distance. */
#include "mbs/constraints/newton.h"
#include <float.h>
#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/number.h"
#include "base/vector.h"
#include "mbs/constraints/system_internal.h"

static const double first_step   = 0.2;
static const double largest_step = 0.5;
static const double least_step   = 1e-6;   /* below this, rounding decides at a crossing                */
static const double back_step    = 1e-4;   /* after a step of this length, store a posture to return to */
static const double least_cosine = 0.955;  /* cos 0.3 */
static const double det_share    = 0.2;    /* fraction of the determinant that must remain           */
static const double near_share   = 0.2;    /* largest first correction, relative to the step         */
static const double chord_sine   = 0.02;   /* largest sine of the angle between chord and mean tangent */

typedef struct place {
    double *z, *t;                         /* posture and input; unit tangent                (w)   */
    double  det;                           /* determinant; 0 for overconstrained linkages          */
    int     turns[LW_LINK_MAX];            /* whole turns removed from the coordinates of bodies   */
    int     input_turns;                   /* whole turns removed from the input of a pin          */
} place;

struct lw_newton {
    lw_system system;
    int     n, m;                          /* coordinates; rows and inputs                         */
    int     w, rows;                       /* unknowns: coordinates and the change of the first    */
                                           /* input, n + 1; equations m + 1                        */
    double  value;                         /* input in the posture                                 */
    double  unit;                          /* input per unit of z[n]: 1 [rad] or the size [m]      */
    place   start, here, next;
    place   back;                          /* a posture at least one step back                     */
    bool    has_back;
    double  step;
    int     way;                           /* +1, -1: the tangent points to a growing, falling input */
    bool    limit;                         /* the input cannot move further in that direction      */
    int     crossings;
    bool    input_is_pin;
    double *store;                         /* all arrays                                           */
    double *matrix, *diag, *rest, *border;
    double *turned;                        /* contribution of the removed turns to each equation */
};

static void copy(const lw_newton *s, place *to, const place *from)
{
    double *z = to->z, *t = to->t;
    *to = *from;
    to->z = memcpy(z, from->z, (size_t)s->w*sizeof *z);
    to->t = memcpy(t, from->t, (size_t)s->w*sizeof *t);
}

/* to->z = from->z + h from->t */
static void predict(const lw_newton *s, const place *from, double h, place *to)
{
    for (int i = 0; i < s->w; i++)
        to->z[i] = from->z[i] + h*from->t[i];
}

/* Residuals of the first m equations at z into s->rest; returns the largest. */
static double evaluate(const lw_newton *s, const double *z, double *rest, double *matrix)
{
    const lw_system *p = &s->system;
    lw_body_frame f[LW_LINK_MAX];
    double most = 0.0;
    lw_system_place(p, z, f);
    lw_system_fill(p, f, rest, matrix, 1, s->rows);
    for (int i = 0; i < p->n_input; i++)
        rest[p->n_row + i] = lw_system_count(p, f, p->input_joint[i], matrix ? matrix + p->n_row + i : NULL, s->rows);
    rest[p->n_row] -= z[s->n];
    if (matrix)
        matrix[p->n_row + (long)s->rows*s->n] = -1.0;
    for (int i = 0; i < s->m; i++) {
        rest[i] += s->turned[i];
        most = fmax(most, fabs(rest[i]));
    }
    return most;
}

/* The matrix at z with `row` as its last row; returns the largest residual. */
static double assemble(lw_newton *s, const double *z, const double *row)
{
    memset(s->matrix, 0, (size_t)s->rows*(size_t)s->w*sizeof *s->matrix);
    double most = evaluate(s, z, s->rest, s->matrix);
    for (int c = 0; c < s->w; c++)
        s->matrix[s->m + (long)s->rows*c] = row[c];
    return most;
}

/* Residual that rounding alone can cause: a few units in the last place of the positions. */
static double rounding(const lw_newton *s, const double *z)
{
    double most = 1.0;
    for (int i = 0; i < s->n; i++)
        if (i % 3 != 2)
            most = fmax(most, fabs(z[i]));
    return 4.0*DBL_EPSILON*most;
}

/* Newton's method from z to the curve, on the plane across `row` at distance h from s->here.  False if the first
 * correction exceeds its share of h, or if corrections do not shrink. */
static bool correct(lw_newton *s, double *z, const double *row, double h)
{
    double last = 0.0, reach = near_share*fabs(h) + rounding(s, z);
    for (int iteration = 0; iteration < 12; iteration++) {
        double left = assemble(s, z, row), off = -h;
        for (int i = 0; i < s->w; i++)
            off += row[i]*(z[i] - s->here.z[i]);
        double small = rounding(s, z);
        if (left <= 0.25*small && fabs(off) <= small)
            return true;
        s->rest[s->m] = off;
        if (!(lw_qr_factor(s->rows, s->w, s->matrix, s->diag) > 1e-14))
            return false;
        lw_qr_solve(s->rows, s->w, s->matrix, s->diag, s->rest);
        double length = sqrt(lw_dot(s->w, s->rest, s->rest));
        bool at_rounding = left <= small && fabs(off) <= small;
        if (iteration > 0 && !(length < 0.5*last))
            return at_rounding;
        if (iteration == 0 && !(length <= reach) && !at_rounding)
            return false;
        for (int i = 0; i < s->w; i++)
            z[i] -= s->rest[i];
        last = length;
    }
    return false;
}

/* Unit tangent at p->z, on the side of `row`; false if it is not determined. */
static bool find_tangent(lw_newton *s, place *p, const double *row)
{
    assemble(s, p->z, row);
    double condition = lw_qr_factor(s->rows, s->w, s->matrix, s->diag);
    if (!(condition > 1e-12))
        return false;
    p->det = s->rows == s->w ? lw_qr_determinant(s->w, s->diag) : 0.0;
    memset(s->rest, 0, (size_t)s->rows*sizeof *s->rest);
    s->rest[s->m] = 1.0;
    lw_qr_solve(s->rows, s->w, s->matrix, s->diag, s->rest);
    double length = sqrt(lw_dot(s->w, s->rest, s->rest));
    for (int i = 0; i < s->w; i++)
        p->t[i] = s->rest[i]/length;
    return isfinite(length);
}

/* --- steps --- */

/* Is s->next on the same smooth curve as s->here, judged from both ends of the step? */
static bool smooth(const lw_newton *s)
{
    double length2 = 0.0, along = 0.0, mean2 = 0.0, cosine = lw_dot(s->w, s->next.t, s->here.t);
    if (cosine < least_cosine)
        return false;
    for (int i = 0; i < s->w; i++) {
        double chord = s->next.z[i] - s->here.z[i], mean = s->here.t[i] + s->next.t[i];
        length2 += chord*chord;
        along += chord*mean;
        mean2 += mean*mean;
    }
    bool too_short = length2 < 1e-12;       /* its direction is dominated by rounding */
    return too_short || along*along >= (1.0 - chord_sine*chord_sine)*length2*mean2;
}

/* Does no other branch cross the curve between s->here and s->next, or next to s->next? */
static bool uncrossed(const lw_newton *s)
{
    double before = s->here.det, after = s->next.det;
    return (before > 0.0) == (after > 0.0) && fabs(after) >= det_share*fabs(before);
}

/* s->next: the point of the curve at distance h from s->here, on the plane across the tangent. */
static bool go(lw_newton *s, double h)
{
    predict(s, &s->here, h, &s->next);
    return correct(s, s->next.z, s->here.t, h)
        && find_tangent(s, &s->next, s->here.t)
        && smooth(s);
}

/* Does the input turn back and forth within the step although it moves in the same direction at both ends?  The
 * derivative of the cubic through both ends is the parabola q with q(0) = p0, q(1) = p1 and mean slope m.  In a short
 * step, such a detour is smaller than the accuracy of the limits. */
static bool dips(const lw_newton *s, double h)
{
    int n = s->n;
    double p0 = s->here.t[n]*s->way, p1 = s->next.t[n]*s->way;
    double m = (s->next.z[n] - s->here.z[n])*s->way/h;
    double slope = 6.0*m - 4.0*p0 - 2.0*p1, bend = 3.0*(p0 + p1) - 6.0*m;
    if (h < 1e-4 || !(bend > 0.0 && slope < 0.0 && -slope < 2.0*bend))
        return false;
    double least = p0 - 0.25*slope*slope/bend;
    return least < 0.1*fmax(0.0, fmin(p0, p1)) - 1e-12;
}

/* s->next: the point of the curve where the input is `target`, at a distance of about h. */
static bool go_to(lw_newton *s, double target, double h)
{
    memset(s->border, 0, (size_t)s->w*sizeof *s->border);
    s->border[s->n] = 1.0;
    predict(s, &s->here, h, &s->next);
    s->next.z[s->n] = target;
    return correct(s, s->next.z, s->border, target - s->here.z[s->n])
        && find_tangent(s, &s->next, s->here.t)
        && smooth(s)
        && uncrossed(s)
        && !dips(s, h);
}

/* Call this whenever the turns of s->here change. */
static void count_turns(lw_newton *s)
{
    lw_system_turns(&s->system, s->here.turns, s->turned, s->turned + s->system.n_row);
    s->turned[s->system.n_row] -= s->here.input_turns;
    for (int i = 0; i < s->m; i++)
        s->turned[i] *= 2.0*LW_PI;
}

/* exchange s->here with another place */
static void swap(lw_newton *s, place *other)
{
    place old = *other;
    *other = s->here;
    s->here = old;
    if (memcmp(s->here.turns, other->turns, sizeof old.turns) != 0 || s->here.input_turns != other->input_turns)
        count_turns(s);
}

/* Remove whole turns from an angle; the result is within half a turn. */
static int wrap(double *angle)
{
    int whole = *angle > LW_PI ? 1 : *angle < -LW_PI ? -1 : 0;
    *angle -= 2.0*LW_PI*whole;
    return whole;
}

/* Keep rotations in [-pi, pi], so that sines keep their digits after many turns. */
static void arrive(lw_newton *s)
{
    place *p = &s->next;
    memcpy(p->turns, s->here.turns, sizeof p->turns);
    p->input_turns = s->here.input_turns;
    for (int i = 0; i < s->system.n_body; i++)
        p->turns[i] += wrap(&p->z[3*i + 2]);
    if (s->input_is_pin)
        p->input_turns += wrap(&p->z[s->n]);
    swap(s, &s->next);
}

/* Find the point between s->here and distance h at which the input is *target, or, if target is NULL, at which it
 * turns back: regula falsi after Dowell & Jarratt 1971 (Illinois).  The point is s->next. */
static bool locate(lw_newton *s, double h, const double *target)
{
    int n = s->n;
    double lo = 0.0, hi = h;
    double at_lo = target ? s->here.z[n] - *target : s->here.t[n];
    double at_hi = target ? s->next.z[n] - *target : s->next.t[n];
    double enough = target ? DBL_EPSILON*fmax(1.0, fabs(*target)) : 1e-10;
    for (int i = 0; i < 100; i++) {
        double x = hi - at_hi*(hi - lo)/(at_hi - at_lo);
        if (!(x > fmin(lo, hi) && x < fmax(lo, hi)))
            x = 0.5*(lo + hi);
        if (!go(s, x))
            return false;
        double at_x = target ? s->next.z[n] - *target : s->next.t[n];
        if (fabs(at_x) <= enough || fabs(hi - lo) <= 1e-15)
            return true;
        if ((at_x > 0.0) != (at_hi > 0.0)) {
            lo = hi;
            at_lo = at_hi;
        } else
            at_lo *= 0.5;
        hi = x;
        at_hi = at_x;
    }
    return true;
}

static double reach_of(const lw_newton *s, const place *p)
{
    double sum = 0.0;
    for (int i = 0; i < s->w; i++)
        sum += pow(s->here.z[i] - p->z[i], 2.0);
    return sqrt(sum);
}

/* A limit at which branches also cross (the closing rhombus of Peaucellier) cannot be reached by a step.  The rates
 * here and at an earlier point make the input a parabola of the distance: is its top within rounding? */
static bool at_double_limit(const lw_newton *s)
{
    int n = s->n;
    double rate = s->here.t[n]*s->way, before = s->back.t[n]*s->way;
    return s->has_back && before > rate && 0.5*rate*rate*reach_of(s, &s->back) <= 1e-11*(before - rate);
}

static bool passed(double x, double target, double way) { return (x - target)*way >= 0.0; }

typedef enum outcome { MOVED, ARRIVED, ENDED, LOST } outcome;

/* z (w): the cubic from a (x = 0) to b (x = 1) with the unit tangents ta and tb. */
static void interpolate(int w, const double *a, const double *ta, const double *b, const double *tb, double x, double *z)
{
    double y = 1.0 - x, length = 0.0;
    for (int i = 0; i < w; i++)
        length += (b[i] - a[i])*(b[i] - a[i]);
    length = sqrt(length);
    for (int i = 0; i < w; i++)
        z[i] = y*y*(1.0 + 2.0*x)*a[i] + x*x*(1.0 + 2.0*y)*b[i] + length*x*y*(y*ta[i] - x*tb[i]);
}

/* The step from s->here to s->next crosses another branch and passes the target: move s->next to the target.  The equations
 * are all but singular there, so the posture is that of the cubic through both ends, and tangent and determinant are those
 * between them.  Newton's method is needed only after a long step; its result must lie on the same branch. */
static bool interpolate_crossing(lw_newton *s, double target)
{
    int w = s->w, n = s->n;
    double *z = s->border, lo = 0.0, hi = 1.0;
    for (int i = 0; i < 60; i++) {
        double x = 0.5*(lo + hi);
        interpolate(w, s->here.z, s->here.t, s->next.z, s->next.t, x, z);
        *(passed(z[n], target, s->way) ? &hi : &lo) = x;
    }
    double det = s->here.det + hi*(s->next.det - s->here.det);
    z[n] = target;
    for (int i = 0; i < w; i++)
        s->next.t[i] = (1.0 - hi)*s->here.t[i] + hi*s->next.t[i];
    double length = sqrt(lw_dot(w, s->next.t, s->next.t));
    for (int i = 0; i < w; i++)
        s->next.t[i] /= length;
    memcpy(s->next.z, z, (size_t)w*sizeof *z);
    s->next.det = det;
    if (evaluate(s, s->next.z, s->rest, NULL) <= rounding(s, s->next.z))
        return true;
    memset(s->border, 0, (size_t)w*sizeof *s->border);
    s->border[n] = 1.0;
    return correct(s, s->next.z, s->border, target - s->here.z[n]) && find_tangent(s, &s->next, s->here.t) && smooth(s)
        && (s->next.det > 0.0) == (det > 0.0);
}

/* Two branches cross within least_step: step across the crossing and go straight on, starting from a point far enough
 * before it for an accurate tangent. */
static outcome cross(lw_newton *s, double target)
{
    int n = s->n, turns = s->here.input_turns;
    double away = s->has_back ? reach_of(s, &s->back) : 0.0;
    if (!s->has_back || !(away < largest_step))
        copy(s, &s->back, &s->here);
    swap(s, &s->back);
    target += 2.0*LW_PI*(turns - s->here.input_turns);
    for (double h = fmax(1.25*away, 4.0*least_step); h < largest_step; h *= 1.4) {
        if (!go(s, h) || !(s->next.det*s->here.det < 0.0 && fabs(s->next.det) >= det_share*fabs(s->here.det)) ||
            !(s->next.t[n]*s->way > 0.0))
            continue;
        bool arrived = passed(s->next.z[n], target, s->way);
        if (arrived && !interpolate_crossing(s, target))
            continue;
        bool crossed = s->next.det*s->here.det < 0.0;
        s->crossings += crossed;
        s->step = fmax(h, 1e-3);
        s->has_back = !crossed;
        if (!crossed)
            copy(s, &s->back, &s->here);
        arrive(s);
        return arrived ? ARRIVED : MOVED;
    }
    swap(s, &s->back);
    return LOST;
}

/* In the step of length h to s->next the input turned back or passed its target: find the first of the two. */
static outcome settle(lw_newton *s, double h, double target)
{
    int n = s->n;
    double end = h, way = s->way;
    if (s->next.t[n]*way <= 0.0) {
        bool from_limit = s->here.t[n]*way < 1e-9;         /* two limits: separate them by a shorter step */
        if (from_limit || !locate(s, h, NULL))
            return LOST;
        end = 0.0;
        for (int i = 0; i < s->w; i++)
            end += s->here.t[i]*(s->next.z[i] - s->here.z[i]);
        if (dips(s, end))
            return LOST;
        if (!passed(s->next.z[n], target, way)) {
            arrive(s);
            s->limit = true;
            return ENDED;
        }
    }
    if (!locate(s, end, &target))
        return LOST;
    s->next.z[n] = target;
    arrive(s);
    return ARRIVED;
}

/* One step towards the target, as long as the curve allows. */
static outcome advance(lw_newton *s, double target)
{
    int n = s->n;
    double way = s->way, rate = s->here.t[n]*way, need = (target - s->here.z[n])*way;
    if (rate > 0.0 && need <= rate*s->step && go_to(s, target, need/rate)) {
        arrive(s);
        return ARRIVED;
    }
    for (double h = s->step; h >= least_step; h *= 0.5) {
        if (!go(s, h) || !uncrossed(s))
            continue;
        double cosine = lw_dot(s->w, s->next.t, s->here.t);
        bool turned = s->next.t[n]*way <= 0.0;
        if (!turned && dips(s, h))
            continue;
        if (turned || passed(s->next.z[n], target, way)) {
            outcome o = settle(s, h, target);
            if (o == LOST)
                continue;
            return o;
        }
        s->step = fmin(largest_step, cosine > 0.99 ? 2.0*h : cosine > 0.975 ? 1.2*h : h);
        if (h >= back_step) {
            copy(s, &s->back, &s->here);
            s->has_back = true;
        }
        arrive(s);
        return MOVED;
    }
    outcome o = cross(s, target);
    if (o != LOST)
        return o;
    s->limit = at_double_limit(s);
    return s->limit ? ENDED : LOST;
}

/* Reverse the direction if the input is to move the other way.  At a limit, the motion returns the way it came. */
static void face(lw_newton *s, int way)
{
    if (way == s->way)
        return;
    for (int i = 0; i < s->w; i++)
        s->here.t[i] = -s->here.t[i];
    s->here.det = -s->here.det;              /* the determinant is linear in its last row */
    s->way = way;
    s->limit = s->has_back = false;
}

/* z[n] for a value of the input */
static double wanted(const lw_newton *s, double input)
{
    return (input - s->value)/s->unit - 2.0*LW_PI*s->here.input_turns;
}

enum { STEPS_MAX = 20000 };

static lw_status status_of(outcome o)
{
    return o == ARRIVED ? LW_OK : o == ENDED ? LW_OPEN : o == MOVED ? LW_STOPPED : LW_E_NUMERIC;
}

lw_status lw_newton_step(lw_newton *s, double input, double most)
{
    double target = wanted(s, input), from = s->here.z[s->n];
    if (!isfinite(input))
        return LW_E_ARG;
    if (target == from)
        return LW_OK;
    face(s, target > from ? 1 : -1);
    s->step = fmin(s->step, most);
    return status_of(s->limit ? ENDED : advance(s, target));
}

lw_status lw_newton_move(lw_newton *s, double input, double *reached)
{
    lw_status status = LW_OK;
    double target = wanted(s, input), from = s->here.z[s->n];
    if (!isfinite(input))
        status = LW_E_ARG;
    else if (target != from) {
        face(s, target > from ? 1 : -1);
        outcome o = s->limit ? ENDED : MOVED;
        for (long steps = 0; o == MOVED && steps < STEPS_MAX; steps++)     /* a far input is not followed for ever */
            o = advance(s, wanted(s, input));
        status = o == MOVED ? LW_E_NUMERIC : status_of(o);
    }
    if (reached)
        *reached = status == LW_OK ? input : lw_newton_input(s);
    return status;
}

/* --- making, asking --- */

void lw_newton_reset(lw_newton *s)
{
    copy(s, &s->here, &s->start);
    memset(s->turned, 0, (size_t)s->rows*sizeof *s->turned);
    s->step = first_step;
    s->way = 1;
    s->limit = s->has_back = false;
    s->crossings = 0;
}

size_t lw_newton_node_size(const lw_newton *s) { return 2*(size_t)s->w; }

void lw_newton_keep(const lw_newton *s, double *node)
{
    memcpy(node, s->here.z, (size_t)s->w*sizeof *node);
    for (int i = 0; i < s->system.n_body; i++)
        node[3*i + 2] += 2.0*LW_PI*s->here.turns[i];
    node[s->n] += 2.0*LW_PI*s->here.input_turns;
    for (int i = 0; i < s->w; i++)
        node[s->w + i] = s->way*s->here.t[i];
}

void lw_newton_between(lw_newton *s, const double *a, const double *b, double x)
{
    interpolate(s->w, a, a + s->w, b, b + s->w, x, s->here.z);
    memset(s->here.turns, 0, sizeof s->here.turns);
    s->here.input_turns = 0;
}

/* One block for all arrays. */
static bool allocate(lw_newton *s)
{
    size_t w = (size_t)s->w, rows = (size_t)s->rows;
    double *store = s->store = calloc(10*w + 2*rows + rows*w, sizeof *store);
    if (!store)
        return false;
    s->start  = (place){ .z = store,         .t = store + w };
    s->here   = (place){ .z = store + 2*w,   .t = store + 3*w };
    s->next   = (place){ .z = store + 4*w,   .t = store + 5*w };
    s->back   = (place){ .z = store + 6*w,   .t = store + 7*w };
    s->diag   = store + 8*w;
    s->border = store + 9*w;
    s->rest   = store + 10*w;
    s->turned = s->rest + rows;
    s->matrix = s->turned + rows;
    return true;
}

static lw_status count_equations(const lw_linkage *linkage, lw_newton *s, lw_error *e)
{
    s->n = s->system.n_q;
    s->m = s->system.n_row + s->system.n_input;
    s->w = s->n + 1;
    s->rows = s->m + 1;
    if (linkage->n_input < 1)
        return lw_error_set(e, LW_E_ARG, "the linkage has no input to move it by");
    if (s->m < s->n)
        return lw_error_set(e, LW_E_ARG, "the linkage has %d freedom%s but %d input%s; drive %d more joint%s",
                            s->n - s->system.n_row, lw_plural(s->n - s->system.n_row), s->system.n_input, lw_plural(s->system.n_input), s->n - s->m,
                            lw_plural(s->n - s->m));
    return LW_OK;
}

/* The tangent at the posture, in the direction of a growing input. */
static lw_status begin(lw_newton *s, lw_error *e)
{
    lw_system_posture(&s->system, s->start.z);
    s->border[s->n] = 1.0;
    if (!find_tangent(s, &s->start, s->border))
        return lw_error_set(e, LW_E_NUMERIC, "the posture is a dead point of the input: draw the linkage "
                            "in another posture, so that its branch can be told");
    double left = 0.0;
    assemble(s, s->start.z, s->border);
    for (int i = 0; i < s->m; i++) {
        double rate = 0.0;
        for (int c = 0; c < s->w; c++)
            rate += s->matrix[i + (long)s->rows*c]*s->start.t[c];
        left = fmax(left, fabs(rate));
    }
    if (left > 1e-9)
        return lw_error_set(e, LW_E_NUMERIC, "the linkage is rigid: it has more constraints than it needs "
                            "and they do not agree, so that its input cannot move");
    lw_newton_reset(s);
    return LW_OK;
}

lw_status lw_newton_create(const lw_linkage *linkage, lw_newton **out, lw_error *e)
{
    *out = NULL;
    lw_newton *s = calloc(1, sizeof *s);
    if (!s)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status status = lw_system_make(linkage, NULL, 0.0, &s->system, e);
    if (status == LW_OK)
        status = count_equations(linkage, s, e);
    if (status == LW_OK && !allocate(s))
        status = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (status == LW_OK) {
        s->value = linkage->input[0].value;
        s->input_is_pin = lw_joint_turns(linkage->joint[linkage->input[0].joint].kind);
        s->unit = s->input_is_pin ? 1.0 : s->system.unit;
        status = begin(s, e);
    }
    if (status != LW_OK) {
        lw_newton_free(s);
        return status;
    }
    *out = s;
    return LW_OK;
}

void lw_newton_free(lw_newton *s)
{
    if (s) {
        lw_system_free(&s->system);
        free(s->store);
    }
    free(s);
}

lw_vec2 lw_newton_tracer(const lw_newton *s, int which)
{
    return lw_system_point(&s->system, s->system.tracer_body[which], s->system.tracer_arm[which], s->here.z);
}

lw_vec2 lw_newton_joint(const lw_newton *s, int joint)
{
    const lw_system_joint *q = &s->system.joint[joint];
    return lw_system_point(&s->system, lw_joint_has_ratio(q->kind) ? q->carrier : q->body[0], q->arm[0], s->here.z);
}

lw_vec2 lw_newton_point(const lw_newton *s, int link, lw_vec2 at)
{
    int b = s->system.body[link];
    return lw_system_point(&s->system, b, lw_system_arm(&s->system, b, at), s->here.z);
}

double lw_newton_angle(const lw_newton *s, int link)
{
    int b = s->system.body[link];
    return b < 0 ? 0.0 : s->here.z[3*b + 2] + 2.0*LW_PI*s->here.turns[b];
}

double lw_newton_input(const lw_newton *s)
{
    return s->value + s->unit*(s->here.z[s->n] + 2.0*LW_PI*s->here.input_turns);
}

double lw_newton_residual(const lw_newton *s)
{
    return s->system.unit*evaluate(s, s->here.z, s->rest, NULL);
}

int lw_newton_crossings(const lw_newton *s) { return s->crossings; }
