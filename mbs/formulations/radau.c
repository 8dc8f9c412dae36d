/* mbs/formulations/radau.c - the formulations radau and alpha.
 *
 * Radau IIA of order 9, or 5 for elastic links and clearances at tolerances from 1e-7 on and for friction that is nearly a jump (Hairer & Wanner
 * 1996, section IV.8; 1999), for stiff models of any size: elastic links above all, whose fast vibrations an explicit method would have to
 * follow and BDF methods damp or excite.
 *
 *     q' = G v,   M v' + J^T l = Q(t, q, v, x),   x' = f(t, q, v, x),   Phi(t, q) = 0
 *
 * With Z the displacements from q at the start to the stages, W = A^-1 and h the step: v = T(Z) W Z/h and
 * v' = W (v - v0)/h in the stages, so the unknowns are Z, l and the changes of the first-order states x alone; T is the unit
 * matrix but for turns in space, and Newton's method takes it for that.  In the eigenvectors of W one real and one or two
 * complex sparse systems remain (tangent.c), whose entries are m M + c C + K with m = (w/h)^2, c = w/h.  After each step v is
 * put on the constraints.  The error estimate is that of places; of rigid links without strong dampers and stiff springs, which
 * keep the errors of velocities, that of velocities counts too, and accelerations are found afresh after each step.  Samples of rigid links in the
 * plane lie on the polynomials through the stages, whose error is of the order of the error estimate; that of v begins at v at the start, and so has
 * an order more than the slope of that of q.  Steps of other models end at the samples, where positions, velocities, accelerations and multipliers
 * are those of the last stage: accelerations found afresh from a posture would show its error times the square of the highest frequency.
 *
 * Generalised alpha (Chung & Hulbert 1993; with turns Bruels & Cardona 2010) is the same with one stage at the end of the step,
 *
 *     z = h v + h^2 ((1/2 - beta) a + beta a_1),   v_1 = v + h ((1 - gamma) a + gamma a_1),
 *     (1 - am) a_1 + am a = (1 - af) v'_1 + af v'
 *
 * with an auxiliary acceleration a.  rho, the factor of infinitely fast vibrations in a step, gives am, af, beta and gamma.
 * States x follow as places do, with x' for the velocity. */
#include "base/linalg.h"
#include "base/real.h"
#include "mbs/formulations/formulations_internal.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/dynamics/tangent_internal.h"

/* ---- the method -------------------------------------------------------------------------------------------- */

#define MOST_STAGES 5
#define MOST_PAIRS  2

/* Places of the stages in a step but the last, 1; eigenvalues of A^-1: the real one, then complex ones a + ib. */
typedef struct method { int stages; double at[MOST_STAGES - 1], real, pair[MOST_PAIRS][2]; } method;
static const method methods[] = {
    { 3, { 0.15505102572168219018, 0.64494897427831780981 }, 3.6378342527444957322, { { 2.6810828736277521339, 3.0504301992474105694 } } },
    { 5, { 0.05710419611451768219, 0.27684301363812382768, 0.58359043236891682005, 0.86024013565621944785 }, 6.2867047517292766452,
      { { 5.7009532986717894192, 3.2102656003085498884 }, { 3.6556943254635722582, 6.5437368993600772940 } } },
};

typedef struct stages {
    lw_run *run;
    const method *way;
    lw_tangent real, pair[MOST_PAIRS];       /* matrices for the real and the complex eigenvalues */
    int     n, n_q, n_x, c, s;               /* s: stages */
    double  w[MOST_STAGES][MOST_STAGES], at[MOST_STAGES];          /* A^-1; places */
    double  weight[MOST_STAGES], error[MOST_STAGES];               /* weights; of the error estimate */
    double  T[MOST_STAGES][MOST_STAGES], TI[MOST_STAGES][MOST_STAGES];     /* eigenvectors of A^-1 and their inverse */
    double  t, h, h_old, work;
    double *q, *v, *a, *l, *x, *dx;          /* at t; l of the kept rows; states and their rates */
    double *v_old;                           /* (n) v at the start of the last step */
    double *ahead;                           /* a state of the run: the end of the present step */
    double  weak;                            /* least pivot of the rows there; 1: not known */
    double *z, *zl, *zx;                     /* (s n) displacements of the stages, (s c) l there, (s n_x) changes of states */
    double *last, *last_l, *last_x;          /* those of the last step */
    double *xi, *scale;                      /* (n_x) states of a stage; sizes of states */
    double *vi, *ai, *r, *b, *pair_b, *qi, *e;
    double  power[MOST_STAGES];
    bool    counts_rates;                    /* the error of velocities is kept within the tolerance, too; not where bodies vibrate, or velocities
                                              * decay, faster than the steps, which damp them */
    bool    alpha;                           /* generalised alpha; the following are its own */
    double  beta, gamma, am, af, power_old;
    double  slip;                            /* least speed of friction [1/s], of a slip of the unit of length; infinite: none */
    double  added;                           /* sum of the errors of all steps */
    double *aux, *aux_x;                     /* (n) auxiliary accelerations, (n_x) second rates of states, at t */
    double  rate_refused;                    /* error of velocities of the step refused before this one; 0: none */
    int     n_rounded;                       /* shorter steps one after the other that have not lowered it */
    double  contraction;                     /* of Newton's method in the last step: the greatest */
    double  h_factored;                      /* the step of the factored matrices; 0: none */
    long    since;                           /* steps with the present history; 0: none */
    bool    dense;                           /* samples lie within steps */
    bool    may_leave, goes_back, leaves;    /* for index1; the run came from there; it leaves now */
    int     n_watched, watch;                /* steps since watched_t; steps whose mean length decides */
    double  watched_t, explicit_step;        /* step of an explicit method; 0: not known */
    double  fastest;                         /* the fastest decay or vibration where it had that length */
    double *side;                            /* (3 n_switch) sides of the switches: at the start of the step, within it, before the last one passed */
    double  across;                          /* time in which that one was passed */
} stages;

/* x (n): A x = b, A by columns, overwritten. */
static void solve_small(int n, double *A, double *b)
{
    double diag[2*MOST_STAGES];
    lw_qr_factor(n, n, A, diag);
    lw_qr_solve(n, n, A, diag, b);
}

/* The eigenvector u + iv of A^-1 for re + i im, whose last number is 1. */
static void find_eigenvector(const stages *g, double re, double im, double *u, double *v)
{
    int m = g->s - 1, n = 2*m;
    double A[4*MOST_STAGES*MOST_STAGES], b[2*MOST_STAGES];
    for (int i = 0; i < m; i++) {
        b[i] = -g->w[i][m], b[m + i] = 0;
        for (int j = 0; j < m; j++) {
            A[i + n*j] = A[m + i + n*(m + j)] = g->w[i][j] - (i == j ? re : 0);
            A[i + n*(m + j)] = i == j ? im : 0;
            A[m + i + n*j] = i == j ? -im : 0;
        }
    }
    solve_small(n, A, b);
    for (int i = 0; i < m; i++)
        u[i] = b[i], v[i] = b[m + i];
    u[m] = 1, v[m] = 0;
}

/* Stages at the places c: their polynomials through 0 and all c give A^-1, collocation the weights; the error estimate adds a
 * stage at 0 with the weight 1/w_real, which leaves one order less. */
