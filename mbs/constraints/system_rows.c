/* mbs/constraints/system_rows.c - the rows of a system and their derivatives.
 *
 * With the rotated arms r_i and the joint's points p_i = x_i + r_i on its two links, d = p_1 - p_0 and u the slide
 * line's direction on link 0:
 *
 *     pin       d = 0
 *     slider    i u . d = 0,   phi_1 - phi_0 = 0
 *     slot      i u . d = 0
 *     fixed     d = 0,         phi_1 - phi_0 = 0
 *     gear      (m_1 - ratio m_0)/(1 + |ratio|) = 0,   m_i = phi_i - phi_c, or the displacement of a rack
 *     tie       (h_1 - ratio h_0)/(1 + |ratio|) = 0,   h_i the values of the tied and the first input
 *
 * The displacement of a slider is u . d.  The derivatives of v . d, for a v fixed to link 0 or to the plane, are
 *     by x_1: v,  by phi_1: v . i r_1,  by x_0: -v,  by phi_0: dv . d - v . i r_0.                       */
#include "mbs/constraints/system_internal.h"

#include <string.h>

void lw_system_place(const lw_system *s, const double *q, lw_body_frame *f)
{
    f[0].at = lw_v2(0.0, 0.0);
    f[0].dir = lw_v2(1.0, 0.0);
    f[0].turn = 0.0;
    for (int b = 0; b < s->n_body; b++) {
        f[b + 1].at = lw_v2(q[3*b], q[3*b + 1]);
        f[b + 1].turn = q[3*b + 2];
        f[b + 1].dir = lw_v2_polar(1.0, q[3*b + 2]);
    }
}

/* Destination of the derivatives of one row: that by coordinate i goes to to[i*step] or, where the bodies of the row
 * are given, that by coordinate i of body[k] to to[3*k + i]. */
typedef struct target { double *to; long step; const int *body; } target;

static inline void add(target t, int body, double x, double y, double turn)
{
    if (body < 0 || !t.to)
        return;
    double *p = t.to + 3*body*t.step;
    if (t.body) {
        p = t.to;
        for (const int *b = t.body; *b != body; b++)
            p += 3;
    }
    p[0] += x;
    p[t.step] += y;
    p[2*t.step] += turn;
}

/* The points of a joint on its two links. */
typedef struct contact { lw_vec2 r[2], d, u; } contact;

static inline contact touch(const lw_system_joint *j, const lw_body_frame *f)
{
    contact c;
    int b0 = j->body[0] + 1, b1 = j->body[1] + 1;
    c.r[0] = lw_v2_turn(j->arm[0], f[b0].dir);
    c.r[1] = lw_v2_turn(j->arm[1], f[b1].dir);
    c.d = lw_v2_sub(lw_v2_add(f[b1].at, c.r[1]), lw_v2_add(f[b0].at, c.r[0]));
    c.u = lw_v2_turn(j->along, f[b0].dir);
    return c;
}

/* Add factor times the derivatives of v . d; dv: derivative of v by the rotation of link 0. */
static inline void add_projection(const lw_system_joint *j, const contact *c, lw_vec2 v, lw_vec2 dv, double factor, target t)
{
    lw_vec2 w = lw_v2_scale(v, factor);
    add(t, j->body[1], w.x, w.y, lw_v2_cross(c->r[1], w));
    add(t, j->body[0], -w.x, -w.y, factor*lw_v2_dot(dv, c->d) - lw_v2_cross(c->r[0], w));
}

static inline double turn_between(const lw_system_joint *j, const lw_body_frame *f)
{
    return f[j->body[1] + 1].turn - f[j->body[0] + 1].turn;
}

static inline void add_turn(const lw_system_joint *j, double factor, target t)
{
    add(t, j->body[1], 0.0, 0.0, factor);
    add(t, j->body[0], 0.0, 0.0, -factor);
}

/* The displacement of a joint times `factor`. */
static double count(const lw_system_joint *j, const lw_body_frame *f, double factor, target t)
{
    if (lw_joint_turns(j->kind)) {
        add_turn(j, factor*j->sign, t);
        return factor*j->sign*turn_between(j, f);
    }
    if (!lw_joint_slides(j->kind))
        return 0.0;
    contact c = touch(j, f);
    if (t.to)
        add_projection(j, &c, c.u, lw_v2_perp(c.u), factor, t);
    return factor*lw_v2_dot(c.u, c.d);
}

double lw_system_count(const lw_system *s, const lw_body_frame *f, int j, double *row, long step)
{
    return count(&s->joint[j], f, 1.0, (target){ row, step, NULL });
}

double lw_system_count_block(const lw_system *s, const lw_body_frame *f, int j, double *row, const int *body)
{
    return count(&s->joint[j], f, 1.0, (target){ row, 1, body });
}

double lw_system_gear_factor(const lw_system_joint *j, int side)
{
    return (side == 1 ? 1.0 : -j->ratio)/(1.0 + fabs(j->ratio));
}

static double gear_row(const lw_system *s, const lw_system_joint *j, const lw_body_frame *f, target t)
{
    double left = 0.0;
    for (int side = 0; side < 2; side++) {
        double factor = lw_system_gear_factor(j, side);
        if (j->slider[side] >= 0) {
            left += count(&s->joint[j->slider[side]], f, factor*j->slider_sign[side], t);
            continue;
        }
        left += factor*(f[j->body[side] + 1].turn - f[j->carrier + 1].turn);
        add(t, j->body[side], 0.0, 0.0, factor);
        add(t, j->carrier, 0.0, 0.0, -factor);
    }
    return left;
}

