/* mbs/dynamics/dynamics_make.c - a model made ready: system, memory, a start that satisfies the constraints. */
#include "base/real.h"
#include "mbs/dynamics/dynamics_equations_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/constraints/adjust.h"
#include "mbs/dynamics/follow_internal.h"
#include "mbs/dynamics/tangent_internal.h"
#include "mbs/dynamics/touch_internal.h"
#include "mbs/ode/integrate.h"
#include "mbs/space/recursive_stages.h"

lw_dynamics_options lw_dynamics_options_default(void)
{
    return (lw_dynamics_options){ .to = 1, .intervals = 100, .relative = 1e-10, .absolute = 1e-10, .rho = 0.8 };
}

const char *lw_formulation_name(lw_formulation f)
{
    static const char *const names[] = { "auto",
#define X(id, name, text) #name,
        LW_FORMULATION_LIST(X)
#undef X
    };
    return names[f];
}

static const double nudge = 0.02;        /* distance at which the rank is checked again, scaled */
static const double far_apart = 1e4;    /* ratio of masses from which on light ones are corrected */

const lw_dynamics_report *lw_dynamics_choice(const lw_dynamics *d) { return &d->choice; }
const lw_model *lw_dynamics_model(const lw_dynamics *d) { return d->model; }
bool lw_dynamics_in_time(const lw_dynamics *d)
{
    return d->o.analysis != LW_ANALYSIS_STATIC && d->o.analysis != LW_ANALYSIS_QUASISTATIC;
}

const lw_elastic_expansion *lw_dynamics_elastic(const lw_dynamics *d) { return d->elastic ? &d->expansion : NULL; }
const lw_system *lw_dynamics_system(const lw_dynamics *d) { return &d->s; }
const lw_forces *lw_dynamics_forces(const lw_dynamics *d) { return &d->f; }
int lw_dynamics_inputs(const lw_dynamics *d) { return d->n_input; }
const char *lw_dynamics_input_name(const lw_dynamics *d, int i) { return d->eq.name(d->eq.context, LW_NAMED_INPUT, i); }
bool lw_dynamics_starts_at_rest(const lw_dynamics *d, int i) { return d->at_rest[i]; }
void lw_dynamics_start(const lw_dynamics *d, double *q, double *v)
{
    memcpy(q, d->start_q, (size_t)d->n_q*sizeof *q);
    memcpy(v, d->start_v, (size_t)d->n_v*sizeof *v);
}
const double *lw_dynamics_start_states(const lw_dynamics *d) { return d->start_z; }

void lw_mbs_take_equations(lw_dynamics *d, lw_equations eq)
{
    d->eq = eq;
    d->n_q = eq.n_q;
    d->n_v = eq.n_v;
    d->n_row = eq.n_row;
    d->accelerate = lw_tangent_accelerate;
}

/* ---- memory ------------------------------------------------------------------------------------ */

typedef struct piece { double **to; size_t n; } piece;
typedef struct int_piece { int **to; size_t n; } int_piece;

lw_status lw_mbs_reserve_lists(lw_dynamics *d, size_t joints, size_t stops, size_t inputs, lw_error *e)
{
    d->stop = calloc(stops + 1, sizeof *d->stop);
    d->friction = calloc(joints + 1, sizeof *d->friction);
    d->friction_row = calloc(joints + 1, sizeof *d->friction_row);
    d->driven = calloc(2*inputs + 2, sizeof *d->driven);
    d->driven_measure = d->driven + inputs + 1;
    d->held = calloc(inputs + 1, sizeof *d->held);
    d->at_rest = calloc(inputs + 1, sizeof *d->at_rest);
    return d->stop && d->friction && d->friction_row && d->driven && d->held && d->at_rest
         ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
}

/* A metric for the changes of links that have no mass, in a large model that is all driven: the greatest mass, at the distance
 * of the farthest joint. */
static void weigh_massless(lw_dynamics *d)
{
    double most = 0;
    for (int b = 0; b < d->s.n_body; b++)
        most = fmax(most, d->eq.mass[3*b]);
    for (int b = 0; b < d->s.n_body; b++)
        d->v_try[b] = 0;
    for (int j = 0; j < d->s.n_joint; j++)
        for (int end = 0; end < 2; end++) {
            int b = d->s.joint[j].body[end];
            if (b >= 0)
                d->v_try[b] = fmax(d->v_try[b], lw_v2_dot(d->s.joint[j].arm[end], d->s.joint[j].arm[end]));
        }
    for (int i = 0; i < d->n_v; i++)
        if (!(d->eq.mass[i] > 0)) {
            double far2 = d->v_try[i/3] > 0 ? d->v_try[i/3] : 1;
            d->by_mass[i] = 1/((most > 0 ? most : 1)*(i%3 == 2 ? far2 : 1));
            d->weighed = true;
        }
}

