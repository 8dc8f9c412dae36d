#include "cli/bench/flexible_crank.h"

#include <string.h>
#include "base/real.h"
#include "mbs/ode/cvode.h"
#include "mbs/ode/ida.h"

enum { N = LW_FLEXIBLE_N, E = 4, ROWS = 3, GGL_N = 2*N + 2*ROWS };

const char *lw_flexible_method_name(lw_flexible_method m)
{
    static const char *const name[] = { "reduced", "adams", "bdf", "ggl" };
    return name[m];
}

void lw_flexible_crank_published(lw_flexible_crank *c)
{
    const double pi = 3.1415927, width = 0.008, young = 2e11, density = 7870, l2 = 0.3;
    const double area = width*width, m = density*area*l2, k = young*area/l2, b = area*l2;
    const double bend = pow(pi, 4)*(width/l2)*(width/l2);
    *c = (lw_flexible_crank){
        .crank = 0.15, .coupler = l2, .m2 = 0.151104, .m3 = 0.075552, .j1 = 0.002727, .j2 = 0.0045339259,
        .density = density, .speed = 150,
        .mass = { { 0.5*m }, { 0, 0.5*m }, { 0, 0, 8*m, m }, { 0, 0, m, 2*m } },
        .stiffness = { { k*bend/24 }, { 0, k*bend*2/3 }, { 0, 0, k*16/3, -k*8/3 }, { 0, 0, -k*8/3, k*7/3 } },
        .c1 = { 0, 0, b*2/3, b/6 }, .c2 = { b*2/pi, 0, 0, 0 },
        .c12 = { 0, 0, l2*b/3, l2*b/6 }, .c21 = { l2*b/pi, -l2*b*0.5/pi, 0, 0 } };
    c->b[0][2] = -16*b/pow(pi, 3);
    c->b[0][3] = b*(8/pow(pi, 3) - 1/pi);
    c->b[1][3] = 0.5*b/pi;
    for (int i = 0; i < 2; i++)
        for (int j = 2; j < 4; j++)
            c->b[j][i] = -c->b[i][j];
}

static double dot(const double *a, const double *b)
{
    return a[0]*b[0] + a[1]*b[1] + a[2]*b[2] + a[3]*b[3];
}

void lw_flexible_crank_mass(const lw_flexible_crank *c, const double *p, double *m)
{
    const double *q = p + 3, l1 = c->crank, rho = c->density;
    double co = cos(p[0] - p[1]), si = sin(p[0] - p[1]);
    memset(m, 0, N*N*sizeof *m);
    m[0] = c->j1 + c->m2*l1*l1;
    m[1] = 0.5*l1*c->coupler*c->m2*co + rho*l1*(si*dot(c->c2, q) + co*dot(c->c1, q));
    m[N + 1] = c->j2 + 2*rho*dot(c->c12, q);
    m[2*N + 2] = c->m3;
    for (int i = 0; i < E; i++) {
        m[N + 1] += q[i]*dot(c->mass[i], q);
        m[3 + i] = rho*l1*(co*c->c2[i] - si*c->c1[i]);
        m[N + 3 + i] = rho*(c->c21[i] - dot(c->b[i], q));       /* b is antisymmetric                     */
        for (int j = 0; j < E; j++)
            m[(3 + i)*N + 3 + j] = c->mass[i][j];
    }
    for (int i = 0; i < N; i++)
        for (int j = 0; j < i; j++)
            m[i*N + j] = m[j*N + i];
}

/* Forces of Lagrange's equations for that mass matrix: f = 1/2 d(v^T M v)/dp - dM/dt v - K q. */
void lw_flexible_crank_force(const lw_flexible_crank *c, const double *p, const double *v, double *f)
{
    const double *q = p + 3, *qd = v + 3, l1 = c->crank, rho = c->density, w1 = v[0], w2 = v[1];
    double co = cos(p[0] - p[1]), si = sin(p[0] - p[1]), half = 0.5*l1*c->coupler*c->m2;
    double c1q = dot(c->c1, q), c2q = dot(c->c2, q), qdmq = 0, qdbqd = 0;
    for (int i = 0; i < E; i++) {
        qdmq += qd[i]*dot(c->mass[i], q);
        qdbqd += qd[i]*dot(c->b[i], qd);
        f[3 + i] = w2*w2*(dot(c->mass[i], q) + rho*c->c12[i]) + rho*l1*w1*w1*(co*c->c1[i] + si*c->c2[i]) +
                   2*rho*w2*dot(c->b[i], qd) - dot(c->stiffness[i], q);
    }
    f[0] = -half*w2*w2*si + rho*l1*w2*(w2*(co*c2q - si*c1q) - 2*(co*dot(c->c1, qd) + si*dot(c->c2, qd)));
    f[1] = half*w1*w1*si + rho*l1*w1*w1*(si*c1q - co*c2q) - 2*w2*(rho*dot(c->c12, qd) + qdmq) - rho*qdbqd;
    f[2] = 0;
}

