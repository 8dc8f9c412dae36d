/* The library as its users see it: linkwright.h alone, and a program with an error handler of its own. */
#include <gsl/gsl_errno.h>
#include <pthread.h>
#include <unistd.h>
#include "linkwright.h"
#include "mbs/dynamics/modes_eigen_internal.h"      /* what no model reaches */
#include "tests/check.h"

static int n_handled;

static void of_program(const char *reason, const char *file, int line, int code)
{
    fprintf(stderr, "%s (%s:%d: %d) reached the program\n", reason, file, line, code);
    n_handled++;
}

static lw_linkage *four_bar(void)
{
    static const lw_joint_info joint[] = {
        { .kind = 'r', .link = { 0, 1 }, .at = { 0, 0 } }, { .kind = 'r', .link = { 1, 2 }, .at = { 0, 1 } },
        { .kind = 'r', .link = { 2, 3 }, .at = { 2, 2.5 } }, { .kind = 'r', .link = { 0, 3 }, .at = { 2, 0 } }
    };
    static const lw_input_info input = { .joint = 0, .value = NAN };
    static const lw_tracer_info tracer = { .name = "P", .link = 2, .at = { 4, 4 } };
    lw_linkage *k = NULL;
    lw_error e;
    CHECK_INT(lw_linkage_create(4, 0, 4, joint, 1, &input, 1, &tracer, &k, &e), LW_OK);
    return k;
}

/* ---- topologies ------------------------------------------------------------------------------------------------ */

static lw_status count(void *n, const lw_chain *chain)
{
    ++*(int *)n;
    return lw_chain_check(chain, NULL);
}

static lw_status stop_at_three(void *n, const lw_chain *chain)
{
    (void)chain;
    return ++*(int *)n == 3 ? LW_STOPPED : LW_OK;
}

TEST(chains_are_made_asked_and_written)
{
    lw_chain *c = NULL, *back = NULL;
    lw_error e;
    char *text = NULL;
    bool same = false;
    int n_class = 0;
    uint8_t lowest[4];
    CHECK_INT(lw_chain_create(33, &c), LW_E_ARG);
    CHECK(!c);
    CHECK_INT(lw_chain_create(4, &c), LW_OK);
    for (int i = 0; i < 4; i++)
        CHECK_INT(lw_chain_join(c, i, (i + 1)%4, 1), LW_OK);
    CHECK_INT(lw_chain_mobility(c), 1);
    CHECK_INT(lw_chain_loops(c), 1);
    CHECK_INT(lw_chain_links_with(c, 2), 4);
    CHECK_INT(lw_chain_joint_freedom(c, 0, 2), 0);
    CHECK_INT(lw_chain_joint_freedom(c, 0, 99), 0);
    CHECK(lw_chain_is_planar(c) && !lw_chain_is_fractionated(c));
    CHECK_INT(lw_chain_orbits(c, lowest, &n_class), LW_OK);
    CHECK_INT(n_class, 1);
    static const char *const notations[] = { "graph6", "lam", "sentence", "franke", "edges", "json" };
    for (size_t i = 0; i < sizeof notations/sizeof *notations; i++) {
        CHECK_INT(lw_chain_to_text(c, notations[i], &text, &e), LW_OK);
        CHECK_INT(lw_chain_from_text(text, strlen(text), notations[i], &back, &e), LW_OK);
        CHECK_INT(lw_chain_is_isomorphic(c, back, &same), LW_OK);
        CHECK(same);
        lw_free(text);
        lw_chain_destroy(back);
    }
    CHECK_INT(lw_chain_to_text(c, "prose", &text, &e), LW_E_ARG);
    CHECK_HAS(e.text, "graph6");
    lw_chain_destroy(c);
}

TEST(sentences_grow_by_rules)
{
    char *four = NULL, *six = NULL;
    lw_chain *c = NULL;
    lw_error e;
    CHECK_INT(lw_sentence_derive(NULL, 2, NULL, 0, 0, -1, &four, &e), LW_OK);
    CHECK_INT(lw_sentence_derive(four, 4, "rrr", 1, 3, -1, &six, &e), LW_OK);
    CHECK_INT(lw_chain_from_text(six, strlen(six), "sentence", &c, &e), LW_OK);
    CHECK_INT(lw_chain_n_link(c), 6);
    CHECK_INT(lw_chain_mobility(c), 1);
    lw_chain_destroy(c);
    lw_free(six);
    CHECK_INT(lw_sentence_derive(four, 4, "rrr", 2, 2, -1, &six, &e), LW_E_ARG);
    CHECK_INT(lw_sentence_derive(NULL, 3, NULL, 1, 2, -1, &six, &e), LW_E_ARG);
    CHECK(!six);
    lw_free(four);
}

