/* mbs/dynamics/dynamics_space.c - a spatial model made ready: start, drives; its driven runs; what its joints carry. */
#include "mbs/dynamics/dynamics_space.h"

#include <stdlib.h>
#include <string.h>
#include "base/linalg.h"
#include "base/number.h"
#include "base/vector.h"
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/equations/limits_internal.h"
#include "mbs/ode/integrate.h"
#include "mbs/space/space_hold.h"
#include "mbs/space/space_idle.h"

const lw_space *lw_dynamics_space(const lw_dynamics *d) { return &d->space->s; }
int  lw_dynamics_idle(const lw_dynamics *d) { return d->space ? d->space->n_idle : 0; }
bool lw_dynamics_many_drives(const lw_dynamics *d) { return d->space && d->space->many_drives; }

const char *lw_mbs_is_planar(const lw_dynamics *d)
{
    lw_vec3 normal;
    return lw_spatial_is_planar(d->space->model, &normal)
         ? "; all axes are parallel: the motion is planar (--planar solves it so)" : "";
}

const char *lw_dynamics_massless(const lw_dynamics *d)
{
    return d->space && d->space->massless >= 0 ? d->space->model->body[d->space->s.link_of[d->space->massless]].name : NULL;
}

/* ---- what is special ------------------------------------------------------------------------------------------ */

static void drive_input(lw_dynamics *d, int i)
{
    d->driven_measure[d->n_driven] = lw_spatial_number(d->space, d->space->model->input[i].measure);
    d->driven[d->n_driven++] = i;
}

static void find_special_joints(lw_dynamics *d)
{
    const lw_spatial_scene *c = d->space;
    const lw_spatial *m = c->model;
    for (int j = 0; j < m->n_joint; j++) {
        const lw_joint_stop *p = &m->joint[j].stop;
        lw_spatial_measure of = lw_space_stop_measure(&c->s, j);
        int number = lw_spatial_number(c, of);
        double unit = lw_space_scale(&c->s, of);
        if (m->joint[j].friction.coefficient > 0 && !m->joint[j].opened)
            d->friction[d->n_friction++] = (lw_friction_joint){
                .joint = j, .coefficient = m->joint[j].friction.coefficient, .ideal = !(m->joint[j].friction.speed > 0),
                .speed = m->joint[j].friction.speed > 0 ? m->joint[j].friction.speed : LW_FRICTION_SPEED,
                .lever_arm = m->joint[j].kind == LW_SPATIAL_PRISMATIC ? 1 : m->joint[j].friction.radius };
        if (p->stiffness > 0)
            continue;
        if (p->has_least)
            d->stop[d->n_stop++] = (lw_rigid_stop){ j, number, 1, p->least/unit, p->restitution, false, false, false };
        if (p->has_greatest)
            d->stop[d->n_stop++] = (lw_rigid_stop){ j, number, -1, p->greatest/unit, p->restitution, false, false, false };
    }
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i].motion || d->o.hold_inputs)
            drive_input(d, i);
    for (int i = 0; i < d->n_v; i++)
        d->has_zero_mass = d->has_zero_mass || !(d->eq.mass[i] > 0);
}

/* ---- start ---------------------------------------------------------------------------------------------------- */

lw_status lw_mbs_driven_path(void *context, double t, double (*out)[3])
{
    lw_dynamics *d = context;
    for (int i = 0; i < d->n_driven; i++) {
        double unit = d->eq.measure_unit(d->eq.context, d->driven_measure[i]);
        if (lw_mbs_motion(d, i, t, out[i]) != LW_OK)
            return LW_E_NUMERIC;
        for (int k = 0; k < 3; k++)
            out[i][k] *= unit;
    }
    return LW_OK;
}

static lw_status say_not_a_number(const lw_dynamics *d, double t, lw_error *e)
{
    double motion[3];
    int i = 0;
    while (i + 1 < d->n_driven && lw_mbs_motion(d, i, t, motion) == LW_OK)
        i++;
    return lw_error_set(e, LW_E_NUMERIC, "the motion of input \"%s\", its rate or its acceleration is not a number at t = %.9g s",
                        d->eq.name(d->eq.context, LW_NAMED_INPUT, d->driven[i]), t);
}

/* Turns are counted along the way, which may be many between two samples. */
static void count_turns(void *context, const double *q)
{
    lw_spatial_scene *c = context;
    lw_space_place(&c->s, q, c->frame);
    lw_space_forces_accept(&c->f, c->frame);
}

/* From the posture of the file to where the motions begin, as straight as the joints allow. */
static lw_status find_posture(lw_dynamics *d, lw_error *e)
{
    lw_spatial_scene *c = d->space;
    double motion[3];
    lw_spatial_measure *input = calloc((size_t)d->n_driven + 1, sizeof *input);
    if (!input)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < d->n_driven; i++)
        input[i] = lw_spatial_numbered(c, d->driven_measure[i]);
    lw_status st = lw_space_follow_make(&c->s, input, d->n_driven, true, &c->follow, e);
    free(input);
    c->follow.u = d->o.from;
    c->follow.passed = count_turns;
    c->follow.passed_by = c;
    for (int i = 0; st == LW_OK && i < d->n_driven; i++)
        if (lw_mbs_motion(d, i, d->o.from, motion) != LW_OK)
            return say_not_a_number(d, d->o.from, e);
    if (st == LW_OK)
        st = lw_space_follow_to(&c->follow, lw_mbs_driven_path, d, d->o.from, e);
    if (st != LW_OK)
        return st;
    memcpy(d->start_q, c->follow.q, (size_t)d->n_q*sizeof *d->start_q);
    d->eq.accept(d->eq.context, d->start_q);
    return lw_mbs_arrange(d, d->o.from, d->start_q);
}

