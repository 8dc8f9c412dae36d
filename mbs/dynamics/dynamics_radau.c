/* mbs/dynamics/dynamics_radau.c - Radau IIA of order 5 (Hairer & Wanner 1996, section IV.8) for stiff models of any size:
 * elastic links above all, whose fast vibrations an explicit method would have to follow and BDF methods damp or excite.
 *
 *     q' = G v,   M v' + J^T l = Q(t, q, v, x),   x' = f(t, q, v, x),   Phi(t, q) = 0
 *
 * With Z the displacements from q at the start to the three stages, W = A^-1 and h the step: v = T(Z) W Z/h and
 * v' = W (v - v0)/h in the stages, so the unknowns are Z, l and the changes of the first-order states x alone; T is the unit matrix but for turns in space, and
 * Newton's method takes it for that.  In the eigenvectors of W one real and one complex sparse system remain (tangent.c), whose
 * entries are m M + c C + K with m = (w/h)^2, c = w/h.  After each step v is put on the constraints.  Steps end at the
 * samples, where positions, velocities, accelerations and multipliers are those of the third stage: accelerations found
 * afresh from a posture would show its error times the square of the highest frequency. */
#include "base/real.h"
#include "mbs/dynamics/dynamics_run_internal.h"

#include <stdlib.h>
#include <string.h>
#include "mbs/dynamics/tangent_internal.h"

/* ---- the method -------------------------------------------------------------------------------------------- */

/* Real eigenvalue of A^-1, complex ones a +- ib; eigenvectors T and their inverse. */
static const double w_real = 3.63783425274449573, w_re = 2.68108287362775213, w_im = 3.05043019924741057;
static const double T[3][3] = {
    { 9.1232394870892942792e-02, -0.14125529502095420843, -3.0029194105147424492e-02 },
    { 0.24171793270710701896, 0.20412935229379993199, 0.38294211275726193779 },
    { 0.96604818261509293619, 1, 0 }
};
static const double TI[3][3] = {
    { 4.3255798900631553510, 0.33919925181580986954, 0.54177053993587487119 },
    { -4.1787185915519047273, -0.32768282076106238708, 0.47662355450055045196 },
    { -0.50287263494578687595, 2.5719269498556054292, -0.59603920482822492497 }
};

typedef struct stages {
    lw_run *run;
    lw_tangent real, pair;                   /* matrices for the real and the complex eigenvalues */
    int     n, n_q, n_x, c;
    double  w[3][3], at[3], weight[3], error[3];   /* A^-1; places, weights; of the error estimate */
    double  t, h, h_old, work;
    double *q, *v, *a, *l, *x, *dx;          /* at t; l of the kept rows; states and their rates */
    double *z, *zl, *zx;                     /* (3 n) displacements of the stages, (3 c) l there, (3 n_x) changes of states */
    double *last, *last_l, *last_x;          /* those of the last step */
    double *xi, *scale;                      /* (n_x) states of a stage; sizes of states */
    double *vi, *ai, *r, *b, *pair_b, *qi, *e, *old;
    double  power[3];
    double  contraction;
    long    since;                           /* steps with the present history; 0: none */
} stages;

static void set_method(stages *g)
{
    double s6 = sqrt(6.0);
    const double lambda[3][3] = { { w_real, 0, 0 }, { 0, w_re, -w_im }, { 0, w_im, w_re } };
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            g->w[i][j] = 0;
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++)
                    g->w[i][j] += T[i][a]*lambda[a][b]*TI[b][j];
        }
    const double at[3] = { (4 - s6)/10, (4 + s6)/10, 1 }, weight[3] = { (16 - s6)/36, (16 + s6)/36, 1.0/9 };
    const double error[3] = { -(13 + 7*s6)/(3*w_real), (-13 + 7*s6)/(3*w_real), -1/(3*w_real) };
    memcpy(g->at, at, sizeof at);
    memcpy(g->weight, weight, sizeof weight);
    memcpy(g->error, error, sizeof error);
}