TEST(enumerations_stop_when_asked)
{
    lw_enumeration what = lw_enumeration_default(8, 1);
    lw_error e;
    uint64_t chains = 0, grounds = 0;
    int n = 0;
    CHECK_INT(lw_enumerate_chains(&what, count, &n, &e), LW_OK);
    CHECK_INT(n, 16);
    n = 0;
    CHECK_INT(lw_enumerate_chains(&what, stop_at_three, &n, &e), LW_STOPPED);
    CHECK_INT(n, 3);
    CHECK_INT(lw_enumerate_count(&what, &chains, &grounds, &e), LW_OK);
    CHECK_INT(grounds, 71);
    what.links = 7;
    CHECK_INT(lw_enumerate_chains(&what, count, &n, &e), LW_E_ARG);
    CHECK_HAS(e.text, "7");
    what = lw_enumeration_default(8, 1);
    what.filter = "beautiful";
    CHECK_INT(lw_enumerate_count(&what, &chains, &grounds, &e), LW_E_ARG);
}

/* ---- motion ------------------------------------------------------------------------------------------------------ */

static lw_status see_range(void *n, const lw_input_range *range)
{
    CHECK(range->turns);
    ++*(int *)n;
    return LW_OK;
}

TEST(linkages_move_and_are_written)
{
    lw_linkage *k = four_bar(), *back = NULL;
    lw_kinematics *moving = NULL;
    lw_motion_curves *curves = NULL;
    lw_motion_curve_info info;
    lw_fourbar_class barker;
    lw_mobility_info mobility;
    lw_error e;
    lw_vec2 tracer[4];
    char *text = NULL;
    size_t size = 0;
    double x, y, margin, input, lengths[4] = { 2, 1, 2.5, 2.5 };
    int n = 0;
    CHECK_INT(lw_fourbar_classify(lengths, 1e-12, &barker, &e), LW_OK);
    CHECK_TEXT(barker.symbol, "GCRR");
    CHECK_INT(lw_kinematics_create(k, &moving, &e), LW_OK);
    input = lw_kinematics_input(moving);
    CHECK_INT(lw_kinematics_posture(moving, input, 3, NULL, NULL, tracer, &margin), LW_OK);
    CHECK_INT(lw_kinematics_trace(moving, 0, 1, &input, &x, &y, NULL, NULL), LW_OK);
    CHECK_NEAR(tracer[0].x, 4, 1e-14, 0);
    CHECK_NEAR(x, 4, 1e-14, 0);
    CHECK_NEAR(y, 4, 1e-14, 0);
    CHECK_INT(lw_kinematics_posture(moving, input, 4, NULL, NULL, NULL, NULL), LW_E_ARG);
    CHECK_INT(lw_kinematics_trace(moving, 1, 1, &input, &x, &y, NULL, NULL), LW_E_ARG);
    CHECK_TEXT(lw_kinematics_dimension_name(moving, 0), "r1");
    CHECK_NEAR(lw_kinematics_dimension(moving, 0), 2, 1e-15, 0);
    CHECK(!lw_kinematics_dimension_name(moving, 99));
    CHECK_INT(lw_kinematics_ranges(moving, see_range, &n), LW_OK);
    CHECK_INT(n, 2);
    CHECK_INT(lw_motion_curves_create(k, 5, 1, &curves, &e), LW_OK);
    CHECK_INT(lw_motion_curves_count(curves), 2);
    CHECK_INT(lw_motion_curves_info(curves, 0, &info), LW_OK);
    CHECK(info.closed && info.input_turns == 1 && info.limits == 0);
    CHECK_INT(lw_linkage_analyse_mobility(k, 1e-12, 1, &mobility, &e), LW_OK);
    CHECK_INT(mobility.freedom, 1);
    static const char *const formats[] = { "json", "pyslvs", "pmks", "adams" };
    for (size_t i = 0; i < sizeof formats/sizeof *formats; i++) {
        CHECK_INT(lw_linkage_export(k, formats[i], &text, &size, &e), LW_OK);
        CHECK_INT(strlen(text), size);
        CHECK_INT(lw_linkage_parse(text, size, NULL, NULL, &back, &e), LW_OK);
        CHECK_INT(lw_linkage_mobility(back), 1);
        lw_linkage_destroy(back);
        lw_free(text);
    }
    lw_model *model = NULL;
    lw_plate_options plates = { .width = 0.012, .thickness = 0.003, .hole = 0.004, .clearance = 0.0001 };
    CHECK_INT(lw_model_create(k, &model), LW_OK);
    CHECK_INT(lw_model_export(model, "scad", &plates, &text, &size, &e), LW_OK);
    CHECK_HAS(text, "radius = 6;\nbore = 2;\npin = 1.95;\nthickness = 3;\n");
    lw_free(text);
    CHECK_INT(lw_model_set_mass(model, 1, 0.25, (lw_vec2){ 0, 0 }, 1e-3), LW_OK);
    CHECK_INT(lw_model_export(model, "mjcf", NULL, &text, &size, &e), LW_OK);
    CHECK_HAS(text, "mass=\"0.25\"");
    lw_free(text);
    CHECK_INT(lw_model_export(model, "origami", NULL, &text, &size, &e), LW_E_ARG);
    lw_model_destroy(model);
    CHECK_INT(lw_linkage_export(k, "origami", &text, &size, &e), LW_E_ARG);
    /* the same among results, as fit --json prints them */
    char name[] = "/tmp/linkwright-XXXXXX";
    int fd = mkstemp(name);
    CHECK_INT(lw_linkage_export(k, "json", &text, &size, &e), LW_OK);
    dprintf(fd, "{ \"results\": [\n{ \"linkage\": %s },\n{ \"objective\": 1 }, { \"linkage\": { \"joints\": 7 } } ] }",
            text);
    close(fd);
    CHECK_INT(lw_linkage_load(name, &back, &e), LW_OK);
    CHECK_INT(lw_linkage_mobility(back), 1);
    lw_linkage_destroy(back);
    CHECK_INT(lw_linkage_load_result(name, 1, &back, &e), LW_OK);
    lw_linkage_destroy(back);
    CHECK_INT(lw_linkage_load_result(name, 2, &back, &e), LW_E_NOTATION);
    CHECK_HAS(e.text, "results[1]: this result has no linkage");
    CHECK_INT(lw_linkage_load_result(name, 3, &back, &e), LW_E_NOTATION);
    CHECK(e.line >= 3 && !back);
    CHECK_INT(lw_linkage_load_result(name, 4, &back, &e), LW_E_ARG);
    CHECK_HAS(e.text, "result 4 is wanted, but there are 3");
    CHECK_INT(lw_linkage_load_result(name, 0, &back, &e), LW_E_ARG);
    unlink(name);
    lw_free(text);
    lw_motion_curves_destroy(curves);
    lw_kinematics_destroy(moving);
    lw_linkage_destroy(k);
}