/* Is this the spin, coordinate i of body b, of a body without inertia about its axis that is held? */
static bool is_held_without_inertia(const lw_spatial_scene *c, int b, int i)
{
    bool held = false;
    for (int k = 0; k < c->n_idle; k++)
        held = held || c->idle[k].body == b;
    return held && i >= 3 && c->s.mass[6*b + i] == 0;
}

/* Velocities that links are given, and 1 where they are (0 in by_mass: they are kept). */
static double given_velocities(lw_dynamics *d)
{
    const lw_spatial_scene *c = d->space;
    double top = 0;
    lw_space_place(&c->s, d->start_q, c->frame);
    for (int b = 0; b < c->s.n_body; b++) {
        const lw_spatial_body *p = &c->model->body[c->s.link_of[b]];
        lw_vec3 w = lw_m3_unapply(&c->frame[b + 1].turn, p->omega), u = lw_v3_scale(p->velocity, 1/c->s.unit);
        const double given[6] = { u.x, u.y, u.z, w.x, w.y, w.z };
        for (int i = 0; i < 6; i++) {
            bool has = (i < 3 ? p->has_velocity : p->has_omega) && !is_held_without_inertia(c, b, i);
            d->start_v[6*b + i] = has ? given[i] : 0;
            d->by_mass[6*b + i] = has ? 0 : d->by_mass[6*b + i];
            top = fmax(top, fabs(d->start_v[6*b + i]));
        }
    }
    return top;
}

/* Put start_v on the rows with these rates (n_c), the change least in the metric of the masses. */
static lw_status correct(lw_dynamics *d, const double *wanted)
{
    lw_status st = lw_mbs_rows(d, d->o.from, d->start_q);
    if (st == LW_OK)
        lw_mbs_factor(d, false);
    for (int pass = 0; st == LW_OK && pass < 2; pass++) {
        lw_mbs_times(d, d->start_v, d->rhs);
        for (int r = 0; r < d->n_c; r++)
            d->rhs[r] = wanted[r] - d->rhs[r];
        lw_mbs_linear(d, NULL, d->rhs, d->hold, d->l);
        for (int i = 0; i < d->n_v; i++)
            d->start_v[i] += d->hold[i];
    }
    return st;
}

/* Where inputs move every freedom: does the run in time need velocities at the start, or does the file give a speed or a velocity, which the
 * motions of the inputs may contradict? */
static bool needs_velocities(const lw_dynamics *d, const lw_spatial *m)
{
    bool any = d->eq.n_z > 0 || d->o.pieces || (d->o.formulation != LW_FORMULATION_AUTO && d->o.formulation != LW_FORMULATION_DRIVEN);
    for (int i = 0; i < m->n_input && !any; i++)
        any = m->input[i].has_speed && !m->input[i].motion;
    for (int i = 0; i < m->n_link && !any; i++)
        any = m->body[i].has_velocity || m->body[i].has_omega;
    return any;
}

static void weigh_by_mass(lw_dynamics *d)
{
    for (int i = 0; i < d->n_v; i++)
        d->by_mass[i] = 1/d->eq.mass[i];
}

/* The velocities that satisfy the joints, the motions and the speeds, and keep those that links are given. */
static lw_status find_velocities(lw_dynamics *d, lw_error *e)
{
    const lw_spatial *m = d->space->model;
    int driven = d->n_driven;
    bool large = d->large, stuck = d->freedom == 0 && driven == 0;
    double off = 0, *wanted = d->l_each;
    int worst = 0;
    for (int i = 0; i < d->n_v; i++)
        d->by_mass[i] = d->eq.mass[i] > 0 && !d->has_zero_mass ? 1/d->eq.mass[i] : 1;
    double top = given_velocities(d);
    for (int i = 0; i < m->n_input; i++)
        if (m->input[i].has_speed && !m->input[i].motion)
            drive_input(d, i);
    if (top == 0 && d->n_driven == 0 && !d->has_zero_mass) {             /* at rest, and the rows are arranged */
        weigh_by_mass(d);
        return LW_OK;
    }
    d->large = true;                         /* the fast way alone: rows that only given velocities touch depend on none */
    lw_status st = lw_mbs_arrange(d, d->o.from, d->start_q);
    int held = d->n_driven;
    d->n_driven = driven;
    if (st == LW_OK)
        st = lw_mbs_rate_wanted(d, d->o.from);
    d->n_driven = held;
    for (int r = 0; st == LW_OK && r < d->n_c; r++)
        wanted[r] = r < d->n_row + driven ? d->rhs[r] : m->input[d->driven[r - d->n_row]].speed/
                    d->eq.measure_unit(d->eq.context, d->driven_measure[r - d->n_row]);
    if (st == LW_OK)
        st = correct(d, wanted);
    if (st == LW_OK) {
        lw_mbs_times(d, d->start_v, d->rhs);
        for (int r = 0; r < d->n_c; r++) {
            top = fmax(top, fabs(wanted[r]));
            if (fabs(d->rhs[r] - wanted[r]) > off)
                off = fabs(d->rhs[r] - wanted[r]), worst = r;
        }
        const char *joint = worst < d->n_row ? d->eq.name(d->eq.context, LW_NAMED_ROW, worst) : NULL;
        st = lw_mbs_check_speeds(e, joint, off, top, stuck ? "; nothing can move in this posture, perhaps since numbers of an "
                                 "overconstrained linkage are rounded: see \"mobility\"" : "");
    }
    d->n_driven = driven;
    d->large = large;
    weigh_by_mass(d);
    return st == LW_OK ? lw_mbs_arrange(d, d->o.from, d->start_q) : st;
}

/* ---- drives --------------------------------------------------------------------------------------------------- */

