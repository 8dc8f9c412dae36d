#include "mbs/equations/friction.h"

#include <assert.h>
#include <string.h>
#include "base/linalg.h"
#include "base/real.h"
#include "base/vec3.h"
#include "base/vector.h"

static const double singular = 1e-3;         /* a pivot below this: the reactions are not determined */
static const double singular_signed = 1e-6;  /* the same of a determinant with contacts, where a slip may end before it is 0 */

lw_friction_joint lw_friction_joint_of(const lw_model *m, int j)
{
    const lw_friction *f = &m->friction[j];
    bool ideal = !(f->speed > 0);
    return (lw_friction_joint){ .joint = j, .coefficient = f->coefficient, .ideal = ideal,
                                .speed = ideal ? LW_FRICTION_SPEED : f->speed,
                                .lever_arm = lw_joint_turns(m->linkage.joint[j].kind) ? f->radius : 1 };
}

double lw_friction_push(const lw_friction_joint *f, double rate)
{
    return -f->coefficient*f->lever_arm*(f->held ? f->part : tanh(f->lever_arm*rate/f->speed));
}

double lw_friction_least_slip(int n, const lw_friction_joint *f, double unit)
{
    double least = INFINITY;
    for (int i = 0; i < n; i++)
        least = fmin(least, f[i].speed/unit);
    return least;
}

double lw_friction_force(const lw_system *s, const lw_friction_joint *f, const double *q, const double *v, double size, double *force)
{
    lw_measure m;
    lw_measure_joint(s, f->joint, q, v, false, &m);
    double push = size*lw_friction_push(f, m.rate);
    for (int i = 0; i < 6; i++)
        if (m.body[i/3] >= 0)
            force[3*m.body[i/3] + i%3] += push*m.g[i];
    return push*m.rate;
}

/* The size of reaction j of n, of which the last n_signed keep their sign. */
static double size_of(const double *r, int dim, bool is_signed)
{
    return is_signed ? r[0] : sqrt(r[0]*r[0] + r[1]*r[1] + (dim == 3 ? r[2]*r[2] : 0));
}

/* y += f x, two numbers at a time. */
static inline void add_times(long n, double f, const double *x, double *y)
{
    for (; n > 1; n -= 2, x += 2, y += 2)
        *(lw_pair *)y += f**(const lw_pair *)x;
    if (n > 0)
        *y += f**x;
}

static void swap(double *a, double *b)
{
    double was = *a;
    *a = *b, *b = was;
}

/* Solve A x = b (n x n by columns) in place; x is in b.  The joints get their friction one by one, each time the one with the
 * greatest pivot.  A pivot is the factor by which that changes the determinant, which is linear in the friction of a joint, so
 * the reactions stay determined along the way if no pivot reaches 0.  Returns the least pivot, or the first that is too small;
 * then b is of no use.  The sign of the determinant alone would not tell: that of two lost joints is positive, and that of
 * many harmless ones is small.  harmless: all pivots are at least 1/2 in any order, so none is looked for.  taken: n doubles. */
static double solve_in_turn(long n, bool harmless, double *a, double *taken, double *b)
{
    double least = INFINITY;
    for (long k = 0; k < n; k++) {
        long p = k;
        for (long i = harmless ? n : k + 1; i < n; i++)
            p = a[i + n*i] > a[p + n*p] ? i : p;
        for (long i = 0; p != k && i < n; i++)
            swap(a + k + n*i, a + p + n*i);
        for (long i = 0; p != k && i < n; i++)
            swap(a + i + n*k, a + i + n*p);
        swap(b + k, b + p);
        taken[k] = (double)p;
        const double *pivot = a + n*k;
        if (!(pivot[k] > singular))
            return pivot[k];
        least = lw_lesser(least, pivot[k]);
        const double part = 1/pivot[k];
        for (long j = k + 1; j <= n; j++) {
            double *to = j < n ? a + n*j : b, by = to[k]*part;
            if (by != 0)                     /* joints of links that do not touch: 0 */
                add_times(n - k - 1, -by, pivot + k + 1, to + k + 1);
        }
    }
    for (long k = n - 1; k >= 0; k--) {
        b[k] /= a[k + n*k];
        add_times(k, -b[k], a + n*k, b);
    }
    for (long k = n - 1; k >= 0; k--)
        swap(b + k, b + (long)taken[k]);
    return least;
}

