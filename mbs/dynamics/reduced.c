/* mbs/dynamics/reduced.c - the steps of the plan with derivatives by the input; masses and loads on them.
 *
 * The velocities of a dyad are linear in those of the links it is joined to.  For RRR, c = a + r1 u1 = b + r2 u2, x =
 * cross(u1, u2):
 *     r1 x w1 = (b' - a').u2,    r2 x w2 = (b' - a').u1. */
#include "base/real.h"
#include "mbs/dynamics/reduced_internal.h"

#include <string.h>
#include "mbs/plan/dyad_internal.h"

static const double closed = 1e-12;          /* a margin below this: a dead point */

static inline lw_reg1 direction(lw_vec2 u, double w) { return (lw_reg1){ u, { w, 0 } }; }

/* a + r u */
static inline lw_reg1 arm_end(const lw_reg1 *a, const lw_reg1 *u, double r)
{
    double w = r*u->d.x;
    return (lw_reg1){ lw_v2_add(a->p, lw_v2_scale(u->p, r)), lw_v2(a->d.x - w*u->p.y, a->d.y + w*u->p.x) };
}

/* One square root and beside it one division; the places need nothing else.  With (b - a)^2 = d2 and y = mode
 * sqrt(h) as in mbs/plan/dyad_internal.h, r1 r2 cross(u1, u2) = y/2. */
static double rates_rrr(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *b = &reg[st->in[1]];
    lw_vec2 span = lw_joint_span(a->p, b->p), e = lw_v2_sub(b->d, a->d);
    double d2 = lw_v2_dot(span, span), h = (st->sum2 - d2)*(d2 - st->dif2);
    double y = mode*sqrt(h > 0 ? h : 0), over_d2 = 0.5/d2, over_y = 2/y;
    lw_vec2 u1 = lw_v2_scale(lw_v2_turn(span, lw_v2(d2 + st->product, y)), over_d2*st->inv1);
    lw_vec2 u2 = lw_v2_scale(lw_v2_turn(span, lw_v2(st->product - d2, y)), over_d2*st->inv2);
    reg[st->out[0]] = direction(u1, st->r2*over_y*lw_v2_dot(e, u2));
    if (st->out[1] >= 0)
        reg[st->out[1]] = direction(u2, st->r1*over_y*lw_v2_dot(e, u1));
    reg[st->out[2]] = arm_end(a, &reg[st->out[0]], st->r1);
    return d2 > 2*LW_TINY2 ? h*st->flat : fmin(h*st->flat, 0);
}

/* With t = (c - q).w the place on the line and n = i w:   r (u.w) w1 = (q' - a').n + t ww. */
static double rates_rrp(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *q = &reg[st->in[1]], *w = &reg[st->in[2]];
    lw_rrp z = lw_rrp_solve_along(a->p, q->p, w->p, st->r1, mode);
    lw_vec2 u = lw_rrp_direction(&z), n = lw_v2_perp(w->p);
    double t = lw_v2_dot(lw_v2_sub(lw_v2_add(a->p, z.arm), q->p), w->p);
    double top = lw_v2_dot(lw_v2_sub(q->d, a->d), n) + t*w->d.x;
    reg[st->out[0]] = direction(u, top/(st->r1*lw_v2_dot(u, w->p)));
    reg[st->out[1]] = arm_end(a, &reg[st->out[0]], st->r1);
    return lw_rrp_margin(&z);
}

/* With t = (b - a).u:   t w = (b' - a').n. */
static double rates_rpr(const lw_dyad_step *st, double mode, lw_reg1 *reg)
{
    const lw_reg1 *a = &reg[st->in[0]], *b = &reg[st->in[1]];
    lw_rpr z = lw_rpr_solve(a->p, b->p, st->r1, mode);
    double t = lw_v2_dot(lw_v2_sub(b->p, a->p), z.u);
    reg[st->out[0]] = direction(z.u, lw_v2_cross(z.u, lw_v2_sub(b->d, a->d))/t);
    return lw_rpr_margin(&z);
}

