/* mbs/equilibrium/statics_large.c - equilibrium of models of any size, by Newton's method with sparse matrices.
 *
 * The force that the start lacks is taken away in steps, F(q) = (1 - part) F(start), which for a dead load on an undeformed
 * model are load steps; a step that fails is halved.  Where the model gives way (a mechanism under gravity) or the result
 * is not stable (a column beyond its buckling load), masses are added to the stiffness and taken away as the potential
 * falls, which leads downhill to a stable equilibrium. */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/vector.h"
#include "mbs/equilibrium/statics_internal.h"
#include "mbs/dynamics/tangent_internal.h"
#include "mbs/equilibrium/vibration_internal.h"
#include "mbs/equations/limits_internal.h"

const char *lw_rest_text(const lw_rest *r)
{
    return r->unknown ? "stability not known, since a moment in space, or a force that turns with its link or depends on other quantities, has no potential"
         : r->stable ? "stable" : r->neutral ? "neutral: it can move without any force, so this is one of many postures of equilibrium" : "not stable";
}

typedef struct search {
    lw_dynamics *d;
    lw_tangent   tangent;
    int     n_q, n, c;                       /* coordinates, velocities, kept rows */
    double  t, soft;                         /* soft: masses in the matrix of balance */
    lw_status factored;                      /* of the matrix of the last step */
    double first;                            /* length of the first step of Newton's method */
    double *q, *l, *load, *residual, *step, *walked, *still, *old_q, *old_l, *aside;       /* walked: sum of the steps under a load */
} search;

static const int most_newton = 30, most_parts = 400, most_downhill = 2000;
static const double longest = 0.5;           /* step of Newton's method, in radians or sizes of the model */
static const double settled = 1e-13;         /* the same when it has converged, over the greatest coordinate */
static const double rounded = 1e-10;         /* the same when steps no longer become shorter */
static const double drifts = 1e-5;           /* the same along a motion that nothing resists, by the rounding of forces */
static const double slowest = 1e-6;          /* rate of such a motion, by rounding, over that of falling */

/* Forces added to those of the model: a part of the load that the start lacks, and of a load that pushes aside. */
typedef struct loads { double left, aside; } loads;

/* residual (n + c) = J^T l - Q + left*load - aside*aside, Phi. */
static lw_status find_residual(search *s, loads w)
{
    lw_dynamics *d = s->d;
    lw_status st = lw_mbs_rows(d, s->t, s->q);
    if (st != LW_OK)
        return st;
    d->eq.forces(d->eq.context, s->t, s->q, s->still, d->force, NULL);
    for (int i = 0; i < s->n; i++)
        s->residual[i] = w.left*s->load[i] - w.aside*s->aside[i] - d->force[i];
    lw_tangent_push(d, s->l, s->residual);
    for (int k = 0; k < s->c; k++)
        s->residual[s->n + k] = d->phi[d->kept[k]];
    return isfinite(lw_greatest_or_infinite(s->n + s->c, s->residual)) ? LW_OK : LW_E_NUMERIC;
}

/* One step with `mass` times the masses in the matrix.  Returns its length; INFINITY: there is none. */
static double newton_step(search *s, double mass)
{
    const double m[2] = { mass, 0 }, c[2] = { 0, 0 };
    s->factored = lw_tangent_factor(&s->tangent, s->t, s->q, s->still, s->l, m, c);
    if (s->factored != LW_OK)
        return INFINITY;
    for (int i = 0; i < s->n + s->c; i++)
        s->step[i] = -s->residual[i];
    lw_tangent_solve(&s->tangent, s->step);
    return lw_greatest_or_infinite(s->n, s->step);
}

static void move(search *s)
{
    s->d->eq.move(s->d->eq.context, s->q, s->step);
    for (int i = 0; i < s->n; i++)
        s->walked[i] += s->step[i];
    for (int k = 0; k < s->c; k++)
        s->l[k] += s->step[s->n + k];
}

/* Is a step of this size the last one that Newton's method needs?  before: size of the step before it. */
static bool is_last(const search *s, double size, double still, double before)
{
    double all = fmax(1, lw_greatest_or_infinite(s->n_q, s->q));
    return size <= settled*all || (size < still*all && size > 0.3*before);
}

