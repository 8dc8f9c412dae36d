/* mbs/constraints/motion_curve.c - asking a curve of postures. */
#include "mbs/constraints/motion_curve_internal.h"

#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/vector.h"

void lw_motion_curve_free(lw_motion_curve *b)
{
    if (!b)
        return;
    for (int i = 0; i < b->n_node; i++)
        free(b->node[i].q);
    free(b->node);
    free(b->segment);
    free(b->before);
    free(b->event);
    free(b->series);
    lw_continuation_free(&b->f);
    lw_continuation_free(&b->driven);
    free(b);
}

/* ---- places ------------------------------------------------------------------------------------ */

/* Between here and a branch point there is no good Newton step; the series from the base holds. */
static bool near_singular(const lw_motion_curve_segment *s, double h)
{
    return s->singular >= 0.0 && fabs(h - s->singular) < 3e-3;
}

static bool settle(lw_motion_curve *b, const lw_motion_curve_segment *s, double h, double *q)
{
    lw_motion_curve_node *base = &b->node[s->base];
    const double *t = lw_node_tangent(b, s->base), *c = lw_node_bend(b, s->base);
    for (int i = 0; i < b->n; i++) {
        b->f.row[i] = s->way*t[i];
        b->f.origin[i] = base->q[i];
    }
    if (s->singular >= 0.0) {
        lw_continuation_factor(&b->f, base->q);
        lw_continuation_tangent(&b->f);
        memcpy(b->series, base->q, (size_t)b->n*sizeof *q);
        lw_continuation_series(&b->f, LW_MOTION_CURVE_ORDER, NULL, b->series);
        lw_continuation_sum(&b->f, LW_MOTION_CURVE_ORDER, b->series, h, q);
        if (near_singular(s, h))
            return true;
    } else
        for (int i = 0; i < b->n; i++)
            q[i] = base->q[i] + h*(b->f.row[i] + h*c[i]);
    b->f.distance = h;
    b->f.kappa = base->kappa;
    return lw_continuation_correct(&b->f, q);
}

void lw_motion_curve_at(lw_motion_curve *b, const lw_motion_curve_segment *s, double h, double *q, double *tangent)
{
    if (h <= 0.0 || h >= s->length) {
        const lw_motion_curve_node *end = &b->node[h <= 0.0 ? s->base : s->far];
        memcpy(q, end->q, (size_t)b->n*sizeof *q);
        if (tangent)
            memcpy(tangent, end->q + b->n, (size_t)b->n*sizeof *q);
        return;
    }
    settle(b, s, h, q);
    if (!tangent)
        return;
    if (near_singular(s, h)) {                            /* the derivative of the series */
        double length = 0.0;
        for (int i = 0; i < b->n; i++) {
            tangent[i] = 0.0;
            for (int k = LW_MOTION_CURVE_ORDER; k > 0; k--)
                tangent[i] = tangent[i]*h + k*b->series[k*b->n + i];
            length += tangent[i]*tangent[i];
        }
        for (int i = 0; i < b->n; i++)
            tangent[i] *= s->way/sqrt(length);
        return;
    }
    lw_continuation_factor(&b->f, q);
    lw_continuation_tangent(&b->f);
    for (int i = 0; i < b->n; i++)
        tangent[i] = s->way*b->f.tangent[i];
}

static const lw_motion_curve_segment *segment_of(const lw_motion_curve *b, double station, double *share)
{
    int i = (int)station;
    i = i < 0 ? 0 : i >= b->n_segment ? b->n_segment - 1 : i;
    *share = fmin(fmax(station - i, 0.0), 1.0);
    return &b->segment[i];
}

void lw_motion_curve_posture(lw_motion_curve *b, double station, double *q, double *tangent)
{
    double share;
    const lw_motion_curve_segment *s = segment_of(b, station, &share);
    lw_motion_curve_at(b, s, lw_segment_way(s, share), q, tangent);
}

/* Arc from the base to h */
static double arc_to(const lw_motion_curve_segment *s, double h)
{
    return h + s->square*h*h*h/3.0 + s->cube*h*h*h*h/4.0;
}

double lw_motion_curve_arc(const lw_motion_curve *b, double station)
{
    double share;
    const lw_motion_curve_segment *s = segment_of(b, station, &share);
    double h = lw_segment_way(s, share), arc = arc_to(s, h);
    return b->before[s - b->segment] + (s->way > 0 ? arc : s->arc - arc);
}

double lw_motion_curve_station(const lw_motion_curve *b, double arc)
{
    int lo = 0, hi = b->n_segment;
    while (hi - lo > 1) {
        int middle = (lo + hi)/2;
        if (b->before[middle] <= arc)
            lo = middle;
        else
            hi = middle;
    }
    const lw_motion_curve_segment *s = &b->segment[lo];
    double rest = arc - b->before[lo], want = s->way > 0 ? rest : s->arc - rest, h0 = 0.0, h1 = s->length;
    for (int i = 0; i < 100 && h1 - h0 > 1e-16*s->length; i++) {      /* bisection: arc_to rises */
        double h = 0.5*(h0 + h1);
        if (arc_to(s, h) < want)
            h0 = h;
        else
            h1 = h;
    }
    double share = 0.5*(h0 + h1)/s->length;
    share = share > 1.0 - 1e-15 ? 1.0 : share < 1e-15 ? 0.0 : share;
    return lo + (s->way > 0 ? share : 1.0 - share);
}

