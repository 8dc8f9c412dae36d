/* mbs/ode/collocation.c - steps of Radau IIA with eight stages, eight evaluations at once. */
#include "base/real.h"
#include "base/vector.h"
#include "mbs/ode/collocation.h"

#include <float.h>
#include <string.h>
#include "mbs/ode/collocation_table_internal.h"
#include "mbs/ode/kernel_stages_internal.h"

enum { N = LW_STAGES, MOST_ITERATIONS = 14, PAIRS = N/2 };

static const double exact_enough = 0.03;      /* change that the improvements still promise, over the error allowed */
/* Of an improvement, and of a Newton step, whose derivatives and factors cost something for each step: longer steps need more work for
 * their length. */
static const double best_factor = 0.15, best_newton = 0.4;
static const double least_factor = 0.01;     /* smaller ones are taken as this one */
static const double first_change = 16;       /* square of how far rates may change in the first step, over their size there */
static const double fresh_factor = 0.1;      /* above it derivatives are found afresh */
/* A step that did not converge: the next try over it, the limit that it sets for later steps over it, and the growth of that limit in
 * each later step. */
static const double shorter = 0.5, less = 0.7, relax = 1.2;
static const double greatest_growth = 4, difference = 1e-7;

static const lw_stage_loops *const loops[] = {
#ifdef __x86_64__
    &lw_stage_loops_x86_64_v4, &lw_stage_loops_x86_64_v3, &lw_stage_loops_x86_64
#else
    &lw_stage_loops_native
#endif
};

/* Of an instruction set; of one that has none, the last. */
static const lw_stage_loops *loops_of(const char *isa)
{
    size_t i = 0;
    while (i + 1 < sizeof loops/sizeof *loops && !(isa && strcmp(loops[i]->isa, isa) == 0))
        i++;
    return loops[i];
}

size_t lw_collocation_work(int n, bool implicit)
{
    return (size_t)n*(5*N + 5) + LW_SCRATCH_ALIGNMENT/sizeof(double) + (implicit ? (2 + 2*PAIRS)*LW_IMPLICIT_MAX*LW_IMPLICIT_MAX : 0);
}

void lw_collocation_start(lw_collocation *w, const lw_stages_ode *ode, const lw_ode_options *o, double *work, double t, const double *y)
{
    size_t n = (size_t)ode->n;
    *w = (lw_collocation){ .ode = ode, .loops = loops_of(ode->isa), .o = *o, .t = t, .t_old = t, .fastest = INFINITY, .most = INFINITY, .stale = true };
    work = lw_scratch_align(work);
    double **part[] = { &w->f, &w->stage, &w->c, &w->d, &w->d_refused };
    for (int i = 0; i < 5; i++, work += N*n)
        *part[i] = work;
    w->y = work, w->y_old = work + n, w->low = work + 2*n, w->scale = work + 3*n;
    w->lost = work + 4*n;
    w->by = work + 5*n, w->lu = w->by + 2*LW_IMPLICIT_MAX*LW_IMPLICIT_MAX;
    memset(w->c, 0, N*n*sizeof *y);
    memset(w->d, 0, N*n*sizeof *y);
    lw_collocation_restart(w, y);
}

void lw_collocation_restart(lw_collocation *w, const double *y)
{
    memcpy(w->y, y, (size_t)w->ode->n*sizeof *y);
    memset(w->low, 0, (size_t)w->ode->n*sizeof *y);
}

/* In place of the ninth root that the order asks for: step lengths need few digits, and pow takes fifteen times as long. */
static double eighth_root(double x) { return sqrt(sqrt(sqrt(x))); }

/* ---- polynomials ------------------------------------------------------------------------------------------------ */

/* Integrals of the Legendre polynomials from the beginning of the step to x of it. */
static void integrals_at(double x, double *integral)
{
    double z = 2*x - 1, below = 1, now = z;
    integral[0] = x;
    for (int m = 1; m < N; m++) {
        double next = ((2*m + 1)*z*now - m*below)/(m + 1);
        integral[m] = (next - below)/(2*(2*m + 1));
        below = now, now = next;
    }
}

void lw_collocation_dense(const lw_collocation *w, double t, double *y)
{
    double integral[N];
    integrals_at(w->h_done > 0 ? (t - w->t_old)/w->h_done : 0, integral);
    for (int i = 0; i < w->ode->n; i++) {
        double sum = 0;
        for (int m = 0; m < N; m++)
            sum += w->c[N*i + m]*integral[m];
        y[i] = w->y_old[i] + w->h_done*sum;
    }
}