/* dense: 0 for large models, which know no way by rank. */
lw_status lw_mbs_reserve(lw_dynamics *d, lw_error *e)
{
    size_t inputs = (size_t)d->n_input, dense = d->large ? 0 : 1, q = (size_t)d->n_q, v = (size_t)d->n_v, c = (size_t)d->n_row + inputs;
    c += (d->n_stop || (d->space && d->n_friction) ? LW_STOP_ROW_MAX : 0) + (d->touch ? (size_t)d->touch->row_max : 0);
    size_t all = 0, n_int = 0, row = (size_t)(d->row_size = LW_BLOCK*d->eq.n_slot), speeds = c + inputs + LW_BLOCK*(size_t)d->n_velocity;
    const piece pieces[] = {
        { &d->phi, c }, { &d->jac, c*row }, { &d->jac_by_mass, c*row }, { &d->rhs, speeds }, { &d->by_mass, v },
        { &d->rank_work, dense*lw_rank_doubles((int)v, (int)speeds) }, { &d->null, dense*v*v }, { &d->mass_null, dense*v*v },
        { &d->small, 4*(c + v) }, { &d->force, v }, { &d->bias, v }, { &d->q_try, q }, { &d->v_try, v }, { &d->small_v, v },
        { &d->stop_v, v }, { &d->a, v }, { &d->l, c }, { &d->l_each, 3*c }, { &d->hold, v }, { &d->start_q, q }, { &d->drawn_q, q },
        { &d->start_v, v }, { &d->start_z, (size_t)d->eq.n_z }, { &d->along_null, v },
        { &d->speed_rows, dense*speeds*v }, { &d->rub, (size_t)d->n_friction + 2*(v + c) },
    };
    const int_piece ints[] = { { &d->kept, c }, { &d->place, c }, { &d->unknown, c },
                               { &d->rank_ints, dense*lw_rank_ints((int)v, (int)speeds) } };
    for (size_t i = 0; i < sizeof pieces/sizeof *pieces; i++)
        all += pieces[i].n;
    for (size_t i = 0; i < sizeof ints/sizeof *ints; i++)
        n_int += ints[i].n;
    d->work = calloc(all, sizeof *d->work);
    d->ints = calloc(n_int, sizeof *d->ints);
    d->row_block = calloc(c*(size_t)d->eq.n_slot, sizeof *d->row_block);
    d->bend = malloc((size_t)d->eq.bend_most*sizeof *d->bend);
    if (!d->work || !d->ints || !d->row_block || !d->bend)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    all = n_int = 0;
    for (size_t i = 0; i < sizeof pieces/sizeof *pieces; i++) {
        *pieces[i].to = d->work + all;
        all += pieces[i].n;
    }
    for (size_t i = 0; i < sizeof ints/sizeof *ints; i++) {
        *ints[i].to = d->ints + n_int;
        n_int += ints[i].n;
    }
    double most = 0, least = INFINITY;
    for (size_t i = 0; i < v; i++) {
        d->by_mass[i] = 1/d->eq.mass[i];
        most = fmax(most, d->eq.mass[i]), least = fmin(least, d->eq.mass[i] > 0 ? d->eq.mass[i] : INFINITY);
    }
    d->uneven = most > far_apart*least;
    if (d->large && !d->space)
        weigh_massless(d);
    return LW_OK;
}

void lw_dynamics_free(lw_dynamics *d)
{
    if (!d)
        return;
    void *const array[] = { d->work, d->ints, d->pair, d->weld, d->parts, d->row_block, d->bend, d->frames, d->stop, d->friction, d->friction_row,
                            d->driven, d->held, d->at_rest, d->reduced, d->rule, d->response };
    for (size_t i = 0; i < sizeof array/sizeof *array; i++)
        free(array[i]);
    if (d->masses)
        lw_tangent_free(d->masses);
    free(d->masses);
    lw_mbs_touch_free(d);
    lw_space_tree_free(d->tree);
    lw_cholesky_free(&d->schur);
    lw_mbs_free_fronts(d);
    lw_forces_free(&d->f);
    lw_system_free(&d->s);
    lw_elastic_expansion_free(&d->expansion);
    lw_elastic_rigid_free(&d->rigid);
    lw_spatial_expansion_free(&d->spatial_expansion);
    lw_space_adjusted_free(&d->spatial_adjusted);
    lw_spatial_rigid_free(&d->spatial_rigid);
    lw_spatial_open_free(&d->spatial_open);
    if (d->space)
        lw_spatial_scene_free(d->space);
    free(d->space);
    free(d);
}

/* ---- start ------------------------------------------------------------------------------------- */

