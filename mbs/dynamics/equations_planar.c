/* mbs/dynamics/equations_planar.c - the equations of a planar model: rows and forces of its system, and the parts of
 * accelerations that velocities cause. */
#include "mbs/dynamics/equations.h"

#include <string.h>

/* ---- rows ---------------------------------------------------------------------------------------------- */

static void row_bodies(void *context, int row, int body[LW_SYSTEM_ROW_BODIES])
{
    lw_system_row_bodies(((const lw_planar *)context)->s, row, body);
}

static void measure_bodies(void *context, int joint, int body[LW_SYSTEM_ROW_BODIES])
{
    lw_system_joint_bodies(((const lw_planar *)context)->s, joint, body);
}

static void place(void *context, const double *q)
{
    const lw_planar *d = context;
    lw_system_place(d->s, q, d->frames);
}

static void rows(void *context, double *phi, double *jac, lw_row_bodies *body)
{
    const lw_planar *d = context;
    lw_system_fill_blocks(d->s, d->frames, phi, jac, body);
}

static double measure(void *context, int joint, double *row, const int *body)
{
    const lw_planar *d = context;
    return lw_system_count_block(d->s, d->frames, joint, row, body);
}

/* The two points of a joint and their relative motion, with the part of the acceleration that velocities cause. */
typedef struct joint_motion { lw_vec2 d, dd, ddd, u, du, ddu; } joint_motion;

static joint_motion joint_motion_of(const lw_planar *d, const lw_system_joint *j, const double *v)
{
    joint_motion z;
    lw_vec2 p[2], dp[2], ddp[2];
    double w[2];
    for (int end = 0; end < 2; end++) {
        int b = j->body[end];
        lw_vec2 r = lw_v2_turn(j->arm[end], d->frames[b + 1].dir);
        w[end] = b < 0 ? 0 : v[3*b + 2];
        p[end] = lw_v2_add(d->frames[b + 1].at, r);
        dp[end] = lw_v2_add(b < 0 ? lw_v2(0, 0) : lw_v2(v[3*b], v[3*b + 1]), lw_v2_scale(lw_v2_perp(r), w[end]));
        ddp[end] = lw_v2_scale(r, -w[end]*w[end]);
    }
    z.d = lw_v2_sub(p[1], p[0]);
    z.dd = lw_v2_sub(dp[1], dp[0]);
    z.ddd = lw_v2_sub(ddp[1], ddp[0]);
    z.u = lw_v2_turn(j->along, d->frames[j->body[0] + 1].dir);
    z.du = lw_v2_scale(lw_v2_perp(z.u), w[0]);
    z.ddu = lw_v2_scale(z.u, -w[0]*w[0]);
    return z;
}

/* Second rate of the measure of a joint, without J a. */
static double count_bias(const lw_planar *d, int joint, const double *v)
{
    const lw_system_joint *j = &d->s->joint[joint];
    if (!lw_joint_slides(j->kind))
        return 0;
    joint_motion z = joint_motion_of(d, j, v);
    return lw_v2_dot(z.ddu, z.d) + 2*lw_v2_dot(z.du, z.dd) + lw_v2_dot(z.u, z.ddd);
}

static void joint_bias(const lw_planar *d, const lw_system_joint *j, const double *v, double *out)
{
    double *to = out + j->row;
    joint_motion z;
    if (lw_joint_holds_point(j->kind)) {
        z = joint_motion_of(d, j, v);
        to[0] = -z.ddd.x;
        to[1] = -z.ddd.y;
    } else if (lw_joint_slides(j->kind)) {
        z = joint_motion_of(d, j, v);
        to[0] = -lw_v2_cross(z.ddu, z.d) - 2*lw_v2_cross(z.du, z.dd) - lw_v2_cross(z.u, z.ddd);
    }
    if (lw_joint_has_ratio(j->kind))
        for (int side = 0; side < 2; side++)
            if (j->slider[side] >= 0)
                to[0] -= lw_system_gear_factor(j, side)*j->slider_sign[side]*count_bias(d, j->slider[side], v);
}

static void bias(void *context, const double *v, double *out)
{
    const lw_planar *d = context;
    for (int j = 0; j < d->s->n_joint; j++)
        joint_bias(d, &d->s->joint[j], v, out);
}

static double measure_bias(void *context, int joint, const double *v) { return count_bias(context, joint, v); }

/* ---- second derivatives of rows -------------------------------------------------------------------------- */

static int add_bend(lw_bend *out, int n, int body, int axis, int other, int other_axis, double h)
{
    if (body >= 0 && other >= 0)
        out[n++] = (lw_bend){ 3*body + axis, 3*other + other_axis, h };
    return n;
}

