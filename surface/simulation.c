/* Models and how they move under their loads. */
#include "base/real.h"
#include "surface/surface.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "mbs/analysis/counterweights.h"
#include "mbs/analysis/reactions.h"
#include "mbs/clearance/clearance_sweep.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/equilibrium/modes.h"
#include "mbs/formulations/stepping.h"
#include "mbs/elastic/contact.h"
#include "mbs/formulations/formulations.h"

/* ---- models ------------------------------------------------------------------------------------------------- */

lw_status lw_model_create(const lw_linkage *linkage, lw_model **out)
{
    lw_model *m = calloc(1, sizeof *m);
    lw_status s = m ? lw_model_from_linkage(linkage, m) : LW_E_MEMORY;
    *out = s == LW_OK ? m : NULL;
    if (s != LW_OK)
        free(m);
    return s;
}

LW_SURFACE_FILE(lw_model)

const lw_linkage *lw_model_linkage(const lw_model *model) { return model->small; }

lw_status lw_model_set_speed(lw_model *model, int input, double speed)
{
    if (input < 0 || input >= model->linkage.n_input || !isfinite(speed))
        return LW_E_ARG;
    model->has_speed[input] = true;
    model->speed[input] = speed;
    return LW_OK;
}

lw_status lw_model_set_mass(lw_model *model, int link, double mass, lw_vec2 centre, double inertia)
{
    bool good = link >= 0 && link < model->linkage.n_link && !model->elastic[link].given && mass >= 0 && inertia >= 0 && isfinite(mass)
                && isfinite(inertia) && isfinite(centre.x) && isfinite(centre.y);
    if (good)
        model->body[link] = (lw_body){ .given = true, .mass = mass, .centre = centre, .inertia = inertia };
    return good ? LW_OK : LW_E_ARG;
}

void lw_model_set_gravity(lw_model *model, lw_vec2 gravity) { model->gravity = gravity; }

/* ---- simulation ----------------------------------------------------------------------------------------------- */

struct lw_simulation {
    const lw_model      *model;
    lw_dynamics         *d;
    lw_dynamics_options  o;
    lw_note_sink         note;
    lw_simulation_callback *visit;
    void                *context;
    /* one sample */
    lw_link_motion       *link;
    lw_link_acceleration *acceleration;
    lw_reaction          *joint;
    double               *input, *drive;
    lw_vec2              *tracer;
    int                   n_node;
    lw_elastic_node      *node;                /* of elastic links, reserved with the first sample */
    lw_inner_force       *inner;
};

static lw_status reserve_sample(lw_simulation *s)
{
    const lw_assembly *k = &s->model->linkage;
    size_t links = (size_t)k->n_link, inputs = (size_t)k->n_input + 1;
    s->link = calloc(links, sizeof *s->link);
    s->acceleration = calloc(links, sizeof *s->acceleration);
    s->joint = calloc((size_t)k->n_joint, sizeof *s->joint);
    s->input = calloc(inputs, sizeof *s->input);
    s->drive = calloc(inputs, sizeof *s->drive);
    s->tracer = calloc((size_t)k->n_tracer + 1, sizeof *s->tracer);
    return s->link && s->acceleration && s->joint && s->input && s->drive && s->tracer ? LW_OK : LW_E_MEMORY;
}

/* Memory for samples and the options as the library has them. */
static lw_status make_simulation(const lw_model *model, const lw_simulation_options *options, lw_simulation **out, lw_error *error)
{
    lw_dynamics_options o;
    *out = NULL;
    lw_status status = lw_surface_options(options, &o, error);
    if (status != LW_OK)
        return status;
    lw_simulation *s = calloc(1, sizeof *s);
    if (!s)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    s->model = model;
    s->o = o;
    s->note = options ? options->note : (lw_note_sink){ 0 };
    *out = s;
    return reserve_sample(s) == LW_OK ? LW_OK : lw_error_set(error, LW_E_MEMORY, "out of memory");
}

/* Memory for the nodes of elastic links; known once the model is expanded. */
static lw_status reserve_nodes(lw_simulation *s, const lw_dynamics *d)
{
    const lw_elastic_expansion *x = lw_dynamics_elastic(d);
    int all = 0;                                 /* with those that carry modes */
    for (int c = 0; x && c < x->n_chain; c++)
        s->n_node += x->chain[c].n_bound, all += x->chain[c].n_node;
    s->node = calloc((size_t)s->n_node + 1, sizeof *s->node);
    s->inner = calloc((size_t)all + 1, sizeof *s->inner);
    return s->node && s->inner ? LW_OK : LW_E_MEMORY;
}

