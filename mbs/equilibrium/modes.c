/* mbs/equilibrium/modes.c - eigenvalues of the reduced equations, as modes. */
#include "mbs/equilibrium/modes.h"

#include <assert.h>
#include <float.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/vector.h"
#include "base/eigen.h"
#include "mbs/equilibrium/vibration_internal.h"

#define NEGLIGIBLE 1e-13                 /* numbers below this part of the greatest are rounding */

/* ---- shapes -------------------------------------------------------------------------------------- */

/* Shape of a mode in the coordinates of the bodies, from a reduced vector re + i im (im NULL: real): amplitudes and
 * phases; the greatest amplitude is 1 with phase 0. */
static void set_shape(const lw_vibration *v, const double *re, const double *im, lw_mode *mode)
{
    int n = v->n_q, top = 0;
    double *a = mode->shape, *b = mode->phase;
    for (int k = 0; k < v->n_free; k++)
        for (int i = 0; i < n; i++) {
            a[i] += re[k]*v->null[k*n + i];
            b[i] += im ? im[k]*v->null[k*n + i] : 0.0;
        }
    for (int i = 0; i < n; i++) {
        double size = hypot(a[i], b[i]);
        b[i] = atan2(b[i], a[i]);
        a[i] = size;
        top = size > a[top]*(1.0 + 1e-9) ? i : top;
    }
    double greatest = a[top], phase = b[top];
    for (int i = 0; i < n && greatest > 0.0; i++) {
        a[i] /= greatest;
        b[i] = a[i] > NEGLIGIBLE ? remainder(b[i] - phase, 2.0*LW_PI) : 0.0;
        a[i] = a[i] > NEGLIGIBLE ? a[i] : 0.0;
    }
}

static void set_numbers(lw_mode *m, double re, double im)
{
    double size = hypot(re, im);
    m->re = re;
    m->im = im;
    m->frequency = im/(2.0*LW_PI);
    m->natural = size/(2.0*LW_PI);
    m->damping = re != 0.0 ? -re/size : 0.0;
}

static int by_size(const void *a, const void *b)
{
    const lw_mode *x = a, *y = b;
    return (x->natural > y->natural) - (x->natural < y->natural);
}

static lw_mode *add(lw_modes *out, double re, double im)
{
    assert(out->n_mode < 2*LW_SYSTEM_Q_MAX);
    lw_mode *m = &out->mode[out->n_mode++];
    set_numbers(m, re, im);
    return m;
}

/* ---- eigenvalues --------------------------------------------------------------------------------- */

/* Slow vibrations beside very fast ones: w of the slow ones from 1/w, which rounding of the fast ones does not touch.  The
 * two have the same error at the geometric mean of the rates.  k, m (n*n) are overwritten; inverse (n) x (n*n) scratch.  Changes
 * nothing where a motion is free or unstable.  LW_E_MEMORY. */
static lw_status refine_slow(int n, double *k, double *m, double *inverse, double *vectors, double *w, double *x)
{
    double top = w[n - 1];
    lw_status s = w[0] > NEGLIGIBLE*NEGLIGIBLE*top ? lw_eigen_symmetric(n, m, k, inverse, vectors) : LW_E_NUMERIC;
    if (s != LW_OK || !(inverse[n - 1] > 0))
        return s == LW_E_MEMORY ? s : LW_OK;
    for (int i = 0; i < n; i++) {            /* 1/w ascends as w descends */
        double slow = 1/inverse[n - 1 - i];
        if (!(inverse[n - 1 - i] > 0) || slow*slow*inverse[n - 1] > top)
            break;
        w[i] = slow;
        memcpy(x + i*n, vectors + (n - 1 - i)*n, (size_t)n*sizeof *x);
    }
    return LW_OK;
}