/* Second derivatives of row r, w . d with w fixed or carried by link 0
 * (mbs/constraints/system_rows.c).  Rows of turns have none. */
static int bends(void *context, int r, lw_bend *out)
{
    const lw_planar *d = context;
    const lw_system_joint *j = &d->s->joint[d->s->row[r].joint];
    bool point = lw_joint_holds_point(j->kind);
    int b0 = j->body[0], b1 = j->body[1], side = r - j->row, n = 0;
    if (side >= (point ? 2 : 1))
        return 0;
    lw_vec2 r0 = lw_v2_turn(j->arm[0], d->frames[b0 + 1].dir), r1 = lw_v2_turn(j->arm[1], d->frames[b1 + 1].dir);
    if (point) {
        n = add_bend(out, n, b0, 2, b0, 2, side ? r0.y : r0.x);
        return add_bend(out, n, b1, 2, b1, 2, side ? -r1.y : -r1.x);
    }
    lw_vec2 w = lw_v2_perp(lw_v2_turn(j->along, d->frames[b0 + 1].dir)), dw = lw_v2_perp(w);
    lw_vec2 apart = lw_v2_sub(lw_v2_add(d->frames[b1 + 1].at, r1), lw_v2_add(d->frames[b0 + 1].at, r0));
    n = add_bend(out, n, b0, 2, b0, 2, -lw_v2_dot(w, r0) - lw_v2_dot(w, apart));
    n = add_bend(out, n, b1, 2, b1, 2, -lw_v2_dot(w, r1));
    n = add_bend(out, n, b0, 2, b1, 2, lw_v2_dot(w, r1));
    n = add_bend(out, n, b0, 2, b1, 0, dw.x);
    n = add_bend(out, n, b0, 2, b1, 1, dw.y);
    n = add_bend(out, n, b0, 2, b0, 0, -dw.x);
    return add_bend(out, n, b0, 2, b0, 1, -dw.y);
}

/* ---- forces and energies ------------------------------------------------------------------------------------ */

static void forces(void *context, double t, const double *q, const double *v, double *force, double *power)
{
    lw_forces_apply(((const lw_planar *)context)->f, t, q, v, force, NULL, NULL, power);
}

static void derivatives(void *context, double t, const double *q, const double *v, double *force,
                        const lw_force_sink *sink)
{
    lw_forces_derivatives(((const lw_planar *)context)->f, t, q, v, force, sink);
}

static void pattern(void *context, const lw_force_sink *sink) { lw_forces_pattern(((const lw_planar *)context)->f, sink); }

static void place_states(void *context, const double *z)
{
    const lw_forces *f = ((const lw_planar *)context)->f;
    for (int i = 0; i < f->model->n_state; i++)
        f->z[i] = z[i];
}

static void state_rates(void *context, double t, const double *q, const double *v, double *rate)
{
    lw_forces_state_rates(((const lw_planar *)context)->f, t, q, v, rate);
}

static void state_start(void *context, double t, const double *q, const double *v, double *z)
{
    lw_forces_state_start(((const lw_planar *)context)->f, t, q, v, z);
}

static double state_scale(void *context, int i) { return ((const lw_planar *)context)->f->model->state[i].scale; }

static double kinetic(void *context, const double *v) { return lw_forces_kinetic(((const lw_planar *)context)->f, v); }
static double potential(void *context, const double *q) { return lw_forces_potential(((const lw_planar *)context)->f, q); }

/* ---- motion ------------------------------------------------------------------------------------------------- */

static void move(void *context, double *q, const double *by)
{
    int n = ((const lw_planar *)context)->s->n_q;
    for (int i = 0; i < n; i++)
        q[i] += by[i];
}

static void rates(void *context, const double *q, const double *v, double *dq)
{
    (void)q;
    memcpy(dq, v, (size_t)((const lw_planar *)context)->s->n_q*sizeof *dq);
}

lw_equations lw_planar_equations(lw_planar *p)
{
    return (lw_equations){ .n_q = p->s->n_q, .n_v = p->s->n_q, .n_body = p->s->n_body, .n_row = p->s->n_row,
                           .n_z = p->f->model->n_state, .place_states = place_states, .state_rates = state_rates,
                           .state_start = state_start, .state_scale = state_scale,
                           .mass = p->f->mass, .context = p, .row_bodies = row_bodies, .measure_bodies = measure_bodies,
                           .place = place, .rows = rows, .measure = measure, .bias = bias, .measure_bias = measure_bias,
                           .bends = bends, .forces = forces, .derivatives = derivatives, .pattern = pattern,
                           .kinetic = kinetic, .potential = potential, .move = move, .rates = rates };
}
