/* mbs/reduced/reduced.c - masses and loads on the steps of the plan; the equation in one coordinate. */
#include "base/real.h"
#include "mbs/reduced/reduced_internal.h"

#include <string.h>

static double at_time(const lw_expression *x, double t)
{
    double v[LW_EXPRESSION_VARIABLE_MAX] = { t };
    return x ? lw_expression_value(x, v) : 0;
}

static double spring_law(const lw_expression *law, double length, double rate, double t)
{
    const int *which;
    double v[LW_EXPRESSION_VARIABLE_MAX];
    int n = lw_expression_variables(law, &which);
    for (int i = 0; i < n; i++)
        v[i] = which[i] == lw_variable(LW_QUANTITY_LENGTH, 0) ? length
             : which[i] == lw_variable(LW_QUANTITY_RATE, 0) ? rate : t;
    return lw_expression_value(law, v);
}

/* Add force f at a place, and a torque, to the loads of a body. */
static void push(lw_reduced *r, int body, lw_vec2 at, lw_vec2 f, double torque)
{
    if (body < 0)
        return;
    lw_wrench *to = &r->load[body];
    to->f = lw_v2_add(to->f, f);
    to->m += lw_v2_cross(at, f) + torque;
}

static double springs(lw_reduced *r, double t, double ds, double *power)
{
    double q = 0;
    for (int i = 0; i < r->model->n_spring; i++) {
        const lw_spring *p = &r->model->spring[i];
        const lw_end_point *end = r->end[i];
        lw_reg1 a = lw_rate_point(r->reg, end[0].origin, end[0].dir, end[0].arm);
        lw_reg1 b = lw_rate_point(r->reg, end[1].origin, end[1].dir, end[1].arm);
        lw_vec2 d = lw_v2_sub(b.p, a.p);
        double l = sqrt(lw_v2_dot(d, d)), by = l > 0 ? lw_v2_dot(d, lw_v2_sub(b.d, a.d))/l : 0, loss = p->damping*by*ds;
        double pull = p->law ? spring_law(p->law, l, by*ds, t) : p->stiffness*(l - p->free) + loss;
        q -= pull*by;
        *power -= (p->law ? pull : loss)*by*ds;
        if (r->friction && l > 0) {
            push(r, end[0].body, a.p, lw_v2_scale(d, pull/l), 0);
            push(r, end[1].body, b.p, lw_v2_scale(d, -pull/l), 0);
        }
    }
    return q;
}

static const lw_reg1 *direction_of(const lw_reduced *r, int body) { return &r->reg[r->centre[body].dir]; }
static double first_direction(const lw_reduced *r, int body) { return body < 0 ? 0 : r->dir0[r->dynamics->s.link[body]]; }

/* Turn of a body since the posture that its rates predict. */
static double predicted_turn(const lw_reduced *r, int body, double s)
{
    return body < 0 ? 0 : r->count.turn[body] + 0.5*(r->count.rate[body] + direction_of(r, body)->d.x)*(s - r->count.at);
}

/* Turns of bodies against others since the posture, so many at once that their arc tangents go through vector instructions. */
enum { TURNS = 16 };
typedef struct turns { int n; double along[TURNS], across[TURNS], first[TURNS], value[TURNS]; } turns;

/* One more: of body b against body a (-1: the ground), near a value. */
static void put_turn(const lw_reduced *r, turns *z, int a, int b, double near)
{
    lw_vec2 u = a < 0 ? lw_v2(1, 0) : direction_of(r, a)->p, v = b < 0 ? lw_v2(1, 0) : direction_of(r, b)->p;
    z->along[z->n] = lw_v2_dot(u, v);
    z->across[z->n] = lw_v2_cross(u, v);
    z->first[z->n] = first_direction(r, b) - first_direction(r, a);
    z->value[z->n++] = near;
}

static void find_turns(turns *z)
{
    for (int i = 0; i < z->n; i++) {
        double off = lw_bearing(z->along[i], z->across[i]) - z->first[i] - z->value[i];
        z->value[i] += off - 2*LW_PI*lw_nearest_integer(off*(0.5/LW_PI));
    }
}