lw_status lw_simulation_create(const lw_model *model, const lw_simulation_options *options, lw_simulation **out, lw_error *error)
{
    lw_status status = make_simulation(model, options, out, error);
    if (status == LW_OK)
        status = lw_dynamics_make(model, &(*out)->o, &(*out)->d, error);
    if (status == LW_OK && reserve_nodes(*out, (*out)->d) != LW_OK)
        status = lw_error_set(error, LW_E_MEMORY, "out of memory");
    if (status == LW_OK)
        return LW_OK;
    lw_simulation_destroy(*out);
    *out = NULL;
    return status;
}

void lw_simulation_destroy(lw_simulation *simulation)
{
    if (simulation) {
        void *const array[] = { simulation->link, simulation->acceleration, simulation->joint, simulation->input,
                                simulation->drive, simulation->tracer, simulation->node, simulation->inner };
        for (size_t i = 0; i < sizeof array/sizeof *array; i++)
            free(array[i]);
        lw_dynamics_free(simulation->d);
    }
    free(simulation);
}

static void put_nodes(const lw_simulation *s, const lw_moment *m)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    const lw_elastic_expansion *x = lw_dynamics_elastic(s->d);
    for (int c = 0, n = 0; x && c < x->n_chain; n += x->chain[c++].n_bound) {
        const lw_elastic_chain *chain = &x->chain[c];
        lw_reactions_inner(s->d, m, c, s->inner);
        for (int i = 0; i < chain->n_bound; i++) {
            int b = sys->body[chain->node[i]];
            const lw_inner_force *f = &s->inner[i];
            s->node[n + i] = (lw_elastic_node){ chain->link, i, lw_system_point(sys, b, lw_v2(0, 0), m->q), m->q[3*b + 2],
                                                f->normal, f->shear, f->moment, f->stress };
        }
    }
}

static lw_simulation_sample sample_of(const lw_simulation *s, const lw_moment *m)
{
    const lw_system *sys = lw_dynamics_system(s->d);
    const lw_assembly *k = &s->model->linkage;
    for (int b = 0; b < sys->n_body; b++) {
        const double *v = &m->v[3*b], *a = &m->a[3*b];
        if (sys->link[b] >= k->n_link)           /* a node of an elastic link */
            continue;
        s->link[sys->link[b]] = (lw_link_motion){ lw_system_point(sys, b, lw_v2(0, 0), m->q),
                                               lw_v2(v[0]*sys->unit, v[1]*sys->unit), m->q[3*b + 2], v[2] };
        s->acceleration[sys->link[b]] = (lw_link_acceleration){ lw_v2(a[0]*sys->unit, a[1]*sys->unit), a[2] };
    }
    for (int i = 0; i < sys->n_tracer; i++)
        s->tracer[i] = lw_system_point(sys, sys->tracer_body[i], sys->tracer_arm[i], m->q);
    for (int i = 0; i < k->n_input; i++) {
        lw_measure count;
        lw_measure_joint(sys, k->input[i].joint, m->q, m->v, false, &count);
        s->input[i] = k->input[i].value + count.value;
    }
    lw_reactions_joints(s->d, m, s->joint);
    lw_reactions_driving(s->d, m, s->drive);
    put_nodes(s, m);
    return (lw_simulation_sample){ .t = m->t, .link = s->link, .acceleration = s->acceleration, .joint = s->joint,
                                   .input = s->input, .drive = s->drive, .tracer = s->tracer, .state = m->z,
                                   .shaking = lw_reactions_shaking(s->d, m), .kinetic = m->kinetic,
                                   .potential = m->potential, .work = m->work, .residual = m->off,
                                   .n_node = s->n_node, .node = s->node };
}

static lw_status hand_over(void *context, const lw_moment *m)
{
    const lw_simulation *s = context;
    lw_simulation_sample sample = sample_of(s, m);
    return s->visit ? s->visit(s->context, &sample) : LW_OK;
}

lw_status lw_simulation_run(lw_simulation *simulation, lw_simulation_callback *visit, void *context,
                            lw_simulation_report *report, lw_error *error)
{
    lw_dynamics_report r = *lw_dynamics_choice(simulation->d);
    lw_rest rest;
    simulation->visit = visit;
    simulation->context = context;
    lw_status s = lw_dynamics_analyse(simulation->d, hand_over, simulation, &r, &rest, error);
    if (report)
        lw_surface_report(&r, report);
    lw_surface_notes(simulation->note, simulation->d, &r);
    return s;
}

