/* Targets, and linkages fitted to them. */
#include "base/real.h"
#include "surface/surface.h"

#include <stdlib.h>
#include <string.h>
#include "base/clock.h"
#include "catalogues/pages/fit_page.h"
#include "optimise/precision/exact.h"
#include "optimise/report/robustness.h"
#include "optimise/task/read_file.h"
#include "optimise/topology/topology_search.h"

/* ---- targets ------------------------------------------------------------------------------------------------ */

/* A target read into memory of its own: `s` is what reading it said. */
static lw_status own_target(const lw_target *t, lw_status s, lw_target **out)
{
    if (s == LW_OK)
        s = LW_SURFACE_COPY(t, out);
    return s;
}

lw_status lw_target_parse(const char *text, size_t size, const char *file, const lw_target_options *options,
                          lw_target **out, lw_error *error)
{
    lw_target t;
    *out = NULL;
    return own_target(&t, lw_target_read_text(text, size, file ? file : "", options, &t, error), out);
}

lw_status lw_target_load(const char *path, const lw_target_options *options, lw_target **out, lw_error *error)
{
    lw_target t;
    *out = NULL;
    return own_target(&t, lw_target_read_file(path, options, &t, error), out);
}

lw_status lw_target_create(size_t n, const double *x, const double *y, const double *theta, const double *angle,
                           const double *weight, int closed, lw_target **out, lw_error *error)
{
    lw_target t;
    *out = NULL;
    return own_target(&t, lw_target_make(n, x, y, theta, angle, weight, closed, &t, error), out);
}

void lw_target_destroy(lw_target *target)
{
    if (target)
        lw_target_free(target);
    free(target);
}

size_t lw_target_n(const lw_target *target) { return target->n; }
bool   lw_target_closed(const lw_target *target) { return target->closed; }
double lw_target_length(const lw_target *target) { return target->length; }
const char *lw_target_note(const lw_target *target) { return target->note; }

void lw_target_stations(const lw_target *target, const double **x, const double **y, const double **theta, const double **angle)
{
    if (x)
        *x = target->x;
    if (y)
        *y = target->y;
    if (theta)
        *theta = target->theta;
    if (angle)
        *angle = target->angle;
}

/* ---- what is asked for ------------------------------------------------------------------------------------------ */

#define X(id, name, place, angle, prescribed) name,
static const char *const tasks[] = { "auto", LW_TASK_LIST(X) NULL };
#undef X
#define X(id, name) name,
static const char *const timings[] = { "auto", LW_TIMING_LIST(X) NULL };
#undef X
static const char *const datums[] = { "first", "frame", "plane", NULL };

lw_fit_request lw_fit_request_default(void)
{
    lw_fit_options o = lw_fit_options_default();
    return (lw_fit_request){ .types = "fourbar", .dof = 1, .joints = "r", .topology = "all", .task = "auto",
                             .timing = "auto", .angle_from = "first", .weight_path = 1,
                             .seed = o.seed, .budget = 1e6, .results = o.n_result };
}

/* A task file and its target read into `task` and `t`: `s` is what reading them said. */
static lw_status own_task(lw_task_file *task, lw_target *t, lw_status s, lw_task_file **out, lw_target **target)
{
    if (s != LW_OK) {
        free(task);
        return s;
    }
    s = LW_SURFACE_COPY(t, target);
    if (s == LW_OK) {
        *out = task;
        return s;
    }
    lw_target_free(t);
    lw_task_file_destroy(task);
    return s;
}

lw_status lw_task_file_load(const char *path, lw_task_file **out, lw_target **target, lw_error *error)
{
    lw_task_file *task = calloc(1, sizeof *task);
    lw_target t;
    *out = NULL;
    *target = NULL;
    if (!task)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    return own_task(task, &t, lw_task_file_read_file(path, NULL, task, &t, error), out, target);
}

