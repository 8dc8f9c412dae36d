/* The library as its users see it: linkwright.h alone, and a program with an error handler of its own. */
#include <gsl/gsl_errno.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>
#include "linkwright.h"
#include "base/eigen.h"      /* what no model reaches */
#include "tests/check.h"
#include "tests/temporary.h"

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
    CHECK_OK(lw_linkage_create(4, 0, 4, joint, 1, &input, 1, &tracer, &k, &check_error));
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
    bool planar = false;
    CHECK_INT(lw_chain_is_planar(c, &planar), LW_OK);
    CHECK(planar && !lw_chain_is_fractionated(c));
    CHECK_INT(lw_chain_orbits(c, lowest, &n_class), LW_OK);
    CHECK_INT(n_class, 1);
    static const char *const notations[] = { "graph6", "lam", "sentence", "franke", "edges", "json" };
    for (size_t i = 0; i < sizeof notations/sizeof *notations; i++) {
        CHECK_OK(lw_chain_to_text(c, notations[i], &text, &check_error));
        CHECK_OK(lw_chain_from_text(text, strlen(text), notations[i], &back, &check_error));
        CHECK_INT(lw_chain_is_isomorphic(c, back, &same), LW_OK);
        CHECK(same);
        lw_free(text);
        lw_chain_destroy(back);
    }
    CHECK_FAILS(lw_chain_to_text(c, "prose", &text, &check_error), LW_E_ARG, "graph6");
    lw_chain_destroy(c);
}

TEST(sentences_grow_by_rules)
{
    char *four = NULL, *six = NULL;
    lw_chain *c = NULL;
    CHECK_OK(lw_sentence_derive(NULL, 2, NULL, 0, 0, -1, &four, &check_error));
    CHECK_OK(lw_sentence_derive(four, 4, "rrr", 1, 3, -1, &six, &check_error));
    CHECK_OK(lw_chain_from_text(six, strlen(six), "sentence", &c, &check_error));
    CHECK_INT(lw_chain_n_link(c), 6);
    CHECK_INT(lw_chain_mobility(c), 1);
    lw_chain_destroy(c);
    lw_free(six);
    CHECK_INT(lw_sentence_derive(four, 4, "rrr", 2, 2, -1, &six, &check_error), LW_E_ARG);
    CHECK_INT(lw_sentence_derive(NULL, 3, NULL, 1, 2, -1, &six, &check_error), LW_E_ARG);
    CHECK(!six);
    lw_free(four);
}