TEST(faults_of_a_linkage_are_named)
{
    lw_joint_info joint = { .name = "A", .kind = 'r', .link = { 0, 7 }, .at = { 0, 0 } };
    lw_linkage *k = NULL;
    lw_error e;
    CHECK_INT(lw_linkage_create(2, 0, 1, &joint, 0, NULL, 0, NULL, &k, &e), LW_E_ARG);
    CHECK(!k);
    CHECK_HAS(e.text, "A");
    joint.kind = 'x';
    CHECK_INT(lw_linkage_create(2, 0, 1, &joint, 0, NULL, 0, NULL, &k, NULL), LW_E_ARG);
    CHECK_INT(lw_linkage_create(999, 0, 1, &joint, 0, NULL, 0, NULL, &k, &e), LW_E_ARG);
    CHECK_INT(lw_linkage_parse("{", 1, "x.json", NULL, &k, &e), LW_E_NOTATION);
    CHECK_TEXT(e.file, "x.json");
    CHECK_INT(lw_linkage_load("/no/such/file", &k, &e), LW_E_IO);
    CHECK(!k);
}

/* ---- fits ------------------------------------------------------------------------------------------------------ */

static bool not_a_step_more(void *context, double done, double seconds, double best)
{
    (void)context, (void)done, (void)seconds, (void)best;
    return false;
}