static double tie_row(const lw_system *s, int i, const lw_body_frame *f, target t)
{
    double ratio = s->tie[i], scale = 1.0/(1.0 + fabs(ratio));
    return count(&s->joint[s->input_joint[s->n_input + i]], f, scale, t)
         + count(&s->joint[s->input_joint[0]], f, -ratio*scale, t);
}

/* The target of row r. */
static inline target row_target(double *jac, int r, long row_step, long column_step, lw_row_bodies *body)
{
    return (target){ jac ? jac + r*row_step : NULL, column_step, body ? body[r] : NULL };
}

static void fill(const lw_system *s, const lw_body_frame *f, double *phi, double *jac, long row_step, long column_step, lw_row_bodies *body)
{
    static const lw_vec2 none = { 0.0, 0.0 }, ex = { 1.0, 0.0 }, ey = { 0.0, 1.0 };
    for (int k = 0; k < s->n_joint; k++) {
        const lw_system_joint *j = &s->joint[k];
        int r = j->row;
        target t0 = row_target(jac, r, row_step, column_step, body);
        if (lw_joint_has_ratio(j->kind)) {
            double left = gear_row(s, j, f, t0);
            if (phi)
                phi[r] = left;
            continue;
        }
        if (lw_joint_equations(j->kind) == 0)
            continue;
        contact c = touch(j, f);
        bool point = lw_joint_holds_point(j->kind);
        bool turn = lw_joint_holds_rotation(j->kind);
        lw_vec2 across = lw_v2_perp(c.u);
        int next = r + (point ? 2 : 1);
        if (phi) {
            phi[r] = point ? c.d.x : lw_v2_dot(across, c.d);
            if (point)
                phi[r + 1] = c.d.y;
            if (turn)
                phi[next] = turn_between(j, f);
        }
        if (!jac)
            continue;
        if (point) {
            add_projection(j, &c, ex, none, 1.0, t0);
            add_projection(j, &c, ey, none, 1.0, row_target(jac, r + 1, row_step, column_step, body));
        } else
            add_projection(j, &c, across, lw_v2_scale(c.u, -1.0), 1.0, t0);
        if (turn)
            add_turn(j, 1.0, row_target(jac, next, row_step, column_step, body));
    }
    for (int i = 0, r = s->tie_row; i < s->n_tie; i++, r++) {
        double left = tie_row(s, i, f, row_target(jac, r, row_step, column_step, body));
        if (phi)
            phi[r] = left;
    }
}

void lw_system_fill(const lw_system *s, const lw_body_frame *f, double *phi, double *jac, long row_step, long column_step)
{
    fill(s, f, phi, jac, row_step, column_step, NULL);
}

void lw_system_fill_blocks(const lw_system *s, const lw_body_frame *f, double *phi, double *jac, lw_row_bodies *body)
{
    fill(s, f, phi, jac, LW_SYSTEM_ROW_SIZE, 1, body);
}

void lw_system_rows(const lw_system *s, const double *q, double *phi, double *jac)
{
    lw_body_frame f[LW_LINK_MAX];
    lw_system_place(s, q, f);
    if (jac)
        memset(jac, 0, (size_t)s->n_row*(size_t)s->n_q*sizeof *jac);
    lw_system_fill(s, f, phi, jac, s->n_q, 1);
}

double lw_system_measure(const lw_system *s, int j, const double *q, double *row)
{
    lw_system_joint joint = s->joint[j];
    lw_body_frame f[3] = { [0].dir = { 1.0, 0.0 } };
    double own[6] = { 0.0 };
    for (int end = 0; end < 2; end++) {
        const double *c = q + 3*joint.body[end];
        if (joint.body[end] < 0)
            continue;
        f[end + 1] = (lw_body_frame){ lw_v2(c[0], c[1]), lw_v2_polar(1.0, c[2]), c[2] };
        joint.body[end] = end;
    }
    double value = count(&joint, f, 1.0, (target){ row ? own : NULL, 1, NULL });
    if (row)
        memset(row, 0, (size_t)s->n_q*sizeof *row);
    for (int i = 0; row && i < 6; i++)
        if (joint.body[i/3] >= 0)
            row[3*s->joint[j].body[i/3] + i%3] += own[i];
    return value;
}

/* The whole turns contained in an input value. */
static double whole_count(const lw_system_joint *j, const lw_body_frame *f)
{
    return lw_joint_turns(j->kind) ? j->sign*turn_between(j, f) : 0.0;
}

void lw_system_turns(const lw_system *s, const int *turns, double *rows, double *inputs)
{
    lw_body_frame f[LW_LINK_MAX];
    f[0].turn = 0.0;
    memset(rows, 0, (size_t)s->n_row*sizeof *rows);
    for (int b = 0; b < s->n_body; b++)
        f[b + 1].turn = turns[b];
    for (int k = 0; k < s->n_joint; k++) {
        const lw_system_joint *j = &s->joint[k];
        if (lw_joint_holds_rotation(j->kind))
            rows[j->row + (lw_joint_holds_point(j->kind) ? 2 : 1)] = turn_between(j, f);
        if (lw_joint_has_ratio(j->kind))
            for (int side = 0; side < 2; side++)
                if (j->slider[side] < 0)
                    rows[j->row] += lw_system_gear_factor(j, side)
                                  * (f[j->body[side] + 1].turn - f[j->carrier + 1].turn);
    }
    for (int i = 0; i < s->n_input; i++)
        inputs[i] = whole_count(&s->joint[s->input_joint[i]], f);
    for (int i = 0; i < s->n_tie; i++)
        rows[s->tie_row + i] = (whole_count(&s->joint[s->input_joint[s->n_input + i]], f)
                                - s->tie[i]*whole_count(&s->joint[s->input_joint[0]], f))/(1.0 + fabs(s->tie[i]));
}