/* Undamped: w = s^2.  Below 0 it is a vibration; above, a pair of real values, of which the growing one is reported. */
static lw_status conservative(const lw_vibration *v, double *memory, lw_modes *out)
{
    int n = v->n_free;
    size_t square = (size_t)(n*n);
    double *k = memory, *m = k + square, *x = m + square, *w = x + square, most = 0.0;
    lw_status s = LW_OK;
    for (int pass = 0; s == LW_OK && pass < 2; pass++) {
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                k[i*n + j] = 0.5*(v->stiffness[i*n + j] + v->stiffness[j*n + i]);
        memcpy(m, v->mass, sizeof *m*square);
        if (pass == 0)
            s = lw_eigen_symmetric(n, k, m, w, x);
        for (int i = 0; s == LW_OK && pass == 0 && i < n; i++)
            most = fmax(most, fabs(w[i]));
        if (s == LW_OK && pass == 1 && n > 1)
            s = refine_slow(n, k, m, w + n, w + 2*n, w, x);
    }
    for (int i = 0; s == LW_OK && i < n; i++) {
        lw_mode *mode = add(out, 0.0, 0.0);
        double square_rate = fabs(w[i]) <= NEGLIGIBLE*most ? 0.0 : w[i];     /* a free motion, but for rounding */
        set_numbers(mode, square_rate < 0.0 ? sqrt(-square_rate) : 0.0, square_rate > 0.0 ? sqrt(square_rate) : 0.0);
        set_shape(v, x + i*n, NULL, mode);
    }
    return s;
}

/* ---- with damping --------------------------------------------------------------------------------- */

/* In the basis X of the undamped modes of K + a C, X^T M X = I, each motion that neither K nor C couples with others
 * has its own equation s^2 + c s + k = 0.  So free motions stay at 0 and double roots stay double, which the general
 * problem, defective there, gives to half the digits only.  The coupled motions go to the general problem. */
#define DAMPING_WEIGHT    0.6180339887498949      /* of C over K in the basis; an arbitrary number */

typedef struct basis {
    int     n;
    double *x, *k, *c;                   /* vectors x[i*n + .]; K and C in it (n*n by rows) */
    double  k_most, c_most;
    bool    alone[LW_SYSTEM_Q_MAX];
} basis;

/* out = X A X^T, where the rows of X are the vectors; memory (n*n) */
static void transform(const basis *b, const double *a, double *memory, double *out)
{
    int n = b->n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int l = 0; l < n; l++)
                sum += a[i*n + l]*b->x[j*n + l];
            memory[i*n + j] = sum;
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0.0;
            for (int l = 0; l < n; l++)
                sum += b->x[i*n + l]*memory[l*n + j];
            out[i*n + j] = sum;
        }
}

/* memory (4 n^2 + n) */
static lw_status find_basis(const lw_vibration *v, basis *b, double *memory)
{
    int n = b->n;
    size_t square = (size_t)(n*n);
    double *sum = memory, *mass = sum + square, *w = mass + square, stiff = lw_greatest(n*n, v->stiffness);
    double most = lw_greatest(n*n, v->damping), a = most > 0.0 ? DAMPING_WEIGHT*(stiff > 0.0 ? stiff : 1.0)/most : 0.0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            sum[i*n + j] = 0.5*(v->stiffness[i*n + j] + v->stiffness[j*n + i] + a*(v->damping[i*n + j] + v->damping[j*n + i]));
    memcpy(mass, v->mass, sizeof *mass*square);
    lw_status s = lw_eigen_symmetric(n, sum, mass, w, b->x);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < n; i++) {                           /* the vectors of GSL have length 1: scale to X M X^T = 1 */
        double size = 0.0, *x = b->x + i*n;
        for (int j = 0; j < n; j++)
            for (int l = 0; l < n; l++)
                size += x[j]*v->mass[j*n + l]*x[l];
        for (int j = 0; j < n; j++)
            x[j] /= sqrt(size);
    }
    transform(b, v->stiffness, memory, b->k);
    transform(b, v->damping, memory, b->c);
    b->k_most = lw_greatest(n*n, b->k);
    b->c_most = lw_greatest(n*n, b->c);
    for (int i = 0; i < n; i++) {
        double k = 0.0, c = 0.0;
        for (int j = 0; j < n; j++)
            if (j != i) {
                k = fmax(k, fmax(fabs(b->k[i*n + j]), fabs(b->k[j*n + i])));
                c = fmax(c, fmax(fabs(b->c[i*n + j]), fabs(b->c[j*n + i])));
            }
        b->alone[i] = k <= NEGLIGIBLE*b->k_most && c <= NEGLIGIBLE*b->c_most;
    }
    return LW_OK;
}