/* Velocities and accelerations of the stages from z. */
static void differentiate(stages *g)
{
    const lw_equations *eq = &g->run->d->eq;
    for (int i = 0; i < g->n; i++)
        for (int k = 0; k < 3; k++) {
            g->vi[k*g->n + i] = 0;
            for (int j = 0; j < 3; j++)
                g->vi[k*g->n + i] += g->w[k][j]*g->z[j*g->n + i]/g->h;
        }
    for (int k = 0; k < 3 && eq->along; k++)
        eq->along(eq->context, g->z + k*g->n, g->vi + k*g->n);
    for (int i = 0; i < g->n; i++)
        for (int k = 0; k < 3; k++) {
            g->ai[k*g->n + i] = 0;
            for (int j = 0; j < 3; j++)
                g->ai[k*g->n + i] += g->w[k][j]*(g->vi[j*g->n + i] - g->v[i])/g->h;
        }
}

/* Rate of state i in stage k from its changes. */
static double state_rate(const stages *g, int k, int i)
{
    double rate = 0;
    for (int j = 0; j < 3; j++)
        rate += g->w[k][j]*g->zx[j*g->n_x + i]/g->h;
    return rate;
}

/* Residuals r (3 (n + n_x + c)) of the stages. */
static lw_status residuals(stages *g)
{
    lw_dynamics *d = g->run->d;
    int n = g->n, first = n + g->n_x, all = first + g->c;
    differentiate(g);
    for (int k = 0; k < 3; k++) {
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
        for (int i = 0; i < n; i++)
            r[i] = d->eq.mass[i]*g->ai[k*n + i] - d->force[i];
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

/* One simplified Newton step.  Returns the greatest change of a stage of q, or of a state over its scale. */
static double newton_step(stages *g)
{
    int n = g->n, first = n + g->n_x, all = first + g->c;
    for (int i = 0; i < all; i++) {
        const double r[3] = { g->r[i], g->r[all + i], g->r[2*all + i] };
        g->b[i] = -(TI[0][0]*r[0] + TI[0][1]*r[1] + TI[0][2]*r[2]);
        g->pair_b[2*i] = -(TI[1][0]*r[0] + TI[1][1]*r[1] + TI[1][2]*r[2]);
        g->pair_b[2*i + 1] = -(TI[2][0]*r[0] + TI[2][1]*r[1] + TI[2][2]*r[2]);
    }
    lw_tangent_solve(&g->real, g->b);
    lw_tangent_solve(&g->pair, g->pair_b);
    double most = 0;
    for (int i = 0; i < all; i++)
        for (int k = 0; k < 3; k++) {
            double change = T[k][0]*g->b[i] + T[k][1]*g->pair_b[2*i] + T[k][2]*g->pair_b[2*i + 1];
            if (i >= first) {
                g->zl[k*g->c + i - first] += change;
                continue;
            }
            *(i < n ? &g->z[k*n + i] : &g->zx[k*g->n_x + i - n]) += i < n ? change : change*g->scale[i - n];
            most = fmax(most, fabs(change)) + (isfinite(change) ? 0 : INFINITY);
        }
    return most;
}

/* First values of the stages: the polynomial of the last step, or constant velocity. */
static void predict(stages *g)
{
    for (int k = 0; k < 3; k++) {
        double s = 1 + g->at[k]*g->h/(g->h_old > 0 ? g->h_old : 1), basis[3], basis_l[3];
        for (int j = 0; j < 3; j++) {
            int a = (j + 1)%3, b = (j + 2)%3;
            double c = g->at[j], ca = g->at[a], cb = g->at[b];
            basis_l[j] = (s - ca)*(s - cb)/((c - ca)*(c - cb));
            basis[j] = basis_l[j]*s/c;
        }
        for (int i = 0; i < g->n; i++) {
            const double *z = g->last + i;
            int n = g->n;
            g->z[k*n + i] = g->since ? basis[0]*z[0] + basis[1]*z[n] + basis[2]*z[2*n] - z[2*n] : g->at[k]*g->h*g->v[i];
        }
        for (int i = 0; i < g->n_x; i++) {
            const double *z = g->last_x + i;
            int n = g->n_x;
            g->zx[k*n + i] = g->since ? basis[0]*z[0] + basis[1]*z[n] + basis[2]*z[2*n] - z[2*n] : g->at[k]*g->h*g->dx[i];
        }
        for (int i = 0; i < g->c; i++) {
            const double *z = g->last_l + i;
            int c = g->c;
            g->zl[k*c + i] = g->since ? basis_l[0]*z[0] + basis_l[1]*z[c] + basis_l[2]*z[2*c] : g->l[i];
        }
    }
}

static const int most_newton = 10;

static double tolerance(const stages *g)
{
    double most = 1;
    for (int i = 0; i < g->n_q; i++)
        most = fmax(most, fabs(g->q[i]));
    return g->run->d->o.absolute + g->run->d->o.relative*fmin(most, 1);
}

/* Solve the stages.  LW_OPEN: Newton's method does not converge with this step. */
static lw_status solve_stages(stages *g)
{
    lw_dynamics *d = g->run->d;
    const double c1[2] = { w_real/g->h, 0 }, m1[2] = { c1[0]*c1[0], 0 };
    const double c2[2] = { w_re/g->h, w_im/g->h }, m2[2] = { c2[0]*c2[0] - c2[1]*c2[1], 2*c2[0]*c2[1] };
    double before = 0, wanted = 0.02*tolerance(g);
    lw_status s = lw_mbs_rows(d, g->t, g->q);
    d->eq.place_states(d->eq.context, g->x);
    if (s == LW_OK && lw_tangent_factor(&g->real, g->t, g->q, g->v, g->l, m1, c1) != LW_OK)
        return LW_OPEN;
    if (s == LW_OK && lw_tangent_factor(&g->pair, g->t, g->q, g->v, g->l, m2, c2) != LW_OK)
        return LW_OPEN;
    if (s != LW_OK)
        return s;
    predict(g);
    g->contraction = 0;
    for (int pass = 0; pass < most_newton; pass++) {
        s = lw_run_busy(g->run, g->t);
        if (s == LW_OK)
            s = residuals(g);
        g->run->r->rates += 3;
        if (s != LW_OK)
            return s == LW_E_NUMERIC ? LW_OPEN : s;
        double change = newton_step(g);
        if (!(change < 1e3) || (pass > 1 && change > 2*before))
            return LW_OPEN;
        double ratio = pass ? change/fmax(before, 1e-300) : 1;
        g->contraction = fmax(g->contraction, pass ? ratio : 0);
        if (change <= 1e-15 || (pass > 0 && ratio < 1 && change*ratio/(1 - ratio) <= wanted)
            || (pass > 2 && change <= 1e-13 && ratio > 0.3)) {
            differentiate(g);
            return LW_OK;
        }
        before = change;
    }
    return LW_OPEN;
}

/* Error of the step, over the tolerance: of q by the embedded formula of order 3, filtered by the real matrix. */
static double error_of(stages *g)
{
    lw_dynamics *d = g->run->d;
    int n = g->n;
    double w = w_real/g->h, most = 0;
    for (int i = 0; i < n; i++) {
        double eq = g->v[i]/w, ev = g->a[i]/w;
        for (int k = 0; k < 3; k++) {
            eq += g->error[k]*g->z[k*n + i];
            ev += g->error[k]*(g->vi[k*n + i] - g->v[i]);
        }
        g->e[i] = eq;
        g->b[i] = d->eq.mass[i]*(w*w*eq + w*ev);
    }
    for (int i = 0; i < g->n_x; i++) {
        double e = g->dx[i];
        for (int k = 0; k < 3; k++)
            e += w*g->error[k]*g->zx[k*g->n_x + i];
        g->b[n + i] = e/g->scale[i];
    }
    memset(g->b + n + g->n_x, 0, (size_t)g->c*sizeof *g->b);
    lw_tangent_solve(&g->real, g->b);
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(g->b[i]));
    for (int i = 0; i < g->n_x; i++)
        most = fmax(most, fabs(g->b[n + i])/fmax(1, fabs(g->x[i])/g->scale[i]));
    return most/tolerance(g);
}

/* Take the stages as the step to t + h. */
static lw_status accept(stages *g, double t)
{
    lw_dynamics *d = g->run->d;
    int n = g->n;
    d->eq.move(d->eq.context, g->q, g->z + 2*n);
    for (int i = 0; i < n; i++) {
        g->v[i] = g->vi[2*n + i];
        g->a[i] = g->ai[2*n + i];
    }
    for (int i = 0; i < g->n_x; i++) {
        g->x[i] += g->zx[2*g->n_x + i];
        g->dx[i] = state_rate(g, 2, i);
    }
    memcpy(g->last_x, g->zx, 3*(size_t)g->n_x*sizeof *g->zx);
    memcpy(g->l, g->zl + 2*g->c, (size_t)g->c*sizeof *g->l);
    memcpy(g->last, g->z, 3*(size_t)n*sizeof *g->z);
    memcpy(g->last_l, g->zl, 3*(size_t)g->c*sizeof *g->zl);
    for (int k = 0; k < 3; k++)
        g->work += g->h*g->weight[k]*g->power[k];
    g->h_old = g->h;
    g->t = t;
    g->since++;
    lw_status s = lw_mbs_project_q(d, t, g->q, 0.1);
    if (d->eq.accept)
        d->eq.accept(d->eq.context, g->q);
    return s == LW_OK ? lw_mbs_project_v(d, t, g->v) : s;
}

/* ---- the run ------------------------------------------------------------------------------------------------- */

static double *state(stages *g, double *y)
{
    memcpy(y, g->q, (size_t)g->n_q*sizeof *y);
    memcpy(y + g->n_q, g->v, (size_t)g->n*sizeof *y);
    if (g->run->has_work)
        y[g->n_q + g->n] = g->work;
    memcpy(y + lw_run_states(g->run), g->x, (size_t)g->n_x*sizeof *y);
    return y;
}

static lw_status show(stages *g)
{
    lw_dynamics *d = g->run->d;
    memcpy(d->a, g->a, (size_t)g->n*sizeof *d->a);
    memset(d->l, 0, (size_t)d->n_c*sizeof *d->l);
    for (int k = 0; k < g->c; k++)
        d->l[d->kept[k]] = g->l[k];
    g->run->next++;
    return lw_run_show_solved(g->run, g->t, g->run->y);
}

/* A step towards the next sample: as long as h, or evenly divided where few steps remain. */
static double next_step(const stages *g, double h, double *end)
{
    *end = lw_run_time(g->run->d, g->run->next);
    double left = *end - g->t;
    if (left <= h*(1 + 1e-9))
        return left;
    *end = 0;
    return left < 2*h ? 0.5*left : h;
}

static lw_status run_steps(stages *g)
{
    lw_run *run = g->run;
    lw_dynamics *d = run->d;
    double h = 1e-4*(d->o.to - d->o.from), end, error_old = 1;
    lw_status s = LW_OK;
    for (long k = 1; s == LW_OK && run->next <= d->o.intervals; k++) {
        g->h = next_step(g, h, &end);
        if (!(g->h > 1e-14*fmax(fabs(g->t), d->o.to - d->o.from)))
            return lw_error_set(run->e, LW_E_NUMERIC, "at t = %.9g s the steps become too short: the motion jumps, or an "
                                "elastic link buckles", g->t);
        s = solve_stages(g);
        if (s == LW_OPEN) {
            h = 0.3*g->h;
            run->r->refused++;
            g->since = 0;
            s = LW_OK;
            continue;
        }
        if (s != LW_OK)
            break;
        double error = fmax(error_of(g), 1e-6), factor = 0.9*pow(error, -0.25);
        if (error > 1) {
            h = g->h*fmax(factor, 0.2);
            run->r->refused++;
            continue;
        }
        if (g->since)                        /* Gustafsson's control */
            factor = fmin(factor, factor*g->h/g->h_old*pow(error_old/error, 0.25));
        error_old = fmax(error, 1e-2);
        bool cut = g->h < 0.99*h;
        s = accept(g, end > 0 ? end : g->t + g->h);
        run->r->steps++;
        double next = g->h_old*fmin(fmax(factor, 0.2), g->contraction > 0.3 ? 1 : 8);
        h = cut ? fmax(h, next) : next;
        run->r->t = g->t;
        if (s == LW_OK) {
            lw_run_watch(run, state(g, run->y));
            s = end > 0 ? show(g) : LW_OK;
        }
        if (s == LW_OK)
            s = lw_run_limits(run, g->t, 0);
        (void)k;
    }
    return s;
}

static lw_status run_radau(lw_run *run)
{
    lw_dynamics *d = run->d;
    stages g = { .run = run, .n = d->n_v, .n_q = d->n_q, .n_x = d->eq.n_z, .c = d->n_kept, .t = d->o.from };
    size_t n = (size_t)g.n, c = (size_t)g.c, q = (size_t)g.n_q, x = (size_t)g.n_x;
    double *memory = calloc(2*(size_t)run->n + 2*q + 22*n + 16*c + 16*x + 8, sizeof *memory), *p = memory;
    if (!memory)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    run->y = p, p += run->n;
    g.q = p, p += q, g.v = p, p += n, g.a = p, p += n, g.l = p, p += c;
    g.z = p, p += 3*n, g.zl = p, p += 3*c, g.last = p, p += 3*n, g.last_l = p, p += 3*c;
    g.vi = p, p += 3*n, g.ai = p, p += 3*n, g.r = p, p += 3*(n + x + c), g.b = p, p += n + x + c;
    g.x = p, p += x, g.dx = p, p += x, g.zx = p, p += 3*x, g.last_x = p, p += 3*x, g.xi = p, p += x, g.scale = p, p += x;
    g.pair_b = p, p += 2*(n + x + c), g.qi = p, p += q, g.e = p;
    set_method(&g);
    lw_dynamics_start(d, g.q, g.v);
    memcpy(g.x, d->start_z, x*sizeof *g.x);
    for (int i = 0; i < g.n_x; i++)
        g.scale[i] = d->eq.state_scale(d->eq.context, i);
    d->eq.place_states(d->eq.context, g.x);
    d->eq.state_rates(d->eq.context, g.t, g.q, g.v, g.dx);
    lw_status s = lw_run_begin(run, state(&g, run->y));
    memcpy(g.a, d->a, n*sizeof *g.a);
    for (int k = 0; k < g.c; k++)
        g.l[k] = d->l[d->kept[k]];
    if (s == LW_OK && (lw_tangent_make(d, false, false, &g.real) != LW_OK || lw_tangent_make(d, true, false, &g.pair) != LW_OK))
        s = lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        s = run_steps(&g);
    lw_tangent_free(&g.real);
    lw_tangent_free(&g.pair);
    free(memory);
    return s;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    if (d->touch)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no contacts");
    if (d->n_friction || d->n_stop || d->has_zero_mass)
        return lw_formulation_say(r, LW_E_KIND, 0, "it knows no friction, rigid stops or massless links");
    if (!asked && !d->elastic && !(d->space && lw_mbs_is_stiff(d)))
        return lw_formulation_say(r, LW_E_KIND, 0, "it is taken for elastic links and where it is asked for");
    return lw_formulation_say(r, LW_OK, d->n_v + d->n_c, asked ? "asked for" : d->elastic
                              ? "elastic links vibrate fast: an implicit method that follows slow vibrations and damps those faster "
                                "than its steps"
                              : "dampers make the equations stiff: an implicit method with exact derivatives");
}

const lw_formulation_row lw_formulation_radau = { able, run_radau };
