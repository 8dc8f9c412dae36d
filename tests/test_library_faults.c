/* test_library_faults.c - a program that uses linkwright.h runs out of memory: the library returns a failure or the same
 * result, and never ends the program; and its threads have little stack.
 *
 * This program's own malloc replaces that of the C library in all libraries, among them GSL, igraph, NLopt, SUNDIALS and
 * cairo, whose error handlers stay as they are: GSL's default ends the program.  Each call that takes memory fails once,
 * in a child process.  GMP, which ends a program without memory, is not reached: see docs/promises.md. */
#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>
#include "linkwright.h"
#include "optimise/solvers/method_internal.h"
#include "optimise/topology/packed_mechanism.h"
#include "tests/check.h"
#include "tests/functions.h"
#include "tests/temporary.h"

#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__
#define OWN_MALLOC 0
#else
#define OWN_MALLOC 1
#endif

static atomic_long n_call;
static long fail_at;
static void *failed_for;                             /* who asked for the memory that was not given */
static const char *spared;                           /* a library whose calls do not fail; NULL: none  */

static bool is_in(void *address, const char *library)
{
    Dl_info who;
    return address && dladdr(address, &who) && who.dli_fname && strstr(who.dli_fname, library);
}

static inline bool fails(void *by)
{
    if (++n_call != fail_at)
        return false;
    if (spared && is_in(by, spared)) {
        fail_at++;
        return false;
    }
    failed_for = by;
    return true;
}

#if OWN_MALLOC
void *__libc_malloc(size_t n);
void *__libc_calloc(size_t n, size_t size);
void *__libc_realloc(void *old, size_t n);
void *__libc_memalign(size_t by, size_t n);

#pragma GCC visibility push(default)                  /* of the foreign libraries, too */
void *malloc(size_t n)               { return fails(__builtin_return_address(0)) ? NULL : __libc_malloc(n); }
void *calloc(size_t n, size_t size)  { return fails(__builtin_return_address(0)) ? NULL : __libc_calloc(n, size); }
void *realloc(void *old, size_t n)   { return fails(__builtin_return_address(0)) ? NULL : __libc_realloc(old, n); }
void *aligned_alloc(size_t by, size_t n) { return fails(__builtin_return_address(0)) ? NULL : __libc_memalign(by, n); }
#pragma GCC visibility pop
#endif

/* ---- the calls: each adds its results to a sum that shows every change ---------------------------- */

typedef struct sum { uint64_t hash; } sum;

static void add(sum *s, const void *data, size_t n)
{
    for (size_t i = 0; i < n; i++)
        s->hash = (s->hash ^ ((const unsigned char *)data)[i])*1099511628211u;
}

static lw_status add_vibration(void *context, const lw_vibration_info *v)
{
    add(context, &v->re, sizeof v->re);
    add(context, &v->im, sizeof v->im);
    return LW_OK;
}

static lw_status vibrations(sum *s)
{
    lw_model *m = NULL;
    lw_status st = lw_model_load("examples/pendulum.json", &m, &check_error);
    if (st == LW_OK)
        st = lw_model_vibrations(m, true, false, add_vibration, s, &check_error);
    lw_model_destroy(m);
    return st;
}

static lw_status add_sample(void *context, const lw_simulation_sample *p)
{
    add(context, &p->kinetic, sizeof p->kinetic);
    return LW_OK;
}

static lw_status simulate(sum *s, const char *path, double to)
{
    lw_model *m = NULL;
    lw_simulation *run = NULL;
    lw_simulation_options o = lw_simulation_options_default();
    o.to = to;
    o.intervals = 5;
    lw_status st = lw_model_load(path, &m, &check_error);
    if (st == LW_OK)
        st = lw_simulation_create(m, &o, &run, &check_error);
    if (st == LW_OK)
        st = lw_simulation_run(run, add_sample, s, NULL, &check_error);
    lw_simulation_destroy(run);
    lw_model_destroy(m);
    return st;
}