static void set_method(stages *g)
{
    const int s = g->s = g->way->stages;
    double x[MOST_STAGES + 1] = { 0 }, u[MOST_STAGES], v[MOST_STAGES], A[2][MOST_STAGES*MOST_STAGES];
    memcpy(x + 1, g->way->at, (size_t)(s - 1)*sizeof *x);
    x[s] = 1;
    memcpy(g->at, x + 1, (size_t)s*sizeof *x);
    for (int i = 1; i <= s; i++)
        for (int j = 1; j <= s; j++) {       /* slope at x_i of the polynomial that is 1 at x_j and 0 at the others */
            double at_j = 1, at_i = 1, sum = 0;
            for (int k = 0; k <= s; k++) {
                at_j *= k == j ? 1 : x[j] - x[k];
                at_i *= k == j || k == i ? 1 : x[i] - x[k];
                sum += k == j ? 0 : 1/(x[j] - x[k]);
            }
            g->w[i - 1][j - 1] = i == j ? sum : at_i/at_j;
        }
    for (int q = 0; q < s; q++) {
        for (int j = 0; j < s; j++)
            A[0][q + s*j] = A[1][q + s*j] = pow(g->at[j], q);
        g->weight[q] = 1.0/(q + 1);
        u[q] = q ? 0 : -1/g->way->real;
    }
    solve_small(s, A[0], g->weight);
    solve_small(s, A[1], u);
    for (int j = 0; j < s; j++) {
        g->error[j] = 0;
        for (int i = 0; i < s; i++)
            g->error[j] += u[i]*g->w[i][j];
    }
    for (int k = 0; k < s; k += k ? 2 : 1) {
        const double *pair = g->way->pair[k ? (k - 1)/2 : 0];
        find_eigenvector(g, k ? pair[0] : g->way->real, k ? pair[1] : 0, u, v);
        for (int i = 0; i < s; i++) {
            g->T[i][k] = u[i];
            if (k)
                g->T[i][k + 1] = -v[i];
        }
    }
    for (int j = 0; j < s; j++) {
        for (int i = 0; i < s*s; i++)
            A[0][i] = g->T[i%s][i/s];
        for (int i = 0; i < s; i++)
            u[i] = i == j;
        solve_small(s, A[0], u);
        for (int i = 0; i < s; i++)
            g->TI[i][j] = u[i];
    }
}

static void set_alpha(stages *g, double rho)
{
    g->s = 1;
    g->at[0] = g->weight[0] = g->T[0][0] = g->TI[0][0] = 1;
    g->am = (2*rho - 1)/(rho + 1);
    g->af = rho/(rho + 1);
    g->gamma = 0.5 + g->af - g->am;
    g->beta = 0.25*(0.5 + g->gamma)*(0.5 + g->gamma);
}

/* Auxiliary acceleration, or second rate of a state, at the end of the step that moves by z, from the rate v and the old one. */
static double auxiliary(const stages *g, double z, double v, double old)
{
    return (z/g->h - v)/(g->h*g->beta) - (0.5/g->beta - 1)*old;
}

/* Does the last step tell how this one goes?  Not if it was far shorter, as one that ended at a switch may be: rounding is magnified. */
static bool goes_on(const stages *g) { return g->since && g->h <= 10*g->h_old; }

/* The old auxiliary acceleration is that of a time am - af steps after t, so it changes with the length of steps. */
static double auxiliary_old(const stages *g, int i)
{
    return goes_on(g) ? g->a[i] + g->h/g->h_old*(g->aux[i] - g->a[i]) : g->a[i];
}

static void differentiate_alpha(stages *g)
{
    for (int i = 0; i < g->n; i++) {
        double old = auxiliary_old(g, i), now = auxiliary(g, g->z[i], g->v[i], old);
        g->vi[i] = g->v[i] + g->h*((1 - g->gamma)*old + g->gamma*now);
        g->ai[i] = ((1 - g->am)*now + g->am*old - g->af*g->a[i])/(1 - g->af);
    }
}

/* Velocities and accelerations of the stages from z. */
static void differentiate(stages *g)
{
    const lw_equations *eq = &g->run->d->eq;
    if (g->alpha) {
        differentiate_alpha(g);
        return;
    }
    for (int i = 0; i < g->n; i++)
        for (int k = 0; k < g->s; k++) {
            g->vi[k*g->n + i] = 0;
            for (int j = 0; j < g->s; j++)
                g->vi[k*g->n + i] += g->w[k][j]*g->z[j*g->n + i]/g->h;
        }
    for (int k = 0; k < g->s && eq->along; k++)
        eq->along(eq->context, g->z + k*g->n, g->vi + k*g->n);
    for (int i = 0; i < g->n; i++)
        for (int k = 0; k < g->s; k++) {
            g->ai[k*g->n + i] = 0;
            for (int j = 0; j < g->s; j++)
                g->ai[k*g->n + i] += g->w[k][j]*(g->vi[j*g->n + i] - g->v[i])/g->h;
        }
}

/* Rate of state i in stage k from its changes. */
static double state_rate(const stages *g, int k, int i)
{
    double rate = 0;
    if (g->alpha)
        return g->dx[i] + g->h*((1 - g->gamma)*g->aux_x[i] + g->gamma*auxiliary(g, g->zx[i], g->dx[i], g->aux_x[i]));
    for (int j = 0; j < g->s; j++)
        rate += g->w[k][j]*g->zx[j*g->n_x + i]/g->h;
    return rate;
}

/* Residuals r (3 (n + n_x + c)) of the stages. */
static lw_status residuals(stages *g)
{
    lw_dynamics *d = g->run->d;
    int n = g->n, first = n + g->n_x, all = first + g->c;
    differentiate(g);
    for (int k = 0; k < g->s; k++) {
        double *r = g->r + k*all, t = g->t + g->at[k]*g->h;
        memcpy(g->qi, g->q, (size_t)g->n_q*sizeof *g->qi);
        d->eq.move(d->eq.context, g->qi, g->z + k*n);
        lw_status s = lw_mbs_rows(d, t, g->qi);
        if (s != LW_OK)
            return s;
        for (int i = 0; i < g->n_x; i++)
            g->xi[i] = g->x[i] + g->zx[k*g->n_x + i];
        d->eq.place_states(d->eq.context, g->xi);
        d->eq.forces(d->eq.context, t, g->qi, g->vi + k*n, d->force, &g->power[k]);
        d->eq.state_rates(d->eq.context, t, g->qi, g->vi + k*n, g->xi);
        for (int i = 0; i < g->n_x; i++)
            r[n + i] = (state_rate(g, k, i) - g->xi[i])/g->scale[i];
        if (d->n_friction) {
            lw_tangent_spread(d, g->zl + k*g->c);
            g->power[k] += lw_mbs_rub(d, g->qi, g->vi + k*n, d->force);
        }
        for (int i = 0; i < n; i++)
            r[i] = d->eq.mass[i]*g->ai[k*n + i] - d->force[i];
        if (d->eq.more_inertia)
            d->eq.more_inertia(d->eq.context, g->qi, g->vi + k*n, g->ai + k*n, r);
        lw_tangent_push(d, g->zl + k*g->c, r);
        for (int i = 0; i < g->c; i++)
            r[first + i] = d->phi[d->kept[i]];
        for (int i = 0; i < d->n_driven; i++) {
            double motion[3];
            int place = d->place[d->n_row + i];
            if (lw_mbs_motion(d, i, t, motion) != LW_OK)
                return LW_E_NUMERIC;
            g->power[k] -= place >= 0 ? g->zl[k*g->c + place]*motion[1] : 0;
        }
        for (int i = 0; i < all; i++)
            if (!isfinite(r[i]))
                return LW_E_NUMERIC;
    }
    return LW_OK;
}

/* One simplified Newton step.  Returns the greatest change of a stage of q, or this share of the change of a state over its size or scale. */
static double newton_step(stages *g, double share)
{
    int n = g->n, first = n + g->n_x, all = first + g->c;
    for (int i = 0; i < all; i++)
        for (int a = 0; a < g->s; a++) {
            double sum = 0;
            for (int k = 0; k < g->s; k++)
                sum -= g->TI[a][k]*g->r[k*all + i];
            *(a ? &g->pair_b[(a - 1)/2*2*all + 2*i + (a - 1)%2] : &g->b[i]) = sum;
        }
    lw_tangent_solve(&g->real, g->b);
    for (int p = 0; p < g->s/2; p++)
        lw_tangent_solve(&g->pair[p], g->pair_b + 2*p*all);
    double most = 0;
    for (int i = 0; i < all; i++)
        for (int k = 0; k < g->s; k++) {
            double change = g->T[k][0]*g->b[i];
            for (int a = 1; a < g->s; a++)
                change += g->T[k][a]*g->pair_b[(a - 1)/2*2*all + 2*i + (a - 1)%2];
            if (i >= first) {
                g->zl[k*g->c + i - first] += change;
                continue;
            }
            *(i < n ? &g->z[k*n + i] : &g->zx[k*g->n_x + i - n]) += i < n ? change : change*g->scale[i - n];
            change *= i < n ? 1 : share/fmax(1, fabs(g->x[i - n])/g->scale[i - n]);
            most = fmax(most, fabs(change)) + (isfinite(change) ? 0 : INFINITY);
        }
    return most;
}

