/* optimise/report_curve.c - the motion of a result whose plan has higher groups, for which there are no arcs in closed
 * form: the curve of postures through the first station. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mbs/branch.h"
#include "mbs/pose.h"
#include "optimise/report_internal.h"

enum { STEPS = 720 };

typedef struct work {
    lw_system  s;
    lw_linkage k;
    lw_pose    pose;
    double     q[LW_SYSTEM_Q_MAX], dim[LW_DIM_MAX], mode[LW_MODE_MAX];
} work;

static void keep(const lw_pose *pose, lw_report *r)
{
    double angle = asin(sqrt(fmin(fmax(pose->margin, 0), 1)));
    r->transmission_min = fmin(r->transmission_min, angle);              /* NaN gives way            */
    r->transmission_max = fmax(r->transmission_max, angle);
    r->acceleration_max = fmax(r->acceleration_max, lw_v2_norm(pose->tracer[0][2]));
}

/* Postures of the whole curve, even in the input; each is the seed of its own pose. */
static void whole_curve(const lw_plan *plan, const lw_candidate *c, lw_branch *b, work *w, lw_report *r)
{
    double end = lw_branch_segments(b), input, ends[2];
    for (int i = 0; i < 2; i++) {
        lw_branch_pose(b, i*end, w->q, NULL);
        ends[i] = lw_branch_input(b, w->q);
    }
    for (int i = 0; i < STEPS; i++) {
        double station = i ? lw_branch_find(b, 0, end, ends[0] + (ends[1] - ends[0])*i/STEPS) : 0;
        lw_branch_pose(b, station, w->q, NULL);
        lw_system_write(&w->s, w->q, &w->k);
        if (lw_plan_read(plan, &w->k, w->dim, w->mode, &input, NULL) == LW_OK
            && lw_pose_solve(plan, c->dim, w->mode, input, 2, &w->pose) == LW_OK)
            keep(&w->pose, r);
    }
}

static void part_of_curve(const lw_plan *plan, const lw_candidate *c, double from, double to, work *w, lw_report *r)
{
    for (int i = 0; i <= STEPS; i++)
        if (lw_pose_solve(plan, c->dim, c->branch.mode, from + (to - from)*i/STEPS, 2, &w->pose) == LW_OK)
            keep(&w->pose, r);
}

static bool turns_without_limit(const lw_branch *b)
{
    int n;
    const lw_branch_event *e = lw_branch_events(b, &n);
    for (int i = 0; i < n; i++)
        if (e[i].kind == LW_EVENT_LIMIT)
            return false;
    return lw_branch_ended(b) == LW_BRANCH_CLOSED && lw_branch_turns(b, -1) != 0;
}

void lw_report_curve(const lw_plan *plan, const lw_candidate *c, double from, double to, lw_report *r)
{
    const lw_branch_options o = { .input = 0 };
    lw_branch *b = NULL;
    work *w = malloc(sizeof *w);
    if (w && lw_system_make(&r->linkage, NULL, 0, &w->s, NULL) == LW_OK
        && lw_branch_create(&w->s, NULL, &o, &b, NULL) == LW_OK) {
        w->k = r->linkage;
        r->turns = turns_without_limit(b);
        if (r->turns)
            whole_curve(plan, c, b, w, r);
        lw_branch_free(b);
    }
    if (w && !r->turns)
        part_of_curve(plan, c, from, to, w, r);
    free(w);
}
