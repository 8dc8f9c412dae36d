/* mbs/equilibrium/vibration.c - masses, damping and stiffness on the motions that the constraints allow. */
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/vector.h"
#include "mbs/equilibrium/vibration_internal.h"

#define LEAST_RANK 1e-10             /* rows nearer than this to those before depend on them */

/* ---- memory -------------------------------------------------------------------------------------- */

static double *take(double **p, size_t n)
{
    double *at = *p;
    *p += n;
    return at;
}

lw_status lw_vibration_make(const lw_forces *f, bool hold_inputs, double t, const double *q, lw_vibration *v)
{
    const lw_system *s = f->system;
    *v = (lw_vibration){ .f = f, .n_q = s->n_q };
    for (int i = 0; i < s->n_input; i++) {
        const lw_expression *x = f->model->motion[i];
        if (!x && !hold_inputs)
            continue;
        bool pin = lw_joint_turns(s->joint[s->input_joint[i]].kind);
        double here = lw_system_measure(s, s->input_joint[i], q, NULL), value = here;
        if (x && !hold_inputs) {
            double at[3];
            lw_input_motion(f->model, s, i, t, at);
            value = pin ? at[0] + 2.0*LW_PI*round((here - at[0])/(2.0*LW_PI)) : at[0];
        }
        v->held[v->n_held] = s->input_joint[i];
        v->held_value[v->n_held++] = value;
    }
    v->n_row = s->n_row + v->n_held;
    size_t n = (size_t)v->n_q, rows = (size_t)v->n_row, all = n + rows;
    size_t doubles = rows + rows*n + n*n + n + 2*n*n + rows + 3*n*n + n
                   + lw_rank_doubles((int)rows + 1, (int)n) + lw_rank_doubles((int)all, (int)all);
    v->memory = calloc(doubles, sizeof *v->memory);
    v->ints = calloc(n + all + 2, sizeof *v->ints);
    if (!v->memory || !v->ints) {
        lw_vibration_free(v);
        return LW_E_MEMORY;
    }
    double *p = v->memory;
    v->phi = take(&p, rows), v->jac = take(&p, rows*n), v->null = take(&p, n*n), v->force = take(&p, n);
    v->dq = take(&p, n*n), v->dv = take(&p, n*n), v->l = take(&p, rows);
    v->mass = take(&p, n*n), v->damping = take(&p, n*n), v->stiffness = take(&p, n*n), v->load = take(&p, n);
    lw_rank_place(&v->rank, v->n_row, v->n_q, take(&p, lw_rank_doubles((int)rows + 1, (int)n)), v->ints);
    lw_rank_place(&v->kkt, (int)all, (int)all, p, v->ints + n);
    return LW_OK;
}

void lw_vibration_free(lw_vibration *v)
{
    free(v->memory);
    free(v->ints);
    v->memory = NULL;
    v->ints = NULL;
}

/* ---- rows ---------------------------------------------------------------------------------------- */

/* Fill v->phi and v->jac at q. */
static void fill_rows(lw_vibration *v, const double *q)
{
    const lw_system *s = v->f->system;
    double row[LW_SYSTEM_Q_MAX], *by_rows = v->kkt.a;            /* scratch that is free here */
    lw_system_rows(s, q, v->phi, by_rows);
    for (int r = 0; r < s->n_row; r++)
        for (int i = 0; i < v->n_q; i++)
            v->jac[r + v->n_row*i] = by_rows[r*v->n_q + i];
    for (int h = 0; h < v->n_held; h++) {
        v->phi[s->n_row + h] = lw_system_measure(s, v->held[h], q, row) - v->held_value[h];
        for (int i = 0; i < v->n_q; i++)
            v->jac[s->n_row + h + v->n_row*i] = row[i];
    }
}

static void factor_rows(lw_vibration *v)
{
    memcpy(v->rank.a, v->jac, sizeof(double)*(size_t)(v->n_row*v->n_q));
    if (v->n_row > 0)
        lw_rank_factor(&v->rank, LEAST_RANK);
    v->n_free = v->n_q - (v->n_row > 0 ? v->rank.rank : 0);
    v->redundant = v->n_row - (v->n_row > 0 ? v->rank.rank : 0);
}

