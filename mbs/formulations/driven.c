/* mbs/formulations/driven.c - every freedom is driven: postures on the certified motion of the inputs
 * (mbs/constraints/prescribed_motion.h), which does not depend on the samples; velocities, accelerations and forces
 * from the factors of the rows.
 *
 * Near a branch point these lose digits: at the distance x [rad] from it rounding is magnified by 1/x^4.  There all
 * quantities are interpolated from places on both sides: with one input along its value, with the speed and acceleration
 * that it has at the moment asked for, since in time the input may turn back close to the branch point.  Postures are analytic,
 * and multipliers have at most a simple pole, so the product of multiplier and
 * distance from the branch point is analytic too.  Its value there is the strength of the pole; where that is 0, its
 * derivative is the limit of the multiplier.  The power of a moving input is finite, so its drive has a limit; reactions
 * often have none.  With several inputs, rates follow from a regular posture nearby (mbs/constraints/prescribed_motion.h), drives from the rates by
 * virtual work, and reactions by interpolation along a straight line of values of the inputs. */
#include "base/number.h"
#include "base/real.h"
#include "mbs/formulations/formulations_internal.h"
#include "mbs/dynamics/follow_internal.h"
#include "mbs/dynamics/touch_internal.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"
#include "mbs/equations/limits_internal.h"
#include "mbs/space/space_hold.h"

enum { N_SIDE = 6, N_NODE = 2*N_SIDE };

/* Places of a window as fractions of half its length: Chebyshev's points for an interval with a gap in the middle. */
static const double node[N_SIDE] = { 0.280, 0.447, 0.640, 0.808, 0.929, 0.992 };
static const double longest_half = 0.3;        /* half of a window, scaled: about radians */
static const double beside = 0.1;            /* weakest pivot at which a branch point is looked for */
static const double line_half = 0.05;        /* half of a line of values of several inputs, scaled */
static const double few_digits = 0.03;       /* pivot below which such a line is looked at */
static const double no_digits = 1e-3;        /* pivot below which reactions from the factors alone have no digits */
static const double agreed = 1e-6;           /* greatest difference of two interpolations of a window, relative */
static const double enough = 1e-9;           /* such a difference that a shorter window need not improve */
static const double no_pole = 1e-8;          /* strength of a pole that counts as 0, relative */
static const double far_from_pole = 1e-3;    /* distance, over half a line, at which the quotient keeps its digits */
static const double at_pole = 1e-7;          /* distance from a pole, over half the window, without a value */

/* Samples around one branch point: q, v, a, then the distance from it times the multipliers.  A place is the value of the
 * input.  On a line of values of several inputs: the multipliers, then the product of all pivots, at parameters of the line. */
typedef struct window {
    double at, half;                         /* place of the branch point; half the length; 0: no window */
    double off;                              /* difference of two interpolations */
    double x[N_NODE], *values;               /* places from `at`; (N_NODE x width) */
} window;

typedef struct driven {
    lw_run     *run;
    lw_dynamics *d;
    lw_system   system;                      /* with the driven inputs only */
    lw_prescribed_motion *motion;
    lw_prescribed_motion *by_place;          /* postures by the place; NULL unless one input moves */
    int         width;
    window      found, tried;
    double     *gap;                         /* gaps and rates of the places that may touch, at the moment looked at last */
    double      touch_t, touch_for;          /* that moment, and how long none can close unseen */
    bool        made;                        /* `found` has been looked for at found.at */
    double      piece;                       /* longest time followed at once [s] */
    double      clear_from, clear_to;        /* no branch point between these places */
    double      middle[2*LW_SYSTEM_Q_MAX + LW_SYSTEM_Q_MAX + LW_MBS_ROW_MAX];
    double      rough[3*LW_SYSTEM_Q_MAX + LW_MBS_ROW_MAX];
    double      pole[LW_MBS_ROW_MAX + 1], moved[LW_INPUT_MAX*LW_SYSTEM_Q_MAX];
} driven;

/* ---- one moment ---------------------------------------------------------------------------------------- */

/* Accelerations d->a and multipliers d->l at (t, q, v), of a quasistatic analysis the multipliers of a model at rest.  by_rank: with factors for
 * rows that depend on each other; project: v becomes the velocities at (t, q) first.  LW_OPEN: the posture is singular. */
static lw_status forces_by(lw_dynamics *d, bool by_rank, bool project, double t, const double *q, double *v)
{
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, by_rank);
    if (s == LW_OK && project)
        s = lw_mbs_project_v(d, t, v);
    if (s == LW_OK)
        s = lw_mbs_solve(d, t, q, v, d->a, d->l, NULL);
    if (s != LW_OK || d->o.analysis != LW_ANALYSIS_QUASISTATIC)
        return s;
    memset(d->v_try, 0, (size_t)d->n_v*sizeof *d->v_try);
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    d->eq.forces(d->eq.context, t, q, d->v_try, d->force, NULL);
    if (d->touch)
        lw_mbs_touch_forces(d, d->v_try, d->force, NULL);
    if (!by_rank)
        return lw_mbs_linear(d, d->force, d->rhs, d->v_try, d->l);
    lw_rank_solve(&d->rank_of, d->force, d->l);
    return LW_OK;
}

