#include "optimise/report/report.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mbs/kinematics/motion.h"
#include "mbs/batch/posture.h"
#include "mbs/kinematics/output_limits.h"
#include "optimise/report/report_internal.h"
#include "optimise/problem/tracers.h"

/* ---- posture ------------------------------------------------------------------------------ */

static lw_status full_plan(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_linkage *linkage, lw_plan *plan, lw_error *e)
{
    lw_status st = lw_tracers_linkage(c->family, t, s, linkage, e);
    snprintf(linkage->name, sizeof linkage->name, "%s", lw_family_title(c->family));
    lw_plan_options options = { .tracers = lw_tracers_mask(t), .all_joints = true, .kind = LW_PLAN_GEARED };
    return st == LW_OK ? lw_plan_make(linkage, options, plan, e) : st;
}

/* Angles of the tracers' tools in the posture of a posture of the candidate. */
static void turn_tools(const lw_candidate *c, const lw_target *t, const lw_posture *posture, lw_linkage *linkage)
{
    for (int i = 0; i <= t->n_also; i++)
        linkage->tracer[i].angle = posture->angle[linkage->tracer[i].link][0] + (i > 0 ? c->tool[i - 1] : c->tool0);
}

/* Assembly modes of the candidate at a station, modes (LW_MODE_MAX). */
static void modes_at(const lw_candidate *c, const lw_plan *plan, size_t station, double *modes)
{
    memcpy(modes, c->intended.mode, sizeof c->intended.mode);
    for (int d = 0; c->mode_of && d < plan->n_dyad; d++)
        modes[d] = c->mode_of[station*(size_t)plan->n_dyad + (size_t)d];
}

/* ---- errors at the stations ------------------------------------------------------------------- */

/* Sums over the stations of one point, and the greatest errors. */
typedef struct sums {
    double f, distance, square, angle, distance_max, angle_max;
    size_t worst, worst_angle;
} sums;

static void add_distance(double weight, double d, size_t i, sums *sum)
{
    sum->f += weight*d*d;
    sum->distance += d;
    sum->square += d*d;
    if (d > sum->distance_max || i == 0) {
        sum->distance_max = d;
        sum->worst = i;
    }
}

static void add_angle(double weight, double d, size_t i, sums *sum)
{
    d = remainder(d, 2*LW_PI);
    sum->f += weight*d*d;
    sum->angle += fabs(d);
    if (fabs(d) > sum->angle_max || i == 0) {
        sum->angle_max = fabs(d);
        sum->worst_angle = i;
    }
}

/* Add the errors of each point at one station, and their share of eq. 17. */
static void add_station(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_linkage *linkage,
                        size_t i, const lw_posture *posture, lw_vec2 *at, sums *sum)
{
    lw_vec2 p = at[i] = posture->tracer[0][0];
    double weight = t->weight[i];
    if (lw_task_has_place(s->task))
        add_distance(s->a*weight, hypot(p.x - t->x[i], p.y - t->y[i]), i, &sum[0]);
    if (lw_task_has_angle(s->task))
        add_angle(s->b*weight, posture->angle[linkage->tracer[0].link][0] + c->tool0 - t->theta[i], i, &sum[0]);
    for (int q = 0; q < t->n_also; q++) {
        const lw_also *a = &t->also[q];
        p = at[(size_t)(q + 1)*t->n + i] = posture->tracer[q + 1][0];
        if (a->x)
            add_distance(s->a*a->weight[i], hypot(p.x - a->x[i], p.y - a->y[i]), i, &sum[q + 1]);
        if (a->theta)
            add_angle(s->b*a->weight[i], posture->angle[linkage->tracer[q + 1].link][0] + c->tool[q] - a->theta[i], i, &sum[q + 1]);
    }
}

/* Errors within the rounding of the places and angles from which they come are none. */
#define ROUNDING 1e-12
static void drop_rounding(double reach, int n, sums *sum)
{
    for (int k = 0; k < n; k++) {
        if (sum[k].distance_max <= ROUNDING*reach)
            sum[k].distance = sum[k].square = sum[k].distance_max = 0;
        if (sum[k].angle_max <= ROUNDING)
            sum[k].angle = sum[k].angle_max = 0;
    }
}

