/* optimise/report/report_limits.c - is it a linkage to build: its size, the limits it keeps, and those it is at. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "optimise/problem/problem.h"
#include "optimise/report/report_internal.h"

#define AT_LIMIT 1e-3             /* relative: nearer than this, a limit is active                                  */
#define KEPT     1.01             /* limits are kept to this factor                                                */

static bool on_link(const lw_joint *j, int link)
{
    return lw_joint_turns(j->kind) && (j->link[0] == link || j->link[1] == link);
}

/* Add the arms of the points of a link: the size takes the longest of each, the ratio of lengths the one to the nearest pin. */
static void measure_arms(const lw_linkage *linkage, int link, lw_fit_report *r)
{
    for (int j = 0; j < linkage->n_tracer; j++) {
        double nearest = INFINITY;
        for (int i = 0; i < linkage->n_joint && linkage->tracer[j].link == link; i++)
            if (on_link(&linkage->joint[i], link)) {
                double arm = lw_v2_norm(lw_v2_sub(linkage->joint[i].at, linkage->tracer[j].at));
                nearest = fmin(nearest, arm);
                r->size = fmax(r->size, arm);
            }
        r->arm = fmax(r->arm, isfinite(nearest) ? nearest : 0);
    }
}

/* apart: the pins of a link have different places.  A pin that the search put onto another one makes a link useless, and its length counts
 * as any other; linkages that a person gave may have two joints on one pin. */
static void measure_lengths(const lw_linkage *linkage, bool apart, lw_fit_report *r)
{
    r->size = r->arm = 0;
    r->length_least = r->length_most = NAN;
    for (int link = 0; link < linkage->n_link; link++) {
        for (int i = 0; i < linkage->n_joint; i++) {
            if (!on_link(&linkage->joint[i], link))
                continue;
            for (int j = 0; j < i; j++) {
                double length = lw_v2_norm(lw_v2_sub(linkage->joint[i].at, linkage->joint[j].at));
                if (!on_link(&linkage->joint[j], link) || (!apart && !(length > 1e-9*r->size)))
                    continue;
                r->length_least = fmin(r->length_least, length);
                r->length_most = fmax(r->length_most, length);
                r->size = fmax(r->size, length);
            }
        }
        measure_arms(linkage, link, r);
    }
}

static void add_active(lw_fit_report *r, const char *name)
{
    if (r->n_active < LW_ACTIVE_MAX)
        snprintf(r->active[r->n_active++], sizeof r->active[0], "%s", name);
}

static bool near(double a, double b) { return isfinite(b) && fabs(a - b) <= AT_LIMIT*fmax(fabs(a), fabs(b)); }

/* Which dimensions are at a bound that leaves them free, and which conditions are active? */
static void find_active(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_motion_limits *motion, lw_fit_report *r)
{
    lw_problem *p = malloc(sizeof *p);
    double x[LW_VAR_MAX];
    lw_status st = p ? lw_problem_make(t, s, c->family, c->intended.mode[0], c->intended.sense, p, NULL) : LW_E_MEMORY;
    r->no_memory |= st == LW_E_MEMORY;
    if (st == LW_OK) {
        lw_problem_from_dims(p, c->dim, x);
        for (int i = 0; i < p->n_dim; i++)
            if (p->lo[i] < p->hi[i] && (near(x[i], p->lo[i]) || near(x[i], p->hi[i])) && isfinite(x[i]))
                add_active(r, p->plan.dim[i].name);
        lw_problem_free(p);
    }
    free(p);
    if (s->length_ratio > 0 && near(lw_fit_report_ratio(t, r), s->length_ratio))
        add_active(r, "length-ratio");
    if (s->min_transmission > 0 && near(r->transmission_min, s->min_transmission))
        add_active(r, "transmission");
    if (s->class_margin > 0 && r->has_class && near(r->barker.margin, s->class_margin))
        add_active(r, "class-margin");
    bool slide = r->linkage.n_input > 0 && lw_joint_slides(r->linkage.joint[r->linkage.input[0].joint].kind);
    double acceleration = slide ? s->max_slide_acceleration : s->max_acceleration;
    if (acceleration > 0 && near(motion->acceleration, acceleration))
        add_active(r, "acceleration");
    if (t->size > 0 && lw_pivots_astray(s, &r->linkage) > -AT_LIMIT*t->size)
        add_active(r, "pivots");
    if (t->size > 0 && motion->intrusion > -AT_LIMIT*t->size)
        add_active(r, "forbidden");
}

/* Does the input pass a limit, or turn back, between the stations? */
static bool passes_limit(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_fit_report *r)
{
    if (t->closed && !r->turns && lw_task_has_place(s->task))
        return true;
    size_t dyads = (size_t)c->n_dyad;
    for (size_t i = dyads; c->mode_of && i < t->n*dyads; i++)
        if (c->mode_of[i] != c->mode_of[i - dyads])
            return true;
    bool up = false, down = false;
    for (size_t i = 1; i < t->n && s->timing == LW_TIMING_FREE && !r->turns; i++) {
        up |= c->input[i] > c->input[i - 1];
        down |= c->input[i] < c->input[i - 1];
    }
    return up && down;
}

static void broken(lw_fit_report *r, unsigned limit, const char *text, double value)
{
    if (r->broken == 0)
        snprintf(r->broken_text, sizeof r->broken_text, text, value);
    r->broken |= limit;
}