/* Drives that carry the forces of inputs which leave no freedom. */
static lw_status make_drives(lw_dynamics *d, lw_error *e)
{
    lw_spatial_scene *c = d->space;
    const lw_spatial *m = c->model;
    size_t extras = (size_t)c->n_idle + (size_t)m->n_drive + 1, rows = (size_t)c->s.n_row + extras;
    c->drive_l = calloc(rows + (size_t)(m->n_drive > m->n_input ? m->n_drive : m->n_input) + 2*(size_t)m->n_input + 1, sizeof(double));
    c->drive_f = calloc(2*(size_t)d->n_v + rows*(LW_SPACE_ROW + 1) + 1, sizeof(double));
    c->joint = calloc((size_t)m->n_joint + 1, sizeof *c->joint);
    c->pull = calloc((size_t)m->n_coupling + 1, sizeof *c->pull);
    if (!c->drive_l || !c->drive_f || !c->joint || !c->pull)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (m->n_drive == 0)
        return LW_OK;
    if (d->freedom > 0 && d->n_driven > 0)
        return lw_error_set(e, LW_E_KIND, "\"drives\" carry the forces of a model whose inputs leave no freedom; here %d freedom%s "
                            "left", d->freedom, d->freedom == 1 ? " is" : "s are");
    lw_space_extra *x = calloc(extras, sizeof *x);
    double *metric = malloc(((size_t)d->n_v + 1)*sizeof *metric);
    lw_status st = x && metric ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (st == LW_OK) {
        lw_space_metric(&c->s, metric);
        memcpy(x, c->idle, (size_t)c->n_idle*sizeof *x);
        for (int i = 0; i < m->n_drive; i++)
            x[c->n_idle + i] = (lw_space_extra){ .measure = m->drive[i] };
        st = lw_space_rows_make(&c->s, x, c->n_idle + m->n_drive, metric, d->start_q, &c->drives, e);
    }
    if (st == LW_OK) {
        int joints = d->rank - d->n_driven;          /* rows of joints and spins that are independent */
        c->has_drives = d->freedom == 0;
        c->many_drives = c->has_drives && c->drives.n_kept < joints + m->n_drive;
        if (c->has_drives)                   /* the motion does not depend on it; drives carry it */
            c->n_rub = d->n_friction, d->n_friction = 0;
        if (c->has_drives && c->drives.n_kept < d->n_v)
            st = lw_error_set(e, LW_E_ARG, "%d drive%s only %d of %d freedom%s in the posture of the file: the posture is "
                              "singular for them, or more drives are needed", m->n_drive, m->n_drive == 1 ? " moves" : "s move", c->drives.n_kept - joints,
                              d->n_v - joints, lw_plural(d->n_v - joints));
        if (st == LW_OK && c->many_drives)
            st = lw_space_dense_make(&c->drives, &c->drives_least, e);
    }
    free(x), free(metric);
    return st;
}

/* Reactions of joints count this much less than forces of drives where the least norm of both is sought. */
static const double cheap = 1e4;

/* l with J^T l = f = c->drive_f of the rows of joints and drives, which are factored; where drives share a force, of least norm. */
static void carry(lw_dynamics *d, double *l)
{
    lw_spatial_scene *c = d->space;
    lw_space_rows_set *z = &c->drives;
    double *f = c->drive_f, *rest = f + d->n_v;
    if (c->many_drives) {
        int joints = c->s.n_row + c->n_idle;
        for (int i = 0; i < z->at[joints]; i++)
            z->jac[i] *= cheap;
        memcpy(rest, f, (size_t)d->n_v*sizeof *f);
        c->drives_least.rank.most = z->n_kept;
        lw_space_dense_factor(z, &c->drives_least, 1e-10);
        lw_rank_solve(&c->drives_least.rank, rest, l);
        for (int i = 0; i < z->at[joints]; i++)
            z->jac[i] /= cheap;
        for (int i = 0; i < joints; i++)
            l[i] *= cheap;
    } else
        lw_space_rows_carry(z, f, l);
}

static void drive_reaction(const void *context, int j, const double *l, double *out)
{
    const lw_dynamics *d = context;
    const lw_space *s = &d->space->s;
    const lw_space_joint *p = &s->joint[d->friction[j].joint];
    int side = p->body[1] >= 0 ? 6 : 0;
    out[0] = out[1] = out[2] = 0;
    for (int r = p->row; r < p->row + lw_spatial_kind_of(p->kind)->rows; r++)
        for (int i = 0; i < 3; i++)
            out[i] -= l[r]*d->space->drives.jac[r*LW_SPACE_ROW + side + i]/s->unit;
}

static const char *rubbing(const void *context, int j)
{
    const lw_dynamics *d = context;
    return d->space->model->joint[d->friction[j].joint].name;
}

/* The reactions of the joints and the forces of the drives in c->drive_l become those with friction. */
static lw_status add_friction(lw_dynamics *d, double t, const double *v, lw_error *e)
{
    lw_spatial_scene *c = d->space;
    int n_l = c->drives.n_row;
    double *response = lw_mbs_response(d, c->n_rub, n_l);
    if (!response)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    double *size = response + (size_t)c->n_rub*(size_t)n_l + lw_friction_doubles(c->n_rub, 3);
    lw_mbs_full_friction(d, c->n_rub, v);
    for (int j = 0; j < c->n_rub; j++) {
        memset(c->drive_f, 0, (size_t)d->n_v*sizeof *c->drive_f);
        lw_spatial_rub(c, &d->friction[j], v, 1, c->drive_f);
        carry(d, response + j*n_l);
    }
    return lw_friction_add(&(lw_friction_scene){ d, 3, drive_reaction, rubbing }, c->n_rub, d->friction, response, t, 0, NULL, n_l,
                           c->drive_l, size, NULL, e);
}