/* Turns of all bodies near those in turn[3 b]. */
static void body_turns(const lw_reduced *r, double *turn)
{
    turns z;
    for (int from = 0, n = r->dynamics->s.n_body; from < n; from += TURNS) {
        z.n = 0;
        for (int b = from; b < n && b < from + TURNS; b++)
            put_turn(r, &z, -1, b, turn[3*b]);
        find_turns(&z);
        for (int i = 0; i < z.n; i++)
            turn[3*(from + i)] = z.value[i];
    }
}

void lw_reduced_count_turns(lw_reduced *r)
{
    double s = r->known, turn[3*LW_LINK_MAX];
    int n = r->dynamics->s.n_body;
    if (!r->counts_turns)
        return;
    for (int b = 0; b < n; b++)
        turn[3*b] = predicted_turn(r, b, s);
    body_turns(r, turn);
    for (int b = 0; b < n; b++) {
        r->count.turn[b] = turn[3*b];
        r->count.rate[b] = direction_of(r, b)->d.x;
    }
    r->count.at = s;
}

/* Measures x of the joints of at most TURNS springs from number `from` on, where their forces depend on them.  Returns their number. */
static int joint_values(const lw_reduced *r, double s, int from, double *x)
{
    int n = r->model->n_joint_spring - from, of[TURNS];
    turns z = { .n = 0 };
    n = n < TURNS ? n : TURNS;
    for (int i = 0; i < n; i++) {
        const lw_joint_spring *p = &r->model->joint_spring[from + i];
        const lw_reduced_joint *j = &r->joint[p->joint];
        const int a = j->body[0], b = j->body[1];
        x[i] = 0;
        if (!p->law && p->stiffness == 0) {
            continue;
        } else if (p->joint == r->linkage.input[0].joint) {
            x[i] = r->sense*(s - r->start);
        } else if (!j->slides) {
            of[z.n] = i;
            put_turn(r, &z, a, b, predicted_turn(r, b, s) - predicted_turn(r, a, s));
        } else {
            const lw_end_point *at = j->point;
            lw_vec2 span = lw_v2_sub(lw_rate_point(r->reg, at[1].origin, at[1].dir, at[1].arm).p,
                                     lw_rate_point(r->reg, at[0].origin, at[0].dir, at[0].arm).p);
            x[i] = j->sign*lw_v2_dot(span, lw_v2_turn(j->along, r->reg[j->dir[0]].p));
        }
    }
    find_turns(&z);
    for (int k = 0; k < z.n; k++)
        x[of[k]] = r->joint[r->model->joint_spring[from + of[k]].joint].sign*z.value[k];
    return n;
}

/* Force along the measure of a joint to the loads of its links. */
static void push_joint(lw_reduced *r, int joint, double force)
{
    const lw_reduced_joint *j = &r->joint[joint];
    const lw_end_point *p = &j->point[1];
    lw_vec2 at = { 0, 0 }, f = { 0, 0 };
    double torque = j->slides ? 0 : j->sign*force;
    if (j->slides) {
        at = lw_rate_point(r->reg, p->origin, p->dir, p->arm).p;
        f = lw_v2_scale(lw_v2_turn(j->along, r->reg[j->dir[0]].p), j->sign*force);
    }
    push(r, j->body[1], at, f, torque);
    push(r, j->body[0], at, lw_v2_scale(f, -1), -torque);
}

/* Springs, dampers and motors of joints. */
static double at_joints(lw_reduced *r, double t, double s, double ds, double *power)
{
    const lw_model *m = r->model;
    double q = 0;
    for (int from = 0, n; from < m->n_joint_spring; from += n) {
        double x[TURNS];
        n = joint_values(r, s, from, x);
        for (int i = 0; i < n; i++) {
            const lw_joint_spring *p = &m->joint_spring[from + i];
            double by = lw_reduced_joint_rate(r, p->joint), v = by*ds;
            double loss = p->law ? spring_law(p->law, x[i], v, t) : -p->damping*v;
            double force = loss - (p->law ? 0 : p->stiffness*(x[i] - p->free));
            q += force*by;
            *power += loss*v;
            if (r->friction)
                push_joint(r, p->joint, force);
        }
    }
    for (int i = 0; i < m->n_motor; i++) {
        double by = lw_reduced_joint_rate(r, m->motor[i].joint), v = by*ds;
        double torque = m->motor[i].stall*(1 - v/m->motor[i].free_speed);
        q += torque*by;
        *power += torque*v;
        if (r->friction)
            push_joint(r, m->motor[i].joint, torque);
    }
    return q;
}

