/* optimise/report/verify.c - the second simulation: every result is moved from its file by code that shares nothing
 * with the plan. */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mbs/constraints/motion_curve.h"
#include "mbs/constraints/newton.h"
#include "mbs/batch/posture.h"
#include "optimise/report/report_internal.h"

typedef struct replay {
    const lw_target    *t;
    const lw_fit_spec  *s;
    const lw_candidate *c;
    const lw_plan      *plan;
    lw_fit_report          *r;
    lw_linkage          k, now;     /* as read back from its text; its posture at a station */
    double              shift;      /* input of the file minus input in the ground frame */
    lw_newton          *newton;     /* moved from station to station, or ...             */
    lw_system           system;
    lw_motion_curve          *curve;      /* ... all of its motion, through limits             */
    double              q[LW_SYSTEM_Q_MAX];
    double              place, before;     /* of this station and the one before on the curve [segments] */
    double              gone[2];    /* how far the stations went along it, forwards and backwards; INFINITY: not that way */
    int                 n_placed;
} replay;

/* Do the stations change the assembly mode, or the sense of the input?  Else a motion without limits joins them. */
static bool turns_back(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c)
{
    size_t dyads = (size_t)c->n_dyad, n = t->n + (size_t)c->n_sample;
    int up = 0, down = 0;
    for (size_t i = dyads; c->mode_of && i < n*dyads; i++)
        if (c->mode_of[i] != c->mode_of[i - dyads])
            return true;
    for (size_t i = 1; i < t->n && s->timing == LW_TIMING_FREE; i++) {
        up += c->input[i] > c->input[i - 1];
        down += c->input[i] < c->input[i - 1];
    }
    return up > 0 && down > 0;
}

/* Write the first posture as the text of a file and read it back. */
static bool open_file(replay *v, lw_status *status)
{
    lw_error why = { .text = "" };
    char *text = lw_linkage_write(&v->r->linkage, 0);
    bool ok = text && lw_linkage_read(text, strlen(text), "result", &v->k, &why) == LW_OK;
    if (ok && v->c->mode_of && turns_back(v->t, v->s, v->c))
        ok = lw_system_make(&v->k, NULL, 0, &v->system, &why) == LW_OK
          && lw_motion_curve_create(&v->system, NULL, &(lw_motion_curve_options){ .input = 0 }, &v->curve, &why)
             == LW_OK;
    else if (ok)
        ok = lw_newton_create(&v->k, &v->newton, &why) == LW_OK;
    v->now = v->k;
    free(text);
    v->shift = v->k.input[0].value - v->plan->input_turns_per_period*v->c->input[0];
    *status = !text || why.status == LW_E_MEMORY ? LW_E_MEMORY : LW_OK;
    if (!ok)
        snprintf(v->r->fault, sizeof v->r->fault, "its file does not read back: %.200s", why.text);
    return ok;
}

/* Length that distances are compared with; a function has no path. */
static double size_of(const replay *v) { return !lw_task_has_place(v->s->task) ? 1 : v->t->length; }

/* ---- from station to station without limits -------------------------------------------------------- */

#define TOLERANCE 1e-9             /* of inputs, angles and positions; relative for lengths                 */

static bool move_to(replay *v, size_t i, double to)
{
    double reached, near = v->plan->input_is_slider ? TOLERANCE*v->t->length : TOLERANCE;
    lw_status st = lw_newton_move(v->newton, to, &reached);
    if (st != LW_OK && !(fabs(reached - to) <= near)) {
        snprintf(v->r->fault, sizeof v->r->fault,
                 "station %zu cannot be reached from the one before: the motion ends at input %.9g of %.9g",
                 i + 1, reached, to);
        return false;
    }
    for (int k = 0; k <= v->t->n_also; k++) {
        lw_tracer *p = &v->now.tracer[k];
        p->at = lw_newton_tracer(v->newton, k);
        p->angle = v->k.tracer[k].angle + lw_newton_angle(v->newton, p->link);
    }
    return true;
}

/* ---- on the curve of all postures, across limits ---------------------------------------------------- */

/* Move to a place of the curve.  Returns the greatest distance of its points from the stated ones. */
static double distance_at(replay *v, double place, const lw_vec2 *at, size_t i)
{
    double most = 0;
    lw_motion_curve_posture(v->curve, place, v->q, NULL);
    v->now = v->k;
    lw_system_write(&v->system, v->q, &v->now);
    for (int k = 0; k <= v->t->n_also; k++)
        most = fmax(most, lw_v2_norm(lw_v2_sub(v->now.tracer[k].at, at[(size_t)k*v->t->n + i])));
    return most;
}

/* Near a limit the input does not determine the posture well: find the place nearby at which the first point is
 * nearest. */
