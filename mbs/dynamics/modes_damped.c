/* mbs/dynamics/modes_damped.c - eigenvalues with damping.
 *
 * In the basis X of the undamped modes of K + a C, X^T M X = I, those motions that neither K nor C couples with others
 * have s^2 + c s + k = 0 each: free motions stay at 0 and double roots stay double, which the general problem,
 * defective there, gives to half the digits only.  The rest goes to the general problem. */
#include <float.h>
#include <math.h>
#include <string.h>
#include "mbs/dynamics/modes_internal.h"

#define SHARE    0.6180339887498949      /* of C over K in the basis; any number without meaning           */
#define UNCOUPLED 1e-13                  /* entries below this share of the greatest are rounding          */

typedef struct basis {
    int     n;
    double *x, *k, *c;                   /* vectors x[i*n + .]; K and C in it (n*n by rows)                */
    double  k_most, c_most;
    bool    alone[LW_SYSTEM_Q_MAX];
} basis;

static double greatest(const double *a, int n)
{
    double most = 0.0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(a[i]));
    return most;
}

/* out = X A X^T with rows of X the vectors; room (n*n) */
static void transform(const basis *b, const double *a, double *room, double *out)
{
    int n = b->n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int l = 0; l < n; l++)
                sum += a[i*n + l]*b->x[j*n + l];
            room[i*n + j] = sum;
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int l = 0; l < n; l++)
                sum += b->x[i*n + l]*room[l*n + j];
            out[i*n + j] = sum;
        }
}

/* room (4 n^2 + n) */
static lw_status find_basis(const lw_vibration *v, basis *b, double *room)
{
    int n = b->n;
    size_t square = (size_t)(n*n);
    double *sum = room, *mass = sum + square, *w = mass + square, stiff = greatest(v->stiffness, n*n);
    double most = greatest(v->damping, n*n), a = most > 0.0 ? SHARE*(stiff > 0.0 ? stiff : 1.0)/most : 0.0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            sum[i*n + j] = 0.5*(v->stiffness[i*n + j] + v->stiffness[j*n + i]
                                + a*(v->damping[i*n + j] + v->damping[j*n + i]));
    memcpy(mass, v->mass, sizeof *mass*square);
    lw_status s = lw_eigen_symmetric(n, sum, mass, w, b->x);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < n; i++) {                            /* GSL's vectors are of length 1: make X M X^T = 1 */
        double size = 0.0, *x = b->x + i*n;
        for (int j = 0; j < n; j++)
            for (int l = 0; l < n; l++)
                size += x[j]*v->mass[j*n + l]*x[l];
        for (int j = 0; j < n; j++)
            x[j] /= sqrt(size);
    }
    transform(b, v->stiffness, room, b->k);
    transform(b, v->damping, room, b->c);
    b->k_most = greatest(b->k, n*n);
    b->c_most = greatest(b->c, n*n);
    for (int i = 0; i < n; i++) {
        double k = 0.0, c = 0.0;
        for (int j = 0; j < n; j++)
            if (j != i) {
                k = fmax(k, fmax(fabs(b->k[i*n + j]), fabs(b->k[j*n + i])));
                c = fmax(c, fmax(fabs(b->c[i*n + j]), fabs(b->c[j*n + i])));
            }
        b->alone[i] = k <= UNCOUPLED*b->k_most && c <= UNCOUPLED*b->c_most;
    }
    return LW_OK;
}

static lw_mode *add(lw_modes *out, double re, double im)
{
    lw_mode *m = &out->mode[out->n_mode++];
    lw_mode_finish(m, re, im);
    return m;
}

/* s^2 + c s + k = 0, with 0 and double roots where rounding is all that speaks against them */
static void solve_alone(const lw_vibration *v, const basis *b, int i, lw_modes *out)
{
    double c = b->c[i*b->n + i], k = b->k[i*b->n + i];
    c = fabs(c) <= UNCOUPLED*b->c_most ? 0.0 : c;
    k = fabs(k) <= UNCOUPLED*b->k_most ? 0.0 : k;
    double below = c*c - 4.0*k, doubt = 16.0*DBL_EPSILON*(2.0*fabs(c)*b->c_most + 4.0*b->k_most);
    if (fabs(below) <= doubt)
        below = 0.0;
    if (below < 0.0) {
        lw_mode_shape(v, b->x + i*b->n, NULL, add(out, -0.5*c, 0.5*sqrt(-below)));
        return;
    }
    double far = -0.5*(c + copysign(sqrt(below), c));
    lw_mode_shape(v, b->x + i*b->n, NULL, add(out, far, 0.0));
    if (c != 0.0 || k != 0.0)                                /* a free motion is told once */
        lw_mode_shape(v, b->x + i*b->n, NULL, add(out, below == 0.0 ? far : k/far, 0.0));
}

/* What is coupled: first order in z and z'/tau, with time in units tau of the quickest rate so that both parts are of
 * one size. */
static lw_status solve_coupled(const lw_vibration *v, const basis *b, double *room, lw_modes *out)
{
    int n = b->n, m = 0, which[LW_SYSTEM_Q_MAX];
    double rate = fmax(sqrt(b->k_most), b->c_most), shape[2][LW_SYSTEM_Q_MAX];
    for (int i = 0; i < n; i++)
        if (!b->alone[i])
            which[m++] = i;
    if (m == 0)
        return LW_OK;
    int two = 2*m;
    size_t square = 4*(size_t)(m*m);
    double *a = room, *re = a + square, *im = re + two, *x_re = im + two, *x_im = x_re + square;
    memset(a, 0, square*sizeof *a);
    for (int i = 0; i < m; i++) {
        a[i*two + m + i] = 1.0;
        for (int j = 0; j < m; j++) {
            a[(m + i)*two + j] = -b->k[which[i]*n + which[j]]/(rate*rate);
            a[(m + i)*two + m + j] = -b->c[which[i]*n + which[j]]/rate;
        }
    }
    lw_status s = lw_eigen_general(two, a, re, im, x_re, x_im);
    for (int i = 0; s == LW_OK && i < two; i++) {
        if (im[i] < 0.0)
            continue;                                        /* its partner stands for it */
        memset(shape, 0, sizeof shape);
        for (int j = 0; j < m; j++)
            for (int l = 0; l < n; l++) {
                shape[0][l] += x_re[i*two + j]*b->x[which[j]*n + l];
                shape[1][l] += x_im[i*two + j]*b->x[which[j]*n + l];
            }
        lw_mode_shape(v, shape[0], shape[1], add(out, re[i]*rate, im[i]*rate));
    }
    return s;
}

lw_status lw_modes_damped(const lw_vibration *v, double *room, lw_modes *out)
{
    size_t square = (size_t)(v->n_free*v->n_free);
    basis b = { .n = v->n_free, .x = room, .k = room + square, .c = room + 2*square };
    lw_status s = find_basis(v, &b, room + 3*square);
    for (int i = 0; s == LW_OK && i < b.n; i++)
        if (b.alone[i])
            solve_alone(v, &b, i, out);
    return s == LW_OK ? solve_coupled(v, &b, room + 3*square, out) : s;
}
