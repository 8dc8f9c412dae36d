/* mbs/formulations/statics.c - equilibrium of any model, and the moment of rest. */
#include <string.h>
#include "base/real.h"
#include "base/vector.h"
#include "mbs/dynamics/touch_internal.h"
#include "mbs/equilibrium/statics_internal.h"
#include "mbs/equilibrium/vibration_internal.h"
#include "mbs/formulations/formulations.h"

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
    lw_mbs_freeze(d, d->start_q);
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
    if (s < 0)
        return lw_error_set(e, s, "the rows of the joints cannot be solved in the posture of rest");
    double *rest = d->v_try;                     /* the start of a static analysis is not needed any more */
    memset(rest, 0, (size_t)d->n_v*sizeof *rest);
    lw_moment m = { .t = t, .q = q, .v = rest, .a = rest, .l = d->l, .potential = d->eq.potential(d->eq.context, q),
                    .unique = d->rank == d->n_c };
    for (int r = 0; r < d->n_c; r++)
        m.off = fmax(m.off, fabs(d->phi[r]));
    d->eq.forces(d->eq.context, t, q, rest, d->force, NULL);
    if (d->touch) {                              /* places that slipped last rub */
        lw_status solved = lw_mbs_moment_forces(d, &m);
        if (solved != LW_OK)
            return lw_error_set(e, solved, "the forces of the contacts in the posture of rest were not found");
        lw_mbs_touch_spread(d, m.v, d->l);
    } else if (d->large) {
        memset(d->rhs, 0, (size_t)d->n_c*sizeof *d->rhs);
        lw_mbs_linear(d, d->force, d->rhs, d->a, d->l);
        lw_mbs_least_norm(d, d->l);
    } else
        lw_rank_solve(&d->rank_of, d->force, d->l);
    for (int r = 0; s == LW_OPEN && r < d->n_c; r++)
        d->l[r] = NAN;
    lw_status shown = sink(context, &m);
    return shown == LW_OK ? s : shown;
}