/* lw_friction_sizes for a literal dim, which unrolls the inner loops. */
static inline __attribute__((always_inline)) lw_status find_sizes(int n, int n_signed, const int dim, const double *rest, const double *response, double *size,
                                                                  double *work, double *determinant)
{
    const long w = n;                         /* products of two numbers of joints may pass an int */
    double *matrix = work, *diag = work + w*w, *left = diag + w, *along = left + w, scale = 0;
    for (int j = 0; j < n; j++) {
        size[j] = size_of(rest + dim*j, dim, j >= n - n_signed);
        scale = fmax(scale, fabs(size[j]));
    }
    for (int pass = 0; pass < 60; pass++) {
        double off = 0;
        memcpy(along, rest, (size_t)(dim*w)*sizeof *rest);
        for (int k = 0; k < n; k++)
            add_times(dim*w, size[k], response + dim*w*k, along);
        for (int j = 0; j < n; j++) {        /* the directions in which sizes are reactions */
            double *r = along + dim*j;
            bool is_signed = j >= n - n_signed;
            double norm = size_of(r, dim, is_signed), by = norm > 0 ? 1/norm : 0;
            left[j] = norm - size[j];
            off = lw_greater(off, fabs(left[j]));
            for (int x = 0; x < dim; x++)
                r[x] = is_signed ? x == 0 : r[x]*by;
        }
        if (off <= 1e-13*scale && !(determinant && pass == 0))
            return LW_OK;
        double most = 0;                     /* sum of a column of the matrix less I */
        for (int k = 0; k < n; k++) {
            double sum = 0;
            for (int j = 0; j < n; j++) {
                const double *by = response + dim*(j + w*k), *r = along + dim*j;
                double dot = r[0]*by[0] + r[1]*by[1];
                for (int x = 2; x < dim; x++)
                    dot += r[x]*by[x];
                matrix[j + w*k] = -dot;
                sum += fabs(dot);
            }
            matrix[k + w*k] += 1;
            most = !(sum <= most) ? sum : most;
        }
        double value;
        if (n_signed) {
            lw_qr_factor(n, n, matrix, diag);
            value = lw_qr_determinant(n, diag);
            lw_qr_solve(n, n, matrix, diag, left);
        } else
            value = solve_in_turn(w, most <= 0.5, matrix, diag, left);
        if (determinant)
            *determinant = value;
        if (!(n_signed ? fabs(value) > singular_signed : value > singular))
            break;
        for (int j = 0; j < n; j++) {
            size[j] += left[j];
            if (j < n - n_signed)
                size[j] = fmax(0, size[j]);
            scale = fmax(scale, fabs(size[j]));
        }
    }
    return LW_E_NUMERIC;
}

lw_status lw_friction_sizes(int n, int n_signed, int dim, const double *rest, const double *response, double *size,
                            double *work, double *determinant)
{
    assert(n > 0 && (dim == 2 || dim == 3));
    return dim == 2 ? find_sizes(n, n_signed, 2, rest, response, size, work, determinant)
                    : find_sizes(n, n_signed, 3, rest, response, size, work, determinant);
}

lw_status lw_friction_add(const lw_friction_scene *scene, int n, const lw_friction_joint *joint, double *response, double t,
                          int n_a, double *a, int n_l, double *l, double *size, double *determinant, lw_error *e)
{
    const long stride = n_a + n_l, w = n;
    const int dim = scene->dim;
    int n_signed = 0;
    assert(n > 0);
    double *change = response + w*stride, *rest = change + dim*w*w, *work = rest + dim*n;
    for (int j = 0; j < n; j++) {
        n_signed += joint[j].joint < 0;
        scene->reaction(scene->context, j, l, rest + dim*j);
        for (int k = 0; k < n; k++)
            scene->reaction(scene->context, j, response + k*stride + n_a, change + dim*(j + w*k));
    }
    lw_status found = lw_friction_sizes(n, n_signed, dim, rest, change, size, work, determinant);
    if (found != LW_OK && n_signed > 0)      /* the caller of contacts knows what follows */
        return LW_OPEN;
    if (found != LW_OK)
        return lw_error_set(e, LW_E_NUMERIC, "friction at joint \"%s\" leaves its reaction undetermined for rigid "
                            "links (Painleve's paradox) at t = %.9g s; lower the coefficient or give the joint "
                            "compliance", scene->name(scene->context, 0), t);
    for (int k = 0; k < n; k++) {
        const double *from = response + k*stride;
        add_times(n_a, size[k], from, a);
        add_times(n_l, size[k], from + n_a, l);
    }
    return LW_OK;
}
