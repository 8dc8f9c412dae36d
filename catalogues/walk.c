/* catalogues/walk.c - see walk.h */
#include "catalogues/walk.h"

#include <string.h>

#define STEPS 720                   /* of a turn; gaps narrower than half a degree are not noticed */

static bool closes(const lw_walk *w, const double *mode, double input, lw_pose *pose)
{
    return lw_pose_solve(w->plan, w->dim, mode, input, 0, pose) == LW_OK;
}

/* The last input that closes, going from `from`, which does, by steps; false: none within n steps. */
static bool find_limit(const lw_walk *w, const double *mode, double from, double step, int n,
                       double *limit)
{
    lw_pose pose;
    int i = 1;
    while (i <= n && closes(w, mode, from + i*step, &pose))
        i++;
    double in = from + (i - 1)*step, out = from + i*step;
    *limit = in;
    if (i > n)
        return false;
    for (int k = 0; k < 60 && in != out; k++) {
        double middle = in + (out - in)/2;
        if (middle == in || middle == out)
            break;
        if (closes(w, mode, middle, &pose))
            in = middle;
        else
            out = middle;
    }
    *limit = in;
    return true;
}

/* Greatest distance of a joint between two poses. */
static double pose_distance(const lw_plan *plan, const lw_pose *a, const lw_pose *b)
{
    double d = 0;
    for (int i = 0; i < LW_JOINT_MAX; i++)
        if (plan->joint_point[i] >= 0)
            d = fmax(d, lw_v2_norm(lw_v2_sub(a->joint[i][0], b->joint[i][0])));
    for (int i = 0; i < plan->n_output; i++)
        d = fmax(d, lw_v2_norm(lw_v2_sub(a->tracer[i][0], b->tracer[i][0])));
    return d;
}

/* Turn over the dyad that is stretched at `limit`: the mode whose pose meets the present one there. */
static bool turn_over(const lw_walk *w, double *mode, double limit, double inwards)
{
    lw_pose here, there;
    int best = -1;
    double least = INFINITY;
    if (!closes(w, mode, limit + inwards, &here))
        return false;
    for (int i = 0; i < w->plan->n_dyad; i++) {
        mode[i] = -mode[i];
        if (closes(w, mode, limit + inwards, &there)) {
            double d = pose_distance(w->plan, &here, &there);
            if (d < least && d > 0) {
                least = d;
                best = i;
            }
        }
        mode[i] = -mode[i];
    }
    if (best >= 0)
        mode[best] = -mode[best];
    return best >= 0;
}

static bool same_mode(const lw_plan *plan, const double *a, const double *b)
{
    for (int i = 0; i < plan->n_dyad; i++)
        if (a[i]*b[i] < 0)
            return false;
    return true;
}

/* Follow the circuit from the end of the first stage until it comes round. */
static void go_round(lw_walk *w, double step, int n_step)
{
    lw_stage *first = &w->stage[0];
    while (w->n_stage < LW_STAGE_MAX) {
        const lw_stage *last = &w->stage[w->n_stage - 1];
        lw_stage next = *last;
        double forward = last->to > last->from ? 1 : -1;
        next.from = last->to;
        if (!turn_over(w, next.mode, last->to, -forward*1e-7*step)
            || !find_limit(w, next.mode, next.from - forward*1e-9*step, -forward*step, n_step, &next.to))
            return;
        bool back = same_mode(w->plan, next.mode, first->mode);
        if (back && forward < 0) {
            w->loops = true;
            return;
        }
        w->stage[w->n_stage++] = next;
    }
}

lw_status lw_walk_make(const lw_plan *plan, const double *dim, const double *mode, double input,
                       double size, lw_walk *w)
{
    *w = (lw_walk){ .plan = plan, .dim = dim, .n_stage = 1 };
    lw_pose pose;
    if (!closes(w, mode, input, &pose))
        return LW_OPEN;
    lw_stage *s = &w->stage[0];
    memcpy(s->mode, mode, sizeof *mode*(size_t)plan->n_dyad);
    int n_step = plan->input_is_slider ? 20*STEPS : STEPS;
    double step = plan->input_is_slider ? size/STEPS : 2*LW_PI/STEPS;
    bool limited = find_limit(w, mode, input, step, n_step, &s->to);
    limited = find_limit(w, mode, input, -step, n_step, &s->from) && limited;
    if (!limited && !plan->input_is_slider) {
        w->turns = w->loops = true;
        s->from = input;
        s->to = input + 2*LW_PI;
    } else if (limited)
        go_round(w, step, n_step);
    return LW_OK;
}