static lw_status simulation(sum *s) { return simulate(s, "examples/dynamics/governor.json", 0.05); }
static lw_status contact(sum *s)    { return simulate(s, "examples/dynamics/boxes.json", 0.1); }
static lw_status elastic(sum *s)    { return simulate(s, "examples/elastic-cantilever.json", 1e-3); }
static lw_status states(sum *s)     { return simulate(s, "examples/dynamics/boom-cylinder.json", 0.01); }

static lw_status add_in_space(void *context, const lw_spatial_sample *p)
{
    add(context, &p->kinetic, sizeof p->kinetic);
    add(context, &p->link[1], sizeof p->link[1]);
    return LW_OK;
}

static lw_status add_trace(void *context, double at, const double *input, const lw_frame_motion *tracer)
{
    (void)input;
    add(context, &at, sizeof at);
    add(context, &tracer[0].place, sizeof tracer[0].place);
    return LW_OK;
}

/* Mobility, path and motion of models in space. */
static lw_status space(sum *s)
{
    lw_spatial *m = NULL;
    lw_mobility_info info = { 0 };
    lw_status st = lw_spatial_load("examples/space/bricard.json", &m, &check_error);
    if (st == LW_OK)
        st = lw_spatial_analyse_mobility(m, 1e-12, 1, &info, &check_error);
    if (st == LW_OK)
        st = lw_spatial_trace(m, false, 0, 0, 3, add_trace, s, &check_error);
    add(s, &info.freedom, sizeof info.freedom);
    lw_spatial_destroy(m);
    return st;
}

/* Without memory for eight states at once no other method may take over: it gives other numbers. */
static lw_status open_tree(sum *s)
{
    lw_spatial *m = NULL;
    lw_simulation_options o = lw_simulation_options_default();
    o.to = 0.01;
    o.intervals = 2;
    lw_status st = lw_spatial_load("examples/space/governor.json", &m, &check_error);
    if (st == LW_OK)
        st = lw_spatial_simulate(m, &o, add_in_space, s, NULL, &check_error);
    lw_spatial_destroy(m);
    return st;
}

static lw_status family(sum *s)
{
    lw_master *m = NULL;
    lw_variant *v = NULL;
    char *text = NULL;
    size_t size = 0;
    lw_status st = lw_master_load("examples/families/loader.json", &m, &check_error);
    if (st == LW_OK)
        st = lw_variant_create(m, &v);
    if (st == LW_OK)
        st = lw_variant_set(v, "reach", "2.5", &check_error);
    if (st == LW_OK)
        st = lw_variant_hold_checks(v, &check_error);
    if (st == LW_OK)
        st = lw_variant_text(v, &text, &size, &check_error);
    add(s, text, text ? size : 0);
    lw_free(text);
    lw_variant_destroy(v);
    lw_master_destroy(m);
    return st;
}

/* The load of a drive, and the motors that can carry it; a servo loop. */
static lw_status drives(sum *s)
{
    lw_model *m = NULL;
    lw_loads loads = { 0 };
    lw_drive_parts *parts = NULL;
    lw_drive_choice *choice = NULL;
    bool *front = NULL;
    size_t n = 0;
    lw_servo *servo = NULL;
    lw_servo_options o = lw_servo_options_default();
    lw_servo_report report = { 0 };
    o.to = 0.01;
    o.intervals = 4;
    lw_status st = lw_model_load("examples/drives/lifting-arm.json", &m, &check_error);
    if (st == LW_OK)
        st = lw_model_loads(m, 0, 2.5, 20, &loads, &check_error);
    if (st == LW_OK)
        st = lw_drive_parts_load("examples/drives/motors.csv", &parts, &check_error);
    if (st == LW_OK)
        st = lw_drive_choose(&loads.load[0], parts, 10, NULL, &n, &choice, &front, &check_error);
    for (size_t i = 0; st == LW_OK && i < n; i++)
        add(s, &choice[i].worst, sizeof choice[i].worst);
    if (st == LW_OK)
        st = lw_servo_load("examples/drives/servo-axis.json", &servo, &check_error);
    if (st == LW_OK)
        st = lw_servo_run(servo, &o, NULL, NULL, &report, &check_error);
    add(s, &report.heat, sizeof report.heat);
    lw_servo_destroy(servo);
    lw_free(choice);
    lw_free(front);
    lw_drive_parts_destroy(parts);
    lw_loads_free(&loads);
    lw_model_destroy(m);
    return st;
}

