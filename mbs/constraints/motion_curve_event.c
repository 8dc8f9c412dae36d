/* mbs/constraints/motion_curve_event.c - events on a motion curve: joints that turn back, and branch points. */
#include "mbs/constraints/motion_curve_internal.h"

#include <stdlib.h>
#include <string.h>

/* First and second derivative of the displacement of joint j by arc length, for the curve q + t s + c s^2. */
static void rate_at(const lw_motion_curve *b, int joint, const double *node, double rate[2])
{
    double count[3];
    lw_system_measure_series(b->s, joint, 2, node, count);
    rate[0] = count[1];
    rate[1] = 2.0*count[2];
}

/* The first derivative alone, at distance h of a segment. */
static double rate_on(lw_motion_curve *b, const lw_motion_curve_segment *s, int joint, double h)
{
    double count[2], *q = b->series;                      /* posture and tangent, one after the other */
    lw_motion_curve_at(b, s, h, b->b, b->c);
    memcpy(q, b->b, (size_t)b->n*sizeof *q);
    memcpy(q + b->n, b->c, (size_t)b->n*sizeof *q);
    lw_system_measure_series(b->s, joint, 1, q, count);
    return count[1];
}

static lw_status add_event(lw_motion_curve *b, lw_motion_curve_event_kind kind, int joint, const lw_motion_curve_segment *s, double h)
{
    if (b->n_event % 32 == 0) {
        lw_motion_curve_event *grown = realloc(b->event, (size_t)(b->n_event + 32)*sizeof *grown);
        if (!grown)
            return LW_E_MEMORY;
        b->event = grown;
    }
    double share = h/s->length;
    lw_motion_curve_at(b, s, h, b->a, NULL);
    double station = (double)(s - b->segment) + (s->way > 0 ? share : 1.0 - share);
    b->event[b->n_event++] = (lw_motion_curve_event){ kind, joint, station, lw_motion_curve_input(b, b->a) };
    return LW_OK;
}

/* The root of the rate between h0 and h1, where the rates r0 and r1 have different signs. */
static double root(lw_motion_curve *b, const lw_motion_curve_segment *s, int joint, double h0, double r0, double h1, double r1)
{
    int kept = -1;
    for (int i = 0; i < 80 && h1 - h0 > 1e-15*s->length; i++) {
        double h = h1 - r1*(h1 - h0)/(r1 - r0);
        if (!(h > h0 && h < h1))
            h = 0.5*(h0 + h1);
        double r = rate_on(b, s, joint, h);
        if (fabs(r) < 1e-15)
            return h;
        if ((r > 0.0) == (r0 > 0.0)) {
            h0 = h, r0 = r;
            r1 *= kept == 0 ? 0.5 : 1.0;
            kept = 0;
        } else {
            h1 = h, r1 = r;
            r0 *= kept == 1 ? 0.5 : 1.0;
            kept = 1;
        }
    }
    return 0.5*(h0 + h1);
}

/* The inner extremum nearest to zero of a cubic given by values and slopes at 0 and 1; -1 unless its value is below a
 * fifth of both end values. */
static double dip(double r0, double r1, double d0, double d1)
{
    double way = r0 > 0.0 ? 1.0 : -1.0, best = -1.0;
    double c = d0, bq = 3.0*(r1 - r0) - 2.0*d0 - d1, a = 2.0*(r0 - r1) + d0 + d1;
    double disc = bq*bq - 3.0*a*c;
    if (disc < 0.0)
        return -1.0;
    double w = -(bq + (bq < 0.0 ? -sqrt(disc) : sqrt(disc))), x[2] = { w/(3.0*a), c/w };
    for (int i = 0; i < 2; i++)
        if (x[i] > 0.0 && x[i] < 1.0) {
            double at = r0 + x[i]*(c + x[i]*(bq + x[i]*a));
            if (at*way < 0.2*fmin(fabs(r0), fabs(r1)))
                best = x[i];
        }
    return best;
}

/* Does the joint stand still on the whole curve, apart from rounding next to branch points? */
static bool stands_still(const lw_motion_curve *b, int joint)
{
    double most = 0.0, rate[2];
    for (int i = 0; i < b->n_node; i++) {
        rate_at(b, joint, b->node[i].q, rate);
        most = fmax(most, fabs(rate[0]));
    }
    return most < 1e-8;
}

static lw_status watch(lw_motion_curve *b, int joint, lw_motion_curve_event_kind kind)
{
    for (int i = 0; i < b->n_segment; i++) {
        const lw_motion_curve_segment *s = &b->segment[i];
        double r0[2], r1[2];
        lw_status status = LW_OK;
        rate_at(b, joint, b->node[s->base].q, r0);
        rate_at(b, joint, b->node[s->far].q, r1);
        double L = s->way*s->arc, tiny = 1e-13;
        if (fabs(r0[0]) < tiny && fabs(r1[0]) < tiny)
            continue;
        if (fabs(r0[0]) < tiny && s->way > 0 && i == 0 && b->end == LW_MOTION_CURVE_CLOSED) {
            status = add_event(b, kind, joint, s, 0.0);   /* the drawn posture is an event */
        } else if (r0[0]*r1[0] < 0.0) {
            status = add_event(b, kind, joint, s, root(b, s, joint, 0.0, r0[0], s->length, r1[0]));
        } else if (r0[0]*r1[0] > 0.0) {
            double x = dip(r0[0], r1[0], r0[1]*L, r1[1]*L), h = x*s->length;
            double middle = x > 0.0 ? rate_on(b, s, joint, h) : r0[0];
            if (middle*r0[0] < 0.0) {
                status = add_event(b, kind, joint, s, root(b, s, joint, 0.0, r0[0], h, middle));
                if (status == LW_OK)
                    status = add_event(b, kind, joint, s, root(b, s, joint, h, middle, s->length, r1[0]));
            }
        } else if (fabs(r1[0]) < tiny && i + 1 < b->n_segment) {
            status = add_event(b, kind, joint, s, s->length);
        }
        if (status != LW_OK)
            return status;
    }
    return LW_OK;
}

static int by_station(const void *x, const void *y)
{
    const lw_motion_curve_event *p = x, *q = y;
    return p->station != q->station ? (p->station < q->station ? -1 : 1) : (int)p->kind - (int)q->kind;
}

lw_status lw_motion_curve_find_events(lw_motion_curve *b)
{
    lw_status status = LW_OK;
    int input = b->s->input_joint[b->input];
    for (int i = 0; status == LW_OK && i < b->n_segment; i++)
        if (b->segment[i].singular >= 0.0)
            status = add_event(b, LW_EVENT_CROSSING, -1, &b->segment[i], b->segment[i].singular);
    b->rests = stands_still(b, input);
    if (status == LW_OK && !b->rests)
        status = watch(b, input, LW_EVENT_LIMIT);
    for (int j = 0; status == LW_OK && j < b->s->n_joint; j++) {
        const lw_system_joint *p = &b->s->joint[j];
        bool driven = false;
        for (int i = 0; i < b->s->n_input; i++)
            driven = driven || b->s->input_joint[i] == j;
        bool counts = lw_joint_can_drive(p->kind);
        if (!driven && counts && (p->body[0] < 0 || p->body[1] < 0) && !stands_still(b, j))
            status = watch(b, j, LW_EVENT_TURNING);
    }
    if (b->n_event > 0)
        qsort(b->event, (size_t)b->n_event, sizeof *b->event, by_station);
    return status;
}
