/* mbs/space/space.c - a spatial model as bodies with principal axes, joints with frames, and a posture. */
#include "mbs/space/space.h"

#include <stdlib.h>
#include <string.h>
#include "mbs/elastic/expand_space.h"

void lw_space_free(lw_space *s)
{
    free(s->memory);
    memset(s, 0, sizeof *s);
}

/* One block for all arrays. */
static lw_status reserve(const lw_spatial *m, lw_space *s, lw_error *e)
{
    size_t links = (size_t)m->n_link, joints = (size_t)m->n_joint, tracers = (size_t)m->n_tracer;
    size_t couplings = (size_t)m->n_coupling, terms = 0;
    for (int i = 0; i < m->n_coupling; i++)
        terms += (size_t)m->coupling[i].n;
    size_t bytes = joints*sizeof *s->joint + couplings*sizeof *s->coupling + terms*sizeof *s->coupling->term +
                   (tracers + 1)*(sizeof *s->tracer + sizeof *s->from) +
                   links*sizeof *s->axes + links*14*sizeof(double) + (2*links + 5*terms + couplings)*sizeof(int);
    char *at = s->memory = calloc(1, bytes);
    if (!at)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    s->mass = (double *)(void *)at, at += 6*links*sizeof(double);
    s->rotor = (double *)(void *)at, at += links*sizeof(double);
    s->start = (double *)(void *)at, at += 7*links*sizeof(double);
    s->axes = (lw_quaternion *)(void *)at, at += links*sizeof *s->axes;
    s->tracer = (lw_space_point *)(void *)at, at += (tracers + 1)*sizeof *s->tracer;
    s->from = (lw_mat3 *)(void *)at, at += (tracers + 1)*sizeof *s->from;
    s->joint = (lw_space_joint *)(void *)at, at += joints*sizeof *s->joint;
    s->coupling = (lw_space_coupling *)(void *)at, at += couplings*sizeof *s->coupling;
    for (int i = 0; i < m->n_coupling; i++) {
        s->coupling[i].n = m->coupling[i].n;
        s->coupling[i].term = (lw_space_term *)(void *)at, at += (size_t)m->coupling[i].n*sizeof *s->coupling->term;
    }
    s->body_of = (int *)(void *)at, at += links*sizeof(int);
    s->link_of = (int *)(void *)at, at += links*sizeof(int);
    for (int i = 0; i < m->n_coupling; i++) {            /* two bodies and three parts a term; one place more, which stays -1 */
        s->coupling[i].body = (int *)(void *)at, at += (2*(size_t)m->coupling[i].n + 1)*sizeof(int);
        s->coupling[i].part = (int *)(void *)at, at += 3*(size_t)m->coupling[i].n*sizeof(int);
    }
    return LW_OK;
}

static void make_body(lw_space *s, const lw_spatial_body *p, int link)
{
    const lw_spatial *m = s->model;
    int b = s->n_body++;
    double *q = s->start + 7*b, *mass = s->mass + 6*b;
    lw_vec3 at = p->centre;
    lw_mat3 axes;
    s->body_of[link] = b;
    s->link_of[b] = link;
    for (int j = 0; !p->given && j < m->n_joint; j++)     /* without a mass: at its first joint */
        if (m->joint[j].link[0] == link || m->joint[j].link[1] == link) {
            at = m->joint[j].at;
            break;
        }
    double inertia[6];
    memcpy(inertia, p->inertia, sizeof inertia);
    for (int i = 0; i < m->states.n_rotor; i++) {
        const lw_rotor *r = &m->states.rotor[i];
        lw_vec3 u = m->joint[r->joint].axis;
        const double tensor[6] = { u.x*u.x, u.y*u.y, u.z*u.z, u.x*u.y, u.x*u.z, u.y*u.z };
        if (r->link == link && m->joint[r->joint].kind == LW_SPATIAL_PRISMATIC)
            s->rotor[b] += r->inertia*s->unit*s->unit;
        for (int k = 0; r->link == link && m->joint[r->joint].kind != LW_SPATIAL_PRISMATIC && k < 6; k++)
            inertia[k] += r->inertia*tensor[k];
    }
    mass[0] = mass[1] = mass[2] = p->mass*s->unit*s->unit + s->rotor[b];
    for (int i = 0; i < m->n_super; i++)     /* these weigh by themselves */
        for (int k = 0; k < m->super[i].n; k++)
            s->rotor[b] += m->super[i].link[k] == link ? m->super[i].lump[k]*s->unit*s->unit : 0;
    lw_m3_principal(inertia, mass + 3, &axes);
    double top = fmax(mass[3], fmax(mass[4], mass[5]));
    for (int i = 3; i < 6; i++)
        if (mass[i] < 1e-15*top)
            mass[i] = 0;
    lw_quaternion t = s->axes[b] = lw_quaternion_of_matrix(&axes);
    q[0] = at.x/s->unit, q[1] = at.y/s->unit, q[2] = at.z/s->unit, q[3] = t.w, q[4] = t.x, q[5] = t.y, q[6] = t.z;
}

