/* mbs/constraints/system_series.c - Taylor series of the rows along a curve.
 *
 * The direction of a link, u = exp(i phi), has the series  k u_k = i (sum over m = 1 .. k of m phi_m u_{k-m})
 * (Griewank & Walther 2008, section 13.2); all rows are sums and products of such directions, positions and
 * rotations. */
#include "mbs/constraints/system.h"

#include <string.h>

#define N (LW_SYSTEM_ORDER_MAX + 1)

/* Series of one body: position and direction. */
typedef struct body_series { lw_vec2 at[N], dir[N]; double turn[N]; } body_series;

static void read_body(const lw_system *s, int body, int order, const double *q, body_series *out)
{
    memset(out, 0, sizeof *out);
    out->dir[0] = lw_v2(1.0, 0.0);
    if (body < 0)
        return;
    for (int k = 0; k <= order; k++) {
        const double *c = q + (long)k*s->n_q + 3*body;
        out->at[k] = lw_v2(c[0], c[1]);
        out->turn[k] = c[2];
    }
    out->dir[0] = lw_v2_polar(1.0, out->turn[0]);
    for (int k = 1; k <= order; k++) {
        lw_vec2 sum = { 0.0, 0.0 };
        for (int m = 1; m <= k; m++)
            sum = lw_v2_add(sum, lw_v2_scale(out->dir[k - m], m*out->turn[m]));
        out->dir[k] = lw_v2_scale(lw_v2_perp(sum), 1.0/k);
    }
}

/* The joint's two bodies, d = p_1 - p_0 and the direction of its slide line. */
typedef struct joint_series { body_series body[2]; lw_vec2 d[N], u[N]; } joint_series;

static void read_joint(const lw_system *s, const lw_system_joint *j, int order, const double *q, joint_series *out)
{
    const body_series *b = out->body;
    read_body(s, j->body[0], order, q, &out->body[0]);
    read_body(s, j->body[1], order, q, &out->body[1]);
    for (int k = 0; k <= order; k++) {
        lw_vec2 p0 = lw_v2_add(b[0].at[k], lw_v2_turn(j->arm[0], b[0].dir[k]));
        lw_vec2 p1 = lw_v2_add(b[1].at[k], lw_v2_turn(j->arm[1], b[1].dir[k]));
        out->d[k] = lw_v2_sub(p1, p0);
        out->u[k] = lw_v2_turn(j->along, b[0].dir[k]);
    }
}

/* Coefficient k of a . d */
static double product(const lw_vec2 *a, const lw_vec2 *d, int k)
{
    double sum = 0.0;
    for (int m = 0; m <= k; m++)
        sum += lw_v2_dot(a[m], d[k - m]);
    return sum;
}

static double across(const joint_series *c, int k)
{
    double sum = 0.0;
    for (int m = 0; m <= k; m++)
        sum += lw_v2_cross(c->u[m], c->d[k - m]);
    return sum;
}

void lw_system_measure_series(const lw_system *s, int j, int order, const double *q, double *out)
{
    const lw_system_joint *p = &s->joint[j];
    joint_series c;
    memset(out, 0, (size_t)(order + 1)*sizeof *out);
    if (!lw_joint_has_position(p->kind))
        return;
    read_joint(s, p, order, q, &c);
    for (int k = 0; k <= order; k++)
        out[k] = lw_joint_turns(p->kind) ? p->sign*(c.body[1].turn[k] - c.body[0].turn[k])
                                              : product(c.u, c.d, k);
}

static void gear_series(const lw_system *s, const lw_system_joint *j, int order, const double *q, double *phi)
{
    for (int side = 0; side < 2; side++) {
        double factor = lw_system_gear_factor(j, side), count[N];
        if (j->slider[side] >= 0) {
            lw_system_measure_series(s, j->slider[side], order, q, count);
            factor *= j->slider_sign[side];
        }
        for (int k = 0; k <= order; k++) {
            const double *c = q + (long)k*s->n_q;
            if (j->slider[side] < 0)
                count[k] = (j->body[side] < 0 ? 0.0 : c[3*j->body[side] + 2])
                         - (j->carrier < 0 ? 0.0 : c[3*j->carrier + 2]);
            phi[(long)k*s->n_row] += factor*count[k];
        }
    }
}

static void joint_rows(const lw_system *s, const lw_system_joint *j, int order, const double *q, double *phi)
{
    joint_series c;
    if (lw_joint_has_ratio(j->kind)) {
        gear_series(s, j, order, q, phi);
        return;
    }
    if (lw_joint_equations(j->kind) == 0)
        return;
    read_joint(s, j, order, q, &c);
    bool point = lw_joint_holds_point(j->kind);
    bool turn = lw_joint_holds_rotation(j->kind);
    for (int k = 0; k <= order; k++) {
        double *out = phi + (long)k*s->n_row;
        out[0] = point ? c.d[k].x : across(&c, k);
        if (point)
            out[1] = c.d[k].y;
        if (turn)
            out[point ? 2 : 1] = c.body[1].turn[k] - c.body[0].turn[k];
    }
}

static void tie_series(const lw_system *s, int i, int order, const double *q, double *phi)
{
    double tied[N], first[N], scale = 1.0/(1.0 + fabs(s->tie[i]));
    lw_system_measure_series(s, s->input_joint[s->n_input + i], order, q, tied);
    lw_system_measure_series(s, s->input_joint[0], order, q, first);
    for (int k = 0; k <= order; k++)
        phi[(long)k*s->n_row] = scale*(tied[k] - s->tie[i]*first[k]);
}

void lw_system_series(const lw_system *s, int order, const double *q, double *phi)
{
    memset(phi, 0, (size_t)(order + 1)*(size_t)s->n_row*sizeof *phi);
    for (int j = 0; j < s->n_joint; j++)
        joint_rows(s, &s->joint[j], order, q, phi + s->joint[j].row);
    for (int i = 0; i < s->n_tie; i++)
        tie_series(s, i, order, q, phi + s->tie_row + i);
}

void lw_system_point_series(const lw_system *s, int body, lw_vec2 arm, int order, const double *q, lw_vec2 *out)
{
    body_series b;
    read_body(s, body, order, q, &b);
    for (int k = 0; k <= order; k++)
        out[k] = lw_v2_scale(lw_v2_add(b.at[k], lw_v2_turn(arm, b.dir[k])), s->unit);
    out[0] = lw_v2_add(out[0], s->origin);
}