lw_status lw_task_file_parse(const char *text, size_t size, const char *file, lw_task_file **out, lw_target **target, lw_error *error)
{
    lw_task_file *task = calloc(1, sizeof *task);
    lw_target t;
    *out = NULL;
    *target = NULL;
    if (!task)
        return lw_error_set(error, LW_E_MEMORY, "out of memory");
    lw_status s = lw_task_file_read_text(text, size, file ? file : "", task, &t, error);
    return own_task(task, &t, s, out, target);
}

void lw_task_file_destroy(lw_task_file *task)
{
    if (task)
        lw_task_file_free(task);
    free(task);
}

lw_fit_request lw_task_file_request(const lw_task_file *task)
{
    const lw_fit_spec *s = &task->spec;
    lw_fit_request r = lw_fit_request_default();
    r.links = task->links ? task->links : r.links;
    r.dof = task->dof ? task->dof : r.dof;
    r.joints = task->joints[0] ? task->joints : r.joints;
    r.topology = task->topology[0] ? task->topology : r.topology;
    r.task = task->has_task ? tasks[s->task + 1] : r.task;
    r.timing = task->has_timing ? timings[s->timing + 1] : r.timing;
    r.angle_from = datums[s->datum];
    for (int i = 0; i < LW_ALSO_MAX; i++)
        r.point_link[i] = (int)s->carrier[i];
    r.weight_path = s->a;
    r.weight_angle = s->b;
    r.angle_length = s->angle_length;
    r.crank_only = s->crank_only && s->exclude_drag_link;
    r.full_turn = s->crank_only;
    r.min_transmission = task->limits & LW_LIMIT_TRANSMISSION && !(s->min_transmission > 0) ? -1 : s->min_transmission;
    r.max_acceleration = s->max_acceleration;
    r.max_slide_acceleration = s->max_slide_acceleration;
    r.length_range[0] = s->length_lo;
    r.length_range[1] = s->length_hi;
    r.position_range[0] = s->position_lo;
    r.position_range[1] = s->position_hi;
    r.length_ratio = s->length_ratio;
    r.max_size = task->limits & LW_LIMIT_SIZE && !(s->max_size > 0) ? -1 : s->max_size;
    r.class_margin = task->limits & LW_LIMIT_MARGIN && !(s->class_margin > 0) ? -1 : s->class_margin;
    r.through_limits = task->limits & LW_LIMIT_MOTION;
    r.unlimited = task->limits == LW_LIMIT_ALL;
    r.tolerance = s->tolerance;
    r.n_bound = s->n_bound;
    r.bound = s->bound;
    r.n_zone = s->n_zone;
    r.zone = s->zone;
    return r;
}