static lw_status look_at_limits(const search *s) { return lw_limits_check(s->d->o.stop, s->d->o.until, true, s->t, NULL); }

/* Derivatives with the tensions in elements that the step about to be made leads to by its linear part: the stretch is of second order in the
 * deflection, and what it adds to the tension is gone after the next step (Magisano, Leonetti & Garcea 2017); by NULL: with those at hand. */
static void foresee(const search *s, const double *by)
{
    if (s->d->eq.foresee)
        s->d->eq.foresee(s->d->eq.context, s->q, by);
}

/* Newton's method under these loads. */
static lw_status newton(search *s, loads w, int *iterations)
{
    double before = INFINITY;
    memset(s->walked, 0, (size_t)s->n*sizeof *s->walked);
    for (int pass = 0; pass < most_newton; pass++) {
        if (look_at_limits(s) != LW_OK)
            return LW_STOPPED;
        lw_status st = find_residual(s, w);
        if (st != LW_OK)
            return LW_OPEN;
        double size = newton_step(s, s->soft);
        s->first = pass == 0 ? size : s->first;
        ++*iterations;
        if (s->factored == LW_E_MEMORY)
            return s->factored;
        if (!(size < longest) || (pass > 3 && size > 2*before))
            return LW_OPEN;
        foresee(s, s->step);
        move(s);
        if (is_last(s, size, s->soft > 0 ? drifts : rounded, pass > 2 ? before : INFINITY))
            return find_residual(s, w) == LW_OK ? LW_OK : LW_OPEN;
        before = size;
    }
    return LW_OPEN;
}

static lw_status balance(search *s, loads w, int *iterations)
{
    lw_status st = newton(s, w, iterations);
    foresee(s, NULL);
    return st;
}

static void keep(search *s)
{
    memcpy(s->old_q, s->q, (size_t)s->n_q*sizeof *s->q);
    memcpy(s->old_l, s->l, (size_t)s->c*sizeof *s->l);
}

static void put_back(search *s)
{
    memcpy(s->q, s->old_q, (size_t)s->n_q*sizeof *s->q);
    memcpy(s->l, s->old_l, (size_t)s->c*sizeof *s->l);
}

/* Has Newton's method left the path of the posture kept last, as beyond a snap-through?  On the path the motion is little more than that along
 * its tangent. */
static bool off_path(const search *s)
{
    double moved = lw_greatest_or_infinite(s->n, s->walked);
    return moved > longest || moved > 1.5*s->first + 1e-6;
}

/* From one pair of loads to another in parts. */
static lw_status load_steps(search *s, loads from, loads to, lw_rest *r)
{
    double part = 0, next = 1;
    keep(s);
    for (int k = 0; k < most_parts && part < 1; k++) {
        double end = fmin(part + next, 1);
        loads w = { from.left + end*(to.left - from.left), from.aside + end*(to.aside - from.aside) };
        lw_status st = balance(s, w, &r->iterations);
        if (st == LW_STOPPED || st == LW_E_MEMORY)
            return st;
        if (st == LW_OK && !off_path(s)) {
            keep(s);
            part = end;
            next *= 2;
        } else {
            put_back(s);
            next *= 0.5;
            if (next < 1e-6)
                return LW_OPEN;
        }
    }
    return part < 1 ? LW_OPEN : LW_OK;
}

/* Work of the forces on the step just taken from old_q to q, by their values at both ends; 0 where it is rounding. */
static double work_of_step(search *s, double size)
{
    lw_dynamics *d = s->d;
    double work = 0, all = 0;
    for (int end = 0; end < 2; end++) {
        d->eq.forces(d->eq.context, s->t, end ? s->q : s->old_q, s->still, d->force, NULL);
        for (int i = 0; i < s->n; i++) {
            work += 0.5*d->force[i]*s->step[i];
            all += fabs(d->force[i]*s->step[i]);
        }
    }
    return size < 1e-9 || fabs(work) < 1e-12*all ? 0 : work;
}

/* The greatest acceleration of a part that falls, over the size of the model [1/s^2]; 0: without weight. */
static double falling(const lw_dynamics *d)
{
    double most = 0;
    for (int i = 0; i < d->n_v; i++)
        most = fmax(most, d->eq.mass[i] > 0 ? fabs(d->eq.weight[i])/d->eq.mass[i] : 0);
    return most;
}