void lw_collocation_dense_eight(const lw_collocation *w, const double t[LW_STAGES], double *y)
{
    double integral[N], column[N][N];
    for (int k = 0; k < N; k++) {
        integrals_at((t[k] - w->t_old)/w->h_done, integral);
        for (int m = 0; m < N; m++)
            column[m][k] = integral[m];
    }
    w->loops->sums(w->ode->n, (const double (*)[N])column, w->c, y);
    for (int i = 0; i < w->ode->n; i++)
        for (int k = 0; k < N; k++)
            y[N*i + k] = t[k] == w->t ? w->y[i] : w->y_old[i] + w->h_done*y[N*i + k];
}

/* column[m][k]: Newton's polynomial m on the points of a step of length `of`, from its end, at point k of one of length h that begins `later`. */
static void continue_polynomials(double of, double later, double h, double column[N][N])
{
    for (int k = 0; k < N; k++) {
        double x = (later + node[k]*h)/of, product = 1;
        for (int m = 0; m < N; product *= x - node[N - 1 - m], m++)
            column[m][k] = product;
    }
}

/* Rates from this one on are predicted: x' = u follows from u. */
static int first_predicted(const lw_collocation *w) { return w->ode->motion ? 0 : w->ode->n_x; }

/* out: combinations of the predicted rates in */
static void sums_of_rates(const lw_collocation *w, const double (*column)[N], const double *in, double *out)
{
    const int from = first_predicted(w);
    w->loops->sums(w->ode->n - from, column, in + N*from, out + N*from);
}

/* By the last step, or by one that was refused and goes farther. */
static void predict(lw_collocation *w, double h)
{
    _Alignas(LW_SCRATCH_ALIGNMENT) double column[N][N];
    bool refused = w->h_refused > w->passed;
    continue_polynomials(refused ? w->h_refused : w->h_done, refused ? w->passed : w->h_done, h, column);
    for (int m = w->degree + 1; m < N && !refused; m++)
        memset(column[m], 0, sizeof column[m]);
    sums_of_rates(w, (const double (*)[N])column, refused ? w->d_refused : w->d, w->f);
}

/* A step whose rates converged but whose error is too great: it is repeated shorter, and these rates are nearly right within it. */
static void keep_refused(lw_collocation *w, double h)
{
    sums_of_rates(w, difference_column, w->f, w->d_refused);
    w->h_refused = h;
    w->passed = 0;
}

/* The degree with which the last polynomial would have met the rates of this step best.  A rate of u moves x at the end of the step by the part of it
 * that is left. */
static int best_degree(const lw_collocation *w, double h)
{
    _Alignas(LW_SCRATCH_ALIGNMENT) double column[N][N];
    double off[N], weight[N];
    int best = 0, from = first_predicted(w);
    continue_polynomials(w->h_done, w->h_done, h, column);
    for (int k = 0; k < N; k++)
        weight[k] = (1 - node[k])*(1 - node[k]);
    w->loops->misses(w->ode->n - from, (const double (*)[N])column, w->d + N*from, w->f + N*from, w->scale + from, weight, off);
    for (int m = 1; m < N; m++)
        best = off[m] < off[best] ? m : best;
    return best;
}

/* ---- improvements ----------------------------------------------------------------------------------------------- */

static lw_status rates_at(lw_collocation *w, double h, bool again)
{
    double t[N];
    for (int k = 0; k < N; k++)
        t[k] = w->t_old + node[k]*h;
    w->n_rate += N;
    return w->ode->rates(w->ode->context, t, again, w->stage, w->f);
}

/* x' from the states, to f; and where they are, which is u among the states or in f. */
static void move(lw_collocation *w)
{
    size_t n = N*(size_t)w->ode->n_x;
    if (w->ode->motion)
        w->ode->motion(w->ode->context, w->stage, w->f);
    else
        memcpy(w->f, w->stage + n, n*sizeof *w->f);
}

static const double *motion(lw_collocation *w)
{
    if (!w->ode->motion)
        return w->stage + N*(size_t)w->ode->n_x;
    move(w);
    return w->f;
}

/* Numbers `from` to n at all points from their rates f; off (8): sums of squares of how far they moved, over the errors allowed. */
static void improve(lw_collocation *w, double h, int from, int n, const double *f, double *off)
{
    w->loops->improve(n - from, stage_column, h, w->y_old + from, w->scale + from, f, w->stage + N*from, off);
}

