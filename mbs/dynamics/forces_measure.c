/* mbs/dynamics/forces_measure.c - lengths, displacements, coordinates and turns with two derivatives. */
#include "mbs/dynamics/forces.h"

#include <string.h>

/* A point of a body: place and arm in the plane, scaled; rate. */
typedef struct point { lw_vec2 p, r, v; } point;

static point point_of(int body, lw_vec2 arm, const double *q, const double *v)
{
    if (body < 0)
        return (point){ arm, { 0, 0 }, { 0, 0 } };
    const double *c = q + 3*body, *d = v + 3*body;
    lw_vec2 r = lw_v2_turn(arm, lw_v2_polar(1, c[2]));
    return (point){ lw_v2_add(lw_v2(c[0], c[1]), r), r, lw_v2_add(lw_v2(d[0], d[1]), lw_v2_scale(lw_v2_perp(r), d[2])) };
}

/* Derivative of w . p by the three coordinates of p's body, w fixed. */
static void along(lw_vec2 w, const point *p, double sign, double *g)
{
    g[0] = sign*w.x;
    g[1] = sign*w.y;
    g[2] = sign*lw_v2_cross(p->r, w);
}

static void finish(lw_measure *m, double unit, const double *v)
{
    m->value *= unit;
    m->rate = 0;
    for (int i = 0; i < 6; i++) {
        m->g[i] *= unit;
        if (m->body[i/3] >= 0)
            m->rate += m->g[i]*v[3*m->body[i/3] + i%3];
        for (int j = 0; m->second && j < 6; j++)
            m->h[i][j] *= unit;
    }
}

static void begin(lw_measure *m, int a, int b, bool second)
{
    m->body[0] = a;
    m->body[1] = b;
    m->second = second;
    memset(m->g, 0, sizeof m->g);
    if (second)
        memset(m->h, 0, sizeof m->h);
}

void lw_measure_length(const lw_system *s, const int body[2], const lw_vec2 arm[2], const double *q,
                       const double *v, bool second, lw_measure *m)
{
    point a = point_of(body[0], arm[0], q, v), b = point_of(body[1], arm[1], q, v);
    lw_vec2 d = lw_v2_sub(b.p, a.p);
    double l = lw_v2_norm(d);
    /* ends at one point pull nowhere: no direction is better than another */
    lw_vec2 u = l > 0 ? lw_v2_scale(d, 1/l) : lw_v2(0, 0);
    begin(m, body[0], body[1], second);
    m->value = l;
    along(u, &a, -1, m->g);
    along(u, &b, 1, m->g + 3);
    if (second && l > 0) {
        double across[6];                    /* of the direction: l du = n (n . d'), n = i u */
        along(lw_v2_perp(u), &a, -1, across);
        along(lw_v2_perp(u), &b, 1, across + 3);
        for (int i = 0; i < 6; i++)
            for (int j = 0; j < 6; j++)
                m->h[i][j] = across[i]*across[j]/l;
        m->h[2][2] += lw_v2_dot(u, a.r);
        m->h[5][5] -= lw_v2_dot(u, b.r);
    }
    finish(m, s->unit, v);
}

void lw_measure_point(const lw_system *s, int body, lw_vec2 arm, int axis, const double *q, const double *v,
                      bool second, lw_measure *m)
{
    begin(m, body, -1, second);
    if (axis == 2) {
        m->value = body < 0 ? 0 : q[3*body + 2];
        m->g[2] = body < 0 ? 0 : 1;
        finish(m, 1, v);
        return;
    }
    point p = point_of(body, arm, q, v);
    lw_vec2 w = lw_v2(axis == 0, axis == 1);
    m->value = lw_v2_dot(w, p.p);
    if (body >= 0)
        along(w, &p, 1, m->g);
    if (second)
        m->h[2][2] = -lw_v2_dot(w, p.r);
    finish(m, s->unit, v);
    m->value += axis == 0 ? s->origin.x : s->origin.y;
}

/* u . (p1 - p0), u turning with body 0:  by phi0: n . d - u . i r0 ... (mbs/constraints/system_rows.c) */
static void measure_slide(const lw_system_joint *j, const double *q, const double *v, bool second, lw_measure *m)
{
    point a = point_of(j->body[0], j->arm[0], q, v), b = point_of(j->body[1], j->arm[1], q, v);
    lw_vec2 u = lw_v2_turn(j->along, lw_v2_polar(1, j->body[0] < 0 ? 0 : q[3*j->body[0] + 2]));
    lw_vec2 n = lw_v2_perp(u), d = lw_v2_sub(b.p, a.p);
    m->value = lw_v2_dot(u, d);
    along(u, &a, -1, m->g);
    along(u, &b, 1, m->g + 3);
    m->g[2] += lw_v2_dot(n, d);
    if (!second)
        return;
    double mixed[6];                         /* of n . d, n fixed */
    along(n, &a, -1, mixed);
    along(n, &b, 1, mixed + 3);
    for (int i = 0; i < 6; i++) {
        m->h[2][i] += mixed[i];
        m->h[i][2] += mixed[i];
    }
    m->h[2][2] += lw_v2_dot(u, a.r) - lw_v2_dot(u, d);
    m->h[5][5] -= lw_v2_dot(u, b.r);
}

void lw_measure_joint(const lw_system *s, int joint, const double *q, const double *v, bool second, lw_measure *m)
{
    const lw_system_joint *j = &s->joint[joint];
    begin(m, j->body[0], j->body[1], second);
    m->value = 0;
    if (j->kind == LW_JOINT_REVOLUTE) {
        double turn[2] = { j->body[0] < 0 ? 0 : q[3*j->body[0] + 2], j->body[1] < 0 ? 0 : q[3*j->body[1] + 2] };
        m->value = j->sign*(turn[1] - turn[0]);
        m->g[2] = -j->sign;
        m->g[5] = j->sign;
        finish(m, 1, v);
        return;
    }
    if (j->kind == LW_JOINT_SLIDER || j->kind == LW_JOINT_SLOT)
        measure_slide(j, q, v, second, m);
    finish(m, s->unit, v);
}