static void predict_alpha(stages *g)
{
    for (int i = 0; i < g->n; i++)
        g->z[i] = g->h*(g->v[i] + 0.5*g->h*auxiliary_old(g, i));
    for (int i = 0; i < g->n_x; i++)
        g->zx[i] = g->h*(g->dx[i] + 0.5*g->h*g->aux_x[i]);
    memcpy(g->zl, g->l, (size_t)g->c*sizeof *g->l);
}

/* The polynomials of the stages at `at` of the step: one is 1 at its stage and 0 at the others (l), and at 0 too (b). */
typedef struct polynomials { double b[MOST_STAGES], l[MOST_STAGES]; } polynomials;

static polynomials polynomials_at(const stages *g, double at)
{
    polynomials p = { .b = { 0 } };
    for (int j = 0; j < g->s; j++) {
        double value = 1;
        for (int i = 0; i < g->s; i++)
            value *= i == j ? 1 : (at - g->at[i])/(g->at[j] - g->at[i]);
        p.l[j] = value;
        p.b[j] = value*at/g->at[j];
    }
    return p;
}

/* First values of the stages: the polynomial of the last step, or constant velocity. */
static void predict(stages *g)
{
    int n = g->n, x = g->n_x, c = g->c, s = g->s;
    if (g->alpha) {
        predict_alpha(g);
        return;
    }
    bool goes = goes_on(g);
    for (int k = 0; k < s; k++) {
        polynomials p = polynomials_at(g, 1 + g->at[k]*g->h/(goes ? g->h_old : 1));
        for (int i = 0; i < n + x + c; i++) {
            const double *old = i < n ? g->last + i : i < n + x ? g->last_x + i - n : g->last_l + i - n - x;
            int size = i < n ? n : i < n + x ? x : c;
            double *to = i < n ? &g->z[k*n + i] : i < n + x ? &g->zx[k*x + i - n] : &g->zl[k*c + i - n - x];
            *to = i < n ? g->at[k]*g->h*g->v[i] : i < n + x ? g->at[k]*g->h*g->dx[i - n] : g->l[i - n - x];
            if (!goes)
                continue;
            *to = i < n + x ? -old[(s - 1)*size] : 0;
            for (int j = 0; j < s; j++)
                *to += (i < n + x ? p.b[j] : p.l[j])*old[j*size];
        }
    }
}

static const int most_newton = 10, most_rounded = 2;
static const double slip_part = 0.01;        /* of the least speed of friction, to which velocities are solved: friction of stages that are farther off
                                              * pushes with all its force */
static const double rounded = 1e-13;         /* changes below it that fall no more are rounding */

/* Steps of second order are short beside the time in which their errors die away, so errors add up: this part of the tolerance
 * gives errors of the size of those of Radau's method. */
static const double alpha_part = 0.1, alpha_energy = 10;     /* its energy is off by more than its places */

/* From this sum of the errors of all steps on, over the error allowed in one, the report says so. */
static const double added_most = 100;

static double tolerance(const stages *g)
{
    double most = 1;
    for (int i = 0; i < g->n_q; i++)
        most = fmax(most, fabs(g->q[i]));
    return (g->run->d->o.absolute + g->run->d->o.relative*fmin(most, 1))*(g->alpha ? alpha_part : 1);
}

/* Matrices for the step h, at the predicted posture of its middle stage: that at t would lag behind stiff links that turn. */
static lw_status factor(stages *g)
{
    lw_dynamics *d = g->run->d;
    const int k_mid = g->s/2;
    double t = g->t + g->at[k_mid]*g->h, *v = g->vi + k_mid*g->n, *l = g->zl + k_mid*g->c;
    differentiate(g);
    memcpy(g->qi, g->q, (size_t)g->n_q*sizeof *g->qi);
    d->eq.move(d->eq.context, g->qi, g->z + k_mid*g->n);
    lw_status s = lw_mbs_rows(d, t, g->qi);
    g->h_factored = 0;
    if (s != LW_OK)
        return s;
    if (g->alpha) {
        const double c[2] = { g->gamma/(g->beta*g->h) }, m[2] = { (1 - g->am)/((1 - g->af)*g->beta*g->h*g->h) };
        s = lw_tangent_factor(&g->real, t, g->qi, v, l, m, c);
    }
    for (int k = 0; s == LW_OK && !g->alpha && k <= g->s/2; k++) {
        double re = (k ? g->way->pair[k - 1][0] : g->way->real)/g->h, im = k ? g->way->pair[k - 1][1]/g->h : 0;
        const double c[2] = { re, im }, m[2] = { re*re - im*im, 2*re*im };
        s = lw_tangent_factor(k ? &g->pair[k - 1] : &g->real, t, g->qi, v, l, m, c);
    }
    if (s == LW_OK)
        g->h_factored = g->h;
    if (s == LW_E_MEMORY)
        return lw_error_set(g->run->e, s, "out of memory");
    return s == LW_E_NUMERIC ? LW_OPEN : s;
}

/* Newton's method from the predicted stages on, with the matrices at hand.  LW_OPEN: it does not converge. */
static lw_status iterate(stages *g)
{
    lw_dynamics *d = g->run->d;
    /* contacts of the stages may throw Newton's method far; whole turns away, it would find the posture again */
    double before = 0, wanted = 0.005*tolerance(g), share = 1, far = d->eq.next_piece ? 0.3 : 1e3;
    if (g->counts_rates || d->o.relative < 1e-9 || d->eq.n_switch) {     /* velocities too, which are differences of stages over h; rounding of rows is 2e-16 */
        share = fmin(1, fmax(g->h/g->way->real, 4e-16/wanted));
        wanted *= share;
    }
    wanted = fmin(wanted, slip_part*g->slip*g->h);
    g->contraction = 0;
    for (int pass = 0; pass < most_newton; pass++) {
        lw_status s = lw_run_busy(g->run, g->t);
        if (s == LW_OK)
            s = residuals(g);
        g->run->r->rates += g->s;
        if (s != LW_OK)
            return s == LW_E_NUMERIC ? LW_OPEN : s;
        double change = newton_step(g, share);
        if (!(change < far) || (pass > 1 && change > 2*before && change > rounded))
            return LW_OPEN;
        double ratio = pass ? change/fmax(before, 1e-300) : 1;
        g->contraction = fmax(g->contraction, pass ? ratio : 0);
        if (change <= 4e-16 || (pass > 0 && ratio < 1 && change*ratio/(1 - ratio) <= wanted)
            || (pass > 2 && change <= rounded && ratio > 0.3)) {
            differentiate(g);
            return LW_OK;
        }
        before = change;
    }
    return LW_OPEN;
}

/* Up to this contraction the matrices serve another step of the same length, unless the five stages of a small tolerance are to
 * keep the energy of stiff elements. */
static const double contraction_kept = 0.02;

/* Solve the stages.  LW_OPEN: Newton's method does not converge with this step. */
static lw_status solve_stages(stages *g)
{
    lw_dynamics *d = g->run->d;
    bool kept = g->s < 5 && fabs(g->h - g->h_factored) <= 1e-9*g->h && g->contraction <= contraction_kept;
    d->eq.place_states(d->eq.context, g->x);
    predict(g);
    lw_status s = kept ? iterate(g) : LW_OPEN;
    if (kept && s == LW_OPEN)
        predict(g);
    if (s == LW_OPEN && (s = factor(g)) == LW_OK)
        s = iterate(g);
    return s;
}

