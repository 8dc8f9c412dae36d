/* mbs/run/stops.c - rigid stops in the bodies' coordinates (mbs/equations/rigid_stops_internal.h). */
#include "base/real.h"
#include "mbs/run/run_internal.h"

#include <assert.h>
#include <string.h>

/* Gap of stop i at the posture placed last; its gradient in g (n_v) unless NULL. */
static double gap_of(const lw_dynamics *d, int i, double *g)
{
    const lw_rigid_stop *p = &d->stop[i];
    int block[LW_ROW_BLOCKS];
    double row[LW_ROW_SIZE] = { 0 };
    d->eq.measure_blocks(d->eq.context, p->measure, block);
    double value = d->eq.measure(d->eq.context, p->measure, row, block);
    if (g)
        memset(g, 0, (size_t)d->n_v*sizeof *g);
    for (int k = 0; g && k < LW_ROW_SIZE && block[k/LW_BLOCK] >= 0; k++)
        g[LW_BLOCK*block[k/LW_BLOCK] + k%LW_BLOCK] = p->sign*row[k];
    return p->sign*(value - p->limit);
}

/* Place of stop i among those that rest. */
static int place_of(const lw_dynamics *d, int i)
{
    int place = 0;
    while (place < d->n_resting && d->resting[place] != i)
        place++;
    assert(place < d->n_resting);
    return place;
}

static const double rounding = 1e-13;        /* of a force or acceleration, over the greatest one that acts */
static const double least_press = 1e-100;    /* where no force acts; its product with a force does not underflow (CVODE) */

/* What presses on a stop that is rested on; > 0 where it is 0 up to rounding, since a stop that does not pull is not left. */
static double press_of(const lw_dynamics *d, int place)
{
    double most = 0;
    for (int k = 0; k < d->n_v; k++)
        most = fmax(most, fabs(d->force[k]));
    return -d->stop[d->resting[place]].sign*d->l[d->n_row + d->n_driven + place] + rounding*most + least_press;
}

lw_status lw_run_stop_events(void *context, double t, const double *y, double *g)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    if (run->kinks)
        g[d->n_stop + (d->eq.piece_left != NULL)] = lw_run_kink_ahead(run, t, y);
    if (d->eq.piece_left)
        g[d->n_stop] = d->eq.piece_left(d->eq.context, y);
    d->eq.place(d->eq.context, y);
    d->eq.place_states(d->eq.context, y + lw_run_states(run));
    for (int i = 0; i < d->n_stop; i++)
        if (!d->stop[i].resting)
            g[i] = gap_of(d, i, NULL);
    if (d->n_resting == 0)
        return LW_OK;
    lw_status s = lw_mbs_accelerate(d, t, y, y + d->n_q, d->a, d->l, NULL);
    for (int k = 0; s == LW_OK && k < d->n_resting; k++)
        g[d->resting[k]] = press_of(d, k);
    return s;
}

bool lw_run_stop_passed(const lw_run *run, const double *y, bool begin)
{
    const lw_dynamics *d = run->d;
    bool passed = false;
    if (d->n_stop > 0)
        d->eq.place(d->eq.context, y);
    for (int i = 0; i < d->n_stop; i++) {
        lw_rigid_stop *p = &d->stop[i];
        bool beyond = !p->resting && gap_of(d, i, NULL) < -(1e-6 + 10*d->o.absolute);
        passed |= beyond && !p->beyond;
        p->beyond = begin ? beyond : p->beyond;
    }
    return passed;
}

static double gap(void *context, int i, const double *y)
{
    const lw_dynamics *d = ((lw_run *)context)->d;
    d->eq.place(d->eq.context, y);
    return gap_of(d, i, NULL);
}

