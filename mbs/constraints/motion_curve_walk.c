/* mbs/constraints/motion_curve_walk.c - following the curve of postures. */
#include "base/number.h"
#include "mbs/constraints/motion_curve_internal.h"
#include "base/vector.h"

#include <stdlib.h>
#include <string.h>

static const double longest_step = 0.5;    /* so that the end points show what lies between them       */
static const double closing = 1e-8;        /* largest distance from the start at which a curve is closed */

/* ---- nodes ------------------------------------------------------------------------------------- */

static lw_status add_node(lw_motion_curve *b, const double *q, int *index)
{
    if (b->n_node % 64 == 0) {
        lw_motion_curve_node *grown = realloc(b->node, (size_t)(b->n_node + 64)*sizeof *grown);
        if (!grown)
            return LW_E_MEMORY;
        b->node = grown;
    }
    lw_motion_curve_node *p = &b->node[b->n_node];
    p->q = calloc(3*(size_t)b->n, sizeof *p->q);
    if (!p->q)
        return LW_E_MEMORY;
    p->kappa = 0.0;
    memcpy(p->q, q, (size_t)b->n*sizeof *q);
    *index = b->n_node++;
    return LW_OK;
}

static void drop_nodes(lw_motion_curve *b, int n)
{
    while (b->n_node > n)
        free(b->node[--b->n_node].q);
}

/* Compute tangent (on the side of f->row), reach and curvature of a node, so that f can step from it.  The stored
 * tangent points to growing stations. */
static bool look_around(lw_motion_curve *b, int node, int way)
{
    lw_motion_curve_node *p = &b->node[node];
    double *q = p->q, *series = b->series;
    if (!(lw_continuation_factor(&b->f, q) > 1e-14) || !lw_continuation_tangent(&b->f))
        return false;
    p->kappa = lw_continuation_bound(&b->f, q);
    memcpy(series, q, (size_t)b->n*sizeof *q);
    lw_continuation_series(&b->f, 4, NULL, series);
    for (int i = 0; i < b->n; i++) {
        lw_node_tangent(b, node)[i] = way*b->f.tangent[i];
        lw_node_bend(b, node)[i] = series[2*b->n + i];
        b->f.row[i] = b->f.tangent[i];
        b->f.origin[i] = q[i];
    }
    b->worst = fmax(b->worst, lw_continuation_residual(&b->f, q));
    return isfinite(p->kappa);
}

/* ---- the start --------------------------------------------------------------------------------- */

static lw_status begin(lw_motion_curve *b, lw_error *e)
{
    int freedoms = lw_continuation_freedoms(&b->f, b->node[0].q, b->f.row), inputs = b->s->n_input;
    int counted = b->s->n_q - b->s->n_row;
    if (freedoms == 2 && lw_motion_curve_leave(b, b->node[0].q))
        freedoms = lw_continuation_freedoms(&b->f, b->node[0].q, b->f.row);
    if (freedoms < 0)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (freedoms == 0 && counted > 0 && inputs > counted)
        return lw_error_set(e, LW_E_ARG, "the linkage has %d freedom%s but %d input%s; leave out %d", counted,
                            lw_plural(counted), inputs, lw_plural(inputs), inputs - counted);
    if (freedoms == 0)
        return lw_error_set(e, LW_E_NUMERIC, "the linkage cannot move: in its posture every freedom is taken");
    if (freedoms > 1)
        return lw_error_set(e, LW_E_NUMERIC, "the posture has %d freedoms where one is expected: it is a branch point, "
                            "or a part moves freely; draw the linkage in another posture", freedoms);
    lw_system_measure(b->s, b->s->input_joint[b->input], b->node[0].q, b->a);
    double rate = lw_dot(b->n, b->a, b->f.row);
    for (int i = 0; i < b->n; i++)
        b->f.row[i] *= rate < 0.0 ? -1.0 : 1.0;
    if (!look_around(b, 0, 1))
        return lw_error_set(e, LW_E_NUMERIC, "the posture is a branch point; draw the linkage in another posture");
    return LW_OK;
}

