#include "mbs/dynamics/reactions.h"

#include <math.h>
#include <string.h>

/* -J^T l of some rows on one body: force, and moment about its reference point. */
static lw_reaction on_body(const lw_system *s, const double *jac, const double *l, int first, int n, int body)
{
    lw_reaction r = { { 0, 0 }, 0 };
    for (int k = first; k < first + n; k++) {
        const double *row = jac + k*s->n_q + 3*body;
        r.force.x -= l[k]*row[0]/s->unit;
        r.force.y -= l[k]*row[1]/s->unit;
        r.moment -= l[k]*row[2];
    }
    return r;
}

void lw_reactions_joints(const lw_dynamics *d, const lw_moment *m, lw_reaction *out)
{
    const lw_system *s = lw_dynamics_system(d);
    double jac[3*LW_SYSTEM_Q_MAX], phi[3];
    for (int j = 0; j < s->n_joint; j++) {
        const lw_system_joint *p = &s->joint[j];
        int end = p->body[1] >= 0 ? 1 : 0, body = p->body[end], n = lw_joint_equations(p->kind);
        lw_dynamics_joint_rows(d, j, m->q, phi, jac);
        lw_reaction r = on_body(s, jac, m->l + p->row, 0, n, body);
        /* link[1] receives the opposite of what acts on link[0] */
        double sign = end == 1 ? 1 : -1;
        lw_vec2 at = lw_system_point(s, lw_joint_has_ratio(p->kind) ? p->carrier : p->body[1], p->arm[1], m->q);
        lw_vec2 centre = lw_system_point(s, body, lw_v2(0, 0), m->q);
        out[j].force = lw_v2_scale(r.force, sign);
        out[j].moment = sign*(r.moment - lw_v2_cross(lw_v2_sub(at, centre), r.force));
    }
}

static double input_unit(const lw_system *s, int input)
{
    return lw_system_joint_unit(s, s->input_joint[input]);
}

void lw_reactions_driving(const lw_dynamics *d, const lw_moment *m, double *out)
{
    const lw_system *s = lw_dynamics_system(d);
    const lw_model *model = lw_dynamics_forces(d)->model;
    int row = s->n_row;
    for (int i = 0; i < s->n_input; i++) {
        out[i] = model->motion[i] ? -m->l[row++]/input_unit(s, i) : 0;
    }
    for (int i = 0; i < s->n_tie; i++) {                     /* (h_tied - ratio h_first)/(1 + |ratio|) = 0 */
        double pull = -m->l[s->tie_row + i]/(1 + fabs(s->tie[i]));
        out[s->n_input + i] = pull/input_unit(s, s->n_input + i);
        out[0] -= s->tie[i]*pull/input_unit(s, 0);
    }
}

lw_reaction lw_reactions_shaking(const lw_dynamics *d, const lw_moment *m)
{
    const lw_system *s = lw_dynamics_system(d);
    const lw_forces *f = lw_dynamics_forces(d);
    lw_reaction r = { { 0, 0 }, 0 };
    for (int b = 0; b < s->n_body; b++) {
        double mass = f->mass[3*b]/(s->unit*s->unit);
        lw_vec2 at = lw_system_point(s, b, lw_v2(0, 0), m->q);
        lw_vec2 pull = lw_v2_scale(lw_v2(m->a[3*b], m->a[3*b + 1]), -mass*s->unit);
        r.force = lw_v2_add(r.force, pull);
        r.moment += lw_v2_cross(at, pull) - f->mass[3*b + 2]*m->a[3*b + 2];
    }
    return r;
}