/* Right-hand side, in b, for the errors of the step by the embedded formula of order s. */
static void embedded_error(stages *g)
{
    int n = g->n;
    double w = g->way->real/g->h;
    for (int i = 0; i < n; i++) {
        double eq = g->v[i]/w, ev = g->a[i]/w;
        for (int k = 0; k < g->s; k++) {
            eq += g->error[k]*g->z[k*n + i];
            ev += g->error[k]*(g->vi[k*n + i] - g->v[i]);
        }
        g->e[i] = eq;
        g->r[i] = w*w*eq + w*ev;
    }
    lw_tangent_mass_filled(&g->real, g->r, g->b);
    for (int i = 0; i < g->n_x; i++) {
        double e = g->dx[i];
        for (int k = 0; k < g->s; k++)
            e += w*g->error[k]*g->zx[k*g->n_x + i];
        g->b[n + i] = e/g->scale[i];
    }
    lw_tangent_damp(&g->pair[0], w, g->e, g->b);
}

/* out += by C e, from the derivatives of the forces, C = -dQ/dv.  (The matrix of generalised alpha is real and does not tell C apart,
 * as lw_tangent_damp needs it.) */
typedef struct damping { double by; const double *e; double *out; } damping;

static void add_damping(void *context, int row, int column, double by_q, double by_v)
{
    damping *c = context;
    (void)by_q;
    c->out[row] -= c->by*by_v*c->e[column];
}

/* The same of generalised alpha: h^3 v'' (beta + (am - af)/2 - 1/6), where the change of a is h v''. */
static void alpha_error(stages *g)
{
    lw_dynamics *d = g->run->d;
    double part = g->beta + 0.5*(g->am - g->af) - 1.0/6, weight = (1 - g->am)/((1 - g->af)*g->beta);
    for (int i = 0; i < g->n; i++) {
        double old = auxiliary_old(g, i), change = part*(auxiliary(g, g->z[i], g->v[i], old) - old);
        g->e[i] = g->h*g->h*change;
        g->r[i] = weight*change;
    }
    lw_tangent_mass_filled(&g->real, g->r, g->b);
    for (int i = 0; i < g->n_x; i++)
        g->b[g->n + i] = g->gamma/g->beta*part*g->h*(auxiliary(g, g->zx[i], g->dx[i], g->aux_x[i]) - g->aux_x[i])/g->scale[i];
    damping c = { g->gamma/(g->beta*g->h), g->e, g->b };
    if (!d->eq.conservative)
        d->eq.derivatives(d->eq.context, g->t + g->h, g->qi, g->vi, d->force, &(lw_force_sink){ .context = &c, .add = add_damping });
}

/* Error in b filtered by the real matrix, over the tolerance. */
static double filter_error(stages *g)
{
    int n = g->n;
    double most = 0;
    memset(g->b + n + g->n_x, 0, (size_t)g->c*sizeof *g->b);
    lw_tangent_solve(&g->real, g->b);
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(g->b[i]));
    for (int i = 0; i < g->n_x; i++)
        most = fmax(most, fabs(g->b[n + i])/fmax(1, fabs(g->x[i])/g->scale[i]));
    return most/tolerance(g);
}

/* Error of the velocities, over the tolerance: w (e - E), e the filtered error of places and E the same before the filter, w the real eigenvalue
 * over h.  A second filter takes away what the constraints do not let happen and what vibrates faster than the steps.  *rounding gets what
 * rounding of the stages may make of it; of that a few times the tolerance do not count. */
static double rate_error(stages *g, double *rounding)
{
    const double w = g->way->real/g->h, allowed = tolerance(g);
    double most = 0;
    *rounding = 4*DBL_EPSILON*w/allowed;
    for (int i = 0; i < g->n; i++)
        g->r[i] = w*w*w*(g->e[i] - g->b[i]);
    lw_tangent_mass_filled(&g->real, g->r, g->b);
    memset(g->b + g->n, 0, (size_t)(g->n_x + g->c)*sizeof *g->b);
    lw_tangent_solve(&g->real, g->b);
    for (int i = 0; i < g->n; i++)
        most = fmax(most, (fabs(g->b[i])/allowed - fmin(*rounding, 3))/(1 + fabs(g->v[i])));
    return most;
}

/* Error of the step, over the tolerance.  States that decay within the step begin it a little off, since velocities were projected; a second
 * filter takes away what has died away by its end (Hairer & Wanner 1996, eq. IV.8.20). */
static double error_of(stages *g)
{
    if (g->alpha)
        alpha_error(g);
    else
        embedded_error(g);
    double error = filter_error(g);
    if (error > 1 && !g->alpha && g->n_x) {
        memcpy(g->xi, g->b + g->n, (size_t)g->n_x*sizeof *g->xi);
        embedded_error(g);
        for (int i = 0; i < g->n_x; i++)
            g->b[g->n + i] = g->way->real/g->h*g->xi[i];
        error = filter_error(g);
    }
    if (!g->counts_rates)
        return error;
    double rounding, rate = rate_error(g, &rounding);
    g->n_rounded = rate > 1 && rate < rounding && g->rate_refused > 0 && rate > 0.9*g->rate_refused ? g->n_rounded + 1 : 0;
    g->rate_refused = rate > 1 ? rate : 0;
    return fmax(error, rate);
}

/* Posture of the polynomial through the stages at a part of the step, in g->qi. */
static void place_within(stages *g, double part)
{
    double *by = g->e;
    polynomials p = polynomials_at(g, part);
    for (int i = 0; i < g->n; i++)
        by[i] = 0;
    for (int j = 0; j < g->s; j++)
        for (int i = 0; i < g->n; i++)
            by[i] += p.b[j]*g->z[j*g->n + i];
    memcpy(g->qi, g->q, (size_t)g->n_q*sizeof *g->qi);
    g->run->d->eq.move(g->run->d->eq.context, g->qi, by);
}

static double piece_left_within(stages *g, double part)
{
    const lw_equations *eq = &g->run->d->eq;
    place_within(g, part);
    return eq->piece_left(eq->context, g->qi);
}

/* The part of the step at which a piece of the forces ends, just beyond its end; 1: none does before the end of the step. */
static double piece_end(stages *g)
{
    double low = 0, high = 1;
    bool ends = false;
    for (int k = 0; k < g->s && !ends; k++) {
        high = g->at[k];
        ends = piece_left_within(g, high) < 0;
        low = ends ? low : high;
    }
    for (int pass = 0; ends && pass < 60 && high - low > 1e-12; pass++) {
        double middle = 0.5*(low + high);
        *(piece_left_within(g, middle) < 0 ? &high : &low) = middle;
    }
    return ends ? high : 1;
}

/* Has a switch another side at `part` of the step than at its start? */
static bool switched(stages *g, double part)
{
    const lw_equations *eq = &g->run->d->eq;
    double *now = g->side + eq->n_switch, *v = g->e;
    bool other = false;
    place_within(g, part);
    polynomials p = polynomials_at(g, part);
    double first = 1;
    for (int j = 0; j < g->s; j++)
        first -= p.b[j];
    for (int i = 0; i < g->n; i++) {
        v[i] = first*g->v[i];
        for (int j = 0; j < g->s; j++)
            v[i] += p.b[j]*g->vi[j*g->n + i];
    }
    for (int i = 0; i < g->n_x; i++) {
        g->xi[i] = g->x[i];
        for (int j = 0; j < g->s; j++)
            g->xi[i] += p.b[j]*g->zx[j*g->n_x + i];
    }
    eq->place_states(eq->context, g->xi);
    eq->switches(eq->context, g->t + part*g->h, g->qi, v, g->r, now);
    for (int i = 0; i < eq->n_switch; i++)
        other = other || lw_kinks_crossed(g->run->kinks, i, g->side[i], now[i], g->h);
    return other;
}

static const double least_jump = 1e-9;       /* of forces, in parts of the greatest so far */

/* The last part of the step before a switch changes, and in *beyond the first one behind; 1: none does. */
static double switch_within(stages *g, double *beyond)
{
    const lw_equations *eq = &g->run->d->eq;
    double low = 0, high = 1;
    bool ends = false;
    eq->place_states(eq->context, g->x);
    eq->switches(eq->context, g->t, g->q, g->v, g->r, g->side);
    for (int k = 0; k < g->s && !ends; k++) {
        high = g->at[k];
        ends = switched(g, high);
        low = ends ? low : high;
    }
    for (int pass = 0; ends && pass < 60 && high - low > 1e-15; pass++) {
        double middle = 0.5*(low + high);
        *(switched(g, middle) ? &high : &low) = middle;
    }
    *beyond = high;
    double jump = 0;
    bool stop = false;                       /* a stop begins or ends to push; where sign() and mod() change, forces need not
                                              * jump: sign(v)*v^2 does not */
    if (ends && eq->n_jump) {
        switched(g, low);
        memcpy(g->b, g->r, (size_t)g->n*sizeof *g->b);
        switched(g, high);
        for (int i = 0; i < g->n; i++)
            jump = fmax(jump, fabs(g->r[i] - g->b[i]));
        for (int i = 0; i < eq->n_switch - eq->n_jump; i++)
            stop = stop || lw_kinks_crossed(g->run->kinks, i, g->side[i], g->side[eq->n_switch + i], g->h);
    }
    return ends && (!eq->n_jump || stop || jump > least_jump*g->run->most_force) ? low : 1;
}