lw_status lw_vibration_project(lw_vibration *v, double *q)
{
    double x[LW_SYSTEM_Q_MAX], before = INFINITY;
    for (int round = 0; v->n_row > 0; round++) {
        double off = 0.0;
        fill_rows(v, q);
        for (int r = 0; r < v->n_row; r++)
            off = fmax(off, fabs(v->phi[r]));
        if (off <= 1e-15 || (off < 1e-11 && off > 0.25*before))
            return LW_OK;
        if (!(off < 1e3) || round == 60)
            return LW_OPEN;
        before = off;
        factor_rows(v);
        lw_rank_solve(&v->rank, v->phi, x);
        for (int i = 0; i < v->n_q; i++)
            q[i] -= x[i];
    }
    return LW_OK;
}

/* Orthonormal basis of the motions that the rows allow: unit vectors minus their part in the row space, longest
 * first. */
static void find_null(lw_vibration *v)
{
    int n = v->n_q;
    bool used[LW_SYSTEM_Q_MAX] = { false };
    for (int k = 0; k < v->n_free; k++) {
        double best[LW_SYSTEM_Q_MAX] = { 0.0 }, longest = -1.0;
        int which = 0;
        for (int i = 0; i < n; i++) {
            double x[LW_SYSTEM_Q_MAX] = { 0.0 }, size = 0.0;
            if (used[i])
                continue;
            x[i] = 1.0;
            if (v->n_row > 0)
                lw_rank_null_part(&v->rank, x);
            for (int twice = 0; twice < 2; twice++)
                for (int j = 0; j < k; j++) {
                    double dot = 0.0;
                    for (int c = 0; c < n; c++)
                        dot += v->null[j*n + c]*x[c];
                    for (int c = 0; c < n; c++)
                        x[c] -= dot*v->null[j*n + c];
                }
            for (int c = 0; c < n; c++)
                size += x[c]*x[c];
            if (size > longest) {
                longest = size;
                which = i;
                memcpy(best, x, sizeof best);
            }
        }
        used[which] = true;
        for (int c = 0; c < n; c++)
            v->null[k*n + c] = best[c]/sqrt(longest);
    }
}

/* ---- forces -------------------------------------------------------------------------------------- */

/* Multipliers of least norm at rest: M a + J^T l = Q, J a = 0. */
static void find_multipliers(lw_vibration *v)
{
    int n = v->n_q, all = n + v->n_row;
    double most = 0.0, b[LW_SYSTEM_Q_MAX + LW_SYSTEM_ROW_MAX + LW_INPUT_MAX] = { 0.0 }, x[sizeof b/sizeof *b];
    for (int i = 0; i < n; i++)
        most = fmax(most, v->f->mass[i]);
    most = most > 0.0 ? most : 1.0;
    memset(v->kkt.a, 0, sizeof(double)*(size_t)(all*all));
    for (int i = 0; i < n; i++) {
        v->kkt.a[i + all*i] = v->f->mass[i];
        b[i] = v->force[i];
        for (int r = 0; r < v->n_row; r++)
            v->kkt.a[i + all*(n + r)] = v->kkt.a[n + r + all*i] = most*v->jac[r + v->n_row*i];
    }
    lw_rank_factor(&v->kkt, 1e-13);
    lw_rank_solve(&v->kkt, b, x);
    for (int r = 0; r < v->n_row; r++)
        v->l[r] = most*x[n + r];
}

/* Sum over rows of l times half the second derivative along direction d, from the second coefficient of their
 * series. */
static double bend(const lw_vibration *v, const double *q, const double *d)
{
    const lw_system *s = v->f->system;
    double series[3*LW_SYSTEM_Q_MAX] = { 0.0 }, phi[3*LW_SYSTEM_ROW_MAX], h[3], sum = 0.0;
    size_t n = (size_t)v->n_q;
    memcpy(series, q, sizeof *q*n);
    memcpy(series + n, d, sizeof *d*n);
    lw_system_series(s, 2, series, phi);
    for (int r = 0; r < s->n_row; r++)
        sum += v->l[r]*phi[2*s->n_row + r];
    for (int i = 0; i < v->n_held; i++) {
        lw_system_measure_series(s, v->held[i], 2, series, h);
        sum += v->l[s->n_row + i]*h[2];
    }
    return sum;
}

