/* mbs/space/space_forces.c - loads of a spatial model. */
#include "mbs/space/space_forces.h"

#include <stdlib.h>
#include <string.h>

/* Is the stop an elastic one? */
static bool elastic_stop(const lw_joint_stop *p) { return (p->has_least || p->has_greatest) && p->stiffness > 0; }

lw_status lw_space_forces_make(const lw_space *s, lw_space_forces *f, lw_error *e)
{
    const lw_spatial *m = s->model;
    size_t springs = (size_t)m->n_spring, forces = (size_t)m->n_force, joints = (size_t)m->n_joint;
    *f = (lw_space_forces){ .s = s, .conservative = m->n_force == 0 && m->n_motor == 0 };
    size_t bytes = springs*sizeof *f->spring_end + forces*sizeof *f->force_at + joints*sizeof *f->turn + 1;
    char *at = f->memory = calloc(1, bytes);
    if (!at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    f->spring_end = (lw_space_point (*)[2])(void *)at, at += springs*sizeof *f->spring_end;
    f->force_at = (lw_space_point *)(void *)at, at += forces*sizeof *f->force_at;
    f->turn = (double *)(void *)at;
    for (int i = 0; i < m->n_spring; i++) {
        for (int k = 0; k < 2; k++)
            f->spring_end[i][k] = lw_space_point_of(s, m->spring[i].link[k], m->spring[i].at[k]);
        f->conservative = f->conservative && m->spring[i].damping == 0 && !m->spring[i].law;
    }
    for (int i = 0; i < m->n_joint_spring; i++)
        f->conservative = f->conservative && m->joint_spring[i].damping == 0 && !m->joint_spring[i].law;
    for (int i = 0; i < m->n_joint; i++)
        f->conservative = f->conservative && !(elastic_stop(&m->joint[i].stop) && m->joint[i].stop.damping > 0);
    for (int i = 0; i < m->n_force; i++)
        f->force_at[i] = lw_space_point_of(s, m->force[i].link, m->force[i].at);
    return LW_OK;
}

void lw_space_forces_free(lw_space_forces *f)
{
    free(f->memory);
    *f = (lw_space_forces){ 0 };
}

void lw_space_forces_accept(lw_space_forces *f, const lw_space_frame *frame)
{
    for (int j = 0; j < f->s->n_joint; j++)
        if (lw_spatial_kind_of(f->s->joint[j].kind)->turns)
            f->turn[j] = lw_space_measure(f->s, frame, (lw_spatial_measure){ LW_OF_TURN, j }, f->turn[j], NULL);
}

/* ---- loads ------------------------------------------------------------------------------------------------ */

static void push(const lw_space *s, const lw_space_frame *frame, lw_space_point p, lw_vec3 load, double *force)
{
    if (p.body < 0)
        return;
    double *to = force + 6*p.body;
    lw_vec3 moment = lw_v3_cross(p.arm, lw_m3_unapply(&frame[p.body + 1].turn, load));
    to[0] += s->unit*load.x, to[1] += s->unit*load.y, to[2] += s->unit*load.z, to[3] += moment.x, to[4] += moment.y, to[5] += moment.z;
}

/* A force along a measure, in its SI unit. */
static void push_measure(const lw_space_forces *f, const lw_space_frame *frame, lw_spatial_measure of, double load,
                         double *force)
{
    double jac[LW_SPACE_ROW], scale = lw_space_scale(f->s, of);
    int body[2];
    lw_space_measure(f->s, frame, of, 0, jac);
    lw_space_bodies(f->s, &(lw_space_extra){ .measure = of }, body);
    for (int k = 0; k < 2; k++)
        for (int i = 0; body[k] >= 0 && i < 6; i++)
            force[6*body[k] + i] += scale*load*jac[6*k + i];
}

static void measured(const lw_space_forces *f, const lw_space_frame *frame, lw_spatial_measure of, const double *v,
                     double *value,
                     double *rate)
{
    lw_space_measured(f->s, frame, of, of.of == LW_OF_TURN ? f->turn[of.index] : 0, v, value, rate);
}

/* Value of an expression; length and rate are those of a law. */
static double value_of(const lw_space_forces *f, const lw_expression *x, double t, const lw_space_frame *frame,
                       const double *v,
                       double length, double rate)
{
    const int *which;
    double at[LW_EXPRESSION_VARIABLE_MAX];
    int n = lw_expression_variables(x, &which);
    for (int i = 0; i < n; i++) {
        lw_spatial_variable kind = LW_VARIABLE_OF(which[i]);
        int index = LW_VARIABLE_INDEX(which[i]);
        double value = 0, speed = 0;
        lw_vec3 p = { 0, 0, 0 };
        if (kind >= LW_VARIABLE_TURN && kind <= LW_VARIABLE_SLIDE_RATE) {
            bool turn = kind == LW_VARIABLE_TURN || kind == LW_VARIABLE_TURN_RATE;
            measured(f, frame, (lw_spatial_measure){ turn ? LW_OF_TURN : LW_OF_SLIDE, index }, v, &value, &speed);
        } else if (kind >= LW_VARIABLE_X && kind <= LW_VARIABLE_Z)
            p = lw_space_point_at(frame, f->s->tracer[index]);
        else if (kind >= LW_VARIABLE_VX && kind <= LW_VARIABLE_VZ)
            p = lw_space_point_velocity(f->s, frame, f->s->tracer[index], v);
        switch (kind) {
        case LW_VARIABLE_T: at[i] = t; break;
        case LW_VARIABLE_TURN: case LW_VARIABLE_SLIDE: at[i] = value; break;
        case LW_VARIABLE_TURN_RATE: case LW_VARIABLE_SLIDE_RATE: at[i] = speed; break;
        case LW_VARIABLE_X: case LW_VARIABLE_VX: at[i] = p.x; break;
        case LW_VARIABLE_Y: case LW_VARIABLE_VY: at[i] = p.y; break;
        case LW_VARIABLE_Z: case LW_VARIABLE_VZ: at[i] = p.z; break;
        case LW_VARIABLE_LENGTH: at[i] = length; break;
        case LW_VARIABLE_RATE: at[i] = rate; break;
        }
    }
    return lw_expression_value(x, at);
}

/* Length of a spring, the unit vector along it and the rate. */
static double spring_line(const lw_space_forces *f, int i, const lw_space_frame *frame, const double *v,
                          lw_vec3 *along, double *rate)
{
    const lw_space_point *end = f->spring_end[i];
    lw_vec3 d = lw_v3_sub(lw_space_point_at(frame, end[1]), lw_space_point_at(frame, end[0]));
    double length = lw_v3_norm(d);
    *along = length > 0 ? lw_v3_scale(d, 1/length) : d;
    if (rate)
        *rate = lw_v3_dot(*along, lw_v3_sub(lw_space_point_velocity(f->s, frame, end[1], v),
                                            lw_space_point_velocity(f->s, frame, end[0], v)));
    return length;
}

/* How far a measure lies beyond its stop. */
static double beyond(const lw_joint_stop *p, double value)
{
    return p->has_least && value < p->least ? value - p->least : p->has_greatest && value > p->greatest ?
        value - p->greatest : 0;
}

static lw_spatial_measure stop_measure(const lw_space *s, int joint)
{
    return (lw_spatial_measure){ lw_spatial_kind_of(s->joint[joint].kind)->turns ? LW_OF_TURN : LW_OF_SLIDE, joint };
}

void lw_space_forces_unit(const lw_space_forces *f, const lw_space_frame *frame, int spring, double *force)
{
    const lw_spatial *m = f->s->model;
    lw_vec3 along;
    if (spring >= m->n_spring) {
        push_measure(f, frame, m->joint_spring[spring - m->n_spring].measure, 1, force);
        return;
    }
    spring_line(f, spring, frame, NULL, &along, NULL);
    push(f->s, frame, f->spring_end[spring][0], along, force);
    push(f->s, frame, f->spring_end[spring][1], lw_v3_scale(along, -1), force);
}

void lw_space_forces_apply(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v,
                           double *force,
                           double *power)
{
    const lw_space *s = f->s;
    const lw_spatial *m = s->model;
    double work = 0, value, rate;
    for (int b = 0; b < s->n_body; b++) {
        const double *mass = s->mass + 6*b, *w = v + 6*b + 3;
        double *to = force + 6*b;
        to[0] = mass[0]*m->gravity.x/s->unit, to[1] = mass[1]*m->gravity.y/s->unit, to[2] = mass[2]*m->gravity.z/s->unit;
        to[3] = (mass[4] - mass[5])*w[1]*w[2];
        to[4] = (mass[5] - mass[3])*w[2]*w[0];
        to[5] = (mass[3] - mass[4])*w[0]*w[1];
    }
    for (int i = 0; i < m->n_spring; i++) {
        const lw_spatial_spring *p = &m->spring[i];
        lw_vec3 along;
        double length = spring_line(f, i, frame, v, &along, &rate);
        double damp = p->law ? value_of(f, p->law, t, frame, v, length, rate) : p->damping*rate;
        double pull = p->law ? damp : p->stiffness*(length - p->free) + damp;
        push(s, frame, f->spring_end[i][0], lw_v3_scale(along, pull), force);
        push(s, frame, f->spring_end[i][1], lw_v3_scale(along, -pull), force);
        work -= damp*rate;
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_spatial_joint_spring *p = &m->joint_spring[i];
        measured(f, frame, p->measure, v, &value, &rate);
        double damp = p->law ? value_of(f, p->law, t, frame, v, value, rate) : p->damping*rate;
        push_measure(f, frame, p->measure, -(p->law ? damp : p->stiffness*(value - p->free) + damp), force);
        work -= damp*rate;
    }
    for (int i = 0; i < m->n_motor; i++) {
        const lw_spatial_motor *p = &m->motor[i];
        lw_spatial_measure of = stop_measure(s, p->joint);
        measured(f, frame, of, v, &value, &rate);
        double load = p->stall*(1 - rate/p->free_speed);
        push_measure(f, frame, of, load, force);
        work += load*rate;
    }
    for (int i = 0; i < m->n_joint; i++) {
        const lw_joint_stop *p = &m->joint[i].stop;
        if (!elastic_stop(p))
            continue;
        measured(f, frame, stop_measure(s, i), v, &value, &rate);
        double depth = beyond(p, value);
        if (depth == 0)
            continue;
        push_measure(f, frame, stop_measure(s, i), -(p->stiffness*depth + p->damping*rate), force);
        work -= p->damping*rate*rate;
    }
    for (int i = 0; i < m->n_force; i++) {
        const lw_spatial_force *p = &m->force[i];
        lw_space_point at = f->force_at[i];
        double load[6] = { 0 };
        for (int k = 0; k < 3; k++) {
            load[k] = p->force[k] ? value_of(f, p->force[k], t, frame, v, 0, 0) : 0;
            load[3 + k] = p->torque[k] ? value_of(f, p->torque[k], t, frame, v, 0, 0) : 0;
        }
        if (at.body < 0)
            continue;
        lw_vec3 pull = lw_v3(load[0], load[1], load[2]), twist = lw_v3(load[3], load[4], load[5]);
        const lw_mat3 *turn = &frame[at.body + 1].turn;
        if (p->follows) {                    /* axes of the link: those of the ground in the posture of the file */
            lw_mat3 axes = lw_quaternion_matrix(s->axes[at.body]);
            pull = lw_m3_apply(turn, lw_m3_unapply(&axes, pull));
            twist = lw_m3_apply(turn, lw_m3_unapply(&axes, twist));
        }
        push(s, frame, at, pull, force);
        lw_vec3 own = lw_m3_unapply(turn, twist);
        double *to = force + 6*at.body + 3;
        to[0] += own.x, to[1] += own.y, to[2] += own.z;
        work += lw_v3_dot(pull, lw_space_point_velocity(s, frame, at, v)) + lw_v3_dot(twist, lw_space_omega(frame,
                at.body, v));
    }
    if (power)
        *power = work;
}

/* ---- energies ------------------------------------------------------------------------------------------------ */

double lw_space_potential(const lw_space_forces *f, const lw_space_frame *frame)
{
    const lw_space *s = f->s;
    const lw_spatial *m = s->model;
    double sum = 0, value;
    lw_vec3 along;
    for (int b = 0; b < s->n_body; b++)
        sum -= s->mass[6*b]*lw_v3_dot(m->gravity, frame[b + 1].at)/(s->unit*s->unit);
    for (int i = 0; i < m->n_spring; i++) {
        double stretch = spring_line(f, i, frame, NULL, &along, NULL) - m->spring[i].free;
        sum += m->spring[i].law ? 0 : m->spring[i].stiffness*stretch*stretch/2;
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_spatial_joint_spring *p = &m->joint_spring[i];
        value = lw_space_scale(s, p->measure)*lw_space_measure(s, frame, p->measure,
                                                               p->measure.of == LW_OF_TURN ? f->turn[p->measure.index]
                                                                   : 0, NULL);
        sum += p->law ? 0 : p->stiffness*(value - p->free)*(value - p->free)/2;
    }
    for (int i = 0; i < m->n_joint; i++)
        if (elastic_stop(&m->joint[i].stop)) {
            lw_spatial_measure of = stop_measure(s, i);
            value = lw_space_scale(s, of)*lw_space_measure(s, frame, of, f->turn[i], NULL);
            double depth = beyond(&m->joint[i].stop, value);
            sum += m->joint[i].stop.stiffness*depth*depth/2;
        }
    return sum;
}

double lw_space_kinetic(const lw_space *s, const double *v)
{
    double sum = 0;
    for (int i = 0; i < s->n_v; i++)
        sum += s->mass[i]*v[i]*v[i];
    return sum/2;
}

void lw_space_momentum(const lw_space *s, const lw_space_frame *frame, const double *v, lw_vec3 *linear,
                       lw_vec3 *angular)
{
    *linear = *angular = lw_v3(0, 0, 0);
    for (int b = 0; b < s->n_body; b++) {
        const double *m = s->mass + 6*b, *u = v + 6*b;
        lw_vec3 p = lw_v3_scale(lw_v3(m[0]*u[0], m[1]*u[1], m[2]*u[2]), 1/s->unit);
        lw_vec3 spin = lw_m3_apply(&frame[b + 1].turn, lw_v3(m[3]*u[3], m[4]*u[4], m[5]*u[5]));
        *linear = lw_v3_add(*linear, p);
        *angular = lw_v3_add(*angular, lw_v3_add(spin, lw_v3_cross(frame[b + 1].at, p)));
    }
}