static lw_status motion(void *context, int i, double t, const double *y, double *g, lw_gap *out)
{
    lw_dynamics *d = ((lw_run *)context)->d;
    lw_status s = lw_mbs_accelerate(d, t, y, y + d->n_q, d->a, d->l, NULL);
    d->eq.place(d->eq.context, y);
    *out = (lw_gap){ .value = gap_of(d, i, g) };
    out->acceleration = d->stop[i].sign*d->eq.measure_bias(d->eq.context, d->stop[i].measure, y + d->n_q);
    for (int k = 0; k < d->n_v; k++) {
        out->rate += g[k]*y[d->n_q + k];
        out->acceleration += g[k]*d->a[k];
        out->rounding = fmax(out->rounding, rounding*fabs(d->force[k])*d->by_mass[k]);
    }
    return s;
}

static lw_status impulse(void *context, double t, const double *y, const double *g, double *change, double *mobility)
{
    (void)t, (void)y;                        /* the factors are those of the motion just found */
    *mobility = lw_mbs_impulse(((lw_run *)context)->d, g, change);
    return *mobility > 0 ? LW_OK : LW_NOTHING;
}

static lw_status pressure(void *context, int i, double t, const double *y, double *press)
{
    lw_dynamics *d = ((lw_run *)context)->d;
    lw_status s = lw_mbs_accelerate(d, t, y, y + d->n_q, d->a, d->l, NULL);
    *press = press_of(d, place_of(d, i));
    return s;
}

static lw_status arrange(void *context, int i, double t, double *y)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    if (!d->stop[i].resting) {
        int place = place_of(d, i);
        d->n_resting--;
        for (int k = place; k < d->n_resting; k++)
            d->resting[k] = d->resting[k + 1];
        return lw_mbs_arrange(d, t, y);
    }
    if (d->n_resting == LW_STOP_ROW_MAX)
        return lw_error_set(run->e, LW_E_NUMERIC, "more than %d stops touch at t = %.9g s", LW_STOP_ROW_MAX, t);
    int rank = d->rank;
    d->resting[d->n_resting++] = i;
    lw_status s = lw_mbs_arrange(d, t, y);
    if (s == LW_OK && d->rank == rank) {     /* other rows hold it already */
        d->n_resting--;
        d->stop[i].resting = false;
        s = lw_mbs_arrange(d, t, y);
    }
    return s == LW_OK ? lw_run_project(run, t, y) : s;
}

static const char *name(void *context, int i)
{
    const lw_dynamics *d = ((lw_run *)context)->d;
    return d->eq.name(d->eq.context, LW_NAMED_MEASURE, d->stop[i].measure);
}

static void note(void *context, int i, double t, bool impact, double rate)
{
    lw_run *run = context;
    lw_dynamics_report *r = run->r;
    const lw_rigid_stop *p = &run->d->stop[i];
    double unit = run->d->eq.measure_unit(run->d->eq.context, p->measure);
    if (r->n_event < LW_REPORT_EVENT_MAX)
        r->event[r->n_event++] = (lw_run_event){ t, p->joint, p->sign < 0, impact, rate*unit,
                                                 name(run, i), false };
    r->n_event_seen++;
}

lw_status lw_run_strike(lw_run *run, double t, double *y, unsigned long long events, bool *changed)
{
    lw_dynamics *d = run->d;
    bool implicit = run->r->formulation == LW_FORMULATION_CVODE;      /* its error hides low bounces */
    lw_stops stops = { .context = run, .n_stop = d->n_stop, .n = d->n_v, .v = d->n_q, .stop = d->stop, .name = name, .due = events,
                       .change = d->stop_v, .gradient = d->small_v,
                       .least_bounce = implicit ? fmax(LW_STOP_LEAST_BOUNCE, d->o.absolute) : LW_STOP_LEAST_BOUNCE,
                       .gap = gap, .motion = motion, .impulse = impulse, .pressure = pressure, .arrange = arrange,
                       .note = note };
    double before = d->eq.kinetic(d->eq.context, y + d->n_q);
    d->eq.place_states(d->eq.context, y + lw_run_states(run));       /* forces decide whether a stop is rested on */
    lw_status s = lw_stops_strike(&stops, t, y, changed, &run->flight, run->e);
    if (run->has_work && *changed)
        y[d->n_q + d->n_v] += d->eq.kinetic(d->eq.context, y + d->n_q) - before;
    return s;
}