static double *state(stages *g, double *y)
{
    memcpy(y, g->q, (size_t)g->n_q*sizeof *y);
    memcpy(y + g->n_q, g->v, (size_t)g->n*sizeof *y);
    if (g->run->has_work)
        y[g->n_q + g->n] = g->work;
    memcpy(y + lw_run_states(g->run), g->x, (size_t)g->n_x*sizeof *y);
    return y;
}

/* The work done in the step, and to *off how far a coarser sum is from it: by trapeziums, and of generalised alpha with the first power. */
static double work_of(const stages *g, double *off)
{
    double work = 0, coarse = 0, at = 0, power = g->power_old;
    for (int k = 0; k < g->s; k++) {
        work += g->h*g->weight[k]*(g->alpha ? 0.5*(g->power_old + g->power[k]) : g->power[k]);
        coarse += g->alpha ? g->h*power : 0.5*g->h*(g->at[k] - at)*(power + g->power[k]);
        at = g->at[k], power = g->power[k];
    }
    *off = fabs(work - coarse);
    return work;
}

/* Posture and velocities at the end t of the step, on the constraints, into the state `ahead`; LW_OPEN: the energy has changed by more than
 * the step's error.  So it does where motion turns quickly, as a crank of little mass does at its dead point: places hardly
 * change in a step that is short enough, but velocities do.  Elastic links lose the energy of vibrations that are faster than the steps. */
static lw_status end_state(stages *g, double t)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    double *q = g->ahead, *v = q + g->n_q, off;
    if (d->eq.next_piece && residuals(g) != LW_OK)       /* the power of stiff contacts, at the last iterate */
        return LW_E_NUMERIC;
    memcpy(q, g->q, (size_t)g->n_q*sizeof *q);
    memcpy(v, g->vi + (g->s - 1)*g->n, (size_t)g->n*sizeof *v);
    d->eq.move(d->eq.context, q, g->z + (g->s - 1)*g->n);
    double before = lw_run_energy(run, state(g, run->y)), work = work_of(g, &off);
    lw_status s = lw_mbs_settle(d, t, q, v);
    g->weak = d->by_rank ? 1 : d->weak;
    if (run->has_work)
        v[g->n] = g->work + work;
    if (s != LW_OK || d->elastic || d->eq.next_piece)
        return s;
    return fabs(lw_run_energy(run, g->ahead) - before) <= lw_run_energy_error(run, g->alpha ? alpha_energy : 1, g->ahead, g->e) + off ? LW_OK : LW_OPEN;
}

/* Take accelerations, multipliers, rates of states and the power from the equations at the present state. */
static lw_status take_rates(stages *g)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    double *rate = run->y + run->n;
    lw_status s = lw_run_rate(run, g->t, state(g, run->y), rate);
    if (s != LW_OK)
        return s;
    memcpy(g->a, rate + g->n_q, (size_t)g->n*sizeof *g->a);
    memcpy(g->dx, rate + lw_run_states(run), (size_t)g->n_x*sizeof *g->dx);
    for (int k = 0; k < g->c; k++)
        g->l[k] = d->l[d->kept[k]];
    g->power_old = run->has_work ? rate[g->n_q + g->n] : 0;
    return LW_OK;
}

/* Forces of contacts have peaks within steps: look at all stages but the last. */
static void watch_stages(stages *g)
{
    const lw_equations *eq = &g->run->d->eq;
    for (int k = 0; eq->watch && k + 1 < g->s; k++) {
        memcpy(g->qi, g->q, (size_t)g->n_q*sizeof *g->qi);
        eq->move(eq->context, g->qi, g->z + k*g->n);
        eq->watch(eq->context, g->t + g->at[k]*g->h, g->qi, g->vi + k*g->n, false);
    }
}

/* Take the stages as the step to t, and `ahead` as its end.  error: over the tolerance. */
static void accept(stages *g, double t, double error)
{
    lw_dynamics *d = g->run->d;
    int n = g->n;
    double off;
    for (int i = 0; i < n && g->alpha; i++)
        g->aux[i] = auxiliary(g, g->z[i], g->v[i], auxiliary_old(g, i));
    g->work += work_of(g, &off);
    memcpy(g->q, g->ahead, (size_t)g->n_q*sizeof *g->q);
    for (int i = 0; i < n; i++) {
        g->v_old[i] = g->v[i];
        g->v[i] = g->ahead[g->n_q + i];
        g->a[i] = g->ai[(g->s - 1)*n + i];
    }
    for (int i = 0; i < g->n_x; i++) {
        double rate = state_rate(g, g->s - 1, i);
        if (g->alpha)
            g->aux_x[i] = auxiliary(g, g->zx[i], g->dx[i], g->aux_x[i]);
        g->x[i] += g->zx[(g->s - 1)*g->n_x + i];
        g->dx[i] = rate;
    }
    memcpy(g->last_x, g->zx, (size_t)g->s*(size_t)g->n_x*sizeof *g->zx);
    memcpy(g->l, g->zl + (g->s - 1)*g->c, (size_t)g->c*sizeof *g->l);
    memcpy(g->last, g->z, (size_t)g->s*(size_t)n*sizeof *g->z);
    memcpy(g->last_l, g->zl, (size_t)g->s*(size_t)g->c*sizeof *g->zl);
    g->power_old = g->power[g->s - 1];
    g->h_old = g->h;
    g->t = t;
    g->since++;
    if (g->counts_rates)                     /* differences of velocities over a short step are rounding */
        take_rates(g);
    if (d->eq.accept)
        d->eq.accept(d->eq.context, g->q);
    if (d->eq.keep_momenta)
        d->eq.keep_momenta(d->eq.context, t, g->q, g->v, d->hold);
    g->added += error*tolerance(g);
    g->run->r->added = g->alpha && g->added > added_most*(d->o.relative + d->o.absolute) ? g->added : 0;
    g->run->r->steps++;
    g->run->r->t = t;
}

/* ---- the run ------------------------------------------------------------------------------------------------- */

static lw_status show(stages *g)
{
    lw_dynamics *d = g->run->d;
    memcpy(d->a, g->a, (size_t)g->n*sizeof *d->a);       /* of the stages: those of the state magnify its error by stiffness */
    lw_tangent_spread(d, g->l);
    double t = lw_run_time(d, g->run->next++);           /* a kink there may be passed already */
    if (!d->eq.more_inertia && lw_mbs_rows(d, t, g->q) == LW_OK && lw_mbs_factor(d, false) == LW_OK
        && lw_mbs_acceleration_wanted(d, t, g->v) == LW_OK)
        lw_mbs_refine(d, d->a, d->l);                    /* places of the stages meet the rows, their accelerations need not */
    return lw_run_show_solved(g->run, t, g->run->y);
}