/* Solve s^2 + c s + k = 0; the result is 0 or a double root where only rounding speaks against it. */
static void solve_alone(const lw_vibration *v, const basis *b, int i, lw_modes *out)
{
    double c = b->c[i*b->n + i], k = b->k[i*b->n + i];
    c = fabs(c) <= NEGLIGIBLE*b->c_most ? 0.0 : c;
    k = fabs(k) <= NEGLIGIBLE*b->k_most ? 0.0 : k;
    double below = c*c - 4.0*k, doubt = 16.0*DBL_EPSILON*(2.0*fabs(c)*b->c_most + 4.0*b->k_most);
    if (fabs(below) <= doubt)
        below = 0.0;
    if (below < 0.0) {
        set_shape(v, b->x + i*b->n, NULL, add(out, -0.5*c, 0.5*sqrt(-below)));
        return;
    }
    double larger = -0.5*(c + copysign(sqrt(below), c));
    set_shape(v, b->x + i*b->n, NULL, add(out, larger, 0.0));
    if (c != 0.0 || k != 0.0)                                /* a free motion is reported once */
        set_shape(v, b->x + i*b->n, NULL, add(out, below == 0.0 ? larger : k/larger, 0.0));
}

/* Solve the coupled motions at first order in z and z'/tau, where 1/tau is the greatest rate, so that both parts
 * have one size. */
static lw_status solve_coupled(const lw_vibration *v, const basis *b, double *memory, lw_modes *out)
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
    double *a = memory, *re = a + square, *im = re + two, *x_re = im + two, *x_im = x_re + square;
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
            continue;                                        /* its conjugate is reported */
        memset(shape, 0, sizeof shape);
        for (int j = 0; j < m; j++)
            for (int l = 0; l < n; l++) {
                shape[0][l] += x_re[i*two + j]*b->x[which[j]*n + l];
                shape[1][l] += x_im[i*two + j]*b->x[which[j]*n + l];
            }
        set_shape(v, shape[0], shape[1], add(out, re[i]*rate, im[i]*rate));
    }
    return s;
}

static lw_status damped(const lw_vibration *v, double *memory, lw_modes *out)
{
    size_t square = (size_t)(v->n_free*v->n_free);
    basis b = { .n = v->n_free, .x = memory, .k = memory + square, .c = memory + 2*square };
    lw_status s = find_basis(v, &b, memory + 3*square);
    for (int i = 0; s == LW_OK && i < b.n; i++)
        if (b.alone[i])
            solve_alone(v, &b, i, out);
    return s == LW_OK ? solve_coupled(v, &b, memory + 3*square, out) : s;
}

/* ---- all modes -------------------------------------------------------------------------------------- */

/* No damping, and a stiffness that comes from a potential? */
static bool is_conservative(const lw_vibration *v)
{
    int n = v->n_free;
    double stiff = 0.0, skew = 0.0, damping = 0.0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            stiff = fmax(stiff, fabs(v->stiffness[i*n + j]));
            skew = fmax(skew, fabs(v->stiffness[i*n + j] - v->stiffness[j*n + i]));
            damping = fmax(damping, fabs(v->damping[i*n + j]));
        }
    return damping == 0.0 && skew <= 1e-11*stiff;
}

static double unbalanced(const lw_vibration *v)
{
    double rest = 0.0, most = 0.0;
    for (int k = 0; k < v->n_free; k++)
        rest = fmax(rest, fabs(v->load[k]));
    for (int i = 0; i < v->n_q; i++)
        most = fmax(most, fabs(v->force[i]));
    return most > 0.0 ? rest/most : 0.0;
}

/* Name of the link that moves most in the motion with the least mass. */
static const char *lightest(const lw_vibration *v)
{
    int n = v->n_free, worst = 0, top = 0;
    for (int k = 1; k < n; k++)
        worst = v->mass[k*n + k] < v->mass[worst*n + worst] ? k : worst;
    for (int i = 1; i < v->n_q; i++)
        top = fabs(v->null[worst*v->n_q + i]) > fabs(v->null[worst*v->n_q + top]) ? i : top;
    return v->eq ? v->eq->name(v->eq->context, LW_NAMED_BLOCK, top/LW_BLOCK)
                 : v->f->model->linkage.link_name[v->f->system->link[top/3]];
}

void lw_modes_free(lw_modes *modes)
{
    free(modes->memory);
    memset(modes, 0, sizeof *modes);
}

