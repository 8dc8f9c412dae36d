/* mbs/equations/equations_planar.c - the equations of a planar model: rows and forces of its system, and the parts of
 * accelerations that velocities cause. */
#include "mbs/equations/equations_planar.h"

#include <string.h>
#include "base/real.h"
#include "mbs/equations/timed.h"

/* ---- rows ---------------------------------------------------------------------------------------------- */

static void row_blocks(void *context, int row, int *body)
{
    lw_system_row_bodies(((const lw_planar *)context)->s, row, body);
}

static void measure_blocks(void *context, int joint, int *body)
{
    lw_system_joint_bodies(((const lw_planar *)context)->s, joint, body);
}

static void place(void *context, const double *q)
{
    const lw_planar *d = context;
    lw_system_place(d->s, q, d->frames);
    if (d->f->superelements.n)
        memcpy(d->f->superelements.placed, q, (size_t)d->s->n_q*sizeof *q);
}

static void rows(void *context, double *phi, double *jac, int *block)
{
    const lw_planar *d = context;
    lw_system_fill_blocks(d->s, d->frames, phi, jac, (lw_row_bodies *)block);
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
    for (int i = 0; i < d->s->n_tie; i++) {
        const int *joint = d->s->input_joint;
        double ratio = d->s->tie[i];
        out[d->s->tie_row + i] -= (count_bias(d, joint[d->s->n_input + i], v) - ratio*count_bias(d, joint[0], v))/(1 + fabs(ratio));
    }
}

static double measure_bias(void *context, int joint, const double *v) { return count_bias(context, joint, v); }

/* ---- second derivatives of rows -------------------------------------------------------------------------- */

static int add_bend(lw_bend *out, int n, int body, int axis, int other, int other_axis, double h)
{
    int a = 3*body + axis, b = 3*other + other_axis;
    if (body >= 0 && other >= 0)
        out[n++] = (lw_bend){ a, b, h };
    if (body >= 0 && other >= 0 && a != b)
        out[n++] = (lw_bend){ b, a, h };
    return n;
}

/* w . d with w carried by link 0, in its direction now. */
static int line_bends(const lw_planar *d, const lw_system_joint *j, lw_vec2 w, lw_bend *out)
{
    int b0 = j->body[0], b1 = j->body[1], n = 0;
    lw_vec2 r0 = lw_v2_turn(j->arm[0], d->frames[b0 + 1].dir), r1 = lw_v2_turn(j->arm[1], d->frames[b1 + 1].dir), dw = lw_v2_perp(w);
    lw_vec2 apart = lw_v2_sub(lw_v2_add(d->frames[b1 + 1].at, r1), lw_v2_add(d->frames[b0 + 1].at, r0));
    n = add_bend(out, n, b0, 2, b0, 2, -lw_v2_dot(w, r0) - lw_v2_dot(w, apart));
    n = add_bend(out, n, b1, 2, b1, 2, -lw_v2_dot(w, r1));
    n = add_bend(out, n, b0, 2, b1, 2, lw_v2_dot(w, r1));
    n = add_bend(out, n, b0, 2, b1, 0, dw.x);
    n = add_bend(out, n, b0, 2, b1, 1, dw.y);
    n = add_bend(out, n, b0, 2, b0, 0, -dw.x);
    return add_bend(out, n, b0, 2, b0, 1, -dw.y);
}

/* Of the measure of a joint times a factor; turns have none. */
static int count_bends(const lw_planar *d, int joint, double by, lw_bend *out)
{
    const lw_system_joint *j = &d->s->joint[joint];
    if (!lw_joint_slides(j->kind))
        return 0;
    return line_bends(d, j, lw_v2_scale(lw_v2_turn(j->along, d->frames[j->body[0] + 1].dir), by), out);
}

static int measure_bends(void *context, int joint, lw_bend *out) { return count_bends(context, joint, 1, out); }

