/* mbs/constraints/mobility_drift.c - walk on the set of postures without knowing its dimension.  Gauss-Newton steps
 * of least norm (Ben-Israel 1966) find a posture near a guess for any rank. */
#include <stdlib.h>
#include <string.h>
#include "base/vector.h"
#include "base/real.h"
#include "mbs/constraints/mobility_internal.h"

#define SETTLE_MAX   150       /* a motion of order p that falls back loses 1/p of its length a step */
#define PATIENCE     15        /* steps without improvement */
#define STEP_FIRST   0.1       /* relative to the size, or in radians */
#define STEP_LEAST   1e-3
#define WALK_STEPS   10
#define WALK_LEAST   0.05      /* a shorter walk may be a shaky motion of high order */
#define PROBE        0.02      /* length of trial motions at a posture */

lw_status lw_drift_create(const lw_system *s, double tolerance, lw_drift *d)
{
    size_t n = (size_t)s->n_q, m = (size_t)s->n_row + 1;
    int tall = s->n_row + s->n_q + LW_DRIFT_EXTRA;
    *d = (lw_drift){ .s = s, .tolerance = tolerance };
    d->columns = calloc(lw_rank_ints(tall, s->n_q), sizeof *d->columns);
    d->block = calloc(2*m + m*n + 2*n + n*n + lw_rank_doubles(tall, s->n_q), sizeof *d->block);
    if (!d->columns || !d->block) {
        lw_drift_free(d);
        return LW_E_MEMORY;
    }
    d->phi = d->block;
    d->goal = d->phi + m;
    d->jac = d->goal + m;
    d->step = d->jac + m*n;
    d->start = d->step + n;
    d->null = d->start + n;
    d->factors = d->null + n*n;
    return LW_OK;
}

void lw_drift_free(lw_drift *d)
{
    free(d->columns);
    free(d->block);
}

int lw_drift_factor(lw_drift *d, int m, int n, const double *a, double zero)
{
    lw_rank_place(&d->rank, m, n, d->factors, d->columns);
    for (int i = 0; i < m; i++)
        for (int k = 0; k < n; k++)
            d->rank.a[i + m*k] = a[i*n + k];
    lw_rank_factor(&d->rank, zero);
    return d->rank.rank;
}

static double distance(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += (a[i] - b[i])*(a[i] - b[i]);
    return sqrt(sum);
}

/* Pivoted Gram-Schmidt: of k vectors v[i*n ..], an orthonormal basis comes first; components shorter than `zero` are
 * dropped.  Returns the number of basis vectors. */
static int independent_vectors(int n, int k, double *v, double zero)
{
    for (int i = 0; i < k; i++) {
        int best = i;
        for (int j = i + 1; j < k; j++)
            if (lw_dot(n, v + j*n, v + j*n) > lw_dot(n, v + best*n, v + best*n))
                best = j;
        double length = sqrt(lw_dot(n, v + best*n, v + best*n));
        if (length < zero)
            return i;
        for (int l = 0; l < n; l++) {
            double swap = v[best*n + l];
            v[best*n + l] = v[i*n + l];
            v[i*n + l] = swap/length;
        }
        for (int j = i + 1; j < k; j++) {
            double share = lw_dot(n, v + i*n, v + j*n);
            for (int l = 0; l < n; l++)
                v[j*n + l] -= share*v[i*n + l];
        }
    }
    return k;
}

/* The null-space components of unit vectors along the columns without pivot span the null space. */
void lw_drift_null(const lw_drift *d, double *null)
{
    int n = d->rank.n, loose = n - d->rank.rank;
    memset(null, 0, (size_t)n*(size_t)loose*sizeof *null);
    for (int i = 0; i < loose; i++) {
        null[i*n + d->rank.column[d->rank.rank + i]] = 1;
        lw_rank_null_part(&d->rank, null + i*n);
    }
    independent_vectors(n, loose, null, 0);
}

int lw_drift_rank(lw_drift *d, const double *q, double zero)
{
    lw_system_rows(d->s, q, d->phi, d->jac);
    int rank = lw_drift_factor(d, d->s->n_row, d->s->n_q, d->jac, zero);
    lw_drift_null(d, d->null);
    return rank;
}

/* Rows that are dependent along a motion are slightly independent beside it, in proportion to the error of q.  Do not
 * divide by such a small pivot once only rounding errors are left. */
static double solve_zero(const lw_drift *d) { return fmax(1e-10, 10*d->tolerance); }

double lw_drift_settle(lw_drift *d, const double *from, const double *along, double length, double *q)
{
    int n = d->s->n_q, m = d->s->n_row;
    double last = INFINITY, best = INFINITY;
    for (int i = 0, best_at = 0; i < SETTLE_MAX; i++) {
        lw_system_rows(d->s, q, d->phi, d->jac);
        double worst = 0;
        for (int r = 0; r < m; r++) {
            worst = fmax(worst, fabs(d->phi[r]));
            d->goal[r] = -d->phi[r];
        }
        if (!(worst < 10) || worst == 0 || (worst > 0.7*last && (along || worst <= d->tolerance)))
            return worst < 10 ? worst : INFINITY;
        last = worst;
        if (worst < best) {
            best = worst;
            best_at = i;
        } else if (i - best_at > PATIENCE) {
            return INFINITY;
        }
        if (along) {
            memcpy(d->jac + (size_t)m*(size_t)n, along, (size_t)n*sizeof *along);
            d->goal[m] = length - (lw_dot(n, along, q) - lw_dot(n, along, from));
        }
        lw_drift_factor(d, m + (along != NULL), n, d->jac, solve_zero(d));
        lw_rank_solve(&d->rank, d->goal, d->step);
        if (!(lw_dot(n, d->step, d->step) < 1))
            return INFINITY;
        for (int k = 0; k < n; k++)
            q[k] += d->step[k];
    }
    return last;
}