static void errors_of_first(const lw_target *t, const lw_fit_spec *s, const sums *sum, lw_fit_report *r)
{
    double n = (double)t->n;
    bool path = lw_task_has_place(s->task), angle = lw_task_has_angle(s->task);
    r->error_mean = path ? sum->distance/n : NAN;
    r->error_rms = path ? sqrt(sum->square/n) : NAN;
    r->error_max = path ? sum->distance_max : NAN;
    r->error_percent = t->length > 0 ? 100*r->error_mean/t->length : NAN;
    r->worst = path ? sum->worst : sum->worst_angle;
    r->angle_mean = angle ? sum->angle/n : NAN;
    r->angle_max = angle ? sum->angle_max : NAN;
}

static void errors_of_further(const lw_also *a, double n, const sums *sum, lw_also_error *r)
{
    r->mean = a->x ? sum->distance/n : NAN;
    r->rms = a->x ? sqrt(sum->square/n) : NAN;
    r->max = a->x ? sum->distance_max : NAN;
    r->percent = a->length > 0 ? 100*r->mean/a->length : NAN;
    r->worst = a->x ? sum->worst : sum->worst_angle;
    r->angle_mean = a->theta ? sum->angle/n : NAN;
    r->angle_max = a->theta ? sum->angle_max : NAN;
}

/* Note how far each pin has turned since the first station, whose angles of the links are in `first`: the greatest angle so far [rad]. */
static void add_turns(const lw_linkage *k, const double *first, const lw_posture *posture, double *turn)
{
    for (int i = 0; i < k->n_joint; i++) {
        const int *l = k->joint[i].link;
        double now = posture->angle[l[1]][0] - posture->angle[l[0]][0] - (first[l[1]] - first[l[0]]);
        turn[i] = fmax(turn[i], fabs(remainder(now, 2*LW_PI)));
    }
}

/* A pin that turns by less than this part of what another one turns by rests. */
#define RESTS 1e-3

static bool has_pin_at_rest(const lw_linkage *k, const double *turn)
{
    double least = INFINITY, most = 0;
    for (int i = 0; i < k->n_joint; i++)
        if (lw_joint_turns(k->joint[i].kind)) {
            least = fmin(least, turn[i]);
            most = fmax(most, turn[i]);
        }
    return least < RESTS*most;
}

/* at: positions, n of each point; then those of the curve samples. */
static lw_status station_errors(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c,
                                const lw_plan *plan, lw_vec2 *at, lw_fit_report *r)
{
    sums sum[1 + LW_ALSO_MAX] = { { .f = 0 } };
    double first[LW_LINK_MAX], turn[LW_JOINT_MAX] = { 0 };
    for (size_t i = 0; i < t->n; i++) {
        double modes[LW_MODE_MAX];
        lw_posture posture;
        modes_at(c, plan, i, modes);
        lw_status st = lw_posture_solve(plan, c->dim, modes, c->input[i], 0, &posture);
        if (st != LW_OK)
            return st;
        add_station(t, s, c, &r->linkage, i, &posture, at, sum);
        for (int l = 0; l < r->linkage.n_link && i == 0; l++)
            first[l] = posture.angle[l][0];
        add_turns(&r->linkage, first, &posture, turn);
    }
    r->rests = has_pin_at_rest(&r->linkage, turn);
    for (int j = 0; j < c->n_sample; j++) {                /* without timing, which has one point */
        double modes[LW_MODE_MAX];
        lw_posture posture;
        modes_at(c, plan, t->n + (size_t)j, modes);
        lw_status st = lw_posture_solve(plan, c->dim, modes, c->input[t->n + (size_t)j], 0, &posture);
        if (st != LW_OK)
            return st;
        at[t->n + (size_t)j] = posture.tracer[0][0];
    }
    double reach = 0;
    for (size_t i = 0; i < t->n*(size_t)(1 + t->n_also); i++)
        reach = fmax(reach, fmax(fabs(at[i].x), fabs(at[i].y)));
    for (int i = 0; i < r->linkage.n_joint; i++)
        reach = fmax(reach, fmax(fabs(r->linkage.joint[i].at.x), fabs(r->linkage.joint[i].at.y)));
    drop_rounding(reach, 1 + t->n_also, sum);
    r->objective = sum[0].f;
    errors_of_first(t, s, &sum[0], r);
    r->n_also = t->n_also;
    for (int k = 0; k < t->n_also; k++) {
        r->objective += sum[k + 1].f;
        errors_of_further(&t->also[k], (double)t->n, &sum[k + 1], &r->also[k]);
    }
    return LW_OK;
}