/* ---- steps ------------------------------------------------------------------------------------- */

/* d arc / d h = sqrt(1 + |2 q_2 h + ..|^2), which is 1/(t . t_far) at the far end */
static void measure_arc(lw_motion_curve *b, lw_motion_curve_segment *s)
{
    const double *c = lw_node_bend(b, s->base);
    double h = s->length, end = 1.0/fmax(0.1, lw_dot(b->n, lw_node_tangent(b, s->base), lw_node_tangent(b, s->far)));
    s->square = 2.0*lw_dot(b->n, c, c);
    s->cube = (end - 1.0 - s->square*h*h)/(h*h*h);
    if (fabs(s->cube*h) > s->square + 1.0) {              /* caused by rounding in a short step */
        s->square = (end - 1.0)/(h*h);
        s->cube = 0.0;
    }
    s->arc = h + s->square*h*h*h/3.0 + s->cube*h*h*h*h/4.0;
}

static lw_status add_segment(lw_motion_curve *b, int base, int far, int way, double length, double singular)
{
    if (b->n_segment % 64 == 0) {
        lw_motion_curve_segment *grown = realloc(b->segment, (size_t)(b->n_segment + 64)*sizeof *grown);
        if (!grown)
            return LW_E_MEMORY;
        b->segment = grown;
    }
    lw_motion_curve_segment *s = &b->segment[b->n_segment++];
    *s = (lw_motion_curve_segment){ .base = base, .far = far, .way = way, .length = length, .singular = singular };
    measure_arc(b, s);
    return LW_OK;
}

/* One step from node `here`, for which f is prepared, that stays on the branch.  q: its end; *h: its length. */
static bool step(lw_motion_curve *b, int here, double *q, double *h)
{
    double kappa = b->node[here].kappa;
    for (*h = fmin(longest_step, 0.5*LW_CONTINUATION_SHARE/kappa); *h >= LW_CONTINUATION_LEAST; *h *= 0.5) {
        lw_continuation_sum(&b->f, 4, b->series, *h, q);
        b->f.distance = *h;
        if (lw_continuation_correct(&b->f, q) && lw_continuation_distance(&b->f, q, b->node[here].q) < 1.0/kappa)
            return true;
    }
    return false;
}

/* ---- branch points ----------------------------------------------------------------------------- */

static void set_distance(void *context, double h)
{
    lw_motion_curve *b = context;
    b->f.distance = h;
}

/* out = q - start with whole turns removed; returns its component along the tangent of the start. */
static double from_start(const lw_motion_curve *b, const double *q, double *out)
{
    for (int i = 0; i < b->n; i++) {
        out[i] = q[i] - b->node[0].q[i];
        if (i % 3 == 2)
            out[i] -= 2.0*LW_PI*round(out[i]/(2.0*LW_PI));
    }
    return lw_dot(b->n, out, lw_node_tangent(b, 0));
}

/* Distance of the start ahead of node `base` along f->row, if it is within reach of a step across a branch point. */
static double start_ahead(lw_motion_curve *b, int base, double distance)
{
    from_start(b, b->node[base].q, b->a);
    double h = -lw_dot(b->n, b->f.row, b->a), size = sqrt(lw_dot(b->n, b->a, b->a));
    return h > 1.000001*distance && h <= 4.0*distance && size < 2.0*h ? h : HUGE_VAL;
}

/* No step is short enough at node `here`: cross the branch point ahead along the Taylor series of an earlier node
 * that is far enough from it for good derivatives.  The posture on the far side must agree with the series much
 * better than its reach. */