/* ---- runs in pieces -------------------------------------------------------------------------------------------- */

struct lw_stepper {
    lw_simulation       *memory;              /* of samples; its d belongs to steps; NULL: in space               */
    lw_surface_spatial   space;
    lw_note_sink         note;
    lw_error            *e;                   /* of the advance under way                                         */
    lw_stepping         *steps;
    double              *state;
    lw_simulation_sample sample;
    lw_dynamics_report   report;              /* of all pieces                                                    */
};

static lw_status keep_sample(void *context, const lw_moment *m)
{
    lw_stepper *s = context;
    s->sample = sample_of(s->memory, m);
    if (s->memory->model->states.n_state)
        memcpy(s->state, m->z, (size_t)s->memory->model->states.n_state*sizeof *s->state);
    s->sample.state = s->state;
    return LW_OK;
}

static lw_status keep_spatial_sample(void *context, const lw_moment *m)
{
    lw_stepper *s = context;
    return lw_surface_spatial_take(&s->space, m, s->e);
}

lw_status lw_stepper_create(const lw_model *model, const lw_simulation_options *options, lw_stepper **out, lw_error *error)
{
    lw_stepper *s = calloc(1, sizeof *s);
    *out = NULL;
    if (!s)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_status status = make_simulation(model, options, &s->memory, error);
    if (status == LW_OK && !(s->state = calloc((size_t)model->states.n_state + 1, sizeof *s->state)))
        status = lw_error_set(error, LW_E_MEMORY, "out of memory");
    if (status == LW_OK)
        status = lw_stepping_make(model, &s->memory->o, &s->steps, error);
    if (status == LW_OK) {
        s->memory->d = (lw_dynamics *)(uintptr_t)lw_stepping_dynamics(s->steps);
        status = reserve_nodes(s->memory, s->memory->d) == LW_OK ? LW_OK : lw_error_set(error, LW_E_MEMORY, "out of memory");
    }
    if (status == LW_OK)
        status = lw_stepper_advance(s, s->memory->o.from, error);
    if (status == LW_OK) {
        s->note = s->memory->note;
        *out = s;
    } else
        lw_stepper_destroy(s);
    return status;
}

lw_status lw_spatial_stepper_create(const lw_spatial *model, const lw_simulation_options *options, lw_stepper **out, lw_error *error)
{
    lw_dynamics_options o;
    *out = NULL;
    lw_status status = lw_surface_options(options, &o, error);
    if (status == LW_OK && o.force.apply)
        status = lw_error_set(error, LW_E_KIND, "spatial models take no forces of the caller's own");
    lw_stepper *s = status == LW_OK ? calloc(1, sizeof *s) : NULL;
    if (!s)
        return status == LW_OK ? lw_error_set(error, LW_E_MEMORY, "out of memory") : status;
    status = lw_stepping_make_spatial(model, &o, &s->steps, error);
    if (status == LW_OK)
        status = lw_surface_spatial_make((lw_dynamics *)(uintptr_t)lw_stepping_dynamics(s->steps), &s->space, error);
    if (status == LW_OK)
        status = lw_stepper_advance(s, o.from, error);
    if (status == LW_OK) {
        s->note = options ? options->note : (lw_note_sink){ 0 };
        *out = s;
    } else
        lw_stepper_destroy(s);
    return status;
}

const lw_spatial_sample *lw_spatial_stepper_sample(const lw_stepper *stepper)
{
    return stepper->memory ? NULL : &stepper->space.sample;
}

lw_status lw_spatial_stepper_set_load(lw_stepper *stepper, int link, lw_frame_load load)
{
    const double l[] = { load.force.x, load.force.y, load.force.z, load.torque.x, load.torque.y, load.torque.z };
    return stepper->memory ? LW_E_ARG : lw_stepping_set_load(stepper->steps, link, l);
}

void lw_stepper_destroy(lw_stepper *stepper)
{
    if (stepper) {
        if (stepper->memory)
            stepper->memory->d = NULL;
        lw_simulation_destroy(stepper->memory);
        lw_surface_spatial_free(&stepper->space);
        lw_stepping_free(stepper->steps);
        free(stepper->state);
    }
    free(stepper);
}

