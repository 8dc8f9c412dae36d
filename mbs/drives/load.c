#include "mbs/drives/load.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "base/real.h"
#include "mbs/analysis/reactions.h"
#include "mbs/dynamics/dynamics_equations_internal.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/equations/timed.h"
#include "mbs/formulations/formulations.h"

static lw_status make_room(int n, const lw_load_options *o, lw_loads *out, lw_error *e)
{
    size_t rows = (size_t)o->intervals + 1;
    if (n == 0)
        return lw_error_set(e, LW_E_ARG, "the model has no drive; name its \"input\"");
    if (o->intervals < 1 || !(o->from < o->to))
        return lw_error_set(e, LW_E_ARG, "a cycle needs a begin before its end, and an interval or more");
    out->load = calloc((size_t)n, sizeof *out->load);
    out->memory = calloc((3*(size_t)n + 1)*rows, sizeof(double));
    if (!out->load || !out->memory)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    out->n = n;
    for (int i = 0; i < n; i++) {
        double *at = (double *)out->memory + 3*(size_t)i*rows;
        out->load[i] = (lw_load){ .step = (o->to - o->from)/o->intervals, .speed = at, .torque = at + rows,
                                  .acceleration = at + 2*rows, .inertia = { NAN, NAN },
                                  .kink = (double *)out->memory + 3*(size_t)n*rows };
    }
    return LW_OK;
}

/* Arrays of load i, to be filled. */
static double *speed_of(const lw_loads *l, int i) { return (double *)l->memory + (l->load[i].speed - (double *)l->memory); }
static double *torque_of(const lw_loads *l, int i) { return speed_of(l, i) + (l->load[i].torque - l->load[i].speed); }
static double *acceleration_of(const lw_loads *l, int i)
{
    return speed_of(l, i) + (l->load[i].acceleration - l->load[i].speed);
}

/* Where functions of time have kinks.  Two in one interval count as none: it is shorter than what the samples show. */
static void find_kinks(const lw_dynamics *d, const lw_load_options *o, lw_loads *out)
{
    lw_timed w = { .expressions = d->eq.expressions, .context = d->eq.context, .from = o->from, .to = o->to };
    double *kink = (double *)out->memory + 3*(size_t)out->n*((size_t)o->intervals + 1), step = out->load[0].step, beside = 1e-9*step;
    bool any = false;
    for (double at = o->from; isfinite(at = lw_timed_next_kink(&w, at + beside, o->to + beside));) {
        double k = fmin(fmax(1, ceil((at - o->from - beside)/step)), o->intervals), end = o->from + k*step;
        bool second = at < end - beside && isfinite(lw_timed_next_kink(&w, at + beside, end - beside));
        if (!second && !(kink[(size_t)k] > 0))
            kink[(size_t)k] = fmin(1 + (at - end)/step, 1);
        any |= !second;
        at = second ? end : at;
    }
    for (int i = 0; i < out->n && !any; i++)
        out->load[i].kink = NULL;
}

void lw_loads_free(lw_loads *l)
{
    free(l->load);
    free(l->memory);
    *l = (lw_loads){ 0 };
}

/* Least and greatest; the first number replaces NaN. */
static void widen(double range[2], double x)
{
    range[0] = fmin(range[0], x);
    range[1] = fmax(range[1], x);
}

/* ---- planar ------------------------------------------------------------------------------------------------------ */

typedef struct planar_run { lw_dynamics *d; lw_loads *out; double *drive; } planar_run;

/* With fewer drives the reflected inertia is found at every sample, with n times as many at every nth. */
enum { DRIVES_EACH = 32 };

/* Twice the kinetic energy at unit rate of one drive, the others at rest: what its torque rises by, but for friction, when only its
 * acceleration rises by 1.  Inputs that are tied to others move with them. */