/* A step of about h from d->start along d->step; true if it closes away from the start. */
static bool try_step(lw_drift *d, const double *direction, double h, double *q, double *worst)
{
    int n = d->s->n_q;
    for (int k = 0; k < n; k++)
        q[k] = d->start[k] + h*direction[k];
    *worst = lw_drift_settle(d, NULL, NULL, 0, q);
    double way = distance(q, d->start, n);
    return *worst <= d->tolerance && way > 0.1*h && way < 3*h;
}

/* A motion of first order at q: the projection of `old`, slightly randomised. */
static bool choose_direction(lw_drift *d, lw_rng *r, const double *q, const double *old, double *direction)
{
    int n = d->s->n_q, loose = n - lw_drift_rank(d, q, fmax(LW_RANK_ZERO, 10*d->tolerance));
    memset(direction, 0, (size_t)n*sizeof *direction);
    for (int i = 0; i < loose; i++) {
        const double *v = d->null + (size_t)i*(size_t)n;
        double share = (old ? lw_dot(n, old, v) : 0) + (old ? 0.3 : 1)*lw_rng_normal(r);
        for (int k = 0; k < n; k++)
            direction[k] += share*v[k];
    }
    double length = sqrt(lw_dot(n, direction, direction));
    for (int k = 0; k < n; k++)
        direction[k] /= length > 0 ? length : 1;
    return length > 0;
}

double lw_drift_walk(lw_drift *d, lw_rng *r, double *q, double *residual)
{
    int n = d->s->n_q;
    double direction[LW_SYSTEM_Q_MAX], next[LW_SYSTEM_Q_MAX], old[LW_SYSTEM_Q_MAX];
    double way = 0, h = STEP_FIRST;
    for (int i = 0; i < WALK_STEPS || (way < WALK_LEAST && i < 20*WALK_STEPS); i++) {
        double worst = 0;
        memcpy(d->start, q, (size_t)n*sizeof *q);
        if (!choose_direction(d, r, q, i ? old : NULL, direction))
            return 0;
        while (h >= STEP_LEAST && !try_step(d, direction, h, next, &worst))
            h /= 3;
        if (h < STEP_LEAST)
            break;
        double moved = distance(next, q, n);
        for (int k = 0; k < n; k++)
            old[k] = (next[k] - q[k])/moved;
        way += moved;
        memcpy(q, next, (size_t)n*sizeof *q);
        *residual = fmax(*residual, worst);
        h = fmin(2*h, STEP_FIRST);
    }
    return way >= WALK_LEAST ? way : 0;
}

/* Push along every motion of first order and find the component that remains. */
static void probe(lw_drift *d, lw_mobility_posture *t)
{
    int n = d->s->n_q, k = t->first_order;
    double *basis = t->motion + (size_t)n*(size_t)k;       /* its upper half, 2 k columns, is free */
    memcpy(basis, d->null, (size_t)n*(size_t)k*sizeof *basis);
    for (int i = 0; i < k; i++) {
        double q[LW_SYSTEM_Q_MAX], *column = t->motion + i*n, worst, h = 4*PROBE;
        memcpy(d->start, t->q, (size_t)n*sizeof *q);
        do {
            h /= 4;
            for (int l = 0; l < n; l++)
                q[l] = t->q[l] + h*basis[i*n + l];
            worst = lw_drift_settle(d, NULL, NULL, 0, q);
        } while (worst > d->tolerance && h > PROBE/20);
        memset(column, 0, (size_t)n*sizeof *column);
        for (int j = 0; j < k && worst <= d->tolerance; j++) {
            double share = (lw_dot(n, basis + j*n, q) - lw_dot(n, basis + j*n, t->q))/h;
            for (int l = 0; l < n; l++)
                column[l] += share*basis[j*n + l];
        }
    }
    t->freedom = independent_vectors(n, k, t->motion, 0.1);
}

void lw_drift_stand(lw_drift *d, bool moves, lw_mobility_posture *t)
{
    int n = d->s->n_q;
    t->rank = lw_drift_rank(d, t->q, fmax(LW_RANK_ZERO, 10*d->tolerance));
    t->first_order = n - t->rank;
    t->freedom = moves ? t->first_order : 0;
    /* all rows are independent: the implicit function theorem answers */
    if (t->rank < d->s->n_row && t->first_order > 1 && moves)
        probe(d, t);
    else
        memcpy(t->motion, d->null, (size_t)n*(size_t)t->first_order*sizeof *t->motion);
}
