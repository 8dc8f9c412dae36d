/* mbs/branch_cross.c - the other branch at a branch point.
 *
 * At a simple one the equations F lose one rank: two directions t, n span what they leave free, and psi F' = 0 for one
 * psi.  Branches leave along v = a t + b n with psi F''[v, v] = 0 (Keller 1977; Allgower & Georg 1990, section
 * 8.1).  As t is a branch itself, the other is v = -(psi F''[n, n]/(2 psi F''[t, n])) t + n. */
#include "mbs/branch_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/rank.h"
#include "base/rng.h"

static const double step_off = 0.02;       /* along the other branch: far from rounding, near for curvature */
static const double least_rank = 1e-8;     /* what is left of a lost rank, at branch points told to 1e-11   */

/* A vector of the null space of the m x n matrix a (by columns); how many dimensions it has, -1: out of memory. */
static int null_vector(int m, int n, const double *a, const double *without, double *out)
{
    double *memory = malloc(lw_rank_doubles(m, n)*sizeof *memory), length = 0.0, along = 0.0;
    int *ints = malloc(lw_rank_ints(m, n)*sizeof *ints), left = -1;
    if (memory && ints) {
        lw_rank r;
        lw_rng rng;
        lw_rank_place(&r, m, n, memory, ints);
        memcpy(r.a, a, (size_t)m*(size_t)n*sizeof *a);
        lw_rank_factor(&r, least_rank);
        left = n - r.rank;
        lw_rng_seed(&rng, 3, 0);
        for (int i = 0; i < n; i++)
            out[i] = lw_rng_range(&rng, -1.0, 1.0);
        lw_rank_null_part(&r, out);
        for (int i = 0; i < n && without; i++)
            along += out[i]*without[i];
        for (int i = 0; i < n; i++) {
            out[i] -= without ? along*without[i] : 0.0;
            length += out[i]*out[i];
        }
        for (int i = 0; i < n; i++)
            out[i] /= length > 0.0 ? sqrt(length) : 1.0;
    }
    free(memory);
    free(ints);
    return left;
}

/* psi F''[v, v]/2 at q */
static double bent(const lw_branch *b, const double *q, const double *v, const double *psi, double *series,
                   double *phi)
{
    double sum = 0.0, count[3];
    int n = b->n, rows = b->s->n_row;
    memset(series, 0, 3*(size_t)n*sizeof *series);
    memcpy(series, q, (size_t)n*sizeof *q);
    memcpy(series + n, v, (size_t)n*sizeof *v);
    lw_system_series(b->s, 2, series, phi);
    for (int r = 0; r < rows; r++)
        sum += psi[r]*phi[2*rows + r];
    for (int i = 0; i < b->f.n_held; i++) {
        lw_system_measure_series(b->s, b->s->input_joint[b->f.held[i]], 2, series, count);
        sum += psi[rows + i]*count[2];
    }
    return sum;
}

/* Rows and resting inputs without the plane, by columns: m x n, and transposed. */
static void derivatives(lw_branch *b, const double *q, double *a, double *transposed)
{
    int m = b->f.m - 1, n = b->n;
    lw_follow_assemble(&b->f, q);
    for (int i = 0; i < n; i++)
        for (int r = 0; r < m; r++)
            a[r + (long)m*i] = transposed[i + (long)n*r] = b->f.matrix[r + (long)b->f.m*i];
}

/* The direction of the other branch at q, whose own is t, into out. */
static bool other_direction(lw_branch *b, const double *q, const double *t, double *out)
{
    int m = b->f.m - 1, n = b->n;
    size_t rows = (size_t)b->s->n_row;
    double *a = calloc(2*(size_t)m*(size_t)n + (size_t)m + 5*(size_t)n + 3*rows, sizeof *a);
    if (!a)
        return false;
    double *transposed = a + m*n, *psi = transposed + m*n, *sum = psi + m, *series = sum + n, *phi = series + 3*n;
    derivatives(b, q, a, transposed);
    bool simple = null_vector(m, n, a, t, out) == 2 && null_vector(n, m, transposed, NULL, psi) >= 1;
    if (simple) {
        for (int i = 0; i < n; i++)
            sum[i] = t[i] + out[i];
        double nn = bent(b, q, out, psi, series, phi), tt = bent(b, q, t, psi, series, phi);
        double tn = bent(b, q, sum, psi, series, phi) - nn - tt, length = 0.0;
        simple = fabs(tn) > 1e-6;
        for (int i = 0; i < n; i++) {
            out[i] -= nn/tn*t[i];
            length += out[i]*out[i];
        }
        for (int i = 0; i < n; i++)
            out[i] /= sqrt(length);
    }
    free(a);
    return simple;
}

bool lw_branch_other(lw_branch *b, int event, double *q)
{
    double at[LW_SYSTEM_Q_MAX], t[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX];
    if (event < 0 || event >= b->n_event || b->event[event].kind != LW_EVENT_CROSSING)
        return false;
    lw_branch_pose(b, b->event[event].station, at, t);
    if (!other_direction(b, at, t, v))
        return false;
    for (int i = 0; i < b->n; i++) {
        b->f.row[i] = v[i];
        b->f.origin[i] = at[i];
        q[i] = at[i] + step_off*v[i];
    }
    b->f.distance = step_off;
    b->f.kappa = 1.0/step_off;
    return lw_follow_correct(&b->f, q) && lw_follow_distance(&b->f, q, at) < 2.0*step_off;
}
