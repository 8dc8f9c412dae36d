/* Models in space. */
#include "surface/surface.h"

#include <stdlib.h>
#include <string.h>
#include "catalogues/exchange/format.h"
#include "grammar/model/spatial.h"
#include "mbs/dynamics/dynamics_space.h"
#include "mbs/formulations/formulations.h"
#include "mbs/space/space_mobility.h"

LW_SURFACE_FILE(lw_spatial)

int lw_spatial_count(const lw_spatial *model, char what)
{
    switch (what) {
    case 'l': return model->n_link;
    case 'j': return model->n_joint;
    case 'i': return model->n_input;
    case 'd': return model->n_drive;
    case 'c': return model->n_coupling;
    case 't': return model->n_tracer;
    default:  return 0;
    }
}

const char *lw_spatial_name(const lw_spatial *model, char what, int index)
{
    if (index < 0 || index >= lw_spatial_count(model, what))
        return NULL;
    lw_spatial_measure of = what == 'i' ? model->input[index].measure : what == 'd' ? model->drive[index]
                          : (lw_spatial_measure){ what == 't' ? LW_OF_X : LW_OF_TURN, index };
    return what == 'l' ? model->body[index].name : what == 'c' ? model->coupling[index].name : of.of >= LW_OF_X ? model->tracer[of.index].name
        : model->joint[of.index].name;
}

lw_status lw_spatial_export(const lw_spatial *model, const char *format, char **out, size_t *size, lw_error *error)
{
    const lw_format *f = lw_format_find(format);
    lw_bytes b = { 0 };
    *out = NULL;
    if (!f || !f->write)
        return lw_error_set(error, LW_E_ARG, "there is no format '%s' to write", format);
    lw_status s = lw_format_write_space(f, model, &b, error);
    return s == LW_OK ? lw_surface_give(&b, out, size, error) : s;
}

lw_status lw_spatial_analyse_mobility(const lw_spatial *model, double tolerance, uint64_t seed, lw_mobility_info *out, lw_error *error)
{
    lw_space_mobility m;
    if (!(tolerance > 0 && tolerance <= 1e-4))
        return lw_error_set(error, LW_E_ARG, "the tolerance of closing lies between 0 and 1e-4");
    lw_status s = lw_space_mobility_find(model, tolerance, seed, NULL, &m, error);
    if (s != LW_OK)
        return s;
    *out = (lw_mobility_info){ .kind = m.freedom > 0 ? "moves" : m.shaky ? "shaky" : "rigid", .count = m.count,
                               .freedom = m.freedom, .generic = -1, .instant = m.instant, .redundant = m.n_redundant,
                               .idle = m.idle, .residual = m.residual };
    lw_space_mobility_free(&m);
    return LW_OK;
}

lw_status lw_spatial_trace(const lw_spatial *model, bool in_time, double from, double to, int intervals,
                           lw_spatial_trace_callback *visit, void *context, lw_error *error)
{
    lw_space_trace o = { .in_time = in_time, .from = from, .to = to, .intervals = intervals, .whole = !in_time
                         && from == to };
    if (intervals < 1 || !(from <= to) || (in_time && from == to))
        return lw_error_set(error, LW_E_ARG, "a trace needs an interval or more, and an end that is not before its begin");
    return lw_space_trace_run(model, &o, visit, context, error);
}

/* ---- simulation --------------------------------------------------------------------------------------------- */

lw_status lw_surface_spatial_make(lw_dynamics *d, lw_surface_spatial *s, lw_error *error)
{
    const lw_spatial *m = lw_dynamics_space(d)->model;         /* with the nodes of elastic links */
    *s = (lw_surface_spatial){ .d = d };
    s->link = calloc((size_t)m->n_link, sizeof *s->link);
    s->tracer = calloc((size_t)m->n_tracer + 1, sizeof *s->tracer);
    return s->link && s->tracer ? LW_OK : lw_error_set(error, LW_E_MEMORY, "out of memory");
}

void lw_surface_spatial_free(lw_surface_spatial *s)
{
    free(s->link), free(s->tracer);
    *s = (lw_surface_spatial){ 0 };
}

lw_status lw_surface_spatial_take(lw_surface_spatial *s, const lw_moment *moment, lw_error *error)
{
    lw_space_moment m;
    const lw_space *space = lw_dynamics_space(s->d);
    lw_status st = lw_dynamics_space_moment(s->d, moment, &m, error);
    if (st != LW_OK)
        return st;
    lw_space_links(space, &m, s->link);
    lw_space_tracers(space, m.frame, m.q, m.v, m.a, s->tracer);
    s->sample = (lw_spatial_sample){ m.t, s->link, s->tracer, m.joint, m.input, m.input_rate, m.drive, m.kinetic, m.potential,
                                     m.work, m.off, m.coupling };
    return LW_OK;
}

typedef struct visitor {
    lw_surface_spatial   now;
    lw_error            *e;
    lw_spatial_callback *visit;
    void                *context;
} visitor;

static lw_status ignore(void *context, const lw_moment *m) { (void)context, (void)m; return LW_OK; }

static lw_status hand_on(void *context, const lw_moment *m)
{
    visitor *v = context;
    lw_status st = lw_surface_spatial_take(&v->now, m, v->e);
    return st == LW_OK ? v->visit(v->context, &v->now.sample) : st;
}

lw_status lw_spatial_simulate(const lw_spatial *model, const lw_simulation_options *options, lw_spatial_callback *visit,
                              void *context, lw_simulation_report *report, lw_error *error)
{
    lw_dynamics_options o;
    lw_dynamics_report q = { 0 };
    lw_rest rest;
    lw_error own = { 0 };
    visitor v = { .visit = visit, .context = context, .e = error ? error : &own };
    if (report)
        *report = (lw_simulation_report){ .formulation = "" };
    lw_status s = lw_surface_options(options, &o, error);
    if (s == LW_OK && o.force.apply)
        s = lw_error_set(error, LW_E_KIND, "spatial models take no forces of the caller's own");
    lw_dynamics *d = NULL;
    if (s == LW_OK)
        s = lw_dynamics_make_spatial(model, &o, &d, error);
    if (s != LW_OK)
        return s;
    s = lw_surface_spatial_make(d, &v.now, error);
    if (s == LW_OK)
        s = lw_dynamics_analyse(d, visit ? hand_on : ignore, &v, &q, &rest, error);
    if (report)
        lw_surface_report(&q, report);
    lw_surface_notes(options ? options->note : (lw_note_sink){ 0 }, d, &q);
    lw_surface_spatial_free(&v.now);
    lw_dynamics_free(d);
    return s;
}
