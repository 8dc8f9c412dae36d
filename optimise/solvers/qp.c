#include "optimise/solvers/qp.h"

#include <assert.h>
#include <string.h>
#include "base/real.h"
#include "base/vector.h"

#define ROUNDING_ROW  1e-13      /* of a . p - b, relative to its terms                                            */
#define ROUNDING_STEP 1e-14      /* of p, relative to its way, in the metric of H                                  */
#define LITTLE        1e-4       /* of a row's square: less outside the active rows is worked out twice            */
#define DEPENDENT     1e-22      /* a row with less of its square outside the active rows depends on them          */

/* These functions work column by column, because the operations of one column do not depend on each other. */
bool lw_qp_cholesky(int n, double *h)
{
    double column[LW_QP_MAX];
    assert(n <= LW_QP_MAX);
    for (int k = 0; k < n; k++) {
        double pivot = h[k*n + k];
        if (!(pivot > 0 && isfinite(pivot)))
            return false;
        h[k*n + k] = sqrt(pivot);
        for (int i = k + 1; i < n; i++)
            column[i] = h[i*n + k] /= h[k*n + k];
        for (int i = k + 1; i < n; i++)
            for (int q = k + 1; q <= i; q++)
                h[i*n + q] -= column[i]*column[q];
    }
    return true;
}

static void forward(int n, const double *l, double *v)          /* v = L^-1 v */
{
    for (int q = 0; q < n; q++) {
        v[q] /= l[q*n + q];
        for (int i = q + 1; i < n; i++)
            v[i] -= l[i*n + q]*v[q];
    }
}

static void backward(int n, const double *l, double *v)         /* v = L^-T v */
{
    for (int q = n - 1; q >= 0; q--) {
        v[q] /= l[q*n + q];
        for (int i = 0; i < q; i++)
            v[i] -= l[q*n + i]*v[q];
    }
}

/* The active conditions: rows L^-1 a as columns of an orthonormal matrix q and a triangle r.  Both are recomputed from the
 * first row that changes on, which is cheap for so few unknowns. */
typedef struct active {
    int    n, count;
    int    row[LW_QP_MAX];
    double u[LW_QP_MAX + 1];                    /* multipliers, >= 0                     */
    double *q, *r;                              /* (n*n); row k of q is the k-th orthonormal vector */
    double size;                                /* largest |L'p| so far                  */
} active;

/* Take from v its parts along the first `count` orthonormal vectors, which become part[k*stride], and return the square of the
 * rest.  Where little is left, rounding has left parts along them: then they are taken once more. */
static double take_out(const active *w, int count, double *v, double *part, int stride)
{
    int n = w->n;
    double whole = lw_dot(n, v, v), rest = whole;
    for (int k = 0; k < count; k++)
        part[k*stride] = 0;
    for (int pass = 0; count > 0 && pass < 2 && (pass == 0 || rest < LITTLE*whole); pass++) {
        for (int k = 0; k < count; k++) {
            double along = lw_dot(n, w->q + k*n, v);
            part[k*stride] += along;
            for (int c = 0; c < n; c++)
                v[c] -= along*w->q[k*n + c];
        }
        rest = lw_dot(n, v, v);
    }
    return rest;
}

static void remake(active *w, int first, const double *l, const double *a)
{
    int n = w->n;
    for (int k = first; k < w->count; k++) {
        double *v = w->q + k*n;
        memcpy(v, a + w->row[k]*n, sizeof(double)*(size_t)n);
        forward(n, l, v);
        w->r[k*n + k] = sqrt(take_out(w, k, v, w->r + k, n));
        for (int c = 0; c < n; c++)
            v[c] /= w->r[k*n + k];
    }
}

/* Split y = L^-1 a_p into its part z outside the active space and the change d of the multipliers; returns the square of z. */
static double split(const active *w, const double *y, double *z, double *d)
{
    int n = w->n;
    memcpy(z, y, sizeof(double)*(size_t)n);
    double z2 = take_out(w, w->count, z, d, 1);
    for (int k = w->count - 1; k >= 0; k--) {
        for (int i = k + 1; i < w->count; i++)
            d[k] -= w->r[k*n + i]*d[i];
        d[k] /= w->r[k*n + k];
    }
    return z2;
}

static void drop(active *w, int k, const double *l, const double *a)
{
    for (int i = k + 1; i < w->count; i++) {
        w->row[i - 1] = w->row[i];
        w->u[i - 1] = w->u[i];
    }
    w->count--;
    remake(w, k, l, a);
}

static double gap_of(int n, int j, const double *a, const double *b, const double *p)
{
    return lw_dot(n, a + j*n, p) - b[j];
}

/* Rounding error to expect in condition j: p is accurate to a few units in the last place only in the metric of H, in
 * which the path to p is at most `size` long. */
static double rounding(const active *w, int j, const double *l, const double *a, const double *b,
                       const double *p)
{
    int n = w->n;
    double y[LW_QP_MAX], scale = fabs(b[j]);
    for (int c = 0; c < n; c++)
        scale += fabs(a[j*n + c]*p[c]);
    memcpy(y, a + j*n, sizeof(double)*(size_t)n);
    forward(n, l, y);
    return ROUNDING_ROW*scale + ROUNDING_STEP*sqrt(lw_dot(n, y, y))*w->size;
}