/* d^T A e for A (n*n) by rows. */
static double between(int n, const double *d, const double *a, const double *e)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        for (int j = 0; d[i] != 0.0 && j < n; j++)
            sum += d[i]*a[i*n + j]*e[j];
    return sum;
}

static void reduce(lw_vibration *v, const double *q)
{
    int n = v->n_q, m = v->n_free;
    double own[LW_SYSTEM_Q_MAX], both[LW_SYSTEM_Q_MAX];
    for (int k = 0; k < m; k++)
        own[k] = bend(v, q, v->null + k*n);
    for (int k = 0; k < m; k++) {
        const double *z = v->null + k*n;
        v->load[k] = 0.0;
        for (int i = 0; i < n; i++)
            v->load[k] += z[i]*v->force[i];
        for (int j = 0; j < m; j++) {
            const double *y = v->null + j*n;
            double mass = 0.0;
            for (int i = 0; i < n; i++)
                mass += z[i]*v->f->mass[i]*y[i];
            for (int i = 0; i < n; i++)
                both[i] = z[i] + y[i];
            /* own_k is d^T H d/2, so the value for the sum of both directions contains z^T H y besides */
            double geometric = j == k ? 2.0*own[k] : bend(v, q, both) - own[k] - own[j];
            v->mass[k*m + j] = mass;
            v->damping[k*m + j] = -between(n, z, v->dv, y);
            v->stiffness[k*m + j] = geometric - between(n, z, v->dq, y);
        }
    }
}

lw_status lw_vibration_linearise(lw_vibration *v, double t, const double *q)
{
    double still[LW_SYSTEM_Q_MAX] = { 0.0 };
    fill_rows(v, q);
    factor_rows(v);
    find_null(v);
    lw_forces_apply(v->f, t, q, still, v->force, v->dq, v->dv, NULL);
    for (int i = 0; i < v->n_q; i++)
        if (!isfinite(v->force[i]))
            return LW_E_NUMERIC;
    find_multipliers(v);
    reduce(v, q);
    return LW_OK;
}

/* ---- equilibrium --------------------------------------------------------------------------------- */

/* By Newton's method on the reduced equations. Where the stiffness is not positive definite, a multiple of the masses is
 * added until it is, which leads downhill and away from saddles. */
#define SLIGHT 1e-9                      /* the first shift, in stiffnesses over masses */
#define NEUTRAL 1e-13                    /* a stiffness that becomes positive definite by so small a one, as rounding makes it, does not drive away */

#define CONVERGED 1e-11                  /* two steps below this in a row: rounding stops Newton's method */

/* Solve (K + shift W) x = load by Cholesky's method, with W the masses and a small multiple of I.  false: not
 * positive definite. */