static lw_status forces_at(lw_dynamics *d, double t, const double *q, double *v)
{
    return forces_by(d, d->rank < d->n_c || d->o.analysis == LW_ANALYSIS_QUASISTATIC, false, t, q, v);
}

/* Velocities v at (t, q). */
static lw_status velocities_at(lw_dynamics *d, double t, const double *q, double *v)
{
    memset(v, 0, (size_t)d->n_q*sizeof *v);
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    return s == LW_OK ? lw_mbs_project_v(d, t, v) : s;
}

/* Distance of all rows from dependence at q, about radians from a singular posture. */
static double apart(lw_dynamics *d, double t, const double *q)
{
    if (lw_mbs_rows(d, t, q) != LW_OK || lw_mbs_factor(d, true) != LW_OK)
        return 0;
    return d->rank_of.weakest;
}

/* ---- around a branch point ------------------------------------------------------------------------------ */

/* Value (width) at x from the branch point, from `n` of the places on either side beginning with the outermost; if
 * slope, the derivative at x instead. */
static void interpolate(const window *w, int width, int n, double x, bool slope, double *out)
{
    memset(out, 0, (size_t)width*sizeof *out);
    for (int i = N_SIDE - n; i < N_SIDE + n; i++) {
        double product = 1, sum = 0;
        for (int j = N_SIDE - n; j < N_SIDE + n; j++) {
            if (j == i)
                continue;
            double step = 1/(w->x[i] - w->x[j]), other = step;
            for (int k = N_SIDE - n; slope && k < N_SIDE + n; k++)
                other *= k == i || k == j ? 1 : (x - w->x[k])/(w->x[i] - w->x[k]);
            sum += other;
            product *= (x - w->x[j])*step;
        }
        for (int c = 0; c < width; c++)
            out[c] += (slope ? sum : product)*w->values[i*width + c];
    }
}

/* Greatest value of part k at the places: q, v, a, multipliers. */
static double scale(const driven *z, const window *w, int k)
{
    int n = z->d->n_q;
    double most = 0;
    for (int i = 0; i < N_NODE; i++)
        most = fmax(most, lw_greatest(k < 3 ? n : z->d->n_c, w->values + i*z->width + k*n));
    return most;
}

/* Go to the places of the window w, whose `at` and `half` are set, and compare two interpolations at its middle.  The
 * speeds and accelerations of the inputs and the forces are those of time t. */
static lw_status fill(driven *z, window *w, double t)
{
    lw_dynamics *d = z->d;
    int n = d->n_q;
    for (int i = 0; i < N_NODE; i++) {
        double *to = w->values + i*z->width;
        w->x[i] = i < N_SIDE ? -w->half*node[N_SIDE - 1 - i] : w->half*node[i - N_SIDE];
        lw_status s = lw_prescribed_motion_to(z->by_place, w->at + w->x[i]);
        if (s == LW_OK) {
            memcpy(to, lw_prescribed_motion_posture(z->by_place), (size_t)n*sizeof *to);
            s = velocities_at(d, t, to, to + n);
        }
        if (s == LW_OK)
            s = forces_at(d, t, to, to + n);
        if (s != LW_OK || isnan(d->l[0]))
            return s == LW_OK ? LW_OPEN : s;
        memcpy(to + 2*n, d->a, (size_t)n*sizeof *to);
        for (int c = 0; c < d->n_c; c++)
            to[3*n + c] = d->l[c]*w->x[i];
    }
    w->off = 0;
    for (int slope = 0; slope < 2; slope++) {
        interpolate(w, z->width, N_SIDE, 0, slope, z->middle);
        interpolate(w, z->width, N_SIDE - 1, 0, slope, z->rough);
        for (int c = 0; c < z->width; c++)
            z->rough[c] -= z->middle[c];
        for (int k = 0; k < 4; k++)
            w->off = fmax(w->off, lw_greatest(k < 3 ? n : d->n_c, z->rough + k*n)*(slope ? w->half : 1) /fmax(scale(z, w, k), 1e-300));
    }
    return LW_OK;
}

/* A window around the branch point at `at` for time t: the length whose interpolations agree best. */
static void make_window(driven *z, double at, double half, double t)
{
    window *best = &z->found, *next = &z->tried;
    best->half = 0;
    best->off = INFINITY;
    for (int k = 0; k < 5 && best->off > enough; k++, half *= 0.5) {
        next->at = at;
        next->half = half;
        if (fill(z, next, t) != LW_OK || !(next->off < best->off))
            continue;
        window was = *best;
        *best = *next;
        *next = was;
    }
    if (!(best->off < agreed))
        best->half = 0;
    best->at = at;
}