/* c->drive_l from the motions by unit rates of the inputs, where going to q has found them: the drives do the work of f = c->drive_f along these
 * motions, and the rows of joints and inputs, factored there, carry what is left.  false: not found, or inputs and drives do not go together well. */
static bool load_by_motions(lw_dynamics *d, const double *q)
{
    static const double well = 1e-3, rounding = 1e-15;
    lw_spatial_scene *c = d->space;
    lw_space_follow *w = &c->follow;
    lw_space_rows_set *z = &w->z;
    const lw_space *s = &c->s;
    int n = c->model->n_drive, first = s->n_row + c->n_idle, body[2];
    double jac[LW_SPACE_HELD][LW_SPACE_ROW], a[LW_SPACE_HELD*LW_SPACE_HELD], diag[LW_SPACE_HELD], *l = c->drive_l + first, *rest = c->drive_f + d->n_v;
    if (!w->has_column || n != w->n_input || w->n_idle != c->n_idle || z->n_kept < z->n_row || z->n_row != d->n_v || c->n_rub > 0)
        return false;
    for (int i = 0; i < d->n_q; i++)         /* quaternions of q may have been normalised */
        if (!(fabs(z->filled[i] - q[i]) < rounding))
            return false;
    memset(a, 0, sizeof a);
    for (int k = 0; k < n; k++) {
        lw_space_extra drive = { .measure = c->model->drive[k] };
        lw_space_measure(s, z->frame, drive.measure, 0, jac[k]);
        lw_space_bodies(s, &drive, body);
        for (int i = 0; i < n; i++)
            for (int end = 0; end < 2; end++)
                a[i + n*k] += body[end] < 0 ? 0 : lw_dot(6, jac[k] + 6*end, w->column + i*d->n_v + 6*body[end]);
    }
    if (!(lw_qr_factor(n, n, a, diag) > well))
        return false;
    for (int i = 0; i < n; i++)
        l[i] = lw_dot(d->n_v, w->column + i*d->n_v, c->drive_f);
    lw_qr_solve(n, n, a, diag, l);
    memcpy(rest, c->drive_f, (size_t)d->n_v*sizeof *rest);
    for (int k = 0; k < n; k++) {
        lw_space_bodies(s, &(lw_space_extra){ .measure = c->model->drive[k] }, body);
        for (int i = 0; i < LW_SPACE_ROW; i++)
            if (body[i/6] >= 0)
                rest[6*body[i/6] + i%6] -= l[k]*jac[k][i];
    }
    lw_space_rows_carry(z, rest, w->l);
    memcpy(c->drive_l, w->l, (size_t)first*sizeof *l);
    return true;
}

/* c->drive_l at velocities v. */
static lw_status load_by_rows(lw_dynamics *d, double t, const double *q, const double *v, lw_error *e)
{
    lw_spatial_scene *c = d->space;
    lw_space_rows_set *z = &c->drives;
    double most = 0, left = 0, *f = c->drive_f, *rest = f + d->n_v;
    lw_space_rows_fill(z, q, NULL);
    if (!lw_space_rows_factor(z))
        return lw_error_set(e, LW_OPEN, "at t = %.9g s the drives cannot hold the posture: it is singular for them", t);
    carry(d, c->drive_l);
    for (int i = 0; i < d->n_v; i++) {
        most = fmax(most, fabs(f[i]));
        rest[i] = -f[i];
    }
    lw_space_rows_add(z, 1, c->drive_l, rest);
    for (int i = 0; i < d->n_v; i++)
        left = fmax(left, fabs(rest[i]));
    if (left > 1e-7*most + 1e-12)
        return lw_error_set(e, LW_E_ARG, "at t = %.9g s the drives cannot move the model: %.3g of %.3g N m (forces times the size) "
                            "are left; are there as many drives as inputs?", t, left, most);
    return c->n_rub ? add_friction(d, t, v, e) : LW_OK;
}

/* The drives of a driven run at velocities v under the forces c->drive_f.  *jac: the derivatives of the rows of the joints there. */
static lw_status load_drives(lw_dynamics *d, double t, const double *q, const double *v, double *drive, const double **jac, lw_error *e)
{
    lw_spatial_scene *c = d->space;
    bool by_motions = load_by_motions(d, q);
    lw_status st = by_motions ? LW_OK : load_by_rows(d, t, q, v, e);
    *jac = by_motions ? c->follow.z.jac : c->drives.jac;
    for (int i = 0; i < c->model->n_drive; i++)
        drive[i] = -c->drive_l[c->s.n_row + c->n_idle + i]/lw_space_scale(&c->s, c->model->drive[i]);
    return st;
}

/* ---- moments -------------------------------------------------------------------------------------------------- */

/* Forces of the joints on their second links, and of the couplings, for multipliers l; all: the derivatives of all rows.  The row of a slide in a
 * coupling pulls at the centre of the second link; a coupling pulls along the axis through the joint's point, as drives do, so the joint carries the
 * moment. */