void lw_flexible_crank_rows(const lw_flexible_crank *c, double t, const double *p, double *phi, double *g)
{
    double s1 = sin(p[0]), c1 = cos(p[0]), s2 = sin(p[1]), c2 = cos(p[1]), l = c->coupler + p[6];
    phi[0] = c->crank*s1 + l*s2;
    phi[1] = p[2] - c->crank*c1 - l*c2;
    phi[2] = p[0] - c->speed*t;
    if (!g)
        return;
    memset(g, 0, ROWS*N*sizeof *g);
    g[0] = c->crank*c1, g[1] = l*c2, g[6] = s2;
    g[N] = c->crank*s1, g[N + 1] = l*s2, g[N + 2] = 1, g[N + 6] = -c2;
    g[2*N] = 1;
}

/* ---- in the elastic coordinates alone --------------------------------------------------------------------- */

/* p, v from time and the elastic coordinates y (q, q'); v = T q' + ..., a = T q'' + b. T is 1 for the elastic
 * coordinates; `turn` and `slide` are its entries from the last of them to coupler and slider. */
typedef struct expanded { double p[N], v[N], b[N], turn, slide; } expanded;

static void expand(const lw_flexible_crank *c, double t, const double *y, expanded *s)
{
    double w = c->speed, l1 = c->crank, l = c->coupler + y[3], ld = y[7];
    double s1 = sin(w*t), c1 = cos(w*t), s2 = -l1*s1/l, c2 = sqrt(1 - s2*s2);
    memset(s, 0, sizeof *s);
    memcpy(s->p + 3, y, E*sizeof *y);
    memcpy(s->v + 3, y + E, E*sizeof *y);
    s->p[0] = w*t, s->p[1] = asin(s2), s->p[2] = l1*c1 + l*c2;
    double w2 = -(l1*c1*w + s2*ld)/(l*c2);
    s->v[0] = w, s->v[1] = w2, s->v[2] = -l1*s1*w - l*s2*w2 + c2*ld;
    s->b[1] = (l*s2*w2*w2 - 2*ld*c2*w2 + l1*s1*w*w)/(l*c2);
    s->b[2] = -l1*c1*w*w - 2*ld*s2*w2 - l*c2*w2*w2 - l*s2*s->b[1];
    s->turn = -s2/(l*c2);
    s->slide = c2 - l*s2*s->turn;
}

/* Solve A x = b for a positive definite 4 x 4 matrix; x holds b on entry. */
static lw_status cholesky(double a[E][E], double *x)
{
    for (int j = 0; j < E; j++)
        for (int i = j; i < E; i++) {
            for (int k = 0; k < j; k++)
                a[i][j] -= a[i][k]*a[j][k];
            if (i == j && !(a[j][j] > 0))
                return LW_OPEN;
            a[i][j] = i == j ? sqrt(a[j][j]) : a[i][j]/a[j][j];
        }
    for (int i = 0; i < E; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= a[i][k]*x[k];
        x[i] /= a[i][i];
    }
    for (int i = E - 1; i >= 0; i--) {
        for (int k = i + 1; k < E; k++)
            x[i] -= a[k][i]*x[k];
        x[i] /= a[i][i];
    }
    return LW_OK;
}

