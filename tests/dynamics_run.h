/* tests/dynamics_run.h - models from text or examples/, run to their end. */
#ifndef LW_TESTS_DYNAMICS_RUN_H
#define LW_TESTS_DYNAMICS_RUN_H

#include "base/file.h"
#include "mbs/formulations/formulations.h"
#include "mbs/ode/integrate.h"
#include "tests/json_text.h"

typedef struct drun {
    lw_model    model;
    lw_system   system;
    lw_dynamics_report   report;
    lw_error    e;
    lw_status   status;
    int         n_moment;
    double      t[1100], q[LW_SYSTEM_Q_MAX], v[LW_SYSTEM_Q_MAX], a[LW_SYSTEM_Q_MAX];
    double      l[64], first_l[64], energy[1100];
    bool        unique;
    lw_vec2     tracer[1100];              /* the first tracer [m]                                        */
    lw_dynamics_options o;
} drun;

static inline lw_status drun_keep(void *context, const lw_moment *m)
{
    drun *d = context;
    int n = d->system.n_q, k = d->n_moment < 1100 ? d->n_moment++ : 1099;
    d->t[k] = m->t;
    d->energy[k] = m->kinetic + m->potential;
    d->unique = m->unique;
    memcpy(d->q, m->q, (size_t)n*sizeof *d->q);
    memcpy(d->v, m->v, (size_t)n*sizeof *d->v);
    memcpy(d->a, m->a, (size_t)n*sizeof *d->a);
    memcpy(d->l, m->l, (size_t)(d->system.n_row < 64 ? d->system.n_row : 64)*sizeof *d->l);
    if (k == 0)
        memcpy(d->first_l, d->l, sizeof d->l);
    if (d->system.n_tracer)
        d->tracer[k] = lw_system_point(&d->system, d->system.tracer_body[0], d->system.tracer_arm[0], m->q);
    return LW_OK;
}

/* Read JSON; frees the model that d holds. */
static inline void drun_read_json(drun *d, const char *text)
{
    lw_model_free(&d->model);
    d->e = (lw_error){ 0 };
    d->status = lw_model_read(text, strlen(text), "text", &d->model, &d->e);
    if (d->status != LW_OK)
        fprintf(stderr, "model: %s (line %ld column %ld)\n", d->e.text, d->e.line, d->e.column);
    CHECK_INT(d->status, LW_OK);
    d->o = lw_dynamics_options_default();
}

/* Read a text with ' for ". */
static inline void drun_read_text(drun *d, const char *text)
{
    char *json = json_quotes(strdup(text));
    drun_read_json(d, json);
    free(json);
}

/* Read a format with ' for ". */
static inline void drun_read_format(drun *d, const char *format, double a, double b)
{
    char text[6000];
    json_format(text, sizeof text, format, a, b);
    drun_read_json(d, text);
}

static inline void drun_read(drun *d, const char *file)
{
    char *text = NULL;
    size_t size;
    CHECK_OK(lw_file_read(file, &text, &size, &check_error));
    if (text)
        drun_read_json(d, text);
    free(text);
}

/* The system outlives the run. */
static inline void drun_copy_system(drun *d, const lw_system *s)
{
    int *inputs = calloc((size_t)s->n_input + 1, sizeof *inputs);
    for (int i = 0; i < s->n_input; i++)
        inputs[i] = i;
    lw_system_free(&d->system);
    CHECK_INT(lw_system_choose_inputs(s, inputs, s->n_input, &d->system), LW_OK);
    free(inputs);
}

/* Copy the times and tracer points of a run. */
static inline void drun_keep_path(drun *to, const drun *from)
{
    to->n_moment = from->n_moment;
    memcpy(to->t, from->t, sizeof to->t);
    memcpy(to->tracer, from->tracer, sizeof to->tracer);
}

/* Make and run with d->o; the model is kept. */
static inline lw_status drun_go(drun *d)
{
    lw_dynamics *m;
    d->e = (lw_error){ 0 };
    d->n_moment = 0;
    memset(&d->report, 0, sizeof d->report);
    d->status = lw_dynamics_make(&d->model, &d->o, &m, &d->e);
    if (d->status != LW_OK)
        return d->status;
    drun_copy_system(d, lw_dynamics_system(m));
    d->status = lw_dynamics_run(m, drun_keep, d, &d->report, &d->e);
    lw_dynamics_free(m);
    return d->status;
}

static inline lw_status drun_to(drun *d, lw_formulation f, double tolerance, double to, int intervals)
{
    d->o.formulation = f;
    d->o.relative = d->o.absolute = tolerance;
    d->o.to = to;
    d->o.intervals = intervals;
    return drun_go(d);
}

/* y at `to` by equations in as few coordinates as a textbook takes, for comparison: 1e-14 a step. */
static inline void drun_exact(const lw_ode *ode, double from, double *y, double to)
{
    lw_ode_options o = lw_ode_options_default();
    lw_integrator w;
    lw_ode_stop stop = LW_ODE_STEP;
    double *work = calloc(lw_integrate_work(ode->n, 0), sizeof *work);
    o.relative = o.absolute = 1e-14;
    CHECK_OK(lw_integrate_start(&w, ode, &o, work, from, y, &check_error));
    while (stop != LW_ODE_END && lw_integrate_step(&w, to, &stop, &check_error) == LW_OK) {
    }
    memcpy(y, w.y, (size_t)ode->n*sizeof *y);
    free(work);
}

#endif
