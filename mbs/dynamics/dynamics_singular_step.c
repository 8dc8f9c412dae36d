/* mbs/dynamics/dynamics_singular_step.c - over a singular posture.
 *
 * There the rows lose rank, and beside it, at the distance theta, what the equations give is off by rounding over
 * theta.  A method that controls its error takes that for roughness and creeps up to the place.  The motion
 * itself is smooth there, so one step whose stages lie well to both sides of it is as good as any other: from the last
 * state at a fair distance ahead of the place to the same distance behind it, its error not looked at.  The state it
 * ends in must have the energy of before. */
#include "mbs/dynamics/dynamics_run_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>


/* Steps of a fresh integration from (t, y) to end; `fixed`: one step, whatever its error. */
static lw_status walk(lw_run *run, double t, double end, double *y, bool fixed)
{
    const lw_dynamics_options *o = &run->d->o;
    lw_ode ode = { .n = run->n, .context = run, .rate = lw_run_rate, .project = lw_run_project };
    lw_ode_options each = lw_ode_options_default();
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    double *work = calloc(lw_integrate_work(run->n, 0), sizeof *work);
    if (!work)
        return LW_E_MEMORY;
    each.relative = o->relative;
    each.absolute = o->absolute;
    each.max_step = 10000;
    each.fixed = fixed ? end - t : 0;
    lw_status s = lw_integrate_start(&w, &ode, &each, work, t, y, run->e);
    while (s == LW_OK && stop != LW_ODE_END)
        s = lw_integrate_step(&w, end, &stop, run->e);
    if (s == LW_OK)
        memcpy(y, w.y, (size_t)run->n*sizeof *y);
    run->r->rates += w.n_rate;
    run->r->steps += w.n_step;
    free(work);
    return s;
}

static double energy(const lw_run *run, const double *y)
{
    const lw_dynamics *d = run->d;
    return lw_forces_kinetic(&d->f, y + d->n_q) + lw_forces_potential(&d->f, y) - (run->has_work ? y[2*d->n_q] : 0);
}

/* Samples on the way, each by a walk of its own: from y at `good`, and behind `start` by one step from there. */
static lw_status show_on_the_way(lw_run *run, double good, const double *y, double start, const double *begun,
                                 double end)
{
    lw_status s = LW_OK;
    for (; s == LW_OK && run->next <= run->d->o.intervals; run->next++) {
        double t = lw_run_time(run->d, run->next);
        if (t >= end)
            break;
        bool beyond = t > start;
        memcpy(run->y, beyond ? begun : y, (size_t)run->n*sizeof *y);
        s = t > good ? walk(run, beyond ? start : good, t, run->y, beyond) : LW_OK;
        if (s == LW_OK)
            s = lw_run_show(run, t, run->y);
        s = s == LW_OPEN ? LW_OK : s;
    }
    return s;
}

lw_status lw_run_singular_step(lw_run *run, double half, double good, double weak, double place, double *t, double *y)
{
    size_t n = (size_t)run->n;
    double before = energy(run, y), angle = sqrt(weak), start = good, *first = malloc(2*n*sizeof *first);
    lw_status s = LW_OK;
    if (!first)
        return LW_E_MEMORY;
    memcpy(first, y, n*sizeof *first);
    run->e->text[0] = '\0';
    if (angle > half) {
        start = place - (place - good)*half/angle;
        s = walk(run, good, start, y, false);
    }
    memcpy(first + n, y, n*sizeof *first);
    double end = fmin(2*place - start, run->d->o.to);
    if (s == LW_OK)
        s = walk(run, start, end, y, true);
    if (s == LW_OK && !(fabs(energy(run, y) - before) <= 1e-6*fmax(run->r->energy_scale, 1e-300)))
        s = LW_OPEN;
    if (s == LW_OK)
        s = show_on_the_way(run, good, first, start, first + n, end);
    free(first);
    *t = end;
    s = s == LW_E_NUMERIC && run->apart > 0 ? LW_OPEN : s;      /* near branches: told where the run ends */
    return s == LW_OK || s == LW_STOPPED ? s
         : lw_error_set(run->e, s, "at t = %.9g s the linkage comes to a singular posture with speed, and no "
                        "motion goes on behind it that keeps the energy: a dead point or the end of its way", place);
}