static lw_status search(sum *s, bool exact)
{
    static const double x[] = { 0, 0.030, 0.061, 0.090, 0.120 }, y[] = { 0, 0.011, 0.014, 0.009, -0.006 };
    lw_target *t = NULL;
    lw_results *r = NULL;
    lw_fit_request o = lw_fit_request_default();
    o.starts = 4;
    o.rounds = o.jobs = 1;
    o.crank_only = !exact;                           /* the default limits, in an eighth of the time */
    o.max_size = exact ? 0 : 1.1;
    lw_status st = exact ? lw_target_create(5, x, y, NULL, NULL, NULL, false, &t, &check_error)
                         : lw_target_load("examples/ellipse.csv", NULL, &t, &check_error);
    if (st == LW_OK)
        st = (exact ? lw_fit_precision_points : lw_fit_target)(t, &o, &r, &check_error);
    int n = r ? lw_results_count(r) : 0;
    add(s, &n, sizeof n);
    lw_results_destroy(r);
    lw_target_destroy(t);
    return st;
}

static lw_status fit(sum *s)   { return search(s, false); }
static lw_status exact(sum *s) { return search(s, true); }

/* A short search by a solver of another library, or of more links. */
static lw_status short_search(sum *s, const char *solver, int links)
{
    static const double x[] = { 0, 0.030, 0.061, 0.090, 0.120 }, y[] = { 0, 0.011, 0.014, 0.009, -0.006 };
    static const double angle[] = { 0, 0.3, 0.6, 0.9, 1.2 };
    lw_target *t = NULL;
    lw_results *r = NULL;
    lw_fit_request o = lw_fit_request_default();
    o.starts = o.rounds = o.jobs = o.results = 1;
    o.timing = "prescribed";
    o.solver = solver;
    o.links = links;
    o.topology = links > 4 ? "watt1" : "all";
    o.budget = 1000;
    o.joints = "r";
    o.unlimited = true;
    o.crank_only = links == 4;                       /* a third of the time */
    lw_status st = lw_target_create(5, x, y, NULL, angle, NULL, false, &t, &check_error);
    if (st == LW_OK)
        st = lw_fit_target(t, &o, &r, &check_error);
    int n = r ? lw_results_count(r) : 0;
    add(s, &n, sizeof n);
    lw_results_destroy(r);
    lw_target_destroy(t);
    return st == LW_STOPPED ? LW_OK : st;
}

static lw_status fit_gsl(sum *s)    { return short_search(s, "lm-gsl", 4); }
static lw_status fit_slsqp(sum *s)  { return short_search(s, "slsqp", 4); }
static lw_status fit_six(sum *s)    { return short_search(s, NULL, 6); }

/* The postures of an eight-bar whose coupler links are a group of order three. */
static lw_status group(sum *s)
{
    lw_linkage *linkage = NULL;
    lw_kinematics *k = NULL;
    lw_vec2 at[1] = { { 0, 0 } };
    lw_status st = lw_linkage_load("tests/data/linkages/triad-eight-bar.json", &linkage, &check_error);
    if (st == LW_OK)
        st = lw_kinematics_create(linkage, &k, &check_error);
    for (int i = 0; i < 3 && st == LW_OK; i++) {
        st = lw_kinematics_posture(k, lw_kinematics_input(k) + 0.01*i, 0, NULL, NULL, at, NULL);
        add(s, at, sizeof at);
    }
    lw_kinematics_destroy(k);
    lw_linkage_destroy(linkage);
    return st;
}