/* ---- the motion ----------------------------------------------------------------------------- */

enum { SAMPLES = 720 };           /* of a motion                                                  */

/* Update curve_max by the tracer's greatest distance from the target over [from, to] in one assembly mode. */
static void measure_distance(const lw_target *t, const lw_plan *plan, const lw_candidate *c, const double *modes,
                             double from, double to, lw_fit_report *r)
{
    lw_posture posture;
    for (int k = 0; k <= SAMPLES; k++)
        if (lw_posture_solve(plan, c->dim, modes, from + (to - from)*k/SAMPLES, 0, &posture) == LW_OK)
            r->curve_max = fmax(r->curve_max, lw_target_distance(t, posture.tracer[0][0]));
}

/* The arc that holds station 0; -1: none. */
static int arc_of(const lw_plan *plan, const lw_motion *m, const lw_candidate *c)
{
    double modes[LW_MODE_MAX];
    modes_at(c, plan, 0, modes);
    int at = lw_motion_arc(plan, m, modes, c->input[0]);
    for (int d = 0; d < plan->n_dyad; d++)             /* dyads of two slides have one mode       */
        modes[d] = 1;
    return at >= 0 ? at : lw_motion_arc(plan, m, modes, c->input[0]);
}

/* The range of the arc, in the turn of station 0, and the reversals in it. */
static void describe_arc(const lw_plan *plan, const lw_candidate *c, const lw_arc *a, lw_fit_report *r)
{
    lw_output_limits turn[LW_REVERSAL_MAX];
    double middle = 0.5*(a->first + a->last), turns = 0;
    if (!plan->input_is_slider && !a->turns)
        turns = 2*LW_PI*round((c->input[0] - middle)/(2*LW_PI));
    double first = a->turns ? c->input[0] : a->first + turns, last = a->turns ? first + 2*LW_PI : a->last + turns;
    r->input_first = plan->input_turns_per_period*first;
    r->input_last = plan->input_turns_per_period*last;
    for (int end = 0; end < 2; end++)
        if (a->limit[end])
            lw_fit_report_reversal(r, true, plan->input_joint, plan->input_turns_per_period*(end ? last : first));
    int n = lw_output_limits_find(plan, &r->linkage, c->dim, a->mode, first, last, turn, LW_REVERSAL_MAX);
    for (int i = 0; i < n; i++)
        lw_fit_report_reversal(r, false, turn[i].joint, plan->input_turns_per_period*turn[i].input);
}

void lw_fit_report_range(const lw_target *t, const lw_candidate *c, double *from, double *to)
{
    *from = *to = c->input[0];
    for (size_t i = 1; i < t->n; i++) {
        *from = fmin(*from, c->input[i]);
        *to = fmax(*to, c->input[i]);
    }
}

/* Measure the motion from station to station, of closed targets back to the first.  Where the assembly mode changes,
 * the motion passes a limit: the transmission angle is 0 there, and the acceleration infinite. */
static void measure_between_stations(const lw_target *t, const lw_plan *plan, const lw_fit_spec *s,
                                     const lw_candidate *c, int coarse, lw_motion_limits *limits)
{
    size_t spans = t->closed ? t->n : t->n - 1;
    int samples = spans < SAMPLES/8/(size_t)coarse ? SAMPLES/coarse/(int)spans : 8;
    for (size_t i = 0; i < spans; i++) {
        double here[LW_MODE_MAX], next[LW_MODE_MAX];
        size_t k = (i + 1) % t->n;
        modes_at(c, plan, i, here);
        modes_at(c, plan, k, next);
        bool on = memcmp(here, next, sizeof *here*(size_t)plan->n_dyad) == 0;
        lw_motion_limits_run(plan, s, c->dim, here, c->input[i], on ? c->input[k] : c->input[i], samples, limits);
        if (!on) {
            limits->margin_least = fmin(limits->margin_least, 0);
            limits->acceleration = INFINITY;
        }
    }
}

/* A transmission angle in [0, pi] as one in [0, pi/2]. */
static double folded(double angle) { return fmin(angle, LW_PI - angle); }