static bool is_active(const active *w, int j)
{
    for (int k = 0; k < w->count; k++)
        if (w->row[k] == j)
            return true;
    return false;
}

/* gap_of for conditions j to j + 3, in the same order of operations: four sums do not wait for each other as one does. */
static void gaps_of_four(int n, int j, const double *a, const double *b, const double *p, double gap[4])
{
    const double *r = a + j*n, *s = r + n, *t = s + n, *u = t + n;
    double sum[4] = { 0 };
    for (int c = 0; c < n; c++) {
        sum[0] += r[c]*p[c];
        sum[1] += s[c]*p[c];
        sum[2] += t[c]*p[c];
        sum[3] += u[c]*p[c];
    }
    for (int k = 0; k < 4; k++)
        gap[k] = sum[k] - b[j + k];
}

/* The condition that is violated most, by more than rounding, and its gap; -1: there is none. */
static int most_violated(const active *w, int m, const double *l, const double *a, const double *b,
                         const double *p, double *gap)
{
    int n = w->n, last = -1;
    double within = -INFINITY;                  /* rows up to here, and up to `last` at it, are violated within rounding */
    for (int i = 0; i <= m; i++) {
        int worst = -1;
        double least = 0, four[4];
        for (int j = 0; j < m; j++) {
            if (j % 4 == 0 && j + 4 <= m)
                gaps_of_four(n, j, a, b, p, four);
            double s = j < m/4*4 ? four[j % 4] : gap_of(n, j, a, b, p);
            if (s < least && (s > within || (s == within && j > last)) && !is_active(w, j)) {
                least = s;
                worst = j;
            }
        }
        *gap = least;
        if (worst < 0 || least < -rounding(w, worst, l, a, b, p))
            return worst;
        within = least;
        last = worst;
    }
    return -1;
}

static void grow(active *w, const double *l, const double *p)
{
    double y2 = 0;
    for (int i = 0; i < w->n; i++) {
        double y = 0;
        for (int q = i; q < w->n; q++)
            y += l[q*w->n + i]*p[q];
        y2 += y*y;
    }
    w->size = fmax(w->size, sqrt(y2));
}

/* Move p back onto the active conditions, which it left by the rounding of its path. */
static void settle(const active *w, const double *l, const double *a, const double *b, double *p)
{
    int n = w->n;
    double step[LW_QP_MAX] = { 0 }, v[LW_QP_MAX];
    for (int k = 0; k < w->count; k++) {
        v[k] = -gap_of(n, w->row[k], a, b, p);
        for (int i = 0; i < k; i++)
            v[k] -= w->r[i*n + k]*v[i];
        v[k] /= w->r[k*n + k];
        for (int c = 0; c < n; c++)
            step[c] += v[k]*w->q[k*n + c];
    }
    backward(n, l, step);
    for (int c = 0; c < n; c++)
        p[c] += step[c];
}

/* Activate condition j: step in primal and dual space until it holds. */
static bool bring_in(active *w, int j, double gap, const double *l, const double *a, double *p)
{
    int n = w->n;
    double y[LW_QP_MAX], z[LW_QP_MAX], d[LW_QP_MAX], u_new = 0;
    memcpy(y, a + j*n, sizeof(double)*(size_t)n);
    forward(n, l, y);
    double y2 = lw_dot(n, y, y);
    for (int guard = 0; guard < 4*LW_QP_MAX; guard++) {
        double z2 = split(w, y, z, d), t1 = INFINITY, t2 = INFINITY;
        int leave = -1;
        for (int k = 0; k < w->count; k++)
            if (d[k] > 0 && w->u[k]/d[k] < t1) {
                t1 = w->u[k]/d[k];
                leave = k;
            }
        if (z2 > DEPENDENT*y2 && w->count < n)
            t2 = -gap/z2;
        double t = fmin(t1, t2);
        if (!isfinite(t))
            return false;
        for (int k = 0; k < w->count; k++)
            w->u[k] = fmax(0, w->u[k] - t*d[k]);
        u_new += t;
        if (isfinite(t2)) {
            backward(n, l, z);
            for (int c = 0; c < n; c++)
                p[c] += t*z[c];
            gap += t*z2;
            grow(w, l, p);
        }
        if (t2 <= t1) {
            assert(w->count < n);
            w->row[w->count] = j;
            w->u[w->count++] = u_new;
            remake(w, w->count - 1, l, a);
            return true;
        }
        drop(w, leave, l, a);
    }
    return false;
}

bool lw_qp_solve(int n, const double *l, const double *g, int m, const double *a, const double *b, double *work,
                 double *p)
{
    active w;
    assert(n <= LW_QP_MAX);
    w.n = n;
    w.count = 0;
    w.q = work;
    w.r = work + n*n;
    for (int i = 0; i < n; i++)
        p[i] = -g[i];
    forward(n, l, p);
    w.size = sqrt(lw_dot(n, p, p));
    backward(n, l, p);
    for (int round = 0; round < 20*LW_QP_MAX; round++) {
        double gap;
        int j = most_violated(&w, m, l, a, b, p, &gap);
        if (j < 0) {
            settle(&w, l, a, b, p);
            return true;
        }
        if (bring_in(&w, j, gap, l, a, p))
            continue;
        settle(&w, l, a, b, p);                              /* what is left of a row that depends on active ones? */
        if (gap_of(n, j, a, b, p) < -rounding(&w, j, l, a, b, p))
            return false;
    }
    return false;
}