static lw_status reflect_planar(planar_run *r, const lw_moment *m)
{
    lw_dynamics *d = r->d;
    const lw_system *sys = lw_dynamics_system(d);
    const lw_assembly *k = &lw_dynamics_model(d)->linkage;
    double *rate = calloc((size_t)(d->n_v + 2*d->n_c) + 1, sizeof *rate), *wanted = rate + d->n_v, *l = wanted + d->n_c;
    lw_status s = rate ? lw_mbs_rows(d, m->t, m->q) : LW_E_MEMORY;
    if (s == LW_OK)
        s = lw_mbs_factor(d, false);
    for (int i = 0; s == LW_OK && i < d->n_driven; i++) {
        lw_measure count;
        wanted[d->n_row + i] = 1;
        s = lw_mbs_linear(d, NULL, wanted, rate, l);
        wanted[d->n_row + i] = 0;
        lw_measure_joint(sys, k->input[d->driven[i]].joint, m->q, rate, false, &count);
        if (s == LW_OK)
            widen(r->out->load[d->driven[i]].inertia, 2*d->eq.kinetic(d->eq.context, rate)/(count.rate*count.rate));
    }
    free(rate);
    return s == LW_OPEN ? LW_OK : s;         /* a singular posture: without limit */
}

static lw_status take_planar(void *context, const lw_moment *m)
{
    planar_run *r = context;
    const lw_system *sys = lw_dynamics_system(r->d);
    const lw_assembly *k = &lw_dynamics_model(r->d)->linkage;
    lw_reactions_driving(r->d, m, r->drive);
    for (int i = 0; i < k->n_input; i++) {
        lw_measure count;
        lw_load *l = &r->out->load[i];
        lw_measure_joint(sys, k->input[i].joint, m->q, m->v, false, &count);
        speed_of(r->out, i)[l->n] = count.rate;
        torque_of(r->out, i)[l->n++] = r->drive[i];
    }
    return (r->out->load[0].n - 1)%(1 + (size_t)r->d->n_driven/DRIVES_EACH) == 0 ? reflect_planar(r, m) : LW_OK;
}

static lw_status run_planar(const lw_model *m, const lw_load_options *o, lw_loads *out, double *drive, lw_error *e)
{
    lw_dynamics_options d = lw_dynamics_options_default();
    lw_dynamics_report report;
    planar_run r = { .out = out, .drive = drive };
    d.analysis = LW_ANALYSIS_KINEMATIC;
    d.from = o->from;
    d.to = o->to;
    d.intervals = o->intervals;
    d.stop = o->stop;
    lw_status s = lw_dynamics_make(m, &d, &r.d, e);
    if (s == LW_OK) {
        find_kinks(r.d, o, out);
        s = lw_dynamics_run(r.d, take_planar, &r, &report, e);
        lw_dynamics_free(r.d);
    }
    return s;
}

/* Second derivative of a motion at each sample; behind a kink, as the forces are. */
static void accelerate(const lw_expression *motion, double factor, double from, lw_load *l, double *out)
{
    for (size_t r = 0; r < l->n; r++) {
        double series[3] = { 0 }, v[3*LW_EXPRESSION_VARIABLE_MAX] = { from + (double)r*l->step, 1, 0 };
        lw_expression_series(motion, 2, v, series);
        out[r] = 2*factor*series[2];
    }
}

lw_status lw_loads_planar(const lw_model *m, const lw_load_options *o, lw_loads *out, lw_error *e)
{
    *out = (lw_loads){ 0 };
    int n = m->linkage.n_input;
    lw_status s = make_room(n, o, out, e);
    double *drive = s == LW_OK ? malloc((size_t)n*sizeof *drive) : NULL;
    if (s == LW_OK && !drive)
        s = lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < n; i++) {
        const lw_joint *j = &m->linkage.joint[m->linkage.input[i].joint];
        snprintf(out->load[i].name, sizeof out->load[i].name, "%s", j->name);
        out->load[i].slides = lw_joint_slides(j->kind);
    }
    if (s == LW_OK)
        s = run_planar(m, o, out, drive, e);
    for (int i = 0; s == LW_OK && i < n; i++) {
        if (m->motion[i])
            accelerate(m->motion[i], 1, o->from, &out->load[i], acceleration_of(out, i));
        else if (m->motion[0])                                         /* tied to the first */
            accelerate(m->motion[0], m->linkage.input[i].ratio, o->from, &out->load[i], acceleration_of(out, i));
    }
    free(drive);
    return s;
}

/* ---- spatial ----------------------------------------------------------------------------------------------------- */

