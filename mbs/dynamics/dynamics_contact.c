/* mbs/dynamics/dynamics_contact.c - rigid stops: impact with restitution, resting, leaving.
 *
 * An impact changes velocities by an impulse along the stop's measure that leaves all constraints:
 *     v+ = v - (1 + e) (g.v / g.W g) W g,     W: inverse mass on the constraints   (Newton's restitution).
 * Bounces get shorter by the factor e; one too low to be told from rounding (or, by an implicit method, from
 * its error) is taken as resting, a row of its own until the stop would have to pull. */
#include "mbs/dynamics/dynamics_run_internal.h"

#include <math.h>
#include <string.h>

static const double low = 1e-13;             /* height of a bounce that is rest, scaled                    */

/* Gap of a stop (>= 0 apart), scaled. */
static double gap_of(const lw_dynamics *d, const lw_contact *c, const double *q)
{
    const lw_joint_stop *p = &d->model->stop[c->joint];
    double scale = d->s.joint[c->joint].kind == LW_JOINT_REVOLUTE ? 1 : 1/d->s.unit;
    double value = lw_system_measure(&d->s, c->joint, q, NULL);
    return c->greatest ? p->greatest*scale - value : value - p->least*scale;
}

/* What a touching stop presses, > 0. */
static double pressure(const lw_dynamics *d, int place, const double *l)
{
    double push = -l[d->n_row + d->n_driven + place];
    return d->contact[d->touching[place]].greatest ? -push : push;
}

lw_status lw_run_gaps(void *context, double t, const double *y, double *g)
{
    lw_run *run = context;
    lw_dynamics *d = run->d;
    for (int i = 0; i < d->n_contact; i++)
        if (!d->contact[i].touching)
            g[i] = gap_of(d, &d->contact[i], y);
    if (d->n_touching == 0)
        return LW_OK;
    lw_status s = lw_mbs_accelerate(d, t, y, y + d->n_q, d->a, d->l, NULL);
    for (int k = 0; s == LW_OK && k < d->n_touching; k++)
        g[d->touching[k]] = pressure(d, k, d->l);
    return s;
}

static void note(lw_run *run, double t, const lw_contact *c, bool impact, double speed)
{
    lw_dynamics_report *r = run->r;
    double unit = run->d->s.joint[c->joint].kind == LW_JOINT_REVOLUTE ? 1 : run->d->s.unit;
    if (r->n_happening < LW_REPORT_EVENT_MAX)
        r->happening[r->n_happening++] = (lw_run_event){ t, c->joint, c->greatest, impact, speed*unit };
    r->n_seen++;
}

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += a[i]*b[i];
    return sum;
}

/* Rate and acceleration of a gap; its row in g (n_q). */
static lw_status gap_motion(lw_run *run, const lw_contact *c, double t, const double *y, double *g, double *rate,
                            double *acceleration)
{
    lw_dynamics *d = run->d;
    double sign = c->greatest ? -1 : 1, series[3*LW_SYSTEM_Q_MAX], out[3];
    int n = d->n_q;
    lw_status s = lw_mbs_accelerate(d, t, y, y + n, d->a, d->l, NULL);
    lw_system_measure(&d->s, c->joint, y, g);
    for (int i = 0; i < n; i++)
        g[i] *= sign;
    *rate = dot(g, y + n, n);
    memcpy(series, y, 2*(size_t)n*sizeof *series);
    for (int i = 0; i < n; i++)
        series[2*n + i] = 0.5*d->a[i];
    lw_system_measure_series(&d->s, c->joint, 2, series, out);
    *acceleration = 2*sign*out[2];
    return s;
}

static lw_status touch(lw_run *run, int which, double t, double *y)
{
    lw_dynamics *d = run->d;
    if (d->n_touching == LW_STOP_ROW_MAX)
        return lw_error_set(run->e, LW_E_NUMERIC, "more than %d stops touch at t = %.9g s", LW_STOP_ROW_MAX, t);
    int rank = d->rank;
    d->touching[d->n_touching++] = which;
    d->contact[which].touching = true;
    lw_status s = lw_mbs_arrange(d, t, y);
    if (s == LW_OK && d->rank == rank) {          /* held already: nothing more to say */
        d->n_touching--;
        d->contact[which].touching = false;
        s = lw_mbs_arrange(d, t, y);
    }
    return s == LW_OK ? lw_run_project(run, t, y) : s;
}