/* Is the start singular?  Compare its rank with that of a posture near by, with driven inputs where they are there: along the velocities or,
 * at rest, along some motion. */
static lw_status rank_nearby(lw_dynamics *d, double t, const double *q, const double *v)
{
    double *dir = d->a, size = 0;
    if (lw_mbs_rows(d, t, q) != LW_OK)
        return LW_E_NUMERIC;
    int freedom = d->freedom, rank = d->rank;
    lw_status s = lw_mbs_factor(d, true);
    memcpy(dir, v, (size_t)d->n_v*sizeof *dir);
    for (int i = 0; i < d->n_v; i++)
        size = fmax(size, fabs(dir[i]));
    if (!(size > 0)) {
        for (int r = 0; r < d->n_c; r++)
            d->rhs[r] = r < d->n_row ? 0 : 1 + 0.3*(r - d->n_row);
        lw_rank_solve_transposed(&d->rank_of, d->rhs, dir);
        for (int k = 0; k < freedom; k++) {
            lw_rank_left_null(&d->rank_of, k, d->bias);
            for (int i = 0; i < d->n_v; i++)
                dir[i] += d->bias[i]*(1 + 0.3*k);
        }
    }
    size = 0;
    for (int i = 0; i < d->n_v; i++)
        size = fmax(size, fabs(dir[i]));
    if (!(size > 0))
        return s;
    for (int i = 0; i < d->n_v; i++)
        dir[i] *= nudge/size;
    memcpy(d->q_try, q, (size_t)d->n_q*sizeof *q);
    d->eq.move(d->eq.context, d->q_try, dir);
    lw_mbs_freeze(d, d->q_try);
    d->rank = 0, d->freedom = d->n_v;
    bool closed = lw_mbs_project_q(d, t, d->q_try, 1) == LW_OK && lw_mbs_rows(d, t, d->q_try) == LW_OK;
    d->frozen = false;
    if (closed) {
        lw_mbs_factor(d, true);
        if (d->rank_of.rank > rank)
            return lw_error_set(d->e, LW_E_NUMERIC, "the posture at the start is singular: from there the linkage can "
                                "go on in several ways; start it from a posture nearby");
    }
    d->rank = rank, d->freedom = freedom;
    return LW_OK;
}

/* The same for a large model: are the rows that were left out as dependent satisfied in a posture near by, to which the
 * others lead? */
static lw_status rank_nearby_large(lw_dynamics *d, double t, const double *q, const double *v)
{
    double size = 0;
    if (d->n_kept == d->n_c)
        return LW_OK;
    for (int i = 0; i < d->n_v; i++)
        size = fmax(size, fabs(v[i]));
    for (int i = 0; i < d->n_v; i++)                     /* at rest: any motion; its projection leads along the freedoms */
        d->hold[i] = nudge*(size > 0 ? v[i]/size : i%3 == 2 ? sin(1 + i) : 0);
    memcpy(d->q_try, q, (size_t)d->n_q*sizeof *q);
    d->eq.move(d->eq.context, d->q_try, d->hold);
    lw_mbs_freeze(d, d->q_try);
    double off = INFINITY;
    for (int pass = 0; pass < 20 && off > 1e-12; pass++) {
        if (lw_mbs_rows(d, t, d->q_try) != LW_OK || lw_mbs_factor(d, false) != LW_OK)
            break;
        off = 0;
        for (int r = 0; r < d->n_c; r++) {
            d->rhs[r] = -d->phi[r];
            off = d->place[r] >= 0 ? fmax(off, fabs(d->phi[r])) : off;
        }
        lw_mbs_linear(d, NULL, d->rhs, d->hold, d->l_each);
        d->eq.move(d->eq.context, d->q_try, d->hold);
    }
    d->frozen = false;
    if (!(off <= 1e-12))
        return lw_error_set(d->e, LW_E_NUMERIC, "%d constraints depend on others in the posture at the start, and it could "
                            "not be shown that they always do; start it from a posture nearby", d->n_c - d->n_kept);
    for (int r = 0; r < d->n_c; r++)
        if (fabs(d->phi[r]) > 1e-9)
            return lw_error_set(d->e, LW_E_NUMERIC, "the posture at the start is singular: from there the linkage can "
                                "go on in several ways; start it from a posture nearby");
    return LW_OK;
}

/* Hold input i, which has no motion, as if it had one, unless its row depends on the others in the posture. */
static lw_status hold_input(lw_dynamics *d, int i, const double *q)
{
    int n = d->n_driven, rank = d->rank;
    d->driven_measure[d->n_driven] = d->s.input_joint[i];
    d->driven[d->n_driven++] = i;
    lw_status s = lw_mbs_arrange(d, d->o.from, q);
    if (s != LW_OK || d->rank > rank)
        return s;
    d->n_driven = n;
    return lw_mbs_arrange(d, d->o.from, q);
}

