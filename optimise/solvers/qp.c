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

static void forward(int n, int first, const double *l, double *v)          /* v = L^-1 v; 0 before `first` */
{
    for (int q = first; q < n; q++) {
        const double now = v[q] /= l[q*n + q];
        for (int i = q + 1; i < n; i++)
            v[i] -= l[i*n + q]*now;
    }
}

static void backward(int n, const double *l, double *v)         /* v = L^-T v */
{
    for (int q = n - 1; q >= 0; q--) {
        const double now = v[q] /= l[q*n + q];
        for (int i = 0; i < q; i++)
            v[i] -= l[q*n + i]*now;
    }
}

void lw_qp_list(int n, int m, const double *a, short *first, short *column)
{
    short count = 0;
    for (int j = 0; j < m; j++) {
        first[j] = count;
        for (int c = 0; c < n; c++)
            if (a[j*n + c] != 0)
                column[count++] = (short)c;
    }
    first[m] = count;
}

/* The active conditions: rows L^-1 a as columns of an orthonormal matrix q and a triangle r.  After one of them is dropped, those
 * that follow it are worked out again, which is cheap for so few unknowns. */
typedef struct active {
    int    n, count;
    const double     *l;
    const lw_qp_rows *rows;
    int    row[LW_QP_MAX];
    double u[LW_QP_MAX + 1];                    /* multipliers, >= 0                     */
    double *q, *r;                              /* (n*n); row k of q is the k-th orthonormal vector */
    double size;                                /* largest |L'p| so far                  */
} active;

/* y = L^-1 a of condition j. */
static void condition_vector(const active *w, int j, double *y)
{
    const lw_qp_rows *c = w->rows;
    memcpy(y, c->a + j*w->n, sizeof *y*(size_t)w->n);
    forward(w->n, j < c->n_listed && c->first[j] < c->first[j + 1] ? c->column[c->first[j]] : 0, w->l, y);
}

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

static void remake(active *w, int first)
{
    int n = w->n;
    for (int k = first; k < w->count; k++) {
        double *v = w->q + k*n;
        condition_vector(w, w->row[k], v);
        w->r[k*n + k] = sqrt(take_out(w, k, v, w->r + k, n));
        for (int c = 0; c < n; c++)
            v[c] /= w->r[k*n + k];
    }
}

/* Split y = L^-1 a_p into its parts along the active conditions and its rest z; returns the square of z.  d: the change of the
 * multipliers. */
static double split(const active *w, const double *y, double *z, double *part, double *d)
{
    int n = w->n;
    memcpy(z, y, sizeof(double)*(size_t)n);
    double z2 = take_out(w, w->count, z, part, 1);
    memcpy(d, part, sizeof(double)*(size_t)w->count);
    for (int k = w->count - 1; k >= 0; k--) {
        for (int i = k + 1; i < w->count; i++)
            d[k] -= w->r[k*n + i]*d[i];
        d[k] /= w->r[k*n + k];
    }
    return z2;
}

/* Make condition j, which was split last, active. */
static void join(active *w, int j, double u, const double *part, const double *z, double z2)
{
    int n = w->n, k = w->count++;
    w->row[k] = j;
    w->u[k] = u;
    for (int i = 0; i < k; i++)
        w->r[i*n + k] = part[i];
    w->r[k*n + k] = sqrt(z2);
    for (int c = 0; c < n; c++)
        w->q[k*n + c] = z[c]/w->r[k*n + k];
}

static void drop(active *w, int k)
{
    for (int i = k + 1; i < w->count; i++) {
        w->row[i - 1] = w->row[i];
        w->u[i - 1] = w->u[i];
    }
    w->count--;
    remake(w, k);
}

static inline double listed_gap(const lw_qp_rows *c, int n, int j, const double *p)
{
    const double *a = c->a + j*n;
    double sum = 0;
    for (int i = c->first[j]; i < c->first[j + 1]; i++)
        sum += a[c->column[i]]*p[c->column[i]];
    return sum - c->b[j];
}

static double gap_of(const active *w, int j, const double *p)
{
    const lw_qp_rows *c = w->rows;
    return j < c->n_listed ? listed_gap(c, w->n, j, p) : lw_dot(w->n, c->a + j*w->n, p) - c->b[j];
}

/* Rounding error to expect in condition j, of which y is the vector: p is accurate to a few units in the last place only in the
 * metric of H, in which the path to p is at most `size` long. */
static double rounding(const active *w, int j, const double *y, const double *p)
{
    int n = w->n;
    const double *a = w->rows->a + j*n;
    double scale = fabs(w->rows->b[j]);
    for (int c = 0; c < n; c++)
        scale += fabs(a[c]*p[c]);
    return ROUNDING_ROW*scale + ROUNDING_STEP*sqrt(lw_dot(n, y, y))*w->size;
}

static bool is_active(const active *w, int j)
{
    for (int k = 0; k < w->count; k++)
        if (w->row[k] == j)
            return true;
    return false;
}

/* gap_of for conditions j to j + EIGHT - 1, in the same order of operations: eight sums do not wait for each other as one does. */
enum { EIGHT = 8 };

