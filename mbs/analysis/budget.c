/* mbs/analysis/budget.c - error budget of a robot's tool, by source. */
#include "mbs/analysis/budget.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "mbs/run/run_internal.h"
#include "mbs/dynamics/tangent_internal.h"
#include "mbs/formulations/formulations.h"

/* ---- elastic links, one at a time ---------------------------------------------------------------------------- */

/* The model with one of its links elastic, drives held. */
struct lw_budget_part {
    lw_spatial        model, rigid;
    lw_spatial_input *input;
    lw_elastic       *elastic;
    lw_dynamics      *d;
    lw_tangent        tangent;
    double           *q, *still, *a, *l, *b;
};

static lw_status make_part(const lw_spatial *m, const lw_budget_options *o, int link, struct lw_budget_part *p, lw_error *e)
{
    lw_dynamics_options run = lw_dynamics_options_default();
    int n = m->n_drive ? m->n_drive : m->n_input;
    lw_status s = lw_spatial_rigid(m, &p->rigid, e);
    if (s != LW_OK)
        return s;
    p->model = *m;
    p->model.body = p->rigid.body;
    p->input = calloc((size_t)n + 1, sizeof *p->input);
    p->elastic = calloc((size_t)m->n_link, sizeof *p->elastic);
    if (!p->input || !p->elastic)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; i < n; i++)
        p->input[i].measure = m->n_drive ? m->drive[i] : m->input[i].measure;
    p->elastic[link] = m->elastic[link];
    p->model.elastic = p->elastic, p->model.n_elastic = 1;
    p->model.input = p->input, p->model.n_input = n;
    p->model.n_drive = p->model.n_force = p->model.n_motor = p->model.n_spring = p->model.n_joint_spring = 0;
    p->model.gravity = o->weight ? m->gravity : lw_v3(0, 0, 0);
    p->model.states = (lw_states){ 0 };
    run.analysis = LW_ANALYSIS_STATIC;
    run.hold_inputs = true;
    if ((s = lw_dynamics_make_spatial(&p->model, &run, &p->d, e)) != LW_OK)
        return s;
    size_t q = (size_t)p->d->n_q, v = (size_t)p->d->n_v, c = (size_t)p->d->n_kept;
    p->q = calloc(q + 3*v + 2*c + 1, sizeof *p->q);
    if (!p->q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    p->still = p->q + q, p->a = p->still + v, p->l = p->a + v, p->b = p->l + c;
    return LW_OK;
}

lw_status lw_budget_stiffness_make(const lw_spatial *m, const lw_budget_options *o, lw_budget_stiffness *s, lw_error *e)
{
    *s = (lw_budget_stiffness){ .n = 0 };
    s->link = calloc((size_t)m->n_elastic + 1, sizeof *s->link);
    s->part = calloc((size_t)m->n_elastic + 1, sizeof *s->part);
    lw_status st = s->link && s->part ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; st == LW_OK && i < m->n_link; i++)
        if (m->elastic[i].given) {
            s->link[s->n] = i;
            st = make_part(m, o, i, &s->part[s->n++], e);
        }
    return st;
}

void lw_budget_stiffness_free(lw_budget_stiffness *s)
{
    for (int i = 0; s->part && i < s->n; i++) {
        struct lw_budget_part *p = &s->part[i];
        lw_tangent_free(&p->tangent);
        lw_dynamics_free(p->d);
        if (p->rigid.body)
            lw_spatial_rigid_free(&p->rigid);
        free(p->input), free(p->elastic), free(p->q);
    }
    free(s->link), free(s->part);
    *s = (lw_budget_stiffness){ 0 };
}

/* Displacement of the tool by one elastic link: K x + J^T l = F, J x = 0. */
static lw_status bend(struct lw_budget_part *p, const lw_robot *r, lw_vec3 load, lw_vec3 *out, lw_error *e)
{
    lw_dynamics *d = p->d;
    const double none[2] = { 0, 0 };
    lw_status s = lw_dynamics_place_on_rigid(d, &r->space, r->follow.q, p->q, e);
    if (s == LW_OK && !p->tangent.lu && lw_tangent_make(d, false, false, &p->tangent) != LW_OK)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s != LW_OK)
        return s;
    if ((s = lw_tangent_at_rest(d, d->o.from, p->q, p->still, p->a, p->l)) == LW_OK)
        s = lw_tangent_factor(&p->tangent, d->o.from, p->q, p->still, p->l, none, none);
    if (s != LW_OK)
        return lw_error_set(e, s, s == LW_E_MEMORY ? "out of memory" : "the equations of elastic links at rest are singular in this posture");
    const lw_space *space = &d->space->s;
    lw_space_point tool = space->tracer[r->tool];
    lw_space_place(space, p->q, d->space->frame);
    double *b = p->b;
    memset(b, 0, (size_t)(d->n_v + d->n_kept)*sizeof *b);
    for (int i = 0; i < d->n_v; i++)
        b[i] = d->eq.weight[i];
    if (tool.body >= 0) {
        lw_vec3 twist = lw_v3_cross(tool.arm, lw_m3_unapply(&d->space->frame[tool.body + 1].turn, load));
        double *to = b + 6*tool.body;
        to[0] += space->unit*load.x, to[1] += space->unit*load.y, to[2] += space->unit*load.z;
        to[3] += twist.x, to[4] += twist.y, to[5] += twist.z;
    }
    lw_tangent_solve(&p->tangent, b);
    *out = lw_space_point_velocity(space, d->space->frame, tool, b);
    return LW_OK;
}