const lw_simulation_sample *lw_stepper_sample(const lw_stepper *stepper) { return stepper->memory ? &stepper->sample : NULL; }

lw_status lw_stepper_advance(lw_stepper *stepper, double t, lw_error *error)
{
    lw_error own = { 0 };
    stepper->e = error ? error : &own;
    lw_dynamics_report r;
    lw_status s = lw_stepping_advance(stepper->steps, t, stepper->memory ? keep_sample : keep_spatial_sample, stepper, &r, stepper->e);
    if (s != LW_OK)
        return s;
    if (t == lw_stepping_time(stepper->steps))
        lw_surface_notes(stepper->note, lw_stepping_dynamics(stepper->steps), &r);
    r.steps += stepper->report.steps;
    r.refused += stepper->report.refused;
    r.rates += stepper->report.rates;
    r.energy_error += stepper->report.energy_error;
    r.worst_off = fmax(r.worst_off, stepper->report.worst_off);
    stepper->report = r;
    return LW_OK;
}

void lw_stepper_report(const lw_stepper *stepper, lw_simulation_report *out) { lw_surface_report(&stepper->report, out); }

lw_status lw_stepper_set_load(lw_stepper *stepper, int link, lw_link_load load)
{
    return stepper->memory ? lw_stepping_set_load(stepper->steps, link, (const double[]){ load.force.x, load.force.y, load.torque })
                           : LW_E_ARG;
}

lw_status lw_stepper_set_state(lw_stepper *stepper, int state, double value)
{
    return lw_stepping_set_state(stepper->steps, state, value);
}

lw_status lw_stepper_save(const lw_stepper *stepper, char **out, size_t *size)
{
    void *bytes = NULL;
    lw_status s = lw_stepping_save(stepper->steps, &bytes, size);
    *out = bytes;
    return s;
}

lw_status lw_stepper_restore(lw_stepper *stepper, const void *bytes, size_t size, lw_error *error)
{
    lw_status s = lw_stepping_restore(stepper->steps, bytes, size, error);
    return s == LW_OK ? lw_stepper_advance(stepper, lw_stepping_time(stepper->steps), error) : s;
}

int lw_model_n_state(const lw_model *model) { return model->states.n_state; }

const char *lw_model_state_name(const lw_model *model, int state)
{
    return state >= 0 && state < model->states.n_state ? model->states.state[state].name : NULL;
}

int lw_model_find_state(const lw_model *model, const char *name)
{
    for (int i = 0; i < model->states.n_state; i++)
        if (strcmp(model->states.state[i].name, name) == 0)
            return i;
    return -1;
}

/* ---- counterweights -------------------------------------------------------------------------------------------- */

typedef struct postures { const lw_simulation *simulation; size_t n, most; double *q; } postures;

static lw_status keep(void *context, const lw_moment *m)
{
    postures *p = context;
    size_t n_q = (size_t)lw_dynamics_system(p->simulation->d)->n_q;
    if (p->n < p->most)
        memcpy(p->q + p->n++*n_q, m->q, n_q*sizeof *m->q);
    return LW_OK;
}