static void find_reactions(lw_spatial_scene *c, const double *v, const double *l, const double *all)
{
    const lw_space *s = &c->s;
    for (int i = 0; i < s->n_joint; i++) {
        const lw_space_joint *j = &s->joint[i];
        int end = j->body[1] >= 0 ? 1 : 0;   /* from the side that is a body, about its centre, to the point on link[1] */
        lw_vec3 load = { 0, 0, 0 }, twist = { 0, 0, 0 }, p[2];
        for (int k = 0; k < lw_spatial_kind_of(j->kind)->rows; k++) {
            const double *jac = all + (j->row + k)*LW_SPACE_ROW + 6*end;
            double f = -l[j->row + k];
            load = lw_v3_add(load, lw_v3_scale(lw_v3(jac[0], jac[1], jac[2]), f/s->unit));
            twist = lw_v3_add(twist, lw_v3_scale(lw_v3(jac[3], jac[4], jac[5]), f));
        }
        for (int k = 0; k < 2; k++)
            p[k] = lw_space_point_at(c->frame, (lw_space_point){ j->body[k], j->arm[k] });
        lw_vec3 about = lw_m3_apply(&c->frame[j->body[end] + 1].turn, twist);
        about = lw_v3_add(about, lw_v3_cross(lw_v3_sub(c->frame[j->body[end] + 1].at, p[1]), load));
        c->joint[i].force = lw_v3_scale(load, end == 1 ? 1 : -1);
        c->joint[i].moment = lw_v3_scale(about, end == 1 ? 1 : -1);
    }
    for (int i = 0; i < s->n_coupling; i++) {
        const lw_space_coupling *p = &s->coupling[i];
        c->pull[i] = -l[s->n_joint_row + i]/p->most;
        for (int k = 0; k < p->n; k++) {
            const lw_space_term *t = &p->term[k];
            const lw_space_joint *j = &s->joint[t->index];
            if (t->turn || j->body[1] < 0)
                continue;
            const lw_space_frame *of = &c->frame[j->body[1] + 1];
            lw_vec3 arm = lw_m3_apply(&of->turn, lw_v3_scale(j->arm[1], -1)), axis = lw_m3_apply(&of->turn, j->z[1]);
            lw_vec3 *moment = &c->joint[t->index].moment;
            *moment = lw_v3_add(*moment, lw_v3_cross(arm, lw_v3_scale(axis, c->pull[i]*t->factor*p->most/s->unit)));
        }
    }
    for (int i = 0; i < c->model->n_contact; i++) {
        const lw_space_contact *p = &c->f.contact[i];
        lw_vec3 d = lw_v3_sub(lw_space_point_at(c->frame, p->end[1]), lw_space_point_at(c->frame, p->end[0]));
        lw_space_touch at = lw_space_touch_of(&c->f, c->frame, v, i);
        lw_vec3 *to = &c->joint[p->joint].force;
        *to = lw_v3_add(lw_v3_sub(*to, lw_v3_scale(d, at.distance > 0 ? at.force/at.distance : 0)), at.drag);
        c->joint[p->joint].moment = lw_v3_add(c->joint[p->joint].moment, lw_v3_cross(at.arm, at.drag));
    }
}

lw_status lw_dynamics_space_moment(lw_dynamics *d, const lw_moment *m, lw_space_moment *out, lw_error *e)
{
    lw_spatial_scene *c = d->space;
    const lw_spatial *model = c->model;
    int inputs = model->n_input;
    bool still = d->o.analysis == LW_ANALYSIS_QUASISTATIC || d->o.analysis == LW_ANALYSIS_STATIC;
    double *input = c->drive_l + c->s.n_row + c->n_idle + model->n_drive + 1, *rate = input + inputs, *drive = rate + inputs;
    double *f = c->drive_f, *none = f + d->n_v;
    const double *l = m->l, *all = none + c->s.n_row;
    lw_status st = LW_OK;
    *out = (lw_space_moment){ .t = m->t, .q = m->q, .v = m->v, .a = m->a, .frame = c->frame, .input = input, .input_rate = rate,
                              .drive = drive, .joint = c->joint, .coupling = c->pull, .kinetic = m->kinetic, .potential = m->potential,
                              .work = m->work, .off = m->off, .off_rate = m->off_rate };
    for (int i = 0; i < inputs || i < model->n_drive; i++)
        drive[i] = 0;                        /* what runs freely */
    lw_space_place(&c->s, m->q, c->frame);
    if (c->has_drives) {
        memset(none, 0, (size_t)d->n_v*sizeof *none);
        lw_space_forces_apply(&c->f, m->t, c->frame, still ? none : m->v, f, NULL, NULL);
        for (int i = 0; i < d->n_v && !still; i++)
            f[i] -= c->s.mass[i]*m->a[i];
        st = load_drives(d, m->t, m->q, still ? none : m->v, drive, &all, e);
        l = c->drive_l;
    }
    for (int i = 0; i < d->n_driven && model->n_drive == 0; i++)
        drive[d->driven[i]] = -m->l[d->n_row + i]/d->eq.measure_unit(d->eq.context, d->driven_measure[i]);
    for (int i = 0; i < inputs; i++) {
        lw_spatial_measure of = model->input[i].measure;
        lw_space_measured(&c->s, c->frame, of, of.of == LW_OF_TURN ? c->f.turn[of.index] : 0, m->v, &input[i], &rate[i]);
        input[i] += lw_spatial_offset(&model->input[i]);
    }
    if (!c->has_drives)
        lw_space_rows(&c->s, c->frame, none, none + c->s.n_row);
    find_reactions(c, m->v, l, all);
    return st;
}

const lw_spatial_expansion *lw_dynamics_spatial_elastic(const lw_dynamics *d)
{
    return d->elastic && d->space ? &d->spatial_expansion : NULL;
}

/* Add the line loads that a part of a chain passes on to a node, in ground axes, to force and moment of the part on that node. */
static void add_line_loads(const lw_dynamics *d, const lw_space_moment *m, int part, int link, lw_vec3 *force, lw_vec3 *moment)
{
    const lw_spatial *model = d->space->model;
    for (int i = 0; i < model->n_force; i++) {
        lw_vec3 about;
        if (model->force[i].part != part + 1 || model->force[i].link != link)
            continue;
        *force = lw_v3_add(*force, lw_space_applied(&d->space->f, i, m->t, m->frame, m->v, &about));
        *moment = lw_v3_add(*moment, about);
    }
}

/* Add what acts at one end of a part of a bar to the node there, in the axes of its section: force and moment of the part on its first
 * node, or of the node on the part at its second. */
