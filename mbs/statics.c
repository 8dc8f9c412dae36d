/* mbs/statics.c - equilibrium by Newton's method in the null space of the constraints, with a fallback downhill.
 *
 * With N an orthonormal basis of the null space of J, forces g = N^T Q(q, 0) vanish at rest.  The matrix is
 * K = -N^T (dQ/dq - d(J^T l)/dq) N, its second part by differences of J^T l along the columns of N. */
#include "mbs/statics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "mbs/dynamics_run_internal.h"

static const int    most = 400;
static const double small = 1e-13;           /* of the greatest force                                     */
static const double longest = 0.2;           /* step, scaled                                              */

typedef struct rest {
    lw_dynamics *d;
    double t, *q, *force, *l, *free, *k, *trial, *side, *dq, *dv, scale;
} rest;

static const double still[LW_SYSTEM_Q_MAX];

/* Forces at q along N (free), with multipliers; N in d->null.  Factored. */
static lw_status balance(rest *r, const double *q)
{
    lw_dynamics *d = r->d;
    lw_status s = lw_mbs_rows(d, r->t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, true);
    if (s != LW_OK)
        return s;
    lw_forces_apply(&d->f, r->t, q, still, r->force, r->dq, r->dv, NULL);
    if (d->o.extra.apply)
        d->o.extra.apply(d->o.extra.context, r->t, q, still, r->force, NULL, NULL, &(double){ 0 });
    r->scale = 0;
    for (int i = 0; i < d->n_q; i++)
        r->scale = fmax(r->scale, fabs(r->force[i]));
    for (int k = 0; k < d->freedom; k++) {
        lw_rank_left_null(&d->rank_of, k, d->null + k*d->n_q);
        r->free[k] = 0;
        for (int i = 0; i < d->n_q; i++)
            r->free[k] += d->null[k*d->n_q + i]*r->force[i];
    }
    memcpy(d->bias, r->force, (size_t)d->n_q*sizeof *d->bias);
    lw_rank_solve(&d->rank_of, d->bias, r->l);
    return LW_OK;
}

static double size_of(const double *x, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum = fmax(sum, fabs(x[i]));
    return sum;
}

/* (J(q + h n)^T - J(q - h n)^T) l / 2h into out. */
static void turn_of_rows(rest *r, const double *n, double *out)
{
    lw_dynamics *d = r->d;
    const double h = 1e-5;
    memset(out, 0, (size_t)d->n_q*sizeof *out);
    for (int side = -1; side <= 1; side += 2) {
        for (int i = 0; i < d->n_q; i++)
            r->side[i] = r->q[i] + side*h*n[i];
        lw_mbs_rows(d, r->t, r->side);
        for (int c = 0; c < d->n_c; c++)
            for (int i = 0; i < d->n_q; i++)
                out[i] += side*r->l[c]*d->jac[c*d->n_q + i]/(2*h);
    }
}

/* K x = free by Cholesky; false when K is not positive. */
static bool newton_step(rest *r, double *x)
{
    lw_dynamics *d = r->d;
    int n = d->freedom, q = d->n_q;
    for (int j = 0; j < n; j++) {
        const double *nj = d->null + j*q;
        turn_of_rows(r, nj, r->trial);
        for (int i = 0; i < q; i++)
            for (int c = 0; c < q; c++)
                r->trial[i] -= r->dq[i*q + c]*nj[c];
        for (int i = 0; i < n; i++) {
            r->k[i*n + j] = 0;
            for (int c = 0; c < q; c++)
                r->k[i*n + j] += d->null[i*q + c]*r->trial[c];
        }
    }
    memcpy(x, r->free, (size_t)n*sizeof *x);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = 0.5*(r->k[i*n + j] + (i == j ? r->k[i*n + j] : r->k[j*n + i]));
            for (int c = 0; c < j; c++)
                sum -= r->k[i*n + c]*r->k[j*n + c];
            if (j < i)
                r->k[i*n + j] = sum/r->k[j*n + j];
            else if (sum > 1e-12*r->scale)
                r->k[i*n + i] = sqrt(sum);
            else
                return false;
        }
        for (int c = 0; c < i; c++)
            x[i] -= r->k[i*n + c]*x[c];
        x[i] /= r->k[i*n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int c = i + 1; c < n; c++)
            x[i] -= r->k[c*n + i]*x[c];
        x[i] /= r->k[i*n + i];
    }
    return true;
}