/* Is there a branch point within `half` of the place x?  Leaves the motion at another place. */
static bool look_around(driven *z, double x, double half, double *at)
{
    double last;
    int before = lw_prescribed_motion_crossings(z->by_place, &last);
    if (before > 0 && fabs(last - x) < half)
        return *at = last, true;
    for (int side = 1; side >= -1; side -= 2) {
        if (lw_prescribed_motion_to(z->by_place, x + side*half) != LW_OK)
            lw_prescribed_motion_to(z->by_place, x);
        if (lw_prescribed_motion_crossings(z->by_place, &last) > before && fabs(last - x) < half)
            return *at = last, true;
        lw_prescribed_motion_to(z->by_place, x);
    }
    z->clear_from = x - half;
    z->clear_to = x + half;
    return false;
}

/* Fill q and v (y), d->a and d->l at a place from the window.  A multiplier without a limit is NaN. */
static void from_window(driven *z, double place, double *y)
{
    const window *w = &z->found;
    lw_dynamics *d = z->d;
    int n = d->n_q;
    double x = place - w->at, most = scale(z, w, 3), *pole = z->middle;
    bool near = fabs(x) < at_pole*w->half;
    interpolate(w, z->width, N_SIDE, 0, false, pole);
    interpolate(w, z->width, N_SIDE, x, false, z->rough);
    memcpy(y, z->rough, 2*(size_t)n*sizeof *y);
    memcpy(d->a, z->rough + 2*n, (size_t)n*sizeof *d->a);
    for (int c = 0; c < d->n_c && !near; c++) {
        double strength = fabs(pole[3*n + c]) <= no_pole*most ? pole[3*n + c] : 0;
        d->l[c] = (z->rough[3*n + c] - strength)/x;
    }
    if (!near)
        return;
    interpolate(w, z->width, N_SIDE, 0, true, z->rough);
    for (int c = 0; c < d->n_c; c++)
        d->l[c] = fabs(pole[3*n + c]) <= no_pole*most ? z->rough[3*n + c] : NAN;
}

static bool within(const window *w, double x) { return w->half > 0 && fabs(x - w->at) < node[0]*w->half; }

/* ---- samples --------------------------------------------------------------------------------------------- */

static lw_status lost(driven *z, lw_status s)
{
    lw_prescribed_motion_ended(z->motion, s, &z->d->model->linkage, z->run->e);
    return LW_E_NUMERIC;
}

/* Follow the motion to t, in pieces between which the run can be stopped. */
static lw_status follow(driven *z, double t)
{
    double from = lw_prescribed_motion_time(z->motion), piece = z->piece;
    lw_status s = LW_OK;
    for (long i = 1; s == LW_OK && from + i*piece < t; i++) {
        if ((s = lw_prescribed_motion_to(z->motion, from + i*piece)) != LW_OK)
            return lost(z, s);
        s = lw_limits_check(z->d->o.stop, z->d->o.until, true, from + i*piece, z->run->e);
    }
    if (s == LW_OK && (s = lw_prescribed_motion_to(z->motion, t)) != LW_OK)
        return lost(z, s);
    return s;
}

/* One input: if the posture at t is near a branch point, fill the moment at t from places around it.  false: it is not. */
static bool from_crossing(driven *z, double t, double *y)
{
    lw_dynamics *d = z->d;
    int n = d->n_q;
    double x, at, series[2*LW_SYSTEM_Q_MAX];
    lw_mbs_driven_inputs(d, t, 0, &x);
    if (x > z->clear_from && x < z->clear_to)
        return false;
    if (lw_prescribed_motion_to(z->by_place, x) != LW_OK)     /* at a limit of the input, to rounding */
        return false;
    if (!lw_prescribed_motion_rates(z->by_place, 1, series) || !(lw_greatest(n, series + n) > 0))
        return false;
    double half = longest_half/lw_greatest(n, series + n);
    if (!look_around(z, x, half, &at))
        return false;
    if (!z->made || fabs(z->found.at - at) > 0.1*half)
        make_window(z, at, half, t);
    else if (within(&z->found, x) && fill(z, &z->found, t) != LW_OK)
        z->found.half = 0;
    z->made = true;
    if (!within(&z->found, x))
        return false;
    from_window(z, x, y);
    return true;
}

/* Multipliers and distance from dependence (the product of all pivots) at the places of a straight line of values of the inputs through
 * those at t, towards the regular posture.  Width: n_c + 1. */
