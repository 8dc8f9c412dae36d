/* mbs/dynamics/dynamics_make.c - a model made ready: system, memory, a start that satisfies the constraints. */
#include "mbs/dynamics/dynamics_equations_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/ode/integrate.h"

static const double nudge = 0.02;        /* distance at which the rank is checked again, scaled */

const lw_dynamics_report *lw_dynamics_choice(const lw_dynamics *d) { return &d->choice; }
const lw_system *lw_dynamics_system(const lw_dynamics *d) { return &d->s; }
const lw_forces *lw_dynamics_forces(const lw_dynamics *d) { return &d->f; }
bool lw_dynamics_starts_at_rest(const lw_dynamics *d, int i) { return d->at_rest[i]; }
void lw_dynamics_start(const lw_dynamics *d, double *q, double *v)
{
    memcpy(q, d->start_q, (size_t)d->n_q*sizeof *q);
    memcpy(v, d->start_v, (size_t)d->n_q*sizeof *v);
}

/* ---- memory ------------------------------------------------------------------------------------ */

typedef struct piece { double **to; size_t n; } piece;

static lw_status reserve(lw_dynamics *d, lw_error *e)
{
    size_t q = (size_t)d->n_q, c = (size_t)(d->n_row + d->n_driven + (d->n_stop ? LW_STOP_ROW_MAX : 0));
    size_t all = 0, speeds = c + LW_INPUT_MAX;
    const piece pieces[] = {
        { &d->phi, c }, { &d->jac, c*q }, { &d->rhs, speeds }, { &d->schur, c*c }, { &d->diag, c }, { &d->by_mass, q },
        { &d->rank_work, lw_rank_doubles((int)q, (int)speeds) }, { &d->null, q*q }, { &d->mass_null, q*q },
        { &d->small, c + q }, { &d->force, q }, { &d->bias, q }, { &d->q_try, q }, { &d->v_try, q }, { &d->a, q },
        { &d->l, c }, { &d->l_each, 2*c }, { &d->hold, q }, { &d->start_q, q }, { &d->start_v, q },
        { &d->hold_rows, c*q }, { &d->speed_rows, speeds*q }, { &d->response, (size_t)d->n_friction*(q + c) },
    };
    for (size_t i = 0; i < sizeof pieces/sizeof *pieces; i++)
        all += pieces[i].n;
    d->most_pair = (int)(c*c);
    d->work = calloc(all, sizeof *d->work);
    d->rank_ints = calloc(lw_rank_ints((int)q, (int)speeds), sizeof *d->rank_ints);
    d->pair = calloc((size_t)d->most_pair*LW_SYSTEM_ROW_BODIES, sizeof *d->pair);
    d->after = calloc(c*c + 1, sizeof *d->after);
    d->near = calloc(c*c + 1, 1);
    d->frames = calloc((size_t)d->s.n_body + 1, sizeof *d->frames);
    if (!d->frames || !d->work || !d->rank_ints || !d->pair || !d->after || !d->near)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    all = 0;
    for (size_t i = 0; i < sizeof pieces/sizeof *pieces; i++) {
        *pieces[i].to = d->work + all;
        all += pieces[i].n;
    }
    for (size_t i = 0; i < q; i++)
        d->by_mass[i] = 1/d->f.mass[i];
    return LW_OK;
}

void lw_dynamics_free(lw_dynamics *d)
{
    if (!d)
        return;
    free(d->work);
    free(d->rank_ints);
    free(d->pair);
    free(d->after);
    free(d->near);
    free(d->frames);
    lw_forces_free(&d->f);
    lw_system_free(&d->s);
    free(d->reduced);
    free(d->rule);
    free(d);
}

/* ---- start ------------------------------------------------------------------------------------- */

/* Is the start singular?  Compare its rank with that of a posture near by: along the velocities or, at rest, along
 * some motion. */