/* The factors of 1 - z D - z^2 K, z = h times an eigenvalue, K and D the derivatives by x and u: lower part, then upper part with
 * inverse diagonal, real and imaginary parts in turn. */
static lw_status factor(lw_collocation *w, double h)
{
    const int n = w->ode->n_u;
    const double *K = w->by, *D = K + n*n;
    for (int p = 0; p < PAIRS; p++) {
        double *m = w->lu + 2*p*n*n, a = h*eigenvalue[p][0], b = h*eigenvalue[p][1], aa = a*a - b*b, bb = 2*a*b;
        for (int i = 0; i < n*n; i++)
            m[2*i] = (i%(n + 1) == 0) - a*D[i] - aa*K[i], m[2*i + 1] = -b*D[i] - bb*K[i];
        for (int k = 0; k < n; k++) {
            double *d = m + 2*(k*n + k), size = d[0]*d[0] + d[1]*d[1];
            if (!(size > 1e-12))
                return LW_OPEN;
            d[0] /= size, d[1] /= -size;
            for (int i = k + 1; i < n; i++) {
                double *l = m + 2*(i*n + k), re = l[0]*d[0] - l[1]*d[1], im = l[0]*d[1] + l[1]*d[0];
                l[0] = re, l[1] = im;
                for (int j = k + 1; j < n; j++) {
                    const double *u = m + 2*(k*n + j);
                    double *to = m + 2*(i*n + j);
                    to[0] -= re*u[0] - im*u[1], to[1] -= re*u[1] + im*u[0];
                }
            }
        }
    }
    return LW_OK;
}

/* x (2 n, real and imaginary parts in turn): solve with the factors of eigenvalue p. */
static void solve(const lw_collocation *w, int p, double *x)
{
    const int n = w->ode->n_u;
    const double *m = w->lu + 2*p*n*n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++) {
            const double *l = m + 2*(i*n + j);
            x[2*i] -= l[0]*x[2*j] - l[1]*x[2*j + 1], x[2*i + 1] -= l[0]*x[2*j + 1] + l[1]*x[2*j];
        }
    for (int i = n - 1; i >= 0; i--) {
        const double *d = m + 2*(i*n + i);
        for (int j = i + 1; j < n; j++) {
            const double *u = m + 2*(i*n + j);
            x[2*i] -= u[0]*x[2*j] - u[1]*x[2*j + 1], x[2*i + 1] -= u[0]*x[2*j + 1] + u[1]*x[2*j];
        }
        double re = x[2*i]*d[0] - x[2*i + 1]*d[1];
        x[2*i + 1] = x[2*i]*d[1] + x[2*i + 1]*d[0], x[2*i] = re;
    }
}

/* A Newton step of u at all points; in the eigenvectors of A they separate. */
static void newton_step(lw_collocation *w, double h, double off[N])
{
    const int n = w->ode->n_u, first = n;
    double x[PAIRS][2*LW_IMPLICIT_MAX], r[N];
    for (int i = 0; i < n; i++) {
        const double *stage = w->stage + N*(first + i);
        w->loops->sums(1, stage_column, w->f + N*(first + i), r);
        for (int k = 0; k < N; k++)
            r[k] = w->y_old[first + i] + h*r[k] - stage[k];
        w->loops->sums(1, inverse_column, r, r);
        for (int p = 0; p < PAIRS; p++)                  /* a pair of columns with factors w1, w2 stands for w1 - i w2 */
            x[p][2*i] = r[2*p], x[p][2*i + 1] = -r[2*p + 1];
    }
    for (int p = 0; p < PAIRS; p++)
        solve(w, p, x[p]);
    for (int i = 0; i < n; i++) {
        double *stage = w->stage + N*(first + i);
        for (int p = 0; p < PAIRS; p++)
            r[2*p] = x[p][2*i], r[2*p + 1] = -x[p][2*i + 1];
        w->loops->sums(1, vector_column, r, r);
        for (int k = 0; k < N; k++) {
            double by = r[k]*w->scale[first + i];
            stage[k] += r[k];
            off[k] += by*by;
        }
    }
}

/* Improve the states at all points from their rates, of which f gets no x' here; returns how far the one moved that moved farthest, over the
 * error allowed. */