static double forces(lw_reduced *r, double t, double ds, double *power)
{
    double q = 0;
    for (int i = 0; i < r->model->n_force; i++) {
        const lw_force *p = &r->model->force[i];
        const lw_end_point *at = &r->point[i];
        if (at->origin < 0)
            continue;
        lw_vec2 f = lw_v2_unturn(lw_v2(at_time(p->force[0], t), at_time(p->force[1], t)), r->turn);
        double torque = at_time(p->torque[2], t);
        lw_reg1 c = lw_rate_point(r->reg, at->origin, at->dir, at->arm);
        if (p->follows)
            f = lw_v2_turn(f, lw_v2_unturn(r->reg[at->dir].p, lw_v2_polar(1, r->dir0[p->link])));
        q += lw_v2_dot(f, c.d) + torque*r->reg[at->dir].d.x;
        if (r->friction)
            push(r, at->body, c.p, f, torque);
    }
    *power += q*ds;
    return q;
}

/* All loads, weight included, in the coordinates of the bodies. */
static double general_loads(lw_reduced *r, double t, double s, double ds, double *power)
{
    const lw_dynamics *d = r->dynamics;
    double q = 0;
    for (int b = 0; b < d->s.n_body; b++)
        r->q[3*b + 2] = predicted_turn(r, b, s);
    lw_reduced_state(r, d, ds, r->q, r->v);
    lw_forces_apply(&d->f, t, r->q, r->v, r->force, NULL, NULL, power);
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_end_point *p = &r->centre[b];
        lw_reg1 c = lw_rate_point(r->reg, p->origin, p->dir, p->arm);
        const double *from = r->force + 3*b;
        lw_vec2 f = lw_v2_scale(lw_v2_unturn(lw_v2(from[0], from[1]), r->turn), 1/d->s.unit);
        q += lw_v2_dot(f, c.d) + from[2]*r->reg[p->dir].d.x;
        if (r->friction)
            push(r, b, c.p, f, from[2]);
    }
    return q;
}

/* M of the masses at the registers, and Q of their weight. */
static inline double masses(const lw_reduced *r, double *weight)
{
    const lw_reg1 *reg = r->reg;
    double mass = 0, q = 0;
    for (int i = 0; i < r->n_pivot; i++) {
        const lw_mass_point *p = &r->mass[i];
        double w = reg[p->dir].d.x;
        lw_vec2 arm = lw_v2_turn(p->arm, reg[p->dir].p);
        mass += p->inertia*w*w;
        q += w*lw_v2_cross(arm, p->weight);
    }
    for (int i = r->n_pivot; i < r->n_mass; i++) {
        const lw_mass_point *p = &r->mass[i];
        lw_reg1 c = lw_rate_point(reg, p->origin, p->dir, p->arm);
        double w = reg[p->dir].d.x;
        mass += p->mass*lw_v2_dot(c.d, c.d) + p->inertia*w*w;
        q += lw_v2_dot(p->weight, c.d);
    }
    *weight = q;
    return mass;
}

/* The same where there is friction: keeps the centres, and begins the loads with the weights. */
static double masses_each(lw_reduced *r, double *weight)
{
    const lw_dynamics *d = r->dynamics;
    lw_vec2 g = lw_v2_unturn(r->model->gravity, r->turn);
    double mass = 0, q = 0;
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_end_point *p = &r->centre[b];
        const lw_body *body = &r->model->body[d->s.link[b]];
        lw_reg1 c = r->at[b] = lw_rate_point(r->reg, p->origin, p->dir, p->arm);
        double w = r->reg[p->dir].d.x;
        lw_vec2 f = r->general ? lw_v2(0, 0) : lw_v2_scale(g, body->mass);
        mass += body->mass*lw_v2_dot(c.d, c.d) + body->inertia*w*w;
        q += lw_v2_dot(f, c.d);
        r->load[b] = (lw_wrench){ f, lw_v2_cross(c.p, f) };
    }
    *weight = q;
    return mass;
}

