/* mbs/dynamics/statics.c - equilibrium by Newton's method in the null space of the constraints.
 *
 * The reduced equations are those of small vibrations (mbs/dynamics/modes.h): load = Z^T Q, stiffness Z^T (K + sum
 * l_r H_r) Z.  Where the stiffness is not positive definite, a multiple of the masses is added until it is, which
 * leads downhill and away from saddles. */
#include "mbs/dynamics/statics.h"

#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "base/vector.h"
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/dynamics/statics_internal.h"

/* A stiffness that becomes positive definite by so small a shift neither holds nor drives away: neutral equilibrium. */
#define NEUTRAL 1e-9

#define CONVERGED 1e-11                  /* two steps below this in a row: rounding stops Newton's method */

/* Solve (K + shift W) x = load by Cholesky's method, with W the masses and a small multiple of I.  false: not
 * positive definite. */
static bool solve_shifted(const lw_vibration *v, double shift, double little, double *x)
{
    int n = v->n_free;
    double a[LW_SYSTEM_Q_MAX*4], *m = n*n <= (int)(sizeof a/sizeof *a) ? a : v->kkt.a;
    for (int i = 0; i < n; i++) {
        x[i] = v->load[i];
        for (int j = 0; j <= i; j++) {
            double sum = 0.5*(v->stiffness[i*n + j] + v->stiffness[j*n + i])
                       + shift*(v->mass[i*n + j] + (i == j)*little);
            for (int k = 0; k < j; k++)
                sum -= m[i*n + k]*m[j*n + k];
            if (i == j && !(sum > 1e-14*(fabs(v->stiffness[i*n + i]) + shift*(v->mass[i*n + i] + little))))
                return false;
            m[i*n + j] = i == j ? sqrt(sum) : sum/m[j*n + j];
        }
        for (int k = 0; k < i; k++)
            x[i] -= m[i*n + k]*x[k];
        x[i] /= m[i*n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= m[k*n + i]*x[k];
        x[i] /= m[i*n + i];
    }
    return true;
}

static double length(const double *x, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        sum += x[i]*x[i];
    return sqrt(sum);
}

/* Newton's step with the stiffness, shifted until it is positive definite; at most half a radian or half the size of
 * the linkage.  Returns the shift in stiffnesses over masses; below 0: no step was found. */
static double find_step(const lw_vibration *v, double *x)
{
    double mass = 0.0, stiff = 0.0;
    for (int i = 0; i < v->n_free; i++) {
        mass = fmax(mass, v->mass[i*v->n_free + i]);
        stiff = fmax(stiff, fabs(v->stiffness[i*v->n_free + i]));
    }
    double little = mass > 0.0 ? 1e-3*mass : 1.0, shift = 0.0;
    double unit = (stiff > 0.0 ? stiff : 1.0)/(mass > 0.0 ? mass : 1.0);
    for (int tries = 0; tries < 60; tries++) {
        if (solve_shifted(v, shift, little, x)) {
            double size = length(x, v->n_free);
            for (int i = 0; size > 0.5 && i < v->n_free; i++)
                x[i] *= 0.5/size;
            return isfinite(size) ? shift/unit : -1.0;
        }
        shift = shift > 0.0 ? fmin(8.0*shift, fmax(1e-3*unit, 2.0*shift)) : NEUTRAL*unit;
    }
    return -1.0;
}

/* Step along x from q.  Halve the step while the force at its end pushes back with more than half the force at its
 * start. */
static lw_status search(lw_vibration *v, double t, double *q, const double *x)
{
    int n = v->n_q, m = v->n_free;
    double from[LW_SYSTEM_Q_MAX], null[LW_SYSTEM_Q_MAX], slope = 0.0;
    memcpy(from, q, sizeof *q*(size_t)n);
    memset(null, 0, sizeof null);
    for (int k = 0; k < m; k++)
        for (int i = 0; i < n; i++)
            null[i] += x[k]*v->null[k*n + i];
    for (int k = 0; k < m; k++)
        slope += v->load[k]*x[k];
    for (double fraction = 1.0; fraction > 1e-12; fraction *= 0.5) {
        double end = 0.0;
        for (int i = 0; i < n; i++)
            q[i] = from[i] + fraction*null[i];
        lw_status s = lw_vibration_project(v, q);
        if (s == LW_OK)
            s = lw_vibration_linearise(v, t, q);
        if (s != LW_OK)
            continue;
        for (int i = 0; i < n; i++)
            end += null[i]*v->force[i];
        if (end >= -0.5*fabs(slope) || fraction*length(x, m) < 1e-9)
            return LW_OK;
    }
    return LW_E_NUMERIC;
}

/* Leave a saddle: a small step along every motion, each of another length. */
static lw_status leave_saddle(lw_vibration *v, double t, double *q)
{
    for (int k = 0; k < v->n_free; k++)
        for (int i = 0; i < v->n_q; i++)
            q[i] += 1e-3*(1.0 + 0.3*k)*v->null[k*v->n_q + i];
    lw_status s = lw_vibration_project(v, q);
    return s == LW_OK ? lw_vibration_linearise(v, t, q) : s;
}

lw_status lw_vibration_rest(lw_vibration *v, double t, double *q, lw_rest *r, lw_error *e)
{
    double x[LW_SYSTEM_Q_MAX], last = INFINITY;
    lw_status s = lw_vibration_linearise(v, t, q);
    *r = (lw_rest){ 0 };
    for (int saddles = 0; s == LW_OK && r->iterations < 500; r->iterations++) {
        double shift = v->n_free > 0 ? find_step(v, x) : 0.0, size = v->n_free > 0 ? length(x, v->n_free) : 0.0;
        if (shift < 0.0)
            break;
        r->residual = lw_greatest(v->n_free, v->load);
        r->stable = shift == 0.0;
        bool done = size < 1e-14 || r->residual <= 1e-15*lw_greatest(v->n_q, v->force)
                 || (last < CONVERGED && size < CONVERGED);
        if (done && (shift <= 2.0*NEUTRAL || saddles == 5))
            return LW_OK;
        last = done ? INFINITY : size;
        saddles += done;
        s = done ? leave_saddle(v, t, q) : search(v, t, q, x);
    }
    return lw_error_set(e, LW_NOTHING, "no static equilibrium was found near the posture: the forces drive it away "
                        "(force left %.3g J)", r->residual);
}

/* The balance takes no notice of rigid stops: a rest beyond one is none. */
static lw_status check_stops(const lw_dynamics *d, const double *q, lw_error *e)
{
    for (int i = 0; i < d->n_stop; i++) {
        int j = d->stop[i].joint;
        bool pin = lw_joint_turns(d->s.joint[j].kind);
        double beyond = -lw_rigid_stop_gap(&d->s, &d->stop[i], q, NULL);
        if (beyond > LW_STOP_CLOSED)
            return lw_error_set(e, LW_NOTHING, "without its rigid stop the model rests %.3g %s beyond that of joint "
                                "\"%s\"; give the stop a stiffness, and it rests on it",
                                pin ? beyond : beyond*d->s.unit, pin ? "rad" : "m", d->model->linkage.joint[j].name);
    }
    return LW_OK;
}

/* ---- contacts ---------------------------------------------------------------------------------------------- */

/* Which places touch, stick and slip at rest follows from the way there: friction leaves many equilibria.  The model starts at
 * rest in the posture of the file and moves under its loads, damped in all motion, until it stays. */
static const double at_rest = 1e-9;          /* speed that counts as rest, times the damping; scaled */
static const double balanced = 1e-7;         /* acceleration that counts as rest, over that at the start or by weight */
enum { SETTLING_TIME = 1000 };               /* [1/damping] */

typedef struct settled { const lw_dynamics *d; double push; double *q, left; bool found; } settled;

static lw_status see(void *context, const lw_moment *m)
{
    settled *z = context;
    const lw_dynamics *d = z->d;
    z->found = lw_greatest(d->n_v, m->v) < at_rest*d->settling && lw_greatest(d->n_v, m->a) < balanced*z->push
            && isfinite(lw_greatest(d->n_c, m->l));
    memcpy(z->q, m->q, (size_t)d->n_q*sizeof *m->q);
    z->left = 0;
    for (int i = 0; i < d->n_v; i++)
        z->left = fmax(z->left, fabs(m->a[i]/d->by_mass[i]));
    return z->found ? LW_NOTHING : LW_OK;
}

static lw_status settle(lw_dynamics *d, double t, double *q, lw_rest *r, lw_error *e)
{
    lw_dynamics_report report;
    settled z = { .d = d, .q = q };
    lw_error own = { 0 };
    memset(d->start_v, 0, (size_t)d->n_v*sizeof *d->start_v);
    d->eq.place(d->eq.context, d->start_q);
    d->eq.forces(d->eq.context, t, d->start_q, d->start_v, d->force, NULL);
    for (int i = 0; i < d->n_v; i++)
        z.push = fmax(z.push, fabs(d->force[i]*d->by_mass[i]));
    z.push = fmax(z.push, 1e-6);
    d->settling = 2*sqrt(z.push);
    d->o.from = t;
    d->o.to = t + SETTLING_TIME/d->settling;
    d->o.intervals = 4*SETTLING_TIME;
    lw_status s = lw_dynamics_run(d, see, &z, &report, e ? e : &own);
    *r = (lw_rest){ .iterations = (int)report.steps, .residual = z.left, .stable = true };
    if (z.found)
        return LW_OK;
    return s != LW_OK ? s : lw_error_set(e, LW_NOTHING, "the model does not come to rest: nothing stops it, or a contact slips for "
                                         "ever");
}

lw_status lw_statics_rest(lw_dynamics *d, double t, double *q, lw_rest *r, lw_error *e)
{
    lw_vibration v;
    *r = (lw_rest){ 0 };
    if (d->touch)
        return settle(d, t, q, r, e);
    if (d->large)
        return lw_statics_rest_large(d, t, q, r, e);
    memcpy(q, d->start_q, sizeof *q*(size_t)d->n_q);
    if (lw_vibration_make(&d->f, false, t, q, &v) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_status s = lw_vibration_project(&v, q);
    if (s == LW_OK)
        s = lw_vibration_rest(&v, t, q, r, e);
    else
        lw_error_set(e, s, "no posture near the given one fits the joints and inputs");
    lw_vibration_free(&v);
    return s == LW_OK ? check_stops(d, q, e) : s;
}

lw_status lw_statics_moment(lw_dynamics *d, double t, const double *q, lw_moment_sink *sink, void *context, lw_error *e)
{
    lw_error own = { 0 };
    d->e = e ? e : &own;
    lw_status s = lw_mbs_rows(d, t, q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, true);
    if (s != LW_OK)
        return lw_error_set(e, LW_E_NUMERIC, "the posture of rest is singular: its reactions do not exist");
    double *rest = d->v_try;                     /* the start of a static analysis is not needed any more */
    memset(rest, 0, (size_t)d->n_v*sizeof *rest);
    lw_moment m = { .t = t, .q = q, .v = rest, .a = rest, .l = d->l, .potential = d->eq.potential(d->eq.context, q),
                    .unique = d->rank == d->n_c };
    for (int r = 0; r < d->n_c; r++)
        m.off = fmax(m.off, fabs(d->phi[r]));
    d->eq.forces(d->eq.context, t, q, rest, d->force, NULL);
    if (d->large) {
        memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
        lw_mbs_linear(d, d->force, d->rhs, d->a, d->l);
    } else
        lw_rank_solve(&d->rank_of, d->force, d->l);
    return sink(context, &m);
}

lw_status lw_dynamics_analyse(lw_dynamics *d, lw_moment_sink *sink, void *context, lw_dynamics_report *r, lw_rest *rest,
                              lw_error *e)
{
    if (d->o.analysis != LW_ANALYSIS_STATIC)
        return lw_dynamics_run(d, sink, context, r, e);
    *r = d->choice;
    double *q = calloc((size_t)d->n_q + 1, sizeof *q);
    lw_status s = q ? lw_statics_rest(d, d->o.from, q, rest, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    r->steps = rest->iterations;
    if (s == LW_OK)
        s = lw_statics_moment(d, d->o.from, q, sink, context, e);
    r->samples = s == LW_OK;
    free(q);
    return s;
}