/* ---- rows ---------------------------------------------------------------------------------------------------- */

static lw_vec3 moved(lw_robot *r, const double *x)
{
    return lw_space_point_velocity(&r->space, r->follow.z.frame, r->space.tracer[r->tool], x);
}

/* Displacement of the tool when rows are off by `off` (n_row, which is zeroed again); rounding counts as none.  *fits: cleared
 * where a row that depends on others is off: their joints cannot all be closed then. */
static lw_vec3 by_rows(lw_robot *r, double *off, double *x, double *l, bool *fits)
{
    double most = 0, left = 0;
    for (int i = 0; i < r->follow.z.n_row; i++) {
        most = fmax(most, fabs(off[i]));
        left = fmax(left, r->follow.z.place[i] < 0 ? fabs(off[i]) : 0);
    }
    *fits = *fits && left <= 1e-9*most;
    lw_space_rows_solve(&r->follow.z, NULL, off, true, x, l);
    memset(off, 0, (size_t)r->follow.z.n_row*sizeof *off);
    lw_vec3 d = moved(r, x);
    double rounding = 1e-13*most*r->space.unit;
    return lw_v3(fabs(d.x) > rounding ? d.x : 0, fabs(d.y) > rounding ? d.y : 0, fabs(d.z) > rounding ? d.z : 0);
}

/* The greatest |A d| over |d| = 1 and the sum of squares of A. */
static double greatest(const lw_mat3 *a, double *squares)
{
    double gram[6], value[3];
    lw_mat3 axes;
    lw_vec3 c[3];
    for (int i = 0; i < 3; i++)
        c[i] = lw_m3_column(a, i);
    for (int i = 0; i < 3; i++)
        gram[i] = lw_v3_dot(c[i], c[i]);
    gram[3] = lw_v3_dot(c[0], c[1]), gram[4] = lw_v3_dot(c[0], c[2]), gram[5] = lw_v3_dot(c[1], c[2]);
    lw_m3_principal(gram, value, &axes);
    *squares = gram[0] + gram[1] + gram[2];
    return sqrt(fmax(value[0], fmax(value[1], value[2])));
}

static void add_clearance(lw_robot *r, lw_budget *b, int joint, double gap, double *off, double *x, double *l, bool *fits)
{
    const lw_space_joint *j = &r->space.joint[joint];
    bool pin = j->kind == LW_SPATIAL_REVOLUTE;
    lw_vec3 axis[3] = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } }, column[3] = { { 0, 0, 0 } };
    if (pin) {
        lw_vec3 z = lw_m3_apply(&r->follow.z.frame[j->body[0] + 1].turn, j->z[0]);
        axis[0] = lw_v3_across(z), axis[1] = lw_v3_cross(z, axis[0]);
    }
    for (int i = 0; i < (pin ? 2 : 3); i++) {
        lw_vec3 d = lw_v3_scale(axis[i], gap/r->space.unit);
        off[j->row] = d.x, off[j->row + 1] = d.y, off[j->row + 2] = d.z;
        column[i] = by_rows(r, off, x, l, fits);
    }
    lw_budget_source *s = &b->source[b->n++];
    double squares;
    *s = (lw_budget_source){ .kind = LW_BUDGET_CLEARANCE, .index = joint, .by = lw_m3_columns(column[0], column[1], column[2]) };
    snprintf(s->name, sizeof s->name, "%s", r->model->joint[joint].name);
    s->worst = greatest(&s->by, &squares);
    s->rms = sqrt(squares/(pin ? 2 : 3));
}

static void add_vector(lw_budget *b, lw_budget_kind kind, int index, const char *name, lw_vec3 d, double share)
{
    lw_budget_source *s = &b->source[b->n++];
    *s = (lw_budget_source){ .kind = kind, .index = index, .worst = lw_v3_norm(d), .by = lw_m3_columns(d, lw_v3(0, 0, 0), lw_v3(0, 0, 0)) };
    s->rms = share*s->worst;
    snprintf(s->name, sizeof s->name, "%s", name);
}

/* ---- all together -------------------------------------------------------------------------------------------- */