TEST(fits_find_stop_and_explain)
{
    static const double x[5] = { 0, 1, 2, 3, 4 }, y[5] = { 0, 0.1, 0.15, 0.1, 0 };
    lw_target *t = NULL;
    lw_results *r = NULL;
    lw_result_info info;
    lw_linkage *k = NULL;
    lw_error e;
    double input[5], value;
    char *page = NULL;
    size_t size = 0;
    lw_fit_request o = lw_fit_request_default();
    o.rounds = 1;
    o.results = 2;
    o.solver = "lm-gsl";
    CHECK_INT(lw_target_create(5, x, y, NULL, NULL, NULL, 0, &t, &e), LW_OK);
    CHECK_INT(lw_target_n(t), 5);
    CHECK_INT(lw_fit_target(t, &o, &r, &e), LW_OK);
    CHECK(lw_results_count(r) >= 1);
    CHECK_INT(lw_results_info(r, 0, &info), LW_OK);
    CHECK(info.verified && info.error_max < 0.05);
    CHECK_INT(lw_results_inputs(r, 0, input), LW_OK);
    CHECK_TEXT(lw_results_dimension(r, 0, 0, &value), "r1");
    CHECK_INT(lw_results_linkage(r, 0, &k), LW_OK);
    CHECK_INT(lw_results_page(r, "test", &page, &size, &e), LW_OK);
    CHECK_HAS(page, "<!DOCTYPE html>");
    lw_free(page);
    lw_linkage_destroy(k);
    lw_results_destroy(r);
    o.progress = not_a_step_more;
    o.rounds = 0;
    CHECK_INT(lw_fit_target(t, &o, &r, &e), LW_STOPPED);
    lw_results_destroy(r);
    o = lw_fit_request_default();
    o.task = "dance";
    CHECK_INT(lw_fit_target(t, &o, &r, &e), LW_E_ARG);
    CHECK_HAS(e.text, "function");
    CHECK(!r);
    o = lw_fit_request_default();
    CHECK_INT(lw_fit_precision_points(t, &o, &r, &e), LW_OK);
    CHECK(lw_results_count(r) >= 1);
    lw_results_destroy(r);
    lw_target_destroy(t);
}

/* ---- the program's error handler ------------------------------------------------------------------------------- */

static lw_status see_mode(void *n, const lw_vibration_info *mode)
{
    (void)mode;
    ++*(int *)n;
    return LW_OK;
}

/* A mass matrix that GSL cannot factor, which its handler hears of, and loads beyond all bounds. */
static void *vibrate(void *unused)
{
    (void)unused;
    for (int i = 0; i < 50; i++) {
        double stiffness[4] = { 1, 0, 0, 1 }, mass[4] = { 1, 2, 2, 1 }, value[2], vector[4];
        CHECK_INT(lw_eigen_symmetric(2, stiffness, mass, value, vector), LW_E_NUMERIC);
        lw_linkage *k = four_bar();
        lw_model *m = NULL;
        lw_vec2 centre = { 1, 1 }, gravity = { 0, -9.81 };
        int n = 0;
        CHECK_INT(lw_model_create(k, &m), LW_OK);
        for (int link = 1; link < 4; link++)
            CHECK_INT(lw_model_set_mass(m, link, link == i%4 ? 1e-320 : 1e300, centre, 0), LW_OK);
        lw_model_set_gravity(m, gravity);
        lw_model_vibrations(m, i%2, false, see_mode, &n, NULL);
        lw_model_destroy(m);
        lw_linkage_destroy(k);
    }
    return NULL;
}

TEST(no_error_reaches_the_program)
{
    pthread_t thread[4];
    for (int i = 0; i < 4; i++)
        pthread_create(&thread[i], NULL, vibrate, NULL);
    for (int i = 0; i < 4; i++)
        pthread_join(thread[i], NULL);
    CHECK_INT(n_handled, 0);
    gsl_error_handler_t *now = gsl_set_error_handler(of_program);
    CHECK(now == of_program);                                     /* as the program left it */
}

/* ---- space ------------------------------------------------------------------------------------------------------- */