static lw_status make_spec(const lw_target *t, const lw_fit_request *r, lw_fit_spec *spec, lw_error *e)
{
    int task = lw_surface_word("task", r->task, tasks, e);
    int timing = task < 0 ? -1 : lw_surface_word("timing", r->timing, timings, e);
    int datum = timing < 0 ? -1 : lw_surface_word("angle_from", r->angle_from, datums, e);
    *spec = lw_fit_spec_default();
    if (datum < 0)
        return LW_E_ARG;
    if (r->n_bound < 0 || r->n_bound > (int)(sizeof spec->bound/sizeof *spec->bound) || r->n_zone < 0 || r->n_zone > LW_ZONE_MAX)
        return lw_error_set(e, LW_E_ARG, "at most %d bounds and %d zones", (int)(sizeof spec->bound/sizeof *spec->bound), LW_ZONE_MAX);
    spec->task = task > 0 ? (lw_task)(task - 1) : lw_task_suggested(t);
    spec->timing = timing > 0 ? (lw_timing)(timing - 1) : t->angle ? LW_TIMING_PRESCRIBED : LW_TIMING_FREE;
    spec->datum = (lw_datum)datum;
    if (datum > 0 && spec->timing != LW_TIMING_PRESCRIBED)
        return lw_error_set(e, LW_E_ARG, "angle_from has a meaning with prescribed input angles only");
    for (int i = 0; i < LW_ALSO_MAX; i++) {
        if (r->point_link[i] < LW_CARRIER_ANY || r->point_link[i] > LW_CARRIER_OUTPUT)
            return lw_error_set(e, LW_E_ARG, "point_link is 0 to 3, not %d", r->point_link[i]);
        spec->carrier[i] = (lw_carrier)r->point_link[i];
    }
    spec->a = r->weight_path;
    spec->b = r->weight_angle;
    if (!(spec->b > 0))
        lw_fit_spec_weigh_angles(spec, t, r->angle_length);
    spec->crank_only = r->crank_only || r->full_turn;
    spec->exclude_drag_link = r->crank_only;
    spec->min_transmission = fmax(0, r->min_transmission);
    spec->max_acceleration = r->max_acceleration;
    spec->max_slide_acceleration = r->max_slide_acceleration;
    spec->length_lo = r->length_range[0];
    spec->length_hi = r->length_range[1];
    spec->position_lo = r->position_range[0];
    spec->position_hi = r->position_range[1];
    spec->length_ratio = fmax(0, r->length_ratio);
    spec->max_size = fmax(0, r->max_size);
    spec->class_margin = fmax(0, r->class_margin);
    spec->tolerance = r->tolerance;
    spec->n_bound = r->n_bound;
    spec->n_zone = r->n_zone;
    if (r->n_bound > 0)
        memcpy(spec->bound, r->bound, (size_t)r->n_bound*sizeof *r->bound);
    if (r->n_zone > 0)
        memcpy(spec->zone, r->zone, (size_t)r->n_zone*sizeof *r->zone);
    for (int i = 0; i < r->n_zone; i++)
        if (lw_zone_settle(&spec->zone[i], e) != LW_OK)
            return LW_E_ARG;
    return LW_OK;
}

/* Limits that the request gives, or switches off. */
static unsigned limits_given(const lw_fit_request *r)
{
    return r->unlimited ? LW_LIMIT_ALL
         : (r->min_transmission != 0 ? LW_LIMIT_TRANSMISSION : 0) | (r->length_ratio != 0 ? LW_LIMIT_RATIO : 0)
         | (r->max_size != 0 ? LW_LIMIT_SIZE : 0) | (r->class_margin != 0 ? LW_LIMIT_MARGIN : 0)
         | (r->through_limits ? LW_LIMIT_MOTION : 0);
}

/* Progress that can say no, on top of a flag that can be set from outside. */
typedef struct control {
    const lw_fit_request *request;
    const lw_target      *target;
    const lw_fit_spec    *spec;
    double                best, started;
    volatile int          stop;
} control;

static void show(void *context, double done, double seconds, double best)
{
    control *c = context;
    if (c->request->stop && *c->request->stop)
        c->stop = 1;
    if (c->request->progress && !c->request->progress(c->request->context, done, seconds, best))
        c->stop = 1;
}

/* Each stage begins with finds of its own: only what beats all stages is shown. */
static void show_found(void *context, const lw_candidate *best)
{
    control *c = context;
    lw_linkage *k = best->objective < c->best ? malloc(sizeof *k) : NULL;
    if (k && lw_fit_report_linkage(c->target, c->spec, best, k, NULL) == LW_OK) {
        c->best = best->objective;
        c->request->found(c->request->context, k, best->objective, lw_clock_wall() - c->started);
    }
    free(k);
}

static lw_status make_options(const lw_target *t, const lw_fit_request *r, control *c, lw_fit_options *o, lw_error *e)
{
    *o = lw_fit_options_default();
    *c = (control){ .request = r, .target = t, .spec = &o->spec, .best = INFINITY,
                    .started = lw_clock_wall() };
    lw_status s = make_spec(t, r, &o->spec, e);
    o->types = r->types;
    o->solver = r->solver ? lw_solver_find(r->solver) : NULL;
    if (s == LW_OK && r->solver && !o->solver)
        s = lw_error_set(e, LW_E_ARG, "there is no solver '%s'", r->solver);
    o->seed = r->seed;
    o->jobs = r->jobs;
    o->max_seconds = r->max_seconds;
    o->starts = r->starts;
    o->max_rounds = r->rounds;
    o->n_result = r->results;
    o->budget = (long)r->budget;
    o->interrupt = r->progress || !r->stop ? &c->stop : r->stop;
    o->progress = r->progress ? show : NULL;
    o->found = r->found ? show_found : NULL;
    o->context = c;
    return s;
}

