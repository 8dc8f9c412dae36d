/* mbs/reduced/make.c - can one coordinate describe a model?  Its parts on the registers of the plan. */
#include "base/real.h"
#include "mbs/reduced/reduced_internal.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WHY_SIZE sizeof ((lw_dynamics *)0)->not_reduced

static lw_status no(char *why, const char *text)
{
    snprintf(why, WHY_SIZE, "%s", text);
    return LW_E_KIND;
}

/* ---- what it can do --------------------------------------------------------------------------------- */

static bool of_time_alone(const lw_expression *x)
{
    const int *which;
    int n = x ? lw_expression_variables(x, &which) : 0;
    for (int i = 0; i < n; i++)
        if (which[i] != lw_variable(LW_QUANTITY_T, 0))
            return false;
    return true;
}

static bool has_time(const lw_expression *x)
{
    const int *which;
    int n = x ? lw_expression_variables(x, &which) : 0;
    for (int i = 0; i < n; i++)
        if (which[i] == lw_variable(LW_QUANTITY_T, 0))
            return true;
    return false;
}

/* Which loads does the model have?  Loads that depend on the whole state cost more. */
static lw_status look_at_loads(const lw_dynamics *d, lw_reduced *r, char *why)
{
    const lw_model *m = d->model;
    if (d->n_stop || d->f.n_stop)
        return no(why, "stops");
    if (d->touch)
        return no(why, "contacts or ropes");
    r->general = d->f.caller.apply != NULL;
    for (int i = 0; i < m->n_force; i++)
        r->general = r->general || !of_time_alone(m->force[i].force[0]) || !of_time_alone(m->force[i].force[1]) ||
                     !of_time_alone(m->force[i].torque[2]);
    r->counts_turns = r->general;
    r->constant_loads = !d->f.caller.apply;
    for (int i = 0; i < m->n_force; i++)
        r->constant_loads = r->constant_loads && !has_time(m->force[i].force[0]) && !has_time(m->force[i].force[1]) &&
                            !has_time(m->force[i].torque[2]);
    for (int i = 0; i < m->n_spring; i++)
        r->constant_loads = r->constant_loads && !has_time(m->spring[i].law);
    for (int i = 0; i < m->n_joint_spring; i++)
        r->constant_loads = r->constant_loads && !has_time(m->joint_spring[i].law);
    for (int i = 0; i < m->n_joint_spring; i++)
        r->counts_turns = r->counts_turns || m->joint_spring[i].law || m->joint_spring[i].stiffness != 0;
    return LW_OK;
}

/* Candidate n for the input joint: the input of the file first, then joints at the ground in the order of the file. */
static int candidate(const lw_assembly *linkage, int n)
{
    int input = linkage->n_input ? linkage->input[0].joint : -1;
    if (n == 0 && input >= 0)
        return input;
    n -= input >= 0;
    for (int j = 0; j < linkage->n_joint; j++) {
        const lw_joint *p = &linkage->joint[j];
        bool ground = p->link[0] == linkage->ground || p->link[1] == linkage->ground;
        if (j == input || !ground || !lw_joint_can_drive(p->kind))
            continue;
        if (n-- == 0)
            return j;
    }
    return -1;
}

static lw_status find_plan(const lw_dynamics *d, lw_reduced *r, char *why)
{
    lw_error e;
    lw_plan_options plan_options = { .all_joints = true };
    if (d->model->n_spring > LW_REDUCED_LOAD_MAX || d->model->n_force > LW_REDUCED_LOAD_MAX)
        return no(why, "more springs or forces than it holds");
    if (d->s.n_tie > 0)
        return no(why, "inputs that are tied to the first");
    for (int n = 0, joint; (joint = candidate(&d->model->linkage, n)) >= 0; n++) {
        if (lw_assembly_linkage(&d->model->linkage, &r->linkage, &e) != LW_OK)
            return no(why, "more links than a plan holds");
        lw_system_write(&d->s, d->start_q, &r->linkage);
        r->linkage.n_input = 1;
        r->linkage.input[0] = (lw_input){ .joint = joint };
        r->linkage.input[0].value = lw_linkage_posture_input(&r->linkage, joint);
        if (lw_plan_make(&r->linkage, plan_options, &r->plan, &e) == LW_OK &&
            lw_plan_read(&r->plan, &r->linkage, r->dim, r->mode, &r->first, &e) == LW_OK)
            return LW_OK;
    }
    return no(why, "it is not made of dyads on one driven link at the ground");
}

/* ---- parts ------------------------------------------------------------------------------------------ */

