/* mbs/space/space_forces.c - loads of a spatial model. */
#include "mbs/space/space_forces.h"

#include <stdlib.h>
#include <string.h>
#include "base/vector.h"

/* Is the stop an elastic one? */
static bool elastic_stop(const lw_joint_stop *p) { return (p->has_least || p->has_greatest) && p->stiffness > 0; }

lw_status lw_space_forces_make(const lw_space *s, lw_space_forces *f, lw_error *e)
{
    const lw_spatial *m = s->model;
    size_t springs = (size_t)m->n_spring, forces = (size_t)m->n_force, joints = (size_t)m->n_joint, v = (size_t)s->n_v,
           beams = (size_t)m->n_beam, contacts = (size_t)m->n_contact;
    *f = (lw_space_forces){ .s = s, .conservative = m->n_force == 0 && m->n_motor == 0 };
    size_t bytes = springs*sizeof *f->spring_end + forces*sizeof *f->force_at + (joints + v + beams + (size_t)m->states.n_state)*sizeof *f->turn +
                   beams*sizeof *f->beam + contacts*sizeof *f->contact + 1;
    char *at = f->memory = calloc(1, bytes);
    if (!at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    f->spring_end = (lw_space_point (*)[2])(void *)at, at += springs*sizeof *f->spring_end;
    f->force_at = (lw_space_point *)(void *)at, at += forces*sizeof *f->force_at;
    f->beam = (lw_beam_space *)(void *)at, at += beams*sizeof *f->beam;
    f->contact = (lw_space_contact *)(void *)at, at += contacts*sizeof *f->contact;
    f->weight = (double *)(void *)at, at += v*sizeof *f->weight;
    f->turn = (double *)(void *)at;
    f->pull = f->turn + joints;
    f->z = f->pull + beams;
    for (int i = 0; i < m->n_beam; i++)
        f->pull[i] = NAN;
    for (int i = 0; i < m->n_spring; i++) {
        for (int k = 0; k < 2; k++)
            f->spring_end[i][k] = lw_space_point_of(s, m->spring[i].link[k], m->spring[i].at[k]);
        f->conservative = f->conservative && m->spring[i].damping == 0 && !m->spring[i].law;
    }
    for (int i = 0; i < m->n_joint_spring; i++)
        f->conservative = f->conservative && m->joint_spring[i].damping == 0 && !m->joint_spring[i].law;
    f->weights_alone = m->n_spring + m->n_joint_spring + m->n_contact + m->n_beam + m->n_super == 0;
    for (int i = 0; i < m->n_joint; i++) {
        f->conservative = f->conservative && !(elastic_stop(&m->joint[i].stop) && m->joint[i].stop.damping > 0);
        f->weights_alone = f->weights_alone && !elastic_stop(&m->joint[i].stop);
    }
    for (int i = 0; i < m->n_force; i++)
        f->force_at[i] = lw_space_point_of(s, m->force[i].link, m->force[i].at);
    for (int i = 0; i < m->n_contact; i++) {
        const lw_spatial_joint *j = &m->joint[m->contact[i]];
        f->contact[i] = (lw_space_contact){ .joint = m->contact[i], .law = &j->clearance, .friction = j->friction };
        if (!(j->friction.speed > 0))
            f->contact[i].friction.speed = LW_FRICTION_SPEED;
        for (int k = 0; k < 2; k++)
            f->contact[i].end[k] = lw_space_point_of(s, j->link[k], j->at);
        bool impact = j->clearance.model == LW_CLEARANCE_IMPACT || j->clearance.model == LW_CLEARANCE_MLSD;
        f->conservative = f->conservative && j->friction.coefficient == 0
                       && (impact ? j->clearance.damping == 0 : j->clearance.restitution == 1);
    }
    const double g[] = { m->gravity.x, m->gravity.y, m->gravity.z };
    for (int i = 0; i < s->n_v; i++)
        f->weight[i] = i%6 < 3 ? (s->mass[i] - s->rotor[i/6])*g[i%6]/s->unit : 0;
    return lw_space_elements_make(s, f, e);
}

void lw_space_forces_free(lw_space_forces *f)
{
    for (int i = 0; i < f->n_super; i++)           /* the model may be gone */
        lw_super_free(&f->super[i]);
    free(f->memory), free(f->super), free(f->super_work);
    *f = (lw_space_forces){ 0 };
}

void lw_space_forces_accept(lw_space_forces *f, const lw_space_frame *frame)
{
    lw_space_count_turns(f->s, frame, f->turn);
}

/* ---- measures --------------------------------------------------------------------------------------------- */

/* In SI units, at one moment.  along (12), filled with h: sum of v_a H_ab. */
typedef struct measure { double value, rate; int body[2]; double g[12], h[12][12], along[12]; } measure;

/* Rate, and with derivatives what velocities add to it. */
static void find_rate(measure *m, const double *v, bool derivatives)
{
    m->rate = 0;
    for (int a = 0; a < 12; a++)
        if (m->body[a/6] >= 0)
            m->rate += m->g[a]*v[6*m->body[a/6] + a%6];
    for (int b = 0; derivatives && b < 12; b++) {
        m->along[b] = 0;
        for (int a = 0; a < 12; a++)
            if (m->body[a/6] >= 0)
                m->along[b] += v[6*m->body[a/6] + a%6]*m->h[a][b];
    }
}

static void measure_of(const lw_space_forces *f, const lw_space_frame *frame, lw_spatial_measure of, const double *v,
                       bool derivatives, measure *m)
{
    double scale = lw_space_scale(f->s, of), near = of.of == LW_OF_TURN ? f->turn[of.index] : 0;
    lw_space_bodies(f->s, &(lw_space_extra){ .measure = of }, m->body);
    m->value = scale*lw_space_measure(f->s, frame, of, near, m->g);
    if (derivatives)
        lw_space_measure_bends(f->s, frame, of, m->h);
    for (int a = 0; a < 12; a++) {
        m->g[a] *= scale;
        for (int b = 0; derivatives && b < 12; b++)
            m->h[a][b] *= scale;
    }
    if (v)
        find_rate(m, v, derivatives);
}

/* The displacement of a point by coordinate c of its body. */
static lw_vec3 displacement(const lw_space *s, const lw_space_frame *frame, lw_space_point p, int c)
{
    lw_vec3 e = lw_v3(c%3 == 0, c%3 == 1, c%3 == 2);
    return p.body < 0 ? lw_v3(0, 0, 0) : c < 3 ? lw_v3_scale(e, s->unit)
                      : lw_m3_apply(&frame[p.body + 1].turn, lw_v3_cross(e, p.arm));
}

/* Generalised force of a load at a point: B^T load. */
static void point_gradient(const lw_space *s, const lw_space_frame *frame, lw_space_point p, lw_vec3 load, double *g)
{
    lw_vec3 m = lw_v3_cross(p.arm, lw_m3_unapply(&frame[p.body + 1].turn, load));
    g[0] = s->unit*load.x, g[1] = s->unit*load.y, g[2] = s->unit*load.z, g[3] = m.x, g[4] = m.y, g[5] = m.z;
}

/* The length between two points. */
static void length_of(const lw_space_forces *f, const lw_space_frame *frame, const lw_space_point end[2], const double *v,
                      bool derivatives, measure *m)
{
    const lw_space *s = f->s;
    lw_vec3 d = lw_v3_sub(lw_space_point_at(frame, end[1]), lw_space_point_at(frame, end[0]));
    m->value = lw_v3_norm(d);
    lw_vec3 along = m->value > 0 ? lw_v3_scale(d, 1/m->value) : d;
    for (int i = 0; i < 2; i++) {
        m->body[i] = end[i].body;
        point_gradient(s, frame, end[i], lw_v3_scale(along, i ? 1 : -1), m->g + 6*i);
    }
    for (int b = 0; derivatives && b < 12; b++) {
        lw_vec3 dd = lw_v3_scale(displacement(s, frame, end[b/6], b%6), b < 6 ? -1 : 1), turn = lw_v3(b%6 == 3, b%6 == 4, b%6 == 5);
        lw_vec3 du = m->value > 0 ? lw_v3_scale(lw_v3_sub(dd, lw_v3_scale(along, lw_v3_dot(along, dd))), 1/m->value)
                                  : lw_v3(0, 0, 0);
        for (int i = 0; i < 2; i++) {
            double column[6], sign = i ? 1 : -1;
            point_gradient(s, frame, end[i], lw_v3_scale(du, sign), column);
            if (b/6 == i && b%6 >= 3) {                  /* the body's axes turn */
                lw_vec3 own = lw_m3_unapply(&frame[end[i].body + 1].turn, along);
                lw_vec3 c = lw_v3_scale(lw_v3_cross(end[i].arm, lw_v3_cross(own, turn)), sign);
                column[3] += c.x, column[4] += c.y, column[5] += c.z;
            }
            for (int a = 0; a < 6; a++)
                m->h[6*i + a][b] = column[a];
        }
    }
    if (v)
        find_rate(m, v, derivatives);
}

/* ---- expressions ------------------------------------------------------------------------------------------- */

/* The measure that a variable of an expression is, or is the rate of.  false: it is none. */
static bool variable_measure(int number, lw_spatial_measure *of)
{
    int index = lw_variable_index(number);
    switch (lw_variable_quantity(number)) {
    case LW_QUANTITY_Q: case LW_QUANTITY_V:  *of = (lw_spatial_measure){ LW_OF_TURN, index }; return true;
    case LW_QUANTITY_S: case LW_QUANTITY_VS: *of = (lw_spatial_measure){ LW_OF_SLIDE, index }; return true;
    case LW_QUANTITY_X: case LW_QUANTITY_VX: *of = (lw_spatial_measure){ LW_OF_X, index }; return true;
    case LW_QUANTITY_Y: case LW_QUANTITY_VY: *of = (lw_spatial_measure){ LW_OF_Y, index }; return true;
    case LW_QUANTITY_Z: case LW_QUANTITY_VZ: *of = (lw_spatial_measure){ LW_OF_Z, index }; return true;
    default:                                 return false;
    }
}

static bool is_rate(lw_quantity what)
{
    return what == LW_QUANTITY_V || what == LW_QUANTITY_VS || (what >= LW_QUANTITY_VX && what <= LW_QUANTITY_VZ) ||
           what == LW_QUANTITY_SPRING_RATE;
}

/* The value of a law, and its derivatives by its own length and rate, by every other measure, and by states. */
typedef struct law {
    const lw_expression *x;
    double value, by_length, by_rate;
    int    n, n_state;                           /* other variables */
    double by[LW_EXPRESSION_VARIABLE_MAX], by_state[LW_EXPRESSION_VARIABLE_MAX];
    bool   is_rate[LW_EXPRESSION_VARIABLE_MAX];
    int    state[LW_EXPRESSION_VARIABLE_MAX];
    measure *m;                                  /* (n) */
} law;

/* m (LW_EXPRESSION_VARIABLE_MAX): where derivatives are wanted, else NULL. */
static law evaluate(const lw_space_forces *f, const lw_expression *x, double t, const lw_space_frame *frame, const double *v,
                    double length, double rate, measure *m)
{
    const int *which;
    double at[LW_EXPRESSION_VARIABLE_MAX], dv[LW_EXPRESSION_VARIABLE_MAX];
    int n = lw_expression_variables(x, &which);
    law out = { .x = x, .m = m };
    measure one;
    for (int i = 0; i < n; i++) {
        lw_quantity what = lw_variable_quantity(which[i]);
        int index = lw_variable_index(which[i]);
        lw_spatial_measure of;
        measure *to = m ? &m[out.n] : &one;
        if (what == LW_QUANTITY_SPRING_LENGTH || what == LW_QUANTITY_SPRING_RATE)
            length_of(f, frame, f->spring_end[index], v, m != NULL, to);
        else if (variable_measure(which[i], &of))
            measure_of(f, frame, of, v, m != NULL, to);
        else {
            at[i] = what == LW_QUANTITY_T ? t : what == LW_QUANTITY_STATE ? f->z[index] : what == LW_QUANTITY_LENGTH ? length : rate;
            continue;
        }
        out.is_rate[out.n++] = is_rate(what);
        at[i] = is_rate(what) ? to->rate : to->value;
    }
    if (f->see)
        f->see(f->see_of, x, at);
    if (!m) {
        out.value = lw_expression_value(x, at);
        return out;
    }
    out.value = lw_expression_gradient(x, at, dv);
    out.n = 0;
    for (int i = 0; i < n; i++) {
        lw_quantity what = lw_variable_quantity(which[i]);
        if (what == LW_QUANTITY_LENGTH)
            out.by_length = dv[i];
        else if (what == LW_QUANTITY_RATE)
            out.by_rate = dv[i];
        else if (what == LW_QUANTITY_STATE)
            out.by_state[out.n_state] = dv[i], out.state[out.n_state++] = lw_variable_index(which[i]);
        else if (what != LW_QUANTITY_T)
            out.by[out.n++] = dv[i];
    }
    return out;
}

/* ---- loads ------------------------------------------------------------------------------------------------ */

typedef struct sum {
    const lw_space_forces *f;
    const lw_space_frame  *frame;
    const double *v;
    double  t, power, *force;
    const lw_space_sink *sink;
    measure variable[LW_EXPRESSION_VARIABLE_MAX];        /* scratch */
} sum;

/* Derivatives of a law by measures other than its own, and by states, in n rows that grow by g times its value; states: the
 * rows are rates of states. */
static void add_law(sum *s, const law *l, int n, const int *row, const double *g, bool states)
{
    const lw_space_sink *to = s->sink;
    int n_v = s->f->s->n_v;
    for (int a = 0; a < n; a++) {
        for (int i = 0; i < l->n; i++)
            for (int b = 0; b < 12; b++) {
                const measure *m = &l->m[i];
                double by = l->by[i]*g[a];
                if (m->body[b/6] >= 0 && (to->add_state || !states))
                    (states ? to->add_state : to->add)(to->context, row[a], 6*m->body[b/6] + b%6, by*(l->is_rate[i] ? m->along[b]
                                                       : m->g[b]), l->is_rate[i] ? by*m->g[b] : 0);
            }
        for (int i = 0; i < l->n_state && to->add_state; i++)
            to->add_state(to->context, row[a], n_v + l->state[i], l->by_state[i]*g[a], 0);
    }
}

/* The same for a load with gradient `sense` times g on two bodies. */
static void add_law_on(sum *s, const law *l, const int body[2], double sense, const double *g)
{
    int row[12], n = 0;
    double to[12];
    for (int a = 0; a < 12; a++)
        if (body[a/6] >= 0)
            row[n] = 6*body[a/6] + a%6, to[n++] = sense*g[a];
    add_law(s, l, n, row, to, false);
}

/* A force along a measure, with its derivatives by the measure's value and rate. */
static void push(sum *s, const measure *m, double load, double by_value, double by_rate)
{
    for (int a = 0; a < 12; a++) {
        if (m->body[a/6] < 0)
            continue;
        int row = 6*m->body[a/6] + a%6;
        s->force[row] += load*m->g[a];
        for (int b = 0; s->sink && b < 12; b++)
            if (m->body[b/6] >= 0)
                s->sink->add(s->sink->context, row, 6*m->body[b/6] + b%6,
                             m->g[a]*(by_value*m->g[b] + by_rate*m->along[b]) + load*m->h[a][b], by_rate*m->g[a]*m->g[b]);
    }
}

/* A spring and damper along a measure, or its law, which is a tension (sense -1) or a push. */
static void push_spring(sum *s, const measure *m, double stiffness, double damping, double free, double sense, const lw_expression *x)
{
    if (!x) {
        push(s, m, -stiffness*(m->value - free) - damping*m->rate, -stiffness, -damping);
        s->power -= damping*m->rate*m->rate;
        return;
    }
    law l = evaluate(s->f, x, s->t, s->frame, s->v, m->value, m->rate, s->sink ? s->variable : NULL);
    push(s, m, sense*l.value, sense*l.by_length, sense*l.by_rate);
    s->power += sense*l.value*m->rate;
    if (s->sink)
        add_law_on(s, &l, m->body, sense, m->g);
}

/* How far a measure lies beyond its stop. */
static double beyond(const lw_joint_stop *p, double value)
{
    return p->has_least && value < p->least ? value - p->least : p->has_greatest && value > p->greatest ?
        value - p->greatest : 0;
}

lw_spatial_measure lw_space_stop_measure(const lw_space *s, int joint)
{
    return (lw_spatial_measure){ lw_spatial_kind_of(s->joint[joint].kind)->turns ? LW_OF_TURN : LW_OF_SLIDE, joint };
}

/* ---- friction of contacts --------------------------------------------------------------------------------- */

/* Bodies of a contact at one moment, or how all of it changes: places of the centres and arms from the centres of mass to them,
 * velocities, angular velocities. */
typedef struct contact_bodies { lw_vec3 at[2], arm[2], v[2], omega[2]; } contact_bodies;

typedef struct contact_rub { lw_vec3 drag, arm; double power, force[12], by_x[12][12], by_v[12][12]; } contact_rub;

/* (tanh(u/s)/u - 1/(s cosh^2(u/s)))/u^2: what the slope of friction loses across the slip. */
static double lost_slope(double slip, double speed, double part)
{
    double a = slip/speed;
    return a < 1e-3 ? 2/(3*speed*speed*speed) : (part/slip - (1 - part*part)/speed)/(slip*slip);
}

/* Friction where the surfaces touch, at the radius R of the pin along the line n of the centres: the points there of pin and bush
 * slip by u across n, and the drag on the pin is -coefficient |load| tanh(|u|/speed) u/|u|. */
static bool find_rub(const lw_space_forces *f, const lw_space_frame *frame, const double *v, const lw_space_contact *p,
                     bool derivatives, contact_rub *out)
{
    if (!(p->friction.coefficient > 0) || p->phase == LW_CONTACT_APART || !v)
        return false;
    const lw_vec3 none = lw_v3(0, 0, 0);
    contact_bodies b;
    for (int k = 0; k < 2; k++) {
        int body = p->end[k].body;
        b.at[k] = lw_space_point_at(frame, p->end[k]);
        b.arm[k] = lw_v3_sub(b.at[k], frame[body + 1].at);
        b.v[k] = body < 0 ? none : lw_v3_scale(lw_v3(v[6*body], v[6*body + 1], v[6*body + 2]), f->s->unit);
        b.omega[k] = body < 0 ? none : lw_space_omega(frame, body, v);
    }
    lw_vec3 d = lw_v3_sub(b.at[1], b.at[0]), slip = none, rates = none, reach[2];
    double r = lw_v3_norm(d), by_depth, by_rate;
    if (r == 0)
        return false;
    lw_vec3 n = lw_v3_scale(d, 1/r);
    for (int k = 0; k < 2; k++) {
        reach[k] = lw_v3_add(b.arm[k], lw_v3_scale(n, p->friction.radius + (k ? 0 : r)));
        slip = lw_v3_add(slip, lw_v3_scale(lw_v3_add(b.v[k], lw_v3_cross(b.omega[k], reach[k])), k ? 1 : -1));
        rates = lw_v3_add(rates, lw_v3_scale(lw_v3_add(b.v[k], lw_v3_cross(b.omega[k], b.arm[k])), k ? 1 : -1));
    }
    double along = lw_v3_dot(n, slip), rate = lw_v3_dot(n, rates);
    double load = lw_contact_gradient(p->law, p->phase, r - p->law->gap, rate, p->struck, &by_depth, &by_rate);
    lw_vec3 u = lw_v3_sub(slip, lw_v3_scale(n, along));
    double size = lw_v3_norm(u), speed = p->friction.speed, part = tanh(size/speed), factor = size > 0 ? part/size : 1/speed;
    double press = p->friction.coefficient*fabs(load), lost = lost_slope(size, speed, part);
    out->drag = lw_v3_scale(u, -press*factor);
    out->arm = lw_v3_scale(n, p->friction.radius);
    out->power = lw_v3_dot(out->drag, u);
    for (int k = 0; k < 2; k++) {
        lw_vec3 push = lw_v3_scale(out->drag, k ? 1 : -1), moment = lw_v3_cross(reach[k], push);
        const double all[6] = { push.x, push.y, push.z, moment.x, moment.y, moment.z };
        memcpy(out->force + 6*k, all, sizeof all);
    }
    for (int c = 0; c < 24 && derivatives; c++) {        /* a displacement or turn, then a velocity, of one body */
        contact_bodies by = { { none, none }, { none, none }, { none, none }, { none, none } };
        int moved = c%12/6;
        lw_vec3 e = lw_v3(c%3 == 0, c%3 == 1, c%3 == 2), d_slip = none, d_rates = none, d_reach[2];
        if (c%6 >= 3 && c < 12)
            by.at[moved] = by.arm[moved] = lw_v3_cross(e, b.arm[moved]), by.omega[moved] = lw_v3_cross(e, b.omega[moved]);
        else
            *(c < 12 ? &by.at[moved] : c%6 < 3 ? &by.v[moved] : &by.omega[moved]) = e;
        lw_vec3 dd = lw_v3_sub(by.at[1], by.at[0]);
        double dr = lw_v3_dot(n, dd);
        lw_vec3 dn = lw_v3_scale(lw_v3_sub(dd, lw_v3_scale(n, dr)), 1/r);
        for (int k = 0; k < 2; k++) {
            d_reach[k] = lw_v3_add(by.arm[k], lw_v3_scale(dn, p->friction.radius + (k ? 0 : r)));
            d_reach[k] = lw_v3_add(d_reach[k], lw_v3_scale(n, k ? 0 : dr));
            lw_vec3 turned = lw_v3_add(lw_v3_cross(by.omega[k], reach[k]), lw_v3_cross(b.omega[k], d_reach[k]));
            d_slip = lw_v3_add(d_slip, lw_v3_scale(lw_v3_add(by.v[k], turned), k ? 1 : -1));
            turned = lw_v3_add(lw_v3_cross(by.omega[k], b.arm[k]), lw_v3_cross(b.omega[k], by.arm[k]));
            d_rates = lw_v3_add(d_rates, lw_v3_scale(lw_v3_add(by.v[k], turned), k ? 1 : -1));
        }
        double d_load = by_depth*dr + by_rate*(lw_v3_dot(dn, rates) + lw_v3_dot(n, d_rates));
        lw_vec3 du = lw_v3_sub(d_slip, lw_v3_scale(n, lw_v3_dot(dn, slip) + lw_v3_dot(n, d_slip)));
        du = lw_v3_sub(du, lw_v3_scale(dn, along));
        double by_u = press*lost*lw_v3_dot(u, du) - copysign(p->friction.coefficient, load)*d_load*factor;
        lw_vec3 d_drag = lw_v3_add(lw_v3_scale(u, by_u), lw_v3_scale(du, -press*factor));
        for (int k = 0; k < 2; k++) {
            lw_vec3 m = lw_v3_add(lw_v3_cross(d_reach[k], out->drag), lw_v3_cross(reach[k], d_drag));
            const double all[6] = { d_drag.x, d_drag.y, d_drag.z, m.x, m.y, m.z };
            for (int a = 0; a < 6; a++)
                (c < 12 ? out->by_x : out->by_v)[6*k + a][c%12] = k ? all[a] : -all[a];
        }
    }
    return true;
}

/* The force of pin and bush along the distance of their centres, and friction. */
static void push_contact(sum *s, int i)
{
    const lw_space_contact *p = &s->f->contact[i];
    double by_depth, by_rate;
    measure at;
    contact_rub rub;
    if (p->phase == LW_CONTACT_APART)
        return;
    length_of(s->f, s->frame, p->end, s->v, s->sink != NULL, &at);
    double depth = at.value - p->law->gap, load = lw_contact_gradient(p->law, p->phase, depth, at.rate, p->struck, &by_depth, &by_rate);
    push(s, &at, -load, -by_depth, -by_rate);
    s->power -= (load - lw_contact_spring(p->law, depth))*at.rate;
    if (!find_rub(s->f, s->frame, s->v, p, s->sink != NULL, &rub))
        return;
    lw_space_add_element(s->f->s, s->frame, 2, (const int[2]){ p->end[0].body, p->end[1].body }, rub.force, &rub.by_x[0][0],
                         &rub.by_v[0][0], s->force, s->sink);
    s->power += rub.power;
}

lw_space_touch lw_space_touch_of(const lw_space_forces *f, const lw_space_frame *frame, const double *v, int i)
{
    const lw_space_contact *p = &f->contact[i];
    measure at = { .rate = 0 };
    contact_rub rub = { .power = 0 };
    length_of(f, frame, p->end, v, false, &at);
    if (!find_rub(f, frame, v, p, false, &rub))
        rub.drag = rub.arm = lw_v3(0, 0, 0);
    return (lw_space_touch){ at.value, at.rate, lw_contact_force(p->law, p->phase, at.value - p->law->gap, at.rate, p->struck),
                             rub.drag, rub.arm };
}

void lw_space_stop_sides(const lw_space_forces *f, const lw_space_frame *frame, const double *v, double *side)
{
    measure at;
    for (int i = 0, n = 0; i < f->s->model->n_joint; i++) {
        const lw_joint_stop *p = &f->s->model->joint[i].stop;
        if (!elastic_stop(p))
            continue;
        measure_of(f, frame, lw_space_stop_measure(f->s, i), v, false, &at);
        double depth = beyond(p, at.value);
        double in = fmax(p->has_least ? p->least - at.value : -INFINITY, p->has_greatest ? at.value - p->greatest : -INFINITY);
        side[n++] = in;
        side[n++] = p->stiffness*in + (depth == 0 ? 0 : copysign(p->damping, depth)*at.rate);
    }
}

/* So far beyond its end a piece ends, over the clearance: rounding of lengths is less. */
static const double late = 1e-9;

double lw_space_piece_left(const lw_space_forces *f, const lw_space_frame *frame)
{
    double left = 1;
    for (int i = 0; i < f->s->model->n_contact; i++) {
        const lw_space_contact *p = &f->contact[i];
        double d = lw_v3_norm(lw_v3_sub(lw_space_point_at(frame, p->end[1]), lw_space_point_at(frame, p->end[0])));
        left = fmin(left, lw_contact_within(p->law, p->phase, d - p->law->gap)/p->law->gap + late);
    }
    return left;
}

void lw_space_next_piece(lw_space_forces *f, const lw_space_frame *frame, const double *v, bool start)
{
    for (int i = 0; i < f->s->model->n_contact; i++) {
        lw_space_contact *p = &f->contact[i];
        lw_space_touch at = lw_space_touch_of(f, frame, v, i);
        double depth = at.distance - p->law->gap;
        bool apart = p->phase == LW_CONTACT_APART;
        if (start)
            p->phase = lw_contact_phase_at(p->law, depth);
        for (int k = 0; k < 2 && lw_contact_within(p->law, p->phase, depth) < -0.5*late*p->law->gap; k++)
            p->phase = lw_contact_next(p->law, p->phase, depth);
        if (apart && p->phase != LW_CONTACT_APART)
            p->struck = fabs(at.rate);
    }
}

void lw_space_watch_contacts(lw_space_forces *f, const lw_space_frame *frame, const double *v, double t, bool first)
{
    for (int i = 0; i < f->s->model->n_contact; i++) {
        lw_space_contact *p = &f->contact[i];
        lw_space_touch at = lw_space_touch_of(f, frame, v, i);
        bool open = p->law->model == LW_CLEARANCE_MLSD ? at.distance < p->law->gap : p->phase == LW_CONTACT_APART;
        if (first)
            p->apart = p->force_most = p->distance_most = 0, p->losses = 0;
        else {
            p->apart += p->open ? t - p->last : 0;
            p->losses += open && !p->open;
        }
        p->open = open, p->last = t;
        p->force_most = fmax(p->force_most, at.force), p->distance_most = fmax(p->distance_most, at.distance);
    }
}

/* One component of an applied force or torque, along a unit vector `e`. */
static void push_component(sum *s, int i, int k, bool torque, lw_vec3 e)
{
    const lw_force *p = &s->f->s->model->force[i];
    const lw_expression *x = torque ? p->torque[k] : p->force[k];
    const lw_space *space = s->f->s;
    lw_space_point at = s->f->force_at[i];
    if (!x || at.body < 0)
        return;
    law l = evaluate(s->f, x, s->t, s->frame, s->v, 0, 0, s->sink ? s->variable : NULL);
    const lw_mat3 *turn = &s->frame[at.body + 1].turn;
    lw_vec3 world = e, own;
    if (p->follows) {                        /* axes of the link: those of the ground in the posture of the file */
        lw_mat3 axes = lw_quaternion_matrix(space->axes[at.body]);
        world = lw_m3_apply(turn, lw_m3_unapply(&axes, e));
    }
    own = lw_m3_unapply(turn, world);
    double g[12] = { 0 };
    if (torque)
        g[3] = own.x, g[4] = own.y, g[5] = own.z;
    else
        point_gradient(space, s->frame, at, world, g);
    for (int a = 0; a < 6; a++) {
        s->force[6*at.body + a] += l.value*g[a];
        s->power += l.value*g[a]*s->v[6*at.body + a];
    }
    if (!s->sink)
        return;
    add_law_on(s, &l, (const int[2]){ at.body, -1 }, 1, g);
    for (int c = 0; c < 3; c++) {            /* the body turns: its own axes, or the directions, move */
        lw_vec3 by = lw_v3(c == 0, c == 1, c == 2), d;
        double column[6] = { 0 };
        if (p->follows && !torque) {
            d = lw_v3_scale(lw_m3_apply(turn, lw_v3_cross(by, own)), space->unit);
            column[0] = d.x, column[1] = d.y, column[2] = d.z;
        } else if (!p->follows) {
            d = lw_v3_cross(own, by);
            d = torque ? d : lw_v3_cross(at.arm, d);
            column[3] = d.x, column[4] = d.y, column[5] = d.z;
        }
        for (int a = 0; a < 6; a++)
            s->sink->add(s->sink->context, 6*at.body + a, 6*at.body + 3 + c, l.value*column[a], 0);
    }
}

lw_vec3 lw_space_applied(const lw_space_forces *f, int i, double t, const lw_space_frame *frame, const double *v, lw_vec3 *moment)
{
    const lw_force *p = &f->s->model->force[i];
    lw_space_point at = f->force_at[i];
    double value[6] = { 0 };
    *moment = lw_v3(0, 0, 0);
    if (at.body < 0)
        return *moment;
    for (int k = 0; k < 6; k++) {
        const lw_expression *x = k < 3 ? p->force[k] : p->torque[k - 3];
        value[k] = x ? evaluate(f, x, t, frame, v, 0, 0, NULL).value : 0;
    }
    const lw_mat3 *turn = &frame[at.body + 1].turn;
    lw_mat3 axes = lw_quaternion_matrix(f->s->axes[at.body]);
    lw_vec3 force = lw_v3(value[0], value[1], value[2]), torque = lw_v3(value[3], value[4], value[5]);
    if (p->follows) {
        force = lw_m3_apply(turn, lw_m3_unapply(&axes, force));
        torque = lw_m3_apply(turn, lw_m3_unapply(&axes, torque));
    }
    *moment = lw_v3_add(torque, lw_v3_cross(lw_m3_apply(turn, at.arm), force));
    return force;
}

/* Gravity, and what spinning bodies add. */
static void push_bodies(sum *s)
{
    const lw_space *space = s->f->s;
    memcpy(s->force, s->f->weight, (size_t)space->n_v*sizeof *s->force);
    for (int b = 0; b < space->n_body; b++) {
        const double *mass = space->mass + 6*b, *w = s->v + 6*b + 3;
        for (int i = 0; i < 3; i++) {
            int j = (i + 1)%3, k = (i + 2)%3, row = 6*b + 3 + i;
            double by = mass[3 + j] - mass[3 + k];
            s->force[row] += by*w[j]*w[k];
            if (s->sink) {
                s->sink->add(s->sink->context, row, 6*b + 3 + j, 0, by*w[k]);
                s->sink->add(s->sink->context, row, 6*b + 3 + k, 0, by*w[j]);
            }
        }
    }
}

/* The loads that the caller holds on links. */
static void push_held(sum *s)
{
    static const double none[36];
    const lw_space *space = s->f->s;
    for (int b = 0; b < space->n_body; b++) {
        const double *l = s->f->held + 6*space->link_of[b], *v = s->v + 6*b;
        lw_vec3 omega = lw_space_omega(s->frame, b, s->v);
        lw_space_add_element(space, s->frame, 1, &b, l, none, none, s->force, s->sink);
        s->power += space->unit*(l[0]*v[0] + l[1]*v[1] + l[2]*v[2]) + lw_v3_dot(lw_v3(l[3], l[4], l[5]), omega);
    }
}

void lw_space_forces_apply(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v,
                           double *force, double *power, const lw_space_sink *sink)
{
    const lw_space *space = f->s;
    const lw_spatial *m = space->model;
    sum s;
    measure at;
    s.f = f, s.frame = frame, s.v = v, s.t = t, s.power = 0, s.force = force, s.sink = sink;
    push_bodies(&s);
    for (int i = 0; i < m->n_spring; i++) {
        const lw_spring *p = &m->spring[i];
        length_of(f, frame, f->spring_end[i], v, sink, &at);
        push_spring(&s, &at, p->stiffness, p->damping, p->free, -1, p->law);
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_spatial_joint_spring *p = &m->joint_spring[i];
        measure_of(f, frame, p->measure, v, sink, &at);
        push_spring(&s, &at, p->stiffness, p->damping, p->free, 1, p->law);
    }
    for (int i = 0; i < m->n_motor; i++) {
        const lw_motor *p = &m->motor[i];
        measure_of(f, frame, lw_space_stop_measure(space, p->joint), v, sink, &at);
        double load = p->stall*(1 - at.rate/p->free_speed);
        push(&s, &at, load, 0, -p->stall/p->free_speed);
        s.power += load*at.rate;
    }
    for (int i = 0; i < m->n_joint; i++) {
        const lw_joint_stop *p = &m->joint[i].stop;
        if (!elastic_stop(p))
            continue;
        measure_of(f, frame, lw_space_stop_measure(space, i), v, sink, &at);
        double depth = beyond(p, at.value), load = p->stiffness*depth + p->damping*at.rate;
        if (depth == 0)
            continue;
        bool held = load*depth > 0;          /* the damper of a stop pushes but does not pull */
        push(&s, &at, held ? -load : 0, held ? -p->stiffness : 0, held ? -p->damping : 0);
        s.power += held ? -p->damping*at.rate*at.rate : p->stiffness*depth*at.rate;
    }
    for (int i = 0; i < m->n_contact; i++)
        push_contact(&s, i);
    lw_space_push_elements(f, frame, v, force, &s.power, sink);
    if (f->held)
        push_held(&s);
    for (int i = 0; i < m->n_force; i++)
        for (int k = 0; k < 6; k++)
            push_component(&s, i, k%3, k >= 3, lw_v3(k%3 == 0, k%3 == 1, k%3 == 2));
    for (int i = 0; sink && sink->add_state && i < m->states.n_state; i++) {
        law l = evaluate(f, m->states.state[i].rate, t, frame, v, 0, 0, s.variable);
        add_law(&s, &l, 1, (const int[]){ space->n_v + i }, (const double[]){ 1 }, true);
    }
    if (power)
        *power = s.power;
}

/* ---- states --------------------------------------------------------------------------------------------------- */

void lw_space_state_rates(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v, double *rate)
{
    const lw_states *z = &f->s->model->states;
    for (int i = 0; i < z->n_state; i++)
        rate[i] = evaluate(f, z->state[i].rate, t, frame, v, 0, 0, NULL).value;
}

void lw_space_values(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v, double *force,
                     lw_expression_sink_at *see, void *of)
{
    lw_space_forces noting = *f;
    const lw_states *z = &f->s->model->states;
    noting.see = see;
    noting.see_of = of;
    lw_space_forces_apply(&noting, t, frame, v, force, NULL, NULL);
    for (int i = 0; i < z->n_state; i++)
        evaluate(&noting, z->state[i].rate, t, frame, v, 0, 0, NULL);
}

void lw_space_state_start(const lw_space_forces *f, double t, const lw_space_frame *frame, const double *v, double *start)
{
    const lw_states *z = &f->s->model->states;
    for (int i = 0; i < z->n_state; i++)
        start[i] = f->z[i] = z->state[i].start;
    for (int i = 0; i < z->n_state; i++)
        if (z->state[i].start_at)
            start[i] = f->z[i] = evaluate(f, z->state[i].start_at, t, frame, v, 0, 0, NULL).value;
}

double lw_space_signal(const lw_space_forces *f, int i, double t, const lw_space_frame *frame, const double *v)
{
    return evaluate(f, f->s->model->states.signal[i].value, t, frame, v, 0, 0, NULL).value;
}

/* ---- pattern and dampers ------------------------------------------------------------------------------------- */

static void list(const lw_space_sink *sink, const int body[2], const int other[2])
{
    for (int a = 0; a < 12; a++)
        for (int b = 0; b < 12 && body[a/6] >= 0; b++)
            if (other[b/6] >= 0)
                sink->add(sink->context, 6*body[a/6] + a%6, 6*other[b/6] + b%6, 1, 1);
}

/* A law that acts on two bodies, or (state >= 0) is the rate of a state. */
static void list_law(const lw_space_forces *f, const lw_space_sink *sink, const int body[2], int state, const lw_expression *x)
{
    static const double any[12] = { 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1 };
    sum s;
    law l = { .m = s.variable };
    const int *which;
    int n = x ? lw_expression_variables(x, &which) : 0;
    for (int i = 0; i < n; i++) {
        lw_quantity what = lw_variable_quantity(which[i]);
        lw_spatial_measure of;
        measure *m = &l.m[l.n];
        if (what == LW_QUANTITY_STATE)
            l.by_state[l.n_state] = 1, l.state[l.n_state++] = lw_variable_index(which[i]);
        if (what == LW_QUANTITY_SPRING_LENGTH || what == LW_QUANTITY_SPRING_RATE)
            for (int end = 0; end < 2; end++)
                m->body[end] = f->spring_end[lw_variable_index(which[i])][end].body;
        else if (variable_measure(which[i], &of))
            lw_space_bodies(f->s, &(lw_space_extra){ .measure = of }, m->body);
        else
            continue;
        memcpy(m->g, any, sizeof any);
        l.by[l.n++] = 1;
    }
    s.f = f, s.sink = sink;
    if (state < 0)
        add_law_on(&s, &l, body, 1, any);
    else
        add_law(&s, &l, 1, (const int[]){ f->s->n_v + state }, any, true);
}

void lw_space_forces_pattern(const lw_space_forces *f, const lw_space_sink *sink)
{
    const lw_space *s = f->s;
    const lw_spatial *m = s->model;
    int body[2];
    for (int b = 0; b < s->n_body; b++)
        list(sink, (const int[2]){ b, -1 }, (const int[2]){ b, -1 });
    for (int i = 0; i < m->n_spring; i++) {
        body[0] = f->spring_end[i][0].body, body[1] = f->spring_end[i][1].body;
        list(sink, body, body);
        list_law(f, sink, body, -1, m->spring[i].law);
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        lw_space_bodies(s, &(lw_space_extra){ .measure = m->joint_spring[i].measure }, body);
        list(sink, body, body);
        list_law(f, sink, body, -1, m->joint_spring[i].law);
    }
    for (int i = 0; i < m->n_motor; i++)
        list(sink, s->joint[m->motor[i].joint].body, s->joint[m->motor[i].joint].body);
    for (int i = 0; i < m->n_joint; i++)
        if (elastic_stop(&m->joint[i].stop))
            list(sink, s->joint[i].body, s->joint[i].body);
    for (int i = 0; i < m->n_contact; i++)
        list(sink, s->joint[m->contact[i]].body, s->joint[m->contact[i]].body);
    for (int i = 0; i < m->n_beam; i++) {
        body[0] = s->body_of[m->beam[i].link[0]], body[1] = s->body_of[m->beam[i].link[1]];
        list(sink, body, body);
    }
    for (int i = 0; i < m->n_super; i++)
        for (int k = 0; k < m->super[i].n*m->super[i].n; k++) {
            body[0] = s->body_of[m->super[i].link[k/m->super[i].n]], body[1] = s->body_of[m->super[i].link[k%m->super[i].n]];
            list(sink, (const int[2]){ body[0], -1 }, (const int[2]){ body[1], -1 });
        }
    for (int i = 0; i < m->n_force; i++)
        for (int k = 0; k < 3; k++) {
            list_law(f, sink, (const int[2]){ f->force_at[i].body, -1 }, -1, m->force[i].force[k]);
            list_law(f, sink, (const int[2]){ f->force_at[i].body, -1 }, -1, m->force[i].torque[k]);
        }
    for (int i = 0; i < m->states.n_state && sink->add_state; i++)
        list_law(f, sink, NULL, i, m->states.state[i].rate);
}

int lw_space_dampers(const lw_space *s) { return s->model->n_spring + s->model->n_joint_spring + s->model->n_motor; }

double lw_space_damper(const lw_space_forces *f, int k, const lw_space_frame *frame, double *g)
{
    const lw_spatial *m = f->s->model;
    int joint = k - m->n_spring, motor = joint - m->n_joint_spring;
    measure at;
    if (joint < 0)
        length_of(f, frame, f->spring_end[k], NULL, false, &at);
    else
        measure_of(f, frame, motor < 0 ? m->joint_spring[joint].measure : lw_space_stop_measure(f->s, m->motor[motor].joint),
                   NULL, false, &at);
    for (int a = 0; a < 12; a++)
        if (at.body[a/6] >= 0)
            g[6*at.body[a/6] + a%6] += at.g[a];
    return joint < 0 ? m->spring[k].damping : motor < 0 ? m->joint_spring[joint].damping
                     : m->motor[motor].stall/m->motor[motor].free_speed;
}

/* ---- energies ------------------------------------------------------------------------------------------------ */

double lw_space_potential(const lw_space_forces *f, const double *q, lw_space_frame *frame)
{
    const lw_space *s = f->s;
    const lw_spatial *m = s->model;
    double all = 0, x;
    measure at;
    for (int b = 0; b < s->n_body; b++)
        all -= lw_dot(3, f->weight + 6*b, q + 7*b);
    if (f->weights_alone)
        return all;
    lw_space_place(s, q, frame);
    for (int i = 0; i < m->n_spring; i++) {
        length_of(f, frame, f->spring_end[i], NULL, false, &at);
        x = at.value - m->spring[i].free;
        all += m->spring[i].law ? 0 : m->spring[i].stiffness*x*x/2;
    }
    for (int i = 0; i < m->n_joint_spring; i++) {
        measure_of(f, frame, m->joint_spring[i].measure, NULL, false, &at);
        x = at.value - m->joint_spring[i].free;
        all += m->joint_spring[i].law ? 0 : m->joint_spring[i].stiffness*x*x/2;
    }
    for (int i = 0; i < m->n_joint; i++)
        if (elastic_stop(&m->joint[i].stop)) {
            measure_of(f, frame, lw_space_stop_measure(s, i), NULL, false, &at);
            x = beyond(&m->joint[i].stop, at.value);
            all += m->joint[i].stop.stiffness*x*x/2;
        }
    for (int i = 0; i < m->n_contact; i++)
        all += lw_contact_energy(f->contact[i].law, f->contact[i].phase,
                                 lw_space_touch_of(f, frame, NULL, i).distance - f->contact[i].law->gap);
    return lw_space_elements_energy(f, frame, all);
}

double lw_space_kinetic(const lw_space *s, const double *v)
{
    double all = 0;
    for (int b = 0; b < s->n_body; b++) {    /* short sums, since the processor waits for each term of a long one */
        const double *m = s->mass + 6*b, *u = v + 6*b;
        all += m[0]*u[0]*u[0] + m[1]*u[1]*u[1] + m[2]*u[2]*u[2] + (m[3]*u[3]*u[3] + m[4]*u[4]*u[4] + m[5]*u[5]*u[5]);
    }
    return all/2;
}

void lw_space_momentum(const lw_space_forces *f, const lw_space_frame *frame, const double *v, lw_vec3 *linear, lw_vec3 *angular)
{
    const lw_space *s = f->s;
    *linear = *angular = lw_v3(0, 0, 0);
    for (int b = 0; b < s->n_body; b++) {
        const double *m = s->mass + 6*b, *u = v + 6*b;
        lw_vec3 p = lw_v3_scale(lw_v3(m[0]*u[0], m[1]*u[1], m[2]*u[2]), 1/s->unit);
        lw_vec3 spin = lw_m3_apply(&frame[b + 1].turn, lw_v3(m[3]*u[3], m[4]*u[4], m[5]*u[5]));
        *linear = lw_v3_add(*linear, p);
        *angular = lw_v3_add(*angular, lw_v3_add(spin, lw_v3_cross(frame[b + 1].at, p)));
    }
    for (int i = 0; i < s->model->n_super; i++) {
        lw_super_whole w;
        lw_space_super_whole(f, frame, v, i, lw_v3(0, 0, 0), &w);
        *linear = lw_v3_add(*linear, w.linear);
        *angular = lw_v3_add(*angular, w.angular);
    }
}