static void gaps_of_eight(int n, const double *a, const double *b, const double *p, double gap[EIGHT])
{
    double sum[EIGHT] = { 0 };
    for (int c = 0; c < n; c++)
        for (int k = 0; k < EIGHT; k++)
            sum[k] += a[k*n + c]*p[c];
    for (int k = 0; k < EIGHT; k++)
        gap[k] = sum[k] - b[k];
}

/* The least gap of those looked at. */
typedef struct least_gap { double gap, within; int row, last; } least_gap;

static inline void look_at(const active *w, int j, double gap, least_gap *least)
{
    if (gap < least->gap && (gap > least->within || (gap == least->within && j > least->last)) && !is_active(w, j)) {
        least->gap = gap;
        least->row = j;
    }
}

/* The condition that is violated most, by more than rounding, with its gap and its vector y; -1: there is none. */
static int most_violated(const active *w, const double *p, double *gap, double *y)
{
    const lw_qp_rows *rows = w->rows;
    const int n = w->n, m = rows->m, listed = rows->n_listed;
    double within = -INFINITY, eight[EIGHT];    /* rows up to here, and up to `last` at it, are violated within rounding */
    for (int i = 0, last = -1; i <= m; i++) {
        least_gap least = { 0, within, -1, last };
        int j = 0;
        for (; j < listed; j++)
            look_at(w, j, listed_gap(rows, n, j, p), &least);
        for (; j + EIGHT <= m; j += EIGHT) {
            gaps_of_eight(n, rows->a + j*n, rows->b + j, p, eight);
            for (int k = 0; k < EIGHT; k++)
                look_at(w, j + k, eight[k], &least);
        }
        for (; j < m; j++)
            look_at(w, j, gap_of(w, j, p), &least);
        *gap = least.gap;
        if (least.row < 0)
            return -1;
        condition_vector(w, least.row, y);
        if (least.gap < -rounding(w, least.row, y, p))
            return least.row;
        within = least.gap;
        last = least.row;
    }
    return -1;
}

static void grow(active *w, const double *p)
{
    double y[LW_QP_MAX] = { 0 };
    for (int q = 0; q < w->n; q++)
        for (int i = 0; i <= q; i++)
            y[i] += w->l[q*w->n + i]*p[q];
    w->size = fmax(w->size, lw_norm(w->n, y));
}

/* Move p back onto the active conditions, which it left by the rounding of its path. */
static void settle(const active *w, double *p)
{
    int n = w->n;
    double step[LW_QP_MAX] = { 0 }, v[LW_QP_MAX];
    for (int k = 0; k < w->count; k++) {
        v[k] = -gap_of(w, w->row[k], p);
        for (int i = 0; i < k; i++)
            v[k] -= w->r[i*n + k]*v[i];
        v[k] /= w->r[k*n + k];
        for (int c = 0; c < n; c++)
            step[c] += v[k]*w->q[k*n + c];
    }
    backward(n, w->l, step);
    for (int c = 0; c < n; c++)
        p[c] += step[c];
}

/* Activate condition j with the vector y: step in primal and dual space until it holds. */
static bool bring_in(active *w, int j, double gap, const double *y, double *p)
{
    int n = w->n;
    double z[LW_QP_MAX], part[LW_QP_MAX], d[LW_QP_MAX], step[LW_QP_MAX], u_new = 0, y2 = lw_dot(n, y, y);
    for (int guard = 0; guard < 4*LW_QP_MAX; guard++) {
        double z2 = split(w, y, z, part, d), t1 = INFINITY, t2 = INFINITY;
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
            memcpy(step, z, sizeof *step*(size_t)n);
            backward(n, w->l, step);
            for (int c = 0; c < n; c++)
                p[c] += t*step[c];
            gap += t*z2;
            grow(w, p);
        }
        if (t2 <= t1) {
            assert(w->count < n);
            join(w, j, u_new, part, z, z2);
            return true;
        }
        drop(w, leave);
    }
    return false;
}

bool lw_qp_solve(int n, const double *l, const double *g, const lw_qp_rows *rows, double *work, double *p)
{
    static const lw_qp_rows none = { .m = 0 };
    active w = { .n = n, .l = l, .rows = rows ? rows : &none, .q = work, .r = work + n*n };
    double y[LW_QP_MAX];
    assert(n <= LW_QP_MAX);
    for (int i = 0; i < n; i++)
        p[i] = -g[i];
    forward(n, 0, l, p);
    w.size = sqrt(lw_dot(n, p, p));
    backward(n, l, p);
    for (int round = 0; round < 20*LW_QP_MAX; round++) {
        double gap;
        int j = most_violated(&w, p, &gap, y);
        if (j < 0) {
            settle(&w, p);
            return true;
        }
        if (bring_in(&w, j, gap, y, p))
            continue;
        settle(&w, p);                                       /* what is left of a row that depends on active ones? */
        if (gap_of(&w, j, p) < -rounding(&w, j, y, p))
            return false;
    }
    return false;
}
