/* mbs/dynamics/clearance_stop.c - rigid stops of models with clearance: Newton's restitution, rest, departure.
 *
 * As in mbs/dynamics/dynamics_contact.c, in tree coordinates: an impulse along the stop's measure that leaves the rows that
 * hold.  Forces of contacts are finite, so an impact passes them by. */
#include <math.h>
#include <string.h>
#include "mbs/dynamics/clearance_internal.h"

static const double low = 1e-13;             /* height of a bounce that is rest, scaled                    */

double lw_clearance_gap(lw_clearance_work *w, int i)
{
    const lw_rigid *p = &w->c->rigid[i];
    return p->sign*(lw_system_measure(&w->c->s, p->joint, w->q, w->row) - p->limit);
}

void lw_clearance_stop_rows(lw_clearance_work *w, const lw_row_choice *choice, bool series, int *n)
{
    const lw_system *s = &w->c->s;
    for (int i = 0; i < w->c->n_rigid; i++) {
        const lw_rigid *p = &w->c->rigid[i];
        double h[3] = { 0.0 };
        if (!choice->stop[i])
            continue;
        w->off[*n] = lw_system_measure(s, p->joint, w->series, w->row) - p->limit;
        lw_clearance_through_tree(w, w->row, w->a + *n*w->n_u);
        if (series)
            lw_system_measure_series(s, p->joint, 2, w->series, h);
        w->wanted[*n] = series ? -2.0*h[2] : 0.0;
        ++*n;
    }
}

/* First row of the stops among all */
static int first_row(const lw_clearance_work *w)
{
    int n = w->c->tree.n_row;
    for (int i = 0; i < w->c->n_journal; i++)
        n += w->rows.hold[i] ? 2 : w->rows.link[i] ? 1 : 0;
    return n;
}

double lw_clearance_stop_press(const lw_clearance_work *w, int i)
{
    int n = first_row(w);
    for (int k = 0; k < i; k++)
        n += w->rows.stop[k];
    return w->c->rigid[i].sign*w->lambda[n];
}