static bool fill_line(driven *z, double t, const double *u, window *w)
{
    lw_dynamics *d = z->d;
    const double *regular = lw_prescribed_motion_regular(z->motion);
    double direction[LW_INPUT_MAX], at[LW_INPUT_MAX], longest = 0, *q = z->middle, *v = q + d->n_q;
    for (int i = 0; i < d->n_driven && regular; i++) {
        direction[i] = regular[i] - u[i];
        longest = fmax(longest, fabs(direction[i])/lw_system_joint_unit(&z->system, z->system.input_joint[i]));
    }
    if (!(longest > 0))
        return false;
    int rank = 0;
    for (int k = 0; k < N_NODE; k++) {
        double *to = w->values + k*(d->n_c + 1), *pivots = to + d->n_c;
        w->x[k] = k < N_SIDE ? -node[N_SIDE - 1 - k] : node[k - N_SIDE];
        for (int i = 0; i < d->n_driven; i++)
            at[i] = u[i] + w->x[k]*line_half/longest*direction[i];
        if (!lw_prescribed_motion_near(z->motion, at, q) || velocities_at(d, t, q, v) != LW_OK || forces_at(d, t, q, v) != LW_OK)
            return false;
        memcpy(to, d->l, (size_t)d->n_c*sizeof *to);
        apart(d, t, q);
        if (k > 0 && d->rank_of.rank != rank)
            return false;
        rank = d->rank_of.rank;
        *pivots = 1;
        for (int i = 0; i < rank; i++)
            *pivots *= fabs(d->rank_of.a[i + d->rank_of.m*i]/d->rank_of.a[0]);
    }
    return true;
}

/* Multipliers d->l at the middle of the line: the root of order `rank lost` of the product of pivots is 0 where the posture is singular, and changes its
 * sign there; times it multipliers are smooth.  false: they are not. */
static bool from_line(driven *z, const window *line, int lost)
{
    lw_dynamics *d = z->d;
    int n = d->n_c, width = n + 1;
    double *value = z->middle, *other = z->rough, most = 0, size = 0, noise = 0;
    window *w = &z->found;
    memcpy(w->x, line->x, sizeof w->x);
    for (int k = 0; k < N_NODE; k++) {
        const double *l = line->values + k*width;
        double *to = w->values + k*width;
        to[n] = copysign(pow(l[n], 1.0/lost), w->x[k]);
        for (int c = 0; c < n; c++)
            most = fmax(most, fabs(to[c] = l[c]*to[n]));
        size = fmax(size, fabs(to[n]));
    }
    noise = no_pole*most;
    for (int slope = 0; slope < 2; slope++) {
        interpolate(w, width, N_SIDE, 0, slope, value);
        interpolate(w, width, N_SIDE - 1, 0, slope, other);
        for (int c = 0; c <= n; c++) {
            if (!(fabs(value[c] - other[c]) <= agreed*(c < n ? most : size)))
                return false;
            noise = fmax(noise, c < n ? fabs(value[c] - other[c]) : 0);
        }
    }
    interpolate(w, width, N_SIDE, 0, false, other);
    double away = other[n], x = -away/value[n];           /* the pole is at x */
    interpolate(w, width, N_SIDE, x, false, z->pole);
    if (fabs(x) < far_from_pole)
        interpolate(w, width, N_SIDE, 0.5*x, true, value);
    for (int c = 0; c < n; c++) {
        double strength = fabs(z->pole[c]);               /* small beside the noise, or large, or unknown */
        d->l[c] = fabs(x) >= far_from_pole ? other[c]/away : strength <= noise ? value[c]/value[n]
                : strength > 1e3*noise && fabs(x) > at_pole ? other[c]/away : NAN;
    }
    return true;
}

/* With several inputs the posture is a smooth function of their values in a singular posture, too: posture and velocities y, accelerations,
 * and by virtual work the drives.  Reactions follow from a line of their values; those without a limit, or not found, are NaN, and so are the
 * drives if joints have friction. */