/* Describe the circuit of station 0.  The input of an open target turns if the linkage was made for it, or can turn within the
 * limits.  Else it goes to and fro between the ends of the target. */
static void describe_circuit(const lw_target *t, const lw_plan *plan, const lw_fit_spec *s, const lw_candidate *c,
                             const lw_motion *m, int coarse, lw_motion_limits *limits, lw_fit_report *r)
{
    int at = arc_of(plan, m, c);
    r->circuits = m->n_circuit;
    if (at < 0)
        return;
    const lw_arc *a = &m->arc[at];
    double first = folded(a->transmission_min), last = folded(a->transmission_max);     /* to rounding */
    r->turns = a->turns && (t->closed || c->intended.turns || fmin(first, last) >= s->min_transmission);
    if (coarse == 1)
        describe_arc(plan, c, a, r);
    if (r->turns)
        lw_motion_limits_run(plan, s, c->dim, a->mode, a->first, a->last, SAMPLES/coarse, limits);
    else
        measure_between_stations(t, plan, s, c, coarse, limits);
    if (!r->turns)
        return;
    r->transmission_min = fmin(first, last);
    r->transmission_max = a->transmission_min < LW_PI/2 && a->transmission_max > LW_PI/2 ? LW_PI/2 : fmax(first, last);
}

static double angle_of(double margin) { return asin(sqrt(fmin(fmax(margin, 0), 1))); }

static void describe_motion(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c,
                            const lw_plan *plan, const lw_closed_motion *cycle, int coarse, lw_motion_limits *limits,
                            lw_fit_report *r)
{
    lw_motion m;
    double from, to;
    lw_fit_report_range(t, c, &from, &to);
    if (plan->n_higher)
        lw_fit_report_curve(plan, s, c, from, to, limits, r);
    else {
        lw_status st = lw_motion_find(plan, c->dim, &m);
        if (st == LW_OK)
            describe_circuit(t, plan, s, c, &m, coarse, limits, r);
        r->no_memory |= st == LW_E_MEMORY;
    }
    r->acceleration_max = limits->acceleration;
    if (isnan(r->transmission_min) && !isnan(limits->margin_least)) {
        r->transmission_min = angle_of(limits->margin_least);
        r->transmission_max = angle_of(limits->margin_most);
    }
    if (!lw_task_has_place(s->task)) {
        r->curve_max = NAN;
        return;
    }
    if (coarse > 1)
        return;
    for (int j = 0; j < cycle->n; j++)
        measure_distance(t, plan, c, cycle->leg[j].mode, lw_closed_motion_first(cycle, j), cycle->leg[j].last, r);
    if (t->closed && r->turns)
        to = from + 2*LW_PI;
    bool used[2] = { false, false };
    for (size_t i = 0; i < t->n && cycle->n == 0; i++) {
        double modes[LW_MODE_MAX];
        modes_at(c, plan, i, modes);
        if (!used[modes[0] > 0])
            measure_distance(t, plan, c, modes, from, to, r);
        used[modes[0] > 0] = true;
    }
}

/* The angle in [0, 2 pi) that is a whole number of turns away. */
static double turn_up(double angle)
{
    double a = remainder(angle, 2*LW_PI);
    return a < 0 ? a + 2*LW_PI : a;
}

/* The input's travel over the stations when these have no order: of the two ways from the first station to the last,
 * the one that passes more of the other stations; a whole turn for closed targets. */
static double covered_travel(const lw_target *t, const lw_candidate *c, bool turns)
{
    double travel = c->input[t->n - 1] - c->input[0];
    size_t inside = 0;
    if (!turns)
        return travel;
    if (t->closed)
        return 2*LW_PI;
    travel = turn_up(travel);
    for (size_t i = 1; i + 1 < t->n; i++)
        inside += turn_up(c->input[i] - c->input[0]) <= travel;
    return 2*inside + 2 >= t->n ? travel : travel - 2*LW_PI;
}

/* The input's travel from station a to the next. */
static double travel_to_next(const lw_target *t, const lw_candidate *c, bool turns, size_t a)
{
    size_t b = (a + 1) % t->n;
    double travel = c->input[b] - c->input[a];
    return b == 0 && turns ? c->intended.sense*turn_up(c->intended.sense*travel) : travel;
}