TEST(enumerations_stop_when_asked)
{
    lw_enumeration what = lw_enumeration_default(8, 1);
    uint64_t chains = 0, grounds = 0;
    int n = 0;
    CHECK_OK(lw_enumerate_chains(&what, count, &n, &check_error));
    CHECK_INT(n, 16);
    n = 0;
    CHECK_INT(lw_enumerate_chains(&what, stop_at_three, &n, &check_error), LW_STOPPED);
    CHECK_INT(n, 3);
    CHECK_OK(lw_enumerate_count(&what, &chains, &grounds, &check_error));
    CHECK_INT(grounds, 71);
    what.links = 7;
    CHECK_FAILS(lw_enumerate_chains(&what, count, &n, &check_error), LW_E_ARG, "7");
    what = lw_enumeration_default(8, 1);
    what.filter = "beautiful";
    CHECK_INT(lw_enumerate_count(&what, &chains, &grounds, &check_error), LW_E_ARG);
    what = lw_enumeration_default(8, 1);
    what.filter = "generating";
    CHECK_OK(lw_enumerate_count(&what, &chains, NULL, &check_error));
    CHECK_INT(chains, 16);
    CHECK_INT(lw_enumerate_count(&what, &chains, &grounds, &check_error), LW_E_ARG);
    char digits[40];
    CHECK_OK(lw_enumerate_labelled(8, 1, digits, &check_error));
    CHECK_TEXT(digits, "247800");
    CHECK_INT(lw_enumerate_labelled(9, 1, digits, &check_error), LW_E_ARG);
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
    CHECK_FAILS(lw_linkage_load_result(name, 2, &back, &check_error), LW_E_NOTATION, "results[1]: this result has no linkage");
    CHECK_INT(lw_linkage_load_result(name, 3, &back, &e), LW_E_NOTATION);
    CHECK(e.line >= 3 && !back);
    CHECK_FAILS(lw_linkage_load_result(name, 4, &back, &check_error), LW_E_ARG, "result 4 is wanted, but there are 3");
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

static lw_status take_weight(void *context, const lw_counterweight *weight)
{
    *(lw_counterweight *)context = *weight;
    return LW_OK;
}

/* A crank of 2 kg whose centre is 0.3 m from its pin: 0.6 kg m on the other side. */
TEST(counterweights)
{
    static const char text[] = "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"crank\", \"mass\": 2, \"centre\": [0.3, 0], \"inertia\": 0.1},"
        "{\"name\": \"rod\", \"mass\": 0}, \"slider\"], \"joints\": [{\"name\": \"O\", \"links\": [\"ground\", \"crank\"], \"at\": [0, 0]},"
        "{\"name\": \"A\", \"links\": [\"crank\", \"rod\"], \"at\": [0.5, 0]}, {\"name\": \"B\", \"links\": [\"rod\", \"slider\"], \"at\": [2, 0]},"
        "{\"name\": \"S\", \"kind\": \"t\", \"links\": [\"ground\", \"slider\"], \"at\": [2, 0], \"along\": [1, 0]}], \"inputs\": [{\"joint\": \"O\", \"motion\": \"6.283185307179586*t\"}]}";
    lw_model *m;
    lw_simulation *run;
    lw_counterweight weight = { 0 };
    double before, after;
    lw_simulation_options o = lw_simulation_options_default();
    o.intervals = 36;
    CHECK_OK(lw_model_parse(text, sizeof text - 1, NULL, &m, &check_error));
    CHECK_OK(lw_simulation_create(m, &o, &run, &check_error));
    CHECK_OK(lw_simulation_balance(run, take_weight, &weight, &before, &after, &check_error));
    CHECK_NEAR(weight.product, 0.6, 1e-9, 0);
    CHECK_POINT(weight.at, -0.5, 0, 1e-9, 0);
    CHECK_NEAR(weight.mass, 1.2, 1e-9, 0);
    CHECK_NEAR(after, 0, 1e-9, 0);
    CHECK_NEAR(before, 0.6, 0.01, 0);
    lw_simulation_destroy(run);
    lw_model_destroy(m);
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
    double input[5], value;
    char *page = NULL;
    size_t size = 0;
    lw_fit_request o = lw_fit_request_default();
    o.rounds = 1;
    o.results = 2;
    o.solver = "lm";
    CHECK_OK(lw_target_create(5, x, y, NULL, NULL, NULL, 0, &t, &check_error));
    CHECK_INT(lw_target_n(t), 5);
    CHECK_OK(lw_fit_target(t, &o, &r, &check_error));
    CHECK(lw_results_count(r) >= 1);
    CHECK_INT(lw_results_info(r, 0, &info), LW_OK);
    CHECK(info.verified && info.error_max < 0.05);
    CHECK_INT(lw_results_inputs(r, 0, input), LW_OK);
    CHECK_TEXT(lw_results_dimension(r, 0, 0, &value), "r1");
    CHECK_INT(lw_results_linkage(r, 0, &k), LW_OK);
    lw_result_spread spread, twice;
    CHECK_OK(lw_results_spread(r, t, 0, 1e-5, 0, &spread, &check_error));
    CHECK_OK(lw_results_spread(r, t, 0, 2e-5, 0, &twice, &check_error));
    CHECK(spread.rms > 0 && spread.rms <= spread.worst && spread.within <= 4*spread.worst && spread.open == 0 && spread.dimension[0]);
    CHECK_NEAR(twice.rms, 2*spread.rms, 0, 1e-9);                      /* to first order in the tolerance */
    CHECK_NEAR(spread.trial_rms, spread.rms, 0, 0.1);                  /* 1000 random linkages: some 3 % */
    CHECK_INT(lw_results_spread(r, t, 99, 1e-5, 0, &spread, &check_error), LW_E_ARG);
    CHECK_OK(lw_results_page(r, "test", &page, &size, &check_error));
    CHECK_HAS(page, "<!DOCTYPE html>");
    CHECK_HAS(page, "test: four-bar");
    CHECK_HAS(page, "download=\"test-1.json\"");
    lw_free(page);
    lw_linkage_destroy(k);
    lw_results_destroy(r);
    o.progress = not_a_step_more;
    o.rounds = 0;
    CHECK_INT(lw_fit_target(t, &o, &r, &check_error), LW_STOPPED);
    lw_results_destroy(r);
    o = lw_fit_request_default();
    o.task = "dance";
    CHECK_FAILS(lw_fit_target(t, &o, &r, &check_error), LW_E_ARG, "function");
    CHECK(!r);
    o = lw_fit_request_default();
    CHECK_OK(lw_fit_precision_points(t, &o, &r, &check_error));
    CHECK(lw_results_count(r) >= 1);
    lw_results_destroy(r);
    lw_target_destroy(t);
}

/* The page of a function is that of the program: where its angles begin, and its curve; also after the target is gone. */
TEST(the_page_of_a_function)
{
    double angle[7], theta[7];
    lw_target *t = NULL;
    lw_results *r = NULL;
    char *page = NULL;
    size_t size = 0;
    lw_fit_request o = lw_fit_request_default();
    o.links = 4;
    o.rounds = 1;
    o.results = 1;
    for (int i = 0; i < 7; i++) {
        angle[i] = 0.2*i;
        theta[i] = 0.1*i + 0.05*i*i;
    }
    CHECK_OK(lw_target_create(7, NULL, NULL, theta, angle, NULL, 0, &t, &check_error));
    CHECK_OK(lw_fit_target(t, &o, &r, &check_error));
    lw_target_destroy(t);
    CHECK_OK(lw_results_page(r, "test", &page, &size, &check_error));
    CHECK_HAS(page, " input0=");
    CHECK_HAS(page, " tool0=");
    CHECK_HAS(page, "class=\"curves\"");
    lw_free(page);
    lw_results_destroy(r);
}

/* ---- the program's error handler ------------------------------------------------------------------------------- */

static lw_status see_mode(void *n, const lw_vibration_info *mode)
{
    (void)mode;
    ++*(int *)n;
    return LW_OK;
}

static lw_status see_sample(void *context, const lw_simulation_sample *sample)
{
    *(lw_vec2 *)context = sample->tracer[0];
    return LW_OK;
}

/* A row of parallelograms with more parts than a linkage holds: its parts, run, stepper, picture and exports. */
TEST(models_of_any_size)
{
    enum { N = 60 };
    char *text = malloc(200*(2*N + 1)*4), *at = text, *out = NULL;
    at += sprintf(at, "{\"linkwright\": 1, \"links\": [\"ground\", \"c0\"");
    for (int i = 1; i <= N; i++)
        at += sprintf(at, ", \"c%d\", \"r%d\"", i, i);
    at += sprintf(at, "], \"joints\": [{\"links\": [\"ground\", \"c0\"], \"name\": \"A0\", \"at\": [0, 0]}");
    for (int i = 1; i <= N; i++)
        at += sprintf(at, ", {\"links\": [\"ground\", \"c%d\"], \"name\": \"A%d\", \"at\": [%d, 0]}, {\"links\": [\"c%d\", \"r%d\"], \"name\": "
                      "\"B%d\", \"at\": [%d, 1]}, {\"links\": [\"r%d\", \"c%d\"], \"name\": \"C%d\", \"at\": [%d, 1]}", i, i, i, i - 1, i, i,
                      i - 1, i, i, i, i);
    at += sprintf(at, "], \"input\": {\"joint\": \"A0\", \"value\": 0, \"motion\": \"0.5*t\"}, \"tracers\": [{\"name\": \"P\", \"link\": \"c%d\","
                  " \"at\": [%d, 1]}]}", N, N);
    lw_model *m = NULL;
    lw_simulation *run = NULL;
    lw_stepper *stepper = NULL;
    lw_picture *picture = NULL;
    lw_joint_info joint;
    lw_input_info input;
    lw_tracer_info tracer;
    lw_simulation_report report;
    size_t size;
    lw_vec2 end = { 0, 0 };
    CHECK_SILENT(lw_model_parse(text, (size_t)(at - text), NULL, &m, &check_error));
    CHECK(lw_model_linkage(m) == NULL);
    CHECK_INT(lw_model_n_link(m), 2*N + 2);
    CHECK_INT(lw_model_n_joint(m), 3*N + 1);
    CHECK_INT(lw_model_n_input(m), 1);
    CHECK_INT(lw_model_n_tracer(m), 1);
    CHECK_TEXT(lw_model_link_name(m, lw_model_ground(m)), "ground");
    CHECK_TEXT(lw_model_link_name(m, 2*N), "c60");
    CHECK(lw_model_link_name(m, 2*N + 2) == NULL);
    CHECK_INT(lw_model_joint(m, 3*N, &joint), LW_OK);
    CHECK_TEXT(joint.name, "C60");
    CHECK_NEAR(joint.at.x, N, 0, 0);
    CHECK_INT(lw_model_joint(m, 3*N + 1, &joint), LW_E_ARG);
    CHECK_INT(lw_model_input(m, 0, &input), LW_OK);
    CHECK_INT(input.joint, 0);
    CHECK_INT(lw_model_tracer(m, 0, &tracer), LW_OK);
    CHECK_INT(lw_model_tracer(m, 1, &tracer), LW_E_ARG);
    CHECK_TEXT(lw_model_link_name(m, tracer.link), "c60");
    lw_simulation_options o = lw_simulation_options_default();
    o.intervals = 4;
    CHECK_OK(lw_simulation_create(m, &o, &run, &check_error));
    CHECK_SILENT(lw_simulation_run(run, see_sample, &end, &report, &check_error));
    CHECK_POINT(end, N - sin(0.5), cos(0.5), 1e-9, 0);
    lw_simulation_destroy(run);
    for (int link = 0; link < lw_model_n_link(m); link++) {
        bool crank = lw_model_link_name(m, link)[0] == 'c';
        int i = atoi(lw_model_link_name(m, link) + 1);
        if (link != lw_model_ground(m))
            CHECK_INT(lw_model_set_mass(m, link, 1, (lw_vec2){ crank ? i : i - 0.5, crank ? 0.5 : 1 }, 0.1), LW_OK);
    }
    CHECK_OK(lw_stepper_create(m, &o, &stepper, &check_error));
    CHECK_OK(lw_stepper_advance(stepper, 0.5, &check_error));
    CHECK_NEAR(lw_stepper_sample(stepper)->link[2*N].angle, 0.25, 1e-9, 0);
    lw_stepper_destroy(stepper);
    static const char *const formats[] = { "json", "pyslvs", "pmks", "adams", "mjcf", "urdf", "sdf", "slvs", "poses", "motiongen" };
    for (size_t i = 0; i < sizeof formats/sizeof *formats; i++) {
        CHECK_OK(lw_model_export(m, formats[i], NULL, &out, &size, &check_error));
        CHECK(size > 10*(3*N + 1));                  /* each joint is there */
        lw_free(out);
    }
    CHECK_OK(lw_picture_of_model(m, NULL, NULL, &picture, &check_error));
    CHECK_OK(lw_picture_write(picture, "svg", 0, 0, &out, &size, &check_error));
    CHECK_HAS(out, "<svg");
    lw_free(out);
    lw_picture_destroy(picture);
    lw_model_destroy(m);
    free(text);
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

typedef struct heard { int notes; char told[512]; } heard;

static void hear(void *context, const char *text)
{
    heard *h = context;
    h->notes++;
    if (strncmp(text, "a run with a tolerance of", 25) == 0)
        snprintf(h->told, sizeof h->told, "%s", text);
}

/* A ball that bounces between two discs: each impact multiplies an error, and a second run tells by how much. */
TEST(runs_tell_their_error)
{
    static const char text[] = "{\"linkwright\": 1, \"gravity\": [0, -9.81], \"links\": [{\"name\": \"ground\", \"shapes\": [{\"circle\": [0, 0], "
        "\"radius\": 1}, {\"polygon\": [[1.5, -2], [2, -2], [2, 3], [1.5, 3]]}]}, {\"name\": \"ball\", \"mass\": 1, \"centre\": [0.3, 2], \"inertia\": 0.01, "
        "\"shapes\": [{\"circle\": [0.3, 2], \"radius\": 0.1}]}], \"joints\": [{\"name\": \"F\", \"kind\": \"n\", \"links\": [\"ground\", \"ball\"]}], "
        "\"contacts\": [{\"links\": [\"ground\", \"ball\"], \"restitution\": 1}]}";
    lw_simulation_report report[2];
    for (int once = 0; once < 2; once++) {
        heard h = { 0 };
        lw_model *m;
        lw_simulation *run;
        CHECK_OK(lw_model_parse(text, strlen(text), NULL, &m, &check_error));
        lw_simulation_options o = lw_simulation_options_default();
        o.formulation = "capture";
        o.to = 3;
        o.once = once;
        o.note = (lw_note_sink){ &h, hear };
        CHECK_OK(lw_simulation_create(m, &o, &run, &check_error));
        CHECK_OK(lw_simulation_run(run, NULL, NULL, &report[once], &check_error));
        CHECK(h.notes > 3);
        CHECK_INT(h.told[0] != '\0', !once);
        lw_simulation_destroy(run);
        lw_model_destroy(m);
    }
    CHECK_NEAR(report[0].coarse_tolerance, pow(2.8, 5)*1e-10, 1e-20, 0);
    CHECK(report[0].place_off > 1e-10 && report[0].place_off < 1e-6 && report[1].coarse_tolerance == 0);
}

TEST(spatial_models)
{
    static const char text[] = "{\"linkwright\": 1, \"links\": [\"ground\", {\"name\": \"arm\", \"mass\": 2, \"centre\": [0.5, 0, 0], "
        "\"inertia\": [0.1, 0.1, 0.1]}], \"joints\": [{\"name\": \"A\", \"links\": [\"ground\", \"arm\"], \"at\": [0, 0, 0], "
        "\"axis\": [0, 0, 1]}], \"input\": {\"joint\": \"A\", \"motion\": \"t^2\"}, \"gravity\": [0, 0, -10], "
        "\"tracers\": [{\"name\": \"P\", \"link\": \"arm\", \"at\": [1, 0, 0]}]}";
    lw_spatial *m;
    lw_mobility_info info;
    lw_simulation_report report;
    lw_vec3 end;
    spatial_end at = { 0 };
    CHECK(lw_spatial_text(text, strlen(text)));
    CHECK_OK(lw_spatial_parse(text, strlen(text), "arm", &m, &check_error));
    CHECK_INT(lw_spatial_count(m, 'l'), 2);
    CHECK_TEXT(lw_spatial_name(m, 'i', 0), "A");
    CHECK(lw_spatial_name(m, 't', 1) == NULL);
    CHECK_OK(lw_spatial_analyse_mobility(m, 1e-12, 1, &info, &check_error));
    CHECK_INT(info.freedom, 1);
    CHECK_OK(lw_spatial_trace(m, false, 0, 0.5, 5, last_place, &end, &check_error));
    CHECK_NEAR(end.x, cos(0.5), 1e-14, 0);
    lw_simulation_options o = lw_simulation_options_default();
    CHECK_OK(lw_spatial_simulate(m, &o, last_sample, &at, &report, &check_error));
    CHECK_INT(at.n, 101);
    CHECK_TEXT(report.formulation, "driven");
    CHECK_NEAR(at.torque, (0.1 + 2*0.25)*2, 1e-12, 0);
    CHECK_NEAR(at.w, 2, 1e-13, 0);
    CHECK_NEAR(at.fz, 20, 1e-12, 0);
    CHECK_INT(lw_spatial_set_motion(m, 0, "t +", &check_error), LW_E_NOTATION);
    o.formulation = "reduced";                                    /* a driven motion needs none */
    CHECK_OK(lw_spatial_simulate(m, &o, NULL, NULL, &report, &check_error));
    CHECK_TEXT(report.formulation, "driven");
    o.formulation = "smaller";
    CHECK_INT(lw_spatial_simulate(m, &o, NULL, NULL, NULL, &check_error), LW_E_ARG);
    lw_spatial_destroy(m);
    char *free_text = strdup(text), *motion = strstr(free_text, ", \"motion\": \"t^2\"");
    memset(motion, ' ', strlen(", \"motion\": \"t^2\""));
    CHECK_OK(lw_spatial_parse(free_text, strlen(free_text), "arm", &m, &check_error));
    o.formulation = "reduced";                                    /* planar dyads only */
    CHECK_FAILS(lw_spatial_simulate(m, &o, NULL, NULL, NULL, &check_error), LW_E_KIND, "the reduced formulation cannot do this model");
    o.formulation = "index1";
    CHECK_OK(lw_spatial_simulate(m, &o, NULL, NULL, &report, &check_error));
    CHECK_TEXT(report.formulation, "index1");
    free(free_text);
    lw_spatial_destroy(m);
    CHECK_INT(lw_spatial_load("no/such/file", &m, &check_error), LW_E_IO);
    CHECK(m == NULL);
}

/* ---- the rest of the topologies, against published counts ------------------------------------------------------- */

static lw_status count_text(void *n, const char *text)                     { return ++*(int *)n, *text ? LW_OK : LW_E_ARG; }
static lw_status count_assortment(void *n, const int *n_with, int size)    { return *(int *)n += size > 2 && n_with[2] > 0, LW_OK; }
static lw_status count_structure(void *n, const char *s, const char *how)  { return *(int *)n += *s == '(' && *how, LW_OK; }
static lw_status count_group(void *n, const lw_chain *truss, int lost, const lw_group_info *g)
{
    return *(int *)n += lw_chain_mobility(truss) == 0 && lost >= 0 && g != NULL, LW_OK;
}

typedef struct four_links { lw_mechanism *want; int n, same; } four_links;

static lw_status compare(void *context, const lw_mechanism *m)
{
    four_links *f = context;
    bool same = false;
    CHECK_INT(lw_mechanism_is_isomorphic(m, f->want, &same), LW_OK);
    f->n++;
    f->same += same;
    return LW_OK;
}

TEST(numbers_structures_and_groups)
{
    lw_link_numbers of_links, of_loops;
    lw_enumeration_cost cost;
    int n = 0;
    CHECK_OK(lw_link_numbers_of_links(8, 1, 0, &of_links, &check_error));
    CHECK_OK(lw_link_numbers_of_loops(1, 3, 0, &of_loops, &check_error));
    CHECK(of_links.loops == 3 && of_links.joints1 == 10 && of_loops.links == 8 && of_loops.joints1 == 10);
    CHECK_INT(lw_link_numbers_of_links(5, 1, 0, &of_links, &check_error), LW_E_ARG);
    CHECK_INT(lw_enumerate_assortments(&of_loops, count_assortment, &n), LW_OK);
    CHECK_INT(n, 3);                                              /* 4-4-0, 5-2-1, 6-0-2 */
    CHECK_INT((n = 0, lw_enumerate_structures(4, 1, count_structure, &n)), LW_OK);
    CHECK_INT(n, 17);
    CHECK_OK((n = 0, lw_enumerate_groups(4, 1, count_group, &n, &check_error)));
    CHECK_INT(n, 2);                                              /* of class III and IV */
    CHECK_OK((n = 0, lw_enumerate_multiple(6, 1, 1, count_text, &n, &check_error)));
    CHECK_INT(n, 2);                                              /* published: tests/test_multiple.c */
    CHECK_OK(lw_enumerate_estimate(14, 1, &cost, &check_error));
    CHECK(cost.chains > 0.5*318162 && cost.chains < 2*318162. && cost.bytes > 0 && cost.list_seconds >= cost.count_seconds);
}

TEST(mechanisms_are_made_asked_and_drawn)
{
    four_links f = { NULL, 0, 0 };
    lw_mechanism *m = NULL, *turned = NULL, *back = NULL;
    lw_linkage *k = NULL;
    lw_picture *picture = NULL;
    char *text = NULL, *svg = NULL, why[200];
    size_t size = 0;
    int link[2], input = 0;
    CHECK_INT(lw_mechanism_create(4, &m), LW_OK);
    for (int i = 0; i < 4; i++)
        CHECK_INT(lw_mechanism_join(m, i, (i + 1)%4, i == 3 ? 't' : 'r'), LW_OK);
    CHECK_INT(lw_mechanism_choose(m, 0, 1, &input, 2), LW_OK);
    CHECK(lw_mechanism_n_link(m) == 4 && lw_mechanism_n_joint(m) == 4 && lw_mechanism_ground(m) == 0 && lw_mechanism_output(m) == 2
          && lw_mechanism_n_input(m) == 1 && lw_mechanism_input(m, 0) == 0 && lw_mechanism_mobility(m) == 1);
    CHECK_INT(lw_mechanism_joint_kind(m, lw_mechanism_joint(m, 3, 0), link), 't');
    CHECK(link[0] + link[1] == 3 && lw_mechanism_joint_kind(m, 4, link) == 0);
    CHECK_INT(lw_mechanism_moves(m, why, sizeof why), LW_OK);
    CHECK_INT(lw_mechanism_copy(m, &turned), LW_OK);
    CHECK_INT(lw_mechanism_choose(turned, 1, 1, &input, 3), LW_OK);      /* the ground no longer carries the slide */
    f.want = m;
    CHECK(compare(&f, m) == LW_OK && compare(&f, turned) == LW_OK && f.same == 1);
    CHECK_OK(lw_mechanism_to_text(m, "json", &text, &check_error));
    CHECK_OK(lw_mechanism_from_text(text, strlen(text), NULL, &back, &check_error));
    CHECK(compare(&f, back) == LW_OK && f.same == 2);
    char twice[2000];
    snprintf(twice, sizeof twice, "%s\n%s\n", text, text);
    CHECK_OK(lw_mechanism_read_all(twice, strlen(twice), NULL, compare, &f, &check_error));
    CHECK(f.n == 5 && f.same == 4);
    lw_free(text);
    CHECK_OK(lw_mechanism_derivation(m, &text, &check_error));
    CHECK(text && *text);
    CHECK_OK(lw_picture_of_mechanisms(1, (const lw_mechanism *const *)&m, NULL, 1, "four", &picture, &check_error));
    CHECK_OK(lw_picture_write(picture, "svg", 0, 0, &svg, &size, &check_error));
    CHECK_HAS(svg, "<svg");
    CHECK(size == strlen(svg));
    CHECK_OK(lw_linkage_of_mechanism(m, 7, &k, &check_error));
    CHECK(lw_linkage_n_link(k) == 4 && lw_linkage_mobility(k) == 1);
    /* from four links by the published rules: pins alone make the four-bar, once */
    lw_mechanism_destroy(back);
    CHECK_INT(lw_mechanism_create(4, &back), LW_OK);
    for (int i = 0; i < 4; i++)
        CHECK_INT(lw_mechanism_join(back, i, (i + 1)%4, 'r'), LW_OK);
    f = (four_links){ back, 0, 0 };
    CHECK_OK(lw_enumerate_grammar(4, "1234", "r", true, compare, &f, &check_error));
    CHECK(f.n >= 1);
    lw_linkage_destroy(k);
    lw_picture_destroy(picture);
    lw_free(svg);
    lw_free(text);
    lw_mechanism_destroy(back);
    lw_mechanism_destroy(turned);
    lw_mechanism_destroy(m);
}

TEST(parts_of_a_linkage)
{
    lw_linkage *k = four_bar(), *copy = NULL, *saved = NULL;
    lw_kinematics *z = NULL;
    lw_joint_info j;
    lw_input_info in;
    lw_tracer_info p;
    char path[300];
    snprintf(path, sizeof path, "%s/four.json", temporary_folder());
    lw_linkage_set_name(k, "four");
    CHECK_INT(lw_linkage_copy(k, &copy), LW_OK);
    CHECK_TEXT(lw_linkage_name(copy), "four");
    CHECK(lw_linkage_n_joint(copy) == 4 && lw_linkage_n_input(copy) == 1 && lw_linkage_n_tracer(copy) == 1
          && lw_linkage_ground(copy) == 0 && lw_linkage_link_name(copy, 0) && *lw_linkage_link_name(copy, 0));
    CHECK(lw_linkage_joint(copy, 2, &j) == LW_OK && j.kind == 'r' && j.at.x == 2 && j.at.y == 2.5);
    CHECK(lw_linkage_input(copy, 0, &in) == LW_OK && in.joint == 0);
    CHECK(lw_linkage_tracer(copy, 0, &p) == LW_OK && p.link == 2 && p.at.x == 4);
    CHECK(lw_linkage_joint(copy, 4, &j) == LW_E_ARG && lw_linkage_input(copy, 1, &in) == LW_E_ARG
          && lw_linkage_tracer(copy, 1, &p) == LW_E_ARG);
    p.at = (lw_vec2){ 3, 5 };
    CHECK_OK(lw_linkage_set_tracer(copy, 0, &p, &check_error));
    CHECK_OK(lw_linkage_save(copy, NULL, path, &check_error));
    CHECK_OK(lw_linkage_load(path, &saved, &check_error));
    CHECK(lw_linkage_tracer(saved, 0, &p) == LW_OK && p.at.x == 3 && p.at.y == 5);
    CHECK_OK(lw_kinematics_create(k, &z, &check_error));
    CHECK_INT(lw_kinematics_turns(z), 1);
    int n = lw_kinematics_n_dimension(z);
    CHECK(n >= 6);
    for (int i = 0; i < n; i++)
        if (strcmp(lw_kinematics_dimension_name(z, i), "r2") == 0) {
            lw_vec2 before[4], after[4];
            double at = lw_kinematics_input(z), length = lw_kinematics_dimension(z, i);
            CHECK_INT(lw_kinematics_posture(z, at, 0, before, NULL, NULL, NULL), LW_OK);
            CHECK_INT(lw_kinematics_set_dimension(z, i, 0.5*length), LW_OK);
            CHECK_INT(lw_kinematics_posture(z, at, 0, after, NULL, NULL, NULL), LW_OK);
            double was = hypot(before[1].x - before[0].x, before[1].y - before[0].y);
            CHECK_NEAR(was, 1, 1e-14, 0);
            CHECK_NEAR(hypot(after[1].x - after[0].x, after[1].y - after[0].y), 0.5, 1e-14, 0);
        }
    CHECK_INT(lw_kinematics_set_dimension(z, n, 1), LW_E_ARG);
    unlink(path);
    lw_kinematics_destroy(z);
    lw_linkage_destroy(saved);
    lw_linkage_destroy(copy);
    lw_linkage_destroy(k);
}

/* ---- targets, tasks, profiles ------------------------------------------------------------------------------------ */

TEST(targets_tasks_and_cycles)
{
    static const char bent[] = "x,y\n0,0\n3,0\n6,0\n6,4\n";
    const double *x, *y, *theta, *angle;
    lw_target *t = NULL;
    lw_task_file *task = NULL;
    lw_work_cycle *c = NULL;
    CHECK_OK(lw_target_parse(bent, strlen(bent), NULL, NULL, &t, &check_error));
    lw_target_stations(t, &x, &y, &theta, &angle);
    CHECK(lw_target_n(t) == 4 && !lw_target_closed(t) && !theta && !angle && lw_target_note(t));
    CHECK_NEAR(lw_target_length(t), 10, 0, 1e-15);
    CHECK(x[3] == 6 && y[3] == 4);
    lw_target_destroy(t);
    CHECK_OK(lw_task_file_load("examples/tasks/walking-foot.json", &task, &t, &check_error));
    lw_fit_request asked = lw_task_file_request(task), plain = lw_fit_request_default();
    CHECK(lw_target_n(t) > 3 && memcmp(&asked, &plain, sizeof asked) != 0);
    lw_target_destroy(t);
    lw_task_file_destroy(task);
    CHECK_INT(lw_task_file_parse("{}", 2, NULL, &task, &t, &check_error), LW_E_NOTATION);
    CHECK_OK(lw_work_cycle_load("examples/cycles/gantry.json", &c, &check_error));
    int axes = lw_work_cycle_count(c, 'a'), moves = lw_work_cycle_count(c, 'm');
    double start, duration, dwell, end = 0;
    CHECK(axes > 0 && moves > 0 && lw_work_cycle_name(c, 'a', 0) && !lw_work_cycle_name(c, 'a', axes));
    for (int i = 0; i < moves; i++) {                                    /* one move after the other */
        CHECK_INT(lw_work_cycle_times(c, i, &start, &duration, &dwell), LW_OK);
        CHECK_NEAR(start, end, 1e-12, 1e-12);
        end = start + duration + dwell;
        for (int a = 0; a < axes; a++)
            CHECK_NEAR(lw_work_cycle_at(c, a, start, NULL).v, 0, 1e-9, 0);
    }
    CHECK_NEAR(lw_work_cycle_end(c), end, 1e-12, 1e-12);
    lw_work_cycle_destroy(c);
    CHECK_INT(lw_work_cycle_parse("{", 1, NULL, &c, &check_error), LW_E_NOTATION);
    lw_axis_limits power = { { -INFINITY, INFINITY }, { -INFINITY, INFINITY }, { -INFINITY, INFINITY } }, quiet = power;
    lw_profile_limit_power(2, 50, 3, &power);
    CHECK_NEAR(3*power.a[1]*power.v[1], 50, 0, 1e-12);                    /* at the end of the ramp */
    CHECK_NEAR(2*power.v[1]*power.v[1]/power.a[1], 2, 0, 1e-12);          /* a third of the time each */
    quiet.a[0] = -4, quiet.a[1] = 4;
    lw_profile_limit_frequency(2, 5, &quiet);
    CHECK_NEAR(remainder(quiet.a[1]/quiet.j[1]*5, 1), 0, 1e-12, 0);
    CHECK(quiet.a[1] <= 4 && quiet.j[1] > 0);
}

/* ---- dynamics ---------------------------------------------------------------------------------------------------- */

static lw_status count_row(void *n, const lw_sweep_result *r)
{
    CHECK_INT(r->status, LW_OK);
    return *(int *)n += r->n_outcome, LW_OK;
}

typedef struct samples { int n; double t, most; } samples;

static lw_status see_contact(void *context, double t, double input, double energy, int n_point, const lw_clearance_point *point)
{
    samples *s = context;
    CHECK(t >= s->t && isfinite(input) && isfinite(energy) && n_point == 1);
    *s = (samples){ s->n + 1, t, t >= 0.01 ? fmax(s->most, fabs(point[0].force)) : s->most };
    return LW_OK;
}

TEST(clearances_run_alone_and_in_a_sweep)
{
    lw_model *m = NULL;
    lw_clearance_outcome one;
    lw_clearance_settings o = lw_clearance_settings_default();
    double speed[] = { 8, 9 };
    lw_sweep_request request = { .n_speed = 2, .speed = speed, .jobs = 1 };
    int n = 0, rows = 0;
    CHECK(o.time == 1.25 && o.settle == 0.4 && isnan(o.speed));
    CHECK_OK(lw_model_load("examples/clearance-four-bar.json", &m, &check_error));
    o.time = 0.02, o.settle = 0.01, o.speed = 8;
    CHECK_OK(lw_simulate_clearance(m, &o, NULL, NULL, &one, 1, &n, &check_error));
    CHECK(n == 1 && one.force_most >= 0);
    samples seen = { 0 };
    o.every = 1e-4;
    CHECK_OK(lw_simulate_clearance(m, &o, see_contact, &seen, &one, 1, &n, &check_error));
    CHECK_INT(seen.n, 201);
    CHECK_NEAR(seen.most, one.force_most, 0, 2e-3);                /* samples and the greatest force fall beside the peak */
    CHECK_NEAR(seen.t, 0.02, 1e-12, 0);
    CHECK_OK(lw_sweep_clearance(m, &o, &request, count_row, NULL, &rows, &check_error));
    CHECK_INT(rows, 2);
    CHECK_INT(lw_model_set_speed(m, 9, 1), LW_E_ARG);
    lw_model_destroy(m);
}

/* ---- motion, families, vibrations -------------------------------------------------------------------------------- */

/* The crank turns about its ground pin; the eight crosses itself once, in its middle. */
TEST(centres_double_points_and_motion_curves)
{
    lw_linkage *k = four_bar(), *there = NULL;
    lw_kinematics *z = NULL;
    lw_motion_curves *curves = NULL;
    lw_picture *picture = NULL;
    lw_instant_motion about;
    lw_double_point twice[4];
    char *text = NULL, path[300];
    double x[361], y[361], input[90], px[90], py[90];
    CHECK_OK(lw_kinematics_create(k, &z, &check_error));
    CHECK_INT(lw_kinematics_instant(z, lw_kinematics_input(z), 1, 0, &about), LW_OK);
    CHECK_NEAR(about.turn, 1, 1e-12, 0);
    CHECK_NEAR(hypot(about.centre.x, about.centre.y), 0, 1e-12, 0);
    CHECK_INT(lw_kinematics_instant(z, 0, 9, 0, &about), LW_E_ARG);
    CHECK_INT(lw_kinematics_explain(z, &text), LW_OK);
    CHECK(text && *text);
    CHECK_OK(lw_kinematics_linkage(z, lw_kinematics_input(z) + 0.5, &there, &check_error));
    for (int i = 0; i < 361; i++) {
        double a = i*3.14159265358979323846/180;
        x[i] = cos(a), y[i] = sin(2*a);
    }
    CHECK_INT(lw_path_double_points(361, x, y, twice, 4), 1);
    CHECK_NEAR(hypot(twice[0].at.x, twice[0].at.y), 0, 1e-9, 0);
    CHECK_OK(lw_motion_curves_create(k, 4, 1, &curves, &check_error));
    CHECK_INT(lw_motion_curves_trace(curves, 0, 0, 90, input, px, py), LW_OK);
    for (int i = 0; i < 90; i++)                     /* the tracer keeps its distance from the pin of the crank */
        CHECK_NEAR(hypot(px[i] - cos(input[i]), py[i] - sin(input[i])), 5, 1e-9, 0);
    CHECK_INT(lw_motion_curves_trace(curves, 99, 0, 90, input, px, py), LW_E_ARG);
    snprintf(path, sizeof path, "%s/four.svg", temporary_folder());
    CHECK_OK(lw_picture_of_linkage(there, NULL, NULL, &picture, &check_error));
    CHECK_OK(lw_picture_save(picture, path, 0, 0, &check_error));
    CHECK_INT(unlink(path), 0);
    lw_picture_destroy(picture);
    lw_motion_curves_destroy(curves);
    lw_linkage_destroy(there);
    lw_kinematics_destroy(z);
    lw_linkage_destroy(k);
    lw_free(text);
}

static lw_status keep_slowest(void *slowest, const lw_vibration_info *v)
{
    double *least = slowest;
    if (v->im > 0 && !(*least < v->frequency))
        *least = v->frequency;
    return LW_OK;
}

TEST(families_and_vibrations)
{
    static const char pendulum[] = "{\"linkwright\": 1, \"gravity\": [0, 0, -9.81], \"links\": [\"ground\", {\"name\": \"bob\", "
        "\"mass\": 2, \"centre\": [0, 0, -0.5], \"inertia\": [0.1, 0.1, 0.1]}], \"joints\": [{\"name\": \"A\", \"kind\": \"revolute\", "
        "\"links\": [\"ground\", \"bob\"], \"at\": [0, 0, 0], \"axis\": [0, 1, 0]}]}";
    lw_master *m = NULL;
    lw_variant *v = NULL;
    lw_spatial *space = NULL;
    lw_model *model = NULL;
    const char *unit = NULL;
    char *text = NULL;
    size_t size = 0;
    double range[2], slowest = NAN;
    CHECK_OK(lw_master_load("examples/families/loader.json", &m, &check_error));
    CHECK_TEXT(lw_master_parameter_name(m, 0), "reach");
    CHECK_INT(lw_master_parameter_unit(m, 0, &unit, range), LW_OK);
    CHECK_TEXT(unit, "m");
    CHECK(range[0] == 1.2 && range[1] == 4 && lw_master_parameter_unit(m, 99, &unit, range) == LW_E_ARG);
    CHECK_INT(lw_variant_create(m, &v), LW_OK);
    CHECK_OK(lw_variant_text(v, &text, &size, &check_error));
    CHECK_OK(lw_model_parse(text, size, NULL, &model, &check_error));
    CHECK_INT(lw_variant_spatial(v, &space, &check_error), LW_E_KIND);             /* a planar one */
    lw_free(text);
    lw_model_destroy(model);
    lw_variant_destroy(v);
    lw_master_destroy(m);
    CHECK_INT(lw_master_parse("{", 1, NULL, &m, &check_error), LW_E_NOTATION);
    CHECK_OK(lw_spatial_parse(pendulum, strlen(pendulum), NULL, &space, &check_error));
    CHECK_OK(lw_spatial_vibrations(space, false, false, keep_slowest, &slowest, &check_error));
    CHECK_NEAR(slowest, sqrt(2*9.81*0.5/(0.1 + 2*0.25))/(2*3.14159265358979323846), 0, 1e-9);
    lw_spatial_destroy(space);
}

/* ---- catalogues and plots ---------------------------------------------------------------------------------------- */

static lw_status take_number(void *out, int n, const char *const *name, const lw_value *v)
{
    CHECK(n == 1 && name[0]);
    *(long long *)out = v->integer;
    return LW_OK;
}

TEST(catalogues_answer_and_are_drawn)
{
    lw_catalogue *c = NULL;
    lw_linkage *k = four_bar();
    char path[300], page[300], command[700], *json = NULL;
    size_t size;
    uint64_t n = 0;
    long long chains = 0;
    double x[] = { 0, 1, 2 }, y[] = { 0, 1, 4 };
    lw_plot_series series = { "squares", 3, x, y };
    snprintf(path, sizeof path, "%s/six.db", temporary_folder());
    CHECK_OK(lw_catalogue_open(path, true, 1, &c, &check_error));
    CHECK_OK(lw_catalogue_add_chains(c, 6, 1, "r", NULL, &n, &check_error));
    CHECK_INT((int)n, 2);
    CHECK_OK(lw_catalogue_sql(c, "SELECT count(*) FROM chain", take_number, &chains, &check_error));
    CHECK_INT((int)chains, 2);
    CHECK_INT(lw_catalogue_sql(c, "DELETE FROM chain", take_number, &chains, &check_error), LW_E_ARG);
    CHECK_OK(lw_linkage_export(k, "json", &json, &size, &check_error));
    CHECK_OK(lw_catalogue_add_linkages(c, json, size, "four.json", &n, &check_error));
    CHECK_INT((int)n, 1);
    snprintf(page, sizeof page, "%s/pages", temporary_folder());
    snprintf(command, sizeof command, "mkdir %s", page);
    CHECK_INT(system(command), 0);
    CHECK_OK(lw_catalogue_pages(c, page, 0, 0, NULL, &check_error));
    snprintf(command, sizeof command, "test -s %s/index.html", page);
    CHECK_INT(system(command), 0);
    int stop = 1;
    lw_catalogue_work work = { .stop = &stop };
    CHECK_INT(lw_catalogue_add_curves(c, NULL, 8, 1000, &work, &check_error), LW_STOPPED);       /* while mechanisms are found */
    CHECK_INT(lw_catalogue_add_curves(c, "fourbar", 4, 100, &work, &check_error), LW_STOPPED);
    CHECK_INT(lw_catalogue_add_chains(c, 8, 1, "r", &work, &n, &check_error), LW_STOPPED);
    stop = 0;
    CHECK_OK(lw_catalogue_add_curves(c, "fourbar", 4, 100, &work, &check_error));
    CHECK_OK(lw_catalogue_check(c, &check_error));
    lw_catalogue_close(c);
    snprintf(path, sizeof path, "%s/release", temporary_folder());
    CHECK_INT(mkdir(path, 0777), 0);
    CHECK_OK(lw_release(path, 7, &work, &check_error));
    snprintf(command, sizeof command, "cd %s && sha256sum -c --quiet SHA256SUMS", path);
    CHECK_INT(system(command), 0);
    snprintf(path, sizeof path, "%s/plot.svg", temporary_folder());
    CHECK_OK(lw_plot_save(path, "title", "x", "y", false, false, 1, &series, &check_error));
    CHECK_INT(lw_plot_save("plot.nothing", "title", "x", "y", false, false, 1, &series, &check_error), LW_E_ARG);
    snprintf(command, sizeof command, "grep -q squares %s && test -e examples/../README.md", path);
    CHECK_INT(system(command), 0);
    lw_free(json);
    lw_linkage_destroy(k);
}

CHECK_MAIN
{
    gsl_set_error_handler(of_program);
    CHECK_TEXT(lw_version(), LW_VERSION_STRING);
    check_run();
    return check_end();
}