static lw_status chain(sum *s)
{
    lw_chain *c = NULL, *form = NULL;
    char *text = NULL;
    uint64_t order = 0;
    lw_status st = lw_chain_from_text("Er`G", 4, "graph6", &c, &check_error);
    if (st == LW_OK)
        st = lw_chain_copy(c, &form);
    if (st == LW_OK)
        st = lw_chain_canonical(c, form);
    if (st == LW_OK)
        st = lw_chain_symmetries(c, &order);
    if (st == LW_OK)
        st = lw_chain_to_text(form, "sentence", &text, &check_error);
    if (st == LW_OK)
        add(s, text, strlen(text));
    add(s, &order, sizeof order);
    lw_free(text);
    lw_chain_destroy(form);
    lw_chain_destroy(c);
    return st;
}

/* ---- which mechanisms exist, and a catalogue of them ---- */

static lw_status add_mechanism(void *context, const lw_mechanism *m)
{
    char *text = NULL;
    lw_status st = lw_mechanism_to_text(m, "sentence", &text, NULL);
    if (st == LW_OK)
        add(context, text, strlen(text));
    lw_free(text);
    return st;
}

static lw_status add_chain(void *context, const lw_chain *c)
{
    lw_mechanism *m = NULL;
    lw_choices all = lw_choices_default();
    lw_status st = lw_mechanism_of_chain(c, &m);
    if (st == LW_OK)
        st = lw_enumerate_mechanisms(m, &all, add_mechanism, context, NULL, NULL);
    lw_mechanism_destroy(m);
    return st;
}

static lw_status add_structure(void *context, const char *structure, const char *derivation)
{
    add(context, structure, strlen(structure));
    add(context, derivation, strlen(derivation));
    return LW_OK;
}

static lw_status lists(sum *s)
{
    lw_enumeration six = lw_enumeration_default(6, 1);
    six.jobs = 1;
    lw_status st = lw_enumerate_chains(&six, add_chain, s, NULL);
    return st == LW_OK ? lw_enumerate_structures(4, 1, add_structure, s) : st;
}

static lw_status add_row(void *context, int n, const char *const *name, const lw_value *value)
{
    (void)name;
    for (int i = 0; i < n; i++)
        if (value[i].kind == LW_VALUE_TEXT || value[i].kind == LW_VALUE_BLOB)
            add(context, value[i].text, value[i].size);
    return LW_OK;
}

static lw_status add_hit(void *context, const lw_catalogue_hit *hit)
{
    add(context, &hit->distance, sizeof hit->distance);
    return LW_OK;
}

static lw_status catalogue(sum *s)
{
    char path[300];
    lw_catalogue *c = NULL;
    lw_target *t = NULL;
    lw_catalogue_work work = { .jobs = 1, .seed = 1 };
    snprintf(path, sizeof path, "%s/c.db", temporary_folder());
    remove(path);
    lw_status st = lw_catalogue_open(path, true, 1, &c, NULL);
    if (st == LW_OK)
        st = lw_catalogue_add_chains(c, 6, 1, "r", &work, NULL, NULL);
    if (st == LW_OK)
        st = lw_catalogue_add_curves(c, "fourbar", 4, 20, &work, NULL);
    if (st == LW_OK)
        st = lw_catalogue_query(c, "links=6", "mechanisms", NULL, NULL, 0, add_row, s, NULL);
    if (st == LW_OK)
        st = lw_target_load("examples/ellipse.csv", NULL, &t, NULL);
    if (st == LW_OK)
        st = lw_catalogue_nearest(c, t, NULL, 3, add_hit, s, NULL);
    if (st == LW_OK)
        st = lw_catalogue_check(c, NULL);
    lw_target_destroy(t);
    lw_catalogue_close(c);
    return st;
}

/* ---- motions, pictures and exports of one linkage ---- */