static lw_status leave(lw_run *run, int place, double t, const double *y)
{
    lw_dynamics *d = run->d;
    d->contact[d->touching[place]].touching = false;
    d->n_touching--;
    for (int k = place; k < d->n_touching; k++)
        d->touching[k] = d->touching[k + 1];
    return lw_mbs_arrange(d, t, y);
}

/* Does a gap that opens at this rate stay as good as closed? */
static bool rests(const lw_run *run, double rate, double acceleration)
{
    double height = run->r->formulation == LW_FORMULATION_CVODE ? fmax(low, run->d->o.absolute) : low;
    return acceleration <= 0 && (rate <= 0 || rate*rate <= -2*acceleration*height);
}

/* One stop whose gap is closed and closing. */
static lw_status strike(lw_run *run, int which, double t, double *y, double *g, double rate)
{
    lw_dynamics *d = run->d;
    lw_contact *c = &d->contact[which];
    double e = d->model->stop[c->joint].restitution, acceleration, change[LW_SYSTEM_Q_MAX];
    double before = lw_forces_kinetic(&d->f, y + d->n_q), way = lw_mbs_impulse(d, g, change);
    int n = d->n_q;
    if (!(way > 0))
        return touch(run, which, t, y);
    for (int i = 0; i < n; i++)
        y[n + i] -= (1 + e)*rate/way*change[i];
    lw_status s = gap_motion(run, c, t, y, g, &rate, &acceleration);
    if (s == LW_OK && rests(run, rate, acceleration))
        s = touch(run, which, t, y);
    else if (e == 0 && s == LW_OK)
        for (int i = 0; i < n; i++)
            y[n + i] -= rate/way*change[i];
    if (run->has_work)
        y[2*n] += lw_forces_kinetic(&d->f, y + n) - before;
    return s;
}

/* How long the shortest flight that begins now will last [s]; 0: none does. */
static lw_status find_flight(lw_run *run, double t, const double *y)
{
    lw_dynamics *d = run->d;
    double g[LW_SYSTEM_Q_MAX], rate, acceleration;
    run->flight = 0;
    for (int i = 0; i < d->n_contact; i++) {
        const lw_contact *c = &d->contact[i];
        if (c->touching || fabs(gap_of(d, c, y)) > 1e-9)
            continue;
        lw_status s = gap_motion(run, c, t, y, g, &rate, &acceleration);
        if (s != LW_OK)
            return s;
        double flight = rate > 0 && acceleration < 0 ? -2*rate/acceleration : 0;
        if (flight > 0 && (run->flight == 0 || flight < run->flight))
            run->flight = flight;
    }
    return LW_OK;
}

lw_status lw_run_contacts(lw_run *run, double t, double *y, bool *changed)
{
    lw_dynamics *d = run->d;
    double g[LW_SYSTEM_Q_MAX], rate, acceleration;
    lw_status s = LW_OK;
    *changed = false;
    for (int pass = 0; s == LW_OK && pass < 100; pass++) {
        bool any = false;
        for (int i = 0; s == LW_OK && i < d->n_contact; i++) {
            lw_contact *c = &d->contact[i];
            if (c->touching || gap_of(d, c, y) > 1e-9)
                continue;
            s = gap_motion(run, c, t, y, g, &rate, &acceleration);
            if (s != LW_OK || rate > 0 || (rate == 0 && acceleration >= 0) || fabs(gap_of(d, c, y)) > 1e-6)
                continue;
            note(run, t, c, true, rate);
            s = strike(run, i, t, y, g, rate);
            any = true;
        }
        for (int k = 0; s == LW_OK && k < d->n_touching; k++) {
            s = lw_mbs_accelerate(d, t, y, y + d->n_q, d->a, d->l, NULL);
            if (s != LW_OK || pressure(d, k, d->l) > 0)
                continue;
            note(run, t, &d->contact[d->touching[k]], false, 0);
            s = leave(run, k, t, y);
            any = true;
            break;
        }
        if (!any)
            return s == LW_OK ? find_flight(run, t, y) : s;
        *changed = true;
    }
    return s == LW_OK ? lw_error_set(run->e, LW_E_NUMERIC, "stops strike each other without end at t = %.9g s", t) : s;
}
