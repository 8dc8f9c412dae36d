/* mbs/dynamics/dynamics_kinks.c - steps end where forces have kinks or jumps that depend on the motion (lw_equations.switches).
 *
 * One event function serves all of them: the least distance from a kink or jump, on the sides where the motion is now.  It is passed where
 * the motion is behind it by more than a small part of the tolerance, so that a motion that rests there has no event at each step. */
#include "base/real.h"
#include "mbs/dynamics/dynamics_run_internal.h"

#include <stdlib.h>

static const double part = 1e-3;             /* a kink is passed so far behind it, over the tolerance and its greatest distance so far */

struct lw_kinks {
    int    n;
    double *side, *force;                    /* (n_switch), (n_v) scratch */
    struct { double sense, greatest; } of[]; /* the side where the motion is; greatest distance so far */
};

lw_status lw_run_make_kinks(lw_run *run)
{
    const lw_equations *eq = &run->d->eq;
    size_t n = (size_t)eq->n_switch;
    if (n == 0)
        return LW_OK;
    struct lw_kinks *k = run->kinks = calloc(1, sizeof *k + n*sizeof *k->of + (n + (size_t)eq->n_v)*sizeof(double));
    if (!k)
        return lw_error_set(run->e, LW_E_MEMORY, "out of memory");
    k->n = eq->n_switch;
    k->side = (double *)(k->of + n);
    k->force = k->side + n;
    return LW_OK;
}

void lw_run_free_kinks(lw_run *run) { free(run->kinks); }

/* How far behind a kink it is passed. */
static double late(const lw_run *run, int i) { return part*fmax(run->d->o.relative, run->d->o.absolute)*run->kinks->of[i].greatest; }

/* Distance from where kink i is passed. */
static double ahead(const lw_run *run, int i) { return run->kinks->of[i].sense*run->kinks->side[i] + late(run, i); }

double lw_run_kink_ahead(lw_run *run, double t, const double *y)
{
    const lw_equations *eq = &run->d->eq;
    struct lw_kinks *k = run->kinks;
    double least = INFINITY;
    eq->place_states(eq->context, y + lw_run_states(run));
    eq->switches(eq->context, t, y, y + eq->n_q, k->force, k->side);
    for (int i = 0; i < k->n; i++)
        least = fmin(least, ahead(run, i));
    return least;
}

bool lw_run_pass_kinks(lw_run *run, double t, const double *y, bool event)
{
    struct lw_kinks *k = run->kinks;
    bool any = false;
    if (k)
        lw_run_kink_ahead(run, t, y);
    for (int i = 0; k && i < k->n; i++) {
        bool passed = ahead(run, i) <= (event ? late(run, i) : 0);       /* at an event: up to rounding */
        k->of[i].sense = passed ? -k->of[i].sense : k->of[i].sense;
        k->of[i].greatest = fmax(k->of[i].greatest, fabs(k->side[i]));
        any = any || passed;
    }
    return any;
}

void lw_run_start_kinks(lw_run *run, double t, const double *y)
{
    struct lw_kinks *k = run->kinks;
    if (k)
        lw_run_kink_ahead(run, t, y);
    for (int i = 0; k && i < k->n; i++) {
        k->of[i].sense = k->side[i] > 0 ? 1 : -1;
        k->of[i].greatest = fabs(k->side[i]);
    }
}