static void add_inner(const lw_elastic_chain *c, int node, int nodes, const lw_mat3 *axes, lw_vec3 force, lw_vec3 moment, lw_space_inner *to)
{
    double share = node == 0 || node == nodes - 1 ? 1 : 0.5;
    lw_vec3 f = lw_m3_unapply(axes, force), m = lw_m3_unapply(axes, moment);
    double stress = lw_section_stress_space(&c->elastic->section, f.x, m.y, m.z);
    to->normal += share*f.x;
    to->shear[0] += share*f.y, to->shear[1] += share*f.z;
    to->torque += share*m.x;
    to->bending[0] += share*m.y, to->bending[1] += share*m.z;
    to->stress = fabs(stress) <= fabs(to->stress) ? to->stress : stress;
}

/* Of a condensed bar: the superelement with its weight pushes its nodes, less what it takes for its motion. */
static void add_inner_of_piece(const lw_dynamics *d, const lw_space_moment *m, const lw_elastic_chain *c, int i, lw_space_inner *out)
{
    const lw_space *s = &d->space->s;
    const lw_superelement *p = &d->space->model->super[c->first_beam + i];
    double load[12];
    memcpy(load, lw_space_super(&d->space->f, m->frame, m->v, c->first_beam + i), sizeof load);
    const double *takes = lw_space_super_inertia(&d->space->f, m->frame, m->v, m->a, c->first_beam + i);
    for (int end = 0; end < 2; end++) {
        int b = s->body_of[p->link[end]];
        const double *f = load + 6*end, *g = takes + 6*end, sign = end ? -1 : 1;
        lw_mat3 back = lw_quaternion_matrix(lw_quaternion_inverse(s->axes[b])), at_start = lw_m3_times(&back, &p->section[end]);
        lw_mat3 axes = lw_m3_times(&m->frame[b + 1].turn, &at_start);
        lw_vec3 force = lw_v3(f[0] - g[0], f[1] - g[1], f[2] - g[2]), moment = lw_v3(f[3] - g[3], f[4] - g[4], f[5] - g[5]);
        add_line_loads(d, m, c->first_beam + i, p->link[end], &force, &moment);
        add_inner(c, i + end, c->n_bound, &axes, lw_v3_scale(force, sign), lw_v3_scale(moment, sign), &out[i + end]);
    }
}

void lw_dynamics_space_inner(const lw_dynamics *d, const lw_space_moment *m, int chain, lw_space_inner *out)
{
    const lw_elastic_chain *c = &d->spatial_expansion.chain[chain];
    memset(out, 0, (size_t)c->n_node*sizeof *out);
    for (int i = 0; i + 1 < c->n_bound && c->elastic->n_node == 0; i++) {
        lw_beam_space_state z;
        if (c->condensed) {
            add_inner_of_piece(d, m, c, i, out);
            continue;
        }
        const lw_space_forces *f = &d->space->f;
        lw_space_beam(f, m->frame, m->v, c->first_beam + i, false, &z);
        for (int end = 0; end < 2; end++) {
            const double *on = z.force + 6*end, sign = end ? -1 : 1;
            int b = d->space->s.body_of[c->node[i + end]];
            lw_mat3 axes = lw_m3_times(&m->frame[b + 1].turn, &f->beam[c->first_beam + i].axes[end]);
            lw_vec3 force = lw_v3(on[0], on[1], on[2]), moment = lw_v3(on[3], on[4], on[5]);
            add_line_loads(d, m, c->first_beam + i, c->node[i + end], &force, &moment);
            add_inner(c, i + end, c->n_bound, &axes, lw_v3_scale(force, sign), lw_v3_scale(moment, sign), &out[i + end]);
        }
    }
}

void lw_dynamics_space_momentum(const lw_dynamics *d, const lw_space_moment *m, lw_vec3 *linear, lw_vec3 *angular)
{
    lw_space_momentum(&d->space->f, m->frame, m->v, linear, angular);
}

void lw_space_links(const lw_space *s, const lw_space_moment *m, lw_frame_motion *out)
{
    for (int i = 0; i < s->model->n_link; i++) {
        int b = s->body_of[i];
        out[i] = (lw_frame_motion){ .turn = { 1, 0, 0, 0 } };
        if (b < 0)
            continue;
        const double *q = m->q + 7*b, *v = m->v + 6*b, *a = m->a + 6*b, u = s->unit;
        lw_quaternion turn = lw_quaternion_times((lw_quaternion){ q[3], q[4], q[5], q[6] },
                                                 lw_quaternion_inverse(s->axes[b]));
        out[i] = (lw_frame_motion){ { u*q[0], u*q[1], u*q[2] }, { u*v[0], u*v[1], u*v[2] }, { u*a[0], u*a[1], u*a[2] },
                                    lw_quaternion_unit(turn), lw_space_omega(m->frame, b, m->v), lw_space_omega(m->frame, b, m->a) };
    }
}

double lw_dynamics_space_strain(const lw_dynamics *d, const lw_space_moment *m) { return lw_space_strain(&d->space->f, m->frame); }

double lw_dynamics_space_signal(const lw_dynamics *d, int i, const lw_space_moment *m)
{
    return lw_space_signal(&d->space->f, i, m->t, m->frame, m->v);
}

lw_space_touch lw_dynamics_space_touch(const lw_dynamics *d, int i, const lw_space_moment *m)
{
    return lw_space_touch_of(&d->space->f, m->frame, m->v, i);
}

const lw_space_contact *lw_dynamics_space_contact(const lw_dynamics *d, int i) { return &d->space->f.contact[i]; }

/* ---- making ----------------------------------------------------------------------------------------------------- */