static double improve_all(lw_collocation *w, double h, bool implicit)
{
    const int n = w->ode->n_x, rest = implicit ? n + w->ode->n_u : n;
    double off[N], by_newton[N] = { 0 }, of_x[N], most = 0;
    if (implicit)
        newton_step(w, h, by_newton);
    improve(w, h, rest, w->ode->n, w->f + N*rest, off);
    improve(w, h, 0, n, motion(w), of_x);    /* u is improved before x */
    for (int k = 0; k < N; k++)
        most = lw_greater(off[k] + of_x[k] + by_newton[k], most);
    return sqrt(most/w->ode->n);
}

/* States at all points from the predicted rates. */
static void start_stages(lw_collocation *w, double h)
{
    double off[N];
    predict(w, h);
    if (w->ode->motion)                      /* it needs x */
        improve(w, h, 0, w->ode->n_x, w->f, off);
    improve_all(w, h, false);
}

/* How far rounding moves the states, over the error allowed. */
static double rounding(const lw_collocation *w)
{
    double sum = 0;
    for (int i = 0; i < w->ode->n; i++) {
        double from = fabs(w->y_old[i]), to = fabs(w->stage[N*i + N - 1]), by = lw_greater(from, to)*w->scale[i];
        sum += by*by;
    }
    return 4*DBL_EPSILON*sqrt(sum/w->ode->n);
}

/* What all improvements after the i-th, of factor `by`, leave: their factors fall as 1/i, since h A is integrals over integrals. */
static double still_to_come(double by, int i)
{
    double left = 1;
    for (int j = i + 1; j <= MOST_ITERATIONS; j++)
        left *= by*i/j;
    return left;
}

/* Improve the states of a step until their error is allowed.  LW_OPEN: they do not converge fast enough. */
static lw_status iterate(lw_collocation *w, double h)
{
    double last = 0, by = fmax(least_factor, w->fastest*h), none = 0;
    /* integrals have the rates before the last Newton step */
    const double most = w->ode->implicit && w->ode->n > 2*w->ode->n_u ? 1 : INFINITY;
    start_stages(w, h);
    none = fmin(exact_enough, rounding(w));
    for (int i = 1; i <= MOST_ITERATIONS; i++) {
        lw_status s = rates_at(w, h, i > 1 && !w->ode->implicit);
        if (s != LW_OK)
            return s;
        double moved = improve_all(w, h, w->ode->implicit);
        if (!isfinite(moved))
            return LW_OPEN;
        if (moved <= none) {                 /* its size against the last one tells nothing of how fast they converge */
            w->fastest = fmin(w->fastest, least_factor/h);
            return LW_OK;
        }
        if (i > 1 && last > 0)
            by = i > 2 ? fmax(moved/last, 0.5*by) : moved/last, w->fastest = by/h;
        else if (i == 1)
            w->fastest = fmax(0.5*w->fastest, least_factor/h);       /* unless it is measured */
        if ((moved*by <= exact_enough*(1 - by) && moved <= most) || (i > 2 && by > 0.5 && moved <= exact_enough))
            return LW_OK;
        if (i > 2 && (by > 0.9 || moved*still_to_come(by, i) > exact_enough))
            return LW_OPEN;
        last = moved;
    }
    return LW_OPEN;
}

/* ---- the step ---------------------------------------------------------------------------------------------------- */

/* Derivatives of u' in the middle of the predicted step by differences, eight at a time. */
static lw_status differentiate(lw_collocation *w, double h)
{
    const lw_stages_ode *o = w->ode;
    const int n = o->n_u, middle = N/2;
    double base[LW_IMPLICIT_MAX], t[N], *at = w->lost;
    start_stages(w, h);
    for (int i = 0; i < o->n; i++)
        at[i] = w->stage[N*i + middle];
    for (int k = 0; k < N; k++)
        t[k] = w->t_old + h*node[middle];
    for (int from = -1; from < 2*n; from += N) {         /* column -1: no change */
        for (int i = 0; i < o->n; i++)
            for (int k = 0; k < N; k++)
                w->stage[N*i + k] = at[i] + (from + k == i ? difference*fmax(1, fabs(at[i])) : 0);
        w->n_rate += N;
        lw_status s = o->rates(o->context, t, false, w->stage, w->f);
        if (s != LW_OK)
            return s;
        for (int i = 0; i < n; i++)
            for (int k = 0; k < N && from + k < 2*n; k++) {
                int c = from + k;
                double rate = w->f[N*(n + i) + k];
                if (c < 0)
                    base[i] = rate;
                else
                    w->by[c/n*n*n + i*n + c%n] = (rate - base[i])/(difference*fmax(1, fabs(at[c])));
            }
    }
    w->stale = false;
    return LW_OK;
}