typedef struct spatial_run {
    const lw_spatial *m;
    lw_dynamics      *d;
    const lw_space   *s;
    lw_loads         *out;
    lw_error         *e;
    lw_space_follow   follow;            /* the drives as inputs; memory NULL: they do not take every freedom */
} spatial_run;

static lw_spatial_measure drive_of(const lw_spatial *m, int i) { return m->n_drive ? m->drive[i] : m->input[i].measure; }

/* Twice the kinetic energy at unit rate of one drive, the others at rest. */
static void reflect(spatial_run *r, const lw_space_moment *o)
{
    lw_space_follow *f = &r->follow;
    const lw_space *s = r->s;
    memcpy(f->q, o->q, (size_t)s->n_q*sizeof *f->q);
    lw_space_rows_fill(&f->z, f->q, f->z.near);
    if (!lw_space_rows_factor(&f->z))
        return;                                                        /* singular for its drives: without limit */
    for (int i = 0; i < r->out->n; i++) {
        memset(f->rhs, 0, (size_t)f->z.n_row*sizeof *f->rhs);
        f->rhs[s->n_row + f->n_idle + i] = 1/lw_space_scale(s, drive_of(r->m, i));
        if (!lw_space_rows_solve(&f->z, NULL, f->rhs, true, f->v_try, f->l))
            return;
        widen(r->out->load[i].inertia, 2*lw_space_kinetic(s, f->v_try));
    }
}

static lw_status take_spatial(void *context, const lw_moment *m)
{
    spatial_run *r = context;
    lw_space_moment all, *o = &all;
    lw_status s = lw_dynamics_space_moment(r->d, m, o, r->e);
    if (s != LW_OK)
        return s;
    for (int i = 0; i < r->out->n; i++) {
        lw_spatial_measure of = drive_of(r->m, i);
        lw_load *l = &r->out->load[i];
        double value, rate, second;
        lw_space_measured(r->s, o->frame, of, 0, o->v, &value, &rate);
        lw_space_measured(r->s, o->frame, of, 0, o->a, &value, &second);
        speed_of(r->out, i)[l->n] = rate;
        acceleration_of(r->out, i)[l->n] = second - lw_space_measure_bias(r->s, o->frame, of, o->v)*lw_space_scale(r->s, of);
        torque_of(r->out, i)[l->n++] = o->drive[i];
    }
    if (r->follow.memory)
        reflect(r, o);
    return LW_OK;
}

lw_status lw_loads_spatial(const lw_spatial *m, const lw_load_options *o, lw_loads *out, lw_error *e)
{
    lw_dynamics_options d = lw_dynamics_options_default();
    lw_dynamics_report report;
    lw_error none, own = { 0 };
    spatial_run r = { .m = m, .out = out, .e = e ? e : &own };
    *out = (lw_loads){ 0 };
    int n = m->n_drive ? m->n_drive : m->n_input;
    lw_status s = make_room(n, o, out, e);
    lw_spatial_measure *drive = s == LW_OK ? malloc((size_t)n*sizeof *drive) : NULL;
    d.analysis = LW_ANALYSIS_KINEMATIC;
    d.from = o->from;
    d.to = o->to;
    d.intervals = o->intervals;
    d.stop = o->stop;
    if (s == LW_OK)
        s = drive ? lw_dynamics_make_spatial(m, &d, &r.d, r.e) : lw_error_set(e, LW_E_MEMORY, "out of memory");
    for (int i = 0; s == LW_OK && i < n; i++) {
        drive[i] = drive_of(m, i);
        out->load[i].slides = drive[i].of != LW_OF_TURN;
        lw_spatial_measure_name(m, drive[i], out->load[i].name, sizeof out->load[i].name);
    }
    if (s == LW_OK) {
        r.s = lw_dynamics_space(r.d);
        lw_status fits = lw_space_follow_make(r.s, drive, n, false, &r.follow, &none);
        if (fits == LW_E_MEMORY)
            s = lw_error_set(e, fits, "out of memory");
        else if (fits != LW_OK)
            r.follow.memory = NULL;
    }
    if (s == LW_OK) {
        find_kinks(r.d, o, out);
        s = lw_dynamics_run(r.d, take_spatial, &r, &report, r.e);
    }
    if (r.follow.memory)
        lw_space_follow_free(&r.follow);
    lw_dynamics_free(r.d);
    free(drive);
    return s;
}