static lw_vec3 in_body(const lw_space *s, int body, lw_vec3 direction)
{
    if (body < 0)
        return direction;
    lw_mat3 m = lw_quaternion_matrix(s->axes[body]);
    return lw_m3_unapply(&m, direction);
}

lw_space_point lw_space_point_of(const lw_space *s, int link, lw_vec3 at)
{
    int b = s->body_of[link];
    const double *q = s->start + 7*b;
    return (lw_space_point){ b, b < 0 ? at : in_body(s, b, lw_v3_sub(at, lw_v3_scale(lw_v3(q[0], q[1], q[2]), s->unit))) };
}

static lw_vec3 axis_of(const lw_spatial_joint *p) { return lw_v3_norm(p->axis) > 0 ? p->axis : lw_v3(0, 0, 1); }

/* x: a line across the axis. */
static void make_joint(lw_space *s, int i, lw_vec3 x)
{
    const lw_spatial_joint *p = &s->model->joint[i];
    lw_space_joint *j = &s->joint[i];
    lw_vec3 z = axis_of(p), y = lw_v3_cross(z, x);
    j->kind = p->kind;
    j->row = s->n_row;
    s->n_row += lw_spatial_kind_of(p->kind)->rows;
    j->pitch = p->lead/(2*LW_PI);
    for (int k = 0; k < 2; k++) {
        lw_space_point point = lw_space_point_of(s, p->link[k], p->at);
        int b = j->body[k] = point.body;
        j->arm[k] = point.arm;
        j->x[k] = in_body(s, b, x), j->y[k] = in_body(s, b, y), j->z[k] = in_body(s, b, z);
    }
    if (p->kind == LW_SPATIAL_UNIVERSAL) {
        j->x[0] = in_body(s, j->body[0], p->axis);
        j->x[1] = in_body(s, j->body[1], p->second);
        j->fixed = lw_v3_dot(p->axis, p->second);
    }
}

/* Place of a body among those of a coupling; -1: the ground. */
static int side_of(lw_space_coupling *c, int body)
{
    int k = 0;
    while (c->body[k] >= 0 && c->body[k] != body)
        k++;
    c->body[k] = body;
    return body < 0 ? -1 : k;
}

static void add_part(lw_space_coupling *c, int side, bool turns)
{
    int i = 0, part = 2*side + turns;
    while (i < c->n_part && c->part[i] != part)
        i++;
    if (side >= 0 && i == c->n_part)
        c->part[c->n_part++] = part;
}

