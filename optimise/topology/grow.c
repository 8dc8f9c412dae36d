#include "optimise/topology/grow.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/real.h"
#include "mbs/batch/posture.h"

enum { SAMPLES = 48, TRIES = 12, GENTLE_TRIES = 24, HALVINGS = 30 };

/* The postures of the parent over its motion. */
typedef struct motion_path {
    const lw_linkage *k;
    int     point;                               /* the tracer that the new dyad takes over          */
    lw_plan plan;                                /* with that tracer as its only output              */
    double  dim[LW_DIM_MAX], mode[LW_MODE_MAX], input;
    bool    turns, no_memory;
    double  first, last;
    lw_posture posture[SAMPLES + 1];             /* the last one is the posture                      */
} motion_path;

/* Input of sample i: at equal steps over a turn; else denser near both ends, where at a limit the posture varies like
 * the square root of the input. */
static double sample_input(const motion_path *c, int i)
{
    if (c->turns)
        return c->input + 2*LW_PI*i/SAMPLES;
    return 0.5*(c->first + c->last) - 0.5*(c->last - c->first)*cos(LW_PI*i/(SAMPLES - 1));
}

static lw_status run_path(const lw_linkage *linkage, motion_path *c)
{
    lw_plan_options options = { .tracers = 1u << c->point, .all_joints = true, .kind = LW_PLAN_GEARED };
    lw_status s = lw_plan_make(linkage, options, &c->plan, NULL);
    if (s == LW_OK)
        s = lw_plan_read(&c->plan, linkage, c->dim, c->mode, &c->input, NULL);
    for (int i = 0; s == LW_OK && i <= SAMPLES; i++)
        s = lw_posture_solve(&c->plan, c->dim, c->mode, i == SAMPLES ? c->input : sample_input(c, i), 1, &c->posture[i]);
    return s;
}

/* A pin of a link, to compute the motion of its points from; -1: it has none. */
static int joint_of(const lw_linkage *linkage, int link)
{
    for (int j = 0; j < linkage->n_joint; j++)
        if (lw_joint_turns(linkage->joint[j].kind) && (linkage->joint[j].link[0] == link || linkage->joint[j].link[1] == link))
            return j;
    return -1;
}

/* A point of a link, by its position in the posture. */
typedef struct link_point { int link, joint; lw_vec2 at; } link_point;

/* Its position and velocity in a posture. */
static void move_point(const motion_path *c, const link_point *h, const lw_posture *b, lw_vec2 out[2])
{
    const lw_posture *a = &c->posture[SAMPLES];
    out[0] = h->at;
    out[1] = lw_v2(0, 0);
    if (h->link == c->k->ground || h->joint < 0)
        return;
    lw_vec2 turn = lw_v2_polar(1, b->angle[h->link][0] - a->angle[h->link][0]);
    lw_vec2 lever_arm = lw_v2_turn(lw_v2_sub(h->at, a->joint[h->joint][0]), turn);
    out[0] = lw_v2_add(b->joint[h->joint][0], lever_arm);
    out[1] = lw_v2_add(b->joint[h->joint][1], lw_v2_scale(lw_v2_perp(lever_arm), b->angle[h->link][1]));
}

/* ---- distances that the new dyad spans -------------------------------------------------------------------- */

/* Distance between the tracer and a point, and half the rate of its square. */
static double span(const motion_path *c, const link_point *h, const lw_posture *p, double *rate)
{
    lw_vec2 at[2];
    move_point(c, h, p, at);
    lw_vec2 gap = lw_v2_sub(at[0], p->tracer[0][0]);
    *rate = lw_v2_dot(gap, lw_v2_sub(at[1], p->tracer[0][1]));
    return lw_v2_norm(gap);
}

/* Its extreme between two inputs, at which it rises and falls, by bisection. */
static double extreme(motion_path *c, const link_point *h, double lo, double hi, bool rises)
{
    double rate, d = 0;
    lw_posture posture;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = 0.5*(lo + hi);
        c->no_memory |= lw_posture_solve(&c->plan, c->dim, c->mode, middle, 1, &posture) == LW_E_MEMORY;
        d = span(c, h, &posture, &rate);
        if ((rate > 0) == rises)
            lo = middle;
        else
            hi = middle;
    }
    return d;
}

static void reach(motion_path *c, const link_point *h, double *least, double *most)
{
    double before = 0, rate;
    int n = SAMPLES + c->turns;                           /* a turn ends at its first posture */
    *least = INFINITY;
    *most = 0;
    for (int i = 0; i < n; i++, before = rate) {
        double d = span(c, h, &c->posture[i % SAMPLES], &rate);
        *least = fmin(*least, d);
        *most = fmax(*most, d);
        if (!(before*rate < 0))                           /* at limits there is no rate */
            continue;
        d = extreme(c, h, sample_input(c, i - 1), sample_input(c, i), before > 0);
        *least = fmin(*least, d);
        *most = fmax(*most, d);
    }
}