/* Solve T^T (M (T q'' + b) - f) = 0; also fill a (7) unless it is NULL. */
static lw_status accelerate(const lw_flexible_crank *c, const expanded *s, double *qdd, double *a)
{
    double m[N*N], f[N], small[E][E], to[2] = { s->turn, s->slide };
    lw_flexible_crank_mass(c, s->p, m);
    lw_flexible_crank_force(c, s->p, s->v, f);
    for (int i = 0; i < N; i++)
        f[i] -= m[i*N + 1]*s->b[1] + m[i*N + 2]*s->b[2];
    for (int i = 0; i < E; i++) {
        qdd[i] = f[3 + i];
        for (int j = 0; j < E; j++)
            small[i][j] = m[(3 + i)*N + 3 + j];
    }
    for (int k = 0; k < 2; k++) {
        qdd[3] += to[k]*f[1 + k];
        for (int i = 0; i < E; i++) {
            small[i][3] += to[k]*m[(3 + i)*N + 1 + k];
            small[3][i] += to[k]*m[(3 + i)*N + 1 + k];
        }
        for (int j = 0; j < 2; j++)
            small[3][3] += to[k]*to[j]*m[(1 + k)*N + 1 + j];
    }
    lw_status st = cholesky(small, qdd);
    if (a && st == LW_OK) {
        memcpy(a, s->b, N*sizeof *a);
        memcpy(a + 3, qdd, E*sizeof *a);
        a[1] += s->turn*qdd[3];
        a[2] += s->slide*qdd[3];
    }
    return st;
}

static lw_status reduced_rate(void *context, double t, const double *y, double *dy)
{
    expanded s;
    if (!(fabs(y[3]) < 0.1))                     /* beyond this the loop cannot close                         */
        return LW_OPEN;
    expand(context, t, y, &s);
    memcpy(dy, y + E, E*sizeof *y);
    return accelerate(context, &s, dy + E, NULL);
}

/* ---- all coordinates with multipliers: y = p, v, l, mu ----------------------------------------------------- */

static lw_status ggl_residual(void *context, double t, const double *y, const double *dy, double *r)
{
    const lw_flexible_crank *c = context;
    const double *v = y + N, *l = y + 2*N, *mu = l + ROWS;
    double m[N*N], f[N], g[ROWS*N], phi[ROWS];
    lw_flexible_crank_mass(c, y, m);
    lw_flexible_crank_force(c, y, v, f);
    lw_flexible_crank_rows(c, t, y, phi, g);
    for (int i = 0; i < N; i++) {
        r[i] = dy[i] - v[i];
        r[N + i] = -f[i];
        for (int k = 0; k < ROWS; k++) {
            r[i] += g[k*N + i]*mu[k];
            r[N + i] += g[k*N + i]*l[k];
        }
        for (int j = 0; j < N; j++)
            r[N + i] += m[i*N + j]*dy[N + j];
    }
    for (int k = 0; k < ROWS; k++) {
        r[2*N + k] = k == 2 ? -c->speed : 0;
        for (int i = 0; i < N; i++)
            r[2*N + k] += g[k*N + i]*v[i];
        r[2*N + ROWS + k] = phi[k];
    }
    return LW_OK;
}

/* Multipliers from the rows of crank, coupler and slider, for which G is triangular. */
static lw_status ggl_start(const lw_flexible_crank *c, const double *y0, double *y, double *dy)
{
    double m[N*N], f[N], g[ROWS*N], phi[ROWS], qdd[E];
    expanded s;
    expand(c, 0, y0, &s);
    lw_status st = accelerate(c, &s, qdd, dy + N);
    memset(y, 0, GGL_N*sizeof *y);
    memcpy(y, s.p, sizeof s.p);
    memcpy(y + N, s.v, sizeof s.v);
    memcpy(dy, s.v, sizeof s.v);
    lw_flexible_crank_mass(c, s.p, m);
    lw_flexible_crank_force(c, s.p, s.v, f);
    lw_flexible_crank_rows(c, 0, s.p, phi, g);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            f[i] -= m[i*N + j]*dy[N + j];
    double *l = y + 2*N;
    l[1] = f[2];
    l[0] = (f[1] - g[N + 1]*l[1])/g[1];
    l[2] = f[0] - g[0]*l[0] - g[N]*l[1];
    return st;
}