/* c on both lines:  (c' - q2').n2 = t2 w2,  c = q1 + t1 w1. */
static double rates_prp(const lw_dyad_step *st, lw_reg1 *reg)
{
    const lw_reg1 *q1 = &reg[st->in[0]], *w1 = &reg[st->in[1]], *q2 = &reg[st->in[2]], *w2 = &reg[st->in[3]];
    lw_prp z = lw_prp_solve(q1->p, w1->p, q2->p, w2->p);
    lw_vec2 n1 = lw_v2_perp(w1->p), n2 = lw_v2_perp(w2->p);
    double t2 = lw_v2_dot(lw_v2_sub(z.c, q2->p), w2->p), a1 = z.t1*w1->d.x;
    double dt1 = -z.inv*(t2*w2->d.x + lw_v2_dot(lw_v2_sub(q2->d, q1->d), n2) - a1*lw_v2_dot(n1, n2));
    reg[st->out[0]] = (lw_reg1){ z.c, lw_v2_add(q1->d, lw_v2_add(lw_v2_scale(w1->p, dt1), lw_v2_scale(n1, a1))) };
    return lw_prp_margin(&z);
}

/* ---- across a change point ------------------------------------------------------------------------ */

static lw_reg1 bridged(const double *c, double x, double reach)
{
    double v = 0, d = 0;
    for (int k = LW_BRIDGE_SIZE - 1; k >= 0; k--) {
        d = d*x + v;
        v = v*x + c[k];
    }
    return direction(lw_v2_polar(1, v), d/reach);
}

static void bridge_step(const lw_dyad_step *st, const lw_change_point *t, const lw_bridge *b, double input,
                        lw_reg1 *reg)
{
    double x = (input - t->at)/t->reach;
    reg[st->out[0]] = bridged(b->c[0], x, t->reach);
    if (st->kind == LW_STEP_RRR) {
        if (st->out[1] >= 0)
            reg[st->out[1]] = bridged(b->c[1], x, t->reach);
        reg[st->out[2]] = arm_end(&reg[st->in[0]], &reg[st->out[0]], st->r1);
    } else if (st->kind == LW_STEP_RRP) {
        reg[st->out[1]] = arm_end(&reg[st->in[0]], &reg[st->out[0]], st->r1);
    }
}

/* ---- all steps ------------------------------------------------------------------------------------- */

static const lw_bridge *bridge_of(const lw_change_point *t, const lw_dyad_step *st)
{
    for (int i = 0; t && i < t->n_bridge; i++)
        if (st->kind >= LW_STEP_RRR && t->bridge[i].dyad == st->dyad)
            return &t->bridge[i];
    return NULL;
}

static inline double evaluate_step(const lw_dyad_step *st, const double *mode, double input, lw_reg1 *reg)
{
    double c, s;
    switch (st->kind) {
    case LW_STEP_INPUT_PIN:
        sincos(input, &s, &c);
        reg[st->out[0]] = direction(lw_v2(c, s), 1);
        return 1;
    case LW_STEP_INPUT_SLIDE:
        reg[st->out[0]] = (lw_reg1){ lw_frame_point(reg[st->in[0]].p, reg[st->in[1]].p, input, 0), reg[st->in[1]].p };
        return 1;
    case LW_STEP_POINT:
        reg[st->out[0]] = lw_reduced_point(reg, st->in[0], st->in[1], st->at);
        return 1;
    case LW_STEP_LINE:
        reg[st->out[1]] = direction(lw_v2_turn(st->line, reg[st->in[1]].p), reg[st->in[1]].d.x);
        reg[st->out[0]] = lw_reduced_point(reg, st->in[0], st->out[1], st->at);
        return 1;
    case LW_STEP_RRR: return rates_rrr(st, mode[st->dyad], reg);
    case LW_STEP_RRP: return rates_rrp(st, mode[st->dyad], reg);
    case LW_STEP_RPR: return rates_rpr(st, mode[st->dyad], reg);
    case LW_STEP_PRP:
    case LW_STEP_PPR: return rates_prp(st, reg);
    case LW_STEP_HIGHER: case LW_STEP_TURN: case LW_STEP_SLIDE: case LW_STEP_GEAR: case LW_STEP_ALONG:
    case LW_STEP_ROLL:
    case LW_STEP_RACK: break;                              /* not in plans of dyads alone */
    }
    return 1;
}