/* The model with its elastic links as chains of nodes, or as rigid bars. */
static lw_status expand(lw_dynamics *d, const lw_spatial **m, lw_error *e)
{
    if (!(*m)->n_elastic)
        return LW_OK;
    d->elastic = !d->o.rigid;
    lw_status st = d->elastic ? lw_spatial_expand(*m, lw_dynamics_in_time(d), &d->spatial_expansion, e)
                  : lw_spatial_rigid(*m, &d->spatial_rigid, e);
    *m = d->elastic ? &d->spatial_expansion.model : &d->spatial_rigid;
    return st;
}

/* Does this run open the clearances of the model? */
static bool opens(const lw_dynamics *d, const lw_spatial *m)
{
    bool any = false, time = d->o.analysis == LW_ANALYSIS_TRANSIENT || d->o.analysis == LW_ANALYSIS_DYNAMIC;
    for (int j = 0; j < m->n_joint; j++)
        any = any || lw_spatial_has_clearance(&m->joint[j]);
    return any && time && !d->o.closed;
}

/* Errors of a step are small beside clearances: parts of the gap, and of the depth over which damping grows. */
static const double finest_gap = 2e-3, finest_depth = 0.1;

static void bound_tolerance(lw_dynamics *d)
{
    const lw_space_forces *f = &d->space->f;
    for (int i = 0; i < d->space->model->n_contact; i++) {
        const lw_clearance *c = f->contact[i].law;
        double most = fmin(finest_gap*c->gap, lw_contact_rises(c) ? finest_depth*c->depth : INFINITY)/d->space->s.unit;
        d->o.relative = fmin(d->o.relative, most), d->o.absolute = fmin(d->o.absolute, most);
    }
}

/* Elastic bars between ball joints spin about their line as rigid ones do: hold these spins at their first nodes. */
static lw_status hold_spins(lw_dynamics *d, const lw_spatial *given, lw_error *e)
{
    const lw_spatial_expansion *x = &d->spatial_expansion;
    lw_space rigid;
    lw_status st = lw_space_make(given, &rigid, e);
    lw_space_extra *idle = st == LW_OK ? calloc((size_t)rigid.n_body + 1, sizeof *idle) : NULL;
    if (st == LW_OK && !idle)
        st = lw_error_set(e, LW_E_MEMORY, "out of memory");
    int n = st == LW_OK ? lw_space_idle(&rigid, false, idle) : 0;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < x->n_chain; k++) {
            const lw_elastic *p = x->chain[k].elastic;
            bool alike = p->n_node == 0 && !(lw_v3_norm(p->height) > 0) && (p->n_axis == 0 || p->n_axis == 2);
            if (x->chain[k].link != rigid.link_of[idle[i].body] || !alike)
                continue;
            int node = d->space->s.body_of[x->chain[k].node[0]];
            lw_mat3 from = lw_quaternion_matrix(rigid.axes[idle[i].body]), to = lw_quaternion_matrix(d->space->s.axes[node]);
            lw_spatial_scene_hold(d->space, node, lw_m3_unapply(&to, lw_m3_apply(&from, idle[i].axis)));
        }
    free(idle);
    lw_space_free(&rigid);
    return st;
}

/* Where body b is, or the node that it is, on the links of the rigid model, whose frames and velocities are given; how fast,
 * unless v is NULL. */
static void place_on_rigid(const lw_dynamics *d, const lw_space *rigid, const lw_space_frame *frame, const double *rates, int b,
                           double *q, double *v)
{
    const lw_space *s = &d->space->s;
    const lw_spatial_expansion *x = &d->spatial_expansion;
    int link = s->link_of[b];
    for (int k = 0; k < x->n_chain; k++)
        for (int i = 1; i < x->chain[k].n_node; i++)
            link = x->chain[k].node[i] == s->link_of[b] ? x->chain[k].link : link;
    const double *file = s->start + 7*b;
    lw_space_point p = lw_space_point_of(rigid, link, lw_v3_scale(lw_v3(file[0], file[1], file[2]), s->unit));
    lw_vec3 at = lw_v3_scale(lw_space_point_at(frame, p), 1/s->unit);
    lw_quaternion now = lw_quaternion_of_matrix(&frame[p.body + 1].turn);
    lw_quaternion t = lw_quaternion_times(lw_quaternion_times(now, lw_quaternion_inverse(rigid->axes[p.body])), s->axes[b]);
    q[0] = at.x, q[1] = at.y, q[2] = at.z, q[3] = t.w, q[4] = t.x, q[5] = t.y, q[6] = t.z;
    if (!v)
        return;
    lw_vec3 rate = lw_v3_scale(lw_space_point_velocity(rigid, frame, p, rates), 1/s->unit);
    lw_mat3 turn = lw_quaternion_matrix(lw_quaternion_unit(t));
    lw_vec3 omega = lw_m3_unapply(&turn, lw_space_omega(frame, p.body, rates));
    v[0] = rate.x, v[1] = rate.y, v[2] = rate.z, v[3] = omega.x, v[4] = omega.y, v[5] = omega.z;
}

/* Start elastic links undeformed, pins in the middle of their bushes, with the posture and the velocities of the same model with
 * rigid links and joints without clearance. */
static lw_status start_as_rigid(lw_dynamics *d, const lw_spatial *given, lw_error *e)
{
    lw_dynamics *r = calloc(1, sizeof *r);
    if (!r)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    r->o = d->o;
    r->o.rigid = r->o.closed = true;
    lw_status st = lw_dynamics_prepare_spatial(r, given, e);
    if (st == LW_OK)
        lw_space_place(&r->space->s, r->start_q, r->space->frame);
    for (int b = 0; st == LW_OK && b < d->space->s.n_body; b++)
        place_on_rigid(d, &r->space->s, r->space->frame, r->start_v, b, d->start_q + 7*b, d->start_v + 6*b);
    lw_dynamics_free(r);
    if (st != LW_OK)
        return st;
    d->eq.accept(d->eq.context, d->start_q);
    if ((st = lw_mbs_arrange(d, d->o.from, d->start_q)) == LW_OK &&
        (st = lw_mbs_project_q(d, d->o.from, d->start_q, 0.01)) == LW_OK &&
        (st = lw_mbs_project_v(d, d->o.from, d->start_v)) == LW_OK)
        st = lw_mbs_arrange(d, d->o.from, d->start_q);
    return st;
}