static lw_status leap(lw_motion_curve *b, int first_segment, int way, int here, double ahead, int *far)
{
    double away = 0.0;
    int base = here, cut = b->n_segment;
    while (cut > first_segment && away < LW_CONTINUATION_BACK) {
        cut--;
        away += b->segment[cut].arc;
        base = b->segment[cut].base;
    }
    for (int i = 0; i < b->n; i++)
        b->f.row[i] = way*lw_node_tangent(b, base)[i];
    memcpy(b->a, b->node[here].q, (size_t)b->n*sizeof *b->a);
    double distance = ahead;
    for (int i = 0; i < b->n; i++)
        distance += b->f.row[i]*(b->a[i] - b->node[base].q[i]);
    if (!look_around(b, base, way))
        return LW_E_NUMERIC;
    lw_continuation_series(&b->f, LW_MOTION_CURVE_ORDER, NULL, b->series);
    double stop = way > 0 ? start_ahead(b, base, distance) : HUGE_VAL;
    for (double share = 2.0; share <= 4.0; share += 0.5) {
        double h = fmin(share*distance, stop), *q = b->b, *p = b->c;
        lw_continuation_sum(&b->f, LW_MOTION_CURVE_ORDER, b->series, h, p);
        memcpy(q, p, (size_t)b->n*sizeof *q);
        b->f.distance = h;
        if (!lw_continuation_correct(&b->f, q) || !(lw_continuation_factor(&b->f, q) > 1e-12) || !lw_continuation_tangent(&b->f))
            continue;
        double gap = lw_continuation_distance(&b->f, p, q), turn = lw_dot(b->n, b->f.tangent, b->f.row);
        if (!(gap*lw_continuation_bound(&b->f, q) < 0.01) || !(turn > 0.5))
            continue;
        double singular = lw_continuation_locate(&b->f, LW_MOTION_CURVE_ORDER, b->series, distance, set_distance, b);
        b->n_segment = cut;
        drop_nodes(b, base + 1);
        lw_status s = add_node(b, q, far);
        if (s != LW_OK || !look_around(b, *far, way))
            return s != LW_OK ? s : LW_E_NUMERIC;
        return add_segment(b, base, *far, way, h, singular);
    }
    return LW_E_NUMERIC;
}

/* ---- the whole curve --------------------------------------------------------------------------- */

/* Did the last segment, from `before` (along the tangent of the start) to node `far`, pass the start?  Then end it at
 * the start. */
static lw_status close_up(lw_motion_curve *b, double before, int far, bool *closed)
{
    lw_motion_curve_segment *s = &b->segment[b->n_segment - 1];
    double after = from_start(b, b->node[far].q, b->a), size = sqrt(lw_dot(b->n, b->a, b->a));
    *closed = false;
    bool there = size < closing;      /* also after a singular step that ended at the start */
    if (!(before < 0.0 && (after >= 0.0 || there)) || (s->singular >= 0.0 && !there) || size > 4.0*s->length
        || lw_dot(b->n, lw_node_tangent(b, far), lw_node_tangent(b, 0)) < 0.5)
        return LW_OK;
    memcpy(b->c, b->node[far].q, (size_t)b->n*sizeof *b->c);
    for (int i = 0; i < b->n; i++) {
        b->f.row[i] = lw_node_tangent(b, 0)[i];
        b->f.origin[i] = b->node[far].q[i] - b->a[i];     /* the start with whole turns added */
    }
    b->f.distance = 0.0;
    for (int i = 0; i < b->n; i++)
        b->c[i] = b->node[far].q[i] - after*b->f.row[i];
    if (!lw_continuation_correct(&b->f, b->c))
        return LW_OK;
    double gap = 0.0;
    for (int i = 0; i < b->n; i++)
        gap = fmax(gap, fabs(b->c[i] - b->f.origin[i]));
    if (gap > closing)
        return LW_OK;
    *closed = true;
    for (int i = 0; i < b->n; i++)
        b->node[far].q[i] = b->f.origin[i];
    int base = s->base;
    memcpy(lw_node_tangent(b, far), lw_node_tangent(b, 0), 2*(size_t)b->n*sizeof(double));
    b->node[far].kappa = b->node[0].kappa;
    s->length = 0.0;
    for (int i = 0; i < b->n; i++)
        s->length += lw_node_tangent(b, base)[i]*(b->node[far].q[i] - b->node[base].q[i]);
    measure_arc(b, s);
    if (s->length < 1e-9) {                               /* the step ended at the start */
        b->n_segment--;
        b->segment[b->n_segment - 1].far = far;
    }
    return LW_OK;
}

