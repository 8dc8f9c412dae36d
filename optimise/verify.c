/* optimise/verify.c - every result is simulated again from its file by code that shares nothing with
 * the plan. */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mbs/motion.h"
#include "mbs/newton.h"
#include "mbs/pose.h"
#include "optimise/report_internal.h"

typedef struct replay {
    const lw_target    *t;
    const lw_fit_spec  *s;
    const lw_candidate *c;
    const lw_plan      *plan;
    lw_report          *r;
    lw_linkage          k;          /* as read back from its text                        */
    lw_newton          *newton;
    double              mode;       /* assembly of the posture it started from           */
    double              shift;      /* input of the file minus input in the ground frame */
} replay;

/* The posture at a station through text, as a file would carry it. */
static bool open_at(replay *v, size_t station)
{
    double modes[LW_MODE_MAX];
    lw_linkage k = v->r->linkage;
    lw_error why = { .text = "" };
    lw_candidate_modes(v->c, v->plan, station, modes);
    v->mode = modes[0];
    lw_pose pose;
    if (station > 0) {
        if (lw_plan_write(v->plan, v->c->dim, modes, v->c->input[station], &k) != LW_OK)
            return false;
        lw_pose_solve(v->plan, v->c->dim, modes, v->c->input[station], 0, &pose);
        lw_candidate_tools(v->c, v->t, &pose, &k);
    }
    char *text = lw_linkage_write(&k, 0);
    lw_newton_free(v->newton);
    v->newton = NULL;
    bool ok = text && lw_linkage_read(text, strlen(text), "result", &v->k, &why) == LW_OK
           && lw_newton_create(&v->k, &v->newton, &why) == LW_OK;
    free(text);
    v->shift = v->k.input[0].value - v->plan->laps*v->c->input[station];
    if (!ok)
        snprintf(v->r->fault, sizeof v->r->fault, "its file does not read back: %.200s", why.text);
    return ok;
}

/* How far an input may have to go for all of its way: a turn, or a little more than its range. */
static double whole_way(const replay *v)
{
    lw_range r;
    if (!v->plan->input_is_slider)
        return 2*LW_PI*v->plan->laps;
    if (lw_motion_range(v->plan, v->c->dim, v->mode, &r) != LW_OK)
        return 0;
    return 1.1*(r.last - r.first);
}

/* Do both come to one limit of motion, moved up (or down)?  Pins and tracer tell; where a slide line has its
 * point is another matter in every file. */
static bool meet(lw_newton *a, lw_newton *b, const replay *v, double by)
{
    double size = 0;
    if (lw_newton_move(a, lw_newton_input(a) + by, NULL) != LW_OPEN
        || lw_newton_move(b, lw_newton_input(b) + by, NULL) != LW_OPEN)
        return false;
    lw_vec2 here = lw_newton_tracer(a, 0);
    double gap = lw_v2_norm(lw_v2_sub(here, lw_newton_tracer(b, 0)));
    for (int j = 0; j < v->k.n_joint; j++) {
        lw_vec2 p = lw_newton_joint(a, j);
        size = fmax(size, lw_v2_norm(lw_v2_sub(p, here)));
        if (v->k.joint[j].kind != LW_JOINT_REVOLUTE)
            continue;
        gap = fmax(gap, lw_v2_norm(lw_v2_sub(p, lw_newton_joint(b, j))));
    }
    return gap <= 1e-5*size;                     /* half of the digits count at a limit      */
}

/* A station in the other assembly: simulated from its own posture, when that comes to the same limit of
 * motion as the posture before. */
static bool change_assembly(replay *v, size_t i)
{
    lw_newton *before = v->newton;
    v->newton = NULL;
    bool ok = open_at(v, i);
    if (ok && !meet(before, v->newton, v, whole_way(v)) && !meet(before, v->newton, v, -whole_way(v))) {
        snprintf(v->r->fault, sizeof v->r->fault,
                 "station %zu lies on another branch than the one before: no limit of motion joins them", i + 1);
        ok = false;
    }
    lw_newton_free(before);
    if (ok)
        lw_newton_reset(v->newton);
    return ok;
}

static bool go_to(replay *v, size_t i)
{
    double mode = v->c->mode_of ? v->c->mode_of[i] : v->mode, reached;
    if (i > 0 && mode != v->mode && !change_assembly(v, i))
        return false;
    double to = v->plan->laps*v->c->input[i] + v->shift, near = v->plan->input_is_slider ? 1e-9*v->t->length : 1e-9;
    lw_status st = lw_newton_move(v->newton, to, &reached);
    if (st != LW_OK && !(fabs(reached - to) <= near))
        snprintf(v->r->fault, sizeof v->r->fault,
                 "station %zu cannot be reached from the one before: the motion ends at input %.9g of %.9g",
                 i + 1, reached, to);
    return v->r->fault[0] == 0;
}