void lw_reduced_plain(lw_reduced *r, const double *mode, const lw_change_point *bridge, double input, double *margin_of,
                      double *margin)
{
    lw_reg1 *reg = r->reg;
    *margin = 1;
    r->known = NAN;
    for (int i = 0; i < r->n_step; i++) {
        const lw_dyad_step *st = &r->step[i];
        const lw_bridge *b = bridge ? bridge_of(bridge, st) : NULL;
        double m = 1;
        if (b)
            bridge_step(st, bridge, b, input, reg);
        else
            m = evaluate_step(st, mode, input, reg);
        *margin = m < *margin ? m : *margin;
        if (margin_of && st->kind >= LW_STEP_RRR)
            margin_of[st->dyad] = m;
    }
}

/* Index of the piece that holds an input; *input is moved into the range scanned. */
static int find_piece(const lw_reduced *r, double *input, const lw_change_point **near)
{
    *near = NULL;
    if (r->period > 0)
        *input -= r->period*floor((*input - r->low)/r->period);
    int i = 0;
    while (i < r->n_change && *input >= r->change[i].at)
        i++;
    for (int k = i - 1; k <= i; k++)
        if (k >= 0 && k < r->n_change && fabs(*input - r->change[k].at) < r->change[k].reach)
            *near = &r->change[k];
    return i;
}

lw_status lw_reduced_registers(lw_reduced *r, double input)
{
    const lw_change_point *near = NULL;
    const double *mode = r->mode;
    double margin, at = input;
    if (input == r->known)
        return LW_OK;
    if (r->n_change) {
        int piece = find_piece(r, &at, &near);
        mode = r->piece_mode[piece];
    }
    if (r->period == 0 && (at < r->low || at > r->high))
        return LW_OPEN;
    lw_reduced_plain(r, mode, near, at, NULL, &margin);
    if (!(margin > closed))
        return LW_OPEN;
    r->known = input;
    return LW_OK;
}

/* ---- masses and loads ------------------------------------------------------------------------------ */

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
        lw_reg1 a = lw_reduced_point(r->reg, end[0].origin, end[0].dir, end[0].arm);
        lw_reg1 b = lw_reduced_point(r->reg, end[1].origin, end[1].dir, end[1].arm);
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

/* Turn of a body since the posture, near the one that its rates predict. */
static double turn_of(const lw_reduced *r, int body, double s)
{
    if (body < 0)
        return 0;
    const lw_reg1 *u = &r->reg[r->centre[body].dir];
    double near = r->count.turn[body] + 0.5*(r->count.rate[body] + u->d.x)*(s - r->count.at);
    double turn = atan2(u->p.y, u->p.x) - r->dir0[r->dynamics->s.link[body]] - near;
    return near + turn - 2*LW_PI*rint(turn/(2*LW_PI));
}

void lw_reduced_count_turns(lw_reduced *r)
{
    double s = r->known;
    for (int b = 0; r->counts_turns && b < r->dynamics->s.n_body; b++) {
        r->count.turn[b] = turn_of(r, b, s);
        r->count.rate[b] = r->reg[r->centre[b].dir].d.x;
    }
    r->count.at = s;
}

double lw_reduced_joint_rate(const lw_reduced *r, int joint)
{
    const lw_reduced_joint *j = &r->joint[joint];
    if (!j->slides)
        return j->sign*(r->reg[j->dir[1]].d.x - r->reg[j->dir[0]].d.x);
    const lw_end_point *p = j->point;
    lw_reg1 a = lw_reduced_point(r->reg, p[0].origin, p[0].dir, p[0].arm);
    lw_reg1 b = lw_reduced_point(r->reg, p[1].origin, p[1].dir, p[1].arm);
    return j->sign*lw_v2_dot(lw_v2_sub(b.d, a.d), lw_v2_turn(j->along, r->reg[j->dir[0]].p));
}

double lw_reduced_joint_value(const lw_reduced *r, int joint, double s)
{
    const lw_reduced_joint *j = &r->joint[joint];
    if (joint == r->linkage.input[0].joint)
        return r->sense*(s - r->start);
    if (!j->slides)
        return j->sign*(turn_of(r, j->body[1], s) - turn_of(r, j->body[0], s));
    const lw_end_point *p = j->point;
    lw_reg1 a = lw_reduced_point(r->reg, p[0].origin, p[0].dir, p[0].arm);
    lw_reg1 b = lw_reduced_point(r->reg, p[1].origin, p[1].dir, p[1].arm);
    return j->sign*lw_v2_dot(lw_v2_sub(b.p, a.p), lw_v2_turn(j->along, r->reg[j->dir[0]].p));
}

