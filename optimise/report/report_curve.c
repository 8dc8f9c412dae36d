/* optimise/report/report_curve.c - the motion of a linkage with higher groups, which has no arcs in closed form: the
 * curve of postures through the first station. */
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "mbs/constraints/circuits.h"
#include "mbs/batch/posture.h"
#include "optimise/report/report_internal.h"

void lw_fit_report_reversal(lw_fit_report *r, bool limit, int joint, double input)
{
    const lw_joint *j = &r->linkage.joint[joint];
    if (r->n_reversal < LW_REVERSAL_MAX)
        r->reversal[r->n_reversal++] = (lw_reversal){ limit, joint, j->link[j->link[0] == r->linkage.ground], input };
}

enum { STEPS = 720 };

typedef struct work {
    lw_system  s;
    lw_linkage k;
    lw_posture    posture;
    double     q[LW_SYSTEM_Q_MAX], dim[LW_DIM_MAX], mode[LW_MODE_MAX];
} work;

/* Measure postures of the whole curve at equal steps of the input.  Each posture is the seed of its own posture. */
static void whole_curve(const lw_plan *plan, const lw_fit_spec *s, const lw_candidate *c, lw_motion_curve *motion,
                        work *w, lw_motion_limits *limits)
{
    double end = lw_motion_curve_segments(motion), input, ends[2];
    for (int i = 0; i < 2; i++) {
        lw_motion_curve_posture(motion, i*end, w->q, NULL);
        ends[i] = lw_motion_curve_input(motion, w->q);
    }
    for (int i = 0; i < STEPS; i++) {
        double station = i ? lw_motion_curve_find(motion, 0, end, ends[0] + (ends[1] - ends[0])*i/STEPS) : 0;
        lw_motion_curve_posture(motion, station, w->q, NULL);
        lw_system_write(&w->s, w->q, &w->k);
        lw_status st = lw_plan_read(plan, &w->k, w->dim, w->mode, &input, NULL);
        if (st == LW_OK)
            st = lw_posture_solve(plan, c->dim, w->mode, input, 2, &w->posture);
        if (st == LW_OK)
            lw_motion_limits_posture(plan, s, &w->posture, limits);
        limits->no_memory |= st == LW_E_MEMORY;
    }
}

/* The part of the curve from limit to limit that holds the start, as stations `from` and `to`; limit[end]: it ends at
 * a limit. On a closed curve the part may reach across the seam. */
static void find_part(const lw_motion_curve *motion, double *from, double *to, bool limit[2])
{
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    double start = lw_motion_curve_start(motion), end = lw_motion_curve_segments(motion), lowest = NAN, highest = NAN;
    bool closed = lw_motion_curve_ended(motion) == LW_MOTION_CURVE_CLOSED;
    *from = 0;
    *to = end;
    limit[0] = limit[1] = false;
    for (int i = 0; i < n; i++) {
        if (e[i].kind != LW_EVENT_LIMIT)
            continue;
        lowest = isnan(lowest) ? e[i].station : lowest;
        highest = e[i].station;
        if (e[i].station <= start) {
            *from = e[i].station;
            limit[0] = true;
        } else if (!limit[1]) {
            *to = e[i].station;
            limit[1] = true;
        }
    }
    if (closed && !isnan(lowest) && !limit[0])             /* the seam lies between start and the limit before */
        *from = highest - end;
    if (closed && !isnan(lowest) && !limit[1])
        *to = lowest + end;
    if (closed && !isnan(lowest))
        limit[0] = limit[1] = true;
}

/* How many periods of the curve to add to a station so that it lies between `from` and `to`; NaN: it does not. */
static double periods_to(double station, double end, double from, double to)
{
    for (int turn = -1; turn <= 1; turn++)
        if (station + turn*end >= from && station + turn*end <= to)
            return turn;
    return NAN;
}

/* Add the range of the input and the reversals on that part, limits first. */
static void add_reversals(lw_motion_curve *motion, double shift, work *w, lw_fit_report *r)
{
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    double from, to, end = lw_motion_curve_segments(motion), input[2];
    bool limit[2];
    for (int i = 0; i < 2; i++) {
        lw_motion_curve_posture(motion, i*end, w->q, NULL);
        input[i] = lw_motion_curve_input(motion, w->q);
    }
    bool closed = lw_motion_curve_ended(motion) == LW_MOTION_CURVE_CLOSED;
    double period = closed ? input[1] - input[0] : 0;
    find_part(motion, &from, &to, limit);
    double ends[2] = { limit[0] ? NAN : input[0] - shift, limit[1] ? NAN : input[1] - shift };
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < n; i++) {
            double turn = periods_to(e[i].station, end, from, to), at = e[i].input - shift + turn*period;
            if (isnan(turn) || e[i].joint < 0 || (e[i].kind == LW_EVENT_LIMIT) != (pass == 0))
                continue;
            lw_fit_report_reversal(r, pass == 0, e[i].joint, at);
            if (pass == 0)
                ends[e[i].station + turn*end > 0.5*(from + to)] = at;
        }
    r->input_first = fmin(ends[0], ends[1]);
    r->input_last = fmax(ends[0], ends[1]);
}

static bool turns_without_limit(const lw_motion_curve *motion)
{
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(motion, &n);
    for (int i = 0; i < n; i++)
        if (e[i].kind == LW_EVENT_LIMIT)
            return false;
    return lw_motion_curve_ended(motion) == LW_MOTION_CURVE_CLOSED && lw_motion_curve_turns(motion, -1) != 0;
}

void lw_fit_report_curve(const lw_plan *plan, const lw_fit_spec *s, const lw_candidate *c, double from, double to,
                     lw_motion_limits *limits, lw_fit_report *r)
{
    enum { PATIENCE = 100 };                             /* random postures without a new circuit     */
    const lw_motion_curve_options o = { .input = 0 };
    lw_circuits all = { .n = 0 };
    work *w = calloc(1, sizeof *w);
    lw_status status = w ? lw_system_make(&r->linkage, NULL, 0, &w->s, NULL) : LW_E_MEMORY;
    if (status == LW_OK)
        status = lw_circuits_find(&w->s, NULL, &o, PATIENCE, 1, &all, NULL);
    r->no_memory |= status == LW_E_MEMORY;
    if (status == LW_OK) {
        w->k = r->linkage;
        r->circuits = all.n;
        r->turns = turns_without_limit(all.curve[0]);
        add_reversals(all.curve[0], r->linkage.input[0].value - plan->input_turns_per_period*c->input[0], w, r);
        if (r->turns && plan->input_turns_per_period == 1)
            whole_curve(plan, s, c, all.curve[0], w, limits);
    }
    lw_circuits_free(&all);
    if (w && !(r->turns && plan->input_turns_per_period == 1))
        lw_motion_limits_run(plan, s, c->dim, c->intended.mode, from, to, STEPS, limits);
    if (w)
        lw_system_free(&w->s);
    free(w);
}