static bool solve_shifted(const lw_vibration *v, double shift, double little, double *x)
{
    int n = v->n_free;
    double a[LW_SYSTEM_Q_MAX*4], *m = n*n <= (int)(sizeof a/sizeof *a) ? a : v->kkt.a;
    for (int i = 0; i < n; i++) {
        x[i] = v->load[i];
        for (int j = 0; j <= i; j++) {
            double sum = 0.5*(v->stiffness[i*n + j] + v->stiffness[j*n + i])
                       + shift*(v->mass[i*n + j] + (i == j)*little);
            for (int k = 0; k < j; k++)
                sum -= m[i*n + k]*m[j*n + k];
            if (i == j && !(sum > 1e-14*(fabs(v->stiffness[i*n + i]) + shift*(v->mass[i*n + i] + little))))
                return false;
            m[i*n + j] = i == j ? sqrt(sum) : sum/m[j*n + j];
        }
        for (int k = 0; k < i; k++)
            x[i] -= m[i*n + k]*x[k];
        x[i] /= m[i*n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= m[k*n + i]*x[k];
        x[i] /= m[i*n + i];
    }
    return true;
}

/* Newton's step with the stiffness, shifted until it is positive definite; at most half a radian or half the size of
 * the linkage.  Returns the shift in stiffnesses over masses; below 0: no step was found.  *neutral: a shift of NEUTRAL is enough. */
static double find_step(const lw_vibration *v, double *x, bool *neutral)
{
    double mass = 0.0, stiff = 0.0;
    for (int i = 0; i < v->n_free; i++) {
        mass = fmax(mass, v->mass[i*v->n_free + i]);
        stiff = fmax(stiff, fabs(v->stiffness[i*v->n_free + i]));
    }
    double little = mass > 0.0 ? 1e-3*mass : 1.0, shift = 0.0;
    double unit = (stiff > 0.0 ? stiff : 1.0)/(mass > 0.0 ? mass : 1.0);
    *neutral = false;
    for (int tries = 0; tries < 60; tries++) {
        if (solve_shifted(v, shift, little, x)) {
            if (shift == SLIGHT*unit) {
                *neutral = solve_shifted(v, NEUTRAL*unit, little, x);
                solve_shifted(v, shift, little, x);
            }
            double size = lw_norm(v->n_free, x);
            for (int i = 0; size > 0.5 && i < v->n_free; i++)
                x[i] *= 0.5/size;
            return isfinite(size) ? shift/unit : -1.0;
        }
        shift = shift > 0.0 ? fmin(8.0*shift, fmax(1e-3*unit, 2.0*shift)) : SLIGHT*unit;
    }
    return -1.0;
}

/* Step along x from q.  Halve the step while the force at its end pushes back with more than half the force at its
 * start. */
static lw_status search(lw_vibration *v, double t, double *q, const double *x)
{
    int n = v->n_q, m = v->n_free;
    double from[LW_SYSTEM_Q_MAX], null[LW_SYSTEM_Q_MAX], slope = 0.0;
    memcpy(from, q, sizeof *q*(size_t)n);
    memset(null, 0, sizeof null);
    for (int k = 0; k < m; k++)
        for (int i = 0; i < n; i++)
            null[i] += x[k]*v->null[k*n + i];
    for (int k = 0; k < m; k++)
        slope += v->load[k]*x[k];
    for (double fraction = 1.0; fraction > 1e-12; fraction *= 0.5) {
        double end = 0.0;
        for (int i = 0; i < n; i++)
            q[i] = from[i] + fraction*null[i];
        lw_status s = lw_vibration_project(v, q);
        if (s == LW_OK)
            s = lw_vibration_linearise(v, t, q);
        if (s != LW_OK)
            continue;
        for (int i = 0; i < n; i++)
            end += null[i]*v->force[i];
        if (end >= -0.5*fabs(slope) || fraction*lw_norm(m, x) < 1e-9)
            return LW_OK;
    }
    return LW_E_NUMERIC;
}

/* Leave a saddle: a small step along every motion, each of another length. */
static lw_status leave_saddle(lw_vibration *v, double t, double *q)
{
    for (int k = 0; k < v->n_free; k++)
        for (int i = 0; i < v->n_q; i++)
            q[i] += 1e-3*(1.0 + 0.3*k)*v->null[k*v->n_q + i];
    lw_status s = lw_vibration_project(v, q);
    return s == LW_OK ? lw_vibration_linearise(v, t, q) : s;
}

lw_status lw_vibration_rest(lw_vibration *v, double t, double *q, lw_rest *r, lw_error *e)
{
    double x[LW_SYSTEM_Q_MAX], last = INFINITY;
    lw_status s = lw_vibration_linearise(v, t, q);
    *r = (lw_rest){ 0 };
    for (int saddles = 0; s == LW_OK && r->iterations < 500; r->iterations++) {
        double shift = v->n_free > 0 ? find_step(v, x, &r->neutral) : 0.0, size = v->n_free > 0 ? lw_norm(v->n_free, x) : 0.0;
        if (shift < 0.0)
            break;
        r->residual = lw_greatest(v->n_free, v->load);
        r->stable = shift == 0.0;
        bool done = size < 1e-14 || r->residual <= 1e-15*lw_greatest(v->n_q, v->force)
                 || (last < CONVERGED && size < CONVERGED);
        if (done && (r->stable || r->neutral || saddles == 5))
            return LW_OK;
        last = done ? INFINITY : size;
        saddles += done;
        s = done ? leave_saddle(v, t, q) : search(v, t, q, x);
    }
    return lw_error_set(e, LW_NOTHING, "no static equilibrium was found near the posture: the forces drive it away "
                        "(force left %.3g J)", r->residual);
}
