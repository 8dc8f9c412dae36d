/* tests/mbs_linkage.h - small linkages written by hand, for the tests of mbs/. */
#ifndef LW_TESTS_MBS_LINKAGE_H
#define LW_TESTS_MBS_LINKAGE_H

#include <stdio.h>
#include <string.h>
#include "grammar/linkage/linkage.h"

static inline void blank_linkage(lw_linkage *k, int n_link)
{
    memset(k, 0, sizeof *k);
    snprintf(k->name, sizeof k->name, "test");
    k->n_link = n_link;
    k->units = lw_units_si();
    for (int i = 0; i < n_link; i++)
        snprintf(k->link_name[i], LW_NAME_SIZE, "L%d", i + 1);
}

static inline int add_joint(lw_linkage *k, lw_joint_kind kind, int i, int j, lw_vec2 at, double along)
{
    lw_joint *q = &k->joint[k->n_joint];
    snprintf(q->name, sizeof q->name, "J%d", k->n_joint + 1);
    q->kind = kind;
    q->link[0] = i;
    q->link[1] = j;
    q->at = at;
    if (kind != LW_JOINT_REVOLUTE)
        q->along = lw_v2_polar(1.0, along);
    return k->n_joint++;
}

static inline int add_pin(lw_linkage *k, int i, int j, lw_vec2 at)
{
    return add_joint(k, LW_JOINT_REVOLUTE, i, j, at, 0.0);
}

static inline int add_slide(lw_linkage *k, int i, int j, lw_vec2 at, double along)
{
    return add_joint(k, LW_JOINT_SLIDER, i, j, at, along);
}

static inline int add_gear(lw_linkage *k, int i, int j, lw_vec2 at, double ratio)
{
    int g = add_joint(k, LW_JOINT_GEAR, i, j, at, 0.0);
    k->joint[g].along = lw_v2(0.0, 0.0);
    k->joint[g].ratio = ratio;
    return g;
}

/* Several joints in one call: add_joints(k, JOINTS(PIN(0, 1, x, y), SLIDE(1, 2, x, y, angle), GEAR(2, 0, x, y, ratio))). */
typedef struct joint_row { lw_joint_kind kind; int i, j; double x, y, more; } joint_row;
#define PIN(i, j, x, y)          { LW_JOINT_REVOLUTE, i, j, x, y, 0 }
#define SLIDE(i, j, x, y, angle) { LW_JOINT_SLIDER, i, j, x, y, angle }
#define GEAR(i, j, x, y, ratio)  { LW_JOINT_GEAR, i, j, x, y, ratio }
#define JOINTS(...) (const joint_row[]){ __VA_ARGS__ }, (int)(sizeof (joint_row[]){ __VA_ARGS__ }/sizeof(joint_row))

static inline void add_joints(lw_linkage *k, const joint_row *row, int n)
{
    for (; n-- > 0; row++)
        if (row->kind == LW_JOINT_GEAR)
            add_gear(k, row->i, row->j, lw_v2(row->x, row->y), row->more);
        else
            add_joint(k, row->kind, row->i, row->j, lw_v2(row->x, row->y), row->more);
}

static inline void add_input(lw_linkage *k, int joint, double value)
{
    k->input[k->n_input++] = (lw_input){ .joint = joint, .value = value };
}

static inline void add_tracer(lw_linkage *k, int link, lw_vec2 at)
{
    lw_tracer *q = &k->tracer[k->n_tracer++];
    snprintf(q->name, sizeof q->name, "P%d", k->n_tracer);
    q->link = link;
    q->at = at;
}

/* Where two circles meet, on the left (side +1) or right of the line from a to b: the plain formula,
 * a negative square taken as 0. */
static inline lw_vec2 meet(lw_vec2 a, double ra, lw_vec2 b, double rb, double side)
{
    lw_vec2 line = lw_v2_sub(b, a);
    double d2 = lw_v2_dot(line, line), along = 0.5*(1.0 + (ra*ra - rb*rb)/d2);
    double h2 = ra*ra/d2 - along*along;
    lw_vec2 up = lw_v2_scale(lw_v2_perp(line), side*sqrt(h2 > 0.0 ? h2 : 0.0));
    return lw_v2_add(a, lw_v2_add(lw_v2_scale(line, along), up));
}

/* Joints A0 A B B0 and tracer of a four-bar  r1 r2 r3 r4 cx cy x0 y0 theta0  with its input at
 * `angle` from its frame. */
typedef struct fourbar_joints { lw_vec2 a0, a, b, b0, p; } fourbar_joints;

static inline fourbar_joints fourbar_at(const double k[9], double mode, double angle)
{
    fourbar_joints q;
    q.a0 = lw_v2(k[6], k[7]);
    lw_vec2 a = lw_v2_polar(k[1], angle + k[8]), b0 = lw_v2_polar(k[0], k[8]);
    lw_vec2 b = meet(a, k[2], b0, k[3], mode);
    lw_vec2 p = lw_v2_add(a, lw_v2_turn(lw_v2_sub(b, a), lw_v2(k[4]/k[2], k[5]/k[2])));
    q.a = lw_v2_add(q.a0, a);
    q.b = lw_v2_add(q.a0, b);
    q.b0 = lw_v2_add(q.a0, b0);
    q.p = lw_v2_add(q.a0, p);
    return q;
}

/* The four-bar as a linkage: links ground, crank, coupler, rocker; joints A0 A B B0. */
static inline void fourbar_linkage(lw_linkage *k, const double dim[9], double mode, double angle)
{
    fourbar_joints q = fourbar_at(dim, mode, angle);
    blank_linkage(k, 4);
    add_pin(k, 0, 1, q.a0);
    add_pin(k, 1, 2, q.a);
    add_pin(k, 2, 3, q.b);
    add_pin(k, 3, 0, q.b0);
    add_input(k, 0, angle + dim[8]);
    add_tracer(k, 2, q.p);
}

#endif
