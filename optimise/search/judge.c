/* optimise/search/judge.c - what a find is worth: is it a result, how far is it beyond the limits, and what does the linkage count as? */
#include "optimise/problem/constraint.h"
#include "optimise/problem/evaluate.h"
#include "optimise/problem/residuals.h"
#include "optimise/problem/timing.h"
#include "optimise/search/fit_internal.h"

enum { BEYOND_MOST = 13 };      /* a soft transmission angle may fall to 0, but not the other conditions   */
#define STRAY_STEP 0.05     /* of the size of the target: finds that stray farther than others come after them */
#define CONDITIONS_MET 1e-6  /* conditions on results are met to this                                 */
#define NEAR_STATIONS 1e-2   /* sizes of the target: mean error of finds for few stations that are weighed */

/* A target of so many stations is a curve, not a few points: without limits too, linkages that follow it come first. */
#define DRAWN 32

/* Does the tracer pass this phase between the first station and the last? */
static bool is_between(const lw_problem *p, const lw_work *w, double phase)
{
    double after = fmod(p->intended.sense*(phase - w->phase[0]), 2*LW_PI);
    return p->closed || after + (after < 0)*2*LW_PI <= p->intended.sense*(w->phase[p->n - 1] - w->phase[0]);
}

/* How far the curve leaves the target between the stations beyond what results may, in sizes of the target; at most 0: not
 * beyond.  The phases of the stations are in work. */
static double strays(const lw_search *s, const lw_problem *p, const double *x, lw_work *w)
{
    double most = 0, off = 0;
    bool matters = s->o->spec.within_limits || p->n >= DRAWN, whole = p->closed && p->intended.turns;
    if (!matters || !(whole || (!p->closed && p->timing == LW_TIMING_FREE)) || !lw_task_has_place(p->task))
        return 0;
    for (size_t k = 0; k < p->n; k++)
        off = fmax(off, hypot(w->jac.x[k] - p->x[k], w->jac.y[k] - p->y[k]));
    lw_timing_sample(p, x, w);
    for (int j = 0; j < LW_CURVE_SAMPLES; j++) {
        double least = is_between(p, w, w->turn[j]) ? INFINITY : 0;
        for (size_t k = !p->closed, to = p->closed ? p->n - 1 : 0; k < p->n && least > most; to = k++)
            least = lw_v2_nearer(lw_v2(w->curve_x[j], w->curve_y[j]), lw_v2(p->x[to], p->y[to]), lw_v2(p->x[k], p->y[k]), least);
        most = fmax(most, least);
    }
    return (most - 2*off)*p->unit/s->t->size - lw_stray_allowed(s->t, p->n);
}

/* Take whole turns off an angle that has no bounds: steps of the solver may have added many. */
static void fold(const lw_problem *p, int i, double *x)
{
    if (i >= 0 && isinf(p->lo[i]) && isinf(p->hi[i]))
        x[i] = remainder(x[i], 2*LW_PI);
}

static void fold_angles(const lw_problem *p, double *x)
{
    if (p->datum == LW_DATUM_PLANE && p->plan.input_turns_per_period != 1)
        return;                                          /* the input is counted from a part of theta0 */
    fold(p, p->plan.i_theta0, x);
    fold(p, p->plan.input_is_slider ? -1 : p->i_input0, x);
    fold(p, p->i_tool0, x);
    for (int k = 0; k < p->n_also; k++)
        fold(p, p->also[k].i_tool, x);
}

void lw_search_judge(const lw_search *s, const lw_problem *p, lw_work *work, lw_found *c)
{
    fold_angles(p, c->x);
    if (isfinite(c->f) && (p->timing != LW_TIMING_PRESCRIBED || p->transmission_is_soft))  /* f of x alone, without stations kept */
        c->f = lw_problem_value(p, c->x, NULL, work);
    if (isfinite(c->f) && !lw_problem_stays(p, c->x, work))
        c->f = INFINITY;
    c->beyond = 0;
    if (isfinite(c->f) && !lw_problem_admissible(p, c->x, CONDITIONS_MET, work)) {
        c->beyond = 1 + (int)(lw_problem_lacks(p, c->x, work)/LW_BEYOND);
        c->f = p->transmission_is_soft && c->beyond <= BEYOND_MOST ? c->f : INFINITY;
    }
    double beyond = isfinite(c->f) && lw_problem_settle(p, c->x, work) ? strays(s, p, c->x, work) : 0;
    if (beyond > 0)
        c->beyond += 1 + (int)fmin(10, beyond/STRAY_STEP);
    c->polished = true;
    c->size = lw_problem_size(p, c->x);
}

lw_problem *lw_search_problem_again(lw_search *s, int thread, double angle, lw_found *c, lw_status *st)
{
    lw_problem *p = lw_search_problem(s, thread, c->candidate, false, st);
    if (!p)
        return NULL;
    p->intended = c->intended;
    p->transmission_is_soft = false;
    p->min_transmission = fmax(p->min_transmission, angle*LW_PI/180);
    p->n_side = p->n_side_known;
    c->gentle = angle;
    lw_problem_work_intended(p, s->bench[thread].work);
    return p;
}

bool lw_search_climbs(const lw_search *s)
{
    return s->o->cost && lw_task_has_place(s->o->spec.task) && s->t->n <= LW_FEW_STATIONS && lw_search_widens(s);
}

double lw_search_cost(lw_search *s, int thread, const lw_found *c)
{
    lw_candidate as;
    if (c->beyond || !isfinite(c->f) || !lw_search_fill(s, thread, c, &as))
        return INFINITY;
    double cost = s->o->cost(s->t, &s->o->spec, &as);
    lw_candidate_free(&as);
    return cost;
}

void lw_search_weigh(lw_search *s, int thread, lw_found *c)
{
    lw_status st;
    const bool met = c->f <= NEAR_STATIONS*NEAR_STATIONS*(double)s->t->n;
    lw_problem *p = met && !c->polished ? lw_search_problem_again(s, thread, 0, c, &st) : NULL;
    if (p)
        lw_search_judge(s, p, s->bench[thread].work, c);
    c->cost = met ? lw_search_cost(s, thread, c) : INFINITY;
}