lw_status lw_simulation_balance(lw_simulation *simulation, lw_counterweight_callback *visit, void *context,
                                double *before, double *after, lw_error *error)
{
    const lw_system *sys = lw_dynamics_system(simulation->d);
    postures p = { .simulation = simulation, .most = (size_t)simulation->o.intervals + 1 };
    lw_dynamics_report r;
    lw_counterweights found = { .n = 0 };
    p.q = calloc(p.most*(size_t)sys->n_q + 1, sizeof *p.q);
    lw_status s = p.q ? lw_dynamics_run(simulation->d, keep, &p, &r, error)
                      : lw_error_set(error, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        s = lw_counterweights_find(simulation->model, sys, p.n, p.q, &found, error);
    free(p.q);
    if (s == LW_OK) {
        *before = found.deviation_before;
        *after = found.deviation_after;
    }
    for (int i = 0; s == LW_OK && i < found.n; i++)
        s = visit(context, &found.weight[i]);
    lw_counterweights_free(&found);
    return s;
}

/* ---- vibrations ------------------------------------------------------------------------------------------------- */

typedef struct vibrations { lw_system s; lw_forces f; lw_modes modes; lw_dynamics *d; } vibrations;

/* Modes of large models, elastic links and models in space: the slowest.  One of both is NULL. */
static lw_status find_slowest(vibrations *w, const lw_model *model, const lw_spatial *space, const lw_modes_options *o, lw_error *e)
{
    lw_dynamics_options options = lw_dynamics_options_default();
    options.analysis = LW_ANALYSIS_STATIC;
    options.hold_inputs = o->hold_inputs;
    lw_status s = space ? lw_dynamics_make_spatial(space, &options, &w->d, e) : lw_dynamics_make(model, &options, &w->d, e);
    if (s != LW_OK)
        return s;
    if (lw_dynamics_massless(w->d))
        return lw_error_set(e, LW_E_ARG, "link \"%s\" has no mass, or no inertia about an axis, so its motion has no frequency: give it a \"mass\" "
                            "and an \"inertia\"", lw_dynamics_massless(w->d));
    size_t n = (size_t)(space ? lw_dynamics_space(w->d)->n_q : lw_dynamics_system(w->d)->n_q);
    double *q = calloc(2*n, sizeof *q);
    if (!q)
        return lw_error_set(e, LW_E_MEMORY, "out of memory");
    lw_dynamics_start(w->d, q, q + n);
    s = lw_modes_find_large(w->d, o, LW_MODES_DEFAULT, 0, q, &w->modes, e);
    free(q);
    if (s == LW_OK && space && w->modes.unbalanced > 1e-6)
        s = lw_error_set(e, LW_E_ARG, "the posture is no equilibrium: %.3g of the greatest force is left over; modes in space are "
                         "those of an equilibrium", w->modes.unbalanced);
    return s;
}

static lw_status find_modes(vibrations *w, const lw_model *model, const lw_modes_options *o, lw_error *e)
{
    double q[LW_SYSTEM_Q_MAX];
    const lw_linkage *small;
    if (model->n_elastic || lw_model_small(model, &small, NULL) != LW_OK)
        return find_slowest(w, model, NULL, o, e);
    lw_status s = lw_forces_system(model, false, &w->s, e);
    if (s == LW_OK)
        s = lw_forces_make(model, &w->s, NULL, &w->f, e);
    if (s != LW_OK)
        return s;
    lw_system_posture(&w->s, q);
    return lw_modes_find(&w->f, o, 0, q, &w->modes, e);
}

static lw_status vibrate(const lw_model *model, const lw_spatial *space, lw_modes_options o, lw_vibration_callback *visit,
                         void *context, lw_error *error)
{
    vibrations *w = calloc(1, sizeof *w);
    lw_status s = !w ? lw_error_set(error, LW_E_MEMORY, "out of memory") : space ? find_slowest(w, NULL, space, &o, error)
                : find_modes(w, model, &o, error);
    for (int i = 0; s == LW_OK && i < w->modes.n_mode; i++) {
        const lw_mode *m = &w->modes.mode[i];
        lw_vibration_info info = { m->re, m->im, m->frequency, m->natural, m->damping };
        s = visit(context, &info);
    }
    if (w) {
        lw_modes_free(&w->modes);
        lw_dynamics_free(w->d);
        lw_forces_free(&w->f);
        lw_system_free(&w->s);
    }
    free(w);
    return s;
}

lw_status lw_model_vibrations(const lw_model *model, bool rest, bool hold, lw_vibration_callback *visit, void *context, lw_error *error)
{
    return vibrate(model, NULL, (lw_modes_options){ .hold_inputs = hold, .rest = rest }, visit, context, error);
}

lw_status lw_spatial_vibrations(const lw_spatial *model, bool rest, bool hold, lw_vibration_callback *visit, void *context, lw_error *error)
{
    return vibrate(NULL, model, (lw_modes_options){ .hold_inputs = hold, .rest = rest }, visit, context, error);
}

/* ---- clearance -------------------------------------------------------------------------------------------------- */

typedef struct contact_run { lw_clearance_callback *visit; void *context; } contact_run;

static lw_status hand_contact(void *context, const lw_clearance_sample *s)
{
    const contact_run *r = context;
    return r->visit(r->context, s->t, s->input, s->energy, s->n_point, s->point);
}

lw_clearance_settings lw_clearance_settings_default(void)
{
    lw_clearance_options o = lw_clearance_options_default();
    return (lw_clearance_settings){ .time = o.time, .settle = o.settle, .tolerance = o.tolerance, .speed = o.speed,
                                    .start = "closed" };
}

static lw_status contact_options(const lw_clearance_settings *settings, lw_clearance_options *o, lw_error *e)
{
    static const char *const starts[] = { "closed", "seated", "crank", NULL };
    int start = lw_surface_word("start", settings->start, starts, e);
    *o = lw_clearance_options_default();
    if (start < 0)
        return LW_E_ARG;
    o->time = settings->time;
    o->settle = settings->settle;
    o->tolerance = settings->tolerance;
    o->speed = settings->speed;
    o->start = (lw_clearance_start)start;
    o->max_step = settings->max_steps;
    o->until = settings->max_seconds > 0 ? lw_clock_wall() + settings->max_seconds : 0;
    o->stop = settings->stop;
    return LW_OK;
}

lw_status lw_simulate_clearance(const lw_model *model, const lw_clearance_settings *settings,
                                lw_clearance_callback *visit, void *context, lw_clearance_outcome *outcome, int room,
                                int *n, lw_error *error)
{
    contact_run run = { visit, context };
    lw_clearance_options o;
    lw_clearance_result r = { 0 };
    lw_clearance_scene *scene;
    *n = 0;
    lw_status s = contact_options(settings, &o, error);
    if (s == LW_OK)
        s = lw_clearance_make(model, &scene, error);
    if (s != LW_OK)
        return s;
    o.every = settings->every;
    o.sink = visit ? hand_contact : NULL;
    o.context = &run;
    s = lw_clearance_run(scene, &o, &r, error);
    lw_clearance_free(scene);
    *n = r.n_joint;
    for (int i = 0; i < r.n_joint && i < room; i++)
        outcome[i] = r.joint[i];
    return s;
}

static lw_status hand_sweep(const lw_sweep *w, lw_sweep_callback *visit, lw_contact_limits_callback *see_limits, void *context)
{
    lw_status s = LW_OK;
    for (int i = 0; i < w->n_row && visit && s == LW_OK; i++) {
        const lw_sweep_row *row = &w->row[i];
        const lw_sweep_law *law = &w->law[row->law];
        lw_sweep_result r = { .model = lw_clearance_name(law->model), .stiffness = law->stiffness,
                              .damping = law->damping, .speed = row->speed,
                              .status = row->done ? row->status : LW_STOPPED, .why = row->why,
                              .n_outcome = row->r.n_joint, .outcome = row->r.joint };
        s = visit(context, &r);
    }
    for (int i = 0; i < w->n_limit && see_limits && s == LW_OK; i++) {
        const lw_sweep_limit *l = &w->limit[i];
        const lw_sweep_law *law = &w->law[l->law];
        lw_contact_limits r = { .model = lw_clearance_name(law->model), .stiffness = law->stiffness,
                                .damping = law->damping, .joint = l->joint, .kept = l->kept, .lost = l->lost,
                                .lost_again = l->lost_again, .kept_again = l->kept_again };
        s = see_limits(context, &r);
    }
    return s;
}

lw_status lw_sweep_clearance(const lw_model *model, const lw_clearance_settings *settings,
                             const lw_sweep_request *request, lw_sweep_callback *visit,
                             lw_contact_limits_callback *see_limits, void *context, lw_error *error)
{
    enum { LAWS = LW_CLEARANCE_LANKARANI + 1 };
    lw_clearance_model law[LAWS];
    lw_sweep_options o = { .stiffness = request->stiffness, .damping = request->damping, .speed = request->speed,
                           .model = law, .n_model = request->n_model, .n_stiffness = request->n_stiffness,
                           .n_damping = request->n_damping, .n_speed = request->n_speed, .unit = 1,
                           .refine = request->refine, .jobs = request->jobs };
    lw_sweep w;
    if (request->n_speed < 1 || request->n_model < 0 || request->n_model > LAWS)
        return lw_error_set(error, LW_E_ARG, "a sweep has a speed or more, and at most %d models", LAWS);
    for (int i = 0; i < request->n_model; i++)
        if ((law[i] = lw_clearance_named(request->model[i])) == LW_CLEARANCE_NONE)
            return lw_error_set(error, LW_E_ARG, "there is no clearance model '%s'", request->model[i]);
    lw_status s = contact_options(settings, &o.run, error);
    if (s != LW_OK)
        return s;
    s = lw_sweep_make(model, &o, &w, error);
    if (s == LW_OK)
        s = lw_sweep_run(&w, error);
    if (s == LW_OK)
        s = hand_sweep(&w, visit, see_limits, context);
    lw_sweep_free(&w);
    return s;
}