static lw_status curves(sum *s)
{
    lw_linkage *linkage = NULL;
    lw_motion_curves *m = NULL;
    lw_mobility_info freedom;
    double x[20] = { 0 }, y[20] = { 0 };
    lw_status st = lw_linkage_load("examples/klann.json", &linkage, NULL);
    if (st == LW_OK)
        st = lw_linkage_analyse_mobility(linkage, 1e-9, 1, &freedom, NULL);
    if (st == LW_OK)
        st = lw_motion_curves_create(linkage, 2, 1, &m, NULL);
    if (st == LW_OK)
        st = lw_motion_curves_trace(m, 0, 0, 20, NULL, x, y);
    add(s, x, sizeof x);
    add(s, y, sizeof y);
    lw_motion_curves_destroy(m);
    lw_linkage_destroy(linkage);
    return st;
}

static lw_status pictures(sum *s)
{
    static const char *const kinds[] = { "svg", "png", "pdf" }, *const formats[] = { "json", "pyslvs", "adams", "mjcf" };
    lw_linkage *linkage = NULL;
    lw_picture *picture = NULL;
    char *data = NULL;
    size_t size;
    lw_status st = lw_linkage_load("examples/hoeken.json", &linkage, NULL);
    for (size_t i = 0; i < 4 && st == LW_OK; i++) {
        st = lw_linkage_export(linkage, formats[i], &data, &size, NULL);
        if (st == LW_OK)
            add(s, data, size);
        lw_free(data);
        data = NULL;
    }
    if (st == LW_OK)
        st = lw_picture_of_linkage(linkage, NULL, "Hoeken", &picture, NULL);
    for (size_t i = 0; i < 3 && st == LW_OK; i++) {
        st = lw_picture_write(picture, kinds[i], 400, 300, &data, &size, NULL);
        if (st == LW_OK)
            add(s, data, size);
        lw_free(data);
        data = NULL;
    }
    lw_picture_destroy(picture);
    lw_linkage_destroy(linkage);
    return st;
}

/* ---- runs in pieces, with clearance, and of axes ---- */

static lw_status pieces(sum *s)
{
    lw_model *m = NULL;
    lw_stepper *run = NULL;
    char *saved = NULL;
    size_t size;
    lw_simulation_options o = lw_simulation_options_default();
    lw_status st = lw_model_load("examples/pendulum.json", &m, NULL);
    if (st == LW_OK)
        st = lw_stepper_create(m, &o, &run, NULL);
    if (st == LW_OK)
        st = lw_stepper_advance(run, 0.05, NULL);
    if (st == LW_OK)
        st = lw_stepper_save(run, &saved, &size);
    if (st == LW_OK)
        st = lw_stepper_advance(run, 0.1, NULL);
    if (st == LW_OK)
        add(s, &lw_stepper_sample(run)->kinetic, sizeof(double));
    if (st == LW_OK)
        st = lw_stepper_restore(run, saved, size, NULL);
    if (st == LW_OK)
        st = lw_stepper_advance(run, 0.1, NULL);
    if (st == LW_OK)
        add(s, &lw_stepper_sample(run)->kinetic, sizeof(double));
    lw_free(saved);
    lw_stepper_destroy(run);
    lw_model_destroy(m);
    return st;
}

static lw_status clearance(sum *s)
{
    lw_model *m = NULL;
    lw_clearance_settings o = lw_clearance_settings_default();
    lw_clearance_outcome pins[8] = { { 0 } };
    int n = 0;
    o.time = 0.005;
    o.settle = 0.001;
    lw_status st = lw_model_load("examples/clearance-four-bar.json", &m, NULL);
    if (st == LW_OK)
        st = lw_simulate_clearance(m, &o, NULL, NULL, pins, 8, &n, NULL);
    for (int i = 0; i < n && i < 8; i++)
        add(s, &pins[i].force_most, sizeof pins[i].force_most);
    lw_model_destroy(m);
    return st;
}

static lw_status cycle(sum *s)
{
    lw_work_cycle *c = NULL;
    lw_status st = lw_work_cycle_load("examples/cycles/gantry.json", &c, NULL);
    for (int i = 0; st == LW_OK && i < lw_work_cycle_count(c, 'm'); i++) {
        double t[3];
        st = lw_work_cycle_times(c, i, &t[0], &t[1], &t[2]);
        add(s, t, sizeof t);
    }
    lw_work_cycle_destroy(c);
    return st;
}