static void make_coupling(lw_space *s, int i)
{
    const lw_spatial_coupling *p = &s->model->coupling[i];
    lw_space_coupling *c = &s->coupling[i];
    for (int k = 0; k <= 2*p->n; k++)
        c->body[k] = -1;
    for (int k = 0; k < p->n; k++) {
        lw_space_term *t = &c->term[k];
        bool turn = p->of[k].of == LW_OF_TURN;
        *t = (lw_space_term){ .joint = s->joint[p->of[k].index], .turn = turn, .index = p->of[k].index,
                              .factor = p->factor[k]*(turn ? 1 : s->unit) };
        for (int end = 0; end < 2; end++)
            t->side[end] = side_of(c, t->joint.body[end]);
        if (!turn && t->side[1] >= 0) {
            const lw_spatial_joint *j = &s->model->joint[t->index];
            const double *q = s->start + 7*t->joint.body[1];
            t->joint.arm[1] = lw_v3(0, 0, 0);
            t->start = lw_v3_dot(j->axis, lw_v3_sub(lw_v3(q[0], q[1], q[2]), lw_v3_scale(j->at, 1/s->unit)));
        }
        add_part(c, t->side[0], true);
        add_part(c, t->side[1], turn);
        if (!turn)
            add_part(c, t->side[0], false);
        c->most = fmax(c->most, fabs(t->factor));
    }
    for (int k = 0; k < c->n; k++)
        c->term[k].factor /= c->most;
    for (c->n_side = 2; c->body[c->n_side] >= 0;)
        c->n_side++;
    s->n_side = c->n_side > s->n_side ? c->n_side : s->n_side;
    s->n_term = c->n > s->n_term ? c->n : s->n_term;
}

void lw_space_joints(lw_space *s, const lw_spatial_joint *drawn)
{
    s->n_row = 0;
    for (int i = 0; i < s->n_joint; i++) {
        lw_vec3 z = axis_of(&s->model->joint[i]), x = lw_v3_across(axis_of(&drawn[i]));
        x = lw_v3_sub(x, lw_v3_scale(z, lw_v3_dot(z, x)));
        make_joint(s, i, lw_v3_scale(x, 1/lw_v3_norm(x)));
    }
}

lw_status lw_space_make(const lw_spatial *m, lw_space *s, lw_error *e)
{
    memset(s, 0, sizeof *s);
    s->model = m;
    s->unit = lw_spatial_size(m);
    s->n_joint = m->n_joint;
    lw_status st = reserve(m, s, e);
    if (st != LW_OK)
        return st;
    lw_spatial rigid = { .body = m->body };
    if (m->n_elastic > 0 && (st = lw_spatial_rigid(m, &rigid, e)) != LW_OK) {
        lw_space_free(s);
        return st;
    }
    s->body_of[m->ground] = -1;
    for (int i = 0; i < m->n_link; i++)
        if (i != m->ground)
            make_body(s, &rigid.body[i], i);
    if (m->n_elastic > 0)
        lw_spatial_rigid_free(&rigid);
    s->n_q = 7*s->n_body;
    s->n_v = 6*s->n_body;
    for (int i = 0; i < m->n_joint; i++)
        make_joint(s, i, lw_v3_across(axis_of(&m->joint[i])));
    for (int i = 0; i < m->n_tracer; i++) {
        s->tracer[i] = lw_space_point_of(s, m->tracer[i].link, m->tracer[i].at);
        s->from[i] = lw_quaternion_matrix(s->tracer[i].body >= 0 ? s->axes[s->tracer[i].body] : (lw_quaternion){ 1, 0, 0, 0 });
    }
    s->n_joint_row = s->n_row;
    s->n_side = s->n_term = 2;
    for (; s->n_coupling < m->n_coupling; s->n_coupling++, s->n_row++)
        make_coupling(s, s->n_coupling);
    return LW_OK;
}

void lw_space_place(const lw_space *s, const double *q, lw_space_frame *frame)
{
    frame[0] = (lw_space_frame){ { 0, 0, 0 }, { { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } } };
    for (int b = 0; b < s->n_body; b++, q += 7) {
        frame[b + 1].at = lw_v3_scale(lw_v3(q[0], q[1], q[2]), s->unit);
        frame[b + 1].turn = lw_quaternion_matrix((lw_quaternion){ q[3], q[4], q[5], q[6] });
    }
}

