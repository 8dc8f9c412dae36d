#include "optimise/grow.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "mbs/pose.h"

enum { SAMPLES = 48, TRIES = 12 };

/* Where the parent's point and a place on another link are, over its motion. */
typedef struct course {
    int     point;                               /* the tracer that goes on to the new dyad          */
    lw_plan plan;                                /* its only output                                  */
    double  dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    lw_pose pose[SAMPLES + 1];                   /* the last one is the posture                      */
} course;

static bool run_course(const lw_linkage *k, bool turns, double first, double last, course *c)
{
    if (lw_plan_make_geared(k, (lw_want){ .tracers = 1u << c->point, .all_joints = true }, &c->plan, NULL) != LW_OK
        || lw_plan_read(&c->plan, k, c->dim, c->mode, &c->input, NULL) != LW_OK)
        return false;
    for (int i = 0; i <= SAMPLES; i++) {
        double at = turns ? c->input + 2*LW_PI*i/SAMPLES : first + (last - first)*i/(SAMPLES - 1);
        if (i == SAMPLES)
            at = c->input;
        if (lw_pose_solve(&c->plan, c->dim, c->mode, at, 0, &c->pose[i]) != LW_OK)
            return false;
    }
    return true;
}

/* A joint of a link to carry its places along. */
static int joint_of(const lw_linkage *k, int link)
{
    for (int j = 0; j < k->n_joint; j++)
        if (k->joint[j].kind == LW_JOINT_REVOLUTE && (k->joint[j].link[0] == link || k->joint[j].link[1] == link))
            return j;
    return -1;
}

/* The place of a link that lies at `at` in the posture, in pose i. */
static lw_vec2 carried(const course *c, const lw_linkage *k, int link, lw_vec2 at, int i)
{
    int j = joint_of(k, link);
    const lw_pose *a = &c->pose[SAMPLES], *b = &c->pose[i];
    if (link == k->ground || j < 0)
        return at;
    lw_vec2 turn = lw_v2_polar(1, b->angle[link][0] - a->angle[link][0]);
    return lw_v2_add(b->joint[j][0], lw_v2_turn(lw_v2_sub(at, a->joint[j][0]), turn));
}

/* How large the motion is: the diagonal of the point's box. */
static double size_of(const course *c)
{
    lw_vec2 lo = c->pose[0].tracer[0][0], hi = lo;
    for (int i = 1; i <= SAMPLES; i++) {
        lw_vec2 p = c->pose[i].tracer[0][0];
        lo = lw_v2(fmin(lo.x, p.x), fmin(lo.y, p.y));
        hi = lw_v2(fmax(hi.x, p.x), fmax(hi.y, p.y));
    }
    return lw_v2_norm(lw_v2_sub(hi, lo));
}

static void add_joint(lw_linkage *k, int a, int b, lw_vec2 at)
{
    lw_joint *j = &k->joint[k->n_joint++];
    memset(j, 0, sizeof *j);
    snprintf(j->name, sizeof j->name, "G%d", k->n_joint);
    j->kind = LW_JOINT_REVOLUTE;
    j->link[0] = a;
    j->link[1] = b;
    j->at = at;
}

static void add_links(const lw_linkage *parent, int point, int base, lw_vec2 knee, lw_vec2 hold, lw_linkage *child)
{
    *child = *parent;
    int arm = child->n_link, stay = arm + 1;
    child->n_link += 2;
    snprintf(child->link_name[arm], LW_NAME_SIZE, "arm%d", arm + 1);
    snprintf(child->link_name[stay], LW_NAME_SIZE, "stay%d", stay + 1);
    lw_vec2 p = parent->tracer[point].at;
    add_joint(child, parent->tracer[point].link, arm, p);
    add_joint(child, arm, stay, knee);
    add_joint(child, base, stay, hold);
    child->tracer[point].link = arm;
}

/* Least and greatest distance over the motion, from squares (which have no kink where the distance has one): at the
 * samples, and between them at the vertex of the parabola through three. */
static void extremes(const double d2[SAMPLES + 1], bool turns, double *least, double *most)
{
    double lo = d2[SAMPLES], hi = d2[SAMPLES];
    for (int i = 0; i < SAMPLES; i++) {
        bool inside = turns || (i > 0 && i < SAMPLES - 1);
        double here = d2[i], to_last = d2[(i + SAMPLES - 1)%SAMPLES] - here, to_next = d2[(i + 1)%SAMPLES] - here;
        double bend = to_last + to_next, vertex = here;
        if (inside && to_last*to_next > 0)
            vertex -= (to_next - to_last)*(to_next - to_last)/(8*bend);
        lo = fmin(lo, fmin(here, vertex));
        hi = fmax(hi, fmax(here, vertex));
    }
    *least = sqrt(fmax(lo, 0));
    *most = sqrt(hi);
}

/* One try: where the stay is held, and two lengths that reach and fold far enough. */
static bool try_once(const course *c, const lw_linkage *parent, bool turns, double size, lw_rng *rng, lw_linkage *child)
{
    int base = lw_rng_uniform(rng) < 0.6 ? parent->ground : (int)(lw_rng_uniform(rng)*parent->n_link);
    double far = size*0.3*exp(2.5*lw_rng_uniform(rng)), turn = lw_rng_range(rng, 0, 2*LW_PI);
    lw_vec2 p = c->pose[SAMPLES].tracer[0][0], hold = lw_v2_add(p, lw_v2_polar(far, turn));
    double d2[SAMPLES + 1], least, most, here = lw_v2_norm(lw_v2_sub(hold, p));
    double reach = 0.02*exp(3.5*lw_rng_uniform(rng)), fold = lw_rng_range(rng, -0.95, 0.95);
    double side = lw_rng_uniform(rng) < 0.5 ? -1 : 1;
    if (base == parent->tracer[c->point].link || c->plan.link_origin[base] < 0
        || (base != parent->ground && joint_of(parent, base) < 0))
        return false;
    for (int i = 0; i <= SAMPLES; i++) {
        lw_vec2 d = lw_v2_sub(carried(c, parent, base, hold, i), c->pose[i].tracer[0][0]);
        d2[i] = lw_v2_dot(d, d);
    }
    extremes(d2, turns, &least, &most);
    double sum = most*(1 + reach), differ = least*fold, a = 0.5*(sum + differ), b = 0.5*(sum - differ);
    double along = (here*here + a*a - b*b)/(2*here), h2 = a*a - along*along;
    if (!(least > 1e-3*size) || !(h2 > 0))
        return false;
    lw_vec2 u = lw_v2_scale(lw_v2_sub(hold, p), 1/here);
    lw_vec2 knee = lw_v2_add(p, lw_v2_add(lw_v2_scale(u, along), lw_v2_scale(lw_v2_perp(u), side*sqrt(h2))));
    add_links(parent, c->point, base, knee, hold, child);
    return true;
}

lw_status lw_linkage_grow(const lw_linkage *parent, bool turns, double first, double last, lw_rng *rng,
                          lw_linkage *child)
{
    course c = { .point = parent->n_tracer > 1 ? (int)(lw_rng_uniform(rng)*parent->n_tracer) : 0 };
    if (parent->n_link + 2 > LW_LINK_MAX || parent->n_joint + 3 > LW_JOINT_MAX)
        return LW_E_ARG;
    if (!run_course(parent, turns, first, last, &c))
        return LW_OPEN;
    double size = size_of(&c);
    for (int i = 0; i < TRIES; i++)
        if (try_once(&c, parent, turns, size, rng, child))
            return LW_OK;
    return LW_OPEN;
}
