/* mbs/run/rate.c - the right-hand side of every run, its tolerances and limits. */
#include "base/real.h"
#include "mbs/run/run_internal.h"

#include <stdlib.h>
#include <string.h>
#include "mbs/equations/limits_internal.h"

/* A shorter step may end before a place where friction has no solution (LW_E_NUMERIC), a force is not a number (the same), or only links without
 * mass move (LW_E_ARG). */
lw_status lw_run_failed_rates(lw_run *run, double t, lw_status s)
{
    const lw_dynamics *d = run->d;
    bool within = t > d->o.from;
    if (!(s == LW_E_NUMERIC && !d->touch && (within || d->n_friction)) && !(s == LW_E_ARG && within))
        return s;
    run->e->status = run->e->status == s ? LW_OPEN : LW_OK;
    return LW_OPEN;
}

lw_status lw_run_rate(void *context, double t, const double *y, double *dy)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    int n = d->n_q;
    double power = 0;
    lw_status s = lw_run_busy(run, t);
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    if (s == LW_OK)
        s = lw_mbs_accelerate(d, t, y, y + n, dy + n, d->l, run->has_work ? &power : NULL);
    if (s != LW_OK)
        return lw_run_failed_rates(run, t, s);
    d->eq.rates(d->eq.context, y, y + n, dy);
    for (int i = 0; run->has_work && i < d->n_driven; i++) {
        double motion[3];
        lw_mbs_motion(d, i, t, motion);
        power -= d->l[d->n_row + i]*motion[1];
    }
    if (run->has_work)
        dy[n + d->n_v] = power;
    return d->eq.n_z ? lw_run_failed_rates(run, t, lw_mbs_state_rates(d, t, y, y + n, dy + lw_run_states(run))) : LW_OK;
}

/* Velocities that each step halves, as of bodies at rest on each other, are 0 below this [1/s]: denormal numbers make
 * every operation a hundred times slower. */
static const double at_rest = 1e-200;

lw_status lw_run_project(void *context, double t, double *y)
{
    lw_dynamics *d = ((lw_run *)context)->d;
    double *v = y + d->n_q;
    if (d->eq.accept)
        d->eq.accept(d->eq.context, y);
    lw_status s = lw_mbs_settle(d, t, y, v);
    for (int i = 0; i < d->n_v; i++)
        if (fabs(v[i]) < at_rest)
            v[i] = 0;
    return s;
}

/* Greatest correction of a state beside a singular posture, over the error allowed in a step. */
static const double correction_most = 30;

/* Is x farther from y than the error of y explains? */
static bool is_thrown(const lw_dynamics *d, int n, const double *y, const double *x)
{
    bool thrown = false;
    for (int i = 0; i < n; i++)
        thrown = thrown || !(fabs(x[i] - y[i]) <= correction_most*(d->o.absolute + d->o.relative*fmax(1, fabs(y[i]))));
    return thrown;
}

lw_status lw_run_correct(lw_run *run, double t, double *y)
{
    lw_dynamics *d = run->d;
    double *q = d->q_try, *v = d->v_try;
    memcpy(q, y, (size_t)d->n_q*sizeof *q);
    memcpy(v, y + d->n_q, (size_t)d->n_v*sizeof *v);
    lw_status s = lw_run_project(run, t, y);
    bool beside = s > 0 || d->weak < LW_SINGULAR_NEAR*LW_SINGULAR_NEAR;
    if (s < 0 || !beside || !(is_thrown(d, d->n_q, q, y) || is_thrown(d, d->n_v, v, y + d->n_q)))
        return s;
    memcpy(y, q, (size_t)d->n_q*sizeof *q);
    memcpy(y + d->n_q, v, (size_t)d->n_v*sizeof *v);
    return LW_OK;
}

lw_status lw_run_limits(lw_run *run, double t, long steps)
{
    const lw_dynamics_options *o = &run->d->o;
    run->r->t = t;
    lw_status s = lw_limits_check(o->stop, o->until, (steps & 15) == 0, t, run->e);
    if (s == LW_OK && o->max_step > 0 && run->r->steps + run->r->refused + steps >= o->max_step && t < o->to)
        s = lw_error_set(run->e, LW_STOPPED, "stopped at t = %.9g s after %ld steps", t, o->max_step);
    return s;
}

lw_status lw_run_busy(lw_run *run, double t)
{
    const lw_dynamics_options *o = &run->d->o;
    bool look_at_clock = (++run->n_busy & 255) == 0;
    if (!look_at_clock && !(o->stop && *o->stop))
        return LW_OK;
    return lw_limits_check(o->stop, o->until, look_at_clock, t, run->e);
}

double *lw_run_tolerances(const lw_run *run, double absolute, lw_status *s)
{
    const lw_dynamics *d = run->d;
    double *each = d->eq.n_z ? malloc((size_t)run->n*sizeof *each) : NULL;
    *s = each || !d->eq.n_z ? LW_OK : lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    for (int i = 0; each && i < run->n; i++)
        each[i] = absolute*(i < lw_run_states(run) ? 1 : d->eq.state_scale(d->eq.context, i - lw_run_states(run)));
    return each;
}

long lw_run_steps_left(const lw_run *run)
{
    long all = run->d->o.max_step, done = run->r->steps + run->r->refused;
    return all <= 0 ? 0 : done < all ? all - done : 1;
}