/* The first allocations fail one by one, further ones at growing distances. */
static const struct { const char *name; int first, density; lw_status (*run)(sum *s); } calls[] = {
    { "vibrations", 40, 4, vibrations }, { "simulation", 40, 4, simulation }, { "fit", 12, 1, fit }, { "exact", 12, 2, exact },
    { "chain", 40, 4, chain }, { "postures of a higher group", 40, 4, group }, { "fit by lm-gsl", 3, 1, fit_gsl },
    { "space", 12, 2, space }, { "open tree", 12, 2, open_tree }, { "family", 12, 2, family }, { "drives", 12, 2, drives }, { "contact", 12, 1, contact },
    { "elastic", 12, 1, elastic }, { "states", 12, 1, states },
    { "lists", 12, 2, lists }, { "catalogue", 12, 1, catalogue }, { "motion curves", 12, 2, curves }, { "pictures", 12, 2, pictures },
    { "run in pieces", 12, 2, pieces }, { "clearance", 12, 2, clearance }, { "work cycle", 12, 2, cycle },
    { "fit by slsqp", 3, 1, fit_slsqp }, { "fit with six links", 3, 1, fit_six },
};

/* ---- each allocation fails once -------------------------------------------------------------------- */

/* in_cairo: the memory was refused to cairo itself, which may leave out text then (docs/promises.md) */
typedef struct outcome { long n_call; lw_status status; sum s; bool in_cairo; } outcome;

static int run_child(int i, long n, outcome *out)
{
    pid_t child = fork();
    if (child == 0) {
        sum s = { 14695981039346656037u };
        n_call = 0;
        fail_at = n;
        lw_status st = calls[i].run(&s);
        fail_at = 0;
        *out = (outcome){ n_call, st, s, is_in(failed_for, "libcairo") };
        _exit(0);
    }
    int state = -1;
    waitpid(child, &state, 0);
    return state;
}

/* The first allocations, some in between, and the last ones, but of those rows where they are GMP's or cairo's (docs/promises.md), or, where
 * another solver is all that is new, those of the row "fit". */
static long next_allocation(size_t i, long n, long all)
{
    long last = calls[i].run == lists || calls[i].run == pictures || calls[i].first < 12 ? 0 : 8;
    long next = n < calls[i].first || n > all - last ? n + 1 : n + n/calls[i].density;
    return n <= all - last && next > all - last ? all - last + 1 : next;
}