static lw_status rank_nearby(lw_dynamics *d, double t, const double *q, const double *v)
{
    double *dir = d->a, size = 0;
    if (lw_mbs_rows(d, t, q) != LW_OK)
        return LW_E_NUMERIC;
    int freedom = d->freedom, rank = d->rank;
    lw_status s = lw_mbs_factor(d, true);
    memcpy(dir, v, (size_t)d->n_q*sizeof *dir);
    for (int i = 0; i < d->n_q; i++)
        size = fmax(size, fabs(dir[i]));
    if (!(size > 0))
        for (int k = 0; k < freedom; k++) {
            lw_rank_left_null(&d->rank_of, k, d->bias);
            for (int i = 0; i < d->n_q; i++)
                dir[i] += d->bias[i]*(1 + 0.3*k);
        }
    size = 0;
    for (int i = 0; i < d->n_q; i++)
        size = fmax(size, fabs(dir[i]));
    if (!(size > 0))
        return s;
    for (int i = 0; i < d->n_q; i++)
        d->q_try[i] = q[i] + nudge*dir[i]/size;
    d->rank = 0, d->freedom = d->n_q;
    if (lw_mbs_project_q(d, t, d->q_try, 1) == LW_OK && lw_mbs_rows(d, t, d->q_try) == LW_OK) {
        lw_mbs_factor(d, true);
        if (d->rank_of.rank > rank)
            return lw_error_set(d->e, LW_E_NUMERIC, "the posture at the start is singular: from there the linkage can "
                                "go on in several ways; start it from a posture nearby");
    }
    d->rank = rank, d->freedom = freedom;
    return LW_OK;
}

/* Move the driven inputs from the posture to where their motions begin, in steps short enough to keep the assembly
 * mode. */
static lw_status move_inputs_to_start(lw_dynamics *d, double *q)
{
    double *from = d->v_try, distance[LW_INPUT_MAX], most = 0;
    lw_status s = lw_mbs_rows(d, d->o.from, q);
    for (int i = 0; s == LW_OK && i < d->n_driven; i++) {
        distance[i] = -d->phi[d->n_row + i];
        most = fmax(most, fabs(distance[i]));
    }
    int steps = 1 + (int)(most/0.05);
    for (int k = 1; s == LW_OK && k <= steps && most > 0; k++) {
        for (int pass = 0; s == LW_OK && pass < 20; pass++) {
            double off = 0;
            s = lw_mbs_rows(d, d->o.from, q);
            for (int r = 0; r < d->n_c; r++) {
                int driven = r - d->n_row;
                double left = driven >= 0 && driven < d->n_driven ? distance[driven]*(1 - (double)k/steps) : 0;
                d->rhs[r] = -d->phi[r] - left;
                off = fmax(off, fabs(d->rhs[r]));
            }
            if (off < 1e-13)
                break;
            if (pass == 19 || s != LW_OK || lw_mbs_factor(d, true) != LW_OK)
                return LW_OPEN;
            lw_rank_solve_transposed(&d->rank_of, d->rhs, from);
            for (int i = 0; i < d->n_q; i++)
                q[i] += from[i];
        }
    }
    return s;
}

/* The inputs with a motion, in the order of context's list. */
static void driven_inputs(void *context, double t, int order, double *u)
{
    const lw_dynamics *d = context;
    double at[LW_SERIES_ORDER_MAX + 1] = { t, 1 };
    for (int i = 0; i < d->n_driven; i++)
        lw_expression_series(d->model->motion[d->driven[i]], order, at, u + i*(order + 1));
}