/* Row r (mbs/constraints/system_rows.c): w . d with w fixed or carried by link 0, or a sum of measures. */
static int bends(void *context, int r, lw_bend *out)
{
    const lw_planar *d = context;
    int n = 0;
    if (d->s->n_tie && r >= d->s->tie_row) {
        double ratio = d->s->tie[r - d->s->tie_row], by = 1/(1 + fabs(ratio));
        n = count_bends(d, d->s->input_joint[d->s->n_input + r - d->s->tie_row], by, out);
        return n + count_bends(d, d->s->input_joint[0], -ratio*by, out + n);
    }
    const lw_system_joint *j = &d->s->joint[d->s->row[r].joint];
    for (int side = 0; side < 2 && lw_joint_has_ratio(j->kind); side++)
        if (j->slider[side] >= 0)
            n += count_bends(d, j->slider[side], lw_system_gear_factor(j, side)*j->slider_sign[side], out + n);
    if (lw_joint_has_ratio(j->kind))
        return n;
    bool point = lw_joint_holds_point(j->kind);
    int b0 = j->body[0], b1 = j->body[1], side = r - j->row;
    if (side >= (point ? 2 : 1))
        return 0;
    if (point) {
        lw_vec2 r0 = lw_v2_turn(j->arm[0], d->frames[b0 + 1].dir), r1 = lw_v2_turn(j->arm[1], d->frames[b1 + 1].dir);
        n = add_bend(out, n, b0, 2, b0, 2, side ? r0.y : r0.x);
        return add_bend(out, n, b1, 2, b1, 2, side ? -r1.y : -r1.x);
    }
    return line_bends(d, j, lw_v2_perp(lw_v2_turn(j->along, d->frames[b0 + 1].dir)), out);
}

/* ---- forces and energies ------------------------------------------------------------------------------------ */

static void forces(void *context, double t, const double *q, const double *v, double *force, double *power)
{
    lw_forces_apply(((const lw_planar *)context)->f, t, q, v, force, NULL, NULL, power);
}

static void derivatives(void *context, double t, const double *q, const double *v, double *force, const lw_force_sink *sink)
{
    lw_forces_derivatives(((const lw_planar *)context)->f, t, q, v, force, sink);
}

static void pattern(void *context, const lw_force_sink *sink) { lw_forces_pattern(((const lw_planar *)context)->f, sink); }