lw_status lw_reduced_rate(lw_reduced *r, double t, double s, double p, double *ds, double *dp, double *power)
{
    double q, other = 0;
    lw_status st = lw_reduced_registers(r, s);
    if (st != LW_OK)
        return st;
    double mass = r->friction ? masses_each(r, &q) : masses(r, &q), root = sqrt(mass), rate = p/root;
    if (r->general) {
        q = general_loads(r, t, s, rate, &other);
    } else {
        if (r->model->n_spring)
            q += springs(r, t, rate, &other);
        if (r->model->n_joint_spring || r->model->n_motor)
            q += at_joints(r, t, s, rate, &other);
        if (r->model->n_force)
            q += forces(r, t, rate, &other);
    }
    if (!isfinite(q) || !isfinite(rate))
        return LW_E_NUMERIC;
    if (r->friction && (st = lw_reduced_friction_add(r, t, rate, mass, &q, &other)) != LW_OK)
        return st;
    *ds = rate;
    *dp = q/root;
    *power = other;
    return isfinite(*dp) ? LW_OK : LW_E_NUMERIC;
}

lw_status lw_reduced_mass(lw_reduced *r, double s, double *mass)
{
    double q;
    lw_status st = lw_reduced_registers(r, s);
    *mass = masses(r, &q);
    return st;
}

double lw_reduced_potential(const lw_reduced *r, double s)
{
    double energy = 0;
    for (int i = 0; i < r->n_mass; i++) {
        const lw_mass_point *p = &r->mass[i];
        energy -= lw_v2_dot(p->weight, lw_rate_point(r->reg, p->origin, p->dir, p->arm).p);
    }
    for (int i = 0; i < r->model->n_spring; i++) {
        const lw_spring *p = &r->model->spring[i];
        lw_reg1 a = lw_rate_point(r->reg, r->end[i][0].origin, r->end[i][0].dir, r->end[i][0].arm);
        lw_reg1 b = lw_rate_point(r->reg, r->end[i][1].origin, r->end[i][1].dir, r->end[i][1].arm);
        double l = lw_v2_norm(lw_v2_sub(b.p, a.p)) - p->free;
        energy += p->law ? 0 : 0.5*p->stiffness*l*l;
    }
    for (int from = 0, n; from < r->model->n_joint_spring; from += n) {
        double x[TURNS];
        n = joint_values(r, s, from, x);
        for (int i = 0; i < n; i++) {
            const lw_joint_spring *p = &r->model->joint_spring[from + i];
            energy += p->law ? 0 : 0.5*p->stiffness*(x[i] - p->free)*(x[i] - p->free);
        }
    }
    return energy;
}

void lw_reduced_state(const lw_reduced *r, const lw_dynamics *d, double ds, double *q, double *v)
{
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_end_point *p = &r->centre[b];
        const lw_reg1 *u = &r->reg[p->dir];
        lw_reg1 c = lw_rate_point(r->reg, p->origin, p->dir, p->arm);
        lw_vec2 at = lw_v2_sub(lw_v2_add(r->z0, lw_v2_turn(c.p, r->turn)), d->s.origin);
        lw_vec2 rate = lw_v2_turn(c.d, r->turn);
        q[3*b] = at.x/d->s.unit;
        q[3*b + 1] = at.y/d->s.unit;
        v[3*b] = rate.x*ds/d->s.unit;
        v[3*b + 1] = rate.y*ds/d->s.unit;
        v[3*b + 2] = u->d.x*ds;
    }
    body_turns(r, q + 2);
}

/* p by projection of the velocities in the metric of the masses. */
lw_status lw_reduced_start(lw_reduced *r, const lw_dynamics *d, const double *y, double *s, double *p)
{
    double q[2*LW_SYSTEM_Q_MAX], top = 0, bottom = 0;
    memcpy(q, y, 2*(size_t)d->n_q*sizeof *q);
    lw_status st = lw_reduced_registers(r, r->first);
    if (st != LW_OK)
        return st;
    lw_reduced_state(r, d, 1, q, q + d->n_q);
    for (int i = 0; i < d->n_q; i++) {
        top += d->f.mass[i]*q[d->n_q + i]*y[d->n_q + i];
        bottom += d->f.mass[i]*q[d->n_q + i]*q[d->n_q + i];
    }
    *s = r->first;
    *p = top/sqrt(bottom);
    return LW_OK;
}