/* Has dyad i two assemblies?  Two crossing lines have one. */
static bool has_modes(const lw_plan *plan, int i)
{
    for (int k = 0; k < plan->n_step; k++)
        if (plan->step[k].dyad == i && plan->step[k].kind >= LW_STEP_RRR)
            return plan->step[k].kind < LW_STEP_PRP;
    return false;
}

/* Is this input in this mode part of a walk? */
static bool holds(const lw_walk *w, const double *mode, double input, double slack)
{
    for (int i = 0; i < w->n_stage; i++) {
        const lw_stage *s = &w->stage[i];
        double lo = fmin(s->from, s->to) - slack, hi = fmax(s->from, s->to) + slack;
        double x = w->plan->input_is_slider ? input : lo + fmod(fmod(input - lo, 2*LW_PI) + 2*LW_PI, 2*LW_PI);
        if (same_mode(w->plan, mode, s->mode) && (w->turns || (x >= lo && x <= hi)))
            return true;
    }
    return false;
}

static bool is_new(const lw_walk *found, int n, const double *mode, double input, double slack)
{
    for (int i = 0; i < n; i++)
        if (holds(&found[i], mode, input, slack))
            return false;
    lw_pose pose;
    return closes(&found[0], mode, input, &pose);
}

bool lw_walk_next(const lw_walk *found, int n, double input, double size, lw_walk *next)
{
    const lw_plan *plan = found[0].plan;
    bool slider = plan->input_is_slider;
    double step = slider ? 5*size/STEPS : 2*LW_PI/STEPS, mode[LW_DYAD_MAX];
    int free_dyad[6], n_free = 0;
    for (int i = 0; i < plan->n_dyad && n_free < 6; i++)
        if (has_modes(plan, i))
            free_dyad[n_free++] = i;
    for (int pattern = 0; pattern < 1 << n_free; pattern++) {
        memcpy(mode, found[0].stage[0].mode, sizeof mode);
        for (int i = 0; i < n_free; i++)
            mode[free_dyad[i]] *= pattern >> i & 1 ? -1 : 1;
        for (int k = 0; k < STEPS; k++) {
            double x = input + step*(k - (slider ? STEPS/2 : 0));
            if (is_new(found, n, mode, x, 2*step)
                && lw_walk_make(plan, found[0].dim, mode, x, size, next) == LW_OK)
                return true;
        }
    }
    return false;
}

void lw_walk_restrict(lw_walk *w, double first, double last)
{
    lw_stage *s = &w->stage[0];
    if (w->turns) {                                     /* the posture may be anywhere in the range */
        s->from = first;
        s->to = last;
    } else {
        s->from = fmax(s->from, first);
        s->to = fmin(s->to, last);
    }
    w->n_stage = 1;
    w->loops = w->turns = false;
}

double lw_walk_input(const lw_walk *w, double t)
{
    int i = (int)fmin(fmax(floor(t), 0), w->n_stage - 1);
    const lw_stage *s = &w->stage[i];
    double u = fmin(fmax(t - i, 0), 1);
    if (!w->turns)
        u = 0.5 - 0.5*cos(LW_PI*u);
    return s->from + u*(s->to - s->from);
}

double lw_walk_time(const lw_walk *w, double input)
{
    const lw_stage *s = &w->stage[0];
    double u = fmin(fmax((input - s->from)/(s->to - s->from), 0), 1);
    return w->turns ? u : acos(1 - 2*u)/LW_PI;
}

lw_status lw_walk_pose(const lw_walk *w, double t, lw_pose *pose)
{
    int i = (int)fmin(fmax(floor(t), 0), w->n_stage - 1);
    return lw_pose_solve(w->plan, w->dim, w->stage[i].mode, lw_walk_input(w, t), 0, pose);
}
