/* Runs in pieces against runs in one; saved and restored runs bit by bit. */
#include <linkwright.h>

#include "tests/json_text.h"

/* load(path) and parse(text with ' for ") of a kind of models. */
#define READERS(kind, load, parse)                                                       \
    static kind *load(const char *path)                                                  \
    {                                                                                    \
        kind *m = NULL;                                                                  \
        lw_error e = { LW_OK, "", 0, 0, "" };                                            \
        CHECK_INT(kind##_load(path, &m, &e), LW_OK);                                     \
        CHECK_TEXT(e.text, "");                                                          \
        return m;                                                                        \
    }                                                                                    \
    static kind *parse(const char *quoted)                                               \
    {                                                                                    \
        char text[3000];                                                                 \
        kind *m = NULL;                                                                  \
        lw_error e = { LW_OK, "", 0, 0, "" };                                            \
        json_format(text, sizeof text, "%s", quoted);                                    \
        CHECK_INT(kind##_parse(text, strlen(text), "text", &m, &e), LW_OK);              \
        CHECK_TEXT(e.text, "");                                                          \
        return m;                                                                        \
    }

READERS(lw_model, load, parse)
READERS(lw_spatial, load_in_space, parse_in_space)

typedef struct last { lw_link_motion link[32]; double state[32], work, energy; int n; } last;

static void keep(last *l, const lw_model *m, const lw_simulation_sample *s)
{
    l->n = lw_linkage_n_link(lw_model_linkage(m));
    memcpy(l->link, s->link, (size_t)l->n*sizeof *l->link);
    if (lw_model_n_state(m))
        memcpy(l->state, s->state, (size_t)lw_model_n_state(m)*sizeof *l->state);
    l->work = s->work;
    l->energy = s->kinetic + s->potential;
}

static lw_model *model;

static lw_status keep_last(void *context, const lw_simulation_sample *s)
{
    keep(context, model, s);
    return LW_OK;
}

static void compare(const last *a, const last *b, double off)
{
    for (int i = 0; i < a->n; i++) {
        CHECK_POINT(a->link[i].place, b->link[i].place.x, b->link[i].place.y, off, 0);
        CHECK_NEAR(a->link[i].angle, b->link[i].angle, off, 0);
        CHECK_NEAR(a->link[i].velocity.x, b->link[i].velocity.x, 100*off, 0);
        CHECK_NEAR(a->link[i].angular_velocity, b->link[i].angular_velocity, 100*off, 0);
    }
    for (int i = 0; i < lw_model_n_state(model); i++)
        CHECK_NEAR(a->state[i], b->state[i], off, 10*off);
}

/* To `end` in one and in pieces. */
static void agree_by(const char *formulation, lw_model *m, double end, int pieces, double off)
{
    lw_simulation_options o = lw_simulation_options_default();
    lw_simulation *run = NULL;
    lw_stepper *steps = NULL;
    lw_error e = { LW_OK, "", 0, 0, "" };
    last one = { .n = 0 }, many = { .n = 0 };
    model = m;
    o.formulation = formulation;
    o.to = end;
    CHECK_INT(lw_simulation_create(m, &o, &run, &e), LW_OK);
    CHECK_INT(lw_simulation_run(run, keep_last, &one, NULL, &e), LW_OK);
    CHECK_INT(lw_stepper_create(m, &o, &steps, &e), LW_OK);
    for (int k = 1; steps && k <= pieces; k++)
        CHECK_INT(lw_stepper_advance(steps, end*k/pieces, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    if (steps)
        keep(&many, m, lw_stepper_sample(steps));
    compare(&many, &one, off);
    CHECK_NEAR(many.energy - many.work, one.energy - one.work, 100*off, 1e-8);
    lw_simulation_destroy(run);
    lw_stepper_destroy(steps);
    lw_model_destroy(m);
}

static void agree(lw_model *m, double end, int pieces, double off) { agree_by("auto", m, end, pieces, off); }

static const char motor[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'arm', 'mass': 2, 'centre': [0.3, 0], 'inertia': 0.02}],'joints': [{'name': 'A', 'links': ['ground', "
    "'arm'], 'at': [0, 0]%s}], 'input': {'joint': 'A', 'speed': 0},'gravity': [0, -9.81], 'states': [{'name': 'u', 'rate': 0, 'start': 5}], 'motors': "
    "[{'name': 'M', 'joint': 'A','voltage': 'state(u)', 'resistance': 0.8, 'inductance': 1e-3, 'torque_constant': 0.05, 'inertia': 1e-4,'ratio': 20}]}";

static lw_model *motor_model(const char *stop)
{
    char text[2000];
    snprintf(text, sizeof text, motor, stop);
    return parse(text);
}

TEST(pieces_make_the_whole)
{
    agree(load("examples/andrews.json"), 0.03, 30, 1e-7);
    agree(load("examples/pendulum.json"), 2, 50, 1e-8);
    agree(load("examples/dynamics/trebuchet.json"), 1, 20, 1e-6);
    agree(load("examples/dynamics/servo-arm.json"), 0.5, 20, 1e-7);
    agree(load("examples/five-bar.json"), 0.4, 10, 1e-7);                 /* every freedom is driven */
    agree(load("examples/dynamics/boxes.json"), 0.2, 8, 1e-9);            /* contacts that stick and slip; later impacts of corners depend on rounding */
    agree(load("examples/dynamics/rope.json"), 1, 20, 1e-8);
    agree(load("examples/elastic-slider-crank.json"), 0.02, 4, 1e-5);
    /* an arm that falls on its stop, bounces and rests there */
    agree(motor_model(", 'stop': {'least': -0.2, 'restitution': 0.4}"), 1.5, 60, 1e-7);
    /* impacts at 0.5, 1 and 1.25 s, but for rounding, where pieces end */
    for (int f = 0; f < 2; f++)
        agree_by(f ? "cvode" : "auto", parse("{'linkwright': 1, 'links': ['ground', {'name': 'b', 'mass': 1, 'centre': [0, 0], 'inertia': 1}], 'joints':"
                 "[{'name': 'S', 'kind': 't', 'links': ['ground', 'b'], 'at': [0, 0], 'along': [0, 1], 'stop': {'least': -1.22625, 'restitution': 0.5}}],"
                 "'input': {'joint': 'S', 'speed': 0}, 'gravity': [0, -9.81]}"), 1.4, 28, 1e-7);
}

/* Captured contacts overlap a little at the end of a piece; the next one goes on from there. */
TEST(pieces_of_captured_contacts)
{
    agree_by("capture", load("examples/dynamics/boxes.json"), 0.6, 12, 3e-3);
}

/* A block on an incline sticks by friction, piece after piece, and slides when it is pushed. */
TEST(a_block_sticks)
{
    static const char block[] =
        "{'linkwright': 1, 'units': {'length': 'm'}, 'links': ['ground', {'name': 'block', 'mass': 1, 'centre': [0, 0],"
        "'inertia': 1}], 'joints': [{'name': 'S', 'kind': 't', 'links': ['ground', 'block'], 'at': [0, 0], 'along': [0.8, 0.6],"
        "'friction': {'coefficient': 0.9}}], 'input': {'joint': 'S', 'speed': 0}, 'gravity': [0, -9.81]}";
    lw_simulation_options o = lw_simulation_options_default();
    lw_stepper *steps = NULL;
    lw_error e = { LW_OK, "", 0, 0, "" };
    model = parse(block);
    o.from = 5;                               /* behind the end of a run that the options would have */
    CHECK_INT(lw_stepper_create(model, &o, &steps, &e), LW_OK);
    for (int k = 1; steps && k <= 10; k++)
        CHECK_INT(lw_stepper_advance(steps, 5 + 0.1*k, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    if (steps) {
        CHECK(lw_stepper_sample(steps)->link[1].place.x == 0);
        /* down the incline: 10 N, against 0.9*0.8*9.81 less 0.6*9.81 of gravity */
        CHECK_INT(lw_stepper_set_load(steps, 1, (lw_link_load){ .force = { -8, -6 } }), LW_OK);
        CHECK_INT(lw_stepper_advance(steps, 7, &e), LW_OK);
        CHECK_NEAR(hypot(lw_stepper_sample(steps)->link[1].place.x, lw_stepper_sample(steps)->link[1].place.y),
                   0.5*(10 - 9.81*(0.72 - 0.6)), 1e-9, 0);
    }
    lw_stepper_destroy(steps);
    lw_model_destroy(model);
}

/* Loads and states change at 0.2 and 0.4 s: against the same as expressions of time. */
TEST(changes_act)
{
    static const char same[] =
        "{'linkwright': 1, 'links': ['ground', {'name': 'arm', 'mass': 2, 'centre': [0.3, 0], 'inertia': 0.02}],'joints': [{'name': 'A', 'links': "
        "['ground', 'arm'], 'at': [0, 0]}], 'input': {'joint': 'A', 'speed': 0},'gravity': [0, -9.81], 'motors': [{'name': 'M', 'joint': 'A','voltage': "
        "'5 + 3*(1 + sign(t - 0.4))/2', 'resistance': 0.8, 'inductance': 1e-3, 'torque_constant': 0.05,'inertia': 1e-4, 'ratio': 20}], 'forces': "
        "[{'link': 'arm', 'at': [0.3, 0], 'fy': '-4*(1 + sign(t - 0.2))/2','torque': '2*(1 + sign(t - 0.2))/2'}]}";
    lw_simulation_options o = lw_simulation_options_default();
    lw_stepper *steps[2] = { NULL, NULL };
    lw_model *m[2] = { motor_model(""), parse(same) };
    lw_error e = { LW_OK, "", 0, 0, "" };
    for (int k = 0; k < 2; k++) {
        CHECK_INT(lw_stepper_create(m[k], &o, &steps[k], &e), LW_OK);
        CHECK_INT(lw_stepper_advance(steps[k], 0.2, &e), LW_OK);
        if (k == 0)
            CHECK_INT(lw_stepper_set_load(steps[k], 1, (lw_link_load){ { 0, -4 }, 2 }), LW_OK);
        CHECK_INT(lw_stepper_advance(steps[k], 0.4, &e), LW_OK);
        if (k == 0)
            CHECK_INT(lw_stepper_set_state(steps[k], lw_model_find_state(m[k], "u"), 8), LW_OK);
        CHECK_INT(lw_stepper_advance(steps[k], 0.7, &e), LW_OK);
    }
    CHECK_TEXT(e.text, "");
    CHECK_NEAR(lw_stepper_sample(steps[0])->link[1].angle, lw_stepper_sample(steps[1])->link[1].angle, 1e-8, 0);
    CHECK_NEAR(lw_stepper_sample(steps[0])->work, lw_stepper_sample(steps[1])->work, 1e-7, 0);
    /* the sample of now has the load of now */
    double before = lw_stepper_sample(steps[0])->acceleration[1].angular;
    CHECK_INT(lw_stepper_set_load(steps[0], 1, (lw_link_load){ { 0, -4 }, 2 + 0.26 }), LW_OK);
    CHECK_INT(lw_stepper_advance(steps[0], 0.7, &e), LW_OK);
    CHECK_NEAR(lw_stepper_sample(steps[0])->acceleration[1].angular - before, 0.26/(0.02 + 2*0.09 + 400e-4*1), 1e-9, 0);
    CHECK_INT(lw_stepper_set_load(steps[0], 2, (lw_link_load){ { 0, 0 }, 0 }), LW_E_ARG);
    CHECK_INT(lw_stepper_set_load(steps[0], 1, (lw_link_load){ { 0, NAN }, 0 }), LW_E_ARG);
    CHECK_INT(lw_stepper_set_state(steps[0], 9, 0), LW_E_ARG);
    CHECK_INT(lw_stepper_advance(steps[0], NAN, &e), LW_E_ARG);
    for (int k = 0; k < 2; k++) {
        lw_stepper_destroy(steps[k]);
        lw_model_destroy(m[k]);
    }
}

static void go(lw_stepper *s, int from, int to, last *l)
{
    lw_error e = { LW_OK, "", 0, 0, "" };
    for (int k = from; k < to; k++) {
        if (k == 13)
            lw_stepper_set_load(s, 1, (lw_link_load){ { 0, 3 }, 0 });
        if (k == 25)
            lw_stepper_set_state(s, 0, -2);
        CHECK_INT(lw_stepper_advance(s, 0.05*(k + 1), &e), LW_OK);
    }
    keep(l, model, lw_stepper_sample(s));
}

TEST(restored_runs_have_the_same_bits)
{
    lw_simulation_options o = lw_simulation_options_default();
    lw_error e = { LW_OK, "", 0, 0, "" };
    model = motor_model(", 'stop': {'least': -0.2, 'restitution': 0.4}");
    for (int at = 3; at < 35; at += 8) {
        lw_stepper *a = NULL, *b = NULL;
        char *bytes = NULL;
        size_t size;
        last x, y;
        memset(&x, 0, sizeof x);
        memset(&y, 0, sizeof y);
        CHECK_INT(lw_stepper_create(model, &o, &a, &e), LW_OK);
        CHECK_INT(lw_stepper_create(model, &o, &b, &e), LW_OK);
        go(a, 0, at, &x);
        CHECK_INT(lw_stepper_save(a, &bytes, &size), LW_OK);
        go(a, at, 40, &x);
        CHECK_INT(lw_stepper_restore(b, bytes, size, &e), LW_OK);
        CHECK(lw_stepper_sample(b)->t == 0.05*at);
        go(b, at, 40, &y);
        CHECK(memcmp(&x, &y, sizeof x) == 0);
        CHECK_INT(lw_stepper_restore(a, bytes, size, &e), LW_OK);           /* back in time */
        go(a, at, 40, &y);
        CHECK(memcmp(&x, &y, sizeof x) == 0);
        CHECK_INT(lw_stepper_restore(a, bytes, size - 1, &e), LW_E_NOTATION);
        CHECK_INT(lw_stepper_restore(a, bytes, 5, &e), LW_E_NOTATION);
        for (size_t i = 0; i < size; i++) {                                  /* any byte that is damaged */
            bytes[i] ^= 1;
            CHECK_INT(lw_stepper_restore(a, bytes, size, &e), LW_E_NOTATION);
            bytes[i] ^= 1;
        }
        lw_model *other = motor_model("");
        lw_stepper *c = NULL;
        CHECK_INT(lw_stepper_create(other, &o, &c, &e), LW_OK);
        CHECK_INT(lw_stepper_restore(c, bytes, size, &e), LW_E_NOTATION);
        lw_free(bytes);
        lw_stepper_destroy(a);
        lw_stepper_destroy(b);
        lw_stepper_destroy(c);
        lw_model_destroy(other);
    }
    o.analysis = "static";
    lw_stepper *s = NULL;
    CHECK_INT(lw_stepper_create(model, &o, &s, &e), LW_E_KIND);
    CHECK(s == NULL);
    lw_model_destroy(model);
}

/* With contacts, too: a rope that is taut, goes slack and is taut again, Newton's cradle, boxes that fall on each other. */
TEST(restored_contacts_have_the_same_bits)
{
    static const char *const path[] = { "examples/dynamics/rope.json", "examples/dynamics/newtons-cradle.json", "examples/dynamics/boxes.json" };
    lw_simulation_options o = lw_simulation_options_default();
    lw_error e = { LW_OK, "", 0, 0, "" };
    o.tolerance = 1e-8;
    for (int k = 0; k < 3; k++) {
        lw_stepper *a = NULL, *b = NULL;
        model = load(path[k]);
        CHECK_INT(lw_stepper_create(model, &o, &a, &e), LW_OK);
        CHECK_INT(lw_stepper_create(model, &o, &b, &e), LW_OK);
        for (int at = 0; at < 40; at++) {
            char *bytes = NULL;
            size_t size;
            last x, y;
            memset(&x, 0, sizeof x);
            memset(&y, 0, sizeof y);
            CHECK_INT(lw_stepper_save(a, &bytes, &size), LW_OK);
            CHECK_INT(lw_stepper_restore(b, bytes, size, &e), LW_OK);
            CHECK_INT(lw_stepper_advance(a, 0.025*(at + 1), &e), LW_OK);
            CHECK_INT(lw_stepper_advance(b, 0.025*(at + 1), &e), LW_OK);
            keep(&x, model, lw_stepper_sample(a));
            keep(&y, model, lw_stepper_sample(b));
            CHECK(memcmp(&x, &y, sizeof x) == 0);
            lw_free(bytes);
        }
        lw_stepper_destroy(a);
        lw_stepper_destroy(b);
        lw_model_destroy(model);
    }
}

/* A coarser run beside the stepper, under the same loads, tells the error of contacts: against a run at 1e-12, which has none beside it. */
TEST(errors_of_contacts_are_told)
{
    static const struct { const char *path, *formulation; double tolerance; int pieces; } run[] = {
        { "examples/dynamics/rope.json", "capture", 1e-8, 20 }, { "examples/dynamics/rope.json", "capture", 1e-6, 200 },
        { "examples/dynamics/rope.json", "capture", 1e-6, 3000 },            /* a piece is shorter than a step */
        { "examples/dynamics/rope.json", "index1", 1e-8, 20 }, { "examples/dynamics/newtons-cradle.json", "auto", 1e-8, 20 } };
    lw_error e = { LW_OK, "", 0, 0, "" };
    for (size_t i = 0; i < sizeof run/sizeof *run; i++) {
        lw_simulation_options fine = lw_simulation_options_default(), o = fine;
        lw_simulation_report r[2];
        lw_stepper *steps[2] = { NULL, NULL };
        last l[2];
        fine.once = true;
        fine.tolerance = 1e-12;
        o.formulation = run[i].formulation;
        o.tolerance = run[i].tolerance;
        model = load(run[i].path);
        for (int k = 0; k < 2; k++) {
            CHECK_INT(lw_stepper_create(model, k ? &o : &fine, &steps[k], &e), LW_OK);
            for (int n = 1; n <= run[i].pieces; n++) {
                if (n == run[i].pieces/2)
                    CHECK_INT(lw_stepper_set_load(steps[k], 1, (lw_link_load){ { 1, 2 }, 0 }), LW_OK);
                CHECK_INT(lw_stepper_advance(steps[k], 1.0*n/run[i].pieces, &e), LW_OK);
            }
            CHECK_TEXT(e.text, "");
            keep(&l[k], model, lw_stepper_sample(steps[k]));
            lw_stepper_report(steps[k], &r[k]);
        }
        lw_vec2 a = l[0].link[1].place, b = l[1].link[1].place;
        double off = hypot(a.x - b.x, a.y - b.y);
        CHECK(r[0].coarse_tolerance == 0 && r[1].coarse_tolerance > o.tolerance);
        CHECK(off < 3*r[1].place_off + 1e-9);
        /* saved and restored, it goes on with the same numbers */
        lw_stepper *again = NULL;
        char *bytes = NULL;
        size_t size;
        CHECK_INT(lw_stepper_save(steps[1], &bytes, &size), LW_OK);
        CHECK_INT(lw_stepper_create(model, &o, &again, &e), LW_OK);
        CHECK_INT(lw_stepper_restore(again, bytes, size, &e), LW_OK);
        for (int k = 0; k < 2; k++) {
            CHECK_INT(lw_stepper_advance(k ? again : steps[1], 1.2, &e), LW_OK);
            lw_stepper_report(k ? again : steps[1], &r[k]);
        }
        CHECK(r[0].place_off == r[1].place_off && r[0].turn_off == r[1].turn_off);
        lw_free(bytes);
        lw_stepper_destroy(again);
        lw_stepper_destroy(steps[0]);
        lw_stepper_destroy(steps[1]);
        lw_model_destroy(model);
    }
}

/* ---- in space ------------------------------------------------------------------------------------------------ */

typedef struct last_in_space { lw_frame_motion link[160]; lw_spatial_reaction joint[40]; double work, energy; } last_in_space;

static lw_spatial *space;

static lw_status keep_in_space(void *context, const lw_spatial_sample *s)
{
    last_in_space *l = context;
    memset(l, 0, sizeof *l);
    memcpy(l->link, s->link, (size_t)lw_spatial_count(space, 'l')*sizeof *l->link);
    memcpy(l->joint, s->joint, (size_t)lw_spatial_count(space, 'j')*sizeof *l->joint);
    l->work = s->work;
    l->energy = s->kinetic + s->potential;
    return LW_OK;
}

static double apart(lw_vec3 a, lw_vec3 b) { return fmax(fabs(a.x - b.x), fmax(fabs(a.y - b.y), fabs(a.z - b.z))); }

static void agree_in_space(const char *path, double end, int pieces, double off)
{
    lw_simulation_options o = lw_simulation_options_default();
    lw_stepper *steps = NULL;
    lw_error e = { LW_OK, "", 0, 0, "" };
    last_in_space one, many;
    space = load_in_space(path);
    o.to = end;
    CHECK_INT(lw_spatial_simulate(space, &o, keep_in_space, &one, NULL, &e), LW_OK);
    CHECK_INT(lw_spatial_stepper_create(space, &o, &steps, &e), LW_OK);
    for (int k = 1; steps && k <= pieces; k++)
        CHECK_INT(lw_stepper_advance(steps, end*k/pieces, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    if (steps) {
        keep_in_space(&many, lw_spatial_stepper_sample(steps));
        for (int i = 0; i < lw_spatial_count(space, 'l'); i++) {
            CHECK_NEAR(apart(many.link[i].place, one.link[i].place), 0, off, 0);
            CHECK_NEAR(apart(many.link[i].omega, one.link[i].omega), 0, 1000*off, 0);
        }
        CHECK(lw_stepper_sample(steps) == NULL);
        CHECK_INT(lw_stepper_set_load(steps, 1, (lw_link_load){ { 0, 0 }, 1 }), LW_E_ARG);
        CHECK_INT(lw_spatial_stepper_set_load(steps, 99, (lw_frame_load){ { 0, 0, 0 }, { 0, 0, 1 } }), LW_E_ARG);
        CHECK_INT(lw_spatial_stepper_set_load(steps, 1, (lw_frame_load){ { 0, 0, NAN }, { 0, 0, 1 } }), LW_E_ARG);
        CHECK_INT(lw_stepper_set_state(steps, 0, 1), LW_E_ARG);
    }
    lw_stepper_destroy(steps);
    lw_spatial_destroy(space);
}

TEST(pieces_make_the_whole_in_space)
{
    agree_in_space("examples/space/top.json", 0.5, 20, 1e-8);
    agree_in_space("examples/space/governor.json", 1, 20, 1e-7);
    agree_in_space("examples/space/bennett.json", 0.5, 10, 1e-7);          /* redundant rows */
    agree_in_space("examples/space/slider-crank.json", 0.2, 10, 1e-7);
    agree_in_space("examples/space/delta.json", 0.1, 10, 1e-7);            /* every freedom is driven */
    agree_in_space("examples/space/delta-elastic.json", 0.003, 2, 1e-6);
}

/* A free body and a swing: loads against the same as "forces" of time, and against the closed form. */
static const char body[] =
    "{'linkwright': 1, 'links': ['ground', {'name': 'arm', 'mass': 2, 'centre': [0.3, 0, 0], 'inertia': [0.01, 0.04, 0.05]}],"
    "'joints': [{'name': 'A', 'kind': '%s', 'links': ['ground', 'arm'], 'at': [0, 0, 0]%s}], 'gravity': [0, 0, -9.81]%s}";

static lw_spatial *arm_in_space(const char *kind, const char *axis, const char *forces)
{
    char text[2000];
    snprintf(text, sizeof text, body, kind, axis, forces);
    return parse_in_space(text);
}

TEST(loads_act_in_space)
{
    static const char same[] = ", 'forces': [{'link': 'arm', 'at': [0.3, 0, 0], 'fy': '5*(1 + sign(t - 0.2))/2', "
                               "'fz': '-3*(1 + sign(t - 0.2))/2', 'tx': '0.5*(1 + sign(t - 0.2))/2'}]";
    lw_simulation_options o = lw_simulation_options_default();
    lw_error e = { LW_OK, "", 0, 0, "" };
    last_in_space one, many;
    lw_stepper *steps = NULL;
    o.to = 0.7;
    space = arm_in_space("spherical", "", same);
    CHECK_INT(lw_spatial_simulate(space, &o, keep_in_space, &one, NULL, &e), LW_OK);
    lw_spatial_destroy(space);
    space = arm_in_space("spherical", "", "");
    CHECK_INT(lw_spatial_stepper_create(space, &o, &steps, &e), LW_OK);
    CHECK_INT(lw_stepper_advance(steps, 0.2, &e), LW_OK);
    CHECK_INT(lw_spatial_stepper_set_load(steps, 1, (lw_frame_load){ { 0, 5, -3 }, { 0.5, 0, 0 } }), LW_OK);
    CHECK_INT(lw_stepper_advance(steps, 0.7, &e), LW_OK);
    CHECK_TEXT(e.text, "");
    keep_in_space(&many, lw_spatial_stepper_sample(steps));
    CHECK_NEAR(apart(many.link[1].place, one.link[1].place), 0, 1e-8, 0);
    CHECK_NEAR(apart(many.link[1].omega, one.link[1].omega), 0, 1e-7, 0);
    CHECK_NEAR(many.work, one.work, 1e-7, 0);
    CHECK_NEAR(many.energy - many.work, 0, 1e-7, 0);
    CHECK(fabs(many.work) > 0.1);
    /* the sample of now has the load of now */
    lw_vec3 before = many.link[1].alpha;
    CHECK_INT(lw_spatial_stepper_set_load(steps, 1, (lw_frame_load){ { 0, 0, 0 }, { 0, 0, 0 } }), LW_OK);
    CHECK_INT(lw_stepper_advance(steps, 0.7, &e), LW_OK);
    CHECK(lw_spatial_stepper_sample(steps)->t == 0.7);
    CHECK(apart(lw_spatial_stepper_sample(steps)->link[1].alpha, before) > 0.1);
    lw_stepper_destroy(steps);
    lw_spatial_destroy(space);
    /* about an upright hinge: angle = M t^2/(2 J), many turns, J = 0.05 + 2*0.09 */
    space = arm_in_space("revolute", ", 'axis': [0, 0, 1]", ", 'inputs': [{'joint': 'A', 'speed': 0}]");
    CHECK_INT(lw_spatial_stepper_create(space, &o, &steps, &e), LW_OK);
    CHECK_INT(lw_spatial_stepper_set_load(steps, 1, (lw_frame_load){ { 0, 0, 0 }, { 0, 0, 3 } }), LW_OK);
    for (int k = 1; k <= 40; k++)
        CHECK_INT(lw_stepper_advance(steps, 0.05*k, &e), LW_OK);
    CHECK_NEAR(lw_spatial_stepper_sample(steps)->input[0], 3*4/(2*0.23), 0, 1e-9);
    CHECK_NEAR(lw_spatial_stepper_sample(steps)->work, 3*3*4/(2*0.23), 0, 1e-8);
    CHECK_TEXT(e.text, "");
    lw_stepper_destroy(steps);
    lw_spatial_destroy(space);
}

static void go_in_space(lw_stepper *s, int from, int to, double step, last_in_space *l)
{
    lw_error e = { LW_OK, "", 0, 0, "" };
    for (int k = from; k < to; k++) {
        if (k == 5)
            CHECK_INT(lw_spatial_stepper_set_load(s, 1, (lw_frame_load){ { 0.2, 0, 0.1 }, { 0, 0.05, 0 } }), LW_OK);
        CHECK_INT(lw_stepper_advance(s, step*(k + 1), &e), LW_OK);
    }
    CHECK_TEXT(e.text, "");
    keep_in_space(l, lw_spatial_stepper_sample(s));
}

TEST(restored_runs_in_space_have_the_same_bits)
{
    static const struct { const char *path; double step; int pieces; } run[] = {
        { "examples/space/governor.json", 0.1, 12 }, { "examples/space/bennett.json", 0.1, 12 },
        { "examples/space/delta-elastic.json", 0.0003, 8 }, { NULL, 0.2, 12 } };
    lw_simulation_options o = lw_simulation_options_default();
    lw_error e = { LW_OK, "", 0, 0, "" };
    for (int i = 0; i < 4; i++) {
        lw_stepper *a = NULL, *b = NULL, *c = NULL;
        char *bytes = NULL;
        size_t size;
        last_in_space x, y;
        /* turns that count: a spring about a hinge that turns several times */
        space = run[i].path ? load_in_space(run[i].path) : arm_in_space("revolute", ", 'axis': [0, 0, 1]",
                ", 'springs': [{'joint': 'A', 'stiffness': 0.05}], 'inputs': [{'joint': 'A', 'speed': 20}]");
        CHECK_INT(lw_spatial_stepper_create(space, &o, &a, &e), LW_OK);
        CHECK_INT(lw_spatial_stepper_create(space, &o, &b, &e), LW_OK);
        go_in_space(a, 0, 7, run[i].step, &x);
        CHECK_INT(lw_stepper_save(a, &bytes, &size), LW_OK);
        go_in_space(a, 7, run[i].pieces, run[i].step, &x);
        CHECK_INT(lw_stepper_restore(b, bytes, size, &e), LW_OK);
        go_in_space(b, 7, run[i].pieces, run[i].step, &y);
        CHECK(memcmp(&x, &y, sizeof x) == 0);
        CHECK_INT(lw_stepper_restore(a, bytes, size, &e), LW_OK);           /* back in time */
        go_in_space(a, 7, run[i].pieces, run[i].step, &y);
        CHECK(memcmp(&x, &y, sizeof x) == 0);
        CHECK_INT(lw_stepper_restore(a, bytes, size - 1, &e), LW_E_NOTATION);
        lw_spatial *other = load_in_space("examples/space/top.json");
        CHECK_INT(lw_spatial_stepper_create(other, &o, &c, &e), LW_OK);
        CHECK_INT(lw_stepper_restore(c, bytes, size, &e), LW_E_NOTATION);
        lw_free(bytes);
        lw_stepper_destroy(a);
        lw_stepper_destroy(b);
        lw_stepper_destroy(c);
        lw_spatial_destroy(other);
        lw_spatial_destroy(space);
    }
}