/* State at t, a time within the last step, by the polynomials through its stages. */
static lw_status state_at(void *context, double t, double *y)
{
    stages *g = context;
    int n = g->n, s = g->s;
    double at = 1 + (t - g->t)/g->h_old, w[MOST_STAGES*MOST_STAGES], work[MOST_STAGES], v_by[MOST_STAGES] = { 0 }, first = 1;
    polynomials p = polynomials_at(g, at);
    state(g, y);
    if (at >= 1)
        return LW_OK;
    for (int k = 0; k < s; k++) {
        work[k] = g->h_old*g->power[k];
        first -= p.b[k];
        for (int j = 0; j < s; j++) {
            w[j*s + k] = g->w[k][j];
            v_by[j] += (p.b[k] - (k == s - 1))*g->w[k][j]/g->h_old;
        }
    }
    solve_small(s, w, work);
    for (int i = 0; i < n; i++)
        y[n + i] += first*g->v_old[i];
    for (int j = 0; j < s; j++) {
        double by = p.b[j] - (j == s - 1);
        for (int i = 0; i < n; i++) {
            y[i] += by*g->last[j*n + i];
            y[n + i] += v_by[j]*g->last[j*n + i];
        }
        y[2*n] += g->run->has_work ? by*work[j] : 0;
        for (int i = 0; i < g->n_x; i++)
            y[lw_run_states(g->run) + i] += by*g->last_x[j*g->n_x + i];
    }
    return lw_run_correct(g->run, t, y);
}

/* A step towards the next sample (dense: the end) or kink: as long as h, or evenly divided where few steps remain.  A sample just behind an end that
 * is no kink is taken instead of it. */
static double next_step(const stages *g, double h, double *end)
{
    *end = lw_run_near(g->run, g->t);
    if (!g->alpha)
        *end = fmin(lw_run_end(g->run, g->t), g->t + (g->s - 2)*(*end - g->t));
    double sample = g->dense ? INFINITY : lw_run_time(g->run->d, g->run->next);
    if (sample < *end || (sample - *end <= 1e-9*(*end - g->t) && !lw_run_at_kink(g->run, *end)))
        *end = sample;
    double left = *end - g->t;
    if (left <= h*(1 + 1e-9))
        return left;
    *end = 0;
    return left < 2*h ? 0.5*left : h;
}

/* ---- where vibrations stay ----------------------------------------------------------------------------------- */

/* Vibrations that are not damped can ask for steps as short as those of an explicit method, which cost less.  Then the run goes on
 * by index1.
 * WATCHED, WATCHED_BACK: steps whose mean length decides; in a run that came from index1, then twice as many each time.  explicit_angle: steps of
 * the explicit method times the greatest frequency (measured: 4.4 to 5) or the fastest decay (6).  cost: of a step of radau, of 3 and of 5 stages,
 * over that of an explicit one (1.4 and 2.3 to 3.2 of 51 coordinates).  looser: with this multiple of the tolerance index1 is still more accurate,
 * because its steps are short for stability. */
enum { WATCHED = 32, WATCHED_BACK = 12 };
static const double explicit_angle = 4.5, cost[2] = { 1.3, 2.4 }, looser = 10;

static double fastest(stages *g)
{
    lw_dynamics *d = g->run->d;
    lw_tangent_spread(d, g->l);
    d->eq.place_states(d->eq.context, g->x);
    return fmax(sqrt(lw_mbs_fastest(d, g->t, g->q, g->v, false, false)), lw_mbs_fastest_decay(d, g->t, g->q, g->v, d->n_friction > 0));
}

/* Do the last steps cost more than explicit ones would? */
static bool is_slower(stages *g)
{
    lw_dynamics *d = g->run->d;
    double mean = (g->t - g->watched_t)/g->watch, row = (d->o.to - d->o.from)/fmax(1, d->o.intervals);
    if (!g->may_leave || ++g->n_watched < g->watch)
        return false;
    g->n_watched = 0;
    g->watched_t = g->t;
    if (!g->dense && mean > 0.5*row)         /* rows make them short */
        return false;
    if (!(g->explicit_step > 0))
        g->explicit_step = explicit_angle/fastest(g);
    double step = g->goes_back ? g->explicit_step*g->fastest/fastest(g) : g->explicit_step;
    return mean < cost[g->s > 3]*step && (step < INFINITY || g->goes_back);
}

/* Go on by index1 to the end.  LW_OK: done, or it cannot; samples that it handed out stay. */
static lw_status leave(stages *g)
{
    lw_run *run = g->run;
    lw_dynamics_options *o = &run->d->o;
    const lw_dynamics_options was = *o;
    o->relative *= looser;
    o->absolute *= looser;
    run->r->t = g->t;
    lw_status s = lw_run_go_on(run, run->y);
    o->relative = was.relative;
    o->absolute = was.absolute;
    g->may_leave = false;
    if (s == LW_E_NUMERIC && !run->refused) {
        run->e->text[0] = '\0';
        return LW_OK;
    }
    run->r->formulation = LW_FORMULATION_INDEX1;
    snprintf(run->r->why, sizeof run->r->why, "radau to t = %.3g s, where vibrations made its steps as short as those of the explicit "
             "method, which cost less", g->t);
    return s;
}

/* As at the start and behind a kink of the loads. */
static lw_status begin_again(stages *g)
{
    memset(g->aux_x, 0, (size_t)g->n_x*sizeof *g->aux_x);
    g->since = 0;
    lw_status s = take_rates(g);
    memcpy(g->aux, g->a, (size_t)g->n*sizeof *g->a);
    return s;
}

/* Of an overconstrained model the rows kept can become dependent while the joints do not: choose others then. */
static lw_status rechoose(stages *g)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    if (d->n_c == d->rank || g->t >= d->o.to)
        return LW_OK;
    lw_status s = lw_mbs_rows(d, g->t, g->q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    double weak = s == LW_OK ? d->weak : 0;
    if (s == LW_OK || s == LW_OPEN)
        s = lw_run_rechoose(run, g->t, state(g, run->y), &weak);
    if (s == LW_E_NUMERIC && !run->e->text[0])
        return lw_error_set(run->e, s, "at t = %.9g s the linkage reaches a singular posture, where more of its constraints depend on others", g->t);
    if (s != LW_OK)
        return s == LW_NOTHING ? LW_OK : s;
    s = lw_tangent_renew(d, false, false, &g->real);
    for (int k = 0; s == LW_OK && k < g->s/2; k++)
        s = lw_tangent_renew(d, true, false, &g->pair[k]);
    g->real.rubs = g->pair[0].rubs = g->pair[1].rubs = d->n_friction > 0;
    return s == LW_OK ? begin_again(g) : lw_error_set(run->e, s, "out of memory");
}

/* Pass through the singular posture ahead, if there is one, and begin again behind it. */
static lw_status pass_singular(stages *g)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    double t = g->t, *y = state(g, g->ahead);
    if (d->large || d->elastic || d->eq.next_piece || t >= d->o.to)
        return LW_OK;
    lw_status s = lw_run_singular_crossing(run, g->weak, NULL, &t, y);
    if (s == LW_OK)
        s = lw_run_project(run, t, y);
    if (s != LW_OK)
        return s == LW_NOTHING ? LW_OK : s;
    memcpy(g->q, y, (size_t)g->n_q*sizeof *y);
    memcpy(g->v, y + g->n_q, (size_t)g->n*sizeof *y);
    memcpy(g->x, y + lw_run_states(run), (size_t)g->n_x*sizeof *y);
    g->work = run->has_work ? y[g->n_q + g->n] : 0;
    g->t = t;
    return t < d->o.to ? begin_again(g) : LW_OK;
}

/* Hand out the samples of the last step, and begin again behind a kink. */
static lw_status end_step(stages *g)
{
    lw_run *run = g->run;
    bool kink = lw_run_at_kink(run, g->t);
    lw_status s = LW_OK;
    if (kink)
        s = lw_run_pass_kink(run, &g->t, g->dense ? state_at : NULL, g);
    else if (g->dense)
        s = lw_run_samples(run, g->t, state_at, g);
    bool sample = !g->dense && run->next <= run->d->o.intervals && g->t >= lw_run_time(run->d, run->next), goes_on = g->t < run->d->o.to;
    if (s == LW_OK && sample && !kink)
        s = show(g);
    if (s == LW_OK && kink && goes_on)                   /* motions that change their speed at once push */
        s = lw_mbs_settle(run->d, g->t, g->q, g->v);
    if (s == LW_OK && sample && kink)                    /* stages have the accelerations before it */
        s = lw_run_show(run, lw_run_time(run->d, run->next++), state(g, run->y));
    return s == LW_OK && kink && goes_on ? begin_again(g) : s;
}

/* A step to the end of a piece may end so far beyond it (equations.h, piece_left), and is not shorter than this part of an
 * ordinary one, because differences of places over the length of a step are velocities. */