lw_status lw_modes_solve(lw_vibration *v, lw_modes *out, lw_error *e)
{
    size_t n = (size_t)v->n_free, n_q = (size_t)v->n_q;
    double *memory = calloc(17*n*n + 8*n + 1, sizeof *memory);
    out->memory = calloc(4*n*n_q + 1, sizeof *out->memory);
    for (size_t k = 0; out->memory && k < 2*n; k++) {
        out->mode[k].shape = out->memory + 2*k*n_q;
        out->mode[k].phase = out->mode[k].shape + n_q;
    }
    if (!memory || !out->memory)
        return free(memory), lw_error_set(e, LW_E_MEMORY, "no memory for eigenvalues");
    out->conservative = is_conservative(v);
    lw_status s = out->conservative ? conservative(v, memory, out) : damped(v, memory, out);
    free(memory);
    if (s == LW_E_NUMERIC)
        return lw_error_set(e, LW_E_ARG, "some motion has no mass, so it has no frequency: give link \"%s\" mass and inertia", lightest(v));
    if (s == LW_E_ARG)
        return lw_error_set(e, LW_E_NUMERIC, "a force or mass has no finite derivative in this posture, so small "
                            "vibrations about it are not defined; start from another posture");
    qsort(out->mode, (size_t)out->n_mode, sizeof *out->mode, by_size);
    return s == LW_OK ? s : lw_error_set(e, s, "the eigenvalues cannot be found: %s", lw_status_text(s));
}

lw_status lw_modes_move_input(const lw_forces *f, double t, int input, double value, double *q, lw_error *e)
{
    const lw_system *s = f->system;
    int joint = s->input_joint[input];
    double scale = lw_system_joint_unit(s, joint), next[LW_SYSTEM_Q_MAX];
    double from = lw_system_measure(s, joint, q, NULL), to = (value - s->input_value[input])/scale;
    int n = (int)fmin(1e6, ceil(fabs(to - from)/0.05));
    lw_vibration v;
    if (lw_vibration_make(f, true, t, q, &v) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status status = LW_OK;
    for (int k = 1; status == LW_OK && k <= n; k++) {
        memcpy(next, q, sizeof *q*(size_t)s->n_q);
        v.held_value[input] = from + (to - from)*k/n;
        status = lw_vibration_project(&v, next);
        double moved = 0.0;
        for (int i = 0; i < s->n_q; i++)
            moved = fmax(moved, fabs(next[i] - q[i]));
        if (status == LW_OK && moved > 1.0)
            status = LW_OPEN;                                /* a jump to another motion curve */
        if (status == LW_OK)
            memcpy(q, next, sizeof *q*(size_t)s->n_q);
    }
    lw_vibration_free(&v);
    return status == LW_OK ? LW_OK : lw_error_set(e, LW_OPEN, "the linkage does not reach the input %.9g", value);
}

lw_status lw_modes_find(const lw_forces *f, const lw_modes_options *o, double t, double *q, lw_modes *modes, lw_error *e)
{
    lw_vibration v;
    lw_rest r;
    memset(modes, 0, sizeof *modes);
    if (f->model->states.n_state)
        return lw_error_set(e, LW_E_KIND, "the model has first-order states (\"%s\"), which the analysis of small vibrations "
                            "does not know", f->model->states.state[0].name);
    if (lw_vibration_make(f, o->hold_inputs, t, q, &v) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a linear analysis");
    lw_status s = lw_vibration_project(&v, q);
    if (s != LW_OK)
        lw_error_set(e, s, "no posture near the given one fits the joints and inputs");
    if (s == LW_OK && o->rest)
        s = lw_vibration_rest(&v, t, q, &r, e) == LW_OK ? LW_OK : LW_E_NUMERIC;
    if (s == LW_OK && (s = lw_vibration_linearise(&v, t, q)) != LW_OK)
        lw_error_set(e, s, "the loads are not finite in this posture");
    modes->freedom = v.n_free;
    modes->redundant = v.redundant;
    if (s == LW_OK && v.n_free == 0)
        s = lw_error_set(e, LW_NOTHING, "no freedom is left to vibrate");
    if (s == LW_OK) {
        modes->unbalanced = unbalanced(&v);
        s = lw_modes_solve(&v, modes, e);
    }
    lw_vibration_free(&v);
    return s;
}