double lw_motion_curve_find(lw_motion_curve *b, double first, double last, double input)
{
    double *q = b->c, x[2] = { first, last }, g[2];
    for (int i = 0; i < 2; i++) {
        lw_motion_curve_posture(b, x[i], q, NULL);
        g[i] = lw_motion_curve_input(b, q) - input;
    }
    double lo = floor(first) + 1.0;                       /* whole segments first */
    while (lo < last) {
        double hi = ceil(last) - 1.0, middle = lo < hi ? floor(0.5*(lo + hi)) : lo;
        lw_motion_curve_posture(b, middle, q, NULL);
        double at = lw_motion_curve_input(b, q) - input;
        int side = (at > 0.0) == (g[0] > 0.0) ? 0 : 1;
        x[side] = middle;
        g[side] = at;
        lo = floor(x[0]) + 1.0;
        last = x[1];
    }
    double unit = lw_system_joint_unit(b->s, b->s->input_joint[b->input]);
    int kept = -1;
    for (int i = 0; i < 100 && fabs(x[1] - x[0]) > 1e-16*fmax(1.0, x[1]); i++) {       /* Illinois */
        double at = x[1] - g[1]*(x[1] - x[0])/(g[1] - g[0]);
        if (!(at > x[0] && at < x[1]))
            at = fabs(g[0]) < fabs(g[1]) ? x[0] : x[1];
        lw_motion_curve_posture(b, at, q, NULL);
        double value = lw_motion_curve_input(b, q) - input;
        if (fabs(value) <= 2e-16*fmax(unit, fabs(input)) || at == x[0] || at == x[1])
            return at;
        int side = (value > 0.0) == (g[0] > 0.0) ? 0 : 1;
        x[side] = at;
        g[side] = value;
        if (kept == side)
            g[1 - side] *= 0.5;
        kept = side;
    }
    return x[0];
}

/* ---- questions --------------------------------------------------------------------------------- */

lw_motion_curve_end lw_motion_curve_ended(const lw_motion_curve *b)   { return b->end; }
int           lw_motion_curve_segments(const lw_motion_curve *b) { return b->n_segment; }
bool          lw_motion_curve_rests(const lw_motion_curve *b)   { return b->rests; }
double        lw_motion_curve_length(const lw_motion_curve *b)  { return b->before[b->n_segment]; }
double        lw_motion_curve_start(const lw_motion_curve *b)   { return b->start; }
double        lw_motion_curve_worst(const lw_motion_curve *b)   { return b->worst*b->s->unit; }

const lw_motion_curve_event *lw_motion_curve_events(const lw_motion_curve *b, int *n)
{
    *n = b->n_event;
    return b->event;
}

double lw_motion_curve_input(const lw_motion_curve *b, const double *q)
{
    int joint = b->s->input_joint[b->input];
    double unit = lw_system_joint_unit(b->s, joint);
    return b->s->input_value[b->input] + unit*lw_system_measure(b->s, joint, q, NULL);
}

int lw_motion_curve_turns(const lw_motion_curve *b, int link)
{
    const double *first = b->node[b->segment[0].base].q, *last = b->node[b->segment[b->n_segment - 1].far].q;
    double way;
    if (b->end != LW_MOTION_CURVE_CLOSED)
        return 0;
    if (link < 0) {
        if (!lw_joint_turns(b->s->joint[b->s->input_joint[b->input]].kind))
            return 0;
        way = lw_motion_curve_input(b, last) - lw_motion_curve_input(b, first);
    } else {
        int body = b->s->body[link];
        way = body < 0 ? 0.0 : last[3*body + 2] - first[3*body + 2];
    }
    return (int)lround(way/(2.0*LW_PI));
}

/* A segment holds q when the plane through it has its point of the segment there. */
static bool segment_holds(lw_motion_curve *b, const lw_motion_curve_segment *s, const double *q)
{
    const double *base = b->node[s->base].q, *t = lw_node_tangent(b, s->base);
    double h = 0.0, size = 0.0, gap = 0.0, most = 4.0*s->arc*s->arc + 1e-12;
    for (int i = 0; i < b->n && size <= most; i++) {
        double d = q[i] - base[i];
        if (i % 3 == 2)
            d -= 2.0*LW_PI*round(d/(2.0*LW_PI));
        b->c[i] = base[i] + d;
        h += s->way*t[i]*d;
        size += d*d;
    }
    if (h < -1e-9 || h > s->length + 1e-9 || size > most)
        return false;
    lw_motion_curve_at(b, s, h, b->b, NULL);
    for (int i = 0; i < b->n; i++)
        gap = fmax(gap, fabs(b->b[i] - b->c[i]));
    return gap < 1e-7;
}

bool lw_motion_curve_holds(lw_motion_curve *b, const double *q)
{
    for (int i = 0; i < b->n_segment; i++)
        if (segment_holds(b, &b->segment[i], q))
            return true;
    return false;
}

int lw_motion_curve_side(lw_motion_curve *b, double station)
{
    if (b->driven.m != b->driven.n)
        return 0;
    if (!b->driven.matrix) {
        lw_motion_curve_posture(b, station, b->a, b->b);
        lw_system_measure(b->s, b->s->input_joint[b->input], b->a, b->c);
        return lw_dot(b->n, b->c, b->b) < 0.0 ? -1 : 1;
    }
    lw_motion_curve_posture(b, station, b->a, NULL);
    lw_continuation_factor(&b->driven, b->a);
    return lw_qr_determinant(b->n, b->driven.diag) < 0.0 ? -1 : 1;
}