/* Size of the motion: diagonal of the bounding box of the tracer's path. */
static double size_of(const motion_path *c)
{
    lw_vec2 lo = c->posture[0].tracer[0][0], hi = lo;
    for (int i = 1; i <= SAMPLES; i++) {
        lw_vec2 p = c->posture[i].tracer[0][0];
        lo = lw_v2(fmin(lo.x, p.x), fmin(lo.y, p.y));
        hi = lw_v2(fmax(hi.x, p.x), fmax(hi.y, p.y));
    }
    return lw_v2_norm(lw_v2_sub(hi, lo));
}

static void add_joint(lw_linkage *linkage, int a, int b, lw_vec2 at)
{
    lw_joint *j = &linkage->joint[linkage->n_joint++];
    memset(j, 0, sizeof *j);
    snprintf(j->name, sizeof j->name, "G%d", linkage->n_joint);
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

/* Cosine of the angle between links a and b whose ends are d apart. */
static double knee_cosine(double a, double b, double d) { return (a*a + b*b - d*d)/(2*a*b); }

/* Draw where the second new link is pinned, and two lengths that reach and fold far enough; false: they do not suit. */
static bool try_once(motion_path *c, double size, double transmission, lw_rng *rng, lw_linkage *child)
{
    const lw_linkage *parent = c->k;
    int base = lw_rng_uniform(rng) < 0.6 ? parent->ground : (int)(lw_rng_uniform(rng)*parent->n_link);
    double far = size*0.3*exp(2.5*lw_rng_uniform(rng)), turn = lw_rng_range(rng, 0, 2*LW_PI);
    lw_vec2 p = c->posture[SAMPLES].tracer[0][0];
    link_point h = { base, joint_of(parent, base), lw_v2_add(p, lw_v2_polar(far, turn)) };
    double least, most, here = lw_v2_norm(lw_v2_sub(h.at, p));
    double more = 0.02*exp(3.5*lw_rng_uniform(rng)), fold = lw_rng_range(rng, -0.95, 0.95);
    double side = lw_rng_uniform(rng) < 0.5 ? -1 : 1;
    if (base == parent->tracer[c->point].link || c->plan.link_origin[base] < 0 || (base != parent->ground && h.joint < 0))
        return false;
    reach(c, &h, &least, &most);
    double sum = most*(1 + more), differ = least*fold, a = 0.5*(sum + differ), b = 0.5*(sum - differ);
    double along = (here*here + a*a - b*b)/(2*here), h2 = a*a - along*along;
    if (!(least > 1e-3*size) || !(h2 > 0))
        return false;
    if (transmission > 0 && fmax(knee_cosine(a, b, least), -knee_cosine(a, b, most)) > cos(transmission))
        return false;
    lw_vec2 u = lw_v2_scale(lw_v2_sub(h.at, p), 1/here);
    lw_vec2 knee = lw_v2_add(p, lw_v2_add(lw_v2_scale(u, along), lw_v2_scale(lw_v2_perp(u), side*sqrt(h2))));
    add_links(parent, c->point, base, knee, h.at, child);
    return true;
}

lw_status lw_linkage_grow(const lw_linkage *parent, bool turns, double first, double last, double transmission,
                          lw_rng *rng, lw_linkage *child)
{
    int point = parent->n_tracer > 1 ? (int)(lw_rng_uniform(rng)*parent->n_tracer) : 0;
    bool found = false;
    if (parent->n_link + 2 > LW_LINK_MAX || parent->n_joint + 3 > LW_JOINT_MAX)
        return LW_E_ARG;
    motion_path *c = malloc(sizeof *c);
    if (!c)
        return LW_E_MEMORY;
    c->k = parent, c->point = point, c->turns = turns, c->no_memory = false, c->first = first, c->last = last;
    lw_status s = run_path(parent, c);
    double size = s == LW_OK ? size_of(c) : 0;
    for (int i = 0; s == LW_OK && transmission > 0 && i < GENTLE_TRIES && !found; i++)
        found = try_once(c, size, transmission, rng, child);
    for (int i = 0; s == LW_OK && i < TRIES && !found; i++)
        found = try_once(c, size, 0, rng, child);
    if (s == LW_E_MEMORY || c->no_memory)
        s = LW_E_MEMORY;
    else
        s = found ? LW_OK : LW_OPEN;
    free(c);
    return s;
}
