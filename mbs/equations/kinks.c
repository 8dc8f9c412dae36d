/* mbs/equations/kinks.c - where steps end because forces have kinks or jumps that depend on the motion. */
#include "mbs/equations/kinks.h"
#include "base/real.h"

#include <float.h>
#include <stdlib.h>

static const double part = 1e-3;             /* a kink is passed so far behind it, over the tolerance and its greatest distance so far */
static const double rounded = 64*DBL_EPSILON;        /* of coordinates and velocities */

struct lw_kinks {
    const lw_equations *eq;
    double tolerance;
    double *side, *force, *q, *v;            /* (n_switch), (n_v), (n_q), (n_v) scratch */
    struct { double sense, greatest, change[2]; } of[];  /* the side where the motion is; greatest distance so far; its change by errors of q, of v */
};

lw_status lw_kinks_make(const lw_equations *eq, lw_kinks **k)
{
    size_t n = (size_t)eq->n_switch;
    *k = NULL;
    if (n == 0)
        return LW_OK;
    if (!(*k = calloc(1, sizeof **k + n*sizeof *(*k)->of + (n + 2*(size_t)eq->n_v + (size_t)eq->n_q)*sizeof(double))))
        return LW_E_MEMORY;
    (*k)->eq = eq;
    (*k)->side = (double *)((*k)->of + n);
    (*k)->force = (*k)->side + n;
    (*k)->q = (*k)->force + eq->n_v;
    (*k)->v = (*k)->q + eq->n_q;
    return LW_OK;
}

void lw_kinks_free(lw_kinks *k) { free(k); }

static void look(lw_kinks *k, double t, const double *q, const double *v) { k->eq->switches(k->eq->context, t, q, v, k->force, k->side); }

/* How far behind a kink it is passed; a motion that was never farther away than by its error rests on it. */
static double late(const lw_kinks *k, int i)
{
    double error = k->of[i].change[0] + k->of[i].change[1];
    return k->of[i].greatest > error ? part*k->tolerance*k->of[i].greatest : error;
}

/* Distance from where kink i is passed. */
static double ahead(const lw_kinks *k, int i) { return k->of[i].sense*k->side[i] + late(k, i); }

/* A part of the error of coordinates and velocities that matters to no step. */
static double error_of(const lw_kinks *k) { return rounded + part*k->tolerance; }

/* Move each of the n numbers by a part of its error, with signs and sizes that do not cancel. */
static void disturb(double by, int n, const double *from, double *to)
{
    for (int i = 0; i < n; i++)
        to[i] = from[i] + by*(1 + fabs(from[i]))*((double)((i*5 + 3)%11) - 5.5)/5.5;
}

/* Distances from the kinks where coordinates (which: 0) or velocities (1) are off by their errors. */
static void find_change(lw_kinks *k, double t, const double *q, const double *v, int which)
{
    disturb(which ? 0 : error_of(k), k->eq->n_q, q, k->q);
    disturb(which ? error_of(k) : 0, k->eq->n_v, v, k->v);
    look(k, t, k->q, k->v);
    for (int i = 0; i < k->eq->n_switch; i++)
        k->of[i].change[which] = k->side[i];
}

void lw_kinks_start(lw_kinks *k, double tolerance, double t, const double *q, const double *v)
{
    k->tolerance = tolerance;
    find_change(k, t, q, v, 0);
    find_change(k, t, q, v, 1);
    look(k, t, q, v);
    for (int i = 0; i < k->eq->n_switch; i++) {
        k->of[i].sense = k->side[i] > 0 ? 1 : -1;
        k->of[i].greatest = fabs(k->side[i]);
        for (int which = 0; which < 2; which++)
            k->of[i].change[which] = fabs(k->side[i] - k->of[i].change[which]);
    }
}

double lw_kinks_ahead(lw_kinks *k, double t, const double *q, const double *v)
{
    double least = INFINITY;
    look(k, t, q, v);
    for (int i = 0; i < k->eq->n_switch; i++)
        least = fmin(least, ahead(k, i));
    return least;
}

bool lw_kinks_pass(lw_kinks *k, double t, const double *q, const double *v, bool event)
{
    bool any = false;
    look(k, t, q, v);
    for (int i = 0; i < k->eq->n_switch; i++) {
        bool passed = ahead(k, i) <= (event ? late(k, i) : 0);       /* at an event: up to rounding */
        k->of[i].sense = passed ? -k->of[i].sense : k->of[i].sense;
        k->of[i].greatest = fmax(k->of[i].greatest, fabs(k->side[i]));
        any = any || passed;
    }
    return any;
}

bool lw_kinks_crossed(const lw_kinks *k, int i, double before, double side, double h)
{
    double error = k->of[i].change[0] + k->of[i].change[1]*fmax(1, rounded/(h*error_of(k)));
    return (before > 0) != (side > 0) && fmax(fabs(before), fabs(side)) > error;
}