static lw_status last_place(void *context, double at, const double *input, const lw_frame_motion *tracer)
{
    (void)at, (void)input;
    *(lw_vec3 *)context = tracer[0].place;
    return LW_OK;
}

typedef struct spatial_end { int n; double t, torque, x, w, fz; } spatial_end;

static lw_status last_sample(void *context, const lw_spatial_sample *s)
{
    spatial_end *end = context;
    *end = (spatial_end){ end->n + 1, s->t, s->drive[0], s->tracer[0].place.x, s->link[1].omega.z, s->joint[0].force.z };
    return LW_OK;
}

TEST(spatial_models)
{
    static const char text[] = "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"arm\", \"mass\": 2, "
                               "\"centre\": [0.5, 0, 0], "
        "\"inertia\": [0.1, 0.1, 0.1]}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"arm\"], \"at\": "
        "[0, 0, 0], "
        "\"axis\": [0, 0, 1]}], \"input\": {\"joint\": \"A\", \"motion\": \"t^2\"}, \"gravity\": [0, 0, -10], "
        "\"tracers\": [{\"name\": \"P\", \"link\": \"arm\", \"at\": [1, 0, 0]}]}";
    lw_spatial *m;
    lw_mobility_info info;
    lw_simulation_report report;
    lw_error e = { 0 };
    lw_vec3 end;
    spatial_end at = { 0 };
    CHECK(lw_spatial_text(text, strlen(text)));
    CHECK_INT(lw_spatial_parse(text, strlen(text), "arm", &m, &e), LW_OK);
    CHECK_INT(lw_spatial_count(m, 'l'), 2);
    CHECK_TEXT(lw_spatial_name(m, 'i', 0), "A");
    CHECK(lw_spatial_name(m, 't', 1) == NULL);
    CHECK_INT(lw_spatial_analyse_mobility(m, 1e-12, 1, &info, &e), LW_OK);
    CHECK_INT(info.freedom, 1);
    CHECK_INT(lw_spatial_trace(m, false, 0, 0.5, 5, last_place, &end, &e), LW_OK);
    CHECK_NEAR(end.x, cos(0.5), 1e-14, 0);
    lw_simulation_options o = lw_simulation_options_default();
    CHECK_INT(lw_spatial_simulate(m, &o, last_sample, &at, &report, &e), LW_OK);
    CHECK_INT(at.n, 101);
    CHECK_TEXT(report.formulation, "driven");
    CHECK_NEAR(at.torque, (0.1 + 2*0.25)*2, 1e-12, 0);
    CHECK_NEAR(at.w, 2, 1e-13, 0);
    CHECK_NEAR(at.fz, 20, 1e-12, 0);
    CHECK_INT(lw_spatial_set_motion(m, 0, "t +", &e), LW_E_NOTATION);
    o.formulation = "reduced";                                    /* a driven motion needs none */
    CHECK_INT(lw_spatial_simulate(m, &o, NULL, NULL, &report, &e), LW_OK);
    CHECK_TEXT(report.formulation, "driven");
    o.formulation = "smaller";
    CHECK_INT(lw_spatial_simulate(m, &o, NULL, NULL, NULL, &e), LW_E_ARG);
    lw_spatial_destroy(m);
    char *free_text = strdup(text), *motion = strstr(free_text, ", \"motion\": \"t^2\"");
    memset(motion, ' ', strlen(", \"motion\": \"t^2\""));
    CHECK_INT(lw_spatial_parse(free_text, strlen(free_text), "arm", &m, &e), LW_OK);
    o.formulation = "reduced";                                    /* planar dyads only */
    CHECK_INT(lw_spatial_simulate(m, &o, NULL, NULL, NULL, &e), LW_E_KIND);
    CHECK_HAS(e.text, "the reduced formulation cannot do this model");
    o.formulation = "index1";
    CHECK_INT(lw_spatial_simulate(m, &o, NULL, NULL, &report, &e), LW_OK);
    CHECK_TEXT(report.formulation, "index1");
    free(free_text);
    lw_spatial_destroy(m);
    CHECK_INT(lw_spatial_load("no/such/file", &m, &e), LW_E_IO);
    CHECK(m == NULL);
}

int main(void)
{
    gsl_set_error_handler(of_program);
    CHECK_TEXT(lw_version(), LW_VERSION_STRING);
    check_run();
    return check_end();
}