static bool from_values(driven *z, double t, double off, double *y)
{
    static const double still[LW_SYSTEM_Q_MAX];
    lw_dynamics *d = z->d;
    int n = d->n_q;
    double u[LW_INPUT_MAX], way[2*LW_INPUT_MAX], series[3*LW_SYSTEM_Q_MAX], one[2*LW_SYSTEM_Q_MAX];
    bool slow = d->o.analysis == LW_ANALYSIS_QUASISTATIC, found = false, known = true;
    if (!lw_prescribed_motion_rates(z->motion, 2, series))
        return false;
    memcpy(y, series, 2*(size_t)n*sizeof *y);
    lw_mbs_driven_inputs(d, t, 0, u);
    for (int k = 0; k < d->n_driven && known; k++) {      /* now the directions in which inputs move it, below their work */
        for (int i = 0; i < d->n_driven; i++) {
            way[2*i] = u[i];
            way[2*i + 1] = i == k ? lw_system_joint_unit(&z->system, z->system.input_joint[i]) : 0;
        }
        known = lw_prescribed_motion_along(z->motion, 1, way, one);
        memcpy(z->moved + k*n, one + n, (size_t)n*sizeof *one);
        for (int i = 0; i < n; i++)
            known = known && fabs(one[i] - y[i]) < 1e-6;
    }
    if (known && !lw_prescribed_motion_regular(z->motion))            /* the posture is regular enough */
        return false;
    bool filled = known && fill_line(z, t, u, &z->tried);
    for (int lost = 1; lost <= d->n_driven && filled && !found; lost++)
        found = from_line(z, &z->tried, lost);
    found = found || (off > no_digits && lw_prescribed_motion_near(z->motion, u, z->middle) && velocities_at(d, t, z->middle, z->rough) == LW_OK
                      && forces_at(d, t, z->middle, z->rough) == LW_OK);
    for (int c = 0; c < d->n_c && !found; c++)
        d->l[c] = NAN;
    for (int i = 0; i < n; i++)
        d->a[i] = 2*series[2*n + i];
    lw_forces_apply(&d->f, t, y, slow ? still : y + n, d->force, NULL, NULL, NULL);
    if (d->touch)
        lw_mbs_touch_forces(d, slow ? still : y + n, d->force, NULL);
    for (int k = 0; k < d->n_driven && known && !d->n_friction; k++) {
        double work = 0;
        for (int i = 0; i < n; i++)
            work += (d->force[i] - (slow ? 0 : d->f.mass[i]*d->a[i]))*z->moved[k*n + i];
        d->l[d->n_row + k] = work;
    }
    return true;
}

/* Posture and velocities y, accelerations and multipliers at t.  LW_OPEN: the forces are not known. */
static lw_status moment_at(driven *z, double t, double *y)
{
    lw_dynamics *d = z->d;
    int n = d->n_q;
    lw_status s = follow(z, t);
    if (s != LW_OK)
        return s;
    memcpy(y, lw_prescribed_motion_posture(z->motion), (size_t)n*sizeof *y);
    double off = apart(d, t, y);
    if (d->n_driven == 1 ? off < beside && from_crossing(z, t, y) : off < few_digits && from_values(z, t, off, y))
        return LW_OK;
    double series[2*LW_SYSTEM_Q_MAX];
    s = velocities_at(d, t, y, y + n);
    if (s == LW_OPEN) {
        bool known = lw_prescribed_motion_rates(z->motion, 1, series);
        for (int i = 0; i < n; i++)
            y[n + i] = known ? series[n + i] : NAN;
    }
    return s == LW_OK ? forces_at(d, t, y, y + n) : s;
}

/* ---- contact --------------------------------------------------------------------------------------------- */

/* The gap of a place at t, which lies between two moments that were looked at. */
static lw_status gap_at(driven *z, double t, double *y, int place, double *gap)
{
    lw_dynamics *d = z->d;
    lw_touch_motion m;
    lw_status s = moment_at(z, t, y);
    if (s != LW_OK && s != LW_OPEN)
        return s;
    d->eq.place(d->eq.context, y);
    lw_touch_at(&d->touch->list.touch[place], &d->eq, d->frames, NULL, &m);
    *gap = m.gap;
    return LW_OK;
}

/* Rigid shapes, ropes and stops in the posture y at t: an error if one is closed, or closed and opened again since the
 * moment before: how much it carries does not follow from a prescribed motion. */
static lw_status look_at_places(driven *z, double t, double *y, double *between)
{
    lw_dynamics *d = z->d;
    lw_touch_list *list = &d->touch->list;
    bool first = t == d->o.from;
    d->eq.place(d->eq.context, y);
    for (int i = 0; i < list->n; i++) {
        lw_touch *p = &list->touch[i];
        lw_touch_motion m;
        lw_touch_choose_side(p, d->frames, first, LW_TOUCH_END);
        lw_touch_at(p, &d->eq, d->frames, y + d->n_q, &m);
        double *was = z->gap + 2*i, h = t - z->touch_t, least = m.gap, when = t;
        if (!(p->surface->stiffness > 0) && !first && was[1] < 0 && m.rate > 0 && h > 0) {
            double x = fmin(fmax(was[1]/(was[1] - m.rate), 0), 1), z1 = 1 - x;           /* least of the cubic, nearly */
            double guess = was[0]*z1*z1*(1 + 2*x) + m.gap*x*x*(3 - 2*x) + h*x*z1*(z1*was[1] - x*m.rate);
            if (guess < 0.1*fmin(was[0], m.gap)) {
                lw_status s = gap_at(z, when = z->touch_t + x*h, between, i, &least);
                if (s == LW_OK)
                    s = moment_at(z, t, between);
                if (s < 0)
                    return s;
                d->eq.place(d->eq.context, y);
            }
        }
        was[0] = m.gap;
        was[1] = m.rate;
        if (!(p->surface->stiffness > 0) && least < LW_TOUCH_CLOSED)
            return lw_error_set(z->run->e, LW_E_KIND, "the prescribed motion brings \"%s\" to %s at t = %.9g s: inputs that move every "
                                "freedom do not give way, so how much a rigid %s carries is not determined; give it a "
                                "\"stiffness\", or leave the motion of an input out", lw_touch_name(d->model, p),
                                p->kind == LW_TOUCH_STOP ? "its rigid stop" : p->kind == LW_TOUCH_ROPE ? "its length" : "touch",
                                when, p->kind == LW_TOUCH_STOP ? "stop" : p->kind == LW_TOUCH_ROPE ? "rope" : "contact");
    }
    z->touch_t = t;
    return LW_OK;
}