TEST(each_allocation_fails)
{
    temporary_folder();                              /* of the children, too */
    sum s;
    CHECK(lists(&s) == LW_OK && pictures(&s) == LW_OK);    /* igraph, cairo and fonts are loaded: their own starts end a program without memory */
    outcome *out = mmap(NULL, 2*sizeof *out, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    for (size_t i = 0; i < sizeof calls/sizeof *calls; i++) {
        CHECK_INT(run_child((int)i, 0, &out[0]), 0);
        CHECK_INT(out[0].status, LW_OK);
        for (long n = 1; n <= out[0].n_call && OWN_MALLOC; n = next_allocation(i, n, out[0].n_call)) {
            int state = run_child((int)i, n, &out[1]);
            bool good = state == 0 && (out[1].status < 0 || (out[1].status == LW_OK && (out[1].in_cairo || out[1].s.hash == out[0].s.hash)));
            if (!good)
                fprintf(stderr, "%s: allocation %ld of %ld fails: state %x, status %d\n", calls[i].name, n, out[0].n_call,
                        (unsigned)state, out[1].status);
            CHECK(good);
        }
    }
    munmap(out, 2*sizeof *out);
}

typedef struct minimum { lw_status status; double x[3]; lw_solver_result r; } minimum;

static minimum minimise(const lw_solver *solver)
{
    lw_function f = hs65();
    lw_solver_options o = lw_solver_options_default();
    minimum m = { .x = { 1, 2, 3 } };
    o.max_evals = 300;
    m.status = lw_method_run(solver, &f, &o, m.x, &m.r);
    return m;
}

/* A solver that finds no memory says so: the point that it began from, with LW_OK, would pass for an answer.  What NLopt takes was there
 * before (solver_nlopt.c). */
TEST(solvers_without_memory_say_so)
{
    spared = "libnlopt";
    for (const lw_solver *solver = lw_solver_table; solver->name; solver++) {
        if (!solver->minimise)
            continue;
        n_call = 0;
        minimum usual = minimise(solver);
        long all = n_call;
        int refused = 0;
        CHECK(usual.status == LW_OK || usual.status == LW_STOPPED);
        for (long n = 1; n <= all && OWN_MALLOC; n += n < 12 ? 1 : n/3) {
            n_call = 0;
            fail_at = n;
            minimum m = minimise(solver);
            fail_at = 0;
            bool same = m.status == usual.status && memcmp(m.x, usual.x, sizeof m.x) == 0 && memcmp(&m.r.f, &usual.r.f, sizeof m.r.f) == 0;
            if (m.status != LW_E_MEMORY && !same)
                fprintf(stderr, "%s: allocation %ld of %ld fails: status %d\n", solver->name, n, all, m.status);
            CHECK(m.status == LW_E_MEMORY || same);
            refused += m.status == LW_E_MEMORY;
        }
        CHECK(refused > 0 || !OWN_MALLOC);
    }
    spared = NULL;
}

/* Two mechanisms are compared by their forms: a labelling without memory is no form that differs.  The first allocations are igraph's. */
TEST(a_form_without_memory_is_a_failure)
{
    static lw_graph form, again;
    static const lw_linkage four = { .n_link = 4, .n_joint = 4, .n_tracer = 1, .tracer = { { .link = 2 } },
        .joint = { { .kind = LW_JOINT_REVOLUTE, .link = { 0, 1 } }, { .kind = LW_JOINT_REVOLUTE, .link = { 1, 2 } },
                   { .kind = LW_JOINT_REVOLUTE, .link = { 2, 3 } }, { .kind = LW_JOINT_REVOLUTE, .link = { 3, 0 } } } };
    lw_linkage tied = four;
    CHECK_INT(lw_linkage_canonical_form(&four, &form), LW_OK);
    for (int n = 1; n <= 5 && OWN_MALLOC; n++) {
        fail_at = n_call + n;
        lw_status st = lw_linkage_canonical_form(&four, &again);
        fail_at = 0;
        CHECK_INT(st, LW_E_MEMORY);
        CHECK(lw_linkage_canonical_form(&four, &again) == LW_OK && memcmp(&form, &again, sizeof form) == 0);
    }
    tied.n_input = 2;
    tied.input[1] = (lw_input){ .joint = 3, .ratio = 0.123456789 };
    CHECK_INT(lw_linkage_canonical_form(&tied, &again), LW_NOTHING);
}

/* ---- little stack ------------------------------------------------------------------------------------ */

static void *run_call(void *at)
{
    outcome *o = at;
    o->s = (sum){ 14695981039346656037u };
    o->status = calls[o->n_call].run(&o->s);
    return NULL;
}

/* A thread with 256 KB of stack is enough for every call. */
TEST(little_stack_is_enough)
{
    for (size_t i = 0; i < sizeof calls/sizeof *calls && OWN_MALLOC; i++) {
        outcome usual = { .n_call = (long)i }, little = usual;
        pthread_attr_t about;
        pthread_t thread;
        run_call(&usual);
        CHECK_INT(pthread_attr_init(&about), 0);
        CHECK_INT(pthread_attr_setstacksize(&about, 256*1024), 0);
        CHECK_INT(pthread_create(&thread, &about, run_call, &little), 0);
        CHECK_INT(pthread_join(thread, NULL), 0);
        pthread_attr_destroy(&about);
        CHECK_INT(usual.status, LW_OK);
        CHECK_INT(little.status, LW_OK);
        CHECK(little.s.hash == usual.s.hash);
    }
}