/* What the angle of a tool is off. */
static double turn_error(const replay *v, int point, double want)
{
    const lw_tracer *p = &v->k.tracer[point];
    return remainder(p->angle + lw_newton_angle(v->newton, p->link) - want, 2*LW_PI);
}

/* Eq. 17 at a station; distance is that of the first point. */
static double square_error(const replay *v, size_t i, double *distance)
{
    const lw_target *t = v->t;
    lw_vec2 p = lw_newton_tracer(v->newton, 0);
    double f = 0, a = v->s->a, b = v->s->b;
    if (v->s->task != LW_TASK_FUNCTION) {
        *distance = hypot(p.x - t->x[i], p.y - t->y[i]);
        f += a*t->weight[i]**distance**distance;
    }
    if (v->s->task != LW_TASK_PATH)
        f += b*t->weight[i]*pow(turn_error(v, 0, t->theta[i]), 2);
    for (int k = 0; k < t->n_also; k++) {
        const lw_also *also = &t->also[k];
        p = lw_newton_tracer(v->newton, k + 1);
        if (also->x)
            f += a*also->weight[i]*(pow(p.x - also->x[i], 2) + pow(p.y - also->y[i], 2));
        if (also->theta)
            f += b*also->weight[i]*pow(turn_error(v, k + 1, also->theta[i]), 2);
    }
    return f;
}

/* What the coordinates' own digits cannot hold is no disagreement. */
static double allowed(const replay *v)
{
    double size = v->t->length, reach = 0;
    for (int j = 0; j < v->k.n_joint; j++)
        reach = fmax(reach, fmax(fabs(v->k.joint[j].at.x), fabs(v->k.joint[j].at.y)));
    for (size_t i = 0; v->t->x && i < v->t->n; i++)
        reach = fmax(reach, fmax(fabs(v->t->x[i]), fabs(v->t->y[i])));
    for (int k = 0; k < v->t->n_also; k++)
        for (size_t i = 0; v->t->also[k].x && i < v->t->n; i++)
            reach = fmax(reach, fmax(fabs(v->t->also[k].x[i]), fabs(v->t->also[k].y[i])));
    if (v->s->task == LW_TASK_FUNCTION)
        size = 1;
    return 1e-9*size + 256*DBL_EPSILON*reach;
}

/* Does what the search said of the candidate agree, when each station is off by `off` at most?  With both
 * ways scored the stations are half of it, or less. */
static bool claim_holds(const replay *v, double f, double off)
{
    double weight = 0, also = 0, claim = v->c->objective;
    for (size_t i = 0; i < v->t->n; i++) {
        weight += v->t->weight[i];
        for (int k = 0; k < v->t->n_also; k++)
            also += v->t->also[k].weight[i];
    }
    double a = v->s->task == LW_TASK_FUNCTION ? 0 : v->s->a, b = v->s->task == LW_TASK_PATH ? 0 : v->s->b;
    double slack = off*sqrt(a*(weight + also)) + 1e-9*sqrt(b*weight + v->s->b*also) + 1e-9*sqrt(f);
    if (v->s->timing == LW_TIMING_NONE && v->s->task != LW_TASK_FUNCTION)
        return sqrt(0.5*f) <= sqrt(claim) + slack;
    return fabs(sqrt(f) - sqrt(claim)) <= slack;
}

static void judge(const replay *v, bool followed)
{
    lw_report *r = v->r;
    bool same = r->difference <= allowed(v), claimed = claim_holds(v, r->verified_objective, allowed(v));
    r->verified = followed && same && claimed;
    if (followed && !same)
        snprintf(r->fault, sizeof r->fault,
                 "an independent simulation is %.3g away from the stated positions", r->difference);
    else if (followed && !claimed)
        snprintf(r->fault, sizeof r->fault, "an independent simulation comes to the objective %.9g, the search to %.9g",
                 r->verified_objective, v->c->objective);
}

void lw_verify(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_plan *plan,
               const lw_vec2 *at, lw_report *r)
{
    replay v = { .t = t, .s = s, .c = c, .plan = plan, .r = r };
    bool followed = open_at(&v, 0);
    for (size_t i = 0; i < t->n && followed; i++) {
        double distance = 0;
        followed = go_to(&v, i);
        if (!followed)
            break;
        for (int k = 0; k <= t->n_also; k++) {
            lw_vec2 p = lw_newton_tracer(v.newton, k), here = at[(size_t)k*t->n + i];
            double away = hypot(p.x - here.x, p.y - here.y);
            if (!isnan(r->difference) && !(away <= r->difference))
                r->difference = away;
        }
        r->verified_objective += square_error(&v, i, &distance);
        r->verified_mean += distance/(double)t->n;
    }
    lw_newton_free(v.newton);
    judge(&v, followed);
}