/* Points of the curve from station a on, `steps` at equal inputs.  Returns how many closed. */
static size_t sample_curve(const lw_candidate *c, const lw_plan *plan, size_t a, double travel, int steps, lw_vec2 *curve, lw_fit_report *r)
{
    double modes[LW_MODE_MAX];
    size_t n = 0;
    modes_at(c, plan, a, modes);
    for (int k = 0; k < steps; k++) {
        lw_posture posture;
        lw_status st = lw_posture_solve(plan, c->dim, modes, c->input[a] + travel*k/steps, 0, &posture);
        if (st == LW_OK)
            curve[n++] = posture.tracer[0][0];
        r->no_memory |= st == LW_E_MEMORY;
    }
    return n;
}

/* Compare the target with the curve in the order in which the tracer moves: from station to station if these have an
 * order. */
static void compare_curves(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_plan *plan,
                           const lw_closed_motion *cycle, int coarse, lw_fit_report *r)
{
    enum { STEPS = 12, WHOLE = 1600 };
    const int whole_steps = WHOLE/coarse;
    size_t spans = t->closed ? t->n : t->n - 1, n = 0;
    lw_vec2 *curve = malloc(sizeof *curve*(spans*STEPS + WHOLE + 1));
    if (!curve) {
        r->no_memory = true;
        return;
    }
    bool circuit = cycle->n > 0, piece = circuit || (s->timing == LW_TIMING_NONE && !c->mode_of);
    if (circuit)
        n = lw_fit_report_cycle_points(plan, c, cycle, whole_steps, curve);
    else if (piece)
        n = sample_curve(c, plan, 0, covered_travel(t, c, r->turns), whole_steps, curve, r);
    double whole = 0;
    for (size_t i = 0; i < spans; i++)
        whole += fabs(travel_to_next(t, c, r->turns, i));
    for (size_t i = 0; i < spans && !piece; i++) {
        double here[LW_MODE_MAX], next[LW_MODE_MAX], travel = travel_to_next(t, c, r->turns, i);
        int steps = STEPS + (int)(whole_steps*fmin(fabs(travel)/(whole + 1e-300), 1));     /* within a wide span the point may turn back */
        modes_at(c, plan, i, here);
        modes_at(c, plan, (i + 1) % t->n, next);
        n += sample_curve(c, plan, i, travel, here[0] != next[0] ? 1 : steps, curve + n, r);
    }
    if (!t->closed && !piece)
        n += sample_curve(c, plan, t->n - 1, 0, 1, curve + n, r);
    if (n >= 2) {
        if (coarse == 1)
            r->no_memory |= lw_likeness_measure(t, curve, n, &r->likeness) != LW_OK;
        r->stray = lw_likeness_stray(t, curve, n);
        r->no_memory |= isnan(r->stray.to_target);
    }
    free(curve);
}

static void classify(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_fit_report *r)
{
    if (!c->family->type || strcmp(c->family->type, "RRRR") != 0)
        return;
    double mode = c->mode_of ? c->mode_of[0] : c->intended.mode[0];
    r->has_class = lw_fourbar_classify(c->dim, 1e-12, &r->barker, NULL) == LW_OK;
    if (lw_task_has_place(s->task) && t->n_also == 0    /* cognates move one coupler point */
        && lw_fourbar_cognates(c->dim, mode, r->cognate, r->cognate_mode) == LW_OK)
        r->n_cognate = 2;
}

/* ---- the report ------------------------------------------------------------------------------- */

/* The input of a linkage that rocks along an open target gets limits at the ends of the target: beyond them transmission angles may be small,
 * and nobody needs the motion. */
static void limit_input(const lw_target *t, const lw_candidate *c, lw_fit_report *r)
{
    lw_input *in = &r->linkage.input[0];
    double from, to;
    in->first = in->last = 0;                             /* of the linkage that the search began with            */
    if (t->closed || r->turns || r->passes_limit || r->linkage.n_input != 1)
        return;
    lw_fit_report_range(t, c, &from, &to);
    in->first = in->value + r->input_turns_per_period*(from - c->input[0]);
    in->last = in->value + r->input_turns_per_period*(to - c->input[0]);
}