static void place_states(void *context, const double *z)
{
    const lw_forces *f = ((const lw_planar *)context)->f;
    for (int i = 0; i < f->model->states.n_state; i++)
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

static void foresee(void *context, const double *q, const double *by) { lw_forces_foresee(((const lw_planar *)context)->f, q, by); }
static double state_scale(void *context, int i) { return ((const lw_planar *)context)->f->model->states.state[i].scale; }

static double kinetic(void *context, const double *v)
{
    const lw_forces *f = ((const lw_planar *)context)->f;
    return lw_forces_kinetic(f, v) + lw_superelements_kinetic(&f->superelements, v);
}

static double potential(void *context, const double *q) { return lw_forces_potential(((const lw_planar *)context)->f, q); }

/* ---- momentum ------------------------------------------------------------------------------------------------ */

/* Angular momentum about the only pin to ground, or linear momentum along the only slider there [SI]. */
static double about_ground(const lw_planar *d, const double *q, const double *v)
{
    for (int j = 0; j < d->s->n_joint; j++) {
        const lw_system_joint *p = &d->s->joint[j];
        int ground = p->body[0] < 0 ? 0 : 1;
        if (p->body[ground] >= 0)
            continue;
        double sum = 0;
        for (int b = 0; b < d->s->n_body; b++) {
            lw_vec2 at = lw_v2_sub(lw_v2(q[3*b], q[3*b + 1]), p->arm[ground]), rate = lw_v2(v[3*b], v[3*b + 1]);
            sum += lw_joint_turns(p->kind)
                 ? d->f->mass[3*b]*lw_v2_cross(at, rate) + d->f->mass[3*b + 2]*v[3*b + 2]
                 : d->f->mass[3*b]*lw_v2_dot(p->along, rate)/d->s->unit;
        }
        return sum;
    }
    return 0;
}

static double momentum(void *context, const double *q, const double *v, double *size)
{
    const lw_planar *d = context;
    *size = 0;
    for (int i = 0; i < d->s->n_q; i++)
        *size += d->f->mass[i]*fabs(v[i]);
    return about_ground(d, q, v);
}

/* Is one free joint all that ties the linkage to the ground? */
static bool keeps_momentum(const lw_planar *d)
{
    const lw_model *m = d->f->model;
    int tied = -1;
    if (m->n_super)                              /* about_ground counts the masses of nodes */
        return false;
    for (int j = 0; j < d->s->n_joint; j++)
        if (d->s->joint[j].body[0] < 0 || d->s->joint[j].body[1] < 0) {
            if (tied >= 0)
                return false;
            tied = j;
        }
    if (tied < 0 || !lw_joint_can_drive(d->s->joint[tied].kind))
        return false;
    const lw_joint_stop *p = &m->stop[tied];
    bool loaded = m->gravity.x != 0 || m->gravity.y != 0 || m->n_force || d->f->caller.apply ||
                  m->friction[tied].coefficient > 0 || p->has_least || p->has_greatest;
    for (int i = 0; i < m->n_spring; i++)
        loaded = loaded || m->spring[i].link[0] == m->linkage.ground || m->spring[i].link[1] == m->linkage.ground;
    for (int i = 0; i < m->n_joint_spring; i++)
        loaded = loaded || m->joint_spring[i].joint == tied;
    for (int i = 0; i < m->n_motor; i++)
        loaded = loaded || m->motor[i].joint == tied;
    for (int i = 0; i < d->s->n_input; i++)
        loaded = loaded || (d->s->input_joint[i] == tied && (m->motion[i] || d->hold_inputs));
    return !loaded;
}

/* ---- masses of elements ------------------------------------------------------------------------------------- */

/* The terms of an element's consistent mass besides its lumps. */
static void mass_besides_lumps(const lw_planar *d, const double *q, int beam, int at[6], double out[6][6])
{
    const lw_beam *b = &d->f->model->beam[beam];
    double h = b->length, k = 12*b->stiffness[2]/(h*h*b->stiffness[1]) - 1, turn = 0;
    for (int end = 0; end < 2; end++) {
        int body = d->s->body[b->link[end]];
        turn += 0.5*q[3*body + 2];
        for (int i = 0; i < 3; i++)
            at[3*end + i] = 3*body + i;
    }
    lw_beam_mass(b->mass, h, k, b->gyration, b->direction + turn, out);
    for (int i = 0; i < 6; i++) {
        out[i][i] -= 0.5*b->mass*(i%3 == 2 ? b->gyration : 1);
        for (int j = 0; j < 6; j++)
            out[i][j] *= (i%3 == 2 ? 1 : d->s->unit)*(j%3 == 2 ? 1 : d->s->unit);
    }
}

static void more_mass(void *context, const double *q, const lw_force_sink *sink)
{
    const lw_planar *d = context;
    int at[6];
    double m[6][6];
    lw_superelements_mass(&d->f->superelements, q, sink);
    for (int b = 0; b < d->f->model->n_beam; b++) {
        if (!d->f->model->beam[b].consistent)
            continue;
        mass_besides_lumps(d, q, b, at, m);
        for (int i = 0; i < 36; i++)
            sink->add(sink->context, at[i/6], at[i%6], m[i/6][i%6], 0);
    }
}

static void more_inertia(void *context, const double *q, const double *v, const double *a, double *out)
{
    lw_superelements_inertia(&((const lw_planar *)context)->f->superelements, q, v, a, out);
}

/* ---- dampers, kinks, names ----------------------------------------------------------------------------------- */

/* Dampers between points, then those at joints, then motors. */
static double damper(void *context, int k, const double *q, const double *v, double *g)
{
    const lw_planar *d = context;
    const lw_model *m = d->f->model;
    lw_measure at;
    double c;
    if (k < m->n_spring) {
        int body[2] = { d->s->body[m->spring[k].link[0]], d->s->body[m->spring[k].link[1]] };
        lw_measure_length(d->s, body, d->f->spring_arm[k], q, v, false, &at);
        c = m->spring[k].damping;
    } else if (k < m->n_spring + m->n_joint_spring) {
        lw_measure_joint(d->s, m->joint_spring[k - m->n_spring].joint, q, v, false, &at);
        c = m->joint_spring[k - m->n_spring].damping;
    } else {
        const lw_motor *p = &m->motor[k - m->n_spring - m->n_joint_spring];
        lw_measure_joint(d->s, p->joint, q, v, false, &at);
        c = p->stall/p->free_speed;
    }
    for (int i = 0; i < 6; i++)
        if (at.body[i/3] >= 0)
            g[3*at.body[i/3] + i%3] += at.g[i];
    return c;
}

static void expressions(void *context, lw_expression_sink *see, void *of)
{
    lw_model_expressions(((const lw_planar *)context)->f->model, see, of);
}

static void values(void *context, double t, const double *q, const double *v, double *force, lw_expression_sink_at *see, void *of)
{
    lw_forces_values(((const lw_planar *)context)->f, t, q, v, force, see, of);
}

static void switches(void *context, double t, const double *q, const double *v, double *force, double *side)
{
    const lw_planar *d = context;
    lw_forces_stop_sides(d->f, q, v, side);
    if (d->n_kink + d->n_jump > 0) {
        double *kink = side + 2*d->f->n_stop;
        lw_timed_sides(values, context, t, q, v, force, kink, kink + d->n_kink);
    }
}

static const char *name(void *context, lw_named what, int i)
{
    const lw_planar *d = context;
    const lw_assembly *k = &d->f->model->linkage;
    switch (what) {
    case LW_NAMED_BLOCK:   return k->link_name[d->s->link[i]];
    case LW_NAMED_ROW:     return k->joint[d->s->row[i].joint].name;
    case LW_NAMED_MEASURE: return k->joint[i].name;
    case LW_NAMED_INPUT:   return k->joint[d->s->input_joint[i]].name;
    case LW_NAMED_STATE:   return d->f->model->states.state[i].name;
    }
    return "";
}

static double measure_unit(void *context, int joint) { return lw_system_joint_unit(((const lw_planar *)context)->s, joint); }

static lw_status prescribed(void *context, int input, double t, double out[3])
{
    const lw_planar *d = context;
    out[0] = out[1] = out[2] = 0;            /* an input that only holds its speed while velocities are found */
    return d->f->model->motion[input] ? lw_input_motion(d->f->model, d->s, input, t, out) : LW_OK;
}

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

bool lw_planar_exact(const lw_planar *p)
{
    bool gear = p->s->n_tie > 0;
    for (int j = 0; j < p->s->n_joint; j++)
        gear = gear || lw_joint_has_ratio(p->s->joint[j].kind);
    return !gear && lw_forces_caller_exact(p->f);
}

static bool has_expressions(const lw_model *m)
{
    bool any = m->n_force + m->n_spring + m->n_joint_spring + m->states.n_state > 0;
    for (int i = 0; i < m->linkage.n_input; i++)
        any = any || m->motion[i];
    return any;
}

lw_equations lw_planar_equations(lw_planar *p)
{
    _Static_assert(LW_ROW_SIZE == LW_SYSTEM_ROW_SIZE, "rows of the layer are those of planar systems");
    const lw_model *m = p->f->model;
    bool consistent = false;
    for (int i = 0; i < m->n_beam; i++)
        consistent = consistent || m->beam[i].consistent;
    const lw_timed shown = { .expressions = expressions, .context = p };
    p->n_kink = lw_timed_breaks(&shown, false);
    p->n_jump = lw_timed_breaks(&shown, true);
    return (lw_equations){ .n_q = p->s->n_q, .n_v = p->s->n_q, .n_block = p->s->n_body, .n_row = p->s->n_row,
                           .n_slot = LW_ROW_BLOCKS, .bend_most = 24,         /* of a gear between two sliders */
                           .n_z = m->states.n_state, .z = p->f->z, .n_damper = m->n_spring + m->n_joint_spring + m->n_motor,
                           .mass = p->f->mass, .weight = p->f->weight, .unit = p->s->unit,
                           .conservative = p->f->conservative, .exact = lw_planar_exact(p), .context = p, .name = name,
                           .row_blocks = row_blocks, .measure_blocks = measure_blocks, .place = place, .rows = rows,
                           .measure = measure, .measure_unit = measure_unit, .bias = bias, .measure_bias = measure_bias, .measure_bends = measure_bends,
                           .bends = bends, .motion = prescribed, .forces = forces, .derivatives = derivatives,
                           .pattern = pattern, .foresee = m->n_beam ? foresee : NULL,
                           .more_mass = consistent || m->n_super ? more_mass : NULL,
                           .more_inertia = m->n_super && !consistent ? more_inertia : NULL, .damper = damper,
                           .expressions = has_expressions(m) ? expressions : NULL,
                           .n_switch = 2*p->f->n_stop + p->n_kink + p->n_jump, .n_kink = p->n_kink, .n_jump = p->n_jump, .switches = switches,
                           .values = values, .place_states = place_states,
                           .state_rates = state_rates, .state_start = state_start, .state_scale = state_scale,
                           .kinetic = kinetic, .potential = potential, .momentum = keeps_momentum(p) ? momentum : NULL,
                           .move = move, .rates = rates };
}