static double greatest(const double *x, int n)
{
    double most = 0.0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

static void place(lw_clearance_work *w, const double *u, const double *du)
{
    lw_tree_place(&w->c->tree, u, du, &w->state);
    lw_tree_write(&w->c->tree, &w->state, du, w->q, w->v);
}

/* Gap of stop i, its rate and acceleration, its row in g (n_u). */
static lw_status gap_motion(lw_clearance_work *w, int i, double t, const double *u, const double *du, double *g,
                            double gap[3])
{
    const lw_rigid *p = &w->c->rigid[i];
    double ddu[LW_SYSTEM_Q_MAX], h[3], row[LW_SYSTEM_Q_MAX], series[3*LW_SYSTEM_Q_MAX];
    int n = w->n_u, nq = w->c->s.n_q;
    lw_status s = lw_clearance_accelerate(w, t, u, du, ddu);
    place(w, u, du);
    gap[0] = lw_clearance_gap(w, i);
    memcpy(row, w->row, sizeof(double)*(size_t)nq);
    for (int k = 0; k < nq; k++)
        row[k] *= p->sign;
    memset(g, 0, sizeof(double)*(size_t)n);
    lw_clearance_through_tree(w, row, g);
    memcpy(series, w->q, sizeof(double)*(size_t)nq);
    memcpy(series + nq, w->v, sizeof(double)*(size_t)nq);
    for (int b = 0; b < w->c->tree.n_body; b++) {
        lw_vec2 bias = w->state.bias[b + 1];
        series[2*nq + 3*b] = 0.5*bias.x, series[2*nq + 3*b + 1] = 0.5*bias.y, series[2*nq + 3*b + 2] = 0.0;
    }
    lw_system_measure_series(&w->c->s, p->joint, 2, series, h);
    gap[1] = 0.0, gap[2] = 2.0*p->sign*h[2];
    for (int k = 0; k < n; k++) {
        gap[1] += g[k]*du[k];
        gap[2] += g[k]*ddu[k];
    }
    return s;
}

/* Rest on stop i from now on, unless other rows hold it there already. */
static lw_status rest_on(lw_clearance_work *w, int i, double t, double *u, double *du)
{
    w->rows.stop[i] = true;
    return lw_clearance_project(w, &w->rows, t, u, du);
}

static lw_status strike(lw_clearance_work *w, int i, double t, double *u, double *du, const double *g, double rate)
{
    double change[LW_SYSTEM_Q_MAX], again[LW_SYSTEM_Q_MAX], gap[3], way = 0.0, e = w->c->rigid[i].restitution;
    lw_status s = lw_clearance_respond(w, t, u, du, g, change);
    for (int k = 0; k < w->n_u; k++)
        way += g[k]*change[k];
    if (s != LW_OK || !(way*w->heaviest > 1e-9))
        return s == LW_OK ? LW_NOTHING : s;
    for (int k = 0; k < w->n_u; k++)
        du[k] -= (1.0 + e)*rate/way*change[k];
    w->r->strikes++;
    s = gap_motion(w, i, t, u, du, again, gap);
    bool rests = gap[2] <= 0.0 && (gap[1] <= 0.0 || gap[1]*gap[1] <= -2.0*gap[2]*low);
    return s == LW_OK && rests ? rest_on(w, i, t, u, du) : s;
}

static lw_status blocked(const lw_clearance_work *w, int i, double t, lw_error *e)
{
    return lw_error_set(e, LW_E_NUMERIC, "the stop of joint \"%s\" is hit at t = %.9g s, but motions and joints leave "
                        "it no way to give", w->c->m->linkage.joint[w->c->rigid[i].joint].name, t);
}

/* Strikes of all stops that are closed and closing; whether there was any. */
static lw_status strike_all(lw_clearance_work *w, double t, double *u, double *du, bool *any, lw_error *e)
{
    double g[LW_SYSTEM_Q_MAX], gap[3];
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < w->c->n_rigid; i++) {
        place(w, u, du);
        if (w->rows.stop[i] || lw_clearance_gap(w, i) > 1e-9)
            continue;
        s = gap_motion(w, i, t, u, du, g, gap);
        if (s == LW_OK && fabs(gap[0]) > 1e-6)
            return lw_error_set(e, LW_E_ARG, "the stop of joint \"%s\" is passed at t = %.9g s",
                                w->c->m->linkage.joint[w->c->rigid[i].joint].name, t);
        /* a stop just left closes by rounding at most */
        if (s != LW_OK || gap[1] > 0.0 || (gap[1] >= -1e-13*greatest(du, w->n_u) && gap[2] >= 0.0))
            continue;
        s = strike(w, i, t, u, du, g, gap[1]);
        if (s == LW_NOTHING)
            return blocked(w, i, t, e);
        *any = true;
    }
    return s;
}

static lw_status find_flight(lw_clearance_work *w, double t, const double *u, const double *du, double *flight)
{
    double g[LW_SYSTEM_Q_MAX], gap[3];
    lw_status s = LW_OK;
    *flight = 0.0;
    for (int i = 0; s == LW_OK && i < w->c->n_rigid; i++) {
        place(w, u, du);
        if (w->rows.stop[i] || fabs(lw_clearance_gap(w, i)) > 1e-9)
            continue;
        s = gap_motion(w, i, t, u, du, g, gap);
        double f = gap[1] > 0.0 && gap[2] < 0.0 ? -2.0*gap[1]/gap[2] : 0.0;
        if (f > 0.0 && (*flight == 0.0 || f < *flight))
            *flight = f;
    }
    return s;
}

lw_status lw_clearance_strike(lw_clearance_work *w, double t, double *u, double *du, double *flight, lw_error *e)
{
    double ddu[LW_SYSTEM_Q_MAX];
    for (int pass = 0; pass < 100; pass++) {
        bool any = false;
        lw_status s = strike_all(w, t, u, du, &any, e);
        for (int i = 0; s == LW_OK && i < w->c->n_rigid; i++) {
            if (!w->rows.stop[i])
                continue;
            s = lw_clearance_accelerate(w, t, u, du, ddu);
            if (s == LW_OK && lw_clearance_stop_press(w, i) <= 0.0) {
                w->rows.stop[i] = false;
                any = true;
            }
        }
        if (s != LW_OK)
            return s;
        if (!any)
            return find_flight(w, t, u, du, flight);
    }
    return lw_error_set(e, LW_E_NUMERIC, "stops strike each other without end at t = %.9g s", t);
}
