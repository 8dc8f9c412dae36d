/* catalogues/draw/walk.c - see walk.h */
#include "catalogues/draw/walk.h"

#include <string.h>

double lw_plan_posture_distance(const lw_plan *plan, const lw_posture *a, const lw_posture *b)
{
    double d = 0;
    for (int i = 0; i < LW_JOINT_MAX; i++)
        if (plan->joint_point[i] >= 0)
            d = fmax(d, lw_v2_norm(lw_v2_sub(a->joint[i][0], b->joint[i][0])));
    for (int i = 0; i < plan->n_output; i++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(a->tracer[i][0], b->tracer[i][0])));
    return d;
}

static int modes_apart(const lw_plan *plan, const double *a, const double *b)
{
    int n = 0;
    for (int i = 0; i < plan->n_dyad; i++)
        n += a[i]*b[i] < 0;
    return n;
}

/* Which end of the arc (0 first, 1 last) is a limit at this input; -1: neither. Inputs of a pin count modulo a turn. */
static int limit_at(const lw_plan *plan, const lw_arc *a, double input, double slack)
{
    for (int end = 0; end < 2; end++) {
        double off = (end ? a->last : a->first) - input;
        if (!plan->input_is_slider)
            off = remainder(off, 2*LW_PI);
        if (a->limit[end] && fabs(off) <= slack)
            return end;
    }
    return -1;
}

/* The arc on which the linkage continues at the end of stage s: of the arcs that end there with one dyad in the other
 * assembly mode, the one with the same posture. -1: none. */
static int arc_beyond(const lw_walk *w, const lw_motion *m, const lw_walk_stage *s, int *end)
{
    const lw_arc *now = &m->arc[s->arc];
    double slack = 1e-9*(w->plan->input_is_slider ? now->last - now->first : 1), least = INFINITY;
    lw_posture here, there;
    int best = -1;
    lw_posture_solve(w->plan, w->dim, s->mode, s->to, 0, &here);
    for (int i = 0; i < m->n_arc; i++) {
        const lw_arc *a = &m->arc[i];
        int at = i != s->arc && a->circuit == now->circuit && modes_apart(w->plan, a->mode, s->mode) == 1
               ? limit_at(w->plan, a, s->to, slack) : -1;
        if (at < 0)
            continue;
        lw_posture_solve(w->plan, w->dim, a->mode, at ? a->last : a->first, 0, &there);
        double d = lw_plan_posture_distance(w->plan, &here, &there);
        if (d < least) {
            least = d;
            best = i;
            *end = at;
        }
    }
    return best;
}

static void add_stage(lw_walk *w, const lw_motion *m, int arc, int begin)
{
    const lw_arc *a = &m->arc[arc];
    lw_walk_stage *s = &w->stage[w->n_stage++];
    *s = (lw_walk_stage){ .arc = arc, .from = begin ? a->last : a->first, .to = begin ? a->first : a->last };
    memcpy(s->mode, a->mode, sizeof s->mode);
}

void lw_walk_make(const lw_plan *plan, const double *dim, const lw_motion *m, int arc, double input, lw_walk *w)
{
    const lw_arc *a = &m->arc[arc];
    *w = (lw_walk){ .plan = plan, .dim = dim, .loops = a->turns, .turns = a->turns };
    add_stage(w, m, arc, a->limit[0] && !a->limit[1]);
    if (a->turns) {
        w->stage[0].from = input;
        w->stage[0].to = input + 2*LW_PI;
        return;
    }
    while (w->n_stage < LW_ARC_MAX) {
        const lw_walk_stage *s = &w->stage[w->n_stage - 1];
        const lw_arc *last = &m->arc[s->arc];
        int end = 0, next = last->limit[s->to == last->last] ? arc_beyond(w, m, s, &end) : -1;
        w->loops = next == arc;
        for (int i = 0; i < w->n_stage; i++)
            if (w->stage[i].arc == next)
                next = -1;
        if (next < 0)
            return;
        add_stage(w, m, next, end);
    }
}

void lw_walk_restrict(lw_walk *w, double first, double last)
{
    lw_walk_stage *s = &w->stage[0];
    if (!w->turns) {                              /* in a full turn any input is possible */
        first = fmax(first, fmin(s->from, s->to));
        last = fmin(last, fmax(s->from, s->to));
    }
    s->from = first;
    s->to = last;
    w->n_stage = 1;
    w->loops = w->turns = false;
}

static double input_at(const lw_walk *w, double t)
{
    int i = (int)fmin(fmax(floor(t), 0), w->n_stage - 1);
    const lw_walk_stage *s = &w->stage[i];
    double u = fmin(fmax(t - i, 0), 1);
    if (!w->turns)
        u = 0.5 - 0.5*cos(LW_PI*u);
    return s->from + u*(s->to - s->from);
}

double lw_walk_time(const lw_walk *w, double input)
{
    const lw_walk_stage *s = &w->stage[0];
    double u = fmin(fmax((input - s->from)/(s->to - s->from), 0), 1);
    return w->turns ? u : acos(1 - 2*u)/LW_PI;
}

void lw_walk_posture(const lw_walk *w, double t, lw_posture *posture)
{
    int i = (int)fmin(fmax(floor(t), 0), w->n_stage - 1);
    lw_posture_solve(w->plan, w->dim, w->stage[i].mode, input_at(w, t), 0, posture);
}