/* Move the driven inputs from the posture to where their motions begin, in steps short enough to keep the assembly
 * mode. */
static lw_status move_inputs_to_start(lw_dynamics *d, double *q)
{
    double *from = d->v_try, *distance = d->l, most = 0;
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
            if (d->large)
                lw_mbs_linear(d, NULL, d->rhs, from, d->l_each);
            else
                lw_rank_solve_transposed(&d->rank_of, d->rhs, from);
            for (int i = 0; i < d->n_q; i++)
                q[i] += from[i];
        }
    }
    return s;
}

/* The same; the inputs without a motion keep their values where they can. */
static lw_status move_to_start(lw_dynamics *d, double *q)
{
    const int driven = d->n_driven;
    lw_status s = LW_OK;
    for (int i = 0; s == LW_OK && i < d->s.n_input; i++)
        if (!d->model->motion[i] && !d->o.hold_inputs)
            s = hold_input(d, i, q);
    bool held = d->n_driven > driven;
    memcpy(d->a, q, (size_t)d->n_q*sizeof *q);
    if (s == LW_OK)
        s = move_inputs_to_start(d, q);
    d->n_driven = driven;
    if (s != LW_OPEN || !held)
        return s;
    memcpy(q, d->a, (size_t)d->n_q*sizeof *q);
    s = lw_mbs_arrange(d, d->o.from, q);
    return s == LW_OK ? move_inputs_to_start(d, q) : s;
}

lw_status lw_mbs_follow(const lw_dynamics *d, lw_system *s, lw_prescribed_motion **out, lw_error *e)
{
    *out = NULL;
    if (d->s.n_tie && d->driven[0] != 0)
        return lw_error_set(e, LW_E_KIND, "inputs are tied to input 1, which needs a \"motion\"");
    if (lw_system_choose_inputs(&d->s, d->driven, d->n_driven, s) != LW_OK)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    return lw_prescribed_motion_create(s, d->drawn_q, lw_mbs_driven_inputs, (void *)(uintptr_t)d, d->o.from, out, e);
}

/* Where every freedom is driven, the start is on the motion that a run follows. */
static lw_status start_on_motion(lw_dynamics *d, double *q, lw_error *e)
{
    if (d->large) {
        lw_follow *f;
        lw_status st = lw_follow_ready(d, lw_mbs_driven_inputs, d, d->o.from, &f, e);
        if (st == LW_OK)
            memcpy(q, lw_follow_series(f), (size_t)d->n_q*sizeof *q);
        lw_follow_free(f);
        return st == LW_OK ? lw_mbs_arrange(d, d->o.from, q) : st;
    }
    lw_prescribed_motion *motion;
    lw_system system = { 0 };
    lw_status s = lw_mbs_follow(d, &system, &motion, e);
    if (s == LW_OK)
        memcpy(q, lw_prescribed_motion_posture(motion), (size_t)d->n_q*sizeof *q);
    lw_prescribed_motion_free(motion);
    lw_system_free(&system);
    return s == LW_OK ? lw_mbs_arrange(d, d->o.from, q) : s;
}

/* More inputs have a motion than the n_free that can move.  Names the last one without which as many can; the order of the inputs changes. */
static lw_status refuse_inputs(lw_dynamics *d, const double *q, int n_free, lw_error *e)
{
    const int rank = d->rank, last = --d->n_driven;
    const char *name = "";
    for (int i = last; i >= 0 && !*name; i--) {
        const int out = d->driven[i], measure = d->driven_measure[i];
        d->driven[i] = d->driven[last], d->driven_measure[i] = d->driven_measure[last];
        d->driven[last] = out, d->driven_measure[last] = measure;
        if (lw_mbs_arrange(d, d->o.from, q) == LW_OK && d->rank == rank)
            name = lw_dynamics_input_name(d, out);
    }
    return lw_error_set(e, LW_E_ARG, "%d inputs have a motion but only %d can be moved independently; leave motions out, as that of \"%s\", which follows "
                        "from the others", last + 1, n_free, name);
}