/* Downhill, the way the forces do work, with masses in the matrix.  The start of each step lies on the constraints. */
static lw_status downhill(search *s, lw_rest *r)
{
    lw_dynamics *d = s->d;
    double unit = falling(d) > 0 ? falling(d) : 1, mass = 100*unit, before = INFINITY, last = INFINITY;
    int good = 0;
    for (int k = 0; k < most_downhill; k++) {
        if (look_at_limits(s) != LW_OK)
            return LW_STOPPED;
        if (lw_mbs_rows(d, s->t, s->q) != LW_OK || find_residual(s, (loads){ 0, 0 }) != LW_OK)
            return LW_E_NUMERIC;
        if (d->eq.accept)                        /* a part that falls may turn far */
            d->eq.accept(d->eq.context, s->q);
        keep(s);
        double size = newton_step(s, mass);
        r->iterations++;
        if (s->factored == LW_E_MEMORY)
            return s->factored;
        if (size < longest) {
            move(s);
            bool free = mass > 0 && mass < 1e-8*unit && size < drifts && size > 0.3*last;       /* only along a motion that nothing resists */
            if ((mass < 1e-6*unit && is_last(s, size, rounded, before)) || free)
                return LW_OK;
            last = size;
            before = mass > 0 ? INFINITY : size;
            if (lw_mbs_project_q(d, s->t, s->q, longest) == LW_OK && work_of_step(s, size) >= 0) {
                good++;                          /* slowly down: with too little mass Newton's step leads to a saddle */
                mass = size < 1e-6 ? 0.1*mass : good > 3 ? 0.5*mass : mass;
                mass = mass < 1e-9*unit ? 0 : mass;
                continue;
            }
        }
        put_back(s);
        good = 0;
        mass = mass > 0 ? 4*mass : 1e-3*unit;
        if (mass > 1e18*unit)
            return LW_OPEN;
    }
    return LW_OPEN;
}

static lw_status prepare(search *s, lw_dynamics *d, double t, double *q)
{
    size_t n = (size_t)d->n_v, c = (size_t)d->n_kept, n_q = (size_t)d->n_q;
    double *p = calloc(5*n + n_q + 4*(n + c), sizeof *p);
    *s = (search){ .d = d, .n_q = d->n_q, .n = d->n_v, .c = d->n_kept, .t = t, .q = q, .load = p };
    if (!p || lw_tangent_make(d, false, false, &s->tangent) != LW_OK)
        return LW_E_MEMORY;
    p += n;
    s->aside = p, p += n, s->walked = p, p += n;
    s->still = p, p += n, s->old_q = p, p += n_q, s->l = p, p += n + c;
    s->old_l = p, p += n + c, s->residual = p, p += n + c, s->step = p;
    lw_status st = lw_tangent_at_rest(d, t, q, s->still, d->a, s->l);
    for (size_t i = 0; i < n; i++)
        s->load[i] = d->eq.mass[i]*d->a[i];
    return st;
}

/* From an equilibrium that is not stable along a mode that grows: the path from the start under an additional load that pushes
 * along the mode, which is taken away at the end; or downhill, `falls`: at once. */