static double nearest_place(replay *v, double place, const lw_vec2 *at, size_t i)
{
    double end = lw_motion_curve_segments(v->curve), h = 1e-4;
    for (int step = 0; step < 4; step++) {
        double lo = fmax(0, place - h), hi = fmin(end, place + h);
        distance_at(v, lo, at, i);
        lw_vec2 first = v->now.tracer[0].at;
        distance_at(v, hi, at, i);
        lw_vec2 by = lw_v2_scale(lw_v2_sub(v->now.tracer[0].at, first), 1/(hi - lo));
        distance_at(v, place, at, i);
        double move = lw_v2_dot(lw_v2_sub(at[i], v->now.tracer[0].at), by)/(lw_v2_dot(by, by) + 1e-300);
        place = fmin(fmax(place + fmin(fmax(move, -0.1), 0.1), 0), end);
        h = fmax(1e-7, fmin(h, 10*fabs(move)));
    }
    return place;
}

/* Between two limits the input is monotonic: find the places where it equals `input` up to whole turns, or the end
 * nearest to it.  A place whose points are nearer than *least becomes *best. */
static void search_piece(replay *v, double first, double last, double input, const lw_vec2 *at, size_t i, double *least, double *best)
{
    double ends[2], place[2] = { first, last }, near = v->plan->input_is_slider ? TOLERANCE*v->t->length : TOLERANCE;
    for (int e = 0; e < 2; e++) {
        lw_motion_curve_posture(v->curve, place[e], v->q, NULL);
        ends[e] = lw_motion_curve_input(v->curve, v->q);
    }
    double lo = fmin(ends[0], ends[1]), hi = fmax(ends[0], ends[1]), turn = 2*LW_PI*v->plan->input_turns_per_period;
    bool slider = v->plan->input_is_slider;
    int turns = slider ? 0 : (int)((hi - lo)/turn) + 1;
    double from = slider ? input : input + turn*ceil((lo - near - input)/turn);
    for (int k = 0; k <= turns; k++) {
        double sought = from + turn*k, here;
        if (sought < lo - near || sought > hi + near || !(first < last))
            continue;
        if (sought <= lo || sought >= hi)
            here = place[(sought <= lo) == (ends[0] < ends[1]) ? 0 : 1];
        else
            here = lw_motion_curve_find(v->curve, first, last, sought);
        double away = distance_at(v, here, at, i);
        if (away < *least) {
            *least = away;
            *best = here;
        }
    }
}

#define JITTER 0.01                /* segments; places of one posture are found to this, where the input hardly moves */

/* Do stations that have an order come in it so far: one way along the curve, of a closed one once around at most? */
static bool in_order(replay *v, size_t i)
{
    bool closed = lw_motion_curve_ended(v->curve) == LW_MOTION_CURVE_CLOSED;
    double end = lw_motion_curve_segments(v->curve), step = v->place - v->before;
    if (v->s->timing != LW_TIMING_FREE || i >= v->t->n)
        return true;
    for (int way = 0; way < 2 && v->n_placed > 0; way++, step = -step) {
        double by = closed && step < -JITTER ? step + end : step;
        by = closed && by > end - JITTER ? by - end : by;
        v->gone[way] = by < -JITTER ? INFINITY : v->gone[way] + by;
    }
    v->n_placed++;
    v->before = v->place;
    if (fmin(v->gone[0], v->gone[1]) <= (closed ? end : INFINITY) + JITTER*(double)v->n_placed && isfinite(fmin(v->gone[0], v->gone[1])))
        return true;
    snprintf(v->r->fault, sizeof v->r->fault, "the motion comes to station %zu out of order", i + 1);
    return false;
}

static bool look_up(replay *v, size_t i, double input, const lw_vec2 *at)
{
    int n;
    const lw_motion_curve_event *e = lw_motion_curve_events(v->curve, &n);
    double end = lw_motion_curve_segments(v->curve), from = 0, best = 0, least = INFINITY;
    for (int k = 0; k <= n; k++) {
        if (k < n && e[k].kind != LW_EVENT_LIMIT)
            continue;
        double to = k < n ? e[k].station : end;
        search_piece(v, from, to, input, at, i, &least, &best);
        from = to;
    }
    if (least <= 1e-3*size_of(v)) {
        v->place = nearest_place(v, best, at, i);
        distance_at(v, v->place, at, i);
        return in_order(v, i);
    }
    bool whole = lw_motion_curve_ended(v->curve) != LW_MOTION_CURVE_STOPPED;
    snprintf(v->r->fault, sizeof v->r->fault, whole
             ? "station %zu lies on another branch than the one before: no limit of motion joins them"
             : "the second simulation ends before station %zu: links of so different lengths take too many steps", i + 1);
    return false;
}

/* ---- errors ------------------------------------------------------------------------------------------ */

static bool go_to(replay *v, size_t i, const lw_vec2 *at)
{
    double to = v->plan->input_turns_per_period*v->c->input[i] + v->shift;
    return v->curve ? look_up(v, i, to, at) : move_to(v, i, to);
}

/* Error of the angle of a tool. */
static double turn_error(const replay *v, int point, double angle)
{
    return remainder(v->now.tracer[point].angle - angle, 2*LW_PI);
}