static lw_end_point end_on(const lw_dynamics *d, const lw_reduced *r, int link, lw_vec2 at)
{
    const lw_reg1 *reg = r->reg;
    lw_vec2 p = lw_v2_unturn(lw_v2_sub(at, r->z0), r->turn);
    if (link == r->linkage.ground)
        return (lw_end_point){ -1, -1, -1, p };
    int o = r->plan.link_origin[link], u = r->plan.link_dir[link];
    return (lw_end_point){ o, u, d->s.body[link], lw_v2_unturn(lw_v2_sub(p, reg[o].p), reg[u].p) };
}

/* Place at the start of a point that the model gives in its posture. */
static lw_vec2 at_start(const lw_dynamics *d, int link, lw_vec2 at)
{
    int b = d->s.body[link];
    return lw_system_point(&d->s, b, lw_system_arm(&d->s, b, at), d->start_q);
}

static void place_joints(const lw_dynamics *d, lw_reduced *r)
{
    const lw_assembly *k = &d->model->linkage;
    for (int j = 0; j < d->s.n_joint; j++) {
        const lw_system_joint *from = &d->s.joint[j];
        lw_reduced_joint *to = &r->joint[j];
        to->slides = !lw_joint_turns(from->kind);
        to->sign = from->sign;
        to->pin = to->slides || !r->friction ? -1 : r->plan.joint_point[j];
        for (int end = 0; end < 2; end++) {
            int b = to->body[end] = from->body[end], link = b < 0 ? k->ground : d->s.link[b];
            to->point[end] = end_on(d, r, link, lw_system_point(&d->s, b, from->arm[end], d->start_q));
            to->dir[end] = b < 0 ? 1 : r->plan.link_dir[link];
        }
        double turn = from->body[0] < 0 ? 0 : d->start_q[3*from->body[0] + 2];
        lw_vec2 u = lw_v2_unturn(lw_v2_turn(from->along, lw_v2_polar(1, turn)), r->turn);
        to->along = lw_v2_unturn(u, r->reg[to->dir[0]].p);
    }
}

static lw_status place_parts(const lw_dynamics *d, lw_reduced *r, char *why)
{
    const lw_model *m = d->model;
    for (int b = 0; b < d->s.n_body; b++) {
        int link = d->s.link[b];
        if (r->plan.link_origin[link] < 0 || r->plan.link_dir[link] < 0)
            return no(why, "a link that its plan leaves out");
        r->centre[b] = end_on(d, r, link, lw_system_point(&d->s, b, lw_v2(0, 0), d->start_q));
        const lw_reg1 *u = &r->reg[r->centre[b].dir];
        r->dir0[link] = atan2(u->p.y, u->p.x) - d->start_q[3*b + 2];
    }
    for (int i = 0; i < m->n_spring; i++)
        for (int end = 0; end < 2; end++)
            r->end[i][end] = end_on(d, r, m->spring[i].link[end], at_start(d, m->spring[i].link[end], lw_v3_xy(m->spring[i].at[end])));
    for (int i = 0; i < m->n_force; i++)
        r->point[i] = end_on(d, r, m->force[i].link, at_start(d, m->force[i].link, lw_v3_xy(m->force[i].at)));
    place_joints(d, r);
    return LW_OK;
}

/* Bodies on ground pins come first: their inertia about the pin is constant. */
static void place_masses(const lw_dynamics *d, lw_reduced *r, const bool *fixed)
{
    for (int pivots = 1; pivots >= 0; pivots--) {
        for (int b = 0; b < d->s.n_body; b++) {
            const lw_body *body = &d->model->body[d->s.link[b]];
            const lw_end_point *c = &r->centre[b];
            lw_vec2 g = lw_v2_unturn(lw_v2_scale(d->model->gravity, body->mass), r->turn);
            double about = pivots ? body->mass*lw_v2_dot(c->arm, c->arm) : 0;
            if ((body->mass > 0 || body->inertia > 0) && fixed[c->origin] == (pivots == 1))
                r->mass[r->n_mass++] = (lw_mass_point){ c->origin, c->dir, c->arm, body->mass, body->inertia + about,
                                                        g };
        }
        r->n_pivot = pivots ? r->n_mass : r->n_pivot;
    }
}

/* ---- the plan with its numbers ---------------------------------------------------------------------- */