static bool too_far(const lw_motion_curve *b, const double *q)
{
    for (int i = 0; i < b->n; i++)
        if (i % 3 != 2 && fabs(q[i]) > b->reach)
            return true;
    return false;
}

/* Follow the curve from node 0, for which f is prepared, in one direction to its end. */
static lw_status go(lw_motion_curve *b, int way, lw_motion_curve_end *end)
{
    int here = 0, first = b->n_segment;
    for (;;) {
        double h, before = from_start(b, b->node[here].q, b->a);
        int far;
        if (b->stop && *b->stop)
            return LW_STOPPED;
        if (b->n_segment >= b->most) {
            *end = LW_MOTION_CURVE_STOPPED;
            return LW_OK;
        }
        if (step(b, here, b->b, &h)) {
            lw_status s = add_node(b, b->b, &far);
            if (s != LW_OK)
                return s;
            if (!look_around(b, far, way)) {
                drop_nodes(b, far);
                *end = LW_MOTION_CURVE_LOST;
                return LW_OK;
            }
            s = add_segment(b, here, far, way, h, -1.0);
            if (s != LW_OK)
                return s;
        } else {
            lw_status s = leap(b, first, way, here, 0.5/b->node[here].kappa, &far);
            if (s == LW_E_MEMORY)
                return s;
            if (s != LW_OK) {
                *end = LW_MOTION_CURVE_LOST;
                return LW_OK;
            }
        }
        bool closed = false;
        lw_status s = way > 0 ? close_up(b, before, far, &closed) : LW_OK;
        if (s != LW_OK || closed) {
            *end = LW_MOTION_CURVE_CLOSED;
            return s;
        }
        if (way > 0 && from_start(b, b->node[far].q, b->a) >= 0.0 && before < 0.0) {
            for (int i = 0; i < b->n; i++)
                b->f.row[i] = lw_node_tangent(b, far)[i];
            look_around(b, far, way);                     /* close_up may have changed f */
        }
        here = far;
        if (too_far(b, b->node[here].q)) {
            *end = LW_MOTION_CURVE_FAR;
            return LW_OK;
        }
    }
}

static void reverse(lw_motion_curve_segment *s, int n)
{
    for (int lo = 0, hi = n - 1; lo < hi; lo++, hi--) {
        lw_motion_curve_segment old = s[lo];
        s[lo] = s[hi];
        s[hi] = old;
    }
}

/* The segments from `half` on lead backwards from the start: put them first, in reverse order. */
static void order_segments(lw_motion_curve *b, int half)
{
    reverse(b->segment, half);
    reverse(b->segment, b->n_segment);
    b->start = b->n_segment - half;
}

lw_status lw_motion_curve_walk(lw_motion_curve *b, lw_error *e)
{
    lw_motion_curve_end end[2] = { LW_MOTION_CURVE_CLOSED, LW_MOTION_CURVE_CLOSED };
    lw_status s = begin(b, e);
    if (s != LW_OK)
        return s;
    s = go(b, 1, &end[0]);
    if (s == LW_OK && end[0] != LW_MOTION_CURVE_CLOSED) {
        int half = b->n_segment;
        for (int i = 0; i < b->n; i++)
            b->f.row[i] = -lw_node_tangent(b, 0)[i];
        if (look_around(b, 0, -1)) {
            b->most += half;
            s = go(b, -1, &end[1]);
            order_segments(b, half);
        }
    }
    if (s != LW_OK)
        return lw_error_set(e, s, s == LW_STOPPED ? "stopped before the whole motion was known" : "out of memory");
    b->end = end[0] > end[1] ? end[0] : end[1];
    b->before = malloc((size_t)(b->n_segment + 1)*sizeof *b->before);
    if (!b->before)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    b->before[0] = 0.0;
    for (int i = 0; i < b->n_segment; i++)
        b->before[i + 1] = b->before[i] + b->segment[i].arc;
    if (b->n_segment == 0)
        return lw_error_set(e, LW_E_NUMERIC, "the posture is at a branch point; draw the linkage in another posture");
    return LW_OK;
}