/* What must fall: the energy, or the forces where they have none. */
static double merit(const rest *r, const double *q)
{
    if (r->d->f.conservative && !r->d->o.extra.apply)
        return lw_forces_potential(&r->d->f, q);
    return size_of(r->free, r->d->freedom);
}

static lw_status search(rest *r, lw_rest *out)
{
    lw_dynamics *d = r->d;
    double x[LW_SYSTEM_Q_MAX], way[LW_SYSTEM_Q_MAX], next[LW_SYSTEM_Q_MAX], stretch = longest;
    lw_status s = balance(r, r->q);
    for (out->iterations = 0; s == LW_OK && out->iterations < most; out->iterations++) {
        double before = merit(r, r->q), reach = size_of(r->free, d->freedom);
        out->residual = reach;
        bool newton = newton_step(r, x);
        out->stable = newton;
        if (reach <= small*fmax(r->scale, 1e-300) && newton)
            return LW_OK;
        for (int k = 0; !newton && k < d->freedom; k++)
            x[k] = reach > 1e-9*r->scale ? r->free[k]/reach*stretch : 1e-3*(1 + 0.3*k);
        memset(way, 0, sizeof way);
        for (int k = 0; k < d->freedom; k++)
            for (int i = 0; i < d->n_q; i++)
                way[i] += x[k]*d->null[k*d->n_q + i];
        double shrink = fmin(1, longest/fmax(size_of(way, d->n_q), 1e-300));
        bool better = false;
        for (int tries = 0; s >= 0 && !better && tries < 50; tries++, shrink *= 0.5) {
            for (int i = 0; i < d->n_q; i++)
                next[i] = r->q[i] + shrink*way[i];
            s = lw_mbs_project_q(d, r->t, next, 1);
            if (s == LW_OK)
                s = balance(r, next);
            better = s == LW_OK && (merit(r, next) < before || (newton && size_of(r->free, d->freedom) < reach));
        }
        stretch = newton ? longest : fmin(longest, 2*shrink*stretch);
        if (s < 0)
            return s;
        if (!better) {                            /* rounding ends the descent */
            s = balance(r, r->q);
            return s == LW_OK && out->residual <= 1e-9*r->scale && out->stable ? LW_OK : LW_NOTHING;
        }
        memcpy(r->q, next, (size_t)d->n_q*sizeof *next);
    }
    return s == LW_OK ? LW_NOTHING : s;
}

lw_status lw_statics_rest(lw_dynamics *d, double t, double *q, lw_rest *out, lw_error *e)
{
    size_t n = (size_t)d->n_q, c = (size_t)d->n_c;
    double *room = calloc(5*n + c + 3*n*n, sizeof *room);
    lw_error own = { 0 };
    if (!room)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    rest r = { .d = d, .t = t, .q = q };
    r.force = room;
    r.free = r.force + n;
    r.trial = r.free + n;
    r.side = r.trial + n;
    r.l = r.side + n;
    r.k = r.l + c;
    r.dq = r.k + n*n;
    r.dv = r.dq + n*n;
    *out = (lw_rest){ 0 };
    d->e = e ? e : &own;
    memcpy(q, d->start_q, n*sizeof *q);
    lw_status s = search(&r, out);
    free(room);
    if (s == LW_NOTHING)
        return lw_error_set(e, s, "no posture of rest was found in %d steps; what is left of the forces is %.3g J", most,
                            out->residual);
    return s == LW_OPEN ? lw_error_set(e, s, "the linkage does not close on the way to its rest") : s;
}

lw_status lw_statics_moment(lw_dynamics *d, double t, const double *q, lw_moment_sink *sink, void *context, lw_error *e)
{
    lw_error own = { 0 };
    d->e = e ? e : &own;
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, true);
    if (s != LW_OK)
        return lw_error_set(e, LW_E_NUMERIC, "the posture of rest is singular: its reactions do not exist");
    lw_moment m = { .t = t, .q = q, .v = still, .a = still, .l = d->l, .potential = lw_forces_potential(&d->f, q),
                    .unique = d->rank == d->n_c };
    for (int r = 0; r < d->n_c; r++)
        m.off = fmax(m.off, fabs(d->phi[r]));
    lw_forces_apply(&d->f, t, q, still, d->force, NULL, NULL, NULL);
    lw_rank_solve(&d->rank_of, d->force, d->l);
    return sink(context, &m);
}