static const double beyond_most = 1e-3, least_part = 1e-3;

/* A switch so near, in parts of an ordinary step, is passed with the acceleration before it. */
static const double beside_switch = 1e-5;

/* Forces jump where a damped stop is touched.  A step over it would not see its error in the velocities, which is of first order.  So a
 * step ends just before a switch, and the next one begins just behind it.  Returns the length of the step to take instead of the present
 * one; 0: the present one has no switch; < 0: the switch has been passed, begin the next step.  h: length of an ordinary step; limit:
 * time that a step may not pass; passed: the step before this one ended so. */
static double step_to_switch(stages *g, double h, double limit, bool passed)
{
    lw_dynamics *d = g->run->d;
    double beyond, part = switch_within(g, &beyond), near = beside_switch*h;
    if (part == 1)
        return 0;
    if (part*g->h > near)
        return part*g->h - 0.3*near;
    double across = beyond*g->h + 1e-5*near;
    if (passed || across > 2*near || g->t + across >= limit)
        return 0;
    memcpy(g->side + 2*d->eq.n_switch, g->side, (size_t)d->eq.n_switch*sizeof *g->side);
    g->across = across;
    for (int i = 0; i < g->n; i++) {
        g->e[i] = across*(g->v[i] + 0.5*across*g->a[i]);
        g->v[i] += across*g->a[i];
    }
    d->eq.move(d->eq.context, g->q, g->e);
    for (int i = 0; i < g->n_x; i++)
        g->x[i] += across*g->dx[i];
    g->work += across*g->power_old;
    g->t += across;
    return -1;
}

/* Do the forces behind a jump that was just passed push the motion back over it, within the time in which it was passed?  Then it slides along
 * the jump.  Steps of generalised alpha would go on to and fro, off by the order of a step, without an error that its estimate sees. */
static bool is_pushed_back(stages *g)
{
    const lw_equations *eq = &g->run->d->eq;
    double *ahead = g->side, *behind = ahead + eq->n_switch, *before = behind + eq->n_switch, h = g->across;
    bool back = false;
    eq->place_states(eq->context, g->x);
    eq->switches(eq->context, g->t, g->q, g->v, g->r, behind);
    for (int i = 0; i < g->n; i++) {
        g->e[i] = h*(g->v[i] + 0.5*h*g->a[i]);
        g->b[i] = g->v[i] + h*g->a[i];
    }
    memcpy(g->qi, g->q, (size_t)g->n_q*sizeof *g->qi);
    eq->move(eq->context, g->qi, g->e);
    eq->switches(eq->context, g->t + h, g->qi, g->b, g->r, ahead);
    for (int i = eq->n_switch - eq->n_jump; i < eq->n_switch; i++)
        back = back || ((before[i] > 0) != (behind[i] > 0) && (ahead[i] > 0) == (before[i] > 0));
    return back;
}

/* Where Newton's method does not converge: the next step over that one, the limit that it sets for later steps over it, and the growth of
 * that limit with each later step. */
static const double shorter = 0.3, less = 0.7, relax = 1.1;

typedef struct trial { double h, error; } trial;

/* The part of a refused step to try, from the order that it and the refused one before it show (Gustafsson 1991): the error of vibrations
 * faster than the steps falls more slowly than the order of the method says, or not at all. */
static double shorter_after(trial before, trial now)
{
    if (!(before.h > now.h))
        return 1;
    double order = log(before.error/now.error)/log(before.h/now.h);
    return 0.9*pow(now.error, -1/fmax(order, 0.1));
}

/* Has the step become too short, for rounding or for the motion? */
static lw_status check_length(const stages *g)
{
    const lw_dynamics_options *o = &g->run->d->o;
    if (g->n_rounded == most_rounded)
        return lw_error_set(g->run->e, LW_E_NUMERIC, "at t = %.9g s velocities are less accurate than the tolerance, by rounding: shorter steps do not "
                            "help near a singular posture, or with masses of very different size", g->t);
    if (!(g->h > fmax(1e-14*fabs(g->t), 1e-30*(o->to - o->from))))
        return lw_error_set(g->run->e, LW_E_NUMERIC, "at t = %.9g s the steps become too short: the motion jumps, an elastic link buckles, "
                            "velocities change at once, as where a light crank passes its dead point, or the tolerance is below rounding", g->t);
    return LW_OK;
}

/* Begin again just behind a switch. */
static lw_status go_on_behind_switch(stages *g)
{
    lw_status s = lw_run_jumps(g->run, g->t, state(g, g->run->y));
    if (s == LW_OK)
        s = begin_again(g);
    return s == LW_OK && g->alpha && is_pushed_back(g) ? lw_run_slides(g->run, g->t) : s;
}

/* After a step: what it passed, its samples, and whether radau goes on. */
static lw_status after_step(stages *g)
{
    lw_run *run = g->run;
    lw_run_watch(run, state(g, run->y));
    lw_status s = lw_run_jumps(run, g->t, run->y);
    if (s == LW_OK)
        s = end_step(g);
    if (s == LW_OK)
        s = lw_run_limits(run, g->t, 0);
    if (s == LW_OK)
        s = rechoose(g);
    if (s == LW_OK)
        s = pass_singular(g);
    if (s == LW_OK && run->next <= run->d->o.intervals && is_slower(g)) {
        g->leaves = g->goes_back;
        s = g->leaves ? LW_NOTHING : leave(g);
    }
    return s;
}

static lw_status run_steps(stages *g)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    double h = g->h, end, error_old = 1;
    double most = INFINITY;                              /* limit of h, for Newton's method */
    trial refused = { 0 };                               /* just before this one */
    double to_piece = 0, to_switch = 0;                  /* steps to the end of a piece, to a switch; 0: none */
    bool passed = false;                                 /* a switch just before this step */
    lw_status s = LW_OK;
    while (s == LW_OK && run->next <= d->o.intervals) {
        g->h = next_step(g, h, &end);
        double limit = g->t + g->h;
        if (to_piece > 0 || to_switch > 0)
            g->h = to_piece > 0 ? to_piece : to_switch, end = 0;
        s = check_length(g);
        if (s == LW_OK)
            s = solve_stages(g);
        if (s == LW_OPEN) {
            most = less*g->h;
            h = shorter*g->h;
            to_piece = to_switch = 0;
            run->r->refused++;
            g->since = 0;
            s = LW_OK;
            continue;
        }
        if (s != LW_OK)
            break;
        double error = fmax(error_of(g), 1e-6), root = -1.0/(g->alpha ? 3 : g->s + 1), factor = 0.9*pow(error, root);
        if (error > 1) {
            h = g->h*fmax(fmin(factor, shorter_after(refused, (trial){ g->h, error })), 0.2);
            refused = (trial){ g->h, error };
            to_piece = to_switch = 0;
            run->r->refused++;
            continue;
        }
        double other = d->eq.n_switch ? step_to_switch(g, h, limit, passed) : 0;
        passed = other < 0;
        to_switch = fmax(other, 0);
        if (passed)
            s = go_on_behind_switch(g);
        if (other != 0)
            continue;
        double part = d->eq.piece_left ? piece_end(g) : 1;
        if (part < 1 && !(to_piece > 0 && (piece_left_within(g, 1) > -beyond_most || to_piece <= least_part*h))) {
            to_piece = fmax(part*g->h, least_part*h);    /* once more, to where a piece of the forces ends */
            continue;
        }
        bool switches = to_piece > 0;
        to_piece = 0;
        if (g->since)                        /* Gustafsson's control */
            factor = fmin(factor, factor*g->h/g->h_old*pow(error/error_old, root));
        error_old = fmax(error, 1e-2);
        refused = (trial){ 0 };
        bool cut = g->h < 0.99*h;
        double t_end = end > 0 ? end : g->t + g->h;
        s = end_state(g, t_end);
        if (s == LW_OPEN) {
            h = shorter*g->h;
            run->r->refused++;
            s = LW_OK;
            continue;
        }
        if (s != LW_OK)
            break;
        watch_stages(g);
        accept(g, t_end, error);
        double next = g->h_old*fmin(fmax(factor, 0.2), g->contraction > 0.3 ? 1 : 8);
        h = fmin(cut ? fmax(h, next) : next, fmax(most, g->h_old));
        most *= relax;
        if (switches)
            d->eq.next_piece(d->eq.context, g->q, g->v, false);
        s = after_step(g);
    }
    return s;
}