lw_status lw_mbs_follow(const lw_dynamics *d, lw_system *s, lw_prescribed_motion **out, lw_error *e)
{
    *out = NULL;
    if (d->s.n_tie && d->driven[0] != 0)
        return lw_error_set(e, LW_E_KIND, "inputs are tied to input 1, which needs a \"motion\"");
    if (lw_system_choose_inputs(&d->s, d->driven, d->n_driven, s) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    return lw_prescribed_motion_create(s, driven_inputs, (void *)(uintptr_t)d, d->o.from, out, e);
}

/* Where every freedom is driven, the start is on the motion that a run follows. */
static lw_status start_on_motion(lw_dynamics *d, double *q, lw_error *e)
{
    lw_prescribed_motion *motion;
    lw_system system = { 0 };
    lw_status s = lw_mbs_follow(d, &system, &motion, e);
    if (s == LW_OK)
        memcpy(q, lw_prescribed_motion_pose(motion), (size_t)d->n_q*sizeof *q);
    lw_prescribed_motion_free(motion);
    lw_system_free(&system);
    return s == LW_OK ? lw_mbs_arrange(d, d->o.from, q) : s;
}

static lw_status find_posture(lw_dynamics *d, lw_error *e)
{
    double *q = d->start_q;
    int driven = d->n_driven;
    lw_system_posture(&d->s, q);
    memcpy(d->a, q, (size_t)d->n_q*sizeof *q);
    /* first without motions: close a posture that is not quite closed */
    d->n_driven = 0;
    lw_status s = lw_mbs_arrange(d, d->o.from, q);
    if (s == LW_OK)
        s = lw_mbs_project_q(d, d->o.from, q, 1);
    if (s < 0)
        return s;
    if (s == LW_OPEN)
        return lw_error_set(e, LW_OPEN, "the posture of the file does not close, and no closed one is near");
    for (int i = 0; i < d->n_q; i++)
        d->moved = fmax(d->moved, fabs(q[i] - d->a[i]));
    int rank = d->rank;
    d->n_driven = driven;
    s = lw_mbs_arrange(d, d->o.from, q);
    if (s == LW_OK && d->rank < rank + driven)
        return lw_error_set(e, LW_E_ARG, "%d inputs have a motion but only %d can be moved independently; leave "
                            "motions out", driven, d->rank - rank);
    if (s == LW_OK && driven && d->freedom == 0)
        return start_on_motion(d, q, e);
    if (s == LW_OK && driven)
        s = move_inputs_to_start(d, q);
    if (s == LW_OPEN)
        return lw_error_set(e, LW_OPEN, "the linkage cannot get from the posture of the file to where its motions "
                            "begin");
    return s == LW_OK ? lw_mbs_arrange(d, d->o.from, q) : s;
}

/* Difference between the rate of input i at the start and the speed given. */
static double speed_off(const lw_dynamics *d, int i)
{
    double row[LW_SYSTEM_Q_MAX];
    int j = d->s.input_joint[i];
    if (!d->model->has_speed[i])
        return 0;
    lw_system_measure(&d->s, j, d->start_q, row);
    double off = -d->model->speed[i]/lw_system_joint_unit(&d->s, j);
    for (int c = 0; c < d->n_q; c++)
        off += row[c]*d->start_v[c];
    return fabs(off);
}

/* Add the rate of input i to the rows of r, of which there are *n, if it is independent of them or was given; the rate
 * is 0 unless it was given. */
static void add_speed(lw_dynamics *d, lw_rank *r, int i, int *n)
{
    int j = d->s.input_joint[i], rank, before = *n;
    size_t rows = (size_t)before*(size_t)d->n_q;
    double *kept = d->speed_rows;
    lw_system_measure(&d->s, j, d->start_q, kept + rows);
    d->rhs[before] = d->model->has_speed[i] ? d->model->speed[i]/lw_system_joint_unit(&d->s, j) : 0;
    *n = before + 1;
    if (d->model->has_speed[i])
        return;
    lw_rank_place(r, d->n_q, before, d->rank_work, d->rank_ints);
    memcpy(r->a, kept, rows*sizeof *kept);
    lw_rank_factor(r, LW_RANK_TOLERANCE);
    rank = r->rank;
    lw_rank_place(r, d->n_q, before + 1, d->rank_work, d->rank_ints);
    memcpy(r->a, kept, (rows + (size_t)d->n_q)*sizeof *kept);
    lw_rank_factor(r, LW_RANK_TOLERANCE);
    if (r->rank == rank)
        *n = before;
    else
        d->at_rest[i] = true;
}

/* The least velocities that satisfy the constraints and give the inputs their speeds.  Inputs without a motion and
 * without a speed are at rest where the others allow it. */
static lw_status find_velocities(lw_dynamics *d, lw_error *e)
{
    lw_rank r;
    int n = d->n_c;
    lw_status s = lw_mbs_rows(d, d->o.from, d->start_q);
    if (s == LW_OK)
        s = lw_mbs_rate_wanted(d, d->o.from);
    if (s != LW_OK)
        return s;
    memcpy(d->speed_rows, d->jac, (size_t)d->n_c*(size_t)d->n_q*sizeof *d->jac);
    for (int given = 1; given >= 0; given--)
        for (int i = 0; i < d->s.n_input; i++)
            if (d->model->has_speed[i] == (bool)given && !d->model->motion[i])
                add_speed(d, &r, i, &n);
    lw_rank_place(&r, d->n_q, n, d->rank_work, d->rank_ints);
    memcpy(r.a, d->speed_rows, (size_t)n*(size_t)d->n_q*sizeof *r.a);
    lw_rank_factor(&r, LW_RANK_TOLERANCE);
    lw_rank_solve_transposed(&r, d->rhs, d->start_v);
    s = lw_mbs_arrange(d, d->o.from, d->start_q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    if (s == LW_OK)
        s = lw_mbs_project_v(d, d->o.from, d->start_v);
    for (int i = 0; i < d->s.n_input; i++)
        d->moved_rate = fmax(d->moved_rate, speed_off(d, i));
    for (int i = 0; s == LW_OK && i < d->n_q; i++)
        if (!isfinite(d->start_v[i]))
            return lw_error_set(e, LW_E_NUMERIC, "no velocities at the start satisfy the constraints");
    return s;
}

static void find_special_joints(lw_dynamics *d)
{
    const lw_model *m = d->model;
    d->n_stop = lw_rigid_stops_find(m, &d->s, d->stop);
    for (int j = 0; j < d->s.n_joint; j++)
        if (m->friction[j].coefficient > 0) {
            d->friction_row[d->n_friction] = d->s.joint[j].row;
            d->friction[d->n_friction++] = lw_friction_joint_of(m, j);
        }
    for (int i = 0; i < d->s.n_input; i++)
        if (m->motion[i])
            d->driven[d->n_driven++] = i;
    for (int i = 0; i < d->n_q; i++)
        d->has_zero_mass = d->has_zero_mass || !(d->f.mass[i] > 0);
}

lw_status lw_dynamics_prepare(lw_dynamics *d, lw_error *e)
{
    const lw_model *m = d->model;
    for (int j = 0; j < m->linkage.n_joint; j++)
        if (m->clearance[j].model > LW_CLEARANCE_ZERO)
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" has a clearance; \"linkwright clearance\" runs such models",
                                m->linkage.joint[j].name);
    lw_status s = lw_forces_system(m, false, &d->s, e);
    if (s == LW_OK)
        s = lw_forces_make(m, &d->s, &d->o.force, &d->f, e);
    if (s != LW_OK)
        return s;
    d->n_q = d->s.n_q;
    d->n_row = d->s.n_row;
    find_special_joints(d);
    if (d->n_stop > LW_EVENT_MAX/2)
        return lw_error_set(e, LW_E_ARG, "more than %d rigid stops", LW_EVENT_MAX/2);
    if ((s = reserve(d, e)) != LW_OK)
        return s;
    d->e = e;
    if ((s = find_posture(d, e)) == LW_OK)
        s = find_velocities(d, e);
    if (s == LW_OK)
        s = rank_nearby(d, d->o.from, d->start_q, d->start_v);
    if (s == LW_OK)
        s = lw_mbs_arrange(d, d->o.from, d->start_q);
    return s;
}

void lw_dynamics_joint_rows(const lw_dynamics *d, int joint, const double *q, double *phi, double *jac)
{
    double all_phi[LW_SYSTEM_ROW_MAX];
    int first = d->s.joint[joint].row, next = joint + 1 < d->s.n_joint ? d->s.joint[joint + 1].row : d->s.tie_row;
    lw_system_rows(&d->s, q, all_phi, d->hold_rows);
    memcpy(phi, all_phi + first, (size_t)(next - first)*sizeof *phi);
    memcpy(jac, d->hold_rows + first*d->n_q, (size_t)(next - first)*(size_t)d->n_q*sizeof *jac);
}

/* The reactions of a joint are unique where the null space of J^T has no part in its rows. */
void lw_dynamics_redundant(const lw_dynamics *c, char *text, size_t size)
{
    lw_dynamics *d = (lw_dynamics *)(uintptr_t)c;
    size_t used = 0;
    double *x = d->l_each;
    bool seen[LW_JOINT_MAX] = { false };
    *text = '\0';
    if (d->rank == d->n_c || lw_mbs_rows(d, d->o.from, d->start_q) != LW_OK || lw_mbs_factor(d, true) != LW_OK)
        return;
    for (int r = 0; r < d->n_row; r++) {
        double left = 0;
        memset(x, 0, (size_t)d->n_c*sizeof *x);
        x[r] = 1;
        lw_rank_null_part(&d->rank_of, x);
        for (int i = 0; i < d->n_c; i++)
            left = fmax(left, fabs(x[i]));
        int j = d->s.row[r].joint;
        if (left > LW_RANK_TOLERANCE && !seen[j] && used < size)
            used += (size_t)snprintf(text + used, size - used, " %s", d->model->linkage.joint[j].name);
        seen[j] = seen[j] || left > LW_RANK_TOLERANCE;
    }
}
