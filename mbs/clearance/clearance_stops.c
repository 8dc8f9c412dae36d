/* mbs/clearance/clearance_stops.c - rigid stops in tree coordinates (mbs/equations/rigid_stops_internal.h).  Forces of
 * contacts are finite, so they take no part in an impact. */
#include <string.h>
#include "base/real.h"
#include "mbs/clearance/clearance_internal.h"

/* Least mobility of a stop that gives way, times the greatest mass. */
static const double least_mobility = 1e-9;

static double gap(void *context, int i, const double *y)
{
    lw_clearance_work *w = context;
    lw_tree_place(&w->c->tree, y, NULL, &w->state);
    lw_tree_write(&w->c->tree, &w->state, NULL, w->q, NULL);
    return lw_rigid_stop_gap(&w->c->s, &w->stop[i], w->q, NULL);
}

static lw_status motion(void *context, int i, double t, const double *y, double *g, lw_gap *out)
{
    lw_clearance_work *w = context;
    const lw_tree *tree = &w->c->tree;
    double ddu[LW_SYSTEM_Q_MAX], row[LW_SYSTEM_Q_MAX], a[LW_SYSTEM_Q_MAX];
    lw_status s = lw_clearance_accelerate(w, t, y, y + w->n_u, ddu);
    lw_tree_place(tree, y, y + w->n_u, &w->state);
    lw_tree_write(tree, &w->state, y + w->n_u, w->q, w->v);
    lw_tree_accelerations(tree, &w->state, ddu, a);
    *out = lw_rigid_stop_motion(&w->c->s, &w->stop[i], w->q, w->v, a, row);
    memset(g, 0, sizeof(double)*(size_t)w->n_u);
    lw_clearance_through_tree(w, row, g);
    return s;
}

static lw_status impulse(void *context, double t, const double *y, const double *g, double *change, double *mobility)
{
    lw_clearance_work *w = context;
    lw_status s = lw_clearance_respond(w, t, y, y + w->n_u, g, change);
    *mobility = 0;
    for (int k = 0; k < w->n_u; k++)
        *mobility += g[k]*change[k];
    return s == LW_OK && !(*mobility*w->heaviest > least_mobility) ? LW_NOTHING : s;
}

static lw_status pressure(void *context, int i, double t, const double *y, double *press)
{
    lw_clearance_work *w = context;
    double ddu[LW_SYSTEM_Q_MAX];
    lw_status s = lw_clearance_accelerate(w, t, y, y + w->n_u, ddu);
    *press = lw_clearance_stop_press(w, i);
    return s;
}

static lw_status arrange(void *context, int i, double t, double *y)
{
    lw_clearance_work *w = context;
    w->rows.stop[i] = w->stop[i].resting;
    return w->rows.stop[i] ? lw_clearance_project(w, &w->rows, t, y, y + w->n_u) : LW_OK;
}

static void note(void *context, int i, double t, bool impact, double rate)
{
    (void)i, (void)t, (void)rate;
    ((lw_clearance_work *)context)->r->strikes += impact;
}

static const char *name(void *context, int i)
{
    const lw_clearance_work *w = context;
    return w->c->m->linkage.joint[w->stop[i].joint].name;
}

lw_status lw_clearance_strike(lw_clearance_work *w, double t, double *y, unsigned long long events, double *flight, lw_error *e)
{
    double change[LW_SYSTEM_Q_MAX], gradient[LW_SYSTEM_Q_MAX];
    lw_stops stops = { .context = w, .n_stop = w->c->n_stop, .n = w->n_u, .v = w->n_u, .stop = w->stop, .name = name, .due = events,
                       .change = change, .gradient = gradient,
                       .least_bounce = LW_STOP_LEAST_BOUNCE, .passed_is_error = true, .gap = gap, .motion = motion,
                       .impulse = impulse, .pressure = pressure, .arrange = arrange, .note = note };
    bool changed;
    return lw_stops_strike(&stops, t, y, &changed, flight, e);
}
