#include "optimise/task/motion_limits.h"

#include <stdio.h>
#include "base/real.h"

#define TOLERANCE 1e-3            /* conditions are met to this relative accuracy */

lw_motion_limits lw_motion_limits_begin(void)
{
    return (lw_motion_limits){ .margin_least = NAN, .margin_most = NAN, .intrusion = -INFINITY };
}

static double depth(const lw_zone *z, const lw_plan *plan, const lw_posture *posture)
{
    double least = INFINITY;
    for (int j = 0; j < LW_JOINT_MAX; j++)
        if (plan->joint_point[j] >= 0)
            least = fmin(least, lw_zone_outside(z, posture->joint[j][0]));
    for (int i = 0; i < plan->n_output; i++)
        least = fmin(least, lw_zone_outside(z, posture->tracer[i][0]));
    return -least;
}

void lw_motion_limits_posture(const lw_plan *plan, const lw_fit_spec *s, const lw_posture *posture, lw_motion_limits *w)
{
    double a = !lw_task_has_place(s->task) ? fabs(posture->angle[plan->output_link[0]][2])
                                           : lw_v2_norm(posture->tracer[0][2]);
    w->margin_least = fmin(w->margin_least, posture->margin);           /* fmin prefers a number to NaN */
    w->margin_most = fmax(w->margin_most, posture->margin);
    w->acceleration = fmax(w->acceleration, a/plan->input_turns_per_period/plan->input_turns_per_period);
    for (int i = 0; i < s->n_zone; i++)
        if (lw_zone_forbids(&s->zone[i]))
            w->intrusion = fmax(w->intrusion, depth(&s->zone[i], plan, posture));
}

void lw_motion_limits_run(const lw_plan *plan, const lw_fit_spec *s, const double *dim, const double *modes,
                          double from, double to, int steps, lw_motion_limits *w)
{
    lw_posture posture;
    for (int k = 0; k <= steps; k++) {
        lw_status st = lw_posture_solve(plan, dim, modes, from + (to - from)*k/steps, 2, &posture);
        if (st == LW_OK)
            lw_motion_limits_posture(plan, s, &posture, w);
        w->no_memory |= st == LW_E_MEMORY;
    }
}

/* Distance of a fixed pivot from its zone. */
static double astray(const lw_zone *z, lw_vec2 at)
{
    if (z->kind != LW_ZONE_PIVOTS_LINE)
        return lw_zone_outside(z, at);
    return fabs(lw_v2_cross(z->to, lw_v2_sub(at, z->at))) - z->reach;
}

double lw_pivots_astray(const lw_fit_spec *s, const lw_linkage *linkage)
{
    double most = -INFINITY;
    for (int i = 0; i < s->n_zone; i++)
        for (int j = 0; j < linkage->n_joint; j++)
            if (!lw_zone_forbids(&s->zone[i]) && lw_joint_turns(linkage->joint[j].kind)
                && (linkage->joint[j].link[0] == linkage->ground || linkage->joint[j].link[1] == linkage->ground))
                most = fmax(most, astray(&s->zone[i], linkage->joint[j].at));
    return most;
}

bool lw_motion_limits_meets(const lw_motion_limits *w, const lw_fit_spec *s, const lw_linkage *linkage,
                            double size, char *why, size_t why_size)
{
    double sine = sqrt(fmax(0, w->margin_least)), m = size > 0 ? size : 1, pivots = lw_pivots_astray(s, linkage);
    bool slide = linkage->n_input > 0 && lw_joint_slides(linkage->joint[linkage->input[0].joint].kind);
    double most = slide ? s->max_slide_acceleration : s->max_acceleration;
    char text[160] = "";
    bool soft = s->by_default & LW_LIMIT_TRANSMISSION;
    if (s->min_transmission > 0 && !soft && !(sine >= sin(s->min_transmission) - TOLERANCE))
        snprintf(text, sizeof text, "its transmission angle falls to %.4g deg, and %.4g were asked for",
                 asin(sine)*180/LW_PI, s->min_transmission*180/LW_PI);
    else if (most > 0 && !(w->acceleration <= (1 + TOLERANCE)*most))
        snprintf(text, sizeof text, "its acceleration rises to %.4g times what was allowed", w->acceleration/most);
    else if (w->intrusion > TOLERANCE*m)
        snprintf(text, sizeof text, "it enters a forbidden zone as deep as %.3g of the target's size", w->intrusion/m);
    else if (pivots > TOLERANCE*m)
        snprintf(text, sizeof text, "a fixed pivot is %.3g of the target's size from where it has to be", pivots/m);
    if (why && text[0])
        snprintf(why, why_size, "%s", text);
    return !text[0];
}