static lw_status leave_saddle(search *s, const lw_mode *mode, bool falls, lw_rest *r)
{
    lw_dynamics *d = s->d;
    double most = 0, *saddle = calloc((size_t)s->n_q + (size_t)s->n + 1, sizeof *saddle), *away = saddle + s->n_q;
    lw_status st = saddle ? LW_OPEN : LW_E_MEMORY;
    if (st == LW_E_MEMORY)
        return st;
    memcpy(saddle, s->q, (size_t)s->n_q*sizeof *saddle);
    for (int i = 0; i < s->n; i++) {
        away[i] = mode->shape[i]*cos(mode->phase[i]);
        s->aside[i] = d->eq.mass[i]*away[i];
        most = fmax(most, fabs(s->aside[i]));
    }
    for (double share = 0.1; st == LW_OPEN && share > 1e-4 && !falls; share *= 0.3) {
        double scale = share*lw_greatest_or_infinite(s->n, s->load)/most, moved = 0;
        for (int i = 0; i < s->n; i++)
            s->aside[i] *= scale;
        most *= scale;
        memcpy(s->q, d->start_q, (size_t)s->n_q*sizeof *s->q);
        if (!(scale > 0) || lw_tangent_at_rest(d, s->t, s->q, s->still, d->a, s->l) != LW_OK)
            break;
        st = load_steps(s, (loads){ 1, 0 }, (loads){ 0, 1 }, r);
        if (st == LW_OK && (st = load_steps(s, (loads){ 0, 1 }, (loads){ 0, 0 }, r)) == LW_OPEN) {
            s->soft = 1e-2*mode->re*mode->re;    /* the push may be all that kept it from turning, as a round column about its axis */
            st = balance(s, (loads){ 0, 0 }, &r->iterations);
            s->soft = 0;
        }
        for (int i = 0; st == LW_OK && i < s->n_q; i++)
            moved = fmax(moved, fabs(s->q[i] - saddle[i]));
        st = st == LW_OK && moved < 1e-6 ? LW_OPEN : st;
    }
    bool moves = false;                          /* a long chain follows short pushes only */
    for (double push = 0.01; st == LW_OPEN && !moves && push > 1e-7; push *= 0.1) {
        memcpy(s->q, saddle, (size_t)s->n_q*sizeof *saddle);
        for (int i = 0; i < s->n; i++)
            s->step[i] = push*away[i];
        d->eq.move(d->eq.context, s->q, s->step);
        moves = lw_mbs_project_q(d, s->t, s->q, 1) == LW_OK;
        st = moves ? downhill(s, r) : LW_OPEN;
    }
    free(saddle);
    return st;
}

lw_status lw_statics_rest_large(lw_dynamics *d, double t, double *q, lw_rest *r, lw_error *e)
{
    search s;
    lw_modes modes = { 0 };
    lw_error ignored = { 0 };
    bool falls = false;                                       /* the path of the loads has led to a saddle, or to nothing */
    double still = slowest*sqrt(falling(d));                 /* slower modes are still */
    memcpy(q, d->start_q, (size_t)d->n_q*sizeof *q);
    lw_status st = prepare(&s, d, t, q);
    if (st == LW_OK && (st = load_steps(&s, (loads){ 1, 0 }, (loads){ 0, 0 }, r)) != LW_OK && st != LW_E_MEMORY) {
        put_back(&s);
        falls = true;
        st = downhill(&s, r);
    }
    for (int k = 0; st == LW_OK; k++) {                       /* off an equilibrium that is not stable */
        r->residual = lw_greatest_or_infinite(s.n, s.residual);
        st = lw_modes_about(d, 4, false, NULL, t, q, &modes, &ignored);
        r->stable = st == LW_NOTHING;
        r->unknown = st == LW_E_KIND;
        if (st != LW_OK) {
            st = st == LW_NOTHING || st == LW_E_KIND ? LW_OK : st;
            break;
        }
        int worst = -1;
        for (int i = 0; i < modes.n_mode; i++)
            if (modes.mode[i].re > fmax(1e-6*(modes.mode[i].natural + 1e-300), still) && modes.conservative)
                worst = worst < 0 || modes.mode[i].re > modes.mode[worst].re ? i : worst;
        r->neutral = worst < 0 && modes.n_mode > 0 && 2*LW_PI*modes.mode[0].natural <= still;
        r->stable = worst < 0 && !r->neutral;
        if (worst < 0 || k == 3)
            break;
        st = leave_saddle(&s, &modes.mode[worst], falls, r);
        falls = true;
        lw_modes_free(&modes);
    }
    lw_modes_free(&modes);
    lw_tangent_free(&s.tangent);
    free(s.load);
    if (st == LW_E_MEMORY)
        return lw_error_set(e, st, "out of memory");
    if (st == LW_STOPPED)
        return lw_limits_check(d->o.stop, d->o.until, true, t, e);
    return st == LW_OK ? LW_OK : lw_error_set(e, LW_NOTHING, "no static equilibrium was found near the posture: the forces drive "
                                              "it away, or an elastic link buckles");
}

