/* optimise/verify.c - every result is simulated again from its file by code that shares nothing with
 * the plan. */
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    double modes[LW_DYAD_MAX];
    lw_linkage k = v->r->linkage;
    lw_error why = { .text = "" };
    v->mode = v->c->mode_of ? v->c->mode_of[station] : v->c->mode;
    for (int d = 0; d < v->plan->n_dyad; d++)
        modes[d] = v->mode;
    lw_pose pose;
    if (station > 0) {
        if (lw_plan_write(v->plan, v->c->dim, modes, v->c->input[station], &k) != LW_OK)
            return false;
        lw_pose_solve(v->plan, v->c->dim, modes, v->c->input[station], 0, &pose);
        k.tracer[0].angle = pose.angle[k.tracer[0].link][0] + v->c->tool0;
    }
    char *text = lw_linkage_write(&k, 0);
    lw_newton_free(v->newton);
    v->newton = NULL;
    bool ok = text && lw_linkage_read(text, strlen(text), "result", &v->k, &why) == LW_OK
           && lw_newton_create(&v->k, &v->newton, &why) == LW_OK;
    free(text);
    v->shift = v->k.input[0].value - v->c->input[station];
    if (!ok)
        snprintf(v->r->fault, sizeof v->r->fault, "its file does not read back: %.200s", why.text);
    return ok;
}

/* Move to a station; from another posture when the station is in another assembly. */
static bool go_to(replay *v, size_t i)
{
    double mode = v->c->mode_of ? v->c->mode_of[i] : v->c->mode, reached;
    if (i > 0 && mode != v->mode && !open_at(v, i))
        return false;
    lw_status st = lw_newton_move(v->newton, v->c->input[i] + v->shift, &reached);
    if (st != LW_OK && fabs(reached - v->c->input[i] - v->shift) > 1e-9)
        snprintf(v->r->fault, sizeof v->r->fault,
                 "station %zu cannot be reached from the first: the motion ends at input %.9g of %.9g",
                 i + 1, reached, v->c->input[i] + v->shift);
    return v->r->fault[0] == 0;
}

static double square_error(const replay *v, size_t i, lw_vec2 p, double *distance)
{
    const lw_target *t = v->t;
    double f = 0;
    if (v->s->task != LW_TASK_FUNCTION) {
        *distance = hypot(p.x - t->x[i], p.y - t->y[i]);
        f += v->s->a*t->weight[i]**distance**distance;
    }
    if (v->s->task != LW_TASK_PATH) {
        int link = v->k.tracer[0].link;
        double angle = v->k.tracer[0].angle + lw_newton_angle(v->newton, link);
        double d = remainder(angle - t->theta[i], 2*LW_PI);
        f += v->s->b*t->weight[i]*d*d;
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
    if (v->s->task == LW_TASK_FUNCTION)
        size = 1;
    return 1e-9*size + 256*DBL_EPSILON*reach;
}

void lw_verify(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_plan *plan,
               const lw_vec2 *at, lw_report *r)
{
    replay v = { .t = t, .s = s, .c = c, .plan = plan, .r = r };
    double f = 0, mean = 0;
    bool ok = open_at(&v, 0);
    for (size_t i = 0; ok && i < t->n; i++) {
        double distance = 0;
        ok = go_to(&v, i);
        if (!ok)
            break;
        lw_vec2 p = lw_newton_tracer(v.newton, 0);
        r->difference = fmax(r->difference, hypot(p.x - at[i].x, p.y - at[i].y));
        f += square_error(&v, i, p, &distance);
        mean += distance/(double)t->n;
    }
    lw_newton_free(v.newton);
    r->verified_objective = f;
    r->verified_mean = mean;
    r->verified = ok && r->difference <= allowed(&v);
    if (ok && !r->verified)
        snprintf(r->fault, sizeof r->fault,
                 "an independent simulation is %.3g away from the stated positions", r->difference);
}