static lw_status find_posture(lw_dynamics *d, lw_error *e)
{
    double *q = d->start_q;
    int driven = d->n_driven;
    lw_system_posture(&d->s, q);
    memcpy(d->a, q, (size_t)d->n_q*sizeof *q);
    /* first without motions: close a posture that is not quite closed */
    d->n_driven = 0;
    d->rank_alone = -1;
    lw_status s = d->large ? LW_NOTHING : lw_system_adjust(&d->s, q, &d->adjusted, e);
    if (s < 0)
        return s;
    s = lw_mbs_arrange(d, d->o.from, q);
    if (s == LW_OK)
        s = lw_mbs_project_q(d, d->o.from, q, 1);
    if (s < 0)
        return s;
    if (s == LW_OPEN)
        return lw_error_set(e, LW_OPEN, "the posture of the file does not close, and no closed one is near");
    for (int i = 0; i < d->n_q; i++)
        d->moved = fmax(d->moved, fabs(q[i] - d->a[i]));
    memcpy(d->drawn_q, q, (size_t)d->n_q*sizeof *q);
    int rank = d->rank_alone = d->rank;
    d->n_driven = driven;
    s = lw_mbs_arrange(d, d->o.from, q);
    if (s == LW_OK && d->rank < rank + driven)
        return refuse_inputs(d, q, d->rank - rank, e);
    if (s == LW_OK && driven && d->freedom == 0)
        return start_on_motion(d, q, e);
    if (s == LW_OK && driven)
        s = move_to_start(d, q);
    if (s == LW_OPEN)
        return lw_error_set(e, LW_OPEN, "the linkage cannot get from the posture of the file to where its motions "
                            "begin");
    return s == LW_OK ? lw_mbs_arrange(d, d->o.from, q) : s;
}

/* Difference between the rate of input i at the start and the speed given. */
static double speed_off(const lw_dynamics *d, int i)
{
    lw_measure m;
    int j = d->s.input_joint[i];
    if (!d->model->has_speed[i])
        return 0;
    lw_measure_joint(&d->s, j, d->start_q, d->start_v, false, &m);
    return fabs(m.rate - d->model->speed[i])/lw_system_joint_unit(&d->s, j);
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

/* Add the velocities that the model gives its links to the rows. */
static void add_velocities(lw_dynamics *d, int *n)
{
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_body *from = &d->model->body[d->s.link[b]];
        double rate[3] = { from->velocity.x/d->s.unit, from->velocity.y/d->s.unit, from->omega };
        for (int i = 0; from->has_velocity && i < 3; i++, ++*n) {
            double *row = d->speed_rows + (size_t)*n*(size_t)d->n_q;
            memset(row, 0, (size_t)d->n_q*sizeof *row);
            row[3*b + i] = 1;
            d->rhs[*n] = rate[i];
        }
    }
}

lw_status lw_mbs_check_speeds(lw_error *e, const char *place, double off, double top, const char *note)
{
    if (off <= 1e-9*top + 1e-12)
        return LW_OK;
    return lw_error_set(e, LW_E_ARG, "the speeds and velocities given contradict each other or the posture%s%s%s: they are off by %.3g "
                        "(of %.3g), lengths over the size of the model%s", place ? " at \"" : "", place ? place : "", place ? "\"" : "",
                        off, top, note);
}

/* LW_E_ARG: the velocities of the start are not those given to inputs and links, which a run in time begins with. */
static lw_status check_speeds(const lw_dynamics *d, lw_error *e)
{
    double off = 0, top = 0;
    const char *place = NULL;
    for (int i = 0; i < d->s.n_input; i++) {
        int j = d->s.input_joint[i];
        double wrong = speed_off(d, i);
        if (d->model->has_speed[i])
            top = fmax(top, fabs(d->model->speed[i])/lw_system_joint_unit(&d->s, j));
        if (wrong > off)
            off = wrong, place = d->model->linkage.joint[j].name;
    }
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_body *from = &d->model->body[d->s.link[b]];
        const double *v = d->start_v + 3*b;
        double x = from->velocity.x/d->s.unit, y = from->velocity.y/d->s.unit;
        double wrong = from->has_velocity ? fmax(fabs(v[2] - from->omega), hypot(v[0] - x, v[1] - y)) : 0;
        if (from->has_velocity)
            top = fmax(top, fmax(fabs(from->omega), hypot(x, y)));
        if (wrong > off)
            off = wrong, place = d->model->linkage.link_name[d->s.link[b]];
    }
    bool in_time = d->o.analysis != LW_ANALYSIS_STATIC && d->o.analysis != LW_ANALYSIS_QUASISTATIC;
    return in_time ? lw_mbs_check_speeds(e, place, off, top, "") : LW_OK;
}

/* Velocities that links are given into start_v; by_mass is 0 there: they are kept. */
static void take_velocities(lw_dynamics *d)
{
    for (int b = 0; b < d->s.n_body; b++) {
        const lw_body *from = &d->model->body[d->s.link[b]];
        double rate[3] = { from->velocity.x/d->s.unit, from->velocity.y/d->s.unit, from->omega };
        for (int i = 0; from->has_velocity && i < 3; i++) {
            d->start_v[3*b + i] = rate[i];
            d->by_mass[3*b + i] = 0;
        }
    }
}