static lw_status run_ggl(const lw_flexible_crank *c, const double *y0, const lw_ode_options *o, double to, lw_flexible_run *r, lw_error *e)
{
    unsigned char algebraic[GGL_N] = { 0 };
    double y[GGL_N], dy[GGL_N] = { 0 };
    lw_dae dae = { .n = GGL_N, .context = (void *)(size_t)c, .residual = ggl_residual, .algebraic = algebraic };
    lw_ode_stop stop = LW_ODE_STEP;
    lw_sundials w;
    memset(algebraic + 2*N, 1, 2*ROWS);
    lw_status st = ggl_start(c, y0, y, dy);
    if (st == LW_OK)
        st = lw_ida_make(&w, &dae, o, 0, y, dy, e);
    if (st != LW_OK)
        return st;
    while (st == LW_OK && stop != LW_ODE_END)
        st = lw_sundials_step(&w, to, &stop, e);
    memcpy(r->p, w.y, sizeof r->p);
    memcpy(r->v, w.y + N, sizeof r->v);
    r->steps = w.n_step;
    r->rates = w.n_rate;
    lw_sundials_free(&w);
    return st;
}

/* ---- runs ---------------------------------------------------------------------------------------------------- */

static lw_status run_explicit(const lw_ode *ode, const lw_ode_options *o, double to, double *y, lw_flexible_run *r, lw_error *e)
{
    double work[LW_INTEGRATE_WORK(20, 0)];
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    if (lw_integrate_work(ode->n, 0) > sizeof work/sizeof *work)
        return LW_E_ARG;
    lw_status st = lw_integrate_start(&w, ode, o, work, 0, y, e);
    while (st == LW_OK && stop != LW_ODE_END)
        st = lw_integrate_step(&w, to, &stop, e);
    memcpy(y, w.y, (size_t)ode->n*sizeof *y);
    r->steps = w.n_step;
    r->rates = w.n_rate;
    return st;
}

static lw_status run_cvode(const lw_ode *ode, const lw_ode_options *o, lw_cvode_method method, double to, double *y,
                           lw_flexible_run *r, lw_error *e)
{
    lw_sundials w;
    lw_ode_stop stop = LW_ODE_STEP;
    lw_status st = lw_cvode_make(&w, ode, o, method, 0, y, e);
    if (st != LW_OK)
        return st;
    while (st == LW_OK && stop != LW_ODE_END)
        st = lw_sundials_step(&w, to, &stop, e);
    memcpy(y, w.y, (size_t)ode->n*sizeof *y);
    r->steps = w.n_step;
    r->rates = w.n_rate;
    lw_sundials_free(&w);
    return st;
}

lw_status lw_flexible_crank_run(const lw_flexible_crank *c, lw_flexible_method method, double tolerance, double to,
                                lw_flexible_run *r, lw_error *e)
{
    double y[2*E] = { 0, 0, 1.03339863e-05, 1.69327969e-05, 0.444896105, 0.00463434311, -1.78591076e-06,
                      -2.68938672e-06 };
    /* elastic coordinates are about 1e-4 m, their rates at most 1 m/s */
    double absolute[GGL_N];
    lw_ode ode = { .n = 2*E, .context = (void *)(size_t)c, .rate = reduced_rate };
    lw_ode_options o = lw_ode_options_default();
    bool ggl = method == LW_FLEXIBLE_GGL;
    for (int i = 0; i < GGL_N; i++)
        absolute[i] = tolerance*(ggl ? i < 3 || i >= N ? 1 : 1e-4 : i < E ? 1e-4 : 1);
    for (int i = 2*N; i < GGL_N; i++)            /* multipliers are noise where steps are short               */
        absolute[i] = 1e3*tolerance;
    o.relative = tolerance;
    o.max_step = 300000;
    o.absolute_each = absolute;
    o.first = ggl ? 1e-6*to : 0;               /* shorter first steps make Newton's matrix singular           */
    *r = (lw_flexible_run){ 0 };
    if (ggl)
        return run_ggl(c, y, &o, to, r, e);
    lw_status st = method == LW_FLEXIBLE_EXPLICIT
                 ? run_explicit(&ode, &o, to, y, r, e)
                 : run_cvode(&ode, &o, method == LW_FLEXIBLE_ADAMS ? LW_CVODE_ADAMS : LW_CVODE_BDF, to, y, r, e);
    expanded s;
    expand(c, to, y, &s);
    memcpy(r->p, s.p, sizeof s.p);
    memcpy(r->v, s.v, sizeof s.v);
    return st;
}