/* Look at the places from the last moment on up to t, in steps in which no disc passes a body; y is the moment at t. */
static lw_status watch_places(driven *z, double t, double *y, double *between)
{
    lw_dynamics *d = z->d;
    lw_status s = LW_OK;
    while (s == LW_OK && t > d->o.from && z->touch_t + z->touch_for < t) {
        double at = z->touch_t + fmax(z->touch_for, 1e-9*(d->o.to - d->o.from));
        if (!(at < t))
            break;
        s = moment_at(z, at, between);
        s = s == LW_OPEN ? LW_OK : s;
        if (s == LW_OK) {
            memcpy(y, between, 2*(size_t)d->n_q*sizeof *y);
            s = look_at_places(z, at, y, between);
            z->touch_for = fmin(0.25*lw_run_touch_step(z->run, y), z->piece/2000);
        }
        if (s == LW_OK)
            s = lw_limits_check(d->o.stop, d->o.until, true, at, z->run->e);
    }
    if (s == LW_OK)
        s = moment_at(z, t, y);
    if (s != LW_OK && s != LW_OPEN)
        return s;
    lw_status looked = look_at_places(z, t, y, between);
    z->touch_for = fmin(0.25*lw_run_touch_step(z->run, y), z->piece/2000);
    return looked == LW_OK ? s : looked;
}

/* The energy balance is not checked: nothing is integrated, and the work of the driving torques, from their powers
 * at the samples, would be known to second order only. */
static lw_status run_all(driven *z, double *y)
{
    lw_run *run = z->run;
    lw_dynamics *d = z->d;
    double fastest = 0, motion[3];
    lw_status s = LW_OK;
    for (int i = 0; i < d->n_driven; i++)
        for (double t = d->o.from; t <= d->o.to; t += d->o.to - d->o.from)
            if (lw_mbs_motion(d, i, t, motion) == LW_OK)
                fastest = fmax(fastest, fabs(motion[1]));
    if (!(DBL_EPSILON*fmax(fabs(d->o.from), fabs(d->o.to))*fastest < 0.1))
        return lw_error_set(run->e, LW_E_ARG, "the times %.9g s to %.9g s have too few digits for inputs that move by %.3g "
                            "(radians or multiples of the size) in a second", d->o.from, d->o.to, fastest);
    z->piece = fmin(d->o.to - d->o.from, 100/fmax(fastest, 1e-300));
    for (int k = 0; s == LW_OK && k <= d->o.intervals; k++) {
        double t = lw_run_time(d, k), before = lw_run_time(d, k > 0 ? k - 1 : 0);
        for (int i = 1, looks = lw_run_looks(d); s == LW_OK && i <= looks && d->n_stop > 0; i++)
            if ((s = follow(z, i == looks ? t : before + (t - before)*i/looks)) == LW_OK)
                s = lw_run_look_at_stops(run, lw_prescribed_motion_time(z->motion), lw_prescribed_motion_posture(z->motion));
        if (s != LW_OK)
            break;
        s = d->touch ? watch_places(z, t, y, z->gap + 2*d->touch->list.n) : moment_at(z, t, y);
        if (s == LW_OPEN)
            for (int i = 0; i < d->n_q || i < d->n_c; i++) {
                if (i < d->n_q)
                    d->a[i] = NAN;
                if (i < d->n_c)
                    d->l[i] = NAN;
            }
        if (s == LW_OK || s == LW_OPEN)
            s = lw_run_show_solved(run, t, y);
        run->r->steps++;
        if (s == LW_OK)
            s = lw_run_limits(run, t, k);
    }
    return s;
}