/* Fill all steps in order.  Registers that never move are evaluated once, and their steps left out. */
static void fill_steps(lw_reduced *r, bool *fixed)
{
    double mode[LW_DYAD_MAX] = { 0 }, margin;
    const lw_plan *p = &r->plan;
    r->reg[0] = (lw_reg1){ { 0, 0 }, { 0, 0 } };
    r->reg[1] = (lw_reg1){ { 1, 0 }, { 0, 0 } };
    fixed[0] = fixed[1] = true;
    for (int i = 0; i < p->n_step; i++) {
        const lw_step *st = &p->step[i];
        bool still = st->kind == LW_STEP_POINT || st->kind == LW_STEP_LINE;
        for (int k = 0; k < lw_step_inputs(st->kind); k++)
            still = still && fixed[st->in[k]];
        r->step[0] = lw_dyad_step_of(st, r->dim);
        r->n_step = 1;
        for (int k = 0; k < lw_step_outputs(st->kind); k++)
            if (st->out[k] >= 0)
                fixed[st->out[k]] = still;
        if (still)
            lw_reduced_plain(r, mode, NULL, 0, NULL, &margin);
    }
    r->n_step = 0;
    for (int i = 0; i < p->n_step; i++)
        if (!fixed[p->step[i].out[0]])
            r->step[r->n_step++] = lw_dyad_step_of(&p->step[i], r->dim);
}

static void mark_needed(bool *needed, const lw_end_point *e)
{
    if (e->origin >= 0)
        needed[e->origin] = needed[e->dir] = true;
}

/* Leave out steps that no body, spring or force depends on. */
static void drop_steps(const lw_dynamics *d, lw_reduced *r)
{
    bool needed[LW_REG_MAX] = { false };
    int kept = r->n_step;
    for (int b = 0; b < d->s.n_body; b++)
        mark_needed(needed, &r->centre[b]);
    for (int i = 0; i < d->model->n_spring; i++) {
        mark_needed(needed, &r->end[i][0]);
        mark_needed(needed, &r->end[i][1]);
    }
    for (int i = 0; i < d->model->n_force; i++)
        mark_needed(needed, &r->point[i]);
    for (int j = 0; j < d->s.n_joint; j++)
        if (r->joint[j].pin >= 0)
            needed[r->joint[j].pin] = true;
    for (int i = r->n_step - 1; i >= 0; i--) {
        const lw_dyad_step *st = &r->step[i];
        bool live = st->kind >= LW_STEP_RRR;
        for (int k = 0; k < lw_step_outputs(st->kind); k++)
            live = live || (st->out[k] >= 0 && needed[st->out[k]]);
        if (!live)
            continue;
        for (int k = 0; k < lw_step_inputs(st->kind); k++)
            needed[st->in[k]] = true;
        r->step[--kept] = r->step[i];
    }
    r->n_step -= kept;
    memmove(r->step, r->step + kept, (size_t)r->n_step*sizeof *r->step);
}

/* Does the measure of the input joint rise or fall with the input of the plan? */
static void find_sense(const lw_dynamics *d, lw_reduced *r)
{
    double q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX];
    lw_measure m;
    memcpy(q, d->start_q, (size_t)d->n_q*sizeof *q);
    lw_reduced_state(r, d, 1, q, v);
    lw_measure_joint(&d->s, r->linkage.input[0].joint, q, v, false, &m);
    r->sense = m.rate < 0 ? -1 : 1;
    r->start = r->first - r->sense*m.value;    /* measures count from the posture of the file */
}

/* The joint of a dyad between one of its links and another link, or (inner) between both, where its plan names one of several
 * pins at one place; -1: none, or several. */
static int joint_of_dyad(const lw_dynamics *d, const lw_reduced *r, const lw_dyad *from, int k)
{
    const int a = d->s.body[from->link[k == 2]], b = d->s.body[from->link[k != 2]];
    int found = -1;
    for (int j = 0; j < d->s.n_joint; j++) {
        const int *own = r->joint[j].body;
        bool same = j == from->joint[k] || (r->joint[j].pin >= 0 && r->joint[j].pin == r->joint[from->joint[k]].pin);
        if (!same || (own[0] != a && own[1] != a) || (own[0] == b || own[1] == b) != (k == 1))
            continue;
        if (j == from->joint[k])
            return j;
        found = found < 0 ? j : d->s.n_joint;
    }
    return found < d->s.n_joint ? found : -1;
}

static int slot_of(const lw_reduced_friction *f, int joint)
{
    int i = 0;
    while (i < f->n && f->joint[i] != joint)
        i++;
    return i;
}