/* Rates everywhere as at the start; and how far they may go on so: from rest, positions move by the rates of u alone. */
static lw_status begin(lw_collocation *w, double span)
{
    int n = w->ode->n, n_x = w->ode->n_x;
    double t[N], far[N] = { span }, first = 0, change[N] = { 0 };
    for (int k = 1; k < N; k++)
        far[k] = 0.25*far[k - 1];
    for (int i = 0; i < n; i++)
        for (int k = 0; k < N; k++)
            w->stage[N*i + k] = w->y[i];
    lw_status s = rates_at(w, 0, false);
    if (s != LW_OK)
        return s;
    move(w);
    for (int i = 0; i < n; i++) {
        double rate = w->d[N*i] = w->f[N*i];
        first += rate*w->scale[i]*(rate*w->scale[i]);
    }
    for (int i = n_x; i < n; i++)
        for (int k = 0; k < N; k++)
            w->stage[N*i + k] = w->y[i] + 0.5*far[k]*w->d[N*i];
    move(w);                                 /* half way */
    for (int i = 0; i < n; i++)
        for (int k = 0; k < N; k++)
            w->stage[N*i + k] = w->y[i] + far[k]*(i < n_x ? w->f[N*i + k] : w->d[N*i]);
    for (int k = 0; k < N; k++)
        t[k] = w->t + far[k];
    w->n_rate += N;
    s = w->ode->rates(w->ode->context, t, false, w->stage, w->f);
    move(w);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < N; k++) {
            double by = (w->f[N*i + k] - w->d[N*i])*w->scale[i];
            change[k] += by*by;
        }
    int k = 0;
    while (k < N - 1 && (s != LW_OK || !(change[k] <= first_change*first)))
        k++;
    w->h = far[k];
    w->h_done = 1;                           /* a constant polynomial */
    return s == LW_OPEN ? LW_OK : s;
}

/* The polynomial of this step, to c; error within the step over the error allowed, from how its coefficients fall.  The rates of
 * stiff equations follow from the states: in f errors of u are multiplied. */
static double step_error(lw_collocation *w, double h)
{
    const lw_stages_ode *o = w->ode;
    double size[N], c[N];
    for (int i = o->n_u; o->implicit && i < 2*o->n_u; i++) {
        for (int k = 0; k < N; k++)
            c[k] = (w->stage[N*i + k] - w->y_old[i])/h;
        w->loops->sums(1, slope_column, c, w->f + N*i);
    }
    w->loops->sums(o->n, legendre_column, w->f, w->c);
    w->loops->squares(o->n, w->scale, w->c, size);
    double last = fmax(size[N - 1], 1e-300), fall = eighth_root(last/fmax(size[N - 5], last));
    last = fmax(sqrt(last), sqrt(size[N - 2])*fall);
    return h*last*fall/(2*(2*N + 1)*sqrt((double)o->n));
}

/* Take the step of length h, which is sound; *off: how far the projection moves it, over the error allowed. */
static lw_status arrive(lw_collocation *w, double h, double end, double *off)
{
    int n = w->ode->n;
    double sum_off = 0;
    w->loops->sums(n, stage_column, w->f, w->stage);
    for (int i = 0; i < n; i++) {
        double add = h*w->stage[N*i + N - 1] + w->low[i];
        w->y[i] = w->y_old[i] + add;
        w->lost[i] = add - (w->y[i] - w->y_old[i]);      /* summed with compensation */
    }
    memcpy(w->stage, w->y, (size_t)n*sizeof *w->y);
    lw_status s = w->ode->project(w->ode->context, end, w->y);
    for (int i = 0; i < n; i++) {
        double by = (w->y[i] - w->stage[i])*w->scale[i];
        sum_off += by*by;
    }
    *off = sqrt(sum_off/n);
    for (int i = 0; s == LW_OK && i < n; i++)
        w->low[i] = w->y[i] == w->stage[i] ? w->lost[i] : 0;
    return s;
}

/* A projection by more than the error allowed shows an error of the step, unless a shorter one did not help: rounding. */
static bool moved_too_far(lw_collocation *w, double off)
{
    if (off <= 1)
        return false;
    if (off > 0.5*w->moved)
        w->noise = fmax(w->noise, off);
    w->moved = off;
    return off > 4*w->noise;
}