static void judge(const lw_target *t, const lw_fit_spec *s, lw_fit_report *r)
{
    if (s->within_limits && r->passes_limit)
        broken(r, LW_LIMIT_MOTION, "the input passes a limit or turns back on its way", 0);
    if (s->within_limits && lw_task_has_place(s->task) && r->stray.to_target > lw_stray_allowed(t, t->n)*t->size + 2*r->error_max)
        broken(r, LW_LIMIT_MOTION, "between the stations its curve strays from the target by %.3g of the target's size",
               r->stray.to_target/t->size);
    if (s->by_default & LW_LIMIT_TRANSMISSION && r->transmission_min < s->min_transmission - AT_LIMIT)
        broken(r, LW_LIMIT_TRANSMISSION, "its transmission angle falls to %.3g degrees", r->transmission_min*180/LW_PI);
    if (s->by_default & LW_LIMIT_MARGIN ? lw_fit_report_may_change(r, s->class_margin/KEPT)
                                        : s->class_margin > 0 && r->has_class && r->barker.margin*KEPT < s->class_margin)
        broken(r, LW_LIMIT_MARGIN, "it is only %.3g perimeters from a change point", r->barker.margin);
    else if (s->by_default & LW_LIMIT_MARGIN && r->rests)
        broken(r, LW_LIMIT_MARGIN, "one of its pins does not turn, so it moves as a linkage with fewer links", 0);
    if (s->by_default & LW_LIMIT_RATIO && s->n_bound == 0 && lw_fit_report_ratio(t, r) > KEPT*s->length_ratio)
        broken(r, LW_LIMIT_RATIO, "one of its lengths is %.3g times another", lw_fit_report_ratio(t, r));
    if (s->max_size > 0 && t->extent > 0 && s->n_bound == 0 && !(s->length_hi > 0) && r->size > KEPT*s->max_size*t->extent)
        broken(r, LW_LIMIT_SIZE, "it is %.3g times as large as the target", r->size/t->extent);
}

const char *lw_fit_report_input(const lw_fit_report *r)
{
    return r->passes_limit ? "limit" : r->turns ? "turns" : "rocks";
}

double lw_fit_report_stray(const lw_fit_report *r)
{
    return isnan(r->stray.to_target) ? NAN : fmax(r->stray.to_curve, r->stray.to_target);
}

double lw_fit_report_objective(const lw_candidate *c, const lw_fit_report *r)
{
    bool meets = !(r->error_max > 0 || r->angle_max > 0);
    for (int k = 0; k < r->n_also; k++)
        meets &= !(r->also[k].max > 0 || r->also[k].angle_max > 0);
    return meets ? 0 : c->objective;
}

bool lw_fit_report_may_change(const lw_fit_report *r, double margin)
{
    bool away = !r->turns && !r->passes_limit && r->transmission_min >= LW_DEFAULT_TRANSMISSION_DEG*LW_PI/180 - AT_LIMIT && !r->rests;
    return r->has_class && r->barker.margin < margin && !away;
}

double lw_fit_report_ratio(const lw_target *t, const lw_fit_report *r)
{
    return (t->extent > 0 ? fmax(r->length_most, r->arm) : r->length_most)/r->length_least;
}

/* The error of the angle, as a distance. */
static double turned(const lw_target *t, const lw_fit_report *r)
{
    return isnan(r->angle_max) ? 0 : 0.5*t->extent*r->angle_max;
}

double lw_fit_report_misses(const lw_target *t, const lw_fit_report *r)
{
    return fmax(r->error_max + turned(t, r), lw_fit_report_stray(r));
}

#define FEW        16              /* stations                                                              */
#define SAME_CURVE 1e-5            /* stations met so well, by a linkage with few dimensions, were drawn by that linkage   */

double lw_fit_report_distance(const lw_target *t, const lw_fit_report *r)
{
    int links = r->linkage.n_link;
    if (links == 4 && r->linkage.n_joint == 4 && t->n < FEW && r->error_max < LW_EXACT_ENOUGH*t->extent)
        return fmax(r->stray.to_curve, r->stray.to_target - r->stray.unsure) + turned(t, r);
    bool drawn_by_it = r->error_max < SAME_CURVE*t->extent && (int)t->n >= 4*links;
    return (drawn_by_it ? r->stray.to_curve : fmax(r->error_max, lw_fit_report_stray(r))) + turned(t, r);
}

double lw_fit_report_known_miss(const lw_target *t, const lw_fit_report *r, double doubt)
{
    if (t->n >= FEW)
        return lw_fit_report_distance(t, r);
    return fmax(fmax(r->error_max, doubt*r->stray.to_target), r->stray.to_target - r->stray.unsure) + turned(t, r);
}

void lw_fit_report_active(const lw_fit_report *r, char *text, size_t size)
{
    text[0] = 0;
    for (int i = 0; i < r->n_active; i++)
        snprintf(text + strlen(text), size - strlen(text), "%s%s", i ? ", " : "", r->active[i]);
}

void lw_fit_report_limits(const lw_target *t, const lw_fit_spec *s, const lw_candidate *c, const lw_motion_limits *motion, lw_fit_report *r)
{
    measure_lengths(&r->linkage, !c->family->posture, r);
    find_active(t, s, c, motion, r);
    r->passes_limit = passes_limit(t, s, c, r);
    judge(t, s, r);
}