/* The furthest displacement of all sources along u, and where it ends. */
static double furthest(const lw_budget *b, lw_vec3 u, lw_vec3 *end)
{
    *end = b->bent;
    for (int i = 0; i < b->n; i++) {
        const lw_budget_source *s = &b->source[i];
        if (s->kind == LW_BUDGET_ELASTIC)
            continue;
        lw_vec3 d = lw_m3_unapply(&s->by, u);        /* by^T u: displacement along u by unit errors */
        double size = lw_v3_norm(d);
        if (size > 0)
            *end = lw_v3_add(*end, lw_m3_apply(&s->by, lw_v3_scale(d, 1/size)));
    }
    return lw_v3_dot(u, *end);
}

/* The greatest |end| over all directions: go from many towards where they end, which never shortens it. */
static void find_worst(lw_budget *b)
{
    enum { starts = 64, passes = 60 };
    for (int k = 0; k < starts; k++) {
        double z = 1 - (2*k + 1.0)/starts, turn = 2.399963229728653*k, flat = sqrt(1 - z*z);
        lw_vec3 u = lw_v3(flat*cos(turn), flat*sin(turn), z), end = u;
        for (int pass = 0; pass < passes; pass++) {
            furthest(b, u, &end);
            double size = lw_v3_norm(end);
            if (!(size > 0))                         /* nothing moves the tool that way */
                break;
            u = lw_v3_scale(end, 1/size);
        }
        double size = lw_v3_norm(end);
        if (size > b->worst)
            b->worst = size, b->direction = u;
    }
}

static int compare(const void *a, const void *b)
{
    const lw_budget_source *x = a, *y = b;
    return x->rms < y->rms ? 1 : x->rms > y->rms ? -1 : 0;
}

void lw_budget_free(lw_budget *b)
{
    free(b->source);
    *b = (lw_budget){ 0 };
}

lw_status lw_budget_make(lw_robot *r, lw_budget_stiffness *stiffness, const lw_budget_options *o, lw_budget *b, lw_error *e)
{
    const lw_spatial *m = r->model;
    lw_space_rows_set *z = &r->follow.z;
    size_t rows = (size_t)z->n_row, v = (size_t)r->space.n_v;
    *b = (lw_budget){ .source = calloc((size_t)m->n_joint + (size_t)r->n_drive + (size_t)m->n_elastic + 1, sizeof *b->source) };
    double *off = calloc(2*rows + v + 1, sizeof *off), *l = off + rows, *x = l + rows, squares = 0;
    bool fits = true;
    lw_status s = b->source && off ? LW_OK : lw_error_set(e, LW_E_MEMORY, "out of memory");
    if (s == LW_OK) {
        lw_space_rows_fill(z, r->follow.q, NULL);
        if (!lw_space_rows_factor(z) || z->n_kept < r->space.n_v)
            s = lw_error_set(e, LW_OPEN, "the drives do not hold the tool in this posture");
    }
    for (int j = 0; s == LW_OK && j < m->n_joint; j++) {
        lw_spatial_kind k = m->joint[j].kind;
        double gap = m->joint[j].clearance.model > LW_CLEARANCE_NONE ? m->joint[j].clearance.gap : o->clearance;
        if (gap > 0 && (k == LW_SPATIAL_SPHERICAL || k == LW_SPATIAL_REVOLUTE))
            add_clearance(r, b, j, gap, off, x, l, &fits);
        if (!fits)
            s = lw_error_set(e, LW_E_KIND, "the clearance of joint \"%s\" is not all free: the model is overconstrained, and the gap of one "
                             "joint is taken up by others", m->joint[j].name);
    }
    for (int i = 0; s == LW_OK && i < r->n_drive; i++) {
        lw_spatial_measure of = m->n_drive ? m->drive[i] : m->input[i].measure;
        double play = o->play[of.of != LW_OF_TURN];
        char name[LW_NAME_SIZE + 16];
        if (!(play > 0))
            continue;
        off[r->space.n_row + r->follow.n_idle + i] = play/lw_space_scale(&r->space, of);
        lw_spatial_measure_name(m, of, name, sizeof name);
        add_vector(b, LW_BUDGET_PLAY, i, name, by_rows(r, off, x, l, &fits), 1/sqrt(3));
    }
    for (int i = 0; s == LW_OK && stiffness && i < stiffness->n; i++) {
        lw_vec3 d;
        if ((s = bend(&stiffness->part[i], r, o->load, &d, e)) != LW_OK)
            break;
        add_vector(b, LW_BUDGET_ELASTIC, stiffness->link[i], m->body[stiffness->link[i]].name, d, 1);
        b->bent = lw_v3_add(b->bent, d);
    }
    if (s == LW_OK) {
        for (int i = 0; i < b->n; i++)
            squares += b->source[i].kind == LW_BUDGET_ELASTIC ? 0 : b->source[i].rms*b->source[i].rms;
        b->rms = sqrt(squares + lw_v3_dot(b->bent, b->bent));
        find_worst(b);
        qsort(b->source, (size_t)b->n, sizeof *b->source, compare);
    }
    free(off);
    return s;
}