/* ---- results --------------------------------------------------------------------------------------------------- */

struct lw_results {
    lw_topology_search search;
    bool               is_exact;
    lw_exact           exact;            /* precision points: instead of the search's              */
    lw_fit_results     verified;         /* ... with what passed the second simulation              */
    lw_target          target;           /* a copy                                                         */
    lw_task            task;
};

static const lw_fit *fit_of(const lw_results *r) { return r->is_exact ? &r->exact.fit : &r->search.found.fit; }
static const lw_fit_results *list_of(const lw_results *r) { return r->is_exact ? &r->verified : &r->search.results; }

/* Hand out r, which a search for this task that ended with s has filled. */
static lw_status hand_over(lw_results *r, const lw_target *target, lw_task task, lw_status s, lw_results **out, lw_error *e)
{
    if (s < 0 || s == LW_NOTHING) {
        free(r);
        return s;
    }
    r->task = task;
    lw_status copied = lw_target_join(&target, 1, &r->target, e);
    if (copied != LW_OK) {
        lw_results_destroy(r);
        return copied;
    }
    *out = r;
    return s;
}

lw_status lw_fit_target(const lw_target *target, const lw_fit_request *request, lw_results **out, lw_error *error)
{
    lw_topology_search_options o = lw_topology_search_options_default();
    lw_results *r = calloc(1, sizeof *r);
    lw_linkage *start = calloc((size_t)(request->n_start > 0 ? request->n_start : 0) + 1, sizeof *start);
    control c;
    *out = NULL;
    lw_status s = r && start ? make_options(target, request, &c, &o.fit, error)
                             : lw_error_set(error, LW_E_MEMORY, "out of memory");
    if (s == LW_OK)
        lw_fit_spec_set_limits(&o.fit.spec, target, limits_given(request));
    for (int i = 0; i < request->n_start && s == LW_OK; i++) {
        start[i] = *request->start[i];
        s = lw_start_check(&start[i], error);
    }
    if (s == LW_OK) {
        o.links = request->links;
        o.more = request->links == 0;
        o.freedoms = request->dof;
        o.joints = request->joints;
        o.topologies = request->topology;
        o.gear_ratios = request->gear_ratios ? request->gear_ratios : o.gear_ratios;
        o.input_ratios = request->input_ratios ? request->input_ratios : o.input_ratios;
        o.n_start = request->n_start;
        o.start = start;
        s = lw_topology_search_run(target, &o, &r->search, error);
    }
    free(start);
    return hand_over(r, target, o.fit.spec.task, s, out, error);
}

lw_status lw_fit_precision_points(const lw_target *target, const lw_fit_request *request, lw_results **out, lw_error *error)
{
    lw_fit_options o;
    control c;
    lw_results *r = calloc(1, sizeof *r);
    *out = NULL;
    lw_status s = r ? make_options(target, request, &c, &o, error) : lw_error_set(error, LW_E_MEMORY, "out of memory");
    if (s != LW_OK) {
        free(r);
        return s;
    }
    o.types = strcmp(request->types, lw_fit_request_default().types) == 0 ? NULL : request->types;
    if (!lw_task_table[o.spec.task].prescribed)
        o.spec.timing = LW_TIMING_FREE;
    r->is_exact = true;
    s = lw_exact_run(target, &o, &r->exact, error);
    if (s >= 0 && s != LW_NOTHING) {
        lw_status made = lw_fit_results_make(target, &o.spec, &r->exact.fit, request->results, r->exact.defect, NULL, &r->verified, error);
        s = made == LW_OK ? s : made;
        if (made != LW_OK)
            lw_exact_free(&r->exact);
    }
    return hand_over(r, target, o.spec.task, s, out, error);
}