lw_vec3 lw_space_point_at(const lw_space_frame *frame, lw_space_point p)
{
    const lw_space_frame *f = &frame[p.body + 1];
    return lw_v3_add(f->at, lw_m3_apply(&f->turn, p.arm));
}

lw_vec3 lw_space_omega(const lw_space_frame *frame, int body, const double *v)
{
    return body < 0 ? lw_v3(0, 0, 0) : lw_m3_apply(&frame[body + 1].turn, lw_v3(v[6*body + 3], v[6*body + 4], v[6*body + 5]));
}

lw_vec3 lw_space_point_velocity(const lw_space *s, const lw_space_frame *frame, lw_space_point p, const double *v)
{
    if (p.body < 0)
        return lw_v3(0, 0, 0);
    const double *at = v + 6*p.body;
    lw_vec3 turn = lw_m3_apply(&frame[p.body + 1].turn, lw_v3_cross(lw_v3(at[3], at[4], at[5]), p.arm));
    return lw_v3_add(lw_v3_scale(lw_v3(at[0], at[1], at[2]), s->unit), turn);
}

void lw_space_move(const lw_space *s, double *q, const double *by)
{
    for (int b = 0; b < s->n_body; b++, q += 7, by += 6) {
        q[0] += by[0], q[1] += by[1], q[2] += by[2];
        lw_quaternion t = lw_quaternion_unit(lw_quaternion_times((lw_quaternion){ q[3], q[4], q[5], q[6] },
                                               lw_quaternion_of_vector(lw_v3(by[3], by[4], by[5]))));
        q[3] = t.w, q[4] = t.x, q[5] = t.y, q[6] = t.z;
    }
}

/* Turned by exp(z), z' = w: omega = w - (1 - cos f)/f^2 z x w + (f - sin f)/f^3 z x (z x w) with f = |z|. */
void lw_space_along(const lw_space *s, const double *by, double *rate)
{
    for (int b = 0; b < s->n_body; b++, by += 6, rate += 6) {
        lw_vec3 z = lw_v3(by[3], by[4], by[5]), w = lw_v3(rate[3], rate[4], rate[5]), across = lw_v3_cross(z, w);
        double f2 = lw_v3_dot(z, z), f = sqrt(f2);
        double first = f2 < 1e-3 ? 0.5 - f2*(1./24 - f2*(1./720 - f2/40320)) : (1 - cos(f))/f2;
        double second = f2 < 1e-3 ? 1./6 - f2*(1./120 - f2*(1./5040 - f2/362880)) : (f - sin(f))/(f*f2);
        w = lw_v3_add(lw_v3_sub(w, lw_v3_scale(across, first)), lw_v3_scale(lw_v3_cross(z, across), second));
        rate[3] = w.x, rate[4] = w.y, rate[5] = w.z;
    }
}

void lw_space_rates(const lw_space *s, const double *q, const double *v, double *dq)
{
    for (int b = 0; b < s->n_body; b++, q += 7, v += 6, dq += 7) {
        lw_quaternion t = lw_quaternion_times((lw_quaternion){ q[3], q[4], q[5], q[6] }, (lw_quaternion){ 0, v[3]/2,
                v[4]/2, v[5]/2 });
        dq[0] = v[0], dq[1] = v[1], dq[2] = v[2], dq[3] = t.w, dq[4] = t.x, dq[5] = t.y, dq[6] = t.z;
    }
}

void lw_space_normalise(const lw_space *s, double *q)
{
    for (int b = 0; b < s->n_body; b++, q += 7) {
        lw_quaternion t = lw_quaternion_unit((lw_quaternion){ q[3], q[4], q[5], q[6] });
        q[3] = t.w, q[4] = t.x, q[5] = t.y, q[6] = t.z;
    }
}