/* The same for a large model, with least kinetic energy beside the velocities that are given. */
static lw_status find_velocities_large(lw_dynamics *d, lw_error *e)
{
    int driven = d->n_driven;
    double *by_mass = malloc(((size_t)d->n_v + 1)*sizeof *by_mass);
    if (!by_mass)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    memcpy(by_mass, d->by_mass, (size_t)d->n_v*sizeof *by_mass);
    take_velocities(d);
    lw_status s = d->n_velocity ? lw_mbs_arrange(d, d->o.from, d->start_q) : lw_mbs_rows(d, d->o.from, d->start_q);
    for (int given = 1; given >= 0; given--)
        for (int i = 0; s == LW_OK && i < d->s.n_input; i++)
            if (d->model->has_speed[i] == (bool)given && !d->model->motion[i] && !d->o.hold_inputs) {
                int n = d->n_driven;
                s = hold_input(d, i, d->start_q);
                d->at_rest[i] = !given && d->n_driven > n;
            }
    if (s == LW_OK)
        s = lw_mbs_rows(d, d->o.from, d->start_q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    for (int i = 0, held = d->n_driven; s == LW_OK && i < 1; i++) {
        d->n_driven = driven;                            /* the motions that exist, then the speeds */
        s = lw_mbs_rate_wanted(d, d->o.from);
        d->n_driven = held;
        for (int k = driven; k < held; k++) {
            int j = d->s.input_joint[d->driven[k]];
            d->rhs[d->n_row + k] = d->model->has_speed[d->driven[k]]
                                 ? d->model->speed[d->driven[k]]/lw_system_joint_unit(&d->s, j) : 0;
        }
        lw_mbs_times(d, d->start_v, d->l_each);
        for (int r = 0; r < d->n_c; r++)
            d->rhs[r] -= d->l_each[r];
        if (s == LW_OK)
            s = lw_mbs_linear(d, NULL, d->rhs, d->hold, d->l_each);
        for (int k = 0; k < d->n_v; k++)
            d->start_v[k] += d->hold[k];
    }
    d->n_driven = driven;
    memcpy(d->by_mass, by_mass, (size_t)d->n_v*sizeof *by_mass);
    free(by_mass);
    if (s == LW_OK)
        s = lw_mbs_arrange(d, d->o.from, d->start_q);
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    if (s == LW_OK)
        s = lw_mbs_project_v(d, d->o.from, d->start_v);
    return s == LW_OPEN ? lw_error_set(e, LW_E_NUMERIC, "the posture at the start is singular; start it from a posture "
                                       "nearby") : s;
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
    for (int row = 0; row < d->n_c; row++)
        lw_mbs_row(d, row, d->speed_rows + row*d->n_q);
    add_velocities(d, &n);
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
        if (m->motion[i] || d->o.hold_inputs) {
            d->driven_measure[d->n_driven] = d->s.input_joint[i];
            d->driven[d->n_driven++] = i;
        }
    for (int b = 0; b < d->s.n_body; b++)
        d->n_velocity += m->body[d->s.link[b]].has_velocity;
    for (int i = 0; i < d->n_q; i++)
        d->has_zero_mass = d->has_zero_mass || !(d->f.mass[i] > 0);
}

/* Large models with a freedom need all their masses. */
static lw_status check_masses(const lw_dynamics *d, lw_error *e)
{
    for (int b = 0; b < d->s.n_body && d->weighed && (d->freedom > 0 || d->elastic); b++)
        if (!(d->f.mass[3*b] > 0 && d->f.mass[3*b + 2] > 0))
            return lw_error_set(e, LW_E_ARG, "link \"%s\" needs a \"mass\" and an \"inertia\": in a model with elastic links, or with "
                                "more than %d links and a freedom that no \"motion\" drives (this one has %d), every link has them",
                                d->model->linkage.link_name[d->s.link[b]], LW_LINK_MAX, d->freedom);
    return LW_OK;
}

/* LW_E_KIND: a contact or a rope of an elastic link, whose outline would bend. */
static lw_status check_touching(const lw_model *m, lw_error *e)
{
    for (int i = 0; i < m->n_contact + m->n_rope; i++)
        for (int end = 0; end < 2; end++) {
            bool rope = i >= m->n_contact;
            int link = rope ? m->rope[i - m->n_contact].link[end] : m->contact[i].link[end];
            if (m->elastic[link].given)
                return lw_error_set(e, LW_E_KIND, "%s \"%s\" is at the elastic link \"%s\"; weld a rigid link to it (joint of kind \"f\") that %s",
                                    rope ? "rope" : "contact", rope ? m->rope[i - m->n_contact].name : m->contact[i].name, m->linkage.link_name[link],
                                    rope ? "holds the rope" : "has the shapes");
        }
    return LW_OK;
}

/* Start elastic links undeformed, with the posture and the velocities of the same model with rigid links.  LW_NOTHING: it
 * has none. */
static lw_status start_as_rigid(lw_dynamics *d, const lw_model *given)
{
    lw_dynamics *r = calloc(1, sizeof *r);
    lw_error ignored = { 0 };
    if (!r)
        return lw_error_set(d->e, LW_E_MEMORY, "out of memory");
    r->model = given;
    r->o = d->o;
    r->o.rigid = true;
    lw_status s = lw_dynamics_prepare(r, &ignored) == LW_OK ? LW_OK : LW_NOTHING;
    for (int b = 0; s == LW_OK && b < d->s.n_body; b++) {
        int link = d->s.link[b], body;
        for (int k = 0; k < d->expansion.n_chain; k++)
            for (int i = 1; i < d->expansion.chain[k].n_node; i++)
                link = d->expansion.chain[k].node[i] == d->s.link[b] ? d->expansion.chain[k].link : link;
        body = r->s.body[link];
        lw_vec2 at = lw_v2_scale(lw_v2_sub(d->s.reference[b], lw_v2(0, 0)), d->s.unit);      /* the posture; origin (0, 0) */
        lw_vec2 arm = lw_system_arm(&r->s, body, at), now = lw_system_point(&r->s, body, arm, r->start_q);
        const double *q = r->start_q + 3*body, *v = r->start_v + 3*body;
        lw_vec2 turned = lw_v2_scale(lw_v2_turn(arm, lw_v2_polar(1, q[2])), r->s.unit);
        lw_vec2 rate = lw_v2_add(lw_v2_scale(lw_v2(v[0], v[1]), r->s.unit), lw_v2_scale(lw_v2_perp(turned), v[2]));
        double *to = d->start_q + 3*b, *to_v = d->start_v + 3*b;
        to[0] = now.x/d->s.unit, to[1] = now.y/d->s.unit, to[2] = q[2];
        to_v[0] = rate.x/d->s.unit, to_v[1] = rate.y/d->s.unit, to_v[2] = v[2];
    }
    for (int i = 0; s == LW_OK && i < d->s.n_input; i++)
        d->at_rest[i] = r->at_rest[i];
    d->moved = r->moved;
    lw_dynamics_free(r);
    if (s == LW_OK)
        s = lw_mbs_arrange(d, d->o.from, d->start_q);
    if (s == LW_OK)
        s = lw_mbs_project_q(d, d->o.from, d->start_q, 0.01);
    if (s == LW_OK)
        s = lw_mbs_project_v(d, d->o.from, d->start_v);
    if (s == LW_OK && d->n_kept != d->n_c)
        s = rank_nearby_large(d, d->o.from, d->start_q, d->start_v);
    return s == LW_OK ? lw_mbs_arrange(d, d->o.from, d->start_q) : s == LW_OPEN ? LW_NOTHING : s;
}

lw_status lw_dynamics_prepare(lw_dynamics *d, lw_error *e)
{
    const lw_model *m = d->model, *given = m;
    for (int j = 0; j < m->linkage.n_joint; j++)
        if (m->clearance[j].model > LW_CLEARANCE_ZERO)
            return lw_error_set(e, LW_E_KIND, "joint \"%s\" has a clearance; \"linkwright clearance\" runs such models",
                                m->linkage.joint[j].name);
    lw_status s = LW_OK;
    if (m->n_elastic) {
        d->elastic = !d->o.rigid;
        if (d->elastic && (s = check_touching(m, e)) != LW_OK)
            return s;
        d->model = d->elastic ? &d->expansion.model : &d->rigid;
        s = d->elastic ? lw_elastic_expand(m, lw_dynamics_in_time(d), &d->expansion, e) : lw_elastic_rigid(m, &d->rigid, e);
        if (s != LW_OK)
            return s;
        m = d->model;
    }
    const lw_linkage *small;
    d->large = d->rows_only || d->elastic || lw_model_small(m, &small, NULL) != LW_OK || !small;   /* no copy of it in fixed arrays: as a large model */
    s = lw_forces_system(m, true, &d->s, e);
    if (s == LW_OK)
        s = lw_forces_make(m, &d->s, &d->o.force, &d->f, e);
    if (s == LW_OK)
        s = lw_mbs_reserve_lists(d, (size_t)d->s.n_joint, 2*(size_t)d->s.n_joint, (size_t)(d->s.n_input + d->s.n_tie), e);
    if (s != LW_OK)
        return s;
    d->frames = calloc((size_t)d->s.n_body + 1, sizeof *d->frames);
    if (!d->frames)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    d->planar = (lw_planar){ .s = &d->s, .f = &d->f, .frames = d->frames, .hold_inputs = d->o.hold_inputs };
    lw_mbs_take_equations(d, lw_planar_equations(&d->planar));
    d->n_input = d->s.n_input;
    find_special_joints(d);
    if (!d->rows_only && (s = lw_mbs_touch_make(d, e)) != LW_OK)
        return s;
    if (d->elastic && d->n_velocity > 0)
        return lw_error_set(e, LW_E_KIND, "links have no \"velocity\" in models with elastic links; give inputs a \"speed\"");
    if ((s = lw_mbs_reserve(d, e)) != LW_OK)
        return s;
    d->e = e;
    if (d->rows_only)
        return LW_OK;
    if (d->elastic && (s = check_masses(d, e)) != LW_OK)
        return s;
    if (d->elastic && (s = start_as_rigid(d, given)) != LW_NOTHING)
        return s == LW_OK ? lw_mbs_start_states(d, e) : s;
    if ((s = find_posture(d, e)) == LW_OK)
        s = check_masses(d, e);
    if (s == LW_OK)
        s = d->large ? find_velocities_large(d, e) : find_velocities(d, e);
    if (s == LW_OK)
        s = check_speeds(d, e);
    if (s == LW_OK)
        s = d->large ? rank_nearby_large(d, d->o.from, d->start_q, d->start_v)
                     : rank_nearby(d, d->o.from, d->start_q, d->start_v);
    if (s == LW_OK)
        s = lw_mbs_start_states(d, e);
    return s == LW_OK ? lw_mbs_arrange(d, d->o.from, d->start_q) : s;
}

lw_status lw_mbs_start_states(lw_dynamics *d, lw_error *e)
{
    d->eq.state_start(d->eq.context, d->o.from, d->start_q, d->start_v, d->start_z);
    for (int i = 0; i < d->eq.n_z; i++)
        if (!isfinite(d->start_z[i]))
            return lw_error_set(e, LW_E_NUMERIC, "the start of state \"%s\" is not a number",
                                d->eq.name(d->eq.context, LW_NAMED_STATE, i));
    return LW_OK;
}

void lw_mbs_system_rows(const lw_dynamics *c, const double *q)
{
    lw_dynamics *d = (lw_dynamics *)(uintptr_t)c;
    d->eq.place(d->eq.context, q);
    memset(d->jac, 0, (size_t)d->n_row*(size_t)d->row_size*sizeof *d->jac);
    d->eq.rows(d->eq.context, d->phi, d->jac, d->row_block);
}

/* Add the joint of a row to a list of names, once; "..." where there is no room for more. */
static void add_name(const lw_dynamics *d, int row, const char **last, char *text, size_t size)
{
    const char *name = d->eq.name(d->eq.context, LW_NAMED_ROW, row);
    size_t used = strlen(text);
    if ((!*last || strcmp(name, *last) != 0) && (used < 4 || strcmp(text + used - 4, " ...") != 0))
        snprintf(text + used, size - used, " %s", used + strlen(name) + 6 < size ? name : "...");
    *last = name;
}

/* Does friction act in the joint of a row? */
static bool rubs_in(const lw_dynamics *d, int row)
{
    const char *name = d->eq.name(d->eq.context, LW_NAMED_ROW, row);
    bool yes = false;
    for (int k = 0; k < d->n_friction + (d->space ? d->space->n_rub : 0); k++) {
        int j = d->friction[k].joint;
        yes = yes || strcmp(name, d->space ? d->space->model->joint[j].name : d->model->linkage.joint[j].name) == 0;
    }
    return yes;
}

/* The reactions of a joint are unique where the null space of J^T has no part in its rows. */
bool lw_dynamics_redundant(const lw_dynamics *c, char *text, size_t size)
{
    lw_dynamics *d = (lw_dynamics *)(uintptr_t)c;
    const char *last = NULL;
    bool rubs = false;
    double *x = d->l_each + (d->large ? d->n_c : 0);
    *text = '\0';
    bool none = d->rank == d->n_c || lw_mbs_rows(d, d->o.from, d->start_q) != LW_OK || lw_mbs_factor(d, !d->large) != LW_OK;
    for (int r = 0; r < d->n_c; r++)                     /* large models: some vector of the null space, which touches all its rows */
        x[r] = 1 + sin(r);
    if (d->large && !none)
        lw_mbs_dependence(d, x);
    for (int r = 0; r < d->n_row && !none; r++) {
        double left = fabs(x[r]);
        if (!d->large) {
            memset(x, 0, (size_t)d->n_c*sizeof *x);
            x[r] = 1;
            lw_rank_null_part(&d->rank_of, x);
            left = 0;
            for (int i = 0; i < d->n_c; i++)
                left = fmax(left, fabs(x[i]));
        }
        if (left > LW_RANK_TOLERANCE) {
            add_name(d, r, &last, text, size);
            rubs = rubs || rubs_in(d, r);
        }
    }
    return rubs;
}