/* Friction whose speed is no more than so many times the tolerance is a jump to the polynomials of a step; the fewer stages pass it in fewer steps. */
static const double jump = 30;

static bool high_order(const lw_dynamics *d, double slip)
{
    return (d->o.relative < 1e-7 || !(d->elastic || d->eq.next_piece)) && slip > jump*d->o.relative;
}

/* from: a state of the run at r->t, where explicit steps have the length *h; NULL: the run begins.  LW_NOTHING: as lw_run_radau_from. */
static lw_status run_implicit(lw_run *run, bool alpha, double *from, double *h)
{
    lw_dynamics *d = run->d;
    stages g = { .run = run, .alpha = alpha, .n = d->n_v, .n_q = d->n_q, .n_x = d->eq.n_z, .c = d->n_kept, .t = from ? run->r->t : d->o.from,
                 .h = from ? *h : 1e-4*(d->o.to - d->o.from), .goes_back = from };
    size_t n = (size_t)g.n, c = (size_t)g.c, q = (size_t)g.n_q, x = (size_t)g.n_x;
    g.slip = lw_friction_least_slip(d->n_friction, d->friction, d->eq.unit);
    g.way = &methods[high_order(d, g.slip)];
    if (alpha)
        set_alpha(&g, d->o.rho);
    else
        set_method(&g);
    g.may_leave = from || (!alpha && d->o.formulation == LW_FORMULATION_AUTO && !d->n_friction && !d->eq.next_piece && !d->eq.n_z
                           && !d->eq.more_inertia && !lw_mbs_is_stiff(d));
    g.watch = from ? WATCHED_BACK << run->n_back : WATCHED;
    g.counts_rates = !alpha && !d->elastic && !d->eq.next_piece && !lw_mbs_is_damped(d, false);
    g.watched_t = g.t;
    g.dense = !alpha && !d->elastic && !d->space && !d->eq.next_piece;
    size_t s_n = (size_t)g.s*n, s_x = (size_t)g.s*x, s_c = (size_t)g.s*c, all = n + x + c;
    const size_t total = 3*(size_t)run->n + 2*q + 5*n + 5*s_n + 5*x + 3*s_x + c + 3*s_c + 6*all + 3*(size_t)d->eq.n_switch + 8;
    double *outer = run->y, *memory = calloc(total, sizeof *memory), *p = memory;
    if (!memory)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    run->y = p, p += 2*run->n, g.ahead = p, p += run->n;
    g.q = p, p += q, g.qi = p, p += q, g.v = p, p += n, g.a = p, p += n, g.e = p, p += n, g.l = p, p += c, g.aux = p, p += n, g.v_old = p, p += n;
    g.x = p, p += x, g.dx = p, p += x, g.aux_x = p, p += x, g.xi = p, p += x, g.scale = p, p += x;
    g.z = p, p += s_n, g.last = p, p += s_n, g.vi = p, p += s_n, g.ai = p, p += s_n, g.zx = p, p += s_x, g.last_x = p, p += s_x;
    g.zl = p, p += s_c, g.last_l = p, p += s_c, g.side = p, p += 3*d->eq.n_switch, g.r = p, p += s_n + s_x + s_c, g.b = p, p += all, g.pair_b = p;
    if (from) {
        memcpy(g.q, from, q*sizeof *g.q);
        memcpy(g.v, from + q, n*sizeof *g.v);
        memcpy(g.x, from + lw_run_states(run), x*sizeof *g.x);
        g.work = run->has_work ? from[q + n] : 0;
    } else {
        lw_dynamics_start(d, g.q, g.v);
        memcpy(g.x, d->start_z, x*sizeof *g.x);
    }
    for (int i = 0; i < g.n_x; i++)
        g.scale[i] = d->eq.state_scale(d->eq.context, i);
    lw_status s = from ? LW_OK : lw_run_begin(run, state(&g, run->y));
    g.t = from ? g.t : lw_timed_begin(&run->timed);
    if (s == LW_OK)
        s = begin_again(&g);
    for (int k = 0; s == LW_OK && k <= g.s/2; k++)
        if (lw_tangent_make(d, k > 0, d->eq.more_inertia, k ? &g.pair[k - 1] : &g.real) != LW_OK)
            s = lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    g.real.rubs = g.pair[0].rubs = g.pair[1].rubs = d->n_friction > 0;
    if (s == LW_OK && from)
        g.explicit_step = *h, g.fastest = fastest(&g);
    if (s == LW_OK)
        s = run_steps(&g);
    if (g.leaves)
        state(&g, from);
    if (from)
        *h = g.leaves ? fmin(g.h_old, g.explicit_step*g.fastest/fastest(&g)) : 0;
    if (s == LW_E_NUMERIC && (from || d->o.formulation != LW_FORMULATION_AUTO))
        s = lw_run_hand_over(run, state(&g, run->y));
    lw_tangent_free(&g.real);
    for (int k = 0; k < g.s/2; k++)
        lw_tangent_free(&g.pair[k]);
    run->y = outer;
    free(memory);
    return s;
}

static lw_status run_radau(lw_run *run) { return run_implicit(run, false, NULL, NULL); }
static lw_status run_alpha(lw_run *run) { return run_implicit(run, true, NULL, NULL); }
lw_status lw_run_radau_from(lw_run *run, double *y, double *h) { return run_implicit(run, false, y, h); }

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    if (d->touch)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no contacts");
    if (d->n_stop || d->has_zero_mass)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no rigid stops or massless links");
    for (int j = 0; j < d->n_friction && d->space; j++) {
        lw_spatial_kind kind = d->space->s.joint[d->friction[j].joint].kind;
        if (kind != LW_SPATIAL_REVOLUTE && kind != LW_SPATIAL_PRISMATIC)
            return lw_formulation_say(r, LW_E_KIND, 0, "it knows friction of revolute and prismatic joints only");
    }
    bool slow_states = d->eq.n_z && !lw_mbs_is_stiff(d) && !lw_mbs_states_decay(d);     /* the explicit method takes less time */
    if (!asked && !d->elastic && !d->eq.next_piece && (d->n_friction || !lw_mbs_is_damped(d, false)
        || (!d->space && (!d->eq.exact || d->s.n_tie || slow_states))))
        return lw_formulation_say(r, LW_E_KIND, 0, "it is taken for elastic links and where it is asked for");
    return lw_formulation_say(r, LW_OK, d->n_v + d->n_c, asked ? "asked for" : d->elastic
                              ? "elastic links vibrate fast: an implicit method that follows slow vibrations and damps those faster "
                                "than its steps"
                              : d->eq.next_piece ? "contact in clearances is stiff: an implicit method whose steps end where contact "
                                "begins and ends"
                              : lw_mbs_states_decay(d) ? "first-order states decay fast: an implicit method with exact derivatives"
                              : lw_mbs_vibrates(d) ? "springs and dampers make the equations stiff: an implicit method with exact derivatives"
                              : "dampers make the equations stiff: an implicit method with exact derivatives");
}

const lw_formulation_row lw_formulation_radau = { able, run_radau };

/* Tolerance from which it needs less time than radau for the same error: elastic links in space (docs/benchmarks.md). */
static const double alpha_from = 1e-5;

static lw_status able_alpha(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    lw_status s = able(d, true, r);
    if (s != LW_OK)
        return s;
    if (d->eq.next_piece)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no contacts");
    if (!asked && !(d->space && d->elastic && d->o.relative >= alpha_from))
        return lw_formulation_say(r, LW_E_KIND, 0, "it is taken for elastic links in space at tolerances from 1e-5, and where it is "
                                  "asked for");
    return lw_formulation_say(r, LW_OK, d->n_v + d->n_c, asked ? "asked for" : "elastic links in space and a tolerance of 1e-5 or more: "
                              "the generalised-alpha method, whose steps cost a fifth of those of radau");
}

const lw_formulation_row lw_formulation_alpha = { able_alpha, run_alpha };
