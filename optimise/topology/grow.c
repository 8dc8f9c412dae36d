#include "optimise/topology/grow.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "mbs/plan/pose.h"

enum { SAMPLES = 48, TRIES = 12 };

/* Where the parent's point and a place on another link are, over its motion. */
typedef struct course {
    const lw_linkage *k;
    int     point;                               /* the tracer that goes on to the new dyad          */
    lw_plan plan;                                /* its only output                                  */
    double  dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    bool    turns;
    double  first, last;
    lw_pose pose[SAMPLES + 1];                   /* the last one is the posture                      */
} course;

/* Even over a turn; else dense towards both ends, where limits make everything go as a root. */
static double place(const course *c, int i)
{
    if (c->turns)
        return c->input + 2*LW_PI*i/SAMPLES;
    return 0.5*(c->first + c->last) - 0.5*(c->last - c->first)*cos(LW_PI*i/(SAMPLES - 1));
}

static bool run_course(const lw_linkage *k, course *c)
{
    if (lw_plan_make(k, (lw_plan_options){ .tracers = 1u << c->point, .all_joints = true, .kind = LW_PLAN_GEARED }, &c->plan, NULL) != LW_OK
        || lw_plan_read(&c->plan, k, c->dim, c->mode, &c->input, NULL) != LW_OK)
        return false;
    for (int i = 0; i <= SAMPLES; i++) {
        double at = i == SAMPLES ? c->input : place(c, i);
        if (lw_pose_solve(&c->plan, c->dim, c->mode, at, 1, &c->pose[i]) != LW_OK)
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

/* A place of a link, by where it lies in the posture. */
typedef struct hold { int link, joint; lw_vec2 at; } hold;

/* Where it is in a pose, and its velocity. */
static void carry(const course *c, const hold *h, const lw_pose *b, lw_vec2 out[2])
{
    const lw_pose *a = &c->pose[SAMPLES];
    out[0] = h->at;
    out[1] = lw_v2(0, 0);
    if (h->link == c->k->ground || h->joint < 0)
        return;
    lw_vec2 turn = lw_v2_polar(1, b->angle[h->link][0] - a->angle[h->link][0]);
    lw_vec2 arm = lw_v2_turn(lw_v2_sub(h->at, a->joint[h->joint][0]), turn);
    out[0] = lw_v2_add(b->joint[h->joint][0], arm);
    out[1] = lw_v2_add(b->joint[h->joint][1], lw_v2_scale(lw_v2_perp(arm), b->angle[h->link][1]));
}

/* ---- how far the new dyad has to reach -------------------------------------------------------------------- */

/* Distance between the point and the hold, and half the rate of its square. */
static double span(const course *c, const hold *h, const lw_pose *p, double *rate)
{
    lw_vec2 at[2];
    carry(c, h, p, at);
    lw_vec2 gap = lw_v2_sub(at[0], p->tracer[0][0]);
    *rate = lw_v2_dot(gap, lw_v2_sub(at[1], p->tracer[0][1]));
    return lw_v2_norm(gap);
}

/* Its extreme between two places where it rises and falls, by halving. */
static double extreme(const course *c, const hold *h, double lo, double hi, bool rises)
{
    double rate, d = 0;
    lw_pose pose;
    for (int i = 0; i < 30; i++) {
        double middle = 0.5*(lo + hi);
        lw_pose_solve(&c->plan, c->dim, c->mode, middle, 1, &pose);
        d = span(c, h, &pose, &rate);
        if ((rate > 0) == rises)
            lo = middle;
        else
            hi = middle;
    }
    return d;
}

static void reach(const course *c, const hold *h, double *least, double *most)
{
    double before = 0, rate;
    int n = SAMPLES + c->turns;                           /* a turn comes back to its first place */
    *least = INFINITY;
    *most = 0;
    for (int i = 0; i < n; i++, before = rate) {
        double d = span(c, h, &c->pose[i % SAMPLES], &rate);
        *least = fmin(*least, d);
        *most = fmax(*most, d);
        if (!(before*rate < 0))                           /* at limits there is no rate */
            continue;
        d = extreme(c, h, place(c, i - 1), place(c, i), before > 0);
        *least = fmin(*least, d);
        *most = fmax(*most, d);
    }
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

static void add_links(const lw_linkage *parent, int point, int base, lw_vec2 knee, lw_vec2 root, lw_linkage *child)
{
    *child = *parent;
    int arm = child->n_link, stay = arm + 1;
    child->n_link += 2;
    snprintf(child->link_name[arm], LW_NAME_SIZE, "arm%d", arm + 1);
    snprintf(child->link_name[stay], LW_NAME_SIZE, "stay%d", stay + 1);
    lw_vec2 p = parent->tracer[point].at;
    add_joint(child, parent->tracer[point].link, arm, p);
    add_joint(child, arm, stay, knee);
    add_joint(child, base, stay, root);
    child->tracer[point].link = arm;
}

/* One try: where the stay is held, and two lengths that reach and fold far enough. */
static bool try_once(const course *c, double size, lw_rng *rng, lw_linkage *child)
{
    const lw_linkage *parent = c->k;
    int base = lw_rng_uniform(rng) < 0.6 ? parent->ground : (int)(lw_rng_uniform(rng)*parent->n_link);
    double far = size*0.3*exp(2.5*lw_rng_uniform(rng)), turn = lw_rng_range(rng, 0, 2*LW_PI);
    lw_vec2 p = c->pose[SAMPLES].tracer[0][0];
    hold h = { base, joint_of(parent, base), lw_v2_add(p, lw_v2_polar(far, turn)) };
    double least, most, here = lw_v2_norm(lw_v2_sub(h.at, p));
    double more = 0.02*exp(3.5*lw_rng_uniform(rng)), fold = lw_rng_range(rng, -0.95, 0.95);
    double side = lw_rng_uniform(rng) < 0.5 ? -1 : 1;
    if (base == parent->tracer[c->point].link || c->plan.link_origin[base] < 0
        || (base != parent->ground && h.joint < 0))
        return false;
    reach(c, &h, &least, &most);
    double sum = most*(1 + more), differ = least*fold, a = 0.5*(sum + differ), b = 0.5*(sum - differ);
    double along = (here*here + a*a - b*b)/(2*here), h2 = a*a - along*along;
    if (!(least > 1e-3*size) || !(h2 > 0))
        return false;
    lw_vec2 u = lw_v2_scale(lw_v2_sub(h.at, p), 1/here);
    lw_vec2 knee = lw_v2_add(p, lw_v2_add(lw_v2_scale(u, along), lw_v2_scale(lw_v2_perp(u), side*sqrt(h2))));
    add_links(parent, c->point, base, knee, h.at, child);
    return true;
}

lw_status lw_linkage_grow(const lw_linkage *parent, bool turns, double first, double last, lw_rng *rng,
                          lw_linkage *child)
{
    course c = { .k = parent, .point = parent->n_tracer > 1 ? (int)(lw_rng_uniform(rng)*parent->n_tracer) : 0,
                 .turns = turns, .first = first, .last = last };
    if (parent->n_link + 2 > LW_LINK_MAX || parent->n_joint + 3 > LW_JOINT_MAX)
        return LW_E_ARG;
    if (!run_course(parent, &c))
        return LW_OPEN;
    double size = size_of(&c);
    for (int i = 0; i < TRIES; i++)
        if (try_once(&c, size, rng, child))
            return LW_OK;
    return LW_OPEN;
}