/* One step from t_old of length h.  LW_OPEN: it fails, and *by is the part of it to try. */
static lw_status try_step(lw_collocation *w, double h, double end, double *by)
{
    bool fresh = !w->ode->implicit || w->stale;
    lw_status s = w->ode->implicit && w->stale ? differentiate(w, h) : LW_OK;
    if (s == LW_OK && w->ode->implicit)
        s = factor(w, h);
    if (s != LW_OK)
        return s;
    double old = w->fastest;
    s = iterate(w, h);
    if (s == LW_OK)
        move(w);
    double error = s == LW_OK ? step_error(w, h) : INFINITY, of = h*w->fastest, rising = fmax(1, fmin(3, w->fastest/old));
    double room = sqrt(sqrt((w->ode->implicit ? best_newton : best_factor)/fmax(of, least_factor)/rising));
    w->stale = of > fresh_factor || s != LW_OK;
    if (s == LW_OPEN) {
        *by = fresh ? shorter : 1;           /* 1: with fresh derivatives */
        w->most = fresh ? less*h : w->most;
    }
    if (s == LW_OK && !(error <= 1)) {
        if (isfinite(error))
            keep_refused(w, h);
        *by = fmax(0.2, 0.8/eighth_root(error));
        return LW_OPEN;
    }
    if (s != LW_OK)
        return s;
    double off = 0;
    s = arrive(w, h, end, &off);
    if (s == LW_OK && moved_too_far(w, off)) {
        keep_refused(w, h);
        *by = fmax(0.2, 0.8/eighth_root(off));
        return LW_OPEN;
    }
    if (s != LW_OK)
        return s;
    w->degree = w->n_step == 0 ? N/2 : best_degree(w, h);
    error = fmax(error, 1e-9);
    double factor = 0.85/eighth_root(error);
    if (w->n_step > 0)                       /* where errors rise from step to step, the next one is shorter (Gustafsson 1991) */
        factor = fmin(factor, factor*h/w->h_done*eighth_root(w->error/error));
    *by = fmin(greatest_growth, fmax(0.3, fmin(factor, fresh ? room : fmax(1, room))));
    w->error = fmax(error, 1e-2);
    sums_of_rates(w, difference_column, w->f, w->d);
    w->h_done = h;
    w->passed += h;
    w->n_step++;
    return LW_OK;
}

lw_status lw_collocation_step(lw_collocation *w, double t_end, lw_ode_stop *stop, lw_error *e)
{
    double t_low = w->t_low;
    *stop = LW_ODE_END;
    if (t_end == w->t)
        return LW_OK;
    for (int i = 0; i < w->ode->n; i++)
        w->scale[i] = 1/((w->o.absolute_each ? w->o.absolute_each[i] : w->o.absolute) + w->o.relative*fabs(w->y[i]));
    w->moved = INFINITY;
    w->t_old = w->t;
    memcpy(w->y_old, w->y, (size_t)w->ode->n*sizeof *w->y);
    lw_status s = w->h > 0 ? LW_OK : begin(w, t_end - w->t);
    if (s != LW_OK)
        return lw_error_set(e, s, "no first step is possible at t = %.9g s: %s", w->t, lw_status_text(s));
    for (;;) {
        if (w->o.max_step > 0 && w->n_step + w->n_refused >= w->o.max_step)
            return lw_error_set(e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", w->t_old, w->o.max_step);
        double left = t_end - w->t_old - t_low, h = w->o.greatest > 0 ? fmin(w->h, w->o.greatest) : w->h, by = 0.2;
        bool last = h*(1 + 1e-10) >= left;
        h = last ? left : 2*h > left ? 0.5*left : h;
        if (!(h > 4*DBL_EPSILON*fabs(w->t_old) && h > DBL_MIN))
            return lw_error_set(e, LW_E_NUMERIC, "at t = %.12g s the steps became too short (%.3g s): the motion is "
                                "singular there, a load is not a number behind it, or the tolerance is below rounding", w->t_old, h);
        double end = last ? t_end : w->t_old + (h + t_low);
        s = try_step(w, h, end, &by);
        if (s == LW_OK) {
            w->h = fmin(h*by, fmax(h, w->most));
            w->most *= relax;
            w->t = end;
            w->t_low = last ? 0 : h + t_low - (end - w->t_old);
            *stop = last ? LW_ODE_END : LW_ODE_STEP;
            return LW_OK;
        }
        if (s == LW_STOPPED)
            return s;
        if (s != LW_OPEN)
            return lw_error_set(e, s, "the equations of motion fail near t = %.9g s: %s", w->t_old, lw_status_text(s));
        w->n_refused++;
        w->h = by*h;
    }
}
