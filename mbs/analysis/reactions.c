#include "mbs/analysis/reactions.h"
#include "mbs/dynamics/touch_internal.h"

#include <string.h>
#include "base/real.h"

/* l times the entry of a row; 0 where the row has none, though its l has no limit in a singular posture. */
static double share_of(double l, double entry) { return entry != 0 ? l*entry : 0; }

/* -J^T l of n rows on one body: force, and moment about its reference point. */
static lw_reaction on_body(const lw_dynamics *d, const double *l, int first, int n, int body)
{
    const lw_system *s = &d->s;
    lw_reaction r = { { 0, 0 }, 0 };
    for (int k = first; k < first + n; k++) {
        int slot = 0;
        while (lw_mbs_blocks(d, k)[slot] != body)
            slot++;
        const double *row = lw_mbs_jac(d, k) + 3*slot;
        r.force.x -= share_of(l[k], row[0])/s->unit;
        r.force.y -= share_of(l[k], row[1])/s->unit;
        r.moment -= share_of(l[k], row[2]);
    }
    return r;
}

void lw_reactions_joints(const lw_dynamics *d, const lw_moment *m, lw_reaction *out)
{
    const lw_system *s = lw_dynamics_system(d);
    lw_mbs_system_rows(d, m->q);
    for (int j = 0; j < s->n_joint; j++) {
        const lw_system_joint *p = &s->joint[j];
        int end = p->body[1] >= 0 ? 1 : 0, body = p->body[end], n = lw_joint_equations(p->kind);
        lw_reaction r = on_body(d, m->l, p->row, n, body);
        /* link[1] receives the opposite of what acts on link[0] */
        double sign = end == 1 ? 1 : -1;
        lw_vec2 at = lw_system_point(s, lw_joint_has_ratio(p->kind) ? p->carrier : p->body[1], p->arm[1], m->q);
        lw_vec2 centre = lw_system_point(s, body, lw_v2(0, 0), m->q);
        out[j].force = lw_v2_scale(r.force, sign);
        bool turns = !lw_joint_holds_rotation(p->kind) && !lw_joint_has_ratio(p->kind);
        out[j].moment = turns ? 0 : sign*(r.moment - lw_v2_cross(lw_v2_sub(at, centre), r.force));
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
    double *more = f->superelements.out;
    for (int i = 0; more && i < s->n_q; i++)
        more[i] = 0;
    lw_superelements_inertia(&f->superelements, m->q, m->v, m->a, more);
    for (int b = 0; more && b < s->n_body; b++) {
        lw_vec2 at = lw_system_point(s, b, lw_v2(0, 0), m->q), pull = lw_v2_scale(lw_v2(more[3*b], more[3*b + 1]), -1/s->unit);
        r.force = lw_v2_add(r.force, pull);
        r.moment += lw_v2_cross(at, pull) - more[3*b + 2];
    }
    return r;
}

/* Force of the line loads that an element passes on to a node; *about: their moment there. */
static lw_vec2 line_loads(const lw_dynamics *d, const lw_moment *m, int element, int link, double *about)
{
    const lw_forces *f = lw_dynamics_forces(d);
    lw_vec2 sum = { 0, 0 };
    *about = 0;
    for (int i = 0; i < f->model->n_force; i++) {
        double moment;
        if (f->model->force[i].part != element + 1 || f->model->force[i].link != link)
            continue;
        sum = lw_v2_add(sum, lw_forces_applied(f, i, m->t, m->q, m->v, &moment));
        *about += moment;
    }
    return sum;
}

/* Force and moment of an element or a piece of a condensed bar on its node at one end, and the direction of the section there in the posture. */
static double load_of(const lw_dynamics *d, const lw_moment *m, const lw_elastic_chain *c, int element, int end, double on[3])
{
    const lw_forces *f = lw_dynamics_forces(d);
    if (!c->condensed) {
        lw_beam_state z;
        lw_forces_beam(f, element, m->q, m->v, false, &z);
        memcpy(on, z.force + 3*end, 3*sizeof *on);
        return f->model->beam[element].direction;
    }
    lw_superelements_end(&f->superelements, m->q, m->v, m->a, element, end, on);
    lw_vec3 along = lw_m3_column(&f->model->super[element].section[end], 0);
    return atan2(along.y, along.x);
}

/* What an element and its line loads do to the node at either end, along and across the section there, which turns with the node: in
 * the element's own axes the ends of a bent element would have parts of each other, a clamp not its reaction. */
void lw_reactions_inner(const lw_dynamics *d, const lw_moment *m, int chain, lw_inner_force *out)
{
    const lw_elastic_chain *c = &lw_dynamics_elastic(d)->chain[chain];
    const lw_forces *f = lw_dynamics_forces(d);
    for (int i = 0; i < c->n_node; i++)
        out[i] = c->elastic->n_node == 0 && i < c->n_bound ? (lw_inner_force){ 0 } : (lw_inner_force){ NAN, NAN, NAN, NAN };
    for (int i = 0; c->elastic->n_node == 0 && i + 1 < c->n_bound; i++) {
        int element = c->first_beam + i;
        for (int end = 0; end < 2; end++) {
            lw_inner_force *to = &out[i + end];
            double on[3], direction = load_of(d, m, c, element, end, on);
            double share = i + end == 0 || i + end == c->n_bound - 1 ? 1 : 0.5, sign = end ? -1 : 1, about;
            int body = f->system->body[c->node[i + end]];
            lw_vec2 load = line_loads(d, m, element, c->node[i + end], &about);
            lw_vec2 along = lw_v2_polar(1, direction + (body < 0 ? 0 : m->q[3*body + 2]));
            lw_vec2 force = lw_v2_add(lw_v2(on[0], on[1]), load);
            double normal = sign*lw_v2_dot(force, along), moment = sign*(on[2] + about);
            double stress = lw_section_stress(&c->elastic->section, normal, moment);
            to->normal += share*normal;
            to->shear += share*sign*lw_v2_cross(along, force);
            to->moment += share*moment;
            to->stress = fabs(stress) <= fabs(to->stress) ? to->stress : stress;
        }
    }
}

void lw_reactions_contacts(const lw_dynamics *d, const lw_moment *m, lw_vec2 *contact, double *rope)
{
    const lw_model *model = d->model;
    for (int i = 0; i < model->n_contact; i++)
        contact[i] = lw_v2(0, 0);
    for (int i = 0; i < model->n_rope; i++)
        rope[i] = 0;
    if (d->touch)
        lw_mbs_system_rows(d, m->q);
    for (int i = 0; d->touch && i < d->touch->list.n; i++) {
        lw_vec2 f;
        double normal = lw_mbs_touch_load(d, i, d->o.analysis == LW_ANALYSIS_QUASISTATIC ? NULL : m->v, m->l, &f);
        const lw_touch *p = &d->touch->list.touch[i];
        if (p->kind == LW_TOUCH_ROPE)
            rope[p->owner] += normal;
        else if (p->kind != LW_TOUCH_STOP) {     /* f acts on link 0 of the place; the columns are of link 1 of the contact */
            bool second = model->contact[p->owner].link[1] != p->link;
            contact[p->owner] = lw_v2_add(contact[p->owner], lw_v2_scale(f, second ? -1 : 1));
        }
    }
}
