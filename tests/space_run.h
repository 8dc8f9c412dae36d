/* tests/space_run.h - models in space, run to their end, and the same models in the plane. */
#ifndef LW_TESTS_SPACE_RUN_H
#define LW_TESTS_SPACE_RUN_H

#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"
#include "tests/planar_models.h"
#include "tests/spatial_models.h"

/* One row; total: kinetic and potential energy; energy: without the work that was done.  distance, force: of the first clearance. */
typedef struct srow { double t, input, input_rate, drive[8], total, energy, work, q[64], v[64], a[64], coupling[4], distance, force;
                      lw_vec3 tracer[2], linear, angular, omega; lw_spatial_reaction joint[16]; } srow;

typedef struct srun {
    lw_dynamics        *d;
    const lw_space     *s;
    int                 n, idle;
    bool                many_drives;
    lw_rest             rest;
    double              off, off_rate, strain;        /* strain: energy of the last row */
    lw_dynamics_report  r;
    int                 n_inner;                      /* nodes of the first elastic link */
    lw_space_inner      inner[64];
    lw_space_contact    contact[12];
    srow                at[1002];
} srun;

static inline lw_status srun_keep(void *context, const lw_moment *moment)
{
    srun *k = context;
    lw_space_moment o;
    lw_status st = lw_dynamics_space_moment(k->d, moment, &o, &check_error);
    if (st != LW_OK)
        return st;
    srow *s = &k->at[k->n++];
    const lw_spatial *m = k->s->model;
    *s = (srow){ .t = o.t, .input = m->n_input ? o.input[0] : 0, .input_rate = m->n_input ? o.input_rate[0] : 0,
                 .total = o.kinetic + o.potential, .energy = o.kinetic + o.potential - o.work, .work = o.work };
    for (int i = 0; i < 8 && i < (m->n_drive ? m->n_drive : m->n_input); i++)
        s->drive[i] = o.drive[i];
    for (int i = 0; i < 2 && i < m->n_tracer; i++)
        s->tracer[i] = lw_space_point_at(o.frame, k->s->tracer[i]);
    for (int i = 0; i < k->s->n_v && i < 64; i++)
        s->v[i] = o.v[i], s->a[i] = o.a[i];
    for (int i = 0; i < k->s->n_q && i < 64; i++)
        s->q[i] = o.q[i];
    for (int i = 0; i < m->n_joint && i < 16; i++)
        s->joint[i] = o.joint[i];
    for (int i = 0; i < m->n_coupling && i < 4; i++)
        s->coupling[i] = o.coupling[i];
    if (m->n_contact) {
        lw_space_touch touch = lw_dynamics_space_touch(k->d, 0, &o);
        s->distance = touch.distance, s->force = touch.force;
    }
    s->omega = lw_space_omega(o.frame, 0, o.v);
    lw_dynamics_space_momentum(k->d, &o, &s->linear, &s->angular);
    k->off = fmax(k->off, o.off);
    k->off_rate = fmax(k->off_rate, o.off_rate);
    const lw_spatial_expansion *elastic = lw_dynamics_spatial_elastic(k->d);
    if (elastic) {
        k->strain = lw_dynamics_space_strain(k->d, &o);
        lw_dynamics_space_inner(k->d, &o, 0, k->inner);
        k->n_inner = elastic->chain[0].n_bound;
    }
    return LW_OK;
}

/* Run m; k->s is valid while it runs. */
static inline void srun_go(const lw_spatial *m, const lw_dynamics_options *o, srun *k)
{
    k->n = 0;
    k->off = k->off_rate = 0;
    k->r = (lw_dynamics_report){ 0 };
    lw_status st = lw_dynamics_make_spatial(m, o, &k->d, &check_error);
    CHECK_OK(st);
    if (st != LW_OK)
        return;
    k->s = lw_dynamics_space(k->d);
    k->idle = lw_dynamics_idle(k->d);
    k->many_drives = lw_dynamics_many_drives(k->d);
    CHECK_OK(lw_dynamics_analyse(k->d, srun_keep, k, &k->r, &k->rest, &check_error));
    for (int i = 0; i < k->s->model->n_contact && i < 12; i++)
        k->contact[i] = *lw_dynamics_space_contact(k->d, i);
    lw_dynamics_free(k->d);
}

/* Run m by this formulation.  Returns the report. */
static inline lw_dynamics_report srun_by(const lw_spatial *m, lw_formulation f, lw_analysis a, double to, int intervals, double tolerance, srun *k)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.analysis = a, o.formulation = f, o.to = to, o.intervals = intervals, o.relative = o.absolute = tolerance;
    srun_go(m, &o, k);
    return k->r;
}

/* The same in the plane: the turn of the first moving link and the first tracer of each row. */
typedef struct flat_run { lw_dynamics *d; int n; double turn[1002]; lw_vec2 tracer[1002]; lw_dynamics_report r; } flat_run;

static inline lw_status flat_keep(void *context, const lw_moment *m)
{
    flat_run *p = context;
    const lw_system *s = lw_dynamics_system(p->d);
    p->turn[p->n] = m->q[2];
    if (s->n_tracer)
        p->tracer[p->n] = lw_system_point(s, s->tracer_body[0], s->tracer_arm[0], m->q);
    p->n++;
    return LW_OK;
}

/* Run m, which is freed. */
static inline void flat_go(lw_model *m, double to, int intervals, double tolerance, flat_run *p)
{
    lw_dynamics_options o = lw_dynamics_options_default();
    o.to = to, o.intervals = intervals, o.relative = o.absolute = tolerance;
    p->n = 0;
    lw_status st = lw_dynamics_make(m, &o, &p->d, &check_error);
    CHECK_OK(st == LW_OK ? lw_dynamics_run(p->d, flat_keep, p, &p->r, &check_error) : st);
    lw_dynamics_free(p->d);
    lw_model_free(m);
}

#endif
