/* mbs/equations/kinks.c - where steps end because forces have kinks or jumps that depend on the motion. */
#include "mbs/equations/kinks.h"
#include "base/real.h"

#include <stdlib.h>

static const double part = 1e-3;             /* a kink is passed so far behind it, over the tolerance and its greatest distance so far */

struct lw_kinks {
    const lw_equations *eq;
    double tolerance;
    double *side, *force;                    /* (n_switch), (n_v) scratch */
    struct { double sense, greatest; } of[]; /* the side where the motion is; greatest distance so far */
};

lw_status lw_kinks_make(const lw_equations *eq, lw_kinks **k)
{
    size_t n = (size_t)eq->n_switch;
    *k = NULL;
    if (n == 0)
        return LW_OK;
    if (!(*k = calloc(1, sizeof **k + n*sizeof *(*k)->of + (n + (size_t)eq->n_v)*sizeof(double))))
        return LW_E_MEMORY;
    (*k)->eq = eq;
    (*k)->side = (double *)((*k)->of + n);
    (*k)->force = (*k)->side + n;
    return LW_OK;
}

void lw_kinks_free(lw_kinks *k) { free(k); }

static void look(lw_kinks *k, double t, const double *q, const double *v) { k->eq->switches(k->eq->context, t, q, v, k->force, k->side); }

/* How far behind a kink it is passed. */
static double late(const lw_kinks *k, int i) { return part*k->tolerance*k->of[i].greatest; }

/* Distance from where kink i is passed. */
static double ahead(const lw_kinks *k, int i) { return k->of[i].sense*k->side[i] + late(k, i); }

void lw_kinks_start(lw_kinks *k, double tolerance, double t, const double *q, const double *v)
{
    k->tolerance = tolerance;
    look(k, t, q, v);
    for (int i = 0; i < k->eq->n_switch; i++) {
        k->of[i].sense = k->side[i] > 0 ? 1 : -1;
        k->of[i].greatest = fabs(k->side[i]);
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