lw_status lw_modes_find_large(lw_dynamics *d, const lw_modes_options *o, int wanted, double t, double *q, lw_modes *modes, lw_error *e)
{
    lw_rest rest = { 0 };
    lw_status s = o->rest ? lw_statics_rest_large(d, t, q, &rest, e) : LW_OK;
    memset(modes, 0, sizeof *modes);
    return s == LW_OK ? lw_modes_about(d, wanted, true, o->kept, t, q, modes, e) : s == LW_NOTHING ? LW_E_NUMERIC : s;
}

/* ---- quasi-static runs ------------------------------------------------------------------------------------------ */

/* From the equilibrium in s->q to the one at time t. */
static lw_status follow(search *s, double t, lw_rest *r)
{
    lw_dynamics *d = s->d;
    s->t = t;
    if (lw_tangent_at_rest(d, t, s->q, s->still, d->a, s->l) != LW_OK)
        return LW_OPEN;
    for (int i = 0; i < s->n; i++)
        s->load[i] = d->eq.mass[i]*d->a[i];
    return load_steps(s, (loads){ 1, 0 }, (loads){ 0, 0 }, r);
}

/* Velocities at the equilibrium that the motions of the inputs cause. */
static lw_status find_velocities(search *s, double *v)
{
    lw_dynamics *d = s->d;
    const double none[2] = { 0, 0 };
    lw_status st = lw_mbs_rows(d, s->t, s->q);
    if (st == LW_OK && (st = lw_mbs_rate_wanted(d, s->t)) == LW_OK)
        st = lw_tangent_factor(&s->tangent, s->t, s->q, s->still, s->l, none, none);
    memset(s->step, 0, (size_t)s->n*sizeof *s->step);
    for (int k = 0; k < s->c; k++)
        s->step[s->n + k] = d->rhs[d->kept[k]];
    if (st == LW_OK)
        lw_tangent_solve(&s->tangent, s->step);
    memcpy(v, s->step, (size_t)s->n*sizeof *v);
    return st;
}

lw_status lw_statics_run_large(lw_run *run)
{
    lw_dynamics *d = run->d;
    search s = { 0 };
    lw_rest rest = { 0 };
    double *y = calloc((size_t)run->n + 2*(size_t)d->n_q, sizeof *y), *safe = y + run->n;
    if (!y)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    memcpy(y, d->start_q, (size_t)d->n_q*sizeof *y);
    lw_status st = prepare(&s, d, d->o.from, y) == LW_E_MEMORY ? lw_error_set(run->e, LW_E_MEMORY, "out of memory") : LW_OK;
    double now = d->o.from;
    for (int k = 0; st == LW_OK && k <= d->o.intervals; k++) {
        double to = lw_run_time(d, k), step = to - now;
        do {                                     /* the whole interval, or parts of it */
            double next = to - now <= step*(1 + 1e-9) ? to : now + step;
            memcpy(safe, y, (size_t)d->n_q*sizeof *y);
            lw_status near = follow(&s, next, &rest);
            if (near == LW_OK)
                now = next;
            else if (near == LW_E_MEMORY)
                st = lw_error_set(run->e, near, "out of memory");
            else {
                memcpy(y, safe, (size_t)d->n_q*sizeof *y);
                step *= 0.5;
                if (!(step > 1e-4*(to - now)))
                    st = lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s no equilibrium was found near the one before: the forces "
                                      "drive the links away, or one of them buckles", next);
            }
            if (st == LW_OK)
                st = lw_run_limits(run, now, 0);
        } while (st == LW_OK && now < to);
        if (st == LW_OK && (st = find_velocities(&s, y + d->n_q)) != LW_OK)
            st = st == LW_E_MEMORY ? lw_error_set(run->e, st, "out of memory")
               : lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the equilibrium is neutral: its stiffness is singular", now);
        if (st != LW_OK)
            break;
        memset(d->a, 0, (size_t)d->n_v*sizeof *d->a);
        memset(d->l, 0, (size_t)d->n_c*sizeof *d->l);
        for (int c = 0; c < s.c; c++)
            d->l[d->kept[c]] = s.l[c];
        run->r->t = now;
        st = lw_run_show_solved(run, now, y);
    }
    run->r->steps = run->r->rates = rest.iterations;
    lw_tangent_free(&s.tangent);
    free(s.load);
    free(y);
    return st;
}