lw_status lw_dynamics_place_on_rigid(lw_dynamics *d, const lw_space *rigid, const double *rigid_q, double *q, lw_error *e)
{
    lw_space_frame *frame = malloc(((size_t)rigid->n_body + 1)*sizeof *frame);
    if (!frame)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_space_place(rigid, rigid_q, frame);
    for (int b = 0; b < d->space->s.n_body; b++)
        place_on_rigid(d, rigid, frame, NULL, b, q + 7*b, NULL);
    free(frame);
    d->e = e;
    d->eq.accept(d->eq.context, q);
    return lw_mbs_arrange(d, d->o.from, q);
}

/* Forget the mass that a static analysis made up if no joint lets it move, as the spin of a slender rod on a pin. */
static lw_status judge_massless(lw_dynamics *d, lw_error *e)
{
    static const double still = 1e-9;
    lw_spatial_scene *c = d->space;
    lw_space_rows_set z;
    double *push = calloc(3*(size_t)d->n_v, sizeof *push), *by = push + d->n_v, *weight = by + d->n_v;
    if (!push)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_space_metric(&c->s, weight);
    lw_status st = lw_space_rows_make(&c->s, c->idle, c->n_idle, weight, c->s.start, &z, e);
    if (st == LW_OK) {
        double *l = calloc((size_t)z.n_row + 1, sizeof *l);
        st = l ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
        lw_space_rows_fill(&z, c->s.start, z.near);
        bool moves = st != LW_OK || !lw_space_rows_factor(&z);
        for (int i = 0; i < d->n_v && !moves; i++) {
            if (c->mass[i] == c->s.mass[i] || c->s.mass[i] > 0)
                continue;
            push[i] = 1;
            moves = !lw_space_rows_solve(&z, push, NULL, true, by, l) || by[i] > still*weight[i];
            push[i] = 0;
            c->massless = moves ? i/6 : c->massless;
        }
        c->massless = moves ? c->massless : -1;
        free(l);
    }
    lw_space_rows_free(&z);
    free(push);
    return st;
}

/* At rest no mass matters to the multipliers: rows of a link of next to no inertia must not look dependent. */
static void weigh_alike(lw_dynamics *d)
{
    static const double least = 1e-3;
    double top = 0;
    for (int i = 0; i < d->n_v; i++)
        top = fmax(top, d->eq.mass[i]);
    for (int i = 0; i < d->n_v; i++)
        d->by_mass[i] = 1/fmax(d->eq.mass[i], least*top);
}

lw_status lw_dynamics_prepare_spatial(lw_dynamics *d, const lw_spatial *m, lw_error *e)
{
    d->e = e;
    d->space = calloc(1, sizeof *d->space);
    if (!d->space)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    bool bends = m->n_elastic > 0 && !d->o.rigid;
    lw_status st = bends ? LW_NOTHING : lw_space_adjust(m, &d->spatial_adjusted, e);
    if (st < 0)
        return st;
    const lw_spatial *given = m = st == LW_OK ? &d->spatial_adjusted.model : m;
    st = expand(d, &m, e);
    bool open = st == LW_OK && opens(d, given);
    if (open) {
        st = lw_spatial_open(m, &d->spatial_open, e);
        m = &d->spatial_open;
    }
    if (st == LW_OK)
        st = lw_spatial_scene_make(m, d->space, e);
    if (st == LW_OK && d->elastic)
        st = hold_spins(d, given, e);
    if (st == LW_OK) {
        lw_mbs_take_equations(d, lw_spatial_equations(d->space));
        for (int i = 0; i < m->n_beam; i++)                          /* modes and statics alone know such masses */
            d->eq.more_inertia = m->beam[i].consistent ? NULL : d->eq.more_inertia;
        d->n_input = m->n_input;
        st = lw_mbs_reserve_lists(d, (size_t)m->n_joint, 3*(size_t)m->n_joint, (size_t)m->n_input, e);
    }
    if (st != LW_OK)
        return st;
    find_special_joints(d);
    bool rest = d->o.analysis == LW_ANALYSIS_STATIC;
    d->large = d->n_v > LW_MBS_DENSE || rest || d->elastic;
    if (d->large)
        st = lw_spatial_weigh_massless(d->space, rest, e);
    if (st == LW_OK && d->space->massless >= 0)
        st = judge_massless(d, e);
    if (st == LW_OK && d->large)
        d->has_zero_mass = false;
    if (st == LW_OK && d->n_stop > LW_EVENT_MAX/2)
        st = lw_error_set(e, LW_E_ARG, "more than %d rigid stops", LW_EVENT_MAX/2);
    if (st == LW_OK)
        st = lw_mbs_reserve(d, e);
    if (st == LW_OK && rest)
        weigh_alike(d);
    if (open)
        bound_tolerance(d);
    if (st == LW_OK && (d->elastic || open))
        st = start_as_rigid(d, given, e);
    else if (st == LW_OK && (st = find_posture(d, e)) == LW_OK && !rest &&
             (d->freedom > 0 || d->o.closed || (lw_dynamics_in_time(d) && needs_velocities(d, m))))
        st = find_velocities(d, e);
    if (st == LW_OK)
        st = lw_mbs_start_states(d, e);
    return st == LW_OK ? make_drives(d, e) : st;
}