/* The report on a candidate whose plan is made; `coarse` 1: the whole, else a sketch from 1/coarse of the postures. */
static lw_status report_with(const lw_plan *plan, const lw_target *t, const lw_fit_spec *s, const lw_candidate *c,
                             int coarse, lw_fit_report *r, lw_error *e)
{
    lw_motion_limits limits = lw_motion_limits_begin();
    lw_closed_motion cycle;
    double modes[LW_MODE_MAX];
    for (int i = 0; i < plan->n_dim; i++) {
        memcpy(r->dim_name[i], plan->dim[i].name, sizeof r->dim_name[i]);
        r->dim_kind[i] = plan->dim[i].kind;
    }
    modes_at(c, plan, 0, modes);
    lw_vec2 *at = malloc(sizeof *at*(t->n*(size_t)(1 + t->n_also) + (size_t)c->n_sample));
    if (!at)
        return lw_error_set(e, LW_E_MEMORY, "no memory for a report on %zu stations", t->n);
    r->input_turns_per_period = plan->input_turns_per_period;
    r->counts_as = r->as_made = r->spread = r->transmission_min = r->transmission_max = r->input_first = r->input_last = NAN;
    r->likeness = (lw_likeness){ NAN, NAN, NAN, NAN };
    r->stray = (lw_stray){ NAN, NAN, NAN };
    lw_posture posture;
    lw_status st = lw_plan_write(plan, c->dim, modes, c->input[0], &r->linkage);
    if (st == LW_OK)
        st = station_errors(t, s, c, plan, at, r);
    if (st == LW_OK)
        st = lw_posture_solve(plan, c->dim, modes, c->input[0], 0, &posture);
    r->no_memory |= st == LW_E_MEMORY;
    if (st != LW_OK)
        snprintf(r->fault, sizeof r->fault, "the linkage does not close at every station");
    else {
        turn_tools(c, t, &posture, &r->linkage);
        r->linkage.units = t->units;
        r->no_memory |= !lw_fit_report_cycle(plan, c, modes, &cycle);
        r->legs = cycle.n;
        if (!t->closed)                                  /* an open target is met by a part of the motion only */
            cycle.n = 0;
        describe_motion(t, s, c, plan, &cycle, coarse, &limits, r);
        if (lw_task_has_place(s->task))
            compare_curves(t, s, c, plan, &cycle, coarse, r);
        classify(t, s, c, r);
        lw_fit_report_limits(t, s, c, &limits, r);
        limit_input(t, c, r);
        if (coarse == 1)
            r->no_memory |= lw_verify(t, s, c, plan, at, r) != LW_OK;
        r->meets = lw_motion_limits_meets(&limits, s, &r->linkage, t->x ? t->size : 1, r->fault, sizeof r->fault);
        r->verified &= r->meets;
        r->no_memory |= limits.no_memory;
    }
    free(at);
    return r->no_memory ? lw_error_set(e, LW_E_MEMORY, "out of memory for a report") : LW_OK;
}

static lw_status make(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, int coarse, lw_fit_report *r, lw_error *e)
{
    lw_plan *plan = malloc(sizeof *plan);
    memset(r, 0, sizeof *r);
    lw_status st = plan ? full_plan(t, s, c, &r->linkage, plan, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK)
        st = report_with(plan, t, s, c, coarse, r, e);
    free(plan);
    return st;
}

lw_status lw_fit_report_make(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_fit_report *r, lw_error *e)
{
    return make(t, s, c, 1, r, e);
}

lw_status lw_fit_report_sketch(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_fit_report *r)
{
    enum { COARSE = 20 };
    return make(t, s, c, COARSE, r, NULL);
}

lw_status lw_fit_report_linkage(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, lw_linkage *k, lw_error *e)
{
    lw_posture posture;
    double modes[LW_MODE_MAX];
    lw_plan *plan = malloc(sizeof *plan);
    lw_status st = plan ? full_plan(t, s, c, k, plan, e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK) {
        modes_at(c, plan, 0, modes);
        st = lw_plan_write(plan, c->dim, modes, c->input[0], k);
        if (st != LW_OK)
            lw_error_set(e, st, "%s", lw_status_text(st));
    }
    if (st == LW_OK) {
        lw_posture_solve(plan, c->dim, modes, c->input[0], 0, &posture);
        turn_tools(c, t, &posture, k);
        k->units = t->units;
    }
    free(plan);
    return st;
}