/* Models of any size (mbs/dynamics/follow.h). */
static lw_status run_large(lw_run *run)
{
    lw_dynamics *d = run->d;
    size_t n = (size_t)d->n_q;
    lw_follow *f = NULL;
    double *y = calloc(2*n, sizeof *y);
    run->has_work = false;
    lw_status s = y ? lw_follow_ready(d, lw_mbs_driven_inputs, d, d->o.from, &f, run->e)
                    : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    for (int k = 0; s == LW_OK && k <= d->o.intervals; k++) {
        double t = lw_run_time(d, k), before = lw_follow_time(f);
        for (int i = 1, looks = lw_run_looks(d); s == LW_OK && i <= looks; i++) {
            double at = i == looks ? t : before + (t - before)*i/looks;
            s = lw_follow_to(f, at, run->e);
            if (s == LW_OPEN)
                s = lw_error_set(run->e, LW_E_NUMERIC, "the linkage cannot follow its inputs beyond t = %.12g s: it stands at a "
                                 "limit of its motion", lw_follow_time(f));
            s = s == LW_OK ? lw_run_look_at_stops(run, at, lw_follow_series(f)) : s;
        }
        if (s != LW_OK)
            break;
        memcpy(y, lw_follow_series(f), 2*n*sizeof *y);
        for (size_t i = 0; i < n; i++)
            d->hold[i] = 2*lw_follow_series(f)[2*n + i];
        s = forces_by(d, false, false, t, y, y + n);
        if (s == LW_OPEN) {                                  /* a singular posture has accelerations, and perhaps no reactions */
            for (int i = 0; i < d->n_c; i++)
                d->l[i] = NAN;
            memcpy(d->a, d->hold, n*sizeof *d->a);
            if (d->n_driven == 1)
                d->l[d->n_row] = lw_mbs_drive_by_power(d, t, y, y + n);
        }
        s = s == LW_OK || s == LW_OPEN ? lw_run_show_solved(run, t, y) : s;
        run->r->steps++;
        if (s == LW_OK)
            s = lw_run_limits(run, t, k);
    }
    run->r->lost = f && lw_follow_lost(f, run->r->lost_t);
    lw_follow_free(f);
    free(y);
    return s;
}

/* ---- models in space -------------------------------------------------------------------------------------- */

/* Accelerations d->a and multipliers d->l at (t, q); v becomes the velocities there. */
static lw_status forces_in_space(lw_dynamics *d, double t, const double *q, double *v)
{
    bool still = d->o.analysis == LW_ANALYSIS_QUASISTATIC;
    memset(v, 0, (size_t)d->n_v*sizeof *v);
    lw_status s = forces_by(d, d->rank < d->n_c || d->has_zero_mass || still, true, t, q, v);
    if (s == LW_OK && still)
        memset(d->a, 0, (size_t)d->n_v*sizeof *d->a);
    return s;
}

/* Near a singular posture: multipliers d->l for the velocities and accelerations of f, where they are known to 1e-6 of the greatest, otherwise
 * NAN; that of a single drive follows from its power. */
static lw_status forces_beside(lw_dynamics *d, const lw_space_follow *f, double t, const double *q, double *v)
{
    bool still = d->o.analysis == LW_ANALYSIS_QUASISTATIC;
    double top = 0;
    memcpy(d->a, f->a, (size_t)d->n_v*sizeof *d->a);
    memcpy(v, f->v, (size_t)d->n_v*sizeof *v);
    lw_status st = lw_mbs_rows(d, t, q);
    if (st != LW_OK)
        return st;
    double drive = lw_mbs_drive_by_power(d, t, q, v), most = lw_greatest(d->n_v, d->force);
    st = lw_mbs_factor(d, d->rank < d->n_c || d->has_zero_mass || still);
    memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
    if (st == LW_OK)
        st = lw_mbs_linear(d, d->force, d->rhs, d->hold, d->l);
    for (int r = 0; st == LW_OK && r < d->n_c; r++)
        top = fmax(top, fabs(d->l[r]));
    double apart = d->by_rank ? d->rank_of.weakest : sqrt(d->weak);
    bool known = st == LW_OK && !d->n_friction && LW_SPACE_BETWEEN*most < 1e-6*top*apart;
    for (int r = 0; r < d->n_c && !known; r++)
        d->l[r] = NAN;
    if (!isnan(drive))
        d->l[d->n_row] = drive;
    if (still) {
        memset(v, 0, (size_t)d->n_v*sizeof *v);
        memset(d->a, 0, (size_t)d->n_v*sizeof *d->a);
    }
    return st == LW_OPEN ? LW_OK : st;
}

