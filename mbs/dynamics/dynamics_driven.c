/* mbs/dynamics/dynamics_driven.c - every freedom is driven: postures by Newton's method from a prediction of second
 * order, in steps short enough to keep the correction small; velocities, accelerations and all forces from the same
 * factors.  Steps go over singular postures (change points): the prediction goes on with the velocity. */
#include "mbs/dynamics/dynamics_run_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double longest_step = 0.05;          /* of a coordinate in one step, scaled or [rad] */

static double greatest(const double *x, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

/* Advance y = (q, v) and a from t by h.  LW_OPEN: the step must be shorter. */
static lw_status advance(lw_dynamics *d, double t, double h, double *y, double *a, double *to)
{
    int n = d->n_q;
    for (int i = 0; i < n; i++)
        to[i] = y[i] + h*(y[n + i] + 0.5*h*a[i]);
    double distance = h*greatest(y + n, n);
    lw_status s = lw_mbs_project_q(d, t + h, to, 0.3*distance + 0.5*h*h*greatest(a, n) + 1e-9);
    memcpy(to + n, y + n, (size_t)n*sizeof *to);
    if (s == LW_OK)
        s = lw_mbs_project_v(d, t + h, to + n);
    return s;
}

/* Advance from t to end. */
static lw_status go_to(lw_run *run, double t, double end, double *y, double *a)
{
    lw_dynamics *d = run->d;
    int n = d->n_q, tries = 0;
    lw_status s = LW_OK;
    while (s == LW_OK && t < end) {
        double distance = greatest(y + n, n), h = end - t;
        if (h*distance > longest_step)
            h /= ceil(h*distance/longest_step);
        if (h*h*greatest(a, n) > longest_step)
            h = fmin(h, sqrt(longest_step/greatest(a, n)));
        for (tries = 0; tries < 30; tries++, h *= 0.7) {
            s = advance(d, t, h, y, a, run->y);
            if (s == LW_OK)
                s = lw_mbs_accelerate(d, t + h, run->y, run->y + n, d->a, d->l, NULL);
            if (s != LW_OPEN)
                break;
        }
        if (s != LW_OK)
            break;
        run->r->steps++;
        t = h == end - t ? end : t + h;
        memcpy(y, run->y, 2*(size_t)n*sizeof *y);
        memcpy(a, d->a, (size_t)n*sizeof *a);
    }
    if (s == LW_OPEN)
        return lw_error_set(run->e, LW_E_NUMERIC, "the linkage cannot follow its inputs beyond t = %.9g s: it stands "
                            "at a limit of its motion", t);
    return s;
}

/* The energy balance is not checked: nothing is integrated, and the work of the driving torques, from their powers
 * at the samples, would be known to second order only. */
static lw_status run_all(lw_run *run, double *y, double *a)
{
    lw_dynamics *d = run->d;
    int n = d->n_q;
    lw_dynamics_start(d, y, y + n);
    lw_status s = lw_mbs_accelerate(d, d->o.from, y, y + n, a, d->l, NULL);
    for (int k = 0; s == LW_OK && k <= d->o.intervals; k++) {
        double t = lw_run_time(d, k);
        if (k > 0)
            s = go_to(run, lw_run_time(d, k - 1), t, y, a);
        if (s != LW_OK)
            break;
        if (d->o.analysis == LW_ANALYSIS_QUASISTATIC)
            s = lw_run_show_slow(run, t, y);
        else
            s = lw_run_show(run, t, y);
        if (s == LW_OK || s == LW_OPEN)
            s = lw_run_limits(run, t, k);
    }
    return s;
}

static lw_status run_driven(lw_run *run)
{
    size_t n = (size_t)run->d->n_q;
    double *y = calloc(5*n + 2, sizeof *y);
    if (!y)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    run->y = y + 3*n;
    run->has_work = false;
    lw_status s = run_all(run, y, y + 2*n);
    free(y);
    return s;
}

static lw_status able(lw_dynamics *d, bool asked, lw_dynamics_report *r)
{
    char why[200];
    if (d->freedom == 0)
        return lw_formulation_say(r, LW_OK, d->n_q, "every freedom is driven: kinematics, then forces");
    snprintf(why, sizeof why, "%d more freedom%s would have to be driven for this analysis: give every input a "
             "\"motion\", or ask for dynamic", d->freedom, d->freedom == 1 ? "" : "s");
    return lw_formulation_say(r, asked ? LW_E_ARG : LW_E_KIND, 0, why);
}

const lw_formulation_row lw_formulation_driven = { able, run_driven };