/* Joints with friction, and the dyads that carry reactions to the ground, in the order of the plan. */
static lw_status find_friction(const lw_dynamics *d, lw_reduced *r, char *why)
{
    lw_reduced_friction *f = r->friction;
    bool carried[LW_JOINT_MAX] = { false };
    if (r->n_change)
        return no(why, "friction where assembly modes meet, which leaves reactions undetermined");
    f->input_joint = r->linkage.input[0].joint;
    f->input_body = d->s.joint[f->input_joint].body[d->s.joint[f->input_joint].body[0] < 0];
    carried[f->input_joint] = true;
    for (int i = 0; i < r->plan.n_step; i++) {
        lw_step_kind kind = r->plan.step[i].kind;
        if (kind < LW_STEP_RRR || kind > LW_STEP_PPR)
            continue;
        const lw_dyad *from = &r->plan.dyad[r->plan.step[i].dyad];
        lw_reduced_group *to = &f->group[f->n_group++];
        to->pins = true;
        for (int k = 0; k < 3; k++) {
            if ((to->joint[k] = joint_of_dyad(d, r, from, k)) < 0)
                return no(why, "friction where several pins at one place share the reactions of a dyad");
            carried[to->joint[k]] = true;
            to->pins = to->pins && r->joint[to->joint[k]].pin >= 0;
        }
        for (int side = 0; side < 2; side++)
            to->body[side] = d->s.body[from->link[side]];
        for (int k = 0; k < 3; k++) {
            const int *body = r->joint[to->joint[k]].body, own = to->body[k == 2];
            to->side[k] = body[1] == own ? 1 : -1;
            if (k != 1)
                to->before[k/2] = body[body[0] == own];
        }
    }
    for (int i = 0; i < d->n_friction; i++) {
        const lw_friction_joint *p = &d->friction[i];
        if (!carried[p->joint])
            return no(why, "friction in a joint that its plan leaves out");
        if (r->joint[p->joint].slides)
            f->slide[f->n_slide++] = f->n;
        f->set_valued = f->set_valued || p->ideal;
        f->joint[f->n] = p->joint;
        f->arm[f->n++] = p->coefficient*p->lever_arm;
    }
    for (int k = 0; k < 3*f->n_group; k++)
        f->group[k/3].slot[k%3] = slot_of(f, f->group[k/3].joint[k%3]);
    f->input_slot = slot_of(f, f->input_joint);
    /* of a size, whose error acts on the others and on the force by the friction's small part of them */
    f->tolerance = fmin(fmax(0.1*d->o.relative, 1e-14), 1e-9);
    return LW_OK;
}

static lw_status make(const lw_dynamics *d, lw_reduced *r, char *why)
{
    bool fixed[LW_REG_MAX] = { false };
    double margin;
    r->known = NAN;
    r->dynamics = d;
    if (d->elastic)
        return no(why, "elastic links");
    if (d->freedom != 1 || d->n_driven)
        return no(why, d->n_driven ? "inputs with a motion beside free ones" : "more than one freedom");
    lw_status s = look_at_loads(d, r, why);
    if (s == LW_OK)
        s = find_plan(d, r, why);
    if (s != LW_OK)
        return s;
    r->model = d->model;
    r->scale = r->plan.input_is_slider ? d->s.unit : 1;
    r->z0 = lw_v2(r->dim[r->plan.i_x0], r->dim[r->plan.i_y0]);
    r->turn = lw_v2_polar(1, r->dim[r->plan.i_theta0]);
    fill_steps(r, fixed);
    lw_reduced_plain(r, r->mode, NULL, r->first, NULL, &margin);
    if (!(margin > 1e-9))
        return no(why, "the posture at the start is a dead point of its closed form");
    r->low = -INFINITY;
    r->high = INFINITY;
    if ((s = place_parts(d, r, why)) != LW_OK)
        return s;
    place_masses(d, r, fixed);
    assert(r->n_mass <= LW_LINK_MAX && r->n_step <= LW_STEP_MAX);
    drop_steps(d, r);
    find_sense(d, r);
    if ((s = lw_reduced_change_points(r, r->first)) == LW_E_KIND)
        return no(why, "two assemblies of a dyad come near each other, but do not meet");
    if (s != LW_OK)
        return s;
    if ((s = lw_reduced_registers(r, r->first)) != LW_OK)
        return no(why, "the posture at the start is a dead point of its closed form");
    for (int b = 0; b < d->s.n_body; b++) {
        r->count.turn[b] = d->start_q[3*b + 2];
        r->count.rate[b] = r->reg[r->centre[b].dir].d.x;
    }
    r->count.at = r->first;
    return r->friction ? find_friction(d, r, why) : LW_OK;
}

lw_status lw_reduced_able(lw_dynamics *d)
{
    if (d->reduced)
        return d->reduced_status;
    if (d->space)
        return no(d->not_reduced, "its links move in space");
    if (d->f.coupled)
        return no(d->not_reduced, "a first-order state, or a law of other quantities than its own");
    size_t n = (size_t)d->n_q;
    d->reduced = calloc(1, sizeof *d->reduced + sizeof *d->reduced->friction + 3*n*sizeof(double));
    if (!d->reduced)
        return LW_E_MEMORY;
    lw_reduced_friction *friction = (void *)(d->reduced + 1);
    d->reduced->friction = d->n_friction ? friction : NULL;
    d->reduced->q = (void *)(friction + 1);
    d->reduced->v = d->reduced->q + n;
    d->reduced->force = d->reduced->v + n;
    return d->reduced_status = make(d, d->reduced, d->not_reduced);
}