static lw_status run_spatial(lw_run *run)
{
    lw_dynamics *d = run->d;
    lw_space_follow *f = &d->space->follow;
    lw_space_watch w = { 0 };
    double *y = calloc((size_t)run->n, sizeof *y);
    lw_status st = y ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    for (int k = 0; st == LW_OK && k <= d->o.intervals; k++) {
        double t = lw_run_time(d, k);
        double before = f->u;
        if (k == 1)
            st = lw_space_watch_begin(&w, f, run->e);
        for (int i = 1, looks = lw_run_looks(d); st == LW_OK && i <= looks; i++) {
            double at = i == looks ? t : before + (t - before)*i/looks;
            if ((st = lw_limits_check(d->o.stop, d->o.until, true, at, run->e)) == LW_OK)
                st = lw_space_follow_to(f, lw_mbs_driven_path, d, at, run->e);
            st = st == LW_OPEN ? LW_E_NUMERIC : st;      /* its text says where and why */
            st = st == LW_OK ? lw_run_look_at_stops(run, at, f->q) : st;
        }
        if (st != LW_OK)
            break;
        run->r->t = t;
        lw_space_follow_rates(f, lw_mbs_driven_path, d);
        memcpy(y, f->q, (size_t)d->n_q*sizeof *y);
        d->eq.accept(d->eq.context, y);
        if (d->space->has_drives && d->o.analysis != LW_ANALYSIS_QUASISTATIC) {      /* which find all forces from the motion */
            memcpy(y + d->n_q, f->v, (size_t)d->n_v*sizeof *y);
            memcpy(d->a, f->a, (size_t)d->n_v*sizeof *d->a);
            memset(d->l, 0, (size_t)d->n_c*sizeof *d->l);
        } else
            st = f->between ? forces_beside(d, f, t, y, y + d->n_q) : forces_in_space(d, t, y, y + d->n_q);
        if (st == LW_OPEN)
            st = lw_error_set(run->e, LW_OPEN, "at t = %.9g s the model stands in a singular posture", t);
        if (st == LW_OK)
            st = lw_run_show_solved(run, t, y);
        run->next++;
        run->r->steps++;
    }
    run->r->lost = w.lost;
    memcpy(run->r->lost_t, w.between, sizeof w.between);
    memcpy(run->r->lost_how, w.how, sizeof w.how);
    lw_space_watch_end(&w);
    free(y);
    return st;
}

/* ---- all models -------------------------------------------------------------------------------------------- */

static lw_status run_driven(lw_run *run)
{
    if (run->d->space)
        return run_spatial(run);
    if (run->d->large)
        return run_large(run);
    lw_dynamics *d = run->d;
    size_t n = (size_t)d->n_q, width = 3*n + (size_t)d->n_c;
    driven *z = calloc(1, sizeof *z);
    size_t places = d->touch ? 2*(size_t)d->touch->list.n + 2*n : 0;
    double *y = calloc(2*n + 2*N_NODE*width + places, sizeof *y);
    run->has_work = false;
    lw_status s = z && y ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        z->run = run;
        z->d = d;
        z->width = (int)width;
        z->found.values = y + 2*n;
        z->tried.values = z->found.values + N_NODE*width;
        z->gap = z->tried.values + N_NODE*width;
        if (d->touch)
            d->touch->events = false;        /* compliant places press by their depth alone */
        z->clear_from = z->clear_to = -INFINITY;
        s = lw_mbs_follow(d, &z->system, &z->motion, run->e);
    }
    if (s == LW_OK) {
        z->by_place = lw_prescribed_motion_by_value(z->motion);
        s = run_all(z, y);
        run->r->lost = lw_prescribed_motion_lost(z->motion, &d->model->linkage, run->r->lost_t, run->r->lost_how);
    }
    if (z) {
        lw_prescribed_motion_free(z->motion);
        lw_system_free(&z->system);
    }
    free(z);
    free(y);
    return s;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    char why[200];
    for (int i = 0; d->touch && i < d->touch->list.n; i++) {
        const lw_surface *p = d->touch->list.touch[i].surface;
        if (p->stiffness > 0 && p->friction > 0 && !(p->friction_speed > 0))
            return lw_formulation_say(r, LW_E_KIND, 0, "static friction of a contact whose bodies are driven is not determined while "
                                      "they do not slip: give it a \"friction_speed\"");
    }
    if (d->touch && (d->space || d->large))
        return lw_formulation_say(r, LW_E_KIND, 0, "contacts in prescribed motion take part in planar models of up to 32 links");
    if (d->eq.n_z)
        return lw_formulation_say(r, LW_E_KIND, 0, "first-order states need the motion in time");
    if (d->freedom == 0)
        return snprintf(why, sizeof why, "every freedom is driven: kinematics, then forces%s", d->space ? lw_mbs_is_planar(d) : ""),
               lw_formulation_say(r, LW_OK, d->n_v, why);
    snprintf(why, sizeof why, "%d more freedom%s would have to be driven for this analysis: give every input a "
             "\"motion\", or ask for dynamic", d->freedom, lw_plural(d->freedom));
    return lw_formulation_say(r, asked ? LW_E_ARG : LW_E_KIND, 0, why);
}

const lw_formulation_row lw_formulation_driven = { able, run_driven };