void lw_results_destroy(lw_results *results)
{
    if (!results)
        return;
    if (results->is_exact) {
        lw_fit_results_free(&results->verified);
        lw_exact_free(&results->exact);
    } else {
        lw_topology_search_free(&results->search);
    }
    lw_target_free(&results->target);
    free(results);
}

int lw_results_count(const lw_results *results) { return list_of(results)->n; }

static bool has_result(const lw_results *r, int i) { return i >= 0 && i < list_of(r)->n; }

static const lw_candidate *candidate_of(const lw_results *r, int i)
{
    return &fit_of(r)->candidate[list_of(r)->candidate[i]];
}

lw_status lw_results_info(const lw_results *results, int i, lw_result_info *out)
{
    if (!has_result(results, i))
        return LW_E_ARG;
    const lw_fit_report *r = &list_of(results)->report[i];
    const lw_candidate *c = candidate_of(results, i);
    *out = (lw_result_info){
        .title = lw_family_title(c->family), .fourbar_class = r->has_class ? r->barker.symbol : "",
        .links = r->linkage.n_link, .objective = c->objective,
        .error_mean = r->error_mean, .error_rms = r->error_rms, .error_max = r->error_max,
        .error_percent = r->error_percent,
        .angle_mean = r->angle_mean, .angle_max = r->angle_max,
        .transmission = { r->transmission_min, r->transmission_max }, .acceleration_max = r->acceleration_max,
        .turns = r->turns, .circuits = r->circuits, .verified = r->verified,
        .stray = lw_fit_report_stray(r), .size = r->size, .passes_limit = r->passes_limit,
        .defects = results->is_exact ? results->exact.defect[list_of(results)->candidate[i]] : 0
    };
    lw_fit_report_active(r, out->at_limit, sizeof out->at_limit);
    return LW_OK;
}

lw_status lw_results_linkage(const lw_results *results, int i, lw_linkage **out)
{
    *out = NULL;
    return has_result(results, i) ? lw_linkage_copy(&list_of(results)->report[i].linkage, out) : LW_E_ARG;
}

const char *lw_results_dimension(const lw_results *results, int i, int dimension, double *value)
{
    if (!has_result(results, i) || dimension < 0 || dimension >= candidate_of(results, i)->n_dim)
        return NULL;
    if (value)
        *value = candidate_of(results, i)->dim[dimension];
    return list_of(results)->report[i].dim_name[dimension];
}

lw_status lw_results_inputs(const lw_results *results, int i, double *input)
{
    if (!has_result(results, i))
        return LW_E_ARG;
    memcpy(input, candidate_of(results, i)->input, results->target.n*sizeof *input);
    return LW_OK;
}

lw_status lw_results_spread(const lw_results *results, const lw_target *target, int i, double tolerance,
                            double clearance, lw_result_spread *out, lw_error *error)
{
    lw_tolerances of = { .length = tolerance, .clearance = clearance, .seed = 1 };
    lw_robustness r;
    memset(out, 0, sizeof *out);
    if (!has_result(results, i) || !results->target.x || target->n != results->target.n)
        return lw_error_set(error, LW_E_ARG, "no result %d with a path for this target", i);
    const lw_fit_report *report = &list_of(results)->report[i];
    lw_status s = lw_robustness_of(target, candidate_of(results, i), report, &of, &r, error);
    if (s == LW_OK)
        *out = (lw_result_spread){ r.rms, r.worst, r.trial_rms, r.within, r.open, "", r.part[r.first] };
    memcpy(out->dimension, r.name[r.first], s == LW_OK ? sizeof out->dimension : 0);
    return s;
}

/* ---- the page -------------------------------------------------------------------------------------------------- */

lw_status lw_results_page(const lw_results *results, const char *title, char **out, size_t *size, lw_error *error)
{
    const lw_fitted f = { title, &results->target, results->task, fit_of(results), list_of(results) };
    lw_bytes b = { 0 };
    *out = NULL;
    lw_status s = lw_fitted_page(&f, 1, title, &b, error);
    if (s == LW_OK)
        return lw_surface_give(&b, out, size, error);
    lw_bytes_free(&b);
    return s;
}