/* Eq. 17 at a station. */
static double square_error(const replay *v, size_t i)
{
    const lw_target *t = v->t;
    lw_vec2 p = v->now.tracer[0].at;
    double f = 0, a = v->s->a, b = v->s->b;
    if (lw_task_has_place(v->s->task)) {
        double distance = hypot(p.x - t->x[i], p.y - t->y[i]);
        f += a*t->weight[i]*distance*distance;
    }
    if (lw_task_has_angle(v->s->task))
        f += b*t->weight[i]*pow(turn_error(v, 0, t->theta[i]), 2);
    for (int k = 0; k < t->n_also; k++) {
        const lw_also *also = &t->also[k];
        p = v->now.tracer[k + 1].at;
        if (also->x)
            f += a*also->weight[i]*(pow(p.x - also->x[i], 2) + pow(p.y - also->y[i], 2));
        if (also->theta)
            f += b*also->weight[i]*pow(turn_error(v, k + 1, also->theta[i]), 2);
    }
    return f;
}

/* Differences up to this are rounding of the coordinates. */
static double allowed(const replay *v)
{
    double reach = 0;
    for (int j = 0; j < v->k.n_joint; j++)
        reach = fmax(reach, fmax(fabs(v->k.joint[j].at.x), fabs(v->k.joint[j].at.y)));
    for (size_t i = 0; v->t->x && i < v->t->n; i++)
        reach = fmax(reach, fmax(fabs(v->t->x[i]), fabs(v->t->y[i])));
    for (int k = 0; k < v->t->n_also; k++)
        for (size_t i = 0; v->t->also[k].x && i < v->t->n; i++)
            reach = fmax(reach, fmax(fabs(v->t->also[k].x[i]), fabs(v->t->also[k].y[i])));
    return TOLERANCE*size_of(v) + 256*DBL_EPSILON*reach;
}

/* Does the objective that the search stated agree, if each station differs by `off` at most? */
static bool claim_holds(const replay *v, double f, double off)
{
    double weight = 0, also = 0, claim = v->c->objective;
    for (size_t i = 0; i < v->t->n; i++) {
        weight += v->t->weight[i];
        for (int k = 0; k < v->t->n_also; k++)
            also += v->t->also[k].weight[i];
    }
    double a = !lw_task_has_place(v->s->task) ? 0 : v->s->a, b = !lw_task_has_angle(v->s->task) ? 0 : v->s->b;
    double slack = off*sqrt(a*(weight + also)) + TOLERANCE*sqrt(b*weight + v->s->b*also) + TOLERANCE*sqrt(f);
    return fabs(sqrt(f) - sqrt(claim)) <= slack;
}

/* Without timing the stations are half of the objective, the distances of the curve's samples from the target the
 * other half. */
static bool add_samples(replay *v, const lw_vec2 *at)
{
    v->r->verified_objective *= 0.5;
    for (size_t i = v->t->n; i < v->t->n + (size_t)v->c->n_sample; i++) {
        if (!go_to(v, i, at))
            return false;
        double away = lw_target_distance(v->t, v->now.tracer[0].at);
        v->r->verified_objective += v->s->a*v->c->sample_weight*away*away;
    }
    return true;
}

static void judge(const replay *v, bool followed)
{
    lw_fit_report *r = v->r;
    bool same = r->difference <= allowed(v), claimed = claim_holds(v, r->verified_objective, allowed(v));
    r->verified = followed && same && claimed;
    if (followed && !same)
        snprintf(r->fault, sizeof r->fault, "an independent simulation is %.3g away from the stated positions", r->difference);
    else if (followed && !claimed)
        snprintf(r->fault, sizeof r->fault, "an independent simulation comes to the objective %.9g, the search to %.9g",
                 r->verified_objective, v->c->objective);
}

lw_status lw_verify(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_plan *plan,
               const lw_vec2 *at, lw_fit_report *r)
{
    replay *v = malloc(sizeof *v);
    lw_status status;
    if (!v)
        return LW_E_MEMORY;
    *v = (replay){ .t = t, .s = s, .c = c, .plan = plan, .r = r };
    bool followed = open_file(v, &status);
    for (size_t i = 0; i < t->n && followed; i++) {
        followed = go_to(v, i, at);
        if (!followed)
            break;
        for (int k = 0; k <= t->n_also; k++) {
            lw_vec2 p = v->now.tracer[k].at, here = at[(size_t)k*t->n + i];
            double away = hypot(p.x - here.x, p.y - here.y);
            if (!isnan(r->difference) && !(away <= r->difference))
                r->difference = away;
        }
        r->verified_objective += square_error(v, i);
    }
    if (t->n_also == 0 && s->timing == LW_TIMING_NONE && lw_task_has_place(s->task))
        followed = followed && add_samples(v, at);
    lw_newton_free(v->newton);
    lw_motion_curve_free(v->curve);
    lw_system_free(&v->system);
    judge(v, followed);
    free(v);
    return status;
}