/* Force along the measure of a joint to the loads of its links. */
static void push_joint(lw_reduced *r, int joint, double force)
{
    const lw_reduced_joint *j = &r->joint[joint];
    const lw_end_point *p = &j->point[1];
    lw_vec2 at = { 0, 0 }, f = { 0, 0 };
    double torque = j->slides ? 0 : j->sign*force;
    if (j->slides) {
        at = lw_reduced_point(r->reg, p->origin, p->dir, p->arm).p;
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
    for (int i = 0; i < m->n_joint_spring; i++) {
        const lw_joint_spring *p = &m->joint_spring[i];
        double by = lw_reduced_joint_rate(r, p->joint), v = by*ds;
        double x = p->law || p->stiffness != 0 ? lw_reduced_joint_value(r, p->joint, s) : 0;
        double loss = p->law ? spring_law(p->law, x, v, t) : -p->damping*v;
        double force = loss - (p->law ? 0 : p->stiffness*(x - p->free));
        q += force*by;
        *power += loss*v;
        if (r->friction)
            push_joint(r, p->joint, force);
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
        lw_vec2 f = lw_v2_unturn(lw_v2(at_time(p->fx, t), at_time(p->fy, t)), r->turn);
        double torque = at_time(p->torque, t);
        lw_reg1 c = lw_reduced_point(r->reg, at->origin, at->dir, at->arm);
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
        r->q[3*b + 2] = turn_of(r, b, s);
    lw_reduced_state(r, d, ds, r->q, r->v);
    lw_forces_apply(&d->f, t, r->q, r->v, r->force, NULL, NULL, power);
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_end_point *p = &r->centre[b];
        lw_reg1 c = lw_reduced_point(r->reg, p->origin, p->dir, p->arm);
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
        lw_reg1 c = lw_reduced_point(reg, p->origin, p->dir, p->arm);
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
        lw_reg1 c = r->at[b] = lw_reduced_point(r->reg, p->origin, p->dir, p->arm);
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
    if (r->friction && (st = lw_reduced_friction_add(r, rate, mass, &q, &other)) != LW_OK)
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
        energy -= lw_v2_dot(p->weight, lw_reduced_point(r->reg, p->origin, p->dir, p->arm).p);
    }
    for (int i = 0; i < r->model->n_spring; i++) {
        const lw_spring *p = &r->model->spring[i];
        lw_reg1 a = lw_reduced_point(r->reg, r->end[i][0].origin, r->end[i][0].dir, r->end[i][0].arm);
        lw_reg1 b = lw_reduced_point(r->reg, r->end[i][1].origin, r->end[i][1].dir, r->end[i][1].arm);
        double l = lw_v2_norm(lw_v2_sub(b.p, a.p)) - p->free;
        energy += p->law ? 0 : 0.5*p->stiffness*l*l;
    }
    for (int i = 0; i < r->model->n_joint_spring; i++) {
        const lw_joint_spring *p = &r->model->joint_spring[i];
        double x = p->law || p->stiffness == 0 ? 0 : lw_reduced_joint_value(r, p->joint, s) - p->free;
        energy += p->law ? 0 : 0.5*p->stiffness*x*x;
    }
    return energy;
}

void lw_reduced_state(const lw_reduced *r, const lw_dynamics *d, double ds, double *q, double *v)
{
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_end_point *p = &r->centre[b];
        const lw_reg1 *u = &r->reg[p->dir];
        lw_reg1 c = lw_reduced_point(r->reg, p->origin, p->dir, p->arm);
        lw_vec2 at = lw_v2_sub(lw_v2_add(r->z0, lw_v2_turn(c.p, r->turn)), d->s.origin);
        lw_vec2 rate = lw_v2_turn(c.d, r->turn);
        double turn = atan2(u->p.y, u->p.x) - r->dir0[d->s.link[b]];
        q[3*b] = at.x/d->s.unit;
        q[3*b + 1] = at.y/d->s.unit;
        turn -= q[3*b + 2];
        q[3*b + 2] += turn - 2*LW_PI*rint(turn/(2*LW_PI));
        v[3*b] = rate.x*ds/d->s.unit;
        v[3*b + 1] = rate.y*ds/d->s.unit;
        v[3*b + 2] = u->d.x*ds;
    }
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
